"""A file that the disk has no room for is named, and nothing that looks complete is left."""

import errno
import os
import resource
import signal

import numpy as np
import pytest

from fieldrecon._core.atomic_files import whole_file, write_atomically, write_if_changed
from fieldrecon.io.targets import Targets, TargetValues
from fieldrecon.io.values import FORMATS, write_values


@pytest.fixture
def file_limit():
    """A function that limits the size of a file, as a full disk does, until the test ends."""
    handler = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    yield lambda size=before[0]: resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    resource.setrlimit(resource.RLIMIT_FSIZE, before)
    signal.signal(signal.SIGXFSZ, handler)


def result_at(points):
    """A field with its error at points."""
    m = len(points)
    return TargetValues(
        ("x", "y", "v"), Targets(points), points[:, 0], np.ones(m), np.zeros(m, dtype=np.int8)
    )


@pytest.mark.parametrize("suffix", FORMATS)
def test_a_full_disk_names_the_file_and_leaves_the_one_before(tmp_path, file_limit, suffix):
    """At its first byte, in its middle and before its end, for each format."""
    path = tmp_path / f"field.{suffix}"
    points = np.random.default_rng(0).random((2000, 2))
    before = write_values(path, result_at(points)).read_bytes()
    for size in (10, len(before) // 2, len(before) - 8):
        file_limit(size)
        with pytest.raises(OSError, match=rf"field\.{suffix}") as caught:
            write_values(path, result_at(points))
        file_limit()
        assert caught.value.errno == errno.EFBIG
        assert [entry.name for entry in tmp_path.iterdir()] == [path.name]
        assert path.read_bytes() == before


def test_a_file_is_on_the_disk_before_it_has_its_name(tmp_path, monkeypatch):
    """So that a power failure leaves no half of it; what can be made again is not waited for."""
    path, seen = tmp_path / "a", []
    monkeypatch.setattr(os, "fsync", lambda _: seen.append(path.exists()))
    write_atomically(path, b"one", sync=False)
    assert seen == []
    path.unlink()
    write_atomically(path, b"one")
    assert seen == [False]
    with whole_file(tmp_path / "b") as temporary:
        temporary.write_bytes(b"two")
    assert len(seen) == 2


def test_a_file_with_the_same_content_is_not_written_again(tmp_path):
    """Its time of modification, by which programs see a change, stays."""
    path = write_if_changed(tmp_path / "new" / "a", b"one")
    os.utime(path, (1, 1))
    write_if_changed(path, b"one")
    assert (path.read_bytes(), path.stat().st_mtime) == (b"one", 1)
    write_if_changed(path, b"two")
    assert path.read_bytes() == b"two"
    assert path.stat().st_mtime > 1
