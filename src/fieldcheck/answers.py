"""Known answers on fixed inputs: the right values, and the values of known mistakes.

The values on the public cases are in ``answers/``. A mistake is recognized by its values, so that
neither its code nor the code of a solution is in this package.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Any

import numpy as np

from fieldcheck.calls import Call, Outcome, Values
from fieldcheck.question import Question
from fieldcheck.shapes import fitted

DIGITS = 12
"""Significant digits of stored values."""
ROUNDING = 1e-12
"""A part of the largest argument: a wrong answer with smaller numbers returns rounding errors."""


@dataclass(frozen=True)
class Mistake:
    """A known wrong answer.

    Parameters
    ----------
    name : str
        A few words: ``"weights not squared"``.
    sentence : str
        The sentence for the student.
    outcomes : tuple of Outcome
        The outcomes of the calls.
    """

    name: str
    sentence: str
    outcomes: tuple[Outcome, ...]


@dataclass(frozen=True)
class Answers:
    """The known answers to the calls of a question."""

    right: tuple[Values, ...]
    mistakes: tuple[Mistake, ...]

    def recognize(
        self, question: Question, calls: Sequence[Call], outcomes: Sequence[Outcome]
    ) -> Mistake | None:
        """Return the mistake with the same values, within the tolerance, or None."""
        near = [m for m in self.mistakes if self._is_near(question, calls, outcomes, m.outcomes)]
        return min(
            near, key=lambda m: self.distance(question, calls, outcomes, m.outcomes), default=None
        )

    def distance(
        self,
        question: Question,
        calls: Sequence[Call],
        outcomes: Sequence[Outcome],
        others: Sequence[Outcome],
    ) -> float:
        """Return the distance of two sets of outcomes, in units of the tolerance.

        It is infinite if one returned and the other did not, if the shapes differ, or if no call
        returned: an exception alone does not identify a mistake.
        """
        apart = self._distances(question, calls, outcomes, others)
        return max(apart, default=np.inf) if _any_returned(outcomes) else np.inf

    def _is_near(
        self,
        question: Question,
        calls: Sequence[Call],
        outcomes: Sequence[Outcome],
        others: Sequence[Outcome],
    ) -> bool:
        """Whether the distance is at most one; most answers are far at the first call already."""
        apart = self._distances(question, calls, outcomes, others)
        return _any_returned(outcomes) and all(d <= 1 for d in apart)

    def _distances(
        self,
        question: Question,
        calls: Sequence[Call],
        outcomes: Sequence[Outcome],
        others: Sequence[Outcome],
    ) -> Iterator[float]:
        for each in zip(calls, outcomes, others, self.right, strict=True):
            yield _distance(question, *each)


def _any_returned(outcomes: Sequence[Outcome]) -> bool:
    return any(outcome.status == "returned" for outcome in outcomes)


def _distance(question: Question, call: Call, one: Outcome, other: Outcome, right: Values) -> float:
    if one.status != other.status or (one.values is None) != (other.values is None):
        return np.inf
    if one.values is None or other.values is None:
        return 0.0 if one.error.partition(":")[0] == other.error.partition(":")[0] else np.inf
    shapes = question.shapes(call)
    values, known = fitted(one.values, shapes), fitted(other.values, shapes)
    if [v.shape for v in values] != [v.shape for v in known]:
        return np.inf
    if [v.shape for v in known] != list(shapes):
        return _plain_distance(question, call, values, known, right)
    finite, known_finite = (_finite(question, call, v) for v in (values, known))
    if any((a != b).any() for a, b in zip(finite, known_finite, strict=True)):
        return np.inf
    if not all(f.all() for f in known_finite):
        return _plain_distance(question, call, values, known, right)
    apart = question.fingerprint_differences(call, values, known, right)
    return max(float(d.max(initial=0.0)) for d in apart)


def _finite(question: Question, call: Call, values: Values) -> Values:
    """Return which values are finite; a fingerprint may leave out others.

    A normal form is not applied: it may need finite values.
    """
    with np.errstate(all="ignore"):
        kept = question.fingerprint(call, values) if question.fingerprint else values
    return tuple(np.isfinite(v) for v in kept)


def _plain_distance(
    question: Question, call: Call, values: Values, known: Values, right: Values
) -> float:
    """Compare values without a normal form: wrong shapes, or values that are not finite.

    The order of rows is ignored, and so are numbers that are rounding errors of the arguments. The
    order of columns is ignored if the question leaves it open.
    """
    tolerance = question.tolerance(call)
    rounding = ROUNDING * max(_scale(np.asarray(a)) for a in call.arguments)

    def same(a: np.ndarray, b: np.ndarray) -> bool:
        atol = max(tolerance * _scale(b), rounding)
        return np.allclose(a, b, rtol=tolerance, atol=atol, equal_nan=True)

    pairs = list(zip(values, known, strict=True))
    near = all(same(rows_sorted(a), rows_sorted(b)) for a, b in pairs)
    if not near and _order_of_columns_is_open(question, call, right):
        near = all(same(rows_sorted(a.T), rows_sorted(b.T)) for a, b in pairs)
    return 0.0 if near else np.inf


def _order_of_columns_is_open(question: Question, call: Call, right: Values) -> bool:
    """Return whether the right matrix is still right with its columns in the opposite order."""
    other = tuple(v[:, ::-1] if v.ndim == 2 else v for v in right)
    changed = any(not np.array_equal(a, b) for a, b in zip(other, right, strict=True))
    apart = question.differences(call, other, right)
    return changed and all(d.max(initial=0.0) <= 1 for d in apart)


def rows_sorted(a: np.ndarray) -> np.ndarray:
    """Return a matrix with its rows in an order that rounding errors do not change."""
    return a[np.lexsort(np.round(a / _scale(a), 6).T)] if a.ndim == 2 and a.size else a


def _scale(array: np.ndarray) -> float:
    finite = np.abs(array[np.isfinite(array)])
    return float(finite.max(initial=0.0)) or 1.0


def to_json(answers: Answers) -> dict[str, Any]:
    """Return answers as data for ``json``."""
    return {
        "right": [arrays_to_json(values) for values in answers.right],
        "mistakes": [
            {
                "name": mistake.name,
                "sentence": mistake.sentence,
                "outcomes": [
                    {
                        "status": o.status,
                        "error": o.error.partition(":")[0],
                        "values": None if o.values is None else arrays_to_json(o.values),
                    }
                    for o in mistake.outcomes
                ],
            }
            for mistake in answers.mistakes
        ],
    }


def from_json(data: Mapping[str, Any]) -> Answers:
    """Return the answers that `to_json` wrote."""
    return Answers(
        right=tuple(arrays_from_json(values) for values in data["right"]),
        mistakes=tuple(
            Mistake(m["name"], m["sentence"], tuple(_outcome(o) for o in m["outcomes"]))
            for m in data["mistakes"]
        ),
    )


def _outcome(data: Mapping[str, Any]) -> Outcome:
    values = None if data["values"] is None else arrays_from_json(data["values"])
    return Outcome(data["status"], values=values, error=data["error"])


def arrays_to_json(values: Values) -> list[dict[str, Any]]:
    """Return arrays of real numbers as data for ``json``, with twelve digits."""
    return [
        {"shape": list(v.shape), "numbers": [float(f"{x:.{DIGITS}g}") for x in v.ravel().tolist()]}
        for v in values
    ]


def arrays_from_json(data: Sequence[Mapping[str, Any]]) -> Values:
    """Return the arrays that `arrays_to_json` wrote."""
    return tuple(np.array(d["numbers"], dtype=float).reshape(d["shape"]) for d in data)


@cache
def public_answers(notebook: str) -> Mapping[str, Answers]:
    """Return the known answers on the public cases of the questions of a notebook."""
    file = files("fieldcheck") / "answers" / f"{notebook}.json"
    if not file.is_file():
        return {}
    data = json.loads(file.read_text(encoding="utf-8"))
    return {name: from_json(answers) for name, answers in data.items()}
