"""What the command line shows: tables, a progress bar, and how each method did on samples."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TimeElapsedColumn
from rich.table import Table

from fieldrecon.experiments import Experiment, Map
from fieldrecon.gridding import Grid, Trial
from fieldrecon.samples import Samples

_WIDEST = 7
_MOST_ROWS = 40


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


def print_trials(samples: Samples, grid: Grid, trials: list[Trial], chosen: Trial) -> None:
    """Print how each method did, what was drawn, and what a reader should beware of."""
    tried = sorted((t for t in trials if t.residuals is not None), key=lambda t: t.rms)
    rows = [(t.candidate.name, t.candidate.meaning, t.rms, t.largest) for t in tried]
    title = f"{samples.names[2]} at {len(samples.points)} points: error when each is left out"
    print_table(("method", "what it is", "rms error", "largest error"), rows, title=title)
    say = Terminal(highlight=False, markup=False).print
    for t in trials:
        if t.residuals is None:
            say(f"{t.candidate.name}: {t.reason}.")
    if samples.merged:
        say(f"{samples.merged} rows repeat a point; it bears the mean of its values.")
    if samples.in_degrees:
        say("The columns look like degrees but are taken as lengths; project them first.")
    say(f"Drawn: {chosen.candidate.name}, {chosen.candidate.meaning}.")
    say(
        f"{grid.extrapolated.sum()} of {grid.values.size} nodes lie outside the convex hull of "
        "the samples: extrapolated, and marked so in every file."
    )


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
