"""Many small weighted least-squares problems at once.

For each of m queries, C with c = C f minimizes sum_i w_i^2 (b_i^T c - f_i)^2. Where the matrix is
well conditioned, the normal equations are solved by elimination, batched over the queries. They
square the condition number. One step of iterative refinement, C + (I - C B) C, mends this: the
errors are a few times those of QR, at a fraction of its cost. It needs all coefficients. If only
the first ones are wanted, as for values, it is taken for the few queries at which the determinant
is small.

Products of C with B lose as many digits again where entries of C are large. There the residuals,
on which derivatives by the query depend, are projections on the complement of the basis.

The remaining problems take one of two stabler ways. If all coefficients must be determined, it is
Householder QR with rows and columns pivoted, which is stable however much the weights of the rows
differ (Cox and Higham 1998). If the first coefficients suffice, they need only be *estimable*: no
null vector of the matrix has a part in them, so they are the same in every solution. The solution
of least norm gives them, by the singular value decomposition.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from fieldrecon._core.blas_threads import one_blas_thread
from fieldrecon.polynomials import EPS

LARGEST_WEIGHT = 1e8
"""Weights beyond this turn the rounding of the data into errors of half the digits."""

# Pivots of the equilibrated normal matrix below this send a query to QR: elimination loses three
# digits of sixteen to one such pivot, and more where several are small in a row. A hundredth would
# save most of those, and takes a fifth more time at degree 2.
_SAFE_PIVOT = 1e-3
# First coefficients are refined where the determinant of this matrix is smaller: at one query in
# fourteen or fewer. Of 20 000 others the worst loses 2e-13; without refinement it loses 2e-12.
_SAFE_DETERMINANT = 1e-2
# Squares of entries below this lose digits, or vanish.
_SMALLEST_SQUARE = 1e-6
# C b may differ from the unit matrix by this after elimination before a stabler way is taken.
_ROUNDING = 1e-13
# Residuals are projections where products with C would magnify rounding by more than this.
_AMPLIFIED = 100.0


class Undetermined(Exception):
    """The sites of query `query` of the batch leave the coefficients undetermined: rank `rank`.

    If the rank is full, they are lost in rounding: absolute weights in the first sum to `size`.
    """

    def __init__(self, query: int, rank: int, size: float = 0.0) -> None:
        super().__init__(query, rank, size)
        self.query, self.rank, self.size = query, rank, size


@one_blas_thread()
def coefficient_weights(
    b: np.ndarray,
    w: np.ndarray,
    rows: int,
    tolerance: np.ndarray,
    largest: float = np.inf,
) -> np.ndarray:
    """First rows of C: the weights of the data in the first coefficients.

    Parameters
    ----------
    b : (m, k, q) ndarray
        Basis at the sites of each query, in its local frame.
    w : (m, k) ndarray
        Weights, the largest of each query one; a site of weight zero does not count.
    rows : int
        How many coefficients are wanted.
    tolerance : (m,) ndarray
        Smallest singular value, relative to the largest, of a basis that determines them.
    largest : float
        Largest sum of the absolute weights in the first coefficient.

    Returns
    -------
    (m, rows, k) ndarray
        C, so that C f are the coefficients.

    Raises
    ------
    Undetermined
        If the sites with positive weight leave a polynomial undetermined, or the weights in the
        first coefficient are too large: the sites whose weight is not negligible leave it so.
    """
    weighted = (w * w)[..., None] * b
    if rows == b.shape[2]:
        c, safe = _refined(b, weighted)
    else:
        solution, safe, determinant = by_elimination(weighted.mT @ b, rows)
        c = (weighted @ solution).mT
        inexact = safe & (determinant < _SAFE_DETERMINANT)
        c[inexact] = _refined(b[inexact], weighted[inexact])[0][:, :rows]
    if not safe.all():
        risky = ~safe
        _require_full_rank(b, w, tolerance, np.flatnonzero(risky))
        c[risky] = _by_qr(b[risky], w[risky])[:, :rows]
        size = np.abs(c[risky, 0]).sum(axis=1)
        if not size.max() <= largest:
            worst = int(np.argmax(size))
            query = int(np.flatnonzero(risky)[worst])
            raise Undetermined(query, b.shape[2], float(size[worst]))
    return c


def _refined(b: np.ndarray, weighted: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """C (m, q, k) by elimination and one step of iterative refinement, and where to trust it."""
    solution, safe, _ = by_elimination(weighted.mT @ b, b.shape[2])
    c = (weighted @ solution).mT
    return c + (np.eye(b.shape[2]) - c @ b) @ c, safe


def estimable_weights(b: np.ndarray, w: np.ndarray, rows: int) -> np.ndarray:
    """First rows of C where they are estimable: the data may leave other coefficients undetermined.

    Parameters
    ----------
    b : (m, k, q) ndarray
        Rows of each fit, of size one: its variables in a local frame.
    w : (m, k) ndarray
        Weights, the largest of each fit one; a row of weight zero does not count.
    rows : int
        How many coefficients are wanted.

    Returns
    -------
    (m, rows, k) ndarray
        C, so that C f are the first coefficients; nan where they are not estimable.
    """
    weighted = (w * w)[..., None] * b
    solution, safe, _ = by_elimination(weighted.mT @ b, rows)
    c = (weighted @ solution).mT
    # pivots that are small one after the other lose more than each; C b shows how much
    lost = c @ b - np.eye(rows, b.shape[2])
    risky = np.flatnonzero(~safe | (np.einsum("mrq,mrq->m", lost, lost) > _ROUNDING**2))
    if len(risky):
        c[risky] = _by_singular_values(np.where(w[risky, :, None] > 0, b[risky], 0), w[risky], rows)
    return c


def residuals(c: np.ndarray, b: np.ndarray, w: np.ndarray, data: np.ndarray) -> np.ndarray:
    """Residuals f - B C f (m, k, v) of the data (m, k, v), for C of all coefficients (m, q, k).

    Rounding spoils the residual of the site of largest weight, and its weight magnifies this. Since
    the polynomials contain the constants, sum_i w_i^2 r_i = 0 gives it from the other residuals.
    """
    r = data - b @ (c @ data)
    amplified = _largest_entry(c) > _AMPLIFIED
    if amplified.any():
        length = w[amplified, :, None]
        scaled = _off_the_basis(length * data[amplified], b[amplified], w[amplified])
        r[amplified] = np.divide(scaled, length, out=r[amplified], where=length > 0)
    heaviest = _heaviest(w)
    np.put_along_axis(r, heaviest, 0.0, axis=1)
    rest = (w[..., None] ** 2 * r).sum(axis=1, keepdims=True)
    np.put_along_axis(r, heaviest, -rest, axis=1)
    return r


def weights_of_changing_weights(
    c: np.ndarray, b: np.ndarray, w: np.ndarray, log_gradient: np.ndarray
) -> np.ndarray:
    """Part (m, k, d) of the weights in the gradient of c_0 that is due to the change of the w_i.

    It is sum_i a_i (grad w_i^2 / w_i^2) r_i, with r = f - B C f and a the first row of C.

    Parameters
    ----------
    c : (m, q, k) ndarray
        Weights of the data in all coefficients.
    b : (m, k, q) ndarray
        Basis at the sites.
    w : (m, k) ndarray
        Weights, the largest of each query one.
    log_gradient : (m, k, d) ndarray
        Gradients of log w_i^2 by the query.
    """
    u = c[:, 0, :, None] * log_gradient
    # the residual of the heaviest site from those of the others, as in `residuals`
    u = u - w[..., None] ** 2 * np.take_along_axis(u, _heaviest(w), axis=1)
    result = u - c.mT @ (b.mT @ u)
    top = _largest_entry(c)
    size, of_result = (np.abs(part).sum(axis=(1, 2)) for part in (u, result))
    amplified = top * size > _AMPLIFIED * (top + of_result)  # the gradient also has c_1, ..., c_d
    if amplified.any():
        length = w[amplified, :, None]
        scaled = np.divide(u[amplified], length, out=np.zeros_like(u[amplified]), where=length > 0)
        result[amplified] = length * _off_the_basis(scaled, b[amplified], w[amplified])
    return result


def _largest_entry(c: np.ndarray) -> np.ndarray:
    return np.abs(c).max(axis=(1, 2), initial=0.0)


def _off_the_basis(z: np.ndarray, b: np.ndarray, w: np.ndarray) -> np.ndarray:
    """(I - Q Q^T) z for W B = Q R: the part of z (m, k, v) that no coefficients give.

    With W this is I - B C = W^-1 (I - Q Q^T) W, without the large numbers of C. A second
    projection takes out the rounding of the first.
    """
    q, r, *_ = _pivoted_qr(b, w)
    q = q * (np.diagonal(r, axis1=1, axis2=2) != 0)[:, None, :]  # redundant columns span nothing
    z = z - q @ (q.mT @ z)
    return z - q @ (q.mT @ z)


def _heaviest(w: np.ndarray) -> np.ndarray:
    return np.argmax(w, axis=1)[:, None, None]


def by_elimination(g: np.ndarray, rows: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Columns (m, q, rows) of the inverse of the normal matrices, and where they can be trusted.

    The determinants (m,) of the equilibrated matrices come third: products of their pivots.
    """
    m, q, _ = g.shape
    diagonal = np.einsum("mii->mi", g)
    size = np.sqrt(np.where(diagonal > 0, diagonal, 1.0))
    # each step runs over contiguous memory: the queries are last, or the columns if there are more
    t = np.zeros((q, q + rows, m)) if m > q else np.zeros((m, q, q + rows)).transpose(1, 2, 0)
    t[:, :q] = (g / (size[:, :, None] * size[:, None, :])).transpose(1, 2, 0)
    t[range(rows), range(q, q + rows)] = 1.0
    least, determinant = np.ones(m), np.ones(m)
    for j in range(q):
        pivot = t[j, j].copy()
        least = np.fmin(least, pivot)
        determinant *= pivot
        t[j, j:] /= np.where(pivot > _SAFE_PIVOT, pivot, 1.0)
        for others in (t[:j], t[j + 1 :]):
            others[:, j + 1 :] -= others[:, j, None] * t[j, j + 1 :]
    safe = (least > _SAFE_PIVOT) & (diagonal > _SMALLEST_SQUARE).all(axis=1)
    scaled = t[:, q:].transpose(2, 0, 1) / size[:, :, None]
    return scaled / size[:, None, :rows], safe, determinant


def _require_full_rank(
    b: np.ndarray, w: np.ndarray, tolerance: np.ndarray, queries: np.ndarray
) -> None:
    # Whether a polynomial can vanish on the sites is a matter of the sites, not of the weights:
    # with those, a query between two close sites would look deficient.
    counted = np.where(w[queries, :, None] > 0, b[queries], 0.0)
    norms = np.linalg.norm(counted, axis=1, keepdims=True)
    sigma = np.linalg.svd(counted / np.where(norms > 0, norms, 1.0), compute_uv=False)
    rank = (sigma > tolerance[queries, None] * sigma[:, :1]).sum(axis=1)
    deficient = np.flatnonzero(rank < b.shape[2])
    if len(deficient):
        raise Undetermined(int(queries[deficient[0]]), int(rank[deficient[0]]))


class _PivotedQR(NamedTuple):
    """W B = Q R with the columns of B scaled and sorted, and the rows of Q in their order."""

    q: np.ndarray  # (m, k, q)
    r: np.ndarray  # (m, q, q)
    order: np.ndarray  # (m, q), of the columns
    scale: np.ndarray  # (m, q), of the columns as they are in B


def _pivoted_qr(b: np.ndarray, w: np.ndarray) -> _PivotedQR:
    """Householder QR of the weighted rows, rows and columns pivoted.

    Columns are scaled as they are without weights: the rounding in a row is as large as the row,
    and in a row of 1e-16 times the weight of another it has to stay that small.
    """
    m, k, q = b.shape
    scale = _power_of_two(np.where(w[..., None] > 0, np.abs(b), 0.0).max(axis=1))
    r = w[..., None] * (b / scale[:, None, :])
    rounding = max(k, 8) * EPS * np.abs(r).max(axis=2)
    rows, columns = np.tile(np.arange(k), (m, 1)), np.tile(np.arange(q), (m, 1))
    v = np.zeros((m, k, q))  # the reflectors, I - v v^T
    for j in range(q):
        largest = j + np.argmax(_norms(r[:, j:, j:]), axis=1)
        _swap(j, largest, r.swapaxes(1, 2), columns)
        heaviest = j + np.argmax(np.abs(r[:, j:, j]), axis=1)
        _swap(j, heaviest, r, v, rows, rounding)
        v[:, j:, j] = _reflector(r[:, j:, j])
        _reflect(r[:, j:, j:], v[:, j:, j])
        # The remainder of a redundant row is rounding, and may outweigh all lighter rows.
        rest = r[:, j + 1 :, j + 1 :]
        rest[np.abs(rest) < rounding[:, j + 1 :, None]] = 0.0
    thin_q = np.zeros((m, k, q))
    thin_q[:, range(q), range(q)] = 1.0
    for j in reversed(range(q)):
        _reflect(thin_q[:, j:], v[:, j:, j])
    in_order = np.empty_like(thin_q)
    np.put_along_axis(in_order, rows[..., None].repeat(q, axis=2), thin_q, axis=1)
    return _PivotedQR(in_order, np.triu(r[:, :q]), columns, scale)


def _by_qr(b: np.ndarray, w: np.ndarray) -> np.ndarray:
    """C (m, q, k) = P R^-1 Q^T W, by `_pivoted_qr`."""
    q, r, order, scale = _pivoted_qr(b, w)
    c = np.empty_like(q.mT)
    np.put_along_axis(c, order[..., None], np.linalg.solve(r, q.mT), axis=1)
    return c * w[:, None, :] / scale[:, :, None]


def _swap(j: int, best: np.ndarray, *arrays: np.ndarray) -> None:
    """Exchange entry j of axis 1 with entry best (m,), in place."""
    each = np.arange(len(best))
    for array in arrays:
        array[each, best], array[:, j] = array[:, j].copy(), array[each, best]


def _reflect(x: np.ndarray, v: np.ndarray) -> None:
    """Apply I - v v^T to the columns of x, in place."""
    x -= v[..., None] * (v[:, None, :] @ x)


def _reflector(x: np.ndarray) -> np.ndarray:
    """Vectors v with (I - v v^T) x = -sign(x_0) |x| e_0, for each row of x."""
    v = x.copy()
    v[:, 0] += np.copysign(_norms(x), x[:, 0])
    length = _norms(v)
    return np.sqrt(2.0) * v / np.where(length > 0, length, 1.0)[:, None]


def _power_of_two(size: np.ndarray) -> np.ndarray:
    """A power of two near to each size, so that scaling by it rounds nothing; one for zero."""
    return np.exp2(np.round(np.log2(np.where(size > 0, size, 1.0))))


def _norms(a: np.ndarray) -> np.ndarray:
    """Euclidean norms along axis 1, without underflow of the squares of tiny remainders."""
    top = np.abs(a).max(axis=1)
    return top * np.linalg.norm(a / np.expand_dims(np.where(top > 0, top, 1.0), 1), axis=1)


def _by_singular_values(b: np.ndarray, w: np.ndarray, rows: int) -> np.ndarray:
    """First rows of C by B = U S V^T: with c = V S^-1 y, the matrix U of y has full rank.

    Which singular values vanish is a matter of the sites, not of the weights.
    """
    m, k, q = b.shape
    b = np.concatenate([b, np.zeros((m, max(q - k, 0), q))], axis=1)
    norms = np.linalg.norm(b, axis=1)
    norms = np.where(norms > 0, norms, 1.0)
    u, s, vt = np.linalg.svd(b / norms[:, None, :], full_matrices=False)
    tolerance = 4 * EPS * max(k, q)
    null = s <= tolerance * s[:, :1]
    leak = np.linalg.norm(np.where(null[..., None], vt[..., :rows], 0.0), axis=1)
    estimable = (leak <= LARGEST_WEIGHT * tolerance).all(axis=1)
    c = np.full((m, rows, k), np.nan)
    rank = (~null).sum(axis=1)
    for r in np.unique(rank[estimable]):
        of = np.flatnonzero(estimable & (rank == r))
        y = coefficient_weights(u[of, :k, :r], w[of], r, np.zeros(len(of)))
        whole = (vt[of, :r].mT / s[of, None, :r]) @ y / norms[of, :, None]
        first = whole[:, :rows]
        # one step of refinement: weights that differ much cost digits of the other coefficients
        c[of] = first + (np.eye(rows, q) - first @ b[of, :k]) @ whole
    return c
