"""Sites about many vertices at once: where they are, in local frames, and how much they weigh."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fieldrecon.polynomials import EPS
from fieldrecon.radial import Radial

# Weights above this stand for infinity: their squares, and the inverses of those, are numbers.
_INFINITE = 1e120


@dataclass(frozen=True)
class Stars:
    """Sites about a batch of m vertices, at most k of them each.

    Attributes
    ----------
    vertices : (m,) ndarray of int
        The vertices.
    index : (m, k) ndarray of int
        Sites (faces or cells) about each.
    there : (m, k) ndarray of bool
        Where there is one.
    """

    vertices: np.ndarray
    index: np.ndarray
    there: np.ndarray

    def some(self, chosen: np.ndarray) -> Stars:
        """The chosen ones."""
        return Stars(self.vertices[chosen], self.index[chosen], self.there[chosen])


@dataclass(frozen=True)
class LocalWeights:
    """What a fit makes of a batch of stars.

    Attributes
    ----------
    weights : (m, r, k) ndarray
        Weights of the data in each of the r results; nan where they are not determined.
    amplification : (m,) ndarray
        Change of the results by errors of norm one of the data, in units in which both have size
        one; infinite where they are not determined.
    counted : (m,) ndarray of int
        How many sites have a part in the fit.
    """

    weights: np.ndarray
    amplification: np.ndarray
    counted: np.ndarray


def as_weight(weight: Radial | None, none_allowed: bool = True) -> Radial | None:
    """A weight that falls with the distance, or none."""
    if weight is None and none_allowed:
        return None
    if not isinstance(weight, Radial):
        raise ValueError(
            f"weight must be a radial function such as inverse_square(0.1); got {weight!r}"
        )
    if weight.order > 0 or weight.homogeneity > 0:
        raise ValueError(f"weight must be positive and fall with the distance; {weight!r} does not")
    return weight


def scaled_offsets(offset: np.ndarray, there: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Offsets (m, k, d) of the sites in units (m,) of their size, powers of two."""
    # a sum instead of the largest: numpy adds along a short axis in a fraction of the time
    size = np.einsum("mkd,mk->mk", np.abs(offset), there).max(axis=1)
    unit = np.exp2(np.ceil(np.log2(np.where(size > 0, size, 1.0))))
    return offset / unit[:, None, None], unit


def relative_weights(
    weight: Radial | None, unit: float, offset: np.ndarray, there: np.ndarray
) -> np.ndarray:
    """Weights (m, k) of sites at offsets (m, k, d), the largest of each vertex one.

    Distances are taken in units of the size of the mesh: no square of them overflows.
    """
    if weight is None:
        return there.astype(np.float64)
    with np.errstate(all="ignore"):  # a weight may vanish, or be infinite at a distance of zero
        w = weight.in_units(unit)(np.linalg.norm(offset / unit, axis=2))
    w = np.where(there, np.minimum(w, _INFINITE), 0.0)
    top = w.max(axis=1, initial=0.0)
    return w / np.where(top > 0, top, 1.0)[:, None]


def number_that_count(w: np.ndarray) -> np.ndarray:
    """How many of the weights (m, k), the largest one, are above rounding: only they end a search.

    A narrow gaussian gives some weight to every site there is.
    """
    return np.count_nonzero(w > EPS, axis=1)
