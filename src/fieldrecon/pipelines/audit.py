"""From a mesh of triangles in a file to a list of its errors, and to a repaired mesh."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fieldrecon._core import validation as valid
from fieldrecon._core.chunks import Stages, silent
from fieldrecon.io.meshes import read_triangles
from fieldrecon.triangles.audit import MeshAudit, audit_mesh
from fieldrecon.triangles.repair import MeshRepair, repair_mesh


@dataclass(frozen=True)
class AuditRequest:
    """Which mesh to audit, and whether to repair it.

    Parameters
    ----------
    mesh : Path
        A file that `fieldrecon.io.read_triangles` reads.
    tolerance : float, optional
        As for `fieldrecon.audit_mesh`.
    repair : bool
        Whether to repair the mesh.
    largest_hole : float
        As for `fieldrecon.repair_mesh`.
    """

    mesh: Path
    tolerance: float | None = None
    repair: bool = False
    largest_hole: float = 0.1


@dataclass(frozen=True, eq=False)
class AuditResult:
    """The errors of a mesh, and its repair.

    Parameters
    ----------
    points : (n, 3) ndarray
    triangles : (m, 3) ndarray
        The mesh as read from the file.
    audit : MeshAudit
        Its errors.
    repair : MeshRepair, optional
        The repaired mesh, if it was requested.
    """

    points: np.ndarray
    triangles: np.ndarray
    audit: MeshAudit
    repair: MeshRepair | None

    @property
    def final(self) -> MeshAudit:
        """The errors of the repaired mesh, or of the mesh if it was not repaired."""
        return self.audit if self.repair is None else self.repair.after

    def sound(self, open_allowed: bool) -> bool:
        """Whether no errors are left; a boundary is not an error if it is allowed."""
        allowed = {"boundary_loops"} if open_allowed else set()
        return {*self.final.found} <= allowed


def audit_file(request: AuditRequest, *, stages: Stages = silent) -> AuditResult:
    """Find the errors of a mesh in a file, and repair them if requested.

    Parameters
    ----------
    request : AuditRequest
    stages : callable, optional
        Opens a stage of the work by its name, and returns its progress(done, total).

    Raises
    ------
    ValueError
        If the file cannot be read as triangles, or an argument is invalid.
    FileNotFoundError
        If there is no such file.
    """
    if request.tolerance is not None:
        valid.as_length(request.tolerance, "tolerance", zero_allowed=True)
    points, triangles = read_triangles(request.mesh)
    progress = stages("looking for self-intersections")
    if not request.repair:
        audit = audit_mesh(points, triangles, request.tolerance, progress=progress)
        return AuditResult(points, triangles, audit, None)
    repair = repair_mesh(
        points, triangles, request.tolerance, request.largest_hole, progress=progress
    )
    return AuditResult(points, triangles, repair.before, repair)
