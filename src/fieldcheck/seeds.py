"""Seeds of a student's own inputs, from the student, the question and a salt.

The public salt is here, so that students can check their answers. The grader uses a secret salt,
which gives inputs that nobody has seen.
"""

from __future__ import annotations

import hashlib
from pathlib import Path

PUBLIC_SALT = "fieldrecon"
EVERYBODY = ""
"""The name from which the public cases are drawn, which are the same for everybody."""
FILE = "student.txt"
"""The file beside the notebooks that holds the student's name or number."""


def seed(student: str, question: str, salt: str = PUBLIC_SALT) -> int:
    """Return the seed of a student's inputs to a question.

    Examples
    --------
    >>> seed("ada", "01.1") == seed("ada", "01.1")
    True
    >>> seed("ada", "01.1") == seed("bob", "01.1")
    False
    """
    text = "\0".join((salt, student.strip().lower(), question))
    return int.from_bytes(hashlib.sha256(text.encode()).digest()[:8], "big")


def student(folder: Path | None = None) -> str:
    """Return the first line of ``student.txt`` that is not a comment; empty if there is none."""
    file = (Path.cwd() if folder is None else folder) / FILE
    lines = file.read_text(encoding="utf-8").splitlines() if file.is_file() else []
    stripped = (line.strip() for line in lines)
    return next((line for line in stripped if line and not line.startswith("#")), EVERYBODY)
