"""The files that the sandbox can see: Python without the course, by bubblewrap and by Landlock."""

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
"""The whole environment of a server; nothing is inherited."""
PACKAGES = ("fieldrecon", "fieldreport", "fieldcheck", "fieldgrade")
SECONDS_TO_TRY = 20.0


@dataclass(frozen=True)
class SandboxFolders:
    """The folders of a sandbox.

    Parameters
    ----------
    stage : Path
        The code that runs in the sandbox: restrictions and calls, no answers.
    homes : Path
        The only folder that a submission may write to; empty at the start.
    fonts : Path
        The font list of matplotlib, read when the server starts.
    """

    stage: Path
    homes: Path
    fonts: Path

    @classmethod
    def create(cls, scratch: Path) -> SandboxFolders:
        """Create the folders in an empty folder."""
        folders = cls(scratch / "stage", scratch / "homes", scratch / "fonts")
        folders.homes.mkdir(mode=0o700)
        _fill(folders.stage)
        copy_font_list(folders.fonts)
        return folders

    def settings(self) -> dict[str, Any]:
        """Return the settings of the server: its folders, and the paths that Landlock allows."""
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
        """Return the command that starts a server; its arguments follow.

        It is the base Python of the virtual environment, which does not use the environment and
        reads no start-up files.
        """
        start = f"import sys; sys.path.insert(0, {str(self.stage)!r}); "
        start += "from fieldgrade.sandbox.server import main; main()"
        return [getattr(sys, "_base_executable", sys.executable), "-I", "-S", "-B", "-c", start]

    def bubblewrap(self) -> list[str]:
        """Return the bubblewrap command, to be followed by the command to run."""
        return _bubblewrap_command(self._readable(), (self.homes, self.fonts), hidden_folders())

    def _readable(self) -> list[Path]:
        folders = [*map(Path, SYSTEM), Path(sys.base_prefix), *map(Path, _packages()), self.stage]
        return [path for path in dict.fromkeys(folders) if path.exists()]


def bubblewrap_works() -> bool:
    """Whether bubblewrap is installed and the kernel permits its namespaces."""
    if shutil.which("bwrap") is None:
        return False
    readable = [Path(path) for path in SYSTEM if Path(path).exists()]
    trial = [*_bubblewrap_command(readable, (), ()), "true"]
    try:
        return not subprocess.run(trial, capture_output=True, timeout=SECONDS_TO_TRY).returncode
    except subprocess.TimeoutExpired:
        return False


def hidden_folders() -> list[Path]:
    """Return the folders of the course, which the sandbox may not read."""
    packages = [Path(str(files(name))).resolve() for name in PACKAGES]
    roots = [package.parent.parent for package in packages]
    return list(dict.fromkeys([*packages, *(r for r in roots if (r / "solutions").is_dir())]))


def _packages() -> list[str]:
    return list(dict.fromkeys(sysconfig.get_path(name) for name in ("purelib", "platlib")))


def _bubblewrap_command(
    readable: Iterable[Path], writable: Iterable[Path], hidden: Iterable[Path]
) -> list[str]:
    """Return the bubblewrap command: no shared namespace, a few readable folders.

    The private /tmp is mounted first, since it would hide mounts below it. Writable folders are
    bound from outside, where they are emptied; everything else is remounted read-only at the end.
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
    for path_in_sandbox in (*masks, "/tmp", "/dev", "/"):
        options += ["--remount-ro", path_in_sandbox]
    return [shutil.which("bwrap") or "bwrap", *options]


def _without(folder: Path, hidden: Iterable[Path]) -> Iterator[Path]:
    """Yield a folder or, if it has hidden folders, its other entries; no link leads out."""
    resolved = folder.resolve()
    if resolved in hidden:
        return
    if not any(h.is_relative_to(resolved) for h in hidden):
        yield folder
        return
    for entry in sorted(folder.iterdir()):
        if not entry.is_symlink() or entry.resolve().is_relative_to(resolved):
            yield from _without(entry, hidden)


def _fill(stage: Path) -> None:
    """Copy the code that runs in the sandbox: restrictions and calls, no answers."""
    package = stage / "fieldgrade"
    shutil.copytree(str(files("fieldgrade.sandbox")), package / "sandbox", ignore=_compiled)
    (package / "__init__.py").touch()
    shutil.copytree(str(files("fieldcheck")), stage / "fieldcheck", ignore=_answers)


_compiled = shutil.ignore_patterns("__pycache__")
_answers = shutil.ignore_patterns("__pycache__", "answers", "stubs.json")
