"""Models to choose from: methods with their parameters, by the names that a user types."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from types import MappingProxyType
from typing import Any, TypeAlias

import numpy as np
from scipy.spatial import cKDTree

from fieldrecon.kernels.base import Radial
from fieldrecon.kernels.conditionally_positive_definite import polyharmonic, thin_plate_spline
from fieldrecon.kernels.positive_definite import wendland
from fieldrecon.methods.least_squares import LeastSquares
from fieldrecon.methods.mean import Mean
from fieldrecon.methods.moving_least_squares import MovingLeastSquares
from fieldrecon.methods.partition_of_unity.method import PartitionOfUnityRBF
from fieldrecon.methods.rbf import RBF
from fieldrecon.methods.tangent_plane import OnTangentPlane, in_tangent_plane
from fieldrecon.polynomials import dimension
from fieldrecon.reconstruction import Reconstruction

MANY = 20_000
"""Above this number of samples, cross-validation uses those in windows, in more folds: few gaps fit
in one. Windows do not show the error of one polynomial through all samples."""
_NEIGHBORS_PER_COEFFICIENT = 4
_STRENGTHS = (0.0, *(10.0**k for k in range(-6, 1)))
_PATCH_STRENGTHS = (0.0, 0.03, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0, 300.0)
_NOISY_PATCH, _CROWDED_PATCH, _WIDE_PATCH = 60, 120, 240
"""Numbers of samples in a patch: of separate samples, at most where many are near-duplicates, and
beside gaps."""
CAUTIOUS = (("mean", "linear", "pu1"), ("smooth",), ("pu2",), ("pusmooth",))
"""Names of models, in the order in which they overshoot more and more where samples are few.

The mean of the kernel r and of plates is as safe as the kernel r: beside a gap, where one of them
is wrong, the other one halves its error."""
_DUPLICATE, _REPEATED = 1e-3, 32
"""Distance of near-duplicates in units of the mean distance of samples, and the neighbours among
which a sample has one that is none."""
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
        Takes all the points (n, d) to paths of variants, each with more and more smoothing. A
        variant takes points to the method on these.
    max_samples : float
        Number of samples up to which it is tried unasked: global kernels take O(n³), and windows
        do not show the error of a global polynomial.
    parts : tuple of Model
        Models of whose best variants it is the mean; it then has no variants of its own.
    """

    name: str
    family: str
    meaning: str
    makers: Callable[[np.ndarray], Sequence[Sequence[Maker]]]
    max_samples: float = np.inf
    parts: tuple[Model, ...] = ()

    @property
    def caution(self) -> float:
        """Place among the `CAUTIOUS` models; infinite for the others."""
        return next((k for k, names in enumerate(CAUTIOUS) if self.name in names), np.inf)

    def on_tangent_plane(self, pole: np.ndarray) -> Model:
        """The same model for unit vectors of a region, in the plane that touches the globe."""
        parts = tuple(part.on_tangent_plane(pole) for part in self.parts)
        return replace(self, makers=partial(_projected, self.makers, pole), parts=parts)


def with_variances(maker: Maker, variances: np.ndarray | None) -> Maker:
    """The variant with its smoothing in proportion to the variances (n,) of the data.

    Its smoothing is then that of a datum of the mean variance. A method without smoothing takes
    all data as equal.
    """
    if variances is None:
        return maker
    return _changed(maker, partial(_weighted, variances / (variances.mean() or 1.0)))


def _weighted(relative: np.ndarray, maker: Maker) -> Maker:
    smoothing = maker.keywords.get("smoothing") if isinstance(maker, partial) else None
    return _with(maker, smoothing=smoothing * relative) if smoothing else maker


def with_wide_patches(maker: Maker | None) -> Maker | None:
    """The variant with four times as many samples in each patch; None if it smooths no patches.

    Beside a gap, a patch has samples of one side, and a few tracks at most. The wider it is, the
    nearer is the field to that of all samples at once.
    """
    if maker is None or not any(map(_has_noisy_patches, _innermost(maker))):
        return None
    return _changed(maker, _widened)


def _has_noisy_patches(maker: Maker) -> bool:
    return isinstance(maker, partial) and maker.keywords.get("patch_size", np.inf) < _WIDE_PATCH


def _widened(maker: Maker) -> Maker:
    return _with(maker, patch_size=_WIDE_PATCH) if _has_noisy_patches(maker) else maker


def with_distances(maker: Maker, metric: np.ndarray) -> Maker:
    """The variant with an anisotropic distance."""
    return _changed(maker, lambda one: _with(one, metric=metric))


def mean_of(makers: Sequence[Maker]) -> Maker:
    """The variant whose field is the mean of those of several variants."""
    return partial(Mean, methods=tuple(makers))


def parts_of_mean(maker: Maker) -> tuple[Maker, ...]:
    """The variants of which this one is the mean; none if it is not a mean."""
    if isinstance(maker, partial) and maker.func is Mean:
        parts: tuple[Maker, ...] = maker.keywords["methods"]
        return parts
    return ()


def _changed(maker: Maker, change: Callable[[Maker], Maker]) -> Maker:
    """The variant with a change of the methods that fit the values: those within others."""
    if isinstance(maker, partial) and maker.func is OnTangentPlane:
        return partial(maker, method=_changed(maker.keywords["method"], change))
    if parts := parts_of_mean(maker):
        return mean_of([_changed(one, change) for one in parts])
    return change(maker)


def _innermost(maker: Maker) -> list[Maker]:
    """The methods that fit the values: those within others."""
    if isinstance(maker, partial) and maker.func is OnTangentPlane:
        return _innermost(maker.keywords["method"])
    if parts := parts_of_mean(maker):
        return [one for part in parts for one in _innermost(part)]
    return [maker]


def _with(maker: Callable[..., Reconstruction], **arguments: Any) -> Maker:
    return partial(maker, **arguments)


def with_metric(model: Model, metric: np.ndarray, meaning: str) -> Model:
    """The model with an anisotropic distance, if it has distances: least squares has none."""
    if model.family == "LS":
        return model
    makers = partial(_with_metric, model.makers, metric)
    parts = tuple(with_metric(part, metric, meaning) for part in model.parts)
    return replace(model, makers=makers, parts=parts, meaning=f"{model.meaning}, {meaning}")


def _with_metric(
    makers: Callable[[np.ndarray], Sequence[Sequence[Maker]]],
    metric: np.ndarray,
    points: np.ndarray,
) -> list[list[Maker]]:
    """Variants whose smoothing is in units of the distances of the metric."""
    paths: Sequence[Sequence[Any]] = makers(points @ np.linalg.cholesky(metric))
    return [[partial(maker, metric=metric) for maker in path] for path in paths]


def _projected(
    makers: Callable[[np.ndarray], Sequence[Sequence[Maker]]], pole: np.ndarray, points: np.ndarray
) -> list[list[Maker]]:
    paths = makers(in_tangent_plane(points, pole))
    return [[partial(OnTangentPlane, method=maker, pole=pole) for maker in path] for path in paths]


def _least_squares(degree: int, _: np.ndarray) -> list[list[Maker]]:
    return [[partial(LeastSquares, degree=degree)]]


def _moving(degree: int, _: np.ndarray) -> list[list[Maker]]:
    return [[partial(_moving_on, degree)]]


def _moving_on(
    degree: int, points: np.ndarray, metric: np.ndarray | None = None
) -> MovingLeastSquares:
    n, d = points.shape
    neighbors = min(_NEIGHBORS_PER_COEFFICIENT * dimension(d, degree), n - 1)
    return MovingLeastSquares(points, wendland(3, 1), degree, neighbors, metric=metric)


def _kernel(power: int) -> Radial:
    return thin_plate_spline() if power == 2 else polyharmonic(power)


def _interpolant(power: int, _: np.ndarray) -> list[list[Maker]]:
    return [[partial(RBF, kernel=_kernel(power))]]


def _smoothed(power: int, degrees: Sequence[int], points: np.ndarray) -> list[list[Maker]]:
    """A global kernel, its smoothing in powers of the extent."""
    unit = np.ptp(points, axis=0).max() ** power
    whole = partial(RBF, kernel=_kernel(power))
    return [[partial(whole, degree=m, smoothing=unit * s) for s in _STRENGTHS] for m in degrees]


def _patches(power: int, _: np.ndarray) -> list[list[Maker]]:
    return [[partial(PartitionOfUnityRBF, kernel=polyharmonic(power))]]


def _smoothed_patches(power: int, degrees: Sequence[int], points: np.ndarray) -> list[list[Maker]]:
    """Patches of a kernel, with smoothing (s h)^power for the distance h between neighbours."""
    unit = _spacing(points)
    patches = partial(PartitionOfUnityRBF, kernel=_kernel(power), patch_size=_patch_size(points))
    return [
        [partial(patches, degree=m, smoothing=(unit * s) ** power) for s in _PATCH_STRENGTHS]
        for m in degrees
    ]


def _spacing(points: np.ndarray) -> float:
    """The median distance of a sample from the nearest one that is no near-duplicate of it.

    A sample that has no others among its neighbours does not count.
    """
    distance, apart, mean = _neighbors(points)
    nearest = distance[np.arange(len(distance)), apart.argmax(axis=1)]
    counted = apart.any(axis=1)
    return float(np.median(nearest[counted])) if counted.any() else mean or 1.0


def _patch_size(points: np.ndarray) -> int:
    """Number of samples in a patch, larger if many are near-duplicates, which count as one."""
    _, apart, _ = _neighbors(points)
    sites_per_sample = np.mean(1 / (~apart).sum(axis=1))
    return min(round(_NOISY_PATCH / sites_per_sample), _CROWDED_PATCH)


def _neighbors(points: np.ndarray) -> tuple[np.ndarray, np.ndarray, float]:
    """Distances of some samples from their neighbours and themselves, which are near-duplicates.

    Near-duplicates, such as repeated measurements at a station, are nearer than a thousandth of
    l / n^(1/d), with the extent l. Returned are the distances, whether these are larger, and
    l / n^(1/d).
    """
    n, d = points.shape
    mean = float(np.ptp(points, axis=0).max()) / n ** (1 / d)
    few = points[:: max(1, n // _TYPICAL)]
    distance = cKDTree(points).query(few, range(1, min(_REPEATED, n) + 1))[0]
    return distance, distance > _DUPLICATE * mean, mean


def _no_variants(_: np.ndarray) -> list[list[Maker]]:
    return []


_KERNEL_R = Model("pu1", "PU", "patches of r, smoothed", partial(_smoothed_patches, 1, (0, 1)))
_PLATES = Model("pu2", "PU", "patches of plates, smoothed", partial(_smoothed_patches, 2, (1,)))

MODELS: Mapping[str, Model] = MappingProxyType(
    {
        model.name: model
        for model in (
            Model("ls1", "LS", "least squares, plane", partial(_least_squares, 1), MANY),
            Model("ls2", "LS", "least squares, degree 2", partial(_least_squares, 2), MANY),
            Model("ls4", "LS", "least squares, degree 4", partial(_least_squares, 4), MANY),
            Model("mls1", "MLS", "moving least squares, degree 1", partial(_moving, 1)),
            Model("mls2", "MLS", "moving least squares, degree 2", partial(_moving, 2)),
            Model("linear", "RBF", "kernel r, smoothed", partial(_smoothed, 1, (0, 1)), 1000),
            Model("tps", "RBF", "thin-plate spline", partial(_interpolant, 2), 1000),
            Model("cubic", "RBF", "cubic spline r³", partial(_interpolant, 3), 1000),
            Model("smooth", "RBF", "thin plate, smoothed", partial(_smoothed, 2, (1,)), 1000),
            Model("pu3", "PU", "patches of r³, blended", partial(_patches, 3)),
            Model("pu", "PU", "patches of r⁵, blended", partial(_patches, 5)),
            _KERNEL_R,
            _PLATES,
            Model("mean", "PU", "mean of pu1 and pu2", _no_variants, parts=(_KERNEL_R, _PLATES)),
            Model("pusmooth", "PU", "patches of r³, smoothed", partial(_smoothed_patches, 3, (1,))),
        )
    }
)
