"""Comparison with other libraries: error against time.

The experiment does no timing: it reads what ``make bench`` measured.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from fieldrecon.plotting.style import FULL_WIDTH, METHOD_COLORS, figure, shades
from fieldreport.framework.experiment import Map, Result, ResultTable
from fieldreport.framework.parameters import Parameters, input_file, parameter
from fieldreport.framework.result_files import read_benchmark, select_columns, tables


@dataclass(frozen=True)
class Params(Parameters):
    """The measurements."""

    results: str = input_file("benchmarks/results/peers.json", "file that make bench wrote")
    large: int = parameter(50_000, "smallest number of sites of a large cloud", least=1)
    small: int = parameter(1000, "largest number of sites of a small cloud", least=0)


QUICK = Params(large=100_000)

OURS, USUAL = "fieldrecon", "fieldrecon patches"
CHOSEN, KRIGING, LINEAR = "fieldrecon, chosen for the data", "kriging", "SciPy LinearND"
PACKAGES = ("numpy", "scipy", "ferreus_rbf", "wlsqm", "verde", "scikit-learn")
DATA = {
    "smooth": "Franke's function",
    "front": "a steep front",
    "clusters": "half of the sites in clusters",
    "noisy": "noise of one part in a hundred",
    "terrain": "terrain, m",
    "cube": "a wave in space",
}
NONE = "–"
ROUNDING = 1e-6
NOISE = 0.01
TOLD_SITES, LAND, MEANS = 100_000, 50_000, 4000
TOLD = {
    "smooth_usual": ("smooth", TOLD_SITES, USUAL),
    "smooth_r7": ("smooth", TOLD_SITES, "fieldrecon patches, r⁷"),
    "smooth_wlsqm4": ("smooth", TOLD_SITES, "wlsqm, degree 4"),
    "smooth_scipy3": ("smooth", TOLD_SITES, "SciPy RBF, r³, 40 neighbours"),
    "noisy_usual": ("noisy", TOLD_SITES, USUAL),
    "noisy_linear": ("noisy", TOLD_SITES, "SciPy LinearND"),
    "noisy_means": ("noisy", TOLD_SITES, f"fieldrecon patches, {MEANS} means"),
    "land_chosen": ("terrain", LAND, "fieldrecon patches, by leave-one-out"),
}
"""Runs with facts for seconds and error, by the prefix of the facts."""


class MethodRun(NamedTuple):
    """One method on one data set: seconds in total and of the parts; the error; memory in MiB."""

    data: str
    sites: int
    method: str
    fit: float
    evaluate: float
    total: float
    cpu: float
    rms: float
    left_out: int
    memory: int

    @property
    def ours(self) -> bool:
        """Whether it is a method of this library."""
        return self.method.startswith(OURS)

    def covers(self, other: MethodRun) -> bool:
        """Whether neither its time nor its error is larger."""
        return self.total <= other.total and self.is_as_accurate_as(other)

    def is_as_accurate_as(self, other: MethodRun) -> bool:
        """Whether its error is not larger, up to rounding, which differs between libraries."""
        return self.rms <= other.rms * (1 + ROUNDING)


COLUMNS = (
    "data",
    "sites",
    "method",
    "fit s",
    "evaluate s",
    "total s",
    "cpu s",
    "rms error",
    "left out",
    "memory MiB",
)
SURVEYS = (
    "survey",
    "samples",
    "our error",
    "our seconds",
    "best peer",
    "its error over ours",
    "linear over ours",
    "kriging over ours",
)
LOST = (
    "data",
    "sites",
    "peer",
    "its seconds",
    "its error",
    "our error by then",
    "our seconds to that error",
)


def run(params: Params, each: Map = map) -> Result:  # noqa: ARG001 - there is nothing to run
    """Read the measurements."""
    result = read_benchmark(params.results)
    (table,) = tables(result)
    measured = [MethodRun._make(row) for row in select_columns(table, COLUMNS).rows]
    runs = [r for r in measured if r.data in DATA]
    machine, patience = result["machine"], result["parameters"]["patience in seconds"]
    lost = uncovered(runs)
    facts = {
        "processor": machine["processor"],
        "cores": machine["cores used"],
        "runs": len(runs),
        "methods": len({r.method for r in runs}),
        "peers_runs": sum(not r.ours for r in runs),
        "lost": len(lost),
        "peers_runs_large": sum(not r.ours and r.sites >= params.large for r in runs),
        "lost_large": sum(r.sites >= params.large for r in lost),
        "ahead_large": sum(_is_ahead(runs, r) and r.sites >= params.large for r in runs),
        "land_lost": sum(r[:2] == ("terrain", LAND) for r in lost),
        "lost_small": sum(r.sites <= params.small for r in lost),
        "repeats": result["parameters"]["repeats"],
        "patience": patience,
        "stopped": sum("stopped after" in note for note in result["notes"]),
        **_numbers(runs),
        **_targets(runs, patience),
    }
    told = {
        "runs": ResultTable(COLUMNS, tuple(runs)),
        "lost": _losses(runs, lost),
        "lost_beyond_small": _losses(runs, [r for r in lost if r.sites > params.small]),
        "versions": ResultTable(
            ("package", "version"), tuple((name, f"version {machine[name]}") for name in PACKAGES)
        ),
        "surveys": on_surveys([r for r in measured if r.data not in DATA]),
        **{
            f"{data}_{n}": _side_by_side(runs, data, n)
            for data, n in dict.fromkeys((r.data, r.sites) for r in runs)
        },
    }
    return Result(params, told, facts)


def uncovered(runs: Sequence[MethodRun]) -> list[MethodRun]:
    """Runs of other libraries that are not covered by one of ours on the same data."""
    return [
        peer
        for peer in runs
        if not peer.ours
        and not any(mine.covers(peer) for mine in _ours(runs, peer.data, peer.sites))
    ]


def _is_ahead(runs: Sequence[MethodRun], peer: MethodRun) -> bool:
    """Whether a run is both faster and more accurate than every run of ours on the same data."""
    mine = _ours(runs, peer.data, peer.sites)
    return not peer.ours and all(peer.total < r.total and peer.rms < r.rms for r in mine)


def _ours(runs: Iterable[MethodRun], data: str, sites: int) -> list[MethodRun]:
    return [r for r in runs if r.ours and (r.data, r.sites) == (data, sites)]


def _losses(runs: Sequence[MethodRun], lost: Iterable[MethodRun]) -> ResultTable:
    return ResultTable(LOST, tuple(_loss(runs, peer) for peer in lost))


def _loss(runs: Sequence[MethodRun], peer: MethodRun) -> tuple[str | int | float, ...]:
    """Return our error in the time of another run, and our time for its error."""
    mine = _ours(runs, peer.data, peer.sites)
    error = min((r.rms for r in mine if r.total <= peer.total), default=NONE)
    seconds = min((r.total for r in mine if r.is_as_accurate_as(peer)), default=NONE)
    return peer.data, peer.sites, peer.method, peer.total, peer.rms, error, seconds


def _side_by_side(runs: Iterable[MethodRun], data: str, n: int) -> ResultTable:
    """Every method on one data set, by increasing error."""
    here = sorted((r for r in runs if (r.data, r.sites) == (data, n)), key=lambda r: r.rms)
    return ResultTable(
        ("method", "fit s", "evaluate s", "rms error", "cores busy", "memory MiB"),
        tuple((r.method, r.fit, r.evaluate, r.rms, r.cpu / r.total, r.memory) for r in here),
    )


def on_surveys(runs: Sequence[MethodRun]) -> ResultTable:
    """The chosen method on each survey, and errors of others relative to it.

    The best peer answers all queries; linear interpolation answers those inside the hull.
    """
    rows = []
    for data, n in dict.fromkeys((r.data, r.sites) for r in runs):
        here = {r.method: r for r in runs if (r.data, r.sites) == (data, n)}
        own = here[CHOSEN]
        complete = [r for r in here.values() if not r.ours and not r.left_out]
        best = min(complete, key=lambda r: r.rms)
        others = [here[m].rms / own.rms if m in here else NONE for m in (LINEAR, KRIGING)]
        rows.append((data, n, own.rms, own.total, best.method, best.rms / own.rms, *others))
    return ResultTable(SURVEYS, tuple(rows))


def _numbers(runs: Sequence[MethodRun]) -> dict[str, float | str]:
    """Return seconds and errors of the reported runs, and of the most accurate peers."""
    facts: dict[str, float | str] = {"told_sites": TOLD_SITES, "land_sites": LAND, "means": MEANS}
    for name, told in TOLD.items():
        (own,) = (r for r in runs if r[:3] == told)
        facts |= {f"{name}_seconds": own.total, f"{name}_error": own.rms}
        if name == "noisy_linear":
            facts["noisy_linear_of_noise"] = own.rms / NOISE
    for name, where in (("noisy", ("noisy", TOLD_SITES)), ("land", ("terrain", LAND))):
        best = min((r for r in runs if r[:2] == where and not r.ours), key=lambda r: r.rms)
        facts |= {
            f"{name}_best_peer": best.method,
            f"{name}_best_error": best.rms,
            f"{name}_best_seconds": best.total,
        }
    return facts


def _targets(runs: Sequence[MethodRun], patience: float) -> dict[str, float | str]:
    """Return the facts about the targets: the largest clouds against the fast multipole method."""
    facts: dict[str, float | str] = {}
    for data in ("smooth", "cube"):
        n = max(r.sites for r in runs if r.data == data)
        here = {r.method: r for r in runs if (r.data, r.sites) == (data, n)}
        rival = min((r for m, r in here.items() if m.startswith("ferreus")), key=lambda r: r.rms)
        ours = here[USUAL]
        facts |= {
            f"{data}_sites": n,
            f"{data}_rival": rival.method,
            f"{data}_error_ratio": rival.rms / ours.rms,
            f"{data}_gigabytes": ours.memory / 1024,
            f"{data}_seconds": ours.total,
            f"{data}_error": ours.rms,
            f"{data}_rival_seconds": rival.total,
            f"{data}_patience_over_ours": float(patience // ours.total),  # a lower bound
        }
    return facts


LIBRARIES: Mapping[str, tuple[str, Any]] = {
    "fieldrecon": (METHOD_COLORS["PU"], "-"),
    "SciPy": (METHOD_COLORS["MLS"], (0, (5, 1.5))),
    "ferreus_rbf": (METHOD_COLORS["RBF"], (0, (6, 1.5, 1, 1.5))),
    "wlsqm": (METHOD_COLORS["LS"], (0, (1, 1.2))),
    "verde": ("#b04a3a", (0, (3, 1, 1, 1, 1, 1))),
    "scikit-learn": ("#707070", (0, (2, 2))),
}
"""Colour and dashes of each library."""
MARKERS = "oDs^vP*Xd<>ph"
RANGE = 30.0
HIGHEST = {"terrain": 10.0}
"""Largest errors drawn, in metres: one peer would otherwise compress all other curves."""


def looks(methods: Iterable[str]) -> dict[str, dict[str, Any]]:
    """Return the line styles: ours thick, in shades, with filled markers; the others open."""
    methods = list(methods)
    own = [method for method in methods if method.startswith(OURS)]
    shade = dict(zip(own, shades("PU", len(own)), strict=True))
    seen: Counter[str] = Counter()
    drawn = {}
    for method in methods:
        library = method.replace(",", "").split()[0]
        ours = library == OURS
        color, dashes = LIBRARIES[library]
        color = shade[method]["color"] if ours else color
        drawn[method] = {
            "color": color,
            "linestyle": dashes,
            "linewidth": 1.5 if ours else 0.8,
            "marker": MARKERS[seen[library]],
            "markersize": 5.0 if ours else 4.6,
            "markerfacecolor": color if ours else "white",
            "markeredgewidth": 0.8,
            "label": method,
            "zorder": 3 if ours else 2,
        }
        seen[library] += 1
    return drawn


def plot(result: Result) -> Figure:
    """Draw error against seconds, a panel for each set of data."""
    table = result.tables["runs"]
    methods = looks(dict.fromkeys(map(str, table.column("method"))))
    data = table.columns.index("data")
    with figure(FULL_WIDTH, height=8.6, rows=3, columns=2) as (page, axes):
        for panel, (name, title) in zip(axes.ravel(), DATA.items(), strict=True):
            here = ResultTable(table.columns, tuple(r for r in table.rows if r[data] == name))
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


def plot_growth(result: Result) -> Figure:
    """Draw seconds and memory against the number of sites."""
    table = result.tables["runs"]
    here = ResultTable(table.columns, tuple(r for r in table.rows if r[0] == "smooth"))
    methods = looks(dict.fromkeys(map(str, here.column("method"))))
    with figure(FULL_WIDTH, height=4.4, columns=2) as (page, axes):
        for panel, column, title in (
            (axes[0], "total s", "seconds, fit and evaluation"),
            (axes[1], "memory MiB", "memory of the process, MiB"),
        ):
            _curves(panel, here, methods, "sites", column)
            panel.set(
                title=title, xlabel="number of sites and of queries", xscale="log", yscale="log"
            )
        _legend(page, axes)
    return page


def _curves(
    panel: Axes, table: ResultTable, methods: Mapping[str, Mapping[str, Any]], x: str, y: str
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
