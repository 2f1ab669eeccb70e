"""Grade a class, and print what needs the instructor's eyes and a summary."""

from __future__ import annotations

import argparse
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

from fieldgrade.authoring.secret_salt import MISSING
from fieldgrade.checking.results import STATUSES, Record, Results
from fieldgrade.class_folder.decisions import ClassFolder, Decisions, save_decisions
from fieldgrade.class_folder.dismissals import Dismissal
from fieldgrade.gradebook.attention import (
    FILE,
    Concern,
    attention_csv,
    attention_page,
    concerns,
    in_lines,
    without_dismissed,
)
from fieldgrade.gradebook.grade_sheets import counted_notebooks
from fieldgrade.grading.options import TABLES, run_of
from fieldgrade.grading.pytest_items import printable
from fieldgrade.grading.run import RESULTS, GradingRun
from fieldgrade.grading.unchanged import Report, print_warnings
from fieldrecon._core.atomic_files import write_if_changed
from fieldrecon.cli.progress import Stage, StatusLine, in_words

NEEDS_EYES = 3
FAILED = """The grader failed; the messages above name the cause. Remove it, and run the same
command again: what is graded is kept."""
NEXT = "pages for students: fieldrecon course feedback {these}; gradebook: … course export {these}"
SECONDS_BETWEEN_LINES = 10.0


def graded(options: argparse.Namespace) -> Report:
    """Grade a class, print a report, and return it.

    Raises
    ------
    ValueError
        There is nothing to be graded, or a table is wrong.
    """
    from fieldgrade.grading.grade_class import grade_class

    run, banner = run_of(options)
    _ = run.taken  # errors in tables and submissions are reported first
    folder = ClassFolder(options.tables)
    decisions, dismissals = folder.decisions(), folder.dismissals()
    warnings = tuple(filter(None, (banner, "" if run.salt.secret else MISSING)))
    print_warnings(warnings)
    try:
        with _progress("graded") as progress:
            grading = grade_class(run, progress=progress, options=options.pytest)
    except KeyboardInterrupt:
        print("what is graded is kept: the same command continues from here", file=sys.stderr)
        raise
    for failure in grading.collector.failures:
        print(f"fieldrecon: {failure}", file=sys.stderr)
    records = list(grading.collector.records.values())
    results = grading.results or run.results(())
    found, dismissed = _concerns(run, results, decisions, dismissals)
    earlier = len(results.records) - len(records)
    listed = in_lines(found, str(run.out / f"{FILE}.html"), dismissed)
    printed = (*listed, *_summary(run, records, earlier))
    lines = tuple(map(printable, printed))
    print(*lines, sep="\n")
    _compare(options, grading.changed)
    if grading.collector.failures or any(record.status == "grader failed" for record in records):
        print(f"fieldrecon: {' '.join(FAILED.split())}", file=sys.stderr)
        return Report(1, lines, warnings)
    status = NEEDS_EYES if any(concern.needs_decision for concern in found) else 0
    return Report(status, lines, warnings)


def _concerns(
    run: GradingRun,
    results: Results,
    decisions: Decisions,
    dismissals: Mapping[str, Dismissal],
) -> tuple[list[Concern], int]:
    """Write what needs the instructor's eyes; return it, and how many entries are dismissed."""
    counted = counted_notebooks(results, decisions)
    found, dismissed = without_dismissed(concerns(results, counted, run.taken[1]), dismissals)
    shown = attention_page(found, dismissed, dismissals)
    for suffix, text in (("html", shown), ("csv", attention_csv(found))):
        write_if_changed(run.out / f"{FILE}.{suffix}", text.encode("utf-8", "replace"))
    return found, len(dismissed)


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
    yield f"{_counted(len(graded))}, sandbox: {run.tier}; {statuses or 'nothing was selected'}"
    for record in graded:
        if record.status in ("unreadable", "grader failed"):
            yield f"  {record.student}, {record.file}: {'; '.join(record.notes)}"
    yield from (f"  belongs to no student: {stray}" for stray in run.taken[1])
    if earlier > 0:  # not if options of pytest left out a check of every question
        yield f"{_counted(earlier)} of earlier runs {'is' if earlier == 1 else 'are'} unchanged"
    yield str(run.out / RESULTS)
    yield NEXT.format(these=f"{run.out} --class {run.tables}" if _is_named(run.tables) else run.out)


def _is_named(tables: Path | None) -> bool:
    """Whether the other commands find the tables of the class only by an option."""
    return tables not in (None, TABLES)


def _counted(submissions: int) -> str:
    return "1 submission" if submissions == 1 else f"{submissions} submissions"


def _compare(options: argparse.Namespace, changed: bool) -> None:
    """Print which grades changed, if requested, and save the decisions for the next time."""
    file, folder = options.out / RESULTS, ClassFolder(options.tables)
    if options.diff:
        from fieldgrade.commands.gradebook import print_differences
        from fieldgrade.gradebook.differences import compared

        print_differences(compared(file, folder, None if changed else file))
    save_decisions(options.out, folder)
