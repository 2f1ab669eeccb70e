"""Synthetic scans: solids with sharp and thin parts, and point clouds with defects."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fieldrecon.solids.constructive import Solid
from fieldrecon.solids.shapes import Ball, Box, Cylinder, Torus, roughened, sample_surface, scanned
from fieldrecon.surfaces.off_surface import spacing_of

EYES = np.array([[4.0, -4.0, 1.5], [-4.0, -3.0, 1.5], [0.0, 4.0, -2.0]])
"""Positions of the scanner: two above and one below, all to the side of the body."""
HOLES = 0.8 * np.array([[0.87, -0.5, 0.25], [0.0, -1.0, 0.25], [-0.87, 0.5, 0.25], [0.5, 0.87, 0]])
"""Positions of the holes in the cloud, on the rim of the wheel, and their radius."""
HOLE = 0.26


@dataclass(frozen=True, eq=False)
class SyntheticScan:
    """Points (n, 3) of a solid, and the exact solid."""

    points: np.ndarray
    body: Solid


def machine_part() -> Solid:
    """Return a plate with a hole, a pin with a collar, and a thin fin."""
    plate = Box([2.0, 1.4, 0.3]) - Cylinder(0.3, 1.0, [-0.6, 0.0, 0.0])
    pin = Cylinder(0.2, 1.0, [0.5, 0.0, 0.4]) | Torus(0.2, 0.13, [0.5, 0.0, 0.6])
    fin = Box([0.1, 1.1, 0.8], [-0.1, 0.0, 0.4])
    return plate | pin | fin


def wheel() -> Solid:
    """Return a ring with a hub and a bar through it."""
    return Torus(0.8, 0.22) | Cylinder(0.25, 0.5) | Box([1.5, 0.2, 0.2])


def damaged(count: int, noise: float, seed: int) -> dict[str, SyntheticScan]:
    """Return point clouds of a wheel by the name of their defect.

    Parameters
    ----------
    count : int
        Number of points of the whole wheel.
    noise : float
        Standard deviation, in units of the spacing of the points.
    seed : int
        Seed of the random numbers.
    """
    body = wheel()
    points, normals = sample_surface(body, count, seed)
    spacing = spacing_of(points)
    rng = np.random.default_rng(seed)
    rough = roughened(points, normals, noise * spacing, rng)
    missing = np.linalg.norm(points[:, None] - HOLES, axis=2).min(axis=1) < HOLE
    low, high = 1.3 * body.box
    strays = low + (high - low) * rng.random((count // 50, 3))
    strays = strays[-body(strays) > 5 * spacing]
    other = Ball(0.4, [0.0, 0.0, 0.9])
    more, _ = sample_surface(other, count // 5, seed)
    sheet = Box([1.4, 1.4, 2.2 * np.sqrt(2 * 1.4**2 / count)])
    return {
        "as drawn": SyntheticScan(points, body),
        "with noise": SyntheticScan(rough, body),
        "with holes": SyntheticScan(points[~missing], body),
        "in shadow": SyntheticScan(points[scanned(body, points, normals, EYES)], body),
        "with strays and copies": SyntheticScan(
            np.vstack([points, strays, points[: count // 10]]), body
        ),
        "two bodies": SyntheticScan(np.vstack([points, more]), body | other),
        "thin sheet": SyntheticScan(sample_surface(sheet, count, seed)[0], sheet),
    }


def spheroid(n: int) -> tuple[np.ndarray, np.ndarray]:
    """Return points (n, 3) evenly distributed on an oblate spheroid, and its normals."""
    z = 1 - (2 * np.arange(n) + 1) / n
    angle = np.pi * (1 + 5**0.5) * np.arange(n)
    ball = np.column_stack([np.cos(angle), np.sin(angle), z])
    ball[:, :2] *= np.sqrt(1 - z**2)[:, None]
    half = np.array([1.0, 0.8, 0.6])
    normals = ball / half
    return ball * half, normals / np.linalg.norm(normals, axis=1, keepdims=True)
