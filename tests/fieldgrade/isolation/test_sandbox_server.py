"""Tiers of isolation: the available ones in order of safety, and servers that clean up."""

import os
import subprocess
import sys
import tempfile
import threading
import time
from contextlib import ExitStack, suppress
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
def test_tiers_are_ordered_from_safest_to_none(locks, bubblewrap, version, expected, monkeypatch):
    """Both sandboxes need the seccomp filter, without which processes cannot be limited."""
    monkeypatch.setattr(seccomp, "is_known", lambda: locks)
    monkeypatch.setattr(server_module.file_access, "bubblewrap_works", lambda: bubblewrap)
    monkeypatch.setattr(landlock, "version", lambda: version)
    assert server_module.tiers() == expected


def test_macos_and_unknown_machines_offer_no_sandbox(monkeypatch):
    """Only the tier `none` is left there."""
    monkeypatch.setattr(seccomp.sys, "platform", "darwin")
    assert not seccomp.is_known()
    assert landlock.version() == 0
    assert server_module.tiers() == ("none",)
    monkeypatch.undo()
    monkeypatch.setattr(seccomp.platform, "machine", lambda: "riscv64")
    assert server_module.tiers() == ("none",)


@pytest.mark.slow
def test_a_server_removes_its_folders_and_process():
    """This also holds after an error in the block."""
    server = server_module.Server("none")
    with suppress(KeyError), server.started():
        scratch, process = server._scratch.folder, server._process
        assert scratch.is_dir()
        raise KeyError
    assert not scratch.exists()
    assert process.poll() is not None


@pytest.mark.slow
@pytest.mark.parametrize("running", [True, False])
def test_a_server_that_is_ended_while_it_starts_a_process_leaves_nothing(
    running, tmp_path, monkeypatch
):
    """Another thread ends it, between the look at its process and the start of a new one."""
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    server, block = server_module.Server("none"), ExitStack()
    block.enter_context(server.started())
    process, ending = server._process, threading.Thread(target=block.close)

    def poll():
        ending.start()
        time.sleep(0.5)
        return None if running else 1

    process.poll = poll
    with suppress(RuntimeError):
        for end in server.run():
            os.close(end)
    ending.join()
    assert process.returncode is not None
    assert list(tmp_path.iterdir()) == []
    assert server._process is None


GRADER = """
import sys, time
from fieldgrade.isolation import process as process_module
from fieldgrade.isolation import server as server_module
with server_module.Server(sys.argv[1]).started() as server:
    process = process_module.Process(server, time.monotonic() + 600)
    process.await_start()
    process.load(process_module.Program(["open('here', 'w')", "while True: pass"]), ())
    process.cell(0, ())
    print(server._scratch.folder, flush=True)
    process.cell(1, ())
"""


def processes_in(scratch):
    """The processes that run in a folder."""
    lines = (p for p in Path("/proc").glob("[0-9]*/cmdline"))
    found = []
    for line in lines:
        with suppress(OSError):
            if scratch in line.read_bytes().decode(errors="replace"):
                found.append(line.parent.name)
    return found


def becomes_true(condition):
    """Whether a condition becomes true; a busy machine may take long."""
    end = time.monotonic() + 300
    while not condition() and time.monotonic() < end:
        time.sleep(0.02)
    return condition()


if sys.platform == "linux":

    @pytest.mark.slow
    @pytest.mark.parametrize("tier", server_module.tiers())
    def test_the_server_ends_when_the_grader_is_killed(tier):
        """The server and its children end, whatever they are doing."""
        command = [sys.executable, "-c", GRADER, tier]
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as grader:
            scratch = Path(grader.stdout.readline().strip())
            assert processes_in(str(scratch))
            grader.kill()
        assert becomes_true(lambda: not processes_in(str(scratch)))
        homes.remove(str(scratch))
