"""Progress of a build: a bar on a terminal, plain lines elsewhere."""

from __future__ import annotations

import sys
from types import TracebackType

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn


class Bar:
    """A progress bar whose total grows as work is found, on standard error.

    Parameters
    ----------
    quiet : bool
        Tell nothing but what ``say`` is asked to.
    """

    def __init__(self, quiet: bool = False) -> None:
        self._console = Console(stderr=True, highlight=False)
        self._progress = Progress(
            TextColumn("{task.description}"),
            BarColumn(),
            MofNCompleteColumn(),
            TimeElapsedColumn(),
            console=self._console,
            transient=True,
            disable=quiet or not sys.stderr.isatty(),
        )
        self._quiet = quiet
        self._task = self._progress.add_task("report", total=0)

    def __enter__(self) -> Bar:
        self._progress.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._progress.stop()

    def add(self, count: int) -> None:
        """Count more work to be done."""
        task = self._progress.tasks[0]
        self._progress.update(self._task, total=(task.total or 0) + count)

    def done(self, text: str) -> None:
        """Tell that a piece of work is done."""
        self._progress.advance(self._task)
        if not self._quiet:
            self.say(text)

    def say(self, text: str) -> None:
        """Print a line above the bar."""
        self._console.print(text, markup=False, soft_wrap=True)
