"""Digests of all that a verdict depends on: the keys of the cache.

A digest of a file would change with every comment, and one file has the checks of a whole notebook.
Therefore the digest follows a function to the functions that it calls, by their compiled code
without line numbers. A change to one check does not change the digests of others.
"""

from __future__ import annotations

import inspect
import platform
import sys
import sysconfig
from collections.abc import Collection, Mapping
from dataclasses import fields, is_dataclass
from functools import cache, partial
from importlib.metadata import distributions
from importlib.resources import files
from importlib.resources.abc import Traversable
from pathlib import Path
from types import CodeType, FunctionType, ModuleType
from typing import Any

import numpy as np

from fieldrecon._core.digests import bytes_digest

OURS = ("fieldcheck", "fieldgrade", "fieldrecon", "fieldreport")


def dependency_digest(*things: Any) -> str:
    """Return a digest of functions with all that they call, of numbers, arrays and records.

    Examples
    --------
    >>> one, other = (lambda x: x + 1), (lambda x: x + 2)
    >>> dependency_digest(one) == dependency_digest(lambda x: x + 1)
    True
    >>> dependency_digest(one) == dependency_digest(other)
    False
    """
    return bytes_digest(repr(_structure(things, {})).encode())


def _structure(thing: Any, seen: dict[int, tuple[int, Any]]) -> Any:
    """Return an object as nested tuples; an object that occurs again is replaced by its number."""
    if thing is None or isinstance(thing, bool | int | float | complex | str | bytes):
        return repr(thing)
    if id(thing) in seen:
        return ("again", seen[id(thing)][0])
    seen[id(thing)] = (len(seen), thing)
    if isinstance(thing, np.ndarray):
        return ("array", thing.dtype.str, thing.shape, thing.tobytes().hex())
    if isinstance(thing, tuple | list):
        return tuple(_structure(part, seen) for part in thing)
    if isinstance(thing, set | frozenset):
        return ("set", *sorted(repr(part) for part in thing))
    if isinstance(thing, Mapping):
        return tuple((repr(key), _structure(thing[key], seen)) for key in sorted(thing, key=repr))
    if isinstance(thing, partial):
        return ("partial", *_structure((thing.func, thing.args, thing.keywords), seen))
    if hasattr(thing, "__wrapped__"):
        return ("wrapped", _structure(thing.__wrapped__, seen))
    if isinstance(thing, FunctionType) and _is_ours(thing.__module__):
        return _function(thing, seen)
    if is_dataclass(thing) and not isinstance(thing, type):
        parts = {field.name: getattr(thing, field.name) for field in fields(thing)}
        return (type(thing).__qualname__, _structure(parts, seen))
    return _by_name(thing)


def _function(function: FunctionType, seen: dict[int, tuple[int, Any]]) -> Any:
    """Return the code of a function, with its defaults, closure and the globals that it uses."""
    known = function.__globals__
    around = [cell.cell_contents for cell in function.__closure__ or ()]
    return (
        _code(function.__code__),
        _structure((function.__defaults__, function.__kwdefaults__, around), seen),
        *((n, _structure(known[n], seen)) for n in sorted(_names(function.__code__)) if n in known),
    )


def _code(code: CodeType) -> Any:
    constants = [
        _code(c)
        if isinstance(c, CodeType)
        else repr(sorted(map(repr, c)))
        if isinstance(c, frozenset)
        else repr(c)
        for c in code.co_consts
    ]
    return (
        code.co_code.hex(),
        tuple(constants),
        code.co_names,
        code.co_varnames,
        code.co_freevars,
        code.co_argcount,
        code.co_kwonlyargcount,
        code.co_posonlyargcount,
        code.co_flags,
    )


def _names(code: CodeType) -> set[str]:
    inner = (c for c in code.co_consts if isinstance(c, CodeType))
    return set(code.co_names).union(*map(_names, inner))


def _by_name(thing: Any) -> Any:
    """Return the name of an object of a library; for this project, with the digest of its file."""
    kind = thing if isinstance(thing, ModuleType | type) or callable(thing) else type(thing)
    module = kind.__name__ if isinstance(kind, ModuleType) else getattr(kind, "__module__", "")
    name = (module, getattr(kind, "__qualname__", getattr(kind, "__name__", type(kind).__name__)))
    return (*name, _file(module)) if _is_ours(module) else name


@cache
def _file(module: str) -> str:
    try:
        return bytes_digest(Path(inspect.getfile(sys.modules[module])).read_bytes())
    except (KeyError, TypeError, OSError):
        return ""


def _is_ours(module: str | None) -> bool:
    """Whether a module belongs to this project or to a course, rather than to a library."""
    name = module or ""
    if name.partition(".")[0] in OURS or name not in sys.modules:
        return name != ""
    file = getattr(sys.modules[name], "__file__", None)
    return file is not None and not any(Path(file).is_relative_to(p) for p in _libraries())


@cache
def _libraries() -> set[str]:
    return {sysconfig.get_path(name) for name in ("stdlib", "platlib", "purelib")}


@cache
def environment_digest() -> str:
    """Return a digest of Python, the machine, and the version of every installed package."""
    installed = sorted(f"{found.name}=={found.version}" for found in distributions())
    return dependency_digest(sys.version, platform.machine(), installed)


JUDGING = {
    "fieldcheck": ("answers", "calls", "judge", "question", "seeds", "shapes", "verdict"),
    "fieldgrade.authoring": ("hidden_cases", "known_answers", "trials"),
    "fieldgrade.checking": ("check_results", "course", "grade_submission", "instructor_checks"),
    "fieldgrade.grading": ("pytest_items",),
    "fieldgrade.isolation": ("file_access", "server", "session"),
    "fieldgrade.sandbox": (),
    "fieldgrade.submissions": ("definitions", "submission"),
}
"""The modules that every verdict depends on, by package; all modules if none is named."""


@cache
def grader_digest() -> str:
    """Return a digest of the code that runs and judges answers, without the checks."""
    return dependency_digest([_files(files(package), stems) for package, stems in JUDGING.items()])


def _files(package: Traversable, stems: Collection[str]) -> list[tuple[str, str]]:
    return [
        (file.name, bytes_digest(file.read_bytes()))
        for file in sorted(package.iterdir(), key=lambda file: file.name)
        if file.name.endswith(".py") and (not stems or file.name.removesuffix(".py") in stems)
    ]
