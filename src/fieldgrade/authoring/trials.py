"""Trials of an answer: the public cases, the student's own inputs, and hidden cases."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

from fieldcheck.answers import Answers, Mistake
from fieldcheck.calls import Call, Outcome, perform
from fieldcheck.judge import TIMEOUT_FACTOR, judge
from fieldcheck.question import Question
from fieldcheck.seeds import seed
from fieldcheck.verdict import Verdict
from fieldgrade.authoring.catalogue import Entry
from fieldgrade.authoring.hidden_cases import Hidden
from fieldgrade.authoring.known_answers import known_answers, known_mistakes, public_calls

PUBLIC, OWN = "public cases", "own inputs"
"""The names of the first two checks of every question; hidden cases have their own names."""

REVEALING = ("exception", "endless", "type", "shape", "not finite", "wrong", "slow")
"""Outcomes whose sentence would reveal a hidden input."""


@dataclass(frozen=True)
class Trial:
    """Calls with known answers, a name, and for hidden cases the sentence that replaces all others.

    The values of `mistakes` are computed only if an answer is wrong, since most answers are right.
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
        return self.judge_outcomes(outcomes)

    def judge_outcomes(self, outcomes: Sequence[Outcome]) -> Verdict:
        """Judge the outcomes of the calls, without revealing hidden inputs."""
        verdict = judge(self.question, self.calls, outcomes, self.answers)
        if not verdict.right and (mistakes := self.mistakes()):
            known = replace(self.answers, mistakes=mistakes)
            verdict = judge(self.question, self.calls, outcomes, known)
        return self.without_hidden_inputs(verdict)

    def without_hidden_inputs(self, verdict: Verdict) -> Verdict:
        """Return a verdict whose sentence does not reveal hidden inputs."""
        if self.sentence and verdict.finding in REVEALING:
            return replace(verdict, sentence=self.sentence, call=None)
        return verdict


def asked_by(case: Hidden, question: Question) -> Question:
    """Return a question with the inputs of a hidden case, and without laws."""
    return replace(question, inputs=case.inputs, laws=())


def public_trial(question: Question, functions: dict[str, Any], mistakes: Sequence[Entry]) -> Trial:
    """Return the public trial of a question, which is the same for everybody."""
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

    The `public` trial can be passed, so that it is computed once for many students.
    """

    def trial(question: Question, sentence: str, name: str) -> Trial:
        calls = question.inputs(number)
        known = known_answers(question, calls, functions, ())
        made = cache(lambda: known_mistakes(question, calls, functions, mistakes))
        return Trial(question, calls, known, sentence, name, made)

    number = seed(student, question.name, salt)
    sentence = "It is right on the public cases, not on others."
    return (
        public or public_trial(question, functions, mistakes),
        trial(question, sentence, OWN),
        *(
            trial(asked_by(h, question), h.sentence, h.name)
            for h in hidden
            if h.question == question.name
        ),
    )


def grade(trials: Sequence[Trial], functions: dict[str, Any]) -> Verdict:
    """Return the verdict of the first failed trial, or of the last one."""
    verdict = None
    for trial in trials:
        verdict = trial.verdict(functions)
        if not verdict.right:
            break
    if verdict is None:
        raise ValueError("an answer without trials cannot be graded")
    return verdict
