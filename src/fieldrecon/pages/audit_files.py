"""The files of an audit: what is wrong with a mesh, as JSON, and a picture of it."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from fieldrecon._core.atomic_files import write_atomically
from fieldrecon._core.extras import PICTURES, absent
from fieldrecon.plotting.figure_files import write_figure
from fieldrecon.triangles.audit import MeshAudit

PICTURE_FORMATS = ("png", "svg")


def write_audit(
    folder: Path, audit: MeshAudit, points: np.ndarray, triangles: np.ndarray
) -> list[Path]:
    """Write ``audit.json``, and the picture if the packages that draw are there; return them."""
    text = json.dumps(audit.as_dict(), indent=1) + "\n"
    findings = write_atomically(folder / "audit.json", text.encode())
    if absent(*PICTURES):
        return [findings]
    from fieldrecon.plotting.audit_picture import plot

    picture = plot(audit, points, triangles)
    return [findings, *write_figure(picture, folder / "audit", PICTURE_FORMATS)]
