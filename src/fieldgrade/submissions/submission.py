"""What a student handed in, in whatever state: its code cells, found without running anything."""

from __future__ import annotations

import hashlib
import json
import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from fieldgrade.submissions.definitions import defined, plain, statements

MOST_BYTES = 20 << 20
MOST_CODE = 1 << 20
MARK = re.compile(r"^# ?(?:%%|In ?\[[\d ]*\]|<codecell>).*$", re.MULTILINE)
IDENTIFIER = re.compile(r"q-(\d\d)-\d+")
NUMBER = re.compile(r"(?<!\d)(\d\d)(?!\d)")


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
    def text(self) -> str:
        """The file as text, with the ends of lines that Python has.

        Raises
        ------
        Unreadable
            It is none.
        """
        if len(self.content) > MOST_BYTES:
            raise Unreadable(f"the file has more than {MOST_BYTES >> 20} MiB")
        if not self.content.strip():
            raise Unreadable("the file is empty")
        try:
            text = self.content.decode(_encoding(self.content))
        except UnicodeDecodeError:
            if not self.name.lower().endswith(".py"):
                raise Unreadable("the file is no text") from None
            text = self.content.decode("latin-1")
        return text.replace("\r\n", "\n").replace("\r", "\n")

    @property
    def is_script(self) -> bool:
        """Whether it is Python rather than a notebook, which is JSON."""
        return self.name.lower().endswith(".py") and not self.text.lstrip().startswith("{")

    @cached_property
    def notebook_cells(self) -> tuple[Mapping[str, Any], ...]:
        """The cells of a notebook of format 4 or 3, whatever is in them; none of a script.

        Raises
        ------
        Unreadable
            The file is no notebook.
        """
        if self.is_script:
            return ()
        cells = _cells(self._data)
        if cells is None:
            raise Unreadable("the file is no notebook: it has no cells")
        return tuple(cell for cell in cells if isinstance(cell, dict))

    @cached_property
    def cells(self) -> tuple[str, ...]:
        """The code of its cells, in order, as Python.

        Raises
        ------
        Unreadable
            The file is no notebook and no Python, or there is more code than a person writes.
        """
        codes = _pieces(self.text) if self.is_script else map(_code, self.notebook_cells)
        found = [code for code in codes if code.strip()]
        if sum(map(len, found)) > MOST_CODE:
            raise Unreadable(f"there is more than {MOST_CODE >> 20} MiB of code in it")
        return tuple(map(plain, found))

    @cached_property
    def definitions(self) -> Mapping[str, tuple[bool, ...]]:
        """For each name defined at top level: is it a stub, in the order of definitions."""
        found: dict[str, list[bool]] = {}
        for cell in self.cells:
            for name, stub in defined(cell):
                found.setdefault(name, []).append(stub)
        return {name: tuple(stubs) for name, stubs in found.items()}

    def notebook(self, functions: Mapping[str, Iterable[str]]) -> str:
        """Return which notebook this is, by the functions that it defines.

        Where that leaves several, or there is none, what was handed out may still say it: the
        metadata, then the identifiers of cells. Between several even the file's name counts.

        Parameters
        ----------
        functions : mapping
            The functions that each notebook asks for.

        Raises
        ------
        Unreadable
            Nothing tells.
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
        """Yield which notebook this was made from, by the signs that are left of it."""
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
            raise Unreadable("the file is no complete notebook: its JSON is broken") from None


def source_of(cell: Mapping[str, Any]) -> str:
    """Return what stands in a cell of a notebook."""
    source = cell.get("source", cell.get("input", ""))
    if isinstance(source, list):
        return "".join(part for part in source if isinstance(part, str))
    return source if isinstance(source, str) else ""


def _encoding(content: bytes) -> str:
    return "utf-16" if content.startswith((b"\xff\xfe", b"\xfe\xff")) else "utf-8-sig"


def _cells(data: Any) -> list[Any] | None:
    """Return the cells of a notebook of format 4, or 3, where they are in worksheets."""
    if not isinstance(data, dict):
        return None
    cells, sheets = data.get("cells"), data.get("worksheets")
    if not isinstance(cells, list) and isinstance(sheets, list):
        inside = [sheet.get("cells") for sheet in sheets if isinstance(sheet, dict)]
        return [cell for found in inside if isinstance(found, list) for cell in found]
    return cells if isinstance(cells, list) else None


def _code(cell: Mapping[str, Any]) -> str:
    """Return the code of a cell; nothing if it holds none."""
    return source_of(cell) if cell.get("cell_type") == "code" else ""


def _pieces(text: str) -> list[str]:
    """Return a script in the cells from which it was exported, or else in statements."""
    return MARK.split(text) if MARK.search(text) else statements(text)
