"""Hermite-Birkhoff interpolation: laws, splines, surfaces from normals, Poisson's equation."""

from unittest import mock

import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline

from fieldrecon import reconstruction
from fieldrecon.datasets.synthetic import halton
from fieldrecon.kernels.base import Radial
from fieldrecon.kernels.conditionally_positive_definite import (
    multiquadric,
    polyharmonic,
    thin_plate_spline,
)
from fieldrecon.kernels.derivatives import radial_derivative, smoothness
from fieldrecon.kernels.positive_definite import gaussian, inverse_multiquadric, matern, wendland
from fieldrecon.kernels.weights import inverse_square
from fieldrecon.methods import functionals as functionals_module
from fieldrecon.methods.functionals import (
    Functionals,
    derivatives_at,
    laplacians_at,
    together,
    values_at,
)
from fieldrecon.methods.hermite import HermiteRBF
from fieldrecon.methods.rbf import RBF
from laws import assert_close, difference_quotient, refused

SITES = np.random.default_rng(3).random((24, 2))
NORMALS = np.random.default_rng(4).standard_normal((24, 2))
QUERIES = np.random.default_rng(5).random((15, 2))
KERNELS: list[Radial] = [
    gaussian(0.4),
    inverse_multiquadric(0.3),
    multiquadric(0.3),
    matern(4.5, 0.2),
    wendland(3, 2, 1.3),
    wendland(3, 3, 1.3),
    polyharmonic(5),
    polyharmonic(6),
    polyharmonic(7),
]
ROUGHER: list[Radial] = [
    thin_plate_spline(),
    polyharmonic(4),
    matern(1.5, 0.3),
    matern(2.0, 0.3),
    wendland(1, 0),
    wendland(3, 1, 0.8),
    inverse_square(0.5),
    polyharmonic(1),
]


def wave(x):
    return np.cos(x @ [2.0, 3.0]) + x[..., 0] ** 3


def wave_gradient(x):
    slope = -np.sin(x @ [2.0, 3.0])[..., None] * [2.0, 3.0]
    slope[..., 0] += 3 * x[..., 0] ** 2
    return slope


def wave_laplacian(x):
    return -13 * np.cos(x @ [2.0, 3.0]) + 6 * x[..., 0]


def mixed(sites=SITES, unit=1.0):
    """Values, normal components and Laplacians, each at a third of the sites.

    Some sites have two.
    """
    return together(
        [
            values_at(sites[:9]),
            derivatives_at(sites[8:17], NORMALS[8:17] * unit),
            laplacians_at(sites[16:]),
        ]
    )


def data_of(f: Functionals) -> np.ndarray:
    slope = np.einsum("nd,nd->n", f.gradient, wave_gradient(f.points))
    return f.value * wave(f.points) + slope + f.laplacian * wave_laplacian(f.points)


# --- radial derivatives of kernels ----------------------------------------------------------------


@pytest.mark.parametrize("kernel", KERNELS + ROUGHER, ids=repr)
@pytest.mark.parametrize("times", range(4))
def test_each_radial_derivative_is_the_slope_of_the_previous_one(kernel, times):
    """φ_(j+1) = φ_j'/r, by differences of order six."""
    r = np.linspace(0.1, 0.7, 25)
    h = 1e-3
    by = {
        k: radial_derivative(kernel, (r + k * h) ** 2, times)
        - radial_derivative(kernel, (r - k * h) ** 2, times)
        for k in (1, 2, 3)
    }
    quotient = (45 * by[1] - 9 * by[2] + by[3]) / (60 * h) / r
    expected = radial_derivative(kernel, r**2, times + 1)
    size = np.abs(expected).max()
    assert_close(expected / size, quotient / size, 1e-6)


@pytest.mark.parametrize("kernel", KERNELS + ROUGHER, ids=repr)
def test_radial_derivatives_begin_with_the_kernel_and_its_slope(kernel):
    """φ_0 = φ and φ_1 = φ'/r. At zero, where φ_2 may be infinite, a finite number is returned."""
    s = np.array([0.0, 1e-300, 0.01, 0.3, 0.9, 4.0])
    assert_close(radial_derivative(kernel, s, 0), kernel.of_squared(s), 0.0)
    scale = 1 + np.abs(kernel.slope_of_squared(s[2:]))
    assert_close(
        radial_derivative(kernel, s[2:], 1) / scale, kernel.slope_of_squared(s[2:]) / scale, 1e-12
    )
    assert kernel.differentiable == (smoothness(kernel) >= 1)
    assert all(np.isfinite(radial_derivative(kernel, s[:1], j)).all() for j in range(5))


@pytest.mark.parametrize("kernel", KERNELS + ROUGHER, ids=repr)
def test_smoothness_equals_the_number_of_finite_radial_derivatives(kernel):
    """φ(|x|) is C^(2j) if φ_j has a limit at zero, and C^(2j+1) if r φ_(j+1) tends to zero."""
    last = smoothness(kernel)
    for j in range(1, 4):
        far, near = np.abs(radial_derivative(kernel, np.array([1e-8, 1e-14]), j))
        assert (1e-3 * near < 0.1 * far) == (last >= 2 * j - 1)
        assert (near < 1.3 * far) == (last >= 2 * j)


@pytest.mark.parametrize("d", [1, 2, 3, 5])
@pytest.mark.parametrize("k", range(4))
def test_radial_derivatives_of_compact_support_are_zero_from_its_end_on(d, k):
    """Also those that jump there, of (1 - r)^l the l-th."""
    for times in range(5):
        values = radial_derivative(wendland(d, k, 0.5), np.array([0.25, 0.26, 4.0]), times)
        assert_close(values, np.zeros(3), 0.0)


# --- laws -----------------------------------------------------------------------------------------


def data_are_reproduced(method: HermiteRBF) -> None:
    """Each functional of the field must equal its datum."""
    assert_close(method.weights_of(method.functionals), np.eye(len(method.points)), 1e-6)
    data = data_of(method.functionals)
    size = np.abs(data).max()
    assert_close(method.field(data).apply(method.functionals) / size, data / size, 1e-7)


def linear_polynomials_are_reproduced(method: HermiteRBF) -> None:
    """Data of a linear polynomial must give its values, gradients and Laplacians."""
    if method.degree >= 1:
        f = method.functionals
        plane = f.value * (1 + f.points @ [2.0, -3.0]) + f.gradient @ [2.0, -3.0]
        s = method.field(plane)
        assert_close(s(QUERIES), 1 + QUERIES @ [2.0, -3.0], 1e-8)
        assert_close(s.gradient(QUERIES), np.tile([2.0, -3.0], (15, 1)), 1e-7)
        assert_close(s.apply(laplacians_at(QUERIES)), np.zeros(15), 1e-5)


def the_error_is_smaller_than_that_of_values_alone(method: HermiteRBF) -> None:
    """Between the sites the error must be smaller than that of r³ with the nine values only."""
    error = method.field(data_of(method.functionals))(QUERIES) - wave(QUERIES)
    rough = RBF(SITES[:9], polyharmonic(3)).field(wave(SITES[:9]))(QUERIES) - wave(QUERIES)
    assert np.sqrt(np.mean(error**2)) < 0.9 * np.sqrt(np.mean(rough**2))


def functionals_of_the_field_equal_difference_quotients(method: HermiteRBF) -> None:
    """Gradients, directional derivatives and Laplacians must equal differences of the values."""
    s = method.field(data_of(method.functionals))
    quotient = difference_quotient(s, QUERIES, 1e-3)
    size = np.abs(quotient).max()
    assert_close(s.gradient(QUERIES) / size, quotient / size, 1e-5)
    along = s.apply(derivatives_at(QUERIES, [1.0, -2.0]))
    assert_close(along / size, quotient @ [1.0, -2.0] / size, 1e-5)
    second = difference_quotient(s.gradient, QUERIES, 1e-3)
    laplacian = np.trace(second, axis1=1, axis2=2)
    size = np.abs(laplacian).max()
    assert_close(s.apply(laplacians_at(QUERIES)) / size, laplacian / size, 1e-4)
    assert_close(s.laplacian(QUERIES), s.apply(laplacians_at(QUERIES)), 0.0)
    assert_close(s.hessian(QUERIES) / size, second / size, 1e-4)


def the_energy_is_positive_and_increases_with_the_data(method: HermiteRBF) -> None:
    """λᵀ f is the minimal energy for these data; with fewer data it must be smaller."""

    def energy(m: HermiteRBF) -> float:
        return float(
            m._prepare(data_of(m.functionals)[:, None])[0][:, 0]
            @ (data_of(m.functionals) / m._size)
        )

    f = method.functionals
    fewer = type(method)(f[:-2], method.kernel, method.degree)
    assert 0 < energy(fewer) * 0.999999 < energy(method)


HERMITE_LAWS = [
    data_are_reproduced,
    linear_polynomials_are_reproduced,
    the_error_is_smaller_than_that_of_values_alone,
    functionals_of_the_field_equal_difference_quotients,
    the_energy_is_positive_and_increases_with_the_data,
]


@pytest.mark.parametrize("law", HERMITE_LAWS, ids=lambda law: law.__name__)
@pytest.mark.parametrize("kernel", KERNELS, ids=repr)
def test_every_smooth_kernel_obeys_the_law(law, kernel):
    """The data are values, normal components and Laplacians, each at some of the sites."""
    law(HermiteRBF(mixed(), kernel, max(1, kernel.order - 1)))


class Unsymmetric(HermiteRBF):
    """Kernels to which the functionals of the data are not applied, as in Kansa's method."""

    def _of_kernel(self, local):
        return local.of_kernel(values_at(self._local.points), self._unit_kernel)


class SignOfTheSecondArgument(HermiteRBF):
    """Derivatives with respect to y instead of x."""

    def _of_kernel(self, local):
        f = self._local
        reversed_gradients = Functionals(f.points, f.value, -f.gradient, f.laplacian)
        return local.of_kernel(reversed_gradients, self._unit_kernel)


class ValuesOnly(HermiteRBF):
    """Ignores all data that are not values."""

    def _prepare(self, values):
        return super()._prepare(np.where(self._local.value[:, None] == 0, 0.0, values))


class GradientsOfTheFrame(HermiteRBF):
    """Derivatives with respect to local coordinates."""

    def _applied(self, asked, prepared):
        return super()._applied(asked, prepared) * np.where(asked.value == 0, 2.0, 1.0)[:, None]


@pytest.mark.parametrize(
    ("law", "mutant"),
    [
        (data_are_reproduced, ValuesOnly),
        (data_are_reproduced, GradientsOfTheFrame),
        (linear_polynomials_are_reproduced, ValuesOnly),
        (the_error_is_smaller_than_that_of_values_alone, ValuesOnly),
        (functionals_of_the_field_equal_difference_quotients, GradientsOfTheFrame),
        (the_energy_is_positive_and_increases_with_the_data, SignOfTheSecondArgument),
    ],
)
def test_the_law_rejects_the_mutant(law, mutant):
    """A wrong method violates the law that it was written for."""
    with pytest.raises(AssertionError):
        law(mutant(mixed(), polyharmonic(5)))


# --- the system -----------------------------------------------------------------------------------


@pytest.mark.parametrize("kernel", KERNELS, ids=repr)
def test_the_matrix_is_symmetric_and_positive_where_the_polynomials_vanish(kernel):
    """Its inertia is (n, q, 0), as for values."""
    f = mixed()
    a = f.of_kernel(f, kernel)
    assert_close(a, a.T, 1e-12 * np.abs(a).max())
    p = f.of_monomials(kernel.order - 1)
    z = np.linalg.qr(p, mode="complete")[0][:, p.shape[1] :]
    d = 1 / np.sqrt(np.diag(z.T @ a @ z))
    assert np.linalg.eigvalsh(d[:, None] * (z.T @ a @ z) * d).min() > 0


@pytest.mark.slow
def test_the_entries_equal_symbolic_derivatives_of_the_kernel():
    """sympy computes all nine pairs of functionals for one kernel and two points."""
    import sympy

    x = sympy.symbols("x0 x1 y0 y1", real=True)
    r2 = (x[0] - x[2]) ** 2 + (x[1] - x[3]) ** 2
    phi = -(r2 ** sympy.Rational(5, 2))
    a, b = (sympy.Rational(2), sympy.Rational(-3)), (sympy.Rational(1), sympy.Rational(5))

    def applied(f, at, direction):
        slopes = [sympy.diff(f, v) for v in at]
        along = sum(c * s for c, s in zip(direction, slopes, strict=True))
        return [f, along, sum(sympy.diff(f, v, 2) for v in at)]

    point = dict(zip(x, (0.3, -0.2, 1.1, 0.7), strict=True))
    expected = [
        [float(g.subs(point)) for g in applied(f, x[2:], b)] for f in applied(phi, x[:2], a)
    ]
    here, there = np.array([[0.3, -0.2]]), np.array([[1.1, 0.7]])
    left = together([values_at(here), derivatives_at(here, [2.0, -3.0]), laplacians_at(here)])
    right = together([values_at(there), derivatives_at(there, [1.0, 5.0]), laplacians_at(there)])
    assert_close(left.of_kernel(right, polyharmonic(5)), expected, 1e-12)


def test_values_alone_equal_rbf():
    for kernel in (polyharmonic(3), gaussian(0.3)):
        field = HermiteRBF(values_at(SITES), kernel).field(wave(SITES))
        assert_close(field(QUERIES), RBF(SITES, kernel).field(wave(SITES))(QUERIES), 1e-8)


def test_mapped_points_and_directions_have_the_distances_of_a_metric():
    """With M = L^T L: values as by `RBF` with the metric M, and derivatives along b in x."""
    metric = np.array([[4.0, 1.0], [1.0, 2.0]])
    to = np.linalg.cholesky(metric)
    values = np.cos(3 * SITES[:, 0] + SITES[:, 1])
    s = HermiteRBF(values_at(SITES @ to), polyharmonic(3)).field(values)
    by_metric = RBF(SITES, polyharmonic(3), metric=metric).field(values)
    assert_close(s(QUERIES @ to), by_metric(QUERIES), 1e-10)
    both = [values_at(SITES @ to), derivatives_at(SITES @ to, NORMALS @ to)]
    slopes = np.sin(np.arange(24.0))
    s = HermiteRBF(both, polyharmonic(5)).field(np.append(values, slopes))
    along = np.einsum("nd,nd->n", s.gradient(SITES @ to) @ to.T, NORMALS)
    assert_close(along, slopes, 1e-7)


def test_values_and_slopes_on_a_line_are_the_cubic_hermite_spline():
    """r³ minimizes ∫ s''².

    With both data at every site the minimizer is SciPy's piecewise Hermite spline.
    """
    x = np.sort(np.random.default_rng(7).random(12))
    f, g = np.sin(7 * x), 7 * np.cos(7 * x)
    method = HermiteRBF([values_at(x[:, None]), derivatives_at(x[:, None], [1.0])], polyharmonic(3))
    s, reference = method.field(np.concatenate([f, g])), CubicHermiteSpline(x, f, g)
    q = np.linspace(x[0], x[-1], 101)
    assert_close(s(q[:, None]), reference(q), 1e-7)
    assert_close(s.gradient(q[:, None])[:, 0], reference(q, 1), 1e-5)


@pytest.mark.parametrize(("unit", "offset"), [(1e-6, 0.0), (1e6, 0.0), (1.0, 2.0**20)])
def test_fields_do_not_depend_on_unit_and_origin(unit, offset):
    """In another unit derivatives scale with 1/unit and Laplacians with 1/unit²."""
    kernel = polyharmonic(5)
    here = mixed(np.round(SITES * 2**20) / 2**20)
    there = mixed(np.round(SITES * 2**20) / 2**20 * unit + offset)
    data = data_of(here)
    scaled = data * np.where(here.value != 0, 1, np.where(here.laplacian != 0, unit**-2, 1 / unit))
    queries = np.round(QUERIES * 2**20) / 2**20
    a = HermiteRBF(here, kernel).field(data)
    b = HermiteRBF(there, kernel).field(scaled)
    assert_close(b(queries * unit + offset), a(queries), 1e-7)
    assert_close(b.gradient(queries * unit + offset) * unit, a.gradient(queries), 1e-6)


@pytest.mark.parametrize("unit", [1e-3, 1.0, 1e3])
def test_weights_and_the_adjoint_are_those_of_the_field_in_any_unit(unit):
    """Data of derivatives and Laplacians have other units than values."""
    asked = mixed(SITES * unit)
    method = HermiteRBF(asked, polyharmonic(5))
    data = np.sin(np.arange(len(asked.points)) + 1.0)
    data *= np.where(asked.value != 0, 1, np.where(asked.laplacian != 0, unit**-2, 1 / unit))
    x, loads = QUERIES * unit, np.cos(np.arange(30.0)).reshape(15, 2)
    s, weights = method.field(data), method.weights(x)
    assert_close(weights @ data, s(x), 1e-7)
    for axis, slopes in enumerate(method.gradient_weights(x)):
        assert_close(slopes @ data, s.gradient(x)[:, axis], 1e-6)
    assert_close(method.adjoint(x, loads) * data[:, None], weights.T @ loads * data[:, None], 1e-7)


# --- surfaces and equations -----------------------------------------------------------------------


def test_a_sphere_is_reconstructed_from_points_and_normals():
    """F = 0 and ∂F/∂n = -1, without off-surface points.

    F is positive inside, and the radius is accurate to 1e-3.
    """
    golden = np.pi * (3 - np.sqrt(5))
    i = np.arange(120)
    z = 1 - (2 * i + 1) / 120
    normals = np.column_stack(
        [np.sqrt(1 - z**2) * np.cos(golden * i), np.sqrt(1 - z**2) * np.sin(golden * i), z]
    )
    data = np.concatenate([np.zeros(120), -np.ones(120)])
    surface = HermiteRBF(
        [values_at(normals), derivatives_at(normals, normals)], polyharmonic(3)
    ).field(data)
    assert float(surface([0.0, 0.0, 0.0])) > 0.3
    directions = np.random.default_rng(2).standard_normal((50, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    radii = 1 + surface(directions)  # one Newton step along the normal, of slope -1
    assert np.abs(radii - 1).max() < 1e-3
    slope = np.einsum("nd,nd->n", surface.gradient(directions), directions)
    assert_close(slope, -np.ones(50), 2e-2)


def poisson(n: int, kernel: Radial, right, boundary):
    """Collocation of Δu = right in the unit square, u = boundary on its sides, on about n sites."""
    side = round(np.sqrt(n))
    t = np.arange(side) / side
    edge = np.concatenate(
        [
            np.column_stack([t, 0 * t]),
            np.column_stack([1 + 0 * t, t]),
            np.column_stack([1 - t, 1 + 0 * t]),
            np.column_stack([0 * t, 1 - t]),
        ]
    )
    inside = halton(n, 2)
    inside = inside[((inside > 0.3 / side) & (inside < 1 - 0.3 / side)).all(axis=1)]
    method = HermiteRBF([laplacians_at(inside), values_at(edge)], kernel)
    return method.field(np.concatenate([right(inside), boundary(edge)]))


def test_poisson_s_equation_converges_with_more_than_second_order():
    """r⁷ and cubic polynomials, with 100 and 900 sites inside."""
    x = np.random.default_rng(9).random((300, 2))
    errors = []
    for n in (100, 900):
        u = poisson(n, polyharmonic(7), wave_laplacian, wave)
        errors.append(np.sqrt(np.mean((u(x) - wave(x)) ** 2)))
    assert np.log(errors[0] / errors[1]) / np.log(3) > 2.5
    assert errors[1] < 1e-4


def test_the_torsion_of_a_square_equals_its_series():
    """Δu = -1 with u = 0 on the boundary.

    The value at the centre is compared with the double sine series.
    """
    k = np.arange(1, 400, 2)
    sign = (-1.0) ** ((k - 1) // 2)
    series = (
        16 / np.pi**4 * np.sum(np.outer(sign, sign) / (np.outer(k, k) * np.add.outer(k**2, k**2)))
    )
    u = poisson(700, polyharmonic(7), lambda x: -np.ones(len(x)), lambda x: np.zeros(len(x)))
    assert float(u([0.5, 0.5])) == pytest.approx(series, rel=1e-3)


# --- refusals -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: HermiteRBF(mixed(), polyharmonic(3)), "has 2 continuous .* order 2 need 4"),
        (
            lambda: HermiteRBF([derivatives_at(SITES, [1, 0])], thin_plate_spline()),
            "has 1 continuous derivatives; data of order 1 need 2",
        ),
        (
            lambda: HermiteRBF([values_at(SITES), values_at(SITES[:1])], polyharmonic(3)),
            "independent; those at one point are not: 0, 24",
        ),
        (
            lambda: HermiteRBF(
                [values_at(SITES), derivatives_at(SITES[[0, 0]], [[1, 2], [2, 4]])], polyharmonic(3)
            ),
            "those at one point are not: 0, 24, 25",
        ),
        (
            lambda: HermiteRBF([values_at(SITES[:1])] * 7, polyharmonic(3)),
            "not: 0, 1, 2, 3, 4$",
        ),
        (lambda: HermiteRBF(SITES, polyharmonic(3)), "functionals must be those of values_at"),
        (lambda: HermiteRBF([], polyharmonic(3)), "functionals must be those of values_at"),
        (lambda: together([values_at(SITES), values_at([[0.0]])]), "of as many variables"),
        (lambda: derivatives_at(SITES, NORMALS[:3]), r"shape \(24, 2\) or \(2,\); got \(3, 2\)"),
        (lambda: derivatives_at(SITES[:2], [[1, 0], [0, 0]]), r"directions\[1\] is zero"),
        (
            lambda: (
                HermiteRBF(values_at(SITES), matern(0.5, 1.0)).field(wave(SITES)).gradient([0, 0])
            ),
            "has 0 continuous derivatives; asked for order 1",
        ),
        (
            lambda: HermiteRBF(values_at(SITES), polyharmonic(3)).weights_of(values_at([[0.0]])),
            "as many variables as the points",
        ),
    ],
)
def test_invalid_functionals_are_refused(make, words):
    """The message names the argument, what came and what was wanted."""
    with pytest.raises(ValueError, match=words):
        make()


@pytest.mark.parametrize(
    ("kernel", "data", "reach"),
    [
        (matern(0.5, 0.4), values_at(SITES), 0),
        (thin_plate_spline(), values_at(SITES), 1),
        (wendland(3, 1, 1.3), values_at(SITES), 2),
        (wendland(3, 1, 1.3), [values_at(SITES), derivatives_at(SITES, NORMALS)], 1),
        (matern(2.5, 0.4), [values_at(SITES), laplacians_at(SITES)], 2),
    ],
    ids=["matern", "thin plate", "wendland", "slopes", "laplacians"],
)
def test_a_field_has_as_many_derivatives_as_its_kernel_and_data_leave_it(kernel, data, reach):
    """Those of the kernel, less the order of the data; asking for others is refused."""
    method = HermiteRBF(data, kernel)
    s = method.field(np.zeros(len(method.functionals)))
    slopes, laplacians = derivatives_at(QUERIES, [1.0, 0.0]), laplacians_at(QUERIES)
    for order, evaluate in (
        (1, lambda: s.gradient(QUERIES)),
        (1, lambda: s.apply(slopes)),
        (1, lambda: method.gradient_weights(QUERIES)),
        (1, lambda: method.weights_of(slopes)),
        (2, lambda: s.hessian(QUERIES)),
        (2, lambda: s.laplacian(QUERIES)),
        (2, lambda: s.apply(laplacians)),
        (2, lambda: method.weights_of(laplacians)),
    ):
        if order <= reach:
            assert np.isfinite(evaluate()).all()
        else:
            with refused(f"has {reach} continuous derivatives; asked for order {order}"):
                evaluate()


@pytest.mark.parametrize(
    "make",
    [
        lambda kernel: RBF(SITES, kernel),
        lambda kernel: HermiteRBF(values_at(SITES), kernel),
        lambda kernel: HermiteRBF([values_at(SITES), derivatives_at(SITES[:8], [1, 0])], kernel),
    ],
    ids=["RBF", "values", "values and slopes"],
)
def test_weights_are_refused_where_only_smooth_data_can_be_fitted(make):
    """The kernel is wide: a constant is met, but the fields of single data are lost in rounding."""
    method = make(gaussian(4.0))
    data = np.concatenate([np.ones(24), np.zeros(len(method.points) - 24)])
    assert_close(method.field(data)(QUERIES), np.ones(15), 1e-5)
    asked = [method.weights, method.gradient_weights, lambda x: method.adjoint(x, np.ones(15))]
    if isinstance(method, HermiteRBF):
        asked.append(lambda x: method.weights_of(laplacians_at(x)))
    for weights in asked:
        with refused("rounding decides the weights: a field of", np.linalg.LinAlgError):
            weights(QUERIES)


def test_functionals_of_a_field_far_outside_are_refused():
    """As its values are, since rounding decides them; near the sites they are not."""
    s = HermiteRBF(mixed(), polyharmonic(5)).field(data_of(mixed()))
    near, far = QUERIES[:1] + 1.0, QUERIES[:1] + 1e4
    assert_close(s.apply(values_at(near)), s(near), 1e-9 * np.abs(s(near)).max())
    for functional in (values_at(far), derivatives_at(far, [1.0, 0.0]), laplacians_at(far)):
        with refused("rounding decides the value at", np.linalg.LinAlgError):
            s.apply(functional)


def test_weights_of_too_many_functionals_are_refused():
    """Before their matrix is made, as weights of values are."""
    method = HermiteRBF(mixed(), polyharmonic(5))
    with mock.patch.object(reconstruction, "DENSE_LIMIT_BYTES", 8 * 10 * len(method.functionals)):
        assert method.weights_of(laplacians_at(SITES[:10])).shape == (10, len(method.functionals))
        with refused("dense weights of 11 queries for 26 sites", MemoryError):
            method.weights_of(laplacians_at(SITES[:11]))


def test_data_that_do_not_determine_the_polynomial_are_refused():
    """Derivatives do not determine the constant."""
    with pytest.raises(np.linalg.LinAlgError, match="the data do not determine a polynomial"):
        HermiteRBF(derivatives_at(SITES, [1.0, 0.0]), polyharmonic(3))


def test_a_kernel_with_unknown_derivatives_is_refused():
    """A kernel defined by the user has no formulas for higher derivatives."""

    class Own(gaussian):
        pass

    class Stranger(Radial):
        def of_squared(self, s):
            return np.exp(-s)

        def slope_of_squared(self, s):
            return -2 * np.exp(-s)

        def in_units(self, h):  # noqa: ARG002
            return self

    assert smoothness(Own(1.0)) == np.inf
    with pytest.raises(ValueError, match=r"the higher derivatives of .*Stranger.* are not known"):
        smoothness(Stranger())
    with pytest.raises(ValueError, match="are not known"):
        radial_derivative(Stranger(), np.ones(2), 1)
    assert functionals_module.radial_derivative is radial_derivative
