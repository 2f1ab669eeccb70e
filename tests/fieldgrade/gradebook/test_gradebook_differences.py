"""Which grades changed between two gradings, and for which reasons."""

from dataclasses import replace
from datetime import date

import pytest

from fieldgrade.checking.results import write_results
from fieldgrade.class_folder.assignments import Assignment
from fieldgrade.class_folder.decisions import (
    ClassFolder,
    Decisions,
    Mark,
    save_decisions,
    saved_decisions,
)
from fieldgrade.class_folder.late_policy import LatePolicy, moment
from fieldgrade.class_folder.overrides import Override
from fieldgrade.gradebook.differences import (
    Difference,
    GradedState,
    compared,
    differences,
    to_table,
)
from gradebook_class import asked, grade, record, results

TIME = "2026-12-01T12:00:00Z"
WHO = Override("ada", "01.1", 1.0, "Hopper", "right but for a sign", date(2026, 12, 2))


def standing(points=2.0, decisions=None, *, made_by="0" * 64, possible=2.0, code="c", **whole):
    graded = replace(grade("01.1", points, possible), made_by=made_by)
    found = [record("ada", [graded], received=TIME), record("bob", [grade("01.1", 2.0)])]
    found[0] = replace(found[0], code=code)
    questions = asked("01.1", points=possible) + asked("01.7", kind="words")
    whole = {"grader": "g", "environment": "e"} | whole
    return GradedState(results(found, questions, **whole), decisions or Decisions())


BEFORE = standing()


@pytest.mark.parametrize(
    ("now", "points", "reasons"),
    [
        (standing(0.0, code="d"), 0, ["answer changed"]),
        (standing(0.0, made_by="1" * 64), 0, ["check changed"]),
        (standing(4.0, possible=4.0), 4, ["points changed"]),
        (standing(0.0, grader="h"), 0, ["grader changed"]),
        (standing(0.0, environment="f"), 0, ["packages changed"]),
        (standing(0.0, secret=True), 0, ["secret inputs"]),
        (standing(0.0), 0, ["no recorded change: other hidden inputs, or chance"]),
        (standing(0.0, code="d", grader="h"), 0, ["answer changed", "grader changed"]),
        (standing(2.0, Decisions(overrides=[WHO])), 1, ["override: right but for a sign"]),
        (standing(0.0, Decisions(overrides=[WHO])), 1, ["override: right but for a sign"]),
    ],
)
def test_a_changed_grade_is_reported_with_all_its_reasons(now, points, reasons):
    """Unchanged grades and unaffected students are not reported."""
    assert differences(BEFORE, now) == [Difference("ada", "01.1", 2, points, tuple(reasons))]


def test_equal_points_are_not_reported_as_a_difference():
    """Another check or grader that gives the same points makes no difference."""
    assert differences(BEFORE, standing(code="d", made_by="1" * 64, grader="h")) == []


def test_a_withdrawn_override_is_reported():
    """The points of the grader count again."""
    before = standing(decisions=Decisions(overrides=[WHO]))
    (found,) = differences(before, BEFORE)
    assert (found.before, found.now, found.reasons) == (1, 2, ("override withdrawn",))


def test_a_mark_for_an_ungraded_answer_is_reported():
    """The answer had no points before."""
    now = standing(decisions=Decisions(marks=[Mark("ada", "01.7", 1.5)]))
    assert differences(BEFORE, now) == [Difference("ada", "01.7", None, 1.5, ("marked",))]


def test_a_changed_deadline_is_reported_for_the_whole_notebook():
    """The late penalty is listed apart from the questions."""
    policy = LatePolicy(moment("2026-11-30T23:59Z"), per_day=0.25)
    now = standing(decisions=Decisions({"01": Assignment("01", policy)}))
    assert differences(BEFORE, now) == [
        Difference("ada", "01 late", 0, -0.5, ("deadline or extension changed",))
    ]


def test_new_and_withdrawn_submissions_are_reported():
    """A new notebook has no grades before, and a withdrawn one has none now."""
    alone = GradedState(replace(BEFORE.results, records=BEFORE.results.records[1:]), Decisions())
    (came,) = differences(alone, BEFORE)
    assert (came.before, came.now, came.reasons) == (None, 2, ("submitted",))
    (gone,) = differences(BEFORE, alone)
    assert (gone.before, gone.now, gone.reasons) == (2, None, ("withdrawn",))


def test_a_comparison_that_ignores_the_code_gives_another_reason(monkeypatch):
    """A mutant: without comparing the code, a changed answer would look like chance."""
    from fieldgrade.gradebook import differences as module

    monkeypatch.setattr(module, "_answer", lambda *_: [])
    (found,) = differences(BEFORE, standing(0.0, code="d"))
    assert found.reasons != ("answer changed",)


def test_regrading_is_compared_with_the_newest_results_of_the_history(tmp_path):
    """The history keeps the decisions that held at that time."""
    out, folder = tmp_path / "out", ClassFolder(tmp_path / "class")
    file = out / "results.json"
    folder.folder.mkdir()
    digest = {"code": "c" * 64, "grader": "a" * 64, "environment": "b" * 64}
    write_results(standing(**digest).results, file)
    save_decisions(out, folder)
    line = "ada,01.1,1,Hopper,fair,2026-12-02\n"
    (folder.folder / "overrides.csv").write_text("student,question,points,by,reason,on\n" + line)
    assert [d.reasons for d in compared(file, folder)] == [("override: fair",)]

    write_results(standing(0.0, **digest | {"grader": "d" * 64}).results, file)
    assert [(d.before, d.now) for d in compared(file, folder)] == [(2, 1)]
    save_decisions(out, folder)
    assert not saved_decisions(out / "history" / "0001.json").overrides
    assert len(saved_decisions(file).overrides) == 1

    write_results(standing(2.0, **digest).results, file)
    assert compared(file, folder) == [], "the override holds the grade, before and now"
    save_decisions(out, folder)
    assert len(saved_decisions(out / "history" / "0002.json").overrides) == 1
    first = compared(file, folder, out / "history" / "0001.json")
    assert [d.reasons for d in first] == [("override: fair",)]


def test_results_without_a_history_have_no_differences(tmp_path):
    digest = {"code": "c" * 64, "grader": "a" * 64, "environment": "b" * 64}
    write_results(standing(**digest).results, tmp_path / "results.json")
    assert compared(tmp_path / "results.json", ClassFolder(tmp_path / "class")) == []


def test_the_table_has_one_line_for_each_difference():
    text = to_table([Difference("ada", "01.1", None, 1.5, ("a", "b"))])
    assert text == "student,question,before,now,reasons\nada,01.1,,1.5,a; b\n"
