"""The returned and the right values of a call, as the search for patterns compares them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import permutations

import numpy as np

from fieldcheck.calls import Call, Values
from fieldcheck.question import LEAST_TOLERANCE, Question, scale

FAR_OFF = 100.0
"""Errors of this many times the tolerance are no rounding errors."""


@dataclass(frozen=True, eq=False)
class Case:
    """The returned and the right arrays of a call, in normal form.

    `rows` and `dimension` are the numbers of rows and columns of the first table among the
    arguments, whose rows are points in most questions; `whole` contains the positions of the arrays
    of integers. `orders` contains the orders in which the returned arrays are the right ones.
    `moved` states whether the normal form is relative to the first corner, and `single` whether the
    returned numbers are those of float32.
    """

    name: str
    rows: int
    dimension: int
    whole: frozenset[int]
    values: Values
    right: Values
    tolerance: float
    orders: frozenset[tuple[int, ...]]
    moved: bool
    single: bool

    @property
    def pairs(self) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """The returned and the right array, one pair after the other."""
        return zip(self.values, self.right, strict=True)

    def differ(self, a: np.ndarray, b: np.ndarray) -> np.ndarray:
        """Return where two arrays of one shape differ by more than the tolerance."""
        return ~(np.abs(a - b) <= self.tolerance * scale(b))

    @property
    def is_right_whole(self) -> bool:
        """Whether all right values are integers."""
        return all((r == np.rint(r)).all() for r in self.right)

    @property
    def is_far_off(self) -> bool:
        """Whether some value differs by many times the tolerance."""
        limit = FAR_OFF * self.tolerance
        return any((~(np.abs(v - r) <= limit * scale(r))).any() for v, r in self.pairs)

    @property
    def is_exact(self) -> bool:
        """Whether no value differs by more than a small part of the tolerance."""
        limit = self.tolerance / FAR_OFF
        return all((np.abs(v - r) <= limit * scale(r)).all() for v, r in self.pairs)

    def same(self, a: np.ndarray, b: np.ndarray) -> bool:
        """Return whether two arrays are equal within the tolerance."""
        return a.shape == b.shape and not self.differ(a, b).any()

    def right_if(self, changed: Callable[[np.ndarray, np.ndarray], np.ndarray]) -> bool:
        """Return whether the values are right once `changed(value, right)` replaces them."""
        return all(self.same(changed(v, r), r) for v, r in self.pairs)


def compared(question: Question, call: Call, values: Values, right: Values) -> Case:
    """Return the values of a call, and the right ones."""
    zeros = tuple(map(np.zeros_like, right))
    case = Case(
        call.case,
        *_first_table(call),
        frozenset(k for k, a in enumerate(call.arguments) if _is_whole(a)),
        question.normal_form(call, values),
        question.normal_form(call, right),
        max(question.tolerance(call), LEAST_TOLERANCE),
        frozenset(),
        any(z.any() for z in question.normal_form(call, zeros)),
        _are_single(values),
    )

    def is_right(order: tuple[int, ...]) -> bool:
        arrays = tuple(values[k] for k in order)
        if any(a.shape != r.shape for a, r in zip(arrays, right, strict=True)):
            return False
        return all(map(case.same, question.normal_form(call, arrays), case.right))

    return replace(case, orders=frozenset(filter(is_right, permutations(range(len(right))))))


def _first_table(call: Call) -> tuple[int, int]:
    tables = (a for a in call.arguments if isinstance(a, np.ndarray) and a.ndim == 2)
    return next((table.shape for table in tables), (0, 0))


def _is_whole(argument: object) -> bool:
    return isinstance(argument, np.ndarray) and argument.dtype.kind in "iu"


def _are_single(values: Values) -> bool:
    """Whether all numbers are those of float32."""
    with np.errstate(over="ignore"):
        return all((v.astype(np.float32) == v).all() for v in values)


def are_truth_values(answers: Sequence[Values]) -> bool:
    """Whether all values of all answers are 0 or 1, so that none is too large by an amount."""
    return all(np.isin(value, (0, 1)).all() for values in answers for value in values)


def are_single_whole_numbers(answers: Sequence[Values]) -> bool:
    """Whether no answer is an array or has decimals, as with a rank or a number of pieces."""
    return all(v.ndim == 0 and float(v).is_integer() for values in answers for v in values)
