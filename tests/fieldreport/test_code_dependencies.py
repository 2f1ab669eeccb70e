"""Code dependencies: the cached digests equal those from reading every module again."""

import ast
import sys
from hashlib import sha256
from importlib.metadata import version
from importlib.util import find_spec, resolve_name
from pathlib import Path

import pytest

from fieldreport import experiments
from fieldreport.build import code_dependencies
from fieldreport.build.code_dependencies import PACKAGES, _defined, code_digests
from fieldreport.build.rerun import RUN_NAMES


def is_text(statement):
    value = getattr(statement, "value", None)
    return isinstance(statement, ast.Expr) and isinstance(getattr(value, "value", None), str)


def parsed(module):
    """The statements of a module without docstrings, read anew."""
    tree = ast.parse(Path(find_spec(module).origin).read_text(encoding="utf-8"))
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            node.body = [s for s in node.body if not is_text(s)] or [ast.Pass()]
    return tree.body


def used(statement):
    return {node.id for node in ast.walk(statement) if isinstance(node, ast.Name)}


def imported(statement, module):
    """Full names of the imports of a statement, at any depth."""
    spec = find_spec(module)
    for node in ast.walk(statement):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = resolve_name("." * node.level + (node.module or ""), spec.parent)
            yield from (inner_module(base, alias.name) or base for alias in node.names)
        elif isinstance(node, ast.Call) and node.args:
            name = getattr(node.func, "id", getattr(node.func, "attr", None))
            argument = getattr(node.args[0], "value", None)
            if name in {"find_spec", "files", "import_module"} and isinstance(argument, str):
                yield argument


def inner_module(base, name):
    ours = base.partition(".")[0] in PACKAGES and find_spec(base).submodule_search_locations
    return f"{base}.{name}" if ours and find_spec(f"{base}.{name}") else None


def digest(text):
    return sha256(text.encode()).hexdigest()


def digests_by_definition(module, names):
    """The digests by their definition: each module is parsed wherever it occurs."""
    statements = parsed(module)
    needed, before = set(names), None
    while needed != before:
        before = set(needed)
        kept = [s for s in statements if not (d := set(_defined(s))) or d & needed]
        needed |= set().union(*map(used, kept))
    found = {module: kept}
    todo = [t for s in kept for t in imported(s, module)]
    while todo:
        name = todo.pop()
        root = name.partition(".")[0]
        if name in found or root in sys.stdlib_module_names:
            continue
        if root not in PACKAGES:
            found[root] = None
        else:
            found[name] = parsed(name)
            todo += [t for s in found[name] for t in imported(s, name)]
    return {
        name: s and digest("\n".join(digest(ast.dump(one)) for one in s))
        for name, s in found.items()
    }


@pytest.mark.slow
@pytest.mark.parametrize("name", ["power_sampling", "terrain", "variational_implicits"])
@pytest.mark.parametrize("names", [RUN_NAMES, ("plot",)], ids=["run", "plot"])
@pytest.mark.parametrize("kept", [False, True], ids=["parsed", "kept"])
def test_the_code_digests_agree_with_their_definition(name, names, kept, tmp_path):
    """The modules, their digests, and the versions of packages are the same."""
    module = experiments.module_of(name)
    if kept:
        with code_dependencies.statement_cache(tmp_path / "code.json"):
            code_digests(module, names)
    with code_dependencies.statement_cache(tmp_path / "code.json"):
        fast, slow = code_digests(module, names), digests_by_definition(module, names)
    assert set(fast) == set(slow)
    assert {m: fast[m] for m, form in slow.items() if form} == {m: f for m, f in slow.items() if f}
    assert fast["numpy"] == version("numpy")
    assert len(slow) > 5


@pytest.mark.slow
def test_each_module_is_parsed_once(monkeypatch):
    """The number of results that depend on the module does not matter."""
    parsed_trees = []

    def parse(*arguments, whole=ast.parse, **options):
        parsed_trees.append(arguments)
        return whole(*arguments, **options)

    found = set()
    modules = [experiments.module_of(name) for name in ("power_sampling", "terrain", "peers")]
    code_dependencies.clear_caches()
    with monkeypatch.context() as during:
        during.setattr(ast, "parse", parse)
        for module in modules:
            for names in (RUN_NAMES, ("plot",), ("run",)):
                found |= set(code_digests(module, names))
    assert len(parsed_trees) == len([name for name in found if name.startswith(PACKAGES)])


def test_a_cached_module_is_parsed_again_only_when_it_changed(tmp_path, monkeypatch):
    monkeypatch.setattr(experiments, "__path__", [str(tmp_path), *experiments.__path__])
    module, file, kept = f"{experiments.__name__}.fake_c", tmp_path / "fake_c.py", tmp_path / "kept"
    parsed_texts = []

    def parse(text, module, whole=code_dependencies._parsed):
        parsed_texts.append(text)
        return whole(text, module)

    monkeypatch.setattr(code_dependencies, "_parsed", parse)
    found = []
    for text in ("import math\nx = 1\n", "import math\nx = 1\n", "import numpy\nx = 2\n"):
        file.write_text(text)
        with code_dependencies.statement_cache(kept):
            found.append(code_digests(module))
    assert found[0] == found[1] != found[2]
    assert set(found[2]) == {module, "numpy"}
    assert parsed_texts == ["import math\nx = 1\n", "import numpy\nx = 2\n"]
