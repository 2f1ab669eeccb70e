"""Notebook 06 and the library are two routes to one answer."""

import numpy as np
import pytest

from checkout import ROOT
from fieldgrade.authoring.sources import Source
from fieldrecon import cell_velocities, normal_velocities
from fieldrecon.velocity import raviart_thomas
from meshes import jittered_mesh, random_mesh, taylor_green

NOTEBOOK = Source(ROOT / "solutions/06_cell_velocities.py").functions()
MESHES = {"random": random_mesh(60, 2, 1), "jittered": jittered_mesh(5, 2, 2)}
each_mesh = pytest.mark.parametrize("mesh", MESHES.values(), ids=MESHES.keys())


def cells(mesh, v):
    """Corners of each cell and the velocities out of it, side a opposite corner a."""
    return zip(mesh.points[mesh.cells], mesh.cell_face_signs * v[mesh.cell_faces], strict=True)


def data_of(mesh):
    """Normal velocities of a curved field, and others that no field has."""
    return (
        normal_velocities(mesh, taylor_green(mesh.points)),
        np.random.default_rng(3).normal(size=len(mesh.faces)),
    )


def affine(matrix, m):
    """An affine field about m."""
    return lambda x: (x - m) @ np.transpose(matrix)


def found_and_true(mesh, field):
    """Velocities of the cells by the notebook, and the field at the circumcentres."""
    v = normal_velocities(mesh, field(mesh.points))
    found = [NOTEBOOK["cell_velocity"](q, out) for q, out in cells(mesh, v)]
    places = np.array([NOTEBOOK["circumcentre"](q) for q in mesh.points[mesh.cells]])
    return np.array(found), field(places)


@each_mesh
def test_normals_are_those_of_the_library_turned_outward(mesh):
    """Whichever way the corners are listed."""
    normals = mesh.cell_face_signs[:, :, None] * mesh.face_normals[mesh.cell_faces]
    for q, n in zip(mesh.points[mesh.cells], normals, strict=True):
        np.testing.assert_allclose(NOTEBOOK["outward_normals"](q), n, rtol=0, atol=1e-11)
        mirrored = NOTEBOOK["outward_normals"](q[::-1])
        np.testing.assert_allclose(mirrored, n[::-1], rtol=0, atol=1e-11)


@each_mesh
def test_velocity_and_defect_are_those_of_the_library(mesh):
    """The library forms no matrix: it takes the Raviart–Thomas field at the symmedian point."""
    for v in data_of(mesh):
        by_library = cell_velocities(mesh, v)
        for k, (q, out) in enumerate(cells(mesh, v)):
            u, d = NOTEBOOK["cell_velocity"](q, out), NOTEBOOK["defect"](q, out)
            np.testing.assert_allclose(u, by_library.values[k], rtol=1e-9, atol=1e-9)
            assert d == pytest.approx(by_library.defect[k], rel=1e-9, abs=1e-12)


@each_mesh
def test_circumcentres_are_those_of_the_library(mesh):
    """Flat cells have theirs far away, so the distance counts from the cell."""
    for q, o in zip(mesh.points[mesh.cells], mesh.circumcenters, strict=True):
        radius = np.linalg.norm(o - q[0])
        assert np.linalg.norm(NOTEBOOK["circumcentre"](q) - o) < 1e-9 * max(radius, 1)


@each_mesh
def test_the_field_of_raviart_and_thomas_is_that_of_the_library(mesh):
    """At the centroids, and at the corner of each cell."""
    for v in data_of(mesh):
        for where in (mesh.points[mesh.cells].mean(axis=1), mesh.points[mesh.cells[:, 1]]):
            by_library = raviart_thomas(mesh, v, where)
            for k, (q, out) in enumerate(cells(mesh, v)):
                w = NOTEBOOK["raviart_thomas"](q, out, where[k])
                np.testing.assert_allclose(w, by_library[k], rtol=1e-8, atol=1e-9)


@each_mesh
def test_a_rotation_is_exact_at_the_circumcentres_and_a_strain_is_not(mesh):
    """What the first question in words proves, and what it warns of."""
    m = mesh.points.mean(axis=0)
    found, true = found_and_true(mesh, affine([[0, -1], [1, 0]], m))
    np.testing.assert_allclose(found, true, rtol=0, atol=1e-8)
    found, true = found_and_true(mesh, affine([[1, 0], [0, -1]], m))
    assert np.linalg.norm(found - true, axis=1).mean() > 0.05


@each_mesh
@pytest.mark.parametrize("s", [0.0, 0.7])
def test_the_errors_are_those_of_the_velocities_of_the_library(mesh, s):
    """At circumcentres, centroids and vertices."""
    m = mesh.points.mean(axis=0)
    field = affine([[s, -1], [1, s]], m)
    np.testing.assert_allclose(NOTEBOOK["truth"](mesh.points, m, s), field(mesh.points), atol=1e-14)
    u = cell_velocities(mesh, normal_velocities(mesh, field(mesh.points))).values
    corners = mesh.points[mesh.cells]
    there = (mesh.circumcenters[:, None], corners.mean(axis=1)[:, None], corners)
    wanted = [np.sqrt(((u[:, None] - field(x)) ** 2).sum(axis=-1).mean()) for x in there]
    found = NOTEBOOK["errors"](mesh.points, mesh.cells, s)
    np.testing.assert_allclose(found, wanted, rtol=1e-8, atol=1e-8)


def test_taking_the_ends_of_the_sides_in_turn_changes_no_velocity():
    """The data are off by a multiple of the lengths, which least squares ignores."""
    q = np.array([[0.1, 0.9], [-0.8, -0.5], [0.8, -0.4]])
    n = NOTEBOOK["outward_normals"](q)
    truth = NOTEBOOK["truth"](q, np.array([0.3, 0.2]), 0.6)
    middles, begins = (q.sum(axis=0) - q) / 2, np.roll(truth, -1, axis=0)
    v = np.sum(n * NOTEBOOK["truth"](middles, np.array([0.3, 0.2]), 0.6), axis=1)
    other = np.sum(n * begins, axis=1)
    assert np.abs(v - other).min() > 0.3
    u, changed = (NOTEBOOK["cell_velocity"](q, data) for data in (v, other))
    np.testing.assert_allclose(changed, u, rtol=0, atol=1e-14)
