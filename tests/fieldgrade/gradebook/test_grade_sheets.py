"""Grade sheets combine the grader, marks, overrides and lateness; bad tables are refused."""

from datetime import date

import pytest

from fieldgrade.class_folder.assignments import Assignment, read_assignments
from fieldgrade.class_folder.decisions import Decisions, Mark
from fieldgrade.class_folder.dismissals import read_dismissals
from fieldgrade.class_folder.example_tables import HEADERS, LINES, example, write_examples
from fieldgrade.class_folder.late_policy import Extension, LatePolicy, moment, read_extensions
from fieldgrade.class_folder.overrides import (
    Override,
    RegradeRequest,
    open_requests,
    read_overrides,
    read_requests,
)
from fieldgrade.class_folder.roster import read_points, read_roster, read_times
from fieldgrade.gradebook.explanations import heading
from fieldgrade.gradebook.exports import gradebook_csv
from fieldgrade.gradebook.grade_sheets import by_student, grade_sheets
from gradebook_class import asked, grade, record, results

DAY = date(2026, 12, 2)
READ = {
    "roster.csv": read_roster,
    "points.csv": lambda file: read_points(file, ["01.3", "01.5"]),
    "received.csv": read_times,
    "assignments.csv": read_assignments,
    "extensions.csv": read_extensions,
    "overrides.csv": read_overrides,
    "dismissed.csv": read_dismissals,
    "requests.csv": read_requests,
}


def override(points, reason="because", student="ada", question="01.1"):
    return Override(student, question, points, "Hopper", reason, DAY)


def sheet(decisions=None, **changes):
    graded = [grade("01.1", 2.0), grade("01.2", 0.0)]
    return grade_sheets(results([record("ada", graded, **changes)]), decisions)[0]


def test_overrides_replace_checks_and_marks_fill_written_answers():
    """An override replaces the points of a check; an answer without a mark stays open."""
    plain = sheet()
    assert [(line.points, line.how) for line in plain.lines] == [
        (2, "checked"),
        (0, "checked"),
        (0, "open"),
    ]
    decided = sheet(Decisions(marks=[Mark("ada", "01.7", 1.5)], overrides=[override(1)]))
    assert [(line.points, line.how) for line in decided.lines] == [
        (1, "override"),
        (0, "checked"),
        (1.5, "read"),
    ]
    assert decided.points == 2.5


def test_the_last_of_several_overrides_counts():
    """Overrides are only appended to the table, so the order of the lines decides."""
    decided = sheet(Decisions(overrides=[override(1, "first"), override(0.5, "then")]))
    assert (decided.lines[0].points, decided.lines[0].comment) == (0.5, "then")


def test_the_latest_submission_counts_even_with_fewer_points():
    """The later of two submissions counts, also if they name different time zones."""
    early = record("ada", [grade("01.1", 2.0)], received="2026-11-30T20:30:00+01:00")
    last = record("ada", [grade("01.1", 1.0)], received="2026-11-30T20:00:00Z")
    for order in ([early, last], [last, early]):
        (found,) = grade_sheets(results(order, asked("01.1")))
        assert found.points == 1


def test_lateness_is_applied_by_the_grade_sheet_and_not_by_the_results():
    """The results contain no policy: the present tables determine what the same record loses."""
    late = {"received": "2026-12-02T12:00:00+01:00"}
    policy = LatePolicy(moment("2026-11-30T23:59+01:00"), per_day=0.25)
    named = {"01": Assignment("01", policy)}
    assert sheet(None, **late).points == 2
    assert sheet(Decisions(named), **late).points == 1
    more = {("ada", "01"): Extension("ada", "01", moment("2026-12-05T12:00Z"), "ill")}
    assert sheet(Decisions(named, more), **late).points == 2


@pytest.mark.parametrize(
    ("decisions", "message"),
    [
        (Decisions(overrides=[override(1, student="adda")]), "adda, 01.1: no such student"),
        (Decisions(overrides=[override(1, question="01.9")]), "ada, 01.9: there is no such quest"),
        (Decisions(overrides=[override(3)]), "3 points for ada, 01.1: the question is worth 2"),
        (Decisions(marks=[Mark("ada", "01.2", 1)]), "this answer is code; write an over"),
    ],
)
def test_decisions_for_unknown_students_or_questions_are_refused(decisions, message):
    """Too many points, and a mark for a code question, are refused too."""
    with pytest.raises(ValueError, match=message):
        sheet(decisions)


def test_students_without_a_readable_notebook_are_in_the_gradebook():
    """Every student has a row, and unreadable files are named in it."""
    found = grade_sheets(
        results(
            [
                record("ada", [grade("01.1", 2.0)]),
                record("bob", [], notebook="", status="unreadable", tier="", file="photo.ipynb"),
            ],
            asked("01.1"),
            students=[{"student": "cy", "name": "Cy"}],
        )
    )
    rows = gradebook_csv(found).splitlines()
    assert rows[0] == (
        "student,name,section,01.1 of 2,01 late,01 points,01 status,points,unreadable files"
    )
    assert rows[1:] == [
        "cy,Cy,,0,0,0,not submitted,0,",
        "ada,,,2,0,2,graded,2,",
        "bob,,,0,0,0,not submitted,0,photo.ipynb",
    ]


def counted(submitted, listed=()):
    """For each student: the notebooks with points, and those that do not count."""
    records = [
        record(student, [grade(f"{number}.1", 2.0)], notebook=number)
        for student, numbers in submitted.items()
        for number in numbers
    ]
    asked_ = asked("01.1", "02.1", "03.1")
    assignments = {number: Assignment(number) for number in listed}
    found = grade_sheets(results(records, asked_), Decisions(assignments))
    return {
        row[0].student["student"]: (
            [sheet.notebook for sheet in row],
            [record.notebook for record in row[0].uncounted],
        )
        for row in by_student(found)
    }


def test_a_stray_notebook_changes_nobody_elses_total():
    """A notebook of one student of five does not count, and only this student's sheet names it."""
    found = counted({"ada": ["01", "02"], "bob": ["01"], "cy": ["01"], "di": ["01"], "ed": ["01"]})
    assert found.pop("ada") == (["01"], ["02"])
    assert set(map(str, found.values())) == {"(['01'], [])"}


def test_notebooks_count_by_the_assignments_or_by_their_number_of_submissions():
    """Listed notebooks count; without a list, those of a tenth as many students as the first."""
    many = {f"s{k:02}": ["01", "02"] if k < 3 else ["01"] for k in range(30)}
    assert counted(many)["s05"] == (["01", "02"], []), "three of thirty are a tenth"
    many["s02"] = ["01"]
    assert counted(many)["s05"] == (["01"], [])
    assert counted(many, ["01", "02", "03"])["s05"] == (["01", "02"], []), "listed and submitted"
    assert counted(many, ["02"])["s00"] == (["02"], ["01"])
    assert counted({"ada": ["01", "02"], "bob": ["01"]})["bob"] == (["01", "02"], [])
    with pytest.raises(ValueError, match=r"assignments.csv has no line for any submitted .* 01"):
        counted({"ada": ["01"]}, ["03"])


def test_a_regrade_request_is_open_until_an_answer_or_a_later_override():
    """An override from before the request does not close it."""
    asks = RegradeRequest("ada", "01.1", DAY, "please")
    assert open_requests([asks], []) == [asks]
    assert open_requests([asks], [override(1)]) == []
    before = Override("ada", "01.1", 1, "Hopper", "because", date(2026, 12, 1))
    assert open_requests([asks], [before]) == [asks]
    answered = RegradeRequest("ada", "01.1", DAY, "please", "no: see the rubric")
    assert open_requests([answered], []) == []


@pytest.mark.parametrize("name", HEADERS)
def test_every_example_table_is_valid(name, tmp_path):
    """The tables that are written are valid and empty, and each example line in them is valid."""
    file = tmp_path / name
    file.write_text(example(name))
    assert not READ[name](file)
    file.write_text("\n".join([",".join(HEADERS[name]), *LINES[name]]))
    assert len(READ[name](file)) == len(LINES[name])


def test_example_tables_never_overwrite_an_existing_table(tmp_path):
    (tmp_path / "roster.csv").write_text("student\nada\n")
    written = {file.name for file, is_new in write_examples(tmp_path) if is_new}
    assert written == set(HEADERS) - {"roster.csv"}
    assert (tmp_path / "roster.csv").read_text() == "student\nada\n"
    assert not any(is_new for _, is_new in write_examples(tmp_path))


@pytest.mark.parametrize(
    ("name", "line", "message"),
    [
        ("overrides.csv", "ada,01.3,2,,fair,2026-12-02", "2: column by is empty"),
        ("overrides.csv", "ada,1.3,2,Hopper,fair,2026-12-02", "2: a question is written as 01.2"),
        (
            "overrides.csv",
            "ada,01.3,2,Hopper,fair,2/12/26",
            "2: a day must be written as 2026-11-30",
        ),
        (
            "overrides.csv",
            "ada,01.3,two,Hopper,fair,2026-12-02",
            "2: points must be a number such as",
        ),
        ("requests.csv", "ada,01.3,2026-12-02,,", "2: column request is empty"),
        ("assignments.csv", "01,,,,,Least squares,", "2: a Canvas column has a name"),
        ("assignments.csv", "01,,,150,,,", "2: percent_per_day must be a number from 0 to 100"),
    ],
)
def test_a_bad_line_of_a_table_is_reported_with_its_number(name, line, message, tmp_path):
    """The error names the file, the line and the required form."""
    file = tmp_path / name
    file.write_text(",".join(HEADERS[name]) + "\n" + line)
    with pytest.raises(ValueError, match=rf"{name}:{message}"):
        READ[name](file)


# Optional questions


def with_optional(decisions=None, **changes):
    """A notebook of 01.1, the optional 01.2, and the optional 01.7 in words, which is open."""
    optional = [q | {"optional": True} for q in asked("01.2") + asked("01.7", kind="words")]
    questions = (*asked("01.1"), *(q | changes for q in optional))
    graded = [grade("01.1", 1.0), grade("01.2", 2.0)]
    return grade_sheets(results([record("ada", graded)], questions), decisions)[0]


def test_optional_questions_count_only_if_the_instructor_says_so():
    """The points stay visible; the sums, and what waits for a reader, contain the core alone."""
    plain = with_optional()
    assert [line.points for line in plain.lines] == [1, 2, 0]
    assert (plain.points, plain.possible, plain.waiting) == (1, 2, 0)
    counted = with_optional(Decisions({"01": Assignment("01", counts_optional=True)}))
    assert (counted.points, counted.possible, counted.waiting) == (3, 6, 1)
    same = with_optional(Decisions({"01": Assignment("01")}))
    assert (same.points, same.possible) == (plain.points, plain.possible)


def test_in_results_without_the_mark_every_question_counts():
    """Results of earlier versions do not say which questions are optional."""
    old = with_optional(optional=False)
    assert (old.points, old.possible, old.waiting) == (3, 6, 1)


def test_the_gradebook_names_the_optional_questions_that_do_not_count():
    header = gradebook_csv([with_optional()]).partition("\n")[0]
    assert "01.1 of 2," in header
    assert "01.2 of 2, optional" in header
    counted = with_optional(Decisions({"01": Assignment("01", counts_optional=True)}))
    assert "optional" not in gradebook_csv([counted]).partition("\n")[0]
    assert heading(with_optional().lines[1]) == "01.2 (optional, does not count)"
    assert heading(counted.lines[1]) == "01.2"


@pytest.mark.parametrize(("text", "counts"), [("", False), ("no", False), ("Yes", True)])
def test_the_table_of_assignments_says_whether_optional_questions_count(tmp_path, text, counts):
    file = tmp_path / "assignments.csv"
    file.write_text(f"notebook,optional\n02,{text}\n")
    assert read_assignments(file)["02"].counts_optional is counts
    file.write_text("notebook,optional\n02,perhaps\n")
    with pytest.raises(ValueError, match="yes or no"):
        read_assignments(file)
