"""The radial basis mappings of the coupling library preCICE, by their published formulas.

With the kernel matrices C between nodes and A from nodes to evaluation points, and the linear
polynomials Q at nodes and V at evaluation points, displacements are mapped by a matrix H, called
consistent, and loads by its transpose, called conservative. The polynomial is *integrated*, as in
the augmented system, or *separate*: fitted first, and subtracted from the data that the kernels
interpolate.

References
----------
Chourdakis and others, preCICE v2 (2022); the documentation of preCICE, Mapping configuration.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

import numpy as np
from scipy.spatial.distance import cdist

Kernel: TypeAlias = Callable[[np.ndarray], np.ndarray]


def integrated(x: np.ndarray, y: np.ndarray, kernel: Kernel) -> tuple[np.ndarray, np.ndarray]:
    """Consistent (m, n) and conservative (n, m) matrix of the augmented system."""
    q, v, c, a = _parts(x, y, kernel)
    system = np.block([[np.zeros((q.shape[1],) * 2), q.T], [q, c]])
    evaluation = np.hstack([v, a])
    given = np.vstack([np.zeros((q.shape[1], len(x))), np.eye(len(x))])
    conservative = np.linalg.solve(system.T, evaluation.T)[q.shape[1] :]
    return evaluation @ np.linalg.solve(system, given), conservative


def separate(x: np.ndarray, y: np.ndarray, kernel: Kernel) -> tuple[np.ndarray, np.ndarray]:
    """Consistent (m, n) and conservative (n, m) matrix, with the polynomial fitted first."""
    q, v, c, a = _parts(x, y, kernel)
    fit = np.linalg.pinv(q)
    consistent = a @ np.linalg.solve(c, np.eye(len(x)) - q @ fit) + v @ fit
    mu = np.linalg.solve(c, a.T)
    return consistent, mu - fit.T @ (q.T @ mu - v.T)


def _parts(
    x: np.ndarray, y: np.ndarray, kernel: Kernel
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    q, v = (np.column_stack([np.ones(len(p)), p]) for p in (x, y))
    return q, v, kernel(cdist(x, x)), kernel(cdist(y, x))
