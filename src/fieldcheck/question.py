"""A question: the requested function, its inputs, and the laws that it must satisfy."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import wraps
from typing import Any, Literal

import numpy as np

from fieldcheck.calls import Call, Values

LEAST_TOLERANCE = 1e-9
"""Smallest tolerance: known answers are stored with twelve digits."""

Picture = Literal["values", "polygon", "sides"]
Shape = tuple[int, ...]
Deviation = Callable[[Sequence[Call], Sequence[Values]], float]


@dataclass(frozen=True)
class Law:
    """A requirement that every right answer satisfies for all inputs; it needs no reference.

    Parameters
    ----------
    sentence : str
        What must hold, and the meaning of a violation.
    deviation : callable
        ``deviation(calls, values) -> float``, relative; zero if the law holds exactly.
    tolerance : float
        The largest deviation that rounding explains.
    of_each : bool
        Whether it holds for each call alone, so that calls need not be compared.
    amount : str
        What the deviation of one call is, with ``{}`` for the number, where this says more than the
        difference from the right answer.
    """

    sentence: str
    deviation: Deviation
    tolerance: float = LEAST_TOLERANCE
    of_each: bool = False
    amount: str = ""


def law(sentence: str, tolerance: float = LEAST_TOLERANCE) -> Callable[[Deviation], Law]:
    """Declare the function below as the deviation from the law of this sentence."""
    return lambda deviation: Law(sentence, deviation, tolerance)


def law_of_each(
    sentence: str, tolerance: float = LEAST_TOLERANCE, amount: str = ""
) -> Callable[[Callable[[Call, Values], float]], Law]:
    """Declare the function below as the deviation of one call; the largest, or NaN, counts."""

    def declare(deviation: Callable[[Call, Values], float]) -> Law:
        @wraps(deviation)
        def largest(calls: Sequence[Call], values: Sequence[Values]) -> float:
            return float(np.max([deviation(*each) for each in zip(calls, values, strict=True)]))

        return Law(sentence, largest, tolerance, of_each=True, amount=amount)

    return declare


def unchanged(_: Call, values: Values) -> Values:
    """Return the values as they are."""
    return values


def least_tolerance(_: Call) -> float:
    """Return the tolerance of a well-conditioned question."""
    return LEAST_TOLERANCE


@dataclass(frozen=True)
class Question:
    """A question, and how an answer is checked.

    Parameters
    ----------
    name : str
        ``"02.3"``: notebook and number.
    function : str
        The function that the student writes.
    points : int
        The points of a right answer.
    inputs : callable
        ``inputs(seed) -> calls``; calls of other seeds have the same cases with other values.
    shapes : callable
        ``shapes(call)``: the shape of each array to be returned.
    laws : sequence of Law
        The laws.
    tolerance : callable
        ``tolerance(call)``: relative to the largest entry, from the condition of the problem.
    normal_form : callable
        ``normal_form(call, values) -> values`` removes what the question leaves open, such as a
        sign or an order, before answers are compared.
    fingerprint : callable, optional
        ``fingerprint(call, values) -> values``: the part of the values by which mistakes are
        recognized, if the normal form of a mistake depends on rounding. It may be given values
        that are not finite, and may leave them out. The default is the normal form.
    limit : float
        Time limit of one call, in seconds.
    may_call : tuple of str
        Earlier questions whose functions a right answer may call, beside those that the solution
        calls. If they are wrong, the grader gives it right ones.
    picture : str
        How wrong values are drawn: ``"polygon"`` if they are the corners of one in the plane,
        ``"sides"`` if they are vectors at the sides of the triangle that is the only argument,
        each opposite to the corner of its row.
    """

    name: str
    function: str
    points: int
    inputs: Callable[[int], tuple[Call, ...]]
    shapes: Callable[[Call], tuple[Shape, ...]]
    laws: tuple[Law, ...] = field(default=())
    tolerance: Callable[[Call], float] = least_tolerance
    normal_form: Callable[[Call, Values], Values] = unchanged
    fingerprint: Callable[[Call, Values], Values] | None = None
    limit: float = 5.0
    may_call: tuple[str, ...] = ()
    picture: Picture = "values"

    @property
    def notebook(self) -> str:
        """The number of its notebook: ``"02"``."""
        return self.name.partition(".")[0]

    def differences(self, call: Call, values: Values, others: Values) -> list[np.ndarray]:
        """Return |values − others| in normal form, in units of the tolerance, array by array."""
        pairs = zip(self.normal_form(call, values), self.normal_form(call, others), strict=True)
        return [np.abs(a - b) / (self._unit(call) * scale(b)) for a, b in pairs]

    def fingerprint_differences(
        self, call: Call, values: Values, others: Values, right: Values
    ) -> list[np.ndarray]:
        """Return |values − others| by their fingerprints, in units of the tolerance.

        The tolerance is relative to the right values, or to the others if these are larger: a
        mistake that should return zero returns rounding errors.
        """
        form = self.fingerprint or self.normal_form
        triples = zip(*(form(call, v) for v in (values, others, right)), strict=True)
        return [np.abs(a - b) / (self._unit(call) * scale(b, r)) for a, b, r in triples]

    def _unit(self, call: Call) -> float:
        return max(self.tolerance(call), LEAST_TOLERANCE)


def scale(*arrays: np.ndarray) -> float:
    """Return the largest absolute entry of the arrays, or one if all entries are zero."""
    largest = max(float(np.abs(values).max(initial=0.0)) for values in arrays)
    return largest if largest > 0 else 1.0


def relative(deviation: Any, reference: Any) -> float:
    """Return the largest entry of `deviation` relative to the largest of `reference`."""
    return float(np.abs(deviation).max(initial=0.0)) / scale(np.asarray(reference))
