"""The solutions of notebook 12 agree with the library."""

import numpy as np
import pytest
from scipy.linalg import eigvals

from checkout import ROOT
from fieldcheck.questions.q12_steady_state import section, wing
from fieldcheck.questions.q12_weights_and_slopes import grid
from fieldgrade.authoring.sources import Source
from fieldrecon import RBF, polyharmonic
from fieldrecon.coupling.flat_structures import FlatCoupling
from fieldrecon.coupling.rigid_body_motions import net_force_and_moment
from fieldrecon.coupling.transfer import Coupling

SOURCE = Source(ROOT / "solutions/12_aeroelastic_coupling.py")
NOTEBOOK = SOURCE.functions()
ROUNDING = 1e-9


def cubic_rbf(points):
    """The method of the notebook: kernel r³ with linear polynomials."""
    return RBF(points, polyharmonic(3), degree=1)


@pytest.fixture(params=[(6,), (4, 3), (3, 2, 2)], ids=["line", "plane", "space"])
def meshes(request):
    """Nodes, and points near them."""
    random = np.random.default_rng(len(request.param))
    nodes = grid(random, *request.param)
    return nodes, random.uniform(-0.3, 1.5, (7, len(request.param)))


def test_weights_and_slopes_agree_with_the_library(meshes):
    nodes, queries = meshes
    h, g = NOTEBOOK["weights"](nodes, queries), NOTEBOOK["slopes"](nodes, queries)
    np.testing.assert_allclose(h, cubic_rbf(nodes).weights(queries), rtol=0, atol=ROUNDING)
    np.testing.assert_allclose(g, cubic_rbf(nodes).gradient_weights(queries), rtol=0, atol=ROUNDING)


def test_slopes_are_the_derivatives_of_the_weights(meshes):
    """Central differences have an error of second order."""
    nodes, queries = meshes
    for axis, g in zip(np.eye(nodes.shape[1]), NOTEBOOK["slopes"](nodes, queries), strict=True):
        ahead, behind = (NOTEBOOK["weights"](nodes, queries + s * axis) for s in (1e-4, -1e-4))
        np.testing.assert_allclose((ahead - behind) / 2e-4, g, rtol=0, atol=1e-5)


def test_loads_resultants_and_densities_agree_with_the_library():
    """Virtual work, total force and total moment are conserved."""
    random = np.random.default_rng(5)
    nodes, queries = grid(random, 3, 2, 2), random.random((30, 3))
    f, areas = random.normal(size=(30, 3)), random.uniform(1, 2, 30)
    coupling = Coupling(cubic_rbf(nodes), queries)
    h = NOTEBOOK["weights"](nodes, queries)
    g = NOTEBOOK["loads"](h, f)
    np.testing.assert_allclose(g, coupling.loads(f), rtol=0, atol=ROUNDING)
    about = random.normal(size=3)
    whole = NOTEBOOK["resultants"](queries, f, about)
    np.testing.assert_allclose(
        whole, net_force_and_moment(queries, f, about), rtol=0, atol=ROUNDING
    )
    np.testing.assert_allclose(NOTEBOOK["resultants"](nodes, g, about), whole, atol=ROUNDING)
    u = random.normal(size=(12, 3))
    assert np.vdot(coupling.displacements(u), f) == pytest.approx(np.vdot(u, g))
    spread = np.abs(h)  # no node may receive a negative area
    of_one = (spread.T @ (areas * f[:, 0])) / (spread.T @ areas)
    np.testing.assert_allclose(NOTEBOOK["densities"](spread, f[:, 0], areas), of_one)


def test_densities_on_a_fine_skin_agree_with_the_library():
    """Each node receives a positive area."""
    nodes = np.indices((4, 4)).reshape(2, -1).T / 3
    queries = (np.indices((20, 20)).reshape(2, -1).T + 0.5) / 20
    areas = np.random.default_rng(6).uniform(1, 1.2, 400)
    p = np.cos(queries)
    wanted = Coupling(cubic_rbf(nodes), queries).densities(p, areas)
    h = NOTEBOOK["weights"](nodes, queries)
    found = [NOTEBOOK["densities"](h, column, areas) for column in p.T]
    np.testing.assert_allclose(np.transpose(found), wanted, rtol=0, atol=ROUNDING)


def test_flat_loads_agree_with_the_library_and_conserve_force_and_moment():
    """For a flat structure the system in space is singular; the normal direction is added."""
    random = np.random.default_rng(7)
    nodes = grid(random, 4, 3)
    queries, f = random.normal(size=(9, 3)), random.normal(size=(9, 3))
    flat = np.pad(nodes, ((0, 0), (0, 1)))
    assert np.linalg.matrix_rank(NOTEBOOK["system"](flat)) < 12 + 4
    g = NOTEBOOK["flat_loads"](nodes, queries, f)
    np.testing.assert_allclose(g, FlatCoupling(flat, queries, cubic_rbf).loads(f), atol=1e-8)
    np.testing.assert_allclose(
        net_force_and_moment(flat, g), net_force_and_moment(queries, f), atol=1e-8
    )


def test_the_typical_section_converges_to_its_closed_form():
    """θ = λ/(1 − λ) α₀ with λ = e S a / k, and divergence at the pressure 1/λ."""
    k, h, f0, a = section(np.random.default_rng(8), 0.25)
    lam = float((h.T @ a @ h / k)[0, 0])
    last = NOTEBOOK["iterates"](k, h, f0, a, 0.9, 80)[-1]
    assert last[0] == pytest.approx(lam / (1 - lam) * 0.1)
    assert NOTEBOOK["divergence"](k, h, a) == pytest.approx(1 / lam)


def test_iterates_are_powers_and_divergence_is_a_generalized_eigenvalue():
    """Errors are multiplied by I − ω (I − K⁻¹HᵀAH); SciPy solves K u = q HᵀAH u."""
    random = np.random.default_rng(9)
    k, h, f0, a = wing(random, 4, 6)
    u = NOTEBOOK["iterates"](k, h, f0, a, 0.7, 9)
    end = np.linalg.solve(k - h.T @ a @ h, h.T @ f0)
    step = np.eye(4) - 0.7 * (np.eye(4) - np.linalg.solve(k, h.T @ a @ h))
    np.testing.assert_allclose(u[9], end - np.linalg.matrix_power(step, 9) @ end, atol=ROUNDING)
    a = np.abs(a)  # at least one positive eigenvalue
    q = eigvals(k, h.T @ a @ h)
    real = q[np.isfinite(q) & (np.abs(q.imag) < 1e-9)].real
    wanted = real[(real > 0) & (real < 1e9)].min()
    assert NOTEBOOK["divergence"](k, h, a) == pytest.approx(wanted)


def drawing_function(name):
    """A function of a drawing cell, which may call functions of earlier cells."""
    namespace = dict(NOTEBOOK)
    for cell in SOURCE.cells:
        if "@draw" in cell.text and cell.kind == "code" and not cell.is_setup:
            exec(cell.text.partition("@draw")[0], namespace)
    return namespace[name]


def test_the_straight_wing_diverges_near_the_closed_form():
    """The closed form is π²GJ / (4 l² c e a); a wing swept forward diverges much earlier."""
    straight, forward = (drawing_function("swept_wing")(np.radians(angle)) for angle in (0, -20))
    q = NOTEBOOK["divergence"](straight[0], straight[1], straight[3])
    assert q == pytest.approx(1, abs=0.02)
    assert NOTEBOOK["divergence"](forward[0], forward[1], forward[3]) < 0.6


def test_the_four_ways_of_load_transfer_have_the_stated_errors():
    """Interpolated forces lose most of the force, interpolated pressures a tenth of the twisting
    moment, and assignment to the nearest node some of the moments.
    """
    for stations in (3, 6, 14):
        wanted, found = drawing_function("arrivals")(stations)
        off = {name: np.abs(got[2:5] / wanted[2:5] - 1) for name, got in found.items()}
        assert off["your transpose"].max() < 1e-12
        assert off["to the nearest node"][0] < 1e-12
        assert off["to the nearest node"][2] > 1e-3
        assert off["forces interpolated"].min() > 0.5
        assert off["pressures interpolated"][0] < 0.01
        assert off["pressures interpolated"][2] == pytest.approx(0.12, abs=0.01)


def test_the_example_of_three_nodes():
    """The weights are 13, 22 and −3 parts of 32, and conserve force and moment."""
    row = NOTEBOOK["weights"](np.array([[0.0], [1.0], [2.0]]), np.array([[0.5]]))
    np.testing.assert_allclose(32 * row, [[13, 22, -3]])
    np.testing.assert_allclose(NOTEBOOK["loads"](row, np.array([[32.0]]))[:, 0], [13, 22, -3])


def test_the_example_of_a_fixed_point():
    """The iterates of u = (1 + u)/2 are 0, 1/2, 3/4, 7/8."""
    one = np.ones((1, 1))
    u = NOTEBOOK["iterates"](2 * one, one, np.ones(1), one, 1.0, 3)
    np.testing.assert_allclose(u[:, 0], [0, 1 / 2, 3 / 4, 7 / 8])
