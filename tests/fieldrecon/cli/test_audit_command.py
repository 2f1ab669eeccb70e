"""The command `fieldrecon audit`: exit status, table, JSON, picture and repair."""

import json
from pathlib import Path

import matplotlib.image
import numpy as np
import pytest

from fieldrecon._core import extras
from fieldrecon.cli.audit import print_audit
from fieldrecon.cli.main import main
from fieldrecon.io.meshes import read_triangles, write_triangles
from fieldrecon.plotting import mesh_pictures
from fieldrecon.plotting.mesh_pictures import COLORS, MeshPicture, marks
from fieldrecon.triangles.audit import CONCERNS, audit_mesh
from fieldreport.experiments.triangles.planted_errors import TOWARD, damaged, planted_errors
from fieldreport.experiments.triangles.triangle_shapes import band, cube, sphere

PLANTED = planted_errors(1)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Change to an empty folder and draw small pictures."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(mesh_pictures, "_PIXELS", 150)
    return tmp_path


def test_a_clean_mesh_has_status_0(folder, capsys):
    """The command reports no errors and lists its files.

    The JSON equals the audit of the library.
    """
    write_triangles("ball.stl", *sphere(1))
    assert main(["audit", "ball.stl"]) == 0
    shown = capsys.readouterr().out
    assert "80 triangles in 1 part," in shown
    assert "Nothing is wrong" in shown
    files = [f"audit/audit.{kind}" for kind in ("html", "json", "png", "svg")]
    assert shown.splitlines()[-4:] == files
    page = (folder / "audit" / "audit.html").read_text()
    assert "Nothing is wrong" in page
    assert "<h2>Errors" not in page
    written = json.loads((folder / "audit" / "audit.json").read_text())
    assert written == audit_mesh(*read_triangles("ball.stl")).as_dict()


@pytest.mark.parametrize(
    "error",
    [
        "overlap",
        *(
            pytest.param(e, marks=pytest.mark.slow)
            for e in ("duplicate vertex", "bow-tie", "one side")
        ),
    ],
)
def test_an_error_has_status_1_and_is_named(folder, capsys, error):
    """The table, the page and the JSON name each kind of error that was planted in the mesh."""
    write_triangles("mesh.ply", *PLANTED[error].surface)
    assert main(["audit", "mesh.ply", "--out", "found"]) == 1
    shown = " ".join(capsys.readouterr().out.replace("│", " ").split())
    errors = (folder / "found" / "audit.html").read_text().split("<h2>Errors</h2>")[1]
    for kind in PLANTED[error].found:
        assert kind.replace("_", " ").split()[0] in shown
        assert kind.replace("_", " ").split()[0] in errors
    written = json.loads((folder / "found" / "audit.json").read_text())
    assert {*written["indices"]} == {*PLANTED[error].found}


@pytest.mark.slow
def test_a_repair_is_written_and_audited_again(folder, capsys):
    """The exit status is that of the repaired mesh, not of the mesh that was read."""
    write_triangles("bad.stl", *damaged(2, 1, seed=0))
    assert main(["audit", "bad.stl", "--repair", "good.obj"]) == 0
    assert "Repaired: " in capsys.readouterr().out
    assert audit_mesh(*read_triangles(folder / "good.obj")).clean
    write_triangles("crossing.ply", *PLANTED["crossing"].surface)
    assert main(["audit", "crossing.ply", "--repair", "same.ply"]) == 1


@pytest.mark.usefixtures("folder")
def test_what_a_repair_leaves_is_explained_and_its_file_is_listed(capsys, monkeypatch):
    """The explanation is printed and stands on the page; the option that it names helps."""
    monkeypatch.setattr(extras, "find_spec", lambda name: None if name == "typst" else ...)
    write_triangles("bad.ply", *PLANTED["hole"].surface)
    arguments = ["audit", "bad.ply", "--repair", "same.ply"]
    assert main([*arguments, "--largest-hole", "0"]) == 1
    shown = capsys.readouterr().out
    words = " ".join(shown.split())
    assert "bad.ply: " in words
    assert "same.ply: " in words
    assert "Repaired: nothing." in words
    assert "1 hole was not filled" in words
    assert "1 hole was not filled" in Path("audit/audit.html").read_text()
    assert shown.splitlines()[-2:] == ["audit/audit.json", "same.ply"]
    assert main([*arguments, "--largest-hole", "1"]) == 0
    assert "not filled" not in capsys.readouterr().out


@pytest.mark.slow
def test_a_boundary_may_be_allowed(folder, capsys):
    """With --open a band with a boundary is accepted, and a one-sided band is still an error."""
    for half_turns, status in ((0, 0), (1, 1)):
        write_triangles(folder / "band.off", *band(12, half_turns=half_turns))
        assert main(["audit", "band.off"]) == 1
        assert main(["audit", "band.off", "--open"]) == status
    assert "boundary loops" in capsys.readouterr().out


@pytest.mark.slow
def test_json_is_the_only_output(folder, capsys):
    """With --json standard output is one JSON document, with or without a repair."""
    write_triangles(folder / "hole.ply", *PLANTED["hole"].surface)
    assert main(["audit", "hole.ply", "--json"]) == 1
    assert json.loads(capsys.readouterr().out)["counts"]["boundary"]["boundary_loops"] == 1
    assert main(["audit", "hole.ply", "--json", "--repair", "closed.ply"]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert printed["done"] == {"filled_holes": 1, "filling_triangles": 1}
    assert printed["left"]["clean"]


@pytest.mark.slow
def test_tolerance_decides_which_vertices_coincide(folder, capsys):
    """A seam open by 1e-6 is reported for a tolerance of 1e-5 and not for a tolerance of zero."""
    points, triangles = PLANTED["duplicate vertex"].surface
    points = points + np.where(np.arange(len(points)) == len(points) - 1, 1e-6, 0)[:, None]
    write_triangles(folder / "seam.ply", points, triangles)
    assert main(["audit", "seam.ply", "--tolerance", "0"]) == 1
    assert "duplicate" not in capsys.readouterr().out
    assert main(["audit", "seam.ply", "--tolerance", "1e-5", "--repair", "sewn.ply"]) == 0
    assert "duplicate" in capsys.readouterr().out


@pytest.mark.parametrize("corners", [3, 6, 7, 12])
@pytest.mark.parametrize("alone", [1, 3, 4])
def test_few_indices_of_each_error_are_printed(capsys, corners, alone):
    """Three errors of a kind, and six vertices of a hole, as where a regular mesh lacks one vertex.

    An ellipsis stands for the others.
    """
    angle = 2 * np.pi * np.arange(corners) / corners
    rim = np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    ring = np.arange(corners)
    fan = np.column_stack([np.full(corners, corners), ring, np.roll(ring, -1)])
    points = np.vstack([rim, [[0, 0, 1]], 9.0 + np.arange(3 * alone).reshape(-1, 3)])
    found = audit_mesh(points, fan)
    print_audit(Path("fan.ply"), found)
    shown = " ".join(capsys.readouterr().out.replace("│", " ").split())
    loop = "-".join(map(str, found.boundary_loops[0][:6]))
    assert f" {loop}{'-…' if corners > 6 else ''} " in f"{shown} "
    unused = ", ".join(map(str, found.unreferenced_vertices[:3]))
    assert f" {unused}{', …' if alone > 3 else ''} " in f"{shown} "


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["nowhere.stl"], "nowhere.stl: no such file"),
        (["text.stl"], "text.stl is not an STL file"),
        (["cube.ply", "--tolerance", "-1"], "tolerance must be zero or a positive number"),
        (["cube.ply", "--repair", "cube.xyz"], "must end with .stl, .ply, .obj or .off"),
    ],
)
def test_wrong_input_has_status_2(folder, capsys, arguments, words):
    """The message on standard error says what is wrong with the file or the option."""
    (folder / "text.stl").write_text("not a mesh")
    write_triangles("cube.ply", *cube(1))
    assert main(["audit", *arguments]) == 2
    assert words in capsys.readouterr().err


def test_help_explains_the_exit_status(capsys):
    """The help text explains the exit status and lists the file formats."""
    with pytest.raises(SystemExit):
        main(["audit", "--help"])
    shown = " ".join(capsys.readouterr().out.split())
    assert "The status is 0 if there are no errors" in shown
    assert ".stl, .ply, .obj or .off" in shown


# --- the picture ----------------------------------------------------------------------------------


@pytest.mark.slow
def test_errors_are_marked_in_the_picture(folder):
    """The picture of a damaged mesh has pixels in the colour of the error.

    A clean mesh has none.
    """

    def pixels(surface, concern):
        write_triangles(folder / "mesh.ply", *surface)
        main(["audit", "mesh.ply"])
        image = matplotlib.image.imread(folder / "audit" / "audit.png")[..., :3]
        color = np.array(matplotlib.colors.to_rgb(COLORS[concern]))
        return int((np.abs(image - color).max(axis=2) < 0.02).sum())

    for error in ("hole", "unreferenced vertex"):
        concern = next(c for c, kinds in CONCERNS.items() if {*kinds} & {*PLANTED[error].found})
        assert pixels(PLANTED[error].surface, concern) > 30
        assert pixels(sphere(1), concern) == 0


def test_the_nearest_triangle_is_visible():
    """Each pixel shows the nearest triangle that covers it, here of the top face of a cube."""
    points, triangles = cube(1)
    picture = MeshPicture(points, triangles, np.array([0.01, 0.02, 1.0]), 60)
    seen = np.unique(picture.front[picture.front >= 0], return_counts=True)
    top = np.flatnonzero((points[triangles][:, :, 2] == 1).all(axis=1))
    shown = dict(zip(*(s.tolist() for s in seen), strict=True))
    assert sum(shown[t] for t in top.tolist()) > 0.9 * sum(shown.values())
    below = np.flatnonzero((points[triangles][:, :, 2] == 0).all(axis=1))
    assert not {*below.tolist()} & {*shown}


@pytest.mark.slow
def test_the_picture_of_a_sphere_is_a_disc():
    """The covered area is π r², the area of the disc with the radius of the sphere."""
    points, triangles = sphere(4)
    picture = MeshPicture(points, triangles, TOWARD, 400)
    radius = (400 - 8) / 2
    assert (picture.front >= 0).sum() == pytest.approx(np.pi * radius**2, rel=5e-3)


def test_every_kind_of_error_has_marks():
    """The picture marks triangles, edges or vertices for each kind of error in the audit."""
    for error in PLANTED.values():
        found = marks(audit_mesh(*error.surface), error.surface[1])
        assert {*found} == {*error.found}
        for mark in found.values():
            assert len(mark.triangles) + len(mark.edges) + len(mark.vertices) > 0
