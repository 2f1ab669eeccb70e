"""Packages that only some commands need: what does without them, and what installs them."""

import json
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest

import fieldrecon as fr
from checkout import ROOT
from fieldrecon._core import extras as _extras
from fieldrecon.cli.main import main
from fieldreport.framework import experiment

PROJECT, COURSE = (
    tomllib.loads((ROOT / folder / "pyproject.toml").read_text())["project"]
    for folder in (".", "src")
)
EXTRAS = COURSE["optional-dependencies"] | PROJECT["optional-dependencies"]
OF_USERS = ("pictures", "mesh", "surface", "parquet", "dask", "report", "grade")
OURS = {"fieldcheck", "fieldgrade", "fieldrecon", "fieldreport"}
CORNERS = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]


def names_of(requirements: list[str]) -> set[str]:
    """Names of packages, all in one spelling."""
    return {
        re.match(r"[\w.-]+", need).group().lower().replace("_", "-") for need in requirements
    } - {"fieldrecon", "fieldrecon-course"}


def imported() -> set[str]:
    """First names of all modules that the code imports, by statements or by `optional`."""
    name = r"(\w+)[.\w]*"
    statement = rf"^ *(?:import {name}(?: as \w+)?$|from {name} import )|\boptional\(f?\"{name}"
    sources = (path.read_text() for path in (ROOT / "src").rglob("*.py"))
    found = {name for text in sources for m in re.findall(statement, text, re.M) for name in m}
    return found - set(sys.stdlib_module_names) - OURS - {""}


OPTIONAL = sorted(imported() - names_of(PROJECT["dependencies"]))


def without(modules: list[str], *arguments: str, cwd: Path) -> subprocess.CompletedProcess[str]:
    """Run the command line where these modules are not installed."""
    code = (
        f"import sys; sys.modules.update(dict.fromkeys({modules!r})); "
        "from fieldrecon.cli.main import main; sys.exit(main(sys.argv[1:]))"
    )
    command = [sys.executable, "-c", code, *arguments]
    return subprocess.run(command, cwd=cwd, capture_output=True, text=True)


# --- which extra has what -------------------------------------------------------------------------


def test_optional_packages_are_found():
    """The list that the other tests go through is not empty, nor without either kind of import."""
    assert {"matplotlib", "meshio", "pyarrow", "skimage", "nbformat"} <= set(OPTIONAL)


@pytest.mark.parametrize("module", OPTIONAL)
def test_each_package_comes_with_the_extra_that_is_named(module):
    """Of those for users; and the package that is named is the one that the extra requires."""
    sentence = _extras.remedy(f"{module}.part")
    package, extra = re.match(r"(\S+) is not .* the extra '(\w+)': pip install ", sentence).groups()
    assert extra in OF_USERS
    assert package.lower().replace("_", "-") in names_of(EXTRAS[extra])


def test_several_packages_take_one_line():
    """Each extra once, in the order of the packages."""
    sentence = _extras.remedy("skimage", "meshio", "skimage.measure")
    assert sentence.startswith("scikit-image and meshio are not installed; they come with the ")
    assert re.search(r"extras 'surface' and 'mesh': pip install .*\[surface,mesh\]'$", sentence)
    assert _extras.remedy("unheard_of.part") == "unheard_of is not installed"


def test_all_is_all_that_users_need():
    """The extras `all` contain the others for users, and none for developers."""
    named = [
        re.fullmatch(rf"{project['name']}\[(.*)\]", *project["optional-dependencies"]["all"])[1]
        for project in (PROJECT, COURSE)
    ]
    assert set(",".join(named).split(",")) == set(OF_USERS)


def test_ranges_for_users_and_pins_in_the_lock():
    """Metadata that pinned a version would refuse every environment that has another."""
    assert not [need for needs in EXTRAS.values() for need in needs if "==" in need]
    lock = (ROOT / "requirements.lock").read_text()
    for name in names_of([need for extra in OF_USERS for need in EXTRAS[extra]]):
        assert re.search(rf"^{name}==\S+ ", lock, flags=re.M), name


# --- the line that installs it --------------------------------------------------------------------

FOLDER, WHEEL = "file:///a%20b/fieldrecon", "file:///w/fieldrecon-0.2.0-py3-none-any.whl"


@pytest.mark.parametrize(
    ("record", "line"),
    [
        (None, "pip install 'fieldrecon[mesh]'"),
        ({"url": FOLDER, "dir_info": {}}, "pip install '/a b/fieldrecon[mesh]'"),
        (
            {"url": FOLDER, "dir_info": {"editable": True}},
            "pip install --editable '/a b/fieldrecon[mesh]'",
        ),
        (
            {"url": WHEEL, "archive_info": {}},
            "pip install '/w/fieldrecon-0.2.0-py3-none-any.whl[mesh]'",
        ),
        (
            {"url": "https://host/f.whl", "archive_info": {}},
            "pip install 'fieldrecon[mesh] @ https://host/f.whl'",
        ),
        (
            {"url": "https://host/f.git", "vcs_info": {"vcs": "git", "commit_id": "ab12"}},
            "pip install 'fieldrecon[mesh] @ git+https://host/f.git@ab12'",
        ),
    ],
    ids=["index", "folder", "editable", "wheel", "address", "repository"],
)
def test_the_line_installs_from_where_fieldrecon_came(monkeypatch, record, line):
    """From an index only if fieldrecon came from one: another may have a stranger's package."""

    files = {"RECORD": "", "direct_url.json": record and json.dumps(record)}
    monkeypatch.setattr(_extras, "distributions", lambda **_: [Recorded({}), Recorded(files)])
    assert _extras.remedy("meshio").endswith(f": {line}")


class Recorded:
    """A distribution, with the files that an installer leaves, or none, as beside the source."""

    name = "fieldrecon"
    requires = ("numpy>=2.1", 'meshio>=5.3.5; extra == "mesh"')

    def __init__(self, files):
        self.read_text = files.get


def test_in_the_checkout_the_line_is_short(monkeypatch, tmp_path):
    """A dot there, the path elsewhere."""
    monkeypatch.chdir(ROOT)
    assert _extras.remedy("meshio").endswith(" '.[mesh]'")
    monkeypatch.chdir(tmp_path)
    assert _extras.remedy("meshio").endswith(f" '{ROOT}[mesh]'")


# --- the base install -----------------------------------------------------------------------------


@pytest.fixture
def folder(tmp_path):
    """A folder with samples and an open mesh."""
    points = fr.datasets.halton(40, 2)
    table = np.column_stack([points, fr.datasets.franke(points)])
    np.savetxt(tmp_path / "points.csv", table, delimiter=",", header="x,y,value", comments="")
    fr.io.write_triangles(tmp_path / "open.stl", CORNERS, [[0, 2, 1], [0, 1, 3], [0, 3, 2]])
    return tmp_path


def test_a_field_without_any_extra(folder):
    """The values, the page and one sentence for what is not drawn."""
    options = ["--method", "tps", "--grid", "4x3", "--out", "field.csv"]
    done = without(OPTIONAL, "reconstruct", "points.csv", *options, cwd=folder)
    assert done.returncode == 0, done.stderr
    assert len((folder / "field.csv").read_text().splitlines()) == 13
    assert "<img" not in (folder / "field.html").read_text()
    assert re.fullmatch(r"fieldrecon: no picture was drawn: .* 'pictures': pip.*\n", done.stderr)


def test_an_audit_without_any_extra(folder):
    """The findings, the repaired mesh and the same sentence; JSON stays alone."""
    options = ["--largest-hole", "1", "--repair", "closed.stl", "--json"]
    done = without(OPTIONAL, "audit", "open.stl", *options, cwd=folder)
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["done"]["filled_holes"] == 1
    assert fr.audit_mesh(*fr.io.read_triangles(folder / "closed.stl")).clean
    assert [path.name for path in (folder / "audit").iterdir()] == ["audit.json"]
    assert re.fullmatch(r"fieldrecon: no picture was drawn: .* 'pictures': pip.*\n", done.stderr)


@pytest.mark.parametrize(
    ("arguments", "extra"),
    [
        (["report"], "report"),
        (["course"], "grade"),
        (["grade", "class"], "grade"),
    ],
    ids=lambda x: x if isinstance(x, str) else x[0],
)
def test_a_command_names_its_extra(folder, arguments, extra):
    """In a sentence, with status 2."""
    always = names_of(COURSE["dependencies"])
    done = without([m for m in OPTIONAL if m not in always], *arguments, cwd=folder)
    assert done.returncode == 2
    assert re.search(rf"with the extras? .*'{extra}': pip install ", done.stderr)
    assert "Traceback" not in done.stderr


def test_a_surface_says_what_it_takes_before_it_reads(capsys, monkeypatch):
    """All of it at once; nothing is read, so nothing can be lost."""
    monkeypatch.setitem(sys.modules, "skimage", None)
    assert main(["surface", "none.xyz", "--out", "mesh.stl"]) == 2
    assert "scikit-image is not installed" in capsys.readouterr().err
    monkeypatch.setitem(sys.modules, "meshio", None)
    assert main(["surface", "none.xyz", "--out", "mesh.ply"]) == 2
    assert "extras 'surface' and 'mesh'" in capsys.readouterr().err


def test_a_repair_says_what_it_takes_before_it_reads(capsys, monkeypatch):
    """A format that takes meshio, and one that nobody knows."""
    monkeypatch.setitem(sys.modules, "meshio", None)
    assert main(["audit", "none.stl", "--repair", "mesh.ply"]) == 2
    assert "meshio is not installed; it comes with the extra 'mesh'" in capsys.readouterr().err
    assert main(["audit", "none.stl", "--repair", "mesh.xyz"]) == 2
    assert "must end with .stl, .ply, .obj or .off" in capsys.readouterr().err


# --- measurements ---------------------------------------------------------------------------------


def test_measurements_are_found_in_a_checkout_or_said_to_be_missing(tmp_path, monkeypatch, capsys):
    """Where the code lies in no checkout, the folder that one is in may be one."""
    monkeypatch.setattr(experiment, "__file__", str(tmp_path / "a" / "b" / "c" / "d.py"))
    monkeypatch.chdir(ROOT)
    assert main(["experiments", "run", "million", "--out", str(tmp_path)]) == 0
    monkeypatch.chdir(tmp_path)
    capsys.readouterr()
    assert main(["experiments", "run", "million"]) == 2
    told = capsys.readouterr().err
    assert "benchmarks/results/million.json are missing: they are part of a checkout" in told
    assert "--set results=FILE" in told
