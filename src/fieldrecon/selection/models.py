"""Models to choose from: methods with their parameters, by the names that a user types."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from types import MappingProxyType
from typing import TypeAlias

import numpy as np
from scipy.spatial import cKDTree

from fieldrecon.kernels.conditionally_positive_definite import polyharmonic, thin_plate_spline
from fieldrecon.kernels.positive_definite import wendland
from fieldrecon.methods.least_squares import LeastSquares
from fieldrecon.methods.moving_least_squares import MovingLeastSquares
from fieldrecon.methods.partition_of_unity.method import PartitionOfUnityRBF
from fieldrecon.methods.rbf import RBF
from fieldrecon.polynomials import dimension
from fieldrecon.reconstruction import Reconstruction

_NEIGHBORS_PER_COEFFICIENT = 4
_STRENGTHS = tuple(10.0**k for k in range(-6, 1))
_PATCH_STRENGTHS = tuple(10.0**k for k in range(-1, 7))
_NOISY_PATCH = 60
_TYPICAL = 5000  # samples from whose neighbours the typical distance of samples is found

Maker: TypeAlias = Callable[[np.ndarray], Reconstruction]


@dataclass(frozen=True)
class Model:
    """A method with its parameters, possibly in several variants, to be tried on samples.

    Parameters
    ----------
    name : str
        The name that a user types.
    family : str
        LS, MLS, RBF or PU.
    meaning : str
        A description in a few words.
    makers : callable
        Takes all the points (n, d) to variants, each of which takes points to the method on these.
    max_samples : float
        Number of samples up to which it is tried unasked: global kernels take O(n³).
    """

    name: str
    family: str
    meaning: str
    makers: Callable[[np.ndarray], Sequence[Maker]]
    max_samples: float = np.inf


def _least_squares(degree: int, _: np.ndarray) -> list[Maker]:
    return [partial(LeastSquares, degree=degree)]


def _moving(degree: int, _: np.ndarray) -> list[Maker]:
    return [partial(_moving_on, degree)]


def _moving_on(degree: int, points: np.ndarray) -> MovingLeastSquares:
    n, d = points.shape
    neighbors = min(_NEIGHBORS_PER_COEFFICIENT * dimension(d, degree), n - 1)
    return MovingLeastSquares(points, wendland(3, 1), degree, neighbors)


def _interpolant(power: int, _: np.ndarray) -> list[Maker]:
    kernel = thin_plate_spline() if power == 2 else polyharmonic(power)
    return [partial(RBF, kernel=kernel)]


def _smoothed(points: np.ndarray) -> list[Maker]:
    """Thin plates, their smoothing in squares of the extent."""
    unit = np.ptp(points, axis=0).max() ** 2
    plate = partial(RBF, kernel=thin_plate_spline())
    return [partial(plate, smoothing=unit * s) for s in _STRENGTHS]


def _patches(power: int, _: np.ndarray) -> list[Maker]:
    return [partial(PartitionOfUnityRBF, kernel=polyharmonic(power))]


def _smoothed_patches(points: np.ndarray) -> list[Maker]:
    """Patches of r³, their smoothing in cubes of the distance between neighbours."""
    few = points[:: max(1, len(points) // _TYPICAL)]
    unit = np.median(cKDTree(points).query(few, 2)[0][:, 1]) ** 3 if len(points) > 1 else 1.0
    patches = partial(PartitionOfUnityRBF, kernel=polyharmonic(3), patch_size=_NOISY_PATCH)
    return [partial(patches, smoothing=unit * s) for s in _PATCH_STRENGTHS]


MODELS: Mapping[str, Model] = MappingProxyType(
    {
        model.name: model
        for model in (
            Model("ls1", "LS", "least squares, plane", partial(_least_squares, 1)),
            Model("ls2", "LS", "least squares, degree 2", partial(_least_squares, 2)),
            Model("ls4", "LS", "least squares, degree 4", partial(_least_squares, 4)),
            Model("mls1", "MLS", "moving least squares, degree 1", partial(_moving, 1)),
            Model("mls2", "MLS", "moving least squares, degree 2", partial(_moving, 2)),
            Model("tps", "RBF", "thin-plate spline", partial(_interpolant, 2), 3000),
            Model("cubic", "RBF", "cubic spline r³", partial(_interpolant, 3), 3000),
            Model("smooth", "RBF", "thin plate, smoothed", _smoothed, 2000),
            Model("pu3", "PU", "patches of r³, blended", partial(_patches, 3)),
            Model("pu", "PU", "patches of r⁵, blended", partial(_patches, 5)),
            Model("pusmooth", "PU", "patches of r³, smoothed", _smoothed_patches),
        )
    }
)
