"""What an answer goes through: mistakes are recognised on any inputs, and cost nothing before."""

import pytest

from fieldcheck.questions import get
from fieldrecon.course.catalogue import entries
from fieldrecon.course.hidden import hidden_cases
from fieldrecon.course.trials import trials
from graded_class import SOURCES

SOURCE = SOURCES["01"]
FUNCTIONS, MISTAKES = SOURCE.functions(), entries(SOURCE, "misconceptions")


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
        "fieldrecon.course.trials.known_mistakes", lambda *_: asked.append("mistakes") or ()
    )
    public, *others = tried("01.2")
    assert all(trial.verdict(FUNCTIONS).right for trial in others)
    assert not asked
    assert not others[0].verdict(MISTAKES[0].namespace(FUNCTIONS) | {"fit": lambda *_: 0}).right
    assert asked == ["mistakes"]
    assert public.answers.mistakes
