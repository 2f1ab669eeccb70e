"""Parameter values given as text: by the command line, or by a settings file."""

from __future__ import annotations

import math
import typing
from collections.abc import Mapping
from dataclasses import fields, replace
from typing import Any

from fieldreport.framework.names import no_such

_WORDS = {
    bool: "true or false",
    int: "a whole number",
    float: "a finite number",
    str: "a text",
}


def replace_parameters(params: Any, settings: Mapping[str, Any]) -> Any:
    """Return the parameters with some fields replaced; values are checked against declared types.

    Parameters
    ----------
    params : dataclass
        Fields are of type int, float, bool, str, or ``tuple[T, ...]`` of one of those.
    settings : mapping of str
        New values by field: a text from the command line (``"0.1"``; a tuple is a list with commas,
        ``"1,2,4"``), or a value of the declared type from a settings file.

    Raises
    ------
    ValueError
        If a field does not exist, or a value has another type or lies outside its domain.

    Examples
    --------
    >>> from dataclasses import dataclass
    >>> @dataclass(frozen=True)
    ... class Params:
    ...     powers: tuple[int, ...] = (1, 2)
    ...     epsilon: float = 1.0
    >>> replace_parameters(Params(), {"powers": "1,3", "epsilon": 2})
    Params(powers=(1, 3), epsilon=2.0)
    """
    types = typing.get_type_hints(type(params))
    known = [f.name for f in fields(params)]
    for name in settings:
        if name not in known:
            raise ValueError(f"there is {no_such('parameter', name, known)}")
    return replace(params, **{name: _of(name, types[name], x) for name, x in settings.items()})


def _of(name: str, kind: Any, x: Any) -> Any:
    if typing.get_origin(kind) is tuple:
        return _tuple_of(name, typing.get_args(kind)[0], x)
    value = _read(kind, x) if isinstance(x, str) else _as(kind, x)
    if value is None:
        raise ValueError(f"parameter {name} must be {_WORDS[kind]}; got {x!r}")
    return value


def _tuple_of(name: str, kind: Any, x: Any) -> tuple:
    items = [item.strip() for item in x.split(",")] if isinstance(x, str) else x
    if not isinstance(items, list | tuple) or not items or "" in items:
        raise ValueError(f"parameter {name} must be a list such as 1,2,4; got {x!r}")
    return tuple(_of(name, kind, item) for item in items)


def _read(kind: type, text: str) -> Any:
    """Return the value that a text represents, or None."""
    if kind is str:
        return text
    if kind is bool:
        return {"true": True, "false": False}.get(text.lower())
    try:
        return _as(kind, kind(text))
    except ValueError:
        return None


def _as(kind: type, x: Any) -> Any:
    """Return the value as that type, or None; an integer is accepted as a float, a bool is not."""
    if kind is float and isinstance(x, int | float) and not isinstance(x, bool):
        return float(x) if math.isfinite(x) else None
    return x if type(x) is kind else None
