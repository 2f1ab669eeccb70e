"""Folders of sandbox servers, and the removal of those that a killed grader left behind.

The process that owns a folder holds a lock on a file in it. The system releases the lock when the
process ends, however it ends.
"""

from __future__ import annotations

import fcntl
import os
import stat
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

from fieldgrade.sandbox import homes

PREFIX, LOCK = "grading-", "owner.lock"


@dataclass(frozen=True)
class Scratch:
    """A folder for the files of a server, and the descriptor of its lock."""

    folder: Path
    lock: int

    @classmethod
    def create(cls) -> Scratch:
        """Create a folder that belongs to this process."""
        folder = Path(tempfile.mkdtemp(prefix=PREFIX))
        new = folder / "new.lock"
        lock = os.open(new, os.O_RDWR | os.O_CREAT | os.O_EXCL, 0o600)
        with suppress(OSError):  # some file systems have no locks; then the folder is never removed
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            new.rename(folder / LOCK)  # whoever sees this name finds it locked
        return cls(folder, lock)

    def remove(self) -> None:
        """Remove the folder."""
        homes.remove(str(self.folder))
        os.close(self.lock)


def remove_abandoned() -> None:
    """Remove the folders of this user in the temporary folder whose owners have ended."""
    for folder in Path(tempfile.gettempdir()).glob(f"{PREFIX}*"):
        with _if_abandoned(folder) as abandoned:
            if abandoned:
                homes.remove(str(folder))


@contextmanager
def _if_abandoned(folder: Path) -> Iterator[bool]:
    """Give whether a folder is ours and has no owner; it is locked in the meantime."""
    lock = -1
    try:
        found = folder.lstat()
        ours = stat.S_ISDIR(found.st_mode) and found.st_uid == os.getuid()
        if ours and stat.S_IMODE(found.st_mode) == stat.S_IRWXU:
            lock = os.open(folder / LOCK, os.O_RDWR | os.O_NOFOLLOW)
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        else:
            ours = False
    except OSError:
        ours = False
    try:
        yield ours
    finally:
        if lock >= 0:
            os.close(lock)
