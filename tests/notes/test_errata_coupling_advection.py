"""Errors and omissions of the book on aeroelastic coupling (1.2) and semi-Lagrangian steps (1.3).

Each counterexample follows the printed sentence, mostly in rational numbers; the correct statement
is then tested on the library as well.
"""

from fractions import Fraction as F

import numpy as np
import pytest

import fieldrecon as fr
from fieldrecon.advection.characteristics import Inflow, departure_points
from fieldrecon.advection.semi_lagrangian_steps import semi_lagrangian
from fieldrecon.coupling.flat_structures import couple
from fieldrecon.coupling.rigid_body_motions import net_force_and_moment
from fieldrecon.coupling.transfer import Coupling
from fieldrecon.kernels.conditionally_positive_definite import thin_plate_spline
from fieldrecon.methods.rbf import RBF
from rational import inverse, product, rank, times, transposed

ROUNDING = 1e-12
STRUCTURE = [F(0), F(2), F(5)]
SKIN = [F(k, 2) for k in range(11)]


def hats(nodes, x):
    """Weights of piecewise linear interpolation in rational numbers, (len(x), len(nodes))."""

    def weight(p, k):
        if k and nodes[k - 1] <= p < nodes[k]:
            return (p - nodes[k - 1]) / (nodes[k] - nodes[k - 1])
        if k + 1 < len(nodes) and nodes[k] <= p <= nodes[k + 1]:
            return (nodes[k + 1] - p) / (nodes[k + 1] - nodes[k])
        return F(p == nodes[k])

    return [[weight(p, k) for k in range(len(nodes))] for p in x]


def work(u, f):
    """Sum over the nodes of displacement times force."""
    return sum(a * b for a, b in zip(u, f, strict=True))


def test_loads_by_evaluation_lose_force_and_work():
    """p. 5: G1 = 1 and 1ᵀG = 1ᵀ together say |X| = 1ᵀG1 = |Y|; the transpose keeps force and work.

    Interpolated loads recover constants, so they cannot keep the sum; the transpose of the
    displacements keeps the sum, so it cannot recover constants.
    """
    down, up = hats(SKIN, STRUCTURE), hats(STRUCTURE, SKIN)
    ones, u = [F(1)] * len(SKIN), [F(1), F(-2), F(4)]
    f = [F(k * k - 7) for k in range(len(SKIN))]
    moved = times(up, u)
    evaluated, transpose = times(down, ones), times(transposed(up), ones)
    assert evaluated == [1, 1, 1]
    assert sum(evaluated) != sum(ones) == sum(transpose)
    assert transpose != [1, 1, 1]
    assert work(u, times(down, f)) != work(moved, f) == work(u, times(transposed(up), f))
    sites = fr.datasets.halton(12, 2)
    coupling = Coupling(RBF(sites, thin_plate_spline()), fr.datasets.halton(40, 2, seed=1))
    loads = coupling.loads(np.ones((40, 2)))
    np.testing.assert_allclose(loads.sum(axis=0), 40, rtol=ROUNDING)
    assert abs(loads - 1).max() > 1


def test_densities_can_be_constant_where_loads_cannot():
    """p. 5: force per length is recovered and its integral kept, with M_X of the moved lengths."""
    up = hats(STRUCTURE, SKIN)
    lengths = [F(1, 4), *[F(1, 2)] * 9, F(1, 4)]
    own = times(transposed(up), lengths)
    density = [F(k) for k in range(11)]
    arrived = times(transposed(up), [m * g for m, g in zip(lengths, density, strict=True)])
    assert sum(arrived) == work(lengths, density)
    assert [a / m for a, m in zip(times(transposed(up), lengths), own, strict=True)] == [1, 1, 1]
    coupling = Coupling(
        fr.NaturalCubicSpline(np.array([0.0, 2, 5])), np.array(SKIN, float)[:, None]
    )
    mass = np.array(lengths, dtype=float)
    np.testing.assert_allclose(coupling.densities(np.ones((11, 1)), mass), 1, rtol=ROUNDING)


def test_work_is_kept_without_interpolation():
    """p. 6: a regression C does not interpolate, and with loads by Cᵀ no step loses work.

    Interpolation of displacements and of loads, as the book has it, loses work.
    """
    basis = [[F(1), x] for x in [*STRUCTURE, F(7)]]
    pseudo = product(inverse(product(transposed(basis), basis)), transposed(basis))
    u = [F(0), F(3), F(-1), F(2)]
    assert times(product(basis, pseudo), u) != u  # it does not interpolate
    c = product([[F(1), y] for y in SKIN], pseudo)
    f = [F((-1) ** k * k) for k in range(len(SKIN))]
    assert work(times(c, u), f) == work(u, times(transposed(c), f))
    assert sum(times(transposed(c), f)) == sum(f)
    up, down = hats(STRUCTURE, SKIN), hats(SKIN, STRUCTURE)
    assert times(hats(STRUCTURE, STRUCTURE), u[:3]) == u[:3]  # this one interpolates
    assert work(times(up, u[:3]), f) != work(u[:3], times(down, f))


def test_a_flat_structure_does_not_determine_linear_fields():
    """p. 6: for coplanar nodes linear polynomials in space have rank 3, not 4; a rotation is lost.

    The library refuses; with the rotations of the plane as further data moments are kept.
    """
    nodes = [[F(i), F(j), F(0)] for i in range(3) for j in range(4)]
    assert rank([[F(1), *p] for p in nodes]) == 3
    flat = np.array(nodes, dtype=float)
    skin = flat + np.array([0.25, 0.5, 0.75])
    with pytest.raises(np.linalg.LinAlgError):
        RBF(flat, thin_plate_spline(), degree=1)
    f = np.cos(skin)
    kept = net_force_and_moment(flat, couple(flat, skin).loads(f))
    np.testing.assert_allclose(kept, net_force_and_moment(skin, f), rtol=1e-10)


def test_work_is_one_number_for_all_components():
    """p. 5-6: forces and displacements are vectors; work by components is more than work.

    On a flat structure a force along the plane, at a height, does its work through the rotation
    of the normal: what one component gives, another receives.
    """
    flat = np.pad(np.indices((4, 5)).reshape(2, -1).T * 1.0, ((0, 0), (0, 1)))
    skin = flat + np.array([0.25, 0.5, 0.75])
    coupling = couple(flat, skin)
    u, f = np.cos(flat @ np.array([[1, 2, 3], [2, 1, 1], [0, 0, 0]])), np.zeros_like(skin)
    f[:, 0] = np.arange(len(skin))
    above, below = coupling.displacements(u) * f, u * coupling.loads(f)
    assert above.sum() == pytest.approx(below.sum(), rel=1e-10)
    assert abs(above.sum(axis=0) - below.sum(axis=0)).max() > 0.1


def test_a_curve_of_constant_values_need_not_be_a_characteristic():
    """p. 7: u(x - t, y) is constant along (t, c(t)) for any c; only y' = a is a characteristic."""

    def u(place, t):
        return (place[0] - t) ** 2

    times_ = [F(k) for k in range(5)]
    for curve in ([(t, 5 * t * t) for t in times_], [(t, F(3)) for t in times_]):
        assert {u(place, t) for place, t in zip(curve, times_, strict=True)} == {0}
    rises = {5 * (t + 1) ** 2 - 5 * t * t for t in times_}
    assert 0 not in rises  # but the velocity (1, 0) does not rise
    foot = departure_points([[2.0, 3.0]], lambda x, _: np.tile([1.0, 0.0], (len(x), 1)), 2.0, 2.0)
    np.testing.assert_allclose(foot, [[0.0, 3.0]], atol=ROUNDING)


def test_upstream_points_outside_need_values_at_the_inflow():
    """p. 7: two solutions agree at all sites at first, and differ where the flow has entered.

    Without values at the inflow a method extrapolates; with them it finds either solution.
    """
    x = np.linspace(0, 1, 41)[:, None]
    method = RBF(x, fr.polyharmonic(3))

    def wind(y, _):
        return np.ones_like(y)

    times_ = np.linspace(0, 0.5, 11)
    for entering in (0.0, 2.0):
        inflow = Inflow(lambda y: y[:, 0], lambda _, t, value=entering: value * t)
        *_, last = semi_lagrangian(method, x[:, 0] * 0, wind, times_, inflow=inflow)
        expected = entering * np.maximum(0.5 - x[:, 0], 0)
        assert abs(last.values - expected).max() < 0.03
    *_, alone = semi_lagrangian(method, x[:, 0] * 0, wind, times_)
    assert abs(alone.values).max() < ROUNDING
