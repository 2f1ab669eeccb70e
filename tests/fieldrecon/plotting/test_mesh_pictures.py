"""Pictures of a mesh: each error is marked where it is, and what is behind is hidden."""

import numpy as np
import pytest

from fieldrecon.plotting import mesh_pictures
from fieldrecon.plotting.mesh_pictures import (
    _VIEWS,
    COLORS,
    INSIDE,
    LIGHT,
    OUTSIDE,
    Marks,
    MeshPicture,
    draw,
    marks,
    plot_audit,
)
from fieldrecon.plotting.style import figure
from fieldrecon.triangles.audit import audit_mesh
from fieldreport.experiments.triangles.triangle_shapes import cube
from figure_layout import filled


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


TETRAHEDRON = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])
OUTWARD = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
PLACES = np.array([[0, 0, 0], [4, 0, 0], [4, 4, 0], [0, 4, 0], [2, 0, 0], [2, 2, 3], [2, 2, -3.0]])
FAN = [[0, 1, 2], [0, 1, 5], [0, 1, 6]]  # three triangles at the edge (0, 1)
KINDS = {
    # kind: vertices, triangles, and the marked triangles, edges and vertices
    "boundary_loops": (PLACES, [[0, 1, 2], [0, 2, 3]], [], [(0, 1), (1, 2), (2, 3), (0, 3)], []),
    "nonmanifold_edges": (PLACES, FAN, [], [(0, 1)], []),
    "duplicate_triangles": (PLACES, [[0, 1, 2], [0, 2, 3], [2, 0, 1]], [2], [], []),
    "unreferenced_vertices": (PLACES, [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]], [], [], [6]),
    "flipped_triangles": (PLACES, [[0, 1, 2], [0, 2, 3], [0, 3, 5], [0, 1, 6]], [3], [], []),
    "inside_out_triangles": (TETRAHEDRON, OUTWARD[:, ::-1], [0, 1, 2, 3], [], []),
    "t_junctions": (PLACES, [[0, 1, 2], [4, 0, 6]], [], [], [4]),
    "crossings": (PLACES, [[0, 1, 2], [4, 5, 6]], [0, 1], [], []),
    "duplicate_vertices": (
        np.vstack([PLACES, PLACES[:1]]),
        [[0, 1, 2], [7, 2, 3], [0, 3, 5]],
        *([], [], [7]),
    ),
}


@pytest.mark.parametrize("kind", KINDS)
def test_an_error_is_marked_where_it_is(kind):
    """A triangle, an edge by its two ends, or a vertex, and the later one of two equal ones."""
    points, triangles, faces, edges, vertices = KINDS[kind]
    triangles = np.array(triangles)
    mark = marks(audit_mesh(points, triangles), triangles)[kind]
    assert mark.triangles.tolist() == faces
    assert {frozenset(edge) for edge in mark.edges.tolist()} == {*map(frozenset, edges)}
    assert mark.vertices.tolist() == vertices
    marked = {*np.ravel(triangles[faces]).tolist(), *np.ravel(edges), *vertices}
    assert {*mark.of_vertices(triangles).tolist()} == marked


def test_both_edges_of_a_seam_are_marked():
    """Two sheets whose common edge has vertices of its own in each."""
    points = np.array([[0, 0], [1, 0], [1, 1], [0, 1], [0, 0], [0, 1], [-1, 0], [-1, 1.0]])
    points = np.column_stack([points, np.zeros(8)])
    triangles = np.array([[0, 1, 2], [0, 2, 3], [4, 5, 6], [5, 7, 6]])
    mark = marks(audit_mesh(points, triangles), triangles)["free_edge_pairs"]
    assert {frozenset(e) for e in mark.edges.tolist()} == {frozenset({0, 3}), frozenset({4, 5})}


VIEWS = [(0.8, -0.7, 0.6), (-0.8, 0.7, -0.6), (1.0, 0.0, 0.0), (0.1, 0.2, 5.0)]


@pytest.mark.parametrize("toward", VIEWS)
def test_a_picture_is_a_parallel_projection_with_z_upward(toward):
    """The axes are orthonormal and right-handed; the third points to the viewer."""
    picture = MeshPicture(TETRAHEDRON, OUTWARD, np.array(toward), 60)
    right, up, viewer = picture.axes.T
    np.testing.assert_allclose(picture.axes.T @ picture.axes, np.eye(3), atol=1e-15)
    np.testing.assert_allclose(viewer, np.array(toward) / np.linalg.norm(toward))
    np.testing.assert_allclose(np.cross(right, up), viewer, atol=1e-15)
    assert right[2] == pytest.approx(0, abs=1e-15)
    assert up[2] > 0
    projected = TETRAHEDRON @ picture.axes
    drawn, wanted = np.ptp(picture.points, axis=0), np.ptp(projected, axis=0)
    scale = drawn.sum() / wanted.sum()
    shift = picture.points[0] - scale * projected[0]
    np.testing.assert_allclose(picture.points, scale * projected + shift, atol=1e-9)


@pytest.mark.parametrize("toward", VIEWS)
@pytest.mark.parametrize("size", [1e-20, 1.0, 1e20])
def test_a_mesh_fills_its_picture_up_to_a_margin(toward, size):
    """Of four pixels on each side, in any unit; rounding may add a pixel."""
    points = size * (TETRAHEDRON + np.array([1e3, 0, 0]))
    picture = MeshPicture(points, OUTWARD, np.array(toward), 100)
    rows, columns = picture.shape
    assert max(rows, columns) in (100, 101)
    np.testing.assert_allclose(picture.points[:, :2].min(axis=0), 4.0, atol=1e-6)
    ends = picture.points[:, :2].max(axis=0)
    assert (ends <= np.array([columns, rows]) - 4 + 1e-6).all()
    assert (ends > np.array([columns, rows]) - 6).all()
    seen = picture.image()[..., 3]
    assert not seen[:3].any()
    assert not seen[-3:].any()
    assert not seen[:, :3].any()
    assert not seen[:, -3:].any()


@pytest.mark.parametrize("middle", [None, np.array([2, 5])])
def test_a_pixel_shows_the_triangle_that_is_nearest_to_the_viewer(middle):
    """Compared with a ray through the middle of each pixel and every triangle, one by one; in a
    close-up the triangles reach beyond the picture.
    """
    rng = np.random.default_rng(3)
    points, triangles = rng.random((12, 3)), rng.permutation(12).reshape(4, 3)
    picture = MeshPicture(points, triangles, np.array([0.3, -0.8, 0.4]), 28, middle)
    rows, columns = picture.shape
    if middle is not None:
        beyond = picture.points[:, :2]
        assert (beyond.min(axis=0) < 0).all()
        assert (beyond.max(axis=0) > 28).all()
    for row in range(rows):
        for column in range(columns):
            depths = {}
            for k, corners in enumerate(picture.points[triangles]):
                system = np.vstack([corners[:, :2].T, np.ones(3)])
                shares = np.linalg.solve(system, [column + 0.5, row + 0.5, 1.0])
                if (shares >= 0).all():
                    depths[k] = shares @ corners[:, 2]
            nearest = max(depths, key=depths.get) if depths else -1
            assert picture.front.reshape(rows, columns)[row, column] == nearest
            expected = depths.get(nearest, -np.inf)
            assert picture.depth.reshape(rows, columns)[row, column] == pytest.approx(expected)
            if depths:
                corners = picture.points[triangles[nearest], :2]
                side = np.roll(corners, -1, axis=0) - corners
                to_pixel = [column + 0.5, row + 0.5] - corners
                across = np.linalg.det(np.stack([side, to_pixel], axis=1))
                distance = abs(across) / np.linalg.norm(side, axis=1)
                near = picture.near_edge.reshape(rows, columns)[row, column]
                assert near == (distance.min() < 0.6)


@pytest.mark.parametrize("pixels_at_once", [1, 7, 64, 500, 10_000])
def test_a_picture_does_not_depend_on_the_pixels_that_are_drawn_at_once(
    monkeypatch, pixels_at_once
):
    """A triangle may have more of them, or none."""
    points, triangles = cube(5)
    triangles = np.vstack([triangles[:9], [[0, 0, 0]], triangles[9:], [[1, 1, 1]]])
    views = points, triangles, np.array([1.0, 1.1, 1.2]), 40, np.array([0, 9])
    wanted = MeshPicture(*views)
    monkeypatch.setattr(mesh_pictures, "_CHUNK", pixels_at_once)
    found = MeshPicture(*views)
    assert (wanted.front >= 0).any()
    for name in ("front", "depth", "near_edge"):
        np.testing.assert_array_equal(getattr(found, name), getattr(wanted, name))


def test_the_two_sides_of_a_triangle_have_colours_of_their_own_and_a_tint_covers_both():
    """A square seen from above and from below; a tinted one looks alike."""
    points = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.0]])
    square = np.array([[0, 1, 2], [0, 2, 3]])
    above, below = (
        MeshPicture(points, np.array(square), np.array([0.1, 0.1, z]), 30) for z in (1.0, -1.0)
    )

    def middle(picture, tints=None):
        rows, columns = picture.shape
        color = picture.image(tints)[rows // 2 - 5, columns // 2]
        assert color[3] == 1
        return color[:3] / color[:3].sum()

    assert middle(above)[2] > middle(above)[0]  # bluish
    assert middle(below)[2] < middle(below)[0]  # brownish
    red = {0: np.array([0.8, 0.1, 0.1]), 1: np.array([0.8, 0.1, 0.1])}
    for picture in (above, below):
        assert middle(picture, red)[0] > 0.6


@pytest.mark.parametrize(("pixels", "edge"), [(20, 1.0), (300, 0.6)])
def test_the_colour_of_a_triangle_is_that_of_its_side_or_its_tint_by_its_light(pixels, edge):
    """Of a tint 85 %, times (1 + |cos|) / 2 for the angle with the light; a large one is darker at
    its edges.
    """
    points, triangles = cube(9)
    triangles = triangles[::2]  # so that inner sides are seen
    toward = np.array([1.0, 1.1, 1.2])
    picture = MeshPicture(points, triangles, toward, pixels)
    a, b, c = points[triangles].swapaxes(0, 1) @ picture.axes
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    color = np.array([OUTSIDE if z > 0 else INSIDE for z in normal[:, 2]])
    seen = np.unique(picture.front[picture.front >= 0])
    tint = np.array([0.3, 0.5, 0.7])
    for triangle in seen[::3]:
        color[triangle] = (3 * color[triangle] + 17 * tint) / 20
    color *= (1 + abs(normal @ LIGHT)[:, None]) / 2
    shown = picture.front >= 0
    image = picture.image(dict.fromkeys(seen[::3].tolist(), tint)).reshape(-1, 4)[shown, :3]
    dark = np.where(picture.near_edge[shown], edge, 1.0)[:, None]
    np.testing.assert_allclose(image, dark * color[picture.front[shown]], atol=1e-12)


def test_a_triangle_that_faces_the_light_is_the_brightest():
    """And none is darker than half of it, whichever side is seen."""
    brightness = []
    for toward in np.random.default_rng(0).standard_normal((20, 3)):
        viewer = toward / np.linalg.norm(toward)
        picture = MeshPicture(TETRAHEDRON, OUTWARD, viewer, 40)
        image = picture.image()
        brightness += [*image[image[..., 3] > 0][:, 1]]
        assert (image[..., 3] <= 1).all()
    assert max(brightness) <= 0.9
    assert min(brightness) >= 0.4 * max(brightness) * 0.6  # at an edge, darker by 0.6
    assert min(brightness) < 0.6 * max(brightness)


def test_a_mesh_with_triangles_without_area_has_a_picture():
    """They are not seen, and colour nothing."""
    points = np.vstack([TETRAHEDRON, TETRAHEDRON[:1]])
    triangles = np.vstack([OUTWARD, [[0, 4, 1], [2, 2, 2]]])
    picture = MeshPicture(points, triangles, np.array([1.0, 1.0, 1.0]), 40)
    assert np.isfinite(picture.image()).all()
    assert picture.front.max() < 4


def test_edges_of_small_triangles_are_not_drawn():
    """They would cover the surface: where a triangle is 7 pixels wide or less."""
    points, triangles = cube(16)
    wide, small = (MeshPicture(points, triangles, np.array([1.0, 1.1, 1.2]), n) for n in (800, 60))
    for picture, levels in ((wide, 6), (small, 3)):
        image = picture.image()[..., :3].reshape(-1, 3).round(6)
        assert len(np.unique(image[image.any(axis=1)], axis=0)) == levels


def test_what_is_behind_the_surface_is_hidden():
    """Each vertex of a cube but the one farthest away is visible, and its middle is not."""
    points, triangles = cube(1)
    picture = MeshPicture(points, triangles, np.array([1.0, 1.1, 1.2]), 60)
    farthest = np.argmin(points @ [1.0, 1.1, 1.2])
    assert picture.hidden(picture.points).tolist() == [k == farthest for k in range(8)]
    assert picture.hidden(picture.points.mean(axis=0)[None]).all()
    beside = np.array([[-5.0, -5.0, 0.0], [500.0, 500.0, 0.0]])
    assert not picture.hidden(beside).any()


@pytest.mark.parametrize("middle", [None, np.array([3, 7, 9])])
def test_what_is_a_fiftieth_of_the_picture_behind_its_surface_is_hidden(middle):
    """In the middle of each pixel, also at the edge of a close-up."""
    points, triangles = cube(4)
    picture = MeshPicture(points, triangles, np.array([1.0, 1.1, 1.2]), 90, middle)
    pixel = np.flatnonzero(picture.front >= 0)
    row, column = np.divmod(pixel, picture.shape[1])
    behind = 0.02 * max(picture.shape)
    for further, hidden in ((-1e-6, False), (1e-6, True)):
        depth = picture.depth[pixel] - behind - further
        assert (picture.hidden(np.column_stack([column + 0.5, row + 0.5, depth])) == hidden).all()


def test_a_close_up_has_the_errors_in_its_middle():
    """Larger by 1 / 0.36 than the whole mesh, square, with as many pixels."""
    points, triangles = cube(4)
    toward = np.array([1.0, 1.1, 1.2])
    some = np.array([3, 7, 9])
    whole, near = (MeshPicture(points, triangles, toward, 90, m) for m in (None, some))
    assert near.shape == (90, 90)
    marked = near.points[some, :2]
    np.testing.assert_allclose((marked.min(axis=0) + marked.max(axis=0)) / 2, 45.0)
    sizes = [np.ptp(p.points, axis=0) for p in (whole, near)]
    np.testing.assert_allclose(sizes[1], sizes[0] / 0.36)


@pytest.mark.parametrize("near", [False, True])
def test_marks_are_drawn_on_the_picture_where_the_errors_are(near):
    """The picture fills its axes, which have no frame; marks beside a close-up are left out."""
    points, triangles = cube(4)
    triangles = triangles[2:]
    found = marks(audit_mesh(points, triangles), triangles)
    none = np.empty((0, 2), dtype=int)
    found["bow_tie_vertices"] = Marks(np.empty(0, dtype=int), none, np.array([0, len(points) - 1]))
    toward = np.array([1.0, 1.1, 1.2])
    middle = np.concatenate([mark.of_vertices(triangles) for mark in found.values()])
    picture = MeshPicture(points, triangles, toward, 80, middle if near else None)
    rows, columns = picture.shape
    with figure() as (page, axes):
        draw(axes, points, triangles, found, toward, pixels=80, near=near)
        page.draw_without_rendering()
        (image,) = axes.images
        assert image.get_array().shape == (rows, columns, 4)
        assert image.get_extent() == [0, columns, 0, rows]
        assert axes.get_xlim() == (0, columns)
        assert axes.get_ylim() == (0, rows)
        assert axes.get_aspect() == 1.0
        assert not axes.axison
        drawn = np.concatenate([line.get_xydata() for line in axes.lines])
        edges = np.concatenate([s for c in axes.collections for s in c.get_segments()])
    places = picture.points[[0, len(points) - 1], :2]
    inside = ((places >= 0) & (places <= [columns, rows])).all(axis=1)
    assert {*map(tuple, drawn.round(6))} == {*map(tuple, places[inside].round(6))}
    loop = found["boundary_loops"].edges
    assert {*map(tuple, edges.round(6))} == {*map(tuple, picture.points[loop.ravel(), :2].round(6))}


def test_hidden_edges_are_thinner_and_paler_than_visible_ones():
    """The twelve edges of a cube, of which three meet at the hidden corner."""
    points, triangles = cube(1)
    ends = np.array(
        [
            (i, j)
            for i in range(8)
            for j in range(i)
            if abs(points[i] - points[j]).sum() == np.ptp(points)
        ]
    )
    none = np.empty(0, dtype=int)
    with figure() as (_, axes):
        draw(
            axes,
            points,
            triangles,
            {"nonmanifold_edges": Marks(none, ends, none)},
            np.array([1.0, 1.1, 1.2]),
            pixels=60,
        )
        hidden, visible = axes.collections
    assert (len(hidden.get_segments()), len(visible.get_segments())) == (3, 9)
    assert 0 < hidden.get_alpha() < visible.get_alpha() == 1.0
    assert 0 < hidden.get_linewidth()[0] < visible.get_linewidth()[0]


def test_an_audit_is_drawn_from_two_opposite_sides():
    """With titles, and a legend that counts the errors of each concern; the page is full."""
    points, triangles = cube(2)
    page = plot_audit(audit_mesh(points, triangles[1:]), points, triangles[1:])
    left, right = page.axes
    titles = [axes.get_title("center") for axes in (left, right)]
    assert titles == ["from the front, right and above", "from behind, left and below"]
    pictures = [axes.images[0].get_array() for axes in (left, right)]
    assert max(pictures[0].shape) == max(pictures[1].shape) == 800
    views = np.array([*_VIEWS.values()])
    np.testing.assert_array_equal(views[0], -views[1])
    assert (np.sign(views[0]) == [1, -1, 1]).all()  # right, front, above
    (legend,) = page.legends
    assert [text.get_text() for text in legend.texts] == ["boundary: 1"]
    (handle,) = legend.legend_handles
    assert (handle.get_color(), handle.get_marker()) == (COLORS["boundary"], "^")
    assert filled(page) > 0.9
