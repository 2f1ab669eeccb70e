"""Space cut into boxes that hold equally many sites, and the balls that reach into each box."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Boxes:
    """A balanced binary tree of boxes, each cut across its longest side; they fill all space.

    Attributes
    ----------
    axes, cuts : tuple of (2^l,) ndarray
        Of each level: across which axis each box is cut, and where.
    sites : (2^L, s) ndarray
        Sites in the boxes of the last level; -1 where there is none.
    """

    axes: tuple[np.ndarray, ...]
    cuts: tuple[np.ndarray, ...]
    sites: np.ndarray

    @classmethod
    def around(cls, points: np.ndarray, most: int) -> Boxes:
        """Boxes with at most so many of the sites (n, d), one or more."""
        every = np.append(np.arange(len(points)), -1)[None, :]
        return cls((), (), every).finer(points, most)

    def finer(self, points: np.ndarray, most: int) -> Boxes:
        """The same boxes, cut on until there are at most so many sites in each."""
        axes, cuts, rows = list(self.axes), list(self.cuts), self.sites
        places = points.T[:, rows]
        while rows.shape[1] - 1 > most:
            axis, cut, rows, places = halved(rows, places)
            axes.append(axis)
            cuts.append(cut)
        return Boxes(tuple(axes), tuple(cuts), rows)

    def containing(self, x: np.ndarray) -> np.ndarray:
        """The box (m,) of each of the places (m, d)."""
        box, each = np.zeros(len(x), dtype=np.intp), np.arange(len(x))
        for axis, cut in zip(self.axes, self.cuts, strict=True):
            box = 2 * box + (x[each, axis[box]] > cut[box])
        return box

    def reached(self, centers: np.ndarray, radii: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Which balls reach into each box: `ball[start[b] : start[b + 1]]`."""
        ball, box = np.arange(len(centers)), np.zeros(len(centers), dtype=np.intp)
        outside = np.zeros_like(centers)  # how far the centre lies outside the box, by axis
        for axis, cut in zip(self.axes, self.cuts, strict=True):
            across = axis[box]
            beyond = centers[ball, across] - cut[box]
            sides = []
            for side, excess in ((0, beyond), (1, -beyond)):
                to_box = outside.copy()
                each = np.arange(len(ball)), across
                to_box[each] = np.maximum(to_box[each], excess)
                near = np.einsum("pd,pd->p", to_box, to_box) <= radii[ball] ** 2
                sides.append((ball[near], 2 * box[near] + side, to_box[near]))
            ball, box, outside = (np.concatenate(part) for part in zip(*sides, strict=True))
        order = np.argsort(box, kind="stable")
        start = np.searchsorted(box[order], np.arange(len(self.sites) + 1))
        return ball[order], start


def halved(
    rows: np.ndarray, places: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Cut each row of sites across the longest side of its box, into halves that differ by one.

    Parameters
    ----------
    rows : (b, s + 1) ndarray
        Numbers of sites, s or s + 1 in each row; where the last is missing, -1.
    places : (d, b, s + 1) ndarray
        Where they are.

    Returns
    -------
    axis, cut : (b,) ndarray
        Across which axis, and where.
    halves : (2 b, s // 2 + 1) ndarray
        Rows of the same form, two for each.
    halfplaces : (d, 2 b, s // 2 + 1) ndarray
        Where they are.
    """
    low, high = extents(rows, places)
    axis = np.argmax(high - low, axis=0)
    along = places[axis, np.arange(len(rows))]
    along[rows[:, -1] < 0, -1] = np.inf
    s = rows.shape[1] - 1
    left = (s + 1) // 2
    order = np.argpartition(along, (left, s), axis=1)  # what is no site stays last
    along = np.take_along_axis(along, order, axis=1)
    cut = along[:, :left].max(axis=1) / 2 + along[:, left] / 2
    halves = _split(np.take_along_axis(rows, order, axis=1), left, -1)
    halfplaces = [_split(np.take_along_axis(p, order, axis=1), left, 0.0) for p in places]
    return axis, cut, halves, np.stack(halfplaces)


def extents(rows: np.ndarray, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Lowest and highest coordinates (d, b) of the sites in each row."""
    low, high = places[..., :-1].min(axis=2), places[..., :-1].max(axis=2)
    last = places[..., -1]
    there = rows[:, -1] >= 0
    return np.where(there, np.minimum(low, last), low), np.where(
        there, np.maximum(high, last), high
    )


def _split(ordered: np.ndarray, left: int, nothing: float) -> np.ndarray:
    """The first `left` columns and the rest as rows of the same length."""
    b, s = ordered.shape[0], ordered.shape[1] - 1
    halves = np.full((b, 2, s // 2 + 1), nothing, dtype=ordered.dtype)
    halves[:, 0, :left] = ordered[:, :left]
    halves[:, 1] = ordered[:, left:]
    return halves.reshape(2 * b, -1)
