"""Files that a submission writes: their folders are created, and none of them is missing.

A notebook writes figures into a folder that lies beside it on the student's machine, and that
nobody submits since nothing in it is needed.
"""

from __future__ import annotations

import os
from contextlib import suppress
from typing import Any

HERE = -1
"""Stands for the current folder where Python permits another one."""


class WrittenFiles:
    """A hook of Python that is called before a file is opened, or a folder created.

    Parameters
    ----------
    home : str
        The folder of the notebook. Folders are created only in it.
    """

    def __init__(self, home: str) -> None:
        self.home = home
        self.names: set[str] = set()

    def __call__(self, event: str, arguments: tuple[Any, ...]) -> None:
        """Note the name of what is created, and create the folders above it."""
        if event == "open":
            name, _, flags = arguments
            creates = isinstance(flags, int) and flags & os.O_CREAT
        elif event == "os.mkdir":
            name, _, folder = arguments
            creates = folder == HERE
        else:
            return
        if creates and isinstance(name, str):
            self.names.add(name)
            with suppress(Exception):  # then the submission has the error itself
                self._create_folder(os.path.dirname(os.path.abspath(name)))  # noqa: PTH100, PTH120

    def _create_folder(self, folder: str) -> None:
        if folder.startswith(f"{self.home}/") and not os.path.isdir(folder):  # noqa: PTH112
            os.makedirs(folder, exist_ok=True)  # noqa: PTH103

    def concerned(self, error: BaseException) -> bool:
        """Whether an error concerns a file that was to be created."""
        name = getattr(error, "filename", None)
        return isinstance(name, str) and name in self.names
