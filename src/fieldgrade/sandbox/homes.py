"""Folders in which students' code has run: measured, and emptied whatever is in them."""

from __future__ import annotations

import os
import stat
from contextlib import suppress
from itertools import count
from secrets import token_hex

MOST_ENTRIES = 1000
MOST_BYTES = 64 << 20
"""Files and folders in a home, and bytes of all of them together."""


def is_overfull(home: str) -> bool:
    """Whether there is more in a home than there may be, or what cannot be looked into."""
    folders, entries, size = [home], 0, 0
    while folders:
        try:
            with os.scandir(folders.pop()) as inside:
                for entry in inside:
                    entries += 1
                    with suppress(FileNotFoundError):
                        size += 512 * entry.stat(follow_symlinks=False).st_blocks
                        if entry.is_dir(follow_symlinks=False):
                            folders.append(entry.path)
                    if entries > MOST_ENTRIES or size > MOST_BYTES:
                        return True
        except FileNotFoundError:
            continue
        except OSError:  # a path that is too long, a folder that is closed
            return True
    return False


def empty(folder: str) -> None:
    """Remove all that is in a folder, however deep, closed or full of links it is.

    Folders inside are moved up before they are emptied, so that no path grows long and nothing
    here is recursive. Links are not followed. What the system does not let go stays.
    """
    mark, numbers, folders = token_hex(8), count(), [folder]
    while folders:
        moved = []
        for path in _emptied(folders[-1], mark):
            with suppress(OSError):
                os.chmod(path, stat.S_IRWXU)  # noqa: PTH101
                os.rename(path, name := f"{folder}/{mark}{next(numbers)}")  # noqa: PTH104
                moved.append(name)
        if not moved:
            done = folders.pop()
            if folders:
                with suppress(OSError):
                    os.rmdir(done)  # noqa: PTH106
        folders += moved


def remove(folder: str) -> None:
    """Remove a folder and all that is in it."""
    empty(folder)
    with suppress(OSError):
        os.rmdir(folder)  # noqa: PTH106


def _emptied(folder: str, mark: str) -> list[str]:
    """Unlink the files of a folder, and return the folders in it that were not moved there."""
    inside = []
    with suppress(OSError):
        os.chmod(folder, stat.S_IRWXU)  # noqa: PTH101
        for entry in list(os.scandir(folder)):
            if not entry.is_dir(follow_symlinks=False):
                with suppress(OSError):
                    os.unlink(entry.path)  # noqa: PTH108
            elif not entry.name.startswith(mark):
                inside.append(entry.path)
    return inside
