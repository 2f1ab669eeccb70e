"""Claims of the chapter on surfaces, compared with known values."""

from dataclasses import replace

import numpy as np
import pytest

from fieldrecon.solids.shapes import Ball
from fieldreport.experiments.surfaces import surface_reconstruction as experiment


def test_synthetic_scans_have_the_named_defects():
    """Noise moves points, shadows and holes remove points, and outliers lie apart."""
    scans = experiment.damaged(1000, 0.3, seed=1)
    off = {name: np.abs(scan.body(scan.points)) for name, scan in scans.items()}
    assert off["exact points"].max() < 1e-9
    assert off["with noise"].max() > 0.02
    assert 0.6 * 1000 < len(scans["in shadow"].points) < 0.95 * 1000
    assert len(scans["with holes"].points) < 950
    assert 1 < (off["with outliers and duplicates"] > 0.1).sum() <= 20
    assert scans["two bodies"].body([0.0, 0.0, 0.9]) == pytest.approx(0.4)


def test_the_ellipsoid_has_exact_points_and_normals():
    """Points satisfy x² + (y / 0.8)² + (z / 0.6)² = 1, and normals are parallel to its gradient."""
    points, normals = experiment.ellipsoid(50)
    half = np.array([1.0, 0.8, 0.6])
    assert ((points / half) ** 2).sum(axis=1) == pytest.approx(np.ones(50))
    assert np.cross(points / half**2, normals) == pytest.approx(np.zeros((50, 3)), abs=1e-12)


def test_a_difference_without_isolines_is_refused_by_its_name():
    """The terrain of a few nodes may lie between two isolines."""
    with pytest.raises(ValueError, match=r"parameter isolines must be .* of 16 nodes .* got 1000"):
        experiment.isolines(replace(experiment.QUICK, isolines=1000))


@pytest.mark.slow
def test_the_table_measures_distances_in_spacings():
    """A ball is reconstructed with errors far below one spacing, in one part."""
    points = experiment.ellipsoid(400)[0] / [1.0, 0.8, 0.6]
    row = experiment.reconstructed(experiment.SyntheticScan(points, Ball(1.0))).row
    named = dict(zip(experiment.COLUMNS[1:], row, strict=True))
    assert named["rms"] < named["largest"] < 0.05
    assert (named["points"], named["left out"], named["parts"], named["errors"]) == (400, 0, 1, 0)
    other = experiment.reconstructed(experiment.SyntheticScan(points, Ball(1.1))).row
    assert other[3] == pytest.approx(0.1 / np.sqrt(4 * np.pi / 400), rel=0.1)
