"""The names that a code cell defines, from its syntax tree, without running it."""

from __future__ import annotations

import ast
import re
import threading
import warnings
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from functools import lru_cache
from io import StringIO

LOCK = threading.RLock()

MOST_PARSED = 256 << 10
"""Characters of a cell that are parsed at most: a syntax tree takes a thousand times as much memory
as its text."""
NO_PYTHON = re.compile(r"^([ \t]*)(?:[%!?].*|[\w.]+\?{1,2}[ \t]*)$", re.MULTILINE)
NO_VALUE = re.compile(r"^([ \t]*\w[\w, ]*=[ \t]*)[%!].*$", re.MULTILINE)
CELL_MAGIC = re.compile(r"\s*%%(\w*).*")
RUNS_IN_PLACE = ("time", "capture", "prun")


MOST_REMEMBERED, LONGEST_REMEMBERED = 1024, 32 << 10
"""Size of the cache, in cells and characters of a cell: most cells of a class are the same."""


@contextmanager
def suppress_warnings() -> Iterator[None]:
    """Neither show warnings nor turn them into errors in this block."""
    with LOCK, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield


def plain(cell: str) -> str:
    r"""Return a cell as plain Python: magics and shell commands are removed, line by line.

    Examples
    --------
    >>> plain("%matplotlib inline\nfiles = !ls\nx = 1"), plain("%%time\nx = 1"), plain("%%bash\nls")
    ('pass\nfiles = None\nx = 1', '\nx = 1', '')
    """
    magic = CELL_MAGIC.match(cell)
    if magic:
        cell = cell[magic.end() :] if magic[1] in RUNS_IN_PLACE else ""
    if outline(cell) is not None:
        return cell
    return NO_VALUE.sub(r"\1None", NO_PYTHON.sub(r"\1pass", cell))


def defined(cell: str) -> tuple[tuple[str, bool], ...]:
    r"""Return the names that a cell defines at top level, and whether each is a stub.

    Definitions inside ``if``, ``try``, ``with`` and loops count, in the order of the text.

    Examples
    --------
    >>> defined("try:\n    fit = lambda x: x\nexcept NameError:\n    def rank(points): ...")
    (('fit', False), ('rank', True))
    """
    return outline(cell) or ()


def outline(cell: str) -> tuple[tuple[str, bool], ...] | None:
    """Return the same as `defined`; None if the cell is not Python."""
    return (_remembered if len(cell) <= LONGEST_REMEMBERED else _outline)(cell)


def _outline(cell: str) -> tuple[tuple[str, bool], ...] | None:
    tree = _tree(cell)
    try:
        return tuple(_bound(tree.body)) if tree else None
    except RecursionError:
        return ()


_remembered = lru_cache(MOST_REMEMBERED)(_outline)


def statements(script: str) -> list[str]:
    r"""Split a script so that an error in one piece does not affect others; a function is a piece.

    Examples
    --------
    >>> statements("import numpy\nx = 1\ndef f():\n    return x\nf()")
    ['import numpy\nx = 1\n', 'def f():\n    return x\n', 'f()']
    """
    tree = _tree(script)
    if not tree:
        return [script]
    lines = StringIO(
        script
    ).readlines()  # str.splitlines also splits at line ends that Python does not have
    starts = {0} | {
        _first_line(node) - 1
        for before, node in zip(tree.body, tree.body[1:], strict=False)
        if _is_definition(before) or _is_definition(node)
    }
    ends = [*sorted(starts)[1:], len(lines)]
    return ["".join(lines[a:b]) for a, b in zip(sorted(starts), ends, strict=True)]


def is_stub(function: ast.FunctionDef | ast.AsyncFunctionDef) -> bool:
    """Whether a function does nothing, or raises NotImplementedError."""
    body = function.body[1:] if ast.get_docstring(function) is not None else function.body
    idle = all(isinstance(node, ast.Pass | ast.Raise) or _is_constant(node) for node in body)
    raised = (ast.dump(node) for node in body if isinstance(node, ast.Raise))
    return idle or any("NotImplementedError" in text for text in raised)


def _tree(code: str) -> ast.Module | None:
    """Return the syntax tree of code; None if it is not Python or is too long."""
    if len(code) > MOST_PARSED:
        return None
    try:
        with suppress_warnings():
            return ast.parse(code)
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return None


def _bound(nodes: Iterable[ast.AST]) -> Iterator[tuple[str, bool]]:
    for node in nodes:
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            yield node.name, is_stub(node)
        elif isinstance(node, ast.Assign):
            yield from ((t.id, False) for t in node.targets if isinstance(t, ast.Name))
        elif isinstance(node, ast.Import | ast.ImportFrom):
            yield from ((a.asname or a.name, False) for a in node.names)
        elif not isinstance(node, ast.ClassDef):
            for part in ("body", "handlers", "orelse", "finalbody"):
                inside = getattr(node, part, [])
                yield from _bound(inside if isinstance(inside, list) else [])


def _is_definition(node: ast.stmt) -> bool:
    return isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef)


def _first_line(node: ast.stmt) -> int:
    """Return the first line of a statement, decorators included."""
    return min([node.lineno, *(d.lineno for d in getattr(node, "decorator_list", []))])


def _is_constant(node: ast.stmt) -> bool:
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
