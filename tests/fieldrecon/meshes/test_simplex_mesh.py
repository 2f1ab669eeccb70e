"""Laws of meshes: topology, geometry, and invariance under changes of origin, unit and order.

A law is a function of a mesh, so that it can be applied to broken meshes, which must violate it.
"""

import math
import pickle
import re
from fractions import Fraction
from itertools import combinations, pairwise, permutations, product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial import ConvexHull, Delaunay
from scipy.stats import ortho_group

from fieldrecon.meshes import delaunay
from fieldrecon.meshes import topology as _topology
from fieldrecon.meshes.delaunay import _outer, _refuse_cracks, _violations
from fieldrecon.meshes.duals import barycentric_dual, circumcentric_dual
from fieldrecon.meshes.exact_delaunay import _independent, _is_independent, exact_delaunay_cells
from fieldrecon.meshes.simplex_mesh import SimplexMesh
from fieldrecon.meshes.simplices import signed_volumes, units
from rational import determinant, dot, minus, rational

EPS = np.finfo(float).eps
SQUARE = [[0, 0], [1, 0], [1, 1], [0, 1]]


def random_points(d: int, n: int = 60) -> np.ndarray:
    return np.random.default_rng(8).random((n, d))


def grid(d: int, n: int = 6) -> np.ndarray:
    """Points of a regular grid, with many cocircular points and many points on the hull."""
    axis = np.arange(n) / (n - 1)
    return np.stack(np.meshgrid(*[axis] * d, indexing="ij"), axis=-1).reshape(-1, d)


def rotated(points: np.ndarray) -> np.ndarray:
    return points @ ortho_group.rvs(points.shape[1], random_state=2)


CLOUDS = {
    "random": random_points,
    "grid": grid,
    "turned grid": lambda d: rotated(grid(d)),
    "turned grid far away": lambda d: rotated(grid(d)) + 1e6,
}
MESHES = {
    f"{name} {d}-D": SimplexMesh.delaunay(cloud(d))
    for name, cloud in CLOUDS.items()
    for d in (2, 3)
}
every_mesh = pytest.mark.parametrize("mesh", MESHES.values(), ids=MESHES.keys())
both_dimensions = pytest.mark.parametrize("d", [2, 3])


def outward_vectors(mesh: SimplexMesh) -> np.ndarray:
    """Outward normal times measure for the faces of each cell, (c, d + 1, d)."""
    vectors = mesh.face_normals * mesh.face_measures[:, None]
    return mesh.cell_face_signs[..., None] * vectors[mesh.cell_faces]


# --- laws -----------------------------------------------------------------------------------------


def euler_s_formula_holds(mesh):
    """The alternating sum over vertices, edges, faces and cells must be that of a ball, 1."""
    vertices, edges = mesh.referenced.sum(), len(mesh.edges)
    if mesh.points.shape[1] == 2:
        assert vertices - edges + len(mesh.cells) == 1
    else:
        assert vertices - edges + len(mesh.faces) - len(mesh.cells) == 1


def faces_are_the_sides_of_cells(mesh):
    """Each face must be listed once with increasing vertices.

    The k-th face of a cell must be opposite its k-th vertex.
    """
    assert (np.diff(mesh.faces, axis=1) > 0).all()
    assert len(np.unique(mesh.faces, axis=0)) == len(mesh.faces)
    for k in range(mesh.cells.shape[1]):
        side = np.sort(np.delete(mesh.cells, k, axis=1), axis=1)
        assert np.array_equal(mesh.faces[mesh.cell_faces[:, k]], side)


def cells_and_faces_refer_to_each_other(mesh):
    """Cell i must list face f if and only if face f lists cell i."""
    of_cells = {(i, f) for i, row in enumerate(mesh.cell_faces.tolist()) for f in row}
    pairs = ((i, f) for f, row in enumerate(mesh.face_cells.tolist()) for i in row)
    assert of_cells == {pair for pair in pairs if pair[0] >= 0}
    one, two = mesh.face_cells.T
    assert (one >= 0).all()
    assert ((two > one) | (two == -1)).all()
    assert np.array_equal(mesh.boundary_faces, np.flatnonzero(two == -1))


def cells_are_positively_oriented(mesh):
    """The determinant of the edges from the first vertex must be positive."""
    corners = mesh.points[mesh.cells]
    assert (np.linalg.det(corners[:, 1:] - corners[:, :1]) > 0).all()
    assert (mesh.cell_measures > 0).all()


def normals_point_from_the_first_cell_to_the_second(mesh):
    """Unit normals must point away from the opposite vertex of the first cell.

    They must point towards the opposite vertex of the second cell.
    """
    np.testing.assert_allclose(np.linalg.norm(mesh.face_normals, axis=1), 1, rtol=4 * EPS)
    opposite = mesh.points[mesh.cells] - mesh.face_centers[mesh.cell_faces]
    along = np.einsum("cki,cki->ck", opposite, mesh.face_normals[mesh.cell_faces])
    assert (along * mesh.cell_face_signs < 0).all()
    assert (mesh.cell_face_signs[mesh.face_cells[:, 0]] != 0).all()
    first = mesh.face_cells[mesh.cell_faces, 0] == np.arange(len(mesh.cells))[:, None]
    assert np.array_equal(mesh.cell_face_signs > 0, first)


def normals_are_perpendicular_to_faces(mesh):
    """A normal must be perpendicular to every edge of its face."""
    corners = mesh.points[mesh.faces]
    edges = corners[:, 1:] - corners[:, :1]
    along = np.einsum("fki,fi->fk", edges, mesh.face_normals)
    assert (np.abs(along) <= 16 * EPS * np.linalg.norm(edges, axis=2)).all()


def cells_are_closed(mesh):
    """Outward normals times measures must sum to zero."""
    vectors = outward_vectors(mesh)
    size = np.abs(vectors).max(axis=(1, 2))
    assert (np.abs(vectors.sum(axis=1)).max(axis=1) <= 16 * EPS * size).all()


def the_divergence_theorem_holds(mesh):
    """The flux of u(x) = a + G x out of a cell must be tr G times its measure."""
    rng = np.random.default_rng(4)
    d = mesh.points.shape[1]
    g, origin = rng.normal(size=(d, d)), mesh.points.mean(axis=0)
    u = rng.normal(size=d) + (mesh.face_centers - origin) @ g.T
    flux = np.einsum("cki,cki->c", outward_vectors(mesh), u[mesh.cell_faces])
    size = np.abs(u).max() * mesh.face_measures[mesh.cell_faces].max(axis=1)
    # the rounding error of centroids is that of the coordinates
    tolerance = 40 * (EPS * size + np.spacing(np.abs(mesh.points).max()) * size / np.abs(u).max())
    assert (np.abs(flux - np.trace(g) * mesh.cell_measures) <= tolerance).all()


def cells_fill_the_hull(mesh):
    """The cells must sum to the hull and boundary faces to its surface: no gaps, no overlaps."""
    local = mesh.points - mesh.points[0]
    hull = ConvexHull(local)
    rounding = 100 * max(np.spacing(np.abs(mesh.points).max()), EPS)
    assert math.isclose(mesh.cell_measures.sum(), hull.volume, rel_tol=rounding)
    boundary = mesh.face_measures[mesh.boundary_faces].sum()
    assert math.isclose(boundary, hull.area, rel_tol=rounding)


def circumcentres_are_equidistant_from_all_corners(mesh):
    """This must hold for the circumcentres of cells and of faces."""
    for corners, centers in [
        (mesh.points[mesh.cells], mesh.circumcenters),
        (mesh.points[mesh.faces], mesh.face_circumcenters),
    ]:
        distance = np.linalg.norm(corners - centers[:, None], axis=2)
        size = np.linalg.norm(corners[:, 1:] - corners[:, :1], axis=2).max(axis=1)
        radius = distance.max(axis=1)
        tolerance = 100 * EPS * (radius / size) ** 2 * size + np.spacing(np.abs(corners).max()) * 4
        assert (np.ptp(distance, axis=1) <= tolerance * np.maximum(radius / size, 1)).all()


def circumcentric_duals_are_perpendicular(mesh):
    """Each dual edge must be perpendicular to its face, up to the rounding of its end points."""
    segments, faces = circumcentric_dual(mesh)
    corners = mesh.points[mesh.faces[faces]]
    edges = corners[:, 1:] - corners[:, :1]
    dual = segments[:, 1] - segments[:, 0]
    along = np.abs(np.einsum("fki,fi->fk", edges, dual)) / np.linalg.norm(edges, axis=2)
    radii = np.linalg.norm(segments - corners[:, :1], axis=2).max(axis=1)
    shortest = np.linalg.norm(edges, axis=2).min(axis=1)
    tolerance = 100 * (EPS * radii + np.spacing(np.abs(segments).max())) * (radii / shortest + 1)
    assert (along <= tolerance[:, None]).all()


LAWS = [
    euler_s_formula_holds,
    faces_are_the_sides_of_cells,
    cells_and_faces_refer_to_each_other,
    cells_are_positively_oriented,
    normals_point_from_the_first_cell_to_the_second,
    normals_are_perpendicular_to_faces,
    cells_are_closed,
    the_divergence_theorem_holds,
    cells_fill_the_hull,
    circumcentres_are_equidistant_from_all_corners,
    circumcentric_duals_are_perpendicular,
]


@every_mesh
@pytest.mark.parametrize("law", LAWS, ids=lambda law: law.__name__)
def test_every_mesh_obeys_the_laws(law, mesh):
    law(mesh)


# --- meshes that violate a law --------------------------------------------------------------------


def mesh_with(d: int, **arrays) -> SimplexMesh:
    """A mesh in which some cached arrays are replaced, given as functions of the correct mesh."""
    right, wrong = MESHES[f"random {d}-D"], SimplexMesh.delaunay(random_points(d))
    for name, make in arrays.items():
        wrong.__dict__[name] = make(right)
    return wrong


def first_two_exchanged(mesh):
    """Cells whose first two vertices are exchanged."""
    return mesh.cells[:, [1, 0, *range(2, mesh.cells.shape[1])]]


def textbook_circumcenters(mesh):
    """Circumcentres from squares of coordinates, which lose their digits far from the origin."""
    corners = mesh.points[mesh.cells]
    squares = (corners**2).sum(axis=2)
    edges = corners[:, 1:] - corners[:, :1]
    return np.linalg.solve(2 * edges, (squares[:, 1:] - squares[:, :1])[..., None])[..., 0]


MISTAKES = {
    "a cell is missing": (
        cells_fill_the_hull,
        lambda d: SimplexMesh(random_points(d), MESHES[f"random {d}-D"].cells[1:]),
    ),
    "one hole": (
        euler_s_formula_holds,
        lambda d: SimplexMesh(
            grid(d), np.array([c for c in MESHES[f"grid {d}-D"].cells if 2 * 6**d // 5 not in c])
        ),
    ),
    "faces in another order": (
        faces_are_the_sides_of_cells,
        lambda d: mesh_with(d, cell_faces=lambda m: m.cell_faces[:, ::-1]),
    ),
    "neighbours exchanged": (
        cells_and_faces_refer_to_each_other,
        lambda d: mesh_with(d, face_cells=lambda m: m.face_cells[::-1]),
    ),
    "negative cells": (
        cells_are_positively_oriented,
        lambda d: mesh_with(d, cells=first_two_exchanged),
    ),
    "normals inward": (
        normals_point_from_the_first_cell_to_the_second,
        lambda d: mesh_with(d, _face_vectors=lambda m: (-m.face_normals, m.face_measures)),
    ),
    "normals from cell centres": (
        normals_are_perpendicular_to_faces,
        lambda d: mesh_with(
            d, _face_vectors=lambda m: (np.ones_like(m.face_normals), m.face_measures)
        ),
    ),
    "measures not of the faces": (
        cells_are_closed,
        lambda d: mesh_with(d, _face_vectors=lambda m: (m.face_normals, 0 * m.face_measures + 1)),
    ),
    "twice the measure": (
        the_divergence_theorem_holds,
        lambda d: mesh_with(d, cell_measures=lambda m: 2 * m.cell_measures),
    ),
    "centroids": (
        circumcentres_are_equidistant_from_all_corners,
        lambda d: mesh_with(d, circumcenters=lambda m: m.cell_centers),
    ),
    "centroids of faces": (
        circumcentric_duals_are_perpendicular,
        lambda d: mesh_with(d, circumcenters=lambda m: m.cell_centers),
    ),
}


@both_dimensions
@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_law_rejects_its_broken_mesh(mistake, d):
    law, make = MISTAKES[mistake]
    mesh = make(d)
    with pytest.raises(AssertionError):
        law(mesh)


def test_every_law_has_a_broken_mesh():
    assert {law for law, _ in MISTAKES.values()} == set(LAWS)


# --- numbers of cells, faces and edges at a vertex ------------------------------------------------


def counts_at(mesh: SimplexMesh, i: int) -> tuple[int, int, int]:
    """Numbers of cells, faces and edges at vertex i, each counted in its own list."""
    return tuple(
        int((rows == i).any(axis=1).sum()) for rows in (mesh.cells, mesh.faces, mesh.edges)
    )


def test_faces_at_a_vertex_in_the_plane():
    """N cells and N faces, which are edges, meet at an interior vertex.

    At a boundary vertex N + 1 faces.
    """
    mesh = MESHES["random 2-D"]
    for i in range(len(mesh.points)):
        cells, faces, _ = counts_at(mesh, i)
        assert faces == cells + mesh.boundary_vertices[i]


def test_faces_and_edges_at_a_vertex_in_space():
    """An interior vertex with N cells has 3N/2 faces and N/2 + 2 edges.

    Its link is a triangulated sphere.
    """
    mesh = MESHES["random 3-D"]
    inside = np.flatnonzero(~mesh.boundary_vertices)
    assert len(inside) > 10
    for i in inside:
        cells, faces, edges = counts_at(mesh, i)
        assert (2 * faces, 2 * edges) == (3 * cells, cells + 4)


@every_mesh
def test_incidence_matrices_equal_the_lists(mesh):
    """This covers vertices in cells, vertices in faces, and faces in cells."""
    for matrix, rows in [
        (mesh.vertex_cell_incidence, mesh.cells),
        (mesh.vertex_face_incidence, mesh.faces),
        (mesh.cell_face_incidence.T, mesh.cell_faces),
    ]:
        wanted = {(v, j) for j, row in enumerate(rows.tolist()) for v in row}
        assert set(zip(*map(np.ndarray.tolist, matrix.nonzero()), strict=True)) == wanted
        assert (matrix.tocsr().data == 1).all()
    assert mesh.vertex_cells(3).tolist() == np.flatnonzero((mesh.cells == 3).any(axis=1)).tolist()


@both_dimensions
def test_rings_equal_their_definition_by_sets(d):
    """The next ring consists of all cells with a vertex in the current ring.

    It can be computed for all or for some vertices.
    """
    mesh = MESHES[f"random {d}-D"]
    for rings in (1, 2, 3):
        cells, faces = mesh.cells_around(rings), mesh.faces_around(rings)
        for i in (0, 7, 31):
            vertices = {i}
            for _ in range(rings):
                ring = [c for c, row in enumerate(mesh.cells.tolist()) if vertices & set(row)]
                vertices = set(mesh.cells[ring].ravel().tolist())
            assert np.flatnonzero(cells[[i]].toarray()).tolist() == ring
            sides = np.unique(mesh.cell_faces[ring])
            assert np.flatnonzero(faces[[i]].toarray()).tolist() == sides.tolist()
        some = mesh.faces_around(rings, [31, 7])
        assert np.array_equal(some.toarray(), faces[[31, 7]].toarray())
        assert faces.max() == cells.max() == 1


# --- exact values ---------------------------------------------------------------------------------


def exact_circumcentre(corners: np.ndarray) -> list[Fraction]:
    """Gaussian elimination in rational arithmetic."""
    p = [[Fraction(x) for x in corner] for corner in corners.tolist()]
    edges = [[a - b for a, b in zip(q, p[0], strict=True)] for q in p[1:]]
    rows = [[*e, sum(x * x for x in e) / 2] for e in edges]
    for k in range(len(rows)):
        pivot = next(i for i in range(k, len(rows)) if rows[i][k])
        rows[k], rows[pivot] = rows[pivot], rows[k]
        rows[k] = [x / rows[k][k] for x in rows[k]]
        for i in range(len(rows)):
            if i != k:
                rows[i] = [x - rows[i][k] * y for x, y in zip(rows[i], rows[k], strict=True)]
    return [row[-1] + x for row, x in zip(rows, p[0], strict=True)]


@both_dimensions
@pytest.mark.parametrize("offset", [0.0, 1e6])
@pytest.mark.parametrize("thin", [1.0, 1e-3, 1e-6])
def test_circumcentres_equal_rational_arithmetic(d, offset, thin):
    """The error is at most of order ε R²/h, also for slivers far from the origin."""
    rng = np.random.default_rng(6)
    stretch = np.r_[np.ones(d - 1), thin]
    for _ in range(20):
        corners = rng.normal(size=(d + 1, d)) * stretch + offset
        mesh = SimplexMesh(corners, [range(d + 1)])
        exact = exact_circumcentre(corners)
        error = max(
            abs(float(Fraction(c) - e)) for c, e in zip(mesh.circumcenters[0], exact, strict=True)
        )
        radius = float(max(abs(e - Fraction(x)) for e, x in zip(exact, corners[0], strict=True)))
        height = mesh.cell_measures[0] / mesh.face_measures.max()
        assert error <= 20 * EPS * radius * max(1, radius / height) + 2 * np.spacing(offset)


@pytest.mark.parametrize("d", [2, 3])
def test_circumcentres_from_squares_of_coordinates_are_wrong_far_away(d):
    """At an offset of 10⁸ they have no correct digit, while those from differences have eight."""
    points = random_points(d, 20) + 1e8
    mesh = SimplexMesh.delaunay(points)
    mesh.__dict__["circumcenters"] = textbook_circumcenters(mesh)
    with pytest.raises(AssertionError):
        circumcentres_are_equidistant_from_all_corners(mesh)
    circumcentres_are_equidistant_from_all_corners(SimplexMesh.delaunay(points))


@both_dimensions
def test_geometry_of_the_reference_simplex(d):
    """The measure is 1/d!, the circumcentre is (1/2, …); the slanted face is opposite vertex 0."""
    mesh = SimplexMesh(np.vstack([np.zeros(d), np.eye(d)]), [range(d + 1)])
    assert math.isclose(mesh.cell_measures[0], 1 / math.factorial(d), rel_tol=4 * EPS)
    np.testing.assert_allclose(mesh.circumcenters[0], 0.5, rtol=4 * EPS)
    np.testing.assert_allclose(mesh.cell_centers[0], 1 / (d + 1), rtol=4 * EPS)
    slanted = mesh.cell_faces[0, 0]
    np.testing.assert_allclose(mesh.face_normals[slanted], 1 / math.sqrt(d), rtol=4 * EPS)
    np.testing.assert_allclose(mesh.face_circumcenters[slanted], 1 / d, rtol=4 * EPS)
    np.testing.assert_allclose(mesh.face_centers[slanted], 1 / d, rtol=4 * EPS)
    assert math.isclose(mesh.face_measures[slanted], math.sqrt(d) / math.factorial(d - 1))


# --- invariance -----------------------------------------------------------------------------------

GEOMETRY = ("cell_measures", "circumcenters", "face_measures", "face_normals", "face_circumcenters")


@both_dimensions
def test_the_mesh_does_not_depend_on_the_orientation_of_cells(d):
    """Any permutation of the vertices of a cell gives the same mesh."""
    right, rng = MESHES[f"random {d}-D"], np.random.default_rng(1)
    shuffled = rng.permuted(right.cells, axis=1)
    mesh = SimplexMesh(right.points, shuffled)
    cells_are_positively_oriented(mesh)
    assert np.array_equal(mesh.faces, right.faces)
    assert np.array_equal(mesh.face_cells, right.face_cells)
    assert np.array_equal(mesh.boundary_vertices, right.boundary_vertices)
    for name in GEOMETRY:
        np.testing.assert_allclose(getattr(mesh, name), getattr(right, name), rtol=1e-9, atol=1e-12)


@both_dimensions
def test_positively_oriented_cells_keep_their_order(d):
    """In an odd permutation the last two vertices are exchanged."""
    points = np.vstack([np.zeros(d), np.eye(d)])
    for order in permutations(range(d + 1)):
        mesh = SimplexMesh(points, [order])
        swapped = (*order[:-2], order[-1], order[-2])
        inversions = sum(a > b for a, b in combinations(order, 2))
        assert tuple(mesh.cells[0]) == (swapped if inversions % 2 else order)


@both_dimensions
def test_the_mesh_does_not_depend_on_the_order_of_points_and_cells(d):
    """After renumbering, cells and faces are the same up to their numbers."""
    right, rng = MESHES[f"random {d}-D"], np.random.default_rng(1)
    number, order = rng.permutation(len(right.points)), rng.permutation(len(right.cells))
    points = np.empty_like(right.points)
    points[number] = right.points
    mesh = SimplexMesh(points, number[right.cells[order]])
    assert np.array_equal(mesh.cell_measures, right.cell_measures[order])
    assert np.array_equal(mesh.circumcenters, right.circumcenters[order])
    renumbered = np.sort(number[right.faces], axis=1)
    which = np.lexsort(renumbered.T[::-1])
    assert np.array_equal(mesh.faces, renumbered[which])
    np.testing.assert_allclose(mesh.face_measures, right.face_measures[which], rtol=1e-12)
    outward = np.isin(np.arange(len(which)), mesh.boundary_faces)
    np.testing.assert_allclose(
        mesh.face_normals[outward], right.face_normals[which][outward], atol=1e-12
    )


@both_dimensions
@pytest.mark.parametrize("unit", [2.0**-330, 2.0**330])
def test_the_mesh_does_not_depend_on_the_unit(d, unit):
    """The arrays agree bit for bit for units of 10⁻¹⁰⁰ and 10¹⁰⁰."""
    right = MESHES[f"random {d}-D"]
    mesh = SimplexMesh.delaunay(right.points * unit)
    assert np.array_equal(mesh.cells, right.cells)
    assert np.array_equal(mesh.face_normals, right.face_normals)
    assert np.array_equal(mesh.circumcenters, right.circumcenters * unit)
    assert np.array_equal(mesh.face_measures, right.face_measures * unit ** (d - 1))
    assert np.array_equal(mesh.cell_measures, right.cell_measures * unit**d)


@both_dimensions
def test_the_mesh_does_not_depend_on_the_origin(d):
    """An offset of 10⁶ loses only the digits that the coordinates lose."""
    points = np.round(random_points(d) * 2**20) / 2**20  # also exact after the translation
    right, mesh = SimplexMesh.delaunay(points), SimplexMesh.delaunay(points + 1e6)
    assert np.array_equal(mesh.cells, right.cells)
    for name in ("cell_measures", "face_measures", "face_normals"):
        assert np.array_equal(getattr(mesh, name), getattr(right, name))
    near = np.linalg.norm(right.circumcenters - 0.5, axis=1) < 10
    np.testing.assert_allclose(
        (mesh.circumcenters - 1e6)[near], right.circumcenters[near], atol=1e-9
    )


@both_dimensions
def test_the_mesh_does_not_depend_on_the_axes(d):
    """Circumcentres and normals rotate with the points; measures do not change."""
    q = ortho_group.rvs(d, random_state=5)
    right = MESHES[f"random {d}-D"]
    mesh = SimplexMesh(right.points @ q.T, right.cells)
    np.testing.assert_allclose(mesh.cell_measures, right.cell_measures, rtol=1e-9)
    np.testing.assert_allclose(mesh.face_normals, right.face_normals @ q.T, atol=1e-12)
    np.testing.assert_allclose(mesh.face_circumcenters, right.face_circumcenters @ q.T, rtol=1e-8)


@pytest.mark.parametrize("n", [5, 50, 2_000_000, 2_600_000, 2**30, 2**40])
def test_faces_are_in_lexicographic_order_for_any_number_of_points(n):
    """If the indices cannot be packed into one integer, they are sorted column by column."""
    few = np.unique(np.linspace(0, n - 1, 50).astype(np.int64))
    rows = np.random.default_rng(0).choice(few, (300, 3))
    order = _topology._lexicographic_order(rows, n)
    assert rows[order].tolist() == sorted(rows.tolist())


def test_arrays_are_read_only_also_in_pickled_copies():
    """The mesh copies its input; a pickled copy has no cached arrays."""
    points = random_points(2)
    mesh = SimplexMesh.delaunay(points)
    given, kept = points.copy(), mesh.cells.copy()
    points[:] = 0
    assert np.array_equal(mesh.points, given)
    copy = pickle.loads(pickle.dumps(mesh))
    assert np.array_equal(copy.cells, kept)
    for m in (mesh, copy):
        for name in ("points", "cells", "faces", "cell_faces", "circumcenters", "face_normals"):
            with pytest.raises(ValueError, match="read-only"):
                getattr(m, name)[0] = 0
        with pytest.raises(ValueError, match="read-only"):
            m.cells_around().data[0] = 5
        with pytest.raises(AttributeError):
            m.points = given


def test_an_unreferenced_point_has_no_effect():
    """It has no cells and no rings, is not on the boundary, and changes no other array."""
    with_it = SimplexMesh([*SQUARE, [9, 9]], [[0, 1, 2], [0, 2, 3]])
    without = SimplexMesh(SQUARE, [[0, 1, 2], [0, 2, 3]])
    assert with_it.referenced.tolist() == [True] * 4 + [False]
    assert not with_it.boundary_vertices[4]
    assert with_it.vertex_cells(4).tolist() == []
    assert with_it.faces_around(2, [4]).nnz == 0
    assert np.array_equal(with_it.faces, without.faces)
    assert np.array_equal(with_it.circumcenters, without.circumcenters)


# --- Delaunay -------------------------------------------------------------------------------------


@every_mesh
def test_circumspheres_contain_no_point(mesh):
    """The tolerance covers ties and rounded coordinates."""
    distance = np.linalg.norm(mesh.points - mesh.circumcenters[:, None], axis=2)
    radius = np.linalg.norm(mesh.points[mesh.cells[:, 0]] - mesh.circumcenters, axis=1)
    assert (distance.min(axis=1) >= radius * (1 - 1e-4)).all()


def dual_lengths(mesh: SimplexMesh) -> np.ndarray:
    """Signed lengths of interior circumcentric dual edges along the normals."""
    segments, faces = circumcentric_dual(mesh)
    along = np.einsum("fi,fi->f", segments[:, 1] - segments[:, 0], mesh.face_normals[faces])
    return along[mesh.face_cells[faces, 1] >= 0]


@every_mesh
def test_dual_lengths_of_delaunay_meshes_are_nonnegative(mesh):
    """The tolerance covers ties and rounded coordinates."""
    assert (dual_lengths(mesh) >= -1e-4).all()


def test_the_dual_length_across_the_long_diagonal_is_negative():
    """In a flat rhombus the circumcircle of a triangle contains the fourth corner."""
    rhombus = [[0, 0], [2, -1], [4, 0], [2, 1]]
    assert dual_lengths(SimplexMesh(rhombus, [[0, 1, 2], [0, 2, 3]])).tolist() == [-3]
    assert dual_lengths(SimplexMesh.delaunay(rhombus)).tolist() == [1.5]


@pytest.mark.parametrize(("n", "cells"), [(6, 50), (12, 242)])
def test_a_grid_of_squares_has_two_triangles_per_square(n, cells):
    """No flat triangles remain along the sides, also far from the origin and after rotation."""
    assert len(SimplexMesh.delaunay(grid(2, n)).cells) == cells
    assert len(SimplexMesh.delaunay(rotated(grid(2, n))).cells) == cells
    assert len(SimplexMesh.delaunay(rotated(grid(2, n)) + 1e6).cells) == cells


def test_a_grid_of_cubes_has_five_or_six_tetrahedra_per_cube():
    """There are no flat tetrahedra between two cubes and no cracks instead of them."""
    for points in (grid(3, 8), rotated(grid(3, 8)), rotated(grid(3, 8)) + 1e6):
        mesh = SimplexMesh.delaunay(points)
        assert 5 * 7**3 <= len(mesh.cells) <= 6 * 7**3
        cells_fill_the_hull(mesh)


LATTICE = st.integers(2, 3).flatmap(
    lambda d: st.lists(
        st.tuples(*[st.integers(-3, 3)] * d), min_size=d + 1, max_size=25, unique=True
    )
)


@pytest.mark.slow
@given(LATTICE, st.sampled_from([1.0, 1e-90, 1e90]), st.sampled_from([0.0, 1e5]))
def test_lattice_points_give_a_mesh_or_are_degenerate(points, unit, offset):
    """With ties, lines and planes everywhere the topological laws hold and every point is used."""
    x = (np.array(points, dtype=float) + offset) * unit
    if np.linalg.matrix_rank(np.array(points[1:]) - points[0]) < x.shape[1]:
        with pytest.raises(np.linalg.LinAlgError, match=r"lie on one (line|plane) within rounding"):
            SimplexMesh.delaunay(x)
        return
    mesh = SimplexMesh.delaunay(x)
    assert mesh.referenced.all()
    euler_s_formula_holds(mesh)
    cells_and_faces_refer_to_each_other(mesh)
    hull = ConvexHull(np.array(points, dtype=float))
    d = x.shape[1]
    assert math.isclose(mesh.cell_measures.sum() / unit**d, hull.volume, rel_tol=1e-9)
    boundary = mesh.face_measures[mesh.boundary_faces].sum() / unit ** (d - 1)
    assert math.isclose(boundary, hull.area, rel_tol=1e-9)


@pytest.mark.slow
@given(LATTICE, st.lists(st.lists(st.integers(-1, 12), min_size=4, max_size=4), max_size=6))
def test_arbitrary_cells_give_a_mesh_or_a_value_error(points, cells):
    x = np.array(points, dtype=float)
    try:
        mesh = SimplexMesh(x, np.array(cells, dtype=int).reshape(-1, 4)[:, : x.shape[1] + 1])
    except ValueError as error:
        message = str(error)
    else:
        message = ""
    if message:
        assert message.startswith(("cells must", "at most two cells"))
        return
    cells_and_faces_refer_to_each_other(mesh)
    faces_are_the_sides_of_cells(mesh)
    cells_are_closed(mesh)
    normals_point_from_the_first_cell_to_the_second(mesh)


# --- barycentric dual -----------------------------------------------------------------------------


@every_mesh
def test_barycentric_dual_segments_of_a_cell_sum_to_zero(mesh):
    """The d + 1 segments lead from the centroid of a cell to those of its faces."""
    segments, faces = barycentric_dual(mesh)
    arms = (segments[:, 1] - segments[:, 0]).reshape(len(mesh.cells), -1, mesh.points.shape[1])
    assert np.array_equal(faces.reshape(len(mesh.cells), -1), mesh.cell_faces)
    rounding = 8 * np.spacing(np.abs(mesh.points).max())
    np.testing.assert_allclose(arms.sum(axis=1), 0, atol=rounding)
    towards = np.einsum("cki,cki->ck", arms, outward_vectors(mesh))
    d = mesh.points.shape[1]
    expected = np.broadcast_to(mesh.cell_measures[:, None] * d / (d + 1), towards.shape)
    np.testing.assert_allclose(towards, expected, rtol=1e-12, atol=rounding)


# --- errors ---------------------------------------------------------------------------------------

TETRAHEDRA = np.vstack([np.zeros(3), np.eye(3), [1, 1, 1]])


@pytest.mark.parametrize(
    ("points", "cells", "words"),
    [
        (SQUARE, [[0, 1, 1]], r"distinct vertices; cells\[0\] is \[0, 1, 1\]"),
        (SQUARE, [[0, 1, 4]], r"cells must index 4 points; cells\[0, 2\] is 4"),
        (SQUARE, [[0, 1, 2], [0, -1, 2], [4, 0, 1]], r"cells\[1, 1\] is -1"),
        (SQUARE, [[0.0, 1.0, 2.0]], "cells must be integers; got the type float64"),
        (SQUARE, [[0, 1, 2, 3]], r"cells must be triangles, shape \(c, 3\); got \(1, 4\)"),
        (SQUARE, np.zeros((0, 3), dtype=int), r"cells must be triangles.* got \(0, 3\)"),
        (SQUARE, [[0, 1, 2], [0, 1]], "cells must be triangles; the rows differ in length"),
        (TETRAHEDRA, [[0, 1, 2]], r"cells must be tetrahedra, shape \(c, 4\); got \(1, 3\)"),
        ([[0, 0], [1, 0], [np.nan, 1]], [[0, 1, 2]], r"points must be finite; points\[2, 0\]"),
        ([[0.0], [1.0]], [[0, 1]], r"shape \(n, 2\) or \(n, 3\); got \(2, 1\)"),
        (
            [[0, 0], [0.1, 0.1], [0.3, 0.3], [1, 0]],
            [[0, 1, 3], [0, 1, 2]],
            r"cell 1 is: its vertices \[0, 1, 2\] lie on one line within rounding$",
        ),
        (
            [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]],
            [[0, 1, 2, 3], [1, 0, 2, 3]],
            "lie on one plane within rounding; so are 1 others",
        ),
        (
            [[0, 0], [1, 0], [0, 1], [1, 1], [0, -1]],
            [[0, 1, 2], [0, 1, 4], [1, 0, 3]],
            r"at most two cells .* face \[0, 1\] belongs to the cells 0, 1, 2",
        ),
        (
            [[0, 0], [1, 0], [0, 1], [1, -1], [-1, 0], [-1, 1]],
            [[0, 1, 3], [0, 1, 2], [0, 2, 4], [0, 2, 5]],
            r"at most two cells .* face \[0, 2\] belongs to the cells 1, 2, 3",
        ),
        (
            SQUARE,
            [[0, 1, 2], [0, 1, 3]],
            r"must not overlap; the cells 0 and 1 lie on the same side of .* face \[0, 1\]",
        ),
        (
            TETRAHEDRA,
            [[0, 1, 2, 3], [0, 1, 2, 4]],
            r"cells 0 and 1 lie on the same side of their common face \[0, 1, 2\]",
        ),
    ],
)
def test_invalid_meshes_are_refused(points, cells, words):
    """The message names the cell or the face."""
    with pytest.raises(ValueError, match=words):
        SimplexMesh(points, cells)


@both_dimensions
@pytest.mark.parametrize("unit", [1.0, 1e-90, 1e90])
def test_a_needle_is_a_cell(d, unit):
    """A needle with a base of 10⁻¹² is accepted in any unit, and its measure is accurate."""
    base = 1e-12
    points = np.vstack([np.zeros(d), np.eye(d)])
    points[1:d] *= base
    mesh = SimplexMesh(points[::-1] * unit, [range(d + 1)])
    assert math.isclose(
        mesh.cell_measures[0] / unit**d, base ** (d - 1) / math.factorial(d), rel_tol=1e-14
    )


def test_a_tetrahedron_of_two_short_distant_edges_is_not_flat():
    """The three edges at any one corner are almost dependent.

    The volume must be computed from both ends.
    """
    h = 1e-10
    mesh = SimplexMesh([[0, 0, 0], [h, 0, 0], [0, 0, 1], [0, h, 1]], [[0, 1, 2, 3]])
    assert math.isclose(mesh.cell_measures[0], h * h / 6, rel_tol=1e-14)


def test_the_unit_of_a_simplex_is_the_power_of_two_below_its_size():
    """The largest component of its edges is one or two such units; that of a point is one."""
    edges = np.random.default_rng(0).standard_normal((50, 3, 3))
    edges *= 10.0 ** np.arange(-25, 25)[:, None, None]
    ratio = np.abs(edges).max(axis=(1, 2)) / units(edges)
    assert ((ratio >= 1) & (ratio < 2)).all()
    assert units(np.zeros((1, 3, 3))).tolist() == [1.0]
    assert units(-np.ones((1, 1, 2))).tolist() == [1.0]


@pytest.mark.parametrize("d", [2, 3])
def test_moderate_needles_are_measured_along_their_short_edges(d):
    """The first corner is far from the others, a hundredth of that apart; to the last digits."""
    rng = np.random.default_rng(0)
    base = 1.9 + 0.01 * rng.random((200, d, d))
    corners = np.concatenate([np.zeros((200, 1, d)), base], axis=1)
    volumes, unit, flat = signed_volumes(corners)
    for simplex, found in zip(corners, volumes * unit**d, strict=True):
        first, *others = rational(simplex)
        exact = determinant([minus(other, first) for other in others]) / math.factorial(d)
        assert abs(Fraction(float(found)) / exact - 1) < 1e-13
    assert not flat.any()


def hard_clouds(d):
    """Distinct points whose distances differ by up to sixteen orders."""
    rng = np.random.default_rng(d)
    x, lattice = rng.random((28 // d, d)), np.indices((3,) * d).reshape(d, -1).T * 1.0
    for width in (1e-6, 1e-9, 1e-12):
        yield np.concatenate([x, 0.5 + width * rng.random((8, d))])
        yield np.concatenate([lattice, 0.5 + width * rng.random((5, d))])
        yield np.concatenate([x * width, rng.random((3, d))])
    yield np.indices((3, 4, 3)[:d]).reshape(d, -1).T / 7 * np.array([1e-6, 1.0, 1.0])[:d]
    yield np.concatenate([x, x[:1] + 1e-9 * np.eye(d)[0]])
    yield np.concatenate([x, x[:3] + 1e-14])
    yield np.concatenate([SQUARE, [[0.5, 0.5], [0.5, 0.5 + 1e-16]]]) if d == 2 else x


def test_a_vertex_inside_the_circle_of_a_cell_is_a_violation():
    """A rhomb has one Delaunay diagonal, wherever it lies; the other one is a violation."""
    for shift in ([0.0, 0.0], [3.0, -7.0]):
        points = np.array([[0, 0], [2, 0.7], [4, 0], [2, -0.7]]) + shift
        across, along = np.array([[0, 3, 1], [2, 1, 3]]), np.array([[0, 2, 1], [0, 3, 2]])
        opposite = np.array([[1, -1, -1], [0, -1, -1]])
        sure = np.array([True, True])
        assert (_violations(points, across, opposite, sure) < 0).all()
        neighbors = np.array([[-1, -1, 1], [-1, 0, -1]])
        assert (_violations(points, along, neighbors, sure) > 0.01).all()


@pytest.mark.parametrize("d", [2, 3])
def test_a_violation_is_the_lifted_determinant_by_the_product_of_its_column_sums(d):
    """Written out for cells that are no longer Delaunay ones; its sign tells who is inside."""
    points = random_points(d, 25)
    found = Delaunay(points)
    cells, neighbors = found.simplices, found.neighbors
    points = points * [1.0, 3.0, 1.5][:d]
    sure = np.arange(len(cells)) % 5 > 0
    literal = []
    for k, c in np.ndindex(d + 1, len(cells)):
        other = neighbors[c, k]
        if other > c and sure[c] and sure[other]:
            (opposite,) = points[np.setdiff1d(cells[other], cells[c])]
            e = points[cells[c]] - opposite
            e /= np.abs(e).max()
            lifted = np.column_stack([e, (e**2).sum(axis=1)])
            center = np.linalg.solve(2 * (e[1:] - e[0]), lifted[1:, d] - lifted[0, d])
            side = np.sign(np.linalg.norm(e[0] - center) - np.linalg.norm(center))
            size = np.abs(lifted).sum(axis=0).prod()
            literal.append(side * abs(np.linalg.det(lifted)) / size)
    violations = _violations(points, cells, neighbors, sure)
    np.testing.assert_allclose(violations, literal, rtol=1e-6, atol=1e-14)
    assert min(literal) < 0 < max(literal)
    assert np.array_equal(_violations(2.0**-400 * points, cells, neighbors, sure), violations)


def test_flat_cells_are_left_out_only_at_the_hull():
    """Flat cells 0 and 1 inside a mesh are not connected with the outside; cell 3 is, by cell 4."""
    neighbors = np.array([[1, 2, 2], [0, 2, 2], [0, 1, -1], [4, 2, 2], [3, 2, -1]])
    flat = np.array([True, True, False, True, True])
    assert _outer(neighbors, flat).tolist() == [False, False, False, True, True]


def test_cells_at_the_hull_that_are_left_out_make_no_crack():
    """Broken ties of a turned grid suffice for a mesh; exact signs take longer."""
    points = rotated(grid(3))
    cells = delaunay._cells_without_flat_ones(points, delaunay._in_local_frame(points))
    assert np.unique(cells).tolist() == [*range(len(points))]
    assert signed_volumes(points[cells])[0].size < len(delaunay._tie_broken(points)[0])
    cells_fill_the_hull(SimplexMesh(points, cells))


def test_a_crack_where_a_cell_is_left_out_is_refused(monkeypatch):
    """Here it is one inside the mesh, which is not flat."""
    points = rotated(grid(3))
    inner = (delaunay._tie_broken(delaunay._in_local_frame(points))[1] >= 0).all(axis=1)
    left_out = np.arange(len(inner)) == np.argmax(inner)
    monkeypatch.setattr(delaunay, "_left_out", lambda *_: left_out)
    with pytest.raises(np.linalg.LinAlgError, match="flat cells between others"):
        delaunay._cells_without_flat_ones(points, delaunay._in_local_frame(points))


@pytest.mark.parametrize("k", [0, 1, 2])
def test_no_larger_cells_are_left_out_than_one_before_a_cell_of_unknown_sign(k):
    """Cells 0, 1, 2 at the hull are 1e-17, 1e-15, 1e-13 of the area; cell 3 is behind cell k."""
    size = 3e-8 * 10.0 ** np.arange(3)
    tiny = [[[i, 0], [i + h, 0], [i, h]] for i, h in enumerate(size)]
    points = np.array([*np.concatenate(tiny), [3, 0], [0, 9]])
    large = [[i, 9, 10] for i in range(9) if i % 3 == 2]
    line, beside = [3 * k, 3 * k + 1, 9], [[0, 1, 10], [3, 4, 10], [6, 7, 10]]
    cells = np.array([[0, 1, 2], [3, 4, 5], [6, 7, 8], line, *large, *beside])
    neighbors = np.full(cells.shape, -1)
    neighbors[3] = [5, 6, k]
    left_out = delaunay._left_out(points, cells, neighbors)
    assert np.flatnonzero(left_out).tolist() == [*range(k + 1), 3]


@pytest.mark.parametrize("d", [2, 3])
def test_cells_with_a_hole_inside_are_refused(d):
    """The boundary of all cells is the hull; an inner cell that is left out adds its own."""
    points = random_points(d)
    mesh = Delaunay(points)
    open_sides = (mesh.neighbors < 0).T
    _refuse_cracks(points, mesh.simplices, open_sides)
    inner = np.flatnonzero(~open_sides.any(axis=0))
    for cell in inner:
        hole = open_sides.copy()
        hole[:, cell] = True
        with pytest.raises(np.linalg.LinAlgError, match="flat cells between others"):
            _refuse_cracks(points, mesh.simplices, hole)


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_edges_along_a_coordinate_plane_are_independent(axis):
    """Only one of the three components of their cross product differs from zero."""
    one, other = np.roll([1, 0, 0], axis).tolist(), np.roll([2, 3, 0], axis).tolist()
    assert _is_independent([tuple(one)], tuple(other))
    assert not _is_independent([tuple(one)], tuple(5 * x for x in one))


@pytest.mark.parametrize("d", [2, 3])
def test_the_first_cell_is_of_the_first_points_that_are_independent(d):
    """Each raises the rank of the edges; many points lie on one line or plane."""
    rng = np.random.default_rng(0)
    for rank in [*range(1, d + 1)] * 40:
        cloud = rng.integers(-1, 2, (9, rank)) @ rng.integers(-1, 2, (rank, d))
        cloud[rng.integers(9)] += rng.integers(-1, 2, d)
        order = rng.permutation(9).tolist()
        first = order[:1]
        for p in order:
            if np.linalg.matrix_rank(cloud[[*first, p]] - cloud[first[0]]) == len(first):
                first.append(p)
        assert _independent([tuple(p) for p in cloud.tolist()], order) == first


def every_point_is_a_vertex_of_an_exact_delaunay_mesh(cloud):
    """In rational numbers no point is inside a sphere by more than 1e-3; volumes add up."""
    cloud = np.unique(cloud, axis=0)
    mesh = SimplexMesh.delaunay(cloud)
    assert mesh.referenced.all()
    assert mesh.cell_measures.sum() == pytest.approx(ConvexHull(cloud).volume, rel=1e-9)
    exact = rational(cloud)
    for cell in mesh.cells:
        side = determinant([minus(exact[v], exact[cell[0]]) for v in cell[1:]])
        assert side > 0
        for p in exact:
            arms = [minus(exact[v], p) for v in cell]
            rows = [[*arm, dot(arm, arm)] for arm in arms]
            size = math.prod(sum(map(abs, column)) for column in zip(*rows, strict=True))
            assert determinant(rows) * (-1) ** cloud.shape[1] <= size / 10**3


@pytest.mark.slow
@pytest.mark.parametrize("d", [2, 3])
def test_delaunay_takes_any_distinct_points(d):
    """Where rounding of the lifted points would hide some."""
    for cloud in hard_clouds(d):
        every_point_is_a_vertex_of_an_exact_delaunay_mesh(cloud)


@pytest.mark.parametrize(("d", "seed"), [(2, 28), (3, 0)])
def test_a_cluster_whose_spheres_qhull_violates_has_an_exact_mesh(d, seed):
    """All points are in Qhull's cells, but their heights are too coarse within the cluster."""
    rng = np.random.default_rng(seed)
    width, n, m = 10.0 ** rng.uniform(-9, -6), rng.integers(3, 9), rng.integers(0, 6)
    far = [rng.random((m, d)), np.eye(d + 1, d)]
    every_point_is_a_vertex_of_an_exact_delaunay_mesh(
        np.concatenate([*far, rng.random(d) + width * rng.random((n, d))])
    )


def test_delaunay_keeps_close_points(monkeypatch):
    """A cluster, and two points that differ in one bit; Qhull alone loses them."""
    cloud = np.concatenate([random_points(2)[:12], 0.5 + 1e-8 * random_points(2)[:6]])
    every_point_is_a_vertex_of_an_exact_delaunay_mesh(cloud)
    every_point_is_a_vertex_of_an_exact_delaunay_mesh(
        np.array([*SQUARE, [0.5, 0.5], [0.5, 0.5 + 1e-16]])
    )
    monkeypatch.setattr(
        delaunay, "_cells_by_exact_signs", lambda p: Delaunay(p - p.mean(axis=0)).simplices
    )
    with pytest.raises((AssertionError, np.linalg.LinAlgError)):
        every_point_is_a_vertex_of_an_exact_delaunay_mesh(cloud)


@pytest.mark.parametrize("d", [2, 3])
def test_the_neighbour_of_an_exact_cell_shares_all_corners_but_one(d):
    """The k-th without the k-th corner; at the hull there is none. Cells are those of Qhull."""
    cloud = random_points(d)[:30]
    cells, neighbors = exact_delaunay_cells(cloud)
    assert {*map(frozenset, cells.tolist())} == {
        *map(frozenset, Delaunay(cloud).simplices.tolist())
    }
    at_side = {}
    for c, cell in enumerate(cells.tolist()):
        for k in range(d + 1):
            at_side.setdefault(frozenset(cell[:k] + cell[k + 1 :]), []).append((c, k))
    for sides in at_side.values():
        (c, k), (other, j) = sides if len(sides) == 2 else (*sides, (-1, None))
        assert neighbors[c, k] == other
        assert other < 0 or neighbors[other, j] == c
    assert {side for side, cs in at_side.items() if len(cs) == 1} == {
        *map(frozenset, ConvexHull(cloud).simplices.tolist())
    }


def exact_volume(points: np.ndarray, cells: np.ndarray) -> Fraction:
    exact = rational(points)
    arms = ([minus(exact[v], exact[cell[0]]) for v in cell[1:]] for cell in cells)
    return sum(abs(determinant(rows)) for rows in arms) / math.factorial(points.shape[1])


@pytest.mark.parametrize("width", [1e-7, 1e-11])
def test_cells_fill_a_needle(width):
    """Three clusters on one line: cells between them are thin, but rounding does not invert them.

    A step of the shortest edge changes the volume by the area of the long ones, which is small.
    """
    rng = np.random.default_rng(0)
    cloud = rng.random((30, 3)) * width + rng.integers(0, 3, (30, 1))
    mesh = SimplexMesh.delaunay(cloud)
    whole = exact_volume(cloud, exact_delaunay_cells(cloud)[0])
    assert float(exact_volume(cloud, mesh.cells) / whole) == pytest.approx(1, rel=1e-9)


@pytest.mark.parametrize("seed", [2, 8, 25, 46])
def test_four_points_in_space_are_one_cell(seed):
    """On a needle so thin that Qhull's rounding joins them with its point at infinity."""
    rng = np.random.default_rng(seed)
    corners = rng.random((4, 3)) * 1e-13 + rng.integers(0, 3, (4, 1))
    assert np.sort(delaunay.delaunay_cells(corners)).tolist() == [[0, 1, 2, 3]]


@pytest.mark.parametrize("more", [1, 7])
@pytest.mark.parametrize("d", [2, 3])
def test_the_cells_of_a_thin_cloud_are_certain_and_have_all_points_and_the_volume(d, more):
    """Where a cell of unknown sign cannot be left out there are none; Qhull returns this cell.

    It also loses cells at the hull, up to a thirtieth of the volume, without a flat one.
    """
    meshes, n = 0, d + more
    for seed in range(30):
        rng = np.random.default_rng(seed)
        cloud = rng.random((n, d)) * [*[1.0] * (d - 1), 10.0 ** rng.uniform(-16, -12)]
        try:
            cells = delaunay.delaunay_cells(cloud)
        except np.linalg.LinAlgError:
            continue
        meshes += 1
        assert np.unique(cells).tolist() == [*range(n)]
        assert not signed_volumes(cloud[cells])[2].any()
        whole = exact_volume(cloud, exact_delaunay_cells(cloud)[0])
        assert float(exact_volume(cloud, cells) / whole) == pytest.approx(1, rel=1e-9)
    assert 5 < meshes < 25


@pytest.mark.parametrize("seed", [9, 11, 25])
def test_broken_ties_give_a_mesh_where_exact_ones_do_not(seed):
    """The corners of a cube, each with a neighbour within 1e-13: twice eight points on a sphere."""
    corners = np.indices((2, 2, 2)).reshape(3, -1).T * 1.0
    close = corners + 1e-14 * np.random.default_rng(seed).standard_normal((8, 3))
    cloud = np.unique(np.concatenate([corners, close]), axis=0)
    cells = delaunay.delaunay_cells(cloud, by_exact_signs=True)
    assert np.unique(cells).tolist() == [*range(len(cloud))]
    assert not signed_volumes(cloud[cells])[2].any()
    assert float(exact_volume(cloud, cells)) == pytest.approx(1, rel=1e-9)
    for unit in (2.0**-90, 2.0**90):
        found = delaunay.delaunay_cells(unit * cloud, by_exact_signs=True)
        assert np.array_equal(found, cells), "ties are broken by parts of a squared distance"


@pytest.mark.parametrize("long", [1.0, 1e-8])
def test_a_cell_is_flat_if_a_step_of_its_corners_inverts_it(long):
    """A corner at the height h over the others, which a step of h / 2 of each corner can invert."""
    h = 1e-6 * long
    cell = np.array([[0, 0, 0], [long, 0, 0], [long, 2 * h, 0], [2 * long, h, h]])
    for rounding, flat in ((0.0, False), (h / 1e3, False), (h / 2, True), (h, True)):
        assert signed_volumes(cell[None], rounding)[2][0] == flat
        assert signed_volumes(cell[None, :3, :2], rounding)[2][0] == flat


@pytest.mark.parametrize(("step", "flat"), [(0.40, False), (0.45, True)])
def test_in_space_a_step_of_two_corners_of_a_needle_counts(step, flat):
    """One edge has the length 1, two have w; their changes by s add up to 2 s w + s^2, up to w."""
    w = 1e-4
    needle = np.array([[[0, 0, 0], [1, 0, 0], [1, w, 0], [1, 0, w]]])
    assert signed_volumes(needle, step * w / 8)[2].tolist() == [flat]


def clouds_that_qhull_folds():
    """Points on a thin ring, a perturbed lattice, and pairs of points."""
    rng = np.random.default_rng(54)
    width, angle = 10.0 ** -rng.integers(3, 15), rng.random(30) * 2 * np.pi
    ring = np.column_stack([np.cos(angle), np.sin(angle), rng.random(30) * width])
    yield np.concatenate([ring, rng.random((3, 3))])
    rng = np.random.default_rng(40)
    width = 10.0 ** -rng.integers(3, 15)
    yield np.round(rng.random((30, 3)) * 4) / 4 + width * rng.integers(-1, 2, (30, 3))
    rng = np.random.default_rng(18)
    width, x = 10.0 ** -rng.integers(3, 15), rng.random((25, 3))
    yield np.concatenate([x, x[:8] * (1 + width)])


@pytest.mark.parametrize("cloud", [*clouds_that_qhull_folds()], ids=["ring", "lattice", "pairs"])
def test_exact_signs_decide_where_cells_overlap(cloud):
    """Two cells of Qhull lay on one side of their face, so these points were refused."""
    cloud = np.unique(cloud, axis=0)
    mesh = SimplexMesh.delaunay(cloud)
    assert mesh.referenced.all()
    whole = exact_volume(cloud, exact_delaunay_cells(cloud)[0])
    assert float(exact_volume(cloud, mesh.cells) / whole) == pytest.approx(1, rel=1e-12)


def test_a_cell_of_unknown_sign_behind_a_thin_one_is_left_out():
    """Five corners of a lattice have a neighbour within 1e-8."""
    rng = np.random.default_rng(9)
    lattice = np.indices((4, 4, 4)).reshape(3, -1).T[:, [1, 0, 2]] * 1.0
    close = lattice[:5] + 10.0 ** -rng.integers(3, 15) * rng.standard_normal((5, 3))
    mesh = SimplexMesh.delaunay(np.unique(np.concatenate([lattice, close]), axis=0))
    assert mesh.referenced.all()
    assert mesh.cell_measures.sum() == pytest.approx(27, rel=1e-7)


@pytest.mark.parametrize(
    ("points", "error", "words"),
    [
        (
            [[0, 0], [1, 0]],
            ValueError,
            "points must be at least 3 for a mesh in 2 dimensions; got 2",
        ),
        ([*SQUARE, [1, 0], [0, 0]], ValueError, "these coincide: 1 and 4, 0 and 5$"),
        ([*SQUARE, [1, 1 + 1e-16 / 2]], ValueError, "these coincide: 2 and 4$"),
        ([[0, 0], [1, 1], [2, 2]], np.linalg.LinAlgError, "lie on one line within rounding"),
        (np.eye(5, 3) * [1, 1, 0], ValueError, "these coincide: 2 and 3, 2 and 4"),
        (np.c_[random_points(2), np.ones(60)], np.linalg.LinAlgError, "lie on one plane"),
        ([[-1e308, 0], [1.7e308, 0], [0, 1.7e308]], OverflowError, "extent of the points exceeds"),
        ([[0.0], [1.0], [2.0]], ValueError, r"shape \(n, 2\) or \(n, 3\); got \(3, 1\)"),
    ],
)
def test_points_without_a_mesh_are_refused(points, error, words):
    """The message names the points."""
    with pytest.raises(error, match=words):
        SimplexMesh.delaunay(points)


@pytest.mark.parametrize("above", [[], [[0.5, 1e3]]], ids=["at the hull", "inside"])
def test_points_of_a_cell_of_unknown_sign_that_cannot_be_left_out_are_named(above):
    """A point rises over an edge by a few roundings, and is in no other cell, or has cells above.

    The circle through the three points is so large that the cell below ends far away.
    """
    edge = [[0, 0], [1, 0], [0.5, 1.7e-15]]
    points = np.array([*edge, [0.5, -1.6e14], *above])
    for signs in product((1, -1), repeat=2):
        for turned in (points * signs, points[:, ::-1] * signs):
            with pytest.raises(np.linalg.LinAlgError, match="so nearly on one line that") as error:
                delaunay.delaunay_cells(turned)
            named = re.search(r"the points \[(.*)\] lie", str(error.value)).group(1)
            assert sorted(map(int, named.split(","))) == [0, 1, 2]


@pytest.mark.parametrize("d", [2, 3])
def test_points_on_one_line_or_plane_have_no_exact_cells(d):
    """The arrays of cells and of neighbours have no rows, and a column for each corner."""
    flat = np.pad(random_points(d - 1)[:9], ((0, 0), (0, 1)))
    cells, neighbors = exact_delaunay_cells(flat)
    assert cells.shape == neighbors.shape == (0, d + 1)


@pytest.mark.parametrize("name", ["random 2-D", "random 3-D"])
def test_cells_and_faces_of_rings_are_in_ascending_order(name):
    """Each once in its row, with the entry one."""
    mesh = MESHES[name]
    for around in (mesh.cells_around, mesh.faces_around):
        for rings in (1, 2, 3):
            matrix = around(rings)
            assert (matrix.data == 1).all()
            for start, end in pairwise(matrix.indptr):
                assert (np.diff(matrix.indices[start:end]) > 0).all()


def test_invalid_vertices_and_rings_are_refused():
    """Vertices must be indices of points, and the number of rings a positive integer."""
    mesh = MESHES["random 2-D"]
    for wrong in (-1, 60):
        with pytest.raises(ValueError, match=f"indices of points, 0 to 59; got {wrong}"):
            mesh.vertex_cells(wrong)
    with pytest.raises(ValueError, match=r"vertices must be indices of points, .* float64"):
        mesh.cells_around(1, [0.5])
    for wrong in (0, 1.5, True):
        with pytest.raises(ValueError, match=f"rings must be an integer, 1 or more; got {wrong}"):
            mesh.faces_around(wrong)
    assert mesh.cells_around(2, []).shape == (0, len(mesh.cells))


def test_overflow_of_measures_is_reported():
    """Volumes may overflow or underflow; the size of a cell may overflow."""
    for unit in (1e-150, 1e150):
        mesh = SimplexMesh(np.vstack([np.zeros(3), np.eye(3)]) * unit, [[0, 1, 2, 3]])
        np.testing.assert_allclose(mesh.circumcenters, unit / 2)
        with pytest.raises(
            OverflowError, match="volumes exceed the range of floating-point numbers"
        ):
            mesh.cell_measures  # noqa: B018
    with pytest.raises(OverflowError, match="the size of cell 0 exceeds the range"):
        SimplexMesh([[-1e308, 0], [1e308, 0], [0, 1]], [[0, 1, 2]])
