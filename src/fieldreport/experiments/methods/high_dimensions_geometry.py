"""Geometry in many variables: distances, polynomial dimensions, weights and Halton points."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq
from scipy.spatial import cKDTree
from scipy.spatial.distance import pdist

from fieldrecon.datasets.synthetic import halton, uniform
from fieldrecon.kernels.positive_definite import wendland
from fieldrecon.methods.partition_of_unity.method import PartitionOfUnityRBF
from fieldrecon.polynomials import dimension
from fieldreport.experiments.methods.high_dimensions_cases import MOST_FOR_PATCHES
from fieldreport.framework.experiment import Cell

KINDS = ("random", "halton", "scrambled")
BINS = np.linspace(0, 2.5, 101)
"""Bins of distances, in units of their mean."""
FEW = 500
"""The number of sites with pairwise distances in the histogram."""


def sites(n: int, d: int, kind: str, seed: int) -> np.ndarray:
    """Return points in the unit cube: random, Halton or scrambled Halton."""
    if kind == "random":
        return uniform(n, d, seed)
    return halton(n, d, seed if kind == "scrambled" else None)


@dataclass(frozen=True)
class Geometry:
    """Distances, polynomial dimensions, weights and Halton points in a number of variables."""

    COLUMNS = (
        "variables",
        "deviation / mean of distances",
        "nearest / mean distance",
        "polynomials of degree 1",
        "of degree 2",
        "of degree 3",
        "sites that count near a query",
        "degree of Wendland's function",
        "its width at half height / radius",
    )
    variables: int
    distances: np.ndarray
    spread: float
    nearest: float
    counting: float
    correlations: tuple[float, ...]
    overlap: float

    @classmethod
    def of(cls, n: int, queries: int, seed: int, d: int) -> Geometry:
        """Measure the geometry on n sites."""
        x = sites(n, d, "random", seed)
        some = pdist(x[:FEW])
        histogram = np.histogram(some / some.mean(), BINS, density=True)[0]
        near = float(np.median(cKDTree(x).query(x, 2)[0][:, 1]) / some.mean())
        correlated = [largest_correlation(sites(n, d, kind, seed)) for kind in KINDS]
        count = counting(x, uniform(queries, d, seed + 1))
        spread = float(some.std() / some.mean())
        return cls(d, histogram, spread, near, count, tuple(correlated), overlap(x))

    def row(self) -> tuple[Cell, ...]:
        """Return the cells of the table."""
        d = self.variables
        half = brentq(lambda r: wendland(d, 1)(np.array(r)) - 0.5, 0.0, 1.0)
        polynomials = (dimension(d, m) for m in (1, 2, 3))
        return (d, self.spread, self.nearest, *polynomials, self.counting, d // 2 + 4, half)


def overlap(x: np.ndarray) -> float:
    """Return the mean number of patches that contain a site; zero if there are no patches."""
    if x.shape[1] > MOST_FOR_PATCHES:
        return 0.0
    return PartitionOfUnityRBF(x).patch_sizes.sum() / len(x)


def counting(x: np.ndarray, q: np.ndarray) -> float:
    """Return the effective number of sites near a query, (sum w²)² / sum w⁴.

    Moving least squares squares its weights: a residual counts by w².
    """
    n, d = x.shape
    near = min(4 * dimension(d, 1), n - 1)
    distance = cKDTree(x).query(q, near + 1)[0]
    weight = wendland(3, 1)(distance[:, :-1] / distance[:, -1:]) ** 2
    return float(np.median(weight.sum(axis=1) ** 2 / (weight**2).sum(axis=1)))


def largest_correlation(x: np.ndarray) -> float:
    """Return the largest absolute correlation of two columns."""
    return float(np.abs(np.triu(np.corrcoef(x.T), 1)).max())
