"""What is on the students' side: a Python without the course, in walls of bubblewrap's."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import sysconfig
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Any

from fieldrecon.plotting.fonts import copy_font_list

SYSTEM = ("/usr", "/lib", "/lib64", "/bin", "/etc/ld.so.cache", "/etc/localtime")
DEVICES = ("/dev/urandom", "/dev/random", "/dev/zero")
ENVIRONMENT = {
    "PATH": os.defpath,
    "MPLBACKEND": "Agg",
    "OPENBLAS_NUM_THREADS": "1",
    "OMP_NUM_THREADS": "1",
}
"""All that a server is told by its environment; nothing is inherited."""
PACKAGES = ("fieldrecon", "fieldreport", "fieldcheck", "fieldgrade")
SECONDS_TO_TRY = 20.0


@dataclass(frozen=True)
class SandboxFolders:
    """Where students' code runs.

    Parameters
    ----------
    stage : Path
        A folder with what runs there: the locks and the calls, no answers.
    homes : Path
        The only folder that a submission may write to; empty when it comes.
    fonts : Path
        matplotlib's list of fonts, read when the server starts.
    """

    stage: Path
    homes: Path
    fonts: Path

    @classmethod
    def made(cls, scratch: Path) -> SandboxFolders:
        """Make the folders in an empty one."""
        place = cls(scratch / "stage", scratch / "homes", scratch / "fonts")
        place.homes.mkdir(mode=0o700)
        _fill(place.stage)
        copy_font_list(place.fonts)
        return place

    def told(self) -> dict[str, Any]:
        """Return what the server needs to know of the place."""
        hidden = hidden_folders()
        parts = [(path, part) for path in self._readable() for part in _without(path, hidden)]
        return {
            "homes": str(self.homes),
            "fonts": str(self.fonts),
            "packages": _packages(),
            "readable": [str(part) for _, part in parts] + list(DEVICES),
            "listed": sorted({str(part.parent) for path, part in parts if part != path}),
        }

    def python(self) -> list[str]:
        """Return the command that starts a server, to be followed by what it is told.

        It is the Python that the environment was made from, which knows nothing of the
        environment and reads no start-up files.
        """
        start = f"import sys; sys.path.insert(0, {str(self.stage)!r}); "
        start += "from fieldgrade.sandbox.server import main; main()"
        return [getattr(sys, "_base_executable", sys.executable), "-I", "-S", "-B", "-c", start]

    def bubblewrap(self) -> list[str]:
        """Return the command that puts the walls up."""
        return _walls(self._readable(), (self.homes, self.fonts), hidden_folders())

    def _readable(self) -> list[Path]:
        folders = [*map(Path, SYSTEM), Path(sys.base_prefix), *map(Path, _packages()), self.stage]
        return [path for path in dict.fromkeys(folders) if path.exists()]


def work() -> bool:
    """Whether bubblewrap is installed, and the kernel lets it put up walls."""
    if shutil.which("bwrap") is None:
        return False
    readable = [Path(path) for path in SYSTEM if Path(path).exists()]
    trial = [*_walls(readable, (), ()), "true"]
    try:
        return not subprocess.run(trial, capture_output=True, timeout=SECONDS_TO_TRY).returncode
    except subprocess.TimeoutExpired:
        return False


def hidden_folders() -> list[Path]:
    """Return the folders of the course, which nothing on the students' side may read."""
    packages = [Path(str(files(name))).resolve() for name in PACKAGES]
    roots = [package.parent.parent for package in packages]
    return list(dict.fromkeys([*packages, *(r for r in roots if (r / "solutions").is_dir())]))


def _packages() -> list[str]:
    return list(dict.fromkeys(sysconfig.get_path(name) for name in ("purelib", "platlib")))


def _walls(readable: Iterable[Path], writable: Iterable[Path], hidden: Iterable[Path]) -> list[str]:
    """Return the command of bubblewrap: nothing is shared, a few folders can be read.

    The private /tmp is mounted first, since it would hide what is bound below it. What can be
    written to is bound from outside, where it is emptied; all else is read-only in the end.
    """
    options = [
        "--unshare-all",
        "--die-with-parent",
        "--new-session",
        "--tmpfs",
        "/tmp",
        "--dev",
        "/dev",
        "--proc",
        "/proc",
    ]
    masks: dict[str, None] = {}
    for path in readable:
        options += ["--ro-bind", str(path), str(path)]
        for inside in (h for h in hidden if h.is_relative_to(path.resolve())):
            options += ["--tmpfs", str(inside)]
            masks[str(inside)] = None
    for path in writable:
        options += ["--bind", str(path), str(path)]
    for place in (*masks, "/tmp", "/dev", "/"):
        options += ["--remount-ro", place]
    return [shutil.which("bwrap") or "bwrap", *options]


def _without(folder: Path, hidden: Iterable[Path]) -> Iterator[Path]:
    """Yield a folder or, if it holds hidden ones, what else it holds; links do not lead out."""
    place = folder.resolve()
    if place in hidden:
        return
    if not any(h.is_relative_to(place) for h in hidden):
        yield folder
        return
    for entry in sorted(folder.iterdir()):
        if not entry.is_symlink() or entry.resolve().is_relative_to(place):
            yield from _without(entry, hidden)


def _fill(stage: Path) -> None:
    """Copy what runs on the students' side: the locks, the calls, and no answers."""
    package = stage / "fieldgrade"
    shutil.copytree(str(files("fieldgrade.sandbox")), package / "sandbox", ignore=_compiled)
    (package / "__init__.py").touch()
    shutil.copytree(str(files("fieldcheck")), stage / "fieldcheck", ignore=_answers)


_compiled = shutil.ignore_patterns("__pycache__")
_answers = shutil.ignore_patterns("__pycache__", "answers", "stubs.json")
