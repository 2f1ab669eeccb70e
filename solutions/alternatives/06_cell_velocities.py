"""Right answers to notebook 06, written in other ways."""

import numpy as np

from fieldgrade.authoring.catalogue import answers


def doubled_area(q):
    """Twice the area, positive for corners listed counter-clockwise."""
    return np.linalg.det(q[1:] - q[0])


def size_of_sides(q):
    return np.array([np.linalg.norm(q[b] - q[c]) for b, c in ((1, 2), (2, 0), (0, 1))])


# 06.1 outward_normals


@answers("06.1")
def by_the_sense_of_rotation(q):
    along = np.roll(q, 1, axis=0) - np.roll(q, -1, axis=0)
    n = np.stack([along[:, 1], -along[:, 0]], axis=1) * np.sign(doubled_area(q))
    return n / np.linalg.norm(along, axis=1)[:, None]


@answers("06.1")
def by_projecting_the_corner_away(q):
    result = []
    for a in range(3):
        b, c = [q[k] for k in range(3) if k != a]
        t = (c - b) / np.linalg.norm(c - b)
        down = (b - q[a]) - ((b - q[a]) @ t) * t
        result.append(down / np.linalg.norm(down))
    return result


@answers("06.1")
def by_gradients(q):
    gradients = np.linalg.inv(np.column_stack([np.ones(3), q - q[0]]))[1:].T
    return -gradients / np.hypot(gradients[:, 0], gradients[:, 1])[:, None]


# 06.2 cell_velocity


@answers("06.2")
def by_normal_equations(q, v):
    n = by_the_sense_of_rotation(q)
    return np.linalg.solve(n.T @ n, n.T @ v)


@answers("06.2")
def by_the_pseudo_inverse(q, v):
    return np.linalg.pinv(by_gradients(q)) @ v


@answers("06.2")
def by_qr(q, v):
    w, r = np.linalg.qr(by_the_sense_of_rotation(q))
    return np.linalg.solve(r, w.T @ v)


@answers("06.2")
def at_the_symmedian_point(q, v):
    size = size_of_sides(q)
    k = np.average(q, axis=0, weights=size**2)
    return (size * v) @ (k - q) / abs(doubled_area(q))


@answers("06.2")
def without_the_outflow(q, v):
    size = size_of_sides(q)
    rest = v - size * (size @ v) / (size @ size)
    return np.linalg.solve(by_gradients(q)[:2], rest[:2])


# 06.3 defect


@answers("06.3")
def by_the_lengths(q, v):
    size = size_of_sides(q)
    return abs(size @ v) / np.sqrt(size @ size)


@answers("06.3")
def by_the_residual(q, v):
    n = by_the_sense_of_rotation(q)
    r = v - n @ (np.linalg.pinv(n) @ v)
    return np.sqrt(np.sum(r**2))


@answers("06.3")
def by_the_lost_direction(q, v):
    lost = np.linalg.svd(by_gradients(q))[0][:, 2]
    return np.abs(lost @ v)


# 06.4 circumcentre


@answers("06.4")
def by_barycentric_weights(q):
    a, b, c = size_of_sides(q) ** 2
    w = np.array([a * (b + c - a), b * (c + a - b), c * (a + b - c)])
    return q[0] + (w @ (q - q[0])) / w.sum()


@answers("06.4")
def in_closed_form(q):
    (bx, by), (cx, cy) = q[1] - q[0], q[2] - q[0]
    d = 2 * (bx * cy - by * cx)
    b2, c2 = bx**2 + by**2, cx**2 + cy**2
    return np.array([cy * b2 - by * c2, bx * c2 - cx * b2]) / d + q[0]


@answers("06.4")
def by_determinants_around_the_centroid(q):
    (ax, ay), (bx, by), (cx, cy) = q - q.mean(axis=0)
    a2, b2, c2 = ax**2 + ay**2, bx**2 + by**2, cx**2 + cy**2
    d = 2 * (ax * (by - cy) + bx * (cy - ay) + cx * (ay - by))
    x = a2 * (by - cy) + b2 * (cy - ay) + c2 * (ay - by)
    y = a2 * (cx - bx) + b2 * (ax - cx) + c2 * (bx - ax)
    return q.mean(axis=0) + np.array([x, y]) / d


@answers("06.4")
def by_complex_numbers(q):
    z = (q - q[2]) @ np.array([1, 1j])
    o = (z[0] * z[1] * (z[0] - z[1]).conjugate()) / (
        z[0].conjugate() * z[1] - z[0] * z[1].conjugate()
    )
    return q[2, 0] + o.real, q[2, 1] + o.imag


@answers("06.4")
def where_bisectors_meet(q):
    p, r = (q[1] - q[0]) / 2, (q[2] - q[0]) / 2
    a, b = np.array([-p[1], p[0]]), np.array([-r[1], r[0]])
    t = np.linalg.solve(np.column_stack([a, -b]), r - p)[0]
    return q[0] + p + t * a


# 06.5 truth


@answers("06.5")
def by_a_matrix(x, m, s):
    return (x - m) @ np.array([[s, -1], [1, s]]).T


@answers("06.5")
def in_the_complex_plane(x, m, s):
    u = (s + 1j) * ((x - m) @ np.array([1, 1j]))
    return np.stack([u.real, u.imag], axis=-1)


@answers("06.5")
def place_by_place(x, m, s):
    result = []
    for a, b in x - m:
        result.append([-b + s * a, a + s * b])
    return np.array(result)


# 06.6 errors


def flow(x, m, s):
    return by_a_matrix(x, m, s)


@answers("06.6")
def for_each_place_in_turn(points, triangles, s):
    m = np.mean(points, axis=0)
    squares = [[], [], []]
    for t in triangles:
        q = points[t]
        p = np.array([(q[1] + q[2]) / 2, (q[2] + q[0]) / 2, (q[0] + q[1]) / 2])
        n = by_gradients(q)
        u = np.linalg.pinv(n) @ np.sum(n * flow(p, m, s), axis=1)
        squares[0].append(np.sum((u - flow(in_closed_form(q)[None], m, s)[0]) ** 2))
        squares[1].append(np.sum((u - flow(q.mean(axis=0)[None], m, s)[0]) ** 2))
        squares[2].extend(np.sum((u - flow(q, m, s)) ** 2, axis=1))
    return [np.sqrt(np.mean(x)) for x in squares]


@answers("06.6")
def from_the_closed_form(points, triangles, s):
    rows = []
    for q in points[triangles]:
        o, k = in_closed_form(q), np.average(q, axis=0, weights=size_of_sides(q) ** 2)
        u = np.array([-o[1], o[0]]) + s * k
        rows.append([u - np.array([-y[1], y[0]]) - s * y for y in (o, q.mean(axis=0), *q)])
    squares = np.einsum("tpk,tpk->tp", rows, rows)
    return np.sqrt(np.array([squares[:, 0].mean(), squares[:, 1].mean(), squares[:, 2:].mean()]))


@answers("06.6")
def with_complex_arrays(points, triangles, s):
    z = points @ np.array([1, 1j])
    q = z[triangles] - z.mean()
    along = np.roll(q, 1, axis=1) - np.roll(q, -1, axis=1)
    n = 1j * along / np.abs(along)
    inside = (n * (q - np.roll(q, 1, axis=1)).conj()).real > 0
    n = np.where(inside, -n, n)
    rate = s + 1j
    v = (n.conj() * rate * (np.roll(q, 1, axis=1) + np.roll(q, -1, axis=1)) / 2).real
    total = (n**2).sum(axis=1)
    right = (n * v).sum(axis=1)
    u = 2 * (3 * right - total * right.conj()) / (9 - np.abs(total) ** 2)
    d, e = q[:, 1] - q[:, 0], q[:, 2] - q[:, 0]
    o = q[:, 0] + (np.abs(d) ** 2 * e - np.abs(e) ** 2 * d) / (d.conj() * e - d * e.conj())
    two = [np.abs(u - rate * place) ** 2 for place in (o, q.mean(axis=1))]
    return np.sqrt([two[0].mean(), two[1].mean(), np.mean(np.abs(u[:, None] - rate * q) ** 2)])


# 06.8 raviart_thomas


@answers("06.8")
def by_area_and_lengths(q, v, x):
    return np.sum((size_of_sides(q) * v)[:, None] * (x - q), axis=0) / abs(doubled_area(q))


@answers("06.8")
def term_by_term(q, v, x):
    w = np.zeros(2)
    for a in range(3):
        b, c = q[(a + 1) % 3], q[(a + 2) % 3]
        height = abs(doubled_area(q)) / np.hypot(*(c - b))
        w += v[a] / height * (x - q[a])
    return w


@answers("06.8")
def by_three_conditions(q, v, x):
    n = by_the_sense_of_rotation(q)
    middles = np.array([(q[a - 1] + q[a - 2]) / 2 for a in range(3)])
    c = np.linalg.solve(np.column_stack([n, np.sum(n * (middles - q[0]), axis=1)]), v)
    return c[:2] + c[2] * (x - q[0])
