"""The command `fieldrecon surface`: from a small point cloud or polygon soup to a mesh."""

import re
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import fieldrecon as fr
from fieldrecon.cli.main import main
from fieldrecon.cli.surface import _precision_warning
from fieldrecon.io.meshes import read_triangles
from fieldrecon.plotting import surface_picture
from fieldrecon.solids.shapes import Ball, Torus, sample_surface
from fieldrecon.triangles.distances import distances_to_triangles
from fieldreport.experiments.triangles.triangle_shapes import sphere


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Change to an empty folder and draw small pictures."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(surface_picture, "_PIXELS", 24)
    return tmp_path


def test_a_ball_is_reconstructed_as_a_closed_mesh(folder, capsys):
    """The cloud lies at 1e7 from the origin; all vertices are within 0.02 of the unit sphere."""
    np.savetxt("ball.xyz", 1e7 + sample_surface(Ball(1.0), 400, seed=1)[0], fmt="%.9f")
    assert main(["surface", "ball.xyz", "--out", "ball.ply"]) == 0
    shown = capsys.readouterr().out
    assert "and is closed." in shown
    assert shown.splitlines()[-3:] == ["ball.ply", "ball.png", "ball.html"]
    points, triangles = read_triangles("ball.ply")
    assert np.linalg.norm(points - 1e7, axis=1) == pytest.approx(1, abs=0.02)
    assert fr.audit_mesh(points - 1e7, triangles).clean
    page = (folder / "ball.html").read_text()
    assert "400 of 400 points" in page
    assert "root mean square" in page
    assert 'src="data:image/png;base64,' in page


@pytest.mark.parametrize(
    ("name", "origin", "error"),
    [
        ("a.STL", 1e7, "0.3"),
        ("a.stl", 1e5, "0.0031"),
        ("a.stl", 1e3, ""),
        ("a.stl", 0.0, ""),
        ("a.ply", 1e7, ""),
    ],
)
def test_single_precision_is_reported_where_it_displaces_vertices(name, origin, error):
    """At 1e7 its numbers are one apart, at 1e5 a hundredth, at 1e3 less than 1e-4.

    The spacing is a tenth. Other formats have double precision.
    """
    points = origin + np.array([[0.3, 0, 0], [1, 2, 3]])
    scan = SimpleNamespace(points=points, body=SimpleNamespace(spacing=0.1))
    said = [*_precision_warning(scan, Path(name))]
    assert len(said) == bool(error)
    assert all(f"by up to {error};" in words for words in said)


@pytest.mark.slow
@pytest.mark.usefixtures("folder")
def test_peculiarities_of_the_cloud_are_reported(capsys):
    """The summary names two parts, repeated points, an outlier and a skipped row."""
    one, other = (sample_surface(Ball(1.0, [x, 0, 0]), 300, seed=1)[0] for x in (0, 3))
    cloud = np.concatenate([one, other, one[:3], [[1.5, 9, 0]], [[np.nan, 0, 0]]])
    np.savetxt("two.csv", cloud, delimiter=",", header="x,y,z", comments="")
    assert main(["surface", "two.csv", "--out", "two.obj"]) == 0
    shown = " ".join(capsys.readouterr().out.split())
    assert "1 row was skipped; the first, line 606: x must be" in shown
    assert "3 points repeat others" in shown
    assert "apart from all others" in shown
    assert "The normals are estimated." in shown
    assert "2 parts" in shown
    assert len(read_triangles("two.obj")[1]) > 500


@pytest.mark.slow
def test_a_hole_is_closed_or_left_open(folder, capsys):
    """A hole is closed by default, with a warning; with --open the mesh keeps its boundary."""
    points, normals = sample_surface(Torus(1.0, 0.5), 600, seed=1)
    seen = points[:, 0] < 0.9
    header = "x,y,z,nx,ny,nz"
    np.savetxt(
        "hole.csv", np.hstack([points, normals])[seen], delimiter=",", header=header, comments=""
    )
    assert main(["surface", "hole.csv"]) == 0
    shown = " ".join(capsys.readouterr().out.split())
    (share,) = re.findall(r"([\d.]+) % of the surface is farther than .* is invented", shown)
    assert 1 < float(share) < 10
    assert "The normals are those of the file." in shown
    assert (folder / "surface.png").exists()
    assert main(["surface", "hole.csv", "--open", "0.3", "--out", "open.stl"]) == 0
    assert "and is open; found: " in " ".join(capsys.readouterr().out.split())


@pytest.mark.slow
@pytest.mark.usefixtures("folder")
def test_a_polygon_soup_becomes_a_closed_mesh(capsys):
    """The audit finds holes in the separated triangles and none in the resulting mesh."""
    points, triangles = sphere(1)
    rng = np.random.default_rng(5)
    corners = points[triangles] + rng.uniform(-0.02, 0.02, (len(triangles), 1, 3))
    fr.io.write_triangles("torn.stl", corners.reshape(-1, 3), np.arange(240).reshape(-1, 3))
    assert not fr.audit_mesh(*read_triangles("torn.stl")).clean
    assert main(["surface", "torn.stl", "--polygons", "0.1", "--edge", "0.15"]) == 0
    assert "80 triangles are loose; the surface goes around them" in capsys.readouterr().out
    mesh = read_triangles("surface.ply")
    assert fr.audit_mesh(*mesh).clean
    assert np.linalg.norm(mesh[0], axis=1) == pytest.approx(1, abs=0.08)
    np.savetxt("none.xyz", points)
    assert main(["surface", "none.xyz", "--polygons", "0"]) == 2
    assert "holds no triangles" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["flat.xyz"], "in one plane or line"),
        (["line.xyz"], "in one plane or line"),
        (["flat.xyz", "--out", "mesh.vtk"], "must end with .ply, .stl, .obj, .off"),
        (["solid.xyz", "--smoothing", "-1"], "smoothing must be zero"),
        (["none.ply"], "no such file"),
        (["few.xyz"], "holds 3 points; a surface takes 10"),
        (["cloud.ply", "--out", "cloud.ply"], "would be overwritten"),
    ],
)
def test_wrong_input_has_status_2(folder, capsys, options, words):
    """The message on standard error says what is wrong, and no page is written."""
    flat = np.random.default_rng(0).random((200, 3)) * [1, 1, 0]
    np.savetxt("flat.xyz", flat)
    np.savetxt("line.xyz", np.outer(flat[:, 0], [1, 2, 3]))
    np.savetxt("few.xyz", flat[:3])
    np.savetxt("solid.xyz", sample_surface(Ball(1.0), 60, seed=1)[0])
    assert main(["surface", *options]) == 2
    assert words in capsys.readouterr().err
    assert not [*folder.glob("*.html")]


def test_distances_to_triangles_equal_the_minimum_over_dense_samples():
    """The distance is at most, and within 0.02 of, the minimum over 150 points of each triangle."""
    points, triangles = sphere(2)
    x = 1.1 * np.random.default_rng(3).normal(size=(12, 3))
    shares = np.random.default_rng(4).dirichlet([0.7] * 3, 150)
    on = np.einsum("sc,mcd->msd", shares, points[triangles]).reshape(-1, 3)
    dense = np.linalg.norm(x[:, None] - on, axis=2).min(axis=1)
    found = distances_to_triangles(x, points, triangles)
    assert (found <= dense + 1e-12).all()
    np.testing.assert_allclose(found, dense, atol=0.02)
