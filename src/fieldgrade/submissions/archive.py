"""Received files, kept under the digests of their contents, before anything is done with them."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from tempfile import NamedTemporaryFile
from typing import IO

PIECE = 1 << 20


class NotTaken(ValueError):
    """What was received cannot be kept: it cannot be read, or there is too much of it."""


@dataclass(frozen=True)
class Archive:
    """A folder of received files. What is in it is never changed.

    Parameters
    ----------
    folder : Path
        It is made when something is kept.
    """

    folder: Path

    def put(self, stream: IO[bytes], most: int) -> str:
        """Keep what a stream holds, and return its digest.

        Raises
        ------
        NotTaken
            There are more bytes than `most`, or they cannot be read. Errors of the archive itself,
            such as a full disk, are raised as they are.
        """
        self.folder.mkdir(parents=True, exist_ok=True)
        digest = hashlib.sha256()
        with NamedTemporaryFile(dir=self.folder, prefix=".part-", delete=False) as part:
            try:
                for piece in _pieces(stream, most):
                    digest.update(piece)
                    part.write(piece)
                part.close()
                self._keep(Path(part.name), digest.hexdigest())
            finally:
                Path(part.name).unlink(missing_ok=True)
        return digest.hexdigest()

    def path(self, digest: str) -> Path:
        """Return where the file with a digest is, or would be."""
        return self.folder / digest[:2] / digest

    def read(self, digest: str, most: int) -> bytes:
        """Return a file's bytes, or the first of them: one more than `most` tells that more are."""
        with self.path(digest).open("rb") as file:
            return file.read(most + 1)

    def _keep(self, part: Path, digest: str) -> None:
        file = self.path(digest)
        if not file.exists():
            file.parent.mkdir(exist_ok=True)
            part.chmod(0o444)
            part.replace(file)


def _pieces(stream: IO[bytes], most: int) -> Iterator[bytes]:
    left = most
    while piece := _read(stream):
        left -= len(piece)
        if left < 0:
            raise NotTaken(f"it has more than {most / (1 << 20):.0f} MiB")
        yield piece


def _read(stream: IO[bytes]) -> bytes:
    try:
        return stream.read(PIECE)
    except Exception as error:  # each way to compress has errors of its own
        raise NotTaken(f"it cannot be read ({error})") from None
