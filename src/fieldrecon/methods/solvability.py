"""Conditions under which a system of radial basis functions is solvable; errors if they fail."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial import cKDTree

from fieldrecon._core import validation as valid
from fieldrecon._core.duplicates import refuse_coincident
from fieldrecon._core.memory import memory_limit
from fieldrecon._numerics.saddle_point import SaddlePoint
from fieldrecon.kernels.base import Radial
from fieldrecon.kernels.derivatives import smoothness
from fieldrecon.polynomials import EPS, powers_of_scale

TOLERATED_MISS = 1e-2
"""Error of a field at its data, as a part of their size, beyond which it is refused."""

INTERPOLATED = 1e-6
"""Error of a field at rough data, as a part of their size, up to which it interpolates them."""


def as_kernel(kernel: Radial, d: int) -> Radial:
    """Require a radial function that is conditionally positive definite in d variables."""
    if not isinstance(kernel, Radial):
        raise ValueError(
            f"kernel must be a radial function such as thin_plate_spline(); got {kernel!r}"
        )
    if d > kernel.dimensions:
        raise ValueError(
            f"{kernel!r} is positive definite in at most {kernel.dimensions} variables; "
            f"points have {d}"
        )
    return kernel


def as_finite(kernel: Radial) -> Radial:
    """Require a kernel that is finite at distance zero."""
    if not np.abs(kernel(0.0)) < 1e100:
        raise ValueError(f"kernel must be finite at r = 0; {kernel!r} is not")
    return kernel


def within_range(entries: np.ndarray, what: str) -> np.ndarray:
    """Require entries of the system whose products do not overflow."""
    if not np.abs(entries).max(initial=0.0) < 1e150:
        raise OverflowError(
            f"{what} exceed 1e150 in units of the cloud's size, too large to compute with; choose "
            "a length, or a smoothing, nearer to the distances of the points"
        )
    return entries


def as_augmentation(degree: int | None, kernel: Radial) -> int:
    """Degree of the polynomial: `kernel.order - 1` by default, and not less."""
    least = kernel.order - 1
    if degree is None:
        return least
    if valid.as_degree(degree, lowest=-1) < least:
        raise ValueError(
            f"{kernel!r} needs polynomials of degree {least} or more "
            f"(order {kernel.order}); got {degree}"
        )
    return int(degree)


def as_smoothing(smoothing: ArrayLike, n: int) -> float | np.ndarray:
    """Smoothing of all n data, one number, or of each datum, a read-only array (n,)."""
    if not isinstance(smoothing, list | tuple) and np.ndim(smoothing) == 0:
        return valid.as_length(smoothing, "smoothing", zero_allowed=True)  # type: ignore[arg-type]
    each = valid.as_values(smoothing, n, name="smoothing").copy()
    if each.ndim > 1 or np.iscomplexobj(each):
        raise ValueError(
            f"smoothing must be a number, or real numbers of the shape ({n},), one for each point; "
            f"got the shape {each.shape} and the type {each.dtype}"
        )
    if (each < 0).any():
        i = int(np.argmax(each < 0))
        raise ValueError(f"smoothing must not be negative; smoothing[{i}] is {each[i]:g}")
    each.flags.writeable = False
    return each


def refuse_duplicates(
    points: np.ndarray,
    remedy: str = "merge them, or give smoothing > 0",
    smoothing: float | np.ndarray = 0.0,
) -> None:
    """Refuse points that coincide and have no smoothing: their equal rows are a singular system."""
    wanted = "points must be distinct to be interpolated; these coincide: {pairs}; "
    interpolated = np.broadcast_to(np.equal(smoothing, 0), len(points))
    if interpolated.any():
        refuse_coincident(points, wanted + remedy, np.flatnonzero(interpolated))


def refuse_beyond_memory(
    n: int,
    entries: float | None = None,
    remedy: str = "PartitionOfUnityRBF fits the points in patches, in memory proportional to n",
) -> None:
    """Refuse a matrix of n^2 numbers, or a sparse factor of `entries`, that memory cannot hold."""
    needed = 8 * n * n if entries is None else 12 * entries
    available = memory_limit()
    form = "matrix" if entries is None else "sparse factor"
    if needed > 0.8 * available:
        raise MemoryError(
            f"a global fit of {n} points needs a {form} of {needed / 2**30:.0f} GiB, and this "
            f"machine or container has {available / 2**30:.3g}; {remedy}"
        )


def refuse_sites(
    kernel: Radial, x: np.ndarray, sites: cKDTree, derivative: str = "gradient"
) -> None:
    """Refuse queries at sites, where a field of this kernel has no such derivative."""
    distance, _ = sites.query(x)
    if (distance == 0).any():
        where = valid.format_point(x[int(np.argmin(distance))])
        raise ValueError(
            f"{kernel!r} has no {derivative} at a site, and the query ({where}) is one"
        )


def refuse_no_hessian(kernel: Radial, x: np.ndarray, sites: cKDTree) -> None:
    """Refuse queries at sites, where a field of a rough kernel has no second derivatives."""
    if smoothness(kernel) < 2:
        refuse_sites(kernel, x, sites, "second derivatives")


def refuse_a_miss(lam: np.ndarray, phi: np.ndarray, values: np.ndarray) -> None:
    """Refuse coefficients (n, v) so large that rounding in their field exceeds the data (n, v)."""
    miss = rounding_miss(lam, phi, values)
    wrong = np.isfinite(miss) & (miss > TOLERATED_MISS)
    if wrong.any():
        raise too_flat("the field", miss[wrong].max())


def rounding_miss(lam: np.ndarray, phi: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Error (v,) of a field at its data (n, v) by rounding, as a part of the size of the data.

    In s(p) = sum_j lambda_j phi(|p - p_j|) the rounding is about eps |lambda| max |phi|, as in a
    sum of random signs. That of the solution adds to it: together up to ten times as much was
    measured, with multiquadrics and gaussians on 200 to 800 sites.
    """
    size = np.abs(values).max(axis=0)
    relative = lam / np.where(size > 0, size, 1.0)  # squares of the data need not be numbers
    return 8 * EPS * np.abs(phi).max() * np.linalg.norm(relative, axis=0)


def miss_of_rough_data(system: SaddlePoint, phi: np.ndarray) -> float:
    """Error of the field of independent random signs at its data, of a factored system.

    Its coefficients are nearly as large as those of any data can be.
    """
    signs = random_signs(len(system), 1)
    return float(rounding_miss(system.solve(signs)[0], phi, signs)[0])


def random_signs(n: int, columns: int) -> np.ndarray:
    """Independent random data (n, v) of size one: the roughest ones, the same every time."""
    return np.random.default_rng(0).choice([-1.0, 1.0], size=(n, columns))


def refuse_lost_weights(miss: float) -> None:
    """Refuse weights where the field of random signs misses its data.

    Weights are the fields of data that are 1 at one site and 0 at the others, as rough as signs.
    Their equations are met to rounding even then, so that a residual would not tell.
    """
    if not miss <= TOLERATED_MISS:
        raise too_flat("rounding decides the weights: a field of independent data", miss)


def too_flat(who: str, miss: float) -> np.linalg.LinAlgError:
    """The error for a kernel so flat that rounding makes the field miss its data."""
    by = f" by about {miss:.0e} of their size" if np.isfinite(miss) else ""
    return np.linalg.LinAlgError(
        f"{who} would miss its data{by}, by rounding: the kernel is too flat for sites this close "
        "and data this rough; choose a smaller scale, a rougher kernel or some smoothing"
    )


def unit_smoothing(
    smoothing: float | np.ndarray, n: int, kernel: Radial, scale: float
) -> np.ndarray:
    """The smoothing (n,) of each datum in units of the kernel on sites divided by the scale."""
    each = np.broadcast_to(smoothing, n)
    if not each.any():
        return each
    unit = powers_of_scale(scale, np.array([-kernel.homogeneity]), "the smoothing")
    scaled = valid.quiet_evaluate(np.multiply, each, unit)
    return within_range(scaled, "values of the smoothing")
