"""Restrict the own process: resource limits, capabilities, and the tie to its parent.

The kernel enforces the restrictions, also for threads, and they cannot be revoked. The order
matters, since a restriction can prevent later ones.
"""

from __future__ import annotations

import os
import platform
import resource
import struct
import sys
from collections.abc import Collection
from contextlib import suppress

from fieldgrade.sandbox.kernel import open_folder, process_control, read_process, system_call

DIE_WITH_PARENT, MAY_BE_LOOKED_INTO, ADOPT_ORPHANS = 1, 4, 36
MOST_FILES = 64


def limit(memory: int, cpu_seconds: int, file_size: int) -> None:
    """Limit memory, processor time, file size, open files and core dumps."""
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    resource.setrlimit(resource.RLIMIT_FSIZE, (file_size, file_size))
    resource.setrlimit(resource.RLIMIT_CPU, (cpu_seconds, cpu_seconds + 1))
    resource.setrlimit(resource.RLIMIT_NOFILE, (MOST_FILES, MOST_FILES))
    if sys.platform == "linux":  # macOS does not enforce it
        resource.setrlimit(resource.RLIMIT_AS, (memory, memory))


def address_space() -> int:
    """Return the bytes of address space in use, to which the limit is added."""
    if sys.platform != "linux":
        return 0
    return int(read_process("self/statm").split()[0]) * resource.getpagesize()


def close_all_but(kept: Collection[int]) -> None:
    """Close all open files except the three standard streams and those in `kept`."""
    folder = open_folder("self/fd") if sys.platform == "linux" else os.open("/dev/fd", os.O_RDONLY)
    for number in map(int, os.listdir(folder)):  # noqa: PTH208
        if number > 2 and number not in kept:
            with suppress(OSError):
                os.close(number)


def drop_capabilities() -> None:
    """Drop all capabilities, irrevocably; limits cannot be raised again.

    Raises
    ------
    OSError
        The kernel refuses.
    """
    version_3_of_this_process = struct.pack("Ii", 0x20080522, 0)
    number = 126 if platform.machine() == "x86_64" else 91
    system_call(number, version_3_of_this_process, bytes(24))


def die_with_parent(parent: int) -> None:
    """Let the kernel kill this process when its parent ends; exit if the parent has ended."""
    if sys.platform == "linux":
        process_control(DIE_WITH_PARENT, 9)
    if os.getppid() != parent:
        os._exit(1)


def adopt_orphans() -> None:
    """Become the parent of orphaned descendants (subreaper)."""
    if sys.platform == "linux":
        process_control(ADOPT_ORPHANS, 1)


def hide_memory(hidden: bool = True) -> None:
    """Forbid or permit other processes of the user to inspect this process and later children."""
    if sys.platform == "linux":
        process_control(MAY_BE_LOOKED_INTO, int(not hidden))
