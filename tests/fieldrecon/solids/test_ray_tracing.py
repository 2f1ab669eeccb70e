"""Ray tracing of implicit surfaces: intersections, acceleration, lighting and views."""

from itertools import product

import numpy as np
import pytest

import fieldrecon as fr
from fieldrecon.solids import ray_casting
from fieldrecon.solids.ray_casting import LIGHT, phong
from fieldrecon.solids.shapes import Ball, Box, Torus, sample_surface

BOX = [[-1.2] * 3, [1.2] * 3]


def exact_ball(view):
    """Distances from the ray origins of a view to the unit ball, inf where there is none."""
    o = view.origins.reshape(-1, 3)
    ahead = -view.axes[:, 2]
    middle = -(o @ ahead)
    squared = 1 - (o**2).sum(axis=1) + middle**2
    met = (squared > 0) & (view.lengths.ravel() > 0)
    return np.where(met, middle - np.sqrt(np.where(met, squared, 0)), np.inf)


@pytest.mark.parametrize("toward", [(0.3, -1.0, 0.4), (0.0, -1.0, 0.0), (1.0, 1.0, 1.0)])
def test_intersections_with_a_ball_equal_the_closed_form(toward):
    """Distances agree to 1e-12; rays that miss the ball have the distance infinity."""
    view = fr.solids.View.of_box(BOX, toward, 24)
    found = fr.solids.ray_intersections(
        Ball(1.0), view.origins.reshape(-1, 3), -view.axes[:, 2], view.lengths.ravel(), 0.05
    )
    expected = exact_ball(view)
    grazing = np.isinf(found) != np.isinf(expected)
    assert grazing.mean() < 0.02
    both = np.isfinite(found) & np.isfinite(expected)
    assert both.mean() > 0.2
    np.testing.assert_allclose(found[both], expected[both], atol=1e-12)


def test_accelerated_rays_have_the_same_intersections():
    """Sphere tracing and points near the surface save over 30 % of the evaluations."""
    torus, calls = Torus(0.8, 0.3), []

    def counted(x):
        calls.append(len(x))
        return torus(x)

    view = fr.solids.View.of_box(BOX, (0.3, -1.0, 0.6), 24)
    near = sample_surface(torus, 3000, seed=1)[0]
    rays = view.origins.reshape(-1, 3), -view.axes[:, 2], view.lengths.ravel(), 0.06
    found, cost = [], []
    for acceleration in ({}, {"slope": 1.0}, {"near": near}):
        calls.clear()
        found.append(fr.solids.ray_intersections(counted, *rays, **acceleration))
        cost.append(sum(calls))
    for other in found[1:]:
        same = np.isinf(other) == np.isinf(found[0])
        assert same.mean() > 0.98
        met = same & np.isfinite(other)
        np.testing.assert_allclose(other[met], found[0][met], atol=1e-10)
    assert max(cost[1:]) < 0.7 * cost[0]


@pytest.mark.parametrize(
    "function",
    [Ball(1.0), lambda x: 1 - (x**2).sum(axis=1), lambda x: np.expm1(5 * Ball(1.0)(x))],
    ids=["distance", "concave", "convex"],
)
def test_zeros_are_found_in_few_evaluations(function):
    """The order of the false position with halved ends is 1.4; bisection would take 40 steps."""
    calls = []

    def counted(x):
        calls.append(len(x))
        return function(x)

    found = fr.solids.ray_intersections(counted, [[0.1, 0.2, 3.0]], [0.0, 0.0, -1.0], [6.0], 0.5)
    np.testing.assert_allclose(found, 3.0 - np.sqrt(0.95), rtol=1e-12)
    assert sum(calls) < 6.0 / 0.5 + 1 + 16


@pytest.mark.slow
def test_a_shell_thinner_than_the_step_is_missed():
    """The step is the size of the smallest feature that is found."""
    shell = Ball(1.0) - Ball(0.999)
    ray = [[0.0, 0, 3]], [0, 0, -1.0], 6.0
    assert np.isinf(fr.solids.ray_intersections(shell, *ray, 0.3))
    assert np.isfinite(fr.solids.ray_intersections(shell, *ray, 0.0005))


@pytest.mark.parametrize("height", [1.25, 1.0, 1.375, 2.75])
def test_the_zero_of_a_linear_function_takes_one_evaluation(height):
    """After those at the steps: interpolation between the last two is exact in binary numbers."""
    seen = []

    def plane(x):
        seen.extend(x[:, 2])
        return height - x[:, 2]

    found = fr.solids.ray_intersections(plane, [[0, 0, 3.0]], [0, 0, -2.0], 6.0, 0.5)
    assert found == 3 - height
    steps = np.arange(3.0, height - 0.5, -0.5)
    assert seen == [*steps[: np.argmax(steps <= height) + 1], height]


@pytest.mark.parametrize("length", [0.0, 0.25, 2.0])
def test_a_ray_that_ends_on_the_surface_meets_it(length):
    """There the function is zero, and not yet positive; a shorter ray does not."""
    ray = [[0.0, 0, 1 + length]], [0, 0, -1.0]
    assert fr.solids.ray_intersections(Ball(1.0), *ray, length, 0.25) == length
    assert np.isinf(fr.solids.ray_intersections(Ball(1.0), *ray, length - 1e-9, 0.25))


@pytest.mark.parametrize("step", [0.3, 0.7, 1.9, 40.0])
@pytest.mark.parametrize("slope", [None, 1.0])
def test_a_surface_between_the_last_step_and_the_end_of_a_ray_is_met(step, slope):
    """A ray that ends just inside of the ball, or at its centre, whatever the steps."""
    for length in (2.0 + 1e-6, 2.2, 3.0):
        found = fr.solids.ray_intersections(
            Ball(1.0), [[0.0, 0, 3.0]], [0, 0, -1.0], length, step, slope=slope
        )
        assert found == pytest.approx(2.0)


@pytest.mark.parametrize("function", [Ball(1.0), lambda x: np.expm1(5 * Ball(1.0)(x))])
def test_distances_are_found_to_the_tolerance_from_inside(function):
    """Not before the surface, and the larger the tolerance, the fewer evaluations."""
    calls = []

    def counted(x):
        calls.append(len(x))
        return function(x)

    cost, exact = [], 3.0 - np.sqrt(0.95)
    for tol in (0.3, 1e-2, 1e-5, 0.0):
        calls.clear()
        ray = [[0.1, 0.2, 3.0]], [0.0, 0.0, -1.0], [6.0], 0.5
        (found,) = fr.solids.ray_intersections(counted, *ray, tol=tol)
        assert -1e-14 < found - exact <= tol + 1e-14
        cost.append(sum(calls))
    assert cost == sorted(cost)
    assert cost[0] < cost[-1]


def test_rays_of_any_direction_and_functions_without_values():
    """Distances are lengths, however long the direction is; a value that is not finite is named."""
    ball, origins = Ball(1.0), [[0.0, 0, 3], [0, 0.6, 3], [0, 2, 3]]
    for size in (1.0, 2.0, 1e-200, 1e200):
        found = fr.solids.ray_intersections(ball, origins, [0, 0, -size], 6.0, 0.1)
        np.testing.assert_allclose(found, [2, 2.2, np.inf], rtol=1e-14)
    assert fr.solids.ray_intersections(ball, np.zeros((0, 3)), [0, 0, -1], 6.0, 0.1).shape == (0,)
    with pytest.raises(ValueError, match="direction must be one vector of 3 coordinates, not all"):
        fr.solids.ray_intersections(ball, origins, [0, 0, 0], 6.0, 0.1)
    with pytest.raises(ValueError, match="direction must be an array of real numbers"):
        fr.solids.ray_intersections(ball, origins, [0, 0, 1j], 6.0, 0.1)
    with pytest.raises(ValueError, match="lengths must be an array of real numbers"):
        fr.solids.ray_intersections(ball, origins, [0, 0, -1], 6j, 0.1)
    with pytest.raises(ValueError, match=r"lengths must be one number, or 3, one for each ray"):
        fr.solids.ray_intersections(ball, origins, [0, 0, -1], [6.0, 6.0], 0.1)
    with pytest.raises(ValueError, match=r"finite on the rays; at \(0, 0, 1.4.*\) it is nan"):
        fr.solids.ray_intersections(
            lambda x: np.where(x[:, 2] < 1.45, np.nan, -1.0), origins, [0, 0, -1], 6.0, 0.1
        )
    with pytest.raises(ValueError, match=r"one value at each of 3 points; got the shape \(3, 1\)"):
        fr.solids.ray_intersections(lambda x: -x[:, :1] - 1, origins, [0, 0, -1], 6.0, 0.1)


def test_progress_counts_the_rays_that_have_ended():
    """At the ball, after two steps and four, or at their end, after twelve."""
    told, origins = [], [[0.0, 0, 2], [0, 0, 3], [0, 2, 3]]
    fr.solids.ray_intersections(
        Ball(1.0), origins, [0, 0, -1], 6.0, 0.5, progress=lambda *counts: told.append(counts)
    )
    assert told == [(k, 3) for k in [0] * 2 + [1] * 2 + [2] * 8 + [3]]


@pytest.mark.parametrize("slope", [0, -1.0, np.nan, np.inf])
def test_a_slope_that_is_no_lipschitz_constant_is_refused(slope):
    """Steps |F| / slope of it would be infinite, and the ball would be missed."""
    with pytest.raises(ValueError, match="slope must be a positive number; got"):
        fr.solids.ray_intersections(Ball(1.0), [[0, 0, 3.0]], [0, 0, -1], 6.0, 0.1, slope=slope)
    with pytest.raises(ValueError, match="tol must be zero or a positive number; got nan"):
        fr.solids.ray_intersections(Ball(1.0), [[0, 0, 3.0]], [0, 0, -1], 6.0, 0.1, tol=np.nan)


def test_the_picture_of_a_ball_has_its_area_and_its_highlight():
    """The ball is a disc of its radius.

    It is brightest where the normal bisects the directions to lamp and viewer.
    """
    view = fr.solids.View.of_box(BOX, (0, -1, 0), 60)
    image = fr.solids.ray_traced(Ball(1.0), view, 0.1, color=(1.0, 0.5, 0.5))
    assert image.shape == (60, 60, 4)
    assert (image[..., 3] > 0).mean() == pytest.approx(np.pi / 2.4**2, rel=0.02)
    row, column = np.unravel_index(image[..., :3].sum(axis=2).argmax(), image.shape[:2])
    half = np.array(LIGHT) / np.linalg.norm(LIGHT) + [0, 0, 1]
    half /= np.linalg.norm(half)
    assert [column, row] == pytest.approx(30 + 25 * half[:2] - 0.5, abs=2)
    assert image[30, 30, 0] > image[30, 30, 1]


def test_a_surface_without_a_colour_is_grey():
    """Red, green and blue are alike, in the light and in the shade."""
    view = fr.solids.View.of_box(BOX, (0, -1, 0), 20)
    image = fr.solids.ray_traced(Ball(1.0), view, 0.5)
    visible = image[image[..., 3] > 0, :3]
    assert np.ptp(visible, axis=1).max() < 0.05
    assert np.ptp(visible.mean(axis=1)) > 0.3


def test_a_view_is_centred_and_its_rays_cross_the_box():
    """From any side: they enter and leave at its surface, and the picture holds its corners."""
    low, high = np.array([1.0, -2.0, 0.5]), np.array([2.0, 0.5, 1.25])
    box, corners = (
        Box(high - low, (low + high) / 2),
        np.array([*product(*zip(low, high, strict=True))]),
    )
    for toward in ((0.3, -1.0, 0.4), (0.0, -1.0, 0.0), (-1.0, 2.0, -0.7)):
        view = fr.solids.View.of_box([low, high], toward, 30)
        np.testing.assert_allclose(view.axes.T @ view.axes, np.eye(3), atol=1e-14)
        np.testing.assert_allclose(view.axes[:, 2], toward / np.linalg.norm(toward))
        assert view.axes[2, 0] == 0 < view.axes[2, 1]
        assert np.linalg.det(view.axes) == pytest.approx(1)
        hit = view.lengths > 0
        ends = view.origins - view.lengths[..., None] * view.axes[:, 2]
        np.testing.assert_allclose(box(view.origins[hit]), 0, atol=1e-12)
        np.testing.assert_allclose(box(ends[hit]), 0, atol=1e-12)
        outside = np.linalg.norm(view.origins - box.box.mean(axis=0), axis=2)[~hit] < 0.1
        assert not outside.any()
        right, up = (view.origins @ view.axes[:, :2]).transpose(2, 0, 1)
        size = right[0, 1] - right[0, 0]
        np.testing.assert_allclose(np.diff(right, axis=1), size, rtol=1e-9)
        np.testing.assert_allclose(np.diff(up, axis=0), size, rtol=1e-9)
        across = np.ptp(corners @ view.axes[:, :2], axis=0)
        assert max(hit.shape) == 30
        assert size == pytest.approx(across.max() / 30)
        assert (np.array(hit.shape[::-1]) == np.ceil(across / size - 1e-6)).all()
        middle = (low + high) / 2 @ view.axes[:, :2]
        np.testing.assert_allclose([right.mean(), up.mean()], middle, atol=1e-12)


def test_light_is_ambient_diffuse_and_mirrored():
    """The ray to the viewer is mirrored at the normal; where it points away from the lamp, none."""
    rng = np.random.default_rng(1)
    normals, color = rng.normal(size=(400, 3)), np.array([1.0, 0.3, 0.1])
    lamp, viewer = np.array(LIGHT) / np.linalg.norm(LIGHT), np.array([0, 0, 1.0])
    normals[7] = lamp + viewer  # which mirrors the lamp to the viewer: more light than is shown
    unit = normals / np.linalg.norm(normals, axis=1, keepdims=True)
    for u, found in zip(unit, phong(normals, color), strict=True):
        mirrored = 2 * (u @ viewer) * u - viewer
        shine = max(mirrored @ lamp, 0) if u @ lamp > 0 else 0
        light = ray_casting._AMBIENT + ray_casting._DIFFUSE * max(u @ lamp, 0)
        shine = ray_casting._SPECULAR * shine**ray_casting._SHININESS
        np.testing.assert_allclose(found, np.clip(light * color + shine, 0, 1), atol=1e-12)
    assert phong(normals, color).max() == 1


def test_phong_lighting_has_full_and_ambient_light():
    """A surface that faces the lamp has full light; one that faces away has ambient light only."""
    lamp = np.array([LIGHT]) / np.linalg.norm(LIGHT)
    white = np.ones(3)
    toward, away, none = phong(7 * lamp, white), phong(-lamp, white), phong(0 * lamp, white)
    assert (toward > 0.9).all()
    assert (away < 0.3).all()
    np.testing.assert_array_equal(away, none)


@pytest.mark.parametrize("step", [0.5, 0.05])
def test_the_colour_of_a_function_is_that_of_the_visible_points(step):
    """They are on the side of the viewer, and on the surface to a thousandth of a step."""
    seen = []

    def striped(points):
        seen.append(points)
        return np.where(points[:, 2:] > 0, [1.0, 0, 0], [0, 0, 1.0])

    view = fr.solids.View.of_box(BOX, (0, -1, 0), 20)
    image = fr.solids.ray_traced(Ball(1.0), view, step, color=striped)
    (points,) = seen
    assert len(points) == (image[..., 3] > 0).sum()
    np.testing.assert_allclose(Ball(1.0)(points), 0, atol=1e-3 * step)
    assert (points[:, 1] < 0).all()
    for half, strong, weak in ((image[:10], 2, 0), (image[10:], 0, 2)):
        visible = half[half[..., 3] > 0]
        assert (visible[:, strong] > visible[:, weak]).all()


def test_pixels_are_squares_of_the_longer_side_however_deep_the_box_is():
    """A box of 2 by 1, seen along its third side."""
    for depth in (0.5, 7.0):
        view = fr.solids.View.of_box([[0, 0, 0], [2, depth, 1]], (0, -1, 0), 40)
        assert view.lengths.shape == (20, 40)
        np.testing.assert_allclose(view.lengths, depth)


def test_a_view_of_one_pixel_is_refused():
    """Nothing would show the size of its pixels."""
    with pytest.raises(ValueError, match="pixels must be an integer, 2 or more; got 1"):
        fr.solids.View.of_box([[0, 0, 0], [1, 1, 1]], (0, -1, 0), 1)


def test_a_view_along_the_up_direction_is_refused():
    """If the view is parallel to `up`, the orientation of the picture is undetermined."""
    with pytest.raises(ValueError, match="parallel to the direction to the viewer"):
        fr.solids.View.of_box(BOX, (0, 0, 1))
    assert fr.solids.View.of_box(BOX, (0, 0, 1), up=(0, 1, 0)).axes[1, 1] == 1
