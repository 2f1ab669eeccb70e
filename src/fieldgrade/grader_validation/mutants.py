"""Mutants: small changes to a solution, which the checks must detect.

The usual tools for mutation testing restart the tests for each change. Here the syntax tree of a
function of a few lines is changed and judged in the same process, thousands of mutants in a minute.
"""

from __future__ import annotations

import ast
import copy
from collections.abc import Callable, Iterator

ARITHMETIC: dict[type[ast.operator], type[ast.operator]] = {
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.Div,
    ast.Div: ast.Mult,
    ast.Pow: ast.Mult,
    ast.MatMult: ast.Mult,
    ast.Mod: ast.Mult,
    ast.FloorDiv: ast.Mult,
}
COMPARISON: dict[type[ast.cmpop], type[ast.cmpop]] = {
    ast.Lt: ast.GtE,
    ast.LtE: ast.Gt,
    ast.Gt: ast.LtE,
    ast.GtE: ast.Lt,
    ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq,
}
LEFT_OUT = ("abs", "sqrt", "log", "exp", "square", "transpose", "unique", "sort", "argsort")
"""Functions that may be replaced by their argument."""

Change = Callable[[ast.AST], Iterator[ast.AST]]


def mutants(function: str) -> Iterator[tuple[str, str]]:
    r"""Yield the description and the code of each mutant of a function.

    Examples
    --------
    >>> for change, code in mutants("def f(x):\n    return x + 1"):
    ...     print(change, "->", code.splitlines()[1].strip())
    line 2: x + 1 becomes x - 1 -> return x - 1
    line 2: 1 becomes 2 -> return x + 2
    line 2: 1 becomes 0 -> return x + 0
    """
    tree = ast.parse(function)
    for index, node in enumerate(ast.walk(tree)):
        for other in _changes(node):
            changed = copy.deepcopy(tree)
            target = next(n for i, n in enumerate(ast.walk(changed)) if i == index)
            _Replace(target, other).visit(changed)
            code = ast.unparse(ast.fix_missing_locations(changed))
            line = getattr(node, "lineno", 0)
            yield f"line {line}: {_short(node)} becomes {_short(other)}", code


class _Replace(ast.NodeTransformer):
    def __init__(self, target: ast.AST, other: ast.AST) -> None:
        self.target, self.other = target, other

    def visit(self, node: ast.AST) -> ast.AST:
        return self.other if node is self.target else self.generic_visit(node)


def _changes(node: ast.AST) -> Iterator[ast.AST]:
    """Yield the replacements of a node."""
    node = copy.deepcopy(node)
    if isinstance(node, ast.BinOp) and type(node.op) in ARITHMETIC:
        yield ast.BinOp(node.left, ARITHMETIC[type(node.op)](), node.right)
    elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub | ast.Not | ast.Invert):
        yield node.operand
    elif isinstance(node, ast.Compare) and type(node.ops[0]) in COMPARISON:
        yield ast.Compare(node.left, [COMPARISON[type(node.ops[0])]()], node.comparators)
    elif isinstance(node, ast.Constant) and isinstance(node.value, bool):
        yield ast.Constant(not node.value)
    elif isinstance(node, ast.Constant) and isinstance(node.value, int | float):
        yield ast.Constant(node.value + 1)
        yield ast.Constant(node.value - 1)
    elif isinstance(node, ast.Attribute) and node.attr == "T":
        yield node.value
    elif isinstance(node, ast.Call):
        yield from _simpler_calls(node)
    elif isinstance(node, ast.AugAssign):
        yield ast.Pass()
        if type(node.op) in ARITHMETIC:
            yield ast.AugAssign(node.target, ARITHMETIC[type(node.op)](), node.value)


def _simpler_calls(node: ast.Call) -> Iterator[ast.AST]:
    name = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
    if name in LEFT_OUT and node.args:
        yield node.args[0]
    for i, keyword in enumerate(node.keywords):
        if keyword.arg in ("axis", "keepdims"):
            fewer = node.keywords[:i] + node.keywords[i + 1 :]
            yield ast.Call(node.func, node.args, fewer)


def _short(node: ast.AST) -> str:
    text = " ".join(ast.unparse(node).split())
    return text if len(text) <= 60 else text[:57] + "…"
