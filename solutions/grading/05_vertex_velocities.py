"""What only a grader tries in notebook 05."""

import numpy as np
from scipy.linalg import qr

from fieldcheck.calls import Call
from fieldcheck.questions.q05_edges import mesh, part_of_a_mesh
from fieldgrade.authoring.hidden_cases import hidden


def fan(random, number):
    """Return a vertex with as many triangles around it, in random order and random directions."""
    angle = 2 * np.pi * (np.arange(number) + random.uniform(-0.3, 0.3, number)) / number
    rim = random.uniform(0.7, 1.1, (number, 1)) * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    place = random.permutation(number + 1)
    k = np.arange(number)
    triangles = place[np.stack([0 * k, k + 1, (k + 1) % number + 1], axis=1)]
    return np.vstack([[[0.0, 0.0]], rim])[np.argsort(place)], random.permuted(triangles, axis=1)


def sides(triangles):
    return np.array(
        sorted(
            {
                (min(t[k], t[k - 1]), max(t[k], t[k - 1]))
                for t in triangles.tolist()
                for k in range(3)
            }
        )
    )


@hidden(
    "05.1", "It must hold for every mesh, whichever way the corners of its triangles are listed."
)
def fans(seed):
    random = np.random.default_rng(seed + 1)
    small = tuple(
        Call("edges_of", (fan(random, n)[1],), f"{n} triangles around a vertex") for n in (4, 7)
    )
    larger = (
        (mesh(random, 11, 12)[1], "a mesh of more than a hundred vertices"),
        (mesh(random, 18, 17)[1], "a mesh of more than three hundred vertices"),
        (part_of_a_mesh(random, 40), "a part of a mesh with larger numbers"),
    )
    return (*small, *(Call("edges_of", (triangles,), case) for triangles, case in larger))


@hidden("05.2", "The midpoints and normals must be right for edges of every length and direction.")
def short_and_long(seed):
    random = np.random.default_rng(seed + 2)
    points, triangles = fan(random, 5)
    return (
        Call("midpoints_and_normals", (1e-10 * points, sides(triangles)), "a small mesh"),
        Call("midpoints_and_normals", (1e4 * points, sides(triangles)), "a large mesh"),
        *(
            Call("midpoints_and_normals", (p, sides(t)), f"a mesh of {len(t)} triangles")
            for p, t in (mesh(random, 9, 10), mesh(random, 13, 12))
        ),
    )


@hidden("05.3", "It must hold for any number of points.")
def many_points(seed):
    random = np.random.default_rng(seed + 7)
    return tuple(Call("rotation", (random.random((n, 2)),), f"{n} points") for n in (67, 101))


@hidden("05.4", "It must hold for any velocities, not only for those of a rotation.")
def one_edge(seed):
    random = np.random.default_rng(seed + 3)
    return (
        Call(
            "normal_velocities",
            (np.array([[2, 0]]), random.normal(size=(1, 2)), random.normal(size=(3, 2))),
            "one edge",
        ),
        *(
            Call(
                "normal_velocities",
                (
                    np.add.outer(np.arange(n), random.choice(80, 2, replace=False)) % 90,
                    random.normal(size=(n, 2)),
                    random.normal(size=(90, 2)),
                ),
                f"{n} edges",
            )
            for n in (67, 101)
        ),
    )


@hidden(
    "05.6", "It must hold for every vertex and every mesh, also where a ring takes in all of it."
)
def whole_mesh(seed):
    triangles = fan(np.random.default_rng(seed + 4), 6)[1]
    edges = sides(triangles)
    return tuple(
        Call("ring", (triangles, edges, vertex, rings), "a fan")
        for vertex, rings in ((0, 1), (3, 2), (5, 1))
    )


def independent_first(normals, y):
    """Return an order of edges in which the first six determine a field as well as any six do."""
    rows = np.column_stack([normals, normals[:, :1] * y, normals[:, 1:] * y])
    return qr(rows.T, pivoting=True, mode="r")[1]


@hidden("05.7", "It must hold for any number of edges.")
def many_edges(seed):
    random = np.random.default_rng(seed + 8)
    normals = random.normal(size=(101, 2))
    normals /= np.hypot(*normals.T)[:, np.newaxis]
    return (
        Call("system", (random.random((101, 2)), normals, random.random(2)), "101 edges"),
        Call("system", (random.random((67, 2)), normals[:67], random.random(2)), "67 edges"),
    )


@hidden(
    "05.8",
    "For the normal velocities of an affine field it must return the velocity of this field, for "
    "any positive weights.",
)
def exact_data(seed):
    random = np.random.default_rng(seed + 5)
    points, triangles = fan(random, 7)
    a, b = np.moveaxis(points[sides(triangles)], 1, 0)
    x = points[triangles[0, 0]]
    n = np.stack([a[:, 1] - b[:, 1], b[:, 0] - a[:, 0]], axis=1) / np.hypot(*(b - a).T)[:, None]
    a, b, n = (array[independent_first(n, (a + b) / 2 - x)] for array in (a, b, n))
    flow = random.normal(size=2) + (a + b) / 2 @ random.normal(size=(2, 2))
    w = random.uniform(0.5, 2, len(a))
    return (
        Call(
            "velocity",
            ((a + b) / 2, n, (flow * n).sum(axis=1), x, w),
            "an affine field around a vertex",
        ),
    )


@hidden(
    "05.9",
    "It must hold for every mesh; the rank knows neither where it lies nor the unit of length.",
)
def of_fans(seed):
    random = np.random.default_rng(seed + 6)
    return tuple(
        Call("ranks", (size * p, t, rings), f"{n} triangles")
        for n, size, rings in ((3, 1e-8, 1), (4, 1e5, 2), (5, 1.0, 1))
        for p, t in [fan(random, n)]
    )
