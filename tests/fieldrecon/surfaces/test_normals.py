"""Normals of point clouds of known surfaces: accuracy, orientation, and points without a normal."""

from itertools import product

import numpy as np
import pytest
from scipy.sparse import csgraph

from fieldrecon.surfaces import normal_orientation
from fieldrecon.surfaces.normal_orientation import _vote, orient_normals
from fieldrecon.surfaces.normals import estimate_normals, nearest, reach
from laws import assert_close


def sphere(n, seed=1):
    x = np.random.default_rng(seed).standard_normal((n, 3))
    x /= np.linalg.norm(x, axis=1, keepdims=True)
    return x, x


def torus(n, radius=0.4):
    u, v = 2 * np.pi * np.random.default_rng(2).random((2, n))
    normals = np.column_stack([np.cos(u) * np.cos(v), np.sin(u) * np.cos(v), np.sin(v)])
    return np.column_stack([np.cos(u), np.sin(u), 0 * u]) + radius * normals, normals


def box(n, size):
    rng, size = np.random.default_rng(3), np.array(size, dtype=float)
    areas = size.prod() / size
    axis, side = rng.choice(3, n, p=areas / areas.sum()), rng.choice([-1, 1], n)
    x, normals = (rng.random((n, 3)) - 0.5) * size, np.zeros((n, 3))
    normals[np.arange(n), axis] = side
    x[np.arange(n), axis] = side * size[axis] / 2
    return x, normals


def sheet(step, thickness):
    """Two parallel squares of points, one above the other, without lateral faces."""
    t = np.arange(-2, 2 + step / 2, step)
    a, b = (c.ravel() for c in np.meshgrid(t, t))
    points = [np.column_stack([a, b, np.full_like(a, s * thickness / 2)]) for s in (1, -1)]
    normals = [np.tile([0.0, 0.0, s], (len(a), 1)) for s in (1, -1)]
    return np.vstack(points), np.vstack(normals)


def shuffled_signs(normals, seed=5):
    return normals * np.random.default_rng(seed).choice([-1, 1], len(normals))[:, None]


def correctly_oriented(points, true, **options):
    """Fraction of the points whose estimated and oriented normal points to the true side."""
    vectors = shuffled_signs(estimate_normals(points).vectors)
    along = np.einsum("nd,nd->n", orient_normals(points, vectors, **options), true)
    # where the estimate is tangential, as at an edge, no side is correct
    sure = np.abs(along) > 0.5
    return float((along[sure] > 0).mean())


BODIES = {
    "sphere": sphere(2000),
    "torus": torus(3000),
    "cube": box(4000, (1, 1, 1)),
    "plate": box(6000, (2, 2, 0.1)),
}


# --- the normal -----------------------------------------------------------------------------------


def test_a_vote_turns_a_sign_that_its_neighbours_contradict_and_no_other(monkeypatch):
    """In a ring of equal normals none, one or two have the wrong sign; votes may be small."""
    monkeypatch.setattr(normal_orientation, "_MAX_SWEEPS", 1)
    index = (np.arange(12)[:, None] + [1, 2, 3]) % 12
    for wrong, vote in product(([], [5], [2, 7]), (1.0, 0.01, 0.0)):
        sign = np.ones(12)
        sign[wrong] = -1
        before = sign.tolist()
        _vote(sign, np.full((12, 3), vote), index)
        assert sign.tolist() == ([1] * 12 if vote else before)


@pytest.mark.parametrize("d", [2, 3])
def test_the_agreement_of_an_edge_is_that_with_the_mirrored_normal(d):
    """And its steepness the product of its cosines with both normals; edge by edge."""
    rng = np.random.default_rng(2)
    p, n = rng.standard_normal((2, 30, d))
    n /= np.linalg.norm(n, axis=1, keepdims=True)
    p[7] = p[3]  # a point repeated: no direction, so nothing is mirrored
    index = np.column_stack([np.arange(30), rng.integers(0, 30, (30, 4))])
    index[7, 1], index[3, 2] = 3, 7
    agreement, steepness = normal_orientation._edges(p.T, n.T, index)
    for i, k in np.ndindex(index.shape):
        j = index[i, k]
        e = p[j] - p[i]
        e = e / (np.linalg.norm(e) or 1)
        expected = 0 if i == j else (n[i] - 2 * (e @ n[i]) * e) @ n[j]
        assert agreement[i, k] == pytest.approx(expected, abs=1e-14)
        assert steepness[i, k] == pytest.approx(abs((e @ n[i]) * (e @ n[j])), abs=1e-14)


def test_each_part_gets_the_sign_of_its_volume_or_of_the_sum_of_its_normals():
    """With the areas as weights; the largest component of the sum decides without a volume."""
    x, true = BODIES["sphere"]
    x, true = x[:200], true[:200]
    flat = np.column_stack([np.random.default_rng(1).random((200, 2)), np.zeros(200)])
    down, weights = np.tile([0.3, 0.2, -0.9], (200, 1)), np.ones(200)
    for signs in product((1.0, -1.0), repeat=3):
        p = np.vstack([x, 9 + 0.01 * x, flat + 5])
        n = np.vstack([signs[0] * true, signs[1] * true, signs[2] * down])
        part = np.repeat([0, 1, 2], 200)
        mixed = np.random.default_rng(3).permutation(600)
        found = normal_orientation._outward(
            p[mixed], n[mixed], np.tile(weights, 3)[mixed], part[mixed]
        )
        assert found.tolist() == [signs[0], signs[1], -signs[2]]
    two = np.array([[-1.0, 0, 0], [1, 0, 0], [1.1, 0, 0]]), np.array([[1.0, 0, 0]] * 3)
    for areas, sign in (([1, 0.1, 0.1], 1), ([0.1, 1, 1], 1), ([3, 1, 0], 1)):
        turned = two[1] * [[1.0], [-1], [-1]]
        found = normal_orientation._outward(two[0], turned, np.array(areas), np.zeros(3, int))
        assert found.tolist() == [-sign]


def test_normals_of_a_sphere_are_of_first_order():
    """The median angle to the true normal is proportional to the spacing n^(-1/2)."""
    angles = []
    for n in (500, 8000):
        x, true = sphere(n)
        along = np.abs(np.einsum("nd,nd->n", estimate_normals(x).vectors, true))
        angles.append(np.median(np.arccos(np.minimum(along, 1))))
    assert np.log(angles[0] / angles[1]) / np.log(4) == pytest.approx(1, abs=0.25)
    assert np.degrees(angles[1]) < 1


@pytest.mark.parametrize("aspect", [1.0, 1e-3])
def test_normals_of_planes_are_exact_for_elongated_neighbourhoods(aspect):
    """Only the ratio of the two smaller variances matters.

    The strip is 1000 times longer than wide.
    """
    rng = np.random.default_rng(4)
    frame = np.linalg.qr(rng.standard_normal((3, 3)))[0]
    x = (rng.random((300, 2)) * [1.0, aspect]) @ frame[:2] + 7.0
    estimate = estimate_normals(x, neighbors=300)
    assert_close(np.abs(estimate.vectors @ frame[2]), np.ones(300), 1e-12)
    assert estimate.planar.all()
    assert estimate.planarity.min() > 1 - 1e-6


def test_normals_are_those_of_the_total_least_squares_plane():
    """The normal is the last right singular vector of the centred neighbours."""
    x = np.random.default_rng(6).random((9, 3))
    vectors = estimate_normals(x, neighbors=9).vectors
    last = np.linalg.svd(x - x.mean(axis=0))[2][-1]
    assert_close(np.abs(vectors @ last), np.ones(9), 1e-12)


def test_neighbourhoods_without_a_plane_are_reported():
    """A line, a repeated point and a solid ball of points have no tangent plane."""
    rng = np.random.default_rng(7)
    line = rng.random((50, 1)) * [1.0, 2.0, -1.0] + 10
    ball = rng.standard_normal((400, 3))
    assert not estimate_normals(line).planar.any()
    assert not estimate_normals(np.ones((30, 3))).planar.any()
    assert estimate_normals(ball, 40).planar.mean() < 0.35
    assert estimate_normals(sphere(1000)[0]).planar.all()
    assert np.isfinite(estimate_normals(np.ones((30, 3))).vectors).all()


@pytest.mark.parametrize("unit", [1e-3, 1.0, 1e3])
@pytest.mark.parametrize("d", [2, 3])
def test_a_plane_fits_if_the_variance_across_it_is_at_most_a_quarter(d, unit):
    """Of crosses of points, whose variances are known; the planarity is one less their ratio."""
    for across, planar in ((0.0, True), (0.49, True), (0.51, False), (1.0, False)):
        arms = np.diag([1.0] * (d - 1) + [across])
        cross = unit * (np.vstack([np.zeros((1, d)), arms, -arms]) + 5.0)
        found = estimate_normals(cross, neighbors=2 * d + 1)
        assert (found.planar == planar).all()
        assert_close(found.planarity, np.full(2 * d + 1, 1 - across**2), 1e-10)
        if across < 1:
            assert_close(abs(found.vectors[:, -1]), np.ones(2 * d + 1), 1e-12)


def test_points_near_edges_of_a_cube_are_not_planar():
    """Points in the interior of the faces are planar."""
    x, _ = BODIES["cube"]
    estimate = estimate_normals(x)
    from_edge = np.sort(0.5 - np.abs(x), axis=1)[:, 1]
    assert (~estimate.planar).any()
    assert from_edge[~estimate.planar].max() < 0.12
    assert estimate.planar[from_edge > 0.15].all()


# --- the sign -------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", BODIES)
def test_oriented_normals_point_outward(name):
    """The bodies are smooth, have sharp edges, a hole, or are thin."""
    assert correctly_oriented(*BODIES[name]) == 1.0


@pytest.mark.parametrize("thickness", [0.2, 0.1])
def test_sheets_thinner_than_the_spacing_are_oriented(thickness):
    """Reflected normals of the two sides agree. For the thinnest sheet, noise=0 must be given."""
    x, true = sheet(0.125, thickness)
    assert correctly_oriented(x, true) == 1.0
    thinner, true = sheet(0.125, thickness / 4)
    along = np.einsum("nd,nd->n", orient_normals(thinner, shuffled_signs(true), noise=0.0), true)
    assert (along > 0).all()


@pytest.mark.parametrize(("noise", "least"), [(0.1, 1.0), (0.3, 0.998), (0.5, 0.99)])
def test_noise_inverts_few_normals(noise, least):
    """The noise is given in units of the spacing; at most one normal in a hundred points inward."""
    x, true = sphere(5000)
    distance = np.sqrt(4 * np.pi / 5000)
    noisy = x + noise * distance * np.random.default_rng(8).standard_normal(x.shape)
    assert correctly_oriented(noisy, true) >= least


def test_each_connected_component_is_oriented_outward():
    """There are two bodies of different size."""
    (a, a_true), (b, b_true) = sphere(1500), torus(2500)
    x, true = np.vstack([a, 3 * b + [9.0, 0, 0]]), np.vstack([a_true, b_true])
    assert correctly_oriented(x, true) == 1.0


def arc(ratio):
    """A thick arc whose inner side has `ratio` times the spacing of the outer one, with normals."""
    sides = []
    for radius, side, step in ((1.0, 1.0, 1.0), (0.85, -1.0, ratio)):
        angle = np.linspace(0, 5, int(300 * radius / step))
        x = np.column_stack([np.cos(angle), np.sin(angle)])
        sides.append((radius * x, side * x))
    for angle, side in ((0.0, -1.0), (5.0, 1.0)):
        x, forward = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
        across = np.arange(0.86, 1.0, 0.01)
        sides.append((across[:, None] * x, np.tile(side * forward, (len(across), 1))))
    points, normals = zip(*sides, strict=True)
    return np.vstack(points), np.vstack(normals)


def test_the_side_of_a_body_does_not_depend_on_the_density_of_its_points(monkeypatch):
    """Counted without lengths, a dense inner side decides; with their squares, a sparse one."""
    dense, sparse = arc(0.3), arc(2.5)
    for x, true in (dense, sparse):
        assert (np.sum(orient_normals(x, shuffled_signs(true)) * true, axis=1) > 0).all()
    for power, (x, true) in ((0, dense), (2, sparse)):
        with monkeypatch.context() as patch:
            patch.setattr(normal_orientation, "reach", lambda p, i, m=power: reach(p, i) ** m)
            oriented = orient_normals(x, shuffled_signs(true))
        assert (np.sum(oriented * true, axis=1) < 0).all()


def test_by_default_a_point_is_joined_to_the_nearest_nine_or_five():
    """With normals at random every edge counts."""
    rng = np.random.default_rng(4)
    for d, default in ((3, 9), (2, 5)):
        x, normals = rng.standard_normal((2, 400, d))
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        found = orient_normals(x, normals)
        assert (found == orient_normals(x, normals, default)).all()
        for other in (default - 1, default + 1):
            assert not (found == orient_normals(x, normals, other)).all()


def test_repeated_points_do_not_affect_the_orientation():
    """Edges between repeated points have length zero, and therefore no direction."""
    x, true = BODIES["sphere"]
    assert correctly_oriented(np.vstack([x, x[:600]]), np.vstack([true, true[:600]])) == 1.0


def test_normals_of_a_plane_have_a_positive_largest_component():
    """A plane encloses nothing, so the largest component of the sum of normals decides."""
    rng = np.random.default_rng(9)
    x = rng.random((300, 2)) @ [[1.0, 0.0, 0.5], [0.0, 1.0, 0.2]]
    oriented = orient_normals(x, shuffled_signs(estimate_normals(x).vectors))
    assert (oriented[:, 2] > 0.8).all()


@pytest.mark.parametrize(("unit", "offset"), [(1.0, 1e7), (1e-140, 0.0), (1e140, 0.0)])
def test_normals_do_not_depend_on_origin_and_unit(unit, offset):
    """The origin is 1e7 radii away, or squares of lengths overflow or underflow."""
    x, true = BODIES["torus"]
    assert correctly_oriented(x * unit + offset, true) == 1.0
    estimate = estimate_normals(x * unit + offset)
    along = np.abs(np.einsum("nd,nd->n", estimate.vectors, estimate_normals(x).vectors))
    assert_close(along, np.ones(len(x)), 1e-6)
    assert (estimate.planar == estimate_normals(x).planar).all()


def test_neighbours_of_the_estimate_can_be_reused():
    """The orientation is the same as with a search of its own."""
    x, _ = BODIES["torus"]
    estimate = estimate_normals(x)
    vectors = shuffled_signs(estimate.vectors)
    again = orient_normals(x, vectors, estimate.neighbors[:, :9])
    assert (again == orient_normals(x, vectors, 9)).all()


def test_by_default_sixteen_neighbours_are_fitted_on_a_surface_and_seven_on_a_curve():
    rng = np.random.default_rng(4)
    for d, default in ((3, 16), (2, 7)):
        assert estimate_normals(rng.standard_normal((30, d))).neighbors.shape == (30, default)


def test_orientation_changes_signs_only():
    """The input is not modified."""
    x, true = BODIES["sphere"]
    given = shuffled_signs(true)
    before = given.copy()
    oriented = orient_normals(x, given)
    assert (np.abs(oriented) == np.abs(given)).all()
    assert (given == before).all()


# --- curves in the plane --------------------------------------------------------------------------


def ellipse(n, width=1.0, open_at=0.0):
    """Points of an ellipse of the height 1, less a part of its parameter; outward normals."""
    t = open_at / 2 + (2 * np.pi - open_at) * (np.arange(n) + 0.3) / n
    normals = np.column_stack([np.cos(t), width * np.sin(t)])
    points = np.column_stack([width * np.cos(t), np.sin(t)])
    return points, normals / np.linalg.norm(normals, axis=1)[:, None]


def test_normals_of_a_curve_are_of_second_order():
    """Neighbours on both sides balance: the largest angle falls with the square of the spacing."""
    angles = []
    for n in (100, 400):
        x, true = ellipse(n, 2.0)
        estimate = estimate_normals(x)
        cross = np.abs(estimate.vectors[:, 0] * true[:, 1] - estimate.vectors[:, 1] * true[:, 0])
        angles.append(cross.max())
        assert estimate.planar.all()
    assert np.log(angles[0] / angles[1]) / np.log(4) == pytest.approx(2, abs=0.3)
    line = np.linspace(0, 1, 20)[:, None] * [3.0, 4.0] + 1e5
    assert_close(np.abs(estimate_normals(line).vectors @ [0.8, -0.6]), np.ones(20), 1e-9)
    disc = np.random.default_rng(7).standard_normal((300, 2))
    assert estimate_normals(disc).planar.mean() < 0.5
    assert not estimate_normals(np.ones((9, 2))).planar.any()


def test_normals_of_closed_curves_point_outward():
    """Of a circle, an ellipse, both together, one with noise, in any unit and far away."""
    (a, a_true), (b, b_true) = ellipse(60), ellipse(200, 3.0)
    noise = 0.2 * 2 * np.pi / 200 * np.random.default_rng(3).standard_normal(b.shape)
    for x, true in (
        (a, a_true),
        (b * 1e-140, b_true),
        (b * 1e140, b_true),
        (b + 1e6, b_true),
        (b + noise, b_true),
        (np.vstack([a, b + np.array([9.0, 0.0])]), np.vstack([a_true, b_true])),
    ):
        assert correctly_oriented(x, true) == 1.0


def test_without_the_enclosed_area_normals_may_point_inward(monkeypatch):
    """They agree with that of the first point, whose sign is arbitrary."""
    monkeypatch.setattr(normal_orientation, "_outward", lambda *_: np.ones(1))
    x, true = ellipse(40)
    sides = {orient_normals(x, sign * true)[0] @ true[0] for sign in (1.0, -1.0)}
    assert_close(sorted(sides), np.array([-1.0, 1.0]), 1e-12)


def test_normals_of_an_open_curve_agree():
    """On one side all along, that of the largest component of their sum."""
    x, true = ellipse(100, 2.0, open_at=4.0)
    along = np.einsum("nd,nd->n", orient_normals(x, shuffled_signs(true)), true)
    assert np.abs(along.sum()) == pytest.approx(100)
    straight = np.linspace(0, 1, 30)[:, None] * [1.0, 0.1]
    oriented = orient_normals(straight, shuffled_signs(estimate_normals(straight).vectors))
    assert (oriented[:, 1] > 0.9).all()


def test_deviations_are_those_along_the_principal_axes():
    """Singular values of the centred neighbours, over the root of their number; in any unit."""
    for x, unit in ((np.random.default_rng(6).random((9, 3)), 1e150), (ellipse(30)[0], 1e-150)):
        estimate = estimate_normals(x * unit)
        near = x[estimate.neighbors[0]]
        sigma = np.linalg.svd(near - near.mean(axis=0), compute_uv=False) / np.sqrt(len(near))
        assert_close(estimate.deviations[0] / unit, sigma, 1e-12)
        smallest, next_smallest = (estimate.deviations[:, -1:-3:-1] / unit).T ** 2
        assert_close(estimate.planarity, 1 - smallest / next_smallest, 1e-9)


def test_neighbours_may_be_lists():
    """As indices in an array, or found."""
    x, true = ellipse(40)
    given, index = shuffled_signs(true), nearest(x, 5)
    assert (orient_normals(x, given, index.tolist()) == orient_normals(x, given, index)).all()
    assert (orient_normals(x, given, index) == orient_normals(x, given)).all()


# --- mutants --------------------------------------------------------------------------------------


def test_without_reflection_a_thin_sheet_is_not_oriented(monkeypatch):
    """Hoppe's criterion n_j = n_i gives both sides of the sheet the same sign."""

    def plain(offset, n, other):
        return (n * other).sum(axis=0), np.zeros(offset.shape[1:])

    monkeypatch.setattr(normal_orientation, "_agreement", plain)
    assert correctly_oriented(*sheet(0.125, 0.1)) == pytest.approx(0.5, abs=0.01)


@pytest.mark.parametrize("name", BODIES)
def test_the_spanning_forest_is_minimal(name):
    """It is computed from cheap edges first.

    Its cost equals that of SciPy's spanning tree of all edges.
    """
    points, _ = BODIES[name]
    index = nearest(points, 9)[:, 1:]
    cost = np.random.default_rng(9).random(index.shape).round(2) + 1  # with many equal ones
    at_once = csgraph.minimum_spanning_tree(normal_orientation._graph(cost, index, cost > 0))
    forest = normal_orientation._minimum_spanning_forest(cost, index)
    parts = [csgraph.connected_components(f, directed=False)[0] for f in (forest, at_once)]
    assert parts[0] == parts[1] == len(points) - forest.nnz
    assert_close(forest.sum(), at_once.sum(), 1e-12)


def test_edges_of_cost_zero_are_kept(monkeypatch):
    """In a plane all costs are zero. Sparse matrices drop zeros, so the costs must be shifted."""
    x, true = sheet(0.125, 0.2)
    assert (np.einsum("nd,nd->n", orient_normals(x, shuffled_signs(true)), true) > 0).all()
    tree = normal_orientation.csgraph.minimum_spanning_tree

    def unshifted(costs):
        costs.data -= 1
        costs.eliminate_zeros()
        return tree(costs)

    monkeypatch.setattr(normal_orientation.csgraph, "minimum_spanning_tree", unshifted)
    along = np.einsum("nd,nd->n", orient_normals(x, shuffled_signs(true)), true)
    assert (along > 0).mean() < 0.9


def test_without_majority_votes_noise_inverts_more_normals(monkeypatch):
    """The forest uses one edge per point; a vote uses all its neighbours."""
    x, true = sphere(5000)
    noisy = x + 0.3 * np.sqrt(4 * np.pi / 5000) * np.random.default_rng(8).standard_normal(x.shape)
    with_votes = correctly_oriented(noisy, true)
    monkeypatch.setattr(normal_orientation, "_vote", lambda *_: None)
    assert correctly_oriented(noisy, true) < with_votes


# --- refusals -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: estimate_normals(np.zeros((5, 4))), r"\(n, 3\), n at least 3; got \(5, 4\)"),
        (lambda: estimate_normals(np.zeros((5, 1))), r"shape \(n, 2\) or .*; got \(5, 1\)"),
        (lambda: orient_normals(np.eye(3), np.eye(3), [[0, 1], [1], [2]]), "rows differ in length"),
        (lambda: estimate_normals(np.zeros((2, 3))), r"n at least 3; got \(2, 3\)"),
        (lambda: estimate_normals([[0, 0, np.nan]] * 4), r"points must be finite; points\[0, 2\]"),
        (lambda: estimate_normals(np.eye(3), 2), "neighbors must be an integer"),
        (lambda: orient_normals(np.eye(3), np.eye(3)[:2]), r"shape of the points, \(3, 3\)"),
        (lambda: orient_normals(np.eye(3), np.eye(3), noise=-1.0), "noise must be zero or"),
        (lambda: orient_normals(np.eye(3), np.eye(3), 1.5), "neighbors must be an integer"),
        (lambda: orient_normals(np.eye(3), np.eye(3), np.ones((2, 3), int)), r"shape \(3, k\)"),
        (lambda: orient_normals(np.eye(3), np.eye(3), np.ones((3, 3))), r"got float64 of"),
        (lambda: orient_normals(np.eye(3), np.eye(3), np.full((3, 2), 3)), "indices of the 3 p"),
    ],
)
def test_invalid_arguments_are_refused(call, words):
    """The message names the argument, what came and what was wanted."""
    with pytest.raises(ValueError, match=words):
        call()


def test_three_neighbours_are_enough_for_a_plane():
    """The least number: a point and its two nearest ones."""
    p = np.array([[0.0, 0, 0], [1, 0, 1], [0, 1, 2], [9, 9, 9], [10, 9, 9], [9, 10, 9]])
    estimate = estimate_normals(p, neighbors=3)
    planes = [*[np.array([1.0, 2, -1]) / 6**0.5] * 3, *[np.array([0.0, 0, 1])] * 3]
    assert_close(np.abs(np.einsum("ij,ij->i", estimate.vectors, planes)), np.ones(6), 1e-14)


def test_more_neighbours_than_points_use_all_points():
    """Three points determine a plane."""
    estimate = estimate_normals([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]], neighbors=20)
    assert_close(np.abs(estimate.vectors[:, 2]), np.ones(3), 1e-14)
    assert orient_normals(np.eye(3), np.eye(3), neighbors=20).shape == (3, 3)
