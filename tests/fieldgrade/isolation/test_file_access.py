"""File access of sandboxed code: Python and its packages are readable, the course is not."""

import json
from itertools import pairwise
from pathlib import Path

import pytest

from checkout import ROOT
from fieldgrade.isolation import file_access


@pytest.fixture
def folders(tmp_path):
    return file_access.SandboxFolders.create(tmp_path)


def test_the_sandbox_contains_no_answers(folders):
    """Neither known answers, nor stubs, nor modules of the library or of the grader."""
    names = {str(p.relative_to(folders.stage)) for p in folders.stage.rglob("*") if p.is_file()}
    assert "fieldcheck/calls.py" in names
    assert "fieldgrade/sandbox/worker.py" in names
    ours = {
        n
        for n in names
        if n.startswith(("fieldgrade", "fieldrecon", "fieldreport")) and "/sandbox/" not in n
    }
    assert ours == {"fieldgrade/__init__.py"}
    assert all((folders.stage / name).read_text() == "" for name in ours)
    assert not any("answers/" in name or "stubs.json" in name for name in names)


def test_no_readable_folder_contains_the_course(folders):
    """The sources, the packages and the library are in no readable folder."""
    settings = folders.settings()
    for hidden in file_access.hidden_folders():
        assert hidden.is_dir()
        for path in settings["readable"]:
            assert not hidden.is_relative_to(Path(path).resolve()), path
    assert ROOT.resolve() in file_access.hidden_folders()
    json.dumps(settings)


def test_hidden_folders_are_excluded_from_the_readable_folders(tmp_path):
    """Their siblings stay readable; links into and out of them do not bypass the exclusion."""
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


def test_bubblewrap_hides_a_folder_before_it_binds_its_subfolders(tmp_path):
    """An environment inside the course is readable, the rest of the course is not."""
    usr, course = tmp_path / "usr", tmp_path / "usr" / "course"
    packages = course / "venv"
    packages.mkdir(parents=True)
    command = file_access._bubblewrap_command([usr, packages], [], [course])
    order = [command.index(str(path)) for path in (usr, course, packages)]
    assert order == sorted(order)
    assert command[command.index(str(course)) - 1] == "--tmpfs"
    remounted = [b for a, b in pairwise(command) if a == "--remount-ro"]
    assert remounted == [str(course), "/tmp", "/dev", "/"]


def test_the_bubblewrap_tier_requires_a_working_program(monkeypatch):
    """The tier is unavailable if the program is missing or the kernel refuses it."""
    monkeypatch.setattr(file_access.shutil, "which", lambda _: None)
    assert not file_access.bubblewrap_works()
    monkeypatch.setattr(file_access.shutil, "which", lambda _: "/bin/false")
    assert not file_access.bubblewrap_works()
