"""Suppress warnings: the filter belongs to the process, so one thread at a time."""

from __future__ import annotations

import threading
import warnings
from collections.abc import Iterator
from contextlib import contextmanager

LOCK = threading.RLock()


@contextmanager
def suppress_warnings() -> Iterator[None]:
    """Neither show warnings nor turn them into errors in this block."""
    with LOCK, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield
