"""Mesh files: a mesh is reproduced by every format, and bad files are refused by name."""

import sys

import meshio
import numpy as np
import pytest

from fieldrecon.io.mesh_content import MeshContent, divided, face_blocks
from fieldrecon.io.meshes import read_mesh, read_mesh_and_data, read_surface, write_mesh
from fieldrecon.io.ply import read_ply
from fieldrecon.meshes.simplex_mesh import SimplexMesh

WITH_DATA = [".vtk", ".vtu", ".msh"]
SURFACES = [".ply", ".stl", ".obj", ".off"]
CORNERS = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1]])


def mesh_in(d: int) -> SimplexMesh:
    return SimplexMesh.delaunay(np.random.default_rng(3).normal(size=(30, d)) + 1e3)


def corner_sets(mesh: SimplexMesh) -> set:
    return {frozenset(map(tuple, corners)) for corners in mesh.points[mesh.cells].tolist()}


def test_the_faces_of_a_mesh_do_not_include_its_solid_cells():
    """A quad is two triangles; a block without cells is none."""
    cells = [("tetra", [[0, 1, 2, 3]]), ("quad", [[0, 1, 3, 2]]), ("triangle", np.empty((0, 3)))]
    square = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]])
    content = MeshContent(square, [(kind, np.array(c, dtype=int)) for kind, c in cells])
    assert content.face_triangles().shape == (2, 3)
    assert {*content.face_triangles().ravel()} == {0, 1, 2, 3}


@pytest.mark.parametrize("suffix", [*WITH_DATA, ".ply", ".obj", ".off"])
def test_a_plane_mesh_is_reproduced(suffix, tmp_path):
    """Points and cells are equal to the last bit, in the same order."""
    mesh = mesh_in(2)
    write_mesh(tmp_path / f"mesh{suffix}", mesh)
    read = read_mesh(tmp_path / f"mesh{suffix}")
    assert np.array_equal(read.points, mesh.points)
    assert np.array_equal(read.cells, mesh.cells)


@pytest.mark.parametrize("suffix", [*WITH_DATA, *SURFACES])
def test_a_mesh_is_written_in_silence(suffix, tmp_path, capfd):
    """meshio would print a warning of cells of 64 bits, which PLY files do not hold."""
    points = np.random.default_rng(3).normal(size=(70, 2))
    write_mesh(tmp_path / f"mesh{suffix}", SimplexMesh.delaunay(points))
    assert capfd.readouterr() == ("", "")


def test_stl_reproduces_the_triangles(tmp_path):
    """Each triangle has its corners to the last bit; only the order of the points differs."""
    mesh = mesh_in(2)
    write_mesh(tmp_path / "mesh.stl", mesh)
    read = read_mesh(tmp_path / "mesh.stl")
    assert read.points.shape == mesh.points.shape
    assert corner_sets(read) == corner_sets(mesh)


@pytest.mark.parametrize("suffix", WITH_DATA)
def test_tetrahedra_are_reproduced(suffix, tmp_path):
    """Points and cells are equal to the last bit, in the same order."""
    mesh = mesh_in(3)
    write_mesh(str(tmp_path / f"mesh{suffix}"), mesh)
    read = read_mesh(str(tmp_path / f"mesh{suffix}"))
    assert np.array_equal(read.points, mesh.points)
    assert np.array_equal(read.cells, mesh.cells)


@pytest.mark.parametrize("d", [2, 3])
@pytest.mark.parametrize("suffix", WITH_DATA)
def test_point_and_cell_data_are_reproduced(suffix, d, tmp_path):
    """Data are scalars or vectors; plane vectors get a third component of zero."""
    mesh = mesh_in(d)
    points = {"pressure": mesh.points[:, 0], "velocity": mesh.points}
    cells = {"size": mesh.cell_measures, "centre": mesh.cell_centers}
    write_mesh(tmp_path / f"mesh{suffix}", mesh, points, cells)
    _, at_points, in_cells = read_mesh_and_data(tmp_path / f"mesh{suffix}")
    for read, written in [(at_points, points), (in_cells, cells)]:
        for name, values in written.items():
            assert np.array_equal(read[name].reshape(len(values), -1)[:, :d].squeeze(), values)


def test_lower_dimensional_cells_are_ignored(tmp_path):
    """Gmsh also writes marked boundary triangles, lines and points.

    Only tetrahedra and their data are read.
    """
    blocks = [
        ("vertex", [[0]]),
        ("tetra", [[0, 1, 2, 3]]),
        ("line", [[0, 1]]),
        ("triangle", [[0, 1, 2], [1, 2, 4]]),
        ("tetra", [[4, 1, 2, 3]]),
    ]
    regions = [[7], [8], [9], [5, 6], [4]]
    content = meshio.Mesh(CORNERS, blocks, cell_data={"region": regions})
    meshio.vtk.write(tmp_path / "mesh.vtk", content)
    mesh, _, data = read_mesh_and_data(tmp_path / "mesh.vtk")
    assert np.sort(mesh.cells).tolist() == [[0, 1, 2, 3], [1, 2, 3, 4]]
    assert data["region"].tolist() == [8, 4]


def test_a_constant_third_coordinate_is_dropped(tmp_path):
    """Triangles in a plane z = const are a mesh in two variables."""
    (tmp_path / "mesh.obj").write_text("v 0 0 7\nv 1 0 7\nv 0 1 7\nf 1 3 2\n")
    mesh = read_mesh(tmp_path / "mesh.obj")
    assert mesh.points.tolist() == [[0, 0], [1, 0], [0, 1]]


@pytest.mark.parametrize("suffix", [*SURFACES, *WITH_DATA])
def test_a_surface_is_read_by_read_surface_only(suffix, tmp_path):
    """`read_mesh` refuses a surface in space."""
    triangles = np.array([[0, 1, 3], [1, 2, 3], [2, 0, 3]], dtype=np.int32)
    path = tmp_path / f"surface{suffix}"
    content = meshio.Mesh(CORNERS[:4], [("triangle", triangles)])
    meshio.write(path, content, file_format="gmsh" if suffix == ".msh" else None)
    points, read = read_surface(path)
    assert np.array_equal(points[read], CORNERS[triangles])
    with pytest.raises(ValueError, match=f"surface{suffix} holds a surface in space, not a mesh"):
        read_mesh(path)


@pytest.mark.parametrize(
    ("kind", "cell", "found"),
    [
        ("quad", [0, 1, 4, 2], "quad cells"),
        ("tetra10", [*range(5), *range(5)], "tetra10 cells"),
        ("triangle6", [*range(5), 0], "triangle6 cells"),
        ("line", [0, 1], "line cells"),
    ],
)
def test_unsupported_cells_are_refused(kind, cell, found, tmp_path):
    """The message names the type of cell, also if the file has triangles beside it."""
    path = tmp_path / "mesh.vtk"
    words = f"mesh.vtk holds {found}; triangles or tetrahedra were expected"
    others = [] if kind == "line" else [("triangle", [[0, 1, 2]])]
    for blocks in ([(kind, [cell])], [(kind, [cell]), *others]):
        meshio.vtk.write(path, meshio.Mesh(CORNERS, blocks))
        with pytest.raises(ValueError, match=words):
            read_mesh(path)


def test_tetrahedra_are_not_a_surface(tmp_path):
    """The message names the cells that were found."""
    write_mesh(tmp_path / "mesh.vtk", mesh_in(3))
    with pytest.raises(ValueError, match="holds tetrahedra; triangles"):
        read_surface(tmp_path / "mesh.vtk")


@pytest.mark.parametrize("suffix", [*SURFACES, *WITH_DATA])
@pytest.mark.parametrize(
    "content",
    [b"", b"hello\n", b"ply\nformat ascii 1.0\nelement vertex 3\n", bytes(range(256)) * 3],
    ids=["empty", "text", "cut header", "bytes"],
)
def test_files_that_are_not_meshes_are_refused(suffix, content, tmp_path):
    """The message has the path and one sentence, whatever the reader of the format raises."""
    path = tmp_path / f"no{suffix}"
    path.write_bytes(content)
    for read in (read_mesh, read_surface):
        with pytest.raises(
            ValueError,
            match=rf"no\{suffix} (cannot be read as (a mesh|PLY): .|holds no|is not an STL)",
        ):
            read(path)


def test_triangle_strips_are_read_as_triangles(tmp_path):
    """Some scanners write triangle strips."""
    header = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
    header += "property float z\nelement tristrips 1\nproperty list int int vertex_indices\n"
    path = tmp_path / "scan.ply"
    path.write_text(header + "end_header\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n4 0 1 2 3\n")
    points, triangles = read_surface(path)
    assert (points.shape, triangles.tolist()) == ((4, 3), [[0, 1, 2], [2, 1, 3]])


def test_ply_files_have_vertex_and_face_data(tmp_path):
    """Faces may stand in one block or in several."""
    header = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
    header += "property float z\nproperty float heat\nelement face 2\n"
    header += "property list uchar int vertex_indices\nproperty list uchar float texture\n"
    header += "property int region\nend_header\n0 0 0 5\n1 0 0 6\n0 1 0 7\n1 1 0 8\n"
    path = tmp_path / "mesh.ply"
    path.write_text(header + "3 0 1 2 1 0.5 7\n3 1 3 2 2 0.5 0.5 9\n")
    mesh, points, cells = read_mesh_and_data(path)
    assert mesh.cells.tolist() == [[0, 1, 2], [1, 3, 2]]
    assert points["heat"].tolist() == [5, 6, 7, 8]
    assert cells["region"].tolist() == [7, 9]
    path.write_text(header + "3 0 1 2 1 0.5 7\n4 0 1 3 2 2 0.5 0.5 9\n")
    with pytest.raises(ValueError, match="holds quad cells; triangles or tetrahedra were expected"):
        read_mesh(path)


def test_a_list_before_the_corners_of_a_face_may_hold_any_numbers(tmp_path):
    """Its numbers, here texture coordinates of which one is unknown, are not lengths of lists."""
    header = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
    header += "property float z\nelement face 2\nproperty list uchar float texture\n"
    header += "property list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n"
    path = tmp_path / "mesh.ply"
    path.write_text(header + "2 nan 0.5 3 0 1 2\n2 0.5 -7 3 1 3 2\n")
    assert read_mesh(path).cells.tolist() == [[0, 1, 2], [1, 3, 2]]


@pytest.mark.parametrize("corners", [4, 5, 8])
def test_a_convex_polygon_is_divided_from_its_first_corner(corners):
    """In any plane in space, where other divisions have the same area up to rounding."""
    angle = 2 * np.pi * np.arange(corners) / corners
    plane = np.random.default_rng(corners).normal(size=(2, 3))
    points = np.column_stack([np.cos(angle), np.sin(angle)]) @ plane
    fan = [[0, k, k + 1] for k in range(1, corners - 1)]
    assert divided(points, np.arange(corners)[None]).tolist() == fan


@pytest.mark.parametrize("notch", [1.0, 1.8])
@pytest.mark.parametrize("first", range(4))
def test_a_polygon_that_is_not_convex_is_divided_inside(first, notch):
    """The areas of the triangles add up to its own, from whichever corner it begins.

    However shallow its notch is: of 1.8, the areas of the other two triangles are 2 and 0.2.
    """
    arrow = np.roll([[0.0, 0, 5], [2, -1, 5], [notch, 0, 5], [2, 1, 5]], first, axis=0)
    triangles = divided(arrow, np.arange(4)[None])
    a, b, c = arrow[triangles].swapaxes(0, 1)
    areas = np.cross(b - a, c - a)[:, 2] / 2
    assert (areas > 0).all()
    assert areas.sum() == pytest.approx(notch)


def test_faces_are_named_by_the_number_of_their_corners():
    """Successive ones with equally many are one block."""
    faces = [np.arange(k) for k in (0, 1, 2, 3, 3, 4, 5, 6, 3)]
    blocks = [(kind, cells.shape) for kind, cells in face_blocks(faces)]
    assert blocks == [
        *(("empty", (1, 0)), ("vertex", (1, 1)), ("line", (1, 2)), ("triangle", (2, 3))),
        *(("quad", (1, 4)), ("polygon", (1, 5)), ("polygon", (1, 6)), ("triangle", (1, 3))),
    ]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (
            "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n",
            "holds no mesh: cells must not be flat; cell 0 is",
        ),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", r"holds no mesh: .* cells\[0, 2\] is 3"),
        ("v 0 0 7\nf 1 1 1\n", r"holds no mesh: cells must have distinct vertices; cells\[0\] is"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\n", "holds points only; triangles or"),
    ],
)
def test_invalid_meshes_are_refused(text, words, tmp_path):
    """The message has the path and the sentence that the same mesh gets as arrays."""
    (tmp_path / "bad.obj").write_text(text)
    with pytest.raises(ValueError, match=f"bad.obj {words}"):
        read_mesh(tmp_path / "bad.obj")


@pytest.mark.parametrize(("before", "which"), [("", 0), ("f 1 2 3\n", 1)])
def test_a_triangle_with_a_missing_vertex_is_refused(before, which, tmp_path):
    """This is the only requirement on the triangles of a surface. The first such is named."""
    vertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\n"
    (tmp_path / "bad.obj").write_text(f"{vertices}{before}f 1 2 4\nf 1 2 3\nf 2 3 5\n")
    words = rf"bad.obj: triangle {which} has the corners \[0, 1, 3\]"
    with pytest.raises(ValueError, match=words):
        read_surface(tmp_path / "bad.obj")


def test_limits_of_the_formats_are_checked_before_writing(tmp_path):
    """No file is created if the format cannot hold the mesh or the data."""
    plane, space = mesh_in(2), mesh_in(3)
    for suffix in SURFACES:
        path = tmp_path / f"mesh{suffix}"
        with pytest.raises(ValueError, match=r"cannot hold tetrahedra; .vtk, .vtu and .msh can"):
            write_mesh(path, space)
        with pytest.raises(ValueError, match=r"cannot hold data; .vtk, .vtu and .msh can"):
            write_mesh(path, plane, {"f": np.zeros(30)})
    with pytest.raises(ValueError, match=r"mesh.txt must end with the suffix of a known format"):
        write_mesh(tmp_path / "mesh.txt", plane)
    with pytest.raises(ValueError, match=r"f must have one entry for each point, shape \(30, "):
        write_mesh(tmp_path / "mesh.vtk", plane, {"f": np.zeros(29)})
    with pytest.raises(ValueError, match=r"p must have one entry for each cell"):
        write_mesh(tmp_path / "mesh.vtk", plane, cell_data={"p": np.zeros(30)})
    with pytest.raises(ValueError, match=r"f must be real to be written; got the type complex128"):
        write_mesh(tmp_path / "mesh.vtk", plane, {"f": np.zeros(30) * 1j})
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("suffix", [*SURFACES, *WITH_DATA])
def test_a_missing_file_raises_file_not_found_error(suffix, tmp_path):
    with pytest.raises(FileNotFoundError, match=f"none{suffix}"):
        read_mesh(tmp_path / f"none{suffix}")


def test_without_meshio_the_install_command_is_shown(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "meshio.vtk", None)
    with pytest.raises(ImportError, match=r"meshio is not .* the extra 'mesh': pip install "):
        read_mesh(tmp_path / "mesh.vtk")


@pytest.mark.parametrize(
    ("faces", "shapes", "regions"),
    [
        (("3 0 1 2 10", "3 0 2 3 20"), [(2, 3)], [[10, 20]]),
        (("3 0 1 2 10", "3 0 2 3 20", "4 1 4 5 2 30"), [(2, 3), (1, 4)], [[10, 20], [30]]),
    ],
)
def test_data_of_triangles_and_quadrilaterals_in_one_list_are_parted(
    tmp_path, faces, shapes, regions
):
    """A PLY file has one list of faces; the data of each block belong to its cells."""
    lines = (
        *("ply", "format ascii 1.0", "element vertex 6"),
        *(f"property float {name}" for name in "xyz"),
        *(f"element face {len(faces)}", "property list uchar int vertex_indices"),
        *("property float region", "end_header"),
        *("0 0 0", "1 0 0", "1 1 0", "0 1 0", "2 0 0", "2 1 0"),
        *faces,
    )
    path = tmp_path / "faces.ply"
    path.write_text("\n".join(lines) + "\n")
    content = read_ply(path)
    assert [cells.shape for _, cells in content.cells] == shapes
    assert [data.tolist() for data in content.cell_data["region"]] == regions
