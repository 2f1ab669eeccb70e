"""How submissions are kept apart from the grader, and from each other: what this machine offers."""

from __future__ import annotations

import json
import os
import shutil
import socket
import subprocess
import sys
import sysconfig
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field
from importlib.resources import files
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Literal

from fieldrecon.course.sandbox import confine
from fieldrecon.reporting.fonts import copy_font_list

Tier = Literal["bubblewrap", "landlock", "none"]
TIERS: tuple[Tier, ...] = ("bubblewrap", "landlock", "none")
MEBIBYTE = 1 << 20
SYSTEM = ("/usr", "/lib", "/lib64", "/bin", "/etc/ld.so.cache", "/etc/localtime", "/dev/urandom")
BANNER = (
    "NOT ISOLATED: this machine has neither bubblewrap nor Landlock, so what students wrote runs "
    "with your rights. Grade in a container instead: see docs/instructors.md."
)


@dataclass(frozen=True)
class Limits:
    """What a submission may use.

    Parameters
    ----------
    memory : int
        Bytes beyond what NumPy and matplotlib take.
    cpu_seconds : int
        Processor time of one process; after it was killed, the rest is tried in another.
    file_size : int
        Bytes of a file.
    """

    memory: int = 1024 * MEBIBYTE
    cpu_seconds: int = 60
    file_size: int = 16 * MEBIBYTE


@dataclass(frozen=True)
class Ended:
    """How a process ended."""

    killed: bool = False
    signal: int = 0
    exit: int = 0
    cpu_seconds: float = 0.0
    peak: int = 0


def tiers() -> tuple[Tier, ...]:
    """Return the tiers that work on this machine, the safest first; each is tried."""
    found: list[Tier] = []
    if confine.landlock_version() and confine.seccomp_is_known():
        if _bubblewrap_works():
            found.append("bubblewrap")
        found.append("landlock")
    return (*found, "none")


def _bubblewrap_works() -> bool:
    if shutil.which("bwrap") is None:
        return False
    trial = ["bwrap", *_walls((), ()), "true"]
    return subprocess.run(trial, capture_output=True, check=False).returncode == 0


@dataclass
class Server:
    """A forking server behind the walls of a tier; it serves one submission at a time.

    Parameters
    ----------
    tier : str
        ``"bubblewrap"``, ``"landlock"`` or ``"none"``.
    limits : Limits
        What each submission may use.
    """

    tier: Tier
    limits: Limits = field(default_factory=Limits)

    @contextmanager
    def started(self) -> Iterator[Server]:
        """Start the server, and end it and all that it made at the end of the block."""
        with TemporaryDirectory(prefix="grading-") as scratch:
            stage, homes = Path(scratch) / "stage", Path(scratch) / "homes"
            homes.mkdir()
            _fill(stage)
            copy_font_list(homes / "matplotlib")
            ours, theirs = socket.socketpair()
            command = self._command(stage, homes, theirs.fileno())
            with ours, subprocess.Popen(
                command, pass_fds=[theirs.fileno()], stdin=subprocess.DEVNULL, cwd=stage,
                env={"PATH": os.defpath, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1",
                     "MPLBACKEND": "Agg"},
            ) as process:  # fmt: skip
                theirs.close()
                self._control = ours
                if ours.recv(1) != b"+":
                    raise RuntimeError(f"the server behind {self.tier} does not start")
                try:
                    yield self
                finally:
                    ours.close()
                    process.kill()

    def run(self) -> tuple[int, int]:
        """Start a locked-in process; return the pipes to write to and to read from."""
        their_in, to_them = os.pipe()
        from_them, their_out = os.pipe()
        socket.send_fds(self._control, [b"r"], [their_in, their_out])
        os.close(their_in)
        os.close(their_out)
        return to_them, from_them

    def end(self) -> Ended:
        """End the process, if it has not ended yet, and tell how it did."""
        self._control.sendall(b"e")
        answer = b""
        while not answer.endswith(b"\n"):
            answer += self._control.recv(4096)
        return Ended(**json.loads(answer))

    def _command(self, stage: Path, homes: Path, control: int) -> list[str]:
        packages = sysconfig.get_path("purelib")
        readable = [str(stage), *_python(), packages, *SYSTEM]
        settings: dict[str, Any] = {
            "stage": str(stage), "homes": str(homes), "packages": packages,
            "limits": asdict(self.limits), "readable": readable,
            "locks": [] if self.tier == "none" else ["landlock", "seccomp"],
        }  # fmt: skip
        start = f"import sys; sys.path.insert(0, {str(stage)!r}); "
        start += "from fieldrecon.course.sandbox.server import main; main()"
        python = [sys.executable, "-I", "-S", "-c", start, str(control)]
        walls = ["bwrap", *_walls(readable, (str(homes),))] if self.tier == "bubblewrap" else []
        return [*walls, *python, json.dumps(settings)]


def _python() -> list[str]:
    """Return the folders of this Python, and of the environment it runs in."""
    return sorted({sys.prefix, sys.base_prefix, str(Path(sys.executable).resolve().parent.parent)})


def _walls(readable: Sequence[str], writable: Sequence[str]) -> list[str]:
    """Return the options of bubblewrap: nothing is shared, a few folders can be read.

    The private /tmp is mounted first, since it would hide what is bound below it.
    """
    options = [
        "--unshare-all", "--die-with-parent", "--new-session", "--clearenv", "--tmpfs", "/tmp",
        "--dev", "/dev", "--proc", "/proc", "--setenv", "OPENBLAS_NUM_THREADS", "1",
        "--setenv", "MPLBACKEND", "Agg",
    ]  # fmt: skip
    for path in ("/usr", "/bin", "/lib", "/lib64", *readable):
        if Path(path).exists() and not path.startswith("/dev"):
            options += ["--ro-bind", path, path]
    for path in writable:
        options += ["--bind", path, path]
    return options


def _fill(stage: Path) -> None:
    """Copy what runs on the students' side: the locks, the calls, and no answers."""
    package = stage / "fieldrecon" / "course"
    shutil.copytree(str(files("fieldrecon.course.sandbox")), package / "sandbox", ignore=_compiled)
    for empty in (package, package.parent):
        (empty / "__init__.py").touch()
    shutil.copytree(str(files("fieldcheck")), stage / "fieldcheck", ignore=_answers)


_compiled = shutil.ignore_patterns("__pycache__")
_answers = shutil.ignore_patterns("__pycache__", "answers", "stubs.json")
