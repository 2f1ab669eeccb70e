"""The largest clouds, measured on an idle machine.

The experiment does no timing: it reads what ``make bench ONLY=million`` measured.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from matplotlib.figure import Figure

from fieldrecon.plotting.style import figure
from fieldreport.framework.experiment import Map, Result
from fieldreport.framework.parameters import Parameters, input_file, parameter
from fieldreport.framework.result_files import read_benchmark, select_columns, tables

USUAL, SMALL = "fieldrecon patches", "fieldrecon patches of 32"
RIVAL = "ferreus_rbf, thin plate"
TITLES = {"smooth": "in the plane", "cube": "in space"}
COLUMNS = (
    "data",
    "sites",
    "method",
    "fit s",
    "evaluate s",
    "total s",
    "least s",
    "most s",
    "cpu s",
    "rms error",
    "memory MiB",
)


@dataclass(frozen=True)
class Params(Parameters):
    """The measurements."""

    results: str = input_file("benchmarks/results/million.json", "file that make bench wrote")
    wanted: float = parameter(
        10.0, "target for the speed, in multiples of that of ferreus_rbf", least=1, most=1e6
    )


QUICK = Params(wanted=5.0)


def run(params: Params, each: Map = map) -> Result:  # noqa: ARG001 - there is nothing to run
    """Read the measurements."""
    result = read_benchmark(params.results)
    (table,) = tables(result)
    runs = select_columns(table, COLUMNS)
    found = [dict(zip(COLUMNS, row, strict=True)) for row in runs.rows]
    facts: dict[str, float | int | str] = {"repeats": result["parameters"]["repeats"]}
    for comparison in result["comparisons"]:
        if comparison["peer"] == RIVAL:
            facts |= dict(_against(found, comparison, params.wanted))
    return Result(params, {"runs": runs}, facts)


def _against(
    found: list[dict[str, Any]], comparison: Mapping[str, Any], wanted: float
) -> Iterator[tuple[str, float | int | str]]:
    """Yield the facts of a cloud: times and errors of ferreus_rbf relative to fieldrecon."""
    data = comparison["what"].partition(",")[0]
    here = {r["method"]: r for r in found if r["data"] == data}
    ours, theirs = here[USUAL], here[RIVAL]
    yield f"{data}_sites", ours["sites"]
    times = comparison["seconds_of_peer"] / comparison["seconds"]  # of the medians, as in the text
    yield f"{data}_times", times
    yield f"{data}_verdict", "reached" if times >= wanted else "missed"
    yield f"{data}_seconds", comparison["seconds"]
    yield f"{data}_rival_seconds", comparison["seconds_of_peer"]
    yield f"{data}_cpu_times", theirs["cpu s"] / ours["cpu s"]
    yield f"{data}_cores", ours["cpu s"] / ours["total s"]
    yield f"{data}_error_ratio", theirs["rms error"] / ours["rms error"]
    yield f"{data}_gigabytes", ours["memory MiB"] / 1024
    if SMALL in here:
        yield f"{data}_small_times", theirs["total s"] / here[SMALL]["total s"]
        yield f"{data}_small_error_ratio", theirs["rms error"] / here[SMALL]["rms error"]


def plot(result: Result) -> Figure:
    """Seconds of fit and evaluation, side by side."""
    runs = [dict(zip(COLUMNS, row, strict=True)) for row in result.tables["runs"].rows]
    clouds = list(dict.fromkeys((str(r["data"]), int(r["sites"])) for r in runs))
    with figure(height=2.2, columns=len(clouds)) as (page, axes):
        for panel, (data, sites) in zip(axes, clouds, strict=True):
            here = [r for r in runs if r["data"] == data][::-1]
            names = [str(r["method"]) for r in here]
            fit = [float(r["fit s"]) for r in here]
            panel.barh(names, fit, color="0.45", label="fit")
            panel.barh(
                names,
                [float(r["evaluate s"]) for r in here],
                left=fit,
                color="0.75",
                label="evaluation",
            )
            panel.set(xlabel="seconds", title=f"{sites:,} points, {TITLES[data]}")
            panel.grid(visible=False, axis="y")
        page.set_layout_engine("constrained", wspace=0.06)  # the names are between the panels
        axes[-1].legend(loc="upper right")  # where bars are short
    return page
