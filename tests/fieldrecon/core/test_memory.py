"""The memory limit of a process: that of the machine or of its container, whichever is smaller."""

import re
import sys
from pathlib import Path

import pytest

from fieldrecon._core import memory as _memory
from fieldrecon._core.memory import memory_limit, memory_used, peak_memory

GIBIBYTE = 2**30


@pytest.fixture
def machine(tmp_path, monkeypatch):
    """A machine of 16 GiB whose control groups are folders of the test."""
    monkeypatch.setattr(_memory, "_physical_memory", lambda: 16 * GIBIBYTE)
    monkeypatch.setattr(_memory, "CGROUPS", tmp_path / "cgroup")
    monkeypatch.setattr(_memory, "OWN_CGROUPS", tmp_path / "own")

    def set_up(own, limits):
        if own is not None:
            (tmp_path / "own").write_text(own, encoding="utf-8")
        for name, limit in limits.items():
            file = tmp_path / "cgroup" / name
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(f"{limit}\n", encoding="utf-8")

    return set_up


@pytest.mark.parametrize(
    ("own", "limits", "least"),
    [
        ("0::/\n", {"memory.max": 2 * GIBIBYTE}, 2),
        ("0::/user/job\n", {"user/job/memory.max": "max", "user/memory.max": 3 * GIBIBYTE}, 3),
        ("0::/a\n", {"a/memory.max": 64 * GIBIBYTE}, 16),
        ("0::/a\n", {"a/memory.max": "max"}, 16),
        ("5:cpu,memory:/job\n0::/\n", {"memory/job/memory.limit_in_bytes": GIBIBYTE}, 1),
        ("5:memory:/host/4d2\n", {"memory/memory.limit_in_bytes": 4 * GIBIBYTE}, 4),
        ("5:memory:/\n", {"memory/memory.limit_in_bytes": 2**63 - 4096}, 16),
        ("5:cpu:/job\n", {"memory/job/memory.limit_in_bytes": GIBIBYTE}, 16),
    ],
    ids=[
        "container",
        "limit of the parent",
        "more than the machine has",
        "no limit",
        "version 1",
        "version 1, path of the host",
        "version 1, no limit",
        "version 1, another group's",
    ],
)
def test_the_limit_is_the_minimum_over_machine_and_containers(machine, own, limits, least):
    """Control groups of version 1 and 2 are read, including their parents."""
    machine(own, limits)
    assert memory_limit() == least * GIBIBYTE


def test_without_control_groups_the_limit_is_the_memory_of_the_machine(machine):
    """This is the case on macOS."""
    machine(None, {})
    assert memory_limit() == 16 * GIBIBYTE


def test_the_limit_of_this_machine_is_plausible():
    """The limit lies between a quarter of a gibibyte and an exbibyte."""
    assert 2**28 < memory_limit() < 2**60


@pytest.mark.skipif(sys.platform != "linux", reason="the system has no such file")
def test_the_peak_is_not_less_than_that_of_the_resident_memory():
    """It may be greater: it is inherited from the program that started this one. The two are
    counted in pages, and not at the same time.
    """
    status = Path("/proc/self/status").read_text(encoding="ascii")
    resident = 1024 * int(re.search(r"VmHWM:\s+(\d+) kB", status)[1])
    assert 0.99 * resident <= peak_memory() < memory_limit()


@pytest.mark.skipif(sys.platform != "linux", reason="other systems count in other units")
def test_the_peak_is_that_which_the_system_reports_in_kibibytes():
    """It may grow from one report to the next."""
    resource = pytest.importorskip("resource")
    before, peak, after = (
        1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss,
        peak_memory(),
        1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss,
    )
    assert before <= peak <= after


def test_memory_is_told_in_gigabytes_if_it_is_known():
    assert memory_used(2_345_678_900) == ", 2.35 GB"
    assert memory_used(0, " of memory") == ", 0.00 GB of memory"
    assert memory_used(None, " of memory") == ""
