"""How far grading is, and how long it will take: a bar on a terminal, else a line now and then."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from fieldrecon.cli.progress import Stage, StatusLine, in_words

Told = Callable[[int, int], None]
SECONDS_BETWEEN_LINES = 10.0


@contextmanager
def progress(label: str) -> Iterator[Told]:
    """Give what is told how many are done, and of how many."""
    with StatusLine() as line:
        yield Stage(line, label) if line.on_terminal else _lines(line, label)


def _lines(line: StatusLine, label: str) -> Told:
    """Return what prints a line if the last one was some time ago."""
    started = last = time.monotonic()

    def told(done: int, of: int) -> None:
        nonlocal last
        now = time.monotonic()
        if now - last >= SECONDS_BETWEEN_LINES:
            last = now
            left = (now - started) * (of - done) / done
            line.say(f"{label} {done} of {of}, about {in_words(left)} left")

    return told
