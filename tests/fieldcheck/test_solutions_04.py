"""The solutions of notebook 04 agree with the library."""

import numpy as np
import pytest

from checkout import ROOT
from fieldcheck.questions.q03_radial_basis_functions import cloud
from fieldcheck.questions.q04_rank_of_normals import directions, flow
from fieldgrade.authoring.sources import Source
from fieldrecon import SimplexMesh
from fieldreport.experiments.velocity.normal_matrix_rank import (
    conics_through,
    field_along,
    normal_matrix,
    one_ring,
    rank,
    vertices_around,
)
from fieldreport.experiments.velocity.rank_of_normals import configurations

NOTEBOOK = Source(ROOT / "solutions/04_rank_of_normals.py").functions()


@pytest.fixture
def random():
    return np.random.default_rng(404)


def ring_about(center: np.ndarray, k: int, random: np.random.Generator) -> np.ndarray:
    """Return k neighbours of a vertex in order around it."""
    angle = 2 * np.pi * (np.arange(k) + random.uniform(-0.2, 0.2, k)) / k
    return center + random.uniform(0.7, 1.3, (k, 1)) * np.stack([np.cos(angle), np.sin(angle)], 1)


@pytest.mark.parametrize("d", [2, 3])
def test_the_matrix_agrees_with_the_report(random, d):
    """The matrices agree in the plane and in space, with the same order of columns."""
    points, normals = random.normal(size=(9, d)), random.normal(size=(9, d))
    mine = NOTEBOOK["velocity_matrix"](points, normals)
    np.testing.assert_allclose(mine, normal_matrix(points, normals), atol=1e-15)


@pytest.mark.parametrize("case", configurations(12, 3), ids=lambda case: case.name)
def test_the_rank_agrees_with_the_known_rank(case):
    """This holds for all configurations of the report, at any position."""
    points, normals = case.at(0.0)
    assert NOTEBOOK["velocity_rank"](points, normals) == case.rank
    assert NOTEBOOK["velocity_rank"](1e-5 * points + 3, normals) == case.rank
    assert NOTEBOOK["velocity_rank"](*case.at(0.1)) == points.shape[1] * (points.shape[1] + 1)


def test_the_flow_is_recovered_from_normals_perpendicular_to_it(random):
    """`tangent_field` and `crossing_normals` are inverse to each other up to a factor."""
    for _ in range(20):
        points, c = cloud(random, 12, 2), flow(random)
        normals = NOTEBOOK["crossing_normals"](points, c)
        found = NOTEBOOK["tangent_field"](points, normals)
        cosine = abs(found @ c) / np.linalg.norm(found) / np.linalg.norm(c)
        assert cosine == pytest.approx(1, abs=1e-9)


def test_full_rank_implies_the_obvious_conditions(random):
    """The converse is false: the normals of a rotation satisfy them."""
    found = set()
    for _ in range(150):
        points = random.integers(0, 3, (7, 2)).astype(float)
        angle = random.integers(0, 4, 7) * np.pi / 4
        normals = np.stack([np.cos(angle), np.sin(angle)], 1)
        full = rank(normal_matrix(points, normals)) == 6
        obvious = NOTEBOOK["obvious"](points, normals)
        assert obvious or not full
        found.add((full, obvious))
    assert {(True, True), (False, False)} <= found
    points = cloud(random, 7, 2)
    about = points - 0.5
    normals = about / np.linalg.norm(about, axis=1)[:, None]
    assert NOTEBOOK["obvious"](points, normals)
    assert rank(normal_matrix(points, normals)) == 5


@pytest.mark.parametrize("k", [3, 4, 5, 6, 8])
def test_the_samples_of_a_star_are_those_of_its_mesh(random, k):
    """The matrices agree up to order and signs of the rows; the conic theorem gives the rank."""
    center = random.normal(size=2)
    ring = ring_about(center, k, random)
    cells = [[0, 1 + i, 1 + (i + 1) % k] for i in range(k)]
    mesh = SimplexMesh(np.insert(ring, 0, center, axis=0), cells)
    points, normals = NOTEBOOK["star_samples"](center, ring)
    mine = NOTEBOOK["velocity_matrix"](points, normals)
    theirs = normal_matrix(mesh.face_centers, mesh.face_normals)
    np.testing.assert_allclose(mine.T @ mine, theirs.T @ theirs, atol=1e-12)
    by_mesh = one_ring(mesh, np.zeros(len(mesh.faces))).rank[0]
    assert NOTEBOOK["velocity_rank"](points, normals) == by_mesh == min(6, k + 1)
    assert NOTEBOOK["conic_rank"](mesh.points) == by_mesh


def test_the_null_vector_of_a_star_is_the_field_along_its_conic(random):
    """The conic passes through the vertices of the star."""
    ring = ring_about(np.zeros(2), 4, random)
    cells = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 1]]
    mesh = SimplexMesh(np.insert(ring, 0, 0.0, axis=0), cells)
    along = field_along(conics_through(vertices_around(mesh, 0)))[:, 0]
    found = NOTEBOOK["tangent_field"](*NOTEBOOK["star_samples"](np.zeros(2), ring))
    assert abs(found @ along) == pytest.approx(np.linalg.norm(along), abs=1e-9)


def test_the_conic_rank_is_six_minus_the_number_of_conics(random):
    """The points belong to a small grid, so that many of them lie on conics."""
    found = set()
    for _ in range(60):
        vertices = random.integers(0, 3, (int(random.integers(3, 9)), 2)).astype(float)
        if np.ptp(vertices) > 0:
            wanted = 6 - conics_through(vertices - 1).shape[1]
            assert NOTEBOOK["conic_rank"](vertices) == wanted
            found.add(wanted)
    assert {3, 4, 5, 6} <= found


def test_rotating_all_normals_does_not_increase_the_rank(random):
    """Normals perpendicular to a rotation are, when rotated, perpendicular to a spiral flow."""
    points = cloud(random, 9, 2)
    hidden = NOTEBOOK["crossing_normals"](points, np.array([0.5, -0.5, 0, 1, -1, 0]))
    for angle in random.uniform(0, np.pi, 10):
        turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
        assert NOTEBOOK["velocity_rank"](points, hidden @ turn) == 5
    hidden[2] = directions(random, 1)[0]
    assert NOTEBOOK["velocity_rank"](points, hidden) == 6
