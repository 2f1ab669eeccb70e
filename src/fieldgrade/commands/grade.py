"""``fieldrecon grade``: a class graded by one command, and what came of it in a few lines."""

from __future__ import annotations

import argparse
import shlex
import sys
from collections import Counter
from collections.abc import Iterator, Sequence

from fieldgrade.authoring.secret import MISSING
from fieldgrade.checking.results import STATUSES, Record
from fieldgrade.commands.progress import progress
from fieldgrade.grading.items import printable
from fieldgrade.grading.options import declare, run_of
from fieldgrade.grading.run import RESULTS, Run

DESCRIPTION = """Grade what a class handed in: a folder with a folder or a file for each student,
or the zip file that a learning platform makes. What is found is kept in OUT, so that a run that was
interrupted goes on where it stopped, and after a change only what depends on it is made again."""
EPILOG = "The exit status is 0 however bad the answers are; it is 1 if the grader itself failed."
PYTEST = """what else pytest is told, whose output is shown then: "-k ada -x --junit-xml grades.xml
-n 4" """
NEXT = "pages for students: fieldrecon course feedback {out}; grade book: … course export {out}"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of ``fieldrecon grade``."""
    parser.description, parser.epilog = DESCRIPTION, EPILOG
    parser.add_argument("submissions", metavar="DIR", help="what was handed in")
    declare(parser.add_argument)
    parser.add_argument("--diff", action="store_true", help="tell which grades changed, and why")
    parser.add_argument("--pytest", type=shlex.split, default=[], metavar="'...'", help=PYTEST)
    parser.set_defaults(command=grade)


def grade(options: argparse.Namespace) -> int:
    """Grade a class, and return 1 if the grader itself failed.

    Raises
    ------
    ValueError
        There is nothing to be graded, or a table is wrong.
    """
    from fieldgrade.grading.engine import graded

    run, banner = run_of(options)
    _ = run.taken  # what is wrong there is told before anything else
    _say_loudly(banner, "" if run.salt.secret else MISSING)
    try:
        with progress("graded") as told:
            grading = graded(run, told=told, options=options.pytest)
    except KeyboardInterrupt:
        print("what is graded is kept: the same command goes on from here", file=sys.stderr)
        raise
    for fault in grading.findings.faults:
        print(f"fieldrecon: {fault}", file=sys.stderr)
    records = list(grading.findings.records.values())
    results = grading.results.records if grading.results else ()
    for line in _came_out(run, records, len(results) - len(records)):
        print(printable(line))
    _compare(options, grading.changed)
    failed = grading.findings.faults or any(record.status == "fault" for record in records)
    return int(bool(failed))


def _came_out(run: Run, graded: Sequence[Record], earlier: int) -> Iterator[str]:
    """Yield what came out, and where it is."""
    counted = Counter(record.status for record in graded)
    told = ", ".join(f"{counted[status]} {status}" for status in STATUSES if counted[status])
    submissions = "1 submission" if len(graded) == 1 else f"{len(graded)} submissions"
    yield f"{submissions}, walls: {run.tier}; {told or 'nothing was chosen'}"
    for record in graded:
        if record.status in ("unreadable", "fault"):
            yield f"  {record.student}, {record.file}: {'; '.join(record.notes)}"
    yield from (f"  nobody's: {stray}" for stray in run.taken[1])
    if earlier:
        yield f"{earlier} of earlier runs stay as they were"
    yield str(run.out / RESULTS)
    yield NEXT.format(out=run.out)


def _compare(options: argparse.Namespace, changed: bool) -> None:
    """Tell which grades changed, if asked to, and remember what was decided for the next time."""
    from fieldgrade.class_folder.decided import ClassFolder, remember

    file, folder = options.out / RESULTS, ClassFolder(options.tables)
    if options.diff:
        from fieldgrade.commands.gradebook import print_differences
        from fieldgrade.gradebook.differences import compared

        print_differences(compared(file, folder, None if changed else file))
    remember(options.out, folder)


def _say_loudly(*told: str) -> None:
    line = "!" * 72
    for text in filter(None, told):
        print(f"{line}\n{text}\n{line}", file=sys.stderr)
