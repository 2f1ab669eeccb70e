"""A right answer that calls a wrong earlier one: nothing blames it, and it is paid."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from functools import partial
from typing import Any

from fieldcheck.earlier_answers import earlier_questions, in_place_of
from fieldcheck.notebook import try_public
from fieldcheck.question import Question
from fieldgrade.authoring.catalogue import Entry
from fieldgrade.authoring.right_functions import RightFunctions
from fieldgrade.authoring.solution_calls import solution_calls
from fieldgrade.authoring.sources import Source
from fieldgrade.authoring.trials import Trial, grade
from fieldgrade.sandbox.given_functions import given_function

SECONDS = 600.0


def blamed(
    question: Question, functions: dict[str, Any], mistakes: Sequence[Entry]
) -> Iterator[str]:
    """Yield the mistakes in earlier answers for which the solution of a question is blamed.

    The check must say that the solution is right, or name an earlier question to be corrected.
    """
    for earlier in solution_calls(question, functions):
        for mistake in (m for m in mistakes if m.question == earlier.name):
            with in_place_of(functions, question.function, {earlier.function: mistake.function}):
                verdict = try_public(question, functions)
            if verdict.finding not in ("right", "inherited"):
                yield f"with {mistake.name!r} in {earlier.name}, the solution gets: {verdict}"


def unpaid(
    question: Question, functions: dict[str, Any], source: Source, tried: Sequence[Trial]
) -> Iterator[str]:
    """Yield why a solution loses points if the grader computes the earlier functions it calls."""
    before = [earlier.name for earlier in earlier_questions(question)]
    yield from (f"may_call names {name}" for name in question.may_call if name not in before)
    names = [earlier.function for earlier in solution_calls(question, functions)]
    if not names:
        return
    right = RightFunctions(source.path.resolve(), names)
    exchange = partial(right.answer, late=time.monotonic() + SECONDS)
    given = {name: given_function(name, exchange) for name in names}
    with in_place_of(functions, question.function, given):
        verdict = grade(tried, functions)
    if not verdict.right:
        yield f"with right earlier functions from the grader, the solution gets: {verdict}"
