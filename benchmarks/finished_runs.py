"""Finished runs of a long comparison in a file, so that it goes on where it was interrupted."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import Any

from benchmarks.machine import describe

ROOT = Path(__file__).parents[1]


class FinishedRuns:
    """Results by name, one line for each; lines of another machine or of other code do not count.

    Parameters
    ----------
    path : pathlib.Path, optional
        The file, which `forget` deletes when the comparison is complete; without it nothing is
        kept for later.
    code : pathlib.Path
        The folder whose Python files are measured.
    """

    def __init__(self, path: Path | None, code: Path = ROOT / "src" / "fieldrecon") -> None:
        self._path = path
        self._mark = _fingerprint(code)
        text = path.read_text(encoding="utf-8") if path and path.exists() else ""
        records = map(json.loads, text.splitlines())
        self._found = {r["name"]: r["result"] for r in records if r["mark"] == self._mark}

    def get(self, name: str) -> Any:
        """The result of this name, or None."""
        return self._found.get(name)

    def add(self, name: str, result: Any) -> None:
        """Keep a result, which is written at once."""
        self._found[name] = result
        if self._path is None:
            return
        self._path.parent.mkdir(parents=True, exist_ok=True)
        record = {"mark": self._mark, "name": name, "result": result}
        with self._path.open("a", encoding="utf-8") as file:
            file.write(json.dumps(record, ensure_ascii=False) + "\n")

    def forget(self) -> None:
        """Delete the file."""
        if self._path:
            self._path.unlink(missing_ok=True)


def _fingerprint(code: Path) -> str:
    """A digest of the machine, the versions of the packages, and the measured code."""
    digest = hashlib.sha256(json.dumps(describe(), sort_keys=True).encode())
    for path in sorted(code.rglob("*.py")):
        digest.update(path.relative_to(code).as_posix().encode() + path.read_bytes())
    return digest.hexdigest()
