"""Draw the architecture from the imports: docs/images/architecture.svg (make architecture).

A room is one level above the highest room from which it imports. An arrow is an import that no
chain of other arrows implies.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

import grimp
import matplotlib as mpl
import matplotlib.pyplot as plt

ROOT = Path(__file__).parents[1]
PICTURE = ROOT / "docs" / "images" / "architecture.svg"
COLORS = {
    "fieldrecon": "#d5e8d4",
    "fieldcheck": "#e1d5e7",
    "fieldreport": "#dae8fc",
    "fieldgrade": "#ffe6cc",
}
WHOLE = ("fieldcheck", "fieldreport.experiments")
STYLE = {"svg.hashsalt": "architecture", "font.size": 8}
WIDTH, LEVEL = 9.0, 0.52
"""Width of the picture and height of a level, in inches."""


def rooms_and_imports() -> dict[str, set[str]]:
    """Return for each room the rooms from which its modules import."""
    graph = grimp.build_graph(*COLORS, exclude_type_checking_imports=True)
    found: dict[str, set[str]] = {}
    for module in graph.modules:
        room = room_of(module)
        below = {room_of(other) for other in graph.find_modules_directly_imported_by(module)}
        if room:
            found.setdefault(room, set()).update(below - {room, ""})
    return found


def room_of(module: str) -> str:
    """Return the room of a module; modules that only collect names belong to no room."""
    parts = module.split(".")
    if parts[0] in WHOLE:
        return parts[0]
    if len(parts) == 1 or parts[1] in ("_public", "_deprecated", "__main__"):
        return ""
    return ".".join(parts[:2])


def levels(imports: dict[str, set[str]]) -> dict[str, int]:
    """Return for each room the length of the longest chain of imports that starts there."""

    @cache
    def level(room: str) -> int:
        return 1 + max(map(level, imports[room]), default=-1)

    return {room: level(room) for room in imports}


def without_detours(imports: dict[str, set[str]]) -> set[tuple[str, str]]:
    """Return the imports that no chain of other imports implies (transitive reduction)."""

    @cache
    def reached(room: str) -> frozenset[str]:
        return frozenset(imports[room]).union(*map(reached, imports[room]))

    return {
        (room, below)
        for room in imports
        for below in imports[room]
        if not any(below in reached(other) for other in imports[room])
    }


def positions(level: dict[str, int], arrows: set[tuple[str, str]]) -> dict[str, float]:
    """Place each room in its row, from 0 to 1, near the rooms from which it imports."""
    x: dict[str, float] = {}
    for height in range(max(level.values()) + 1):
        row = sorted(room for room in level if level[room] == height)
        wanted = {room: [x[b] for a, b in arrows if a == room] or [0.5] for room in row}
        row.sort(key=lambda room: (sum(wanted[room]) / len(wanted[room]), room))
        for k, room in enumerate(row):
            x[room] = (k + 0.5) / len(row)
    return x


def in_words(imports: dict[str, set[str]]) -> str:
    """Return the arrows as text, with which a test checks that the picture is up to date."""
    return "; ".join(
        f"{above} imports {below}" for above, below in sorted(without_detours(imports))
    )


def draw(imports: dict[str, set[str]]) -> None:
    """Write the picture."""
    level, arrows = levels(imports), without_detours(imports)
    x = positions(level, arrows)
    with mpl.rc_context(STYLE):
        page, axes = plt.subplots(figsize=(WIDTH, LEVEL * (max(level.values()) + 1.6)))
        page.subplots_adjust(0, 0, 1, 1)
        for room in sorted(imports):
            package, _, name = room.partition(".")
            box = {"boxstyle": "round,pad=0.35", "fc": COLORS[package], "ec": "#444444", "lw": 0.6}
            axes.text(x[room], level[room], name or package, ha="center", va="center", bbox=box)
        for above, below in sorted(arrows):
            axes.annotate(
                "",
                (x[below], level[below] + 0.22),
                (x[above], level[above] - 0.22),
                arrowprops={"arrowstyle": "->", "color": "#777777", "lw": 0.6},
                zorder=0,
            )
        for k, (package, color) in enumerate(COLORS.items()):
            axes.text(
                0.14 + 0.24 * k,
                max(level.values()) + 1,
                package,
                ha="center",
                va="center",
                weight="bold",
                bbox={"boxstyle": "square,pad=0.4", "fc": color, "ec": "none"},
            )
        axes.set(xlim=(0, 1), ylim=(-0.6, max(level.values()) + 1.5))
        axes.set_axis_off()
        page.savefig(PICTURE, metadata={"Date": None, "Description": in_words(imports)})
    plt.close(page)


if __name__ == "__main__":
    draw(rooms_and_imports())
