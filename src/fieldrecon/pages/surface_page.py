"""The page of ``fieldrecon surface``: the mesh of a scan, and the distances of its points."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from fieldrecon.pages.one_page import fill, page, pairs
from fieldrecon.pipelines.surface import ScanResult


def surface_page(
    name: str,
    scan: ScanResult,
    picture: bytes,
    warnings: Sequence[str],
    parameters: Mapping[str, Any],
) -> str:
    """Return the HTML of the page; without a picture if that is empty."""
    distances = pairs({what: f"{d:.3g}" for what, d in scan.quality.items()})
    return page(
        f"{name}, as a surface",
        f"From {scan.sources} of {name}.",
        {"The surface, shaded by the gradient of its field": picture} if picture else {},
        warnings,
        fill("<h2>Distances of the points from the mesh</h2>$distances", distances=distances),
        parameters,
    )
