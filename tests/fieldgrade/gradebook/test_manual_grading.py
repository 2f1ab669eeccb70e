"""Manual grading: pages that show written answers, and tables that keep every entered mark."""

import re

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldgrade.class_folder.decisions import Decisions
from fieldgrade.class_folder.manual_grading import (
    NOTHING,
    Mark,
    answer_digest,
    marking_page,
    read_marks,
    update_table,
    written_questions,
)
from fieldgrade.gradebook.grade_sheets import grade_sheets
from fieldgrade.html_pages import with_formulas
from fieldgrade.submissions.written_answers import written_answers
from gradebook_class import (
    Tags,
    asked,
    harmless,
    notebook,
    record,
    results,
    source,
    submission,
)

names = st.text(st.characters(codec="utf-8", exclude_categories=["Cc", "Cs", "Z"]), min_size=1)


@pytest.fixture
def file(tmp_path):
    return tmp_path / "01.7.csv"


def test_marks_in_the_table_reach_the_grade_sheets(file):
    """An unanswered question has zero points without a reader."""
    assert update_table(file, {"ada": "My words.", "bob": "", "cy": "Mine."}) == []
    text = file.read_text()
    assert text == (
        "student,points,comment,answer\n"
        f"ada,,,{answer_digest('My words.')}\nbob,0,{NOTHING},\ncy,,,{answer_digest('Mine.')}\n"
    )
    file.write_text(text.replace("ada,,,", 'ada,"1,5",good,'))
    marks = read_marks(file.parent)
    assert marks == [Mark("ada", "01.7", 1.5, "good"), Mark("bob", "01.7", 0.0, NOTHING)]
    everybody = [record(name, []) for name in ("ada", "bob", "cy")]
    found = grade_sheets(results(everybody, asked("01.7", kind="words")), Decisions(marks=marks))
    assert [(s.lines[0].points, s.lines[0].how) for s in found] == [
        (1.5, "read"),
        (0, "read"),
        (0, "open"),
    ]


@settings(max_examples=30)
@given(st.lists(names, min_size=1, unique_by=str.strip), st.integers(0, 5))
def test_updating_a_table_keeps_its_lines(tmp_path_factory, students, split):
    """Existing lines keep their bytes, and each student has one line, whatever the name."""
    file = tmp_path_factory.mktemp("m") / "01.7.csv"
    first, later = students[:split], students[split:]
    update_table(file, dict.fromkeys(first, "words"))
    entered = file.read_bytes().replace(b",,,", b",1.25,fine,", 1)
    file.write_bytes(entered)
    for _ in range(2):
        update_table(file, dict.fromkeys([*first, *later], "words"))
        assert file.read_bytes().startswith(entered)
    assert len(file.read_text().splitlines()) == 1 + len(students)


def test_a_table_saved_by_a_spreadsheet_keeps_its_format(file):
    """Semicolons, another order of columns, and a missing final newline are accepted."""
    file.write_bytes(b"points;student\r\n1,5;ada")
    assert update_table(file, {"bob": "words", "ada": "x"}) == []
    assert file.read_bytes() == b"points;student\r\n1,5;ada\n;bob\n"
    assert read_marks(file.parent) == [Mark("ada", "01.7", 1.5)]


def test_a_changed_answer_is_reported_to_the_marker(file):
    """Points given for the previous answer stay, and the student is reported."""
    update_table(file, {"ada": "first", "bob": "", "cy": "unread"})
    file.write_text(file.read_text().replace("ada,,", "ada,2,"))
    before = file.read_bytes()
    assert update_table(file, {"ada": "second", "bob": "now something", "cy": "other"}) == [
        "ada",
        "bob",
    ]
    assert file.read_bytes() == before


def test_an_invalid_table_is_reported_and_not_changed(file):
    file.write_text("student,points,comment\nada,many,\n")
    with pytest.raises(ValueError, match=r"01.7.csv:2: points must be a number such as 1.5"):
        update_table(file, {"bob": "words"})
    assert file.read_text() == "student,points,comment\nada,many,\n"


@pytest.mark.slow
def test_the_marking_page_has_rubric_model_answer_and_all_answers():
    """Formulas are rendered, and other markup in the answers of students is not interpreted."""
    question = next(q for q in written_questions(source("01")) if q.name == "01.7")
    evil = 'My $x$ <script>alert(1)</script> [link](http://evil) ![](http://evil/i.png)\n  "q"'
    marks = {"ada": Mark("ada", "01.7", 2, "nearly <b>")}
    page = marking_page(question, {"<i>ada": evil, "ada": "words", "bob": ""}, marks)
    assert "How it is graded" in page
    assert "A model answer" in page
    assert "<math" in page
    assert page.count("&lt;script&gt;alert(1)&lt;/script&gt; [link](http://evil)") == 2
    for forbidden in ("<script", "<i>ada", 'href="http', 'src="http', "nearly <b>"):
        assert forbidden not in page
    assert "2 answers" in page
    assert "Nothing written: bob." in page
    assert "2 of 3" in page
    assert "2 of 3, changed since then" in marking_page(question, {"ada": "x"}, marks, ["ada"])


HOSTILE = [
    r"$\href{javascript:alert(1)}{x}$",
    r"$\text{<script>alert(1)</script>}$",
    "$<b>$ </math><b>",
    r"$\includegraphics{http://evil/x}$",
    "$" + "{" * 400 + "$",
    "a $ b $ c",
    "$$\n\\x\n$$",
    "<img src=x onerror=alert(1)>",
    "\0",
    "\ud800",
    "# no heading\n* no list\n`no code`",
    "<!-- next -->",
    "$<!-- next -->$",
]


@pytest.mark.parametrize("text", HOSTILE)
def test_markup_in_answers_of_students_is_not_interpreted(text):
    """No text, between dollar signs or outside, becomes an active HTML element."""
    (html,) = with_formulas([text])
    assert harmless(html)
    assert not {tag for tag, _ in Tags(html).tags} & {"a", "b", "img", "h1", "ul", "code"}


def test_an_invalid_formula_does_not_affect_other_answers():
    """Each text has its own HTML, in order."""
    found = with_formulas([*HOSTILE, "so $x^2$ holds", "last"])
    assert len(found) == len(HOSTILE) + 2
    assert "<msup><mi>x</mi><mn>2</mn></msup>" in found[-2]
    assert Tags(found[-1]).text.strip() == "last"
    assert with_formulas([]) == []


def test_line_breaks_follow_markdown():
    """A single newline is a space; empty lines and lists are kept."""
    (html,) = with_formulas(["one\ntwo\n\nthree:\n- a\n  1) b"])
    breaks = re.sub(r"\s*<br />\s*", "|", html).replace("\n", " ").strip()
    assert breaks == "<p>one two||three:|- a|1) b</p>"


def test_a_dollar_sign_before_a_space_is_not_a_formula():
    assert "<math" not in with_formulas(["from $ 5 to $ 6"])[0]


def test_written_answers_are_found_under_their_questions():
    """The model answers are found in the solved notebook; the empty notebook has none."""
    asked_ = [question.name for question in written_questions(source("01"))]
    solved = written_answers(submission("ada", notebook("01")), asked_)
    assert set(solved) == set(asked_)
    assert written_answers(submission("ada", notebook("01", "exercises")), asked_) == {}
