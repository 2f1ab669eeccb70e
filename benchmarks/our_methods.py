"""Methods of this library as the comparison takes them: sites and values to a function."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np

from fieldrecon.kernels.conditionally_positive_definite import polyharmonic, thin_plate_spline
from fieldrecon.kernels.positive_definite import wendland
from fieldrecon.methods.moving_least_squares import MovingLeastSquares
from fieldrecon.methods.partition_of_unity.method import PartitionOfUnityRBF
from fieldrecon.methods.rbf import RBF
from fieldrecon.pipelines.block_averages import block_means
from fieldrecon.polynomials import dimension
from fieldrecon.reconstruction import Field
from fieldrecon.selection.cross_validation import CrossValidator
from fieldrecon.selection.leaving_one_out import leave_one_out
from fieldrecon.selection.models import Model

Fit = Callable[[np.ndarray, np.ndarray], Field]
CHOICES = ((2, 1, 50), (3, 3, 40), (4, 2, 120), (7, 4, 60))
"""Power of the kernel, with a logarithm if even, degree and patch size, of which one is taken."""
BLOCKS = 8
STRENGTHS = 10.0 ** np.arange(-7, 0)
"""Smoothing of r^5 that is tried, in fifth powers of the extent."""
TRIAL_PATCH, LARGE_PATCH, MOST_AT_ONCE = 100, 300, 1_000


def patches(points: np.ndarray, values: np.ndarray) -> Field:
    """By default: interpolates, r³ and cubics."""
    return PartitionOfUnityRBF(points).field(values)


def patches_of(power: int, degree: int, patch_size: int) -> Fit:
    def fit(points: np.ndarray, values: np.ndarray) -> Field:
        return _patches(power, degree, patch_size, points).field(values)

    return fit


def patches_by_leave_one_out(points: np.ndarray, values: np.ndarray) -> Field:
    """Kernel, degree and patch size that miss left-out samples least, judged in a few blocks."""
    makers = [partial(_patches, *choice) for choice in CHOICES]
    judge = CrossValidator.of(points, values)
    if judge.blocks is not None:
        judge = replace(judge, blocks=judge.blocks[:BLOCKS])
    trial = judge.evaluate(Model("patches", "PU", "patches, blended", lambda _: makers))
    return trial.maker(points).field(values)


def _patches(power: int, degree: int, size: int, points: np.ndarray) -> PartitionOfUnityRBF:
    kernel = thin_plate_spline() if power == 2 else polyharmonic(power)
    return PartitionOfUnityRBF(points, kernel, degree, size)


def moving_least_squares(degree: int, neighbors: int | None = None) -> Fit:
    def fit(points: np.ndarray, values: np.ndarray) -> Field:
        k = neighbors or 4 * dimension(points.shape[1], degree)
        return MovingLeastSquares(points, wendland(3, 1), degree, neighbors=k).field(values)

    return fit


def thin_plate(points: np.ndarray, values: np.ndarray) -> Field:
    return RBF(points, thin_plate_spline()).field(values)


def smoothed_means(count: int) -> Fit:
    """r⁵ through the means of so many blocks, smoothed as leaving out the means one by one says.

    Smoothings are tried on patches. The best is taken on all means if these are a thousand or
    fewer, otherwise on larger patches.
    """
    kernel = polyharmonic(5)

    def fit(points: np.ndarray, values: np.ndarray) -> Field:
        places, means = block_means(points, values, min(count, len(points)))
        unit = np.ptp(points, axis=0).max() ** 5

        def missed(strength: float) -> float:
            patches = PartitionOfUnityRBF(places, kernel, 3, TRIAL_PATCH, strength * unit)
            return float(np.mean(leave_one_out(patches, means) ** 2))

        smoothing = min(STRENGTHS, key=missed) * unit
        if count <= MOST_AT_ONCE:
            return RBF(places, kernel, 3, smoothing).field(means)
        return PartitionOfUnityRBF(places, kernel, 3, LARGE_PATCH, smoothing).field(means)

    return fit
