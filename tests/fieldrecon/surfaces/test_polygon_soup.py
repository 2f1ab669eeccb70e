"""Implicit moving least squares of a polygon soup: integrals, laws and mutants."""

import math
from itertools import product

import mpmath
import numpy as np
import pytest

import fieldrecon as fr
from fieldrecon.surfaces import polygon_soup, triangle_integrals
from fieldrecon.surfaces.triangle_integrals import by_rule, over_segments, over_triangles
from fieldreport.experiments.surfaces.polygon_soup import gauss_on_triangles, on_the_cube
from fieldreport.experiments.triangles.triangle_shapes import cube, sphere, torus


@pytest.fixture
def rng():
    """Each test draws its own numbers, so that no result depends on which tests ran before."""
    return np.random.default_rng(7)


def random_triangles(n, rng):
    corners = rng.normal(size=(n, 3, 3))
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return corners, normals / np.linalg.norm(normals, axis=1, keepdims=True)


def test_integrals_over_triangles_agree_with_dense_quadrature(rng):
    """Closed form and gradient agree for queries above, beside and far from the triangles."""
    corners, normals = random_triangles(60, rng)
    rule = gauss_on_triangles(corners, 40)
    for distance in (0.5, 3.0, 100.0):
        x = distance * rng.normal(size=(60, 3))
        value, slope = over_triangles(x, corners, normals, 0.3)
        expected, expected_slope = by_rule(x, *rule, 0.3)
        np.testing.assert_allclose(value, expected, rtol=1e-5)
        size = np.linalg.norm(expected_slope, axis=1, keepdims=True)
        np.testing.assert_allclose(slope / size, expected_slope / size, atol=1e-4)


@pytest.mark.slow
def test_integrals_at_corners_and_edges_do_not_cancel():
    """At these points the side of the query relative to an edge is decided by rounding."""
    points, triangles = torus(12, 6)
    x = np.repeat(points, len(triangles), axis=0)
    corners = np.tile(points[triangles], (len(points), 1, 1))
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    value, _ = over_triangles(x, corners, normals, 0.3)
    np.testing.assert_allclose(value, by_rule(x, *gauss_on_triangles(corners, 12), 0.3)[0], 1e-4)


def test_integrals_in_the_plane_of_a_triangle_converge_for_small_epsilon():
    """Outside the triangle, but in its plane, the integrand is regular for ε = 0."""
    corners, up = np.array([[[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]]), np.array([[0.0, 0, 1]])
    for x in ([2.0, 1.0, 0.0], [2.0, 0.0, 1e-9], [-1.0, 0.0, 0.0]):
        x = np.array([x])
        expected, _ = by_rule(x, *gauss_on_triangles(corners, 40), 0.0)
        for epsilon in (1e-4, 1e-8, 1e-12):
            np.testing.assert_allclose(
                over_triangles(x, corners, up, epsilon)[0], expected, rtol=1e-6
            )


def test_integrals_over_segments_agree_with_dense_quadrature(rng):
    """This is the case of the plane, with the gradient."""
    corners = rng.normal(size=(60, 2, 2))
    along = corners[:, 1] - corners[:, 0]
    length = np.linalg.norm(along, axis=1)
    normals = np.stack([along[:, 1], -along[:, 0]], axis=1) / length[:, None]
    node, weight = np.polynomial.legendre.leggauss(80)
    nodes = corners[:, None, 0] + along[:, None] * (node[:, None] + 1) / 2
    weights = length[:, None] * weight / 2
    for distance in (0.5, 100.0):
        x = distance * rng.normal(size=(60, 2))
        value, slope = over_segments(x, corners, normals, 0.3)
        expected, expected_slope = by_rule(x, nodes, weights, 0.3)
        np.testing.assert_allclose(value, expected, rtol=1e-5)
        np.testing.assert_allclose(slope, expected_slope, rtol=1e-4, atol=1e-4 * slope.max())


@pytest.mark.parametrize("epsilon", [0.0, 0.2])
def test_coplanar_polygons_give_the_distance_to_their_plane(epsilon, rng):
    """All polygons have the same linear function, so the result is exact everywhere."""
    points = np.column_stack([rng.normal(size=(30, 2)), np.full(30, 2.5)])
    triangles = np.arange(30).reshape(-1, 3)
    a, b, c = points[triangles].swapaxes(0, 1)
    down = np.cross(b - a, c - a)[:, 2] < 0
    triangles[down] = triangles[down][:, ::-1]
    soup = fr.surfaces.PolygonSoup(points, triangles, epsilon)
    x = 5 * rng.normal(size=(50, 3))
    np.testing.assert_allclose(soup(x), 2.5 - x[:, 2], atol=1e-12)
    np.testing.assert_allclose(soup.gradient(x), np.tile([0, 0, -1.0], (50, 1)), atol=1e-7)


@pytest.mark.parametrize("surface", [cube(2), sphere(1), torus(12, 6)])
def test_without_smoothing_the_polygons_are_zeros(surface, rng):
    """F vanishes on the polygons with the gradient -n and is positive inside."""
    points, triangles = surface
    soup = fr.surfaces.PolygonSoup(points, triangles)
    shares = rng.dirichlet([3.0, 3.0, 3.0], len(triangles))
    on = np.einsum("kc,kcd->kd", shares, points[triangles])
    a, b, c = points[triangles].swapaxes(0, 1)
    normals = np.cross(b - a, c - a)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    np.testing.assert_allclose(soup(on), 0, atol=1e-12)
    np.testing.assert_allclose(soup.gradient(on), -normals, atol=1e-5)
    assert (soup(on - 1e-3 * normals) > 0).all()
    assert (soup(on + 1e-3 * normals) < 0).all()


def test_the_zero_level_converges_to_the_polygons_with_second_order():
    """Half the smoothing length gives a quarter of the distance."""
    (coarse, _), (fine, _) = on_the_cube(0.02), on_the_cube(0.01)
    assert np.log2(coarse / fine) == pytest.approx(2, abs=0.05)


def test_gradients_equal_central_differences(rng):
    """F has smoothing and offsets; queries are near and far."""
    points, triangles = sphere(1)
    offsets = 0.1 * rng.random(len(triangles))
    soup = fr.surfaces.PolygonSoup(points, triangles, 0.1, offsets, tol=1e-12)
    x, h = 1.5 * rng.normal(size=(40, 3)), 1e-5
    slopes = [(soup(x + h * e) - soup(x - h * e)) / (2 * h) for e in np.eye(3)]
    np.testing.assert_allclose(soup.gradient(x), np.stack(slopes, axis=1), atol=1e-7)


@pytest.mark.parametrize("epsilon", [0.0, 0.5])
def test_gradients_far_from_polygons_are_those_of_the_quadrature(epsilon, rng):
    """Of many polygons some are integrated in closed form, and the others by the rules."""
    square = (
        np.array([[0.0, 0], [1, 0], [1, 1], [0, 1]]),
        np.array([[0, 1], [1, 2], [2, 3], [3, 0]]),
    )
    for points, polygons in (square, sphere(1)):
        d, h = points.shape[1], 1e-5
        soup = fr.surfaces.PolygonSoup(points, polygons, epsilon, tol=1e-4)
        direction = rng.normal(size=(40, d))
        direction /= np.linalg.norm(direction, axis=1, keepdims=True)
        x = np.array(points).mean(axis=0) + direction * rng.uniform(1.2, 12, (40, 1))
        near = soup._integrals(x)[1]
        assert near.any()
        assert not near.all()
        slopes = [(soup(x + h * e) - soup(x - h * e)) / (2 * h) for e in np.eye(d)]
        smooth = (soup._integrals(x + h)[1] == soup._integrals(x - h)[1]).all(axis=1)
        found = soup.gradient(x)[smooth]
        np.testing.assert_allclose(found, np.stack(slopes, axis=1)[smooth], atol=1e-8)


@pytest.mark.parametrize(("d", "degree"), [(2, 7), (3, 5)])
def test_the_rules_are_exact_for_polynomials(d, degree):
    """Four nodes of Gauss on a segment, seven of Radon on a triangle, and no degree higher."""
    nodes, weights = polygon_soup._RULES[d]
    np.testing.assert_allclose(nodes.sum(axis=1), 1.0)
    for total in range(degree + 2):
        errors = []
        for powers in product(range(total + 1), repeat=d):
            if sum(powers) == total:
                factorials = [math.factorial(k) for k in (*powers, d - 1)]
                exact = math.prod(factorials) / math.factorial(total + d - 1)
                errors.append(abs(weights @ (nodes**powers).prod(axis=1) / exact - 1))
        assert (max(errors) < 1e-12) == (total <= degree)


def test_the_error_of_the_far_quadrature_is_below_the_tolerance(rng):
    points, triangles = sphere(2)
    exact = fr.surfaces.PolygonSoup(points, triangles, 0.05, tol=1e-14)
    x = 1.2 * rng.normal(size=(60, 3))
    for tolerance in (1e-2, 1e-4, 1e-6):
        soup = fr.surfaces.PolygonSoup(points, triangles, 0.05, tol=tolerance)
        assert np.abs(soup(x) - exact(x)).max() < tolerance


@pytest.mark.parametrize("d", [2, 3])
def test_the_quadrature_begins_where_its_error_falls_below_the_tolerance(d, rng):
    """In space half of the tolerance is used; the rule for segments is better than that."""
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [0.5, 0.75**0.5, 0]])[:d, :d]
    points, polygons = np.concatenate([corners, corners + 1e3]), np.arange(2 * d).reshape(2, d)
    x = rng.normal(size=(4000, d))
    x *= np.exp(rng.uniform(-1, 3, (4000, 1))) / np.linalg.norm(x, axis=1, keepdims=True)
    x += corners.mean(axis=0)

    def near_to_far(tolerance):
        near, far = fr.surfaces.PolygonSoup(points, polygons, tol=tolerance).weights(x).T
        return near / far

    exact = near_to_far(1e-14)
    for tolerance in (1e-2, 1e-4, 1e-6):
        error = np.abs(near_to_far(tolerance) / exact - 1).max()
        assert (0.2 if d == 3 else 1e-3) * tolerance < error < tolerance


@pytest.mark.parametrize("nearest", [51.0, 60.0])
def test_integrals_beside_a_slender_triangle_have_all_terms_of_their_series(nearest):
    """Far along the line of an edge, at a distance from the line of one; by mpmath."""
    s, t, squared = np.array([nearest]), np.array([nearest + 3.0]), np.array([1.0])
    for integral, power in ((triangle_integrals._second, 2), (triangle_integrals._third, 3)):
        exact = mpmath.quad(lambda u, p=power: 1 / (u * u + 1) ** p, [nearest, nearest + 3])
        np.testing.assert_allclose(integral(s, t, squared), float(exact), rtol=1e-11)


def test_subdividing_a_polygon_does_not_change_the_field(rng):
    """The integral over the parts is that over the whole.

    A duplicated polygon does change the field.
    """
    points, triangles = cube(1)
    middle = points[triangles[0]].mean(axis=0)
    a, b, c = triangles[0]
    cut = np.concatenate([triangles[1:], [[a, b, 8], [b, c, 8], [c, a, 8]]])
    x = rng.normal(size=(30, 3))
    whole = fr.surfaces.PolygonSoup(points, triangles, 0.2, tol=1e-14)
    parts = fr.surfaces.PolygonSoup(np.vstack([points, middle]), cut, 0.2, tol=1e-14)
    doubled = fr.surfaces.PolygonSoup(points, np.concatenate([triangles, triangles[:1]]), 0.2)
    np.testing.assert_allclose(parts(x), whole(x), rtol=1e-9, atol=1e-12)
    assert np.abs(doubled(x) - whole(x)).max() > 1e-3


def test_the_field_does_not_depend_on_origin_axes_and_unit(rng):
    """A rigid motion and a change of unit transform the field accordingly."""
    points, triangles = torus(10, 5)
    rotation = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    rotation *= np.sign(np.linalg.det(rotation))
    x = rng.normal(size=(30, 3))
    soup = fr.surfaces.PolygonSoup(points, triangles, 0.1)
    transformed = fr.surfaces.PolygonSoup(8 * points @ rotation.T + 1e6, triangles, 0.8)
    np.testing.assert_allclose(transformed(8 * x @ rotation.T + 1e6), 8 * soup(x), atol=1e-6)


@pytest.mark.parametrize("unit", [1e-170, 1e-50, 1e60, 1e170])
def test_results_do_not_depend_on_the_unit(unit):
    """Also beside the line of an edge without smoothing, where powers would be out of range."""
    square = np.array([[0.0, 0], [1, 0], [1, 1], [0, 1]]), [[0, 1], [1, 2], [2, 3], [3, 0]]
    x = np.array([[1.000366, -0.15298], [0.5, 0.4], [1.0, 0.3]])
    for points, polygons, y in ((*square, x), (*torus(10, 5), np.column_stack([x, x[:, 0]]))):
        here = fr.surfaces.PolygonSoup(points, polygons).enclosing()
        there = fr.surfaces.PolygonSoup(points * unit, polygons).enclosing()
        np.testing.assert_allclose(there(y * unit) / unit, here(y), rtol=1e-9, atol=1e-12)
        np.testing.assert_allclose(there.gradient(y * unit), here.gradient(y), rtol=1e-9, atol=1e-9)
        np.testing.assert_allclose(there.offsets / unit, here.offsets, atol=1e-12)


@pytest.mark.parametrize("unit", [0.1, 1.0, 10.0])
def test_a_soup_that_has_offsets_is_enclosed_in_any_unit(unit, rng):
    """The function is zero at one corner, and positive at the others."""
    points, triangles = torus(8, 5)
    offsets = 0.1 * rng.normal(size=len(triangles))
    soup = fr.surfaces.PolygonSoup(unit * points, triangles, 0.3 * unit, unit * offsets)
    assert abs(soup(soup.points).min()) > 1e-3 * unit
    assert abs(soup.enclosing()(soup.points).min()) < 1e-12 * unit


@pytest.mark.slow
@pytest.mark.parametrize(
    ("loose", "epsilon", "share"), [(0.0, 0.3, 0.05), (0.1, 0.05, 0.8), (0.1, 0.3, 0.97)]
)
def test_enclosing_surfaces_contain_all_corners_and_are_close(loose, epsilon, share, rng):
    """The mean distance is at most that of one common offset for all polygons, mostly less."""
    points, triangles = torus(12, 6)
    ratios = []
    for _ in range(8 if loose else 1):
        corners = points[triangles] * (1 + loose * rng.random((len(triangles), 1, 1)))
        soup = fr.surfaces.PolygonSoup(
            corners.reshape(-1, 3), np.arange(3 * len(triangles)).reshape(-1, 3), epsilon
        )
        around, before = soup.enclosing()(soup.points), soup(soup.points)
        assert around.min() > -1e-12
        ratios.append(around.mean() / (before - before.min()).mean())
    assert max(ratios) <= 1 + 1e-12
    assert np.mean(ratios) <= share


def test_sweeps_that_enclose_go_on_after_four_without_progress():
    """Of these segments the fifth is better again; sweep by sweep, the best is taken."""
    points, segments = np.random.default_rng(112).normal(size=(8, 2)), np.arange(8).reshape(4, 2)
    offsets, means = np.zeros(4), []
    for _ in range(40):
        values = fr.surfaces.PolygonSoup(points, segments, 1.0, offsets)(points)
        means.append((values - values.min()).mean())
        offsets = offsets - values[segments].min(axis=1)
    around = fr.surfaces.PolygonSoup(points, segments, 1.0).enclosing()(points)
    assert around.mean() < 1.1 * min(means)


def test_constant_values_on_polygons_give_the_zero_field(monkeypatch, rng):
    """Plain moving least squares with the value zero on the polygons gives F = 0 everywhere."""
    soup = fr.surfaces.PolygonSoup(*sphere(1))
    monkeypatch.setattr(
        polygon_soup.PolygonSoup, "_planes", lambda self, x: np.zeros((len(x), len(self._kept)))
    )
    assert not soup(rng.normal(size=(20, 3))).any()


def test_too_many_polygons_to_enclose_are_refused(monkeypatch):
    """The error is raised before memory is allocated."""
    monkeypatch.setattr(polygon_soup, "DENSE_LIMIT_BYTES", 10_000)
    with pytest.raises(MemoryError, match="take fewer polygons"):
        fr.surfaces.PolygonSoup(*sphere(1), 0.1).enclosing()
    soup = fr.surfaces.PolygonSoup(*cube(1))
    monkeypatch.setattr(polygon_soup, "DENSE_LIMIT_BYTES", 8 * 12 * 7)
    assert soup.weights(np.ones((7, 3))).shape == (7, 12)
    with pytest.raises(MemoryError, match="the weights of 12 polygons at 8 points"):
        soup.weights(np.ones((8, 3)))


@pytest.mark.parametrize("epsilon", [0.0, 0.2])
def test_polygons_without_an_area_are_ignored(epsilon, rng):
    """At the beginning, in the middle or at the end; they keep their offsets."""
    points, triangles = cube(1)
    x = rng.normal(size=(30, 3))
    flat = np.array([[0, 0, 1]])
    without = fr.surfaces.PolygonSoup(points, triangles, epsilon).enclosing()
    for k in (0, 5, len(triangles)):
        every = np.concatenate([triangles[:k], flat, triangles[k:]])
        offsets = np.where(np.arange(len(every)) == k, 7.0, 0.0)
        soup = fr.surfaces.PolygonSoup(points, every, epsilon, offsets).enclosing()
        np.testing.assert_allclose(soup(x), without(x), atol=1e-12)
        np.testing.assert_allclose(soup.gradient(x), without.gradient(x), atol=1e-12)
        np.testing.assert_allclose(soup.weights(x), without.weights(x), atol=1e-14)
        assert soup.offsets[k] == 7
        np.testing.assert_allclose(np.delete(soup.offsets, k), without.offsets, atol=1e-12)


@pytest.mark.parametrize("last", [0.0, 0.3, 1.0])
def test_points_on_triangles_include_the_corners_of_each(last):
    """Also of a triangle whose corners coincide, beside one without or with cuts, or alone."""
    point = np.full((1, 3, 3), 7.0)
    other = np.array([[[0.0, 0, 0], [last, 0, 0], [0, last, 0]]])
    for corners in (point, np.concatenate([other, point])):
        found = polygon_soup.points_on_triangles(corners, 0.5)
        assert {*map(tuple, corners.reshape(-1, 3))} <= {*map(tuple, found)}


def test_points_on_triangles_are_at_most_the_spacing_apart(rng):
    """Lattices with as many steps along each side as the longest side takes."""
    for corners in rng.normal(size=(12, 1, 3, 3)):
        longest = np.linalg.norm(corners[0] - np.roll(corners[0], 1, axis=0), axis=1).max()
        for spacing in longest * np.array([2.0, 1.001, 0.999, 0.4, 0.1]):
            steps = int(np.ceil(longest / spacing))
            shares = [(i, j, steps - i - j) for i in range(steps + 1) for j in range(steps + 1 - i)]
            expected = np.array(shares) @ corners[0] / steps
            found = polygon_soup.points_on_triangles(corners, spacing)
            expected = expected[np.lexsort(expected.T[::-1].round(9))]
            np.testing.assert_allclose(found[np.lexsort(found.T[::-1].round(9))], expected)


@pytest.mark.parametrize(("epsilon", "spacing"), [(0.0, None), (0.3, None), (0.0, 0.5), (0.1, 0.5)])
def test_the_body_of_loose_triangles_holds_them_in_its_box(epsilon, spacing):
    """With a margin of spacings or smoothing lengths, the larger; points without a triangle too."""
    points, triangles = np.vstack([3 * cube(2)[0], [[9.0, 9, 9]]]), cube(2)[1]
    body = polygon_soup.PolygonSoupSolid(points, triangles, epsilon, spacing)
    assert body.spacing == pytest.approx(spacing or 3 / polygon_soup.CELLS)
    margin = polygon_soup._MARGIN * max(body.spacing, epsilon)
    np.testing.assert_allclose(body.box, [[-margin] * 3, [3 + margin] * 3], atol=1e-12)
    assert (body(points[:-1]) >= -1e-9).all()
    assert body([1.5, 1.5, 1.5]) > 0
    assert (body(body.box) < 0).all()
    np.testing.assert_array_equal(
        body.points, polygon_soup.points_on_triangles(points[triangles], body.spacing)
    )


@pytest.mark.parametrize(
    ("points", "polygons", "options", "words"),
    [
        ([[0.0], [1.0]], [[0]], {}, "in the plane or in space"),
        ([[0.0, 0], [1, 0]], [[0, 2]], {}, "indices of the 2 points"),
        ([[0.0, 0], [1, 0]], [[0, 1, 1]], {}, r"shape \(m, 2\)"),
        ([[0.0, 0], [1, 0]], [[0, 0]], {}, "a length or an area"),
        ([[0.0, 0], [1, 0]], [[0, 1]], {"epsilon": -1.0}, "epsilon must be zero or a positive"),
        ([[0.0, 0], [1, 0]], [[0, 1]], {"offsets": [1.0, 2.0]}, "one entry for each polygon"),
    ],
)
def test_invalid_polygon_soups_are_refused(points, polygons, options, words):
    """The message names the argument, what came and what was wanted."""
    with pytest.raises(ValueError, match=words):
        fr.surfaces.PolygonSoup(points, polygons, **options)
