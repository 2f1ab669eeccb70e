"""The options of grading, for pytest and for the command line."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fieldgrade.isolation.memory import fitting_jobs
from fieldgrade.isolation.server import TIERS, Limits
from fieldrecon._core.worker_processes import available_cores

if TYPE_CHECKING:
    from fieldgrade.grading.run import GradingRun

TABLES = Path("class")


def jobs(text: str) -> int:
    """Return the number of concurrent submissions, from an option."""
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"must be a positive whole number; got {text!r}")
    return int(text)


def declare(add: Callable[..., Any]) -> None:
    """Declare the options with a function that adds one."""
    add(
        "--out",
        type=Path,
        default=Path("graded"),
        metavar="OUT",
        help="where the results go; earlier results there are reused (default: graded)",
    )
    add(
        "--class",
        type=Path,
        dest="tables",
        default=TABLES,
        metavar="CLASS",
        help="the folder "
        "with roster.csv and the other tables, and your own checks in checks/test_*.py; "
        "each is optional (default: class)",
    )
    add("--root", type=Path, default=Path(), metavar="ROOT", help="the checkout (default: here)")
    add("--only", nargs="+", default=[], metavar="02", help="grade these notebooks")
    add("--question", default="", metavar="02.3", help="grade this question")
    add("--student", default="", metavar="NAME", help="grade this student")
    add(
        "--jobs",
        type=jobs,
        default=available_cores(),
        metavar="N",
        help="submissions at once (default: one for each core)",
    )
    add("--tier", choices=TIERS, default="", help="the sandbox (default: the best that works)")
    add("--require-isolation", action="store_true", help="refuse to grade without a sandbox")


def run_of(options: argparse.Namespace) -> tuple[GradingRun, str]:
    """Return the run that the options describe, and warnings: no sandbox, or little memory.

    Raises
    ------
    ValueError
        The options contradict each other, or the tier does not work on this machine.
    """
    from fieldgrade.grading.run import Choice, GradingRun, chosen_tier

    if options.question and options.only and options.question[:2] not in options.only:
        raise ValueError(f"question {options.question} is not in {', '.join(options.only)}")
    tables = options.tables if options.tables.is_dir() else None
    if tables is None and options.tables != TABLES:
        raise ValueError(f"{options.tables} is not a folder with the tables of a class")
    tier, banner = chosen_tier(options.tier, options.require_isolation)
    workers, memory = fitting_jobs(options.jobs, Limits())
    choice = Choice(frozenset(options.only), options.question, options.student)
    run = GradingRun(
        Path(options.submissions),
        options.out,
        options.root,
        tables,
        tier,
        workers,
        choice,
    )
    return run, "\n".join(filter(None, (banner, memory)))
