"""The forking server: it imports NumPy once, and forks a restricted process for each submission.

Its arguments are the number of a socket and a JSON object of settings. The server runs no student's
code: it forks, and the child restricts itself before it runs any. Commands are one byte each:
``r``, with two pipes, starts a process; ``e`` ends it and reports how it ended; ``w`` does the same
after a moment in which it can end by itself. Meanwhile the server watches what the kernel does not
limit: the number of threads, the size of the home, and the room on its disk. ``l`` lets it look at
once and answer ``+``, or ``-`` if the process exceeds a limit and was killed.
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

from fieldgrade.sandbox import confine, homes, landlock, mounts, seccomp
from fieldgrade.sandbox.kernel import processes, read_process

PRELOADED = ("numpy", "numpy.polynomial", "numpy.random", "numpy.testing", "matplotlib.pyplot")
"""Modules that notebooks import, or NumPy imports late, so that forked processes have them."""
SECONDS_BETWEEN_LOOKS = 0.1
SECONDS_TO_END_ITSELF = 0.5
MOST_THREADS = 64
MOST_ROUNDS = 1000


@dataclass
class Child:
    """A running process, the folder of its home, and why it was killed, if it was.

    The machine's failure is a sentence.
    """

    process: int
    homes: str
    file_size: int
    ended_for: str = ""
    machine: str = ""


def main() -> None:
    """Import modules, then serve commands until the socket is closed."""
    control = socket.socket(fileno=int(sys.argv[1]))
    settings = json.loads(sys.argv[2])
    processes()  # opened before it is hidden
    own_mounts = settings["mounts"] and mounts.are_allowed(settings["homes"], settings["packages"])
    if own_mounts:
        mounts.separate()  # before an import starts a thread
    sys.path += settings["packages"]
    os.environ["MPLCONFIGDIR"] = settings["fonts"]
    for name in PRELOADED:
        import_module(name)
    from fieldcheck.questions import questions
    from fieldgrade.sandbox import worker

    questions()
    worker.quiet_fieldcheck()
    worker.quiet_matplotlib()
    settings["server"] = os.getpid()
    if own_mounts:  # matplotlib has written its settings by now
        size, entries = homes.HARD_LIMIT * homes.MOST_BYTES, homes.HARD_LIMIT * homes.MOST_ENTRIES
        mounts.close_off(settings["homes"], size, entries)
    confine.adopt_orphans()
    confine.hide_memory()
    ruleset = None
    if settings["landlock"]:
        writable = [settings["homes"], os.devnull]
        ruleset = landlock.ruleset(settings["readable"], settings["listed"], writable)
    control.sendall(b"+")
    child: Child | None = None
    failure = ""
    while True:
        if child and not select.select([control], [], [], SECONDS_BETWEEN_LOOKS)[0]:
            _look_after(child)
            continue
        command, pipes, *_ = socket.recv_fds(control, 1, 2)
        if command == b"l":
            if child:
                _look_after(child)
            control.sendall(b"-" if child and child.ended_for else b"+")
            continue
        if command == b"r":
            try:
                home = tempfile.mkdtemp(dir=settings["homes"])
                process = os.fork()
            except OSError as error:
                child, failure = None, str(error)
            else:
                if process == 0:
                    _run(settings, home, pipes, ruleset)
                child = Child(process, settings["homes"], settings["limits"]["file_size"])
            for pipe in pipes:
                os.close(pipe)
            continue
        grace = SECONDS_TO_END_ITSELF if command == b"w" else 0.0
        ended = _end(child, grace) if child else {"machine": failure}
        child = None
        if not command:
            return
        control.sendall(json.dumps(ended).encode() + b"\n")


def _look_after(child: Child) -> None:
    """Kill a child with too many threads or too large a home."""
    if child.ended_for:
        return
    child.machine = child.machine or homes.lacking(child.homes)
    if _threads(child.process) > MOST_THREADS:
        child.ended_for = "threads"
    elif homes.is_overfull(child.homes, child.process, child.file_size):
        child.ended_for = "disk"
    if child.ended_for:
        with suppress(ProcessLookupError):
            os.kill(child.process, signal.SIGKILL)


def _threads(process: int) -> int:
    try:
        return int(read_process(f"{process}/stat").rpartition(")")[2].split()[17])
    except OSError:
        return 1


def _end(child: Child, grace: float = 0.0) -> dict[str, Any]:
    """End a child and its descendants, and return how it ended."""
    last = time.monotonic() + grace
    ended, status, usage = os.wait4(child.process, os.WNOHANG)
    while not ended and time.monotonic() < last:
        time.sleep(0.005)
        ended, status, usage = os.wait4(child.process, os.WNOHANG)
    machine = child.machine or homes.lacking(child.homes)
    result = {"killed": not ended, "ended_for": child.ended_for, "machine": machine}
    if not ended:
        os.kill(child.process, signal.SIGKILL)
        _, status, usage = os.wait4(child.process, 0)
    with suppress(ProcessLookupError, PermissionError):
        os.killpg(child.process, signal.SIGKILL)
    _end_orphans()
    homes.empty(child.homes)
    return result | {
        "signal": os.WTERMSIG(status) if os.WIFSIGNALED(status) else 0,
        "exit": os.WEXITSTATUS(status) if os.WIFEXITED(status) else 0,
        "cpu_seconds": usage.ru_utime + usage.ru_stime,
        "peak": usage.ru_maxrss * (1 if sys.platform == "darwin" else 1024),
    }


def _end_orphans() -> None:
    """Kill orphaned processes, which have become children of this one."""
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
        return [int(number) for number in read_process("thread-self/children").split()]
    except OSError:
        return []


def _run(settings: dict[str, Any], home: str, pipes: list[int], ruleset: int | None) -> None:
    """Restrict this process and serve frames; this function never returns."""
    from fieldgrade.sandbox import worker

    code = 1
    try:
        os.setsid()
        confine.die_with_parent(settings["server"])
        _environment(home)
        worker.silence()
        limits = settings["limits"]
        memory = confine.address_space() + limits["memory"]
        confine.close_all_but(pipes if ruleset is None else [*pipes, ruleset])
        confine.limit(memory, limits["cpu_seconds"], limits["file_size"])
        if not homes.is_in_memory(settings["homes"]):
            confine.hide_memory(False)  # the server looks for deleted files that are kept open
        if settings["seccomp"]:
            if ruleset is not None:
                landlock.restrict(ruleset)
                os.close(ruleset)
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
