"""What students write instead of notebook 08, and what each of them should hear."""

import numpy as np

from fieldgrade.authoring.catalogue import answers


def spokes_of(center, neighbors, cells):
    return neighbors[cells] - center


def factors(center, neighbors, cells, corners, x):
    """The three factors below (8.2), for each corner."""
    return np.einsum("abk,ak->ab", spokes_of(center, neighbors, cells), corners - x)


def six_volumes(center, neighbors, cells):
    return np.abs(np.linalg.det(spokes_of(center, neighbors, cells)))


def right_weights(center, neighbors, cells, corners, x):
    return six_volumes(center, neighbors, cells) / factors(
        center, neighbors, cells, corners, x
    ).prod(axis=1)


# 08.1


@answers("08.1")
def sign_kept(a, b, c, d):
    """The absolute value is right, but the sign depends on the order of the corners. A volume is
    positive; (8.3) has an absolute value.
    """
    return np.linalg.det([b - a, c - a, d - a]) / 6


@answers("08.1", named=False)
def four_rows_with_ones(a, b, c, d):
    """Far from the origin the determinant of absolute coordinates loses the digits of a sliver."""
    return abs(np.linalg.det(np.insert(np.array([a, b, c, d], dtype=float), 3, 1, axis=1))) / 6


@answers("08.1")
def parallelepiped(a, b, c, d):
    """This is the volume of the parallelepiped over three edges. Which part of it is the
    tetrahedron?
    """
    return abs(np.linalg.det([b - a, c - a, d - a]))


@answers("08.1")
def half_as_in_the_plane(a, b, c, d):
    """This is half of the parallelepiped. A triangle is half of a parallelogram; in space the same
    count gives another fraction, see (8.3).
    """
    return abs(np.linalg.det([b - a, c - a, d - a])) / 2


@answers("08.1")
def a_third(a, b, c, d):
    """This is a third of the parallelepiped, the volume of a pyramid over a parallelogram. The
    base of a tetrahedron is a triangle.
    """
    return abs(np.linalg.det([b - a, c - a, d - a])) / 3


@answers("08.1")
def origin_for_corner(a, b, c, d):
    """The determinant is that of three corners, not of three edges: the tetrahedron has the
    origin for a corner. Does your result change when all corners move together?
    """
    return abs(np.linalg.det([b, c, d])) / 6


@answers("08.1")
def angles_forgotten(a, b, c, d):
    """A sixth of the product of three lengths would be right if the edges were perpendicular. How
    wide the angles between them are must matter.
    """
    return np.linalg.norm(b - a) * np.linalg.norm(c - a) * np.linalg.norm(d - a) / 6


@answers("08.1", named=False)
def from_distances_alone(a, b, c, d):
    """The determinant of the squared distances is proportional to the square of the volume, so that
    of a sliver has lost its digits.
    """
    p = np.array([a, b, c, d])
    m = np.ones((5, 5))
    m[1:, 1:] = ((p[:, None] - p) ** 2).sum(axis=2)
    m[0, 0] = 0
    return np.sqrt(max(np.linalg.det(m), 0.0) / 288)


@answers("08.1", named=False)
def products_of_the_corners(a, b, c, d):
    """Far from the origin the products of the coordinates themselves lose digits."""
    triples = ((b, c, d), (a, d, c), (a, b, d), (b, a, c))
    return abs(sum(p @ np.cross(q, r) for p, q, r in triples)) / 6


# 08.2


@answers("08.2", named=False)
def differences_of_squares(a, b, c, d):
    """Far from the origin the differences of squared coordinates lose digits."""
    p = np.array([a, b, c, d])
    squares = (p**2).sum(axis=1)
    return np.linalg.solve(2 * (p[1:] - p[:-1]), squares[1:] - squares[:-1])


@answers("08.2")
def centroid(a, b, c, d):
    """This is the centroid, the mean of the corners. In general it does not have the same distance
    from all corners, which is what (8.4) requires.
    """
    return (a + b + c + d) / 4


@answers("08.2")
def half_forgotten(a, b, c, d):
    """The point is twice as far from the first corner as it should be. Look at the factor on the
    right side of (8.4).
    """
    edges = np.array([b - a, c - a, d - a])
    return a + np.linalg.solve(edges, (edges**2).sum(axis=1))


@answers("08.2")
def not_moved_back(a, b, c, d):
    """This is the circumcentre relative to the first corner. The unknown of (8.4) is a difference;
    which step is missing?
    """
    edges = np.array([b - a, c - a, d - a])
    return np.linalg.solve(edges, (edges**2).sum(axis=1) / 2)


@answers("08.2")
def lengths_not_squared(a, b, c, d):
    """The right side of the equations contains lengths, where (8.4) has their squares. Look at the
    units of both sides.
    """
    edges = np.array([b - a, c - a, d - a])
    return a + np.linalg.solve(edges, np.linalg.norm(edges, axis=1) / 2)


@answers("08.2")
def of_one_face(a, b, c, d):
    """This is the circumcentre of one face: the fourth corner does not enter. Two equations
    determine a line in space; which is the third?
    """
    edges = np.array([b - a, c - a])
    return a + np.linalg.pinv(edges) @ ((edges**2).sum(axis=1) / 2)


@answers("08.2")
def equations_in_columns(a, b, c, d):
    """The matrix is transposed. Each equation of (8.4) belongs to one edge, so each edge is a row
    of the matrix.
    """
    edges = np.array([b - a, c - a, d - a])
    return a + np.linalg.solve(edges.T, (edges**2).sum(axis=1) / 2)


# 08.4


@answers("08.4")
def sign_left_in(center, tips):
    """The number has the sign of the order in which the tips are listed. In (8.1) there are bars: a
    weight must not depend on the order.
    """
    n = tips - center
    return np.linalg.det(n / np.linalg.norm(n, axis=1)[:, None])


@answers("08.4")
def lengths_left_in(center, tips):
    """The vectors have the lengths of the edges. This is six times the volume of the tetrahedron,
    the numerator in what you are about to prove. In (8.1) the normals have length one.
    """
    return abs(np.linalg.det(tips - center))


@answers("08.4")
def a_sixth_of_it(center, tips):
    """This is the volume of the tetrahedron of the three normals. In (8.1) it is the volume of the
    parallelepiped, the determinant itself.
    """
    n = tips - center
    return abs(np.linalg.det(n / np.linalg.norm(n, axis=1)[:, None])) / 6


@answers("08.4")
def columns_of_length_one(center, tips):
    """Here the columns have length one, and not the rows: each coordinate was divided, where each
    vector should be. Which axis does the length run along?
    """
    n = tips - center
    return abs(np.linalg.det(n / np.linalg.norm(n, axis=0)))


@answers("08.4")
def from_the_origin(center, tips):
    """The directions are those from the origin to the tips. The normals of the cell run along the
    edges at the vertex: see step 1.
    """
    return abs(np.linalg.det(tips / np.linalg.norm(tips, axis=1)[:, None]))


@answers("08.4")
def normals_of_the_tetrahedron(center, tips):
    """These are the normals of the faces of the tetrahedron. Needed are those of the faces of the
    Voronoi cell, which are perpendicular to the edges: see step 1.
    """
    j, k, m = tips - center
    n = np.array([np.cross(j, k), np.cross(k, m), np.cross(m, j)])
    return abs(np.linalg.det(n / np.linalg.norm(n, axis=1)[:, None]))


# 08.7


@answers("08.7")
def volumes_dropped(center, neighbors, cells, corners, x):
    """The volumes are missing. In a regular cell they are equal, elsewhere linear fields are not
    reproduced. What is the numerator of (8.2)?
    """
    return 1 / factors(center, neighbors, cells, corners, x).prod(axis=1)


@answers("08.7", named=False)
def products_of_absolute_positions(center, neighbors, cells, corners, x):
    """Far from the origin the difference of two large products loses its digits."""
    e = spokes_of(center, neighbors, cells)
    below = np.einsum("abk,ak->ab", e, corners) - e @ x
    return six_volumes(center, neighbors, cells) / below.prod(axis=1)


@answers("08.7")
def six_dropped(center, neighbors, cells, corners, x):
    """These are sixths of the weights. The coordinates would be right, since a common factor
    cancels. But (8.2) has this factor, and question 08.5 derives it.
    """
    return right_weights(center, neighbors, cells, corners, x) / 6


@answers("08.7")
def two_as_in_the_plane(center, neighbors, cells, corners, x):
    """The factor is that of the plane, 2. Count again how many tetrahedra make a parallelepiped."""
    return right_weights(center, neighbors, cells, corners, x) / 3


@answers("08.7")
def sign_of_the_determinant(center, neighbors, cells, corners, x):
    """The sizes are right, some signs are wrong: those of tetrahedra listed the other way
    round. Their sum is then wrong too, and all coordinates with it. A volume has no sign.
    """
    w = right_weights(center, neighbors, cells, corners, x)
    return w * np.sign(np.linalg.det(spokes_of(center, neighbors, cells)))


@answers("08.7")
def third_neighbour_forgotten(center, neighbors, cells, corners, x):
    """The denominator has two factors only. In space three faces meet in a corner, and each
    tetrahedron has three vertices besides the central one.
    """
    below = factors(center, neighbors, cells, corners, x)[:, :2]
    return six_volumes(center, neighbors, cells) / below.prod(axis=1)


@answers("08.7")
def product_over_all_neighbours(center, neighbors, cells, corners, x):
    """The product runs over all neighbours. Only three faces of the cell meet in a corner; which
    numbers does `cells` give for it?
    """
    below = ((corners - x) @ (neighbors - center).T).prod(axis=1)
    return six_volumes(center, neighbors, cells) / below


@answers("08.7")
def first_neighbours_for_all(center, neighbors, cells, corners, x):
    """The denominators have the factors of the first three neighbours, the same for every
    tetrahedron. A row of `cells` contains the indices of the right ones.
    """
    below = ((corners - x) @ (neighbors[:3] - center).T).prod(axis=1)
    return six_volumes(center, neighbors, cells) / below


@answers("08.7")
def normals_of_length_one_below(center, neighbors, cells, corners, x):
    """The denominator has unit normals, as in (8.1), and the numerator has six times the volume, as
    in (8.2). The lengths cancel only if both are treated alike.
    """
    lengths = np.linalg.norm(spokes_of(center, neighbors, cells), axis=2).prod(axis=1)
    return right_weights(center, neighbors, cells, corners, x) * lengths


@answers("08.7")
def spokes_from_the_origin(center, neighbors, cells, corners, x):
    """The denominator has the neighbours themselves instead of their differences from the vertex.
    It is right only for a vertex at the origin.
    """
    below = np.einsum("abk,ak->ab", neighbors[cells], corners - x).prod(axis=1)
    return six_volumes(center, neighbors, cells) / below


@answers("08.7")
def spokes_from_the_place(center, neighbors, cells, corners, x):
    """The edges begin at the point x, where they should begin at the vertex: the normals of a
    cell do not depend on where it is looked at.
    """
    below = np.einsum("abk,ak->ab", neighbors[cells] - x, corners - x).prod(axis=1)
    return six_volumes(center, neighbors, cells) / below


@answers("08.7")
def from_the_vertex_not_the_place(center, neighbors, cells, corners, x):
    """These weights do not depend on the point: the corners are taken relative to the vertex. Where
    is x in (8.2)?
    """
    return right_weights(center, neighbors, cells, corners, center)


@answers("08.7")
def sum_below(center, neighbors, cells, corners, x):
    """The three factors of the denominator were added. In (8.2) they are multiplied, so that one
    small factor suffices for a large weight.
    """
    below = factors(center, neighbors, cells, corners, x).sum(axis=1)
    return six_volumes(center, neighbors, cells) / below


@answers("08.7")
def place_minus_corner(center, neighbors, cells, corners, x):
    """All weights have the wrong sign: the differences in the denominator are x − p. In the plane
    two such signs cancel, in space three do not.
    """
    return -right_weights(center, neighbors, cells, corners, x)


@answers("08.7")
def divided_by_the_sum(center, neighbors, cells, corners, x):
    """These are coordinates: the weights divided by their sum. Here the weights (8.2) themselves
    are required.
    """
    w = right_weights(center, neighbors, cells, corners, x)
    return w / w.sum()


@answers("08.7", named=False)
def size_of_the_weights(center, neighbors, cells, corners, x):
    """Outside the cell some weights are negative; here all of them are positive."""
    return np.abs(right_weights(center, neighbors, cells, corners, x))


# 08.8


@answers("08.8")
def half_left_out(center, neighbors, x):
    """The factor ½ is missing: this height vanishes on a plane through the neighbour instead of
    halfway to it.
    """
    s = neighbors - center
    return (s**2).sum(axis=1)[:, None] - s @ (x - center).T


@answers("08.8")
def lengths_in_place_of_squares(center, neighbors, x):
    """Half of a length is used in place of half of its square. Both terms of (8.5) must have the
    unit of an area.
    """
    s = neighbors - center
    return np.linalg.norm(s, axis=1)[:, None] / 2 - s @ (x - center).T


@answers("08.8")
def place_from_the_origin(center, neighbors, x):
    """The point is taken from the origin: right only for a vertex there. (8.5) has a difference
    on the right as well.
    """
    s = neighbors - center
    return (s**2).sum(axis=1)[:, None] / 2 - s @ x.T


@answers("08.8")
def true_distances(center, neighbors, x):
    """These are distances to the faces: h divided by the length of the edge. The proof cancels
    that length; in (8.5) it is not there.
    """
    s = neighbors - center
    h = (s**2).sum(axis=1)[:, None] / 2 - s @ (x - center).T
    return h / np.linalg.norm(s, axis=1)[:, None]


@answers("08.8")
def negative_inside(center, neighbors, x):
    """The sign is reversed: these are negative inside the cell. Which term of (8.5) is subtracted
    from which?
    """
    s = neighbors - center
    return s @ (x - center).T - (s**2).sum(axis=1)[:, None] / 2


@answers("08.8")
def terms_added(center, neighbors, x):
    """The two terms have been added, so h vanishes on the far side of the vertex. At the midpoint
    of the edge it has to be zero.
    """
    s = neighbors - center
    return (s**2).sum(axis=1)[:, None] / 2 + s @ (x - center).T


# 08.10


def right_heights(center, neighbors, x):
    s = neighbors - center
    return (s**2).sum(axis=1)[:, None] / 2 - s @ (x - center).T


def normalized(c):
    with np.errstate(divide="ignore", invalid="ignore"):
        return (c / c.sum(axis=0)).T


def products(center, neighbors, cells, h, left_out=3):
    rest = [np.delete(h, cell[:left_out], axis=0).prod(axis=0) for cell in cells]
    return six_volumes(center, neighbors, cells)[:, None] * np.array(rest)


@answers("08.10")
def quotients_again(center, neighbors, cells, x):
    """Inside the cell this is right; on its faces, edges and corners weights are divided by zero,
    because the quotients of (8.2) are still there. In (8.6) nothing is divided but by the sum at
    the end.
    """
    h = right_heights(center, neighbors, x)
    with np.errstate(divide="ignore", invalid="ignore"):
        w = six_volumes(center, neighbors, cells)[:, None] / h[cells].prod(axis=1)
        return normalized(w)


@answers("08.10")
def own_heights_above(center, neighbors, cells, x):
    """The product contains the three heights of the corner itself. In (8.6) it contains all the
    other heights.
    """
    h = right_heights(center, neighbors, x)
    return normalized(six_volumes(center, neighbors, cells)[:, None] * h[cells].prod(axis=1))


@answers("08.10")
def two_left_out_as_in_the_plane(center, neighbors, cells, x):
    """Only two heights are left out for each corner, as in the plane. Three faces meet there, and
    the third height makes the coordinate of the corner zero on its own face.
    """
    return normalized(
        products(center, neighbors, cells, right_heights(center, neighbors, x), left_out=2)
    )


@answers("08.10")
def all_heights_kept(center, neighbors, cells, x):
    """The product has all heights, so it is the same for all corners, and only the volumes are
    left. Which three does (8.6) leave out?
    """
    h = right_heights(center, neighbors, x).prod(axis=0)
    return normalized(six_volumes(center, neighbors, cells)[:, None] * h)


@answers("08.10")
def volumes_left_out(center, neighbors, cells, x):
    """The volumes are missing. In a regular cell they are equal and cancel, in others linear fields
    are not reproduced. What is the factor before the product of (8.6)?
    """
    c = products(center, neighbors, cells, right_heights(center, neighbors, x))
    return normalized(c / six_volumes(center, neighbors, cells)[:, None])


@answers("08.10")
def sum_forgotten(center, neighbors, cells, x):
    """The products have not been divided by their sum, so a constant is not reproduced. The
    first half of (8.6) is still to do.
    """
    return (products(center, neighbors, cells, right_heights(center, neighbors, x)) / 6).T


@answers("08.10")
def sum_over_the_places(center, neighbors, cells, x):
    """The products were summed over the points instead of over the corners. Each point needs a
    sum of its own: which axis is to be summed?
    """
    c = products(center, neighbors, cells, right_heights(center, neighbors, x))
    with np.errstate(divide="ignore", invalid="ignore"):
        return (c / c.sum(axis=1)[:, None]).T


@answers("08.10")
def heights_of_unit_normals(center, neighbors, cells, x):
    """The heights are true distances here, with unit normals, while the volumes are those of (8.6).
    The length of each edge is omitted only in the corners of its face, so the lengths do not
    cancel.
    """
    h = right_heights(center, neighbors, x) / np.linalg.norm(neighbors - center, axis=1)[:, None]
    return normalized(products(center, neighbors, cells, h))


@answers("08.10", named=False)
def no_height_is_negative(center, neighbors, cells, x):
    """Outside the cell some heights are negative; here their absolute values were taken."""
    return normalized(
        products(center, neighbors, cells, np.abs(right_heights(center, neighbors, x)))
    )


@answers("08.10", named=False)
def no_coordinate_is_negative(center, neighbors, cells, x):
    """Outside the cell some coordinates are negative; here they were replaced by zero."""
    c = products(center, neighbors, cells, right_heights(center, neighbors, x))
    return normalized(np.maximum(c, 0))


def by_quotients(center, neighbors, cells, h):
    with np.errstate(all="ignore"):
        return normalized(six_volumes(center, neighbors, cells)[:, None] / h[cells].prod(axis=1))


@answers("08.10", named=False)
def a_small_number_added(center, neighbors, cells, x):
    """The quotients are still there; in a small cell the number added is not small."""
    return by_quotients(center, neighbors, cells, right_heights(center, neighbors, x) + 1e-13)


@answers("08.10", named=False)
def small_heights_replaced(center, neighbors, cells, x):
    """The quotients are still there; in a small cell all h are below this absolute bound."""
    h = right_heights(center, neighbors, x)
    return by_quotients(center, neighbors, cells, np.where(np.abs(h) < 1e-14, 1e-14, h))


@answers("08.10", named=False)
def zeros_replaced_by_a_tiny_number(center, neighbors, cells, x):
    """The quotients are still there; tiny factors have the product zero in a corner."""
    h = right_heights(center, neighbors, x)
    return by_quotients(center, neighbors, cells, np.where(h == 0, 1e-300, h))


@answers("08.1", named=False)
def flat_ones_have_none(a, b, c, d):
    """A tetrahedron that is nearly flat still has a volume."""
    edges = np.array([b - a, c - a, d - a], dtype=float)
    sizes = np.linalg.svd(edges, compute_uv=False)
    return 0.0 if sizes[2] < 1e-6 * sizes[0] else abs(np.linalg.det(edges)) / 6


@answers("08.2", named=False)
def a_direction_left_out(a, b, c, d):
    """The pseudo-inverse with a coarse limit leaves out the short direction of a flat
    tetrahedron.
    """
    edges = np.array([b - a, c - a, d - a], dtype=float)
    return a + np.linalg.pinv(edges, 1e-3) @ (edges**2).sum(axis=1) / 2
