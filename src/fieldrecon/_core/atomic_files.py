"""Atomic writing: a file is replaced only after the new one is complete."""

from __future__ import annotations

import errno
import os
import re
import secrets
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

TEMPORARY = re.compile(r"\.\d+-[0-9a-f]{8}\..+")
"""Names of files before they are renamed; a killed process may leave such files."""


def temporary_beside(path: Path) -> Path:
    """A temporary name in the same folder, with the same ending, which determines the format."""
    return path.with_name(f".{os.getpid()}-{secrets.token_hex(4)}.{path.name}")


@contextmanager
def whole_file(path: Path, sync: bool = True) -> Iterator[Path]:
    """Yield a temporary path to write to, which is renamed to the path at the end.

    An existing file stays if writing fails or is interrupted. Missing folders are created. Without
    `sync`, a power failure may leave an incomplete file; this suffices for reproducible files.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = temporary_beside(path)
    try:
        yield temporary
        if sync:
            with temporary.open("rb+") as file:
                os.fsync(file.fileno())
        temporary.replace(path)
    except OSError as error:
        if error.errno is not None:  # a full disk does not name the file
            error.filename = error.filename or str(path)
        raise
    finally:
        temporary.unlink(missing_ok=True)


def check_writable(path: Path) -> None:
    """Raise the error that writing a file would meet in its folder, before long work."""
    folder = next(parent for parent in path.absolute().parents if parent.exists())
    if not folder.is_dir():
        raise NotADirectoryError(errno.ENOTDIR, os.strerror(errno.ENOTDIR), str(path))
    if not os.access(folder, os.W_OK | os.X_OK):
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), str(path))


def write_if_changed(path: Path, content: bytes) -> Path:
    """Write a file atomically, unless it has this content: it keeps its time of modification."""
    if not path.is_file() or path.read_bytes() != content:
        write_atomically(path, content)
    return path


def write_atomically(path: Path, content: bytes, sync: bool = True) -> Path:
    """Write a file under a temporary name and rename it, so that it is never seen incomplete."""
    with whole_file(path, sync) as temporary:
        temporary.write_bytes(content)
    return path
