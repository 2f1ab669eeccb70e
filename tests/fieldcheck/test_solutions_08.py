"""The solutions of notebook 08 agree with the library."""

import numpy as np
import pytest

from checkout import ROOT
from fieldcheck.questions.q08_weights_in_3d import points_inside, star
from fieldgrade.authoring.sources import Source
from fieldrecon import SimplexMesh, VoronoiCell
from fieldreport.experiments.barycentric.hexagon_spiral import Star, icosahedron, quotients

NOTEBOOK = Source(ROOT / "solutions/08_weights_in_3d.py").functions()
ROUNDING = 1e-10


def of_mesh(mesh, vertex):
    """The arguments of the notebook's functions for a vertex of a mesh."""
    around = mesh.cells[mesh.vertex_cells(vertex)]
    others = around[around != vertex].reshape(-1, 3)
    numbers, cells = np.unique(others, return_inverse=True)
    return mesh.points[vertex], mesh.points[numbers], cells.reshape(-1, 3)


def made(n):
    """A star of the questions as a mesh whose vertex 0 is the centre."""
    center, neighbors, cells, corners = star(np.random.default_rng(n), n)
    whole = np.column_stack([np.zeros(len(cells), int), cells + 1])
    return SimplexMesh(np.vstack([center, neighbors]), whole), 0, corners


def stars():
    """Stars made from their cells, the icosahedron, and a star in a random mesh."""
    for n in (3, 4, 6):
        yield made(n)[:2]
    yield icosahedron()
    points = np.random.default_rng(1).random((60, 3))
    yield SimplexMesh.delaunay(points), int(((points - 0.5) ** 2).sum(axis=1).argmin())


@pytest.fixture(params=stars(), ids=["5 faces", "6 faces", "8 faces", "icosahedron", "random"])
def case(request):
    mesh, vertex = request.param
    return mesh, vertex, of_mesh(mesh, vertex), mesh.circumcenters[mesh.vertex_cells(vertex)]


def test_circumcentres_and_volumes_agree_with_the_library(case):
    """Six times the volume divided by the edge lengths is the volume of the normals."""
    mesh, vertex, (center, neighbors, cells), corners = case
    sizes = mesh.cell_measures[mesh.vertex_cells(vertex)]
    for cell, corner, size in zip(cells, corners, sizes, strict=True):
        tips = neighbors[cell]
        assert NOTEBOOK["volume"](center, *tips) == pytest.approx(size, rel=1e-9)
        p = NOTEBOOK["circumcenter"](center, *tips)
        np.testing.assert_allclose(p, corner, rtol=1e-8, atol=1e-8)
        lengths = np.linalg.norm(tips - center, axis=1).prod()
        normals = NOTEBOOK["volume_of_normals"](center, tips)
        assert normals == pytest.approx(6 * size / lengths, rel=1e-9)


def test_the_stars_of_the_questions_have_the_given_circumcentres():
    """The checks therefore know the circumcentres without computing them."""
    for n in (3, 4, 6):
        mesh, _, corners = made(n)
        np.testing.assert_allclose(mesh.circumcenters, corners, rtol=0, atol=ROUNDING)


def test_coordinates_agree_with_the_library(case):
    """Quotients and products are compared, also at corners; linear fields are reproduced."""
    mesh, vertex, (center, neighbors, cells), corners = case
    x = points_inside(np.random.default_rng(3), center, corners, 15)
    w = np.array([NOTEBOOK["weights"](center, neighbors, cells, corners, place) for place in x])
    assert w.min() > 0
    omega = NOTEBOOK["coordinates"](center, neighbors, cells, x)
    np.testing.assert_allclose(w / w.sum(axis=1)[:, None], omega, rtol=0, atol=1e-7)
    np.testing.assert_allclose(omega, quotients(Star(mesh, vertex), x), rtol=0, atol=1e-7)
    np.testing.assert_allclose(omega @ corners, x, rtol=0, atol=1e-8)
    cell = VoronoiCell(mesh, vertex)
    at = [list(mesh.vertex_cells(vertex)).index(c[0]) for c in cell.cells]
    border = np.vstack([x, corners[:3]])
    mine = NOTEBOOK["coordinates"](center, neighbors, cells, border)[:, at]
    np.testing.assert_allclose(mine, cell.weights(border), rtol=0, atol=1e-7)


def test_heights_are_equal_from_every_corner_of_a_face(case):
    """(x_b − x_i)ᵀ(p_a − x) = h_b(x) for every corner a of face b and every x."""
    _, _, (center, neighbors, cells), corners = case
    x = center + np.random.default_rng(4).normal(size=(5, 3))
    h = NOTEBOOK["heights"](center, neighbors, x)
    for cell, corner in zip(cells, corners, strict=True):
        left = (neighbors[cell] - center) @ (corner - x).T
        np.testing.assert_allclose(left, h[cell], rtol=0, atol=1e-8)
