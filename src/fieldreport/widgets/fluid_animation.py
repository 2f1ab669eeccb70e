"""The fluid animation: mesh, ink and exact boundary at the end of each step, and the energies."""

from __future__ import annotations

import base64
from typing import Any

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import reverse_cuthill_mckee

from fieldreport.experiments.advection.fluid_animation import (
    ENERGY,
    WAYS,
    AnimationFrame,
    animated,
    exact_rim,
)
from fieldreport.framework.experiment import Result

USES = ("fluid_animation",)
RIM = 80
"""Points on the exact boundary of the ink."""
FULL = 65535
"""Coordinates from 0 to 1 are stored as 16-bit integers."""
SHADES = 255


def data(result: Result) -> dict[str, Any]:
    """Return the frames of the first variant, packed, and the history of all variants."""
    params = result.params
    frames = animated(params, WAYS[0])[1]
    times = np.linspace(0, params.time, params.steps + 1)
    energies = result.arrays["history"][:, :, 0] / ENERGY
    return {
        "times": [round(float(t), 6) for t in times],
        "ways": [way.name for way in WAYS],
        "energies": [[float(f"{x:.6g}") for x in row] for row in energies],
        "frames": [packed(frame) for frame in frames],
        "rims": [_packed(np.round(exact_rim(t, RIM) * FULL), "<u2") for t in times],
    }


def packed(frame: AnimationFrame) -> dict[str, str]:
    """Return points, cells and ink in base64.

    The points are renumbered so that the numbers of neighbours are close, and a cell is stored as
    three bytes: the increase of its lowest number, and the differences of the other two from it.
    """
    mesh = frame.mesh
    n = len(mesh.points)
    links = np.concatenate([mesh.edges, mesh.edges[:, ::-1]])
    order = reverse_cuthill_mckee(_incidence(links, n), symmetric_mode=True)
    number = np.empty(n, dtype=int)
    number[order] = np.arange(n)
    cells = np.sort(number[mesh.cells], axis=1)
    cells = cells[np.lexsort(cells.T[::-1])]
    steps = np.diff(cells[:, 0], prepend=0)
    triples = np.column_stack([steps, cells[:, 1:] - cells[:, :1]])
    if triples.max() > SHADES:
        raise ValueError(f"numbers of neighbours must differ by at most 255; got {triples.max()}")
    return {
        "points": _packed(np.round(mesh.points[order] * FULL), "<u2"),
        "cells": _packed(triples, "u1"),
        "ink": _packed(np.round(frame.ink[order] * SHADES), "u1"),
    }


def _incidence(links: np.ndarray, n: int) -> Any:

    return csr_array((np.ones(len(links)), links.T), shape=(n, n))


def _packed(numbers: np.ndarray, kind: str) -> str:
    return base64.b64encode(numbers.astype(kind).tobytes()).decode()
