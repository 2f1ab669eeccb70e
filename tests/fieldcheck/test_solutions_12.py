"""Notebook 12 and the library are two routes to one answer."""

import numpy as np
import pytest
from scipy.linalg import eigvals

from checkout import ROOT
from fieldcheck.questions.q12_aeroelastic_coupling import grid, section, wing
from fieldgrade.authoring.sources import Source
from fieldrecon import RBF, polyharmonic
from fieldrecon.coupling.flat_structures import FlatCoupling
from fieldrecon.coupling.rigid_body_motions import net_force_and_moment
from fieldrecon.coupling.transfer import Coupling

SOURCE = Source(ROOT / "solutions/12_aeroelastic_coupling.py")
NOTEBOOK = SOURCE.functions()
ROUNDING = 1e-9


def ruler(points):
    """The method of the notebook: cubes of distances, linear polynomials."""
    return RBF(points, polyharmonic(3), degree=1)


@pytest.fixture(params=[(6,), (4, 3), (3, 2, 2)], ids=["line", "plane", "space"])
def meshes(request):
    """Nodes, and places about them."""
    random = np.random.default_rng(len(request.param))
    nodes = grid(random, *request.param)
    return nodes, random.uniform(-0.3, 1.5, (7, len(request.param)))


def test_weights_and_slopes_are_those_of_the_library(meshes):
    """A column of the system more or less, the same field and its gradient."""
    nodes, places = meshes
    h, g = NOTEBOOK["weights"](nodes, places), NOTEBOOK["slopes"](nodes, places)
    np.testing.assert_allclose(h, ruler(nodes).weights(places), rtol=0, atol=ROUNDING)
    np.testing.assert_allclose(g, ruler(nodes).gradient_weights(places), rtol=0, atol=ROUNDING)


def test_slopes_are_derivatives_of_weights(meshes):
    """Central differences, whose error is of second order."""
    nodes, places = meshes
    for axis, g in zip(np.eye(nodes.shape[1]), NOTEBOOK["slopes"](nodes, places), strict=True):
        ahead, behind = (NOTEBOOK["weights"](nodes, places + s * axis) for s in (1e-4, -1e-4))
        np.testing.assert_allclose((ahead - behind) / 2e-4, g, rtol=0, atol=1e-5)


def test_loads_resultants_and_densities_are_those_of_the_library():
    """And virtual work, total force and total moment are kept."""
    random = np.random.default_rng(5)
    nodes, places = grid(random, 3, 2, 2), random.random((30, 3))
    f, areas = random.normal(size=(30, 3)), random.uniform(1, 2, 30)
    coupling = Coupling(ruler(nodes), places)
    h = NOTEBOOK["weights"](nodes, places)
    g = NOTEBOOK["loads"](h, f)
    np.testing.assert_allclose(g, coupling.loads(f), rtol=0, atol=ROUNDING)
    about = random.normal(size=3)
    whole = NOTEBOOK["resultants"](places, f, about)
    np.testing.assert_allclose(whole, net_force_and_moment(places, f, about), rtol=0, atol=ROUNDING)
    np.testing.assert_allclose(NOTEBOOK["resultants"](nodes, g, about), whole, atol=ROUNDING)
    u = random.normal(size=(12, 3))
    assert np.vdot(coupling.displacements(u), f) == pytest.approx(np.vdot(u, g))
    spread = np.abs(h)  # no node may be handed a negative area
    of_one = (spread.T @ (areas * f[:, 0])) / (spread.T @ areas)
    np.testing.assert_allclose(NOTEBOOK["densities"](spread, f[:, 0], areas), of_one)


def test_densities_are_those_of_the_library():
    """On a fine skin each node is handed a positive area."""
    nodes = np.indices((4, 4)).reshape(2, -1).T / 3
    places = (np.indices((20, 20)).reshape(2, -1).T + 0.5) / 20
    areas = np.random.default_rng(6).uniform(1, 1.2, 400)
    p = np.cos(places)
    wanted = Coupling(ruler(nodes), places).densities(p, areas)
    h = NOTEBOOK["weights"](nodes, places)
    found = [NOTEBOOK["densities"](h, column, areas) for column in p.T]
    np.testing.assert_allclose(np.transpose(found), wanted, rtol=0, atol=ROUNDING)


def test_flat_loads_are_those_of_the_library_and_keep_all_six_resultants():
    """A singular system in space, and the normal as the remedy."""
    random = np.random.default_rng(7)
    nodes = grid(random, 4, 3)
    places, f = random.normal(size=(9, 3)), random.normal(size=(9, 3))
    flat = np.pad(nodes, ((0, 0), (0, 1)))
    assert np.linalg.matrix_rank(NOTEBOOK["system"](flat)) < 12 + 4
    g = NOTEBOOK["flat_loads"](nodes, places, f)
    np.testing.assert_allclose(g, FlatCoupling(flat, places, ruler).loads(f), atol=1e-8)
    np.testing.assert_allclose(
        net_force_and_moment(flat, g), net_force_and_moment(places, f), atol=1e-8
    )


def test_the_typical_section_settles_where_the_closed_form_says():
    """θ = λ/(1 − λ) α₀ with λ = e S a / k, and divergence at 1/λ."""
    k, h, f0, a = section(np.random.default_rng(8), 0.25)
    lam = float((h.T @ a @ h / k)[0, 0])
    last = NOTEBOOK["iterates"](k, h, f0, a, 0.9, 80)[-1]
    assert last[0] == pytest.approx(lam / (1 - lam) * 0.1)
    assert NOTEBOOK["divergence"](k, h, a) == pytest.approx(1 / lam)


def test_iterates_are_powers_and_divergence_is_a_generalised_eigenvalue():
    """Errors are multiplied by I − ω (I − K⁻¹ Hᵀ A H); K u = q Hᵀ A H u by another routine."""
    random = np.random.default_rng(9)
    k, h, f0, a = wing(random, 4, 6)
    u = NOTEBOOK["iterates"](k, h, f0, a, 0.7, 9)
    end = np.linalg.solve(k - h.T @ a @ h, h.T @ f0)
    step = np.eye(4) - 0.7 * (np.eye(4) - np.linalg.solve(k, h.T @ a @ h))
    np.testing.assert_allclose(u[9], end - np.linalg.matrix_power(step, 9) @ end, atol=ROUNDING)
    a = np.abs(a)  # one positive eigenvalue at least
    q = eigvals(k, h.T @ a @ h)
    real = q[np.isfinite(q) & (np.abs(q.imag) < 1e-9)].real
    wanted = real[(real > 0) & (real < 1e9)].min()
    assert NOTEBOOK["divergence"](k, h, a) == pytest.approx(wanted)


def drawn(name):
    """A function of a cell that draws, which may call those of the cells before."""
    namespace = dict(NOTEBOOK)
    for cell in SOURCE.cells:
        if "@draw" in cell.text and cell.kind == "code" and not cell.is_setup:
            exec(cell.text.partition("@draw")[0], namespace)
    return namespace[name]


def test_the_straight_wing_of_the_picture_diverges_near_the_closed_form():
    """As π²GJ / (4 l² c e a) says to two per cent; swept forward much earlier."""
    straight, forward = (drawn("swept_wing")(np.radians(angle)) for angle in (0, -20))
    q = NOTEBOOK["divergence"](straight[0], straight[1], straight[3])
    assert q == pytest.approx(1, abs=0.02)
    assert NOTEBOOK["divergence"](forward[0], forward[1], forward[3]) < 0.6


def test_what_the_text_says_of_the_four_ways_is_so():
    """Interpolated forces lose most, pressures a tenth of the twist, the nearest node moments."""
    for stations in (3, 6, 14):
        wanted, found = drawn("arrivals")(stations)
        off = {name: np.abs(got[2:5] / wanted[2:5] - 1) for name, got in found.items()}
        assert off["your transpose"].max() < 1e-12
        assert off["to the nearest node"][0] < 1e-12
        assert off["to the nearest node"][2] > 1e-3
        assert off["forces interpolated"].min() > 0.5
        assert off["pressures interpolated"][0] < 0.01
        assert off["pressures interpolated"][2] == pytest.approx(0.12, abs=0.01)
