"""Tables in CSV: cells are reproduced, bad tables are refused, and no cell is a formula."""

import csv
import io

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldgrade.class_folder.csv_tables import (
    FORMULA,
    notebook,
    points,
    question,
    read_table,
    to_csv,
)


def table(tmp_path, content):
    file = tmp_path / "table.csv"
    file.write_bytes(content if isinstance(content, bytes) else content.encode())
    return file


BAD = {
    "nothing": (b"", "table.csv is empty; its first line should be student, points"),
    "blank": (b"\n \n# comment\n", "is empty"),
    "UTF-16": ("student,points".encode("utf-16"), "is not in UTF-8: save it as CSV UTF-8"),
    "no such column": (b"student\n", "table.csv:1: there is no column points"),
    "a misspelled column": (b"student,points,coment\n", "unknown column 'coment'"),
    "a column twice": (b"student,points,Points\n", "a column occurs twice"),
    "a cell without end": (b'student,points\nx,"' + b"y" * 200_000, "field larger than"),
}


@pytest.mark.parametrize(("content", "sentence"), BAD.values(), ids=BAD)
def test_bad_tables_are_refused(tmp_path, content, sentence):
    """The message names the file and says how to correct it."""
    with pytest.raises(ValueError, match=sentence):
        read_table(table(tmp_path, content), dict, ("student", "points"), ("comment",))


@given(content=st.binary(max_size=300))
def test_arbitrary_bytes_give_a_table_or_a_value_error(tmp_path_factory, content):
    """The message of the ValueError begins with the name of the file."""
    file = tmp_path_factory.mktemp("t") / "table.csv"
    file.write_bytes(b"student,points\n" + content)
    try:
        rows = read_table(file, dict, ("student", "points"))
    except ValueError as error:
        assert str(error).startswith("table.csv")  # noqa: PT017
    else:
        assert all(row["student"] and row["points"] for row in rows)


cells = st.text(st.characters(codec="utf-8", exclude_characters="\0"), max_size=20)


@given(rows=st.lists(st.tuples(cells, cells), max_size=5))
def test_cells_are_reproduced(tmp_path_factory, rows):
    """Only surrounding space and rows of empty cells are lost."""
    file = tmp_path_factory.mktemp("t") / "table.csv"
    file.write_text(to_csv(("student", "comment"), rows), encoding="utf-8", newline="")
    columns = ("student", "comment")
    found = [(r["student"], r["comment"]) for r in read_table(file, dict, (), columns)]
    wanted = [(_ends(a).strip(), _ends(b).strip()) for a, b in rows]
    assert found == [pair for pair in wanted if any(pair)]


def _ends(text):
    return text.replace("\r\n", "\n").replace("\r", "\n")


@given(st.text(max_size=20))
def test_no_cell_is_a_formula(text):
    """No cell begins with a character that starts a formula or a comment."""
    (row,) = csv.reader(io.StringIO(to_csv((text, "x"), []), newline=""))
    assert row[0][:1] not in [*"=+-@\t\r\n＝＋－＠#"]


@pytest.mark.parametrize("text", ["=1+1", "+1", "-1", "@SUM(A1)", "\t=1", "＝1", "#x", "'=1"])
def test_formulas_are_quoted(text):
    """A quotation mark in front turns a formula into text, also where the text begins with one."""
    assert FORMULA.match(text)
    assert to_csv(("x",), [(text,)]).splitlines()[1].strip('"').startswith("'")


def test_numbers_are_written_as_numbers():
    """Numbers are not text, so a negative number needs no quotation mark."""
    assert to_csv(("a", "b", "c"), [(-1.5, 2 / 3, None)]) == "a,b,c\n-1.5,0.67,\n"


def test_repeated_entries_in_a_unique_column_are_refused(tmp_path):
    """The comparison ignores the case of letters."""
    file = table(tmp_path, "student,points\nada,1\nAda,2\nbob,1\n")
    with pytest.raises(ValueError, match=r"table\.csv:3: student Ada is already in line 2"):
        read_table(file, dict, ("student", "points"), unique=("student",))
    assert len(read_table(file, dict, ("student", "points"))) == 3


def test_line_numbers_count_line_breaks_within_cells(tmp_path):
    """The reported line is the last line of the row."""
    file = table(tmp_path, 'student,points\n"a\nb",1\n"c\nd",\n')
    with pytest.raises(ValueError, match=r"table\.csv:5: column points is empty"):
        read_table(file, dict, ("student", "points"))


@pytest.mark.parametrize(("cell", "value"), [("2", 2.0), ("1.5", 1.5), ("0,25", 0.25)])
def test_numbers_with_point_or_comma_are_read(cell, value):
    assert points(cell) == value


@pytest.mark.parametrize(
    ("read", "cell"),
    [
        (points, "inf"),
        (points, "1e3"),
        (points, "½"),
        (question, "1.2"),
        (question, "01,2"),
        (notebook, "002"),
        (notebook, ""),
    ],
)
def test_non_numeric_cells_are_refused(read, cell):
    with pytest.raises(ValueError, match=f"not '{cell}'"):
        read(cell)
