"""A class graded by any executor: cached results are reused, and no submission stops the batch.

The results of a submission are cached as soon as they are known. A run that was killed continues
where it stopped when it is started again.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Executor, Future, wait
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, TypeVar

from fieldgrade.checking.cache import Cache, keys
from fieldgrade.checking.check_results import (
    CheckResult,
    CheckResults,
    pending,
    up_to_first_failure,
)
from fieldgrade.checking.course import Course
from fieldgrade.checking.grade_submission import SandboxRun, assemble_record, run_checks
from fieldgrade.checking.results import Record
from fieldgrade.grading.ledger import Ledger
from fieldgrade.isolation import worker_servers
from fieldgrade.isolation.server import Server
from fieldgrade.submissions.archive import Archive
from fieldgrade.submissions.collection import ReceivedFile
from fieldgrade.submissions.submission import Submission

T = TypeVar("T")
S = TypeVar("S")


@dataclass(frozen=True)
class GradingTask:
    """A received file and the questions to be graded in it; none if it is unreadable."""

    file: ReceivedFile
    questions: tuple[str, ...] = ()


@dataclass(frozen=True)
class CachedResults:
    """The cached results of a submission, by question and check.

    Parameters
    ----------
    keys : mapping
        The cache keys; the checks are in the order of the course.
    results : mapping
        The results that are in the cache.
    """

    keys: Mapping[str, Mapping[str, str]]
    results: CheckResults

    def missing(self) -> dict[str, tuple[str, ...]]:
        """Return the checks that have to be run."""
        todo = {q: tuple(pending(checks, self.results[q])) for q, checks in self.keys.items()}
        return {question: checks for question, checks in todo.items() if checks}

    def completed(self, new: CheckResults) -> CheckResults:
        """Return the results of all questions, cached and new."""
        return {
            q: up_to_first_failure(checks, {**self.results[q], **new.get(q, {})})
            for q, checks in self.keys.items()
        }


def run_in_worker(
    course: Course,
    server: Server,
    submission: Submission,
    notebook: str,
    checks: Mapping[str, tuple[str, ...]],
    known: CheckResults,
) -> SandboxRun:
    """Run checks with the server of this thread; if the server fails, with a new one.

    Raises
    ------
    GraderError
        The grader fails with the new server too.
    """
    return worker_servers.with_server(
        server.tier,
        server.limits,
        lambda s: run_checks(course, s, submission, notebook, checks, known),
    )


@dataclass(frozen=True)
class Batch:
    """The grading of a class: trusted side, sandbox, cache and executor.

    Parameters
    ----------
    course : Course
        The trusted side.
    server : Server
        The sandbox, not started: each worker starts its own.
    archive : Archive
        The received files.
    cache : Cache
        The results of earlier runs.
    ledger : Ledger
        The log of what ran.
    executor : Executor
        Threads, processes, or other machines that see the same folders.
    workers : int
        How many submissions run at once; twice as many are read ahead.
    """

    course: Course
    server: Server
    archive: Archive
    cache: Cache
    ledger: Ledger
    executor: Executor
    workers: int = 1

    def records(self, tasks: Iterable[GradingTask]) -> Iterator[tuple[GradingTask, Record]]:
        """Yield a record for each task, as they are completed; no submission ends this.

        Raises
        ------
        BrokenExecutor
            The executor takes no more work.
        OSError
            The results cannot be kept, for example on a full disk.
        """
        return as_completed_in_window(self._begin, tasks, 2 * self.workers)

    def _begin(
        self, task: GradingTask
    ) -> tuple[Future[Any] | None, Callable[[], tuple[GradingTask, Record]]]:
        """Begin a task: return the future to wait for, and the function to call after it."""
        try:
            future, finish = self._submit(task)
        except BrokenExecutor:
            raise
        except Exception as error:  # the submission is listed, and the class is graded
            record = _with_receipt(task.file, self._failed(task, error))
            return None, lambda: (task, record)
        return future, lambda: (task, _with_receipt(task.file, finish()))

    def _submit(self, task: GradingTask) -> tuple[Future[Any] | None, Callable[[], Record]]:
        """Submit the checks whose results are not cached."""
        if not task.file.notebook:
            return None, lambda: _unreadable(task.file)
        submission = task.file.submission(self.archive).parsed()
        cached = self._cached(submission, task.questions)
        todo = cached.missing()
        if not todo:
            record = self._record(task, submission, cached, SandboxRun({}))
            return None, lambda: record
        known = {q: its for q, its in cached.results.items() if q not in todo}
        work = self.course, self.server, submission, task.file.notebook, todo, known
        future = self.executor.submit(run_in_worker, *work)
        again = partial(worker_servers.run_alone, run_in_worker, *work)
        return future, lambda: self._finish(task, submission, cached, future, again)

    def _cached(self, submission: Submission, questions: Iterable[str]) -> CachedResults:
        names = {q: keys(self.course, self.server, submission, q) for q in questions}
        kept = self.cache.get(submission)
        results = {
            q: {check: kept[name] for check, name in checks.items() if name in kept}
            for q, checks in names.items()
        }
        return CachedResults(names, results)

    def _finish(
        self,
        task: GradingTask,
        submission: Submission,
        cached: CachedResults,
        future: Future[SandboxRun],
        again: Callable[[], SandboxRun],
    ) -> Record:
        """Cache the new results, note them in the ledger, and return the record.

        If the worker process was lost, the submission runs once more, `again`. An error of the
        grader with one submission is a status of this submission.

        Raises
        ------
        OSError
            The results cannot be kept.
        """
        try:
            sandbox_run = _first_or_again(future, again)
            record = self._record(task, submission, cached, sandbox_run)
        except Exception as error:
            return self._failed(task, error)
        new, made = dict[str, CheckResult](), dict[str, dict[str, str]]()
        for question, results in sandbox_run.results.items():
            made[question] = {check: self.course.checks(question)[check] for check in results}
            new |= {cached.keys[question][check]: r for check, r in results.items()}
        self.cache.put(submission, new)
        self.ledger.note(record, made)
        return record

    def _record(
        self,
        task: GradingTask,
        submission: Submission,
        cached: CachedResults,
        sandbox_run: SandboxRun,
    ) -> Record:
        complete = replace(sandbox_run, results=cached.completed(sandbox_run.results))
        tier, notebook = self.server.tier, task.file.notebook
        return assemble_record(self.course, submission, notebook, tier, complete)

    def _failed(self, task: GradingTask, error: Exception) -> Record:
        file, note = task.file, f"the grader failed: {error}"
        return Record(
            file.student,
            file.name,
            file.digest,
            file.notebook,
            "grader failed",
            self.server.tier,
            notes=(note,),
        )


def _first_or_again(future: Future[SandboxRun], again: Callable[[], SandboxRun]) -> SandboxRun:
    try:
        return future.result()
    except BrokenExecutor:  # perhaps for another submission that ran at the same time
        return again()


def _unreadable(file: ReceivedFile) -> Record:
    return Record(file.student, file.name, file.digest, "", "unreadable", "", notes=(file.problem,))


def _with_receipt(file: ReceivedFile, record: Record) -> Record:
    """Return a record with the time of receipt and the notes of the intake."""
    return replace(
        record,
        digest=file.digest,
        received=file.received,
        received_by=file.received_by,
        late_mark=file.late_mark,
        notes=(*record.notes, *file.notes),
    )


def as_completed_in_window(
    begin: Callable[[S], tuple[Future[Any] | None, Callable[[], T]]], items: Iterable[S], ahead: int
) -> Iterator[T]:
    """Yield the results of items as they are completed, with a bounded number begun at a time.

    Parameters
    ----------
    begin : callable
        From an item to a future, or None if there is nothing to wait for, and to a function that is
        called when the future is done and returns what is yielded.
    items : iterable
        Items are taken when there is room, so that not all are in memory.
    ahead : int
        The largest number of items that are begun and not completed.
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
                yield from _completed(waiting)
        while waiting:
            yield from _completed(waiting)
    finally:
        for future in waiting:
            future.cancel()


def _completed(waiting: dict[Future[Any], Callable[[], T]]) -> Iterator[T]:
    for future in wait(waiting, return_when=FIRST_COMPLETED).done:
        yield waiting.pop(future)()
