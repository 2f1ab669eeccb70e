"""What a student handed in, in whatever state: its code cells, found without running anything."""

from __future__ import annotations

import ast
import hashlib
import json
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

MOST_BYTES = 20 << 20
PERCENT = re.compile(r"^# ?(?:%%|In\[[\d ]*\]).*$", re.MULTILINE)
MAGIC = re.compile(r"^(\s*)[%!?].*$", re.MULTILINE)


class Unreadable(ValueError):
    """A file is not what can be graded; the sentence says why."""


@dataclass(frozen=True)
class Submission:
    """A file that a student handed in.

    Parameters
    ----------
    student : str
        Who handed it in, by the roster or the name of the file.
    name : str
        The name under which it came.
    content : bytes
        The file.
    """

    student: str
    name: str
    content: bytes

    @property
    def digest(self) -> str:
        """SHA-256 of the file."""
        return hashlib.sha256(self.content).hexdigest()

    @cached_property
    def cells(self) -> tuple[str, ...]:
        """The code of its cells, in order.

        Raises
        ------
        Unreadable
            The file is no notebook and no Python.
        """
        if len(self.content) > MOST_BYTES:
            raise Unreadable(f"the file has more than {MOST_BYTES >> 20} MiB")
        if not self.content.strip():
            raise Unreadable("the file is empty")
        try:
            text = self.content.decode("utf-8-sig")
        except UnicodeDecodeError:
            raise Unreadable("the file is no text") from None
        if self.name.lower().endswith(".py"):
            return tuple(part for part in PERCENT.split(text) if part.strip())
        return _notebook_cells(text)

    @cached_property
    def definitions(self) -> Mapping[str, tuple[bool, ...]]:
        """For each function defined at top level: is it a stub, in the order of definitions."""
        found: dict[str, list[bool]] = {}
        for cell in self.cells:
            for name, function in _functions(cell):
                found.setdefault(name, []).append(is_stub(function))
        return {name: tuple(stubs) for name, stubs in found.items()}

    def notebook(self, functions: Mapping[str, Iterable[str]]) -> str:
        """Return which notebook this is, by the functions that it defines.

        Parameters
        ----------
        functions : mapping
            The functions that each notebook asks for.
        """
        shared = {n: len(set(asked) & set(self.definitions)) for n, asked in functions.items()}
        best = max(shared, key=lambda n: shared[n], default="")
        if not best or not shared[best]:
            raise Unreadable("it defines none of the functions that are asked for")
        return best


def _notebook_cells(text: str) -> tuple[str, ...]:
    try:
        data = json.loads(text)
    except (ValueError, RecursionError):
        raise Unreadable("the file is no complete notebook: its JSON is broken") from None
    cells = _cells(data)
    if cells is None:
        raise Unreadable("the file is no notebook: it has no cells")
    return tuple(code for cell in cells if (code := _code(cell)).strip())


def _cells(data: Any) -> list[Any] | None:
    """Return the cells of a notebook of format 4, or 3, where they are in worksheets."""
    if not isinstance(data, dict):
        return None
    cells = data.get("cells")
    sheets = data.get("worksheets")
    if not isinstance(cells, list) and isinstance(sheets, list):
        cells = []
        for sheet in sheets:
            inside = sheet.get("cells") if isinstance(sheet, dict) else None
            cells += inside if isinstance(inside, list) else []
    return cells if isinstance(cells, list) else None


def _code(cell: Any) -> str:
    """Return the code of a cell; nothing if it holds none."""
    if not isinstance(cell, dict) or cell.get("cell_type") != "code":
        return ""
    source = cell.get("source", cell.get("input", ""))
    if isinstance(source, list):
        return "".join(part for part in source if isinstance(part, str))
    return source if isinstance(source, str) else ""


def _functions(cell: str) -> list[tuple[str, ast.FunctionDef]]:
    try:
        tree = ast.parse(MAGIC.sub(r"\1pass", cell))
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return []
    return [(node.name, node) for node in tree.body if isinstance(node, ast.FunctionDef)]


def is_stub(function: ast.FunctionDef) -> bool:
    """Whether a function does nothing but say that it is not written."""
    body = function.body[1:] if ast.get_docstring(function) is not None else function.body
    return all(isinstance(node, ast.Pass | ast.Raise) or _is_ellipsis(node) for node in body)


def _is_ellipsis(node: ast.stmt) -> bool:
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
