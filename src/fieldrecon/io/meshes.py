"""Meshes in files: VTK, Gmsh, PLY, STL, OBJ and OFF, read and written through meshio."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from fieldrecon._core import validation as valid
from fieldrecon._core.extras import optional
from fieldrecon.meshes.simplex_mesh import SimplexMesh

_MODULES = {
    ".vtk": "vtk",
    ".vtu": "vtu",
    ".msh": "gmsh",
    ".ply": "ply",
    ".stl": "stl",
    ".obj": "obj",
    ".off": "off",
}
_SURFACES_ONLY = (".ply", ".stl", ".obj", ".off")
_LOWER = {"triangle": {"line", "vertex"}, "tetra": {"triangle", "line", "vertex"}}
_PLURAL = {"triangle": "triangles", "tetra": "tetrahedra"}

Data = dict[str, np.ndarray]


def read_mesh(path: str | Path) -> SimplexMesh:
    """Read the triangles or the tetrahedra of a file.

    The suffix names the format: .vtk and .vtu (VTK), .msh (Gmsh), .ply, .stl, .obj, .off.
    Tetrahedra go before triangles, which then are the marked boundary, and both before lines and
    points. The third coordinates of a mesh of triangles must all be the same, and are left out.

    Parameters
    ----------
    path : str or pathlib.Path

    Returns
    -------
    SimplexMesh
        In the order of the file. In .stl, where each triangle has vertices of its own, equal ones
        are one vertex.

    Raises
    ------
    ValueError
        If the file cannot be read, holds other cells, or they are no mesh: with its path.
    FileNotFoundError
        If there is no such file.
    ImportError
        If meshio is not installed.
    """
    return read_mesh_and_data(path)[0]


def read_mesh_and_data(path: str | Path) -> tuple[SimplexMesh, Data, Data]:
    """Read a mesh like `read_mesh`, and the data at its points and in its cells.

    Returns
    -------
    mesh : SimplexMesh
    point_data, cell_data : dict of str to ndarray
        Arrays of n and of c rows. Vectors in the plane may have come back with a third component,
        because some formats know no others.
    """
    content = _content(path)
    kind = "tetra" if "tetra" in _kinds(content) else "triangle"
    cells = _cells(path, content, kind)
    points = content.points
    if kind == "triangle" and points.shape[1] == 3:
        if (points[:, 2] != points[0, 2]).any():
            raise ValueError(
                f"{path} holds a surface in space, not a mesh of the plane; read_surface reads it"
            )
        points = points[:, :2]
    try:
        mesh = SimplexMesh(points, cells)
    except (ValueError, OverflowError) as error:
        raise ValueError(f"{path} holds no mesh: {error}") from None
    in_cells = {name: _of_kind(content, kind, name) for name in content.cell_data}
    return mesh, {name: np.asarray(v) for name, v in content.point_data.items()}, in_cells


def read_surface(path: str | Path) -> tuple[np.ndarray, np.ndarray]:
    """Read the triangles of a surface in space.

    A surface is no `SimplexMesh`: it may be open, cross itself or have edges of three triangles,
    and nothing is checked but that the triangles index the points.

    Parameters
    ----------
    path : str or pathlib.Path

    Returns
    -------
    points : (n, 3) ndarray
    triangles : (m, 3) ndarray of int

    Raises
    ------
    ValueError
        If the file cannot be read or holds other cells: with its path.
    FileNotFoundError
        If there is no such file.
    ImportError
        If meshio is not installed.
    """
    content = _content(path)
    triangles = _cells(path, content, "triangle").astype(np.intp)
    n = len(content.points)
    if triangles.min() < 0 or triangles.max() >= n:
        raise ValueError(f"{path} holds a triangle of points that it does not hold")
    points = np.zeros((n, 3))
    points[:, : content.points.shape[1]] = content.points
    return points, triangles


def read_vertices(path: str | Path) -> tuple[np.ndarray, np.ndarray | None, np.ndarray]:
    """Read all points of a file, whatever cells they have.

    Returns
    -------
    points : (n, 3) ndarray
    normals : (n, 3) ndarray or None
        Data at the points that are called Normals.
    triangles : (m, 3) ndarray of int
        Those that there are.

    Raises
    ------
    ValueError
        If the file cannot be read, or its points are not in space: with its path.
    FileNotFoundError
        If there is no such file.
    ImportError
        If meshio is not installed.
    """
    content = _content(path)
    if content.points.shape[1] != 3:
        raise ValueError(f"{path} holds points of the plane; points in space were expected")
    normals = {name.lower(): data for name, data in content.point_data.items()}.get("normals")
    triangles = [block.data for block in content.cells if block.type == "triangle"]
    return (
        np.asarray(content.points, dtype=float),
        None if normals is None else np.asarray(normals, dtype=float).reshape(-1, 3),
        np.concatenate([np.empty((0, 3), dtype=np.intp), *triangles]).astype(np.intp),
    )


def write_mesh(
    path: str | Path,
    mesh: SimplexMesh,
    point_data: Mapping[str, ArrayLike] | None = None,
    cell_data: Mapping[str, ArrayLike] | None = None,
) -> None:
    """Write a mesh, and data on it, to a file.

    Parameters
    ----------
    path : str or pathlib.Path
        Its suffix names the format, as for `read_mesh`. Those of surfaces, .ply, .stl, .obj
        and .off, hold triangles only.
    mesh : SimplexMesh
        A mesh of the plane gets third coordinates of zero.
    point_data, cell_data : mapping of str to array_like, optional
        Real arrays of n rows, and of c rows; .vtk, .vtu and .msh hold both. Vectors in the plane
        get a third component of zero.

    Raises
    ------
    ValueError
        If the format is unknown or does not hold such cells or data.
    ImportError
        If meshio is not installed.

    Examples
    --------
    >>> import tempfile
    >>> mesh = SimplexMesh.delaunay([[0, 0], [2, 0], [0, 2], [3, 3]])
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = Path(folder) / "mesh.vtk"
    ...     write_mesh(path, mesh, cell_data={"area": mesh.cell_measures})
    ...     _, _, data = read_mesh_and_data(path)
    >>> data["area"]
    array([2., 4.])
    """
    module = _module(path)
    suffix, (n, d) = Path(path).suffix.lower(), mesh.points.shape
    if d == 3 and suffix in _SURFACES_ONLY:
        raise ValueError(f"{path} cannot hold tetrahedra; .vtk, .vtu and .msh can")
    if (point_data or cell_data) and suffix in _SURFACES_ONLY:
        raise ValueError(f"{path} cannot hold data; .vtk, .vtu and .msh can")
    at_points = {k: _as_data(v, k, n, "point") for k, v in (point_data or {}).items()}
    in_cells = {k: [_as_data(v, k, len(mesh.cells), "cell")] for k, v in (cell_data or {}).items()}
    cells = mesh.cells.astype(np.int32) if n < 2**31 else mesh.cells
    kind = "triangle" if d == 2 else "tetra"
    content = optional("meshio").Mesh(_in_space(mesh.points), [(kind, cells)], at_points, in_cells)
    module.write(str(path), content)


def _module(path: str | Path) -> Any:
    """The module of meshio for the format that the suffix names."""
    suffix = Path(path).suffix.lower()
    if suffix not in _MODULES:
        known = ", ".join(_MODULES)
        raise ValueError(f"{path} must end with the suffix of a known format, {known}")
    return optional(f"meshio.{_MODULES[suffix]}")


def _content(path: str | Path) -> Any:
    module = _module(path)
    _refuse_endless_header(path)
    try:
        with np.errstate(all="ignore"):  # meshio takes the start of an ASCII .stl for a number
            content = module.read(str(path))
    except OSError:
        raise
    except Exception as error:  # meshio lets through whatever goes wrong inside
        reason = " ".join(str(error).split()) or "it is not in the format that its suffix names"
        raise ValueError(f"{path} cannot be read as a mesh: {reason}") from None
    if np.ndim(content.points) != 2 or len(content.points) == 0:
        raise ValueError(f"{path} holds no points")
    return content


def _refuse_endless_header(path: str | Path) -> None:
    """Refuse a .ply cut off within its header, which meshio would read for ever."""
    if Path(path).suffix.lower() == ".ply" and b"end_header" not in Path(path).read_bytes():
        raise ValueError(f"{path} cannot be read as a mesh: its header has no end")


def _kinds(content: Any) -> list[str]:
    return sorted({block.type for block in content.cells if len(block.data)})


def _cells(path: str | Path, content: Any, kind: str) -> np.ndarray:
    """All cells of this kind; others than their sides are refused."""
    kinds = _kinds(content)
    others = sorted(set(kinds) - {kind} - _LOWER[kind])
    if others or kind not in kinds:
        found = ", ".join(_PLURAL.get(k, f"{k} cells") for k in others or kinds) or "points only"
        wanted = "triangles or tetrahedra" if kind == "triangle" else "tetrahedra"
        raise ValueError(f"{path} holds {found}; {wanted} were expected")
    return np.concatenate([block.data for block in content.cells if block.type == kind])


def _of_kind(content: Any, kind: str, name: str) -> np.ndarray:
    """The rows of the data that belong to cells of this kind."""
    blocks = zip(content.cells, content.cell_data[name], strict=True)
    return np.concatenate([np.asarray(v) for block, v in blocks if block.type == kind])


def _as_data(values: ArrayLike, name: str, rows: int, of: str) -> np.ndarray:
    array = valid.as_values(values, rows, name=name, of=of)
    if array.dtype.kind == "c":
        raise ValueError(f"{name} must be real to be written; got the type {array.dtype}")
    return _in_space(array)


def _in_space(array: np.ndarray) -> np.ndarray:
    """A third component of zero for vectors in the plane; an array of its own in any case."""
    if array.ndim == 2 and array.shape[1] == 2:
        return np.column_stack([array, np.zeros(len(array))])
    return np.array(array)
