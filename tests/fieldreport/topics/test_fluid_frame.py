"""Flow past a cylinder and a sphere: potential flow, fluxes, meshes and streamlines."""

import re
from functools import partial

import numpy as np
import pytest
from matplotlib.colors import to_hex
from matplotlib.patches import Circle

from checkout import ROOT
from fieldrecon.velocity.vertices import divergence, normal_velocities, vertex_velocities
from fieldreport import experiments
from fieldreport.build.screen_figures import OF_PAGE
from fieldreport.experiments.velocity import fluid_frame
from fieldreport.experiments.velocity.fluid_frame import exact_streamline, traced_streamlines
from fieldreport.experiments.velocity.potential_flow import (
    ball_mesh,
    disc_mesh,
    mean_normal_velocities,
    pressure_coefficient,
    stream_function,
    vector_potential,
    velocity,
)
from fieldreport.framework.error_measures import order

MESHES = {2: partial(disc_mesh, 16, 4.0, 5, 1), 3: partial(ball_mesh, 0.6, 3.0, 1)}


@pytest.fixture(scope="module", params=MESHES)
def mesh(request):
    return MESHES[request.param]()


@pytest.fixture(scope="module")
def found():
    params = fluid_frame.Params(around=(24, 48, 96), relaxations=10, steps_3d=(0.5, 0.25), arc=0.05)
    return experiments.get("fluid_frame").run(params)


def outside(d, seed=0):
    """Points around the ball, at distances from 1 to 3 from its centre."""
    rng = np.random.default_rng(seed)
    x = rng.standard_normal((60, d))
    return x / np.linalg.norm(x, axis=1, keepdims=True) * rng.uniform(1, 3, (60, 1))


def jacobian(f, x):
    """Derivatives (m, components, d) by central differences."""
    steps = 1e-5 * np.eye(x.shape[1])
    return np.stack([(f(x + s) - f(x - s)) / 2e-5 for s in steps], axis=-1)


# --- potential flow ------------------------------------------------------------------------------


@pytest.mark.parametrize("d", [2, 3])
def test_the_velocity_is_a_potential_flow_past_the_ball(d):
    """No divergence, no rotation, tangential at the surface, and uniform far away."""
    g = jacobian(velocity, outside(d))
    assert np.abs(np.trace(g, axis1=1, axis2=2)).max() < 1e-8
    assert np.abs(g - g.mT).max() < 1e-8
    surface = outside(d) / np.linalg.norm(outside(d), axis=1, keepdims=True)
    assert np.abs((velocity(surface) * surface).sum(axis=1)).max() < 1e-14
    np.testing.assert_allclose(velocity(1e6 * surface), np.tile(np.eye(d)[0], (60, 1)), atol=1e-11)


def test_the_stream_function_and_vector_potential_give_the_velocity():
    """u = (∂ψ/∂y, −∂ψ/∂x) in the plane and u = curl A in space."""
    x = outside(2)
    slope = jacobian(lambda y: stream_function(y)[:, None], x)[:, 0]
    np.testing.assert_allclose(slope @ [[0, -1], [1, 0]], velocity(x), atol=1e-8)
    x = outside(3)
    g = jacobian(vector_potential, x)
    curl = np.stack([g[:, 2, 1] - g[:, 1, 2], g[:, 0, 2] - g[:, 2, 0], g[:, 1, 0] - g[:, 0, 1]], 1)
    np.testing.assert_allclose(curl, velocity(x), atol=1e-8)


@pytest.mark.parametrize("d", [2, 3])
def test_the_pressure_satisfies_bernoullis_equation(d):
    """1 − |u|² on the surface; around a cylinder this is 1 − 4 sin²θ."""
    surface = outside(d) / np.linalg.norm(outside(d), axis=1, keepdims=True)
    speed = np.linalg.norm(velocity(surface), axis=1)
    np.testing.assert_allclose(pressure_coefficient(surface[:, 0], d), 1 - speed**2, atol=1e-12)
    assert pressure_coefficient(np.array(0.0), 2) == -3
    assert pressure_coefficient(np.array(0.0), 3) == -1.25


# --- fluxes -------------------------------------------------------------------------------------


def flux_by_quadrature(mesh):
    """The mean of n · u over each face, by subdivision and the midpoint rule."""
    corners = mesh.points[mesh.faces]
    for _ in range(5):
        if corners.shape[1] == 2:
            a, b = corners[:, 0], corners[:, 1]
            m = (a + b) / 2
            parts = [(a, m), (m, b)]
        else:
            a, b, c = corners.transpose(1, 0, 2)
            x, y, z = (b + c) / 2, (c + a) / 2, (a + b) / 2
            parts = [(a, z, y), (z, b, x), (y, x, c), (x, y, z)]
        corners = np.concatenate([np.stack(part, axis=1) for part in parts])
    u = velocity(corners.mean(axis=1)).reshape(-1, len(mesh.faces), corners.shape[2]).mean(axis=0)
    return (u * mesh.face_normals).sum(axis=1)


@pytest.mark.slow
def test_the_mean_normal_velocities_agree_with_quadrature(mesh):
    """The library computes them from the stream function or the vector potential."""
    np.testing.assert_allclose(mean_normal_velocities(mesh), flux_by_quadrature(mesh), atol=2e-3)


def test_the_fluxes_have_no_divergence_in_any_cell(mesh):
    """By Stokes' theorem it vanishes to rounding; sampled normal velocities have a divergence."""
    assert np.abs(divergence(mesh, mean_normal_velocities(mesh))).max() < 1e-12
    sampled = normal_velocities(mesh, velocity(mesh.points))
    assert np.abs(divergence(mesh, sampled)).max() > 1e-2


def test_the_flux_through_the_cylinder_vanishes():
    """The chords have flux zero exactly, because ψ vanishes at both ends."""
    mesh = MESHES[2]()
    chords = fluid_frame.on_ball(mesh)[mesh.faces].all(axis=1)
    assert chords.sum() == 16
    assert np.abs(mean_normal_velocities(mesh)[chords]).max() < 1e-14


# --- meshes -------------------------------------------------------------------------------------


def test_the_mesh_fills_the_region_between_two_polygons():
    """Its area is the difference of two regular polygons, and no cell lies in the inner one."""
    mesh = disc_mesh(20, 5.0, 8, 2)
    polygon = 10 * np.sin(2 * np.pi / 20)
    assert mesh.cell_measures.sum() == pytest.approx((25 - 1) * polygon)
    assert fluid_frame.on_ball(mesh).sum() == 20
    assert np.linalg.norm(mesh.points, axis=1).min() > 1 - 1e-12


def smallest_angle(mesh):
    length = mesh.face_measures[mesh.cell_faces]
    return np.degrees(np.arcsin(2 * mesh.cell_measures * length.min(axis=1) / length.prod(axis=1)))


def test_relaxation_by_springs_improves_the_angles():
    """After relaxation few angles are below 33 degrees; random points have many."""
    random, relaxed = (disc_mesh(32, 6.0, relaxations, 3) for relaxations in (0, 30))
    assert np.percentile(smallest_angle(random), 25) < 33
    assert np.percentile(smallest_angle(relaxed), 5) > 33


def test_the_mesh_around_the_ball_fills_the_shell():
    """The volume agrees up to what the flat faces cut off."""
    mesh = ball_mesh(0.3, 3.0, 2)
    shell = 4 / 3 * np.pi * (27 - 1)
    assert mesh.cell_measures.sum() == pytest.approx(shell, rel=0.05)
    assert np.linalg.norm(mesh.cell_centers, axis=1).min() > 0.9


# --- streamlines --------------------------------------------------------------------------------


def test_the_stream_function_is_constant_along_exact_streamlines():
    """ψ is the distance from the axis far away, above and below the cylinder."""
    height = np.array([[0.01], [0.7], [-1.5]])
    line = exact_streamline(height, np.tile(np.linspace(-3, 3, 41), (3, 1)))
    np.testing.assert_allclose(stream_function(line), np.tile(height, 41), atol=1e-12)
    assert np.linalg.norm(line, axis=-1).min() > 1


def test_streamlines_of_a_rotation_are_circles():
    """Linear fields are exact on triangles, so the error is that of the integrator, order four."""
    mesh = disc_mesh(16, 4.0, 5, 1)
    u = mesh.points @ np.array([[0.0, -1.0], [1.0, 0.0]])  # clockwise
    gaps = []
    for arc in (0.2, 0.1):
        line = traced_streamlines(mesh, u, np.array([[-2.0, 0.0]]), arc, 1.5)
        gaps.append(np.abs(np.linalg.norm(line, axis=-1) - 2).max())
    assert gaps[0] < 1e-4
    assert gaps[0] / gaps[1] > 10


# --- results -------------------------------------------------------------------------------------


@pytest.mark.slow
def test_vertex_velocities_are_of_second_and_cell_velocities_of_first_order(found):
    """In the plane and in space."""
    facts = found.facts
    assert facts["divergence"] < 1e-11
    for d in (2, 3):
        assert facts[f"order_inner_vertices_{d}d"] == pytest.approx(2, abs=0.3)
        assert facts[f"order_cells_{d}d"] == pytest.approx(1, abs=0.3)
    for name in ("plane", "space"):
        cells, again = (found.tables[name].column(m) for m in ("cells", "vertices from cells"))
        assert again[-1] < cells[-1] / 3


@pytest.mark.slow
def test_errors_on_the_surface_are_larger_than_inside(found):
    """At the surface all faces lie on one side; the order is the same."""
    errors = dict(zip(fluid_frame.MEASURES, found.arrays["errors"].T, strict=True))
    assert np.all(errors["surface"] > 10 * errors["inner vertices"])
    assert np.all(errors["surface by LS"] > 1.5 * errors["surface"])
    assert found.facts["error_surface_from_cells"] > 5 * found.facts["error_surface"]
    assert order(found.arrays["steps"], errors["pressure on surface"]) > 1.5
    assert 3 < found.facts["suction_missed_percent"] < 15


@pytest.mark.slow
def test_the_drift_of_computed_streamlines_falls_with_refinement(found):
    """The drift is the change of ψ along a streamline."""
    drift = np.array(found.tables["plane"].column("drift"))
    assert np.all(np.diff(drift) < 0)
    assert drift[-1] < 5e-3


@pytest.mark.slow
def test_the_drawn_velocities_agree_with_the_flow(found):
    """Away from the cylinder the error is below 0.02; normal velocities alone differ much more."""
    arrays = found.arrays
    away = np.linalg.norm(arrays["points"], axis=1)
    away = (away > 1.5) & (away < 6)
    error = np.linalg.norm((arrays["velocities"] - velocity(arrays["points"]))[away], axis=1)
    assert error.max() < 0.02
    gap = np.linalg.norm(arrays["normal_velocities"] - velocity(arrays["middles"]), axis=1)
    assert np.median(gap) > 0.3


def test_a_wrong_sign_of_one_flux_is_detected():
    """It changes the divergence of two cells, and the velocities at the vertices of the face."""
    mesh = MESHES[2]()
    v = mean_normal_velocities(mesh)
    wrong = v.copy()
    inner = np.flatnonzero((mesh.face_cells[:, 1] >= 0) & (np.abs(v) > 0.3))[0]
    wrong[inner] *= -1
    assert np.count_nonzero(np.abs(divergence(mesh, wrong)) > 1e-6) == 2
    change = vertex_velocities(mesh, wrong).values - vertex_velocities(mesh, v).values
    assert np.linalg.norm(change[mesh.faces[inner]], axis=1).min() > 0.02


@pytest.mark.slow
def test_the_cylinder_has_the_colour_of_the_page_in_all_figures(found):
    """Beside a map of colours a grey would stay as light on a dark page as on a white one."""
    for draw in (fluid_frame.plot, fluid_frame.plot_data):
        bodies = [p for a in draw(found).axes for p in a.patches if isinstance(p, Circle)]
        assert bodies
        assert {to_hex(body.get_facecolor()) for body in bodies} <= set(OF_PAGE)


def test_the_listing_of_the_chapter_runs():
    """It runs unchanged, on a mesh with fluxes; both ways give the velocities at vertices."""
    text = (ROOT / "report" / "chapters" / "32-flow.md").read_text("utf-8")
    mesh = MESHES[2]()
    names = {
        "points": mesh.points,
        "triangles": mesh.cells,
        "flux": mean_normal_velocities(mesh) * mesh.face_measures,
        "half_a_step": np.pi / 16,
    }
    exec(re.search(r"^```\{\.python.*?\n(.*?)^```", text, re.S | re.M).group(1), names)
    along = names["W"][0] @ names["v"]
    np.testing.assert_allclose(along, names["at_vertices"].values[:, 0], atol=1e-12)
    gap = np.linalg.norm(names["again"] - names["at_vertices"].values, axis=1)
    assert gap[~mesh.boundary_vertices].max() < 0.2
