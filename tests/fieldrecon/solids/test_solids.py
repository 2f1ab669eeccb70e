"""Solids as fields: distances, set operations, blends, transformations and surface samples."""

from itertools import product

import numpy as np
import pytest
from scipy.spatial import cKDTree

from fieldrecon.solids import constructive as solids
from fieldrecon.solids.constructive import (
    as_solid,
    blend,
    difference,
    intersection,
    morph,
    transform,
    union,
)
from fieldrecon.solids.shapes import Ball, Box, Cylinder, Torus, roughened, sample_surface, scanned
from fieldrecon.triangles.audit import audit_mesh
from laws import assert_close

SHAPES = {
    "ball": Ball(1.0, [0.3, -0.2, 0.1]),
    "box": Box([1.0, 1.5, 0.4], [0.1, 0.2, 0.0]),
    "torus": Torus(1.0, 0.3),
    "cylinder": Cylinder(0.7, 1.2, [0.0, 0.1, 0.2]),
}
ROTATION = np.linalg.qr(np.random.default_rng(3).standard_normal((3, 3)))[0]
BODIES = SHAPES | {
    "union": Ball(1.0) | Box(1.2, [1.0, 0, 0]),
    "intersection": Ball(1.0) & Box(1.2, [1.0, 0, 0]),
    "difference": Box(1.5) - Cylinder(0.4, 3.0),
    "blend": blend(Ball(1.0), Ball(1.0, [1.5, 0, 0]), 0.8),
    "deformation": morph(Ball(1.0), Box(1.5), 0.4),
    "moved": transform(Torus(1.0, 0.3), ROTATION, [1.0, 2.0, 3.0], 2.5),
    "given": as_solid(Ball(1.0), [[-1, -1, -1], [1, 1, 1]]),
}


def queries(solid, n=4000, seed=1):
    low, high = solid.box
    return low - 0.5 + (high - low + 1.0) * np.random.default_rng(seed).random((n, 3))


@pytest.mark.parametrize("name", SHAPES)
def test_the_field_of_a_shape_is_the_distance_to_its_surface(name):
    """The reference is the nearest of 20 000 points on the surface."""
    solid = SHAPES[name]
    surface, _ = sample_surface(solid, 20000, seed=2)
    x = queries(solid, 300)
    nearest = cKDTree(surface).query(x)[0]
    distance = np.abs(solid(x))
    assert (distance <= nearest + 1e-9).all()
    assert (nearest - distance).max() < 0.08


@pytest.mark.parametrize("name", BODIES)
def test_gradients_equal_central_differences(name):
    """The field is not smooth everywhere, so 98 % of the queries must agree."""
    solid = BODIES[name]
    x, h = queries(solid, 500), 1e-6
    differences = np.stack(
        [(solid(x + h * e) - solid(x - h * e)) / (2 * h) for e in np.eye(3)], axis=-1
    )
    error = np.linalg.norm(differences - solid.gradient(x), axis=1)
    assert np.quantile(error, 0.98) < 1e-6


@pytest.mark.parametrize("name", BODIES)
def test_a_solid_lies_in_its_box(name):
    """No point outside the box is inside the solid, and some points of the box are."""
    solid = BODIES[name]
    x = queries(solid)
    out = ((x < solid.box[0]) | (x > solid.box[1])).any(axis=1)
    assert (solid(x[out]) <= 1e-12).all()
    assert (solid(x) > 0).any()


def test_signs_of_set_operations_obey_set_algebra():
    """Union, intersection, difference and one of De Morgan's laws are compared at random points."""
    a, b, c = SHAPES["ball"], SHAPES["box"], SHAPES["torus"]
    x = queries(a | b | c)
    inside = [s(x) > 0 for s in (a, b, c)]
    assert ((union(a, b, c)(x) > 0) == np.any(inside, axis=0)).all()
    assert ((intersection(a, b, c)(x) > 0) == np.all(inside, axis=0)).all()
    assert ((difference(a, b)(x) > 0) == (inside[0] & ~inside[1])).all()
    assert_close((a - (b | c))(x), ((a - b) & (a - c))(x), 0.0)


def test_the_box_of_an_intersection_is_that_of_the_boxes():
    """It is a single point if the boxes do not meet."""
    a, b = Ball(1.0), Ball(1.0, center=[1.5, 0.0, 0.0])
    assert (a & b).box.tolist() == [[0.5, -1.0, -1.0], [1.0, 1.0, 1.0]]
    apart = a & Ball(1.0, center=[9.0, 0.0, 0.0])
    assert (apart.box[0] <= apart.box[1]).all()


def test_a_difference_without_the_minus_sign_is_detected(monkeypatch):
    """Without the minus sign the difference is the intersection."""
    extreme = solids._Extreme
    monkeypatch.setattr(
        solids, "_Extreme", lambda parts, _, box, choice: extreme(parts, np.ones(2), box, choice)
    )
    a, b = SHAPES["ball"], SHAPES["box"]
    x = queries(a | b)
    assert ((difference(a, b)(x) > 0) != ((a(x) > 0) & ~(b(x) > 0))).any()


def test_a_blend_equals_the_union_away_from_the_intersection_curve():
    """The blend exceeds the union by at most a quarter of the radius, attained at equal fields."""
    a, b, r = Ball(1.0), Ball(1.0, [1.5, 0, 0]), 0.8
    x = queries(a | b)
    more = blend(a, b, r)(x) - union(a, b)(x)
    assert (more >= 0).all()
    assert (more[np.abs(a(x) - b(x)) >= r] == 0).all()
    middle = [0.75, 3.0, 0.0]
    assert_close(blend(a, b, r)(middle), union(a, b)(middle) + r / 4, 1e-15)


def test_a_blend_has_a_continuous_gradient_where_a_union_has_none():
    """The gradient of the union jumps in the plane in which two balls intersect."""
    a, b = Ball(1.0), Ball(1.0, [1.5, 0, 0])
    sides = np.array([[0.75 - 1e-9, 0.9, 0], [0.75 + 1e-9, 0.9, 0]])
    assert np.ptp(blend(a, b, 0.8).gradient(sides), axis=0).max() < 1e-7
    assert np.ptp(union(a, b).gradient(sides), axis=0).max() > 1


def test_a_morph_interpolates_between_two_solids():
    """t = 0 and t = 1 give the two solids; between concentric balls the result is a ball."""
    a, b = SHAPES["box"], SHAPES["torus"]
    x = queries(a | b)
    assert_close(morph(a, b, 0.0)(x), a(x), 0.0)
    assert_close(morph(a, b, 1.0)(x), b(x), 0.0)
    assert_close(morph(Ball(1.0), Ball(3.0), 0.25)(x), Ball(1.5)(x), 1e-12)


def test_transformed_fields_scale_and_their_normals_rotate():
    """F'(s R x + t) = s F(x), and the normals are rotated by R."""
    solid, shift = SHAPES["torus"], np.array([1.0, 2.0, 3.0])
    x = queries(solid)
    there = 2.5 * x @ ROTATION.T + shift
    other = transform(solid, ROTATION, shift, 2.5)
    assert_close(other(there), 2.5 * solid(x), 1e-12)
    assert_close(other.normals(there), solid.normals(x) @ ROTATION.T, 1e-9)


def test_one_size_is_that_of_all_edges_of_a_box():
    assert Box(1.5, [1.0, 2.0, 3.0]).box.tolist() == [[0.25, 1.25, 2.25], [1.75, 2.75, 3.75]]
    x = queries(Box(1.5))
    assert_close(Box(1.5)(x), Box([1.5, 1.5, 1.5])(x), 0.0)


def test_the_box_of_a_transformed_body_holds_its_corners():
    """And touches them: it is the box of the eight corners of the box before."""
    size, shift = np.array([1.0, 2.0, 0.5]), np.array([1.0, 2.0, 3.0])
    corners = np.array(list(product(*Box(size).box.T)))
    there = 2.5 * corners @ ROTATION.T + shift
    box = transform(Box(size), ROTATION, shift, 2.5).box
    assert_close(box, [there.min(axis=0), there.max(axis=0)], 1e-12)


def test_surface_samples_are_uniform():
    """The number of points on each face of a box is within four standard deviations of its mean."""
    size = np.array([1.0, 2.0, 0.5])
    points, normals = sample_surface(Box(size), 6000, seed=4)
    assert np.abs(Box(size)(points)).max() < 1e-9
    areas = np.repeat(size.prod() / size, 2)
    expected = 6000 * areas / areas.sum()
    counts = [int((normals[:, k] == sign).sum()) for k in range(3) for sign in (-1, 1)]
    assert (np.abs(counts - expected) < 4 * np.sqrt(expected)).all()


@pytest.mark.parametrize("slope", [0.3, 1.0, 3.0])
def test_points_are_drawn_on_a_surface_whatever_the_slope_of_the_field_there(slope):
    """They are projected by Newton's method, which divides by the squared slope."""

    class Scaled(Ball):
        def _from_center(self, y):
            return tuple(slope * part for part in super()._from_center(y))

    points, normals = sample_surface(Scaled(1.0), 500, seed=3)
    assert_close(np.linalg.norm(points, axis=1), np.ones(500), 1e-10)
    assert_close(normals, points, 1e-10)


def test_as_many_points_are_drawn_as_are_wanted():
    """Also where a round finds one at most: in a box that is large for the body."""
    body = as_solid(Ball(0.1), [[-5.0] * 3, [5.0] * 3])
    for n in (0, 1, 2, 5):
        assert sample_surface(body, n, seed=1)[0].shape == (n, 3)


def test_no_points_are_drawn_where_the_field_is_flat():
    """Outside of this ball it is zero, with a gradient of zero, which gives no direction."""

    class Clipped:
        def __call__(self, x):
            return np.maximum(Ball(1.0)(x), 0)

        def gradient(self, x):
            return np.where((Ball(1.0)(x) >= 0)[..., None], Ball(1.0).gradient(x), 0.0)

    points, normals = sample_surface(as_solid(Clipped(), Ball(1.0).box), 50, seed=3)
    assert_close(np.linalg.norm(points, axis=1), np.ones(50), 1e-12)
    assert_close(normals, points, 1e-12)


def test_noise_is_along_the_normal():
    """Its standard deviation is the given one; tangential components are zero."""
    points, normals = sample_surface(Ball(1.0), 4000, seed=5)
    rough = roughened(points, normals, 0.05, seed=6)
    assert np.linalg.norm(rough, axis=1).std() == pytest.approx(0.05, rel=0.05)
    assert_close(np.cross(rough, points), np.zeros_like(points), 1e-12)
    np.testing.assert_array_equal(roughened(points, normals, 0.0, seed=6), points)


def test_a_scan_omits_hidden_points():
    """A scanner sees half of a ball, and nothing of it behind a wall."""
    ball, eye = Ball(0.5), [[5.0, 0.0, 0.0]]
    points, normals = sample_surface(ball, 800, seed=7)
    seen = scanned(ball, points, normals, eye)
    assert seen[points[:, 0] > 0.2].all()
    assert not seen[points[:, 0] < 0].any()
    assert not scanned(ball | Box([0.1, 3, 3], [2.0, 0, 0]), points, normals, eye).any()
    assert scanned(ball, points, normals, [*eye, [-5.0, 0, 0]]).mean() > 1.5 * seen.mean()


@pytest.mark.parametrize("slant", [0.1, 0.2, 0.7])
@pytest.mark.parametrize("name", ["ball", "box", "cylinder"])
def test_a_scanner_sees_of_a_convex_body_what_faces_it(name, slant):
    """Up to the given angle between the normal and the direction to it, from one place or more."""
    points, normals = sample_surface(SHAPES[name], 400, seed=7)
    eyes = np.array([[3.0, -1.0, 0.5], [-2.0, 2.5, 1.0]])
    toward = eyes[:, None] - points
    cosine = np.einsum("eij,ij->ei", toward, normals) / np.linalg.norm(toward, axis=2)
    for some in ([0], [1], [0, 1]):
        expected = (cosine[some] > slant).any(axis=0)
        found = scanned(SHAPES[name], points, normals, eyes[some], slant)
        np.testing.assert_array_equal(found, expected)


@pytest.mark.parametrize("distance", [1.3, 4.0, 60.0])
def test_a_scanner_sees_nothing_in_the_shadow_of_a_ball(distance):
    """The distance of the centre of a ball from the segments to the scanner is less than its
    radius; only rays that graze it are in doubt."""
    eye, other = np.array([0.3, distance, 0.1]), Ball(0.15, [0.1, 0.9, 0.0])
    points, normals = sample_surface(Ball(0.6), 600, seed=8)
    toward = (eye - points) / np.linalg.norm(eye - points, axis=1, keepdims=True)
    along = np.clip(np.einsum("ij,ij->i", other._center - points, toward), 0, None)
    past = np.linalg.norm(points + along[:, None] * toward - other._center, axis=1)
    expected = (np.einsum("ij,ij->i", normals, toward) > 0.2) & (past > other.radius)
    sure = np.abs(past - other.radius) > 0.003
    found = scanned(Ball(0.6) | other, points, normals, [eye])
    np.testing.assert_array_equal(found[sure], expected[sure])
    assert expected.any()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: Ball(0.0), "radius must be a positive number; got 0.0"),
        (lambda: Box([1.0, -1.0, 1.0]), r"size must be positive; got \[1.0, -1.0, 1.0\]"),
        (lambda: Box([1.0, 1j, 1.0]), "size must be an array of real numbers"),
        (lambda: union(), "at least one body is needed"),
        (lambda: union(Ball(1.0), 3), "must be a Solid, such as .*; got 3"),
        (lambda: blend(Ball(1.0), Ball(1.0), -1), "radius must be a positive number"),
        (lambda: morph(Ball(1.0), Ball(1.0), 1.5), "t must be from 0 to 1; got 1.5"),
        (lambda: transform(Ball(1.0), 2 * np.eye(3)), "rotation must be an orthogonal matrix"),
        (lambda: as_solid(abs, [[0, 0, 0], [1, 1, 1]]), "must be callable and have a gradient"),
        (lambda: as_solid(Ball(1.0), [[0, 0, 0], [1, 0, 1]]), "a low and a high corner"),
        (lambda: Ball(1.0)([1.0, 2.0]), "x must have 3 coordinates"),
        (lambda: sample_surface(Ball(1.0) & Ball(1.0, [9, 0, 0]), 5, 1), "no surface in its box"),
    ],
)
def test_invalid_solids_are_refused(call, words):
    """The message names the argument, what came and what was wanted."""
    with pytest.raises(ValueError, match=words):
        call()


@pytest.mark.slow
def test_triangles_of_one_cell_do_not_cross():
    """For all signs at the corners, and vertices anywhere on the edges."""
    from skimage import measure

    rng = np.random.default_rng(3)
    for bits in range(1, 255):
        signs = np.array([1.0 if bits >> k & 1 else -1.0 for k in range(8)], np.float32)
        vertices, triangles, *_ = measure.marching_cubes(
            signs.reshape(2, 2, 2), 0.0, method="lorensen", gradient_direction="ascent"
        )
        inside = np.abs(vertices - np.round(vertices)) > 0.1
        for draw in range(2):
            along = rng.random(len(vertices)) if draw else rng.choice([0.01, 0.99], len(vertices))
            audit = audit_mesh(np.where(inside, along[:, None], vertices), triangles)
            assert not len(audit.crossings), bits
            assert not len(audit.overlaps), bits
