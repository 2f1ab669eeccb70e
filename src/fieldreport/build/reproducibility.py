"""Reproducibility checks: equal bytes on one kind of machine, equal facts on all.

With equal versions of Python, NumPy and SciPy, all x86-64 Linux machines with AVX2 are of one kind.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator, Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from fieldrecon._core.simd_dispatch import dispatch
from fieldreport import experiments
from fieldreport.build.errors import BuildError
from fieldreport.build.pinned_kernels import pins
from fieldreport.build.source_date import source_date
from fieldreport.build.step_records import digests

LEVEL_OF_ROUNDING = 1e-8
"""Orders of magnitude below this are rounding errors."""

NEGLIGIBLE = 1e-17
"""Zero errors are replaced by this: on another machine they may be one rounding error."""

SURROUNDINGS: Mapping[str, str] = {
    "TZ": "Pacific/Kiritimati",
    "LC_ALL": "C",
    "PYTHONHASHSEED": "1",
    "OMP_NUM_THREADS": "4",
    "OPENBLAS_NUM_THREADS": "4",
}


def other_surroundings(caller: Mapping[str, str]) -> dict[str, str]:
    """Return variables with which a build would give other bytes without the pins.

    They are Prescott's kernels, and NumPy without its dispatch; or Haswell's, and all of NumPy's
    dispatch, if the caller has requested the former. Time zone, locale, order of hashes, and number
    of threads are others, too.
    """
    if not pins():
        return dict(SURROUNDINGS)
    if caller.get("OPENBLAS_CORETYPE") == "Prescott":
        return {**SURROUNDINGS, "OPENBLAS_CORETYPE": "Haswell", "NPY_DISABLE_CPU_FEATURES": ""}
    return {
        **SURROUNDINGS,
        "OPENBLAS_CORETYPE": "Prescott",
        "NPY_DISABLE_CPU_FEATURES": " ".join(dispatch()),
    }


def check(arguments: argparse.Namespace) -> int:
    """Build again in a new folder, in other surroundings, and compare all bytes with the report."""
    ours = arguments.out or arguments.source / "build"
    print("building again, in other surroundings", file=sys.stderr)
    with tempfile.TemporaryDirectory() as new:
        theirs = _build(arguments, Path(new, "folder ", "report"), other_surroundings(os.environ))
        differences = different(ours, theirs)
    for name in differences:
        print(f"differs: {name}", file=sys.stderr)
    count = len(_outputs(ours))
    if differences:
        raise BuildError(f"{len(differences)} of {count} files differ from those of a new build")
    print(f"a new build in other surroundings gave the same {count} files, byte for byte")
    return 0


def different(first: Path, second: Path) -> list[str]:
    """List the outputs that differ between two builds or exist in only one."""
    a, b = (digests(_outputs(folder), folder) for folder in (first, second))
    return sorted(name for name in a.keys() | b.keys() if a.get(name) != b.get(name))


def compare_facts(arguments: argparse.Namespace) -> int:
    """Compare the facts of the build with those of another manifest, to the stated digits."""
    out = arguments.out or arguments.source / "build"
    ours, theirs = (
        json.loads(path.read_text(encoding="utf-8"))
        for path in (out / "manifest.json", arguments.against)
    )
    differences = list(deviations(ours, theirs, _digits_of))
    for text in differences:
        print(f"differs: {text}", file=sys.stderr)
    if differences:
        raise BuildError(f"{len(differences)} facts differ from {arguments.against}")
    print(f"the facts are those of {arguments.against}, to the digits that the experiments state")
    return 0


def _digits_of(experiment: str) -> Callable[[str], int]:
    return experiments.get(experiment).digits


def deviations(
    ours: Mapping[str, Any],
    theirs: Mapping[str, Any],
    digits_of: Callable[[str], Callable[[str], int]],
) -> Iterator[str]:
    """Yield a line for each parameter or fact in which two manifests differ.

    Integers and texts must be equal. Other numbers must agree to one unit in their last digit;
    `digits_of` returns the number of digits by experiment, then by fact.
    """
    mine, other = ours["experiments"], theirs["experiments"]
    for name in sorted(mine.keys() | other.keys()):
        a, b = mine.get(name, {}), other.get(name, {})
        if a.get("params") != b.get("params"):
            yield f"{name}: the parameters {a.get('params')} and {b.get('params')}"
            continue
        digits = digits_of(name)
        facts = a["facts"].keys() | b["facts"].keys()
        for fact in sorted(facts):
            x, y = a["facts"].get(fact), b["facts"].get(fact)
            if not agree(x, y, digits(fact)):
                yield f"{name}.{fact}: {x} and {y}"


def agree(x: Any, y: Any, digits: int) -> bool:
    """Whether two facts differ by at most one unit in their last digit.

    Two orders of magnitude may differ by a factor of ten, since both values may be near a boundary.

    Examples
    --------
    >>> agree(1.00001, 1.0, digits=6), agree(1.00002, 1.0, digits=6)
    (True, False)
    >>> agree(1e-15, 1e-16, digits=6), agree(0.01, 0.001, digits=0), agree(0.01, 0.001, digits=6)
    (True, True, False)
    >>> agree(3, 4, digits=6), agree("MLS", "MLS", digits=6)
    (False, True)
    """
    if not (isinstance(x, float) and isinstance(y, int | float)):
        return bool(x == y)
    if digits == 0 or _is_rounding(x) or _is_rounding(y):
        return _decades(x, y) < 1.5
    return math.isclose(x, y, rel_tol=10.0 ** (1 - digits))


def _is_rounding(x: float) -> bool:
    return x == 0 or (0 < x < LEVEL_OF_ROUNDING and math.isclose(x, 10.0 ** round(math.log10(x))))


def _decades(x: float, y: float) -> float:
    return abs(math.log10(max(abs(x), NEGLIGIBLE) / max(abs(y), NEGLIGIBLE)))


def _build(arguments: argparse.Namespace, place: Path, surroundings: Mapping[str, str]) -> Path:
    """Build a copy of the text in a separate folder and process."""
    shutil.copytree(arguments.source, place, ignore=shutil.ignore_patterns("build"))
    command = [sys.executable, "-m", "fieldreport", f"--jobs={arguments.jobs}"]
    if arguments.experiments:
        command += ["--experiments", str(arguments.experiments.resolve())]
    environment = {**os.environ, **date_of(arguments.source), **surroundings}
    if subprocess.run(command, cwd=place.parent, env=environment, check=False).returncode:
        raise BuildError("the new build failed")
    return place / "build"


def date_of(source: Path) -> dict[str, str]:
    """Return the variable that gives a copy, which is no checkout, the date of the sources."""
    date = source_date(source)
    if not date:
        return {}
    midnight = datetime.fromisoformat(date).replace(tzinfo=UTC)
    return {"SOURCE_DATE_EPOCH": f"{midnight.timestamp():.0f}"}


def _outputs(build: Path) -> list[Path]:
    """List the manifest and the files that it names, if they exist."""
    manifest = build / "manifest.json"
    named = json.loads(manifest.read_text(encoding="utf-8"))["sha256"]
    return [manifest, *filter(Path.exists, (build / name for name in named))]
