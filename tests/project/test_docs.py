"""The documents are correct: commands, links, dependencies, and the direction of imports."""

import ast
import os
import re
import runpy
import shlex
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

import fieldrecon as fr
from checkout import ROOT
from fieldrecon.cli.main import main

PACKAGE = ROOT / "src" / "fieldrecon"
README = (ROOT / "README.md").read_text()
ENGINEERS = (ROOT / "docs" / "engineers.md").read_text()
PAGES = sorted([*ROOT.glob("*.md"), *ROOT.glob("docs/**/*.md")])


def blocks(text: str, language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```", text, flags=re.M | re.S)


# --- commands in the README ----------------------------------------------------------------------


def test_the_code_of_the_readme_runs():
    """Each example is complete, and its comments state the shapes of the results."""
    for code in blocks(README, "python"):
        names: dict[str, object] = {}
        for line in ast.parse(code).body:
            source = ast.get_source_segment(code, line)
            exec(source, names)
        shapes = re.search(r"# \((\d+),\), \((\d+), (\d+)\)$", code.strip())
        n, rows, d = map(int, shapes.groups())
        values, gradients = eval(source, names)
        assert values.shape == (n,)
        assert gradients.shape == (rows, d)


@pytest.mark.slow
def test_the_code_for_engineers_runs(tmp_path, monkeypatch):
    """The commands in Python, on the sample files; each writes the files that it names."""
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    complete = [code for code in blocks(ENGINEERS, "python") if "fr.pipelines." in code]
    assert len(complete) == 2
    for code in complete:
        exec(code, names)
    assert names["values"].shape == names["error"].shape == (2,)
    assert names["grid"].height.shape == (150, 200)
    assert names["found"].sound()
    written = re.findall(r'(?:write|report|savefig)\("(\S+)"\)', "".join(complete))
    assert {*written} == {path.name for path in tmp_path.iterdir()} - {"examples"}


def test_make_targets_named_in_the_documentation_exist():
    targets = set(re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(), flags=re.M))
    for page in PAGES:
        text = page.read_text()
        named = re.findall(r"`make ([a-z-]+)[` ]", text)
        named += re.findall(r"^make ([a-z-]+)", "\n".join(blocks(text, "sh")), flags=re.M)
        assert set(named) <= targets, page


def readme_commands() -> list[list[str]]:
    lines = "\n".join(blocks(README, "sh")).splitlines()
    return [line.split()[1:] for line in lines if line.startswith(".venv/bin/fieldrecon")]


@pytest.mark.slow
@pytest.mark.parametrize("command", readme_commands(), ids=" ".join)
def test_the_commands_of_the_readme_run(command, tmp_path, monkeypatch, capsys):
    """They run unchanged, in a folder with the sample files."""
    monkeypatch.chdir(tmp_path)
    shutil.copytree(ROOT / "examples", tmp_path / "examples")
    assert main(command) == 0
    assert capsys.readouterr().out


INSTRUCTORS = (ROOT / "docs" / "instructors.md").read_text(encoding="utf-8")


def test_the_check_shown_to_instructors_is_that_of_the_example_class():
    example = ROOT / "src/fieldgrade/class_folder/example_class/class/checks/test_order.py"
    assert blocks(INSTRUCTORS, "python") == [example.read_text(encoding="utf-8")]


@pytest.mark.slow
def test_the_trial_of_the_instructors_page_prints_what_it_shows(tmp_path, monkeypatch, capsys):
    """The commands run as printed, apart from the folder and from the endless notebook."""
    monkeypatch.chdir(ROOT)
    lines = "\n".join(blocks(INSTRUCTORS, "sh")).splitlines()
    trial = [line.partition(" #")[0] for line in lines if "results/sample" in line]
    shown = []
    for line in trial:
        command = shlex.split(line.replace("results/sample", str(tmp_path / "sample")))[1:]
        if "--pytest" not in command and command[0] == "grade":
            shutil.rmtree(tmp_path / "sample" / "submissions" / "dan")
        assert main(command) in (0, 3)  # Eve's file needs the instructor's eyes
        shown.append(capsys.readouterr().out)
    (printed,) = blocks(INSTRUCTORS, "text")
    assert outcomes(printed) == outcomes(shown[1])
    sample = tmp_path / "sample"
    assert f"course export {sample}/graded --class {sample}/class\n" in shown[1]
    assert (tmp_path / "sample/graded/feedback/eve.html").is_file()
    assert (tmp_path / "sample/graded/gradescope/01.zip").is_file()


def outcomes(printed: str) -> list[tuple[str, str]]:
    """Return the items that pytest lists, with their outcomes, and the line with their counts."""
    counts = re.findall(r"collected (.*)", printed)
    items = re.findall(r"^(?:.*/)?(\S.*) (PASSED|FAILED|SKIPPED)", printed, flags=re.M)
    return [("collected", counts[0]), *items]


def test_continuous_integration_runs_the_command_of_the_readme():
    """The README promises `make test`, and CI runs it in a clean clone."""
    assert re.search(r"^make test\b", "\n".join(blocks(README, "sh")), flags=re.M)
    script = (ROOT / ".ci" / "run").read_text()
    assert re.search(r"^    step test_with test test$", script, flags=re.M)
    assert re.search(r'^test_with\(\) \{ make "\$\{@:2\}"', script, flags=re.M)


def test_the_workflow_runs_every_job_of_continuous_integration():
    """An unknown job of `.ci/run` is refused with the list of jobs."""
    run = subprocess.run(["bash", ".ci/run", "x"], cwd=ROOT, capture_output=True, text=True)
    assert run.returncode == 2
    _, names = run.stdout.splitlines()[0].split("there is no job x, only ")
    workflow = (ROOT / ".github" / "workflows" / "ci.yml").read_text()
    assert set(re.findall(r"job: (\w+)", workflow)) == set(names.split())


# --- links and dependencies ----------------------------------------------------------------------


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_relative_links_lead_to_existing_files(page):
    prose = re.sub(r"^```.*?^```", "", page.read_text(), flags=re.M | re.S)
    links = re.findall(r"\]\(([^)#\s]+)\)", prose)
    for link in links:
        if "://" not in link:
            assert (page.parent / link).is_file(), link


def settings_of(name: str) -> dict:
    return tomllib.loads((ROOT / name).read_text())


def test_every_dependency_has_a_documented_reason():
    """Dependencies and rows of docs/dependencies.md correspond one to one."""
    groups = []
    for settings in (settings_of("pyproject.toml"), settings_of("src/pyproject.toml")):
        project = settings["project"]
        groups += [project["dependencies"], *project["optional-dependencies"].values()]
        groups += settings.get("dependency-groups", {}).values()
        groups += [settings["build-system"]["requires"]]
    needed = {re.match(r"[\w.-]+", need).group() for group in groups for need in group}
    needed -= {"fieldrecon", "fieldrecon-course"}  # an extra that contains another
    text = (ROOT / "docs" / "dependencies.md").read_text()
    rows = re.findall(r"^\| (?!package|command)([\w.-]+) \| \S", text, flags=re.M)
    assert sorted(rows) == sorted(needed)


def test_version_numbers_agree():
    """Both distributions, the library itself, and CITATION.cff have the same version."""
    version = settings_of("pyproject.toml")["project"]["version"]
    course = settings_of("src/pyproject.toml")["project"]
    assert course["version"] == version
    assert f"fieldrecon=={version}" in course["dependencies"]
    assert fr.__version__ == version
    assert f"\nversion: {version}\n" in (ROOT / "CITATION.cff").read_text()


# --- direction of imports ------------------------------------------------------------------------

LINTER = Path(sys.executable).parent / "lint-imports"
CONTRACTS = (ROOT / "pyproject.toml").read_text().partition("[tool.importlinter]")[2]


UPWARD = [
    ("fieldrecon/kernels/base.py: import fieldrecon.methods.rbf", "Rooms of the library"),
    ("fieldrecon/_core/chunks.py: def f(): from fieldreport import build", "Packages"),
    ("fieldreport/framework/settings.py: from fieldreport import build", "Rooms of the report"),
    ("fieldgrade/sandbox/frames.py: import fieldgrade.commands", "Rooms of the grader"),
    ("fieldrecon/kernels/base.py: import fieldrecon.kernels.positive_definite", "No circles"),
    ("fieldrecon/newroom/__init__.py: ", "Rooms of the library"),
]


@pytest.mark.slow
@pytest.mark.parametrize(("wrong", "broken"), UPWARD)
def test_an_upward_import_is_reported(wrong, broken, tmp_path):
    """`make lint` checks the contracts of pyproject.toml; a new room must be listed in them."""
    shutil.copytree(ROOT / "src", tmp_path / "src", ignore=shutil.ignore_patterns("*.egg-info"))
    (tmp_path / ".importlinter.toml").write_text("[tool.importlinter]" + CONTRACTS)
    name, line = wrong.split(": ", 1)
    file = tmp_path / "src" / name
    file.parent.mkdir(exist_ok=True)
    file.write_text((file.read_text() if file.exists() else "") + f"\n{line}\n")
    checked = subprocess.run(
        [
            Path(sys.executable).parent / "lint-imports",
            "--config",
            ".importlinter.toml",
            "--no-cache",
        ],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(tmp_path / "src"), "COLUMNS": "200"},
        capture_output=True,
        text=True,
    )
    assert checked.returncode == 1, checked.stdout + checked.stderr
    assert broken in re.findall(r"^(.*?)(?::.*)? BROKEN$", checked.stdout, flags=re.M)


def test_the_picture_of_the_architecture_is_up_to_date():
    """`make architecture` draws it from the imports."""
    drawn = runpy.run_path(str(ROOT / "tools" / "architecture.py"))
    picture = drawn["PICTURE"].read_text(encoding="utf-8")
    assert drawn["in_words"](drawn["rooms_and_imports"]()) in picture, "run: make architecture"


SOURCES = {
    ".".join(path.relative_to(ROOT / "src").with_suffix("").parts): path.read_text()
    for path in sorted((ROOT / "src").rglob("*.py"))
}


def imported(source: str) -> set[str]:
    """Full names of the imports of a module at run time, without those for type checkers."""
    tree = ast.parse(source)
    tree.body = [s for s in tree.body if not ast.unparse(s).startswith("if TYPE_CHECKING:")]
    found = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            found |= {f"{node.module}.{alias.name}" for alias in node.names}
    return found


@pytest.mark.slow
def test_the_library_computes_without_matplotlib():
    """Only the room `plotting` imports matplotlib."""
    drawing = {
        module.split(".")[1]
        for module, source in SOURCES.items()
        if module.startswith("fieldrecon.")
        and {name.split(".")[0] for name in imported(source)} & {"matplotlib", "mpl_toolkits"}
    }
    assert drawing == {"plotting"}


@pytest.mark.slow
def test_experiments_import_from_modules_and_not_from_rooms():
    """The build follows these imports to find the code on which a result depends."""
    rooms = {module.removesuffix(".__init__") for module in SOURCES if module.endswith("__init__")}
    experiments = {m: s for m, s in SOURCES.items() if m.startswith("fieldreport.experiments.")}
    named = {m: imported(source) - set(SOURCES) for m, source in experiments.items()}
    assert experiments
    assert {
        m for m, names in named.items() if {n.rpartition(".")[0] for n in names} & rooms
    } == set()


def test_git_tracks_no_generated_files():
    """Git tracks neither the environment nor build outputs."""
    command = ["git", "ls-files", ".venv", "report/build", "*.pyc", "*.egg-info"]
    listed = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert listed.stdout == ""
