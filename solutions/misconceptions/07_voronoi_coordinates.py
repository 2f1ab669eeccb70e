"""What students write instead of notebook 07, and what each of them should hear."""

import numpy as np

from fieldgrade.authoring.catalogue import answers


def circle(angle):
    return np.stack([np.cos(angle), np.sin(angle)], axis=1)


def cross(u, v):
    return u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0]


def heights(center, rim, corners, x):
    """The two factors below (7.5), for each corner."""
    j, k = rim - center, np.roll(rim, -1, axis=0) - center
    return np.sum(j * (corners - x), axis=1), np.sum(k * (corners - x), axis=1)


def double_areas(center, rim):
    return np.abs(cross(rim - center, np.roll(rim, -1, axis=0) - center))


def one_place(center, rim, corners, x):
    j, k = heights(center, rim, corners, x)
    return double_areas(center, rim) / (j * k)


def many_places(center, rim, corners, x):
    return np.array([one_place(center, rim, corners, place) for place in x])


def normalized(w):
    return w / w.sum(axis=1, keepdims=True)


# 07.1


@answers("07.1")
def angle_in_degrees(center, radius, turn):
    """The corners lie on the circle, but not evenly: the steps are 60, and NumPy's cosine takes
    radians. What is the factor of b in (7.1)?
    """
    return center + radius * circle(turn + 60.0 * np.arange(6))


@answers("07.1")
def center_forgotten(center, radius, turn):
    """This hexagon is centred at the origin. Every point of (7.1) contains the centre as its first
    term.
    """
    return radius * circle(turn + np.pi / 3 * np.arange(6))


@answers("07.1")
def turn_forgotten(center, radius, turn):
    """The first corner lies to the right of the centre, whatever the angle α is. Where does α enter
    (7.1)?
    """
    return center + radius * circle(np.pi / 3 * np.arange(6))


@answers("07.1")
def first_corner_twice(center, radius, turn):
    """The last corner is the first again: six numbers from 0 to 2π with both ends make five steps.
    How wide is a step in (7.1)?
    """
    return center + radius * circle(turn + np.linspace(0, 2 * np.pi, 6))


@answers("07.1")
def clockwise(center, radius, turn):
    """The corners are those of the hexagon, but they go round clockwise. In (7.1) the angle grows
    with b; the sign of a sine, or of the step, decides.
    """
    return center + radius * circle(turn - np.pi / 3 * np.arange(6))


@answers("07.1")
def diameter_for_radius(center, radius, turn):
    """The hexagon is half as large as asked: the number given is its radius, from the centre to a
    corner, not its diameter.
    """
    return center + radius / 2 * circle(turn + np.pi / 3 * np.arange(6))


@answers("07.1")
def turn_taken_as_degrees(center, radius, turn):
    """The angle α was converted from degrees. It is given in radians already, as NumPy's cosine
    takes it.
    """
    return center + radius * circle(np.radians(turn) + np.pi / 3 * np.arange(6))


@answers("07.1")
def turned_by_minus_the_angle(center, radius, turn):
    """The corners go round counter-clockwise, but the hexagon is turned by −α. Look at the sign of
    α in (7.1).
    """
    return center + radius * circle(-turn + np.pi / 3 * np.arange(6))


@answers("07.1")
def sine_and_cosine_exchanged(center, radius, turn):
    """The two coordinates, relative to the centre, are exchanged. In (7.1) the cosine comes
    first.
    """
    return center + radius * circle(turn + np.pi / 3 * np.arange(6))[:, ::-1]


@answers("07.1")
def begins_with_the_second_corner(center, radius, turn):
    """The first row is x₁ and the last one x₀. In (7.1) b runs from 0 to 5."""
    return center + radius * circle(turn + np.pi / 3 * np.arange(1, 7))


@answers("07.1", named=False)
def absolute_center(center, radius, turn):
    """The coordinates of the centre have lost their signs."""
    return np.abs(center) + radius * circle(turn + np.pi / 3 * np.arange(6))


@answers("07.1", named=False)
def absolute_angle(center, radius, turn):
    """The angle has lost its sign: the hexagon was always turned to the left."""
    return center + radius * circle(abs(turn) + np.pi / 3 * np.arange(6))


# 07.2


@answers("07.2", named=False)
def differences_of_squares(a, b, c):
    """Far from the origin the differences of squared coordinates lose digits."""
    return np.linalg.solve(2 * np.array([b - a, c - b]), [b @ b - a @ a, c @ c - b @ b])


@answers("07.2")
def centroid(a, b, c):
    """This is the centroid, the mean of the corners. Only in an equilateral triangle has it the
    same distance from all corners, which is what (7.2) requires.
    """
    return (a + b + c) / 3


@answers("07.2")
def half_forgotten(a, b, c):
    """The point is twice as far from the corner as it should be. Expand the squares in (7.2) once
    more: the linear term has a factor 2.
    """
    edges = np.array([b - a, c - a])
    return a + np.linalg.solve(edges, np.sum(edges**2, axis=1))


@answers("07.2")
def not_moved_back(a, b, c):
    """This is the circumcentre relative to the first corner. The unknown of the equations is a
    difference; which step is missing?
    """
    edges = np.array([b - a, c - a])
    return np.linalg.solve(edges, np.sum(edges**2, axis=1) / 2)


@answers("07.2")
def lengths_not_squared(a, b, c):
    """The right side of the equations contains lengths instead of squares of lengths. Square (7.2)
    and look at the units of both sides.
    """
    edges = np.array([b - a, c - a])
    return a + np.linalg.solve(edges, np.linalg.norm(edges, axis=1) / 2)


@answers("07.2")
def edges_in_columns(a, b, c):
    """The matrix is transposed. Each equation belongs to one edge, so each edge is a row of the
    matrix. Write the first equation out.
    """
    edges = np.column_stack([b - a, c - a])
    return a + np.linalg.solve(edges, np.sum(edges**2, axis=0) / 2)


@answers("07.2")
def incenter(a, b, c):
    """This is the incentre, which has the same distance from the three sides. The circumcentre has
    the same distance from the three corners.
    """
    sides = np.array([np.linalg.norm(b - c), np.linalg.norm(c - a), np.linalg.norm(a - b)])
    return sides @ np.array([a, b, c]) / sides.sum()


@answers("07.2")
def orthocenter(a, b, c):
    """This is where the altitudes meet, which go through the corners. The lines that meet in the
    circumcentre go through the middles of the edges.
    """
    edges = np.array([c - b, c - a])
    return np.linalg.solve(edges, [(c - b) @ a, (c - a) @ b])


# 07.3


@answers("07.3")
def sign_kept(a, b, c):
    """The absolute value is right, but the sign depends on the order of the corners. An area is
    positive; (7.4) has an absolute value.
    """
    return cross(b - a, c - a) / 2


@answers("07.3", named=False)
def determinant_of_coordinates(a, b, c):
    """Digits are lost far from the origin, where differences are exact."""
    return abs(np.linalg.det(np.array([[1, *a], [1, *b], [1, *c]], dtype=float))) / 2


@answers("07.3")
def parallelogram(a, b, c):
    """This is the area of the parallelogram over two edges. How much of it is the triangle?"""
    return abs(cross(b - a, c - a))


@answers("07.3")
def sine_forgotten(a, b, c):
    """This takes every triangle for a right-angled one: half of the product of two sides. How
    wide the angle between them is must matter. Compare (7.4).
    """
    return np.linalg.norm(b - a) * np.linalg.norm(c - a) / 2


@answers("07.3")
def scalar_for_determinant(a, b, c):
    """This is half of the scalar product of two edges, which is zero if they are perpendicular,
    where the area is largest. (7.4) asks for a determinant.
    """
    return abs((b - a) @ (c - a)) / 2


@answers("07.3")
def origin_for_corner(a, b, c):
    """The determinant is that of two corners, not of two edges: it is the area of a triangle with
    the origin. Does your result change when all corners move together?
    """
    return abs(cross(b, c)) / 2


@answers("07.3", named=False)
def heron(a, b, c):
    """In a needle the sum of two sides is nearly the third one, and their difference has lost its
    digits.
    """
    x, y, z = (np.linalg.norm(e) for e in (b - a, c - b, a - c))
    s = (x + y + z) / 2
    return np.sqrt(max(s * (s - x) * (s - y) * (s - z), 0.0))


@answers("07.3", named=False)
def shoelace(a, b, c):
    """Far from the origin the products of the coordinates themselves lose digits."""
    return abs(cross(a, b) + cross(b, c) + cross(c, a)) / 2


# 07.4


@answers("07.4")
def areas_dropped(center, rim, corners, x):
    """The areas are missing: the numerator is one. In a regular hexagon all areas are equal,
    elsewhere linear fields are not reproduced. What is the numerator of (7.5)?
    """
    j, k = heights(center, rim, corners, x)
    return 1 / (j * k)


@answers("07.4")
def factor_two_dropped(center, rim, corners, x):
    """These are halves of the weights. The coordinates would be right, since a common factor
    cancels. But the determinant of two edges is twice the area of the triangle.
    """
    return one_place(center, rim, corners, x) / 2


@answers("07.4")
def areas_squared(center, rim, corners, x):
    """The area enters squared. If all lengths are doubled, each weight must become a quarter; which
    powers of a length do your numerator and denominator have?
    """
    return double_areas(center, rim) * one_place(center, rim, corners, x)


@answers("07.4")
def normals_of_length_one_below(center, rim, corners, x):
    """The denominator has unit normals, as in (7.3), and the numerator has twice the area, as in
    (7.5). The lengths cancel only if both are treated alike.
    """
    spokes = np.linalg.norm(rim - center, axis=1)
    return one_place(center, rim, corners, x) * spokes * np.roll(spokes, -1)


@answers("07.4")
def product_over_all_neighbours(center, rim, corners, x):
    """The product runs over all neighbours. Only two edges of the cell meet in a corner, so the
    denominator of (7.5) has two factors.
    """
    below = [np.prod((rim - center) @ (p - x)) for p in corners]
    return double_areas(center, rim) / below


@answers("07.4")
def neighbour_before(center, rim, corners, x):
    """The corner is paired with the wrong triangle: that of the neighbour before, not of the one
    that follows. The first corner belongs to the first and the second neighbour; see (7.5).
    """
    j = rim - center
    k = np.roll(rim, 1, axis=0) - center
    return np.abs(cross(j, k)) / (
        np.sum(j * (corners - x), axis=1) * np.sum(k * (corners - x), axis=1)
    )


@answers("07.4")
def next_but_one(center, rim, corners, x):
    """The two neighbours of a corner are not next to each other: one has been skipped. They must be
    corners of one triangle of the mesh.
    """
    j = rim - center
    k = np.roll(rim, -2, axis=0) - center
    return np.abs(cross(j, k)) / (
        np.sum(j * (corners - x), axis=1) * np.sum(k * (corners - x), axis=1)
    )


@answers("07.4")
def spokes_from_the_origin(center, rim, corners, x):
    """The denominator has the neighbours themselves instead of their differences from the vertex.
    It is right only for a vertex at the origin.
    """
    j, k = rim, np.roll(rim, -1, axis=0)
    below = np.sum(j * (corners - x), axis=1) * np.sum(k * (corners - x), axis=1)
    return double_areas(center, rim) / below


@answers("07.4")
def spokes_from_the_place(center, rim, corners, x):
    """The neighbours are taken relative to the point x instead of relative to the vertex. The
    normals of a cell do not depend on x. Compare the two differences in (7.5).
    """
    j, k = rim - x, np.roll(rim, -1, axis=0) - x
    below = np.sum(j * (corners - x), axis=1) * np.sum(k * (corners - x), axis=1)
    return double_areas(center, rim) / below


@answers("07.4")
def from_the_center_not_the_place(center, rim, corners, x):
    """These weights do not depend on the point: the corners are taken relative to the vertex. They
    are right at the vertex only. Where is x in (7.5)?
    """
    return one_place(center, rim, corners, center)


@answers("07.4")
def sum_below(center, rim, corners, x):
    """The two factors of the denominator were added. In (7.5) they are multiplied, so that one
    small factor suffices for a large weight.
    """
    j, k = heights(center, rim, corners, x)
    return double_areas(center, rim) / (j + k)


@answers("07.4")
def divided_by_the_sum(center, rim, corners, x):
    """These are coordinates: the weights divided by their sum. This is the next question; here the
    weights (7.5) themselves are required.
    """
    w = one_place(center, rim, corners, x)
    return w / w.sum()


@answers("07.4")
def orientation_kept(center, rim, corners, x):
    """For neighbours listed clockwise the weights have the wrong sign, which is the sign of the
    determinant. See the absolute value in (7.4).
    """
    j, k = heights(center, rim, corners, x)
    return cross(rim - center, np.roll(rim, -1, axis=0) - center) / (j * k)


def positive(values):
    return np.abs(values)


@answers("07.4", named=False)
def size_of_the_weights(center, rim, corners, x):
    """Outside the cell some weights are negative; here all of them are positive."""
    return positive(one_place(center, rim, corners, x))


@answers("07.4", named=False)
def from_areas_in_the_cell(center, rim, corners, x):
    """These areas are right inside the cell; outside one of them must be negative."""
    before, after = np.roll(corners, 1, axis=0), np.roll(corners, -1, axis=0)
    first, second = (
        positive(cross(before - x, corners - x)),
        positive(cross(corners - x, after - x)),
    )
    return positive(cross(corners - before, after - before)) / (first * second)


@answers("07.4", named=False)
def size_of_one_factor(center, rim, corners, x):
    """Outside the cell one factor is negative; here its absolute value was taken."""
    j, k = heights(center, rim, corners, x)
    return double_areas(center, rim) / (positive(j) * k)


# 07.5


@answers("07.5")
def not_normalized(center, rim, corners, x):
    """These are the weights, not divided by their sum. A constant field is not reproduced: what
    do the coordinates at a point have to add up to?
    """
    return many_places(center, rim, corners, x)


@answers("07.5")
def normalized_over_the_places(center, rim, corners, x):
    """The sums run over the points instead of over the corners: the columns sum to one, and the
    rows should. The coordinates of a point must not depend on the other points.
    """
    w = many_places(center, rim, corners, x)
    return w / w.sum(axis=0)


@answers("07.5")
def divided_by_everything(center, rim, corners, x):
    """All weights at all points together add up to one. Each point needs a sum of its own: which
    axis is to be summed?
    """
    w = many_places(center, rim, corners, x)
    return w / w.sum()


@answers("07.5")
def divided_by_the_largest(center, rim, corners, x):
    """The largest entry of each row is one, not the sum. Only after division by the sum
    is a constant reproduced; see (7.6).
    """
    w = many_places(center, rim, corners, x)
    return w / w.max(axis=1, keepdims=True)


@answers("07.5")
def of_unit_length(center, rim, corners, x):
    """The rows have length one: they were divided by the root of the sum of squares. Coordinates
    have the sum one.
    """
    w = many_places(center, rim, corners, x)
    return w / np.linalg.norm(w, axis=1, keepdims=True)


@answers("07.5")
def inverse_distances(center, rim, corners, x):
    """These are inverse distances to the corners, divided by their sum. They do not depend on the
    edges, and linear fields are not reproduced. Use the weights of (7.5).
    """
    return normalized(1 / np.linalg.norm(corners - x[:, None], axis=2))


# 07.6


@answers("07.6")
def around_the_origin(center, corners, steps):
    """The spiral is centred at the origin instead of at the vertex. What is the first term of
    (7.7)?
    """
    return spiral(np.zeros(2), np.linalg.norm((corners[0] + corners[1]) / 2 - center), steps)


def spiral(center, r, steps):
    n = np.arange(1, steps + 1)
    return center + (r / n)[:, None] * circle(2 * np.pi * n / steps)


@answers("07.6")
def radius_to_a_corner(center, corners, steps):
    """r is the distance to a corner here. It should end in the middle of an edge; else the spiral
    may begin outside the cell.
    """
    return spiral(center, np.linalg.norm(corners[0] - center), steps)


@answers("07.6")
def radius_from_the_origin(center, corners, steps):
    """r is the distance of the middle of the edge from the origin. It should be that from the
    vertex: there is a difference between the bars of (7.7).
    """
    return spiral(center, np.linalg.norm((corners[0] + corners[1]) / 2), steps)


@answers("07.6")
def corners_that_are_no_neighbours(center, corners, steps):
    """The two corners do not share an edge, so their midpoint lies inside the cell and r is too
    small. Which two corners does the docstring name?
    """
    return spiral(center, np.linalg.norm((corners[0] + corners[2]) / 2 - center), steps)


@answers("07.6")
def opposite_corners(center, corners, steps):
    """The two corners lie opposite each other, and their middle is near the centre: in a regular
    hexagon r would be zero. In (7.7) they are neighbours.
    """
    return spiral(center, np.linalg.norm((corners[0] + corners[3]) / 2 - center), steps)


@answers("07.6")
def half_the_length_of_the_edge(center, corners, steps):
    """The two corners have been subtracted from each other: r is half of the edge between them. The
    middle of an edge has a sum in it.
    """
    return spiral(center, np.linalg.norm(corners[0] - corners[1]) / 2, steps)


@answers("07.6")
def counted_from_zero(center, corners, steps):
    """n begins at zero: the first point is infinitely far away, and the last one is missing. What
    are the first and the last n in (7.7)?
    """
    n = np.arange(steps)
    with np.errstate(divide="ignore", invalid="ignore"):
        r = np.linalg.norm((corners[0] + corners[1]) / 2 - center) / n
        return center + r[:, None] * circle(2 * np.pi * n / steps)


@answers("07.6")
def degrees_in_the_cosine(center, corners, steps):
    """The angles are degrees, and the cosine takes radians, so the points jump about. In which
    unit is Δθ of (7.7)?
    """
    n = np.arange(1, steps + 1)
    r = np.linalg.norm((corners[0] + corners[1]) / 2 - center)
    return center + (r / n)[:, None] * circle(360.0 / steps * n)


@answers("07.6")
def a_circle(center, corners, steps):
    """All points have one distance from the centre: this is a circle. How does the radius of (7.7)
    depend on n?
    """
    r = np.linalg.norm((corners[0] + corners[1]) / 2 - center)
    return center + r * circle(2 * np.pi / steps * np.arange(1, steps + 1))


@answers("07.6")
def shrinking_evenly(center, corners, steps):
    """The radius falls in equal steps here, like that of a coiled rope. In (7.7) it is divided by
    n, so the second point is already half as far away.
    """
    n = np.arange(1, steps + 1)
    r = np.linalg.norm((corners[0] + corners[1]) / 2 - center) * (1 - (n - 1) / steps)
    return center + r[:, None] * circle(2 * np.pi * n / steps)


@answers("07.6")
def one_step_too_few(center, corners, steps):
    """The angles are too large: the circle was divided into one part fewer than there are points.
    The last point of (7.7) has gone round once.
    """
    n = np.arange(1, steps + 1)
    r = np.linalg.norm((corners[0] + corners[1]) / 2 - center)
    return center + (r / n)[:, None] * circle(2 * np.pi * n / (steps - 1))


@answers("07.6")
def from_the_midpoint_of_the_edge(center, corners, steps):
    """The angle nΔθ was measured from the direction of the midpoint of the edge. In (7.7) it is
    measured from the first coordinate axis.
    """
    n = np.arange(1, steps + 1)
    away = (corners[0] + corners[1]) / 2 - center
    angle = np.arctan2(away[1], away[0]) + 2 * np.pi * n / steps
    return center + (np.linalg.norm(away) / n)[:, None] * circle(angle)


@answers("07.6")
def clockwise_spiral(center, corners, steps):
    """The spiral is clockwise. In (7.7) the angle grows with n, so it must be counter-clockwise;
    look at the sign of the sine.
    """
    n = np.arange(1, steps + 1)
    r = np.linalg.norm((corners[0] + corners[1]) / 2 - center)
    return center + (r / n)[:, None] * circle(-2 * np.pi * n / steps)


def distances_to_the_middles(center, corners):
    return np.linalg.norm((corners + np.roll(corners, -1, axis=0)) / 2 - center, axis=1)


@answers("07.6")
def radius_to_the_nearest_edge(center, corners, steps):
    """r is the smallest of the distances to the middles of the edges. (7.7) has the edge of the
    first two corners.
    """
    return spiral(center, distances_to_the_middles(center, corners).min(), steps)


@answers("07.6")
def radius_to_the_edge_before(center, corners, steps):
    """r is the distance to the middle of the edge from the last corner to the first. (7.7) has the
    edge of the first two corners.
    """
    return spiral(center, distances_to_the_middles(center, corners)[-1], steps)


# 07.7


@answers("07.7")
def weights_instead_of_coordinates(center, rim, corners, values, x):
    """The values are mixed with weights that have not been divided by their sum, so even a
    constant is not reproduced. (7.8) has ω, not w.
    """
    return many_places(center, rim, corners, x) @ values


@answers("07.7")
def between_the_values(center, rim, corners, values, x):
    """Inside the cell the values are right. Outside they were clipped to the smallest and the
    largest given value, but (7.8) exceeds them there, since some coordinates are negative.
    """
    mixed = normalized(many_places(center, rim, corners, x)) @ values
    return np.clip(mixed, values.min(), values.max())


@answers("07.7")
def nearest_value(center, rim, corners, values, x):
    """Each point gets the value of the nearest corner, so the field jumps from one to the next. All
    corners take part in (7.8).
    """
    return values[np.linalg.norm(corners - x[:, None], axis=2).argmin(axis=1)]


@answers("07.7")
def plain_mean(center, rim, corners, values, x):
    """This is the plain mean of the values, the same at every point. It is right for constants
    only. Each value has a weight of its own in (7.8).
    """
    return np.full(len(x), values.mean())


@answers("07.7")
def by_inverse_distances(center, rim, corners, values, x):
    """Constants are reproduced, linear fields are not: these are means by inverse distance. The
    weights in (7.8) are the coordinates you wrote.
    """
    return normalized(1 / np.linalg.norm(corners - x[:, None], axis=2)) @ values


@answers("07.7")
def mean_of_products(center, rim, corners, values, x):
    """The sum was divided by the number of corners, but coordinates have the sum one already. What
    would a constant become?
    """
    return (normalized(many_places(center, rim, corners, x)) * values).mean(axis=1)


@answers("07.7")
def values_one_corner_on(center, rim, corners, values, x):
    """Values and coordinates have slipped by one corner against each other. Value and weight must
    have the same index in (7.8): which triangle has number 0?
    """
    return normalized(many_places(center, rim, corners, x)) @ np.roll(values, 1)


# 07.8


def products(center, rim, x, h, areas=None):
    n = len(rim)
    areas = double_areas(center, rim) if areas is None else areas
    c = [areas[a] * np.delete(h, [a, (a + 1) % n], axis=1).prod(axis=1) for a in range(n)]
    return np.stack(c, axis=1)


def distances_to_edges(center, rim, x, half=0.5):
    spokes = rim - center
    return half * (spokes**2).sum(axis=1) - (x - center) @ spokes.T


@answers("07.8")
def quotients_again(center, rim, x):
    """Inside the cell this is right; on the edges weights are divided by zero, because the
    quotients of (7.5) are still there. In (7.10) nothing is divided but by the sum at the end.
    """
    h = distances_to_edges(center, rim, x)
    with np.errstate(divide="ignore", invalid="ignore"):
        return normalized(double_areas(center, rim) / (h * np.roll(h, -1, axis=1)))


@answers("07.8")
def all_factors_kept(center, rim, x):
    """The product contains all factors, so it is the same for all corners and cancels. Which two
    factors are omitted in (7.10)?
    """
    h = distances_to_edges(center, rim, x).prod(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        return normalized(h[:, None] * double_areas(center, rim))


@answers("07.8")
def own_factors_above(center, rim, x):
    """The product contains the two factors of the corner itself. In (7.10) it contains all the
    other factors.
    """
    h = distances_to_edges(center, rim, x)
    with np.errstate(divide="ignore", invalid="ignore"):
        return normalized(double_areas(center, rim) * h * np.roll(h, -1, axis=1))


@answers("07.8")
def one_factor_too_many(center, rim, x):
    """Only one factor is omitted for each corner, but two edges meet there. See the index of the
    product in (7.10).
    """
    h = distances_to_edges(center, rim, x)
    c = [np.delete(h, a, axis=1).prod(axis=1) for a in range(len(rim))]
    with np.errstate(divide="ignore", invalid="ignore"):
        return normalized(np.stack(c, axis=1) * double_areas(center, rim))


@answers("07.8")
def factors_left_out_before(center, rim, x):
    """The omitted factors are those of neighbour a and of the one before. Corner a belongs to the
    neighbours a and a + 1.
    """
    h = distances_to_edges(center, rim, x)
    n = len(rim)
    c = [np.delete(h, [a, a - 1], axis=1).prod(axis=1) for a in range(n)]
    return normalized(np.stack(c, axis=1) * double_areas(center, rim))


@answers("07.8")
def areas_left_out(center, rim, x):
    """The areas are missing. In a regular cell they are equal and cancel, in others linear fields
    are not reproduced. What is the factor before the product of (7.10)?
    """
    return normalized(
        products(center, rim, x, distances_to_edges(center, rim, x), np.ones(len(rim)))
    )


@answers("07.8")
def half_left_out(center, rim, x):
    """h vanishes on a line through the neighbour instead of halfway to it: the factor ½ of (7.9) is
    missing.
    """
    return normalized(products(center, rim, x, distances_to_edges(center, rim, x, 1.0)))


@answers("07.8")
def lengths_in_place_of_squares(center, rim, x):
    """Half of a length is used in place of half of its square. Both terms of (7.9) must have the
    unit of an area.
    """
    spokes = rim - center
    h = 0.5 * np.linalg.norm(spokes, axis=1) - (x - center) @ spokes.T
    return normalized(products(center, rim, x, h))


@answers("07.8")
def true_distances(center, rim, x):
    """Here h is the distance to the edge, with unit normals, while the areas are those of (7.10).
    The length of each edge is omitted in two products only, so the lengths do not cancel.
    """
    h = distances_to_edges(center, rim, x) / np.linalg.norm(rim - center, axis=1)
    return normalized(products(center, rim, x, h))


@answers("07.8")
def place_from_the_origin(center, rim, x):
    """The point is taken from the origin: right only for a vertex there. (7.9) has two
    differences, both from the vertex.
    """
    spokes = rim - center
    h = 0.5 * (spokes**2).sum(axis=1) - x @ spokes.T
    return normalized(products(center, rim, x, h))


@answers("07.8")
def sum_forgotten(center, rim, x):
    """The products have not been divided by their sum, so a constant is not reproduced. The
    first half of (7.10) is still to do.
    """
    return products(center, rim, x, distances_to_edges(center, rim, x)) / 2


@answers("07.8", named=False)
def no_height_is_negative(center, rim, x):
    """Outside the cell some h are negative; here their absolute values were taken."""
    return normalized(products(center, rim, x, positive(distances_to_edges(center, rim, x))))


@answers("07.8", named=False)
def no_coordinate_is_negative(center, rim, x):
    """Outside the cell some coordinates are negative; here they were replaced by zero."""
    c = products(center, rim, x, distances_to_edges(center, rim, x))
    return normalized(np.maximum(c, 0))


def by_quotients(center, rim, h):
    with np.errstate(all="ignore"):
        return normalized(double_areas(center, rim) / (h * np.roll(h, -1, axis=1)))


@answers("07.8", named=False)
def zeros_replaced_by_a_tiny_number(center, rim, x):
    """The quotients are still there; two tiny factors have the product zero in a corner."""
    h = distances_to_edges(center, rim, x)
    return by_quotients(center, rim, np.where(h == 0, 1e-300, h))


@answers("07.8", named=False)
def a_small_number_added(center, rim, x):
    """The quotients are still there; in a small cell the number added is not small."""
    return by_quotients(center, rim, distances_to_edges(center, rim, x) + 1e-12)


@answers("07.8", named=False)
def small_heights_replaced(center, rim, x):
    """The quotients are still there; in a small cell all h are below this absolute bound."""
    h = distances_to_edges(center, rim, x)
    return by_quotients(center, rim, np.where(np.abs(h) < 1e-14, 1e-14, h))
