"""The surface where samples of a scalar have a given value, by the command's function."""

import numpy as np
import pandas as pd
import pytest
from scipy.spatial import cKDTree

import fieldrecon as fr
from fieldrecon.pipelines import surface
from fieldrecon.surfaces.level_sets import LevelSet

POINTS = 2 * fr.datasets.halton(1500, 3) - 1
DISTANCE = np.linalg.norm(POINTS, axis=1) - 0.6


def table(points, values):
    return pd.DataFrame(np.column_stack([points, values]), columns=["X", "Y", "Z", "dist"])


@pytest.mark.slow
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_ball_of_signed_distances_far_from_the_origin(sign):
    """Both signs give the same body, in coordinates of millions."""
    offset = np.array([7.7e6, 5e5, 300.0])
    scan = surface(table(100 * POINTS + offset, 100 * sign * DISTANCE), level=0.0)
    assert scan.sound(open_allowed=False)
    np.testing.assert_allclose(scan.mesh.volume, 4 / 3 * np.pi * 60**3, rtol=0.03)
    radius = np.linalg.norm(scan.points - offset, axis=1)
    np.testing.assert_allclose(radius, 60, rtol=0.02)
    side = "less" if sign > 0 else "greater"
    assert f"The body is where the value is {side} than 0" in " ".join(scan.warnings)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_box_has_a_margin_of_one_spacing(sign):
    """On a lattice the spacing is its step; the body does not depend on the sign of the scalar."""
    step, low = 0.25, np.array([2.0, 0.0, -3.0])
    lattice = np.stack(np.meshgrid(*[np.arange(7.0)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    points = low + step * lattice
    distance = np.linalg.norm(points - points.mean(axis=0), axis=1)
    body = LevelSet(points, sign * distance, sign * 0.6)
    np.testing.assert_allclose(body.box, [low - step, low + 7 * step], atol=1e-12)
    np.testing.assert_array_equal(body(points) > 0, distance < 0.6)
    np.testing.assert_array_equal(body.points, LevelSet(points, -distance, -0.6).points)


@pytest.mark.parametrize("seed", range(1, 7))
def test_the_body_is_where_fewer_of_the_outermost_samples_are(seed):
    """These are all samples on the sides of the box, here of a lattice with random values."""
    lattice = np.stack(np.meshgrid(*[np.arange(5.0)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    values = np.random.default_rng(seed).standard_normal(len(lattice))
    above = values > 0.1
    outermost = ((lattice == 0) | (lattice == 4)).any(axis=1)
    inside = above if above[outermost].mean() < 0.5 else ~above
    np.testing.assert_array_equal(LevelSet(lattice, values, 0.1)(lattice) > 0, inside)


def test_outermost_samples_of_the_level_itself_are_not_in_the_body():
    """Here most have the level, others less, and more is found inside only."""
    lattice = np.stack(np.meshgrid(*[np.arange(5.0)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    outermost = ((lattice == 0) | (lattice == 4)).any(axis=1)
    values = np.where(outermost, np.where(lattice.sum(axis=1) % 3 == 0, -1.0, 0.0), 1.0)
    assert (values[outermost] == 0).mean() > 0.6
    for sign in (1, -1):
        body = LevelSet(lattice, sign * values, 0.0)
        np.testing.assert_array_equal(body(lattice) > 0.5, ~outermost)


@pytest.mark.parametrize(("shrunk", "sign"), [(0.9, 1.0), (0.95, 1.0), (0.97, -1.0)])
def test_outermost_are_the_samples_within_a_fiftieth_of_the_sides_of_the_box(shrunk, sign):
    """There are more of value one than of zero, but these lie on the sides, and those may not."""
    sides, others = (
        np.stack(np.meshgrid(*[np.linspace(-1, 1, k)] * 3), axis=-1).reshape(-1, 3) for k in (3, 4)
    )
    sides, others = (x[abs(x).max(axis=1) == 1] for x in (sides, others))
    points = 50.0 + 10 * np.concatenate([sides, shrunk * others])
    values = np.repeat([0.0, 1.0], [26, 56])
    assert LevelSet(points, values, 0.5).sign == sign
    assert LevelSet(points, -values, -0.5).sign == -sign


def test_the_level_of_a_linear_scalar_is_crossed_in_its_plane():
    """Between neighbouring samples it is found by linear interpolation, which is exact."""
    slope = np.array([1.0, 2.0, -3.0])
    body = LevelSet(POINTS, POINTS @ slope, 0.3)
    assert len(body.points) > 50
    np.testing.assert_allclose(body.points @ slope, 0.3, atol=1e-13)
    nearest = cKDTree(POINTS).query(POINTS, 2)[0][:, 1]
    assert body.spacing == pytest.approx(np.median(nearest))
    far = cKDTree(POINTS).query(body.points)[0]
    assert far.max() < 2 * body.spacing


def test_samples_that_have_the_level_itself_lie_on_the_surface():
    """So neither the least nor the greatest value is a level: one side would be empty."""
    lattice = np.stack(np.meshgrid(*[np.arange(5.0)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    x = lattice[:, 0]
    for level in (2.0, 3.0):
        body = LevelSet(lattice, x, level)
        np.testing.assert_allclose(body.points[:, 0], level, atol=1e-12)
        assert len(body.points) > 10
    for level in (0.0, 4.0):
        words = f"level must lie between the values, 0 to 4; got {level:g}"
        with pytest.raises(ValueError, match=words):
            LevelSet(lattice, x, level)


@pytest.mark.slow
def test_another_level_is_another_surface():
    scan = surface(table(POINTS, DISTANCE), level=0.2, value="dist")
    np.testing.assert_allclose(np.linalg.norm(scan.points, axis=1), 0.8, rtol=0.02)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"level": 5.0}, r"level must lie between the values, -0\.5.* to 1\.\d+; got 5"),
        ({"level": 0.0, "smoothing": 1.0}, "level is for samples of a scalar"),
        ({"value": "dist"}, "give level as well"),
        ({"level": 0.0, "value": "grade"}, "no column 'grade'; it has X, Y, Z, dist"),
    ],
)
def test_what_has_no_surface_is_refused(options, words):
    with pytest.raises(ValueError, match=words):
        surface(table(POINTS, DISTANCE), **options)
