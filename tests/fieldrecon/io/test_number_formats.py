"""Formats of numbers: which lines may be read at once."""

from fieldrecon.io.number_formats import NumberFormat


def test_a_decimal_point_is_no_decimal_comma():
    """Where the comma is the sign, lines with a point are read cell by cell, and refused there."""
    assert NumberFormat(",").plain(["1,5;2", "3;4d2"]) == ["1.5;2", "3;4e2"]
    assert NumberFormat(",").plain(["1,5;2", "1.5;2"]) is None
    assert NumberFormat().plain(["1.5;2D3"]) == ["1.5;2e3"]
