"""What students write instead of notebook 14, and what each of them should hear."""

import numpy as np

from fieldgrade.authoring.catalogue import answers


def sides(triangles):
    return np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2).reshape(-1, 2)


def parts(n, links):
    label, changed = list(range(n)), True
    while changed:
        changed = False
        for a, b in np.reshape(links, (-1, 2)).astype(int).tolist():
            changed |= label[a] != label[b]
            label[a] = label[b] = min(label[a], label[b])
    return np.array(label)


def counted(triangles, ends):
    known = {}
    for e in map(tuple, ends.tolist()):
        known[e] = known.get(e, 0) + 1
    return np.array([known[e] for e in map(tuple, ends.tolist())])


def at_sides(triangles):
    return counted(triangles, np.sort(sides(triangles), axis=1))


def distances(points):
    return np.sqrt(((points[:, None] - points) ** 2).sum(axis=2))


# 14.1 Weld


@answers("14.1")
def rounded_to_a_grid(points, tolerance):
    """The coordinates were rounded to multiples of the tolerance and then compared. Two points on
    both sides of a border of that grid are told apart however near they are, and two far ends of
    one cell are not. Compare distances.
    """
    steps = np.round(points / (tolerance or 1e-300)) if tolerance else points
    return np.array([int(np.argmax((steps == p).all(axis=1))) for p in steps])


@answers("14.1")
def exactly_equal_only(points, tolerance):
    """Only points that are equal to the last digit were welded; the tolerance is not used. After
    a rotation, or a detour through a file with six digits, hardly any two are.
    """
    return np.array([int(np.argmax((points == p).all(axis=1))) for p in points])


@answers("14.1")
def each_coordinate_by_itself(points, tolerance):
    """Each coordinate was compared with the tolerance by itself, which makes a cube of the ball
    of (14.1). Its corners are farther away, by the root of three.
    """
    near = (np.abs(points[:, None] - points) <= tolerance).all(axis=2)
    return np.argmax(near, axis=1)


@answers("14.1")
def relative_tolerance(points, tolerance):
    """`isclose` adds to the tolerance a part of the size of the numbers, 1e-5 if it is not told
    otherwise. Far from the origin this is more than the distance of good vertices, and the mesh
    collapses. Which argument turns it off?
    """
    near = np.isclose(points[:, None], points, atol=tolerance).all(axis=2)
    return np.argmax(near, axis=1)


@answers("14.1")
def nearer_than_the_tolerance(points, tolerance):
    """The distance had to be less than the tolerance. In (14.1) it may be equal: with the
    tolerance zero a point is not even in its own place otherwise.
    """
    return np.argmax(distances(points) < tolerance, axis=1)


@answers("14.1")
def last_in_its_place(points, tolerance):
    """Each vertex got the last of those in its place. (14.1) takes the first: copies are added
    behind what was there before, and the old numbers should survive.
    """
    near = distances(points) <= tolerance
    return len(points) - 1 - np.argmax(near[:, ::-1], axis=1)


@answers("14.1")
def numbered_anew(points, tolerance):
    """The places were numbered anew, without gaps. Asked for is the number that the first vertex
    in a place has already, so that triangles can go on to use the same list of points.
    """
    first = np.argmax(distances(points) <= tolerance, axis=1)
    return np.unique(first, return_inverse=True)[1]


@answers("14.1")
def whether_it_is_a_copy(points, tolerance):
    """This says whether there is an earlier vertex in the same place. Asked for is which one."""
    return np.argmax(distances(points) <= tolerance, axis=1) < np.arange(len(points))


# 14.2 Counts


@answers("14.2")
def by_direction(triangles):
    """Sides were taken for different if they run in opposite directions. Two neighbours that are
    rightly oriented do exactly that, so every edge of a good surface seems to be a boundary. An
    edge has no direction.
    """
    return counted(triangles, sides(triangles))


@answers("14.2")
def neighbours_only(triangles):
    """These are the *other* triangles at each edge, one too few. A side at the boundary has an
    edge of one triangle: its own.
    """
    return at_sides(triangles) - 1


@answers("14.2")
def opposite_side_first(triangles):
    """The numbers are right and belong to other sides: of a triangle's three the first should be
    that of the side from its first vertex to the second. `sides` has them in this order.
    """
    return np.roll(at_sides(triangles).reshape(-1, 3), -1, axis=1).ravel()


@answers("14.2")
def triangles_at_vertices(triangles):
    """This counts the triangles at each vertex. An edge has two ends, and only triangles with
    both of them have it.
    """
    return np.bincount(triangles.ravel())[triangles].ravel()


@answers("14.2")
def whether_on_the_boundary(triangles):
    """This says which sides are on the boundary. Asked for is the number of triangles: with more
    than two of them an edge is wrong in another way.
    """
    return at_sides(triangles) == 1


@answers("14.2")
def ends_summed(triangles):
    """Different edges got the same key, as with the sum of both ends: 1 and 4 make the same as 2
    and 3. Compare both ends, sorted.
    """
    key = sides(triangles).sum(axis=1)
    return np.bincount(key)[key]


# 14.3 Euler


def edges_of(triangles):
    return np.unique(np.sort(sides(triangles), axis=1), axis=0)


@answers("14.3")
def unused_vertices_counted(triangles):
    """The vertices were taken from the largest number in the list. A file may hold points that no
    triangle has, and they are no part of the surface.
    """
    return triangles.max() + 1 - len(edges_of(triangles)) + len(triangles)


@answers("14.3")
def all_sides_counted(triangles):
    """Three edges were counted for each triangle. Neighbours share one: each edge counts once,
    not once for each of its triangles.
    """
    return len(np.unique(triangles)) - 3 * len(triangles) + len(triangles)


@answers("14.3")
def as_if_it_were_closed(triangles):
    """The number of edges was taken to be three halves of that of the triangles. That holds where
    every edge has two of them, and is not even a whole number elsewhere.
    """
    return len(np.unique(triangles)) - 1.5 * len(triangles) + len(triangles)


@answers("14.3")
def directions_told_apart(triangles):
    """An edge was counted once for each direction in which it is run through. Sort its ends
    before you compare.
    """
    runs = np.unique(sides(triangles), axis=0)
    return len(np.unique(triangles)) - len(runs) + len(triangles)


@answers("14.3")
def handles(triangles):
    """This is the number of handles that a closed surface in one piece would have. Asked for is χ
    itself, which means something for every list of triangles.
    """
    chi = len(np.unique(triangles)) - len(edges_of(triangles)) + len(triangles)
    return (2 - chi) / 2


@answers("14.3")
def signs_exchanged(triangles):
    """The signs do not alternate as in (14.2): points plus, lines minus, areas plus. Try it on
    one triangle, which has three, three and one.
    """
    return len(np.unique(triangles)) + len(edges_of(triangles)) - len(triangles)


# 14.4 Loops


def looped(n, free):
    label = parts(n, free)
    label[~np.isin(np.arange(n), free)] = -1
    return label


@answers("14.4")
def sides_run_alike(n, triangles):
    """A side was taken for free if no other runs the opposite way. Where one triangle is turned
    over, its neighbours seem to have no partner, and loops appear inside of the surface. Boundary
    is a matter of edges, not of direction.
    """
    s = sides(triangles)
    runs = set(map(tuple, s.tolist()))
    return looped(n, np.array([e for e in s.tolist() if (e[1], e[0]) not in runs]))


@answers("14.4")
def inner_vertices_named(n, triangles):
    """Vertices off the boundary kept a name, their own. They are on no loop, which is to be -1:
    `connected` takes a thing without links for a part of its own.
    """
    return parts(n, sides(triangles)[at_sides(triangles) == 1])


@answers("14.4")
def loops_of_the_whole_surface(n, triangles):
    """Boundary vertices were joined through all edges of the surface, so that all loops of one
    part have the same name. Round a hole lead only the edges of the boundary.
    """
    label = parts(n, sides(triangles))
    label[~np.isin(np.arange(n), sides(triangles)[at_sides(triangles) == 1])] = -1
    return label


@answers("14.4")
def edges_between_boundary_vertices(n, triangles):
    """Edges were followed because both of their ends are on the boundary. An inner edge may be so
    too, straight across a narrow strip, and joins two loops into one. Which edges have one
    triangle?
    """
    on = np.isin(np.arange(n), sides(triangles)[at_sides(triangles) == 1])
    s = sides(triangles)
    label = parts(n, s[on[s].all(axis=1)])
    label[~on] = -1
    return label


@answers("14.4")
def edges_of_two_triangles(n, triangles):
    """These are the edges with two triangles, the inner ones. The boundary has one."""
    return looped(n, sides(triangles)[at_sides(triangles) == 2])


@answers("14.4")
def only_on_the_boundary_or_not(n, triangles):
    """This says of each vertex whether it is on a boundary. Asked for is on which loop, by the
    name of its least vertex.
    """
    return np.where(looped(n, sides(triangles)[at_sides(triangles) == 1]) >= 0, 1, -1)


@answers("14.4")
def loops_numbered(n, triangles):
    """The loops were numbered 0, 1, 2 and so on. Asked for is another name, which does not depend
    on the order in which they are found: the least of the vertices of the loop.
    """
    label = looped(n, sides(triangles)[at_sides(triangles) == 1])
    return np.searchsorted(np.unique(label[label >= 0]), label) - (label < 0)


# 14.5 Fans


def rims(n, triangles):
    for v in range(n):
        here = triangles[(triangles == v).any(axis=1)]
        yield here, here[here != v].reshape(-1, 2)


@answers("14.5")
def edges_less_triangles(n, triangles):
    """Edges less triangles at a vertex is the number of *open* fans. One that goes all the way
    round has as many edges as triangles, and was not counted.
    """
    return np.array([len(np.unique(rim)) - len(here) for here, rim in rims(n, triangles)])


@answers("14.5")
def triangles_at_the_vertex(n, triangles):
    """These are the triangles at each vertex. A fan is a set of them that hang together."""
    return np.bincount(triangles.ravel(), minlength=n)


@answers("14.5")
def parts_of_the_whole(n, triangles):
    """Triangles were taken to be of one fan if there is any way between them on the surface. The
    way has to stay at the vertex: two vertices of one sphere, made one, have two fans and a
    surface in one piece.
    """
    count = []
    for v in range(n):
        rest = triangles[~(triangles == v).any(axis=1)]
        label = parts(n, np.vstack([sides(rest), *[r for _, r in [_rim(v, triangles)]]]))
        count.append(len(np.unique(label[_rim(v, triangles)[1]])))
    return np.array(count)


def _rim(v, triangles):
    here = triangles[(triangles == v).any(axis=1)]
    return here, here[here != v].reshape(-1, 2)


@answers("14.5")
def joined_by_the_vertex(n, triangles):
    """Triangles count as connected because they share a vertex. But all of those at v share v: so
    there can be only one fan. They must share an edge that ends there.
    """
    return np.isin(np.arange(n), triangles)


@answers("14.5")
def isolated_vertices_have_one(n, triangles):
    """A vertex that no triangle has got one fan. It has none: such points are in the list and not
    in the surface.
    """
    counts = [len(np.unique(parts(n, rim)[rim])) for _, rim in rims(n, triangles)]
    return np.maximum(counts, 1)


@answers("14.5")
def vertices_without_links_counted(n, triangles):
    """All parts were counted that `connected` returns, and most of them are single vertices that
    have nothing to do with v. Look only at those on the rim.
    """
    return np.array([len(np.unique(parts(n, rim))) for _, rim in rims(n, triangles)])


@answers("14.5")
def whether_it_is_a_bow_tie(n, triangles):
    """This says which vertices have more than one fan. Asked for is the number of fans, which
    also tells a vertex without triangles from a good one.
    """
    return np.array([len(np.unique(parts(n, rim)[rim])) > 1 for _, rim in rims(n, triangles)])


# 14.6 Orientation


def walk(triangles, disagree):
    m = len(triangles)
    ends = [[tuple(e) for e in s] for s in sides(triangles).reshape(-1, 3, 2).tolist()]
    at = {}
    for t in range(m):
        for a, b in ends[t]:
            at.setdefault((min(a, b), max(a, b)), []).append((t, (a, b)))
    sign = np.zeros(m)
    for start in range(m):
        if sign[start]:
            continue
        sign[start], queue = 1, [start]
        part, bad = [start], False
        while queue:
            t = queue.pop()
            for a, b in ends[t]:
                for s, run in at[min(a, b), max(a, b)]:
                    if s != t:
                        wanted = sign[t] * (-1 if disagree(t, s, run == (a, b)) else 1)
                        bad = bad or sign[s] * wanted < 0
                        if not sign[s]:
                            sign[s] = wanted
                            queue.append(s)
                            part.append(s)
        yield part, sign[part].copy(), bad


def normals(points, triangles):
    a, b, c = points[triangles].swapaxes(0, 1)
    return np.cross(b - a, c - a)


def assembled(m, found, one_sided=0.0):
    result = np.zeros(m)
    for part, signs, bad in found:
        result[part] = one_sided * signs if bad else signs
    return result


@answers("14.6")
def normals_of_neighbours(points, triangles):
    """Neighbours were taken to agree if their normals point in similar directions. Across a sharp
    fold those of a well oriented surface point apart. The order of the vertices decides, and the
    places of the points do not matter.
    """
    n = normals(points, triangles)
    return assembled(len(triangles), walk(triangles, lambda t, s, alike: n[t] @ n[s] < 0))


@answers("14.6")
def away_from_the_middle(points, triangles):
    """Triangles were turned so that they look away from the middle of all points. That works for
    convex bodies: on the inner side of a torus the outside is towards the middle, and a sheet has
    no outside.
    """
    middle = points.mean(axis=0)
    out = np.einsum("ij,ij->i", normals(points, triangles), points[triangles].mean(axis=1) - middle)
    return np.where(out < 0, -1, 1)


@answers("14.6")
def same_direction_agrees(points, triangles):
    """Neighbours were taken to agree if they run along their edge in the same direction. It is
    the other way round: draw two triangles, both of which run to the left, and follow their
    common edge.
    """
    return assembled(len(triangles), walk(triangles, lambda t, s, alike: not alike))


@answers("14.6")
def one_sided_not_noticed(points, triangles):
    """The strip of Möbius got signs as if it could be oriented. A walk comes back to its first
    triangle with the other sign: look at triangles that have a sign already, too.
    """
    return assembled(len(triangles), walk(triangles, lambda t, s, alike: alike), 1.0)


@answers("14.6")
def first_part_only(points, triangles):
    """Only the part of the first triangle has signs. What is not connected to it must be begun
    anew, with a sign of its own.
    """
    found = list(walk(triangles, lambda t, s, alike: alike))
    return assembled(len(triangles), found[:1])


@answers("14.6")
def all_zero_if_one_part_is(points, triangles):
    """One part with a single side made all others zero. Each part is judged by itself: the sphere
    beside the strip of Möbius can be oriented.
    """
    found = list(walk(triangles, lambda t, s, alike: alike))
    return assembled(len(triangles), found) * (not any(bad for *_, bad in found))


@answers("14.6")
def against_the_first(points, triangles):
    """Each triangle was compared only with those before it, in the order of the list, and took
    its sign from the last that it met. A triangle may come before its neighbours have a final
    sign: go from neighbour to neighbour, or let `connected`.
    """
    sign = np.ones(len(triangles))
    seen = {}
    for t, three in enumerate(sides(triangles).reshape(-1, 3, 2).tolist()):
        for a, b in three:
            if (a, b) in seen:
                sign[t] = -sign[seen[a, b]]
            elif (b, a) in seen:
                sign[t] = sign[seen[b, a]]
        for a, b in three:
            seen[a, b] = t
    return sign


@answers("14.6")
def whether_a_neighbour_disagrees(points, triangles):
    """This marks the triangles that disagree with any of their neighbours. Of two that disagree
    it marks both, and only one has to be turned: start from one triangle, and let the others
    follow.
    """
    s = sides(triangles)
    return np.where((counted(triangles, s) > 1).reshape(-1, 3).any(axis=1), -1, 1)


# 14.7 Flat triangles


def lengths(points, triangles):
    a, b, c = points[triangles].swapaxes(0, 1)
    return np.linalg.norm([b - a, c - b, a - c], axis=2)


def twice_areas(points, triangles):
    return np.linalg.norm(normals(points, triangles), axis=1)


@answers("14.7")
def area_against_a_length(points, triangles, tolerance):
    """An area was compared with a tolerance that is a length. A small triangle of good shape
    seems to be flat then, and in other units the answer is another one. Which length of a
    triangle vanishes when it gets flat?
    """
    return twice_areas(points, triangles) / 2 <= tolerance


@answers("14.7")
def short_sides_only(points, triangles, tolerance):
    """This finds triangles with a short side. A cap has three long ones, with one corner on the
    opposite side, and is as flat.
    """
    return lengths(points, triangles).min(axis=0) <= tolerance


@answers("14.7")
def equal_names_only(points, triangles, tolerance):
    """This finds triangles that name a vertex twice. Corners with different names may be in one
    place, or on one line.
    """
    a, b, c = triangles.T
    return (a == b) | (b == c) | (c == a)


@answers("14.7")
def exactly_zero(points, triangles, tolerance):
    """Only areas that are exactly zero were found. Rounding leaves something of nearly every one:
    the least height is to be compared with the tolerance.
    """
    return twice_areas(points, triangles) == 0


@answers("14.7")
def the_greatest_height(points, triangles, tolerance):
    """The greatest height was compared, that over the shortest side. A needle has one height that
    is nearly as long as it is itself: the least one belongs to the longest side.
    """
    return twice_areas(points, triangles) <= tolerance * lengths(points, triangles).min(axis=0)


@answers("14.7")
def divided_by_zero(points, triangles, tolerance):
    """Triangles whose corners are all in one place were called good. Zero divided by zero is no
    number, and no number is less than anything. Multiply where you divide.
    """
    return twice_areas(points, triangles) / lengths(points, triangles).max(axis=0) <= tolerance


@answers("14.7")
def half_of_the_height(points, triangles, tolerance):
    """The area was divided by the longest side, which is half of the height: a factor of two is
    missing.
    """
    return twice_areas(points, triangles) / 2 <= tolerance * lengths(points, triangles).max(axis=0)


@answers("14.7")
def relative_to_the_size(points, triangles, tolerance):
    """The height was compared with a part of the size of the triangle: this is about shape. The
    tolerance is a length, by which points may be off, however large the triangle is.
    """
    return twice_areas(points, triangles) <= tolerance * lengths(points, triangles).max(axis=0) ** 2


# 14.8 Pierced


def side(a, b, c, d):
    return np.sign(np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a))


def sides_of_line(start, end, corners):
    a, b, c = corners.swapaxes(0, 1)
    return side(start, end, a, b), side(start, end, b, c), side(start, end, c, a)


def plane(start, end, corners):
    a, b, c = corners.swapaxes(0, 1)
    return side(a, b, c, start), side(a, b, c, end)


@answers("14.8")
def the_whole_straight_line(start, end, corners):
    """Only the second part of (14.5) was asked: whether the straight line through both points
    meets the triangle. It may do so beyond its ends.
    """
    one, two, three = sides_of_line(start, end, corners)
    return (one == two) & (two == three)


@answers("14.8")
def the_whole_plane(start, end, corners):
    """Only the first part of (14.5) was asked: whether the ends are on different sides of the
    plane. The plane goes on beyond the triangle.
    """
    p, q = plane(start, end, corners)
    return p * q < 0


@answers("14.8")
def from_one_side_only(start, end, corners):
    """Only lines that pass in one direction were found: all three signs had to be positive.
    Through the other side of a triangle they are all negative.
    """
    p, q = plane(start, end, corners)
    one, two, three = sides_of_line(start, end, corners)
    return (p * q < 0) & (one > 0) & (two > 0) & (three > 0)


@answers("14.8")
def two_sides_only(start, end, corners):
    """Only two of the three signs were compared: so the line may lie beyond the third side of the
    triangle.
    """
    p, q = plane(start, end, corners)
    one, two, _ = sides_of_line(start, end, corners)
    return (p * q < 0) & (one == two)


@answers("14.8")
def not_round_the_triangle(start, end, corners):
    """The three sides were not taken in the order round the triangle: with a to c in the place of
    c to a one of the signs is the wrong way round.
    """
    a, _, c = corners.swapaxes(0, 1)
    p, q = plane(start, end, corners)
    one, two, _ = sides_of_line(start, end, corners)
    return (p * q < 0) & (one == two) & (two == side(start, end, a, c))


@answers("14.8")
def both_on_one_side(start, end, corners):
    """The ends had to be on the same side of the plane. A line between such points does not reach
    it.
    """
    p, q = plane(start, end, corners)
    one, two, three = sides_of_line(start, end, corners)
    return (p == q) & (one == two) & (two == three)


@answers("14.8")
def middle_of_the_line(start, end, corners):
    """It was tested whether the middle between both ends lies over the triangle. The line meets
    the plane somewhere else, unless both are as far away from it.
    """
    a, b, c = corners.swapaxes(0, 1)
    n = np.cross(b - a, c - a)
    x = (start + end) / 2
    inside = [
        np.einsum("ij,ij->i", np.cross(f - e, x - e), n) > 0 for e, f in ((a, b), (b, c), (c, a))
    ]
    p, q = plane(start, end, corners)
    return (p * q < 0) & np.all(inside, axis=0)
