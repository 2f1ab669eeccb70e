"""Extrapolation: queries outside the hull or in a gap, in the plane, in space, on the globe."""

import tracemalloc

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial import Delaunay

from fieldrecon._core import chunks as _chunks
from fieldrecon.datasets.synthetic import clustered, uniform
from fieldrecon.methods.globe import to_unit
from fieldrecon.selection.extrapolation import (
    AMONG,
    GAP,
    OUTSIDE,
    _in_gap,
    extrapolated,
    outside_hull,
)


@pytest.mark.slow
@given(
    d=st.integers(2, 3),
    seed=st.integers(0, 50),
    unit=st.sampled_from([1e-6, 1.0, 1e6]),
    offset=st.sampled_from([0.0, 1e3, -1e6]),
)
def test_outside_the_hull_means_outside_every_delaunay_simplex(d, seed, unit, offset):
    """The statement holds for any unit of length and any origin."""
    points, queries = uniform(12, d, seed), uniform(200, d, seed + 1000) * 1.4 - 0.2
    outside = Delaunay(points).find_simplex(queries) < 0
    moved = (points + offset) * unit, (queries + offset) * unit
    assert np.array_equal(outside_hull(*moved), outside)


def test_samples_are_not_extrapolated():
    """Points on the corners and edges of the hull count as inside."""
    points = uniform(50, 2, seed=0) * [1e5, 1e-2] + [5e6, 3.0]
    middles = (points + np.roll(points, 1, axis=0)) / 2
    assert not outside_hull(points, points).any()
    assert not outside_hull(points, middles).any()
    assert (extrapolated(points, points) == AMONG).all()


def test_the_memory_of_a_hull_does_not_grow_with_the_queries(monkeypatch):
    """It is less than a quarter of one number for each query and each of a thousand facets."""
    monkeypatch.setattr(_chunks, "CHUNK_BYTES", 2**16)
    points = np.random.default_rng(0).standard_normal((500, 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    queries = 2 * uniform(4000, 3, seed=1)
    tracemalloc.start()
    outside = outside_hull(points, queries)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert outside.any()
    assert peak < 0.25 * (4000 * 1000 * queries.itemsize)


def test_a_hull_without_interior_is_refused():
    """Points on a line have no hull with an interior."""
    with pytest.raises(np.linalg.LinAlgError, match="9 points have no hull with an inside"):
        outside_hull(np.outer(np.arange(9.0), [1, 2]), np.zeros((1, 2)))


@pytest.mark.parametrize("d", [2, 3])
def test_a_hole_is_a_gap_and_nothing_else_is(d):
    """Queries well inside a hole are in a gap; queries among the samples around it are not."""
    points = uniform(20_000, d, seed=0) - 0.5
    points = points[np.linalg.norm(points, axis=1) > 0.25]
    queries = uniform(20_000, d, seed=1) - 0.5
    distance = np.linalg.norm(queries, axis=1)
    flags = extrapolated(points, queries)
    spacing = len(points) ** (-1 / d)
    assert (flags[distance < 0.25 - 4 * spacing] == GAP).all()
    beyond = flags[distance > 0.25]
    assert (beyond != GAP).all()
    assert np.mean(beyond == OUTSIDE) < 0.2


def test_varying_density_is_not_a_gap():
    """The size of a gap is relative to the local spacing of the samples."""
    points = clustered(5000, 2, 20, 0.15, seed=0)
    queries = points[:-1] / 2 + points[1:] / 2
    near = points + np.random.default_rng(0).standard_normal(points.shape) * 1e-3
    assert np.mean(extrapolated(points, near) == GAP) < 0.01
    assert np.mean(extrapolated(points, queries) == GAP) < 0.05


@pytest.mark.parametrize(("nearer", "meaning"), [(15, AMONG), (16, GAP)])
def test_a_gap_needs_sixteen_nearer_neighbours_of_the_nearest_sample(nearer, meaning):
    """The query has distance 1.5 from its nearest sample, whose neighbours have distance 1."""
    angle = np.linspace(np.pi / 2, 3 * np.pi / 2, nearer)
    about = np.column_stack([np.cos(angle), np.sin(angle)])
    far = [[50.0, -50.0], [50.0, 50.0]]
    points = np.vstack([np.zeros((1, 2)), about, 2 * about, far])
    assert extrapolated(points, np.array([[1.5, 0.0]])).tolist() == [meaning]


def test_a_query_as_far_as_the_sixteenth_neighbour_is_in_no_gap():
    """Only fifteen are nearer to the nearest sample than the query is."""
    line = np.arange(40.0)[:, None]
    assert _in_gap(line, np.array([[-15.5], [-16.0], [-16.5]])).tolist() == [False, False, True]
    assert not _in_gap(line[:16], np.array([[-99.0]])).any()
    assert _in_gap(line[:17], np.array([[-99.0]])).all()


def test_the_space_between_tracks_is_a_gap():
    """Dense samples along parallel lines do not determine the field between the lines."""
    y, x = np.mgrid[0:5, 0:1:0.001]
    points = np.column_stack([x.ravel(), y.ravel()])
    assert extrapolated(points, np.array([[0.5, 0.5], [0.5, 1.0]])).tolist() == [GAP, AMONG]


@pytest.mark.parametrize("middle", [[0.0, 0.0], [180.0, 10.0], [-100.0, 89.0]])
def test_the_hull_on_the_globe_is_bounded_by_great_circles(middle):
    """A spherical cap around any point, also at the date line or near a pole, is its own hull."""
    rng = np.random.default_rng(0)
    pole = to_unit(middle)
    points = rng.standard_normal((4000, 3))
    points /= np.linalg.norm(points, axis=1)[:, None]
    sites, queries = points[:2000], points[2000:]
    sites = np.vstack([sites, rng.standard_normal((3000, 3)) * 0.2 + pole])
    sites /= np.linalg.norm(sites, axis=1)[:, None]
    cap = sites[sites @ pole > np.cos(0.7)]
    flags = extrapolated(cap, queries, on_globe=True)
    angle = np.arccos(np.clip(queries @ pole, -1, 1))
    assert (flags[angle < 0.5] == AMONG).all()
    assert (flags[angle > 0.7001] == OUTSIDE).all()


def test_nothing_is_outside_a_hull_of_the_whole_globe():
    """Samples in all directions can leave gaps but no outside."""
    rng = np.random.default_rng(0)
    points = rng.standard_normal((3000, 3))
    points /= np.linalg.norm(points, axis=1)[:, None]
    queries = np.roll(points, 1, axis=1)
    assert (extrapolated(points, queries, on_globe=True) == AMONG).all()
    north = points[points[:, 2] < 0.6]
    flags = extrapolated(north, queries, on_globe=True)
    assert (flags[queries[:, 2] > 0.85] == GAP).all()
    assert (flags != OUTSIDE).all()


def test_a_hull_on_the_globe_may_reach_almost_to_a_great_circle():
    """Samples up to 83 degrees from a pole: queries are inside to 82 degrees, and then outside."""

    def ring(degrees, count):
        around = np.linspace(0, 360, count, endpoint=False)
        return to_unit(np.column_stack([around, np.full(count, 90.0 - degrees)]))

    sites = np.vstack([ring(degrees, 400) for degrees in range(3, 84, 10)])
    for degrees, meaning in ((82, AMONG), (84, OUTSIDE), (100, OUTSIDE), (179, OUTSIDE)):
        assert (extrapolated(sites, ring(degrees, 30), on_globe=True) == meaning).all()


def test_up_to_the_validated_distance_a_query_is_among_the_samples():
    """Also outside the hull, and at this distance itself; beyond it the hull decides."""
    points = np.array([[0.0, 0.0], [8.0, 0.0], [8.0, 8.0], [0.0, 8.0]])
    x = np.array([[2.0, 0.0], [2.5, 0.0], [-2.0, 0.0], [-2.5, 0.0], [4.0, 4.0], [9.0, 9.0]])
    flags = extrapolated(points, x, validated=2.0)
    assert flags.tolist() == [AMONG, GAP, AMONG, OUTSIDE, GAP, AMONG]


def test_few_points_have_no_gaps():
    """With three samples no sample has the sixteen neighbours that a gap needs."""
    points = np.array([[0.0, 0], [1, 0], [0, 1]])
    assert extrapolated(points, points[:1] + 0.2).tolist() == [AMONG]
    assert extrapolated(points, np.empty((0, 2))).tolist() == []
