"""Claims of the chapter on cell velocities: triangles, tetrahedra and noise."""

import numpy as np
import pytest

from fieldrecon.meshes.simplex_mesh import SimplexMesh
from fieldrecon.velocity.cells import cell_velocities
from fieldrecon.velocity.vertices import normal_velocities
from fieldreport import experiments
from fieldreport.experiments.meshes.reference_flows import abc_flow, jittered_cube, taylor_green
from fieldreport.experiments.velocity import cell_velocity
from fieldreport.experiments.velocity.cell_velocity import (
    GRADIENTS,
    PLACES,
    ROTATION,
    STRAIN,
    closed_form,
)
from fieldreport.framework.error_measures import order

pytestmark = pytest.mark.slow  # experiments are run

ROUNDING = 1e-12


@pytest.fixture(scope="module")
def found():
    return experiments.get("cell_velocity").run(
        cell_velocity.Params(sides=(8, 32), sides_3d=(3, 9))
    )


def row(found, d, field):
    """Return a row of the table of fields by its columns."""
    table = found.tables["fields"]
    (cells,) = (r for r in table.rows if r[:2] == (d, field))
    return dict(zip(table.columns, cells, strict=True))


def some_triangles():
    corners = np.random.default_rng(0).uniform(-1, 1, (300, 3, 2))
    edges = corners[:, 1:] - corners[:, :1]
    return corners[np.abs(np.linalg.det(edges)) > 0.05]


def by_least_squares(corners, g):
    """Return u − u(O) in the field G x by numpy.linalg.lstsq, for each triangle."""
    error = []
    for p in corners:
        middle, edge = (np.roll(p, -1, axis=0) + p) / 2, np.roll(p, -1, axis=0) - p
        n = edge @ ROTATION / np.linalg.norm(edge, axis=1, keepdims=True)
        u = np.linalg.lstsq(n, np.einsum("ad,ad->a", n, middle @ g.T))[0]
        center = np.linalg.solve(2 * (p[1:] - p[0]), (p[1:] ** 2 - p[0] ** 2).sum(axis=1))
        error.append(u - g @ center)
    return np.array(error)


def check_closed_form(form):
    corners, rng = some_triangles(), np.random.default_rng(1)
    for _ in range(5):
        g = rng.uniform(-1, 1, (2, 2))
        np.testing.assert_allclose(form(corners, g), by_least_squares(corners, g), atol=1e-9)


def test_the_closed_form_agrees_with_least_squares_by_numpy():
    """They agree for affine fields and arbitrary triangles, without using the library."""
    check_closed_form(closed_form)


@pytest.mark.parametrize("part", [np.eye(2), STRAIN, np.array([[0.0, 1.0], [1.0, 0.0]])])
def test_a_closed_form_without_one_of_its_terms_fails(part):
    """Expansion and both strains contribute to the error, and the rotation does not."""
    with pytest.raises(AssertionError, match="Not equal"):
        check_closed_form(lambda corners, g: closed_form(corners, g - np.sum(g * part) / 2 * part))
    check_closed_form(lambda corners, g: closed_form(corners, g + ROTATION))


def places(corners, strains=7):
    return cell_velocity.places_on_triangle(corners, strains)


@pytest.mark.parametrize("k", range(12))
def test_each_field_attains_its_velocity_at_a_triangle_centre(k):
    """Rotation at the circumcentre, expansion at the symmedian point, strain on Feuerbach's circle.

    The circle passes through the midpoints of the sides, by which the test recognizes it.
    """
    corners = some_triangles()[k]
    at = places(corners)
    np.testing.assert_allclose(at["places"][0], at["center"], atol=1e-10)
    np.testing.assert_allclose(at["places"][1], at["symmedian"], atol=1e-10)
    distance = np.linalg.norm(at["places"][2:] - at["nine_point_center"], axis=1)
    middles = (np.roll(corners, -1, axis=0) + corners) / 2
    through = np.linalg.norm(middles - at["nine_point_center"], axis=1)
    np.testing.assert_allclose(through, at["nine_point_radius"], atol=1e-10)
    np.testing.assert_allclose(distance, at["nine_point_radius"], atol=1e-10)


def test_some_strain_attains_its_velocity_at_the_midpoint_of_a_side():
    """The strain whose normal velocities vanish at the midpoints of the sides."""
    corners = np.array([[-1.0, 0.0], [1.0, 0.0], [0.3, 1.7]])
    mesh = SimplexMesh(corners, [[0, 1, 2]])
    middle = corners[:2].mean(axis=0)
    hits = []
    for angle in np.linspace(0, np.pi, 3600, endpoint=False):
        g = np.array([[np.cos(angle), np.sin(angle)], [np.sin(angle), -np.cos(angle)]])
        u = cell_velocities(mesh, normal_velocities(mesh, mesh.points @ g.T)).values[0]
        hits.append(np.linalg.norm(np.linalg.solve(g, u) - middle))
    assert min(hits) < 2e-3


def test_only_the_rotation_is_exact_at_the_circumcentre(found):
    """Strain and expansion have an error there; the rotation has an error elsewhere."""
    rotation = row(found, 2, "rotation")
    assert rotation["circumcentre"] < ROUNDING < rotation["centroid"] < rotation["vertices"]
    for field in ("expansion", "strain"):
        assert row(found, 2, field)["circumcentre"] > row(found, 2, field)["centroid"] > ROUNDING
    assert found.facts["closed_form_gap"] < ROUNDING


def test_raviart_thomas_is_exact_for_expansion_and_not_for_strain(found):
    """For a divergence-free field it is constant in the cell, so it does not differ."""
    for d in (2, 3):
        expansion, strain = row(found, d, "expansion"), row(found, d, "strain")
        assert expansion["RT at circumcentre"] < ROUNDING < expansion["circumcentre"]
        assert strain["RT at circumcentre"] == pytest.approx(strain["circumcentre"], rel=1e-6)


def test_in_space_a_rotation_requires_the_circumcentres_of_faces(found):
    """With normal velocities at the centroids of the faces it is not exact."""
    assert row(found, 3, "rotation, v at circumcentres")["circumcentre"] < ROUNDING
    assert row(found, 3, "rotation")["circumcentre"] > 0.01


def test_a_small_defect_does_not_imply_a_small_error(found):
    """The strain has no defect and a larger error than the expansion."""
    assert row(found, 2, "strain")["defect"] < ROUNDING
    assert row(found, 2, "strain")["circumcentre"] > row(found, 2, "expansion")["circumcentre"]
    assert row(found, 2, "expansion")["defect"] > 0.01


def test_noise_affects_defect_and_velocity_as_predicted(found):
    """The defect has the standard deviation of the noise; the pseudo-inverse gives the other."""
    for d in (2, 3):
        assert found.facts[f"defect_over_noise_{d}d"] == pytest.approx(1, abs=0.15)
        predicted, drawn = (found.facts[f"{name}_gain_{d}d"] for name in ("disturbance", "drawn"))
        assert drawn == pytest.approx(predicted, rel=0.05)


@pytest.mark.parametrize(("u", "d"), [(taylor_green, 2), (abc_flow, 3)])
def test_the_reference_flows_are_divergence_free(u, d):
    """Central differences; the velocity of the cells therefore has no error from expansion."""
    x = np.random.default_rng(2).random((50, d))
    steps = 1e-5 * np.eye(d)
    total = sum((u(x + s)[:, k] - u(x - s)[:, k]) / 2e-5 for k, s in enumerate(steps))
    assert np.abs(total).max() < 1e-8


def test_cell_errors_are_of_first_order_and_partly_cancel_at_vertices():
    """The mean of the cells around an inner vertex converges faster by half an order."""
    params = cell_velocity.Params(sides=(8, 16, 32))
    errors = np.array(
        [cell_velocity.errors_on_mesh(params, (2, side))["vortices"] for side in params.sides]
    )
    h = 1 / np.array(params.sides)
    at = {place: errors[:, k] for k, place in enumerate(PLACES)}
    assert order(h, at["circumcentre"]) == pytest.approx(1, abs=0.2)
    assert order(h, at["inner vertices"]) > 1.4
    assert at["inner vertices"][-1] < at["circumcentre"][-1] / 2


def test_the_gain_at_inner_vertices_is_that_of_literal_means(found):
    """Means with the weights V / ∏ l², vertex by vertex; the gain is smaller in space."""
    mesh = jittered_cube(32, 2, 0.6, 0)
    u = cell_velocities(mesh, normal_velocities(mesh, taylor_green(mesh.points))).values
    error = []
    for i in np.flatnonzero(~mesh.boundary_vertices):
        cells = np.flatnonzero((mesh.cells == i).any(axis=1))
        others = mesh.cells[cells][mesh.cells[cells] != i].reshape(-1, 2)
        squares = ((mesh.points[others] - mesh.points[i]) ** 2).sum(axis=2)
        w = mesh.cell_measures[cells] / squares.prod(axis=1)
        error.append(np.linalg.norm(w @ u[cells] / w.sum() - taylor_green(mesh.points[i])))
    of_cells = np.linalg.norm(u - taylor_green(mesh.circumcenters), axis=1)
    gain = found.facts["gain_inner_2d"]
    assert gain == pytest.approx(np.median(of_cells) / np.median(error), rel=1e-5)
    assert 1 < found.facts["gain_inner_3d"] < gain


def test_rotation_expansion_and_strain_have_their_defining_properties():
    """They are skew-symmetric, the identity, and symmetric with trace zero."""
    for of_dimension in GRADIENTS.values():
        rotation, expansion, strain = of_dimension.values()
        np.testing.assert_array_equal(rotation, -rotation.T)
        np.testing.assert_array_equal(expansion, np.eye(len(expansion)))
        np.testing.assert_array_equal(strain, strain.T)
        assert np.trace(strain) == 0


def test_a_jittered_mesh_fills_the_cube_and_is_a_delaunay_mesh():
    """The volumes sum to that of the cube, and no vertex lies inside a circumsphere."""
    for d, side in ((2, 6), (3, 3)):
        mesh = jittered_cube(side, d, 0.6, 5)
        assert mesh.cell_measures.sum() == pytest.approx(1)
        radius = np.linalg.norm(mesh.points[mesh.cells[:, 0]] - mesh.circumcenters, axis=1)
        distance = np.linalg.norm(mesh.points - mesh.circumcenters[:, None], axis=2).min(axis=1)
        assert np.all(distance > radius * (1 - 1e-6) - 1e-9)


def test_apparent_errors_of_a_rotation_are_distances_to_the_circumcentre(found):
    """At rate one the apparent error is R at a vertex and |h|/3 at the centroid."""
    mesh = jittered_cube(32, 2, found.params.jitter, found.params.seed)
    radius = np.linalg.norm(mesh.points[mesh.cells[:, 0]] - mesh.circumcenters, axis=1)
    offset = (mesh.points[mesh.cells] - mesh.circumcenters[:, None]).sum(axis=1) / 3
    rotation = row(found, 2, "rotation")
    assert rotation["vertices"] == pytest.approx(np.sqrt(np.mean(radius**2)))
    assert rotation["centroid"] == pytest.approx(np.sqrt(np.mean((offset**2).sum(axis=1))))


def test_the_error_is_of_the_size_of_the_circumradius_and_not_of_the_cell():
    """At most R (|s| + 2 |σ|); in a flat triangle a strain at 45° to the base has nearly 2 R."""
    rng = np.random.default_rng(5)
    for corners in (*rng.random((200, 3, 2)), np.array([[0.0, 0], [1, 0], [0.5, 0.01]])):
        q = corners @ [1, 1j]
        o, r = circumcircle(q)
        s, sigma = rng.normal(), rng.normal() + 1j * rng.normal()
        bound = r * (abs(s) + 2 * abs(sigma))
        assert abs(velocity_of(q, o, s, sigma)) <= bound * (1 + 1e-9)
    shear = velocity_of(q, o, 0.0, 1j)
    assert r == pytest.approx((1 / 4 + 1e-4) / 0.02)
    assert abs(shear) == pytest.approx(2 * r, rel=2e-3)
    assert abs(shear - 1j * np.conj(q.mean() - o)) == pytest.approx(r, rel=2e-3)


def circumcircle(q):
    """Centre and radius of the circle through three complex numbers."""
    d = q - q[0]
    top = d[1] * d[2] * np.conj(d[1] - d[2])
    o = q[0] + top / (np.conj(d[1]) * d[2] - d[1] * np.conj(d[2]))
    return o, abs(o - q[0])


def velocity_of(q, o, s, sigma):
    """Least squares for an expansion s and a strain σ about o, by numpy, in complex numbers."""
    edges = np.roll(q, -1) - q
    normals = -1j * edges / abs(edges)
    z = (q + np.roll(q, -1)) / 2 - o
    v = (np.conj(normals) * (s * z + sigma * np.conj(z))).real
    return complex(*np.linalg.lstsq(np.stack([normals.real, normals.imag], axis=1), v)[0])
