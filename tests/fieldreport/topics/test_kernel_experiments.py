"""Experiments on splines, kernels and Hermite data, compared with independent values."""

import numpy as np
import pytest

from fieldrecon.methods.functionals import values_at
from fieldreport import experiments
from fieldreport.experiments.kernels import cpd_kernels, mairhuber_curtis
from fieldreport.experiments.methods import hermite_data, natural_splines


@pytest.fixture(scope="module")
def splines():
    return natural_splines.run(natural_splines.Params()).facts  # with more digits than are told


@pytest.fixture(scope="module")
def exchange():
    return mairhuber_curtis.run(mairhuber_curtis.Params())  # facts with more digits than are told


@pytest.fixture(scope="module")
def kernels():
    return experiments.get("cpd_kernels").run()


@pytest.fixture(scope="module")
def other_data():
    params = hermite_data.Params(sizes=(8, 11, 14))
    return hermite_data.run(params).facts  # with more digits than are told


def test_the_natural_spline_has_the_least_energy(splines):
    """Less than any other curve; with what is left it makes up that of the sine, exactly."""
    assert splines["energy_not_a_knot_ratio"] > 1
    assert splines["energy_polynomial_ratio"] > 1
    assert splines["energy_natural"] == pytest.approx(splines["energy_by_coefficients"], rel=1e-9)
    total = splines["energy_natural"] + splines["energy_rest"]
    assert total == pytest.approx(splines["energy_function"], rel=1e-8)
    assert splines["pythagoras_defect"] <= 1e-9


def test_the_energy_of_the_sine_is_an_integral():
    """The closed form against Gauss's rule."""
    nodes, weights = np.polynomial.legendre.leggauss(60)
    x = 0.2 + 0.3 * (nodes + 1)
    integral = 0.3 * weights @ (81 * np.sin(9 * x)) ** 2
    assert natural_splines.energy_of_sine(9.0, 0.2, 0.8) == pytest.approx(integral, rel=1e-12)


def test_orders_and_decay_of_natural_splines(splines):
    """Four inside, two at the ends, where s'' = 0 is wrong; influence falls by 2 - √3."""
    assert splines["order_middle"] == pytest.approx(4, abs=0.1)
    assert splines["order_ends"] == pytest.approx(2, abs=0.1)
    assert splines["decay"] == pytest.approx(2 - 3**0.5, rel=1e-6)
    assert splines["difference_from_scipy"] <= 1e-13
    assert abs(splines["outside_natural"] - splines["outside_scipy"]) > 1


def test_the_determinant_changes_its_sign_where_the_points_are_collinear(exchange):
    """At the time of the closed form; the least distance of the points never is zero."""
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


def test_six_points_on_a_conic_make_the_quadratics_singular(exchange):
    """When their determinant vanishes a quadric passes through all six."""
    points = mairhuber_curtis.exchanged(
        exchange.params.rise, mairhuber_curtis.OTHERS, exchange.facts["time_quadratic"]
    )
    x, y = points.T
    b = np.column_stack([np.ones(6), x, y, x * x, x * y, y * y])
    assert np.linalg.svd(b, compute_uv=False)[-1] < 1e-8
    assert np.linalg.svd(b, compute_uv=False)[-2] > 1e-2


def test_every_kernel_is_as_its_order_says(kernels):
    """Positive with it and negative below it; the inertia is (n, q, 0) for all eleven."""
    facts = kernels.facts
    assert facts["least_of_all"] > 0 > facts["largest_below"]
    assert facts["as_predicted"] == facts["kernels"] == 11
    assert (facts["alone_positive"], facts["alone_negative"]) == (23, 1)


def test_what_fails_without_a_premise(kernels):
    """Rank on a line, the even power, a cone in the plane: -0.105 on the 9 × 9 lattice."""
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


def test_normals_are_better_data_than_points_beside(other_data):
    """With fewer of them the curve is found better; values alone give nothing at all."""
    assert other_data["missed_normals"] < 1e-3
    assert other_data["beside_over_normals"] > 2
    assert other_data["largest_zero_field"] == 0


def test_poisson_converges_and_the_torsion_is_that_of_the_series(other_data):
    """The smoother kernel is of higher order; the value in the middle is that of the series."""
    assert 2 < other_data["order_r5"] < other_data["order_r7"]
    assert other_data["torsion_series"] == pytest.approx(0.0736713532, rel=1e-8)
    assert other_data["torsion_percent"] < 0.1


def test_laplacians_forgotten_would_be_seen(monkeypatch):
    """With values in the place of Laplacians the error is of order one."""
    monkeypatch.setattr(hermite_data, "laplacians_at", values_at)
    assert hermite_data.error_at(50, (6, hermite_data.KERNELS["r⁷"])) > 0.5
