"""Triangle meshes of surfaces: closed, with handles, with a boundary, and non-orientable."""

from __future__ import annotations

import numpy as np

Surface = tuple[np.ndarray, np.ndarray]
"""Points (n, 3) and triangles (m, 3)."""

_GOLDEN = (1 + 5**0.5) / 2


def sphere(level: int) -> Surface:
    """Return the unit sphere: an icosahedron with repeatedly subdivided triangles."""
    one, other = np.array([[-1, 1, -1, 1], [_GOLDEN, _GOLDEN, -_GOLDEN, -_GOLDEN]])
    zero = np.zeros(4)
    points = np.concatenate(
        [
            np.column_stack([one, other, zero]),
            np.column_stack([zero, one, other]),
            np.column_stack([other, zero, one]),
        ]
    )
    points /= np.linalg.norm(points, axis=1)[:, None]
    triangles = _outward(points, _hull(points))
    for _ in range(level):
        points, triangles = refined(points, triangles)
        points /= np.linalg.norm(points, axis=1)[:, None]
    return points, triangles


def refined(points: np.ndarray, triangles: np.ndarray) -> Surface:
    """Subdivide each triangle into four at the midpoints of its edges."""
    n, sides = len(points), np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    key, middle = np.unique(sides[:, 0] * n + sides[:, 1], return_inverse=True)
    ab, bc, ca = n + middle.reshape(-1, 3).T
    a, b, c = triangles.T
    corners = ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))
    middles = (points[key // n] + points[key % n]) / 2
    return np.concatenate([points, middles]), np.concatenate([np.stack(t, 1) for t in corners])


def bumpy(level: int) -> Surface:
    """Return a sphere with hills and saddles all over, 20 · 4ˡᵉᵛᵉˡ triangles."""
    points, triangles = sphere(level)
    x, y, z = points.T
    return points * (1 + 0.1 * np.sin(9 * x) * np.sin(8 * y) * np.cos(7 * z))[:, None], triangles


def cube(cells: int) -> Surface:
    """Return the unit cube, with a number of squares along each edge."""
    u, v = np.meshgrid(*[np.arange(cells + 1)] * 2, indexing="ij")
    square = np.column_stack([u.ravel(), v.ravel()])
    corner = np.arange((cells + 1) ** 2).reshape(cells + 1, -1)
    a, b, c, d = (
        q.ravel() for q in (corner[:-1, :-1], corner[1:, :-1], corner[1:, 1:], corner[:-1, 1:])
    )
    cut = np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])])
    points: list[np.ndarray] = []
    triangles: list[np.ndarray] = []
    for axis in range(3):
        for height in (0, cells):
            face = np.insert(square, 2, height, axis=1)[:, np.roll([0, 1, 2], axis)]
            triangles.append((cut if height else cut[:, ::-1]) + len(square) * len(points))
            points.append(face)
    places, number = np.unique(np.concatenate(points), axis=0, return_inverse=True)
    return places / cells, number.ravel()[np.concatenate(triangles)]


def torus(around: int, across: int) -> Surface:
    """Return a torus with the radii 1 and 0.4."""
    u, v = _angles(around, across)
    r = 1 + 0.4 * np.cos(v)
    points = np.column_stack([r * np.cos(u), r * np.sin(u), 0.4 * np.sin(v)])
    return points, _sewn(around, across, twisted=False)


def klein_bottle(around: int, across: int) -> Surface:
    """Return the figure-eight immersion of the Klein bottle."""
    u, v = _angles(around, across)
    v += np.pi / across  # no vertex where the eight crosses itself
    r = np.cos(u / 2) * np.sin(v) - np.sin(u / 2) * np.sin(2 * v)
    height = np.sin(u / 2) * np.sin(v) + np.cos(u / 2) * np.sin(2 * v)
    points = np.column_stack([(2 + r) * np.cos(u), (2 + r) * np.sin(u), height]) / 2
    return points, _sewn(around, across, twisted=True)


def band(around: int, *, half_turns: int) -> Surface:
    """Return a band around the unit circle; with one half-twist it is the Möbius band."""
    u = np.repeat(2 * np.pi * np.arange(around) / around, 2)
    s = np.tile([-0.3, 0.3], around)
    r = 1 + s * np.cos(half_turns * u / 2)
    points = np.column_stack([r * np.cos(u), r * np.sin(u), s * np.sin(half_turns * u / 2)])
    a, b = 2 * np.arange(around), 2 * np.arange(around) + 1
    c, d = np.roll(a, -1), np.roll(b, -1)
    if half_turns % 2:
        c[-1], d[-1] = d[-1], c[-1]
    return points, np.concatenate([np.column_stack([a, c, d]), np.column_stack([a, d, b])])


def together(*surfaces: Surface) -> Surface:
    """Return several surfaces as one, without shared points."""
    starts = np.cumsum([0, *(len(points) for points, _ in surfaces)])
    triangles = [t + start for (_, t), start in zip(surfaces, starts, strict=False)]
    return np.concatenate([points for points, _ in surfaces]), np.concatenate(triangles)


def turned_over(surface: Surface) -> Surface:
    """Return the surface with inverted orientation."""
    points, triangles = surface
    return points, triangles[:, ::-1]


def _angles(around: int, across: int) -> tuple[np.ndarray, np.ndarray]:
    u, v = np.meshgrid(np.arange(around) / around, np.arange(across) / across, indexing="ij")
    return 2 * np.pi * u.ravel(), 2 * np.pi * v.ravel()


def _sewn(around: int, across: int, *, twisted: bool) -> np.ndarray:
    """Triangles of a grid that is periodic in both directions, possibly with a twist in one."""
    number = np.arange(around * across).reshape(around, across)
    beyond = number[:1, ::-1] if twisted else number[:1]
    after = np.concatenate([number[1:], beyond])
    a, b, c, d = (
        q.ravel() for q in (number, after, np.roll(after, -1, axis=1), np.roll(number, -1, axis=1))
    )
    return np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])])


def _hull(points: np.ndarray) -> np.ndarray:
    """Triangles of mutually nearest points on a sphere."""
    distance = np.linalg.norm(points[:, None] - points, axis=2)
    near = (distance > 0) & (distance < 1.01 * distance[distance > 0].min())
    i, j, k = np.nonzero(near[:, :, None] & near[:, None] & near[None])
    ordered = (i < j) & (j < k)
    return np.column_stack([i, j, k])[ordered]


def _outward(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    inward = np.linalg.det(points[triangles]) < 0
    return np.where(inward[:, None], triangles[:, ::-1], triangles)
