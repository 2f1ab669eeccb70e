"""From points to an implicit surface, and from an implicit surface to triangles."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from scipy.spatial import cKDTree

from fieldrecon.datasets.synthetic import uniform
from fieldrecon.kernels.conditionally_positive_definite import polyharmonic
from fieldrecon.methods.functionals import derivatives_at, values_at
from fieldrecon.methods.hermite import HermiteRBF
from fieldrecon.methods.partition_of_unity.method import PartitionOfUnityRBF
from fieldrecon.methods.rbf import RBF
from fieldrecon.pipelines.scans import _percent
from fieldrecon.solids import marching_cubes as surface_extraction
from fieldrecon.solids.constructive import as_solid, blend, morph, transform
from fieldrecon.solids.marching_cubes import extract_surface
from fieldrecon.solids.shapes import Ball, Box, Cylinder, Torus, roughened, sample_surface
from fieldrecon.surfaces import implicit_surfaces, off_surface
from fieldrecon.surfaces.cloud_cleaning import (
    _against,
    _at_boundaries,
    _beside,
    as_clean_cloud,
    noise_of,
    noise_without_curvature,
    outliers,
)
from fieldrecon.surfaces.implicit_surfaces import (
    _box_about,
    _far_points,
    _smoothing_of,
    _warnings,
    implicit_surface,
)
from fieldrecon.surfaces.off_surface import classified_points, off_surface_points, spacing_of
from laws import assert_close

ROTATION = np.linalg.qr(np.random.default_rng(3).standard_normal((3, 3)))[0]
TORUS = Torus(1.0, 0.35)


def cloud(solid, n, seed=1):
    return sample_surface(solid, n, seed)


def spiral(n):
    """Almost uniformly distributed points on the unit sphere."""
    z = 1 - (2 * np.arange(n) + 1) / n
    angle = np.pi * (1 + 5**0.5) * np.arange(n)
    r = np.sqrt(1 - z**2)
    return np.column_stack([r * np.cos(angle), r * np.sin(angle), z])


def order(coarse, fine, ratio):
    return np.log(coarse / fine) / np.log(ratio)


# --- points off the surface -----------------------------------------------------------------------


def nearest_site_is_own(points, off):
    """Carr's check: the nearest site of each off-surface point must be its own site."""
    found, _ = cKDTree(points).query(off.points)
    own = np.linalg.norm(off.points - points[off.sites], axis=1)
    return bool((found >= own * (1 - 1e-9)).all())


@pytest.mark.parametrize("distance", [0.02, 0.2, 5.0])
def test_the_nearest_site_of_an_off_surface_point_is_its_own(distance):
    """This holds on a plate and a torus for any requested distance."""
    for solid in (Box([1.0, 1.0, 0.1]), TORUS):
        points, normals = cloud(solid, 1500)
        off = off_surface_points(points, normals, distance)
        assert nearest_site_is_own(points, off)
        assert (np.abs(off.values) <= distance * (1 + 1e-12)).all()
        assert (np.sign(solid(off.points)) == np.sign(off.values)).mean() > 0.999


def test_without_shrinking_off_surface_points_lie_on_the_wrong_side(monkeypatch):
    """At 1.5 times the thickness of a plate, inner points lie beyond the opposite side."""
    points, normals = cloud(Box([1.0, 1.0, 0.1]), 1500)
    monkeypatch.setattr(off_surface, "_empty_balls", lambda p, *rest: np.full(len(p), rest[-1]))
    off = off_surface_points(points, normals, 0.15)
    assert not nearest_site_is_own(points, off)
    inside = off.values > 0
    assert (Box([1.0, 1.0, 0.1])(off.points[inside]) < 0).mean() > 0.5


def test_radii_of_empty_balls_equal_the_minimum_over_all_pairs():
    """The radius of the largest empty ball is the minimum of |e|² / (2 n · e)."""
    points, normals = cloud(TORUS, 300)
    radius = off_surface._empty_balls(points, -normals, cKDTree(points), 9.0)
    e = points - points[:, None]
    along = -np.einsum("jki,ji->jk", e, normals)
    touching = np.divide(
        (e**2).sum(axis=2), 2 * along, out=np.full(along.shape, 9.0), where=along > 1e-12
    )
    assert_close(radius, np.minimum(touching.min(axis=1), 9.0), 1e-9)


def test_the_balls_off_the_surface_are_as_large_wherever_the_origin_is():
    """Also where coordinates are so large that a shift to twice as far would round them."""
    normals = spiral(200)
    points = np.rint(40 * normals)
    near, far = (off_surface_points(points + shift, normals, 99.0) for shift in (0.0, 2.0**52))
    assert 0 < (np.abs(near.values) < 98).sum() < len(near.values)
    assert far.sites.tolist() == near.sites.tolist()
    assert_close(far.values, near.values, 1e-12)


def test_off_surface_values_are_signed_distances_positive_inside():
    """On the unit ball they are exactly 1 - |x|."""
    points = spiral(400)
    off = off_surface_points(points, points, 0.1)
    assert_close(off.values, 1 - np.linalg.norm(off.points, axis=1), 1e-12)
    assert len(off.values) == 800


def test_the_nearest_site_classifies_points_for_dense_samples():
    """This is the second rule of the book. Near a sharp edge it can be wrong."""
    points, normals = cloud(TORUS, 4000)
    x = np.random.default_rng(2).uniform(-1.4, 1.4, (2000, 3))
    classified = classified_points(points, normals, x)
    assert (np.sign(classified.values) == np.sign(TORUS(classified.points))).mean() > 0.995
    assert np.abs(classified.values - TORUS(classified.points)).max() < 0.2
    wedge = [[0.0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0.0, 1, 0], [0, 1, 0], [1, 0, 0]]
    assert classified_points(*wedge, [[-0.05, -0.06, 0]]).values > 0  # although it is outside
    assert len(classified_points(*wedge, [[-0.06, 0.01, 0]]).values) == 0  # ambiguous


def test_one_point_with_its_normal_classifies_a_half_space():
    """No point has no sides."""
    one = [[0.0, 0, 0]], [[0.0, 0, 2]]
    assert classified_points(*one, [[0, 0, 3.0], [0, 0, -1]]).values.tolist() == [-3, 1]
    with pytest.raises(ValueError, match="at least one point"):
        classified_points(np.zeros((0, 3)), np.zeros((0, 3)), [[0, 0, 1.0]])


def test_the_spacing_is_the_square_root_of_the_area_per_point():
    """The points are a square lattice and random points on a sphere."""
    lattice = np.stack(np.meshgrid(np.arange(40.0), np.arange(40.0), [0.0]), -1).reshape(-1, 3)
    assert spacing_of(lattice) == pytest.approx(1, rel=0.2)
    points, _ = cloud(Ball(1.0), 5000)
    assert spacing_of(points) == pytest.approx(np.sqrt(4 * np.pi / 5000), rel=0.1)


@pytest.mark.parametrize("neighbors", [9, 4])
def test_the_spacing_is_the_edge_of_a_square_with_the_area_of_a_point(neighbors):
    """The disc to the k-th neighbour, the median one, has the area of k such squares."""
    points = np.random.default_rng(4).standard_normal((200, 3))
    radius = np.sort(np.linalg.norm(points[:, None] - points, axis=2), axis=1)[:, neighbors]
    spacing = spacing_of(points + 1e4, neighbors)
    assert neighbors != 9 or spacing == spacing_of(points + 1e4)  # the usual number
    assert neighbors * spacing**2 == pytest.approx(np.pi * np.median(radius) ** 2, rel=1e-9)
    reach = np.linalg.norm(points[:5, None] - points[:5], axis=2).max(axis=1)
    few = spacing_of(points[:5], 99)
    assert 4 * few**2 == pytest.approx(np.pi * np.median(reach) ** 2)


@pytest.mark.parametrize("cosine", [0.0, 0.5, 0.8, 1.0])
def test_points_are_classified_by_the_angle_at_the_nearest_site(cosine):
    """One point after the other."""
    rng = np.random.default_rng(5)
    points, x = rng.standard_normal((40, 3)), rng.standard_normal((300, 3))
    normals = rng.standard_normal((40, 3))
    expected = []
    for k, query in enumerate(x):
        site = np.linalg.norm(points - query, axis=1).argmin()
        ray = query - points[site]
        height = ray @ normals[site] / np.linalg.norm(normals[site])
        if abs(height) / np.linalg.norm(ray) >= cosine:
            expected.append((k, site, -height))
    found = classified_points(points, normals, x, cosine)
    rows, sites, values = np.array(expected).reshape(-1, 3).T
    np.testing.assert_array_equal(found.points, x[rows.astype(int)])
    np.testing.assert_array_equal(found.sites, sites)
    assert_close(found.values, values, 1e-12)
    assert len(classified_points(points, normals, points).values) == 0  # at a site: on no side


@pytest.mark.parametrize("unit", [1e-3, 1.0, 1e3])
def test_points_in_a_gap_of_two_sheets_are_a_quarter_of_it_off(unit):
    """Half the radius of the ball that touches both; none less than a twentieth of the distance."""
    for gap in (0.19, 0.21, 1.0, 3.9, 4.1):
        sheets = unit * np.array([[0, 0, 0], [0, 0, gap]])
        off = off_surface_points(sheets, [[0, 0, 1.0], [0, 0, -1.0]], unit)
        between = (off.points[:, 2] > 0) & (off.points[:, 2] < gap * unit)
        expected = [] if gap < 0.2 else [-min(gap / 4, 1)] * 2
        assert_close(off.values[between] / unit, np.array(expected), 1e-12)
        assert_close(off.values[~between] / unit, np.ones(2), 1e-12)
        assert off.sites.tolist() == ([] if gap < 0.2 else [0, 1]) + [0, 1]


def test_the_last_ball_that_is_not_empty_shrinks_until_it_is():
    """A point whose ball contains others, one after another; the other balls are empty at once."""
    others = np.array([[0, 0, 2.2], [0.9, 0, 1.0]])
    points = np.concatenate([np.zeros((1, 3)), others])
    off = off_surface_points(points, [[0, 0, 1.0], [0, 0, 1.0], [1.0, 0, 0]], 1.0)
    outside = off.values < 0
    assert off.sites[outside].tolist() == [0, 1, 2]
    least = ((others**2).sum(axis=1) / (2 * others[:, 2])).min()
    assert_close(-off.values[outside], np.array([least / 2, 1.0, 1.0]), 1e-12)


# --- the implicit surface -------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("method", ["rbf", "partition", "hermite"])
def test_the_implicit_surface_interpolates_and_is_positive_inside(method):
    """Near the surface F is about the signed distance, and its gradient points inward."""
    points, normals = cloud(TORUS, 700)
    body = implicit_surface(points, method=method)
    assert np.abs(body(body.points)).max() < 1e-9
    x = points - 0.1 * normals
    assert_close(body(x), TORUS(x), 0.05)
    assert body([1.0, 0, 0]) > 0 > body([0.0, 0, 0])
    assert np.einsum("ij,ij->i", body.normals(points), normals).min() > 0.9


def test_the_sign_in_the_text_of_the_book_inverts_the_surface(monkeypatch):
    """With values -d inside, F is negative inside, and the test above would fail."""
    points, normals = cloud(TORUS, 600)

    def with_opposite_sign(*given):
        off = off_surface_points(*given)
        return off_surface.OffSurface(off.points, -off.values, off.sites)

    monkeypatch.setattr(implicit_surfaces, "off_surface_points", with_opposite_sign)
    body = implicit_surface(points, normals, method="rbf")
    assert body([1.0, 0, 0]) < 0
    assert np.einsum("ij,ij->i", body.normals(points), normals).max() < 0


def test_a_sphere_is_reconstructed_with_third_order():
    """With four times as many points the error decreases by a factor of more than eight."""
    errors = []
    for n in (150, 600):
        body = implicit_surface(spiral(n), method="hermite")
        x = spiral(333)
        errors.append(np.abs(body(x)).max())
    assert order(*errors, 2) > 3
    assert errors[1] < 1e-4


@pytest.mark.slow
def test_the_default_interpolates_many_points_by_patches():
    """F vanishes at the points and is small between them."""
    points, _ = cloud(TORUS, 2000)
    body = implicit_surface(points)
    assert np.abs(body(points)).max() < 1e-9
    x, _ = cloud(TORUS, 500, seed=9)
    assert np.abs(body(x)).max() < 0.3 * body.spacing
    assert np.sqrt(np.mean(body(x) ** 2)) < 0.02 * body.spacing


def test_the_surface_does_not_depend_on_origin_axes_and_unit():
    """The surface of transformed points is the transformed surface, also at 1e7 from the origin."""
    points, normals = cloud(TORUS, 500)
    body = implicit_surface(points, normals)
    x = np.random.default_rng(4).uniform(-1.5, 1.5, (300, 3))
    there = implicit_surface(3.0 * points @ ROTATION.T + 7.0, normals @ ROTATION.T)
    assert_close(there(3.0 * x @ ROTATION.T + 7.0), 3.0 * body(x), 1e-7)
    far = implicit_surface(points + 1e7, normals)
    assert_close(far(x + 1e7), body(x), 1e-5)


@pytest.mark.slow
def test_noise_is_estimated_and_smoothed():
    """For noise of a fifth of the spacing, smoothing halves the error."""
    points, normals = cloud(Ball(1.0), 1500)
    spacing = spacing_of(points)
    rough = roughened(points, normals, 0.2 * spacing, seed=8)
    assert noise_of(rough) == pytest.approx(0.2 * spacing, rel=0.2)
    assert noise_of(points) < 0.01 * spacing
    x, _ = cloud(Ball(1.0), 400, seed=9)
    bodies = implicit_surface(rough), implicit_surface(rough, smoothing=0.0)
    errors = [np.sqrt(np.mean(body(x) ** 2)) for body in bodies]
    assert "are smoothed away" in bodies[0].warnings[-1]
    assert errors[0] < 0.5 * errors[1]
    assert errors[0] < 0.1 * spacing


def test_points_far_from_the_surface_have_signed_distances():
    """Beside those on the walls of the box there are some inside and some outside."""
    points, normals = sample_surface(Ball(1.0), 400, seed=1)
    cloud = as_clean_cloud(points, normals)
    far, values = _far_points(cloud, _box_about(cloud))
    between = (np.abs(far) < 0.99 * np.abs(far).max(axis=0)).all(axis=1)
    depth = 1 - np.linalg.norm(far[between], axis=1)
    assert (depth > 0.2).sum() > 10
    assert (depth < -0.2).sum() > 10
    assert_close(values[between], depth, 0.1)


@pytest.mark.parametrize(("n", "levels"), [(100, 1), (400, 2)])
def test_points_far_from_the_surface_are_nodes_of_lattices_and_lie_on_the_walls(n, levels):
    """All nodes, of each step, in a layer around the points; coarser ones only outside.

    Their values are the distances from tangent planes at sites with a normal or direction.
    """
    points, normals = sample_surface(Ball(1.0), n, seed=1)
    given = as_clean_cloud(points, normals)
    given = replace(given, trusted=points[:, 2] > 0, beside=points[:, 0] > 0)
    box, spacing = _box_about(given), given.spacing
    expected, wall = {}, np.linspace(0, 1, implicit_surfaces._WALL)
    for t in product(wall, repeat=3):
        if {*t} & {0, 1}:
            x = box[0] + (box[1] - box[0]) * t
            expected[tuple(x.round(9))] = -np.linalg.norm(points - x, axis=1).min()
    assert 2 ** (levels - 1) <= (box[1] - box[0]).max() / (8 * spacing) < 2**levels
    for level in range(levels):
        step = 2 * spacing * 2**level
        count = np.ceil((box[1] - box[0]) / step).astype(int)
        for index in product(*(range(c) for c in count)):
            x = box[0] + step * (np.array(index) + 0.382)
            site = np.linalg.norm(points - x, axis=1).argmin()
            ray = x - points[site]
            far, value = np.linalg.norm(ray), -ray @ normals[site]
            usable = given.trusted[site] or given.beside[site]
            layer = 0.75 * step < far < 2 * step and abs(value) >= 0.5 * far
            if (x < box[1]).all() and usable and layer and (level == 0 or value < 0):
                expected[tuple(x.round(9))] = value
    found, values = _far_points(given, box)
    assert {*map(tuple, found.round(9).tolist())} == {*expected}
    assert_close(values, np.array([expected[tuple(x)] for x in found.round(9)]), 1e-9)
    assert len(found) == len(expected)


@pytest.mark.parametrize("beside", [-0.49, -0.2, 0.0, 0.2, 0.49])
def test_nodes_of_a_lattice_are_used_up_to_two_steps_from_a_plane(beside):
    """On both sides, and not nearer than 0.75, wherever the plane lies between the layers."""
    y, z = (c.ravel() for c in np.meshgrid(np.arange(9.0), np.arange(17.0)))
    points, normals = np.column_stack([0 * y, y, z]), np.tile([1.0, 0, 0], (153, 1))
    given = as_clean_cloud(points, normals)
    step = 2 * given.spacing
    box = np.array([[-(3 + beside) * step, -1, -1], [3 * step, 9, 17]])
    layers = step * (np.arange(7) - 3 - beside + implicit_surfaces._SHIFT)
    expected = layers[(abs(layers) > 0.75 * step) & (abs(layers) < 2 * step)]
    found, values = _far_points(given, box)
    inner = ((found > box[0] + 1e-9) & (found < box[1] - 1e-9)).all(axis=1)
    assert_close(values[inner], -found[inner, 0], 1e-12)
    assert np.unique(found[inner, 0].round(9)).tolist() == expected.round(9).tolist()
    lines = -1 + step * (np.arange(9) + implicit_surfaces._SHIFT)
    beyond = inner & ((found[:, 1:] > 0) & (found[:, 1:] < [8, 16])).all(axis=1)
    count = [((lines > 0) & (lines < width)).sum() for width in (8, 16)]
    assert beyond.sum() == len(expected) * count[0] * count[1]


@pytest.mark.parametrize(("n", "method"), [(700, RBF), (701, PartitionOfUnityRBF)])
def test_up_to_700_points_are_interpolated_by_one_system(n, method):
    """And more by a partition of unity, if no method is given."""
    body = implicit_surface(spiral(n), spiral(n), smoothing=0.0)
    assert type(body.field.method) is method


def test_from_points_and_normals_the_kernel_is_that_of_least_energy():
    """That is r^3, whose data are the values 0 and the slopes -1 along the normals."""
    points, normals = cloud(TORUS, 60)
    data = [values_at(points), derivatives_at(points, normals)]
    field = HermiteRBF(data, polyharmonic(3)).field(np.repeat([0.0, -1.0], 60))
    x = 0.9 * points
    body = implicit_surface(points, normals, method="hermite")
    assert_close(body(x), field(x), 1e-9)
    assert body.smoothing == 0
    assert body.warnings == ()


def test_points_off_the_surface_are_a_spacing_away_or_as_far_as_given():
    points, normals = cloud(TORUS, 300)
    usual, same, nearer = (
        implicit_surface(points, normals, smoothing=0.0, distance=distance)
        for distance in (None, spacing_of(points), spacing_of(points) / 3)
    )
    x = 0.9 * points
    assert_close(same(x), usual(x), 1e-12)
    assert np.abs(nearer(x) - usual(x)).max() > 1e-3


def test_distances_are_those_to_first_order():
    """|F| over |grad F|, of the points that were used by default."""
    points, normals = cloud(TORUS, 300)
    body = implicit_surface(points, normals, method="hermite")
    x = points[:50] + 0.03 * np.random.default_rng(1).standard_normal((50, 3))
    steep = np.linalg.norm(body.gradient(x), axis=1)
    assert_close(body.distances(x), np.abs(body(x)) / steep, 1e-12)
    assert body.distances(x.reshape(5, 10, 3)).shape == (5, 10)
    assert body.distances().shape == (300,)
    assert body.distances().max() < 1e-9
    assert_close(body.distances(x), np.abs(TORUS(x)), 0.02)
    ball = implicit_surfaces.ImplicitSurface(as_clean_cloud(points, normals), Ball(2.0), 0.0)
    assert ball.distances([0.0, 0, 0]) == 2.0  # where grad F is zero, |F|


@pytest.mark.parametrize("unit", [1e-200, 1e-3, 1.0, 1e3, 1e200])
def test_the_longest_smoothed_waves_have_half_the_width_of_a_cloud(unit):
    """Its second largest extent along its principal axes."""
    arms = np.diag([3.0, 1.0, 0.3])
    cross = unit * (np.vstack([arms, -arms]) @ ROTATION.T + 2.0)
    assert implicit_surfaces._longest_smoothed(cross) == pytest.approx(unit)


def test_shares_have_two_digits():
    """Only a share that is nearly all has three."""
    shares = (0.00123, 0.0456, 0.123, 0.99, 0.996, 1.0)
    assert [_percent(s) for s in shares] == [
        *("0.12 %", "4.6 %", "12 %", "99 %", "100 %", "100 %"),
    ]


def test_few_exact_points_of_a_sphere_give_the_sphere():
    """Their curvature is not taken for noise, in any unit and for any method with points off it."""
    for n, unit in ((8, 1.0), (10, 1e-6), (12, 1e6), (16, 1.0), (24, 1.0), (48, 1.0)):
        points = spiral(n) @ ROTATION.T
        body = implicit_surface(points * unit, points)
        assert np.abs(body(points * unit)).max() < 0.003 * unit
        assert body([0, 0, 0.0]) > 0.6 * unit
        assert extract_surface(body, 0.15 * unit).volume == pytest.approx(
            4 / 3 * np.pi * unit**3, rel=0.06
        )
        assert extract_surface(body).volume == pytest.approx(4 / 3 * np.pi * unit**3, rel=0.06)
        bounded = any("too few to tell noise from curvature" in w for w in body.warnings)
        assert bounded == (n < 48)
    rough = roughened(*cloud(Ball(1.0), 300), 0.1 * spacing_of(cloud(Ball(1.0), 300)[0]), seed=8)
    body = implicit_surface(rough)
    assert body.smoothing == 10 * np.sqrt(body.noise * body.spacing) > 0.5


@pytest.mark.parametrize("axes", [(1, 1, 1), (1, 1, 1.5), (1, 2, 3), (1, 1, 0.3), (1, 0.5, 0.2)])
def test_curvature_between_exact_points_is_not_reported_as_noise(axes):
    """Nor smoothed away, unless the points are too few to tell the two apart."""
    for n in (8, 12, 20, *range(30, 200, 5), 200, 300, 460, 500, 1000):
        given = as_clean_cloud(spiral(n) * axes, spiral(n) / axes)
        warnings = _warnings(given, _smoothing_of(given))
        assert not any("off a smooth surface" in warning for warning in warnings), n


def test_noise_is_reported_where_points_suffice_to_tell_it_from_curvature():
    """Noise of 2 % of the radius; in the estimate the curvature between the points is small."""
    normals = spiral(500)
    height = 1 + 0.02 * np.random.default_rng(3).standard_normal((500, 1))
    for given in (normals, None):
        warnings = implicit_surface(normals * height, given).warnings
        assert "The points are about 0.019 off a smooth surface" in warnings[-1]
    assert noise_without_curvature(normals * height) == pytest.approx(0.02, rel=0.1)
    assert noise_without_curvature(spiral(50)) == 0.0
    assert "are about" not in "".join(implicit_surface(spiral(50), spiral(50)).warnings)


@pytest.mark.slow
def test_smoothing_halves_waves_of_the_smoothing_length():
    """On a wavy plane nearly all of twice that wavelength is kept and little of half of it."""
    i = np.arange(-12, 13) / 12.0
    x, y = (c.ravel() for c in np.meshgrid(i, i))
    remaining = []
    for wave in (0.25, 0.5, 1.0):
        height = 0.01 * np.cos(2 * np.pi * x / wave)
        points = np.column_stack([x, y, height])
        body = implicit_surface(
            points, np.tile([0.0, 0, 1], (len(x), 1)), method="rbf", distance=1 / 12, smoothing=0.5
        )
        inner = np.maximum(np.abs(x), np.abs(y)) < 0.6
        below = body(np.column_stack([x, y, 0 * x]))[inner]
        remaining.append(below @ height[inner] / (height[inner] @ height[inner]))
    assert remaining[0] < 0.12
    assert remaining[1] == pytest.approx(0.5, abs=0.12)
    assert remaining[2] > 0.9


@pytest.mark.parametrize(("count", "says"), [(1, "1 point repeats"), (2, "2 points repeat")])
def test_the_sentence_on_repeated_points_has_their_number(count, says):
    points = cloud(TORUS, 100)[0]
    given = as_clean_cloud(*[np.concatenate([points, points[:count]])] * 2)
    assert given.warnings[0].startswith(f"{says} others and count")


@pytest.mark.slow
def test_repeated_points_and_outliers_are_skipped_and_reported():
    """They do not change the surface; the warnings give their numbers."""
    points, _ = cloud(TORUS, 600)
    alone = [[3.0, 0, 0], [0, 0, 2.0]]
    body = implicit_surface(np.vstack([points, points[:5], alone]))
    assert body.left_out.tolist() == list(range(600, 607))
    assert "5 points repeat others" in body.warnings[0]
    assert "2 points lie apart from all others" in body.warnings[1]
    assert_close(body(TORUS.box), implicit_surface(points)(TORUS.box), 1e-9)


@pytest.mark.parametrize("apart", [1, 2, 3])
def test_a_point_and_a_pair_lie_apart_but_three_points_do_not(apart):
    """Points with one other point near by at most, as others have eight; of any density."""
    sheet = np.column_stack([*uniform(300, 2, seed=0).T, np.zeros(300)])
    sheet[:, 0] **= 3  # denser towards one side
    lonely = np.array([[0.5, 0.5, 2.0], [0.5, 0.5, 2.01], [0.5, 0.51, 2.0]])[:apart]
    found = outliers(np.vstack([lonely, sheet]))
    assert found[:apart].tolist() == [apart < 3] * apart
    assert found[apart:].mean() < 0.01


def test_a_point_apart_has_more_than_the_reach_of_its_neighbours_to_the_second_one():
    """One point after the other: half as far again as those reach to their eighth neighbours."""
    points = np.random.default_rng(0).standard_normal((200, 3)) ** 3
    distance = np.linalg.norm(points[:, None] - points, axis=2)
    reach, order = np.sort(distance, axis=1), distance.argsort(axis=1)
    literal = [
        reach[k, 2] > 1.5 * np.median([reach[j, 8] for j in order[k, 1:9]]) for k in range(200)
    ]
    assert outliers(points).tolist() == literal
    assert 0 < sum(literal) < 20
    assert not outliers(points[:9] * [1, 1, 1e9]).any()  # too few to be compared


def test_points_lie_apart_and_have_noise_wherever_the_origin_is():
    """Also where coordinates are so large that a shift to twice as far would round them."""
    points = np.rint(2 * np.random.default_rng(0).standard_normal((200, 3)) ** 3)
    points = np.unique(points, axis=0)
    far = points + 2.0**52
    assert (far - 2.0**52 == points).all()
    assert 0 < outliers(points).sum() < 20
    assert outliers(far).tolist() == outliers(points).tolist()
    assert noise_of(far) == pytest.approx(noise_of(points), rel=1e-9)


@pytest.mark.parametrize("n", [300, 7, 6])
def test_the_noise_is_the_deviation_from_paraboloids_through_twelve_points(n):
    """Over the plane of the neighbours, with one degree of freedom less for each coefficient."""
    points = spiral(n) * (1 + 0.05 * np.random.default_rng(0).standard_normal((n, 1)))
    literal, k = [], min(12, n)
    for point in points:
        near = points[np.linalg.norm(points - point, axis=1).argsort()[:k]]
        near = near - near.mean(axis=0)
        x, y, height = (near @ np.linalg.svd(near)[2].T).T
        basis = np.column_stack([np.ones(k), x, y, x * x, x * y, y * y])
        rest = height - basis @ np.linalg.lstsq(basis, height)[0]
        literal.append(np.sqrt(rest @ rest / (k - 6)) if k > 6 else 0.0)
    assert noise_of(points) == pytest.approx(np.median(literal), rel=1e-6)


@pytest.mark.parametrize("unit", [1e-3, 1.0, 1e3])
@pytest.mark.parametrize(
    ("far", "opposite", "known", "against"),
    [
        (1.0, 1.0, True, True),
        (2.0, 1.0, True, True),  # the nearer one counts four times as much
        (1.0, 0.0, True, False),
        (1.0, 0.29, True, False),
        (1.0, 0.31, True, True),
        (1.0, 1.0, False, False),
    ],
)
def test_a_direction_that_its_neighbours_contradict_is_rejected(
    far, opposite, known, against, unit
):
    """The mean of their cosines, by inverse squared distances, is less than -0.3."""
    points = unit * np.array([[0, 0, 0], [1, 0, 0], [-far, 0, 0], [0, 1, 0], [0, 0, 0]])
    aside = np.sqrt(1 - opposite**2)
    directions = np.array([[0, 0, 1.0], [0, aside, -opposite], [0, aside, -opposite], [0, 0, 1.0]])
    directions = np.vstack([directions, directions[:1]])
    if far == 2:
        directions[2] = [0, 0, 1.0]
    mask = np.array([True, known, known, False, True])
    neighbors = np.array([[0, 4, 1, 2, 3]] * 5)
    assert _against(points, directions, mask, neighbors)[0] == against


def test_a_cloud_of_which_most_points_have_no_normal_is_reported():
    given = as_clean_cloud(spiral(40), spiral(40))
    for known, reported in ((19, True), (20, False)):
        found = implicit_surfaces._warnings(replace(given, trusted=np.arange(40) < known), 0.0)
        assert [w.startswith("Most points have no normal") for w in found] == [True] * reported


@pytest.mark.slow
def test_points_at_edges_without_normals_are_reported():
    """The surface of a box stays within one spacing of it and rounds its edges."""
    solid = Box([1.0, 1.0, 0.4])
    body = implicit_surface(cloud(solid, 1000)[0])
    assert "have no normal" in body.warnings[0]
    given = as_clean_cloud(*cloud(solid, 1000))
    assert given.trusted.all()
    assert not given.beside.any()
    mesh = extract_surface(body)
    assert mesh.audit.clean
    assert mesh.audit.parts == 1
    assert np.abs(solid(mesh.points)).max() < body.spacing
    assert mesh.volume == pytest.approx(0.4, rel=0.03)


@pytest.mark.parametrize("solid", [Box([1.0, 1.0, 0.4]), Cylinder(1.0, 1.0)], ids=["box", "can"])
def test_directions_at_edges_are_unit_vectors_that_point_outward(solid):
    """There no plane fits, and they lie between the normals of the faces."""
    found = as_clean_cloud(cloud(solid, 1000)[0], None)
    assert 0 < found.beside.sum() < 0.1 * len(found.points)
    assert not (found.trusted & found.beside).any()
    known = found.trusted | found.beside
    points, outward = found.points[known], found.outward[known]
    assert_close(np.linalg.norm(outward, axis=1), np.ones(len(points)), 1e-12)
    assert (solid(points + 0.2 * found.spacing * outward) < 0).all()
    assert (solid(points - 0.2 * found.spacing * outward) > 0).all()


@pytest.mark.parametrize("unit", [1e-3, 1.0, 1e3])
@pytest.mark.parametrize(("angle", "share"), [(0, 1.0), (30, 0.75), (60, 0.25), (90, 0.0)])
def test_neighbours_count_by_the_squared_cosine_of_their_elevation(angle, share, unit):
    """Those in the tangent plane count fully, and those across a thin sheet do not."""
    angle = np.deg2rad(angle)
    points = unit * np.array([[0, 0, 0], [np.cos(angle), 0, -np.sin(angle)]])
    normals = np.array([[0, 0, 1.0]] * 2)
    assert_close(_beside(points, normals, np.array([[1], [0]])), [[share]] * 2, 1e-14)


@pytest.mark.parametrize("unit", [1e-3, 1.0, 1e3])
@pytest.mark.parametrize("side", [1.0, -1.0], ids=["sheet", "slit"])
def test_the_rim_of_a_sheet_looks_away_from_it_and_that_of_a_slit_into_it(side, unit):
    """Where no normals are known, or in the middle, the direction is not known."""
    x, y, z = (axis.ravel() for axis in np.meshgrid([0, -1, -2, -3], [-1, 0, 1], [0.1, -0.1]))
    points = np.array([[0, 0, 0], *np.column_stack([x, y, z]), [-1.5, 0, 0]])
    normals = np.where(points[:, 2:] > 0, side, -side) * [0, 0, 1]
    trusted = points[:, 2] != 0
    around = np.arange(1, 25)
    neighbors = np.array([[0, *around], [25, *around]])
    turned = unit * points @ ROTATION + 3 * unit
    directions, known = _at_boundaries(turned, normals @ ROTATION, trusted, neighbors)
    assert known.tolist() == [True, False]
    assert_close(directions, np.array([[side, 0, 0], normals[25]]) @ ROTATION, 1e-12)
    assert not _at_boundaries(turned, normals, np.zeros(26, dtype=bool), neighbors)[1].any()


@pytest.mark.slow
def test_a_sheet_two_spacings_thick_has_two_sides():
    """Neighbours on both sides must not be fitted by one plane."""
    solid = Box([0.44, 0.44, 0.04])
    body = implicit_surface(cloud(solid, 1100)[0])
    assert 1.5 < 0.04 / body.spacing < 2.5
    assert body([0, 0, 0.0]) > 0 > max(body([0, 0, 0.04]), body([0, 0, -0.04]))
    mesh = extract_surface(body, within=2 * body.spacing)
    inner = np.abs(mesh.points[:, :2]).max(axis=1) < 0.17
    assert np.abs(np.abs(mesh.points[inner, 2]) - 0.02).max() < 0.5 * body.spacing


@pytest.mark.slow
def test_noise_raises_no_bulge_at_the_edges_of_a_plate():
    """The plate is three spacings thick, and its points have noise of 0.28 spacings.

    No vertex is farther than 1.2 spacings from the plate, and the root mean square is below the
    noise. Outward directions from 32 neighbours of both sides made bulges of six spacings.
    """
    solid = Box([0.7, 0.7, 0.08])
    points, _ = cloud(solid, 1250)
    spacing = spacing_of(points)
    rough = points + 0.28 * spacing * np.random.default_rng(6).standard_normal(points.shape)
    body = implicit_surface(rough)
    distance = solid(extract_surface(body).points) / spacing
    assert np.abs(distance).max() < 1.2
    assert np.sqrt(np.mean(distance**2)) < 0.28


@pytest.mark.slow
def test_a_sheet_thinner_than_half_the_spacing_is_reported_as_noisy():
    """Given normals and no smoothing, the two sides are reconstructed."""
    solid = Box([0.6, 0.6, 0.01])
    points, normals = cloud(solid, 1500)
    assert "are about 0.005 off a smooth surface" in implicit_surface(points).warnings[-1]
    body = implicit_surface(points, normals, smoothing=0.0)
    assert body.warnings == ()
    assert body([0, 0, 0.0]) > 0 > max(body([0, 0, 0.02]), body([0, 0, -0.02]))


@pytest.mark.slow
def test_half_a_ball_is_closed_within_its_box(monkeypatch):
    """Without the constraints far from the points the surface extends to the sides of the box."""
    points = spiral(900)
    points = points[points[:, 2] > 0]
    mesh = extract_surface(implicit_surface(points, points, method="partition"))
    assert mesh.audit.clean
    assert len(mesh.cut) == 0
    nothing = np.empty((0, 3)), np.empty(0)
    monkeypatch.setattr(implicit_surfaces, "_far_points", lambda *_: nothing)
    free = implicit_surface(points, points, method="partition")
    assert len(extract_surface(free).cut) > 100


# --- triangles ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("solid", "volume", "area"),
    [
        (Ball(1.0), 4 / 3 * np.pi, 4 * np.pi),
        (TORUS, 2 * np.pi**2 * 0.35**2, 4 * np.pi**2 * 0.35),
    ],
)
def test_volume_and_area_converge_with_second_order(solid, volume, area):
    """The reference values are the formulas for a ball and a torus."""
    meshes = [extract_surface(solid, h) for h in (0.1, 0.05)]
    for measure, exact in (("volume", volume), ("area", area)):
        errors = [abs(getattr(mesh, measure) - exact) for mesh in meshes]
        assert order(*errors, 2) == pytest.approx(2, abs=0.2)
        assert errors[1] < 0.006 * exact


BODIES = {
    "ball": Ball(1.0),
    "edges": Box([1.0, 1.2, 0.7]) - Cylinder(0.3, 3.0),
    "two bodies": Ball(0.5) | Ball(0.6, [2.0, 0, 0]),
    "cavity": Ball(1.0) - Ball(0.5),
    "blend": blend(Ball(0.7), Box([0.5, 0.5, 2.0]), 0.3),
    "between": morph(Ball(0.8), TORUS, 0.5),
    "plate": Box([1.0, 1.0, 0.21]),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", BODIES)
def test_meshes_are_clean_and_lie_on_the_zero_level(name):
    """The audit finds no errors, volumes are positive, and |F| < 2e-6 spacings at the vertices."""
    mesh = extract_surface(BODIES[name], 0.05)
    assert mesh.audit.found == {}
    assert mesh.volume > 0
    assert np.abs(BODIES[name](mesh.points)).max() < 2e-6 * mesh.spacing
    assert mesh.audit.parts == {"two bodies": 2, "cavity": 2}.get(name, 1)


@pytest.mark.slow
def test_meshes_of_arbitrary_fields_are_clean():
    """The field has waves in all directions, some of them shorter than a cell."""
    k = 9 * np.random.default_rng(5).standard_normal((12, 3))

    class Waves:
        def __call__(self, x):
            return np.sin(x @ k.T).sum(axis=-1)

        def gradient(self, x):
            return np.cos(x @ k.T) @ k

    mesh = extract_surface(as_solid(Waves(), [[-1, -1, -1], [1, 1, 1]]), 0.12)
    assert mesh.audit.found == {}
    assert len(mesh.cut) > 0


def test_linear_interpolation_misses_the_zero_level(monkeypatch):
    """Without further steps the error at the vertices is of the order of the squared cell size."""
    monkeypatch.setattr(surface_extraction, "_MAX_STEPS", 0)
    mesh = extract_surface(Ball(1.0), 0.1)
    assert np.abs(Ball(1.0)(mesh.points)).max() > 1e-4


def test_the_extraction_follows_the_component_of_a_given_point():
    """One point gives the whole torus, but only one of two balls."""
    mesh = extract_surface(TORUS, 0.1, near=[[1.35, 0, 0]])
    assert len(mesh.triangles) == len(extract_surface(TORUS, 0.1).triangles)
    one = extract_surface(BODIES["two bodies"], 0.1, near=[[0.5, 0, 0]])
    assert one.audit.parts == 1


def test_the_number_of_evaluations_grows_with_the_area():
    """It is proportional to the area and not to the volume.

    Each vertex takes two nodes of the grid and about three points on its edge, and no gradient.
    """
    counts, evaluations = [], []

    class Counted:
        def __call__(self, x):
            counts[-1] += len(x)
            return TORUS(x)

        def gradient(self, x):
            raise AssertionError(f"a gradient was computed at {len(x)} points")

    near = sample_surface(TORUS, 2000, seed=1)[0]
    for h in (0.1, 0.05):
        counts.append(0)
        mesh = extract_surface(as_solid(Counted(), TORUS.box, near), h)
        evaluations.append(counts[-1] / len(mesh.points))
    assert order(counts[1], counts[0], 2) == pytest.approx(2, abs=0.3)
    assert max(evaluations) < 6


def test_a_surface_that_leaves_the_box_is_closed_at_its_sides():
    """Half of a ball gets a flat side, one cell outside the box; `cut` lists its vertices."""
    mesh = extract_surface(Ball(1.0), 0.1, box=[[-1.2, -1.2, -1.2], [1.2, 1.2, 0.0]])
    assert mesh.audit.clean
    assert_close(mesh.points[mesh.cut, 2], np.full(len(mesh.cut), 0.1), 1e-6)
    assert len(extract_surface(Ball(1.0), 0.1).cut) == 0


@pytest.mark.slow
def test_holes_stay_open_with_the_argument_within():
    """A sphere without a cap is closed by default; with `within` it has one boundary loop."""
    points = spiral(800)
    body = implicit_surface(points[points[:, 2] < 0.8], points[points[:, 2] < 0.8])
    closed = extract_surface(body)
    assert closed.audit.clean
    assert closed.volume == pytest.approx(4 / 3 * np.pi, rel=0.03)
    assert extract_surface(body, within=2 * body.spacing).audit.found == {"boundary_loops": 1}


def test_points_far_from_the_surface_are_reported():
    """The points lie on a sphere, and one at its centre."""
    mesh = extract_surface(Ball(1.0), 0.1, near=[*spiral(500), [0, 0, 0]])
    assert mesh.missed.tolist() == [500]


@pytest.mark.slow
def test_tiny_components_are_removed(monkeypatch):
    """A ball with a radius of 1.2 cells is removed; one of 2.4 cells is kept."""
    parts = {}
    for speck in (0, surface_extraction._SPECK):
        monkeypatch.setattr(surface_extraction, "_SPECK", speck)
        for cells in (2, 4):
            small = Ball(0.06 * cells, [1.0, 0, 0])
            near = [[0.5, 0, 0], [1.0, 0, 0.06 * cells]]
            parts[speck, cells] = extract_surface(Ball(0.5) | small, 0.1, near=near).audit.parts
    assert parts == {(0, 2): 2, (0, 4): 2, (3, 2): 1, (3, 4): 2}


@pytest.mark.parametrize(
    ("extents", "kept"), [([3, 2, 9], [3, 9]), ([2, 1, 2], [2, 2]), ([1], [1]), ([4, 3], [4, 3])]
)
def test_parts_of_three_cells_and_those_of_the_largest_extent_are_kept(extents, kept):
    """Each part is one triangle along an axis."""
    lower = np.concatenate([[[0, 0, 0], [k, 0, 0], [0, 0, 0]] for k in extents])
    ends = lower, np.arange(len(lower)) % 3
    triangles = np.arange(len(lower)).reshape(-1, 3)
    (left, axis), found = surface_extraction._without_specks(ends, triangles)
    assert left[1::3, 0].tolist() == kept
    assert axis.tolist() == [0, 1, 2] * len(kept)
    assert found.tolist() == triangles[: len(kept)].tolist()


def test_meshes_far_from_the_origin_are_clean():
    """At 1e8 cells from the origin rounding moves vertices by about 2e-8 cells."""
    mesh = extract_surface(transform(TORUS, ROTATION, [1e7, -1e7, 1e7]), 0.1)
    assert mesh.audit.found == {}
    assert mesh.volume == pytest.approx(extract_surface(transform(TORUS, ROTATION), 0.1).volume)


@pytest.mark.parametrize(
    ("near", "spacing", "expected"),
    [
        (False, None, 3 / 64),  # of the longest side of the box
        (True, None, 3 / 64),
        (False, 0.7, 0.7),
        (True, 0.1, 0.1),
        (True, 0.7, 2 / 12),  # of the extent of the points
        (True, 0.01, 0.01),
    ],
)
def test_cells_are_by_default_as_large_as_the_spacing_of_the_points(near, spacing, expected):
    """But no more than a 12th of these; and a 64th of the box if no spacing is known."""
    box = np.array([[-1.5] * 3, [1.5, 1.0, 1.0]])
    body = as_solid(Ball(1.0), box, np.vstack([np.eye(3), -np.eye(3)]) if near else None, spacing)
    assert surface_extraction._usual_spacing(body, box) == pytest.approx(expected)
    few = as_solid(Ball(1.0), box, 0.1 * np.eye(3), 0.7)
    assert surface_extraction._usual_spacing(few, box) == pytest.approx(3 / 64)


def test_the_grid_extends_beyond_the_box_by_a_cell_and_a_half():
    """And on each side by the same length, of less than two cells."""
    rng = np.random.default_rng(1)
    for _ in range(50):
        low, spacing = rng.normal(size=3), rng.uniform(0.05, 0.5)
        high = low + spacing * rng.choice([1.0, 2.5, 3.0, 4.999, 5.001], 3)
        grid = surface_extraction.Grid.over(np.array([low, high]), spacing)
        top = grid.nodes(np.array(grid.shape) - 1)
        for beyond in (low - grid.low, top - high):
            assert (beyond > (1.5 - 1e-9) * spacing).all()
            assert (beyond < (2 + 1e-9) * spacing).all()
        assert_close(low - grid.low, top - high, 1e-12)
        assert grid.cells == tuple(n - 1 for n in grid.shape)


@pytest.mark.parametrize("body", [Ball(0.3, [0.13, 0.2, -0.1]), Box([0.9, 0.1, 0.7])])
def test_the_search_looks_into_coarse_cells_with_two_signs_or_the_surface_near_their_middle(body):
    """Cell by cell: four cells along each edge, as far as the grid goes."""
    grid = surface_extraction.Grid.over(np.array([[-0.6, -0.4, -0.5], [0.55, 0.5, 0.45]]), 0.09)
    expected, step = set(), 4 * grid.spacing
    for first in product(*(range(0, n, 4) for n in grid.cells)):
        corner = grid.nodes(np.array(first))
        signs = {bool(body(corner + step * np.array(c)) > 0) for c in product((0, 1), repeat=3)}
        middle = corner + step / 2
        if len(signs) == 2 or abs(body(middle)) <= np.sqrt(3) / 2 * step:
            within = (np.array(first) + np.array(k) for k in product(range(4), repeat=3))
            expected |= {tuple(map(int, k)) for k in within if (k < grid.cells).all()}
    found = np.unravel_index(surface_extraction.search_box(body, grid), grid.cells)
    assert {*zip(*(axis.tolist() for axis in found), strict=True)} == expected
    assert 0 < len(expected) < np.prod(grid.cells)


@pytest.mark.parametrize(
    ("body", "points"),
    [
        (Ball(0.3, [0.13, 0.2, -0.1]), [[0.43, 0.2, -0.1]]),
        (Box(0.6) - Ball(0.2), [[0.3, 0, 0], [0, 0.2, 0]]),
        (
            as_solid(Ball(3.0, [-1.7, 1.7, 1.7]), [[-0.4] * 3, [0.4, 0.5, 0.6]]),
            [[0.03, -0.03, -0.03]],
        ),
    ],
    ids=["ball", "cavity", "cut off"],
)
def test_a_surface_is_followed_through_every_cell_that_it_crosses(body, points):
    """Once through each, from one of each part to the ends of the grid; progress counts nodes."""
    grid = surface_extraction.Grid.over(body.box, 0.07)
    index = np.stack(np.meshgrid(*map(np.arange, grid.shape), indexing="ij"), axis=-1)
    inside = body(grid.nodes(index)) > 0
    views = [inside[tuple(slice(k, k - 1 or None) for k in c)] for c in product((0, 1), repeat=3)]
    crossed = np.flatnonzero(np.any(views, axis=0) & ~np.all(views, axis=0))
    told = []
    for some in (surface_extraction.search_box(body, grid), grid.cells_of(np.array(points))):
        told.clear()
        values, found = surface_extraction.follow_surface(
            body, grid, some, progress=lambda *counts: told.append(counts)
        )
        np.testing.assert_array_equal(np.sort(found), crossed)
        known = np.isfinite(values)
        assert_close(values[known], body(grid.nodes(index[known])), 1e-6)
        assert known.ravel()[grid.corners(crossed)].all()
        done, total = np.array(told).T
        assert (np.diff(done) >= 0).all()
        assert (done <= total).all()
        assert done[-1] == total[-1] == known.sum()


@pytest.mark.parametrize("shift", [0.0, 2.0**52])
def test_the_volume_of_a_cube_is_exact_wherever_it_is(shift):
    """Two triangles on each side, with corners that are integers."""
    corners = np.array([*product((0, 1), repeat=3)])
    sides = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    halves = [t for a, b, c, d in sides for t in ([a, b, c], [a, c, d])]
    none = np.empty(0, dtype=np.intp)
    cube = surface_extraction.ExtractedSurface(
        3.0 * corners + shift, np.array(halves), Box(3.0), 1.0, none, none
    )
    assert cube.volume == 27.0
    assert cube.area == 54.0


def test_points_are_missed_farther_than_two_cells_from_all_vertices():
    """Along the normals of a ball, outward."""
    vertices = extract_surface(Ball(1.0), 0.1).points[::9]
    for cells, missed in ((0.0, False), (1.99, False), (2.01, True), (3.0, True)):
        near = np.vstack([spiral(500), vertices * (1 + 0.1 * cells)])
        found = extract_surface(Ball(1.0), 0.1, near=near).missed
        assert found.tolist() == [500 + k for k in range(len(vertices)) if missed]


def test_triangles_with_a_corner_farther_than_within_are_dropped():
    """The others keep their places; and so do the vertices at the wall of the box."""
    near = spiral(300)[:110]
    box = np.array([[-1.2, -1.2, -1.2], [0.4, 1.2, 1.2]])
    whole = extract_surface(Ball(1.0), 0.1, near=near, box=box)
    part = extract_surface(Ball(1.0), 0.1, near=near, box=box, within=0.3)
    close = np.linalg.norm(whole.points[:, None] - near, axis=2).min(axis=1) <= 0.3
    kept = whole.triangles[close[whole.triangles].all(axis=1)]
    np.testing.assert_array_equal(part.points[part.triangles], whole.points[kept])
    used = np.intersect1d(whole.cut, kept)
    np.testing.assert_array_equal(part.points[part.cut], whole.points[used])
    assert 0 < len(used) < len(whole.cut)
    assert len(part.points) == len(np.unique(kept))


@pytest.mark.parametrize(("shift", "unit"), [(0.0, 1.0), (2.0**24, 2.0**-10)])
def test_vertices_at_nodes_of_the_grid_stay_apart(shift, unit):
    """At a corner of a cavity that is a node, three edges of the grid have a vertex.

    These are a millionth of an edge apart, or, far from the origin, dozens of roundings.
    """
    body = transform(Box(2.0) - Box(1.0), shift=[shift] * 3, scale=unit)
    mesh = extract_surface(
        body, 0.25 * unit, box=[[shift - 1.375 * unit] * 3, [shift + 1.375 * unit] * 3]
    )
    assert mesh.audit.clean
    least = max(1e-6 * mesh.spacing, 64 * np.spacing(shift))
    assert np.abs(body(mesh.points)).max() < 2 * least
    nearest = cKDTree(mesh.points - shift).query(mesh.points - shift, 2)[0][:, 1]
    assert 0.5 * least < nearest.min() < 2 * least


def test_a_grid_may_have_as_many_nodes_as_are_allowed(monkeypatch):
    """And where it would have more, the proposed spacing is accepted, and hardly coarser."""
    monkeypatch.setattr(surface_extraction, "NODE_LIMIT", 1000)
    cube = np.array([[0.0] * 3, [6.0] * 3])
    assert surface_extraction.Grid.over(cube, 1.0).shape == (10, 10, 10)
    for spacing in np.geomspace(0.01, 0.99, 40):
        with pytest.raises(ValueError, match=r"at most 1e\+03 are allowed; take") as refusal:
            surface_extraction.Grid.over(cube, spacing)
        proposed = float(str(refusal.value).split()[-3])
        assert surface_extraction.Grid.over(cube, proposed).shape == (10, 10, 10)
        assert 1.0 <= proposed < 1.06


# --- refusals -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: off_surface_points(spiral(9), spiral(8)), r"shape of the points, \(9, 3\); got"),
        (lambda: off_surface_points(spiral(9), 0 * spiral(9)), r"normals\[0\] is zero"),
        (lambda: off_surface_points(spiral(9), spiral(9), 0.0), "distance must be a positive"),
        (lambda: classified_points(spiral(9), spiral(9), spiral(2), 2.0), "cosine must be from 0"),
        (lambda: classified_points(spiral(9), spiral(9), [[1.0, 2]]), r"x must have the shape"),
        (lambda: implicit_surface(spiral(90), method="mls"), "one of rbf, partition, hermite; got"),
        (lambda: implicit_surface(spiral(90), method="hermite", smoothing=0.1), "takes smoothing"),
        (lambda: implicit_surface(spiral(90), smoothing=-1.0), "smoothing must be zero or a pos"),
        (lambda: extract_surface(np.sin), "as_solid makes one of a field"),
        (lambda: extract_surface(Ball(1.0), 1e-4), r"would take 8e\+12 nodes in the box"),
        (lambda: extract_surface(Ball(1.0), 0.0), "spacing must be a positive number"),
        (lambda: extract_surface(Ball(1.0), near=[[9.0, 0, 0]]), "F has one sign there"),
        (lambda: extract_surface(Ball(1.0), within=1.0), "within needs points near the surface"),
    ],
)
def test_invalid_arguments_are_refused(call, words):
    """The message names the argument, what came and what was wanted."""
    with pytest.raises(ValueError, match=words):
        call()


def test_points_that_determine_no_surface_are_refused():
    """All points coincide or lie on a line."""
    with pytest.raises(np.linalg.LinAlgError, match="at least four different points; got 1"):
        implicit_surface(np.ones((9, 3)))
    with pytest.raises(np.linalg.LinAlgError, match="no plane fits the neighbours"):
        implicit_surface(np.arange(30.0)[:, None] * [1.0, 2.0, 3.0])


def test_the_box_about_a_cloud_has_a_margin():
    """It has four spacings, or a tenth of the length of the cloud if this is more."""
    t = np.arange(12) * np.pi / 6
    around = np.column_stack([np.cos(t), np.sin(t), np.zeros(12)])
    for length, margin in ((1.0, None), (10.0, 1.0)):
        along = np.linspace(0, length, round(20 * length) + 1)
        tube = 0.1 * around[:, None] + along[:, None] * [0, 0, 1]
        cloud = as_clean_cloud(tube.reshape(-1, 3), np.repeat(around, len(along), axis=0))
        box = np.array([[-0.1, -0.1, 0.0], [0.1, 0.1, length]])
        wanted = 4 * cloud.spacing if margin is None else margin
        assert_close(np.abs(_box_about(cloud) - box), np.full((2, 3), wanted), 1e-12)
