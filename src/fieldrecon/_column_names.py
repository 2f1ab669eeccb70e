"""Which columns of a table hold coordinates and value: those named, else those of usual names."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

_USUAL = {
    "x": ("x", "easting", "east", "lon", "long", "longitude"),
    "y": ("y", "northing", "north", "lat", "latitude"),
    "z": ("z", "height", "elevation", "depth", "altitude"),
    "value": ("value", "f", "v", "z", "h", "height", "elevation", "depth", "intensity"),
}


def chosen_columns(path: Path, columns: list[str], names: Mapping[str, str | None]) -> list[int]:
    """Find the columns of the coordinates and of the value."""
    for name in names.values():
        if name is not None and name not in columns:
            raise ValueError(f"{path} has no column {name!r}; it has {', '.join(columns)}")
    named = [columns.index(name) for name in names.values() if name is not None]
    found: dict[str, int | None] = {}
    for role, name in names.items():
        taken = {*named, *found.values()}
        usual = _usual(columns, _USUAL[role], taken)
        found[role] = columns.index(name) if name is not None else usual
    left = set(range(len(columns))) - set(found.values())
    if found["value"] is None and len(left) == 1:
        found["value"] = left.pop()
    for role, column in found.items():
        if column is None:
            raise ValueError(
                f"it is not clear which column of {path} to take; "
                f"name it with --{role}: {', '.join(columns)}"
            )
    chosen = [column for column in found.values() if column is not None]
    if len(set(chosen)) < len(chosen):
        raise ValueError("the coordinates and the value must be different columns")
    return chosen


def _usual(columns: list[str], usual: Sequence[str], taken: Iterable[int | None]) -> int | None:
    """Find the column of the most usual name, if any is left; units in brackets do not count."""
    taken = set(taken)
    bare = {bare_name(name): k for k, name in reversed([*enumerate(columns)]) if k not in taken}
    return next((bare[name] for name in usual if name in bare), None)


def bare_name(name: str) -> str:
    return name.lower().split("(")[0].split("[")[0].strip()
