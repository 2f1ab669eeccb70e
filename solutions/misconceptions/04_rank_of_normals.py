"""What students write instead of notebook 04, and what each of them should hear."""

import numpy as np

from fieldgrade.authoring.catalogue import answers


def basis(points):
    return np.insert(points, 0, 1.0, axis=1)


def rows(points, normals):
    b = basis(points)[:, :, None] * normals[:, None, :]
    return b.reshape(len(points), -1)


def local(points):
    moved = points - np.mean(points, axis=0)
    return moved / np.max(np.abs(moved))


def flow_at(points, c):
    return basis(points) @ np.reshape(c, (3, 2))


def turn(v):
    return np.column_stack([-v[:, 1], v[:, 0]])


def unit(v):
    return v / np.sqrt(np.sum(v * v, axis=1))[:, None]


def singular_values(matrix):
    return np.linalg.svd(matrix, compute_uv=False)


# 04.1 The matrix


@answers("04.1")
def components_apart(points, normals):
    """The columns stand in another order: all coefficients of the first component of u, then all of
    the second. The matrix is as good, but c has the order of (4.3), and everything after this
    question reads it so: the normal itself stands first, then the normal times x, and so on.
    """
    b = basis(points)
    return np.hstack([normals[:, [k]] * b for k in range(points.shape[1])])


@answers("04.1")
def normals_not_applied(points, normals):
    """The normals are not used: this is the system for velocities that are known with all their
    components, and has D times as many rows. Known is one number for each sample, n · u.
    """
    return np.kron(basis(points), np.eye(points.shape[1]))


@answers("04.1")
def tangents_for_normals(points, normals):
    """The rows hold the directions of the edges and not their normals: this is a system for what
    flows along the edges. Measured is what flows across, n · u.
    """
    along = normals.copy()
    along[:, 0], along[:, 1] = -normals[:, 1], normals[:, 0]
    return rows(points, along)


@answers("04.1")
def constant_forgotten(points, normals):
    """The first block is missing: the flow is forced to vanish at the origin. What multiplies c₀ in
    the equation n · u(p) = v?
    """
    return rows(points, normals)[:, points.shape[1] :]


@answers("04.1")
def points_and_normals_exchanged(points, normals):
    """Points and normals have changed places: rows of p, then p times the components of n. In (4.3)
    the normal is in each block, and the coordinates of the point multiply it.
    """
    return rows(normals, points)


@answers("04.1")
def each_component_with_its_own(points, normals):
    """The arrays were multiplied entry by entry, so that x meets only the first component of n
    and y only the second. In a block of (4.3) one coordinate multiplies the whole normal.
    """
    return np.hstack([normals, points * normals])


@answers("04.1")
def normals_made_unit(points, normals):
    """The rows were scaled as if the normals had to have the length one. Where they have not, v is
    measured along the vector as it is given, and its row must be scaled as v is: not at all.
    """
    return rows(points, normals / np.sqrt(np.sum(normals**2, axis=1))[:, None])


# 04.2 The rank


@answers("04.2")
def equations_counted(points, normals):
    """This counts equations and unknowns. Rows may depend on each other: eight parallel normals are
    eight equations, and the rank is three.
    """
    d = points.shape[1]
    return min(len(points), d + d * d)


@answers("04.2")
def as_if_all_components_were_known(points, normals):
    """This is D times the rank of the matrix of the points, and knows nothing of the normals. It is
    the rank for velocities of which all components are measured.
    """
    return points.shape[1] * np.linalg.matrix_rank(basis(local(points)), tol=1e-9)


@answers("04.2")
def zero_only_if_exactly(points, normals):
    """Singular values were compared with zero exactly. Rounding makes those that should be zero
    about 1e-16, and nearly every matrix has full rank then. From which size on is a value meant?
    """
    return np.sum(singular_values(rows(local(points), normals)) > 0)


@answers("04.2")
def tolerance_in_metres(points, normals):
    """The tolerance is a fixed number, and the points are in whatever unit they come. For points
    that are all very close together true singular values are below it. Bring the points to the
    size one first.
    """
    return np.linalg.matrix_rank(rows(points - points[0], normals), tol=1e-5)


@answers("04.2")
def far_from_the_origin(points, normals):
    """Far from the origin the columns of B' are nearly multiples of each other, and the rank
    seems to be less than it is. What can be known does not depend on where the origin lies:
    choose a good one.
    """
    return np.linalg.matrix_rank(rows(points, normals))


@answers("04.2")
def whether_it_is_full(points, normals):
    """This says whether the rank is full, as one or zero. Asked for is the rank itself: it tells
    how many flows are lost.
    """
    d = points.shape[1]
    return int(np.linalg.matrix_rank(rows(local(points), normals), tol=1e-9) == d + d * d)


@answers("04.2")
def flows_lost(points, normals):
    """This is the number of flows that no sample sees, the columns less the rank. Asked for is the
    rank.
    """
    d = points.shape[1]
    return d + d * d - np.linalg.matrix_rank(rows(local(points), normals), tol=1e-9)


# 04.3 The tangent field


@answers("04.3")
def best_seen(points, normals):
    """This is the flow that the samples see best of all: it belongs to the largest singular value.
    Which one belongs to a flow that gives zero everywhere?
    """
    return np.linalg.svd(rows(points, normals))[2][0]


@answers("04.3")
def column_for_row(points, normals):
    """A column was taken where a row belongs. NumPy returns the last factor of the decomposition
    already transposed: the vectors that the matrix acts on are its rows.
    """
    return np.linalg.svd(rows(points, normals))[2][:, -1]


@answers("04.3")
def solved_for_zero(points, normals):
    """All coefficients are zero. That is a solution of B'c = 0, and the one that says nothing: a
    solver of least squares returns the shortest. Asked for is another one.
    """
    return np.linalg.lstsq(rows(points, normals), np.zeros(len(points)))[0]


@answers("04.3")
def reduced_decomposition(points, normals):
    """For more samples this is right. Five have only five singular values, all above zero, and
    the flow that is wanted is a sixth row, which belongs to none of them: a reduced decomposition
    leaves it out, and the place of the smallest singular value does not lead to it.
    """
    return np.linalg.svd(rows(points, normals), full_matrices=False)[2][-1]


@answers("04.3")
def across_all_edges(points, normals):
    """This flow stands at right angles to the edges where it should run along them, as far as it
    can: the rows were made of the edges and not of their normals.
    """
    return np.linalg.svd(rows(points, turn(normals)))[2][-1]


@answers("04.3")
def in_the_other_order(points, normals):
    """The six numbers are right and stand in another order: first those of one component, then
    those of the other. c is (c₀, c₁, c₂), and each of the three has two components.
    """
    return np.linalg.svd(rows(points, normals))[2][-1].reshape(3, 2).T.ravel()


# 04.4 The normals


@answers("04.4")
def along_the_flow(points, c):
    """These are unit vectors along the flow. Then n · u is the speed, the largest value there is,
    and the flow is seen best of all. A normal that hides it stands at a right angle.
    """
    return unit(flow_at(points, c))


@answers("04.4")
def not_of_length_one(points, c):
    """The direction is right and the length is not: these are as long as the velocity is large.
    Asked for are unit normals.
    """
    return turn(flow_at(points, c))


@answers("04.4")
def mirrored(points, c):
    """The two components were exchanged, which is a reflection and no right angle: the product
    with u is twice u₁u₂ and not zero. One sign is missing.
    """
    return unit(flow_at(points, c)[:, ::-1])


@answers("04.4")
def without_the_constant(points, c):
    """The velocity was computed without c₀. These normals hide another flow, with its centre at the
    origin. Use `velocity`.
    """
    return unit(turn(points @ np.reshape(c, (3, 2))[1:] + 1e-300))


@answers("04.4")
def coefficients_by_component(points, c):
    """The coefficients were read as three of one component and three of the other. By (4.1) c is
    c₀, c₁, c₂, each with two components: `velocity` knows.
    """
    return unit(turn(basis(points) @ np.reshape(c, (2, 3)).T))


@answers("04.4")
def scaled_together(points, c):
    """All normals were divided by one number, the size of the whole array. Each row has to have the
    length one by itself: along which axis are the squares summed?
    """
    n = turn(flow_at(points, c))
    return n / np.linalg.norm(n)


# 04.5 The obvious conditions


def spans(points):
    return len(points) > 2 and np.linalg.matrix_rank(points - points[0], tol=1e-9) == 2


@answers("04.5")
def only_not_all_parallel(points, normals):
    """This asks whether all normals are parallel. With two others it says yes, and yet the flow
    along the many edges is measured at two places only, which is not enough for an affine
    function.
    """
    return np.linalg.matrix_rank(normals, tol=1e-9) == 2


@answers("04.5")
def only_along_the_axes(points, normals):
    """Only the directions of the axes were tried. A bad direction may be any: turn all samples by
    45 degrees, and the answer should stay. Which directions leave a sample out?
    """
    return spans(points[np.abs(normals[:, 0]) > 1e-9]) and spans(
        points[np.abs(normals[:, 1]) > 1e-9]
    )


@answers("04.5")
def three_are_enough(points, normals):
    """For each direction it was counted whether three samples see it. Three points on a line do not
    determine an affine function: they must span the plane.
    """
    return all(np.sum(np.abs(normals @ [-n[1], n[0]]) > 1e-9) >= 3 for n in normals)


@answers("04.5")
def directions_counted(points, normals):
    """This counts how many different directions the normals have. Two may be enough, and many may
    not be: it matters how many samples have each, and where they are.
    """
    tensors = np.einsum("ni,nj->nij", normals, normals).round(8)
    return len(np.unique(tensors.reshape(len(normals), 4), axis=0)) > 2


@answers("04.5")
def the_whole_truth(points, normals):
    """This is whether B' has full rank, and that is more than was asked: (4.5) speaks only of
    flows of one fixed direction. If all normals go through one place it holds, and a rotation is
    lost all the same.
    """
    return np.linalg.matrix_rank(rows(local(points), normals), tol=1e-9) == 6


@answers("04.5")
def opposite_taken_for_different(points, normals):
    """A normal and its opposite were taken for two directions. The sign of a normal is a matter of
    taste, and n · m is zero for both or for none. Compare something that has no sign.
    """
    return all(spans(points[np.abs(normals - n).max(axis=1) > 1e-9]) for n in normals)


@answers("04.5")
def tried_along_the_normals(points, normals):
    """The directions that were tried are the normals themselves. A flow along its own normal is
    seen by a sample; left out is the sample for the direction at a right angle.
    """
    return all(spans(points[np.abs(normals @ n) > 1e-9]) for n in normals)


# 04.6 Stars


def star(center, ring, following):
    start, end = np.vstack([0 * ring + center, ring]), np.vstack([ring, following])
    return start, end


def shifted(ring):
    return np.vstack([ring[1:], ring[:1]])


@answers("04.6")
def spokes_alone(center, ring):
    """The rim is missing. With the spokes alone the flow away from the vertex runs along every
    edge, and the rank can never be full. There are twice as many samples.
    """
    return (center + ring) / 2, unit(turn(ring - center))


@answers("04.6")
def edges_for_normals(center, ring):
    """These are unit vectors along the edges. A normal stands at a right angle to its edge."""
    start, end = star(center, ring, shifted(ring))
    return (start + end) / 2, unit(end - start)


@answers("04.6")
def as_long_as_the_edges(center, ring):
    """The normals are as long as the edges, so that n · u is what flows across the whole edge.
    Asked for are unit normals.
    """
    start, end = star(center, ring, shifted(ring))
    return (start + end) / 2, turn(end - start)


@answers("04.6")
def divided_by_one_number(center, ring):
    """All normals were divided by one number, the size of the whole array, so none has the length
    one. Each row has a length of its own: along which axis are the squares summed?
    """
    start, end = star(center, ring, shifted(ring))
    return (start + end) / 2, turn(end - start) / np.linalg.norm(end - start)


@answers("04.6")
def ends_for_midpoints(center, ring):
    """The samples stand at the ends of the edges. The mean of an affine flow over an edge is its
    value in the middle, so that is where it is sampled.
    """
    start, end = star(center, ring, shifted(ring))
    return end, unit(turn(end - start))


@answers("04.6")
def not_halved(center, ring):
    """The two ends were added and not divided by two. Draw your points: they lie outside the
    star.
    """
    start, end = star(center, ring, shifted(ring))
    return start + end, unit(turn(end - start))


@answers("04.6")
def rim_not_closed(center, ring):
    """One edge of the rim is missing, that from the last neighbour to the first. The neighbours
    go all the way round.
    """
    start, end = np.vstack([0 * ring + center, ring[:-1]]), np.vstack([ring, ring[1:]])
    return (start + end) / 2, unit(turn(end - start))


@answers("04.6")
def rim_first(center, ring):
    """All samples are there, the rim before the spokes. Asked for are the spokes first."""
    start, end = star(center, ring, shifted(ring))
    k = len(ring)
    return np.roll((start + end) / 2, k, axis=0), np.roll(unit(turn(end - start)), k, axis=0)


@answers("04.6")
def rim_backwards(center, ring):
    """The rim begins with the edge from the first neighbour to the last. Asked for is the one to
    the next neighbour first: look at the direction in which the array was rolled.
    """
    start, end = star(center, ring, np.vstack([ring[-1:], ring[:-1]]))
    return (start + end) / 2, unit(turn(end - start))


# 04.7 The conic


def conic(points):
    x, y = points.T
    return np.array([x**0, x, y, x**2, x * y, y**2]).T


@answers("04.7")
def vertices_counted(vertices):
    """This is the number of vertices, or six: no conic was noticed. Nine points of a circle have
    the rank five. Were they counted, or singular values compared with zero exactly, which
    rounding never leaves?
    """
    return min(len(vertices), 6)


@answers("04.7")
def lines_only(vertices):
    """This is the rank of the columns 1, x, y: whether the points lie on a line. The columns of
    degree two in (4.6) are missing.
    """
    return np.linalg.matrix_rank(basis(local(vertices)), tol=1e-9)


@answers("04.7")
def no_mixed_column(vertices):
    """The column of the products xy is missing. Without it only conics are found whose axes are
    parallel to those of the coordinates, and the rank is five at most.
    """
    return np.linalg.matrix_rank(np.delete(conic(local(vertices)), 4, axis=1), tol=1e-9)


@answers("04.7")
def circles_only(vertices):
    """This asks whether the points lie on a circle: the squares were added to one column. A conic
    has a factor for each of x², xy and y².
    """
    x, y = local(vertices).T
    return np.linalg.matrix_rank(np.array([x**0, x, y, x**2 + y**2]), tol=1e-9)


@answers("04.7")
def in_these_units(vertices):
    """In these units the columns differ by many orders of magnitude, squares most of all, and far
    from the origin they are nearly dependent. Move the points to the origin and scale them before
    the squares are formed.
    """
    return np.linalg.matrix_rank(conic(vertices))


@answers("04.7")
def tolerance_for_metres(vertices):
    """The tolerance is a fixed number, and the points are in whatever unit they come. A small
    length has a square that is much smaller still: for points close together those columns count
    as zero. Bring the points to the size one first.
    """
    return np.linalg.matrix_rank(conic(vertices - vertices.mean(axis=0)), tol=1e-9)


@answers("04.7")
def does_one_exist(vertices):
    """This says whether there is a conic through the points, as one or zero. Asked for is the
    rank: it tells how many conics there are.
    """
    return int(np.linalg.matrix_rank(conic(local(vertices)), tol=1e-9) < 6)
