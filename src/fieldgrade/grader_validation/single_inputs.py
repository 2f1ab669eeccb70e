"""Which inputs catch a wrong answer: every known wrong answer must be caught by two at least.

A wrong answer that a single input catches shows how little separates it from a right one: a
slightly different wrong answer might pass.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

from fieldcheck.calls import Outcome, perform
from fieldcheck.judge import TIMEOUT_FACTOR, judge
from fieldgrade.authoring.catalogue import Entry
from fieldgrade.authoring.trials import Trial

FEWEST = 2


def caught_by_few(
    tried: Sequence[Trial], functions: dict[str, Any], mistakes: Sequence[Entry]
) -> Iterator[str]:
    """Yield the wrong answers that fewer than two inputs catch, with these inputs."""
    for mistake in mistakes:
        catching = first_that_catch(tried, mistake.namespace(functions))
        if len(catching) < FEWEST:
            yield f"{mistake.name!r} is caught only by: {', '.join(catching) or 'no input alone'}"


def first_that_catch(tried: Sequence[Trial], functions: dict[str, Any]) -> list[str]:
    """Return the first two cases, or fewer, for which a wrong answer alone is not right.

    The student's own inputs are the public cases with other numbers; both count as one.
    """
    found: dict[str, None] = {}
    for trial in tried:
        limit = TIMEOUT_FACTOR * trial.question.limit
        for index, call in enumerate(trial.calls):
            if call.case in found:
                continue
            (outcome,) = perform(functions, (call,), limit)
            if not _right_alone(trial, index, outcome):
                found[call.case] = None
                if len(found) == FEWEST:
                    return list(found)
    return list(found)


def _right_alone(trial: Trial, index: int, outcome: Outcome) -> bool:
    """Judge one outcome by its right values, without the laws, which may compare cases."""
    question = replace(trial.question, laws=())
    known = replace(trial.answers, right=(trial.answers.right[index],), mistakes=())
    return judge(question, [trial.calls[index]], [outcome], known).right
