"""Pictures: sizes of pages and points, and what marks and legends show."""

import io
import re

import numpy as np
import pytest

from fieldrecon.io.targets import Targets, TargetValues, grid_nodes
from fieldrecon.pages.reconstruction_page import _flattened
from fieldrecon.plotting.field_pictures import _draw_scattered, _drawn, _set_axes
from fieldrecon.plotting.mesh_pictures import marks, plot_audit
from fieldrecon.plotting.style import figure
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
    ("y", "regular"), [([0.0, 1, 2], True), ([2.0, 1, 0], True), ([0.0, 1, 5], False), ([1], False)]
)
def test_a_grid_is_drawn_with_increasing_axes(y, regular):
    """A grid of xarray may begin in the north; one with uneven axes is drawn as points."""
    axes_of_grid = np.array([3.0, 4.0]), np.array(y, dtype=float)
    nodes = grid_nodes(axes_of_grid)
    values, flags = nodes @ [1.0, 10.0], np.zeros(len(nodes), dtype=int)
    drawn = _drawn(
        TargetValues(("x", "y", "f"), Targets(nodes, axes_of_grid), values, values, flags)
    )
    assert bool(drawn.targets.axes) == regular
    if regular:
        assert [axis.tolist() for axis in drawn.targets.axes] == [[3, 4], [0, 1, 2]]
        assert drawn.values.tolist() == [3, 4, 13, 14, 23, 24]
    else:
        assert drawn.values.tolist() == values.tolist()


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
