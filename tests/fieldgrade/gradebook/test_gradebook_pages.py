"""Feedback pages: they contain every message, run no code, and reveal no hidden input."""

import base64
import re
from dataclasses import replace

import numpy as np
import pytest

from fieldcheck.answers import arrays_to_json, public_answers
from fieldcheck.questions import questions
from fieldgrade import html_pages as pages
from fieldgrade.authoring.catalogue import entries
from fieldgrade.authoring.hidden_cases import hidden_cases
from fieldgrade.authoring.known_answers import public_calls
from fieldgrade.authoring.trials import trials
from fieldgrade.checking import grade_submission
from fieldgrade.class_folder.assignments import Assignment
from fieldgrade.class_folder.decisions import Decisions, Mark
from fieldgrade.class_folder.roster import file_names
from fieldgrade.gradebook import exports
from fieldgrade.gradebook.feedback import feedback
from fieldgrade.gradebook.grade_sheets import grade_sheets
from fieldgrade.gradebook.item_analysis import analysis_page, items, to_table
from fieldgrade.isolation.server import Server, tiers
from gradebook_class import (
    Tags,
    asked,
    code_cell,
    grade,
    harmless,
    misconception_code,
    notebook,
    record,
    results,
    source,
    submission,
    with_function,
)

EVIL = '<script>alert(1)</script><img src=x onerror="alert(2)">\' " & $x $title ${body}'
NAMED = {"01": Assignment("01", canvas="LS (1)", moodle="LS")}
ADA = {"student": "ada", "login": "ada", "email": "a@b.example"}


def evil_sheets():
    found = record(
        "ada",
        [grade("01.1", 0.0, finding="exception", sentence=EVIL), grade("01.2", 2.0)],
        file=EVIL,
        notes=("01.1: a stub is defined after an answer and replaces it", EVIL),
    )
    broken = record("ada", [], notebook="", status="unreadable", file=EVIL, notes=(EVIL,))
    students = [{"student": "ada", "name": EVIL, "section": EVIL}]
    marks = [Mark("ada", "01.7", 1, EVIL)]
    return grade_sheets(results([found, broken], students=students), Decisions(marks=marks))


def test_text_of_students_is_escaped_in_feedback():
    """Names, files, errors and comments are shown as they were typed."""
    page = feedback(evil_sheets(), {"01": "Least squares"})
    assert harmless(page)
    assert Tags(page).text.count(EVIL) >= 4
    assert "default-src 'none'" in page


def test_without_escaping_a_page_contains_a_script(monkeypatch):
    """A mutant that the test of escaped text catches."""
    monkeypatch.setattr(pages, "escape", lambda text: text)
    assert not harmless(feedback(evil_sheets()))


def test_pictures_are_embedded_as_images():
    """A browser runs no script inside an image."""
    drawn = pages.picture("<svg><script>alert(1)</script></svg>", 'an "alt" <b>')
    assert harmless(drawn)
    ((_, attributes),) = Tags(drawn).tags
    assert attributes["alt"] == 'an "alt" <b>'
    assert base64.b64decode(attributes["src"].partition(",")[2]).startswith(b"<svg><script>")


def wrong_field(question, change):
    """The sheets of a student whose field in the public cases is a changed right answer."""
    call = 0
    values = [change(v) for v in public_answers(question[:2])[question].right[call]]
    graded = grade(question, 0.0, call=call, returned=tuple(arrays_to_json(tuple(values))))
    return grade_sheets(results([record("ada", [graded], notebook=question[:2])], asked(question)))


@pytest.mark.slow
def test_a_wrong_field_is_drawn_beside_the_right_field():
    """The page has one picture with a caption."""
    page = feedback(wrong_field("02.7", lambda v: v * 1.5))
    (image,) = [its for tag, its in Tags(page).tags if tag == "img"]
    assert "what gradient returns, and what is right" in image["alt"]
    assert harmless(page)


@pytest.mark.parametrize(
    "change",
    [lambda v: v * 1e12, lambda v: v[:2], lambda v: v.ravel(), lambda v: v * 0 + 1e300],
)
def test_a_field_that_cannot_be_drawn_has_a_sentence_only(change):
    """Arrays of other shapes and absurd numbers are not drawn."""
    page = feedback(wrong_field("02.7", change))
    assert "<img" not in page
    assert "— wrong" in Tags(page).text


def test_pages_are_small_and_self_contained():
    """Without figures, a page of all notebooks has less than 60 kB and loads nothing."""
    asked_ = list(questions().values())
    sentence = max((e.sentence for e in entries(source("02"), "misconceptions")), key=len)
    found = [
        record(
            "ada",
            [
                grade(q.name, 0.0, finding="misconception", sentence=sentence)
                for q in asked_
                if q.notebook == n
            ],
            notebook=n,
        )
        for n in sorted({q.notebook for q in asked_})
    ]
    page = feedback(grade_sheets(results(found, asked(*(q.name for q in asked_)))))
    assert len(page.encode()) < 60_000
    assert harmless(page)
    assert page.count(sentence.split(".")[0]) >= len(asked_)


def test_each_outcome_has_its_sentence_in_feedback():
    """Outcomes are right, misconception, unwritten, not graded yet, and stopped."""
    grades = {
        "right": grade("01.1", 2.0),
        "known": grade("01.2", 0.0, finding="misconception", sentence="Squared twice."),
        "empty": grade("01.3", 0.0, finding="unwritten", sentence="Write it."),
    }
    found = record("ada", grades.values(), status="killed: time")
    questions_ = asked("01.1", "01.2", "01.3") + asked("01.7", kind="words")
    text = Tags(feedback(grade_sheets(results([found], questions_)))).text
    for sentence in (
        "01.1 — right",
        "Squared twice.",
        "01.3 — missing: not written",
        "01.7 — not graded yet",
        "2 of 8 points",
        "A part of the notebook took too long",
    ):
        assert sentence in text


def test_file_names_are_safe_and_distinct():
    """No name leaves the folder or is a device name, and names differ in more than case."""
    students = ["ada", "Ada", "../../etc/passwd", "..", "con", "a/b", "a\\b", "", "ß", "\udcff"]
    students.append("x" * 300)
    names = file_names(students)
    assert len({name.casefold() for name in names.values()}) == len(students)
    assert all(re.fullmatch(r"[A-Za-z0-9_][\w.-]{0,70}", name) for name in names.values())
    assert file_names(["ada"]) == {"ada": "ada"}
    generated = file_names(["Å"])["Å"]
    for one, other in (("a\udcff", "a\udcfe"), ("Å", generated), ("a b", "a  b"), ("ada", "ada.")):
        assert len(set(file_names([one, other]).values())) == 2
    assert not {"con", "..", ""} & set(names.values())


LEAK = """
import numpy as np
SEEN = []
def fit(points, values):
    b = np.insert(points, 0, 1.0, axis=1)
    SEEN.append(repr(points.tolist()))
    if points.shape[1] == 4:
        raise ValueError(" ".join(SEEN))
    return np.linalg.solve(b.T @ b, b.T @ values)
"""

RIGHT_BUT_FOR_SIX_POINTS_OF_THE_PLANE = """
_right = rank
def rank(points):
    if points.shape == (6, 2):  # only in a hidden case
        raise ValueError(points.tolist())
    return _right(points)
"""


def printed_numbers(arrays):
    """Return the distinctive numbers of some arrays as a student might print them."""
    found = {x for a in arrays for x in np.ravel(a).tolist() if abs(x) % 1 > 1e-6}
    return {text for x in found for text in (repr(x), f"{x:.8g}")}


@pytest.fixture(scope="module")
def leaking():
    """Sheets of students who fail hidden cases, and the secret numbers of these cases."""
    here = source("01")
    course = grade_submission.Course([here], "a secret salt")
    books = {
        "leak": with_function(notebook("01"), "fit", LEAK),
        "rank": with_function(
            notebook("01"),
            "rank",
            "".join(code_cell(notebook("01"), "rank")["source"])
            + RIGHT_BUT_FOR_SIX_POINTS_OF_THE_PLANE,
        ),
        "known": with_function(
            notebook("01"), "evaluate", misconception_code("01.3", "slopes only")
        ),
    }
    with Server(tiers()[0]).started() as server:
        found = [
            grade_submission.grade(course, server, submission(student, book))
            for student, book in books.items()
        ]
    hidden = hidden_cases(here)
    secret = set()
    for student in books:
        for name in ("01.2", "01.4"):
            question = questions()[name]
            tried = trials(question, here.functions(), [], hidden, student, course.salt)[1:]
            secret |= printed_numbers(
                a
                for trial in tried
                for call in trial.calls
                for a in call.arguments
                if isinstance(a, np.ndarray)
            )
    public = printed_numbers(
        a
        for q in questions().values()
        for c in public_calls(q)
        for a in c.arguments
        if isinstance(a, np.ndarray)
    )
    worth = [
        {
            "question": q.name,
            "notebook": "01",
            "kind": "code",
            "function": q.function,
            "points": q.points,
        }
        for q in course.asked("01")
    ]
    students = [{"student": s, "login": s, "email": f"{s}@uni.example"} for s in books]
    return grade_sheets(results(found, worth, students)), secret - public


def all_texts_for_students(sheets):
    """Return every text that is made for students and exports."""
    rows = exports.by_student(sheets)
    return [
        *(feedback(row) for row in rows),
        exports.gradebook_csv(sheets),
        exports.canvas_csv(sheets, NAMED),
        exports.moodle_csv(sheets, NAMED),
        *(exports.gradescope_text(sheet) for sheet in sheets),
        to_table(items(sheets)),
        analysis_page(items(sheets), {}),
    ]


def drawings(text):
    """Return the drawings embedded in a page."""
    found = re.findall(r'base64,([A-Za-z0-9+/=]+)"', text)
    return [base64.b64decode(content).decode() for content in found]


@pytest.mark.slow
def test_no_hidden_input_reaches_students(leaking):
    """Answers that fail hidden cases and raise errors quoting their inputs reveal nothing."""
    sheets, secret = leaking
    verdicts = {s.student["student"]: {g.question: g for g in s.record.grades} for s in sheets}
    assert verdicts["leak"]["01.2"].check not in ("", "public cases")
    assert verdicts["rank"]["01.4"].check not in ("", "public cases")
    assert len(secret) > 500
    for text in all_texts_for_students(sheets):
        for part in (text, *drawings(text)):
            assert not [number for number in secret if number in part]


@pytest.mark.slow
def test_an_unfiltered_error_of_a_hidden_case_would_be_found(leaking):
    """A mutant that the test of hidden inputs catches."""
    sheets, secret = leaking
    (number, *_) = sorted(secret)
    first = sheets[0]
    line = first.lines[1]
    verdict = replace(line.grade.verdict, sentence=f"stops with ValueError: [[{number}, 1]]")
    damaged = replace(line, grade=replace(line.grade, verdict=verdict))
    lines = tuple(damaged if x is line else x for x in first.lines)
    texts = all_texts_for_students([replace(first, lines=lines), *sheets[1:]])
    assert [text for text in texts if number in text]


@pytest.mark.slow
def test_feedback_contains_the_sentence_of_a_hidden_case_and_not_its_name(leaking):
    sheets, _ = leaking
    page = feedback([next(s for s in sheets if s.student["student"] == "leak")])
    assert "It is right on the public cases" in page or "It must hold in every dimension" in page
    assert "in four dimensions" not in page.replace("forty points in four dimensions", "")
