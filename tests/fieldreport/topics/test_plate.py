"""Plates: polynomials represented by Morley's element, and closed forms of thin plates."""

import numpy as np
import pytest

from fieldrecon.datasets.synthetic import halton
from fieldrecon.meshes.simplex_mesh import SimplexMesh
from fieldreport.experiments.coupling.elastic_wing import cantilever, strip
from fieldreport.experiments.coupling.plate import Plate, hessians, isotropic_rigidity
from laws import VISIBLE, assert_close


def scattered(n: int = 40) -> SimplexMesh:
    return SimplexMesh.delaunay(halton(n, 2))


def degrees_of_freedom(mesh, value, gradient) -> np.ndarray:
    """Values at vertices, and normal derivatives at the midpoints of faces."""
    slopes = (mesh.face_normals * gradient(mesh.face_centers)).sum(axis=1)
    return np.concatenate([value(mesh.points), slopes])


# --- second derivatives -----------------------------------------------------------------------


def check_second_derivatives_of_quadratics(second) -> None:
    """This holds on any mesh, with any origin, and for any direction of the normals."""
    a = np.array([[1.5, -0.7], [-0.7, 0.4]])
    mesh = scattered()
    given = degrees_of_freedom(
        mesh, lambda x: 2 - x[:, 0] + (x @ a * x).sum(axis=1) / 2, lambda x: x @ a - [1, 0]
    )
    found = (second(mesh) @ given).reshape(-1, 3)
    assert_close(found, np.tile([a[0, 0], a[1, 1], 2 * a[0, 1]], (len(found), 1)), 1e-9)


def test_second_derivatives_of_quadratics_are_exact():
    """Morley's shape functions are the quadratics."""
    check_second_derivatives_of_quadratics(hessians)


def only_slopes(mesh):
    """A mutant that ignores the values at the vertices."""
    return hessians(mesh) @ np.diag([0.0] * len(mesh.points) + [1.0] * len(mesh.faces))


def once_mixed(mesh):
    """A mutant that counts the mixed derivative once instead of twice."""
    return np.diag(np.tile([1, 1, 0.5], len(mesh.cells))) @ hessians(mesh)


def slopes_leave_cells(mesh):
    """A mutant that treats each normal as outward for both cells of its face."""
    both = hessians(mesh).toarray()
    n = len(mesh.points)
    for k, row in enumerate(mesh.cell_face_signs):
        both[3 * k : 3 * k + 3, n + mesh.cell_faces[k]] *= row
    return both


@pytest.mark.parametrize("mutant", [only_slopes, once_mixed, slopes_leave_cells])
def test_mutants_of_the_second_derivatives_fail(mutant):
    """Each mutant has one error."""
    with pytest.raises(AssertionError):
        check_second_derivatives_of_quadratics(mutant)


# --- energy -----------------------------------------------------------------------------------


def test_only_rigid_motions_have_zero_energy():
    """There are three, a translation and two rotations; the stiffness matrix is symmetric."""
    mesh = scattered()
    plate = Plate(mesh, isotropic_rigidity(1.3, 0.3), mesh.points[:, 0] < 0.3)
    k = plate.stiffness.toarray()
    assert_close(k, k.T, 1e-9 * np.abs(k).max())
    energies = np.linalg.eigvalsh(k)
    assert np.abs(energies[:3]).max() < 1e-10 * energies[-1] < 1e-4 * energies[3]
    for value, slope in ((lambda x: 1 + 0 * x[:, 0], [0, 0]), (lambda x: x[:, 1], [0, 1])):
        moved = degrees_of_freedom(mesh, value, lambda x, s=slope: np.tile(s, (len(x), 1)))
        assert np.abs(k @ moved).max() < 1e-10 * energies[-1]


def test_the_flexibility_is_symmetric():
    """Maxwell's reciprocity: force and deflection may exchange their points."""
    mesh = scattered()
    plate = Plate(mesh, isotropic_rigidity(1.0, 0.3), mesh.points[:, 0] < 0.3)
    flexibility = plate.deflections(np.eye(len(mesh.points)))
    assert_close(flexibility, flexibility.T, 1e-9)
    assert np.linalg.eigvalsh((flexibility + flexibility.T) / 2)[0] > -1e-12


def test_deflections_do_not_depend_on_position_and_orientation():
    """On a plate twice as large the same forces cause four times the deflection."""
    mesh = scattered()
    turn = np.linalg.qr(np.random.default_rng(3).normal(size=(2, 2)))[0]
    other = SimplexMesh(2 * mesh.points @ turn + 5, mesh.cells)
    f = np.cos(9 * mesh.points[:, 0])
    held = mesh.points[:, 0] < 0.3
    w, far = (Plate(m, isotropic_rigidity(1.0, 0.3), held).deflections(f) for m in (mesh, other))
    assert_close(far, 4 * w, 1e-8 * np.abs(w).max())


# --- closed forms -----------------------------------------------------------------------------


def test_a_uniformly_loaded_cantilever_converges_with_order_two():
    """The limit is the Euler-Bernoulli beam, with Poisson's ratio zero."""
    errors = [c.computed / c.closed_form - 1 for c in (cantilever(4), cantilever(8))]
    assert abs(np.log2(errors[0] / errors[1]) - 2) < 0.1
    assert 0 < errors[1] < 0.002


def test_a_strip_twists_as_predicted_by_saint_venant():
    """Between two stations far from the ends the twist is T / (2 D (1 - ν) c) for the width c."""
    mesh, poisson = strip(8.0, 8, 64), 0.3
    x, y = mesh.points.T
    plate = Plate(mesh, isotropic_rigidity(1.0, poisson), y == 0)
    couple = np.where(y == 8, 1.0, 0.0) * ((x == 1).astype(float) - (x == 0))
    w = plate.deflections(couple)
    turn = [w[(y == at) & (x == 1)][0] - w[(y == at) & (x == 0)][0] for at in (3.0, 5.0)]
    closed = 2 / (2 * (1 - poisson))
    assert_close((turn[1] - turn[0]) / closed, 1.0, 0.01)
    assert turn[0] > VISIBLE


def test_several_load_cases_are_independent():
    """Forces at clamped vertices have no effect."""
    mesh = scattered()
    held = mesh.points[:, 0] < 0.3
    plate = Plate(mesh, isotropic_rigidity(1.0, 0.3), held)
    f = np.random.default_rng(0).normal(size=(len(mesh.points), 2, 3))
    w = plate.deflections(f)
    for k in np.ndindex(2, 3):
        assert_close(w[:, *k], plate.deflections(f[:, *k]), 1e-12)
    assert np.abs(w[held]).max() == 0
    assert_close(plate.deflections(np.where(held[:, None, None], 0, f)), w, 1e-12)


# --- refusals ---------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("rigidity", "words"),
    [
        (np.eye(2), r"rigidity must have the shape \(3, 3\)"),
        (-np.eye(3), "positive definite"),
        (np.eye(3) + np.eye(3, k=1), "symmetric"),
        (isotropic_rigidity(np.nan, 0.3), "finite"),
    ],
)
def test_invalid_rigidities_are_refused(rigidity, words):
    """The message names the violated requirement."""
    mesh = scattered()
    with pytest.raises(ValueError, match=words):
        Plate(mesh, rigidity, mesh.points[:, 0] < 0.3)


def test_plates_that_can_move_rigidly_are_refused():
    """One clamped vertex allows a rotation; a second part may have no clamped vertex."""
    mesh = scattered()
    one = np.arange(len(mesh.points)) == 0
    with pytest.raises(np.linalg.LinAlgError, match="about cell 0 has no clamped face"):
        Plate(mesh, np.eye(3), one)
    far = SimplexMesh(
        np.vstack([mesh.points, mesh.points + 3]),
        np.vstack([mesh.cells, mesh.cells + len(mesh.points)]),
    )
    with pytest.raises(np.linalg.LinAlgError, match="has no clamped face"):
        Plate(far, np.eye(3), far.points[:, 0] < 0.3)


def test_invalid_plates_are_refused():
    """Examples are tetrahedra, points without a cell, and an invalid mask of clamped points."""
    mesh = scattered()
    with pytest.raises(ValueError, match="mesh must lie in the plane"):
        hessians(SimplexMesh.delaunay(halton(9, 3)))
    with pytest.raises(ValueError, match="clamped must tell of each of the 40 points"):
        Plate(mesh, np.eye(3), [0, 1])
    lone = SimplexMesh(np.vstack([mesh.points, [[9.0, 9.0]]]), mesh.cells)
    with pytest.raises(ValueError, match="points that belong to no cell, 40"):
        Plate(lone, np.eye(3), np.ones(41, bool))
