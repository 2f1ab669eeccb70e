"""Right answers to notebook 14, written in other ways."""

import numpy as np
from scipy.sparse.csgraph import connected_components

from fieldgrade.authoring.catalogue import answers


def edge(a, b):
    return (min(a, b), max(a, b))


def edges_of(t):
    return [edge(int(t[0]), int(t[1])), edge(int(t[1]), int(t[2])), edge(int(t[2]), int(t[0]))]


# 14.1 Weld


@answers("14.1")
def by_two_loops(points, tolerance):
    place = []
    for p in points:
        for j, q in enumerate(points):
            if np.sqrt(((p - q) ** 2).sum()) <= tolerance:
                place.append(j)
                break
    return place


@answers("14.1")
def by_squares(points, tolerance):
    gap = ((points[:, :, None] - points.T[None]) ** 2).sum(axis=1)
    return np.array([np.flatnonzero(row <= tolerance**2)[0] for row in gap])


@answers("14.1")
def the_least_of_those_near(points, tolerance):
    n = len(points)
    near = np.linalg.norm(points[None] - points[:, None], axis=-1) <= tolerance
    return np.where(near, np.arange(n), n).min(axis=1)


@answers("14.1")
def earlier_ones_in_turn(points, tolerance):
    place = np.arange(len(points))
    for i, p in enumerate(points):
        for j in range(i):
            if np.hypot.reduce(points[j] - p) <= tolerance:
                place[i] = j
                break
    return place


# 14.2 Counts


@answers("14.2")
def by_dictionary(triangles):
    number = {}
    for t in triangles:
        for e in edges_of(t):
            number[e] = number.get(e, 0) + 1
    return [number[e] for t in triangles for e in edges_of(t)]


@answers("14.2")
def by_a_matrix(triangles):
    n = triangles.max() + 1
    table = np.zeros((n, n))
    for k in range(3):
        np.add.at(table, (triangles[:, k], triangles[:, (k + 1) % 3]), 1)
    table = table + table.T
    return np.array([table[t[k], t[k - 2]] for t in triangles for k in range(3)])


@answers("14.2")
def by_one_number(triangles):
    low = np.minimum(triangles, np.roll(triangles, -1, axis=1))
    high = np.maximum(triangles, np.roll(triangles, -1, axis=1))
    key = low * 100000 + high
    return (key.ravel()[:, None] == key.ravel()).sum(axis=1)


# 14.3 Euler


@answers("14.3")
def by_sets(triangles):
    vertices = {int(v) for v in triangles.ravel()}
    edges = {e for t in triangles for e in edges_of(t)}
    return len(triangles) + len(vertices) - len(edges)


@answers("14.3")
def by_shares(triangles):
    number = by_dictionary(triangles)
    at = np.bincount(triangles.ravel())
    return round(
        np.sum(1 / at[at > 0] * at[at > 0]) - np.sum(1.0 / np.array(number)) + len(triangles)
    )


@answers("14.3")
def by_adjacency(triangles):
    n = triangles.max() + 1
    meet = np.zeros((n, n), dtype=bool)
    for a, b, c in triangles:
        meet[[a, b, c], [b, c, a]] = True
    meet |= meet.T
    return meet.any(axis=0).sum() - np.triu(meet).sum() + triangles.shape[0]


# 14.4 Loops


@answers("14.4")
def by_walking(n, triangles):
    number = np.reshape(by_dictionary(triangles), (-1, 3))
    nearby = {}
    for t, counts in zip(triangles, number):
        for (a, b), k in zip(edges_of(t), counts):
            if k == 1:
                nearby.setdefault(a, []).append(b)
                nearby.setdefault(b, []).append(a)
    loop = -np.ones(n, dtype=int)
    for start in sorted(nearby):
        v = start if loop[start] < 0 else None
        while v is not None:
            loop[v] = start
            v = next((w for w in nearby[v] if loop[w] < 0), None)
    return loop


@answers("14.4")
def by_union_find(n, triangles):
    boss = list(range(n))

    def find(v):
        return v if boss[v] == v else find(boss[v])

    on = set()
    for t, counts in zip(triangles, np.reshape(by_dictionary(triangles), (-1, 3))):
        for (a, b), k in zip(edges_of(t), counts):
            if k == 1:
                on |= {a, b}
                low, high = sorted((find(a), find(b)))
                boss[high] = low
    return np.array([find(v) if v in on else -1 for v in range(n)])


@answers("14.4")
def by_components_of_a_graph(n, triangles):
    step = np.zeros((n, n))
    for t, counts in zip(triangles, np.reshape(by_dictionary(triangles), (-1, 3))):
        for (a, b), k in zip(edges_of(t), counts):
            if k == 1:
                step[[a, b, a, b], [b, a, a, b]] = 1
    _, part = connected_components(step)
    least = np.array([np.argmax(part == k) for k in part])
    return np.where(step.any(axis=1), least, -1)


# 14.5 Fans


@answers("14.5")
def by_pairs_of_triangles(n, triangles):
    count = []
    for v in range(n):
        left = [set(map(int, t)) for t in triangles if v in t]
        number = 0
        while left:
            number += 1
            fan = left.pop()
            while True:
                more = [t for t in left if len(t & fan) > 1]
                if not more:
                    break
                for t in more:
                    left.remove(t)
                    fan |= t
        count.append(number)
    return count


@answers("14.5")
def by_rank_of_a_matrix(n, triangles):
    count = np.zeros(n, dtype=int)
    for v in range(n):
        rim = [[w for w in t if w != v] for t in triangles if v in t]
        names = sorted({int(w) for pair in rim for w in pair})
        laplace = np.zeros((len(names), len(names)))
        for a, b in rim:
            i, j = names.index(a), names.index(b)
            laplace[[i, j, i, j], [i, j, j, i]] += [1, 1, -1, -1]
        count[v] = len(names) - (np.linalg.matrix_rank(laplace) if names else 0)
    return count


@answers("14.5")
def corner_by_corner(n, triangles):
    fan = {(t, v): (t, v) for t, three in enumerate(triangles) for v in map(int, three)}
    changed = True
    at = {}
    for t, three in enumerate(triangles):
        for e in edges_of(three):
            at.setdefault(e, []).append(t)
    while changed:
        changed = False
        for e, some in at.items():
            for v in e:
                least = min(fan[t, v] for t in some)
                for t in some:
                    changed = changed or fan[t, v] != least
                    fan[t, v] = least
    return np.array([len({f for (_, w), f in fan.items() if w == v}) for v in range(n)])


# 14.6 Orientation


@answers("14.6")
def by_a_walk(points, triangles):
    m = len(triangles)
    runs = [[(int(t[k]), int(t[(k + 1) % 3])) for k in range(3)] for t in triangles]
    at = {}
    for t in range(m):
        for a, b in runs[t]:
            at.setdefault(edge(a, b), []).append(t)
    sign = [0] * m
    for first in range(m):
        if sign[first]:
            continue
        sign[first], part, two_sided = 1, [first], True
        for t in part:
            for a, b in runs[t]:
                for s in at[edge(a, b)]:
                    if s == t:
                        continue
                    wanted = sign[t] if (b, a) in runs[s] else -sign[t]
                    if sign[s] == 0:
                        sign[s] = wanted
                        part.append(s)
                    two_sided &= sign[s] == wanted
        if not two_sided:
            for t in part:
                sign[t] = 9
    return np.array([0 if s == 9 else s for s in sign])


@answers("14.6")
def by_a_linear_system(points, triangles):
    m = len(triangles)
    there = triangles + 1j * np.roll(triangles, -1, axis=1)
    back = 1j * there.conj()
    alike = np.zeros((m, m))
    for k in range(3):
        for j in range(3):
            alike += there[:, [k]] == back[:, j]
            alike -= there[:, [k]] == there[:, j]
    np.fill_diagonal(alike, 0)
    count, label = connected_components(alike)
    sign = np.zeros(m)
    for k in range(count):
        part = np.flatnonzero(label == k)
        own = alike[np.ix_(part, part)]
        laplace = np.diag(abs(own).sum(axis=1)) - own
        x = np.append(1, np.linalg.solve(laplace[1:, 1:], -laplace[1:, 0]))
        if np.allclose(laplace @ x, 0, atol=1e-6):
            sign[part] = np.round(x)
    return sign


@answers("14.6")
def by_constraints(points, triangles):
    m = len(triangles)
    boss, parity = list(range(m)), [1] * m

    def find(t):
        sign = 1
        while boss[t] != t:
            sign *= parity[t]
            t = boss[t]
        return t, sign

    bad, at = set(), {}
    for t, three in enumerate(triangles):
        for a, b in zip(three, np.roll(three, -1)):
            e = edge(int(a), int(b))
            if e in at:
                s, before = at[e]
                relation = -1 if before == (int(a), int(b)) else 1
                (r, x), (q, y) = find(s), find(t)
                if r == q and x * y != relation:
                    bad.add((s, t))
                elif r != q:
                    boss[q], parity[q] = r, x * y * relation
            at[e] = (t, (int(a), int(b)))
    roots = [find(t) for t in range(m)]
    one_sided = {find(s)[0] for s, _ in bad}
    first = {}
    for r, x in roots:
        first.setdefault(r, x)
    return [0 if r in one_sided else x * first[r] for r, x in roots]


# 14.7 Flat triangles


@answers("14.7")
def by_distance_from_the_longest_side(points, triangles, tolerance):
    result = []
    for t in triangles:
        p = points[t]
        length, k = max((np.linalg.norm(p[i] - p[i - 1]), i) for i in range(3))
        along, across = p[k] - p[k - 1], p[k - 2] - p[k - 1]
        result.append(length == 0 or np.linalg.norm(np.cross(along, across)) / length <= tolerance)
    return result


@answers("14.7")
def least_of_three_heights(points, triangles, tolerance):
    p = points[triangles]
    heights = []
    for k in range(3):
        a, b, c = p[:, k], p[:, k - 1], p[:, k - 2]
        along = b - a
        length = np.sqrt((along**2).sum(axis=1))
        unit = along / np.where(length > 0, length, 1)[:, None]
        foot = ((c - a) * unit).sum(axis=1)[:, None] * unit
        heights.append(np.where(length > 0, np.linalg.norm(c - a - foot, axis=1), 0))
    return (np.min(heights, axis=0) <= tolerance) * 1.0


@answers("14.7")
def with_where(points, triangles, tolerance):
    a, b, c = (points[triangles[:, k]] for k in range(3))
    area = 0.5 * np.sqrt((np.cross(a - b, a - c) ** 2).sum(axis=1))
    longest = np.max([np.linalg.norm(e, axis=1) for e in (a - b, b - c, c - a)], axis=0)
    return np.divide(2 * area, longest, out=np.zeros(len(area)), where=longest > 0) <= tolerance


# 14.8 Pierced


@answers("14.8")
def by_solving(start, end, corners):
    result = []
    for p, q, (a, b, c) in zip(start, end, corners):
        matrix = np.column_stack([b - a, c - a, p - q])
        if np.linalg.det(matrix) == 0:
            result.append(False)
            continue
        u, v, t = np.linalg.solve(matrix, p - a)
        result.append(1e-12 < t < 1 - 1e-12 and u > 0 and v > 0 and u + v < 1)
    return result


@answers("14.8")
def by_cross_products(start, end, corners):
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    n = np.cross(b - a, c - a)
    high, low = ((start - a) * n).sum(axis=1), ((end - a) * n).sum(axis=1)
    part = high / (high - low)
    place = start + part[:, None] * (end - start)
    inside = np.ones(len(a), dtype=bool)
    for e, f in ((a, b), (b, c), (c, a)):
        inside &= (np.cross(f - e, place - e) * n).sum(axis=1) > 0
    return inside & (part > 0) & (part < 1)


@answers("14.8")
def by_volumes_one_by_one(start, end, corners):
    def volume(a, b, c, d):
        return np.dot(np.cross(a - d, b - d), c - d)

    result = np.zeros(len(start), dtype=int)
    for k, (p, q) in enumerate(zip(start, end)):
        a, b, c = corners[k]
        rim = [volume(p, q, a, b) > 0, volume(p, q, b, c) > 0, volume(p, q, c, a) > 0]
        opposite = np.sign(volume(a, b, c, p)) * np.sign(volume(a, b, c, q)) < 0
        result[k] = opposite and len(set(rim)) == 1
    return result
