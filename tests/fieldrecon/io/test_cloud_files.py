"""Point clouds in files: PLY, OBJ, STL, VTK and tables are read; errors name the file."""

import struct

import numpy as np
import pytest

import fieldrecon as fr
from fieldrecon.io.clouds import read_cloud
from fieldrecon.io.obj import read_obj
from fieldrecon.io.ply import read_elements, read_ply
from fieldreport.experiments.triangles.triangle_shapes import sphere

POINTS, TRIANGLES = sphere(1)
ORDERS = {"binary_little_endian": "<", "binary_big_endian": ">"}


def ply(kind, *, faces=None, strip=None, normals=None, points=POINTS, rows=None):
    """Bytes of a PLY file, written independently of the reader."""
    names = "xyz" if normals is None else ("x", "y", "z", "nx", "ny", "nz")
    table = points if normals is None else np.hstack([points, normals])
    head = f"ply\nformat {kind} 1.0\ncomment a test\nelement vertex {rows or len(table)}\n"
    head += "".join(f"property double {name}\n" for name in names)
    lists = []
    if faces is not None:
        head += f"element face {len(faces)}\nproperty uchar flags\n"
        head += "property list uchar int vertex_indices\n"
        lists = [(7, face) for face in faces]
    if strip is not None:
        head += "element tristrips 1\nproperty list int int vertex_indices\n"
    head += "end_header\n"
    if kind == "ascii":
        lines = [" ".join(map(repr, map(float, row))) for row in table]
        lines += [" ".join(map(str, (flag, len(face), *face))) for flag, face in lists]
        lines += [] if strip is None else [" ".join(map(str, (len(strip), *strip)))]
        return (head + "\n".join(lines) + "\n").encode()
    o = ORDERS[kind]
    body = b"".join(struct.pack(f"{o}{len(row)}d", *row) for row in table)
    body += b"".join(
        struct.pack(f"{o}BB{len(face)}i", flag, len(face), *face) for flag, face in lists
    )
    body += b"" if strip is None else struct.pack(f"{o}{len(strip) + 1}i", len(strip), *strip)
    return head.encode() + body


@pytest.mark.parametrize("kind", ["ascii", *ORDERS])
@pytest.mark.parametrize("mixed", [False, True])
def test_ply_is_read_in_ascii_and_both_byte_orders(tmp_path, kind, mixed):
    """Points, normals and flags are reproduced; faces may have three or more corners."""
    path = tmp_path / "cloud.ply"
    faces = [list(t) for t in TRIANGLES] + ([[0, 1, 2, 3], [4, 5, 6, 7, 8]] if mixed else [])
    path.write_bytes(ply(kind, faces=faces, normals=2 * POINTS))
    cloud = read_cloud(path)
    np.testing.assert_array_equal(cloud.points, POINTS)
    np.testing.assert_array_equal(cloud.normals, 2 * POINTS)
    np.testing.assert_array_equal(cloud.triangles[: len(TRIANGLES)], TRIANGLES)
    added = cloud.triangles[len(TRIANGLES) :]
    corners = [{*added[:2].ravel()}, {*added[2:].ravel()}]
    assert corners == ([{0, 1, 2, 3}, {4, 5, 6, 7, 8}] if mixed else [set(), set()])
    assert len(added) == 5 * mixed
    assert np.asarray(read_elements(path)["face"]["flags"]).tolist() == [7] * len(faces)


def test_other_numbers_of_the_vertices_of_a_ply_file_are_data(tmp_path):
    """Not the coordinates, and not lists of different lengths."""
    head = "ply\nformat ascii 1.0\nelement vertex 2\nproperty float quality\n"
    head += "".join(f"property float {name}\n" for name in "xyz")
    head += "property list uchar int near\nend_header\n"
    path = tmp_path / "quality.ply"
    path.write_text(head + "0.5 1 2 3 1 1\n0.25 4 5 6 2 0 0\n")
    content = read_ply(path)
    assert content.points.tolist() == [[1, 2, 3], [4, 5, 6]]
    assert {k: v.tolist() for k, v in content.point_data.items()} == {"quality": [0.5, 0.25]}


@pytest.mark.parametrize("kind", ["ascii", *ORDERS])
def test_triangle_strips_are_consistently_oriented(tmp_path, kind):
    """Every second triangle of a strip is reversed.

    The index -1 begins a new strip at any place, and repeated indices add no triangle.
    """
    path = tmp_path / "strips.ply"
    for strip in (
        [[0, 1]],
        [[2, 0, 1]],
        [[0, 1, 2, 3], [4, 5, 6, 7, 7, 8]],
        [[*range(7, 14)]],
        [[0, 1, 2, 3, 4], [5, 6, 7, 7, 8], [9, 10]],
        [[3, 4], [5, 6, 5, 7], [], [8, 8, 9, 10]],
    ):
        triangles = []
        for one in strip:
            for k, (a, b, c) in enumerate(zip(one, one[1:], one[2:], strict=False)):
                if len({a, b, c}) == 3:
                    triangles.append([b, a, c] if k % 2 else [a, b, c])
        joined = [index for one in strip for index in (*one, -1)][:-1]
        path.write_bytes(ply(kind, strip=joined))
        assert read_ply(path).face_triangles().tolist() == triangles


def test_normals_are_taken_from_triangles_if_the_file_has_none(tmp_path):
    """Normals of OBJ and STL files point outward by the orientation; corners of STL are merged."""
    fr.io.write_triangles(tmp_path / "ball.stl", POINTS, TRIANGLES)
    lines = [f"v {x} {y} {z}" for x, y, z in POINTS]
    lines += [f"f {a + 1}/1 {b + 1}//2 {c - len(POINTS)}" for a, b, c in TRIANGLES]
    (tmp_path / "ball.obj").write_text("# a ball\n" + "\n".join(lines))
    for name in ("ball.stl", "ball.obj"):
        cloud = read_cloud(tmp_path / name)
        assert cloud.points.shape == POINTS.shape
        assert cloud.normals_of == "triangles in the file"
        n = cloud.normals / np.linalg.norm(cloud.normals, axis=1, keepdims=True)
        assert np.einsum("ij,ij->i", n, cloud.points).min() > 0.95


@pytest.mark.parametrize("count", [3, 4, 5])
def test_an_obj_file_with_one_normal_for_each_vertex_has_them(tmp_path, count):
    """With another number of them it is not known which vertex has which."""
    lines = [f"v {x} {y} {z}" for x, y, z in POINTS[:4]]
    lines += [f"vn {x} {y} {z}" for x, y, z in -POINTS[:count]]
    (tmp_path / "a.obj").write_text("\n".join([*lines, "f 1 2 3", "f 2 3 4"]))
    mesh = read_obj(tmp_path / "a.obj")
    np.testing.assert_array_equal(mesh.points, POINTS[:4])
    assert [a.tolist() for a in mesh.point_data.values()] == [(-POINTS[:4]).tolist()] * (count == 4)


@pytest.mark.parametrize("suffix", [".xyz", ".csv", ".npz"])
def test_tables_are_read_as_clouds(tmp_path, suffix):
    """Columns 4 to 6 without names are normals if more than nine tenths are about one long.

    Those with names have any length.
    """
    path = tmp_path / f"cloud{suffix}"
    both = np.hstack([POINTS + 5, POINTS])
    if suffix == ".npz":
        np.savez(path, **dict(zip(("x", "y", "z", "nx", "ny", "nz"), both.T, strict=True)))
    else:
        header = "x,y,z,nx,ny,nz" if suffix == ".csv" else ""
        np.savetxt(path, both, delimiter="," if header else " ", header=header, comments="")
    cloud = read_cloud(path)
    np.testing.assert_allclose(cloud.points, POINTS + 5)
    np.testing.assert_allclose(cloud.normals, POINTS)
    if suffix == ".csv":
        many = np.hstack([POINTS, 9 * POINTS])
        np.savetxt(path, many, delimiter=",", header=header, comments="")
        np.testing.assert_allclose(read_cloud(path).normals, 9 * POINTS)
    if suffix == ".xyz":
        few = np.arange(len(POINTS)) < 4
        many = np.arange(len(POINTS)) < 5
        for factor, normals in ((100, 0), (2, 0), (0.5, 0), (1.05, 1), (0.95, 1)):
            lengths = np.full(len(POINTS), factor)
            np.savetxt(path, np.hstack([POINTS, lengths[:, None] * POINTS]))
            assert (read_cloud(path).normals is not None) == normals
        np.savetxt(path, np.hstack([both, np.full((len(both), 2), 7)]))
        np.testing.assert_allclose(read_cloud(path).normals, POINTS)
        for length in (0.9, 1.1):
            np.savetxt(path, np.hstack([POINTS, 0 * POINTS + [0, length, 0]]))
            assert read_cloud(path).normals is None
        np.savetxt(path, np.hstack([POINTS, POINTS * (1 + (np.arange(42) == 7))[:, None]])[:10])
        assert read_cloud(path).normals is None
        for some, normals in ((few, 1), (many, 0)):
            np.savetxt(path, np.hstack([POINTS, np.where(some, 2, 1)[:, None] * POINTS]))
            assert (read_cloud(path).normals is not None) == normals


@pytest.mark.parametrize(
    ("rows", "points", "lines"),
    [
        ([3], "1 point has coordinates that are not finite, and was", "1 row was"),
        ([3, 5], "2 points have coordinates that are not finite, and were", "2 rows were"),
    ],
)
def test_non_finite_points_are_skipped_and_reported(tmp_path, rows, points, lines):
    """In a binary file their triangles are removed too; in a text the line is reported."""
    bad = POINTS.copy()
    bad[rows, 1] = np.nan
    path = tmp_path / "cloud.ply"
    path.write_bytes(ply("binary_little_endian", points=bad, faces=TRIANGLES.tolist()))
    cloud = read_cloud(path)
    np.testing.assert_array_equal(cloud.points, np.delete(POINTS, rows, axis=0))
    kept = TRIANGLES[~np.isin(TRIANGLES, rows).any(axis=1)]
    np.testing.assert_array_equal(cloud.points[cloud.triangles], POINTS[kept])
    assert cloud.warnings == (f"{points} skipped.",)
    np.savetxt(tmp_path / "cloud.xyz", bad)
    (warning,) = read_cloud(tmp_path / "cloud.xyz").warnings
    assert warning.startswith(f"{lines} skipped; the first, line 4: y must be a finite number")


def test_points_of_a_vtk_file_are_read_with_their_normals(tmp_path):
    """meshio reads them, whatever the cells are; ten points are enough."""
    import meshio

    points = POINTS[:10]
    for data in ({}, {"Normals": 2 * points}):
        mesh = meshio.Mesh(points, [("vertex", np.arange(10)[:, None])], point_data=data)
        mesh.write(tmp_path / "cloud.vtk")
        cloud = read_cloud(tmp_path / "cloud.vtk")
        np.testing.assert_array_equal(cloud.points, points)
        if data:
            np.testing.assert_array_equal(cloud.normals, 2 * points)
        else:
            assert cloud.normals is None


@pytest.mark.parametrize("kind", ["ascii", *ORDERS])
def test_a_list_of_no_faces_at_the_end_of_a_file_is_empty(tmp_path, kind):
    (tmp_path / "cloud.ply").write_bytes(ply(kind, faces=[]))
    assert read_elements(tmp_path / "cloud.ply")["face"]["vertex_indices"].shape == (0, 0)
    assert read_cloud(tmp_path / "cloud.ply").triangles.shape == (0, 3)


def test_normals_of_zero_are_no_normals(tmp_path):
    """Then those of the triangles are taken, if there are any."""
    path = tmp_path / "cloud.ply"
    path.write_bytes(ply("ascii", normals=0 * POINTS))
    assert read_cloud(path).normals is None
    path.write_bytes(ply("ascii", normals=0 * POINTS, faces=TRIANGLES.tolist()))
    cloud = read_cloud(path)
    assert cloud.normals_of == "triangles in the file"
    assert np.einsum("ij,ij->i", cloud.normals, POINTS).min() > 0


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("a.ply", b"solid", "does not begin with the word ply"),
        ("a.ply", b"ply\nformat ascii 1.0\n", "header has no end"),
        ("a.ply", b"ply\nformat ascii 1.0\nend_header", "header has no end"),
        ("a.ply", b"ply\nformat binary 1.0\nend_header\n", "the line 'format binary 1.0'"),
        ("a.ply", b"ply\nformat ascii 1.0\nelement face 0\nend_header\n", "no vertices with x"),
        *(
            ("a.ply", b"ply\nformat ascii 1.0\n" + line + b"\nend_header\n", f"the line '{words}'")
            for line, words in (
                (b"property float x", "property float x"),
                (b"property list uchar int x", "property list uchar int x"),
                (b"element vertex 1\nproperty long x", "property long x"),
                (b"element vertex 1\nproperty list uchar long x", "property list uchar long x"),
                (b"element vertex -1", "element vertex -1"),
            )
        ),
        ("a.ply", ply("binary_big_endian")[:-30], "announces 42 vertices and holds 40"),
        ("a.ply", ply("ascii", rows=50), "announces 50 vertices and holds 42"),
        (
            "a.ply",
            ply("binary_little_endian", faces=[[0, 1, 2]] * 9)[:-5],
            "announces 9 faces and holds 8",
        ),
        (
            "a.ply",
            ply("ascii", faces=[[0, 1, 99]]),
            r"triangle 0 has the corners \[0, 1, 99\], and the vertices are numbered from 0 to 41",
        ),
        ("a.ply", ply("ascii", faces=[[0, 1, -1]]), r"triangle 0 has the corners \[0, 1, -1\]"),
        ("a.ply", ply("ascii", faces=[[0, 1, 42]]), r"triangle 0 has the corners \[0, 1, 42\]"),
        ("a.ply", ply("ascii").replace(b"0.0", b"zero"), "a word that is not a number"),
        ("a.obj", b"v 1 2 3\nv 1 x 2\n", "line 2: 'v 1 x 2'"),
        ("a.obj", b"v 1 2\n", "fewer than three coordinates"),
        ("a.xyz", b"1 2 3\n4 5 6\n" * 4 + b"7 8 9\n", "9 points; a surface takes 10"),
        ("a.csv", b"x,y,height\n1,2,3\n", "no column 'z'"),
        ("a.stl", b"", "not an STL file"),
    ],
)
def test_bad_clouds_are_refused(tmp_path, name, content, words):
    """The message has the name of the file, what is wrong, and where."""
    (tmp_path / name).write_bytes(content)
    with pytest.raises(ValueError, match=words) as caught:
        read_cloud(tmp_path / name)
    assert name in str(caught.value)


def test_a_missing_file_raises_file_not_found_error(tmp_path):
    with pytest.raises(FileNotFoundError):
        read_cloud(tmp_path / "none.ply")


def test_a_strip_of_two_points_has_no_triangle(tmp_path):
    """Alone or beside another."""
    path = tmp_path / "cloud.ply"
    content = ply("ascii", strip=[0, 1])
    path.write_bytes(content)
    assert read_cloud(path).triangles.shape == (0, 3)
    path.write_bytes(content.replace(b"tristrips 1", b"tristrips 2") + b"3 4 5 6\n")
    assert read_cloud(path).triangles.tolist() == [[4, 5, 6]]


@pytest.mark.parametrize("kind", ["ascii", *ORDERS])
@pytest.mark.parametrize("length", [-1, -2])
def test_a_list_of_negative_length_ends_the_file(tmp_path, kind, length):
    """What follows it cannot be read: the rows before it are counted."""
    content = ply(kind, faces=[[0, 1, 2], [3, 4, 5], [6, 7, 8]])
    content = content.replace(b"list uchar", b"list char")
    if kind == "ascii":
        content = content.replace(b"7 3 3 4 5", b"7 %d 3 4 5" % length)
    else:
        content = content[:-27] + struct.pack("b", length) + content[-26:]
    (tmp_path / "cloud.ply").write_bytes(content)
    with pytest.raises(ValueError, match="it announces 3 faces and holds 1"):
        read_ply(tmp_path / "cloud.ply")


@pytest.mark.parametrize("length", [b"-1", b"-3", b"1e999", b"nan"])
def test_a_first_list_without_a_length_ends_a_text_file(tmp_path, length):
    """And the next one, of a list in a row that has another one."""
    for kept in (0, 1):
        content = ply("ascii", faces=[[0, 1, 2], [3, 4, 5], [6, 7]][: kept + 1])
        at = content.rindex(b"3 0 1 2" if kept == 0 else b"3 3 4 5")
        (tmp_path / "cloud.ply").write_bytes(content[:at] + length + content[at + 1 :])
        with pytest.raises(ValueError, match=f"it announces {kept + 1} faces and holds {kept}"):
            read_ply(tmp_path / "cloud.ply")


@pytest.mark.parametrize("kind", ORDERS)
def test_a_first_list_of_negative_length_ends_the_file(tmp_path, kind):
    content = ply(kind, faces=[[0, 1, 2]])
    content = content[:-13].replace(b"list uchar", b"list char") + b"\xff" + content[-12:]
    (tmp_path / "cloud.ply").write_bytes(content)
    with pytest.raises(ValueError, match="it announces 1 faces and holds 0"):
        read_ply(tmp_path / "cloud.ply")


@pytest.mark.parametrize("kind", ["ascii", *ORDERS])
def test_lists_of_other_lengths_are_one_array_each(tmp_path, kind):
    """Also one without entries, between others and at the end."""
    faces = [[0, 1, 2], [], [3, 4, 5, 6], []]
    (tmp_path / "cloud.ply").write_bytes(ply(kind, faces=faces))
    read = read_elements(tmp_path / "cloud.ply")["face"]
    assert [corners.tolist() for corners in read["vertex_indices"]] == faces
    assert [corners.dtype for corners in read["vertex_indices"]] == [np.int32] * 4


@pytest.mark.parametrize("kind", ["ascii", *ORDERS])
@pytest.mark.parametrize("few", [0, 1, 2])
def test_equally_long_lists_are_one_array_of_their_type(tmp_path, kind, few):
    """Whatever stands between them; the elements before and after have rows of other lengths."""
    head = f"ply\nformat {kind} 1.0\nelement row 2\nproperty uchar flag\n"
    head += "property list uchar int long\nproperty double weight\n"
    head += "property list ushort short few\nelement end 1\nproperty list uchar int long\n"
    head += "element nothing 0\nelement mark 2\nproperty uchar mark\n"
    rows = [(k, 3, k, -5, 6, k / 4, few, *range(k, k + few)) for k in (1, 2)]
    if kind == "ascii":
        rows += [(1, 9), (4,), (5,)]
        body = "".join(" ".join(map(str, row)) + "\n" for row in rows).encode()
    else:
        o = ORDERS[kind]
        body = b"".join(struct.pack(f"{o}BBiiidH{few}h", *row) for row in rows)
        body += struct.pack(f"{o}BiBB", 1, 9, 4, 5)
    (tmp_path / "a.ply").write_bytes(f"{head}end_header\n".encode() + body)
    read = read_elements(tmp_path / "a.ply")
    wanted = {
        "flag": np.array([1, 2], np.uint8),
        "long": np.array([[1, -5, 6], [2, -5, 6]], np.int32),
        "weight": np.array([0.25, 0.5]),
        "few": np.array([[*range(k, k + few)] for k in (1, 2)], np.int16),
    }
    for name, array in wanted.items():
        np.testing.assert_array_equal(read["row"][name], array, strict=True)
    assert read["end"]["long"].tolist() == [[9]]
    assert (read["nothing"], read["mark"]["mark"].tolist()) == ({}, [4, 5])


@pytest.mark.parametrize("kind", ["ascii", *ORDERS])
def test_a_list_of_no_faces_before_others_is_empty(tmp_path, kind):
    """Its rows have no length, whatever follows."""
    content = ply(kind, strip=[4, 5, 6]).replace(
        b"element tristrips", b"element face 0\nproperty list uchar int corners\nelement tristrips"
    )
    (tmp_path / "a.ply").write_bytes(content)
    read = read_elements(tmp_path / "a.ply")
    assert read["face"]["corners"].shape == (0, 0)
    assert read["tristrips"]["vertex_indices"].tolist() == [[4, 5, 6]]


def test_a_normal_that_is_not_finite_is_unknown(tmp_path):
    """It is zero in all its components, and the others are kept, as are their points."""
    points, normals = POINTS.copy(), 2 * POINTS
    normals[3, 1], normals[7, 0], points[5, 2] = np.nan, np.inf, np.nan
    (tmp_path / "cloud.ply").write_bytes(ply("ascii", points=points, normals=normals))
    cloud = read_cloud(tmp_path / "cloud.ply")
    wanted = 2 * POINTS
    wanted[[3, 7]] = 0
    np.testing.assert_array_equal(cloud.normals, np.delete(wanted, 5, axis=0))
    np.testing.assert_array_equal(cloud.points, np.delete(POINTS, 5, axis=0))


def test_a_text_may_end_before_a_list(tmp_path):
    """None is wanted there, or the rows above are counted."""
    path = tmp_path / "a.ply"
    head = "ply\nformat ascii 1.0\nelement face {}\nproperty list uchar int corners\nend_header\n"
    path.write_text(head.format(0))
    assert read_elements(path)["face"]["corners"].shape == (0, 0)
    path.write_text(head.format(3) + "3 0 1 2\n4 0 1 2 3\n")
    with pytest.raises(ValueError, match="it announces 3 faces and holds 2"):
        read_elements(path)
