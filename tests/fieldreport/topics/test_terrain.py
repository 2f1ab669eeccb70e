"""Terrain: known surfaces are reproduced, and landforms beyond the last isolines are found."""

from functools import partial

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy.interpolate import LinearNDInterpolator

from fieldrecon.datasets.elevation import Terrain, terrain
from fieldreport import experiments
from fieldreport.experiments.datasets import terrain_methods
from fieldreport.experiments.datasets.terrain import QUICK, Params, on_one_isoline, run, study
from fieldreport.experiments.datasets.terrain_errors import (
    HOLLOW,
    NONE,
    SLOPE,
    TOP,
    TerrainProblem,
    beyond_band,
    landforms,
    level_below,
    measured,
    part,
    phase,
    relief_told,
    windowed,
)
from fieldreport.experiments.datasets.terrain_methods import GUARDED, THIN_PLATE, methods

EXACT = 1e-9
SMALL = Params(
    spacing=20,
    apart=15.0,
    degrees=(1, 2),
    shown_degree=2,
    window=(50.0, 50.0, 200.0),
    spacings=(10, 20),
)


def land(height_at, rows=30, columns=40):
    """Heights of a function of column and row, cells of 10 m × 12 m."""
    j, i = np.meshgrid(np.arange(columns), np.arange(rows))
    return Terrain(10.0 * np.arange(columns), 12.0 * np.arange(rows), 1.0 * height_at(j, i))


def plane():
    """A plane that rises to the north-east, by whole metres from cell to cell."""
    return land(lambda j, i: 5 * j + 3 * i)


def hills():
    """Two hills and a hollow between them."""
    return land(
        lambda j, i: np.round(
            90 * np.exp(-((j - 10) ** 2 + (i - 15) ** 2) / 40)
            + 70 * np.exp(-((j - 30) ** 2 + (i - 12) ** 2) / 30)
            - 60 * np.exp(-((j - 20) ** 2 + (i - 20) ** 2) / 20)
        )
    )


@pytest.fixture(scope="module")
def quick():
    return run(QUICK)  # unrounded facts


EXACT_ON_PLANES = (
    "LS 1",
    "LS 2",
    "MLS 1",
    "MLS 1 wide",
    "MLS 2",
    "MLS 2 wide",
    "RBF r³",
    THIN_PLATE,
)


@pytest.mark.parametrize("name", EXACT_ON_PLANES)
def test_a_plane_is_reproduced_from_its_isolines(name):
    """Every method that reproduces linear polynomials reproduces it, also outside the points."""
    problem = TerrainProblem(plane(), 20, 15.0)
    surface = methods((1, 2), 4, 3.0)[name](*problem.isolines, problem.land.points)
    assert_allclose(surface.heights, problem.truth, atol=1e-7)


def test_the_kernel_r_with_a_constant_does_not_reproduce_a_plane():
    """This shows that the test above can fail."""
    problem = TerrainProblem(plane(), 20, 15.0)
    surface = methods((1,), 4, 3.0)["RBF −r"](*problem.isolines, problem.land.points)
    assert np.abs(surface.heights - problem.truth).max() > 1


@pytest.mark.parametrize(
    ("name", "exact"), [("LS 1", False), ("LS 2", True), ("MLS 1", False), ("MLS 2", True)]
)
def test_only_degree_two_reproduces_a_paraboloid(name, exact):
    """The values are given at the points of the isolines."""
    points, _ = TerrainProblem(hills(), 20, 15.0).isolines
    queries = hills().points

    def height(x):
        return (x[:, 0] - 200) ** 2 / 300 + x[:, 0] * x[:, 1] / 500

    surface = methods((1, 2), 4, 3.0)[name](points, height(points), queries)
    assert (np.abs(surface.heights - height(queries)).max() < 1e-6) == exact


def test_collinear_neighbors_are_extended():
    """If the twelve nearest points are collinear, more are added, and a plane is reproduced."""
    along = np.arange(0.0, 100.0, 4.0)
    points = np.array([(x, y) for y in (0.0, 90.0) for x in along])
    heights = points @ [0.5, 2.0] + 7
    queries = np.array([[50.0, 3.0], [20.0, 80.0]])
    surface = terrain_methods.moving(1, 4, points, heights, queries)
    assert surface.neighbors == 48
    assert_allclose(surface.heights, queries @ [0.5, 2.0] + 7, atol=EXACT)


def test_guarded_weights_stay_below_the_bound():
    """The sum of |weights| never exceeds the bound, while it does for plain degree 2."""
    problem = TerrainProblem(hills(), 20, 15.0)
    tried = methods((), 4, 2.0)
    plain, guarded = (tried[n](*problem.isolines, problem.land.points) for n in ("MLS 2", GUARDED))
    assert guarded.amplification.max() <= 2
    safe = plain.amplification <= 2
    assert 0 < safe.sum() < safe.size
    assert_array_equal(guarded.heights[safe], plain.heights[safe])


def test_amplification_is_the_worst_case_effect_of_data_errors():
    """Errors of one metre with the worst signs change a height by the sum of the |weights|."""
    problem = TerrainProblem(hills(), 20, 15.0)
    points, heights = problem.isolines
    queries = problem.land.points[::97]
    weights = terrain_methods.local_weights(2, 24, points, queries)
    sizes = terrain_methods.amplification(weights)
    for k in range(len(queries)):
        worst = np.sign(weights[[k]].toarray()[0])
        moved = terrain_methods.moving(2, 4, points, heights + worst, queries[[k]]).heights
        still = terrain_methods.moving(2, 4, points, heights, queries[[k]]).heights
        assert moved - still == pytest.approx(sizes[k])


def test_flat_ground_has_neighbors_of_one_height_only():
    """On one isoline every degree returns its height; elsewhere few cells have a level's height."""
    problem = TerrainProblem(hills(), 20, 15.0)
    flat = on_one_isoline(problem, 12)
    heights = methods((), 4, 3.0)["MLS 1"](*problem.isolines, problem.land.points).heights
    assert 0 < flat.sum() < flat.size
    assert np.abs(phase(heights, 20))[flat].max() < EXACT
    assert np.mean(np.abs(phase(heights, 20))[~flat] < EXACT) < 0.1


def test_the_thin_plate_spline_agrees_with_scipy():
    """The difference from scipy.interpolate.RBFInterpolator is at the level of rounding."""
    problem = TerrainProblem(hills(), 10, 15.0)
    queries = problem.land.points
    ours = methods((), 4, 3.0)[THIN_PLATE](*problem.isolines, queries).heights
    theirs = terrain_methods.scipy_thin_plate(*problem.isolines, queries).heights
    assert np.abs(ours - theirs).max() < 1e-9 * np.ptp(problem.truth) * len(problem.isolines[0])


def test_linear_triangles_end_at_the_convex_hull():
    """Outside the convex hull of the points there are no values."""
    problem = TerrainProblem(hills(), 20, 15.0)
    surface = terrain_methods.triangles(*problem.isolines, problem.land.points)
    assert_array_equal(np.isnan(surface.heights), problem.outside)
    assert measured(problem, surface)["outside"] == NONE
    reference = LinearNDInterpolator(*problem.isolines)(problem.land.points)
    assert_array_equal(surface.heights, reference)


def test_landforms_of_known_hills_are_classified():
    """Both summits are tops, the bottom is a hollow, and halfway up there is a slope."""
    ground = hills()
    form = landforms(ground.height, 20)
    assert form[15, 10] == form[12, 30] == TOP
    assert form[20, 20] == HOLLOW
    assert form[15, 14] == SLOPE
    tops = np.unique(level_below(ground.height, 20)[form == TOP])
    assert tops.min() > 0


def test_tops_of_the_inverted_terrain_are_hollows():
    """Levels are at k·spacing + ½, so inverting about ½ m keeps the isolines."""
    height = terrain().height
    assert_array_equal(landforms(1 - height, 100), -landforms(height, 100))


@pytest.mark.parametrize("form", [TOP, HOLLOW])
def test_recovered_relief_is_one_for_the_truth_and_zero_for_a_terrace(form):
    """It is linear between the height of the last isoline and the true height."""
    height = hills().height
    truth = height[landforms(height, 20) == form]
    terrace = level_below(truth, 20) + (20 if form == HOLLOW else 0)
    assert relief_told(truth, truth, 20, form) == pytest.approx(1)
    assert relief_told(terrace, truth, 20, form) == pytest.approx(0)
    assert relief_told((truth + terrace) / 2, truth, 20, form) == pytest.approx(0.5)


def test_the_terrain_stays_within_its_bands():
    """The true height lies between its two isolines; shifted by one spacing it never does."""
    height = terrain().height
    assert not beyond_band(height, height, 100).any()
    assert beyond_band(height + 100, height, 100).all()
    assert np.abs(phase(height, 100)).max() <= 0.5


def test_a_window_contains_the_nodes_of_its_square():
    ground = hills()
    cut = windowed(ground, (95.0, 60.0, 50.0))
    assert cut.x.tolist() == [100, 110, 120, 130, 140]
    assert cut.y.tolist() == [60, 72, 84, 96, 108]
    assert cut.height[2, 1] == ground.height[7, 11]


def test_a_study_of_a_plane_has_no_errors():
    """The errors of the exact methods vanish on the map and in the window, inside and outside."""
    result = study(SMALL, plane())
    for name in ("ls", "mls_1", "mls_2", "thin_plate"):
        assert result.facts[f"{name}_largest"] < 1e-7
        assert result.facts[f"{name}_outside"] < 1e-7
        assert result.facts[f"window_{name}_finest"] < 1e-7
        assert result.facts[f"{name}_top_told_percent"] == pytest.approx(100)
    assert result.facts["cone_largest"] > 1


@pytest.mark.slow
def test_the_facts_agree_with_the_elevation_file(quick):
    """Extremes, mean and extent are those of every fifth row and column of the model."""
    ground = part(terrain(), np.s_[::5], np.s_[::5])
    assert quick.facts["highest"] == ground.height.max()
    assert quick.facts["lowest"] == ground.height.min()
    assert quick.facts["mean_height"] == pytest.approx(ground.height.mean())
    assert (
        quick.facts["cells"] == quick.facts["rows"] * quick.facts["columns"] == ground.height.size
    )
    assert abs(Params().every * terrain().height.max() - quick.facts["published_summit"]) <= 2


@pytest.mark.slow
def test_the_ranking_of_methods_holds_on_a_coarser_model(quick):
    """The thin plate has a smaller error than MLS, guarded MLS than plain, and all than LS."""
    inside = {name: quick.facts[f"{name}_inside"] for name in ("ls", "mls_1", "mls_2")}
    thin_plate, guarded = quick.facts["thin_plate_inside"], quick.facts["mls_guarded_inside"]
    assert thin_plate < guarded < min(inside["mls_1"], inside["mls_2"])
    assert max(inside["mls_1"], inside["mls_2"]) < inside["ls"]
    assert quick.facts["mls_1_terrace_percent"] > 2 * quick.facts["truth_terrace_percent"]
    assert quick.facts["unsafe_share_percent"] > quick.facts["unsafe_percent"]
    assert quick.facts["difference_from_scipy"] < 1e-5


@pytest.mark.slow
def test_maps_have_north_at_the_top(quick):
    """Row 0 is the south and is drawn at the bottom; the first column is in the west."""
    x, y = quick.arrays["x"], quick.arrays["y"]
    for plot in experiments.get("terrain").plots.values():
        for axes in plot(quick).axes:
            for image in axes.images:
                west, east, south, north = image.get_extent()
                assert image.origin == "lower"
                assert west < east <= x[-1] + x[1]
                assert south < north <= y[-1] + y[1]
                assert not axes.xaxis_inverted()
                assert not axes.yaxis_inverted()


@pytest.mark.slow
def test_the_terrain_is_drawn_at_its_coordinates(quick):
    """In the third map the highest cell has its true coordinates."""
    land_map = experiments.get("terrain").plots["terrain"](quick).axes[2].images[0]
    row, column = np.unravel_index(quick.arrays["truth"].argmax(), quick.arrays["truth"].shape)
    west, east, south, north = land_map.get_extent()
    rows, columns = land_map.get_array().shape[:2]
    assert west + (column + 0.5) * (east - west) / columns == pytest.approx(
        quick.arrays["x"][column]
    )
    assert south + (row + 0.5) * (north - south) / rows == pytest.approx(quick.arrays["y"][row])


def test_a_window_outside_the_map_is_refused():
    """The message contains its lengths."""
    refused = partial(windowed, hills(), (9000.0, 0.0, 100.0))
    with pytest.raises(ValueError, match=r"parameter window must hold 3 or more rows .*9000"):
        refused()
