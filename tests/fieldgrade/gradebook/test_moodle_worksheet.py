"""The grading worksheet of Moodle is filled in so that Moodle reads the grades back."""

import csv
import io
import re
import zipfile

import pytest

from fieldgrade.gradebook import moodle_worksheet
from fieldgrade.gradebook.grade_sheets import grade_sheets
from gradebook_class import asked, grade, record, results

STUDENTS = [
    {"student": "s1", "name": "Berg, Ada", "email": "ada@uni.example"},
    {"student": "s2", "name": "Carr, Bob", "email": "bob@uni.example"},
    {"student": "s3", "name": "Dahl, Cai", "email": "cai@uni.example"},
    {"student": "s4", "name": "Eck, Dan"},
    {"student": "s5", "name": "Falk, Eve"},
]
# The columns that mod/assign/gradingtable.php writes for a download with e-mail addresses.
HEADER = (
    "Identifier,Full name,Email address,Status,Grade,Maximum Grade,Grade can be changed,"
    "Last modified (submission),Last modified (grade),Feedback comments"
)
WORKSHEET = f"""\ufeff{HEADER}
Participant 8813,Ada Berg,ADA@uni.example,Submitted for grading - ,,4.00,Yes,"Fri, 20 Nov",-,
Participant 8807,Robert C.,bob@uni.example,Submitted for grading - ,1.00,"2,00",Yes,-,-,old
Participant 8811,Cai Dahl,,Submitted for grading - ,,4.00,No,-,-,
Participant 8815,Eve Falk,,Submitted for grading - ,,4.00,Yes,-,-,
Participant 8809,Nora Nobody,nora@uni.example,No submission - ,3.00,4.00,Yes,-,-,by hand
"""


def sheets():
    found = [record(f"s{k}", [grade("01.1", 2.0), grade("01.2", 0.5)]) for k in (1, 2, 3, 4)]
    return grade_sheets(results(found, asked("01.1", "01.2"), STUDENTS))


@pytest.fixture
def participants(tmp_path):
    file = tmp_path / "01.csv"
    file.write_text(WORKSHEET, encoding="utf-8")
    return moodle_worksheet.read_worksheet(file, sheets())


def read_as_moodle(text):
    """Grade and feedback by the number of the participant.

    The rules are those of importgradeslib.php: the number is what follows the first 12 characters,
    and the three columns are found by name.
    """
    header, *rows = csv.reader(io.StringIO(text))
    who, points, _, said = (
        header.index(name)
        for name in ("Identifier", "Grade", "Last modified (grade)", "Feedback comments")
    )
    return {row[who][len("Participant ") :]: (row[points], row[said]) for row in rows}


def test_grades_and_feedback_are_filled_in_and_all_else_remains(participants):
    """Students are found by address or by name; a stranger's grade by hand is kept."""
    text = moodle_worksheet.worksheet_csv(participants)
    read = read_as_moodle(text)
    assert {number: points for number, (points, _) in read.items()} == {
        "8813": "2.5",
        "8807": "2.5",
        "8811": "2.5",
        "8815": "",
        "8809": "3.00",
    }
    assert read["8813"][1].startswith("01.1")
    assert read["8809"][1] == "by hand"
    before = csv.DictReader(io.StringIO(WORKSHEET.lstrip("\ufeff")))
    for old, new in zip(before, csv.DictReader(io.StringIO(text)), strict=True):
        changed = {name for name in old if old[name] != new[name]}
        assert changed <= {"Grade", "Feedback comments"}


def test_grades_that_moodle_would_skip_are_reported(participants):
    """Above the maximum, locked, or of a student who is not in the worksheet."""
    assert dict(moodle_worksheet.problems(participants, sheets())) == {
        "s2": "2.5 points are more than the maximum grade, 2.00",
        "s3": "the grade is locked in Moodle",
        "s4": "no line of the worksheet has the name",
    }


def test_feedback_files_are_named_as_moodle_expects(participants, tmp_path):
    """importziplib.php splits each folder at underscores: name, number, type and plugin.

    A student whose file is unreadable has a page, too, which says so.
    """
    pages = {f"s{k}": tmp_path / f"{k}.html" for k in (1, 2, 3, 5)}
    for student in ("s1", "s2", "s5"):
        pages[student].write_text(student)
    packed = moodle_worksheet.feedback_zip(participants, pages)
    with zipfile.ZipFile(io.BytesIO(packed)) as archive:
        found = {name: archive.read(name).decode() for name in archive.namelist()}
    numbers = {}
    for name, content in found.items():
        folder, _, file = name.partition("/")
        _, number, kind, plugin = folder.split("_")
        assert (kind, plugin, file) == ("assignfeedback", "file", "feedback.html")
        numbers[number] = content
    assert numbers == {"8813": "s1", "8807": "s2", "8815": "s5"}


def test_a_table_that_is_not_a_worksheet_is_refused(tmp_path):
    """Moodle names the columns in its own language."""
    file = tmp_path / "01.csv"
    file.write_text("Identifikator,Grade\nx,1\n")
    wanted = "01.csv is not a grading worksheet in English: it has no column 'Identifier'"
    with pytest.raises(ValueError, match=re.escape(wanted)):
        moodle_worksheet.read_worksheet(file, sheets())
