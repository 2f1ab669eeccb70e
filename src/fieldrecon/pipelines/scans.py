"""From a scan, points on the surface of a body, to a closed mesh of the surface.

The steps: read the cloud, fit an implicit function to its points (or to its loose triangles),
extract the mesh of the zeros, and measure the distances of the points from it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.spatial import cKDTree

from fieldrecon._core import validation as valid
from fieldrecon._core.atomic_files import write_atomically
from fieldrecon._core.chunks import Stages, silent
from fieldrecon._core.geometry import triangle_normals
from fieldrecon.io.clouds import Cloud, as_cloud
from fieldrecon.io.frames import as_source
from fieldrecon.io.meshes import write_triangles
from fieldrecon.pages.surface_page import picture, surface_page
from fieldrecon.pipelines.samples import read_samples
from fieldrecon.solids.marching_cubes import ExtractedSurface, extract_surface
from fieldrecon.surfaces.implicit_surfaces import ImplicitSurface, implicit_surface
from fieldrecon.surfaces.level_sets import LevelSet
from fieldrecon.surfaces.polygon_soup import PolygonSoupSolid
from fieldrecon.triangles.audit import in_words
from fieldrecon.triangles.distances import distances_to_triangles

if TYPE_CHECKING:
    from matplotlib.figure import Figure

GAP = 3.0
"""Distance from the nearest point, in spacings of the points, beyond which a surface is unknown."""
_FLAT = 1e-9


@dataclass(frozen=True, eq=False)
class ScanResult:
    """A surface through the points of a scan, with its warnings.

    Parameters
    ----------
    cloud : Cloud
        As read from the file.
    center : (3,) ndarray
        Coordinates of the cloud are coordinates of the body and its mesh plus this vector.
    body : ImplicitSurface, PolygonSoupSolid or LevelSet
    mesh : ExtractedSurface
    distances : (n,) ndarray
        Distances of the points of the body from the triangles.
    gaps : (t,) ndarray of bool
        The triangles that are farther than GAP spacings from all points.
    own_normals : bool
        Whether the cloud came with its normals.
    source : str
        Name of the file, or what the data were.
    """

    cloud: Cloud
    center: np.ndarray
    body: ImplicitSurface | PolygonSoupSolid | LevelSet
    mesh: ExtractedSurface
    distances: np.ndarray
    gaps: np.ndarray
    own_normals: bool
    source: str

    def __repr__(self) -> str:
        state = "sound" if self.sound(open_allowed=False) else "with errors or a boundary"
        return (
            f"<ScanResult: {len(self.mesh.triangles)} triangles from {self.sources} of "
            f"{self.source}, {state}>"
        )

    def write(self, path: str | Path) -> Path:
        """Write the mesh, in the coordinates of the cloud; the suffix names the format.

        Parameters
        ----------
        path : str or pathlib.Path
            ``.ply``, ``.stl``, ``.obj`` or ``.off``; all but ``.stl`` take the extra ``mesh``.
        """
        write_triangles(Path(path), self.points, self.mesh.triangles)
        return Path(path)

    def plot(self, up: str = "z") -> Figure:
        """Draw the surface from two sides; it is coloured where it is far from all points.

        Parameters
        ----------
        up : "x", "y" or "z"
            The axis that points up.

        Raises
        ------
        ModuleNotFoundError
            If the packages that draw are not installed: with the extra that provides them.
        """
        return picture(self, up)

    def report(self, path: str | Path, parameters: Mapping[str, Any] | None = None) -> Path:
        """Write a page of HTML with the picture, the distances of the points and the warnings.

        Parameters
        ----------
        path : str or pathlib.Path
        parameters : mapping, optional
            Parameters for the table at its end.
        """
        page = surface_page(self, self.warnings, parameters or {})
        return write_atomically(Path(path), page.encode())

    @property
    def far(self) -> float:
        """Distance from all points beyond which the surface is unknown."""
        return GAP * self.body.spacing

    @property
    def points(self) -> np.ndarray:
        """Vertices of the mesh, in the coordinates of the cloud."""
        return self.mesh.points + self.center

    @property
    def triangles(self) -> np.ndarray:
        """Triangles between these points."""
        return self.mesh.triangles

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
        if isinstance(self.body, LevelSet):
            crossings = f"{len(self.body.points):,} crossings of the level"
            return f"{crossings} between {self.body.samples:,} samples"
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
        if not isinstance(self.body, ImplicitSurface):
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
                f"{_percent(invented)} of the surface is farther than {self.far:.3g}"
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


def surface(
    data: Any,
    *,
    level: float | None = None,
    value: str | None = None,
    normals: Any = "file",
    smoothing: float | None = None,
    polygons: float | None = None,
    edge: float | None = None,
    open: float | None = None,
    stages: Stages = silent,
) -> ScanResult:
    """Fit a body to a scan, and triangles to its surface.

    Parameters
    ----------
    data : path, (n, 3) array_like, Cloud, or a table in memory
        A file that `fieldrecon.io.read_cloud` reads, points, or a data frame or mapping with
        columns x, y, z and perhaps nx, ny, nz.
    level : float, optional
        The data are samples of a scalar, such as signed distances, in a table with x, y, z and the
        value; the surface is where it has this value. The body is on the side that fewer of the
        outermost samples have.
    value : str, optional
        With `level`, the column of the scalar; usual names are recognized.
    normals : "file", "estimate" or (n, 3) array_like
        Those of the data or of their triangles, if there are any; those estimated from the points
        alone; or these.
    smoothing : float, optional
        As for `fieldrecon.implicit_surface`: a length.
    polygons : float, optional
        Take the triangles of the file for loose polygons, with this length as the `epsilon` of
        `fieldrecon.surfaces.PolygonSoup`: 0 interpolates them, more encloses them.
    edge : float, optional
        Length of the edges of the mesh, as for `fieldrecon.extract_surface`.
    open : float, optional
        Leave out the surface farther than this length from all points, instead of closing it.
    stages : callable, optional
        Opens a stage of the work by its name, and returns its progress(done, total).

    Returns
    -------
    ScanResult

    Raises
    ------
    ValueError, numpy.linalg.LinAlgError
        If the data cannot be read, or no surface goes through the points.
    ImportError
        If scikit-image is not installed, or meshio for a format that takes it.
    """
    stages("reading")
    if level is not None:
        if smoothing is not None or polygons is not None:
            raise ValueError("level is for samples of a scalar, not for points or polygons")
        samples = read_samples(as_source(data), value=value, in_space=True)
        warnings = tuple(samples.warnings)
        cloud = Cloud(samples.points, None, np.empty((0, 3), dtype=np.intp), warnings)
    elif value is not None:
        raise ValueError("value is for samples of a scalar: give level as well")
    else:
        samples, cloud = None, _with_normals(as_cloud(data), normals)
    # far from the origin, squares of coordinates would lose digits
    center = (cloud.points.min(axis=0) + cloud.points.max(axis=0)) / 2
    body: ImplicitSurface | PolygonSoupSolid | LevelSet
    if samples is not None and level is not None:
        stages("fitting the scalar")
        body, spacing = LevelSet(cloud.points - center, samples.values, level), edge
    elif polygons is None:
        body = _fit_points(cloud, center, smoothing, stages)
        spacing = edge
    else:
        if smoothing is not None:
            raise ValueError("smoothing is for points; polygons says how smooth polygons are")
        body = _enclose_triangles(cloud, center, polygons, edge, stages)
        spacing = None
    progress = stages("following the surface")
    mesh = extract_surface(body, spacing, within=open, progress=progress)
    progress = stages("distances of the points")
    distances = distances_to_triangles(body.points, mesh.points, mesh.triangles, progress=progress)
    stages("looking for gaps and errors")
    away = cKDTree(body.points).query(mesh.points[mesh.triangles].mean(axis=1))[0]
    gaps = away > GAP * body.spacing
    own_normals = isinstance(body, ImplicitSurface) and cloud.normals is not None
    source = Path(data).name if isinstance(data, str | Path) else "points in memory"
    result = ScanResult(cloud, center, body, mesh, distances, gaps, own_normals, source)
    _ = result.mesh.audit  # computed in this stage, and cached
    return result


def _with_normals(cloud: Cloud, normals: Any) -> Cloud:
    """The cloud with the normals that were asked for."""
    if not isinstance(normals, str):
        given = valid.as_values(normals, len(cloud.points), "normals")
        if given.shape != cloud.points.shape:
            raise ValueError(f"normals must have the shape (n, 3); got {given.shape}")
        return replace(cloud, normals=given, normals_of="argument")
    if normals not in ("file", "estimate"):
        raise ValueError(f"normals must be 'file', 'estimate' or an array; got {normals!r}")
    return cloud if normals == "file" else replace(cloud, normals=None)


def _fit_points(
    cloud: Cloud, center: np.ndarray, smoothing: float | None, stages: Stages
) -> ImplicitSurface:
    points, normals = cloud.points - center, cloud.normals
    _refuse_flat(points)
    if normals is not None:
        known = normals.any(axis=1)
        points, normals = points[known], normals[known]
    progress = stages("normals, and the field")
    return implicit_surface(points, normals, smoothing=smoothing, progress=progress)


def _enclose_triangles(
    cloud: Cloud, center: np.ndarray, epsilon: float, edge: float | None, stages: Stages
) -> PolygonSoupSolid:
    epsilon = valid.as_length(epsilon, "polygons", zero_allowed=True)
    if not len(cloud.triangles):
        raise ValueError("the file holds no triangles, of which a surface could be made")
    stages("enclosing the triangles")
    return PolygonSoupSolid(cloud.points - center, cloud.triangles, epsilon, edge)


def _refuse_flat(points: np.ndarray) -> None:
    spread = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    if spread[2] <= _FLAT * spread[0]:
        raise np.linalg.LinAlgError("the points lie in one plane or line, and enclose nothing")


def _areas(mesh: ExtractedSurface) -> np.ndarray:
    a, b, c = mesh.points[mesh.triangles].swapaxes(0, 1)
    return np.linalg.norm(triangle_normals(a, b, c), axis=1)


def _percent(share: float) -> str:
    return f"{100 * share:.2g} %" if share < 0.995 else f"{100 * share:.0f} %"
