"""Point clouds: scans in files of meshes of any format that is read, or in tables."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from fieldrecon._core.geometry import triangle_normals
from fieldrecon.io.column_names import bare_name
from fieldrecon.io.frames import Source, as_source, bad_row_message, numbered, read_source
from fieldrecon.io.mesh_content import MeshContent, require_vertices
from fieldrecon.io.meshes import READERS, read_content
from fieldrecon.io.tables import ColumnSpec

_MIN_POINTS = 10
_UNIT_LENGTHS = (0.9, 1.1)  # lengths at which unnamed columns are taken for normals
_NORMALS = (("nx", "ny", "nz"), ("normal_x", "normal_y", "normal_z"))


@dataclass(frozen=True, eq=False)
class Cloud:
    """Points on a surface, as read from a file.

    Parameters
    ----------
    points : ndarray of shape (n, 3)
        Finite.
    normals : ndarray of shape (n, 3), optional
        From the file, or the sums of the normals of the triangles around each point. They are
        finite, and zero where unknown.
    triangles : ndarray of shape (m, 3)
        Between the points; empty if the file has none.
    warnings : tuple of str
        What was skipped, in sentences.
    normals_of : str
        The source of the normals: "file", "triangles in the file", or a table in memory.
    """

    points: np.ndarray
    normals: np.ndarray | None
    triangles: np.ndarray
    warnings: tuple[str, ...] = ()
    normals_of: str = "file"


def read_cloud(path: str | Path) -> Cloud:
    """Read points on a surface, their normals if the file has them, and its triangles.

    Parameters
    ----------
    path : str or pathlib.Path
        .ply (text or binary, with faces, strips or neither), .obj, .stl; .vtk, .vtu, .off and
        .msh through meshio; any other suffix as a table of x, y, z and optionally nx, ny, nz, as
        `read_table` does. Equal corners of an .stl file are merged.

    Returns
    -------
    Cloud
        Points with non-finite coordinates are skipped and reported.

    Raises
    ------
    ValueError
        If the file cannot be read, or holds too few points: with its path.
    FileNotFoundError
        If there is no such file.
    ImportError
        If the format takes a package that is not installed.
    """
    path = Path(path)
    read = _cloud_of_mesh if path.suffix.lower() in READERS else _cloud_of_table
    return _checked(read(path), path)


def as_cloud(data: Any) -> Cloud:
    """A cloud as it is, or one read from a file, an array of points, or a table in memory.

    Parameters
    ----------
    data : Cloud, path, (n, 3) array_like, or a table in memory
        A table has columns x, y, z and perhaps nx, ny, nz; see `fieldrecon.io.frames.as_source`.

    Raises
    ------
    ValueError
        If it holds too few points, or none in space.
    TypeError
        If it is of no known kind.
    """
    if isinstance(data, Cloud):
        return data
    source = as_source(data)
    if isinstance(source, Path):
        return read_cloud(source)
    return _checked(replace(_cloud_of_table(source), normals_of=source.name), source)


def _checked(cloud: Cloud, source: Source) -> Cloud:
    cloud = _finite(cloud)
    if len(cloud.points) < _MIN_POINTS:
        raise ValueError(
            f"{source} holds {len(cloud.points)} points; a surface takes {_MIN_POINTS} at least"
        )
    require_vertices(source, cloud.triangles, len(cloud.points))
    return _with_normals(cloud)


def _cloud_of_mesh(path: Path) -> Cloud:
    content = read_content(path).with_merged_vertices()
    if content.points.shape[1] != 3:
        raise ValueError(f"{path} holds points of the plane; points in space were expected")
    return Cloud(content.points.astype(float), _point_normals(content), content.face_triangles())


def _point_normals(content: MeshContent) -> np.ndarray | None:
    """Return the data "normals", or three columns of their components, if there are such data."""
    data = {name.lower(): values for name, values in content.point_data.items()}
    if "normals" in data:
        return np.asarray(data["normals"], dtype=float).reshape(-1, 3)
    named = next((names for names in _NORMALS if {*names} <= {*data}), None)
    if named is None:
        return None
    return np.column_stack([np.asarray(data[name], dtype=float) for name in named])


def _cloud_of_table(source: Source) -> Cloud:
    names: list[str] = []

    def choose(columns: list[str]) -> Sequence[int]:
        bare = [bare_name(column) for column in columns]
        wanted = [*"xyz", *next((n for n in _NORMALS if {*n} <= {*bare}), ())]
        if missing := [name for name in wanted if name not in bare]:
            raise ValueError(
                f"{source} has no column {missing[0]!r}; points in space have x, y and z, and it "
                f"has {', '.join(columns)}"
            )
        unnamed = columns[3:6] == ["column 4", "column 5", "column 6"]
        names[:] = [*wanted, *columns[3:6]] if unnamed else wanted
        return [bare.index(name) for name in wanted] + [3, 4, 5] * unnamed

    table = read_source(source, ColumnSpec(choose))
    numbers = table.numbers
    if not len(numbers):
        raise ValueError(bad_row_message(source, table.bad[0]))
    normals = numbers[:, 3:] if len(names) == 6 else None
    if normals is not None and "column 4" in names:
        lengths = np.linalg.norm(normals, axis=1)
        low, high = _UNIT_LENGTHS
        normals = normals if ((lengths > low) & (lengths < high)).mean() > 0.9 else None
    warnings = []
    if table.bad:
        row, count = table.bad[0], len(table.bad)
        rows = "row was" if count == 1 else "rows were"
        first = f"the first, {numbered(source)} {row.line}: {row.reason}"
        warnings = [f"{count} {rows} skipped; {first}."]
    return Cloud(numbers[:, :3], normals, np.empty((0, 3), dtype=np.intp), tuple(warnings))


def _finite(cloud: Cloud) -> Cloud:
    """Return the cloud without points that are not finite, nor their triangles."""
    good = np.isfinite(cloud.points).all(axis=1)
    normals = cloud.normals
    if normals is not None:
        normals = np.where(np.isfinite(normals).all(axis=1, keepdims=True), normals, 0.0)[good]
    if good.all():
        return replace(cloud, normals=normals)
    count = int((~good).sum())
    number = np.cumsum(good) - 1
    inside = (cloud.triangles >= 0) & (cloud.triangles < len(good))
    kept = cloud.triangles[inside.all(axis=1)]
    kept = kept[good[kept].all(axis=1)]
    points = "point has" if count == 1 else "points have"
    were = "was" if count == 1 else "were"
    warning = f"{count} {points} coordinates that are not finite, and {were} skipped."
    return Cloud(cloud.points[good], normals, number[kept], (*cloud.warnings, warning))


def _with_normals(cloud: Cloud) -> Cloud:
    """Return the cloud with the normals of its triangles, if it has triangles and no normals."""
    if cloud.normals is not None and cloud.normals.any():
        return cloud
    if not len(cloud.triangles):
        return replace(cloud, normals=None)
    area = triangle_normals(*cloud.points[cloud.triangles].swapaxes(0, 1))
    n = len(cloud.points)
    normals = np.stack(
        [np.bincount(cloud.triangles.ravel(), np.repeat(column, 3), n) for column in area.T],
        axis=1,
    )
    return replace(cloud, normals=normals, normals_of="triangles in the file")
