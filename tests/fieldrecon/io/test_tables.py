"""What is written as a table is read as it was, and is no formula to a spreadsheet."""

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
def test_what_is_no_table_is_told(tmp_path, content, sentence):
    """By the name of the file, and what to do about it."""
    with pytest.raises(ValueError, match=sentence):
        read_table(table(tmp_path, content), dict, ("student", "points"), ("comment",))


@given(content=st.binary(max_size=300))
def test_no_bytes_raise_anything_else(tmp_path_factory, content):
    """A file is a table, or a sentence says why not."""
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
def test_cells_come_back(tmp_path_factory, rows):
    """But for the space round them, and for lines that say nothing."""
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
    """Nor a comment that the reading would leave out."""
    (row,) = csv.reader(io.StringIO(to_csv((text, "x"), []), newline=""))
    assert row[0][:1] not in [*"=+-@\t\r\n＝＋－＠#"]


@pytest.mark.parametrize("text", ["=1+1", "+1", "-1", "@SUM(A1)", "\t=1", "＝1", "#x", "'=1"])
def test_formulas_are_quoted(text):
    """A quotation mark in front makes them text, and one more where there is one."""
    assert FORMULA.match(text)
    assert to_csv(("x",), [(text,)]).splitlines()[1].strip('"').startswith("'")


def test_numbers_are_written_as_numbers():
    """They are no text, so a negative one is no formula."""
    assert to_csv(("a", "b", "c"), [(-1.5, 2 / 3, None)]) == "a,b,c\n-1.5,0.67,\n"


def test_two_lines_may_not_say_the_same(tmp_path):
    """Where a table asks for that, whatever the case of letters."""
    file = table(tmp_path, "student,points\nada,1\nAda,2\nbob,1\n")
    with pytest.raises(ValueError, match=r"table\.csv:3: Ada is already in line 2"):
        read_table(file, dict, ("student", "points"), unique=("student",))
    assert len(read_table(file, dict, ("student", "points"))) == 3


def test_a_line_is_counted_where_it_ends(tmp_path):
    """Also where a cell goes over several lines."""
    file = table(tmp_path, 'student,points\n"a\nb",1\n"c\nd",\n')
    with pytest.raises(ValueError, match=r"table\.csv:5: column points is empty"):
        read_table(file, dict, ("student", "points"))


@pytest.mark.parametrize(("cell", "value"), [("2", 2.0), ("1.5", 1.5), ("0,25", 0.25)])
def test_points_are_understood(cell, value):
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
def test_what_is_no_number_is_refused(read, cell):
    with pytest.raises(ValueError, match=f"not '{cell}'"):
        read(cell)
