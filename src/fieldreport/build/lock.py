"""A lock that allows one build at a time in a folder."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def only_build_in(folder: Path, say: Callable[[str], None]) -> Iterator[None]:
    """Hold the lock of the folder inside the ``with``; report and wait for another build.

    The system releases the lock when the process ends, even if it is killed.

    Raises
    ------
    OSError
        If the system has no such locks.
    """
    try:
        import fcntl
    except ModuleNotFoundError:
        raise OSError(
            "the report is built on Linux and macOS; Windows has no fcntl.flock"
        ) from None
    folder.mkdir(parents=True, exist_ok=True)
    with (folder / ".lock").open("a") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            say(f"another build is at work in {folder}; waiting for it to end")
            fcntl.flock(file, fcntl.LOCK_EX)
        yield
