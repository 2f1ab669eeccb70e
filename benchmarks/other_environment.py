"""A peer in an environment of its own, kept running, and asked over its standard input.

Some packages do not go into the environment of the benchmarks: for their licence, their size or
what they depend on. uv makes them one, and a worker in it does the work when told to.
"""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path


class Peer:
    """A worker script in an environment with some packages, asked for one thing after the other.

    Parameters
    ----------
    worker : Path
        Prints a line when it is ready, and then one of JSON for each line it reads.
    packages : tuple of str
        With their versions.
    arguments : str
        Of the worker.
    """

    def __init__(self, worker: Path, packages: tuple[str, ...], *arguments: str) -> None:
        environment = [option for package in packages for option in ("--with", package)]
        command = [sys.executable, "-m", "uv", "run", "--quiet", "--no-project", "--python",
                   sys.executable, *environment, "python", str(worker), *arguments]  # fmt: skip
        self._process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )
        self.ready = bool(self._process.stdout.readline())

    def ask(self, what: str) -> dict:
        """Answer of the worker."""
        self._process.stdin.write(what + "\n")
        self._process.stdin.flush()
        return json.loads(self._process.stdout.readline())

    def close(self) -> None:
        """End the worker."""
        self._process.communicate()
