"""Measure the speed and the memory of fieldrecon against its peers: python -m benchmarks."""

from __future__ import annotations

import argparse
import importlib
import os
from collections.abc import Iterable, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.progress import Progress

    from benchmarks.timing import Track

NAMES = (
    "moving_least_squares",
    "radial_basis_functions",
    "memory",
    "scaling",
    "mesh_velocities",
    "mesh_scaling",
    "barycentric",
    "grading",
    "grading_workers",
    "grading_class",
    "mesh_audit",
    "normals",
    "surfaces",
    "patch_sizes",
    "streaming",
    "peers",
    "million",
    "surveys",
)
RESULTS = Path(__file__).parent / "results"
DOCS = Path(__file__).parents[1] / "docs"
CORES = 2


def main(arguments: list[str] | None = None) -> None:
    """Run the named benchmarks, show their results and write them to files."""
    parser = _parser()
    asked = parser.parse_args(arguments)
    if unknown := sorted({*asked.names} - {*NAMES}):
        parser.error(f"no benchmark is called {', '.join(unknown)}; there are {', '.join(NAMES)}")
    _use_cores(CORES)  # before NumPy counts them
    from rich.console import Console
    from rich.markdown import Markdown
    from rich.progress import Progress

    from benchmarks import pages

    console = Console()
    folder = asked.out or (None if asked.quick else RESULTS)
    for name in asked.names or NAMES:
        with Progress(console=console) as bars:
            result = measured(name, "QUICK" if asked.quick else "FULL", partial(_track, bars))
        console.print(Markdown(pages.section(result)))
        if folder:
            pages.write(name, result, folder)
            console.print(f"written to {folder}")
    if folder == RESULTS:
        for page in DOCS.glob("*.md"):
            page.write_text(pages.with_tables(page.read_text(), RESULTS))


def measured(name: str, size: str, track: Track) -> dict:
    """The result of one benchmark, with its title and the machine."""
    from benchmarks import machine

    benchmark = importlib.import_module(f"benchmarks.{name}")
    title = benchmark.__doc__.splitlines()[0].rstrip(".")
    outcome = benchmark.run(getattr(benchmark, size), track)
    return {"title": title, "machine": machine.describe(), **outcome.as_dict()}


def _track(bars: Progress, items: Sequence[str], what: str) -> Iterable[str]:
    return bars.track(items, description=what)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.add_argument(
        "names", nargs="*", metavar="NAME", help=f"{', '.join(NAMES)}; all of them by default"
    )
    parser.add_argument("--quick", action="store_true", help="small sizes, shown but not written")
    parser.add_argument(
        "--out",
        type=Path,
        metavar="DIR",
        help="folder of the results (default: benchmarks/results)",
    )
    return parser


def _use_cores(number: int) -> None:
    """Restrict this process and its threads to a number of cores, if the system supports it."""
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, sorted(os.sched_getaffinity(0))[:number])


if __name__ == "__main__":
    main()
