"""Folders with names, addresses and grades, which git must not commit."""

from __future__ import annotations

from pathlib import Path

from fieldrecon._core.atomic_files import write_atomically

IGNORED = "# Names, addresses and grades of students: git ignores this folder.\n*\n"


def keep_out_of_git(folder: Path) -> None:
    """Write a ``.gitignore`` to a folder inside a git repository, unless it has one.

    The folder is created if it is missing. Outside of a repository nothing is written.
    """
    file, here = folder / ".gitignore", folder.resolve()
    is_inside = any((parent / ".git").exists() for parent in (here, *here.parents))
    if is_inside and not file.exists():
        write_atomically(file, IGNORED.encode())
