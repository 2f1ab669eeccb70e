"""The archive of received files, each under the digest of its content."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import IO

from fieldrecon._core.atomic_files import temporary_beside

PIECE = 1 << 20


class CannotArchive(ValueError):
    """A received file cannot be archived: it cannot be read, or it is too large."""


@dataclass(frozen=True)
class Archive:
    """A folder of received files, which are never changed.

    Parameters
    ----------
    folder : Path
        The folder; it is created when it is needed.
    """

    folder: Path

    def put(self, stream: IO[bytes], most: int) -> str:
        """Archive the content of a stream, and return its digest.

        Raises
        ------
        CannotArchive
            There are more bytes than `most`, or they cannot be read. Errors of the archive itself,
            such as a full disk, are raised unchanged.
        """
        self.folder.mkdir(parents=True, exist_ok=True)
        digest = hashlib.sha256()
        temporary = temporary_beside(self.folder / "received")
        try:
            with temporary.open("xb") as file:
                for piece in _pieces(stream, most):
                    digest.update(piece)
                    file.write(piece)
            self._keep(temporary, digest.hexdigest())
        finally:
            temporary.unlink(missing_ok=True)
        return digest.hexdigest()

    def path(self, digest: str) -> Path:
        """Return the path of the file with a digest, which may not exist."""
        return self.folder / digest[:2] / digest

    def read(self, digest: str, most: int) -> bytes:
        """Return the bytes of a file, at most `most + 1`; one more than `most` means too many."""
        with self.path(digest).open("rb") as file:
            return file.read(most + 1)

    def _keep(self, temporary: Path, digest: str) -> None:
        file = self.path(digest)
        if not file.exists():
            file.parent.mkdir(exist_ok=True)
            temporary.chmod(0o444)
            temporary.replace(file)


def _pieces(stream: IO[bytes], most: int) -> Iterator[bytes]:
    left = most
    while piece := _read(stream):
        left -= len(piece)
        if left < 0:
            raise CannotArchive(f"it has more than {most / (1 << 20):.0f} MiB")
        yield piece


def _read(stream: IO[bytes]) -> bytes:
    try:
        return stream.read(PIECE)
    except Exception as error:  # each compression method raises its own errors
        raise CannotArchive(f"it cannot be read ({error})") from None
