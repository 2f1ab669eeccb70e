"""One page about a scan, complete in itself: the surface, and how far its points are from it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from fieldrecon.pages.one_page import page, pairs
from fieldrecon.pipelines.scan import Scan


def surface_page(
    name: str, scan: Scan, picture: bytes, remarks: Sequence[str], parameters: Mapping[str, Any]
) -> str:
    """HTML of a page about a scan, complete in itself; without a picture where that is empty."""
    rows = pairs({what: f"{d:.3g}" for what, d in scan.quality.items()})
    return page(
        f"{name}, as a surface",
        f"From {scan.counted} of {name}.",
        {"The surface, lit by the gradient of its field": picture} if picture else {},
        remarks,
        "<h2>How far these are from the mesh</h2>"
        f'<div class="scroll"><table><tbody>{rows}</tbody></table></div>',
        parameters,
    )
