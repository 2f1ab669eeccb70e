"""Right answers to notebook 08, written in other ways."""

import math

import numpy as np

from fieldgrade.authoring.catalogue import answers


@answers("08.1")
def triple_product(a, b, c, d):
    return abs(np.dot(np.cross(b - a, c - a), d - a)) / 6


@answers("08.1")
def a_third_of_base_times_height(a, b, c, d):
    normal = np.cross(b - a, c - a)
    base = np.linalg.norm(normal) / 2
    height = abs(normal @ (d - a)) / np.linalg.norm(normal)
    return base * height / 3


@answers("08.1")
def determinant_of_four(a, b, c, d):
    rows = np.column_stack([np.array([a, b, c, d]) - d, np.ones(4)])
    return np.abs(np.linalg.det(rows)) / math.factorial(3)


@answers("08.1")
def product_of_the_heights(a, b, c, d):
    return np.prod(np.abs(np.diag(np.linalg.qr(np.array([b - a, c - a, d - a]).T)[1]))) / 6


@answers("08.2")
def by_sums_and_differences(a, b, c, d):
    p = np.array([a, b, c, d])
    edges, sums = p[1:] - p[:-1], p[1:] + p[:-1] - 2 * d
    return d + np.linalg.solve(edges, (edges * sums).sum(axis=1) / 2)


@answers("08.2")
def by_cross_products(a, b, c, d):
    u, v, w = b - a, c - a, d - a
    above = (u @ u) * np.cross(v, w) + (v @ v) * np.cross(w, u) + (w @ w) * np.cross(u, v)
    return a + above / (2 * u @ np.cross(v, w))


@answers("08.2")
def by_bordered_distances(a, b, c, d):
    p = np.array([a, b, c, d])
    m = np.ones((5, 5))
    m[1:, 1:] = ((p[:, None] - p) ** 2).sum(axis=2)
    m[0, 0] = 0
    return np.linalg.solve(m, [1, 0, 0, 0, 0])[1:] @ p


@answers("08.4")
def by_determinant_of_edges(center, tips):
    spokes = tips - center
    return abs(np.linalg.det(spokes)) / np.prod(np.linalg.norm(spokes, axis=1))


@answers("08.4")
def by_scalar_products(center, tips):
    n = (tips - center) / np.sqrt(((tips - center) ** 2).sum(axis=1, keepdims=True))
    return np.sqrt(np.linalg.det(n @ n.T))


@answers("08.4")
def by_triple_product(center, tips):
    j, k, m = [(tip - center) / math.dist(tip, center) for tip in tips]
    return abs(j @ np.cross(k, m))


@answers("08.7")
def from_the_normals(center, neighbors, cells, corners, x):
    out = []
    for cell, p in zip(cells, corners):
        n = neighbors[cell] - center
        n = n / np.linalg.norm(n, axis=1)[:, None]
        out.append(abs(np.linalg.det(n)) / np.prod(n @ (p - x)))
    return np.array(out, dtype=object)


@answers("08.7")
def all_at_once(center, neighbors, cells, corners, x):
    s = neighbors[cells] - center
    return np.abs(np.linalg.det(s)) / np.einsum("abk,ak->ab", s, corners - x).prod(axis=1)


@answers("08.7")
def from_heights_of_neighbours(center, neighbors, cells, corners, x):
    s = neighbors - center
    h = 0.5 * (s**2).sum(axis=1) - s @ (x - center)
    return [abs(np.linalg.det(s[c])) / (h[c[0]] * h[c[1]] * h[c[2]]) for c in cells]


@answers("08.8")
def as_a_matrix(center, neighbors, x):
    s = neighbors - center
    return 0.5 * (s**2).sum(axis=1)[:, None] - s @ (x - center).T


@answers("08.8")
def from_the_midpoints(center, neighbors, x):
    return np.einsum("bk,bmk->bm", neighbors - center, ((center + neighbors) / 2)[:, None] - x)


@answers("08.8")
def by_squared_distances(center, neighbors, x):
    out = []
    for tip in neighbors:
        out.append(
            [(math.dist(place, tip) ** 2 - math.dist(place, center) ** 2) / 2 for place in x]
        )
    return out


@answers("08.10")
def by_a_triple_loop(center, neighbors, cells, x):
    s, rows = neighbors - center, []
    for place in x:
        c = []
        for cell in cells:
            product = abs(np.linalg.det(s[cell]))
            for b in range(len(s)):
                if b not in cell:
                    product *= s[b] @ s[b] / 2 - s[b] @ (place - center)
            c.append(product)
        rows.append(np.array(c) / np.sum(c))
    return rows


@answers("08.10")
def by_masked_products(center, neighbors, cells, x):
    s = neighbors - center
    h = (s**2).sum(axis=1) / 2 - (x - center) @ s.T
    own = (cells[:, :, None] == np.arange(len(s))).any(axis=1)
    c = np.abs(np.linalg.det(s[cells])) * np.where(own, 1.0, h[:, None]).prod(axis=2)
    return c / c.sum(axis=1)[:, None]


@answers("08.10")
def by_bisectors(center, neighbors, cells, x):
    apart = ((x[:, None] - neighbors) ** 2).sum(axis=2) - ((x - center) ** 2).sum(axis=1)[:, None]
    c = []
    for cell in cells:
        others = [b for b in range(len(neighbors)) if b not in cell]
        c.append(abs(np.linalg.det(neighbors[cell] - center)) * apart[:, others].prod(axis=1))
    return np.transpose(c / np.sum(c, axis=0))
