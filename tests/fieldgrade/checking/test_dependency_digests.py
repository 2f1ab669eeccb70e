"""A check's digest changes if and only if something changes on which its verdict depends."""

from dataclasses import replace
from functools import partial
from importlib.util import module_from_spec, spec_from_file_location

import numpy as np
import pytest

from fieldcheck.questions import questions
from fieldgrade.authoring.hidden_cases import hidden_cases
from fieldgrade.authoring.sources import Source
from fieldgrade.authoring.trials import asked_by
from fieldgrade.checking.course import Course
from fieldgrade.checking.dependency_digests import dependency_digest
from graded_class import ROOT, checkout

CODE = """
import numpy as np
UNIT = 2.0
class Law:
    size = 1
def helper(x):
    return UNIT * x
def check(x, tolerance=1e-9):
    return [helper(y) for y in np.atleast_1d(x)]
def other(x):
    return x
"""


def digest(folder, code, name="check"):
    """The digest of a function defined in a file."""
    file = folder / f"code_{abs(hash(code))}.py"
    file.write_text(code)
    spec = spec_from_file_location(file.stem, file)
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return dependency_digest(getattr(module, name))


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("import numpy", "# a comment\n\nimport numpy"),
        ("return x\n", "return x + 1\n"),
        ("size = 1", "size = 2"),
    ],
    ids=["a comment", "a function that it does not call", "a class that it does not use"],
)
def test_irrelevant_edits_do_not_change_the_digest(tmp_path, old, new):
    """Lines may move, and code that the check does not use may change."""
    assert digest(tmp_path, CODE) == digest(tmp_path, CODE.replace(old, new))


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("UNIT * x", "UNIT / x"),
        ("UNIT = 2.0", "UNIT = 3.0"),
        ("1e-9", "1e-8"),
        ("atleast_1d", "atleast_2d"),
        ("helper(y) for", "helper(helper(y)) for"),
        ("import numpy as np", "import math as np"),
    ],
)
def test_relevant_edits_change_the_digest(tmp_path, old, new):
    """Helpers, constants, defaults, names of libraries, and nested code are relevant."""
    assert old in CODE
    assert digest(tmp_path, CODE) != digest(tmp_path, CODE.replace(old, new))


def test_mutually_recursive_functions_have_different_digests():
    """A function that was visited before enters the digest by its number."""

    def even(n):
        return n == 0 or odd(n - 1)

    def odd(n):
        return n != 0 and even(n - 1)

    assert dependency_digest(even) != dependency_digest(odd)


@pytest.mark.parametrize(
    ("one", "other"),
    [
        (1, 1.0),
        ((1, 2), (2, 1)),
        (np.zeros(2), np.zeros(3)),
        (np.zeros(2), np.zeros(2, int)),
        ({"a": 1}, {"a": 2}),
        (partial(max, 1), partial(max, 2)),
        (max, min),
        ("1", 1),
    ],
)
def test_different_values_have_different_digests(one, other):
    """Numbers and arrays differ by type, arrays also by shape, and containers by content."""
    assert dependency_digest(one) == dependency_digest(one)
    assert dependency_digest(one) != dependency_digest(other)


def made_by(root):
    """The digests of the questions of notebook 01 and of their checks."""
    course = Course([Source(root / "solutions" / "01_least_squares.py")], "salt")
    asked = [q.name for q in questions().values() if q.notebook == "01"]
    checks = {f"{q} {name}": made for q in asked for name, made in course.checks(q).items()}
    return {q: course.made_by(q) for q in asked} | checks


ALL = {
    "01.3",
    *(f"01.3 {check}" for check in ("public cases", "own inputs", "values in other units")),
}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("file", "old", "new", "concerned"),
    [
        ("grading", "1e5 * line", "1e6 * line", {"01.4", "01.4 tiny and huge"}),
        (
            "grading",
            "every dimension, and for other",
            "each dimension, and for other",
            {"01.2", "01.2 in four dimensions"},
        ),
        ("misconceptions", "def slopes_only", "def only_slopes", ALL),
        ("grading", '"""What only', '"""What just', set()),
    ],
)
def test_a_changed_check_changes_its_own_digest_and_that_of_its_question(
    tmp_path, file, old, new, concerned
):
    """One file contains the checks of a whole notebook, and each check has its own digest."""
    before = made_by(ROOT)
    root = checkout(tmp_path, "01")
    place = root / "solutions" / file / "01_least_squares.py"
    assert old in place.read_text()
    place.write_text(place.read_text().replace(old, new))
    now = made_by(root)
    assert {name for name in now if now[name] != before[name]} == concerned


def test_laws_and_public_inputs_do_not_affect_the_digest_of_a_hidden_case():
    """A hidden case shares only the comparison of answers, such as the tolerance, with them."""
    (case,) = hidden_cases(Source(ROOT / "solutions" / "01_least_squares.py"))[:1]
    asked = questions()[case.question]

    def digest_of(**changed):
        return dependency_digest(asked_by(case, replace(asked, **changed)))

    assert digest_of(laws=(), inputs=None) == digest_of()
    assert digest_of(tolerance=lambda _: 1e-3) != digest_of()
