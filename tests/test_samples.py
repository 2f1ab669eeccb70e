"""Samples are read from the tables people have, and a bad row is told by its line."""

import numpy as np
import pytest

from fieldrecon.samples import read_samples


@pytest.fixture
def table(tmp_path):
    """Write a text to a file and return its path."""

    def write(text, encoding="utf-8"):
        path = tmp_path / "points.csv"
        path.write_bytes(text.encode(encoding))
        return path

    return write


@pytest.mark.parametrize(
    "text",
    [
        "x,y,value\n0,1,2\n3,4,5\n",
        "\ufeffx;y;value\r\n0;1;2\r\n3;4;5\r\n",
        "# made by hand\nX\tY\tValue\n\n0\t1\t2\n# half-way\n3\t4\t5",
        'Northing,Easting [m],"Depth (m, below sea)"\n1,0,2\n4,3,5\n',
        "lat,lon,temperature\n1,0,2\n4,3,5\n",
        "y,x,id,z\n1,0,17,2\n4,3,18,5\n",
    ],
)
def test_columns_are_found_by_usual_names(table, text):
    """Whatever separates the cells, in any order, with units, comments or a byte-order mark."""
    samples = read_samples(table(text))
    assert samples.points.tolist() == [[0, 1], [3, 4]]
    assert samples.values.tolist() == [2, 5]
    assert samples.in_degrees == ("lat" in text)


def test_columns_are_chosen_by_name(table):
    """Named columns win over usual ones."""
    path = table("x,y,z,a,b\n0,1,2,3,4\n5,6,7,8,9\n")
    samples = read_samples(path, x="a", value="b")
    assert samples.names == ("a", "y", "b")
    assert samples.points.tolist() == [[3, 1], [8, 6]]
    assert samples.values.tolist() == [4, 9]


def test_repeated_points_bear_the_mean(table):
    """A point given several times stands once, where it first stood, with the mean value."""
    samples = read_samples(table("x,y,z\n5,5,1\n0,0,2\n5,5,4\n0,1,3\n5,5,4\n"))
    assert samples.points.tolist() == [[5, 5], [0, 0], [0, 1]]
    assert samples.values.tolist() == [3, 2, 3]
    assert samples.merged == 2


@pytest.mark.parametrize(
    ("text", "columns", "words"),
    [
        (
            "x,y,z\n0,0,1\n\n1,0,n/a\n",
            {},
            r"points.csv, line 4: z must be a finite number; .*'n/a'",
        ),
        ("x,y,z\n0,0,1\n1,nan,2\n", {}, r"line 3: y must be a finite number; got 'nan'"),
        ("x,y,z\n0,0,1\n1,,2\n", {}, r"line 3: y must be a finite number; got ''"),
        ("# a\nx,y,z\n0,0,1\n1,2\n", {}, r"line 4: the header has 3 cells and this row 2"),
        ("x,y,z\n0,5,0,1,0\n", {}, r"line 2: the header has 3 cells and this row 5"),
        ("a,b,c\n0,0,1\n", {}, r"not clear which column of .* name it with --x: a, b, c"),
        ("x,y,a,b\n0,0,1,1\n", {}, r"not clear which column of .* --value: x, y, a, b"),
        ("x,y,z\n0,0,1\n", {"value": "w"}, r"has no column 'w'; it has x, y, z"),
        ("x,y,z\n0,0,1\n", {"x": "y"}, r"three different columns"),
        ("x,y,z\n", {}, r"has no rows below its header"),
        ("", {}, r"is empty; a header such as x,y,value and rows were expected"),
    ],
)
def test_a_bad_table_is_told_in_words(table, text, columns, words):
    """With the line of the row, or the columns that there are."""
    with pytest.raises(ValueError, match=words):
        read_samples(table(text), **columns)


def test_a_table_in_another_encoding_is_told(table):
    """A file that is not UTF-8 is named as such."""
    with pytest.raises(ValueError, match="is not a text in UTF-8"):
        read_samples(table("x,y,Höhe\n0,0,1\n", encoding="latin-1"))


def test_numbers_keep_their_digits(table):
    """Seventeen digits and large offsets are read as they are written."""
    samples = read_samples(table("x,y,z\n4500000.1,1e-300,0.1234567890123456\n"))
    assert samples.points.tolist() == [[4500000.1, 1e-300]]
    assert samples.values == np.array([0.1234567890123456])
