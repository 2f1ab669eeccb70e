"""The example class: what five students submitted, and the tables of their class."""

from __future__ import annotations

import shutil
from importlib.resources import as_file, files
from pathlib import Path

NAME = "example_class"


def write_example_class(folder: Path) -> tuple[Path, Path]:
    """Copy the example class to a new folder; return the folders of submissions and of tables.

    Raises
    ------
    ValueError
        The folder is not empty, or it is a file. Nothing is overwritten.
    """
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise ValueError(f"{folder} exists and is not empty: name a new folder")
    with as_file(files(__package__) / NAME) as source:
        # Without the times of the package's files: the copies were received now.
        shutil.copytree(
            source,
            folder,
            copy_function=shutil.copyfile,
            ignore=shutil.ignore_patterns("__pycache__"),
            dirs_exist_ok=True,
        )
    return folder / "submissions", folder / "class"
