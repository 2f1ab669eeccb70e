"""How many submissions the memory of the machine permits at once.

If the sandboxes together needed more memory than there is, the system would kill one of them,
perhaps that of a modest submission.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

from fieldgrade.isolation.server import MEBIBYTE, Limits
from fieldgrade.sandbox import homes

OF_A_WORKER = 512 * MEBIBYTE
"""Memory of a worker, of its sandbox server, and of its process for right functions."""
CONTROL_GROUPS = (
    ("memory.max", "anon"),
    ("memory/memory.limit_in_bytes", "total_rss"),
)
"""The limit of a container, and the entry of ``memory.stat`` that cannot be freed."""


def fitting_jobs(jobs: int, limits: Limits, root: Path = Path("/")) -> tuple[int, str]:
    """Return how many submissions can run at once, and a sentence if these are fewer than `jobs`.

    Parameters
    ----------
    jobs : int
        The requested number.
    limits : Limits
        The limits of a submission.
    root : Path
        The root folder of the system.
    """
    each = limits.memory + homes.HARD_LIMIT * homes.MOST_BYTES + OF_A_WORKER
    free = min(_free(root), default=jobs * each)
    fitting = max(1, min(jobs, free // each))
    amounts = f"{each / 2**30:.1f} GiB of memory, and {free / 2**30:.1f} GiB are free"
    if free < each:
        return 1, f"A submission may need {amounts}: some may have to be graded again."
    if fitting < jobs:
        once = "1 submission is" if fitting == 1 else f"{fitting} submissions are"
        return fitting, f"{once} graded at once, not {jobs}: each may need {amounts}."
    return jobs, ""


def _free(root: Path) -> Iterator[int]:
    """Yield the free memory of the machine and of its control group, in bytes; none elsewhere."""
    with suppress(OSError):
        yield 1024 * _entries(root / "proc/meminfo")["MemAvailable:"]
    for limit, entry in CONTROL_GROUPS:
        file = root / "sys/fs/cgroup" / limit
        with suppress(OSError, ValueError, KeyError):  # "max", or another version
            yield max(0, int(file.read_text()) - _entries(file.with_name("memory.stat"))[entry])


def _entries(file: Path) -> dict[str, int]:
    """Return the numbers in a file with a name and a number in each line."""
    lines = (line.split() for line in file.read_text().splitlines())
    return {words[0]: int(words[1]) for words in lines}
