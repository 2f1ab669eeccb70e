"""Polygons and polyhedra, and the planes of their faces."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np
from scipy.spatial import ConvexHull

GOLDEN = (1 + 5**0.5) / 2

_SIGNS = np.array([*product((-1.0, 1.0), repeat=3)])
_OCTAHEDRON = np.vstack([np.eye(3), -np.eye(3)])
_SQUARE = np.array([[-1.0, -1], [1, -1], [1, 1], [-1, 1]])


def _cyclic(a: float, b: float) -> np.ndarray:
    """Return (0, ±a, ±b) and its cyclic permutations."""
    rows = np.array([[0, s * a, t * b] for s, t in product((-1, 1), repeat=2)])
    return np.vstack([np.roll(rows, k, axis=1) for k in range(3)])


POLYHEDRA = {
    "tetrahedron": np.array([[1.0, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]),
    "cube": _SIGNS,
    "dodecahedron": np.vstack([_SIGNS, _cyclic(1 / GOLDEN, GOLDEN)]),
    "octahedron": _OCTAHEDRON,
    "square pyramid": np.vstack([np.column_stack([_SQUARE, np.zeros(4)]), [[0, 0, 2]]]),
    "rhombic dodecahedron": np.vstack([_SIGNS, 2 * _OCTAHEDRON]),
}


OUTSIDE = {
    4: np.array([[-1.0, -1], [1, -0.5], [0.4, 0.4], [-0.5, 1]]),
    5: np.array([[0.9, 0.4], [-0.1, 0.8], [-0.9, 0.3], [-0.7, -0.6], [0.6, -0.8]]),
    6: np.array([[1.0, 0], [-0.9, 0.5], [-0.7, -0.7], [-0.3, -1], [0.5, -0.9], [0.8, -0.5]]),
}
"""Polygons of which any two edges, extended, intersect nearby."""


def regular(n: int, turn: float = 0.0) -> np.ndarray:
    """Return the corners (n, 2) of a regular polygon about the origin, turned by an angle."""
    angle = turn + 2 * np.pi * np.arange(n) / n
    return np.stack([np.cos(angle), np.sin(angle)], axis=1)


def irregular(n: int, seed: int) -> np.ndarray:
    """Return the corners (n, 2) of a random convex polygon: on an ellipse, well separated."""
    angle = 2 * np.pi * (np.arange(n) + 0.4 * np.random.default_rng(seed).random(n)) / n
    return np.stack([np.cos(angle), 0.8 * np.sin(angle)], axis=1)


def polygons(corners: int, seed: int) -> dict[str, np.ndarray]:
    """Return the polygons by name; the last is random, with the given number of corners."""
    return {
        "triangle": np.array([[-0.9, -0.8], [0.9, -0.5], [-0.2, 0.9]]),
        "square": 0.75 * _SQUARE,
        "regular pentagon": regular(5, np.pi / 2),
        "regular hexagon": regular(6),
        f"random {corners}-gon": irregular(corners, seed),
    }


@dataclass(frozen=True)
class Planes:
    """A convex polytope by its faces n^T x <= b, found by Qhull.

    Attributes
    ----------
    normals : (f, d) ndarray
        Outward unit normals.
    offsets : (f,) ndarray
    corners : (n, d) ndarray
    on : (n, f) ndarray of bool
        Whether a corner lies on a face.
    """

    normals: np.ndarray
    offsets: np.ndarray
    corners: np.ndarray
    on: np.ndarray

    @classmethod
    def of(cls, corners: np.ndarray) -> Planes:
        """Return the faces of the hull; triangles in one plane are merged into one face."""
        hull = ConvexHull(corners)
        _, first = np.unique(hull.equations.round(9), axis=0, return_index=True)
        normals, offsets = hull.equations[first, :-1], -hull.equations[first, -1]
        return cls(normals, offsets, corners, np.abs(corners @ normals.T - offsets) < 1e-9)

    @property
    def faces_at(self) -> np.ndarray:
        """The number of faces that meet at each corner."""
        return self.on.sum(axis=1)

    @property
    def simple(self) -> bool:
        """Whether d faces meet at every corner."""
        return bool((self.faces_at == self.normals.shape[1]).all())

    def around(self, face: int) -> np.ndarray:
        """Return the corners of a face in space, counter-clockwise when seen from outside."""
        members = np.flatnonzero(self.on[:, face])
        from_middle = self.corners[members] - self.corners[members].mean(axis=0)
        side = np.cross(self.normals[face], from_middle[0])
        return members[np.argsort(np.arctan2(from_middle @ side, from_middle @ from_middle[0]))]

    @property
    def edges(self) -> np.ndarray:
        """Return the edges (e, 2) of a polyhedron: pairs of corners with two faces in common."""
        shared = self.on.astype(int) @ self.on.T
        return np.argwhere(np.triu(shared, 1) == 2)

    @property
    def opposite(self) -> tuple[np.ndarray, np.ndarray]:
        """Return two pairs of faces at the first corner of four, each pair meeting only there."""
        at = np.flatnonzero(self.on[self.faces_at == 4][0])
        meet = self.on[:, at].astype(int).T @ self.on[:, at]
        across = at[meet[0].argmin()]
        return np.array([at[0], across]), np.setdiff1d(at[1:], across)


def mesh_of(corners: np.ndarray, rings: int) -> tuple[np.ndarray, np.ndarray]:
    """Return points and triangles that fill a convex polygon, in the plane or in space.

    Parameters
    ----------
    corners : (k, d) ndarray
        In cyclic order.
    rings : int
        Rings about the centre, and segments of each edge.
    """
    step = np.arange(rings)[:, None, None] / rings
    along = corners + step * (np.roll(corners, -1, axis=0) - corners)
    boundary = along.swapaxes(0, 1).reshape(-1, corners.shape[1])
    middle = corners.mean(axis=0)
    points = middle + (1 + np.arange(rings))[:, None, None] / rings * (boundary - middle)
    here = 1 + np.arange(rings * len(boundary)).reshape(rings, -1)
    beside = np.roll(here, -1, axis=1)
    triangles = [
        np.stack([np.zeros_like(here[0]), here[0], beside[0]], axis=-1),
        np.stack([here[:-1], here[1:], beside[1:]], axis=-1),
        np.stack([here[:-1], beside[1:], beside[:-1]], axis=-1),
    ]
    return (
        np.vstack([middle[None], points.reshape(-1, corners.shape[1])]),
        np.concatenate([t.reshape(-1, 3) for t in triangles]),
    )
