"""The solutions of notebook 11 agree with the library."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.sparse.csgraph import minimum_spanning_tree
from scipy.spatial import cKDTree

from checkout import ROOT
from fieldcheck.datasets import kleopatra
from fieldcheck.questions.q11_orientation import OUTWARD, orient_inputs, random_signs
from fieldcheck.questions.q11_point_clouds import horseshoe, outward, oval, torus
from fieldcheck.questions.q11_zero_levels import body, points_about_origin
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
def torus_surface(random):
    """Points of a torus, their outward normals, and the notebook's coefficients."""
    points = torus(random, 9, 20)
    n = outward(points)
    sites, values = NOTEBOOK["augmented"](points, n, NOTEBOOK["off_surface"](points, n, 0.2))
    return points, n, sites, values, *NOTEBOOK["implicit"](sites, values)


def sphere(random, n):
    x = random.normal(size=(n, 3))
    return x / np.linalg.norm(x, axis=1)[:, None]


def test_normals_and_planarity_agree_with_the_library(random):
    """They agree up to the signs of the normals, near the origin and far from it."""
    for points in (torus(random, 8, 14), 1e5 + sphere(random, 80), random.normal(size=(30, 3))):
        n, planarity = NOTEBOOK["normals"](points, 9)
        theirs = estimate_normals(points, neighbors=9)
        np.testing.assert_allclose(np.abs((n * theirs.vectors).sum(axis=1)), 1, atol=1e-8)
        np.testing.assert_allclose(planarity, theirs.planarity, atol=1e-6)


def test_neighbours_agree_with_a_kd_tree(random):
    """The neighbour graph is symmetrized."""
    points = random.normal(size=(60, 3))
    nearest = cKDTree(points).query(points, 6)[1][:, 1:]
    graph = np.zeros((60, 60))
    graph[np.arange(60)[:, None], nearest] = 1
    np.testing.assert_array_equal(NOTEBOOK["linked"](points, 6), np.maximum(graph, graph.T))


def test_orientations_agree_with_the_library(random):
    """Normals of a sphere and a torus point outward; the library uses another rule for that."""
    for points in (sphere(random, 150), torus(random, 9, 18)):
        estimate = estimate_normals(points, neighbors=9)
        given = random_signs(random, estimate.vectors)
        mine = NOTEBOOK["orient"](points, given, NOTEBOOK["linked"](points, 9))
        np.testing.assert_array_equal(mine, orient_normals(points, given, estimate.neighbors))


def test_orientation_follows_the_minimum_spanning_tree(random):
    """Normals joined by an edge of SciPy's minimum spanning tree agree."""
    points = torus(random, 9, 18)
    given = random_signs(random, outward(points))
    graph = NOTEBOOK["linked"](points, 7)
    n = NOTEBOOK["orient"](points, given, graph)
    # SciPy treats a cost of zero as a missing edge
    i, j = minimum_spanning_tree(graph * (2 - np.abs(given @ given.T))).nonzero()
    assert len(i) == len(points) - 1
    assert ((n[i] * n[j]).sum(axis=1) > 0).all()


@pytest.mark.slow
def test_the_point_clouds_of_every_student_can_be_oriented():
    """For every seed the tree gives the outward normals, as the law of 11.3 requires."""
    for seed in range(30):
        for call in orient_inputs(seed):
            n = NOTEBOOK["orient"](*call.arguments)
            assert ((n * OUTWARD[call.case](call.arguments[0])).sum(axis=1) > 0).all()


def test_off_surface_points_are_nearest_to_their_own_sites(random):
    """The criterion of Carr et al., by another search; at twice the distance it fails."""
    points = horseshoe(random, 60)
    lengths = NOTEBOOK["off_surface"](points, outward(points), 1.0)
    tree, own = cKDTree(points), np.arange(60)
    for sign, length in zip((1, -1), lengths.T, strict=True):
        beside = sign * length[:, None] * outward(points)
        assert (tree.query(points + beside)[1] == own).all()
        assert (tree.query(points + 2 * beside)[1] != own)[length < 1].all()
    assert lengths.min() < 0.5 < lengths.max()


def test_the_implicit_function_agrees_with_the_library(random, torus_surface):
    """Values and gradients of the interpolant with the kernel r³ and a linear polynomial."""
    _, _, sites, values, lam, c = torus_surface
    s = RBF(sites, polyharmonic(3), degree=1).field(values)
    x = random.uniform(-1.3, 1.3, (80, 3))
    f, gradient = NOTEBOOK["field"](x, sites, lam, c)
    np.testing.assert_allclose(f, s(x), atol=1e-7)
    np.testing.assert_allclose(gradient, s.gradient(x), atol=1e-6)


def test_gradients_on_the_zero_level_are_the_normals(random, torus_surface):
    """Newton's method reaches the zero level, and the gradients there point outward."""
    points, n, sites, _, lam, c = torus_surface
    start = points + random.uniform(-0.1, 0.1, (len(points), 1)) * n
    x = NOTEBOOK["to_surface"](start, sites, lam, c, 5)
    f, gradient = NOTEBOOK["field"](x, sites, lam, c)
    terms = np.linalg.norm(x[:, None] - sites, axis=2) ** 3 @ np.abs(lam)
    assert (np.abs(f) < 1e-14 * terms).all()  # the rounding error of the sum
    normal = -gradient / np.linalg.norm(gradient, axis=1)[:, None]
    assert ((normal * outward(x)).sum(axis=1) > 0.95).all()


def test_hermite_data_give_nearly_the_same_curve(random):
    """The library interpolates values and normal derivatives without off-surface points."""
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
    """The residual after a step is at most a multiple of the square of the residual before."""
    for d in (2, 3):
        x, coefficients = points_about_origin(random, 20, d), body(random, d, 5)
        left = [
            np.abs(NOTEBOOK["field"](NOTEBOOK["to_surface"](x, *coefficients, k), *coefficients)[0])
            for k in range(4)
        ]
        for before, after in pairwise(left):
            assert (after <= 2 * before**2 + 1e-14).all()


def test_the_pieces_of_the_zero_level_close_to_a_circle():
    """Each piece begins where another ends, counter-clockwise about the positive part."""
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


def test_the_example_of_a_covariance():
    """The eigenvalues are 6 and 2, and the normal is vertical."""
    example = np.array([[-2.0, 1.0], [1.0, -2.0], [4.0, 1.0]])
    np.testing.assert_allclose(np.cov(example.T, bias=True), np.diag([6, 2]), atol=1e-14)
    n, planarity = NOTEBOOK["normals"](example, 3)
    np.testing.assert_allclose(np.abs(n), np.tile([0, 1], (3, 1)), atol=1e-14)
    np.testing.assert_allclose(planarity, 2 / 3)


def test_the_example_of_a_spanning_tree():
    """The tree of the five points is the chain, and all normals become outward."""
    points, given, graph = (
        NOTEBOOK[name].astype(float) for name in ("FIVE", "FIVE_GIVEN", "FIVE_LINKS")
    )
    cost = np.round(1 - np.abs(given @ given.T), 9)
    np.testing.assert_allclose(np.diag(cost, 1), [0.2, 0.4, 0.2, 0.4])
    np.testing.assert_allclose(np.diag(cost, 2), 1)
    tree = minimum_spanning_tree(graph * (1 + cost)).nonzero()
    assert {tuple(sorted(map(int, e))) for e in zip(*tree, strict=True)} == {
        *pairwise(range(5)),
    }
    np.testing.assert_allclose(NOTEBOOK["orient"](points, given, graph), points / 2)


def test_the_example_of_a_square():
    """The piece runs from (3/4, 0) to (0, 3/5)."""
    ends = NOTEBOOK["pieces"](np.array([[3.0, -1.0, -2.0, -2.0]]))
    np.testing.assert_allclose(ends[0], [[0.75, 0], [0, 0.6]])


def test_long_links_are_in_no_spanning_tree():
    """The cost of each long link exceeds that of all links in the tree."""
    for seed in range(30):
        long = [call for call in orient_inputs(seed) if "long links" in call.case]
        assert len(long) == 2
        for call in long:
            points, given, graph = call.arguments
            truth = OUTWARD[call.case](points)
            i, j = minimum_spanning_tree(graph * (2 - np.abs(given @ given.T))).nonzero()
            assert len(i) == len(points) - 1
            assert ((truth[i] * truth[j]).sum(axis=1) > 0.6).all()
            assert (graph * (truth @ truth.T) < -0.1).sum() > len(points)


def test_the_normals_of_the_asteroid_point_outward():
    """Half of the points suffice; the triangles give the direction to compare with."""
    points, triangles = kleopatra()
    a, b, c = points[triangles].swapaxes(0, 1)
    area = np.zeros_like(points)
    np.add.at(area, triangles, np.cross(b - a, c - a)[:, None])
    some = points[::2]
    n = NOTEBOOK["orient"](some, NOTEBOOK["normals"](some, 8)[0], NOTEBOOK["linked"](some, 8))
    assert ((n * area[::2]).sum(axis=1) > 0).all()
