"""Meshes and surfaces of triangles in files.

One table names the reader of each format. PLY, STL and OBJ are read here; meshio reads VTK, Gmsh
and OFF, and writes all formats but binary STL.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType

import numpy as np
from numpy.typing import ArrayLike

from fieldrecon._core import validation as valid
from fieldrecon._core.atomic_files import whole_file, write_atomically
from fieldrecon._core.extras import optional
from fieldrecon.io.mesh_content import MeshContent, require_vertices
from fieldrecon.io.obj import read_obj
from fieldrecon.io.ply import read_ply
from fieldrecon.io.stl import read_stl, stl_bytes
from fieldrecon.meshes.simplex_mesh import SimplexMesh
from fieldrecon.triangles.audit import as_surface

_MESHIO_MODULES = {
    ".vtk": "vtk",
    ".vtu": "vtu",
    ".msh": "gmsh",
    ".ply": "ply",
    ".stl": "stl",
    ".obj": "obj",
    ".off": "off",
}
_SURFACES_ONLY = (".ply", ".stl", ".obj", ".off")
_SIDES = {"triangle": {"line", "vertex"}, "tetra": {"triangle", "line", "vertex"}}
_PLURAL = {"triangle": "triangles", "tetra": "tetrahedra"}

Data = dict[str, np.ndarray]


def _read_by_meshio(path: str | Path) -> MeshContent:
    module = optional(f"meshio.{_MESHIO_MODULES[Path(path).suffix.lower()]}")
    try:
        content = module.read(str(path))
    except OSError:
        raise
    except Exception as error:  # meshio raises whatever goes wrong inside
        reason = " ".join(str(error).split()) or "it is not in the format that its suffix names"
        raise ValueError(f"{path} cannot be read as a mesh: {reason}") from None
    return MeshContent(
        np.asarray(content.points),
        [(block.type, np.asarray(block.data)) for block in content.cells],
        {name: np.asarray(values) for name, values in content.point_data.items()},
        {name: [np.asarray(v) for v in blocks] for name, blocks in content.cell_data.items()},
    )


READERS: Mapping[str, Callable[[str | Path], MeshContent]] = MappingProxyType(
    {
        ".vtk": _read_by_meshio,
        ".vtu": _read_by_meshio,
        ".msh": _read_by_meshio,
        ".ply": read_ply,
        ".stl": read_stl,
        ".obj": read_obj,
        ".off": _read_by_meshio,
    }
)
"""The reader of each format, by its suffix."""


def read_content(path: str | Path) -> MeshContent:
    """Read a file by the reader of its format.

    Raises
    ------
    ValueError
        If the suffix is unknown, or the file cannot be read or holds no points: with its path.
    FileNotFoundError
        If there is no such file.
    ImportError
        If the format takes meshio, which is not installed.
    """
    content = READERS[_known_suffix(path)](path)
    if np.ndim(content.points) != 2 or len(content.points) == 0:
        raise ValueError(f"{path} holds no points")
    return content


def read_mesh(path: str | Path) -> SimplexMesh:
    """Read the triangles or the tetrahedra of a file.

    The suffix names the format: .vtk and .vtu (VTK), .msh (Gmsh), .ply, .stl, .obj, .off.
    If there are tetrahedra, triangles are taken for the marked boundary and ignored; lines and
    points always are. The third coordinates of a mesh of triangles must be equal, and are dropped.

    Parameters
    ----------
    path : str or pathlib.Path

    Returns
    -------
    SimplexMesh
        In the order of the file. Equal vertices of an .stl file are merged.

    Raises
    ------
    ValueError
        If the file cannot be read, holds other cells, or they are not a mesh: with its path.
    FileNotFoundError
        If there is no such file.
    ImportError
        If the format takes meshio, which is not installed.
    """
    return read_mesh_and_data(path)[0]


def read_mesh_and_data(path: str | Path) -> tuple[SimplexMesh, Data, Data]:
    """Read a mesh like `read_mesh`, and the data at its points and in its cells.

    Parameters
    ----------
    path : str or pathlib.Path
        A file of a format that `read_mesh` reads.

    Returns
    -------
    mesh : SimplexMesh
    point_data, cell_data : dict of str to ndarray
        Arrays of n and of c rows. Vectors in the plane may have a third component, since some
        formats store only vectors in space.
    """
    content = read_content(path).with_merged_vertices()
    kind = "tetra" if "tetra" in content.kinds else "triangle"
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
    cell_data = {name: content.cell_data_of(kind, name) for name in content.cell_data}
    return mesh, content.point_data, cell_data


def read_surface(path: str | Path) -> tuple[np.ndarray, np.ndarray]:
    """Read the triangles of a surface in space.

    The surface may be open, intersect itself or have edges of three triangles. The only check is
    that the triangles index the points.

    Parameters
    ----------
    path : str or pathlib.Path

    Returns
    -------
    points : (n, 3) ndarray
        Equal vertices of an .stl file are merged.
    triangles : (m, 3) ndarray of int

    Raises
    ------
    ValueError
        If the file cannot be read or holds other cells: with its path.
    FileNotFoundError
        If there is no such file.
    ImportError
        If the format takes meshio, which is not installed.
    """
    return _surface(path, read_content(path).with_merged_vertices())


def read_triangles(path: str | Path, *, triangulate: bool = False) -> tuple[np.ndarray, np.ndarray]:
    """Read the triangles of a surface in space with all their errors: no vertices are merged.

    Parameters
    ----------
    path : str or pathlib.Path
        Each triangle of an .stl file has vertices of its own; the normals in the file are ignored.
        The other formats are the same as in `read_surface`.
    triangulate : bool
        Divide quads and polygons into triangles, instead of refusing them: by the diagonals from
        their first corner, or if they are not convex by those of the least area.

    Returns
    -------
    points : (n, 3) ndarray
        In single precision if the file is a binary .stl.
    triangles : (m, 3) ndarray of int

    Raises
    ------
    ValueError
        If the file cannot be read as triangles: with its path.
    FileNotFoundError
        If there is no such file.
    """
    content = read_content(path)
    if content.separate_corners:
        return content.points, content.cells_of("triangle")
    if triangulate and content.polygonal:
        content = replace(content, cells=[("triangle", content.face_triangles())], cell_data={})
    return _surface(path, content)


def _surface(path: str | Path, content: MeshContent) -> tuple[np.ndarray, np.ndarray]:
    triangles = _cells(path, content, "triangle").astype(np.intp)
    n, d = content.points.shape
    require_vertices(path, triangles, n)
    points = np.zeros((n, 3))
    points[:, :d] = content.points
    return points, triangles


def _cells(path: str | Path, content: MeshContent, kind: str) -> np.ndarray:
    """Return all cells of this kind; cells other than their sides are refused."""
    kinds = content.kinds
    others = sorted(set(kinds) - {kind} - _SIDES[kind])
    if others or kind not in kinds:
        found = ", ".join(_PLURAL.get(k, f"{k} cells") for k in others or kinds) or "points only"
        wanted = "triangles or tetrahedra" if kind == "triangle" else "tetrahedra"
        remedy = "; the option triangulate divides them" if content.polygonal else ""
        raise ValueError(f"{path} holds {found}; {wanted} were expected{remedy}")
    return content.cells_of(kind)


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
        Its suffix names the format, as for `read_mesh`. The formats of surfaces, .ply, .stl, .obj
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
    suffix, (n, d) = _known_suffix(path), mesh.points.shape
    module = optional(f"meshio.{_MESHIO_MODULES[suffix]}")
    if d == 3 and suffix in _SURFACES_ONLY:
        raise ValueError(f"{path} cannot hold tetrahedra; .vtk, .vtu and .msh can")
    if (point_data or cell_data) and suffix in _SURFACES_ONLY:
        raise ValueError(f"{path} cannot hold data; .vtk, .vtu and .msh can")
    at_points = {k: _as_data(v, k, n, "point") for k, v in (point_data or {}).items()}
    in_cells = {k: [_as_data(v, k, len(mesh.cells), "cell")] for k, v in (cell_data or {}).items()}
    cells = mesh.cells.astype(np.int32) if n < 2**31 else mesh.cells
    kind = "triangle" if d == 2 else "tetra"
    content = optional("meshio").Mesh(_in_space(mesh.points), [(kind, cells)], at_points, in_cells)
    with whole_file(Path(path)) as temporary:
        module.write(str(temporary), content)


def write_triangles(path: str | Path, points: ArrayLike, triangles: ArrayLike) -> None:
    """Write triangles in space to a file.

    Parameters
    ----------
    path : str or pathlib.Path
        .stl is written binary, in single precision; .ply, .obj and .off through meshio.
    points : (n, 3) array_like
    triangles : (m, 3) array_like of int

    Raises
    ------
    ValueError
        If the format is unknown, or the arrays are not triangles in space.
    ModuleNotFoundError
        If the format takes meshio, which is not installed.

    Examples
    --------
    >>> import tempfile
    >>> corners = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = Path(folder) / "two.stl"
    ...     write_triangles(path, corners, [[0, 1, 2], [0, 3, 1]])
    ...     points, triangles = read_triangles(path)
    >>> len(points), triangles.tolist()
    (6, [[0, 1, 2], [3, 4, 5]])
    """
    p, t = as_surface(points, triangles)
    if not packages_to_write(path):
        write_atomically(Path(path), stl_bytes(p[t]))
        return
    meshio = optional("meshio")
    with whole_file(Path(path)) as temporary:
        meshio.write_points_cells(str(temporary), p, [("triangle", t.astype(np.int32))])


def packages_to_write(path: str | Path) -> tuple[str, ...]:
    """Return the optional packages that `write_triangles` takes for a file of this name.

    Raises
    ------
    ValueError
        If the format is unknown.
    """
    suffix = Path(path).suffix.lower()
    if suffix not in _SURFACES_ONLY:
        raise ValueError(f"{path} must end with .stl, .ply, .obj or .off")
    return () if suffix == ".stl" else ("meshio",)


def _known_suffix(path: str | Path) -> str:
    suffix = Path(path).suffix.lower()
    if suffix not in READERS:
        raise ValueError(f"{path} must end with the suffix of a known format, {', '.join(READERS)}")
    return suffix


def _as_data(values: ArrayLike, name: str, rows: int, of: str) -> np.ndarray:
    array = valid.as_values(values, rows, name=name, of=of)
    if array.dtype.kind == "c":
        raise ValueError(f"{name} must be real to be written; got the type {array.dtype}")
    return _in_space(array)


def _in_space(array: np.ndarray) -> np.ndarray:
    """Return a copy, with a third component of zero for vectors in the plane."""
    if array.ndim == 2 and array.shape[1] == 2:
        return np.column_stack([array, np.zeros(len(array))])
    return np.array(array)
