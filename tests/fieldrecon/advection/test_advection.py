"""Semi-Lagrangian advection: orders, exactness, inflow, stability, bounds and mass."""

from unittest import mock

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.optimize import brentq, minimize

from fieldrecon import reconstruction
from fieldrecon.advection import characteristics as characteristics
from fieldrecon.advection.characteristics import (
    SCHEMES,
    Inflow,
    Snapshots,
    departure_points,
    entries,
)
from fieldrecon.advection.mass_fixer import project_to_bounds_and_mass
from fieldrecon.advection.semi_lagrangian_steps import State, semi_lagrangian
from fieldrecon.datasets.synthetic import halton
from fieldrecon.kernels.conditionally_positive_definite import polyharmonic, thin_plate_spline
from fieldrecon.kernels.positive_definite import gaussian
from fieldrecon.methods.least_squares import LeastSquares
from fieldrecon.methods.moving_least_squares import MovingLeastSquares
from fieldrecon.methods.partition_of_unity.method import PartitionOfUnityRBF
from fieldrecon.methods.rbf import RBF
from laws import assert_close

ORDERS = {"euler": 1, "midpoint": 2, "heun": 2, "rk4": 4}


def disc(n: int) -> np.ndarray:
    """About n sites in the unit disc, some of them on the circle."""
    x = 2 * halton(int(1.27 * n), 2) - 1
    angles = 2 * np.pi * np.arange(int(3 * np.sqrt(n))) / int(3 * np.sqrt(n))
    circle = np.column_stack([np.cos(angles), np.sin(angles)])
    return np.vstack([x[np.linalg.norm(x, axis=1) < 1 - 0.5 / np.sqrt(n)], circle])


def rotation(y: np.ndarray, _: float) -> np.ndarray:
    return y[:, ::-1] * [-1, 1]


def hill(x: np.ndarray) -> np.ndarray:
    return np.exp(-8 * ((x[:, 0] - 0.4) ** 2 + x[:, 1] ** 2))


def rotated_back(x: np.ndarray, angle: float) -> np.ndarray:
    """The position of x before a rotation by the angle."""
    c, s = np.cos(angle), np.sin(angle)
    return x @ np.array([[c, -s], [s, c]])


def last(*arguments, **options) -> State:
    *_, state = semi_lagrangian(*arguments, **options)
    return state


def slope(h: np.ndarray, errors: np.ndarray) -> float:
    return float(np.polyfit(np.log(h), np.log(errors), 1)[0])


# --- characteristics ------------------------------------------------------------------------------


def unsteady(y: np.ndarray, t: float) -> np.ndarray:
    """y_1' = y_1 cos t, y_2' = y_1 y_2 cos t: nonlinear and dependent on time."""
    return np.column_stack([y[:, 0] * np.cos(t), y[:, 1] * y[:, 0] * np.cos(t)])


def unsteady_start(y: np.ndarray, t: float) -> np.ndarray:
    """The position of y at time zero: y_1 e^{-sin t}, and y_2 e^{y_1(0) - y_1(t)}."""
    first = y[:, 0] * np.exp(-np.sin(t))
    return np.column_stack([first, y[:, 1] * np.exp(first - y[:, 0])])


def measured_order(scheme: str) -> float:
    x, end = halton(20, 2), 1.3
    steps, errors = np.array([8, 16, 32, 64]), []
    for k in steps:
        y, dt = x, end / k
        for j in range(k):
            y = departure_points(y, unsteady, end - j * dt, dt, scheme)
        errors.append(np.abs(y - unsteady_start(x, end)).max())
    return slope(end / steps, np.array(errors))


@pytest.mark.parametrize("scheme", SCHEMES)
def test_schemes_have_their_orders(scheme):
    """The reference is the closed form of a nonlinear flow that depends on time."""
    assert abs(measured_order(scheme) - ORDERS[scheme]) < 0.15


@pytest.mark.parametrize(
    ("scheme", "wrong"),
    [
        ("midpoint", (((1,),), (0, 1))),
        ("heun", (((1 / 2,),), (1 / 2, 1 / 2))),
        ("rk4", (((1 / 2,), (1 / 2, 0), (0, 0, 1)), (1 / 6, 1 / 3, 1 / 3, 1 / 6))),
        ("rk4", (((1 / 2,), (0, 1 / 2), (0, 0, 1)), (1 / 4, 1 / 4, 1 / 4, 1 / 4))),
    ],
)
def test_a_wrong_runge_kutta_tableau_loses_an_order(scheme, wrong, monkeypatch):
    monkeypatch.setitem(SCHEMES, scheme, wrong)
    assert measured_order(scheme) < ORDERS[scheme] - 0.5


def test_evaluating_all_stages_at_the_arrival_time_is_of_first_order():
    def at_arrival_time(x, velocity, t, dt, scheme):
        return departure_points(x, lambda y, _: velocity(y, t), t, dt, scheme)

    x, end, errors = halton(20, 2), 1.3, []
    for k in (16, 64):
        y, dt = x, end / k
        for j in range(k):
            y = at_arrival_time(y, unsteady, end - j * dt, dt, "rk4")
        errors.append(np.abs(y - unsteady_start(x, end)).max())
    assert errors[0] < 6 * errors[1]


def test_sampled_velocities_give_the_departure_points_of_the_velocity():
    """The method reproduces the velocity; snapshots are interpolated linearly in time."""
    x, sites = halton(30, 2), halton(40, 2, seed=3)
    method = RBF(sites, thin_plate_spline())
    samples = method.field(rotation(sites, 0))
    expected = departure_points(x, rotation, 0.7, 0.7)
    assert_close(departure_points(x, samples, 0.7, 0.7), expected, 1e-10)
    wind = Snapshots([0.0, 1.0, 3.0], [method.field(k * rotation(sites, 0)) for k in (0, 1, 3)])
    exact = departure_points(x, lambda y, t: t * rotation(y, t), 2.5, 0.8)
    assert_close(departure_points(x, wind, 2.5, 0.8), exact, 1e-9)


def test_snapshots_are_of_second_order_in_time():
    """Linear interpolation between snapshots has an error of O(Δt²)."""
    x, sites = halton(10, 2), halton(12, 2, seed=3)
    method, errors = LeastSquares(sites), []
    for k in (4, 8, 16):
        times = np.linspace(0, 2, k + 1)
        wind = Snapshots(times, [method.field(np.cos(3 * t) * rotation(sites, t)) for t in times])
        errors.append(np.abs(wind(x, 1.1) - np.cos(3.3) * rotation(x, 0)).max())
    assert slope(1 / np.array([4, 8, 16]), np.array(errors)) > 1.5


# --- exact solutions ------------------------------------------------------------------------------


@pytest.mark.parametrize("scheme", SCHEMES)
def test_affine_fields_in_linear_flows_are_exact_up_to_the_scheme(scheme):
    """After n steps the field is c + g · Mⁿ x with M = Σ (-dt J)^k / k! for k up to the order."""
    x, dt = disc(60), 0.1
    jacobian = np.array([[0.3, -1.1], [0.9, -0.2]])
    state = last(
        RBF(x, thin_plate_spline()),
        2 + x @ [3.0, -1.0],
        lambda y, _: y @ jacobian.T,
        np.arange(6) * dt,
        scheme=scheme,
    )
    term, m = np.eye(2), np.eye(2)
    for k in range(1, ORDERS[scheme] + 1):
        term = term @ (-dt * jacobian) / k
        m = m + term
    exact = 2 + x @ np.linalg.matrix_power(m, 5).T @ [3.0, -1.0]
    assert_close(state.values, exact, 1e-10)
    if scheme == "rk4":
        assert_close(m, expm(-dt * jacobian), 1e-6)


def test_sites_that_move_with_the_flow_keep_their_values():
    """The departure points are then the old sites, where an interpolant reproduces the data."""
    angles = np.linspace(0, 1.0, 6)
    x = disc(80)
    method = RBF(x, polyharmonic(3))
    state = last(
        method,
        hill(x),
        rotation,
        angles,
        sites=lambda state, t: RBF(
            departure_points(state.method.points, rotation, state.time, state.time - t),
            polyharmonic(3),
        ),
    )
    assert_close(state.values, hill(x), 1e-5)
    assert np.abs(state.method.points - x).max() > 0.5


def test_sites_may_change_from_step_to_step():
    """Each step has other sites and another number of them."""

    def sites(_, t):
        return RBF(disc(500 + round(100 * t)), polyharmonic(3))

    state = last(sites(None, 0), hill(disc(500)), rotation, np.linspace(0, 1, 5), sites=sites)
    x = state.method.points
    assert len(x) != len(disc(500))
    assert np.abs(state.values - hill(rotated_back(x, 1.0))).max() < 0.03


def test_vectors_matrices_and_complex_numbers_are_advected_by_components():
    x = disc(100)
    f = np.stack([hill(x), np.cos(x[:, 0]), x[:, 1], hill(-x)], axis=1).reshape(-1, 2, 2)
    method, times = RBF(x, polyharmonic(3)), np.linspace(0, 1, 4)
    together = last(method, f, rotation, times).values
    for i, j in np.ndindex(2, 2):
        assert_close(together[:, i, j], last(method, f[:, i, j], rotation, times).values, 1e-10)
    c = last(method, f[:, 0, 0] + 1j * f[:, 0, 1], rotation, times).values
    assert_close(c, together[:, 0, 0] + 1j * together[:, 0, 1], 1e-10)


# --- orders ---------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("scheme", SCHEMES)
def test_the_error_has_the_order_of_the_scheme_in_the_step(scheme):
    """Smooth data, which the sites resolve, are rotated by one radian."""
    x = disc(900)
    method = RBF(x, polyharmonic(7))
    u = np.cos(x @ [1.0, 2.0])
    steps = np.array([1, 2, 4]) if scheme == "rk4" else np.array([4, 8, 16])
    errors = []
    for k in steps:
        final = last(method, u, rotation, np.linspace(0, 1, k + 1), scheme=scheme)
        inner = np.linalg.norm(x, axis=1) < 0.5
        exact = np.cos(rotated_back(x, 1.0) @ [1.0, 2.0])
        errors.append(np.abs(final.values - exact)[inner].max())
    assert abs(slope(1 / steps, np.array(errors)) - ORDERS[scheme]) < 0.3


@pytest.mark.slow
def test_the_error_has_more_than_third_order_in_the_spacing():
    """With r³, linear polynomials and accurate departure points the order is nearly four."""
    counts, errors = np.array([300, 700, 1600]), []
    for n in counts:
        x = disc(n)
        final = last(
            RBF(x, polyharmonic(3)), hill(x), rotation, np.linspace(0, 1, 9), steady=True
        ).values
        errors.append(np.sqrt(np.mean((final - hill(rotated_back(x, 1.0))) ** 2)))
    assert slope(counts**-0.5, np.array(errors)) > 3


def test_steady_velocities_are_traced_once():
    """The departure points are computed once per step size, and the result is the same."""
    x = disc(100)
    method = PartitionOfUnityRBF(x)
    times = [0, 0.1, 0.2, 0.3, 0.5, 0.7]
    calls = []

    def counted(y, t):
        calls.append(t)
        return rotation(y, t)

    once = last(method, hill(x), counted, times, steady=True).values
    assert len(calls) == 8
    assert_close(once, last(method, hill(x), rotation, times).values, 1e-10)
    with mock.patch.object(reconstruction, "DENSE_LIMIT_BYTES", 1000):
        rbf = RBF(x, polyharmonic(3))
        formless = last(rbf, hill(x), rotation, times, steady=True).values
    assert_close(formless, last(rbf, hill(x), rotation, times, steady=True).values, 1e-10)


@pytest.mark.parametrize("unit", [1e-6, 1e6])
def test_the_unit_of_time_does_not_matter(unit):
    """A step of another length is traced anew, however short it is."""
    x, times = disc(60), np.array([0.0, 0.1, 0.3])
    found = last(
        LeastSquares(x, 2), hill(x), lambda y, t: rotation(y, t) / unit, unit * times, steady=True
    )
    assert_close(found.values, last(LeastSquares(x, 2), hill(x), rotation, times).values, 1e-12)


def test_a_step_to_other_sites_is_traced_anew():
    """Also of a steady velocity, from the same sites and in the same time."""
    few, many = LeastSquares(disc(60), 2), LeastSquares(disc(90), 2)
    first = State(0.0, few, hill(few.points))
    for methods in ([few, few, many], [few, many, few, few, many, many]):
        following = iter(methods[1:])
        *_, found = semi_lagrangian(
            methods[0],
            first.values,
            rotation,
            np.arange(len(methods)) / 9,
            steady=True,
            sites=lambda *_, following=following: next(following),
        )
        state = first
        for method in methods[1:]:
            feet = departure_points(method.points, rotation, 0.0, 1 / 9)
            state = State(0.0, method, state.method.field(state.values)(feet))
        assert_close(found.values, state.values, 1e-11)


# --- inflow ---------------------------------------------------------------------------------------


def test_inflow_takes_the_boundary_value_at_the_time_of_entry():
    """The exact solution is sin(5(x - t)) on [0, 1]; without inflow the error exceeds 0.1."""
    x = np.linspace(0, 1, 41)[:, None]
    method = RBF(x, polyharmonic(5))
    flow = Inflow(lambda y: y[:, 0], lambda y, t: np.sin(5 * (y[:, 0] - t)))
    times = np.linspace(0, 2, 21)
    u = np.sin(5 * x[:, 0])
    one = lambda y, _: np.ones_like(y)  # noqa: E731
    exact = np.sin(5 * (x[:, 0] - 2))
    assert_close(last(method, u, one, times, inflow=flow, steady=True).values, exact, 1e-5)
    assert np.abs(last(method, u, one, times, steady=True).values - exact).max() > 0.1


def test_entry_points_and_times_are_of_fourth_order():
    """Circular paths enter a half plane at a known point and time."""
    errors, steps = [], np.array([0.8, 0.4, 0.2])
    for dt in steps:
        x = np.array([[0.5 * np.sin(0.6 * dt), -0.5 * np.cos(0.6 * dt)]])
        feet = departure_points(x, rotation, 3.0, dt)
        flow = Inflow(lambda y: y[:, 0], lambda *_: np.zeros(1))
        found = characteristics.entries(x, feet, rotation, 3.0, dt, flow)
        assert found.which.tolist() == [0]
        assert abs(found.points[0, 0]) < 1e-12
        errors.append(max(abs(found.points[0, 1] + 0.5), abs(found.delays[0] - 0.6 * dt)))
    assert slope(steps, np.array(errors)) > 3.7


def test_inflow_may_be_a_vector_field():
    """Inflow values of another shape are refused."""
    x = np.linspace(0, 1, 11)[:, None]
    f = np.column_stack([x, 1 - x])
    one = lambda y, _: np.ones_like(y)  # noqa: E731
    flow = Inflow(lambda y: y[:, 0], lambda y, t: np.column_stack([y[:, 0] - t, 1 - y[:, 0] + t]))
    found = last(LeastSquares(x), f, one, [0, 0.15, 0.3], inflow=flow).values
    assert_close(found, np.column_stack([x - 0.3, 1.3 - x]), 1e-12)
    with pytest.raises(ValueError, match=r"inflow\.values must give values of the shape \(2, 2\)"):
        last(LeastSquares(x), f, one, [0, 0.15], inflow=Inflow(flow.domain, lambda y, _: y))


# --- Burgers' equation: the values are the velocity -----------------------------------------------


def test_burgers_equation_is_of_second_order_in_time():
    """Every step reproduces u = x / (1 + t), so the error is that of the time stepping."""
    x = np.linspace(-1, 1, 11)[:, None]
    steps = np.array([8, 16, 32])
    errors = [
        np.abs(last(LeastSquares(x), x, None, np.linspace(0, 1, k + 1)).values - x / 2).max()
        for k in steps
    ]
    assert abs(slope(1 / steps, np.array(errors)) - 2) < 0.2


def test_burgers_equation_agrees_with_the_implicit_solution():
    """u = f(x - u t), before characteristics intersect."""
    x = np.linspace(-2, 2, 161)[:, None]
    f = lambda y: np.exp(-4 * y**2)  # noqa: E731
    found = last(RBF(x, polyharmonic(5)), f(x), None, np.linspace(0, 0.4, 41)).values[:, 0]
    exact = [brentq(lambda u, y=y: u - f(y - 0.4 * u), 0, 1.1) for y in x[:, 0]]
    assert np.abs(found - exact).max() < 2e-3
    assert np.abs(f(x[:, 0]) - exact).max() > 0.3


# --- stability ------------------------------------------------------------------------------------


def test_powers_of_the_weight_matrix_are_bounded_for_a_rotation():
    """The spectral radius of H is at most 1 + 1e-6 for a rotation by 0.1 radians of a disc."""
    x = disc(300)
    h = RBF(x, thin_plate_spline()).weights(departure_points(x, rotation, 0.1, 0.1))
    assert np.abs(np.linalg.eigvals(h)).max() < 1 + 1e-6
    norms = [np.linalg.norm(np.linalg.matrix_power(h, k), 2) for k in (1, 10, 100, 1000)]
    assert max(norms) < 3


def test_powers_of_the_weight_matrix_grow_with_extrapolation():
    """A uniform velocity into the disc without inflow extrapolates linearly in each step."""
    x = disc(300)
    wind = lambda y, _: np.tile([1.0, 0.0], (len(y), 1))  # noqa: E731
    h = RBF(x, thin_plate_spline()).weights(departure_points(x, wind, 0.2, 0.2))
    assert np.linalg.norm(np.linalg.matrix_power(h, 100), 2) > 10


def test_weighted_means_stay_within_the_range_of_the_data():
    """Nonnegative weights that sum to one give powers of H with the maximum norm one."""
    x = disc(200)
    method = MovingLeastSquares(x, gaussian(0.15), 0)
    h = np.asarray(method.weights(departure_points(x, rotation, 0.1, 0.1)))
    assert np.abs(np.linalg.matrix_power(h, 500)).sum(axis=1).max() < 1 + 1e-9


# --- bounds and mass ------------------------------------------------------------------------------


def slotted(x: np.ndarray) -> np.ndarray:
    """Indicator function of a disc with a slot."""
    y = x - [0.0, 0.4]
    inside = (np.linalg.norm(y, axis=1) < 0.35) & ~((np.abs(y[:, 0]) < 0.08) & (y[:, 1] < 0.1))
    return inside.astype(float)


def test_bounds_and_mass_are_preserved_on_request():
    """Without the options a discontinuous field overshoots, and the total mass changes."""
    x = disc(500)
    masses = 0.5 + np.random.default_rng(0).random(len(x))
    method, times, u = RBF(x, polyharmonic(3)), np.linspace(0, 2, 21), slotted(x)
    wanted = masses @ u
    free, bounded, mass, both = (
        last(method, u, rotation, times, steady=True, **options).values
        for options in (
            {},
            {"bounded": True},
            {"masses": masses},
            {"bounded": True, "masses": lambda _: masses},
        )
    )
    assert free.min() < -0.05
    assert free.max() > 1.05
    for kept in (bounded, both):
        assert kept.min() >= 0
        assert kept.max() <= 1
    assert abs(masses @ free - wanted) > 1e-3 * wanted
    assert abs(masses @ bounded - wanted) > 1e-3 * wanted
    for kept in (mass, both):
        assert abs(masses @ kept - wanted) < 1e-12 * wanted


@pytest.mark.parametrize(("n", "d"), [(30, 1), (30, 2), (30, 3), (5, 3)])
def test_bounds_are_those_of_the_two_to_the_d_sites_nearest_to_the_departure_point(n, d):
    """Or of all sites if they are fewer."""
    x, u = halton(n, d), np.random.default_rng(0).random(n)
    method = RBF(x, polyharmonic(3)) if n > 5 else MovingLeastSquares(x, gaussian(0.5), 0)
    found = last(method, u, lambda y, _: 0 * y + 1.0, [0.0, 0.05], bounded=True)
    feet = x - 0.05
    away = np.linalg.norm(feet[:, None] - x, axis=2)
    near = u[np.argsort(away, axis=1)[:, : 2**d]]
    free = method.field(u)(feet)
    assert_close(found.values, np.clip(free, near.min(axis=1), near.max(axis=1)), 1e-9)


def test_bounds_reduce_the_accuracy_of_smooth_fields():
    """The limiter cuts off the maximum of a smooth hill; the error grows more than threefold."""
    x = disc(500)
    method, times = RBF(x, polyharmonic(3)), np.linspace(0, 1, 11)
    exact = hill(rotated_back(x, 1.0))
    free, bounded = (
        np.abs(last(method, hill(x), rotation, times, steady=True, bounded=b).values - exact).max()
        for b in (False, True)
    )
    assert bounded > 3 * free


def test_the_projection_to_bounds_and_mass_is_orthogonal():
    """The result is the closest admissible vector in the norm of the masses, as SLSQP confirms."""
    rng = np.random.default_rng(2)
    u, m = rng.normal(size=12), 0.2 + rng.random(12)
    low = u - rng.random(12) + 0.3
    high = low + 0.7 * rng.random(12)
    total = 0.6 * (m @ low) + 0.4 * (m @ high)
    found = project_to_bounds_and_mass(
        u[:, None], low[:, None], high[:, None], m, np.array([total])
    )[:, 0]
    reference = minimize(
        lambda v: m @ (v - u) ** 2,
        (low + high) / 2,
        jac=lambda v: 2 * m * (v - u),
        bounds=list(zip(low, high, strict=True)),
        constraints={"type": "eq", "fun": lambda v: m @ v - total, "jac": lambda _: m},
        method="SLSQP",
        options={"ftol": 1e-14, "maxiter": 500},
    ).x
    assert_close(found, reference, 1e-5)
    assert_close(m @ found, total, 1e-13)
    assert m @ (found - u) ** 2 <= m @ (reference - u) ** 2 + 1e-9


@pytest.mark.parametrize("share", [1e-4, 0.5, 1 - 1e-4])
def test_values_and_bounds_with_a_constant_are_projected_to_the_same_with_it(share):
    """Also a negative one, and totals near the least and the largest; each column by itself.

    So are values in another unit.
    """
    rng, m = np.random.default_rng(2), np.array([1.0, 2.0, 3.0, 0.5])
    u = rng.normal(size=(4, 2))
    low, high = u - rng.random((4, 2)), u + rng.random((4, 2))
    total = m @ ((1 - share) * low + share * high)
    found = project_to_bounds_and_mass(u, low, high, m, total)
    assert_close(m @ found, total, 1e-12)
    for c in (-50.0, 50.0):
        moved = project_to_bounds_and_mass(u + c, low + c, high + c, m, total + c * m.sum())
        assert_close(moved, found + c, 1e-12)
    for unit in (1e-9, 1e9):
        scaled = project_to_bounds_and_mass(u * unit, low * unit, high * unit, m, total * unit)
        assert_close(scaled / unit, found, 1e-12)


@pytest.mark.parametrize("unit", [1e-8, 1.0, 1e8])
@pytest.mark.parametrize("end", ["low", "high"])
def test_the_extreme_masses_determine_the_values(end, unit):
    """At the largest or smallest possible total the values are the bounds.

    A total beyond is refused, unless by rounding.
    """
    u = np.array([[0.3], [0.9], [0.1]]) * unit
    low, high, m = u - 0.1 * unit, u + 0.2 * unit, np.array([0.1, 0.2, 0.3])
    edge = {"low": low, "high": high}[end]
    for rounding in (-1e-13, 0.0, 1e-13):
        found = project_to_bounds_and_mass(u, low, high, m, m @ edge * (1 + rounding))
        assert_close(found / unit, edge / unit, 1e-9)
    for one in (u, 0 * u):  # nothing to choose
        assert_close(project_to_bounds_and_mass(one, one, one, m, m @ one), one, 0.0)
    beyond = m @ edge * (1 + 1e-9 if end == "high" else 1 - 1e-9)
    with pytest.raises(
        ValueError,
        match=r"cannot be .* within the bounds of neighbouring values",
    ):
        project_to_bounds_and_mass(u, low, high, m, beyond)


def test_the_velocity_between_snapshots_is_linear_in_time():
    """At the time of a snapshot it is the velocity in this snapshot. Before the first snapshot and
    after the last one there is none.
    """
    times, rng = [2.0, 3.0, 5.0, 9.0], np.random.default_rng(0)
    values, method = rng.normal(size=(4, 2)), LeastSquares(np.eye(2), degree=0)
    wind = Snapshots(times, [method.field(np.tile(v, (2, 1))) for v in values])
    x = np.array([[0.3, 0.7]])
    for t in (*times, 2.3, 3.1, 4.9, 6.0, 8.5, 2.0 - 6.5e-9, 9.0 + 6.5e-9):
        expected = [np.interp(t, times, component) for component in values.T]
        assert_close(wind(x, t)[0], np.array(expected), 1e-7)
    for t in (2.0 - 7.5e-9, 9.0 + 7.5e-9):
        with pytest.raises(ValueError, match=r"lies outside the snapshots, 2\.0 to 9\.0"):
            wind(x, t)
    pair = Snapshots(times[:2], wind.fields[:2])
    assert_close(pair(x, 2.5)[0], (values[0] + values[1]) / 2, 1e-12)
    with pytest.raises(ValueError, match="times must increase, one for each"):
        Snapshots([2.0, 2.0], pair.fields)


def test_in_a_wind_that_grows_linearly_the_times_of_entry_are_exact():
    """Then the way is quadratic in time: x = (1 + t) s - s²/2 for the time s since the entry."""
    x, t, dt = np.array([[0.1, 1.0], [0.5, 2.0], [1.3, 3.0], [2.0, 4.0]]), 2.0, 0.5

    def wind(y, time):
        return np.tile([1.0 + time, 0.0], (len(y), 1))

    flow = Inflow(lambda y: y[:, 0], lambda y, _: y[:, 0])
    entered = entries(x, departure_points(x, wind, t, dt), wind, t, dt, flow)
    assert entered.which.tolist() == [0, 1, 2]
    assert_close(entered.points, x[:3] * [0.0, 1.0], 1e-12)
    assert_close(entered.delays, 1 + t - np.sqrt((1 + t) ** 2 - 2 * x[:3, 0]), 1e-12)
    edge = x * [0.0, 1.0]  # in still air nothing enters, also there
    assert not len(entries(edge, edge, lambda y, _: 0 * y, t, dt, flow).which)


def test_the_first_state_is_that_which_is_given():
    """With no further time it is the only one."""
    x = disc(60)
    (only,) = semi_lagrangian(LeastSquares(x), hill(x), rotation, [2.5])
    assert only.time == 2.5
    assert np.array_equal(only.values, hill(x))


# --- refusals -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"scheme": "rk5"}, "scheme must be one of euler, midpoint, heun, rk4; got 'rk5'"),
        ({"times": [0, 1, 1]}, "times must be increasing finite numbers"),
        ({"times": [0, np.inf]}, "times must be increasing finite numbers"),
        ({"times": [[0], [1]]}, "times must be increasing finite numbers"),
        ({"times": []}, "times must be increasing finite numbers"),
        ({"values": np.ones(3)}, "values must have one entry for each point"),
        ({"velocity": None}, r"values that are the velocity must have the shape"),
        ({"velocity": lambda y, _: y[:, 0]}, "velocity must give vectors of the shape"),
        ({"velocity": lambda y, _: y * np.nan}, "velocity must be finite"),
        (
            {"values": 1j * hill(disc(60)), "bounded": True},
            "bounds and masses are kept of real values",
        ),
        ({"masses": lambda m: -np.ones(len(m.points))}, "masses must be positive"),
        ({"masses": lambda m: np.arange(len(m.points))}, "masses must be positive"),
        ({"masses": lambda m: np.ones((len(m.points), 1))}, "masses .* one for each site"),
        (
            {"masses": np.ones(80), "inflow": Inflow(lambda y: y[:, 0], lambda *_: 0)},
            "masses cannot be kept where there is inflow",
        ),
    ],
)
def test_invalid_arguments_are_refused(options, words):
    """The message names the argument."""
    x = disc(60)
    given = {"values": hill(x), "velocity": rotation, "times": [0.0, 0.1], **options}
    with pytest.raises(ValueError, match=words):
        last(
            LeastSquares(x), given.pop("values"), given.pop("velocity"), given.pop("times"), **given
        )


def test_invalid_snapshot_times_are_refused():
    """Times must increase, and a query time must lie between the first and the last."""
    field = LeastSquares(disc(60)).field(disc(60))
    with pytest.raises(ValueError, match="times must increase, one for each of at least two"):
        Snapshots([1.0, 0.0], [field, field])
    with pytest.raises(ValueError, match=r"the time 2 lies outside the snapshots, 0\.0 to 1\.0"):
        Snapshots([0.0, 1.0], [field, field])(disc(60), 2.0)
