"""A failure of the machine or of the grader lowers no grade, and does not repeat for ever."""

import os
import shutil
import signal
import sys
import threading
import time
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import pytest

from fieldgrade.checking.grade_submission import grade
from fieldgrade.grading.grade_class import grade_class
from fieldgrade.isolation import file_access, worker_servers
from fieldgrade.isolation import server as server_module
from fieldgrade.isolation.server import GraderError
from fieldgrade.submissions.submission import Submission
from graded_class import run
from hostile.case import HERE, POINTS, SANDBOXED, Case, as_file, notebook
from hostile.conftest import LIMITS
from hostile.test_submissions import points

ANSWERS = as_file(notebook())[1]
SLOW = Case("slow", before="import time; time.sleep(1.5)").submitted_file({})


def descendants(process):
    """The processes that a process has started, the youngest last."""
    found = [process]
    for parent in found:
        for file in Path("/proc").glob("[0-9]*/stat"):
            try:
                number, rest = file.read_text(errors="replace").split(" ", 1)
            except OSError:
                continue
            if int(rest.rpartition(")")[2].split()[1]) == parent:
                found.append(int(number))
    return found[1:]


def process_killed(server):
    """As the kernel does when memory runs out."""
    os.kill(descendants(server._process.pid)[-1], signal.SIGKILL)


def server_killed(server):
    os.kill(server._process.pid, signal.SIGKILL)


def server_stopped(server):
    """It does not answer any more."""
    server._control.settimeout(0.5)
    *_, own, child = (server._process.pid, *descendants(server._process.pid))
    os.kill(own, signal.SIGSTOP)
    os.kill(child, signal.SIGKILL)


def homes_lost(server):
    """No process can start any more; without mounts of its own a server does not notice it."""
    shutil.rmtree(server._scratch.folder / "homes")
    process_killed(server)


FAILURES = [process_killed, server_killed, server_stopped, homes_lost]


def graded_while(course, tier, fails, times):
    """The record of an honest submission; meanwhile something fails, a number of times."""
    left, timers = [fails] * times, []

    def do(server):
        if left:
            fail = left.pop()
            timers.append(threading.Timer(0.7, lambda: fail(server)))
            timers[-1].start()
        return grade(course, server, Submission("honest", *SLOW))

    with worker_servers.serving():
        try:
            return worker_servers.with_server(tier, LIMITS, do)
        finally:
            for timer in timers:
                timer.join()


if sys.platform == "linux":

    @pytest.mark.slow
    @pytest.mark.parametrize("fails", FAILURES, ids=lambda f: f.__name__)
    @pytest.mark.parametrize("tier", [tier for tier in HERE if tier in SANDBOXED])
    def test_a_failure_of_the_machine_costs_no_points(course, tier, fails, monkeypatch):
        """The submission runs again. A server that is stopped never ends itself, and is killed."""
        monkeypatch.setattr(server_module, "SECONDS_TO_END", 2.0)
        record = graded_while(course, tier, fails, 1)
        assert points(record) == POINTS["01"]
        assert (record.status, record.notes) == ("graded", ())

    @pytest.mark.slow
    @pytest.mark.parametrize("fails", FAILURES[:2], ids=lambda f: f.__name__)
    def test_a_lasting_failure_of_the_machine_gives_no_grade(course, fails):
        """There is no third attempt."""
        started = time.monotonic()
        with pytest.raises(GraderError, match=r"killed a process|server ended"):
            graded_while(course, HERE[0], fails, 9)
        assert time.monotonic() - started < 300


FULL_DISK = """
import os
from types import SimpleNamespace
os.statvfs = lambda _: SimpleNamespace(f_bavail=0, f_frsize=4096, f_blocks=1 << 30)
"""


@pytest.fixture
def disk(monkeypatch):
    """A disk of the homes that is full while `disk.full` is set; it counts the servers."""
    real = file_access.SandboxFolders.create
    disk = SimpleNamespace(full=True, servers=0)

    def create(scratch):
        folders = real(scratch)
        disk.servers += 1
        if disk.full:
            (folders.stage / "fieldgrade" / "__init__.py").write_text(FULL_DISK)
        return folders

    monkeypatch.setattr(server_module, "OWN_MOUNTS", False)
    monkeypatch.setattr(file_access.SandboxFolders, "create", create)
    return disk


@pytest.mark.slow
@pytest.mark.parametrize("tier", [tier for tier in HERE if tier in SANDBOXED])
def test_a_disk_that_stays_full_gives_no_grade(tier, disk, tmp_path):
    """Each submission is tried twice, earlier grades stay, and the next run grades the others."""
    students = ("ada", "bob", "cai")
    todo = replace(run(tmp_path, {f"{s}/01.ipynb": ANSWERS for s in students}), tier=tier)

    def records():
        return {r.student: r for r in grade_class(replace(todo)).results.records}

    disk.full = False
    first = records()
    (todo.submissions / "dan").mkdir()
    (todo.submissions / "dan" / "01.ipynb").write_bytes(ANSWERS.replace(b"import", b"import ", 1))
    disk.full, disk.servers = True, 0
    second = records()
    assert {s: second[s] for s in students} == first
    assert second["dan"].status == "grader failed"
    assert second["dan"].grades == ()
    assert "the disk of" in second["dan"].notes[0]
    assert "is full: 0 MiB are free" in second["dan"].notes[0]
    assert disk.servers == 2
    disk.full = False
    assert points(records()["dan"]) == POINTS["01"]
