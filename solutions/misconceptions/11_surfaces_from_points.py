"""Mistakes in notebook 11, each with the sentence that the student reads."""

import numpy as np

from fieldgrade.authoring.catalogue import answers


def distances(points):
    return np.sqrt(((points[:, None] - points) ** 2).sum(axis=2))


# 11.1 Normals


def neighbours(points, k, first=0):
    """The k nearest points of each point, of shape (N, k, D)."""
    return points[np.argsort(distances(points), axis=1)[:, first : first + k]]


def products(offsets):
    return np.einsum("nki,nkj->nij", offsets, offsets)


def principal(near, centre=None):
    """Eigenvalues (N, D) and eigenvectors (N, D, D), about the means or another centre."""
    return np.linalg.eigh(
        products(near - (near.mean(axis=1)[:, None] if centre is None else centre))
    )


def planarity(sizes):
    return np.round(1 - sizes[:, 0] / sizes[:, 1], 11)


def fitted(points, k, first=0, which=0, centre=None):
    sizes, axes = principal(neighbours(points, k, first), centre)
    return axes[:, :, which], planarity(sizes)


@answers("11.1")
def stored_like_the_points(points, k):
    """The normals were stored in an array of the type of the points, as `np.zeros_like` makes it.
    For points with integer coordinates it holds integers only, and the decimals are lost.
    """
    n, q = fitted(points, k)
    return n.astype(points.dtype), q


@answers("11.1")
def along_the_surface(points, k):
    """These directions run along the surface, since they belong to the largest variance. The normal
    belongs to the smallest variance. NumPy sorts the eigenvalues in increasing order.
    """
    return fitted(points, k, which=-1)


@answers("11.1")
def not_centred(points, k):
    """The mean of the neighbours was not subtracted. Then the largest variance points from the
    origin to the cloud, and the result depends on the position of the origin.
    """
    return fitted(points, k, centre=0)


@answers("11.1")
def centred_at_the_point(points, k):
    """The offsets start at the point itself and not at the mean of its neighbours. On a curved
    surface the neighbours lie on one side of the point, and this adds to the variance across the
    surface.
    """
    return fitted(points, k, centre=points[:, None])


@answers("11.1")
def without_itself(points, k):
    """The point itself is missing, and one more neighbour was taken instead. N(i) holds the K
    nearest points including the point itself.
    """
    return fitted(points, k, first=1)


@answers("11.1")
def one_more_neighbour(points, k):
    """These are K + 1 points: the point itself and K others. N(i) has K points including the point
    itself.
    """
    return fitted(points, k + 1)


@answers("11.1")
def row_for_column(points, k):
    """A row of the matrix of eigenvectors was taken. `eigh` returns the eigenvectors as columns."""
    sizes, axes = principal(neighbours(points, k))
    return axes[:, 0], planarity(sizes)


@answers("11.1")
def planarity_by_the_largest(points, k):
    """The planarity compares the smallest variance with the largest. The formula (11.2) compares
    the two smallest, which is another number in space.
    """
    sizes, axes = principal(neighbours(points, k))
    return axes[:, :, 0], 1 - sizes[:, 0] / sizes[:, -1]


@answers("11.1")
def planarity_of_lengths(points, k):
    """The planarity was computed from standard deviations, the square roots of the eigenvalues.
    (11.2) uses the variances themselves.
    """
    n, q = fitted(points, k)
    return n, 1 - np.sqrt(np.maximum(1 - q, 0))


@answers("11.1", named=False)
def mean_of_squares_less_square_of_mean(points, k):
    """The covariance was computed as a sum of squares minus a square of sums. Far from the origin
    both are nearly equal, and digits cancel. Subtract the mean first.
    """
    near = neighbours(points, k)
    sizes, axes = np.linalg.eigh(products(near) - products(near.sum(axis=1, keepdims=True)) / k)
    return axes[:, :, 0], 1 - sizes[:, 0] / sizes[:, 1]


@answers("11.1")
def ratio_upside_down(points, k):
    """The normals are right. In the planarity the quotient is inverted, so that it is not between
    0 and 1: divide the smallest eigenvalue by the second smallest.
    """
    sizes, axes = principal(neighbours(points, k))
    return axes[:, :, 0], 1 - sizes[:, 1] / sizes[:, 0]


@answers("11.1")
def ratio_alone(points, k):
    """The normals are right. The second array is the quotient of the eigenvalues; (11.2) is one
    minus this quotient.
    """
    n, q = fitted(points, k)
    return n, 1 - q


# 11.2 The graph


def nearest(points, k, first=1):
    graph = np.zeros((len(points), len(points)))
    for i, row in enumerate(distances(points)):
        graph[i, np.argsort(row)[first:k]] = 1
    return graph


@answers("11.2")
def one_way_only(points, k):
    """The links go one way only: i has j among its nearest points, but j does not have i. By (11.3)
    one of the two suffices for a link in both directions.
    """
    return nearest(points, k)


@answers("11.2")
def both_ways_required(points, k):
    """Two points were linked only if each is among the nearest of the other. (11.3) says *or*. With
    *and*, isolated points lose their links, and the graph falls into components.
    """
    g = nearest(points, k)
    return g * g.T


@answers("11.2")
def linked_to_itself(points, k):
    """The points are linked to themselves. The nearest point is the point itself, and (11.3)
    excludes it.
    """
    g = nearest(points, k, 0)
    return np.maximum(g, g.T)


@answers("11.2")
def k_others(points, k):
    """These are links to K others. N(i) has K points including the point itself, hence K − 1
    others.
    """
    g = nearest(points, k + 1)
    return np.maximum(g, g.T)


@answers("11.2")
def ways_counted(points, k):
    """Links that hold in both directions count twice. The function should return zeros and ones."""
    g = nearest(points, k)
    return g + g.T


@answers("11.2")
def farthest_points(points, k):
    """These are the farthest points. `argsort` sorts in increasing order."""
    graph = np.zeros((len(points), len(points)))
    for i, row in enumerate(distances(points)):
        graph[i, np.argsort(row)[-(k - 1) :]] = 1
    return np.maximum(graph, graph.T)


@answers("11.2")
def lengths_for_links(points, k):
    """The links carry their lengths. The function should return zeros and ones. The cost of a link
    is computed later, from the normals.
    """
    g = nearest(points, k)
    return np.maximum(g, g.T) * distances(points)


# 11.3 Orientation


def grown(
    points,
    normals,
    linked,
    cost,
    *,
    root="highest",
    upward=True,
    parent_sign=1.0,
    parts=None,
    compared_with=None,
):
    """Prim's algorithm; of links with equal costs the first one in the list is taken."""
    n = normals.copy()
    parents = n if compared_with is None else compared_with
    costs = np.where(linked, cost, np.inf)
    outside = np.ones(len(n), dtype=bool)
    begun = 0
    while outside.any() and (parts is None or begun < parts):
        begun += 1
        heights = np.where(outside, points[:, -1], -np.inf)
        i = heights.argmax() if root == "highest" else outside.argmax()
        if upward and n[i, -1] < 0:
            n[i] = -n[i]
        best, origin = np.full(len(n), np.inf), np.zeros(len(n), dtype=int)
        while True:
            outside[i] = False
            better = outside & ((costs[i] < best) | (costs[i] == best) & (i < origin))
            best[better], origin[better], best[i] = costs[i, better], i, np.inf
            if not np.isfinite(best.min()):
                break
            i = min(np.flatnonzero(best == best.min()), key=lambda j: origin[j])
            if parent_sign * (parents[origin[i]] @ n[i]) < 0:
                n[i] = -n[i]
    return n


def by_angle(normals):
    return 1 - np.abs(normals @ normals.T)


@answers("11.3")
def away_from_the_middle(points, normals, linked):
    """The normals were oriented away from the mean of the cloud. This works for convex bodies. On
    the inner side of the horseshoe the outside is towards the mean.
    """
    away = np.sum((points - points.mean(axis=0)) * normals, axis=1)
    return np.where(away < 0, -1, 1)[:, None] * normals


@answers("11.3")
def all_upward(points, normals, linked):
    """Every normal was made to point upward. This rule holds for the highest point of a component
    only; at the bottom of a body the outside is downward.
    """
    return np.where(normals[:, -1:] < 0, -normals, normals)


@answers("11.3")
def first_sign_kept(points, normals, linked):
    """All normals agree with each other, but not with the rule for the first one. If it points
    inward, so do all others. What does the rule say about which point and which component?
    """
    return grown(points, normals, linked, by_angle(normals), upward=False)


@answers("11.3")
def begun_anywhere(points, normals, linked):
    """The tree begins at the first point of the list, and its normal was made to point upward. Only
    at the highest point of a component is the outside known to be above.
    """
    return grown(points, normals, linked, by_angle(normals), root="first")


@answers("11.3")
def first_part_only(points, normals, linked):
    """Only the component with the highest point of all was oriented. The links do not reach the
    other components. Each of them needs a first point of its own.
    """
    return grown(points, normals, linked, by_angle(normals), parts=1)


@answers("11.3")
def shortest_links_first(points, normals, linked):
    """The signs were passed along the shortest links. Near a sharp tip two points are close, but
    their normals are not parallel, so the sign is unsafe. (11.4) makes such a link expensive.
    """
    return grown(points, normals, linked, distances(points))


@answers("11.3")
def right_angles_first(points, normals, linked):
    """The costs are inverted: links between perpendicular normals were taken first, where the sign
    is a guess. Parallel normals, of either sign, must be cheap.
    """
    return grown(points, normals, linked, 1 - by_angle(normals))


@answers("11.3")
def neighbours_turned_apart(points, normals, linked):
    """Along the tree the normals were inverted so that they *disagree*. The test of the scalar
    product has the wrong sign.
    """
    return grown(points, normals, linked, by_angle(normals), parent_sign=-1.0)


@answers("11.3")
def compared_with_the_first(points, normals, linked):
    """Each normal was compared with that of the highest point and not with that of its neighbour in
    the tree. Far away the outward normal may well point in the opposite direction.
    """
    n = normals.copy()
    top = n[np.argmax(points[:, -1])]
    top = top if top[-1] >= 0 else -top
    return np.where(n @ top < 0, -1, 1)[:, None] * n


def grown_by_arrays(
    points,
    normals,
    linked,
    highest=lambda heights, outside: np.argmax(np.where(outside, heights, -np.inf)),
    keeps_latest=False,
):
    """Prim's algorithm with the cost and the origin of the best link to each point outside."""
    n = normals.copy()
    outside = np.ones(len(n), dtype=bool)
    cost, origin = np.full(len(n), np.inf), np.full(len(n), -1)
    while outside.any():
        i = int(np.argmin(np.where(outside, cost, np.inf)))
        if not (outside[i] and np.isfinite(cost[i])):
            i = int(highest(points[:, -1], outside))
            if not outside[i]:
                return n
            n[i] *= -1 if n[i, -1] < 0 else 1
        elif n[i] @ n[origin[i]] < 0:
            n[i] *= -1
        outside[i] = False
        for j in np.flatnonzero(linked[i] * outside):
            if keeps_latest or 1 - abs(n[i] @ n[j]) < cost[j]:
                cost[j], origin[j] = 1 - abs(n[i] @ n[j]), i
    return n


@answers("11.3")
def last_link_kept(points, normals, linked):
    """Each point outside the tree keeps its *latest* link to the tree, not its cheapest: the
    comparison of the costs is missing.
    """
    return grown_by_arrays(points, normals, linked, keeps_latest=True)


@answers("11.3")
def compared_with_the_given_normal(points, normals, linked):
    """Each normal was compared with the *given* normal of its neighbour in the tree. The neighbour
    may have been inverted before: compare with the oriented normal.
    """
    return grown(points, normals, linked, by_angle(normals), compared_with=normals)


@answers("11.3")
def all_inward(points, normals, linked):
    """All normals point inward: the first normal of each component has the wrong sign. At the
    highest point the outward normal points upward.
    """
    return -grown(points, normals, linked, by_angle(normals))


@answers("11.3", named=False)
def part_begun_at_height_zero(points, normals, linked):
    """The highest point of a component below zero is not found."""
    return grown_by_arrays(
        points, normals, linked, lambda heights, outside: np.argmax(heights * outside)
    )


# 11.4 Points beside


def halved(points, normals, distance, passes, sides=(1, -1)):
    lengths = np.full((len(points), 2), float(distance))
    for length, side in zip(lengths.T, sides, strict=True):
        while True:
            failed = ~passes(points + side * length[:, None] * normals, length)
            failed &= length >= 1e-12 * distance
            if not failed.any():
                break
            length[failed] /= 2
    return lengths


def own(points):
    """Whether the nearest point to each place is the one with the same number."""
    return lambda places, _: nearest_points(points, places) == np.arange(len(points))


def nearest_points(points, places):
    return ((points - places[:, None]) ** 2).sum(axis=2).argmin(axis=1)


@answers("11.4")
def not_tested(points, normals, distance):
    """All lengths are the full distance Δ. Where the body is thin or bent, points lie on the wrong
    side of another part of it. The test of (11.6) is missing.
    """
    return np.full((len(points), 2), float(distance))


@answers("11.4")
def halved_once(points, normals, distance):
    """The length was halved at most once. Half of it may still be too large: repeat until the test
    is passed.
    """
    passes = own(points)
    sides = (points + side * distance * normals for side in (1, -1))
    return np.array([np.where(passes(side, 0), distance, distance / 2) for side in sides]).T


@answers("11.4")
def one_length_for_both_sides(points, normals, distance):
    """Both sides have the same length, the shorter one. Each side has its own test: there may be
    room outside where there is none inside.
    """
    lengths = halved(points, normals, distance, own(points))
    return np.tile(lengths.min(axis=1)[:, None], 2)


@answers("11.4")
def one_length_for_all(points, normals, distance):
    """All points have the same length, the smallest that any of them needs. By (11.6) each point
    has its own length.
    """
    return np.full((len(points), 2), halved(points, normals, distance, own(points)).min())


@answers("11.4")
def inside_first(points, normals, distance):
    """The columns are exchanged. Column 0 is the length outside, along the normal; column 1 is the
    length inside.
    """
    return halved(points, normals, distance, own(points))[:, ::-1]


@answers("11.4")
def both_outside(points, normals, distance):
    """Both columns were tested along the normal. The second column belongs to the opposite
    direction.
    """
    return halved(points, normals, distance, own(points), (1, 1))


@answers("11.4")
def distance_to_others_only(points, normals, distance):
    """The length was compared with the distance from the *point* to its nearest neighbour. The test
    of (11.6) concerns the off-surface point: which point of the cloud is nearest to it?
    """
    gaps = distances(points) + 1e9 * np.eye(len(points))
    return halved(points, normals, distance, lambda places, length: length < gaps.min(axis=1))


@answers("11.4")
def at_most_thirty_halvings(points, normals, distance):
    """The length was halved thirty times at most. Beside a very large Δ a cloud may be so small
    that this is too few: halve until the test of (11.6) is passed.
    """
    lengths = halved(points, normals, distance, own(points))
    return np.maximum(lengths, distance / 2**30)


@answers("11.4")
def as_far_as_possible(points, normals, distance):
    """The largest length that passes the test was computed. (11.6) asks for the largest of Δ, Δ/2,
    Δ/4, … that passes.
    """
    passes = own(points)
    lengths = halved(points, normals, distance, passes)
    for low, side in zip(lengths.T, (1, -1), strict=True):
        high = np.minimum(2 * low, distance)
        for _ in range(60):
            middle = (low + high) / 2
            passed = passes(points + side * middle[:, None] * normals, middle)
            low[passed], high[~passed] = middle[passed], middle[~passed]
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
    """The kernel is the distance and not its cube. The gradient of the distance jumps at every
    site, where the surface needs its normals.
    """
    return solved(sites, values, 1)


@answers("11.5")
def squared_distance(sites, values):
    """The kernel is the squared distance, a polynomial. Sums of squared distances are polynomials
    of degree two, and cannot take so many values.
    """
    return solved(sites, values, 2)


@answers("11.5")
def without_the_linear_part(sites, values):
    """The linear polynomial is missing. Without it and the side conditions, the matrix of cubes may
    be singular, and F grows like the cube of the distance.
    """
    return np.linalg.solve(distances(sites) ** 3, values), np.zeros(sites.shape[1] + 1)


@answers("11.5")
def only_a_constant(sites, values):
    """There is a constant but no linear polynomial. The kernel r³ is conditionally positive
    definite of order two: it needs the side conditions for all linear polynomials.
    """
    n, d = sites.shape
    matrix = np.ones((n + 1, n + 1))
    matrix[:n, :n], matrix[n, n] = distances(sites) ** 3, 0
    solution = np.linalg.solve(matrix, np.append(values, 0))
    return solution[:n], np.append(solution[n], np.zeros(d))


@answers("11.5")
def side_conditions_missing(sites, values):
    """The side conditions, the second row of (11.8), are missing. There are fewer equations than
    unknowns, and least squares returned the shortest of all solutions.
    """
    n = len(sites)
    whole = np.hstack([distances(sites) ** 3, np.insert(sites, 0, 1.0, axis=1)])
    solution = np.linalg.lstsq(whole, values, rcond=None)[0]
    return solution[:n], solution[n:]


@answers("11.5")
def linear_part_fitted_first(sites, values):
    """A linear function was fitted first, and the cubes were fitted to the residuals. Then the side
    conditions do not hold: (11.8) must be solved as one system.
    """
    p = np.insert(sites, 0, 1.0, axis=1)
    c = np.linalg.lstsq(p, values, rcond=None)[0]
    return np.linalg.solve(distances(sites) ** 3, values - p @ c), c


@answers("11.5")
def constant_last(sites, values):
    """The numbers are right, but c is in another order. The constant c₀ is its first entry."""
    lam, c = solved(sites, values)
    return lam, np.roll(c, -1)


@answers("11.5")
def ones_in_the_corner(sites, values):
    """The lower right block of (11.8) is not zero. The side conditions do not contain c."""
    return solved(sites, values, corner=1.0)


# 11.6 The field


def parts(x, sites):
    offset = x[:, None] - sites
    return offset, np.sqrt((offset**2).sum(axis=2))


@answers("11.6", named=False)
def sums_subtracted(x, sites, lam, c):
    """Far from the origin two large sums are subtracted, and their digits are lost."""
    r = np.linalg.norm(x[:, None] - sites, axis=2)
    k = 3 * r * lam
    return r**3 @ lam + c[0] + x @ c[1:], x * k.sum(axis=1)[:, None] - k @ sites + c[1:]


@answers("11.6")
def gradient_without_the_linear_part(x, sites, lam, c):
    """The gradient of the linear polynomial is missing. It is the same at all points."""
    offset, r = parts(x, sites)
    g = np.einsum("mn,mnd->md", 3 * r * lam, offset)
    return r**3 @ lam + c[0] + x @ c[1:], g


@answers("11.6")
def no_slope_beside_the_sites(x, sites, lam, c):
    """Beside a site the term of this site is missing in the gradient: a fixed length decides which
    points count as the site. The term tends to zero there, so no distinction is needed.
    """
    offset, r = parts(x, sites)
    g = np.einsum("mn,mnd->md", 3 * np.where(r < 2e-3, 0, r) * lam, offset) + c[1:]
    return r**3 @ lam + c[0] + x @ c[1:], g


@answers("11.6")
def derivative_without_the_chain(x, sites, lam, c):
    """The derivative was taken as 3r² times the offset. By the chain rule it is 3r² times a *unit*
    vector, so there is one factor r too many.
    """
    offset, r = parts(x, sites)
    g = np.einsum("mn,mnd->md", 3 * r**2 * lam, offset) + c[1:]
    return r**3 @ lam + c[0] + x @ c[1:], g


@answers("11.6")
def towards_the_sites(x, sites, lam, c):
    """The gradient of the cubes has the wrong sign. The distance grows *away* from the site."""
    offset, r = parts(x, sites)
    g = np.einsum("mn,mnd->md", -3 * r * lam, offset) + c[1:]
    return r**3 @ lam + c[0] + x @ c[1:], g


@answers("11.6")
def three_forgotten(x, sites, lam, c):
    """The gradient of the cubes is a third of what it should be. What is the derivative of r³?"""
    offset, r = parts(x, sites)
    g = np.einsum("mn,mnd->md", r * lam, offset) + c[1:]
    return r**3 @ lam + c[0] + x @ c[1:], g


@answers("11.6")
def divided_by_the_distance(x, sites, lam, c):
    """The distance is in a denominator, and one of the points is a site: zero divided by zero. The
    factor r cancels; simplify the formula first.
    """
    offset, r = parts(x, sites)
    g = np.einsum("mn,mnd->md", 3 * r**2 / r * lam, offset / r[:, :, None] * r[:, :, None]) + c[1:]
    return r**3 @ lam + c[0] + x @ c[1:], g


@answers("11.6")
def constant_forgotten(x, sites, lam, c):
    """The constant c₀ is missing in the values. The gradient does not contain it."""
    offset, r = parts(x, sites)
    g = np.einsum("mn,mnd->md", 3 * r * lam, offset) + c[1:]
    return r**3 @ lam + x @ c[1:], g


@answers("11.6")
def constant_taken_last(x, sites, lam, c):
    """The last entry of c was used as the constant. By (11.7) the constant is the first entry."""
    offset, r = parts(x, sites)
    g = np.einsum("mn,mnd->md", 3 * r * lam, offset) + c[:-1]
    return r**3 @ lam + c[-1] + x @ c[:-1], g


@answers("11.6")
def unit_gradient(x, sites, lam, c):
    """The gradients were divided by their lengths. Return the gradient itself."""
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
    """The step is F times the unit gradient: it was divided by the length of the gradient once.
    (11.9) divides by the *square* of this length.
    """
    return stepped(x, sites, lam, c, steps, lambda f, g: -f[:, None] * g / np.sqrt(squares(g)))


@answers("11.7")
def not_divided(x, sites, lam, c, steps):
    """The step is F times the gradient, without a division. This is a descent of arbitrary step
    length and not Newton's method.
    """
    return stepped(x, sites, lam, c, steps, lambda f, g: -f[:, None] * g)


@answers("11.7")
def to_the_other_side(x, sites, lam, c, steps):
    """The steps lead away from the zero level. Where F is positive, a step must decrease it."""
    return stepped(x, sites, lam, c, steps, lambda f, g: f[:, None] * g / squares(g))


@answers("11.7")
def coordinate_by_coordinate(x, sites, lam, c, steps):
    """F was divided by each partial derivative separately. Each of these steps alone leads to the
    zero of the tangent, so together they go too far.
    """
    return stepped(x, sites, lam, c, steps, lambda f, g: -f[:, None] / g)


@answers("11.7")
def one_step_only(x, sites, lam, c, steps):
    """Only one step was made, whatever the number of steps."""
    return stepped(x, sites, lam, c, 1, lambda f, g: -f[:, None] * g / squares(g))


@answers("11.7")
def one_step_too_many(x, sites, lam, c, steps):
    """There is one step too many: for `steps` = 1 only the first one must be made."""
    return stepped(x, sites, lam, c, steps + 1, lambda f, g: -f[:, None] * g / squares(g))


@answers("11.7")
def first_gradient_kept(x, sites, lam, c, steps):
    """F and its gradient were computed once, and all steps use them. Both must be evaluated again
    after each step.
    """
    f, g = slope(x, sites, lam, c)
    return x - steps * f[:, None] * g / squares(g)


@answers("11.7")
def scaled_together(x, sites, lam, c, steps):
    """All gradients were divided by one number, the sum of squares over the whole array. Each point
    has its own gradient: along which axis must the sum run?
    """
    return stepped(x, sites, lam, c, steps, lambda f, g: -f[:, None] * g / (g * g).sum())


@answers("11.7")
def stopped_at_a_small_value(x, sites, lam, c, steps):
    """The steps end as soon as all values of F are below a fixed number. If lengths are of the size
    10⁻⁹, as in metres between atoms, all values of a distance are below it from the start. Make the
    given number of steps.
    """
    for _ in range(steps):
        f, g = slope(x, sites, lam, c)
        if np.abs(f).max() < 1e-8:
            break
        x = x - f[:, None] * g / squares(g)
    return x


@answers("11.7")
def stopped_after_a_small_step(x, sites, lam, c, steps):
    """The steps end as soon as one of them is shorter than a fixed number. If all lengths are of
    the size 10⁻⁹, already the first step is shorter. Make the given number of steps.
    """
    for _ in range(steps):
        f, g = slope(x, sites, lam, c)
        step = f[:, None] * g / squares(g)
        x = x - step
        if np.abs(step).max() < 1e-8:
            break
    return x


@answers("11.7", named=False)
def steps_limited(x, sites, lam, c, steps):
    """The steps were limited to a fixed length. The unit of length must not matter."""
    return stepped(x, sites, lam, c, steps, lambda f, g: (-f[:, None] * g / squares(g)).clip(-1, 1))


@answers("11.7", named=False)
def small_number_below(x, sites, lam, c, steps):
    """A fixed number was added to the denominator. The unit of length must not matter."""
    return stepped(x, sites, lam, c, steps, lambda f, g: -f[:, None] * g / (squares(g) + 1e-6))


# 11.8 Marching squares

CORNERS = np.array([[0.0, 0], [1, 0], [1, 1], [0, 1]])


def marched(values, share, swap=False, corners=CORNERS):
    ends = np.zeros((len(values), 2, 2))
    for e, f in zip(ends, values):
        for i in range(4):
            j = (i + 1) % 4
            if (f[i] > 0) != (f[j] > 0):
                e[int((f[i] < 0) != swap)] = corners[i] + share(f[i], f[j]) * (
                    corners[j] - corners[i]
                )
    return ends


def linear(a, b):
    return a / (a - b)


@answers("11.8")
def middles_of_the_sides(values):
    """The ends are at the midpoints of the sides. The level is nearer to the corner whose value is
    closer to zero.
    """
    return marched(values, lambda a, b: 0.5)


@answers("11.8")
def from_the_wrong_end(values):
    """The share was measured from the other end of the side. Where the value at the first end is
    small, the crossing is near the *first* end.
    """
    return marched(values, lambda a, b: b / (b - a))


@answers("11.8")
def by_sizes_of_both(values):
    """The share is a/(a + b) with signed values, so the ends are outside the square. The two values
    have different signs: use their difference.
    """
    return marched(values, lambda a, b: a / (a + b))


@answers("11.8")
def run_backwards(values):
    """The pieces are right, but run in the opposite direction: the positive values are on their
    right.
    """
    return marched(values, linear, swap=True)


@answers("11.8")
def in_the_order_of_the_sides(values):
    """The ends are in the order in which they were found, so the positive values are on the left of
    some pieces only. Which change of sign is the start?
    """
    ends = np.zeros((len(values), 2, 2))
    for e, f in zip(ends, values):
        found = [
            CORNERS[i] + linear(f[i], f[i - 3]) * (CORNERS[i - 3] - CORNERS[i])
            for i in range(4)
            if (f[i] > 0) != (f[i - 3] > 0)
        ]
        e[:] = found[:2]
    return ends


@answers("11.8")
def corners_row_by_row(values):
    """The corners were taken row by row, as (0,0), (1,0), (0,1), (1,1). They are given in their
    order *round* the square.
    """
    return marched(values, linear, corners=CORNERS[[0, 1, 3, 2]])


@answers("11.8")
def coordinates_exchanged(values):
    """The two coordinates are exchanged: the second corner is (1, 0). The square is reflected, so
    left and right are exchanged too.
    """
    return marched(values, linear, corners=CORNERS[:, ::-1])


@answers("11.8")
def last_side_forgotten(values):
    """The side from the last corner back to the first was skipped. Pieces that cross it have an end
    at (0, 0).
    """
    ends = np.zeros((len(values), 2, 2))
    for e, f in zip(ends, values):
        for i in range(3):
            if (f[i] > 0) != (f[i + 1] > 0):
                e[int(f[i] < 0)] = CORNERS[i] + linear(f[i], f[i + 1]) * (
                    CORNERS[i + 1] - CORNERS[i]
                )
    return ends


@answers("11.1", named=False)
def distances_by_products(points, k):
    """Far from the origin the squares of the coordinates leave no digits for distances."""
    n, q = np.zeros(points.shape), np.zeros(len(points))
    for i, p in enumerate(points):
        near = points[np.argsort((points**2).sum(axis=1) - 2 * points @ p, kind="stable")[:k]]
        values, vectors = np.linalg.eigh(np.cov(near.T, bias=True))
        n[i], q[i] = vectors[:, 0], 1 - values[0] / values[1]
    return n, q


@answers("11.8", named=False)
def in_units_of_the_largest_value(values):
    """Tiny values divided by the largest of all squares become zero."""
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    ends = np.zeros((len(values), 2, 2))
    for row, f in zip(ends, values / np.abs(values).max(), strict=True):
        for i in range(4):
            j = (i + 1) % 4
            if (f[i] > 0) != (f[j] > 0):
                row[int(f[j] > 0)] = square[i] + f[i] / (f[i] - f[j]) * (square[j] - square[i])
    return ends
