"""SHA-256 digests of bytes, files and plain data: by them results are found again."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import Any


def bytes_digest(content: bytes) -> str:
    """Return the SHA-256 of bytes, in hexadecimal."""
    return hashlib.sha256(content).hexdigest()


def file_digest(path: Path) -> str:
    """Return the SHA-256 of a file's content."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def json_digest(*values: Any) -> str:
    """Return the SHA-256 of values, written as JSON with sorted keys.

    Examples
    --------
    >>> json_digest({"a": 1, "b": 2}) == json_digest({"b": 2, "a": 1})
    True
    >>> json_digest("ada", 1) == json_digest("ada", 2)
    False
    """
    return bytes_digest(json.dumps(values, sort_keys=True).encode())
