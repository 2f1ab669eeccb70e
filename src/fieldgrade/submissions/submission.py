"""A submitted file, possibly damaged: its code cells and definitions, without running it."""

from __future__ import annotations

import json
import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from fieldgrade.submissions.definitions import defined, plain, statements
from fieldrecon._core.digests import bytes_digest, json_digest

MOST_BYTES = 20 << 20
MOST_CODE = 1 << 20
MARK = re.compile(r"^# ?(?:%%|In ?\[[\d ]*\]|<codecell>).*$", re.MULTILINE)
IDENTIFIER = re.compile(r"q-(\d\d)-\d+")
NUMBER = re.compile(r"(?<!\d)(\d\d)(?!\d)")


class Unreadable(ValueError):
    """A file cannot be graded; the message says why."""


@dataclass(frozen=True)
class Submission:
    """A file that a student submitted.

    Parameters
    ----------
    student : str
        The student, by the roster or the name of the file.
    name : str
        The name of the file.
    content : bytes
        The bytes of the file.
    """

    student: str
    name: str
    content: bytes

    @property
    def digest(self) -> str:
        """SHA-256 of the file."""
        return bytes_digest(self.content)

    @cached_property
    def text(self) -> str:
        """The file as text, with Python's line ends.

        Raises
        ------
        Unreadable
            It is not text.
        """
        if len(self.content) > MOST_BYTES:
            raise Unreadable(f"the file has more than {MOST_BYTES >> 20} MiB")
        if not self.content.strip():
            raise Unreadable("the file is empty")
        try:
            text = self.content.decode(_encoding(self.content))
        except UnicodeDecodeError:
            if not self.name.lower().endswith(".py"):
                raise Unreadable("the file is not text") from None
            text = self.content.decode("latin-1")
        return text.replace("\r\n", "\n").replace("\r", "\n")

    @property
    def is_script(self) -> bool:
        """Whether the file is a Python script rather than a notebook, which is JSON."""
        return self.name.lower().endswith(".py") and not self.text.lstrip().startswith("{")

    @cached_property
    def notebook_cells(self) -> tuple[Mapping[str, Any], ...]:
        """The cells of a notebook of format 4 or 3, whatever they contain; none for a script.

        Raises
        ------
        Unreadable
            The file is not a notebook.
        """
        if self.is_script:
            return ()
        cells = _cells(self._data)
        if cells is None:
            raise Unreadable("the file is not a notebook: it has no cells")
        return tuple(cell for cell in cells if isinstance(cell, dict))

    @cached_property
    def cells(self) -> tuple[str, ...]:
        """The code of its cells, in order, as Python.

        Raises
        ------
        Unreadable
            The file is neither a notebook nor Python, or contains too much code.
        """
        codes = _pieces(self.text) if self.is_script else map(_code, self.notebook_cells)
        found = [code for code in codes if code.strip()]
        if sum(map(len, found)) > MOST_CODE:
            raise Unreadable(f"it contains more than {MOST_CODE >> 20} MiB of code")
        return tuple(map(plain, found))

    @cached_property
    def code_digest(self) -> str:
        """SHA-256 of the code of all cells: any of them may bear on any answer."""
        return json_digest(*self.cells)

    @cached_property
    def definitions(self) -> Mapping[str, tuple[bool, ...]]:
        """For each name defined at top level: whether each of its definitions is a stub."""
        found: dict[str, list[bool]] = {}
        for cell in self.cells:
            for name, stub in defined(cell):
                found.setdefault(name, []).append(stub)
        return {name: tuple(stubs) for name, stubs in found.items()}

    def notebook(self, functions: Mapping[str, Iterable[str]]) -> str:
        """Return the number of the notebook, from the functions that it defines.

        If several or no notebooks match, the metadata decide, then the identifiers of cells; among
        several, then the name of the file.

        Parameters
        ----------
        functions : mapping
            The functions that each notebook asks for.

        Raises
        ------
        Unreadable
            The notebook cannot be identified.
        """
        shared = {n: len(set(asked) & set(self.definitions)) for n, asked in functions.items()}
        most = max(shared.values(), default=0)
        best = [number for number in functions if shared[number] == most]
        hints = [*self._handed_out(), *(NUMBER.findall(self.name) if most else ())]
        found = [number for number in hints if number in best] or (best if most else [])
        if not found:
            raise Unreadable("it defines none of the functions that are asked for")
        return found[0]

    def _handed_out(self) -> Iterator[str]:
        """Yield the number of the original notebook, from metadata and identifiers of cells."""
        if self.is_script:
            return
        metadata = self._data.get("metadata") if isinstance(self._data, dict) else None
        course = metadata.get("course") if isinstance(metadata, dict) else None
        source = course.get("source") if isinstance(course, dict) else None
        if isinstance(source, str):
            yield source[:2]
        identifiers = (cell.get("id") for cell in self.notebook_cells)
        names = (IDENTIFIER.match(found) for found in identifiers if isinstance(found, str))
        yield from (number for number, _ in Counter(n[1] for n in names if n).most_common())

    @cached_property
    def _data(self) -> Any:
        text = self.text
        try:
            return json.loads(text)
        except (ValueError, RecursionError):
            raise Unreadable("the file is not a complete notebook: its JSON is broken") from None


def source_of(cell: Mapping[str, Any]) -> str:
    """Return the source text of a cell."""
    source = cell.get("source", cell.get("input", ""))
    if isinstance(source, list):
        return "".join(part for part in source if isinstance(part, str))
    return source if isinstance(source, str) else ""


def _encoding(content: bytes) -> str:
    return "utf-16" if content.startswith((b"\xff\xfe", b"\xfe\xff")) else "utf-8-sig"


def _cells(data: Any) -> list[Any] | None:
    """Return the cells of a notebook of format 4, or of format 3, which has worksheets."""
    if not isinstance(data, dict):
        return None
    cells, sheets = data.get("cells"), data.get("worksheets")
    if not isinstance(cells, list) and isinstance(sheets, list):
        inside = [sheet.get("cells") for sheet in sheets if isinstance(sheet, dict)]
        return [cell for found in inside if isinstance(found, list) for cell in found]
    return cells if isinstance(cells, list) else None


def _code(cell: Mapping[str, Any]) -> str:
    """Return the code of a cell; empty if it is not a code cell."""
    return source_of(cell) if cell.get("cell_type") == "code" else ""


def _pieces(text: str) -> list[str]:
    """Split a script into the cells from which it was exported, or else into statements."""
    return MARK.split(text) if MARK.search(text) else statements(text)
