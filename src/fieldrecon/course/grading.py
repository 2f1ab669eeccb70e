"""From a submission to a record of its grades: run behind walls, judged on this side."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Literal

from fieldcheck.calls import Outcome
from fieldcheck.ladder import PATIENCE, judge
from fieldcheck.question import Question
from fieldcheck.questions import questions
from fieldcheck.verdict import Verdict
from fieldrecon.course.catalogue import entries
from fieldrecon.course.hidden import hidden_cases
from fieldrecon.course.isolation import Server, Tier
from fieldrecon.course.session import Log, Task, run
from fieldrecon.course.sources import Source
from fieldrecon.course.submission import Submission, Unreadable
from fieldrecon.course.trials import Trial, trials

Status = Literal[
    "graded", "partly", "unreadable", "killed: time", "killed: memory", "killed: output"
]  # fmt: skip


@dataclass(frozen=True)
class Grade:
    """What an answer earns.

    Parameters
    ----------
    question : str
        Its name.
    points, possible : float
        Earned, and to be earned.
    verdict : Verdict
        How far up the ladder it came, and the sentence for the student.
    trial : int
        Which trial decided: 0 the public cases, 1 the student's own inputs, 2 and more hidden ones.
    """

    question: str
    points: float
    possible: float
    verdict: Verdict
    trial: int


@dataclass(frozen=True)
class Record:
    """All that is known of a graded submission.

    Parameters
    ----------
    student, file, digest : str
        Whose, under which name it came, and the SHA-256 of its content.
    notebook : str
        Which notebook it is; empty if it is none.
    status : str
        How it went.
    tier : str
        Behind which walls it ran.
    grades : tuple of Grade
        One for each question of the notebook.
    notes : tuple of str
        What the instructor should know, such as a stub behind a working answer.
    seconds, cpu_seconds : float
        Time taken.
    peak : int
        Bytes of memory at most.
    """

    student: str
    file: str
    digest: str
    notebook: str
    status: Status
    tier: Tier
    grades: tuple[Grade, ...] = ()
    notes: tuple[str, ...] = ()
    seconds: float = 0.0
    cpu_seconds: float = 0.0
    peak: int = 0

    @property
    def points(self) -> float:
        """The points of all questions together."""
        return sum(grade.points for grade in self.grades)


@dataclass(frozen=True)
class Course:
    """The trusted side: the sources, and what each question is worth.

    Parameters
    ----------
    sources : sequence of Source
        The notebooks.
    salt : str
        From which hidden inputs are drawn.
    worth : mapping
        Points that differ from those of the questions.
    """

    sources: Sequence[Source]
    salt: str
    worth: Mapping[str, float] = field(default_factory=dict)

    def asked(self, number: str, only: Iterable[str] = ()) -> list[Question]:
        """Return the questions of a notebook, or those of them that are chosen."""
        chosen = tuple(only)
        return [
            q for q in questions().values()
            if q.notebook == number and (not chosen or q.name in chosen)
        ]  # fmt: skip

    def functions(self) -> dict[str, list[str]]:
        """Return which functions each notebook asks for."""
        return {s.number: [q.function for q in self.asked(s.number)] for s in self.sources}

    def source(self, number: str) -> Source:
        """Return the source of a notebook."""
        return next(source for source in self.sources if source.number == number)

    def trials(self, number: str, student: str, only: Iterable[str] = ()) -> dict[str, list[Trial]]:
        """Return what the answers of a student to a notebook go through, by question."""
        source = self.source(number)
        functions, mistakes = source.functions(), entries(source, "misconceptions")
        hidden = hidden_cases(source)
        return {
            q.name: list(trials(q, functions, mistakes, hidden, student, self.salt))
            for q in self.asked(number, only)
        }


def grade(
    course: Course, server: Server, submission: Submission, only: Iterable[str] = ()
) -> Record:
    """Grade a submission behind the walls of a started server.

    Nothing of it is imported, executed or unpickled on this side: its code goes to the server as
    text, and arrays come back, which are judged here.

    Returns
    -------
    Record
        Also for what cannot be read: a batch never stops because of a submission.
    """
    try:
        number = submission.notebook(course.functions())
    except Unreadable as error:
        return Record(
            submission.student, submission.name, submission.digest, "", "unreadable", server.tier,
            notes=(str(error),),
        )  # fmt: skip
    tried = course.trials(number, submission.student, only)
    tasks = [
        Task(f"{name} {k}", trial.calls, PATIENCE * trial.question.limit)
        for name, gone_through in tried.items() for k, trial in enumerate(gone_through)
        if trial.question.function in submission.definitions
    ]  # fmt: skip
    outcomes, log = run(server, submission.cells, tasks)
    grades = tuple(_grade(course, name, its, outcomes) for name, its in tried.items())
    return Record(
        submission.student, submission.name, submission.digest, number, _status(log), server.tier,
        grades, tuple(_notes(submission, tried, log)), log.seconds,
        sum(p.cpu_seconds for p in log.processes), max((p.peak for p in log.processes), default=0),
    )  # fmt: skip


def _grade(
    course: Course, name: str, tried: Sequence[Trial], outcomes: Mapping[str, Any]
) -> Grade:
    """Return the grade of an answer: that of the first trial that it does not pass."""
    question = tried[0].question
    worth = course.worth.get(name, question.points)
    for index, trial in enumerate(tried):
        came = outcomes.get(f"{name} {index}", (Outcome("missing"),) * len(trial.calls))
        verdict = trial.told(judge(trial.question, trial.calls, came, trial.answers))
        if not verdict.right:
            break
    return Grade(name, worth * verdict.credit, worth, replace(verdict, picture=""), index)


def _status(log: Log) -> Status:
    for reason in ("memory", "output", "time"):
        if reason in log.killed:
            return f"killed: {reason}"  # type: ignore[return-value]
    return "partly" if log.killed else "graded"


def _notes(
    submission: Submission, tried: Mapping[str, Sequence[Trial]], log: Log
) -> Iterable[str]:
    """Yield what the instructor should look at."""
    for name, its in tried.items():
        stubs = submission.definitions.get(its[0].question.function, ())
        if len(stubs) > 1 and stubs[-1] and not all(stubs):
            yield f"{name}: a stub stands behind an answer, and takes its place"
    for number, error in log.cell_errors.items():
        yield f"code cell {number + 1}: {error}"
