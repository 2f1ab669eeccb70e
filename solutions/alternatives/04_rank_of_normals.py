"""Right answers to notebook 04, written in other ways."""

import numpy as np

from fieldgrade.authoring.catalogue import answers


def matrix(points, normals):
    return np.array([np.kron([1, *p], n) for p, n in zip(points, normals)])


# 04.1 The matrix


@answers("04.1")
def row_by_row(points, normals):
    b = []
    for p, n in zip(points, normals):
        row = list(n)
        for coordinate in p:
            row += [coordinate * component for component in n]
        b.append(row)
    return b


@answers("04.1")
def by_einsum(points, normals):
    b = np.column_stack([np.ones(len(points)), points])
    return np.einsum("nk,nd->nkd", b, normals).reshape(len(points), -1)


@answers("04.1")
def by_kronecker_products(points, normals):
    return matrix(points, normals)


@answers("04.1")
def from_the_form_by_components(points, normals):
    d = points.shape[1]
    b = np.insert(points, 0, 1.0, axis=1)
    apart = np.hstack([np.diag(normals[:, k]) @ b for k in range(d)])
    order = np.arange(d * (d + 1)).reshape(d, d + 1).T.ravel()
    return apart[:, order]


# 04.2 The rank


def centred(points):
    moved = points - points[0]
    return moved / np.abs(moved).max()


@answers("04.2")
def by_singular_values(points, normals):
    s = np.linalg.svd(matrix(centred(points), normals), compute_uv=False)
    return int(np.sum(s > 1e-9 * s[0]))


@answers("04.2")
def by_elimination(points, normals):
    b = matrix(centred(points), normals)
    rank = 0
    while b.size and np.abs(b).max() > 1e-8:
        i, j = np.unravel_index(np.argmax(np.abs(b)), b.shape)
        b = b - np.outer(b[:, j], b[i]) / b[i, j]
        b = np.delete(np.delete(b, i, axis=0), j, axis=1)
        rank += 1
    return rank


@answers("04.2")
def one_field_at_a_time(points, normals):
    columns = matrix((points - points.mean(axis=0)) / np.ptp(points, axis=0).max(), normals).T
    found = []
    for column in columns:
        for q in found:
            column = column - (q @ column) * q
        for q in found:
            column = column - (q @ column) * q
        size = np.sqrt(column @ column)
        if size > 1e-8:
            found.append(column / size)
    return len(found)


# 04.3 The tangent field


@answers("04.3")
def of_another_size_and_sign(points, normals):
    return -7.3 * np.linalg.svd(matrix(points, normals), full_matrices=True)[2][5]


@answers("04.3")
def by_a_complete_qr(points, normals):
    b = matrix(points, normals)
    chosen = []
    for row in b:
        if np.linalg.matrix_rank(np.array([*chosen, row]), tol=1e-8) > len(chosen):
            chosen.append(row)
    return np.linalg.qr(np.array(chosen).T, mode="complete")[0][:, -1]


@answers("04.3")
def by_projection(points, normals):
    b = matrix(points, normals)
    left = np.eye(6) - np.linalg.pinv(b, rcond=1e-9) @ b
    return left[:, np.argmax(np.diag(left))]


# 04.4 The normals


@answers("04.4")
def to_the_other_side(points, c):
    u = c[:2] + points @ np.array([c[2:4], c[4:]])
    v, w = u.T
    return np.transpose([w, -v]) / np.hypot(v, w)[:, None]


@answers("04.4")
def by_angles(points, c):
    x, y = points.T
    angle = np.arctan2(c[1] + c[3] * x + c[5] * y, c[0] + c[2] * x + c[4] * y)
    return np.column_stack([np.sin(angle), -np.cos(angle)])


@answers("04.4")
def by_complex_numbers(points, c):
    u = (c[0::2] + 1j * 0) @ np.insert(points, 0, 1.0, axis=1).T
    w = c[1::2] @ np.insert(points, 0, 1.0, axis=1).T
    n = 1j * (u + 1j * w)
    n = n / abs(n)
    return np.column_stack([n.real, n.imag])


@answers("04.4")
def point_by_point(points, c):
    normals = []
    for k, p in enumerate(points):
        u = c[0:2] + p[0] * c[2:4] + p[1] * c[4:6]
        n = np.array([u[1], -u[0]]) * (-1) ** k
        normals.append(n / np.sqrt(n @ n))
    return normals


# 04.5 The obvious conditions


@answers("04.5")
def by_cross_products(points, normals):
    for n in normals:
        p = points[np.abs(n[0] * normals[:, 1] - n[1] * normals[:, 0]) > 1e-9]
        if len(p) < 3:
            return False
        longest = max(np.linalg.norm(q - p[0]) for q in p)
        area = [abs(np.linalg.det([q - p[0], r - p[0]])) for q in p for r in p]
        if max(area) <= 1e-9 * longest:
            return False
    return True


@answers("04.5")
def by_distances_from_the_longest_line(points, normals):
    for x, y in normals:
        seen = points[np.abs(normals @ [-y, x]) > 1e-9]
        if not len(seen):
            return False
        away = seen - seen[0]
        far = away[np.argmax(np.hypot(*away.T))]
        across = np.abs(away @ [-far[1], far[0]])
        if across.max() <= 1e-9 * np.hypot(*far):
            return False
    return True


@answers("04.5")
def by_groups_of_directions(points, normals):
    groups = []
    for i, (x, y) in enumerate(normals):
        for group in groups:
            if abs(normals[group[0]] @ [-y, x]) < 1e-9:
                group.append(i)
                break
        else:
            groups.append([i])
    b = np.insert(points, 0, 1.0, axis=1)
    rest = [np.delete(b, group, axis=0) for group in groups]
    return int(min(np.linalg.matrix_rank(r, tol=1e-9) if len(r) else 0 for r in rest) == 3)


# 04.6 Stars


@answers("04.6")
def edge_by_edge(center, ring):
    k = len(ring)
    edges = [(center, q) for q in ring] + [(ring[i], ring[(i + 1) % k]) for i in range(k)]
    points, normals = [], []
    for a, b in edges:
        points.append(a + (b - a) / 2)
        x, y = b - a
        normals.append(np.array([y, -x]) / np.hypot(x, y))
    return np.array(points), np.array(normals)


@answers("04.6")
def outward_on_the_rim(center, ring):
    following = ring[np.arange(1, len(ring) + 1) % len(ring)]
    rim = following - ring
    normals = np.append(ring - center, rim, axis=0) @ np.array([[0, 1], [-1, 0]])
    points = np.append(ring + center, ring + following, axis=0) / 2
    normals = normals / np.sqrt(np.square(normals).sum(axis=1, keepdims=True))
    normals[len(ring) :] *= np.sign(np.sum(normals[len(ring) :] * (ring - center), axis=1))[:, None]
    return points, normals


@answers("04.6")
def by_complex_numbers_too(center, ring):
    z, o = ring @ [1, 1j], center @ np.array([1, 1j])
    edges = np.append(z - o, np.append(z[1:], z[0]) - z)
    middle = np.append((z + o) / 2, (z + np.append(z[1:], z[0])) / 2)
    n = edges / np.abs(edges) * -1j
    return np.stack([middle.real, middle.imag], axis=1), np.stack([n.real, n.imag], axis=1)


# 04.7 The conic


def local(vertices):
    return centred(vertices - vertices.mean(axis=0) + 0.0)


@answers("04.7")
def by_products_of_the_basis(vertices):
    b = np.insert(local(vertices), 0, 1.0, axis=1)
    products = np.einsum("nj,nk->njk", b, b).reshape(len(b), 9)
    return np.linalg.matrix_rank(products, tol=1e-9)


@answers("04.7")
def with_each_coordinate_of_size_one(vertices):
    moved = vertices - vertices.mean(axis=0)
    x, y = (moved / np.ptp(moved, axis=0)).T
    return np.linalg.matrix_rank(np.array([x**0, x, y, x**2, x * y, y**2]), tol=1e-9)


@answers("04.7")
def six_less_the_conics(vertices):
    x, y = local(vertices).T
    m = np.stack([x**i * y**j for i in range(3) for j in range(3 - i)], axis=-1)
    s = np.zeros(6)
    s[: min(m.shape)] = np.linalg.svd(m, compute_uv=False)
    return 6 - int(np.sum(s < 1e-9))


@answers("04.6")
def as_one_array(center, ring):
    ends = [(center, r) for r in ring] + [(ring[i - 1], ring[i]) for i in [*range(1, len(ring)), 0]]
    a, b = np.swapaxes(ends, 0, 1)
    d = (b - a)[:, ::-1] * [1, -1]
    return np.array([(a + b) / 2, d / np.linalg.norm(d, axis=1, keepdims=True)])


@answers("04.3")
def as_a_list(points, normals):
    columns = [normals, points[:, [0]] * normals, points[:, [1]] * normals]
    b = np.hstack(columns)
    return (1e-3 * np.linalg.svd(b)[2][-1]).tolist()
