"""The number of concurrent submissions fits into the memory of the machine."""

import pytest

from fieldgrade.isolation.memory import fitting_jobs
from fieldgrade.isolation.server import Limits

GIBIBYTE = 1 << 30
EACH = 1.625
"""GiB: 1 for a submission, 1/8 for its files, 1/2 for the worker and its helpers."""


def machine(root, free, limit="max", used=0.0):
    """A folder with the files in which Linux reports memory; numbers are in GiB."""
    bytes_of = {"free": int(free * GIBIBYTE), "used": int(used * GIBIBYTE)}
    limit = limit if limit == "max" else str(int(limit * GIBIBYTE))
    for name, text in {
        "proc/meminfo": f"MemTotal: 1 kB\nMemAvailable: {bytes_of['free'] // 1024} kB\n",
        "sys/fs/cgroup/memory.max": f"{limit}\n",
        "sys/fs/cgroup/memory.stat": f"anon {bytes_of['used']}\nfile 99\n",
    }.items():
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text(text)
    return root


@pytest.mark.parametrize(
    ("jobs", "memory", "expected"),
    [
        (4, {"free": 4 * EACH}, 4),
        (4, {"free": 4 * EACH - 0.01}, 3),
        (4, {"free": 64, "limit": 2.5 * EACH}, 2),
        (4, {"free": 64, "limit": 4 * EACH, "used": EACH}, 3),
        (4, {"free": 0.1}, 1),
        (1, {"free": 64}, 1),
    ],
)
def test_as_many_submissions_run_at_once_as_fit_into_memory(tmp_path, jobs, memory, expected):
    """The smaller of the free memory of the machine and that of its container is used."""
    found, sentence = fitting_jobs(jobs, Limits(), machine(tmp_path, **memory))
    assert found == expected
    assert bool(sentence) == (found < jobs)
    assert ("graded again" in sentence) == (memory["free"] < EACH)


def test_the_sentence_states_both_amounts_of_memory(tmp_path):
    _, sentence = fitting_jobs(8, Limits(), machine(tmp_path, 4.0))
    assert sentence == (
        "2 submissions are graded at once, not 8: each may need 1.6 GiB of memory, "
        "and 4.0 GiB are free."
    )


def test_an_unknown_amount_of_memory_is_no_reason_to_run_fewer(tmp_path):
    """On other systems the files do not exist."""
    assert fitting_jobs(8, Limits(), tmp_path) == (8, "")
