"""The vortex lattice: Biot-Savart law, limits of wings, and forces."""

import numpy as np
import pytest
from scipy.integrate import quad

from fieldreport.experiments.coupling.elastic_wing import elliptic_wing, long_wing
from fieldreport.experiments.coupling.vortex_lattice import VortexLattice, _horseshoe
from laws import VISIBLE, assert_close


def corners(across: int = 3, along: int = 6, sweep: float = 0.4) -> np.ndarray:
    """The corners of a tapered, swept half wing."""
    y = np.linspace(0, 3, along + 1)
    part = np.linspace(0, 1, across + 1)[:, None]
    return np.stack(np.broadcast_arrays(sweep * y + part * (1 - y / 6), y), axis=-1)


# --- induced velocity -------------------------------------------------------------------------


def by_quadrature(p, a, b) -> float:
    """The Biot-Savart law along the three segments, by adaptive quadrature."""

    def rate(at, direction) -> float:
        r = p - at
        return (direction[0] * r[1] - direction[1] * r[0]) / np.linalg.norm(r) ** 3

    ahead = np.array([1.0, 0.0])
    bound = quad(lambda t: rate(a + t * (b - a), b - a), 0, 1)[0]
    left = quad(lambda t: -rate(a + t * ahead, ahead), 0, np.inf)[0]
    right = quad(lambda t: rate(b + t * ahead, ahead), 0, np.inf)[0]
    return (bound + left + right) / (4 * np.pi)


def test_the_velocity_of_a_horseshoe_vortex_agrees_with_quadrature():
    """The points are beside the vortex, in front of it, and between its legs."""
    a, b = np.array([0.1, -0.3]), np.array([0.4, 0.9])
    for p in ([1.0, 0.2], [-0.5, 0.4], [0.7, 1.5], [0.2, -1.0]):
        found = _horseshoe(np.array([[p]]), a[None], b[None])[0, 0]
        assert_close(found, by_quadrature(np.array(p), a, b), 1e-7)


# --- limits -----------------------------------------------------------------------------------


def test_the_lift_of_an_elliptic_wing_agrees_with_lifting_line_theory():
    """To first order in the inverse aspect ratio; the lift of an infinite wing is larger."""
    check = elliptic_wing()
    assert abs(check.computed / check.closed_form - 1) < 0.002
    assert check.computed < 0.985 * 2 * np.pi


def test_the_lift_of_a_long_wing_follows_prandtl_glauert():
    """The lift slope of a flat plate is 2π / √(1 - M²)."""
    for mach in (0.0, 0.5, 0.8):
        check = long_wing(mach)
        assert abs(check.computed / check.closed_form - 1) < 0.003


def test_without_the_prandtl_glauert_factor_the_comparison_fails():
    """The lift slope would be 2π at all Mach numbers."""
    assert abs(long_wing(0.0).computed / long_wing(0.8).closed_form - 1) > 0.3


def test_the_lift_of_a_slender_wing_agrees_with_jones():
    """A delta wing of low aspect ratio A has the slope π A / 2 at any Mach number."""
    part, y = np.linspace(0, 1, 21)[:, None], np.linspace(0, 0.02, 11)
    ahead = y / 0.02
    grid = np.stack(np.broadcast_arrays(ahead + part * (1.0001 - ahead), y), axis=-1)
    for mach in (0.0, 0.8):
        wing = VortexLattice(grid, mach)
        slope = wing.lift_coefficient(wing.circulations(np.ones(wing.shape)))
        aspect = 2 * 0.02**2 / wing.area
        assert abs(slope / (np.pi * aspect / 2) - 1) < 0.08


def test_the_lift_of_a_cambered_wing_agrees_with_thin_airfoil_theory():
    """A parabolic camber of height h at zero incidence gives 4 π h."""
    part = np.linspace(0, 1, 9)
    y = np.linspace(0, 1000.0, 11)
    wing = VortexLattice(np.stack(np.meshgrid(part, y, indexing="ij"), axis=-1))
    height = np.repeat(4 * 0.01 * part * (1 - part), len(y))
    slope = 0.04 * (1 - 2 * (np.arange(8) + 0.75) / 8)
    gamma = wing.circulations(np.tile(-slope[:, None], (1, 10)))
    assert abs(2 * gamma[:, 0].sum() / (4 * np.pi * 0.01) - 1) < 0.003
    middles = wing.incidences(height)[:, 0]
    assert_close(middles, -0.04 * (1 - 2 * (np.arange(8) + 0.5) / 8), 1e-12)


# --- forces and incidences at the corners -----------------------------------------------------


def check_work_of_corner_forces(forces, wing: VortexLattice) -> None:
    """For any corner heights: 2 γ Δy times the height of the midpoint of each vortex."""
    rng = np.random.default_rng(0)
    gamma, z = rng.normal(size=wing.shape), rng.normal(size=len(wing.points))
    grid = z.reshape(wing.shape[0] + 1, -1)
    at = 3 / 4 * grid[:-1] + 1 / 4 * grid[1:]
    middle = (at[:, 1:] + at[:, :-1]) / 2
    assert_close(forces(gamma) @ z, (2 * gamma * wing.spans * middle).sum(), 1e-12)


def test_corner_forces_do_the_work_of_the_panels():
    """Force and moment are therefore conserved; several load cases are independent."""
    wing = VortexLattice(corners())
    check_work_of_corner_forces(wing.forces, wing)
    gamma = np.random.default_rng(1).normal(size=(*wing.shape, 2))
    for k in range(2):
        assert_close(wing.forces(gamma)[:, k], wing.forces(gamma[..., k]), 1e-13)


def test_equal_shares_of_the_force_violate_the_law_of_work():
    """A quarter of the force at each corner conserves the force only."""
    wing = VortexLattice(corners())

    def quarters(gamma):
        total = np.zeros((wing.shape[0] + 1, wing.shape[1] + 1))
        for i, j in np.ndindex(2, 2):
            total[i : i + wing.shape[0], j : j + wing.shape[1]] += gamma * wing.spans / 2
        return total.ravel()

    with pytest.raises(AssertionError):
        check_work_of_corner_forces(quarters, wing)


def test_a_plane_has_constant_incidence():
    """For any sweep it is minus the slope in the direction of the flow."""
    wing = VortexLattice(corners())
    z = wing.points @ [-0.3, 0.7] + 2
    assert_close(wing.incidences(z), np.full(wing.shape, 0.3), 1e-12)


def test_circulations_satisfy_the_boundary_condition():
    """The downwash of all horseshoe vortices and their images equals the incidence."""
    grid = corners()
    wing = VortexLattice(grid)
    theta = np.random.default_rng(0).normal(size=wing.shape)
    gamma = wing.circulations(theta)
    bound = 3 / 4 * grid[:-1] + 1 / 4 * grid[1:]
    rear = 1 / 4 * grid[:-1] + 3 / 4 * grid[1:]
    for i, j in ((0, 0), (2, 3), (1, 5)):
        at = (rear[i, j] + rear[i, j + 1]) / 2
        up = 0.0
        for k, m in np.ndindex(*wing.shape):
            a, b = bound[k, m], bound[k, m + 1]
            up += gamma[k, m] * by_quadrature(at, a, b)
            up += gamma[k, m] * by_quadrature(at, b * [1, -1], a * [1, -1])
        assert_close(up, -theta[i, j], 1e-6)


def test_results_scale_with_the_size_of_the_wing():
    """Twice the lengths give twice the circulations and the same lift coefficient."""
    small, large = VortexLattice(corners(), 0.6), VortexLattice(2 * corners(), 0.6)
    theta = np.random.default_rng(0).normal(size=small.shape)
    a, b = small.circulations(theta), large.circulations(theta)
    assert_close(b, 2 * a, 1e-12)
    assert_close(large.lift_coefficient(b), small.lift_coefficient(a), 1e-12)
    assert_close(large.pressures(b), small.pressures(a), 1e-11)
    mean = (small.pressures(a) * small.spans * small.chords).sum() / small.area
    assert_close(mean, small.lift_coefficient(a), 1e-12)
    assert abs(mean) > VISIBLE


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: VortexLattice(np.zeros((2, 2))), r"corners must have the shape \(a \+ 1, b \+ 1"),
        (lambda: VortexLattice(corners(), 1.0), "mach must be 0 or more, and less than 1"),
        (lambda: VortexLattice(corners()[::-1]), "run from front to back"),
        (lambda: VortexLattice(corners() + np.array([0, 1])), "y = 0 in the first"),
        (lambda: VortexLattice(corners() * np.nan), "corners must be finite"),
        (lambda: VortexLattice(corners()).circulations(np.ones(3)), r"shape \(3, 6, '...'\)"),
        (lambda: VortexLattice(corners()).incidences(np.ones(3)), "one entry for each corner"),
    ],
)
def test_invalid_wings_are_refused(make, words):
    """The message names the argument and the requirement."""
    with pytest.raises(ValueError, match=words):
        make()
