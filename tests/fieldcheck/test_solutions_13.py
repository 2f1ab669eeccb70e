"""The solutions of notebook 13 agree with the library."""

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.spatial import cKDTree

from checkout import ROOT
from fieldcheck.questions.q13_semi_lagrangian_advection import in_disc, in_square
from fieldgrade.authoring.sources import Source
from fieldrecon import RBF, polyharmonic
from fieldrecon.advection.characteristics import departure_points
from fieldrecon.advection.mass_fixer import project_to_bounds_and_mass
from fieldrecon.advection.semi_lagrangian_steps import semi_lagrangian

SOURCE = Source(ROOT / "solutions/13_semi_lagrangian_advection.py")
NOTEBOOK = SOURCE.functions()
ROUNDING = 1e-9


def cubic_rbf(points):
    """The method of the notebook: kernel r³ with linear polynomials."""
    return RBF(points, polyharmonic(3), degree=1)


def drawing_function(name):
    """A function of a drawing cell, which may call functions of earlier cells."""
    namespace = dict(NOTEBOOK)
    for cell in SOURCE.cells:
        if "@draw" in cell.text and cell.kind == "code" and not cell.is_setup:
            exec(cell.text.partition("@draw")[0], namespace)
    return namespace[name]


@pytest.mark.parametrize("scheme", ["euler", "midpoint", "rk4"])
@pytest.mark.parametrize("flow", [0, 1, 2])
def test_departure_points_agree_with_the_library(scheme, flow):
    """The flows have rotation, acceleration and strain; negative steps go forward in time."""
    x = 0.9 * in_square(np.random.default_rng(1), 4)
    for dt in (0.15, -0.1):
        wanted = departure_points(
            x, lambda y, t: NOTEBOOK["velocity"](y, t, flow), 0.4, dt, scheme=scheme
        )
        np.testing.assert_allclose(NOTEBOOK[scheme](x, 0.4, dt, flow), wanted, atol=ROUNDING)


def test_the_flows_have_the_properties_stated_in_the_text():
    """One revolution per unit of time, the closed form of the vortex, and a reversing flow."""
    x = in_disc(np.random.default_rng(2), 20)
    for flow, steps in ((0, 300), (2, 300)):
        y = 0.7 * x
        for n in range(steps):
            y = NOTEBOOK["rk4"](y, 1 - n / steps, 1 / steps, flow)
        np.testing.assert_allclose(y, 0.7 * x, atol=1e-7)
    exact = drawing_function("exact_feet")(x, 0.6, 0.05)
    np.testing.assert_allclose(NOTEBOOK["rk4"](x, 0.6, 0.05, 1), exact, atol=1e-4)
    edge = np.array([[1.0, 0.3], [-0.2, -1.0]])
    leaving = NOTEBOOK["velocity"](edge, 0.0, 2)[[0, 1], [0, 1]]
    np.testing.assert_allclose(leaving, 0, atol=1e-15)


@pytest.mark.parametrize("d", [1, 2, 3])
def test_a_row_contains_the_weights_of_the_nearest_sites(d):
    """The library's weights for these sites alone; all other entries are zero."""
    random = np.random.default_rng(d)
    sites, feet = random.random((30, d)), random.random((6, d))
    h = NOTEBOOK["step_matrix"](sites, feet, 9)
    for row, y in zip(h, feet, strict=True):
        _, near = cKDTree(sites).query(y, 9)
        wanted = np.zeros(30)
        wanted[near] = cubic_rbf(sites[near]).weights(y)
        np.testing.assert_allclose(row, wanted, atol=1e-7)


def test_many_steps_agree_with_the_library_when_all_sites_are_used():
    """The velocity depends on time."""
    sites = in_disc(np.random.default_rng(4), 40)
    u = np.cos(3 * sites[:, 0]) + sites[:, 1]
    states = semi_lagrangian(
        cubic_rbf(sites), u, lambda y, t: NOTEBOOK["velocity"](y, t, 1), np.linspace(0, 0.2, 5)
    )
    found = NOTEBOOK["advect"](sites, u, 0.05, 4, 1, 40)
    np.testing.assert_allclose(found, [s.values for s in states], atol=1e-8)


def test_bounds_agree_with_a_kd_tree_search():
    """The bounds are the extremes of the four nearest values."""
    random = np.random.default_rng(5)
    sites, u, feet = random.random((50, 2)), random.normal(size=50), random.random((20, 2))
    around = u[cKDTree(sites).query(feet, 4)[1]]
    low, high = NOTEBOOK["bounds"](sites, u, feet)
    np.testing.assert_array_equal(low, around.min(axis=1))
    np.testing.assert_array_equal(high, around.max(axis=1))


def test_the_mass_correction_agrees_with_the_library_and_is_minimal():
    """Every other field with these bounds and this mass is farther from the given field."""
    random = np.random.default_rng(6)
    u, m = random.normal(size=30), random.uniform(0.5, 2, 30)
    low, high = u - random.uniform(0.1, 1, 30), u + random.uniform(0.1, 1, 30)
    total = float(m @ (0.3 * low + 0.7 * high))
    v = NOTEBOOK["with_mass"](u, low, high, m, total)
    columns = (a[:, None] for a in (u, low, high))
    wanted = project_to_bounds_and_mass(*columns, m, np.array([total]))[:, 0]
    np.testing.assert_allclose(v, wanted, atol=ROUNDING)
    for _ in range(20):
        other = NOTEBOOK["with_mass"](u + 0.3 * random.normal(size=30), low, high, m, total)
        assert m @ (v - u) ** 2 <= m @ (other - u) ** 2


@pytest.mark.slow
def test_departure_points_of_burgers_equation_are_roots():
    """The equation y + Δt s(y) = x has one root before the wave breaks; SciPy finds it."""
    x = np.linspace(-1, 1, 30)[:, None]
    u = 0.3 + np.sin(3 * x[:, 0]) / 3
    field = cubic_rbf(x).field(u)
    found = NOTEBOOK["burgers_feet"](x, u, 0.6, 60, 30)
    for place, foot in zip(x[5:-5, 0], found[5:-5, 0], strict=True):
        root = brentq(lambda y, p=place: y + 0.6 * float(field([y])) - p, -3, 3, xtol=1e-14)
        assert foot == pytest.approx(root, abs=1e-8)


@pytest.mark.slow
def test_the_error_depends_on_the_number_of_steps_as_stated():
    """With Runge–Kutta the error falls and rises again; with Euler it falls throughout."""
    sites = drawing_function("scattered_in_disc")(250)
    u = drawing_function("hill")(sites)

    def error(scheme, steps):
        h = NOTEBOOK["step_matrix"](sites, NOTEBOOK[scheme](sites, 0, 1 / steps, 0), 21)
        return np.abs(np.linalg.matrix_power(h, steps) @ u - u).max()

    few, best, many = (error("rk4", steps) for steps in (4, 12, 60))
    assert best < few / 5
    assert best < many / 2
    errors = [error("euler", steps) for steps in (6, 12, 40)]
    assert errors == sorted(errors, reverse=True)


@pytest.mark.slow
def test_bounds_and_mass_behave_as_stated():
    """Without limits values leave the range and the mass drifts; with limits the maximum drops."""
    sites = drawing_function("scattered_in_disc")(300)
    u = drawing_function("slotted")(sites)
    feet = NOTEBOOK["rk4"](sites, 0, 1 / 24, 0)
    h = NOTEBOOK["step_matrix"](sites, feet, 21)
    free, bounded, both = (
        drawing_function("rotate_with")(sites, u, h, feet, *kept)
        for kept in ((False, False), (True, False), (True, True))
    )
    assert free.max() > 1.1
    assert free.min() < -0.1
    assert 0.003 < np.ptp(free.sum(axis=1) / u.sum()) < 0.1
    assert bounded.min() >= 0
    assert bounded.max() <= 1
    assert np.ptp(bounded.sum(axis=1) / u.sum()) > 0.003
    np.testing.assert_allclose(both.sum(axis=1), u.sum())
    below = (sites[:, 1] < -0.2) & (sites[:, 0] < 0)
    assert both[-1][below].max() < free[-1][below].max() - 0.05


def test_the_examples_of_departure_points():
    """In the solid rotation, the radii after one step of an eighth of the period."""
    start = np.array([[1.0, 0.0]])
    euler, midpoint = (NOTEBOOK[name](start, 0, 1 / 8, 0)[0] for name in ("euler", "midpoint"))
    np.testing.assert_allclose(euler, [1, -np.pi / 4])
    np.testing.assert_allclose(midpoint, [1 - np.pi**2 / 32, -np.pi / 4])
    np.testing.assert_allclose(
        np.hypot(*np.transpose([euler, midpoint])), [1.272, 1.046], atol=6e-4
    )


def test_the_examples_of_weights_bounds_and_mass():
    """The numbers of the worked examples, done by hand."""
    line = np.arange(3.0)[:, None]
    h = NOTEBOOK["step_matrix"](line, np.array([[0.5]]), 3)
    np.testing.assert_allclose(32 * h, [[13, 22, -3]])
    low, high = NOTEBOOK["bounds"](
        np.arange(4.0)[:, None], np.array([0.0, 0, 1, 0]), np.array([[1.2]])
    )
    assert (low[0], high[0]) == (0, 1)
    u, low, high = np.array([[0, 1], [0, 0], [1, 1.2]])
    np.testing.assert_allclose(NOTEBOOK["with_mass"](u, low, high, np.ones(2), 1.6), [0.4, 1.2])
    linear = np.linspace(0, 1.2, 7)[:, None]
    y = NOTEBOOK["burgers_feet"](linear, linear[:, 0], 0.5, 3, 7)
    assert y[5, 0] == pytest.approx(5 / 8)
