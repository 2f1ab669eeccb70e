"""What the command line shows: a progress bar, how each method did, what is wrong with a mesh."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from fieldrecon._core.extras import PICTURES, absent, remedy
from fieldrecon._core.memory import memory_used, peak_memory
from fieldrecon.cli.console import print_table, say
from fieldrecon.cli.progress import Stage, StatusLine
from fieldrecon.pipelines.scan import Scan
from fieldrecon.pipelines.survey import Outcome
from fieldrecon.triangles.audit import MeshAudit, in_words

_FEW_PLACES = 3
_LONG_PLACE = 6


@contextmanager
def progress(
    mapping: Callable[..., Iterable[Any]], label: str
) -> Iterator[Callable[..., Iterator[Any]]]:
    """Give the map with a bar that tells, on a terminal, how many of its items are done."""
    with StatusLine() as line:

        def each(function: Any, items: Iterable[Any]) -> Iterator[Any]:
            items = list(items)
            show = Stage(line, label)
            for count, done in enumerate(mapping(function, items), 1):
                show(count, len(items))
                yield done

        yield each


@contextmanager
def stages() -> Iterator[Callable[[str], Callable[[int, int], None]]]:
    """Give what opens a stage of long work: a bar with the time left and the memory, on a terminal.

    What it returns is called as progress(done, total); until then only the name is shown.
    """
    with StatusLine() as line:

        def stage(label: str) -> Callable[[int, int], None]:
            show = Stage(line, label)
            return lambda done, total: show(done, total, memory_used(peak_memory()))

        yield stage


def print_outcome(outcome: Outcome) -> None:
    """Print how each method did, what was evaluated, and what a reader should beware of."""
    tried = [t for t in outcome.ranked if t.residuals is not None]
    rows = [(t.model.name, t.model.meaning, t.rms, t.largest) for t in tried]
    name, count = outcome.samples.names[-1], len(outcome.samples.points)
    if rows:
        title = f"{name} at {count} points: error when each of {outcome.judged} is left out"
        print_table(("method", "what it is", "rms error", "largest error"), rows, title=title)
    for t in outcome.trials:
        if t.residuals is None:
            say(f"{t.model.name}: {t.reason}.")
    for remark in outcome.remarks:
        say(remark)
    say(f"Evaluated: {outcome.method}.")
    say(f"{outcome.cost}.")


def print_audit(path: Path, audit: MeshAudit, done: dict[str, int] | None = None) -> None:
    """Print what was found in a mesh, and, of a repaired one, what was done."""
    parts = "1 part" if audit.parts == 1 else f"{audit.parts:,} parts"
    say(
        f"{path}: {audit.triangles:,} triangles in {parts}, {audit.vertices:,} "
        f"vertices; tolerance {audit.tolerance:.3g}."
    )
    if audit.soup:
        say("Each triangle has vertices of its own, as the format has it; equal ones count as one.")
    if done is not None:
        told = ", ".join(in_words(what, n) for what, n in done.items())
        say(f"Repaired: {told or 'nothing was to be done'}.")
    if audit.clean:
        say("Nothing is wrong: closed, oriented, without self-intersections.")
    else:
        columns = ("concerns", "found", "where, by index from 0")
        print_table(columns, _findings(audit))


def print_scan(path: Path, scan: Scan, remarks: Sequence[str], cost: str) -> None:
    """Print how far the points of a scan are from its surface, and what is to be known."""
    title = f"{path.name}: {scan.counted}, and how far they are from the mesh"
    print_table(("points", "distance"), tuple(scan.quality.items()), title=title)
    for remark in remarks:
        say(remark)
    say(f"{cost}.")


def _findings(audit: MeshAudit) -> list[tuple[str, str, str]]:
    """Return a row for each kind of error that was found: concern, how many, where."""
    return [
        (concern, in_words(kind, n), _where(getattr(audit, kind)))
        for concern, kinds in audit.counts.items()
        for kind, n in kinds.items()
        if n
    ]


def _where(found: Sequence[np.ndarray]) -> str:
    """Spell the first few of the places."""
    few = [_place(np.atleast_1d(place)) for place in found[:_FEW_PLACES]]
    return ", ".join([*few, "…"] if len(found) > _FEW_PLACES else few)


def _place(indices: np.ndarray) -> str:
    few = "-".join(map(str, indices[:_LONG_PLACE]))
    return f"{few}-…" if len(indices) > _LONG_PLACE else few


def print_json(content: dict[str, Any]) -> None:
    """Print a dictionary as JSON and nothing else."""
    print(json.dumps(content))


def print_missing_pictures() -> None:
    """Say on standard error what is to be installed for pictures, where something is."""
    if missing := absent(*PICTURES):
        print(f"fieldrecon: no picture was drawn: {remedy(*missing)}", file=sys.stderr)


def print_files(paths: Iterable[Path]) -> None:
    """Print the files that were written, one a line, so that another program can read them."""
    for path in paths:
        print(path)
