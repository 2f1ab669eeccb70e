"""Each mistake must be caught by two cases, each by itself."""

import numpy as np

from fieldcheck.calls import Call
from fieldcheck.question import Question, law
from fieldgrade.authoring import catalogue
from fieldgrade.authoring.catalogue import Entry
from fieldgrade.authoring.trials import trials
from fieldgrade.grader_validation.single_inputs import caught_by_few


def inputs(seed):
    random = np.random.default_rng(seed)
    return tuple(
        Call("absolute", (sign * random.uniform(1, 2, 3),), case)
        for sign, case in ((1, "positive numbers"), (-1, "negative numbers"), (3, "larger numbers"))
    )


@law("Both signs must have the same result.")
def is_even(_, values):
    return max(float((-v).max() > 0) for (v,) in values)


ABSOLUTE = Question(
    "99.6", "absolute", 1, inputs, lambda call: (call.arguments[0].shape,), (is_even,)
)


def test_a_mistake_that_one_case_catches_is_reported(monkeypatch):
    """The student's own inputs are the same cases with other numbers, and count once."""
    monkeypatch.setattr(catalogue, "get", lambda _: ABSOLUTE)
    mistakes = [
        Entry("99.6", "unchanged", "It is unchanged.", lambda x: x),
        Entry("99.6", "squared", "It is squared.", np.square),
        Entry("99.6", "right", "It is right.", np.abs),
    ]
    functions = {"absolute": np.abs}
    tried = trials(ABSOLUTE, functions, mistakes, (), "ada", "salt")
    assert list(caught_by_few(tried, functions, mistakes)) == [
        "'unchanged' is caught only by: negative numbers",
        "'right' is caught only by: no input alone",
    ]
