"""Experiments on splines, kernels and Hermite data, compared with independent values."""

import numpy as np
import pytest

from fieldrecon.methods.functionals import values_at
from fieldreport import experiments
from fieldreport.experiments.kernels import cpd_kernels, mairhuber_curtis
from fieldreport.experiments.methods import hermite_data, natural_splines

pytestmark = pytest.mark.slow  # experiments are run


@pytest.fixture(scope="module")
def splines():
    return natural_splines.run(natural_splines.Params()).facts  # unrounded


@pytest.fixture(scope="module")
def exchange():
    return mairhuber_curtis.run(mairhuber_curtis.Params())  # unrounded facts


@pytest.fixture(scope="module")
def kernels():
    return experiments.get("cpd_kernels").run()


@pytest.fixture(scope="module")
def other_data():
    params = hermite_data.Params(sizes=(8, 11, 14))
    return hermite_data.run(params).facts  # unrounded


def test_the_natural_spline_has_the_least_energy(splines):
    """Its energy and that of the difference sum to the energy of the sine (Pythagoras)."""
    assert splines["energy_not_a_knot_ratio"] > 1
    assert splines["energy_polynomial_ratio"] > 1
    assert splines["energy_natural"] == pytest.approx(splines["energy_by_coefficients"], rel=1e-9)
    total = splines["energy_natural"] + splines["energy_rest"]
    assert total == pytest.approx(splines["energy_function"], rel=1e-8)
    assert splines["pythagoras_defect"] <= 1e-9


def test_the_energy_of_the_sine_agrees_with_quadrature():
    """The closed form is compared with Gauss quadrature."""
    nodes, weights = np.polynomial.legendre.leggauss(60)
    x = 0.2 + 0.3 * (nodes + 1)
    integral = 0.3 * weights @ (81 * np.sin(9 * x)) ** 2
    assert natural_splines.energy_of_sine(9.0, 0.2, 0.8) == pytest.approx(integral, rel=1e-12)


def test_natural_splines_have_the_predicted_orders_and_decay(splines):
    """Order four inside, two at the ends, where s'' = 0 is wrong; influence decays by 2 - √3."""
    assert splines["order_middle"] == pytest.approx(4, abs=0.1)
    assert splines["order_ends"] == pytest.approx(2, abs=0.1)
    assert splines["decay"] == pytest.approx(2 - 3**0.5, rel=1e-6)
    assert splines["difference_from_scipy"] <= 1e-13
    assert abs(splines["outside_natural"] - splines["outside_scipy"]) > 1


def test_the_linear_determinant_changes_sign_at_collinear_points(exchange):
    """The time agrees with its closed form; the points never coincide during the exchange."""
    facts = exchange.facts
    assert facts["ratio_linear"] == pytest.approx(-1)
    assert facts["ratio_quadratic"] == pytest.approx(-1)
    assert facts["ratio_gaussians"] == pytest.approx(1)
    assert facts["ratio_thin_plates"] == pytest.approx(1)
    assert facts["time_linear"] == pytest.approx(facts["time_linear_exact"], abs=1e-9)
    assert facts["closest"] > 0.05
    gaussians, plates = exchange.arrays["curves"][2:]
    assert (gaussians > 0).all()
    assert (plates < 0).all()
    assert "rank 2 of 3" in facts["refusal"]


def test_six_points_on_a_conic_make_the_quadratic_matrix_singular(exchange):
    """When the determinant vanishes, a conic passes through all six points."""
    points = mairhuber_curtis.exchanged(
        exchange.params.rise, mairhuber_curtis.OTHERS, exchange.facts["time_quadratic"]
    )
    x, y = points.T
    b = np.column_stack([np.ones(6), x, y, x * x, x * y, y * y])
    assert np.linalg.svd(b, compute_uv=False)[-1] < 1e-8
    assert np.linalg.svd(b, compute_uv=False)[-2] > 1e-2


def test_every_kernel_has_its_order_of_positive_definiteness(kernels):
    """Positive with the side conditions of its order and not below; inertia (n, q, 0) for all."""
    facts = kernels.facts
    assert facts["least_of_all"] > 0 > facts["largest_below"]
    assert facts["as_predicted"] == facts["kernels"] == 11
    assert (facts["alone_positive"], facts["alone_negative"]) == (23, 1)


def test_counterexamples_show_that_each_premise_is_needed(kernels):
    """Collinear points, an even power, and a cone in the plane with least eigenvalue -0.105."""
    facts = kernels.facts
    assert facts["size_on_a_line"] - facts["rank_on_a_line"] == 1
    assert facts["residual_on_a_line"] <= 1e-12
    assert facts["free_kernels"] <= 1e-12
    assert facts["fields_apart_at_points"] == 0
    assert (facts["even_zero"], facts["even_size"]) == (3, 5)
    assert facts["cone_least"] == pytest.approx(-0.105, abs=5e-4)
    assert facts["cone_wave"] == pytest.approx(5.88, abs=0.06)
    assert facts["late_wave"] == pytest.approx(88.52, abs=0.05)
    waves = cpd_kernels.WAVES
    exact = (1 - np.cos(waves)) / waves**2 * np.sqrt(2 / np.pi)
    assert np.abs(kernels.arrays["waves"][0] - exact).max() < 1e-14


def test_normal_derivatives_give_a_smaller_error_than_off_surface_points(other_data):
    """Fewer data suffice; values alone determine only the zero field."""
    assert other_data["missed_normals"] < 1e-3
    assert other_data["beside_over_normals"] > 2
    assert other_data["largest_zero_field"] == 0


def test_poisson_converges_and_the_torsion_agrees_with_its_series(other_data):
    """The smoother kernel has a higher order; the value at the centre is that of the series."""
    assert 2 < other_data["order_r5"] < other_data["order_r7"]
    assert other_data["torsion_series"] == pytest.approx(0.0736713532, rel=1e-8)
    assert other_data["torsion_percent"] < 0.1


def test_values_instead_of_laplacians_give_a_large_error(monkeypatch):
    """A mutant: the error is then of order one."""
    monkeypatch.setattr(hermite_data, "laplacians_at", values_at)
    assert hermite_data.error_at(50, (6, hermite_data.KERNELS["r⁷"])) > 0.5
