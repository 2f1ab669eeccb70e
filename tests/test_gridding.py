"""The method that fits is found, and what is a guess is marked."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial import Delaunay

from fieldrecon import LeastSquares, leave_one_out
from fieldrecon.datasets import franke, halton, uniform
from fieldrecon.gridding import CANDIDATES, best_field, cross_validate, grid_over, outside_hull

EXACT = 1e-8


def trials(points, values):
    return [cross_validate(candidate, points, values) for candidate in CANDIDATES.values()]


def winner(points, values):
    return best_field(trials(points, values), points, values, points)[0].candidate.name


def test_each_kind_of_data_has_its_method():
    """A plane, a smooth field and a noisy one are each fitted best by the method made for it."""
    points = uniform(150, 2, seed=0)
    noise = np.random.default_rng(1).standard_normal(150)
    slope = points @ [2.0, 3.0]
    assert winner(points, slope + noise) == "ls1"
    assert winner(points, franke(points)) in {"tps", "cubic", "smooth", "mls2"}
    assert winner(points, franke(points) + 0.1 * noise) in {"smooth", "mls1", "ls4"}


def test_residuals_are_those_of_leaving_one_out():
    """The error told for a method is the library's leave-one-out error, in the data's unit."""
    points = uniform(40, 2, seed=0)
    trial = cross_validate(CANDIDATES["ls2"], points, 1000 * franke(points))
    literal = leave_one_out(LeastSquares(points, 2), 1000 * franke(points))
    assert trial.rms == pytest.approx(np.sqrt(np.mean(literal**2)))
    assert trial.largest == pytest.approx(np.abs(literal).max())


@pytest.mark.parametrize("name", CANDIDATES)
def test_every_candidate_reproduces_a_plane(name):
    """Data of a plane give the plane on the grid, outside of the hull as well."""
    points = uniform(80, 2, seed=2)
    values = 1 + points @ [2.0, 3.0]
    _, _, nodes = grid_over(points, 7, 5)
    trial = cross_validate(CANDIDATES[name], points, values)
    assert trial.reason == ""
    _, field = best_field([trial], points, values, nodes)
    np.testing.assert_allclose(field, 1 + nodes @ [2.0, 3.0], atol=EXACT)


def test_costly_methods_wait_to_be_asked():
    """Global kernels are not tried on thousands of samples unless asked for."""
    points = halton(2001, 2)
    candidate = CANDIDATES["smooth"]
    trial = cross_validate(candidate, points, franke(points))
    assert trial.residuals is None
    assert trial.reason == "not tried on more than 2000 samples unasked"
    assert trial.rms == np.inf
    few = halton(60, 2)
    assert cross_validate(candidate, few, franke(few), asked_for=True).rms < 0.1


def test_methods_that_need_more_samples_say_so():
    """Four samples carry a plane; for higher degrees the reason is told, and the plane is drawn."""
    points = np.array([[0.0, 0.0], [1.0, 0.1], [0.2, 1.0], [0.7, 0.6]])
    tried = {trial.candidate.name: trial for trial in trials(points, points[:, 0])}
    assert "do not determine a polynomial of degree 2" in tried["ls2"].reason
    assert tried["ls1"].reason == ""


def test_no_method_on_a_line():
    """Samples on a straight line leave the field beside it open, and the reason is told."""
    points = np.outer(np.arange(9.0), [1.0, 2.0])
    with pytest.raises(np.linalg.LinAlgError, match="no field from these samples by ls1: the poin"):
        best_field(trials(points, points[:, 0]), points, points[:, 0], points)


def test_a_method_that_fails_on_the_grid_gives_way():
    """The next best field is drawn where the best one does not exist at some query."""
    points = uniform(30, 2, seed=4)
    good = cross_validate(CANDIDATES["ls1"], points, franke(points))
    bad = cross_validate(CANDIDATES["tps"], points, franke(points))
    assert bad.rms < good.rms

    def fails(*_):
        raise np.linalg.LinAlgError("the sites about query 3 do not determine the polynomial")

    object.__setattr__(bad, "candidate", type(bad.candidate)("tps", "RBF", "broken", fails))
    assert best_field([good, bad], points, franke(points), points)[0] is good


@given(
    seed=st.integers(0, 50),
    unit=st.sampled_from([1e-6, 1.0, 1e6]),
    offset=st.sampled_from([0.0, 1e3, -1e6]),
)
def test_outside_is_outside_of_all_triangles(seed, unit, offset):
    """A query is outside the hull if no Delaunay triangle holds it, in any unit, at any place."""
    points, queries = uniform(12, 2, seed), uniform(200, 2, seed + 1000) * 1.4 - 0.2
    outside = Delaunay(points).find_simplex(queries) < 0
    moved = (points + offset) * unit, (queries + offset) * unit
    assert np.array_equal(outside_hull(*moved), outside)


def test_the_samples_themselves_are_not_extrapolated():
    """Corners and edges of the hull count as inside."""
    points = uniform(50, 2, seed=0) * [1e5, 1e-2] + [5e6, 3.0]
    middles = (points + np.roll(points, 1, axis=0)) / 2
    assert not outside_hull(points, points).any()
    assert not outside_hull(points, middles).any()
