"""Claims of the chapter on pressure gradients: orders, the boundary, and the weights."""

import numpy as np
import pytest

from fieldrecon.kernels.weights import inverse_square
from fieldrecon.methods.moving_least_squares import MovingLeastSquares
from fieldrecon.velocity.gradients import local_moving_least_squares, vertex_gradients
from fieldreport import experiments
from fieldreport.experiments.meshes.reference_flows import equilateral_mesh, jittered_cube
from fieldreport.experiments.velocity import pressure_gradients
from fieldreport.experiments.velocity.pressure_gradients import (
    METHODS,
    diffuse,
    pressure,
    pressure_gradient,
)
from fieldreport.framework.error_measures import order, rms

pytestmark = pytest.mark.slow  # experiments are run


@pytest.fixture(scope="module")
def found():
    params = pressure_gradients.Params(sides=(8, 16, 32), sides_3d=(4, 8), values=9, sweep_side=16)
    return experiments.get("pressure_gradients").run(params)


def rows(found):
    table = found.tables["orders"]
    return {row[:2]: dict(zip(table.columns, row, strict=True)) for row in table.rows}


@pytest.mark.parametrize("d", [2, 3])
def test_the_reference_gradient_is_the_derivative_of_the_pressure(d):
    """It is compared with central differences."""
    x = np.random.default_rng(0).random((50, d))
    for k, step in enumerate(1e-5 * np.eye(d)):
        slope = (pressure(x + step) - pressure(x - step)) / 2e-5
        np.testing.assert_allclose(slope, pressure_gradient(x)[:, k], atol=1e-9)


def test_irregular_meshes_give_first_order_inside_and_on_the_boundary(found):
    """This holds for every method; the error on the boundary has a larger constant."""
    for method in METHODS:
        inside, boundary = (rows(found)["jittered, plane", w] for w in ("inside", "boundary"))
        assert inside[f"{method}, order"] == pytest.approx(1, abs=0.25)
        assert boundary[f"{method}, order"] == pytest.approx(1, abs=0.25)
        assert boundary[method] > 3 * inside[method]


def test_equilateral_meshes_give_second_order_inside_only(found):
    """Circumcentres lie in pairs opposite to the vertex, so even derivatives cancel."""
    for method in METHODS:
        inside, boundary = (rows(found)["equilateral, plane", w] for w in ("inside", "boundary"))
        assert inside[f"{method}, order"] == pytest.approx(2, abs=0.1)
        assert boundary[f"{method}, order"] == pytest.approx(1, abs=0.25)


def test_rbf_is_more_accurate_than_mls_and_mls_than_ls(found):
    """This holds inside irregular meshes, in the plane and in space."""
    for mesh in ("jittered, plane", "jittered, space"):
        inside = rows(found)[mesh, "inside"]
        assert inside["RBF"] < inside["MLS"] < inside["LS"]


def test_a_vertex_in_space_has_four_times_as_many_neighbours_as_in_the_plane(found):
    """Cells at vertices not on the faces of the cube, counted from the list of cells."""
    mesh = jittered_cube(8, 3, 0.6, 0)
    cells = np.bincount(mesh.cells.ravel())[((mesh.points > 0) & (mesh.points < 1)).all(axis=1)]
    assert found.facts["cells_at_vertex_3d"] == pytest.approx(cells.mean(), rel=1e-5)
    assert 4 * 6 < cells.mean() < 5 * 6


def test_gradients_agree_with_numpy_and_scipy(found):
    """Central differences lose half the digits, and a fit in closed form loses none."""
    assert found.facts["gap_ls"] < 1e-11
    assert found.facts["gap_mls"] < 1e-7
    assert found.facts["gap_rbf"] < 1e-7


def test_the_diffuse_derivative_is_not_the_gradient_of_the_field(found):
    """It has the same error but is another vector; both agree only for large ε."""
    facts, sweep = found.facts, found.arrays["sweep"]
    assert facts["best_diffuse"] == pytest.approx(facts["best_full"], rel=0.1)
    assert facts["largest_difference"] > 0.1 * facts["best_full"]
    assert sweep[-1, 2] < 1e-2 * sweep[0, 2]


def test_the_diffuse_derivative_is_the_slope_of_the_local_fit():
    """NumPy fits around the vertex; the full derivative is the gradient of the library's field."""
    mesh = jittered_cube(8, 2, 0.6, 1)
    weight, p = inverse_square(0.05), pressure(mesh.circumcenters)
    inner = np.flatnonzero(~mesh.boundary_vertices)[::7]
    slopes = vertex_gradients(mesh, p, diffuse(weight), vertices=inner)
    full = vertex_gradients(mesh, p, local_moving_least_squares(weight), vertices=inner)
    for i, slope, gradient in zip(inner, slopes, full, strict=True):
        cells = mesh.vertex_cells(i)
        y = mesh.circumcenters[cells] - mesh.points[i]
        w = weight(np.linalg.norm(y, axis=1))
        basis = np.column_stack([np.ones(len(y)), y])
        fit = np.linalg.lstsq(w[:, None] * basis, w * p[cells])[0]
        np.testing.assert_allclose(slope, fit[1:], atol=1e-10)
        field = MovingLeastSquares(mesh.circumcenters[cells], weight).field(p[cells])
        np.testing.assert_allclose(gradient, field.gradient(mesh.points[i]), atol=1e-9)


def test_cell_means_must_not_be_used_as_values_at_circumcentres(found):
    """The error of the gradient then does not fall; with values at the centroids it does."""
    facts = found.facts
    assert facts["means_order"] < 0.5
    assert facts["means_at_centroids_order"] == pytest.approx(1, abs=0.25)
    assert facts["means_error"] > 3 * facts["means_at_centroids_error"]


@pytest.mark.parametrize("d", [2, 3])
def test_cell_means_agree_with_monte_carlo_means(d):
    """They agree within the standard error of many points drawn uniformly in each cell."""
    mesh = jittered_cube(6, d, 0.6, 2)
    shares = np.random.default_rng(3).dirichlet(np.ones(d + 1), 40000)
    for c in range(0, len(mesh.cells), len(mesh.cells) // 4):
        values = pressure(shares @ mesh.points[mesh.cells[c]])
        gap = pressure_gradients._means(mesh)[c] - values.mean()
        assert abs(gap) < 5 * values.std() / np.sqrt(len(values)) + 1e-4


def test_an_equilateral_mesh_covers_the_square_and_is_regular():
    """All edges have equal length, and each inner vertex has six triangles."""
    mesh = equilateral_mesh(5)
    np.testing.assert_allclose(mesh.face_measures, 0.2, rtol=1e-12)
    assert mesh.points.max(axis=0).min() >= 1
    valence = mesh.vertex_cell_incidence.sum(axis=1)
    assert set(valence[~mesh.boundary_vertices]) == {6}


def test_rms_and_order_have_known_values():
    """The root of the mean squared length, and the slope in logarithmic axes."""
    assert rms(np.array([[3.0, 4.0], [0.0, 0.0]])) == pytest.approx(5 / np.sqrt(2))
    assert order([1, 0.5, 0.25], [8, 1, 1 / 8]) == pytest.approx(3)
