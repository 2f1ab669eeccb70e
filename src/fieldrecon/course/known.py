"""The known answers to a question: what the solution and the catalogued mistakes give."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

from fieldcheck.answers import Answers, Mistake, to_json
from fieldcheck.calls import Call, Outcome, Values, perform
from fieldcheck.ladder import PATIENCE
from fieldcheck.question import Question
from fieldcheck.questions import questions
from fieldcheck.seeds import EVERYBODY, seed
from fieldcheck.shapes import fitted
from fieldrecon.course.catalogue import Entry, entries
from fieldrecon.course.sources import Source


def known_answers(
    question: Question, calls: Sequence[Call], functions: dict[str, Any], mistakes: Sequence[Entry]
) -> Answers:
    """Return what the solution and each mistake give for the calls.

    Raises
    ------
    ValueError
        The solution does not return the shapes that the question promises.
    """
    right = perform(functions, calls, PATIENCE * question.limit)
    return Answers(
        tuple(_right(question, *pair) for pair in zip(calls, right, strict=True)),
        known_mistakes(question, calls, functions, mistakes),
    )


def known_mistakes(
    question: Question, calls: Sequence[Call], functions: dict[str, Any], mistakes: Sequence[Entry]
) -> tuple[Mistake, ...]:
    """Return what each mistake gives for the calls."""
    limit = PATIENCE * question.limit
    return tuple(
        Mistake(m.name, m.sentence, perform(m.namespace(functions), calls, limit))
        for m in mistakes
        if m.question == question.name
    )


def _right(question: Question, call: Call, outcome: Outcome) -> Values:
    if outcome.values is None:
        raise ValueError(
            f"the solution of {question.name} for {call.case}: {outcome.status} {outcome.error}"
        )
    values = fitted(outcome.values, question.shapes(call))
    if [v.shape for v in values] != list(question.shapes(call)):
        raise ValueError(
            f"the solution of {question.name} for {call.case} returns shapes "
            f"{[v.shape for v in values]}; the question promises {list(question.shapes(call))}"
        )
    return values


def public_calls(question: Question) -> tuple[Call, ...]:
    """Return the fixed cases that are the same for everybody."""
    return question.inputs(seed(EVERYBODY, question.name))


def answers_file(source: Source) -> str:
    """Return the text of ``fieldcheck/answers/NN.json``."""
    functions, mistakes = source.functions(), entries(source, "misconceptions")
    asked = [q for q in questions().values() if q.notebook == source.number]
    data = {q.name: to_json(known_answers(q, public_calls(q), functions, mistakes)) for q in asked}
    return json.dumps(data, indent=None, separators=(",", ":"), ensure_ascii=False) + "\n"
