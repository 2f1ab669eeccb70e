"""Build records: each step of a build stores the digests of its inputs and outputs.

The record is written last: after an interrupted build, the steps without a record are repeated.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any

from fieldrecon._core.atomic_files import write_atomically
from fieldrecon._core.digests import file_digest


def content_digest(path: Path) -> str:
    """Return the SHA-256 of a file's content, or an empty text if there is no file."""
    return file_digest(path) if path.is_file() else ""


def digests(paths: Iterable[Path], root: Path) -> dict[str, str]:
    """Return the SHA-256 of files by their path below a folder, sorted."""
    return {path.relative_to(root).as_posix(): file_digest(path) for path in sorted(paths)}


@dataclass(frozen=True)
class Steps:
    """The records of one build folder.

    Parameters
    ----------
    out : Path
        The build folder; the records are in ``out/.state``.
    """

    out: Path

    def done(self, step: str, key: str) -> bool:
        """Whether a step was done with this key, and its outputs still exist, unchanged."""
        try:
            note = self._read(step)
            made = {self.out / name: old for name, old in note["made"].items()}
            return (
                note["key"] == key
                and all(file_digest(p) == old for p, old in made.items())
                and all(content_digest(Path(p)) == old for p, old in note["read"].items())
            )
        except (OSError, ValueError):
            return False

    def made(self, step: str) -> set[Path]:
        """Return the output files of a recorded step."""
        return {self.out / name for name in self._read(step)["made"]}

    def record(
        self,
        step: str,
        key: str,
        made: Iterable[Path],
        read: Mapping[Path, str] = MappingProxyType({}),
    ) -> None:
        """Record a step: `made` are its outputs, `read` the digests of inputs not in the key.

        The digests of inputs are taken before the step reads them.
        """
        inputs = {str(path): content for path, content in read.items()}
        note = {"key": key, "made": digests(made, self.out), "read": inputs}
        write_atomically(self._note(step), json.dumps(note, indent=1).encode())

    def remove_others(self, step: str, made: Iterable[Path]) -> None:
        """Remove what a step made before, according to its record, and does not make now.

        Files that no step made stay, and folders with such files.
        """
        with suppress(OSError, ValueError):  # no record, or one that does not say what is whose
            _remove(self.made(step).difference(made))

    def keep_only(self, kind: str, steps: Iterable[str]) -> None:
        """Remove the outputs and the records of all other steps whose names begin with a kind.

        Files that no step made stay, and folders with such files.
        """
        wanted = {f"{kind}-{step}" for step in steps}
        for note in (self.out / ".state").glob(f"{kind}-*.json"):
            if note.stem not in wanted:
                with suppress(ValueError):  # a damaged record does not say what is whose
                    _remove(self.made(note.stem))
                note.unlink()

    def _read(self, step: str) -> Any:
        note = json.loads(self._note(step).read_text(encoding="utf-8"))
        if not isinstance(note, dict) or {"key", "made", "read"} - note.keys():
            raise ValueError(f"the record of {step} is damaged")
        return note

    def _note(self, step: str) -> Path:
        return self.out / ".state" / f"{step}.json"


def _remove(paths: Iterable[Path]) -> None:
    for path in paths:
        path.unlink(missing_ok=True)
        with suppress(OSError):  # there are other files
            path.parent.rmdir()
