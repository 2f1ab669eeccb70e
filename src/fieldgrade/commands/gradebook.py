"""``fieldrecon course feedback | export | analysis | …``: what is made from the file of results."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from os import cpu_count
from pathlib import Path
from typing import Any

from fieldgrade.authoring.catalogue import entries
from fieldgrade.class_folder import manual
from fieldgrade.class_folder.csv_tables import to_csv
from fieldgrade.class_folder.decided import MANUAL
from fieldgrade.class_folder.examples import write_examples
from fieldgrade.class_folder.overrides import open_requests
from fieldgrade.gradebook import analysis, differences, exports, similarity
from fieldgrade.gradebook import item_analysis as items
from fieldgrade.gradebook import platforms as platform_forms
from fieldgrade.gradebook import similarity_page as resemblance
from fieldgrade.gradebook.desk import DEFAULT, Desk
from fieldgrade.gradebook.feedback import feedback
from fieldgrade.submissions.submission import Submission, Unreadable
from fieldgrade.submissions.words import words
from fieldrecon.cli.console import print_files, print_table
from fieldrecon.cli.progress import progress

FORMS = {"canvas": platform_forms.canvas_csv, "moodle": platform_forms.moodle_csv}


def add_commands(commands: Any) -> None:
    """Declare the subcommands that begin where grading has ended."""
    _add(commands, "feedback", _feedback, "write a page for each student")
    _add(commands, "export", _export, "write the grade book, and those of the platforms")
    _add(commands, "analysis", _analysis, "tell how the questions did")
    _add(commands, "manual", _manual, "write pages to read words on, and tables for points")
    _add(commands, "report", _report, "write a report on the class, as HTML and PDF")
    _add(commands, "similarity", _similarity, "show answers that resemble each other")
    changed = _add(commands, "differences", _differences, "tell which grades changed, and why")
    changed.add_argument(
        "--before", type=Path, metavar="FILE", help="earlier results (default: last in history/)"
    )
    tables = commands.add_parser("class", help="write the tables of a class, with examples")
    tables.add_argument("folder", type=Path, metavar="DIR")
    tables.set_defaults(command=_class)


def _add(commands: Any, name: str, command: Callable[..., Any], text: str) -> Any:
    parser = commands.add_parser(name, help=text)
    parser.add_argument(
        "results", type=Path, metavar="RESULTS", help="results.json, or the folder that holds it"
    )
    parser.add_argument(
        "--class",
        type=Path,
        metavar="DIR",
        dest="folder",
        help=f"the folder with the tables of the class (default: {DEFAULT}, if it is there)",
    )
    parser.add_argument(
        "--out", type=Path, metavar="DIR", help="where to write (default: beside the results)"
    )
    parser.set_defaults(command=lambda options: command(Desk(options)))
    return parser


def _feedback(desk: Desk) -> None:
    by_student = exports.by_student(desk.sheets)
    make = partial(feedback, titles=desk.titles)
    with ProcessPoolExecutor(cpu_count()) as pool, progress(pool.map, "pages") as each:
        pages = list(each(make, by_student))
    names = [desk.names[sheets[0].student["student"]] for sheets in by_student]
    for name, page in zip(names, pages, strict=True):
        desk.write(f"feedback/{name}.html", page)
    rows = [(s[0].student["student"], f"{n}.html") for s, n in zip(by_student, names, strict=True)]
    print_files([desk.write("feedback/files.csv", to_csv(("student", "file"), rows))])
    print(f"{len(pages)} pages in {desk.out / 'feedback'}")


def _export(desk: Desk) -> None:
    named = desk.decisions.assignments
    files = [desk.write("gradebook.csv", exports.gradebook_csv(desk.sheets))]
    for platform, make in FORMS.items():
        if any(getattr(assignment, platform) for assignment in named.values()):
            files.append(desk.write(f"{platform}.csv", make(desk.sheets, named)))
            for student in platform_forms.left_out(platform, desk.sheets):
                print(f"{student} is not in {platform}.csv: the roster does not tell who that is")
        else:
            print(f"no {platform}.csv: assignments.csv has no name under {platform}")
    for sheet in desk.sheets:
        if sheet.record:
            whose = desk.names[sheet.student["student"]]
            text = platform_forms.gradescope_text(sheet)
            desk.write(f"gradescope/{sheet.notebook}/{whose}/results.json", text)
    print_files([*files, desk.out / "gradescope"])
    waiting = sum(line.how == "open" for sheet in desk.sheets for line in sheet.lines)
    if waiting:
        print(f"{waiting} answers are not graded yet, and count as no points in these files")
    for request in open_requests(desk.folder.requests(), desk.decisions.overrides):
        print(f"open request: {request.student}, {request.question}, {request.on}")


def _analysis(desk: Desk) -> None:
    found = items.items(desk.sheets)
    handed_in = sum(sheet.record is not None for sheet in desk.sheets)
    told = f"{handed_in} notebooks of {len(desk.names)} students"
    page = analysis.analysis_page(found, desk.titles, told)
    print_files(
        [desk.write("analysis.csv", items.to_table(found)), desk.write("analysis.html", page)]
    )


def _manual(desk: Desk) -> None:
    marks = {(mark.question, mark.student): mark for mark in desk.decisions.marks}
    for number, source in desk.sources.items():
        asked = manual.theory(source)
        written = {
            student: words(desk.submission(record), [question.name for question in asked])
            for student, record in desk.records(number).items()
        }
        for question in asked:
            answers = {student: its.get(question.name, "") for student, its in written.items()}
            table = desk.folder.folder / MANUAL / f"{question.name}.csv"
            changed = manual.enter(table, answers)
            for student in changed:
                print(f"{question.name}: {student} wrote something else since it was read")
            given = {who: mark for (name, who), mark in marks.items() if name == question.name}
            page = manual.reading_page(question, answers, given, changed)
            print_files([table, desk.write(f"manual/{question.name}.html", page)])


def _report(desk: Desk) -> None:
    from fieldgrade.gradebook.report import class_report

    sentences = {
        (mistake.question, mistake.name): mistake.sentence
        for source in desk.sources.values()
        for mistake in entries(source, "misconceptions")
    }
    source, out = desk.options.root / "report", desk.out / "report"
    print_files(class_report(desk.results, desk.sheets, desk.titles, sentences, source, out))


def _similarity(desk: Desk) -> None:
    rows: list[tuple[str, similarity.Pair]] = []
    files = []
    for number, title in desk.titles.items():
        codes = list(_codes(desk, number))
        given = similarity.code("", _handed_out(desk, number))
        found = similarity.pairs(codes, given)
        page = resemblance.similarity_page(f"{number} {title}", found, len(codes))
        files.append(desk.write(f"similarity/{number}.html", page))
        rows += [(number, pair) for pair in found]
    print_files([*files, desk.write("similarity/pairs.csv", resemblance.to_table(rows))])


def _codes(desk: Desk, number: str) -> Iterator[similarity.Code]:
    for student, record in desk.records(number).items():
        try:
            yield similarity.code(student, desk.submission(record).cells)
        except Unreadable:
            continue


def _handed_out(desk: Desk, number: str) -> tuple[str, ...]:
    """Return the code cells that everybody was given."""
    name = f"{desk.sources[number].name}.ipynb"
    content = (desk.options.root / "exercises" / name).read_bytes()
    return Submission("", name, content).cells


def _differences(desk: Desk) -> None:
    found = differences.compared(desk.file, desk.folder, desk.options.before)
    print_differences(found)
    print_files([desk.write("differences.csv", differences.to_table(found))])


def print_differences(found: list[differences.Difference]) -> None:
    """Print which grades changed, and why."""
    if not found:
        print("no grade changed")
        return
    rows = [
        (d.student, d.question, _cell(d.before), _cell(d.now), "; ".join(d.reasons)) for d in found
    ]
    print_table(differences.COLUMNS, rows, title="Grades that changed")


def _cell(points: float | None) -> str:
    return "–" if points is None else f"{points:g}"


def _class(options: argparse.Namespace) -> None:
    for file, is_new in write_examples(options.folder):
        print(f"{file}" if is_new else f"{file} was there")
