"""Judge outcomes: the rungs of the ladder in order, and the sentence of the first that fails.

The judge sees calls and outcomes, and never the function itself.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from fieldcheck.answers import Answers
from fieldcheck.calls import Call, Outcome, Values
from fieldcheck.question import LEAST_TOLERANCE, Question, scale
from fieldcheck.shapes import fitted, in_words, shape_in_words
from fieldcheck.verdict import LADDER, Rung, Verdict

TIMEOUT_FACTOR = 4.0
"""A call is stopped after this multiple of its time limit."""

NOT_RECOGNISABLE = ("missing", "unwritten", "endless", "modified")


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
    failures = list(_failures(question, calls, outcomes, answers))
    if not failures:
        return Verdict(question.name, "right", _note(question, outcomes))
    rung, sentence, call = min(failures, key=lambda failure: LADDER.index(failure[0]))
    if answers and rung not in NOT_RECOGNISABLE:
        mistake = answers.recognise(question, calls, outcomes)
        if mistake:
            return Verdict(question.name, "misconception", mistake.sentence, mistake.name, call)
    return Verdict(question.name, rung, sentence, call=call)


def _note(question: Question, outcomes: Sequence[Outcome]) -> str:
    """Return a hint on a right answer that is a list rather than an array."""
    if not any(outcome.returned for outcome in outcomes):
        return ""
    return (
        f"But {question.function} returns a list. Where it is used below, arithmetic needs an "
        "array: return np.array(…) of the list."
    )


Failure = tuple[Rung, str, int | None]


def _failures(
    question: Question,
    calls: Sequence[Call],
    outcomes: Sequence[Outcome],
    answers: Answers | None,
) -> Iterator[Failure]:
    """Yield the failures of single calls, then those that only all calls together show."""
    found = False
    for index, (call, outcome) in enumerate(zip(calls, outcomes, strict=True)):
        for rung, sentence in _form(question, call, outcome):
            found = True
            yield rung, sentence, index
    if found:
        return
    values = [
        fitted(o.values or (), question.shapes(c)) for c, o in zip(calls, outcomes, strict=True)
    ]
    yield from _wrong(question, calls, values, answers)
    slowest = int(np.argmax([outcome.seconds for outcome in outcomes]))
    if outcomes[slowest].seconds > question.limit:
        yield "slow", _slow(question, calls[slowest], outcomes[slowest]), slowest


def _form(question: Question, call: Call, outcome: Outcome) -> Iterator[tuple[Rung, str]]:
    """Yield the failures of an outcome that do not depend on its values."""
    name = question.function
    if outcome.status == "missing":
        yield "missing", f"There is no function {name}. Run the cell that defines it."
    elif outcome.status == "unwritten":
        yield "unwritten", f"Write {name}, run its cell, and then this one again."
    elif outcome.status == "raised":
        place = f" It arises in {outcome.line}." if outcome.line else ""
        yield "exception", f"For {call.case}, {name} stops with {outcome.error}.{place}"
    elif outcome.status == "timed out":
        yield "endless", f"For {call.case}, {name} was stopped after {outcome.seconds:.0f} seconds."
    elif outcome.values is None:
        wanted = " and ".join(map(shape_in_words, question.shapes(call)))
        yield "type", f"For {call.case}, {name} returns {outcome.returned}. It should be {wanted}."
    else:
        yield from _array_form(question, call, outcome, outcome.values)


def _array_form(
    question: Question, call: Call, outcome: Outcome, returned: Values
) -> Iterator[tuple[Rung, str]]:
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
                "NaN or infinite: look for a division by zero, or a logarithm of zero."
            ),
        )
    if outcome.modified:
        which = ", ".join(str(i + 1) for i in outcome.modified)
        yield (
            "modified",
            (
                f"{question.function} changes its argument number {which}, which belongs to the "
                "caller. Operators such as += work in place: take a copy first."
            ),
        )


def _wrong(
    question: Question, calls: Sequence[Call], values: Sequence[Values], answers: Answers | None
) -> Iterator[Failure]:
    """Yield the first violated law, with the largest difference from the right answer."""
    index, difference = _difference(question, calls, values, answers)
    for law in question.laws:
        with np.errstate(all="ignore"):  # wrong values may be of any size
            deviation = float(law.deviation(calls, values))
        if not deviation <= law.tolerance:
            yield (
                "wrong",
                f"{law.sentence} {difference or _off(deviation, law.tolerance)}".strip(),
                index,
            )
            return
    if difference:
        yield "wrong", difference, index


def _difference(
    question: Question, calls: Sequence[Call], values: Sequence[Values], answers: Answers | None
) -> tuple[int | None, str]:
    """Return the call with the largest difference from the right answer, and a description."""
    if answers is None:
        return None, ""
    triples = zip(calls, values, answers.right, strict=True)
    differences = [question.differences(*triple) for triple in triples]
    worst = int(np.argmax([max(d.max(initial=0.0) for d in parts) for parts in differences]))
    part = int(np.argmax([d.max(initial=0.0) for d in differences[worst]]))
    units = differences[worst][part]
    if units.max(initial=0.0) <= 1:
        return None, ""
    call, wanted = calls[worst], answers.right[worst][part]
    tolerance = max(question.tolerance(call), LEAST_TOLERANCE) * scale(wanted)
    off = units.max() * tolerance
    text = f"For {call.case}, {_entry(units, part, len(differences[worst]))} is off by {off:.2g}"
    if _whole(wanted):
        return worst, f"{text}; all values here are whole numbers."
    return worst, (
        f"{text}, where the largest right value is {scale(wanted):.2g}; "
        f"rounding explains {tolerance:.0e}."
    )


def _off(deviation: float, tolerance: float) -> str:
    """Return the size of the violation of a law, if it is not an integer or infinite."""
    if not np.isfinite(deviation) or deviation == round(deviation):
        return ""
    return f"It is off by {deviation:.2g}; rounding explains {tolerance:.0e}."


def _whole(values: np.ndarray) -> bool:
    return bool((values == np.round(values)).all())


def _entry(units: np.ndarray, part: int, parts: int) -> str:
    of = f" of array {part + 1}" if parts > 1 else ""
    if units.ndim == 0:
        return f"the number{of}" if not of else f"number {part + 1}"
    index = np.unravel_index(int(np.argmax(units)), units.shape)
    return f"entry [{', '.join(str(int(i)) for i in index)}]{of}"


def _slow(question: Question, call: Call, outcome: Outcome) -> str:
    return (
        f"The numbers are right, but for {call.case} {question.function} took "
        f"{outcome.seconds:.1f} seconds; {question.limit:.0f} should do. "
        "Let NumPy work on whole arrays."
    )
