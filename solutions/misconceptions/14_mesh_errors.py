"""Mistakes in notebook 14, each with the sentence that the student reads."""

import numpy as np

from fieldgrade.authoring.catalogue import answers


def sides(triangles):
    return np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2).reshape(-1, 2)


def parts(n, links):
    """The first of all objects that are connected with each one."""
    links = np.reshape(links, (-1, 2)).astype(int)
    earlier = {i: i for i in links.ravel().tolist()}

    def first(i):
        while earlier[i] != i:
            i = earlier[i]
        return i

    for a, b in links.tolist():
        one, other = sorted((first(a), first(b)))
        earlier[other] = one
    label = np.arange(n)
    label[list(earlier)] = [first(i) for i in earlier]
    return label


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
    """The coordinates were rounded to multiples of the tolerance and then compared. Two close
    points on both sides of a rounding boundary are not merged. Compare distances.
    """
    steps = np.round(points / (tolerance or 1e-300)) if tolerance else points
    return np.array([int(np.argmax((steps == p).all(axis=1))) for p in steps])


@answers("14.1")
def exactly_equal_only(points, tolerance):
    """Only exactly equal points were merged: the tolerance was not used."""
    return np.array([int(np.argmax((points == p).all(axis=1))) for p in points])


@answers("14.1")
def each_coordinate_by_itself(points, tolerance):
    """Each coordinate was compared with the tolerance separately. (14.1) requires the distance,
    which may be larger by a factor of up to the square root of 3.
    """
    near = (np.abs(points[:, None] - points) <= tolerance).all(axis=2)
    return np.argmax(near, axis=1)


@answers("14.1")
def relative_tolerance(points, tolerance):
    """`isclose` and `allclose` add 1e-5 times the size of the numbers to the tolerance, unless
    another `rtol` is given. Far from the origin this merges different points.
    """
    near = np.isclose(points[:, None], points, atol=tolerance).all(axis=2)
    return np.argmax(near, axis=1)


@answers("14.1")
def nearer_than_the_tolerance(points, tolerance):
    """The distance was required to be less than the tolerance. In (14.1) it may be equal. With the
    tolerance 0, a point would not even be near itself.
    """
    return np.argmax(distances(points) < tolerance, axis=1)


@answers("14.1")
def last_in_its_place(points, tolerance):
    """Each vertex was replaced by the last one within the tolerance. (14.1) takes the first."""
    near = distances(points) <= tolerance
    return len(points) - 1 - np.argmax(near[:, ::-1], axis=1)


@answers("14.1")
def numbered_anew(points, tolerance):
    """The merged vertices were numbered again without gaps. (14.1) requires the old number of the
    first vertex.
    """
    first = np.argmax(distances(points) <= tolerance, axis=1)
    return np.unique(first, return_inverse=True)[1]


@answers("14.1")
def whether_it_is_a_copy(points, tolerance):
    """This says whether there is an earlier vertex within the tolerance. Return its number."""
    return np.argmax(distances(points) <= tolerance, axis=1) < np.arange(len(points))


@answers("14.1")
def sum_of_the_differences(points, tolerance):
    """The absolute differences of the coordinates were added. The distance in (14.1) is the square
    root of the sum of squares.
    """
    return np.argmax(np.abs(points[:, None] - points).sum(axis=2) <= tolerance, axis=1)


@answers("14.1")
def whole_chains(points, tolerance):
    """All points of a chain became one vertex, however long the chain is. (14.1) considers only
    points whose own distance is at most the tolerance.
    """
    return parts(len(points), np.argwhere(distances(points) <= tolerance))


@answers("14.1", named=False)
def vertex_of_the_vertex(points, tolerance):
    """The vertex that stands for another may itself stand for an earlier one."""
    first = np.argmax(distances(points) <= tolerance, axis=1)
    return first[first]


@answers("14.1", named=False)
def kept_vertices_only(points, tolerance):
    """Only vertices that stand for themselves are considered, not all earlier ones."""
    near, kept, found = distances(points) <= tolerance, [], []
    for i in range(len(points)):
        there = [j for j in kept if near[i, j]]
        found.append(there[0] if there else i)
        if not there:
            kept.append(i)
    return np.array(found)


@answers("14.1", named=False)
def tolerance_with_a_lower_bound(points, tolerance):
    """A tolerance below 10⁻⁹ must not be replaced by another one."""
    return np.argmax(distances(points) <= max(tolerance, 1e-9), axis=1)


# 14.2 Counts


@answers("14.2", named=False)
def key_for_a_hundred_vertices(triangles):
    """The key is not unique for vertices from 100 on."""
    ends = np.sort(sides(triangles))
    key = ends[:, 0] * 100 + ends[:, 1]
    _, which, count = np.unique(key, return_inverse=True, return_counts=True)
    return count[which]


@answers("14.2", named=False)
def key_for_a_thousand_vertices(triangles):
    """The key is not unique for vertices from 1000 on."""
    ends = np.sort(sides(triangles))
    key = ends[:, 0] * 1000 + ends[:, 1]
    _, which, count = np.unique(key, return_inverse=True, return_counts=True)
    return count[which]


@answers("14.2")
def by_direction(triangles):
    """Sides that run in opposite directions were counted as different edges. In an oriented surface
    all neighbours do this. An edge has no direction.
    """
    return counted(triangles, sides(triangles))


@answers("14.2")
def neighbours_only(triangles):
    """The numbers are too small by 1: the triangle itself was not counted."""
    return at_sides(triangles) - 1


@answers("14.2")
def opposite_side_first(triangles):
    """The numbers are right, but in another order. `sides` begins with the side from the first
    vertex to the second.
    """
    return np.roll(at_sides(triangles).reshape(-1, 3), -1, axis=1).ravel()


@answers("14.2")
def all_first_sides_first(triangles):
    """The numbers are right, but in another order. In `sides` the three sides of a triangle follow
    each other.
    """
    return at_sides(triangles).reshape(-1, 3).T.ravel()


@answers("14.2")
def triangles_at_vertices(triangles):
    """This counts the triangles at a vertex. An edge has two ends: count the triangles that have
    both.
    """
    return np.bincount(triangles.ravel())[triangles].ravel()


@answers("14.2")
def whether_on_the_boundary(triangles):
    """This says which sides belong to the boundary. Return the number of triangles."""
    return at_sides(triangles) == 1


@answers("14.2")
def ends_summed(triangles):
    """Different edges have the same key, the sum of their ends: 1 + 4 equals 2 + 3. Compare both
    ends, sorted.
    """
    key = sides(triangles).sum(axis=1)
    return np.bincount(key)[key]


@answers("14.2")
def different_triangles(triangles):
    """A triangle that is listed twice was counted once. Count the rows of the list."""
    corners = [frozenset(t) for t in triangles.tolist()]
    pairs = [frozenset(s) for s in sides(triangles).tolist()]
    return [len({t for t in corners if pair < t}) for pair in pairs]


# 14.3 Euler


def edges_of(triangles):
    return np.unique(np.sort(sides(triangles), axis=1), axis=0)


@answers("14.3")
def unused_vertices_counted(triangles):
    """The number of vertices was taken from the largest number in the list. The file may contain
    points that no triangle has, and they do not count.
    """
    return triangles.max() + 1 - len(edges_of(triangles)) + len(triangles)


@answers("14.3")
def all_sides_counted(triangles):
    """Three edges were counted for each triangle. An edge that two triangles share counts once."""
    return len(np.unique(triangles)) - 3 * len(triangles) + len(triangles)


@answers("14.3")
def as_if_it_were_closed(triangles):
    """The number of edges was taken as 3F/2. This holds only if every edge has exactly two
    triangles.
    """
    return len(np.unique(triangles)) - 1.5 * len(triangles) + len(triangles)


@answers("14.3")
def directions_told_apart(triangles):
    """Edges were counted once for each direction of their sides. Sort the two ends first."""
    runs = np.unique(sides(triangles), axis=0)
    return len(np.unique(triangles)) - len(runs) + len(triangles)


@answers("14.3")
def handles(triangles):
    """This is the number of handles, (2 − χ)/2. Return χ itself."""
    chi = len(np.unique(triangles)) - len(edges_of(triangles)) + len(triangles)
    return (2 - chi) / 2


@answers("14.3")
def signs_exchanged(triangles):
    """The signs in (14.2) are V − E + F. A single triangle has 3 vertices, 3 edges and χ = 1."""
    return len(np.unique(triangles)) + len(edges_of(triangles)) - len(triangles)


@answers("14.3", named=False)
def triangles_counted_once(triangles):
    """A triangle that is listed twice was counted once."""
    edges = np.unique(np.sort(sides(triangles)), axis=0)
    faces = np.unique(np.sort(triangles), axis=0)
    return len(np.unique(triangles)) - len(edges) + len(faces)


@answers("14.3", named=False)
def half_of_the_sides_of_many(triangles):
    """An edge of four triangles was counted twice."""
    count = counted(triangles, np.sort(sides(triangles)))
    edges = np.sum(count == 1) + np.sum(count >= 2) // 2
    return len(np.unique(triangles)) - edges + len(triangles)


# 14.4 Loops


def looped(n, free):
    label = parts(n, free)
    label[~np.isin(np.arange(n), free)] = -1
    return label


@answers("14.4")
def sides_run_alike(n, triangles):
    """A side was taken as boundary if no other side runs in the opposite direction. Near an
    inverted triangle this is wrong. A boundary edge is an edge with one triangle, whatever its
    direction.
    """
    s = sides(triangles)
    runs = set(map(tuple, s.tolist()))
    return looped(n, np.array([e for e in s.tolist() if (e[1], e[0]) not in runs]))


@answers("14.4")
def inner_vertices_named(n, triangles):
    """Vertices that are on no loop have a name, their own. They must have −1: `connected` regards
    an object without links as a component.
    """
    return parts(n, sides(triangles)[at_sides(triangles) == 1])


@answers("14.4")
def loops_of_the_whole_surface(n, triangles):
    """Boundary vertices were linked across all edges of the surface, so all loops of a component
    have the same name. Link them along boundary edges only.
    """
    label = parts(n, sides(triangles))
    label[~np.isin(np.arange(n), sides(triangles)[at_sides(triangles) == 1])] = -1
    return label


@answers("14.4")
def edges_between_boundary_vertices(n, triangles):
    """All edges between boundary vertices were used. Such an edge may be inside the surface and
    link two loops. A boundary edge has exactly one triangle.
    """
    on = np.isin(np.arange(n), sides(triangles)[at_sides(triangles) == 1])
    s = sides(triangles)
    label = parts(n, s[on[s].all(axis=1)])
    label[~on] = -1
    return label


@answers("14.4")
def edges_of_two_triangles(n, triangles):
    """The edges with two triangles were used. A boundary edge has exactly one triangle."""
    return looped(n, sides(triangles)[at_sides(triangles) == 2])


@answers("14.4")
def only_on_the_boundary_or_not(n, triangles):
    """This says which vertices are on a boundary. Return the smallest vertex of their loop."""
    return np.where(looped(n, sides(triangles)[at_sides(triangles) == 1]) >= 0, 1, -1)


@answers("14.4")
def loops_numbered(n, triangles):
    """The loops were numbered 0, 1, 2, … The name of a loop is its smallest vertex."""
    label = looped(n, sides(triangles)[at_sides(triangles) == 1])
    return np.searchsorted(np.unique(label[label >= 0]), label) - (label < 0)


def loops_of(n, triangles, boundary):
    free = sides(triangles)[boundary]
    loop = parts(n, free)
    loop[~np.isin(np.arange(n), free)] = -1
    return loop


@answers("14.4")
def edges_of_many_triangles_too(n, triangles):
    """Edges with three or more triangles were taken as boundary, too. A boundary edge has exactly
    one triangle.
    """
    return loops_of(n, triangles, counted(triangles, np.sort(sides(triangles))) != 2)


@answers("14.4", named=False)
def edges_of_an_odd_number_of_triangles(n, triangles):
    """Edges of three triangles were taken as boundary."""
    return loops_of(n, triangles, counted(triangles, np.sort(sides(triangles))) % 2 == 1)


# 14.5 Fans


def rims(n, triangles):
    for v in range(n):
        here = triangles[(triangles == v).any(axis=1)]
        yield here, here[here != v].reshape(-1, 2)


@answers("14.5")
def edges_less_triangles(n, triangles):
    """This is the number of edges minus the number of triangles at the vertex, which counts *open*
    fans only. A closed fan has as many edges as triangles.
    """
    return np.array([len(np.unique(rim)) - len(here) for here, rim in rims(n, triangles)])


@answers("14.5")
def triangles_at_the_vertex(n, triangles):
    """These are the numbers of triangles at each vertex. A fan is a set of triangles that are
    connected across edges at the vertex.
    """
    return np.bincount(triangles.ravel(), minlength=n)


@answers("14.5")
def parts_of_the_whole(n, triangles):
    """Two triangles were put into one fan if they are connected anywhere on the surface. They must
    be connected across edges that end at the vertex.
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
    """Each vertex with triangles has one fan here. Triangles that share only the vertex belong to
    different fans: they must share an edge.
    """
    return np.isin(np.arange(n), triangles)


@answers("14.5")
def isolated_vertices_have_one(n, triangles):
    """Vertices without triangles have one fan here. They must have none."""
    counts = [len(np.unique(parts(n, rim)[rim])) for _, rim in rims(n, triangles)]
    return np.maximum(counts, 1)


@answers("14.5")
def vertices_without_links_counted(n, triangles):
    """All components returned by `connected` were counted, also the objects without links. Count
    only those of the opposite sides.
    """
    return np.array([len(np.unique(parts(n, rim))) for _, rim in rims(n, triangles)])


@answers("14.5")
def whether_it_is_a_bow_tie(n, triangles):
    """This says which vertices have more than one fan. Return the number of fans."""
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
    """Neighbours were compared by their normals. Across a sharp fold the normals of an oriented
    surface may point apart. Only the order of the vertices matters.
    """
    n = normals(points, triangles)
    return assembled(len(triangles), walk(triangles, lambda t, s, alike: n[t] @ n[s] < 0))


@answers("14.6")
def away_from_the_middle(points, triangles):
    """The triangles were oriented away from the mean of all points. This works for convex bodies,
    but not for all others, and the first triangle of each part must stay.
    """
    middle = points.mean(axis=0)
    out = np.einsum("ij,ij->i", normals(points, triangles), points[triangles].mean(axis=1) - middle)
    return np.where(out < 0, -1, 1)


@answers("14.6")
def same_direction_agrees(points, triangles):
    """Neighbours were taken to agree if they run along their common edge in the same direction.
    They agree if the directions are opposite.
    """
    return assembled(len(triangles), walk(triangles, lambda t, s, alike: not alike))


@answers("14.6")
def one_sided_not_noticed(points, triangles):
    """The Möbius strip has signs here, as if it were orientable. A walk across its edges reaches a
    triangle that already has the other sign.
    """
    return assembled(len(triangles), walk(triangles, lambda t, s, alike: alike), 1.0)


@answers("14.6")
def first_part_only(points, triangles):
    """Only the part of the first triangle has signs. Each part needs a first triangle
    of its own.
    """
    found = list(walk(triangles, lambda t, s, alike: alike))
    return assembled(len(triangles), found[:1])


@answers("14.6")
def other_parts_unchanged(points, triangles):
    """Only the part of the first triangle was treated, and all other signs remained +1. Each part
    needs a first triangle of its own.
    """
    found = list(walk(triangles, lambda t, s, alike: alike))
    result = assembled(len(triangles), found[:1])
    for part, *_ in found[1:]:
        result[list(part)] = 1
    return result


@answers("14.6")
def all_zero_if_one_part_is(points, triangles):
    """One part that is not orientable made all signs zero. Each part must be treated
    separately.
    """
    found = list(walk(triangles, lambda t, s, alike: alike))
    return assembled(len(triangles), found) * (not any(bad for *_, bad in found))


@answers("14.6")
def parts_joined_at_vertices(points, triangles):
    """Triangles that share only a vertex were taken as one part: a part that is not orientable made
    a part that it touches zero. A part is connected across edges.
    """
    part = parts(len(points), sides(triangles))[triangles[:, 0]]
    found = list(walk(triangles, lambda t, s, alike: alike))
    one_sided = [part[t] for triangles_of_it, _, bad in found if bad for t in triangles_of_it]
    return assembled(len(triangles), found) * ~np.isin(part, one_sided)


@answers("14.6")
def against_the_first(points, triangles):
    """Each triangle was compared only with earlier triangles of the list. The sign of an earlier
    triangle may not be final yet: go from neighbour to neighbour, or use `connected`.
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
    """All triangles that disagree with a neighbour were marked. If two neighbours disagree, only
    one of them must be inverted.
    """
    s = sides(triangles)
    return np.where((counted(triangles, s) > 1).reshape(-1, 3).any(axis=1), -1, 1)


@answers("14.6")
def last_triangle_stays(points, triangles):
    """Neighbours agree, but in some parts the triangle that stays is not the first one of the list.
    By 14.6 the first triangle of each part must have the sign +1.
    """
    found = [
        (part, signs * signs[np.argmax(part)], bad)
        for part, signs, bad in walk(triangles, lambda t, s, alike: alike)
    ]
    return assembled(len(triangles), found)


@answers("14.6", named=False)
def most_triangles_stay(points, triangles):
    """The first triangle of a part must stay, even if most others are inverted then."""
    found = [
        (part, signs * (1 if signs.sum() >= 0 else -1), bad)
        for part, signs, bad in walk(triangles, lambda t, s, alike: alike)
    ]
    return assembled(len(triangles), found)


@answers("14.6", named=False)
def fifty_rounds(points, triangles):
    """Signs were passed on fifty times only, which is too few for a long strip."""
    ends = sides(triangles)
    same = (np.sort(ends)[:, None] == np.sort(ends)).all(axis=2)
    alike = (ends[:, None] == ends).all(axis=2)
    one, two = np.nonzero(same & ~np.eye(len(ends), dtype=bool))
    relation = np.where(alike[one, two], -1, 1)
    first, sign = np.arange(len(triangles)), np.ones(len(triangles))
    for _ in range(50):
        for s, t, r in zip(one // 3, two // 3, relation):
            if first[s] < first[t]:
                first[t], sign[t] = first[s], r * sign[s]
    disagree = sign[one // 3] * sign[two // 3] != relation
    return np.where(np.isin(first, first[one[disagree] // 3]), 0, sign)


# 14.7 Flat triangles


def lengths(points, triangles):
    a, b, c = points[triangles].swapaxes(0, 1)
    return np.linalg.norm([b - a, c - b, a - c], axis=2)


def twice_areas(points, triangles):
    return np.linalg.norm(normals(points, triangles), axis=1)


@answers("14.7")
def area_against_a_length(points, triangles, tolerance):
    """An area was compared with the tolerance, which is a length. Then small triangles of good
    shape are called flat. (14.3) compares a height.
    """
    return twice_areas(points, triangles) / 2 <= tolerance


@answers("14.7")
def short_sides_only(points, triangles, tolerance):
    """Triangles with a short side were found. A cap has three long sides and is flat as well."""
    return lengths(points, triangles).min(axis=0) <= tolerance


@answers("14.7")
def equal_names_only(points, triangles, tolerance):
    """Triangles that name a vertex twice were found. Corners with different numbers may also be at
    the same point, or on one line.
    """
    a, b, c = triangles.T
    return (a == b) | (b == c) | (c == a)


@answers("14.7")
def exactly_zero(points, triangles, tolerance):
    """Only triangles with area exactly zero were found. (14.3) compares the smallest height with
    the tolerance.
    """
    return twice_areas(points, triangles) == 0


@answers("14.7")
def the_greatest_height(points, triangles, tolerance):
    """The largest height was compared, that over the shortest side. The smallest height is that
    over the longest side.
    """
    return twice_areas(points, triangles) <= tolerance * lengths(points, triangles).min(axis=0)


@answers("14.7")
def divided_by_zero(points, triangles, tolerance):
    """Triangles whose corners are all at one point are not flat here. Their height is 0, which is
    at most τ. Is the comparison strict, or is zero divided by zero?
    """
    return twice_areas(points, triangles) / lengths(points, triangles).max(axis=0) <= tolerance


@answers("14.7", named=False)
def strictly_less(points, triangles, tolerance):
    """A height of zero is at most a tolerance of zero, and a strict comparison denies it."""
    return twice_areas(points, triangles) < tolerance * lengths(points, triangles).max(axis=0)


@answers("14.7", named=False)
def against_the_perimeter(points, triangles, tolerance):
    """The perimeter is more than twice the longest side."""
    return twice_areas(points, triangles) <= tolerance * lengths(points, triangles).sum(axis=0)


@answers("14.7", named=False)
def against_one_fixed_side(points, triangles, tolerance):
    """The smallest height is that over the longest side, which may be another one."""
    return twice_areas(points, triangles) <= tolerance * lengths(points, triangles)[1]


@answers("14.7")
def half_of_the_height(points, triangles, tolerance):
    """The values are those of half the height: the area was divided by the longest side. (14.3) has
    2A.
    """
    return twice_areas(points, triangles) / 2 <= tolerance * lengths(points, triangles).max(axis=0)


@answers("14.7")
def relative_to_the_size(points, triangles, tolerance):
    """The height was compared with τ times the longest side, a relative tolerance. In (14.3) τ is a
    length.
    """
    return twice_areas(points, triangles) <= tolerance * lengths(points, triangles).max(axis=0) ** 2


@answers("14.7", named=False)
def small_number_added_to_the_tolerance(points, triangles, tolerance):
    """The result must not depend on the unit of length."""
    longest = lengths(points, triangles).max(axis=0)
    return twice_areas(points, triangles) / (longest + 1e-12) <= tolerance + 1e-9


@answers("14.7", named=False)
def area_against_a_square(points, triangles, tolerance):
    """The area was compared with the square of the tolerance."""
    return twice_areas(points, triangles) / 2 <= tolerance**2


@answers("14.7", named=False)
def perimeter_for_longest_side(points, triangles, tolerance):
    """The perimeter was used in place of the longest side."""
    return twice_areas(points, triangles) <= tolerance * lengths(points, triangles).sum(axis=0)


@answers("14.7", named=False)
def first_side_for_longest_side(points, triangles, tolerance):
    """One side was used in place of the longest side."""
    return twice_areas(points, triangles) <= tolerance * lengths(points, triangles)[0]


@answers("14.7", named=False)
def second_side_for_longest_side(points, triangles, tolerance):
    """One side was used in place of the longest side."""
    return twice_areas(points, triangles) <= tolerance * lengths(points, triangles)[1]


@answers("14.7", named=False)
def longest_of_two_sides(points, triangles, tolerance):
    """Two sides were compared, and the third side may be the longest one."""
    longest = lengths(points, triangles)[:2].max(axis=0)
    return twice_areas(points, triangles) <= tolerance * longest


@answers("14.7", named=False)
def longest_of_the_last_two_sides(points, triangles, tolerance):
    """Two sides were compared, and the first side may be the longest one."""
    longest = lengths(points, triangles)[1:].max(axis=0)
    return twice_areas(points, triangles) <= tolerance * longest


@answers("14.7", named=False)
def middle_side(points, triangles, tolerance):
    """The side of middle length was used in place of the longest side."""
    middle = np.sort(lengths(points, triangles), axis=0)[1]
    return twice_areas(points, triangles) <= tolerance * middle


@answers("14.7", named=False)
def areas_by_the_products_of_sides(points, triangles, tolerance):
    """In nearly flat triangles the two products agree, and their difference has no digits."""
    a, b, c = points[triangles.T].astype(float)
    u, v = b - a, c - a
    squares = np.sum(u * u, axis=1) * np.sum(v * v, axis=1) - np.sum(u * v, axis=1) ** 2
    longest = lengths(points, triangles).max(axis=0)
    return np.maximum(squares, 0) <= (tolerance * longest) ** 2


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
    """Only the second condition of (14.5) was tested. It holds if the straight line through both
    points passes through the triangle, even if the segment ends before the triangle.
    """
    one, two, three = sides_of_line(start, end, corners)
    return (one == two) & (two == three)


@answers("14.8")
def the_whole_plane(start, end, corners):
    """Only the first condition of (14.5) was tested. It holds for every segment that crosses the
    plane of the triangle, even if it crosses this plane outside the triangle.
    """
    p, q = plane(start, end, corners)
    return p * q < 0


@answers("14.8")
def signs_multiplied(start, end, corners):
    """For very small pairs the product of two numbers (14.4) is rounded to zero, and does not count
    as negative. Compare the signs of the two numbers.
    """
    a, b, c = corners.swapaxes(0, 1)
    across = np.cross(b - a, c - a)
    p, q = (np.sum(across * (x - a), axis=1) for x in (start, end))
    one, two, three = sides_of_line(start, end, corners)
    return (p * q < 0) & (one == two) & (two == three)


@answers("14.8", named=False)
def determinants_of_absolute_coordinates(start, end, corners):
    """Rounding errors of the determinants decide where a segment ends in the plane."""
    a, b, c = corners.swapaxes(0, 1)

    def side(*four):
        rows = [np.insert(np.asarray(p, dtype=float), 3, 1, axis=1) for p in four]
        return np.sign(np.linalg.det(np.stack(rows, axis=1)))

    signs = [side(start, end, *two) for two in ((a, b), (b, c), (c, a))]
    across = side(a, b, c, start) * side(a, b, c, end) < 0
    return across & (signs[0] == signs[1]) & (signs[1] == signs[2])


@answers("14.8", named=False)
def products_of_absolute_coordinates(start, end, corners):
    """Far from the origin the digits of the difference are lost, and points in the plane count as
    beside it.
    """
    a, b, c = corners.swapaxes(0, 1)

    def side(a, b, c, x):
        n = np.cross(b - a, c - a)
        return np.sign(np.sum(n * x, axis=1) - np.sum(n * a, axis=1))

    signs = [side(start, end, *two) for two in ((a, b), (b, c), (c, a))]
    across = side(a, b, c, start) * side(a, b, c, end) < 0
    return across & (signs[0] == signs[1]) & (signs[1] == signs[2])


@answers("14.8")
def from_one_side_only(start, end, corners):
    """The three signs of the second condition of (14.5) were required to be positive. They are
    positive for one direction of the segment, and negative for the opposite direction.
    """
    p, q = plane(start, end, corners)
    one, two, three = sides_of_line(start, end, corners)
    return (p * q < 0) & (one > 0) & (two > 0) & (three > 0)


@answers("14.8")
def two_sides_only(start, end, corners):
    """Only two of the three signs in the second condition of (14.5) were compared. The segment may
    then cross the plane of the triangle beyond the third edge.
    """
    p, q = plane(start, end, corners)
    one, two, _ = sides_of_line(start, end, corners)
    return (p * q < 0) & (one == two)


@answers("14.8")
def not_round_the_triangle(start, end, corners):
    """The three edges do not follow each other around the triangle: the edge from a to c was used
    instead of the edge from c to a. This inverts one sign of the second condition of (14.5).
    """
    a, _, c = corners.swapaxes(0, 1)
    p, q = plane(start, end, corners)
    one, two, _ = sides_of_line(start, end, corners)
    return (p * q < 0) & (one == two) & (two == side(start, end, a, c))


@answers("14.8")
def both_on_one_side(start, end, corners):
    """The ends were required to be on the same side of the plane. They must be on
    different sides.
    """
    p, q = plane(start, end, corners)
    one, two, three = sides_of_line(start, end, corners)
    return (p == q) & (one == two) & (two == three)


@answers("14.8")
def middle_of_the_line(start, end, corners):
    """The midpoint of the segment was tested. The segment meets the plane at another point, unless
    both ends are equally far away.
    """
    a, b, c = corners.swapaxes(0, 1)
    n = np.cross(b - a, c - a)
    x = (start + end) / 2
    inside = [
        np.einsum("ij,ij->i", np.cross(f - e, x - e), n) > 0 for e, f in ((a, b), (b, c), (c, a))
    ]
    p, q = plane(start, end, corners)
    return (p * q < 0) & np.all(inside, axis=0)


@answers("14.8")
def sign_of_each_coordinate(start, end, corners):
    """The sign was taken of each coordinate of the cross product. The vector then has another
    direction and is no longer normal to the plane. In (14.4) the sign is taken last, of the scalar
    product.
    """

    def six_volumes(a, b, c, d):
        return np.sign((np.sign(np.cross(b - a, c - a)) * (d - a)).sum(axis=1))

    a, b, c = corners.swapaxes(0, 1)
    p, q = six_volumes(a, b, c, start), six_volumes(a, b, c, end)
    one, two = six_volumes(start, end, a, b), six_volumes(start, end, b, c)
    return (p == -q) & (p != 0) & (one == two) & (two == six_volumes(start, end, c, a))


@answers("14.8", named=False)
def opposite_or_both_zero(start, end, corners):
    """A segment in the plane of the triangle was called piercing."""
    p, q = plane(start, end, corners)
    one, two, three = sides_of_line(start, end, corners)
    return (p == -q) & (one == two) & (two == three)


@answers("14.8")
def ends_in_the_plane_too(start, end, corners):
    """Segments that end in the plane of the triangle were found, too. What does "≠ 0" in (14.5)
    exclude?
    """
    p, q = plane(start, end, corners)
    one, two, three = sides_of_line(start, end, corners)
    return (p * q <= 0) & (one == two) & (two == three)


@answers("14.8", named=False)
def signs_that_differ(start, end, corners):
    """A segment that ends in the plane of the triangle was called piercing."""
    p, q = plane(start, end, corners)
    one, two, three = sides_of_line(start, end, corners)
    return (p != q) & (one == two) & (two == three)


@answers("14.8", named=False)
def positive_or_not(start, end, corners):
    """Zero was treated as negative, so a segment that ends in the plane was called piercing."""
    p, q = (s > 0 for s in plane(start, end, corners))
    one, two, three = (s > 0 for s in sides_of_line(start, end, corners))
    return (p != q) & (one == two) & (two == three)
