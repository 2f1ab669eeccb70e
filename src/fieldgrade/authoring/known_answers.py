"""Known answers to a question: the values of the solution and of the catalogued mistakes."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

from fieldcheck.answers import Answers, Mistake, from_json, to_json
from fieldcheck.calls import Call, Outcome, Values, perform
from fieldcheck.judge import TIMEOUT_FACTOR
from fieldcheck.question import Question
from fieldcheck.questions import questions
from fieldcheck.seeds import EVERYBODY, seed
from fieldcheck.shapes import fitted
from fieldgrade.authoring.catalogue import Entry, entries
from fieldgrade.authoring.sources import Source

SAME = 0.2
"""Known answers that differ by less, in units of the tolerance, differ only by rounding: those of
some mistakes do, on another processor."""


def known_answers(
    question: Question, calls: Sequence[Call], functions: dict[str, Any], mistakes: Sequence[Entry]
) -> Answers:
    """Return the values of the solution and of each mistake for the calls.

    Raises
    ------
    ValueError
        The solution does not return the shapes that the question states.
    """
    right = perform(functions, calls, TIMEOUT_FACTOR * question.limit)
    return Answers(
        tuple(_right(question, *pair) for pair in zip(calls, right, strict=True)),
        known_mistakes(question, calls, functions, mistakes),
    )


def known_mistakes(
    question: Question, calls: Sequence[Call], functions: dict[str, Any], mistakes: Sequence[Entry]
) -> tuple[Mistake, ...]:
    """Return the values of each recognizable mistake for the calls."""
    limit = TIMEOUT_FACTOR * question.limit
    return tuple(
        Mistake(m.name, m.sentence, perform(m.namespace(functions), calls, limit))
        for m in mistakes
        if m.named and m.question == question.name
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
            f"{[v.shape for v in values]}; the question states {list(question.shapes(call))}"
        )
    return values


def public_calls(question: Question) -> tuple[Call, ...]:
    """Return the public cases, which are the same for everybody."""
    return question.inputs(seed(EVERYBODY, question.name))


def answers_file(source: Source) -> str:
    """Return the text of ``fieldcheck/answers/NN.json``."""
    functions, mistakes = source.functions(), entries(source, "misconceptions")
    asked = [q for q in questions().values() if q.notebook == source.number]
    data = {q.name: to_json(known_answers(q, public_calls(q), functions, mistakes)) for q in asked}
    return json.dumps(data, indent=None, separators=(",", ":"), ensure_ascii=False) + "\n"


def same_answers(kept: str, fresh: str) -> bool:
    """Return whether two texts of a file of known answers differ by rounding errors at most."""
    before, now = json.loads(kept), json.loads(fresh)
    return list(before) == list(now) and all(
        _same(questions()[name], from_json(before[name]), from_json(now[name])) for name in now
    )


def _same(question: Question, before: Answers, now: Answers) -> bool:
    def outcomes(answers: Answers) -> list[tuple[Outcome, ...]]:
        right = tuple(Outcome("returned", values=values) for values in answers.right)
        return [right, *(m.outcomes for m in answers.mistakes)]

    def names(answers: Answers) -> list[tuple[str, str]]:
        return [(m.name, m.sentence) for m in answers.mistakes]

    calls = public_calls(question)
    return names(before) == names(now) and all(
        len(one) == len(other) == len(calls) and now.distance(question, calls, one, other) <= SAME
        for one, other in zip(outcomes(before), outcomes(now), strict=True)
    )
