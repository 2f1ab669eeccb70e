"""The sandbox server as the grader controls it, and the tiers of isolation of this machine."""

from __future__ import annotations

import json
import os
import socket
import subprocess
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import asdict, dataclass, field
from typing import Any, Literal

from fieldgrade.isolation import file_access
from fieldgrade.isolation.scratch import Scratch
from fieldgrade.sandbox import landlock, seccomp

Tier = Literal["bubblewrap", "landlock", "none"]
TIERS: tuple[Tier, ...] = ("bubblewrap", "landlock", "none")
MEBIBYTE = 1 << 20
SECONDS_TO_START = 60.0
SECONDS_TO_ANSWER = 30.0
SECONDS_TO_END = 30.0
OWN_MOUNTS = True
"""Whether servers try to have mounts of their own; tests show what holds without them."""
BANNER = (
    "NOT ISOLATED: this machine has neither bubblewrap nor Landlock, so students' code runs "
    "with your rights. Grade in a container instead: see docs/threat-model.md."
)


class GraderError(Exception):
    """The grader fails, not the submission."""


class MachineFailed(RuntimeError):
    """The machine or the server failed while a submission ran: the submission must run again."""


@dataclass(frozen=True)
class Limits:
    """Limits of a submission.

    Parameters
    ----------
    memory : int
        Bytes, in addition to those of NumPy and matplotlib.
    cpu_seconds : int
        Processor time of one process, a limit for computations in the background. It covers a whole
        submission, so that no answer suffers from the time of others.
    file_size : int
        Bytes of one file.
    seconds_per_cell, seconds_per_call : float
        Time limits of a statement of a cell and of a call, after which the process is killed; a
        call with its own limit is killed after the shorter one.
    seconds_in_all : float
        Time limit of a whole submission.
    most_starts : int
        The largest number of processes of one submission.
    """

    memory: int = 1024 * MEBIBYTE
    cpu_seconds: int = 600
    file_size: int = 16 * MEBIBYTE
    seconds_per_cell: float = 10.0
    seconds_per_call: float = 60.0
    seconds_in_all: float = 600.0
    most_starts: int = 25


@dataclass(frozen=True)
class ProcessEnd:
    """The end of a process: its reason and its cost.

    Parameters
    ----------
    killed : bool
        Whether it still ran and was killed at the end.
    ended_for : str
        Why it was killed before that: ``"threads"`` or ``"disk"``.
    signal, exit : int
        The signal that ended the process, or its exit status.
    cpu_seconds : float
        Processor time.
    peak : int
        Peak memory, in bytes.
    machine : str
        A failure of the machine, such as a full disk, as a sentence; empty if there was none.
    """

    killed: bool = False
    ended_for: str = ""
    signal: int = 0
    exit: int = 0
    cpu_seconds: float = 0.0
    peak: int = 0
    machine: str = ""


def tiers() -> tuple[Tier, ...]:
    """Return the tiers that work on this machine, the safest first; bubblewrap is tested."""
    has_filter = seccomp.is_known()
    found: list[Tier] = []
    if has_filter and file_access.bubblewrap_works():
        found.append("bubblewrap")
    if has_filter and landlock.version():
        found.append("landlock")
    return (*found, "none")


@dataclass
class Server:
    """A forking server in a sandbox, which runs one submission at a time.

    If the server ends unexpectedly, the next submission starts a new one. The thread that starts it
    must outlive it, since bubblewrap ends with the thread that created it.

    Parameters
    ----------
    tier : str
        ``"bubblewrap"``, ``"landlock"`` or ``"none"``.
    limits : Limits
        The limits of each submission.
    """

    tier: Tier
    limits: Limits = field(default_factory=Limits)
    _process: subprocess.Popen[bytes] | None = field(default=None, init=False, repr=False)
    _over: bool = field(default=False, init=False, repr=False)
    _changing: threading.RLock = field(init=False, repr=False, compare=False)
    """Held while the process starts or ends: the thread that ends it may not be its user."""

    @contextmanager
    def started(self) -> Iterator[Server]:
        """Start the server; at the end of the block, end it and all its processes."""
        self._over, self._changing = False, threading.RLock()
        self._start()
        try:
            yield self
        finally:
            self._over = True
            self._stop()

    def run(self) -> tuple[int, int]:
        """Start a sandboxed process; return the pipes to write to and to read from.

        The pipe to write to does not block, so that a process that does not read it cannot block
        the grader.

        Raises
        ------
        RuntimeError
            The server does not start, or it has been ended, perhaps by another thread.
        """
        with self._changing:
            if self._over:
                raise RuntimeError("the server has been ended")
            if self._process is not None and self._process.poll() is not None:
                self._stop()
            if self._process is None:
                self._start()
        their_in, to_them = os.pipe()
        from_them, their_out = os.pipe()
        os.set_blocking(to_them, False)
        with suppress(OSError):  # the end of the server is noticed at the pipes
            socket.send_fds(self._control, [b"r"], [their_in, their_out])
        os.close(their_in)
        os.close(their_out)
        return to_them, from_them

    def exceeds_a_limit(self) -> bool:
        """Whether the process has too many threads or too large a home; if so, it is killed."""
        try:
            self._control.sendall(b"l")
            return self._control.recv(1) == b"-"
        except OSError:  # the end of the server is noticed at the pipes
            return False

    def end(self, patiently: bool = False) -> ProcessEnd:
        """End the process, if it has not ended yet, and return how it ended.

        Parameters
        ----------
        patiently : bool
            Allow the process to end by itself first, so that the reason can be reported.
        """
        answer = b""
        try:
            self._control.sendall(b"w" if patiently else b"e")
            while not answer.endswith(b"\n"):
                part = self._control.recv(4096)
                if not part:
                    raise ConnectionError
                answer += part
        except OSError:  # the server has ended, or takes too long
            self._stop()
            return ProcessEnd(killed=True, machine="the sandbox server ended or does not answer")
        return ProcessEnd(**json.loads(answer))

    def _start(self) -> None:
        self._scratch = Scratch.create()
        folders = file_access.SandboxFolders.create(self._scratch.folder)
        self._control, theirs = socket.socketpair()
        self._control.settimeout(SECONDS_TO_START)
        settings: dict[str, Any] = {
            **folders.settings(),
            "limits": asdict(self.limits),
            "seccomp": self.tier != "none",
            "mounts": self.tier != "none" and OWN_MOUNTS,
            "landlock": self.tier != "none" and landlock.version() > 0,
        }
        python = [*folders.python(), str(theirs.fileno()), json.dumps(settings)]
        self._process = subprocess.Popen(
            [*folders.bubblewrap(), *python] if self.tier == "bubblewrap" else python,
            pass_fds=[theirs.fileno()],
            stdin=subprocess.DEVNULL,
            cwd=folders.stage,
            env=file_access.ENVIRONMENT,
            start_new_session=True,
        )
        theirs.close()
        with suppress(OSError):
            if self._control.recv(1) == b"+":
                self._control.settimeout(SECONDS_TO_ANSWER)
                return
        self._stop()
        raise RuntimeError(f"the sandbox server ({self.tier}) does not start")

    def _stop(self) -> None:
        """End the server and with it its processes; kill it if it hangs."""
        with self._changing:
            if self._process is None:
                return
            process, self._process = self._process, None
            with suppress(OSError):
                self._control.shutdown(socket.SHUT_RDWR)
            self._control.close()
            try:
                process.wait(SECONDS_TO_END)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
            self._scratch.remove()
