"""The solutions of notebook 06 agree with the library."""

import numpy as np
import pytest

from checkout import ROOT
from fieldcheck.notebook import try_public
from fieldcheck.questions import get
from fieldcheck.seeds import EVERYBODY, seed
from fieldgrade.authoring.sources import Source
from fieldrecon import cell_velocities, normal_velocities
from fieldrecon.velocity import raviart_thomas
from meshes import jittered_mesh, random_mesh, taylor_green

NOTEBOOK = Source(ROOT / "solutions/06_cell_velocities.py").functions()
MESHES = {"random": random_mesh(60, 2, 1), "jittered": jittered_mesh(5, 2, 2)}
each_mesh = pytest.mark.parametrize("mesh", MESHES.values(), ids=MESHES.keys())


def cells(mesh, v):
    """Corners of each cell and its outward normal velocities, side a opposite corner a."""
    return zip(mesh.points[mesh.cells], mesh.cell_face_signs * v[mesh.cell_faces], strict=True)


def data_of(mesh):
    """Normal velocities of a field that is not linear, and random normal velocities."""
    return (
        normal_velocities(mesh, taylor_green(mesh.points)),
        np.random.default_rng(3).normal(size=len(mesh.faces)),
    )


def affine(matrix, m):
    """An affine field about m."""
    return lambda x: (x - m) @ np.transpose(matrix)


def computed_and_exact(mesh, field):
    """Velocities of the cells by the notebook, and the field at the circumcentres."""
    v = normal_velocities(mesh, field(mesh.points))
    found = [NOTEBOOK["cell_velocity"](q, out) for q, out in cells(mesh, v)]
    queries = np.array([NOTEBOOK["circumcenter"](q) for q in mesh.points[mesh.cells]])
    return np.array(found), field(queries)


@each_mesh
def test_outward_normals_agree_with_the_library(mesh):
    """The order of the corners does not matter."""
    normals = mesh.cell_face_signs[:, :, None] * mesh.face_normals[mesh.cell_faces]
    for q, n in zip(mesh.points[mesh.cells], normals, strict=True):
        np.testing.assert_allclose(NOTEBOOK["outward_normals"](q), n, rtol=0, atol=1e-11)
        mirrored = NOTEBOOK["outward_normals"](q[::-1])
        np.testing.assert_allclose(mirrored, n[::-1], rtol=0, atol=1e-11)


@each_mesh
def test_velocity_and_defect_agree_with_the_library(mesh):
    """The library evaluates the Raviart–Thomas field at the symmedian point instead."""
    for v in data_of(mesh):
        by_library = cell_velocities(mesh, v)
        for k, (q, out) in enumerate(cells(mesh, v)):
            u, d = NOTEBOOK["cell_velocity"](q, out), NOTEBOOK["defect"](q, out)
            np.testing.assert_allclose(u, by_library.values[k], rtol=1e-9, atol=1e-9)
            assert d == pytest.approx(by_library.defect[k], rel=1e-9, abs=1e-12)


@each_mesh
def test_circumcentres_agree_with_the_library(mesh):
    """The error is relative to the circumradius, since circumcentres of flat cells are far away."""
    for q, o in zip(mesh.points[mesh.cells], mesh.circumcenters, strict=True):
        radius = np.linalg.norm(o - q[0])
        assert np.linalg.norm(NOTEBOOK["circumcenter"](q) - o) < 1e-9 * max(radius, 1)


@each_mesh
def test_the_raviart_thomas_field_agrees_with_the_library(mesh):
    """The fields are compared at the centroid and at a corner of each cell."""
    for v in data_of(mesh):
        for where in (mesh.points[mesh.cells].mean(axis=1), mesh.points[mesh.cells[:, 1]]):
            by_library = raviart_thomas(mesh, v, where)
            for k, (q, out) in enumerate(cells(mesh, v)):
                w = NOTEBOOK["raviart_thomas"](q, out, where[k])
                np.testing.assert_allclose(w, by_library[k], rtol=1e-8, atol=1e-9)


@each_mesh
def test_a_rotation_is_exact_at_the_circumcentres_and_a_strain_is_not(mesh):
    """The first written question proves this, and warns of the strain."""
    m = mesh.points.mean(axis=0)
    found, true = computed_and_exact(mesh, affine([[0, -1], [1, 0]], m))
    np.testing.assert_allclose(found, true, rtol=0, atol=1e-8)
    found, true = computed_and_exact(mesh, affine([[1, 0], [0, -1]], m))
    assert np.linalg.norm(found - true, axis=1).mean() > 0.05


@each_mesh
@pytest.mark.parametrize("s", [0.0, 0.7])
def test_the_errors_agree_with_the_library(mesh, s):
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


def test_sampling_sides_at_their_ends_does_not_change_the_velocity():
    """The change of the data is a multiple of the side lengths, which least squares ignores."""
    q = np.array([[0.1, 0.9], [-0.8, -0.5], [0.8, -0.4]])
    n = NOTEBOOK["outward_normals"](q)
    truth = NOTEBOOK["truth"](q, np.array([0.3, 0.2]), 0.6)
    middles, begins = (q.sum(axis=0) - q) / 2, np.roll(truth, -1, axis=0)
    v = np.sum(n * NOTEBOOK["truth"](middles, np.array([0.3, 0.2]), 0.6), axis=1)
    other = np.sum(n * begins, axis=1)
    assert np.abs(v - other).min() > 0.3
    u, changed = (NOTEBOOK["cell_velocity"](q, data) for data in (v, other))
    np.testing.assert_allclose(changed, u, rtol=0, atol=1e-14)


def test_the_error_far_from_the_origin_is_reported_as_it_is():
    """Circumcentres are compared relative to a corner; the sentence states the same difference."""

    def cancelling(q):
        return np.linalg.solve(2 * (q[1:] - q[0]), np.sum(q[1:] ** 2, axis=1) - q[0] @ q[0])

    question = get("06.4")
    verdict = try_public(question, {"circumcenter": cancelling})
    (corners,) = question.inputs(seed(EVERYBODY, "06.4"))[verdict.call].arguments
    error = np.abs(cancelling(corners) - NOTEBOOK["circumcenter"](corners)).max()
    size = np.ptp(corners, axis=0).max()
    assert np.abs(corners).max() > 1e6 * size
    assert 1e-4 < error / size < 10
    stated = float(verdict.sentence.partition("is off by ")[2].partition(". ")[0])
    assert stated == pytest.approx(error, rel=0.1)
