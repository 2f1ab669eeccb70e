"""Finished functions of earlier notebooks: what they return, and that they answer no question."""

import inspect
import re
from functools import cache

import numpy as np
import pytest

from checkout import ROOT
from fieldcheck import given
from fieldcheck.given import distances, saddle_point_matrix
from fieldcheck.notebook import try_public
from fieldcheck.questions import questions
from fieldgrade.authoring.build import all_sources

GIVEN = dict(inspect.getmembers(given, inspect.isfunction))


@cache
def imported():
    """The names of given functions, and the notebooks that import them."""
    line = re.compile(r"^from fieldcheck\.given import (.*)$", re.MULTILINE)
    found = [
        (name, s.number)
        for s in all_sources(ROOT)
        for c in s.cells
        for t in line.findall(c.text)
        for name in t.split(", ")
    ]
    return {name: [number for other, number in found if other == name] for name in GIVEN}


def test_the_saddle_point_matrix_gives_an_interpolant_with_its_side_conditions():
    random = np.random.default_rng(3)
    points, values = random.normal(size=(9, 2)), random.normal(size=9)
    a, p = distances(points, points) ** 3, np.insert(points, 0, 1, axis=1)
    unknown = np.linalg.solve(saddle_point_matrix(a, p), np.append(values, np.zeros(3)))
    np.testing.assert_allclose(a @ unknown[:9] + p @ unknown[9:], values, atol=1e-9)
    np.testing.assert_allclose(p.T @ unknown[:9], 0, atol=1e-9)


def test_the_polynomials_may_have_no_column():
    a = np.array([[0.0, 2.0], [2.0, 0.0]])
    assert (saddle_point_matrix(a, np.ones((2, 0))) == a).all()


@pytest.mark.parametrize("p", [np.ones(2), np.ones((3, 1))])
def test_other_shapes_are_an_error_that_names_both(p):
    with pytest.raises(
        ValueError, match=r"A must have .*\(N, N\).*\(2, 2\) and " + re.escape(f"{p.shape}")
    ):
        saddle_point_matrix(np.eye(2), p)


@pytest.mark.slow
@pytest.mark.parametrize("function", GIVEN.values(), ids=GIVEN)
def test_no_finished_function_answers_a_question(function):
    """Students have all notebooks, and each question is graded."""
    verdicts = {q.name: try_public(q, {q.function: function}) for q in questions().values()}
    assert not [name for name, verdict in verdicts.items() if verdict.right]


@pytest.mark.slow
def test_the_map_of_the_course_lists_the_finished_functions_and_their_notebooks():
    page = (ROOT / "docs/course.md").read_text(encoding="utf-8")
    rows = dict(re.findall(r"^\| `(\w+)` \| notebook 03 \| ([\d, ]+) \|$", page, re.MULTILINE))
    assert {name: row.split(", ") for name, row in rows.items()} == imported()
    assert all(rows.values())
