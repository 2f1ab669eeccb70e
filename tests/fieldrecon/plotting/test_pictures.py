"""Pictures: sizes of pages and points, and what marks and legends show."""

import io
import re
from dataclasses import replace

import numpy as np
import pytest
from matplotlib.patches import Rectangle

from fieldrecon.io.targets import Targets, TargetValues, grid_nodes
from fieldrecon.pages.reconstruction_page import _flattened
from fieldrecon.pipelines import reconstruct
from fieldrecon.pipelines.scans import ScanResult
from fieldrecon.pipelines.validation import Validation
from fieldrecon.pipelines.variograms import variogram
from fieldrecon.plotting.field_pictures import _SIDE, _draw_scattered, _drawn, _outer, _set_axes
from fieldrecon.plotting.field_pictures import plot as plot_field
from fieldrecon.plotting.maps import map_axes
from fieldrecon.plotting.mesh_pictures import Marks, MeshPicture, draw, marks, plot_audit
from fieldrecon.plotting.style import PLAIN_NUMBERS, figure
from fieldrecon.plotting.surface_picture import plot
from fieldrecon.plotting.validation_pictures import plot_distances, plot_held_out, plot_variogram
from fieldrecon.solids.marching_cubes import extract_surface
from fieldrecon.solids.shapes import Ball
from fieldrecon.triangles.audit import audit_mesh
from fieldreport.experiments.triangles.triangle_shapes import cube


def height(rows: int, columns: int) -> float:
    """Height of the axes of a page 6 inches wide."""
    with figure(6.0, rows=rows, columns=columns) as (page, _):
        return page.get_size_inches()[1] - 0.25


@pytest.mark.slow
def test_the_default_height_keeps_the_shape_of_the_axes():
    """Axes side by side are lower, and rows add up."""
    assert height(1, 1) == pytest.approx(0.62 * 6.0)
    assert height(1, 2) == pytest.approx(height(1, 1) / 2)
    assert height(2, 1) == pytest.approx(height(1, 1) * 2)


def test_a_degenerate_triangle_is_marked_by_its_three_edges():
    """Each edge has two of its corners."""
    points = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 0.0]])
    triangles = np.array([[0, 1, 2], [0, 1, 3]])
    found = marks(audit_mesh(points, triangles), triangles)["degenerate_triangles"]
    assert {frozenset(edge) for edge in found.edges.tolist()} == {
        frozenset(pair) for pair in ((0, 1), (1, 2), (0, 2))
    }


@pytest.mark.slow
@pytest.mark.parametrize("damaged", [False, True])
def test_only_a_picture_with_errors_has_a_legend(damaged):
    """A correct mesh needs no explanation of marks."""
    points, triangles = cube(2)
    triangles = triangles[int(damaged) :]
    page = plot_audit(audit_mesh(points, triangles), points, triangles)
    assert len(page.legends) == damaged


@pytest.mark.parametrize("invented", [False, True])
def test_only_a_surface_far_from_the_points_of_its_scan_has_a_legend(invented):
    """It explains the colour of the triangles where the surface is invented."""
    body = Ball(1.0)
    mesh = extract_surface(body, spacing=0.5)
    gaps = np.arange(len(mesh.triangles)) < invented
    scan = ScanResult(None, np.zeros(3), body, mesh, np.zeros(0), gaps, False, "a ball")
    words = [text.get_text() for legend in plot(scan, (0, 0, 1)).legends for text in legend.texts]
    assert words == ["far from all points: invented"] * invented


def test_visible_marks_are_filled_and_opaque_and_hidden_ones_are_not():
    """The eight corners of a cube, of which the viewer sees seven."""
    points, triangles = cube(1)
    none = np.empty(0, dtype=int)
    found = {"bow_tie_vertices": Marks(none, np.empty((0, 2), dtype=int), np.arange(8))}
    with figure() as (_, axes):
        draw(axes, points, triangles, found, np.array([1.0, 1.1, 1.2]), pixels=60)
        hidden, visible = axes.lines
    assert (len(hidden.get_xdata()), len(visible.get_xdata())) == (1, 7)
    assert (hidden.get_markerfacecolor(), visible.get_markerfacecolor() == "none") == (
        "none",
        False,
    )
    assert hidden.get_alpha() < visible.get_alpha() == 1.0


def test_edges_of_large_triangles_are_drawn_darker():
    """A single triangle has two colours, and the darker one at its edges."""
    points = np.array([[0.0, 0, 0], [1, 0, 0], [0, 0, 1]])
    image = MeshPicture(points, np.array([[0, 1, 2]]), np.array([0, -1, 0]), 60).image()
    light = image[..., :3].sum(axis=2)[image[..., 3] > 0]
    middle, edge = light.max(), light.min()
    assert edge < 0.9 * middle
    assert np.isclose(light, middle).mean() > 0.5
    assert (np.isclose(light, middle) | np.isclose(light, edge)).all()


@pytest.mark.parametrize(("number", "size"), [(20, 30.0), (500, 4.0), (5000, 1.0)])
def test_many_points_are_drawn_small_but_visible(number, size):
    """The areas of the points are between 1 and 30, and all points together bounded between."""
    points, zeros = np.random.default_rng(0).random((number, 2)), np.zeros(number)
    result = TargetValues(("x", "y", "f"), Targets(points), zeros, zeros, zeros.astype(int))
    with figure() as (_, axes):
        picture = _draw_scattered(axes, result, zeros, {})
    assert picture.get_sizes() == pytest.approx([size])


def test_values_on_a_mesh_are_drawn_at_its_vertices():
    """The axes cover the mesh, in x and in y."""
    points, zeros = np.array([[0.0, 5.0], [1.0, 5.0], [0.0, 7.0]]), np.zeros(3)
    targets = Targets(points, cells=np.array([[0, 1, 2]]))
    result = TargetValues(("x", "y", "f"), targets, zeros, zeros, zeros.astype(int))
    with figure() as (_, axes):
        _draw_scattered(axes, result, zeros, {})
        assert axes.dataLim.extents.tolist() == [0.0, 5.0, 1.0, 7.0]


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
    shown = [line.get_xydata() for line in plot_field(survey).axes[0].lines]
    assert sum(map(len, shown)) == drawn
    if drawn:
        np.testing.assert_array_equal(shown[0], survey.samples.points)


def test_held_out_values_are_drawn_against_the_predicted_ones():
    """Beside the diagonal, on which they are equal."""
    values, residuals = np.random.default_rng(1).random((2, 9))
    validation = Validation(None, *np.zeros((3, 9)), values, residuals)
    dots, diagonal = plot_held_out(validation, "f").axes[0].lines
    np.testing.assert_allclose(dots.get_xdata() + residuals, dots.get_ydata())
    np.testing.assert_array_equal(dots.get_ydata(), values)
    ends = [values.min(), values.max()]
    assert diagonal.get_xydata().tolist() == [[end, end] for end in ends]


def test_a_notebook_shows_a_figure():
    """As PNG, whether or not its backend is set up."""
    with figure() as (page, _):
        assert page._repr_png_().startswith(b"\x89PNG")


@pytest.mark.parametrize("kind", ["svg", "pdf", "png"])
def test_a_saved_figure_has_no_date(kind):
    buffer = io.BytesIO()
    with figure() as (page, _):
        page.savefig(buffer, format=kind)
    assert not re.search(rb"<dc:date>|CreationDate|Creation Time", buffer.getvalue())


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


def test_arguments_of_a_kernel_have_names_of_their_own():
    """On the page of a survey nested arguments are listed one by one."""
    described = {"name": "RBF", "kernel": {"name": "matern", "scale": 2.0}, "degree": None}
    assert _flattened(described) == {"name": "RBF", "kernel": "matern", "kernel scale": 2.0}


def test_plain_numbers_at_an_axis_have_no_formula():
    """Nor has the power of ten beside it."""
    with figure(settings=PLAIN_NUMBERS) as (page, axes):
        axes.plot([0.0, 3e9])
        page.draw_without_rendering()
        texts = [axes.yaxis.get_offset_text(), *axes.get_yticklabels()]
    assert texts[0].get_text()
    assert not any("$" in text.get_text() for text in texts)


def test_pictures_of_distances_name_their_curves_and_show_all_of_them():
    """Three distributions with a legend, and a variogram up to its largest distance."""
    points = np.random.default_rng(0).random((60, 2))
    validation = Validation(None, *np.random.default_rng(1).random((3, 9)), *np.zeros((2, 9)))
    (axes,) = plot_distances(validation).axes
    assert axes.get_xlabel() == "distance from the nearest sample"
    assert axes.get_ylabel() == "fraction of points"
    names = [text.get_text() for text in axes.get_legend().get_texts()]
    assert names == ["targets", "held-out samples", "leave-one-out"]
    found = variogram(points, points[:, 0])
    on_globe = plot_distances(replace(validation, unit=" degrees")).axes[0]
    assert on_globe.get_xlabel() == "distance from the nearest sample, degrees"
    (axes,) = plot_variogram(found, "f").axes
    assert axes.get_xlim() == (0.0, found.distances.max())
    lines = {line.get_label(): line.get_xydata() for line in axes.lines}
    np.testing.assert_array_equal(lines["samples"].T, [found.distances, found.values])
    h, model = lines["exponential model"].T
    assert (h[0], h[-1]) == (0.0, found.distances.max())
    np.testing.assert_allclose(model, found(h))
    assert (lines["nugget"][:, 1] == found.nugget).all()
    assert ("range" in lines) == found.levels_off


@pytest.mark.parametrize(
    ("limits", "length", "label"),
    [
        ((0.0, 9000.0), 2000.0, "2 km"),
        ((7000.0, 3000.0), 1000.0, "1 km"),
        ((-1000.0, 2000.0), 500.0, "500 m"),
        ((0.0, 2.0), 0.5, "0.5 m"),
    ],
)
def test_a_map_has_a_scale_bar_and_no_ticks(limits, length, label):
    """The bar has a round length, at most a quarter of the width, whichever way the axis runs."""
    with figure() as (page, axes):
        axes.set(xlim=limits, ylim=(0.0, 3000.0))
        map_axes(axes, "heights")
        page.draw_without_rendering()
        (bar,) = axes.artists
        (drawn,) = bar.size_bar.findobj(Rectangle)
        assert (drawn.get_width(), bar.txt_label.get_text()) == (length, label)
        assert (axes.get_title("left"), axes.get_aspect()) == ("heights", 1.0)
        assert len(axes.get_xticks()) == len(axes.get_yticks()) == 0
        assert all(spine.get_visible() for spine in axes.spines.values())


def test_held_out_values_are_drawn_above_their_predictions():
    """With the line where both are equal, over all values, thinner than a curve."""
    values, residuals = np.random.default_rng(1).standard_normal((2, 9))
    some = np.ones(9)
    (axes,) = plot_held_out(Validation(None, some, some, some, values, residuals), "f").axes
    points, equal = axes.lines
    assert np.array_equal(points.get_xydata(), np.stack([values - residuals, values], axis=1))
    assert (points.get_linestyle(), points.get_marker()) == ("None", ".")
    assert np.array_equal(equal.get_xydata(), [[min(values)] * 2, [max(values)] * 2])
    with figure(3.0) as (_, other):
        (curve,) = other.plot([0, 1])
    assert equal.get_linewidth() < curve.get_linewidth()
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("f, predicted", "f, held out")


def test_axes_and_their_labels_are_inside_the_page_and_apart():
    """However long the labels are; a figure is laid out once, whatever is saved or drawn later."""
    with figure(4.0, columns=2) as (page, both):
        for axes in both:
            axes.set(xlabel="two\nlines", ylabel="three\nlines\nhere", title="a title")
            axes.set_ylim(0, 1e5)
    assert page.get_layout_engine() is None
    left, right = (axes.get_tightbbox() for axes in both)
    for box in (left, right):
        assert (box.min >= page.bbox.min).all()
        assert (box.max <= page.bbox.max).all()
    assert left.x1 < right.x0


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
