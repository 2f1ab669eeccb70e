"""``fieldrecon course``: build the notebooks, test the graders, make the bundle for students."""

from __future__ import annotations

import argparse
import sys
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from datetime import date
from functools import partial, reduce
from itertools import chain
from operator import or_
from os import cpu_count
from pathlib import Path

from fieldgrade.authoring import build as building
from fieldgrade.authoring.bundle import write_bundle
from fieldgrade.authoring.minutes import suggested_minutes
from fieldgrade.authoring.outline import Outline, minutes
from fieldgrade.authoring.publish import publish
from fieldgrade.authoring.secret_salt import FILE as SALT_FILE
from fieldgrade.authoring.secret_salt import MISSING, make_salt, read_salt
from fieldgrade.authoring.sources import Source
from fieldgrade.class_folder.example import write_example_class
from fieldgrade.class_folder.self_assessment import write_self_assessment
from fieldgrade.commands.gradebook import add_commands as add_gradebook
from fieldgrade.grader_validation.blas_kernels import (
    NO_CHOICE,
    JudgeRequest,
    KernelRun,
    Setting,
    has_choice_of_kernels,
    not_as_chosen,
    run,
    settings,
)
from fieldgrade.grader_validation.known_verdicts import GraderReport, grader_reports
from fieldgrade.grader_validation.rounding_errors import (
    Baseline,
    Changes,
    changes,
    changes_of_draws,
    rounding_test,
)
from fieldrecon.cli.console import print_files, print_table
from fieldrecon.cli.progress import progress


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the subcommands of ``fieldrecon course``."""
    parser.add_argument(
        "--root", type=Path, default=Path(), metavar="DIR", help="the checkout (default: here)"
    )
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    build = commands.add_parser("build", help="write the notebooks of students and solutions")
    build.set_defaults(command=_build)
    times = commands.add_parser("minutes", help="compare the minutes of each question with a rule")
    times.set_defaults(command=_minutes)
    check = commands.add_parser("check", help="test the graders")
    check.set_defaults(command=_check)
    check.add_argument("--question", default="", metavar="02.3", help="only this question")
    pages = commands.add_parser("publish", help="write the solved notebooks as HTML and PDF")
    pages.add_argument("--out", type=Path, default=Path("dist/solutions"), metavar="DIR")
    pages.set_defaults(command=_publish)
    rubrics = commands.add_parser(
        "self-assessment", help="write model answers with rubrics, to be released to students"
    )
    rubrics.add_argument("--out", type=Path, default=Path("dist/self-assessment"), metavar="DIR")
    rubrics.set_defaults(command=_self_assessment)
    for command in (build, times, check, pages, rubrics):
        command.add_argument("--only", nargs="+", default=[], metavar="02", help="these notebooks")
    init = commands.add_parser("init", help="create the secret salt, .course-secret.json")
    init.add_argument("--renew", action="store_true", help="replace it, for a new year")
    init.set_defaults(command=_init)
    bundle = commands.add_parser("bundle", help="write the zip file for students")
    bundle.add_argument("--out", type=Path, default=Path("dist/student-bundle.zip"), metavar="FILE")
    bundle.set_defaults(command=_bundle)
    example = commands.add_parser("example", help="write an example class of five, to try grading")
    example.add_argument("folder", type=Path, metavar="DIR", help="a new or an empty folder")
    example.set_defaults(command=_example)
    add_gradebook(commands)


def _build(options: argparse.Namespace) -> None:
    chosen = _chosen(options)
    with ThreadPoolExecutor(cpu_count()) as pool, progress(pool.map, "notebooks") as each:
        building.build(options.root, chosen, each)
    print(f"{len(chosen)} notebooks are up to date, for students and solved")


def _minutes(options: argparse.Namespace) -> None:
    """Print the declared and the suggested minutes of each question, with sums."""
    for source in _chosen(options):
        outline = Outline(source)
        suggested = suggested_minutes(outline)
        parts = (("core", outline.core), ("optional", outline.optional))
        rows: list[tuple[object, ...]] = [
            (name, item.question, item.minutes, suggested[item.question])
            for name, items in parts
            for item in items
        ]
        rows += [
            (name, "all", minutes(items), sum(suggested[item.question] for item in items))
            for name, items in parts
            if items
        ]
        heads = ("part", "question", "minutes", "suggested")
        print_table(heads, rows, title=source.name, whole=True)


def _check(options: argparse.Namespace) -> int:
    salt = read_salt(options.root)
    _print_banner(salt.secret)
    sources = _chosen(options, options.question[:2])
    todo = partial(_checked, salt=salt.text, only=options.question)
    # the last notebooks take longest
    with ProcessPoolExecutor(cpu_count()) as pool, progress(pool.map, "graders") as each:
        parts, baselines, changed = zip(*each(todo, sources[::-1]), strict=True)
    reports: list[GraderReport] = list(chain.from_iterable(parts[::-1]))
    baseline: Baseline = reduce(or_, baselines)
    runs = _runs(JudgeRequest(tuple(sources), salt.text, options.question, baseline.known))
    verdicts = ((f"with {setting.name}", found.verdicts) for setting, found in runs)
    for changes_of_its in (*changed, changes(baseline.verdicts, verdicts)):
        reports = [p.with_problems(changes_of_its.get(p.question, ())) for p in reports]
    print_table(
        ("question", "mistakes", "other right answers", "mutants", "caught", "problems"),
        [
            (p.question, p.mistakes, p.alternatives, p.mutants, p.caught, len(p.problems))
            for p in reports
        ],
        title="Verdicts of the graders on answers with known verdicts",
        whole=True,
    )
    for report in reports:
        for problem in report.problems:
            print(f"{report.question}: {problem}", file=sys.stderr)
    alike = list(not_as_chosen(runs))
    print(*alike, sep="\n", end="\n" * bool(alike), file=sys.stderr)
    return int(any(report.problems for report in reports) or not reports or bool(alike))


def _checked(source: Source, salt: str, only: str) -> tuple[list[GraderReport], Baseline, Changes]:
    found = rounding_test(source, salt, only)
    baseline = found.baseline()
    return list(grader_reports(source, salt, only)), baseline, changes_of_draws(found, baseline)


def _runs(request: JudgeRequest) -> list[tuple[Setting, KernelRun]]:
    """Judge all answers in each setting, and print the kernels of each process."""
    chosen = settings()
    with ThreadPoolExecutor(cpu_count()) as pool, progress(pool.map, "kernels") as each:
        runs = list(zip(chosen, each(partial(run, request=request), chosen), strict=True))
    for setting, found in runs:
        print(f"With {setting.name}: {found}.")
    if not has_choice_of_kernels():
        print(NO_CHOICE)
    return runs


def _init(options: argparse.Namespace) -> None:
    salt = make_salt(options.root, date.today().year, options.renew)
    file = options.root / SALT_FILE
    print(
        f"{file}: the secret salt of {salt.year}; back it up, since regrading needs it, and "
        "never commit it"
    )


def _bundle(options: argparse.Namespace) -> None:
    for problem in building.leaks(options.root, read_salt(options.root).text):
        raise ValueError(f"files for students would contain solutions: {problem}")
    print(write_bundle(options.root, options.out))


def _example(options: argparse.Namespace) -> None:
    submissions, tables = write_example_class(options.folder)
    print(f"{submissions}: what five students submitted\n{tables}: the tables of their class")
    out = options.folder / "graded"
    print(f"next: fieldrecon grade {submissions} --class {tables} --out {out}")


def _publish(options: argparse.Namespace) -> None:
    todo = partial(_pages, root=options.root, out=options.out)
    with ThreadPoolExecutor(cpu_count()) as pool, progress(pool.map, "pages") as each:
        print_files(chain.from_iterable(each(todo, _chosen(options))))


def _self_assessment(options: argparse.Namespace) -> None:
    print_files(
        chain.from_iterable(
            write_self_assessment(source, options.out) for source in _chosen(options)
        )
    )


def _pages(source: Source, root: Path, out: Path) -> list[Path]:
    return list(publish(root, source, out))


def _print_banner(secret: bool) -> None:
    if not secret:
        line = "!" * 72
        print(f"{line}\n{MISSING}\n{line}", file=sys.stderr)


def _chosen(options: argparse.Namespace, number: str = "") -> list[Source]:
    wanted = options.only or ([number] if number else [])
    found = building.all_sources(options.root)
    unknown = set(wanted) - {source.number for source in found}
    if unknown:
        raise ValueError(f"there is no notebook {', '.join(sorted(unknown))}")
    chosen = [source for source in found if not wanted or source.number in wanted]
    for source in chosen:
        building.require_questions(source)
    return chosen
