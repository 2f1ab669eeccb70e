"""Names of columns: those that are usual for coordinates and values, and units in brackets."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence

AXES = ("x", "y", "z")
_WITH_UNIT = re.compile(r"(.*\S)\s*(?:\[([^][]+)\]|\(([^(),\s]+)\))\s*")
_USUAL_NAMES = {
    "x": ("x", "easting", "east", "lon", "long", "longitude"),
    "y": ("y", "northing", "north", "lat", "latitude"),
    "z": ("z", "height", "elevation", "depth", "altitude"),
    "value": ("value", "f", "v", "z", "h", "height", "elevation", "depth", "intensity"),
}


def chosen_columns(table: object, columns: list[str], names: Mapping[str, str | None]) -> list[int]:
    """Return the indices of the columns for each role: by the given name, else by a usual one.

    Parameters
    ----------
    table : Path or Frame
        For the messages.
    columns : list of str
        The columns of the table.
    names : mapping of str to str or None
        The names that were given for the roles x, y, z and value.

    Raises
    ------
    ValueError
        If a named column is missing, a role has no column, or two roles have the same one.
    """
    for name in names.values():
        if name is not None and name not in columns:
            raise ValueError(f"{table} has no column {name!r}; it has {', '.join(columns)}")
    named = [columns.index(name) for name in names.values() if name is not None]
    found: dict[str, int | None] = {}
    for role, name in names.items():
        taken = {*named, *found.values()}
        usual = _usual_column(columns, _USUAL_NAMES.get(role, ()), taken)
        found[role] = columns.index(name) if name is not None else usual
    unused = set(range(len(columns))) - set(found.values())
    if found["value"] is None and len(unused) == 1:
        found["value"] = unused.pop()
    for role, column in found.items():
        usual_names = _USUAL_NAMES.get(role, ())
        other = next((o for o, c in found.items() if _is_usual(columns, c, usual_names)), None)
        if column is None and role in AXES and other is not None:
            raise ValueError(
                f"the column {names[other]} of {table} was named as {other}, and no other column "
                f"is {role}; the columns are {', '.join(columns)}"
            )
        if column is None:
            raise ValueError(
                f"it is not clear which column of {table} is {role}; "
                f"name it by the option {role}: {', '.join(columns)}"
            )
    chosen = [column for column in found.values() if column is not None]
    if len(set(chosen)) < len(chosen):
        raise ValueError("the coordinates and the value must be different columns")
    return chosen


def _usual_column(
    columns: list[str], usual: Sequence[str], taken: Iterable[int | None]
) -> int | None:
    """Return the free column with the most usual name, if there is one."""
    taken = set(taken)
    bare = {bare_name(name): k for k, name in reversed([*enumerate(columns)]) if k not in taken}
    return next((bare[name] for name in usual if name in bare), None)


def _is_usual(columns: list[str], column: int | None, usual: Sequence[str]) -> bool:
    return column is not None and bare_name(columns[column]) in usual


def bare_name(name: str) -> str:
    """Return the name of a column in lower case, without its unit in brackets."""
    return name.lower().split("(")[0].split("[")[0].strip()


def name_and_unit(name: str) -> tuple[str, str]:
    """Return the name of a column without its unit, and the unit in brackets or an empty string.

    Examples
    --------
    >>> name_and_unit("depth [m]"), name_and_unit("f(x, y)")
    (('depth', 'm'), ('f(x, y)', ''))
    """
    found = _WITH_UNIT.fullmatch(name)
    return (found[1], found[2] or found[3]) if found else (name, "")
