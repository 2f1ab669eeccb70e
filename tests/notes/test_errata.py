"""Errors and omissions of the slides: a counterexample to each, and the correct statement.

The headings give the pages. Each counterexample evaluates the printed formula, mostly in rational
numbers; the correct statement is then tested on the library as well. The chapter Errata
of the report names every test of this file, and no other.
"""

import itertools
import math
import re
from fractions import Fraction as F

import numpy as np
import pytest

from fieldrecon.barycentric.coordinates import BarycentricCoordinates
from fieldrecon.barycentric.voronoi import VoronoiCell
from fieldrecon.datasets import synthetic as datasets
from fieldrecon.kernels.conditionally_positive_definite import polyharmonic, thin_plate_spline
from fieldrecon.kernels.weights import inverse_square
from fieldrecon.meshes.duals import circumcentric_dual
from fieldrecon.meshes.simplex_mesh import SimplexMesh
from fieldrecon.methods.least_squares import LeastSquares
from fieldrecon.methods.moving_least_squares import MovingLeastSquares
from fieldrecon.methods.rbf import RBF
from fieldrecon.selection.leaving_one_out import leave_one_out
from fieldrecon.velocity.cells import cell_velocities, raviart_thomas
from fieldrecon.velocity.vertices import normal_velocities, vertex_velocities
from polytopes import regular
from rational import (
    circumcentre,
    determinant,
    dot,
    inverse,
    least_squares,
    minus,
    product,
    rank,
    rational,
    solved,
    times,
    transposed,
)
from report_fixtures import REPORT

ROUNDING = 1e-12
ERRATA = REPORT / "chapters" / "22-errata.md"


def test_the_chapter_names_every_test_and_no_other():
    """A claim is in the chapter if and only if a test here demonstrates it."""
    here = {name for name in globals() if name.startswith("test_")}
    here.remove("test_the_chapter_names_every_test_and_no_other")
    named = re.findall(r"`(test_\w+)`", ERRATA.read_text("utf-8"))
    assert sorted(named) == sorted(here)


# --- least squares and moving least squares, p. 2-10 ---------------------------------------------


def linear_basis(points):
    return [[1, *p] for p in points]


def moving(points, values, x, epsilon, degree=1, power=2):
    """f(x) of p. 8-10 in rational numbers; power=2 is the slides' W squared."""
    r2 = [dot(minus(x, p), minus(x, p)) for p in points]
    w = [(1 / (s + F(epsilon) ** 2)) ** power for s in r2]
    b = linear_basis(points) if degree else [[1] for _ in points]
    c = least_squares(b, values, w)
    return dot([1, *x] if degree else [1], c)


def test_only_radial_basis_functions_interpolate():
    """p.

    2-3, 8, 10: least squares and moving least squares approximate; for MLS the error is O(ε⁴).
    """
    points, values = [[0], [1], [2], [4]], [0, 1, 0, 1]
    c = least_squares(linear_basis(points), values)
    assert all(dot([1, *p], c) != f for p, f in zip(points, values, strict=True))
    error = [moving(points, values, [1], epsilon) - 1 for epsilon in (F(1, 100), F(1, 1000))]
    assert error[0] / error[1] == pytest.approx(10**4, rel=1e-3)
    method = MovingLeastSquares(points, inverse_square(0.01))
    assert not method.interpolates
    assert float(method.field(values)([1.0])) - 1 == pytest.approx(float(error[0]), rel=1e-6)
    assert float(LeastSquares(points).field(values)([1.0])) == pytest.approx(float(c[0] + c[1]))
    sites = datasets.halton(30, 2)
    data = np.cos(9 * sites[:, 0])
    assert abs(RBF(sites, thin_plate_spline()).field(data)(sites) - data).max() < ROUNDING


def test_normal_equations_need_full_column_rank():
    """p. 5: (BᵀB)⁻¹Bᵀ = B⁺ needs full column rank. Otherwise B⁺ exists but BᵀB has no inverse."""
    flat = linear_basis([[0, 0], [1, 1], [2, 2], [5, 5]])
    assert determinant(product(transposed(flat), flat)) == 0
    b = np.array(flat, dtype=float)
    np.testing.assert_allclose(b @ np.linalg.pinv(b) @ b, b, atol=ROUNDING)
    with pytest.raises(np.linalg.LinAlgError, match="determine"):
        LeastSquares(b[:, 1:])
    full = linear_basis([[0, 0], [1, 1], [2, 2], [5, 4]])
    x = product(inverse(product(transposed(full), full)), transposed(full))
    unit = rational(np.eye(3, dtype=int).tolist())
    assert product(x, full) == unit  # hence B X B = B and X B X = X
    assert product(full, x) == transposed(product(full, x))
    np.testing.assert_allclose(
        np.array(x, dtype=float), np.linalg.pinv(np.array(full, dtype=float)), atol=ROUNDING
    )


def test_a_deficient_pseudo_inverse_depends_on_the_origin():
    """p. 5: if B is rank-deficient, the field by B⁺ depends on the origin of the coordinates."""

    def beside_the_line(shift):
        points = np.array([[0.0, 0], [1, 1], [2, 2]]) + shift
        c = np.linalg.pinv(np.array(linear_basis(points))) @ [0, 1, 2]
        return float(np.array([1, 1 + shift[0], shift[1]]) @ c)

    here, there = beside_the_line(np.zeros(2)), beside_the_line(np.array([3.0, 0.0]))
    assert abs(here - there) > 0.1


def test_the_minimized_function_is_half_the_squared_norm():
    """p.

    6-7: ψ = ½‖ε‖² is a number. The square of the vector ε is not, and the square of the sum of its
    components has another gradient.
    """
    rng = np.random.default_rng(1)
    b = np.column_stack([np.ones(6), rng.random((6, 2))])
    v, c, step = rng.random(6), rng.random(3), 1e-6

    def slope(psi):
        return np.array([(psi(c + h) - psi(c - h)) / (2 * step) for h in step * np.eye(3)])

    printed = b.T @ (b @ c - v)
    assert ((b @ c - v) ** 2 / 2).shape == (6,)
    assert abs(slope(lambda c: np.sum(b @ c - v) ** 2 / 2) - printed).max() > 0.1
    np.testing.assert_allclose(slope(lambda c: np.sum((b @ c - v) ** 2) / 2), printed, atol=1e-8)
    points = b[:, 1:]
    least = np.linalg.lstsq(b, v)[1][0] / 2
    assert float(LeastSquares(points).objective(v)) == pytest.approx(least)


def test_the_weights_enter_squared():
    """p. 10: H = BᵀW²B weights a sample by r⁻⁴. Most of the literature uses BᵀWB, that is r⁻²."""
    points, values, x = [[0], [1], [3], [4]], [0, 2, 1, 5], [F(3, 2)]
    slides, usual = (moving(points, values, x, F(1, 2), power=power) for power in (2, 1))
    assert abs(slides - usual) > F(1, 10)
    method = MovingLeastSquares(points, inverse_square(0.5))
    assert float(method.field(values)([1.5])) == pytest.approx(float(slides), rel=ROUNDING)


@pytest.mark.parametrize("d", [2, 3])
def test_unsquared_weights_favour_distant_samples(d):
    """p.

    10: on a lattice the total weight of the shell r ≤ |p| < 2r is constant for r⁻². For r⁻⁴ it
    decreases.
    """
    axes = np.meshgrid(*[np.arange(-32, 33)] * d, indexing="ij")
    r2 = sum(axis.astype(float) ** 2 for axis in axes).ravel()
    shells = [(r2 >= r**2) & (r2 < 4 * r**2) for r in (4, 8, 16)]
    unsquared = [np.sum(1 / r2[shell]) for shell in shells]
    squared = [np.sum(1 / r2[shell] ** 2) for shell in shells]
    assert all(b > 0.95 * a for a, b in itertools.pairwise(unsquared))
    assert all(b < 0.55 * a for a, b in itertools.pairwise(squared))


def differences(values):
    """Differences of neighbouring numbers."""
    return [b - a for a, b in itertools.pairwise(values)]


@pytest.mark.slow
@pytest.mark.parametrize("degree", [0, 1])
def test_bumps_occur_with_either_basis(degree):
    """p. 9: on x³, which rises, and x², which is convex; for the linear basis ε = h is enough.

    A small ε makes the field fall somewhere (constants: nearly flat at every sample), and its
    curvature changes its sign between any two samples.
    """
    points = [[k] for k in range(8)]
    path = [F(k, 8) for k in range(57)]

    def along(power, epsilon):
        values = [p[0] ** power for p in points]
        return [moving(points, values, [x], epsilon, degree) for x in path]

    small, spacing = F(1, 10), F(1)
    flattest = [min(differences(along(3, epsilon))) for epsilon in (small, spacing)]
    bends = [differences(differences(along(2, epsilon))) for epsilon in (small, spacing)]
    changes = [sum(a * b < 0 for a, b in itertools.pairwise(bend)) for bend in bends]
    assert flattest[0] < (0 if degree else F(1, 100)) < flattest[1] + F(1, 10**6)
    assert changes[0] >= 12
    if degree:
        assert flattest[1] > 0
        assert changes[1] <= 2
    ours = MovingLeastSquares(points, inverse_square(0.1), degree).field([k**3 for k in range(8)])
    at = np.array([[float(x)] for x in path])
    np.testing.assert_allclose(ours(at), np.array(along(3, small), dtype=float), atol=1e-9)


def test_planes_cannot_show_bumps_of_the_linear_basis():
    """p. 9: affine data are reproduced for every ε, so a test of bumps needs a curved field."""
    grid = [*itertools.product(range(3), repeat=2)]
    plane = [1 + 2 * x - 3 * y for x, y in grid]
    for epsilon, x in itertools.product((F(1, 1000), F(1), F(9)), ([F(1, 3), F(8, 7)], [1, 1])):
        assert moving(grid, plane, x, epsilon) == 1 + 2 * x[0] - 3 * x[1]


def test_constants_are_flat_at_every_sample():
    """p. 9: with constants, Shepard's method, the slope at a sample is of the order of ε⁴."""
    points, h = [[k] for k in range(5)], F(1, 10**20)

    def slope(epsilon):
        values = [p[0] for p in points]
        there, back = (moving(points, values, [1 + s * h], epsilon, degree=0) for s in (1, -1))
        return (there - back) / (2 * h)

    assert slope(F(1, 100)) / slope(F(1, 1000)) == pytest.approx(10**4, rel=1e-2)
    assert slope(F(1, 100)) < F(1, 10**6)
    assert slope(F(1)) > F(1, 4)


def test_a_large_epsilon_costs_accuracy_with_the_linear_basis():
    """p. 9: between samples of a curved field the error increases with ε."""
    points = [[k] for k in range(8)]
    values = [p[0] ** 2 for p in points]
    queries = [[F(2 * k + 1, 2)] for k in range(7)]
    error = [
        sum(abs(moving(points, values, x, epsilon) - x[0] ** 2) for x in queries)
        for epsilon in (F(1, 10), F(1), F(3), F(10))
    ]
    assert error == sorted(error)
    assert error[-1] > 5 * error[0]
    ours = MovingLeastSquares(points, inverse_square(3.0)).field(values)
    at = np.array(queries, dtype=float)
    assert float(abs(ours(at) - at[:, 0] ** 2).sum()) == pytest.approx(float(error[2]))


def objective(points, values, x, epsilon):
    """The minimum of ψ_MLS(x) over c, in rational numbers."""
    w = [1 / (dot(minus(x, p), minus(x, p)) + F(epsilon) ** 2) for p in points]
    b = linear_basis(points)
    c = least_squares(b, values, [v**2 for v in w])
    return sum((v * (dot(row, c) - f)) ** 2 for v, row, f in zip(w, b, values, strict=True)) / 2


def test_psi_always_prefers_an_infinite_epsilon():
    """p. 40, hint: ψ_MLS decreases with ε for all data, and ε⁴ψ_MLS tends to ψ_LS."""
    rng = np.random.default_rng(2)
    points = rng.integers(0, 20, (9, 2)).tolist()
    basis = linear_basis(points)
    for draw in range(5):
        values = rng.integers(-9, 9, 9).tolist()
        x = rng.integers(0, 20, 2).tolist()
        steps = [objective(points, values, x, F(2) ** k) for k in range(-4, 12)]
        assert all(b < a for a, b in itertools.pairwise(steps)), draw
        c = least_squares(basis, values)
        least = sum((dot(row, c) - f) ** 2 for row, f in zip(basis, values, strict=True)) / 2
        assert steps[-1] * F(2) ** 44 == pytest.approx(float(least), rel=1e-3)
        ours = MovingLeastSquares(points, inverse_square(4.0)).objective(values, x)
        assert float(ours) == pytest.approx(float(steps[6]), rel=1e-10)


def test_leave_one_out_selects_epsilon_and_psi_does_not():
    """p.

    40, hint: for exact data leave-one-out selects a small ε; ψ selects one with ten times the
    error.
    """
    points, queries = datasets.halton(80, 2), 0.2 + 0.6 * datasets.halton(60, 2)
    field = datasets.power_of_sum(3)
    choices = 10.0 ** np.arange(-3, 3)
    methods = [MovingLeastSquares(points, inverse_square(epsilon)) for epsilon in choices]
    psi = [m.objective(field(points), queries).mean() for m in methods]
    left_out = [np.mean(leave_one_out(m, field(points)) ** 2) for m in methods]
    error = [np.abs(m.field(field(points))(queries) - field(queries)).mean() for m in methods]
    assert np.argmin(psi) == len(choices) - 1
    assert error[np.argmin(left_out)] < 1.1 * min(error)
    assert error[np.argmin(psi)] > 10 * min(error)


# --- radial basis functions, p. 11-13 ------------------------------------------------------------


def thin_plate(r2):
    """w of p. 11, with its limit at zero."""
    r2 = np.asarray(r2, dtype=float)
    return r2 * np.log(np.where(r2 > 0, r2, 1.0))


def slides_matrix(points):
    """H_RBF of p. 13."""
    points = np.asarray(points, dtype=float)
    a = thin_plate(((points[:, None] - points) ** 2).sum(axis=2))
    p = np.column_stack([np.ones(len(points)), points])
    return np.block([[a, p], [p.T, np.zeros((p.shape[1],) * 2)]]), p


def test_the_thin_plate_kernel_is_a_limit_at_zero():
    """p. 11: ‖y‖² log ‖y‖² is 0 · ∞ at y = 0, the diagonal of H. Its limit there is zero."""
    with np.errstate(divide="ignore", invalid="ignore"):
        assert np.isnan(np.float64(0) * np.log(np.float64(0)))
    assert abs(1e-20 * math.log(1e-20)) < 1e-18
    assert float(thin_plate_spline()(0.0)) == 0
    np.testing.assert_allclose(thin_plate_spline()([0.5, 2.0]), thin_plate([0.25, 4.0]))


def laplacian(f, d):
    """The Laplacian of Σ c rᵃ (log r)ᵏ, k = 0 or 1, for r > 0.

    Functions are dictionaries {(a, k): c}.
    """
    result = {}
    for (a, k), c in f.items():
        result[a - 2, k] = result.get((a - 2, k), 0) + c * a * (a + d - 2)
        if k:
            result[a - 2, 0] = result.get((a - 2, 0), 0) + c * (2 * a + d - 2)
    return {term: c for term, c in result.items() if c}


def test_the_thin_plate_spline_of_space_is_another_kernel():
    """p. 11: off zero r² log r solves Δ²w = 0 in the plane; in space r solves it.

    In space r³ solves Δ³w = 0. The system of p. 13 is nevertheless solvable with r² log r in space.
    """
    kernel, r, cube = {(2, 1): 1}, {(1, 0): 1}, {(3, 0): 1}
    assert laplacian(laplacian(kernel, 2), 2) == {}
    assert laplacian(laplacian(kernel, 3), 3) == {(-2, 0): 6}
    assert laplacian(laplacian(r, 3), 3) == {}
    assert laplacian(laplacian(laplacian(cube, 3), 3), 3) == {}
    points = datasets.halton(25, 3)
    values = points @ [1.0, 2.0, 3.0] + np.sin(6 * points[:, 0])
    for k in (thin_plate_spline(), polyharmonic(1), polyharmonic(3)):
        s = RBF(points, k, degree=1).field(values)
        np.testing.assert_allclose(s(points), values, atol=1e-10)


def test_the_multipliers_are_the_polynomial_coefficients():
    """p. 11: c is the multiplier of min ½λᵀAλ - φᵀλ subject to Pᵀλ = δ.

    λ is the multiplier of the conditions φ = f(p) of p. 12. A multiplier is the derivative of the
    optimum with respect to the right side of its condition.
    """
    points = datasets.halton(12, 2)
    phi = np.cos(5 * points[:, 0]) + points[:, 1]
    h, p = slides_matrix(points)
    n, q = p.shape
    a = h[:n, :n]

    def optimum(delta):
        lam = np.linalg.solve(h, np.concatenate([phi, delta]))[:n]
        return lam @ a @ lam / 2 - phi @ lam

    def energy(phi):
        lam = np.linalg.solve(h, np.concatenate([phi, np.zeros(q)]))[:n]
        return lam @ a @ lam

    def derivative(f, at):
        return np.array([(f(at + e) - f(at - e)) / 2 for e in np.eye(len(at))])  # f is quadratic

    lam, c = RBF(points, thin_plate_spline()).coefficients(phi)
    np.testing.assert_allclose(derivative(optimum, np.zeros(q)), -c, rtol=1e-8)
    np.testing.assert_allclose(derivative(energy, phi), 2 * lam, rtol=1e-8)
    assert len(lam) != q  # so λ cannot be the multiplier of the q side conditions


def test_the_rbf_matrix_is_indefinite():
    """p.

    13: H_RBF has N positive and D + 1 negative eigenvalues, so it is never positive definite.
    """
    triangle = [(0, 0), (1, 0), (0, 1)]
    for w in (F(1), F(7, 5), F(-3)):  # any value of the kernel between the last two points
        a = [[0, 0, 0], [0, 0, w], [0, w, 0]]
        p = linear_basis(triangle)
        h = [a[i] + p[i] for i in range(3)] + [[*column, 0, 0, 0] for column in transposed(p)]
        assert h[0][0] == 0
        assert determinant(h) == -1
    with pytest.raises(np.linalg.LinAlgError):
        np.linalg.cholesky(slides_matrix(triangle)[0])
    for d, n in itertools.product((1, 2, 3), (4, 9, 30)):
        points = datasets.halton(n, d)
        for h in (slides_matrix(points)[0], RBF(points, thin_plate_spline()).matrix()):
            eigenvalues = np.linalg.eigvalsh(h)
            assert (np.sum(eigenvalues > 0), np.sum(eigenvalues < 0)) == (n, d + 1)


def test_the_rbf_system_is_singular_for_points_on_a_line():
    """p.

    13: the solution is unique if and only if the points are distinct and unisolvent of degree 1.
    """
    line = [(0, 0), (1, 2), (2, 4), (5, 10)]
    h, _ = slides_matrix(line)
    null = np.array([0, 0, 0, 0, 0, 2, -1.0])  # the polynomial 2x - y, and no basis functions
    assert not np.any(h @ null)
    with pytest.raises(np.linalg.LinAlgError, match="determine"):
        RBF(line, thin_plate_spline())
    twice, _ = slides_matrix([(0, 0), (1, 0), (0, 1), (0, 1)])
    assert np.array_equal(twice[2], twice[3])
    with pytest.raises(ValueError, match="points must be distinct"):
        RBF([(0, 0), (1, 0), (0, 1), (0, 1)], thin_plate_spline())


def test_without_side_conditions_the_thin_plate_matrix_can_be_zero():
    """p. 12-13: r² log r² is zero at distance 1. With the polynomial the matrix H is regular."""
    triangle = np.array([[0, 0], [1, 0], [0.5, math.sqrt(3) / 2]])
    h, _ = slides_matrix(triangle)
    np.testing.assert_allclose(h[:3, :3], 0, atol=1e-15)
    assert abs(np.linalg.det(h)) > 0.5


# --- finite volumes on meshes, p. 14-25 ----------------------------------------------------------


def test_a_circumcentre_may_lie_outside_its_triangle():
    """p.

    14: the circumcentre of an obtuse triangle, where the pressure is located, lies outside.
    """
    corners = [[0, 0], [4, 0], [1, 1]]
    x = circumcentre(corners)
    columns = [[1, 1, 1], *transposed(corners)]
    assert min(solved(columns, [1, *x])) < 0
    mesh = SimplexMesh(corners, [[0, 1, 2]])
    np.testing.assert_allclose(mesh.circumcenters[0], np.array(x, dtype=float))


def test_cocircular_cells_have_one_circumcentre():
    """p. 14, 32: the dual edge between them has length zero, and therefore no direction."""
    square = [[0, 0], [2, 0], [2, 2], [0, 2]]
    assert circumcentre(square[:3]) == circumcentre([square[0], *square[2:]])
    mesh = SimplexMesh(square, [[0, 1, 2], [0, 2, 3]])
    segments, _ = circumcentric_dual(mesh)
    inside = segments[mesh.face_cells[:, 1] >= 0]
    assert np.array_equal(inside[:, 0], inside[:, 1])


def test_in_space_dual_edges_meet_faces_at_their_circumcentres():
    """p. 14, 32: the dual edge passes through the circumcentre of the face, not the centroid.

    The mean of vertex velocities of p. 43 belongs to the centroid. In the plane both are the
    midpoint of the edge.
    """
    face, tops = [[0, 0, 0], [4, 0, 0], [1, 3, 0]], ([1, 1, 2], [2, 1, -3])
    ends = [circumcentre([*face, top]) for top in tops]
    flat = circumcentre([p[:2] for p in face])
    assert all(
        end[:2] == flat for end in ends
    )  # on the line normal to the face through its circumcentre
    centroid = [F(sum(column), 3) for column in transposed(face)][:2]
    assert flat != centroid
    mesh = SimplexMesh([*face, *tops], [[0, 1, 2, 3], [0, 1, 2, 4]])
    shared = int(np.flatnonzero(mesh.face_cells[:, 1] >= 0)[0])
    at = np.array(flat, dtype=float)
    np.testing.assert_allclose(mesh.face_circumcenters[shared][:2], at, atol=ROUNDING)
    u = mesh.points[:, [0]] * [0, 0, 1]
    v = normal_velocities(mesh, u)[shared] * mesh.face_normals[shared, 2]
    assert v == pytest.approx(float(centroid[0]))
    assert abs(v - float(flat[0])) > 0.1


def incident(cells, i):
    """Numbers of cells, faces and edges at vertex i, counted as sets of vertices."""
    mine = [frozenset(map(int, cell)) for cell in cells if i in cell]
    d = len(mine[0]) - 1
    faces = {frozenset(f) for cell in mine for f in itertools.combinations(cell, d) if i in f}
    edges = {frozenset((i, j)) for cell in mine for j in cell if j != i}
    return len(mine), len(faces), len(edges)


def test_numbers_of_faces_and_edges_at_a_vertex_of_n_cells():
    """p.

    15: in the plane N faces meet at an interior vertex and N + 1 at a boundary vertex. In space an
    interior vertex has 3N/2 faces and N/2 + 2 edges.
    """
    for d in (2, 3):
        mesh = SimplexMesh.delaunay(np.random.default_rng(3).random((60, d)))
        valences = np.diff(mesh.vertex_face_incidence.indptr)
        for i in range(60):
            n, faces, edges = incident(mesh.cells, i)
            assert len(mesh.vertex_cells(i)) == n
            assert valences[i] == faces
            if mesh.boundary_vertices[i]:
                assert faces != n
                assert d == 3 or faces == n + 1
            else:
                assert (faces, edges) == ((n, n) if d == 2 else (3 * n / 2, n / 2 + 2))


def ring(valence, seed):
    """Vertex 0 surrounded by a polygon, in integers."""
    rng = np.random.default_rng(seed)
    angle = 2 * np.pi * (np.arange(valence) + rng.uniform(-0.2, 0.2, valence)) / valence
    polygon = rng.uniform(50, 90, valence)[:, None] * np.column_stack(
        [np.cos(angle), np.sin(angle)]
    )
    points = [[7, -3], *np.rint(polygon).astype(int).tolist()]
    rest = range(1, valence + 1)
    return points, [(0, k) for k in rest], [(k, k % valence + 1) for k in rest]


def velocity_matrix(points, edges):
    """B' of p. 22 with rows (nᵀ, x nᵀ, y nᵀ), times the lengths of the edges."""
    rows = []
    for i, j in edges:
        (x0, y0), (x1, y1) = points[i], points[j]
        n, (x, y) = (y1 - y0, x0 - x1), (F(x0 + x1, 2), F(y0 + y1, 2))
        rows.append([*n, *(x * c for c in n), *(y * c for c in n)])
    return rows


@pytest.mark.parametrize("valence", range(3, 9))
def test_edges_at_a_vertex_do_not_suffice(valence):
    """p.

    15-22: u = x - x_i is tangent to all of these edges. Therefore the rank of B' is at most 5, and
    H is singular.
    """
    points, spokes, _ = ring(valence, 4)
    b = velocity_matrix(points, spokes)
    x, y = points[0]
    expansion = [-x, -y, 1, 0, 0, 1]  # c0, c1, c2 of u = x - x_i
    assert not any(times(b, expansion))
    assert rank(b) == min(5, valence)
    assert determinant(product(transposed(b), b)) == 0


@pytest.mark.parametrize("valence", range(3, 9))
def test_one_ring_suffices_for_valence_five_and_more(valence):
    """p. 15-22: with the edges opposite the vertex the rank is N + 1 in general, at most 6.

    Six equations are not sufficient: the rank depends on the number of vertices of the patch, N +
    1.
    """
    points, spokes, opposite = ring(valence, 5)
    b = velocity_matrix(points, spokes + opposite)
    assert len(b) == 2 * valence >= 6
    assert rank(b) == min(6, valence + 1)


def test_vertices_on_a_conic_reduce_the_rank_of_a_patch():
    """p. 42: the rank of B' equals that of the quadratic monomials at the vertices of the patch."""
    # five points of the conic x y = 60, and a sixth on it or off it
    five = [[1, 60], [-6, -10], [-10, -6], [60, 1], [20, 3]]
    for sixth, wanted in (([3, 20], 5), ([4, 20], 6)):
        points = [*five, sixth]
        squares = [[1, x, y, x * x, x * y, y * y] for x, y in points]
        assert rank(squares) == wanted
        fan = [(0, k) for k in range(1, 6)] + [(k, k + 1) for k in range(1, 5)]
        assert rank(velocity_matrix(points, fan)) == wanted


def test_full_rank_of_the_points_is_not_sufficient():
    """p.

    42: full column rank of B does not suffice. If five of six points are collinear, B' is singular
    for all normals.
    """
    points = [[k, 0] for k in range(5)] + [[1, 1]]
    assert rank([[1, x, y] for x, y in points]) == 3
    numbers = np.random.default_rng(4).integers(-9, 10, (50, 6, 2)).tolist()
    for normals in numbers:
        pairs = zip(points, normals, strict=True)
        assert rank([[a * b for b in (1, *p) for a in n] for p, n in pairs]) <= 5
    spread = [[0, 0], [1, 0], [0, 1], [0, 0], [1, 0], [0, 1]]  # two directions at three corners
    axes = [[1, 0]] * 3 + [[0, 1]] * 3
    pairs = zip(spread, axes, strict=True)
    assert rank([[a * b for b in (1, *p) for a in n] for p, n in pairs]) == 6


def test_least_norm_silently_fails_for_a_rotation():
    """p.

    22: the least-norm solution with too few edges does not reproduce a rotation. The library uses a
    second ring instead.
    """
    mesh = SimplexMesh.delaunay(np.random.default_rng(6).random((80, 2)))
    rotation = np.array([[0.0, 1.0], [-1.0, 0.0]])
    u = (mesh.points - mesh.points.mean(axis=0)) @ rotation
    v = normal_velocities(mesh, u)
    valence = np.diff(mesh.vertex_cell_incidence.indptr)
    inside = ~mesh.boundary_vertices & (valence == 4)
    assert inside.any()
    found = vertex_velocities(mesh, v)
    np.testing.assert_allclose(found.values, u, atol=1e-10)
    assert np.all(found.rings[inside] == 2)
    for i in np.flatnonzero(inside):
        spokes = np.flatnonzero((mesh.faces == i).any(axis=1))
        n, p = mesh.face_normals[spokes], mesh.face_centers[spokes]
        b = np.hstack([n, p[:, :1] * n, p[:, 1:] * n])
        c = np.linalg.lstsq(b, v[spokes])[0]
        assert np.abs(b @ c - v[spokes]).max() < ROUNDING  # the residual is zero
        assert np.linalg.norm(np.array([1, *mesh.points[i]]) @ c.reshape(3, 2) - u[i]) > 1e-3


def test_the_velocity_matrix_has_two_orders_of_columns():
    """p. 21-22: (N_x B, N_y B) with c_x, c_y is the second B' with c_0, c_1, c_2 reordered."""
    rng = np.random.default_rng(7)
    p, n, c = rng.random((8, 2)), rng.normal(size=(8, 2)), rng.random((3, 2))
    b = np.column_stack([np.ones(8), p])
    first = np.hstack([n[:, :1] * b, n[:, 1:] * b])
    second = np.hstack([n, p[:, :1] * n, p[:, 1:] * n])
    assert np.abs(first - second).max() > 0.1
    assert np.array_equal(first[:, [0, 3, 1, 4, 2, 5]], second)
    np.testing.assert_allclose(first @ c.T.ravel(), second @ c.ravel())


def test_right_sides_must_be_vectors():
    """p.

    22, 25: W B'c is a vector. The right side must be the vector W V', not W'; the system of p. 25
    is B c = V.
    """
    rng = np.random.default_rng(8)
    w, b, c, v = np.diag(rng.random(8)), rng.random((8, 6)), rng.random(6), rng.random(8)
    assert (w @ b @ c).shape == (w @ v).shape == (8,)
    assert w.T.shape != (8,)


def test_the_field_of_the_exercise_rotates_about_the_mean():
    """p.

    43: u_k is the difference x_k - m rotated by 90°. The printed product of two vectors is
    undefined.
    """
    mesh = SimplexMesh.delaunay(datasets.halton(40, 2))
    m = mesh.points.mean(axis=0)

    def rotated(x):
        return np.stack([-x[:, 1], x[:, 0]], axis=1)

    def largest_radial_component(u):
        return np.abs(np.einsum("kd,kd->k", u, mesh.points - m)).max()

    assert (
        largest_radial_component(rotated(mesh.points * m)) > 0.01
    )  # not even component by component
    assert largest_radial_component(rotated(mesh.points - m)) < ROUNDING
    assert np.abs(rotated(mesh.points - m).mean(axis=0)).max() < ROUNDING


def test_cell_velocities_belong_to_circumcentres_in_rotations():
    """p. 23-25, 44: for an expansion the value belongs to the symmedian point Σl²q / Σl² instead.

    For a strain the value belongs to another point, which depends on the strain: with
    S = diag(1, -1) the error at the circumcentre of an equilateral triangle is half its radius.
    """
    q = [[0, 0], [4, 0], [0, 3]]
    edges = [(1, 2), (2, 0), (0, 1)]  # the k-th opposite q_k
    lengths = [5, 3, 4]
    normals = [[F(3, 5), F(4, 5)], [-1, 0], [0, -1]]

    def fitted(u):
        middle = [[F(q[i][k] + q[j][k], 2) for k in (0, 1)] for i, j in edges]
        return least_squares(normals, [dot(n, u(m)) for n, m in zip(normals, middle, strict=True)])

    center = circumcentre(q)
    symmedian = [
        sum(length**2 * p[k] for length, p in zip(lengths, q, strict=True)) / F(50) for k in (0, 1)
    ]
    assert fitted(lambda x: [-x[1], x[0]]) == [-center[1], center[0]]
    assert fitted(lambda x: x) == symmedian != center
    mesh = SimplexMesh(q, [[0, 1, 2]])
    v = normal_velocities(mesh, mesh.points)
    np.testing.assert_allclose(cell_velocities(mesh, v).values[0], np.array(symmedian, dtype=float))
    np.testing.assert_allclose(raviart_thomas(mesh, v)[0], np.array(center, dtype=float))
    equilateral = SimplexMesh(regular(3), [[0, 1, 2]])
    strain = equilateral.points * [1, -1]
    u = cell_velocities(equilateral, normal_velocities(equilateral, strain))
    assert np.linalg.norm(u.values[0]) == pytest.approx(0.5)
    assert u.defect[0] < ROUNDING


# --- convex polytopes, p. 27-31 ------------------------------------------------------------------

PENTAGON = [[0, 0], [4, 0], [5, 3], [2, 5], [-1, 3]]


def outward(corners):
    """Outward normals of the edges. Their lengths cancel in ω."""
    after = [*corners[1:], corners[0]]
    return [[b[1] - a[1], a[0] - b[0]] for a, b in zip(corners, after, strict=True)]


def slides_weights(corners, x, volume):
    """ω of p. 29-31 with the given vol(n_a, n_b), in rational numbers."""
    normals = outward(corners)
    w = []
    for i, p in enumerate(corners):
        a, b = normals[i - 1], normals[i]
        w.append(volume(i, a, b) / (dot(a, minus(p, x)) * dot(b, minus(p, x))))
    return [v / sum(w) for v in w]


def absolute(_, a, b):
    return abs(determinant([a, b]))


def test_affinely_independent_points_make_simplices_only():
    """p. 27: at most D + 1 points are affinely independent, so a square would be excluded.

    The intended condition is N ≥ D + 1 points in convex position that affinely span R^D.
    """
    square = [[0, 0], [1, 0], [1, 1], [0, 1]]
    assert rank(linear_basis(square)) == 3 < len(square)
    np.testing.assert_allclose(BarycentricCoordinates(square).weights([0.5, 0.5]), 0.25)
    with pytest.raises(np.linalg.LinAlgError, match="line"):
        BarycentricCoordinates([[0, 0], [1, 1], [2, 2], [3, 3]])


def test_a_point_within_an_edge_has_no_coordinate():
    """p. 28: two edges meet at the point but vol is zero, so its value has no influence.

    On the edge ω is 0/0. The limit is linear between neighbours; the library takes it.
    """
    corners = [[0, 0], [1, 0], [2, 0], [2, 2], [0, 2]]
    assert slides_weights(corners, [1, F(1, 10**9)], absolute)[1] == 0
    with pytest.raises(ZeroDivisionError):
        slides_weights(corners, [F(1, 2), 0], absolute)
    limit = BarycentricCoordinates(corners).weights([[0.5, 0], [1, 0], [1, 0.5]])
    np.testing.assert_allclose(limit[:2], [[0.5, 0.5, 0, 0, 0], [0, 1, 0, 0, 0]], atol=ROUNDING)
    assert abs(limit[2, 1]) < ROUNDING


def test_the_volume_of_the_normals_is_an_absolute_value():
    """p.

    30: N_i is a set, so the order of its elements and the sign of det are arbitrary: |det| is
    meant.
    """
    x = [2, 2]

    def unordered(i, a, b):
        return determinant([b, a] if i in (0, 2) else [a, b])

    def position(w):
        return [dot(w, column) for column in transposed(PENTAGON)]

    literal = slides_weights(PENTAGON, x, unordered)
    assert min(literal) < 0
    assert max(map(abs, minus(position(literal), x))) > F(1, 4)
    intended = slides_weights(PENTAGON, x, absolute)
    assert position(intended) == x
    ours = BarycentricCoordinates(PENTAGON).weights(x)[0]
    np.testing.assert_allclose(ours, np.array(intended, dtype=float), rtol=ROUNDING)


def test_the_quotient_has_no_value_on_the_boundary():
    """p. 29, 31: on an edge two weights are infinite and ω is ∞/∞. The product form is exact."""
    for x in ([2, 0], [0, 0]):
        with pytest.raises(ZeroDivisionError):
            slides_weights(PENTAGON, x, absolute)
    weights = BarycentricCoordinates(PENTAGON).weights([[2.0, 0.0], [0.0, 0.0]])
    assert np.array_equal(weights, [[0.5, 0.5, 0, 0, 0], [1, 0, 0, 0, 0]])


def test_beside_an_edge_the_quotient_is_silently_wrong():
    """p.

    29, 31: heights near an edge are rounding errors. The product form has one height per face and
    is accurate.
    """
    worst = 0.0
    for k in range(40):
        angle = 0.01 * k + np.pi / 3 * np.arange(6)
        corners = np.column_stack([np.cos(angle), np.sin(angle)])
        edge = np.roll(corners, -1, axis=0) - corners
        normals = np.column_stack([edge[:, 1], -edge[:, 0]]) / np.linalg.norm(edge, axis=1)[:, None]
        x = (corners[0] + corners[1]) / 2
        with np.errstate(divide="ignore", invalid="ignore"):
            h = [normals[[i - 1, i]] @ (corners[i] - x) for i in range(6)]
            w = [abs(np.linalg.det(normals[[i - 1, i]])) / np.prod(h[i]) for i in range(6)]
            omega = np.array(w) / np.sum(w)
        truth = [0.5, 0.5, 0, 0, 0, 0]
        if np.all(np.isfinite(omega)):
            worst = max(worst, np.abs(omega - truth).max())
        ours = BarycentricCoordinates(corners).weights(x)[0]
        np.testing.assert_allclose(ours, truth, atol=1e-15)
    assert worst > 0.1


def test_outside_the_coordinates_change_sign_and_have_a_pole():
    """p. 31: outside, linear fields are reproduced except on a curve where Σ w vanishes.

    For this quadrilateral the curve is the line 4x + 3y + 12 = 0 through the intersections of
    opposite edges.
    """
    corners = [[0, 0], [2, 0], [3, 2], [0, 1]]
    outside = slides_weights(corners, [5, 7], absolute)
    assert min(outside) < 0
    assert [dot(outside, column) for column in transposed(corners)] == [5, 7]
    ours = BarycentricCoordinates(corners).weights([5, 7])[0]
    np.testing.assert_allclose(ours, np.array(outside, dtype=float))
    for pole in ([-F(9, 4), -1], [-F(15, 4), 1]):
        assert 4 * pole[0] + 3 * pole[1] + 12 == 0
        with pytest.raises(ZeroDivisionError):
            slides_weights(corners, pole, absolute)
        with pytest.raises(np.linalg.LinAlgError, match="no value"):
            BarycentricCoordinates(corners).weights(np.array(pole, dtype=float))


# --- Voronoi cells, p. 32-37 and 45 --------------------------------------------------------------


def corners_of_cell(neighbors):
    """Corners of the Voronoi cell of the origin, each with its number of faces."""
    found = {}
    for three in itertools.combinations(neighbors, 3):
        if determinant(three):
            x = tuple(solved(three, [F(dot(b, b), 2) for b in three]))
            heights = [F(dot(b, b), 2) - dot(b, x) for b in neighbors]
            if min(heights) >= 0:
                found[x] = heights.count(0)
    return found


def test_a_voronoi_cell_need_not_be_simple():
    """p. 33: in the face-centred lattice six of the fourteen corners have four faces."""
    neighbors = [p for p in itertools.product((-1, 0, 1), repeat=3) if sum(map(abs, p)) == 2]
    corners = corners_of_cell(neighbors)
    assert sorted(corners.values()) == [3] * 8 + [4] * 6
    lattice = [p for p in itertools.product(range(-2, 3), repeat=3) if sum(p) % 2 == 0]
    mesh = SimplexMesh.delaunay(lattice)
    cell = VoronoiCell(mesh, lattice.index((0, 0, 0)))
    assert {tuple(p) for p in cell.points.round(12) + 0.0} == {
        tuple(map(float, p)) for p in corners
    }
    x = np.array([0.25, -0.125, 0.375])
    np.testing.assert_allclose(cell.weights(x)[0] @ cell.points, x, atol=ROUNDING)


def test_voronoi_cells_on_the_boundary_are_open():
    """p.

    32-33: the cell of a vertex of the convex hull is unbounded, so its corners do not enclose it.
    """
    points = datasets.halton(30, 2)
    mesh = SimplexMesh.delaunay(points)
    hull = int(points[:, 0].argmin())
    for far in (1e3, 1e6, 1e9):
        x = points[hull] - [far, 0]
        others = np.delete(points, hull, axis=0)
        difference = (2 * x - points[hull] - others) @ (points[hull] - others).T
        assert np.all(np.diag(difference) > 0)  # x is nearest to the vertex, however far away
    with pytest.raises(ValueError, match="boundary"):
        VoronoiCell(mesh, hull)


def hexagon(center, turn=0.0):
    """The mesh of p. 45 with the centre as its last vertex, and the heights in its Voronoi cell."""
    c, s = np.cos(turn), np.sin(turn)
    corners = regular(6) @ np.array([[c, s], [-s, c]])
    points = np.vstack([corners, np.zeros(2)]) + center
    mesh = SimplexMesh(points, [[6, k, (k + 1) % 6] for k in range(6)])
    return mesh, lambda x: 0.5 - (x - center) @ corners.T


def spiral(r, n=50):
    k = np.arange(1, n + 1)
    angle = 2 * np.pi / n * k
    return (r / k)[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])


def inradius(mesh, a, b):
    """r = ‖(p_a + p_b)/2 - x_i‖."""
    p = mesh.circumcenters
    return float(np.linalg.norm((p[a] + p[b]) / 2 - mesh.points[6]))


def test_the_spiral_begins_at_the_centre_of_the_cell():
    """p. 45: the points are x_i + s_n. Around the origin they may all lie outside the cell."""
    center = np.array([3.0, -2.0])
    mesh, heights = hexagon(center)
    s = spiral(inradius(mesh, 0, 1))
    assert np.sum(heights(s).min(axis=1) >= 0) == 0
    assert np.sum(heights(center + s).min(axis=1) > 0) == 50
    cell = VoronoiCell(mesh, 6)
    x = center + s
    np.testing.assert_allclose(cell.field(cell.points.sum(axis=1))(x), x.sum(axis=1), atol=ROUNDING)


def test_the_spiral_radius_needs_neighbouring_circumcentres():
    """p. 45: a and b must be adjacent. For opposite circumcentres the midpoint is x_i and r = 0."""
    mesh, _ = hexagon(np.zeros(2))
    assert inradius(mesh, 0, 1) == pytest.approx(0.5)
    assert inradius(mesh, 0, 2) == pytest.approx(1 / math.sqrt(12))
    assert inradius(mesh, 0, 3) < ROUNDING


def test_the_spiral_may_touch_the_edge_of_the_cell():
    """p.

    45: the first point has the distance r from the centre. In a rotated hexagon it lies on an edge.
    """
    mesh, heights = hexagon(np.zeros(2), turn=2 * np.pi / 50)
    first = spiral(inradius(mesh, 0, 1))[:1]
    assert abs(heights(first).min()) < 1e-15
    cell = VoronoiCell(mesh, 6)
    weights = np.sort(cell.weights(first)[0])
    np.testing.assert_allclose(weights, [0, 0, 0, 0, 0.5, 0.5], atol=1e-15)
    straight, heights = hexagon(np.zeros(2))
    margin = heights(spiral(inradius(straight, 0, 1))).min()
    assert margin == pytest.approx((1 - math.cos(2 * math.pi / 50)) / 2)
