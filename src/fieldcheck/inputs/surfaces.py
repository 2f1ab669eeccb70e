"""Surfaces of notebook 14, built from rectangular arrays of vertex numbers.

Their edges, loops and fans are known in advance.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

Surface = tuple[np.ndarray, np.ndarray]


def net(numbers: np.ndarray) -> np.ndarray:
    """Return the triangles of an array of vertex numbers, two for each of its squares."""
    a, b, c, d = numbers[:-1, :-1], numbers[:-1, 1:], numbers[1:, 1:], numbers[1:, :-1]
    return np.stack([a, b, c, a, c, d], axis=-1).reshape(-1, 3)


def sheet(rows: int = 3, columns: int = 4) -> Surface:
    """Return a rectangular, slightly bent sheet."""
    y, x = (axis.ravel() for axis in np.mgrid[: rows + 1, : columns + 1])
    return np.column_stack([x, y, 0.1 * x * y]), net(
        np.arange(x.size).reshape(rows + 1, columns + 1)
    )


def ball(rings: int = 3, around: int = 6) -> Surface:
    """Return a sphere, oriented outward: rings of vertices about the axis, and two poles."""
    up, turn = np.pi * np.arange(1, rings + 1) / (rings + 1), 2 * np.pi * np.arange(around) / around
    height, angle = (axis.ravel() for axis in np.meshgrid(up, turn, indexing="ij"))
    points = np.column_stack(
        [np.sin(height) * np.cos(angle), np.sin(height) * np.sin(angle), np.cos(height)]
    )
    numbers = np.pad(
        np.arange(rings * around).reshape(rings, around), ((0, 0), (0, 1)), mode="wrap"
    )
    first, last, n = numbers[0], numbers[-1], len(points)
    caps = [[n, i, j] for i, j in pairwise(first)]
    caps += [[n + 1, j, i] for i, j in pairwise(last)]
    return np.vstack([points, [[0, 0, 1], [0, 0, -1]]]), np.vstack([net(numbers)[:, ::-1], caps])


def ring(rows: int = 4, columns: int = 6) -> Surface:
    """Return a torus."""
    small, large = np.meshgrid(
        2 * np.pi * np.arange(rows) / rows, 2 * np.pi * np.arange(columns) / columns, indexing="ij"
    )
    wide = (2 + 0.8 * np.cos(small)).ravel()
    points = np.column_stack(
        [wide * np.cos(large.ravel()), wide * np.sin(large.ravel()), 0.8 * np.sin(small.ravel())]
    )
    return points, net(
        np.pad(np.arange(rows * columns).reshape(rows, columns), ((0, 1), (0, 1)), mode="wrap")
    )


def bottle(rows: int = 4, columns: int = 6) -> Surface:
    """Return a Klein bottle: a closed surface without an inside, with crossings in space."""
    numbers = np.arange(rows * columns).reshape(rows, columns)
    closed = np.vstack([numbers, numbers[:1]])
    return ring(rows, columns)[0], net(np.hstack([closed, closed[::-1, :1]]))


def band(twists: int, columns: int = 12) -> Surface:
    """Return a closed strip with half twists; one half twist gives the Möbius strip."""
    grid = np.meshgrid(
        np.linspace(-0.5, 0.5, 3), 2 * np.pi * np.arange(columns) / columns, indexing="ij"
    )
    across, along = (axis.ravel() for axis in grid)
    wide = 1.2 + across * np.cos(twists * along / 2)
    points = np.column_stack(
        [wide * np.cos(along), wide * np.sin(along), across * np.sin(twists * along / 2)]
    )
    numbers = np.arange(3 * columns).reshape(3, columns)
    first = numbers[:, :1] if twists % 2 == 0 else numbers[::-1, :1]
    return points, net(np.hstack([numbers, first]))


def unjoined(twists: int, columns: int) -> Surface:
    """Return a strip with half twists whose ends meet, but have no common vertices."""
    points = band(twists, columns)[0].reshape(3, columns, 3)
    first = points[::-1, :1] if twists % 2 else points[:, :1]
    return np.hstack([points, first]).reshape(-1, 3), sheet(2, columns)[1]


def halves(rings: int, around: int) -> Surface:
    """Return a sphere cut along a ring into an outward and an inward half."""
    points, triangles = ball(2 * rings + 1, around)
    upper = points[triangles].mean(axis=1)[:, 2] > 0
    lower = triangles[~upper][:, ::-1] + len(points)
    return np.vstack([points, points]), np.vstack([triangles[upper], lower])


def book(pages: int) -> Surface:
    """Return triangles that share one edge, as the pages of a book share its spine."""
    angle = 2 * np.pi * np.arange(pages) / pages
    points = np.vstack(
        [[[0, 0, 0], [0, 0, 1]], np.column_stack([np.cos(angle), np.sin(angle), 0.5 + 0 * angle])]
    )
    return points, np.array([[0, 1, 2 + k] if k % 2 else [1, 0, 2 + k] for k in range(pages)])


def joined(*surfaces: Surface) -> Surface:
    """Return several surfaces as one list of triangles, side by side."""
    points, triangles, n = [], [], 0
    for k, (p, t) in enumerate(surfaces):
        points.append(p + np.array([5.0 * k, 0, 0]))
        triangles.append(t + n)
        n += len(p)
    return np.vstack(points), np.vstack(triangles)


def walled() -> Surface:
    """Return a sphere with a wall across its middle: three triangles meet along the rim of it."""
    points, triangles = ball(3, 6)
    middle, n = np.arange(6, 12), len(points)
    wall = np.column_stack([np.full(6, n), middle, np.roll(middle, -1)])
    return np.vstack([points, [[0, 0, 0]]]), np.vstack([triangles, wall])


def repeated(surface: Surface, *twice: int) -> Surface:
    """Return a surface with some triangles listed twice."""
    return surface[0], np.vstack([surface[1], surface[1][list(twice)]])


def fused(surface: Surface, *pairs: tuple[int, int]) -> Surface:
    """Return a surface in which some vertices are replaced by others."""
    points, triangles = surface
    name = np.arange(len(points))
    for kept, gone in pairs:
        name[gone] = kept
    return points, name[triangles]


def without(surface: Surface, *left_out: int) -> Surface:
    """Return a surface without some of its triangles."""
    return surface[0], np.delete(surface[1], left_out, axis=0)


def flipped(random: np.random.Generator, surface: Surface, share: float = 0.4) -> Surface:
    """Return a surface in which some triangles, including the last, have reversed orientation."""
    points, triangles = surface[0], surface[1].copy()
    chosen = random.random(len(triangles)) < share
    chosen[-1] = True
    triangles[chosen] = triangles[chosen][:, [0, 2, 1]]
    return points, triangles


def shuffled(random: np.random.Generator, surface: Surface, spare: int = 0) -> Surface:
    """Return a surface in random order, with some unused vertices."""
    points, triangles = surface
    n = len(points) + spare
    name = random.permutation(n)
    moved = random.normal(size=(n, 3))
    moved[name[: len(points)]] = points
    rolled = [np.roll(t, random.integers(3)) for t in name[triangles]]
    return moved, np.array(rolled)[random.permutation(len(rolled))]


TRIANGLE = np.eye(3), np.array([[0, 1, 2]])
"""A single triangle."""


def alike(random: np.random.Generator, base: int, as_text: bool = False) -> Surface:
    """Return two triangles without a common vertex that a key of two vertices may confuse.

    For vertices i < j, two edges of one triangle have the values base i + j of two edges of the
    other, or the same digits if i and j are written one after the other.
    """
    i, (j, k) = random.integers(1, 5), np.sort(50 + random.permutation(50)[:2])
    other = 10 * i + 1 if as_text else i + 1
    triangles = np.array([[i, base + j, base + k], [other, j, k]])
    return random.normal(size=(base + 100, 3)), triangles


def large_numbers(random: np.random.Generator) -> dict[str, Surface]:
    """Return triangles with vertex numbers below and above 100."""
    return {
        "two triangles with large numbers": alike(random, 100),
        "two other triangles with large numbers": alike(random, 100, as_text=True),
    }


def numbers_on_both_sides(random: np.random.Generator) -> dict[str, Surface]:
    """Return triangles that a key of two vertices, i + 100 j or i + 1000 j for i < j, confuses."""
    made = {}
    for base in (100, 1000):
        i, (j, k) = random.integers(1, 5), np.sort(base + 50 + 2 * random.permutation(20)[:2])
        triangles = np.array([[base + i, j, k], [i, j + 1, k + 1]])
        points = random.normal(size=(base + 100, 3))
        made[f"two triangles with numbers below and above {base}"] = points, triangles
    return made


def larger_numbers(random: np.random.Generator) -> dict[str, Surface]:
    """Return triangles whose vertex numbers differ by 256 or 512, which a byte cannot show."""
    points, triangles = alike(random, 256)
    return {
        "two triangles with numbers below and above 512": alike(random, 512),
        "two triangles with numbers above 260": (
            np.vstack([points, points[:260]]),
            triangles + 260,
        ),
    }


def thousands(random: np.random.Generator) -> dict[str, Surface]:
    """Return triangles with vertex numbers below and above 1000."""
    return {
        "two triangles with numbers up to 1100": alike(random, 1000),
        "two other triangles with numbers up to 1100": alike(random, 1000),
    }


def few(random: np.random.Generator) -> dict[str, Surface]:
    """Return a strip of three triangles, as many as a triangle has vertices."""
    return {"a strip of three triangles": shuffled(random, without(sheet(1, 2), 1))}


def hundreds(random: np.random.Generator) -> dict[str, Surface]:
    """Return surfaces of some hundred triangles, each with one hole of three edges."""
    return {
        "a sphere of 69 triangles with a hole": shuffled(random, without(ball(5, 7), 0)),
        "a torus of 69 triangles with a hole": shuffled(random, without(ring(5, 7), 5)),
    }


def sides_by_name(triangles: np.ndarray) -> list[tuple[int, int]]:
    """Return the ends of each side, in the direction of its triangle."""
    return [(int(t[k]), int(t[k - 2])) for t in triangles for k in range(3)]
