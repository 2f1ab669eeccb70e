"""Velocities at vertices: affine fields, the conic theorem, rings, weights and refusals."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrecon._numerics.weighted_least_squares import estimable_weights
from fieldrecon.kernels.conditionally_positive_definite import thin_plate_spline
from fieldrecon.kernels.positive_definite import gaussian, wendland
from fieldrecon.kernels.weights import inverse_square
from fieldrecon.meshes.simplex_mesh import SimplexMesh
from fieldrecon.polynomials import monomials
from fieldrecon.velocity.stencils import WELL_DETERMINED, MatrixOfWeights, Stencils
from fieldrecon.velocity.vertices import (
    divergence,
    normal_velocities,
    point_velocities,
    point_velocity_weights,
    velocity_weights,
    vertex_velocities,
)
from laws import assert_close
from meshes import abc_flow, affine, jittered_mesh, order, random_mesh, rms, star, taylor_green

EXACT = 1e-11
MESHES = {
    "random 2-D": random_mesh(600, 2, 1),
    "random 3-D": random_mesh(200, 3, 2),
    "jittered 2-D": jittered_mesh(12, 2, 3),
    "jittered 3-D": jittered_mesh(4, 3, 4),
}


@pytest.fixture(params=MESHES, scope="module")
def mesh(request) -> SimplexMesh:
    return MESHES[request.param]


def slides_matrix(mesh: SimplexMesh, faces: np.ndarray, i: int) -> np.ndarray:
    """B' of p. 22 relative to vertex i, with one row (nᵀ, y₁nᵀ, … y_dnᵀ) per face."""
    y = mesh.face_centers[faces] - mesh.points[i]
    y = y / np.abs(y).max()
    n = mesh.face_normals[faces]
    return np.concatenate([n, *(y[:, [k]] * n for k in range(y.shape[1]))], axis=1)


def amplification(b: np.ndarray, d: int) -> float:
    """Largest row norm of the weights of the value, infinite if a null vector affects the value."""
    _, s, vt = np.linalg.svd(b)
    kept = (s > 1e-12 * s[0]).sum()
    if np.abs(vt[kept:, :d]).max(initial=0) > 1e-10:
        return np.inf
    return float(np.linalg.norm(vt[:kept, :d].T / s[:kept], axis=1).max())


# --- anywhere -------------------------------------------------------------------------------------


def somewhere(mesh: SimplexMesh) -> np.ndarray:
    """Points inside cells, on faces, outside, and the vertices."""
    size = np.ptp(mesh.points, axis=0)
    outside = mesh.points.max(axis=0) + 0.1 * size * np.arange(1, 4)[:, None]
    return np.concatenate(
        [mesh.cell_centers[::5], mesh.face_centers[::7], outside, mesh.points[::3]]
    )


def velocities_are_those_of_the_fit_about_the_point(reconstruct, mesh: SimplexMesh) -> None:
    """Affine fields are reproduced and others are not; weights are centred at the point."""
    x = somewhere(mesh)
    for seed in range(2):
        field = affine(mesh, seed)
        found = reconstruct(mesh, normal_velocities(mesh, field(mesh.points)), x, None)
        assert_close(found, field(x), EXACT)
    v = np.random.default_rng(0).normal(size=len(mesh.faces))
    for weight in (None, inverse_square(0.1), gaussian(0.4)):
        at_vertices = reconstruct(mesh, v, mesh.points, weight)
        assert_close(at_vertices, vertex_velocities(mesh, v, weight).values, EXACT)
    near, quadratic = mesh.cell_centers[:5], (mesh.points**2)
    curved = reconstruct(mesh, normal_velocities(mesh, quadratic), near, None)
    assert np.abs(curved - near**2).max() > 1e-4
    narrow = gaussian(0.2 * np.ptp(mesh.points))
    d = mesh.points.shape[1]
    for p, found in zip(near, reconstruct(mesh, v, near, narrow), strict=True):
        nearest = int(np.argmin(np.linalg.norm(mesh.points - p, axis=1)))
        rings = int(point_velocities(mesh, v, [p], narrow).rings[0])
        faces = mesh.faces_around(rings, [nearest]).indices
        y = mesh.face_centers[faces] - p
        w = narrow(np.linalg.norm(y, axis=1))
        n = mesh.face_normals[faces]
        b = np.concatenate([n, *(y[:, [k]] * n for k in range(d))], axis=1)
        c = np.linalg.lstsq(w[:, None] / w.max() * b, w / w.max() * v[faces], rcond=1e-13)[0][:d]
        assert_close(found, c, 1e-6 * max(1.0, np.abs(c).max()))


def at_points(mesh, v, x, weight):
    return point_velocities(mesh, v, x, weight).values


def by_weights(mesh, v, x, weight):
    return np.stack([w @ v for w in point_velocity_weights(mesh, x, weight)], axis=-1)


def at_the_nearest_vertex(mesh, v, x, weight):
    nearest = np.linalg.norm(mesh.points - x[:, None], axis=2).argmin(axis=1)
    return vertex_velocities(mesh, v, weight, nearest).values


def without_weights(mesh, v, x, weight):  # noqa: ARG001
    return point_velocities(mesh, v, x).values


@pytest.mark.parametrize("reconstruct", [at_points, by_weights])
def test_velocities_anywhere(reconstruct):
    """Values and weights, in the plane and in space."""
    for name in ("jittered 2-D", "jittered 3-D"):
        velocities_are_those_of_the_fit_about_the_point(reconstruct, MESHES[name])


@pytest.mark.parametrize("mutant", [at_the_nearest_vertex, without_weights])
def test_the_law_of_velocities_anywhere_can_fail(mutant):
    """For the velocity of the nearest vertex, and for weights that are ignored."""
    with pytest.raises(AssertionError):
        velocities_are_those_of_the_fit_about_the_point(mutant, MESHES["jittered 2-D"])


def test_several_velocities_at_points_are_those_of_each_alone():
    """Data of the shape (f, 2, 3) are six normal velocities."""
    mesh = MESHES["jittered 2-D"]
    v = np.random.default_rng(0).normal(size=(len(mesh.faces), 2, 3))
    found = point_velocities(mesh, v, mesh.cell_centers[:4]).values
    assert found.shape == (4, 2, 3, 2)
    for i, j in np.ndindex(2, 3):
        alone = point_velocities(mesh, v[:, i, j], mesh.cell_centers[:4]).values
        assert_close(found[:, i, j], alone, EXACT)


# --- affine fields ------------------------------------------------------------------------------


def affine_fields_are_reproduced(reconstruct, mesh: SimplexMesh, tolerance: float = EXACT) -> None:
    """This must hold at every vertex, including the boundary."""
    for seed in range(3):
        u = affine(mesh, seed)(mesh.points)
        assert_close(reconstruct(mesh, normal_velocities(mesh, u)), u, tolerance)


def values(mesh, v, weight=None):
    return vertex_velocities(mesh, v, weight).values


def test_affine_fields_are_reproduced(mesh):
    """For u = c + Gx the data v_a = n_a·u(p_a) are exact, and so is u at each vertex."""
    affine_fields_are_reproduced(values, mesh)


def test_rotations_are_reproduced(mesh):
    """The field is u = J(x - m) of the exercise on p. 43, and its analogue in space."""
    d = mesh.points.shape[1]
    upper = np.triu(np.ones((d, d)), 1)
    u = (mesh.points - mesh.points.mean(axis=0)) @ (upper - upper.T)
    assert_close(values(mesh, normal_velocities(mesh, u)), u, EXACT)


@pytest.mark.slow
@pytest.mark.parametrize(
    "weight",
    [
        lambda _: inverse_square(0.0),
        inverse_square,
        lambda h: gaussian(h / 3),
        lambda h: wendland(3, 1, 6 * h),
    ],
    ids=["singular", "slides", "narrow", "compact"],
)
def test_affine_fields_are_reproduced_for_every_weight(mesh, weight):
    """The weights of the faces may differ by orders of magnitude.

    The length h is the spacing of the points.
    """
    h = len(mesh.points) ** (-1 / mesh.points.shape[1])
    affine_fields_are_reproduced(lambda mesh, v: values(mesh, v, weight(h)), mesh)


@pytest.mark.parametrize("unit", [1e-100, 1e100])
@pytest.mark.parametrize("length", [None, 0.1])
def test_affine_fields_are_reproduced_in_every_unit(mesh, unit, length):
    """The length of the weight function must be given in the same unit."""
    weight = None if length is None else inverse_square(length * unit)
    scaled = SimplexMesh(mesh.points * unit, mesh.cells)
    affine_fields_are_reproduced(lambda mesh, v: values(mesh, v, weight), scaled)


def test_affine_fields_are_reproduced_far_from_the_origin(mesh):
    """Offsets are differences of points, so the rounding of the centroids has no effect."""
    affine_fields_are_reproduced(values, SimplexMesh(mesh.points + 1e6, mesh.cells))


def spokes_only(mesh: SimplexMesh, v: np.ndarray) -> np.ndarray:
    """Mutant: the least-norm solution from the faces at the vertex only."""
    u = []
    for i in range(len(mesh.points)):
        faces = np.flatnonzero((mesh.faces == i).any(axis=1))
        u.append(np.linalg.lstsq(slides_matrix(mesh, faces, i), v[faces], rcond=1e-12)[0])
    return np.array(u)[:, : mesh.points.shape[1]]


def one_ring_only(mesh: SimplexMesh, v: np.ndarray) -> np.ndarray:
    """Mutant: the least-norm solution from one ring at every vertex, as on the slides."""
    around = mesh.faces_around(1)
    u = []
    for i in range(len(mesh.points)):
        faces = around[[i]].indices
        u.append(np.linalg.lstsq(slides_matrix(mesh, faces, i), v[faces], rcond=1e-12)[0])
    return np.array(u)[:, : mesh.points.shape[1]]


def one_normal_reversed(mesh: SimplexMesh, v: np.ndarray) -> np.ndarray:
    """Mutant: one normal has the wrong sign."""
    return values(mesh, np.where(np.arange(len(v)) == 7, -v, v))


@pytest.mark.parametrize("mutant", [spokes_only, one_ring_only, one_normal_reversed])
def test_mutants_do_not_reproduce_affine_fields(mutant):
    """At some vertex the error exceeds 0.1.

    The formulas of p. 19-23 would have this error silently.
    """
    with pytest.raises(AssertionError, match="deviates"):
        affine_fields_are_reproduced(mutant, MESHES["random 2-D"], 0.1)


# --- rank and rings -----------------------------------------------------------------------------


def patch(kind: str, rng: np.random.Generator) -> SimplexMesh:
    """A star of 4 to 8 triangles with vertices in general position, on an ellipse or two lines."""
    n = int(rng.integers(4, 9))
    if kind == "two lines":  # both lines contain the centre
        line = rng.uniform(0, np.pi) + np.array([0, rng.uniform(0.5, 2.5)])
        angle = np.sort(np.concatenate([line, line + np.pi]))
        radius = rng.uniform(0.5, 1.5, 4)
        ring = radius[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])
        points = np.vstack([[[0.0, 0.0]], ring])
    else:
        angle = np.sort(rng.uniform(0, 2 * np.pi, n))
        points = np.column_stack([np.cos(angle), np.sin(angle)])
        if kind == "general":
            points = points * rng.uniform(0.5, 1.5, (n, 1))
        points = points @ rng.uniform(-1, 1, (2, 2)) + rng.uniform(-1, 1, 2)
    return SimplexMesh.delaunay(points)


@pytest.mark.parametrize("kind", ["general", "ellipse", "two lines"])
def test_the_rank_equals_that_of_quadratics_at_the_vertices(kind):
    """rank B' is the rank of the Vandermonde matrix of degree 2 at the vertices of the patch.

    The null space consists of ∇⊥ψ with ψ quadratic and constant on the vertices, because l n·u(p)
    is the difference of ψ along the edge.
    """
    rng = np.random.default_rng(5)
    ranks = set()
    for _ in range(100):
        mesh = patch(kind, rng)
        used = mesh.points[mesh.referenced]
        y = (used - used.mean(axis=0)) / np.abs(used - used.mean(axis=0)).max()
        faces = np.arange(len(mesh.faces))
        b = slides_matrix(mesh, faces, 0)
        rank = np.linalg.matrix_rank(b, tol=1e-9)
        assert rank == np.linalg.matrix_rank(monomials(y, 2), tol=1e-9)
        ranks.add(int(rank))
    assert max(ranks) == (6 if kind == "general" else 5)


def test_spokes_do_not_determine_an_affine_field():
    """u = x - x_i is tangent to every face at x_i, so the rank is at most 5.

    The value at x_i is determined by five or more spokes, not by three or four.
    """
    for valence in range(3, 10):
        mesh = star(valence, 6)
        spokes = np.flatnonzero((mesh.faces == 0).any(axis=1))
        b = slides_matrix(mesh, spokes, 0)
        assert np.linalg.matrix_rank(b, tol=1e-9) == min(5, valence)
        assert np.isfinite(amplification(b, 2)) == (valence >= 5)


def two_rings(valence: int, seed: int) -> SimplexMesh:
    """A star surrounded by a second ring of triangles."""
    inner = star(valence, seed)
    outer = np.random.default_rng(seed).uniform(1.9, 2.4, (valence, 1)) * inner.points[1:]
    k, n = np.arange(valence), np.roll(np.arange(valence), -1)
    second = [
        np.column_stack([1 + k, 1 + valence + k, 1 + n]),
        np.column_stack([1 + valence + k, 1 + valence + n, 1 + n]),
    ]
    return SimplexMesh(np.vstack([inner.points, outer]), np.vstack([inner.cells, *second]))


@pytest.mark.parametrize("valence", [3, 4, 5, 6, 7])
def test_vertices_of_valence_three_and_four_need_two_rings(valence):
    """N triangles have N + 1 vertices, hence rank min(6, N + 1).

    With a second ring the rank is 6.
    """
    mesh = two_rings(valence, 7)
    assert len(mesh.vertex_cells(0)) == valence
    v = normal_velocities(mesh, affine(mesh, 0)(mesh.points))
    assert vertex_velocities(mesh, v, vertices=[0]).rings[0] == (2 if valence < 5 else 1)


def test_boundary_vertices_with_few_triangles_need_two_rings():
    """N triangles at a boundary vertex have N + 2 vertices; at least four triangles are needed."""
    mesh = MESHES["random 2-D"]
    rings = vertex_velocities(mesh, np.zeros(len(mesh.faces))).rings
    fans = np.diff(mesh.vertex_cell_incidence.indptr)
    few = mesh.boundary_vertices & (fans < 4)
    assert few.any()
    assert (rings[few] >= 2).all()
    many = mesh.boundary_vertices & (fans >= 5)
    assert (rings[many] == 1).mean() > 0.8


def cross(seed: int = 8) -> SimplexMesh:
    """Four triangles at vertex 0 with neighbours on two lines through it."""
    r = np.random.default_rng(seed).uniform(0.5, 1.5, 4)
    points = [[0, 0], [r[0], 0], [0, r[1]], [-r[2], 0], [0, -r[3]]]
    return SimplexMesh(points, [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 1]])


@pytest.mark.parametrize("offset", [0.0, 0.7, 1e3])
def test_the_value_at_the_centre_of_a_cross_is_determined(offset):
    """The rank is 5 of 6, but the conic xy = 0 has gradient zero at the centre.

    One ring suffices.
    """
    mesh = SimplexMesh(cross().points + offset, cross().cells)
    u = affine(mesh, 9)(mesh.points)
    v = normal_velocities(mesh, u)
    assert np.linalg.matrix_rank(slides_matrix(mesh, np.arange(8), 0), tol=1e-9) == 5
    found = vertex_velocities(mesh, v, vertices=[0])
    assert found.rings.tolist() == [1]
    assert_close(found.values, u[:1], EXACT)


@pytest.mark.parametrize(
    ("rows", "known"),
    [(1, [True, True, True, False, False, True]), (2, [True, False, True, *[False] * 3])],
)
def test_coefficients_are_found_if_and_only_if_the_sites_determine_them(rows, known):
    """The value at the origin, and with it the slope along x: by NumPy's pseudoinverse.

    Sites are scattered, on lines through the origin and one beside it, or all in one point. Their
    fits have ranks from one to three, together or alone; two sites on a line are enough for it.
    """
    rng = np.random.default_rng(5)
    along = rng.standard_normal((5, 1))
    lines = [along * [1.0, 2.0], along * [1.0, 0.0], along * [1.0, 0.0] + [0.0, 1.0]]
    sites = np.stack([rng.standard_normal((5, 2)), *lines, np.ones((5, 2)), np.zeros((5, 2))])
    w = rng.uniform(0.1, 1.0, (6, 5))
    w[:, 0] = 1.0
    sites[:, 4], w[:, 4] = rng.standard_normal((6, 2)), 0.0  # they do not count
    for fits, k in ((slice(6), 5), *((slice(i, i + 1), 5) for i in range(6)), (slice(1, 3), 2)):
        b, own = monomials(sites[fits, :k], 1), w[fits, :k]
        expected = np.linalg.pinv(own[..., None] * b, rtol=1e-9)[:, :rows] * own[:, None]
        expected[~np.array(known[fits])] = np.nan
        np.testing.assert_allclose(estimable_weights(b, own, rows), expected, atol=1e-12)


def test_weights_of_sites_on_a_line_are_accurate_to_their_rounding():
    """They reproduce constants and vanish for a slope, most to the last bit, for all weights."""
    rng = np.random.default_rng(0)
    sites = rng.standard_normal((500, 6, 1)) * [1.0, 2.0]
    w = 10.0 ** rng.uniform(-4, 0, (500, 6))
    c = estimable_weights(monomials(sites, 1), w / w.max(axis=1, keepdims=True), 1)[:, 0]
    assert np.median(np.abs(c.sum(axis=1) - 1)) < 1.5e-16
    assert np.median(np.abs((c * sites[..., 0]).sum(axis=1))) < 1.5e-16


def test_the_least_norm_solution_of_a_cross_depends_on_the_origin():
    """Therefore coordinates are relative to the vertex. In another frame the solution is wrong."""
    mesh = cross()
    u = affine(mesh, 9)(mesh.points)
    b = slides_matrix(mesh, np.arange(8), 1)  # coordinates relative to vertex 1
    size = np.abs(mesh.face_centers - mesh.points[1]).max()
    c = np.linalg.lstsq(b, normal_velocities(mesh, u), rcond=1e-12)[0].reshape(3, 2)
    assert np.abs(c[0] - u[1]).max() > 0.01
    at_the_centre = c[0] + (mesh.points[0] - mesh.points[1]) / size @ c[1:]
    assert_close(at_the_centre, u[0], EXACT)  # every solution gives this value


def test_a_ring_of_all_faces_is_the_last():
    """A flat star determines its centre badly, but a second ring has no further faces."""
    angle = 0.1 + 2 * np.pi * np.arange(5) / 5
    rim = np.column_stack([np.cos(angle), 0.01 * np.sin(angle)])
    mesh = SimplexMesh(np.vstack([[0, 0], rim]), [[0, 1 + k, 1 + (k + 1) % 5] for k in range(5)])
    assert amplification(slides_matrix(mesh, np.arange(10), 0), 2) > WELL_DETERMINED
    u = affine(mesh, 3)(mesh.points)
    found = vertex_velocities(mesh, normal_velocities(mesh, u), vertices=[0])
    assert found.rings.tolist() == [1]
    assert_close(found.values, u[:1], 1e-9)


@pytest.mark.slow
def test_rings_are_minimal(mesh):
    """With one ring fewer, the singular values of B' show an amplification above ten."""
    d = mesh.points.shape[1]
    rings = vertex_velocities(mesh, np.zeros(len(mesh.faces))).rings
    for i in range(len(mesh.points)):
        for r in range(1, rings[i] + 1):
            faces = mesh.faces_around(r, [i]).indices
            enough = amplification(slides_matrix(mesh, faces, i), d) <= WELL_DETERMINED
            assert enough == (r == rings[i])


def test_vertex_velocities_equal_weighted_least_squares():
    """argmin |W(B'c - V')|² equals numpy.linalg.lstsq for random data."""
    mesh = MESHES["random 2-D"]
    v = np.random.default_rng(10).standard_normal(len(mesh.faces))
    for weight in (None, inverse_square(0.02)):
        found = vertex_velocities(mesh, v, weight)
        for i in range(0, 600, 7):
            faces = mesh.faces_around(found.rings[i], [i]).indices
            r = np.linalg.norm(mesh.face_centers[faces] - mesh.points[i], axis=1)
            w = np.ones(len(r)) if weight is None else weight(r)
            b = slides_matrix(mesh, faces, i)
            c = np.linalg.lstsq(w[:, None] * b, w * v[faces], rcond=1e-12)[0]
            assert_close(found.values[i], c[:2], 1e-9)


# --- smooth fields ------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize(("u", "d", "sides"), [(taylor_green, 2, (16, 64)), (abc_flow, 3, (6, 12))])
@pytest.mark.parametrize("weighted", [False, True])
def test_vertex_velocities_of_smooth_fields_are_of_second_order(u, d, sides, weighted):
    """The error is proportional to h² on jittered grids, in the plane and in space."""
    errors = []
    for side in sides:
        mesh = jittered_mesh(side, d, 11)
        v = normal_velocities(mesh, u(mesh.points))
        weight = inverse_square(0.5 / side) if weighted else None
        errors.append(rms(values(mesh, v, weight) - u(mesh.points)))
    assert 1.75 < order(*errors, sides[1] / sides[0]) < 2.6


# --- normal velocities and divergence -----------------------------------------------------------


def test_normal_velocities_equal_the_formula_of_the_exercise():
    """v_a = n_aᵀ(u_i + u_j)/2 of p. 43, computed edge by edge."""
    mesh = MESHES["random 2-D"]
    u = taylor_green(mesh.points)
    for a in range(0, len(mesh.faces), 11):
        i, j = mesh.faces[a]
        n = mesh.face_normals[a]
        assert normal_velocities(mesh, u)[a] == pytest.approx(n @ (u[i] + u[j]) / 2, abs=1e-14)


def test_the_divergence_of_an_affine_field_is_its_trace(mesh):
    """Σ l_a v_a / V = tr G, which is zero for fields without divergence."""
    d = mesh.points.shape[1]
    g = np.random.default_rng(12).uniform(-1, 1, (d, d))
    div = divergence(mesh, normal_velocities(mesh, mesh.points @ g.T))
    slope = 1 / mesh.cell_measures * mesh.face_measures[mesh.cell_faces].max(axis=1)  # rounding
    assert np.abs(div - np.trace(g)).max() <= 1e-14 * slope.max()
    free = g - np.trace(g) / d * np.eye(d)
    div = divergence(mesh, normal_velocities(mesh, mesh.points @ free.T))
    assert np.abs(div).max() <= 1e-14 * slope.max()


def test_the_total_divergence_equals_the_boundary_flux(mesh):
    """Gauss's theorem: Σ V div v = Σ l v over the boundary, because interior faces cancel."""
    v = np.random.default_rng(13).standard_normal(len(mesh.faces))
    total = mesh.cell_measures @ divergence(mesh, v)
    outer = mesh.boundary_faces
    assert total == pytest.approx(mesh.face_measures[outer] @ v[outer], abs=1e-11)


def test_divergence_is_the_adjoint_of_the_pressure_difference(mesh):
    """Σ_c V p div v = Σ_f l v (p_first - p_second), with zero pressure outside."""
    rng = np.random.default_rng(14)
    v, p = rng.standard_normal(len(mesh.faces)), rng.standard_normal(len(mesh.cells))
    first, second = mesh.face_cells.T
    jump = p[first] - np.where(second < 0, 0, p[second])
    left = mesh.cell_measures @ (p * divergence(mesh, v))
    assert left == pytest.approx(mesh.face_measures @ (v * jump), abs=1e-10)


# --- weights, shapes of the data, orientation ---------------------------------------------------


def test_velocity_weights_give_the_velocities(mesh):
    """u = (W_1 v, … W_d v) with sparse matrices; their transposes satisfy the adjoint identity."""
    d = mesh.points.shape[1]
    rng = np.random.default_rng(15)
    v, f = rng.standard_normal(len(mesh.faces)), rng.standard_normal((len(mesh.points), d))
    for weight in (None, inverse_square(0.1)):
        w = velocity_weights(mesh, weight)
        u = values(mesh, v, weight)
        assert_close(np.stack([m @ v for m in w], axis=1), u, 1e-12)
        assert all(m.shape == (len(mesh.points), len(mesh.faces)) for m in w)
        work = sum((m.T @ f[:, k]) @ v for k, m in enumerate(w))
        assert work == pytest.approx((f * u).sum(), abs=1e-9)


def test_velocity_weights_reproduce_affine_fields(mesh):
    """Σ_a W_k,ia n_a,l p_a^α = δ_kl x_i^α for |α| ≤ 1: affine exactness as an identity for W."""
    d = mesh.points.shape[1]
    rows = np.concatenate(
        [mesh.face_normals[None], mesh.face_centers.T[..., None] * mesh.face_normals]
    )
    wanted = np.concatenate([np.ones((1, len(mesh.points))), mesh.points.T])
    for k, w in enumerate(velocity_weights(mesh)):
        for moment, x in zip(rows, wanted, strict=True):
            assert_close(w @ moment, x[:, None] * np.eye(d)[k], EXACT)


def test_the_columns_of_each_row_of_the_weights_increase(mesh):
    for w in velocity_weights(mesh):
        begins = np.zeros(w.nnz, dtype=bool)
        begins[w.indptr[:-1][np.diff(w.indptr) > 0]] = True
        assert (begins[1:] | (np.diff(w.indices) > 0)).all()


def test_errors_of_the_data_are_amplified_at_most_tenfold(mesh):
    """The rows of the weights have a norm of at most ten, which is the criterion for the rings."""
    for w in velocity_weights(mesh):
        assert np.sqrt((w.multiply(w)).sum(axis=1)).max() <= WELL_DETERMINED


def test_data_may_have_several_axes_and_be_complex():
    """The axes of the data are kept; the components come last."""
    mesh = MESHES["random 3-D"]
    rng = np.random.default_rng(16)
    u = rng.standard_normal((len(mesh.points), 2, 4, 3)) + 1j
    v = normal_velocities(mesh, u)
    assert v.shape == (len(mesh.faces), 2, 4)
    assert_close(v[:, 1, 2], normal_velocities(mesh, u[:, 1, 2]), 1e-14)
    found = vertex_velocities(mesh, v).values
    assert found.shape == u.shape
    assert_close(found[:, 1, 2], values(mesh, v[:, 1, 2]), EXACT)
    div = divergence(mesh, v)
    assert_close(div[:, 0, 3], divergence(mesh, v[:, 0, 3]), 1e-9)


def test_velocities_do_not_depend_on_the_order_of_the_cells(mesh):
    """If the first cell of a face changes, its normal and v change sign; the velocities do not."""
    reordered = SimplexMesh(mesh.points, mesh.cells[::-1])
    assert (reordered.faces == mesh.faces).all()
    sign = (reordered.face_normals * mesh.face_normals).sum(axis=1).round()
    assert set(sign) == {-1.0, 1.0}
    v = np.random.default_rng(17).standard_normal(len(mesh.faces))
    assert_close(values(reordered, sign * v), values(mesh, v), 1e-9)
    assert_close(
        divergence(reordered, sign * v)[::-1] * mesh.cell_measures,
        divergence(mesh, v) * mesh.cell_measures,
        1e-12,
    )


def test_velocities_have_the_order_of_the_requested_vertices(mesh):
    """A vertex may be requested twice."""
    v = np.random.default_rng(18).standard_normal(len(mesh.faces))
    some = np.array([5, 3, 3, 90])
    all_of_them, found = vertex_velocities(mesh, v), vertex_velocities(mesh, v, vertices=some)
    assert_close(found.values, all_of_them.values[some], 1e-11)
    assert (found.rings == all_of_them.rings[some]).all()
    assert vertex_velocities(mesh, v, vertices=[]).values.shape == (0, mesh.points.shape[1])


def test_unreferenced_points_are_refused_only_if_requested():
    """A mesh may have such points, but there are no data about them."""
    mesh = MESHES["jittered 2-D"]
    more = SimplexMesh(np.vstack([[[9.0, 9.0]], mesh.points]), mesh.cells + 1)
    u = affine(mesh, 0)(more.points)
    v = normal_velocities(more, u)
    with pytest.raises(np.linalg.LinAlgError, match="point 0 belongs to no cell"):
        vertex_velocities(more, v)
    some = np.flatnonzero(more.referenced)
    assert_close(vertex_velocities(more, v, vertices=some).values, u[some], EXACT)


# --- refusals -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("points", "cells", "faces"),
    [
        ([[0, 0], [1, 0], [0, 1]], [[0, 1, 2]], 3),
        ([[0, 0], [1, 0], [1, 1], [0, 1]], [[0, 1, 2], [0, 2, 3]], 5),
        (np.vstack([np.zeros(3), np.eye(3)]), [[0, 1, 2, 3]], 4),
    ],
)
def test_meshes_with_too_few_faces_are_refused(points, cells, faces):
    """The message names the vertex and the number of faces."""
    mesh = SimplexMesh(points, cells)
    words = f"the {faces} faces that count about vertex 0 do not determine its velocity"
    with pytest.raises(np.linalg.LinAlgError, match=words):
        vertex_velocities(mesh, np.zeros(faces))


def test_a_weight_whose_support_contains_no_face_is_refused():
    """The search for rings ends at the support of the weight."""
    mesh = MESHES["random 2-D"]
    with pytest.raises(np.linalg.LinAlgError, match=r"the [01] faces that count about vertex"):
        vertex_velocities(mesh, np.zeros(len(mesh.faces)), wendland(3, 1, 1e-5))


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda m: normal_velocities(m, np.zeros((600, 3))), "u must have 2 components for each"),
        (lambda m: normal_velocities(m, np.zeros((5, 2))), "u must have one entry for each point"),
        (lambda m: vertex_velocities(m, np.zeros(7)), "v must have one entry for each face"),
        (lambda m: divergence(m, [np.nan] * len(m.faces)), "v must be finite"),
        (lambda m: velocity_weights(m, "near"), "weight must be a radial function"),
        (lambda m: velocity_weights(m, thin_plate_spline()), "fall with the distance"),
        (lambda m: point_velocity_weights(m, [0.5, 0.5]), r"x must have the shape \(m, 2\)"),
        (lambda m: point_velocity_weights(m, [[0.5] * 3]), "x must have 2 coordinates per point"),
        (
            lambda m: velocity_weights(m, vertices=[600]),
            "vertices must be indices of points, 0 to 599; got 600",
        ),
        (
            lambda m: velocity_weights(m, vertices=[0.5]),
            "vertices must be indices of points, shape",
        ),
    ],
)
def test_invalid_arguments_are_refused(call, words):
    """The message names the argument, what came and what was wanted."""
    with pytest.raises(ValueError, match=words):
        call(MESHES["random 2-D"])


def test_weights_may_belong_to_more_sites_than_32_bits_number():
    """The last of these sites has the number 2^31."""
    found = MatrixOfWeights(1, (2, 2**31 + 1))
    sites, there = np.array([[2**31, 5]]), np.ones((1, 2), dtype=bool)
    found(np.array([1]), Stencils(np.array([1]), np.array([0]), sites, there), np.array([[[3, 4]]]))
    (matrix,) = found.matrices()
    assert matrix[1, 2**31] == 3
    assert matrix[1, 5] == 4
    assert matrix.nnz == 2


@pytest.mark.slow
@given(
    st.integers(4, 12), st.integers(2, 3), st.integers(0, 10**6), st.sampled_from([None, 0.0, 0.3])
)
def test_small_meshes_give_the_affine_field_or_an_error(n, d, seed, epsilon):
    """Either the value is correct or the error names the vertex."""
    mesh = random_mesh(n + d, d, seed)
    u = affine(mesh, seed)(mesh.points)
    v = normal_velocities(mesh, u)
    weight = None if epsilon is None else inverse_square(epsilon)
    for i in range(len(mesh.points)):
        enough = amplification(slides_matrix(mesh, np.arange(len(mesh.faces)), i), d)
        if enough < 1e5:
            found = vertex_velocities(mesh, v, weight, vertices=[i])
            assert_close(found.values[0], u[i], 1e-6)
        elif enough > 1e11:
            with pytest.raises(np.linalg.LinAlgError, match=f"faces that count about vertex {i} "):
                vertex_velocities(mesh, v, weight, vertices=[i])
