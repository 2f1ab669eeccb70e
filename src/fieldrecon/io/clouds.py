"""Clouds of points in files: PLY, OBJ, STL, tables, and what meshio reads."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from fieldrecon.io.meshes import read_vertices
from fieldrecon.io.ply import fans, read_ply, triangles_of
from fieldrecon.io.tables import Wanted, bare_name, read_table
from fieldrecon.io.triangles import read_triangles
from fieldrecon.triangles.duplicates import welded

_FEWEST = 10
_LENGTHS_OF_NORMALS = (0.9, 1.1)
_NORMALS = (("nx", "ny", "nz"), ("normal_x", "normal_y", "normal_z"))


@dataclass(frozen=True, eq=False)
class Cloud:
    """Points on a surface, as a file has them.

    Parameters
    ----------
    points : ndarray of shape (n, 3)
        Finite.
    normals : ndarray of shape (n, 3), optional
        Of the file, or of its triangles around each point: finite, and zero where there are none.
    triangles : ndarray of shape (m, 3)
        Between the points; none if the file has none.
    remarks : tuple of str
        What was left out, in sentences.
    normals_of : str
        Whose the normals are: "file" or "triangles in the file".
    """

    points: np.ndarray
    normals: np.ndarray | None
    triangles: np.ndarray
    remarks: tuple[str, ...] = ()
    normals_of: str = "file"


def read_cloud(path: str | Path) -> Cloud:
    """Read points on a surface, their normals where the file has some, and its triangles.

    Parameters
    ----------
    path : str or pathlib.Path
        .ply (text or binary, with faces, strips or neither), .obj, .stl; .vtk, .vtu, .off and
        .msh through meshio; anything else as a table of x, y, z and perhaps nx, ny, nz, as
        `read_table` does. Corners of an STL that are in one place become one point.

    Returns
    -------
    Cloud
        Points that are not finite are left out, and told.

    Raises
    ------
    ValueError
        If the file cannot be read, or holds too few points: with its path.
    FileNotFoundError
        If there is no such file.
    ImportError
        If it takes a package that is not installed.
    """
    path = Path(path)
    suffix = path.suffix.lower()
    readers: dict[str, Callable[[Path], Cloud]] = {
        ".ply": _of_ply,
        ".obj": _of_obj,
        ".stl": _of_stl,
        **dict.fromkeys((".vtk", ".vtu", ".off", ".msh"), _of_meshio),
    }
    cloud = _finite(readers.get(suffix, _of_table)(path))
    if len(cloud.points) < _FEWEST:
        raise ValueError(
            f"{path} holds {len(cloud.points)} points; a surface takes {_FEWEST} at least"
        )
    m = cloud.triangles
    if len(m) and (m.min() < 0 or m.max() >= len(cloud.points)):
        raise ValueError(f"{path} holds a triangle of points that it does not hold")
    return _with_normals(cloud)


def _of_ply(path: Path) -> Cloud:
    elements = read_ply(path)
    columns = elements.get("vertex", {})
    if not {"x", "y", "z"} <= {*columns}:
        raise ValueError(f"{path} has no vertices with x, y and z")
    named = next((names for names in _NORMALS if {*names} <= {*columns}), None)
    normals = None if named is None else _columns(columns[name] for name in named)
    return Cloud(_columns(columns[c] for c in "xyz"), normals, triangles_of(elements))


def _columns(columns: Iterator[np.ndarray | list[np.ndarray]]) -> np.ndarray:
    return np.column_stack([np.asarray(column, dtype=float) for column in columns])


def _of_stl(path: Path) -> Cloud:
    points, triangles = read_triangles(path)
    kept, number = np.unique(welded(points.astype(float)), return_inverse=True)
    return Cloud(points[kept].astype(float), None, number[triangles])


def _of_meshio(path: Path) -> Cloud:
    points, normals, triangles = read_vertices(path)
    return Cloud(points, normals, triangles)


def _of_obj(path: Path) -> Cloud:
    """Vertices, normals if there is one for each vertex, and faces as fans."""
    vertices, normals, faces = [], [], []
    for number, line in enumerate(path.read_bytes().splitlines(), 1):
        kind, _, rest = line.strip().partition(b" ")
        try:
            if kind == b"v":
                vertices.append([float(word) for word in rest.split()[:3]])
            elif kind == b"vn":
                normals.append([float(word) for word in rest.split()[:3]])
            elif kind == b"f":
                corners = [int(word.split(b"/")[0]) for word in rest.split()]
                faces.append([c - 1 if c > 0 else len(vertices) + c for c in corners])
        except ValueError:
            raise ValueError(f"{path}, line {number}: {line.decode('latin-1')!r}") from None
    if any(len(row) < 3 for row in (*vertices, *normals)):
        raise ValueError(f"{path} holds a vertex with fewer than three coordinates")
    triangles = [fans(np.array([face])) for face in faces]
    return Cloud(
        np.array(vertices, dtype=float).reshape(-1, 3),
        np.array(normals) if normals and len(normals) == len(vertices) else None,
        np.concatenate([np.empty((0, 3), dtype=np.intp), *triangles]),
    )


def _of_table(path: Path) -> Cloud:
    names: list[str] = []

    def choose(columns: list[str]) -> Sequence[int]:
        bare = [bare_name(column) for column in columns]
        wanted = [*"xyz", *next((n for n in _NORMALS if {*n} <= {*bare}), ())]
        if missing := [name for name in wanted if name not in bare]:
            raise ValueError(
                f"{path} has no column {missing[0]!r}; points in space have x, y and z, and it has "
                f"{', '.join(columns)}"
            )
        unnamed = columns[3:6] == ["column 4", "column 5", "column 6"]
        names[:] = [*wanted, *columns[3:6]] if unnamed else wanted
        return [bare.index(name) for name in wanted] + [3, 4, 5] * unnamed

    table = read_table(path, _Growing(choose))
    numbers = table.numbers
    if not len(numbers):
        raise ValueError(f"{path}, line {table.bad[0].line}: {table.bad[0].reason}")
    normals = numbers[:, 3:] if len(names) == 6 else None
    if normals is not None and "column 4" in names:
        lengths = np.linalg.norm(normals, axis=1)
        low, high = _LENGTHS_OF_NORMALS
        normals = normals if ((lengths > low) & (lengths < high)).mean() > 0.9 else None
    remarks = []
    if table.bad:
        row, count = table.bad[0], len(table.bad)
        rows = "row was" if count == 1 else "rows were"
        remarks = [f"{count} {rows} left out; the first, line {row.line}: {row.reason}."]
    return Cloud(numbers[:, :3], normals, np.empty((0, 3), dtype=np.intp), tuple(remarks))


class _Growing(Wanted):
    """Columns of any number, each of any size."""

    def __init__(self, choose: Callable[[list[str]], Sequence[int]]) -> None:
        def counted(columns: list[str]) -> Sequence[int]:
            chosen = choose(columns)
            object.__setattr__(self, "limits", (np.inf,) * len(chosen))
            return chosen

        super().__init__(counted, ())


def _finite(cloud: Cloud) -> Cloud:
    """The cloud without the points that are none, nor their triangles."""
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
    remark = f"{count} {points} coordinates that are no finite numbers, and were left out."
    return Cloud(cloud.points[good], normals, number[kept], (*cloud.remarks, remark))


def _with_normals(cloud: Cloud) -> Cloud:
    """The cloud with the normals of its triangles, if it has these and no others."""
    if cloud.normals is not None and cloud.normals.any():
        return cloud
    if not len(cloud.triangles):
        return replace(cloud, normals=None)
    p = cloud.points - cloud.points.mean(axis=0)
    a, b, c = p[cloud.triangles].swapaxes(0, 1)
    area = np.cross(b - a, c - a)
    normals = np.stack(
        [np.bincount(cloud.triangles.ravel(), np.repeat(column, 3), len(p)) for column in area.T],
        axis=1,
    )
    return replace(cloud, normals=normals, normals_of="triangles in the file")
