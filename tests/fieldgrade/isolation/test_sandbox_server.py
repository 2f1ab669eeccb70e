"""Tiers: what a machine offers is used, the safest first, and nothing is offered that is not."""

import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path

import pytest

from fieldgrade.isolation import server as server_module
from fieldgrade.sandbox import homes, landlock, seccomp


@pytest.mark.parametrize(
    ("locks", "bubblewrap", "version", "expected"),
    [
        (True, True, 7, ("bubblewrap", "landlock", "none")),
        (True, False, 1, ("landlock", "none")),
        (True, True, 0, ("bubblewrap", "none")),
        (True, False, 0, ("none",)),
        (False, True, 7, ("none",)),
    ],
)
def test_the_safest_comes_first(locks, bubblewrap, version, expected, monkeypatch):
    """Both kinds of walls need the filter of calls, without which processes are not counted."""
    monkeypatch.setattr(seccomp, "is_known", lambda: locks)
    monkeypatch.setattr(server_module.file_access, "bubblewrap_works", lambda: bubblewrap)
    monkeypatch.setattr(landlock, "version", lambda: version)
    assert server_module.tiers() == expected


def test_other_systems_have_no_bubblewrap_command(monkeypatch):
    """On macOS, as on machines whose calls are not known, only the last tier is left."""
    monkeypatch.setattr(seccomp.sys, "platform", "darwin")
    assert not seccomp.is_known()
    assert landlock.version() == 0
    assert server_module.tiers() == ("none",)
    monkeypatch.undo()
    monkeypatch.setattr(seccomp.platform, "machine", lambda: "riscv64")
    assert server_module.tiers() == ("none",)


def test_a_server_leaves_nothing_behind():
    """Its folders and its process are gone at the end of the block, also after an error."""
    server = server_module.Server("none")
    with suppress(KeyError), server.started():
        scratch, process = server._scratch, server._process
        assert scratch.is_dir()
        raise KeyError
    assert not scratch.exists()
    assert process.poll() is not None


GRADER = """
import sys
from fieldgrade.isolation import server as server_module, session
with server_module.Server(sys.argv[1]).started() as server:
    print(server._scratch, flush=True)
    group = session.CallGroup("x", (), 1.0)
    session.run(server, ["open('here', 'w')", "while True: pass"], [group])
"""


def of(scratch):
    """The processes that run in a folder."""
    lines = (p for p in Path("/proc").glob("[0-9]*/cmdline"))
    found = []
    for line in lines:
        with suppress(OSError):
            if scratch in line.read_bytes().decode(errors="replace"):
                found.append(line.parent.name)
    return found


def awaited(condition):
    """Whether something comes true; a busy machine may take its time."""
    end = time.monotonic() + 300
    while not condition() and time.monotonic() < end:
        time.sleep(0.02)
    return condition()


if sys.platform == "linux":

    @pytest.mark.slow
    @pytest.mark.parametrize("tier", server_module.tiers())
    def test_nothing_outlives_a_grader_that_is_killed(tier):
        """The server and what it made end with it, whatever that is at."""
        command = [sys.executable, "-c", GRADER, tier]
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as grader:
            scratch = Path(grader.stdout.readline().strip())
            assert awaited(lambda: list((scratch / "homes").glob("*/here")))
            assert of(str(scratch))
            grader.kill()
        assert awaited(lambda: not of(str(scratch)))
        homes.remove(str(scratch))
