"""Error against time, beside what else an engineer could take.

Nothing is timed here: the numbers are those of ``make bench``, read from the file that it wrote.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from matplotlib.figure import Figure

from fieldreport.experiments.methods.peers_figures import draw_errors, draw_growth
from fieldreport.framework.experiment import (
    Map,
    Result,
    Table,
    input_file,
    parameter,
    require_at_least,
)
from fieldreport.framework.benchmark_results import measured, selected, tables


@dataclass(frozen=True)
class Params:
    """The measurements."""

    results: str = input_file("benchmarks/results/peers.json", "file that make bench wrote")
    large: int = parameter(50_000, "number of sites from which on a cloud is called large")
    small: int = parameter(1000, "number of sites up to which it is called small")

    def __post_init__(self) -> None:
        require_at_least(self, large=1, small=0)


QUICK = Params(large=100_000)

OURS, USUAL = "fieldrecon", "fieldrecon patches"
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
"""Runs of which the text tells seconds and error, by the names it has for them."""


class Run(NamedTuple):
    """One method on one set of data: seconds of all, and of the parts; the error; memory in MiB."""

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

    def covers(self, other: Run) -> bool:
        """Whether it takes no longer and errs no more."""
        return self.total <= other.total and self.is_as_accurate_as(other)

    def is_as_accurate_as(self, other: Run) -> bool:
        """Whether it errs no more; the same interpolant by two libraries differs by rounding."""
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
    """Read what was measured."""
    result = measured(params.results)
    (table,) = tables(result)
    runs = [Run._make(row) for row in selected(table, COLUMNS).rows]
    ratios = {(c["what"], c["peer"]): c for c in result["comparisons"]}
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
        **_targets(runs, ratios, patience),
    }
    told = {
        "runs": Table(COLUMNS, tuple(runs)),
        "lost": _losses(runs, lost),
        "lost_beyond_small": _losses(runs, [r for r in lost if r.sites > params.small]),
        "versions": Table(
            ("package", "version"), tuple((name, f"version {machine[name]}") for name in PACKAGES)
        ),
        **{
            f"{data}_{n}": _side_by_side(runs, ratios, data, n)
            for data, n in dict.fromkeys((r.data, r.sites) for r in runs)
        },
    }
    return Result(params, told, facts)


def uncovered(runs: Sequence[Run]) -> list[Run]:
    """Peers' runs that none of ours on the same data covers."""
    return [
        peer
        for peer in runs
        if not peer.ours
        and not any(mine.covers(peer) for mine in _ours(runs, peer.data, peer.sites))
    ]


def _is_ahead(runs: Sequence[Run], peer: Run) -> bool:
    """Whether a peer is both faster and more accurate than every one of ours on the same data."""
    mine = _ours(runs, peer.data, peer.sites)
    return not peer.ours and all(peer.total < r.total and peer.rms < r.rms for r in mine)


def _ours(runs: Iterable[Run], data: str, sites: int) -> list[Run]:
    return [r for r in runs if r.ours and (r.data, r.sites) == (data, sites)]


def _losses(runs: Sequence[Run], lost: Iterable[Run]) -> Table:
    return Table(LOST, tuple(_loss(runs, peer) for peer in lost))


def _loss(runs: Sequence[Run], peer: Run) -> tuple[str | int | float, ...]:
    """Return what ours do in the peer's time, and how long they take to its error."""
    mine = _ours(runs, peer.data, peer.sites)
    error = min((r.rms for r in mine if r.total <= peer.total), default=NONE)
    seconds = min((r.total for r in mine if r.is_as_accurate_as(peer)), default=NONE)
    return peer.data, peer.sites, peer.method, peer.total, peer.rms, error, seconds


def _side_by_side(
    runs: Iterable[Run], ratios: Mapping[tuple[str, str], Mapping[str, float]], data: str, n: int
) -> Table:
    """Every method on one set of data, in the order of its errors, times over our usual one's."""
    rows = []
    for r in sorted((r for r in runs if (r.data, r.sites) == (data, n)), key=lambda r: r.rms):
        c = ratios.get((f"{data}, {n} sites: fit and evaluate", r.method))
        times = f"{_times(c['ratio'])} ({_times(c['most'])} … {_times(c['least'])})" if c else NONE
        rows.append((r.method, r.fit, r.evaluate, times, r.rms, r.cpu / r.total, r.memory))
    return Table(
        (
            "method",
            "fit s",
            "evaluate s",
            "times our time",
            "rms error",
            "cores busy",
            "memory MiB",
        ),
        tuple(rows),
    )


def _times(ratio: float) -> str:
    """Return a ratio turned round, with two digits or more."""
    return f"{1 / ratio:.2g}" if ratio > 0.1 else f"{1 / ratio:.0f}"


def _numbers(runs: Sequence[Run]) -> dict[str, float | str]:
    """Return seconds and errors of the runs that are told of, and of the most accurate peers."""
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


def _targets(
    runs: Sequence[Run], ratios: Mapping[tuple[str, str], Mapping[str, float]], patience: float
) -> dict[str, float | str]:
    """Return what was aimed at: the largest clouds against the fast multipole method."""
    facts: dict[str, float | str] = {}
    for data in ("smooth", "cube"):
        n = max(r.sites for r in runs if r.data == data)
        here = {r.method: r for r in runs if (r.data, r.sites) == (data, n)}
        rival = min((r for m, r in here.items() if m.startswith("ferreus")), key=lambda r: r.rms)
        c = ratios[f"{data}, {n} sites: fit and evaluate", rival.method]
        ours = here[USUAL]
        facts |= {
            f"{data}_sites": n,
            f"{data}_rival": rival.method,
            f"{data}_times": 1 / c["ratio"],
            f"{data}_times_least": 1 / c["most"],
            f"{data}_times_most": 1 / c["least"],
            f"{data}_error_ratio": rival.rms / ours.rms,
            f"{data}_gigabytes": ours.memory / 1024,
            f"{data}_seconds": ours.total,
            f"{data}_error": ours.rms,
            f"{data}_rival_seconds": rival.total,
            f"{data}_patience_over_ours": patience / ours.total,
        }
    return facts


def plot(result: Result) -> Figure:
    """Error at places left out against the time of fit and evaluation, a curve for each method."""
    return draw_errors(result.tables["runs"], DATA)


def plot_growth(result: Result) -> Figure:
    """Time of fit and evaluation, and memory, against the number of sites."""
    return draw_growth(result.tables["runs"], "smooth")
