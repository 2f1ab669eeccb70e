"""``fieldrecon grade``: grade a class with one command, and print a summary."""

from __future__ import annotations

import argparse
import shlex
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager

from fieldgrade.authoring.secret_salt import MISSING
from fieldgrade.checking.results import STATUSES, Record
from fieldgrade.grading.options import declare, run_of
from fieldgrade.grading.pytest_items import printable
from fieldgrade.grading.run import RESULTS, GradingRun
from fieldrecon.cli.progress import Stage, StatusLine, in_words

DESCRIPTION = """Grade the submissions of a class: a folder with a folder or a file for each
student, or the zip file that a learning platform makes. Results are kept in OUT: an interrupted run
continues where it stopped, and after a change only the affected checks run again."""
EPILOG = "The exit status is 0 however bad the answers are; it is 1 if the grader itself failed."
PYTEST = """further options of pytest, whose output is then shown: "-k ada -x --junit-xml grades.xml
-n 4" """
NEXT = "pages for students: fieldrecon course feedback {out}; gradebook: … course export {out}"
SECONDS_BETWEEN_LINES = 10.0


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of ``fieldrecon grade``."""
    parser.description, parser.epilog = DESCRIPTION, EPILOG
    parser.add_argument("submissions", metavar="DIR", help="the folder or zip file to be graded")
    declare(parser.add_argument)
    parser.add_argument("--diff", action="store_true", help="report which grades changed, and why")
    parser.add_argument("--pytest", type=shlex.split, default=[], metavar="'...'", help=PYTEST)
    parser.set_defaults(command=grade)


def grade(options: argparse.Namespace) -> int:
    """Grade a class, and return 1 if the grader itself failed.

    Raises
    ------
    ValueError
        There is nothing to be graded, or a table is wrong.
    """
    from fieldgrade.grading.grade_class import grade_class

    run, banner = run_of(options)
    _ = run.taken  # errors in tables and submissions are reported first
    _print_banners(banner, "" if run.salt.secret else MISSING)
    try:
        with _progress("graded") as progress:
            grading = grade_class(run, progress=progress, options=options.pytest)
    except KeyboardInterrupt:
        print("what is graded is kept: the same command continues from here", file=sys.stderr)
        raise
    for fault in grading.collector.faults:
        print(f"fieldrecon: {fault}", file=sys.stderr)
    records = list(grading.collector.records.values())
    results = grading.results.records if grading.results else ()
    for line in _summary(run, records, len(results) - len(records)):
        print(printable(line))
    _compare(options, grading.changed)
    failed = grading.collector.faults or any(record.status == "fault" for record in records)
    return int(bool(failed))


@contextmanager
def _progress(label: str) -> Iterator[Callable[[int, int], None]]:
    """Give a function of (done, total): a bar on a terminal, else a line every ten seconds."""
    with StatusLine() as line:
        yield Stage(line, label) if line.on_terminal else _lines(line, label)


def _lines(line: StatusLine, label: str) -> Callable[[int, int], None]:
    started = last = time.monotonic()

    def progress(done: int, total: int) -> None:
        nonlocal last
        now = time.monotonic()
        if now - last >= SECONDS_BETWEEN_LINES:
            last = now
            left = (now - started) * (total - done) / done
            line.say(f"{label} {done} of {total}, about {in_words(left)} left")

    return progress


def _summary(run: GradingRun, graded: Sequence[Record], earlier: int) -> Iterator[str]:
    """Yield how many submissions have each status, the problems, and where the results are."""
    counted = Counter(record.status for record in graded)
    statuses = ", ".join(f"{counted[status]} {status}" for status in STATUSES if counted[status])
    submissions = "1 submission" if len(graded) == 1 else f"{len(graded)} submissions"
    yield f"{submissions}, sandbox: {run.tier}; {statuses or 'nothing was selected'}"
    for record in graded:
        if record.status in ("unreadable", "fault"):
            yield f"  {record.student}, {record.file}: {'; '.join(record.notes)}"
    yield from (f"  belongs to no student: {stray}" for stray in run.taken[1])
    if earlier:
        yield f"{earlier} submissions of earlier runs are unchanged"
    yield str(run.out / RESULTS)
    yield NEXT.format(out=run.out)


def _compare(options: argparse.Namespace, changed: bool) -> None:
    """Print which grades changed, if requested, and save the decisions for the next time."""
    from fieldgrade.class_folder.decisions import ClassFolder, save_decisions

    file, folder = options.out / RESULTS, ClassFolder(options.tables)
    if options.diff:
        from fieldgrade.commands.gradebook import print_differences
        from fieldgrade.gradebook.differences import compared

        print_differences(compared(file, folder, None if changed else file))
    save_decisions(options.out, folder)


def _print_banners(*texts: str) -> None:
    line = "!" * 72
    for text in filter(None, texts):
        print(f"{line}\n{text}\n{line}", file=sys.stderr)
