"""Progress of long work: one line of standard error that is rewritten, on a terminal only."""

from __future__ import annotations

import shutil
import sys
import time
from types import TracebackType
from typing import Self

_CELLS = 10
_SECONDS_BETWEEN = 0.1


class StatusLine:
    """The last line of a terminal, rewritten as work goes on; nothing where there is no terminal.

    The end of its block erases it.
    """

    def __init__(self) -> None:
        self._stream = sys.stderr
        self.on_terminal = self._stream.isatty()
        self._length = 0

    def show(self, text: str) -> None:
        """Replace the line."""
        if self.on_terminal:
            text = text[: shutil.get_terminal_size().columns - 1]
            self._stream.write(f"\r{' ' * self._length}\r{text}")
            self._stream.flush()
            self._length = len(text)

    def say(self, text: str) -> None:
        """Print a line that stays, in place of this one; also where there is no terminal."""
        self.show("")
        print(text, file=self._stream, flush=True)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.show("")


class Stage:
    """How much of one stage of the work is done, and how long the rest will take.

    Parameters
    ----------
    line : StatusLine
        Where it is shown.
    label : str
        The work.
    """

    def __init__(self, line: StatusLine, label: str) -> None:
        self._line, self._label = line, label
        self._began = self._shown = time.monotonic()
        line.show(label)

    def __call__(self, done: int, total: int, note: str = "") -> None:
        """Show how many are done, of how many, ten times a second at most."""
        now = time.monotonic()
        if done and now - self._shown >= _SECONDS_BETWEEN:
            self._shown = now
            left = in_words((now - self._began) * (total - done) / done)
            self._line.show(f"{self._label} {bar(done, total)}, about {left} left{note}")


class Bar(StatusLine):
    """Progress of a build, whose total grows as work is found."""

    def __init__(self) -> None:
        super().__init__()
        self._done = self._total = 0

    def add(self, count: int) -> None:
        """Count more work to be done."""
        self._total += count
        self._show_counts()

    def done(self, text: str) -> None:
        """Report that a piece of work is done."""
        self._done += 1
        self.say(text)

    def say(self, text: str) -> None:
        """Print a line above the bar."""
        super().say(text)
        self._show_counts()

    def _show_counts(self) -> None:
        if self._total:
            self.show(f"report {bar(self._done, self._total)}, {self._done} of {self._total}")


def bar(done: int, total: int) -> str:
    """Draw the share that is done.

    Examples
    --------
    >>> bar(1, 2)
    '[#####-----]  50 %'
    """
    full = round(_CELLS * done / total)
    return f"[{'#' * full}{'-' * (_CELLS - full)}] {100 * done / total:3.0f} %"


def in_words(seconds: float) -> str:
    """Return a time as one would say it.

    Examples
    --------
    >>> in_words(42.3), in_words(90)
    ('42 seconds', '2 minutes')
    """
    return f"{seconds:.0f} seconds" if seconds < 90 else f"{seconds / 60:.0f} minutes"
