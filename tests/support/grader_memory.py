"""The memory of a grader's own processes, measured from outside while it runs."""

import subprocess
import time
from pathlib import Path

SANDBOXED = (b"bwrap", b"/grading-")
"""Words in the command lines of sandboxes; their processes are not counted."""


def peak_memory(command, seconds_between=0.2):
    """Run a command; return its exit status and the largest sum of PSS, in bytes.

    The proportional set size counts a page that n processes share as 1/n page of each.
    """
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    peak = 0
    while process.poll() is None:
        peak = max(peak, sum(map(_pss, _own(process.pid))))
        time.sleep(seconds_between)
    return process.returncode, peak


def _own(root):
    """The processes below a process that belong to no sandbox."""
    children = {}
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            children.setdefault(_parent(entry.name), []).append(int(entry.name))
    found, todo = [], [root]
    while todo:
        one = todo.pop()
        if not any(word in _read(one, "cmdline") for word in SANDBOXED):
            found.append(one)
            todo += children.get(one, [])
    return found


def _parent(process):
    after_name = _read(process, "stat").rpartition(b")")[2].split()
    return int(after_name[1]) if after_name else 0


def _pss(process):
    lines = _read(process, "smaps_rollup").splitlines()
    return sum(int(line.split()[1]) << 10 for line in lines if line.startswith(b"Pss:"))


def _read(process, name):
    try:
        return Path(f"/proc/{process}/{name}").read_bytes()
    except OSError:
        return b""
