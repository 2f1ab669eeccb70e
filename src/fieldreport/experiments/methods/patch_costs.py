"""Partition-of-unity RBF: measured time by kernel, degree, patch size, overlap and sites.

The experiment does no timing: it reads what ``make bench`` measured.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NoReturn

import numpy as np
from matplotlib.figure import Figure

from fieldrecon.plotting.style import FULL_WIDTH, METHOD_COLORS, figure, line
from fieldreport.framework.error_measures import order
from fieldreport.framework.experiment import Cell, Map, Result, ResultTable
from fieldreport.framework.parameters import Parameters, input_file, parameter
from fieldreport.framework.result_files import read_benchmark, tables


@dataclass(frozen=True)
class Params(Parameters):
    """The measurements, and the defaults of the library."""

    results: str = input_file("benchmarks/results/patch_sizes.json", "file that make bench wrote")
    kernel: str = parameter(
        "r³", "default kernel", choices=("r² log r", "r³", "r⁴ log r", "r⁵", "r⁷", "Wendland C⁴")
    )
    degree: int = parameter(3, "default degree of polynomials", least=-1)
    patch: int = parameter(40, "default number of sites in a patch", least=1)

    most: float = parameter(1.15, "target for the exponent of growth, at most", above=0, most=10)


QUICK = Params(patch=24)

DATA = {"smooth": "Franke's function", "front": "a steep front", "noisy": "noise"}
STEPS = ("set-up", "fit", "evaluate")
KERNELS = {
    "r² log r": METHOD_COLORS["LS"],
    "r³": METHOD_COLORS["PU"],
    "r⁴ log r": "#6f9a3e",
    "r⁵": METHOD_COLORS["MLS"],
    "r⁷": METHOD_COLORS["RBF"],
    "Wendland C⁴": "#707070",
}
TOLD = {
    "linear": ("r³", 1, 40),
    "quartic": ("r³", 4, 40),
    "few": ("r³", 3, 16),
    "quintic": ("r⁵", 3, 40),
    "septic": ("r⁷", 3, 40),
    "plate": ("r² log r", 1, 40),
}
"""Choices with facts, besides the default."""
MARKERS = {1: "o", 2: "s", 3: "D", 4: "^"}


def run(params: Params, each: Map = map) -> Result:  # noqa: ARG001 - there is nothing to run
    """Read the measurements."""
    result = read_benchmark(params.results)
    choices, overlap, growth = tables(result)
    grown = ResultTable(growth.columns, tuple(r for r in growth.rows if isinstance(r[0], int)))
    return Result(
        params,
        {"choices": choices, "overlap": overlap, "growth": grown},
        {
            "sites": result["parameters"]["sites"],
            **_told(params, choices),
            **dict(_of_growth(grown)),
        },
    )


def _told(params: Params, choices: ResultTable) -> dict[str, Cell]:
    """Return seconds and errors of the default and of some other choices, by name."""
    usual = (params.kernel, params.degree, params.patch)
    facts: dict[str, Cell] = {}
    for name, choice in {"usual": usual, **TOLD}.items():
        (own,) = [row for row in choices.rows if row[:3] == choice] or _refuse(choice, choices)
        numbers = dict(zip(choices.columns, own, strict=True))
        facts[f"{name}_seconds"] = numbers["total, s"]
        facts |= {f"{name}_{data}": numbers[f"rms error, {data}"] for data in DATA}
    return facts | {"few_patch": TOLD["few"][2]}


def _refuse(choice: tuple[str, int, int], choices: ResultTable) -> NoReturn:
    kernel, degree, patch = choice
    measured = [row[1:3] for row in choices.rows if row[0] == kernel]
    degrees, patches = (", ".join(map(str, sorted(set(x)))) for x in zip(*measured, strict=True))
    raise ValueError(
        f"parameters degree and patch must be one of {degrees} and one of {patches}, "
        f"which were measured for {kernel}; got {degree} and {patch}"
    )


def _of_growth(growth: ResultTable) -> Iterator[tuple[str, Cell]]:
    """Yield exponents p of seconds C n^p in the plane, and time and memory of the largest cloud."""
    plane = [r for r in growth.rows if r[1] == 2]
    sites, steps = np.array([r[0] for r in plane]), np.array([r[2:5] for r in plane])
    yield "most_sites", int(sites[-1])
    yield "most_sites_seconds", float(steps[-1].sum())
    yield "most_sites_gigabytes", plane[-1][5]
    columns = zip(("set_up", "fit", "evaluate"), steps.T, strict=True)
    for name, seconds in (*columns, ("fitting", steps[:, :2].sum(axis=1)), ("all", steps.sum(1))):
        yield f"exponent_{name}", order(sites, seconds)


def plot(result: Result) -> Figure:
    """Error against time, a curve for each kernel and degree along which patches grow."""
    table = result.tables["choices"]
    kinds = dict.fromkeys((str(row[0]), int(row[1])) for row in table.rows)
    with figure(FULL_WIDTH, height=3.9, columns=3) as (page, axes):
        for panel, (name, title) in zip(axes, DATA.items(), strict=True):
            error = table.columns.index(f"rms error, {name}")
            seconds = table.columns.index("total, s")
            for kernel, degree in kinds:
                own = [r for r in table.rows if r[:2] == (kernel, degree)]
                panel.plot(
                    [r[seconds] for r in own],
                    [r[error] for r in own],
                    color=KERNELS[kernel],
                    marker=MARKERS[degree],
                    markersize=3.6,
                    linewidth=1.0,
                    label=f"{kernel}, degree {degree}",
                )
            panel.set(title=title, xlabel="seconds", yscale="log")
        axes[0].set_ylabel("root mean square error")
        page.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=4)
    return page


def plot_growth(result: Result) -> Figure:
    """Seconds of the three steps, and memory, against the number of sites."""
    plane = [r for r in result.tables["growth"].rows if r[1] == 2]
    sites = [r[0] for r in plane]
    with figure(FULL_WIDTH, height=2.5, columns=2) as (page, (left, right)):
        for k, (step, look) in enumerate(zip(STEPS, ("LS", "MLS", "PU"), strict=True)):
            left.plot(sites, [r[2 + k] for r in plane], **line(look, label=step))
        left.legend()
        left.set(
            title="seconds", xlabel="number of sites and of queries", xscale="log", yscale="log"
        )
        right.plot(sites, [r[5] for r in plane], **line("PU"))
        right.set(
            title="memory, GB", xlabel="number of sites and of queries", xscale="log", yscale="log"
        )
    return page
