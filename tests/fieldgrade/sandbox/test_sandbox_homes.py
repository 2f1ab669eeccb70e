"""Home folders in the sandbox are measured and emptied, whatever they contain."""

import ctypes
import mmap
import os
import sys
from contextlib import ExitStack
from pathlib import Path
from types import SimpleNamespace

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


@pytest.mark.parametrize(("fill", "size"), [(deep, 200), (closed, 0), (linked, 0), (many, 1000)])
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


@pytest.mark.slow
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


if sys.platform == "linux":
    C = ctypes.CDLL(None)
    C.mmap.restype = ctypes.c_void_p
    C.mmap.argtypes = [ctypes.c_void_p, ctypes.c_size_t, *[ctypes.c_int] * 3, ctypes.c_long]

    @pytest.mark.parametrize("keep", ["open", "mapped"])
    def test_deleted_files_count_while_they_are_kept(home, keep):
        """An open file counts with its size, a mapped one with the limit of a file."""
        limits = {"process": os.getpid(), "file_size": homes.MOST_BYTES // 2 + 4096}
        assert not homes.is_overfull(str(home), **limits)
        with ExitStack() as kept:
            for name in "abc":
                file = kept.enter_context((home / name).open("w+b"))
                file.write(bytes(homes.MOST_BYTES // 2 if keep == "open" else 1))
                file.flush()
                if keep == "mapped":
                    address = C.mmap(None, 4096, mmap.PROT_READ, mmap.MAP_SHARED, file.fileno(), 0)
                    kept.callback(C.munmap, ctypes.c_void_p(address), 4096)
                    file.close()
                (home / name).unlink()
            assert homes.is_overfull(str(home), **limits)
            assert not homes.is_overfull(str(home))
        assert not homes.is_overfull(str(home), **limits)


def test_a_home_on_a_full_disk_is_reported_with_its_folder(home, monkeypatch):
    """The room must suffice for a home; a home in memory has its own."""
    assert homes.lacking(str(home)) == ""
    size = homes.HARD_LIMIT * homes.MOST_BYTES // 4096
    for blocks, words in ((10 * size, f"the disk of {home} is full: 63 MiB are free"), (size, "")):
        disk = SimpleNamespace(
            f_blocks=blocks, f_frsize=4096, f_bavail=homes.MOST_BYTES // 4096 - 1
        )
        monkeypatch.setattr(os, "statvfs", lambda _, disk=disk: disk)
        assert homes.lacking(str(home)).startswith(words)
        assert bool(homes.lacking(str(home))) == bool(words)
