"""Voronoi coordinates: barycentric coordinates of the circumcentres, and the slides' formula."""

import itertools
import math
from fractions import Fraction
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import ortho_group

from fieldrecon._core.chunks import Inline
from fieldrecon.barycentric.coordinates import BarycentricCoordinates
from fieldrecon.barycentric.voronoi import VoronoiCell, _merged, _ranked, voronoi_weights
from fieldrecon.meshes.simplex_mesh import SimplexMesh
from laws import assert_counted, assert_same_bits
from polytopes import HEXAGON, PYRAMID, RHOMBIC_DODECAHEDRON, kuhn, regular, star, voronoi_cell
from rational import determinant, dot, solved


@cache
def random_mesh(d):
    return SimplexMesh.delaunay(np.random.default_rng(d).random((150, d)))


def inner(mesh):
    return np.flatnonzero(~mesh.boundary_vertices & mesh.referenced)


def inside(corners, m, seed=0):
    share = np.random.default_rng(seed).dirichlet(np.full(len(corners), 0.5), m)
    return share @ corners


def per_corner(h, cell):
    """Weights of the mesh cells, summed for each corner of one Voronoi cell."""
    return np.stack([h[:, cells].sum(axis=1) for cells in cell.cells], axis=1)


def slides_weights(mesh, i, x):
    """The slides' D! V_a / prod (x_b - x_i)^T (p_a - x), one for each cell at vertex i."""
    w = []
    for a in mesh.vertex_cells(i):
        others = mesh.points[mesh.cells[a][mesh.cells[a] != i]]
        spokes = others - mesh.points[i]
        heights = spokes @ (mesh.circumcenters[a] - x)
        w.append(math.factorial(len(x)) * mesh.cell_measures[a] / np.prod(heights))
    return np.array(w) / np.sum(w)


# --- definition and formula ---------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("d", [2, 3])
def test_voronoi_coordinates_are_barycentric_coordinates_of_the_circumcentres(d):
    """The simplified formula of the slides does not use the circumcentres."""
    mesh = random_mesh(d)
    for i in inner(mesh)[:25]:
        cell = VoronoiCell(mesh, i)
        centers = mesh.circumcenters[np.concatenate(cell.cells)]
        assert abs(cell.points - centers).max() < 1e-12
        x = inside(cell.points, 10)
        full = BarycentricCoordinates(cell.points)
        assert abs(cell.weights(x) - full.weights(x)).max() < 1e-9
        gradients = zip(cell.gradient_weights(x), full.gradient_weights(x), strict=True)
        size = max(abs(g).max() for g in full.gradient_weights(x))
        assert max(abs(a - b).max() for a, b in gradients) < 1e-7 * size


@pytest.mark.parametrize("d", [2, 3])
def test_voronoi_coordinates_equal_the_quotients_of_the_slides_inside(d):
    """w_a = D! V_a / prod (x_b - x_i)^T (p_a - x), away from the faces."""
    mesh = random_mesh(d)
    for i in inner(mesh)[:25]:
        cell = VoronoiCell(mesh, i)
        x = 0.5 * inside(cell.points, 1, seed=i)[0] + 0.5 * mesh.points[i]
        assert abs(cell.weights(x)[0] - slides_weights(mesh, i, x)).max() < 1e-9


def test_the_quotients_of_the_slides_are_silently_wrong_on_an_edge():
    """In a hexagon rotated by 7.2 degrees the spiral begins on an edge of the dual cell."""
    angle = np.deg2rad(7.2) + np.arange(6) * np.pi / 3
    ring = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    mesh = SimplexMesh(np.vstack([[0, 0], ring]), [[0, 1 + k, 1 + (k + 1) % 6] for k in range(6)])
    cell = VoronoiCell(mesh, 0)
    x = 0.5 * ring
    ends = np.sort(cell.weights(x), axis=1)
    assert abs(ends - [0, 0, 0, 0, 0.5, 0.5]).max() < 1e-14
    with np.errstate(all="ignore"):
        naive = np.array([np.sort(slides_weights(mesh, 0, y)) for y in x])
    finite = np.isfinite(naive).all(axis=1)
    assert finite.any()
    assert abs(naive[finite] - ends[finite]).max() > 0.05


def test_the_spiral_in_the_hexagon_has_linear_precision():
    """Exercise of the slides: constants and linear fields are reproduced at all points s_n.

    s_n = (r/n)(cos, sin)(2 pi n / 50) with r = 1/2.
    """
    mesh = SimplexMesh(
        np.vstack([[0, 0], regular(6)]), [[0, 1 + k, 1 + (k + 1) % 6] for k in range(6)]
    )
    cell = VoronoiCell(mesh, 0)
    a, b = cell.points[:2]
    r = np.linalg.norm((a + b) / 2)
    assert r == pytest.approx(0.5)
    n = np.arange(1, 51)
    angle = 2 * np.pi * n / 50
    s = (r / n)[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    assert abs(cell.field(np.ones(6))(s) - 1).max() < 1e-15
    linear = cell.field(cell.points.sum(axis=1))(s)
    assert abs(linear - s.sum(axis=1)).max() < 1e-15
    # no point is outside; quadratic fields are not reproduced: |p|^2 is 1/3 at all corners
    assert cell.weights(s).min() > 5e-4
    quadratic = cell.field((cell.points**2).sum(axis=1))(s)
    assert abs(quadratic - 1 / 3).max() < 1e-15


def test_weights_at_the_vertex_are_positive():
    """They are V_a / prod l_b^2 up to normalization, also if the cells are not Delaunay."""
    rng = np.random.default_rng(5)
    for _ in range(20):
        n = 6
        angle = 2 * np.pi * (np.arange(n) + 0.6 * rng.random(n)) / n
        ring = (0.2 + rng.random(n))[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        mesh = SimplexMesh(
            np.vstack([[0, 0], ring]), [[0, 1 + k, 1 + (k + 1) % n] for k in range(n)]
        )
        w = VoronoiCell(mesh, 0).weights([0.0, 0.0])[0]
        squares = (ring**2).sum(axis=1)
        plain = mesh.cell_measures / (squares * np.roll(squares, -1))
        assert abs(w - plain / plain.sum()).max() < 1e-14
        assert w.min() > 0


def test_a_star_that_is_not_delaunay_reproduces_linear_fields():
    """The dual polygon intersects itself.

    Linear fields are reproduced wherever the weights are defined.
    """
    ring = np.array([[1, 0.1], [0.1, 0.3], [-1, 0.2], [-0.8, -0.5], [0.1, -0.25], [0.9, -0.6]])
    mesh = SimplexMesh(np.vstack([[0, 0], ring]), [[0, 1 + k, 1 + (k + 1) % 6] for k in range(6)])
    cell = VoronoiCell(mesh, 0)
    lengths = (ring**2).sum(axis=1) / 2
    low = (lengths - cell.points @ ring.T).min(axis=1)
    assert low.min() < -0.01  # some corner lies outside the Voronoi cell
    x = 0.1 * np.random.default_rng(8).normal(size=(20, 2))
    assert abs(cell.weights(x) @ cell.points - x).max() < 1e-10


# --- coincident circumcentres -------------------------------------------------------------------


@pytest.mark.parametrize("d", [2, 3])
def test_voronoi_coordinates_on_a_lattice_are_multilinear(d):
    """Squares and cubes are cut into simplices; coincident circumcentres share a weight."""
    mesh = kuhn(3, d)
    i = int(np.flatnonzero((mesh.points == 1).all(axis=1))[0])
    cell = VoronoiCell(mesh, i)
    assert len(cell.points) == 2**d
    assert sorted(len(c) for c in cell.cells) == sorted({2: [1, 1, 2, 2], 3: [2] * 6 + [6] * 2}[d])
    rng = np.random.default_rng(3)
    x = np.vstack([cell.points, mesh.points[i][None], rng.uniform(0.5, 1.5, (30, d))])
    x = np.vstack([x, np.where(np.arange(d) < d - 1, 0.5, 0.8)])  # on an edge
    exact = np.where(cell.points == 1.5, x[:, None] - 0.5, 1.5 - x[:, None]).prod(axis=2)
    assert abs(cell.weights(x) - exact).max() < 1e-15
    together = voronoi_weights(mesh, np.full(len(x), i), x).toarray()
    assert abs(per_corner(together, cell) - exact).max() < 1e-14
    assert abs(together @ mesh.circumcenters - x).max() < 1e-14


def test_weights_on_a_lattice_are_invariant_under_rigid_motions():
    """In the moved lattice circumcentres coincide only up to rounding."""
    flat = kuhn(3, 3)
    q, _ = np.linalg.qr(np.random.default_rng(4).normal(size=(3, 3)))
    for offset in (0.0, 100.0):
        mesh = SimplexMesh(flat.points @ q + offset, flat.cells)
        here, there = VoronoiCell(flat, 13), VoronoiCell(mesh, 13)
        assert [c.tolist() for c in there.cells] == [c.tolist() for c in here.cells]
        x = np.vstack([here.points, inside(here.points, 20)])
        error = abs(there.weights(x @ q + offset) - here.weights(x)).max()
        assert error < 1e-14 * (10 + offset)


def test_the_cell_of_the_face_centred_lattice_has_corners_of_four_faces():
    """The slides call Voronoi cells simple.

    The rhombic dodecahedron is a Voronoi cell and is not simple.
    """
    for corners in (RHOMBIC_DODECAHEDRON, PYRAMID):
        cell = voronoi_cell(corners)
        assert abs(cell.points - corners).max() < 1e-13
        x = inside(corners, 20)
        full = BarycentricCoordinates(corners)
        assert abs(cell.weights(x) - full.weights(x)).max() < 1e-12
        assert abs(cell.weights(corners) - np.eye(len(corners))).max() < 1e-12
        beside = corners + 1e-9 * (x[0] - corners)
        assert abs(cell.weights(beside) @ corners - beside).max() < 1e-13
    assert max(len(c) for c in cell.cells) == 2


@pytest.mark.parametrize("corners", [RHOMBIC_DODECAHEDRON, PYRAMID], ids=["14 corners", "5"])
def test_at_a_corner_of_four_faces_the_weights_are_exact_and_have_no_gradient(corners):
    """In any position and unit, although the four heights there are rounded."""
    for seed, unit in enumerate((1e-9, 1.0, 1e9)):
        q = ortho_group.rvs(3, random_state=seed)
        cell = voronoi_cell(unit * (corners @ q + 0.1))
        crowded = [a for a, cells in enumerate(cell.cells) if len(cells) == 2]
        assert len(crowded) == (6 if len(corners) == 14 else 1)
        assert (cell.weights(cell.points[crowded]) == np.eye(len(corners))[crowded]).all()
        x = inside(cell.points, 9)
        assert abs(cell.weights(x) @ cell.points - x).max() < 1e-12 * unit
        for a in crowded:
            with pytest.raises(ValueError, match="no gradient at the corner"):
                cell.gradient_weights(cell.points[a])


def test_cocircular_points_give_one_corner():
    """Four triangles have one circumcentre.

    The merged corner keeps its two outer faces and all four cells.
    """
    angle = np.deg2rad([-120, -60, 0, 60, 120])
    arc = np.stack([1 + np.cos(angle), np.sin(angle)], axis=1)
    ring = np.vstack([arc, [[-1.0, 1.5], [-1.25, -1.5]]])
    mesh = SimplexMesh(np.vstack([[0, 0], ring]), [[0, 1 + k, 1 + (k + 1) % 7] for k in range(7)])
    cell = VoronoiCell(mesh, 0)
    assert [c.tolist() for c in cell.cells] == [[0, 1, 2, 3], [4], [5], [6]]
    assert abs(cell.points[0] - [1, 0]).max() < 1e-15
    x = np.vstack([cell.points, inside(cell.points, 10)])
    full = BarycentricCoordinates(cell.points)
    assert abs(cell.weights(x) - full.weights(x)).max() < 1e-13
    together = voronoi_weights(mesh, 0, x).toarray()
    assert abs(per_corner(together, cell) - full.weights(x)).max() < 1e-13


# --- many cells at once -------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("d", [2, 3])
def test_voronoi_weights_equal_those_of_single_cells(d):
    """Queries are vertices, points near them, corners of cells and points outside."""
    mesh = random_mesh(d)
    vertices, queries, expected = [], [], []
    rng = np.random.default_rng(6)
    for i in inner(mesh)[:40]:
        cell = VoronoiCell(mesh, i)
        x = np.vstack([mesh.points[i][None], inside(cell.points, 2, seed=i), cell.points[:1]])
        w = np.zeros((len(x), len(mesh.cells)))
        for a, cells in enumerate(cell.cells):
            w[:, cells] = cell.weights(x)[:, [a]] / len(cells)
        vertices += [i] * len(x)
        queries.append(x)
        expected.append(w)
    queries, expected = np.vstack(queries), np.vstack(expected)
    order = rng.permutation(len(queries))
    h = voronoi_weights(mesh, np.array(vertices)[order], queries[order])
    assert h.shape == (len(queries), len(mesh.cells))
    assert h.nnz == sum(len(mesh.vertex_cells(i)) for i in vertices)
    assert abs(h.toarray() - expected[order]).max() < 1e-9


def test_voronoi_weights_do_not_depend_on_the_executor():
    """The same bits, and progress counts the queries up to their number."""
    mesh, calls = random_mesh(2), []
    vertices = inner(mesh)
    x = mesh.points[vertices] + 1e-3
    here = voronoi_weights(mesh, vertices, x)
    there = voronoi_weights(
        mesh, vertices, x, executor=Inline(), progress=lambda *call: calls.append(call)
    )
    assert_same_bits(there, here)
    assert_counted(calls, len(vertices))
    assert calls[-1] == (len(vertices), len(vertices))


def test_one_vertex_may_be_given_for_all_queries():
    """Leading axes of the queries are flattened, as in the weights of a method."""
    mesh = random_mesh(2)
    i = int(inner(mesh)[0])
    x = mesh.points[i] + np.zeros((2, 3, 2))
    one = voronoi_weights(mesh, i, x)
    assert one.shape == (6, len(mesh.cells))
    assert (one != voronoi_weights(mesh, np.full((2, 3), i), x)).nnz == 0
    assert voronoi_weights(mesh, np.zeros(0, int), np.zeros((0, 2))).shape[0] == 0


@settings(max_examples=25)
@given(st.integers(0, 2**32), st.sampled_from([2, 3]), st.sampled_from([1e-120, 1.0, 1e120]))
def test_weights_on_random_meshes_are_positive_with_linear_precision(seed, d, unit):
    """The queries are interior vertices, in three units of length."""
    rng = np.random.default_rng(seed)
    mesh = SimplexMesh.delaunay(rng.random((40, d)) * unit)
    vertices = inner(mesh)
    x = mesh.points[vertices]
    h = voronoi_weights(mesh, vertices, x)
    assert h.data.min(initial=0.0) >= 0
    assert abs(h @ mesh.circumcenters - x).max(initial=0.0) < 1e-9 * unit


# --- refusals -----------------------------------------------------------------------------------


def test_open_cells_and_invalid_vertices_are_refused():
    """The message has the index of the vertex."""
    mesh = SimplexMesh(
        np.vstack([star(HEXAGON).points, [[9.0, 9.0]]]), star(HEXAGON).cells
    )  # one point that no cell has
    for vertex, words in (
        (1, "1 lies on the boundary of the mesh: its Voronoi cell is open"),
        (7, "7 belongs to no cell"),
        (8, "must be an index of a point, 0 to 7; got 8"),
        (-1, "must be an index of a point, 0 to 7; got -1"),
        (0.0, r"must be an index of a point, an integer; got 0\.0"),
        (True, "must be an index of a point, an integer; got True"),
    ):
        with pytest.raises(ValueError, match=f"vertex {words}"):
            VoronoiCell(mesh, vertex)
        with pytest.raises(ValueError, match=f"vertices {words}"):
            voronoi_weights(mesh, vertex, [0.5, 0.5])
    with pytest.raises(ValueError, match="vertex must be an index of a point, an integer"):
        VoronoiCell(mesh, [0])
    with pytest.raises(ValueError, match=r"one for each query, shape \(3,\), .* got the shape \(2"):
        voronoi_weights(mesh, [0, 0], np.zeros((3, 2)))
    with pytest.raises(ValueError, match="x must have 2 coordinates per point"):
        voronoi_weights(mesh, 0, np.zeros((3, 3)))


def test_the_formula_at_boundary_vertices_loses_linear_precision():
    """There the weights sum to 1 but do not reproduce positions.

    Therefore open cells are refused.
    """
    mesh = random_mesh(2)
    worst = 0.0
    for i in np.flatnonzero(mesh.boundary_vertices):
        cells = mesh.vertex_cells(i)
        x = mesh.cell_centers[cells[0]]
        w = slides_weights(mesh, i, x)
        assert w.sum() == pytest.approx(1)
        if abs(w).max() < 2:
            worst = max(worst, abs(w @ mesh.circumcenters[cells] - x).max())
    assert worst > 0.05


def test_poles_outside_are_refused():
    """The poles are those of the barycentric coordinates."""
    square = np.array([[0.0, 0], [2, 0], [3, 2], [0, 1]])
    with pytest.raises(
        np.linalg.LinAlgError, match=r"no value at \(-1.5, -2\): the weights of the"
    ):
        voronoi_cell(square).weights([-1.5, -2.0])
    with pytest.raises(
        np.linalg.LinAlgError, match=r"no value at \(-1.5, -2\): the weights of the"
    ):
        voronoi_weights(star(square), 0, [-1.5, -2.0])


def weighted_corner(edges, x, volume):
    """w_a (p_a - x), with the circumcentre p_a of a cell at the origin; exact."""
    corner = solved(edges, [dot(e, e) / 2 for e in edges])
    weight = volume / math.prod(dot(e, e) / 2 - dot(e, x) for e in edges)
    return [weight * (p - t) for p, t in zip(corner, x, strict=True)]


def test_a_folded_star_has_no_linear_precision():
    """At about 0°, 100°, 80°, 200° and 290°: two cells at a face can lie on the same side of it.

    With the signed volume of the second cell, which is negative, the sum is zero.
    """
    rim = [[Fraction(k) for k in v] for v in ([6, 0], [-1, 6], [1, 5], [-6, -2], [2, -6])]
    x = [Fraction(1, 7), Fraction(2, 7)]
    cells = list(zip(rim, [*rim[1:], rim[0]], strict=True))
    volumes = [determinant(list(edges)) for edges in cells]
    assert [v > 0 for v in volumes] == [True, False, True, True, True]
    for measured, precise in (([abs(v) for v in volumes], False), (volumes, True)):
        terms = [weighted_corner(e, x, v) for e, v in zip(cells, measured, strict=True)]
        assert ([sum(column) for column in zip(*terms, strict=True)] == [0, 0]) == precise


def test_linear_precision_of_any_star_in_any_dimension():
    """Exact, for positively oriented cells that surround x_i, mostly not Delaunay; no fan."""
    rng = np.random.default_rng(4)
    for d in (2, 3, 4):
        axes = [[Fraction(int(k == j)) for k in range(d)] for j in range(d)]
        spokes = {}
        for j, sign in itertools.product(range(d), (-1, 1)):
            noise = [Fraction(int(t), 9) for t in rng.integers(-4, 5, d)]
            length = sign * int(rng.integers(3, 9))
            spokes[j, sign] = [length * e + t for e, t in zip(axes[j], noise, strict=True)]
        x = [Fraction(int(t), 7) for t in rng.integers(-5, 6, d)]
        terms = []
        for signs in itertools.product((-1, 1), repeat=d):
            edges = [spokes[j, sign] for j, sign in enumerate(signs)]
            volume = determinant(edges) * math.prod(signs)  # times d!
            assert volume > 0
            terms.append(weighted_corner(edges, x, volume))
        assert [sum(column) for column in zip(*terms, strict=True)] == [0] * d
        assert any(sum(column) != 0 for column in zip(*terms[1:], strict=True))


def test_only_neighbours_with_the_same_circumcentre_share_a_corner():
    """In a star that is not Delaunay, others may have it by chance."""
    ring = np.array([[0, 1], [1, 2], [2, 3], [3, 4], [4, 0]])
    centers = np.array([[0.0, 0.0], [0.0, 1e-9], [5.0, 0.0], [0.0, 0.0], [0.0, 3.0]])
    assert _merged(centers, ring, 1e-8).tolist() == [0, 0, 1, 2, 3]
    in_space = np.array([[0, 1, 2], [0, 1, 3], [2, 3, 4], [0, 5, 6], [7, 8, 9]])
    assert _merged(np.zeros((5, 3)), in_space, 1e-8).tolist() == [0, 0, 1, 2, 3]


def test_distinct_entries_of_rows_and_their_ranks():
    """Each row by itself, as by `numpy.unique`."""
    a = np.random.default_rng(6).integers(0, 5, (20, 6))
    distinct, valid, ranks = _ranked(a)
    for row, found, there, rank in zip(a, distinct, valid, ranks, strict=True):
        np.testing.assert_array_equal(found[there], np.unique(row))
        np.testing.assert_array_equal(found[rank], row)
