"""Independent formulas for barycentric coordinates: slow or ill-conditioned, for comparison.

Each function computes the weights of a convex polytope in another way: the quotient of the slides,
the volumes of the polar dual from a convex hull, faces shifted apart at the corners, rational
arithmetic, and the closed forms for simplices and cubes. The errors beside edges and corners, and
the poles outside a polygon, are found with them.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from itertools import combinations

import numpy as np
from scipy.spatial import ConvexHull

from fieldrecon.barycentric.coordinates import BarycentricCoordinates
from fieldreport.experiments.barycentric.polytopes import GOLDEN, Planes, regular


def affine(corners: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Return the weights (m, d + 1) of a simplex: the solution of sum w = 1, sum w p = x."""
    system = np.vstack([corners.T, np.ones(len(corners))])
    return np.linalg.solve(system, np.vstack([x.T, np.ones(len(x))])).T


def multilinear(corners: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Return the weights (m, 2**d) of a square or cube with corners (±r, ±r, ...)."""
    return ((1 + x[:, None] / corners) / 2).prod(axis=2)


def quotient(planes: Planes, x: np.ndarray, faces: int | None = None) -> np.ndarray:
    """Return the slides' weights (m, n), |det N_i| / prod n_a^T (p_i - x) over their sum.

    Parameters
    ----------
    planes : Planes
        The polytope.
    x : (m, d) ndarray
        Queries.
    faces : int, optional
        Use only this number of faces at each corner; by default all, of which there must be d.
    """
    w = np.empty((len(x), len(planes.corners)))
    for i, p in enumerate(planes.corners):
        normals = planes.normals[planes.on[i]][:faces]
        w[:, i] = abs(np.linalg.det(normals)) / ((p - x) @ normals.T).prod(axis=1)
    return w / w.sum(axis=1, keepdims=True)


def polar(planes: Planes, x: np.ndarray) -> np.ndarray:
    """Return the weights (m, n) as volumes of the polar dual about each query, found by Qhull.

    The dual has a corner n_a / (n_a^T (p_a - x)) for each face, and for each corner p_i a facet on
    the plane y^T (p_i - x) = 1; w_i is the volume of the cone from the origin over that facet.
    """
    w = np.zeros((len(x), len(planes.corners)))
    for row, q in zip(w, x, strict=True):
        dual = planes.normals / (planes.offsets - planes.normals @ q)[:, None]
        hull = ConvexHull(dual)
        away = planes.corners - q
        away /= np.linalg.norm(away, axis=1)[:, None]
        corner = (hull.equations[:, :-1] @ away.T).argmax(axis=1)
        np.add.at(row, corner, np.abs(np.linalg.det(dual[hull.simplices])))
    return w / w.sum(axis=1, keepdims=True)


def split(planes: Planes, shifts: np.ndarray) -> tuple[Planes, np.ndarray]:
    """Return the polyhedron with its faces shifted outwards, and the original of each corner.

    A corner of more than three faces splits into corners of three faces, which are found by trying
    all triples of faces.
    """
    offsets = planes.offsets + shifts
    triples = np.array([*combinations(range(len(offsets)), 3)])
    triples = triples[np.abs(np.linalg.det(planes.normals[triples])) > 1e-9]
    p = np.linalg.solve(planes.normals[triples], offsets[triples][..., None])[..., 0]
    inside = (p @ planes.normals.T <= offsets + 1e-13).all(axis=1)
    corners, triples = p[inside], triples[inside]
    on = np.zeros((len(corners), len(offsets)), dtype=bool)
    np.put_along_axis(on, triples, values=True, axis=1)
    apart = np.linalg.norm(corners[:, None] - planes.corners, axis=2)
    return Planes(planes.normals, offsets, corners, on), apart.argmin(axis=1)


def added_up(w: np.ndarray, origin: np.ndarray, n: int) -> np.ndarray:
    """Return the weights (m, n) of corners as sums over the corners into which they split."""
    return w @ (origin[:, None] == np.arange(n))


def rational(corners: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Return the exact weights (n,) at x of a polygon with corners in counter-clockwise order."""
    p = [[Fraction(c) for c in row] for row in corners.tolist()]
    q = [Fraction(c) for c in x.tolist()]
    n = len(p)
    edges = [[b - a for a, b in zip(p[a], p[(a + 1) % n], strict=True)] for a in range(n)]
    to = [[c - b for b, c in zip(p[a], q, strict=True)] for a in range(n)]
    h = [_cross(edge, away) for edge, away in zip(edges, to, strict=True)]
    w = []
    for i in range(n):
        term = _cross(edges[i - 1], edges[i])
        for a in range(n):
            term *= 1 if a in (i, (i - 1) % n) else h[a]
        w.append(term)
    total = sum(w)
    return np.array([float(term / total) for term in w])


def _cross(a: list[Fraction], b: list[Fraction]) -> Fraction:
    return a[0] * b[1] - a[1] * b[0]


def adjoint(planes: Planes, x: np.ndarray) -> np.ndarray:
    """Return the common denominator (m,) of the coordinates of a polygon, sum of the products.

    It is a polynomial of degree n - 3, since the highest terms cancel.
    """
    h = planes.offsets - x @ planes.normals.T
    total = np.zeros(len(x))
    for on in planes.on:
        total += abs(np.linalg.det(planes.normals[on])) * h[:, ~on].prod(axis=1)
    return total


def crossings(planes: Planes) -> np.ndarray:
    """Return the intersections (n (n - 3) / 2, 2) of extended non-adjacent edges of a polygon."""
    pairs = [
        (a, b)
        for a, b in combinations(range(len(planes.offsets)), 2)
        if not (planes.on[:, a] & planes.on[:, b]).any()
    ]
    return np.array([np.linalg.solve(planes.normals[[*p]], planes.offsets[[*p]]) for p in pairs])


def curve_through(points: np.ndarray, degree: int) -> np.ndarray:
    """Return the coefficients of the polynomial of this degree that vanishes at these points.

    The number of points must be the number of coefficients less one; the polynomial is then unique
    up to a factor.
    """
    return np.linalg.svd(_monomials(points, degree))[2][-1]


def on_curve(coefficients: np.ndarray, degree: int, x: np.ndarray) -> np.ndarray:
    """Return the values (m,) of that polynomial at points (m, 2)."""
    return _monomials(x, degree) @ coefficients


def _monomials(x: np.ndarray, degree: int) -> np.ndarray:
    powers = [(i, j) for i in range(degree + 1) for j in range(degree + 1 - i)]
    return np.stack([x[:, 0] ** i * x[:, 1] ** j for i, j in powers], axis=1)


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
        exact = np.array([rational(corners, q) for q in x])
        with np.errstate(all="ignore"):
            error = np.abs(quotient(planes, x) - exact).max(axis=1)
        row[0] = np.where(np.isfinite(error), error, -1)
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
        points = crossings(planes)
        size = 2 + 2 * np.abs(points).max()
        ticks = size * (np.arange(side) + 0.5) / side - size / 2
        # shifted slightly, so that no grid point lies on the curve
        grid = np.stack(np.meshgrid(ticks, ticks + GOLDEN * size / (9 * side)), axis=-1)
        flat = grid.reshape(-1, 2)
        denominator = adjoint(planes, flat)
        degree = len(corners) - 3
        curve = on_curve(curve_through(points, degree), degree, flat)
        difference = denominator - (denominator @ curve / (curve @ curve)) * curve
        poles = _zeros(planes, regular(directions), size)
        return cls(
            corners,
            points,
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
    crosses = adjoint(planes, size * directions) < 0
    for _ in range(60):
        middle = (inner + outer) / 2
        inside = adjoint(planes, middle[:, None] * directions) > 0
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
