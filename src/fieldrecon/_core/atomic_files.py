"""A file is written whole or not at all."""

from __future__ import annotations

import os
import re
import secrets
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

TEMPORARY = re.compile(r"\.\d+-[0-9a-f]{8}\..+")
"""Names under which files are written before they are renamed: what a killed process leaves."""


def temporary_beside(path: Path) -> Path:
    """Another name in the same folder, with the same ending, since that says which format it is."""
    return path.with_name(f".{os.getpid()}-{secrets.token_hex(4)}.{path.name}")


@contextmanager
def whole_file(path: Path, sync: bool = True) -> Iterator[Path]:
    """Give a temporary name beside the path to write under; it takes the path's name at the end.

    Whatever stood there stays if the writing fails or is interrupted. Folders are made. Without
    `sync` a power failure may leave the file torn, which is good enough for what can be made again.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = temporary_beside(path)
    try:
        yield temporary
        if sync:
            with temporary.open("rb+") as file:
                os.fsync(file.fileno())
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)


def write_atomically(path: Path, content: bytes, sync: bool = True) -> Path:
    """Write a file under a temporary name and rename it, so that nobody sees half of it."""
    with whole_file(path, sync) as temporary:
        temporary.write_bytes(content)
    return path
