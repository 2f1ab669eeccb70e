"""pytest as the engine of grading: a submission, a question and a check make an item.

``pytest -p fieldgrade.grading.plugin --submissions DIR --out OUT`` grades a class, and so
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

from fieldgrade.checking import workplace
from fieldgrade.checking.checks import Checked, behind_walls
from fieldgrade.checking.examine import Fault
from fieldgrade.checking.results import Record, Results
from fieldgrade.grading.batch import Batch, Portion
from fieldgrade.grading.instructors import USAGE, Instructor, check_of, parametrized, place_of_item
from fieldgrade.grading.items import Item, Place, items, places
from fieldgrade.grading.options import declare, run_of
from fieldgrade.grading.reports import Findings, place_of, written
from fieldgrade.grading.run import Run
from fieldgrade.submissions.submission import Submission

CHECKED, FAULT = pytest.StashKey[Checked](), pytest.StashKey[str]()


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
    return behind_walls(grading.run.server, grading.submission(request.param))


def grading_of(config: pytest.Config) -> Grading | None:
    """Return the run of a session of pytest, if it has been registered."""
    plugins = config.pluginmanager.get_plugins()
    return next((plugin for plugin in plugins if isinstance(plugin, Grading)), None)


class Grading:
    """The plugin of one run.

    Parameters
    ----------
    run : Run
        What is graded.
    executor, told
        As for `fieldgrade.grading.engine.graded`.
    """

    def __init__(
        self,
        run: Run,
        executor: Executor | None = None,
        told: Callable[[int, int], None] = lambda *_: None,
    ) -> None:
        self.run, self.executor, self.told = run, executor, told
        self.findings = Findings()
        self.results: Results | None = None
        self.changed = False
        self.problems: list[str] = []
        self.error: BaseException | None = None
        self._instructor = Instructor(run)
        self._portions: dict[Place, Portion] = {}
        self._records: dict[Place, Record] = {}
        self._fresh: list[Record] = []
        self._of: Counter[Place] = Counter()
        self._stream: Iterator[tuple[Portion, Record]] = iter(())
        self._open = ExitStack()
        self._is_worker = False

    # Collecting.

    def pytest_sessionstart(self, session: pytest.Session) -> None:
        """Let servers be started from here on."""
        self._is_worker = hasattr(session.config, "workerinput")
        self._open.enter_context(workplace.opened())

    def pytest_generate_tests(self, metafunc: pytest.Metafunc) -> None:
        """Make items of the checks of instructors."""
        parametrized(metafunc, self.run.portions())

    @pytest.hookimpl(wrapper=True, tryfirst=True)
    def pytest_collection_modifyitems(
        self, session: pytest.Session, items: list[pytest.Item]
    ) -> Generator[None, None, None]:
        """Put the items of submissions in front; then see which of all are chosen."""
        items[:0] = self._items(session)
        self._of = Counter(filter(None, map(_place, items)))
        yield
        chosen = set(filter(None, map(_place, items)))
        for portion in self.run.portions():
            at = [place for place in places(portion) if place in chosen]
            if at:
                questions = tuple(place.question for place in at if place.question)
                self._portions[at[0].whole] = Portion(portion.handed, questions)

    def _items(self, session: pytest.Session) -> list[pytest.Item]:
        run = self.run
        return [i for p in run.portions() for i in items(session, p, run.course, self.record)]

    def pytest_collectreport(self, report: pytest.CollectReport) -> None:
        """Remember what could not be collected."""
        if report.failed:
            self.problems.append(report.longreprtext)

    # Running.

    def pytest_runtestloop(self, session: pytest.Session) -> None:
        """Begin: one process does all; those of pytest-xdist each do what they are told to."""
        if self._is_worker or getattr(session.config.option, "dist", "no") != "no":
            return
        workers = min(self.run.jobs, len(self._portions)) or 1
        self._stream = self._batch(workers).records(self._portions.values())

    def _batch(self, workers: int) -> Batch:
        run = self.run
        if self.executor is None:
            self.executor = self._open.enter_context(workplace.workers(workers))
        return Batch(
            run.course, run.server, run.archive, run.cache, run.ledger, self.executor, workers
        )

    def record(self, place: Place) -> Record:
        """Return the record of a submission, once it is there."""
        if self._is_worker and place.whole not in self._records:
            self._stream = self._batch(1).records([self._portions[place.whole]])
        while place.whole not in self._records:
            try:
                _, record = next(self._stream)
            except Exception as error:  # of the executor, or of the disk: not of a submission
                self.error = error
                pytest.exit(f"the grader failed: {error!r}", pytest.ExitCode.INTERNAL_ERROR)
            self._records[place_of(record)] = record
            self._fresh.append(record)
            self.told(len(self._records), len(self._portions))
        return self._records[place.whole]

    def submission(self, place: Place) -> Submission:
        """Return what was handed in."""
        return self._portions[place.whole].handed.submission(self.run.archive)

    @pytest.hookimpl(tryfirst=True)
    def pytest_pyfunc_call(self, pyfuncitem: pytest.Function) -> bool | None:
        """Make the check of an instructor, if the answer is right so far."""
        place, check = place_of_item(pyfuncitem), check_of(pyfuncitem)
        if place is None or check is None:
            return None
        grades = {grade.question: grade for grade in self.record(place).grades}
        if place.question not in grades or not grades[place.question].verdict.right:
            pytest.skip(f"{place.question} is not right")
        try:
            checked = self._instructor.checked(pyfuncitem, check, self.submission(place))
        except Fault as fault:
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
            self.findings.add(report.graded)

    @pytest.hookimpl(trylast=True)
    def pytest_sessionfinish(self, exitstatus: int) -> None:
        """Write the results, unless the run was interrupted, and end the servers."""
        try:
            whole = exitstatus in (pytest.ExitCode.OK, pytest.ExitCode.TESTS_FAILED)
            if whole and not self._is_worker:
                self.results, self.changed = self.run.finish(self.findings.complete())
        finally:
            self._open.close()


def _place(item: pytest.Item) -> Place | None:
    return item.place if isinstance(item, Item) else place_of_item(item)
