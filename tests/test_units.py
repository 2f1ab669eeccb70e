"""No answer depends on the unit of length: each public function that solves a system, at 1e±30.

The methods obey this law in `laws.py`; here are the functions that are no methods. Each case takes
a unit, and returns arrays without one.
"""

from functools import partial

import numpy as np
import pytest

from fieldrecon.advection.characteristics import departure_points
from fieldrecon.advection.incompressible import divergence_free
from fieldrecon.advection.semi_lagrangian_steps import semi_lagrangian
from fieldrecon.barycentric.voronoi import voronoi_weights
from fieldrecon.coupling.flat_structures import couple
from fieldrecon.datasets.synthetic import halton
from fieldrecon.kernels.conditionally_positive_definite import polyharmonic
from fieldrecon.kernels.weights import inverse_square
from fieldrecon.meshes.simplex_mesh import SimplexMesh
from fieldrecon.methods.functionals import derivatives_at, values_at
from fieldrecon.methods.hermite import HermiteRBF
from fieldrecon.methods.natural_splines import NaturalCubicSpline
from fieldrecon.methods.rbf import RBF
from fieldrecon.methods.spline_bases import b_splines
from fieldrecon.solids.marching_cubes import extract_surface
from fieldrecon.solids.ray_casting import ray_intersections
from fieldrecon.solids.shapes import Ball, sample_surface
from fieldrecon.surfaces.implicit_surfaces import implicit_surface
from fieldrecon.surfaces.normal_orientation import orient_normals
from fieldrecon.surfaces.normals import estimate_normals
from fieldrecon.surfaces.off_surface import classified_points, off_surface_points
from fieldrecon.surfaces.polygon_soup import PolygonSoup
from fieldrecon.surfaces.variational_implicits import variational_implicit
from fieldrecon.triangles.audit import audit_mesh
from fieldrecon.triangles.repair import repair_mesh
from fieldrecon.velocity.cells import cell_velocities, raviart_thomas
from fieldrecon.velocity.cells_to_vertices import vertex_velocities_from_cells
from fieldrecon.velocity.gradients import (
    local_moving_least_squares,
    local_rbf,
    vertex_gradients,
)
from fieldrecon.velocity.vertices import divergence, point_velocities, vertex_velocities
from fieldreport.experiments.coupling.plate import Plate, isotropic_rigidity
from laws import assert_close

UNITS = (2.0**-100, 2.0**100)  # powers of two, which break no ties
SPHERE = sample_surface(Ball(1.0), 200, seed=1)


def mesh_in(unit, d):
    points = halton(60, d)
    return SimplexMesh(points * unit, SimplexMesh.delaunay(points).cells)


def flow_of(mesh):
    rng = np.random.default_rng(0)
    return np.where(mesh.face_cells[:, 1] < 0, 0.0, rng.normal(size=len(mesh.faces)))


def projection(d, unit):
    mesh = mesh_in(unit, d)
    w = divergence_free(mesh, flow_of(mesh))
    through = np.abs(mesh.face_measures * w)[mesh.cell_faces].sum(axis=1)
    balance = divergence(mesh, w) * mesh.cell_measures / through
    assert np.abs(balance).max() < 1e-12
    return (w,)


def plate(unit):
    mesh = mesh_in(unit, 2)
    clamped = halton(60, 2)[:, 0] < 0.3
    forces = np.cos(9 * halton(60, 2)[:, 0])
    return Plate(mesh, isotropic_rigidity(1.0, 0.3), clamped).deflections(forces) / unit**2


def velocities(d, unit):
    mesh = mesh_in(unit, d)
    v, data = flow_of(mesh), np.cos(np.arange(len(mesh.cells)))
    cells = cell_velocities(mesh, v)
    gradients = [
        vertex_gradients(mesh, data, method, sites=mesh.cell_centers) * unit
        for method in (None, local_rbf(), local_moving_least_squares(inverse_square(0.1 * unit)))
    ]
    return (
        cells.values,
        cells.defect,
        raviart_thomas(mesh, v),
        vertex_velocities(mesh, v).values,
        point_velocities(mesh, v, mesh.cell_centers[::9], inverse_square(0.1 * unit)).values,
        vertex_velocities_from_cells(mesh, cells.values),
        divergence(mesh, v) * unit,
        *gradients,
    )


def voronoi(d, unit):
    mesh = mesh_in(unit, d)
    inner = np.flatnonzero(~mesh.boundary_vertices)[:3]
    return (voronoi_weights(mesh, inner, mesh.points[inner] + 1e-3 * unit).toarray(),)


def transfer(unit):
    x, flat = halton(50, 3), np.pad(halton(50, 2), ((0, 0), (0, 1)))
    y, u = halton(20, 3, seed=3) / 4 + 0.3, np.cos(9 * x)
    results = []
    for nodes in (x, flat):
        coupling = couple(nodes * unit, y * unit)
        results += [coupling.displacements(u), coupling.loads(np.sin(9 * y))]
        results += [coupling.densities(np.sin(9 * y), np.full(20, unit**2), np.full(50, unit**2))]
    return tuple(results)


def hermite(unit):
    x = halton(20, 2) + 0.1
    method = HermiteRBF([values_at(x * unit), derivatives_at(x * unit, x)], polyharmonic(5))
    field = method.field(np.concatenate([np.cos(9 * x[:, 0]), np.sin(9 * x[:, 1]) / unit]))
    queries = halton(9, 2, seed=2) * unit
    return field(queries), field.gradient(queries) * unit


def splines(unit):
    x = np.sort(halton(20, 1)[:, 0])
    spline = NaturalCubicSpline(x * unit)
    field, queries = spline.field(np.cos(9 * x)), np.linspace(-0.2, 1.2, 9) * unit
    knots = np.arange(8.0)
    bases = b_splines(knots * unit, 3, np.linspace(0, 6.9, 9) * unit)
    return field(queries), field.gradient(queries) * unit, bases


def spin(x, t):  # noqa: ARG001
    """A rotation in units of time, about the point (0.5, 0.5) of the unit."""
    return 2 * x[:, ::-1] * [-1, 1]


def advected(unit):
    x = halton(60, 2) - 0.5
    u = 1.0 + np.exp(-20 * (x**2).sum(axis=1))
    method = RBF(x * unit, polyharmonic(3))
    feet = departure_points(x * unit, spin, 1.0, 0.1) / unit
    mass = np.full(60, unit**2 / 60)
    steps = semi_lagrangian(method, u, spin, [0, 0.1, 0.2], bounded=True, masses=mass)
    return feet, *[state.values for state in steps]


def cleaned(unit):
    """A cloud, its normals, and what is off it."""
    points, normals = SPHERE
    points = points * unit
    found = estimate_normals(points)
    off = off_surface_points(points, normals)
    toward = orient_normals(points, found.vectors)
    classified = classified_points(points, normals, halton(20, 3) * unit)
    return found.vectors, toward, off.points / unit, off.values / unit, classified.values / unit


def surface(method, unit):
    points, normals = SPHERE
    noise = 0.02 * np.random.default_rng(0).normal(size=points.shape)
    field = implicit_surface(
        (points + (method == "noisy") * noise) * unit,
        normals,
        method={"noisy": "rbf"}.get(method, method),
    )
    queries = 2 * halton(20, 3) * unit - unit
    return field(queries) / unit, field.gradient(queries), np.array([field.smoothing / unit])


def solids(unit):
    ball = Ball(unit)
    found = extract_surface(ball, 0.3 * unit)
    origins = np.column_stack([np.full(5, -2.0), halton(5, 2) - 0.5]) * unit
    seen = ray_intersections(ball, origins, [1.0, 0.0, 0.0], 4 * unit, 0.1 * unit)
    soup = PolygonSoup(found.points, found.triangles[::9], 0.1 * unit)
    queries = 1.5 * (halton(9, 3) - 0.5) * unit
    return found.points / unit, seen / unit, soup(queries) / unit


def shapes(unit):
    points, normals = SPHERE[0][:40], SPHERE[1][:40]
    field = variational_implicit(points * unit, normals)
    queries = halton(9, 3) * unit
    return (field(queries) / unit,)


def triangles(unit):
    mesh = extract_surface(Ball(1.0), 0.4)
    holes = np.delete(mesh.triangles, [3, 40], axis=0)
    repaired = repair_mesh(mesh.points * unit, holes)
    found = audit_mesh(mesh.points * unit, holes).found
    return repaired.points / unit, repaired.triangles, np.array(sorted(found.values()))


CASES = {
    "projection in 2-D": partial(projection, 2),
    "projection in 3-D": partial(projection, 3),
    "plate": lambda unit: (plate(unit),),
    "velocities in 2-D": partial(velocities, 2),
    "velocities in 3-D": partial(velocities, 3),
    "Voronoi cells in 2-D": partial(voronoi, 2),
    "Voronoi cells in 3-D": partial(voronoi, 3),
    "coupling": transfer,
    "Hermite data": hermite,
    "splines": splines,
    "advection": advected,
    "cloud": cleaned,
    "implicit surface": partial(surface, "rbf"),
    "implicit surface of noisy points": partial(surface, "noisy"),
    "implicit surface by patches": partial(surface, "partition"),
    "implicit surface by Hermite data": partial(surface, "hermite"),
    "solids": solids,
    "variational implicit": shapes,
    "triangles": triangles,
}


def answers_do_not_depend_on_the_unit(name):
    """As for lengths of order one."""
    here = CASES[name](1.0)
    for unit in UNITS:
        for a, b in zip(CASES[name](unit), here, strict=True):
            assert_close(a, b, 1e-6 * max(1.0, np.abs(b).max()))


def test_saddle_point_systems_are_scaled():
    """The projection and the plate, in the fast suite."""
    for name in ("projection in 2-D", "plate"):
        answers_do_not_depend_on_the_unit(name)


@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
def test_no_answer_depends_on_the_unit(name):
    """Whatever is solved."""
    answers_do_not_depend_on_the_unit(name)
