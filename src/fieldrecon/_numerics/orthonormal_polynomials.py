"""Polynomials of several variables that are orthonormal on given sites.

The monomials of degree 40 on an interval are linearly dependent up to rounding; polynomials that
are orthonormal on the sites never are. Those of degree k + 1 are made from the products x_j q of
the variables with those of degree k, as an Arnoldi iteration makes a Krylov basis from products
with a matrix (Brubeck, Nakatsukasa and Trefethen, Vandermonde with Arnoldi, 2021).
"""

from __future__ import annotations

import numpy as np

from fieldrecon.polynomials import EPS, dimension, exponents

VANISHING = 1e-6
"""Size at the sites, relative to what it was made from, from which on a polynomial is not zero."""
_SAMPLED = 500  # sites at which gradients are looked at for their size


class OrthonormalPolynomials:
    """A basis of the polynomials of total degree <= `degree`, orthonormal on the sites.

    Degree k + 1 is U in the singular value decomposition X - B H = U S V^T of the products X of
    degree k with the variables, less their projections on the basis B of degree k. So it is
    (X - B H) V S^-1, at the sites and at any other points.

    Parameters
    ----------
    y : (n, d) ndarray
        Sites, in a frame in which they have size one.
    degree : int
        0 or more.
    rounding : (d,) ndarray
        Rounding of the coordinates. A polynomial that it could make vanish on the sites is not in
        the basis.

    Attributes
    ----------
    at_sites : (n, r) ndarray
        Values at the sites, with orthonormal columns; r is less than the dimension of the
        polynomials if the sites do not determine them.
    last_degree : int
        The highest degree of which a polynomial is in the basis.
    is_steep : bool
        Whether it has all polynomials up to this degree and ends although a further one does not
        vanish on the sites: between them all rise so steeply that the rounding of the coordinates
        decides their values.
    """

    def __init__(self, y: np.ndarray, degree: int, rounding: np.ndarray) -> None:
        n, d = y.shape
        self.degree, self._sites = degree, n
        self.last_degree, self.is_steep = degree, False
        self._blocks: list[tuple[np.ndarray, np.ndarray]] = []
        b, last = np.full((n, 1), n**-0.5), 1
        some = slice(None, None, max(1, n // _SAMPLED))
        g = np.zeros((d, len(y[some]), 1))
        for k in range(1, degree + 1):
            x = _products(y, b[:, -last:])
            size = np.linalg.norm(x, axis=0)
            size = np.where(size > 0, size, 1.0)
            rest, h = x / size, np.zeros((b.shape[1], x.shape[1]))
            for _ in range(2):  # the second time for what rounding left
                part = b.T @ rest
                rest, h = rest - b @ part, h + part
            u, s, vt = _svd(rest)
            slopes = _gradients_of_products(y[some], b[some, -last:], g[..., -last:]) / size - g @ h
            spread = np.sqrt(n / slopes.shape[1]) * rounding @ np.linalg.norm(slopes, axis=(1, 2))
            kept = int((s > 4 * (EPS * np.sqrt(n * x.shape[1]) + spread)).sum())
            last = min(kept, dimension(d, k) - dimension(d, k - 1))
            v = vt[:last].T / s[:last]
            # What is left of B in X - B H is divided by S, which may be small.
            part = b.T @ u[:, :last]
            self._blocks.append((v / size[:, None], h @ v + part))
            g = np.concatenate([g, slopes @ v - g @ part], axis=2)
            b = np.hstack([b, u[:, :last] - b @ part])
            if not last:
                self.last_degree = k - 1
                complete = b.shape[1] == dimension(d, k - 1)
                self.is_steep = complete and float(s[0]) > VANISHING
                break
        self.at_sites = b

    def values(self, y: np.ndarray) -> np.ndarray:
        """Values (m, r) at points (m, d)."""
        b, last = np.full((len(y), 1), self._sites**-0.5), 1
        for v, hv in self._blocks:
            b, last = np.hstack([b, _products(y, b[:, -last:]) @ v - b @ hv]), v.shape[1]
        return b

    def gradients(self, y: np.ndarray) -> np.ndarray:
        """Gradients (d, m, r) at points (m, d)."""
        b, g, start = self.values(y), np.zeros((y.shape[1], len(y), 1)), 0
        for v, hv in self._blocks:
            end = g.shape[2]
            slopes = _gradients_of_products(y, b[:, start:end], g[..., start:])
            g, start = np.concatenate([g, slopes @ v - g @ hv], axis=2), end
        return g

    def hessians(self, y: np.ndarray) -> np.ndarray:
        """Second derivatives (d, d, m, r) at points (m, d)."""
        d, m = y.shape[1], len(y)
        g, start = self.gradients(y), 0
        w = np.zeros((d, d, m, 1))
        for v, hv in self._blocks:
            end = w.shape[3]
            bends = _hessians_of_products(y, g[..., start:end], w[..., start:])
            w, start = np.concatenate([w, bends @ v - w @ hv], axis=3), end
        return w

    def in_monomials(self, d: int) -> np.ndarray:
        """Coefficients (q, r) of the basis in the monomials of the coordinates y."""
        alpha = exponents(d, self.degree)
        index = {tuple(a): i for i, a in enumerate(alpha.tolist())}
        t, last = np.zeros((len(alpha), 1)), 1
        t[0] = self._sites**-0.5
        for k, (v, hv) in enumerate(self._blocks):
            lower = dimension(d, k)
            x = np.zeros((len(alpha), d, last))
            for axis in range(d):
                rows = [
                    index[tuple(a)] for a in (alpha[:lower] + np.eye(d, dtype=int)[axis]).tolist()
                ]
                x[rows, axis] = t[:lower, -last:]
            t, last = np.hstack([t, x.reshape(len(alpha), -1) @ v - t @ hv]), v.shape[1]
        return t


def _products(y: np.ndarray, q: np.ndarray) -> np.ndarray:
    """Products (m, d r) of the variables with functions q (m, r)."""
    return (y[:, :, None] * q[:, None, :]).reshape(len(y), y.shape[1] * q.shape[1])


def _gradients_of_products(y: np.ndarray, q: np.ndarray, g: np.ndarray) -> np.ndarray:
    """Gradients (d, m, d r) of the products, by the values q (m, r) and gradients g (d, m, r)."""
    d, m, r = g.shape
    slopes = y[:, :, None] * g[:, :, None, :]  # (axis, point, variable, function)
    slopes[range(d), :, range(d)] += q
    return slopes.reshape(d, m, d * r)


def _hessians_of_products(y: np.ndarray, g: np.ndarray, w: np.ndarray) -> np.ndarray:
    """Second derivatives (d, d, m, d r) of the products, by those w of the functions and g."""
    d, m, r = g.shape
    bends = y[:, :, None] * w[:, :, :, None, :]  # (axis, axis, point, variable, function)
    for k in range(d):
        bends[k, :, :, k] += g
        bends[:, k, :, k] += g
    return bends.reshape(d, d, m, d * r)


def _svd(a: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Thin singular value decomposition of a matrix with many rows, by that of its factor R."""
    q, r = np.linalg.qr(a)
    u, s, vt = np.linalg.svd(r, full_matrices=False)
    return q @ u, s, vt
