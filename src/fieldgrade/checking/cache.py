"""Cache of check results, by digests of all that they depend on.

The key of a result is the digest of the answer, the check and the environment. Therefore no cached
result can be out of date, a run that was killed continues where it stopped, and after a change to
one check only this check runs again. All results of a submission are in one file, since creating a
file takes longer than judging an answer.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, get_args

from fieldcheck.seeds import seed
from fieldcheck.verdict import Finding, Verdict
from fieldgrade.checking.check_results import CellReport, CheckResult
from fieldgrade.checking.course import Course
from fieldgrade.checking.dependency_digests import environment_digest, grader_digest
from fieldgrade.isolation.process import CellError
from fieldgrade.isolation.server import Server
from fieldgrade.sandbox.missing import validated
from fieldgrade.submissions.submission import Submission
from fieldrecon._core.atomic_files import write_atomically
from fieldrecon._core.digests import json_digest


def keys(course: Course, server: Server, submission: Submission, question: str) -> dict[str, str]:
    """Return the cache keys of the checks of an answer, by check."""
    around = json_digest(
        submission.code_digest,
        question,
        environment_digest(),
        grader_digest(),
        seed(submission.student, question, course.salt),
        server.tier,
        vars(server.limits),
        [course.made_by(earlier) for earlier in course.given(question)],
    )
    made_by = course.checks(question)
    return {check: json_digest(around, check, made) for check, made in made_by.items()}


@dataclass(frozen=True)
class Cache:
    """Check results in a folder.

    Parameters
    ----------
    folder : Path
        The folder; it is created when it is needed.
    """

    folder: Path

    def get(self, submission: Submission) -> dict[str, CheckResult]:
        """Return the cached results of a submission, by key; unreadable ones are left out."""
        read = {name: _check_result(data) for name, data in self._kept(submission).items()}
        return {name: result for name, result in read.items() if result}

    def put(self, submission: Submission, results: Mapping[str, CheckResult]) -> None:
        """Add results of a submission to the cache, by key."""
        kept = json.dumps({**self._kept(submission), **results}, default=vars)
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


def _check_result(data: Any) -> CheckResult | None:
    """Return a cached result; None if it is damaged."""
    try:
        verdict = Verdict(**data["verdict"])
        errors = tuple(CellError(**error) for error in data["cells"]["errors"])
        missing = validated(data["cells"]["missing"])
        cells = CellReport(errors, missing, tuple(data["cells"]["notes"]))
        broke, returned = tuple(map(str, data["broke"])), tuple(data["returned"])
        given = tuple(map(str, data["given"]))
        found = CheckResult(verdict, str(data["check"]), broke, cells, returned, given)
    except (ValueError, KeyError, TypeError):
        return None
    return found if verdict.finding in get_args(Finding) else None
