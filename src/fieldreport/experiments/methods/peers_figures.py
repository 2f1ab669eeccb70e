"""Pictures of the comparison with other libraries: a colour for each, a marker for each method."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from typing import Any

from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from fieldrecon.plotting.style import FULL_WIDTH, METHOD_COLORS, figure
from fieldreport.framework.experiment import Table

LIBRARIES: Mapping[str, tuple[str, Any]] = {
    "fieldrecon": (METHOD_COLORS["PU"], "-"),
    "SciPy": (METHOD_COLORS["MLS"], (0, (5, 1.5))),
    "ferreus_rbf": (METHOD_COLORS["RBF"], (0, (6, 1.5, 1, 1.5))),
    "wlsqm": (METHOD_COLORS["LS"], (0, (1, 1.2))),
    "verde": ("#b04a3a", (0, (3, 1, 1, 1, 1, 1))),
    "scikit-learn": ("#707070", (0, (2, 2))),
}
"""Colour and dashes of each library."""
MARKERS = "oDs^vP*Xd"
RANGE = 30.0
HIGHEST = {"terrain": 10.0}
"""Errors beyond which nothing is drawn, in metres: one peer would make the others a line."""


def looks(methods: Iterable[str]) -> dict[str, dict[str, Any]]:
    """Return how each method is drawn: ours in thick lines and full marks, the others' open."""
    seen: Counter[str] = Counter()
    drawn = {}
    for method in methods:
        library = method.replace(",", "").split()[0]
        color, dashes = LIBRARIES[library]
        ours = library == "fieldrecon"
        drawn[method] = {
            "color": color,
            "linestyle": dashes,
            "linewidth": 1.5 if ours else 0.8,
            "marker": MARKERS[seen[library]],
            "markersize": 4.2 if ours else 4.6,
            "markerfacecolor": color if ours else "white",
            "markeredgewidth": 0.8,
            "label": method,
            "zorder": 3 if ours else 2,
        }
        seen[library] += 1
    return drawn


def draw_errors(table: Table, titles: Mapping[str, str]) -> Figure:
    """Draw error against seconds, a panel for each set of data."""
    methods = looks(dict.fromkeys(map(str, table.column("method"))))
    data = table.columns.index("data")
    with figure(FULL_WIDTH, height=8.6, rows=3, columns=2) as (page, axes):
        for panel, (name, title) in zip(axes.ravel(), titles.items(), strict=True):
            here = Table(table.columns, tuple(r for r in table.rows if r[data] == name))
            shown = {m: look for m, look in methods.items() if m in here.column("method")}
            _curves(panel, here, shown, "total s", "rms error")
            panel.set(title=title, xscale="log", yscale="log")
            _label(panel.xaxis)
            if name in HIGHEST:
                panel.set(yscale="linear", ylim=(None, HIGHEST[name]))
        for panel in axes[-1]:
            panel.set_xlabel("seconds, fit and evaluation")
        for panel in axes[:, 0]:
            panel.set_ylabel("root mean square error")
        _legend(page, axes.ravel())
    return page


def _label(axis: Axis) -> None:
    """Label an axis of little more than a decade or less at 1, 2 and 5, in plain numbers."""
    low, high = axis.get_data_interval()
    if high / low < RANGE:
        axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        axis.set_major_formatter(FuncFormatter(lambda x, _: f"{x:g}"))
        axis.set_minor_formatter(NullFormatter())


def draw_growth(table: Table, data: str) -> Figure:
    """Draw seconds and memory against the number of sites."""
    here = Table(table.columns, tuple(r for r in table.rows if r[0] == data))
    methods = looks(dict.fromkeys(map(str, here.column("method"))))
    with figure(FULL_WIDTH, height=4.4, columns=2) as (page, axes):
        for panel, column, title in (
            (axes[0], "total s", "seconds, fit and evaluation"),
            (axes[1], "memory MiB", "memory of the process, MiB"),
        ):
            _curves(panel, here, methods, "sites", column)
            panel.set(title=title, xlabel="sites, and as many queries", xscale="log", yscale="log")
        _legend(page, axes)
    return page


def _curves(
    panel: Axes, table: Table, methods: Mapping[str, Mapping[str, Any]], x: str, y: str
) -> None:
    numbers = list(zip(*(table.column(name) for name in ("method", x, y)), strict=True))
    for method, look in methods.items():
        own = [(u, v) for m, u, v in numbers if m == method]
        panel.plot(*zip(*own, strict=True), **look)


def _legend(page: Figure, panels: Iterable[Axes]) -> None:
    """Put every method once below the panels."""
    drawn: dict[str, Artist] = {}
    for panel in panels:
        handles, labels = panel.get_legend_handles_labels()
        drawn |= dict(zip(map(str, labels), handles, strict=True))
    order = sorted(drawn, key=lambda label: [*LIBRARIES].index(label.replace(",", "").split()[0]))
    page.legend(
        [drawn[label] for label in order], order, loc="outside lower center", ncols=3, fontsize=7
    )
