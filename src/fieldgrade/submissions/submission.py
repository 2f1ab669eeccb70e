"""A submitted file, possibly damaged: its code cells and definitions, without running it."""

from __future__ import annotations

import json
import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

from fieldgrade.submissions.definitions import defined, plain
from fieldgrade.submissions.notebook_json import MOST_BYTES, without_outputs
from fieldrecon._core.digests import bytes_digest, json_digest

MOST_RECEIVED = 64 << 20
"""Bytes of a file with outputs, which are left out before it is parsed."""
MOST_CODE = 1 << 20
MARK = re.compile(r"^# ?(?:%%|In ?\[[\d ]*\]|<codecell>).*$", re.MULTILINE)
IDENTIFIER = re.compile(r"q-(\d\d)-\d+")
DEFINITION = re.compile(r"(?:^|['\"]|\\n)(?:async )?def[ \t]+(\w+)", re.MULTILINE)
"""A function at the beginning of a line, also of a line in a text that is executed."""
IMPORT = re.compile(r"^[ \t]*(?:from|import)[ \t]+([\w., \t]+)", re.MULTILINE)
NUMBER = re.compile(r"(?<!\d)(\d\d)(?!\d)")
PARSED = ("digest", "is_script", "sources", "code_digest")
"""What remains of a submission without its file."""


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
    helpers : tuple of (str, bytes or Path), optional
        Paths and contents of the files beside it, which its code can import or read. The content
        may be the path of a file in the archive, which is read when the submission runs.
    """

    student: str
    name: str
    content: bytes
    helpers: tuple[tuple[str, bytes | Path], ...] = ()

    def parsed(self) -> Submission:
        """Return the submission without its file: with its code, and the digest of the file.

        Only this is kept while it is graded, and sent to other processes.

        Raises
        ------
        Unreadable
            The file cannot be graded.
        """
        code = replace(self, content=b"")
        vars(code).update({name: getattr(self, name) for name in PARSED})
        return code

    @cached_property
    def digest(self) -> str:
        """SHA-256 of the file."""
        return bytes_digest(self.content)

    def files(self) -> Iterator[tuple[str, bytes]]:
        """Yield the paths and the contents of the files beside it."""
        for name, content in self.helpers:
            yield name, content.read_bytes() if isinstance(content, Path) else content

    @property
    def text(self) -> str:
        """The file as text, with Python's line ends; a notebook without its outputs.

        Raises
        ------
        Unreadable
            It is not text, or exceeds a limit.
        """
        if not self.content or self.content.isspace():
            raise Unreadable("the file is empty")
        try:
            text = self._bytes().decode("utf-8-sig")
        except UnicodeDecodeError:
            if not self.name.lower().endswith(".py"):
                raise Unreadable("the file is not text") from None
            text = self.content.decode("latin-1")
        return text.replace("\r\n", "\n").replace("\r", "\n")

    def _bytes(self) -> bytes:
        """Return the file in UTF-8; a notebook without its outputs."""
        limit = MOST_BYTES if self.is_script or self._is_utf16 else MOST_RECEIVED
        if len(self.content) > limit:
            raise Unreadable(f"the file has more than {limit >> 20} MiB")
        content = self.content.decode("utf-16").encode() if self._is_utf16 else self.content
        if self.is_script:
            return content
        try:
            return without_outputs(content)
        except ValueError as error:
            raise Unreadable(f"the file is not a notebook: {error}") from None

    @property
    def _is_utf16(self) -> bool:
        return self.content.startswith((b"\xff\xfe", b"\xfe\xff"))

    @cached_property
    def is_script(self) -> bool:
        """Whether the file is a Python script rather than a notebook, which is JSON."""
        start = self.content[:4096].lstrip(b"\xef\xbb\xbf\xff\xfe\0 \t\r\n")
        return self.name.lower().endswith(".py") and not start.startswith(b"{")

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
    def sources(self) -> tuple[str, ...]:
        """The code of its cells, in order, as it was submitted.

        Raises
        ------
        Unreadable
            The file is neither a notebook nor Python, or contains too much code.
        """
        codes = MARK.split(self.text) if self.is_script else map(_code, self.notebook_cells)
        found = tuple(code for code in codes if code.strip())
        if sum(map(len, found)) > MOST_CODE:
            raise Unreadable(f"it contains more than {MOST_CODE >> 20} MiB of code")
        return found

    @cached_property
    def cells(self) -> tuple[str, ...]:
        """The code of its cells, in order, as plain Python."""
        return tuple(map(plain, self.sources))

    @cached_property
    def code_digest(self) -> str:
        """SHA-256 of the code of all cells and helpers: any of them may bear on any answer."""
        helpers = [(name, bytes_digest(content)) for name, content in self.files()]
        return json_digest(*self.sources, *([helpers] if helpers else []))

    @cached_property
    def definitions(self) -> Mapping[str, tuple[bool, ...]]:
        """For each name defined at top level: whether each of its definitions is a stub."""
        found: dict[str, list[bool]] = {}
        for cell in self.cells:
            for name, stub in defined(cell):
                found.setdefault(name, []).append(stub)
        return {name: tuple(stubs) for name, stubs in found.items()}

    @cached_property
    def definitions_in_text(self) -> frozenset[str]:
        """The names after ``def`` at the beginning of lines, also of cells that are not Python."""
        return frozenset(name for code in self.sources for name in DEFINITION.findall(code))

    @cached_property
    def imported(self) -> frozenset[str]:
        """The words after ``import`` and ``from``: names of modules, and others."""
        found = (words for code in self.sources for words in IMPORT.findall(code))
        return frozenset(word for words in found for word in re.findall(r"\w+", words))

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
        for names in (set(self.definitions), self.definitions_in_text):
            shared = {n: len(set(asked) & names) for n, asked in functions.items()}
            most = max(shared.values(), default=0)
            if most:
                break
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
