"""What the command line prints: tables that fit, and a line that leaves nothing behind."""

import io
import sys

import pytest

from fieldrecon.cli.console import print_table, say
from fieldrecon.cli.progress import Bar, Stage, StatusLine

WORDS = "several words that are too long for one line of a narrow terminal"
ROWS = [("short", WORDS), ("x", 0.123456789), ("list", (1, 2))]


class Terminal(io.StringIO):
    """A terminal that is remembered."""

    def isatty(self) -> bool:
        return True


def terminal(monkeypatch, name: str, width: int = 80) -> Terminal:
    """Put a terminal of this width in the place of standard output or error."""
    monkeypatch.setenv("COLUMNS", str(width))
    monkeypatch.setattr(sys, name, shown := Terminal())
    return shown


def on_screen(text: str) -> list[str]:
    """The lines that a terminal shows: what follows a carriage return overwrites."""
    shown = []
    for line in text.split("\n"):
        seen = ""
        for part in line.split("\r"):
            seen = part + seen[len(part) :]
        shown.append(seen.rstrip())
    return shown


@pytest.mark.parametrize("width", [30, 60])
def test_a_table_fits_the_terminal_and_loses_nothing(monkeypatch, width):
    """No line is longer; the words of a cell stand below each other, in their order."""
    shown = terminal(monkeypatch, "stdout", width)
    print_table(("name", "meaning"), ROWS, title="A title")
    lines = shown.getvalue().splitlines()
    assert max(map(len, lines)) <= width
    column = lines[1].index("meaning")
    assert f"meaning {'-' * 7}" in " ".join(line[column:][:7] for line in lines[1:3])
    cell = " ".join(line[column:] for line in lines[3:-3])
    assert cell.split() == WORDS.split()
    assert [line[column:] for line in lines[-3:-1]] == ["0.1235", "1,2"]


@pytest.mark.parametrize("width", [30, 60])
def test_a_paragraph_fits_the_terminal(monkeypatch, width):
    """And loses no word."""
    shown = terminal(monkeypatch, "stdout", width)
    say(WORDS)
    assert max(map(len, shown.getvalue().splitlines())) <= width
    assert shown.getvalue().split() == WORDS.split()


def test_a_file_has_each_row_in_a_line(capsys, monkeypatch):
    """Nothing is broken where there is no terminal."""
    monkeypatch.setenv("COLUMNS", "30")
    print_table(("name", "meaning"), ROWS)
    say(WORDS)
    shown = capsys.readouterr().out.splitlines()
    assert shown[2] == f"short  {WORDS}"
    assert shown[-1] == WORDS


def test_the_status_line_leaves_nothing_behind(monkeypatch):
    """On a terminal the lines that are to stay do, and the others are gone at the end."""
    shown = terminal(monkeypatch, "stderr")
    with StatusLine() as line:
        Stage(line, "a long label of a stage")
        assert on_screen(shown.getvalue())[-1] == "a long label of a stage"
        line.say("kept")
        Stage(line, "another")
    assert on_screen(shown.getvalue()) == ["kept", ""]


def test_a_build_is_counted(monkeypatch):
    """How many are done, of how many that are known."""
    shown = terminal(monkeypatch, "stderr")
    with Bar() as bar:
        bar.add(3)
        bar.add(1)
        bar.done("drew it")
        kept, line = on_screen(shown.getvalue())
        assert kept == "drew it"
        assert line.endswith("25 %, 1 of 4")
    assert on_screen(shown.getvalue()) == ["drew it", ""]


def test_a_file_gets_the_lines_that_stay(capsys):
    """And none of those that are rewritten."""
    with Bar() as bar:
        bar.add(1)
        bar.done("drew it")
    assert capsys.readouterr().err == "drew it\n"
