"""Tables of a class are read or their errors are reported, and names are matched to students."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldgrade.class_folder.example_tables import HEADERS, LINES
from fieldgrade.class_folder.roster import Student, columns, read_points, read_roster, read_times
from fieldgrade.submissions.bulk_downloads import parse_path, platform_of
from fieldgrade.submissions.owners import OwnerHint, students_of

QUESTIONS = ("01.1", "01.3", "01.5", "01.10")


def table(tmp_path, text):
    file = tmp_path / "table.csv"
    file.write_text(text, encoding="utf-8")
    return file


def example(tmp_path, name):
    return table(tmp_path, "\n".join([",".join(HEADERS[name]), *LINES[name]]))


def test_the_example_tables_are_read(tmp_path):
    """Instructors copy these lines."""
    students = read_roster(example(tmp_path, "roster.csv"))
    assert students["ada"].name == "Lovelace, Ada"
    assert columns(students["alan"])["canvas_id"] == "1205"
    assert read_points(example(tmp_path, "points.csv"), QUESTIONS) == {"01.3": 4.0, "01.5": 1.5}
    assert read_times(example(tmp_path, "received.csv")) == {
        ("ada", "01"): "2026-11-30T22:10:00+01:00"
    }


def test_only_the_student_column_of_a_roster_is_required(tmp_path):
    """Columns may have any order; the file has the format of a spreadsheet program."""
    file = tmp_path / "roster.csv"
    file.write_bytes("\ufeffName;Student\r\nAda Müller;s1\r\n;s2\r\n\r\n# gone;s3\r\n".encode())
    assert read_roster(file) == {"s1": Student("s1", "Ada Müller"), "s2": Student("s2")}


BAD = {
    "roster": (
        read_roster,
        "student,name\nada,Ada\n,Nobody\nbob\nADA,Again\nx,y,z\n",
        [
            "table.csv:3: column student is empty",
            "table.csv:5: student ADA is already in line 2",
            "table.csv:6: the line has 3 cells for 2 columns",
        ],
    ),
    "roster with equal numbers": (
        read_roster,
        "student,email,canvas_id\nada,a@x.org,\nbob,A@x.org,\ncai,,7\ndan,,7\neve,,\n",
        [
            "table.csv:3: email A@x.org is already in line 2",
            "table.csv:5: canvas_id 7 is already in line 4",
        ],
    ),
    "points": (
        lambda file: read_points(file, QUESTIONS),
        "question,points\n01.1,two\n1.1,2\n09.9,1\n01.3,2\n01.3,3\n01.5,\n01.10,-1\n",
        [
            "table.csv:2: points must be a number such as 1.5, not 'two'",
            "table.csv:3: a question is written as 01.2, not '1.1'; spreadsheets shorten such names"
            " unless the column is formatted as text",
            "table.csv:4: there is no question 09.9",
            "table.csv:6: question 01.3 is already in line 5",
            "table.csv:7: column points is empty",
            "table.csv:8: points must be a number such as 1.5, not '-1'",
        ],
    ),
    "times": (
        read_times,
        "student,notebook,received\nada,1,2026-11-30\nada,one,2026-11-30T12:00Z\n"
        "bob,01,2026-11-30T12:00\nbob,02,yesterday\ncai,1,2026-11-30T12:00Z\n"
        "cai,01,2026-12-01T12:00Z\n",
        [
            "table.csv:2: '2026-11-30' is a day without a time: write 2026-11-30T23:59+01:00",
            "table.csv:3: a notebook is written as 02, not 'one'",
            "table.csv:4: '2026-11-30T12:00' has no time zone: write it as "
            "2026-11-30T12:00+01:00 or 2026-11-30T12:00Z",
            "table.csv:5: a time must be written as 2026-11-30T23:59+01:00, not 'yesterday'",
            "table.csv:7: student, notebook cai, 01 is already in line 6",
        ],
    ),
}


@pytest.mark.parametrize(("read", "text", "problems"), BAD.values(), ids=BAD)
def test_all_bad_lines_of_a_table_are_reported_at_once(tmp_path, read, text, problems):
    """Each error is one sentence with its line number."""
    with pytest.raises(ValueError, match="table") as error:
        read(table(tmp_path, text))
    assert str(error.value).splitlines() == problems


ADA = Student("s123", "Ada King Lovelace", "ada@x.org", "alove", "12", "77", "", "512 612")
BOB = Student("bob", "Bob Byte", "bob@x.org", "bbyte", "13", "78", "", "513")
ROSTER = {s.student: s for s in (ADA, BOB)}
SIGNS = {
    "the number of Canvas": OwnerHint("anybody", "12", platform="canvas"),
    "the number of Moodle": OwnerHint("Participant", "512", platform="moodle"),
    "the number of Gradescope": OwnerHint("A. L.", "77", platform="gradescope"),
    "one of several numbers of Moodle": OwnerHint("Participant", "612", platform="moodle"),
    "the address": OwnerHint("A. L.", "", "ADA@x.org", "gradescope"),
    "an address as a name": OwnerHint("ada@x.org"),
    "the login": OwnerHint("ALove"),
    "the name": OwnerHint("Ada King Lovelace"),
    "the name of Canvas": OwnerHint("lovelaceadaking", "", platform="canvas"),
    "the name, last in front": OwnerHint("Lovelace, Ada King"),
    "the name with accents": OwnerHint("Ada Kíng  Lovelacé"),
    "the number in a text": OwnerHint("hand-in_s123 (final)"),
}


@pytest.mark.parametrize("owner", SIGNS.values(), ids=SIGNS)
def test_a_student_is_identified_by_any_of_several_hints(owner):
    """Hints are numbers, addresses, names as platforms change them, and a number within a text."""
    assert students_of([owner], ROSTER) == {owner: "s123"}


STRANGERS = {
    "a part of a name": OwnerHint("Bob"[:2]),
    "a word of a text": OwnerHint("Maria de bob"),
    "another number": OwnerHint("bytebob", "99", platform="canvas"),
    "a student number that Moodle gave to another": OwnerHint("C", "77", platform="moodle"),
    "nothing": OwnerHint(""),
}


@pytest.mark.parametrize("owner", STRANGERS.values(), ids=STRANGERS)
def test_an_unknown_owner_is_not_matched_to_a_student(owner):
    """Similarity is not enough, since a submission must not count for another student."""
    assert students_of([owner], ROSTER) == {owner: owner.text}


@pytest.mark.parametrize("platform", ["canvas", "moodle"])
def test_a_number_of_a_platform_is_not_a_student_number(platform):
    """The platform may give one student the number that another has at the university."""
    roster = {s.student: s for s in (Student("4701", "Ada Berg"), Student("4702", "Bob Carr"))}
    owner = OwnerHint("Bob Carr", "4701", platform=platform)
    assert students_of([owner], roster) == {owner: "4702"}


def test_an_ambiguous_name_is_not_matched():
    """Two students of one name are distinguished by their numbers, or not at all."""
    twins = {k: Student(k, "Kim Lee", canvas_id=n) for k, n in (("k1", "1"), ("k2", "2"))}
    plain = OwnerHint("Kim Lee")
    assert students_of([plain], twins) == {plain: "Kim Lee"}
    numbered = OwnerHint("leekim", "2", platform="canvas")
    assert students_of([numbered], twins) == {numbered: "k2"}


@pytest.mark.slow
@given(st.text(max_size=60), st.text(max_size=20), st.text(max_size=20))
def test_any_text_is_matched_to_at_most_one_student(text, number, email):
    """No text raises an error."""
    owner = OwnerHint(text, number, email, "moodle")
    assert students_of([owner], ROSTER)[owner] in {text, f"{text} ({number})", "s123", "bob"}


@pytest.mark.slow
@given(st.text(min_size=1).filter(lambda name: "/" not in name), st.text(max_size=5))
def test_any_path_has_one_owner(first, rest):
    where = parse_path([first, *([rest] if rest else [])], "Moodle")
    assert len(where.owners) == 1
    assert isinstance(platform_of(first), str)
