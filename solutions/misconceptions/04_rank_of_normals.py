"""Wrong answers to notebook 04, each with the sentence for the student."""

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
    the second. In (4.3) the normal comes first, then x times the normal, and so on.
    """
    b = basis(points)
    return np.hstack([normals[:, [k]] * b for k in range(points.shape[1])])


@answers("04.1")
def normals_not_applied(points, normals):
    """The normals are not used. This is the system for velocities with all components known, and it
    has D times as many rows. Each sample gives one number, n · u.
    """
    return np.kron(basis(points), np.eye(points.shape[1]))


@answers("04.1")
def tangents_for_normals(points, normals):
    """The rows hold the directions of the edges instead of their normals. The measurements are the
    components across the edges, n · u.
    """
    along = normals.copy()
    along[:, 0], along[:, 1] = -normals[:, 1], normals[:, 0]
    return rows(points, along)


@answers("04.1")
def constant_forgotten(points, normals):
    """The first block is missing, so the flow would be zero at the origin. Which factor has c₀ in
    the equation n · u(p) = v?
    """
    return rows(points, normals)[:, points.shape[1] :]


@answers("04.1")
def points_and_normals_exchanged(points, normals):
    """Points and normals are exchanged: the rows hold p, then p times the components of n. In (4.3)
    each block holds the normal, multiplied by a coordinate of the point.
    """
    return rows(normals, points)


@answers("04.1")
def each_component_with_its_own(points, normals):
    """The arrays were multiplied entry by entry, so x multiplies only the first component of n, and
    y only the second. In each block of (4.3) one coordinate multiplies the whole normal.
    """
    return np.hstack([normals, points * normals])


@answers("04.1")
def normals_made_unit(points, normals):
    """The normals were scaled to length one. Each row must use the vector as it is given, since v
    is its scalar product with u.
    """
    return rows(points, normals / np.sqrt(np.sum(normals**2, axis=1))[:, None])


# 04.2 The rank


@answers("04.2")
def equations_counted(points, normals):
    """This is the smaller of the numbers of equations and unknowns. Rows may depend on each other:
    eight parallel normals give eight equations of rank three.
    """
    d = points.shape[1]
    return min(len(points), d + d * d)


@answers("04.2")
def as_if_all_components_were_known(points, normals):
    """This is D times the rank of the matrix of the points, and the normals have no influence. It
    is the rank for velocities with all components measured.
    """
    return points.shape[1] * np.linalg.matrix_rank(basis(local(points)), tol=1e-9)


@answers("04.2", named=False)
def zero_only_if_exactly(points, normals):
    """Rounding makes zero singular values about 10⁻¹⁶, or zero, so these ranks are accidental."""
    return np.sum(singular_values(rows(local(points), normals)) > 0)


@answers("04.2")
def tolerance_in_metres(points, normals):
    """The tolerance depends on the unit of length: for points that are very close together,
    singular values that are not zero fall below it. Scale the points to size one first.
    """
    return np.linalg.matrix_rank(rows(points - points.mean(axis=0), normals), tol=1e-9)


def tolerance_of(points, normals, tolerance):
    return np.linalg.matrix_rank(rows(local(points), normals), tol=tolerance)


@answers("04.2")
def default_tolerance(points, normals):
    """The tolerance is smaller than that of the text, such as the default of `matrix_rank`, which
    is about 10⁻¹⁵. The text counts singular values below 10⁻⁹ as zero.
    """
    return np.linalg.matrix_rank(rows(local(points), normals))


@answers("04.2")
def distance_of_the_first_two(points, normals):
    """The unit is the distance of the first two points. Several samples may share a point, so it
    may be zero. Divide by the extent of all points.
    """
    p = points - points[0]
    unit = np.linalg.norm(p[1]) if p[1].any() else 1.0
    return np.linalg.matrix_rank(rows(p / unit, normals), tol=1e-9)


@answers("04.2", named=False)
def coarse_tolerance(points, normals):
    """Normals that nearly meet in a point lose a rank."""
    return tolerance_of(points, normals, 0.1)


@answers("04.2", named=False)
def tolerance_of_a_hundredth(points, normals):
    """Normals that nearly meet in a point lose a rank."""
    return tolerance_of(points, normals, 1e-2)


@answers("04.2", named=False)
def tolerance_of_a_thousandth(points, normals):
    """Normals that nearly meet in a point lose a rank."""
    return tolerance_of(points, normals, 1e-3)


@answers("04.2", named=False)
def tolerance_relative_to_the_largest_column(points, normals):
    """Without scaling the columns differ by the unit of length."""
    s = singular_values(rows(points - points.mean(axis=0), normals))
    return np.sum(s > 1e-9 * s[0])


@answers("04.2", named=False)
def coarser_tolerance_relative_to_the_largest_column(points, normals):
    """Without scaling the columns differ by the unit of length."""
    s = singular_values(rows(points - points.mean(axis=0), normals))
    return np.sum(s > 1e-6 * s[0])


@answers("04.2", named=False)
def each_axis_by_itself(points, normals):
    """For points within rounding of a line parallel to an axis this magnifies the rounding."""
    moved = points - points.mean(axis=0)
    sizes = np.ptp(moved, axis=0)
    return np.linalg.matrix_rank(rows(moved / np.where(sizes > 0, sizes, 1), normals), tol=1e-9)


@answers("04.2", named=False)
def of_the_first_equations(points, normals):
    """The first D + D² equations may depend on each other although the others do not."""
    b = rows(local(points), normals)
    return np.linalg.matrix_rank(b[: b.shape[1]], tol=1e-9)


@answers("04.2", named=False)
def smallest_extent(points, normals):
    """The largest extent is the size of the points, not the smallest."""
    moved = points - points.mean(axis=0)
    return np.linalg.matrix_rank(
        rows(moved / (np.ptp(moved, axis=0).min() or 1), normals), tol=1e-9
    )


@answers("04.2", named=False)
def tolerance_of_a_millionth(points, normals):
    """Normals that very nearly meet in a point lose a rank."""
    return tolerance_of(points, normals, 1e-6)


@answers("04.2", named=False)
def by_eigenvalues_of_the_normal_matrix(points, normals):
    """The eigenvalues are the squares of the singular values, and need the square of 10⁻⁹."""
    b = rows(local(points), normals)
    return np.count_nonzero(np.linalg.eigvalsh(b.T @ b) > 1e-12)


@answers("04.2", named=False)
def tolerance_of_the_rounding(points, normals):
    """Normals within 10⁻¹⁰ of meeting in a point count as general."""
    return tolerance_of(points, normals, 1e-12)


@answers("04.2")
def far_from_the_origin(points, normals):
    """The points were neither moved nor scaled. Far from the origin the columns of B' are nearly
    multiples of each other, and the computed rank is wrong. The rank does not depend on the origin.
    Subtract the mean of the points, divide by their extent, and use the tolerance of the text.
    """
    return np.linalg.matrix_rank(rows(points, normals))


@answers("04.2")
def whether_it_is_full(points, normals):
    """The function returns 1 if the rank is full, else 0. The question asks for the
    rank itself.
    """
    d = points.shape[1]
    return int(np.linalg.matrix_rank(rows(local(points), normals), tol=1e-9) == d + d * d)


@answers("04.2")
def flows_lost(points, normals):
    """This is the dimension of the null space: the number of columns minus the rank. The question
    asks for the rank.
    """
    d = points.shape[1]
    return d + d * d - np.linalg.matrix_rank(rows(local(points), normals), tol=1e-9)


# 04.3 The tangent field


@answers("04.3")
def best_seen(points, normals):
    """This is the singular vector of the largest singular value. Which singular value belongs to a
    vector with B' c = 0?
    """
    return np.linalg.svd(rows(points, normals))[2][0]


@answers("04.3")
def column_for_row(points, normals):
    """A column was taken instead of a row. NumPy returns the last factor of the decomposition
    transposed: the right singular vectors are its rows.
    """
    return np.linalg.svd(rows(points, normals))[2][:, -1]


@answers("04.3")
def solved_for_zero(points, normals):
    """All coefficients are zero. This solves B' c = 0, but the question asks for another solution.
    A least-squares solver returns the shortest one.
    """
    return np.linalg.lstsq(rows(points, normals), np.zeros(len(points)))[0]


@answers("04.3")
def reduced_decomposition(points, normals):
    """Five samples have only five singular values, none of them zero. The null vector is a sixth
    row: the reduced decomposition omits it, and the smallest singular value belongs to another row.
    """
    return np.linalg.svd(rows(points, normals), full_matrices=False)[2][-1]


@answers("04.3")
def across_all_edges(points, normals):
    """The rows were made of the edge directions instead of the normals. This flow is perpendicular
    to the edges, as far as possible, where it must be tangent.
    """
    return np.linalg.svd(rows(points, turn(normals)))[2][-1]


@answers("04.3")
def in_the_other_order(points, normals):
    """The six numbers are right, but in another order: first those of one component, then those of
    the other. c is (c₀, c₁, c₂), each with two components.
    """
    return np.linalg.svd(rows(points, normals))[2][-1].reshape(3, 2).T.ravel()


def tangent_to_moved(points, normals, size):
    moved = points - points.mean(axis=0)
    return np.linalg.svd(rows(moved / size(moved), normals))[2][-1]


@answers("04.3")
def of_the_shifted_points(points, normals):
    """These coefficients belong to the shifted points, whose origin is another one. Return those
    for the points as they are given, for which B' c = 0.
    """
    return tangent_to_moved(points, normals, lambda _: 1)


@answers("04.3")
def of_the_points_divided_by_their_extent(points, normals):
    """These coefficients belong to the shifted and scaled points of 04.2. Return those for the
    points as they are given, for which B' c = 0.
    """
    return tangent_to_moved(points, normals, np.ptp)


@answers("04.3")
def of_the_points_divided_by_their_sides(points, normals):
    """These coefficients belong to the shifted and scaled points, as in 04.2. Return those for the
    points as they are given, for which B' c = 0.
    """
    return tangent_to_moved(points, normals, lambda p: np.ptp(p, axis=0).max())


@answers("04.3")
def of_the_points_divided_by_their_largest_coordinate(points, normals):
    """These coefficients belong to points that were shifted and scaled as in 04.2. Return those for
    the points as they are given, for which B' c = 0.
    """
    return tangent_to_moved(points, normals, lambda p: np.abs(p).max())


@answers("04.3")
def of_the_points_divided_by_the_largest_distance(points, normals):
    """These coefficients belong to points that were shifted and scaled, as in 04.2. Return those
    for the points as they are given, for which B' c = 0.
    """
    return tangent_to_moved(points, normals, lambda p: np.hypot(*p.T).max())


# 04.4 The normals


@answers("04.4")
def along_the_flow(points, c):
    """These are unit vectors along the flow. Then n · u is the speed, not zero. The normal must be
    perpendicular to the flow.
    """
    return unit(flow_at(points, c))


@answers("04.4")
def not_of_length_one(points, c):
    """The directions are right, but the lengths are the speeds. The question asks
    for unit normals.
    """
    return turn(flow_at(points, c))


@answers("04.4")
def mirrored(points, c):
    """The two components were exchanged, which is a reflection and not a rotation by 90 degrees.
    Before the division by the length, the scalar product with u is 2 u₁u₂ or −2 u₁u₂. Exactly one
    of the two components must change its sign.
    """
    return unit(flow_at(points, c)[:, ::-1])


@answers("04.4")
def without_the_constant(points, c):
    """The velocity was computed without c₀. Use `velocity`."""
    return unit(turn(points @ np.reshape(c, (3, 2))[1:] + 1e-300))


@answers("04.4")
def coefficients_by_component(points, c):
    """The coefficients were read as three of one component and three of the other. By (4.1) they
    are c₀, c₁, c₂, each with two components. Use `velocity`.
    """
    return unit(turn(basis(points) @ np.reshape(c, (2, 3)).T))


@answers("04.4")
def scaled_together(points, c):
    """All normals were divided by one number, the norm of the whole array. Each row must have
    length one. Along which axis must the squares be added?
    """
    n = turn(flow_at(points, c))
    return n / np.linalg.norm(n)


@answers("04.4", named=False)
def by_slopes(points, c):
    """Dividing by the second component of the velocity fails for a flow along the first axis."""
    u, v = flow_at(points, c).T
    with np.errstate(all="ignore"):
        return unit(np.column_stack([np.ones(len(u)), -u / v]))


@answers("04.4", named=False)
def slow_counts_as_zero(points, c):
    """A speed below 10⁻⁶ counts as zero, which depends on the units of length and time."""
    u = flow_at(points, c)
    slow = np.sqrt(np.sum(u * u, axis=1)) < 1e-6
    return unit(turn(np.where(slow[:, None], [1.0, 0.0], u)))


@answers("04.4", named=False)
def absolute_points(points, c):
    """The coordinates of the points have lost their signs."""
    return unit(turn(flow_at(np.abs(points), c)))


@answers("04.4", named=False)
def absolute_velocities(points, c):
    """The components of the velocity have lost their signs."""
    return unit(turn(np.abs(flow_at(points, c))))


# 04.5 The obvious conditions


def spans(points):
    return len(points) > 2 and np.linalg.matrix_rank(points - points[0], tol=1e-9) == 2


@answers("04.5")
def only_not_all_parallel(points, normals):
    """The result is whether not all normals are parallel. If all but two are parallel, the flow
    along the many edges is measured at two points only. That is too few for an affine function.
    """
    return np.linalg.matrix_rank(normals, tol=1e-9) == 2


def with_tolerance(points, normals, tolerance):
    return all(spans(points[np.abs(normals @ [-n[1], n[0]]) > tolerance]) for n in normals)


@answers("04.5", named=False)
def coarse_test_of_directions(points, normals):
    """With this tolerance normals at a small angle count as parallel."""
    return with_tolerance(points, normals, 0.01)


@answers("04.5", named=False)
def products_below_a_millionth(points, normals):
    """With this tolerance normals at a small angle count as parallel."""
    return with_tolerance(points, normals, 1e-6)


@answers("04.5", named=False)
def default_of_isclose(points, normals):
    """The default tolerance of isclose is 10⁻⁸ for zero, ten times that of the text."""
    return all(spans(points[~np.isclose(normals @ [-n[1], n[0]], 0)]) for n in normals)


@answers("04.5")
def products_of_a_tenth_count(points, normals):
    """Normals at an angle of 5 · 10⁻¹⁰ count as different directions. Products n · m of unit
    vectors below 10⁻⁹ are zero by the text. Which tolerance has your comparison?
    """
    return with_tolerance(points, normals, 1e-10)


@answers("04.5")
def rows_multiplied_by_the_products(points, normals):
    """A small angle and a small distance from a line were multiplied: their product is below the
    tolerance, although neither of them is. Select the points by n · m, and test these points.
    """
    b = np.insert(points, 0, 1.0, axis=1)
    return all(
        np.linalg.matrix_rank((normals @ [-n[1], n[0]])[:, None] * b, tol=1e-9) == 3
        for n in normals
    )


@answers("04.5", named=False)
def compared_by_cosines(points, normals):
    """The cosine of a small angle is one up to half of its square, which is below the rounding."""
    cosines = np.abs(normals @ normals.T)
    return all(spans(points[np.abs(row - 1) > 1e-12]) for row in cosines)


@answers("04.5", named=False)
def products_compared_with_zero_exactly(points, normals):
    """Normals that are parallel up to rounding count as different directions."""
    products = normals @ np.array([-normals[:, 1], normals[:, 0]])
    return all(spans(points[seen]) for seen in products.T != 0)


@answers("04.5", named=False)
def angles_compared_exactly(points, normals):
    """Normals that are parallel up to rounding count as different directions."""
    angles = np.arctan2(normals[:, 1], normals[:, 0]) % np.pi
    return all(spans(points[angles != angle]) for angle in angles)


@answers("04.5", named=False)
def first_three_points_only(points, normals):
    """Only the first three of the points that count were tested for lying on a line."""
    return all(spans(points[np.abs(normals @ [-n[1], n[0]]) > 1e-9][:3]) for n in normals)


@answers("04.5", named=False)
def hundred_directions(points, normals):
    """The bad directions are those of the normals, and none of a hundred fixed ones."""
    angles = np.linspace(0, np.pi, 100)
    directions = np.stack([np.cos(angles), np.sin(angles)])
    return all(spans(points[column]) for column in (np.abs(normals @ directions) > 1e-9).T)


@answers("04.5", named=False)
def compared_by_slope(points, normals):
    """two opposite vertical normals have different slopes, but are parallel."""
    slopes = normals[:, 1] / (normals[:, 0] + 1e-300)
    return all(spans(points[np.abs(slopes - slope) > 1e-9]) for slope in slopes)


@answers("04.5", named=False)
def compared_by_one_component(points, normals):
    """Two mirrored normals have the same first component, but are not parallel."""
    sizes = np.abs(normals[:, 0])
    return all(spans(points[np.abs(sizes - size) > 1e-9]) for size in sizes)


@answers("04.5")
def only_along_the_axes(points, normals):
    """Bad directions are found only at fixed angles, such as along the axes. If all samples
    are rotated, the answer must stay the same. Which directions are tested, and is n · m compared
    with zero up to rounding?
    """
    return spans(points[np.abs(normals[:, 0]) > 1e-9]) and spans(
        points[np.abs(normals[:, 1]) > 1e-9]
    )


@answers("04.5")
def three_are_enough(points, normals):
    """Three samples on one line are accepted here. Three points on a line do not determine an
    affine function.
    """
    return all(np.sum(np.abs(normals @ [-n[1], n[0]]) > 1e-9) >= 3 for n in normals)


@answers("04.5")
def directions_counted(points, normals):
    """This counts the different directions of the normals. The condition (4.5) also depends on the
    number and the positions of the samples that have each direction.
    """
    tensors = np.einsum("ni,nj->nij", normals, normals).round(8)
    return len(np.unique(tensors.reshape(len(normals), 4), axis=0)) > 2


@answers("04.5")
def the_whole_truth(points, normals):
    """The result is whether B' has full rank, which is a stronger condition than (4.5). If the
    lines of all normals pass through one point, (4.5) can hold, but the rank is less than six.
    """
    return np.linalg.matrix_rank(rows(local(points), normals), tol=1e-9) == 6


@answers("04.5")
def opposite_taken_for_different(points, normals):
    """A normal and its opposite count as two directions here. The sign of a normal is arbitrary,
    and n · m is zero for both or for neither.
    """
    return all(spans(points[np.abs(normals - n).max(axis=1) > 1e-9]) for n in normals)


@answers("04.5")
def holds_always(points, normals):
    """The answer is True for all inputs. Parallel normals violate (4.5): for which direction m is n
    · m zero for all of them?
    """
    return True


@answers("04.5")
def only_not_on_one_line(points, normals):
    """The answer is only that not all points are on one line. No direction omits a sample here. For
    which directions m is n · m zero for some sample?
    """
    return spans(points)


@answers("04.5")
def one_direction_is_enough(points, normals):
    """Here one good direction is enough. (4.5) must hold for every direction m."""
    return any(spans(points[np.abs(normals @ [-n[1], n[0]]) > 1e-9]) for n in normals)


@answers("04.5")
def first_direction_only(points, normals):
    """Only the direction that omits the first sample decides. Does the loop return before it has
    tested the others?
    """
    m = np.array([-normals[0, 1], normals[0, 0]])
    return spans(points[np.abs(normals @ m) > 1e-9])


@answers("04.5")
def ones_forgotten(points, normals):
    """Points on a line that does not pass through the origin are accepted here. Their array has
    rank 2. Which column of B is missing?
    """
    kept = [points[np.abs(normals @ [-n[1], n[0]]) > 1e-9] for n in normals]
    return all(np.linalg.matrix_rank(k, tol=1e-9) == 2 for k in kept)


@answers("04.5")
def tried_along_the_normals(points, normals):
    """The tested directions are the normals themselves. A sample is omitted for the direction
    perpendicular to its normal.
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
    """The outer edges are missing: there must be 2k samples. With the spokes alone the rank is
    always less than six.
    """
    return (center + ring) / 2, unit(turn(ring - center))


@answers("04.6")
def edges_for_normals(center, ring):
    """These are unit vectors along the edges. A normal is perpendicular to its edge."""
    start, end = star(center, ring, shifted(ring))
    return (start + end) / 2, unit(end - start)


@answers("04.6")
def as_long_as_the_edges(center, ring):
    """The normals are as long as the edges. The question asks for unit normals."""
    start, end = star(center, ring, shifted(ring))
    return (start + end) / 2, turn(end - start)


@answers("04.6")
def divided_by_one_number(center, ring):
    """All normals were divided by one number, the norm of the whole array. Each row must have
    length one. Along which axis must the squares be added?
    """
    start, end = star(center, ring, shifted(ring))
    return (start + end) / 2, turn(end - start) / np.linalg.norm(end - start)


@answers("04.6")
def ends_for_midpoints(center, ring):
    """The samples are at the ends of the edges. They must be at the midpoints, where an affine flow
    has its mean over the edge.
    """
    start, end = star(center, ring, shifted(ring))
    return end, unit(turn(end - start))


@answers("04.6")
def not_halved(center, ring):
    """The two ends were added, but not divided by two. Draw your points: they are
    outside the star.
    """
    start, end = star(center, ring, shifted(ring))
    return start + end, unit(turn(end - start))


@answers("04.6")
def rim_not_closed(center, ring):
    """One outer edge is missing: the one from the last neighbour to the first."""
    start, end = np.vstack([0 * ring + center, ring[:-1]]), np.vstack([ring, ring[1:]])
    return (start + end) / 2, unit(turn(end - start))


@answers("04.6")
def rolled_without_an_axis(center, ring):
    """The next neighbours have coordinates of two points: without `axis=0`, `np.roll` moves single
    numbers and not rows.
    """
    start, end = star(center, ring, np.roll(ring, -1))
    return (start + end) / 2, unit(turn(end - start))


@answers("04.6")
def rim_first(center, ring):
    """All samples are there, but the outer edges come before the spokes. Return the
    spokes first.
    """
    start, end = star(center, ring, shifted(ring))
    k = len(ring)
    return np.roll((start + end) / 2, k, axis=0), np.roll(unit(turn(end - start)), k, axis=0)


@answers("04.6")
def rim_backwards(center, ring):
    """The outer edges begin with the edge from the first neighbour to the last. The first one must
    be the edge to the next neighbour. Check the direction in which the array was rolled.
    """
    start, end = star(center, ring, np.vstack([ring[-1:], ring[:-1]]))
    return (start + end) / 2, unit(turn(end - start))


# 04.7 The conic


def conic(points):
    x, y = points.T
    return np.array([x**0, x, y, x**2, x * y, y**2]).T


@answers("04.7")
def vertices_counted(vertices):
    """This is the number of vertices, or six: no conic was found. Nine points on a circle have rank
    five. Were vertices counted, or singular values compared with zero exactly?
    """
    return min(len(vertices), 6)


@answers("04.7")
def lines_only(vertices):
    """This is the rank of the columns 1, x, y. It shows only whether the points lie on a line. The
    columns of degree two in (4.6) are missing.
    """
    return np.linalg.matrix_rank(basis(local(vertices)), tol=1e-9)


@answers("04.7")
def no_mixed_column(vertices):
    """The column of the products xy is missing, so the rank is at most five. Only conics with axes
    parallel to the coordinate axes are found.
    """
    return np.linalg.matrix_rank(np.delete(conic(local(vertices)), 4, axis=1), tol=1e-9)


@answers("04.7")
def circles_only(vertices):
    """The squares were added to one column, so only circles are found. In (4.6) x², xy and y² have
    a column each.
    """
    x, y = local(vertices).T
    return np.linalg.matrix_rank(np.array([x**0, x, y, x**2 + y**2]), tol=1e-9)


@answers("04.7")
def in_these_units(vertices):
    """In these units the columns differ by many orders of magnitude, and far from the origin they
    are nearly dependent. Subtract the mean of each coordinate and scale to size one before you form
    the squares.
    """
    return np.linalg.matrix_rank(conic(vertices))


@answers("04.7")
def tolerance_for_metres(vertices):
    """For points that are close together, the columns of degree two fall below this tolerance.
    Scale the points to size one before you form the squares.
    """
    return np.linalg.matrix_rank(conic(vertices - vertices.mean(axis=0)), tol=1e-9)


@answers("04.7")
def default_tolerance_for_conics(vertices):
    """The tolerance is smaller than that of the text, such as the default of `matrix_rank`, which
    is about 10⁻¹⁵. The text counts singular values below 10⁻⁹ as zero.
    """
    return np.linalg.matrix_rank(conic(local(vertices)))


@answers("04.7", named=False)
def coarse_tolerance_for_conics(vertices):
    """Points close to a conic are taken for points on it."""
    return np.linalg.matrix_rank(conic(local(vertices)), tol=0.05)


@answers("04.7", named=False)
def tolerance_of_a_thousandth_for_conics(vertices):
    """Points close to a conic are taken for points on it."""
    return np.linalg.matrix_rank(conic(local(vertices)), tol=1e-3)


@answers("04.7", named=False)
def tolerance_of_a_millionth_for_conics(vertices):
    """Points close to a conic are taken for points on it."""
    return np.linalg.matrix_rank(conic(local(vertices)), tol=1e-6)


@answers("04.7", named=False)
def of_the_first_vertices(vertices):
    """The first six vertices may be on a conic although the others are not."""
    return np.linalg.matrix_rank(conic(local(vertices))[:6], tol=1e-9)


@answers("04.7", named=False)
def by_eigenvalues_of_the_conics(vertices):
    """The eigenvalues are the squares of the singular values, and need the square of 10⁻⁹."""
    b = conic(local(vertices))
    return np.count_nonzero(np.linalg.eigvalsh(b.T @ b) > 1e-12)


@answers("04.7", named=False)
def moved_by_one_mean(vertices):
    """One mean of all coordinates leaves the points far from the origin."""
    moved = vertices - vertices.mean()
    return np.linalg.matrix_rank(conic(moved / np.ptp(moved)), tol=1e-9)


@answers("04.7", named=False)
def linear_columns_not_scaled(vertices):
    """The linear columns are in metres, the squares are scaled."""
    x, y = (vertices - vertices.mean(axis=0)).T
    u, v = local(vertices).T
    return np.linalg.matrix_rank(np.array([x**0, x, y, u**2, u * v, v**2]), tol=1e-9)


@answers("04.7")
def does_one_exist(vertices):
    """The function returns 1 if a conic passes through the points, else 0. The question asks for
    the rank.
    """
    return int(np.linalg.matrix_rank(conic(local(vertices)), tol=1e-9) < 6)
