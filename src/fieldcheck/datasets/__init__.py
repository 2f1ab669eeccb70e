"""Measured data for the notebooks; each file names its source and its licence."""

from __future__ import annotations

import json
from importlib.resources import files
from typing import Any

import numpy as np


def kleopatra() -> tuple[np.ndarray, np.ndarray]:
    """Return the surface of the asteroid 216 Kleopatra, as seen by radar.

    Returns
    -------
    points : ndarray, shape (600, 3)
        Points on the surface, in kilometres.
    triangles : ndarray, shape (1196, 3)
        Three points each, counter-clockwise when seen from outside.

    References
    ----------
    S. J. Ostro and others, Asteroid Radar Shape Models, 216 Kleopatra.
    EAR-A-5-DDR-RADARSHAPE-MODELS-V2.0. NASA Planetary Data System, 2004.

    Examples
    --------
    >>> points, triangles = kleopatra()
    >>> np.ptp(points, axis=0).round()
    array([219.,  94.,  82.])
    """
    content = _read("kleopatra")
    return np.array(content["points"]), np.array(content["triangles"])


def terrain() -> tuple[np.ndarray, np.ndarray]:
    """Return the heights of a real landscape, around Cross Mountain, Tennessee.

    Returns
    -------
    points : ndarray, shape (3000, 2)
        Nodes of a regular grid, row by row from south to north, in kilometres.
    heights : ndarray, shape (3000,)
        Heights there, in metres.

    Examples
    --------
    >>> points, heights = terrain()
    >>> np.ptp(points, axis=0).round(1), int(heights.max())
    (array([13.2, 13.6]), 1071)
    """
    content = _read("terrain")
    heights = np.array(content["heights_in_metres"], dtype=float)
    x, y = (
        s * np.arange(n)
        for s, n in zip(content["spacing_in_kilometres"], heights.T.shape, strict=True)
    )
    return np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2), heights.ravel()


def _read(name: str) -> Any:
    return json.loads((files("fieldcheck") / f"datasets/{name}.json").read_text("utf-8"))
