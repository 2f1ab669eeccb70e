"""Right answers to notebook 01, written in other ways."""

import numpy as np

from fieldgrade.authoring.catalogue import answers


@answers("01.1")
def by_loops(points):
    b = []
    for p in points:
        row = [1.0]
        for x in p:
            row.append(x)
        b.append(row)
    return b


@answers("01.1")
def by_insertion(points):
    return np.insert(points, 0, 1, axis=1)


@answers("01.1")
def into_an_empty_array(points):
    n, d = points.shape
    b = np.empty((n, d + 1))
    b[:, 0] = 1
    b[:, 1:] = points
    return b


@answers("01.1")
def as_a_matrix(points):
    return np.matrix(np.c_[np.ones(len(points)), points])


@answers("01.2")
def by_lstsq(points, values):
    return np.linalg.lstsq(np.insert(points, 0, 1, axis=1), values, rcond=None)[0]


@answers("01.2")
def by_qr(points, values):
    q, r = np.linalg.qr(np.column_stack([np.ones(len(points)), points]))
    return np.linalg.solve(r, q.T @ values)


@answers("01.2")
def by_pseudo_inverse(points, values):
    return np.linalg.pinv(np.column_stack([np.ones(len(points)), points])) @ values


@answers("01.2")
def by_means(points, values):
    center, mean = points.mean(axis=0), values.mean()
    slopes = np.linalg.lstsq(points - center, values - mean, rcond=None)[0]
    return np.array([mean - slopes @ center, *slopes])


@answers("01.3")
def constant_added(coefficients, x):
    return coefficients[0] + x @ coefficients[1:]


@answers("01.3")
def by_loop(coefficients, x):
    return [coefficients[0] + sum(c * t for c, t in zip(coefficients[1:], p)) for p in x]


@answers("01.3")
def by_einsum(coefficients, x):
    return np.einsum("mk,k->m", np.insert(x, 0, 1.0, axis=1), coefficients)


@answers("01.4")
def by_differences(points):
    moved = points - points[0]
    return 1 + np.linalg.matrix_rank(moved / max(np.abs(moved).max(), 1e-300), tol=1e-9)


@answers("01.4")
def by_singular_values(points):
    s = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    return 1 + int(np.sum(s > 1e-9 * (points.max(axis=0) - points.min(axis=0)).max()))


@answers("01.4")
def of_the_matrix_itself(points):
    extent = np.ptp(points, axis=0).max() or 1.0
    scaled = (points - points.mean(axis=0)) / extent
    return np.linalg.matrix_rank(np.insert(scaled, 0, 1.0, axis=1), tol=1e-9)


@answers("01.4")
def as_a_float_in_a_matrix(points):
    moved = points - points[0]
    scale = np.abs(moved).max()
    return np.array([[1.0 if scale == 0 else 1.0 + np.linalg.matrix_rank(moved / scale, tol=1e-9)]])


@answers("01.5")
def repeated(coefficients, x):
    return np.repeat(coefficients[np.newaxis, 1:], len(x), axis=0)


@answers("01.5")
def added_to_zeros(coefficients, x):
    return np.zeros_like(x) + coefficients[1:]


@answers("01.5")
def a_list_of_lists(coefficients, x):
    return [[float(c) for c in coefficients[1:]] for _ in x]


@answers("01.6")
def half_the_squared_norm(points, values, coefficients):
    return np.linalg.norm(coefficients[0] + points @ coefficients[1:] - values) ** 2 / 2


@answers("01.6")
def summed_by_a_loop(points, values, coefficients):
    total = 0.0
    for p, v in zip(points, values):
        total += (coefficients[0] + np.dot(p, coefficients[1:]) - v) ** 2 / 2
    return total


@answers("01.6")
def point_by_point(points, values, coefficients):
    psi = 0.0
    for x, value in zip(points, values, strict=True):
        fitted = coefficients[0]
        for slope, coordinate in zip(coefficients[1:], x, strict=True):
            fitted = fitted + slope * coordinate
        psi += (value - fitted) ** 2 / 2
    return psi
