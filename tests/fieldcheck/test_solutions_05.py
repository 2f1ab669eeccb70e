"""The solutions of notebook 05 agree with the library."""

import numpy as np
import pytest

from checkout import ROOT
from fieldgrade.authoring.sources import Source
from fieldrecon import inverse_square, normal_velocities, vertex_velocities
from fieldrecon.methods.least_squares import monomial_matrix
from meshes import jittered_mesh, random_mesh, star, taylor_green

NOTEBOOK = Source(ROOT / "solutions/05_vertex_velocities.py").functions()
MESHES = {
    "random": random_mesh(60, 2, 1),
    "jittered": jittered_mesh(5, 2, 2),
    "star of four": star(4, 3),
    "star of seven": star(7, 4),
}
EPSILON = 0.1
each_mesh = pytest.mark.parametrize("mesh", MESHES.values(), ids=MESHES.keys())


def edges_with_normals(mesh):
    """Edges, midpoints and normals of the notebook, with the signs of the library's normals."""
    edges = NOTEBOOK["edges_of"](mesh.cells)
    p, n = NOTEBOOK["midpoints_and_normals"](mesh.points, edges)
    return edges, p, n * np.sign(np.sum(n * mesh.face_normals, axis=1))[:, None]


def velocity_at(mesh, v, vertex, rings):
    """The velocity at a vertex by the notebook, from the edges in so many rings."""
    edges, p, n = edges_with_normals(mesh)
    near = NOTEBOOK["ring"](mesh.cells, edges, vertex, rings)
    x = mesh.points[vertex]
    w = 1 / (np.sum((p[near] - x) ** 2, axis=1) + EPSILON**2)
    return NOTEBOOK["velocity"](p[near], n[near], v[near], x, w)


@each_mesh
def test_edges_midpoints_and_normals_agree_with_the_library(mesh):
    """The faces of the library are the edges of the notebook, in the same order."""
    edges, p, n = edges_with_normals(mesh)
    np.testing.assert_array_equal(edges, mesh.faces)
    np.testing.assert_allclose(p, mesh.points[mesh.faces].mean(axis=1), rtol=0, atol=1e-15)
    np.testing.assert_allclose(n, mesh.face_normals, rtol=0, atol=1e-12)


@each_mesh
def test_normal_velocities_agree_with_the_library(mesh):
    """They agree for a rotation and for a field that is not linear."""
    edges, _, n = edges_with_normals(mesh)
    for u in (NOTEBOOK["rotation"](mesh.points), taylor_green(mesh.points)):
        v = NOTEBOOK["normal_velocities"](edges, n, u)
        np.testing.assert_allclose(v, normal_velocities(mesh, u), rtol=0, atol=1e-12)


@each_mesh
def test_the_rotation_is_a_rigid_rotation_about_the_mean(mesh):
    """Its derivative is antisymmetric with entries ±1, so divergence and strain vanish."""
    u = NOTEBOOK["rotation"](mesh.points)
    c = np.linalg.lstsq(monomial_matrix(mesh.points, 1), u)[0]
    np.testing.assert_allclose(c[1:], [[0, 1], [-1, 0]], rtol=0, atol=1e-12)
    np.testing.assert_allclose(u.mean(axis=0), 0, rtol=0, atol=1e-14)


@pytest.mark.parametrize("name", ["random", "jittered"])
def test_the_velocity_agrees_with_the_library_for_equal_rings(name):
    """Where the notebook's ring has rank six, both fits have the same unique solution."""
    mesh = MESHES[name]
    v = normal_velocities(mesh, taylor_green(mesh.points))
    found = vertex_velocities(mesh, v, inverse_square(EPSILON))
    ranks = {k: NOTEBOOK["ranks"](mesh.points, mesh.cells, k) for k in np.unique(found.rings)}
    compared = [i for i, k in enumerate(found.rings) if ranks[k][i] == 6]
    assert len(compared) > len(mesh.points) / 2
    for i in compared:
        by_notebook = velocity_at(mesh, v, i, found.rings[i])
        np.testing.assert_allclose(by_notebook, found.values[i], rtol=0, atol=1e-9)


@each_mesh
@pytest.mark.parametrize("rings", [1, 2])
def test_the_rank_is_that_of_the_quadratic_monomials_of_the_ring(mesh, rings):
    """The monomials are evaluated at the vertices and do not involve any normals."""
    ranks = NOTEBOOK["ranks"](mesh.points, mesh.cells, rings)
    edges = NOTEBOOK["edges_of"](mesh.cells)
    for i, x in enumerate(mesh.points):
        near = np.unique(edges[NOTEBOOK["ring"](mesh.cells, edges, i, rings)])
        y = mesh.points[near] - x
        conics = monomial_matrix(y / np.abs(y).max(), 2)
        assert ranks[i] == np.linalg.matrix_rank(conics, tol=1e-7)
