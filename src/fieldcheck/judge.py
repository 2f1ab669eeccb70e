"""Judge outcomes: look for all findings in order, and report the sentence of the first.

The judge sees calls and outcomes, and never the function itself.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from itertools import product

import numpy as np

from fieldcheck.answers import Answers
from fieldcheck.calls import LIST, MATRIX, Call, Outcome, Values
from fieldcheck.question import Law, Question
from fieldcheck.shapes import (
    fitted,
    in_words,
    shape_in_words,
    without_extra_axes,
)
from fieldcheck.verdict import FINDINGS, Finding, Verdict
from fieldcheck.wrong_values.compared import FAR_OFF
from fieldcheck.wrong_values.difference import difference, is_in_any_order
from fieldcheck.wrong_values.patterns import pattern

TIMEOUT_FACTOR = 4.0
"""A call is stopped after this multiple of its time limit."""

NOT_RECOGNISABLE = ("missing", "unwritten", "endless", "modified", "slow")
"""Failures that are reported as they are; the values of a slow answer are right."""

SLIGHTLY = 0.01
"""A law that compares calls is hardly violated by such a part of the error of one of them."""

NEAR = 100.0
"""Errors of up to so many times the tolerance read like rounding errors."""

CLEARLY = 10.0
"""Beside stored values, which have twelve digits, a law must be violated so much more by others."""

NOT_FINITE = (
    " NumPy says this of NaN or infinite entries: look for a division by zero in or before this "
    "line."
)
ADVICE = {
    "Cannot cast ufunc": (
        " The array on the left holds integers, and takes no decimals, not even by `+=` or `-=`; "
        "begin with one of floats."
    ),
    "did not converge": NOT_FINITE,
    "infs or NaNs": NOT_FINITE,
}
"""What to do about errors of NumPy, which does not say it in these words."""


def judge(
    question: Question,
    calls: Sequence[Call],
    outcomes: Sequence[Outcome],
    answers: Answers | None = None,
) -> Verdict:
    """Return the verdict on the outcomes of calls.

    Parameters
    ----------
    question : Question
        The question.
    calls : sequence of Call
        ``question.inputs(seed)``.
    outcomes : sequence of Outcome
        Their outcomes.
    answers : Answers, optional
        The known answers to these calls. Without them only the laws of the question are checked.
    """
    outcomes = [
        without_extra_axes(outcome, question.shapes(call))
        for call, outcome in zip(calls, outcomes, strict=True)
    ]
    failures = list(_failures(question, calls, outcomes, answers))
    if not failures:
        return Verdict(question.name, "right", _note(question, calls, outcomes))
    finding, sentence, call = min(failures, key=lambda failure: FINDINGS.index(failure[0]))
    if answers and finding not in NOT_RECOGNISABLE:
        mistake = answers.recognize(question, calls, outcomes)
        if mistake:
            return Verdict(question.name, "misconception", mistake.sentence, mistake.name, call)
        if finding == "wrong":
            count = _number_in_form(question, calls, outcomes)
            values = _values(question, calls[:count], outcomes[:count])
            right = answers.right[:count]
            found = pattern(
                *(question, calls[:count], values, right),
                are_all=count == len(calls),
                in_order=not any(map(partial(is_in_any_order, question), calls[:count], right)),
            )
            sentence = _joined(sentence, found)
    return Verdict(question.name, finding, sentence, call=call)


def _note(question: Question, calls: Sequence[Call], outcomes: Sequence[Outcome]) -> str:
    """Return a hint on a right answer that is a list, a matrix or complex, no real array."""
    if any(outcome.returned == MATRIX for outcome in outcomes):
        return (
            f"But {question.function} returns {MATRIX}, for which * is the product of matrices, "
            "and which always has two axes. Where it is used below, use np.array(…) instead."
        )
    if any(v.dtype.kind == "c" for outcome in outcomes for v in outcome.values or ()):
        return (
            f"But {question.function} returns complex numbers. Where it is used below, arithmetic "
            "needs real ones: return the real part."
        )
    listed = any(outcome.returned == LIST for outcome in outcomes)
    if not listed or any(len(question.shapes(call)) > 1 for call in calls):
        return ""
    return (
        f"But {question.function} returns a list. Where it is used below, arithmetic needs an "
        "array: return np.array(…) of the list."
    )


Failure = tuple[Finding, str, int | None]


def _failures(
    question: Question,
    calls: Sequence[Call],
    outcomes: Sequence[Outcome],
    answers: Answers | None,
) -> Iterator[Failure]:
    """Yield the failures of the first call without values of the right form, or of the values.

    Wrong values before it are reported. If LAPACK refused it, only those of the first call are: for
    a nearly singular system that depends on the machine, and the first call is a plain one.
    """
    count = _number_in_form(question, calls, outcomes)
    if count < len(calls):
        form = list(_form(question, calls[count], outcomes[count]))
        error = outcomes[count].error
        singular = "LinAlgError" in error and "did not converge" not in error
        before = min(count, 1) if singular else count
        wrong = _wrong_before(question, calls, outcomes, answers, count, before)
        yield from wrong or [(finding, sentence, count) for finding, sentence in form]
        return
    yield from _wrong(question, calls, _values(question, calls, outcomes), answers)
    slowest = int(np.argmax([outcome.seconds for outcome in outcomes]))
    if outcomes[slowest].seconds > question.limit:
        yield "slow", _slow(question, calls[slowest], outcomes[slowest]), slowest


def _number_in_form(question: Question, calls: Sequence[Call], outcomes: Sequence[Outcome]) -> int:
    """Return the number of calls before the first without values of the right form."""
    pairs = zip(calls, outcomes, strict=True)
    return next((k for k, pair in enumerate(pairs) if any(_form(question, *pair))), len(calls))


def _wrong_before(
    question: Question,
    calls: Sequence[Call],
    outcomes: Sequence[Outcome],
    answers: Answers | None,
    count: int,
    before: int,
) -> list[Failure]:
    """Return the first wrong case of the first calls.

    Laws are judged on the values of all calls before the failure of form, since a law that compares
    calls may hold for these values; the calls after it have their right values.
    """
    if answers is None or before == 0:
        return []
    values = _values(question, calls[:count], outcomes[:count])
    return list(_wrong(question, calls, [*values, *answers.right[count:]], answers, before))


def _values(question: Question, calls: Sequence[Call], outcomes: Sequence[Outcome]) -> list[Values]:
    """Return the values of outcomes that have the right shapes."""
    return [
        fitted(o.values or (), question.shapes(c)) for c, o in zip(calls, outcomes, strict=True)
    ]


def _form(question: Question, call: Call, outcome: Outcome) -> Iterator[tuple[Finding, str]]:
    """Yield the failures of an outcome that do not depend on its values."""
    name = question.function
    if outcome.status == "missing":
        yield "missing", f"There is no function {name}. Run the cell that defines it."
    elif outcome.status == "unwritten":
        yield "unwritten", f"Write {name}, run its cell, and then this one again."
    elif outcome.status == "raised":
        place = f" It arises in {outcome.line}." if outcome.line else ""
        advice = next((text for words, text in ADVICE.items() if words in outcome.error), "")
        error = outcome.error.removesuffix(".")
        yield "exception", f"For {call.case}, {name} stops with {error}.{place}{advice}"
    elif outcome.status == "timed out":
        yield "endless", f"For {call.case}, {name} was stopped after {outcome.seconds:.0f} seconds."
    elif outcome.values is None:
        wanted = " and ".join(map(shape_in_words, question.shapes(call)))
        yield "type", f"For {call.case}, {name} returns {outcome.returned}. It should be {wanted}."
    else:
        yield from _array_form(question, call, outcome, outcome.values)


def _array_form(
    question: Question, call: Call, outcome: Outcome, returned: Values
) -> Iterator[tuple[Finding, str]]:
    shapes = question.shapes(call)
    values = fitted(returned, shapes)
    wanted = " and ".join(map(shape_in_words, shapes))
    if any(v.dtype.kind == "c" for v in values):
        yield "type", f"For {call.case}, {question.function} returns complex numbers."
    elif [v.shape for v in values] != list(shapes):
        yield (
            "shape",
            (
                f"For {call.case}, {question.function} returns {in_words(returned)}. "
                f"It should be {wanted}."
            ),
        )
    elif not all(np.isfinite(v).all() for v in values):
        bad = sum(int((~np.isfinite(v)).sum()) for v in values)
        yield (
            "not finite",
            (
                f"For {call.case}, {bad} of {sum(v.size for v in values)} values are "
                "NaN or infinite, and all should be finite. If the code does not set them so, look "
                "for a division by zero, or for a logarithm or a root of a number that is zero or "
                "negative."
            ),
        )
    if outcome.modified:
        which = ", ".join(str(i + 1) for i in outcome.modified)
        yield (
            "modified",
            (
                f"{question.function} changes its argument number {which}, which belongs to the "
                "caller. Statements such as a[i] = …, a += …, a.sort() and a.shape = … work in "
                "place, also after a = np.asarray(b): take a copy first."
            ),
        )


def _wrong(
    question: Question,
    calls: Sequence[Call],
    values: Sequence[Values],
    answers: Answers | None,
    before: int | None = None,
) -> Iterator[Failure]:
    """Yield a violated law and the first case that violates it, or else the first wrong case.

    Inputs begin with the plain cases, so the first one is the simplest. It is not passed over for a
    later case with a violated law if it satisfies this law itself and is far off. But cases at the
    limit of the tolerance come last: they read like rounding errors.

    With `before`, only the cases before it are reported, since some of the later values are the
    stored ones; if none of them is wrong, neither is a law violated.
    """
    if answers is None:
        amounts = ((law, _deviation(law, calls, values)) for law in question.laws)
        for law, deviation in [a for a in amounts if not a[1] <= a[0].tolerance][:1]:
            yield "wrong", _joined(law.sentence, _off(deviation, law.tolerance)), None
        return
    right = answers.right
    units = _units(question, calls, values, answers)
    failed = [k for k, d in enumerate(units[:before]) if not max(map(_largest, d)) <= 1]
    if before is not None and not failed:
        return
    failed.sort(key=lambda k: max(map(_largest, units[k])) <= NEAR)
    violated = [
        law
        for law in question.laws
        if _is_violated(law, calls, values, right, before)
        and (law.of_each or not _is_hardly_violated(law, calls, values, right, failed))
    ]
    first = failed[0] if failed else None
    is_far_off = first is not None and max(map(_largest, units[first])) > FAR_OFF
    for index, law in product(failed, violated):
        deviation = _deviation_alone(law, calls, values, right, index)
        if not deviation <= (law.tolerance if law.of_each else _limit(law, calls, right)):
            is_near = max(map(_largest, units[index])) <= NEAR
            if index != first and is_far_off and (law.of_each or is_near):
                violated = []
                break
            text = law.amount and f"For {calls[index].case}, {law.amount.format(deviation)}."
            shown = _units_of_law(law, calls, values, right, index, units[index])
            text = text or difference(question, calls[index], shown, right, index)
            yield "wrong", _joined(law.sentence, text), index
            return
    if violated:
        text = _off(_deviation(violated[0], calls, values), violated[0].tolerance)
        yield "wrong", _joined(violated[0].sentence, text), first
    elif first is not None:
        text = difference(question, calls[first], units[first], right, first)
        yield "wrong", text, first


def _is_violated(
    law: Law,
    calls: Sequence[Call],
    values: Sequence[Values],
    right: Sequence[Values],
    before: int | None,
) -> bool:
    """Return whether the values violate a law; with `before`, some of the later ones are stored."""
    if law.of_each:
        return not _deviation(law, calls[:before], values[:before]) <= law.tolerance
    limit = law.tolerance if before is None else _limit(law, calls, right)
    return not _deviation(law, calls, values) <= limit


def _limit(law: Law, calls: Sequence[Call], right: Sequence[Values]) -> float:
    """Return the largest deviation that is explained by rounding, also by that of stored values.

    Far from the origin, these have fewer digits of a small triangle than a law may need.
    """
    return max(law.tolerance, CLEARLY * _deviation(law, calls, right))


def _largest(differences: np.ndarray) -> float:
    return float(differences.max(initial=0.0))


def _joined(*sentences: str) -> str:
    return " ".join(filter(None, sentences))


def _deviation(law: Law, calls: Sequence[Call], values: Sequence[Values]) -> float:
    with np.errstate(all="ignore"):  # wrong values may be of any size
        return float(law.deviation(calls, values))


def _deviation_alone(
    law: Law,
    calls: Sequence[Call],
    values: Sequence[Values],
    right: Sequence[Values],
    index: int,
) -> float:
    """Return by how much one call alone violates a law.

    If the law compares calls, the others get their right values.
    """
    if law.of_each:
        return _deviation(law, calls[index : index + 1], values[index : index + 1])
    return _deviation(law, calls, [*right[:index], values[index], *right[index + 1 :]])


def _units_of_law(
    law: Law,
    calls: Sequence[Call],
    values: Sequence[Values],
    right: Sequence[Values],
    index: int,
    units: Sequence[np.ndarray],
) -> list[np.ndarray]:
    """Return the differences of the arrays that violate the law beside right ones; if none, all."""

    def violates(part: int) -> bool:
        mixed = (*right[index][:part], values[index][part], *right[index][part + 1 :])
        each = [*values[:index], mixed, *values[index + 1 :]]
        return _deviation_alone(law, calls, each, right, index) > law.tolerance

    broken = [violates(part) for part in range(len(units))]
    pairs = zip(units, broken, strict=True)
    return [u if b or not any(broken) else np.zeros_like(u) for u, b in pairs]


def _is_hardly_violated(
    law: Law,
    calls: Sequence[Call],
    values: Sequence[Values],
    right: Sequence[Values],
    failed: Sequence[int],
) -> bool:
    """Return whether wrong values nearly satisfy a law, though one among right ones does not.

    Values that ignore an argument do not depend on the unit, but right ones beside them differ.
    """
    alone = [_deviation_alone(law, calls, values, right, index) for index in failed]
    largest = max((d for d in alone if np.isfinite(d)), default=0.0)
    return _deviation(law, calls, values) < SLIGHTLY * largest


def _units(
    question: Question, calls: Sequence[Call], values: Sequence[Values], answers: Answers
) -> list[list[np.ndarray]]:
    """Return the differences from the right answer in units of the tolerance."""
    triples = zip(calls, values, answers.right, strict=True)
    return [question.differences(*triple) for triple in triples]


def _off(deviation: float, tolerance: float) -> str:
    """Return the size of the violation of a law, if it is not an integer or infinite."""
    if not np.isfinite(deviation) or deviation == round(deviation):
        return ""
    return f"This is off by {deviation:.2g}; {tolerance:.0e} is allowed for rounding."


def _slow(question: Question, call: Call, outcome: Outcome) -> str:
    return (
        f"The numbers are right, but for {call.case} {question.function} took "
        f"{outcome.seconds:.1f} seconds; {question.limit:.0f} should do. "
        "Let NumPy work on whole arrays."
    )
