"""Pictures of a validation: distances, held-out values and the variogram."""

from dataclasses import replace

import numpy as np

from fieldrecon.pipelines.validation import Validation
from fieldrecon.pipelines.variograms import variogram
from fieldrecon.plotting.style import figure
from fieldrecon.plotting.validation_pictures import plot_distances, plot_held_out, plot_variogram


def test_held_out_values_are_drawn_against_the_predicted_ones():
    """Beside the diagonal, on which they are equal."""
    values, residuals = np.random.default_rng(1).random((2, 9))
    validation = Validation(None, *np.zeros((3, 9)), values, residuals)
    dots, diagonal = plot_held_out(validation, "f").axes[0].lines
    np.testing.assert_allclose(dots.get_xdata() + residuals, dots.get_ydata())
    np.testing.assert_array_equal(dots.get_ydata(), values)
    ends = [values.min(), values.max()]
    assert diagonal.get_xydata().tolist() == [[end, end] for end in ends]


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
