"""A fast check whether anything changed since the last complete build, from files alone.

A build would have to import all experiments to find that nothing changed. This check compares the
contents of all files that a build reads, including comments, and of all files that it wrote. If one
differs, the steps of the build decide what must be rerun.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path

import fieldrecon
import fieldreport
from fieldrecon._core.digests import json_digest
from fieldreport import experiments
from fieldreport.build.lock import only_build_in
from fieldreport.build.manifest import machine
from fieldreport.build.pinned_kernels import pins
from fieldreport.build.source_date import source_date
from fieldreport.build.step_records import Steps, content_digest
from fieldreport.build.typesetting import Document

STEP = "build"
HIDDEN = {".state", ".lock"}


def is_up_to_date(arguments: argparse.Namespace) -> bool:
    """Whether the report is up to date; if so, print this."""
    out = out_folder(arguments)
    if not out.is_dir():
        return False
    with only_build_in(out, _say):
        steps = Steps(out)
        done = steps.done(STEP, key(arguments)) and steps.made(STEP) == set(_outputs(out))
    if done:
        _say(f"{out / 'report.html'} and {out / 'report.pdf'} are up to date")
    return done


def key(arguments: argparse.Namespace) -> str:
    """Return the digest of what a build depends on, except input files of experiments."""
    source = arguments.source
    text = Document(source, out_folder(arguments)).inputs
    files = [settings_file(arguments), *text, *_code()]
    return json_digest(
        {
            "files": {str(path): content_digest(path) for path in sorted(files)},
            "packages": sorted(_packages()),
            "python": sys.version,
            "machine": machine(),
            "pins": pins(),
            "date": source_date(source),
        }
    )


def record(steps: Steps, key: str, read: Mapping[Path, str]) -> None:
    """Record the complete build; `read` are the digests of the input files of experiments."""
    steps.record(STEP, key, _outputs(steps.out), read)


def out_folder(arguments: argparse.Namespace) -> Path:
    """Return the build folder."""
    out: Path = arguments.out or arguments.source / "build"
    return out


def settings_file(arguments: argparse.Namespace) -> Path:
    """Return the file of the parameters that differ from the defaults."""
    path: Path = arguments.experiments or arguments.source / "experiments.toml"
    return path


def _code() -> Iterator[Path]:
    """Yield every module that a build may import, including experiments in other folders."""
    for folder in {*fieldrecon.__path__, *fieldreport.__path__, *experiments.__path__}:
        yield from Path(folder).rglob("*.py")


def _packages() -> Iterator[str]:
    """Yield the names of the metadata folders of installed packages, which contain the versions."""
    for folder in map(Path, sys.path):
        yield from (str(path) for path in folder.glob("*.*-info"))


def _outputs(out: Path) -> list[Path]:
    """List all files in the build folder, except locks and records."""
    return [
        path
        for path in sorted(out.rglob("*"))
        if path.is_file() and path.relative_to(out).parts[0] not in HIDDEN
    ]


def _say(text: str) -> None:
    print(text, file=sys.stderr)
