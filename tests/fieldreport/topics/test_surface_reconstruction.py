"""The claims of the chapter on surfaces, compared with known values."""

import numpy as np
import pytest

from fieldrecon.solids.shapes import Ball
from fieldreport.experiments.surfaces import surface_reconstruction as experiment


def test_scans_are_what_their_names_say():
    """Noise moves points off the body, shadows and holes take some away, strays lie apart."""
    scans = experiment.damaged(1000, 0.3, seed=1)
    off = {name: np.abs(scan.body(scan.points)) for name, scan in scans.items()}
    assert off["as drawn"].max() < 1e-9
    assert off["with noise"].max() > 0.02
    assert 0.6 * 1000 < len(scans["in shadow"].points) < 0.95 * 1000
    assert len(scans["with holes"].points) < 950
    assert 1 < (off["with strays and copies"] > 0.1).sum() <= 20
    assert scans["two bodies"].body([0.0, 0.0, 0.9]) == pytest.approx(0.4)


def test_the_flattened_ball_has_its_points_and_normals():
    """On x^2 + (y / 0.8)^2 + (z / 0.6)^2 = 1, with the gradient of that for a normal."""
    points, normals = experiment.spheroid(50)
    half = np.array([1.0, 0.8, 0.6])
    assert ((points / half) ** 2).sum(axis=1) == pytest.approx(np.ones(50))
    assert np.cross(points / half**2, normals) == pytest.approx(np.zeros((50, 3)), abs=1e-12)


def test_the_table_measures_distances_in_spacings():
    """Of a ball rebuilt from its points: far below one, without an error, and in one part."""
    points = experiment.spheroid(400)[0] / [1.0, 0.8, 0.6]
    row = experiment.reconstructed(experiment.SyntheticScan(points, Ball(1.0))).row
    named = dict(zip(experiment.COLUMNS[1:], row, strict=True))
    assert named["rms"] < named["largest"] < 0.05
    assert (named["points"], named["left out"], named["parts"], named["errors"]) == (400, 0, 1, 0)
    other = experiment.reconstructed(experiment.SyntheticScan(points, Ball(1.1))).row
    assert other[3] == pytest.approx(0.1 / np.sqrt(4 * np.pi / 400), rel=0.1)
