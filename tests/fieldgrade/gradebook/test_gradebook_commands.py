"""The commands that begin where grading has ended, from a folder of results to files."""

import csv
import io
import json
import re

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
def place(tmp_path):
    """A folder of results with two notebooks in its archive, and a class with a table."""
    out, archive = tmp_path / "out", Archive(tmp_path / "out" / "received")
    found = []
    for name, book, points in (("ada", notebook("01"), 2.0), ("bob", notebook("01"), 0.0)):
        handed_in = submission(name, book)
        digest = archive.put(io.BytesIO(handed_in.content), 1 << 30)
        mistake = {} if points else {"rung": "misconception", "mistake": "no constant"}
        grades = [grade("01.1", points, **mistake), grade("01.2", 2.0)]
        found.append(record(name, grades, digest=digest))
    write_results(results(found, QUESTIONS, STUDENTS, **HEX), out / "results.json")
    (tmp_path / "class").mkdir()
    named = "notebook,canvas,moodle\n01,LS (17),Assignment: LS\n"
    (tmp_path / "class" / "assignments.csv").write_text(named)
    return tmp_path


def run(place, name, *more):
    folders = [str(place / "out"), "--class", str(place / "class")]
    return main(["course", "--root", str(ROOT), name, *folders, *more])


def rows(file):
    return list(csv.reader(io.StringIO(file.read_text("utf-8"))))


def test_feedback_is_a_page_for_each_student_and_a_list_of_them(place):
    """The list tells which page is whose."""
    assert run(place, "feedback") == 0
    files = dict(rows(place / "out/feedback/files.csv")[1:])
    assert set(files) == {"ada", "bob"}
    page = (place / "out/feedback" / files["bob"]).read_text("utf-8")
    assert "Bob Unmistakable" in page
    assert "Lovelace" not in page


def test_export_writes_each_form_and_tells_what_waits(place, capsys):
    """Grade book, Canvas, Moodle, Gradescope; unread answers and open requests are told."""
    line = "ada,01.1,2026-12-02,Look again.,\n"
    (place / "class/requests.csv").write_text("student,question,on,request,answer\n" + line)
    assert run(place, "export", "--out", str(place / "elsewhere")) == 0
    told = capsys.readouterr().out
    assert "2 answers are not graded yet" in told
    assert "open request: ada, 01.1, 2026-12-02" in told
    assert [r[0] for r in rows(place / "elsewhere/gradebook.csv")] == ["student", "ada", "bob"]
    assert rows(place / "elsewhere/canvas.csv")[2][-1] == "4"
    assert rows(place / "elsewhere/moodle.csv")[2][1] == "2"
    scope = place / "elsewhere/gradescope/01/bob/results.json"
    assert json.loads(scope.read_text())["score"] == 2


def test_a_platform_without_names_is_told_and_not_made(place, capsys):
    """Who does not use Canvas is not stopped by it."""
    (place / "class/assignments.csv").unlink()
    assert run(place, "export") == 0
    assert "no canvas.csv: column canvas of assignments.csv is empty" in capsys.readouterr().out
    assert not (place / "out/canvas.csv").exists()


def test_words_are_read_and_the_points_come_back(place):
    """Pages and tables are made; points that are entered count in the next export."""
    assert run(place, "manual") == 0
    table = place / "class/manual/01.7.csv"
    assert "By counting" in (place / "out/manual/01.7.html").read_text("utf-8")
    table.write_text(table.read_text().replace("ada,,", "ada,2.5,"))
    assert run(place, "manual") == 0
    assert "ada,2.5," in table.read_text()
    assert run(place, "export") == 0
    assert rows(place / "out/gradebook.csv")[1][5] == "2.5"


def test_an_override_is_told_as_a_difference(place, capsys):
    """What was decided since the class was graded stands in the table with its reason."""
    from fieldgrade.class_folder.decisions import ClassFolder, save_decisions

    save_decisions(place / "out", ClassFolder(place / "class"))
    assert run(place, "differences") == 0
    assert "no grade changed" in capsys.readouterr().out
    line = "bob,01.1,1,Hopper,right idea,2026-12-02\n"
    (place / "class/overrides.csv").write_text("student,question,points,by,reason,on\n" + line)
    assert run(place, "differences") == 0
    told = ["bob", "01.1", "0", "1", "override: right idea"]
    assert rows(place / "out/differences.csv")[1] == told


def test_similar_notebooks_are_shown(place):
    """Two equal notebooks share all that is not handed out, in the functions asked for."""
    assert run(place, "similarity") == 0
    (pair,) = rows(place / "out/similarity/pairs.csv")[1:]
    assert pair[:4] == ["01", "ada", "bob", "1"]
    assert "fit" in pair[5]
    assert "not a verdict" in (place / "out/similarity/01.html").read_text("utf-8")


def test_the_analysis_counts_mistakes(place):
    """A line for each question, with what went wrong."""
    assert run(place, "analysis") == 0
    assert rows(place / "out/analysis.csv")[1] == ["01.1", "2", "0.5", "0.5", "", "no constant (1)"]


@pytest.mark.slow
def test_the_class_report_has_facts_tables_and_figures_and_names_nobody(place):
    """HTML and PDF are set by the report generator; no student is in them."""
    assert run(place, "report") == 0
    page = (place / "out/report/report.html").read_text("utf-8")
    text = re.sub(r"\s+", " ", re.sub(r"<[^>]+>", "", page))
    assert "The class has 2 students. 2 of them submitted" in text
    assert "The constant is missing." in text
    assert page.count("data:image/svg+xml") == 2
    assert (place / "out/report/report.pdf").read_bytes().startswith(b"%PDF")
    for name in ("Unmistakable", "Lovelace", "ada@"):
        assert name not in page


def test_the_tables_of_a_class_are_written_once(tmp_path, capsys):
    """The command tells what it wrote and what was there."""
    assert main(["course", "class", str(tmp_path / "class")]) == 0
    assert "was there" not in capsys.readouterr().out
    assert main(["course", "class", str(tmp_path / "class")]) == 0
    assert "roster.csv exists and was kept" in capsys.readouterr().out


def test_what_is_wrong_is_told_in_a_sentence(place, capsys):
    """Missing results, a damaged file and a bad table end with status 2 and say where."""
    assert main(["course", "export", str(place / "nowhere.json")]) == 2
    assert "nowhere.json" in capsys.readouterr().err
    assert main(["course", "export", str(place / "out"), "--class", str(place / "clas")]) == 2
    assert "there is no folder" in capsys.readouterr().err
    (place / "class/overrides.csv").write_text("student,question\n")
    assert run(place, "export") == 2
    assert "overrides.csv:1: there is no column points, by, reason, on" in capsys.readouterr().err
    (place / "out/results.json").write_text("{}")
    assert run(place, "analysis") == 2
    assert "results.json: this is not a file of results" in capsys.readouterr().err


def test_differences_are_printed_as_a_table(capsys):
    """Without any there is a sentence."""
    command.print_differences([])
    assert capsys.readouterr().out == "no grade changed\n"
