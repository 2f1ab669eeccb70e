"""Each lost point is explained in words that fit a graded page."""

import re
from typing import get_args

import pytest

from checkout import ROOT
from fieldcheck.calls import Outcome
from fieldcheck.judge import judge
from fieldcheck.questions import questions
from fieldcheck.verdict import Finding
from fieldgrade.authoring.build import all_sources
from fieldgrade.authoring.known_answers import public_calls
from fieldgrade.authoring.sources import IN_WORDS
from fieldgrade.authoring.trials import OWN, PUBLIC
from fieldgrade.checking.results import Grade
from fieldgrade.class_folder.decisions import Decisions, Mark
from fieldgrade.class_folder.overrides import Override
from fieldgrade.gradebook.explanations import NOT_YET, OUTCOMES, explained, heading, summary
from fieldgrade.gradebook.feedback import feedback
from fieldgrade.gradebook.grade_sheets import GradeLine, grade_sheets
from fieldgrade.isolation.process import CellError
from fieldgrade.sandbox.missing import Missing
from gradebook_class import Tags, asked, grade, harmless, record, results

FIT = questions()["01.2"]
OF_NOTEBOOKS = re.compile(r"\b(run (its|the) cell|this one again|yet\b|rung|ladder)", re.IGNORECASE)
"""Words that fit a notebook, or that no page contains."""


def explanation(check=PUBLIC, **outcome):
    """The explanation of an answer to 01.2 whose first call has this outcome."""
    calls = public_calls(FIT)
    verdict = judge(FIT, calls, [Outcome(**outcome)] * len(calls))
    found = Grade("01.2", 0.0, 3.0, verdict, check)
    return verdict, explained(GradeLine("01.2", 0.0, 3.0, "checked", "", found, "The fit", "fit"))


@pytest.mark.parametrize(
    ("outcome", "words", "sentence"),
    [
        ({"status": "missing"}, "missing", "there was no function fit"),
        ({"status": "unwritten"}, "missing: not written", "without an answer in it"),
        ({"status": "raised", "error": "KeyError: 1"}, "stopped by an error", "with KeyError: 1."),
        ({"status": "timed out", "seconds": 20.0}, "too slow: stopped", "after 20 seconds"),
        ({"status": "returned"}, "wrong: not the requested kind of value", "It should be"),
    ],
)
def test_a_lost_point_is_wrong_missing_stopped_or_too_slow(outcome, words, sentence):
    """The notebook's sentence is replaced where it tells the student to run a cell."""
    _, found = explanation(**outcome)
    assert found.outcome == words
    assert sentence in " ".join(found.sentences)
    assert not OF_NOTEBOOKS.search(" ".join(found.sentences))


def test_the_students_own_line_is_quoted():
    """The line at which an error arose is separated from the sentence, whatever it contains."""
    line = 'line 3 of fit: raise KeyError("It arises in line 9 of x: y.")'
    error = 'KeyError: "It arises in line 9 of x: y."'
    _, found = explanation(status="raised", error=error, line=line)
    assert found.sentences[1] == "The error arises in line 3 of fit:"
    assert found.code == 'raise KeyError("It arises in line 9 of x: y.")'
    _, found = explanation(status="raised", error="KeyError: 1", line="line 3 of fit")
    assert (found.sentences[1], found.code) == ("The error arises in line 3 of fit.", "")


@pytest.mark.parametrize("check", [OWN, "in four dimensions"])
def test_an_error_in_a_hidden_case_is_named_without_its_input(check):
    """The sentence of the hidden case alone does not say that the function stopped."""
    for finding, words in (("exception", "stops with an error"), ("slow", "takes too long")):
        found = grade("01.2", 0.0, finding=finding, sentence="Any dimension counts.", check=check)
        outcome, sentences, code = explained(GradeLine("01.2", 0, 2, "checked", grade=found))
        assert words in sentences[0]
        assert sentences[1:] == ("Any dimension counts.",)
        assert (outcome, code) == (OUTCOMES[finding], "")


def test_every_outcome_has_words_without_private_vocabulary():
    """A wrong answer is called wrong, missing, stopped or too slow."""
    assert set(OUTCOMES) == set(get_args(Finding))
    words = re.compile("wrong|missing|stopped by an error|too slow|right$")
    assert all(words.search(text) for text in OUTCOMES.values())
    assert not OF_NOTEBOOKS.search(" ".join(OUTCOMES.values()))


def test_every_question_has_a_title():
    """The titles are the headings of the notebook; a written answer may have none."""
    titles = {q: t for s in all_sources(ROOT) for q, t in s.question_titles.items()}
    text = (ROOT / "solutions" / "01_least_squares.py").read_text(encoding="utf-8")
    assert titles["01.4"]
    assert titles["01.4"] in text
    assert titles["01.7"] == IN_WORDS
    written = {question for s in all_sources(ROOT) for question in s.written_points}
    assert set(titles) == {*questions(), *written}


def test_a_page_names_questions_and_shows_errors_of_cells():
    """The page has the title of each question, and the errors of the cells as they are."""
    error = CellError(3, "NameError: name 'np' <b> is not defined", 2, "np.ones(1) < 2")
    found = record(
        "ada",
        [grade("01.1", 2.0), grade("01.2", 0.0)],
        notes=("a note for the instructor",),
        cell_errors=(error,),
        missing=Missing(("pandas",), ("data.csv",), ("Arial",)),
    )
    questions_ = asked("01.1", title="The matrix") + asked("01.2", title="The fit <i>")
    page = feedback(grade_sheets(results([found], questions_)))
    text = Tags(page).text
    assert harmless(page)
    for part in (
        "01.1 The matrix — right",
        "01.2 The fit <i> — wrong",
        "Code cell 3, line 2: np.ones(1) < 2 — NameError: name 'np' <b> is not defined",
        "Modules that were not available where the notebook ran: pandas.",
        "Files that were not found where the notebook ran: data.csv.",
        "Fonts of figures that were not installed where the notebook ran, which costs no points: A",
    ):
        assert part in text
    assert found.notes[0] not in text
    assert not OF_NOTEBOOKS.search(text.partition("</style>")[2])


def test_a_page_names_no_other_student():
    """A file name that claims another student is refused, and only the instructor reads whom."""
    claim = "its name can be read as that of ada and of bob: the file must have another name"
    broken = record("ada", [], notebook="", status="unreadable", file="x.ipynb", notes=(claim,))
    notes = (f"y.ipynb is not graded: {claim}", "the files of ada and of bob count for ada")
    found = record("ada", [grade("01.1", 2.0)], notes=notes)
    text = Tags(feedback(grade_sheets(results([found, broken])))).text
    assert text.count("can be read as that of another student: the file must have") == 2
    assert "bob" not in text


def test_decisions_of_people_are_explained():
    """A mark and an override show the points and the comment, and what the grader found."""
    decided = Decisions(
        marks=[Mark("ada", "01.7", 1, "Half of it.")],
        overrides=[Override("ada", "01.2", 1, "Hopper", "A typing error.", None)],
    )
    (sheet,) = grade_sheets(results([record("ada", [grade("01.2", 0.0)])]), decided)
    assert [explained(line)[:2] for line in sheet.lines] == [
        (NOT_YET, ()),
        ("wrong", ("Points set by the staff: A typing error.",)),
        ("right in part", ("Half of it.",)),
    ]
    assert summary(sheet)[-1] == "01.7: right in part (1 of 2). Half of it."


def test_a_heading_without_a_title_is_the_number():
    """Results of other origin may have no titles."""
    assert heading(GradeLine("01.2", 0, 2, "open")) == "01.2"
