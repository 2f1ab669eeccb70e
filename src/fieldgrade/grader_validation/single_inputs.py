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
        catching = catching_inputs(tried, mistake.namespace(functions))
        if len(catching) < FEWEST:
            yield f"{mistake.name!r} is caught only by: {', '.join(catching) or 'no input alone'}"


def catching_inputs(tried: Sequence[Trial], functions: dict[str, Any]) -> list[str]:
    """Return the cases for which a wrong answer alone is not right.

    The student's own inputs are the public cases with other numbers; both count as one.
    """
    found: dict[str, None] = {}
    for trial in tried:
        limit = TIMEOUT_FACTOR * trial.question.limit
        for index, outcome in enumerate(perform(functions, trial.calls, limit)):
            if not _right_alone(trial, index, outcome):
                found[trial.calls[index].case] = None
    return list(found)


def _right_alone(trial: Trial, index: int, outcome: Outcome) -> bool:
    """Judge one outcome by its right values, without the laws, which may compare cases."""
    question = replace(trial.question, laws=())
    known = replace(trial.answers, right=(trial.answers.right[index],), mistakes=())
    return judge(question, [trial.calls[index]], [outcome], known).right
