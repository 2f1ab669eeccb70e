"""Landlock: restrict access to files, and forbid TCP ports, abstract sockets and signals.

Landlock does not control permissions and times of files, nor, before its third version, truncation;
`fieldgrade.sandbox.seccomp` refuses these calls.
"""

from __future__ import annotations

import os
import struct
import sys
from collections.abc import Iterable

from fieldgrade.sandbox.kernel import no_new_privileges, system_call

CREATE_RULESET, ADD_RULE, RESTRICT_SELF = 444, 445, 446
BELOW_A_PATH = 1

# Rights on files, one bit each; later versions have more of them.
EXECUTE, WRITE_FILE, READ_FILE, READ_DIR = 1, 2, 4, 8
RIGHTS_BY_VERSION = {1: 13, 2: 14, 3: 15, 4: 15, 5: 16}
"""The number of file rights in each version."""


def version() -> int:
    """Return the version of Landlock in the kernel; 0 if there is none."""
    if sys.platform != "linux":
        return 0
    try:
        return system_call(CREATE_RULESET, None, 0, 1)
    except OSError:
        return 0


def ruleset(readable: Iterable[str], listed: Iterable[str], writable: Iterable[str]) -> int:
    """Return a ruleset as a file descriptor, for processes that are started later.

    Parameters
    ----------
    readable : iterable of str
        Files and folders (with content) that may be read.
    listed : iterable of str
        Folders whose entries may be listed.
    writable : iterable of str
        Folders in which everything is allowed.

    Raises
    ------
    OSError
        The kernel refuses.
    """
    known = version()
    everything = (1 << RIGHTS_BY_VERSION[min(known, max(RIGHTS_BY_VERSION))]) - 1
    fields = [everything]
    if known >= 4:
        fields.append(3)  # to bind and to connect by TCP
    if known >= 6:
        fields.append(3)  # abstract sockets, and signals to processes outside
    attributes = struct.pack(f"{len(fields)}Q", *fields)
    made = system_call(CREATE_RULESET, attributes, len(attributes), 0)
    read = EXECUTE | READ_FILE | READ_DIR
    for paths, rights in ((readable, read), (listed, READ_DIR), (writable, everything)):
        for path in paths:
            _allow(made, path, rights)
    return made


def _allow(ruleset: int, path: str, rights: int) -> None:
    try:
        descriptor = os.open(path, os.O_PATH | os.O_CLOEXEC)
    except FileNotFoundError:
        return
    if not os.path.isdir(path):  # noqa: PTH112
        rights &= EXECUTE | WRITE_FILE | READ_FILE
    try:
        system_call(ADD_RULE, ruleset, BELOW_A_PATH, struct.pack("=Qi", rights, descriptor), 0)
    finally:
        os.close(descriptor)


def restrict(ruleset: int) -> None:
    """Apply a ruleset to this process, irrevocably.

    Raises
    ------
    OSError
        The kernel refuses.
    """
    no_new_privileges()
    system_call(RESTRICT_SELF, ruleset, 0)
