"""Experiments on coupling and advection, compared with independently computed values."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp

from fieldrecon.advection.semi_lagrangian_steps import semi_lagrangian
from fieldrecon.coupling.flat_structures import blended_plates
from fieldrecon.coupling.rigid_body_motions import net_force_and_moment
from fieldrecon.coupling.transfer import Coupling
from fieldrecon.datasets.synthetic import halton
from fieldrecon.methods.partition_of_unity.method import PartitionOfUnityRBF
from fieldreport import experiments
from fieldreport.experiments.advection import adaptive_front, advection, slotted_disc
from fieldreport.experiments.coupling import coupling
from laws import assert_close, difference_quotient


@pytest.fixture(scope="module")
def wings():
    return experiments.get("coupling").run(coupling.Params(stations=(8,), pictured=24))


def test_closed_forms_of_the_elliptic_wing_agree_with_quadrature():
    """Lift, moments and tip deflection of an elliptic lift distribution."""
    params = coupling.Params()

    def lift(y: float) -> float:
        return 4 / np.pi * np.sqrt(1 - y**2)

    expected = [
        quad(lift, 0, 1)[0],
        quad(lambda y: lift(y) * y, 0, 1)[0],
        -params.chord * quad(lambda c: 2 * (1 - c) * c, 0, 1)[0],
        quad(lambda y: lift(y) * y**2 * (3 - y) / 6, 0, 1)[0],
    ]
    assert_close(coupling.closed_forms(params), expected, 1e-8)


def test_the_tip_deflection_of_a_cantilever_agrees_with_the_beam_equation():
    """y² (3 - y) / 6 solves w'''' = 0 on both sides of the load, as an initial value problem."""
    y = 0.4
    deflection = solve_ivp(
        lambda x, w: [w[1], w[2], -1.0 if x < y else 0.0], (0, 1), [0, 0, y], max_step=0.01
    ).y[0, -1]
    found = coupling.quantities(np.array([[0.0, y, 0.0]]), np.array([[0.0, 0.0, 1.0]]))[3]
    assert_close(found, deflection, 1e-4)


@pytest.mark.slow
def test_transposes_conserve_what_the_method_reproduces(wings):
    """Reproducing linear fields conserves force and moments, reproducing constants the force."""
    table = wings.tables["errors"]
    errors = {row[0]: row[1:4] for row in table.rows}
    for way in ("transpose, linear", "transpose, patches", "transpose, flat"):
        assert max(errors[way]) <= coupling.ROUNDING
    assert (
        errors["transpose, constants"][0] <= coupling.ROUNDING < errors["transpose, constants"][1]
    )
    assert errors["forces interpolated"][0] > 0.9
    assert errors["pressures interpolated"][0] > 0.01


def test_the_deforming_flow_is_divergence_free_and_reverses():
    """No velocity crosses the sides of the square."""
    x = 0.02 + 0.9 * np.random.default_rng(0).random((30, 2))
    slopes = difference_quotient(lambda y: advection.deforming(1.5, y, 0.3), x, 1e-3)
    assert_close(np.trace(slopes, axis1=1, axis2=2), np.zeros(30), 1e-8)
    there = advection.deforming(1.5, x, 0.3)
    assert_close(advection.deforming(1.5, x, 1.2), -there, 1e-12)
    side = np.column_stack([np.zeros(5), np.linspace(0, 1, 5)])
    assert_close(advection.deforming(1.5, side, 0.0)[:, 0], np.zeros(5), 1e-12)


@pytest.mark.slow
def test_the_initial_shapes_have_their_known_integrals():
    """The area of the slotted disc, and the volumes of cone and hump, summed on a fine grid."""
    g = (np.arange(1000) + 0.5) / 1000
    sums = advection.shapes(np.stack(np.meshgrid(g, g), axis=-1).reshape(-1, 2)).mean(axis=0)
    r = advection.RADIUS
    half = np.arcsin(0.025 / r)
    below = 0.025 * r * np.cos(half) + r**2 * half  # of the disc, under the slot's ceiling
    disc = np.pi * r**2 - below - 0.05 * 0.1
    hump = quad(lambda s: np.pi * s * (1 + np.cos(np.pi * s / r)), 0, r)[0]
    assert_close(sums, [disc, np.pi * r**2 / 3, hump], 1e-4)


def test_time_integrators_have_their_orders():
    """The orders are one, two, two and four."""
    steps = (32, 64)
    for scheme, order in {"euler": 1, "midpoint": 2, "heun": 2, "rk4": 4}.items():
        coarse, fine = (advection.time_error((scheme, k)) for k in steps)
        assert abs(np.log2(coarse / fine) - order) < 0.3


@pytest.mark.slow
def test_a_large_coupling_conserves_force_and_moment():
    """10⁴ nodes and 10⁵ surface points, with sparse weights."""

    x, y = (
        np.column_stack([p, np.cos(4 * p[:, 0]) * p[:, 1]])
        for p in (halton(10_000, 2), 1.01 * halton(100_000, 2, seed=1))
    )
    t = Coupling(blended_plates(x), y)
    f = np.sin(9 * y)
    assert t._weights.nnz < 200 * len(y)
    assert_close(net_force_and_moment(x, t.loads(f)), net_force_and_moment(y, f), 1e-6)


@pytest.mark.slow
def test_a_hundred_steps_on_a_hundred_thousand_sites_have_a_small_error():
    """A hill makes one revolution; all steps use the same matrix."""

    x = advection.disc(100_000)
    hill = np.exp(-50 * ((x - [0.5, 0.7]) ** 2).sum(axis=1))
    times = np.linspace(0, 1, 101)
    *_, end = semi_lagrangian(PartitionOfUnityRBF(x), hill, advection.turning, times, steady=True)
    assert np.abs(end.values - hill).max() < 1e-4


def test_the_boundary_of_the_slotted_disc_has_its_length_and_area():
    """The signed distance has known values at four points."""
    r, half = advection.RADIUS, np.arcsin(slotted_disc.SLOT / advection.RADIUS)
    x = slotted_disc.rim()
    length = np.linalg.norm(np.diff(x, axis=0), axis=1).sum()
    slot = slotted_disc.TOP + r * np.cos(half)
    assert_close(length, (2 * np.pi - 2 * half) * r + 2 * slot + 2 * slotted_disc.SLOT, 1e-4)
    a, b = (x - advection.DISC).T
    area = abs(np.sum(a * np.roll(b, -1) - b * np.roll(a, -1))) / 2
    exact = np.pi * r**2 - r**2 * (half - np.sin(2 * half) / 2) - 2 * slotted_disc.SLOT * slot
    assert_close(area, exact, 1e-5)
    off = advection.DISC + np.array([[0.0, 0.0], [0.0, 0.12], [0.08, 0.0], [0.2, 0.0]])
    found = slotted_disc.signed_distance(off)
    assert_close(found, [0.025, -0.02, -0.055, 0.05], 1e-4)


def test_the_numbers_of_sites_agree_with_the_published_meshes():
    """Doubling the step divides the number by four."""
    assert [slotted_disc.sites_of(k) for k in range(4)] == [1130, 4520, 18078, 72314]


@pytest.mark.slow
@pytest.mark.parametrize("shift", [1e-4, 0.0])
def test_the_adaptive_sites_do_not_depend_on_rounding(monkeypatch, shift):
    """Without the shift, sites have equal distances and rounding selects their neighbours.

    The shift of the sites makes the refinement independent of perturbations by 1e-14.
    """
    params = replace(adaptive_front.QUICK, sites=400, spacing=0.008, rounds=3, shift=shift)
    found = []
    for seed in range(3):
        noise = 1e-14 * np.random.default_rng(seed).standard_normal((400, 2))
        monkeypatch.setattr(
            adaptive_front, "halton", lambda n, d, noise=noise: halton(n, d) * (1 + noise)
        )
        counts, error, _ = adaptive_front.carried(params, 0)
        found.append((*counts, round(error, 9)))
    assert (len(set(found)) == 1) == (shift > 0)


@pytest.mark.slow
def test_steps_in_the_disc_are_nearly_stable_and_not_strictly():
    """The spectral radius agrees with the growth of the norms of high powers."""
    params = advection.Params()
    radius = advection.radius_of_rotated(params, 60.0)
    assert 1e-4 < radius - 1 < 1e-2
    assert radius == pytest.approx(growth_of_powers(params, 60.0), rel=1e-6)
    assert advection.radius_of_rotated(params, 360.0) == pytest.approx(
        advection.spectral_radius(advection.step_matrix(params, advection.disc(params.powers))),
        rel=1e-9,
    )


def growth_of_powers(params: advection.Params, degrees: float, squarings: int = 16) -> float:
    """Return ‖H^2k‖ / ‖H^k‖ per step, k = 2^squarings: it tends to the spectral radius."""
    turn = np.exp(1j * np.deg2rad(degrees))
    z = (advection.disc(params.powers) - 0.5) @ [1, 1j] * turn
    h = advection.step_matrix(params, 0.5 + np.column_stack([z.real, z.imag]))
    for _ in range(squarings):
        h = h @ h
    return (np.linalg.norm(h @ h, 2) / np.linalg.norm(h, 2)) ** (1 / 2**squarings)
