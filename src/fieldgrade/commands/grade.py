"""``fieldrecon grade``: grade a class with one command, and print a summary.

This module imports little, so that a run with nothing to do takes no longer than comparing files.
"""

from __future__ import annotations

import argparse
import shlex

from fieldgrade.grading import FOR_WORKERS
from fieldgrade.grading.options import declare
from fieldgrade.grading.unchanged import (
    inputs_digest,
    keep_report,
    last_report,
    print_warnings,
)
from fieldrecon._core.worker_processes import prepare

DESCRIPTION = """Grade the submissions of a class: a folder with a folder or a file for each
student, or the zip file that a learning platform makes. Results are kept in OUT: an interrupted run
continues where it stopped, and after a change only the affected checks run again."""
EPILOG = """Exit status: 0, every submission was graded, however bad the answers are; 1, the grader
itself failed, and the same command grades what is left; 2, the options, tables or submissions are
wrong; 3, grading is complete, and some submissions need your eyes: they are printed, and listed in
OUT/needs-your-eyes.html."""
PYTEST = """further options of pytest, whose output is then shown: "-k ada -x --junit-xml grades.xml
-n 4" """
FAILED = 1


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of ``fieldrecon grade``."""
    parser.description, parser.epilog = DESCRIPTION, EPILOG
    parser.add_argument("submissions", metavar="DIR", help="the folder or zip file to be graded")
    declare(parser.add_argument)
    parser.add_argument("--diff", action="store_true", help="report which grades changed, and why")
    parser.add_argument("--pytest", type=shlex.split, default=[], metavar="'...'", help=PYTEST)
    parser.set_defaults(command=grade)


def grade(options: argparse.Namespace) -> int:
    """Grade a class, and return the exit status.

    Raises
    ------
    ValueError
        There is nothing to be graded, or a table is wrong.
    """
    inputs = inputs_digest(options)
    if report := last_report(options.out, inputs):
        print_warnings(report.warnings)
        print(*report.lines, sep="\n")
        return report.status
    prepare(FOR_WORKERS)
    from fieldgrade.commands.grade_report import graded

    report = graded(options)
    if report.status != FAILED:
        keep_report(options.out, inputs, report)
    return report.status
