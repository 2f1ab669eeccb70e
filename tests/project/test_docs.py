"""What the documents say is so: commands, links, dependencies, and which way imports point."""

import ast
import re
import subprocess
import tomllib
from collections.abc import Iterator
from functools import cache
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

import fieldrecon as fr
from checkout import ROOT
from fieldrecon.cli.main import main

PACKAGE = ROOT / "src" / "fieldrecon"
README = (ROOT / "README.md").read_text()
PAGES = sorted([*ROOT.glob("*.md"), *ROOT.glob("docs/**/*.md")])


def blocks(text: str, language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```", text, flags=re.M | re.S)


# --- what the README tells the reader to do -----------------------------------------------------


def test_the_readme_s_code_runs():
    """Each example is complete, and its comments state the shapes that come out."""
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


def test_the_readme_s_make_targets_exist():
    """Each `make TARGET` of any page is a target of the Makefile."""
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
def test_the_readme_s_commands_run(command, tmp_path, monkeypatch, capsys):
    """As they stand there, in a folder that holds a table of samples."""
    monkeypatch.chdir(tmp_path)
    heights = (f"{x},{y},{x * y}" for x in range(6) for y in range(6))
    (tmp_path / "points.csv").write_text("\n".join(["east,north,height", *heights]))
    assert main(command) == 0
    assert capsys.readouterr().out


def test_continuous_integration_runs_the_readme_s_command():
    """What the README promises is what is tried in a clean clone."""
    assert re.search(r"^make test\b", "\n".join(blocks(README, "sh")), flags=re.M)
    script = (ROOT / ".ci" / "run").read_text()
    assert re.search(r"^    step test_with test test$", script, flags=re.M)
    assert re.search(r'^test_with\(\) \{ make "\$\{@:2\}"', script, flags=re.M)


def test_the_workflow_runs_every_job_of_continuous_integration():
    """And a name that is no job of `.ci/run` is refused, with the names that are."""
    run = subprocess.run(["bash", ".ci/run", "x"], cwd=ROOT, capture_output=True, text=True)
    assert run.returncode == 2
    _, names = run.stdout.splitlines()[0].split("there is no job x, only ")
    workflow = (ROOT / ".github" / "workflows" / "ci.yml").read_text()
    assert set(re.findall(r"job: (\w+)", workflow)) == set(names.split())


# --- what the pages point to --------------------------------------------------------------------


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_relative_links_lead_somewhere(page):
    """To a file of this checkout."""
    prose = re.sub(r"^```.*?^```", "", page.read_text(), flags=re.M | re.S)
    links = re.findall(r"\]\(([^)#\s]+)\)", prose)
    for link in links:
        if "://" not in link:
            assert (page.parent / link).is_file(), link


def test_every_dependency_has_its_reason():
    """And every reason its dependency: one row each in docs/dependencies.md."""
    with (ROOT / "pyproject.toml").open("rb") as file:
        settings = tomllib.load(file)
    project = settings["project"]
    groups = [project["dependencies"], *project["optional-dependencies"].values()]
    groups += [*settings["dependency-groups"].values(), settings["build-system"]["requires"]]
    needed = {re.match(r"[\w.-]+", need).group() for group in groups for need in group}
    needed -= {"fieldrecon"}  # an extra that contains another
    text = (ROOT / "docs" / "dependencies.md").read_text()
    rows = re.findall(r"^\| (?!package)([\w.-]+) \| \S", text, flags=re.M)
    assert sorted(rows) == sorted(needed)


def test_versions_agree():
    """The number in pyproject.toml is the one to cite, and the one that the library tells."""
    with (ROOT / "pyproject.toml").open("rb") as file:
        version = tomllib.load(file)["project"]["version"]
    assert fr.__version__ == version
    assert f"\nversion: {version}\n" in (ROOT / "CITATION.cff").read_text()


# --- which way imports point --------------------------------------------------------------------


def module_name(path: Path) -> str:
    parts = path.relative_to(PACKAGE).with_suffix("").parts
    return ".".join(parts).removesuffix(".__init__").removesuffix("__init__")


@cache
def modules() -> dict[str, Path]:
    """The modules below the package, without its name; the package itself gathers from all."""
    return {n: p for p in sorted(PACKAGE.rglob("*.py")) if (n := module_name(p))}


def runtime_nodes(tree: ast.AST) -> Iterator[ast.AST]:
    """All nodes of a module, but those that only a type checker reads."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.If) and ast.unparse(node.test).endswith("TYPE_CHECKING"):
            continue
        yield node
        yield from runtime_nodes(node)


@cache
def imports(source: str) -> set[str]:
    """Full names of what a module imports, names within a module included."""
    found = set()
    for node in runtime_nodes(ast.parse(source)):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, "imports are absolute"
            found |= {f"{node.module}.{alias.name}" for alias in node.names}
    return found


def imported_modules(source: str) -> set[str]:
    """Modules of this package that a module imports."""
    known = modules()
    found = set()
    for name in imports(source):
        inside = name.removeprefix("fieldrecon.")
        if inside != name:
            found.add(inside if inside in known else inside.rpartition(".")[0])
    return found


@cache
def layers() -> dict[str, int]:
    """The rows of the table in docs/architecture.md."""
    text = (ROOT / "docs" / "architecture.md").read_text()
    table = text.split("| layer | modules |\n|---|---|\n")[1].split("\n\n")[0]
    rows = [re.findall(r"`([\w.]+)`", row) for row in table.splitlines()]
    return {name: i for i, row in enumerate(rows) for name in row}


def layer(module: str, table: dict[str, int]) -> int:
    """Row of a module: its own, else that of the package it is in."""
    while module and module not in table:
        module = module.rpartition(".")[0]
    return table[module]


def wrong_way(module: str, source: str) -> set[str]:
    """Modules that this one imports from a lower row than its own."""
    table = layers()
    own = layer(module, table)
    return {m for m in imported_modules(source) if m and layer(m, table) > own}


def test_every_module_has_its_layer():
    """The table of docs/architecture.md names all modules, and no other."""
    table = layers()
    homeless = {m for m in modules() if m not in table and m.split(".")[0] not in table}
    assert homeless == set(), "add them to the table of docs/architecture.md"
    assert set(table) <= set(modules())


def test_imports_point_one_way():
    """A module imports from its own layer and those before it."""
    wrong = {module: wrong_way(module, path.read_text()) for module, path in modules().items()}
    assert {module: names for module, names in wrong.items() if names} == {}


@pytest.mark.parametrize(
    ("module", "source"),
    [
        ("polynomials", "from fieldrecon.methods.rbf import RBF"),
        ("rbf", "import fieldrecon.datasets.synthetic"),
        ("datasets", "def f():\n    from fieldrecon import experiments"),
        ("experiments.terrain", "from fieldreport.build.build import main"),
        ("reporting.style", "from fieldreport.framework.experiment import Result"),
    ],
)
def test_an_import_the_wrong_way_is_seen(module, source):
    """Whatever its form, and inside functions too."""
    assert len(wrong_way(module, source)) == 1


def test_there_are_no_cycles():
    """Modules of one layer may use one another, but not in a circle."""
    graph = {m: imported_modules(p.read_text()) - {m} for m, p in modules().items()}
    TopologicalSorter(graph).prepare()


def test_only_experiments_and_reporting_draw():
    """The library computes without matplotlib, and so does the command line before it draws."""
    drawing = {
        module.split(".")[0]
        for module, path in modules().items()
        if any(
            name.split(".")[0] in ("matplotlib", "mpl_toolkits")
            for name in imports(path.read_text())
        )
    }
    assert drawing == {"experiments", "reporting"}


def test_experiments_name_the_modules_they_use():
    """Never the package as a whole: the build follows imports to see what a result depends on."""
    experiments = [m for m in modules() if m.startswith("experiments.")]
    assert experiments
    assert not [m for m in experiments if "fieldrecon" in imports(modules()[m].read_text())]


def test_the_checkout_holds_no_generated_file():
    """Git has neither the environment nor what was built."""
    command = ["git", "ls-files", ".venv", "report/build", "*.pyc", "*.egg-info"]
    listed = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert listed.stdout == ""
