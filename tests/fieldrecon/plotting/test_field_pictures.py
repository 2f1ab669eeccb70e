"""Pictures of a field: what is drawn, where, in which colours, and what is marked as uncertain."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from matplotlib.collections import TriMesh
from matplotlib.colors import LogNorm
from scipy.spatial import cKDTree

from fieldrecon.io.targets import Targets, TargetValues, grid_nodes
from fieldrecon.methods.globe import to_unit
from fieldrecon.pipelines import reconstruct
from fieldrecon.plotting.field_pictures import (
    _HEIGHT,
    _SIDE,
    _WIDTH,
    _draw_samples,
    _draw_scattered,
    _drawn,
    _outer,
    _set_axes,
    color_map,
    plot,
    plot_error,
    plot_nearest,
)
from fieldrecon.plotting.style import figure
from fieldrecon.selection.extrapolation import AMONG, GAP, OUTSIDE


@pytest.mark.parametrize(("number", "size"), [(20, 30.0), (500, 4.0), (5000, 1.0)])
def test_many_points_are_drawn_small_but_visible(number, size):
    """The areas of the points are between 1 and 30, and all points together bounded between."""
    points, zeros = np.random.default_rng(0).random((number, 2)), np.zeros(number)
    result = TargetValues(("x", "y", "f"), Targets(points), zeros, zeros, zeros.astype(int))
    with figure() as (_, axes):
        picture = _draw_scattered(axes, result, zeros, {})
    assert picture.get_sizes() == pytest.approx([size])


@pytest.mark.parametrize(
    ("d", "cells", "mesh"),
    [
        (2, [[0, 1, 2], [1, 3, 2]], True),
        (2, [[0, 1], [1, 2], [2, 3]], False),
        (3, [[0, 1, 2], [1, 3, 2]], False),
        (3, [[0, 1, 2, 3]], False),
    ],
)
def test_values_on_a_mesh_of_the_plane_are_drawn_on_its_triangles(d, cells, mesh):
    """The axes cover it, in x and in y; of all other meshes the vertices are drawn."""
    points = np.array([[0.0, 5, 1], [1, 5, 2], [0, 7, 3], [1, 7, 4]])[:, :d]
    values, zeros = np.arange(4.0), np.zeros(4)
    targets = Targets(points, cells=np.array(cells))
    result = TargetValues(("x", "y", "z", "f"), targets, values, zeros, zeros.astype(int))
    with figure() as (_, axes):
        picture = _draw_scattered(axes, result, values, {})
        assert axes.dataLim.extents.tolist() == [0.0, 5.0, 1.0, 7.0]
    assert isinstance(picture, TriMesh) == mesh
    np.testing.assert_array_equal(picture.get_array(), values)
    if mesh:
        np.testing.assert_array_equal(picture._triangulation.triangles, cells)
    else:
        np.testing.assert_array_equal(picture.get_offsets(), points[:, :2])


@pytest.mark.parametrize(
    ("y", "regular"),
    [
        ([0.0, 1, 2], True),
        ([2.0, 1, 0], True),
        ([1.0, 1], True),
        ([0.0, 1, 5], False),
        ([1], False),
    ],
)
def test_a_grid_is_drawn_with_increasing_axes(y, regular):
    """A grid of xarray may begin in the north, and a side may have no length; one with uneven axes
    is drawn as points.
    """
    axes_of_grid = np.array([3.0, 4.0]), np.array(y, dtype=float)
    nodes = grid_nodes(axes_of_grid)
    values, flags = nodes @ [1.0, 10.0], np.zeros(len(nodes), dtype=int)
    drawn = _drawn(
        TargetValues(("x", "y", "f"), Targets(nodes, axes_of_grid), values, values, flags)
    )
    assert bool(drawn.targets.axes) == regular
    if regular:
        assert [axis.tolist() for axis in drawn.targets.axes] == [[3, 4], sorted(y)]
        assert drawn.values.tolist() == [a + 10 * b for b in sorted(y) for a in (3, 4)]
    else:
        assert drawn.values.tolist() == values.tolist()


def test_of_many_scattered_targets_some_are_drawn_and_of_a_mesh_all_vertices():
    """Every third of 50,000, with its own value, error and flag."""
    points = np.random.default_rng(0).random((50_000, 2))
    values, error = points @ [1.0, 10.0], points @ [2.0, 3.0]
    flags = (points[:, 0] > 0.5).astype(int)
    for cells, step in ((None, 3), (np.array([[0, 1, 49_999]]), 1)):
        targets = Targets(points, cells=cells)
        drawn = _drawn(TargetValues(("x", "y", "f"), targets, values, error, flags))
        np.testing.assert_array_equal(drawn.targets.points, points[::step])
        np.testing.assert_array_equal(drawn.values, values[::step])
        np.testing.assert_array_equal(drawn.error, error[::step])
        np.testing.assert_array_equal(drawn.extrapolated, flags[::step])


@pytest.mark.parametrize(
    ("d", "n", "drawn"), [(2, 40, 40), (2, 5000, 5000), (2, 5001, 0), (3, 40, 0)]
)
def test_samples_are_drawn_on_a_map_unless_they_would_hide_it(d, n, drawn):
    """In space they are not drawn, since a map shows one height."""
    points = np.random.default_rng(0).random((n, d))
    axes = {"xyz"[k]: points[:, k] for k in range(d)}
    survey = reconstruct(**axes, value=points[:, 0], method="ls1", at=points[:20])
    shown = [line.get_xydata() for line in plot(survey).axes[0].lines]
    assert sum(map(len, shown)) == drawn
    if drawn:
        np.testing.assert_array_equal(shown[0], survey.samples.points)


@pytest.mark.parametrize(("middle", "stretch"), [(0, 1), (60, 2), (-60, 2), (88, 10), (90, 10)])
def test_a_degree_of_latitude_is_drawn_longer_than_one_of_longitude(middle, stretch):
    """By 1 / cos(latitude), and near a pole by ten at most."""
    nodes = grid_nodes((np.array([0.0, 1.0]), middle + np.array([-1.0, 1.0]) / (2 * stretch)))
    zeros = np.zeros(len(nodes))
    targets = Targets(nodes)
    result = TargetValues(("x", "y", "f"), targets, zeros, zeros, zeros.astype(int), lonlat=True)
    with figure() as (_, axes):
        _set_axes(axes, result)
        assert axes.get_aspect() == pytest.approx(stretch)


@pytest.mark.parametrize("sides", [(3, 2, 7), (2, 7, 3)])
def test_a_grid_in_space_is_drawn_at_its_middle_height(sides):
    """The title has the height."""
    axes_of_grid = tuple(np.arange(n, dtype=float) for n in sides)
    nodes = grid_nodes(axes_of_grid)
    zeros = np.zeros(len(nodes))
    targets = Targets(nodes, axes_of_grid)
    result = TargetValues(("x", "y", "z", "f"), targets, zeros, zeros, zeros.astype(int))
    with figure() as (_, axes):
        _set_axes(axes, result)
        assert axes.get_title(loc="center") + axes.get_title(loc="left") == f"z = {sides[2] // 2}"


@pytest.mark.parametrize(
    ("counts", "drawn", "middle"),
    [
        ((3, 3 * _SIDE), (3, _SIDE), 0),
        ((_SIDE + 1, 2), (_SIDE // 2 + 1, 2), 0),
        ((_SIDE, 2, 4), (_SIDE, 2), 2),
    ],
)
@pytest.mark.parametrize("falling", [False, True])
def test_of_the_nodes_of_a_large_grid_some_are_drawn(counts, drawn, middle, falling):
    """Every node, or every second or third one; of a grid in space those of the middle slice."""
    axes = tuple(np.arange(float(count))[:: 1 - 2 * falling] for count in counts)
    targets = Targets(grid_nodes(axes), axes)
    places = np.round(targets.points[:, 0] + 1e4 * targets.points[:, 1])
    places += 1e-3 * targets.points[:, 2] if len(counts) == 3 else 0
    names = (*"xyz"[: len(counts)], "v")
    found = _drawn(TargetValues(names, targets, places, 2 * places, np.arange(len(places))))
    x, y = found.targets.axes
    assert (len(x), len(y)) == drawn
    assert (np.diff(x) > 0).all()
    assert (np.diff(y) > 0).all()
    height = axes[2][middle] if len(counts) == 3 else 0.0
    expected = np.add.outer(1e4 * y, x).ravel() + 1e-3 * height
    np.testing.assert_allclose(found.values, expected, rtol=1e-15)
    np.testing.assert_array_equal(found.error, 2 * found.values)
    np.testing.assert_array_equal(places[found.extrapolated], found.values)


@pytest.mark.parametrize(("step", "even"), [(1.0, True), (1.0009, True), (1.01, False)])
def test_a_grid_with_uneven_steps_is_drawn_as_points(step, even):
    """A picture has equal cells, up to a thousandth."""
    axes = np.array([0.0, step, step + 1.0]), np.arange(2.0)
    targets = Targets(grid_nodes(axes), axes)
    found = _drawn(TargetValues("xyv", targets, np.arange(6.0), np.zeros(6), np.zeros(6, int)))
    assert bool(found.targets.axes) == even
    assert len(found.values) == 6


def test_the_cells_of_a_picture_are_centred_at_their_nodes():
    assert _outer(np.array([2.0, 4.0, 6.0])) == (1.0, 7.0)
    assert _outer(np.array([3.0, 3.0])) == (2.5, 3.5)  # a cell has a width


@pytest.fixture(scope="module")
def some_survey():
    """One on a grid of 4 by 3 nodes, whose samples and values the tests replace."""
    points = np.random.default_rng(2).random((12, 2))
    return reconstruct(points, value=points[:, 0], method="ls1", grid=(4, 3))


def with_values(survey, values, error, flags):
    """The survey with these values, errors and flags at its targets."""
    columns = [np.asarray(a, dtype=float).ravel() for a in (values, error)]
    flags = np.asarray(flags).ravel()
    return replace(
        survey,
        result=replace(survey.result, values=columns[0], error=columns[1], extrapolated=flags),
    )


def shown(page):
    """The first picture of the first axes, its label, and all other things drawn there."""
    axes, bar = page.axes
    picture, *others = [*axes.images, *axes.collections]
    return axes, picture, bar.get_ylabel(), others


def test_the_colours_of_a_field_range_over_the_values_among_the_samples(some_survey):
    """Whatever is extrapolated, or not a number; white veils what is extrapolated by half."""
    values = np.arange(12.0).reshape(3, 4)
    values[0, 2] = np.nan
    flags = np.zeros((3, 4), dtype=int)
    flags[2, 1:], flags[0, 0] = (GAP, GAP, OUTSIDE), GAP
    axes, picture, label, (veil, *outline) = shown(
        plot(with_values(some_survey, values, values, flags))
    )
    assert picture.get_clim() == (1.0, 8.0)
    assert label == "value"
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("x", "y")
    np.testing.assert_array_equal(picture.get_array(), values)
    white, opacity = veil.get_array()[..., :3], veil.get_array()[..., 3]
    assert (white == 1).all()
    assert (opacity[flags == AMONG] == 0).all()
    assert np.ptp(opacity[flags != AMONG]) == 0
    assert 0.3 < opacity[2, 1] < 0.6
    assert picture.get_extent() == veil.get_extent() == [*axes.get_xlim(), *axes.get_ylim()]
    hatched, line = outline
    assert hatched.hatches == ["////"]
    x, y = some_survey.result.targets.axes
    half_x, half_y = x[2:].mean(), y[1:].mean()  # of the way to the corner, which is outside
    (outside,), (edge,) = hatched.get_paths(), line.get_paths()
    np.testing.assert_allclose(outside.get_extents().extents, [half_x, half_y, x[3], y[2]])
    ends = edge.vertices[edge.vertices[:, 0].argsort()]
    np.testing.assert_allclose(ends, [[half_x, y[2]], [x[3], half_y]])


def test_only_a_grid_with_nodes_outside_the_samples_is_hatched(some_survey):
    """A gap among the samples is pale, and no more."""
    values = np.arange(12.0)
    _, _, _, (_, *outline) = shown(plot(with_values(some_survey, values, values, np.full(12, GAP))))
    assert not outline


@pytest.mark.parametrize(
    ("spread", "low"), [(10.0, None), (29.5, None), (30.5, 1 / 30.5), (1e6, 1e-4)]
)
def test_errors_of_different_sizes_are_drawn_by_their_logarithms(some_survey, spread, low):
    """Over four decades at most; errors where the field is extrapolated change nothing."""
    error = np.full(12, 2.0)
    error[:2], error[-1] = 2.0 / spread, 1e9
    flags = np.where(np.arange(12) < 11, AMONG, OUTSIDE)
    _, picture, label, _ = shown(plot_error(with_values(some_survey, error, error, flags)))
    assert label == "error of value"
    assert isinstance(picture.norm, LogNorm) == (low is not None)
    assert picture.get_clim() == pytest.approx((2.0 * (low or 1 / spread), 2.0))


def test_an_error_of_zero_has_no_logarithm(some_survey):
    """The range of colours begins at zero."""
    error = np.arange(12.0)
    _, picture, _, _ = shown(
        plot_error(with_values(some_survey, error, error, np.zeros(12, dtype=int)))
    )
    assert picture.get_clim() == (0.0, 11.0)
    assert not isinstance(picture.norm, LogNorm)


def test_where_all_is_extrapolated_a_picture_has_colours_too(some_survey):
    """Those of all values."""
    error = np.arange(12.0)
    for draw in (plot, plot_error):
        _, picture, _, _ = shown(draw(with_values(some_survey, error, error, np.full(12, OUTSIDE))))
        assert picture.get_clim() == (0.0, 11.0)


def test_the_distance_from_the_nearest_sample_is_drawn(some_survey):
    """From zero on."""
    survey = with_values(some_survey, np.zeros(12), np.zeros(12), np.zeros(12, dtype=int))
    _, picture, label, _ = shown(plot_nearest(survey, cmap="magma"))
    expected = cKDTree(survey.samples.points).query(survey.result.targets.points)[0]
    np.testing.assert_array_equal(np.ravel(picture.get_array()), expected)
    assert (picture.get_clim()[0], picture.get_cmap().name) == (0.0, "magma")
    assert label == "distance from the nearest sample"


def on_globe(survey, samples, at):
    """The survey as if its samples and targets were longitudes and latitudes."""
    zeros = np.zeros(len(at))
    result = replace(
        survey.result,
        targets=Targets(at),
        values=zeros,
        error=zeros,
        extrapolated=zeros.astype(int),
        lonlat=True,
    )
    return replace(survey, samples=replace(survey.samples, points=samples), result=result)


def test_on_the_globe_the_distance_from_the_nearest_sample_is_an_angle(some_survey):
    """In degrees; along a meridian it is the difference of the latitudes."""
    samples = np.column_stack([np.full(9, 10.0), np.linspace(-60.0, 60.0, 9)])
    at = np.column_stack([np.full(3, 10.0), [-60.0, 0.0, 67.0]])
    _, picture, label, _ = shown(plot_nearest(on_globe(some_survey, samples, at)))
    order = np.lexsort(at.T)
    np.testing.assert_allclose(picture.get_array(), np.array([0.0, 0.0, 7.0])[order], atol=1e-9)
    assert label == "distance from the nearest sample, degrees"


def test_the_farthest_point_of_the_globe_is_half_a_turn_away(some_survey):
    """Where the chord, which is rounded, is a little longer than the diameter, too."""
    lon, lat = np.random.default_rng(0).uniform(-80, 80, (2, 20_000))
    here, there = np.column_stack([lon, lat]), np.column_stack([lon + 180, -lat])
    chords = np.linalg.norm(to_unit(here) - to_unit(there), axis=1)
    far = [int(chords.argmax())]
    assert chords[far] > 2
    _, picture, _, _ = shown(plot_nearest(on_globe(some_survey, here[far], there[far])))
    np.testing.assert_allclose(picture.get_array(), 180)


def test_one_of_several_values_is_drawn():
    """The first, or the one that is asked for, in the colours that are asked for."""
    x, y = np.random.default_rng(0).random((2, 30))
    values = {"east": x, "north": 5 + y}
    survey = reconstruct(
        {"x": x, "y": y} | values, value=["east", "north"], method="ls1", grid=(5, 5)
    )
    for draw, prefix in ((plot, ""), (plot_error, "error of ")):
        labels = [shown(draw(survey, *k))[2] for k in ((), (0,), (1,))]
        assert labels == [prefix + name for name in ("east", "east", "north")]
        assert shown(draw(survey, 1, "cividis"))[1].get_cmap().name == "cividis"
    assert shown(plot(survey, 1))[1].get_clim()[0] >= 5 - 1e-9


@pytest.mark.parametrize("first", [-30.0, 0.0, 200.0, 355.0])
def test_samples_on_the_globe_are_drawn_where_the_targets_are(first, some_survey):
    """A longitude may be given from -180 to 180, from 0 to 360, or beyond."""
    at = np.column_stack([first + np.arange(20.0), np.linspace(-10, 10, 20)])
    turned = np.column_stack([(at[:, 0] + 180) % 360 - 180, at[:, 1]])
    with figure() as (_, axes):
        _draw_samples(axes, on_globe(some_survey, turned, at))
        (samples,) = axes.lines
    np.testing.assert_allclose(samples.get_xydata(), at)


@pytest.mark.parametrize(("number", "size"), [(4, 3.0), (400, 2.0), (40_000, 0.4)])
def test_dots_of_many_samples_are_small_but_visible(number, size):
    points = np.random.default_rng(0).random((number, 2))
    survey = reconstruct(points, value=points[:, 0], method="ls1", at=points[:3])
    with figure() as (_, axes):
        _draw_samples(axes, survey)
        (samples,) = axes.lines
    assert samples.get_markersize() == pytest.approx(size)
    assert samples.get_markeredgewidth() == 0


def test_scattered_targets_are_drawn_with_the_highest_on_top():
    """In space; those that are extrapolated are faint."""
    points = np.random.default_rng(0).random((40, 3))
    flags = (np.arange(40) % 2) * OUTSIDE
    values = points[:, 2]
    result = TargetValues(("x", "y", "z", "f"), Targets(points), values, values, flags)
    with figure() as (_, axes):
        picture = _draw_scattered(axes, result, values, {})
    order = np.argsort(points[:, 2])
    np.testing.assert_array_equal(picture.get_offsets(), points[order, :2])
    np.testing.assert_array_equal(picture.get_array(), values[order])
    opacity = picture.get_alpha()
    assert (opacity[flags[order] == AMONG] == 1).all()
    assert np.ptp(opacity[flags[order] != AMONG]) == 0
    assert 0.3 < opacity.min() < 0.6


def test_a_point_of_which_one_is_drawn_has_a_value():
    """Few targets are drawn each."""
    points = np.array([[0.0, 0.0], [1.0, 2.0]])
    drawn = _drawn(TargetValues(("x", "y", "f"), Targets(points), *np.zeros((2, 2)), np.zeros(2)))
    assert len(drawn.values) == 2


@pytest.mark.parametrize(
    ("width", "height", "equal"),
    [(1.0, 1.0, True), (1.0, 2.9, True), (1.0, 3.1, False), (3.1, 1.0, True), (3.4, 1.0, False)],
)
def test_scales_are_equal_unless_a_picture_would_be_narrow(width, height, equal):
    """The axes have their names, and ticks with all digits, which are apart."""
    nodes = 4e5 + grid_nodes((np.array([0.0, 1e3 * width]), np.array([0.0, 1e3 * height])))
    zeros = np.zeros(len(nodes))
    result = TargetValues(("x, m", "y, m", "f"), Targets(nodes), zeros, zeros, zeros.astype(int))
    with figure(_WIDTH, _HEIGHT) as (page, axes):
        axes.plot(*nodes.T)
        _set_axes(axes, result)
        page.draw_without_rendering()
        assert axes.get_aspect() == (1.0 if equal else "auto")
        assert (axes.get_xlabel(), axes.get_ylabel()) == ("x, m", "y, m")
        assert axes.xaxis.get_offset_text().get_text() == ""
        assert "400000" in axes.get_xticklabels()[1].get_text()
        assert not any(line.get_visible() for line in axes.get_xgridlines())
        boxes = [label.get_window_extent() for label in axes.get_xticklabels()]
        assert all(a.x1 < b.x0 for a, b in pairwise(boxes))


def test_a_colour_map_has_a_known_name():
    assert color_map("viridis") == "viridis"
    with pytest.raises(ValueError, match="there is no colour map 'vridis'"):
        color_map("vridis")


@pytest.mark.parametrize("sides", [(1.0, 2.9), (3.2, 1.0), (1.0, 1.0)])
def test_a_map_and_its_colours_are_in_the_middle_of_the_page(sides, some_survey):
    """Also where equal scales leave the page empty on both sides, or above and below."""
    axes = tuple(side * np.linspace(0, 1, 4) for side in sides)
    targets = Targets(grid_nodes(axes), axes)
    values = targets.points[:, 0]
    result = replace(
        some_survey.result,
        targets=targets,
        values=values,
        error=values,
        extrapolated=np.zeros(16, dtype=int),
    )
    page = plot(replace(some_survey, result=result))
    page.draw_without_rendering()
    boxes = [axes.get_tightbbox() for axes in page.axes]
    for low, high, size in (
        (min(box.x0 for box in boxes), max(box.x1 for box in boxes), page.bbox.width),
        (min(box.y0 for box in boxes), max(box.y1 for box in boxes), page.bbox.height),
    ):
        assert abs(low - (size - high)) < 0.05 * size
        assert 0 <= low < high <= size
