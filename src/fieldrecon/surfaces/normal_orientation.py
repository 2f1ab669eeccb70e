"""Consistent orientation of the normals of a cloud along a minimum spanning forest."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from scipy import sparse
from scipy.sparse import csgraph

from fieldrecon._core import validation as valid
from fieldrecon._core.chunks import chunked
from fieldrecon.polynomials import Frame
from fieldrecon.surfaces.normals import ROWS, as_cloud, nearest, reach

_NEIGHBORS = {2: 5, 3: 9}  # to which a point is joined, by dimension
_MAX_SWEEPS = 20  # of votes; signs that still change are left as they are


def orient_normals(
    points: ArrayLike,
    normals: ArrayLike,
    neighbors: int | ArrayLike | None = None,
    noise: float = 0.15,
) -> np.ndarray:
    """Choose the signs of normals such that neighbours agree, and normals point outward.

    The Riemannian graph joins points to their neighbours. Across an edge in the direction e the
    normal n_i is expected to be mirrored, n_i - 2 (e . n_i) e, as it is on spheres, planes and
    folds, convex or concave, and between the two sides of a thin sheet. The edge has the cost

        1 - |expected . n_j| + noise |e . n_i| |e . n_j|.

    Signs are propagated along the minimum spanning forest. Then signs that most of the neighbours
    contradict are reversed. Each connected part gets the sign with which it encloses a positive
    volume, sum_i a_i n_i . (p_i - c) > 0, with the centre c of the part and areas a_i by the
    distances of neighbours. A part without volume, such as a plane, gets the sign that makes the
    largest component of the sum of its normals positive. For curves in the plane the volume is the
    enclosed area.

    Parameters
    ----------
    points : (n, d) array_like
        Points on a surface (d = 3) or on a plane curve (d = 2).
    normals : (n, d) array_like
        Unit normals of any sign, such as those of `estimate_normals`.
    neighbors : int or (n, k) array_like of int, optional
        Number of nearest points to which each is joined, itself included, 3 or more; or their
        indices, such as `PointNormals.neighbors`, which saves a search. By default 9 on a surface
        and 5 on a curve.
    noise : float
        Penalty of edges across the surface, zero or positive. Both noise and a sheet thinner than
        the spacing of the points make edges steep, and cannot be distinguished. Zero is best for
        exact points of thin sheets, one for thick bodies with much noise.

    Returns
    -------
    (n, d) ndarray
        The normals, each with its sign or the opposite one.

    Raises
    ------
    ValueError
        If an argument has the wrong form.

    References
    ----------
    Wendland (2005), section 1.1, whose sum of signs should be made large and not small; Hoppe et
    al. (1992), who expect n_j to be n_i; Koenig and Gumhold (2009), who mirror.

    Examples
    --------
    >>> from fieldrecon.surfaces.normals import estimate_normals
    >>> x = np.random.default_rng(1).standard_normal((500, 3))
    >>> x /= np.linalg.norm(x, axis=1, keepdims=True)
    >>> estimate = estimate_normals(x)
    >>> outward = orient_normals(x, estimate.vectors, estimate.neighbors[:, :9])
    >>> bool((np.sum(outward * x, axis=1) > 0.9).all())
    True
    """
    cloud = as_cloud(points, (2, 3))
    p = Frame.around(cloud).local(cloud)
    n = valid.as_points(normals, "normals")
    if n.shape != p.shape:
        raise ValueError(f"normals must have the shape of the points, {p.shape}; got {n.shape}")
    noise = valid.as_length(noise, "noise", zero_allowed=True)
    index = _as_neighbors(_NEIGHBORS[p.shape[1]] if neighbors is None else neighbors, p)
    agreement, steepness = _edges(p.T, n.T, index)
    # scipy.sparse drops edges of cost zero, hence the shift
    costs = 2 - np.abs(agreement) + noise * steepness
    sign, part = _propagate(_minimum_spanning_forest(costs, index), p, n)
    _vote(sign, agreement * np.maximum(1 - 2 * steepness, 0), index)
    oriented = sign[:, None] * n
    areas = reach(p, index) ** (p.shape[1] - 1)
    return oriented * _outward(p, oriented, areas, part)[part, None]


def _as_neighbors(neighbors: ArrayLike, p: np.ndarray) -> np.ndarray:
    """Validate indices (n, k), or find the nearest points."""
    wanted = f"neighbors must be a number, or indices of the shape ({len(p)}, k)"
    neighbors = valid.unmasked(neighbors, "neighbors")
    try:
        index = np.asarray(neighbors)
    except ValueError:
        raise ValueError(f"{wanted}; the rows differ in length") from None
    if index.ndim == 0:
        return nearest(p, index.item())
    if index.ndim != 2 or len(index) != len(p) or index.dtype.kind not in "iu":
        raise ValueError(f"{wanted}; got {index.dtype} of the shape {index.shape}")
    if not ((index >= 0) & (index < len(p))).all():
        raise ValueError(f"neighbors must be indices of the {len(p)} points")
    return index


def _edges(p: np.ndarray, n: np.ndarray, index: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Agreement and steepness (n, k) of edges; zero for a point and itself."""
    p, n = np.ascontiguousarray(p), np.ascontiguousarray(n)
    agreement, steepness = np.empty(index.shape), np.empty(index.shape)

    def work(i: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        j = np.ascontiguousarray(index[i].T)
        offset = np.take(p, j, axis=1) - p[:, None, i]
        agreed, steep = _agreement(offset, n[:, None, i], np.take(n, j, axis=1))
        return np.where(j == i, 0.0, agreed).T, steep.T

    for rows, (agreed, steep) in chunked(work, np.arange(len(index)), ROWS):
        agreement[rows], steepness[rows] = agreed, steep
    return agreement, steepness


def _agreement(
    offset: np.ndarray, n: np.ndarray, other: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Agreement of n_j with the mirrored n_i, and the steepness |e . n_i| |e . n_j|."""

    def dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
        total: np.ndarray = a[0] * b[0]
        for x, y in zip(a[1:], b[1:], strict=True):
            total = total + x * y
        return total

    squared = dot(offset, offset)
    steep = dot(offset, n) * dot(offset, other)
    steep /= np.where(squared > 0, squared, 1.0)  # zero between coincident points
    return dot(n, other) - 2 * steep, np.abs(steep)


def _minimum_spanning_forest(costs: np.ndarray, index: np.ndarray) -> sparse.csr_array:
    """The minimum spanning forest of the edges.

    The first forest uses only the cheapest edges, four for each point. Most other edges lie within
    one of its trees, and are never sorted (Osipov, Sanders and Singler 2009).
    """
    count = min(4 * len(index), costs.size - 1)
    cheap = costs <= np.partition(costs, count, axis=None)[count]
    forest = csgraph.minimum_spanning_tree(_graph(costs, index, cheap))
    _, tree = csgraph.connected_components(forest, directed=False)
    between = tree[index] != tree[:, None]
    return csgraph.minimum_spanning_tree(forest + _graph(costs, index, between))


def _graph(values: np.ndarray, index: np.ndarray, chosen: np.ndarray) -> sparse.csr_array:
    """The graph of the chosen edges of each point with its neighbours, with values (n, k)."""
    ends = np.append(0, np.cumsum(np.count_nonzero(chosen, axis=1)))
    columns, ends = index[chosen].astype(np.int32), ends.astype(np.int32)  # csgraph of SciPy 1.15
    return sparse.csr_array((values[chosen], columns, ends), shape=(len(index),) * 2)


def _propagate(
    forest: sparse.csr_array, p: np.ndarray, n: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Signs (n,) relative to the root of each tree, and the tree of each point."""
    count, part = csgraph.connected_components(forest, directed=False)
    roots, top = np.unique(part, return_index=True)[1], len(p)
    # one more vertex, joined to the roots, makes the forest a tree
    edges = (
        np.append(forest.data, np.ones(count)),
        np.append(forest.indices, roots),
        np.append(forest.indptr, forest.nnz + count),
    )
    tree = sparse.csr_array(edges, shape=(top + 1, top + 1))
    parent = csgraph.breadth_first_order(tree, top, directed=False)[1][:top]
    parent[roots] = roots
    agreement, _ = _agreement((p[parent] - p).T, n.T, n[parent].T)
    sign = np.where(agreement < 0, -1.0, 1.0)
    # pointer jumping: the number of steps is the logarithm of the depth
    while (parent[parent] != parent).any():
        sign, parent = sign * sign[parent], parent[parent]
    return sign, part  # the parents are roots


def _vote(sign: np.ndarray, votes: np.ndarray, index: np.ndarray) -> None:
    """Reverse, in place, the signs that most neighbours contradict."""
    graph = _graph(votes, index, votes != 0)
    for _ in range(_MAX_SWEEPS):
        against = sign * (graph @ sign + graph.T @ sign) < 0
        if not against.any():
            return
        sign[against] *= -1


def _outward(p: np.ndarray, n: np.ndarray, areas: np.ndarray, part: np.ndarray) -> np.ndarray:
    """The sign of each part that makes its normals point outward."""
    count = int(part.max()) + 1

    def total(values: np.ndarray) -> np.ndarray:
        return np.bincount(part, values, minlength=count)

    weight = np.maximum(total(areas), np.finfo(float).tiny)
    center = np.stack([total(areas * x) / weight for x in p.T], axis=1)
    offset = p - center[part]
    volume = total(areas * np.einsum("ij,ij->i", offset, n))
    size = total(areas * np.linalg.norm(offset, axis=1))
    sums = np.stack([total(areas * x) for x in n.T], axis=1)
    largest = sums[np.arange(count), np.abs(sums).argmax(axis=1)]
    return np.where(np.where(np.abs(volume) > 1e-3 * size, volume, largest) < 0, -1.0, 1.0)
