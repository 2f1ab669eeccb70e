"""A mistake in an earlier answer costs points once; a wrong answer that calls it is not excused."""

import json
from dataclasses import replace

import numpy as np
import pytest

from fieldcheck.questions import get, questions
from fieldcheck.verdict import Verdict
from fieldgrade.authoring import right_functions
from fieldgrade.authoring.build import all_sources
from fieldgrade.authoring.solution_calls import solution_calls
from fieldgrade.checking import grade_submission
from fieldgrade.checking.cache import keys
from fieldgrade.checking.check_results import CheckResult
from fieldgrade.checking.course import Course
from fieldgrade.checking.earlier_mistakes import with_given
from fieldgrade.checking.grade_submission import grade
from fieldgrade.checking.instructor_checks import answer_of_submission, given_functions
from fieldgrade.checking.results import Results, from_json, to_json
from fieldgrade.gradebook.explanations import explained
from fieldgrade.gradebook.grade_sheets import GradeLine
from fieldgrade.isolation import worker_servers
from fieldgrade.isolation.server import Limits, Server
from hostile.case import ROOT, Case

WRONG = "def basis_matrix(points):\n    return np.insert(points, 0, 2.0, axis=1)\n"
FIT = (
    "def fit(points, values):\n    b = basis_matrix(points)\n"
    "    return np.linalg.solve(b.T @ b, b.T @ values)\n"
)


@pytest.fixture(scope="module")
def course():
    return Course(all_sources(ROOT), "a salt")


@pytest.fixture(scope="module")
def server():
    with Server("none", Limits(seconds_per_cell=30.0)).started() as started:
        yield started


@pytest.fixture(scope="module")
def graded(course, server):
    """The grades of a notebook in which some answers are replaced, by question."""

    def grades(number="01", only=(), **answers):
        submission = Case("", number=number, answers=answers).submission({})
        record = grade(course, server, submission, only)
        assert from_json(json.loads(json.dumps(to_json(Results((record,)))))).records == (
            replace(record, seconds=0.0, cpu_seconds=0.0, peak=0),
        )
        return {grade.question: grade for grade in record.grades}

    return grades


def lost(grades):
    """The questions without all their points."""
    return [name for name, grade in grades.items() if grade.points < grade.possible]


@pytest.mark.slow
def test_a_mistake_costs_points_once_and_the_page_says_so(graded):
    """The three questions that call the wrong answer are graded with ours."""
    grades = graded(basis_matrix=WRONG)
    assert lost(grades) == ["01.1"]
    given = {name: grade.given for name, grade in grades.items() if grade.given}
    assert given == dict.fromkeys(("01.2", "01.3", "01.6"), ("01.1",))
    line = GradeLine("01.2", 3.0, 3.0, "checked", grade=grades["01.2"])
    assert explained(line).sentences == (
        "Graded with our 01.1, so that the mistake there costs points once.",
    )


@pytest.mark.slow
def test_a_wrong_answer_is_not_excused(graded):
    """Its own mistake is named, though the earlier one hid it in the first run."""
    sign = FIT.replace("return", "return -")
    normal = FIT.replace("b.T @ b,", "b.T @ b + np.eye(len(b.T)),")
    for fit in (sign, normal, "def fit(points, values):\n    return basis_matrix(points)\n"):
        grades = graded(basis_matrix=WRONG, fit=fit, only=("01.1", "01.2"))
        assert lost(grades) == ["01.1", "01.2"]
        assert not grades["01.2"].given


@pytest.mark.slow
def test_nothing_is_given_if_the_earlier_answers_are_right(graded, monkeypatch):
    """Not even asked for."""
    monkeypatch.setattr(grade_submission, "RightFunctions", None)
    assert lost(graded(fit=FIT.replace("return", "return -"))) == ["01.2"]
    assert lost(graded(rank="def rank(points):\n    return 0\n")) == ["01.4"]


@pytest.mark.slow
def test_an_answer_that_does_not_call_the_wrong_one_is_judged_by_itself(graded):
    grades = graded(
        basis_matrix=WRONG,
        fit="def fit(points, values):\n    return np.ones(points.shape[1] + 1)\n",
        only=("01.1", "01.2"),
    )
    assert lost(grades) == ["01.1", "01.2"]
    assert "with our" not in grades["01.2"].verdict.sentence


@pytest.mark.slow
@pytest.mark.parametrize(
    "earlier",
    [
        "pass",
        "def basis_matrix(points):\n    raise NotImplementedError\n",
        "def basis_matrix(points):\n    return 1 / 0\n",
        "basis_matrix = 7",
        "def basis_matrix(points):\n    points *= 0\n    return np.insert(points, 0, 1, axis=1)\n",
    ],
)
def test_the_earlier_answer_may_be_missing_or_stop(graded, earlier):
    """Or change its argument."""
    assert lost(graded(basis_matrix=earlier, only=("01.1", "01.2"))) == ["01.1"]


@pytest.mark.slow
def test_one_question_alone_gets_the_same_grade(graded):
    """Its earlier questions are graded, too, to know whether they are wrong."""
    alone = graded(basis_matrix=WRONG, only=("01.2",))
    assert [*alone] == ["01.2"]
    assert (alone["01.2"].points, alone["01.2"].given) == (3.0, ("01.1",))


@pytest.mark.slow
def test_in_a_chain_only_the_wrong_answer_is_replaced(graded):
    """The answers between are the student's own."""
    grades = graded("07", area="def area(*corners):\n    return 1.0\n")
    assert lost(grades) == ["07.3"]
    assert grades["07.7"].given == ("07.3",)
    wrong_between = "def weights(corners, x):\n    return np.ones((len(x), len(corners)))\n"
    grades = graded("07", area="def area(*corners):\n    return 1.0\n", weights=wrong_between)
    assert lost(grades) == ["07.3", "07.4"]
    assert grades["07.7"].given == ("07.4",)


@pytest.mark.slow
def test_a_slow_earlier_answer_costs_points_once(graded, monkeypatch):
    hasty = {name: replace(get(name), limit=0.2) for name in ("01.1", "01.2")}
    monkeypatch.setattr(Course, "asked", lambda *_: [*hasty.values()])
    # on a busy machine, too, the answer is slow, and not stopped
    monkeypatch.setattr("fieldgrade.checking.grade_submission.TIMEOUT_FACTOR", 100.0)
    busy = "    end = time.process_time() + 0.25 * (next(CALLS) % 4 == 0)\n"
    busy += "    while time.process_time() < end: pass\n"
    slow = f"import itertools, time\nCALLS = itertools.count()\ndef basis_matrix(points):\n{busy}"
    grades = graded(basis_matrix=f"{slow}    return np.insert(points, 0, 1.0, axis=1)\n")
    assert [grade.verdict.finding for grade in grades.values()] == ["slow", "right"]


def test_the_functions_that_a_solution_calls_are_found_in_its_code(course):
    """Also through other answers, but not attributes of the same name."""
    assert course.given("12.8") == ("12.1", "12.2", "12.7")
    assert course.given("07.7") == ("07.3", "07.4", "07.5")
    assert course.given("01.1") == ()
    functions = {}
    code = "import numpy as np\ndef fit(p, v): return np.rank, v.basis_matrix\n"
    exec(f"{code}def basis_matrix(p): pass\n", functions)
    assert solution_calls(get("01.2"), functions) == ()


def test_a_question_may_name_further_earlier_questions(course, monkeypatch):
    """A right answer may call what the solution does not."""
    from fieldgrade.checking import course as module

    named = {**questions(), "12.11": replace(get("12.11"), may_call=("12.2",))}
    monkeypatch.setattr(module, "questions", lambda: named)
    module._given.cache_clear()
    assert course.given("12.11") == ("12.2",)
    module._given.cache_clear()


def test_a_change_of_an_earlier_check_makes_later_results_out_of_date(course, server, monkeypatch):
    """Whether a right function is given depends on it."""
    submission = Case("").submission({})
    before = {q: keys(course, server, submission, q) for q in ("01.2", "01.5")}
    of = Course.made_by
    monkeypatch.setattr(Course, "made_by", lambda c, q: "new" if q == "01.1" else of(c, q))
    assert keys(course, server, submission, "01.2") != before["01.2"]
    assert keys(course, server, submission, "01.5") == before["01.5"]


def result(finding, sentence, check="public cases"):
    return CheckResult(Verdict("01.2", finding, sentence, call=0), check, returned=({},))


OURS = "It is not right, and with our 01.1 in place of yours it is not right either."


@pytest.mark.parametrize(
    ("first", "again", "finding", "sentence"),
    [
        (
            result("wrong", "First."),
            result("misconception", "Known."),
            "misconception",
            "Known.",
        ),
        (result("misconception", "Of 01.1."), result("wrong", "Value 7."), "wrong", OURS),
        (result("wrong", "First."), result("wrong", "Value 7."), "wrong", "First."),
        (result("wrong", "First."), result("wrong", "7.", "own inputs"), "wrong", OURS),
        (result("exception", "First."), result("exception", "7."), "exception", "First."),
        (result("unwritten", "First."), result("shape", "7."), "wrong", OURS),
        (result("slow", "First."), result("slow", "7 s."), "slow", "First."),
        (result("slow", "First."), result("wrong", "7."), "slow", "First."),
        (result("slow", "First."), result("misconception", "Known."), "slow", "First."),
    ],
)
def test_no_word_of_the_second_run_is_shown_if_it_is_wrong(first, again, finding, sentence):
    """Except a sentence of the catalogue, which no value can change."""
    (found,) = with_given({"public cases": first}, {"public cases": again}, ["01.1"]).values()
    assert (found.verdict.finding, found.verdict.sentence) == (finding, sentence)
    assert found.given == ()
    assert "7" not in found.verdict.sentence
    assert found.returned == (first.returned if sentence == "First." else ())


def test_of_a_right_second_run_only_the_outcome_is_kept():
    """A slow one has a sentence of ours, without the time."""
    first = {"public cases": result("wrong", "First.")}
    again = {"public cases": result("right", "Value 7."), "own inputs": result("slow", "7 s.")}
    one, other = with_given(first, again, ["01.1"]).values()
    assert (one.verdict, other.verdict.finding) == (Verdict("01.2", "right", ""), "slow")
    assert "7" not in repr((one, other))
    assert one.given == other.given == ("01.1",)


def test_the_limits_leave_room_for_honest_answers():
    """The solutions make 900 calls at most, with 3 kB of arguments."""
    assert right_functions.MOST_CALLS >= 10 * 900
    assert right_functions.MOST_BYTES >= 50 * 3000


@pytest.mark.slow
def test_checks_of_instructors_give_the_same_functions(course, server, graded):
    """An answer that was paid with ours is not failed by a check with the student's own."""
    submission = Case("", answers={"basis_matrix": WRONG}).submission({})
    points, values = np.array([[0.0], [1.0], [3.0]]), np.array([1.0, 3.0, 7.0])
    grades = graded(basis_matrix=WRONG, only=("01.1", "01.2"))
    with worker_servers.serving():
        alone = answer_of_submission(server, submission)
        ours = answer_of_submission(server, submission, given_functions(course, grades["01.2"]))
        np.testing.assert_allclose(ours("01.2", points, values), [1.0, 2.0], atol=1e-12)
        np.testing.assert_allclose(alone("01.2", points, values), [0.5, 2.0], atol=1e-12)
        assert (ours("01.1", points) == alone("01.1", points)).all()
    assert given_functions(course, grades["01.1"]) == {}
