"""Tables of samples: formats and headers in use are read, and bad rows are reported by line."""

import csv
import sys

import numpy as np
import pyarrow as pa
import pyarrow.parquet
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrecon.datasets.synthetic import uniform
from fieldrecon.io import tables as _text_tables
from fieldrecon.io.text_files import open_text
from fieldrecon.pipelines.missing_values import as_missing, suspects
from fieldrecon.pipelines.samples import Samples, read_samples, refuse_flat


@pytest.fixture
def table(tmp_path):
    """A function that writes a text to a file and returns its path."""

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
        'x,y,name,value\n0,1,"a, b",2\n3,4,c,5\n',
        'x, y, name, value\n0, 1, "a, b", 2\n3, "4", c, 5\n',
        "0 1 2\n3   4\t5\n",
        "  0.0e0   1   2  \r\n\r\n3 4 5",
        "# LAS points\n0,1,2,77\n3,4,5,78\n",
        "x y z\n0 1 2\n3 4 5\n",
    ],
)
def test_columns_are_found_by_usual_names(table, text):
    """Separators, order of columns, units, comments and a missing header do not matter."""
    samples = read_samples(table(text))
    assert samples.points.tolist() == [[0, 1], [3, 4]]
    assert samples.values.tolist() == [2, 5]
    assert samples.bad == ()


def test_columns_are_chosen_by_name(table):
    """Requested columns take precedence over the usual names."""
    path = table("x,y,z,a,b\n0,1,2,3,4\n5,6,7,8,9\n")
    samples = read_samples(path, x="a", value="b")
    assert samples.names == ("a", "y", "b")
    assert samples.points.tolist() == [[3, 1], [8, 6]]
    assert samples.values.tolist() == [4, 9]


def test_points_in_space_need_the_option_z(table):
    """Without --z a column z that was not read is reported."""
    path = table("x,y,z,value\n0,1,2,3\n4,5,6,7\n")
    samples = read_samples(path, z="z")
    assert samples.names == ("x", "y", "z", "value")
    assert samples.points.tolist() == [[0, 1, 2], [4, 5, 6]]
    assert samples.warnings == []
    assert "The column z was not read" in " ".join(read_samples(path).warnings)
    assert read_samples(table("x,y,z,i\n0,1,2,3\n"), z="z").values.tolist() == [3]


def test_repeated_points_are_merged_to_their_mean_value(table):
    """The merged point stays at its first position in the order of rows."""
    samples = read_samples(table("x,y,z\n5,5,1\n0,0,2\n5,5,4\n0,1,3\n5,5,4\n-0,0,2\n"))
    assert samples.points.tolist() == [[5, 5], [0, 0], [0, 1]]
    assert samples.values.tolist() == [3, 2, 3]
    assert (samples.merged, samples.conflicts, samples.spread) == (3, 1, 3)
    assert samples.warnings == [
        "3 rows repeat a point; its value is the mean of the values given there, which differ at 1 "
        "point, by up to 3."
    ]
    equal = read_samples(table("x,y,z\n5,5,0.1\n5,5,0.1\n5,5,0.1\n0,0,2\n"))
    assert equal.values.tolist() == [0.1, 2]
    assert equal.warnings[0].endswith("which are the same.")
    assert (equal.merged, equal.conflicts, equal.spread) == (2, 0, 0)
    distinct = read_samples(table("x,y,z\n5,5,1\n0,0,2\n"))
    assert (distinct.merged, distinct.conflicts, distinct.spread) == (0, 0, 0)


def test_equivalent_longitudes_are_the_same_point(table):
    """Longitudes differ by multiples of 360°; at a pole every longitude is the same point."""
    rows = "lon,lat,t\n190,10,1\n-170,10,3\n370.1,0,5\n10.1,0,5\n17,90,2\n-60,90,4\n180,0,1\n"
    samples = read_samples(table(rows), lonlat=True)
    assert samples.points.tolist() == [[-170, 10], [10.1, 0], [0, 90], [-180, 0]]
    assert samples.values.tolist() == [2, 5, 3, 1]
    assert samples.lonlat
    assert all("degrees" not in remark for remark in samples.warnings)


@pytest.mark.parametrize(
    ("header", "size", "words"),
    [
        (
            "lon,lat,t",
            1e6,
            "look like degrees but are taken as lengths of one unit: add the option lonlat",
        ),
        ("x,y,t", 80, "all within ±180 and ±90, are degrees, add the option lonlat"),
        ("x,y,t", 5.5, "all within ±180 and ±90, are degrees, add the option lonlat"),
        ("x,y,t", 5, ""),
        ("x,y,t", 1, ""),
        ("x,y,t", 200, ""),
        ("east,north,t", 80, ""),
    ],
)
def test_coordinates_that_look_like_degrees_are_reported(table, header, size, words):
    """Degrees are recognized by the names of the columns or by the range of the numbers."""
    warnings = read_samples(table(f"{header}\n0,0,1\n{size},{size},2\n0,{size},2\n")).warnings
    assert words in " ".join(warnings)
    assert bool(warnings) == bool(words)


@pytest.mark.parametrize(
    ("x", "y", "named"),
    [(180, 90, True), (-180, -90, True), (180.5, 90, False), (180, 90.5, False), (0, -90.5, False)],
)
def test_numbers_may_be_degrees_up_to_the_poles_and_the_date_line(table, x, y, named):
    warnings = read_samples(table(f"x,y,t\n0,0,1\n{x},{y},2\n0,9,2\n")).warnings
    assert any("are degrees, add the option lonlat" in words for words in warnings) == named


@pytest.mark.parametrize(
    ("row", "reason"),
    [
        ("1,0,n/a", "z must be a finite number; got 'n/a'"),
        ("1,nan,2", "y must be a finite number; got 'nan'"),
        ("1,inf,2", "y must be a finite number; got 'inf'"),
        ("1,,2", "y must be a finite number; got ''"),
        ("1_000,1,2", "x must be a finite number; got '1_000'"),
        ("1e999,1,2", "x must be a finite number; got '1e999'"),
        ("1,2", "the header has 3 cells and this row 2"),
        ("0,5,0,1,0", "the header has 3 cells and this row 5"),
        ('"1,1,2', "the header has 3 cells and this row 1"),
        ("\x001,1,2", "x must be a finite number; got"),
        ("   ,  ,", "x must be a finite number; got ''"),
    ],
)
def test_bad_rows_are_skipped_and_reported_by_line(table, row, reason):
    """With strict=True, or if every row is bad, the first bad row raises an error."""
    path = table(f"# a\nx,y,z\n0,0,1\n\n{row}\n2,2,3\n")
    samples = read_samples(path)
    assert samples.points.tolist() == [[0, 0], [2, 2]]
    assert [bad.line for bad in samples.bad] == [5]
    assert reason in samples.bad[0].reason
    assert samples.warnings[0].startswith("1 row skipped, by line: 5: ")
    with pytest.raises(ValueError, match=r"points\.csv, line 5: "):
        read_samples(path, strict=True)
    with pytest.raises(ValueError, match=r"points\.csv, line 2: "):
        read_samples(table(f"x,y,z\n{row}\n"))


def test_a_quoted_separator_does_not_split_a_cell(table):
    """Such a row may have as many commas as the header but one cell less."""
    samples = read_samples(table('note,more,x,y,value\n"a,b",1,2,3\nc,d,4,5,6\n'))
    assert samples.points.tolist() == [[4, 5]]
    assert [(bad.line, bad.reason) for bad in samples.bad] == [
        (2, "the header has 5 cells and this row 4")
    ]


def test_latitudes_beyond_the_poles_are_bad_rows(table):
    """This holds only with lonlat=True."""
    path = table("lon,lat,t\n0,0,1\n10,95,1\n")
    assert read_samples(path).bad == ()
    assert read_samples(path, lonlat=True).bad == ((3, "lat must lie within ±90; got 95", 1),)
    metres = table("lon,lat,t\n0,0,1\n1000,9,1\n10,2000,1\n")
    with pytest.raises(
        ValueError, match=r"most rows of .* are not degrees .* line 3: lon must lie wi"
    ):
        read_samples(metres, lonlat=True)


def test_points_on_the_globe_are_distinguished_to_a_tenth_of_a_millimetre(table):
    """That is a billionth of a degree; what rounding makes of 360 - 349.9 is less.

    Points nearer than half of it are one.
    """
    path = table("lon,lat,t\n10.1,0,1\n10.100000001,0,2\n-349.9,0,3\n10.1000000004,0,2\n")
    samples = read_samples(path, lonlat=True)
    assert samples.points.tolist() == [[10.1, 0], [10.100000001, 0]]
    assert samples.values.tolist() == pytest.approx([2, 2])


def test_degrees_reach_to_the_poles_and_once_around_the_earth(table):
    """Longitudes of both conventions are read: to 180 degrees, and to 360."""
    rows = ["360,90", "-360,-90", "360.5,0", "-360.5,0", "0,90.5", "0,-90.5", "1,2", "3,4"]
    path = table("lon,lat,t\n" + "".join(f"{row},1\n" for row in rows))
    samples = read_samples(path, lonlat=True)
    assert [row.line for row in samples.bad] == [4, 5, 6, 7]
    assert len(samples.points) == 4


def test_many_bad_rows_are_counted(table):
    """The warning shows the first five; `bad` contains all of them."""
    samples = read_samples(table("x,y,z\n0,0,1\n" + "a,b,c\n" * 9))
    assert [bad.line for bad in samples.bad] == [*range(3, 12)]
    assert "9 rows skipped" in samples.warnings[0]
    assert samples.warnings[0].endswith("; and 4 more.")
    five = read_samples(table("x,y,z\n0,0,1\n" + "a,b,c\n" * 5)).warnings[0]
    assert "7: x must be" in five
    assert "more." not in five


@pytest.mark.parametrize(
    ("text", "columns", "words"),
    [
        ("a,b,c\n0,0,1\n", {}, r"not clear which column of .* name it by the option x: a, b, c"),
        (
            "x,y,a,b\n0,0,1,1\n",
            {},
            r"not clear which column of .* is value; name it by the option value: x, y, a, b",
        ),
        ("x,y,z\n0,0,1\n", {"value": "w"}, r"has no column 'w'; it has x, y, z"),
        ("x,y,z\n0,0,1\n", {"y": "z", "value": "z"}, r"must be different columns"),
        ("x,y,z\n0,0,1\n", {"z": "z", "lonlat": True}, r"z for points in space: not both"),
        ("x,y,z\n", {}, r"has no rows below its header"),
        ("x,y,z", {}, r"has no rows below its header"),
        ("x,y,z\n# end\n\n", {}, r"has no rows below its header"),
        ("", {}, r"is empty; a header such as x,y,value and rows were expected"),
        ("\n# nothing\n", {}, r"is empty"),
        ("LASF\0\0\1\2", {}, r"is not a text: it holds bytes of zero"),
    ],
)
def test_bad_tables_are_refused(table, text, columns, words):
    """The message lists the columns of the table."""
    with pytest.raises(ValueError, match=words):
        read_samples(table(text), **columns)


@pytest.mark.parametrize(
    "encoding", ["latin-1", "cp1252", "utf-8-sig", "utf-16", "utf-16-le", "utf-16-be", "utf-32"]
)
def test_tables_may_have_any_usual_encoding(table, encoding):
    """Names, numbers and the lines of bad rows are those of the text in UTF-8."""
    text = "x,y,Höhe [m²]\r\n0,1,2\r\n?,0,0\r\n3,4,5\r\n"
    samples = read_samples(table(text, encoding))
    assert samples.names == ("x", "y", "Höhe [m²]")
    assert samples.points.tolist() == [[0, 1], [3, 4]]
    assert [(row.line, row.row) for row in samples.bad] == [(3, 1)]


@pytest.mark.parametrize("encoding", ["utf-16-le", "utf-16-be"])
@pytest.mark.parametrize(
    ("letters", "recognized"),
    [
        ("a" * 81 + "я" * 79, True),
        ("a" * 80 + "я" * 80, False),
        ("a" * 88 + "Ѐ" * 10, True),
        ("a" * 88 + "Ѐ" * 11, False),
    ],
)
def test_utf_16_without_a_mark_is_known_by_its_zeros(table, encoding, letters, recognized):
    """In more than half of the characters one byte is zero, and in an eighth as many the other."""
    path = table(letters, encoding)
    if recognized:
        with open_text(path) as file:
            assert file.read() == letters
    else:
        with pytest.raises(ValueError, match="is not a text"), open_text(path):
            pass


@pytest.mark.parametrize(
    ("begin", "words"),
    [
        (b"PK\x03\x04xl", "is a spreadsheet or another zip archive; save the table as CSV"),
        (b"\xd0\xcf\x11\xe0\0", "is a spreadsheet of an old form; save the table as CSV"),
        (b"\x1f\x8b\x08", "is compressed; unpack it first"),
        (b"\x89HDF\r\n", "open it with xarray"),
    ],
)
def test_other_files_are_refused_with_the_remedy(tmp_path, begin, words):
    (tmp_path / "a.dat").write_bytes(begin)
    with pytest.raises(ValueError, match=words):
        read_samples(tmp_path / "a.dat")


@pytest.mark.parametrize(
    "text",
    [
        "x;y;value\n0,5;1.234,25;-2,0e1\n1234,5;7;8\n",
        "x;y;value\n0.5;1,234.25;-20\n1,234.5;7;8\n",
        "x\ty\tvalue\n0,5\t1 234,25\t-20\n1'234,5\t7\t8\n",
        "x y value\n0.5 1.23425D+03 -2d1\n1234.5 7D0 8.\n",
        'x,y,value\n0.5,"1,234.25",-20\n"1,234.5",7,8\n',
        '"x","y","value"\n"0,5","1234,25","-20"\n"1234,5","7","8"\n',
        "0,5 1234,25 -20,0\n1234,5 7 8\n",
        "0,5;1234,25;-20,0\n1234,5;7;8\n",
        "0.5D0 1234.25 -20\n1234.5 7 8\n",
    ],
)
def test_numbers_are_read_as_they_are_written(table, text):
    """Decimal commas, grouped digits and Fortran exponents, as the other cells decide."""
    samples = read_samples(table(text))
    assert samples.points.tolist() == [[0.5, 1234.25], [1234.5, 7]]
    assert samples.values.tolist() == [-20, 8]
    assert samples.bad == ()


def test_a_coordinate_that_was_named_as_the_value_is_reported(table):
    path = table("x,y,height\n0,0,1\n")
    with pytest.raises(ValueError, match=r"column x of .* was named as value, and no other column"):
        read_samples(path, value="x")


def test_an_ambiguous_comma_is_refused_unless_its_meaning_is_given(table):
    path = table("x;y;value\n1,234;1;2\n5,678;0;1\n")
    with pytest.raises(ValueError, match=r"comma in 1,234 marks decimals or thousands.*option dec"):
        read_samples(path)
    assert read_samples(path, decimal=",").points[:, 0].tolist() == [1.234, 5.678]
    assert read_samples(path, decimal=".").points[:, 0].tolist() == [1234, 5678]
    with pytest.raises(ValueError, match=r"decimal must be '\.' or ','; got ';'"):
        read_samples(path, decimal=";")


@pytest.mark.parametrize("cell", ["1,5", "1,23", "12,34,567", "1.5.0", "1,", "1_000"])
def test_a_number_in_another_format_is_a_bad_row(table, cell):
    """In a table of decimal points and commas between thousands no digit is guessed."""
    samples = read_samples(table(f"x;y;value\n1,234.5;1;2\n1,111.5;1;2\n{cell};0;1\n"))
    assert [row.line for row in samples.bad] == [4]


def test_marks_of_missing_values_are_named_and_left_out(table):
    """Extreme values that are repeated far from the others, not ends where values accumulate."""
    numbers = uniform(40, 3, seed=1)
    numbers[::8, 2], numbers[4::8, 2] = -9999, 1e20
    path = table("x,y,v\n" + "".join(f"{x},{y},{v}\n" for x, y, v in numbers.tolist()))
    said = read_samples(path).warnings
    assert any(s.startswith("v is -9999 5 times, far from all other values, 0.1") for s in said)
    assert any(s.startswith("v is 1e+20 5 times") for s in said)
    samples = read_samples(path, missing=[-9999, 1e20])
    assert len(samples.points) == 30
    assert samples.warnings == ["10 rows with missing values left out."]
    numbers[:, 2] = np.clip(numbers[:, 2], 0, 0.1)
    clipped = table("x,y,v\n" + "".join(f"{x},{y},{v}\n" for x, y, v in numbers.tolist()))
    assert read_samples(clipped).warnings == []
    with pytest.raises(ValueError, match=r"every row of .* has a missing value"):
        read_samples(table("x,y,v\n0,0,-99\n"), missing=-99)


def found_beside(end, ranges, times):
    """What is found to mark missing values: an end at so many ranges of the others."""
    others = end / 2 - np.linspace(abs(end) / 2 / ranges, 0, 201) * np.sign(end)
    found = suspects(np.random.default_rng(0).permutation([*others, *[end] * times]))
    assert all(one.others == (others.min(), others.max()) for one in found)
    return [(one.value, one.times) for one in found]


@pytest.mark.parametrize("mark", [99, 999, 9999, 99999, 999999, 9999999, 32767, 32768, 1e20, 1e30])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_usual_mark_may_occur_once_and_is_found_nearer(mark, sign):
    """Once at one range of the other values, repeatedly at a tenth; any other number at three."""
    usual, other = sign * mark, 1.01 * sign * mark
    assert found_beside(usual, 1.1, 1) == [(usual, 1)]
    assert found_beside(usual, 0.9, 1) == []
    assert found_beside(usual, 0.11, 2) == [(usual, 2)]
    assert found_beside(usual, 0.09, 2) == []
    assert found_beside(other, 100.0, 1) == []
    assert found_beside(other, 3.1, 2) == [(other, 2)]
    assert found_beside(other, 2.9, 2) == []
    assert suspects(np.array([0.0, usual / 1e3, usual])) == []
    assert len(suspects(np.array([0.0, usual / 1e3, usual / 2e3, usual]))) == 1


def test_the_range_of_the_others_is_that_without_both_ends():
    """A mark that occurs once is farther from them than this range, whatever lies inside."""
    others = np.array([10.5, 10.0, 9.2, 8.0, 0.0])
    for sign in (1.0, -1.0):
        for apart, found in ((10.1, [sign * 99]), (9.9, [])):
            values = sign * np.append(99 - apart - others, 99)
            assert [one.value for one in suspects(values)] == found


@pytest.mark.parametrize(("gap", "found"), [(0.9, 0), (1.0, 0), (1.1, 1)])
def test_a_mark_is_farther_from_the_others_than_two_steps_between_them(gap, found):
    """However often it occurs."""
    values = np.append(32768 - gap - np.array([0.0, 0.5, 1.25]), [32768, 32768])
    assert len(suspects(values)) == len(suspects(-values)) == found


def test_nine_and_eight_nines_are_no_usual_marks():
    assert found_beside(9.0, 100.0, 1) == found_beside(99_999_999.0, 100.0, 1) == []


def test_a_mark_of_missing_values_is_a_real_number():
    with pytest.raises(ValueError, match="missing must be"):
        as_missing([1.0, 1j])
    assert as_missing(None) == ()
    assert as_missing(-99) == (-99.0,)


def test_marks_are_named_in_depths_in_coordinates_and_in_standard_deviations(table):
    """Also where the depths have a range as large as the mark, and several marks on one side."""
    rng = np.random.default_rng(0)
    x, y, depth = rng.uniform(0, 1, 300), rng.uniform(0, 1, 300), rng.uniform(-7600, -50, 300)
    depth[:9], depth[9:13], x[20:23], sigma = -9999, -8888, 9999, rng.uniform(1, 2, 300)
    sigma[40:42] = -999
    rows = "".join(map("{},{},{},{}\n".format, x, y, depth, abs(sigma)))
    said = read_samples(table("x,y,depth,s\n" + rows), sigma="s").warnings
    for words in ("depth is -9999 9 times", "x is 9999 3 times", "deviation is 999 2 times"):
        assert any(words in sentence for sentence in said), (words, said)


def test_marks_in_the_coordinates_are_no_degrees(table):
    path = table("lon,lat,v\n-9999,1,2\n1,2,3\n400,1,2\n")
    samples = read_samples(path, missing=-9999, lonlat=True)
    assert (samples.absent, [row.line for row in samples.bad]) == (1, [4])


@pytest.mark.parametrize(("scales", "wide"), [((3e6, 2e-3), "x"), ((5e-7, 4e-2), "y")])
def test_the_power_of_ten_in_a_warning_brings_extents_of_other_units_together(table, scales, wide):
    """The column that is named is then as wide as the other one, to half a power of ten."""
    points = np.array([[0, 0], [1, 1], [0.3, 0.6]]) * scales
    text = "x,y,v\n" + "".join(f"{x},{y},1\n" for x, y in points)
    (said,) = (words for words in read_samples(table(text)).warnings if "one unit:" in words)
    name, factor = said.rpartition("divide ")[2].removesuffix(".").split(" by ")
    assert name == wide
    points[:, "xy".index(name)] /= float(factor)
    x, y = np.ptp(points, axis=0)
    assert 10**-0.5 < x / y < 10**0.5


def test_extents_in_other_units_are_reported(table):
    points = uniform(20, 2, seed=2)
    said = [
        read_samples(table("x,y,v\n" + "".join(f"{a * x},{y},1\n" for x, y in points))).warnings
        for a in (1e4, 2.0)
    ]
    assert "convert one of them, or divide x by 1e+04" in said[0][0]
    assert said[1] == []


@pytest.mark.parametrize(("ratio", "reported"), [(199.5, False), (200.5, True)])
@pytest.mark.parametrize("turned", [False, True])
def test_extents_in_the_ratio_of_200_are_probably_not_in_one_unit(ratio, reported, turned):
    """Whichever of the two is the wider one; nothing else is said."""
    points = np.array([[0.0, 0.0], [ratio, 0.3], [0.1, 1.0]])[:, :: -1 if turned else 1]
    said = Samples(("x", "y", "v"), points, np.zeros(3)).warnings
    assert [words for words in said if "convert one of them" not in words] == []
    assert len(said) == reported


def test_numbers_are_read_to_the_last_digit(table):
    """Numbers have up to 17 significant digits or a large offset."""
    samples = read_samples(table("x,y,z\n4500000.1,1e-300,0.1234567890123456\n"))
    assert samples.points.tolist() == [[4500000.1, 1e-300]]
    assert samples.values == np.array([0.1234567890123456])


@pytest.mark.slow
@given(data=st.data(), block=st.integers(1, 200))
def test_the_result_does_not_depend_on_the_block_size(tmp_path_factory, data, block):
    """Good and bad rows are found wherever a block of the file ends."""
    cell = st.one_of(st.floats(allow_nan=False, allow_infinity=False).map(repr), st.just("?"))
    rows = data.draw(st.lists(st.tuples(cell, cell, cell), min_size=1, max_size=30))
    path = tmp_path_factory.mktemp("blocks") / "points.txt"
    path.write_text("x,y,value\n" + "".join(f"{','.join(row)}\n" for row in rows))
    good = [[float(c) for c in row] for row in rows if "?" not in row]
    bad = [k for k, row in enumerate(rows, 2) if "?" in row]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(_text_tables, "BLOCK_SIZE", block)
        if not good:
            with pytest.raises(ValueError, match="must be a finite number"):
                read_samples(path)
            return
        samples = read_samples(path)
    assert [row.line for row in samples.bad] == bad
    once = {(x, y): 0 for x, y, _ in good}
    assert samples.points.tolist() == [list(point) for point in once]


def test_the_mean_of_huge_values_does_not_overflow(table):
    """The sum overflows but the mean does not; the spread of values far apart is infinite."""
    samples = read_samples(table("x,y,z\n0,0,1e308\n0,0,1.2e308\n0,0,1.4e308\n1,0,1\n0,1,2\n"))
    np.testing.assert_allclose(samples.values[0], 1.2e308)
    far = read_samples(table("x,y,z\n0,0,1.5e308\n0,0,-1.5e308\n1,0,1\n0,1,2\n"))
    assert (far.values[0], far.spread) == (0.0, np.inf)
    largest = np.finfo(float).max
    same = read_samples(table(f"x,y,z\n0,0,{largest}\n0,0,{largest}\n0,0,{largest}\n1,0,1\n"))
    assert (same.values[0], same.conflicts) == (largest, 0)


def test_several_values_and_their_deviations_are_merged_at_repeated_points(table):
    """A point counts once as a conflict, however many of its values differ."""
    rows = "0,0,1,10,3\n1,0,2,20,1\n0,0,3,14,4\n0,1,5,5,1\n1,0,2,20,1e200\n"
    samples = read_samples(table(f"x,y,east,north,s\n{rows}"), value=("east", "north"), sigma="s")
    np.testing.assert_allclose(samples.values, [[2, 12], [2, 20], [5, 5]])
    np.testing.assert_allclose(samples.sigma, [2.5, 5e199, 1])
    assert (samples.merged, samples.conflicts, samples.spread) == (2, 1, 4.0)


def test_progress_is_reported_in_bytes(table, monkeypatch):
    """Progress increases to the size of the file."""
    monkeypatch.setattr(_text_tables, "BLOCK_SIZE", 64)
    path = table("x,y,z\n" + "".join(f"{k},{k * k},1\n" for k in range(200)))
    steps = []
    read_samples(path, progress=lambda *step: steps.append(step))
    done = [step[0] for step in steps]
    assert len(done) > 10
    assert done == sorted(done)
    assert steps[-1] == (path.stat().st_size, path.stat().st_size)


# --- arrays -------------------------------------------------------------------------------------


def write_npz(path, **arrays):
    np.savez(path, **arrays)
    return path


def test_npz_archives_are_tables(tmp_path):
    """The arrays are the columns by name, or `points` and `values`; they are read in one step."""
    path, steps = tmp_path / "a.npz", []
    rows = [[0.0, 1.0], [3.0, 4.0]]
    for arrays in (
        {"x": [0, 3], "y": [1, 4], "value": [2, 5]},
        {"points": rows, "values": [2, 5], "note": "by hand"},
        {"points": rows, "values": [2, 5], "epsg": 25832, "cube": np.zeros((2, 2, 2))},
    ):
        samples = read_samples(write_npz(path, **arrays), progress=lambda *step: steps.append(step))
        assert samples.points.tolist() == rows
        assert samples.values.tolist() == [2, 5]
        assert steps.pop() == (1, 1)
        assert not steps
    space = write_npz(path, points=[[1.0, 2.0, 3.0]], values=[4.0])
    assert read_samples(space, z="z").points.tolist() == [[1, 2, 3]]
    assert read_samples(write_npz(path, x=[0, np.nan], y=[1, 1], value=[2, 2])).bad == (
        (2, "x must be a finite number; got nan", 1),
    )


def test_masked_rows_are_skipped_and_counted(tmp_path):
    """NumPy saves masked arrays without their masks; beside them, a mask is heeded."""
    values = np.ma.masked_greater([2.0, 5.0, 1e20, np.nan, 3.0], 1e19)
    arrays = {"x": [0, 3, 1, 1, 2], "y": [1, 4, 5, 5, 6], "value": values}
    samples = read_samples(write_npz(tmp_path / "a.npz", **arrays, mask=values.mask))
    assert samples.values.tolist() == [2, 5, 3]
    assert samples.points.tolist() == [[0, 1], [3, 4], [2, 6]]
    with pytest.raises(ValueError, match="no column 'mask'"):
        read_samples(tmp_path / "a.npz", value="mask")
    assert samples.warnings[0] == (
        "2 rows skipped, by line: 3: the row is masked; 4: value must be a finite number; got nan."
    )
    with pytest.raises(ValueError, match="line 3: the row is masked"):
        read_samples(tmp_path / "a.npz", strict=True)
    with pytest.raises(ValueError, match="mask must have one truth value for each of 5 rows"):
        read_samples(write_npz(tmp_path / "a.npz", **arrays, mask=[True]))


@pytest.mark.parametrize(
    ("arrays", "words"),
    [
        ({"x": [0, 1], "y": [0], "value": [1]}, "must be equally long; got x 2, y 1, value 1"),
        ({"x": [0], "y": [0]}, "name it by the option value: x, y"),
        ({"points": np.zeros((2, 5))}, "a column must be one number for each row; points is not"),
        ({"x": np.array([{}], dtype=object)}, "cannot be read as arrays: .*allow_pickle"),
        ({"x": np.empty(0), "y": np.empty(0), "value": np.empty(0)}, "has no rows"),
    ],
)
def test_inconsistent_archives_are_refused(tmp_path, arrays, words):
    """The message names the file; a pickle is not opened."""
    with pytest.raises(ValueError, match=words):
        read_samples(write_npz(tmp_path / "a.npz", **arrays))


def test_files_that_are_not_archives_are_refused(tmp_path):
    """Only the suffix of these files is that of an archive."""
    for name in ("a.npz", "a.parquet"):
        (tmp_path / name).write_bytes(b"PK\3\4 but no more")
        with pytest.raises(ValueError, match="cannot be read as"):
            read_samples(tmp_path / name)


# --- Parquet ------------------------------------------------------------------------------------


def test_parquet_files_are_tables(tmp_path):
    """Columns may have any numeric type; a row with a missing number is bad, counted from one."""
    path = tmp_path / "a.parquet"
    columns = {
        "name": pa.array(["a", "b", "c"]),
        "x": pa.array([0, 3, 7], pa.int32()),
        "y": pa.array([1, 4, 7], pa.float32()),
        "value": pa.array([2.0, 5.0, None]),
    }
    pyarrow.parquet.write_table(pa.table(columns), path)
    steps = []
    samples = read_samples(path, progress=lambda *step: steps.append(step))
    assert samples.points.tolist() == [[0, 1], [3, 4]]
    assert samples.values.tolist() == [2, 5]
    assert samples.bad == ((3, "value must be a finite number; got nan", 2),)
    assert steps[-1] == (3, 3)
    with pytest.raises(ValueError, match="must hold numbers in"):
        read_samples(path, value="name")


def test_parquet_files_are_read_in_batches_of_rows(tmp_path, monkeypatch):
    """Rows are numbered through, and progress ends with the last of them."""
    monkeypatch.setattr(_text_tables, "PARQUET_ROWS", 3)
    value = [0.0, None, 2.0, 3.0, None, 5.0, 6.0]
    columns = {
        "x": pa.array(range(7)),
        "y": pa.array([*map(float, range(7))][::-1]),
        "value": value,
    }
    pyarrow.parquet.write_table(pa.table(columns), tmp_path / "a.parquet")
    steps = []
    samples = read_samples(tmp_path / "a.parquet", progress=lambda *step: steps.append(step))
    assert samples.points[:, 0].tolist() == samples.values.tolist() == [0, 2, 3, 5, 6]
    assert [(row.line, row.row) for row in samples.bad] == [(2, 1), (5, 4)]
    assert steps == [(3, 7), (6, 7), (7, 7)]


def test_without_pyarrow_the_install_command_is_shown(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyarrow.parquet", None)
    with pytest.raises(ImportError, match=r"pyarrow is not .* the extra 'parquet': pip install "):
        read_samples(tmp_path / "a.parquet")


# --- geometry -----------------------------------------------------------------------------------


@pytest.mark.parametrize(("size", "offset"), [(1.0, 0.0), (1.0, 4.5e6), (1e-3, 4.5e6)])
@pytest.mark.parametrize(
    ("directions", "words"),
    [
        ([[0, 0]], "all 50 points lie at one point"),
        ([[1, 2]], "all 50 points lie on one straight line: .* take the distance along it"),
        ([[1, 2, 3]], "all 50 points lie on one straight line"),
        ([[1, 2, 3], [1, 0, 0]], "all 50 points lie in one plane"),
    ],
)
def test_collinear_and_coplanar_samples_are_refused(size, offset, directions, words):
    """Values on a line or a plane do not determine the field beside it.

    A large offset, which rounds the coordinates, makes no difference.
    """
    points = size * uniform(50, len(directions), seed=0) @ np.array(directions, float) + offset
    samples = Samples(("x",) * (points.shape[1] + 1), points, points[:, 0])
    with pytest.raises(np.linalg.LinAlgError, match=words):
        refuse_flat(samples)


@pytest.mark.parametrize(
    ("scales", "divided"), [([1e9, 1], "x"), ([1, 1e12], "y"), ([1e-7, 1e5], "y")]
)
def test_the_remedy_for_different_units_makes_the_samples_acceptable(scales, divided):
    """The extents are equal up to half a power of ten. Points on a line in any units, such as
    (1, 2) t, have no such remedy.
    """

    def refused(points):
        with pytest.raises(np.linalg.LinAlgError) as caught:
            refuse_flat(Samples(("x", "y", "v"), points, points[:, 0]))
        return str(caught.value)

    points = uniform(50, 2, seed=0) * scales
    message = refused(points)
    name, factor = message.rpartition("divide ")[2].split(" by ")
    assert name == divided
    assert factor.startswith("1e")
    points[:, "xy".index(name)] /= float(factor)
    refuse_flat(Samples(("x", "y", "v"), points, points[:, 0]))
    assert abs(np.log10(np.ptp(points, axis=0)) @ [1, -1]) < 0.51
    line = np.outer(uniform(50, 1, seed=0), [1.0, 2.0])
    for flat in (line * scales, line * [1, 0] + [0, 1 / 3]):
        assert "units differ" not in refused(flat)


def test_a_narrow_strip_is_not_flat():
    """A strip that is a thousand times longer than wide is accepted."""
    points = uniform(50, 2, seed=0) * [1e3, 1.0] + 1e5
    refuse_flat(Samples(("x", "y", "z"), points, points[:, 0]))


def test_the_fast_parser_equals_the_parser_by_rows(table, monkeypatch):
    """Both give the numbers that Python's csv module and float() give."""
    numbers = np.random.default_rng(0).standard_normal((500, 3)) * 10.0 ** np.arange(-150, 151, 150)
    path = table("x,y,z\n" + "".join(",".join(map(repr, row)) + "\n" for row in numbers.tolist()))
    quick = read_samples(path)
    monkeypatch.setattr(_text_tables._TextParser, "_parse_at_once", lambda *_: None)
    slow = read_samples(path)
    assert np.array_equal(quick.points, slow.points)
    with path.open(newline="") as file:
        literal = [float(row["z"]) for row in csv.DictReader(file)]
    assert quick.values.tolist() == slow.values.tolist() == literal
    assert len(literal) == 500
