"""The elevation data: georeference, order of points and heights, and points on isolines."""

import importlib.util

import numpy as np
import pytest
from scipy.interpolate import RegularGridInterpolator
from scipy.spatial.distance import pdist

from fieldrecon.datasets import elevation as elevation
from fieldrecon.datasets.elevation import Terrain, terrain

EXACT = 1e-9
# In the file: west edge of the first column, north edge of the first row, size of a cell.
WEST, NORTH, DEGREES = -84.41375, 36.44625, 1 / 1200


@pytest.fixture(scope="module")
def land():
    return terrain()


def roof(rows=5, columns=7, slope=3.0):
    """Heights that depend on x only and rise by a whole number of metres per column."""
    x, y = 10.0 * np.arange(columns), 20.0 * np.arange(rows)
    return Terrain(x, y, np.broadcast_to(slope * np.arange(columns), (rows, columns)).copy())


def test_the_highest_cell_is_the_summit_of_cross_mountain(land):
    """The highest cell contains the published summit: 36.19833° N, 84.23056° W, 1077 m.

    Coordinates and height of the summit are from the gazetteer of the U.S. Geological Survey. The
    tolerance is one cell. If the rows were read in reverse order, or from the latitude that the
    file calls ymin, the summit would be at least 9 km from there.
    """
    row, column = np.unravel_index(land.height.argmax(), land.height.shape)
    row_from_north = len(land.y) - 1 - row
    latitude = NORTH - (row_from_north + 0.5) * DEGREES
    longitude = WEST + (column + 0.5) * DEGREES
    assert (latitude, longitude) == pytest.approx((36.19833, -84.23056), abs=DEGREES)
    assert land.height.max() == pytest.approx(1077, abs=2)


def test_y_points_north(land):
    """The Tennessee valley, the lowest part of the map, lies in the south-east."""
    rows, columns = land.height.shape
    south_east = land.height[: rows // 4, 3 * columns // 4 :]
    north_east = land.height[3 * rows // 4 :, 3 * columns // 4 :]
    north_west = land.height[3 * rows // 4 :, : columns // 4]
    assert np.median(south_east) + 50 < min(np.median(north_east), np.median(north_west))


def test_a_cell_has_the_size_of_three_seconds_of_arc(land):
    """At 36.3° N a degree is 89.8 km along the parallel and 111.0 km along the meridian.

    This is the middle of 344 rows.
    """
    assert np.ptp(np.diff(land.x)) < EXACT
    assert np.ptp(np.diff(land.y)) < EXACT
    assert land.x[1] * 1.2 == pytest.approx(89.8, abs=0.05)
    assert land.y[1] * 1.2 == pytest.approx(111.0, abs=0.05)
    east, north = elevation._metres_per_degree(NORTH - 344 / 2 * DEGREES)
    assert (land.x[1], land.y[1]) == pytest.approx((east * DEGREES, north * DEGREES))


def test_the_length_of_a_degree_is_exact_at_equator_and_pole():
    """A degree of longitude at the equator is π a/180.

    A degree of latitude at the pole is π a²/(180 b).
    """
    a, b = 6378137.0, 6356752.314245
    at_equator, at_pole = elevation._metres_per_degree(0.0), elevation._metres_per_degree(90.0)
    assert at_equator == pytest.approx((np.pi * a / 180, np.pi * b**2 / a / 180), abs=1e-6)
    assert at_pole == pytest.approx((0.0, np.pi * a**2 / b / 180), abs=1e-6)


def test_points_and_heights_are_in_the_same_order(land):
    """Row k of the points is the location of entry k of the heights."""
    columns = len(land.x)
    k = 17 * columns + 5
    assert land.points.shape == (344 * 403, 2)
    assert land.points[k].tolist() == [land.x[5], land.y[17]]
    assert land.height.ravel()[k] == land.height[17, 5]


@pytest.mark.slow
@pytest.mark.parametrize(("spacing", "apart"), [(10, 0), (25, 150.0), (50, 0)])
def test_isolines_lie_on_their_levels(land, spacing, apart):
    """Bilinear interpolation, which is linear along the grid edges, reproduces the level."""
    points, levels = land.isolines(spacing, apart)
    height = RegularGridInterpolator((land.y, land.x), land.height)
    np.testing.assert_allclose(height(points[:, ::-1]), levels, atol=EXACT)
    assert set(levels) == set(np.arange(0.5, 1076, spacing)[np.arange(0.5, 1076, spacing) > 236])
    assert len(np.unique(points, axis=0)) == len(points)


def test_isolines_of_a_roof_equal_the_computation_by_hand():
    """The heights 0, 3, 6, … cross the level h at x = 10 h/3 in every row."""
    points, levels = roof().isolines(2)
    np.testing.assert_allclose(points[:, 0], levels * 10 / 3)
    assert sorted(set(levels)) == [0.5, 2.5, 4.5, 6.5, 8.5, 10.5, 12.5, 14.5, 16.5]
    assert len(points) == 5 * 9


def test_isolines_keep_close_points_unless_a_distance_is_asked_for():
    """Of points in rows 0.02 m apart every second one is closer to another than 0.03 m."""
    steep = Terrain(roof().x, roof().y / 1000, roof().height)
    points, levels = steep.isolines(2)
    assert len(points) == len(roof().isolines(2)[0])
    assert len(steep.isolines(2, 0.03)[0]) == len(points) * 3 // 5
    assert (np.diff(points[np.lexsort((points[:, 1], levels)), 1]) < 0.03).all()


def test_isolines_commute_with_exchanging_x_and_y():
    """The isolines of the transposed terrain are the isolines with x and y exchanged."""
    land = terrain()
    part = Terrain(land.x[:60], land.y[:50], land.height[:50, :60])
    transposed = Terrain(part.y, part.x, part.height.T)
    (a, _), (b, _) = part.isolines(20), transposed.isolines(20)
    np.testing.assert_allclose(a[np.lexsort(a.T)], b[:, ::-1][np.lexsort(b[:, ::-1].T)], atol=EXACT)


def test_points_on_isolines_are_kept_one_after_the_other():
    """The literal way: a point is kept if none that was kept on its level is as close.

    At a distance larger than the map, one is kept on each level.
    """
    x, y = 10.0 * np.arange(12), 15.0 * np.arange(9)
    height = np.floor(20 * np.cos(x / 30) + 15 * np.sin(y / 25)[:, None])
    land = Terrain(x, y, height)
    points, levels = land.isolines(4)
    kept = []
    for i, point in enumerate(points):
        on_level = [j for j in kept if levels[j] == levels[i]]
        if all(np.linalg.norm(point - points[j]) > 12 for j in on_level):
            kept.append(i)
    assert len(points) / 4 < len(kept) < len(points)
    thinned, of_level = land.isolines(4, apart=12)
    assert thinned.tolist() == points[kept].tolist()
    assert of_level.tolist() == levels[kept].tolist()
    assert sorted(land.isolines(4, apart=1e12)[1]) == sorted({*levels})


@pytest.mark.slow
def test_thinned_isolines_are_a_maximal_set_of_distant_points(land):
    """Points on one level are more than `apart` metres from each other.

    Each removed point is within this distance of a remaining one.
    """
    all_points, all_levels = land.isolines(100)
    points, levels = land.isolines(100, apart=500.0)
    for level in np.unique(all_levels):
        kept = points[levels == level]
        assert len(kept) < 2 or pdist(kept).min() > 500
        left_out = all_points[all_levels == level]
        gaps = np.linalg.norm(left_out[:, None] - kept[None], axis=-1).min(axis=1)
        assert gaps.max() <= 500


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((2.5,), "spacing must be a whole number of metres, 1 or more; got 2.5"),
        ((0,), "spacing must be a whole number of metres, 1 or more; got 0"),
        ((10, -1.0), "apart must be zero or a positive number of metres; got -1.0"),
    ],
)
def test_invalid_spacings_are_refused(arguments, words):
    """The message names the argument, what came and what was wanted."""
    with pytest.raises(ValueError, match=words):
        roof().isolines(*arguments)


def test_without_matplotlib_the_install_command_is_shown(monkeypatch):
    """The elevation data are a file of matplotlib."""
    monkeypatch.setattr(elevation, "find_spec", lambda _: None)
    with pytest.raises(
        ModuleNotFoundError, match=r"is a file of matplotlib.* extra 'pictures': pip install "
    ):
        terrain()


def test_a_matplotlib_without_sample_data_is_reported(monkeypatch, tmp_path):
    """The message names the missing file."""
    spec = importlib.util.find_spec("json")
    spec.submodule_search_locations = [str(tmp_path)]
    monkeypatch.setattr(elevation, "find_spec", lambda _: spec)
    with pytest.raises(FileNotFoundError, match="without the terrain: no file"):
        terrain()
