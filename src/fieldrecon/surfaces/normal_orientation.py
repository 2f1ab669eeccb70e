"""Orientation of the normals of a cloud: signs that neighbours agree on, and an outside."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from scipy import sparse
from scipy.sparse import csgraph

from fieldrecon._core import validation as valid
from fieldrecon._core.chunks import chunked
from fieldrecon.polynomials import Frame
from fieldrecon.surfaces.normals import ROWS, as_cloud, nearest, reach

_SWEEPS = 20  # after so many votes what still wavers is left as it is


def orient_normals(
    points: ArrayLike, normals: ArrayLike, neighbors: int | np.ndarray = 9, noise: float = 0.15
) -> np.ndarray:
    """Normals turned round where needed, so that neighbours agree and they point outward.

    Points are joined to their neighbours. Across a joint in the direction e the normal n_i is
    expected to be mirrored, n_i - 2 (e . n_i) e, as it is on spheres, planes and folds, convex or
    concave, and between the two sides of a thin sheet. The joint costs

        1 - |expected . n_j| + noise |e . n_i| |e . n_j|.

    Signs spread along the minimum spanning forest; then points that most of their neighbours
    contradict are turned. Each connected part gets the sign with which it encloses a positive
    volume, sum_i a_i n_i . (p_i - c) > 0, with the centre c of the part and areas a_i by the
    distances of neighbours; a part that encloses none, such as a plane, the sign that makes the
    largest component of the sum of its normals positive.

    Parameters
    ----------
    points : (n, 3) array_like
        Points on a surface.
    normals : (n, 3) array_like
        Unit normals of any sign, such as those of `estimate_normals`.
    neighbors : int or (n, k) ndarray of int
        How many nearest points are joined to each, itself counted among them, 3 or more; or their
        indices, those of `PointNormals.neighbors` to search only once.
    noise : float
        Distrust of joints across the surface, zero or positive. Noise makes joints steep, and so
        does a sheet thinner than the distance of the points: no rule tells them apart. Zero is
        best for exact points of thin sheets, one for thick bodies with much noise.

    Returns
    -------
    (n, 3) ndarray
        The normals, each as it was or with the other sign.

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
    cloud = as_cloud(points)
    p = Frame.around(cloud).local(cloud)
    n = valid.as_queries(normals, 3)
    if n.shape != p.shape:
        raise ValueError(f"normals must have the shape of the points, {p.shape}; got {n.shape}")
    noise = valid.as_length(noise, "noise", zero_allowed=True)
    index = _as_neighbors(neighbors, p)
    agreement, steepness = _joints(p.T, n.T, index)
    # a joint of cost zero would be none to scipy.sparse, hence the shift
    costs = 2 - np.abs(agreement) + noise * steepness
    sign, part = _spread(_minimum_spanning_forest(costs, index), p, n)
    _vote(sign, agreement * np.maximum(1 - 2 * steepness, 0), index)
    oriented = sign[:, None] * n
    return oriented * _outward(p, oriented, reach(p, index) ** 2, part)[part, None]


def _as_neighbors(neighbors: int | np.ndarray, p: np.ndarray) -> np.ndarray:
    """Indices (n, k)."""
    if not isinstance(neighbors, np.ndarray):
        return nearest(p, neighbors)
    if neighbors.ndim != 2 or len(neighbors) != len(p) or neighbors.dtype.kind not in "iu":
        raise ValueError(
            f"neighbors must be a number, or indices of the shape ({len(p)}, k); got "
            f"{neighbors.dtype} of the shape {neighbors.shape}"
        )
    if not ((neighbors >= 0) & (neighbors < len(p))).all():
        raise ValueError(f"neighbors must be indices of the {len(p)} points")
    return neighbors


def _joints(p: np.ndarray, n: np.ndarray, index: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Agreement and steepness (n, k) of joints; of a point with itself none."""
    p, n = np.ascontiguousarray(p), np.ascontiguousarray(n)
    agreement, steepness = np.empty(index.shape), np.empty(index.shape)

    def work(i: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        j = np.ascontiguousarray(index[i].T)
        offset = np.take(p, j, axis=1) - p[:, None, i]
        agreed, steep = _agreement(offset, n[:, None, i], np.take(n, j, axis=1))
        return np.where(j == i, 0.0, agreed).T, steep.T

    for some, (agreed, steep) in chunked(work, np.arange(len(index)), ROWS):
        agreement[some], steepness[some] = agreed, steep
    return agreement, steepness


def _agreement(
    offset: np.ndarray, n: np.ndarray, other: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Of n_j, at an offset (3, ...), with n_i mirrored across the middle; |e . n_i| |e . n_j|."""

    def dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
        return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]

    squared = dot(offset, offset)
    steep = dot(offset, n) * dot(offset, other)
    steep /= np.where(squared > 0, squared, 1.0)  # none between points that coincide
    return dot(n, other) - 2 * steep, np.abs(steep)


def _minimum_spanning_forest(costs: np.ndarray, index: np.ndarray) -> sparse.csr_array:
    """The cheapest joints that connect what can be connected.

    First of the cheapest joints, four for each point: most of the others lie within a tree of
    these, and are never sorted (Osipov, Sanders and Singler 2009).
    """
    count = min(4 * len(index), costs.size - 1)
    cheap = costs <= np.partition(costs, count, axis=None)[count]
    forest = csgraph.minimum_spanning_tree(_graph(costs, index, cheap))
    _, tree = csgraph.connected_components(forest, directed=False)
    between = tree[index] != tree[:, None]
    return csgraph.minimum_spanning_tree(forest + _graph(costs, index, between))


def _graph(values: np.ndarray, index: np.ndarray, chosen: np.ndarray) -> sparse.csr_array:
    """Values (n, k) of the chosen joints of each point with its neighbours."""
    ends = np.append(0, np.cumsum(np.count_nonzero(chosen, axis=1)))
    columns, ends = index[chosen].astype(np.int32), ends.astype(np.int32)  # csgraph of SciPy 1.15
    return sparse.csr_array((values[chosen], columns, ends), shape=(len(index),) * 2)


def _spread(
    forest: sparse.csr_array, p: np.ndarray, n: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Signs (n,) relative to the root of each tree, and the tree of each point."""
    count, part = csgraph.connected_components(forest, directed=False)
    roots, top = np.unique(part, return_index=True)[1], len(p)
    # one more vertex, joined to the roots, makes one tree of the forest
    joints = (
        np.append(forest.data, np.ones(count)),
        np.append(forest.indices, roots),
        np.append(forest.indptr, forest.nnz + count),
    )
    tree = sparse.csr_array(joints, shape=(top + 1, top + 1))
    parent = csgraph.breadth_first_order(tree, top, directed=False)[1][:top]
    parent[roots] = roots
    agreement, _ = _agreement((p[parent] - p).T, n.T, n[parent].T)
    sign = np.where(agreement < 0, -1.0, 1.0)
    # each step looks twice as far up: as many steps as the depth has binary digits
    while (parent[parent] != parent).any():
        sign, parent = sign * sign[parent], parent[parent]
    return sign * sign[parent], part


def _vote(sign: np.ndarray, votes: np.ndarray, index: np.ndarray) -> None:
    """Turn, in place, the signs that most neighbours contradict."""
    graph = _graph(votes, index, votes != 0)
    for _ in range(_SWEEPS):
        against = sign * (graph @ sign + graph.T @ sign) < 0
        if not against.any():
            return
        sign[against] *= -1


def _outward(p: np.ndarray, n: np.ndarray, areas: np.ndarray, part: np.ndarray) -> np.ndarray:
    """Sign of each part."""
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
