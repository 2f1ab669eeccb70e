"""Files that a student submitted beside a notebook, which its code can import or read."""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import PurePosixPath

from fieldgrade.submissions.archive import Archive
from fieldgrade.submissions.bulk_downloads import TRAILING_NUMBER
from fieldgrade.submissions.collection import ReceivedFile

MOST_FILES, MOST_BYTES = 50, 4 << 20
"""Limits for the helper files of a notebook: number and total size."""
MOST_FOLDERS, LONGEST_NAME = 8, 200
IN_ZIP = re.compile(r".*\.zip/", re.IGNORECASE | re.DOTALL)
NO_HELPERS = (".ipynb", ".zip")
TOO_LARGE = (
    f"{{}} is not available to the notebook: all files beside it may have {MOST_BYTES >> 20} MiB, "
    f"and there may be {MOST_FILES}"
)


def helper_files(
    file: ReceivedFile, others: Iterable[ReceivedFile], archive: Archive
) -> tuple[dict[str, ReceivedFile], list[ReceivedFile]]:
    """Return the student's other files by their paths beside a file, and those beyond the limits.

    Parameters
    ----------
    file : ReceivedFile
        The file to be graded.
    others : iterable of ReceivedFile
        The files of the same student; of several with one path the last counts.
    archive : Archive
        Where they are kept. Sizes are compared with the limits before anything is read. Python
        files come first, then the smallest files.
    """
    own, aliases = dict[str, ReceivedFile](), dict[str, ReceivedFile]()
    for other in others:
        if other.digest and other.digest != file.digest:
            first, *more = paths_beside(other.name, file.name) or [""]
            own |= {first: other} if first else {}
            aliases |= dict.fromkeys(more, other)
    sizes = {path: _size(other, archive) for path, other in (aliases | own).items()}
    found, left_out = dict[str, ReceivedFile](), list[ReceivedFile]()
    left = MOST_BYTES
    for path in sorted(sizes, key=lambda p: (p not in own, not p.endswith(".py"), sizes[p], p)):
        if len(found) < MOST_FILES and sizes[path] <= left:
            found[path], left = (aliases | own)[path], left - sizes[path]
        elif path in own:
            left_out.append(own[path])
    return found, left_out


def _size(file: ReceivedFile, archive: Archive) -> int:
    return archive.path(file.digest).stat().st_size


def is_mentioned(file: ReceivedFile, code: str) -> bool:
    """Whether code contains the name of a file, without ending and appended number."""
    stem = PurePosixPath(file.name).stem
    return any(name in code for name in {stem, TRAILING_NUMBER.sub("", stem)})


def paths_beside(name: str, notebook: str) -> list[str]:
    """Return the paths that a file has from the folder of a notebook; none for a notebook.

    A file outside this folder counts as if it were in it. A number that a platform appended is
    removed: from the name of a Python file, which could not be imported, and in a second path of
    another file. The last path has no folders, since a platform may have removed them.

    Examples
    --------
    >>> paths_beside("hw/lib/bases.py", "hw/01.ipynb"), paths_beside("helper-1.py", "a.zip/1.ipynb")
    (['lib/bases.py'], ['helper.py'])
    >>> paths_beside("code.zip/helper.py", "01.ipynb"), paths_beside("a/wind-1.csv", "01.ipynb")
    (['helper.py'], ['a/wind-1.csv', 'a/wind.csv', 'wind-1.csv', 'wind.csv'])
    """
    folder = notebook.rpartition("/")[0]
    inside = name.startswith(f"{folder}/") if folder else True
    path = PurePosixPath(IN_ZIP.sub("", name[len(folder) :] if inside else name).lstrip("/"))
    if not path.parts:
        return []
    *folders, last = path.parts if inside else path.parts[-1:]
    stem, ending = TRAILING_NUMBER.sub("", path.stem), path.suffix
    if ending.lower() == ".py":
        stem = path.stem if path.stem.isidentifier() else stem
        is_module = all(part.isidentifier() for part in (*folders, stem))
        return ["/".join((*folders, f"{stem}.py"))] if is_module else []
    if ending.lower() in NO_HELPERS or not all(map(_is_plain, path.parts)):
        return []
    below = (folders, []) if len(folders) <= MOST_FOLDERS else ([],)
    paths = ("/".join((*f, n)) for f in below for n in (last, f"{stem}{ending}"))
    return list(dict.fromkeys(paths))


def _is_plain(part: str) -> bool:
    """Whether a part of a path names a file or a folder, and leads nowhere else."""
    return part not in ("", ".", "..") and part.isprintable() and len(part.encode()) <= LONGEST_NAME
