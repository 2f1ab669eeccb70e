"""A run that finds nothing changed repeats the report of the run before.

All that the results depend on is compared by content: submissions, tables, sources, secret, grader,
installed packages, sandbox and options. Comparing takes less time than the imports of NumPy and
pytest, so this module imports neither.
"""

from __future__ import annotations

import argparse
import json
import platform
import sys
from collections.abc import Iterable, Iterator
from dataclasses import asdict, dataclass
from importlib.metadata import distributions
from importlib.util import find_spec
from pathlib import Path

from fieldgrade.isolation.server import tiers
from fieldrecon._core.atomic_files import write_atomically
from fieldrecon._core.digests import file_digest, json_digest

FILE = "last-report.json"
RESULTS = ("results.json", "decided.json", "needs-your-eyes.html", "needs-your-eyes.csv")
PACKAGES = ("fieldcheck", "fieldgrade", "fieldrecon")
SOURCES = ("solutions", ".course-secret.json")
WITHOUT_EFFECT = ("command", "jobs")


@dataclass(frozen=True)
class Report:
    """What a run prints.

    Parameters
    ----------
    status : int
        The exit status.
    lines : tuple of str
        Lines of the output.
    warnings : tuple of str
        Warnings about the sandbox and the secret.
    """

    status: int
    lines: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()


def inputs_digest(options: argparse.Namespace) -> str:
    """Return the digest of all that a run depends on; empty if it is not known.

    Checks of the instructor may read any file, so that a run with such checks is never repeated.
    """
    if options.pytest or options.diff or (options.tables / "checks").is_dir():
        return ""
    chosen = {k: str(v) for k, v in vars(options).items() if k not in WITHOUT_EFFECT}
    installed = sorted(f"{found.name}=={found.version}" for found in distributions())
    machine = (sys.version, platform.machine(), installed, tiers()[0])
    packages = (Path(p) for name in PACKAGES for p in _folders(name))
    places = [Path(options.submissions), options.tables, *(options.root / s for s in SOURCES)]
    try:
        files = [[(str(f), *_state(f)) for f in _files(place)] for place in (*places, *packages)]
    except OSError:
        return ""
    return json_digest(chosen, machine, files)


def last_report(out: Path, inputs: str) -> Report | None:
    """Return the report of the last run, if neither its inputs nor its results have changed."""
    try:
        kept = json.loads((out / FILE).read_bytes())
        if not inputs or (kept["inputs"], kept["results"]) != (inputs, _results_digest(out)):
            return None
        report = kept["report"]
        return Report(report["status"], tuple(report["lines"]), tuple(report["warnings"]))
    except (OSError, ValueError, KeyError, TypeError):
        return None


def keep_report(out: Path, inputs: str, report: Report) -> None:
    """Keep the report of a run in which the grader did not fail."""
    if inputs:
        kept = {"inputs": inputs, "results": _results_digest(out), "report": asdict(report)}
        write_atomically(out / FILE, json.dumps(kept).encode(), sync=False)


def print_warnings(warnings: Iterable[str]) -> None:
    """Print each warning between two lines."""
    line = "!" * 72
    for text in warnings:
        print(f"{line}\n{text}\n{line}", file=sys.stderr)


def _results_digest(out: Path) -> str:
    """Return the digest of the results, and of the names of the received files."""
    received = sorted(file.name for file in (out / "received").glob("*/*"))
    return json_digest([file_digest(out / n) for n in RESULTS if (out / n).is_file()], received)


def _folders(package: str) -> list[str]:
    spec = find_spec(package)
    return [*(spec.submodule_search_locations or ())] if spec else []


def _files(place: Path) -> Iterator[Path]:
    """Yield the files of a folder, or a file; caches of Python are left out."""
    found = sorted(place.rglob("*")) if place.is_dir() else [place]
    yield from (file for file in found if file.suffix != ".pyc" and not file.is_dir())


def _state(file: Path) -> tuple[str, int]:
    """Return the digest of a file, and its time, which can be the time of receipt."""
    if not file.is_file() or file.is_symlink():
        return "", 0
    return file_digest(file), file.stat().st_mtime_ns
