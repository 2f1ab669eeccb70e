"""Rank deficiency of B': tangent fields, collinear points, stars of few vertices."""

from itertools import product

import numpy as np
import pytest

from fieldrecon.polynomials import monomials
from fieldreport import experiments
from fieldreport.experiments.velocity import rank_of_normals as module
from fieldreport.experiments.velocity.normal_matrix_rank import normal_matrix, one_ring, rank
from fieldreport.experiments.velocity.rank_of_normals import configurations

CASES = {case.name: case for case in configurations(12, 3)}


@pytest.fixture(scope="module")
def result():
    return experiments.get("rank_of_normals").run(module.QUICK)


def random_normals(n: int, rng: np.random.Generator) -> np.ndarray:
    angle = rng.uniform(0, np.pi, n)
    return np.column_stack([np.cos(angle), np.sin(angle)])


@pytest.mark.parametrize("name", CASES)
def test_the_rank_is_known_although_b_has_full_rank(name):
    """B has rank D + 1 in all configurations, and B' has full rank after a small shift."""
    case = CASES[name]
    p, n = case.at(0.0)
    d = p.shape[1]
    assert rank(monomials(p, 1)) == d + 1
    assert rank(normal_matrix(p, n)) == case.rank
    assert rank(normal_matrix(*case.at(0.1))) == d + d * d
    np.testing.assert_allclose(np.linalg.norm(n, axis=1), 1)


def test_the_smallest_singular_value_is_proportional_to_the_distance(result):
    """The slope is one, with the factor of first-order perturbation theory."""
    assert result.facts["rank_mismatches"] == 0
    assert 0.99 < result.facts["least_slope"] <= result.facts["largest_slope"] < 1.01
    assert result.facts["rate_difference"] < 1e-4


def test_the_null_vectors_are_tangent_fields(result):
    """Each drawn field is affine, nonzero, and tangent at all samples."""
    names = {key.removesuffix("_field") for key in result.arrays if key.endswith("_field")}
    assert len(names) == 10
    for name in names:
        p, n, c = (result.arrays[f"{name}_{key}"] for key in ("p", "n", "field"))
        assert np.linalg.norm(c) > 1e-3
        u = monomials(p, 1) @ c.reshape(3, 2)
        assert np.abs((n * u).sum(axis=1)).max() < 1e-12


def test_normals_perpendicular_to_an_affine_field_make_b_deficient():
    """The rank is 5 of 6 for any points and any affine field of rank 2."""
    rng = np.random.default_rng(1)
    for _ in range(50):
        p, c = rng.standard_normal((9, 2)), rng.standard_normal((3, 2))
        u = monomials(p, 1) @ c
        n = np.column_stack([-u[:, 1], u[:, 0]]) / np.linalg.norm(u, axis=1)[:, None]
        assert rank(normal_matrix(p, n)) == 5
        assert rank(normal_matrix(p, random_normals(9, rng))) == 6


def test_the_rank_does_not_depend_on_signs_and_weights():
    """The rank equals that of diag(±w) B' for any nonzero weights."""
    rng = np.random.default_rng(2)
    for name, case in CASES.items():
        b = normal_matrix(*case.at(0.0))
        w = rng.choice([-1, 1], len(b)) * rng.uniform(0.1, 10, len(b))
        assert rank(w[:, None] * b) == rank(b), name


def test_two_directions_on_three_points_each_suffice():
    """As on a staggered grid, each component is known at three points that are not collinear."""
    rng = np.random.default_rng(3)
    for _ in range(20):
        m = np.repeat(random_normals(2, rng), 3, axis=0)
        p = rng.standard_normal((6, 2))
        assert rank(normal_matrix(p, m)) == 6
        p[2] = (p[0] + p[1]) / 2
        assert rank(normal_matrix(p, m)) == 5


# --- ranks allowed by the points ------------------------------------------------------------------


def test_five_collinear_points_of_six_make_b_deficient_for_any_normals():
    """B has full rank; u = l(x) m with l = 0 on the line and m along the sixth edge is lost."""
    p = np.array([[k, 0] for k in range(5)] + [[1, 1]], dtype=float)
    rng = np.random.default_rng(4)
    assert rank(monomials(p, 1)) == 3
    for _ in range(100):
        n = random_normals(6, rng)
        b = normal_matrix(p, n)
        assert rank(b) <= 5
        c = np.zeros((3, 2))
        c[2] = [-n[5, 1], n[5, 0]]  # l(x) = y
        assert np.abs(b @ c.ravel()).max() < 1e-14


def test_the_best_rank_is_that_of_the_best_partition():
    """The maximum of rank B_1 + rank B_2 over all partitions into two parts, by enumeration."""
    rng = np.random.default_rng(5)
    found = set()
    for _ in range(60):
        n = int(rng.integers(3, 8))
        p = rng.integers(-1, 2, (n, 2)).astype(float)
        b = monomials(p, 1)
        best = 0
        for side in product([False, True], repeat=n):
            first = np.array(side)
            parts = [rank(x) if len(x) else 0 for x in (b[first], b[~first])]
            best = max(best, sum(parts))
        assert module.best_rank(p) == best
        found.add(best)
    assert {4, 5, 6} <= found


def test_random_normals_attain_the_best_rank(result):
    """This holds for every set drawn; some sets with B of full rank cannot attain rank 6."""
    assert result.facts["sets_mismatches"] == 0
    assert result.facts["sets_spoilt"] > 0


# --- tetrahedra ---------------------------------------------------------------------------------


def test_a_star_of_tetrahedra_requires_seven_vertices(result):
    """V random vertices give rank min(12, 3V - 8); full rank determines the velocity."""
    rows = [row for row in result.tables["stars"].rows if row[0] == "at random"]
    assert [row[1] for row in rows] == list(module.QUICK.vertices)
    for _, v, cells, faces, bound, lowest, highest, determined in rows:
        assert (cells, faces) == (2 * v - 6, 5 * v - 15)
        assert bound == lowest == highest == min(12, 3 * v - 8)
        assert determined == (100 if v >= 7 else 0)


def test_the_octahedron_has_rank_ten(result):
    """Volume-preserving stretches along its axes are lost; the velocity at the centre is not."""
    row = result.tables["stars"].rows[-1]
    assert row[0] == "octahedron"
    assert row[4:] == (12, 10, 10, 100.0)
    mesh = module._star(module.OCTAHEDRON)
    b = normal_matrix(mesh.face_centers, mesh.face_normals)
    for stretch in ([1, -1, 0], [0, 1, -1]):
        c = np.vstack([np.zeros(3), np.diag(stretch)])
        assert np.abs(b @ c.ravel()).max() < 1e-14


def test_ranks_are_affine_invariant():
    """Points and velocities transform by A, areas times normals by its cofactor matrix."""
    rng = np.random.default_rng(6)
    for star in (module._star(module.OCTAHEDRON), *module._random_stars(3, 6, rng)):
        a = np.eye(3) + rng.uniform(-0.4, 0.4, (3, 3))
        moved = type(star)(star.points @ a.T, star.cells)
        before, after = (one_ring(mesh, np.zeros(len(mesh.faces))) for mesh in (star, moved))
        assert before.rank[0] == after.rank[0]
        assert before.determined[0] == after.determined[0]
