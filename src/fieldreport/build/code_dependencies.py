"""Code dependencies of results: the modules that are imported, without comments and docstrings.

Layout has no effect either. In an experiment's own file only the definitions that are reached from
given names are used, so that a change to a plot does not run the experiment again.
"""

from __future__ import annotations

import ast
import json
import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import cache
from importlib.metadata import PackageNotFoundError, packages_distributions, version
from importlib.util import find_spec, resolve_name
from pathlib import Path

from fieldrecon._core.atomic_files import write_atomically
from fieldrecon._core.digests import bytes_digest

PACKAGES = ("fieldrecon", "fieldreport")
_distributions = cache(packages_distributions)


@dataclass(frozen=True)
class Statement:
    """The relevant properties of a statement at the top level of a module."""

    form: str
    """The SHA-256 of its normal form."""
    defined: frozenset[str]
    used: frozenset[str]
    imports: tuple[str, ...]


_kept: dict[str, list] = {}


@contextmanager
def statement_cache(path: Path) -> Iterator[None]:
    """Cache the statements of all modules in a file: the next build parses only changed modules."""
    clear_caches()
    with suppress(OSError, ValueError):
        _kept.update(json.loads(path.read_text(encoding="utf-8")))
    before = set(_kept)
    yield
    if before != set(_kept):
        write_atomically(path, json.dumps(_kept).encode())


def code_digests(module: str, names: Iterable[str] = ()) -> dict[str, str]:
    """Return digests of the code on which some definitions of a module depend.

    Parameters
    ----------
    module : str
        Full name of the module.
    names : iterable of str
        Top-level definitions to start from; none means the whole module.

    Returns
    -------
    dict
        The SHA-256 of the normal form of each module of this project, and the version of each other
        package.
    """
    statements = _reached(_statements(module), tuple(names))
    found = {module: _digest(statements)}
    todo = {target for s in statements for target in s.imports}
    while todo:
        name = todo.pop()
        if name in found:
            continue
        found[name] = _module_digest(name) if _is_ours(name) else _version(name)
        todo |= _imported(name) if _is_ours(name) else set()
    return dict(sorted(found.items()))


def clear_caches() -> None:
    """Clear all caches, so that all modules are read again."""
    _kept.clear()
    for memory in (
        _surroundings,
        _statements,
        _module_digest,
        _imported,
        _package,
        _submodule,
        _version,
    ):
        memory.cache_clear()


def _is_ours(module: str) -> bool:
    return module.partition(".")[0] in PACKAGES


@cache
def _module_digest(module: str) -> str:
    return _digest(_statements(module))


@cache
def _imported(module: str) -> frozenset[str]:
    return frozenset(target for s in _statements(module) for target in s.imports)


def _digest(statements: Iterable[Statement]) -> str:
    return bytes_digest("\n".join(s.form for s in statements).encode())


@cache
def _statements(module: str) -> tuple[Statement, ...]:
    """Parse a module, once in a build: most experiments and figures depend on most modules."""
    spec = find_spec(module)
    if spec is None or not spec.origin:
        raise ImportError(f"there is no module {module}")
    text = Path(spec.origin).read_text(encoding="utf-8")
    key = bytes_digest("\n".join([_surroundings(), module, text]).encode())
    if key in _kept:
        return tuple(
            Statement(f, frozenset(d), frozenset(u), tuple(i)) for f, d, u, i in _kept[key]
        )
    statements = _parsed(text, module)
    _kept[key] = [[s.form, sorted(s.defined), sorted(s.used), s.imports] for s in statements]
    return statements


@cache
def _surroundings() -> str:
    """Return what else affects parsing: Python version, this file, names of all modules."""
    folders = [Path(find_spec(package).origin).parent for package in PACKAGES]  # type: ignore
    names = sorted(str(path) for folder in folders for path in folder.rglob("*.py"))
    return "\n".join([sys.version, Path(__file__).read_text(encoding="utf-8"), *names])


def _parsed(text: str, module: str) -> tuple[Statement, ...]:
    body = ast.parse(text).body
    body = [s for s in body if not _is_text(s)] or [ast.Pass()]
    return tuple(_statement(s, module) for s in body)


def _statement(s: ast.stmt, module: str) -> Statement:
    nodes = list(ast.walk(s))
    for node in nodes:
        if isinstance(node, ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            node.body = [s for s in node.body if not _is_text(s)] or [ast.Pass()]
    return Statement(
        bytes_digest(ast.dump(s).encode()),
        frozenset(_defined(s)),
        frozenset(node.id for node in nodes if isinstance(node, ast.Name)),
        tuple(_imports(nodes, module)),
    )


def _is_text(statement: ast.stmt) -> bool:
    """Whether a statement is a docstring, or a string that documents a constant."""
    return (
        isinstance(statement, ast.Expr)
        and isinstance(statement.value, ast.Constant)
        and isinstance(statement.value.value, str)
    )


def _reached(statements: tuple[Statement, ...], names: Iterable[str]) -> tuple[Statement, ...]:
    """Select the statements that define what the names need, and those that define nothing."""
    if not names:
        return statements
    needed = set(names).union(*(s.used for s in statements if not s.defined))
    while True:
        kept = tuple(s for s in statements if not s.defined or s.defined & needed)
        grown = needed.union(*(s.used for s in kept))
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


def _imports(nodes: Iterable[ast.AST], module: str) -> Iterator[str]:
    """Yield the modules that are imported, at any depth, without the standard library."""
    for node in nodes:
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
                yield target if root in PACKAGES else root


def _asks_by_name(node: ast.AST) -> bool:
    """Whether a node is a call such as ``find_spec("matplotlib")`` that finds a package."""
    match node:
        case ast.Call(func=ast.Name(id=name) | ast.Attribute(attr=name), args=[first, *_]):
            known = name in {"find_spec", "files", "import_module"}
            return known and isinstance(first, ast.Constant) and isinstance(first.value, str)
    return False


@cache
def _package(module: str) -> str:
    spec = find_spec(module)
    return (spec.parent if spec else None) or module


@cache
def _submodule(base: str, name: str) -> str:
    """Return ``base.name`` where that is a module of these packages, else ``base``."""
    inner = f"{base}.{name}"
    spec = find_spec(base) if _is_ours(base) else None
    is_module = spec is not None and spec.submodule_search_locations and find_spec(inner)
    return inner if is_module else base


@cache
def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:  # its import name differs from its distribution name
        return version(_distributions()[package][0])
