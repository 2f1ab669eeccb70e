"""Theory of conditionally positive definite kernels: each condition, and failure without it.

References: Wendland, Scattered Data Approximation (2005), chapters 8 and 9; Micchelli (1986).
"""

import numpy as np
import pytest
import sympy
from scipy.linalg import null_space
from scipy.spatial.distance import cdist
from scipy.special import jv

from fieldrecon.kernels.base import Radial
from fieldrecon.kernels.conditionally_positive_definite import (
    multiquadric,
    polyharmonic,
    thin_plate_spline,
)
from fieldrecon.kernels.positive_definite import gaussian, inverse_multiquadric, matern, wendland
from fieldrecon.methods.rbf import RBF
from laws import all_monomials, assert_close

SITES = np.random.default_rng(8).random((25, 2))
ORDERS: list[Radial] = [
    gaussian(0.3),
    inverse_multiquadric(0.3),
    matern(1.5, 0.5),
    wendland(3, 1, 0.8),
    multiquadric(0.3),
    polyharmonic(1),
    thin_plate_spline(),
    polyharmonic(3),
    polyharmonic(4),
    polyharmonic(5),
    polyharmonic(6),
    polyharmonic(7),
]


def system(kernel: Radial, x: np.ndarray, degree: int) -> np.ndarray:
    """The saddle-point matrix of kernel and polynomials, in monomials."""
    p = all_monomials(x, degree) if degree >= 0 else np.zeros((len(x), 0))
    zero = np.zeros((p.shape[1], p.shape[1]))
    return np.block([[kernel(cdist(x, x)), p], [p.T, zero]])


def inertia(h: np.ndarray) -> tuple[int, int, int]:
    """Numbers of positive, negative and zero eigenvalues."""
    values = np.linalg.eigvalsh(h)
    tiny = 1e-12 * np.abs(values).max()
    return int((values > tiny).sum()), int((values < -tiny).sum()), int((abs(values) <= tiny).sum())


# --- the system -----------------------------------------------------------------------------------


@pytest.mark.parametrize("kernel", ORDERS, ids=repr)
def test_the_saddle_point_matrix_has_n_positive_and_q_negative_eigenvalues(kernel):
    """The sites are unisolvent; the polynomials have degree m - 1 or m for a kernel of order m."""
    for degree in (kernel.order - 1, kernel.order):
        q = system(kernel, SITES, degree).shape[0] - len(SITES)
        assert inertia(system(kernel, SITES, degree)) == (len(SITES), q, 0)


@pytest.mark.parametrize("kernel", [k for k in ORDERS if k.order > 1], ids=repr)
def test_too_low_a_degree_changes_the_inertia(kernel):
    """Some λ that annihilates the polynomials of degree m - 2 has a negative quadratic form."""
    degree = kernel.order - 2
    q = system(kernel, SITES, degree).shape[0] - len(SITES)
    assert inertia(system(kernel, 3 * SITES, degree)) != (len(SITES), q, 0)


@pytest.mark.parametrize("kernel", [polyharmonic(1), multiquadric(0.3)], ids=repr)
def test_kernel_matrices_of_order_one_are_regular_without_the_constant(kernel):
    """The form is positive on Σλ = 0, which gives n - 1 positive eigenvalues.

    The trace is not positive, so one eigenvalue is negative (Micchelli).
    """
    assert inertia(kernel(cdist(SITES, SITES))) == (len(SITES) - 1, 1, 0)


# --- existence and uniqueness ---------------------------------------------------------------------

NOT_UNISOLVENT = {
    "five on a line": np.array([[0.0, 0.0], [1, 2], [2, 4], [3, 6], [5, 10]]) / 7,
    "two in the plane": np.array([[0.1, 0.7], [0.6, 0.2]]),
    "eight on a plane": np.column_stack([np.random.default_rng(4).random((8, 2)), np.zeros(8)]),
}


@pytest.mark.parametrize("sites", NOT_UNISOLVENT.values(), ids=NOT_UNISOLVENT)
def test_a_solution_exists_without_unisolvency(sites):
    """The system is solvable for all data, but the polynomial part is not unique.

    A solution is λ = Z (ZᵀAZ)⁻¹ Zᵀ f, because f - Aλ is in the range of P. λ is unique. Any
    polynomial that vanishes at the sites may be added, and it changes the field between the sites.
    Therefore the library requires unisolvent sites.
    """
    h = system(thin_plate_spline(), sites, 1)
    n, d = sites.shape
    assert np.linalg.matrix_rank(h) == n + d  # one less than regular
    data = np.random.default_rng(5).standard_normal((n, 50))
    right = np.vstack([data, np.zeros((d + 1, 50))])
    solution = np.linalg.lstsq(h, right, rcond=1e-12)[0]
    assert_close(h @ solution, right, 1e-11)
    free = null_space(h, rcond=1e-12)
    assert free.shape[1] == 1
    assert_close(free[:n], np.zeros((n, 1)), 1e-11)
    assert_close(all_monomials(sites, 1) @ free[n:], np.zeros((n, 1)), 1e-11)
    outside = all_monomials(np.full((1, d), 0.9) + np.arange(d) / 3, 1) @ free[n:]
    assert abs(outside[0, 0]) > 1e-2
    with pytest.raises(np.linalg.LinAlgError, match="do not determine a polynomial of degree 1"):
        RBF(sites, thin_plate_spline())


def test_coincident_sites_are_solvable_for_equal_data_only():
    """With two equal rows the system is solvable if and only if the two data are equal."""
    sites = np.vstack([SITES[:6], SITES[:1]])
    h = system(thin_plate_spline(), sites, 1)
    data = np.cos(5 * sites[:, 0])
    for change, solvable in ((0.0, True), (0.1, False)):
        right = np.concatenate([data, np.zeros(3)])
        right[0] += change
        residual = h @ np.linalg.lstsq(h, right, rcond=1e-12)[0] - right
        assert (np.abs(residual).max() < 1e-10) == solvable


# --- Micchelli's criterion ------------------------------------------------------------------------

s = sympy.symbols("s", positive=True)
AS_FUNCTIONS_OF_THE_SQUARE = {
    gaussian(1.0): sympy.exp(-s),
    inverse_multiquadric(1.0): 1 / sympy.sqrt(1 + s),
    multiquadric(1.0): -sympy.sqrt(1 + s),
    polyharmonic(1): -sympy.sqrt(s),
    thin_plate_spline(): s * sympy.log(s),
    polyharmonic(3): s ** sympy.Rational(3, 2),
    polyharmonic(4): -(s**2) * sympy.log(s) / 2,
    polyharmonic(5): -(s ** sympy.Rational(5, 2)),
    polyharmonic(7): s ** sympy.Rational(7, 2),
}


def completely_monotone(f: sympy.Expr, derivatives: int = 6) -> bool:
    """Whether (-1)^j f^(j) ≥ 0 at a few values of s, for the first derivatives."""
    where = [0.001, 0.4, 2.5, 10000.0]
    for j in range(derivatives):
        slope = sympy.lambdify(s, (-1) ** j * sympy.diff(f, s, j))
        if not all(slope(at) >= 0 for at in where):
            return False
    return True


@pytest.mark.parametrize("kernel", AS_FUNCTIONS_OF_THE_SQUARE, ids=repr)
def test_the_order_is_that_of_the_first_completely_monotone_derivative(kernel):
    """Φ = φ(|·|²) has order m if (-1)^m φ^(m) is completely monotone, and m is minimal.

    The side conditions have degree m - 1. If they had degree m, as the definition may be misread,
    r³ would have order one; but its first derivative is not completely monotone.
    """
    phi = AS_FUNCTIONS_OF_THE_SQUARE[kernel]
    assert_close(kernel(np.sqrt(2.5)), float(phi.subs(s, 2.5)), 1e-12)
    order = next(m for m in range(6) if completely_monotone((-1) ** m * sympy.diff(phi, s, m)))
    assert order == kernel.order


def test_complete_monotonicity_gives_semidefiniteness_only():
    """φ(s) = -s satisfies the criterion for m = 1, but Σ λ_i λ_j φ = 2|Σ λ_i x_i|² can vanish.

    Micchelli's theorem must exclude polynomials.
    """
    assert completely_monotone(-sympy.diff(-s, s))
    x = SITES[:6]
    z = null_space(np.ones((1, 6)))
    values = np.linalg.eigvalsh(z.T @ -cdist(x, x, "sqeuclidean") @ z)
    assert_close(values[:3], np.zeros(3), 1e-14)
    assert values[3] > 0.01
    lam = z @ np.random.default_rng(2).random(5)
    form = lam @ -cdist(x, x, "sqeuclidean") @ lam
    assert form == pytest.approx(2 * np.sum((lam @ x) ** 2))


# --- Wendland's functions and dimensions ----------------------------------------------------------


NODES, WEIGHTS = np.polynomial.legendre.leggauss(200)


def transform(phi: Radial, d: int, w: float) -> float:
    """Fourier transform of φ(|x|) in d variables at |ω| = w, by Hankel's integral on [0, 1]."""
    r = (NODES + 1) / 2
    waves = jv(d / 2 - 1, r * w) * (r * w) ** (1 - d / 2)
    return float(WEIGHTS @ (phi(r) * waves * r ** (d - 1)))


@pytest.mark.parametrize(
    ("phi", "positive_below", "negative_at"),
    [
        (wendland(1, 0), 5.8, 6.0),
        (wendland(3, 0), 15.7, 16.0),
        (wendland(1, 1), 15.7, 16.0),
        (wendland(3, 1), 88.4, 94.8),
    ],
)
def test_wendland_transforms_are_positive_up_to_the_stated_dimension(
    phi, positive_below, negative_at
):
    """By Bochner's theorem the function is positive definite where its transform is not negative.

    This holds in `dimensions` variables and fails in one more. There the first frequency with a
    negative transform may be so high that random sites do not detect it. Therefore the library
    refuses by the dimension and not by a numerical test.
    """
    own = phi.dimensions
    waves = np.linspace(0.1, positive_below, 60)
    for d in range(1, own + 2):
        assert min(transform(phi, d, w) for w in waves) > 0
    assert transform(phi, own, negative_at) > 0
    assert transform(phi, own + 1, negative_at) < 0


@pytest.mark.parametrize("d", [1, 2, 3, 4, 5])
@pytest.mark.parametrize("k", range(4))
def test_wendland_functions_refuse_higher_dimensions(d, k):
    """Points in `dimensions` variables are accepted, and points in one more are refused."""
    phi = wendland(d, k, 0.5)
    for variables in (phi.dimensions, phi.dimensions + 1):
        sites = np.random.default_rng(1).random((12, variables))
        if variables <= phi.dimensions:
            assert RBF(sites, phi).degree == -1
        else:
            with pytest.raises(ValueError, match=f"at most {phi.dimensions} variables; points"):
                RBF(sites, phi)
