"""What students write instead of notebook 06, and what each of them should hear."""

import numpy as np

from fieldgrade.authoring.catalogue import answers


def sides(q):
    """The sides opposite the corners, once round."""
    return np.array([q[2] - q[1], q[0] - q[2], q[1] - q[0]])


def lengths(q):
    return np.hypot(*sides(q).T)


def signed_area(q):
    (a, b), (c, d) = q[1] - q[0], q[2] - q[0]
    return (a * d - b * c) / 2


def clockwise_turn(vectors):
    return np.stack([vectors[..., 1], -vectors[..., 0]], axis=-1)


def turned_left(vectors):
    return -clockwise_turn(vectors)


def outward(q):
    return np.sign(signed_area(q)) * clockwise_turn(sides(q)) / lengths(q)[:, None]


def solved(matrix, v):
    return np.linalg.lstsq(matrix, v, rcond=None)[0]


def center(q):
    d = q[1:] - q[0]
    return q[0] + np.linalg.solve(d, (d**2).sum(axis=1) / 2)


def flow(x, m, s):
    return turned_left(x - m) + s * (x - m)


def raviart(q, v, x):
    return ((v * lengths(q))[:, None] * (x - q)).sum(axis=0) / (2 * abs(signed_area(q)))


# 06.1 outward_normals


@answers("06.1")
def inward(q):
    """All normals point inwards. Then v would be the velocity at which the fluid *enters*, and
    every velocity has the wrong sign. On which side of the line is the opposite corner?
    """
    return -outward(q)


@answers("06.1")
def outward_in_one_order_only(q):
    """Outward for triangles whose corners are listed counter-clockwise, and inward for the others.
    A mesh may contain both. How can you decide which direction is outward in a given triangle?
    """
    return clockwise_turn(sides(q)) / lengths(q)[:, None]


@answers("06.1")
def as_long_as_the_sides(q):
    """The directions are right, but each normal is as long as its side. N u is then
    a flow rate instead of a velocity, and long sides count more. What is a *unit* normal?
    """
    return np.sign(signed_area(q)) * clockwise_turn(sides(q))


@answers("06.1")
def along_the_sides(q):
    """These are unit vectors along the sides. A normal must be
    perpendicular to its side: rotate them by a right angle.
    """
    return sides(q) / lengths(q)[:, None]


@answers("06.1")
def in_another_order(q):
    """The normals are right, in another order: row a has the normal of a side that *begins* at
    corner a, and should have that of the side opposite. Which two corners are the ends of
    side a?
    """
    return np.roll(outward(q), -2, axis=0)


@answers("06.1")
def of_the_side_that_begins_here(q):
    """There are two mistakes. Row a has the normal of the side that begins at corner a instead of
    the one opposite. It is outward only if the corners are listed counter-clockwise. Begin with the
    first row, and name its side by its two ends.
    """
    along = np.roll(q, -1, axis=0) - q
    return clockwise_turn(along) / np.hypot(*along.T)[:, None]


@answers("06.1")
def from_the_centre(q):
    """These unit vectors point from the centroid to the middles of the sides. They are
    perpendicular to the sides only in an equilateral triangle. Check the scalar product with a
    side.
    """
    away = q.mean(axis=0) - q
    return away / np.hypot(*away.T)[:, None]


@answers("06.1")
def divided_by_one_length(q):
    """All three normals are divided by the same number, the length of the whole array. Each has a
    length of its own.
    """
    n = np.sign(signed_area(q)) * clockwise_turn(sides(q))
    return n / np.linalg.norm(n)


# 06.2 cell_velocity


@answers("06.2")
def mean_of_the_projections(q, v):
    """This is a third of the sum of the vectors v n. Each is only the component of the velocity
    across one side, so the result is too short, by a factor of about two. The equations must be
    solved together.
    """
    return v @ outward(q) / 3


@answers("06.2")
def right_in_equilateral_triangles(q, v):
    """This is two thirds of the sum of the vectors v n, which is right only in an equilateral
    triangle. In no other is the matrix of the normal equations a multiple of the identity. Which
    system has to be solved?
    """
    return 2 * v @ outward(q) / 3


@answers("06.2")
def first_two_equations(q, v):
    """This velocity satisfies the first two equations and ignores the third. With the corners in
    another order another velocity would come out. Least squares treats all three alike.
    """
    return np.linalg.solve(outward(q)[:2], v[:2])


@answers("06.2")
def last_two_equations(q, v):
    """This velocity satisfies the last two equations and ignores the first. Which two are used is
    an accident of the numbering. Least squares treats all three alike.
    """
    return np.linalg.solve(outward(q)[1:], v[1:])


@answers("06.2")
def normals_inward(q, v):
    """The velocity has the opposite sign, as if the normals pointed inwards: v is the velocity at
    which the fluid *leaves*.
    """
    return -solved(outward(q), v)


@answers("06.2")
def weighted_by_the_lengths(q, v):
    """This is the result of least squares with each equation multiplied by the length of its side.
    It is also the mean of the three solutions of two equations, and (6.8) at the centroid. In (6.2)
    the three residuals count alike.
    """
    size = lengths(q)
    return solved(size[:, None] * outward(q), size * v)


@answers("06.2")
def normals_not_of_unit_length(q, v):
    """The normals are as long as the sides, while v is a velocity and not yet multiplied by the
    length. The two sides of (6.1) do not fit: a constant velocity is not reproduced.
    """
    return solved(lengths(q)[:, None] * outward(q), v)


@answers("06.2")
def normal_equations_without_the_right_side(q, v):
    """This is Nᵀv, the right-hand side of the normal equations, and not their solution. Which
    matrix multiplies u in these equations?
    """
    return outward(q).T @ v


@answers("06.2")
def counter_clockwise_assumed(q, v):
    """The velocity has the wrong sign for the triangles whose corners are listed clockwise. Are
    your normals outward for both orders?
    """
    return np.sign(signed_area(q)) * solved(outward(q), v)


@answers("06.2", named=False)
def least_norm_with_a_small_ridge(q, v):
    """A small number is added to the normal matrix: the velocity is a little too short."""
    n = outward(q)
    return np.linalg.solve(n.T @ n + 1e-6 * np.eye(2), n.T @ v)


# 06.3 defect


@answers("06.3")
def root_mean_square(q, v):
    """This is the root of the *mean* of the three squared differences. The defect is the length of
    their vector: the root of the sum.
    """
    return abs(lengths(q) @ v) / np.linalg.norm(lengths(q)) / np.sqrt(3)


@answers("06.3")
def sum_without_lengths(q, v):
    """The normal velocities are added without the lengths. The outflow through a side is the normal
    velocity *times* the length. Without the lengths a constant velocity would have a defect.
    """
    return abs(v.sum()) / np.sqrt(3)


@answers("06.3")
def squared_defect(q, v):
    """This is the square of the defect: the root is missing. Doubling the data should double it."""
    return (lengths(q) @ v) ** 2 / (lengths(q) @ lengths(q))


@answers("06.3")
def with_a_sign(q, v):
    """The absolute value is right, the sign is not: the defect is the length of a vector. The sign
    belongs to the divergence, which is negative for a sink.
    """
    return lengths(q) @ v / np.linalg.norm(lengths(q))


@answers("06.3")
def outflow_not_divided(q, v):
    """This is the net outflow, a velocity times a length. The defect is a velocity. Which length is
    the denominator of (6.4)?
    """
    return abs(lengths(q) @ v)


@answers("06.3")
def divided_by_the_perimeter(q, v):
    """The outflow is divided by the sum of the lengths. The denominator of (6.4) is the norm of the
    vector of lengths: the root of the sum of their squares.
    """
    return abs(lengths(q) @ v) / lengths(q).sum()


@answers("06.3")
def divergence(q, v):
    """This is the outflow divided by the area: the size of the divergence. It says how fast the
    fluid expands; the defect is a velocity. Which length is in the denominator of (6.4)?
    """
    return abs(lengths(q) @ v) / abs(signed_area(q))


@answers("06.3")
def largest_residual(q, v):
    """This is the largest of the three differences. The defect is the length of the vector of all
    three.
    """
    return np.abs(outward(q) @ solved(outward(q), v) - v).max()


@answers("06.3")
def residual_as_a_vector(q, v):
    """These are the three differences of N u and v. The defect is the length of
    this vector, one number.
    """
    return outward(q) @ solved(outward(q), v) - v


# 06.4 circumcenter


@answers("06.4")
def centroid(q):
    """This is the centroid, the mean of the corners. It is equally far from them only in an
    equilateral triangle.
    """
    return q.mean(axis=0)


@answers("06.4")
def incentre(q):
    """This is the incentre, the centre of the circle that touches the three *sides*. The
    circumcentre is the centre of the circle through the three corners.
    """
    return lengths(q) @ q / lengths(q).sum()


@answers("06.4")
def factor_two_missing(q):
    """Seen from the first corner the result is twice as far as it should be. Compare the factors
    on both sides of (6.5).
    """
    return 2 * center(q) - q[0]


@answers("06.4")
def as_seen_from_the_corner(q):
    """This is O − q₁, the circumcentre relative to the first corner. Which step is missing?"""
    return center(q) - q[0]


@answers("06.4")
def orthocentre(q):
    """This is the orthocentre, where the heights meet, not where the perpendicular bisectors meet.
    Which point is equally far from the corners?
    """
    return q.sum(axis=0) - 2 * center(q)


@answers("06.4")
def middle_of_the_box(q):
    """This is the middle of the box around the triangle. How far is it from each corner?"""
    return (q.min(axis=0) + q.max(axis=0)) / 2


@answers("06.4")
def lengths_not_squared(q):
    """Your right side contains the lengths of the sides, where (6.5) has another power of them. A
    length cannot be equal to a product of two lengths in every unit. Look at the exponent.
    """
    d = q[1:] - q[0]
    return q[0] + np.linalg.solve(2 * d, np.hypot(*d.T))


@answers("06.4", named=False)
def differences_of_squares(q):
    """Far from the origin the differences of squared coordinates lose digits."""
    return np.linalg.solve(2 * (q[1:] - q[0]), np.sum(q[1:] ** 2, axis=1) - q[0] @ q[0])


# 06.5 truth


@answers("06.5")
def about_the_origin(x, m, s):
    """The centre m is not used: this field turns about the origin. Where should the velocity
    vanish?
    """
    return flow(x, 0 * m, s)


@answers("06.5")
def clockwise(x, m, s):
    """The rotation is clockwise, as with the opposite sign of J. Apply J of (6.6) to (1, 0) by
    hand.
    """
    return -turned_left(x - m) + s * (x - m)


@answers("06.5")
def rotation_only(x, m, s):
    """The field is the rotation only: s has no effect. The second term of (6.6) is missing."""
    return flow(x, m, 0)


@answers("06.5")
def expansion_from_the_origin(x, m, s):
    """The rotation is about m, but the expansion starts from the origin. Both terms of (6.6) have
    the same vector.
    """
    return turned_left(x - m) + s * x


@answers("06.5")
def everything_times_s(x, m, s):
    """The whole field has been multiplied by s, the rotation too. For s = 0 the fluid should
    still turn.
    """
    return s * (turned_left(x - m) + x - m)


@answers("06.5")
def mirrored(x, m, s):
    """The components are exchanged without a change of sign: this is a reflection, not a rotation.
    Look at the signs in J.
    """
    return (x - m)[:, ::-1] + s * (x - m)


@answers("06.5")
def about_the_mean_of_the_points(x, m, s):
    """The field rotates about the mean of the points x. Its centre is the argument m: evaluated at
    one point only, the field must not vanish there, unless the point is m.
    """
    return flow(x, x.mean(axis=0), s)


@answers("06.5")
def size_of_s(x, m, s):
    """For negative s the field expands, as for positive s. With s < 0 the fluid must flow towards
    the centre: use s with its sign.
    """
    return flow(x, m, abs(s))


# 06.6 errors


def compared(points, triangles, s, data=lambda q, middles: middles):
    """Squared differences of each cell, of shape (T, 5): circumcentre, centroid, and the three
    corners.
    """
    m = points.mean(axis=0)
    found = []
    for q in points[triangles]:
        at = data(q, 0.5 * (np.roll(q, -1, axis=0) + np.roll(q, -2, axis=0)))
        u = solved(outward(q), np.einsum("ak,ak->a", outward(q), flow(at, m, s)))
        places = np.concatenate([[center(q)], [q.mean(axis=0)], q])
        found.append(((u - flow(places, m, s)) ** 2).sum(axis=1))
    return np.array(found)


def three(squares, join=lambda x: np.sqrt(np.mean(x))):
    return np.array([join(squares[:, 0]), join(squares[:, 1]), join(squares[:, 2:])])


@answers("06.6")
def mean_squares(points, triangles, s):
    """These are the means of the squares: the roots in (6.7) are missing. An error must have the
    unit of a velocity.
    """
    return three(compared(points, triangles, s), np.mean)


@answers("06.6")
def largest_errors(points, triangles, s):
    """These are the largest errors. One triangle, often a flat one, decides about each. (6.7)
    has a mean over all cells.
    """
    return three(compared(points, triangles, s), lambda x: np.sqrt(np.max(x)))


@answers("06.6")
def means_of_lengths(points, triangles, s):
    """These are means of the lengths of the differences. In (6.7) the lengths are squared first,
    and the root comes last.
    """
    return three(compared(points, triangles, s), lambda x: np.mean(np.sqrt(x)))


@answers("06.6")
def mean_over_components_too(points, triangles, s):
    """These are too small by the root of two: the mean was taken over the two components as well.
    The square of a length is the *sum* of the squares of the components.
    """
    return three(compared(points, triangles, s)) / np.sqrt(2)


@answers("06.6")
def sums_instead_of_means(points, triangles, s):
    """The squares are added and not averaged, so that a finer mesh of the same quality looks
    worse. How many terms has each sum?
    """
    return three(compared(points, triangles, s), lambda x: np.sqrt(np.sum(x)))


@answers("06.6")
def sums_over_the_cells(points, triangles, s):
    """The squares are added over the cells, and averaged only over the three corners. In (6.7) the
    mean is over the cells, too.
    """
    squares = compared(points, triangles, s)
    return np.sqrt([squares[:, 0].sum(), squares[:, 1].sum(), squares[:, 2:].mean(axis=1).sum()])


@answers("06.6")
def largest_over_the_cells(points, triangles, s):
    """These are the errors of the worst cell, with the mean over its corners in the third number.
    (6.7) has a mean over all cells.
    """
    squares = compared(points, triangles, s)
    return np.sqrt([squares[:, 0].max(), squares[:, 1].max(), squares[:, 2:].mean(axis=1).max()])


@answers("06.6")
def sum_over_the_corners(points, triangles, s):
    """The third number is too large by the root of three: the squares were summed over the three
    corners of a cell. In (6.7) the mean is over the corners as well.
    """
    return three(compared(points, triangles, s)) * np.array([1, 1, np.sqrt(3)])


@answers("06.6")
def mean_of_the_vertex_velocities(points, triangles, s):
    """The third number compares with the *mean* of the velocities at the three corners. For an
    affine field that is the truth at the centroid, so it repeats the second number. (6.7)
    compares with each corner.
    """
    squares = compared(points, triangles, s)
    return np.sqrt(squares[:, [0, 1, 1]].mean(axis=0))


@answers("06.6")
def opposite_corner(points, triangles, s):
    """The normal velocity of side a is taken at corner a, which is opposite to it. Row a of N
    belongs to the side that does *not* have that corner.
    """
    return three(compared(points, triangles, s, data=lambda q, _: q))


@answers("06.6")
def middles_in_another_order(points, triangles, s):
    """The midpoints of the sides are right, but not in the order of the normals: each normal is
    combined with the velocity at the midpoint of another side. Side a is opposite to corner a.
    """
    return three(compared(points, triangles, s, data=lambda q, p: np.roll(p, 1, axis=0)))


@answers("06.6")
def centroid_for_circumcentre(points, triangles, s):
    """The first two numbers are equal: the first was taken at the centroids too. A circumcentre
    is equally far from the three corners.
    """
    squares = compared(points, triangles, s)
    return np.sqrt([squares[:, 1].mean(), squares[:, 1].mean(), squares[:, 2:].mean()])


@answers("06.6")
def circumcentre_and_centroid_exchanged(points, triangles, s):
    """The first two numbers are exchanged: that of the circumcentres comes first."""
    return three(compared(points, triangles, s))[[1, 0, 2]]


# 06.8 raviart_thomas


@answers("06.8")
def towards_the_corner(q, v, x):
    """The result has the wrong sign. In (6.8) the vectors point from the corners to x, the normals
    point outward, and the heights are positive.
    """
    return -raviart(q, v, x)


@answers("06.8")
def area_not_doubled(q, v, x):
    """Twice too large: the height is twice the area over the side. What is the area of a triangle
    in terms of a side and its height?
    """
    return 2 * raviart(q, v, x)


@answers("06.8")
def lengths_forgotten(q, v, x):
    """The lengths of the sides are missing: v has been divided by twice the area instead of by a
    height. What is h in (6.8)?
    """
    return raviart(q, v / lengths(q), x)


@answers("06.8")
def area_with_a_sign(q, v, x):
    """The sign is wrong for triangles whose corners are listed clockwise, as the determinant is
    negative there. An area has no sign.
    """
    return np.sign(signed_area(q)) * raviart(q, v, x)


@answers("06.8")
def from_the_middles(q, v, x):
    """The vectors start at the midpoints of the sides. In (6.8) they start at the opposite corners:
    only then is each term parallel to the two other sides along these sides.
    """
    middles = (np.roll(q, -1, axis=0) + np.roll(q, -2, axis=0)) / 2
    return ((v * lengths(q))[:, None] * (x - middles)).sum(axis=0) / (2 * abs(signed_area(q)))


@answers("06.8")
def multiplied_by_the_heights(q, v, x):
    """The velocities are multiplied by the heights instead of divided by them. A velocity times
    two lengths is no velocity.
    """
    h = 2 * abs(signed_area(q)) / lengths(q)
    return (v * h) @ (x - q)


@answers("06.8")
def the_constant_velocity(q, v, x):
    """This is the constant velocity of question 06.2; the point x has no effect. The field of
    (6.8) changes from point to point.
    """
    return solved(outward(q), v)


@answers("06.8")
def corners_in_another_order(q, v, x):
    """Each velocity is combined with the wrong corner. Side a is opposite to corner a, and its term
    in (6.8) has the vector from *that* corner.
    """
    return ((v * lengths(q))[:, None] * (x - np.roll(q, 1, axis=0))).sum(axis=0) / (
        2 * abs(signed_area(q))
    )
