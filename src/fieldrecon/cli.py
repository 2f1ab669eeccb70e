"""The command line: experiments, a grid from a file of samples, the report."""

from __future__ import annotations

import argparse
import os
import re
import sys
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from threadpoolctl import threadpool_limits

if TYPE_CHECKING:
    from rich.console import Console

    from fieldrecon.experiments import Map

USER_ERRORS = (ValueError, np.linalg.LinAlgError, OSError, MemoryError, OverflowError, ImportError)
_WIDEST = 7
_MOST_ROWS = 40


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit status: 2 for what the user can put right."""
    options = _parser().parse_args(arguments)
    try:
        options.command(options)
    except KeyboardInterrupt:
        print("fieldrecon: interrupted", file=sys.stderr)
        return 130
    except USER_ERRORS as error:
        if options.traceback:
            raise
        print(f"fieldrecon: {_sentence(error)}", file=sys.stderr)
        return 2
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="fieldrecon", description="Reconstruct a field from scattered samples."
    )
    parser.add_argument(
        "--version", action="version", version=f"fieldrecon {version('fieldrecon')}"
    )
    parser.add_argument("--traceback", action="store_true", help="show where an error came from")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    _add_experiments(commands.add_parser("experiments", help="list, show and run the experiments"))
    _add_reconstruct(
        commands.add_parser(
            "reconstruct",
            help="a grid from a CSV file of samples, and which method fits them",
            description="Put samples on a grid. Each method is judged by leaving out each sample "
            "in turn; nodes outside the convex hull of the samples are marked as extrapolated.",
        )
    )
    return parser


def _add_experiments(parser: argparse.ArgumentParser) -> None:
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    commands.add_parser("list", help="the experiments").set_defaults(command=_list)
    show = commands.add_parser("show", help="what an experiment is, and its parameters")
    show.add_argument("name", metavar="NAME")
    show.set_defaults(command=_show)
    run = commands.add_parser("run", help="run an experiment and write its files")
    run.add_argument("name", metavar="NAME")
    run.add_argument(
        "--set", action="append", default=[], metavar="KEY=VALUE", help="replace a parameter"
    )
    run.add_argument("--seed", help="the same as --set seed=SEED")
    run.add_argument("--out", type=Path, default=Path("results"), metavar="DIR")
    run.add_argument("--jobs", type=_positive, default=1, metavar="N", help="processes (1)")
    run.set_defaults(command=_run)


def _add_reconstruct(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("samples", type=Path, metavar="POINTS.csv", help="a table with a header")
    for name in ("x", "y", "value"):
        parser.add_argument(f"--{name}", metavar="COLUMN", help=f"the column that holds {name}")
    parser.add_argument(
        "--method",
        default="best",
        metavar="NAME",
        help="ls1, ls2, ls4, mls1, mls2, tps, cubic, smooth, or best (the default): "
        "the one that misses left-out samples least",
    )
    parser.add_argument("--grid", type=_shape, default=(200, 200), metavar="NXxNY")
    parser.add_argument("--out", type=Path, default=Path("reconstruction"), metavar="DIR")
    parser.set_defaults(command=_reconstruct)


def _positive(text: str) -> int:
    if not re.fullmatch(r"0*[1-9]\d*", text):
        raise argparse.ArgumentTypeError(f"must be a positive whole number; got {text!r}")
    return int(text)


def _shape(text: str) -> tuple[int, int]:
    sides = re.fullmatch(r"(\d+)x(\d+)", text.lower())
    if sides is None or min(columns_rows := (int(sides[1]), int(sides[2]))) < 2:
        raise argparse.ArgumentTypeError(f"must be such as 200x150, each 2 or more; got {text!r}")
    return columns_rows


def _list(_: argparse.Namespace) -> None:
    from fieldrecon.experiments import get, names

    _print_table(("experiment", "what it is about"), [(name, get(name).title) for name in names()])


def _show(options: argparse.Namespace) -> None:
    from dataclasses import asdict

    from fieldrecon.experiments import get

    experiment = get(options.name)
    console = _console()
    console.print(f"{experiment.title}\n", style="bold", highlight=False)
    for paragraph in experiment.description.split("\n\n"):
        text = paragraph if "\n---" in paragraph else " ".join(paragraph.split())
        console.print(f"{text}\n", highlight=False, markup=False)
    rows = [
        (name, _typed(value), experiment.meanings[name])
        for name, value in asdict(experiment.defaults).items()
    ]
    _print_table(("parameter", "default", "what it is"), rows)
    console.print(f"Figures: {', '.join(experiment.plots)}")


def _run(options: argparse.Namespace) -> None:
    from fieldrecon.experiments import files, get
    from fieldrecon.experiments.settings import with_settings

    experiment = get(options.name)
    settings = dict(map(_setting, options.set)) | ({"seed": options.seed} if options.seed else {})
    params = with_settings(experiment.defaults, settings)
    with _pool_map(options.jobs) as pool_map, _progress(pool_map, experiment.name) as each:
        result = experiment.run(params, each)
    for name, table in result.tables.items():
        _print_table(table.columns, table.rows, title=f"{experiment.name}: {name}")
    _print_table(("fact", ""), tuple(result.facts.items()))
    folder = options.out / experiment.name
    _print_files(
        [*files.write_result(result, folder), *files.write_figures(experiment, result, folder)]
    )


def _setting(text: str) -> tuple[str, str]:
    key, equals, value = text.partition("=")
    if not equals:
        raise ValueError(f"--set wants KEY=VALUE; got {text!r}")
    return key.strip(), value


def _reconstruct(options: argparse.Namespace) -> None:
    from fieldrecon.gridding import CANDIDATES, Grid, best, cross_validate, grid_over, nodes_of
    from fieldrecon.reporting.gridding import METHOD_COLUMNS, method_rows, write_reconstruction
    from fieldrecon.samples import read_samples

    if options.method not in {"best", *CANDIDATES}:
        raise ValueError(
            f"there is no method {options.method!r}; there are best, {', '.join(CANDIDATES)}"
        )
    samples = read_samples(options.samples, options.x, options.y, options.value)
    points, values = samples.points, samples.values

    def trial(candidate: Any) -> Any:
        asked_for = {"limit": len(points)} if candidate.name == options.method else {}
        return cross_validate(candidate, points, values, **asked_for)

    with _progress(map, "leaving out each sample") as each:
        trials = list(each(trial, CANDIDATES.values()))
    chosen = best([t for t in trials if options.method in ("best", t.candidate.name)])
    x, y, outside = grid_over(points, *options.grid)
    field = chosen.candidate.at_sites(points, values).field(values)
    grid = Grid(x, y, field(nodes_of(x, y)).reshape(outside.shape), outside)
    title = f"{samples.names[2]} at {len(points)} points: error when each is left out"
    _print_table(METHOD_COLUMNS, tuple(method_rows(trials)), title=title)
    say = _console().print
    if samples.merged:
        say(f"{samples.merged} rows repeat a point; it bears the mean of its values.")
    say(f"Drawn by {chosen.candidate.name}, {chosen.candidate.meaning}.")
    say(
        f"{outside.mean():.0%} of the grid lies outside the convex hull of the samples: "
        "extrapolated, marked in every file."
    )
    _print_files(write_reconstruction(options.out, samples, grid, trials, chosen))


@contextmanager
def _pool_map(jobs: int) -> Iterator[Map]:
    """Give a map over so many processes, each with BLAS on one thread."""
    if jobs == 1:
        yield map
        return
    with ProcessPoolExecutor(jobs, initializer=threadpool_limits, initargs=(1,)) as pool:
        yield pool.map


@contextmanager
def _progress(mapping: Map, label: str) -> Iterator[Map]:
    """Give the map with a bar that tells, on a terminal, how many of its items are done."""
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TimeElapsedColumn

    columns = ("{task.description}", BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with Progress(*columns, console=_console(stderr=True), transient=True) as bar:

        def each(function: Any, items: Iterable[Any]) -> Iterator[Any]:
            items = list(items)
            task = bar.add_task(label, total=len(items))
            for done in mapping(function, items):
                bar.advance(task)
                yield done

        yield each


def _print_table(columns: Sequence[str], rows: Sequence[Sequence[Any]], title: str = "") -> None:
    """Print a table; one with many columns lies on its side, so that it fits a terminal."""
    from rich.table import Table

    texts = [list(columns), *([_typed(cell) for cell in row] for row in rows)]
    if len(columns) > _WIDEST >= len(rows) or len(columns) > 2 * _WIDEST:
        texts = [list(column) for column in zip(*texts, strict=True)]
    table = Table(*texts[0], title=title or None, title_justify="left")
    for row in texts[1 : 1 + _MOST_ROWS]:
        table.add_row(*row)
    _console().print(table)
    if len(texts) - 1 > _MOST_ROWS:
        _console().print(f"… and {len(texts) - 1 - _MOST_ROWS} rows more, in the file")


def _typed(cell: Any) -> str:
    """Spell a value for the terminal; a list as it would be typed."""
    if isinstance(cell, float):
        return f"{cell:.4g}"
    return ",".join(map(_typed, cell)) if isinstance(cell, list | tuple) else str(cell)


def _print_files(paths: Iterable[Path]) -> None:
    for path in paths:
        print(path)


def _console(stderr: bool = False) -> Console:
    from rich.console import Console

    return Console(stderr=stderr)


def _sentence(error: Exception) -> str:
    if isinstance(error, ModuleNotFoundError) and error.name:
        return f"{error.name} is not installed; pip install 'fieldrecon[report]'"
    if isinstance(error, OSError) and error.strerror:
        return f"{error.filename}: {error.strerror.lower()}" if error.filename else error.strerror
    return " ".join(str(error).split()) or type(error).__name__


if __name__ == "__main__":
    # A pipe that is closed early, as by head, is no error.
    try:
        sys.exit(main())
    except BrokenPipeError:
        os._exit(0)
