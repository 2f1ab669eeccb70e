"""Triangles come out of files as they stand there, and what is no file of triangles is refused."""

import numpy as np
import pytest

from fieldrecon.io.meshes import read_triangles, write_triangles
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


def test_an_ascii_file_is_read_as_it_stands(tmp_path):
    """Three points for each triangle, equal ones too, in the order of the file."""
    points, triangles = read_triangles(written(tmp_path, ASCII))
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


def test_several_solids_and_other_line_ends_are_one_mesh(tmp_path):
    """Two solids in a file, with the line ends of Windows."""
    points, triangles = read_triangles(written(tmp_path, (ASCII + ASCII).replace("\n", "\r\n")))
    assert (len(points), len(triangles)) == (12, 4)


def test_long_files_are_read_in_pieces(tmp_path, monkeypatch):
    """The pieces end with lines, wherever the blocks do."""
    whole = read_triangles(written(tmp_path, ASCII * 5))[0]
    monkeypatch.setattr("fieldrecon.io.stl._BLOCK_BYTES", 37)
    np.testing.assert_array_equal(read_triangles(tmp_path / "mesh.stl")[0], whole)


@pytest.mark.parametrize("header", [b"", b"solid, but not in letters"])
def test_a_binary_file_is_known_by_its_length(header, tmp_path):
    """Its numbers keep their single precision; a header that begins with solid deceives nobody."""
    points, triangles = sphere(1)
    write_triangles(tmp_path / "ball.stl", points, triangles)
    content = (tmp_path / "ball.stl").read_bytes()
    back, soup = read_triangles(written(tmp_path, header.ljust(80) + content[80:]))
    assert back.dtype == np.float32
    np.testing.assert_array_equal(back[soup], points[triangles].astype(np.float32))


def test_normals_in_the_file_are_those_of_the_triangles(tmp_path):
    """Unit normals by the right hand; zero where there is no area."""
    points, triangles = cube(1)
    write_triangles(tmp_path / "cube.stl", points, np.concatenate([triangles, [[0, 0, 1]]]))
    content = np.frombuffer((tmp_path / "cube.stl").read_bytes()[84:], dtype=np.uint8)
    normals = content.reshape(-1, 50)[:, :12].copy().view("<f4")
    outward = points[triangles].mean(axis=1) - 0.5
    assert (np.einsum("ki,ki->k", normals[:-1], outward) > 0.4).all()
    np.testing.assert_allclose(np.linalg.norm(normals[:-1], axis=1), 1)
    assert not normals[-1].any()


@pytest.mark.parametrize("suffix", [".ply", ".obj", ".off"])
def test_other_files_keep_their_vertices(suffix, tmp_path):
    """The same points and triangles, to the last bit, those that nothing uses too."""
    points, triangles = sphere(1)
    points = np.concatenate([points, points[:2], [[9, 9, 9]]])
    write_triangles(tmp_path / f"mesh{suffix}", points, triangles)
    back = read_triangles(tmp_path / f"mesh{suffix}")
    np.testing.assert_array_equal(back[0], points)
    np.testing.assert_array_equal(back[1], triangles)


def test_a_soup_is_no_mesh_with_open_edges(tmp_path):
    """The error that a library would hide is told apart from errors of the surface."""
    write_triangles(tmp_path / "cube.stl", *cube(1))
    audit = audit_mesh(*read_triangles(tmp_path / "cube.stl"))
    assert (audit.vertices, audit.triangles, audit.soup, audit.clean) == (36, 12, True, True)


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
def test_what_is_no_file_of_triangles_is_refused(content, words, tmp_path):
    """In words, with the path."""
    with pytest.raises(ValueError, match=rf"mesh.stl .*{words}"):
        read_triangles(written(tmp_path, content))


def test_an_unknown_format_is_not_written(tmp_path):
    """The suffixes that are known are told."""
    with pytest.raises(ValueError, match=r"must end with \.stl, \.ply, \.obj or \.off"):
        write_triangles(tmp_path / "mesh.dxf", *cube(1))
    with pytest.raises(FileNotFoundError):
        read_triangles(tmp_path / "nowhere.stl")
