"""The case for which an answer failed: its arguments, the returned values, and the right ones."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from fieldcheck.answers import Answers
from fieldcheck.calls import Call, Outcome, Values
from fieldcheck.question import Question
from fieldcheck.shapes import are_whole, fitted, in_words, shape_in_words
from fieldcheck.verdict import WAITING, Verdict


@dataclass(frozen=True)
class FailedCase:
    """A call of a student's function that was not right.

    Parameters
    ----------
    question : Question
        The question.
    call : Call
        The call.
    outcome : Outcome
        Its outcome.
    known : tuple of ndarray, optional
        The right values. They are stored only for the inputs that are the same for everybody.
    """

    question: Question
    call: Call
    outcome: Outcome
    known: Values | None = None

    @property
    def arguments(self) -> tuple[Any, ...]:
        """The arguments, as copies: ``fit(*case().arguments)`` repeats the call."""
        return copy.deepcopy(self.call.arguments)

    @property
    def returned(self) -> Any:
        """What the function returned: an array or number, a tuple of them, or None."""
        values = self.outcome.values
        return values and _unpacked(fitted(values, self.question.shapes(self.call)))

    @property
    def right(self) -> Any:
        """The right array or number, a tuple of them, or None if it is not known."""
        return self.known and _unpacked(self.known)

    def __repr__(self) -> str:
        name = self.question.function
        given = [_in_words(argument) for argument in self.call.arguments]
        right = " and ".join(map(shape_in_words, self.question.shapes(self.call)))
        lines = [
            f"{self.question.name}: {name} for {self.call.case}",
            f"case().arguments  {'; '.join(given)}",
            f"case().returned   {self._outcome()}",
            f"case().right      {right}{_shown(self.known)}",
        ]
        if self.known is None:
            lines[-1] += "; its values are not stored, since these inputs are your own"
        return "\n".join(lines)

    def _outcome(self) -> str:
        values = self.outcome.values
        if values is None:
            return self.outcome.error or self.outcome.returned or f"nothing: {self.outcome.status}"
        return f"{in_words(values)}{_shown(values)}"


def failed_case(
    verdict: Verdict,
    question: Question,
    calls: Sequence[Call],
    outcomes: Sequence[Outcome],
    answers: Answers | None,
) -> FailedCase | None:
    """Return the case of a verdict, or the first one if it is about all cases."""
    if verdict.right or verdict.finding in ("missing", *WAITING):
        return None
    index = verdict.call or 0
    known = answers.right[index] if answers else None
    return FailedCase(question, calls[index], outcomes[index], known)


def _unpacked(values: Values) -> Any:
    return values[0] if len(values) == 1 else values


def _in_words(argument: Any) -> str:
    if isinstance(argument, np.ndarray):
        return shape_in_words(argument.shape)
    return repr(argument) if isinstance(argument, (int, float, str)) else type(argument).__name__


MOST_SHOWN = 6


def _shown(values: Values | None) -> str:
    """Return the numbers, if there are few."""
    if values is None or sum(v.size for v in values) > MOST_SHOWN:
        return ""
    return ": " + " and ".join(np.array2string(_as_integers(v), precision=6) for v in values)


def _as_integers(value: np.ndarray) -> np.ndarray:
    """Return whole numbers as integers, so that a rank is 4 and not ``4.``."""
    return value.astype(int) if are_whole(value) else value
