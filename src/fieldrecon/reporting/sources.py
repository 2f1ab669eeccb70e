"""Which code a result depends on: imports are followed and only the meaning of the source counts.

Comments, docstrings and layout change nothing. Of an experiment's own file only the definitions
that are reached from given names count, so that work on a plot does not run the experiment again.
"""

from __future__ import annotations

import ast
import sys
from collections.abc import Iterable, Iterator
from functools import cache
from importlib.metadata import PackageNotFoundError, packages_distributions, version
from importlib.util import find_spec, resolve_name
from pathlib import Path

PACKAGE = __name__.partition(".")[0]


def code_behind(module: str, names: Iterable[str] = ()) -> dict[str, str]:
    """Collect the code on which some definitions of a module depend.

    Parameters
    ----------
    module : str
        Full name of the module.
    names : iterable of str
        Top-level definitions to start from; none means the whole module.

    Returns
    -------
    dict
        For each module of this package its normal form, for each foreign package its version.
    """
    found: dict[str, str] = {}
    todo = [(module, tuple(names))]
    while todo:
        name, wanted = todo.pop()
        if name in found:
            continue
        if name.partition(".")[0] != PACKAGE:
            found[name] = _version(name)
            continue
        statements = _statements(name)
        statements = _reached(statements, wanted) if wanted else statements
        found[name] = "\n".join(ast.dump(s) for s in statements)
        todo += [(target, ()) for s in statements for target in _imports(s, name)]
    return dict(sorted(found.items()))


@cache
def _statements(module: str) -> list[ast.stmt]:
    spec = find_spec(module)
    if spec is None or not spec.origin:
        raise ImportError(f"there is no module {module}")
    tree = ast.parse(Path(spec.origin).read_text(encoding="utf-8"))
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            node.body = [s for s in node.body if not _is_text(s)] or [ast.Pass()]
    return tree.body


def _is_text(statement: ast.stmt) -> bool:
    """Tell a docstring, or a string that documents a constant, from code."""
    return (
        isinstance(statement, ast.Expr)
        and isinstance(statement.value, ast.Constant)
        and isinstance(statement.value.value, str)
    )


def _reached(statements: list[ast.stmt], names: Iterable[str]) -> list[ast.stmt]:
    """Keep the statements that define what the names need, and those that define nothing."""
    definitions = [(s, set(_defined(s))) for s in statements]
    needed = set(names).union(*(_used(s) for s, defined in definitions if not defined))
    while True:
        kept = [s for s, defined in definitions if not defined or defined & needed]
        grown = needed.union(*map(_used, kept))
        if grown == needed:
            return kept
        needed = grown


def _defined(statement: ast.stmt) -> Iterator[str]:
    match statement:
        case ast.FunctionDef(name=name) | ast.AsyncFunctionDef(name=name) | ast.ClassDef(name=name):
            yield name
        case ast.Import(names=aliases) | ast.ImportFrom(names=aliases):
            yield from ((alias.asname or alias.name).partition(".")[0] for alias in aliases)
        case ast.Assign() | ast.AnnAssign():
            targets = getattr(statement, "targets", None) or [statement.target]  # type: ignore[union-attr]
            yield from (n.id for t in targets for n in ast.walk(t) if isinstance(n, ast.Name))


def _used(statement: ast.stmt) -> set[str]:
    return {node.id for node in ast.walk(statement) if isinstance(node, ast.Name)}


def _imports(statement: ast.stmt, module: str) -> Iterator[str]:
    """Name the modules that a statement imports, at any depth; the standard library left out."""
    for node in ast.walk(statement):
        if isinstance(node, ast.Import):
            targets = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            base = resolve_name("." * node.level + (node.module or ""), _package(module))
            targets = [_submodule(base, alias.name) for alias in node.names]
        elif _asks_by_name(node):
            targets = [node.args[0].value]  # type: ignore[attr-defined]
        else:
            continue
        for target in targets:
            root = target.partition(".")[0]
            if root not in sys.stdlib_module_names:
                yield target if root == PACKAGE else root


def _asks_by_name(node: ast.AST) -> bool:
    """Tell a call such as ``find_spec("matplotlib")``, with which a package's files are found."""
    match node:
        case ast.Call(func=ast.Name(id=name) | ast.Attribute(attr=name), args=[first, *_]):
            known = name in {"find_spec", "files", "import_module"}
            return known and isinstance(first, ast.Constant) and isinstance(first.value, str)
    return False


def _package(module: str) -> str:
    spec = find_spec(module)
    return (spec.parent if spec else None) or module


def _submodule(base: str, name: str) -> str:
    """Return ``base.name`` where that is a module of this package, else ``base``."""
    inner = f"{base}.{name}"
    spec = find_spec(base) if base.partition(".")[0] == PACKAGE else None
    is_module = spec is not None and spec.submodule_search_locations and find_spec(inner)
    return inner if is_module else base


@cache
def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:  # imported under another name than it is installed under
        return version(packages_distributions()[package][0])
