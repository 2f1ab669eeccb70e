"""The record says for each lost point what stopped the answer, in which line of which cell."""

import json

import pytest

from fieldcheck.questions import questions
from fieldgrade.authoring.known_answers import public_calls
from fieldgrade.authoring.trials import OWN
from fieldgrade.checking.grade_submission import grade
from fieldgrade.checking.results import Results, from_json, invalid, to_json
from fieldgrade.isolation.process import CellError
from fieldgrade.sandbox.missing import Missing
from hostile import cheats
from hostile.case import Case, notebook

CELLS = {
    "basis_matrix": "import not_here\ndef basis_matrix(points):\n    from helper import ones\n"
    "    return ones(points)",
    "fit": "def fit(points, values):\n    return 1\nthis is a remark",
    "evaluate": "def evaluate(coefficients, x):\n    y = x + 1\n    return y / FACTOR",
    "rank": "# twelve\nFACTOR = 12 * undefined\ndef rank(points):\n    return points[10 ** 6]",
    "gradient": "grad = 1",
}
HELPER = "import numpy as np\ndef ones(points):\n    raise KeyError(len(points))\n"
CODE = [cell["source"] for cell in notebook()["cells"] if cell["cell_type"] == "code"]
NUMBERS = {f: next(k for k, c in enumerate(CODE, 1) if f"def {f}(" in c) for f in CELLS}
"""The numbers of the cells."""
ERRORS = (
    CellError(
        NUMBERS["basis_matrix"],
        "ModuleNotFoundError: No module named 'not_here'",
        1,
        "import not_here",
    ),
    CellError(NUMBERS["fit"], "SyntaxError: invalid syntax", 3, "this is a remark"),
    CellError(
        NUMBERS["rank"], "NameError: name 'undefined' is not defined", 2, "FACTOR = 12 * undefined"
    ),
)


@pytest.fixture(scope="module")
def record(servers, course):
    case = Case("", answers=CELLS, helpers={"helper.py": HELPER})
    return grade(course, servers("none"), case.submission({}))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("question", "finding", "sentence", "cause"),
    [
        ("01.1", "exception", "line 3 of helper.py, in ones: raise KeyError(len(points)).", ""),
        ("01.2", "missing", "", f"C{str(ERRORS[1])[1:]}."),
        (
            "01.3",
            "exception",
            f"3 of code cell {NUMBERS['evaluate']}, in evaluate: return",
            f"C{str(ERRORS[2])[1:]}.",
        ),
        (
            "01.4",
            "exception",
            f"4 of code cell {NUMBERS['rank']}, in rank: return points[10 ** 6].",
            "",
        ),
        ("01.5", "missing", "", "No code cell defines gradient."),
    ],
)
def test_a_lost_point_has_a_line_or_a_cause(record, question, finding, sentence, cause):
    """The line of an error is in the sentence; the error of a cell that should define is apart."""
    (found,) = (grade for grade in record.grades if grade.question == question)
    assert found.verdict.finding == finding
    assert sentence in found.verdict.sentence
    assert found.cause == cause


@pytest.mark.slow
def test_errors_of_cells_and_missing_modules_are_in_the_results(record):
    """They are read back from the file as they were written."""
    assert record.cell_errors == ERRORS
    assert (record.missing.modules, record.helper_files) == (("not_here",), ("helper.py",))
    data = json.loads(json.dumps(to_json(Results((record,)))))
    assert invalid(data) == ""
    (read,) = from_json(data).records
    assert read.cell_errors == ERRORS
    assert [grade.cause for grade in read.grades] == [grade.cause for grade in record.grades]


@pytest.mark.slow
def test_calls_with_hidden_inputs_report_no_text(servers, course):
    """What a call raises after the public cases could contain a hidden input."""
    count = len(public_calls(questions()["01.2"]))
    answer = (
        f"calls = []\ndef fit(points, values):\n    calls.append(1)\n    if len(calls) > {count}:\n"
        "        raise ModuleNotFoundError(\"No module named 'leaked'\", name='leaked')\n"
        "    return np.linalg.lstsq(basis_matrix(points), values, rcond=None)[0]"
    )
    record = grade(course, servers("none"), Case("", answers={"fit": answer}).submission({}))
    (lost,) = (grade for grade in record.grades if grade.points < grade.possible)
    assert (lost.question, lost.check, lost.verdict.finding) == ("01.2", OWN, "exception")
    assert "leaked" not in json.dumps(to_json(Results((record,))))


def test_a_forged_report_of_a_cell_is_validated(servers, course):
    """The results stay valid, whatever a cell answers in place of the worker."""
    forged = """
forged({"frame": their("head")["frame"], "error": "forged", "line": True, "arrays": [],
        "missing": {"modules": [1, "a b", "ok"], "files": ["\\n", "x" * 999], "fonts": "all"},
        "stubs": {"fit": 1}})
raise ValueError
"""
    case = Case("", after=cheats.FORGER + forged)
    record = grade(course, servers("none"), case.submission({}))
    assert (record.missing, record.cell_errors[-1].line) == (Missing(modules=("ok",)), 0)
    assert invalid(json.loads(json.dumps(to_json(Results((record,)))))) == ""
