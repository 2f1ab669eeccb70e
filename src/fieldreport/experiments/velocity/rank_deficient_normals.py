"""Points with normals for which B' is rank deficient, each with a path that approaches it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from fieldrecon.datasets.synthetic import uniform

Samples = tuple[np.ndarray, np.ndarray]


@dataclass(frozen=True)
class Configuration:
    """Samples that are rank deficient at t = 0.

    Attributes
    ----------
    name, title : str
        An identifier, and a title for readers.
    rank : int
        The rank of B' at t = 0, known by theory.
    at : callable
        Maps t to points and unit normals (n, d).
    edges : (n, 2, d) ndarray
        Ends of the edges at t = 0, if the samples are edges of triangles; none otherwise.
    """

    name: str
    title: str
    rank: int
    at: Callable[[float], Samples]
    edges: np.ndarray = field(default_factory=lambda: np.empty((0, 2, 2)))


def configurations(samples: int, seed: int) -> list[Configuration]:
    """Return all configurations, in the plane and in space, the last ones with random normals."""
    rng = np.random.default_rng(seed)
    return [*_in_the_plane(samples, rng), *_in_space(2 * samples, rng)]


def _in_the_plane(n: int, rng: np.random.Generator) -> list[Configuration]:
    p = 0.9 * (2 * uniform(n, 2, rng) - 1)
    m = np.array([0.3, -0.2])  # the centre, off the origin
    parallel = np.tile(_unit(np.array([0.3, 1.0])), (n, 1))
    free = _unit(rng.standard_normal((n, 2)))
    two, three = (np.where(np.arange(n)[:, None] < k, free, parallel) for k in (2, 3))
    in_line = p.copy()
    in_line[:3] = np.array([-0.6, -0.5]) + np.array([[0.0], [0.5], [1.1]]) * np.array([1.0, 0.6])
    along = {
        "rotation": ("rotation", lambda x: _turned(x - m)),
        "expansion": ("expansion", lambda x: x - m),
        "spiral": ("spiral", lambda x: 0.4 * (x - m) + _turned(x - m)),
        "saddle": ("saddle", lambda x: (x - m) * [1.0, -1.0]),
        "parabola": ("parabolas", lambda x: np.column_stack([np.ones(len(x)), 2 * x[:, 0]])),
    }
    tangent = [
        _turning(name, title, 5, p, _turned(_unit(u(p))), rng) for name, (title, u) in along.items()
    ]
    return [
        _turning("parallel", "all normals parallel", 3, p, parallel, rng),
        _turning("two", "all but two parallel", 5, p, two, rng),
        _turning("three", "all but three, in line", 5, in_line, three, rng),
        *tangent,
        _hyperbola(rng),
        _five_in_line(rng),
        _turning("random", "normals at random", 6, p, free, rng),
    ]


def _in_space(n: int, rng: np.random.Generator) -> list[Configuration]:
    p = 2 * uniform(n, 3, rng) - 1
    m, axis = np.array([0.3, -0.2, 0.1]), _unit(np.array([1.0, 1.0, 1.0]))
    free = _unit(rng.standard_normal((n, 3)))
    parallel = np.tile(_unit(np.array([0.3, 1.0, 0.5])), (n, 1))
    about = np.cross(axis, p - m)
    fields = {
        "axis": ("rotation about an axis", about),
        "source": ("expansion in space", p - m),
        "screw": ("screw", about + 0.4 * axis),
    }
    return [
        _turning("planes", "all parallel in space", 4, p, parallel, rng),
        *(
            _turning(name, title, 11, p, _unit(np.cross(u, free)), rng)
            for name, (title, u) in fields.items()
        ),
        _turning("random_space", "at random in space", 12, p, free, rng),
    ]


def _turning(
    name: str, title: str, rank: int, p: np.ndarray, n: np.ndarray, rng: np.random.Generator
) -> Configuration:
    """Samples whose normals rotate by angles of the order of t."""
    away = rng.standard_normal(n.shape)
    away -= (away * n).sum(axis=1)[:, None] * n
    return Configuration(name, title, rank, lambda t: (p, _unit(n + t * away)))


def _hyperbola(rng: np.random.Generator) -> Configuration:
    """The edges of a star with vertices on the hyperbola xy = 1/9, which move by t."""
    x = np.array([1.0, 2.6, 0.4, -0.45, -1.1, -2.4]) / 3
    vertices = np.column_stack([x, 1 / (9 * x)])
    order = 1 + np.argsort(np.arctan2(*(vertices[1:] - vertices[0]).T[::-1]))
    triangles = np.column_stack([np.zeros(5, dtype=int), order, np.roll(order, -1)])
    sides = triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    start, end = np.unique(np.sort(sides, axis=1), axis=0).T
    away = rng.standard_normal(vertices.shape) / 3

    def at(t: float) -> Samples:
        corner = vertices + t * away
        return (corner[start] + corner[end]) / 2, _turned(_unit(corner[end] - corner[start]))

    ends = np.stack([vertices[start], vertices[end]], axis=1)
    return Configuration("hyperbola", "vertices on a hyperbola", 5, at, ends)


def _five_in_line(rng: np.random.Generator) -> Configuration:
    """Six samples, five of them at distances t from a line, with arbitrary normals."""
    p = np.array([-0.7, -0.2]) + np.linspace(0, 1.4, 6)[:, None] * np.array([1.0, 0.5])
    p[5] = [0.3, -0.6]
    n, away = _unit(rng.standard_normal((6, 2))), rng.standard_normal((6, 2))
    return Configuration("five", "five of six points in line", 5, lambda t: (p + t * away, n))


def _turned(u: np.ndarray) -> np.ndarray:
    """Vectors (n, 2), rotated by 90 degrees."""
    return np.column_stack([-u[:, 1], u[:, 0]])


def _unit(u: np.ndarray) -> np.ndarray:
    return u / np.linalg.norm(u, axis=-1, keepdims=True)
