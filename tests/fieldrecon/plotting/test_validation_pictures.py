"""Pictures of a validation: distances, held-out values and the variogram."""

from dataclasses import replace

import numpy as np
import pytest

from fieldrecon.pipelines.validation import Validation
from fieldrecon.pipelines.variograms import variogram
from fieldrecon.plotting.style import figure
from fieldrecon.plotting.validation_pictures import plot_distances, plot_held_out, plot_variogram


def test_pictures_of_distances_name_their_curves_and_show_all_of_them():
    """Three distributions with a legend, and a variogram up to its largest distance."""
    points = np.random.default_rng(0).random((60, 2))
    validation = Validation(None, *np.random.default_rng(1).random((3, 9)), *np.zeros((2, 9)))
    (axes,) = plot_distances(validation).axes
    assert axes.get_xlabel() == "distance from the nearest sample"
    assert axes.get_ylabel() == "fraction of points"
    names = [text.get_text() for text in axes.get_legend().get_texts()]
    assert names == ["targets", "held-out samples", "leave-one-out"]
    found = variogram(points, points[:, 0])
    on_globe = plot_distances(replace(validation, unit=" degrees")).axes[0]
    assert on_globe.get_xlabel() == "distance from the nearest sample, degrees"
    (axes,) = plot_variogram(found, "f").axes
    assert axes.get_xlim() == (0.0, found.distances.max())
    lines = {line.get_label(): line.get_xydata() for line in axes.lines}
    np.testing.assert_array_equal(lines["samples"].T, [found.distances, found.values])
    h, model = lines["exponential model"].T
    assert (h[0], h[-1]) == (0.0, found.distances.max())
    np.testing.assert_allclose(model, found(h))
    assert (lines["nugget"][:, 1] == found.nugget).all()
    assert ("range" in lines) == found.levels_off


def test_held_out_values_are_drawn_above_their_predictions():
    """With the line where both are equal, over all values, thinner than a curve."""
    values, residuals = np.random.default_rng(1).standard_normal((2, 9))
    some = np.ones(9)
    (axes,) = plot_held_out(Validation(None, some, some, some, values, residuals), "f").axes
    points, equal = axes.lines
    assert np.array_equal(points.get_xydata(), np.stack([values - residuals, values], axis=1))
    assert (points.get_linestyle(), points.get_marker()) == ("None", ".")
    assert np.array_equal(equal.get_xydata(), [[min(values)] * 2, [max(values)] * 2])
    with figure(3.0) as (_, other):
        (curve,) = other.plot([0, 1])
    assert equal.get_linewidth() < curve.get_linewidth()
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("f, predicted", "f, held out")


def test_a_curve_of_distances_is_their_distribution_function():
    """At each distance it has the fraction of those that are not larger."""
    some = np.random.default_rng(1).random((3, 9))
    validation = Validation(None, *some, *np.zeros((2, 9)))
    curves = plot_distances(validation).axes[0].lines
    wanted = (validation.targets, validation.held_out, validation.leave_one_out)
    for curve, distances in zip(curves, wanted, strict=True):
        x, fraction = curve.get_xydata().T
        np.testing.assert_array_equal(x, np.sort(distances))
        np.testing.assert_allclose(fraction, [(distances <= t).mean() for t in x])
    assert len({curve.get_linestyle() for curve in curves}) == 3


@pytest.mark.parametrize("unit_of_length", [1e-3, 1.0, 1e3])
@pytest.mark.parametrize(("spread", "scale"), [(29.5, "linear"), (30.5, "log")])
def test_distances_of_different_sizes_are_drawn_by_their_logarithms(spread, scale, unit_of_length):
    """Those that are zero have none."""
    held_out = unit_of_length * np.array([0.0, 1.0, 2.0, spread])
    validation = Validation(None, held_out, held_out, held_out, *np.zeros((2, 4)))
    assert plot_distances(validation).axes[0].get_xscale() == scale


def test_lines_of_a_variogram_can_be_told_from_its_model():
    """Nugget and range are thinner, and their dashes differ; values begin at zero."""
    points = np.random.default_rng(0).random((400, 2))
    values = np.sin(30 * points).sum(axis=1)
    (axes,) = plot_variogram(variogram(points, values), "f").axes
    lines = {line.get_label(): line for line in axes.lines}
    assert "range" in lines
    model = lines["exponential model"]
    for name in ("nugget", "range"):
        assert lines[name].get_linewidth() < model.get_linewidth()
    styles = {lines[name].get_linestyle() for name in ("exponential model", "nugget", "range")}
    assert len(styles) == 3
    assert axes.get_ylim()[0] == 0
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("distance", "semivariance of f")
    assert len(model.get_xdata()) >= 100
