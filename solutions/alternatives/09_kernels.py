"""Right answers to notebook 09, written in other ways."""

from itertools import combinations_with_replacement
from math import floor

import numpy as np

from fieldgrade.authoring.catalogue import answers


def full(points, degree):
    x, y = points[:, 0], points[:, 1]
    table = np.zeros((len(points), (degree + 1) * (degree + 2) // 2))
    column = 0
    for total in range(degree + 1):
        for b in range(total + 1):
            table[:, column] = x ** (total - b) * y**b
            column += 1
    return table


def phi(r, k):
    sign = [0, -1, 1, 1, -1, -1, 1, 1, -1][k]
    return sign * r**k if k % 2 else sign * r**k * np.log(np.where(r == 0, 1, r))


def gaps(x, points):
    return np.sqrt(sum((x[:, None, i] - points[None, :, i]) ** 2 for i in range(x.shape[1])))


# 09.1 The monomials


@answers("09.1")
def by_first_exponent(points, degree):
    x, y = points.T
    pairs = [(a, b) for a in range(degree + 1) for b in range(degree + 1 - a)]
    return np.array([x**a * y**b for a, b in pairs]).reshape(len(pairs), len(points)).T


@answers("09.1")
def with_second_coordinate_first(points, degree):
    if degree < 0:
        return np.zeros((len(points), 0))
    columns = []
    for b in range(degree + 1):
        for a in range(degree + 1):
            if a + b <= degree:
                columns.append(points[:, 1] ** b * points[:, 0] ** a)
    return np.column_stack(columns)


@answers("09.1")
def by_products_of_factors(points, degree):
    columns = []
    for total in range(degree + 1):
        for chosen in combinations_with_replacement((0, 1), total):
            column = np.ones(len(points))
            for i in chosen:
                column = column * points[:, i]
            columns.append(column)
    return np.array(columns).T if columns else np.empty((len(points), 0))


# 09.2 The least eigenvalue


@answers("09.2")
def by_pivoted_elimination(a, p):
    from scipy.linalg import null_space

    z = null_space(p.T, rcond=1e-10) if p.shape[1] else np.eye(len(a))
    return min(np.linalg.eigvalsh(z.T @ a @ z))


@answers("09.2")
def by_an_obstacle(a, p):
    """The form is made large where the conditions do not hold."""
    u, s, _ = np.linalg.svd(p, full_matrices=False)
    u = u[:, s > 1e-10 * max(s, default=1)]
    k = np.eye(len(a)) - u @ u.T
    large = 2 * np.linalg.norm(a)
    return np.linalg.eigvalsh(k @ a @ k + large * u @ u.T).min()


@answers("09.2")
def by_a_general_problem(a, p):
    """A basis that is not orthonormal, and its Gram matrix on the other side."""
    from scipy.linalg import eigh, null_space

    z = null_space(p.T, rcond=1e-10) if p.shape[1] else np.eye(len(a))
    z = z @ np.triu(np.ones((z.shape[1], z.shape[1])))
    return eigh(z.T @ a @ z, z.T @ z, eigvals_only=True)[0]


@answers("09.2")
def with_a_penalty_off_the_subspace(a, p):
    n = len(a)
    off = p @ np.linalg.pinv(p, rcond=1e-10) if p.shape[1] else np.zeros((n, n))
    on = np.eye(n) - off
    return np.linalg.eigvalsh(on @ a @ on + 10 * np.abs(a).sum() * off).min()


# 09.3 Polynomials that vanish


def own_box(points):
    """Points with the least coordinates zero and the largest one 1."""
    away = points - points.min(axis=0)
    return away / max(away.max(), 1e-300)


@answers("09.3")
def by_singular_values(points, degree):
    s = np.linalg.svd(full(own_box(points), degree), compute_uv=False)
    return (degree + 1) * (degree + 2) // 2 - np.sum(s > 1e-11 * s[0])


@answers("09.3")
def by_a_null_space(points, degree):
    from scipy.linalg import null_space

    return null_space(full(own_box(points), degree), rcond=1e-10).shape[1]


@answers("09.3")
def by_pivots(points, degree):
    from scipy.linalg import qr

    p = full(own_box(points), degree)
    r = np.abs(np.diag(qr(p, mode="economic", pivoting=True)[1]))
    return p.shape[1] - int((r > 1e-10 * r[0]).sum())


@answers("09.3")
def in_centred_coordinates(points, degree):
    own = points - points.mean(axis=0)
    p = full(own / max(np.abs(own).max(), 1e-12), degree)
    return p.shape[1] - np.linalg.matrix_rank(p, tol=1e-9)


# 09.4 The field


@answers("09.4")
def on_the_null_space(points, values, k, degree, x):
    p, a = full(points, degree), phi(gaps(points, points), k)
    q, r = np.linalg.qr(p, mode="complete")
    m = p.shape[1]
    z = q[:, m:]
    lam = z @ np.linalg.solve(z.T @ a @ z, z.T @ values)
    c = np.linalg.solve(r[:m], q[:, :m].T @ (values - a @ lam))
    return phi(gaps(x, points), k) @ lam + full(x, degree) @ c


@answers("09.4")
def with_the_polynomial_first(points, values, k, degree, x):
    n, p = len(points), full(points, degree)
    m = p.shape[1]
    h = np.zeros((n + m, n + m))
    h[:m, m:], h[m:, :m] = p.T, p
    h[m:, m:] = phi(gaps(points, points), k)
    unknown = np.linalg.solve(h, np.r_[np.zeros(m), values])
    return np.hstack([full(x, degree), phi(gaps(x, points), k)]) @ unknown


@answers("09.4")
def with_the_sign_turned(points, values, k, degree, x):
    """The sign of the kernel makes no difference to the field: λ takes it up."""
    n, p = len(points), full(points, degree)
    h = np.block([[-phi(gaps(points, points), k), p], [p.T, np.zeros((p.shape[1], p.shape[1]))]])
    unknown = np.linalg.solve(h, np.append(values, np.zeros(p.shape[1])))
    return full(x, degree) @ unknown[n:] - phi(gaps(x, points), k) @ unknown[:n]


@answers("09.4")
def by_loops(points, values, k, degree, x):
    n, p = len(points), full(points, degree)
    m = p.shape[1]
    h = np.zeros((n + m, n + m))
    for i in range(n):
        for j in range(n):
            h[i, j] = phi(np.array(np.hypot(*(points[i] - points[j]))), k)
        for j in range(m):
            h[i, n + j] = h[n + j, i] = p[i, j]
    u = np.linalg.solve(h, np.append(values, np.zeros(m)))
    f = []
    for place, row in zip(x, full(x, degree)):
        terms = phi(np.hypot(*(place - points).T), k)
        f.append(terms @ u[:n] + row @ u[n:])
    return np.array(f)


# 09.5 Wendland's functions


@answers("09.5")
def with_where(r, d, s):
    ell = floor(d / 2) + s + 1
    if s == 1:
        return np.where(r < 1, (1 - r) ** (ell + 1) * (ell * r + r + 1), 0.0)
    return np.where(r < 1, (1 - r) ** ell, 0.0)


@answers("09.5")
def by_one_formula(r, d, s):
    ell = d // 2 + s + 1
    return (r < 1) * (1 - r) ** (ell + s) * (1 + s * (ell + 1) * r)


@answers("09.5")
def by_the_integral(r, d, s):
    """(9.9) by hand: t (1 - t)^ℓ has the antiderivative of powers of 1 - t."""
    y = np.clip(1 - r, 0, 1)
    ell = d // 2 + 1
    if s == 0:
        return y**ell
    m = ell + 1
    return (y ** (m + 1) / (m + 1) - y ** (m + 2) / (m + 2)) * (m + 1) * (m + 2)


# 09.6 Two points change places


def determinant(points, t):
    middle = (points[0] + points[1]) / 2
    c, s = np.cos(np.pi * t), np.sin(np.pi * t)
    turn = np.array([[c, -s], [s, c]])
    one, two = middle + turn @ (points[0] - middle), middle + turn @ (points[1] - middle)
    return np.linalg.det(np.array([[1, *one], [1, *two], [1, *points[2]]]))


@answers("09.6")
def by_bisection(points):
    low, high = 0.0, 1.0
    sign = np.sign(determinant(points, 0.0))
    for _ in range(50):
        t = (low + high) / 2
        if np.sign(determinant(points, t)) == sign:
            low = t
        else:
            high = t
    return low


@answers("09.6")
def by_a_root_finder(points):
    from scipy.optimize import brentq

    return brentq(lambda t: determinant(points, t), 0, 1, xtol=1e-14)


@answers("09.6")
def by_two_angles(points):
    middle = (points[0] + points[1]) / 2
    one, other = points[0] - middle, points[2] - middle
    return ((np.arctan2(*other[::-1]) - np.arctan2(*one[::-1])) % np.pi) / np.pi


@answers("09.6")
def by_complex_numbers(points):
    z = points[:, 0] + 1j * points[:, 1]
    t = np.angle((2 * z[2] - z[0] - z[1]) / (z[0] - z[1])) / np.pi
    return t + 1 if t < 0 else t


# 09.7 Values and slopes


@answers("09.7")
def by_slope_loops(x):
    n = len(x)
    h = np.zeros((2 * n + 2, 2 * n + 2))
    for i in range(n):
        for j in range(n):
            z = x[i] - x[j]
            h[i, j] = abs(z) ** 3
            h[i, n + j] = -3 * z * abs(z)
            h[n + i, j] = 3 * z * abs(z)
            h[n + i, n + j] = -6 * abs(z)
        h[i, 2 * n] = h[2 * n, i] = 1
        h[i, 2 * n + 1] = h[2 * n + 1, i] = x[i]
        h[n + i, 2 * n + 1] = h[2 * n + 1, n + i] = 1
    return h


@answers("09.7")
def half_and_its_transpose(x):
    n = len(x)
    z = np.subtract.outer(x, x)
    upper = np.zeros((2 * n + 2, 2 * n + 2))
    upper[:n, n : 2 * n] = -3 * np.sign(z) * z**2
    upper[:n, 2 * n], upper[:n, 2 * n + 1], upper[n : 2 * n, 2 * n + 1] = 1, x, 1
    whole = upper + upper.T
    whole[:n, :n], whole[n : 2 * n, n : 2 * n] = np.abs(z**3), -6 * np.abs(z)
    return whole


@answers("09.7")
def by_stacking(x):
    z = x[:, None] - x[None, :]
    r, one, none = np.sqrt(z * z), np.ones((len(x), 1)), np.zeros((len(x), 1))
    values = np.hstack([r**3, -3 * z * r, one, x[:, None]])
    slopes = np.hstack([3 * z * r, -6 * r, none, one])
    below = np.hstack([np.vstack([values, slopes])[:, -2:].T, np.zeros((2, 2))])
    return np.vstack([values, slopes, below])
