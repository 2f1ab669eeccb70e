"""Means of blocks of neighbouring samples: fewer samples with less noise."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from fieldrecon._core import validation as valid
from fieldrecon._numerics.kd_partition import KDPartition


def block_means(points: ArrayLike, values: ArrayLike, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Mean points and mean values of blocks of neighbours, (1/m) sum_i p_i and (1/m) sum_i f_i.

    Space is bisected until there are `count` boxes or more, whose numbers of samples differ by at
    most one. The noise of a mean of m samples is smaller by the factor 1 / sqrt(m), and linear
    functions are reproduced. A second derivative c of the field causes an error of about
    c h^2 / 24 in boxes of side h.

    Parameters
    ----------
    points : (n, d) array_like
        Sites of the samples.
    values : (n, ...) array_like
        Values of the samples.
    count : int
        Smallest number of blocks; there are at most a fifth more.

    Returns
    -------
    points : (b, d) ndarray
        Means of the points of each block.
    values : (b, ...) ndarray
        Means of the values of each block.

    Raises
    ------
    ValueError
        If there are fewer points than blocks, or an argument has the wrong form.

    References
    ----------
    Uieda, Verde: processing and gridding spatial data using Green's functions (2018), which
    recommends them.

    Examples
    --------
    >>> import fieldrecon as fr
    >>> points = fr.datasets.uniform(1000, 2, seed=1)
    >>> middles, means = block_means(points, points.sum(axis=1), 50)
    >>> middles.shape, bool(abs(means - middles.sum(axis=1)).max() < 1e-12)
    ((56, 2), True)
    """
    points = valid.as_points(points)
    values = valid.as_values(values, len(points))
    valid.as_count(count, "count", wanted="a positive integer")
    if count > len(points):
        raise ValueError(f"count must be at most {len(points)}, the number of points; got {count}")
    sites = KDPartition.around(points, len(points) / count).sites
    there = sites >= 0
    held = there.sum(axis=1)
    starts = (np.cumsum(held) - held)[held > 0]
    order = sites[there]
    return _means(points[order], starts), _means(values[order], starts)


def _means(rows: np.ndarray, starts: np.ndarray) -> np.ndarray:
    """Means of consecutive rows (n, ...) of each block, which begins at its start."""
    sizes = np.diff(np.append(starts, len(rows)))
    sums = np.add.reduceat(rows, starts, axis=0)
    return sums / sizes.reshape(-1, *(1 for _ in rows.shape[1:]))
