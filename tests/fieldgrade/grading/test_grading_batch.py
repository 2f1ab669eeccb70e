"""Grading a class: every submission is graded once, by any executor, also after interruptions."""

import errno
import json
import os
import shutil
import signal
import subprocess
import sys
import time
from concurrent.futures import BrokenExecutor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import replace
from multiprocessing import get_context

import pytest

from fieldgrade.authoring import leaks
from fieldgrade.checking import grade_submission
from fieldgrade.checking.course import Course
from fieldgrade.checking.grade_submission import GraderError
from fieldgrade.checking.results import invalid, read_results
from fieldgrade.grading.batch import as_completed_in_window
from fieldgrade.grading.grade_class import grade_class as graded
from fieldgrade.isolation import worker_servers
from fieldgrade.isolation.server import Limits
from fieldrecon._core import atomic_files
from graded_class import ROOT, SOURCES, STUB, TIER, checkout, ledger, points, right, run
from submission_files import notebook, write_files


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    """A small class and the result of grading it."""
    folder = tmp_path_factory.mktemp("class")
    todo = run(folder, jobs=2)
    return todo, graded(todo)


def statuses(grading):
    return {(r.student, r.notebook): r.status for r in grading.results.records}


@pytest.mark.slow
def test_every_submission_has_a_status_and_its_verdicts(small):
    """Right, wrong and unwritten answers, and an unreadable file."""
    _, grading = small
    assert statuses(grading) == {
        ("ada", "01"): "graded",
        ("ada", "02"): "graded",
        ("bob", "01"): "graded",
        ("cai", "01"): "graded",
        ("dan", ""): "unreadable",
    }
    lost = {
        (r.student, g.question): g.verdict.finding
        for r in grading.results.records
        for g in r.grades
        if g.points < g.possible
    }
    assert lost == {("bob", "01.2"): "wrong", ("cai", "01.4"): "unwritten"}


def test_the_results_file_contains_the_results(small):
    """The file conforms to the schema."""
    todo, grading = small
    file = todo.out / "results.json"
    assert invalid(json.loads(file.read_text())) == ""
    assert read_results(file) == replace(
        grading.results, students=tuple({"student": s} for s in ("ada", "bob", "cai", "dan"))
    )


def test_only_wrong_numbers_of_the_public_case_are_stored(small):
    """Feedback draws them beside the right numbers."""
    _, grading = small
    shown = {
        (r.student, g.question): g.returned
        for r in grading.results.records
        for g in r.grades
        if g.returned
    }
    (part,) = shown.pop(("bob", "01.2"))
    assert part["shape"] == [len(part["numbers"])]
    assert not shown


def test_grading_again_runs_nothing(small):
    """The cache knows every verdict; the results keep their bytes, and no history is written."""
    todo, _ = small
    before, lines = (todo.out / "results.json").read_bytes(), ledger(todo.out)
    assert not graded(replace(todo)).changed
    assert (todo.out / "results.json").read_bytes() == before
    assert ledger(todo.out) == lines
    assert not (todo.out / "history").exists()


@contextmanager
def pool_of(kind):
    """An executor: a thread, worker processes, or a Dask cluster."""
    if kind == "one thread":
        yield ThreadPoolExecutor(1)
    elif kind == "processes":
        with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
            yield pool
    else:
        from distributed import Client, LocalCluster

        settings = {"n_workers": 2, "threads_per_worker": 1, "dashboard_address": None}
        with LocalCluster(**settings) as cluster, Client(cluster) as client:
            yield client.get_executor()


KINDS = [
    "one thread",
    *(pytest.param(k, marks=pytest.mark.slow) for k in ("processes", "a cluster")),
]


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_every_executor_gives_the_same_results_file(small, tmp_path, kind):
    """The work can be sent to other processes, and each of them starts its own sandbox."""
    todo, _ = small
    other = replace(todo, out=tmp_path / "out")
    with pool_of(kind) as pool:
        graded(other, pool)
    assert len(ledger(other.out)) == 4
    assert (other.out / "results.json").read_bytes() == (todo.out / "results.json").read_bytes()


def test_sandbox_servers_end_with_the_run(small):
    assert small
    assert not worker_servers._open.get(os.getpid())


def test_the_ledger_names_the_year_of_the_salt_and_not_the_salt(small):
    """Each line has the fields that are needed to interpret it."""
    todo, _ = small
    line = json.loads((todo.out / "ledger.jsonl").read_text().splitlines()[0])
    assert set(line) == {
        "on",
        "student",
        "file",
        "digest",
        "code",
        "notebook",
        "status",
        "made_by",
        "environment",
        "grader",
        "salt_year",
        "tier",
        "seconds",
        "cpu_seconds",
        "peak_bytes",
    }
    assert todo.salt.text not in line.values()
    assert line["tier"] == TIER


@pytest.mark.slow
def test_damaged_cache_files_are_replaced(small, tmp_path):
    """A truncated file, a file of another format, and a file with one invalid entry."""
    todo, _ = small
    other = replace(todo, out=tmp_path / "out")
    shutil.copytree(todo.out, other.out)
    kept = sorted((other.out / "cache").rglob("*.json"))
    assert len(kept) == 4
    known = json.loads(kept[0].read_text())
    name = next(iter(known))
    kept[0].write_text(json.dumps(known | {name: {"verdict": "right"}}))
    kept[1].write_text(kept[1].read_text()[:-9])
    kept[2].write_text("[]")
    graded(other)
    assert len(ledger(other.out)) == 4 + 3
    assert json.loads(kept[0].read_text()) == known
    assert (other.out / "results.json").read_bytes() == (todo.out / "results.json").read_bytes()


# Dependencies of verdicts


CHECKS = [f"01.4 {k}" for k, _ in enumerate(Course(list(SOURCES.values()), "").checks("01.4"))]
"""The checks of the rank, in the order in which they run; "tiny and huge" is the last."""
ELEVEN = """

@hidden("01.4", "Eleven points in the plane span it.")
def eleven_points(seed):
    return (Call("rank", (np.random.default_rng(seed + 3).random((11, 2)),), "eleven points"),)
"""
ODD = """
_rank = rank
def rank(points):
    large = 1e7 < np.ptp(points, axis=0).max() < 1e11
    return 0 if len(points) == 11 or large else _rank(points)
"""
DYING = """
_rank = rank
def rank(points):
    import os
    return os._exit(3) if 2e3 < np.ptp(points, axis=0).max() < 1e11 else {}
"""


def with_two_hidden_cases(folder, line="1e5 * line"):
    """A copy of the course with two hidden cases for the rank; `line` is part of the first case."""
    root = checkout(folder, "01")
    file = root / "solutions" / "grading" / "01_least_squares.py"
    file.write_text(file.read_text().replace("1e5 * line", line) + ELEVEN)
    return root


@pytest.fixture
def edited(tmp_path, monkeypatch):
    """A class that is graded before and after a hidden case is edited, and the calls made then."""
    called = []

    def counted(server, cells, tasks):
        called.extend(task.name for task in tasks)
        return real(server, cells, tasks)

    real = grade_submission.run
    monkeypatch.setattr(grade_submission, "run", counted)
    answers = {
        "ada": "",
        "bob": STUB,
        "odd": ODD,
        "dying": DYING.format("_rank(points)"),
        "lost": DYING.format("0"),
    }
    files = {f"{name}/01.ipynb": notebook(*right(), code) for name, code in answers.items()}
    files["bob/01.ipynb"] = notebook(*(c for c in right() if "def rank" not in c), STUB)
    before = run(tmp_path, files, root=with_two_hidden_cases(tmp_path / "before"))
    after = replace(before, root=with_two_hidden_cases(tmp_path / "after", "1e9 * line"))

    def grade_twice():
        first = graded(before).results
        called.clear()
        return first, graded(after).results

    return before, after, called, grade_twice


def failed_checks(results):
    """The status of each submission, and the first check that its rank failed."""
    asked = ((r, g) for r in results.records for g in r.grades if g.question == "01.4")
    return {r.student: (r.status, g.check) for r, g in asked}


@pytest.mark.slow
def test_after_a_check_is_edited_only_that_check_is_repeated(edited, tmp_path):
    """It is repeated on the answers that reach it; other verdicts come from the cache.

    The answer that broke down in this check before the edit is also tried on the next check.
    """
    before, after, called, grade_twice = edited
    first, second = grade_twice()
    written = (after.out / "results.json").read_bytes()
    edited, added = CHECKS[-1], f"01.4 {len(CHECKS)}"
    assert sorted(called) == [edited] * 3 + [added]
    lines = [json.loads(line) for line in (after.out / "ledger.jsonl").read_text().splitlines()]
    assert sorted(line["student"] for line in lines[5:]) == ["ada", "dying", "odd"]
    assert {(q, *its) for line in lines[5:] for q, its in line["made_by"].items()} == {
        ("01.4", "tiny and huge")
    }
    known = {
        "ada": ("graded", ""),
        "bob": ("graded", "public cases"),
        "lost": ("graded", "public cases"),
        "dying": ("partly", "tiny and huge"),
    }
    assert failed_checks(first) == known | {"odd": ("graded", "eleven points")}
    assert failed_checks(second) == known | {"odd": ("graded", "tiny and huge")}
    called.clear()
    assert failed_checks(graded(replace(before)).results) == failed_checks(first)
    assert not called
    fresh = replace(after, out=tmp_path / "fresh")
    graded(fresh)
    assert (fresh.out / "results.json").read_bytes() == written, "it tells what was known before"


@pytest.mark.slow
def test_with_one_digest_per_question_all_its_checks_are_repeated(edited, monkeypatch):
    """A mutant: the digests of single checks are what avoids repeated calls."""
    _, _, called, grade_twice = edited
    own = Course.checks
    monkeypatch.setattr(
        Course, "checks", lambda course, q: dict.fromkeys(own(course, q), course.made_by(q))
    )
    grade_twice()
    assert set(called) == {*CHECKS, f"01.4 {len(CHECKS)}"}


@pytest.mark.slow
def test_changed_points_do_not_repeat_any_check(small, tmp_path):
    """Points are applied to the cached verdicts."""
    todo = replace(small[0], tables=tmp_path / "class", out=tmp_path / "out")
    shutil.copytree(small[0].out, todo.out)
    write_files(todo.tables, {"points.csv": b"question,points\n01.2,30\n"})
    before = ledger(todo.out)
    grading = graded(todo)
    assert ledger(todo.out) == before
    assert points(grading.results)["ada", "01.2"] == 30.0
    assert points(grading.results)["bob", "01.2"] == 0.0


@pytest.mark.slow
def test_grading_a_selection_keeps_other_results(tmp_path):
    """A selection by question, and one by student and notebook."""
    todo = run(tmp_path, question="01.4")
    graded(todo)
    assert sorted(ledger(todo.out)) == [(s, "01.4") for s in ("ada", "bob", "cai")]
    found = graded(replace(todo, choice=run(tmp_path, student="ada", notebooks=("02",)).choice))
    asked = points(found.results)
    assert {s for s, q in asked if q.startswith("02")} == {"ada"}
    assert {s for s, q in asked if q == "01.4"} == {"ada", "bob", "cai"}


def slow_at_first(monkeypatch, task, busy):
    """Let the first `busy` runs of a task take long, and return the tasks of each run."""
    runs = []

    def slowed(server, cells, tasks):
        outcomes, log = real(server, cells, tasks)
        runs.append([task.name for task in tasks])
        if len(runs) <= busy:
            outcomes[task] = tuple(replace(o, seconds=6.0) for o in outcomes[task])
        return outcomes, log

    real = grade_submission.run
    monkeypatch.setattr(grade_submission, "run", slowed)
    return runs


@pytest.mark.slow
@pytest.mark.parametrize("check", CHECKS)
@pytest.mark.parametrize(("busy", "left"), [(1, 2.0), (2, 1.0)])
def test_a_slow_answer_is_tried_again(tmp_path, monkeypatch, check, busy, left):
    """The run starts again at the slow check, so a busy machine costs no points."""
    runs = slow_at_first(monkeypatch, check, busy)
    found = graded(run(tmp_path, {"ada/01.ipynb": notebook(*right())})).results
    assert points(found)["ada", "01.4"] == left
    assert runs[1:] == [CHECKS[CHECKS.index(check) :]]


@pytest.mark.slow
def test_an_answer_that_is_fast_when_repeated_must_pass_the_other_checks(tmp_path, monkeypatch):
    """Its verdict is that of the first check that it fails."""
    slow_at_first(monkeypatch, "01.4 0", 1)
    wrong = ODD.replace("1e7", "2e3")
    found = graded(run(tmp_path, {"ada/01.ipynb": notebook(*right(), wrong)})).results
    assert failed_checks(found) == {"ada": ("graded", "tiny and huge")}


# Failures


@pytest.mark.slow
def test_a_submission_that_crashes_does_not_affect_others(tmp_path):
    """Its other answers keep their points, and other submissions are graded."""
    deadly = "def fit(points, values):\n    import os\n    os._exit(3)\n"
    files = {"eve/01.ipynb": notebook(*right(), deadly), "zoe/01.ipynb": notebook(*right())}
    found = points(graded(run(tmp_path, files)).results)
    assert found["eve", "01.2"] == 0.0
    assert {q for (s, q), p in found.items() if s == "eve" and p > 0} == {
        "01.1",
        "01.3",
        "01.4",
        "01.5",
        "01.6",
    }
    assert found["zoe", "01.2"] == 3.0


@pytest.mark.slow
def test_no_hidden_input_reaches_the_results(tmp_path):
    """Neither return values nor errors reveal one, since public cases are tried first."""
    thief = """
_seen = []
def _stolen(function):
    def call(*arguments):
        _seen.append([np.asarray(a).tolist() for a in arguments])
        if len(_seen) > 3:
            raise ValueError(repr(_seen))
        return function(*arguments)
    return call
basis_matrix, rank = _stolen(basis_matrix), _stolen(rank)
def fit(points, values):
    raise ValueError(repr(_seen))
def gradient(coefficients, x):
    return np.asarray(x)
"""
    todo = run(tmp_path, {"eve/01.ipynb": notebook(*right(), thief)})
    grading = graded(todo)
    assert points(grading.results)["eve", "01.2"] == 0.0
    written = {"results.json": leaks.long_numbers((todo.out / "results.json").read_text())}
    tried = todo.course.trials("01", "eve")
    for trial in (t for its in tried.values() for t in its[1:]):
        assert not list(leaks.number_leaks(trial.calls, trial.answers.right, written))
    public = tried["01.1"][0]
    assert list(leaks.number_leaks(public.calls, (), written)), "the thief has stolen nothing"


@pytest.mark.slow
def test_a_check_that_fails_on_the_solution_is_reported_as_a_grader_failure(tmp_path):
    """The grader failed, and nothing is cached: a corrected check is run again."""
    root = checkout(tmp_path, "01")
    file = root / "solutions" / "grading" / "01_least_squares.py"
    file.write_text(file.read_text().replace("(1e5 * line,)", "(line, line)"))
    todo = run(tmp_path, {"ada/01.ipynb": notebook(*right())}, root=root)
    (record,) = graded(todo).results.records
    assert record.status == "grader failed"
    assert "the solution of 01.4" in record.notes[0]
    assert [r.status for r in graded(replace(todo, root=ROOT)).results.records] == ["graded"]


def grade_and_stop(todo, temporary, by):
    """Grade in a new process, stop it after a quarter of the work, and return its exit status."""
    command = [sys.executable, "-m", "fieldrecon.cli.main", "grade", "in", "--root", str(ROOT)]
    command += ["--out", "out", "--jobs", "2", "--tier", TIER]
    temporary.mkdir()
    environment = os.environ | {"TMPDIR": str(temporary)}
    process = subprocess.Popen(
        command, cwd=todo.out.parent, stderr=subprocess.DEVNULL, env=environment
    )
    wait_until(lambda: len(ledger(todo.out)) >= 3)
    assert list(temporary.glob("grading-*"))
    process.send_signal(by)
    process.wait(120)
    wait_until(lambda: not list(temporary.glob("grading-*")))
    return process.returncode


def wait_until(condition):
    deadline = time.monotonic() + 120
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.02)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("by", "status", "name"),
    [
        (signal.SIGKILL, -signal.SIGKILL, "short"),
        (signal.SIGINT, 130, "too long for sockets" * 5),
    ],
)
def test_an_interrupted_run_is_resumed(tmp_path, by, status, name):
    """A killed or interrupted run writes no results, and its workers end and remove their files.

    A second run grades the remaining submissions, each once.
    """
    slow = "import time\ntime.sleep(0.25)\n"
    files = {f"s{k}/01.ipynb": notebook(*right(), f"{slow}# {k}") for k in range(12)}
    todo = run(tmp_path, files)
    assert grade_and_stop(todo, tmp_path / name, by) == status
    done = ledger(todo.out)
    assert 3 <= len(done) < 12
    assert not (todo.out / "results.json").exists()
    grading = graded(todo)
    assert len(statuses(grading)) == 12
    again = [line for line in ledger(todo.out)[len(done) :] if line in done]
    assert len(again) <= 1, "what was being written when it was killed"
    assert {student for student, *_ in ledger(todo.out)} == {f"s{k}" for k in range(12)}


@pytest.mark.slow
def test_a_broken_executor_ends_the_run_without_results(tmp_path):
    """A broken executor is not the fault of a submission, so no grade is given."""

    class BrokenPool(ThreadPoolExecutor):
        def submit(self, *_):
            raise BrokenExecutor("a worker is gone")

    todo = run(tmp_path, {"ada/01.ipynb": notebook(*right())})
    with pytest.raises(RuntimeError, match="a worker is gone"):
        graded(todo, BrokenPool(1))
    assert not (todo.out / "results.json").exists()


class LostOnce(ThreadPoolExecutor):
    """An executor whose first worker is lost, and whose second call has an error of the grader."""

    calls = 0

    def submit(self, fn, *arguments):
        self.calls += 1
        if self.calls == 1:
            future = Future()
            future.set_exception(BrokenExecutor("a worker is gone"))
            return future
        return super().submit(fail if self.calls == 2 else fn, *arguments)


def fail(*_):
    raise MemoryError("in the grader")


@pytest.mark.slow
def test_a_lost_worker_or_an_error_of_the_grader_does_not_end_the_class(tmp_path, monkeypatch):
    """The first submission runs again, the second one is listed, and the third one is graded."""
    monkeypatch.setattr(worker_servers, "run_alone", lambda do, *arguments: do(*arguments))
    files = {f"{name}/01.ipynb": notebook(*right()) for name in ("ada", "bob", "cai")}
    found = graded(run(tmp_path, files), LostOnce(1)).results.records
    assert [record.status for record in found] == ["graded", "grader failed", "graded"]
    assert found[0].points == found[2].points == found[0].possible > 0
    assert found[1].grades == ()
    assert "in the grader" in found[1].notes[0]


@pytest.mark.slow
def test_a_lost_worker_is_replaced_and_a_second_loss_is_a_failure():
    """Later submissions are graded; a submission whose worker is lost twice is not tried again."""
    with worker_servers.worker_pool(2) as pool:
        with pytest.raises(BrokenExecutor):
            pool.submit(os._exit, 1).result()
        assert pool.submit(abs, -1).result() == 1
    with pytest.raises(GraderError, match="killed the process that graded it, twice"):
        worker_servers.run_alone(os._exit, 1)


@pytest.mark.slow
def test_a_full_disk_for_results_names_the_file(tmp_path, monkeypatch):
    """The run ends, no grade is given, and the error states where there is no room."""

    def no_room(*_):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    todo = run(tmp_path, {"ada/01.ipynb": notebook(*right())})
    monkeypatch.setattr(atomic_files.Path, "write_bytes", no_room)
    with pytest.raises(RuntimeError, match=r"No space left on device: '.*/(received|cache)/"):
        graded(todo)
    assert not (todo.out / "results.json").exists()


# Parts of the batch


def test_only_a_window_of_submissions_is_in_memory():
    """The next submission begins only when an earlier one ends."""
    begun, waiting = [], []

    def begin(item):
        begun.append(item)
        future = Future()
        waiting.append(future)
        if len(waiting) == 3:
            waiting.pop(0).set_result(None)
        return future, lambda: item

    stream = as_completed_in_window(begin, range(100), ahead=3)
    assert next(stream) == 0
    assert begun == [0, 1, 2]
    assert next(stream) == 1
    assert begun == [0, 1, 2, 3]
    stream.close()
    assert all(future.cancelled() for future in waiting)


@pytest.mark.slow
def test_a_failing_server_is_replaced_once():
    """A second failure is a failure of the grader and gives no grade."""
    tried = []

    def do(server):
        tried.append(server)
        raise OSError("the pipe is broken")

    with worker_servers.serving(), pytest.raises(GraderError, match="OSError: the pipe is broken"):
        worker_servers.with_server(TIER, Limits(), do)
    first, second = tried
    assert first is not second


def test_no_server_is_started_after_the_work_has_ended():
    """Threads that still run when a run is interrupted end and leave nothing behind."""
    with worker_servers.serving():
        pass
    with pytest.raises(worker_servers.WorkEnded):
        worker_servers.with_server(TIER, Limits(), lambda server: server)
