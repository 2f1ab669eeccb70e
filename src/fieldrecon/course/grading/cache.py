"""What was found before, kept by what it depends on: the answer, the check, the surroundings.

A finding is a file whose name is the digest of all that it depends on. So nothing in it can be out
of date, a run that was killed goes on where it stopped, and after a change to one check only that
check is made again.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import get_args

from fieldcheck.seeds import seed
from fieldcheck.verdict import Rung, Verdict
from fieldrecon._whole_file import write_atomically
from fieldrecon.course.grading.examine import code_digest
from fieldrecon.course.grading.findings import Finding
from fieldrecon.course.grading.fingerprint import environment, grader
from fieldrecon.course.grading.isolation import Server
from fieldrecon.course.grading.submission import Submission
from fieldrecon.course.grading.trusted import Course


def keys(
    course: Course, server: Server, submission: Submission, question: str
) -> dict[str, str]:
    """Return the digests of all that the findings on an answer depend on, check by check."""
    around = (
        code_digest(submission), question, environment(), grader(),
        seed(submission.student, question, course.salt), server.tier, asdict(server.limits),
    )  # fmt: skip
    return {
        check: hashlib.sha256(json.dumps((*around, check, made_by)).encode()).hexdigest()
        for check, made_by in course.checks(question).items()
    }


@dataclass(frozen=True)
class Cache:
    """Findings in a folder.

    Parameters
    ----------
    folder : Path
        It is made when something is kept.
    """

    folder: Path

    def get(self, name: str) -> Finding | None:
        """Return a finding; None if there is none, or what is there cannot be read."""
        try:
            data = json.loads(self._file(name).read_text(encoding="utf-8"))
            verdict = Verdict(**data["verdict"])
            errors = tuple((int(n), str(text)) for n, text in data["cell_errors"])
            broke, returned = tuple(map(str, data["broke"])), tuple(data["returned"])
            found = Finding(verdict, str(data["check"]), broke, errors, returned)
        except (OSError, ValueError, KeyError, TypeError):
            return None
        return found if verdict.rung in get_args(Rung) else None

    def known(self, keys: Mapping[str, str]) -> dict[str, Finding]:
        """Return what is known of an answer, by check."""
        found = {check: self.get(name) for check, name in keys.items()}
        return {check: finding for check, finding in found.items() if finding}

    def put(self, name: str, finding: Finding) -> None:
        """Keep a finding."""
        write_atomically(self._file(name), json.dumps(asdict(finding)).encode(), sync=False)

    def _file(self, name: str) -> Path:
        return self.folder / name[:2] / f"{name}.json"
