"""Mounts of the sandbox: a home of a fixed size, other files read-only, and no list of processes.

A user namespace and a mount namespace of the server make this possible without privileges. Some
systems forbid them, as AppArmor of Ubuntu and the default settings of Docker do; then the home is a
folder on the disk, and `fieldgrade.sandbox.homes` measures it.
"""

from __future__ import annotations

import os
import struct
from collections.abc import Iterable

from fieldgrade.sandbox.kernel import library_call, system_call

NEW_MOUNTS, NEW_USER = 0x00020000, 0x10000000
READ_ONLY, NO_SUID, NO_DEVICES, NO_PROGRAMS, RECURSIVE, PRIVATE = 1, 2, 4, 8, 1 << 14, 1 << 18
MOUNT_SETATTR, WHOLE_TREE = 442, 0x8000


def separate() -> None:
    """Give this process, which has a single thread, mounts of its own.

    Raises
    ------
    OSError
        The system forbids it.
    """
    user, group = os.getuid(), os.getgid()
    library_call("unshare", NEW_USER | NEW_MOUNTS)
    for name, text in (
        ("setgroups", "deny"),
        ("uid_map", f"{user} {user} 1"),
        ("gid_map", f"{group} {group} 1"),
    ):
        with open(f"/proc/self/{name}", "w", encoding="ascii") as file:  # noqa: PTH123
            file.write(text)
    library_call("mount", None, b"/", None, RECURSIVE | PRIVATE, None)


def close_off(home: str, size: int, entries: int) -> None:
    """Make all files read-only, hide the processes, and mount a home of `size` bytes in memory.

    Raises
    ------
    OSError
        The system forbids it.
    """
    read_only = struct.pack("QQQQ", READ_ONLY, 0, 0, 0)
    system_call(MOUNT_SETATTR, -1, b"/", WHOLE_TREE, read_only, len(read_only))
    _memory(home, NO_SUID | NO_DEVICES, f"size={size},nr_inodes={entries},mode=700")
    _memory("/proc", NO_SUID | NO_DEVICES | NO_PROGRAMS | READ_ONLY, "size=4k,mode=500")


def _memory(folder: str, flags: int, options: str) -> None:
    library_call("mount", b"tmpfs", os.fsencode(folder), b"tmpfs", flags, options.encode())


def are_allowed(home: str, needed: Iterable[str] = ()) -> bool:
    """Whether a child of this process can give itself such mounts, and read what is needed.

    In a user namespace even the superuser reads only what the rights of a file permit.
    """
    child = os.fork()
    if child == 0:
        failed = 1
        try:
            separate()
            close_off(home, 1 << 20, 16)
            failed = int(not all(os.access(path, os.R_OK | os.X_OK) for path in needed))
        finally:
            os._exit(failed)
    return os.waitpid(child, 0)[1] == 0
