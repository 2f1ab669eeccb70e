"""Polynomials of d variables: the monomial basis b(x), its gradients, and the local frame."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache
from itertools import combinations_with_replacement
from typing import Any, ClassVar, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from fieldrecon._core.blas_threads import blas_threads_for

Derivative: TypeAlias = Any
"""A dense or sparse matrix of derivatives, which can be added and multiplied by numbers."""
EPS = float(np.finfo(np.float64).eps)
LARGE_BASIS = 500
"""Size of a basis beyond which fewer sites are refused before the basis is computed."""


def dimension(d: int, degree: int) -> int:
    """Dimension C(degree + d, d) of the polynomials of total degree <= `degree` in d variables.

    >>> dimension(2, 1), dimension(3, 2), dimension(2, -1)
    (3, 10, 0)
    """
    return math.comb(degree + d, d) if degree >= 0 else 0


@lru_cache(maxsize=256)
def exponents(d: int, degree: int) -> np.ndarray:
    """Exponents alpha (q, d) of the monomials x^alpha: 1, x1 ... xd, then by total degree.

    >>> exponents(2, 2).tolist()
    [[0, 0], [1, 0], [0, 1], [2, 0], [1, 1], [0, 2]]
    """
    rows = [
        [factors.count(k) for k in range(d)]
        for total in range(degree + 1)
        for factors in combinations_with_replacement(range(d), total)
    ]
    alpha = np.array(rows, dtype=int).reshape(-1, d)
    alpha.flags.writeable = False
    return alpha


@lru_cache(maxsize=256)
def _factors(d: int, degree: int) -> list[tuple[int, int]]:
    """For each monomial but the first: its first variable, and the index of the quotient by it."""
    index = {tuple(alpha): i for i, alpha in enumerate(exponents(d, degree))}
    steps = []
    for alpha in exponents(d, degree)[1:]:
        variable = int(np.flatnonzero(alpha)[0])
        rest = alpha.copy()
        rest[variable] -= 1
        steps.append((variable, index[tuple(rest)]))
    return steps


def monomials(x: ArrayLike, degree: int) -> np.ndarray:
    """Basis b(x) of all monomials of total degree <= `degree`.

    Parameters
    ----------
    x : (..., d) array_like
        Points, best in a local frame.
    degree : int
        Highest total degree; -1 gives the empty basis.

    Returns
    -------
    (..., q) ndarray
        1, x1 ... xd, x1^2, x1 x2 ..., in the order of `exponents`.

    Examples
    --------
    >>> monomials([2.0, 3.0], 2)
    array([1., 2., 3., 4., 6., 9.])
    """
    x = np.asarray(x, dtype=np.float64)
    b = np.empty((*x.shape[:-1], dimension(x.shape[-1], degree)))
    if degree >= 0:
        b[..., 0] = 1.0
    for j, (variable, rest) in enumerate(_factors(x.shape[-1], degree), start=1):
        np.multiply(x[..., variable], b[..., rest], out=b[..., j])
    return b


def monomial_gradients(x: ArrayLike, degree: int) -> np.ndarray:
    """Gradients of the monomials, alpha_k x^(alpha - e_k).

    Parameters
    ----------
    x : (..., d) array_like
        Points.
    degree : int
        Highest total degree.

    Returns
    -------
    (..., q, d) ndarray
        The derivative of each monomial by each variable.

    Examples
    --------
    >>> monomial_gradients([2.0, 3.0], 2)[4]  # of x1 x2
    array([3., 2.])
    """
    x = np.asarray(x, dtype=np.float64)
    d = x.shape[-1]
    b = monomials(x, degree)
    g = np.zeros((*b.shape, d))
    alpha = exponents(d, degree)
    index = {tuple(a): i for i, a in enumerate(alpha)}
    for j, a in enumerate(alpha):
        for k in np.flatnonzero(a):
            lower = tuple(a - np.eye(d, dtype=int)[k])
            g[..., j, k] = a[k] * b[..., index[lower]]
    return g


def monomial_hessians(x: ArrayLike, degree: int) -> np.ndarray:
    """Second derivatives of the monomials, alpha_k (alpha - e_k)_l x^(alpha - e_k - e_l).

    Parameters
    ----------
    x : (..., d) array_like
        Points.
    degree : int
        Highest total degree.

    Returns
    -------
    (..., q, d, d) ndarray
        The symmetric matrix of second derivatives of each monomial.

    Examples
    --------
    >>> monomial_hessians([2.0, 3.0], 3)[7]  # of x^2 y
    array([[6., 4.],
           [4., 0.]])
    """
    x = np.asarray(x, dtype=np.float64)
    d = x.shape[-1]
    b = monomials(x, degree)
    h = np.zeros((*b.shape, d, d))
    alpha, unit = exponents(d, degree), np.eye(d, dtype=int)
    index = {tuple(a): i for i, a in enumerate(alpha)}
    for j, a in enumerate(alpha):
        for k in np.flatnonzero(a):
            once = a - unit[k]
            for m in np.flatnonzero(once):
                h[..., j, k, m] = a[k] * once[m] * b[..., index[tuple(once - unit[m])]]
    return h


def monomial_laplacians(x: ArrayLike, degree: int) -> np.ndarray:
    """Laplacians of the monomials, sum_k alpha_k (alpha_k - 1) x^(alpha - 2 e_k), (..., q).

    >>> monomial_laplacians([2.0, 3.0], 3)[6:]  # of x^3, x^2 y, x y^2, y^3
    array([12.,  6.,  4., 18.])
    """
    x = np.asarray(x, dtype=np.float64)
    b = monomials(x, degree)
    total = np.zeros_like(b)
    alpha = exponents(x.shape[-1], degree)
    index = {tuple(a): i for i, a in enumerate(alpha)}
    for j, a in enumerate(alpha):
        for k in np.flatnonzero(a > 1):
            lower = a.copy()
            lower[k] -= 2
            total[..., j] += a[k] * (a[k] - 1) * b[..., index[tuple(lower)]]
    return total


@dataclass(frozen=True)
class Frame:
    """Local frame y = (x - center) / scale, in which sites have size one.

    `scale` is a power of two, so that scaling rounds nothing.
    """

    center: np.ndarray
    scale: float

    is_isotropic: ClassVar[bool] = True
    """Whether a Laplacian by y is one by x, up to a factor."""
    who: ClassVar[str] = "the points do"
    """Subject of the error for sites that do not determine a polynomial in the frame."""

    @classmethod
    def around(cls, points: np.ndarray) -> Frame:
        """The frame in which the sites (n, d) fill the cube [-1, 1]^d."""
        low, high = points.min(axis=0), points.max(axis=0)
        center = low / 2 + high / 2
        extent = float((high / 2 - low / 2).max())
        return cls(center, float(power_of_two_above(extent)))

    def local(self, x: np.ndarray) -> np.ndarray:
        """Coordinates (..., d) in the frame."""
        return (x - self.center) / self.scale

    def point(self, y: np.ndarray) -> np.ndarray:
        """The point x (d,) with the coordinates y in the frame."""
        return self.center + self.scale * y

    def scaled(self, x: np.ndarray) -> np.ndarray:
        """Coordinates (..., d) in its unit, not shifted, so that close points stay apart."""
        return x / self.scale

    def gradient(self, by_y: np.ndarray) -> np.ndarray:
        """Derivatives (..., d) by x from those by y."""
        return by_y / self.scale

    def hessian(self, by_y: np.ndarray) -> np.ndarray:
        """Second derivatives (..., d, d) by x from those by y."""
        return by_y / self.scale / self.scale

    def partials(self, by_y: Iterable[Derivative]) -> tuple[Derivative, ...]:
        """Derivatives by each of the d variables x from those by y."""
        return tuple(derivative / self.scale for derivative in by_y)

    def global_coefficients(self, c: np.ndarray, degree: int) -> np.ndarray:
        """Coefficients in the monomials of x, from those (q, ...) in the monomials of y.

        ((x - a) / h)^alpha = h^-|alpha| sum_beta C(alpha, beta) x^beta (-a)^(alpha - beta)

        Raises
        ------
        OverflowError
            If the coefficients do not fit into floating-point numbers in this unit of length.
        """
        d = len(self.center)
        alpha = exponents(d, degree)
        lowered = alpha[:, None, :] - alpha[None, :, :]
        binomial = np.where(lowered >= 0, _binomials(degree)[alpha[:, None], alpha[None, :]], 0)
        unit = powers_of_scale(self.scale, -alpha.sum(axis=1), "the coefficients")
        with np.errstate(over="ignore", invalid="ignore"):
            shift = np.prod(binomial * (-self.center) ** np.maximum(lowered, 0), axis=-1)
            result = np.tensordot((unit[:, None] * shift).T, c, axes=1)
        if not np.isfinite(result).all():
            raise OverflowError(
                f"the coefficients of degree {degree} overflow in this unit of length"
            )
        return result


def powers_of_scale(scale: float, exponent: np.ndarray, what: str) -> np.ndarray:
    """scale^exponent, refused where it would leave the range of floating-point numbers."""
    bits = np.asarray(exponent) * (math.frexp(scale)[1] - 1)
    if (np.abs(bits) > 960).any():
        raise OverflowError(
            f"{what} would leave the range of floating-point numbers: points of size {scale:.1e} "
            f"to the power {int(np.abs(exponent).max())}; choose a unit nearer to their size"
        )
    return np.ldexp(1.0, bits)


def power_of_two_above(length: ArrayLike) -> np.ndarray:
    """The least powers of two that are not below the lengths, if any is; one for a length of zero.

    Scaling by a power of two rounds nothing.

    >>> power_of_two_above([0.0, 0.7, 1.0, 3.0])
    array([1., 1., 1., 4.])
    """
    length = np.asarray(length)
    mantissa, exponent = np.frexp(length)
    power = np.ldexp(1.0, np.minimum(exponent - (mantissa == 0.5), 1023))
    return np.where(length > 0, power, 1.0)


@lru_cache(maxsize=64)
def _binomials(degree: int) -> np.ndarray:
    return np.array(
        [[math.comb(n, k) for k in range(degree + 1)] for n in range(degree + 1)], dtype=float
    )


def resolution(points: np.ndarray) -> float:
    """Rounding of the coordinates relative to the points' extent, the worst axis that has one.

    Near the origin this is about 1e-16; for points of size one at an offset of 1e6 it is 1e-10,
    and no property of the points below that size means anything.
    """
    extent = np.ptp(points / 2, axis=0)
    reach = np.abs(points / 2).max(axis=0)
    # an axis whose extent is itself rounding gives no scale
    known = extent > 4 * EPS * reach
    return EPS * float(np.max(reach[known] / extent[known], initial=1.0))


def undetermined(
    d: int, degree: int, rank: int, who: str = "the points do"
) -> np.linalg.LinAlgError:
    """The error for sites that do not determine a polynomial."""
    variables = "1 variable" if d == 1 else f"{d} variables"
    return np.linalg.LinAlgError(
        f"{who} not determine a polynomial of degree {degree} in {variables}: "
        f"rank {rank} of {dimension(d, degree)}"
    )


def refuse_too_few(points: np.ndarray, degree: int) -> None:
    """Refuse fewer sites than a large basis has members, before the basis is computed.

    The rank of a small basis is more informative; a large basis, such as that of degree 10 in 20
    variables, may not fit into memory.

    Raises
    ------
    numpy.linalg.LinAlgError
        If the points cannot determine a polynomial of this degree.
    """
    n, d = points.shape
    q = dimension(d, degree)
    if n < q > LARGE_BASIS:
        raise np.linalg.LinAlgError(
            f"the points do not determine a polynomial of degree {degree} in {d} variables, which "
            f"has {q} coefficients; there are {n} points"
        )


def require_unisolvent(
    points: np.ndarray, b: np.ndarray, degree: int, who: str = "the points do"
) -> None:
    """Refuse sites on which a polynomial (basis values `b`, shape (n, q)) can vanish.

    Raises
    ------
    numpy.linalg.LinAlgError
        If the points do not determine a polynomial of this degree.
    """
    n, q = b.shape
    norms = np.linalg.norm(b, axis=0)
    with blas_threads_for(2 * b.size * q):
        sigma = np.linalg.svd(b / np.where(norms > 0, norms, 1.0), compute_uv=False)
    tolerance = 4 * (max(n, q) * EPS + max(degree, 1) * resolution(points))
    rank = int((sigma > tolerance * sigma[:1].sum()).sum()) if q else 0
    if rank < q:
        raise undetermined(points.shape[1], degree, rank, who)
