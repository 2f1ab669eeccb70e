"""Streamlines: traced through vertex velocities of a mesh, and exact ones past a cylinder."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import LinearNDInterpolator

from fieldrecon.meshes.simplex_mesh import SimplexMesh

HALVINGS = 60


def traced_streamlines(
    mesh: SimplexMesh, u: np.ndarray, start: np.ndarray, arc: float, right: float
) -> np.ndarray:
    """Trace velocities, linear between the vertices of a mesh, by the Runge-Kutta method.

    Parameters
    ----------
    mesh : SimplexMesh
        A mesh of triangles.
    u : (n, 2) ndarray
        Velocities of the vertices.
    start : (m, 2) ndarray
        Starting points of the lines.
    arc : float
        Length of a step.
    right : float
        Lines stop when x exceeds this value.

    Returns
    -------
    (m, steps, 2) ndarray
        Points along each line.
    """
    field = LinearNDInterpolator(mesh.points, u)

    def direction(x: np.ndarray) -> np.ndarray:
        v = field(x)
        return v / np.linalg.norm(v, axis=1, keepdims=True)

    lines = [start]
    for _ in range(int(2 * (right - start[:, 0].min()) / arc)):
        x = lines[-1]
        going = x[:, 0] < right
        if not going.any():
            break
        y = x[going]
        k1 = direction(y)
        k2 = direction(y + arc / 2 * k1)
        k3 = direction(y + arc / 2 * k2)
        k4 = direction(y + arc * k3)
        x = x.copy()
        x[going] = y + arc / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        lines.append(x)
    return np.stack(lines, axis=1)


def exact_streamline(height: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Return the points (x, y) with y (1 − 1/r²) = height, the streamlines past the unit circle.

    For height > 0 the left side is zero on the circle, increases with y outside, and exceeds height
    at y = height + 1; so y is found by bisection.

    Examples
    --------
    >>> exact_streamline(np.array(1.5), np.array(0.0)).round(12).tolist()
    [0.0, 2.0]
    """
    target = np.abs(height) + 0 * x
    low = np.sqrt(np.maximum(1 - x**2, 0))
    high = target + 1
    for _ in range(HALVINGS):
        y = (low + high) / 2
        above = y * (1 - 1 / (x**2 + y**2)) > target
        low, high = np.where(above, low, y), np.where(above, y, high)
    return np.stack([x, np.sign(height) * high], axis=-1)
