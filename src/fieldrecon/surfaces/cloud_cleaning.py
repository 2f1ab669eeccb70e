"""A cloud made ready: copies and outliers left out, normals that can be trusted, and the noise."""

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

_ALONE = 1.5  # times the reach of its neighbours: a point with one other nearer is an outlier
_NEIGHBORS = 8  # that a point has about it, with whom it is compared
_SAMPLE = 2000  # points of which the noise is judged
_QUADRIC = 12  # neighbours through which a paraboloid is laid
_AGREEMENT = 0.5  # of a normal with those about it, in the mean of the cosines
_AGAINST = 0.3  # of those about in the mean: a direction that contradicts them is none
_OFF_MIDDLE = 0.2  # of the reach: a point so far off the middle of its neighbours is at a rim
_ROUGH = 0.2  # of the spacing: noise from which on a plane takes more neighbours


@dataclass(frozen=True, eq=False)
class Cloud:
    """Points of a surface that count, distinct.

    Attributes
    ----------
    points, outward : (n, 3) ndarray
    trusted, beside : (n,) ndarray of bool
        Whether the normal is that of a plane through the neighbours, in agreement with theirs; or
        a direction outward, as at an edge or a rim. Otherwise it means nothing.
    left_out : (k,) ndarray of int
    spacing, noise : float
    remarks : tuple of str
    """

    points: np.ndarray
    outward: np.ndarray
    trusted: np.ndarray
    beside: np.ndarray
    left_out: np.ndarray
    spacing: float
    noise: float
    remarks: tuple[str, ...]


def as_clean_cloud(points: ArrayLike, normals: ArrayLike | None) -> Cloud:
    """What counts of a cloud, and what is to be said of it."""
    given = as_cloud(points)
    n = None if normals is None else as_oriented(points, normals)[1]
    first = np.flatnonzero(first_of_equal(given) == np.arange(len(given)))
    if len(first) < 4:
        raise np.linalg.LinAlgError(
            f"a surface takes four different points or more; got {len(first)}"
        )
    alone = outliers(given[first])
    kept = first[~alone]
    p = given[kept]
    spacing = spacing_of(p)
    noise = noise_of(p)
    if n is None:
        estimate = _estimated(p, noise > _ROUGH * spacing)
        if not estimate.planar.any():
            raise np.linalg.LinAlgError(
                "the points lie on no surface: nowhere does a plane fit their neighbours"
            )
        outward = orient_normals(p, estimate.vectors, estimate.neighbors[:, :9])
        outward, trusted, beside = _agreed(p, outward, estimate.planar, estimate.neighbors)
    else:
        outward, trusted = n[kept], np.ones(len(p), dtype=bool)
        beside = ~trusted
    said = (
        (len(given) - len(first), "{} repeat others and count once"),
        (int(alone.sum()), "{} lie apart from all others and are left out"),
        (int((~trusted).sum()), "{} have no normal: no plane fits their neighbours, as at edges"),
    )
    remarks = [sentence.format(_points(count)) + "." for count, sentence in said if count]
    left_out = np.setdiff1d(np.arange(len(given)), kept)
    return Cloud(p, outward, trusted, beside, left_out, spacing, noise, tuple(remarks))


def _estimated(p: np.ndarray, rough: bool) -> PointNormals:
    """Normals by more neighbours where there is noise, and by fewer where these are no plane."""
    wide = estimate_normals(p, 32 if rough else 16)
    if rough:
        return wide
    close = estimate_normals(p, 8)
    vectors = np.where(wide.planar[:, None], wide.vectors, close.vectors)
    return replace(wide, vectors=vectors, planar=wide.planar | close.planar)


def _agreed(
    p: np.ndarray, outward: np.ndarray, planar: np.ndarray, neighbors: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Normals, or directions outward at edges and rims, and which are the one and the other."""
    weight = planar[neighbors] * _beside(p, outward, neighbors)
    around = np.einsum("nk,nki->ni", weight, outward[neighbors])
    count = np.maximum(weight.sum(axis=1), np.finfo(float).tiny)
    length = np.linalg.norm(around, axis=1)
    trusted = planar & (np.einsum("ij,ij->i", around, outward) >= _AGREEMENT * count)
    beside = ~trusted & (length >= _AGREEMENT * count)
    directions = outward.copy()
    directions[beside] = around[beside] / length[beside, None]
    rest = np.flatnonzero(~trusted & ~beside)
    directions[rest], beside[rest] = _at_rims(p, outward, trusted, neighbors[rest])
    beside &= ~_against(p, directions, trusted | beside, neighbors)
    return directions, trusted, beside


def _beside(p: np.ndarray, outward: np.ndarray, neighbors: np.ndarray) -> np.ndarray:
    """1 - (e . n_k)^2 / |e|^2 of neighbours (n, k): none of those across a sheet."""
    e = p[neighbors] - p[:, None]
    along, squared = np.einsum("nki,nki->nk", e, outward[neighbors]) ** 2, (e**2).sum(axis=2)
    return 1 - np.divide(along, squared, out=np.zeros_like(along), where=squared > 0)


def _against(
    p: np.ndarray, directions: np.ndarray, known: np.ndarray, neighbors: np.ndarray
) -> np.ndarray:
    """Which directions (n,) are against those about, the nearest counting most."""
    squared = ((p[neighbors] - p[:, None]) ** 2).sum(axis=2)
    weight = np.divide(known[neighbors], squared, out=np.zeros_like(squared), where=squared > 0)
    cosine = np.einsum("nki,ni->nk", directions[neighbors], directions)
    return (weight * cosine).sum(axis=1) < -_AGAINST * weight.sum(axis=1)


def _at_rims(
    p: np.ndarray, outward: np.ndarray, trusted: np.ndarray, neighbors: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Directions where normals cancel: away from the neighbours, or towards them in a slit.

    From the middle of the neighbours the normals of a sheet look away, those of a slit do not.
    """
    offsets = p[neighbors] - p[neighbors].mean(axis=1, keepdims=True)
    away = offsets[:, 0]
    far, reach = np.linalg.norm(away, axis=1), np.linalg.norm(offsets, axis=2).max(axis=1)
    looking = np.einsum("nki,nki,nk->n", offsets, outward[neighbors], trusted[neighbors])
    sign = np.where(looking < 0, -1.0, 1.0)
    known = (far > _OFF_MIDDLE * reach) & (looking != 0)
    directions = np.where(known, sign / np.maximum(far, np.finfo(float).tiny), 0.0)[:, None] * away
    return np.where(known[:, None], directions, outward[neighbors[:, 0]]), known


def outliers(p: np.ndarray) -> np.ndarray:
    """Points (n,) that have hardly another as near as their neighbours have eight.

    Two strays together are found too; the neighbours' reach allows for a changing density.
    """
    if len(p) <= _NEIGHBORS + 1:
        return np.zeros(len(p), dtype=bool)
    p = p - p[0]
    reach, index = cKDTree(p).query(p, _NEIGHBORS + 1, workers=-1)
    return reach[:, 2] > _ALONE * np.median(reach[index[:, 1:], -1], axis=1)


def noise_of(p: np.ndarray) -> float:
    """Standard deviation of the points from paraboloids through their neighbours, the median.

    Of k neighbours a paraboloid takes six: the squares of what is left are divided by k - 6.
    """
    k = min(_QUADRIC, len(p))
    if k <= 6:
        return 0.0
    some = np.random.default_rng(0).permutation(len(p))[:_SAMPLE]
    local = p - p[0]
    y = local[cKDTree(local).query(local[some], k)[1]]
    y = y - y.mean(axis=1, keepdims=True)
    axes = np.linalg.eigh(y.mT @ y)[1]
    y = y @ axes
    size = np.abs(y).max(axis=(1, 2), keepdims=True)
    y = y / np.where(size > 0, size, 1.0)
    basis = np.linalg.qr(monomials(y[..., 1:], 2))[0]
    heights = y[..., :1]
    rest = heights - basis @ (basis.mT @ heights)
    return float(np.median(np.linalg.norm(rest, axis=(1, 2)) * size[:, 0, 0]) / np.sqrt(k - 6))


def _points(count: int) -> str:
    return "1 point" if count == 1 else f"{count:,} points"
