"""What was graded, when, by what and at what cost: a file of lines to which lines are added."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from fieldgrade.checking.results import Record


@dataclass(frozen=True)
class Ledger:
    """A file with a line of JSON for each submission that ran behind the walls.

    Nothing in it is ever changed. It names the year of the secret salt, never the salt.

    Parameters
    ----------
    file : Path
        It is made when something is noted.
    environment, grader : str
        Digests of the installed packages and of the grader.
    year : int
        For which the salt was made; 0 for the public one.
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
            What came of it, and what it took.
        checks : mapping
            The checks that were made, by question and name, with their digests.
        """
        told = {
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
        with self.file.open("ab", buffering=0) as file:  # one write, so that lines are never torn
            file.write(json.dumps(told).encode() + b"\n")
