"""A class, graded: by any executor, as far as it is not known from before, and to the end.

What is found of a submission is kept as soon as it is found. A run that is killed goes on where it
stopped when it is started again, since what is kept is not done twice.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Executor, Future, wait
from dataclasses import dataclass, replace
from typing import Any, TypeVar

from fieldgrade.checking import workplace
from fieldgrade.checking.cache import Cache, keys
from fieldgrade.checking.examine import Examined, assembled, examine
from fieldgrade.checking.findings import Finding, Found, reached, unknown
from fieldgrade.checking.results import Record
from fieldgrade.checking.trusted import Course
from fieldgrade.grading.ledger import Ledger
from fieldgrade.isolation.isolation import Server
from fieldgrade.submissions.archive import Archive
from fieldgrade.submissions.intake import Handed
from fieldgrade.submissions.submission import Submission

T = TypeVar("T")
S = TypeVar("S")


@dataclass(frozen=True)
class Portion:
    """What was handed in, and which questions of it are to be graded: none if it is unreadable."""

    handed: Handed
    questions: tuple[str, ...] = ()


@dataclass(frozen=True)
class Job:
    """Checks to be made of a submission, with all that a process elsewhere has to know."""

    course: Course
    server: Server
    submission: Submission
    notebook: str
    checks: Mapping[str, tuple[str, ...]]


@dataclass(frozen=True)
class Known:
    """What was known of a submission beforehand, by question and check.

    Parameters
    ----------
    keys : mapping
        Under which names the findings are kept; the checks are in the order of the course.
    findings : mapping
        Those that are there.
    """

    keys: Mapping[str, Mapping[str, str]]
    findings: Found

    def missing(self) -> dict[str, tuple[str, ...]]:
        """Return the checks that have to be made."""
        made = {q: tuple(unknown(its, self.findings[q])) for q, its in self.keys.items()}
        return {question: checks for question, checks in made.items() if checks}

    def completed(self, found: Found) -> Found:
        """Return the findings on all questions, those just made among them."""
        return {
            q: reached(its, {**self.findings[q], **found.get(q, {})})
            for q, its in self.keys.items()
        }


def work(job: Job) -> Examined:
    """Examine a submission with the server of this thread; try again if the server fails.

    Raises
    ------
    Fault
        The grader fails, also with a fresh server.
    """
    return workplace.served(
        job.server.tier,
        job.server.limits,
        lambda s: examine(job.course, s, job.submission, job.notebook, job.checks),
    )


@dataclass(frozen=True)
class Batch:
    """How a class is graded.

    Parameters
    ----------
    course : Course
        The trusted side.
    server : Server
        The walls, not started: each worker starts its own.
    archive : Archive
        Where the submissions are.
    cache : Cache
        What was found before.
    ledger : Ledger
        Where it is noted what ran.
    executor : Executor
        What does the work: of threads, of processes, of other machines that see the same folders.
    workers : int
        How many submissions are worked on at once; twice as many are read beforehand.
    """

    course: Course
    server: Server
    archive: Archive
    cache: Cache
    ledger: Ledger
    executor: Executor
    workers: int = 1

    def records(self, portions: Iterable[Portion]) -> Iterator[tuple[Portion, Record]]:
        """Yield a record for each portion, as they come; no submission ends this."""
        return as_they_come(self._begun, portions, 2 * self.workers)

    def _begun(
        self, portion: Portion
    ) -> tuple[Future[Any] | None, Callable[[], tuple[Portion, Record]]]:
        """Begin with a submission: return what has to be waited for, and then to be called."""
        try:
            future, finish = self._submitted(portion)
        except (BrokenExecutor, OSError):
            raise
        except Exception as error:  # the sources of a course may be broken
            record = self._fault(portion, error)
            return None, lambda: (portion, record)
        return future, lambda: (portion, _told(portion.handed, finish()))

    def _submitted(self, portion: Portion) -> tuple[Future[Any] | None, Callable[[], Record]]:
        """Have a submission examined, as far as it is not known."""
        handed = portion.handed
        if not handed.notebook:
            return None, lambda: _unreadable(handed)
        submission = handed.submission(self.archive)
        _ = submission.definitions  # here, where the stack is deep enough for any syntax tree
        known = self._known(submission, portion.questions)
        todo = known.missing()
        if not todo:
            return None, lambda: self._record(portion, submission, known, Examined({}))
        job = Job(self.course, self.server, submission, handed.notebook, todo)
        future = self.executor.submit(work, job)
        return future, lambda: self._finished(portion, submission, known, future)

    def _known(self, submission: Submission, questions: Iterable[str]) -> Known:
        names = {q: keys(self.course, self.server, submission, q) for q in questions}
        kept = self.cache.get(submission)
        known = {
            q: {check: kept[name] for check, name in its.items() if name in kept}
            for q, its in names.items()
        }
        return Known(names, known)

    def _finished(
        self, portion: Portion, submission: Submission, known: Known, future: Future[Examined]
    ) -> Record:
        """Keep what was found, note it, and return the record."""
        try:
            examined = future.result()
        except BrokenExecutor:
            raise
        except Exception as error:
            return self._fault(portion, error)
        found, made = dict[str, Finding](), dict[str, dict[str, str]]()
        for question, findings in examined.findings.items():
            made[question] = {check: self.course.checks(question)[check] for check in findings}
            found |= {known.keys[question][check]: f for check, f in findings.items()}
        self.cache.put(submission, found)
        record = self._record(portion, submission, known, examined)
        self.ledger.note(record, made)
        return record

    def _record(
        self, portion: Portion, submission: Submission, known: Known, examined: Examined
    ) -> Record:
        tier, notebook = self.server.tier, portion.handed.notebook
        complete = replace(examined, findings=known.completed(examined.findings))
        return assembled(self.course, submission, notebook, tier, complete)

    def _fault(self, portion: Portion, error: Exception) -> Record:
        file, note = portion.handed.file, f"the grader failed: {error}"
        return Record(
            file.student,
            file.name,
            file.digest,
            portion.handed.notebook,
            "fault",
            self.server.tier,
            notes=(note,),
        )


def _unreadable(handed: Handed) -> Record:
    file = handed.file
    return Record(
        file.student, file.name, file.digest, "", "unreadable", "", notes=(handed.problem,)
    )


def _told(handed: Handed, record: Record) -> Record:
    """Return a record with what is known from the intake."""
    file = handed.file
    return replace(
        record,
        digest=file.digest,
        received=file.received,
        received_by=file.received_by,
        late_mark=file.late_mark,
        notes=(*record.notes, *handed.notes),
    )


def as_they_come(
    begin: Callable[[S], tuple[Future[Any] | None, Callable[[], T]]], items: Iterable[S], ahead: int
) -> Iterator[T]:
    """Yield what becomes of items, as they come, with at most so many begun at a time.

    Parameters
    ----------
    begin : callable
        From an item to a future, or None if there is nothing to wait for, and to what is called
        when it is done, which returns what is yielded.
    items : iterable
        They are taken when there is room, so that not all are in memory.
    ahead : int
        The most that are begun and not done.
    """
    waiting: dict[Future[Any], Callable[[], T]] = {}
    try:
        for item in items:
            future, finish = begin(item)
            if future is None:
                yield finish()
                continue
            waiting[future] = finish
            if len(waiting) >= ahead:
                yield from _done(waiting)
        while waiting:
            yield from _done(waiting)
    finally:
        for future in waiting:
            future.cancel()


def _done(waiting: dict[Future[Any], Callable[[], T]]) -> Iterator[T]:
    for future in wait(waiting, return_when=FIRST_COMPLETED).done:
        yield waiting.pop(future)()
