"""A right function that calls a wrong earlier answer is not blamed; wrong code is not excused."""

from dataclasses import replace
from pathlib import Path
from types import ModuleType

import pytest

import fieldcheck
from fieldcheck import notebook
from fieldcheck.earlier_answers import (
    called_by,
    earlier_questions,
    explained_by_earlier,
    in_place_of,
)
from fieldcheck.questions import get, questions
from fieldcheck.verdict import Verdict
from fieldgrade.authoring.catalogue import entries
from fieldgrade.authoring.sources import Source, sources
from fieldgrade.grader_validation import inherited_mistakes

SOURCES = {source.number: source for source in sources(Path(__file__).parents[2] / "solutions")}

BASIS = """
import numpy as np

def basis_matrix(points):
    return np.insert(points, 0, 1.0, axis=1)
"""
WRONG_BASIS = BASIS.replace("1.0", "2.0")
FIT = """
def fit(points, values):
    b = basis_matrix(points)
    return np.linalg.solve(b.T @ b, b.T @ values)
"""
WRONG_FIT = FIT.replace("return", "return -")
FIRST = "First correct 01.1 (function `basis_matrix`), which fit calls."


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """A working folder for the progress of the student."""
    monkeypatch.chdir(tmp_path)


def cells(*codes):
    """The namespace of a notebook after its cells have run."""
    namespace = {}
    for code in codes:
        exec(code, namespace)
    return namespace


def test_right_code_is_told_to_wait_for_the_earlier_answer():
    """The sentence names the question and the function, and no mistake of the answer."""
    verdict = fieldcheck.check("01.2", cells(WRONG_BASIS, FIT))
    assert (verdict.finding, verdict.sentence) == ("inherited", FIRST)
    assert verdict.credit == 0
    assert "case()" not in verdict._repr_html_()
    assert "· waits" in repr(fieldcheck.progress())


@pytest.mark.slow
def test_wrong_code_is_not_excused():
    """Its own mistake is reported if it calls no wrong answer, and once that one is corrected."""
    assert "opposite sign" in fieldcheck.check("01.2", cells(BASIS, WRONG_FIT)).sentence
    assert fieldcheck.check("01.2", cells(WRONG_BASIS, WRONG_FIT)).sentence == FIRST
    alone = WRONG_FIT.replace("basis_matrix(points)", "np.insert(points, 0, 1.0, axis=1)")
    assert "opposite sign" in fieldcheck.check("01.2", cells(WRONG_BASIS, alone)).sentence


def test_right_code_with_a_wrong_answer_that_it_does_not_call_is_right():
    alone = FIT.replace("basis_matrix(points)", "np.insert(points, 0, 1.0, axis=1)")
    assert fieldcheck.check("01.2", cells(WRONG_BASIS, alone)).right


def test_only_calls_in_the_failing_case_count():
    """The earlier answer is called, but not where the values are wrong."""
    only_right_there = """
def fit(points, values):
    if len(points) == NUMBER:
        basis_matrix(points)
        return np.linalg.lstsq(np.insert(points, 0, 1.0, axis=1), values, rcond=None)[0]
    return np.ones(points.shape[1] + 1)
"""
    numbers = [len(call.arguments[0]) for call in get("01.2").inputs(0)]
    once = next(n for n in numbers if numbers.count(n) == 1)
    code = only_right_there.replace("NUMBER", str(once))
    assert fieldcheck.check("01.2", cells(WRONG_BASIS, code)).finding == "wrong"


@pytest.mark.parametrize(
    ("earlier", "word"),
    [
        ("import numpy as np", "write"),
        ("import numpy as np\ndef basis_matrix(points): raise NotImplementedError", "write"),
        ("import numpy as np\nbasis_matrix = 3", "write"),
        ("import numpy as np\ndef basis_matrix(points): return 1 / 0", "correct"),
        ("import numpy as np\ndef basis_matrix(points): return None", "correct"),
    ],
)
def test_an_earlier_answer_that_is_missing_or_stops_is_named(earlier, word):
    """Otherwise the answer itself would be called unwritten, or blamed for the error."""
    verdict = fieldcheck.check("01.2", cells(earlier, FIT))
    assert (verdict.finding, verdict.sentence) == ("inherited", FIRST.replace("correct", word))


def test_the_answers_own_stub_is_reported_as_before():
    unwritten = "def fit(points, values):\n    raise NotImplementedError"
    assert fieldcheck.check("01.2", cells(WRONG_BASIS, unwritten)).finding == "unwritten"
    assert fieldcheck.check("01.2", cells(WRONG_BASIS)).finding == "missing"


def test_other_names_and_modules_are_followed():
    """An alias, and answers that are imported from a file."""
    alias = cells(WRONG_BASIS, "B = basis_matrix", FIT.replace("basis_matrix", "B"))
    assert fieldcheck.check("01.2", alias).sentence == FIRST
    helper = ModuleType("helper")
    exec(WRONG_BASIS + FIT, vars(helper))
    imported = {"fit": helper.fit, "basis_matrix": helper.basis_matrix}
    assert fieldcheck.check("01.2", imported).sentence == FIRST
    through = "def both(points): return basis_matrix(points)\n" + FIT.replace(
        "basis_matrix", "both"
    )
    assert fieldcheck.check("01.2", cells(WRONG_BASIS, through)).sentence == FIRST


def test_the_first_wrong_answer_of_a_chain_is_named():
    """The answers between are right: 07.7 calls 07.5, which calls 07.4, which calls 07.3."""
    functions, area = SOURCES["07"].functions(), get("07.3")
    with in_place_of(functions, "interpolate", {area.function: lambda *_: 1.0}):
        sentence = notebook.try_public(get("07.7"), functions).sentence
    assert sentence == "First correct 07.3 (function `area`), which interpolate calls."


def test_the_reason_of_an_earlier_failure_is_passed_on():
    """The earlier answer is right too, and waits itself."""
    functions, question = cells(WRONG_BASIS, FIT), get("01.2")
    wrong = Verdict("01.2", "wrong", "It is wrong.", call=0)
    for finding, sentence in (("inherited", "First correct 00.1."), ("wrong", FIRST)):
        found = Verdict("01.1", finding, "First correct 00.1.")
        calls = question.inputs(0)
        verdict = explained_by_earlier(wrong, question, calls, functions, lambda _, v=found: v)
        assert verdict == Verdict("01.2", "inherited", sentence)


@pytest.mark.slow
def test_a_slow_earlier_answer_explains_only_slowness(monkeypatch):
    """Its values are right."""
    hasty = {q.name: replace(q, limit=0.5) for q in map(get, ("01.1", "01.2"))}
    monkeypatch.setattr("fieldcheck.earlier_answers.questions", lambda: hasty)
    monkeypatch.setattr(notebook, "get", hasty.get)
    monkeypatch.setattr("fieldcheck.notebook.TIMEOUT_FACTOR", 100.0)  # on a busy machine, too
    # only for many points, so that the limit may be far above the pauses of a busy machine
    busy = (
        "    end = time.process_time() + 0.6 * (len(points) > 50)\n"
        "    while time.process_time() < end: pass\n"
    )
    slow = "import time\n" + BASIS.replace("    return", f"{busy}    return")
    assert fieldcheck.check("01.2", cells(slow, FIT)).sentence == FIRST
    assert "opposite sign" in fieldcheck.check("01.2", cells(slow, WRONG_FIT)).sentence


def test_the_namespace_is_left_as_it_was():
    """Also after an error in the block; other changes made in it remain."""
    functions = cells(WRONG_BASIS, "B = basis_matrix", FIT)
    before = dict(functions)
    fieldcheck.check("01.2", functions)
    assert functions == before

    def fail():
        with in_place_of(functions, "fit", {"basis_matrix": len, "rank": len}):
            assert functions["B"] is functions["rank"] is len
            functions["counter"] = 1
            raise KeyError

    with pytest.raises(KeyError):
        fail()
    assert functions == {**before, "counter": 1}


def test_a_functions_own_output_is_printed_once(capsys):
    """The failing case runs again to see what it calls."""
    fieldcheck.check("01.2", cells(WRONG_BASIS, FIT.replace("    b =", "    print('x')\n    b =")))
    assert capsys.readouterr().out == "x\n" * len(get("01.2").inputs(0))


def test_only_earlier_questions_of_the_notebook_count():
    """Otherwise two answers could wait for each other."""
    later = "def basis_matrix(points):\n    return fit(points, points[:, 0])\n"
    wrong_fit = "import numpy as np\ndef fit(points, values): return np.ones(3)\n"
    assert fieldcheck.check("01.1", cells(wrong_fit, later)).finding == "shape"
    assert [q.name for q in earlier_questions(get("02.4"))] == ["02.1", "02.2"]
    functions = cells(BASIS, FIT)
    assert called_by(get("01.2"), get("01.2").inputs(0), functions) == [get("01.1")]


def test_a_check_that_blames_is_noticed(monkeypatch):
    """Without the search for earlier answers, right solutions are blamed."""
    monkeypatch.setattr(notebook, "explained_by_earlier", lambda verdict, *_: verdict)
    source = Source(SOURCES["01"].path)
    functions, mistakes = source.functions(), entries(source, "misconceptions")
    asked = [q for q in questions().values() if q.notebook == source.number]
    assert len([b for q in asked for b in inherited_mistakes.blamed(q, functions, mistakes)]) > 3
