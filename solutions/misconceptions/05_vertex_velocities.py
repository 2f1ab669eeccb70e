"""What students write instead of notebook 05, and what each of them should hear."""

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


def ranks_by(points, triangles, chosen, matrix=rows):
    """The rank at each vertex, of the edges that `chosen` picks."""
    edges = pairs_of(triangles)
    p, n = middles_and_normals(points, edges)
    found = []
    for i, x in enumerate(points):
        near = chosen(edges, i)
        b = matrix(p[near], n[near], x)
        found.append(np.linalg.matrix_rank(b / np.sqrt((b**2).sum(axis=0)), tol=1e-6))
    return np.array(found)


# 05.1 edges_of


@answers("05.1")
def third_side_missing(triangles):
    """Only two sides of each triangle are listed, so some edges are not there. A triangle with the
    corners (a, b, c) has three sides; which pair is missing?
    """
    pairs = np.concatenate([triangles[:, :2], triangles[:, 1:]])
    found = np.unique(np.sort(pairs, axis=1), axis=0)
    return found


@answers("05.1")
def inner_edges_twice(triangles):
    """The sides of every triangle are there, but an edge between two triangles is a side of both,
    and you list it twice. It would count double in every fit. How can you tell that two pairs are
    the same edge?
    """
    return np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])


@answers("05.1")
def every_pair_of_vertices(triangles):
    """Every pair of vertices is listed, also of vertices far apart. An edge is a side of a
    triangle.
    """
    k = int(triangles.max()) + 1
    return np.stack(np.triu_indices(k, 1), axis=1)


@answers("05.1")
def side_from_a_corner_to_itself(triangles):
    """Some rows hold the same vertex twice, which is no edge. Look at the indices with which you
    form the three sides: one of them joins a corner to itself.
    """
    a, b, c = triangles.T
    pairs = np.concatenate([np.stack(s, axis=1) for s in ((a, b), (b, c), (c, c))])
    return np.unique(np.sort(pairs, axis=1), axis=0)


@answers("05.1")
def directions_told_apart(triangles):
    """An edge between two triangles that list it in opposite directions is there twice, as (i, j)
    and as (j, i). Which of the two you write is up to you, but it must be the same for both
    triangles.
    """
    return np.unique(
        np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=0
    )


# 05.2 midpoints_and_normals


@answers("05.2")
def normals_as_long_as_the_edges(points, edges):
    """The normals are perpendicular to the edges, but as long as these. Then v is no velocity but
    a velocity times a length, and long edges count more than short ones. What does (5.1) say of
    the length?
    """
    a, b = ends(points, edges)
    return (a + b) / 2, turned(b - a)


@answers("05.2")
def tangents(points, edges):
    """These are unit vectors *along* the edges. What flows along an edge does not cross it. What
    must the scalar product of a normal with the edge be?
    """
    a, b = ends(points, edges)
    return (a + b) / 2, (b - a) / np.hypot(*(b - a).T)[:, None]


@answers("05.2")
def components_exchanged_without_a_sign(points, edges):
    """The two components have been exchanged, but none has changed its sign: this mirrors the
    edge at a diagonal and does not turn it. Compute the scalar product of your normal with its
    edge.
    """
    a, b = ends(points, edges)
    return (a + b) / 2, (b - a)[:, ::-1] / np.hypot(*(b - a).T)[:, None]


@answers("05.2")
def one_length_for_all(points, edges):
    """All normals have been divided by the same number, the length of the whole array. Each has
    to be divided by a length of its own. `numpy.linalg.norm` needs to be told along which axis.
    """
    a, b = ends(points, edges)
    return (a + b) / 2, turned(b - a) / np.linalg.norm(b - a)


@answers("05.2")
def sum_of_the_ends(points, edges):
    """The normals are right. The midpoints are twice what they should be: a sum of two places is no
    mean of them, and lies outside of the mesh.
    """
    a, b = ends(points, edges)
    return a + b, middles_and_normals(points, edges)[1]


@answers("05.2")
def half_the_difference(points, edges):
    """The normals are right. What stands for the midpoints is half the way from one end to the
    other, as a vector; it does not know where the edge lies. Where does it start?
    """
    a, b = ends(points, edges)
    return (b - a) / 2, middles_and_normals(points, edges)[1]


@answers("05.2")
def normals_of_the_places(points, edges):
    """The unit vectors are perpendicular to the midpoints, seen from the origin, and not to the
    edges. Which vector is to be turned by a right angle?
    """
    a, b = ends(points, edges)
    middle = (a + b) / 2
    return middle, turned(middle) / np.maximum(np.hypot(*middle.T), 1e-12)[:, None]


# 05.3 rotation


@answers("05.3")
def about_the_origin(points):
    """This rotates about the origin: the mean m has not been subtracted. Where should the
    velocity be zero?
    """
    return turned(points)


@answers("05.3")
def clockwise(points):
    """This is the rotation in the other direction, with the sign of J reversed. Apply J of (5.2)
    to (1, 0) by hand: which way does it turn?
    """
    return -turned(points - points.mean(axis=0))


@answers("05.3")
def exchanged_without_a_sign(points):
    """The components are exchanged, but no sign has changed. This field mirrors and does not
    turn: along one diagonal the fluid rushes away from m, along the other towards it. Look at the
    signs in J.
    """
    return (points - points.mean(axis=0))[:, ::-1].copy()


@answers("05.3")
def away_from_the_mean(points):
    """The places seen from the mean have not been turned: this fluid flows away from m in all
    directions. What does J do to a vector?
    """
    return points - points.mean(axis=0)


@answers("05.3")
def one_mean_for_both_coordinates(points):
    """The mean is a single number, over both coordinates at once, so that the centre lies on the
    diagonal. m has two coordinates; along which axis of the array is the mean?
    """
    return turned(points - points.mean())


@answers("05.3")
def middle_of_the_box(points):
    """The rotation is about the middle of the smallest box around the points, which is not their
    mean: where there are more points on one side, the mean is on that side. Look at (5.2).
    """
    return turned(points - (points.min(axis=0) + points.max(axis=0)) / 2)


@answers("05.3")
def of_unit_speed(points):
    """Every velocity has length one. A body that rotates moves the faster, the farther from its
    centre; and the field is then no affine one. Leave the lengths as they are.
    """
    u = turned(points - points.mean(axis=0))
    return u / np.hypot(*u.T)[:, None]


# 05.4 normal_velocities


@answers("05.4")
def sum_of_the_two_ends(edges, normals, u):
    """These are twice the right numbers: the velocities at the two ends have been added, and not
    averaged.
    """
    return np.einsum("ak,ak->a", normals, u[edges[:, 0]] + u[edges[:, 1]])


@answers("05.4")
def first_end_only(edges, normals, u):
    """Only the velocity at the first end of each edge is used. Which end is first is an accident,
    and the midpoint is as far from the one as from the other.
    """
    return np.einsum("ak,ak->a", normals, u[edges[:, 0]])


@answers("05.4")
def difference_of_the_ends(edges, normals, u):
    """The velocities at the two ends are subtracted. For the same velocity everywhere that gives
    zero, as if nothing flowed. Which sign stands between them in (5.3)?
    """
    return np.einsum("ak,ak->a", normals, u[edges[:, 1]] - u[edges[:, 0]]) / 2


@answers("05.4")
def speeds(edges, normals, u):
    """These are the lengths of the velocities at the midpoints, and the normals have no part in
    them. Fluid that flows along an edge does not cross it. What does the dot in (5.3) mean?
    """
    return np.hypot(*(u[edges].mean(axis=1)).T)


@answers("05.4")
def products_not_added(edges, normals, u):
    """Normals and velocities are multiplied entry by entry, and the products not added. A scalar
    product is one number for each edge.
    """
    return normals * u[edges].mean(axis=1)


@answers("05.4")
def along_the_edge(edges, normals, u):
    """This is the component *along* each edge: the normal has been turned by a right angle. Flow
    through an edge is what goes across.
    """
    return np.einsum("ak,ak->a", turned(normals), u[edges].mean(axis=1))


@answers("05.4")
def without_its_sign(edges, normals, u):
    """The absolute values are right, but the signs are lost, and with them to which side the
    fluid goes. The flow of one wind and of the opposite one would look the same.
    """
    return np.abs(np.einsum("ak,ak->a", normals, u[edges].mean(axis=1)))


@answers("05.4")
def every_normal_with_every_edge(edges, normals, u):
    """There is a number for each normal *and* each edge: every normal has met every velocity. The
    right numbers are on the diagonal. You want the scalar products row by row.
    """
    return normals @ u[edges].mean(axis=1).T


# 05.6 ring


@answers("05.6")
def edges_at_the_vertex_only(triangles, edges, vertex, rings):
    """These are only the edges that end in the vertex, or in a vertex already reached: the outer
    sides of the triangles are missing. Without them a source at the vertex goes unnoticed. A
    triangle has three sides.
    """
    corners = [vertex] if rings == 1 else list(triangles_in_ring(triangles, vertex, rings - 1)[1])
    return np.isin(edges, corners).any(axis=1)


@answers("05.6")
def both_ends_in_the_ring(triangles, edges, vertex, rings):
    """Nearly: you take every edge whose two ends are vertices of the ring. Two such vertices may
    be joined by an edge outside of the ring, which belongs to no triangle of it. Draw a vertex
    beside one with three triangles.
    """
    corners = list(triangles_in_ring(triangles, vertex, rings)[1])
    return np.isin(edges, corners).all(axis=1)


@answers("05.6")
def outer_edges_only(triangles, edges, vertex, rings):
    """The edges that end in the vertex are missing: you have only the sides opposite to it. All
    three sides of each triangle belong to the ring.
    """
    return edges_in_ring(triangles, edges, vertex, rings) & (edges != vertex).all(axis=1)


@answers("05.6")
def always_one_ring(triangles, edges, vertex, rings):
    """This is the one ring, whatever number of rings is asked for. What has to be repeated for
    each further ring, and from which vertices does it start?
    """
    return edges_in_ring(triangles, edges, vertex, 1)


@answers("05.6")
def one_ring_too_many(triangles, edges, vertex, rings):
    """This is one ring more than asked for. Count how often your loop looks for triangles: for
    one ring that should happen once.
    """
    return edges_in_ring(triangles, edges, vertex, rings + 1)


@answers("05.6")
def across_sides_only(triangles, edges, vertex, rings):
    """The first ring is right, the next ones are too small: they take in only triangles that
    share a whole side with the ring before. By the definition above one common corner is enough.
    """
    near = [set(t) for t in triangles.tolist() if vertex in t]
    for _ in range(rings - 1):
        near = [set(t) for t in triangles.tolist() if any(len(set(t) & s) >= 2 for s in near)]
    return np.array([any(set(e) <= t for t in near) for e in edges.tolist()])


@answers("05.6")
def numbers_of_the_edges(triangles, edges, vertex, rings):
    """These are the numbers of the edges in the ring. Asked for is True or False for each edge of
    the mesh; start from an array of False as long as the list of edges.
    """
    return np.flatnonzero(edges_in_ring(triangles, edges, vertex, rings))


# 05.7 system


@answers("05.7")
def places_not_from_the_vertex(midpoints, normals, x):
    """The midpoints enter as they are, and not as seen from the vertex. Then c₀ is the velocity
    at the origin of the coordinates and not at the vertex. What is y in (5.4)?
    """
    return rows(midpoints, normals, 0 * x)


@answers("05.7")
def from_midpoint_to_vertex(midpoints, normals, x):
    """The last four columns have the wrong sign: these are the vertices as seen from the
    midpoints. The velocity at the vertex survives it, the slopes of the field do not. In which
    direction does y point?
    """
    return rows(-midpoints, normals, -x)


@answers("05.7")
def by_components(midpoints, normals, x):
    """The numbers are right, and the columns stand in another order: first all that is multiplied
    by the first component of the normal, then the second. The unknowns in (5.6) are ordered by
    vectors c₀, c₁, c₂.
    """
    return rows(midpoints, normals, x)[:, [0, 2, 4, 1, 3, 5]]


@answers("05.7")
def constant_last(midpoints, normals, x):
    """The columns of the bare normals stand last. So the first two unknowns are slopes, and
    whoever takes them for the velocity at the vertex is wrong. Compare the order in (5.6).
    """
    return np.roll(rows(midpoints, normals, x), -2, axis=1)


@answers("05.7")
def each_coordinate_with_its_component(midpoints, normals, x):
    """There are four columns: each coordinate has been multiplied with the component of the
    normal of the same number only. Each coordinate multiplies the *whole* normal, since c₁ and c₂
    are vectors.
    """
    return np.hstack([normals, (midpoints - x) * normals])


@answers("05.7")
def a_row_for_each_component(midpoints, normals, x):
    """This is the system for velocities that are fully known: two rows for each edge, and no
    normals. But each edge tells only one number. Where are the normals in (5.6)?
    """
    y = np.pad(midpoints - x, ((0, 0), (1, 0)), constant_values=1)
    return np.kron(y, np.eye(2))


@answers("05.7")
def without_the_constant(midpoints, normals, x):
    """The first two columns are missing, those of c₀. Without them the velocity at the vertex
    would be zero, and it is what we want to know.
    """
    return rows(midpoints, normals, x)[:, 2:]


@answers("05.7")
def coordinates_exchanged(midpoints, normals, x):
    """The two coordinates of y are exchanged: the third and fourth columns should have y₁ and the
    last two y₂, as c₁ belongs to the first coordinate.
    """
    return rows(midpoints, normals, x)[:, [0, 1, 4, 5, 2, 3]]


@answers("05.7")
def normals_and_places_side_by_side(midpoints, normals, x):
    """There are four columns, the normals and the places side by side. In (5.6) the
    places *multiply* the normals, once y₁ and once y₂; a sum of unknowns times these columns
    would be no scalar product with a normal.
    """
    return np.hstack([normals, midpoints - x])


# 05.8 velocity


@answers("05.8")
def weights_only_on_the_left(midpoints, normals, v, x, w):
    """The matrix is multiplied by the weights and the right side is not. An affine field, which
    satisfies all equations, is then no longer found. What stands on the right of (5.7)?
    """
    return solved(w[:, None] * rows(midpoints, normals, x), v)[:2]


@answers("05.8")
def weights_forgotten(midpoints, normals, v, x, w):
    """This is plain least squares: the weights have no effect. Every edge counts alike, however
    far it is. Where does W enter in (5.7)?
    """
    return solved(rows(midpoints, normals, x), v)[:2]


@answers("05.8")
def weights_not_squared(midpoints, normals, v, x, w):
    """In the normal equations the weights enter once, not squared. Each row of (5.7) is
    multiplied by w, and the normal equations multiply two rows with each other.
    """
    root = np.sqrt(w)
    return solved(root[:, None] * rows(midpoints, normals, x), root * v)[:2]


@answers("05.8")
def weights_squared_twice(midpoints, normals, v, x, w):
    """The weights enter with the fourth power: squared once too often. Multiplying the equations
    by w makes their errors count by w² all by itself.
    """
    return solved(w[:, None] ** 2 * rows(midpoints, normals, x), w**2 * v)[:2]


@answers("05.8")
def mean_of_the_shadows(midpoints, normals, v, x, w):
    """This is a weighted mean of the vectors v n. Each of them is only the part of the velocity
    across one edge, so their mean is too short, about half of the truth. The equations (5.5) must
    be solved together.
    """
    return (w * v) @ normals / w.sum()


@answers("05.8")
def one_velocity_for_all_edges(midpoints, normals, v, x, w):
    """One constant velocity is fitted to all edges, without slopes. A field that changes from
    edge to edge, as a rotation does, is then not reproduced. How many unknowns has (5.4)?
    """
    return solved(w[:, None] * normals, w * v)


@answers("05.8")
def at_the_origin(midpoints, normals, v, x, w):
    """This is the value of the fitted field at the origin of the coordinates, and not at the
    vertex. Either measure places from the vertex, or evaluate (5.4) there.
    """
    return solved(w[:, None] * rows(midpoints, normals, 0 * x), w * v)[:2]


@answers("05.8")
def last_unknowns(midpoints, normals, v, x, w):
    """These are the last two unknowns, the slopes of the field along the second axis. Which
    unknowns are the velocity at the vertex?
    """
    return solved(w[:, None] * rows(midpoints, normals, x), w * v)[4:]


@answers("05.8")
def all_six_unknowns(midpoints, normals, v, x, w):
    """These are all six coefficients. Asked for is the velocity at the vertex; put y = 0 in
    (5.4), and see which of them are left.
    """
    return solved(w[:, None] * rows(midpoints, normals, x), w * v)


@answers("05.8")
def first_six_equations(midpoints, normals, v, x, w):
    """This field satisfies the first six equations and ignores all others. Which six come first
    is an accident, and every edge should have its say.
    """
    return np.linalg.solve(rows(midpoints, normals, x)[:6], v[:6])[:2]


# 05.9 ranks


@answers("05.9")
def spokes_only(points, triangles, rings):
    """The ranks are those of the edges that end in the vertex, which never see a source there: no
    rank is six. Which edges are in the ring?
    """
    return ranks_by(points, triangles, lambda edges, i: (edges == i).any(axis=1))


@answers("05.9")
def counted(points, triangles, rings):
    """This counts equations: six or more edges are taken for rank six. They need not be
    independent; a vertex inside with three triangles has six edges and a lower rank. Let a
    function compute the rank of the matrix.
    """
    edges = pairs_of(triangles)
    return np.array(
        [min(6, edges_in_ring(triangles, edges, i, rings).sum()) for i in range(len(points))]
    )


@answers("05.9")
def all_edges_of_the_mesh(points, triangles, rings):
    """The matrix has the edges of the whole mesh in it, so that the rank is six everywhere. Which
    of them belong to the ring of the vertex?
    """
    return ranks_by(points, triangles, lambda edges, i: np.ones(len(edges), dtype=bool))


@answers("05.9")
def rank_of_the_places(points, triangles, rings):
    """This is the rank of the matrix with the rows (1, y₁, y₂), three everywhere: it would do if
    velocities were fully known. The normals decide here. Use B′ of (5.6).
    """
    return np.full(len(points), 3)


@answers("05.9")
def yes_or_no(points, triangles, rings):
    """This says whether the rank is six, as one or zero. Asked for is the rank: you will want to
    see how much is missing.
    """
    edges = pairs_of(triangles)
    all_ranks = ranks_by(points, triangles, lambda _, i: edges_in_ring(triangles, edges, i, rings))
    return (all_ranks == 6).astype(int)


@answers("05.9")
def one_ring_whatever_is_asked(points, triangles, rings):
    """The ranks are those of one ring, also where more are asked for. Where does the number of
    rings go in?
    """
    edges = pairs_of(triangles)
    return ranks_by(points, triangles, lambda _, i: edges_in_ring(triangles, edges, i, 1))


@answers("05.9")
def in_units_that_matter(points, triangles, rings):
    """The ranks are right for one unit of length and wrong for another: the columns with y shrink
    with the unit, until their singular values are below your tolerance. Make all columns of B′
    alike before you ask for the rank.
    """
    edges = pairs_of(triangles)
    p, n = middles_and_normals(points, edges)
    found = []
    for i, x in enumerate(points):
        near = edges_in_ring(triangles, edges, i, rings)
        found.append(np.linalg.matrix_rank(rows(p[near], n[near], x), tol=1e-6))
    return np.array(found)
