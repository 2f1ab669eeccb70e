"""Static aeroelasticity: iteration, steady state, divergence, and the standard atmosphere."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from fieldrecon.coupling.fixed_point_iteration import fixed_point
from fieldreport.experiments.coupling import elastic_wing
from fieldreport.experiments.coupling.elastic_wing import straight_wing
from fieldreport.experiments.coupling.pointwise_loads import WAYS, compared, corner_areas, loaded
from fieldreport.experiments.coupling.standard_atmosphere import standard_atmosphere
from fieldreport.experiments.coupling.static_aeroelasticity import ElasticWing
from laws import VISIBLE, assert_close

PARAMS = elastic_wing.QUICK
Q = PARAMS.pressure


def wing(sweep: float = 30.0) -> ElasticWing:
    return PARAMS.wing(sweep)


# --- fixed points -----------------------------------------------------------------------------


def test_the_typical_section():
    """A stiff section on a twisting spring: K θ = q c² e a (α + θ), so θ = α q / (q_D - q)."""
    k, slope, alpha = 3.0, 2 * np.pi / 4, 0.1
    diverges = k / slope
    for q in (0.3 * diverges, 0.9 * diverges, -0.8 * diverges):
        turn = partial(lambda q, theta: q * slope * (alpha + theta) / k, q)
        found = fixed_point(turn, 0.0, relaxation=1.0, maxiter=400)
        assert found.converged
        assert_close(found.value, alpha * q / (diverges - q), 1e-9)
        assert_close(found.contraction, abs(q) / diverges, 1e-4)
    beyond = partial(lambda q, theta: q * slope * (alpha + theta) / k, 1.1 * diverges)
    assert not fixed_point(beyond, 0.0, relaxation=1.0, maxiter=400).converged


def test_aitken_needs_two_steps_on_a_line():
    """Whatever the factor, and whether or not plain repetition converges."""
    for factor in (-30.0, -0.9, 0.5, 1.5, 40.0):
        turn = partial(lambda k, x: 2 + k * x, factor)
        found = fixed_point(turn, [0.0])
        assert found.converged
        assert len(found.residuals) <= 4
        assert_close(found.value, [2 / (1 - factor)], 1e-9)
        plain = fixed_point(turn, [0.0], relaxation=1.0, maxiter=300)
        assert plain.converged == (abs(factor) < 1)


def test_residuals_and_what_is_given_up():
    """The first is that of the start; a residual that explodes ends it, and one that is not."""
    grown = fixed_point(lambda x: 10 * x, [1.0, 0.0], relaxation=1.0)
    assert grown.residuals[0] == 9.0
    assert len(grown.residuals) < 12
    assert not grown.converged
    at_rest = fixed_point(lambda x: x, [1.0, 2.0])
    assert at_rest.converged
    assert len(at_rest.residuals) == 1
    with pytest.raises(ValueError, match=r"func\(x\) must be finite"):
        fixed_point(lambda x: x / 0 if np.any(x) else x + np.nan, 0.0)


# --- the coupled problem --------------------------------------------------------------------------


def turns_do_what_the_feedback_says(made: ElasticWing) -> None:
    """The loop comes to (1 - q T)^-1 γ(θ), and plain turns contract by q max |λ|."""
    theta = PARAMS.incidences(30.0)
    gamma = made.circulations(made.steady_state(Q, theta).value, theta)
    stiff = made.lattice.circulations(theta).ravel()
    solved = np.linalg.solve(np.eye(len(stiff)) - Q * made.feedback, stiff)
    assert_close(gamma.ravel() / np.abs(solved).max(), solved / np.abs(solved).max(), 1e-8)
    plain = made.steady_state(Q, theta, relaxation=1.0)
    assert_close(plain.contraction, made.contraction(Q), 0.01)


def test_turns_do_what_the_feedback_says():
    """Swept back."""
    turns_do_what_the_feedback_says(wing())


def test_the_law_of_turns_can_fail():
    """A feedback of loads handed over another way is that of another wing."""

    class Mixed(ElasticWing):
        @property
        def feedback(self):
            same = ElasticWing(self.plate, self.lattice, self.coupling)
            return loaded(same, "forces interpolated").feedback

    made = wing()
    with pytest.raises(AssertionError):
        turns_do_what_the_feedback_says(Mixed(made.plate, made.lattice, made.coupling))


def test_the_flexibility_of_the_surface_is_symmetric_with_the_transpose_alone():
    """Forces at the corners and their heights are reciprocal, as at the plate's nodes."""
    made = wing()
    m = len(made.lattice.points)
    for way in WAYS:
        other = loaded(made, way)
        flexibility = other.heights(other.deflections(np.eye(m)))
        skew = np.abs(flexibility - flexibility.T).max() / np.abs(flexibility).max()
        assert (skew < 1e-9) if way == "transpose" else (skew > VISIBLE)


def test_divergence_of_a_straight_wing():
    """That of strips on a beam that twists."""
    check = straight_wing()
    assert abs(check.computed / check.closed_form - 1) < 0.002


def test_a_wing_swept_forward_diverges_where_plain_turns_cease_to_contract():
    """And one swept back does not, though plain turns cease there too."""
    forward, back = wing(-20.0), wing(30.0)
    theta = PARAMS.incidences(-20.0)
    bound = forward.divergence_pressure
    assert_close(forward.contraction(bound), 1.0, 1e-9)
    for part in (0.9, 1.1):
        found = forward.steady_state(part * bound, theta, relaxation=1.0, maxiter=400)
        assert found.converged == (part < 1)
    for part in (0.9, 0.99):  # the nearer, the larger
        found = forward.steady_state(part * bound, theta).value
        assert forward.heights(found).max() > 0.5 / (1 - part)
    assert back.eigenvalues[0].real < 0
    assert back.divergence_pressure > 20 * Q
    beyond = 1.5 / back.contraction(1.0)
    assert not back.steady_state(beyond, PARAMS.incidences(30.0), relaxation=1.0).converged
    assert back.steady_state(beyond, PARAMS.incidences(30.0)).converged


def test_lift_is_lost_where_the_nose_goes_down():
    """By a wing swept back; one swept forward gains."""
    for sweep, sign in ((30.0, -1), (-20.0, 1)):
        made, theta = wing(sweep), PARAMS.incidences(sweep)
        bent = made.circulations(made.steady_state(Q, theta).value, theta)
        stiff = made.lattice.circulations(theta)
        assert sign * (bent - stiff).sum() > 0.05 * stiff.sum()


def test_work_and_force_by_the_transpose_alone():
    """The table of the ways: rounding in the first row, and somewhere not in the others."""
    rows = {row[0]: row[1:] for row in compared(wing(), Q, PARAMS.incidences(30.0))}
    assert max(rows["transpose"][:3]) < 1e-11
    assert rows["nearest node"][0] < 1e-11
    for way in ("nearest node", "pressures interpolated", "forces interpolated"):
        assert rows[way][2] > 1e-3
    assert rows["forces interpolated"][0] > 1


def test_areas_of_corners_are_those_of_panels():
    """In sum."""
    made = wing()
    assert_close(corner_areas(made).sum(), made.lattice.area, 1e-9)


def test_nodes_must_be_those_of_plate_and_lattice():
    """In this order, in the plane z = 0."""
    made, other = wing(), wing(0.0)
    with pytest.raises(ValueError, match=r"coupling.structure must be the 65 nodes, with z = 0"):
        replace(made, plate=other.plate)
    with pytest.raises(ValueError, match=r"coupling.surface must be the 28 nodes"):
        replace(made, lattice=other.lattice)


# --- the air ------------------------------------------------------------------------------------


def test_the_standard_atmosphere():
    """Pressures at the bases of its layers, as printed in the U.S. Standard Atmosphere, 1976."""
    for height, temperature, pressure in (
        (0, 288.15, 101325),
        (11e3, 216.65, 22632.06),
        (20e3, 216.65, 5474.889),
    ):
        air = standard_atmosphere(height)
        assert_close(air.temperature, temperature, 1e-9)
        assert_close(air.pressure / pressure, 1.0, 5e-6)


def test_air_hangs_on_itself():
    """dp/dh = -ρ g, in both layers."""
    for height in (3e3, 15e3):
        p = [standard_atmosphere(height + k).pressure for k in (-1, 1)]
        assert_close((p[1] - p[0]) / 2 / -9.80665, standard_atmosphere(height).density, 1e-6)


def test_dynamic_pressure_is_that_of_the_speed():
    """ρ U² / 2 with U = M a."""
    air = standard_atmosphere(PARAMS.height)
    speed = PARAMS.mach * air.sound_speed
    assert_close(air.dynamic_pressure(PARAMS.mach), air.density * speed**2 / 2, 1e-9)


def test_heights_without_air_are_refused():
    """Below the sea, and above what is tabulated here."""
    for height in (-1.0, 20_001.0, np.nan):
        with pytest.raises(ValueError, match="height must lie between 0 and 20000 m"):
            standard_atmosphere(height)
