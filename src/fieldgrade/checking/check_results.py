"""Results of the checks of an answer, which run in order up to the first failure."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from fieldcheck.verdict import Verdict
from fieldgrade.isolation.process import CellError
from fieldgrade.sandbox.missing import NOTHING, Missing


@dataclass(frozen=True)
class CellReport:
    """What is reported about the cells of a submission.

    Parameters
    ----------
    errors : tuple of CellError
        The first error of each cell that has one.
    missing : Missing
        Modules, files and fonts that the code needs and that are not there.
    notes : tuple of str
        Sentences on stubs and cells that were left out, and on files that are not used.
    """

    errors: tuple[CellError, ...] = ()
    missing: Missing = NOTHING
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class CheckResult:
    """The result of one check of an answer; it can be cached, since it depends on no points.

    Parameters
    ----------
    verdict : Verdict
        The verdict on the answer.
    check : str
        The name of the check if the answer failed it, else empty.
    broke : tuple of str
        Why processes were killed in cells or in calls of this check.
    cells : CellReport
        What is reported about the cells, which ran before the calls.
    returned : tuple of mapping
        The wrong values on the first public case that fails, for a picture.
    given : tuple of str
        The earlier questions whose right functions the answer was given.
    """

    verdict: Verdict
    check: str = ""
    broke: tuple[str, ...] = ()
    cells: CellReport = CellReport()
    returned: tuple[Mapping[str, Any], ...] = ()
    given: tuple[str, ...] = ()


CheckResults = Mapping[str, Mapping[str, CheckResult]]
"""By question and check, in the order of the checks; the first failure is the last entry."""


def pending(checks: Iterable[str], cached: Mapping[str, CheckResult]) -> Iterator[str]:
    """Yield the checks to be run: none after a check that is known to fail.

    Checks after a pending one are run with it, since this costs less than running all cells again
    if it passes.
    """
    for check in checks:
        if check not in cached:
            yield check
        elif not cached[check].verdict.right:
            return


def up_to_first_failure(
    checks: Iterable[str], found: Mapping[str, CheckResult]
) -> dict[str, CheckResult]:
    """Return the results up to the first failure."""
    so_far = {}
    for check in checks:
        so_far[check] = found[check]
        if not found[check].verdict.right:
            break
    return so_far
