"""Fewer samples for a noisy field: the means of blocks of neighbours."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from fieldrecon._core import validation as valid
from fieldrecon._numerics.kd_partition import KDPartition


def block_means(points: ArrayLike, values: ArrayLike, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Mean points and mean values of blocks of neighbours, (1/m) sum_i p_i and (1/m) sum_i f_i.

    Space is halved until there are so many boxes, which hold equally many samples, or one more. A
    mean of m samples has a root of m times less noise than each of them, and linear functions pass
    unchanged. What varies within a block is lost: a bend c of the field makes an error of about
    c h^2 / 24 for boxes of side h.

    Parameters
    ----------
    points : (n, d) array_like
        Where the samples are.
    values : (n, ...) array_like
        Samples.
    count : int
        Number of blocks, at least; at most a fifth more.

    Returns
    -------
    points : (b, d) ndarray
        Means of the blocks' points.
    values : (b, ...) ndarray
        Means of their values.

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
    """Means of consecutive rows (n, ...), those of a block from its start on."""
    sizes = np.diff(np.append(starts, len(rows)))
    sums = np.add.reduceat(rows, starts, axis=0)
    return sums / sizes.reshape(-1, *(1 for _ in rows.shape[1:]))
