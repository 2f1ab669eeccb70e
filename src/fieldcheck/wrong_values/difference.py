"""The largest difference of an answer from the right one, in words."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fieldcheck.calls import Call, Values
from fieldcheck.question import LEAST_TOLERANCE, Question, scale
from fieldcheck.shapes import ORDINALS, are_whole
from fieldcheck.wrong_values.compared import are_truth_values

MATCHED = 1e-3
"""Relative error below which it is known which right entry, or which sign, a value is meant for."""

STEP = 1e-3
"""Relative size of the change that shows the unit in which answers are compared."""


def difference(
    question: Question,
    call: Call,
    units: Sequence[np.ndarray],
    answers: Sequence[Values],
    index: int,
) -> str:
    """Describe the largest difference of a call from its right answer, which has this index."""
    right = answers[index]
    part = int(np.argmax([d.max(initial=0.0) for d in units]))
    wanted = right[part]
    compared = question.normal_form(call, right)[part]
    tolerance = max(question.tolerance(call), LEAST_TOLERANCE) * scale(compared)
    open_order = _order_is_open(question, call, right, part)
    if not open_order:
        tolerance /= _magnification(question, call, right, part, int(np.argmax(units[part])))
    off = units[part].max() * tolerance
    is_open = open_order or _sign_is_open(question, call, right, part)
    if is_open and off > MATCHED * scale(compared) and not are_truth_values(answers):
        which = f"the entries of the {ORDINALS[part]} array" if len(units) > 1 else "the entries"
        freedom = "in any order that the question allows" if open_order else "with either sign"
        return f"For {call.case}, {which} are not the right ones {freedom}."
    entry = _entry(units[part], part, len(units), open_order)
    if np.isclose(off, 1) and are_truth_values(answers):
        return f"For {call.case}, {entry} {_of_two(compared.flat[int(np.argmax(units[part]))])}."
    size = f"{off:.2g}" if np.isfinite(off) else "more than 10²⁹⁰ times the largest right value"
    text = f"For {call.case}, {entry} is off by {size}."
    if all(are_whole(values[part]) for values in answers):
        which = "All right values here" if len(units) == 1 else "All right values of this array"
        return f"{text} {which} are whole numbers."
    if wanted.size == 1:
        value = f"The right value is {'−' * (wanted.item() < 0)}{abs(wanted.item()):.2g}"
    else:
        value = f"The largest right value is {scale(wanted):.2g}"
    return f"{text} {value}; {tolerance:.0e} is allowed for rounding."


def _magnification(
    question: Question, call: Call, right: Values, part: int, position: int
) -> float:
    """Return how often larger a small change of one entry is where answers are compared."""
    step = STEP * scale(right[part])
    changed = right[part].astype(float)
    changed.flat[position] += step
    forms = (
        question.normal_form(call, (*right[:part], value, *right[part + 1 :]))[part]
        for value in (changed, right[part])
    )
    ratio = float(np.abs(np.subtract(*forms)).flat[position]) / step
    return ratio if ratio > 0 else 1.0


def _of_two(right: float) -> str:
    return "must be 1, or True" if right else "must be 0, or False"


def is_in_any_order(question: Question, call: Call, right: Values) -> bool:
    """Return whether some of the returned arrays may come in another order."""
    return any(_order_is_open(question, call, right, part) for part in range(len(right)))


def _order_is_open(question: Question, call: Call, right: Values, part: int) -> bool:
    """Return whether rows or columns may come in another order, so that an index says nothing."""
    value = right[part]
    others = [np.flip(value, axis) for axis in range(value.ndim)]
    form = question.normal_form(call, right)[part]
    return any(
        not np.array_equal(other, value)
        and np.array_equal(
            question.normal_form(call, (*right[:part], other, *right[part + 1 :]))[part], form
        )
        for other in others
    )


def _sign_is_open(question: Question, call: Call, right: Values, part: int) -> bool:
    """Return whether an array, or each of its rows, may have the other sign."""
    value = right[part]
    form, other = (
        question.normal_form(call, (*right[:part], signed, *right[part + 1 :]))[part]
        for signed in (value, -value)
    )
    return bool(value.any()) and np.array_equal(form, other)


def _entry(units: np.ndarray, part: int, parts: int, order_is_open: bool) -> str:
    if units.ndim == 0:
        return f"the {ORDINALS[part]} number" if parts > 1 else "the number"
    if order_is_open:
        return f"an entry of the {ORDINALS[part]} array" if parts > 1 else "an entry"
    index = np.unravel_index(int(np.argmax(units)), units.shape)
    entry = f"entry [{', '.join(str(int(i)) for i in index)}]"
    return f"{entry} of the {ORDINALS[part]} array" if parts > 1 else entry
