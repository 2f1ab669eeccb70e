"""The trial of mutants: each in a fork of one process, which has imported the other packages."""

from __future__ import annotations

import json
import os
import resource
import shutil
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass, field
from importlib import import_module
from pathlib import Path
from time import monotonic

from tools.mutation.judged import ROOT
from tools.mutation.mutants import Mutant
from tools.mutation.reach import OF_THE_LIBRARY, WORK, Reach, of_the_copy

LEFT_BEHIND = (".git", ".venv*", "build", "dist", "__pycache__", ".*_cache", ".hypothesis")
IMPORTED = (
    *("hypothesis", "matplotlib.pyplot", "meshio", "numpy.testing", "pandas", "pyarrow", "pyproj"),
    *("pytest", "scipy.interpolate", "scipy.linalg", "scipy.optimize", "scipy.sparse.linalg"),
    *("scipy.spatial", "scipy.special", "scipy.stats", "skimage.measure", "sympy", "xarray"),
)
"""Packages that the tests use; a fork need not import them again."""
FAST = 40
"""So many of the fastest tests run first, since most mutants are caught by one of them."""
PATIENCE = ("-o", "faulthandler_timeout=200", "-o", "faulthandler_exit_on_timeout=true")
"""A test that takes more seconds does not end; without a mutant none takes a fifth of them."""


def copy_of_checkout(name: str) -> Path:
    """Return a fresh copy of the checkout."""
    folder = WORK / name
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(ROOT, folder, ignore=shutil.ignore_patterns(*LEFT_BEHIND), symlinks=True)
    return folder


def compile_tests(folders: Sequence[Path]) -> None:
    """Compile the library and its tests in the copies, which no trial does."""
    command = (*(sys.executable, "-m", "pytest", "-p", "no:cacheprovider", "-q"), "--collect-only")
    running = [
        subprocess.Popen(
            (*command, *OF_THE_LIBRARY, "src/fieldrecon"),
            cwd=folder,
            env=os.environ | of_the_copy(folder) | {"PYTHONDONTWRITEBYTECODE": ""},
            stdout=subprocess.DEVNULL,
        )
        for folder in folders
    ]
    for process in running:
        process.wait()


@dataclass(frozen=True)
class Trial:
    """A mutant in a copy of the checkout, and the tests that may catch it."""

    mutant: Mutant
    folder: Path
    tests: list[str]
    seconds: float
    begin: float = field(default_factory=monotonic)

    def start(self) -> int:
        """Start the tests in a fork, and return its number."""
        source = (ROOT / self.mutant.path).read_text()
        (self.folder / self.mutant.path).write_text(self.mutant.code(source))
        number = os.fork()
        if number == 0:
            try:
                os._exit(self._run())
            finally:  # whatever was raised, no fork goes on with the work of its parent
                os._exit(1)
        return number

    def _run(self) -> int:
        """Run the tests in this process: 0 if all of them pass."""
        import pytest

        limit = int(120 + 10 * self.seconds)
        resource.setrlimit(resource.RLIMIT_CPU, (limit, limit))
        os.chdir(self.folder)
        os.environ |= of_the_copy(self.folder)
        sys.dont_write_bytecode = True
        sys.path[0] = str(self.folder / "src")
        for stream in (1, 2):
            os.dup2(os.open(os.devnull, os.O_WRONLY), stream)
        already = ("-W", "ignore::pytest.PytestAssertRewriteWarning")
        options = ("-x", "-q", "-p", "no:cacheprovider", *already, *PATIENCE)
        parts = filter(None, (self.tests[:FAST], self.tests[FAST:]))
        return int(any(pytest.main([*options, *part]) for part in parts))

    def restore(self) -> None:
        """Write the right code again, of its old date: it is compiled."""
        shutil.copy2(ROOT / self.mutant.path, self.folder / self.mutant.path)


def trials(
    mutants: Sequence[Mutant], known: Reach, folders: Sequence[Path], results: Path
) -> dict[str, str]:
    """Return of each mutant whether it is `caught`, `survived`, or `unreached` by any test.

    Those in the file of results are not tried again.
    """
    outcomes: dict[str, str] = {}
    if results.exists():
        outcomes = dict(json.loads(line) for line in results.read_text().splitlines())

    def note(mutant: Mutant, found: str, seconds: float = 0.0) -> None:
        outcomes[repr(mutant)] = found
        with results.open("a") as file:
            file.write(json.dumps([repr(mutant), found]) + "\n")
        at = f"{mutant.path}:{mutant.statement[0]}"
        done = f"{sum(repr(m) in outcomes for m in mutants)}/{len(mutants)}"
        print(f"{done:>8} {found:9} {seconds:6.1f} s  {at}  {mutant.operator}", flush=True)

    for name in IMPORTED:
        import_module(name)
    waiting = [mutant for mutant in reversed(mutants) if repr(mutant) not in outcomes]
    free, running = list(folders), dict[int, Trial]()
    while waiting or running:
        while waiting and free:
            mutant = waiting.pop()
            if tests := known.of(mutant):
                seconds = sum(known.seconds.get(test, 0.0) for test in tests)
                trial = Trial(mutant, free.pop(), tests, seconds)
                running[trial.start()] = trial
            else:
                note(mutant, "unreached")
        if running:
            number, status = os.wait()
            ended = running.pop(number)
            ended.restore()
            free.append(ended.folder)
            found = "caught" if status else "survived"
            note(ended.mutant, found, monotonic() - ended.begin)
    return outcomes
