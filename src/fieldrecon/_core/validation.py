"""Checks of arguments and results: shapes, types, and finite numbers."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import wraps
from numbers import Real
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike
from scipy import sparse

MAX_SHOWN = 6
"""Coordinates of a format_point that an error spells out."""


def as_points(points: ArrayLike, name: str = "points", none_allowed: bool = False) -> np.ndarray:
    """Sites as a read-only float array (n, d), d and n at least 1; n may be zero where allowed."""
    p = as_numbers(points, name, complex_allowed=False)
    if p.ndim != 2 or p.shape[1] == 0:
        hint = f"; for one variable write {name}[:, None]" if p.ndim == 1 else ""
        raise ValueError(f"{name} must have the shape (n, d); got {p.shape}{hint}")
    if len(p) == 0 and not none_allowed:
        raise ValueError(f"{name} must hold at least one point; got the shape {p.shape}")
    p = p.copy()
    p.flags.writeable = False
    return p


def as_line(points: ArrayLike, name: str = "points") -> np.ndarray:
    """Sites on a line, given without an axis, as a read-only float array (n, 1), n at least 1."""
    p = as_numbers(points, name, complex_allowed=False)
    if p.ndim != 1 or len(p) == 0:
        raise ValueError(f"{name} must have the shape (n,), without an axis; got {p.shape}")
    return as_points(p[:, None], name)


def as_queries(x: ArrayLike, d: int, name: str = "x") -> np.ndarray:
    """Queries as a float array (..., d)."""
    q = as_numbers(x, name, complex_allowed=False)
    if q.ndim == 0 or q.shape[-1] != d:
        wanted = "1 coordinate" if d == 1 else f"{d} coordinates"
        hint = f"; for one variable write {name}[..., None]" if d == 1 else ""
        raise ValueError(
            f"{name} must have {wanted} per point, shape (..., {d}); got {q.shape}{hint}"
        )
    return q


def as_values(values: ArrayLike, n: int, name: str = "values", of: str = "point") -> np.ndarray:
    """Data as a float or complex array (n, ...), one row for each point."""
    v = as_numbers(values, name, complex_allowed=True)
    if v.ndim == 0 or len(v) != n:
        raise ValueError(
            f"{name} must have one entry for each {of}, shape ({n}, ...); got {v.shape}"
        )
    return v


def as_degree(degree: int, lowest: int = 0) -> int:
    """A polynomial degree: an integer, `lowest` or more."""
    return as_count(degree, "degree", lowest)


def as_count(
    count: int, name: str, lowest: int = 1, highest: float = math.inf, wanted: str = ""
) -> int:
    """An integer from `lowest` to `highest`; `wanted` describes it in the error message."""
    known = isinstance(count, int | np.integer) and not isinstance(count, bool)
    if not known or not lowest <= count <= highest:
        wanted = wanted or f"an integer, {lowest} or more"
        raise ValueError(f"{name} must be {wanted}; got {count!r}")
    return int(count)


def as_length(length: float, name: str, zero_allowed: bool = False) -> float:
    """A length parameter: finite and positive, or zero where that has a meaning."""
    bound = "zero or a positive" if zero_allowed else "a positive"
    try:
        known = isinstance(length, Real) and not isinstance(length, bool)
        number = float(length) if known else math.nan
    except OverflowError:
        number = math.inf
    if not 0 <= number < math.inf or (number == 0 and not zero_allowed):
        raise ValueError(f"{name} must be {bound} number; got {length!r}")
    return number


def unmasked(a: ArrayLike, name: str) -> ArrayLike:
    """The argument, refused if it is a masked array with a masked entry.

    `np.asarray` would drop the mask, and make data of what it hides.
    """
    rows = a if isinstance(a, list | tuple) else [a]
    masked = sum(int(np.ma.count_masked(row)) for row in rows if np.ma.isMaskedArray(row))
    if masked:
        if rows[0] is not a:  # a list of arrays
            remedy = f"{name}[~mask]"
        elif np.ndim(a) == 1:
            remedy = f"{name}.compressed()"
        else:  # whole rows: `[~mask]` of the mask of the entries would make one long row of them
            remedy = f"numpy.ma.compress_rows({name})" if np.ndim(a) == 2 else f"{name}[~mask]"
        raise ValueError(
            f"{name} must have no masked entries, and {masked} of {np.size(a)} are masked: the "
            f"numbers behind a mask are not data: leave them out, for instance by {remedy}, and "
            "the same rows of the arrays that belong to it"
        )
    return a


def as_numbers(a: ArrayLike, name: str, complex_allowed: bool = True) -> np.ndarray:
    """Finite numbers of any shape as a float or complex array, which may be the argument itself."""
    a = unmasked(a, name)
    try:
        array = np.asarray(a)
    except ValueError:
        raise ValueError(f"{name} must be an array of numbers; its rows differ in length") from None
    kinds = "biufc" if complex_allowed else "biuf"
    if array.dtype.kind not in kinds:
        wanted = "numbers" if complex_allowed else "real numbers"
        raise ValueError(f"{name} must be an array of {wanted}; got the type {array.dtype}")
    array = array.astype(np.complex128 if array.dtype.kind == "c" else np.float64, copy=False)
    if not np.isfinite(array).all():
        where = tuple(int(i) for i in np.argwhere(~np.isfinite(array))[0])
        raise ValueError(f"{name} must be finite; {name}{list(where) or ''} is {array[where]}")
    return array


Function = TypeVar("Function", bound=Callable[..., Any])


def finite(what: str) -> Callable[[Function], Function]:
    """Decorator that raises an OverflowError about `what` if a function's result is not finite."""

    def decorated(function: Function) -> Function:
        @wraps(function)
        def checked(*arguments: Any, **options: Any) -> Any:
            with np.errstate(all="ignore"):
                result = function(*arguments, **options)
            parts = result if isinstance(result, tuple) else (result,)
            if not all(np.isfinite(part).all() for part in parts):
                raise OverflowError(
                    f"{what} exceed the range of floating-point numbers; choose a unit nearer to "
                    "the size of the points and the data"
                )
            return result

        return checked  # type: ignore[return-value]

    return decorated


def quiet_evaluate(function: Callable[..., Any], *arguments: Any) -> Any:
    """Result of a computation without warnings of overflow, which `check_finite` finds in it."""
    with np.errstate(all="ignore"):
        return function(*arguments)


def format_point(x: np.ndarray) -> str:
    """Coordinates of a point for an error message, the first few of many."""
    few = x if len(x) <= MAX_SHOWN else x[: MAX_SHOWN // 2]
    shown = ", ".join(f"{c:.6g}" for c in few)
    return shown if len(few) == len(x) else f"{shown}, … of {len(x)} coordinates"


def check_finite(result: Any, x: np.ndarray) -> Any:
    """The result, one row for each point x, if it is finite; the error names a point if not."""
    entries = result.data if sparse.issparse(result) else result
    if not np.isfinite(entries).all():
        wrong = ~np.isfinite(result.toarray() if sparse.issparse(result) else result)
        where = format_point(x[np.argwhere(wrong)[0][0]])
        raise OverflowError(f"the result at ({where}) exceeds the range of floating-point numbers")
    return result
