"""Files of triangles: STL in ASCII and binary, PLY, OBJ and OFF, and files that are refused."""

import numpy as np
import pytest

from fieldrecon.io.meshes import read_triangles, write_triangles
from fieldrecon.io.ply import read_elements
from fieldrecon.io.stl import read_stl
from fieldrecon.triangles.audit import audit_mesh
from fieldreport.experiments.triangles.triangle_shapes import cube, sphere

ASCII = """solid two
  facet normal 0 0 1
    outer loop
      vertex 0 0 0
      vertex 1.5e0 0 0
      vertex 0 1 0
    endloop
  endfacet
  facet normal 0 0 1
    outer loop
      VERTEX 1.5 0 0
      vertex 1 1 -2.25
      vertex 0 1 0
    endloop
  endfacet
endsolid two
"""


def written(folder, content, name="mesh.stl"):
    path = folder / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


def test_ascii_stl_is_read_without_merging_vertices(tmp_path):
    """Each triangle has its own three points, in the order of the file."""
    points, triangles = read_triangles(written(tmp_path, ASCII))
    np.testing.assert_array_equal(read_triangles(written(tmp_path, ASCII.upper()))[0], points)
    assert points.dtype == np.float64
    assert points.tolist() == [
        [0, 0, 0],
        [1.5, 0, 0],
        [0, 1, 0],
        [1.5, 0, 0],
        [1, 1, -2.25],
        [0, 1, 0],
    ]
    assert triangles.tolist() == [[0, 1, 2], [3, 4, 5]]


def test_several_solids_with_windows_line_ends_are_one_mesh(tmp_path):
    points, triangles = read_triangles(written(tmp_path, (ASCII + ASCII).replace("\n", "\r\n")))
    assert (len(points), len(triangles)) == (12, 4)


def test_ascii_stl_is_read_in_blocks(tmp_path, monkeypatch):
    """The result does not depend on where the blocks end."""
    whole = read_triangles(written(tmp_path, ASCII * 5))[0]
    monkeypatch.setattr("fieldrecon.io.stl._BLOCK_BYTES", 37)
    np.testing.assert_array_equal(read_triangles(tmp_path / "mesh.stl")[0], whole)


@pytest.mark.parametrize("header", [b"", b"solid, but not in letters"])
def test_binary_stl_is_recognized_by_its_length(header, tmp_path):
    """Points keep single precision. A header that begins with "solid" does not make it ASCII."""
    points, triangles = sphere(1)
    write_triangles(tmp_path / "ball.stl", points, triangles)
    content = (tmp_path / "ball.stl").read_bytes()
    read, soup = read_triangles(written(tmp_path, header.ljust(80) + content[80:]))
    assert read.dtype == np.float32
    np.testing.assert_array_equal(read[soup], points[triangles].astype(np.float32))


def test_stl_normals_are_unit_normals_of_the_triangles(tmp_path):
    """Normals follow the right-hand rule; a triangle without area has the normal zero."""
    points, triangles = cube(1)
    write_triangles(tmp_path / "cube.stl", points, np.concatenate([triangles, [[0, 0, 1]]]))
    content = np.frombuffer((tmp_path / "cube.stl").read_bytes()[84:], dtype=np.uint8)
    normals = content.reshape(-1, 50)[:, :12].copy().view("<f4")
    outward = points[triangles].mean(axis=1) - 0.5
    assert (np.einsum("ki,ki->k", normals[:-1], outward) > 0.4).all()
    np.testing.assert_allclose(np.linalg.norm(normals[:-1], axis=1), 1)
    assert not normals[-1].any()


@pytest.mark.parametrize("suffix", [".ply", ".obj", ".off"])
def test_ply_obj_and_off_reproduce_vertices_and_triangles(suffix, tmp_path):
    """Repeated and unreferenced vertices are kept, to the last bit."""
    points, triangles = sphere(1)
    points = np.concatenate([points, points[:2], [[9, 9, 9]]])
    write_triangles(tmp_path / f"mesh{suffix}", points, triangles)
    read = read_triangles(tmp_path / f"mesh{suffix}")
    np.testing.assert_array_equal(read[0], points)
    np.testing.assert_array_equal(read[1], triangles)


def test_a_polygon_soup_is_reported_as_such(tmp_path):
    """Unmerged vertices of an STL file are reported as a soup and not as open edges."""
    write_triangles(tmp_path / "cube.stl", *cube(1))
    audit = audit_mesh(*read_triangles(tmp_path / "cube.stl"))
    assert (audit.vertices, audit.triangles, audit.soup, audit.clean) == (36, 12, True, True)


def test_merged_vertices_are_shared(tmp_path):
    """The content of the file says so, and merging it again changes nothing."""
    write_triangles(tmp_path / "cube.stl", *cube(1))
    merged = read_stl(tmp_path / "cube.stl").with_merged_vertices()
    assert not merged.separate_corners
    assert len(merged.points) == 8
    assert merged.with_merged_vertices() is merged


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", "is not an STL file"),
        (b"\0" * 84, "holds no triangles"),
        (b"\0" * 80 + b"\2\0\0\0" + b"\0" * 50, "its length is not that of a binary file"),
        ("solid nothing\nendsolid nothing\n", "holds no triangles"),
        (ASCII.replace("vertex 1 1 -2.25\n", ""), "begins 2 facets and holds 5 vertices"),
        (ASCII.replace("1.5e0", "1.5ee"), "whose coordinates are not numbers"),
        (ASCII.replace("1.5e0", "nan"), "holds coordinates that are not finite"),
        (ASCII.replace("1.5e0", "1e999"), "holds coordinates that are not finite"),
    ],
)
def test_bad_stl_files_are_refused(content, words, tmp_path):
    """The message has the path and says what is wrong."""
    with pytest.raises(ValueError, match=rf"mesh.stl .*{words}"):
        read_triangles(written(tmp_path, content))


def test_unknown_formats_are_refused(tmp_path):
    """The message lists the known suffixes."""
    with pytest.raises(ValueError, match=r"must end with \.stl, \.ply, \.obj or \.off"):
        write_triangles(tmp_path / "mesh.dxf", *cube(1))
    with pytest.raises(FileNotFoundError):
        read_triangles(tmp_path / "nowhere.stl")


def test_weights_and_colours_of_obj_vertices_are_left_out(tmp_path):
    """A vertex may have a fourth number, a weight, or six, with its colour."""
    for more in ("", " 1.0", " 0.2 0.3 0.4"):
        lines = "".join(f"v {corner}{more}\n" for corner in ("0 0 0", "1 0 0", "0 1 0"))
        points, triangles = read_triangles(written(tmp_path, lines + "f 1 2 3\n", "mesh.obj"))
        assert points.tolist() == [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
        assert triangles.tolist() == [[0, 1, 2]]


def test_quads_are_refused_unless_triangles_are_asked_for(tmp_path):
    """Then by a diagonal from their first corner."""
    path = written(tmp_path, "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n", "mesh.obj")
    with pytest.raises(ValueError, match=r"mesh.obj holds quad cells"):
        read_triangles(path)
    assert read_triangles(path, triangulate=True)[1].tolist() == [[0, 1, 2], [0, 2, 3]]


def test_a_binary_element_of_single_bytes_is_read(tmp_path):
    """It stands at the end of the file, one byte for each vertex."""
    header = (
        *("ply", "format binary_little_endian 1.0", "element vertex 3"),
        *(f"property float {name}" for name in "xyz"),
        *("element face 1", "property list uchar int vertex_indices"),
        *("element flag 3", "property uchar set", "end_header", ""),
    )
    numbers = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], "<f4").tobytes()
    body = numbers + bytes([3]) + np.arange(3, dtype="<i4").tobytes() + bytes([1, 0, 1])
    path = written(tmp_path, "\n".join(header).encode() + body, "mesh.ply")
    assert read_triangles(path)[1].tolist() == [[0, 1, 2]]
    assert read_elements(path)["flag"]["set"].tolist() == [1, 0, 1]


def test_indices_of_obj_files_count_back_if_negative(tmp_path):
    """From the vertices that stand above, also with tabs and on two lines; none is beyond them."""
    above, below = "v 0 0 0\nv\t1 0 0\nv 0 1 0\n", "v 0 0 1\n"
    for faces in ("f -3 -2 -1\n", "f 1// -2/4 \\\n-1/4/4\n", "f\t-3/1 2 3\n"):
        path = written(tmp_path, above + faces + below + "f -1 1 -3\n", "mesh.obj")
        assert read_triangles(path)[1].tolist() == [[0, 1, 2], [3, 0, 1]]
    none = {"f 0 1 2": "vertices are numbered from 1", "f -4 1 2": "there are 3 vertices before"}
    for wrong, why in none.items():
        with pytest.raises(ValueError, match=f"mesh.obj, line 4: '{wrong}': {why}"):
            read_triangles(written(tmp_path, above + wrong, "mesh.obj"))
