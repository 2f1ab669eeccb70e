"""The command that audits a mesh in a file: status, table, JSON, picture, repair."""

import json

import matplotlib.image
import numpy as np
import pytest

from fieldrecon.cli.main import main
from fieldrecon.io.meshes import read_triangles, write_triangles
from fieldrecon.plotting import audit_picture
from fieldrecon.plotting.mesh_pictures import COLORS, MeshPicture, marks
from fieldrecon.triangles.audit import CONCERNS, audit_mesh
from fieldreport.experiments.triangles.damaged_meshes import damaged
from fieldreport.experiments.triangles.planted_errors import TOWARD, planted_errors
from fieldreport.experiments.triangles.triangle_shapes import band, cube, sphere

PLANTED = planted_errors(1)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Work in a folder of its own, with small pictures."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(audit_picture, "_PIXELS", 150)
    return tmp_path


def test_a_clean_mesh_has_status_0(folder, capsys):
    """It is said in words; the files are named, and the JSON says the same."""
    write_triangles("ball.stl", *sphere(1))
    assert main(["audit", "ball.stl"]) == 0
    shown = capsys.readouterr().out
    assert "80 triangles in 1 part," in shown
    assert "Nothing is wrong" in shown
    assert shown.splitlines()[-3:] == ["audit/audit.json", "audit/audit.png", "audit/audit.svg"]
    told = json.loads((folder / "audit" / "audit.json").read_text())
    assert told == audit_mesh(*read_triangles("ball.stl")).as_dict()


@pytest.mark.parametrize("error", ["duplicate vertex", "bow-tie", "one side", "overlap"])
def test_an_error_has_status_1_and_is_named(folder, capsys, error):
    """The table names the kind of each error, what it concerns, and where it is."""
    write_triangles("mesh.ply", *PLANTED[error].surface)
    assert main(["audit", "mesh.ply", "--out", "found"]) == 1
    shown = " ".join(capsys.readouterr().out.replace("│", " ").split())
    for kind in PLANTED[error].found:
        assert kind.replace("_", " ").split()[0] in shown
    told = json.loads((folder / "found" / "audit.json").read_text())
    assert {*told["indices"]} == {*PLANTED[error].found}


def test_a_repair_is_written_told_and_judged(folder, capsys):
    """The status is that of the mesh that was written."""
    write_triangles("bad.stl", *damaged(2, 1, seed=0))
    assert main(["audit", "bad.stl", "--repair", "good.obj"]) == 0
    assert "Repaired: " in capsys.readouterr().out
    assert audit_mesh(*read_triangles(folder / "good.obj")).clean
    write_triangles("crossing.ply", *PLANTED["crossing"].surface)
    assert main(["audit", "crossing.ply", "--repair", "same.ply"]) == 1


@pytest.mark.slow
def test_a_boundary_may_be_allowed(folder, capsys):
    """A ring is no error with --open, a one-sided band is."""
    for half_turns, status in ((0, 0), (1, 1)):
        write_triangles(folder / "band.off", *band(12, half_turns=half_turns))
        assert main(["audit", "band.off"]) == 1
        assert main(["audit", "band.off", "--open"]) == status
    assert "boundary loops" in capsys.readouterr().out


def test_json_alone_can_be_read_by_another_program(folder, capsys):
    """Nothing else is printed."""
    write_triangles(folder / "hole.ply", *PLANTED["hole"].surface)
    assert main(["audit", "hole.ply", "--json"]) == 1
    assert json.loads(capsys.readouterr().out)["counts"]["boundary"]["boundary_loops"] == 1
    assert main(["audit", "hole.ply", "--json", "--repair", "closed.ply"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["done"] == {"filled_holes": 1, "filling_triangles": 1}
    assert told["left"]["clean"]


def test_the_tolerance_is_heeded(folder, capsys):
    """A seam that is open by a millionth is a seam for a larger tolerance only."""
    points, triangles = PLANTED["duplicate vertex"].surface
    points = points + np.where(np.arange(len(points)) == len(points) - 1, 1e-6, 0)[:, None]
    write_triangles(folder / "seam.ply", points, triangles)
    assert main(["audit", "seam.ply", "--tolerance", "0"]) == 1
    assert "duplicate" not in capsys.readouterr().out
    assert main(["audit", "seam.ply", "--tolerance", "1e-5", "--repair", "sewn.ply"]) == 0
    assert "duplicate" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["nowhere.stl"], "nowhere.stl: no such file"),
        (["text.stl"], "text.stl is not an STL file"),
        (["cube.ply", "--tolerance", "-1"], "tolerance must be zero or a positive number"),
        (["cube.ply", "--repair", "cube.xyz"], "must end with .stl, .ply, .obj or .off"),
    ],
)
def test_trouble_has_status_2_and_one_line(folder, capsys, arguments, words):
    """What the user can put right is told in a sentence."""
    (folder / "text.stl").write_text("not a mesh")
    write_triangles("cube.ply", *cube(1))
    assert main(["audit", *arguments]) == 2
    assert words in capsys.readouterr().err


def test_the_help_tells_the_status(capsys):
    """And names the formats."""
    with pytest.raises(SystemExit):
        main(["audit", "--help"])
    shown = " ".join(capsys.readouterr().out.split())
    assert "The status is 0 if there are no errors" in shown
    assert ".stl, .ply, .obj or .off" in shown


# --- the picture ----------------------------------------------------------------------------------


@pytest.mark.slow
def test_errors_are_marked_in_the_picture(folder):
    """The picture of an error has pixels of its colour, that of the clean mesh has none."""

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


def test_what_is_in_front_hides_what_is_behind():
    """Each pixel shows the nearest of the triangles that cover it: of two squares the upper."""
    points, triangles = cube(1)
    picture = MeshPicture(points, triangles, np.array([0.01, 0.02, 1.0]), 60)
    seen = np.unique(picture.front[picture.front >= 0], return_counts=True)
    top = np.flatnonzero((points[triangles][:, :, 2] == 1).all(axis=1))
    shown = dict(zip(*(s.tolist() for s in seen), strict=True))
    assert sum(shown[t] for t in top.tolist()) > 0.9 * sum(shown.values())
    below = np.flatnonzero((points[triangles][:, :, 2] == 0).all(axis=1))
    assert not {*below.tolist()} & {*shown}


def test_a_picture_covers_what_it_shows():
    """The pixels of a sphere are those of a disc of its radius."""
    points, triangles = sphere(4)
    picture = MeshPicture(points, triangles, TOWARD, 400)
    radius = (400 - 8) / 2
    assert (picture.front >= 0).sum() == pytest.approx(np.pi * radius**2, rel=5e-3)


def test_marks_are_where_the_errors_are():
    """Triangles, edges or vertices for each kind that was found."""
    for error in PLANTED.values():
        found = marks(audit_mesh(*error.surface), error.surface[1])
        assert {*found} == {*error.found}
        for mark in found.values():
            assert len(mark.triangles) + len(mark.edges) + len(mark.vertices) > 0
