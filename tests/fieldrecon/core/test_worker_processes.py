"""Worker processes: each is prepared first, and Ctrl-C is left to the parent."""

import multiprocessing
import os
import signal
import subprocess
import sys
import time
import warnings
from multiprocessing.process import BaseProcess
from pathlib import Path
from types import SimpleNamespace

import pytest

from fieldrecon._core import worker_processes
from fieldrecon._core.worker_processes import (
    WorkerPool,
    _ctrl_c_blocked,
    available_cores,
    start_process,
)

HERE = ["fresh"]


def prepare() -> None:
    os.environ["PREPARED"] = "yes"


def record(path: Path) -> None:
    path.write_text(HERE[0])


def recorded(path: Path) -> str:
    """What a process that is started here finds in the memory of this one."""
    before, HERE[0] = HERE[0], "changed"
    try:
        start_process(record, path).join()
    finally:
        HERE[0] = before
    return path.read_text()


def is_running(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    return True


@pytest.mark.skipif(not hasattr(os, "sched_setaffinity"), reason="no system call for it here")
def test_only_the_cores_that_a_process_may_use_are_counted():
    """A process that is bound to one core of a large machine has one."""
    before = os.sched_getaffinity(0)
    assert available_cores() == len(before)
    try:
        os.sched_setaffinity(0, {min(before)})
        assert available_cores() == 1
    finally:
        os.sched_setaffinity(0, before)


@pytest.mark.parametrize(("known", "cores"), [(3, 3), (None, 1)])
def test_where_a_process_is_not_bound_the_cores_of_the_machine_are_counted(
    monkeypatch, known, cores
):
    """One, if the system does not tell their number."""
    monkeypatch.delattr(os, "sched_getaffinity", raising=False)
    monkeypatch.setattr(os, "cpu_count", lambda: known)
    assert available_cores() == cores


def test_a_worker_is_prepared_before_its_first_call():
    """It runs `begin`, here a module's function, which this process does not run."""
    with WorkerPool(1, begin=prepare) as pool:
        assert pool.submit(os.getenv, "PREPARED").result() == "yes"
    assert "PREPARED" not in os.environ


@pytest.mark.parametrize("context", [None, multiprocessing.get_context("spawn")])
def test_ctrl_c_ends_the_programs_of_a_worker_and_not_the_worker(context):
    """Its parent decides what to do; a program that it runs has neither its handler nor a mask."""
    with WorkerPool(1, context=context) as pool:
        assert pool.submit(signal.raise_signal, signal.SIGINT).exception() is None
        program = pool.submit(subprocess.call, ["sh", "-c", "kill -INT $$"])
        assert program.result() == -signal.SIGINT


def test_ctrl_c_is_blocked_while_a_worker_is_started():
    """Afterwards the mask is the one before."""
    with _ctrl_c_blocked():
        assert signal.SIGINT in signal.pthread_sigmask(signal.SIG_BLOCK, [])
    assert signal.SIGINT not in signal.pthread_sigmask(signal.SIG_BLOCK, [])


def test_a_process_does_not_outlive_the_program_that_started_it():
    """The program ends at once, and does not wait for it."""
    code = (
        "import time; from fieldrecon._core.worker_processes import start_process; "
        "start_process(time.sleep, 60)"
    )
    subprocess.run([sys.executable, "-c", code], timeout=30, check=True)


def test_a_worker_ends_with_the_program_that_started_it(tmp_path):
    """Also if that is killed; before, the worker calls a function, which cleans up."""
    code = (
        "import os, signal, sys; from pathlib import Path; "
        "from fieldrecon._core.worker_processes import WorkerPool; "
        "pool = WorkerPool(1, end=Path(sys.argv[1]).touch); "
        "print(pool.submit(os.getpid).result(), flush=True); os.kill(os.getpid(), signal.SIGKILL)"
    )
    command = [sys.executable, "-c", code, str(tmp_path / "ended")]
    worker = int(subprocess.run(command, stdout=subprocess.PIPE, check=False).stdout)
    last = time.monotonic() + 20
    while is_running(worker) and time.monotonic() < last:
        time.sleep(0.01)
    assert not is_running(worker)
    assert (tmp_path / "ended").exists()


class WarnsOfThreads(BaseProcess):
    """A process that only warns, as a fork beside threads does since Python 3.12."""

    def start(self) -> None:
        warnings.warn("this process is multi-threaded", DeprecationWarning, stacklevel=1)


def test_a_worker_is_started_without_the_warning_about_threads(monkeypatch, recwarn):
    """The other threads of a worker only wait."""
    monkeypatch.setattr(
        worker_processes, "_context", lambda: SimpleNamespace(Process=WarnsOfThreads)
    )
    start_process(os.getpid)
    assert len(recwarn) == 0


@pytest.mark.skipif(sys.platform != "linux", reason="processes are only forked on Linux")
def test_a_process_shares_the_memory_of_a_worker_and_of_no_other_process(tmp_path):
    """It is forked from a worker; elsewhere, beside threads that may hold locks, it begins anew."""
    assert recorded(tmp_path / "here") == "fresh"
    with WorkerPool(1) as pool:
        assert pool.submit(recorded, tmp_path / "there").result() == "changed"
