"""Home folders of sandboxed processes: measured while they run, and emptied afterwards."""

from __future__ import annotations

import os
import stat
from contextlib import suppress
from itertools import count
from secrets import token_hex

MOST_ENTRIES = 1000
MOST_BYTES = 64 << 20
"""Limits of a home: number of files and folders, and total bytes."""


def is_overfull(home: str) -> bool:
    """Whether a home exceeds its limits or cannot be inspected."""
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
        except OSError:  # a path that is too long, a folder without permissions
            return True
    return False


def empty(folder: str) -> None:
    """Remove the content of a folder, whatever its depth, permissions and links.

    Inner folders are moved up before they are emptied, so that paths stay short and no recursion is
    needed. Links are not followed. Files that the system does not remove stay.
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
    """Remove a folder with its content."""
    empty(folder)
    with suppress(OSError):
        os.rmdir(folder)  # noqa: PTH106


def _emptied(folder: str, mark: str) -> list[str]:
    """Unlink the files of a folder, and return its inner folders that were not moved there."""
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
