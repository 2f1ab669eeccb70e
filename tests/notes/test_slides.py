"""Every page of the slides with mathematics: the page in a few lines of NumPy against the library.

Where a page has an error, its test implements the intended statement and names the test of
`test_errata.py` that demonstrates the error.
"""

import itertools
import re
from pathlib import Path

import numpy as np
import pytest
import test_errata

from fieldrecon.barycentric.coordinates import BarycentricCoordinates
from fieldrecon.barycentric.voronoi import VoronoiCell, voronoi_weights
from fieldrecon.datasets import synthetic as datasets
from fieldrecon.kernels.conditionally_positive_definite import thin_plate_spline
from fieldrecon.kernels.weights import inverse_square
from fieldrecon.meshes.duals import circumcentric_dual
from fieldrecon.meshes.simplex_mesh import SimplexMesh
from fieldrecon.methods.least_squares import LeastSquares, normal_equations
from fieldrecon.methods.moving_least_squares import MovingLeastSquares
from fieldrecon.methods.rbf import RBF
from fieldrecon.velocity.cells import cell_velocities
from fieldrecon.velocity.gradients import local_least_squares, vertex_gradients
from fieldrecon.velocity.vertices import normal_velocities, vertex_velocities
from laws import difference_quotient
from meshes import random_mesh, star, taylor_green
from polytopes import CUBE, PYRAMID, TETRAHEDRON, regular

TITLES_AND_READING = {1, 17, 23, 26, 38}
EPSILON = 0.3

POINTS = datasets.halton(12, 2)
VALUES = np.cos(4 * POINTS[:, 0]) + POINTS[:, 1] ** 2
B = np.column_stack([np.ones(12), POINTS])
X = np.array([0.4, 0.7])
MESH = random_mesh(60, 2, 11)
TETRAHEDRA = random_mesh(60, 3, 12)


def close(a, b, tolerance=1e-10):
    np.testing.assert_allclose(a, b, rtol=0, atol=tolerance)


def test_every_page_with_mathematics_has_a_test():
    """These are pages 2 to 46 except titles and reading lists.

    Every erratum that a docstring names must exist.
    """
    pages = [int(name[10:12]) for name in globals() if name.startswith("test_page_")]
    assert sorted(pages) == sorted(set(range(2, 47)) - TITLES_AND_READING)
    named = set(re.findall(r"test_errata\.(test_\w+)", Path(__file__).read_text("utf-8")))
    assert len(named) > 10
    assert all(hasattr(test_errata, name) for name in named)


# --- least squares -------------------------------------------------------------------------------


def test_page_02_a_field_from_samples():
    """f(p_i) = φ_i holds for radial basis functions only.

    See test_errata.test_only_radial_basis_functions_interpolate.
    """
    close(RBF(POINTS, thin_plate_spline()).field(VALUES)(POINTS), VALUES)


def test_page_03_the_linear_basis():
    """f(x) = b(x)ᵀ c with b(x) = (1, x_1 ... x_D)."""
    method = LeastSquares(POINTS)
    close(method.field(VALUES)(X), np.array([1, *X]) @ method.coefficients(VALUES))


def test_page_04_the_matrix_of_all_equations():
    """The rows of B are b(p_i)ᵀ. For affine data B c = V the coefficients c are reproduced."""
    c = np.array([1.0, -2.0, 3.0])
    close(LeastSquares(POINTS).coefficients(B @ c), c)


def test_page_05_the_normal_equations():
    """c = (BᵀB)⁻¹BᵀV.

    B must have full column rank: test_errata.test_normal_equations_need_full_column_rank.
    """
    c = np.linalg.inv(B.T @ B) @ B.T @ VALUES
    close(LeastSquares(POINTS).matrix(), B.T @ B)
    close(normal_equations(POINTS, VALUES), c)
    close(LeastSquares(POINTS).coefficients(VALUES), c)


def test_page_06_the_minimized_function():
    """ψ = ½‖Bc - V‖².

    On the printed formula see test_errata.test_the_minimized_function_is_half_the_squared_norm.
    """
    method = LeastSquares(POINTS)
    c = method.coefficients(VALUES)

    def psi(c):
        return np.sum((B @ c - VALUES) ** 2) / 2

    assert float(method.objective(VALUES)) == pytest.approx(psi(c))
    assert all(psi(c + h) > psi(c) for h in np.random.default_rng(1).normal(size=(20, 3)))


def test_page_07_the_first_order_condition():
    """Bᵀ(Bc - V) = 0 at the solution."""
    close(B.T @ (B @ LeastSquares(POINTS).coefficients(VALUES) - VALUES), np.zeros(3))


# --- moving least squares ------------------------------------------------------------------------


def weights(x, epsilon=EPSILON):
    return 1 / (((x - POINTS) ** 2).sum(axis=1) + epsilon**2)


def moving(x):
    """The value of p. 8-10, by `lstsq` on the scaled equations."""
    w = weights(x)
    return np.array([1, *x]) @ np.linalg.lstsq(w[:, None] * B, w * VALUES)[0]


METHOD = MovingLeastSquares(POINTS, inverse_square(EPSILON))


def test_page_08_each_equation_is_scaled():
    """w_i b(p_i)ᵀ c = w_i φ_i in the sense of least squares."""
    close(METHOD.field(VALUES)(X), moving(X))


def test_page_09_the_weight():
    """w(r) = 1/(r² + ε²).

    On the advice for ε see test_errata.test_bumps_occur_with_either_basis.
    """
    r = np.linspace(0, 2, 9)
    close(inverse_square(EPSILON)(r), 1 / (r**2 + EPSILON**2))


def test_page_10_the_weighted_normal_equations():
    """H = BᵀW²B and f = bᵀH⁻¹BᵀW²V.

    W enters squared: test_errata.test_the_weights_enter_squared.
    """
    w = np.diag(weights(X))
    h = B.T @ w @ w @ B
    close(METHOD.matrix(X), h, 1e-8)
    a = np.array([1, *X]) @ np.linalg.solve(h, B.T @ w @ w)
    close(METHOD.weights(X)[0], a)
    close(METHOD.field(VALUES)(X), a @ VALUES)


# --- radial basis functions ----------------------------------------------------------------------


def thin_plate(y):
    """w of p. 11, with the limit of test_errata.test_the_thin_plate_kernel_is_a_limit_at_zero."""
    s = (y**2).sum(axis=-1)
    return s * np.log(np.where(s > 0, s, 1.0))


def test_page_11_a_sum_of_basis_functions_and_a_polynomial():
    """f(x) = b(x)ᵀc + Σ λ_j w(x - p_j), w = ‖y‖² log ‖y‖²."""
    method = RBF(POINTS, thin_plate_spline())
    lam, c = method.coefficients(VALUES)
    close(method.field(VALUES)(X), np.array([1, *X]) @ c + lam @ thin_plate(X - POINTS))


def test_page_12_the_constraints():
    """f(p_i) = φ_i, and Σ λ_j b(p_j) = 0.

    On the multipliers see test_errata.test_the_multipliers_are_the_polynomial_coefficients.
    """
    lam, c = RBF(POINTS, thin_plate_spline()).coefficients(VALUES)
    close(B @ c + thin_plate(POINTS[:, None] - POINTS) @ lam, VALUES)
    close(B.T @ lam, np.zeros(3))


def bordered(points):
    a = thin_plate(points[:, None] - points)
    p = np.column_stack([np.ones(len(points)), points])
    return np.block([[a, p], [p.T, np.zeros((p.shape[1],) * 2)]])


def test_page_13_the_system():
    """H (λ, c) = (φ, 0), in space.

    Both statements about H on this page are wrong: test_errata.test_the_rbf_matrix_is_indefinite
    and test_errata.test_the_rbf_system_is_singular_for_points_on_a_line.
    """
    points = datasets.halton(15, 3)
    values = np.sin(points.sum(axis=1))
    solution = np.linalg.solve(bordered(points), [*values, 0, 0, 0, 0])
    method = RBF(points, thin_plate_spline())
    close(method.matrix(), bordered(points))
    close(np.concatenate(method.coefficients(values)), solution)


# --- meshes --------------------------------------------------------------------------------------


@pytest.mark.parametrize("mesh", [MESH, TETRAHEDRA], ids=["2-D", "3-D"])
def test_page_14_locations_of_velocities_and_pressures(mesh):
    """v = n·u at face centres, and p at circumcentres, which are equidistant from the vertices.

    Circumcentres need not lie in their cells:
    test_errata.test_a_circumcentre_may_lie_outside_its_triangle.
    """
    p, e = mesh.points[mesh.faces], np.diff(mesh.points[mesh.faces], axis=1)
    close(np.einsum("fkd,fd->fk", e, mesh.face_normals), 0)
    gradient = np.arange(mesh.points.shape[1] ** 2).reshape(-1, mesh.points.shape[1])
    u = p.mean(axis=1) @ gradient
    v = (mesh.face_normals * u).sum(axis=1)
    close(normal_velocities(mesh, mesh.points @ gradient), v)
    r = np.linalg.norm(mesh.points[mesh.cells] - mesh.circumcenters[:, None], axis=2)
    np.testing.assert_allclose(r, r[:, :1].repeat(r.shape[1], axis=1), rtol=1e-9)


def test_page_15_the_neighbourhood_of_a_vertex():
    """An interior vertex of a plane mesh has N triangles and N edges.

    On other vertices see test_errata.test_numbers_of_faces_and_edges_at_a_vertex_of_n_cells.
    """
    mesh = star(6, 13)
    assert len(mesh.vertex_cells(0)) == 6
    assert mesh.vertex_face_incidence[[0]].nnz == 6


def test_page_16_pressure_gradients_at_vertices():
    """∇p(x_i) is the gradient of a least-squares fit to the values of the surrounding cells."""
    values = np.sin(3 * MESH.circumcenters[:, 0]) + MESH.circumcenters[:, 1] ** 2
    i = int(np.flatnonzero(~MESH.boundary_vertices)[0])
    cells = MESH.vertex_cells(i)
    c = LeastSquares(MESH.circumcenters[cells]).coefficients(values[cells])
    found = vertex_gradients(MESH, values, local_least_squares(), vertices=[i])
    close(found[0], c[1:], 1e-9)


# --- velocities at vertices ----------------------------------------------------------------------

INSIDE = np.flatnonzero(~MESH.boundary_vertices & (np.diff(MESH.vertex_cell_incidence.indptr) >= 5))
FACES = MESH.faces_around(1, [INSIDE[0]]).indices
P, N = MESH.face_centers[FACES], MESH.face_normals[FACES]
V = normal_velocities(MESH, taylor_green(MESH.points))
FOUND = vertex_velocities(MESH, V, inverse_square(EPSILON), [INSIDE[0]]).values[0]
W = 1 / (((P - MESH.points[INSIDE[0]]) ** 2).sum(axis=1) + EPSILON**2)
B_EDGES = np.column_stack([np.ones(len(P)), P])


def vertex_fit(b):
    return np.linalg.lstsq(W[:, None] * b, W * V[FACES])[0]


def test_page_18_an_affine_velocity():
    """u(x) = c_0 + Σ x_j c_j with n_k · u(p_k) = v_k: affine velocities are reproduced."""
    c = np.array([[1.0, 2.0], [3.0, -1.0], [0.5, 4.0]])

    def u(x):
        return c[0] + x @ c[1:]

    v = (u(MESH.face_centers) * MESH.face_normals).sum(axis=1)
    close(vertex_velocities(MESH, v).values, u(MESH.points), 1e-9)


def test_page_19_reverse_thinking():
    """With full velocities at the edges, B c_x = V_x and B c_y = V_y are two separate fits."""
    u = taylor_green(P)
    whole = LeastSquares(P).coefficients(u)
    close(whole, np.stack([np.linalg.lstsq(B_EDGES, u[:, k])[0] for k in (0, 1)], axis=1))


def test_page_20_both_components_at_once():
    """diag(B, B) (c_x, c_y) = (V_x, V_y) is equivalent to the two separate fits."""
    u, zero = taylor_green(P), np.zeros_like(B_EDGES)
    c = np.linalg.lstsq(np.block([[B_EDGES, zero], [zero, B_EDGES]]), u.T.ravel())[0]
    close(LeastSquares(P).coefficients(u), c.reshape(2, 3).T)


def test_page_21_projected_onto_normals():
    """B' = (N_x B, N_y B), V' = N_x V_x + N_y V_y.

    p. 22 has another B': test_errata.test_the_velocity_matrix_has_two_orders_of_columns.
    """
    nx, ny = np.diag(N[:, 0]), np.diag(N[:, 1])
    c = vertex_fit(np.hstack([nx @ B_EDGES, ny @ B_EDGES])).reshape(2, 3)
    close(FOUND, c @ [1, *MESH.points[INSIDE[0]]], 1e-9)


def test_page_22_the_fit_at_a_vertex():
    """W B'c = W V' with the rows (nᵀ, x nᵀ, y nᵀ), and u(x_i) = c_0 + x c_1 + y c_2.

    The edges at the vertex alone do not suffice: test_errata.test_edges_at_a_vertex_do_not_suffice.
    """
    c = vertex_fit(np.hstack([N, P[:, :1] * N, P[:, 1:] * N])).reshape(3, 2)
    close(FOUND, np.array([1, *MESH.points[INSIDE[0]]]) @ c, 1e-9)


# --- velocities of cells -------------------------------------------------------------------------


def outward(mesh, cell):
    return mesh.face_normals[mesh.cell_faces[cell]] * mesh.cell_face_signs[cell][:, None]


@pytest.mark.parametrize("mesh", [MESH, TETRAHEDRA], ids=["2-D", "3-D"])
def test_page_24_a_constant_velocity_has_these_normal_components(mesh):
    """n_iᵀu = v_i with outward unit normals: constant fields are reproduced in every cell."""
    u = np.arange(1.0, 1 + mesh.points.shape[1])
    for cell in range(3):
        to_face = mesh.face_centers[mesh.cell_faces[cell]] - mesh.cell_centers[cell]
        assert np.all((outward(mesh, cell) * to_face).sum(axis=1) > 0)
    close(cell_velocities(mesh, mesh.face_normals @ u).values, np.tile(u, (len(mesh.cells), 1)))


@pytest.mark.parametrize("mesh", [MESH, TETRAHEDRA], ids=["2-D", "3-D"])
def test_page_25_the_least_squares_velocity_of_a_cell(mesh):
    """B c = V in the sense of least squares, where the rows of B are the three or four normals."""
    v = np.random.default_rng(14).normal(size=len(mesh.faces))
    found = cell_velocities(mesh, v)
    for cell in range(0, len(mesh.cells), 7):
        b, right = outward(mesh, cell), v[mesh.cell_faces[cell]] * mesh.cell_face_signs[cell]
        c, residual, _, _ = np.linalg.lstsq(b, right)
        close(found.values[cell], c, 1e-8)
        assert found.defect[cell] == pytest.approx(residual[0] ** 0.5)


# --- convex polytopes ----------------------------------------------------------------------------


def polytope(corners):
    """Unit outward normals and the faces at each corner, from all planes through d corners."""
    d = corners.shape[1]
    faces = {}
    for some in itertools.combinations(range(len(corners)), d):
        edges = corners[list(some[1:])] - corners[some[0]]
        n = np.linalg.svd(edges)[2][-1]
        h = (corners - corners[some[0]]) @ n
        n = n if h.max() < 1e-9 else -n
        if min(h.max(), -h.min()) < 1e-9:
            faces[tuple(np.flatnonzero(np.abs(h) < 1e-9))] = n  # the corners identify the face
    normals = np.array(list(faces.values()))
    height = normals @ corners.T
    on = np.abs(height - height.max(axis=1, keepdims=True)) < 1e-9
    return normals, [np.flatnonzero(column) for column in on.T]


def w(corners, x):
    """p. 29-30: |det(n_a ...)| / Π n_aᵀ(p_i - x), for simple polytopes."""
    normals, at = polytope(corners)
    return np.array(
        [
            abs(np.linalg.det(normals[a])) / np.prod(normals[a] @ (p - x))
            for a, p in zip(at, corners, strict=True)
        ]
    )


PENTAGON = np.array([[0, 0], [4, 0], [5, 3], [2, 5], [-1, 3]]) / 4.0


def test_page_27_the_convex_hull_of_the_points():
    """The hull is bounded by faces with outward normals.

    On the points see test_errata.test_affinely_independent_points_make_simplices_only.
    """
    for corners, faces in ((PENTAGON, 5), (CUBE, 6), (TETRAHEDRON, 4)):
        normals, _ = polytope(corners)
        assert len(normals) == faces
        middle = corners.mean(axis=0)
        assert np.all((normals @ (corners - middle).T).max(axis=1) > 0)
        close(BarycentricCoordinates(corners).weights(middle)[0] @ corners, middle)


def test_page_28_which_polytopes_are_simple():
    """Polygons and tetrahedra are simple. A pyramid is not: its apex has four faces.

    On polygons see test_errata.test_a_point_within_an_edge_has_no_coordinate.
    """
    count = [[len(a) for a in polytope(c)[1]] for c in (PENTAGON, TETRAHEDRON, PYRAMID)]
    assert count == [[2] * 5, [3] * 4, [3, 3, 3, 3, 4]]


@pytest.mark.parametrize("corners", [PENTAGON, TETRAHEDRON, CUBE], ids=["2-D", "simplex", "cube"])
def test_page_29_the_weight_function(corners):
    """w_i = vol / Π n_aᵀ(p_i - x) is proportional to the weights of the library.

    On the boundary see test_errata.test_the_quotient_has_no_value_on_the_boundary.
    """
    x = np.average(corners, axis=0, weights=np.arange(1, 1 + len(corners)))
    quotient = w(corners, x) / BarycentricCoordinates(corners).weights(x)[0]
    np.testing.assert_allclose(quotient, quotient[0], rtol=1e-9)


def test_page_30_the_volume_of_the_normals():
    """vol = |det(n_a, n_b)|, the sine of the angle at the corner.

    On the printed formula see test_errata.test_the_volume_of_the_normals_is_an_absolute_value.
    """
    normals, at = polytope(PENTAGON)
    sides = np.roll(PENTAGON, -1, axis=0) - PENTAGON, np.roll(PENTAGON, 1, axis=0) - PENTAGON
    s, t = (side / np.linalg.norm(side, axis=1)[:, None] for side in sides)
    sine = np.abs(s[:, 0] * t[:, 1] - s[:, 1] * t[:, 0])
    close([abs(np.linalg.det(normals[a])) for a in at], sine)


def cut(corners, delta):
    """Corners of the simple polytope in which a face of each non-simple corner is shifted by δ."""
    normals, at = polytope(corners)
    offset = (normals @ corners.T).max(axis=1)
    crowded = [a for a in at if len(a) > 3]
    shifted = {int(min(a, key=lambda k: normals[k][0] + 0.3 * normals[k][1])) for a in crowded}
    offset[list(shifted)] += delta
    found = {}
    for three in itertools.combinations(range(len(normals)), 3):
        if abs(np.linalg.det(normals[list(three)])) > 1e-9:
            p = np.linalg.solve(normals[list(three)], offset[list(three)])
            if np.all(normals @ p <= offset + 1e-12):
                found[tuple(p.round(9))] = p
    return np.array(list(found.values()))


def test_page_31_normalization_and_split_corners():
    """ω_i = w_i / Σ w_j.

    A corner of four faces has the sum of the weights of its perturbed corners. On points outside
    see test_errata.test_outside_the_coordinates_change_sign_and_have_a_pole.
    """
    x = np.array([0.6, 0.5])
    close(BarycentricCoordinates(PENTAGON).weights(x)[0], w(PENTAGON, x) / w(PENTAGON, x).sum())
    x = np.array([0.1, 0.2, 0.7])
    whole = BarycentricCoordinates(PYRAMID).weights(x)[0]
    error = []
    for delta in (1e-2, 1e-4):
        split = cut(PYRAMID, delta)
        assert len(split) == 6
        omega = w(split, x) / w(split, x).sum()
        owner = ((split[:, None] - PYRAMID) ** 2).sum(axis=2).argmin(axis=1)
        error.append(np.abs(np.bincount(owner, omega) - whole).max())
    assert error[1] < 0.02 * error[0] < 0.02 * 0.1


# --- Voronoi cells -------------------------------------------------------------------------------


def test_page_32_dual_cells_of_a_delaunay_mesh():
    """Dual edges are normal to primal edges, and dual cells are convex.

    On boundary cells see test_errata.test_voronoi_cells_on_the_boundary_are_open.
    """
    for mesh in (MESH, TETRAHEDRA):
        segments, faces = circumcentric_dual(mesh)
        along = np.diff(mesh.points[mesh.faces[faces]], axis=1)
        across = segments[:, 1] - segments[:, 0]
        size = np.abs(across).max(axis=1) + 1
        close(np.einsum("fkd,fd->fk", along, across) / size[:, None], 0, 1e-9)
    for i in np.flatnonzero(~MESH.boundary_vertices):
        corners = MESH.circumcenters[MESH.vertex_cells(i)]
        middle = MESH.cell_centers[MESH.vertex_cells(i)] - MESH.points[i]
        ordered = corners[np.argsort(np.arctan2(middle[:, 1], middle[:, 0]))]
        e, f = np.roll(ordered, -1, 0) - ordered, np.roll(ordered, -2, 0) - np.roll(ordered, -1, 0)
        assert (e[:, 0] * f[:, 1] - e[:, 1] * f[:, 0]).min() > -1e-12


@pytest.mark.parametrize("mesh", [MESH, TETRAHEDRA], ids=["2-D", "3-D"])
def test_page_33_the_corners_of_a_voronoi_cell(mesh):
    """They are the circumcentres of the cells at the vertex, and no other vertex is closer to them.

    They need not be simple: test_errata.test_a_voronoi_cell_need_not_be_simple.
    """
    i = int(np.flatnonzero(~mesh.boundary_vertices)[0])
    cell = VoronoiCell(mesh, i)
    assert sorted(np.concatenate(cell.cells)) == mesh.vertex_cells(i).tolist()
    close(cell.points, mesh.circumcenters[np.concatenate(cell.cells)])
    distance = np.linalg.norm(cell.points[:, None] - mesh.points, axis=2)
    close(distance[:, i], distance.min(axis=1))


def test_page_34_each_corner_belongs_to_a_triangle_ijk():
    """The two faces at the corner lie on the bisectors of x_i x_j and x_i x_k."""
    i = int(INSIDE[0])
    cell = VoronoiCell(MESH, i)
    center = MESH.points[i]
    for p, (triangle,) in zip(cell.points, cell.cells, strict=True):
        for b in MESH.points[MESH.cells[triangle][MESH.cells[triangle] != i]]:
            close((p - (center + b) / 2) @ (b - center), 0)


def cells_at(mesh):
    """For each cell at an interior vertex x_i: x_i, other vertices, circumcentre, measure."""
    i = int(np.flatnonzero(~mesh.boundary_vertices)[0])
    for a in mesh.vertex_cells(i):
        others = mesh.cells[a][mesh.cells[a] != i]
        yield mesh.points[i], mesh.points[others], mesh.circumcenters[a], mesh.cell_measures[a]


def test_page_35_the_volume_of_the_normals_of_a_voronoi_corner():
    """vol = 2A / (l_ki l_ji), and Π n_bᵀ(p_a - x) = Π (x_b - x_i)ᵀ(p_a - x) / l_bi."""
    for center, others, p, area in cells_at(MESH):
        edges = others - center
        length = np.linalg.norm(edges, axis=1)
        n = edges / length[:, None]
        assert abs(np.linalg.det(n)) == pytest.approx(2 * area / length.prod())
        x = center + 0.01
        assert np.prod(n @ (p - x)) == pytest.approx(np.prod(edges @ (p - x) / length))


def simplified(mesh, x, factor):
    """w_a = D! V_a / Π (x_b - x_i)ᵀ(p_a - x), normalized: p. 36 and 37."""
    w = [factor * m / np.prod((b - center) @ (p - x)) for center, b, p, m in cells_at(mesh)]
    return np.array(w) / np.sum(w)


def simplified_weights_agree(mesh, factor):
    i = int(np.flatnonzero(~mesh.boundary_vertices)[0])
    x = mesh.points[i] + 0.02
    h = voronoi_weights(mesh, i, x).toarray()[0, mesh.vertex_cells(i)]
    close(h, simplified(mesh, x, factor), 1e-9)


def test_page_36_the_weights_in_the_plane():
    """w_a = 2A / Π (x_b - x_i)ᵀ(p_a - x)."""
    simplified_weights_agree(MESH, 2)


def test_page_37_the_weights_in_space():
    """w_a = 6V / Π (x_b - x_i)ᵀ(p_a - x)."""
    simplified_weights_agree(TETRAHEDRA, 6)


# --- exercises -----------------------------------------------------------------------------------


def test_page_39_least_squares():
    """B is N by D + 1 and must have full column rank; the gradient is (c_1 ... c_D) everywhere."""
    method = LeastSquares(POINTS)
    assert method.matrix().shape == (3, 3)
    close(method.field(VALUES).gradient([X, -X]), np.tile(method.coefficients(VALUES)[1:], (2, 1)))
    with pytest.raises(np.linalg.LinAlgError):
        LeastSquares(np.outer(POINTS[:, 0], [1.0, 2.0]))


def test_page_40_moving_least_squares():
    """The minimum of ψ, the size of H, and the full gradient with derivatives of the coefficients.

    On the hint see test_errata.test_psi_always_prefers_an_infinite_epsilon.
    """
    w = weights(X)
    c, residual, _, _ = np.linalg.lstsq(w[:, None] * B, w * VALUES)
    assert METHOD.matrix(X).shape == (3, 3)
    assert float(METHOD.objective(VALUES, X)) == pytest.approx(residual[0] / 2)
    a = np.array([1, *X]) @ np.linalg.pinv(w[:, None] * B) * w
    gradient = c[1:] - 4 * (a * w * (VALUES - B @ c)) @ (X - POINTS)
    close(METHOD.field(VALUES).gradient(X), gradient)
    close(difference_quotient(np.vectorize(moving, signature="(d)->()"), X, 1e-2), gradient, 1e-6)
    assert np.abs(gradient - c[1:]).max() > 1e-2


def test_page_41_radial_basis_functions():
    """H has N + D + 1 rows; ∇f = (c_1 ... c_D) + Σ 2λ_j (x - p_j)(1 + log ‖x - p_j‖²)."""
    method = RBF(POINTS, thin_plate_spline())
    lam, c = method.coefficients(VALUES)
    assert method.matrix().shape == (15, 15)
    y = X - POINTS
    gradient = c[1:] + 2 * (lam * (1 + np.log((y**2).sum(axis=1)))) @ y
    close(method.field(VALUES).gradient(X), gradient, 1e-9)


def test_page_42_conditions_on_the_normals():
    """B' is rank-deficient for parallel normals, and if an affine field is tangent to all edges.

    On the edges of a patch see test_errata.test_vertices_on_a_conic_reduce_the_rank_of_a_patch.
    """

    def rank(n):
        return np.linalg.matrix_rank(np.hstack([n, P[:, :1] * n, P[:, 1:] * n]))

    assert np.linalg.matrix_rank(B_EDGES) == 3
    assert rank(N) == 6
    assert rank(np.tile([0.6, 0.8], (len(P), 1))) == 3
    assert rank(P - X) == 5  # normal to the rotation about a point


def test_page_43_a_rotation_at_the_vertices():
    """u = J(x - m) is affine, so v_a = n·(u_i + u_j)/2 = n·u(midpoint), and u is reproduced.

    On the printed formula see test_errata.test_the_field_of_the_exercise_rotates_about_the_mean; on
    one ring see test_errata.test_least_norm_silently_fails_for_a_rotation.
    """

    def u(x):
        y = x - MESH.points.mean(axis=0)
        return np.stack([-y[:, 1], y[:, 0]], axis=1)

    v = normal_velocities(MESH, u(MESH.points))
    close(v, (MESH.face_normals * u(MESH.face_centers)).sum(axis=1))
    close(vertex_velocities(MESH, v).values, u(MESH.points))


def test_page_44_a_rotation_in_the_cells():
    """A rotation is reproduced at circumcentres only; the divergence does not affect the velocity.

    On other fields see test_errata.test_cell_velocities_belong_to_circumcentres_in_rotations.
    """

    def rotated(x):
        return np.stack([-x[:, 1], x[:, 0]], axis=1)

    v = normal_velocities(MESH, rotated(MESH.points))
    u = cell_velocities(MESH, v).values
    close(u, rotated(MESH.circumcenters), 1e-8)
    assert np.abs(u - rotated(MESH.cell_centers)).max() > 1e-2
    one = SimplexMesh(MESH.points[MESH.cells[0]], [[0, 1, 2]])
    v = np.array([1.0, -2.0, 0.5])
    out = (one.face_measures @ v) / np.sum(one.face_measures**2)  # boundary normals point out
    close(cell_velocities(one, v).values, cell_velocities(one, v - out * one.face_measures).values)


def test_page_45_the_spiral_in_a_hexagon():
    """Constant and linear fields are reproduced at x_i + s_n, n = 1 ... 50.

    On the printed points see test_errata.test_the_spiral_begins_at_the_centre_of_the_cell.
    """
    center = np.array([0.25, -0.5])
    points = np.vstack([regular(6) + center, center])
    mesh = SimplexMesh(points, [[6, k, (k + 1) % 6] for k in range(6)])
    p = mesh.circumcenters
    n = np.arange(1, 51)
    angle, r = 2 * np.pi / 50 * n, np.linalg.norm((p[0] + p[1]) / 2 - center)
    s = center + (r / n)[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    cell = VoronoiCell(mesh, 6)
    close(cell.field(np.ones(6))(s), 1)
    close(cell.field(cell.points.sum(axis=1))(s), s.sum(axis=1))
    assert cell.weights(s).min() > 0


def test_page_46_the_weights_in_space_are_the_general_ones():
    """p. 37 agrees with p. 29-31 on the Voronoi cell; the normals are computed from its corners."""
    i = int(np.flatnonzero(~TETRAHEDRA.boundary_vertices)[0])
    corners = TETRAHEDRA.circumcenters[TETRAHEDRA.vertex_cells(i)]
    x = TETRAHEDRA.points[i] + 0.02
    general = w(corners, x)
    close(simplified(TETRAHEDRA, x, 6), general / general.sum(), 1e-6)
