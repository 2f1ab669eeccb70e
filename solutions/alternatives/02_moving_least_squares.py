"""Right answers to notebook 02, written in other ways."""

import numpy as np

from fieldgrade.authoring.catalogue import answers


def shape_functions(points, x, epsilon):
    """Return a with f(x) = a · values, from a basis around x, by QR."""
    w = 1 / (((x - points) ** 2).sum(axis=1) + epsilon**2)
    q, r = np.linalg.qr(np.insert(points - x, 0, 1.0, axis=1) * w[:, None])
    return w * (q @ np.linalg.solve(r.T, np.eye(len(r))[0]))


# 02.1


@answers("02.1")
def by_the_norm(points, x, epsilon):
    return (np.linalg.norm(x - points, axis=1) ** 2 + epsilon**2) ** -1.0


@answers("02.1")
def by_loops(points, x, epsilon):
    w = []
    for p in points:
        s = epsilon * epsilon
        for a, b in zip(p, x):
            s += (a - b) * (a - b)
        w.append(1 / s)
    return w


@answers("02.1")
def by_einsum(points, x, epsilon):
    d = points - x[None, :]
    return np.reciprocal(np.einsum("ik,ik->i", d, d) + float(epsilon) ** 2)


@answers("02.1")
def as_a_hypotenuse(points, x, epsilon):
    return 1 / np.hypot(np.linalg.norm(points - x, axis=1), epsilon) ** 2


@answers("02.1")
def from_matrices_as_complex_numbers(points, x, epsilon):
    d = np.matrix(points) - x
    return 1 / (np.diag(d * d.T) + epsilon**2) + 0j


# 02.2


@answers("02.2")
def by_matrices(points, values, w):
    b, v = np.matrix(np.insert(points, 0, 1, axis=1)), np.matrix(values).T
    w = np.matrix(np.diag(w))
    return np.array((b.T * w * w * b).I * (b.T * w * w * v)).ravel()


@answers("02.2")
def with_weights_of_at_most_one(points, values, w):
    w = w / w.max()
    return list(np.linalg.pinv(w[:, None] * np.insert(points, 0, 1, axis=1)) @ (w * values))


@answers("02.2")
def as_on_the_page(points, values, w):
    B = np.hstack((np.ones((len(points), 1)), points))
    W = np.diag(w)
    H = B.T @ W @ W @ B
    return np.linalg.inv(H) @ B.T @ W @ W @ values


@answers("02.2")
def by_lstsq(points, values, w):
    b = np.insert(points, 0, 1, axis=1)
    return np.linalg.lstsq(w[:, None] * b, w * values, rcond=None)[0]


@answers("02.2")
def by_qr(points, values, w):
    q, r = np.linalg.qr(np.insert(points, 0, 1, axis=1) * w[:, None])
    return np.linalg.solve(r, q.T @ (w * values))


@answers("02.2")
def by_weighted_means(points, values, w):
    m = w**2 / np.sum(w**2)
    center, mean = m @ points, m @ values
    d = points - center
    slopes = np.linalg.solve((d.T * m) @ d, (d.T * m) @ (values - mean))
    return np.array([mean - slopes @ center, *slopes])


@answers("02.2")
def point_by_point(points, values, w):
    q = points.shape[1] + 1
    h, g = np.zeros((q, q)), np.zeros(q)
    for p, v, s in zip(points, values, w):
        b = np.array([1, *p])
        h += s * s * np.outer(b, b)
        g += s * s * v * b
    return np.linalg.solve(h, g)


# 02.4


@answers("02.4")
def by_shape_functions(points, values, x, epsilon):
    return [shape_functions(points, place, epsilon) @ values for place in x]


@answers("02.4")
def with_the_basis_around_the_place(points, values, x, epsilon):
    result = np.zeros(len(x))
    for j in range(len(x)):
        b = np.insert(points - x[j], 0, 1, axis=1)
        w = 1 / (np.linalg.norm(points - x[j], axis=1) ** 2 + epsilon**2)
        result[j] = np.linalg.lstsq(w[:, None] * b, w * values, rcond=None)[0][0]
    return result


@answers("02.4")
def all_systems_at_once(points, values, x, epsilon):
    m = (((x[:, None] - points) ** 2).sum(axis=-1) + epsilon**2) ** -2.0
    b = np.insert(points, 0, 1, axis=1)
    h = np.einsum("mi,ia,ib->mab", m, b, b)
    c = np.linalg.solve(h, ((m * values) @ b)[..., None])[..., 0]
    return (np.insert(x, 0, 1, axis=1) * c).sum(axis=1)


@answers("02.4")
def with_normalized_weights(points, values, x, epsilon):
    result = []
    for place in x:
        m = (np.sum((points - place) ** 2, axis=1) + epsilon**2) ** -2.0
        m = m / m.sum()
        center, mean = m @ points, m @ values
        d = points - center
        slopes = np.linalg.solve((d.T * m) @ d, (d.T * m) @ values)
        result.append(mean + slopes @ (place - center))
    return np.array(result)


# 02.5


@answers("02.5")
def half_the_squared_norm(points, values, x, epsilon, coefficients):
    b = np.insert(points, 0, 1, axis=1)
    w = np.diag(1 / (np.sum((points - x) ** 2, axis=1) + epsilon**2))
    return np.linalg.norm(w @ b @ coefficients - w @ values) ** 2 / 2


@answers("02.5")
def summed_by_a_loop(points, values, x, epsilon, coefficients):
    total = 0.0
    for p, v in zip(points, values):
        w = 1 / (np.dot(x - p, x - p) + epsilon**2)
        total += w**2 * (coefficients[0] + np.dot(p, coefficients[1:]) - v) ** 2
    return total / 2


@answers("02.5")
def as_a_dot_product(points, values, x, epsilon, coefficients):
    s = ((x - points) ** 2).sum(axis=1) + epsilon**2
    e = (values - coefficients[0] - points @ coefficients[1:]) / s
    return e.dot(e) * 0.5


# 02.7


@answers("02.7")
def by_the_shape_functions(points, values, x, epsilon):
    rows = []
    for place in x:
        d = place - points
        w = 1 / (np.sum(d**2, axis=1) + epsilon**2)
        b = np.insert(-d, 0, 1, axis=1)
        c = np.linalg.lstsq(w[:, None] * b, w * values, rcond=None)[0]
        a = shape_functions(points, place, epsilon)
        rows.append(c[1:] - 4 * (a * w * (values - b @ c)) @ d)
    return np.array(rows)


@answers("02.7")
def by_a_complex_step(points, values, x, epsilon):
    step = 1e-30
    b = np.insert(points, 0, 1, axis=1)
    result = np.zeros(x.shape)
    for j, place in enumerate(x):
        for k in range(x.shape[1]):
            z = place.astype(complex)
            z[k] += 1j * step
            m = (np.sum((z - points) ** 2, axis=1) + epsilon**2) ** -2
            c = np.linalg.solve((b.T * m) @ b, b.T @ (m * values))
            result[j, k] = (c[0] + z @ c[1:]).imag / step
    return result


@answers("02.7")
def with_both_terms_of_the_product_rule(points, values, x, epsilon):
    B = np.insert(points, 0, 1, axis=1)
    rows = []
    for place in x:
        s = np.sum((points - place) ** 2, axis=1) + epsilon**2
        H = B.T @ np.diag(1 / s**2) @ B
        c = np.linalg.solve(H, B.T @ (values / s**2))
        row = []
        for k in range(len(place)):
            dM = np.diag(-2 / s**3 * 2 * (place[k] - points[:, k]))
            dc = np.linalg.solve(H, B.T @ dM @ values - B.T @ dM @ B @ c)
            row.append(c[k + 1] + dc[0] + dc[1:] @ place)
        rows.append(row)
    return rows


# 02.8


@answers("02.8")
def by_lstsq_and_shape_functions(points, queries, n, epsilon):
    v, t = np.sum(points, axis=1) ** n, np.sum(queries, axis=1) ** n
    c = np.linalg.lstsq(np.insert(points, 0, 1, axis=1), v, rcond=None)[0]
    plain = np.insert(queries, 0, 1, axis=1) @ c
    moving = np.array([shape_functions(points, p, epsilon) @ v for p in queries])
    return np.linalg.norm([plain - t, moving - t], axis=1) / np.sqrt(len(queries))


@answers("02.8")
def with_a_huge_epsilon_for_least_squares(points, queries, n, epsilon):
    v, t = np.sum(points, axis=1) ** n, np.sum(queries, axis=1) ** n
    huge = 1e7 * np.abs(points).max()
    fields = [[shape_functions(points, p, e) @ v for p in queries] for e in (huge, epsilon)]
    return [np.sqrt(np.mean((f - t) ** 2)) for f in np.array(fields)]


@answers("02.8")
def place_by_place(points, queries, n, epsilon):
    v = np.array([(p[0] + p[1]) ** n for p in points])
    ls = mls = 0.0
    huge = 1e6 * np.abs(points).max()
    for q in queries:
        t = (q[0] + q[1]) ** n
        ls += (shape_functions(points, q, huge) @ v - t) ** 2
        mls += (shape_functions(points, q, epsilon) @ v - t) ** 2
    return [(ls / len(queries)) ** 0.5, (mls / len(queries)) ** 0.5]


@answers("02.8")
def as_a_pair(points, queries, n, epsilon):
    def fitted(q, w):
        b = np.insert(points - q, 0, 1, axis=1)
        return np.linalg.lstsq(w[:, None] * b, w * points.sum(axis=1) ** n, rcond=None)[0][0]

    def error(weight):
        missed = [
            fitted(q, weight(np.sum((points - q) ** 2, axis=1))) - (q[0] + q[1]) ** n
            for q in queries
        ]
        return np.std(missed) if np.mean(missed) == 0 else np.sqrt(np.mean(np.square(missed)))

    return error(np.ones_like), error(lambda s: 1 / (s + epsilon**2))


# 02.9


@answers("02.9")
def by_deletion(points, values, epsilon):
    e = []
    for i, (p, v) in enumerate(zip(points, values)):
        a = shape_functions(np.delete(points, i, axis=0), p, epsilon)
        e.append(v - a @ np.delete(values, i))
    return e


@answers("02.9")
def by_slices(points, values, epsilon):
    e = []
    for i in range(len(points)):
        p, v = np.r_[points[:i], points[i + 1 :]], np.r_[values[:i], values[i + 1 :]]
        e.append(values[i] - shape_functions(p, points[i], epsilon) @ v)
    return tuple(e)


@answers("02.9")
def by_a_weight_of_zero(points, values, epsilon):
    e = np.empty(len(points))
    b = np.insert(points, 0, 1, axis=1)
    for i in range(len(points)):
        w = 1 / (np.sum((points - points[i]) ** 2, axis=1) + epsilon**2)
        w[i] = 0
        c = np.linalg.lstsq(w[:, None] * b, w * values, rcond=None)[0]
        e[i] = values[i] - b[i] @ c
    return e
