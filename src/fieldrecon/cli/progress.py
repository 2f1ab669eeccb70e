"""Progress bars: one line of standard error that is rewritten, on a terminal only."""

from __future__ import annotations

import shutil
import sys
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from types import TracebackType
from typing import Any, Self

from fieldrecon._core.memory import memory_used, peak_memory

_CELLS = 10
_SECONDS_BETWEEN = 0.1


class StatusLine:
    """The last line of a terminal, rewritten as work goes on; invisible without a terminal.

    It is a context manager; leaving its block erases the line.
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
        """Print a line that stays above this one, also without a terminal."""
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
    """A bar for one stage of the work, with the time that is left.

    Parameters
    ----------
    line : StatusLine
        Where the bar is shown.
    label : str
        The name of the stage, which is shown at once.
    """

    def __init__(self, line: StatusLine, label: str) -> None:
        self._line, self._label = line, label
        self._began = self._shown = time.monotonic()
        line.show(label)

    def __call__(self, done: int, total: int, note: str = "") -> None:
        """Show how many of the total are done, at most ten times a second."""
        now = time.monotonic()
        if done and now - self._shown >= _SECONDS_BETWEEN:
            self._shown = now
            left = in_words((now - self._began) * (total - done) / done)
            self._line.show(f"{self._label} {bar(done, total)}, about {left} left{note}")


class Bar(StatusLine):
    """A bar for a build, whose total grows as work is found."""

    def __init__(self) -> None:
        super().__init__()
        self._done = self._total = 0

    def add(self, count: int) -> None:
        """Increase the total."""
        self._total += count
        self._show_counts()

    def done(self, text: str) -> None:
        """Count a finished piece of work, and print a line about it."""
        self._done += 1
        self.say(text)

    def say(self, text: str) -> None:
        """Print a line above the bar."""
        super().say(text)
        self._show_counts()

    def _show_counts(self) -> None:
        if self._total:
            self.show(f"report {bar(self._done, self._total)}, {self._done} of {self._total}")


@contextmanager
def progress(
    mapping: Callable[..., Iterable[Any]], label: str
) -> Iterator[Callable[..., Iterator[Any]]]:
    """Wrap a function like `map`, so that a bar counts the finished items."""
    with StatusLine() as line:

        def counted(function: Any, items: Iterable[Any]) -> Iterator[Any]:
            items = list(items)
            show = Stage(line, label)
            for count, done in enumerate(mapping(function, items), 1):
                show(count, len(items))
                yield done

        yield counted


@contextmanager
def stages() -> Iterator[Callable[[str], Callable[[int, int], None]]]:
    """Give a function that opens a stage by its name, and returns its progress(done, total).

    The bar of a stage shows the time that is left and the memory that was used.
    """
    with StatusLine() as line:

        def stage(label: str) -> Callable[[int, int], None]:
            show = Stage(line, label)
            return lambda done, total: show(done, total, memory_used(peak_memory()))

        yield stage


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
    """Return a duration in words.

    Examples
    --------
    >>> in_words(42.3), in_words(90)
    ('42 seconds', '2 minutes')
    """
    return f"{seconds:.0f} seconds" if seconds < 90 else f"{seconds / 60:.0f} minutes"
