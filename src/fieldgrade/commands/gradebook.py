"""``fieldrecon course feedback | export | analysis | …``: pages and tables made from results."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from os import cpu_count
from pathlib import Path
from typing import Any

from fieldgrade.authoring.catalogue import entries
from fieldgrade.class_folder.csv_tables import to_csv
from fieldgrade.class_folder.decisions import MANUAL
from fieldgrade.class_folder.example_tables import write_examples
from fieldgrade.class_folder.manual_grading import marking_page, update_table, written_questions
from fieldgrade.class_folder.overrides import open_requests
from fieldgrade.class_folder.private import keep_out_of_git
from fieldgrade.gradebook import (
    differences,
    exports,
    item_analysis,
    moodle_worksheet,
    similarity,
)
from fieldgrade.gradebook.attention import FILE
from fieldgrade.gradebook.feedback import feedback
from fieldgrade.gradebook.grade_sheets import by_student
from fieldgrade.gradebook.graded_class import DEFAULT_FOLDER, GradedClass
from fieldgrade.submissions.submission import Submission
from fieldgrade.submissions.written_answers import written_answers
from fieldrecon._core.atomic_files import write_atomically
from fieldrecon.cli.console import print_files, print_table
from fieldrecon.cli.progress import progress

PLATFORMS = {"canvas": exports.canvas_csv, "moodle": exports.moodle_csv}


def add_commands(commands: Any) -> None:
    """Declare the subcommands that work on results."""
    _add(commands, "feedback", _feedback, "write a page for each student")
    _add(commands, "export", _export, "write the gradebook, and the files that platforms import")
    _add(commands, "analysis", _analysis, "write statistics of the questions")
    _add(commands, "manual", _manual, "write the written answers as pages, and tables for points")
    _add(commands, "report", _report, "write a report on the class, as HTML and PDF")
    _add(commands, "similarity", _similarity, "show similar answers")
    changed = _add(commands, "differences", _differences, "report which grades changed, and why")
    changed.add_argument(
        "--before", type=Path, metavar="FILE", help="earlier results (default: last in history/)"
    )
    tables = commands.add_parser("class", help="write the tables of a class, with examples")
    tables.add_argument("folder", type=Path, metavar="DIR")
    tables.set_defaults(command=_class)


def _add(commands: Any, name: str, command: Callable[..., Any], text: str) -> Any:
    parser = commands.add_parser(name, help=text)
    parser.add_argument(
        "results", type=Path, metavar="RESULTS", help="results.json, or the folder with it"
    )
    parser.add_argument(
        "--class",
        type=Path,
        metavar="DIR",
        dest="folder",
        help=f"the folder with the tables of the class (default: {DEFAULT_FOLDER}, if it exists)",
    )
    parser.add_argument(
        "--out", type=Path, metavar="DIR", help="where to write (default: beside the results)"
    )
    parser.set_defaults(command=lambda options: command(_graded(options), options))
    return parser


def _graded(options: argparse.Namespace) -> GradedClass:
    graded = GradedClass(options.results, options.folder, options.out, options.root)
    if graded.file.is_file():
        keep_out_of_git(graded.out)
    return graded


def _feedback(graded: GradedClass, _: argparse.Namespace) -> None:
    rows = by_student(graded.sheets)
    make = partial(feedback, titles=graded.titles)
    with ProcessPoolExecutor(cpu_count()) as pool, progress(pool.map, "pages") as each:
        pages = list(each(make, rows))
    students = [sheets[0].student["student"] for sheets in rows]
    for student, page in zip(students, pages, strict=True):
        graded.write(f"feedback/{graded.names[student]}.html", page)
    files = [(student, f"{graded.names[student]}.html") for student in students]
    print_files([graded.write("feedback/files.csv", to_csv(("student", "file"), files))])
    print(f"{len(pages)} pages in {graded.out / 'feedback'}")


def _export(graded: GradedClass, _: argparse.Namespace) -> None:
    named = graded.decisions.assignments
    files = [graded.write("gradebook.csv", exports.gradebook_csv(graded.sheets))]
    for platform, make in PLATFORMS.items():
        if any(getattr(assignment, platform) for assignment in named.values()):
            files.append(graded.write(f"{platform}.csv", make(graded.sheets, named)))
            for student in exports.left_out(platform, graded.sheets):
                print(f"{student} is not in {platform}.csv: the roster does not identify them")
        else:
            print(f"no {platform}.csv: column {platform} of assignments.csv is empty")
    print_files([*files, *_worksheets(graded), *_gradescope(graded)])
    waiting = sum(sheet.waiting for sheet in graded.sheets)
    if waiting:
        print(f"{waiting} answers are not graded yet, and count as no points in these files")
    for sheet in graded.sheets:
        if sheet.record and not sheet.has_grade:
            who = sheet.student["student"]
            print(f"{who}, notebook {sheet.notebook}: no grade in these files: the grader failed")
    for request in open_requests(graded.folder.requests(), graded.decisions.overrides):
        print(f"open request: {request.student}, {request.question}, {request.on}")


def _worksheets(graded: GradedClass) -> Iterator[Path]:
    """Fill in the worksheets of Moodle, and pack the pages of the students; yield the files."""
    pages = {who: graded.out / f"feedback/{name}.html" for who, name in graded.names.items()}
    for file in sorted((graded.folder.folder / moodle_worksheet.FOLDER).glob("[0-9][0-9].csv")):
        sheets = [sheet for sheet in graded.sheets if sheet.notebook == file.stem]
        participants = moodle_worksheet.read_worksheet(file, sheets)
        for student, why in moodle_worksheet.problems(participants, sheets):
            print(f"Moodle will not get the grade of {student} for {file.stem}: {why}")
        text = moodle_worksheet.worksheet_csv(participants)
        yield graded.write(f"{moodle_worksheet.FOLDER}/{file.name}", text)
        packed = moodle_worksheet.feedback_zip(participants, pages)
        place = graded.out / f"{moodle_worksheet.FOLDER}/{file.stem}-feedback.zip"
        yield write_atomically(place, packed)


def _gradescope(graded: GradedClass) -> Iterator[Path]:
    """Write a result for each submission, and an autograder for each notebook; yield these."""
    for sheet in graded.sheets:
        if sheet.has_grade:
            whose = graded.names[sheet.student["student"]]
            text = exports.gradescope_text(sheet)
            graded.write(f"gradescope/{sheet.notebook}/{whose}/results.json", text)
    without = exports.left_out("gradescope", graded.sheets)
    if len(without) == len(graded.names):
        print("no autograder for Gradescope: the roster has no e-mail addresses")
        return
    for student in without:
        print(f"{student} is not in the autograder for Gradescope: the roster has no address")
    for notebook in dict.fromkeys(sheet.notebook for sheet in graded.sheets):
        packed = exports.gradescope_zip(s for s in graded.sheets if s.notebook == notebook)
        yield write_atomically(graded.out / f"gradescope/{notebook}.zip", packed)


def _analysis(graded: GradedClass, _: argparse.Namespace) -> None:
    found = item_analysis.items(graded.sheets)
    submitted = sum(sheet.record is not None for sheet in graded.sheets)
    subtitle = f"{submitted} notebooks of {len(graded.names)} students"
    attention = f"{FILE}.html" if (graded.out / f"{FILE}.html").is_file() else ""
    page = item_analysis.analysis_page(found, graded.titles, subtitle, attention)
    table = item_analysis.to_table(found)
    print_files([graded.write("analysis.csv", table), graded.write("analysis.html", page)])


def _manual(graded: GradedClass, _: argparse.Namespace) -> None:
    marks = {(mark.question, mark.student): mark for mark in graded.decisions.marks}
    for number, source in graded.sources.items():
        asked = written_questions(source)
        written = {
            student: written_answers(graded.submission(record), [q.name for q in asked])
            for student, record in graded.records(number).items()
        }
        for question in asked:
            answers = {student: its.get(question.name, "") for student, its in written.items()}
            table = graded.folder.folder / MANUAL / f"{question.name}.csv"
            changed = update_table(table, answers)
            for student in changed:
                print(f"{question.name}: {student} changed the answer after it was marked")
            given = {who: mark for (name, who), mark in marks.items() if name == question.name}
            page = marking_page(question, answers, given, changed)
            print_files([table, graded.write(f"manual/{question.name}.html", page)])


def _report(graded: GradedClass, _: argparse.Namespace) -> None:
    from fieldgrade.gradebook.class_report import class_report

    sentences = {
        (mistake.question, mistake.name): mistake.sentence
        for source in graded.sources.values()
        for mistake in entries(source, "misconceptions")
    }
    source, out = graded.root / "report", graded.out / "report"
    print_files(class_report(graded.results, graded.sheets, graded.titles, sentences, source, out))


def _similarity(graded: GradedClass, _: argparse.Namespace) -> None:
    rows: list[tuple[str, similarity.Pair]] = []
    files = []
    for number, title in graded.titles.items():
        codes = list(_codes(graded, number))
        given = similarity.code("", _handed_out(graded, number))
        found = similarity.pairs(codes, given)
        page = similarity.similarity_page(f"{number} {title}", found, len(codes))
        files.append(graded.write(f"similarity/{number}.html", page))
        rows += [(number, pair) for pair in found]
    print_files([*files, graded.write("similarity/pairs.csv", similarity.to_table(rows))])


def _codes(graded: GradedClass, number: str) -> Iterator[similarity.Code]:
    for student, record in graded.records(number).items():
        try:
            code = similarity.code(student, graded.submission(record).cells)
        except Exception as error:  # no submission stops the class
            print(f"{number}: the answers of {student} are not compared ({error})")
            continue
        if code.left_out:
            print(f"{number}: {code.left_out} functions or cells of {student} are not compared")
        yield code


def _handed_out(graded: GradedClass, number: str) -> tuple[str, ...]:
    """Return the code cells of the student's notebook."""
    name = f"{graded.sources[number].name}.ipynb"
    content = (graded.root / "exercises" / name).read_bytes()
    return Submission("", name, content).cells


def _differences(graded: GradedClass, options: argparse.Namespace) -> None:
    found = differences.compared(graded.file, graded.folder, options.before)
    print_differences(found)
    print_files([graded.write("differences.csv", differences.to_table(found))])


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
        print(f"{file}" if is_new else f"{file} exists and was kept")
