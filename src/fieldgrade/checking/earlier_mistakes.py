"""The results of an answer that was asked again with right functions of earlier questions.

A mistake in an earlier answer costs points once. The values that the right functions returned may
be in every sentence about the second run, so that only its outcome is used.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from fieldcheck.verdict import Verdict
from fieldgrade.checking.check_results import CheckResult

Results = Mapping[str, CheckResult]
"""By check, in the order of the checks."""

ALSO_WRONG = "It is not right, and with our {} in place of yours it is not right either."
ALSO_SLOW = "The numbers are right, but the function takes too long, also with our {}."


def is_right(results: Results) -> bool:
    """Whether an answer passed all its checks."""
    return _last(results).verdict.right


def with_given(first: Results, again: Results, given: Sequence[str]) -> dict[str, CheckResult]:
    """Return the results of an answer, from a run with its own earlier answers and one with ours.

    Parameters
    ----------
    first, again : mapping
        The results with the submitted earlier answers, and with right ones.
    given : sequence of str
        The earlier questions whose right functions the answer called.
    """
    before, after = _last(first), _last(again)
    if before.verdict.credit and after.verdict.credit <= before.verdict.credit:
        return dict(first)
    if not after.verdict.credit:
        return {**first, [*first][-1]: _failed(before, after, given)}
    return {
        check: replace(
            result,
            verdict=_passed(result.verdict, given),
            cells=before.cells,
            broke=before.broke,
            returned=(),
            given=tuple(given),
        )
        for check, result in again.items()
    }


def _passed(verdict: Verdict, given: Sequence[str]) -> Verdict:
    sentence = "" if verdict.right else ALSO_SLOW.format(" and ".join(given))
    return Verdict(verdict.question, verdict.finding, sentence)


def _failed(before: CheckResult, after: CheckResult, given: Sequence[str]) -> CheckResult:
    """Return the result of an answer that is wrong with right functions, too.

    The sentence on the first run is kept if both runs fail alike: no right function had a part in
    it. Otherwise it may be about an earlier answer.
    """
    new, old = after.verdict, before.verdict
    if new.finding == "misconception":
        verdict = Verdict(new.question, new.finding, new.sentence, new.mistake)
    elif (after.check, new.finding) == (before.check, old.finding):
        return before
    else:
        verdict = Verdict(new.question, "wrong", ALSO_WRONG.format(" and ".join(given)))
    return replace(before, verdict=verdict, returned=())


def _last(results: Results) -> CheckResult:
    return results[[*results][-1]]
