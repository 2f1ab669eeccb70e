"""The solutions of notebook 07 agree with the library."""

import numpy as np
import pytest

from checkout import ROOT
from fieldcheck.questions.q07_coordinates_without_division import on_edges
from fieldcheck.questions.q07_voronoi_coordinates import points_inside, star
from fieldgrade.authoring.sources import Source
from fieldrecon import SimplexMesh, VoronoiCell
from fieldreport.experiments.barycentric.hexagon_spiral import Star, from_areas, hexagon, spiral

NOTEBOOK = Source(ROOT / "solutions/07_voronoi_coordinates.py").functions()
ROUNDING = 1e-11
each_star = pytest.mark.parametrize(("n", "seed"), [(3, 0), (5, 1), (6, 2), (9, 3)])


def made(n, seed):
    """A star, its mesh, and the corners of the library's cell in the order of the notebook."""
    center, rim, corners = star(np.random.default_rng(seed), n, clockwise=seed % 2 == 1)
    triangles = [[0, 1 + a, 1 + (a + 1) % n] for a in range(n)]
    mesh = SimplexMesh(np.vstack([center, rim]), triangles)
    return center, rim, corners, mesh


@pytest.mark.parametrize(("turn", "center"), [(0.0, (0.0, 0.0)), (20.0, (3.0, -2.0))])
def test_the_hexagon_is_a_delaunay_triangulation(turn, center):
    library = hexagon(turn, center)
    rim = NOTEBOOK["hexagon"](np.array(center), 1.0, np.deg2rad(turn))
    np.testing.assert_allclose(rim, library.mesh.points[1:], rtol=0, atol=ROUNDING)
    mesh = SimplexMesh.delaunay(np.vstack([center, rim]))
    fan = {frozenset((0, 1 + a, 1 + (a + 1) % 6)) for a in range(6)}
    assert {frozenset(cell) for cell in mesh.cells.tolist()} == fan


@each_star
def test_circumcentres_and_areas_agree_with_the_library(n, seed):
    """The circumcentres are the corners from which the star was made."""
    _, _, corners, mesh = made(n, seed)
    p = [NOTEBOOK["circumcenter"](*mesh.points[cell]) for cell in mesh.cells]
    np.testing.assert_allclose(p, mesh.circumcenters, rtol=0, atol=ROUNDING)
    np.testing.assert_allclose(p, corners, rtol=0, atol=ROUNDING)
    areas = [NOTEBOOK["area"](*mesh.points[cell]) for cell in mesh.cells]
    np.testing.assert_allclose(areas, mesh.cell_measures, rtol=0, atol=ROUNDING)


@each_star
def test_coordinates_agree_with_the_library(n, seed):
    """Quotients are compared inside the cell, products also on its edges and corners."""
    center, rim, corners, mesh = made(n, seed)
    cell = VoronoiCell(mesh, 0)
    order = np.argsort([int(c[0]) for c in cell.cells])
    x = points_inside(np.random.default_rng(9), center, corners, 30)
    wanted = cell.weights(x)[:, order]
    omega = NOTEBOOK["coordinates"](center, rim, corners, x)
    np.testing.assert_allclose(omega, wanted, rtol=0, atol=ROUNDING)
    np.testing.assert_allclose(omega, from_areas(corners, x), rtol=0, atol=ROUNDING)
    border = np.vstack([x, on_edges(corners), corners])
    safe = NOTEBOOK["safe_coordinates"](center, rim, border)
    np.testing.assert_allclose(safe, cell.weights(border)[:, order], rtol=0, atol=ROUNDING)


@each_star
def test_the_field_agrees_with_the_library(n, seed):
    center, rim, corners, mesh = made(n, seed)
    random = np.random.default_rng(seed)
    values, x = random.normal(size=n), points_inside(random, center, corners, 20)
    cell = VoronoiCell(mesh, 0)
    field = cell.field(values[[int(c[0]) for c in cell.cells]])
    mine = NOTEBOOK["interpolate"](center, rim, corners, values, x)
    np.testing.assert_allclose(mine, field(x), rtol=0, atol=ROUNDING)


def test_weights_agree_with_the_formula_of_the_slides():
    """At the centre of a regular hexagon of radius one each weight is 2A / (1/2)²."""
    rim = NOTEBOOK["hexagon"](np.zeros(2), 1.0, 0.0)
    corners = (rim + np.roll(rim, -1, axis=0)) / 3
    w = NOTEBOOK["weights"](np.zeros(2), rim, corners, np.zeros(2))
    np.testing.assert_allclose(w, np.full(6, 2 * np.sqrt(3)), rtol=1e-12)


def test_fields_on_the_spiral_have_the_errors_of_the_experiment():
    """Constants and linear fields are exact; a square has an error of R²/3 at the centre."""
    library = hexagon(20.0, (3.0, -2.0))
    center, rim = library.center, library.mesh.points[1:]
    corners = np.array([NOTEBOOK["circumcenter"](center, *rim[[a, (a + 1) % 6]]) for a in range(6)])
    s = NOTEBOOK["spiral"](center, corners, 50)
    np.testing.assert_allclose(s, spiral(Star(library.mesh, 0), 50), rtol=0, atol=ROUNDING)

    def along(values):
        return NOTEBOOK["interpolate"](center, rim, corners, values, s)

    np.testing.assert_allclose(along(np.ones(6)), 1.0, rtol=1e-13)
    np.testing.assert_allclose(along(corners.sum(axis=1)), s.sum(axis=1), rtol=1e-13)
    error = along(((corners - center).sum(axis=1)) ** 2) - (s - center).sum(axis=1) ** 2
    assert error.min() > 0
    assert error[-1] == pytest.approx(1 / 3, abs=1e-3)
    assert error[0] < error[-1]
