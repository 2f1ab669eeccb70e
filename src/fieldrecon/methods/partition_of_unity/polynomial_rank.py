"""The polynomials that the sites of many patches determine."""

from __future__ import annotations

import math

import numpy as np

from fieldrecon._numerics.weighted_least_squares import by_elimination
from fieldrecon.polynomials import EPS, exponents, monomials


def maybe_rank_deficient(y: np.ndarray, degree: int) -> np.ndarray:
    """Whether the sites (p, k, d) of each patch may not determine the polynomials, or barely do."""
    basis = monomials(y, degree)
    if not basis.shape[2]:
        return np.zeros(len(y), dtype=bool)
    if basis.shape[1] < basis.shape[2]:
        return np.ones(len(y), dtype=bool)
    return ~by_elimination(basis.mT @ basis, 1)[1]


def ranks(y: np.ndarray, degree: int) -> np.ndarray:
    """Dimension (p,) of the polynomials restricted to the sites (p, k, d) of each patch."""
    sigma = np.linalg.svd(_equilibrated(y, degree), compute_uv=False)
    return (sigma > _tolerance(y, degree) * sigma[:, :1]).sum(axis=1)


def determined_basis(y: np.ndarray, degree: int) -> np.ndarray | None:
    """Basis of the polynomials that the sites (k, d) determine; None if they determine all.

    The columns of the matrix (q, q) are coefficients of polynomials of least Bombieri norm among
    those with the same values at the sites, followed by columns of zeros.
    """
    basis = _equilibrated(y, degree)
    _, sigma, vt = np.linalg.svd(basis, full_matrices=False)
    rank = int((sigma > _tolerance(y, degree) * sigma[0]).sum())
    if rank == basis.shape[1]:
        return None
    transform = np.zeros((basis.shape[1], basis.shape[1]))
    transform[:, :rank] = vt[:rank].T / sigma[:rank]
    return _bombieri(y.shape[1], degree)[:, None] * transform


def leverages(y: np.ndarray, degree: int) -> np.ndarray:
    """Leverages (p, k) of the sites (p, k, d) in the least-squares polynomial of each patch."""
    u, sigma, _ = np.linalg.svd(_equilibrated(y, degree), full_matrices=False)
    kept = sigma > _tolerance(y, degree) * sigma.max(axis=1, keepdims=True, initial=0.0)
    return np.einsum("pkq,pq->pk", u**2, kept.astype(float))


def _equilibrated(y: np.ndarray, degree: int) -> np.ndarray:
    return monomials(y, degree) * _bombieri(y.shape[-1], degree)


def _tolerance(y: np.ndarray, degree: int) -> float:
    return 1e3 * EPS * (y.shape[-2] + len(exponents(y.shape[-1], degree)))


def _bombieri(d: int, degree: int) -> np.ndarray:
    """Square roots of the multinomial coefficients, which make the norm invariant to rotations."""
    factorial = np.vectorize(math.factorial, otypes=[float])
    alpha = exponents(d, degree)
    return np.sqrt(factorial(alpha.sum(axis=1)) / factorial(alpha).prod(axis=1))
