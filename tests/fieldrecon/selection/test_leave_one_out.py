"""Leave-one-out residuals equal those of refits, also where the closed form loses digits."""

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

import high_precision
from fieldrecon.kernels.conditionally_positive_definite import polyharmonic, thin_plate_spline
from fieldrecon.kernels.positive_definite import gaussian, matern, wendland
from fieldrecon.kernels.weights import inverse_square
from fieldrecon.methods.functionals import derivatives_at, laplacians_at, values_at
from fieldrecon.methods.hermite import HermiteRBF
from fieldrecon.methods.least_squares import LeastSquares
from fieldrecon.methods.moving_least_squares import MovingLeastSquares
from fieldrecon.methods.natural_splines import NaturalCubicSpline
from fieldrecon.methods.rbf import RBF
from fieldrecon.reconstruction import Reconstruction
from fieldrecon.selection.leaving_one_out import leave_one_out
from laws import assert_close, refused

POINTS = np.random.default_rng(1).random((16, 2))
VALUES = np.cos(POINTS @ [3.0, 2.0])


def without(i: int) -> np.ndarray:
    return np.delete(np.arange(len(POINTS)), i)


@pytest.mark.parametrize("degree", [0, 1, 2])
@pytest.mark.parametrize("epsilon", [0.0, 1e-8, 1e-4, 1e-3, 1e-2, 0.1, 1.0])
def test_mls_residuals_are_accurate_for_small_epsilon(epsilon, degree):
    """For tiny ε the closed form divides by 1 - h_ii, which has lost all its digits.

    The reference is a refit in high precision.
    """
    m = MovingLeastSquares(POINTS, inverse_square(epsilon), degree)
    residuals = leave_one_out(m, VALUES)
    weight = high_precision.inverse_square(epsilon)
    for i in (0, 5, 15):
        k = without(i)
        s = float(high_precision.moving(POINTS[k], VALUES[k], POINTS[i], weight, degree))
        assert_close(residuals[i], VALUES[i] - s, 1e-10)


@pytest.mark.slow
@pytest.mark.parametrize("smoothing", [pytest.param(0.0, marks=pytest.mark.slow), 0.1])
def test_rbf_residuals_are_accurate(smoothing):
    """Rippa's formula λ_i / (H⁻¹)_ii agrees with a refit in 500 digits."""
    residuals = leave_one_out(RBF(POINTS, thin_plate_spline(), smoothing=smoothing), VALUES)
    for i in (0, 5, 15):
        k = without(i)
        solution = high_precision.rbf_coefficients(
            POINTS[k], VALUES[k], high_precision.thin_plate, 1, smoothing
        )
        s = float(high_precision.rbf(POINTS[k], solution, POINTS[i], high_precision.thin_plate, 1))
        assert_close(residuals[i], VALUES[i] - s, 1e-12)


@pytest.mark.parametrize("far", [1e3, 1e5, 1e7])
def test_the_residual_of_a_distant_point_is_accurate(far):
    """The leverage of the point is almost one, so the closed form would lose its digits."""
    p, f = np.vstack([POINTS, [[far, far]]]), np.append(VALUES, 1.0)
    residuals = leave_one_out(LeastSquares(p), f)
    expected = 1.0 - float(LeastSquares(POINTS).field(VALUES)([far, far]))
    assert residuals[-1] == pytest.approx(expected, rel=1e-12)


def test_residuals_of_two_close_sites_are_accurate():
    """Each of the two is predicted by the other, although the diagonal of H⁻¹ is huge."""
    p = np.vstack([POINTS, POINTS[3] + 1e-7])
    plane = 1 + p @ [2.0, -3.0]
    for m in (RBF(p, thin_plate_spline()), RBF(p, polyharmonic(3))):
        assert_close(leave_one_out(m, plane)[[3, 16]], np.zeros(2), 1e-6)


def test_residuals_have_the_shape_and_type_of_the_data():
    """The shape is (n, *v); complex data have complex residuals."""
    f = np.stack([VALUES, 1j * VALUES], axis=1)[:, :, None]
    for m in (
        LeastSquares(POINTS),
        MovingLeastSquares(POINTS, inverse_square(0.0)),
        MovingLeastSquares(POINTS, wendland(3, 1), neighbors=8),
        RBF(POINTS, gaussian(0.2)),
    ):
        e = leave_one_out(m, f)
        assert e.shape == (16, 2, 1)
        assert_close(e[:, 0, 0], leave_one_out(m, VALUES), 1e-12)
        assert_close(e[:, 1, 0], 1j * leave_one_out(m, VALUES), 1e-12)


def test_leave_one_out_selects_a_good_epsilon():
    """The ε with the least leave-one-out error has nearly the least true error.

    The ε that minimizes ψ_MLS does not.
    """
    p = np.random.default_rng(3).random((150, 2))
    x = np.random.default_rng(4).random((200, 2))

    def truth(y):
        return np.sin(y @ [5.0, 3.0])

    f = truth(p) + 0.2 * np.random.default_rng(5).standard_normal(150)
    epsilons = [0.01, 0.03, 0.1, 0.2, 0.3, 1.0, 10.0]
    methods = [MovingLeastSquares(p, inverse_square(e)) for e in epsilons]
    true = [np.sqrt(np.mean((m.field(f)(x) - truth(x)) ** 2)) for m in methods]
    left_out = [np.mean(leave_one_out(m, f) ** 2) for m in methods]
    psi = [m.objective(f, x).mean() for m in methods]
    assert true[int(np.argmin(left_out))] < 1.3 * min(true)
    assert true[int(np.argmin(psi))] > 1.5 * min(true)


# --- splines and data of other kinds --------------------------------------------------------------


@pytest.mark.parametrize("n", [3, 4, 5, 60])
def test_residuals_of_splines(n):
    """By a spline without each site, in any order and unit, and by SciPy's; in O(n)."""
    x = np.random.default_rng(n).random(n) ** 3 * 1e150
    f = np.stack([np.sin(1e-149 * x), 1j * x / 1e150], axis=1)
    residuals = leave_one_out(NaturalCubicSpline(x), f)
    for i in range(0, n, 7):
        others = np.arange(n) != i
        refit = NaturalCubicSpline(x[others]).field(f[others])
        assert_close(residuals[i], f[i] - refit(x[i]), 1e-9)
    order = np.argsort(x)
    middle = order[n // 2]
    others = order[order != middle]
    if n > 3:
        spline = CubicSpline(x[others] / 1e150, f[others, 0].real, bc_type="natural")
        assert_close(residuals[middle, 0].real, f[middle, 0].real - spline(x[middle] / 1e150), 1e-9)


def test_two_sites_of_a_spline_are_indispensable():
    """One site does not determine a line."""
    with refused(r"without point 0, \(1\), the others do not", np.linalg.LinAlgError):
        leave_one_out(NaturalCubicSpline([1.0, 2.0]), [0.0, 1.0])


def test_residuals_of_data_of_any_kind():
    """Values, derivatives and Laplacians, in a unit of 1e-3: each by a fit to all the others."""
    points = POINTS * 1e-3
    kinds = [
        values_at(points[:8]),
        derivatives_at(points[4:12], [1.0, 2.0]),
        laplacians_at(points[8:]),
    ]
    data = np.random.default_rng(2).standard_normal(24) * np.repeat([1.0, 1e3, 1e6], 8)
    method = HermiteRBF(kinds, matern(5.5, 1e-4))
    residuals = leave_one_out(method, data)
    for i in range(0, 24, 5):
        others = np.arange(24) != i
        refit = HermiteRBF(method.functionals[others], method.kernel).field(data[others])
        expected = data[i] - refit.apply(method.functionals[i : i + 1])[0]
        assert_close(residuals[i] / expected, 1.0, 1e-7)
    slopes = derivatives_at([[0.0], [1.0]], [1.0])
    for kinds, i, place in (
        ([values_at([[0.0]]), slopes], 0, "0"),
        ([slopes, values_at([[2.0]])], 2, "2"),
    ):
        words = rf"without point {i}, \({place}\), the others do not .* rank 1 of 2"
        with refused(words, np.linalg.LinAlgError):
            leave_one_out(HermiteRBF(kinds, polyharmonic(3)), np.ones(3))


# --- refusals -------------------------------------------------------------------------------------

CORNER = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
LONE = np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [0.5, 1.0]])


@pytest.mark.parametrize(
    ("method", "i", "place"),
    [
        (LeastSquares(CORNER), 0, "0, 0"),
        (RBF(CORNER, thin_plate_spline()), 0, "0, 0"),
        (LeastSquares(LONE), 3, "0.5, 1"),
        (RBF(LONE, thin_plate_spline()), 3, "0.5, 1"),
        (RBF(LONE, thin_plate_spline(), smoothing=1.0), 3, "0.5, 1"),
        (LeastSquares([[1.0]], 0), 0, "1"),
        (RBF([[1.0]], polyharmonic(1)), 0, "1"),
    ],
)
def test_an_indispensable_point_is_named(method, i, place):
    """Without this point the others do not determine the polynomial."""
    words = rf"without point {i}, \({place}\), the others do not determine the field: the"
    with refused(words, np.linalg.LinAlgError):
        leave_one_out(method, np.ones(len(method.points)))


@pytest.mark.parametrize("weight", [inverse_square(0.1), inverse_square(0.0)])
def test_mls_names_the_query_without_enough_neighbours(weight):
    """The message has the number of sites that count at the query, and the rank."""
    words = r"the 3 sites that count at the query \(0.5, 1\) do not determine .* rank 2 of 3"
    with refused(words, np.linalg.LinAlgError):
        leave_one_out(MovingLeastSquares(LONE, weight), np.ones(4))


def test_the_residual_of_a_single_gaussian_is_its_datum():
    """Without polynomials the interpolant of zero sites is zero."""
    assert leave_one_out(RBF([[1.0]], gaussian(1.0)), [3.0]).tolist() == [3.0]


def test_leave_one_out_needs_two_more_points_than_neighbors():
    """Besides k neighbours there must be the (k+1)-th site and the point left out."""
    m = MovingLeastSquares(POINTS, wendland(3, 1), neighbors=15)
    with refused("to leave one point out, neighbors=15 needs 17 points: .*; got 16"):
        leave_one_out(m, VALUES)
    assert leave_one_out(MovingLeastSquares(POINTS, wendland(3, 1), neighbors=14), VALUES).all()


@pytest.mark.parametrize(("degree", "neighbors"), [(0, 1), (1, 6), (2, 12)])
def test_residuals_of_the_nearest_sites_equal_refits(degree, neighbors):
    """Where a site is left out another one is among the nearest; four of the sites coincide."""
    which = [0, 0, 0, *range(16)]
    p, f = POINTS[which], VALUES[which]
    residuals = leave_one_out(MovingLeastSquares(p, gaussian(0.8), degree, neighbors), f)
    for i in range(len(p)):
        rest = np.delete(p, i, axis=0)
        s = MovingLeastSquares(rest, gaussian(0.8), degree, neighbors).field(np.delete(f, i))
        assert_close(residuals[i], f[i] - s(p[i]), 1e-11)


def test_data_of_another_length_are_refused():
    with refused(r"values must have one entry for each point, shape \(16, ...\); got \(3,\)"):
        leave_one_out(LeastSquares(POINTS), [1.0, 2.0, 3.0])


class NearestSites(Reconstruction):
    """Nearest-neighbour interpolation: a method without a closed form for leave-one-out."""

    degree, interpolates = 0, True

    def __init__(self, points, power=1, *, progress=None):  # noqa: ARG002
        self.points, self.power = np.asarray(points), power

    def _weight_rows(self, x):
        nearest = np.argmin(np.linalg.norm(x[:, None] - self.points, axis=2), axis=1)
        return np.eye(len(self.points))[nearest]

    def _gradient_weight_rows(self, x):
        return tuple(np.zeros((len(x), len(self.points))) for _ in x.T)


def test_other_methods_are_refitted_without_each_point():
    """`progress` reports one refit per point."""
    counts = []
    residuals = leave_one_out(
        NearestSites(POINTS), VALUES, progress=lambda *count: counts.append(count)
    )
    distance = np.linalg.norm(POINTS[:, None] - POINTS, axis=2) + 9 * np.eye(16)
    assert_close(residuals, VALUES - VALUES[np.argmin(distance, axis=1)], 0)
    assert counts == [(i + 1, 16) for i in range(16)]


def test_two_points_predict_each_other_and_one_has_no_others():
    """With a single point there is nothing to make the method again from."""
    assert leave_one_out(NearestSites(POINTS[:2]), [5.0, 3.0]).tolist() == [2.0, -2.0]
    with refused("without point 0, .* determine the field: there are none", np.linalg.LinAlgError):
        leave_one_out(NearestSites(POINTS[:1]), [5.0])


def test_a_method_must_keep_its_arguments_as_attributes():
    """Otherwise it cannot be constructed again from the other points."""
    method = NearestSites(POINTS)
    del method.power
    with refused("NearestSites keeps no attribute 'power'", TypeError):
        leave_one_out(method, VALUES)


def test_an_argument_that_is_not_a_reconstruction_is_refused():
    with refused("method must be a Reconstruction; got 3", TypeError):
        leave_one_out(3, VALUES)
