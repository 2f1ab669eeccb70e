"""Trials of an answer: misconceptions are recognized on any inputs and evaluated only on demand."""

from itertools import chain

import numpy as np
import pytest

from fieldcheck.questions import get, questions
from fieldgrade.authoring.catalogue import entries
from fieldgrade.authoring.hidden_cases import hidden_cases
from fieldgrade.authoring.known_answers import known_answers
from fieldgrade.authoring.trials import public_trial, trials
from fieldgrade.grader_validation.rounding_errors import perturbed
from graded_class import SOURCES

SOURCE = SOURCES["01"]
FUNCTIONS, MISTAKES = SOURCE.functions(), entries(SOURCE, "misconceptions")


def trials_of_class(number, count):
    """The public trials of a notebook, by question, and then the others of each student."""
    source = SOURCES[number]
    functions, hidden = source.functions(), hidden_cases(source)
    asked = {q.name: q for q in questions().values() if q.notebook == number}
    public = {name: public_trial(q, functions, ()) for name, q in asked.items()}
    yield {name: (trial,) for name, trial in public.items()}
    for k in range(count):
        its = (functions, (), hidden, f"student {k}", "a salt")
        yield {name: trials(q, *its, public[name])[1:] for name, q in asked.items()}


@pytest.mark.parametrize(
    ("number", "students"),
    [("01", 2), *(pytest.param(number, 4, marks=pytest.mark.slow) for number in SOURCES)],
)
def test_no_right_answer_consists_of_rounding_errors(number, students):
    """A rounding error of zero would become the unit of all differences.

    Then a right answer that rounds differently would be judged wrong. Values that vanish, such as
    the curvature of a spline through two sites, are exactly zero in the normal form. Small values
    that keep their digits on perturbed inputs are not rounding errors.
    """
    functions = SOURCES[number].functions()
    for its in trials_of_class(number, students):
        for trial in chain.from_iterable(its.values()):
            again = known_answers(trial.question, perturbed(trial.calls, 0), functions, ()).right
            for call, right, other in zip(trial.calls, trial.answers.right, again, strict=True):
                most = max(map(largest, (*call.arguments, *right)))
                arrays = trial.question.normal_form(call, right)
                changed = trial.question.normal_form(call, other)
                assert not any(
                    0 < largest(array) < 1e-10 * most
                    and largest(array - other) > 1e-3 * largest(array)
                    for array, other in zip(arrays, changed, strict=True)
                ), (trial.question.name, call.case)


def largest(array):
    return float(np.abs(array).max(initial=0.0)) if isinstance(array, np.ndarray) else 0.0


@pytest.mark.slow
@pytest.mark.parametrize("number", SOURCES)
def test_alternative_right_answers_are_right_for_every_student(number):
    """Three students have inputs of their own, on which right answers round differently."""
    functions, others = SOURCES[number].functions(), entries(SOURCES[number], "alternatives")
    for its in trials_of_class(number, 3):
        for other in others:
            found = [trial.verdict(other.namespace(functions)) for trial in its[other.question]]
            assert all(verdict.right for verdict in found), (other.name, found)


def tried(question):
    return trials(get(question), FUNCTIONS, MISTAKES, hidden_cases(SOURCE), "ada", "a secret salt")


@pytest.mark.parametrize(
    "question", ["01.1", *(pytest.param(q, marks=pytest.mark.slow) for q in ("01.2", "01.4"))]
)
def test_misconceptions_are_recognized_on_hidden_inputs(question):
    """The student reads the sentence of the misconception, which reveals no input."""
    mistakes = [m for m in MISTAKES if m.question == question]
    for trial in tried(question):
        verdicts = [trial.verdict(m.namespace(FUNCTIONS)) for m in mistakes]
        known = {v.mistake: v.sentence for v in verdicts if v.finding == "misconception"}
        assert known
        assert known.items() <= {m.name: m.sentence for m in mistakes}.items()


def test_misconceptions_are_not_evaluated_for_right_answers(monkeypatch):
    """Each question has about a dozen misconceptions, and most answers are right."""
    asked = []
    monkeypatch.setattr(
        "fieldgrade.authoring.trials.known_mistakes", lambda *_: asked.append("mistakes") or ()
    )
    public, *others = tried("01.2")
    assert all(trial.verdict(FUNCTIONS).right for trial in others)
    assert not asked
    assert not others[0].verdict(MISTAKES[0].namespace(FUNCTIONS) | {"fit": lambda *_: 0}).right
    assert asked == ["mistakes"]
    assert public.answers.mistakes
