"""The surface where samples of a scalar have a given value, by the command's function."""

import numpy as np
import pandas as pd
import pytest

import fieldrecon as fr
from fieldrecon.pipelines import surface

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
