"""Figures as files: SVG, PDF and PNG, the same bytes each time."""

from __future__ import annotations

import io
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from fieldrecon._core.atomic_files import write_atomically

FIGURE_FORMATS = ("svg", "pdf", "png")


def write_figure(figure: Any, stem: Path, formats: Iterable[str] = FIGURE_FORMATS) -> list[Path]:
    """Write one figure as ``STEM.svg``, ``STEM.pdf`` and ``STEM.png``, the same bytes each time."""
    return [
        write_atomically(stem.with_name(f"{stem.name}.{kind}"), figure_bytes(figure, kind))
        for kind in formats
    ]


def figure_bytes(figure: Any, kind: str) -> bytes:
    """Return the figure as SVG, PDF or PNG; figures of the report's style carry no date."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format=kind)
    return buffer.getvalue()
