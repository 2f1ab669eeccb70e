"""The statements of a cell: which run after a failure, and which an answer needs."""

import pytest

from fieldgrade.sandbox import blocks
from fieldgrade.sandbox.notebook_code import plain
from fieldgrade.sandbox.statements import needed, read

CELL = """
import os
import numpy as np, missing
x = os._exit(1)
TABLE = {}
TABLE["one"] = 1.0
np.seterr(all="raise")
log.append(TABLE)
def scale(v): return np.sqrt(v) * TABLE["one"]
def other(x): return scale(x)
fit = lambda p: scale(p)
print(fit(3))
exec("fit = fit")
"""


def lines(indices, found):
    return sorted({found[index].line for index in indices})


def test_an_answer_needs_what_its_names_are_made_of():
    """Neither a parameter called x nor a call that changes nothing needed counts; exec might."""
    found, _ = read(CELL, "cell")
    assert lines(needed(["fit"], found), found) == [3, 5, 6, 9, 11, 13]
    assert lines(needed(["scale"], found), found) == [3, 5, 6, 9, 13]
    assert lines(needed(["x"], found), found) == [2, 4, 13]


@pytest.mark.parametrize(
    ("code", "name"),
    [
        ("a, (b, *fit) = 1, (2, 3)", "fit"),
        ("fit: int = 3", "fit"),
        ("print(fit := 3)", "fit"),
        ("match 3:\n    case fit: pass", "fit"),
        ("def f():\n    global fit\n    fit = 3", "fit"),
        ("with open(x) as fit: pass", "fit"),
        ("fit.rate[2] += 1", "fit"),
        ("fit.append(1)", "fit"),
        ("from x import y as fit", "fit"),
        ("class fit: pass", "fit"),
        ("del fit[0]", "fit"),
    ],
)
def test_a_statement_defines_the_names_that_it_binds_or_changes(code, name):
    """A list comprehension and a parameter bind no name of the notebook."""
    (found, *_), _ = read(code, "cell")
    assert name in found.defines
    (other,), _ = read("y = [fit for fit in (lambda fit: fit)(3)]", "cell")
    assert "fit" not in other.defines | other.uses


def test_each_import_is_a_statement_and_flags_of_the_future_stay():
    """An annotation that is not evaluated may name what does not exist."""
    found, flags = read("from __future__ import annotations\nimport a, b.c as d", "cell")
    assert [statement.defines for statement in found] == [{"annotations"}, {"a"}, {"d"}]
    (function,), _ = read("def f(x: nowhere): pass", "cell", flags)
    exec(function.code, {})


@pytest.mark.parametrize(
    ("cell", "python"),
    [
        ("%x\ny = (1\n  % 2)\nz = 3 \\\n  % 2", "pass\ny = (1\n  % 2)\nz = 3 \\\n  % 2"),
        ("'''\n%x\n'''\n%x", "'''\n%x\n'''\npass"),
        ("# it's\n!ls 'a\ny = '%'", "# it's\npass\ny = '%'"),
        ("if y:\n    !ls \\\n  -l\nfit?", "if y:\n    pass\n\npass"),
        ("a, b = !ls \\\n  x\n%time c = 1", "a, b = None\n\nc = 1"),
        ("?fit\nfit??\n%time\n%run", "pass\npass\npass\npass"),
        ("%%time fit(1)\nx = 1", "\nx = 1"),
    ],
)
def test_a_magic_is_one_only_where_a_logical_line_begins(cell, python):
    """The numbers of lines stay the same."""
    assert plain(cell) == python
    assert python.count("\n") == cell.count("\n")


BLOCKS = """\
if first:
    x = 1
    if second:
        y = f(1)
        def a(): pass
    def b(): pass
    print(x)
elif third:
    def c(): pass
for k in fourth:
    def d(): pass
    print(k)
    break
else:
    def e(): pass
try:
    def f(): pass
    with fifth:
        g = 1
        print(g)
except ValueError:
    print(2)
    def h(): pass
"""


@pytest.mark.parametrize(
    ("failed", "reached"),
    [
        (1, [2, 5, 6, 9]),
        (2, [3, 6, 7]),
        (3, [5, 6, 7]),
        (4, [5, 6, 7]),
        (8, [9]),
        (9, []),
        (10, [11, 15]),
        (11, [12, 13, 15]),
        (15, []),
        (17, [18]),
        (18, [19]),
        (19, [20]),
        (22, [17, 19, 23]),
    ],
)
def test_what_a_failure_keeps_from_running(failed, reached):
    """The rest of its blocks; only definitions where it is unknown which block would have run."""
    found, _ = read(BLOCKS, "cell")
    index = next(k for k, s in enumerate(found) if s.parent < 0 and s.line <= failed <= s.last)
    assert lines(blocks.not_reached(found, index, failed), found) == reached


def test_what_a_passed_over_exception_may_have_skipped():
    """Neither a branch nor a handler runs without its condition."""
    found, _ = read(BLOCKS, "cell")
    several = [k for k, s in enumerate(found) if s.parent < 0]
    skipped = (k for index in several for k in blocks.unconditional_definitions(found, index))
    assert lines(skipped, found) == [17, 19]


def test_a_statement_that_means_nothing_outside_its_loop_does_nothing():
    """The cell itself may not contain it outside a loop."""
    found, _ = read(BLOCKS, "cell")
    (stop,) = (s for s in found if s.line == 13)
    assert not stop.uses | stop.defines
    with pytest.raises(SyntaxError):
        read("if True: break", "cell")
