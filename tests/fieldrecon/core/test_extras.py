"""Optional packages: what works without them, and which extra installs them."""

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
OF_USERS = (
    "pictures",
    "mesh",
    "surface",
    "parquet",
    "frames",
    "crs",
    "dask",
    "report",
    "grade",
)
OURS = {"fieldcheck", "fieldgrade", "fieldrecon", "fieldreport"}
CORNERS = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]


def names_of(requirements: list[str]) -> set[str]:
    """Names of the required packages, normalized."""
    return {
        re.match(r"[\w.-]+", need).group().lower().replace("_", "-") for need in requirements
    } - {"fieldrecon", "fieldrecon-course"}


def imported() -> set[str]:
    """Top-level names of all modules that the code imports, by a statement or by `optional`."""
    name = r"(\w+)[.\w]*"
    statement = rf"^ *(?:import {name}(?: as \w+)?$|from {name} import )|\boptional\(f?\"{name}"
    sources = (path.read_text() for path in (ROOT / "src").rglob("*.py"))
    found = {name for text in sources for m in re.findall(statement, text, re.M) for name in m}
    return found - set(sys.stdlib_module_names) - OURS - {""}


OPTIONAL = sorted(imported() - names_of(PROJECT["dependencies"]))


def without(modules: list[str], *arguments: str, cwd: Path) -> subprocess.CompletedProcess[str]:
    """Run the command line in an interpreter in which these modules cannot be imported."""
    code = (
        f"import sys; sys.modules.update(dict.fromkeys({modules!r})); "
        "from fieldrecon.cli.main import main; sys.exit(main(sys.argv[1:]))"
    )
    command = [sys.executable, "-c", code, *arguments]
    return subprocess.run(command, cwd=cwd, capture_output=True, text=True)


# --- the extra of each package --------------------------------------------------------------------


def test_optional_packages_are_found():
    """The list OPTIONAL contains packages of both kinds of import, so the other tests are not
    empty.
    """
    assert {"matplotlib", "meshio", "pyarrow", "skimage", "nbformat"} <= set(OPTIONAL)


@pytest.mark.parametrize("module", OPTIONAL)
def test_the_named_extra_requires_the_package(module):
    """The message names an extra for users, and this extra requires the package in the message."""
    sentence = _extras.remedy(f"{module}.part")
    package, extra = re.match(r"(\S+) is not .* the extra '(\w+)': pip install ", sentence).groups()
    assert extra in OF_USERS
    assert package.lower().replace("_", "-") in names_of(EXTRAS[extra])


def test_several_missing_packages_give_one_command():
    """Each extra is named once, in the order of the packages."""
    sentence = _extras.remedy("skimage", "meshio", "skimage.measure")
    assert sentence.startswith("scikit-image and meshio are not installed; they come with the ")
    assert re.search(r"extras 'surface' and 'mesh': pip install .*\[surface,mesh\]'$", sentence)
    assert _extras.remedy("unheard_of.part") == "unheard_of is not installed"


def test_the_extra_all_contains_every_extra_for_users():
    """The extras `all` contain every extra for users and none for developers."""
    named = [
        re.fullmatch(rf"{project['name']}\[(.*)\]", *project["optional-dependencies"]["all"])[1]
        for project in (PROJECT, COURSE)
    ]
    assert set(",".join(named).split(",")) == set(OF_USERS)


def test_metadata_have_ranges_and_the_lock_file_has_pins():
    """Pinned versions in the metadata would conflict with most environments."""
    assert not [need for needs in EXTRAS.values() for need in needs if "==" in need]
    lock = (ROOT / "requirements.lock").read_text()
    for name in names_of([need for extra in OF_USERS for need in EXTRAS[extra]]):
        assert re.search(rf"^{name}==\S+ ", lock, flags=re.M), name


# --- the install command --------------------------------------------------------------------------

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
def test_the_install_command_names_the_source_of_fieldrecon(monkeypatch, record, line):
    """The command uses the package index only if fieldrecon was installed from there.

    Another index may hold a package of the same name by somebody else.
    """

    files = {"RECORD": "", "direct_url.json": record and json.dumps(record)}
    monkeypatch.setattr(_extras, "distributions", lambda **_: [Recorded({}), Recorded(files)])
    assert _extras.remedy("meshio").endswith(f": {line}")


class Recorded:
    """A distribution with the given metadata files; a source tree has none of them."""

    name = "fieldrecon"
    requires = ("numpy>=2.1", 'meshio>=5.3.5; extra == "mesh"')

    def __init__(self, files):
        self.read_text = files.get


def test_the_companion_is_installed_from_a_checkout_that_has_it(monkeypatch, tmp_path):
    """From the index where fieldrecon itself is, or where its folder is no checkout."""
    files = {"RECORD": ""}
    monkeypatch.setattr(_extras, "distributions", lambda **_: [Recorded(files)])
    from_index = "fieldrecon-course: pip install 'fieldrecon-course[report]'"
    assert _extras.companion("report") == from_index
    files["direct_url.json"] = json.dumps({"url": tmp_path.as_uri(), "dir_info": {}})
    assert _extras.companion("report") == from_index
    (tmp_path / "src").mkdir()
    (tmp_path / "src" / "pyproject.toml").touch()
    line = f"fieldrecon-course: pip install '{tmp_path / 'src'}[report]'"
    assert _extras.companion("report") == line


def test_the_install_command_for_a_checkout_is_its_path(monkeypatch, tmp_path):
    """In the root of the checkout the path is a dot."""
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


@pytest.mark.slow
def test_reconstruct_works_without_extras(folder):
    """Values and page are written; one sentence says that no picture was drawn."""
    options = ["--method", "tps", "--grid", "4x3", "--out", "field.csv"]
    done = without(OPTIONAL, "reconstruct", "points.csv", *options, cwd=folder)
    assert done.returncode == 0, done.stderr
    assert len((folder / "field.csv").read_text().splitlines()) == 13
    assert "<img" not in (folder / "field.html").read_text()
    assert re.fullmatch(r"fieldrecon: no picture was drawn: .* 'pictures': pip.*\n", done.stderr)


@pytest.mark.slow
def test_audit_works_without_extras(folder):
    """Findings and the repaired mesh are written.

    The sentence about the missing picture does not disturb the JSON.
    """
    options = ["--largest-hole", "1", "--repair", "closed.stl", "--json"]
    done = without(OPTIONAL, "audit", "open.stl", *options, cwd=folder)
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["done"]["filled_holes"] == 1
    assert fr.audit_mesh(*fr.io.read_triangles(folder / "closed.stl")).clean
    assert sorted(path.name for path in (folder / "audit").iterdir()) == [
        "audit.html",
        "audit.json",
    ]
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
def test_a_command_names_the_extra_that_it_needs(folder, arguments, extra):
    """The command exits with status 2 and one sentence."""
    always = names_of(COURSE["dependencies"])
    done = without([m for m in OPTIONAL if m not in always], *arguments, cwd=folder)
    assert done.returncode == 2
    assert re.search(rf"with the extras? .*'{extra}': pip install ", done.stderr)
    assert "Traceback" not in done.stderr


def test_surface_checks_its_packages_before_it_reads(capsys, monkeypatch):
    """All missing packages are named at once, before any computation could be lost."""
    monkeypatch.setitem(sys.modules, "skimage", None)
    assert main(["surface", "none.xyz", "--out", "mesh.stl"]) == 2
    assert "scikit-image is not installed" in capsys.readouterr().err
    monkeypatch.setitem(sys.modules, "meshio", None)
    assert main(["surface", "none.xyz", "--out", "mesh.ply"]) == 2
    assert "extras 'surface' and 'mesh'" in capsys.readouterr().err


def test_repair_checks_its_packages_before_it_reads(capsys, monkeypatch):
    """Both a format that needs meshio and an unknown format are refused."""
    monkeypatch.setitem(sys.modules, "meshio", None)
    assert main(["audit", "none.stl", "--repair", "mesh.ply"]) == 2
    assert "meshio is not installed; it comes with the extra 'mesh'" in capsys.readouterr().err
    assert main(["audit", "none.stl", "--repair", "mesh.xyz"]) == 2
    assert "must end with .stl, .ply, .obj or .off" in capsys.readouterr().err


# --- measurements ---------------------------------------------------------------------------------


@pytest.mark.slow
def test_measurements_are_read_from_the_checkout(tmp_path, monkeypatch, capsys):
    """They are found if the working directory lies in a checkout; elsewhere an error says so."""
    monkeypatch.setattr(experiment, "__file__", str(tmp_path / "a" / "b" / "c" / "d.py"))
    monkeypatch.chdir(ROOT)
    assert main(["experiments", "run", "million", "--out", str(tmp_path)]) == 0
    monkeypatch.chdir(tmp_path)
    capsys.readouterr()
    assert main(["experiments", "run", "million"]) == 2
    message = capsys.readouterr().err
    assert "benchmarks/results/million.json are missing: they are part of a checkout" in message
    assert "--set results=FILE" in message
