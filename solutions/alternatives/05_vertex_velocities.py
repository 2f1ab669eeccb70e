"""Right answers to notebook 05, written in other ways."""

from itertools import combinations

import numpy as np
from matplotlib.tri import Triangulation

from fieldgrade.authoring.catalogue import answers

# 05.1 edges_of


@answers("05.1")
def by_sets(triangles):
    found = set()
    for a, b, c in triangles.tolist():
        for i, j in ((a, b), (b, c), (c, a)):
            if (j, i) not in found:
                found.add((i, j))
    return np.array(list(found))


@answers("05.1")
def by_codes(triangles):
    k = triangles.max() + 1
    low = np.minimum(triangles, np.roll(triangles, 1, axis=1)).ravel()
    high = np.maximum(triangles, np.roll(triangles, 1, axis=1)).ravel()
    codes = np.unique(high * k + low)
    return np.stack([codes // k, codes % k], axis=1)


@answers("05.1")
def by_a_matrix_of_neighbours(triangles):
    k = triangles.max() + 1
    joined = np.zeros((k, k), dtype=bool)
    for a, b in combinations(range(3), 2):
        joined[triangles[:, a], triangles[:, b]] = True
        joined[triangles[:, b], triangles[:, a]] = True
    return np.argwhere(np.triu(joined))


@answers("05.1")
def by_matplotlib(triangles):
    k = triangles.max() + 1
    angle = 2 * np.pi * np.arange(k) / k
    return Triangulation(np.cos(angle), np.sin(angle), triangles).edges


# 05.2 midpoints_and_normals


@answers("05.2")
def to_the_other_side(points, edges):
    i, j = edges.T
    d = points[j] - points[i]
    n = np.stack([d[:, 1], -d[:, 0]], axis=-1)
    n = n / np.hypot(d[:, 0], d[:, 1])[:, None]
    return points[i] + d / 2, n


@answers("05.2")
def edge_by_edge(points, edges):
    p, n = np.zeros((len(edges), 2)), np.zeros((len(edges), 2))
    for a, (i, j) in enumerate(edges):
        p[a] = 0.5 * (points[i] + points[j])
        dx, dy = points[j] - points[i]
        n[a] = np.array([-dy, dx]) / np.sqrt(dx**2 + dy**2)
    return p, n


@answers("05.2")
def by_complex_numbers(points, edges):
    z = points[:, 0] + 1j * points[:, 1]
    along = z[edges[:, 1]] - z[edges[:, 0]]
    n = 1j * along / np.abs(along)
    return points[edges].mean(axis=1), np.column_stack([n.real, n.imag])


@answers("05.2")
def by_angles(points, edges):
    d = np.diff(points[edges], axis=1)[:, 0]
    angle = np.arctan2(d[:, 1], d[:, 0]) - np.pi / 2
    return points[edges].sum(axis=1) / 2, np.array([np.cos(angle), np.sin(angle)]).T


# 05.3 rotation


@answers("05.3")
def by_the_matrix(points):
    j = np.array([[0, -1], [1, 0]])
    return (points - points.mean(axis=0)) @ j.T


@answers("05.3")
def by_a_loop(points):
    m = sum(points) / len(points)
    return [[-(y - m[1]), x - m[0]] for x, y in points]


@answers("05.3")
def in_the_complex_plane(points):
    z = points @ np.array([1, 1j])
    u = 1j * (z - z.mean())
    return np.stack([u.real, u.imag], axis=-1)


@answers("05.3")
def turned_then_centred(points):
    u = np.empty_like(points)
    u[:, 0], u[:, 1] = -points[:, 1], points[:, 0]
    return u - np.average(u, axis=0)


# 05.4 normal_velocities


@answers("05.4")
def mean_of_projections(edges, normals, u):
    first = np.einsum("ij,ij->i", normals, u[edges[:, 0]])
    second = np.einsum("ij,ij->i", normals, u[edges[:, 1]])
    return 0.5 * (first + second)


@answers("05.4")
def one_by_one(edges, normals, u):
    return [n @ (u[i] + u[j]) / 2 for (i, j), n in zip(edges, normals)]


@answers("05.4")
def by_matmul(edges, normals, u):
    return (u[edges].mean(axis=1)[:, None, :] @ normals[:, :, None])[:, 0, 0]


# 05.6 ring


@answers("05.6")
def by_codes_of_pairs(triangles, edges, vertex, rings):
    k = triangles.max() + 1
    reached = np.zeros(k, dtype=bool)
    reached[vertex] = True
    for _ in range(rings):
        near = triangles[reached[triangles].any(axis=1)]
        reached[near] = True

    def code(i, j):
        return np.minimum(i, j) * k + np.maximum(i, j)

    sides = np.concatenate([code(near[:, a], near[:, b]) for a, b in ((0, 1), (1, 2), (2, 0))])
    return np.isin(code(*edges.T), sides)


@answers("05.6")
def by_sets_of_corners(triangles, edges, vertex, rings):
    corners = {vertex}
    for _ in range(rings):
        near = [set(t) for t in triangles.tolist() if corners.intersection(t)]
        corners = set().union(*near)
    return [1 if any({i, j} <= t for t in near) else 0 for i, j in edges.tolist()]


@answers("05.6")
def by_neighbours_of_triangles(triangles, edges, vertex, rings):
    has = np.zeros((len(triangles), triangles.max() + 1), dtype=int)
    for t, corners in enumerate(triangles):
        has[t, corners] = 1
    near = has[:, vertex] > 0
    for _ in range(1, rings):
        near = has @ has.T @ near > 0
    return (has[:, edges[:, 0]] * has[:, edges[:, 1]])[near].any(axis=0)


# 05.7 system


@answers("05.7")
def by_kronecker_products(midpoints, normals, x):
    return np.array([np.kron([1.0, *(p - x)], n) for p, n in zip(midpoints, normals)])


@answers("05.7")
def by_outer_products(midpoints, normals, x):
    b = np.column_stack([np.ones(len(midpoints)), midpoints - x])
    return np.einsum("ij,ik->ijk", b, normals).reshape(-1, 6)


@answers("05.7")
def column_by_column(midpoints, normals, x):
    b = np.empty((len(midpoints), 6))
    for k in range(2):
        b[:, k] = normals[:, k]
        b[:, 2 + k] = (midpoints[:, 0] - x[0]) * normals[:, k]
        b[:, 4 + k] = (midpoints[:, 1] - x[1]) * normals[:, k]
    return b


@answers("05.7")
def by_diagonal_matrices(midpoints, normals, x):
    b = np.insert(midpoints - x, 0, 1.0, axis=1)
    halves = [np.diag(n) @ b for n in normals.T]
    return np.hstack(halves)[:, [0, 3, 1, 4, 2, 5]]


@answers("05.7")
def by_the_matrix_of_notebook_04(midpoints, normals, x):
    """The function of 04.1, called for the positions relative to the vertex."""

    def velocity_matrix(points, normals):
        columns = np.column_stack([np.ones(len(points)), points]).T
        return np.concatenate([column[:, None] * normals for column in columns], axis=1)

    return velocity_matrix(midpoints - x, normals)


# 05.8 velocity


def matrix(p, n, x):
    b = np.insert(p - x, 0, 1.0, axis=1)
    return (b[:, :, None] * n[:, None, :]).reshape(len(p), 6)


@answers("05.8")
def by_qr_of_the_determined_part(midpoints, normals, v, x, w):
    b = np.diag(w) @ matrix(midpoints, normals, x)
    left, sizes, _ = np.linalg.svd(b)
    kept = left[:, : np.sum(sizes > 1e-14 * sizes[0])]
    q, r = np.linalg.qr((kept.T @ b).T)
    return q[:2] @ np.linalg.solve(r.T, kept.T @ (w * v))


@answers("05.8")
def by_pseudo_inverse(midpoints, normals, v, x, w):
    c = np.linalg.pinv(np.diag(w) @ matrix(midpoints, normals, x)) @ (np.diag(w) @ v)
    return c[0], c[1]


@answers("05.8")
def term_by_term(midpoints, normals, v, x, w):
    left, sizes, right = np.linalg.svd(w[:, None] * matrix(midpoints, normals, x))
    c = np.zeros(6)
    for k, size in enumerate(sizes):
        if size > 1e-14 * sizes[0]:
            c += (left[:, k] @ (w * v)) / size * right[k]
    return c[:2]


# 05.9 ranks


def parts(points, triangles, rings):
    """Edges around each vertex, as midpoints from the vertex in units of the largest distance,
    and normals.
    """
    for i, x in enumerate(points):
        corners = {i}
        for _ in range(rings):
            near = [t for t in triangles.tolist() if corners.intersection(t)]
            corners = set().union(*near)
        pairs = sorted({tuple(sorted(pair)) for t in near for pair in combinations(t, 2)})
        a, b = (points[list(side)] - x for side in zip(*pairs))
        d = b - a
        y = (a + b) / 2
        yield (
            y / np.hypot(*y.T).max(),
            np.stack([-d[:, 1], d[:, 0]], axis=1) / np.hypot(*d.T)[:, None],
        )


@answers("05.9")
def in_units_of_the_ring(points, triangles, rings):
    return [
        np.linalg.matrix_rank(matrix(y, n, 0), tol=1e-7) for y, n in parts(points, triangles, rings)
    ]


@answers("05.9")
def by_singular_values(points, triangles, rings):
    found = []
    for y, n in parts(points, triangles, rings):
        sizes = np.linalg.svd(matrix(y, n, 0), compute_uv=False)
        found.append((sizes > 1e-6 * sizes[0]).sum())
    return np.array(found)


@answers("05.9")
def by_eigenvalues(points, triangles, rings):
    found = np.zeros(len(points))
    for k, (y, n) in enumerate(parts(points, triangles, rings)):
        b = matrix(y, n, 0)
        found[k] = np.sum(np.linalg.eigvalsh(b.T @ b) > 1e-11)
    return found


@answers("05.9")
def by_conics(points, triangles, rings):
    edges = np.array([[t[k - 1], t[k]] for t in triangles for k in range(3)])
    found = []
    for i, x in enumerate(points):
        corners = np.array([i])
        for _ in range(rings):
            corners = np.unique(edges[np.isin(edges, corners).any(axis=1)])
        z = points[corners] - x
        a, b = (z / np.abs(z).max()).T
        found.append(
            np.linalg.matrix_rank(np.stack([a**0, a, b, a * a, a * b, b * b], axis=1), tol=1e-7)
        )
    return found
