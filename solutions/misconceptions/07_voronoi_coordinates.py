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


def normalised(w):
    return w / w.sum(axis=1, keepdims=True)


# 07.1


@answers("07.1")
def angle_in_degrees(center, radius, turn):
    """The corners lie on the circle, but not evenly: the steps are of 60, and NumPy's cosine takes
    radians. Which number stands beside b in (7.1)?
    """
    return center + radius * circle(turn + 60.0 * np.arange(6))


@answers("07.1")
def center_forgotten(center, radius, turn):
    """This hexagon stands round the origin. Every point of (7.1) begins with the place of the
    middle vertex; without it all that follows is right for one position only.
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


# 07.2


@answers("07.2")
def centroid(a, b, c):
    """This is the centroid, the mean of the corners. It is a centre of the triangle, but not
    equally far from the corners, and lines between centroids are not perpendicular to the edges.
    For the regular hexagon nobody would notice. Condition (7.2) speaks of distances.
    """
    return (a + b + c) / 3


@answers("07.2")
def half_forgotten(a, b, c):
    """The point is twice as far from the corner as it should be. Expand the squares in (7.2) once
    more: the linear term comes with a factor 2, so something is left on the other side.
    """
    edges = np.array([b - a, c - a])
    return a + np.linalg.solve(edges, np.sum(edges**2, axis=1))


@answers("07.2")
def not_moved_back(a, b, c):
    """This is the way from the first corner to the circumcentre, not the circumcentre. The
    equations were solved relative to a corner, and the result was left there.
    """
    edges = np.array([b - a, c - a])
    return np.linalg.solve(edges, np.sum(edges**2, axis=1) / 2)


@answers("07.2")
def lengths_not_squared(a, b, c):
    """On the right of the equations stand lengths, where squares of lengths belong: both sides must
    be areas. Look at what squaring (7.2) leaves.
    """
    edges = np.array([b - a, c - a])
    return a + np.linalg.solve(edges, np.linalg.norm(edges, axis=1) / 2)


@answers("07.2")
def edges_in_columns(a, b, c):
    """Rows and columns of the system are exchanged. Each equation speaks of one edge, so an edge
    is a row of the matrix; in the columns stand its coordinates. Write the first equation out.
    """
    edges = np.column_stack([b - a, c - a])
    return a + np.linalg.solve(edges, np.sum(edges**2, axis=0) / 2)


@answers("07.2")
def incenter(a, b, c):
    """This is the centre of the inscribed circle, where the bisectors of the angles meet: it is
    equally far from the sides. Asked for is the point equally far from the corners.
    """
    sides = np.array([np.linalg.norm(b - c), np.linalg.norm(c - a), np.linalg.norm(a - b)])
    return sides @ np.array([a, b, c]) / sides.sum()


@answers("07.2")
def orthocenter(a, b, c):
    """This is where the altitudes meet. The perpendiculars were raised through the corners; those
    of the circumcentre go through the middles of the edges.
    """
    edges = np.array([c - b, c - a])
    return np.linalg.solve(edges, [(c - b) @ a, (c - a) @ b])


# 07.3


@answers("07.3")
def sign_kept(a, b, c):
    """The size is right, but the sign tells which way round the corners are listed. An area is
    positive, and (7.4) has bars. With the sign some weights would come out negative.
    """
    return cross(b - a, c - a) / 2


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


# 07.4


@answers("07.4")
def areas_dropped(center, rim, corners, x):
    """The areas are missing: above the line there is a one. In the regular hexagon all triangles
    are equal and nobody would notice; elsewhere linear fields are lost. What stands above in
    (7.5)?
    """
    j, k = heights(center, rim, corners, x)
    return 1 / (j * k)


@answers("07.4")
def factor_two_dropped(center, rim, corners, x):
    """These are halves of the weights. The coordinates would come out right, since a common factor
    cancels, but (7.5) has it: the determinant of two spokes is not the area itself.
    """
    return one_place(center, rim, corners, x) / 2


@answers("07.4")
def areas_squared(center, rim, corners, x):
    """The area enters squared. Doubling all lengths must leave a quarter of each weight; which
    powers of a length stand above and below in yours?
    """
    return double_areas(center, rim) * one_place(center, rim, corners, x)


@answers("07.4")
def normals_of_length_one_below(center, rim, corners, x):
    """Below the line the normals have length one, as in (7.3), while above stands twice the area,
    as in (7.5). The lengths cancel only if they are left out of both, or kept in both.
    """
    spokes = np.linalg.norm(rim - center, axis=1)
    return one_place(center, rim, corners, x) * spokes * np.roll(spokes, -1)


@answers("07.4")
def product_over_all_neighbours(center, rim, corners, x):
    """The product runs over all neighbours. Only two edges of the cell meet in a corner, and only
    their two factors belong into (7.5).
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
    """The neighbours themselves stand below, not the ways to them from the middle: right only for a
    vertex at the origin. Which difference is meant in (7.5)?
    """
    j, k = rim, np.roll(rim, -1, axis=0)
    below = np.sum(j * (corners - x), axis=1) * np.sum(k * (corners - x), axis=1)
    return double_areas(center, rim) / below


@answers("07.4")
def spokes_from_the_place(center, rim, corners, x):
    """The spokes begin at the place x, where they should begin at the vertex: the normals of a
    cell do not depend on where it is looked at. Compare the two differences in (7.5).
    """
    j, k = rim - x, np.roll(rim, -1, axis=0) - x
    below = np.sum(j * (corners - x), axis=1) * np.sum(k * (corners - x), axis=1)
    return double_areas(center, rim) / below


@answers("07.4")
def from_the_center_not_the_place(center, rim, corners, x):
    """These weights do not depend on the place: the way to the corner was taken from the vertex.
    They are right in the middle of the cell only. Where is x in (7.5)?
    """
    return one_place(center, rim, corners, center)


@answers("07.4")
def sum_below(center, rim, corners, x):
    """Below the line the two factors have been added. A corner must gain on the others as the place
    comes near either of its edges, so one small factor has to suffice. Read the sign between them.
    """
    j, k = heights(center, rim, corners, x)
    return double_areas(center, rim) / (j + k)


@answers("07.4")
def divided_by_the_sum(center, rim, corners, x):
    """These are coordinates already: the weights divided by their sum. That is the next question;
    here the weights of (7.5) themselves are asked for.
    """
    w = one_place(center, rim, corners, x)
    return w / w.sum()


@answers("07.4")
def orientation_kept(center, rim, corners, x):
    """For neighbours listed clockwise the weights are negative: the area carries a sign. If all
    do, the coordinates survive; with triangles both ways round they would not. See the bars in
    (7.4).
    """
    j, k = heights(center, rim, corners, x)
    return cross(rim - center, np.roll(rim, -1, axis=0) - center) / (j * k)


# 07.5


@answers("07.5")
def not_normalised(center, rim, corners, x):
    """These are the weights, not divided by their sum. A constant field would not come back: what
    do the coordinates at a place have to add up to?
    """
    return many_places(center, rim, corners, x)


@answers("07.5")
def normalised_over_the_places(center, rim, corners, x):
    """The sums run over the places instead of over the corners: columns add up to one, and rows
    should. Each place has its own six, and must not depend on which others were asked for.
    """
    w = many_places(center, rim, corners, x)
    return w / w.sum(axis=0)


@answers("07.5")
def divided_by_everything(center, rim, corners, x):
    """All weights at all places together add up to one. Each place needs a sum of its own: which
    axis is to be summed?
    """
    w = many_places(center, rim, corners, x)
    return w / w.sum()


@answers("07.5")
def divided_by_the_largest(center, rim, corners, x):
    """The largest entry of each row is one, not the sum. Only division by the sum makes a
    constant come back; see (7.6).
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
    """The sum is one, but these weights are inverse distances to the corners. They know nothing
    of the edges, and linear fields are lost. Use the weights of (7.5).
    """
    return normalised(1 / np.linalg.norm(corners - x[:, None], axis=2))


# 07.6


@answers("07.6")
def around_the_origin(center, corners, steps):
    """The spiral winds round the origin and not round the vertex. As it stands it may miss the cell
    altogether. What is the first term of (7.7)?
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
    """The two corners do not share an edge, so their middle lies inside the cell and the spiral
    comes out too small. Which two does the docstring name?
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
    """n begins at zero: the first point is infinitely far away, and the last one is missing.
    Where does (7.7) begin to count, and where does it end?
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


# 07.7


@answers("07.7")
def weights_instead_of_coordinates(center, rim, corners, values, x):
    """The values are mixed with weights that have not been divided by their sum, so even a
    constant does not come back. (7.8) has ω, not w.
    """
    return many_places(center, rim, corners, x) @ values


@answers("07.7")
def nearest_value(center, rim, corners, values, x):
    """Each place gets the value of the nearest corner, so the field jumps from one to the next. All
    corners take part in (7.8).
    """
    return values[np.linalg.norm(corners - x[:, None], axis=2).argmin(axis=1)]


@answers("07.7")
def plain_mean(center, rim, corners, values, x):
    """This is the plain mean of the values, the same at every place. It is right for constants
    only. Each value has a weight of its own in (7.8).
    """
    return np.full(len(x), values.mean())


@answers("07.7")
def by_inverse_distances(center, rim, corners, values, x):
    """Constants come back and linear fields do not: these are means by inverse distance. The
    weights in (7.8) are the coordinates you wrote.
    """
    return normalised(1 / np.linalg.norm(corners - x[:, None], axis=2)) @ values


@answers("07.7")
def mean_of_products(center, rim, corners, values, x):
    """The sum was divided by the number of corners a second time: coordinates have the sum one
    already. What would a constant become?
    """
    return (normalised(many_places(center, rim, corners, x)) * values).mean(axis=1)


@answers("07.7")
def values_one_corner_on(center, rim, corners, values, x):
    """Values and coordinates have slipped by one corner against each other. Value and weight must
    have the same index in (7.8): which triangle has number 0?
    """
    return normalised(many_places(center, rim, corners, x)) @ np.roll(values, 1)


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
    """Inside the cell this is right; on the edges it is zero by zero, because the quotients of
    (7.5) are still there. In (7.10) nothing is divided but by the sum at the end.
    """
    h = distances_to_edges(center, rim, x)
    with np.errstate(divide="ignore", invalid="ignore"):
        return normalised(double_areas(center, rim) / (h * np.roll(h, -1, axis=1)))


@answers("07.8")
def all_factors_kept(center, rim, x):
    """The product has all factors, so it is the same for all corners, and only the areas are
    left; on an edge nothing is. Which two factors does (7.10) leave out?
    """
    h = distances_to_edges(center, rim, x).prod(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        return normalised(h[:, None] * double_areas(center, rim))


@answers("07.8")
def own_factors_above(center, rim, x):
    """The two factors that belong below the line in (7.5) now stand above it. A corner would lose
    weight as its edges come near. In (7.10) the product is over the others.
    """
    h = distances_to_edges(center, rim, x)
    with np.errstate(divide="ignore", invalid="ignore"):
        return normalised(double_areas(center, rim) * h * np.roll(h, -1, axis=1))


@answers("07.8")
def one_factor_too_many(center, rim, x):
    """Only one factor is left out for each corner, but two edges meet there, and one of them
    still makes the corner vanish on it. See the index below the product of (7.10).
    """
    h = distances_to_edges(center, rim, x)
    c = [np.delete(h, a, axis=1).prod(axis=1) for a in range(len(rim))]
    with np.errstate(divide="ignore", invalid="ignore"):
        return normalised(np.stack(c, axis=1) * double_areas(center, rim))


@answers("07.8")
def factors_left_out_before(center, rim, x):
    """The factors left out are those of the neighbour itself and of the one before. The corner
    number a lies between the neighbours a and a + 1.
    """
    h = distances_to_edges(center, rim, x)
    n = len(rim)
    c = [np.delete(h, [a, a - 1], axis=1).prod(axis=1) for a in range(n)]
    return normalised(np.stack(c, axis=1) * double_areas(center, rim))


@answers("07.8")
def areas_left_out(center, rim, x):
    """The areas are missing. In a regular cell they are equal and cancel; in others linear fields
    are lost. What stands before the product of (7.10)?
    """
    return normalised(
        products(center, rim, x, distances_to_edges(center, rim, x), np.ones(len(rim)))
    )


@answers("07.8")
def half_left_out(center, rim, x):
    """h vanishes on a line through the neighbour instead of half-way to it: the half of (7.9) is
    missing, and the cell comes out too large.
    """
    return normalised(products(center, rim, x, distances_to_edges(center, rim, x, 1.0)))


@answers("07.8")
def lengths_in_place_of_squares(center, rim, x):
    """Half of the length of a spoke stands where half of its square belongs. Both terms of (7.9)
    must be areas; yours change their proportion with the unit of length.
    """
    spokes = rim - center
    h = 0.5 * np.linalg.norm(spokes, axis=1) - (x - center) @ spokes.T
    return normalised(products(center, rim, x, h))


@answers("07.8")
def true_distances(center, rim, x):
    """Here h is the distance to the edge, divided by the length of the spoke, while the areas are
    those of (7.10). Each spoke is missing from all corners but two, so the lengths do not cancel.
    """
    h = distances_to_edges(center, rim, x) / np.linalg.norm(rim - center, axis=1)
    return normalised(products(center, rim, x, h))


@answers("07.8")
def place_from_the_origin(center, rim, x):
    """The place is taken from the origin: right only for a vertex there. (7.9) has two
    differences, both from the vertex.
    """
    spokes = rim - center
    h = 0.5 * (spokes**2).sum(axis=1) - x @ spokes.T
    return normalised(products(center, rim, x, h))


@answers("07.8")
def sum_forgotten(center, rim, x):
    """The products have not been divided by their sum, so a constant does not come back. The
    first half of (7.10) is still to do.
    """
    return products(center, rim, x, distances_to_edges(center, rim, x)) / 2
