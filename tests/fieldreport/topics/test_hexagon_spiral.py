"""The spiral in the hexagon: reproduction by Voronoi coordinates, and errors of quotients."""

from fractions import Fraction

import numpy as np
import pytest

from fieldrecon import VoronoiCell
from fieldreport.experiments.barycentric import hexagon_spiral
from fieldreport.experiments.barycentric.hexagon_spiral import (
    at_random,
    from_areas,
    hexagon,
    icosahedron,
    quotients,
    spiral,
)

ROUNDING = 1e-14
STARS = {
    "hexagon": hexagon(),
    "turned": hexagon(20.0),
    "moved": hexagon(0.0, (3.0, -2.0)),
    "plane": at_random(60, 2, 0),
    "icosahedron": icosahedron(),
    "space": at_random(60, 3, 0),
}


@pytest.fixture(scope="module")
def result():
    return hexagon_spiral.run(hexagon_spiral.Params())  # unrounded facts


@pytest.fixture(params=STARS.values(), ids=STARS.keys())
def star(request):
    return request.param


def test_the_radius_of_the_spiral_agrees_with_the_slides():
    """It is the distance to the midpoint of two adjacent circumcentres, half the shortest spoke."""
    for turn in (0.0, 20.0):
        here = hexagon(turn, (3.0, -2.0))
        corners = here.corners[np.argsort(np.arctan2(*(here.corners - here.center).T))]
        r = np.linalg.norm((corners[0] + corners[1]) / 2 - here.center)
        assert np.linalg.norm(spiral(here, 50)[0] - here.center) == pytest.approx(r, abs=ROUNDING)


def test_the_spiral_stays_in_the_cell(star):
    """Each point is nearer to x_i than to any neighbour, and the n-th has the radius r / n."""
    s = spiral(star, 50)
    to_center = ((s - star.center) ** 2).sum(axis=1)
    to_others = ((s[:, None] - star.center - star.spokes) ** 2).sum(axis=2)
    assert (to_center < to_others.min(axis=1)).all()
    n = np.arange(1, 51)
    np.testing.assert_allclose(np.sqrt(to_center) * n, np.sqrt(to_center[0]), rtol=1e-12)


def test_without_its_centre_the_spiral_leaves_the_cell(result):
    """The printed formula turns about the origin: no point is in the cell of the moved hexagon."""
    moved = hexagon(0.0, result.params.center)
    s = spiral(hexagon(), result.params.steps)
    beyond = (s - moved.center) @ moved.spokes.T - (moved.spokes**2).sum(axis=1) / 2
    assert (beyond.max(axis=1) > 0).all()


def test_constant_and_linear_data_are_reproduced(star):
    """This holds on every star and at every point of the spiral, up to rounding."""
    cell, s = VoronoiCell(*star), spiral(star, 50)
    size = np.abs(cell.points).max()
    assert abs(cell.field(np.ones(len(cell.points)))(s) - 1).max() < ROUNDING
    assert abs(cell.field(cell.points.sum(axis=1))(s) - s.sum(axis=1)).max() < ROUNDING * size
    assert cell.weights(s).min() > 0


def test_quadratic_data_are_not_reproduced(result):
    """|p|² is R²/3 at all six corners, so the field is constant, while |s_n|² = (R/2n)²."""
    table = result.tables["spiral"]
    n = np.array(table.column("n"))
    np.testing.assert_allclose(table.column("quadratic"), 1 / 3, rtol=1e-8)
    np.testing.assert_allclose(table.column("x² + y²"), 1 / (4 * n**2), rtol=1e-8)


def test_the_weights_agree_with_area_coordinates():
    """Areas of triangles of corners and query point, computed without a mesh."""
    for name in ("hexagon", "turned", "moved", "plane"):
        cell, s = VoronoiCell(*STARS[name]), spiral(STARS[name], 50)
        around = np.argsort(np.arctan2(*(cell.points - STARS[name].center).T))
        areas = from_areas(cell.points[around], s)
        assert abs(cell.weights(s)[:, around] - areas).max() < 1e-12


def test_area_coordinates_are_bilinear_in_a_square():
    """Known coordinates of the unit square: (1 − x)(1 − y), x(1 − y), xy, (1 − x)y."""
    corners = np.array([[0.0, 0], [1, 0], [1, 1], [0, 1]])
    x, y = Fraction(1, 4), Fraction(5, 8)
    exact = [(1 - x) * (1 - y), x * (1 - y), x * y, (1 - x) * y]
    found = from_areas(corners, np.array([[float(x), float(y)]]))[0]
    assert abs(found - np.array(exact, dtype=float)).max() < ROUNDING


def test_the_first_point_has_the_predicted_distance_from_the_edge(result):
    """s_1 is R/2 (1 − cos 2π/N) from the edge, and inside if no spoke points at 2π/N."""
    assert result.facts["margin"] == pytest.approx((1 - np.cos(2 * np.pi / 50)) / 2, rel=1e-8)


def test_on_an_edge_only_the_product_form_is_defined(result):
    """Between two corners the field is linear along the edge."""
    assert result.arrays["moved_product"].max() < ROUNDING
    assert result.arrays["moved_quotient"][0] > 1e-3
    assert result.arrays["moved_quotient"][1:].max() < ROUNDING


def test_quotients_lose_digits_near_an_edge(result):
    """The error is inversely proportional to the distance; one height per face avoids the loss."""
    distances, near = result.arrays["distances"], result.arrays["near"]
    middle = (distances > 1e-14) & (distances < 1e-3)
    slope = np.polyfit(np.log(distances[middle]), np.log(near[middle, 0]), 1)[0]
    assert slope == pytest.approx(-1, abs=0.05)
    assert near[middle, 1].max() < ROUNDING
    assert near[:, 2].max() < ROUNDING


def test_quotients_and_products_agree_away_from_edges(star):
    cell, s = VoronoiCell(*star), spiral(star, 50)[1:]
    order = np.concatenate(cell.cells)
    for one_height in (False, True):
        w = quotients(star, s, one_height)
        in_order = w[:, np.searchsorted(star.cells, order)]
        assert abs(in_order - cell.weights(s)).max() < 1e-11


@pytest.mark.parametrize("name", ["plane", "space"])
def test_weights_without_the_volume_fail(name):
    """Where cells differ, their volumes matter, and the comparison detects the wrong formula."""
    star = STARS[name]
    s = spiral(star, 50)[1:]
    w = quotients(star, s) / star.mesh.cell_measures[star.cells]
    w /= w.sum(axis=1, keepdims=True)
    assert abs(w @ star.corners - s).max() > 1e-3
