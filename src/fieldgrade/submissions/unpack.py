"""List the files in folders and zip files; unsafe ones are refused with a reason.

No file is unpacked to the path in its name: it is opened in place, and the archive stores its bytes
under their digest. Links, devices and names that lead out of the folder are refused nevertheless,
since they do not occur by accident.
"""

from __future__ import annotations

import mmap
import re
import stat
import zipfile
from collections.abc import Callable
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from functools import partial
from itertools import islice
from pathlib import Path
from typing import IO

MEBIBYTE = 1 << 20
MOST_MEMBERS = 20_000
MOST_UNPACKED = 8192 * MEBIBYTE
LONGEST_NAME, MOST_FOLDERS = 255, 100
MEMBER, DIRECTORY_END = re.compile(rb"PK\x01\x02"), b"PK\x05\x06"
"""The signatures of each entry in the central directory of a zip file, and of its end."""
UNKNOWN = 0xFFFFFFFF
"""The size of a directory that is stated elsewhere, in the format for large files."""
DRIVE = re.compile(r"[A-Za-z]:")
LEADS_OUT = "its name leads out of the folder"
IGNORED_FOLDERS = {
    *(
        "__MACOSX",
        "__pycache__",
        "fieldcheck",
        "site-packages",
        "venv",
        ".venv",
        ".ipynb_checkpoints",
    ),
    *(".git", ".idea", ".vscode", ".cache", ".pytest_cache", ".mypy_cache", ".ruff_cache"),
    *(".Trashes", ".Trash", ".Spotlight-V100", ".fseventsd", ".TemporaryItems"),
}
IGNORED_NAMES = {"Thumbs.db", "desktop.ini", "student.txt"}
CODE = (".ipynb", ".py", ".zip")
"""The endings of files that are graded."""


class BadZip(ValueError):
    """A zip file cannot be unpacked; the message says why."""


@dataclass(frozen=True)
class InputFile:
    """A file below a folder or in a zip file.

    Parameters
    ----------
    parts : tuple of str
        The folders of its path, and its name.
    open : callable
        Opens the file.
    time : str
        The time of the last change, in ISO 8601, if known.
    by : str
        The source of the time: ``"file"`` or ``"zip"``.
    refused : str
        Why the file is refused; empty if it is accepted.
    """

    parts: tuple[str, ...]
    open: Callable[[], IO[bytes]]
    time: str = ""
    by: str = "file"
    refused: str = ""

    @property
    def name(self) -> str:
        """The path of the file."""
        return "/".join(self.parts)

    @property
    def is_zip(self) -> bool:
        """Whether the name ends as the name of a zip file does."""
        return self.parts[-1].lower().endswith(".zip")

    def below(self, depth: int) -> InputFile:
        """Return the file without its outermost folders."""
        return replace(self, parts=self.parts[depth:])


def folder_items(folder: Path) -> list[InputFile]:
    """Return the files below a folder in the order of their names; no link is followed.

    Raises
    ------
    OSError
        The folder itself cannot be read.
    """
    found: list[InputFile] = []
    todo: list[tuple[Path, tuple[str, ...]]]
    todo = [(path, (_printable(path.name),)) for path in folder.iterdir()]
    while todo:  # not recursive: folders can be nested more deeply than function calls
        path, parts = todo.pop()
        if parts[-1] in IGNORED_FOLDERS:
            continue
        try:
            mode = path.lstat().st_mode
            if stat.S_ISDIR(mode):
                todo += [(inner, (*parts, _printable(inner.name))) for inner in path.iterdir()]
            elif not is_ignored(parts):
                found.append(_file(path, parts, mode))
        except OSError as error:
            refused = f"it cannot be read ({error.strerror})"
            found.append(InputFile(parts, partial(_read, path), refused=refused))
    return sorted(found, key=lambda item: item.parts)


def _file(path: Path, parts: tuple[str, ...], mode: int) -> InputFile:
    if not stat.S_ISREG(mode):
        kind = "a link" if stat.S_ISLNK(mode) else "not a regular file"
        return InputFile(parts, partial(_read, path), refused=f"it is {kind}")
    try:
        time = datetime.fromtimestamp(int(path.lstat().st_mtime), UTC).isoformat()
    except (ValueError, OverflowError):
        time = ""
    return InputFile(parts, partial(_read, path), time)


def _read(path: Path) -> IO[bytes]:
    return path.open("rb")


def zip_items(path: Path) -> list[InputFile]:
    """Return the files in a zip file in the order of their names.

    Raises
    ------
    BadZip
        The file is not a valid zip file, or has too many members or too much content.
    """
    try:
        if _members(path) > MOST_MEMBERS:
            raise BadZip(f"the zip file holds more than {MOST_MEMBERS} files and folders")
        pack = zipfile.ZipFile(path)  # open as long as one of its files is referenced
        members = [info for info in pack.infolist() if not info.is_dir()]
    except BadZip:
        raise
    except Exception as error:  # a damaged zip file can raise any error
        raise BadZip(f"the zip file is damaged ({error})") from None
    if sum(m.file_size for m in members) > MOST_UNPACKED:
        raise BadZip(f"the zip file holds more than {MOST_UNPACKED // MEBIBYTE} MiB")
    items = (_member(pack, info) for info in members)
    return sorted((i for i in items if not is_ignored(i.parts)), key=lambda item: item.parts)


def _members(path: Path) -> int:
    """Return the number of entries in the directory, or a larger one than is allowed.

    The entries are counted before any of them is read into memory.
    """
    with path.open("rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as content:
        end = content.rfind(DIRECTORY_END)
        size = int.from_bytes(content[end + 12 : end + 16], "little") if end >= 0 else UNKNOWN
        start = end - size if size < min(end, UNKNOWN) else 0
        found = MEMBER.finditer(content, start)
        count = sum(1 for _ in islice(found, MOST_MEMBERS + 1))
        del found  # it refers to the content, which could not be closed
        return count


def _member(pack: zipfile.ZipFile, info: zipfile.ZipInfo) -> InputFile:
    parts = tuple(_printable(part) for part in info.filename.replace("\\", "/").split("/"))
    refused = ""
    if stat.S_ISLNK(info.external_attr >> 16):
        refused = "it is a link"
    elif any(part in ("", ".", "..") for part in parts) or DRIVE.match(parts[0]):
        refused = LEADS_OUT
    elif len(parts) > MOST_FOLDERS or any(len(part) > LONGEST_NAME for part in parts):
        refused = "its name is too long"
    elif info.flag_bits & 1:
        refused = "it is encrypted"
    kept = tuple(part[:LONGEST_NAME] for part in parts if part not in ("", ".", ".."))
    kept = kept[-MOST_FOLDERS:] or ("?",)
    return InputFile(kept, partial(_open, pack, info), _local(info.date_time), "zip", refused)


def _open(pack: zipfile.ZipFile, info: zipfile.ZipInfo) -> IO[bytes]:
    return pack.open(info)


def _local(time: tuple[int, int, int, int, int, int]) -> str:
    """Return a time of a zip file, which has no time zone, as local time."""
    try:
        return datetime(*time).astimezone(UTC).isoformat()
    except (ValueError, OverflowError, OSError):
        return ""


def is_ignored(parts: tuple[str, ...]) -> bool:
    """Whether a file is not the student's work: of the system, a cache, or a copy of the checks.

    A folder whose name begins with a dot may be a student's, and is read.
    """
    name = parts[-1]
    hidden = name.startswith("._") or (name.startswith(".") and not name.lower().endswith(CODE))
    return hidden or not IGNORED_FOLDERS.isdisjoint(parts) or name in IGNORED_NAMES


def _printable(name: str) -> str:
    """Return a name that can be written to any text file; different names remain different."""
    return "".join(c if c.isprintable() and c != "\\" else ascii(c)[1:-1] for c in name)
