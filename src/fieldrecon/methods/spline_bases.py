"""Bases of splines: B-splines by their three definitions, and from truncated powers to r^3."""

from __future__ import annotations

import itertools
import math

import numpy as np
from numpy.polynomial import Polynomial
from numpy.typing import ArrayLike

from fieldrecon._core.validation import as_degree, as_line, as_numbers, as_queries, unmasked


def b_splines(knots: ArrayLike, degree: int, x: ArrayLike) -> np.ndarray:
    """B-splines by recursion: non-negative, of local support, with the sum one.

    B_(i,0) = 1 on [t_i, t_(i+1)), else 0; the last of these intervals is closed, so that the sum is
    one at the last of k + 1 coincident knots as well (de Boor); and

        B_(i,k)(x) = (x - t_i) / (t_(i+k) - t_i) B_(i,k-1)(x)
                   + (t_(i+k+1) - x) / (t_(i+k+1) - t_(i+1)) B_(i+1,k-1)(x),

    where a quotient by zero, of coincident knots, counts as zero.

    Parameters
    ----------
    knots : (n,) array_like
        Knots t, ascending; coincident knots make the splines less smooth there.
    degree : int
        Degree k, 0 or more; n >= k + 2.
    x : (...) array_like
        Evaluation points.

    Returns
    -------
    (..., n - k - 1) ndarray
        Values of all B-splines; continuous from the right, at the last knot from the left.

    Raises
    ------
    ValueError
        If the knots descend or are too few.

    References
    ----------
    Wendland (2005), p. 9; de Boor, A Practical Guide to Splines (2001), chapter IX.

    Examples
    --------
    >>> b_splines([0, 1, 2, 3, 4], 2, 1.5)
    array([0.75 , 0.125])
    """
    t, x = _knots(knots, degree), _numbers(x)
    b = ((t[:-1] <= x) & (x < t[1:])).astype(float)
    b[x[..., 0] == t[-1], np.flatnonzero(t[:-1] < t[-1])[-1:]] = 1.0
    for k in range(1, degree + 1):
        rising = _quotient(x - t[: -k - 1], t[k:-1] - t[: -k - 1])
        falling = _quotient(t[k + 1 :] - x, t[k + 1 :] - t[1:-k])
        b = rising * b[..., :-1] + falling * b[..., 1:]
    return b


def b_splines_by_divided_differences(knots: ArrayLike, degree: int, x: ArrayLike) -> np.ndarray:
    """B-splines by divided differences of truncated powers.

    B_(i,k)(x) = (t_(i+k+1) - t_i) [t_i, ..., t_(i+k+1)] (. - x)_+^k. Where j + 1 knots coincide the
    difference is the derivative of order j over j!. The powers cancel far from their support:
    use `b_splines` for computing.

    Parameters
    ----------
    knots : (n,) array_like
        Knots t, ascending.
    degree : int
        Degree k, 0 or more; n >= k + 2.
    x : (...) array_like
        Evaluation points.

    Returns
    -------
    (..., n - k - 1) ndarray
        Values of all B-splines; continuous from the right, at the last knot from the left.

    References
    ----------
    Wendland (2005), p. 9; Curry and Schoenberg (1966).
    """
    t, x = _knots(knots, degree), _numbers(x)
    columns = [
        (window[-1] - window[0]) * _divided_difference(window, degree, x[..., 0], t[-1])
        for window in np.lib.stride_tricks.sliding_window_view(t, degree + 2)
    ]
    return np.stack(columns, axis=-1)


def cardinal_b_spline(degree: int, x: ArrayLike) -> np.ndarray:
    """B-spline on the knots 0, 1, ..., degree + 1 by convolution, N_k = N_(k-1) * N_0.

    N_k(x) = integral of N_(k-1) over [x - 1, x], so that piece i of N_k, in u = x - i, is the
    integral of piece i - 1 of N_(k-1) from u to 1 and that of piece i from 0 to u.

    Parameters
    ----------
    degree : int
        Degree k, 0 or more.
    x : (...) array_like
        Evaluation points.

    Returns
    -------
    (...) ndarray
        Values; the density of the sum of k + 1 numbers drawn from [0, 1).

    References
    ----------
    Wendland (2005), p. 9; Schoenberg (1946).

    Examples
    --------
    >>> cardinal_b_spline(3, [1.0, 2.0, 3.0]) * 6
    array([1., 4., 1.])
    """
    pieces = [Polynomial([1.0])]
    for _ in range(as_degree(degree)):
        integrals = [Polynomial([0.0]), *(p.integ() for p in pieces), Polynomial([0.0])]
        pieces = [before(1) - before + here for before, here in itertools.pairwise(integrals)]
    x = _numbers(x)[..., 0]
    i = np.floor(x)
    values = [np.where(i == piece, p(x - i), 0.0) for piece, p in enumerate(pieces)]
    return np.sum(values, axis=0)


def radial_form(
    points: ArrayLike, alpha: ArrayLike, beta: ArrayLike
) -> tuple[np.ndarray, np.ndarray]:
    """From truncated powers to r^3: x_+^3 = (|x|^3 + x^3) / 2, where sum alpha = sum alpha x = 0.

    sum_j alpha_j (x - x_j)_+^3 + beta_0 + beta_1 x is a natural spline, and equals
    sum_j alpha~_j |x - x_j|^3 + beta~_0 + beta~_1 x with alpha~ = alpha / 2,
    beta~_0 = beta_0 - 1/2 sum alpha_j x_j^3 and beta~_1 = beta_1 + 3/2 sum alpha_j x_j^2.

    Parameters
    ----------
    points : (n,) array_like
        Sites x_j.
    alpha : (n, ...) array_like
        Coefficients of the truncated powers, orthogonal to the linear polynomials.
    beta : (2, ...) array_like
        Coefficients of 1 and x.

    Returns
    -------
    alpha : (n, ...) ndarray
        Coefficients of r^3.
    beta : (2, ...) ndarray
        Coefficients of 1 and x.

    References
    ----------
    Wendland (2005), equations 1.4 to 1.7.

    Examples
    --------
    >>> radial_form([0.0, 1.0, 2.0], [1.0, -2.0, 1.0], [0.0, 0.0])
    (array([ 0.5, -1. ,  0.5]), array([-3.,  3.]))
    """
    x, alpha, beta = (
        np.asarray(unmasked(a, name))
        for a, name in ((points, "points"), (alpha, "alpha"), (beta, "beta"))
    )
    first = beta[0] - np.tensordot(x**3, alpha, axes=1) / 2
    second = beta[1] + 1.5 * np.tensordot(x**2, alpha, axes=1)
    return alpha / 2, np.stack([first, second])


def _knots(knots: ArrayLike, degree: int) -> np.ndarray:
    t = as_line(knots, "knots")[:, 0]
    if len(t) < as_degree(degree) + 2:
        raise ValueError(f"B-splines of degree {degree} need {degree + 2} knots; got {len(t)}")
    if (np.diff(t) < 0).any():
        raise ValueError(
            f"knots must ascend; knots[{int(np.argmax(np.diff(t) < 0))}] is larger than the next"
        )
    return t


def _numbers(x: ArrayLike) -> np.ndarray:
    return as_queries(as_numbers(x, "x", complex_allowed=False)[..., None], 1)


def _quotient(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.where(b > 0, a / np.where(b > 0, b, 1.0), 0.0)


def _divided_difference(t: np.ndarray, degree: int, x: np.ndarray, last: float) -> np.ndarray:
    """[t_0, ..., t_n] (. - x)_+^degree at each x, by the triangle of differences."""
    closed = x == last
    level = [_power(knot - x, degree, closed) for knot in t]
    for j in range(1, len(t)):
        level = [
            (level[i + 1] - level[i]) / (t[i + j] - t[i])
            if t[i + j] > t[i]
            else math.comb(degree, j) * _power(t[i] - x, degree - j, closed)
            for i in range(len(t) - j)
        ]
    return level[0]


def _power(y: np.ndarray, degree: int, closed: np.ndarray) -> np.ndarray:
    """Truncated power y_+^degree; y_+^0 is zero at zero, but one where it is closed."""
    there = (y > 0) | (closed & (y == 0))
    return np.where(there, y, 0.0) ** degree * there if degree >= 0 else np.zeros_like(y)
