"""``manifest.json``: the inputs, versions and outputs of a finished build."""

from __future__ import annotations

import json
import platform
from collections.abc import Iterable, Mapping
from importlib.metadata import version
from pathlib import Path
from typing import Any

from fieldreport.build.pinned_kernels import pins
from fieldreport.build.step_records import digests

PACKAGES = ("fieldrecon", "numpy", "scipy", "matplotlib", "fonttools", "pypandoc_binary", "typst")


def versions() -> dict[str, str]:
    """Return the versions of Python and of the packages that make the report."""
    return {"python": platform.python_version()} | {name: version(name) for name in PACKAGES}


def machine() -> dict[str, str]:
    """Return the kind of machine: with equal pins and versions, equal kinds give equal bytes."""
    return {"system": platform.system(), "processor": platform.machine()}


def manifest(values: Mapping[str, Any], made: Iterable[Path], out: Path) -> bytes:
    """Return the manifest: versions, machine, pins, parameters, seeds, facts, digests of outputs.

    Parameters
    ----------
    values : mapping
        Facts and parameters by experiment.
    made : iterable of Path
        The outputs.
    out : Path
        The build folder; outputs are named by their path below it.
    """
    return _json(
        {
            "versions": versions(),
            "machine": machine(),
            "pins": pins(),
            "experiments": {name: _described(x) for name, x in sorted(values.items())},
            "sha256": digests(made, out),
        }
    )


def _described(experiment: Mapping[str, Any]) -> dict[str, Any]:
    params = experiment["params"]
    return {
        "params": params,
        "seeds": {name: x for name, x in params.items() if name.startswith("seed")},
        "facts": experiment["facts"],
    }


def _json(x: Any) -> bytes:
    return (json.dumps(x, indent=1, ensure_ascii=False) + "\n").encode()
