"""How submissions are kept apart from the grader, and from each other: what this machine offers."""

from __future__ import annotations

import json
import os
import socket
import subprocess
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, Literal

from fieldgrade.isolation import file_access
from fieldgrade.sandbox import homes, landlock, seccomp

Tier = Literal["bubblewrap", "landlock", "none"]
TIERS: tuple[Tier, ...] = ("bubblewrap", "landlock", "none")
MEBIBYTE = 1 << 20
SECONDS_TO_START = 60.0
SECONDS_TO_END = 30.0
BANNER = (
    "NOT ISOLATED: this machine has neither bubblewrap nor Landlock, so what students wrote runs "
    "with your rights. Grade in a container instead: see docs/threat-model.md."
)


class GraderError(Exception):
    """The grader fails, not the submission."""


@dataclass(frozen=True)
class Limits:
    """What a submission may use.

    Parameters
    ----------
    memory : int
        Bytes beyond what NumPy and matplotlib take.
    cpu_seconds : int
        Processor time of one process, for what computes in the background; it is as long as a
        submission may take, so that no answer pays for what others have used.
    file_size : int
        Bytes of a file.
    seconds_per_cell, seconds_per_call : float
        After so many seconds a cell or a call is ended, however it holds on; calls that have a
        limit of their own are ended by the shorter one.
    seconds_in_all : float
        After so many seconds what is left of a submission is given up,
    most_starts : int
        and after so many processes, each of which broke down.
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
    """How a process ended.

    Parameters
    ----------
    killed : bool
        It still ran when it was told to end.
    ended_for : str
        What it was ended for before that: ``"threads"``, ``"disk"``, or ``"server"`` if the server
        went with it.
    signal, exit : int
        The signal that ended it, or its exit status.
    cpu_seconds : float
        Processor time.
    peak : int
        Bytes of memory, at most.
    """

    killed: bool = False
    ended_for: str = ""
    signal: int = 0
    exit: int = 0
    cpu_seconds: float = 0.0
    peak: int = 0


def tiers() -> tuple[Tier, ...]:
    """Return the tiers that work on this machine, the safest first; bubblewrap is tried."""
    locks = seccomp.is_known()
    found: list[Tier] = []
    if locks and file_access.work():
        found.append("bubblewrap")
    if locks and landlock.version():
        found.append("landlock")
    return (*found, "none")


@dataclass
class Server:
    """A forking server behind the walls of a tier; it serves one submission at a time.

    If it ends unasked, the next submission finds a new one. The thread that starts it must outlive
    it, since bubblewrap ends with the thread that made it.

    Parameters
    ----------
    tier : str
        ``"bubblewrap"``, ``"landlock"`` or ``"none"``.
    limits : Limits
        What each submission may use.
    """

    tier: Tier
    limits: Limits = field(default_factory=Limits)
    _process: subprocess.Popen[bytes] | None = field(default=None, init=False, repr=False)
    _over: bool = field(default=False, init=False, repr=False)

    @contextmanager
    def started(self) -> Iterator[Server]:
        """Start the server, and end it and all that it made at the end of the block."""
        self._over = False
        self._start()
        try:
            yield self
        finally:
            self._over = True
            self._stop()

    def run(self) -> tuple[int, int]:
        """Start a locked-in process; return the pipes to write to and to read from.

        The pipe to write to does not block, so that who does not read it holds up nobody.

        Raises
        ------
        RuntimeError
            The server does not start, or it has been ended, by another thread perhaps.
        """
        if self._over:
            raise RuntimeError("the server has been ended")
        if self._process is not None and self._process.poll() is not None:
            self._stop()
        if self._process is None:
            self._start()
        their_in, to_them = os.pipe()
        from_them, their_out = os.pipe()
        os.set_blocking(to_them, False)
        with suppress(OSError):  # its end is seen at the other end of the pipes
            socket.send_fds(self._control, [b"r"], [their_in, their_out])
        os.close(their_in)
        os.close(their_out)
        return to_them, from_them

    def end(self, patiently: bool = False) -> ProcessEnd:
        """End the process, if it has not ended yet, and tell how it did.

        Parameters
        ----------
        patiently : bool
            Give it a moment to end by itself, so that it can be told why it does.
        """
        answer = b""
        try:
            self._control.sendall(b"w" if patiently else b"e")
            while not answer.endswith(b"\n"):
                part = self._control.recv(4096)
                if not part:
                    raise ConnectionError
                answer += part
        except OSError:  # it is gone, or takes too long
            self._stop()
            return ProcessEnd(killed=True, ended_for="server")
        return ProcessEnd(**json.loads(answer))

    def _start(self) -> None:
        self._scratch = Path(tempfile.mkdtemp(prefix="grading-"))
        place = file_access.SandboxFolders.made(self._scratch)
        self._control, theirs = socket.socketpair()
        self._control.settimeout(SECONDS_TO_START)
        settings: dict[str, Any] = {
            **place.told(),
            "limits": asdict(self.limits),
            "seccomp": self.tier != "none",
            "landlock": self.tier != "none" and landlock.version() > 0,
        }
        python = [*place.python(), str(theirs.fileno()), json.dumps(settings)]
        self._process = subprocess.Popen(
            [*place.bubblewrap(), *python] if self.tier == "bubblewrap" else python,
            pass_fds=[theirs.fileno()],
            stdin=subprocess.DEVNULL,
            cwd=place.stage,
            env=file_access.ENVIRONMENT,
            start_new_session=True,
        )
        theirs.close()
        with suppress(OSError):
            if self._control.recv(1) == b"+":
                self._control.settimeout(SECONDS_TO_END)
                return
        self._stop()
        raise RuntimeError(f"the server behind {self.tier} does not start")

    def _stop(self) -> None:
        """End the server, which ends what it made; what hangs is killed."""
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
        homes.remove(str(self._scratch))
