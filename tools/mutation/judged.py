"""What was judged by hand: choices, which are not changed, and mutants that compute the same."""

from __future__ import annotations

import re
import tomllib
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parents[2]
LIST = Path(__file__).with_name("equivalent.toml")


@cache
def listed() -> dict[str, list[dict]]:
    """Return the choices and the equivalent mutants of the list."""
    return tomllib.loads(LIST.read_text())


def choices(path: str) -> set[str]:
    """Return the constants of a file that decide time, memory or looks alone."""
    constants = (c.split(":") for entry in listed()["choice"] for c in entry["constants"])
    return {name for file, name in constants if file == path}


def outdated() -> list[str]:
    """Return the entries of the list whose file or code is not there any more."""

    def code(path: str) -> str:
        file = ROOT / path
        return "\n".join(map(str.strip, file.read_text().splitlines())) if file.exists() else ""

    places = [c.split(":") for entry in listed()["choice"] for c in entry["constants"]]
    lines = [(entry["path"], entry["before"]) for entry in listed()["mutant"]]
    return [
        *(
            f"{path}: {name}"
            for path, name in places
            if not re.search(rf"^{name}\b", code(path), re.M)
        ),
        *(f"{path}: {before}" for path, before in lines if before not in code(path)),
    ]


@cache
def equivalents() -> set[tuple[str, str, str]]:
    """Return path and lines, before and after, of the mutants that compute the same."""
    return {
        (entry["path"], entry["before"], after)
        for entry in listed()["mutant"]
        for after in entry["after"]
    }
