"""Right answers to notebook 11, written in other ways."""

import numpy as np

from fieldgrade.authoring.catalogue import answers


def gaps(points):
    return np.linalg.norm(points[None] - points[:, None], axis=-1)


# 11.1 Normals


@answers("11.1")
def by_singular_values(points, k):
    n, q = [], []
    for row in gaps(points):
        near = points[np.argsort(row)[:k]]
        _, s, v = np.linalg.svd(near - near.mean(axis=0))
        n.append(-v[-1])
        q.append(1 - (s[-1] / s[-2]) ** 2)
    return np.array(n), np.array(q)


@answers("11.1")
def all_at_once(points, k):
    near = points[np.argsort(gaps(points), axis=1)[:, :k]]
    near = near - near.mean(axis=1, keepdims=True)
    size, axes = np.linalg.eigh(np.einsum("nki,nkj->nij", near, near) / k)
    return axes[..., 0], 1 - size[:, 0] / size[:, 1]


@answers("11.1")
def by_numpy_s_covariance(points, k):
    n, q = np.empty(points.shape), np.empty(len(points))
    for i, p in enumerate(points):
        order = sorted(range(len(points)), key=lambda j: ((points[j] - p) ** 2).sum())
        near = (points[order[:k]] - p).T
        size, axes = np.linalg.eig(np.cov(near))
        rank = np.argsort(size)
        n[i] = axes[:, rank[0]]
        q[i] = (size[rank[1]] - size[rank[0]]) / size[rank[1]]
    return n, q


# 11.2 The graph


@answers("11.2")
def by_ranks(points, k):
    rank = np.argsort(np.argsort(gaps(points), axis=1), axis=1)
    near = (rank > 0) & (rank < k)
    return near | near.T


@answers("11.2")
def by_sets(points, k):
    g = gaps(points)
    near = [{int(j) for j in np.argsort(row)[:k]} - {i} for i, row in enumerate(g)]
    n = len(points)
    return [[int(j in near[i] or i in near[j]) for j in range(n)] for i in range(n)]


@answers("11.2")
def by_the_kth_distance(points, k):
    g = gaps(points)
    far = np.sort(g, axis=1)[:, k - 1]
    return ((g <= np.maximum(far[:, None], far)) & (g > 0)).astype(float)


# 11.3 Orientation


def with_roots(points, normals, edges):
    n, todo = normals.copy(), set(range(len(normals)))
    at = {i: [] for i in todo}
    for a, b in edges:
        at[a].append(b)
        at[b].append(a)
    while todo:
        root = max(todo, key=lambda i: points[i, -1])
        n[root] *= 1 if n[root, -1] >= 0 else -1
        stack = [root]
        todo.discard(root)
        while stack:
            a = stack.pop()
            for b in at[a]:
                if b in todo:
                    n[b] *= 1 if n[a] @ n[b] >= 0 else -1
                    todo.discard(b)
                    stack.append(b)
    return n


@answers("11.3")
def by_kruskal(points, normals, linked):
    boss = list(range(len(points)))

    def find(i):
        while boss[i] != i:
            i = boss[i]
        return i

    cost = 1 - np.abs(normals @ normals.T)
    edges = []
    for a, b in sorted(map(tuple, np.argwhere(np.triu(linked))), key=lambda e: cost[e]):
        if find(a) != find(b):
            boss[find(b)] = find(a)
            edges.append((int(a), int(b)))
    return with_roots(points, normals, edges)


@answers("11.3")
def by_boruvka(points, normals, linked):
    cost = np.where(np.asarray(linked) > 0, 1 - np.abs(normals @ normals.T), np.inf)
    part, edges = np.arange(len(points)), set()
    while True:
        best = {}
        for a in range(len(points)):
            row = np.where(part != part[a], cost[a], np.inf)
            b = int(np.argmin(row))
            if row[b] < best.get(part[a], (np.inf,))[0]:
                best[part[a]] = (row[b], min(a, b), max(a, b))
        if not best:
            return with_roots(points, normals, edges)
        for _, a, b in best.values():
            edges.add((a, b))
            part[part == part[b]] = part[a]


@answers("11.3")
def by_a_simple_search(points, normals, linked):
    n = np.array(normals)
    done = []
    rest = list(np.argsort(-points[:, -1]))
    while rest:
        pairs = [(1 - abs(n[a] @ n[b]), a, b) for a in done for b in rest if linked[a, b]]
        if pairs:
            _, a, b = min(pairs)
            if np.dot(n[a], n[b]) < 0:
                n[b] *= -1
        else:
            b = rest[0]
            n[b] *= np.sign(n[b, -1])
        rest.remove(b)
        done.append(b)
    return n


# 11.4 Points beside


@answers("11.4")
def all_lengths_at_once(points, normals, distance):
    lengths = np.full((2, len(points)), 1.0 * distance)
    while True:
        x = points + np.array([1, -1])[:, None, None] * lengths[..., None] * normals
        nearest = ((x[:, :, None] - points) ** 2).sum(axis=-1).argmin(axis=-1)
        wrong = nearest != np.arange(len(points))
        if not wrong.any():
            return lengths.T
        lengths[wrong] *= 0.5


@answers("11.4")
def by_the_largest_ball(points, normals, distance):
    offset = points[None] - points[:, None]
    square = (offset**2).sum(axis=2)
    result = []
    for sign in (1, -1):
        toward = np.einsum("ijd,id->ij", offset, sign * normals)
        room = np.full(square.shape, np.inf)
        room[toward > 0] = square[toward > 0] / (2 * toward[toward > 0])
        m = np.maximum(np.ceil(np.log2(distance / room.min(axis=1))), 0)
        result.append(distance / 2**m)
    return np.stack(result, axis=1)


@answers("11.4")
def with_a_helper(points, normals, distance):
    def length(i, n):
        d = distance
        while True:
            others = np.delete(points, i, axis=0)
            if np.linalg.norm(others - (points[i] + d * n), axis=1).min() > d * np.linalg.norm(n):
                return d
            d = d / 2

    return [[length(i, n), length(i, -n)] for i, n in enumerate(normals)]


# 11.5 The coefficients


def cubes(sites):
    return gaps(sites) ** 3


@answers("11.5")
def by_the_null_space(sites, values):
    p = np.insert(sites, 0, 1.0, axis=1)
    q, r = np.linalg.qr(p, mode="complete")
    k = p.shape[1]
    z, a = q[:, k:], cubes(sites)
    lam = z @ np.linalg.solve(z.T @ a @ z, z.T @ values)
    return lam, np.linalg.solve(r[:k], q[:, :k].T @ (values - a @ lam))


@answers("11.5")
def constant_first_in_the_system(sites, values):
    n, d = sites.shape
    p = np.column_stack([np.ones(n), sites])
    m = np.zeros((n + d + 1, n + d + 1))
    m[d + 1 :, : d + 1], m[: d + 1, d + 1 :], m[d + 1 :, d + 1 :] = p, p.T, cubes(sites)
    solution = np.linalg.inv(m) @ np.append(np.zeros(d + 1), values)
    return solution[d + 1 :], solution[: d + 1]


@answers("11.5")
def about_the_middle(sites, values):
    middle = sites.mean(axis=0)
    p = np.insert(sites - middle, 0, 1.0, axis=1)
    k = p.shape[1]
    m = np.block([[cubes(sites - middle), p], [p.T, np.zeros((k, k))]])
    solution = np.linalg.solve(m, np.pad(values, (0, k)))
    lam, c = solution[:-k], solution[-k:].copy()
    c[0] -= c[1:] @ middle
    return lam, c


# 11.6 The field


@answers("11.6")
def place_by_place(x, sites, lam, c):
    values, gradients = [], []
    for y in x:
        f, g = c[0] + y @ c[1:], np.array(c[1:])
        for s, weight in zip(sites, lam):
            r = np.sqrt((y - s) @ (y - s))
            f, g = f + weight * r**3, g + 3 * weight * r * (y - s)
        values.append(f)
        gradients.append(g)
    return values, gradients


@answers("11.6")
def by_sums_of_products(x, sites, lam, c):
    r = gaps(np.vstack([x, sites]))[: len(x), len(x) :]
    w = r * lam
    values = (w * r * r).sum(axis=1) + np.insert(x, 0, 1.0, axis=1) @ c
    y, s = x - sites[0], sites - sites[0]
    return values, 3 * (w.sum(axis=1)[:, None] * y - w @ s) + c[1:]


@answers("11.6")
def by_complex_steps(x, sites, lam, c):
    def f(y):
        square = ((y[:, None] - sites) ** 2).sum(axis=2)
        return square**1.5 @ lam + c[0] + y @ c[1:]

    steps = 1e-30j * np.eye(x.shape[1])
    gradients = np.column_stack([f(x + s).imag / 1e-30 for s in steps])
    return f(x), np.where(np.isnan(gradients), 0, gradients)


# 11.7 Newton


def slope(x, sites, lam, c):
    offset = x[:, None] - sites
    r = np.linalg.norm(offset, axis=2)
    return r**3 @ lam + c[0] + x @ c[1:], ((3 * lam * r)[..., None] * offset).sum(axis=1) + c[1:]


@answers("11.7")
def with_unit_normals(x, sites, lam, c, steps):
    for _ in range(steps):
        f, g = slope(x, sites, lam, c)
        size = np.linalg.norm(g, axis=1)
        x = x - (f / size)[:, None] * (g / size[:, None])
    return x


@answers("11.7")
def by_pseudo_inverse(x, sites, lam, c, steps):
    places = [np.array(y) for y in x]
    for i in range(len(places)):
        for _ in range(steps):
            f, g = slope(places[i][None], sites, lam, c)
            places[i] = places[i] - np.linalg.pinv(g) @ f
    return np.array(places)


@answers("11.7")
def by_recursion(x, sites, lam, c, steps):
    if steps == 0:
        return x
    f, g = slope(x, sites, lam, c)
    step = np.einsum("m,md->md", f / np.einsum("md,md->m", g, g), g)
    return by_recursion(x - step, sites, lam, c, steps - 1)


# 11.8 Marching squares


@answers("11.8")
def by_arrays(values):
    corners = np.array([[0.0, 0], [1, 0], [1, 1], [0, 1]])
    after = np.roll(values, -1, axis=1)
    side = np.roll(corners, -1, axis=0) - corners
    place = corners + (values / (values - after))[..., None] * side
    down, up = np.argmax((values > 0) & (after < 0), 1), np.argmax((values < 0) & (after > 0), 1)
    rows = np.arange(len(values))
    return np.stack([place[rows, down], place[rows, up]], axis=1)


@answers("11.8")
def side_by_side(values):
    result = []
    for a, b, c, d in values:
        sides = [
            (a, b, lambda t: (t, 0)),
            (b, c, lambda t: (1, t)),
            (c, d, lambda t: (1 - t, 1)),
            (d, a, lambda t: (0, 1 - t)),
        ]
        start = next(at(f / (f - g)) for f, g, at in sides if f > 0 > g)
        end = next(at(f / (f - g)) for f, g, at in sides if f < 0 < g)
        result.append([start, end])
    return np.array(result)


@answers("11.8")
def turned_afterwards(values):
    corners = np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
    result = []
    for f in values:
        ends = []
        for i in range(4):
            j = i - 3
            if np.sign(f[i]) != np.sign(f[j]):
                weight = abs(f[j]) / (abs(f[i]) + abs(f[j]))
                ends.append(weight * corners[i] + (1 - weight) * corners[j])
        (p, q), k = ends, np.argmax(f)
        run, to = q - p, corners[k] - p
        result.append([p, q] if run[0] * to[1] - run[1] * to[0] > 0 else [q, p])
    return result
