"""How far grading is, and how long it will take: a bar on a terminal, else a line now and then."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    TimeElapsedColumn,
    TimeRemainingColumn,
)

from fieldrecon.reporting.terminal import Terminal

Told = Callable[[int, int], None]
SECONDS_BETWEEN_LINES = 10.0


@contextmanager
def progress(label: str) -> Iterator[Told]:
    """Give what is told how many are done, and of how many."""
    if not sys.stderr.isatty():
        yield _lines(label)
        return
    columns = (
        "{task.description}",
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        "about",
        TimeRemainingColumn(),
        "left",
    )
    with Progress(*columns, console=Terminal(file=sys.stderr), transient=True) as bar:
        task = bar.add_task(label, total=None)
        yield lambda done, of: bar.update(task, completed=done, total=of)


def _lines(label: str) -> Told:
    """Return what prints a line if the last one was some time ago."""
    started = last = time.monotonic()
    errors = sys.stderr  # pytest puts another in its place while it runs

    def told(done: int, of: int) -> None:
        nonlocal last
        now = time.monotonic()
        if now - last >= SECONDS_BETWEEN_LINES:
            last = now
            left = (now - started) * (of - done) / done
            print(f"{label} {done} of {of}, about {_in_words(left)} left", file=errors)

    return told


def _in_words(seconds: float) -> str:
    """Return a time as one would say it.

    Examples
    --------
    >>> _in_words(42.3), _in_words(90)
    ('42 seconds', '2 minutes')
    """
    return f"{seconds:.0f} seconds" if seconds < 90 else f"{seconds / 60:.0f} minutes"
