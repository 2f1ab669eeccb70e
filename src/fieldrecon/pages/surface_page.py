"""The page of ``fieldrecon surface``: the mesh of a scan, and the distances of its points."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from fieldrecon._core.extras import PICTURES, absent, require
from fieldrecon.pages.one_page import fill, page, pairs
from fieldrecon.plotting.figure_files import figure_bytes

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from fieldrecon.pipelines.scans import ScanResult

UP = {"x": (1, 0, 0), "y": (0, 1, 0), "z": (0, 0, 1)}
"""Directions that may point up in the picture."""


def picture(scan: ScanResult, up: str = "z") -> Figure:
    """Draw the surface from two sides.

    Raises
    ------
    ModuleNotFoundError
        If the packages that draw are not installed: with the extra that provides them.
    ValueError
        If there is no such axis.
    """
    if up not in UP:
        raise ValueError(f"up must be one of {', '.join(UP)}; got {up!r}")
    require(*PICTURES)
    from fieldrecon.plotting.surface_picture import plot

    return plot(scan, UP[up])


def surface_page(
    scan: ScanResult,
    warnings: Sequence[str],
    parameters: Mapping[str, Any],
    drawn: bytes | None = None,
) -> str:
    """Return the HTML of the page; without a picture if the packages that draw are missing.

    Parameters
    ----------
    scan : ScanResult
    warnings : sequence of str
    parameters : mapping
    drawn : bytes, optional
        The picture as PNG, if it is drawn already.
    """
    if drawn is None and not absent(*PICTURES):
        drawn = figure_bytes(picture(scan), "png")
    distances = pairs({what: f"{d:.3g}" for what, d in scan.quality.items()})
    return page(
        f"{scan.source}, as a surface",
        f"From {scan.sources} of {scan.source}.",
        {"The surface, from two sides": drawn} if drawn else {},
        warnings,
        fill("<h2>Distances of the points from the mesh</h2>$distances", distances=distances),
        parameters,
    )
