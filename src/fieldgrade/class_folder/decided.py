"""The folder of a class: what people write into tables, read together, and remembered.

What was decided when a class was graded is kept beside the results in ``decided.json``, so that it
can be told later which grades changed because somebody changed them.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TypeVar

from fieldgrade.class_folder.assignments import read_assignments
from fieldgrade.class_folder.decisions import Decisions
from fieldgrade.class_folder.late import read_extensions
from fieldgrade.class_folder.manual import read_marks
from fieldgrade.class_folder.overrides import Request, read_overrides, read_requests
from fieldrecon._core.atomic_files import write_atomically

T = TypeVar("T")

DECIDED = ("assignments.csv", "extensions.csv", "overrides.csv", "manual/*.csv")
"""The tables that have a say in grades after everything has been graded."""
MANUAL, MEMORY = "manual", "decided.json"


@dataclass(frozen=True)
class ClassFolder:
    """A folder with tables; each of them may be missing.

    Parameters
    ----------
    folder : Path
        It holds ``assignments.csv``, ``extensions.csv``, ``overrides.csv``, ``requests.csv`` and
        ``manual/``.
    """

    folder: Path

    def decisions(self) -> Decisions:
        """Return what people decided.

        Raises
        ------
        ValueError
            All that is wrong with one of the tables, line by line.
        """
        return Decisions(
            self._read("assignments.csv", read_assignments, {}),
            self._read("extensions.csv", read_extensions, {}),
            read_marks(self.folder / MANUAL),
            self._read("overrides.csv", read_overrides, []),
        )

    def requests(self) -> list[Request]:
        """Return what students asked to be looked at again."""
        return self._read("requests.csv", read_requests, [])

    def _read(self, name: str, read: Callable[[Path], T], otherwise: T) -> T:
        file = self.folder / name
        return read(file) if file.is_file() else otherwise

    def texts(self) -> dict[str, str]:
        """Return the tables that have a say in grades, as they are."""
        found = (file for pattern in DECIDED for file in sorted(self.folder.glob(pattern)))
        return {
            file.relative_to(self.folder).as_posix(): file.read_text("utf-8-sig", "replace")
            for file in found
        }


def remember(out: Path, folder: ClassFolder) -> None:
    """Keep what is decided beside the results; call it when they have been written.

    What was remembered before goes to ``history/``, to the results of then.
    """
    file = out / MEMORY
    text = json.dumps(folder.texts(), indent=1) + "\n"
    if file.is_file():
        if file.read_text(encoding="utf-8") == text and not _unremembered(out):
            return
        for earlier in _unremembered(out):
            write_atomically(earlier, file.read_bytes())
    write_atomically(file, text.encode())


def remembered(results: Path) -> Decisions | None:
    """Return what was decided when results were written; None if nobody remembers."""
    file = _memory_of(results)
    if results.name == "results.json":
        file = results.parent / MEMORY
    elif not file.is_file():  # replaced by a run that has not been remembered yet
        file = results.parent.parent / MEMORY
    if not file.is_file():
        return None
    texts: Mapping[str, str] = json.loads(file.read_text(encoding="utf-8"))
    with TemporaryDirectory() as folder:
        for name, text in texts.items():
            write_atomically(Path(folder) / name, text.encode())
        return ClassFolder(Path(folder)).decisions()


def _unremembered(out: Path) -> list[Path]:
    """Return where it should stand what was decided for earlier results, and does not."""
    earlier = sorted((out / "history").glob("[0-9][0-9][0-9][0-9].json"))
    return [m for m in map(_memory_of, earlier) if not m.is_file()]


def _memory_of(results: Path) -> Path:
    return results.with_name(f"{results.stem}-{MEMORY}")
