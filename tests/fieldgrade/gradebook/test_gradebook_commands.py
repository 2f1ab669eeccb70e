"""The commands after grading: from a folder of results to feedback, tables and reports."""

import csv
import io
import json
import os
import re
import subprocess
import tomllib

import pytest

from fieldgrade.checking.results import write_results
from fieldgrade.commands import gradebook as command
from fieldgrade.submissions.archive import Archive
from fieldrecon.cli.main import main
from gradebook_class import ROOT, asked, grade, notebook, record, results, submission

QUESTIONS = asked("01.1", "01.2") + asked("01.7", points=3.0, kind="words")
STUDENTS = [
    {"student": "ada", "name": "Lovelace, Ada", "login": "ada", "email": "ada@uni.example"},
    {"student": "bob", "name": "Bob Unmistakable", "login": "bob", "email": "bob@uni.example"},
]
HEX = {"grader": "a" * 64, "environment": "b" * 64, "secret": True}


@pytest.fixture
def folder(tmp_path):
    """A folder with results and two archived notebooks, and a class folder with one table."""
    out, archive = tmp_path / "out", Archive(tmp_path / "out" / "received")
    found = []
    for name, book, points in (("ada", notebook("01"), 2.0), ("bob", notebook("01"), 0.0)):
        handed_in = submission(name, book)
        digest = archive.put(io.BytesIO(handed_in.content), 1 << 30)
        mistake = {} if points else {"finding": "misconception", "mistake": "no constant"}
        grades = [grade("01.1", points, **mistake), grade("01.2", 2.0)]
        found.append(record(name, grades, digest=digest))
    write_results(results(found, QUESTIONS, STUDENTS, **HEX), out / "results.json")
    (tmp_path / "class").mkdir()
    named = "notebook,canvas,moodle\n01,LS (17),Assignment: LS\n"
    (tmp_path / "class" / "assignments.csv").write_text(named)
    return tmp_path


def run(folder, name, *more):
    folders = [str(folder / "out"), "--class", str(folder / "class")]
    return main(["course", "--root", str(ROOT), name, *folders, *more])


def rows(file):
    return list(csv.reader(io.StringIO(file.read_text("utf-8"))))


def test_feedback_writes_a_page_for_each_student_and_a_list_of_pages(folder):
    """The list assigns the pages to the students."""
    assert run(folder, "feedback") == 0
    files = dict(rows(folder / "out/feedback/files.csv")[1:])
    assert set(files) == {"ada", "bob"}
    page = (folder / "out/feedback" / files["bob"]).read_text("utf-8")
    assert "Bob Unmistakable" in page
    assert "Lovelace" not in page


def test_export_writes_every_format_and_reports_pending_work(folder, capsys):
    """The formats are those of the gradebook, Canvas, Moodle and Gradescope."""
    line = "ada,01.1,2026-12-02,Look again.,\n"
    (folder / "class/requests.csv").write_text("student,question,on,request,answer\n" + line)
    (folder / "class/worksheets").mkdir()
    (folder / "class/worksheets/01.csv").write_text(
        "Identifier,Full name,Grade,Last modified (grade)\nParticipant 7,Ada Lovelace,,-\n"
    )
    assert run(folder, "export", "--out", str(folder / "elsewhere")) == 0
    printed = capsys.readouterr().out
    assert "Moodle will not get the grade of bob for 01: no line of the worksheet" in printed
    assert rows(folder / "elsewhere/worksheets/01.csv")[1][:3] == [
        "Participant 7",
        "Ada Lovelace",
        "4",
    ]
    assert (folder / "elsewhere/worksheets/01-feedback.zip").is_file()
    assert "2 answers are not graded yet" in printed
    assert "open request: ada, 01.1, 2026-12-02" in printed
    assert [r[0] for r in rows(folder / "elsewhere/gradebook.csv")] == ["student", "ada", "bob"]
    assert rows(folder / "elsewhere/canvas.csv")[2][-1] == "4"
    assert rows(folder / "elsewhere/moodle.csv")[2][1] == "2"
    scope = folder / "elsewhere/gradescope/01/bob/results.json"
    assert json.loads(scope.read_text())["score"] == 2


def test_an_export_without_assignment_names_is_skipped_and_reported(folder, capsys):
    """A class that does not use Canvas can still be exported."""
    (folder / "class/assignments.csv").unlink()
    assert run(folder, "export") == 0
    assert "no canvas.csv: column canvas of assignments.csv is empty" in capsys.readouterr().out
    assert not (folder / "out/canvas.csv").exists()


@pytest.mark.slow
def test_manual_points_reach_the_exported_gradebook(folder):
    """Marking pages and tables are written; entered points count in the next export."""
    assert run(folder, "manual") == 0
    table = folder / "class/manual/01.7.csv"
    assert "By counting" in (folder / "out/manual/01.7.html").read_text("utf-8")
    table.write_text(table.read_text().replace("ada,,", "ada,2.5,"))
    assert run(folder, "manual") == 0
    assert "ada,2.5," in table.read_text()
    assert run(folder, "export") == 0
    assert rows(folder / "out/gradebook.csv")[1][5] == "2.5"


def test_an_override_is_reported_as_a_difference(folder, capsys):
    """The table lists decisions made since the class was graded, with their reasons."""
    from fieldgrade.class_folder.decisions import ClassFolder, save_decisions

    save_decisions(folder / "out", ClassFolder(folder / "class"))
    assert run(folder, "differences") == 0
    assert "no grade changed" in capsys.readouterr().out
    line = "bob,01.1,1,Hopper,right idea,2026-12-02\n"
    (folder / "class/overrides.csv").write_text("student,question,points,by,reason,on\n" + line)
    assert run(folder, "differences") == 0
    printed = ["bob", "01.1", "0", "1", "override: right idea"]
    assert rows(folder / "out/differences.csv")[1] == printed


def test_similar_notebooks_are_reported(folder):
    """Two equal notebooks share all code that was not handed out, in the required functions."""
    assert run(folder, "similarity") == 0
    (pair,) = rows(folder / "out/similarity/pairs.csv")[1:]
    assert pair[:4] == ["01", "ada", "bob", "1"]
    assert "fit" in pair[5]
    assert "not a verdict" in (folder / "out/similarity/01.html").read_text("utf-8")


def test_an_error_in_the_comparison_of_one_student_is_reported(folder, monkeypatch, capsys):
    """The other students are compared, and the student is named."""
    whole = command.similarity.code

    def fails_for_ada(student, cells):
        if student == "ada":
            raise RecursionError("too deep")
        return whole(student, cells)

    monkeypatch.setattr(command.similarity, "code", fails_for_ada)
    assert run(folder, "similarity") == 0
    assert "the answers of ada are not compared (too deep)" in capsys.readouterr().out


def test_the_analysis_counts_misconceptions(folder):
    """The table has one line for each question."""
    assert run(folder, "analysis") == 0
    assert rows(folder / "out/analysis.csv")[1] == [
        "01.1",
        "2",
        "0.5",
        "0.5",
        "",
        "no constant (1)",
    ]


@pytest.mark.slow
def test_the_class_report_has_tables_and_figures_and_names_no_student(folder):
    """The report is written as HTML and PDF."""
    assert run(folder, "report") == 0
    page = (folder / "out/report/report.html").read_text("utf-8")
    text = re.sub(r"\s+", " ", re.sub(r"<[^>]+>", "", page))
    assert "The class has 2 students. 2 of them submitted" in text
    assert "The column of ones is missing." in text
    assert page.count('<svg class="picture" role="img"') == 2
    assert (folder / "out/report/report.pdf").read_bytes().startswith(b"%PDF")
    for name in ("Unmistakable", "Lovelace", "ada@"):
        assert name not in page


def test_existing_tables_of_a_class_are_kept(tmp_path, capsys):
    """The command reports which tables it wrote and which ones existed."""
    assert main(["course", "class", str(tmp_path / "class")]) == 0
    assert "was there" not in capsys.readouterr().out
    assert main(["course", "class", str(tmp_path / "class")]) == 0
    assert "roster.csv exists and was kept" in capsys.readouterr().out


def test_the_example_class_is_packaged_and_never_overwrites(tmp_path, capsys):
    """All its files are package data, so that an installed wheel has them, too."""
    package, folder = ROOT / "src/fieldgrade", tmp_path / "try"
    assert main(["course", "example", str(folder)]) == 0
    assert f"grade {folder / 'submissions'} --class {folder / 'class'}" in capsys.readouterr().out
    written = {path.relative_to(folder) for path in folder.rglob("*") if path.is_file()}
    settings = tomllib.loads((ROOT / "src/pyproject.toml").read_text())
    patterns = settings["tool"]["setuptools"]["package-data"]["fieldgrade"]
    packaged = {path for pattern in patterns for path in package.glob(pattern) if path.is_file()}
    example = package / "class_folder/example_class"
    assert {example / name for name in written} <= packaged
    assert len(written) == 5 + 2 + 1
    roster = folder / "class/roster.csv"
    roster.write_text("student\nmine\n")
    assert main(["course", "example", str(folder)]) == 2
    assert "is not empty: name a new folder" in capsys.readouterr().err
    assert roster.read_text() == "student\nmine\n"


def test_bad_input_of_the_commands_is_reported(folder, capsys):
    """Missing results, a damaged file and a bad table give exit status 2 and are named."""
    assert main(["course", "export", str(folder / "nowhere.json")]) == 2
    assert "nowhere.json" in capsys.readouterr().err
    assert main(["course", "export", str(folder / "out"), "--class", str(folder / "clas")]) == 2
    assert "there is no folder" in capsys.readouterr().err
    (folder / "class/overrides.csv").write_text("student,question\n")
    assert run(folder, "export") == 2
    assert "overrides.csv:1: there is no column points, by, reason, on" in capsys.readouterr().err
    (folder / "out/results.json").write_text("{}")
    assert run(folder, "analysis") == 2
    assert "results.json: this is not a file of results" in capsys.readouterr().err


def test_differences_are_printed_as_a_table(capsys):
    """Without differences the command prints a sentence."""
    command.print_differences([])
    assert capsys.readouterr().out == "no grade changed\n"


def test_the_statistics_link_to_the_list_that_needs_eyes(folder):
    """The link is there if the list is, beside the page."""
    assert run(folder, "analysis") == 0
    assert "href" not in (folder / "out/analysis.html").read_text("utf-8")
    (folder / "out/needs-your-eyes.html").touch()
    assert run(folder, "analysis") == 0
    assert 'href="needs-your-eyes.html"' in (folder / "out/analysis.html").read_text("utf-8")


def test_a_second_export_writes_no_unchanged_file(folder):
    """Files whose content is the same keep their time; a changed one is written."""
    assert run(folder, "export") == 0
    files = [f for f in (folder / "out").rglob("*") if f.suffix in (".csv", ".json")]
    for file in files:
        os.utime(file, (1e9, 1e9))
    (folder / "class/overrides.csv").write_text(
        "student,question,points,by,reason,on\nbob,01.1,1,Hopper,fair,2026-12-02\n"
    )
    assert run(folder, "export") == 0
    written = {f.relative_to(folder / "out").as_posix() for f in files if f.stat().st_mtime > 1e9}
    assert written == {
        "canvas.csv",
        "gradebook.csv",
        "moodle.csv",
        "gradescope/01/bob/results.json",
    }


@pytest.mark.parametrize("is_repository", [True, False])
def test_git_ignores_folders_with_data_of_students(folder, is_repository):
    """A folder of grades or of tables inside a repository is ignored, wherever it is."""
    if is_repository:
        subprocess.run(["git", "init", "-q", folder], check=True)
    assert run(folder, "export", "--out", str(folder / "elsewhere")) == 0
    assert main(["course", "class", str(folder / "tables")]) == 0
    for name in ("elsewhere", "tables"):
        assert (folder / name / ".gitignore").is_file() == is_repository
    if is_repository:
        command = ["git", "-C", folder, "status", "--short", "elsewhere", "tables"]
        assert subprocess.run(command, capture_output=True, check=True).stdout == b""
