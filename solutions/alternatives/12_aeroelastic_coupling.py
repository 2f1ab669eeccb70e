"""Right answers to notebook 12, written in other ways."""

import numpy as np

from fieldgrade.authoring.catalogue import answers


def matrix(nodes):
    """The system of (12.1), entry by entry."""
    n, d = nodes.shape
    a = np.zeros((n + d + 1, n + d + 1))
    for i in range(n):
        for j in range(n):
            a[i, j] = np.sqrt(((nodes[i] - nodes[j]) ** 2).sum()) ** 3
        a[i, n] = a[n, i] = 1
        a[i, n + 1 :] = a[n + 1 :, i] = nodes[i]
    return a


def rising(nodes, y):
    return np.r_[np.linalg.norm(y - nodes, axis=1) ** 3, 1, y]


# 12.1


@answers("12.1")
def one_point_after_the_other(nodes, points):
    rows = [np.linalg.solve(matrix(nodes), rising(nodes, y))[: len(nodes)] for y in points]
    return np.array(rows)


@answers("12.1")
def by_unit_displacements(nodes, points):
    n = len(nodes)
    coefficients = np.linalg.solve(matrix(nodes), np.eye(len(matrix(nodes)))[:, :n])
    return np.array([rising(nodes, y) for y in points]) @ coefficients


@answers("12.1")
def by_the_inverse(nodes, points):
    inverse = np.linalg.inv(matrix(nodes))
    return (np.array([rising(nodes, y) for y in points]) @ inverse)[:, : len(nodes)]


@answers("12.1")
def in_the_space_of_the_side_conditions(nodes, points):
    n = len(nodes)
    a = matrix(nodes)
    phi, p = a[:n, :n], a[:n, n:]
    q, r = np.linalg.qr(p, mode="complete")
    first, z = q[:, : p.shape[1]], q[:, p.shape[1] :]
    h = []
    for y in points:
        b = rising(nodes, y)
        base = first @ np.linalg.solve(r[: p.shape[1]].T, b[n:])
        h.append(base + z @ np.linalg.solve(z.T @ phi @ z, z.T @ (b[:n] - phi @ base)))
    return np.array(h)


# 12.2


@answers("12.2")
def by_indices(H, f):
    return np.einsum("ij,ik->jk", H, f)


@answers("12.2")
def force_by_force(H, f):
    g = np.zeros((H.shape[1], f.shape[1]))
    for parts, force in zip(H, f):
        g += np.outer(parts, force)
    return g


@answers("12.2")
def transposed_twice(H, f):
    return (f.T @ H).T


# 12.4


@answers("12.4")
def component_by_component(points, forces, about):
    x, y, z = (points - about).T
    fx, fy, fz = forces.T
    return np.array(
        [
            fx.sum(),
            fy.sum(),
            fz.sum(),
            (y * fz - z * fy).sum(),
            (z * fx - x * fz).sum(),
            (x * fy - y * fx).sum(),
        ]
    )


@answers("12.4")
def moved_from_the_origin(points, forces, about):
    total = forces.sum(axis=0)
    return np.hstack([total, np.cross(points, forces).sum(axis=0) - np.cross(about, total)])


@answers("12.4")
def as_work_in_rigid_motions(points, forces, about):
    work = [np.sum(forces * axis) for axis in np.eye(3)]
    work += [np.sum(forces * np.cross(axis, points - about)) for axis in np.eye(3)]
    return np.array(work)


@answers("12.4")
def in_a_loop(points, forces, about):
    total = np.zeros(6)
    for p, f in zip(points, forces):
        total[:3] += f
        total[3:] += np.cross(p - about, f)
    return total


# 12.6


@answers("12.6")
def with_diagonal_matrices(H, p, m):
    areas = np.diag(H.T @ m)
    return np.linalg.inv(areas) @ H.T @ np.diag(m) @ p


@answers("12.6")
def node_by_node(H, p, m):
    return np.array([np.sum(column * m * p) / np.sum(column * m) for column in H.T])


@answers("12.6")
def as_weighted_means(H, p, m):
    return np.array([np.average(p, weights=column * m) for column in H.T])


# 12.7


@answers("12.7")
def by_the_coefficients(nodes, points):
    n, d = nodes.shape
    c = np.linalg.inv(matrix(nodes))[:, :n]
    away = points[:, None, :] - nodes[None, :, :]
    kernels = 3 * np.sqrt((away**2).sum(axis=2))[:, :, None] * away
    return np.stack([kernels[:, :, k] @ c[:n] + c[n + 1 + k] for k in range(d)])


@answers("12.7")
def all_right_sides_at_once(nodes, points):
    n, d = nodes.shape
    m = len(points)
    away = points.T[:, :, None] - nodes.T[:, None, :]
    b = np.zeros((d, m, n + d + 1))
    b[:, :, :n] = 3 * np.linalg.norm(away, axis=0) * away
    b[np.arange(d), :, n + 1 + np.arange(d)] = 1
    return np.linalg.solve(matrix(nodes), b.transpose(0, 2, 1)).transpose(0, 2, 1)[:, :, :n]


@answers("12.7")
def point_by_point(nodes, points):
    n, d = nodes.shape
    g = np.zeros((d, len(points), n))
    for i, y in enumerate(points):
        for k in range(d):
            b = np.zeros(n + d + 1)
            for j, x in enumerate(nodes):
                b[j] = 3 * np.linalg.norm(y - x) * (y - x)[k]
            b[n + 1 + k] = 1
            g[k, i] = np.linalg.solve(matrix(nodes), b)[:n]
    return g


# 12.8


def in_the_plane(nodes, points):
    """H and its two slopes."""
    p = points[:, :2]
    return one_point_after_the_other(nodes, p), by_the_coefficients(nodes, p)


@answers("12.8")
def by_the_matrix_of_displacements(nodes, points, f):
    h, g = in_the_plane(nodes, points)
    whole = np.zeros((len(points), 3, len(nodes), 3))
    for k in range(3):
        whole[:, k, :, k] = h
    whole[:, 0, :, 2] -= points[:, [2]] * g[0]
    whole[:, 1, :, 2] -= points[:, [2]] * g[1]
    return np.tensordot(f, whole, axes=([0, 1], [0, 1]))


@answers("12.8")
def force_after_force(nodes, points, f):
    h, g = in_the_plane(nodes, points)
    loads = np.zeros((len(nodes), 3))
    for i, force in enumerate(f):
        loads += np.outer(h[i], force)
        loads[:, 2] -= points[i, 2] * (force[0] * g[0, i] + force[1] * g[1, i])
    return loads


@answers("12.8")
def as_work_in_unit_displacements(nodes, points, f):
    h, g = in_the_plane(nodes, points)
    loads = np.zeros((len(nodes), 3))
    for j in range(len(nodes)):
        for k in range(3):
            v = np.zeros(points.shape)
            v[:, k] = h[:, j]
            if k == 2:
                v[:, :2] = -points[:, [2]] * g[:, :, j].T
            loads[j, k] = np.sum(v * f)
    return loads


# 12.10


@answers("12.10")
def with_one_matrix(K, H, f0, A, omega, steps):
    onward = (1 - omega) * np.eye(len(K)) + omega * np.linalg.inv(K) @ H.T @ A @ H
    push = omega * np.linalg.inv(K) @ H.T @ f0
    u = [np.zeros(len(K))]
    for _ in range(steps):
        u.append(onward @ u[-1] + push)
    return np.array(u)


@answers("12.10")
def by_residuals(K, H, f0, A, omega, steps):
    u = np.zeros(len(K))
    found = [u]
    for _ in range(steps):
        residual = H.T @ (f0 + A @ H @ u) - K @ u
        u = u + omega * np.linalg.solve(K, residual)
        found.append(u)
    return np.stack(found)


@answers("12.10")
def as_sums_of_powers(K, H, f0, A, omega, steps):
    first = omega * np.linalg.solve(K, H.T @ f0)
    factor = (1 - omega) * np.eye(len(K)) + omega * np.linalg.solve(K, H.T @ A @ H)
    added = [np.linalg.matrix_power(factor, n) @ first for n in range(steps)]
    return np.cumsum([np.zeros(len(K)), *added], axis=0)


# 12.11


@answers("12.11")
def by_the_other_quotient(K, H, A):
    growth = np.linalg.eigvals(H.T @ A @ H @ np.linalg.inv(K))
    scale = np.abs(growth).max()
    q = [1 / g.real for g in growth if abs(g.imag) < 1e-9 * scale and g.real > 1e-9 * scale]
    return min(q)


@answers("12.11")
def by_the_root_of_the_stiffness(K, H, A):
    values, vectors = np.linalg.eigh(K)
    root = vectors @ np.diag(values**-0.5) @ vectors.T
    growth = np.linalg.eigvals(root @ H.T @ A @ H @ root)
    return 1 / max(g.real for g in growth if g.imag == 0)


@answers("12.11")
def by_bisection_of_the_determinant(K, H, A):
    def sign(q):
        return np.linalg.slogdet(K - q * H.T @ A @ H)[0]

    reach = 1 / np.abs(np.linalg.eigvals(np.linalg.solve(K, H.T @ A @ H))).max()
    low, high = 0.0, 0.9 * reach
    while sign(high) > 0:
        low, high = high, 1.01 * high
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if sign(middle) > 0 else (low, middle)
    return high
