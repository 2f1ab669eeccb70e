"""Verdicts must not depend on rounding errors: test with perturbed inputs.

The known answers are computed once. Then the solution, the alternative answers and the mistakes run
again with other rounding errors, and are judged by these known answers. Every verdict must stay the
same. Rounding errors change with inputs that are perturbed in their last digits (here), and with
other BLAS kernels or instructions of the processor (``blas_kernels``).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fieldcheck.answers import Answers
from fieldcheck.calls import Call, perform
from fieldcheck.judge import TIMEOUT_FACTOR, judge
from fieldcheck.questions import questions
from fieldgrade.authoring.catalogue import Entry, entries
from fieldgrade.authoring.hidden_cases import hidden_cases
from fieldgrade.authoring.sources import Source
from fieldgrade.authoring.trials import Trial, public_trial, trials

CHANGE = 1e-14
"""Relative change of the inputs: some fifty units in the last place."""
DRAWS = 10
STUDENTS = ("first", "second", "third")
"""Students whose own and hidden inputs are tried: of the others than the first, one draw."""

TrialKey = tuple[str, str]
"""A question, and the name of a trial."""
Verdicts = dict[tuple[str, str, str], str]
"""Verdicts by question, inputs and answer."""
Changes = dict[str, list[str]]
"""By question, a sentence for each answer whose verdict changed."""


@dataclass(frozen=True)
class Baseline:
    """The known answers, and the verdicts without perturbation."""

    known: dict[TrialKey, Answers]
    verdicts: Verdicts

    def __or__(self, other: Baseline) -> Baseline:
        return Baseline(self.known | other.known, self.verdicts | other.verdicts)


@dataclass(frozen=True)
class RoundingTest:
    """The trials of the questions of a notebook, and the answers to be judged.

    Parameters
    ----------
    functions : dict
        The functions of the notebook.
    trials : dict
        Trials by question and inputs: the public cases, and the own and hidden inputs of three
        students, with the known mistakes of each.
    answers : dict
        By question: names and answers; None is the solution.
    """

    functions: dict[str, Any]
    trials: dict[TrialKey, Trial]
    answers: dict[str, dict[str, Entry | None]]

    def baseline(self) -> Baseline:
        """Return the known answers and the verdicts of this process."""
        known = {place: _with_mistakes(trial) for place, trial in self.trials.items()}
        return Baseline(known, self.verdicts(known))

    def without(self, students: Iterable[str]) -> RoundingTest:
        """Return the test without the own and hidden inputs of some students."""
        ends = tuple(_of("", student) for student in students)
        return replace(
            self, trials={k: t for k, t in self.trials.items() if not k[1].endswith(ends)}
        )

    def of_named(self) -> RoundingTest:
        """Return the test without the mistakes that are never named, only refused."""
        named = {
            question: {name: entry for name, entry in its.items() if entry is None or entry.named}
            for question, its in self.answers.items()
        }
        return replace(self, answers=named)

    def verdicts(self, known: Mapping[TrialKey, Answers], draw: int | None = None) -> Verdicts:
        """Judge each answer by known answers; with a `draw`, on perturbed inputs."""
        found: Verdicts = {}
        for (question, inputs), trial in self.trials.items():
            tried = trial.calls if draw is None else perturbed(trial.calls, draw)
            for name, entry in self.answers[question].items():
                verdict = self._verdict(trial, tried, entry, known[question, inputs])
                found[question, inputs, name] = verdict
        return found

    def _verdict(
        self, trial: Trial, tried: tuple[Call, ...], entry: Entry | None, known: Answers
    ) -> str:
        calls, question = trial.calls, trial.question
        functions = entry.namespace(self.functions) if entry else self.functions
        outcomes = perform(functions, tried, TIMEOUT_FACTOR * question.limit)
        verdict = judge(replace(question, limit=np.inf), calls, outcomes, known)
        return repr(verdict.mistake) if verdict.mistake else verdict.finding


def rounding_test(
    source: Source, salt: str, only: str = "", students: Iterable[str] | None = None
) -> RoundingTest:
    """Return the trials of the questions of a notebook whose names begin with `only`.

    The own and hidden inputs are those of `students`, or of all `STUDENTS`.
    """
    functions, hidden = source.functions(), hidden_cases(source)
    mistakes, others = entries(source, "misconceptions"), entries(source, "alternatives")
    asked = [q for q in questions().values() if q.notebook == source.number]
    tried, answers = {}, {}
    for question in (q for q in asked if q.name.startswith(only)):
        public = public_trial(question, functions, mistakes)
        tried[question.name, public.name] = public
        for student in STUDENTS if students is None else students:
            own = trials(question, functions, mistakes, hidden, student, salt, public)[1:]
            tried |= {(question.name, _of(t.name, student)): t for t in own}
        answers[question.name] = {"the solution": None} | {
            f"the {kind} {entry.name!r}": entry
            for kind, found in (("right answer", others), ("mistake", mistakes))
            for entry in found
            if entry.question == question.name
        }
    return RoundingTest(functions, tried, answers)


def _of(inputs: str, student: str) -> str:
    return f"{inputs} of the {student} student"


def _with_mistakes(trial: Trial) -> Answers:
    return replace(trial.answers, mistakes=trial.mistakes() or trial.answers.mistakes)


def perturbed(calls: Iterable[Call], draw: int) -> tuple[Call, ...]:
    """Return calls whose floating-point inputs are changed relatively by ±1e-14, at random.

    Arguments that a call declares exact keep their digits, and so do integers and booleans.

    Examples
    --------
    >>> call, = perturbed([Call("f", (1.0, np.array([2.0, 0.0]), np.array([3]), 4.0), "", (3,))], 0)
    >>> [float(abs(np.max(a) / b - 1) / CHANGE).__round__(1)
    ...  for a, b in zip(call.arguments, (1, 2, 3, 4))]
    [1.0, 1.0, 0.0, 0.0]
    """
    random = np.random.default_rng(draw)
    return tuple(
        replace(
            call,
            arguments=tuple(
                argument if position in call.exact else _changed(argument, random)
                for position, argument in enumerate(call.arguments)
            ),
        )
        for call in calls
    )


def _changed(argument: Any, random: np.random.Generator) -> Any:
    if not isinstance(argument, float | np.ndarray) or np.asarray(argument).dtype.kind != "f":
        return argument
    return argument * (1 + CHANGE * random.choice([-1.0, 1.0], np.shape(argument)))[()]


def changes(before: Verdicts, runs: Iterable[tuple[str, Verdicts]]) -> Changes:
    """Return the verdicts that changed in other runs.

    Parameters
    ----------
    before : dict
        The verdicts to compare with.
    runs : iterable
        Pairs of a condition in words ("with …", "when …") and the verdicts.
    """
    found: dict[tuple[str, str], list[str]] = {}
    for when, after in runs:
        for (question, inputs, answer), now in after.items():
            if now != (verdict := before[question, inputs, answer]):
                sentence = f"{answer} is judged {now} and no longer {verdict} {when}: {inputs}"
                found.setdefault((question, answer), []).append(sentence)
    summary: Changes = {}
    for (question, _), sentences in found.items():
        first, more = sentences[0], len(sentences) - 1
        summary.setdefault(question, []).append(
            first + (f" (and {more} times more)" if more else "")
        )
    return summary


def changes_of_draws(found: RoundingTest, baseline: Baseline) -> Changes:
    """Return the verdicts that change on perturbed inputs; the first draw tries everything."""
    tests = [found, *[found.without(STUDENTS[1:]).of_named()] * (DRAWS - 1)]
    draws = (
        (f"when the inputs change by {CHANGE:.0e} (draw {k})", test.verdicts(baseline.known, k))
        for k, test in enumerate(tests)
    )
    return changes(baseline.verdicts, draws)
