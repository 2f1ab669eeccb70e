"""Other libraries in separate environments: worker processes that answer over standard input.

Some packages cannot be installed into the environment of the benchmarks, because of their licence,
their size or their dependencies. uv creates an environment for them, and a worker process in it
does the work on request.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import threading
from pathlib import Path


class Peer:
    """A worker script in an environment with the given packages; it answers requests one by one.

    Parameters
    ----------
    worker : Path
        A script that prints a line when it is ready, and then one line of JSON per input line.
    packages : tuple of str
        Requirements with versions.
    arguments : str
        Command-line arguments of the worker.
    """

    def __init__(self, worker: Path, packages: tuple[str, ...], *arguments: str) -> None:
        environment = [option for package in packages for option in ("--with", package)]
        self._command = [
            sys.executable,
            "-m",
            "uv",
            "run",
            "--quiet",
            "--no-project",
            "--python",
            sys.executable,
            *environment,
            "python",
            str(worker),
            *arguments,
        ]
        self.ready = self._started()

    def ask(self, what: str, patience: float | None = None) -> dict | None:
        """The answer of the worker, or None after a timeout, when a new worker is started."""
        end = threading.Timer(patience or threading.TIMEOUT_MAX, self._end)
        end.start()
        self._process.stdin.write(what + "\n")
        self._process.stdin.flush()
        answer = self._process.stdout.readline()
        end.cancel()
        if answer:
            return json.loads(answer)
        self._process.wait()
        self._started()
        return None

    def close(self) -> None:
        """End the worker."""
        self._process.communicate()

    def _started(self) -> bool:
        self._process = subprocess.Popen(
            self._command,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            start_new_session=True,
        )
        return bool(self._process.stdout.readline())

    def _end(self) -> None:
        os.killpg(self._process.pid, signal.SIGKILL)  # uv and the Python process that it started
