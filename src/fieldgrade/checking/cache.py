"""What was found before, kept by what it depends on: the answer, the check, the surroundings.

The name of a finding is the digest of all that it depends on. So nothing that is kept can be out of
date, a run that was killed goes on where it stopped, and after a change to one check only that
check is made again. What is found of a submission is one file, since to make a file takes longer
than to judge an answer.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, get_args

from fieldcheck.seeds import seed
from fieldcheck.verdict import Rung, Verdict
from fieldgrade.checking.check_results import CheckResult
from fieldgrade.checking.course import Course
from fieldgrade.checking.dependency_digests import environment_digest, grader_digest
from fieldgrade.digests import json_digest
from fieldgrade.isolation.server import Server
from fieldgrade.submissions.submission import Submission
from fieldrecon._core.atomic_files import write_atomically


def keys(course: Course, server: Server, submission: Submission, question: str) -> dict[str, str]:
    """Return the digests of all that the findings on an answer depend on, check by check."""
    around = json_digest(
        submission.code_digest,
        question,
        environment_digest(),
        grader_digest(),
        seed(submission.student, question, course.salt),
        server.tier,
        vars(server.limits),
    )
    made_by = course.checks(question)
    return {check: json_digest(around, check, made) for check, made in made_by.items()}


@dataclass(frozen=True)
class Cache:
    """Findings in a folder.

    Parameters
    ----------
    folder : Path
        It is made when something is kept.
    """

    folder: Path

    def get(self, submission: Submission) -> dict[str, CheckResult]:
        """Return what is known of a submission, by name; what cannot be read is not known."""
        read = {name: _finding(data) for name, data in self._kept(submission).items()}
        return {name: finding for name, finding in read.items() if finding}

    def put(self, submission: Submission, findings: Mapping[str, CheckResult]) -> None:
        """Keep findings on a submission, by name, beside those that are there."""
        kept = json.dumps({**self._kept(submission), **findings}, default=vars)
        write_atomically(self._file(submission), kept.encode(), sync=False)

    def _kept(self, submission: Submission) -> dict[str, Any]:
        try:
            kept = json.loads(self._file(submission).read_text(encoding="utf-8"))
        except (OSError, ValueError):
            return {}
        return kept if isinstance(kept, dict) else {}

    def _file(self, submission: Submission) -> Path:
        name = json_digest(submission.student, submission.code_digest)
        return self.folder / name[:2] / f"{name}.json"


def _finding(data: Any) -> CheckResult | None:
    """Return a finding as it was kept; None if that is none."""
    try:
        verdict = Verdict(**data["verdict"])
        errors = tuple((int(n), str(text)) for n, text in data["cell_errors"])
        broke, returned = tuple(map(str, data["broke"])), tuple(data["returned"])
        found = CheckResult(verdict, str(data["check"]), broke, errors, returned)
    except (ValueError, KeyError, TypeError):
        return None
    return found if verdict.rung in get_args(Rung) else None
