"""The polynomials that the sites of many patches determine."""

from __future__ import annotations

import math

import numpy as np

from fieldrecon._numerics.weighted_least_squares import by_elimination
from fieldrecon.polynomials import dimension, exponents, monomials


def maybe_rank_deficient(y: np.ndarray, degree: int) -> np.ndarray:
    """Whether the sites (p, k, d) of each patch may not determine the polynomials, or barely do."""
    basis = monomials(y, degree)
    if not basis.shape[2]:
        return np.zeros(len(y), dtype=bool)
    if basis.shape[1] < basis.shape[2]:
        return np.ones(len(y), dtype=bool)
    return ~by_elimination(basis.mT @ basis, 0)[1]


def orthonormal_basis(y: np.ndarray, degree: int, tolerance: np.ndarray) -> np.ndarray:
    """Polynomials that are orthonormal at the sites (p, k, d) of each patch, degree by degree.

    The polynomials of degree m are taken modulo those of lower degree: their homogeneous parts are
    those of least Bombieri norm, and what they have in common at the sites with lower degrees is
    subtracted. So a lower degree stays whole where a higher one is not determined. On a circle the
    linear polynomials are whole, although x^2 + y^2 is a constant there.

    Parameters
    ----------
    y : (p, k, d) ndarray
        Sites, at most one from the origin.
    degree : int
        Highest degree.
    tolerance : (p, degree + 1) ndarray
        For each degree the singular value, per root of the number of sites, up to which a
        polynomial vanishes at the sites modulo lower degrees.

    Returns
    -------
    (p, q, q) ndarray
        Coefficients in the monomials, one polynomial in each column, in the order of the degrees; a
        column of zeros for each that the sites do not determine.
    """
    bombieri = _bombieri(y.shape[2], degree)
    values = monomials(y, degree) * bombieri
    tolerance = tolerance * np.sqrt(y.shape[1])
    at_sites = np.zeros_like(values)
    coefficients = np.zeros((len(y), values.shape[2], values.shape[2]))
    for m in range(degree + 1):
        block = slice(dimension(y.shape[2], m - 1), dimension(y.shape[2], m))
        rest = values[..., block]
        parts = np.zeros_like(coefficients[..., block])
        parts[:, range(block.start, block.stop), range(block.stop - block.start)] = 1.0
        for _ in range(2):  # twice is enough
            common = at_sites.mT @ rest
            rest = rest - at_sites @ common
            parts = parts - coefficients @ common
        u, sigma, vt = np.linalg.svd(rest, full_matrices=False)
        kept = sigma > tolerance[:, m, None]
        column = slice(block.start, block.start + sigma.shape[1])
        inverse = kept / np.where(kept, sigma, 1.0)
        at_sites[..., column] = u * kept[:, None, :]
        coefficients[..., column] = (parts @ vt.mT) * inverse[:, None, :]
    return bombieri[:, None] * coefficients


def whole_degrees(basis: np.ndarray, d: int, degree: int) -> int:
    """Highest degree up to which an `orthonormal_basis` (p, q, q) has all polynomials."""
    there = ~(basis == 0).all(axis=1).any(axis=0)
    whole = [m for m in range(degree + 1) if there[: dimension(d, m)].all()]
    return max(whole, default=-1)


def _bombieri(d: int, degree: int) -> np.ndarray:
    """Square roots of the multinomial coefficients, which make the norm invariant to rotations."""
    factorial = np.vectorize(math.factorial, otypes=[float])
    alpha = exponents(d, degree)
    return np.sqrt(factorial(alpha.sum(axis=1)) / factorial(alpha).prod(axis=1))
