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
# # Velocities at the vertices of a mesh
#
# A program that computes a flow on a mesh of triangles often knows one number for each edge: how
# fast the fluid crosses it. To draw the flow, or to let a leaf drift in it, one needs the whole
# velocity at a vertex. By the end of this notebook you have built a mesh and a flow, you have
# computed what the program would know, and you have won the velocities back: at most vertices to
# the last digit, at some not at all. You know beforehand at which, and why.
#
# Each question asks for a function. Write it, run its cell, and run the check below it. The check
# tells you whether it is right and, if it is not, what kind of mistake it may be. You need nothing
# from other notebooks. There are eight functions, most of them of one to three lines, and three
# questions in words.

# %% tags=["setup"]
import numpy as np
from matplotlib.tri import Triangulation

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

# %% [markdown]
# ## The problem in a picture
#
# On the left is a flow: two whirls that turn against each other. On the right is what the program
# knows of it. The mesh lies over the flow, and for each edge there is one number, the speed at
# which the fluid crosses it: the darker the edge, the faster. Along a pale edge the fluid may rush,
# but it does not cross. Which way does it go, and how fast, at the vertex with the question mark?
# Move it.


# %%
def scattered(number, seed=3):
    """Vertices (K, 2) of a mesh of the unit square: spread evenly, but not in rows; and its
    triangles (T, 3).
    """
    random = np.random.default_rng(seed)
    k = np.arange(12)
    rim = (k + (k % 3 > 0) * random.uniform(-0.3, 0.3, 12)) / 3  # once round the square, in sides
    round_x, round_y = ([0, 1, 1, 0, 0], [0, 0, 1, 1, 0])
    points = np.stack([np.interp(rim, range(5), way) for way in (round_x, round_y)], axis=1)
    while len(points) < number:
        more = random.uniform(0.08, 0.92, (2, 2))
        free = [np.hypot(*(points - place).T).min() for place in more]
        points = np.vstack([points, more[np.argmax(free)]])
    return points, Triangulation(*points.T).triangles


POINTS, TRIANGLES = scattered(32)


def whirls(x, y):
    """What flows between two places: the difference of this function there."""
    return np.sin(np.pi * x) * np.sin(2 * np.pi * y) / np.pi


@draw(vertex=Slider(0, 31, 20, "vertex", whole=True))
def the_problem(vertex):
    side = np.linspace(0, 1, 41)
    heights = whirls(*np.meshgrid(side, side))
    down, along = np.gradient(heights, side, side)
    with figure(6.6, 3.2) as page:
        left, right = page.subplots(1, 2)
        left.streamplot(
            side, side, down, -along, density=0.8, color=BLUE, linewidth=0.9, arrowsize=0.8
        )
        for corners in TRIANGLES:
            for a, b in zip(POINTS[corners], POINTS[np.roll(corners, 1)], strict=True):
                crossing = abs(whirls(*a) - whirls(*b)) / np.hypot(*(a - b))
                right.plot(
                    *np.stack([a, b]).T,
                    color=BLUE,
                    alpha=min(1, 0.08 + 0.5 * crossing),
                    lw=2.2,
                    solid_capstyle="round",
                )
        x, y = POINTS[vertex]
        right.plot(x, y, "o", ms=17, color="white", mec=ORANGE, mew=1.6, zorder=3)
        right.text(
            x, y, "?", color=ORANGE, ha="center", va="center_baseline", weight="bold", zorder=4
        )
        for axes, title in ((left, "the flow"), (right, "what is known of it")):
            axes.set(
                aspect="equal",
                xticks=[0, 1],
                yticks=[0, 1],
                title=title,
                xlim=(-0.05, 1.05),
                ylim=(-0.05, 1.05),
            )
    return page


# %% [markdown]
# **What to look at.** Each edge tells one number, and a velocity has two. But the edges around a
# vertex lie in different directions. Each tells another component, though each at another place.
# This is least squares again, with a twist: what is measured is not the velocity but its *shadow*
# on a normal.

# %% [markdown]
# ## The mesh
#
# A triangle mesh is two arrays: the vertices $\mathbf{x}_1, \dots, \mathbf{x}_K$, of shape $(K,
# 2)$, and for each triangle the numbers of its three corners, of shape $(T, 3)$. The corners may
# come in either sense of rotation. An *edge* is a pair of vertices: a side of a triangle. Inside
# the mesh two triangles share it, on the boundary it belongs to one.
#
# ### 05.1 The edges
#
# Write a function that lists the edges, each once. The order of the edges, and which end of an edge
# comes first, are up to you.
#
# <details><summary>Hint</summary>
#
# Write down the three sides of every triangle. An inner edge is now there twice, perhaps once as
# $(i, j)$ and once as $(j, i)$. How do you make these two alike? After that a function of NumPy
# keeps one of each; look at its argument `axis`.
#
# </details>


# %% question="05.1"
def edges_of(triangles):
    """Return the edges as pairs of vertex numbers, of shape (E, 2), for triangles (T, 3)."""
    # BEGIN SOLUTION
    pairs = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    return np.unique(np.sort(pairs), axis=0)
    # END SOLUTION


# %%
check("05.1")

# %% [markdown]
# For an edge $a$ between the vertices $i$ and $j$ let
#
# $$ \mathbf{p}_a = \tfrac{1}{2} (\mathbf{x}_i + \mathbf{x}_j), \qquad
#    \mathbf{n}_a \cdot (\mathbf{x}_j - \mathbf{x}_i) = 0, \qquad \lVert \mathbf{n}_a \rVert = 1
#    \tag{5.1} $$
#
# be its *midpoint* and a *unit normal*. Two vectors satisfy this, $\mathbf{n}_a$ and
# $-\mathbf{n}_a$. Take either.
#
# ### 05.2 Midpoints and normals
#
# Write a function that returns both, one row for each edge.


# %% question="05.2"
def midpoints_and_normals(points, edges):
    """Return p_a and n_a of (5.1), each of shape (E, 2), for points (K, 2) and edges (E, 2)."""
    # BEGIN SOLUTION
    start, end = points[edges[:, 0]], points[edges[:, 1]]
    along = end - start
    normals = np.column_stack([-along[:, 1], along[:, 0]])
    length = np.linalg.norm(along, axis=1)
    return (start + end) / 2, normals / length[:, np.newaxis]
    # END SOLUTION


# %%
check("05.2")

# %% [markdown]
# Here is what you have made, on the mesh of the first picture. Are all edges there? Is each normal
# across its edge?


# %%
@draw(vertex=Slider(0, 31, 20, "vertex", whole=True))
def edges_and_normals(vertex):
    edges = edges_of(TRIANGLES)
    p, n = midpoints_and_normals(POINTS, edges)
    mine = (np.asarray(edges) == vertex).any(axis=1)
    with figure(6.4, 3.9) as page:
        axes = page.subplots()
        for edge, color in zip(edges, np.where(mine, ORANGE, GREY), strict=True):
            axes.plot(*POINTS[edge].T, color=color, lw=1.8 if color == ORANGE else 0.9)
        axes.plot(*p.T, "o", ms=3, color="black", label=r"midpoints $\mathbf{p}_a$")
        axes.quiver(
            *p.T,
            *n.T,
            color=BLUE,
            angles="xy",
            scale_units="xy",
            scale=16,
            width=0.004,
            label=r"normals $\mathbf{n}_a$",
        )
        axes.plot(*POINTS[vertex], "o", color=ORANGE, label=f"vertex {vertex}, {mine.sum()} edges")
        axes.set(
            aspect="equal",
            xticks=[0, 1],
            yticks=[0, 1],
            title=f"{len(POINTS)} vertices, {len(TRIANGLES)} triangles, {len(edges)} edges",
        )
        axes.legend(loc="center left", bbox_to_anchor=(1, 0.5))
    return page


# %% [markdown]
# ## A flow that is known
#
# To see whether a method works one needs a case where the truth is known. Ours is a rotation. Let
#
# $$ \mathbf{m} = \frac{1}{K} \sum_{k=1}^K \mathbf{x}_k, \qquad
#    \mathbf{u}_k = \mathbf{J}\,(\mathbf{x}_k - \mathbf{m}), \qquad
#    \mathbf{J} = \begin{bmatrix} 0 & -1 \\ 1 & 0 \end{bmatrix}. \tag{5.2} $$
#
# So $\mathbf{J}$ makes $(-z_2, z_1)$ of a vector $(z_1, z_2)$: it turns it by a right angle.
#
# ### 05.3 The rotation


# %% question="05.3"
def rotation(points):
    """Return u_1 … u_K of (5.2), of shape (K, 2), for points (K, 2)."""
    # BEGIN SOLUTION
    m = points.mean(axis=0)
    z = points - m
    return np.column_stack([-z[:, 1], z[:, 0]])
    # END SOLUTION


# %%
check("05.3")

# %% [markdown]
# The program would know only how fast the fluid crosses each edge, the *normal velocity* at its
# midpoint. We compute it from the velocities at the two ends,
#
# $$ v_a = \mathbf{n}_a \cdot \tfrac{1}{2} (\mathbf{u}_i + \mathbf{u}_j). \tag{5.3} $$
#
# Its sign says to which side the fluid goes: where $\mathbf{n}_a$ points, or the other way.
#
# ### 05.4 The normal velocities


# %% question="05.4"
def normal_velocities(edges, normals, u):
    """Return v_a of (5.3), of shape (E,), for edges (E, 2), normals (E, 2), velocities u (K, 2)."""
    # BEGIN SOLUTION
    mean = (u[edges[:, 0]] + u[edges[:, 1]]) / 2
    return np.sum(normals * mean, axis=1)
    # END SOLUTION


# %%
check("05.4")

# %% [markdown]
# On the left the truth, on the right what is left of it: the arrow at each midpoint is
# $v_a\mathbf{n}_a$, the part of the velocity across the edge. The rest is lost.


# %%
@draw(seed=Slider(1, 12, 3, "mesh", whole=True))
def truth_and_data(seed):
    points, triangles = scattered(32, seed)
    edges = edges_of(triangles)
    p, n = midpoints_and_normals(points, edges)
    u = rotation(points)
    v = normal_velocities(edges, n, u)
    look = dict(angles="xy", scale_units="xy", scale=3.2, width=0.007)
    with figure(6.6, 3.2) as page:
        left, right = page.subplots(1, 2)
        left.quiver(*points.T, *u.T, color=BLUE, **look)
        left.plot(*points.mean(axis=0), "+", ms=11, color="black")
        right.quiver(*p.T, *(v[:, np.newaxis] * n).T, color=ORANGE, **look)
        for axes, title in (
            (left, r"velocities $\mathbf{u}_k$, and + at $\mathbf{m}$"),
            (right, r"known: $v_a\,\mathbf{n}_a$"),
        ):
            axes.triplot(*points.T, triangles, color=GREY, lw=0.6, zorder=0)
            axes.set(
                aspect="equal",
                xticks=[0, 1],
                yticks=[0, 1],
                title=title,
                xlim=(-0.2, 1.2),
                ylim=(-0.2, 1.2),
            )
    return page


# %% [markdown]
# **What to look at.** The orange picture hardly looks like a rotation. An edge that points to
# $\mathbf{m}$ is crossed at full speed; one that lies across that direction is not crossed at all,
# however fast the fluid runs along it.
#
# ### In words
#
# **05.5** Is the velocity field (5.2) a linear mapping of the place? Say precisely of what it is
# one. Then look at (5.3): it takes the mean of the velocities at the two ends for the velocity at
# the midpoint. Show that for this field that is no approximation. For which fields is it one, and
# what decides how good it is?
#
# <details><summary>Hint</summary>
#
# A linear mapping takes zero to zero. Where is $\mathbf{u} = \mathbf{0}$? For the mean, insert the
# midpoint of (5.1) into (5.2).
#
# </details>
#
# <details><summary>Hint for the last part</summary>
#
# Look at the velocity along one edge only, as a function of one variable, and at its Taylor series
# about the midpoint. Which terms drop out of the mean of the two ends?
#
# </details>

# %% [markdown] answer="05.5" points=4
# As a field, $\mathbf{u}(\mathbf{x}) = \mathbf{J}(\mathbf{x} - \mathbf{m}) = \mathbf{J}\mathbf{x} -
# \mathbf{J}\mathbf{m}$. It is a linear mapping of $\mathbf{x} - \mathbf{m}$, the place seen from
# the mean. Of $\mathbf{x}$ itself it is an *affine* one: it is zero at $\mathbf{m}$ and not at the
# origin, so that it is linear in $\mathbf{x}$ only if $\mathbf{m} = \mathbf{0}$. Its derivative is
# $\mathbf{J}$ everywhere; the trace is zero, so the field is free of divergence: a rigid rotation
# about $\mathbf{m}$.
#
# An affine map takes the mean of two points to the mean of their images: $\tfrac12(\mathbf{u}_i +
# \mathbf{u}_j) = \mathbf{J}\left(\tfrac12(\mathbf{x}_i + \mathbf{x}_j) - \mathbf{m}\right) =
# \mathbf{u}(\mathbf{p}_a)$. Nothing is neglected, and $v_a = \mathbf{n}_a \cdot
# \mathbf{u}(\mathbf{p}_a)$ exactly. That the sum of the weights $\tfrac12 + \tfrac12$ is one is
# what lets the constant part through.
#
# For a field that is not affine along the edge it is an approximation. With $t$ the distance from
# the midpoint along an edge of length $l$, the ends are at $t = \pm l/2$, and the odd terms of the
# Taylor series cancel in the mean: $\tfrac12(\mathbf{u}_i + \mathbf{u}_j) =
# \mathbf{u}(\mathbf{p}_a) + \tfrac18 l^2\, \partial_t^2\mathbf{u}(\mathbf{p}_a) + O(l^4)$. So the
# curvature of the field along the edge decides, and halving the edges makes the error four times
# smaller.

# %% [markdown] rubric="05.5"
# One point for affine in $\mathbf{x}$, linear in $\mathbf{x}-\mathbf{m}$; "linear" without saying
# of what earns none. Two for the mean: one for the calculation, one for naming what is used, that
# the map is affine. One for the error of other fields: second derivative along the edge, second
# order in its length.

# %% [markdown]
# ## Which edges?
#
# We want the velocity at one vertex, from edges around it. Which? Those that end there are too few,
# as you will see. So take all edges of the triangles that meet there: the *one ring* of the vertex.
# If this is not enough, take also the triangles that touch the one ring, be it in one corner only:
# the edges of all these are the *two ring*. And so on: each ring adds the triangles that have a
# corner among those of the ring before.
#
# ### 05.6 The ring
#
# Write a function that says for each edge whether it is in the ring.
#
# <details><summary>Hint</summary>
#
# `np.isin(triangles, some)` says of each corner whether it is one of some vertices. Start with one
# vertex. Find the triangles that have it. Their corners are the vertices for the next round.
#
# </details>
#
# <details><summary>Hint: from triangles to edges</summary>
#
# The edges of some triangles: you have written a function for these. To find them in the list,
# compare pairs, and mind that $(i, j)$ and $(j, i)$ are the same edge. It is not enough to look
# whether both ends belong to the ring.
#
# </details>


# %% question="05.6"
def ring(triangles, edges, vertex, rings):
    """Return an array of shape (E,), True for the edges in so many rings of the vertex.

    The triangles have shape (T, 3), the edges (E, 2); vertex and rings are whole numbers.
    """
    # BEGIN SOLUTION
    reached = [vertex]
    for _ in range(rings):
        near = triangles[np.any(np.isin(triangles, reached), axis=1)]
        reached = near
    found = {frozenset(edge) for edge in edges_of(near).tolist()}
    return np.array([frozenset(edge) in found for edge in edges.tolist()])
    # END SOLUTION


# %%
check("05.6")


# %%
@draw(vertex=Slider(0, 31, 20, "vertex", whole=True))
def rings_around(vertex):
    edges = edges_of(TRIANGLES)
    with figure(6.6, 2.5) as page:
        for k, axes in enumerate(page.subplots(1, 3), start=1):
            near = np.asarray(ring(TRIANGLES, edges, vertex, k), dtype=bool)
            for edge, chosen in zip(edges, near, strict=True):
                axes.plot(
                    *POINTS[edge].T,
                    color=ORANGE if chosen else GREY,
                    lw=1.8 if chosen else 0.6,
                    zorder=2 if chosen else 1,
                )
            axes.plot(*POINTS[vertex], "o", color="black", zorder=3)
            axes.set(
                aspect="equal",
                xticks=[],
                yticks=[],
                title=f"{('one ring', 'two rings', 'three rings')[k - 1]}: {near.sum()} edges",
            )
    return page


# %% [markdown]
# ## The system
#
# Near the vertex $\mathbf{x}_i$ we look for an affine velocity field. Let us measure places from
# the vertex, $\mathbf{y} = \mathbf{x} - \mathbf{x}_i$:
#
# $$ \mathbf{u}(\mathbf{x}) = \mathbf{c}_0 + y_1 \mathbf{c}_1 + y_2 \mathbf{c}_2, \qquad
#    \mathbf{c}_0, \mathbf{c}_1, \mathbf{c}_2 \in \mathbb{R}^2. \tag{5.4} $$
#
# These are six unknown numbers. What we want is two of them: at the vertex $\mathbf{y} =
# \mathbf{0}$, so that $\mathbf{u}(\mathbf{x}_i) = \mathbf{c}_0$. Every edge of the ring gives one
# equation,
#
# $$ \mathbf{n}_a \cdot \mathbf{u}(\mathbf{p}_a) = v_a . \tag{5.5} $$
#
# Insert (5.4), with $\mathbf{y}_a = \mathbf{p}_a - \mathbf{x}_i$ for the midpoint. The unknowns are
# multiplied by $\mathbf{n}_a^T$, $y_{a,1}\mathbf{n}_a^T$ and $y_{a,2}\mathbf{n}_a^T$. So the
# equations are
#
# $$ \mathbf{B}'\mathbf{c} = \mathbf{V}', \qquad
#    \mathbf{B}' = \begin{bmatrix} \mathbf{n}_1^T & y_{1,1}\mathbf{n}_1^T & y_{1,2}\mathbf{n}_1^T \\
#    \vdots & \vdots & \vdots \\
#    \mathbf{n}_n^T & y_{n,1}\mathbf{n}_n^T & y_{n,2}\mathbf{n}_n^T \end{bmatrix}, \qquad
#    \mathbf{c} = \begin{bmatrix} \mathbf{c}_0 \\ \mathbf{c}_1 \\ \mathbf{c}_2 \end{bmatrix}, \qquad
#    \mathbf{V}' = \begin{bmatrix} v_1 \\ \vdots \\ v_n \end{bmatrix}. \tag{5.6} $$
#
# $\mathbf{B}'$ has six columns and a row for each of the $n$ edges.
#
# ### 05.7 The matrix


# %% question="05.7"
def system(midpoints, normals, x):
    """Return B′ of (5.6), of shape (n, 6), for midpoints (n, 2), normals (n, 2), the vertex x
    (2,).
    """
    # BEGIN SOLUTION
    y = midpoints - x
    return np.hstack([normals, y[:, [0]] * normals, y[:, [1]] * normals])
    # END SOLUTION


# %%
check("05.7")

# %% [markdown]
# There are usually more equations than unknowns. As in moving least squares each may have a weight,
# larger for an edge that is close:
#
# $$ \mathbf{W}\mathbf{B}'\mathbf{c} = \mathbf{W}\mathbf{V}', \qquad
#    \mathbf{W} = \operatorname{diag}(w_1, \dots, w_n), \qquad
#    w_a = \frac{1}{\lVert \mathbf{p}_a - \mathbf{x}_i \rVert^2 + \varepsilon^2}. \tag{5.7} $$
#
# We take the coefficients that leave the smallest error $\lVert \mathbf{W}\mathbf{B}'\mathbf{c} -
# \mathbf{W}\mathbf{V}' \rVert$. With all weights equal this is plain least squares.
#
# ### 05.8 The velocity at a vertex
#
# Write a function that returns $\mathbf{u}(\mathbf{x}_i)$ for weights that are given.
#
# <details><summary>Hint</summary>
#
# Soon you will meet vertices where the six unknowns are not determined. The normal equations then
# have a singular matrix. `numpy.linalg.lstsq` still returns an answer: among all that fit equally
# well, the $\mathbf{c}$ of least length. It takes the matrix and the right side of (5.7), not of
# the normal equations.
#
# </details>


# %% question="05.8"
def velocity(midpoints, normals, v, x, w):
    """Return u at the vertex x (2,), of shape (2,), by least squares on (5.7).

    Given are midpoints (n, 2), normals (n, 2), normal velocities v (n,), and weights w (n,).
    """
    # BEGIN SOLUTION
    b = system(midpoints, normals, x)
    c = np.linalg.lstsq(w[:, np.newaxis] * b, w * v, rcond=None)[0]
    return c[:2]
    # END SOLUTION


# %%
check("05.8")

# %% [markdown]
# ## Look at it
#
# The cell below takes your functions together: the edges, what is known of the flow, and at each
# vertex the ring, the weights and the velocity. Read it; there is nothing in it that you have not
# written.


# %%
def reconstruct(points, triangles, u, rings, epsilon):
    """The velocities at all vertices, (K, 2), won back from the normal velocities of u (K, 2)."""
    edges = edges_of(triangles)
    p, n = midpoints_and_normals(points, edges)
    v = normal_velocities(edges, n, u)
    found = np.full(points.shape, np.nan)
    for i, place in enumerate(points):
        near = np.asarray(ring(triangles, edges, i, rings), dtype=bool)
        distance = np.hypot(*(p[near] - place).T)
        w = 1 / (distance**2 + epsilon**2)
        try:
            found[i] = velocity(p[near], n[near], v[near], place, w)
        except np.linalg.LinAlgError:
            pass  # singular: no arrow
    return found


@draw(
    rings=Slider(1, 3, 1, "rings", whole=True),
    epsilon=Slider(0.01, 10, 0.2, "ε", logarithmic=True),
    seed=Slider(1, 12, 3, "mesh", whole=True),
)
def reconstruction(rings, epsilon, seed):
    points, triangles = scattered(32, seed)
    u = rotation(points)
    found = reconstruct(points, triangles, u, rings, epsilon)
    missed = np.hypot(*(found - u).T)
    wrong = ~(missed < 1e-9)
    look = dict(angles="xy", scale_units="xy", scale=3.2)
    with figure(6.6, 3.9) as page:
        axes = page.subplots()
        axes.triplot(*points.T, triangles, color=GREY, lw=0.6, zorder=0)
        axes.plot(*points[wrong].T, "s", ms=11, mfc="none", color=PURPLE, label="not the truth")
        axes.quiver(*points.T, *u.T, color=BLUE, alpha=0.45, width=0.012, label="truth", **look)
        axes.quiver(*points.T, *found.T, color=ORANGE, width=0.005, label="yours", **look)
        axes.set(aspect="equal", xticks=[0, 1], yticks=[0, 1], xlim=(-0.2, 1.2), ylim=(-0.2, 1.2))
        axes.set_title(
            rf"{rings} ring{'s' * (rings > 1)}, $\varepsilon$ = {epsilon:.2g}: "
            f"{wrong.sum()} of {len(points)} wrong"
        )
        axes.legend(loc="center left", bbox_to_anchor=(1, 0.5))
    return page


# %% [markdown]
# **What to look at.**
#
# - At most vertices the two arrows lie on each other, to the last digit. Move $\varepsilon$:
#   nothing changes there. Why not?
# - Some vertices are wrong, inside too, and nothing has warned you. The wrong arrows are of the
#   right size, and some look quite credible. What have these vertices in common? Try other meshes.
#   Count triangles.
# - Take two rings.

# %% [markdown]
# ## Which vertices are determined?
#
# A velocity can be found only if no two fields give the same data. If $\mathbf{B}'$ has rank six,
# all of $\mathbf{c}$ is determined. If the rank is lower, there is a $\mathbf{c} \neq \mathbf{0}$
# with
#
# $$ \mathbf{B}'\mathbf{c} = \mathbf{0} \qquad \Longleftrightarrow \qquad
#    \mathbf{n}_a \cdot \mathbf{u}(\mathbf{p}_a) = 0 \quad \text{for all edges } a \text{ of the
#    ring}: \tag{5.8} $$
#
# an affine flow that crosses none of the edges at its midpoint. It can be added to any solution,
# and nobody notices.
#
# ### 05.9 The ranks
#
# Write a function that returns the rank of $\mathbf{B}'$ at every vertex of a mesh.
#
# A computer must decide which singular value counts as zero. The rank must not depend on where the
# mesh lies, nor on the unit of length: a mesh in millimetres has the same ranks as one in metres.
#
# <details><summary>Hint</summary>
#
# `numpy.linalg.matrix_rank` takes a tolerance `tol`: singular values below count as zero. With the
# unit of length the last four columns of $\mathbf{B}'$ change, and the first two do not. The rank
# stays what it is if each column is divided by its length. The tolerance can then be as coarse as
# $10^{-6}$, far above rounding.
#
# </details>


# %% question="05.9"
def ranks(points, triangles, rings):
    """Return the rank of B′ at each vertex, of shape (K,), for points (K, 2) and triangles (T,
    3).
    """
    # BEGIN SOLUTION
    edges = edges_of(triangles)
    midpoints, normals = midpoints_and_normals(points, edges)
    result = []
    for vertex, x in enumerate(points):
        mine = ring(triangles, edges, vertex, rings)
        b = system(midpoints[mine], normals[mine], x)
        result.append(np.linalg.matrix_rank(b / np.linalg.norm(b, axis=0), tol=1e-6))
    return np.array(result)
    # END SOLUTION


# %%
check("05.9")

# %% [markdown]
# On the left your ranks; inside the mesh, and on its boundary, the number of triangles at the
# vertex is written beside. On the right the error of the reconstruction against the rank, each
# vertex a dot.


# %%
MARKS = {3: ("v", PURPLE), 4: ("^", ORANGE), 5: ("s", BLUE), 6: ("o", GREEN)}


@draw(rings=Slider(1, 3, 1, "rings", whole=True), seed=Slider(1, 12, 3, "mesh", whole=True))
def ranks_of_a_mesh(rings, seed):
    points, triangles = scattered(32, seed)
    r = np.asarray(ranks(points, triangles, rings))
    u = rotation(points)
    missed = np.hypot(*(reconstruct(points, triangles, u, rings, 0.2) - u).T)
    count = np.bincount(triangles.ravel())
    with figure(6.8, 3.4) as page:
        left, right = page.subplots(1, 2, width_ratios=(1.5, 1))
        left.triplot(*points.T, triangles, color=GREY, lw=0.6, zorder=0)
        for rank, (mark, color) in MARKS.items():
            of = r == rank
            left.plot(*points[of].T, mark, color=color, ms=7, label=f"rank {rank}")
            right.semilogy(
                r[of] + np.linspace(-0.2, 0.2, of.sum()),
                np.maximum(missed[of], 1e-17),
                mark,
                ms=5,
                color=color,
            )
        for place, number in zip(points, count, strict=True):
            left.annotate(number, place, (4, 3), textcoords="offset points", fontsize=8)
        left.set(
            aspect="equal",
            xticks=[],
            yticks=[],
            title=f"rank with {('one ring', 'two rings', 'three rings')[rings - 1]}",
        )
        left.legend(
            loc="upper center",
            bbox_to_anchor=(0.5, -0.02),
            ncols=4,
            columnspacing=0.8,
            handletextpad=0.1,
        )
        right.set(
            xlabel=r"rank of $\mathbf{B}'$",
            ylabel="error of the velocity",
            xlim=(2.5, 6.5),
            ylim=(1e-18, 3),
            xticks=[3, 4, 5, 6],
        )
    return page


# %% [markdown]
# **What to look at.** Rank six and an error of rounding go together. With one ring an inner vertex
# with three triangles has rank four, one with four has rank five. They have six and eight edges! On
# the boundary it is other numbers. Find the rule: count, for each vertex, the *vertices* of the
# ring.
#
# ## What edges cannot see
#
# Below is a star: one vertex with some triangles around it. Where your $\mathbf{B}'$ has a rank
# less than six, the picture shows a flow of (5.8), which no edge notices. The lines are its stream
# lines. An affine flow of this kind flows along the level lines of a polynomial of degree two, so
# the stream lines are *conics*: ellipses, parabolas, hyperbolas, or pairs of lines. One of them is
# drawn thick.


# %%
def star(triangles, turn):
    """A vertex at the origin with so many triangles around it."""
    random = np.random.default_rng(triangles + 1)
    angle = (
        2
        * np.pi
        * (np.arange(triangles) + random.uniform(-0.22, 0.22, triangles) + turn)
        / triangles
    )
    radius = random.uniform(0.65, 1.15, triangles)
    rim = radius * np.exp(1j * angle)
    k = np.arange(triangles)
    return np.stack([np.r_[0, rim.real], np.r_[0, rim.imag]], axis=1), np.stack(
        [0 * k, k + 1, (k + 1) % triangles + 1], axis=1
    )


def unseen(points, triangles):
    """Coefficients c_0, c_1, c_2 of a flow that the edges of a star do not see, (3, 2); the rank
    of B′.
    """
    p, n = midpoints_and_normals(points, edges_of(triangles))
    _, sizes, rows = np.linalg.svd(np.asarray(system(p, n, np.zeros(2))))
    return rows[5].reshape(3, 2), int((sizes > 1e-9).sum())


@draw(triangles=Slider(3, 7, 4, "triangles", whole=True), turn=Slider(0, 1, 0, "turn"))
def what_edges_cannot_see(triangles, turn):
    points, cells = star(triangles, turn)
    (drift, first, second), rank = unseen(points, cells)
    x, y = np.meshgrid(*[np.linspace(-1.4, 1.4, 281)] * 2)
    psi = (
        drift[0] * y - drift[1] * x + first[0] * x * y - first[1] * x**2 / 2 + second[0] * y**2 / 2
    )
    with figure(6.4, 4.0) as page:
        axes = page.subplots()
        axes.triplot(*points.T, cells, color="black", lw=1.2)
        if rank < 6:
            axes.contour(x, y, psi, 17, colors=BLUE, linewidths=0.6, linestyles="solid")
            axes.contour(x, y, psi, [0], colors=BLUE, linewidths=2.4)
            axes.quiver(
                0, 0, *drift / np.hypot(*drift), color=ORANGE, scale=4.5, width=0.012, zorder=3
            )
        axes.plot(*points.T, "o", color="black", ms=5)
        told = (
            "an unseen flow, and its velocity at the vertex" if rank < 6 else "every flow is seen"
        )
        axes.set(aspect="equal", xticks=[], yticks=[], xlim=(-1.4, 1.4), ylim=(-1.4, 1.4))
        axes.set_title(
            f"{len(points)} vertices, {len(edges_of(cells))} edges, rank {rank}:\n{told}"
        )
    return page


# %% [markdown]
# **What to look at.** The thick conic goes through *all* vertices. Follow one edge: the conic
# leaves it at one end and comes back at the other. Whatever crosses the edge on the way out crosses
# it back, so on the whole nothing does. Now take five triangles. Through six points at random there
# is no conic.
#
# ### In words
#
# **05.10** At which vertices does the reconstruction fail, and why? State the rule that you found
# for the rank. Prove at least this: with the edges that *end* in a vertex alone, however many,
# $\mathbf{B}'$ never has rank six. Then explain why a conic through all vertices of the ring makes
# it fail, and why therefore three or four triangles inside cannot be enough. What do you do with
# such a vertex?
#
# <details><summary>Hint for the proof</summary>
#
# Find an affine flow, not zero, that runs along each of these edges. Think of a source.
#
# </details>
#
# <details><summary>Hint for the conic</summary>
#
# Let $\psi$ be a polynomial of degree two, and let $\mathbf{u} = (\partial\psi/\partial
# y_2, -\partial\psi/\partial y_1)$. It is an affine flow. By how much does $\psi$ change along an
# edge? Express it by $\mathbf{n}_a \cdot \mathbf{u}$, which is affine along the edge, and integrate
# that by its value at the midpoint. How many coefficients has $\psi$, and how many equations does
# it take to make it vanish at all vertices?
#
# </details>

# %% [markdown] answer="05.10" points=5
# *The rule.* With one ring it fails at inner vertices with three or four triangles and on the
# boundary where there are one to three. The rank is the number of vertices of the ring, or six if
# there are more than six; the exception are vertices in a special position, namely all on one
# conic.
#
# *Spokes only.* The flow $\mathbf{u}(\mathbf{x}) = \mathbf{x} - \mathbf{x}_i$ is affine and not
# zero. Every edge that ends in $\mathbf{x}_i$ has $\mathbf{p}_a - \mathbf{x}_i$ along itself, so
# $\mathbf{n}_a \cdot \mathbf{u}(\mathbf{p}_a) = 0$. This $\mathbf{c}$ is in the kernel, and the
# rank at most five.
#
# *The conic.* Let $\psi$ be quadratic and $\mathbf{u} = (\partial_2\psi, -\partial_1\psi)$. Along
# the edge from $\mathbf{x}_i$ to $\mathbf{x}_j$ the derivative of $\psi$ is, up to the sign of the
# normal, $\mathbf{n}_a\cdot\mathbf{u}$. It is affine there, so its integral is its value at the
# midpoint times the length: $\psi(\mathbf{x}_j) - \psi(\mathbf{x}_i) = \pm l_a\, \mathbf{n}_a \cdot
# \mathbf{u}(\mathbf{p}_a)$. If $\psi$ vanishes at all vertices, if they lie on the conic $\psi =
# 0$, all these are zero, and $\mathbf{u}$ is a flow of (5.8). Conversely a flow of (5.8) has no
# divergence, since by Gauss nothing flows out of a triangle, so it has such a $\psi$, which is
# equal at all vertices because the edges connect them; take the constant so that it is zero. Thus
# the kernel of $\mathbf{B}'$ is as large as the space of quadratic polynomials that vanish at all
# vertices. These have six coefficients. Five vertices or fewer are five equations or fewer: there
# is always a conic. With $N$ triangles inside, the ring has $N + 1$ vertices, so $N = 3$ gives rank
# four and $N = 4$ rank five; on the boundary there are $N + 2$.
#
# That the field is not determined need not mean that its value at the vertex is not: the velocity
# $\mathbf{c}_0$ is determined if every unseen flow is zero there. This is so where four neighbours
# lie on two lines through the vertex.
#
# *What to do.* Take a second ring where one does not suffice, and test the rank, or better the size
# of the smallest singular value: nothing else warns.

# %% [markdown] rubric="05.10"
# One point for the vertices that fail (inner with three or four triangles, boundary with few) or
# the rule by number of vertices. One for the proof for spokes. Two for the conic: one for the
# stream function and the midpoint, one for counting six coefficients against five vertices; the
# converse is not asked. One for the remedy, more edges, with a test of the rank.

# %% [markdown]
# ## Your own mesh
#
# The mesh below is yours: nobody else has it. Its vertices were numbered at random. Both fields are
# shown for one ring and for two, and besides the rotation there is a second flow, a whirl that is
# not affine.


# %%
def whirl(points, bend):
    """The rotation, slower the farther from the mean: affine for bend = 0 only."""
    u = rotation(points)
    return u / (1 + bend * np.hypot(*u.T)[:, np.newaxis] ** 2)


@draw(bend=Slider(0, 8, 0, "bend"), epsilon=Slider(0.01, 10, 0.2, "ε", logarithmic=True))
def comparison(bend, epsilon):
    points, triangles, _ = data("05.9")
    u = whirl(points, bend)
    with figure(6.8, 2.9) as page:
        panels = page.subplots(1, 3, width_ratios=(1, 1, 0.9))
        for rings, axes, color in zip((1, 2), panels, (PURPLE, ORANGE), strict=False):
            found = reconstruct(points, triangles, u, rings, epsilon)
            missed = np.hypot(*(found - u).T)
            axes.triplot(*points.T, triangles, color=GREY, lw=0.5, zorder=0)
            look = dict(angles="xy", scale_units="xy", scale=2.6)
            axes.quiver(*points.T, *u.T, color=BLUE, alpha=0.45, width=0.018, **look)
            axes.quiver(*points.T, *found.T, color=color, width=0.008, **look)
            axes.set(
                aspect="equal", xticks=[], yticks=[], title=("one ring", "two rings")[rings - 1]
            )
            axes.margins(0.25)
            order = np.sort(np.nan_to_num(missed, nan=1))
            panels[2].semilogy(
                np.maximum(order, 1e-17),
                ".-",
                ms=4,
                lw=0.8,
                color=color,
                label=("one ring", "two rings")[rings - 1],
            )
        panels[2].set(xlabel="vertices, best first", ylabel="error of the velocity")
        panels[2].legend(
            loc="upper center",
            bbox_to_anchor=(0.5, 1.2),
            ncols=2,
            columnspacing=0.8,
            handlelength=1,
        )
    return page


# %% [markdown]
# **What to look at.** For the rotation the errors with one ring are in two groups, with more than
# ten orders of magnitude between. With two rings the upper group is gone. Now bend the flow a
# little: every vertex has an error. Which part of it can weights influence? Try small and large
# $\varepsilon$, with one ring and with two.
#
# ### In words
#
# **05.11** Compare your reconstructed velocities with the truth: how large are the errors of the
# rotation, and why do neither $\varepsilon$ nor the choice between least squares and moving least
# squares matter where the rank is six? A friend who tested a program on this rotation reports that
# the method is exact. What does such a test show, and what does it not show?
#
# <details><summary>Hint</summary>
#
# The true coefficients satisfy *every* equation of (5.6). How small can the error of (5.7) then be
# made, for any weights? How many $\mathbf{c}$ reach it?
#
# </details>

# %% [markdown] answer="05.11" points=3
# Where the rank is six the errors are of the order of $10^{-15}$, rounding. The rotation is affine,
# so it is among the fields (5.4), and by question 05.5 the data are its exact normal velocities at
# the midpoints: the true coefficients satisfy all equations, and the least error of (5.7) is zero,
# whatever the weights. Positive weights do not change which $\mathbf{c}$ solves
# $\mathbf{B}'\mathbf{c} = \mathbf{V}'$, and with rank six only one does. Weights are a compromise
# between equations that contradict each other; here none do. At vertices of lower rank the error
# has the size of the velocity itself, and which of the many solutions comes out depends on the
# solver.
#
# The test shows that the program has no mistake in geometry, signs and indices, and which vertices
# are not determined. It says nothing about the error on a flow that is not affine, where the data
# (5.3) and the affine field are both approximations; nothing about noise; nor that the method is
# stable, since vertices nearly on a conic have rank six and pass the test, but enlarge every error
# of the data.

# %% [markdown] rubric="05.11"
# One point for errors of rounding where determined, and of the size of the velocity elsewhere. One
# for the reason: the truth satisfies all equations, so weights have nothing to decide. One for the
# limits of the test: it contains only an affine field, no curvature or no noise.

# %% [markdown]
# ## Dig deeper
#
# - *A cross.* Put a vertex at the origin and its four neighbours on the two axes. The rank is five.
#   Is the velocity at the vertex wrong? Look at the unseen flow there.
# - *A trap.* Cut the squares of a regular grid along diagonals that alternate. Look at the vertices
#   in the middle of a side with four triangles: six vertices, and still rank five. On which conic
#   do they lie?
# - *Nearly a conic.* Move the sixth vertex of a star slowly onto the conic through the other five.
#   How does the smallest singular value of $\mathbf{B}'$ go to zero? Add noise of size $10^{-3}$ to
#   the normal velocities. By how much is it enlarged?
# - *Order.* Take the bent whirl on meshes with more and more vertices. With which power of the
#   length of the edges does the error fall, with one ring and with two? Look at the root of the
#   mean square, and at the largest.
# - *Least length.* Where the solution is not unique `lstsq` takes the $\mathbf{c}$ of least length.
#   Multiply all coordinates by ten, and the field by ten as well. Is the answer ten times the old
#   one?

# %%
progress()
