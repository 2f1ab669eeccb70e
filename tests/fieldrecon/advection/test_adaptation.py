"""Adaptive sites: where points are added and removed, and how much the error decreases."""

import numpy as np
import pytest
from scipy.spatial import ConvexHull, cKDTree

from fieldrecon.advection.adaptation import adapted_points
from fieldrecon.advection.semi_lagrangian_steps import semi_lagrangian
from fieldrecon.datasets.synthetic import halton
from fieldrecon.kernels.conditionally_positive_definite import polyharmonic
from fieldrecon.methods.partition_of_unity.method import PartitionOfUnityRBF
from fieldrecon.selection.leaving_one_out import leave_one_out

RULES = {"refine": 0.5, "coarsen": 0.1, "spacing": 0.01}


def pairs(x: np.ndarray) -> set[tuple[float, ...]]:
    return set(map(tuple, x.tolist()))


@pytest.mark.parametrize("d", [1, 2, 3])
def test_points_are_added_where_the_indicator_is_large(d):
    """A new point is the midpoint of such a point and a neighbour, and respects `spacing`."""
    x = halton(300, d)
    eta = np.where(x[:, 0] > 0.7, 1.0, 0.3)
    spacing = 0.01 if d > 1 else 1e-4
    found = adapted_points(x, eta, **RULES | {"spacing": spacing})
    assert pairs(x) < pairs(found)
    fresh = found[len(x) :]
    assert cKDTree(found).query(found, 2)[0][len(x) :, 1].min() >= spacing * (1 - 1e-9)
    near = cKDTree(x).query(x, 2 * d + 1)[1][:, 1:]
    middle = (x[:, None] + x[near]) / 2
    assert cKDTree(middle[eta > 0.5].reshape(-1, d)).query(fresh)[0].max() < 1e-12


@pytest.mark.parametrize("d", [1, 2, 3])
def test_points_are_removed_where_the_indicator_is_small(d):
    """A point and its nearest neighbour are not both removed; the convex hull does not change."""
    x = halton(300, d)
    eta = np.where(x[:, 0] > 0.5, 0.0, 0.3)
    found = adapted_points(x, eta, **RULES)
    assert pairs(found) < pairs(x)
    removed = np.array([tuple(p) not in pairs(found) for p in x.tolist()])
    assert (x[removed, 0] > 0.5).all()
    first = cKDTree(x).query(x, 2)[1][:, 1]
    assert not (removed & removed[first]).any()
    if d > 1:
        assert ConvexHull(found).volume == pytest.approx(ConvexHull(x).volume, rel=1e-12)
    else:
        assert np.ptp(found) == np.ptp(x)


def test_isolated_points_are_not_removed():
    """Points with a nearest neighbour farther than `widest` stay, even if the indicator is zero."""
    x = halton(300, 2)
    found = adapted_points(x, np.zeros(300), **RULES, widest=0.03)
    nearest = cKDTree(x).query(x, 2)[0][:, 1]
    removed = np.array([tuple(p) not in pairs(found) for p in x.tolist()])
    assert 0 < removed.sum() < 100
    assert nearest[removed].max() <= 0.03
    assert (nearest[~removed] < 0.03).any()


@pytest.mark.parametrize("d", [1, 2, 3])
def test_no_point_is_left_that_could_be_added_or_removed(d):
    """Each is near to one that is there, or to a removed one; the least indicator comes first."""
    x, spacing = halton(200, d), (0.001, 0.02, 0.1)[d - 1]
    eta = np.random.default_rng(0).random(200)
    found = adapted_points(x, eta, refine=0.7, coarsen=0.3, spacing=spacing)
    kept = np.array([tuple(p) in pairs(found) for p in x.tolist()])
    assert np.array_equal(found[: kept.sum()], x[kept])
    near = cKDTree(x).query(x, 2 * d + 1)[1][:, 1:]
    middle = ((x[:, None] + x[near]) / 2)[eta > 0.7].reshape(-1, d)
    assert (cKDTree(np.vstack([x, found])).query(middle)[0] < spacing).all()
    corners = ConvexHull(x).vertices if d > 1 else [x.argmin(), x.argmax()]
    may_go = (eta < 0.3) & ~np.isin(np.arange(200), corners)
    assert not kept[np.where(may_go, eta, 1.0).argmin()]
    for i in np.flatnonzero(may_go):
        beside = {*near[i], *np.flatnonzero((near == i).any(axis=1))}
        assert kept[i] == any(not kept[j] for j in beside)
        assert not kept[i] or any(not kept[j] and eta[j] <= eta[i] for j in beside)


def test_at_the_bounds_of_the_indicator_nothing_changes():
    """Nor with one point; few points have fewer neighbours."""
    x = halton(30, 2)
    found = adapted_points(x, np.full(30, 0.5), refine=0.5, coarsen=0.5, spacing=0.01)
    assert np.array_equal(found, x)
    assert adapted_points([[3.0]], [0.0], **RULES).tolist() == [[3.0]]
    triangle = [[0.0, 0.0], [4.0, 0.0], [0.0, 4.0]]
    found = adapted_points(triangle, np.ones(3), **RULES)
    assert sorted(found[3:].tolist()) == [[0, 2], [2, 0], [2, 2]]
    line = adapted_points([[0.0], [2.0], [6.0]], np.ones(3), **RULES | {"spacing": 1.0})
    assert sorted(line[3:, 0].tolist()) == [1, 3, 4]  # they may be just as near as the spacing


@pytest.mark.slow
def test_adaptive_sites_reduce_the_error_of_a_front():
    """A steep ring is rotated with adaptive sites and with as many fixed sites."""

    def front(x: np.ndarray) -> np.ndarray:
        return np.tanh(30 * (np.linalg.norm(x - [0.5, 0.65], axis=-1) - 0.15))

    def rotation(x: np.ndarray, _: float) -> np.ndarray:
        return (x - 0.5)[:, ::-1] * [-1, 1]

    def method(x):
        return PartitionOfUnityRBF(x, polyharmonic(3), 1)

    def following(state, _):
        eta = np.abs(leave_one_out(state.method, state.values))
        rules = {"refine": 0.02, "coarsen": 0.004, "spacing": 0.012}
        return method(adapted_points(state.method.points, eta, **rules))

    def advected(x, sites):
        *_, state = semi_lagrangian(
            method(x), front(x), rotation, np.linspace(0, 1, 11), sites=sites
        )
        return state

    adapted = advected(halton(800, 2), following)
    fixed = advected(halton(len(adapted.values), 2), None)
    c, s = np.cos(1.0), np.sin(1.0)
    q = 0.2 + 0.6 * halton(3000, 2, seed=3)
    exact = front(0.5 + (q - 0.5) @ np.array([[c, -s], [s, c]]))
    errors = [
        np.sqrt(np.mean((state.method.field(state.values)(q) - exact) ** 2))
        for state in (adapted, fixed)
    ]
    assert errors[0] < 0.6 * errors[1]


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"coarsen": 2.0}, "coarsen be at most refine"),
        ({"spacing": 0.0}, "spacing must be a positive number"),
        ({"indicator": np.ones((9, 1))}, "indicator must hold one number for each point"),
        ({"indicator": np.ones(3)}, "indicator must have one entry for each point"),
    ],
)
def test_invalid_arguments_are_refused(changes, words):
    """The message names the argument."""
    given = {"indicator": np.ones(9), **RULES, **changes}
    with pytest.raises(ValueError, match=words):
        adapted_points(halton(9, 2), given.pop("indicator"), **given)
