"""Noise gain of a method: how much it amplifies the noise of the data at given points."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from fieldrecon.reconstruction import Reconstruction


def noise_gain(method: Reconstruction, x: ArrayLike) -> np.ndarray:
    """Standard deviation of the field of uncorrelated noise with unit variance, at queries.

    It is the norm of the weights, sqrt(sum_i w_i(x)^2), and does not depend on the values: 1 where
    a method takes the value of one sample, n^(-1/2) for the mean of n samples, and large where it
    extrapolates.

    Parameters
    ----------
    method : Reconstruction
    x : (m, d) array_like
        Queries.

    Returns
    -------
    (m,) ndarray

    Raises
    ------
    MemoryError
        If dense weights are too many, see `Reconstruction.weights`.

    References
    ----------
    Hastie, Tibshirani and Friedman, The Elements of Statistical Learning, 2nd ed. (2009), section
    6.1.2: the equivalent kernel, and the variance of a linear smoother.

    Examples
    --------
    >>> import fieldrecon as fr
    >>> points = fr.datasets.uniform(100, 2, seed=0)
    >>> noise_gain(fr.LeastSquares(points, 0), [[0.5, 0.5]]).round(9)
    array([0.1])
    """
    weights = method.weights(x)
    return np.sqrt(np.asarray((weights * weights).sum(axis=1)).ravel())
