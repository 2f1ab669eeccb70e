"""Right answers to notebook 03, written in other ways."""

import numpy as np

from fieldgrade.authoring.catalogue import answers


def w(y):
    s = (y * y).sum(-1)
    return np.nan_to_num(s * np.log(s))


def between(x, points):
    return w(x[:, None] - points)


# 03.1 The kernel


@answers("03.1")
def with_nan_replaced(y):
    s = (y**2).sum(axis=-1)
    return np.nan_to_num(s * np.log(s))


@answers("03.1")
def with_one_in_the_logarithm_of_zero(y):
    r = np.linalg.norm(y, axis=-1)
    return 2 * r**2 * np.log(np.where(r == 0, 1, r))


@answers("03.1")
def by_a_loop(y):
    flat = y.reshape(-1, y.shape[-1])
    w = []
    for v in flat:
        s = v @ v
        w.append(s * np.log(s) if s > 0 else 0)
    return np.array(w).reshape(y.shape[:-1])


@answers("03.1")
def with_a_negligible_addition(y):
    s = np.einsum("...d,...d->...", y, y)
    return s * np.log(s + 1e-300)


@answers("03.1")
def as_nested_lists(y):
    s = np.square(y).sum(-1)
    return np.vectorize(lambda t: t * np.log(t) if t else 0.0)(s).tolist()


# 03.2 The matrix


@answers("03.2")
def from_matrices(points):
    b = np.matrix(np.insert(points, 0, 1.0, axis=1))
    q = b.shape[1]
    return np.bmat([[np.matrix(between(points, points)), b], [b.T, np.zeros((q, q))]])


@answers("03.2")
def by_loops(points):
    n, d = points.shape
    h = np.zeros((n + d + 1, n + d + 1))
    for i in range(n):
        for j in range(n):
            s = sum((points[i] - points[j]) ** 2)
            if s > 0:
                h[i, j] = s * np.log(s)
        h[i, n] = h[n, i] = 1
        for k in range(d):
            h[i, n + 1 + k] = h[n + 1 + k, i] = points[i, k]
    return h


@answers("03.2")
def into_zeros(points):
    n, d = points.shape
    h = np.zeros((n + d + 1, n + d + 1))
    h[:n, :n] = between(points, points)
    h[:n, n] = 1
    h[:n, n + 1 :] = points
    h[n:, :n] = h[:n, n:].T
    return h


@answers("03.2")
def by_stacking(points):
    b = np.column_stack([np.ones(len(points)), points])
    q = b.shape[1]
    top = np.hstack([between(points, points), b])
    bottom = np.hstack([b.T, np.zeros((q, q))])
    return np.vstack([top, bottom])


# 03.3 The coefficients


def bordered(points):
    b = np.insert(points, 0, 1.0, axis=1)
    q = b.shape[1]
    return np.block([[between(points, points), b], [b.T, np.zeros((q, q))]])


@answers("03.3")
def by_the_inverse(points, values):
    n = len(points)
    unknown = np.linalg.inv(bordered(points))[:, :n] @ values
    return unknown[:n], unknown[n:]


@answers("03.3")
def by_lstsq(points, values):
    h = bordered(points)
    right = np.zeros(len(h))
    right[: len(values)] = values
    return tuple(np.split(np.linalg.lstsq(h, right, rcond=None)[0], [len(values)]))


@answers("03.3")
def as_a_list(points, values):
    unknown = np.linalg.solve(bordered(points), np.append(values, np.zeros(points.shape[1] + 1)))
    return np.split(unknown, [len(values)])


@answers("03.3")
def on_the_null_space_by_cholesky(points, values):
    b = np.insert(points, 0, 1.0, axis=1)
    q, r = np.linalg.qr(b, mode="complete")
    k = b.shape[1]
    z, a = q[:, k:], between(points, points)
    if z.shape[1]:
        factor = np.linalg.cholesky(z.T @ a @ z)
        lam = z @ np.linalg.solve(factor.T, np.linalg.solve(factor, z.T @ values))
    else:
        lam = np.zeros(len(values))
    return lam, np.linalg.solve(r[:k], q[:, :k].T @ (values - a @ lam))


@answers("03.3")
def with_the_polynomial_first(points, values):
    b = np.insert(points, 0, 1.0, axis=1)
    q = b.shape[1]
    h = np.block([[np.zeros((q, q)), b.T], [b, between(points, points)]])
    unknown = np.linalg.solve(h, np.append(np.zeros(q), values))
    return unknown[q:], unknown[:q]


@answers("03.3")
def with_half_of_the_kernel_and_half_of_lambda(points, values):
    b = np.insert(points, 0, 1.0, axis=1)
    q, n = b.shape[1], len(points)
    h = np.block([[between(points, points) / 2, b], [b.T, np.zeros((q, q))]])
    unknown = np.linalg.solve(h, np.append(values, np.zeros(q)))
    return unknown[:n] / 2, unknown[n:]


# 03.4 The field


@answers("03.4")
def place_by_place(points, lam, c, x):
    values = []
    for place in x:
        total = c[0] + np.dot(c[1:], place)
        for p, factor in zip(points, lam):
            s = np.sum((place - p) ** 2)
            if s > 0:
                total += factor * s * np.log(s)
        values.append(total)
    return values


@answers("03.4")
def one_centre_after_another(points, lam, c, x):
    f = np.insert(x, 0, 1.0, axis=1) @ c
    for p, factor in zip(points, lam):
        f = f + factor * w(x - p)
    return f


@answers("03.4")
def by_einsum(points, lam, c, x):
    return c[0] + np.einsum("md,d->m", x, c[1:]) + np.einsum("mn,n->m", between(x, points), lam)


# 03.5 The signs


@answers("03.5")
def by_signs(points):
    eigenvalues = np.linalg.eigvalsh(bordered(points))
    eigenvalues[np.abs(eigenvalues) < 1e-12 * np.abs(eigenvalues).max()] = 0
    signs = np.sign(eigenvalues)
    return [np.count_nonzero(signs == s) for s in (1, -1, 0)]


@answers("03.5")
def by_general_eigenvalues(points):
    eigenvalues = np.linalg.eigvals(bordered(points)).real
    tolerance = 1e-12 * np.linalg.norm(eigenvalues)
    positive, negative = (eigenvalues > tolerance).sum(), (eigenvalues < -tolerance).sum()
    return np.array([positive, negative, len(eigenvalues) - positive - negative])


@answers("03.5")
def by_the_law_of_inertia(points):
    """A shift by the tolerance separates the zeros; a factorization keeps the signs (Sylvester)."""
    from scipy.linalg import ldl

    h = bordered(points)
    tolerance = 1e-12 * np.linalg.norm(h, 2) * np.eye(len(h))
    above, below = (np.linalg.eigvalsh(ldl(h + s * tolerance)[1]) for s in (-1, 1))
    positive, negative = int(sum(above > 0)), int(sum(below < 0))
    return positive, negative, len(h) - positive - negative


@answers("03.5")
def by_singular_values(points):
    """The zeros are the small singular values; the other eigenvalues have their signs."""
    values = np.linalg.eigvalsh(bordered(points))
    sizes = np.linalg.svd(bordered(points), compute_uv=False)
    zero = int(np.sum(sizes <= 1e-12 * sizes[0]))
    kept = np.argsort(np.abs(values))[zero:]
    positive = int(np.sum(values[kept] > 0))
    return positive, len(kept) - positive, zero


# 03.6 The gradient


@answers("03.6")
def with_nan_replaced_by_zero(points, lam, c, x):
    y = x[:, None] - points
    s = (y**2).sum(axis=2)
    kernels = np.nan_to_num(2 * y * (1 + np.log(s))[..., None], posinf=0, neginf=0)
    return c[1:] + np.tensordot(lam, kernels, axes=(0, 1))


@answers("03.6")
def by_a_loop_over_places(points, lam, c, x):
    g = np.tile(c[1:], (len(x), 1)).astype(float)
    for m, place in enumerate(x):
        for p, factor in zip(points, lam):
            y = place - p
            s = y @ y
            if s != 0:
                g[m] += 2 * factor * y * np.log(s) + 2 * factor * y
    return g


@answers("03.6")
def coordinate_by_coordinate(points, lam, c, x):
    s = sum((x[:, [k]] - points[:, k]) ** 2 for k in range(x.shape[1]))
    slope = 2 + 2 * np.log(np.where(s > 0, s, 1))
    return np.stack(
        [c[k + 1] + (slope * (x[:, [k]] - points[:, k])) @ lam for k in range(x.shape[1])], axis=1
    )


# 03.7 The energy


@answers("03.7")
def from_the_values(points, values):
    n = len(points)
    lam = np.linalg.solve(bordered(points), np.append(values, [0, 0, 0]))[:n]
    return 16 * np.pi * lam @ values


@answers("03.7")
def from_the_residual_of_the_affine_part(points, values):
    unknown = np.linalg.solve(bordered(points), np.append(values, [0, 0, 0]))
    lam, c = np.split(unknown, [len(points)])
    return [[16 * np.pi * np.sum(lam * (values - c[0] - points @ c[1:]))]]


@answers("03.7")
def with_half_of_the_kernel(points, values):
    b = np.insert(points, 0, 1.0, axis=1)
    a = between(points, points) / 2
    h = np.block([[a, b], [b.T, np.zeros((3, 3))]])
    lam = np.linalg.solve(h, np.append(values, [0, 0, 0]))[: len(points)]
    return 8 * np.pi * np.einsum("i,ij,j->", lam, a, lam)


@answers("03.7")
def on_the_null_space(points, values):
    z = np.linalg.qr(np.insert(points, 0, 1.0, axis=1), mode="complete")[0][:, 3:]
    inside = z.T @ between(points, points) @ z
    return 16 * np.pi * (z.T @ values) @ np.linalg.solve(inside, z.T @ values)


@answers("03.7")
def by_a_double_sum(points, values):
    lam = np.linalg.inv(bordered(points))[: len(points), : len(points)] @ values
    total = 0.0
    for i, p in enumerate(points):
        for j, q in enumerate(points):
            total += lam[i] * lam[j] * w(p - q)
    return 16 * np.pi * total
