"""Cleaning of a cloud: duplicates and outliers removed, reliable normals, and the noise."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial import cKDTree

from fieldrecon._core.duplicates import first_of_equal
from fieldrecon.polynomials import monomials
from fieldrecon.surfaces.normal_orientation import orient_normals
from fieldrecon.surfaces.normals import PointNormals, as_cloud, estimate_normals
from fieldrecon.surfaces.off_surface import as_oriented, spacing_of

_ALONE = 1.5  # times the reach of its neighbours: an outlier has at most one other point nearer
_NEIGHBORS = 8  # with which a point is compared
_SAMPLE = 2000  # points from which the noise is estimated
_QUADRIC = 12  # neighbours to which a paraboloid is fitted
_AGREEMENT = 0.5  # smallest mean cosine of a normal with its neighbours
_AGAINST = 0.3  # weighted mean cosine, negative, at which a direction is rejected
_OFF_CENTER = 0.2  # of the reach: distance from the centroid of its neighbours at a boundary
_ROUGH = 0.2  # of the spacing: noise at which planes are fitted to more neighbours


@dataclass(frozen=True, eq=False)
class CleanedCloud:
    """Distinct points of a surface, without outliers, with normals.

    Attributes
    ----------
    points, outward : (n, 3) ndarray
    trusted, beside : (n,) ndarray of bool
        Whether `outward` is the normal of a plane through the neighbours that agrees with theirs,
        or an outward direction as at an edge or boundary, which is not taken from noisy points.
        Otherwise it is meaningless.
    left_out : (k,) ndarray of int
    spacing, noise : float
    warnings : tuple of str
    """

    points: np.ndarray
    outward: np.ndarray
    trusted: np.ndarray
    beside: np.ndarray
    left_out: np.ndarray
    spacing: float
    noise: float
    warnings: tuple[str, ...]


def as_clean_cloud(points: ArrayLike, normals: ArrayLike | None) -> CleanedCloud:
    """Clean a cloud, and estimate its normals if they are not given."""
    given = as_cloud(points)
    n = None if normals is None else as_oriented(points, normals)[1]
    first = np.flatnonzero(first_of_equal(given) == np.arange(len(given)))
    if len(first) < 4:
        raise np.linalg.LinAlgError(
            f"a surface takes at least four different points; got {len(first)}"
        )
    alone = outliers(given[first])
    kept = first[~alone]
    p = given[kept]
    spacing = spacing_of(p)
    noise = noise_of(p)
    if n is None:
        rough = noise > _ROUGH * spacing
        estimate = _estimate(p, rough)
        if not estimate.planar.any():
            raise np.linalg.LinAlgError(
                "the points do not lie on a surface: no plane fits the neighbours of any point"
            )
        outward = orient_normals(p, estimate.vectors, estimate.neighbors[:, :9])
        outward, trusted, beside = _with_agreement(p, outward, estimate.planar, estimate.neighbors)
        # so many neighbours lie on both sides of a thin sheet, and their mean may point inward
        beside &= not rough
    else:
        outward, trusted = n[kept], np.ones(len(p), dtype=bool)
        beside = ~trusted
    warnings = _findings(len(given) - len(first), int(alone.sum()), int((~trusted).sum()))
    left_out = np.setdiff1d(np.arange(len(given)), kept)
    return CleanedCloud(p, outward, trusted, beside, left_out, spacing, noise, tuple(warnings))


def _estimate(p: np.ndarray, rough: bool) -> PointNormals:
    """Normals by more neighbours if there is noise, and by fewer where no plane fits."""
    wide = estimate_normals(p, 32 if rough else 16)
    if rough:
        return wide
    close = estimate_normals(p, 8)
    vectors = np.where(wide.planar[:, None], wide.vectors, close.vectors)
    return replace(wide, vectors=vectors, planar=wide.planar | close.planar)


def _with_agreement(
    p: np.ndarray, outward: np.ndarray, planar: np.ndarray, neighbors: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Normals, or outward directions at edges and boundaries, and masks of both."""
    weight = planar[neighbors] * _beside(p, outward, neighbors)
    around = np.einsum("nk,nki->ni", weight, outward[neighbors])
    count = np.maximum(weight.sum(axis=1), np.finfo(float).tiny)
    length = np.linalg.norm(around, axis=1)
    trusted = planar & (np.einsum("ij,ij->i", around, outward) >= _AGREEMENT * count)
    beside = ~trusted & (length >= _AGREEMENT * count)
    directions = outward.copy()
    directions[beside] = around[beside] / length[beside, None]
    rest = np.flatnonzero(~trusted & ~beside)
    directions[rest], beside[rest] = _at_boundaries(p, outward, trusted, neighbors[rest])
    beside &= ~_against(p, directions, trusted | beside, neighbors)
    return directions, trusted, beside


def _beside(p: np.ndarray, outward: np.ndarray, neighbors: np.ndarray) -> np.ndarray:
    """1 - (e . n_k)^2 / |e|^2 of neighbours (n, k); zero for those across a thin sheet."""
    e = p[neighbors] - p[:, None]
    along, squared = np.einsum("nki,nki->nk", e, outward[neighbors]) ** 2, (e**2).sum(axis=2)
    return 1 - np.divide(along, squared, out=np.zeros_like(along), where=squared > 0)


def _against(
    p: np.ndarray, directions: np.ndarray, known: np.ndarray, neighbors: np.ndarray
) -> np.ndarray:
    """Whether directions (n,) contradict their neighbours, weighted by inverse squared distance."""
    squared = ((p[neighbors] - p[:, None]) ** 2).sum(axis=2)
    weight = np.divide(known[neighbors], squared, out=np.zeros_like(squared), where=squared > 0)
    cosine = np.einsum("nki,ni->nk", directions[neighbors], directions)
    return (weight * cosine).sum(axis=1) < -_AGAINST * weight.sum(axis=1)


def _at_boundaries(
    p: np.ndarray, outward: np.ndarray, trusted: np.ndarray, neighbors: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Directions where normals cancel: away from the neighbours, or towards them in a slit.

    The normals of a thin sheet point away from the centroid of the neighbours, those of a slit
    towards it.
    """
    offsets = p[neighbors] - p[neighbors].mean(axis=1, keepdims=True)
    away = offsets[:, 0]
    far, reach = np.linalg.norm(away, axis=1), np.linalg.norm(offsets, axis=2).max(axis=1)
    looking = np.einsum("nki,nki,nk->n", offsets, outward[neighbors], trusted[neighbors])
    sign = np.where(looking < 0, -1.0, 1.0)
    known = (far > _OFF_CENTER * reach) & (looking != 0)
    directions = (sign / np.maximum(far, np.finfo(float).tiny))[:, None] * away
    return np.where(known[:, None], directions, outward[neighbors[:, 0]]), known


def outliers(p: np.ndarray) -> np.ndarray:
    """Mask (n,) of points with at most one other as near as their neighbours have eight.

    Pairs of outliers are also found. The reach of the neighbours allows for a varying density.
    """
    if len(p) <= _NEIGHBORS + 1:
        return np.zeros(len(p), dtype=bool)
    p = p - p[0]
    reach, index = cKDTree(p).query(p, _NEIGHBORS + 1, workers=-1)
    return reach[:, 2] > _ALONE * np.median(reach[index[:, 1:], -1], axis=1)


def noise_without_curvature(p: np.ndarray) -> float:
    """Noise of points, by Richardson's extrapolation to neighbourhoods without an extent.

    A paraboloid leaves terms of third order. With twice as many neighbours their squares are 8
    times as large, and those of the noise are the same.
    """
    near, wide = noise_of(p), noise_of(p, 2 * _QUADRIC)
    return float(np.sqrt(max(8 * near**2 - wide**2, 0.0) / 7))


def noise_of(p: np.ndarray, neighbors: int = _QUADRIC) -> float:
    """Median of the standard deviations of points from paraboloids fitted to their neighbours.

    A paraboloid has six coefficients, so the sum of squared residuals is divided by k - 6.
    """
    k = min(neighbors, len(p))
    if k <= 6:
        return 0.0
    sample = np.random.default_rng(0).permutation(len(p))[:_SAMPLE]
    local = p - p[0]
    y = local[cKDTree(local).query(local[sample], k)[1]]
    y = y - y.mean(axis=1, keepdims=True)
    axes = np.linalg.eigh(y.mT @ y)[1]
    y = y @ axes
    size = np.abs(y).max(axis=(1, 2), keepdims=True)
    y = y / size  # the points of a clean cloud are different
    basis = np.linalg.qr(monomials(y[..., 1:], 2))[0]
    heights = y[..., :1]
    residuals = heights - basis @ (basis.mT @ heights)
    return float(np.median(np.linalg.norm(residuals, axis=(1, 2)) * size[:, 0, 0]) / np.sqrt(k - 6))


def _findings(repeated: int, alone: int, unknown: int) -> list[str]:
    """Sentences on the points that repeat others, lie apart, or have no normal."""
    found = (
        (repeated, "repeats others and counts once", "repeat others and count once"),
        (
            alone,
            "lies apart from all others and is ignored",
            "lie apart from all others and are ignored",
        ),
        (
            unknown,
            "has no normal: no plane fits its neighbours, as at edges",
            "have no normal: no plane fits their neighbours, as at edges",
        ),
    )
    return [
        f"1 point {one}." if count == 1 else f"{count:,} points {several}."
        for count, one, several in found
        if count
    ]
