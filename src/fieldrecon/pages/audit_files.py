"""The files of ``fieldrecon audit``: the errors of a mesh as JSON, and a picture of them."""

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
    """Write ``audit.json``, and a picture if its packages are installed; return the files."""
    text = json.dumps(audit.as_dict(), indent=1) + "\n"
    findings = write_atomically(folder / "audit.json", text.encode())
    if absent(*PICTURES):
        return [findings]
    from fieldrecon.plotting.mesh_pictures import plot_audit

    picture = plot_audit(audit, points, triangles)
    return [findings, *write_figure(picture, folder / "audit", PICTURE_FORMATS)]
