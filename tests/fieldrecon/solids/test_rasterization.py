"""Rasterization of triangles: the same picture as by ray tracing, hidden parts, colours."""

from itertools import product

import numpy as np
import pytest

import fieldrecon as fr
from fieldrecon.solids.rasterization import rasterized
from fieldrecon.solids.shapes import Ball

BOX = [[-1.2] * 3, [1.2] * 3]


@pytest.mark.parametrize("toward", [(0, -1, 0), (0.3, -1.0, 0.4)])
def test_the_picture_of_a_fine_mesh_is_that_of_its_body_by_ray_tracing(toward):
    """Two overlapping balls: the same pixels, and colours within 0.02, but for a few at edges."""
    body = Ball(0.7) | Ball(0.5, [0.3, -0.5, 0.4])
    mesh = fr.extract_surface(body, 0.05)
    view = fr.solids.View.of_box(BOX, toward, 60)
    found = rasterized(mesh.points, mesh.triangles, view)
    exact = fr.solids.ray_traced(body, view, 0.05)
    assert found.shape == exact.shape
    assert (exact[..., 3] > 0).mean() > 0.1
    assert (np.abs(found - exact).max(axis=2) > 0.02).mean() < 0.05
    assert (found[..., 3] != exact[..., 3]).mean() < 0.01


def test_the_nearest_triangle_is_visible_in_its_own_colour():
    """A red square hides a blue one, in either order, and no pixel on its diagonal is left out."""
    square = np.array([[-1.0, 0, -1], [1, 0, -1], [1, 0, 1], [-1, 0, 1]])
    points = np.concatenate([square, square + np.array([0, 0.5, 0])])
    triangles = np.array([[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]])
    view = fr.solids.View.of_box([[-1.0] * 3, [1.0] * 3], (0, -1, 0), 21)
    red, blue = [1.0, 0, 0], [0, 0, 1.0]
    for order in (np.arange(4), np.array([2, 3, 0, 1])):
        colors = np.array([red, red, blue, blue])[order]
        image = rasterized(points, triangles[order], view, colors)
        assert (image[..., 3] == 1).all()
        assert (image[..., 0] > image[..., 2]).all()
    behind = rasterized(points, triangles[2:], view, blue)
    assert (behind[..., 2] > behind[..., 0]).all()


def test_what_lies_beside_the_view_leaves_no_pixel():
    """A square to the left or right, above or below, or beyond a corner, near or far."""
    square = np.array([[0.0, 0, 0], [0.25, 0, 0], [0.25, 0, 0.25], [0, 0, 0.25]])
    triangles = np.array([[0, 1, 2], [0, 2, 3]])
    view = fr.solids.View.of_box([[-1.0] * 3, [1.0] * 3], (0, -1, 0), 21)
    for far in (1.01, 1.3, 1.6, 5.0):
        for right, up in product((-far - 0.25, 0.5, far), repeat=2):
            image = rasterized(square + np.array([right, 0, up]), triangles, view)
            assert (image[..., 3] > 0).any() == (right == up == 0.5)


@pytest.mark.parametrize(("high", "pixels"), [(1.0, 24), (0.4, 24), (1.7, 24), (0.5, 2)])
@pytest.mark.parametrize("turn", [1, -1])
def test_a_triangle_covers_the_pixels_whose_middles_lie_in_it(turn, high, pixels):
    """From both sides; on the left of each of its edges, if these turn anticlockwise."""
    rng = np.random.default_rng(3)
    view = fr.solids.View.of_box([[-1.0, -1, -high], [1.0, 1, high]], (0, -1, 0), pixels)
    middles = view.origins[..., [0, 2]]
    for corners in rng.uniform(-1.2, 1.2, (20, 3, 2)) * [1, high]:
        u, v = corners[1:] - corners[0]
        corners = corners[:: int(np.sign(u[0] * v[1] - u[1] * v[0]))]
        inside = np.ones(middles.shape[:2], dtype=bool)
        for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True):
            (x, z), w = b - a, middles - a
            inside &= x * w[..., 1] - z * w[..., 0] >= 0
        points = np.insert(corners[::turn], 1, rng.normal(size=3), axis=1)
        image = rasterized(points, np.array([[0, 1, 2]]), view)
        np.testing.assert_array_equal(image[..., 3] == 1, inside)
