"""Stages of long work, by which a pipeline reports what it does and how far it is."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

from fieldrecon._core.chunks import Progress

Stages: TypeAlias = Callable[[str], Progress]
"""Opens a stage of the work by its name, and returns the progress of the stage."""


def silent(_name: str) -> Progress:
    """Open a stage that nobody sees."""
    return lambda *_: None
