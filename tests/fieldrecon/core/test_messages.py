"""Error messages: the point at fault."""

from fieldrecon._core.validation import MAX_SHOWN, format_point


def test_a_point_of_few_variables_is_shown_whole():
    """Of a longer one the number of coordinates is given."""
    point = [0.25 * k for k in range(MAX_SHOWN + 1)]
    assert [float(c) for c in format_point(point[:-1]).split(", ")] == point[:-1]
    assert format_point(point).endswith(f", … of {MAX_SHOWN + 1} coordinates")
