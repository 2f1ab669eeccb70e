"""Normal velocities advected to another mesh and projected to zero divergence."""

import numpy as np
import pytest

from fieldrecon.advection.incompressible import (
    carried_normal_velocities,
    divergence_free,
    flow_energy,
)
from fieldrecon.datasets.synthetic import halton
from fieldrecon.meshes.simplex_mesh import SimplexMesh
from fieldrecon.methods.least_squares import LeastSquares
from fieldrecon.velocity.cells import raviart_thomas
from fieldrecon.velocity.vertices import divergence, normal_velocities
from fieldreport import experiments
from fieldreport.experiments.advection import fluid_animation
from fieldreport.experiments.advection.fluid_animation import box_mesh
from laws import VISIBLE, assert_close


def scattered(d: int = 2) -> SimplexMesh:
    return SimplexMesh.delaunay(halton(60, d))


def normal_velocities_of_stream_function(mesh: SimplexMesh, psi: np.ndarray) -> np.ndarray:
    """Normal velocities whose flux through an edge is the difference of ψ at its ends."""
    start, end = mesh.faces.T
    along = mesh.points[end] - mesh.points[start]
    side = np.sign((along[:, ::-1] * [1, -1] * mesh.face_normals).sum(axis=1))
    return side * (psi[end] - psi[start]) / mesh.face_measures


def random_flow(mesh: SimplexMesh) -> np.ndarray:
    """Random normal velocities in the interior and zero on the boundary."""
    v = np.random.default_rng(0).normal(size=len(mesh.faces))
    return np.where(mesh.face_cells[:, 1] < 0, 0.0, v)


# --- energy -----------------------------------------------------------------------------------


@pytest.mark.parametrize("unit", [1.0, 0.1])
@pytest.mark.parametrize("d", [2, 3])
def test_energy_equals_the_integral_of_the_field(d, unit):
    """Raviart-Thomas fields reproduce u = a + b x, whose energy has a closed form."""
    mesh, a, b = scattered(d), np.arange(1.0, d + 1), 0.7
    mesh = SimplexMesh(unit * mesh.points, mesh.cells)
    v = normal_velocities(mesh, a + b * mesh.points)
    corners = mesh.points[mesh.cells]
    center = corners.mean(axis=1)
    spread = ((corners - center[:, None]) ** 2).sum(axis=(1, 2)) / ((d + 1) * (d + 2))
    exact = mesh.cell_measures @ (((a + b * center) ** 2).sum(axis=1) + b**2 * spread)
    assert_close(v @ (flow_energy(mesh) @ v) / exact, 1.0, 1e-10)
    at_centers = raviart_thomas(mesh, v, mesh.cell_centers)
    assert_close(at_centers, a + b * mesh.cell_centers, 1e-9)


def test_the_energy_matrix_is_symmetric_positive_definite():
    m = flow_energy(scattered()).toarray()
    assert_close(m, m.T, 1e-12)
    assert np.linalg.eigvalsh(m)[0] > 0


# --- the projection to zero divergence ------------------------------------------------------------


def the_projection_has_zero_divergence(project) -> None:
    """The divergence of each cell must vanish, and boundary velocities must not change."""
    for d in (2, 3):
        mesh = scattered(d)
        boundary = mesh.face_cells[:, 1] < 0
        steady = normal_velocities(mesh, np.tile(np.arange(1.0, d + 1), (len(mesh.points), 1)))
        w = project(mesh, steady + random_flow(mesh))
        assert_close(w[boundary], steady[boundary], 0.0)
        assert_close(divergence(mesh, w) * mesh.cell_measures, np.zeros(len(mesh.cells)), 1e-10)


def the_projection_is_orthogonal(project) -> None:
    """The change must be orthogonal, in the energy, to the flows of all stream functions."""
    mesh = scattered()
    v = random_flow(mesh)
    change = flow_energy(mesh) @ (project(mesh, v) - v)
    inner = np.flatnonzero(~mesh.boundary_vertices)
    for i in inner:
        z = normal_velocities_of_stream_function(
            mesh, (np.arange(len(mesh.points)) == i).astype(float)
        )
        assert_close(z @ change, 0.0, 1e-10)


LAWS = [the_projection_has_zero_divergence, the_projection_is_orthogonal]


@pytest.mark.parametrize("law", LAWS, ids=lambda law: law.__name__)
def test_the_projection_obeys_the_laws(law):
    """Together the two laws determine the projection."""
    law(divergence_free)


def identity(mesh, v):  # noqa: ARG001
    return v


def projection_without_energy_matrix(mesh, v):
    """The projection in the Euclidean norm, without the sizes of faces and cells."""
    n = len(mesh.faces)
    inside = mesh.face_cells[:, 1] >= 0
    d = np.zeros((len(mesh.cells), n))
    np.put_along_axis(
        d, mesh.cell_faces, mesh.cell_face_signs * mesh.face_measures[mesh.cell_faces], 1
    )
    w = v.copy()
    w[inside] -= np.linalg.pinv(d[:, inside]) @ (d @ v)
    return w


def projection_with_open_walls(mesh, v):
    """Zero divergence obtained by changing boundary velocities."""
    d = np.zeros((len(mesh.cells), len(mesh.faces)))
    np.put_along_axis(
        d, mesh.cell_faces, mesh.cell_face_signs * mesh.face_measures[mesh.cell_faces], 1
    )
    return v - np.linalg.pinv(d) @ (d @ v)


@pytest.mark.parametrize(
    ("law", "mutant"),
    [
        (the_projection_has_zero_divergence, identity),
        (the_projection_has_zero_divergence, projection_with_open_walls),
        (the_projection_is_orthogonal, projection_without_energy_matrix),
    ],
)
def test_each_law_rejects_a_mutant(law, mutant):
    with pytest.raises(AssertionError):
        law(mutant)


def test_the_projection_is_the_closest_flow_of_a_stream_function():
    """In the plane ψ, zero on the boundary, solves a linear system of its own."""
    mesh = scattered()
    v = random_flow(mesh)
    inner = np.flatnonzero(~mesh.boundary_vertices)
    basis = np.column_stack(
        [normal_velocities_of_stream_function(mesh, row) for row in np.eye(len(mesh.points))[inner]]
    )
    m = flow_energy(mesh)
    psi = np.linalg.solve(basis.T @ (m @ basis), basis.T @ (m @ v))
    assert_close(divergence_free(mesh, v), basis @ psi, 1e-9)


def test_the_projection_is_idempotent_and_reduces_the_energy():
    mesh = scattered()
    v = random_flow(mesh)
    once, m = divergence_free(mesh, v), flow_energy(mesh)
    assert_close(divergence_free(mesh, once), once, 1e-10)
    assert once @ (m @ once) < v @ (m @ v)
    assert np.abs(once - v).max() > VISIBLE


def test_each_connected_component_must_balance():
    """In every component the flux into the mesh must equal the flux out of it."""
    mesh = SimplexMesh([[0, 0], [1, 0], [0, 1], [5, 0], [6, 0], [5, 1]], [[0, 1, 2], [3, 4, 5]])
    v = normal_velocities(mesh, np.ones((6, 2)))
    assert_close(divergence_free(mesh, v), v, 0.0)
    with pytest.raises(ValueError, match="let in through the boundary as much as out; 1 more"):
        divergence_free(mesh, v + np.where(np.arange(6) == 0, 1.0, 0.0))
    with pytest.raises(ValueError, match="as much as out; 1 more"):  # that of the first part
        divergence_free(mesh, v + np.select([np.arange(6) == 0, np.arange(6) == 5], [1.0, 2.0]))
    with pytest.raises(ValueError, match="v must be one number for each face"):
        divergence_free(mesh, np.ones((6, 2)))


@pytest.mark.parametrize("d", [2, 3])
def test_the_outflow_of_cells_vanishes_to_rounding(d):
    """On the mean, it is less than two roundings of the sum of the flows of a cell."""
    mesh = SimplexMesh.delaunay(halton(400, d))
    w = divergence_free(mesh, random_flow(mesh))
    flows = (mesh.face_measures * w)[mesh.cell_faces] * mesh.cell_face_signs
    lost = np.abs(divergence(mesh, w) * mesh.cell_measures) / np.abs(flows).sum(axis=1)
    assert lost.mean() < 4e-16


@pytest.mark.parametrize("d", [2, 3])
@pytest.mark.parametrize(("length", "speed"), [(1e-40, 1e-30), (1e40, 1e30), (1.0, 1e30)])
def test_the_projection_does_not_depend_on_units(d, length, speed):
    """Neither does the balance: a surplus of a millionth is refused, and named in the unit."""
    mesh = scattered(d)
    small, v = SimplexMesh(mesh.points * length, mesh.cells), random_flow(mesh)
    assert_close(divergence_free(small, speed * v) / speed, divergence_free(mesh, v), 1e-12)
    wall = int(np.argmax(mesh.face_cells[:, 1] < 0))
    v[wall] += 1e-6
    more = divergence(small, speed * v) @ small.cell_measures
    with pytest.raises(ValueError, match="as much as out; ") as refused:
        divergence_free(small, speed * v)
    told = str(refused.value).partition("as much as out; ")[2].split()[0]
    assert float(told) == pytest.approx(more, rel=0.01, abs=0.0)


# --- advection ------------------------------------------------------------------------------------


def test_normal_velocities_are_taken_at_the_departure_points():
    """The departure points of a rotation are known.

    Velocities of the flow and of another field are advected.
    """
    x, mesh = halton(30, 2), scattered()
    middle = np.array([0.4, 0.6])
    flow = LeastSquares(x).field((x - middle)[:, ::-1] * [-1, 1])
    dt = 0.3
    back = np.array([[np.cos(dt), np.sin(dt)], [-np.sin(dt), np.cos(dt)]])
    feet = middle + (mesh.face_centers - middle) @ back.T
    u = (feet - middle)[:, ::-1] * [-1, 1]
    v = carried_normal_velocities(mesh, flow, 1.0, dt)
    assert_close(v, (u * mesh.face_normals).sum(axis=1), 1e-4)
    other = carried_normal_velocities(mesh, flow, 1.0, dt, carried=lambda y, t: y * t)
    assert_close(other, 0.7 * (feet * mesh.face_normals).sum(axis=1), 1e-4)


# --- the animation --------------------------------------------------------------------------------


def test_the_vortex_is_a_steady_flow_of_an_ideal_fluid():
    """u · ∇u is the gradient of -p with p = (cos 2πx + cos 2πy) / 4.

    The normal velocity on the walls is zero.
    """
    x, h = 0.05 + 0.9 * halton(50, 2), 1e-4
    slopes = np.stack(
        [
            (fluid_animation.vortex(x + h * e) - fluid_animation.vortex(x - h * e)) / (2 * h)
            for e in np.eye(2)
        ],
        axis=-1,
    )
    convection = np.einsum("nij,nj->ni", slopes, fluid_animation.vortex(x))
    assert_close(convection, np.pi / 2 * np.sin(2 * np.pi * x), 1e-6)
    side = np.column_stack([np.ones(5), np.linspace(0, 1, 5)])
    assert_close(fluid_animation.vortex(side)[:, 0], np.zeros(5), 1e-12)


def test_the_first_frame_has_zero_divergence_and_the_energy_of_the_vortex():
    """The energy is within 1 % of 1/4, and the normal velocities are those of the vortex."""
    frame = fluid_animation.first(fluid_animation.Params(spacing=0.08, finest=0.05))
    assert np.abs(divergence(frame.mesh, frame.v)).max() < 1e-11
    assert abs(frame.energy / fluid_animation.ENERGY - 1) < 0.01
    at = (fluid_animation.vortex(frame.mesh.face_centers) * frame.mesh.face_normals).sum(axis=1)
    assert np.abs(frame.v - at).max() < 0.02


def test_the_exact_outline_preserves_its_area():
    """The outline is advected by a flow of zero divergence."""
    for time in (0.0, 1.0, 2.0):
        x, y = fluid_animation.exact_rim(time, 2000).T
        area = (x[:-1] * y[1:] - x[1:] * y[:-1]).sum() / 2
        assert_close(area, np.pi * fluid_animation.RADIUS**2, 1e-5)


def test_meshes_of_frames_fill_the_box_and_differ():
    """The edges have about the requested length."""
    one, two = (box_mesh(lambda x: np.full(len(x), 0.1), seed) for seed in (1, 2))
    for mesh in (one, two):
        assert_close(mesh.cell_measures.sum(), 1.0, 1e-12)
        assert 0.5 < np.median(mesh.face_measures) / 0.1 < 1.3
    assert len(one.points) != len(two.points) or np.abs(one.points - two.points).max() > VISIBLE


@pytest.mark.slow
def test_reflection_and_pressure_reduce_the_errors():
    """Reflection loses less energy than plain projection. Without pressure the error is largest."""
    result = experiments.get("fluid_animation").run(fluid_animation.QUICK)
    facts = result.facts
    assert facts["plain_energy"] < facts["reflected_energy"] < 1
    assert facts["reflected_error"] < facts["plain_error"] < facts["loose_error"]
    assert facts["divergence"] < 1e-10
