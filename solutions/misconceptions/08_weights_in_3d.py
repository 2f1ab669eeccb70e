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
    """The size is right, but the sign tells in which order the corners are listed. A volume is
    positive, and (8.3) has bars.
    """
    return np.linalg.det([b - a, c - a, d - a]) / 6


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


# 08.2


@answers("08.2")
def centroid(a, b, c, d):
    """This is the centroid, the mean of the corners, which is not equally far from them. In a
    mesh the lines between centroids are not perpendicular to the faces, and the whole proof rests
    on that.
    """
    return (a + b + c + d) / 4


@answers("08.2")
def half_forgotten(a, b, c, d):
    """The point is twice as far from the corner as it should be: something stands before the
    square on the right of (8.4).
    """
    edges = np.array([b - a, c - a, d - a])
    return a + np.linalg.solve(edges, (edges**2).sum(axis=1))


@answers("08.2")
def not_moved_back(a, b, c, d):
    """This is the way from the first corner to the circumcentre. The unknown of (8.4) is a
    difference; what has to be done at the end?
    """
    edges = np.array([b - a, c - a, d - a])
    return np.linalg.solve(edges, (edges**2).sum(axis=1) / 2)


@answers("08.2")
def lengths_not_squared(a, b, c, d):
    """On the right of the equations stand lengths, where (8.4) has their squares: both sides must
    be areas.
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
    """The edges stand in the columns of the matrix, so other equations are solved. In (8.4) each
    edge is multiplied with the unknown: each is a row.
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
    """The vectors have the lengths of the edges: this is six times the volume of the tetrahedron,
    one side of what you are about to prove. (8.1) asks for normals of length one.
    """
    return abs(np.linalg.det(tips - center))


@answers("08.4")
def a_sixth_of_it(center, tips):
    """This is the volume of the tetrahedron over the three normals. (8.1) takes the whole
    parallelepiped: a determinant and nothing else.
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
    """The volumes are missing. In a regular star they are equal and nobody would notice;
    elsewhere linear fields are lost. What stands above in (8.2)?
    """
    return 1 / factors(center, neighbors, cells, corners, x).prod(axis=1)


@answers("08.7")
def six_dropped(center, neighbors, cells, corners, x):
    """These are sixths of the weights. The coordinates would come out right, since a common factor
    cancels, but (8.2) has it, and the proof shows where it comes from.
    """
    return right_weights(center, neighbors, cells, corners, x) / 6


@answers("08.7")
def two_as_in_the_plane(center, neighbors, cells, corners, x):
    """The factor is that of the plane, 2. Count again how many tetrahedra make a parallelepiped."""
    return right_weights(center, neighbors, cells, corners, x) / 3


@answers("08.7")
def sign_of_the_determinant(center, neighbors, cells, corners, x):
    """The sizes are right and some weights are negative: those of tetrahedra listed the other way
    round. Their sum is then wrong too, and all coordinates with it. A volume has no sign.
    """
    w = right_weights(center, neighbors, cells, corners, x)
    return w * np.sign(np.linalg.det(spokes_of(center, neighbors, cells)))


@answers("08.7")
def third_neighbour_forgotten(center, neighbors, cells, corners, x):
    """Only two factors stand below the line. In space three faces meet in a corner, and each
    tetrahedron has three neighbours besides the vertex.
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
    """Below stand the factors of the first three neighbours, the same for every tetrahedron.
    `cells` holds the numbers of the right ones.
    """
    below = ((corners - x) @ (neighbors[:3] - center).T).prod(axis=1)
    return six_volumes(center, neighbors, cells) / below


@answers("08.7")
def normals_of_length_one_below(center, neighbors, cells, corners, x):
    """Below the line the normals have length one, as in (8.1), and above stands six times the
    volume, as in (8.2). The lengths cancel only if they are left out of both, or kept in both.
    """
    lengths = np.linalg.norm(spokes_of(center, neighbors, cells), axis=2).prod(axis=1)
    return right_weights(center, neighbors, cells, corners, x) * lengths


@answers("08.7")
def spokes_from_the_origin(center, neighbors, cells, corners, x):
    """The neighbours themselves stand below, not the ways to them from the vertex: right only for
    a vertex at the origin. Which differences does (8.2) have?
    """
    below = np.einsum("abk,ak->ab", neighbors[cells], corners - x).prod(axis=1)
    return six_volumes(center, neighbors, cells) / below


@answers("08.7")
def spokes_from_the_place(center, neighbors, cells, corners, x):
    """The edges begin at the place x, where they should begin at the vertex: the normals of a
    cell do not depend on where it is looked at.
    """
    below = np.einsum("abk,ak->ab", neighbors[cells] - x, corners - x).prod(axis=1)
    return six_volumes(center, neighbors, cells) / below


@answers("08.7")
def from_the_vertex_not_the_place(center, neighbors, cells, corners, x):
    """These weights do not depend on the place: the way to the corner was taken from the vertex.
    Where is x in (8.2)?
    """
    return right_weights(center, neighbors, cells, corners, center)


@answers("08.7")
def sum_below(center, neighbors, cells, corners, x):
    """Below the line the three factors have been added. A corner gains weight as the place comes
    near any one of its faces, so one small factor has to suffice.
    """
    below = factors(center, neighbors, cells, corners, x).sum(axis=1)
    return six_volumes(center, neighbors, cells) / below


@answers("08.7")
def place_minus_corner(center, neighbors, cells, corners, x):
    """All weights are negative: the difference below the line is the wrong way round. In the
    plane two such signs cancel, in space three do not.
    """
    return -right_weights(center, neighbors, cells, corners, x)


@answers("08.7")
def divided_by_the_sum(center, neighbors, cells, corners, x):
    """These are coordinates already: the weights divided by their sum. Asked for are the weights
    of (8.2) themselves.
    """
    w = right_weights(center, neighbors, cells, corners, x)
    return w / w.sum()


# 08.8


@answers("08.8")
def half_left_out(center, neighbors, x):
    """The half is missing: this height vanishes on a plane through the neighbour, and not
    half-way to it. The cell would be twice as large.
    """
    s = neighbors - center
    return (s**2).sum(axis=1)[:, None] - s @ (x - center).T


@answers("08.8")
def lengths_in_place_of_squares(center, neighbors, x):
    """Half of the length stands where half of its square belongs. Both terms of (8.5) must be
    areas.
    """
    s = neighbors - center
    return np.linalg.norm(s, axis=1)[:, None] / 2 - s @ (x - center).T


@answers("08.8")
def place_from_the_origin(center, neighbors, x):
    """The place is taken from the origin: right only for a vertex there. (8.5) has a difference
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


def normalised(c):
    with np.errstate(divide="ignore", invalid="ignore"):
        return (c / c.sum(axis=0)).T


def products(center, neighbors, cells, h, left_out=3):
    rest = [np.delete(h, cell[:left_out], axis=0).prod(axis=0) for cell in cells]
    return six_volumes(center, neighbors, cells)[:, None] * np.array(rest)


@answers("08.10")
def quotients_again(center, neighbors, cells, x):
    """Inside the cell this is right; on its edges and corners it is zero by zero, because the
    quotients of (8.2) are still there. In (8.6) nothing is divided but by the sum at the end.
    """
    h = right_heights(center, neighbors, x)
    with np.errstate(divide="ignore", invalid="ignore"):
        w = six_volumes(center, neighbors, cells)[:, None] / h[cells].prod(axis=1)
        return normalised(w)


@answers("08.10")
def own_heights_above(center, neighbors, cells, x):
    """The three heights that belong below the line in (8.2) now stand above it, so a corner loses
    weight as its faces come near. The product of (8.6) is over the others.
    """
    h = right_heights(center, neighbors, x)
    return normalised(six_volumes(center, neighbors, cells)[:, None] * h[cells].prod(axis=1))


@answers("08.10")
def two_left_out_as_in_the_plane(center, neighbors, cells, x):
    """Only two heights are left out for each corner, as in the plane. Three faces meet there, and
    the third makes the corner vanish on it.
    """
    return normalised(
        products(center, neighbors, cells, right_heights(center, neighbors, x), left_out=2)
    )


@answers("08.10")
def all_heights_kept(center, neighbors, cells, x):
    """The product has all heights, so it is the same for all corners, and only the volumes are
    left. Which three does (8.6) leave out?
    """
    h = right_heights(center, neighbors, x).prod(axis=0)
    return normalised(six_volumes(center, neighbors, cells)[:, None] * h)


@answers("08.10")
def volumes_left_out(center, neighbors, cells, x):
    """The volumes are missing. In a regular cell they are equal and cancel; in others linear
    fields are lost. What stands before the product of (8.6)?
    """
    c = products(center, neighbors, cells, right_heights(center, neighbors, x))
    return normalised(c / six_volumes(center, neighbors, cells)[:, None])


@answers("08.10")
def sum_forgotten(center, neighbors, cells, x):
    """The products have not been divided by their sum, so a constant does not come back. The
    first half of (8.6) is still to do.
    """
    return (products(center, neighbors, cells, right_heights(center, neighbors, x)) / 6).T


@answers("08.10")
def sum_over_the_places(center, neighbors, cells, x):
    """The products were summed over the places instead of over the corners. Each place needs a
    sum of its own: which axis is to be summed?
    """
    c = products(center, neighbors, cells, right_heights(center, neighbors, x))
    with np.errstate(divide="ignore", invalid="ignore"):
        return (c / c.sum(axis=1)[:, None]).T


@answers("08.10")
def heights_of_unit_normals(center, neighbors, cells, x):
    """The heights are true distances here, divided by the length of the edge, while the volumes
    are those of (8.6). Each length is missing from all corners but those of its face, so it does
    not cancel.
    """
    h = right_heights(center, neighbors, x) / np.linalg.norm(neighbors - center, axis=1)[:, None]
    return normalised(products(center, neighbors, cells, h))
