"""Vertex velocities from one ring and from more rings: ranks, errors and orders."""

from dataclasses import replace

import numpy as np
import pytest

from fieldrecon.kernels.weights import inverse_square
from fieldrecon.meshes.simplex_mesh import SimplexMesh
from fieldrecon.polynomials import monomials
from fieldrecon.velocity.vertices import normal_velocities, velocity_weights, vertex_velocities
from fieldreport import experiments
from fieldreport.experiments.meshes.reference_flows import (
    jittered_cube,
    random_square,
    rotation,
    taylor_green,
)
from fieldreport.experiments.velocity import normal_matrix_rank
from fieldreport.experiments.velocity import rotational_velocity as module
from fieldreport.experiments.velocity.normal_matrix_rank import (
    SPACE,
    conics_through,
    counts_of_mesh,
    error_by_conics,
    field_along,
    normal_matrix,
    one_ring,
    rank,
    rotation_in_space,
    vertices_around,
)

pytestmark = pytest.mark.slow  # experiments are run

ROUNDING = 1e-12


@pytest.fixture(scope="module")
def result():
    return experiments.get("rotational_velocity").run(module.QUICK)


@pytest.fixture(scope="module")
def refined():
    params = replace(module.QUICK, sides_2d=(16, 32, 64), sides_3d=(5, 10), weights_side=16)
    return experiments.get("rotational_velocity").run(params)


# --- the conic theorem --------------------------------------------------------------------------


def test_the_normal_velocity_of_an_edge_is_the_difference_of_psi():
    """l n·u(p) = ψ(x_j) - ψ(x_i) for every quadratic stream function ψ and every edge."""
    rng = np.random.default_rng(1)
    psi = rng.standard_normal(6)
    start, end = rng.standard_normal((2, 50, 2))
    edge = end - start
    l_n = np.column_stack([edge[:, 1], -edge[:, 0]])
    u = monomials((start + end) / 2, 1) @ field_along(psi).reshape(3, 2)
    rise = (monomials(end, 2) - monomials(start, 2)) @ psi
    np.testing.assert_allclose((l_n * u).sum(axis=1), rise, atol=ROUNDING)


def test_ranks_agree_with_the_conic_theorem(result):
    """At every vertex rank B' is the rank of the Vandermonde matrix of degree 2."""
    assert result.facts["counted"] > 300
    assert result.facts["rank_mismatches"] == 0


def test_ranks_grow_with_the_number_of_triangles(result):
    """min(6, N + 1) inside, min(6, N + 2) on the boundary; only rank 6 determines the velocity."""
    seen = set()
    for where, triangles, _, lowest, highest, determined, *_ in result.tables["valences"].rows:
        n = int(str(triangles).split()[0])
        full = min(6, n + (1 if where == "inside" else 2))
        assert (lowest, highest) == (full, full)
        assert (determined > 0) == (full == 6)
        seen.add((where, n))
    assert {("inside", 3), ("inside", 4), ("boundary", 2), ("boundary", 3)} <= seen


def test_the_conics_predict_the_error(result, monkeypatch):
    """The component of the field along them is lost for any normals; a wrong curl is detected."""
    assert result.facts["difference_from_conics"] < ROUNDING
    monkeypatch.setattr(normal_matrix_rank, "_CURL", np.roll(normal_matrix_rank._CURL, 1, axis=0))
    assert counts_of_mesh(random_square(60, 5, 0))[:, -1].max() > 1e-2


def union_jack(side: int) -> SimplexMesh:
    """A grid whose diagonals meet in every second vertex, in eight triangles."""
    p = np.indices((side + 1, side + 1)).reshape(2, -1).T
    cells = []
    for i, j in np.ndindex(side, side):
        a, b, c, d = ((i + k) * (side + 1) + j + m for k, m in ((0, 0), (1, 0), (1, 1), (0, 1)))
        cells += [[a, b, c], [a, c, d]] if (i + j) % 2 == 0 else [[a, b, d], [b, c, d]]
    return SimplexMesh(p.astype(float), cells)


def test_a_regular_grid_has_conics_that_random_meshes_lack():
    """On the boundary, the six vertices of four triangles lie on two parallel lines: rank 5.

    Inside, four triangles form a cross: rank 5 as well, but the two lines meet at the vertex.
    """
    mesh = union_jack(4)
    fit = one_ring(mesh, np.zeros(len(mesh.faces)))
    fans = np.diff(mesh.vertex_cell_incidence.indptr)
    four = fans == 4
    assert set(fit.rank[four]) == {5}
    assert not fit.determined[four & mesh.boundary_vertices].any()
    assert fit.determined[four & ~mesh.boundary_vertices].all()
    assert fit.determined[fans == 8].all()


def test_no_conic_through_a_determined_vertex_is_smooth_there():
    """At a determined vertex every conic through the ring has zero gradient."""
    for mesh in (random_square(60, 5, 3), union_jack(4)):
        fit = one_ring(mesh, np.zeros(len(mesh.faces)))
        for i in range(len(mesh.points)):
            slope = np.abs(conics_through(vertices_around(mesh, i))[1:3]).max(initial=0)
            assert (slope < 1e-9) == fit.determined[i]


# --- the exercise -------------------------------------------------------------------------------


def test_a_rotation_is_exact_at_determined_vertices(result):
    """One ring suffices there, and enough rings suffice everywhere, with and without weights."""
    facts = result.facts
    for name in ("error_where_determined", "error_ls", "error_mls"):
        assert facts[name] < ROUNDING
    assert facts["error_one_ring"] > 0.1
    assert facts["undetermined"] == facts["of_three"] + facts["of_four"] + facts["on_boundary"]
    assert facts["most_rings"] == 2


def test_the_mean_of_two_ends_is_the_midpoint_value_for_affine_fields(result):
    """For other fields it differs by l²/8 times the second derivative along the edge, and O(l⁴)."""
    assert result.facts["midpoint_difference"] < ROUNDING
    for h in (1e-2, 1e-3):
        mesh = SimplexMesh(0.3 + h * np.array([[0, 0], [1, 0.2], [0.1, 1]]), [[0, 1, 2]])
        v = normal_velocities(mesh, taylor_green(mesh.points))
        halfway = taylor_green(mesh.face_centers)
        edge = np.diff(mesh.points[mesh.faces], axis=1)[:, 0]
        second = (taylor_green(mesh.face_centers + edge / 2) - halfway) + (
            taylor_green(mesh.face_centers - edge / 2) - halfway
        )
        bend = np.einsum("fd,fd->f", mesh.face_normals, second) / 2
        off = v - np.einsum("fd,fd->f", mesh.face_normals, halfway)
        np.testing.assert_allclose(off, bend, atol=1e-13)
        assert 0.1 * h**2 < np.abs(off).max() < 10 * h**2


# --- refinement -----------------------------------------------------------------------------------


def test_enough_rings_give_second_order(refined):
    """This holds in the plane and in space, with equal weights and with those of the slides."""
    for name in ("ls_2d", "mls_2d", "ls_3d", "mls_3d"):
        assert 1.7 < refined.facts[f"order_{name}"] < 2.5


def test_one_ring_does_not_converge(refined):
    """At vertices that one ring does not determine, the error stays of order one."""
    table = refined.tables["convergence"]
    rows = np.array(table.rows, dtype=float)[:3]
    one, ls = (rows[:, table.columns.index(f"{name} rms")] for name in ("one ring", "LS"))
    assert one[0] > one[-1] > 0.2 * one[0]
    assert one[-1] > 5 * ls[-1]
    assert refined.facts["undetermined_2d"] > 0.05


def test_weights_reduce_the_error_where_two_rings_are_needed(refined):
    """They reduce the influence of the far edges of the second ring."""
    assert refined.facts["gain_2"] > 1.5
    assert 0.8 < refined.facts["gain_1"] < 1.2


def test_narrow_weights_cost_noise(refined):
    """The narrower the weight, the fewer edges share the noise; the error hardly changes.

    On the same edges no weights have less noise than equal ones, at no vertex (Gauss and Markov).
    """
    assert refined.facts["least_noise_on_same_edges"] > 1 - 1e-12
    on_same = np.array(refined.tables["weights"].column("noise / LS, same edges"))
    assert on_same[0] == 1
    assert np.all(np.diff(on_same) > 0)
    noise = np.array(refined.tables["weights"].column("noise"))
    error = np.array(refined.tables["weights"].column("error"))
    assert np.all(np.diff(noise) > 0)
    assert error.max() / error.min() < 1.5


def test_vertices_that_take_other_edges_have_the_largest_noise_with_equal_weights():
    """They are a part of its mean square, not the most of it, and reverse the comparison."""
    params = replace(module.QUICK, weights_side=32, ratios=(1.0,))
    rows, facts = module._compared_weights(params)
    assert rows[1][4] < 1 < rows[1][5]
    mesh = jittered_cube(32, 2, params.jitter, params.seed)
    noise, rings = [], []
    for weight in (None, inverse_square(1 / 32)):
        x, y = velocity_weights(mesh, weight)
        noise.append(x.power(2).sum(axis=1) + y.power(2).sum(axis=1))
        rings.append(vertex_velocities(mesh, np.zeros(len(mesh.faces)), weight).rings)
    others = np.flatnonzero(rings[0] != rings[1])
    assert set(others) == set(np.argsort(noise[0])[-len(others) :])
    share = noise[0][others].sum() / noise[0].sum()
    assert 0.1 < share < 0.5
    assert facts["share_with_other_edges"] == pytest.approx(share, rel=1e-9)


# --- in space -----------------------------------------------------------------------------------


@pytest.mark.parametrize("d", [2, 3])
def test_the_rank_is_bounded_by_faces_and_cells(d):
    """rank B' <= F - T + 1, since the outflows of the T cells all equal tr G times the volume."""
    for mesh in (jittered_cube(4, d, 0.6, 1), jittered_cube(3, d, 0.0, 1)):
        fit = one_ring(mesh, np.zeros(len(mesh.faces)))
        faces, cells = (np.diff(x.indptr) for x in (mesh.faces_around(), mesh.cells_around()))
        assert np.all(fit.rank <= np.minimum(d + d * d, faces - cells + 1))
        # the bound is attained at nearly all vertices
        assert np.mean(fit.rank == np.minimum(d + d * d, faces - cells + 1)) > 0.4


def test_in_space_one_ring_is_insufficient_on_the_boundary_only():
    """Inside a tetrahedral mesh there are enough vertices; elsewhere two rings suffice."""
    row = dict(zip(SPACE, rotation_in_space(jittered_cube(5, 3, 0.6, 2)), strict=True))
    assert row["undetermined by one ring"] > 0
    assert row["undetermined inside"] == row["more rings"] == 0
    assert row["largest error, one ring"] > 0.1
    assert row["largest error"] < ROUNDING


def test_rotations_in_space_have_their_axis():
    """u = (1, 1, 1) × (x - m): no velocity along the axis, and zero velocity on it."""
    x, m = np.random.default_rng(4).standard_normal((20, 3)), np.array([0.3, 0.1, -1.0])
    assert np.abs(rotation(x, m) @ np.ones(3)).max() < ROUNDING
    assert np.abs(rotation(m + np.ones((1, 3)), m)).max() < ROUNDING


def test_the_matrix_and_its_solution_agree_with_the_slides():
    """Rows (nᵀ, x nᵀ, y nᵀ) of p. 22; the minimum-norm solution is that of numpy.linalg.lstsq."""
    mesh = random_square(40, 5, 8)
    v = np.random.default_rng(9).standard_normal(len(mesh.faces))
    fit = one_ring(mesh, v)
    for i in range(0, len(mesh.points), 5):
        faces = mesh.faces_around(1, [i]).indices
        (y, n) = mesh.face_centers[faces] - mesh.points[i], mesh.face_normals[faces]
        y = y / np.abs(y).max()
        b = np.column_stack([n, y[:, :1] * n, y[:, 1:] * n])
        np.testing.assert_array_equal(normal_matrix(y, n), b)
        assert rank(b) == fit.rank[i]
        c = np.linalg.lstsq(b, v[faces], rcond=1e-9)[0]
        np.testing.assert_allclose(fit.values[i], c[:2], atol=1e-9)


def test_without_a_conic_no_error_is_predicted():
    mesh = random_square(60, 5, 3)
    i = int(np.diff(mesh.vertex_cell_incidence.indptr).argmax())
    assert not error_by_conics(mesh, i, np.ones(2), np.eye(2)).any()
