"""``fieldrecon experiments``: list, show and run the experiments."""

from __future__ import annotations

import argparse
import re
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

from fieldrecon.cli.console import print_table, say
from fieldreport.experiments import get, titles

if TYPE_CHECKING:
    from fieldreport.framework.experiment import Experiment, Map


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the subcommands."""
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    commands.add_parser("list", help="list the experiments").set_defaults(command=_list)
    show = commands.add_parser(
        "show", help="show the description and the parameters of an experiment"
    )
    show.add_argument("name", metavar="NAME")
    show.set_defaults(command=_show)
    run = commands.add_parser("run", help="run an experiment and write its files")
    run.add_argument("name", metavar="NAME")
    run.add_argument(
        "--set", action="append", default=[], metavar="KEY=VALUE", help="replace a parameter"
    )
    run.add_argument("--seed", help="the same as --set seed=SEED")
    run.add_argument("--out", type=Path, default=Path("results"), metavar="DIR")
    run.add_argument(
        "--jobs", type=_positive, default=1, metavar="N", help="number of processes (default: 1)"
    )
    run.set_defaults(command=_run)


def _positive(text: str) -> int:
    if not re.fullmatch(r"0*[1-9]\d*", text):
        raise argparse.ArgumentTypeError(f"must be a positive whole number; got {text!r}")
    return int(text)


def _list(_: argparse.Namespace) -> None:
    print_table(("experiment", "title"), tuple(titles().items()))


def _show(options: argparse.Namespace) -> None:
    _print_experiment(get(options.name))


def _print_experiment(experiment: Experiment) -> None:
    """Print the description and the parameters of an experiment."""
    say(experiment.title)
    print()
    for paragraph in experiment.description.split("\n\n"):
        listed = "\n---" in paragraph
        say(paragraph if listed else " ".join(paragraph.split()))
        print()
    rows = [
        (name, value, experiment.domains[name], experiment.meanings[name])
        for name, value in asdict(experiment.defaults).items()
    ]
    print_table(("parameter", "default", "allowed", "meaning"), rows)
    say(f"Figures: {', '.join(experiment.plots)}")


def _run(options: argparse.Namespace) -> None:
    from fieldrecon.cli.console import print_files
    from fieldrecon.cli.progress import progress
    from fieldreport.framework import result_files as files
    from fieldreport.framework.parameters import replace_parameters

    experiment = get(options.name)
    params = replace_parameters(experiment.defaults, _settings(options.set, options.seed))
    with _pool_map(options.jobs) as pool_map, progress(pool_map, experiment.name) as each:
        result = experiment.run(params, each)
    folder = options.out / experiment.name
    written = files.write_result(result, folder) + files.write_figures(experiment, result, folder)
    for name, table in result.tables.items():
        print_table(
            table.columns, files.mark_orders(table.rows), title=f"{experiment.name}: {name}"
        )
    print_table(("fact", ""), files.mark_orders(tuple(result.facts.items())))
    print_files(written)


def _settings(texts: Sequence[str], seed: str | None) -> dict[str, str]:
    """Return the values by parameter; refuse to set a parameter twice."""
    given = [*map(_setting, texts), *([] if seed is None else [("seed", seed)])]
    for key, count in Counter(key for key, _ in given).items():
        if count > 1:
            values = " and ".join(repr(value) for k, value in given if k == key)
            raise ValueError(f"parameter {key} must be set once; got {values}")
    return dict(given)


def _setting(text: str) -> tuple[str, str]:
    key, equals, value = text.partition("=")
    if not equals:
        raise ValueError(f"--set must be KEY=VALUE; got {text!r}")
    return key.strip(), value


@contextmanager
def _pool_map(jobs: int) -> Iterator[Map]:
    """Yield a map over a number of processes, each with BLAS on one thread."""
    if jobs == 1:
        yield map
        return
    from concurrent.futures import ProcessPoolExecutor

    from threadpoolctl import threadpool_limits

    with ProcessPoolExecutor(jobs, initializer=threadpool_limits, initargs=(1,)) as pool:
        yield pool.map
