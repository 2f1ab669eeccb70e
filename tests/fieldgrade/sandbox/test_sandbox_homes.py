"""Home folders in the sandbox are measured and emptied, whatever they contain."""

import os
from pathlib import Path

import pytest

from fieldgrade.sandbox import homes


@pytest.fixture
def home(tmp_path):
    (tmp_path / "home").mkdir()
    return tmp_path / "home"


def deep(folder, depth):
    """Nested folders whose path is longer than any path may be."""
    here = os.open(folder, os.O_RDONLY)
    for _ in range(depth):
        os.mkdir("d" * 100, dir_fd=here)
        inner = os.open("d" * 100, os.O_RDONLY, dir_fd=here)
        os.close(here)
        here = inner
    os.close(here)


def closed(folder, _):
    """Folders without permissions, with files in them."""
    for name in ("a", "b"):
        (folder / name / "inner").mkdir(parents=True)
        (folder / name / "inner" / "file").write_text("x")
        (folder / name / "inner").chmod(0)
        (folder / name).chmod(0o500)


def linked(folder, _):
    """Links to files that must stay, to nothing, and to themselves; a named pipe."""
    (folder / "out").symlink_to(folder.parent / "kept")
    (folder / "root").symlink_to("/")
    (folder / "nothing").symlink_to("nothing at all")
    (folder / "self").symlink_to("self")
    os.mkfifo(folder / "pipe")


def many(folder, count):
    """Many files with unusual names."""
    for k in range(count):
        (folder / f"-{k}\n\udcff").touch()


@pytest.mark.parametrize(("fill", "size"), [(deep, 200), (closed, 0), (linked, 0), (many, 3000)])
def test_a_home_folder_is_emptied(fill, size, home):
    """The folder itself and the targets of links are untouched."""
    kept = home.parent / "kept"
    kept.mkdir()
    (kept / "file").write_text("kept")
    number = home.stat().st_ino
    fill(home, size)
    homes.empty(str(home))
    assert list(home.iterdir()) == []
    assert home.stat().st_ino == number
    assert (kept / "file").read_text() == "kept"
    homes.remove(str(home))
    assert not home.exists()


def test_a_folder_that_cannot_be_removed_is_left(home, monkeypatch):
    """No error is raised."""
    (home / "a" / "b").mkdir(parents=True)

    def refuse(*_):
        raise PermissionError

    monkeypatch.setattr(os, "rename", refuse)
    homes.empty(str(home))
    assert (home / "a" / "b").is_dir()


def test_an_overfull_home_folder_is_detected(home):
    """The criteria are the number of entries, the disk space used, and the depth."""
    assert not homes.is_overfull(str(home))
    linked(home, 0)
    many(home, 10)
    assert not homes.is_overfull(str(home))
    with (home / "holes").open("wb") as file:
        file.truncate(10 * homes.MOST_BYTES)
    assert not homes.is_overfull(str(home))
    (home / "large").write_bytes(bytes(homes.MOST_BYTES + 1))
    assert homes.is_overfull(str(home))
    (home / "large").unlink()
    many(home, homes.MOST_ENTRIES + 1)
    assert homes.is_overfull(str(home))
    homes.empty(str(home))
    deep(home, 60)
    assert homes.is_overfull(str(home))
    homes.empty(str(home))
    assert not homes.is_overfull(str(Path(home) / "no such folder"))
