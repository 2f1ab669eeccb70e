"""Silence for warnings, which belongs to a whole process, so to one thread at a time."""

from __future__ import annotations

import threading
import warnings
from collections.abc import Iterator
from contextlib import contextmanager

LOCK = threading.RLock()


@contextmanager
def quiet() -> Iterator[None]:
    """Let no warning be shown, nor turned into an error, until the end of the block."""
    with LOCK, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield
