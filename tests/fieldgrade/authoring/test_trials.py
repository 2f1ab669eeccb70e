"""What an answer goes through: mistakes are recognised on any inputs, and cost nothing before."""

from itertools import chain

import numpy as np
import pytest

from fieldcheck.questions import get, questions
from fieldgrade.authoring.catalogue import entries
from fieldgrade.authoring.hidden_cases import hidden_cases
from fieldgrade.authoring.trials import trials
from graded_class import SOURCES

SOURCE = SOURCES["01"]
FUNCTIONS, MISTAKES = SOURCE.functions(), entries(SOURCE, "misconceptions")


def of_class(number, count):
    """What the students of a class go through in a notebook, one by one."""
    source = SOURCES[number]
    functions, hidden = source.functions(), hidden_cases(source)
    asked = [q for q in questions().values() if q.notebook == number]
    for k in range(count):
        yield {q.name: trials(q, functions, (), hidden, f"student {k}", "a salt") for q in asked}


@pytest.mark.parametrize("students", [2, pytest.param(25, marks=pytest.mark.slow)])
@pytest.mark.parametrize("number", SOURCES)
def test_no_right_number_is_the_rounding_of_zero(number, students):
    """Else it would be the unit of all differences, and who rounds otherwise would be wrong.

    What is nothing, as the bends of a spline through two sites, is zero in its normal form.
    """
    for its in of_class(number, students):
        for trial in chain.from_iterable(its.values()):
            for call, right in zip(trial.calls, trial.answers.right, strict=True):
                made_of = [*call.arguments, *right]
                most = max((largest(a) for a in made_of if isinstance(a, np.ndarray)), default=0.0)
                for array in map(largest, trial.question.normal_form(call, right)):
                    assert array == 0 or array > 1e-10 * most, (trial.question.name, call.case)


def largest(array):
    return float(np.abs(array).max(initial=0.0))


@pytest.mark.slow
@pytest.mark.parametrize("number", SOURCES)
def test_who_is_right_in_another_way_is_right_in_any_class(number):
    """Thirty students, each with own inputs: right ways round differently."""
    functions, others = SOURCES[number].functions(), entries(SOURCES[number], "alternatives")
    for its in of_class(number, 30):
        for other in others:
            found = [trial.verdict(other.namespace(functions)) for trial in its[other.question]]
            assert all(verdict.right for verdict in found), (other.name, found)


def tried(question):
    return trials(get(question), FUNCTIONS, MISTAKES, hidden_cases(SOURCE), "ada", "a secret salt")


@pytest.mark.parametrize("question", ["01.1", "01.2", "01.4"])
def test_mistakes_are_recognised_on_hidden_inputs_too(question):
    """The student reads the sentence of the mistake, which tells no input."""
    mistakes = [m for m in MISTAKES if m.question == question]
    for trial in tried(question):
        told = [trial.verdict(m.namespace(FUNCTIONS)) for m in mistakes]
        known = {v.mistake: v.sentence for v in told if v.rung == "misconception"}
        assert known
        assert known.items() <= {m.name: m.sentence for m in mistakes}.items()


def test_nobody_asks_what_mistakes_give_while_answers_are_right(monkeypatch):
    """There are a dozen of them for each answer, and most answers are right."""
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
