"""Right answers to notebook 07, written in other ways."""

import math

import numpy as np

from fieldgrade.authoring.catalogue import answers


@answers("07.1")
def corner_by_corner(center, radius, turn):
    rim = []
    for b in range(6):
        t = turn + math.radians(60 * b)
        rim.append([center[0] + radius * math.cos(t), center[1] + radius * math.sin(t)])
    return rim


@answers("07.1")
def by_complex_numbers(center, radius, turn):
    z = complex(*center) + radius * np.exp(
        1j * (turn + np.linspace(0, 2 * np.pi, 6, endpoint=False))
    )
    return np.stack([z.real, z.imag], axis=1)


@answers("07.1")
def by_turning(center, radius, turn):
    c, s = np.cos(np.pi / 3), np.sin(np.pi / 3)
    spoke, rim = radius * np.array([np.cos(turn), np.sin(turn)]), np.zeros((6, 2))
    for b in range(6):
        rim[b] = center + spoke
        spoke = np.array([c * spoke[0] - s * spoke[1], s * spoke[0] + c * spoke[1]])
    return rim


@answers("07.2")
def by_sums_and_differences(a, b, c):
    return np.linalg.solve(np.array([b - a, c - b]), [(b - a) @ (a + b) / 2, (c - b) @ (b + c) / 2])


@answers("07.2")
def by_angles(a, b, c):
    opposite = np.array([(b - c) @ (b - c), (c - a) @ (c - a), (a - b) @ (a - b)])
    share = opposite * (opposite.sum() - 2 * opposite)
    return share @ np.array([a, b, c]) / share.sum()


@answers("07.2")
def by_complex_formula(a, b, c):
    u, v = complex(*(b - a)), complex(*(c - a))
    q = u * v * (u - v).conjugate() / (u.conjugate() * v - u * v.conjugate())
    return a + [q.real, q.imag]


@answers("07.2")
def where_bisectors_meet(a, b, c):
    middle, way = (a + b) / 2, np.array([a[1] - b[1], b[0] - a[0]])
    t = (c - a) @ ((a + c) / 2 - middle) / ((c - a) @ way)
    return middle + t * way


@answers("07.3")
def cross_product(a, b, c):
    u, v = b - a, c - a
    return abs(u[0] * v[1] - u[1] * v[0]) / 2


@answers("07.3")
def shoelace(a, b, c):
    x, y = np.transpose([a - c, b - c, c - c])
    return np.abs(x @ np.roll(y, 1) - y @ np.roll(x, 1)) * 0.5


@answers("07.3")
def half_of_base_times_height(a, b, c):
    base = b - a
    across = np.array([-base[1], base[0]]) / math.hypot(*base)
    return math.hypot(*base) * abs(across @ (c - a)) / 2


@answers("07.3")
def determinant_of_edges(a, b, c):
    return np.abs(np.linalg.det([b - a, c - a])) / 2


@answers("07.4")
def from_the_normals(center, rim, corners, x):
    n = (rim - center) / np.linalg.norm(rim - center, axis=1)[:, None]
    out = []
    for a in range(len(rim)):
        pair = np.array([n[a], n[a + 1 - len(rim)]])
        out.append(abs(np.linalg.det(pair)) / np.prod(pair @ (corners[a] - x)))
    return out


@answers("07.4")
def all_at_once(center, rim, corners, x):
    j = rim - center
    k = np.roll(j, -1, axis=0)
    above = np.abs(j[:, 0] * k[:, 1] - j[:, 1] * k[:, 0])
    return above / (np.sum(j * (corners - x), axis=1) * np.sum(k * (corners - x), axis=1))


@answers("07.4")
def with_the_next_corner_for_the_next_neighbour(center, rim, corners, x):
    w = []
    for a in range(len(rim)):
        b = a + 1 - len(rim)
        j, k = rim[a] - center, rim[b] - center
        above = abs(j[0] * k[1] - j[1] * k[0])
        w.append(above / (j @ (corners[a] - x)) / (k @ (corners[b] - x)))
    return w


@answers("07.4")
def from_heights_of_neighbours(center, rim, corners, x):
    s = rim - center
    h = [0.5 * t @ t - t @ (x - center) for t in s]
    n = len(s)
    return [abs(np.linalg.det(s[[a, (a + 1) % n]])) / h[a] / h[(a + 1) % n] for a in range(n)]


@answers("07.5")
def place_by_place(center, rim, corners, x):
    rows = []
    for place in x:
        s = rim - center
        w = np.zeros(len(s))
        for a in range(len(s)):
            j, k = s[a], s[(a + 1) % len(s)]
            w[a] = (
                abs(j[0] * k[1] - j[1] * k[0])
                / (j @ (corners[a] - place))
                / (k @ (corners[a] - place))
            )
        rows.append(w / np.sum(w))
    return rows


@answers("07.5")
def by_products(center, rim, corners, x):
    s = rim - center
    t = np.roll(s, -1, axis=0)
    h = 0.5 * (s * s).sum(axis=1) - (x - center) @ s.T
    c = np.abs(s[:, 0] * t[:, 1] - s[:, 1] * t[:, 0]) / (h * np.roll(h, -1, axis=1))
    return (c.T / c.sum(axis=1)).T


@answers("07.5")
def by_einsum(center, rim, corners, x):
    s = rim - center
    t = np.concatenate([s[1:], s[:1]])
    away = corners[None] - x[:, None]
    w = np.abs(np.linalg.det(np.stack([s, t], axis=1)))
    w = w / (np.einsum("ak,mak->ma", s, away) * np.einsum("ak,mak->ma", t, away))
    return np.einsum("ma,m->ma", w, 1 / w.sum(axis=1))


@answers("07.6")
def point_by_point(center, corners, steps):
    r = math.dist((corners[0] + corners[1]) / 2, center)
    return [
        [
            center[0] + r / n * math.cos(2 * math.pi * n / steps),
            center[1] + r / n * math.sin(2 * math.pi * n / steps),
        ]
        for n in range(1, steps + 1)
    ]


@answers("07.6")
def in_the_complex_plane(center, corners, steps):
    n = 1 + np.arange(steps)
    r = np.hypot(*(corners[:2].mean(axis=0) - center))
    z = complex(*center) + r / n * np.exp(1j * n * 2 * np.pi / steps)
    return np.array([z.real, z.imag]).T


@answers("07.6")
def by_polar_coordinates(center, corners, steps):
    n = np.linspace(1, steps, steps)
    radius = 0.5 * np.linalg.norm(corners[0] - center + corners[1] - center) / n
    theta = np.deg2rad(360 / steps * n)
    return np.column_stack([center[0] + radius * np.cos(theta), center[1] + radius * np.sin(theta)])


def _coordinates(center, rim, corners, x):
    return np.array(by_einsum(center, rim, corners, x))


@answers("07.7")
def as_a_product(center, rim, corners, values, x):
    return _coordinates(center, rim, corners, x).dot(values)


@answers("07.7")
def as_a_sum(center, rim, corners, values, x):
    return [
        sum(w * f for w, f in zip(row, values)) for row in _coordinates(center, rim, corners, x)
    ]


@answers("07.7")
def above_the_first_value(center, rim, corners, values, x):
    omega = _coordinates(center, rim, corners, x)
    return values[0] + np.sum(omega * (values - values[0]), axis=1)


@answers("07.8")
def by_a_double_loop(center, rim, x):
    n, rows = len(rim), []
    for place in x:
        h = [0.5 * np.dot(s, s) - np.dot(s, place - center) for s in rim - center]
        c = []
        for a in range(n):
            product = abs(np.linalg.det([rim[a] - center, rim[(a + 1) % n] - center]))
            for b in range(n):
                if b not in (a, (a + 1) % n):
                    product *= h[b]
            c.append(product)
        rows.append(np.array(c) / sum(c))
    return rows


@answers("07.8")
def by_masked_products(center, rim, x):
    s = rim - center
    n = len(s)
    t = np.roll(s, -1, axis=0)
    h = 0.5 * (s**2).sum(axis=1) - np.einsum("bk,mk->mb", s, x - center)
    own = np.eye(n, dtype=bool) | np.roll(np.eye(n, dtype=bool), 1, axis=1)
    c = np.abs(s[:, 0] * t[:, 1] - s[:, 1] * t[:, 0]) * np.where(own, 1.0, h[:, None]).prod(axis=2)
    return c / c.sum(axis=1)[:, None]


@answers("07.8")
def by_bisectors(center, rim, x):
    n = len(rim)
    apart = 0.5 * (((x[:, None] - rim) ** 2).sum(axis=2) - ((x - center) ** 2).sum(axis=1)[:, None])
    apart = np.concatenate([apart, apart], axis=1)
    c = np.stack([apart[:, a + 2 : a + n].prod(axis=1) for a in range(n)], axis=1)
    c = c * [abs(np.linalg.det([rim[a - n] - center, rim[a + 1 - n] - center])) for a in range(n)]
    return c / c.sum(axis=1, keepdims=True)
