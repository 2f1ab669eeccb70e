"""SHA-256 digests of bytes and of plain data: the names of archived files and of cached results."""

from __future__ import annotations

import hashlib
import json
from typing import Any


def bytes_digest(content: bytes) -> str:
    """Return the SHA-256 of bytes, in hexadecimal."""
    return hashlib.sha256(content).hexdigest()


def json_digest(*values: Any) -> str:
    """Return the SHA-256 of values, written as JSON.

    Examples
    --------
    >>> json_digest("ada", 1) == json_digest("ada", 2)
    False
    """
    return bytes_digest(json.dumps(values).encode())
