"""From a scan, points on the surface of a body, to a closed mesh of the surface.

The steps: read the cloud, fit an implicit function to its points (or to its loose triangles),
extract the mesh of the zeros, and measure the distances of the points from it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

from fieldrecon._core.chunks import Stages, silent
from fieldrecon._core.geometry import triangle_normals
from fieldrecon._core.validation import as_length
from fieldrecon.io.clouds import Cloud, read_cloud
from fieldrecon.solids.marching_cubes import ExtractedSurface, extract_surface
from fieldrecon.surfaces.implicit_surfaces import ImplicitSurface, implicit_surface
from fieldrecon.surfaces.polygon_soup import PolygonSoupSolid
from fieldrecon.triangles.audit import in_words
from fieldrecon.triangles.distances import distances_to_triangles

GAP = 3.0
"""Distance from the nearest point, in spacings of the points, beyond which a surface is unknown."""
_FLAT = 1e-9


@dataclass(frozen=True)
class ScanRequest:
    """Which scan to reconstruct, and how.

    Parameters
    ----------
    cloud : Path
        A file that `fieldrecon.io.read_cloud` reads.
    own_normals : bool
        Use the normals of the file or of its triangles, if there are any.
    smoothing : float, optional
        As for `fieldrecon.implicit_surface`: a length.
    polygons : float, optional
        Take the triangles of the file for loose polygons, with this length as the `epsilon` of
        `fieldrecon.surfaces.PolygonSoup`: 0 interpolates them, more encloses them.
    edge : float, optional
        Length of the edges of the mesh, as for `fieldrecon.extract_surface`.
    open : float, optional
        Leave out the surface farther than this length from all points, instead of closing it.
    """

    cloud: Path
    own_normals: bool = True
    smoothing: float | None = None
    polygons: float | None = None
    edge: float | None = None
    open: float | None = None


@dataclass(frozen=True, eq=False)
class ScanResult:
    """A surface through the points of a scan, with its warnings.

    Parameters
    ----------
    cloud : Cloud
        As read from the file.
    center : (3,) ndarray
        The coordinates of the cloud are those of the body and its mesh plus this vector.
    body : ImplicitSurface or PolygonSoupSolid
    mesh : ExtractedSurface
    distances : (n,) ndarray
        Distances of the points of the body from the triangles.
    gaps : (t,) ndarray of bool
        The triangles that are farther than GAP spacings from all points.
    own_normals : bool
        Whether the normals are those of the cloud.
    """

    cloud: Cloud
    center: np.ndarray
    body: ImplicitSurface | PolygonSoupSolid
    mesh: ExtractedSurface
    distances: np.ndarray
    gaps: np.ndarray
    own_normals: bool

    @property
    def points(self) -> np.ndarray:
        """Vertices of the mesh, in the coordinates of the cloud."""
        return self.mesh.points + self.center

    @property
    def errors(self) -> list[str]:
        """The errors of the mesh, in words."""
        counts = self.mesh.audit.counts.values()
        return [in_words(kind, n) for kinds in counts for kind, n in kinds.items() if n]

    def sound(self, open_allowed: bool) -> bool:
        """Whether the mesh has no errors, is not cut off, and is near every point.

        A boundary is not an error if it is allowed.
        """
        allowed = {"boundary_loops"} if open_allowed else set()
        cut_off = len(self.mesh.cut) > 0 and not open_allowed
        return {*self.mesh.audit.found} <= allowed and not cut_off and not len(self.mesh.missed)

    @property
    def sources(self) -> str:
        """What the surface was fitted to, in words."""
        if isinstance(self.body, PolygonSoupSolid):
            return f"{len(self.body.points):,} points on {len(self.cloud.triangles):,} triangles"
        return f"{len(self.body.points):,} of {len(self.cloud.points):,} points"

    @property
    def quality(self) -> dict[str, float]:
        """Distances of the points from the mesh."""
        d = self.distances
        return {
            "root mean square": float(np.sqrt(np.mean(d**2))),
            "half of the points, less than": float(np.median(d)),
            "95 of 100, less than": float(np.quantile(d, 0.95)),
            "largest": float(d.max()),
        }

    @property
    def warnings(self) -> list[str]:
        """What a reader of the mesh has to know, in sentences."""
        if isinstance(self.body, PolygonSoupSolid):
            return [*self.cloud.warnings, *self.body.warnings, *self._mesh_warnings()]
        source = f"those of the {self.cloud.normals_of}" if self.own_normals else "estimated"
        normals = f"The normals are {source}."
        spacing = f"The median spacing of the points is {self.body.spacing:.3g}."
        return [
            *self.cloud.warnings,
            normals,
            spacing,
            *self.body.warnings,
            *self._mesh_warnings(),
        ]

    def _mesh_warnings(self) -> Iterator[str]:
        mesh = self.mesh
        area = _areas(mesh)
        if invented := area[self.gaps].sum() / area.sum():
            yield (
                f"{_percent(invented)} of the surface is farther than {GAP * self.body.spacing:.3g}"
                " from all points: there is a hole in the scan, and the surface is invented."
            )
        if mesh.audit.parts > 1:
            yield f"The mesh has {mesh.audit.parts:,} parts, which are not connected."
        if count := len(mesh.missed):
            points = "point has" if count == 1 else "points have"
            yield f"{count:,} {points} no surface nearby; the body may be too thin there."
        if count := len(mesh.cut):
            yield f"The surface extends beyond the points and was cut off, at {count:,} vertices."
        state = "closed" if not len(mesh.audit.boundary_loops) else "open"
        errors = f"; found: {', '.join(self.errors)}" if self.errors else ""
        yield (
            f"The mesh has {len(mesh.triangles):,} triangles and {len(mesh.points):,} vertices, "
            f"and is {state}{errors}."
        )
        yield f"It encloses a volume of {mesh.volume:.5g} in an area of {mesh.area:.5g}."


def reconstruct_scan(request: ScanRequest, *, stages: Stages = silent) -> ScanResult:
    """Fit a body to a scan, and triangles to its surface.

    Parameters
    ----------
    request : ScanRequest
    stages : callable, optional
        Opens a stage of the work by its name, and returns its progress(done, total).

    Raises
    ------
    ValueError, numpy.linalg.LinAlgError
        If the file cannot be read, or no surface goes through the points.
    ImportError
        If scikit-image is not installed, or meshio for a format that takes it.
    """
    stages("reading")
    cloud = read_cloud(request.cloud)
    # far from the origin, squares of coordinates would lose digits
    center = (cloud.points.min(axis=0) + cloud.points.max(axis=0)) / 2
    body: ImplicitSurface | PolygonSoupSolid
    if request.polygons is None:
        body = _fit_points(cloud, center, request, stages)
        spacing = request.edge
    else:
        body = _enclose_triangles(cloud, center, request, request.polygons, stages)
        spacing = None
    progress = stages("following the surface")
    mesh = extract_surface(body, spacing, within=request.open, progress=progress)
    progress = stages("distances of the points")
    distances = distances_to_triangles(body.points, mesh.points, mesh.triangles, progress=progress)
    stages("looking for gaps and errors")
    away = cKDTree(body.points).query(mesh.points[mesh.triangles].mean(axis=1))[0]
    gaps = away > GAP * body.spacing
    own_normals = request.polygons is None and request.own_normals and cloud.normals is not None
    result = ScanResult(cloud, center, body, mesh, distances, gaps, own_normals)
    _ = result.mesh.audit  # computed in this stage, and cached
    return result


def _fit_points(
    cloud: Cloud, center: np.ndarray, request: ScanRequest, stages: Stages
) -> ImplicitSurface:
    points, normals = cloud.points - center, cloud.normals if request.own_normals else None
    _refuse_flat(points)
    if normals is not None:
        known = normals.any(axis=1)
        points, normals = points[known], normals[known]
    progress = stages("normals, and the field")
    return implicit_surface(points, normals, smoothing=request.smoothing, progress=progress)


def _enclose_triangles(
    cloud: Cloud, center: np.ndarray, request: ScanRequest, epsilon: float, stages: Stages
) -> PolygonSoupSolid:
    if request.smoothing is not None:
        raise ValueError("--smoothing is for points; --polygons says how smooth polygons are")
    epsilon = as_length(epsilon, "--polygons", zero_allowed=True)
    if not len(cloud.triangles):
        raise ValueError("the file holds no triangles, of which a surface could be made")
    stages("enclosing the triangles")
    return PolygonSoupSolid(cloud.points - center, cloud.triangles, epsilon, request.edge)


def _refuse_flat(points: np.ndarray) -> None:
    spread = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    if spread[2] <= _FLAT * spread[0]:
        raise np.linalg.LinAlgError("the points lie in one plane or line, and enclose nothing")


def _areas(mesh: ExtractedSurface) -> np.ndarray:
    a, b, c = mesh.points[mesh.triangles].swapaxes(0, 1)
    return np.linalg.norm(triangle_normals(a, b, c), axis=1)


def _percent(share: float) -> str:
    return f"{100 * share:.2g} %" if share < 0.995 else f"{100 * share:.0f} %"
