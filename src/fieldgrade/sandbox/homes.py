"""Home folders of sandboxed processes: measured while they run, and emptied afterwards."""

from __future__ import annotations

import os
import stat
from contextlib import suppress
from itertools import count
from secrets import token_hex

from fieldgrade.sandbox.kernel import open_folder, read_process

MOST_ENTRIES = 1000
MOST_BYTES = 64 << 20
"""Limits of a home: number of files and folders, and total bytes."""
HARD_LIMIT = 2
"""By this factor a home in memory is larger, so that a process that exceeds a limit is noticed."""


def is_in_memory(home: str) -> bool:
    """Whether a home is a file system of its own, which counts all that it holds."""
    with suppress(FileNotFoundError):
        system = os.statvfs(home)
        return system.f_blocks * system.f_frsize == HARD_LIMIT * MOST_BYTES
    return False


def is_overfull(home: str, process: int = 0, file_size: int = 0) -> bool:
    """Whether a home exceeds its limits or cannot be inspected.

    Parameters
    ----------
    home : str
        The home.
    process : int
        A process that may hold deleted files of the home.
    file_size : int
        The limit of a file, in bytes, which stands for the size of a deleted file in memory.
    """
    if not is_in_memory(home):
        return _tree_is_overfull(home, sum(_deleted(home, process, file_size).values()))
    system = os.statvfs(home)
    size = (system.f_blocks - system.f_bfree) * system.f_frsize
    return size > MOST_BYTES or system.f_files - system.f_ffree > MOST_ENTRIES


def lacking(home: str) -> str:
    """Return a sentence if the disk of a home has no room for its content; empty otherwise."""
    if is_in_memory(home):
        return ""
    try:
        system = os.statvfs(home)
    except OSError as error:
        return str(error)
    free = system.f_bavail * system.f_frsize
    if free >= MOST_BYTES:
        return ""
    return f"the disk of {home} is full: {free >> 20} MiB are free, {MOST_BYTES >> 20} are needed"


def _deleted(home: str, process: int, file_size: int) -> dict[int, int]:
    """Return the sizes of the deleted files that a process keeps open or mapped, by inode."""
    sizes: dict[int, int] = {}
    with suppress(OSError):
        for line in read_process(f"{process}/maps").splitlines():
            if line.endswith(" (deleted)") and home in line:
                sizes[int(line.split()[4])] = file_size
    with suppress(OSError):
        folder = open_folder(f"{process}/fd")
        try:
            for number in os.listdir(folder):  # noqa: PTH208
                with suppress(OSError):
                    file = os.stat(number, dir_fd=folder)
                    if stat.S_ISREG(file.st_mode) and not file.st_nlink:
                        sizes[file.st_ino] = 512 * file.st_blocks
        finally:
            os.close(folder)
    return sizes


def _tree_is_overfull(home: str, size: int) -> bool:
    folders, entries = [home], 0
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
    return size > MOST_BYTES


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
