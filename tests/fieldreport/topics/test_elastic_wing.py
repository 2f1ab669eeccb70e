"""Static aeroelasticity: fixed-point iteration, steady state, divergence, and the atmosphere."""

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


def test_the_typical_section_converges_to_its_closed_form():
    """Rigid section on a torsion spring: K θ = q c² e a (α + θ), so θ = α q / (q_D - q)."""
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


def test_aitken_needs_two_steps_for_an_affine_function():
    """This holds for every factor, whether or not the plain iteration converges."""
    for factor in (-30.0, -0.9, 0.5, 1.5, 40.0):
        turn = partial(lambda k, x: 2 + k * x, factor)
        found = fixed_point(turn, [0.0])
        assert found.converged
        assert len(found.residuals) <= 4
        assert_close(found.value, [2 / (1 - factor)], 1e-9)
        plain = fixed_point(turn, [0.0], relaxation=1.0, maxiter=300)
        assert plain.converged == (abs(factor) < 1)


def test_a_diverging_iteration_is_stopped():
    """The first residual is that of the start; residuals that are not finite are refused."""
    grown = fixed_point(lambda x: 10 * x, [1.0, 0.0], relaxation=1.0)
    assert grown.residuals[0] == 9.0
    assert len(grown.residuals) < 12
    assert not grown.converged
    for unit in (1e-9, 1.0, 1e9):  # 8^9 is the first power above 1e8
        assert len(fixed_point(lambda x: 8 * x, [unit, 0.0], relaxation=1.0).residuals) == 10
    start = np.array([1.0, 2.0])
    at_rest = fixed_point(lambda x: x, start)
    assert not np.shares_memory(at_rest.value, start)
    assert at_rest.converged
    assert len(at_rest.residuals) == 1
    assert at_rest.contraction == 0.0
    assert fixed_point(lambda x: x / 4, [1.0, 2.0], relaxation=1.0, maxiter=1).contraction == 0.25
    with pytest.raises(ValueError, match=r"func\(x\) must be finite"):
        fixed_point(lambda x: x / 0 if np.any(x) else x + np.nan, 0.0)
    assert not fixed_point(lambda x: x + 1, 0.0, maxiter=5).converged


def test_by_default_the_first_step_goes_half_way_and_the_hundredth_is_the_last():
    """The norms of the residuals at the start and after each step are kept."""
    assert fixed_point(lambda x: x + 3, 1.0, maxiter=1).value == 2.5
    found = fixed_point(lambda x: x + 3, 1.0)
    assert np.array_equal(found.residuals, np.full(101, 3.0))
    assert not found.converged


def test_values_keep_their_shape_and_may_be_complex():
    """z = 2 + (3 + i) z has the solution -2 / (2 + i), which repetition does not find."""
    found = fixed_point(lambda z: 2 + (3 + 1j) * z, 0.0)
    assert found.converged
    assert_close(found.value, np.array(-2 / (2 + 1j)), 1e-12)
    for start, value, shape in ((1.0, np.ones(2), r"\(2,\)"), (np.ones(2), 1.0, r"\(\)")):
        with pytest.raises(
            ValueError, match=rf"func\(x\) must have the shape .* of x; got {shape}"
        ):
            fixed_point(lambda _, value=value: value, start)


# --- the coupled problem --------------------------------------------------------------------------


def check_iteration_against_feedback(made: ElasticWing) -> None:
    """The iteration gives (1 - q T)^-1 γ(θ), and without relaxation contracts by q max |λ|."""
    theta = PARAMS.incidences(30.0)
    gamma = made.circulations(made.steady_state(Q, theta).value, theta)
    stiff = made.lattice.circulations(theta).ravel()
    solved = np.linalg.solve(np.eye(len(stiff)) - Q * made.feedback, stiff)
    assert_close(gamma.ravel() / np.abs(solved).max(), solved / np.abs(solved).max(), 1e-8)
    plain = made.steady_state(Q, theta, relaxation=1.0)
    assert_close(plain.contraction, made.contraction(Q), 0.01)


def test_the_iteration_agrees_with_the_feedback_matrix():
    """The wing is swept back."""
    check_iteration_against_feedback(wing())


def test_the_feedback_of_another_load_transfer_fails():
    """A mutant: loads interpolated instead of transposed belong to another coupled system."""

    class Mixed(ElasticWing):
        @property
        def feedback(self):
            same = ElasticWing(self.plate, self.lattice, self.coupling)
            return loaded(same, "forces interpolated").feedback

    made = wing()
    with pytest.raises(AssertionError):
        check_iteration_against_feedback(Mixed(made.plate, made.lattice, made.coupling))


def test_only_the_transpose_gives_a_symmetric_flexibility():
    """Forces at surface corners and their displacements are then reciprocal."""
    made = wing()
    m = len(made.lattice.points)
    for way in WAYS:
        other = loaded(made, way)
        flexibility = other.heights(other.deflections(np.eye(m)))
        skew = np.abs(flexibility - flexibility.T).max() / np.abs(flexibility).max()
        assert (skew < 1e-9) if way == "transpose" else (skew > VISIBLE)


def test_the_divergence_pressure_of_a_straight_wing_agrees_with_strip_theory():
    """The closed form is that of strips on a beam in torsion."""
    check = straight_wing()
    assert abs(check.computed / check.closed_form - 1) < 0.002


@pytest.mark.slow
def test_a_forward_swept_wing_diverges_where_the_iteration_does():
    """For a wing swept back the plain iteration diverges too, although the wing does not."""
    forward, back = wing(-20.0), wing(30.0)
    theta = PARAMS.incidences(-20.0)
    bound = forward.divergence_pressure
    assert_close(forward.contraction(bound), 1.0, 1e-9)
    for part in (0.9, 1.1):
        found = forward.steady_state(part * bound, theta, relaxation=1.0, maxiter=400)
        assert found.converged == (part < 1)
    for part in (0.9, 0.99):  # the deflection grows towards the divergence pressure
        found = forward.steady_state(part * bound, theta).value
        assert forward.heights(found).max() > 0.5 / (1 - part)
    assert back.eigenvalues[0].real < 0
    assert back.divergence_pressure > 20 * Q
    beyond = 1.5 / back.contraction(1.0)
    assert not back.steady_state(beyond, PARAMS.incidences(30.0), relaxation=1.0).converged
    assert back.steady_state(beyond, PARAMS.incidences(30.0)).converged


def test_elasticity_reduces_the_lift_of_a_backward_swept_wing():
    """A wing swept forward gains lift."""
    for sweep, sign in ((30.0, -1), (-20.0, 1)):
        made, theta = wing(sweep), PARAMS.incidences(sweep)
        bent = made.circulations(made.steady_state(Q, theta).value, theta)
        stiff = made.lattice.circulations(theta)
        assert sign * (bent - stiff).sum() > 0.05 * stiff.sum()


def test_only_the_transpose_conserves_work_and_force():
    """The errors of the transpose are rounding; each other way violates at least one law."""
    rows = {row[0]: row[1:] for row in compared(wing(), Q, PARAMS.incidences(30.0))}
    assert max(rows["transpose"][:3]) < 1e-11
    assert rows["nearest node"][0] < 1e-11
    for way in ("nearest node", "pressures interpolated", "forces interpolated"):
        assert rows[way][2] > 1e-3
    assert rows["forces interpolated"][0] > 1


def test_corner_areas_sum_to_the_area_of_the_wing():
    made = wing()
    assert_close(corner_areas(made).sum(), made.lattice.area, 1e-9)


def test_nodes_of_another_plate_or_lattice_are_refused():
    """The order of the nodes and the plane z = 0 are checked."""
    made, other = wing(), wing(0.0)
    with pytest.raises(ValueError, match=r"coupling.structure must be the 65 nodes, with z = 0"):
        replace(made, plate=other.plate)
    with pytest.raises(ValueError, match=r"coupling.surface must be the 28 nodes"):
        replace(made, lattice=other.lattice)


# --- standard atmosphere --------------------------------------------------------------------------


def test_the_standard_atmosphere_agrees_with_the_published_table():
    """Pressures at the bases of its layers, from the U.S. Standard Atmosphere, 1976."""
    for height, temperature, pressure in (
        (0, 288.15, 101325),
        (11e3, 216.65, 22632.06),
        (20e3, 216.65, 5474.889),
    ):
        air = standard_atmosphere(height)
        assert_close(air.temperature, temperature, 1e-9)
        assert_close(air.pressure / pressure, 1.0, 5e-6)


def test_the_atmosphere_is_in_hydrostatic_equilibrium():
    """dp/dh = -ρ g, in both layers, at many heights at once as at each alone."""
    height = np.array([[3e3, 15e3], [11e3 - 2, 11e3 + 2]])
    air = standard_atmosphere(height)
    p = [standard_atmosphere(height + k).pressure for k in (-1, 1)]
    assert_close((p[1] - p[0]) / 2 / -9.80665, air.density, 1e-6)
    alone = standard_atmosphere(3e3)
    for name in ("temperature", "pressure", "density", "sound_speed"):
        assert getattr(air, name).shape == (2, 2)
        assert_close(getattr(air, name)[0, 0], getattr(alone, name), 0.0)
    assert_close(air.dynamic_pressure(0.5)[0, 0], alone.dynamic_pressure(0.5), 0.0)


def test_the_dynamic_pressure_agrees_with_the_speed():
    """ρ U² / 2 with U = M a."""
    air = standard_atmosphere(PARAMS.height)
    speed = PARAMS.mach * air.sound_speed
    assert_close(air.dynamic_pressure(PARAMS.mach), air.density * speed**2 / 2, 1e-9)


def test_heights_outside_the_table_are_refused():
    """Such heights are below sea level or above the tabulated layers."""
    for height in (-1.0, 20_001.0, [1e3, -1.0]):
        with pytest.raises(ValueError, match="height must lie between 0 and 20000 m"):
            standard_atmosphere(height)
    with pytest.raises(ValueError, match="height must be finite"):
        standard_atmosphere(np.nan)
