"""What the command line prints: tables and paragraphs that fit the terminal, and progress bars."""

import argparse
import io
import re
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

from fieldrecon.cli import progress
from fieldrecon.cli.console import as_parameters, print_table, say
from fieldrecon.cli.progress import Bar, Stage, StatusLine

WORDS = "several words that are too long for one line of a narrow terminal"
ROWS = [("short", WORDS), ("x", 0.123456789), ("list", (1, 2))]


class Terminal(io.StringIO):
    """A stream that claims to be a terminal and keeps what is written to it."""

    def isatty(self) -> bool:
        return True


def terminal(monkeypatch, name: str, width: int = 80) -> Terminal:
    """Replace standard output or error by a terminal with this number of columns."""
    monkeypatch.setenv("COLUMNS", str(width))
    monkeypatch.setattr(sys, name, shown := Terminal())
    return shown


def on_screen(text: str) -> list[str]:
    """The lines that a terminal shows: text after a carriage return overwrites the line."""
    shown = []
    for line in text.split("\n"):
        seen = ""
        for part in line.split("\r"):
            seen = part + seen[len(part) :]
        shown.append(seen.rstrip())
    return shown


@pytest.mark.parametrize("width", [30, 60])
def test_a_table_is_wrapped_to_the_terminal(monkeypatch, width):
    """The table is as wide as the terminal, and the words of a wrapped cell keep their order."""
    shown = terminal(monkeypatch, "stdout", width)
    print_table(("name", "meaning"), ROWS, title="A title")
    lines = shown.getvalue().splitlines()
    assert max(map(len, lines)) == len(lines[2]) == width
    column = lines[1].index("meaning")
    assert f"meaning {'-' * 7}" in " ".join(line[column:][:7] for line in lines[1:3])
    cell = " ".join(line[column:] for line in lines[3:-3])
    assert cell.split() == WORDS.split()
    assert [line[column:] for line in lines[-3:-1]] == ["0.1235", "1,2"]


@pytest.mark.parametrize(
    ("columns", "rows", "transposed"),
    [(7, 1, False), (8, 7, True), (8, 8, False), (14, 8, False), (15, 8, True)],
)
def test_a_table_of_many_columns_is_transposed(capsys, columns, rows, transposed):
    """Of more than seven, unless it has more rows than that; of more than fourteen always."""
    table = [[f"{row}.{column}" for column in range(columns)] for row in range(1 + rows)]
    print_table(table[0], table[1:])
    first, below, *others, end = capsys.readouterr().out.splitlines()
    assert {*below} == {"-", " "}
    wanted = [*map(list, zip(*table, strict=True))] if transposed else table
    assert [line.split() for line in (first, *others)] == wanted
    assert end == ""


def test_no_column_is_narrower_than_eight_characters(monkeypatch):
    """Also where the table is then wider than the terminal; a narrow column stays as it is."""
    shown = terminal(monkeypatch, "stdout", 12)
    print_table(("a", "b", "c"), [("x", "y" * 20, "z" * 9)])
    assert shown.getvalue().splitlines() == [
        "a  b         c",
        "-  --------  --------",
        "x  yyyyyyyy  zzzzzzzz",
        "   yyyyyyyy  z",
        "   yyyy",
        "",
    ]


def test_parameters_are_the_options_that_were_given_or_have_a_default():
    """By their names on the command line, and without the file that is named elsewhere."""
    options = {"mesh": Path("a.stl"), "json": True, "open": False, "tolerance": None}
    options |= {"out": Path("audit"), "largest_hole": 0.0, "command": print, "traceback": True}
    shown = {"--json": True, "--out": "audit", "--largest-hole": 0.0}
    assert as_parameters(argparse.Namespace(**options), omit="mesh") == shown
    assert as_parameters(argparse.Namespace(**options)) == {"--mesh": "a.stl"} | shown


@pytest.mark.parametrize("transposed", [False, True])
@pytest.mark.parametrize("number", [39, 40, 41, 43])
def test_a_long_table_ends_after_forty_rows_with_the_number_of_the_others(
    capsys, number, transposed
):
    """They are rows as printed: those of a transposed table are its columns."""
    first, *rows = every = [[str(k), f"name_{k}"] for k in range(1 + number)]
    columns = [row[0] for row in every]
    given = (columns, [[row[1] for row in every]]) if transposed else (first, rows)
    for options, limit in (({}, 40), ({"whole": False}, 40), ({"whole": True}, number)):
        print_table(*given, **options)
        *shown, end = capsys.readouterr().out.splitlines()
        assert end == ""
        if number > limit:
            assert shown.pop() == f"… and {number - limit} rows more, in the file"
        assert [line.split() for line in (shown[0], *shown[2:])] == every[: 1 + limit]


@pytest.mark.parametrize("width", [30, 60])
def test_a_paragraph_is_wrapped_to_the_terminal(monkeypatch, width):
    """No line is longer than the terminal, and no word is lost."""
    shown = terminal(monkeypatch, "stdout", width)
    say(WORDS)
    assert max(map(len, shown.getvalue().splitlines())) <= width
    assert shown.getvalue().split() == WORDS.split()


def test_output_to_a_file_is_not_wrapped(capsys, monkeypatch):
    """In a file each row of a table and each paragraph is one line."""
    monkeypatch.setenv("COLUMNS", "30")
    print_table(("name", "meaning"), ROWS)
    say(WORDS)
    shown = capsys.readouterr().out.splitlines()
    assert shown[2] == f"short  {WORDS}"
    assert shown[-1] == WORDS


@pytest.mark.parametrize("width", [30, 60])
def test_the_status_line_is_shorter_than_the_terminal(monkeypatch, width):
    """It is cut to one character less, so that it is never wrapped, and erased as a whole."""
    shown = terminal(monkeypatch, "stderr", width)
    with StatusLine() as line:
        line.show(WORDS)
        assert on_screen(shown.getvalue()) == [WORDS[: width - 1].rstrip()]
        line.show("short")
        assert on_screen(shown.getvalue()) == ["short"]
    assert on_screen(shown.getvalue()) == [""]


def test_the_status_line_is_erased_at_the_end(monkeypatch):
    """Lines printed with `say` remain on the terminal; the labels of stages are erased."""
    shown = terminal(monkeypatch, "stderr")
    with StatusLine() as line:
        Stage(line, "a long label of a stage")
        assert on_screen(shown.getvalue())[-1] == "a long label of a stage"
        line.say("kept")
        Stage(line, "another")
    assert on_screen(shown.getvalue()) == ["kept", ""]


def test_a_line_is_shown_at_once(monkeypatch):
    """Nothing waits in a buffer until the work ends."""
    shown = terminal(monkeypatch, "stderr")
    seen = []
    monkeypatch.setattr(shown, "flush", lambda: seen.append(shown.getvalue()))
    with StatusLine() as line:
        line.say("kept")
        assert seen[-1].endswith("kept\n")
        line.show("begun")
        assert seen[-1].endswith("begun")


def test_the_bar_shows_the_number_of_finished_tasks(monkeypatch):
    """The bar shows the percentage and "1 of 4"; messages of finished tasks remain above it."""
    shown = terminal(monkeypatch, "stderr")
    with Bar() as bar:
        bar.add(3)
        bar.add(1)
        (line,) = on_screen(shown.getvalue())
        assert line.endswith(" 0 %, 0 of 4")
        bar.done("drew it")
        kept, line = on_screen(shown.getvalue())
        assert kept == "drew it"
        assert line.endswith("25 %, 1 of 4")
    assert on_screen(shown.getvalue()) == ["drew it", ""]


def test_output_to_a_file_has_no_bar(capsys):
    """A file receives the messages of finished tasks and no progress bar."""
    with Bar() as bar:
        bar.add(1)
        bar.done("drew it")
    assert capsys.readouterr().err == "drew it\n"


def test_a_bar_is_filled_in_proportion_to_the_work():
    """To the nearest of its ten cells, and to the nearest percentage."""
    for done in range(31):
        bar = progress.bar(done, 30)
        full, left, percent = re.fullmatch(r"\[(#*)(-*)\] +(\d+) %", bar).groups()
        assert len(full + left) == 10
        assert abs(len(full) - done / 3) < 0.5
        assert abs(int(percent) - done / 0.3) < 0.5


def test_times_are_in_seconds_or_from_ninety_on_in_minutes():
    for seconds in (0.2, 59.4, 61.0, 89.4, 90.0, 100.0, 3599.0):
        number, unit = progress.in_words(seconds).split()
        size = {"seconds": 1, "minutes": 60}[unit]
        assert size == (1 if seconds < 90 else 60)
        assert abs(int(number) * size - seconds) <= size / 2


def test_finished_items_are_counted_while_others_are_waited_for(monkeypatch):
    """The results are those of the mapping, in its order; the bar is erased at the end."""
    shown = terminal(monkeypatch, "stderr")
    monkeypatch.setattr(progress, "_SECONDS_BETWEEN", 0)
    with progress.progress(map, "squares") as counted:
        results = counted(lambda x: x**2, iter(range(4)))
        for k in range(4):
            assert next(results) == k**2
            (line,) = on_screen(shown.getvalue())
            assert line.startswith(f"squares {progress.bar(k + 1, 4)}, about ")
        assert next(results, None) is None
    assert on_screen(shown.getvalue()) == [""]


def test_a_stage_shows_its_name_at_once_and_then_the_memory(monkeypatch):
    """The next stage replaces it."""
    shown = terminal(monkeypatch, "stderr")
    monkeypatch.setattr(progress, "_SECONDS_BETWEEN", 0)
    with progress.stages() as stage:
        report = stage("fitting")
        assert on_screen(shown.getvalue()) == ["fitting"]
        report(0, 4)
        assert on_screen(shown.getvalue()) == ["fitting"]
        report(3, 4)
        (line,) = on_screen(shown.getvalue())
        bar = re.escape(progress.bar(3, 4))
        assert re.fullmatch(rf"fitting {bar}, about 0 seconds left, \d\.\d\d GB", line)
        stage("evaluating")
        assert on_screen(shown.getvalue()) == ["evaluating"]
    assert on_screen(shown.getvalue()) == [""]


def test_a_stage_shows_the_time_that_is_left_at_most_ten_times_a_second(monkeypatch):
    """In proportion to the work; before any is done, nothing is known of it."""
    clock = iter([0.0, 5.0, 10.0, 10.05, 10.11])
    monkeypatch.setattr(progress, "time", SimpleNamespace(monotonic=lambda: next(clock)))
    shown = []
    stage = Stage(SimpleNamespace(show=shown.append), "fitting")
    for done in (0, 25, 26, 50):
        stage(done, 100)
    assert shown[0] == "fitting"
    left = [text.partition("about ")[2].removesuffix(" left") for text in shown[1:]]
    assert left == [progress.in_words(30.0), progress.in_words(10.11)]
