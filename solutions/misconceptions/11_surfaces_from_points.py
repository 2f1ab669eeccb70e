"""What students write instead of notebook 11, and what each of them should hear."""

import numpy as np

from fieldgrade.authoring.catalogue import answers


def distances(points):
    return np.sqrt(((points[:, None] - points) ** 2).sum(axis=2))


# 11.1 Normals


def fitted(points, k, first=0, which=0, centre="mean"):
    n, q = np.zeros(points.shape), np.zeros(len(points))
    for i, row in enumerate(distances(points)):
        near = points[np.argsort(row)[first : first + k]]
        if centre == "mean":
            near = near - near.mean(axis=0)
        if centre == "point":
            near = near - points[i]
        size, axes = np.linalg.eigh(near.T @ near)
        n[i], q[i] = axes[:, which], np.round(1 - size[0] / size[1], 11)
    return n, q


@answers("11.1")
def along_the_surface(points, k):
    """These directions run along the surface: they belong to the largest variance. Across the
    neighbours there is the least, and NumPy puts the least eigenvalue first.
    """
    return fitted(points, k, which=-1)


@answers("11.1")
def not_centred(points, k):
    """The centre of the neighbours was not subtracted. Then the largest variance points from the
    origin to the cloud, and what is measured depends on where the origin is.
    """
    return fitted(points, k, centre="")


@answers("11.1")
def centred_at_the_point(points, k):
    """The offsets are those from the point itself and not from the centre of its neighbours. On a
    curved surface the neighbours lie to one side of the point, and that offset counts as variance
    across.
    """
    return fitted(points, k, centre="point")


@answers("11.1")
def without_itself(points, k):
    """The point itself was left out, and one more taken instead. N(i) holds the K nearest points
    with the point among them.
    """
    return fitted(points, k, first=1)


@answers("11.1")
def one_more_neighbour(points, k):
    """These are K + 1 points: K others and the point itself. It counts as one of the K."""
    return fitted(points, k + 1)


@answers("11.1")
def row_for_column(points, k):
    """A row of the matrix of eigenvectors was taken. `eigh` returns them as columns; where the
    matrix is a rotation by itself a row looks very much like a direction, and is another one.
    """
    n, q = np.zeros(points.shape), np.zeros(len(points))
    for i, row in enumerate(distances(points)):
        near = points[np.argsort(row)[:k]]
        near = near - near.mean(axis=0)
        size, axes = np.linalg.eigh(near.T @ near)
        n[i], q[i] = axes[0], 1 - size[0] / size[1]
    return n, q


@answers("11.1")
def planarity_by_the_largest(points, k):
    """The planarity compares the least variance with the largest. On a thin strip that is small
    whatever the strip does across: what decides is the gap between the two *smallest*.
    """
    n, q = np.zeros(points.shape), np.zeros(len(points))
    for i, row in enumerate(distances(points)):
        near = points[np.argsort(row)[:k]]
        near = near - near.mean(axis=0)
        size, axes = np.linalg.eigh(near.T @ near)
        n[i], q[i] = axes[:, 0], 1 - size[0] / size[-1]
    return n, q


@answers("11.1")
def planarity_of_lengths(points, k):
    """The planarity was taken of the standard deviations, the roots of the eigenvalues. (11.2)
    has the variances themselves.
    """
    n, q = fitted(points, k)
    return n, 1 - np.sqrt(np.maximum(1 - q, 0))


@answers("11.1", named=False)
def mean_of_squares_less_square_of_mean(points, k):
    """Near the origin this is right. The matrix was computed as a sum of squares less a square of
    sums, which cancel far from the origin: at 4e4 nine digits of sixteen are lost. Subtract the
    centre first, and square then.
    """
    n, q = np.zeros(points.shape), np.zeros(len(points))
    for i, row in enumerate(distances(points)):
        near = points[np.argsort(row)[:k]]
        total = near.sum(axis=0)
        size, axes = np.linalg.eigh(near.T @ near - np.outer(total, total) / k)
        n[i], q[i] = axes[:, 0], 1 - size[0] / size[1]
    return n, q


# 11.2 The graph


def nearest(points, k, first=1):
    graph = np.zeros((len(points), len(points)))
    for i, row in enumerate(distances(points)):
        graph[i, np.argsort(row)[first:k]] = 1
    return graph


@answers("11.2")
def one_way_only(points, k):
    """The links go one way: i has j among its nearest, and j has not i. A sign could be handed on
    from i to j and not back. One of both is enough for a link.
    """
    return nearest(points, k)


@answers("11.2")
def both_ways_required(points, k):
    """Points were linked only if each is among the nearest of the other. (11.3) says *or*:
    with *and*, lonely points lose their links, and the graph falls into parts.
    """
    g = nearest(points, k)
    return g * g.T


@answers("11.2")
def linked_to_itself(points, k):
    """The points are linked to themselves. The nearest point is the point itself, which is no
    link.
    """
    g = nearest(points, k, 0)
    return np.maximum(g, g.T)


@answers("11.2")
def k_others(points, k):
    """These are links to K others. N(i) has K points with the point itself, hence K − 1 others."""
    g = nearest(points, k + 1)
    return np.maximum(g, g.T)


@answers("11.2")
def ways_counted(points, k):
    """Links that hold both ways count twice. Asked for are zeros and ones."""
    g = nearest(points, k)
    return g + g.T


@answers("11.2")
def farthest_points(points, k):
    """These are the farthest points. `argsort` puts the least first."""
    graph = np.zeros((len(points), len(points)))
    for i, row in enumerate(distances(points)):
        graph[i, np.argsort(row)[-(k - 1) :]] = 1
    return np.maximum(graph, graph.T)


@answers("11.2")
def lengths_for_links(points, k):
    """The links carry their lengths. Asked for are zeros and ones: what a link costs is decided
    later, by the normals.
    """
    g = nearest(points, k)
    return np.maximum(g, g.T) * distances(points)


# 11.3 Orientation


def grown(
    points, normals, linked, cost, *, root="highest", upward=True, parent_sign=1.0, parts=None
):
    n = normals.copy()
    left = set(range(len(n)))
    begun = 0
    while left and (parts is None or begun < parts):
        begun += 1
        i = max(left, key=lambda j: points[j, -1]) if root == "highest" else min(left)
        if upward and n[i, -1] < 0:
            n[i] = -n[i]
        left.discard(i)
        tree = [i]
        while True:
            reach = [(cost(n, a, b), a, b) for a in tree for b in left if linked[a, b]]
            if not reach:
                break
            _, a, b = min(reach)
            if parent_sign * (n[a] @ n[b]) < 0:
                n[b] = -n[b]
            tree.append(b)
            left.discard(b)
    return n


def by_angle(n, a, b):
    return 1 - abs(n[a] @ n[b])


@answers("11.3")
def away_from_the_middle(points, normals, linked):
    """The normals were turned away from the middle of the cloud. That works for convex bodies. On
    the inner side of the horseshoe the outside is towards the middle.
    """
    away = np.sum((points - points.mean(axis=0)) * normals, axis=1)
    return np.where(away < 0, -1, 1)[:, None] * normals


@answers("11.3")
def all_upward(points, normals, linked):
    """Every normal was made to point upward. This is the rule for the first point of the tree
    only; below, the outside is downward.
    """
    return np.where(normals[:, -1:] < 0, -normals, normals)


@answers("11.3")
def first_sign_kept(points, normals, linked):
    """All normals agree, but with a first one of arbitrary sign. If it points inward all others
    do too. Which rule is there for the highest point?
    """
    return grown(points, normals, linked, by_angle, upward=False)


@answers("11.3")
def begun_anywhere(points, normals, linked):
    """The tree was begun at the first point of the list, and its normal was made to point upward.
    Only at the highest point of a body is the outside above.
    """
    return grown(points, normals, linked, by_angle, root="first")


@answers("11.3")
def first_part_only(points, normals, linked):
    """Only the part with the highest point of all was oriented. The links do not reach the
    others, and each needs a beginning of its own.
    """
    return grown(points, normals, linked, by_angle, parts=1)


@answers("11.3")
def shortest_links_first(points, normals, linked):
    """The signs were handed on over the shortest links. Near a sharp tip points are near each
    other, and their normals are not: the sign that comes over such a link is wrong. (11.4) makes
    it expensive.
    """
    return grown(points, normals, linked, lambda n, a, b: np.linalg.norm(points[a] - points[b]))


@answers("11.3")
def right_angles_first(points, normals, linked):
    """The costs are the wrong way round: links between normals at right angles were taken first,
    where the sign is a guess. Parallel normals, of whatever sign, leave no doubt.
    """
    return grown(points, normals, linked, lambda n, a, b: abs(n[a] @ n[b]))


@answers("11.3")
def neighbours_turned_apart(points, normals, linked):
    """Along the tree normals were turned so that they *disagree*: the sign of the product was
    asked the wrong way round.
    """
    return grown(points, normals, linked, by_angle, parent_sign=-1.0)


@answers("11.3")
def compared_with_the_first(points, normals, linked):
    """Each normal was compared with that of the highest point, not with the neighbour from which
    its sign comes. Farther away a surface has turned round, and two right normals point in
    opposite directions.
    """
    n = normals.copy()
    top = n[np.argmax(points[:, -1])]
    top = top if top[-1] >= 0 else -top
    return np.where(n @ top < 0, -1, 1)[:, None] * n


# 11.4 Points beside


def halved(points, normals, distance, test, sides=(1, -1)):
    lengths = np.full((len(points), 2), float(distance))
    for i, p in enumerate(points):
        for s, sign in enumerate(sides):
            while not test(i, p + sign * lengths[i, s] * normals[i], lengths[i, s]):
                lengths[i, s] /= 2
                if lengths[i, s] < 1e-6:
                    break
    return lengths


def own(points):
    return lambda i, x, length: np.argmin(((points - x) ** 2).sum(axis=1)) == i


@answers("11.4")
def not_tested(points, normals, distance):
    """All lengths are the full distance. Where the body is thin, or bent, points lie on the wrong
    side of another part of it: the test is missing.
    """
    return np.full((len(points), 2), float(distance))


@answers("11.4")
def halved_once(points, normals, distance):
    """The length was halved at most once. Half of it may still be too far: test again, until the
    test is passed.
    """
    ok = own(points)
    return np.array(
        [
            [distance if ok(i, p + s * distance * normals[i], 0) else distance / 2 for s in (1, -1)]
            for i, p in enumerate(points)
        ]
    )


@answers("11.4")
def one_length_for_both_sides(points, normals, distance):
    """Both sides got the same length, the shorter one. Outside there may be room where inside
    there is none: each point has a test of its own.
    """
    lengths = halved(points, normals, distance, own(points))
    return np.tile(lengths.min(axis=1)[:, None], 2)


@answers("11.4")
def one_length_for_all(points, normals, distance):
    """All points got one length, the least that any of them needs. In one narrow place the body
    decides for all others, and their points lie nearer than they need.
    """
    return np.full((len(points), 2), halved(points, normals, distance, own(points)).min())


@answers("11.4")
def inside_first(points, normals, distance):
    """The columns are exchanged: asked for is the length outside, along the normal, and then that
    inside.
    """
    return halved(points, normals, distance, own(points))[:, ::-1]


@answers("11.4")
def both_outside(points, normals, distance):
    """Both columns were tested along the normal. The second point lies on its other side."""
    return halved(points, normals, distance, own(points), (1, 1))


@answers("11.4")
def distance_to_others_only(points, normals, distance):
    """The length was compared with the distance of the *point* to its next neighbour. Whether
    there is room beside it is a matter of the place where the added point would lie.
    """
    gaps = distances(points) + 1e9 * np.eye(len(points))
    return halved(points, normals, distance, lambda i, x, length: length < gaps[i].min())


@answers("11.4")
def as_far_as_possible(points, normals, distance):
    """The greatest length that passes the test was looked for, and not the greatest of Δ, Δ/2,
    Δ/4, … as in (11.6).
    """
    lengths = halved(points, normals, distance, own(points))
    ok = own(points)
    for i, p in enumerate(points):
        for s, sign in enumerate((1, -1)):
            low, high = lengths[i, s], min(2 * lengths[i, s], distance)
            for _ in range(60):
                middle = (low + high) / 2
                passed = ok(i, p + sign * middle * normals[i], middle)
                low, high = (middle, high) if passed else (low, middle)
            lengths[i, s] = low
    return lengths


# 11.5 The coefficients


def solved(sites, values, power=3, corner=0.0, border=1.0, ridge=0.0):
    n, d = sites.shape
    p = np.insert(sites, 0, 1.0, axis=1)
    a = distances(sites) ** power + ridge * np.eye(n)
    matrix = np.zeros((n + d + 1, n + d + 1))
    matrix[:n, :n], matrix[:n, n:], matrix[n:, :n] = a, p, border * p.T
    matrix[n:, n:] = corner * np.eye(d + 1)
    solution = np.linalg.lstsq(matrix, np.append(values, np.zeros(d + 1)), rcond=None)[0]
    return solution[:n], solution[n:]


@answers("11.5")
def distance_itself(sites, values):
    """The distance itself was used for the kernel and not its cube. Its gradient jumps at every
    site, where the surface is to have its normals.
    """
    return solved(sites, values, 1)


@answers("11.5")
def squared_distance(sites, values):
    """The squares of the distances were used. They are polynomials: sums of them are of degree
    two, whatever the number of sites, and cannot take so many values.
    """
    return solved(sites, values, 2)


@answers("11.5")
def without_the_linear_part(sites, values):
    """The linear part is missing. The matrix of cubes alone is neither positive nor sure to be
    regular, and F grows like the cube of the distance far away.
    """
    return np.linalg.solve(distances(sites) ** 3, values), np.zeros(sites.shape[1] + 1)


@answers("11.5")
def only_a_constant(sites, values):
    """There is a constant but no linear function. The cube of the distance needs side conditions
    against all polynomials of degree one.
    """
    n, d = sites.shape
    matrix = np.ones((n + 1, n + 1))
    matrix[:n, :n], matrix[n, n] = distances(sites) ** 3, 0
    solution = np.linalg.solve(matrix, np.append(values, 0))
    return solution[:n], np.append(solution[n], np.zeros(d))


@answers("11.5")
def side_conditions_missing(sites, values):
    """The side conditions, the second row of (11.8), are missing: there are fewer equations than
    unknowns, and a solver of least squares returned the shortest of all solutions.
    """
    n = len(sites)
    whole = np.hstack([distances(sites) ** 3, np.insert(sites, 0, 1.0, axis=1)])
    solution = np.linalg.lstsq(whole, values, rcond=None)[0]
    return solution[:n], solution[n:]


@answers("11.5")
def linear_part_fitted_first(sites, values):
    """A linear function was fitted first, and the cubes to what was left. Both belong together:
    taken one after the other they miss the side conditions.
    """
    p = np.insert(sites, 0, 1.0, axis=1)
    c = np.linalg.lstsq(p, values, rcond=None)[0]
    return np.linalg.solve(distances(sites) ** 3, values - p @ c), c


@answers("11.5")
def constant_last(sites, values):
    """The numbers are right and c stands in another order: the constant is to be first."""
    lam, c = solved(sites, values)
    return lam, np.roll(c, -1)


@answers("11.5")
def ones_in_the_corner(sites, values):
    """The block in the corner of (11.8) is not zero. The sums of λ and of λ times the sites are
    to be zero, without c in these equations.
    """
    return solved(sites, values, corner=1.0)


# 11.6 The field


def parts(x, sites):
    offset = x[:, None] - sites
    return offset, np.sqrt((offset**2).sum(axis=2))


@answers("11.6")
def gradient_without_the_linear_part(x, sites, lam, c):
    """The gradient lacks that of the linear part, which is the same everywhere."""
    offset, r = parts(x, sites)
    g = np.einsum("mn,mnd->md", 3 * r * lam, offset)
    return r**3 @ lam + c[0] + x @ c[1:], g


@answers("11.6")
def derivative_without_the_chain(x, sites, lam, c):
    """The derivative of the cube was taken as 3r² along the offset, and the offset has the length
    r. By the chain rule the direction has the length one: one r too many.
    """
    offset, r = parts(x, sites)
    g = np.einsum("mn,mnd->md", 3 * r**2 * lam, offset) + c[1:]
    return r**3 @ lam + c[0] + x @ c[1:], g


@answers("11.6")
def towards_the_sites(x, sites, lam, c):
    """The gradient of the cubes has the wrong sign: the offset runs from the place to the site. A
    distance grows *away* from the site.
    """
    offset, r = parts(x, sites)
    g = np.einsum("mn,mnd->md", -3 * r * lam, offset) + c[1:]
    return r**3 @ lam + c[0] + x @ c[1:], g


@answers("11.6")
def three_forgotten(x, sites, lam, c):
    """The gradient of the cubes is a third of what it should be: what is the derivative of r³?"""
    offset, r = parts(x, sites)
    g = np.einsum("mn,mnd->md", r * lam, offset) + c[1:]
    return r**3 @ lam + c[0] + x @ c[1:], g


@answers("11.6")
def divided_by_the_distance(x, sites, lam, c):
    """There is a division by the distance, and one of the places is a site: zero by zero. The
    factor cancels; write what is left.
    """
    offset, r = parts(x, sites)
    g = np.einsum("mn,mnd->md", 3 * r**2 / r * lam, offset / r[:, :, None] * r[:, :, None]) + c[1:]
    return r**3 @ lam + c[0] + x @ c[1:], g


@answers("11.6")
def constant_forgotten(x, sites, lam, c):
    """The constant c₀ is missing in the values. The gradient does not notice."""
    offset, r = parts(x, sites)
    g = np.einsum("mn,mnd->md", 3 * r * lam, offset) + c[1:]
    return r**3 @ lam + x @ c[1:], g


@answers("11.6")
def constant_taken_last(x, sites, lam, c):
    """The last entry of c was taken for the constant. By (11.7) it is the first."""
    offset, r = parts(x, sites)
    g = np.einsum("mn,mnd->md", 3 * r * lam, offset) + c[:-1]
    return r**3 @ lam + c[-1] + x @ c[:-1], g


@answers("11.6")
def unit_gradient(x, sites, lam, c):
    """The gradients were divided by their lengths. These are the directions of the normals, up to
    the sign; asked for is the gradient itself, with the slope as its length.
    """
    offset, r = parts(x, sites)
    g = np.einsum("mn,mnd->md", 3 * r * lam, offset) + c[1:]
    return r**3 @ lam + c[0] + x @ c[1:], g / np.sqrt((g * g).sum(axis=1))[:, None]


# 11.7 Newton


def slope(x, sites, lam, c):
    offset, r = parts(x, sites)
    return r**3 @ lam + c[0] + x @ c[1:], np.einsum("mn,mnd->md", 3 * r * lam, offset) + c[1:]


def stepped(x, sites, lam, c, steps, rule):
    for _ in range(steps):
        x = x + rule(*slope(x, sites, lam, c))
    return x


def squares(g):
    return (g * g).sum(axis=1)[:, None]


@answers("11.7")
def divided_by_the_slope_once(x, sites, lam, c, steps):
    """The step is F times the unit gradient: it is divided by the length of the gradient once.
    The gradient in the numerator has that length as well, so it has to be divided twice.
    """
    return stepped(x, sites, lam, c, steps, lambda f, g: -f[:, None] * g / np.sqrt(squares(g)))


@answers("11.7")
def not_divided(x, sites, lam, c, steps):
    """The step is F times the gradient, not divided by anything: a descent with a step of its own
    length, and not Newton's method.
    """
    return stepped(x, sites, lam, c, steps, lambda f, g: -f[:, None] * g)


@answers("11.7")
def to_the_other_side(x, sites, lam, c, steps):
    """The steps lead away from the zero level: where F is positive one has to go *down*."""
    return stepped(x, sites, lam, c, steps, lambda f, g: f[:, None] * g / squares(g))


@answers("11.7")
def coordinate_by_coordinate(x, sites, lam, c, steps):
    """Newton's method was used in each coordinate by itself, F divided by each derivative. Every
    one of these steps alone would lead to the tangent's zero: together they go too far.
    """
    return stepped(x, sites, lam, c, steps, lambda f, g: -f[:, None] / g)


@answers("11.7")
def one_step_only(x, sites, lam, c, steps):
    """There is one step, however many are asked for."""
    return stepped(x, sites, lam, c, 1, lambda f, g: -f[:, None] * g / squares(g))


@answers("11.7")
def first_gradient_kept(x, sites, lam, c, steps):
    """F and its gradient were computed once, and all steps taken with them. After a step both are
    others.
    """
    f, g = slope(x, sites, lam, c)
    return x - steps * f[:, None] * g / squares(g)


@answers("11.7")
def scaled_together(x, sites, lam, c, steps):
    """All gradients were divided by one number, the sum of squares over the whole array. Each
    place has a slope of its own: along which axis is summed?
    """
    return stepped(x, sites, lam, c, steps, lambda f, g: -f[:, None] * g / (g * g).sum())


# 11.8 Marching squares

CORNERS = np.array([[0.0, 0], [1, 0], [1, 1], [0, 1]])


def marched(values, share, swap=False, corners=CORNERS):
    ends = np.zeros((len(values), 2, 2))
    for e, f in zip(ends, values):
        for i in range(4):
            j = (i + 1) % 4
            if f[i] * f[j] < 0:
                e[int((f[i] < 0) != swap)] = corners[i] + share(f[i], f[j]) * (
                    corners[j] - corners[i]
                )
    return ends


def linear(a, b):
    return a / (a - b)


@answers("11.8")
def middles_of_the_sides(values):
    """The ends are in the middle of the sides. The values tell more: nearer to zero is nearer to
    the level.
    """
    return marched(values, lambda a, b: 0.5)


@answers("11.8")
def from_the_wrong_end(values):
    """The share belongs to the other end of the side: where the value at the first end is small,
    the crossing is near to *it*.
    """
    return marched(values, lambda a, b: b / (b - a))


@answers("11.8")
def by_sizes_of_both(values):
    """The share is a/(a + b) with the signs in it, and the ends lie outside of the square. Both
    values have different signs: what is their difference?
    """
    return marched(values, lambda a, b: a / (a + b))


@answers("11.8")
def run_backwards(values):
    """The pieces are right, and run the other way: what is positive lies to their right."""
    return marched(values, linear, swap=True)


@answers("11.8")
def in_the_order_of_the_sides(values):
    """The ends are in the order in which they were found, so that what is positive lies now to
    the left, now to the right. Which of the two changes of sign is the start?
    """
    ends = np.zeros((len(values), 2, 2))
    for e, f in zip(ends, values):
        found = [
            CORNERS[i] + linear(f[i], f[i - 3]) * (CORNERS[i - 3] - CORNERS[i])
            for i in range(4)
            if f[i] * f[i - 3] < 0
        ]
        e[:] = found[:2]
    return ends


@answers("11.8")
def corners_row_by_row(values):
    """The corners were taken row by row, as (0,0), (1,0), (0,1), (1,1). They are given *round*
    the square: from one to the next there is a side, not a diagonal.
    """
    return marched(values, linear, corners=CORNERS[[0, 1, 3, 2]])


@answers("11.8")
def coordinates_exchanged(values):
    """The two coordinates are exchanged: the second corner is (1, 0). The square is seen in a
    mirror, and what was to the left is to the right.
    """
    return marched(values, linear, corners=CORNERS[:, ::-1])


@answers("11.8")
def last_side_forgotten(values):
    """The side from the last corner back to the first was not looked at. Pieces that cross it
    have an end at (0, 0).
    """
    ends = np.zeros((len(values), 2, 2))
    for e, f in zip(ends, values):
        for i in range(3):
            if f[i] * f[i + 1] < 0:
                e[int(f[i] < 0)] = CORNERS[i] + linear(f[i], f[i + 1]) * (
                    CORNERS[i + 1] - CORNERS[i]
                )
    return ends
