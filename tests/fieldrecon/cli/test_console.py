"""What the command line prints: tables and paragraphs that fit the terminal, and progress bars."""

import io
import sys
from types import SimpleNamespace

import pytest

from fieldrecon.cli import progress
from fieldrecon.cli.console import print_table, say
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
    """No line is longer than the terminal, and the words of a wrapped cell keep their order."""
    shown = terminal(monkeypatch, "stdout", width)
    print_table(("name", "meaning"), ROWS, title="A title")
    lines = shown.getvalue().splitlines()
    assert max(map(len, lines)) <= width
    column = lines[1].index("meaning")
    assert f"meaning {'-' * 7}" in " ".join(line[column:][:7] for line in lines[1:3])
    cell = " ".join(line[column:] for line in lines[3:-3])
    assert cell.split() == WORDS.split()
    assert [line[column:] for line in lines[-3:-1]] == ["0.1235", "1,2"]


@pytest.mark.parametrize("transposed", [False, True])
@pytest.mark.parametrize("number", [39, 40, 41, 43])
def test_a_long_table_ends_after_forty_rows_with_the_number_of_the_others(
    capsys, number, transposed
):
    """They are rows as printed: those of a transposed table are its columns."""
    first, *rows = every = [[str(k), f"name_{k}"] for k in range(1 + number)]
    columns = [row[0] for row in every]
    given = (columns, [[row[1] for row in every]]) if transposed else (first, rows)
    for whole, limit in ((False, 40), (True, number)):
        print_table(*given, whole=whole)
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


def test_the_bar_shows_the_number_of_finished_tasks(monkeypatch):
    """The bar shows the percentage and "1 of 4"; messages of finished tasks remain above it."""
    shown = terminal(monkeypatch, "stderr")
    with Bar() as bar:
        bar.add(3)
        bar.add(1)
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
