"""What the command line shows: tables, a progress bar, and how each method did on samples."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.markup import escape
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    ProgressColumn,
    Task,
    TaskProgressColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)
from rich.table import Table
from rich.text import Text

from fieldrecon._memory import peak_memory
from fieldrecon.experiments import Experiment, Map
from fieldrecon.mesh_audit import MeshAudit, in_words
from fieldrecon.outcome import Outcome
from fieldrecon.scans import Scan

_WIDEST = 7
_MOST_ROWS = 40
_FEW_PLACES = 3
_LONG_PLACE = 6


class Terminal(Console):
    """A console that leaves it to the program what a closed pipe means."""

    def on_broken_pipe(self) -> None:
        """Pass it on."""
        raise BrokenPipeError


@contextmanager
def progress(mapping: Map, label: str) -> Iterator[Map]:
    """Give the map with a bar that tells, on a terminal, how many of its items are done."""
    columns = ("{task.description}", BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    on_terminal = sys.stderr.isatty()
    errors = Terminal(stderr=True)
    with Progress(*columns, console=errors, transient=True, disable=not on_terminal) as bar:

        def each(function: Any, items: Iterable[Any]) -> Iterator[Any]:
            items = list(items)
            task = bar.add_task(label, total=len(items))
            for done in mapping(function, items):
                bar.advance(task)
                yield done

        yield each


@contextmanager
def stages() -> Iterator[Callable[[str], Callable[[int, int], None]]]:
    """Give what opens a stage of long work: a bar with the time left and the memory, on a terminal.

    What it returns is called as progress(done, total); until then the bar only shows that it lives.
    """
    columns = (
        "{task.description}",
        BarColumn(20),
        TaskProgressColumn(),
        TimeRemainingColumn(),
        "left,",
        _Memory(),
    )
    errors = Terminal(stderr=True)
    with Progress(*columns, console=errors, transient=True, disable=not sys.stderr.isatty()) as bar:

        def stage(label: str) -> Callable[[int, int], None]:
            for earlier in bar.tasks:
                bar.update(earlier.id, visible=False)
            task = bar.add_task(label, total=None)
            return lambda done, total: bar.update(task, completed=done, total=total)

        yield stage


class _Memory(ProgressColumn):
    """The most memory that the program has held."""

    def render(self, _: Task) -> Text:
        peak = peak_memory()
        known = "" if peak is None else f"{peak / 1e9:.2f} GB"
        return Text(known, style="progress.data.speed")


def print_table(
    columns: Sequence[str], rows: Sequence[Sequence[Any]], title: str = "", whole: bool = False
) -> None:
    """Print a table; one with many columns lies on its side, so that it fits a terminal.

    Of a long one the first rows are shown, since a file has the others, unless it is to be whole.
    """
    most = max(len(rows), len(columns)) if whole else _MOST_ROWS
    texts = [[escape(_typed(cell)) for cell in row] for row in (columns, *rows)]
    if len(columns) > _WIDEST >= len(rows) or len(columns) > 2 * _WIDEST:
        texts = [list(column) for column in zip(*texts, strict=True)]
    table = Table(*texts[0], title=escape(title) or None, title_justify="left")
    for row in texts[1 : 1 + most]:
        table.add_row(*row)
    Terminal().print(table)
    if len(texts) - 1 > most:
        Terminal().print(f"… and {len(texts) - 1 - most} rows more, in the file")


def _typed(cell: Any) -> str:
    """Spell a value for the terminal; a list as it would be typed."""
    if isinstance(cell, float):
        return f"{cell:.4g}"
    return ",".join(map(_typed, cell)) if isinstance(cell, list | tuple) else str(cell)


def print_outcome(outcome: Outcome) -> None:
    """Print how each method did, what was evaluated, and what a reader should beware of."""
    tried = [t for t in outcome.ranked if t.residuals is not None]
    rows = [(t.candidate.name, t.candidate.meaning, t.rms, t.largest) for t in tried]
    name, count = outcome.samples.names[-1], len(outcome.samples.points)
    if rows:
        title = f"{name} at {count} points: error when each of {outcome.judged} is left out"
        print_table(("method", "what it is", "rms error", "largest error"), rows, title=title)
    say = Terminal(highlight=False, markup=False).print
    for t in outcome.trials:
        if t.residuals is None:
            say(f"{t.candidate.name}: {t.reason}.")
    for remark in outcome.remarks:
        say(remark)
    say(f"Drawn: {outcome.method}.")
    say(f"{outcome.cost}.")


def print_audit(path: Path, audit: MeshAudit, done: dict[str, int] | None = None) -> None:
    """Print what was found in a mesh, and, of a repaired one, what was done."""
    parts = "1 part" if audit.parts == 1 else f"{audit.parts:,} parts"
    say = Terminal(highlight=False, markup=False).print
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
    say = Terminal(highlight=False, markup=False).print
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


def print_experiment(experiment: Experiment) -> None:
    """Print what an experiment is about, and its parameters."""
    say = Terminal(highlight=False, markup=False).print
    say(f"{experiment.title}\n", style="bold")
    for paragraph in experiment.description.split("\n\n"):
        listed = "\n---" in paragraph
        say(paragraph if listed else " ".join(paragraph.split()), end="\n\n")
    rows = [
        (name, value, experiment.meanings[name])
        for name, value in asdict(experiment.defaults).items()
    ]
    print_table(("parameter", "default", "what it is"), rows)
    say(f"Figures: {', '.join(experiment.plots)}")


def print_files(paths: Iterable[Path]) -> None:
    """Print the files that were written, one a line, so that another program can read them."""
    for path in paths:
        print(path)
