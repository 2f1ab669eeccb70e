"""The course as the grader uses it: sources, points, trials and their digests."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

from fieldcheck.earlier_answers import earlier_questions
from fieldcheck.question import Question
from fieldcheck.questions import questions
from fieldgrade.authoring.catalogue import Entry, entries
from fieldgrade.authoring.hidden_cases import Hidden, hidden_cases
from fieldgrade.authoring.solution_calls import solution_calls
from fieldgrade.authoring.sources import Source
from fieldgrade.authoring.trials import OWN, PUBLIC, Trial, asked_by, public_trial, trials
from fieldgrade.checking.dependency_digests import dependency_digest
from fieldgrade.submissions.definitions import LOCK


@dataclass(frozen=True)
class Course:
    """The sources of the notebooks, and the points of the questions.

    Parameters
    ----------
    sources : sequence of Source
        The notebooks.
    salt : str
        The seed of the hidden inputs.
    worth : mapping
        Points that override those of the questions.
    """

    sources: Sequence[Source]
    salt: str
    worth: Mapping[str, float] = field(default_factory=dict)

    def asked(self, number: str, only: Collection[str] = ()) -> list[Question]:
        """Return the questions of a notebook, or only the selected ones."""
        return [
            q for q in questions().values() if q.notebook == number and (not only or q.name in only)
        ]

    def functions(self) -> dict[str, list[str]]:
        """Return the functions that each notebook asks for."""
        return {s.number: [q.function for q in self.asked(s.number)] for s in self.sources}

    def source(self, number: str) -> Source:
        """Return the source of a notebook."""
        return next(source for source in self.sources if source.number == number)

    def checks(self, name: str) -> Mapping[str, str]:
        """Return the digests of the checks of a question, in the order in which they run.

        An edit of one check does not change the digest of another.
        """
        return _checks(self.source(name.partition(".")[0]).path, name)

    def solution(self, name: str) -> dict[str, Any]:
        """Return the functions of the solution of a question's notebook."""
        return _material(self.source(name.partition(".")[0]).path).functions

    def given(self, name: str) -> tuple[str, ...]:
        """Return the earlier questions whose right functions an answer may be given.

        They are those that the solution calls, and those that the question names, so that calling
        them does not replace an answer.
        """
        return _given(self.source(name.partition(".")[0]).path, name)

    def made_by(self, name: str) -> str:
        """Return the digest of all that a verdict depends on, except the answer."""
        return _made_by(self.source(name.partition(".")[0]).path, name)

    def trials(
        self, number: str, student: str, only: Collection[str] = ()
    ) -> dict[str, tuple[Trial, ...]]:
        """Return the trials of a student's answers to a notebook, by question."""
        path = self.source(number).path
        with LOCK:
            made = _material(path)
            return {
                q.name: trials(
                    q,
                    made.functions,
                    made.mistakes,
                    made.hidden,
                    student,
                    self.salt,
                    _public(path, q.name),
                )
                for q in self.asked(number, only)
            }


@dataclass(frozen=True)
class _Material:
    functions: dict[str, Any]
    mistakes: list[Entry]
    hidden: list[Hidden]

    def of(self, name: str) -> _Material:
        """Return the material of one question."""
        mistakes = [m for m in self.mistakes if m.question == name]
        hidden = [h for h in self.hidden if h.question == name]
        return _Material(self.functions, mistakes, hidden)


@cache
def _material(path: Path) -> _Material:
    """Return the functions, mistakes and hidden cases of a source, read once per process."""
    with LOCK:
        source = Source(path)
        mistakes = entries(source, "misconceptions")
        return _Material(source.functions(), mistakes, hidden_cases(source))


@cache
def _public(path: Path, name: str) -> Trial:
    made = _material(path)
    return public_trial(questions()[name], made.functions, made.mistakes)


@cache
def _given(path: Path, name: str) -> tuple[str, ...]:
    question = questions()[name]
    called = {other.name for other in solution_calls(question, _material(path).functions)}
    return tuple(
        q.name for q in earlier_questions(question) if q.name in {*called, *question.may_call}
    )


@cache
def _made_by(path: Path, name: str) -> str:
    made, question = _material(path).of(name), questions()[name]
    return dependency_digest(
        question, made.functions[question.function], made.mistakes, made.hidden
    )


@cache
def _checks(path: Path, name: str) -> dict[str, str]:
    made, question = _material(path).of(name), questions()[name]
    known = made.functions[question.function], made.mistakes
    hidden = {
        h.name: dependency_digest(asked_by(h, question), h.sentence, known) for h in made.hidden
    }
    return dict.fromkeys((PUBLIC, OWN), dependency_digest(question, known)) | hidden
