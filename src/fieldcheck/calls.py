"""Calls of a student's function, and their outcomes, as plain data.

A check never inspects the function: it states calls and judges outcomes. A notebook performs the
calls in its own process, a grader in another one.
"""

from __future__ import annotations

import copy
import signal
import threading
import time
import traceback
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from numbers import Real
from types import CodeType
from typing import Any, Literal

import numpy as np

Status = Literal["returned", "raised", "unwritten", "missing", "timed out"]
Values = tuple[np.ndarray, ...]

MOST_ARRAYS = 4
"""No function of the course returns more arrays."""
LONGEST_ERROR = 10_000
"""Characters of an error that are read: one of 50 MB takes a tenth of a second each time."""

MATRIX = "an np.matrix"
LIST = "a list"
ONE_ROW = "a tuple of one row"


@dataclass(frozen=True)
class Call:
    """A call: the name of the function, its arguments, and the case.

    Parameters
    ----------
    function : str
        The name of the student's function.
    arguments : tuple
        Arrays and numbers, in order.
    case : str
        The case, in words that can follow "for": ``"five points on a line"``.
    exact : tuple of int
        Positions of the arguments that are degenerate on purpose, such as a point exactly on an
        edge, a tie, or collinear points. The tests of the graders do not perturb them, since a
        change in their last digits would change the problem.
    """

    function: str
    arguments: tuple[Any, ...]
    case: str
    exact: tuple[int, ...] = ()


def calls_of(function: str, *cases: tuple[tuple[Any, ...], str]) -> tuple[Call, ...]:
    """Return the calls of one function, from the arguments and the words of each case.

    Examples
    --------
    >>> [call.arguments for call in calls_of("area", ((2, 3), "a rectangle"), ((1, 1), "a square"))]
    [(2, 3), (1, 1)]
    """
    return tuple(Call(function, arguments, case) for arguments, case in cases)


def integers(numbers: np.ndarray, size: float = 300.0) -> np.ndarray:
    """Return the numbers times `size`, rounded, as an array of integers.

    An answer that stores fractions in an array of this type, as ``np.zeros_like`` makes it, loses
    the decimals. The fourth powers of such numbers do not overflow.

    Examples
    --------
    >>> integers(np.array([0.127, -1.5]))
    array([  38, -450])
    """
    return np.rint(size * numbers).astype(int)


def in_short_binary_numbers(numbers: np.ndarray) -> np.ndarray:
    """Return numbers rounded to 24 binary digits after the point: they stay exact far away.

    Examples
    --------
    >>> in_short_binary_numbers(np.array([0.1])) + 2.0**28 - 2.0**28 == in_short_binary_numbers(
    ...     np.array([0.1])
    ... )
    array([ True])
    """
    return np.asarray(np.round(numbers * 2.0**24) / 2.0**24)


@dataclass(frozen=True)
class Outcome:
    """The outcome of a call.

    Parameters
    ----------
    status : str
        ``"returned"``, ``"raised"``, ``"unwritten"`` (NotImplementedError), ``"missing"`` (no such
        function), ``"timed out"``.
    values : tuple of ndarray, optional
        The returned values: several arrays for a tuple, else one; None if they are not numeric.
    returned : str
        A description of the returned object, if it is not an array or a tuple of several arrays.
    error : str
        Type and message of the exception.
    line : str
        The line of the student's code that raised it.
    seconds : float
        Elapsed time or processor time, whichever is less.
    modified : tuple of int
        Positions of arguments that the call changed.
    """

    status: Status
    values: Values | None = None
    returned: str = ""
    error: str = ""
    line: str = ""
    seconds: float = 0.0
    modified: tuple[int, ...] = ()


class OutOfTime(BaseException):
    """Raised inside a call that takes too long; not an Exception, which a bare call might catch."""


def perform(functions: dict[str, Any], calls: Sequence[Call], limit: float) -> tuple[Outcome, ...]:
    """Make the calls, each with copies of its arguments and a time limit in seconds.

    After a time-out, or if the function does not exist, the other calls are skipped.
    """
    outcomes: list[Outcome] = []
    for call in calls:
        outcomes.append(_perform_one(functions.get(call.function), call, limit))
        if outcomes[-1].status not in ("returned", "raised"):
            return tuple(outcomes + [outcomes[-1]] * (len(calls) - len(outcomes)))
    return tuple(outcomes)


def _perform_one(function: Callable[..., Any] | None, call: Call, limit: float) -> Outcome:
    if not callable(function):
        return Outcome("missing")
    arguments = copy.deepcopy(call.arguments)
    start = _clocks()
    try:
        with _deadline(limit), warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")
            result = function(*arguments)
    except NotImplementedError:
        return Outcome("unwritten")
    except OutOfTime:
        return Outcome("timed out", seconds=limit)
    except (Exception, SystemExit) as error:
        return Outcome("raised", error=_in_words(error), line=own_line(error, function))
    values = as_arrays(result)
    return Outcome(
        "returned",
        values=values,
        returned=_kind(result, values),
        seconds=min(now - then for now, then in zip(_clocks(), start, strict=True)),
        modified=tuple(
            i
            for i, (now, before) in enumerate(zip(arguments, call.arguments, strict=True))
            if not _same(now, before)
        ),
    )


def as_arrays(result: object) -> Values | None:
    """Return a result as arrays, or None if it is not numeric.

    A tuple holds several arrays, as does a short list, or array of objects, that is not
    rectangular.

    Examples
    --------
    >>> as_arrays([1, 2])
    (array([1, 2]),)
    >>> len(as_arrays((1.0, [2, 3]))), len(as_arrays([1.0, [2, 3]]))
    (2, 2)
    >>> as_arrays("three") is as_arrays([[[1], 2], 3]) is as_arrays(None) is None
    True
    >>> as_arrays(np.array([1, 2], dtype=object))
    (array([1., 2.]),)
    """
    parts = result if isinstance(result, tuple) else (result,)
    is_row = isinstance(result, list) or (isinstance(result, np.ndarray) and result.ndim == 1)
    if is_row and len(result) <= MOST_ARRAYS and _as_array(result) is None:  # type: ignore[arg-type]
        parts = tuple(result)  # type: ignore[arg-type]
    arrays = tuple(_as_array(part) for part in parts)
    return None if not arrays or any(array is None for array in arrays) else arrays  # type: ignore[return-value]


def _as_array(part: object) -> np.ndarray | None:
    try:
        array = np.array(part)
        if array.dtype.kind == "O" and all(isinstance(x, Real) for x in array.flat):
            array = array.astype(float)
    except Exception:  # a ragged list, or an object that is not a number
        return None
    return array if array.dtype.kind in "biufc" else None


def _kind(result: object, values: Values | None) -> str:
    """Describe a result that is not numeric, or that is packed in an unusual way."""
    if result is None:
        return "nothing (None), as where no `return` is reached"
    if values is None and isinstance(result, list):
        return "a list that is not a rectangular array of numbers"
    if values is None:
        return f"an object of type {type(result).__name__}"
    parts = result if isinstance(result, tuple | list) else (result,)
    if any(isinstance(part, np.matrix) for part in parts):
        return MATRIX
    if isinstance(result, list):
        return LIST
    return ONE_ROW if isinstance(result, tuple) and len(result) == 1 else ""


def _clocks() -> tuple[float, float]:
    """Return the time and the processor time.

    A busy machine lets an answer wait, and threads of NumPy use several processors at once.
    """
    return time.perf_counter(), time.process_time()


def _same(now: Any, before: Any) -> bool:
    if isinstance(before, np.ndarray):
        return bool(np.array_equal(now, before, equal_nan=before.dtype.kind in "fc"))
    return bool(now == before)


def _in_words(error: BaseException) -> str:
    text = " ".join(str(error)[:LONGEST_ERROR].split())
    return f"{type(error).__name__}: {text}" if text else type(error).__name__


def own_line(error: BaseException, function: Callable[..., Any]) -> str:
    """Return the line of the student's code that raised an error, counted from its `def`.

    It is the innermost function in the file or cell of the function, or in another cell; libraries
    do not count, and of a comprehension the function around it does.
    """
    code = getattr(function, "__code__", None)
    frames = zip(
        traceback.walk_tb(error.__traceback__),
        traceback.extract_tb(error.__traceback__),
        strict=True,
    )
    for (frame, line), found in reversed(list(frames)):
        if _is_own(found.filename, code) and not found.name.startswith("<"):
            text = f": {found.line}" if found.line else ""
            return f"line {line - frame.f_code.co_firstlineno + 1} of {found.name}{text}"
    return ""


def _is_own(filename: str, code: CodeType | None) -> bool:
    if code is not None and filename == code.co_filename:
        return True
    return "ipykernel" in filename or filename.startswith("<ipython-input")


@contextmanager
def _deadline(limit: float) -> Iterator[None]:
    """Interrupt a call after `limit` seconds, if the system has timers.

    Only the main thread can be interrupted, and not on Windows; elsewhere the time is only
    measured.
    """
    if not hasattr(signal, "setitimer") or threading.current_thread() != threading.main_thread():
        yield
        return

    def stop(*_: object) -> None:
        raise OutOfTime

    before = signal.signal(signal.SIGALRM, stop)
    signal.setitimer(signal.ITIMER_REAL, limit)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
