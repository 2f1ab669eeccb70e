"""Gradients at vertices: affine fields, methods of the library, orders of convergence."""

import numpy as np
import pytest

from fieldrecon.kernels.conditionally_positive_definite import polyharmonic, thin_plate_spline
from fieldrecon.kernels.positive_definite import gaussian, wendland
from fieldrecon.kernels.weights import inverse_square
from fieldrecon.meshes.simplex_mesh import SimplexMesh
from fieldrecon.methods.least_squares import LeastSquares
from fieldrecon.methods.moving_least_squares import MovingLeastSquares
from fieldrecon.methods.rbf import RBF
from fieldrecon.velocity.gradients import (
    local_least_squares,
    local_moving_least_squares,
    local_rbf,
    vertex_gradients,
)
from laws import assert_close
from meshes import MESHES, jittered_mesh, order, rms

EXACT = 1e-9
METHODS = {
    "LS": lambda _: local_least_squares(),
    "MLS": lambda h: local_moving_least_squares(inverse_square(0.5 * h)),
    "MLS singular": lambda _: local_moving_least_squares(inverse_square(0.0)),
    "MLS compact": lambda h: local_moving_least_squares(wendland(3, 1, 8 * h)),
    "RBF": lambda _: local_rbf(),
    "RBF cubic": lambda _: local_rbf(polyharmonic(3)),
}


@pytest.fixture(params=MESHES, scope="module")
def mesh(request) -> SimplexMesh:
    return MESHES[request.param]


def spacing(mesh: SimplexMesh) -> float:
    """Mean spacing of the vertices of a mesh of the unit cube."""
    return len(mesh.points) ** (-1 / mesh.points.shape[1])


def gradients_of_affine_fields_are_exact(gradients, mesh: SimplexMesh, unit: float) -> None:
    """The gradient must be exact at every vertex, including the boundary."""
    slope = np.arange(1.0, mesh.points.shape[1] + 1)
    middle = mesh.points.mean(axis=0)
    found = gradients(mesh, 4 + (mesh.circumcenters - middle) / unit @ slope) * unit
    assert_close(found, np.tile(slope, (len(mesh.points), 1)), EXACT)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("unit", [1.0, 1e-100, 1e100])
def test_gradients_of_affine_fields_are_exact(mesh, method, unit):
    """This holds for every method and in every unit of length."""
    scaled = SimplexMesh(mesh.points * unit, mesh.cells)
    by = METHODS[method](spacing(mesh) * unit)
    gradients_of_affine_fields_are_exact(lambda m, p: vertex_gradients(m, p, by), scaled, unit)


@pytest.mark.parametrize("method", METHODS)
def test_gradients_of_affine_fields_are_exact_far_from_the_origin(mesh, method):
    """At an offset of 1000 the coordinates lose three digits."""
    translated = SimplexMesh(mesh.points + 1000.0, mesh.cells)
    by = METHODS[method](spacing(mesh))
    gradients_of_affine_fields_are_exact(lambda m, p: vertex_gradients(m, p, by), translated, 1.0)


def green_gauss(mesh: SimplexMesh, p: np.ndarray) -> np.ndarray:
    """Mutant: the Green-Gauss gradient, which averages over the dual cell."""
    d = mesh.points.shape[1]
    total = np.zeros((len(mesh.points), d))
    size = np.zeros(len(mesh.points))
    inward = -mesh.cell_face_signs[..., None] * mesh.face_normals[mesh.cell_faces]
    area = inward * mesh.face_measures[mesh.cell_faces][..., None]
    np.add.at(total, mesh.cells, area * p[:, None, None] / -d)
    np.add.at(size, mesh.cells, mesh.cell_measures[:, None] / d)
    return total / size[:, None]


def test_green_gauss_gradients_are_not_exact():
    with pytest.raises(AssertionError, match="deviates"):
        gradients_of_affine_fields_are_exact(green_gauss, MESHES["random 2-D"], 1.0)


# --- comparison with the methods of the library -------------------------------------------------


def wavy(x: np.ndarray) -> np.ndarray:
    return np.sin(3 * x[..., 0] + 0.3) * np.cos(2 * x[..., 1]) + x[..., -1] ** 2


def wavy_gradient(x: np.ndarray) -> np.ndarray:
    g = np.zeros_like(x)
    g[..., 0] = 3 * np.cos(3 * x[..., 0] + 0.3) * np.cos(2 * x[..., 1])
    g[..., 1] = -2 * np.sin(3 * x[..., 0] + 0.3) * np.sin(2 * x[..., 1])
    g[..., -1] += 2 * x[..., -1]
    return g


def one_ring_vertices(mesh: SimplexMesh) -> np.ndarray:
    """Interior vertices with a well-conditioned one-ring and no distant circumcentre."""
    chosen = []
    for i in np.flatnonzero(~mesh.boundary_vertices):
        offset = mesh.circumcenters[mesh.vertex_cells(i)] - mesh.points[i]
        r = np.linalg.norm(offset, axis=1)
        b = np.column_stack([np.ones(len(r)), offset / np.median(r)])
        if r.max() < 5 * np.median(r) and np.linalg.cond(b) < 5:
            chosen.append(i)
    return np.array(chosen)


AGAINST = {
    "LS": (local_least_squares(), LeastSquares),
    "MLS": (
        local_moving_least_squares(inverse_square(0.05)),
        lambda p: MovingLeastSquares(p, inverse_square(0.05)),
    ),
    "MLS singular": (
        local_moving_least_squares(inverse_square(0.0)),
        lambda p: MovingLeastSquares(p, inverse_square(0.0)),
    ),
    "MLS gaussian": (
        local_moving_least_squares(gaussian(0.2)),
        lambda p: MovingLeastSquares(p, gaussian(0.2)),
    ),
    "RBF": (local_rbf(smoothing=0.0), lambda p: RBF(p, thin_plate_spline())),
    "RBF cubic": (local_rbf(polyharmonic(3), smoothing=0.0), lambda p: RBF(p, polyharmonic(3))),
}


@pytest.mark.slow
@pytest.mark.parametrize("method", AGAINST)
@pytest.mark.parametrize("name", ["random 2-D", "jittered 3-D"])
def test_batched_gradients_equal_those_of_the_methods(name, method):
    """The reference is `Field.gradient` of the method fitted to the surrounding circumcentres."""
    mesh = MESHES[name]
    local, made = AGAINST[method]
    values = wavy(mesh.circumcenters)
    vertices = one_ring_vertices(mesh)
    assert len(vertices) > 20
    found = vertex_gradients(mesh, values, local, vertices=vertices)
    for i, gradient in zip(vertices, found, strict=True):
        cells = mesh.vertex_cells(i)
        wanted = made(mesh.circumcenters[cells]).field(values[cells]).gradient(mesh.points[i])
        size = np.abs(wanted).max()
        assert_close(gradient / size, wanted / size, 1e-5 if "RBF" in method else 1e-9)


def test_the_gradient_includes_the_derivative_of_the_weights():
    """The slope of the local fit alone differs from the gradient of moving least squares."""
    mesh = MESHES["random 2-D"]
    values, vertices = wavy(mesh.circumcenters), one_ring_vertices(mesh)
    local, _ = AGAINST["MLS"]
    found = vertex_gradients(mesh, values, local, vertices=vertices)
    difference = 0.0
    for i, gradient in zip(vertices, found, strict=True):
        p = mesh.circumcenters[mesh.vertex_cells(i)] - mesh.points[i]
        w = inverse_square(0.05)(np.linalg.norm(p, axis=1))
        b = np.column_stack([np.ones(len(p)), p])
        c = np.linalg.lstsq(w[:, None] * b, w * values[mesh.vertex_cells(i)], rcond=None)[0]
        difference = max(difference, float(np.abs(c[1:] - gradient).max()))
    assert difference > 0.01


@pytest.mark.parametrize("parity", ["even", "odd"])
@pytest.mark.parametrize("method", ["LS", "MLS", "RBF"])
def test_a_site_more_than_ten_times_as_far_as_the_median_does_not_count(method, parity):
    """Of an even number it is the lower one. A square of the distance may have no number."""
    mesh = MESHES["random 2-D"]
    count = np.bincount(mesh.cells.ravel())
    others = mesh.boundary_vertices | (count % 2 != ["even", "odd"].index(parity))
    i = np.argmax(np.where(others, 0, count))
    one, *others = np.flatnonzero((mesh.cells == i).any(axis=1))
    away = np.linalg.norm(mesh.circumcenters[others] - mesh.points[i], axis=1)
    median = np.sort(away)[(count[i] - 1) // 2]
    for distance, counts in ((9.999 * median, True), (10.001 * median, False), (6e153, False)):
        sites = mesh.circumcenters.copy()
        sites[one] = mesh.points[i] + [distance, 0.0]
        values = np.where(np.arange(len(sites)) == one, 1e9, sites @ [3.0, 4.0])
        found = vertex_gradients(mesh, values, METHODS[method](spacing(mesh)), sites, [i])
        assert (np.abs(found - [3.0, 4.0]).max() > EXACT) == counts


def test_coincident_circumcentres_are_replaced_by_their_mean_value():
    """In a grid of squares two triangles share each circumcentre."""
    side = np.arange(5.0)
    points = np.stack(np.meshgrid(side, side, indexing="ij"), axis=-1).reshape(-1, 2)
    mesh = SimplexMesh.delaunay(points)
    noise = np.random.default_rng(5).standard_normal(len(mesh.cells))
    same = mesh.circumcenters[:, 0] * 10 + mesh.circumcenters[:, 1]
    mean = np.array([noise[np.isclose(same, s)].mean() for s in same])
    inside = np.flatnonzero(~mesh.boundary_vertices)
    full = [i for i in inside if len(mesh.vertex_cells(i)) == 8]
    found = vertex_gradients(mesh, noise, local_rbf(), vertices=full)
    assert_close(found, vertex_gradients(mesh, mean, local_rbf(), vertices=full), 1e-8)
    gradients_of_affine_fields_are_exact(
        lambda m, p: vertex_gradients(m, p, local_rbf()), mesh, 1.0
    )


# --- order of convergence -----------------------------------------------------------------------


def interior_error(mesh: SimplexMesh, by) -> float:
    """Root mean square error at vertices with a distance of at least 0.1 from the boundary."""
    inside = ((mesh.points > 0.1) & (mesh.points < 0.9)).all(axis=1)
    vertices = np.flatnonzero(inside)
    found = vertex_gradients(mesh, wavy(mesh.circumcenters), by, vertices=vertices)
    return rms(found - wavy_gradient(mesh.points[vertices]))


@pytest.mark.slow
@pytest.mark.parametrize("method", ["LS", "MLS", "RBF"])
@pytest.mark.parametrize(("d", "sides"), [(2, (16, 64)), (3, (6, 12))])
def test_gradients_on_irregular_meshes_are_of_first_order(method, d, sides):
    """An affine fit ignores second derivatives, which change the gradient by O(h)."""
    errors = [interior_error(jittered_mesh(n, d, 6), METHODS[method](1 / n)) for n in sides]
    assert 0.7 < order(*errors, sides[1] / sides[0]) < 1.5


@pytest.mark.parametrize("method", ["LS", "MLS", "RBF"])
def test_gradients_on_symmetric_meshes_are_of_second_order(method):
    """If the circumcentres are symmetric about the vertex, the even terms cancel."""
    errors = []
    for n in (16, 64):
        errors.append(interior_error(equilateral_triangles(n), METHODS[method](1 / n)))
    assert 1.8 < order(*errors, 4) < 2.3


def equilateral_triangles(n: int) -> SimplexMesh:
    """Equilateral triangles of side 1/n over the unit square."""
    i, j = np.meshgrid(np.arange(-n, 2 * n), np.arange(int(1.3 * n)), indexing="ij")
    x, y = (i + j / 2) / n, j * np.sqrt(0.75) / n
    inside = (x > -0.5 / n) & (x < 1 + 0.5 / n) & (y < 1 + 1 / n)
    return SimplexMesh.delaunay(np.column_stack([x[inside], y[inside]]))


# --- shapes of the data, other sites, refusals --------------------------------------------------


def test_values_at_centroids_need_the_argument_sites(mesh):
    """Cell averages belong to centroids; with circumcentres the gradient is wrong."""
    slope = np.arange(1.0, mesh.points.shape[1] + 1)
    wanted = np.tile(slope, (len(mesh.points), 1))
    at_centroids = mesh.cell_centers @ slope
    assert_close(vertex_gradients(mesh, at_centroids, sites=mesh.cell_centers), wanted, EXACT)
    assert np.abs(vertex_gradients(mesh, at_centroids) - wanted).max() > 0.01


def test_data_may_have_several_axes_and_be_complex():
    """The axes of the data are kept; the derivatives come last."""
    mesh = MESHES["random 3-D"]
    values = np.random.default_rng(7).standard_normal((len(mesh.cells), 2, 4)) * (1 + 2j)
    found = vertex_gradients(mesh, values, local_rbf())
    assert found.shape == (len(mesh.points), 2, 4, 3)
    assert_close(found[:, 1, 2], vertex_gradients(mesh, values[:, 1, 2], local_rbf()), 1e-8)
    some = [4, 4, 100]
    few = vertex_gradients(mesh, values, local_rbf(), vertices=some)
    assert_close(few, found[some], 1e-8)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda m: vertex_gradients(m, np.zeros(7)), "values must have one entry for each cell"),
        (
            lambda m: vertex_gradients(m, np.zeros(len(m.cells)), "LS"),
            "method must be local_least_squares",
        ),
        (
            lambda m: vertex_gradients(m, np.zeros(len(m.cells)), sites=m.points),
            "sites must be one point for each cell",
        ),
        (lambda _: local_moving_least_squares(None), "weight must be a radial function"),
        (lambda _: local_rbf(gaussian(0.1)), "kernel must be a smooth radial function without"),
        (lambda _: local_rbf(polyharmonic(1)), "kernel must be a smooth radial function without"),
        (lambda _: local_rbf(polyharmonic(5)), "of order 2 at most"),
        (lambda _: local_rbf(smoothing=-1), "smoothing must be zero or a positive number"),
    ],
)
def test_invalid_arguments_are_refused(call, words):
    """The message names the argument, what came and what was wanted."""
    with pytest.raises(ValueError, match=words):
        call(MESHES["random 2-D"])


@pytest.mark.parametrize("by", [local_least_squares(), local_rbf()], ids=["LS", "RBF"])
def test_vertices_with_too_few_cells_are_refused(by):
    """Two circumcentres lie on a line."""
    mesh = SimplexMesh([[0, 0], [2, 0], [2, 1], [0, 1.5]], [[0, 1, 2], [0, 2, 3]])
    words = "the 2 cells that count about vertex 0 do not determine a gradient"
    with pytest.raises(np.linalg.LinAlgError, match=words):
        vertex_gradients(mesh, np.zeros(2), by)


def test_coincident_sites_are_refused_without_smoothing():
    """Two values at one point cannot be interpolated."""
    mesh = SimplexMesh.delaunay([[0, 0], [2, 0], [2, 2], [0, 2], [1, 5], [3, 4]])
    sites = mesh.circumcenters.copy()
    sites[1] = sites[0]
    with pytest.raises(np.linalg.LinAlgError, match="coincide, so nothing interpolates them"):
        vertex_gradients(mesh, np.zeros(len(sites)), local_rbf(smoothing=0.0), sites)
