"""The forking server: it imports NumPy once, and makes a locked-in process for each submission.

Its arguments are the number of a socket and a JSON object of settings. It runs no code of a
student: it forks, and the child locks itself in before it does. Commands are a byte each: ``r``,
with two pipes, to run, and ``e`` to end what runs and be told how it ended.
"""

from __future__ import annotations

import json
import os
import shutil
import signal
import socket
import sys
import tempfile
from contextlib import suppress
from importlib import import_module
from typing import Any

PRELOADED = ("numpy", "matplotlib.pyplot")
"""What notebooks import anyway; the processes that are forked have it already."""


def main() -> None:
    """Import what students need, then serve commands until the socket is closed."""
    control = socket.socket(fileno=int(sys.argv[1]))
    settings = json.loads(sys.argv[2])
    sys.path.append(settings["packages"])
    os.environ["MPLCONFIGDIR"] = settings["homes"] + "/matplotlib"
    for name in PRELOADED:
        import_module(name)
    from fieldcheck.questions import questions
    from fieldrecon.course.sandbox import worker

    questions()
    worker.quiet_fieldcheck()
    control.sendall(b"+")
    child, home = 0, ""
    while True:
        command, pipes, *_ = socket.recv_fds(control, 1, 2)
        if not command:
            _end(child, home)
            return
        if command == b"r":
            home = tempfile.mkdtemp(dir=settings["homes"])
            child = os.fork()
            if child == 0:
                control.close()
                _child(settings, home, pipes)
            for pipe in pipes:
                os.close(pipe)
        else:
            control.sendall(json.dumps(_end(child, home)).encode() + b"\n")
            child = 0


def _end(child: int, home: str) -> dict[str, Any]:
    """End a child and all that it may have left, and tell how it ended."""
    if not child:
        return {}
    ended, status, usage = os.wait4(child, os.WNOHANG)
    told = {"killed": not ended}
    if not ended:
        os.kill(child, signal.SIGKILL)
        _, status, usage = os.wait4(child, 0)
    with suppress(ProcessLookupError, PermissionError):
        os.killpg(child, signal.SIGKILL)
    shutil.rmtree(home, ignore_errors=True)
    return told | {
        "signal": os.WTERMSIG(status) if os.WIFSIGNALED(status) else 0,
        "exit": os.WEXITSTATUS(status) if os.WIFEXITED(status) else 0,
        "cpu_seconds": usage.ru_utime + usage.ru_stime,
        "peak": usage.ru_maxrss * (1 if sys.platform == "darwin" else 1024),
    }


def _child(settings: dict[str, Any], home: str, pipes: list[int]) -> None:
    """Lock this process in and run what comes; it never returns."""
    from fieldrecon.course.sandbox import confine, worker

    code = 1
    try:
        os.setsid()
        confine.die_with_parent()
        incoming, outgoing = pipes
        _environment(home)
        worker.silence()
        limits = settings["limits"]
        used = confine.address_space() if sys.platform == "linux" else 0
        confine.limit(used + limits["memory"], limits["cpu_seconds"], limits["file_size"])
        if "landlock" in settings["locks"]:
            confine.landlock(settings["readable"], [home, os.devnull])
        if "seccomp" in settings["locks"]:
            confine.drop_capabilities()
            confine.seccomp()
        worker.serve(incoming, outgoing)
        code = 0
    finally:
        os._exit(code)


def _environment(home: str) -> None:
    os.chdir(home)
    os.environ.clear()
    os.environ.update(
        HOME=home, TMPDIR=home, MPLCONFIGDIR=home, MPLBACKEND="Agg", LANG="C.UTF-8",
        FIELDCHECK_STATIC="1", OPENBLAS_NUM_THREADS="1", OMP_NUM_THREADS="1",
    )  # fmt: skip

