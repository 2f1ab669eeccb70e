"""The forking server: it imports NumPy once, and makes a locked-in process for each submission.

Its arguments are the number of a socket and a JSON object of settings. It runs no code of a
student: it forks, and the child locks itself in before it does. Commands are a byte each: ``r``,
with two pipes, to run, ``e`` to end what runs and be told how it ended, and ``w`` to do so once it
had a moment to end by itself. In between it watches what no limit of the kernel bounds: how many
threads there are, and how full the home is.
"""

from __future__ import annotations

import json
import os
import select
import signal
import socket
import sys
import tempfile
import time
from contextlib import suppress
from dataclasses import dataclass
from importlib import import_module
from typing import Any

from fieldgrade.sandbox import confine, homes, landlock, seccomp

PRELOADED = ("numpy", "numpy.polynomial", "numpy.random", "numpy.testing", "matplotlib.pyplot")
"""What notebooks import anyway, and what NumPy imports when it is first asked for it: the processes
that are forked have it already."""
SECONDS_BETWEEN_LOOKS = 0.1
SECONDS_OF_PATIENCE = 0.5
MOST_THREADS = 64
MOST_ROUNDS = 1000


@dataclass
class Child:
    """A process that runs, the folder of its home, and what it was ended for, if it was."""

    process: int
    homes: str
    ended_for: str = ""


def main() -> None:
    """Import what students need, then serve commands until the socket is closed."""
    control = socket.socket(fileno=int(sys.argv[1]))
    settings = json.loads(sys.argv[2])
    sys.path += settings["packages"]
    os.environ["MPLCONFIGDIR"] = settings["fonts"]
    for name in PRELOADED:
        import_module(name)
    from fieldcheck.questions import questions
    from fieldgrade.sandbox import worker

    questions()
    worker.quiet_fieldcheck()
    settings["server"] = os.getpid()
    confine.adopt_orphans()
    confine.hide_memory()
    lock = None
    if settings["landlock"]:
        writable = [settings["homes"], os.devnull]
        lock = landlock.ruleset(settings["readable"], settings["listed"], writable)
    control.sendall(b"+")
    child: Child | None = None
    while True:
        if child and not select.select([control], [], [], SECONDS_BETWEEN_LOOKS)[0]:
            _look_after(child)
            continue
        command, pipes, *_ = socket.recv_fds(control, 1, 2)
        if command == b"r":
            home = tempfile.mkdtemp(dir=settings["homes"])
            process = os.fork()
            if process == 0:
                _run(settings, home, pipes, lock)
            child = Child(process, settings["homes"])
            for pipe in pipes:
                os.close(pipe)
            continue
        told = _end(child, SECONDS_OF_PATIENCE if command == b"w" else 0.0) if child else {}
        child = None
        if not command:
            return
        control.sendall(json.dumps(told).encode() + b"\n")


def _look_after(child: Child) -> None:
    """End a child that takes more than it may of what has no limit."""
    if child.ended_for:
        return
    if _threads(child.process) > MOST_THREADS:
        child.ended_for = "threads"
    elif homes.is_overfull(child.homes):
        child.ended_for = "disk"
    if child.ended_for:
        with suppress(ProcessLookupError):
            os.kill(child.process, signal.SIGKILL)


def _threads(process: int) -> int:
    try:
        with open(f"/proc/{process}/stat", encoding="ascii", errors="replace") as file:  # noqa: PTH123
            return int(file.read().rpartition(")")[2].split()[17])
    except OSError:
        return 1


def _end(child: Child, patience: float = 0.0) -> dict[str, Any]:
    """End a child and all that it may have left, and tell how it ended."""
    last = time.monotonic() + patience
    ended, status, usage = os.wait4(child.process, os.WNOHANG)
    while not ended and time.monotonic() < last:
        time.sleep(0.005)
        ended, status, usage = os.wait4(child.process, os.WNOHANG)
    told = {"killed": not ended, "ended_for": child.ended_for}
    if not ended:
        os.kill(child.process, signal.SIGKILL)
        _, status, usage = os.wait4(child.process, 0)
    with suppress(ProcessLookupError, PermissionError):
        os.killpg(child.process, signal.SIGKILL)
    _end_orphans()
    homes.empty(child.homes)
    return told | {
        "signal": os.WTERMSIG(status) if os.WIFSIGNALED(status) else 0,
        "exit": os.WEXITSTATUS(status) if os.WIFEXITED(status) else 0,
        "cpu_seconds": usage.ru_utime + usage.ru_stime,
        "peak": usage.ru_maxrss * (1 if sys.platform == "darwin" else 1024),
    }


def _end_orphans() -> None:
    """End the processes that became this one's when those that made them ended."""
    for _ in range(MOST_ROUNDS):
        orphans = _children()
        if not orphans:
            return
        for orphan in orphans:
            with suppress(ProcessLookupError, PermissionError):
                os.kill(orphan, signal.SIGKILL)
        for orphan in orphans:
            with suppress(ChildProcessError):
                os.waitpid(orphan, 0)


def _children() -> list[int]:
    try:
        with open("/proc/thread-self/children", encoding="ascii") as file:  # noqa: PTH123
            return [int(number) for number in file.read().split()]
    except OSError:
        return []


def _run(settings: dict[str, Any], home: str, pipes: list[int], lock: int | None) -> None:
    """Lock this process in and run what comes; it never returns."""
    from fieldgrade.sandbox import worker

    code = 1
    try:
        os.setsid()
        confine.die_with_parent(settings["server"])
        _environment(home)
        worker.silence()
        confine.close_all_but(pipes if lock is None else [*pipes, lock])
        limits = settings["limits"]
        memory = confine.address_space() + limits["memory"]
        confine.limit(memory, limits["cpu_seconds"], limits["file_size"])
        if settings["seccomp"]:
            if lock is not None:
                landlock.restrict(lock)
                os.close(lock)
            confine.drop_capabilities()
            seccomp.refuse()
        worker.serve(*pipes)
        code = 0
    finally:
        os._exit(code)


def _environment(home: str) -> None:
    os.chdir(home)
    os.environ.clear()
    os.environ.update(
        HOME=home,
        TMPDIR=home,
        MPLCONFIGDIR=home,
        MPLBACKEND="Agg",
        LANG="C.UTF-8",
        FIELDCHECK_STATIC="1",
        OPENBLAS_NUM_THREADS="1",
        OMP_NUM_THREADS="1",
    )
