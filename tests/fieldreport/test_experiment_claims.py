"""Claims of the experiments, compared with values known independently of the library."""

import numpy as np
import pytest

from fieldrecon import RBF, MovingLeastSquares, wendland
from fieldrecon.datasets.synthetic import franke, halton, jittered_grid, power_of_sum
from fieldrecon.kernels.weights import inverse_square
from fieldreport import experiments
from fieldreport.experiments.kernels import kernel_comparison
from fieldreport.experiments.methods import (
    epsilon_sweep,
    normal_equations,
    power_sampling,
    weight_shapes,
)
from fieldreport.framework.orders_of_magnitude import OrderOfMagnitude

pytestmark = pytest.mark.slow  # experiments are run

ROUNDING = 1e-13


@pytest.fixture(scope="module")
def powers():
    return experiments.get("power_sampling").run(power_sampling.Params(draws=200))


@pytest.fixture(scope="module")
def sweep():
    return experiments.get("epsilon_sweep").run(epsilon_sweep.Params(draws=5, queries=60, steps=13))


@pytest.fixture(scope="module")
def shapes():
    return experiments.get("weight_shapes").run(
        weight_shapes.Params(steps=9, relief_side=8, draws=1, fine=20)
    )


@pytest.fixture(scope="module")
def kernels():
    return experiments.get("kernel_comparison").run(
        kernel_comparison.Params(sizes=(50, 100, 200), parts=1)
    )


@pytest.mark.parametrize("n", range(1, 9))
def test_the_closed_form_of_the_best_linear_fit_agrees_with_quadrature(n):
    """It is the least-squares residual on a tensor grid of Gauss points."""
    nodes, weights = np.polynomial.legendre.leggauss(12)
    x = np.stack(np.meshgrid(nodes, nodes), axis=-1).reshape(-1, 2) / 2 + 0.5
    root = np.sqrt(np.outer(weights, weights).ravel() / 4)
    basis, field = np.column_stack([np.ones(len(x)), x]), power_of_sum(n)(x)
    residual = (
        root * field
        - root[:, None] * basis @ np.linalg.lstsq(root[:, None] * basis, root * field)[0]
    )
    assert power_sampling.best_linear_rms(n) == pytest.approx(np.linalg.norm(residual), abs=1e-12)


def test_least_squares_is_close_to_the_best_linear_fit(powers):
    """With 100 points its error is larger by a few per cent only."""
    assert 0 < powers.facts["largest_excess_percent"] < 8


def test_moving_least_squares_is_ten_times_more_accurate(powers):
    """The ratio of the errors is about ten for curved fields, and nearly every draw agrees."""
    assert powers.facts["mls_better_percent"] > 99
    assert 8 < powers.facts["smallest_ratio"] <= powers.facts["largest_ratio"] < 16
    assert powers.facts["rms_where_both_exact"] < ROUNDING


def test_moving_least_squares_agrees_with_a_weighted_fit_by_numpy(powers, monkeypatch):
    """The test detects weights that are not squared."""
    assert powers.facts["difference_from_lapack"] < ROUNDING
    params = power_sampling.QUICK

    class Unsquared(inverse_square):
        def of_squared(self, s):
            return np.sqrt(super().of_squared(s))

        def in_units(self, h):
            return Unsquared(self.epsilon / h)

    monkeypatch.setattr(power_sampling, "inverse_square", Unsquared)
    assert power_sampling._difference_from_lapack(params) > 1e-3


def test_raw_psi_decreases_with_epsilon(sweep):
    """It decreases for every draw; scaled by ε⁴ it tends to the residual of least squares."""
    assert sweep.facts["psi_falls_percent"] == 100
    assert sweep.facts["scaled_psi_difference_percent"] < 0.1
    assert np.all(sweep.arrays["chosen_psi"] == sweep.params.largest)


def test_only_leave_one_out_selects_epsilon_with_noise(sweep):
    """The regret is the error with the selected ε relative to the least error."""
    regret = {
        key: sweep.arrays[f"regret_{key}"] for key in ("psi", "normalized_psi", "leave_one_out")
    }
    assert all(np.all(r >= 1) for r in regret.values())
    assert sweep.facts["regret_psi_exact"] > 8
    assert sweep.facts["regret_normalized_psi_noisy"] > 1.4
    assert sweep.facts["regret_leave_one_out_exact"] < 1.05
    assert sweep.facts["regret_leave_one_out_noisy"] < 1.15


def test_the_best_epsilon_for_exact_data_is_small(sweep):
    """The error is constant below a tenth of the spacing; the gradient is best near the spacing."""
    assert sweep.facts["largest_epsilon_within_1_percent"] >= 0.1 * sweep.facts["spacing"] * 0.99
    assert sweep.facts["best_epsilon_gradient_exact"] == pytest.approx(0.1, rel=0.9)


def test_mls_of_degree_zero_is_flat_at_every_site(shapes):
    """The remaining slope agrees with its leading term of order ε⁴; degree 1 keeps the slope."""
    assert shapes.facts["slope_difference_percent"] < 1
    assert shapes.facts["slope_kept_constant_smallest"] < 1e-6
    assert shapes.facts["slope_kept_linear_smallest"] > 0.5


def test_a_large_epsilon_does_not_improve_mls_of_degree_one(shapes):
    """The error is smallest at the smallest ε and grows with ε."""
    error = shapes.arrays["error"][1]
    assert np.all(np.diff(error) > -1e-6)
    assert error[-1] > 5 * error[0]


def test_kernels_agree_with_scipy(kernels):
    """Four kernels are compared with scipy.interpolate.RBFInterpolator."""
    assert kernels.facts["difference_from_scipy"] < 1e-10


def test_the_interpolation_matrix_agrees_with_the_library():
    """Its condition number is measured in the experiment."""
    x = halton(20, 2)
    for kernel in kernel_comparison.QUICK.kernels.values():
        np.testing.assert_allclose(
            kernel_comparison.interpolation_matrix(kernel, x), RBF(x, kernel).matrix(), atol=1e-12
        )


def test_affine_data_are_reproduced_only_with_polynomials_of_degree_one(kernels):
    """Thin-plate spline and cubic kernel contain them by default, other kernels do not."""
    for _, order, _, error, with_plane in kernels.tables["affine"].rows:
        assert with_plane < ROUNDING * 10
        assert (error < ROUNDING * 10) == (order == 2)


def test_the_thin_plate_spline_grows_linearly_far_away(kernels):
    """Without the side conditions it grows like its kernel r² log r²."""
    assert kernels.facts["far_plate_growth"] < 1.2
    assert kernels.facts["far_plate_loose_growth"] > 2
    assert kernels.arrays["far_gaussian"][-1] == 0


def test_orders_depend_on_the_sequence_of_points():
    """By more than the digits of one fit; a point in the corner alone changes order and error."""
    params = kernel_comparison.Params(sizes=(50, 100, 200, 400), parts=8)
    kernels = experiments.get("kernel_comparison").run(params)
    for kernel, smooth in (("linear", 2.5), ("thin_plate", 3.0), ("cubic", 3.4)):
        least, most = (kernels.facts[f"order_{kernel}_{which}"] for which in ("least", "most"))
        assert least <= kernels.facts[f"order_{kernel}_first"] <= most
        assert least < smooth < most
    assert kernels.facts["order_cubic_corner"] > kernels.facts["order_cubic_first"] + 0.5
    assert min(kernels.facts[f"corner_gain_{k}"] for k in ("cubic", "multiquadric")) > 2


def test_the_parts_of_the_halton_sequence_share_no_point():
    """A point of two parts would count twice in their median; no part contains the corner."""
    for params in (kernel_comparison.Params(), kernel_comparison.QUICK):
        n = params.sizes[-1]
        x = np.concatenate([halton(start + n, 2)[start:] for start in params.starts])
        assert len(np.unique(x, axis=0)) == params.parts * n
        assert np.linalg.norm(x, axis=1).min() > 0


def test_errors_below_the_largest_certain_condition_have_their_digits():
    """Another order of the points is another route, and changes errors of the Gaussian only."""
    x, queries = halton(801, 2)[1:], halton(300, 2)
    shuffled = x[np.random.default_rng(0).permutation(len(x))]
    for name, certain in (("multiquadric", True), ("gaussian", False)):
        kernel = kernel_comparison.QUICK.kernels[name]
        fields = [RBF(y, kernel).field(franke(y)) for y in (x, shuffled)]
        error, again = (np.std(s(queries) - franke(queries)) for s in fields)
        matrix = kernel_comparison.interpolation_matrix(kernel, x)
        assert (np.linalg.cond(matrix) < kernel_comparison.CERTAIN) == certain
        assert (abs(again / error - 1) < 1e-4) == certain


def test_smoother_kernels_have_worse_condition(kernels):
    """Among polyharmonic kernels a higher power has a smaller error and a larger condition."""
    errors = [kernels.facts[f"error_{k}"] for k in ("linear", "thin_plate", "cubic")]
    conditions = [kernels.facts[f"condition_{k}"] for k in ("linear", "thin_plate", "cubic")]
    assert errors == sorted(errors, reverse=True)
    assert conditions == sorted(conditions)


def test_singular_normal_equations_are_reported_in_the_table(monkeypatch):
    """Far from the origin, rounding decides whether they are singular; both cases have a result."""

    def far_is_singular(points, values, solve=normal_equations.normal_equations):
        if points.min() > 1e7:
            raise np.linalg.LinAlgError
        return solve(points, values)

    monkeypatch.setattr(normal_equations, "normal_equations", far_is_singular)
    params = normal_equations.Params(side=5, queries=5, decades=(6, 8))
    result = experiments.get("normal_equations").run(params)
    near, far = result.tables["offsets"].column("error, normal equations")[-2:]
    assert (type(near), far) == (OrderOfMagnitude, "singular")
    normal_equations.plot(result)


def test_the_gradient_of_the_nearest_samples_jumps():
    """Where another sample becomes the (k + 1)-th nearest: the field is continuous, no more."""
    points = np.array([[0.0], [1.0], [2.2], [3.1], [4.6]])
    method = MovingLeastSquares(points, wendland(1, 1), degree=1, neighbors=3)
    s = method.field(np.sin(2 * points[:, 0]))
    left, right = np.array([2.3 - 1e-7]), np.array([2.3 + 1e-7])  # as far from 0 as from 4.6
    assert s(left) == pytest.approx(s(right), abs=1e-6)
    assert abs(s.gradient(left) - s.gradient(right)) > 0.05
    assert abs(s.gradient(left - 0.1) - s.gradient(right - 0.1)) < 1e-5


def test_a_finer_grid_finds_no_more_bumps():
    """The count converges; a grid with one point per ε loses a part of the extrema."""
    grids = ((1, 5), (3, 10), (5, 15))
    for ratio in (0.1, 0.5):
        params = (
            weight_shapes.Params(
                draws=1, fine=20, points_per_epsilon=per_epsilon, points_per_spacing=per_spacing
            )
            for per_epsilon, per_spacing in grids
        )
        coarse, usual, fine = (weight_shapes.bumps_and_errors(p, (ratio, 0))[0] for p in params)
        assert abs(usual / fine - 1) < 0.05
        assert coarse < 0.95 * usual


def test_curvatures_are_derivatives_of_the_slope():
    """Of the field and of the truth: by differences along a short line."""
    params, step = weight_shapes.QUICK, 1e-6
    sites = jittered_grid(params.side, 2, params.jitter, params.seed)
    s = weight_shapes._field(params, sites, 0, 0.5)
    x, ahead = np.random.default_rng(0).random((20, 2)), step * np.array([0.6, 0.8])
    for gradient, second in (
        (s.gradient, s.hessian),
        (franke.gradient, weight_shapes.second_derivatives),
    ):
        rise = (gradient(x + ahead) - gradient(x - ahead)) / (2 * step)
        np.testing.assert_allclose(second(x) @ ahead / step, rise, atol=1e-5 * abs(rise).max())


def test_bumps_occur_with_either_basis():
    """More extrema than the field has, and an ε of the spacing removes most with either basis."""
    params = weight_shapes.Params(steps=3, relief_side=8, draws=2, fine=80)
    facts = experiments.get("weight_shapes").run(params).facts
    assert facts["extrema_true"] == 3
    for basis in ("constant", "linear"):
        counts = [facts[f"extrema_{basis}_{name}"] for name in weight_shapes.JUDGED]
        assert counts == sorted(counts, reverse=True)
        assert counts[0] >= 10 > 6 >= counts[2]
        assert (
            facts[f"curvature_error_{basis}_tenth"] > 3 * facts[f"curvature_error_{basis}_spacing"]
        )
    assert 2 < facts["slope_constant_over_linear"] < facts["curvature_constant_over_linear"] < 5
    assert facts["error_linear_ratio"] > 2
