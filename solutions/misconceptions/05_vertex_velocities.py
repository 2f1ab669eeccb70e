"""Wrong answers to notebook 05, each with the sentence for the student."""

import numpy as np

from fieldgrade.authoring.catalogue import answers


def pairs_of(triangles):
    """All edges, the lower end first."""
    found = {
        (min(t[a], t[b]), max(t[a], t[b]))
        for t in triangles.tolist()
        for a, b in ((0, 1), (1, 2), (0, 2))
    }
    return np.array(sorted(found))


def turned(vectors):
    return vectors[..., ::-1] * np.array([-1.0, 1.0])


def ends(points, edges):
    return points[edges[:, 0]], points[edges[:, 1]]


def middles_and_normals(points, edges):
    a, b = ends(points, edges)
    return (a + b) / 2, turned(b - a) / np.hypot(*(b - a).T)[:, None]


def triangles_in_ring(triangles, vertex, rings):
    corners = {vertex}
    for _ in range(rings):
        near = [t for t in triangles.tolist() if corners & set(t)]
        corners = {c for t in near for c in t}
    return near, corners


def edges_in_ring(triangles, edges, vertex, rings):
    near, _ = triangles_in_ring(triangles, vertex, rings)
    return np.array([any(set(e) <= set(t) for t in near) for e in edges.tolist()])


def rows(p, n, x):
    y = np.pad(p - x, ((0, 0), (1, 0)), constant_values=1)
    return np.einsum("ai,aj->aij", y, n).reshape(len(p), -1)


def solved(b, v):
    return np.linalg.lstsq(b, v, rcond=None)[0]


def ranks_by(points, triangles, chosen, matrix=rows, tol=1e-6):
    """The rank at each vertex, of the edges that `chosen` picks."""
    edges = pairs_of(triangles)
    p, n = middles_and_normals(points, edges)
    found = []
    for i, x in enumerate(points):
        near = chosen(edges, i)
        b = matrix(p[near], n[near], x)
        found.append(np.linalg.matrix_rank(b / np.sqrt((b**2).sum(axis=0)), tol=tol))
    return np.array(found)


# 05.1 edges_of


@answers("05.1", named=False)
def keys_of_two_digits(triangles):
    """With a hundred vertices or more, two edges may have the same key."""
    pairs = np.sort(np.concatenate([triangles[:, [k, k - 1]] for k in range(3)]), axis=1)
    keys = np.unique(100 * pairs[:, 0] + pairs[:, 1])
    return np.stack([keys // 100, keys % 100], axis=1)


@answers("05.1")
def third_side_missing(triangles):
    """Only two sides of each triangle are listed. A triangle with the corners (a, b, c) has three
    sides. Which pair is missing?
    """
    pairs = np.concatenate([triangles[:, :2], triangles[:, 1:]])
    found = np.unique(np.sort(pairs, axis=1), axis=0)
    return found


@answers("05.1")
def inner_edges_twice(triangles):
    """The sides of all triangles are listed, so an edge between two triangles occurs twice. How can
    you find out that two pairs are the same edge?
    """
    return np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])


@answers("05.1")
def every_pair_of_vertices(triangles):
    """Every pair of vertices is listed, even of vertices far apart. An edge is a side of a
    triangle.
    """
    vertices = np.unique(triangles)
    i, j = np.triu_indices(len(vertices), 1)
    return np.stack([vertices[i], vertices[j]], axis=1)


@answers("05.1")
def side_from_a_corner_to_itself(triangles):
    """Some rows hold the same vertex twice. Check the indices of the three sides: one of them joins
    a corner to itself.
    """
    a, b, c = triangles.T
    pairs = np.concatenate([np.stack(s, axis=1) for s in ((a, b), (b, c), (c, c))])
    return np.unique(np.sort(pairs, axis=1), axis=0)


@answers("05.1")
def directions_told_apart(triangles):
    """An edge that two triangles list in opposite directions occurs twice, as (i, j) and as (j, i).
    Either order is right, but it must be the same for both triangles.
    """
    return np.unique(
        np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=0
    )


@answers("05.1", named=False)
def number_of_a_pair(triangles):
    """Different pairs have the same number i T + j where vertex numbers exceed the number T of
    triangles, as in a part of a mesh.
    """
    pairs = np.sort(np.vstack([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]))
    number = pairs[:, 0] * max(3, len(triangles)) + pairs[:, 1]
    return pairs[np.unique(number, return_index=True)[1]]


# 05.2 midpoints_and_normals


@answers("05.2")
def normals_as_long_as_the_edges(points, edges):
    """The normals are perpendicular to the edges, but as long as the edges. Which length does (5.1)
    require?
    """
    a, b = ends(points, edges)
    return (a + b) / 2, turned(b - a)


@answers("05.2")
def tangents(points, edges):
    """These are unit vectors *along* the edges. What must the scalar product of a normal and its
    edge be?
    """
    a, b = ends(points, edges)
    return (a + b) / 2, (b - a) / np.hypot(*(b - a).T)[:, None]


@answers("05.2")
def components_exchanged_without_a_sign(points, edges):
    """The two components were exchanged, but none or both changed their signs. This is a reflection
    and not a rotation by 90 degrees. Compute the scalar product of your normal and its edge.
    """
    a, b = ends(points, edges)
    return (a + b) / 2, (b - a)[:, ::-1] / np.hypot(*(b - a).T)[:, None]


@answers("05.2")
def one_length_for_all(points, edges):
    """All normals were divided by the same number, the norm of the whole array. Each must be
    divided by its own length. `numpy.linalg.norm` has an argument `axis`.
    """
    a, b = ends(points, edges)
    return (a + b) / 2, turned(b - a) / np.linalg.norm(b - a)


@answers("05.2")
def sum_of_the_ends(points, edges):
    """The normals are right. The midpoints are twice as large as they must be: the sum of the two
    ends was not divided by two.
    """
    a, b = ends(points, edges)
    return a + b, middles_and_normals(points, edges)[1]


@answers("05.2")
def half_the_difference(points, edges):
    """The normals are right. The midpoints are half the difference of the ends, which does not
    depend on the position of the edge. Look at the sign in (5.1).
    """
    a, b = ends(points, edges)
    return (b - a) / 2, middles_and_normals(points, edges)[1]


@answers("05.2")
def normals_of_the_places(points, edges):
    """The unit vectors are perpendicular to the position vectors of the midpoints. They must be
    perpendicular to the edges.
    """
    a, b = ends(points, edges)
    middle = (a + b) / 2
    return middle, turned(middle) / np.maximum(np.hypot(*middle.T), 1e-30)[:, None]


# 05.3 rotation


@answers("05.3")
def about_the_origin(points):
    """This is the rotation about the origin: the mean m was not subtracted. At which point must the
    velocity be zero?
    """
    return turned(points)


@answers("05.3")
def clockwise(points):
    """This is the rotation in the other direction. Apply J of (5.2) to (1, 0) by hand. Which
    direction is the result?
    """
    return -turned(points - points.mean(axis=0))


@answers("05.3")
def exchanged_without_a_sign(points):
    """The components were exchanged, but no sign was changed. This field is a reflection and not a
    rotation. Look at the signs in J.
    """
    return (points - points.mean(axis=0))[:, ::-1].copy()


@answers("05.3")
def away_from_the_mean(points):
    """The vectors from the mean were not rotated, so this fluid flows away from m in all
    directions. What does J do with a vector?
    """
    return points - points.mean(axis=0)


@answers("05.3")
def one_mean_for_both_coordinates(points):
    """The mean is one number, taken over both coordinates. m has two coordinates. Along which axis
    of the array is the mean?
    """
    return turned(points - points.mean())


@answers("05.3")
def middle_of_the_box(points):
    """The rotation is about the centre of the bounding box of the points, which is not their mean.
    Look at (5.2).
    """
    return turned(points - (points.min(axis=0) + points.max(axis=0)) / 2)


@answers("05.3")
def of_unit_speed(points):
    """Every velocity has length one. In a rotation the speed is proportional to the distance from
    the centre. Do not normalize the vectors.
    """
    u = turned(points - points.mean(axis=0))
    return u / np.hypot(*u.T)[:, None]


# 05.4 normal_velocities


@answers("05.4")
def sum_of_the_two_ends(edges, normals, u):
    """These numbers are twice as large as they must be: the velocities at the two ends were added,
    but not averaged.
    """
    return np.einsum("ak,ak->a", normals, u[edges[:, 0]] + u[edges[:, 1]])


@answers("05.4")
def first_end_only(edges, normals, u):
    """Only the velocity at the first end of each edge is used. (5.3) uses the mean
    of both ends.
    """
    return np.einsum("ak,ak->a", normals, u[edges[:, 0]])


@answers("05.4")
def difference_of_the_ends(edges, normals, u):
    """The velocities at the two ends are subtracted. Then a constant velocity gives zero. Which
    sign stands between them in (5.3)?
    """
    return np.einsum("ak,ak->a", normals, u[edges[:, 1]] - u[edges[:, 0]]) / 2


@answers("05.4")
def speeds(edges, normals, u):
    """These are the lengths of the velocities at the midpoints, without the normals. What does the
    dot in (5.3) mean?
    """
    return np.hypot(*(u[edges].mean(axis=1)).T)


@answers("05.4")
def products_not_added(edges, normals, u):
    """Normals and velocities are multiplied entry by entry, but the products are not added. A
    scalar product is one number for each edge.
    """
    return normals * u[edges].mean(axis=1)


@answers("05.4")
def along_the_edge(edges, normals, u):
    """This is the component *along* each edge: the normal was rotated by 90 degrees. (5.3) is the
    component across the edge.
    """
    return np.einsum("ak,ak->a", turned(normals), u[edges].mean(axis=1))


@answers("05.4")
def without_its_sign(edges, normals, u):
    """The absolute values are right, but the signs are missing. Opposite flows would have the same
    data.
    """
    return np.abs(np.einsum("ak,ak->a", normals, u[edges].mean(axis=1)))


@answers("05.4")
def every_normal_with_every_edge(edges, normals, u):
    """Each normal was multiplied by the velocity of each edge. The right numbers are on the
    diagonal. Compute the scalar products row by row.
    """
    return normals @ u[edges].mean(axis=1).T


# 05.6 ring


@answers("05.6")
def edges_at_the_vertex_only(triangles, edges, vertex, rings):
    """These are only the edges that end in the vertex, or in a vertex of the previous ring. The
    outer sides of the triangles are missing. A triangle has three sides.
    """
    corners = [vertex] if rings == 1 else list(triangles_in_ring(triangles, vertex, rings - 1)[1])
    return np.isin(edges, corners).any(axis=1)


@answers("05.6")
def both_ends_in_the_ring(triangles, edges, vertex, rings):
    """Some of these edges belong to no triangle of the ring, though both their ends are vertices of
    it. A triangle of the ring has a corner in the ring before. Draw a vertex beside one with three
    triangles.
    """
    corners = list(triangles_in_ring(triangles, vertex, rings)[1])
    return np.isin(edges, corners).all(axis=1)


@answers("05.6")
def in_another_order(triangles, edges, vertex, rings):
    """These are the right edges in the order of the sorted edges. An entry must belong to the edge
    in the same row of the argument `edges`.
    """
    order = np.lexsort(np.sort(edges, axis=1).T[::-1])
    return edges_in_ring(triangles, edges, vertex, rings)[order]


@answers("05.6")
def outer_edges_only(triangles, edges, vertex, rings):
    """The edges that end in the vertex are missing. All three sides of each triangle belong to the
    ring.
    """
    return edges_in_ring(triangles, edges, vertex, rings) & (edges != vertex).all(axis=1)


@answers("05.6")
def always_one_ring(triangles, edges, vertex, rings):
    """This is the one-ring for every number of rings. What must be repeated for each further ring,
    and from which vertices does it start?
    """
    return edges_in_ring(triangles, edges, vertex, 1)


@answers("05.6")
def one_ring_too_many(triangles, edges, vertex, rings):
    """This is one ring more than requested. How often does your code look for triangles, also
    before a loop? For one ring it must happen once.
    """
    return edges_in_ring(triangles, edges, vertex, rings + 1)


@answers("05.6")
def across_sides_only(triangles, edges, vertex, rings):
    """The first ring is right, but the next ones are too small: they have only triangles that share
    a whole side with the previous ring. By the definition above one common corner is enough.
    """
    near = [set(t) for t in triangles.tolist() if vertex in t]
    for _ in range(rings - 1):
        near = [set(t) for t in triangles.tolist() if any(len(set(t) & s) >= 2 for s in near)]
    return np.array([any(set(e) <= t for t in near) for e in edges.tolist()])


@answers("05.6")
def numbers_of_the_edges(triangles, edges, vertex, rings):
    """These are the numbers of the edges in the ring. The question asks for True or False for each
    edge of the mesh.
    """
    return np.flatnonzero(edges_in_ring(triangles, edges, vertex, rings))


# 05.7 system


@answers("05.7")
def places_not_from_the_vertex(midpoints, normals, x):
    """The midpoints enter as they are, not relative to the vertex. Then c₀ is the velocity at the
    origin. What is y in (5.4)?
    """
    return rows(midpoints, normals, 0 * x)


@answers("05.7")
def from_midpoint_to_vertex(midpoints, normals, x):
    """The last four columns have the wrong sign: these are the vectors from the midpoints to the
    vertex. Which direction has y in (5.4)?
    """
    return rows(-midpoints, normals, -x)


@answers("05.7")
def by_components(midpoints, normals, x):
    """The numbers are right, but the columns stand in another order: first those of the first
    component of the normal, then those of the second. In (5.6) the unknowns are ordered by the
    vectors c₀, c₁, c₂.
    """
    return rows(midpoints, normals, x)[:, [0, 2, 4, 1, 3, 5]]


@answers("05.7")
def constant_last(midpoints, normals, x):
    """The columns of the normals alone stand last. Then the first two unknowns are slopes, not the
    velocity at the vertex. Compare the order in (5.6).
    """
    return np.roll(rows(midpoints, normals, x), -2, axis=1)


@answers("05.7")
def each_coordinate_with_its_component(midpoints, normals, x):
    """There are four columns: each coordinate was multiplied by one component of the normal only.
    In (5.6) each coordinate multiplies the *whole* normal.
    """
    return np.hstack([normals, (midpoints - x) * normals])


@answers("05.7")
def a_row_for_each_component(midpoints, normals, x):
    """This is the system for velocities with both components known: two rows for each edge, and no
    normals. Where are the normals in (5.6)?
    """
    y = np.pad(midpoints - x, ((0, 0), (1, 0)), constant_values=1)
    return np.kron(y, np.eye(2))


@answers("05.7")
def without_the_constant(midpoints, normals, x):
    """The first two columns are missing, those of c₀. They belong to the velocity at the vertex,
    the result.
    """
    return rows(midpoints, normals, x)[:, 2:]


@answers("05.7")
def coordinates_exchanged(midpoints, normals, x):
    """The two coordinates of y are exchanged: the third and fourth columns must have y₁, and the
    last two y₂.
    """
    return rows(midpoints, normals, x)[:, [0, 1, 4, 5, 2, 3]]


@answers("05.7")
def normals_and_places_side_by_side(midpoints, normals, x):
    """There are four columns, the normals and the positions side by side. In (5.6) the coordinates
    *multiply* the normals, first y₁ and then y₂.
    """
    return np.hstack([normals, midpoints - x])


# 05.8 velocity


@answers("05.8", named=False)
def light_equations_dropped(midpoints, normals, v, x, w):
    """Equations of small weight are measurements too, and were dropped."""
    k = w > 0.1 * w.max()
    y = midpoints[k] - x
    b = np.hstack([normals[k], y[:, :1] * normals[k], y[:, 1:] * normals[k]])
    return np.linalg.lstsq(w[k, None] * b, w[k] * v[k], rcond=None)[0][:2]


@answers("05.8", named=False)
def lighter_equations_dropped(midpoints, normals, v, x, w):
    """Equations of small weight are measurements too, and were dropped."""
    k = w > 1e-3 * w.max()
    b = rows(midpoints[k], normals[k], x)
    return solved(w[k, None] * b, w[k] * v[k])[:2]


@answers("05.8", named=False)
def inverse_of_the_normal_equations(midpoints, normals, v, x, w):
    """The normal equations have the squares of the singular values: those below 10⁻⁸ are lost."""
    b = w[:, None] * rows(midpoints, normals, x)
    return (np.linalg.pinv(b.T @ b, rcond=1e-15) @ b.T @ (w * v))[:2]


@answers("05.8")
def weights_only_on_the_left(midpoints, normals, v, x, w):
    """The matrix is multiplied by the weights, but the right-hand side is not. Then affine fields
    are not reproduced. What is the right-hand side of (5.7)?
    """
    return solved(w[:, None] * rows(midpoints, normals, x), v)[:2]


@answers("05.8")
def weights_forgotten(midpoints, normals, v, x, w):
    """This is plain least squares: the weights have no effect. Where does W enter (5.7)?"""
    return solved(rows(midpoints, normals, x), v)[:2]


@answers("05.8")
def weights_not_squared(midpoints, normals, v, x, w):
    """Each row is multiplied by the root of its weight, or the normal equations contain the weights
    once. In (5.7) each row is multiplied by w itself, so normal equations contain w².
    """
    root = np.sqrt(w)
    return solved(root[:, None] * rows(midpoints, normals, x), root * v)[:2]


@answers("05.8")
def weights_squared_twice(midpoints, normals, v, x, w):
    """The weights enter with their fourth power. Multiplying the equations by w already makes the
    squared residuals count by w².
    """
    return solved(w[:, None] ** 2 * rows(midpoints, normals, x), w**2 * v)[:2]


@answers("05.8")
def mean_of_the_projections(midpoints, normals, v, x, w):
    """This is a weighted mean of the vectors v n. Each of them is only the projection of the
    velocity on one normal. Solve the equations (5.5) together.
    """
    return (w * v) @ normals / w.sum()


@answers("05.8")
def one_velocity_for_all_edges(midpoints, normals, v, x, w):
    """A constant velocity was fitted, without slopes. Then a rotation is not reproduced. How many
    unknowns has (5.4)?
    """
    return solved(w[:, None] * normals, w * v)


@answers("05.8")
def at_the_origin(midpoints, normals, v, x, w):
    """This is the value of the fitted field at the origin of the coordinates, not at the vertex.
    Use positions relative to the vertex, as in (5.4).
    """
    return solved(w[:, None] * rows(midpoints, normals, 0 * x), w * v)[:2]


@answers("05.8")
def evaluated_at_the_coordinates_of_the_vertex(midpoints, normals, v, x, w):
    """The coordinates of the vertex were inserted for y. But y is the position relative to the
    vertex: what is it at the vertex itself?
    """
    c = solved(w[:, None] * rows(midpoints, normals, x), w * v)
    return c[:2] + x[0] * c[2:4] + x[1] * c[4:]


@answers("05.8")
def last_unknowns(midpoints, normals, v, x, w):
    """These are the last two unknowns, the slopes along the second axis. Which unknowns are the
    velocity at the vertex?
    """
    return solved(w[:, None] * rows(midpoints, normals, x), w * v)[4:]


@answers("05.8")
def all_six_unknowns(midpoints, normals, v, x, w):
    """These are all six coefficients. The question asks for the velocity at the vertex: insert y =
    0 into (5.4).
    """
    return solved(w[:, None] * rows(midpoints, normals, x), w * v)


@answers("05.8")
def first_six_equations(midpoints, normals, v, x, w):
    """This field satisfies the first six equations and ignores all others. Least squares uses all
    of them.
    """
    return np.linalg.solve(rows(midpoints, normals, x)[:6], v[:6])[:2]


@answers("05.8", named=False)
def normal_equations_solved(midpoints, normals, v, x, w):
    """If the edges do not determine the six unknowns, the matrix of the normal equations is
    singular: the numbers are rounding errors, or an exception is raised.
    """
    b = w[:, None] * rows(midpoints, normals, x)
    return np.linalg.solve(b.T @ b, b.T @ (w * v))[:2]


@answers("05.8", named=False)
def small_singular_values_dropped(midpoints, normals, v, x, w):
    """Singular values below a hundredth of the largest one were treated as zero."""
    b = w[:, None] * rows(midpoints, normals, x)
    return np.linalg.lstsq(b, w * v, rcond=1e-2)[0][:2]


@answers("05.8", named=False)
def edges_without_flow_left_out(midpoints, normals, v, x, w):
    """An edge with the normal velocity zero gives an equation like every other edge."""
    y, rows = midpoints - x, normals * w[:, None]
    matrix = np.column_stack([rows, y[:, :1] * rows, y[:, 1:] * rows])[v != 0]
    return np.linalg.lstsq(matrix, (v * w)[v != 0], rcond=None)[0][:2]


# 05.9 ranks


@answers("05.9")
def spokes_only(points, triangles, rings):
    """These are the ranks of the edges that end in the vertex alone, so no rank is six. Which edges
    are in the ring?
    """
    return ranks_by(points, triangles, lambda edges, i: (edges == i).any(axis=1))


@answers("05.9")
def counted(points, triangles, rings):
    """This is the number of edges, at most six. Equations may depend on each other: an inner vertex
    with three triangles has six edges and a lower rank. Compute the rank of the matrix.
    """
    edges = pairs_of(triangles)
    return np.array(
        [min(6, edges_in_ring(triangles, edges, i, rings).sum()) for i in range(len(points))]
    )


@answers("05.9")
def all_edges_of_the_mesh(points, triangles, rings):
    """The ranks are six nearly everywhere, which is too much at some vertices. Does the matrix have
    only the edges of the requested number of rings, and do its rows contain the normals?
    """
    return ranks_by(points, triangles, lambda edges, i: np.ones(len(edges), dtype=bool))


@answers("05.9")
def rank_of_the_places(points, triangles, rings):
    """This is the rank of the matrix with the rows (1, y₁, y₂), which is three everywhere. The
    normals have no influence. Use B′ of (5.6).
    """
    return np.full(len(points), 3)


@answers("05.9")
def yes_or_no(points, triangles, rings):
    """The function returns 1 if the rank is six, else 0. The question asks for the rank."""
    edges = pairs_of(triangles)
    all_ranks = ranks_by(points, triangles, lambda _, i: edges_in_ring(triangles, edges, i, rings))
    return (all_ranks == 6).astype(int)


@answers("05.9")
def one_ring_whatever_is_asked(points, triangles, rings):
    """These are the ranks for one ring, even if more are requested. Where do you use the number of
    rings?
    """
    edges = pairs_of(triangles)
    return ranks_by(points, triangles, lambda _, i: edges_in_ring(triangles, edges, i, 1))


@answers("05.9", named=False)
def vertices_of_the_ring_counted(points, triangles, rings):
    """Six or more vertices may lie on one conic; then the rank is less than six."""
    edges = pairs_of(triangles)
    near = [edges[edges_in_ring(triangles, edges, i, rings)] for i in range(len(points))]
    return np.array([min(6, len(np.unique(pairs))) for pairs in near])


@answers("05.9", named=False)
def midpoints_not_relative_to_the_vertex(points, triangles, rings):
    """Far from the origin the columns are nearly multiples of each other."""
    edges = pairs_of(triangles)
    p, n = middles_and_normals(points, edges)
    found = []
    for i, x in enumerate(points):
        near = edges_in_ring(triangles, edges, i, rings)
        b = rows(p[near], n[near], 0 * x)
        found.append(np.linalg.matrix_rank(b / np.linalg.norm(b, axis=0), tol=1e-6))
    return np.array(found)


@answers("05.9", named=False)
def points_divided_by_the_largest_coordinate(points, triangles, rings):
    """Far from the origin the mesh is tiny after this division."""
    edges = pairs_of(triangles)
    p, n = middles_and_normals(points / np.abs(points).max(), edges)
    found = []
    for i, x in enumerate(points / np.abs(points).max()):
        near = edges_in_ring(triangles, edges, i, rings)
        found.append(np.linalg.matrix_rank(rows(p[near], n[near], x), tol=1e-6))
    return np.array(found)


def with_tolerance(points, triangles, rings, tolerance):
    edges = pairs_of(triangles)
    return ranks_by(
        points, triangles, lambda _, i: edges_in_ring(triangles, edges, i, rings), tol=tolerance
    )


@answers("05.9", named=False)
def coarse_tolerance(points, triangles, rings):
    """Singular values between the tolerance of the text and this one are not zero."""
    return with_tolerance(points, triangles, rings, 1e-4)


@answers("05.9", named=False)
def fine_tolerance(points, triangles, rings):
    """Singular values between this tolerance and that of the text count as zero, too."""
    return with_tolerance(points, triangles, rings, 1e-9)


@answers("05.9")
def in_units_that_matter(points, triangles, rings):
    """The ranks are right for one unit of length and wrong for another: the columns with y scale
    with the unit, and the tolerance does not. Divide each column of B′ by its norm first.
    """
    edges = pairs_of(triangles)
    p, n = middles_and_normals(points, edges)
    found = []
    for i, x in enumerate(points):
        near = edges_in_ring(triangles, edges, i, rings)
        found.append(np.linalg.matrix_rank(rows(p[near], n[near], x), tol=1e-6))
    return np.array(found)


@answers("05.7", named=False)
def differences_of_products(midpoints, normals, x):
    """Far from the origin the differences of products lose digits; those of points do not."""
    far = np.hstack([midpoints[:, :1] * normals, midpoints[:, 1:] * normals])
    return np.hstack([normals, far - np.hstack([x[0] * normals, x[1] * normals])])
