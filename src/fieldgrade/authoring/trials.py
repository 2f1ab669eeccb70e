"""What an answer goes through to be graded: public cases, the student's own, hidden ones."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

from fieldcheck.answers import Answers, Mistake
from fieldcheck.calls import Call, Outcome, perform
from fieldcheck.ladder import TIMEOUT_FACTOR, judge
from fieldcheck.question import Question
from fieldcheck.seeds import seed
from fieldcheck.verdict import Verdict
from fieldgrade.authoring.catalogue import Entry
from fieldgrade.authoring.hidden_cases import Hidden
from fieldgrade.authoring.known_answers import known_answers, known_mistakes, public_calls

PUBLIC, OWN = "public cases", "own inputs"
"""The names of the first two checks of every question; hidden ones have names of their own."""

REVEALING = ("exception", "endless", "type", "shape", "not finite", "wrong", "slow")
"""Rungs whose sentence would tell a hidden input."""


@dataclass(frozen=True)
class Trial:
    """Calls, the known answers to them, what is said if they are hidden, and a name.

    What `mistakes` give is asked only once an answer is wrong: most are right, and there are many
    mistakes.
    """

    question: Question
    calls: tuple[Call, ...]
    answers: Answers
    sentence: str = ""
    name: str = PUBLIC
    mistakes: Callable[[], tuple[Mistake, ...]] = tuple

    def verdict(self, functions: dict[str, Any]) -> Verdict:
        """Judge the functions, called in this process: for code that is trusted."""
        question = self.question
        outcomes = perform(functions, self.calls, TIMEOUT_FACTOR * question.limit)
        return self.judged(outcomes)

    def judged(self, outcomes: Sequence[Outcome]) -> Verdict:
        """Judge what came of the calls, and return what may be told."""
        verdict = judge(self.question, self.calls, outcomes, self.answers)
        if not verdict.right and (mistakes := self.mistakes()):
            known = replace(self.answers, mistakes=mistakes)
            verdict = judge(self.question, self.calls, outcomes, known)
        return self.told(verdict)

    def told(self, verdict: Verdict) -> Verdict:
        """Return a verdict without what would give a hidden input away."""
        if self.sentence and verdict.rung in REVEALING:
            return replace(verdict, sentence=self.sentence, call=None)
        return verdict


def asked_by(case: Hidden, question: Question) -> Question:
    """Return a question as a hidden case asks it: with inputs of its own, and without laws."""
    return replace(question, inputs=case.inputs, laws=())


def public_trial(question: Question, functions: dict[str, Any], mistakes: Sequence[Entry]) -> Trial:
    """Return the first trial of a question, which is the same for everybody."""
    calls = public_calls(question)
    return Trial(question, calls, known_answers(question, calls, functions, mistakes))


def trials(
    question: Question,
    functions: dict[str, Any],
    mistakes: Sequence[Entry],
    hidden: Sequence[Hidden],
    student: str,
    salt: str,
    public: Trial | None = None,
) -> tuple[Trial, ...]:
    """Return the trials of a student's answer, the known answers computed by the solution.

    Whoever grades many students makes the `public` trial once, and gives it.
    """

    def trial(question: Question, sentence: str, name: str) -> Trial:
        calls = question.inputs(number)
        known = known_answers(question, calls, functions, ())
        made = cache(lambda: known_mistakes(question, calls, functions, mistakes))
        return Trial(question, calls, known, sentence, name, made)

    number = seed(student, question.name, salt)
    told = "It is right on the public cases, not on others."
    return (
        public or public_trial(question, functions, mistakes),
        trial(question, told, OWN),
        *(
            trial(asked_by(h, question), h.sentence, h.name)
            for h in hidden
            if h.question == question.name
        ),
    )


def grade(trials: Sequence[Trial], functions: dict[str, Any]) -> Verdict:
    """Return the first verdict that is not right, or the last that is."""
    verdict = None
    for trial in trials:
        verdict = trial.verdict(functions)
        if not verdict.right:
            break
    if verdict is None:
        raise ValueError("an answer without trials cannot be graded")
    return verdict
