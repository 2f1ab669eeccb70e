"""The names that a code cell defines, from its syntax tree, without running it."""

from __future__ import annotations

import ast
import threading
import warnings
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from functools import lru_cache

from fieldgrade.sandbox import notebook_code
from fieldgrade.sandbox.statements import is_idle, raises_not_implemented

LOCK = threading.RLock()

MOST_PARSED = 256 << 10
"""Characters of a cell that are parsed at most: a syntax tree takes a thousand times as much memory
as its text."""
MOST_REMEMBERED, LONGEST_REMEMBERED = 1024, 32 << 10
"""Size of the cache, in cells and characters of a cell: most cells of a class are the same."""


@contextmanager
def suppress_warnings() -> Iterator[None]:
    """Neither show warnings nor turn them into errors in this block."""
    with LOCK, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield


def plain(cell: str) -> str:
    """Return a cell as plain Python; a cell that is too long to be parsed is unchanged."""
    if len(cell) > MOST_PARSED:
        return cell
    with suppress_warnings():
        return (_plain if len(cell) <= LONGEST_REMEMBERED else notebook_code.plain)(cell)


_plain = lru_cache(MOST_REMEMBERED)(notebook_code.plain)


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
    return tuple(_bound(tree.body)) if tree else None


_remembered = lru_cache(MOST_REMEMBERED)(_outline)


def is_stub(function: ast.FunctionDef | ast.AsyncFunctionDef) -> bool:
    """Whether a function does nothing, or raises NotImplementedError."""
    body = function.body
    if all(isinstance(node, ast.Raise) or is_idle(node) for node in body):
        return True
    returns = any(isinstance(node, ast.Return) for node in body)
    return not returns and any(map(raises_not_implemented, body))


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
    """Yield the names bound by nodes and the nodes inside, except in functions and classes."""
    left = [*nodes][::-1]
    while left:
        node = left.pop()
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            yield node.name, is_stub(node)
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            yield node.id, False
        elif isinstance(node, ast.Import | ast.ImportFrom):
            yield from ((a.asname or a.name, False) for a in node.names)
        elif not isinstance(node, ast.ClassDef | ast.Lambda):
            left += [*ast.iter_child_nodes(node)][::-1]
