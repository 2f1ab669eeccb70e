"""Notebook 11 and the library are two routes to one answer."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.sparse.csgraph import minimum_spanning_tree
from scipy.spatial import cKDTree

from checkout import ROOT
from fieldcheck.questions.q11_point_clouds import (
    OUTWARD,
    any_sign,
    horseshoe,
    orient_inputs,
    outward,
    oval,
    torus,
)
from fieldcheck.questions.q11_zero_levels import about, body
from fieldgrade.authoring.sources import Source
from fieldrecon.kernels.conditionally_positive_definite import polyharmonic
from fieldrecon.methods.functionals import derivatives_at, values_at
from fieldrecon.methods.hermite import HermiteRBF
from fieldrecon.methods.rbf import RBF
from fieldrecon.surfaces.normal_orientation import orient_normals
from fieldrecon.surfaces.normals import estimate_normals

NOTEBOOK = Source(ROOT / "solutions/11_surfaces_from_points.py").functions()


@pytest.fixture
def random():
    return np.random.default_rng(1111)


@pytest.fixture
def body_of_points(random):
    """Points of a torus, their outward normals, and the coefficients that the notebook finds."""
    points = torus(random, 9, 20)
    n = outward(points)
    sites, values = NOTEBOOK["augmented"](points, n, NOTEBOOK["off_surface"](points, n, 0.2))
    return points, n, sites, values, *NOTEBOOK["implicit"](sites, values)


def sphere(random, n):
    x = random.normal(size=(n, 3))
    return x / np.linalg.norm(x, axis=1)[:, None]


def test_normals_are_those_of_the_library(random):
    """Up to the sign, and the planarity; near the origin and far from it."""
    for points in (torus(random, 8, 14), 1e5 + sphere(random, 80), random.normal(size=(30, 3))):
        n, planarity = NOTEBOOK["normals"](points, 9)
        theirs = estimate_normals(points, neighbors=9)
        np.testing.assert_allclose(np.abs((n * theirs.vectors).sum(axis=1)), 1, atol=1e-8)
        np.testing.assert_allclose(planarity, theirs.planarity, atol=1e-6)


def test_links_are_those_of_a_tree_of_points(random):
    """The nearest by another search, either way."""
    points = random.normal(size=(60, 3))
    nearest = cKDTree(points).query(points, 6)[1][:, 1:]
    graph = np.zeros((60, 60))
    graph[np.arange(60)[:, None], nearest] = 1
    np.testing.assert_array_equal(NOTEBOOK["linked"](points, 6), np.maximum(graph, graph.T))


def test_signs_are_those_of_the_library_on_bodies(random):
    """Outward on a sphere and on a torus, by another rule for the outside."""
    for points in (sphere(random, 150), torus(random, 9, 18)):
        estimate = estimate_normals(points, neighbors=9)
        given = any_sign(random, estimate.vectors)
        mine = NOTEBOOK["orient"](points, given, NOTEBOOK["linked"](points, 9))
        np.testing.assert_array_equal(mine, orient_normals(points, given, estimate.neighbors))


def test_signs_go_along_the_minimum_spanning_tree(random):
    """Every link of the tree that SciPy finds joins normals that agree."""
    points = torus(random, 9, 18)
    given = any_sign(random, outward(points))
    graph = NOTEBOOK["linked"](points, 7)
    n = NOTEBOOK["orient"](points, given, graph)
    # a cost of zero would be no link to SciPy
    i, j = minimum_spanning_tree(graph * (2 - np.abs(given @ given.T))).nonzero()
    assert len(i) == len(points) - 1
    assert ((n[i] * n[j]).sum(axis=1) > 0).all()


def test_every_student_gets_clouds_that_can_be_oriented():
    """The tree leads to the outward normals whatever the seed, as the law of 11.3 promises."""
    for seed in range(30):
        for call in orient_inputs(seed):
            n = NOTEBOOK["orient"](*call.arguments)
            assert ((n * OUTWARD[call.case](call.arguments[0])).sum(axis=1) > 0).all()


def test_points_beside_pass_the_test_of_carr(random):
    """Each is nearest to its own site, by another search, and twice as far would not be."""
    points = horseshoe(random, 60)
    lengths = NOTEBOOK["off_surface"](points, outward(points), 1.0)
    tree, own = cKDTree(points), np.arange(60)
    for sign, length in zip((1, -1), lengths.T, strict=True):
        beside = sign * length[:, None] * outward(points)
        assert (tree.query(points + beside)[1] == own).all()
        assert (tree.query(points + 2 * beside)[1] != own)[length < 1].all()
    assert lengths.min() < 0.5 < lengths.max()


def test_the_function_is_the_interpolant_of_the_library(random, body_of_points):
    """The same values and gradients from the kernel r³ with a linear function."""
    _, _, sites, values, lam, c = body_of_points
    s = RBF(sites, polyharmonic(3), degree=1).field(values)
    x = random.uniform(-1.3, 1.3, (80, 3))
    f, gradient = NOTEBOOK["field"](x, sites, lam, c)
    np.testing.assert_allclose(f, s(x), atol=1e-7)
    np.testing.assert_allclose(gradient, s.gradient(x), atol=1e-6)


def test_gradients_on_the_level_are_the_normals(random, body_of_points):
    """Newton leads onto the level, the level is near the torus, and its slope points outward."""
    points, n, sites, _, lam, c = body_of_points
    start = points + random.uniform(-0.1, 0.1, (len(points), 1)) * n
    x = NOTEBOOK["to_surface"](start, sites, lam, c, 5)
    f, gradient = NOTEBOOK["field"](x, sites, lam, c)
    terms = np.linalg.norm(x[:, None] - sites, axis=2) ** 3 @ np.abs(lam)
    assert (np.abs(f) < 1e-14 * terms).all()  # what rounding leaves of their sum
    normal = -gradient / np.linalg.norm(gradient, axis=1)[:, None]
    assert ((normal * outward(x)).sum(axis=1) > 0.95).all()


def test_normals_as_data_lead_to_nearly_the_same_curve(random):
    """Without points beside: values and derivatives by the library, as the notebook proposes."""
    points = oval(random, 40)
    n = points / [1.44, 0.64]
    n /= np.linalg.norm(n, axis=1)[:, None]
    sites, values = NOTEBOOK["augmented"](points, n, NOTEBOOK["off_surface"](points, n, 0.1))
    lam, c = NOTEBOOK["implicit"](sites, values)
    data = np.concatenate([np.zeros(40), -np.ones(40)])
    hermite = HermiteRBF([values_at(points), derivatives_at(points, n)], polyharmonic(3))
    x = NOTEBOOK["to_surface"](oval(random, 90), sites, lam, c, 6)
    assert np.abs(hermite.field(data)(x)).max() < 5e-3


def test_newton_converges_quadratically(random):
    """What is left after a step is about the square of what was before."""
    for d in (2, 3):
        x, coefficients = about(random, 20, d), body(random, d, 5)
        left = [
            np.abs(NOTEBOOK["field"](NOTEBOOK["to_surface"](x, *coefficients, k), *coefficients)[0])
            for k in range(4)
        ]
        for before, after in pairwise(left):
            assert (after <= 2 * before**2 + 1e-14).all()


def test_pieces_close_to_a_circle_round_the_positive_part():
    """Each piece begins where another ends, and together they run to the left round the body."""
    side = np.linspace(-1.5, 1.5, 32)
    x, y = np.meshgrid(side, side)
    f = 1 - np.hypot(x, y)
    around = np.stack([f[:-1, :-1], f[:-1, 1:], f[1:, 1:], f[1:, :-1]], axis=-1)
    crossed = np.abs(np.sign(around).sum(axis=-1)) < 4
    corner = np.stack([x[:-1, :-1], y[:-1, :-1]], axis=-1)[crossed][:, None]
    ends = corner + (side[1] - side[0]) * NOTEBOOK["pieces"](around[crossed])
    gaps = np.linalg.norm(ends[:, 1, None] - ends[None, :, 0], axis=2)
    np.testing.assert_allclose(gaps.min(axis=1), 0, atol=1e-12)
    (a, b), (p, q) = ends[:, 0].T, ends[:, 1].T
    area = 0.5 * (a * q - b * p).sum()
    assert area == pytest.approx(np.pi, rel=0.01)
