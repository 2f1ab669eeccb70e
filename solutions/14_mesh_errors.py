# ---
# jupyter:
#   jupytext:
#     text_representation:
#       extension: .py
#       format_name: percent
#   kernelspec:
#     display_name: Python 3
#     language: python
#     name: python3
# ---

# %% [markdown]
# # The errors of a mesh
#
# A surface in a file is a list of points and a list of triangles. Nothing in the file says that the
# triangles make a surface. A picture will look right with triangles missing, doubled or turned
# over; a printer, or the computation of a volume, will fail. By the end of this notebook you find
# such errors, and you can say of each what it violates.
#
# Eight functions, most of them of three or four lines.

# %% tags=["setup"]
import numpy as np

from fieldcheck import (
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    PURPLE,
    Slider,
    check,
    data,
    draw,
    figure,
    progress,
    start_over,
)


def sides(triangles):
    """Return the two ends of each side, of shape (3M, 2), for triangles (M, 3).

    Row 3t + k is side k of triangle t; it runs from the k-th vertex of the triangle to the next.
    """
    return np.take(triangles, [0, 1, 1, 2, 2, 0], axis=1).reshape(3 * len(triangles), 2)


def connected(n, links):
    """Return for each of n things the least one of its part, of shape (n,).

    Links, two numbers each, tell which things hang together; a part is what links connect.
    """
    one, other = np.reshape(links, (-1, 2)).astype(int).T
    least = np.arange(n)
    while True:
        before = least.copy()
        np.minimum.at(least, one, before[other])
        np.minimum.at(least, other, before[one])
        least = least[least]
        if (least == before).all():
            return least


# %% [markdown]
# The next cell draws surfaces. Run it; you need not read it.

# %%
from fieldcheck.questions.q14_mesh_errors import (
    ball,
    band,
    book,
    flipped,
    fused,
    joined,
    ring,
    sheet,
    without,
)


def seen(points, turn=25, tilt=25):
    """Return points as they appear on paper, and as a third coordinate how near they are."""
    s, t = np.radians(turn), np.radians(tilt)
    x = np.cos(s) * points[:, 0] - np.sin(s) * points[:, 1]
    y = np.sin(s) * points[:, 0] + np.cos(s) * points[:, 1]
    return np.stack(
        [x, np.cos(t) * points[:, 2] + np.sin(t) * y, np.sin(t) * points[:, 2] - np.cos(t) * y],
        axis=1,
    )


def draw_surface(axes, points, triangles, lines=(), special=(), color=PURPLE):
    """Draw triangles and coloured lines, the far ones first.

    Triangles are pale from outside and dark from inside; special ones are coloured.
    """
    place, special = seen(points), set(special)
    depth = place[triangles, 2].mean(axis=1)
    things = [(d, "triangle", i, color) for i, d in enumerate(depth)]
    for pairs, shade in lines:
        pairs = np.reshape(pairs, (-1, 2)).astype(int)
        nearer = place[pairs, 2].mean(axis=1) + 0.12 * np.ptp(place[:, 2])
        things += [(d, "line", e, shade) for e, d in zip(pairs, nearer)]
    for k, (_, kind, which, shade) in enumerate(sorted(things, key=lambda thing: thing[0])):
        if kind == "line":
            axes.plot(*place[which, :2].T, color=shade, lw=2.5, solid_capstyle="round", zorder=k)
            continue
        a, b, c = place[triangles[which]]
        normal = np.cross(*(place[triangles[which, 1:]] - a))
        light = 0.75 + 0.25 * abs(normal[2]) / (np.linalg.norm(normal) or 1.0)
        fill = shade if which in special else str(light * (0.93 if normal[2] > 0 else 0.62))
        corners = np.stack([a, b, c], axis=1)[:2]
        axes.fill(*corners, facecolor=fill, edgecolor="0.4", lw=0.5, zorder=k)
    axes.set_aspect("equal")
    axes.set_axis_off()


def draw_rings(axes, points, vertices):
    """Draw rings round vertices."""
    axes.plot(
        *seen(points)[vertices, :2].T, "o", ms=10, mfc="none", mec=ORANGE, mew=2.5, zorder=9999
    )


def many(n, thing):
    """Return how many there are, in words."""
    return f"{n} {thing}" + "s" * (n != 1)


# %% [markdown]
# ## The problem in a picture
#
# Three files with a sphere in them. Pull: every part that hangs together in the *list* of triangles
# moves away from the middle.


# %%
@draw(pull=Slider(0, 1, 0.45, "pull"))
def three_files(pull):
    points, triangles = ball(5, 10)
    soup = points[triangles].reshape(-1, 3), np.arange(triangles.size).reshape(-1, 3)
    upper = points[triangles, 2].mean(axis=1) > 0.02
    seam = points.repeat(2, axis=0), 2 * triangles + upper[:, None]
    files = {"each point once": (points, triangles), "two lists of points": seam, "a soup": soup}
    with figure(6.6, 2.6) as page:
        for axes, (name, (p, t)) in zip(page.subplots(1, 3), files.items(), strict=True):
            part = connected(len(p), sides(t))[t[:, 0]]
            moved = p.copy()
            for k in np.unique(part):
                own = np.unique(t[part == k])
                moved[own] += pull * p[own].mean(axis=0)
            draw_surface(axes, moved, t)
            axes.set(
                xlim=(-1.75, 1.75),
                ylim=(-1.75, 1.75),
                title=f"{name}:\n{many(len(np.unique(part)), 'part')}",
            )
    return page


# %% [markdown]
# **What to look at.** Put the slider to zero: no eye can tell the three apart. The one on the right
# is what the most common format for printing, STL, holds: every triangle brings three points of its
# own along. In the middle, a seam that was never sewn: along it every point is in the list twice.
#
# ## One place, one vertex
#
# Let $\mathbf{p}_1, \dots, \mathbf{p}_N$ be the points, in space or in the plane. To *weld* is to
# let one vertex stand for all that are in the same place. The same means: no farther apart than a
# tolerance $\tau \ge 0$, since files round. Take the first one:
#
# $$ w_i = \min\{\, j : \lVert \mathbf{p}_j - \mathbf{p}_i \rVert \le \tau \,\} . \tag{14.1} $$
#
# ### 14.1 Weld
#
# Return $w_i$ for each vertex. Python counts from 0: a vertex that has no earlier one in its place
# stands for itself.
#
# <details><summary>Hint</summary>
#
# `points[:, None] - points` holds all differences. Of an array of True and False, `np.argmax` finds
# the first True: along which axis?
#
# </details>


# %% question="14.1"
def weld(points, tolerance):
    """Return w of (14.1), whole numbers of shape (N,), for points (N, D) and a tolerance ≥ 0."""
    # BEGIN SOLUTION
    distance = np.linalg.norm(points[:, np.newaxis] - points, axis=2)
    return np.array([np.argmax(gaps <= tolerance) for gaps in distance])
    # END SOLUTION


# %%
check("14.1")

# %% [markdown]
# From now on a surface is a list of triangles: each a row of three numbers of vertices.
# `sides(triangles)` is written for you. It has the shape $(3M, 2)$: three sides of each triangle,
# one after the other, and of each side both ends, in the direction in which the triangle runs.
#
# ## How many triangles at an edge?
#
# Sides with the same two ends are one *edge*, whichever way they run. Count for each edge the
# triangles that have it:
#
# - **one**: the edge is at the *boundary*, the rim of the surface or of a hole;
# - **two**: so should it be inside of a surface;
# - **three or more**: here the surface branches. It is *not a manifold*.
#
# ### 14.2 Count
#
# Return, for each row of `sides(triangles)`, how many triangles have its edge.
#
# <details><summary>Hint</summary>
#
# Make the two ends comparable first: sort them. Then `np.unique` with `axis=0` finds the different
# edges, and can return how often each occurs, and which of them every row is.
#
# </details>


# %% question="14.2"
def triangles_at_sides(triangles):
    """Return how many triangles have the edge of each side, (3M,), for triangles (M, 3)."""
    # BEGIN SOLUTION
    ends = np.sort(sides(triangles))
    _, which, count = np.unique(ends, axis=0, return_inverse=True, return_counts=True)
    return count[which]
    # END SOLUTION


# %%
check("14.2")


# %%
@draw()
def edges_in_colour():
    points, triangles = ball(4, 8)
    tip = 1.6 * points[6] + [0, 0, 0.6]
    fin = np.vstack([points, [tip]]), np.vstack([triangles, [[6, 7, 34]]])
    angle = np.radians(65 + np.linspace(-75, 75, 5))
    ends = np.stack([np.cos(angle), np.sin(angle), [0.3, 0.9, 1.3, 0.9, 0.3]], axis=1)
    pages = np.vstack([[[0, 0, 0], [0, 0, 1]], ends]), book(5)[1]
    surfaces = {
        "a sphere": ball(4, 8),
        "two holes": without(ball(4, 8), 10, 11, 40, 41, 43),
        "a fin": fin,
        "five pages": pages,
    }
    with figure(6.6, 2.0) as page:
        for axes, (name, (p, t)) in zip(page.subplots(1, 4), surfaces.items(), strict=True):
            s, count = sides(t), np.asarray(triangles_at_sides(t))
            draw_surface(axes, p, t, [(s[count == 1], BLUE), (s[count > 2], ORANGE)])
            axes.set(title=name)
    return page


# %% [markdown]
# **What to look at.** Blue edges have one triangle, orange ones more than two. The fin has an
# orange edge with a blue boundary beside it: the two ideas are independent. Seen from inside a
# surface is dark.
#
# ## Euler's count
#
# Let $V$ be the number of vertices *that triangles have*, $E$ that of the edges, $F$ that of the
# triangles. Then
#
# $$ \chi = V - E + F \tag{14.2} $$
#
# does not change when triangles are cut into smaller ones: it is a property of the surface,
# its *Euler characteristic*. A closed surface in one piece, with two sides and $g$ handles, has
# $\chi = 2 - 2g$; every hole that is cut into it takes one away; and of several parts the
# characteristics add up.
#
# ### 14.3 Vertices minus edges plus triangles
#
# <details><summary>Hint</summary>
#
# A file may hold points that no triangle has. They are not vertices of the surface: look only into
# the list of triangles. Each edge counts once.
#
# </details>


# %% question="14.3"
def euler_characteristic(triangles):
    """Return χ of (14.2), a whole number, for triangles (M, 3)."""
    # BEGIN SOLUTION
    edges = np.unique(np.sort(sides(triangles)), axis=0)
    return len(np.unique(triangles)) - len(edges) + len(triangles)
    # END SOLUTION


# %%
check("14.3")

# %% [markdown]
# Now the soup of the first picture can be welded. Its points have been written with an error of
# $10^{-5}$ or so, as a file with few digits has. Which tolerance is right?


# %%
@draw(exponent=Slider(-7, 0, -3.5, "log τ", steps=42))
def welding(exponent):
    points, triangles = ball(4, 7)
    random = np.random.default_rng(14)
    soup = points[triangles].reshape(-1, 3)
    soup = soup + 1e-5 * random.uniform(-1, 1, soup.shape)
    own = np.arange(len(soup)).reshape(-1, 3)

    def welded(tolerance):
        t = weld(soup, tolerance)[own]
        return t[(t != np.roll(t, 1, axis=1)).all(axis=1)]

    exponents = np.linspace(-7, 0, 43)
    lists = [welded(10.0**e) for e in exponents]
    now = welded(10.0**exponent)
    with figure(6.6, 2.9) as page:
        left, right = page.subplots(1, 2, width_ratios=(2, 3))
        s, count = sides(now), np.asarray(triangles_at_sides(now) if len(now) else [])
        draw_surface(left, soup, now, [(s[count == 1], BLUE)])
        left.set(xlim=(-1.05, 1.05), ylim=(-1.1, 1.1))
        right.plot(exponents, [len(np.unique(t)) for t in lists], color=BLUE, label="vertices")
        right.plot(
            exponents,
            [euler_characteristic(t) if len(t) else 0 for t in lists],
            "--",
            color=ORANGE,
            label="characteristic",
        )
        right.axvline(exponent, color=GREY, lw=1)
        right.axhline(2, color=GREY, lw=0.6)
        right.set(
            xlabel=r"$\log_{10}\,\tau$",
            title=f"τ = {10**exponent:.1g}: χ = {euler_characteristic(now) if len(now) else 0}",
            yscale="symlog",
        )
        right.set_yticks([0, 2, 10, 100], ["0", "2", "10", "100"])
        right.legend(loc="lower right")
    return page


# %% [markdown]
# **What to look at.** On the left, blue edges are open. Between the error of the file and the size
# of the triangles there is a wide range where the answer is the same, and χ is 2: a sphere. Below
# it there are cracks, above it the surface collapses.
#
# ## Round the holes
#
# Boundary edges that hang together make a *loop*: the rim of one hole. Let us call a loop by the
# least of its vertices.
#
# `connected(n, links)` is written for you. It finds what hangs together among $n$ things, given
# pairs of them, and returns for each thing the least one of its part.
#
# ### 14.4 Loops
#
# Return for each of $N$ vertices the name of the loop it is on, and $-1$ if it is on none. No two
# loops touch. But some triangles may be turned over: do not count on all sides to run the same way
# round.


# %% question="14.4"
def boundary_loops(n, triangles):
    """Return the least vertex on the loop of each vertex, or -1, of shape (n,), for triangles (M,
    3).
    """
    # BEGIN SOLUTION
    free = sides(triangles)[triangles_at_sides(triangles) == 1]
    loop = connected(n, free)
    loop[~np.isin(np.arange(n), free)] = -1
    return loop
    # END SOLUTION


# %%
check("14.4")

# %% [markdown]
# ## One fan at each vertex
#
# A surface can fail to be a manifold although every edge has two triangles. Let two tetrahedra
# touch in one vertex, and weld there: two cones, tip to tip, a *bow-tie*. Round an inner vertex of
# a manifold you come from any of its triangles to any other, across edges that end there. Such a
# set of triangles is a *fan*. A vertex should have one.
#
# ### 14.5 Fans
#
# Return how many fans each vertex has, 0 for a vertex without triangles.
#
# <details><summary>Hint 1</summary>
#
# A triangle $(v, a, b)$ at the vertex $v$ has opposite to $v$ the side from $a$ to $b$. Two
# triangles at $v$ have a common edge there if their opposite sides have a common end. So a fan
# hangs together along its rim.
#
# </details>
# <details><summary>Hint 2</summary>
#
# Vertex by vertex: choose the triangles that have it, and take from them the two other vertices, as
# links for `connected`. How many parts do *these* vertices make?
#
# </details>


# %% question="14.5"
def fans(n, triangles):
    """Return how many fans each vertex has, of shape (n,), for triangles (M, 3)."""
    # BEGIN SOLUTION
    count = np.zeros(n)
    for v in range(n):
        here = triangles[np.any(triangles == v, axis=1)]
        rim = here[here != v]
        count[v] = len(np.unique(connected(n, rim)[rim]))
    return count
    # END SOLUTION


# %%
check("14.5")


# %%
@draw()
def loops_and_fans():
    n = len(ball(3, 8)[0])
    double = joined(ball(3, 8), ball(3, 8))
    touching = np.vstack([double[0][:n], double[0][n:] - [5, 0, 2]])
    points, triangles = ball(6, 12)
    points = points * np.hypot(*points[:, :2].T)[:, None] ** [0, 0, 1.5]
    surfaces = {
        "three holes": without(ball(4, 9), 10, 11, 32, 33, 46, 47),
        "a sheet with a hole": without(sheet(4, 4), 10, 11),
        "tip to tip": fused((touching, double[1]), (n - 1, 2 * n - 2)),
        "poles made one": fused((points, triangles), (72, 73)),
    }
    with figure(6.6, 2.3) as page:
        for axes, (name, (p, t)) in zip(page.subplots(1, 4), surfaces.items(), strict=True):
            loop, bows = np.asarray(boundary_loops(len(p), t)), np.asarray(fans(len(p), t)) > 1
            s, count = sides(t), np.asarray(triangles_at_sides(t))
            names = np.unique(loop[loop >= 0])
            rims = [s[(count == 1) & (loop[s[:, 0]] == one)] for one in names]
            draw_surface(axes, p, t, zip(rims, (BLUE, PURPLE, GREEN)))
            draw_rings(axes, p, np.flatnonzero(bows))
            told = f"{many(len(names), 'loop')}, {many(int(bows.sum()), 'bow-tie')}"
            axes.set_title(f"{name}:\n{told}", fontsize=9)
    return page


# %% [markdown]
# **What to look at.** Each loop has its colour; a ring marks a vertex with more than one fan. In
# both pictures on the right every edge has two triangles, and neither surface is a manifold. With
# the pages of a book, further up, it is the other way round: no bow-tie, and an edge of many
# triangles. Both have to be looked for.
#
# ## The same way round
#
# A triangle runs round its border in the order of its vertices, and seen from where it runs to the
# left, you look at its outer side. Two neighbours agree if they run along their common edge
# in *opposite* directions. If they run along it in the same direction, one of them has to be turned
# over. A surface is *oriented* if all neighbours agree, and *orientable* if triangles can be turned
# so that they do.
#
# ### 14.6 Turn them over
#
# Return for each triangle $+1$ if it stays, $-1$ if it has to be turned over, so that all
# neighbours agree. The first triangle of each part stays. Some parts can not be oriented however
# you turn: return 0 for all triangles of such a part. No edge has more than two triangles. You get
# the points as well. Do you need them?
#
# <details><summary>Hint 1</summary>
#
# Go from triangle to triangle, across edges: a neighbour that disagrees gets the opposite sign. If
# you come to a triangle that has a sign already, and the other one, the part has one side.
#
# </details>
# <details><summary>Hint 2, without a walk</summary>
#
# Take $2M$ things: triangle $t$ as it is, number $t$, and turned over, number $M + t$. Link what
# fits together: two neighbours as they are, if they agree, and both turned over as well. What fits
# if they do not? `connected` then finds the least of each part. What does it mean if $t$ and $M+t$
# are in one part? And otherwise, which of the two is in the part of the first triangle?
#
# </details>


# %% question="14.6"
def turns(points, triangles):
    """Return +1, -1 or 0 for each triangle, of shape (M,), for points (N, 3), triangles (M, 3)."""
    # BEGIN SOLUTION
    m = len(triangles)
    links, first = [], {}
    for i, (a, b) in enumerate(sides(triangles)):
        t = i // 3
        if (b, a) in first:
            s = first[b, a]
            links += [(s, t), (m + s, m + t)]
        if (a, b) in first:
            s = first[a, b]
            links += [(s, m + t), (m + s, t)]
        first[a, b] = t
    least = connected(2 * m, links)
    return np.sign(least[m:] - least[:m])
    # END SOLUTION


# %%
check("14.6")


# %%
@draw()
def your_sphere():
    points, triangles = data("14.6")
    turn = np.asarray(turns(points, triangles))
    mended = np.where(turn[:, None] < 0, triangles[:, ::-1], triangles)
    with figure(4.4, 2.1) as page:
        left, right = page.subplots(1, 2)
        draw_surface(left, points, triangles)
        draw_surface(right, points, mended)
        left.set(title="your sphere, as listed")
        right.set(title=f"{many(int((turn < 0).sum()), 'triangle')} turned")
    return page


# %% [markdown]
# Was the result dark on your screen, not pale? Then the first triangle, which stays, was one of the
# wrong ones. Neighbours know nothing of inside and outside.
#
# Now twist a strip of paper, and close it to a ring. Some triangles are turned over, at random.


# %%
@draw(twists=Slider(0, 4, 1, "half turns", whole=True))
def strips(twists):
    points, triangles = flipped(np.random.default_rng(3), band(twists, 30), 0.3)
    turn = np.asarray(turns(points, triangles))
    loop = np.asarray(boundary_loops(len(points), triangles))
    mended = np.where(turn[:, None] < 0, triangles[:, ::-1], triangles)
    s, count = sides(triangles), np.asarray(triangles_at_sides(triangles))
    names = np.unique(loop[loop >= 0])
    rims = [s[(count == 1) & (loop[s[:, 0]] == one)] for one in names]
    with figure(6.6, 2.7) as page:
        left, right = page.subplots(1, 2)
        draw_surface(left, points, triangles)
        draw_surface(
            right, points, mended, zip(rims, (BLUE, PURPLE)), np.flatnonzero(turn == 0), "#e8d5a8"
        )
        left.set(title=f"{many(twists, 'half turn')}, as listed")
        right.set(
            title=f"{'turned' if turn.any() else 'no turning helps'}, {many(len(names), 'rim')}"
        )
    return page


# %% [markdown]
# **What to look at.** On the left, dark triangles are seen from inside. On the right your function
# has turned them. Even numbers of half turns have two sides, and two rims. After an odd number both
# are one. A flipped triangle is a mistake in the *list*, and is mended there; a single side is a
# property of the *surface*, and cannot be mended.
#
# ## Where the points are
#
# So far the places of the points have not mattered, but for welding. Two errors are geometry.
#
# A triangle without area has no normal. Files have not only those with two corners in one place
# (*needles*), but also those with a corner on the opposite side (*caps*), whose sides are all long.
# What makes a triangle *flat* is its least height:
#
# $$ h = \frac{2A}{\text{its longest side}} \le \tau . \tag{14.3} $$
#
# ### 14.7 Flat triangles
#
# Return whether each triangle is flat. Some have corners that are equal, by name or by place; they
# are flat too, and nothing may be divided by zero.


# %% question="14.7"
def flat(points, triangles, tolerance):
    """Return whether (14.3) holds for each triangle, of shape (M,), for points (N, 3)."""
    # BEGIN SOLUTION
    a, b, c = points[triangles.T]
    twice_area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    longest = np.linalg.norm([b - a, c - b, a - c], axis=2).max(axis=0)
    return twice_area <= tolerance * longest
    # END SOLUTION


# %%
check("14.7")

# %% [markdown]
# A surface is *embedded* if its triangles share nothing but the corners and edges that they have in
# common by name. If two triangles cross, an edge of one passes through the other, as a rule.
# Whether the line from $\mathbf{p}$ to $\mathbf{q}$ passes through the triangle $\mathbf{a},
# \mathbf{b}, \mathbf{c}$ is decided by signs of volumes alone. Let
#
# $$ [\mathbf{a}, \mathbf{b}, \mathbf{c}, \mathbf{x}] = \operatorname{sign} \big( (\mathbf{b} -
#    \mathbf{a}) \times (\mathbf{c} - \mathbf{a}) \big)^T (\mathbf{x} - \mathbf{a}), \tag{14.4} $$
#
# which says on which side of the plane of three points the fourth one lies; without the sign it is
# six times the volume of their tetrahedron. The line passes through the inside of the triangle if
#
# $$ [\mathbf{a}, \mathbf{b}, \mathbf{c}, \mathbf{p}] = -[\mathbf{a}, \mathbf{b}, \mathbf{c},
#    \mathbf{q}] \neq 0, \qquad
#    [\mathbf{p}, \mathbf{q}, \mathbf{a}, \mathbf{b}] = [\mathbf{p}, \mathbf{q}, \mathbf{b},
#    \mathbf{c}] = [\mathbf{p}, \mathbf{q}, \mathbf{c}, \mathbf{a}] . \tag{14.5} $$
#
# The first part: both ends are on different sides of the plane. The second: seen along the line, it
# lies to the same side of all three sides.
#
# ### 14.8 Pierced
#
# Return whether each of $K$ lines passes through its triangle. No line touches a side or a corner.
#
# <details><summary>Hint</summary>
#
# A function inside of your function, for (14.4), saves you from writing it five times. `np.cross`
# takes arrays $(K, 3)$, row by row.
#
# </details>


# %% question="14.8"
def pierced(start, end, corners):
    """Return whether (14.5) holds, of shape (K,), for start and end (K, 3), corners (K, 3, 3)."""

    # BEGIN SOLUTION
    def side(a, b, c, x):
        return np.sign(np.sum(np.cross(b - a, c - a) * (x - a), axis=1))

    a, b, c = corners.swapaxes(0, 1)
    one, two, three = side(start, end, a, b), side(start, end, b, c), side(start, end, c, a)
    across = side(a, b, c, start) != side(a, b, c, end)
    return across & (one == two) & (two == three)
    # END SOLUTION


# %%
check("14.8")

# %% [markdown]
# ## The whole audit
#
# All of your functions, on one sphere with one error. Choose the error, and turn the sphere; think
# first what the audit will say.


# %%
def with_error(k):
    """Return the name of an error, and a sphere that has it."""
    points, triangles = ball(5, 10)
    n, m = len(points), len(triangles)
    tip = 1.6 * points[6] + [0, 0, 0.6]
    two = joined((points, triangles), (0.6 * points, triangles))
    beside = np.vstack([points, two[0][n:] - [5, 0, 0] + [1.1, 0, 0.3]])
    touching = np.vstack([points, two[0][n:] - [5, 0, 0] + [0, 0, 1.6]])
    middle = (points[16] + points[17]) / 2
    here = int(np.flatnonzero((np.sort(triangles, axis=1) == [6, 16, 17]).all(axis=1))[0])
    a, b, c = np.roll(triangles[here], -int(np.argmax(triangles[here] == 6)))
    cut = np.vstack([np.delete(triangles, here, axis=0), [[a, b, n], [a, n, c]]])
    upper = np.isin(triangles, [*range(30), 50]).all(axis=1)
    seam = np.where(
        (20 <= triangles) & (triangles < 30) & upper[:, None], triangles + n - 20, triangles
    )
    return [
        ("nothing", points, triangles),
        ("a hole", points, np.delete(triangles, [32, 33, 35], axis=0)),
        (
            "a triangle turned over",
            points,
            np.where(np.arange(m)[:, None] == 32, triangles[:, ::-1], triangles),
        ),
        ("a fin", np.vstack([points, [tip]]), np.vstack([triangles, [[6, 7, n]]])),
        ("two spheres, tip to tip", *fused((touching, two[1]), (n - 2, 2 * n - 1))),
        ("two spheres that cross", beside, two[1]),
        ("a seam not sewn", np.vstack([points, points[20:30]]), seam),
        ("a triangle listed twice", points, np.vstack([triangles, triangles[[32]]])),
        ("a vertex in an edge", np.vstack([points, [middle]]), cut),
        ("a triangle without area", np.vstack([points, [middle]]), np.vstack([cut, [[c, n, b]]])),
    ][k]


@draw(error=Slider(0, 9, 8, "error", whole=True), turn=Slider(-180, 180, 0, "turn", steps=36))
def audit(error, turn):
    name, points, triangles = with_error(error)
    n, m = len(points), len(triangles)
    place, used = np.asarray(weld(points, 1e-9)), np.unique(triangles)
    s, count = sides(triangles), np.asarray(triangles_at_sides(triangles))
    fan = np.asarray(fans(n, triangles))
    loop, thin = (
        np.asarray(boundary_loops(n, triangles)),
        np.asarray(flat(points, triangles, 1e-9)) > 0,
    )
    over = np.zeros(m) if (count > 2).any() else np.asarray(turns(points, triangles))
    edges = np.array(sorted({tuple(sorted(e)) for e in s.tolist()}))
    i, j = (k.ravel() for k in np.indices((len(edges), m)))
    near = (np.abs(points[edges].mean(axis=1)[i] - points[triangles].mean(axis=1)[j]) < 0.9).all(
        axis=1
    )
    apart = (place[edges[i]][:, :, None] != place[triangles[j]][:, None]).all(axis=(1, 2)) & near
    i, j = i[apart], j[apart]
    crossed = np.unique(
        j[np.asarray(pierced(*points[edges[i]].swapaxes(0, 1), points[triangles[j]]), dtype=bool)]
    )
    t = np.radians(turn)
    shown = points @ [[np.cos(t), np.sin(t), 0], [-np.sin(t), np.cos(t), 0], [0, 0, 1]]
    lines = {
        "characteristic": int(euler_characteristic(triangles)),
        "vertices in the place of others": int((place[used] != used).sum()),
        "loops": len(np.unique(loop[loop >= 0])),
        "edges of more than two triangles": len({tuple(sorted(e)) for e in s[count > 2].tolist()}),
        "vertices of more than one fan": int((fan > 1).sum()),
        "triangles to turn": int((over < 0).sum()) if not (count > 2).any() else "–",
        "triangles without area": int(thin.sum()),
        "triangles that are pierced": len(crossed),
    }
    with figure(6.6, 2.9) as page:
        left, right = page.subplots(1, 2, width_ratios=(1, 1.2))
        marks = [(s[count == 1], BLUE), (s[count > 2], ORANGE), (sides(triangles[thin]), GREEN)]
        draw_surface(left, shown, triangles, marks, [*np.flatnonzero(over < 0), *crossed])
        draw_rings(left, shown, np.flatnonzero(fan > 1))
        left.set(title=name)
        right.set_axis_off()
        for k, (what, number) in enumerate(lines.items()):
            normal = number == (2 if k == 0 else 0)
            style = {"color": GREY if normal else "black", "weight": "normal" if normal else "bold"}
            right.text(
                0, 0.93 - 0.12 * k, str(number), ha="right", transform=right.transAxes, **style
            )
            right.text(0.05, 0.93 - 0.12 * k, what, transform=right.transAxes, **style)
    return page


# %% [markdown]
# **What to look at.** One error has several signs: to list a triangle twice makes three edges of
# three triangles, and a seam makes two loops in one place. A vertex in an edge (it is called
# a *T-junction*) leaves a slit without width: a loop of three edges, where the eye sees none. Close
# it with a triangle, and that has no area.
#
# ## In words
#
# **14.9** A list of errors of meshes that are not manifolds names duplicate vertices,
# edges and triangles; a surface with a boundary; flipped triangles; self-intersections. Which of
# these make a surface no manifold? What do the others concern: the *boundary*, the *orientation*,
# the *embedding*, or only how the surface is *written down*? Which two errors of manifoldness are
# missing? And in a list of triangles: what could a duplicate edge be?
#
# <details><summary>Hint</summary>
#
# Try each of them with the picture above. Ask of each: would it still be there if all points moved
# somewhere else? If the order of the vertices in a triangle did not matter?
#
# </details>

# %% [markdown] answer="14.9" points=4
# None of them as such. A manifold needs at most two triangles at each edge and a single fan at each
# vertex. A manifold may have a boundary (a sheet of paper), that concerns whether it is closed.
# Flipped triangles concern the orientation: the order within a triangle, while the surface as a set
# of triangles stays the same manifold. Self-intersections concern the embedding: where the points
# lie; moved elsewhere, the same list has none. Duplicate vertices and triangles are matters of how
# the surface is written. They have consequences in the counts: vertices that are there twice make a
# boundary where there is none to the eye, and a triangle that is listed twice in a closed mesh
# makes three edges of three triangles, so this one does violate the conditions of a manifold,
# though by repetition only.
#
# Missing are edges of three triangles or more that are no repetition, and bow-ties: vertices with
# several fans. (T-junctions and triangles without area are missing too.)
#
# A list of triangles has no list of edges, so no edge can be there twice. What may be meant: an
# edge of more than two triangles, or two edges of the boundary in one place, between vertices that
# are duplicates: a seam.

# %% [markdown] rubric="14.9"
# One point for boundary, orientation and embedding, each with the right error. One for duplicates
# as a matter of representation, with one of their consequences. One for both missing errors,
# crowded edges and bow-ties. One for the duplicate edge: either reading, with the remark that the
# list has no edges.

# %% [markdown]
# **14.10** "The characteristic of the file is 2, so it is a sphere." Give two different reasons why
# this does not follow, each with an example. What is the characteristic of a soup of $M$ triangles?
# Which checks must a list of triangles pass before (14.2) tells the number of handles?
#
# <details><summary>Hint</summary>
#
# The characteristics of parts add up. What do holes and handles take away? And which surfaces are
# not covered by the formula with $g$ at all?
#
# </details>

# %% [markdown] answer="14.10" points=3
# Parts add up: a sphere and any number of tori have 2 as well, and so have two sheets of paper,
# with 1 each. Nor need it be a manifold: a fin on a sphere adds one vertex, two edges and one
# triangle, which leaves 2; and two spheres and a torus, all welded in one vertex, have $2 + 2 + 0 -
# 2 = 2$.
#
# In a soup no vertex and no edge is shared: $3M - 3M + M = M$.
#
# The list must be welded, without repeated triangles; each part must be taken by itself; it must be
# a manifold, with at most two triangles at each edge and one fan at each vertex; its loops must be
# counted, $b$ of them; and it must be orientable. Then $g = (2 - b - \chi)/2$. For the strip of
# Möbius with $\chi = 0$ and $b = 1$ this would be half a handle.

# %% [markdown] rubric="14.10"
# One point for two reasons with examples (several parts; boundary; no manifold). One for the soup,
# $M$. One for the checks: connected, manifold, loops counted, orientable; one of them may be
# missing.

# %% [markdown]
# ## Dig deeper
#
# - Three points in a row, each within the tolerance of the next, the first and the last not. What
#   does (14.1) return? What should be done: weld all, some, none?
# - A closed part can be oriented in two ways. Show that $\frac16 \sum \det(\mathbf{a}, \mathbf{b},
#   \mathbf{c})$ over its triangles is the volume, with a sign that tells which way the normals
#   point. Why does it not matter where the origin is? What if one triangle is turned over?
# - Round the coordinates in (14.4) to the precision of the computer, and put $\mathbf{p}$ very near
#   to the plane. When is the sign wrong? How could a program know?
# - To look at all pairs of edges and triangles takes hours for a million triangles. Sort boxes
#   round the triangles first. Which pairs are left?
# - Repair: which of the errors of the last picture could a program mend without asking, and where
#   would it have to guess?

# %%
progress()
