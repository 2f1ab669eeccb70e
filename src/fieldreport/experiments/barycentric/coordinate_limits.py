"""Barycentric coordinates near edges and corners, and outside the polygon."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fieldrecon.barycentric.coordinates import BarycentricCoordinates
from fieldreport.experiments.barycentric import coordinate_formulas as formulas
from fieldreport.experiments.barycentric.polytopes import GOLDEN, Planes, regular


def errors_beside(distances: np.ndarray, turn: float) -> np.ndarray:
    """Return errors (edge or corner, quotient or products, distance) in a turned hexagon.

    Exact values are computed in rational arithmetic. Where the quotient is not a number, its error
    is reported as -1.
    """
    corners = regular(6, turn)
    planes, method = Planes.of(corners), BarycentricCoordinates(corners)
    errors = np.empty((2, 2, len(distances)))
    for row, place in zip(errors, (0.3 * corners[0] + 0.7 * corners[1], corners[0]), strict=True):
        x = place - distances[:, None] * place / np.linalg.norm(place)
        exact = np.array([formulas.rational(corners, q) for q in x])
        with np.errstate(all="ignore"):
            quotient = np.abs(formulas.quotient(planes, x) - exact).max(axis=1)
        row[0] = np.where(np.isfinite(quotient), quotient, -1)
        row[1] = np.abs(method.weights(x) - exact).max(axis=1)
    return errors


@dataclass(frozen=True)
class Outside:
    """The coordinates of a polygon beyond its edges, and their pole curve.

    Attributes
    ----------
    corners : (n, 2) ndarray
    crossings : (n (n - 3) / 2, 2) ndarray
        Intersections of extended non-adjacent edges.
    grid : (m, m, 2) ndarray
    weight : (m, m) ndarray
        Of the first corner, on the grid.
    denominator : (m, m) ndarray
        The adjoint, on the grid.
    difference : float
        Between the adjoint and the polynomial of degree n - 3 that vanishes at the crossings, on
        the grid, relative to the adjoint.
    poles : (k, 2) ndarray
        Points where the adjoint is zero to rounding.
    refused : int
        The number of poles that the coordinates refuse.
    """

    corners: np.ndarray
    crossings: np.ndarray
    grid: np.ndarray
    weight: np.ndarray
    denominator: np.ndarray
    difference: float
    poles: np.ndarray
    refused: int

    @classmethod
    def of(cls, corners: np.ndarray, directions: int, side: int) -> Outside:
        """Evaluate along a number of directions, and on a grid with a number of points per side."""
        planes, method = Planes.of(corners), BarycentricCoordinates(corners)
        crossings = formulas.crossings(planes)
        size = 2 + 2 * np.abs(crossings).max()
        ticks = size * (np.arange(side) + 0.5) / side - size / 2
        # shifted slightly, so that no grid point lies on the curve
        grid = np.stack(np.meshgrid(ticks, ticks + GOLDEN * size / (9 * side)), axis=-1)
        flat = grid.reshape(-1, 2)
        denominator = formulas.adjoint(planes, flat)
        degree = len(corners) - 3
        curve = formulas.on_curve(formulas.curve_through(crossings, degree), degree, flat)
        difference = denominator - (denominator @ curve / (curve @ curve)) * curve
        poles = _zeros(planes, regular(directions), size)
        return cls(
            corners,
            crossings,
            grid,
            method.weights(grid)[:, 0].reshape(side, side),
            denominator.reshape(side, side),
            np.abs(difference).max() / np.abs(denominator).max(),
            poles,
            _refused(method, poles),
        )

    def arrays(self) -> dict[str, np.ndarray]:
        """Return the arrays of the figures."""
        n = len(self.corners)
        return {
            f"outside_{n}_corners": self.corners,
            f"outside_{n}_crossings": self.crossings,
            f"outside_{n}_grid": self.grid,
            f"outside_{n}_weight": self.weight,
            f"outside_{n}_denominator": self.denominator,
        }


def _zeros(planes: Planes, directions: np.ndarray, size: float) -> np.ndarray:
    """Return the zeros (k, 2) of the adjoint on rays from the centre, to machine precision.

    They are found by bisection. A ray without a change of sign within the size has none.
    """
    inner, outer = np.zeros(len(directions)), np.full(len(directions), size)
    crosses = formulas.adjoint(planes, size * directions) < 0
    for _ in range(60):
        middle = (inner + outer) / 2
        inside = formulas.adjoint(planes, middle[:, None] * directions) > 0
        inner, outer = np.where(inside, middle, inner), np.where(inside, outer, middle)
    return (inner[:, None] * directions)[crosses]


def _refused(method: BarycentricCoordinates, x: np.ndarray) -> int:
    """Return the number of points at which the coordinates are refused."""
    count = 0
    for q in x:
        try:
            method.weights(q)
        except np.linalg.LinAlgError:
            count += 1
    return count
