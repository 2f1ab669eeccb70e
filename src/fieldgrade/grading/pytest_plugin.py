"""pytest as the engine of grading: a submission, a question and a check make an item.

``pytest -p fieldgrade.grading.pytest_plugin --submissions DIR --out OUT`` grades a class, and so
does ``fieldrecon grade``, which calls it. A batch does the work behind walls, and items wait for
what it finds. With ``-n`` each process of pytest-xdist has walls of its own, and what belongs to a
submission stays together.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Generator, Iterator
from concurrent.futures import Executor
from contextlib import ExitStack
from typing import Any

import pytest

from fieldgrade.checking.instructor_checks import InstructorCheckResult, answer_of_submission
from fieldgrade.checking.results import Record, Results
from fieldgrade.grading.batch import Batch, GradingTask
from fieldgrade.grading.instructor_items import (
    USAGE,
    Instructor,
    answer_of_item,
    check_of,
    parametrized,
)
from fieldgrade.grading.options import declare, run_of
from fieldgrade.grading.pytest_items import AnswerId, CheckItem, answer_ids, items
from fieldgrade.grading.pytest_reports import ReportCollector, answer_of_record, written
from fieldgrade.grading.run import GradingRun
from fieldgrade.isolation import worker_servers
from fieldgrade.isolation.server import GraderError
from fieldgrade.submissions.submission import Submission

CHECKED, FAULT = pytest.StashKey[InstructorCheckResult](), pytest.StashKey[str]()


def pytest_addoption(parser: pytest.Parser) -> None:
    """Declare the options."""
    group = parser.getgroup("grading", "grading a class")
    group.addoption("--submissions", metavar="DIR", help="the folder or zip file to be graded")
    declare(group.addoption)


@pytest.hookimpl(tryfirst=True)
def pytest_configure(config: pytest.Config) -> None:
    """Prepare to grade what the options say, and to collect the checks of instructors only."""
    if not config.option.submissions:
        return
    grading = grading_of(config)
    if grading is None:
        try:
            grading = Grading(run_of(config.option)[0])
            _ = grading.run.taken
        except ValueError as error:
            raise pytest.UsageError(str(error)) from None
        config.pluginmanager.register(grading)
    config.args[:] = [str(grading.run.checks)] if grading.run.checks else []
    config.addinivalue_line("markers", USAGE)
    if getattr(config.option, "dist", "no") == "load":
        config.option.dist = "loadgroup"


@pytest.fixture
def answer(request: pytest.FixtureRequest) -> Any:
    """What a student's functions return, called behind walls: ``answer("01.2", *arguments)``."""
    grading = grading_of(request.config)
    assert grading is not None
    return answer_of_submission(grading.run.server, grading.submission(request.param))


def grading_of(config: pytest.Config) -> Grading | None:
    """Return the run of a session of pytest, if it has been registered."""
    plugins = config.pluginmanager.get_plugins()
    return next((plugin for plugin in plugins if isinstance(plugin, Grading)), None)


class Grading:
    """The plugin of one run.

    Parameters
    ----------
    run : GradingRun
        What is graded.
    executor, progress
        As for `fieldgrade.grading.grade_class.grade_class`.
    """

    def __init__(
        self,
        run: GradingRun,
        executor: Executor | None = None,
        progress: Callable[[int, int], None] = lambda *_: None,
    ) -> None:
        self.run, self.executor, self.progress = run, executor, progress
        self.collector = ReportCollector()
        self.results: Results | None = None
        self.changed = False
        self.problems: list[str] = []
        self.error: BaseException | None = None
        self._instructor = Instructor(run)
        self._tasks: dict[AnswerId, GradingTask] = {}
        self._records: dict[AnswerId, Record] = {}
        self._fresh: list[Record] = []
        self._of: Counter[AnswerId] = Counter()
        self._stream: Iterator[tuple[GradingTask, Record]] = iter(())
        self._open = ExitStack()
        self._is_worker = False

    # Collecting.

    def pytest_sessionstart(self, session: pytest.Session) -> None:
        """Let servers be started from here on."""
        self._is_worker = hasattr(session.config, "workerinput")
        self._open.enter_context(worker_servers.serving())

    def pytest_generate_tests(self, metafunc: pytest.Metafunc) -> None:
        """Make items of the checks of instructors."""
        parametrized(metafunc, self.run.tasks())

    @pytest.hookimpl(wrapper=True, tryfirst=True)
    def pytest_collection_modifyitems(
        self, session: pytest.Session, items: list[pytest.Item]
    ) -> Generator[None, None, None]:
        """Put the items of submissions in front; then see which of all are chosen."""
        items[:0] = self._items(session)
        self._of = Counter(filter(None, map(_place, items)))
        yield
        chosen = set(filter(None, map(_place, items)))
        for task in self.run.tasks():
            at = [place for place in answer_ids(task) if place in chosen]
            if at:
                questions = tuple(place.question for place in at if place.question)
                self._tasks[at[0].whole] = GradingTask(task.file, questions)

    def _items(self, session: pytest.Session) -> list[pytest.Item]:
        run = self.run
        return [i for p in run.tasks() for i in items(session, p, run.course, self.record)]

    def pytest_collectreport(self, report: pytest.CollectReport) -> None:
        """Remember what could not be collected."""
        if report.failed:
            self.problems.append(report.longreprtext)

    # Running.

    def pytest_runtestloop(self, session: pytest.Session) -> None:
        """Begin: one process does all; those of pytest-xdist each do what they are told to."""
        if self._is_worker or getattr(session.config.option, "dist", "no") != "no":
            return
        workers = min(self.run.jobs, len(self._tasks)) or 1
        self._stream = self._batch(workers).records(self._tasks.values())

    def _batch(self, workers: int) -> Batch:
        run = self.run
        if self.executor is None:
            self.executor = self._open.enter_context(worker_servers.worker_pool(workers))
        return Batch(
            run.course, run.server, run.archive, run.cache, run.ledger, self.executor, workers
        )

    def record(self, place: AnswerId) -> Record:
        """Return the record of a submission, once it is there."""
        if self._is_worker and place.whole not in self._records:
            self._stream = self._batch(1).records([self._tasks[place.whole]])
        while place.whole not in self._records:
            try:
                _, record = next(self._stream)
            except Exception as error:  # of the executor, or of the disk: not of a submission
                self.error = error
                pytest.exit(f"the grader failed: {error!r}", pytest.ExitCode.INTERNAL_ERROR)
            self._records[answer_of_record(record)] = record
            self._fresh.append(record)
            self.progress(len(self._records), len(self._tasks))
        return self._records[place.whole]

    def submission(self, place: AnswerId) -> Submission:
        """Return what was handed in."""
        return self._tasks[place.whole].file.submission(self.run.archive)

    @pytest.hookimpl(tryfirst=True)
    def pytest_pyfunc_call(self, pyfuncitem: pytest.Function) -> bool | None:
        """Make the check of an instructor, if the answer is right so far."""
        place, check = answer_of_item(pyfuncitem), check_of(pyfuncitem)
        if place is None or check is None:
            return None
        grades = {grade.question: grade for grade in self.record(place).grades}
        if place.question not in grades or not grades[place.question].verdict.right:
            pytest.skip(f"{place.question} is not right")
        try:
            checked = self._instructor.checked(pyfuncitem, check, self.submission(place))
        except GraderError as fault:
            pyfuncitem.stash[FAULT] = str(fault)
            pytest.fail(f"the grader failed: {fault}", pytrace=False)
        pyfuncitem.stash[CHECKED] = checked
        if not checked.passed:
            pytest.fail(check.sentence, pytrace=False)
        return True

    # Telling.

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_makereport(
        self, item: pytest.Item, call: pytest.CallInfo[None]
    ) -> Generator[None, Any, Any]:
        """Let the last report of an item carry what was found."""
        report: Any = yield
        place = _place(item)
        if place and call.when == "teardown":
            fresh, self._fresh = self._fresh, []
            checked, fault = item.stash.get(CHECKED, None), item.stash.get(FAULT, "")
            report.graded = written(place, self._of[place], fresh, checked, fault)
        return report

    def pytest_internalerror(self, excinfo: pytest.ExceptionInfo[BaseException]) -> None:
        """Remember what broke the session."""
        self.error = excinfo.value

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Gather what was found, in this process or in others."""
        if hasattr(report, "graded"):
            self.collector.add(report.graded)

    @pytest.hookimpl(trylast=True)
    def pytest_sessionfinish(self, exitstatus: int) -> None:
        """Write the results, unless the run was interrupted, and end the servers."""
        try:
            whole = exitstatus in (pytest.ExitCode.OK, pytest.ExitCode.TESTS_FAILED)
            if whole and not self._is_worker:
                self.results, self.changed = self.run.finish(self.collector.complete())
        finally:
            self._open.close()


def _place(item: pytest.Item) -> AnswerId | None:
    return item.place if isinstance(item, CheckItem) else answer_of_item(item)
