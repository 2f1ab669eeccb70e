"""Functions of many variables, and methods that reconstruct them from samples."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any, TypeAlias

import numpy as np
from scipy.spatial import cKDTree

from fieldrecon.datasets.synthetic import franke
from fieldrecon.kernels.conditionally_positive_definite import polyharmonic
from fieldrecon.kernels.positive_definite import gaussian, wendland
from fieldrecon.methods.least_squares import LeastSquares
from fieldrecon.methods.moving_least_squares import MovingLeastSquares
from fieldrecon.methods.partition_of_unity.method import PartitionOfUnityRBF
from fieldrecon.methods.rbf import RBF
from fieldrecon.polynomials import dimension

Maker: TypeAlias = Callable[[np.ndarray, np.ndarray], Callable[[np.ndarray], np.ndarray]]
"""Maps sites and data to a field."""
MOST_FOR_PATCHES = 10
"""With more variables, each patch contains a large part of all sites, or is the only patch."""


def centred(x: np.ndarray) -> np.ndarray:
    """Return variables of mean zero and variance one."""
    return np.sqrt(12) * (x - 0.5)


def ridge(x: np.ndarray) -> np.ndarray:
    """Return a step across the diagonal, equally steep in any number of variables."""
    return np.tanh(2 * centred(x).sum(axis=1) / np.sqrt(x.shape[1]))


def few(x: np.ndarray) -> np.ndarray:
    """Return Franke's function of the first two variables."""
    return franke(x[:, :2])


def additive(x: np.ndarray) -> np.ndarray:
    """Return a sum of cosines of single variables, which no linear function approximates."""
    return np.cos(2 * np.pi * x).sum(axis=1)


def radial(x: np.ndarray) -> np.ndarray:
    """Return the distance from the centre."""
    return np.linalg.norm(x - 0.5, axis=1)


def pairs(x: np.ndarray) -> np.ndarray:
    """Return a sum of products of two variables, with random coefficients."""
    y, d = centred(x), x.shape[1]
    b = np.triu(np.random.default_rng(d).standard_normal((d, d)), 1)
    return np.einsum("ni,ij,nj->n", y, b, y, optimize=True)


def wave(x: np.ndarray) -> np.ndarray:
    """Return a wave across the diagonal, with the same slope along each axis as in one variable."""
    return np.cos(2 * np.pi * x.sum(axis=1))


FIELDS = (ridge, few, additive, radial, pairs, wave)


def methods(d: int, n: int) -> Mapping[str, Maker]:
    """Return the methods by name that are available for a number of sites."""
    wide = gaussian(np.sqrt(d / 6) / 2)  # half the root mean square distance of two sites
    near = min(4 * dimension(d, 1), n - 1)
    made: dict[str, Maker] = {
        "nearest": nearest,
        "linear": partial(fitted, partial(LeastSquares, degree=1)),
        "quadratic": partial(fitted, partial(LeastSquares, degree=2)),
        "near": partial(
            fitted, partial(MovingLeastSquares, weight=wendland(3, 1), degree=1, neighbors=near)
        ),
        "wide": partial(fitted, partial(MovingLeastSquares, weight=wide, degree=1)),
        "cone": partial(fitted, partial(RBF, kernel=polyharmonic(1), degree=1)),
        "cubic": partial(fitted, partial(RBF, kernel=polyharmonic(3))),
        "patches": partial(fitted, PartitionOfUnityRBF),
    }
    refused = {
        "quadratic": dimension(d, 2) > n,
        "patches": d > MOST_FOR_PATCHES,
    }
    return {name: make for name, make in made.items() if not refused.get(name)}


def fitted(
    make: Callable[..., Any], sites: np.ndarray, data: np.ndarray
) -> Callable[[np.ndarray], np.ndarray]:
    """Return a field of the library."""
    return make(sites).field(data)


def nearest(sites: np.ndarray, data: np.ndarray) -> Callable[[np.ndarray], np.ndarray]:
    """Return the datum of the nearest site."""
    tree = cKDTree(sites)
    return lambda x: data[tree.query(x)[1]]


METHODS = tuple(methods(2, 100))
