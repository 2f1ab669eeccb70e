"""The pytest plugin that grades a class: an item is a check of an answer.

``pytest -p fieldgrade.grading.pytest_plugin --submissions DIR --out OUT`` grades a class, as does
``fieldrecon grade``, which calls it. A batch runs the checks in sandboxes, and the items wait for
its records. With ``-n``, each process of pytest-xdist has its own sandbox, and all items of a
submission run in one process.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures import Executor
from contextlib import ExitStack
from dataclasses import asdict, dataclass, field, replace
from typing import Any

import pytest

from fieldgrade.checking.instructor_checks import (
    InstructorCheck,
    InstructorCheckResult,
    answer_of_submission,
    apply_instructor_checks,
    given_functions,
)
from fieldgrade.checking.results import Record, Results, record_from_json, record_to_json
from fieldgrade.grading.batch import Batch, GradingTask
from fieldgrade.grading.options import declare, run_of
from fieldgrade.grading.pytest_items import (
    USAGE,
    AnswerId,
    CheckItem,
    InstructorCheckRunner,
    answer_ids,
    answer_of_item,
    check_of,
    items,
    name_for_option_k,
    parametrized,
)
from fieldgrade.grading.run import GradingRun
from fieldgrade.isolation import worker_servers
from fieldgrade.isolation.server import GraderError
from fieldgrade.submissions.submission import Submission

CHECKED, FAILURE = pytest.StashKey[InstructorCheckResult](), pytest.StashKey[str]()


def pytest_addoption(parser: pytest.Parser) -> None:
    """Declare the options."""
    group = parser.getgroup("grading", "grading a class")
    group.addoption("--submissions", metavar="DIR", help="the folder or zip file to be graded")
    declare(group.addoption)


@pytest.hookimpl(tryfirst=True)
def pytest_configure(config: pytest.Config) -> None:
    """Prepare the run that the options describe; collect only checks of instructors."""
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
    """Call a student's functions in the sandbox: ``answer("01.2", *arguments)``."""
    grading = grading_of(request.config)
    assert grading is not None
    run, submission = grading.run, grading.submission(request.param)
    grades = [
        g for g in grading.record(request.param).grades if g.question == request.param.question
    ]
    given = given_functions(run.course, *grades) if grades else {}
    return answer_of_submission(run.server, submission, given)


def grading_of(config: pytest.Config) -> Grading | None:
    """Return the run of a session of pytest, if it has been registered."""
    plugins = config.pluginmanager.get_plugins()
    return next((plugin for plugin in plugins if isinstance(plugin, Grading)), None)


class Grading:
    """The plugin of one run.

    Parameters
    ----------
    run : GradingRun
        The run.
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
        self._instructor_checks = InstructorCheckRunner(run)
        self._tasks: dict[AnswerId, GradingTask] = {}
        self._records: dict[AnswerId, Record] = {}
        self._fresh: list[Record] = []
        self._of: Counter[AnswerId] = Counter()
        self._stream: Iterator[tuple[GradingTask, Record]] = iter(())
        self._open = ExitStack()
        self._is_worker = False

    # Collection.

    def pytest_sessionstart(self, session: pytest.Session) -> None:
        """Permit sandbox servers."""
        self._is_worker = hasattr(session.config, "workerinput")
        self._open.enter_context(worker_servers.serving())

    def pytest_generate_tests(self, metafunc: pytest.Metafunc) -> None:
        """Parametrise the checks of instructors."""
        parametrized(metafunc, self.run.tasks())

    @pytest.hookimpl(wrapper=True, tryfirst=True)
    def pytest_collection_modifyitems(
        self, session: pytest.Session, items: list[pytest.Item]
    ) -> Generator[None, None, None]:
        """Prepend the items of submissions; after the selection, note which remain."""
        for item in items:
            if answer_id := answer_of_item(item):
                name_for_option_k(item, answer_id)
        mine = self._items(session)
        self._report_collected(session, mine)
        items[:0] = mine
        self._of = Counter(filter(None, map(_answer_id, items)))
        yield
        chosen = set(filter(None, map(_answer_id, items)))
        for task in self.run.tasks():
            chosen_ids = [answer_id for answer_id in answer_ids(task) if answer_id in chosen]
            if chosen_ids:
                questions = tuple(
                    answer_id.question for answer_id in chosen_ids if answer_id.question
                )
                self._tasks[chosen_ids[0].whole] = GradingTask(task.file, questions)

    def _report_collected(self, session: pytest.Session, mine: list[pytest.Item]) -> None:
        """Have pytest count items that no collector found: ``collected 50 items``."""
        found: list[pytest.Item | pytest.Collector] = list(mine)
        report = pytest.CollectReport(str(self.run.submissions), "passed", None, found)
        session.config.hook.pytest_collectreport(report=report)

    def _items(self, session: pytest.Session) -> list[pytest.Item]:
        run = self.run
        return [i for p in run.tasks() for i in items(session, p, run.course, self.record)]

    def pytest_collectreport(self, report: pytest.CollectReport) -> None:
        """Note errors of collection."""
        if report.failed:
            self.problems.append(report.longreprtext)

    # Execution.

    def pytest_runtestloop(self, session: pytest.Session) -> None:
        """Start the batch, unless processes of pytest-xdist run the items."""
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

    def record(self, answer_id: AnswerId) -> Record:
        """Return the record of a submission; wait for it if necessary."""
        if self._is_worker and answer_id.whole not in self._records:
            self._stream = self._batch(1).records([self._tasks[answer_id.whole]])
        while answer_id.whole not in self._records:
            try:
                _, record = next(self._stream)
            except Exception as error:  # of the executor or of the disk, not of a submission
                self.error = error
                pytest.exit(f"the grader failed: {error!r}", pytest.ExitCode.INTERNAL_ERROR)
            self._records[answer_of_record(record)] = record
            self._fresh.append(record)
            self.progress(len(self._records), len(self._tasks))
        return self._records[answer_id.whole]

    def submission(self, answer_id: AnswerId) -> Submission:
        """Return the submission of an answer."""
        return self._tasks[answer_id.whole].file.submission(self.run.archive)

    @pytest.hookimpl(tryfirst=True)
    def pytest_pyfunc_call(self, pyfuncitem: pytest.Function) -> bool | None:
        """Run the check of an instructor, if the answer passed all other checks."""
        answer_id, check = answer_of_item(pyfuncitem), check_of(pyfuncitem)
        if answer_id is None or check is None:
            return None
        grades = {grade.question: grade for grade in self.record(answer_id).grades}
        if answer_id.question not in grades or not grades[answer_id.question].verdict.right:
            pytest.skip(f"{answer_id.question} is not right")
        try:
            checked = self._instructor_checks.checked(pyfuncitem, check, self.submission(answer_id))
        except GraderError as failure:
            pyfuncitem.stash[FAILURE] = str(failure)
            pytest.fail(f"the grader failed: {failure}", pytrace=False)
        pyfuncitem.stash[CHECKED] = checked
        if not checked.passed:
            pytest.fail(check.sentence, pytrace=False)
        return True

    # Reports.

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_makereport(
        self, item: pytest.Item, call: pytest.CallInfo[None]
    ) -> Generator[None, Any, Any]:
        """Attach the results to the last report of an item."""
        report: Any = yield
        answer_id = _answer_id(item)
        if answer_id and call.when == "teardown":
            fresh, self._fresh = self._fresh, []
            checked, failure = item.stash.get(CHECKED, None), item.stash.get(FAILURE, "")
            report.graded = to_text(answer_id, self._of[answer_id], fresh, checked, failure)
        return report

    def pytest_internalerror(self, excinfo: pytest.ExceptionInfo[BaseException]) -> None:
        """Note an error of the session."""
        self.error = excinfo.value

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Collect results, from this process or from others."""
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


def _answer_id(item: pytest.Item) -> AnswerId | None:
    return item.answer_id if isinstance(item, CheckItem) else answer_of_item(item)


def answer_of_record(record: Record) -> AnswerId:
    """Return the identifier of a submission, from its record."""
    return AnswerId(record.student, record.notebook, record.file, record.digest)


def to_text(
    answer_id: AnswerId,
    of: int,
    records: Iterable[Record],
    checked: InstructorCheckResult | None,
    failure: str,
) -> str:
    """Return the results of an item as text, which can be sent between processes.

    Parameters
    ----------
    answer_id : AnswerId
        The answer.
    of : int
        How many items the answer has.
    records : iterable of Record
        Records that were completed in the meantime, of any submission.
    checked : InstructorCheckResult, optional
        The result of an instructor's check.
    failure : str
        The failure of the grader; empty if there is none.
    """
    return json.dumps(
        {
            "place": asdict(answer_id),
            "of": of,
            "records": [record_to_json(r) for r in records],
            "checked": asdict(checked) if checked else None,
            "failure": failure,
        }
    )


@dataclass
class ReportCollector:
    """Collects the results of a run.

    Parameters
    ----------
    records : dict
        The records, by submission.
    failures : list of str
        Failures of the grader.
    """

    records: dict[AnswerId, Record] = field(default_factory=dict)
    failures: list[str] = field(default_factory=list)
    _done: Counter[AnswerId] = field(default_factory=Counter)
    _of: dict[AnswerId, int] = field(default_factory=dict)
    _checked: dict[AnswerId, list[InstructorCheckResult]] = field(default_factory=dict)

    def add(self, text: str) -> None:
        """Add the results of an item."""
        data: dict[str, Any] = json.loads(text)
        answer_id = AnswerId(**data["place"])
        self._done[answer_id] += 1
        self._of[answer_id] = data["of"]
        for record in map(record_from_json, data["records"]):
            self.records[answer_of_record(record)] = record
        if data["checked"]:
            check = InstructorCheck(**data["checked"].pop("check"))
            self._checked.setdefault(answer_id.whole, []).append(
                InstructorCheckResult(check, **data["checked"])
            )
        if data["failure"] and data["failure"] not in self.failures:
            self.failures.append(data["failure"])

    def complete(self) -> Iterator[Record]:
        """Yield records with the grades of the questions whose checks are complete."""
        for answer_id, record in self.records.items():
            whole = apply_instructor_checks(record, self._checked.get(answer_id, ()))
            grades = tuple(g for g in whole.grades if self._is_done(answer_id, g.question))
            if grades or not whole.grades:
                yield replace(whole, grades=grades)

    def _is_done(self, answer_id: AnswerId, question: str) -> bool:
        at = replace(answer_id, question=question)
        return self._done[at] > 0 and self._done[at] == self._of[at]
