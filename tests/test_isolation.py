"""Tiers: what a machine offers is used, the safest first, and nothing is offered that is not."""

import pytest

from fieldrecon.course.grading import isolation
from fieldrecon.course.sandbox import landlock, seccomp


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
    monkeypatch.setattr(isolation.walls, "work", lambda: bubblewrap)
    monkeypatch.setattr(landlock, "version", lambda: version)
    assert isolation.tiers() == expected


def test_other_systems_have_no_walls(monkeypatch):
    """On macOS, as on machines whose calls are not known, only the last tier is left."""
    monkeypatch.setattr(seccomp.sys, "platform", "darwin")
    assert not seccomp.is_known()
    assert landlock.version() == 0
    assert isolation.tiers() == ("none",)
    monkeypatch.undo()
    monkeypatch.setattr(seccomp.platform, "machine", lambda: "riscv64")
    assert isolation.tiers() == ("none",)


def test_a_server_leaves_nothing_behind():
    """Its folders and its process are gone at the end of the block, also after an error."""
    server = isolation.Server("none")
    with pytest.raises(KeyError), server.started():
        scratch, process = server._scratch, server._process
        assert scratch.is_dir()
        raise KeyError
    assert not scratch.exists()
    assert process.poll() is not None
