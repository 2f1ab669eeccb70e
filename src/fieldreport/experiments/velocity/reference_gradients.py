"""Gradients at vertices without the library: numpy.linalg.lstsq and scipy.interpolate.

Least squares is one fit; moving least squares and radial basis functions are evaluated near the
vertex and differentiated by central differences.
"""

from __future__ import annotations

import numpy as np
from scipy.interpolate import RBFInterpolator

from fieldrecon.meshes.simplex_mesh import SimplexMesh


def gradients_by_others(
    mesh: SimplexMesh, p: np.ndarray, vertices: np.ndarray, epsilon: float, step: float
) -> dict[str, np.ndarray]:
    """Return the gradients at inner vertices of the plane by each method, from one ring of cells.

    Parameters
    ----------
    mesh : SimplexMesh
        A mesh of triangles.
    p : (c,) ndarray
        Values at the circumcentres.
    vertices : (m,) ndarray of int
        Vertices at which the gradient is computed.
    epsilon : float
        ε of the weight 1/(r² + ε²) of moving least squares.
    step : float
        Step of the central differences.
    """
    found: dict[str, list[np.ndarray]] = {"LS": [], "MLS": [], "RBF": []}
    for i in vertices:
        cells = mesh.vertex_cells(i)
        sites, values, x = mesh.circumcenters[cells], p[cells], mesh.points[i]
        at = x + step * np.array([[1, 0], [-1, 0], [0, 1], [0, -1]])
        moving = np.array([_weighted_fit(sites, values, epsilon, y)[0] for y in at])
        spline = RBFInterpolator(sites, values, kernel="thin_plate_spline")(at)
        found["LS"].append(_weighted_fit(sites, values, np.inf, x)[1:])
        found["MLS"].append((moving[::2] - moving[1::2]) / (2 * step))
        found["RBF"].append((spline[::2] - spline[1::2]) / (2 * step))
    return {name: np.array(gradients) for name, gradients in found.items()}


def _weighted_fit(
    sites: np.ndarray, values: np.ndarray, epsilon: float, x: np.ndarray
) -> np.ndarray:
    """Return the affine fit about x, (value, slopes), with equal weights for ε = ∞."""
    y = sites - x
    w = np.ones(len(y)) if np.isinf(epsilon) else 1 / ((y**2).sum(axis=1) + epsilon**2)
    basis = np.column_stack([np.ones(len(y)), y])
    return np.linalg.lstsq(w[:, None] * basis, w * values)[0]
