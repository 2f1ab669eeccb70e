"""From a mesh of triangles to a list of its errors, and to a repaired mesh."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fieldrecon._core import validation as valid
from fieldrecon._core.atomic_files import write_atomically
from fieldrecon._core.chunks import Stages, silent
from fieldrecon.io.meshes import read_triangles, write_triangles
from fieldrecon.pages.audit_page import audit_page, picture
from fieldrecon.pipelines.repair_remarks import remarks
from fieldrecon.triangles.audit import MeshAudit, audit_mesh
from fieldrecon.triangles.repair import MeshRepair, repair_mesh

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True, eq=False)
class AuditResult:
    """The errors of a mesh, and its repair.

    Parameters
    ----------
    points : (n, 3) ndarray
    triangles : (m, 3) ndarray
        The mesh that was audited.
    audit : MeshAudit
        Its errors.
    repair : MeshRepair, optional
        The repaired mesh, if it was requested.
    source : str
        Name of the file, or what the data were.
    remarks : tuple of str
        Why errors remain after the repair, and which option helps, in sentences.
    """

    points: np.ndarray
    triangles: np.ndarray
    audit: MeshAudit
    repair: MeshRepair | None
    source: str
    remarks: tuple[str, ...] = ()

    def __repr__(self) -> str:
        found = ", ".join(f"{n} {kind}" for kind, n in self.findings.items()) or "no errors"
        after = "" if self.repair is None else f"; repaired, {sum(self.final.found.values())} left"
        return f"<AuditResult: {self.source}, {len(self.triangles)} triangles, {found}{after}>"

    @property
    def findings(self) -> dict[str, int]:
        """Number of errors of each kind that occurs; `audit` has their indices."""
        return self.audit.found

    @property
    def final(self) -> MeshAudit:
        """The errors of the repaired mesh, or of the mesh if it was not repaired."""
        return self.audit if self.repair is None else self.repair.after

    @property
    def mesh(self) -> tuple[np.ndarray, np.ndarray]:
        """Points and triangles of the repaired mesh, or of the mesh if it was not repaired."""
        if self.repair is None:
            return self.points, self.triangles
        return self.repair.points, self.repair.triangles

    def sound(self, open_allowed: bool = False) -> bool:
        """Whether no errors are left; a boundary is not an error if it is allowed."""
        allowed = {"boundary_loops"} if open_allowed else set()
        return {*self.final.found} <= allowed

    def write(self, path: str | Path) -> Path:
        """Write the repaired mesh, or the mesh if it was not repaired.

        Parameters
        ----------
        path : str or pathlib.Path
            ``.stl``, ``.ply``, ``.obj`` or ``.off``; all but ``.stl`` take the extra ``mesh``.
        """
        write_triangles(Path(path), *self.mesh)
        return Path(path)

    def plot(self) -> Figure:
        """Draw the mesh from two sides with each error marked.

        Raises
        ------
        ModuleNotFoundError
            If the packages that draw are not installed: with the extra that provides them.
        """
        return picture(self)

    def report(self, path: str | Path, parameters: Mapping[str, Any] | None = None) -> Path:
        """Write a page of HTML with the picture and the errors.

        Parameters
        ----------
        path : str or pathlib.Path
        parameters : mapping, optional
            Parameters for the table at its end.
        """
        return write_atomically(Path(path), audit_page(self, parameters or {}).encode())


def audit(
    data: Any,
    *,
    tolerance: float | None = None,
    triangulate: bool = False,
    repair: bool = False,
    largest_hole: float = 0.1,
    stages: Stages = silent,
) -> AuditResult:
    """Find the errors of a mesh, and repair them if requested.

    Parameters
    ----------
    data : path, pair of arrays, or mesh
        A file that `fieldrecon.io.read_triangles` reads; points (n, 3) and triangles (m, 3); or an
        object that has them as `points` and `triangles`, such as the result of
        `fieldrecon.extract_surface`, or as `vertices` and `faces`, as in trimesh.
    tolerance : float, optional
        As for `fieldrecon.audit_mesh`.
    triangulate : bool
        Whether to divide quads and polygons of a file into triangles, instead of refusing them.
    repair : bool
        Whether to repair the mesh.
    largest_hole : float
        As for `fieldrecon.repair_mesh`.
    stages : callable, optional
        Opens a stage of the work by its name, and returns its progress(done, total).

    Returns
    -------
    AuditResult

    Raises
    ------
    ValueError
        If the data cannot be read as triangles, or an argument is invalid.
    FileNotFoundError
        If there is no such file.
    TypeError
        If the data are of no known kind.

    Examples
    --------
    >>> points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    >>> found = audit((points, [[0, 2, 1], [0, 1, 3], [1, 2, 3]]), repair=True, largest_hole=1)
    >>> found.findings, found.sound()
    ({'boundary_loops': 1}, True)
    """
    if tolerance is not None:
        valid.as_length(tolerance, "tolerance", zero_allowed=True)
    points, triangles, source = _triangles_of(data, triangulate)
    progress = stages("looking for self-intersections")
    if not repair:
        found = audit_mesh(points, triangles, tolerance, progress=progress)
        return AuditResult(points, triangles, found, None, source)
    repaired = repair_mesh(points, triangles, tolerance, largest_hole, progress=progress)
    stages("looking for reasons of what remains")
    why = remarks(repaired.points, repaired.triangles, repaired.after, largest_hole)
    return AuditResult(points, triangles, repaired.before, repaired, source, tuple(why))


_FIELDS = (("points", "triangles"), ("vertices", "faces"))


def _triangles_of(data: Any, triangulate: bool) -> tuple[np.ndarray, np.ndarray, str]:
    """Points and triangles, and what they come from."""
    if isinstance(data, str | Path):
        return *read_triangles(Path(data), triangulate=triangulate), Path(data).name
    for names in _FIELDS:
        if all(hasattr(data, name) for name in names):
            return *_arrays(names, [getattr(data, name) for name in names]), "mesh"
    if isinstance(data, tuple | list) and len(data) == 2:
        return *_arrays(_FIELDS[0], data), "mesh"
    raise TypeError(
        "data must be a path, a pair of points and triangles, or a mesh that has them; got "
        f"{type(data).__name__}"
    )


def _arrays(names: Sequence[str], given: Sequence[Any]) -> tuple[np.ndarray, np.ndarray]:
    """Two arrays, refused by their names if an entry is masked."""
    first, second = (np.asarray(valid.unmasked(a, n)) for n, a in zip(names, given, strict=True))
    return first, second
