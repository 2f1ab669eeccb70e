"""Dual meshes: perpendicular dual edges, negative dual lengths, and crossings."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from fieldrecon import SimplexMesh
from fieldrecon.meshes import barycentric_dual, circumcentric_dual
from fieldreport import experiments
from fieldreport.experiments.meshes import dual_meshes as duals
from fieldreport.experiments.meshes.reference_flows import jittered_cube

SQUARE = [[0.0, 0], [2, 0], [2, 2], [0, 2]]


@pytest.fixture(scope="module")
def result():
    return experiments.get("dual_meshes").run()


@pytest.fixture(scope="module", params=[2, 3])
def delaunay(request):
    return jittered_cube({2: 8, 3: 4}[request.param], request.param, 0.6, 3)


def cotangents(mesh):
    """cot α + cot β of the angles opposite each interior edge, from edge lengths only."""
    total = np.zeros(len(mesh.faces))
    corners = mesh.points[mesh.cells]
    for k in range(3):
        a, b, c = (
            np.linalg.norm(corners[:, i] - corners[:, j], axis=1)
            for i, j in ((k - 2, k - 1), (k, k - 1), (k, k - 2))
        )
        np.add.at(total, mesh.cell_faces[:, k], (b**2 + c**2 - a**2) / (4 * mesh.cell_measures))
    return total


# --- the library's duals ------------------------------------------------------------------------


def test_circumcentric_dual_edges_are_perpendicular_to_their_faces(delaunay):
    """This holds in every mesh, Delaunay or not. Barycentric dual edges are not perpendicular."""
    for mesh in (delaunay, duals.stretched(delaunay, 2.0)):
        assert duals.off_perpendicular(mesh, "circumcentric").max() < 1e-8
        assert duals.off_perpendicular(mesh, "barycentric").max() > 20


def test_circumcentric_dual_edges_are_equidistant_from_the_corners_of_their_face(delaunay):
    """Therefore a dual edge is the common boundary of the Voronoi cells of these corners."""
    segments, faces = circumcentric_dual(delaunay)
    corners = delaunay.points[delaunay.faces[faces]]
    distance = np.linalg.norm(segments[:, :, None] - corners[:, None], axis=3)
    assert np.ptp(distance, axis=2).max() < 1e-12


def test_dual_lengths_equal_the_cotangent_formula():
    """l* = l (cot α + cot β) / 2, including the sign."""
    for mesh in (jittered_cube(8, 2, 0.6, 3), duals.stretched(jittered_cube(8, 2, 0.6, 3), 2.0)):
        inner = mesh.face_cells[:, 1] >= 0
        expected = mesh.face_measures * cotangents(mesh) / 2
        np.testing.assert_allclose(duals.dual_lengths(mesh)[inner], expected[inner], atol=1e-12)


def test_dual_lengths_are_negative_where_a_circumsphere_is_not_empty(delaunay):
    """The lifted determinants show where. In a Delaunay mesh no dual length is negative."""
    inner = delaunay.face_cells[:, 1] >= 0
    assert not (duals.dual_lengths(delaunay)[inner] < -1e-9).any()
    for stretch in (1.3, 2.0, 3.0):
        mesh = duals.stretched(delaunay, stretch)
        inner = mesh.face_cells[:, 1] >= 0
        backwards = duals.dual_lengths(mesh)[inner] < -1e-9
        assert backwards.any()
        assert (backwards == duals.inside_a_sphere(mesh)).all()


def test_diamonds_sum_to_the_measure_of_the_mesh(delaunay):
    """Σ A l* / d is the volume. Σ A |l*| / d exceeds it if dual lengths are negative."""
    mesh = duals.stretched(delaunay, 2.0)
    lengths = duals.dual_lengths(mesh)
    assert duals.overlap(mesh, lengths) > 0.05
    assert duals.overlap(delaunay, duals.dual_lengths(delaunay)) < 0.01
    with pytest.raises(ArithmeticError, match="the diamonds measure"):
        duals.overlap(mesh, 1.01 * lengths)


def test_barycentric_dual_edges_connect_centroids(delaunay):
    """They connect the centroid of a cell with the centroids of its faces."""
    segments, faces = barycentric_dual(delaunay)
    cells = np.repeat(np.arange(len(delaunay.cells)), delaunay.cells.shape[1])
    np.testing.assert_allclose(segments[:, 0], delaunay.cell_centers[cells], atol=1e-15)
    np.testing.assert_allclose(segments[:, 1], delaunay.face_centers[faces], atol=1e-15)
    assert (np.bincount(faces) == 1 + (delaunay.face_cells[:, 1] >= 0)).all()


def test_a_square_cut_along_its_diagonal_has_a_dual_edge_of_length_zero():
    """Both triangles have their circumcentre in the middle of the square."""
    segments, faces = circumcentric_dual(SimplexMesh(SQUARE, [[0, 1, 2], [0, 2, 3]]))
    lengths = np.linalg.norm(segments[:, 1] - segments[:, 0], axis=1)
    assert sorted(lengths) == [0, 1, 1, 1, 1]
    assert faces.tolist() == [0, 1, 2, 3, 4]


# --- crossings and the table --------------------------------------------------------------------


def test_a_pentagram_has_five_crossings():
    """Each of five chords crosses two others. A regular pentagon has no crossing."""
    angle = 2 * np.pi * np.arange(6) / 5
    ring = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    star = ring[[0, 2, 4, 1, 3, 0]]
    assert len(duals.crossings(np.array([*pairwise(ring)]))) == 0
    crossed = duals.crossings(np.array([*pairwise(star)]))
    assert len(crossed) == 5
    np.testing.assert_allclose(np.linalg.norm(crossed, axis=1), (3 - 5**0.5) / 2, rtol=1e-12)


def test_the_table_shows_the_three_cases_of_the_slides(result):
    """The dual is perpendicular without crossings, perpendicular with crossings, or neither."""
    rows = {(row[0], row[1], row[2]): row[3:] for row in result.tables["duals"].rows}
    for d in (2, 3):
        _, mean, most, backwards, inside, crossings, overlap = rows[d, "Delaunay", "circumcentric"]
        assert mean <= most < 1e-8
        assert (backwards, inside) == (0, 0)
        assert overlap < 0.1
        *_, backwards, inside, crossings, overlap = rows[d, "not Delaunay", "circumcentric"]
        assert 0 < backwards == inside
        assert overlap > 1
        assert crossings == "–" if d == 3 else crossings >= 2 * backwards
        _, mean, _, _, _, crossings, _ = rows[d, "Delaunay", "barycentric"]
        assert mean > 10
        assert crossings in (0, "–")


def test_invalid_parameters_are_refused():
    """The message names the parameter and what is wanted."""
    with pytest.raises(ValueError, match=r"jitter must be 0 or more and less than 1; got 1"):
        replace(duals.QUICK, jitter=1.0)
