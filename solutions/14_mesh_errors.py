# ---
# jupyter:
#   course:
#     builds_on:
#       "11": the surfaces whose files are examined here
#     pages: appendix, section 1
#     chapters: [37-mesh-errors]
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
# # Errors in triangle meshes
#
# A surface in a file is a list of points and a list of triangles. Nothing in the file guarantees
# that the triangles form a surface. Missing, doubled or inverted triangles are hardly visible in a
# picture. But a 3D printer, or the computation of a volume, will fail. In this notebook you write
# functions that find such errors, and you learn which property of a surface each error violates.
#
# **Sources.** The appendix (of a thesis on mesh errors and conditionally positive definite
# functions); Botsch and others, *Polygon Mesh Processing* (2010), chapters 1 and 8; Attene,
# Campen and Kobbelt, *Polygon mesh repairing: an application perspective*, ACM Computing Surveys
# 45 (2013). Search for: manifold, half-edge, polygon soup, vertex welding, Euler characteristic,
# boundary loop, bow-tie vertex, orientable surface, degenerate triangle, self-intersection,
# T-junction. Notebook 11 constructs surfaces; here their files are examined. Numbers in brackets,
# such as (14.1), belong to formulas; numbers without brackets belong to questions.
#
# Each question asks for a function with a check below it, or for an answer in words. After a check
# that is not right, `case()` in a new cell shows the inputs for which your function failed, and
# your values. If everybody has the same inputs, it also shows the right values. Arrays may hold
# integers, so small that no product of them overflows. Compute with float64, NumPy's default type.
# Returned lists count as arrays, an array with one entry as a number, and a complex number without
# imaginary part as a real one. A function must not change its arguments.

# %% tags=["setup"]
import numpy as np

from fieldcheck import (
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    PURPLE,
    Slider,
    case,
    check,
    data,
    draw,
    figure,
    progress,
    start_over,
)
from fieldcheck.datasets import kleopatra


def sides(triangles):
    """Return the two ends of each side, of shape (3M, 2), for triangles (M, 3).

    Row 3t + k is side k of triangle t; it runs from vertex k of the triangle to the next one.
    """
    return np.take(triangles, [0, 1, 1, 2, 2, 0], axis=1).reshape(3 * len(triangles), 2)


def connected(n, links):
    """Return the smallest index in the connected component of each of n objects, of shape (n,).

    Each row of links (K, 2) connects two objects. An object without links is a component itself.
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
from fieldcheck.inputs.surfaces import (
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


def projected(points, turn=25, tilt=25):
    """Return the position of points in the picture, and their depth as a third coordinate."""
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
    place, special = projected(points), set(special)
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
        *projected(points)[vertices, :2].T, "o", ms=10, mfc="none", mec=ORANGE, mew=2.5, zorder=9999
    )


def many(n, thing):
    """Return a number with a noun in the singular or plural."""
    return f"{n} {thing}" + "s" * (n != 1)


# %% [markdown]
# ## Shared vertices and polygon soups
#
# Three files with the same sphere. The slider moves the connected components of each *list* of
# triangles away from the centre.


# %%
@draw(pull=Slider(0, 1, 0.45, "pull"))
def three_files(pull):
    points, triangles = ball(5, 10)
    soup = points[triangles].reshape(-1, 3), np.arange(triangles.size).reshape(-1, 3)
    upper = points[triangles, 2].mean(axis=1) > 0.02
    seam = points.repeat(2, axis=0), 2 * triangles + upper[:, None]
    files = {"shared vertices": (points, triangles), "a seam": seam, "polygon soup": soup}
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
                title=f"{name}:\n{many(len(np.unique(part)), 'component')}",
            )
    return page


# %% [markdown]
# **What to look at.** Put the slider to zero: the three files look the same. The right one is a
# *polygon soup*, as in STL, the usual format for 3D printing: every triangle has three points of
# its own. The middle one has a *seam*, along which every point is listed twice.
#
# ## Example: two triangles
#
# A square has the vertices 0, 1, 2, 3, counter-clockwise, and the triangles $(0, 1, 2)$ and $(0,
# 2, 3)$. Each triangle has three *sides* (in a data structure: half-edges), which run from vertex
# to vertex:
#
# | triangle | sides |
# |---|---|
# | $(0, 1, 2)$ | $0 \to 1$, $1 \to 2$, $2 \to 0$ |
# | $(0, 2, 3)$ | $0 \to 2$, $2 \to 3$, $3 \to 0$ |
#
# The sides $2 \to 0$ and $0 \to 2$ are the same *edge*, which has two triangles. The other four
# edges have one triangle each; they are the boundary. There are 4 vertices, 5 edges and 2
# triangles. The triangles agree: they run along their common edge in opposite directions.
# `sides(triangles)`, above, is written for you; its rows are these six sides.
#
# The next function is finished, and shows the form of a function on such a list.

# %%
SQUARE = np.array([[0, 1, 2], [0, 2, 3]])
print(sides(SQUARE).tolist())


def triangles_at_vertices(n, triangles):
    """Return how many triangles each of n vertices has, of shape (n,), for triangles (M, 3)."""
    count = np.zeros(n, dtype=int)
    for three in triangles:
        count[three] += 1
    return count


print(triangles_at_vertices(5, SQUARE))

# %% [markdown]
# ## Merging vertices (welding)
#
# Let $\mathbf{p}_1, \dots, \mathbf{p}_N$ be the points, in space or in the plane. To *merge* (or
# *weld*) vertices, replace each vertex by the first one within a tolerance $\tau \ge 0$:
#
# $$ w_i = \min\{\, j : \lVert \mathbf{p}_j - \mathbf{p}_i \rVert \le \tau \,\} . \tag{14.1} $$
#
# A tolerance is needed since files round coordinates; with $\tau = 0$ only equal points are
# merged. Copies of a point should be much closer together than $\tau > 0$, and different points
# much farther apart. Otherwise the result depends on the order of the points, and a vertex that
# replaces another one may itself be replaced: for the points $0,\ 0.9,\ 1.8,\ 2.7$ on a line and
# $\tau = 1$, (14.1) gives $w = (0, 0, 1, 2)$. Point 2 becomes point 1, and point 1 becomes point 0.
#
# ### 14.1 Merge
#
# Return $w_i$ for each vertex, counted from 0 as in Python, also for such chains of points. A
# vertex without an earlier one within $\tau$ keeps its own number. Points may be far from the
# origin.
#
# <details><summary>Hint</summary>
#
# `points[:, None] - points` is the array of all differences. For an array of True and False,
# `np.argmax` along an axis finds the first True.
#
# </details>


# %% question="14.1" minutes=15
def weld(points, tolerance):
    """Return w of (14.1), integers of shape (N,), for points (N, D) and a tolerance ≥ 0."""
    # BEGIN SOLUTION
    distance = np.linalg.norm(points[:, np.newaxis] - points, axis=2)
    return np.array([np.argmax(gaps <= tolerance) for gaps in distance])
    # END SOLUTION


# %%
check("14.1")

# %% [markdown]
# From now on a surface is a list of triangles; each row has the numbers of three different vertices
# (except in 14.7). Vertices with different numbers are different, even if their points are equal.
#
# ## Boundary edges and non-manifold edges
#
# An *edge* consists of all sides with the same two ends, in either direction. The number of its
# triangles classifies it:
#
# - **one**: the edge belongs to the *boundary* of the surface;
# - **two**: the edge is inside the surface;
# - **three or more**: the surface branches; the edge is *non-manifold*.
#
# ### 14.2 Triangles at each edge
#
# Return, for each row of `sides(triangles)`, how many triangles have its edge. A triangle that is
# listed twice counts twice. For the square of the example the result is $1, 1, 2, 2, 1, 1$.
#
# <details><summary>Hint</summary>
#
# Sort the two ends of each side first. Then `np.unique` with `axis=0` finds the different edges.
# It can also return how often each edge occurs, and which edge each row is.
#
# </details>


# %% question="14.2" minutes=10
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
# **What to look at.** Boundary edges are blue, non-manifold edges are orange. The fin has both:
# boundary edges and non-manifold edges are independent errors. The inside of a surface is dark.
#
# ## The Euler characteristic
#
# Let $V$ be the number of vertices *that occur in triangles*, $E$ the number of edges and $F$ the
# number of triangles. A triangle that is listed twice counts twice. The *Euler characteristic*
#
# $$ \chi = V - E + F \tag{14.2} $$
#
# does not change when an edge is split together with its triangles. A closed, orientable, connected
# surface with $g$ handles has $\chi = 2 - 2g$: 2 for a sphere, 0 for a torus. Each hole that is
# cut into the surface reduces $\chi$ by 1. The characteristics of several components add up. For
# the square of the example $\chi = 4 - 5 + 2 = 1$: a sphere with one hole.
#
# ### 14.3 Euler characteristic
#
# Return $\chi$ of (14.2).
#
# <details><summary>Hint</summary>
#
# A file may contain points that no triangle has. They are not vertices of the surface: use only
# the list of triangles. Each edge counts once.
#
# </details>


# %% question="14.3" minutes=10
def euler_characteristic(triangles):
    """Return χ of (14.2), an integer, for triangles (M, 3)."""
    # BEGIN SOLUTION
    edges = np.unique(np.sort(sides(triangles)), axis=0)
    return len(np.unique(triangles)) - len(edges) + len(triangles)
    # END SOLUTION


# %%
check("14.3")

# %% [markdown]
# With these functions the polygon soup of the first picture can be merged. Its points have errors
# of about $10^{-5}$, as in a file with few digits. Which tolerance is suitable?


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
            label="characteristic χ",
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
# **What to look at.** Blue edges are boundary edges. Between the errors of the points and the
# length of the edges there is a wide range of tolerances with the same result, $\chi = 2$: a
# sphere. For smaller tolerances there are cracks; for larger ones the surface collapses.
#
# ## Boundary loops
#
# Connected boundary edges form a *boundary loop*, on a manifold the boundary of one hole. We name a
# loop by its smallest vertex. The function `connected(n, links)`, above, is written for you: it
# finds the connected components of $n$ objects that are linked in pairs, and returns for each
# object the smallest one in its component.
#
# ### 14.4 Boundary loops
#
# Return for each of $n$ vertices the name of its loop, and $-1$ if the vertex is on no loop. For
# the square of the example, with $n = 5$, the result is $0, 0, 0, 0, -1$. In the check each
# vertex on the boundary is on two boundary edges. The fin in the audit at the end has a path
# instead of a loop, which gets its name in the same way. Some triangles may be inverted, so the
# boundary sides need not run the same way round. Some edges may be non-manifold; they do not
# belong to the boundary. A triangle that is listed twice counts twice, as in 14.2.


# %% question="14.4" minutes=10
def boundary_loops(n, triangles):
    """Return the smallest vertex on the loop of each vertex, or -1, (n,), for triangles (M, 3)."""
    # BEGIN SOLUTION
    free = sides(triangles)[triangles_at_sides(triangles) == 1]
    loop = connected(n, free)
    loop[~np.isin(np.arange(n), free)] = -1
    return loop
    # END SOLUTION


# %%
check("14.4")

# %% [markdown]
# ## Fans and bow-tie vertices
#
# A surface can fail to be a manifold although every edge has two triangles. For example, two
# tetrahedra that share one vertex form two cones, tip to tip. Such a vertex is called a *bow-tie*
# or *non-manifold vertex*. A *fan* is a maximal set of triangles at a vertex that are connected
# across edges ending at this vertex. A vertex of a manifold has exactly one fan.
#
# In the example of the square, vertex 0 has two triangles that share the edge 0–2: one fan.
#
# ### 14.5 Fans
#
# Return how many fans each vertex has, and 0 for a vertex without triangles. All triangles at a
# common edge are in one fan, also three or more.
#
# <details><summary>Hint 1</summary>
#
# A triangle $(v, a, b)$ at the vertex $v$ has the side from $a$ to $b$ opposite to $v$. Two
# triangles at $v$ share an edge that ends at $v$ if their opposite sides have a common end.
#
# </details>
# <details><summary>Hint 2</summary>
#
# Go vertex by vertex. Select the triangles at the vertex, and use the two other vertices of each
# of them as a link for `connected`. How many components do *these* vertices form?
#
# </details>


# %% question="14.5" minutes=20
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
        "poles merged": fused((points, triangles), (72, 73)),
    }
    with figure(6.6, 2.3) as page:
        for axes, (name, (p, t)) in zip(page.subplots(1, 4), surfaces.items(), strict=True):
            loop, bows = np.asarray(boundary_loops(len(p), t)), np.asarray(fans(len(p), t)) > 1
            s, count = sides(t), np.asarray(triangles_at_sides(t))
            names = np.unique(loop[loop >= 0])
            rims = [s[(count == 1) & (loop[s[:, 0]] == one)] for one in names]
            draw_surface(axes, p, t, zip(rims, (BLUE, PURPLE, GREEN)))
            draw_rings(axes, p, np.flatnonzero(bows))
            label = f"{many(len(names), 'loop')}, {many(int(bows.sum()), 'bow-tie')}"
            axes.set_title(f"{name}:\n{label}", fontsize=9)
    return page


# %% [markdown]
# **What to look at.** Each loop has its own colour; a ring marks a bow-tie vertex. In both
# pictures on the right every edge has two triangles, and neither surface is a manifold. The pages
# of a book, above, have a non-manifold edge and no bow-tie. So both conditions must be checked.
#
# ## Orientation
#
# A triangle is listed *counter-clockwise when seen from outside*. Two neighbours agree if they run
# along their common edge in *opposite* directions, as in the example of the square. If they run
# along it in the same direction, one of them must be inverted. A surface is *oriented* if all
# neighbours agree. It is *orientable* if some of its triangles can be inverted so that all
# neighbours agree.
#
# ### 14.6 Orientation
#
# Return $+1$ for each triangle that stays and $-1$ for each triangle that must be inverted, so that
# all neighbours agree. A *part* is a maximal set of triangles connected across edges, possibly a
# single one. The triangle of each part that is first in the list stays. If a part is not
# orientable, return 0 for all its triangles. No edge has more than two triangles, a triangle may be
# listed twice, and a part may have thousands of triangles. The points are an argument too: are they
# needed?
#
# <details><summary>Hint 1</summary>
#
# Go from triangle to triangle across edges: a neighbour that disagrees gets the opposite sign. If
# you reach a triangle that already has the other sign, the part is not orientable.
#
# </details>
# <details><summary>Hint 2, without a walk</summary>
#
# Take $2M$ objects: number $t$ for triangle $t$ as it is, and number $M + t$ for triangle $t$
# inverted. Link what fits together. If two neighbours agree, link both as they are, and both
# inverted. What fits if they disagree? Then `connected` finds the smallest number of each
# component. What does it mean if $t$ and $M+t$ are in one component? Otherwise, which of the two
# is in the component of the first triangle?
#
# </details>


# %% question="14.6" minutes=35
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
        right.set(title=f"{many(int((turn < 0).sum()), 'triangle')} inverted")
    return page


# %% [markdown]
# If the result is dark, the first triangle, which stays, was one of the inverted ones. Agreement
# between neighbours does not determine which side is outside.
#
# Now take a strip of paper, twist it by some half turns, and join its ends. Some triangles are
# inverted at random. With one half turn this is the *Möbius strip*.


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
            title=f"{'oriented' if turn.any() else 'not orientable'}, {many(len(names), 'loop')}"
        )
    return page


# %% [markdown]
# **What to look at.** On the left, dark triangles are seen from inside. On the right your function
# has inverted them. With an even number of half turns the strip has two sides and two boundary
# loops. With an odd number it has one side and one loop. An inverted triangle is an error of the
# *list* and can be repaired there. One-sidedness is a property of the *surface* and cannot be
# repaired.
#
# ## Degenerate triangles
#
# So far the positions of the points were used for merging only. The last two errors are geometric.
#
# A triangle without area is *degenerate*: it has no normal. Two kinds occur: *needles*, with two
# corners at the same point, and *caps*, with one corner on the opposite side, whose three sides are
# all long. Coordinates are rounded, so we allow a tolerance. We call a triangle *flat*, that is,
# degenerate within the tolerance $\tau$, if its smallest height is at most $\tau$:
#
# $$ h = \frac{2A}{\text{its longest side}} \le \tau . \tag{14.3} $$
#
# **Example.** The triangle $(0,0,0)$, $(4,0,0)$, $(1,0.3,0)$ has the area $A = 0.6$ and the
# longest side 4. Its smallest height is $1.2 / 4 = 0.3$, the distance of the third corner from the
# longest side.
#
# ### 14.7 Flat triangles
#
# Return whether each triangle is flat. Needles, caps and very small triangles occur, also far from
# the origin. Some triangles name a vertex twice, or have corners at the same point. They are
# exactly degenerate, and flat for every $\tau \ge 0$. Avoid the division of zero by zero. Three
# different corners exactly on a line occur with $\tau > 0$ only.


# %% question="14.7" minutes=15
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
# ## Self-intersections
#
# A surface is *embedded* if its triangles share only the corners and edges that they have in
# common in the list. If two triangles intersect, an edge of one of them usually passes through the
# other. Whether the *segment* from $\mathbf{p}$ to $\mathbf{q}$ passes through the triangle
# $\mathbf{a}, \mathbf{b}, \mathbf{c}$ depends only on signs of volumes. Let
#
# $$ [\mathbf{a}, \mathbf{b}, \mathbf{c}, \mathbf{x}] = \operatorname{sign} \Big( \big(
#    (\mathbf{b} - \mathbf{a}) \times (\mathbf{c} - \mathbf{a}) \big)^T
#     (\mathbf{x} - \mathbf{a}) \Big) . \tag{14.4} $$
#
# This sign shows on which side of the plane through $\mathbf{a}, \mathbf{b}, \mathbf{c}$ the
# point $\mathbf{x}$ lies. The absolute value of the number in the large parentheses is six times
# the volume of the tetrahedron of the four points. The segment passes through the interior of the
# triangle if
#
# $$ [\mathbf{a}, \mathbf{b}, \mathbf{c}, \mathbf{p}] = -[\mathbf{a}, \mathbf{b}, \mathbf{c},
#    \mathbf{q}] \neq 0, \qquad
#    [\mathbf{p}, \mathbf{q}, \mathbf{a}, \mathbf{b}] = [\mathbf{p}, \mathbf{q}, \mathbf{b},
#    \mathbf{c}] = [\mathbf{p}, \mathbf{q}, \mathbf{c}, \mathbf{a}] . \tag{14.5} $$
#
# The first condition requires that the two ends of the segment lie on different sides of the plane
# of the triangle. The second condition requires that the straight line through $\mathbf{p}$ and
# $\mathbf{q}$ passes through the triangle: seen along this line, the three edges turn around it in
# the same direction (compare Guigue and Devillers, *Journal of Graphics Tools* 8, 2003).
#
# **Example.** Let $\mathbf{a} = (0,0,0)$, $\mathbf{b} = (4,0,0)$, $\mathbf{c} = (0,4,0)$,
# $\mathbf{p} = (1,1,2)$ and $\mathbf{q} = (1,1,-2)$. The cross product of $\mathbf{b} -
# \mathbf{a}$ and $\mathbf{c} - \mathbf{a}$ is $(0, 0, 16)$, so the numbers for $\mathbf{p}$ and
# $\mathbf{q}$ are $32$ and $-32$, and the first condition holds. The three numbers of the second
# condition are $-16$, $-32$ and $-16$. All three are negative, so the segment passes through the
# triangle. The segment from $\mathbf{p}$ to $(1,1,1)$ does not pass through the triangle, because
# both numbers of the first condition are positive.
#
# ### 14.8 Segments through triangles
#
# For each of $K$ pairs of a segment and a triangle, return whether (14.5) holds. No triangle is
# degenerate. Some segments end in the plane of the triangle, or lie in this plane, wholly inside or
# wholly outside the triangle. There (14.4) is zero, so the first condition does not hold. No
# segment touches an edge or a corner of its triangle. In the check products and sums then give zero
# without rounding errors. `np.linalg.det` divides, and rounds. Pairs may be of any size, and far
# from the origin.
#
# <details><summary>Hint</summary>
#
# Define a function for (14.4) inside your function, so that you need not write the formula five
# times. `np.cross` accepts arrays of shape $(K, 3)$, row by row.
#
# </details>


# %% question="14.8" minutes=15
def pierced(start, end, corners):
    """Return whether (14.5) holds, of shape (K,), for start and end (K, 3), corners (K, 3, 3)."""

    # BEGIN SOLUTION
    def side(a, b, c, x):
        return np.sign(np.sum(np.cross(b - a, c - a) * (x - a), axis=1))

    a, b, c = corners.swapaxes(0, 1)
    one, two, three = side(start, end, a, b), side(start, end, b, c), side(start, end, c, a)
    across = side(a, b, c, start) * side(a, b, c, end) < 0
    return across & (one == two) & (two == three)
    # END SOLUTION


# %%
check("14.8")

# %% [markdown]
# ## A complete audit
#
# All your functions examine a sphere with one error. Choose the error, predict the result, and
# rotate the sphere.


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
            "an inverted triangle",
            points,
            np.where(np.arange(m)[:, None] == 32, triangles[:, ::-1], triangles),
        ),
        ("a fin", np.vstack([points, [tip]]), np.vstack([triangles, [[6, 7, n]]])),
        ("two spheres, tip to tip", *fused((touching, two[1]), (n - 2, 2 * n - 1))),
        ("two spheres that cross", beside, two[1]),
        ("a seam", np.vstack([points, points[20:30]]), seam),
        ("a triangle listed twice", points, np.vstack([triangles, triangles[[32]]])),
        ("a T-junction", np.vstack([points, [middle]]), cut),
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
        "duplicate vertices": int((place[used] != used).sum()),
        "boundary loops": len(np.unique(loop[loop >= 0])),
        "non-manifold edges": len({tuple(sorted(e)) for e in s[count > 2].tolist()}),
        "bow-tie vertices": int((fan > 1).sum()),
        "inverted triangles": int((over < 0).sum()) if not (count > 2).any() else "–",
        "flat triangles": int(thin.sum()),
        "pierced triangles": len(crossed),
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
# **What to look at.** One error can have several signs. A triangle that is listed twice makes
# three edges with three triangles. A seam makes two boundary loops at the same points. A vertex in
# the interior of an edge (a *T-junction*) leaves a slit without width, a loop of three edges that
# is invisible in a picture. A triangle that closes the slit is degenerate.
#
# ## A measured surface: the asteroid Kleopatra
#
# Notebook 11 reconstructs asteroid 216 Kleopatra from points. `kleopatra()` also returns triangles
# of its surface, measured by radar (S. J. Ostro and others, NASA Planetary Data System, 2004, in
# the public domain; `fieldcheck/datasets/kleopatra.json` names the source). Meshes are often
# thinned by merging vertices with a large tolerance, in kilometres here. Triangles that lose a
# corner are removed. Does the result remain a manifold?


# %%
@draw(tolerance=Slider(0, 20, 9, "tolerance τ in km", steps=40))
def thinned(tolerance):
    points, triangles = kleopatra()
    name = np.asarray(weld(points, tolerance)).astype(int)
    for _ in range(20):
        name = name[name]  # (14.1) may name a vertex that is itself replaced
    t = name[triangles]
    t = t[(t != np.roll(t, 1, axis=1)).all(axis=1)]
    s, count = sides(t), np.asarray(triangles_at_sides(t))
    fan = np.asarray(fans(len(points), t))
    crowded = len({tuple(sorted(e)) for e in s[count > 2].tolist()})
    lines = {
        "vertices": len(np.unique(t)),
        "triangles": len(t),
        "characteristic": int(euler_characteristic(t)),
        "boundary edges": int((count == 1).sum()),
        "non-manifold edges": crowded,
        "bow-tie vertices": int((fan > 1).sum()),
        "vertex triples listed twice": len(t) - len(np.unique(np.sort(t, axis=1), axis=0)),
    }
    with figure(6.8, 2.9) as page:
        left, right = page.subplots(1, 2, width_ratios=(2.2, 1))
        draw_surface(left, points, t, [(s[count == 1], BLUE), (s[count > 2], ORANGE)])
        draw_rings(left, points, np.flatnonzero(fan > 1))
        left.set(title=f"216 Kleopatra, vertices merged within {tolerance:.1f} km")
        right.set_axis_off()
        for k, (what, number) in enumerate(lines.items()):
            y = 0.85 - 0.13 * k
            right.text(0.1, y, str(number), ha="right", transform=right.transAxes)
            right.text(0.15, y, what, transform=right.transAxes)
    return page


# %% [markdown]
# **What to look at.** Without merging the surface is closed, with $\chi = 2$. Up to about 5 km the
# thinned surface remains a sphere. From 6 km on there are non-manifold edges, although the file is
# correct. Some triangles have collapsed onto each other: their three vertices are listed twice, in
# opposite order. Would $\chi$ be 2 again if these pairs were removed?
#
# ## Questions in words
#
# **14.9** A lecture note has a list of "non-manifold errors": duplicate vertices, edges and
# triangles; a surface with a boundary; flipped triangles; self-intersections. Say for each of them,
# with a reason, what it concerns: the *boundary*, the *orientation*, the *embedding*, or the
# *representation* in the file.
#
# <details><summary>Hint</summary>
#
# Try each error with the audit above. Would it remain if all points were moved? Would it remain if
# the order of the vertices in a triangle did not matter?
#
# </details>

# %% [markdown] answer="14.9" points=4 minutes=15 words=100 optional
# *Representation*: duplicate vertices and triangles. A list of triangles has no list of edges, so
# no edge can be there twice. *Boundary*: a surface with a boundary. A sheet of paper is a manifold
# that is not closed. *Orientation*: flipped triangles. They concern the order of the vertices,
# while the surface as a set of triangles stays the same manifold. *Embedding*: self-intersections.
# They concern where the points lie, and moving the points can remove them.
#
# *Beyond the question.* A manifold needs at most two triangles at each edge and a single fan at
# each vertex. The two violations of this are missing in the list: edges with three or more
# different triangles, and bow-ties, vertices with several fans. Of the listed errors only duplicate
# triangles violate these conditions, and only by repetition: one of them in a closed mesh makes
# three edges with three triangles. Duplicate vertices make a boundary along a seam. T-junctions and
# triangles without area are missing in the list, too.

# %% [markdown] rubric="14.9"
# One point for duplicates as a matter of representation. One for the boundary. One for the
# orientation of flipped triangles. One for the embedding of self-intersections.

# %% [markdown]
# **14.10** "The Euler characteristic of the file is 2, so it is a sphere." Give three different
# reasons why this does not follow, each with an example.
#
# <details><summary>Hint</summary>
#
# The characteristics of components add up. How do holes and handles change $\chi$? Which surfaces
# does the formula with $g$ not cover?
#
# </details>

# %% [markdown] answer="14.10" points=3 minutes=10 words=70
# Components add up: a sphere and a torus have 2 together.
#
# It need not be a manifold: a fin on a sphere adds one vertex, two edges and one triangle, leaving
# 2.
#
# Triangles may be listed twice: each repetition adds one triangle and no edge, so a torus with two
# triangles listed twice has $0 + 2 = 2$.
#
# *Beyond the question.* Two sheets of paper have 2 together, with 1 each. Two spheres and a torus,
# all merged in one vertex, have $2 + 2 + 0 - 2 = 2$. Before (14.2) determines the number of
# handles, equal vertices must be merged and repeated triangles removed. Each component must be a
# manifold (at most two triangles at each edge, one fan at each vertex) and orientable. With $b$
# boundary loops it then has $g = (2 - b - \chi)/2$ handles. The Möbius strip has $\chi = 0$ and $b
# = 1$, so $g$ would be half a handle: it is not orientable.

# %% [markdown] rubric="14.10"
# One point for several components, with an example. One for a surface that is not a manifold, with
# an example. One for triangles listed twice, with an example. Two sheets, or vertices that are not
# merged, may stand for one of them.

# %% [markdown]
# ## Dig deeper
#
# - What should be done with chains of points, each within the tolerance of the next? Compare
#   (14.1) with the components of `connected`. Which is better for a soup, and which for thinning?
# - What is the Euler characteristic of a polygon soup of $M$ triangles?
# - A closed part can be oriented in two ways. Show that $\frac16 \sum \det(\mathbf{a}, \mathbf{b},
#   \mathbf{c})$ over its triangles is its volume, positive if the normals point outward (a case of
#   the divergence theorem). Why does the origin not matter? Compute the volume of Kleopatra: about
#   697 000 km³.
# - The signs in (14.4) are computed with rounding errors. When is a sign wrong? (Search for *robust
#   geometric predicates*; Shewchuk, 1997.)
# - Testing all pairs of edges and triangles takes hours for a million triangles. Search for
#   *bounding-volume hierarchy*: which pairs remain?
# - Which errors of the audit could a program repair without asking, and where must it guess?
#   (Search for *hole filling*; Barequet and Sharir, 1995.)

# %%
progress()
