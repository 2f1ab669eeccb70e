"""The picture of the surface of a scan."""

from dataclasses import replace

import numpy as np
import pytest

from fieldrecon.pipelines.scans import ScanResult
from fieldrecon.plotting import surface_picture
from fieldrecon.plotting.surface_picture import _VIEWS, plot
from fieldrecon.solids.marching_cubes import extract_surface
from fieldrecon.solids.shapes import Ball
from figure_layout import filled


@pytest.mark.parametrize("invented", [False, True])
def test_only_a_surface_far_from_the_points_of_its_scan_has_a_legend(invented):
    """It explains the colour of the triangles where the surface is invented."""
    body = Ball(1.0)
    mesh = extract_surface(body, spacing=0.5)
    gaps = np.arange(len(mesh.triangles)) < invented
    scan = ScanResult(None, np.zeros(3), body, mesh, np.zeros(0), gaps, False, "a ball")
    words = [text.get_text() for legend in plot(scan, (0, 0, 1)).legends for text in legend.texts]
    assert words == ["far from all points: invented"] * invented


@pytest.fixture(scope="module")
def scan():
    """An ellipsoid, high or wide."""

    def of(half_axes):
        body = Ball(1.0)
        mesh = extract_surface(body, spacing=0.5)
        mesh = replace(mesh, points=mesh.points * half_axes)
        none = np.zeros(len(mesh.triangles), dtype=bool)
        return ScanResult(None, np.zeros(3), body, mesh, np.zeros(0), none, False, "a ball")

    return of


@pytest.mark.parametrize("half_axes", [(1, 1, 1), (1, 1, 2), (2, 2, 1)])
def test_the_pictures_of_a_surface_are_as_wide_as_their_columns(scan, half_axes):
    """From the front and from behind, at the top, without frames, on a page that they fill."""
    page = plot(scan(half_axes), (0, 0, 1))
    front, behind = page.axes
    titles = [axes.get_title("center") for axes in page.axes]
    assert titles == ["from the front", "from behind"]
    assert filled(page) > 0.8
    boxes = [axes.get_window_extent() for axes in page.axes]
    assert sum(box.width for box in boxes) > 0.9 * page.bbox.width
    assert boxes[0].y1 == pytest.approx(boxes[1].y1)
    for axes in (front, behind):
        (image,) = axes.images
        assert not axes.axison
        assert image.origin == "lower"
        assert max(image.get_array().shape) == 340
        seen = image.get_array()[..., 3]
        assert seen[seen.shape[0] // 2, seen.shape[1] // 2] == 1
        assert not seen[[0, -1]].any()  # a margin
        assert not seen[:, [0, -1]].any()


@pytest.mark.parametrize("axis", range(3))
def test_the_axis_that_points_up_does_so_in_the_picture(scan, axis):
    """An ellipsoid that is long along this axis is drawn high, whichever it is."""
    half_axes = np.ones(3)
    half_axes[axis] = 2
    up = np.eye(3)[axis]
    shapes = [axes.images[0].get_array().shape for axes in plot(scan(half_axes), up).axes]
    right = [axes.images[0].get_array() for axes in plot(scan((1, 1, 2)), (0, 0, 1)).axes]
    assert all(rows > columns for rows, columns, _ in shapes)
    assert shapes == [image.shape for image in right]


def test_views_from_the_front_and_from_behind_are_opposite():
    """To the right and backward are the first two axes; both look from above."""
    front, behind = map(np.array, _VIEWS.values())
    assert front[1] < 0 < behind[1]
    assert front[0] > 0 > behind[0]
    assert min(front[2], behind[2]) > 0
    assert front[:2] @ behind[:2] < -0.8 * np.linalg.norm(front[:2]) * np.linalg.norm(behind[:2])


def test_the_unit_of_length_changes_no_picture_of_a_surface(scan, monkeypatch):
    """It has a margin of some edges of the mesh."""
    monkeypatch.setattr(surface_picture, "_PIXELS", 40)
    one = scan((1, 1, 1))
    large = replace(one.mesh, points=1024 * one.mesh.points, spacing=1024 * one.mesh.spacing)
    for axes, other in zip(
        plot(one, (0, 0, 1)).axes, plot(replace(one, mesh=large), (0, 0, 1)).axes, strict=True
    ):
        image, again = (a.images[0].get_array() for a in (axes, other))
        np.testing.assert_allclose(image, again, atol=1e-9)


def test_an_invented_surface_has_the_colour_of_the_legend(scan):
    """Orange has more red than blue; the surface of a complete scan has not."""
    whole = scan((1, 1, 1))
    for invented in (False, True):
        gaps = np.full(len(whole.mesh.triangles), invented)
        image = plot(replace(whole, gaps=gaps), (0, 0, 1)).axes[0].images[0].get_array()
        red, _, blue = image[image[..., 3] > 0][:, :3].T
        assert ((red > 1.2 * blue).mean() > 0.9) == invented
