"""Least-squares velocity of one triangle in an affine field: closed form and exact points."""

from __future__ import annotations

import numpy as np

from fieldrecon.meshes.simplex_mesh import SimplexMesh
from fieldrecon.velocity.cells import cell_velocities
from fieldrecon.velocity.vertices import normal_velocities

ROTATION = np.array([[0.0, -1.0], [1.0, 0.0]])
STRAIN = np.diag([1.0, -1.0])


def closed_form(corners: np.ndarray, g: np.ndarray) -> np.ndarray:
    """Return u − G O of the least-squares velocity u of triangles (m, 3, 2) in the field G x.

    With O the circumcentre, R the circumradius, q_a the corners from O as complex numbers, h their
    sum, K the symmedian point from O, and G = sI + ωJ + S with Sz = σ z̄:
    u − u(O) = s K + ½ (σ h̄ − σ̄ q₁q₂q₃ / R²).

    Examples
    --------
    >>> equilateral = np.array([[[0.0, 0.0], [1.0, 0.0], [0.5, np.sqrt(0.75)]]])
    >>> closed_form(equilateral, np.diag([1.0, -1.0])).round(6) + 0.0
    array([[0.      , 0.288675]])
    """
    s, sigma = np.trace(g) / 2, complex(g[0, 0] - g[1, 1], g[0, 1] + g[1, 0]) / 2
    p = corners @ np.array([1, 1j])
    sides = np.abs(np.roll(p, -1, axis=1) - np.roll(p, -2, axis=1)) ** 2  # opposite each corner
    weights = sides * (sides.sum(axis=1, keepdims=True) - 2 * sides)
    center = (weights * p).sum(axis=1) / weights.sum(axis=1)
    q = p - center[:, None]
    symmedian = (sides * q).sum(axis=1) / sides.sum(axis=1)
    strain = sigma * q.sum(axis=1).conj() - sigma.conjugate() * q.prod(axis=1) / abs(q[:, 0]) ** 2
    error = s * symmedian + strain / 2
    return np.stack([error.real, error.imag], axis=-1)


def places_on_triangle(corners: np.ndarray, strains: int) -> dict[str, np.ndarray]:
    """Find the points of a triangle where each field equals its least-squares velocity.

    Returns
    -------
    dict
        The corners, circumcentre, centroid, symmedian point, the centre and radius of the
        nine-point circle, and the points for the rotation, the expansion, and strains.
    """
    mesh = SimplexMesh(corners, np.array([[0, 1, 2]]))
    center, sides = mesh.circumcenters[0], mesh.face_measures[mesh.cell_faces[0]]
    angle = (
        np.arange(strains) * np.pi / strains
    )  # argument of σ; the angle of the axis is half of it
    cos, sin = np.cos(angle), np.sin(angle)
    gradients = [
        ROTATION,
        np.eye(2),
        *np.moveaxis(np.array([[cos, sin], [sin, -cos]]), -1, 0),
    ]
    velocities = [
        cell_velocities(mesh, normal_velocities(mesh, mesh.points @ g.T)).values[0]
        for g in gradients
    ]
    return {
        "corners": corners,
        "center": center,
        "centroid": mesh.cell_centers[0],
        "symmedian": sides**2 @ mesh.points[mesh.cells[0]] / (sides @ sides),
        "nine_point_center": center + (mesh.points - center).sum(axis=0) / 2,
        "nine_point_radius": np.linalg.norm(mesh.points[0] - center) / 2,
        "places": np.linalg.solve(np.array(gradients), np.array(velocities)[..., None])[..., 0],
    }
