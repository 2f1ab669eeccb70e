"""Masked arrays: a mask that masks nothing is ignored, any other is refused, by every function."""

import inspect
from collections.abc import Callable, Iterator
from functools import partial
from importlib import import_module
from types import SimpleNamespace

import numpy as np
import pytest

import fieldrecon as fr
from fieldrecon.kernels import polyharmonic, wendland
from laws import refused

NAMESPACES = [
    *("kernels", "methods", "barycentric", "meshes", "velocity", "triangles", "solids"),
    *("surfaces", "coupling", "advection", "selection", "io", "datasets", "pipelines"),
]

N = 12
LINE = np.arange(N) + 0.0
PLANE = fr.datasets.halton(N, 2)
SPHERE = np.random.default_rng(1).normal(size=(N, 3))
SPHERE /= np.linalg.norm(SPHERE, axis=1, keepdims=True)
VALUES = np.cos(LINE)
VECTORS = np.column_stack([VALUES, LINE])
FORCES = np.column_stack([VECTORS, VALUES])
DEGREES = 40 * PLANE
CORNERS = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
TETRAHEDRON = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
BOX = np.array([[-1.2] * 3, [1.2] * 3])
MESH = fr.SimplexMesh.delaunay(np.stack(np.meshgrid(*[np.arange(4.0)] * 2), -1).reshape(-1, 2))
INNER = np.flatnonzero(~MESH.boundary_vertices)
ON_VERTICES, ON_FACES, ON_CELLS = (
    np.cos(np.arange(len(a)) + 1.0) for a in (MESH.points, MESH.faces, MESH.cells)
)
LOCAL = fr.MovingLeastSquares(PLANE, wendland(3, 2, 3.0))
SMOOTH = fr.RBF(PLANE, polyharmonic(3))
FITTED = fr.LeastSquares(PLANE)
SPLINE = fr.NaturalCubicSpline(LINE)
UNITS = fr.methods.to_unit(DEGREES)
GLOBE = fr.OnGlobe(DEGREES, partial(fr.RBF, kernel=polyharmonic(1)))
BALL, TORUS = fr.solids.Ball(1.0), fr.solids.Torus(1.0, 0.3)
SOUP = fr.surfaces.PolygonSoup(CORNERS, TETRAHEDRON)
COUPLING = fr.Coupling(fr.RBF(SPHERE, polyharmonic(3)), SPHERE)
IMPLICIT = fr.implicit_surface(SPHERE, SPHERE, smoothing=0.0)
VIEW = fr.solids.View.of_box(BOX, [1.0, 1, 1], 4)


def times_two(x, t):  # noqa: ARG001
    return 2 * x


def states(**arrays):
    """The last values of a short advection."""
    *_, last = fr.semi_lagrangian(FITTED, velocity=times_two, **arrays)
    return last.values


Call = tuple[Callable[..., object], dict[str, np.ndarray]]
CALLS: dict[str, Call] = {
    "Radial.__call__": (wendland(3, 1), {"r": VALUES}),
    "Radial.slope": (wendland(3, 1).slope, {"r": VALUES}),
    "singular_exchange": (
        partial(fr.kernels.singular_exchange, lambda x: np.column_stack([np.ones(3), x])),
        {"points": CORNERS[:3, :2]},
    ),
    "Reconstruction.field": (FITTED.field, {"values": VALUES}),
    "Reconstruction.weights": (FITTED.weights, {"x": PLANE}),
    "Reconstruction.gradient_weights": (FITTED.gradient_weights, {"x": PLANE}),
    "Reconstruction.adjoint": (FITTED.adjoint, {"x": PLANE, "f": VALUES}),
    "Field.__call__": (FITTED.field(VALUES), {"x": PLANE}),
    "Field.gradient": (FITTED.field(VALUES).gradient, {"x": PLANE}),
    "Field.hessian": (FITTED.field(VALUES).hessian, {"x": PLANE}),
    "Field.laplacian": (FITTED.field(VALUES).laplacian, {"x": PLANE}),
    "RBF": (
        partial(fr.RBF, kernel=polyharmonic(3)),
        {"points": PLANE, "smoothing": np.ones(N), "metric": np.eye(2)},
    ),
    "RBF.coefficients": (SMOOTH.coefficients, {"values": VALUES}),
    "HermiteRBF.field": (
        fr.HermiteRBF(fr.methods.values_at(PLANE), polyharmonic(3)).field,
        {"values": VALUES},
    ),
    "LeastSquares": (fr.LeastSquares, {"points": PLANE}),
    "LeastSquares.coefficients": (FITTED.coefficients, {"values": VALUES}),
    "LeastSquares.objective": (FITTED.objective, {"values": VALUES}),
    "LeastSquares.residuals": (FITTED.residuals, {"values": VALUES}),
    "Mean": (partial(fr.methods.Mean, methods=[fr.LeastSquares]), {"points": PLANE}),
    "Mean.field": (fr.methods.Mean(PLANE, [fr.LeastSquares]).field, {"values": VALUES}),
    "MovingLeastSquares": (
        partial(fr.MovingLeastSquares, weight=wendland(3, 2)),
        {"points": PLANE, "metric": np.eye(2)},
    ),
    "MovingLeastSquares.matrix": (LOCAL.matrix, {"x": PLANE}),
    "MovingLeastSquares.objective": (LOCAL.objective, {"values": VALUES, "x": PLANE}),
    "NaturalCubicSpline": (fr.NaturalCubicSpline, {"points": LINE}),
    "NaturalCubicSpline.field": (SPLINE.field, {"values": VALUES}),
    "NaturalCubicSpline.energy": (SPLINE.energy, {"values": VALUES}),
    "NaturalCubicSpline.truncated_powers": (SPLINE.truncated_powers, {"values": VALUES}),
    "NaturalCubicSpline.coefficients": (SPLINE.coefficients, {"values": VALUES}),
    "NaturalCubicSpline.weights": (SPLINE.weights, {"x": LINE}),
    "OnGlobe": (
        partial(fr.OnGlobe, method=partial(fr.RBF, kernel=polyharmonic(1))),
        {"points": DEGREES},
    ),
    "OnGlobe.field": (GLOBE.field, {"values": VALUES}),
    "OnTangentPlane": (
        partial(fr.methods.OnTangentPlane, method=fr.LeastSquares),
        {"points": UNITS, "pole": UNITS[0]},
    ),
    "OnTangentPlane.field": (
        fr.methods.OnTangentPlane(UNITS, fr.LeastSquares).field,
        {"values": VALUES},
    ),
    "PartitionOfUnityRBF": (
        fr.PartitionOfUnityRBF,
        {"points": PLANE, "smoothing": np.ones(N), "metric": np.eye(2)},
    ),
    "PartitionOfUnityRBF.field": (fr.PartitionOfUnityRBF(PLANE).field, {"values": VALUES}),
    "b_splines": (partial(fr.methods.b_splines, degree=2), {"knots": LINE, "x": LINE}),
    "cardinal_b_spline": (partial(fr.methods.cardinal_b_spline, 2), {"x": LINE}),
    "derivatives_at": (fr.methods.derivatives_at, {"points": PLANE, "directions": VECTORS}),
    "laplacians_at": (fr.methods.laplacians_at, {"points": PLANE}),
    "values_at": (fr.methods.values_at, {"points": PLANE}),
    "normal_equations": (fr.methods.normal_equations, {"points": PLANE, "values": VALUES}),
    "principal": (fr.methods.principal, {"lonlat": DEGREES}),
    "to_unit": (fr.methods.to_unit, {"lonlat": DEGREES}),
    "BarycentricCoordinates": (fr.BarycentricCoordinates, {"vertices": CORNERS}),
    "voronoi_weights": (
        partial(fr.voronoi_weights, MESH),
        {"vertices": INNER, "x": MESH.points[INNER]},
    ),
    "SimplexMesh": (fr.SimplexMesh, {"points": MESH.points, "cells": MESH.cells}),
    "SimplexMesh.delaunay": (fr.SimplexMesh.delaunay, {"points": PLANE}),
    "SimplexMesh.cells_around": (MESH.cells_around, {"vertices": INNER}),
    "SimplexMesh.faces_around": (MESH.faces_around, {"vertices": INNER}),
    "cell_velocities": (partial(fr.cell_velocities, MESH), {"v": ON_FACES}),
    "circumcenter_weights": (partial(fr.velocity.circumcenter_weights, MESH), {"vertices": INNER}),
    "divergence": (partial(fr.divergence, MESH), {"v": ON_FACES}),
    "normal_velocities": (partial(fr.normal_velocities, MESH), {"u": MESH.points}),
    "raviart_thomas": (
        partial(fr.velocity.raviart_thomas, MESH),
        {"v": ON_FACES, "x": MESH.circumcenters},
    ),
    "point_velocities": (
        partial(fr.velocity.point_velocities, MESH),
        {"v": ON_FACES, "x": MESH.circumcenters},
    ),
    "point_velocity_weights": (
        partial(fr.velocity.point_velocity_weights, MESH),
        {"x": MESH.circumcenters},
    ),
    "velocity_weights": (partial(fr.velocity_weights, MESH), {"vertices": INNER}),
    "vertex_gradients": (
        partial(fr.vertex_gradients, MESH),
        {"values": ON_CELLS, "sites": MESH.circumcenters, "vertices": INNER},
    ),
    "vertex_velocities": (
        partial(fr.vertex_velocities, MESH),
        {"v": ON_FACES, "vertices": INNER},
    ),
    "vertex_velocities_from_cells": (
        partial(fr.vertex_velocities_from_cells, MESH),
        {"u": MESH.circumcenters, "vertices": INNER},
    ),
    "audit": (
        lambda points, triangles: fr.pipelines.audit((points, triangles)),
        {"points": CORNERS, "triangles": TETRAHEDRON},
    ),
    "audit_mesh": (fr.audit_mesh, {"points": CORNERS, "triangles": TETRAHEDRON}),
    "repair_mesh": (fr.repair_mesh, {"points": CORNERS, "triangles": TETRAHEDRON}),
    "distances_to_triangles": (
        fr.triangles.distances_to_triangles,
        {"x": SPHERE, "points": CORNERS, "triangles": TETRAHEDRON},
    ),
    "Ball": (partial(fr.solids.Ball, 1.0), {"center": BOX[0]}),
    "Box": (fr.solids.Box, {"size": BOX[1], "center": BOX[0]}),
    "Cylinder": (partial(fr.solids.Cylinder, 1.0, 2.0), {"center": BOX[0]}),
    "Torus": (partial(fr.solids.Torus, 1.0, 0.3), {"center": BOX[0]}),
    "Solid.__call__": (TORUS, {"x": SPHERE}),
    "Solid.gradient": (TORUS.gradient, {"x": SPHERE}),
    "Solid.normals": (TORUS.normals, {"x": SPHERE}),
    "View.of_box": (
        partial(fr.solids.View.of_box, pixels=4),
        {"box": BOX, "toward": SPHERE[0], "up": BOX[1]},
    ),
    "as_solid": (partial(fr.solids.as_solid, IMPLICIT), {"box": BOX, "near": SPHERE}),
    "extract_surface": (
        partial(fr.extract_surface, IMPLICIT, spacing=0.6),
        {"near": SPHERE, "box": BOX},
    ),
    "ray_intersections": (
        partial(fr.solids.ray_intersections, BALL, step=0.1),
        {
            "origins": 3 * SPHERE,
            "direction": BOX[0],
            "lengths": np.full(N, 6.0),
            "near": SPHERE,
        },
    ),
    "ray_traced": (
        partial(fr.solids.ray_traced, BALL, VIEW, 0.3),
        {"near": SPHERE, "color": np.array([0.1, 0.2, 0.3])},
    ),
    "roughened": (
        partial(fr.solids.roughened, noise=0.1, seed=1),
        {"points": SPHERE, "normals": SPHERE},
    ),
    "scanned": (
        partial(fr.solids.scanned, BALL),
        {"points": SPHERE, "normals": SPHERE, "eyes": 9 * SPHERE},
    ),
    "transform": (
        partial(fr.solids.transform, BALL),
        {"rotation": np.eye(3), "shift": SPHERE[0]},
    ),
    "ImplicitSurface.distances": (IMPLICIT.distances, {"x": SPHERE}),
    "PolygonSoup": (
        fr.surfaces.PolygonSoup,
        {"points": CORNERS, "polygons": TETRAHEDRON, "offsets": np.zeros(4)},
    ),
    "PolygonSoup.__call__": (SOUP, {"x": SPHERE}),
    "PolygonSoup.gradient": (SOUP.gradient, {"x": SPHERE}),
    "PolygonSoup.weights": (SOUP.weights, {"x": SPHERE}),
    "classified_points": (
        fr.surfaces.classified_points,
        {"points": SPHERE, "normals": SPHERE, "x": 2 * SPHERE},
    ),
    "estimate_normals": (fr.estimate_normals, {"points": SPHERE}),
    "implicit_surface": (
        partial(fr.implicit_surface, smoothing=0.0),
        {"points": SPHERE, "normals": SPHERE},
    ),
    "off_surface_points": (fr.off_surface_points, {"points": SPHERE, "normals": SPHERE}),
    "orient_normals": (
        fr.orient_normals,
        {"points": SPHERE, "normals": SPHERE, "neighbors": np.add.outer(range(N), range(6)) % N},
    ),
    "variational_implicit": (
        fr.surfaces.variational_implicit,
        {"points": SPHERE, "normals": SPHERE},
    ),
    "Coupling": (partial(fr.Coupling, FITTED), {"x": PLANE}),
    "FlatCoupling": (
        fr.coupling.FlatCoupling,
        {"structure": np.pad(PLANE, ((0, 0), (0, 1))), "x": SPHERE},
    ),
    "couple": (
        partial(fr.coupling.couple, make=fr.LeastSquares),
        {"structure": SPHERE, "x": SPHERE},
    ),
    "Transfer.displacements": (COUPLING.displacements, {"u": FORCES}),
    "Transfer.loads": (COUPLING.loads, {"f": FORCES}),
    "Transfer.densities": (
        COUPLING.densities,
        {"f": FORCES, "surface_mass": np.ones(N), "structure_mass": np.ones(N)},
    ),
    "Transfer.defects": (COUPLING.defects, {"f": FORCES, "about": FORCES[0]}),
    "Transfer.shares": (
        COUPLING.shares,
        {"f": FORCES, "surface": np.arange(N) % 2, "structure": np.arange(N) % 2},
    ),
    "fixed_point": (partial(fr.coupling.fixed_point, np.cos), {"x0": VALUES}),
    "net_force_and_moment": (
        fr.coupling.net_force_and_moment,
        {"points": SPHERE, "loads": FORCES, "about": FORCES[0]},
    ),
    "rigid_motions": (fr.coupling.rigid_motions, {"points": SPHERE, "about": FORCES[0]}),
    "adapted_points": (
        partial(fr.advection.adapted_points, refine=0.5, coarsen=0.1, spacing=0.1),
        {"points": PLANE, "indicator": np.abs(VALUES)},
    ),
    "departure_points": (
        partial(fr.departure_points, velocity=times_two, t=0.0, dt=0.1),
        {"x": PLANE},
    ),
    "divergence_free": (
        partial(fr.advection.divergence_free, MESH),
        {"v": fr.normal_velocities(MESH, MESH.points[:, ::-1])},
    ),
    "semi_lagrangian": (states, {"values": VALUES, "times": np.arange(3) / 10}),
    "leave_one_out": (partial(fr.leave_one_out, FITTED), {"values": VALUES}),
    "extrapolated": (fr.selection.extrapolated, {"points": PLANE, "x": PLANE}),
    "CrossValidator.of": (
        fr.selection.CrossValidator.of,
        {"points": PLANE, "values": VALUES, "x": PLANE, "variances": np.ones(N)},
    ),
    "distance_matched_folds": (
        fr.selection.distance_matched_folds,
        {"points": PLANE, "x": PLANE},
    ),
    "held_out_distances": (
        partial(fr.selection.held_out_distances, folds=[fr.selection.Fold([0], [1, 2])]),
        {"points": PLANE},
    ),
    "nearest_neighbor_distances": (
        fr.selection.nearest_neighbor_distances,
        {"points": PLANE, "x": PLANE},
    ),
    "wasserstein_distance": (fr.selection.wasserstein_distance, {"a": VALUES, "b": VALUES}),
    "ErrorBand": (
        partial(fr.selection.ErrorBand, folds=[fr.selection.Fold([0], [1, 2])]),
        {"points": PLANE, "residuals": VALUES[:1], "own_residuals": VALUES},
    ),
    "AnalyticField.__call__": (fr.datasets.franke, {"x": PLANE}),
    "block_means": (
        partial(fr.pipelines.block_means, count=3),
        {"points": PLANE, "values": VALUES},
    ),
}
"""Every public function that takes arrays, with arguments that it accepts."""


KINDS = ("ArrayLike", "int | ArrayLike", "ArrayLike | Callable[[np.ndarray], np.ndarray]")
"""Annotations of parameters that take arrays."""


def public_parameters() -> Iterator[tuple[str, str]]:
    """Names of public functions and methods, with those of their parameters that are array_like."""
    spaces = [getattr(fr, name) for name in NAMESPACES] + [import_module("fieldrecon._public")]
    named = {name: getattr(space, name) for space in spaces for name in space.__all__}
    for name, value in named.items():
        functions = {name: value}
        if inspect.isclass(value):
            functions = {name: value.__init__} | {
                f"{name}.{key}": getattr(value, key)
                for key, member in vars(value).items()
                if key == "__call__" or (key[0] != "_" and callable(getattr(value, key)))
            }
        for key, function in functions.items():
            if inspect.isroutine(function):
                for parameter in inspect.signature(function).parameters.values():
                    if str(parameter.annotation).removesuffix(" | None") in KINDS:
                        yield key, parameter.name


def test_no_public_function_is_missing():
    """A new function that takes arrays is in the table; writers of files have their own test."""
    listed = {(name, argument) for name, (_, arrays) in CALLS.items() for argument in arrays}
    writers = {("write_triangles", "points"), ("write_triangles", "triangles")}
    assert sorted({*public_parameters()} - listed - writers) == []


def test_a_masked_entry_is_refused():
    """With the name of the argument and the remedy, before anything is computed."""
    for name, (call, arrays) in CALLS.items():
        for argument, array in arrays.items():
            mask = np.zeros(array.shape, dtype=bool)
            mask[(0,) * array.ndim] = True
            with refused(rf"^{argument} must have no masked entries, and 1 of {array.size} are"):
                call(**arrays | {argument: np.ma.array(array, mask=mask)})
                raise AssertionError(f"{name} takes a masked {argument}")


@pytest.mark.slow
def test_a_mask_that_masks_nothing_is_ignored():
    """The results are the same bits, and no masked arrays."""
    for call, arrays in CALLS.values():
        expected = call(**arrays)
        for mask in (np.ma.nomask, False):
            result = call(**{name: np.ma.array(a, mask=mask) for name, a in arrays.items()})
            assert type(result) is type(expected)
            if isinstance(result, np.ndarray):
                np.testing.assert_array_equal(result, expected)


def test_the_remedy_for_points_keeps_whole_rows():
    """What the message says can be pasted: the mask of the entries would select no rows."""
    points = np.ma.masked_greater([[0.0, 0.0], [1.0, 9.0], [2.0, 3.0]], 5.0)
    with refused(r"1 of 6 are .* numpy\.ma\.compress_rows\(points\), and the same rows"):
        fr.LeastSquares(points)
    assert np.ma.compress_rows(points).tolist() == [[0.0, 0.0], [2.0, 3.0]]


def test_masked_arrays_in_a_list_are_refused():
    """Columns of a table are often given so."""
    column = np.ma.array(LINE, mask=LINE == 3)
    with refused(rf"values must have no masked entries, and 2 of {2 * N} are .* values\[~mask\]"):
        SMOOTH.field([column, column])


def test_meshes_and_functions_with_masked_entries_are_refused():
    """By the name of the attribute; of a function, by that of its values."""
    masked = np.ma.masked_equal(TETRAHEDRON, 3)
    for names in (("points", "triangles"), ("vertices", "faces")):
        mesh = SimpleNamespace(**dict(zip(names, (CORNERS, masked), strict=True)))
        with refused(rf"^{names[1]} must have no masked entries, and 3 of 12 are"):
            fr.pipelines.audit(mesh)
    with refused(r"^solid\(x\) must have no masked entries, and 1 of 1 are"):
        fr.solids.ray_intersections(
            lambda x: np.ma.masked_less(BALL(x), -1.0), [[0, 0, 3.0]], [0, 0, -1], 6.0, 0.1
        )


def test_writers_refuse_masked_entries(tmp_path):
    """No file is written."""
    masked = np.ma.array(CORNERS, mask=CORNERS > 0)
    with refused("points must have no masked entries"):
        fr.io.write_triangles(tmp_path / "a.stl", masked, TETRAHEDRON)
    with refused("temperature.* must have no masked entries"):
        values = np.ma.masked_greater(ON_VERTICES, 0.9)
        fr.io.write_mesh(tmp_path / "a.vtk", MESH, {"temperature": values})
    assert not [*tmp_path.iterdir()]
