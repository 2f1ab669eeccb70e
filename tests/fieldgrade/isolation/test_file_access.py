"""What is on the students' side: Python and its packages, none of the course."""

import json
from itertools import pairwise
from pathlib import Path

import pytest

from checkout import ROOT
from fieldgrade.isolation import file_access


@pytest.fixture
def place(tmp_path):
    return file_access.SandboxFolders.create(tmp_path)


def test_no_answer_is_on_the_stage(place):
    """Neither known answers, nor stubs, nor a module of the library or of the course's own."""
    names = {str(p.relative_to(place.stage)) for p in place.stage.rglob("*") if p.is_file()}
    assert "fieldcheck/calls.py" in names
    assert "fieldgrade/sandbox/worker.py" in names
    ours = {
        n
        for n in names
        if n.startswith(("fieldgrade", "fieldrecon", "fieldreport")) and "/sandbox/" not in n
    }
    assert ours == {"fieldgrade/__init__.py"}
    assert all((place.stage / name).read_text() == "" for name in ours)
    assert not any(name.endswith(".json") for name in names)
    assert not any("answers/" in name for name in names)


def test_the_course_cannot_be_read(place):
    """No folder that can be read holds the sources, the package or the library."""
    told = place.settings()
    for hidden in file_access.hidden_folders():
        assert hidden.is_dir()
        for path in told["readable"]:
            assert not hidden.is_relative_to(Path(path).resolve()), path
    assert ROOT.resolve() in file_access.hidden_folders()
    json.dumps(told)


def test_what_is_hidden_is_left_out_wherever_it_lies(tmp_path):
    """Beside it everything can be read; a link to it, or out, is no way around."""
    for name in ("a/ours/x", "a/theirs", "b", "outside"):
        (tmp_path / "usr" / name if name != "outside" else tmp_path / name).mkdir(parents=True)
    usr = tmp_path / "usr"
    (usr / "way").symlink_to(usr / "a")
    (usr / "a" / "also").symlink_to(usr / "a" / "ours")
    (usr / "out").symlink_to(tmp_path / "outside")
    left = list(file_access._without(usr, [usr / "a" / "ours"]))
    assert left == [usr / "a" / "theirs", usr / "b", usr / "way" / "theirs"]
    assert list(file_access._without(usr, [])) == [usr]
    assert list(file_access._without(usr, [usr])) == []


def test_bubblewrap_covers_what_is_hidden_before_it_shows_what_lies_in_it(tmp_path):
    """An environment below the course can be read, the course around it not."""
    usr, course = tmp_path / "usr", tmp_path / "usr" / "course"
    packages = course / "venv"
    packages.mkdir(parents=True)
    command = file_access._bubblewrap_command([usr, packages], [], [course])
    order = [command.index(str(path)) for path in (usr, course, packages)]
    assert order == sorted(order)
    assert command[command.index(str(course)) - 1] == "--tmpfs"
    remounted = [b for a, b in pairwise(command) if a == "--remount-ro"]
    assert remounted == [str(course), "/tmp", "/dev", "/"]


def test_bubblewrap_that_fails_is_none(monkeypatch):
    """Where the program is missing, or the kernel does not let it, its tier is not offered."""
    monkeypatch.setattr(file_access.shutil, "which", lambda _: None)
    assert not file_access.bubblewrap_works()
    monkeypatch.setattr(file_access.shutil, "which", lambda _: "/bin/false")
    assert not file_access.bubblewrap_works()
