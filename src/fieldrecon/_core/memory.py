"""Memory: how much this process may use, and its peak so far."""

from __future__ import annotations

import math
import os
import sys
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

CGROUPS = Path("/sys/fs/cgroup")
OWN_CGROUPS = Path("/proc/self/cgroup")


def memory_limit() -> float:
    """Bytes of memory that this process may use; infinite where the system does not report it.

    The limit is the memory of the machine, or of the container if that is less.
    """
    return min([_physical_memory(), *_cgroup_limits()])


def _physical_memory() -> float:
    """Bytes of memory of this machine; Windows has no ``sysconf``."""
    if not hasattr(os, "sysconf"):
        return math.inf
    return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")


def _cgroup_limits() -> Iterator[int]:
    """Yield the limits in bytes of the control groups of this process and of their parents.

    A line ``0::/a/b`` names a group of version 2, a line ``5:memory:/a/b`` one of version 1. In a
    container the path may be that of the host: its own limit then stands at the root.
    """
    groups = OWN_CGROUPS.read_text(encoding="utf-8") if OWN_CGROUPS.is_file() else ""
    for line in groups.splitlines():
        _, controllers, path = line.split(":", 2)
        if not controllers:
            root, file = CGROUPS, "memory.max"
        elif "memory" in controllers.split(","):
            root, file = CGROUPS / "memory", "memory.limit_in_bytes"
        else:
            continue
        own = root / path.lstrip("/")
        for group in (own, *own.parents):
            with suppress(OSError, ValueError):  # the group is the host's, or the limit "max"
                yield int((group / file).read_text(encoding="ascii"))


def peak_memory() -> int | None:
    """Peak memory of this process in bytes, or None on Windows."""
    try:
        import resource
    except ModuleNotFoundError:
        return None
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak if sys.platform == "darwin" else 1024 * peak


def memory_used(peak: int | None, of: str = "") -> str:
    """The memory as the end of a line that begins with a time; empty if it is not known."""
    return "" if peak is None else f", {peak / 1e9:.2f} GB{of}"
