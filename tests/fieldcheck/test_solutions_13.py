"""Notebook 13 and the library are two routes to one answer."""

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


def ruler(points):
    """The method of the notebook: cubes of distances, linear polynomials."""
    return RBF(points, polyharmonic(3), degree=1)


def drawn(name):
    """A function of a cell that draws, which may call those of the cells before."""
    namespace = dict(NOTEBOOK)
    for cell in SOURCE.cells:
        if "@draw" in cell.text and cell.kind == "code" and not cell.is_setup:
            exec(cell.text.partition("@draw")[0], namespace)
    return namespace[name]


@pytest.mark.parametrize("scheme", ["euler", "midpoint", "rk4"])
@pytest.mark.parametrize("flow", [0, 1, 2])
def test_feet_are_those_of_the_library(scheme, flow):
    """In flows that turn, that get faster, and that stretch; forward as well."""
    x = 0.9 * in_square(np.random.default_rng(1), 4)
    for dt in (0.15, -0.1):
        wanted = departure_points(
            x, lambda y, t: NOTEBOOK["velocity"](y, t, flow), 0.4, dt, scheme=scheme
        )
        np.testing.assert_allclose(NOTEBOOK[scheme](x, 0.4, dt, flow), wanted, atol=ROUNDING)


def test_the_flows_are_what_the_text_says():
    """One turn in the time one, the closed form of the vortex, and a flow that comes back."""
    x = in_disc(np.random.default_rng(2), 20)
    for flow, steps in ((0, 300), (2, 300)):
        y = 0.7 * x
        for n in range(steps):
            y = NOTEBOOK["rk4"](y, 1 - n / steps, 1 / steps, flow)
        np.testing.assert_allclose(y, 0.7 * x, atol=1e-7)
    exact = drawn("exact_feet")(x, 0.6, 0.05)
    np.testing.assert_allclose(NOTEBOOK["rk4"](x, 0.6, 0.05, 1), exact, atol=1e-4)
    edge = np.array([[1.0, 0.3], [-0.2, -1.0]])
    leaving = NOTEBOOK["velocity"](edge, 0.0, 2)[[0, 1], [0, 1]]
    np.testing.assert_allclose(leaving, 0, atol=1e-15)


@pytest.mark.parametrize("d", [1, 2, 3])
def test_a_row_holds_the_weights_of_the_nearest_sites(d):
    """Those of the library on these sites alone, and zeros."""
    random = np.random.default_rng(d)
    sites, feet = random.random((30, d)), random.random((6, d))
    h = NOTEBOOK["step_matrix"](sites, feet, 9)
    for row, y in zip(h, feet, strict=True):
        _, near = cKDTree(sites).query(y, 9)
        wanted = np.zeros(30)
        wanted[near] = ruler(sites[near]).weights(y)
        np.testing.assert_allclose(row, wanted, atol=1e-7)


def test_many_steps_are_those_of_the_library_where_all_sites_count():
    """With a velocity that depends on time."""
    sites = in_disc(np.random.default_rng(4), 40)
    u = np.cos(3 * sites[:, 0]) + sites[:, 1]
    states = semi_lagrangian(
        ruler(sites), u, lambda y, t: NOTEBOOK["velocity"](y, t, 1), np.linspace(0, 0.2, 5)
    )
    found = NOTEBOOK["advect"](sites, u, 0.05, 4, 1, 40)
    np.testing.assert_allclose(found, [s.values for s in states], atol=1e-8)


def test_bounds_are_those_of_four_neighbours_by_a_tree():
    """The library asks a tree, the notebook sorts distances."""
    random = np.random.default_rng(5)
    sites, u, feet = random.random((50, 2)), random.normal(size=50), random.random((20, 2))
    around = u[cKDTree(sites).query(feet, 4)[1]]
    low, high = NOTEBOOK["bounds"](sites, u, feet)
    np.testing.assert_array_equal(low, around.min(axis=1))
    np.testing.assert_array_equal(high, around.max(axis=1))


def test_mass_is_kept_as_in_the_library_and_the_change_is_the_least():
    """Any other field with these bounds and this mass is farther away."""
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


def test_feet_of_burgers_are_roots():
    """y + Δt s(y) = x, by bisection; before the wave breaks there is one."""
    x = np.linspace(-1, 1, 30)[:, None]
    u = 0.3 + np.sin(3 * x[:, 0]) / 3
    field = ruler(x).field(u)
    found = NOTEBOOK["burgers_feet"](x, u, 0.6, 60, 30)
    for place, foot in zip(x[5:-5, 0], found[5:-5, 0], strict=True):
        root = brentq(lambda y, p=place: y + 0.6 * float(field([y])) - p, -3, 3, xtol=1e-14)
        assert foot == pytest.approx(root, abs=1e-8)


def test_what_the_text_says_of_the_number_of_steps_is_so():
    """Runge and Kutta: the error falls, and rises again; Euler: it falls throughout."""
    sites = drawn("scattered_in_disc")(250)
    u = drawn("hill")(sites)

    def error(scheme, steps):
        h = NOTEBOOK["step_matrix"](sites, NOTEBOOK[scheme](sites, 0, 1 / steps, 0), 21)
        return np.abs(np.linalg.matrix_power(h, steps) @ u - u).max()

    few, best, many = (error("rk4", steps) for steps in (4, 12, 60))
    assert best < few / 5
    assert best < many / 2
    errors = [error("euler", steps) for steps in (6, 12, 40)]
    assert errors == sorted(errors, reverse=True)


def test_what_the_text_says_of_bounds_and_mass_is_so():
    """Unbounded values leave the range, the mass wanders; both are kept, and the hill is cut."""
    sites = drawn("scattered_in_disc")(300)
    u = drawn("slotted")(sites)
    feet = NOTEBOOK["rk4"](sites, 0, 1 / 24, 0)
    h = NOTEBOOK["step_matrix"](sites, feet, 21)
    free, bounded, both = (
        drawn("keeping")(sites, u, h, feet, *kept)
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
