"""Right answers to notebook 10, written in other ways."""

from functools import cache

import numpy as np

from fieldgrade.authoring.catalogue import answers

# 10.1 From truncated powers to distances


@answers("10.1")
def by_the_third_moments(sites, alpha, beta):
    second, third = (alpha * sites**2).sum(), (alpha * sites**3).sum()
    return 0.5 * alpha, np.array([beta[0] - third / 2, beta[1] + 1.5 * second])


@answers("10.1")
def by_two_values_on_the_left(sites, alpha, beta):
    """Left of all sites the curve is β₀ + β₁x; what the cubes of distances give there has to be
    taken away.
    """
    x = sites.min() - np.array([1.0, 2.0])
    rest = beta[0] + beta[1] * x - np.abs(x[:, None] - sites) ** 3 @ (alpha / 2)
    slope = (rest[0] - rest[1]) / (x[0] - x[1])
    return alpha / 2, np.array([rest[0] - slope * x[0], slope])


@answers("10.1")
def by_polynomials(sites, alpha, beta):
    rest = np.polynomial.Polynomial(beta)
    for site, factor in zip(sites, alpha):
        rest = rest + factor / 2 * np.polynomial.Polynomial([-site, 1.0]) ** 3
    return alpha / 2, rest.coef[:2]


@answers("10.1")
def as_a_list(sites, alpha, beta):
    a, b = by_the_third_moments(sites, alpha, beta)
    return [a, b]


# 10.2 The spline by distances


@answers("10.2")
def on_the_null_space(sites, values):
    p = np.vander(sites, 2, increasing=True)
    a = np.abs(np.subtract.outer(sites, sites)) ** 3
    q, r = np.linalg.qr(p, mode="complete")
    z = q[:, 2:]
    factors = z @ np.linalg.solve(z.T @ a @ z, z.T @ values)
    return factors, np.linalg.solve(r[:2], q[:, :2].T @ (values - a @ factors))


@answers("10.2")
def by_loops(sites, values):
    n = len(sites)
    h = np.zeros((n + 2, n + 2))
    for i in range(n):
        for j in range(n):
            h[i, j] = abs(sites[i] - sites[j]) ** 3
        h[i, n] = h[n, i] = 1
        h[i, n + 1] = h[n + 1, i] = sites[i]
    found = np.linalg.inv(h) @ np.concatenate([values, np.zeros(2)])
    return found[:-2], found[-2:]


def second_derivatives(sites, values):
    n, h = len(sites), np.diff(sites)
    a = np.diag(np.r_[1.0, (h[1:] + h[:-1]) / 3, 1.0][:n])
    b = np.zeros(n)
    for i in range(1, n - 1):
        a[i, i - 1], a[i, i + 1] = h[i - 1] / 6, h[i] / 6
        b[i] = (values[i + 1] - values[i]) / h[i] - (values[i] - values[i - 1]) / h[i - 1]
    return np.linalg.solve(a, b)


@answers("10.2")
def from_the_jumps(sites, values):
    """The factors are a twelfth of the jumps of s‴; the line is what is left."""
    order = np.argsort(sites)
    x, f = sites[order], values[order]
    m = second_derivatives(x, f)
    third = np.diff(m) / np.diff(x)
    a = np.empty(len(sites))
    a[order] = np.diff(np.r_[0, third, 0]) / 12
    rest = values - np.abs(sites[:, None] - sites) ** 3 @ a
    return a, np.linalg.lstsq(np.vander(sites, 2, increasing=True), rest, rcond=None)[0]


@answers("10.2")
def as_a_list_of_two(sites, values):
    a, b = on_the_null_space(sites, values)
    return [a, b]


# 10.3 The moments


@answers("10.3")
def by_its_inner_part(sites, values):
    h, n = np.diff(sites), len(sites)
    m = np.zeros(n)
    if n > 2:
        a = np.diag((h[:-1] + h[1:]) / 3) + np.diag(h[1:-1] / 6, 1) + np.diag(h[1:-1] / 6, -1)
        m[1:-1] = np.linalg.solve(a, np.diff(np.diff(values) / h))
    return m


@answers("10.3")
def by_elimination(sites, values):
    """Thomas's algorithm, in a number of steps proportional to N."""
    h = np.diff(sites)
    n = len(sites)
    m, up, right = np.zeros(n), np.zeros(n), np.zeros(n)
    for i in range(1, n - 1):
        b = (values[i + 1] - values[i]) / h[i] - (values[i] - values[i - 1]) / h[i - 1]
        pivot = 2 * (h[i - 1] + h[i]) - h[i - 1] * up[i - 1]
        up[i] = h[i] / pivot
        right[i] = (6 * b - h[i - 1] * right[i - 1]) / pivot
    for i in range(n - 2, 0, -1):
        m[i] = right[i] - up[i] * m[i + 1]
    return m


@answers("10.3")
def by_scipy(sites, values):
    from scipy.interpolate import CubicSpline

    if len(sites) == 2:
        return np.zeros(2)
    m = CubicSpline(sites, values, bc_type="natural")(sites, 2)
    m[[0, -1]] = 0
    return m


@answers("10.3")
def from_the_slopes(sites, values):
    """The unknowns are the slopes at the sites."""
    h, n = np.diff(sites), len(sites)
    rise = np.diff(values) / h
    a, right = np.diag(np.full(n, 2.0)), np.zeros(n)
    a[0, 1] = a[-1, -2] = 1
    right[0], right[-1] = 3 * rise[0], 3 * rise[-1]
    for i in range(1, n - 1):
        share = h[i] / (h[i - 1] + h[i])
        a[i, i - 1], a[i, i + 1] = share, 1 - share
        right[i] = 3 * (share * rise[i - 1] + (1 - share) * rise[i])
    slopes = np.linalg.solve(a, right)
    m = np.append(2 * (3 * rise - 2 * slopes[:-1] - slopes[1:]) / h, 0)
    m[0] = 0
    return m


# 10.4 The pieces


@answers("10.4")
def place_by_place(sites, values, M, x):
    out = []
    for t in x:
        if t <= sites[0]:
            h = sites[1] - sites[0]
            slope = (values[1] - values[0]) / h - h * M[1] / 6
            out.append(values[0] + slope * (t - sites[0]))
        elif t >= sites[-1]:
            h = sites[-1] - sites[-2]
            slope = (values[-1] - values[-2]) / h + h * M[-2] / 6
            out.append(values[-1] + slope * (t - sites[-1]))
        else:
            i = int(np.sum(sites <= t)) - 1
            h = sites[i + 1] - sites[i]
            p, q = sites[i + 1] - t, t - sites[i]
            out.append(
                (p * values[i] + q * values[i + 1]) / h
                + ((p**3 / h - p * h) * M[i] + (q**3 / h - q * h) * M[i + 1]) / 6
            )
    return np.array(out)


@answers("10.4")
def by_taylor(sites, values, M, x):
    """From the left end of each piece: value, slope, half of s″, a sixth of s‴."""
    h = np.diff(sites)
    slope = np.diff(values) / h - h / 6 * (2 * M[:-1] + M[1:])
    third = np.diff(M) / h
    last = (values[-1] - values[-2]) / h[-1] + h[-1] / 6 * M[-2]
    start = np.r_[sites[0], sites]
    c0, c1 = np.r_[values[0], values], np.r_[slope[0], slope, last]
    c2, c3 = np.r_[0, M[:-1], 0] / 2, np.r_[0, third, 0] / 6
    i = np.searchsorted(sites, x, side="right")
    z = x - start[i]
    return c0[i] + z * (c1[i] + z * (c2[i] + z * c3[i]))


@answers("10.4")
def by_scipy_pieces(sites, values, M, x):
    from scipy.interpolate import PPoly

    h = np.diff(sites)
    slopes = np.diff(values) / h - h / 6 * (2 * M[:-1] + M[1:])
    pieces = PPoly([np.diff(M) / (6 * h), M[:-1] / 2, slopes, values[:-1]], sites)
    near = np.clip(x, sites[0], sites[-1])
    last = (values[-1] - values[-2]) / h[-1] + h[-1] / 6 * M[-2]
    return pieces(near) + (x - near) * np.where(x < near, slopes[0], last)


@answers("10.4")
def by_truncated_powers(sites, values, M, x):
    """Each site adds a cubic power, whose coefficient is a sixth of the jump of s‴ there. Before
    the first site the spline is the tangent there.
    """
    h = np.diff(sites)
    alpha = np.diff(np.r_[0, np.diff(M) / h, 0]) / 6
    slope = (values[1] - values[0]) / h[0] - h[0] * M[1] / 6
    cubes = np.maximum(x[:, None] - sites, 0) ** 3
    return values[0] + slope * (x - sites[0]) + cubes @ alpha


@answers("10.4")
def by_cubed_distances(sites, values, M, x):
    """The coefficient of each cubed distance is a twelfth of the jump of s‴ there. The line is
    fitted to what is left of the values.
    """
    a = np.diff(np.r_[0, np.diff(M) / np.diff(sites), 0]) / 12
    left = values - np.abs(sites[:, None] - sites) ** 3 @ a
    line = np.linalg.lstsq(np.vander(sites, 2), left, rcond=None)[0]
    return np.abs(x[:, None] - sites) ** 3 @ a + np.polyval(line, x)


# 10.5 Back to truncated powers


@answers("10.5")
def by_sites(sites, values, M):
    n = len(sites)
    alpha = np.zeros(n)
    for j in range(n):
        after = (M[j + 1] - M[j]) / (sites[j + 1] - sites[j]) if j < n - 1 else 0
        before = (M[j] - M[j - 1]) / (sites[j] - sites[j - 1]) if j > 0 else 0
        alpha[j] = (after - before) / 6
    slope = (values[1] - values[0]) / (sites[1] - sites[0]) - (sites[1] - sites[0]) * M[1] / 6
    return alpha, np.array([values[0] - slope * sites[0], slope])


@answers("10.5")
def line_from_two_values(sites, values, M):
    """The factors by the jumps; the line through what is left at the first two sites."""
    third = np.r_[0, np.diff(M) / np.diff(sites), 0]
    alpha = (third[1:] - third[:-1]) / 6
    first, second = values[0], values[1] - alpha[0] * (sites[1] - sites[0]) ** 3
    slope = (second - first) / (sites[1] - sites[0])
    return alpha, np.array([first - slope * sites[0], slope])


@answers("10.5")
def by_a_triangular_system(sites, values, M):
    """s″ at each site but the first is a sum of 6 α (x - y)."""
    z = np.maximum(sites[1:, None] - sites[:-1], 0)
    alpha = np.linalg.solve(6 * z, M[1:])
    alpha = np.append(alpha, -alpha.sum())
    rest = values - np.maximum(sites[:, None] - sites, 0) ** 3 @ alpha
    line = np.polynomial.Polynomial.fit(sites, rest, 1).convert().coef
    return alpha, np.append(line, [0, 0])[:2]


# 10.6 The energy


@answers("10.6")
def by_simpson(sites, M):
    h = np.diff(sites)
    middle = (M[1:] + M[:-1]) / 2
    return np.sum(h * (M[1:] ** 2 + 4 * middle**2 + M[:-1] ** 2)) / 6


@answers("10.6")
def by_antiderivatives(sites, M):
    total = 0.0
    for i in range(len(sites) - 1):
        h = sites[i + 1] - sites[i]
        square = np.polynomial.Polynomial([M[i], (M[i + 1] - M[i]) / h]) ** 2
        total += square.integ()(h)
    return total


@answers("10.6")
def by_mean_and_jump(sites, M):
    h = np.diff(sites)
    return h @ (((M[1:] + M[:-1]) / 2) ** 2 + np.diff(M) ** 2 / 12)


# 10.7 B-splines


@answers("10.7")
def by_scipy_basis(knots, degree, x):
    from scipy.interpolate import BSpline

    columns = [
        BSpline.basis_element(knots[i : i + degree + 2], extrapolate=False)(x)
        if knots[i + degree + 1] > knots[i]
        else 0 * x
        for i in range(len(knots) - degree - 1)
    ]
    b = np.nan_to_num(np.array(columns).T)
    last = (x[:, None] == knots[degree + 1 :]) & (degree == 0)
    return np.where(last, 0.0, b)


@answers("10.7")
def by_calling_itself(knots, degree, x):
    @cache
    def one(i, k):
        if k == 0:
            return np.where((knots[i] <= x) & (x < knots[i + 1]), 1.0, 0.0)
        total = np.zeros(len(x))
        if knots[i + k] > knots[i]:
            total = total + (x - knots[i]) / (knots[i + k] - knots[i]) * one(i, k - 1)
        if knots[i + k + 1] > knots[i + 1]:
            part = (knots[i + k + 1] - x) / (knots[i + k + 1] - knots[i + 1])
            total = total + part * one(i + 1, k - 1)
        return total

    return np.array([one(i, degree) for i in range(len(knots) - degree - 1)]).T


@answers("10.7")
def on_whole_arrays(knots, degree, x):
    t, y = knots, x[:, None]
    b = np.where((t[:-1] <= y) & (y < t[1:]), 1.0, 0.0)
    for k in range(1, degree + 1):
        width = t[k:] - t[:-k]
        slope = np.where(width > 0, 1 / np.where(width > 0, width, 1), 0)
        b = (y - t[: -k - 1]) * slope[:-1] * b[:, :-1] + (t[k + 1 :] - y) * slope[1:] * b[:, 1:]
    return b
