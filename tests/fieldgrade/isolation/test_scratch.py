"""A folder that a killed grader left behind is removed; every other folder stays."""

import os
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

from fieldgrade.isolation import scratch, worker_servers

GRADER = """
import os, signal
from fieldgrade.isolation.server import Server
with Server("none").started() as server:
    print(server._scratch.folder, flush=True)
    os.kill(os.getpid(), signal.SIGKILL)
"""


@pytest.fixture(autouse=True)
def temporary(tmp_path, monkeypatch):
    """The temporary folder of this test."""
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    return tmp_path


def abandoned():
    """A folder whose owner has ended, with content that resists."""
    left = scratch.Scratch.create()
    (left.folder / "homes" / "deep").mkdir(parents=True)
    (left.folder / "homes" / "deep" / "file").touch()
    (left.folder / "homes" / "link").symlink_to("/usr")
    (left.folder / "homes" / "deep").chmod(0)
    os.close(left.lock)
    return left.folder


def test_abandoned_folders_are_removed_at_the_next_run():
    """The folder of a server that runs stays."""
    left, used = abandoned(), scratch.Scratch.create()
    with worker_servers.serving():
        assert not left.exists()
        assert used.folder.is_dir()
    used.remove()
    assert not used.folder.exists()


@pytest.mark.parametrize(
    "change",
    [
        lambda folder: (folder / scratch.LOCK).rename(folder / "other"),
        lambda folder: folder.chmod(0o755),
        lambda folder: folder.rename(folder.with_name("ungraded")),
        lambda folder: folder.with_name("grading-y").symlink_to(folder.rename(folder.parent / "x")),
        lambda folder: folder.with_name("grading-z").touch(),
    ],
)
def test_what_is_not_surely_an_abandoned_folder_stays(change, temporary):
    """A folder without the lock, open to others, of another name, or only a link to one."""
    change(abandoned() if "touch" not in change.__code__.co_names else temporary / "x")
    before = sorted(temporary.iterdir())
    scratch.remove_abandoned()
    assert sorted(temporary.iterdir()) == before


def test_the_folder_of_another_user_stays(monkeypatch):
    """It is not even opened."""
    left = abandoned()
    monkeypatch.setattr(os, "getuid", lambda: 4711)
    scratch.remove_abandoned()
    assert left.is_dir()


@pytest.mark.slow
def test_a_grader_that_is_killed_leaves_a_folder_for_the_next_run(temporary):
    """Its server ends by itself."""
    ended = subprocess.run(
        [sys.executable, "-c", GRADER],
        stdout=subprocess.PIPE,
        text=True,
        env={**os.environ, "TMPDIR": str(temporary)},
        timeout=100,
    )
    left = Path(ended.stdout.strip())
    assert (ended.returncode, left.parent, left.is_dir()) == (-signal.SIGKILL, temporary, True)
    scratch.remove_abandoned()
    assert not left.exists()
