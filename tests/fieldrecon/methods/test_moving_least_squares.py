"""Moving least squares: the formulas of the slides, 500 digits, neighbourhoods and orders."""

import re
from dataclasses import dataclass

import numpy as np
import pytest
from scipy.spatial.distance import cdist

import high_precision
from cases import CASES, Case, case
from fieldrecon._core import chunks as _chunks
from fieldrecon._core.duplicates import coincidence_labels
from fieldrecon._numerics import weighted_least_squares
from fieldrecon._numerics.neighbor_search import group_rows
from fieldrecon.datasets.synthetic import halton
from fieldrecon.kernels.conditionally_positive_definite import (
    multiquadric,
    polyharmonic,
    thin_plate_spline,
)
from fieldrecon.kernels.positive_definite import gaussian, matern, wendland
from fieldrecon.kernels.weights import inverse_square
from fieldrecon.methods.least_squares import LeastSquares
from fieldrecon.methods.moving_least_squares import MovingLeastSquares
from fieldrecon.polynomials import EPS, dimension, monomials
from laws import assert_close, assert_obeyed, dense, refused

EXACT = 1e-10
MOVING = [c for c in CASES if isinstance(c.method, MovingLeastSquares)]
FINITE = [c for c in MOVING if "ε = 0," not in c.name and "ε = 0 " not in c.name]
POINTS = np.random.default_rng(1).random((30, 2))
VALUES = np.cos(POINTS @ [3.0, 2.0])


# --- the formulas of the slides -------------------------------------------------------------------


def weights_and_indices(method: MovingLeastSquares, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Weights w_i(x) of the sites in the neighbourhood, by its definition, and their indices."""
    matrix = np.eye(len(x)) if method.metric is None else method.metric
    r = np.sqrt(np.einsum("ik,kl,il->i", method.points - x, matrix, method.points - x))
    order = np.argsort(r)
    if method.neighbors is None:
        return method.weight(r), np.arange(len(r))
    near = order[: method.neighbors]
    return method.weight(r[near] / r[order[method.neighbors]]), near


def the_value_minimizes_the_weighted_squares(case: Case) -> None:
    """f(x) = b(x)ᵀc with c = argmin |W(Bc - V)|², by numpy.linalg.lstsq for each query."""
    m = case.method
    values = m.field(case.data)(case.queries)
    for x, value in zip(case.queries, values, strict=True):
        w, near = weights_and_indices(m, x)
        b = monomials(m.points[near] - x, m.degree)
        w = w / w.max()
        c = np.linalg.lstsq(w[:, None] * b, w * case.data[near], rcond=1e-15)[0]
        assert_close(value, c[0], 1e-8)


def the_matrix_equals_that_of_the_slides(case: Case) -> None:
    """H_MLS(x) = Bᵀ W(x)² B in monomials of the coordinates, p. 9."""
    m = case.method
    for x, h in zip(case.queries, m.matrix(case.queries), strict=True):
        w, near = weights_and_indices(m, x)
        b = monomials(m.points[near], m.degree)
        expected = sum(w[i] ** 2 * np.outer(b[i], b[i]) for i in range(len(near)))
        assert_close(h / np.abs(expected).max(), expected / np.abs(expected).max(), EXACT)


def the_objective_is_the_weighted_residual(case: Case) -> None:
    """ψ_MLS(x) = ½ Σ w_i² (b_iᵀc - f_i)². The normalized one is divided by Σ w_i²."""
    m = case.method
    psi = m.objective(case.data, case.queries)
    normalized = m.objective(case.data, case.queries, normalized=True)
    for k, x in enumerate(case.queries):
        w, near = weights_and_indices(m, x)
        b = monomials(m.points[near] - x, m.degree)
        data = case.data[near]
        c = np.linalg.lstsq(w[:, None] * b, w * data, rcond=1e-15)[0]
        expected = 0.5 * np.sum((w * (b @ c - data)) ** 2)
        assert psi[k] == pytest.approx(expected, rel=1e-6, abs=1e-12 * w.max() ** 2)
        assert normalized[k] == pytest.approx(expected / np.sum(w**2), rel=1e-6, abs=1e-12)


MOVING_LAWS = [
    the_value_minimizes_the_weighted_squares,
    the_matrix_equals_that_of_the_slides,
    the_objective_is_the_weighted_residual,
]


@pytest.mark.parametrize("case", FINITE, ids=lambda case: case.name)
def test_every_case_obeys_the_formulas_of_the_slides(case):
    """The reference computes one query at a time."""
    assert_obeyed(MOVING_LAWS, case, case.name)


@dataclass(frozen=True)
class square_root(inverse_square):
    """The square root of the weight: BᵀWB, as in most books, instead of BᵀW²B."""

    def of_squared(self, s):
        return np.sqrt(super().of_squared(s))

    def slope_of_squared(self, s):
        return super().slope_of_squared(s) / (2 * self.of_squared(s))

    def in_units(self, h):
        return square_root(self.epsilon / h)


class RootForgotten(MovingLeastSquares):
    """Uses weights that enter once and declares the weights of the slides."""

    def __init__(self, points):
        super().__init__(points, square_root(0.1))
        self.inner, self.weight = self.weight, inverse_square(0.1)

    def _value_rows(self, x, prepared):
        return MovingLeastSquares(self.points, self.inner)._value_rows(x, prepared)

    def _true_weights(self, near):
        return self.inner(near.distance * self.unit)


@pytest.mark.parametrize("law", MOVING_LAWS, ids=lambda law: law.__name__)
def test_the_laws_reject_the_forgotten_root(law):
    """BᵀWB is another method than BᵀW²B, and each law rejects it."""
    right = case("MLS ε = 0.1, degree 1 in 2-D")
    mutant = Case("RootForgotten", lambda p, _: RootForgotten(p), 2, right.n)
    with pytest.raises(AssertionError):
        law(mutant)


def test_the_objective_is_minimal():
    """Any other polynomial has a larger ψ."""
    m, x = MovingLeastSquares(POINTS, inverse_square(0.1)), np.array([0.4, 0.3])
    w2 = m.weight(np.linalg.norm(POINTS - x, axis=1)) ** 2
    s = m.field(VALUES)
    b = monomials(POINTS - x, 1)
    c = np.linalg.solve(b.T @ (w2[:, None] * b), b.T @ (w2 * VALUES))
    assert c[0] == pytest.approx(float(s(x)))
    for change in np.random.default_rng(2).standard_normal((20, 3)):
        residual = b @ (c + 1e-3 * change) - VALUES
        assert 0.5 * np.sum(w2 * residual**2) > float(m.objective(VALUES, x))


@pytest.mark.parametrize("epsilon", [0.01, 0.1, 1.0])
def test_the_derivative_of_the_objective_by_epsilon_is_negative(epsilon):
    """Envelope theorem: dψ/d(ε²) = -Σ w³ r², because ∂ψ/∂c vanishes and dw/d(ε²) = -w²."""
    x = np.array([0.4, 0.3])

    def psi(e2):
        return float(MovingLeastSquares(POINTS, inverse_square(e2**0.5)).objective(VALUES, x))

    e2, h = epsilon**2, 1e-3 * epsilon**2
    by = {k: psi(e2 + k * h) - psi(e2 - k * h) for k in (1, 2, 3)}
    w = inverse_square(epsilon)(np.linalg.norm(POINTS - x, axis=1))
    b = monomials(POINTS - x, 1)
    c = np.linalg.lstsq(w[:, None] * b, w * VALUES, rcond=None)[0]
    expected = -np.sum(w**3 * (b @ c - VALUES) ** 2)
    assert (45 * by[1] - 9 * by[2] + by[3]) / (60 * h) == pytest.approx(expected, rel=1e-7)


def test_a_wide_weight_gives_least_squares():
    """For large ε, ε⁴ψ → ψ_LS and f_MLS → f_LS, even for ε far beyond all lengths."""
    plain, x = LeastSquares(POINTS), np.array([[0.4, 0.3], [1.5, 0.2]])
    for epsilon in (1e6, 1e160, 1e300):
        m = MovingLeastSquares(POINTS, inverse_square(epsilon))
        assert_close(m.field(VALUES)(x), plain.field(VALUES)(x), 1e-10)
        assert_close(m.field(VALUES).gradient(x), plain.field(VALUES).gradient(x), 1e-10)
    psi = MovingLeastSquares(POINTS, inverse_square(1e4)).objective(VALUES, x)
    assert_close(1e16 * psi, np.full(2, float(plain.objective(VALUES))), 1e-7)


# --- at and near a site ---------------------------------------------------------------------------


@pytest.mark.parametrize("degree", [0, 1, 2])
@pytest.mark.parametrize("neighbors", [None, 12])
def test_with_epsilon_zero_results_at_a_site_are_limits(degree, neighbors):
    """Value, gradient and ψ at a site are the limits for queries that approach it."""
    m = MovingLeastSquares(POINTS, inverse_square(0.0), degree, neighbors)
    s, site = m.field(VALUES), POINTS[3]
    beside = site + 1e-9 * np.array([0.6, 0.8])
    assert_close(s(site), VALUES[3], 1e-14)
    assert_close(s(beside), s(site), 1e-7)
    assert_close(s.gradient(beside), s.gradient(site), 1e-6)
    assert m.objective(VALUES, beside) == pytest.approx(float(m.objective(VALUES, site)), rel=1e-6)
    assert float(m.objective(VALUES, site, normalized=True)) < 1e-200


@pytest.mark.parametrize("degree", [0, 1, 2])
def test_the_error_at_a_site_is_of_fourth_order_in_epsilon(degree):
    """The error of f at a site is O(ε⁴), for two values of ε."""
    errors = [
        abs(
            float(MovingLeastSquares(POINTS, inverse_square(e), degree).field(VALUES)(POINTS[3]))
            - VALUES[3]
        )
        for e in (1e-2, 1e-3)
    ]
    assert np.log10(errors[0] / errors[1]) == pytest.approx(4, abs=0.1)


def test_shepard_s_field_has_gradient_zero_at_the_sites():
    """This holds for degree 0 and ε = 0. For degree 1 it does not."""
    flat = MovingLeastSquares(POINTS, inverse_square(0.0), 0).field(VALUES).gradient(POINTS)
    assert_close(flat, np.zeros((30, 2)), 1e-12)
    sloped = MovingLeastSquares(POINTS, inverse_square(0.0), 1).field(VALUES).gradient(POINTS)
    assert np.median(np.linalg.norm(sloped, axis=1)) > 1.0


def test_coincident_sites_give_the_mean_of_their_data():
    """A method that cannot reproduce all data must not declare that it interpolates."""
    twice = np.concatenate([POINTS, POINTS[:1]])
    values = np.append(VALUES, VALUES[0] + 2)
    m = MovingLeastSquares(twice, inverse_square(0.0))
    assert float(m.field(values)(POINTS[0])) == pytest.approx(VALUES[0] + 1)
    assert not m.interpolates
    assert not MovingLeastSquares(twice, gaussian(1.0), 0, 1).interpolates
    assert MovingLeastSquares(POINTS, inverse_square(0.0)).interpolates


def test_coincident_sites_have_equal_labels():
    """-0.0 equals 0.0. The first of several coincident sites represents them."""
    p = np.array([[0.0, 1.0], [2.0, 1.0], [-0.0, 1.0], [2.0, 1.0], [2.0, 0.0], [0.0, 1.0]])
    labels = coincidence_labels(p)
    assert [labels[i] == labels[0] for i in range(6)] == [True, False, True, False, False, True]
    assert sorted(set(labels)) == [0, 1, 2]
    lead, count = group_rows(labels[None])
    assert lead.tolist() == [[0, 1, 0, 1, 4, 0]]
    assert count.tolist() == [[3, 2, 3, 2, 1, 3]]


# --- accuracy against 500 digits ------------------------------------------------------------------

FEW = np.random.default_rng(5).random((15, 2))
SHAPES = {
    "scattered": FEW,
    "a million away": FEW + 2.0**20,
    "within 1e-9 of a line": FEW * [1.0, 1e-9],
}
MORE = (1e-300, 1e-14, 1e-8, 0.1, 100.0)
EPSILONS = (0.0, 1e-70, 1e-12, 1e-4, 1.0, *(pytest.param(e, marks=pytest.mark.slow) for e in MORE))


def smooth(p: np.ndarray) -> np.ndarray:
    """Data of size one for any shape of the point set."""
    y = (p - p.min(axis=0)) / np.ptp(p, axis=0)
    return np.cos(y @ [3.0, 2.0])


LONG = [pytest.param(degree, marks=pytest.mark.slow) for degree in (0, 2)]


@pytest.mark.parametrize("degree", [1, *LONG])
@pytest.mark.parametrize("epsilon", EPSILONS)
@pytest.mark.parametrize("shape", SHAPES)
def test_values_gradients_and_psi_are_accurate(shape, epsilon, degree):
    """The distance of the query from a site is between 1e-1 and 1e-14 or zero.

    Weights exceed 1e140.
    """
    points = SHAPES[shape]
    values, weight = smooth(points), high_precision.inverse_square(epsilon)
    m = MovingLeastSquares(points, inverse_square(epsilon), degree)
    s = m.field(values)
    for fraction in (0.3, 1e-6, 1e-9, 1e-12, 1e-14, 0.0):
        x = points[4] + fraction * (points[7] - points[4])
        near_pole = epsilon < 1e-60 and (x == points[4]).all()
        y = high_precision.beside(x) if near_pole else high_precision.exact(x)
        value = float(high_precision.moving(points, values, y, weight, degree))
        gradient = high_precision.gradient(
            lambda at: high_precision.moving(points, values, at, weight, degree), y
        )
        psi = high_precision.moving_objective(points, values, y, weight, degree)
        size = max(1.0, np.abs(gradient).max())
        assert_close(s(x), value, 1e-12 * max(1.0, abs(value)))
        assert_close(s.gradient(x) / size, gradient / size, 1e-11)
        assert float(m.objective(values, x)) == pytest.approx(psi, rel=1e-9)


@pytest.mark.parametrize("degree", [0, 1, 2])
@pytest.mark.parametrize("epsilon", EPSILONS)
def test_values_near_two_sites_1e_11_apart_are_accurate(epsilon, degree):
    """The slope there is a difference of data over 1e-11, accurate to 1e-5.

    At a distance of 1e-6 its effect is 1e-11.
    """
    points = np.vstack([FEW[:14], FEW[4:5] + np.array([1e-11, 2e-11])])
    values, weight = smooth(points), high_precision.inverse_square(epsilon)
    s = MovingLeastSquares(points, inverse_square(epsilon), degree).field(values)
    for x in [(points[4] + points[14]) / 2, *(points[4] + f * FEW[7] for f in (1e-9, 1e-6, 0.3))]:
        value = float(high_precision.moving(points, values, x, weight, degree))
        assert_close(s(x), value, 1e-10 if epsilon < 1e-4 else 1e-12)


@pytest.mark.parametrize("seed", range(6))
def test_collinear_sites_of_large_weight_do_not_affect_the_normal_slope(seed):
    """Five collinear sites 1e-13 from the query have weights 1e24 times those of twenty others.

    Two sites determine everything along the line. The remainder of the five rows is rounding, and
    must not dominate the other sites.
    """
    rng, spacing = np.random.default_rng(seed), 2.0**-44
    on_line = np.outer(np.arange(1, 6), rng.integers(1, 9, 2)) * spacing
    sites = np.vstack([on_line, rng.random((20, 2)) - 0.5])
    affine = np.column_stack([np.ones(len(sites)), sites])
    s = MovingLeastSquares(sites, inverse_square(0.0), 1).field(affine)
    gradient = s.gradient(np.zeros(2))
    assert_close(gradient[0], np.zeros(2), 4 * EPS / spacing)
    assert_close(gradient[1:], np.eye(2), 1e-14)


@pytest.mark.slow
@pytest.mark.parametrize("degree", [0, 1, 2])
@pytest.mark.parametrize("epsilon", [1e-12, 1e-8, 1e-4, 1e-2, 0.1])
def test_coincident_sites_with_different_data_are_accurate(epsilon, degree):
    """Three data belong to one site and two to another; queries are near and far."""
    points = FEW.copy()
    points[5] = points[6] = points[4]
    points[9] = points[8]
    values = np.random.default_rng(8).standard_normal(15)
    m = MovingLeastSquares(points, inverse_square(epsilon), degree)
    s, weight = m.field(values), high_precision.inverse_square(epsilon)
    for distance in (0.1, 1e-3, 1e-6, 1e-9, 1e-12, 0.0):
        x = points[4] + distance * np.array([0.6, 0.8])
        gradient = high_precision.gradient(
            lambda at: high_precision.moving(points, values, at, weight, degree), x
        )
        size = max(1.0, np.abs(gradient).max())
        assert_close(s(x), float(high_precision.moving(points, values, x, weight, degree)), 1e-12)
        assert_close(s.gradient(x) / size, gradient / size, 1e-11)
        psi = high_precision.moving_objective(points, values, x, weight, degree)
        assert float(m.objective(values, x)) == pytest.approx(psi, rel=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("degree", [0, 1, 2])
@pytest.mark.parametrize(
    "scale", [0.1, *(pytest.param(s, marks=pytest.mark.slow) for s in (0.3, 10.0))]
)
def test_gaussian_weights_are_accurate(scale, degree):
    """The weights decrease by a hundred orders of magnitude within the point set."""
    m = MovingLeastSquares(FEW, gaussian(scale), degree)
    values = smooth(FEW)
    s, weight = m.field(values), high_precision.gaussian(scale)
    for x in (FEW[4], FEW[4] + 1e-9, (FEW[4] + FEW[7]) / 2, np.array([-0.5, 1.5])):
        value = float(high_precision.moving(FEW, values, x, weight, degree))
        gradient = high_precision.gradient(
            lambda at: high_precision.moving(FEW, values, at, weight, degree), x
        )
        size = max(1.0, abs(value), np.abs(gradient).max())
        assert_close(s(x) / size, value / size, 1e-11)
        assert_close(s.gradient(x) / size, gradient / size, 1e-10)


def test_a_redundant_variable_does_not_change_residuals():
    """Slopes among sites within 1e-4 are so large that they are projections, with a column twice.

    The sum a_i g_i r_i over the sites is the part in the gradient that is due to the weights.
    """
    rng = np.random.default_rng(4)
    x, w = 1e-4 * rng.random((5, 12)), rng.random((5, 12))
    w /= w.max(axis=1, keepdims=True)
    data, g = rng.random((5, 12, 2)), rng.random((5, 12, 1))
    b = np.stack([np.ones_like(x), x], axis=2)
    c = np.linalg.pinv(w[..., None] * b) * w[:, None]
    expected = data - b @ (c @ data)
    a = np.einsum("mi,miv,mi->mv", c[:, 0], expected, g[..., 0])
    for again in ([0, 1], [0, 1, 1]):
        b3, share = b[..., again], np.array([1.0, *[1 / (len(again) - 1)] * (len(again) - 1)])
        c3 = c[:, again] * share[:, None]
        assert np.abs(c3).max() > 1000
        assert_close(weighted_least_squares.residuals(c3, b3, w, data), expected, 1e-11)
        change = weighted_least_squares.weights_of_changing_weights(c3, b3, w, g)
        assert_close(np.einsum("mid,miv->mv", change, data), a, 1e-11)


def test_units_of_the_basis_do_not_matter():
    """Sites in a strip determine a polynomial as well as those of the stretched strip."""
    y = np.random.default_rng(4).uniform(-1, 1, (2, 9, 2))
    b, w = monomials(y, 1), np.ones((2, 9))
    units, tolerance = np.array([[1.0, 1.0, 1e-12], [1.0, 1.0, 1.0]])[:, None], np.full(2, 1e-6)
    for rows in (1, 3):
        c = weighted_least_squares.coefficient_weights(b, w, rows, tolerance)
        narrow = weighted_least_squares.coefficient_weights(b * units, w, rows, tolerance)
        assert_close(narrow * units.mT[:, :rows], c, 1e-13)


def test_sites_without_weight_do_not_determine_a_polynomial():
    """Those that count lie on a line; the first such query is named, with the rank."""
    y = np.random.default_rng(4).uniform(-1, 1, (4, 9, 2))
    y[1:3, :6, 1] = y[1:3, :6, 0] / 2
    w = np.tile([1.0] * 6 + [0.0] * 3, (4, 1))
    for rows in (1, 3):
        with pytest.raises(weighted_least_squares.Undetermined) as refusal:
            weighted_least_squares.coefficient_weights(monomials(y, 1), w, rows, np.full(4, 1e-9))
        assert (refusal.value.query, refusal.value.rank) == (1, 2)


def test_the_tolerance_is_relative_to_the_largest_singular_value():
    """Nearly equal unit vectors (1, ±t) have the singular values √2 and √2 t."""
    t = 1e-4
    b = np.array([[[1.0, 1.0], [t, -t]]]) / np.sqrt(1 + t**2)
    w = np.ones((1, 2))
    c = weighted_least_squares.coefficient_weights(b, w, 2, np.array([0.9 * t]))
    assert_close(c @ b, np.eye(2)[None], 1e-11)
    for columns, tolerance in ((b, 1.1 * t), (b * [1.0, 0.0], 0.0)):
        with pytest.raises(weighted_least_squares.Undetermined):
            weighted_least_squares.coefficient_weights(columns, w, 2, np.array([tolerance]))


def test_weights_may_be_just_as_large_as_is_allowed():
    """Otherwise the query with the largest is named, though its polynomial is determined."""
    y = np.random.default_rng(4).uniform(-1, 1, (4, 4, 2))
    y[2] += 9.0  # the value far outside has larger weights
    b, w = monomials(y, 1) * np.array([1.0, 1.0, 1e-12]), np.ones((4, 4))
    b[0, :, 2] *= 1e12
    weights = weighted_least_squares.coefficient_weights
    for rows in (1, 3):
        c = weights(b, w, rows, np.zeros(4))
        size = np.abs(c[:, 0]).sum(axis=1)
        assert size.argmax() == 2
        assert np.array_equal(weights(b, w, rows, np.zeros(4), size[2]), c)
        with pytest.raises(weighted_least_squares.Undetermined) as refusal:
            weights(b, w, rows, np.zeros(4), np.nextafter(size[2], 0.0))
        assert refusal.value.args == (2, 3, size[2])


def test_the_high_precision_gradient_of_a_line_is_its_slope():
    """This checks the reference itself."""
    x = np.linspace(0, 1, 6)[:, None]
    g = high_precision.gradient(
        lambda at: high_precision.moving(x, 3 * x[:, 0], at, high_precision.inverse_square(0.1), 1),
        [0.37],
    )
    assert_close(g, np.array([3.0]), 1e-15)


# --- neighbourhoods -------------------------------------------------------------------------------


def test_only_the_nearest_sites_have_weights():
    """Data of the other sites have no influence, and H is sparse."""
    m = MovingLeastSquares(POINTS, wendland(3, 1), neighbors=8)
    x = np.array([[0.4, 0.3]])
    h = m.weights(x)
    near = np.argsort(cdist(x, POINTS)[0])[:8]
    assert h.nnz == 8
    assert set(h.indices) == set(near)


def test_only_sites_within_the_radius_have_weights():
    """Every site within the radius has a nonzero weight."""
    m = MovingLeastSquares(POINTS, wendland(3, 1, 0.4))
    x = np.array([[0.4, 0.3], [0.6, 0.6]])
    h = m.weights(x).toarray()
    inside = cdist(x, POINTS) < 0.4
    assert (h[~inside] == 0).all()
    assert (h[inside] != 0).all()


@pytest.mark.parametrize("weight", [wendland(3, 1, 0.5), gaussian(0.3), inverse_square(0.0)])
def test_own_weights_are_the_diagonal_of_the_matrix_of_weights(monkeypatch, weight):
    """Also in chunks of a few sites, and where a site occurs twice: each has its own share."""
    monkeypatch.setattr(_chunks, "CHUNK_BYTES", 2**15)
    m = MovingLeastSquares(np.vstack([POINTS, POINTS[3]]), weight)
    assert_close(m.own_weights(), np.diagonal(dense(m.weights(m.points))), EXACT)


def test_the_field_is_continuous_where_neighbours_change():
    """The weight vanishes at the (k + 1)-th site.

    A weight that does not gives a discontinuous field.
    """
    m = MovingLeastSquares(POINTS, wendland(3, 1), neighbors=8)
    path = np.linspace([0.1, 0.2], [0.9, 0.7], 4001)
    steps = np.abs(np.diff(m.field(VALUES)(path)))
    assert steps.max() < 2e-2
    jumping = MovingLeastSquares(POINTS, gaussian(1.0), neighbors=8).field(VALUES)(path)
    assert np.abs(np.diff(jumping)).max() > 3 * steps.max()


def test_n_minus_one_neighbours_equal_a_weight_of_radius_rho():
    """With neighbors = n - 1 the radius is ρ(x), the distance of the farthest site."""
    m = MovingLeastSquares(POINTS, wendland(3, 1), neighbors=29)
    x = np.array([0.4, 0.3])
    rho = np.linalg.norm(POINTS - x, axis=1).max()
    assert_close(
        m.field(VALUES)(x), MovingLeastSquares(POINTS, wendland(3, 1, rho)).field(VALUES)(x), EXACT
    )


def test_one_neighbour_gives_nearest_neighbour_interpolation():
    """The degree is 0."""
    m = MovingLeastSquares(POINTS, gaussian(1.0), 0, 1)
    x = np.random.default_rng(6).random((50, 2))
    assert_close(m.field(VALUES)(x), VALUES[cdist(x, POINTS).argmin(axis=1)], 1e-15)
    assert m.interpolates


def test_coincident_neighbours_are_accepted_with_degree_zero():
    """There may be more than `neighbors` coincident sites at the query itself."""
    p = np.concatenate([np.zeros((6, 2)), POINTS + 1])
    f = np.concatenate([np.full(6, 4.0), VALUES])
    m = MovingLeastSquares(p, wendland(3, 1), 0, 4)
    assert float(m.field(f)([0.0, 0.0])) == pytest.approx(4.0)
    assert float(m.objective(f, [0.0, 0.0])) == 0.0
    assert np.isfinite(m.matrix([0.0, 0.0])).all()


# --- orders of convergence ------------------------------------------------------------------------

SLACK = 0.3


def observed_order(sizes: list[float], errors: list[float]) -> float:
    """Slope of log error over log size, by least squares."""
    return float(np.polyfit(np.log(sizes), np.log(errors), 1)[0])


def require_order(sizes: list[float], errors: list[float], order: float) -> None:
    """The observed order must be at least this order minus the slack.

    Errors must exceed rounding.
    """
    assert min(errors) > 1e-12, "errors are rounding"
    assert observed_order(sizes, errors) > order - SLACK


@pytest.mark.parametrize("order", [1, 2, 3, 4])
def test_the_order_of_known_sequences_is_observed(order):
    """Sequences of lower order, growing errors and rounding errors are rejected."""
    sizes = [0.1, 0.05, 0.025]
    errors = [7 * h**order for h in sizes]
    assert observed_order(sizes, errors) == pytest.approx(order)
    require_order(sizes, errors, order)
    with pytest.raises(AssertionError):
        require_order(sizes, errors, order + 1)
    with pytest.raises(AssertionError):
        require_order(sizes, errors[::-1], order)
    with pytest.raises(AssertionError, match="rounding"):
        require_order(sizes, [1e-14, 1e-15, 1e-16], order)


@pytest.mark.parametrize("degree", [0, 1, 2, 3])
def test_errors_converge_with_the_order_of_the_degree(degree):
    """Levin (1998): order m + 1 for values and m for gradients, with k nearest Halton points."""
    a = np.array([2.0, 3.0])
    sizes, errors, slopes = [], [], []
    x = halton(200, 2) * 0.6 + 0.2
    for n in (500, 2000, 8000):
        p = halton(n, 2)
        s = MovingLeastSquares(p, wendland(3, 2), degree, 3 * dimension(2, degree) + 3).field(
            np.sin(p @ a)
        )
        sizes.append(n**-0.5)
        errors.append(np.sqrt(np.mean((s(x) - np.sin(x @ a)) ** 2)))
        slope = s.gradient(x) - np.cos(x @ a)[:, None] * a
        slopes.append(np.sqrt(np.mean(slope**2)))
    require_order(sizes, errors, degree + 1)
    if degree:
        require_order(sizes, slopes, degree)


@pytest.mark.parametrize(("d", "degree", "k"), [(2, 1, 12), (2, 2, 19), (3, 2, 28)])
@pytest.mark.parametrize("weight", [wendland(3, 2), gaussian(0.6)])
def test_gradients_are_nearly_as_accurate_as_by_qr(monkeypatch, weight, d, degree, k):
    """The error of a polynomial is at most 4 times that of Householder QR, at the worst query 12.

    Elimination without refinement has errors from 3 to 3000 times as large.
    """
    rng = np.random.default_rng(1)
    points, x = rng.random((1000, d)), 0.1 + 0.8 * rng.random((700, d))
    along = np.linspace(0.5, 1.0, d)
    exact = degree * (x @ along - 0.5)[:, None] ** (degree - 1) * along
    field = MovingLeastSquares(points, weight, degree, k).field((points @ along - 0.5) ** degree)

    def rms_and_largest() -> np.ndarray:
        error = abs(field.gradient(x) - exact)
        return np.array([np.sqrt(np.mean(error**2)), error.max()])

    ours = rms_and_largest()
    monkeypatch.setattr(weighted_least_squares, "_SAFE_PIVOT", np.inf)
    monkeypatch.setattr(weighted_least_squares, "_AMPLIFIED", 0.0)
    assert (ours <= np.array([4, 12]) * rms_and_largest()).all()


@pytest.mark.parametrize("weight", [inverse_square(0.1), wendland(2, 2)])
@pytest.mark.parametrize("axis", [0, 1])
def test_derivatives_on_flight_lines_are_exact_beside_their_weights(weight, axis):
    """Three lines with a jitter of a thousandth of their distance hardly determine a quadratic.

    The weights of a constant in the gradient sum to zero, beside weights of up to 4e7. Products
    with the large coefficients of the fits gave sums of 1e-9 of them, and second derivatives of
    x^2 wrong by 25.
    """
    rng = np.random.default_rng(0)
    k = np.arange(600)
    lines = np.column_stack(
        [k // 3 + 0.3 * rng.random(600), 50 * (k % 3) + 0.05 * rng.normal(size=600)]
    )
    points, x = lines, rng.uniform([30, 0], [170, 100], (200, 2))
    points, x = np.roll(points, axis, axis=1), np.roll(x, axis, axis=1)
    method = MovingLeastSquares(points, weight, degree=2, neighbors=20)
    for rows in method.gradient_weights(x):
        assert abs(rows.sum(axis=1)).max() < 1e-13 * abs(rows).sum(axis=1).max()
    hessian = method.field(points[:, axis] ** 2).hessian(x)
    assert abs(hessian - 2 * np.outer(*[np.eye(2)[axis]] * 2)).max() < 1e-3


def test_values_lose_few_digits_more_than_by_qr(monkeypatch):
    """Fourteen sites of 4000 neighbourhoods; some determinants are small.

    The weights differ from those of Householder QR by about 1e-13, without refinement by 4e-12.
    """
    rng = np.random.default_rng(0)
    points, x = rng.random((4000, 2)), rng.random((4000, 2))
    method = MovingLeastSquares(points, inverse_square(0.1), 2, 14)

    def differ_from_qr_by(determinant: float) -> float:
        monkeypatch.setattr(weighted_least_squares, "_SAFE_DETERMINANT", determinant)
        return float(abs(method.weights(x) - by_qr).sum(axis=1).max())

    with monkeypatch.context() as patch:
        patch.setattr(weighted_least_squares, "_SAFE_PIVOT", np.inf)
        by_qr = method.weights(x)
    refined = differ_from_qr_by(weighted_least_squares._SAFE_DETERMINANT)
    assert refined < 1e-12
    assert differ_from_qr_by(0.0) > 5 * refined


# --- refusals -------------------------------------------------------------------------------------


@pytest.mark.parametrize("bad", ["gaussian", None, lambda r: 1 / r, 0.1])
def test_weights_of_other_types_are_refused(bad):
    """Neither a name nor a number is accepted."""
    with refused(r"weight must be a radial function such as inverse_square\(0\.1\); got "):
        MovingLeastSquares(POINTS, bad)


class Unordered(polyharmonic):
    """A power of r that does not state its order."""

    order = 0


@pytest.mark.parametrize(
    "growing", [thin_plate_spline(), polyharmonic(1), multiquadric(0.3), Unordered(1)], ids=repr
)
def test_growing_kernels_are_refused_as_weights(growing):
    """The farthest site would have the largest weight."""
    with refused(
        rf"weight must be positive and fall with the distance; {re.escape(repr(growing))}"
    ):
        MovingLeastSquares(POINTS, growing)


@pytest.mark.parametrize("bad", [0, -1, 30, 31, 2.0, True, "5"])
def test_invalid_numbers_of_neighbours_are_refused(bad):
    """There must be one more site, which determines the radius."""
    with refused("neighbors must be an integer from 1 to 29, fewer than the 30 points, or None"):
        MovingLeastSquares(POINTS, wendland(3, 1), neighbors=bad)


def test_a_query_without_sites_in_reach_is_named():
    """The message has the number of sites with weight and the rank of their polynomials."""
    m = MovingLeastSquares(POINTS, wendland(3, 1, 0.3))
    words = r"the 0 sites that count at the query \(5, 0\.5\) do not determine .* rank 0 of 3"
    for evaluate in (m.field(VALUES), m.field(VALUES).gradient, m.weights):
        for queries in ([[0.5, 0.5], [5.0, 0.5]], [[5.0, 0.5]]):
            with refused(words, np.linalg.LinAlgError):
                evaluate(queries)


def test_a_query_with_collinear_neighbours_is_named():
    """All sites together are unisolvent, but the neighbours of the query are not."""
    line = np.stack([np.linspace(0, 1, 20), np.zeros(20)], axis=1)
    elsewhere = POINTS + np.array([0.0, 5.0])
    m = MovingLeastSquares(np.vstack([line, elsewhere]), wendland(3, 1), neighbors=6)
    words = r"the 6 sites that count at the query \(0\.5, 0\) do not .*: rank 2 of 3"
    with refused(words, np.linalg.LinAlgError):
        m.field(np.ones(50))([0.5, 0.0])


def test_sites_within_a_support_that_lie_on_a_line_up_to_rounding_are_refused():
    """Their coordinates, a million away, are rounded by 1e-7 of the length of the line."""
    line = 1e-3 * np.outer(np.arange(10.0), [0.1, 0.1 / 3])
    points = np.vstack([line, 1 + 1e-3 * POINTS]) + 1e6
    m = MovingLeastSquares(points, wendland(2, 1, 2e-3))
    assert_close(m.weights(points[10:]).sum(axis=1), np.ones(30), EXACT)
    with refused("the 10 sites that count .* do not .*: rank 2 of 3", np.linalg.LinAlgError):
        m.weights(points[[20, 4, 30]])


def test_a_query_is_not_refused_for_the_number_of_others():
    """Two rows of sites, a thousand roundings apart, determine a plane to three digits."""
    i = np.arange(10.0)
    rows = np.column_stack([i / 8, i / 8 + 2.0**-42 * (i % 2)])
    points = np.vstack([rows, 5 + POINTS])
    s = MovingLeastSquares(points, wendland(2, 1, 2.0)).field(points @ [1.0, 2.0])
    assert_close(s(np.full((5000, 2), 0.4)), np.full(5000, 1.2), 1e-3)


def test_points_on_a_line_are_refused_before_any_query():
    """No query could be evaluated."""
    with refused("the points do not determine a polynomial of degree 1", np.linalg.LinAlgError):
        MovingLeastSquares(np.outer(np.arange(9.0), [1, 2]), inverse_square(0.1))


def test_the_first_query_too_far_away_is_named():
    """The squares of its distances from the sites are no numbers."""
    s = MovingLeastSquares(POINTS, inverse_square(0.1)).field(VALUES)
    with refused(r"the query \(1e\+200, 0\) is too far away", OverflowError):
        s([[0.5, 0.5], [1e200, 0.0], [0.0, 1e250]])


def test_overflow_of_matrix_and_objective_is_refused():
    """H at a site is infinite for ε = 0, and squares overflow in extreme units.

    The value is accurate.
    """
    m = MovingLeastSquares(POINTS, inverse_square(0.0))
    with refused("the weights in H_MLS exceed the range of floating-point numbers", OverflowError):
        m.matrix(POINTS[:1])
    small = MovingLeastSquares(POINTS * 1e-150, inverse_square(1e-151))
    assert np.isfinite(small.field(VALUES)(POINTS[:2] * 1e-150)).all()
    with refused("exceeds|would leave", OverflowError):
        small.matrix(POINTS[:1] * 1e-150)
    for unit in (1e-150, 1e150):
        m = MovingLeastSquares(POINTS * unit, inverse_square(unit))
        with refused("the squares of residuals of size .* do not fit", OverflowError):
            m.objective(VALUES, POINTS[:2] * unit)


def test_dense_weights_beyond_the_limit_are_refused():
    """The message has their size. Weights on neighbours are sparse and have no limit."""
    p = np.random.default_rng(7).random((20_000, 2))
    x = np.broadcast_to(np.zeros(2), (20_000, 2))
    with refused("GiB; use field", MemoryError):
        MovingLeastSquares(p, inverse_square(0.1)).weights(x)
    h = MovingLeastSquares(p, wendland(3, 1), neighbors=10).weights(p)
    assert h.shape == (20_000, 20_000)
    assert h.nnz == 200_000


def test_a_point_of_many_coordinates_is_abbreviated():
    """The message has the first three of fifty coordinates, and their number."""
    x = np.random.default_rng(1).random((60, 50))
    s = MovingLeastSquares(x, wendland(3, 1), 1, 40).field(x[:, 0])
    words = r"at the query \(0\.5, 0\.5, 0\.5, … of 50 coordinates\) do not determine"
    with pytest.raises(np.linalg.LinAlgError, match=words):
        s(np.full(50, 0.5))


def test_second_derivatives_at_a_site_are_refused_for_a_weight_with_a_corner():
    """Away from the sites they exist; for weights with two derivatives also at sites, as limits."""
    points = halton(60, 2)
    values = points[:, 0] ** 2
    for weight in (matern(0.5, 0.3), matern(1.0, 0.3)):
        corner = MovingLeastSquares(points, weight).field(values)
        assert np.isfinite(corner.hessian(points[:3] + 1e-3)).all()
        with refused("has no second derivatives at a site"):
            corner.hessian(points[3])
    for weight in (gaussian(0.5), wendland(3, 1, 0.8)):
        hessian = MovingLeastSquares(points, weight).field(values).hessian
        assert_close(hessian(points[3]), hessian(points[3] + 1e-7), 1e-4)


def test_a_single_site_counts_within_its_support():
    """Beyond it no site counts, which is refused in words."""
    field = MovingLeastSquares([[0.0, 0.0]], wendland(2, 1), degree=0).field([3.0])
    assert field([0.5, 0.0]) == 3
    with refused("the 0 sites that count at the query"):
        field([[0.5, 0.0], [2.0, 0.0]])


def test_predictions_within_a_support_use_all_samples_but_one():
    """They equal those of a method made without this sample."""
    x, weight = halton(60, 2), wendland(2, 1, 0.5)
    f = np.sin(5 * x[:, 0]) + x[:, 1]
    sites = np.array([3, 17, 40])
    predicted = MovingLeastSquares(x, weight).predictions_from_others(f[:, None], sites)[:, 0]
    others = [
        MovingLeastSquares(np.delete(x, i, 0), weight).field(np.delete(f, i))(x[i]) for i in sites
    ]
    assert_close(predicted, np.array(others), 1e-12)
