"""Formats of numbers: what a comma means, and which lines may be read at once."""

import math

import pytest

from fieldrecon.io.number_formats import NumberFormat


def test_a_decimal_point_is_no_decimal_comma():
    """Where the comma is the sign, lines with a point are read cell by cell, and refused there."""
    assert NumberFormat(",").plain(["1,5;2", "3;4d2"]) == ["1.5;2", "3;4e2"]
    assert NumberFormat(",").plain(["1,5;2", "1.5;2"]) is None
    assert NumberFormat().plain(["1.5;2D3"]) == ["1.5;2e3"]


@pytest.mark.parametrize(
    ("cells", "decimal"),
    [
        (["0,5"] * 3 + ["1,234"] + ["1.5"] * 2, ","),
        (["0,5"] * 2 + ["1,234"] + ["1.5"] * 3, "."),
        (["0,5"] * 3 + ["1,234,567"] * 2, ","),
        (["0,5"] * 2 + ["1,234,567"] * 3, "."),
        (["0,5"] * 4 + ["1,234,567"] * 2 + ["1.5"], ","),
        (["0,5"] * 4 + ["1,234,567"] * 3 + ["1.5"] * 2, "."),
        (["0,5", "1.5", "1.5"], ","),
        (["1.5"], None),
    ],
)
def test_the_majority_of_the_cells_decides(cells, decimal):
    """A point counts only where a comma may be one between thousands."""
    assert NumberFormat.of(cells).decimal == decimal


def test_a_comma_groups_digits_only_where_it_is_known_to():
    """Other marks between groups are never decimal signs."""
    assert math.isnan(NumberFormat().parse("1,234"))
    assert NumberFormat(".").parse("1,234") == 1234
    assert NumberFormat(",").parse("1,234") == 1.234
    for known in (NumberFormat(), NumberFormat("."), NumberFormat(",")):
        assert known.parse("1'234") == known.parse("1\u00a0234") == 1234
