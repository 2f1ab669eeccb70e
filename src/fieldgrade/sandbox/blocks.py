"""The statements of blocks that a failure keeps from running, though they could stand alone."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Sequence
from itertools import takewhile

from fieldgrade.sandbox.statements import Statement

ALWAYS_ENTERED = (ast.Try, ast.TryStar, ast.With, ast.AsyncWith)
CONTINUED_IN = {"body": ("body", "orelse")}
"""The blocks in which a statement other than ``if`` continues after a line of a block."""


def not_reached(found: Sequence[Statement], index: int, line: int) -> Iterator[int]:
    """Yield the statements that would have run if a line of a statement had not failed.

    Parameters
    ----------
    found : sequence of Statement
        The statements of a cell, each followed by those of its blocks.
    index : int
        The index of the statement that failed.
    line : int
        The line that failed. If it is in none of the blocks, such as the condition of ``if``, it is
        unknown which of them would have run: only the definitions in them are found.
    """
    inner = _inner(found, index)
    failed = next((k for k in inner if found[k].line <= line <= found[k].last), None)
    if failed is None:
        yield from definitions(found, index)
        return
    block = found[failed].block
    may_skip = isinstance(found[index].node, ast.If | ast.Match)
    run = (block,) if may_skip else CONTINUED_IN.get(block, (block,))
    yield from not_reached(found, failed, line) if _inner(found, failed) else ()
    yield from (k for k in inner if k > failed and found[k].block in run)
    if block.startswith("handlers"):
        yield from unconditional_definitions(found, index)


def definitions(found: Sequence[Statement], index: int) -> Iterator[int]:
    """Yield the definitions in the blocks of a statement, except in handlers of exceptions."""
    for k in _inner(found, index):
        if found[k].block.startswith("handlers"):
            continue
        yield from (k,) if found[k].is_definition else definitions(found, k)


def unconditional_definitions(found: Sequence[Statement], index: int) -> Iterator[int]:
    """Yield the definitions of ``try`` and ``with`` that run unless an exception skips them."""
    if not isinstance(found[index].node, ALWAYS_ENTERED):
        return
    for k in _inner(found, index):
        if found[k].block == "body":
            yield from (k,) if found[k].is_definition else unconditional_definitions(found, k)


def inside(found: Sequence[Statement], index: int) -> Iterator[Statement]:
    """Yield the statements in the blocks of a statement, and in their blocks."""
    after = (found[k] for k in range(index + 1, len(found)))
    return takewhile(lambda statement: statement.parent >= index, after)


def _inner(found: Sequence[Statement], index: int) -> list[int]:
    """Return the indices of the statements in the blocks of a statement."""
    count = sum(1 for _ in inside(found, index))
    return [k for k in range(index + 1, index + 1 + count) if found[k].parent == index]
