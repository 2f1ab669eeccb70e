"""Is the report reproducible? The same bytes on one kind of machine, the same facts on all."""

from __future__ import annotations

import argparse
import json
import math
import os
import shutil
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from fieldrecon.reporting.failure import BuildError
from fieldrecon.reporting.steps import digests

RELATIVE_TOLERANCE = 1e-6
"""Of a fact for which ``tolerances.toml`` states none."""

SURROUNDINGS: tuple[Mapping[str, str], Mapping[str, str]] = (
    {
        "TZ": "Pacific/Kiritimati",
        "LC_ALL": "C",
        "PYTHONHASHSEED": "1",
        "OMP_NUM_THREADS": "1",
        "OPENBLAS_NUM_THREADS": "1",
    },
    {
        "TZ": "America/St_Johns",
        "LC_ALL": "C.UTF-8",
        "PYTHONHASHSEED": "2",
        "OMP_NUM_THREADS": "4",
        "OPENBLAS_NUM_THREADS": "4",
    },
)


def check(arguments: argparse.Namespace) -> int:
    """Build in two new folders, with other surroundings each time, and compare all bytes."""
    with tempfile.TemporaryDirectory() as first, tempfile.TemporaryDirectory() as second:
        built = [
            _build(
                arguments, Path(place, "folder " * depth, "report"), surroundings, jobs=depth + 1
            )
            for depth, (place, surroundings) in enumerate(
                zip((first, second), SURROUNDINGS, strict=True)
            )
        ]
        differences = different(*built)
        count = len(_outputs(built[0]))
    for name in differences:
        print(f"differs: {name}", file=sys.stderr)
    if differences:
        raise BuildError(f"{len(differences)} of {count} files differ between two builds")
    print(f"two builds gave the same {count} files, byte for byte")
    return 0


def different(first: Path, second: Path) -> list[str]:
    """List the outputs of two builds that are not the same bytes, or that only one has."""
    a, b = (digests(_outputs(folder), folder) for folder in (first, second))
    return sorted(name for name in a.keys() | b.keys() if a.get(name) != b.get(name))


def compare_facts(arguments: argparse.Namespace) -> int:
    """Compare the facts of the build with those of another manifest, within tolerances."""
    out = arguments.out or arguments.source / "build"
    ours, theirs = (
        json.loads(path.read_text(encoding="utf-8"))
        for path in (out / "manifest.json", arguments.against)
    )
    differences = list(deviations(ours, theirs, _tolerances(arguments.source)))
    for text in differences:
        print(f"differs: {text}", file=sys.stderr)
    if differences:
        raise BuildError(f"{len(differences)} facts differ from {arguments.against}")
    print(f"the facts are those of {arguments.against}, within the tolerances")
    return 0


def deviations(
    ours: Mapping[str, Any],
    theirs: Mapping[str, Any],
    tolerances: Mapping[str, Mapping[str, float]],
) -> Iterator[str]:
    """Yield a line for each parameter or fact in which two manifests differ.

    Whole numbers and texts are to be equal. A power of ten tells an order of magnitude and may be
    off by one order. Other numbers are to agree to a relative tolerance.
    """
    mine, other = ours["experiments"], theirs["experiments"]
    for name in sorted(mine.keys() | other.keys()):
        a, b = mine.get(name, {}), other.get(name, {})
        if a.get("params") != b.get("params"):
            yield f"{name}: the parameters {a.get('params')} and {b.get('params')}"
            continue
        facts = a["facts"].keys() | b["facts"].keys()
        for fact in sorted(facts):
            x, y = a["facts"].get(fact), b["facts"].get(fact)
            if not agree(x, y, tolerances.get(name, {}).get(fact, RELATIVE_TOLERANCE)):
                yield f"{name}.{fact}: {x} and {y}"


def agree(x: Any, y: Any, tolerance: float) -> bool:
    """Tell whether two facts are the same within a relative tolerance.

    Examples
    --------
    >>> agree(1e-15, 1e-16, 1e-6), agree(1.0000001, 1.0, 1e-6), agree(1.1, 1.0, 1e-6)
    (True, True, False)
    >>> agree(3, 4, 1e-6), agree("MLS", "MLS", 1e-6)
    (False, True)
    """
    if isinstance(x, float) and isinstance(y, int | float):
        if _is_order(x) and _is_order(float(y)):
            return abs(math.log10(x / y)) < 1.5
        return math.isclose(x, y, rel_tol=tolerance)
    return x == y


def _is_order(x: float) -> bool:
    return 0 < x < 1e-9 and math.isclose(x, 10.0 ** round(math.log10(x)))


def _tolerances(source: Path) -> dict[str, dict[str, float]]:
    path = source / "tolerances.toml"
    return tomllib.loads(path.read_text(encoding="utf-8")) if path.exists() else {}


def _build(
    arguments: argparse.Namespace, place: Path, surroundings: Mapping[str, str], jobs: int
) -> Path:
    """Build a copy of the text in a place of its own, in a process of its own."""
    shutil.copytree(arguments.source, place, ignore=shutil.ignore_patterns("build"))
    command = [sys.executable, "-m", "fieldrecon.reporting", f"--jobs={jobs}"]
    if arguments.experiments:
        command += ["--experiments", str(arguments.experiments.resolve())]
    run = subprocess.run(command, cwd=place.parent, env={**os.environ, **surroundings}, check=False)
    if run.returncode:
        raise BuildError("the build to be compared failed")
    return place / "build"


def _outputs(folder: Path) -> list[Path]:
    hidden = {".state", ".lock"}
    return [
        p for p in folder.rglob("*") if p.is_file() and p.relative_to(folder).parts[0] not in hidden
    ]
