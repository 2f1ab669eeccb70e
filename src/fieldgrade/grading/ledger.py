"""The log of grading: which checks ran, when, with which grader and at what cost."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from fieldgrade.checking.results import Record


@dataclass(frozen=True)
class Ledger:
    """A file with a line of JSON for each submission that ran in the sandbox.

    Lines are never changed. It names the year of the secret salt, never the salt.

    Parameters
    ----------
    file : Path
        The file; it is created when it is needed.
    environment, grader : str
        Digests of the installed packages and of the grader.
    year : int
        The year of the secret salt; 0 for the public one.
    """

    file: Path
    environment: str
    grader: str
    year: int

    def note(self, record: Record, checks: Mapping[str, Mapping[str, str]]) -> None:
        """Add a line for a submission.

        Parameters
        ----------
        record : Record
            The record, with measurements.
        checks : mapping
            The digests of the checks that ran, by question and name.
        """
        entry = {
            "on": datetime.now(UTC).isoformat(timespec="seconds"),
            "student": record.student,
            "file": record.file,
            "digest": record.digest,
            "code": record.code,
            "notebook": record.notebook,
            "status": record.status,
            "made_by": checks,
            "environment": self.environment,
            "grader": self.grader,
            "salt_year": self.year,
            "tier": record.tier,
            "seconds": round(record.seconds, 4),
            "cpu_seconds": round(record.cpu_seconds, 4),
            "peak_bytes": record.peak,
        }
        self.file.parent.mkdir(parents=True, exist_ok=True)
        with self.file.open(
            "ab", buffering=0
        ) as file:  # one write, so that concurrent lines do not mix
            file.write(json.dumps(entry).encode() + b"\n")
