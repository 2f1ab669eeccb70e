"""Statistics of the questions: discrimination, failures, and the most frequent misconceptions."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldgrade.gradebook import item_analysis as module
from fieldgrade.gradebook.grade_sheets import grade_sheets
from fieldgrade.gradebook.item_analysis import (
    ItemStatistics,
    analysis_page,
    discrimination,
    items,
    to_table,
)
from gradebook_class import asked, grade, record, results

scores = st.lists(st.tuples(st.integers(0, 4), st.integers(0, 20)), min_size=3, max_size=30)


@pytest.mark.slow
@given(scores)
def test_discrimination_is_the_pearson_correlation(pairs):
    """It agrees with NumPy, is in [-1, 1], and is None if one of the two is constant."""
    x, y = np.array(pairs, dtype=float).T
    r = discrimination(x, y)
    if np.ptp(x) == 0 or np.ptp(y) == 0:
        assert r is None
    else:
        assert r == pytest.approx(np.corrcoef(x, y)[0, 1], abs=1e-12)
        assert -1 - 1e-12 <= r <= 1 + 1e-12


@pytest.mark.slow
@given(scores, st.floats(0.1, 10), st.floats(-5, 5))
def test_discrimination_does_not_depend_on_the_unit_of_points(pairs, unit, shift):
    """An affine change of the points keeps the correlation; reversed points change its sign."""
    x, y = np.array(pairs, dtype=float).T
    r = discrimination(x, y)
    if r is not None:
        assert discrimination(unit * x + shift, y) == pytest.approx(r, abs=1e-9)
        assert discrimination(-x, y) == pytest.approx(-r, abs=1e-12)


def test_two_submissions_give_no_discrimination():
    """A line passes through any two points, so their correlation is not evidence."""
    assert discrimination(np.array([0.0, 1.0]), np.array([0.0, 1.0])) is None


def classes(*rows):
    """Return the sheets of students who earned these points for the questions."""
    names = [f"01.{k + 1}" for k in range(len(rows[0]))]
    found = [
        record(f"s{i}", [grade(q, p) for q, p in zip(names, row, strict=True)])
        for i, row in enumerate(rows)
    ]
    return grade_sheets(results(found, asked(*names)))


def test_discrimination_compares_a_question_with_the_other_questions():
    """A question that is independent of the others has no correlation with them, although it is
    correlated with the total that contains it.
    """
    sheets = classes((0, 0), (0, 2), (2, 0), (2, 2))
    assert [item.discrimination for item in items(sheets)] == pytest.approx([0, 0])
    whole = np.array([sheet.earned for sheet in sheets])
    assert discrimination(np.array([0.0, 0.0, 1.0, 1.0]), whole) > 0.7


def test_failures_and_means_are_fractions_of_graded_answers():
    """Half the points is a failure and counts half; ungraded answers do not count."""
    first, second = items(classes((0, 2), (1, 2), (2, 2), (2, 2)))
    assert (first.failed, first.mean) == (0.5, 0.625)
    assert (second.failed, second.mean, second.discrimination) == (0, 1, None)
    unread = results([record("a", [])], asked("01.7", kind="words"))
    assert items(grade_sheets(unread)) == []


def test_misconceptions_are_sorted_by_frequency():
    """An answer without a recognized misconception is not counted among them."""

    def answer(name):
        return grade("01.1", 0.0, finding="misconception" if name else "shape", mistake=name)

    given_ = ["b", "a", "b", "", "c", "c", "c"]
    found = results([record(f"s{i}", [answer(m)]) for i, m in enumerate(given_)], asked("01.1"))
    (item,) = items(grade_sheets(found))
    assert item.mistakes == (("c", 3), ("b", 2), ("a", 1))


def test_the_table_and_the_page_show_the_same_statistics():
    """Doubtful values are marked on the page."""
    found = [
        ItemStatistics("01.1", 8, 0.25, 0.75, 0.1, (("no constant", 2),)),
        ItemStatistics("01.2", 8, 0, 1, None),
    ]
    first, second = to_table(found).splitlines()[1:]
    assert first == "01.1,8,0.25,0.75,0.1,no constant (2)"
    assert second == "01.2,8,0,1,,"
    page = analysis_page(found, {"01": "Least <squares>"})
    assert "<mark>0.10</mark>" in page
    assert "no constant (2)" in page
    assert "Least &lt;squares&gt;" in page


def test_including_the_question_in_the_rest_changes_discrimination(monkeypatch):
    """A mutant that the test of independent questions catches."""
    right = module.discrimination
    monkeypatch.setattr(module, "discrimination", lambda x, rest: right(x, rest + 2 * x))
    found = items(classes((0, 0), (0, 2), (2, 0), (2, 2)))
    assert [item.discrimination for item in found] != pytest.approx([0, 0])
