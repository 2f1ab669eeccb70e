"""The statements of a cell: compiled one by one, with the names that they use and define."""

from __future__ import annotations

import ast
import dis
import warnings
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from types import CodeType

from fieldgrade.sandbox.notebook_code import plain

MOST_REPORTED = 20_000
"""How many statements of a cell are reported, at most, when they begin to run."""
MOST_BLOCKS = 4
"""How many blocks deep statements are distinguished."""
NO_DEFINITION = -1
"""Stands for all statements of a cell that are not definitions."""
FUTURES = 0x1FE0000
"""The flags of ``from __future__ import …``, which hold for all statements that follow."""
DEFINITIONS = (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef, ast.Import, ast.ImportFrom)
INDIRECT = frozenset(("exec", "eval", "globals", "locals", "vars", "setattr", "get_ipython"))
"""Functions that can define a name which the code does not show."""


@dataclass
class Statement:
    """A statement of a cell, or of a block in it.

    Parameters
    ----------
    compiled : callable
        Returns the compiled statement.
    line : int
        Its first line in the cell.
    node : ast.stmt, optional
        Its syntax tree; None if this is a whole cell that is too deep for a tree.
    parent : int
        The index of the statement in whose block it stands; -1 if it stands in none.
    block : str
        The name of this block, such as ``"body"``.
    """

    compiled: Callable[[], CodeType]
    line: int
    node: ast.stmt | None = None
    parent: int = -1
    block: str = ""

    @cached_property
    def code(self) -> CodeType:
        """The compiled statement."""
        return self.compiled()

    @property
    def last(self) -> int:
        """Its last line in the cell."""
        return (self.node.end_lineno if self.node else None) or self.line

    @cached_property
    def uses(self) -> frozenset[str]:
        """The global names that it reads, also those in its functions."""
        return frozenset(name for op, name in _names(self.code) if op.startswith("LOAD"))

    @cached_property
    def defines(self) -> frozenset[str]:
        """The global names that it binds, or whose values it may change."""
        bound = {name for op, name in _names(self.code) if op.startswith("STORE")}
        return frozenset(bound | {*_changed(self.node)})

    @property
    def is_definition(self) -> bool:
        """Whether it defines functions, imports, or assigns constants: it runs in any order."""
        if isinstance(self.node, DEFINITIONS):
            return True
        if not isinstance(self.node, ast.Assign | ast.AnnAssign) or self.node.value is None:
            return False
        value = self.node.value
        calls = any(isinstance(part, ast.Call | ast.Await) for part in ast.walk(value))
        return isinstance(value, ast.Lambda) or not calls

    @property
    def is_function(self) -> bool:
        """Whether it defines a function or a class."""
        value = self.node.value if isinstance(self.node, ast.Assign) else self.node
        return isinstance(value, (*DEFINITIONS[:3], ast.Lambda))

    @property
    def stops(self) -> bool:
        """Whether it can only stop the cell: ``raise`` or ``assert``."""
        return isinstance(self.node, ast.Raise | ast.Assert)

    @property
    def imports_all(self) -> bool:
        """Whether it is ``from … import *``."""
        return isinstance(self.node, ast.ImportFrom) and self.node.names[0].name == "*"

    @property
    def stub(self) -> str:
        """The name of the function that it defines if this is not written yet; else empty."""
        node = self.node
        if not isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            return ""
        *before, last = node.body
        return node.name if raises_not_implemented(last) and all(map(is_idle, before)) else ""


def read(cell: str, name: str, flags: int = 0) -> tuple[list[Statement], int]:
    """Compile the statements of a cell.

    Parameters
    ----------
    cell : str
        The code of the cell.
    name : str
        The name of the cell, which error messages show.
    flags : int
        The flags of the imports from ``__future__`` in earlier cells.

    Returns
    -------
    statements : list of Statement
        An import of several names is several statements. A statement is followed by those of its
        blocks, which run only if a failure has kept them from running. If the syntax tree would be
        too deep, the whole cell is one statement.
    flags : int
        The flags that hold for later cells.

    Raises
    ------
    SyntaxError, ValueError, RecursionError, MemoryError
        The cell cannot be compiled.
    """
    with quiet():
        code = plain(cell)
        try:
            return _separate(ast.parse(code).body, name, flags)
        except (RecursionError, MemoryError):
            whole = _compiled(code, name, flags)
            return [Statement(lambda: whole, 1)], flags


def _separate(nodes: Iterable[ast.stmt], name: str, flags: int) -> tuple[list[Statement], int]:
    found: list[Statement] = []
    for node in _single(nodes):
        statement = _statement(node, name, flags)
        flags |= statement.code.co_flags & FUTURES
        found.append(statement)
        _add_blocks(found, name, flags, 1)
    return found, flags


def _add_blocks(found: list[Statement], name: str, flags: int, depth: int) -> None:
    """Append the statements in the blocks of the last statement."""
    parent, node = len(found) - 1, found[-1].node
    for block, inside in inner_blocks(node) if depth <= MOST_BLOCKS else ():
        for inner in _single(inside):
            found.append(_statement(inner, name, flags, parent, block))
            _add_blocks(found, name, flags, depth + 1)


def inner_blocks(node: ast.stmt | None) -> Iterator[tuple[str, list[ast.stmt]]]:
    """Yield the names and the statements of the blocks of ``if``, ``try``, ``with`` and loops."""
    if node is None or isinstance(node, DEFINITIONS):
        return
    for block in ("body", "orelse", "finalbody"):
        yield block, getattr(node, block, [])
    for several in ("handlers", "cases"):
        for number, part in enumerate(getattr(node, several, [])):
            yield f"{several} {number}", part.body


def _statement(
    node: ast.stmt, name: str, flags: int, parent: int = -1, block: str = ""
) -> Statement:
    def compiled() -> CodeType:
        try:
            return _compiled(ast.Module([node], []), name, flags)
        except SyntaxError:
            if parent < 0:
                raise
            return _compiled("", name, flags)  # ``break`` has no meaning outside its loop

    first = min([node.lineno, *(d.lineno for d in getattr(node, "decorator_list", []))])
    return Statement(compiled, first, node, parent, block)


@contextmanager
def quiet() -> Iterator[None]:
    """Ignore warnings in this block; the code may have turned them into errors."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield


def needed(asked: Iterable[str], statements: Sequence[Statement]) -> set[int]:
    """Return the indices of the statements on which the definitions of some names depend."""
    names, found, size = {*asked}, set[int](), -1
    imported = {n for s in statements if isinstance(s.node, DEFINITIONS[3:]) for n in s.defines}
    while len(found) > size:
        size = len(found)
        for index, statement in enumerate(statements):
            if index in found:
                continue
            defines = statement.defines
            if isinstance(statement.node, ast.Expr):
                defines -= imported
            if (
                statement.node is None
                or statement.imports_all
                or defines & names
                or (statement.uses & INDIRECT)
            ):
                found.add(index)
                names |= statement.uses
    return found


def raises_not_implemented(node: ast.stmt) -> bool:
    """Whether a statement is ``raise NotImplementedError``, as in the functions handed out."""
    raised = node.exc if isinstance(node, ast.Raise) else None
    raised = raised.func if isinstance(raised, ast.Call) else raised
    return isinstance(raised, ast.Name) and raised.id == "NotImplementedError"


def is_idle(node: ast.stmt) -> bool:
    """Whether a statement does nothing, such as a docstring."""
    constant = isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
    return constant or isinstance(node, ast.Pass)


def _compiled(code: str | ast.Module, name: str, flags: int) -> CodeType:
    flags |= ast.PyCF_ALLOW_TOP_LEVEL_AWAIT
    return compile(code, name, "exec", flags, dont_inherit=True)


def _single(nodes: Iterable[ast.stmt]) -> Iterator[ast.stmt]:
    """Yield statements; an import of several names is one for each, since one may fail."""
    for node in nodes:
        if isinstance(node, ast.Import):
            yield from (ast.copy_location(ast.Import([alias]), node) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield from (
                ast.copy_location(ast.ImportFrom(node.module, [alias], node.level), node)
                for alias in node.names
            )
        else:
            yield node


def _names(code: CodeType) -> Iterator[tuple[str, str]]:
    """Yield the operations on global names, also those in functions."""
    codes = [code]
    while codes:
        code = codes.pop()
        codes += [c for c in code.co_consts if isinstance(c, CodeType)]
        for step in dis.get_instructions(code):
            if step.opname.endswith(("_NAME", "_GLOBAL", "_GLOBALS")) and isinstance(
                step.argval, str
            ):
                yield step.opname, step.argval


def _changed(node: ast.stmt | None) -> Iterator[str]:
    """Yield the names whose values a statement may change: ``x`` for ``x[0] = 1``, ``x.add(1)``."""
    targets: list[ast.expr] = []
    if isinstance(node, ast.Assign | ast.Delete):
        targets = [*node.targets]
    elif isinstance(node, ast.AugAssign):
        targets = [node.target]
    elif isinstance(node, ast.Expr) and isinstance(node.value, ast.Call):
        targets = [node.value.func]
    for target in targets:
        inner: ast.expr = target
        while isinstance(inner, ast.Subscript | ast.Attribute):
            inner = inner.value
        if isinstance(inner, ast.Name) and inner is not target:
            yield inner.id
