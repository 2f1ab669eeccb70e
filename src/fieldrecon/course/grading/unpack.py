"""Files in folders and zip files, one by one, with what is not taken from them and why.

Nothing is unpacked to where its name says: an item is opened where it lies, and the archive keeps
its bytes under their digest. Links, devices and names that lead elsewhere are refused all the same,
since they are no accident.
"""

from __future__ import annotations

import stat
import zipfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from typing import IO

MEBIBYTE = 1 << 20
MOST_MEMBERS = 20_000
MOST_UNPACKED = 8192 * MEBIBYTE
SKIPPED = {"__MACOSX", "__pycache__", "fieldcheck", "site-packages", "venv"}
CHAFF = {"Thumbs.db", "desktop.ini", "student.txt"}


class NoZip(ValueError):
    """A zip file that cannot be unpacked; the sentence says why."""


@dataclass(frozen=True)
class Item:
    """A file somewhere below a folder, or in a zip file.

    Parameters
    ----------
    parts : tuple of str
        Its folders, and its name.
    open : callable
        Opens it.
    time : str
        When it was last changed, in ISO 8601, if that is known.
    by : str
        Who says so: ``"file"`` or ``"zip"``.
    refused : str
        Why it is not taken; empty if it is.
    """

    parts: tuple[str, ...]
    open: Callable[[], IO[bytes]]
    time: str = ""
    by: str = "file"
    refused: str = ""

    @property
    def name(self) -> str:
        """Its name with its folders."""
        return "/".join(self.parts)

    @property
    def is_zip(self) -> bool:
        """Whether it is called a zip file."""
        return self.parts[-1].lower().endswith(".zip")


def folder_items(folder: Path) -> Iterator[Item]:
    """Yield the files below a folder in the order of their names; no link is followed."""
    for path in sorted(folder.iterdir()):
        mode = path.lstat().st_mode
        parts = (_printable(path.name),)
        if is_chaff(parts):
            continue
        if stat.S_ISDIR(mode):
            yield from (replace(i, parts=parts + i.parts) for i in folder_items(path))
        elif stat.S_ISREG(mode):
            time = datetime.fromtimestamp(int(path.stat().st_mtime), UTC).isoformat()
            yield Item(parts, partial(path.open, "rb"), time)
        else:
            kind = "a link" if stat.S_ISLNK(mode) else "no file"
            yield Item(parts, partial(path.open, "rb"), refused=f"it is {kind}")


def zip_items(path: Path) -> list[Item]:
    """Return the files in a zip file in the order of their names.

    Raises
    ------
    NoZip
        It is none, or holds more than can be.
    """
    try:
        with zipfile.ZipFile(path) as pack:
            members = [info for info in pack.infolist() if not info.is_dir()]
    except (zipfile.BadZipFile, OSError, ValueError, NotImplementedError) as error:
        raise NoZip(f"the zip file is damaged ({error})") from None
    if len(members) > MOST_MEMBERS or sum(m.file_size for m in members) > MOST_UNPACKED:
        raise NoZip("the zip file holds more than can be unpacked")
    items = (_member(path, info) for info in members)
    return sorted((i for i in items if not is_chaff(i.parts)), key=lambda item: item.parts)


def _member(path: Path, info: zipfile.ZipInfo) -> Item:
    parts = tuple(_printable(part) for part in info.filename.replace("\\", "/").split("/"))
    refused = ""
    if stat.S_ISLNK(info.external_attr >> 16):
        refused = "it is a link"
    elif any(part in ("", ".", "..") for part in parts) or ":" in parts[0]:
        refused = "its name leads out of the folder"
    elif info.flag_bits & 1:
        refused = "it is encrypted"
    kept = tuple(part for part in parts if part not in ("", ".", "..")) or ("?",)
    return Item(kept, partial(_open, path, info), _local(info.date_time), "zip", refused)


def _open(path: Path, info: zipfile.ZipInfo) -> IO[bytes]:
    with zipfile.ZipFile(path) as pack:  # the member keeps the file open that it is read from
        return pack.open(info)


def _local(time: tuple[int, int, int, int, int, int]) -> str:
    """Return a time of a zip file, which says nothing of zones, as one of here."""
    try:
        return datetime(*time).astimezone(UTC).isoformat()
    except (ValueError, OverflowError, OSError):
        return ""


def is_chaff(parts: tuple[str, ...]) -> bool:
    """Whether a file is not the student's work: hidden, a cache, a copy of the checks."""
    hidden = any(part.startswith(".") and part not in (".", "..") for part in parts)
    return hidden or not SKIPPED.isdisjoint(parts) or parts[-1] in CHAFF


def _printable(name: str) -> str:
    """Return a name that every file of text can hold."""
    text = name.encode("utf-8", "backslashreplace").decode("utf-8")
    return "".join(c if c.isprintable() else "?" for c in text)
