"""Weights of the corners of a convex polytope as products of heights below its faces.

    w_i(x) = sum_t vol(t) prod_{a not in t} h_a(x),   t: simplices of d faces at corner i

The only division is by the sum of all weights, and each face has one height. So the weights are
exact on faces, edges and corners, where quotients are 0/0, and accurate close to them, where
quotients of heights rounded differently are wrong.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fieldrecon._numerics.jets import product, quotient, rows_of_jet
from fieldrecon.polynomials import EPS

# Number of heights of size one whose product cannot underflow.
_FEW = 16

# A sum this small relative to its terms is rounding.
_ROUNDING = 64 * EPS

# Number of variables by the number of rows of a jet.
_VARIABLES = {rows_of_jet(d, order): d for d in (2, 3) for order in (1, 2)}

# Exponent of zero: it and sums of many such are below the exponents of all numbers.
_NONE = -(2**40)


class ProductForm:
    """The weights of the corners from the normals of the faces and the faces at each corner.

    Parameters
    ----------
    normals : (f, d) ndarray
        Outward normals, of any lengths.
    corner_faces : sequence of integer arrays
        Faces at each corner, d or more; in 3-D in order round it. Where more than d meet, the
        weight is the volume of the cone over the facet of the polar dual, cut into simplices from
        one corner.
    """

    def __init__(self, normals: np.ndarray, corner_faces: Sequence[np.ndarray]) -> None:
        self.normals = normals
        self.n = len(corner_faces)
        d = normals.shape[1]
        fans = [_fan(faces, d) for faces in corner_faces]
        self.corner = np.repeat(np.arange(self.n), [len(fan) for fan in fans])
        terms = np.concatenate(fans)
        self.volume = np.abs(np.linalg.det(normals[terms]))
        self.crowded = np.array([len(fan) > 1 for fan in fans])
        self._products = _Products(len(normals), terms)

    @property
    def numbers_per_query(self) -> int:
        """Number of numbers held at once for a query, for the size of the chunks."""
        numbers = self._products.count + len(self.corner)
        return numbers if len(self.normals) <= _FEW else 2 * numbers  # exponents too

    def weights(self, h: np.ndarray, out: np.ndarray) -> np.ndarray:
        """Weights (n, m) of sum one at heights (f, m), into `out`; where (m,) the sum vanishes."""
        w = self._summed(h[:, None])[:, 0]
        total = w.sum(axis=0)
        # inside, where no weight is negative, the sum loses nothing
        least = _ROUNDING * np.abs(w).sum(axis=0) if w.min(initial=0.0) < 0 else 0.0
        lost = ~(np.abs(total) > least)
        np.divide(w, np.where(lost, 1.0, total) if lost.any() else total, out=out)
        return lost

    def derivatives(self, h: np.ndarray, order: int) -> tuple[np.ndarray, np.ndarray]:
        """Derivatives (c, n, m) of the weights of sum one, and where (m,) the sum vanishes.

        They are rows of a jet below its values. The derivatives of the largest weight follow
        from the sum zero of all: where more than d faces meet, its own terms would cancel.
        """
        (f, d), m = self.normals.shape, h.shape[1]
        jets = np.zeros((f, rows_of_jet(d, order), m))  # heights are linear
        jets[:, 0], jets[:, 1 : 1 + d] = h, -self.normals[..., None]
        w = self._summed(jets).swapaxes(0, 1)
        total = w.sum(axis=1)
        lost = ~(np.abs(total[0]) > _ROUNDING * np.abs(w[0]).sum(axis=0))
        total[0, lost] = 1.0
        share = quotient(w, total[:, None], d)
        result, largest = share[1:], np.abs(share[:1]).argmax(axis=1)[:, None]
        np.put_along_axis(result, largest, 0.0, axis=1)
        np.put_along_axis(result, largest, -result.sum(axis=1, keepdims=True), axis=1)
        return result, lost

    def _summed(self, leaves: np.ndarray) -> np.ndarray:
        """Sums (n, c, m) of the terms of each corner, in a unit of each query's own."""
        terms, exponent = self._products(leaves)
        if exponent is not None:
            shift = np.maximum(exponent - exponent.max(axis=0), -2000)
            terms = np.ldexp(terms, shift[:, None])
        terms *= self.volume[:, None, None]
        if not self.crowded.any():
            return terms
        return np.add.reduceat(terms, np.flatnonzero(np.diff(self.corner, prepend=-1)), axis=0)


def _fan(faces: np.ndarray, d: int) -> np.ndarray:
    """Simplices (t, d) of faces, a fan about the first face."""
    if d == 2:
        return faces[None]
    first = np.full(len(faces) - 2, faces[0])
    return np.stack([first, faces[1:-1], faces[2:]], axis=1)


class _Products:
    """Products of n factors without some of them, for many choices, by a tree of partial products.

    The factors are the leaves n ... 2n - 1, and node k is the product of nodes 2k and 2k + 1. The
    product without some leaves multiplies the largest nodes that are above none of them. A factor
    is a jet: a value (1, m), perhaps with its derivatives, multiplied by the product rule.
    """

    def __init__(self, n: int, omitted: np.ndarray) -> None:
        self.n = n
        self.covers = [_cover(n, leaves) for leaves in (omitted + n).tolist()]
        wanted = {k for cover in self.covers for k in cover}
        for k in range(1, n):
            if k in wanted:
                wanted |= {2 * k, 2 * k + 1}
        self.inner = sorted((k for k in wanted if k < n), reverse=True)
        self.count = n + len(self.inner)

    def __call__(self, leaves: np.ndarray) -> tuple[np.ndarray, np.ndarray | None]:
        """Products (t, c, m) of factors (n, c, m), each times 2 to the exponent (t, m), if any."""
        node = dict(enumerate(leaves, start=self.n))
        out = np.empty((len(self.covers), *leaves.shape[1:]))
        if self.n <= _FEW:
            for k in self.inner:
                node[k] = _times(node[2 * k], node[2 * k + 1], np.empty(leaves.shape[1:]))
            for term, cover in zip(out, self.covers, strict=True):
                _multiplied([node[k] for k in cover], term)
            return out, None
        exponent = {k: np.zeros(leaves.shape[2], dtype=np.int64) for k in node}
        for k in self.inner:
            product = _times(node[2 * k], node[2 * k + 1], np.empty(leaves.shape[1:]))
            node[k], exponent[k] = _normalized(product, exponent[2 * k] + exponent[2 * k + 1])
        exponents = np.empty((len(out), leaves.shape[2]), dtype=np.int64)
        for term, total, cover in zip(out, exponents, self.covers, strict=True):
            _multiplied([node[k] for k in cover], term)
            total[:] = sum(exponent[k] for k in cover)
        return _normalized(out, exponents)


def _normalized(a: np.ndarray, exponent: np.ndarray | int) -> tuple[np.ndarray, np.ndarray]:
    """Factors (..., c, m) of size one with their exponents (..., m); none for zero."""
    size = np.abs(a).max(axis=-2)
    shift = np.frexp(size)[1]
    return np.ldexp(a, -shift[..., None, :]), np.where(size > 0, exponent + shift, _NONE)


def _cover(n: int, leaves: list[int]) -> list[int]:
    """The largest nodes above none of the leaves."""
    above = {leaf >> level for leaf in leaves for level in range(leaf.bit_length())}
    return [c for k in sorted(above) if 0 < k < n for c in (2 * k, 2 * k + 1) if c not in above]


def _multiplied(factors: list[np.ndarray], out: np.ndarray) -> None:
    if len(factors) == 1:
        out[:] = factors[0]
        return
    _times(factors[0], factors[1], out)
    for factor in factors[2:]:
        _times(out, factor, out)


def _times(u: np.ndarray, v: np.ndarray, out: np.ndarray) -> np.ndarray:
    """Product u v of jets (c, m)."""
    if len(u) > 1:
        out[:] = product(u, v, _VARIABLES[len(u)])
        return out
    np.multiply(u[:1], v[:1], out=out[:1])
    return out
