"""A body from a scan: what came of it, and what its reader should know, in sentences."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from fieldrecon._core.chunks import Progress
from fieldrecon.io.clouds import Cloud
from fieldrecon.solids.marching_cubes import ExtractedSurface, extract_surface
from fieldrecon.surfaces.implicit_surfaces import ImplicitSurface, implicit_surface
from fieldrecon.surfaces.polygon_soup import SoupBody
from fieldrecon.triangles.audit import in_words
from fieldrecon.triangles.distances import distances_to_triangles

GAP = 3.0
"""Spacings from the nearest point beyond which the surface is not known."""
_FLAT = 1e-9


@dataclass(frozen=True, eq=False)
class Scan:
    """A surface through the points of a scan.

    Parameters
    ----------
    cloud : Cloud
        As it was read.
    middle : (3,) ndarray
        What is added to coordinates of the body and its mesh to get those of the cloud.
    body : ImplicitSurface or SoupBody
    mesh : ExtractedSurface
    distances : (n,) ndarray
        Of the points that counted, to the triangles.
    gaps : (t,) ndarray of bool
        Triangles that are farther than GAP spacings from all points.
    told : bool
        Whether the normals are those of the cloud.
    """

    cloud: Cloud
    middle: np.ndarray
    body: ImplicitSurface | SoupBody
    mesh: ExtractedSurface
    distances: np.ndarray
    gaps: np.ndarray
    told: bool

    @property
    def points(self) -> np.ndarray:
        """Vertices of the mesh, in the coordinates of the cloud."""
        return self.mesh.points + self.middle

    @property
    def found(self) -> list[str]:
        """What is wrong with the mesh, in words; a rim is none where it was asked for."""
        counts = self.mesh.audit.counts.values()
        return [in_words(kind, n) for kinds in counts for kind, n in kinds.items() if n]

    def sound(self, rim: bool) -> bool:
        """Whether the mesh is closed and clean, goes no farther than the points, and misses none.

        Where a rim is wanted, it is none the worse for being open.
        """
        allowed = {"boundary_loops"} if rim else set()
        beyond = len(self.mesh.cut) > 0 and not rim
        return {*self.mesh.audit.found} <= allowed and not beyond and not len(self.mesh.missed)

    @property
    def counted(self) -> str:
        """What the surface was made of, in words."""
        if isinstance(self.body, SoupBody):
            return f"{len(self.body.points):,} places on {len(self.cloud.triangles):,} triangles"
        return f"{len(self.body.points):,} of {len(self.cloud.points):,} points"

    @property
    def quality(self) -> dict[str, float]:
        """Distances of the points to the mesh."""
        d = self.distances
        return {
            "root mean square": float(np.sqrt(np.mean(d**2))),
            "half of the points, less than": float(np.median(d)),
            "95 of 100, less than": float(np.quantile(d, 0.95)),
            "largest": float(d.max()),
        }

    @property
    def remarks(self) -> list[str]:
        """What a reader should know."""
        if isinstance(self.body, SoupBody):
            return [*self.cloud.remarks, *self.body.remarks, *self._of_mesh()]
        whose = f"those of the {self.cloud.normals_of}" if self.told else "estimated"
        normals = f"The normals are {whose}."
        apart = f"The points are {self.body.spacing:.3g} apart, in the median."
        return [*self.cloud.remarks, normals, apart, *self.body.remarks, *self._of_mesh()]

    def _of_mesh(self) -> Iterator[str]:
        mesh = self.mesh
        area = _areas(mesh)
        if invented := area[self.gaps].sum() / area.sum():
            yield (
                f"{_percent(invented)} of the surface is farther than {GAP * self.body.spacing:.3g}"
                " from all points: there is a hole in the scan, and the surface is invented."
            )
        if mesh.audit.parts > 1:
            yield f"The mesh has {mesh.audit.parts:,} parts that do not hang together."
        if count := len(mesh.missed):
            points = "point has" if count == 1 else "points have"
            yield f"{count:,} {points} no surface near; the sheet may be too thin there."
        if count := len(mesh.cut):
            yield f"The surface goes on beyond the points and was cut off, at {count:,} vertices."
        state = "closed" if not len(mesh.audit.boundary_loops) else "open"
        found = f"; found: {', '.join(self.found)}" if self.found else ""
        yield (
            f"The mesh has {len(mesh.triangles):,} triangles and {len(mesh.points):,} vertices, "
            f"and is {state}{found}."
        )
        yield f"It encloses a volume of {mesh.volume:.5g} in an area of {mesh.area:.5g}."


def surface_of(
    cloud: Cloud,
    stage: Callable[[str], Progress],
    *,
    own_normals: bool = True,
    smoothing: float | None = None,
    spacing: float | None = None,
    within: float | None = None,
) -> Scan:
    """Fit a body to a cloud, and triangles to its surface.

    Parameters
    ----------
    cloud : Cloud
    stage : callable
        Opens a stage of the work by its name, and gives what its progress is told to.
    own_normals : bool
        Take the normals of the cloud, where it has some.
    smoothing : float, optional
        As for `implicit_surface`.
    spacing, within : float, optional
        As for `extract_surface`.

    Raises
    ------
    ValueError, numpy.linalg.LinAlgError
        If no surface goes through the points.
    """
    # far from the origin squares of coordinates would keep few digits
    middle = (cloud.points.min(axis=0) + cloud.points.max(axis=0)) / 2
    points, normals = cloud.points - middle, cloud.normals if own_normals else None
    _refuse_flat(points)
    if normals is not None:
        told = normals.any(axis=1)
        points, normals = points[told], normals[told]
    progress = stage("normals, and the field")
    body = implicit_surface(points, normals, smoothing=smoothing, progress=progress)
    mesh = extract_surface(body, spacing, within=within, progress=stage("following the surface"))
    return _judged(cloud, middle, body, mesh, normals is not None, stage)


def surface_of_soup(
    cloud: Cloud,
    stage: Callable[[str], Progress],
    epsilon: float,
    *,
    spacing: float | None = None,
    within: float | None = None,
) -> Scan:
    """Make a body of the loose triangles of a cloud, and a mesh of its surface.

    Parameters
    ----------
    cloud : Cloud
        With triangles.
    stage, spacing, within
        As for `surface_of`.
    epsilon : float
        As for `PolygonSoup`: 0 goes through the triangles, more around them.

    Raises
    ------
    ValueError
        If there are no triangles.
    """
    if not len(cloud.triangles):
        raise ValueError("the file holds no triangles, of which a surface could be made")
    middle = (cloud.points.min(axis=0) + cloud.points.max(axis=0)) / 2
    stage("enclosing the triangles")
    body = SoupBody(cloud.points - middle, cloud.triangles, epsilon, spacing)
    mesh = extract_surface(body, within=within, progress=stage("following the surface"))
    return _judged(cloud, middle, body, mesh, False, stage)


def _judged(
    cloud: Cloud,
    middle: np.ndarray,
    body: ImplicitSurface | SoupBody,
    mesh: ExtractedSurface,
    told: bool,
    stage: Callable[[str], Progress],
) -> Scan:
    """Measure how far the points are from the mesh, and where it is invented."""
    progress = stage("distances of the points")
    distances = distances_to_triangles(body.points, mesh.points, mesh.triangles, progress)
    stage("looking for gaps and errors")
    away = cKDTree(body.points).query(mesh.points[mesh.triangles].mean(axis=1))[0]
    gaps = away > GAP * body.spacing
    scan = Scan(cloud, middle, body, mesh, distances, gaps, told)
    _ = scan.mesh.audit
    return scan


def _refuse_flat(points: np.ndarray) -> None:
    spread = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    if spread[2] <= _FLAT * spread[0]:
        raise np.linalg.LinAlgError("the points lie in one plane or line, and enclose nothing")


def _areas(mesh: ExtractedSurface) -> np.ndarray:
    a, b, c = mesh.points[mesh.triangles].swapaxes(0, 1)
    return np.linalg.norm(np.cross(b - a, c - a), axis=1)


def _percent(share: float) -> str:
    return f"{100 * share:.2g} %" if share < 0.995 else f"{100 * share:.0f} %"
