# ---
# jupyter:
#   course:
#     builds_on:
#       "02": weights that decrease with the distance
#       "04": the matrix of normal velocities and its rank
#     pages: slides, pages 18–22 and 43
#     chapters: [14-vertex-velocities]
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
# Many flow solvers on triangle meshes store one number for each edge: the velocity across it. To
# draw the flow or to move particles in it, the whole velocity at the vertices is needed. In this
# notebook you build a mesh and a flow, compute the data of such a solver, and reconstruct the
# velocities from them. At most vertices the reconstruction is exact to rounding. At some it is
# wrong, and you can predict at which.
#
# Notebook 04 examined the system of a single star of triangles. Here the same system is solved at
# every vertex of a mesh.
#
# **Source**: Erleben, *Field Reconstruction: A Quick Survey of Methods* (the slides). **Search
# for**: face-based (staggered) finite volumes, vertex star, one-ring, weighted least squares,
# minimum-norm solution, stream function, conic. **Read**: Perot, *Conservation properties of
# unstructured staggered mesh schemes* (2000); Strang, *Introduction to Linear Algebra*, the
# chapter on the singular value decomposition.
#
# Each question asks for a function or for an answer in words. Write the function, run its cell, and
# run the check below it. The check reports whether the function is right and, if it is not, which
# mistake is likely. After a check that is not right, `case()` in a new cell shows the inputs for
# which your function failed, and your values. If everybody has the same inputs, it also shows the
# right values. Arrays may hold integers, so small that no product of them overflows. Compute with
# float64, NumPy's default type. Returned lists count as arrays, an array with one entry as a
# number, and a complex number without imaginary part as a real one. A function must not change its
# arguments.

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
    case,
    check,
    data,
    draw,
    figure,
    progress,
    start_over,
)

# %% [markdown]
# ## Normal velocities on a mesh
#
# The left picture shows a flow: two vortices of opposite rotation. The right picture shows the data
# of a solver. For each edge of the mesh there is one number, the velocity across the edge: the
# darker the edge, the larger its absolute value. Along a pale edge the fluid may be fast, but it
# does not cross the edge. Which velocity has the flow at the vertex with the question mark? Move
# the vertex.


# %%
def scattered(number, seed=3):
    """Return vertices (K, 2) and triangles (T, 3) of a mesh of the unit square."""
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


def stream(x, y):
    """Return the stream function: its difference is the flow between two points."""
    return np.sin(np.pi * x) * np.sin(2 * np.pi * y) / np.pi


@draw(vertex=Slider(0, 31, 20, "vertex", whole=True))
def the_problem(vertex):
    side = np.linspace(0, 1, 41)
    heights = stream(*np.meshgrid(side, side))
    down, along = np.gradient(heights, side, side)
    with figure(6.6, 3.2) as page:
        left, right = page.subplots(1, 2)
        left.streamplot(
            side, side, down, -along, density=0.8, color=BLUE, linewidth=0.9, arrowsize=0.8
        )
        for corners in TRIANGLES:
            for a, b in zip(POINTS[corners], POINTS[np.roll(corners, 1)], strict=True):
                crossing = abs(stream(*a) - stream(*b)) / np.hypot(*(a - b))
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
        for axes, title in ((left, "the flow"), (right, "normal velocities")):
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
# **What to look at.** Each edge has one number, and a velocity has two components. But the edges
# around a vertex have different directions, so each of them gives another component, at another
# point. This is a least-squares problem in which the data are *projections* of the velocity on
# normals.
#
# ## A finished function
#
# A triangle mesh is two arrays: the vertices $\mathbf{x}_1, \dots, \mathbf{x}_K$, of shape $(K,
# 2)$, and for each triangle the numbers of its three corners, of shape $(T, 3)$. The function below
# is finished; imitate its style. `points[triangles]` has the shape $(T, 3, 2)$: the array of
# numbers `triangles` selects three points for each triangle (*fancy indexing*).


# %%
def areas(points, triangles):
    """Return the areas, of shape (T,), for points (K, 2) and triangles (T, 3)."""
    corners = points[triangles]  # of shape (T, 3, 2)
    first = corners[:, 1] - corners[:, 0]
    second = corners[:, 2] - corners[:, 0]
    return 0.5 * np.abs(first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0])


two_triangles = np.array([[0, 1, 2], [3, 2, 1]])
four_points = np.array([[0.0, 0.0], [4.0, 0.0], [0.0, 3.0], [4.0, 3.0]])
print(areas(four_points, two_triangles))


# %% [markdown]
# ## Edges, midpoints and normals
#
# ### Example: two triangles, by hand
#
# The mesh of the last cell is a rectangle of width 4 and height 3, cut along a diagonal. The
# triangle $(0, 1, 2)$ has the sides $01$, $12$, $20$, and the triangle $(3, 2, 1)$ has the sides
# $32$, $21$, $13$. The side $12$ occurs twice, so the mesh has five edges: $01$, $02$, $12$, $13$,
# $23$.
#
# The edge $12$ goes from $(4, 0)$ to $(0, 3)$. Its midpoint is $(2, \tfrac32)$ and its length is 5.
# The vector $(-4, 3)$ along the edge is perpendicular to $(3, 4)$, so a unit normal is $(\tfrac35,
# \tfrac45)$. If the velocities at its two ends are $(1, 0)$ and $(0, 1)$, their mean is $(\tfrac12,
# \tfrac12)$. The normal velocity is $\tfrac35 \cdot \tfrac12 + \tfrac45 \cdot \tfrac12 =
# \tfrac7{10}$.
#
# ### 05.1 The edges
#
# An *edge* is a pair of vertices that is a side of a triangle. An inner edge belongs to two
# triangles, a boundary edge to one. Write a function that lists the edges, each once. The order of
# the edges, and which end of an edge comes first, are arbitrary. The corners of a triangle may be
# listed in either orientation. The triangles may be a part of a mesh, in which not every vertex
# occurs.
#
# <details><summary>Hint</summary>
#
# List the three sides of every triangle. An inner edge then occurs twice, possibly once as $(i, j)$
# and once as $(j, i)$. How can you make the two pairs equal? Then a function of NumPy keeps one of
# each. See its argument `axis`.
#
# </details>


# %% question="05.1" minutes=15
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
# be its *midpoint* and a *unit normal*. Two vectors satisfy these conditions, $\mathbf{n}_a$ and
# $-\mathbf{n}_a$. Either is right.
#
# ### 05.2 Midpoints and normals
#
# Write a function that returns both arrays, with one row for each edge. An edge may have any
# positive length and any direction, and the mesh may be far from the origin.


# %% question="05.2" minutes=15
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
# The picture shows your results on the mesh of the first picture. Are all edges there? Is each
# normal perpendicular to its edge?


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
# ## A test with a known flow
#
# A reconstruction is tested with a flow that is known. Ours is a rotation. Let
#
# $$ \mathbf{m} = \frac{1}{K} \sum_{k=1}^K \mathbf{x}_k, \qquad
#    \mathbf{u}_k = \mathbf{J}\,(\mathbf{x}_k - \mathbf{m}), \qquad
#    \mathbf{J} = \begin{bmatrix} 0 & -1 \\ 1 & 0 \end{bmatrix}. \tag{5.2} $$
#
# So $\mathbf{J}$ maps $(z_1, z_2)$ to $(-z_2, z_1)$: it rotates vectors by 90 degrees
# counter-clockwise.
#
# ### 05.3 The rotation
#
# Write a function that returns the velocities (5.2) at all vertices. There may be one point only.


# %% question="05.3" minutes=10
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
# The data of the solver are the *normal velocities*. We compute them from the velocities at the two
# ends of each edge:
#
# $$ v_a = \mathbf{n}_a \cdot \tfrac{1}{2} (\mathbf{u}_i + \mathbf{u}_j). \tag{5.3} $$
#
# The sign is positive if the fluid crosses the edge in the direction of $\mathbf{n}_a$.
#
# ### 05.4 The normal velocities
#
# Write a function that returns (5.3) for all edges.


# %% question="05.4" minutes=10
def normal_velocities(edges, normals, u):
    """Return v_a of (5.3), of shape (E,), for edges (E, 2), normals (E, 2), velocities u (K, 2)."""
    # BEGIN SOLUTION
    mean = (u[edges[:, 0]] + u[edges[:, 1]]) / 2
    return np.sum(normals * mean, axis=1)
    # END SOLUTION


# %%
check("05.4")

# %% [markdown]
# The left picture shows the flow, the right picture the data: the arrow at each midpoint is
# $v_a\mathbf{n}_a$, the component of the velocity across the edge.


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
            (right, r"data: $v_a\,\mathbf{n}_a$"),
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
# **What to look at.** The data hardly look like a rotation. An edge that points to $\mathbf{m}$ is
# crossed at full speed. An edge perpendicular to that direction is not crossed at all, since the
# fluid moves along it.
#
# ### In words
#
# **05.5** Formula (5.3) uses the mean of the velocities at the two ends of an edge for the velocity
# at its midpoint. Find the leading term of the error for a smooth field, and conclude that there is
# no error for the field (5.2).
#
# <details><summary>Hint</summary>
#
# Take the velocity along one edge as a function of one variable, and its Taylor series about the
# midpoint. Which terms cancel in the mean of the two ends? Which derivatives has the field (5.2)?
#
# </details>

# %% [markdown] answer="05.5" points=4 minutes=15 words=70
# Let $t$ be the distance from the midpoint along an edge of length $l$. The ends are at $t = \pm
# l/2$, so the odd terms of the Taylor series cancel in the mean:
#
# $$ \tfrac12(\mathbf{u}_i + \mathbf{u}_j) = \mathbf{u}(\mathbf{p}_a) + \tfrac18 l^2\,
#    \partial_t^2\mathbf{u}(\mathbf{p}_a) + O(l^4). $$
#
# The error is of second order in $l$. The field (5.2) is affine, so all its second and higher
# derivatives are zero, and the mean is exact.
#
# *Beyond the question.* The field is linear in $\mathbf{x} - \mathbf{m}$, but linear in
# $\mathbf{x}$ only if $\mathbf{m} = \mathbf{0}$. Without derivatives, by (5.1),
# $\tfrac12(\mathbf{u}_i + \mathbf{u}_j) = \mathbf{J}\left(\tfrac12(\mathbf{x}_i + \mathbf{x}_j) -
# \mathbf{m}\right) = \mathbf{u}(\mathbf{p}_a)$: an affine map takes the mean of two points to the
# mean of their images. The constant part is reproduced because the weights $\tfrac12 + \tfrac12$
# sum to one. The derivative $\mathbf{J}$ has the trace zero, so the field is free of divergence: a
# rigid rotation about $\mathbf{m}$. Halving the edges makes the error four times smaller.

# %% [markdown] rubric="05.5"
# One point for the Taylor series about the midpoint, in which the odd terms cancel. One for the
# second derivative along the edge; the factor $\tfrac18$ is not required. One for the second order
# in the length. One for the field (5.2): it is affine in $\mathbf{x}$ (linear in
# $\mathbf{x}-\mathbf{m}$), so the error is zero.

# %% [markdown]
# ## The ring of a vertex
#
# To find the velocity at one vertex we use edges around it. The edges that end in the vertex do not
# determine the field: $\mathbf{x} - \mathbf{x}_i$ is tangent to all of them. So we take all edges
# of the triangles that meet in the vertex: its *one-ring*. If this is not enough, we add the
# triangles that share at least one corner with the one-ring: the edges of all these triangles are
# the *two-ring*. In general, each further ring adds the triangles that share a corner with the
# triangles of the previous ring.
#
# ### 05.6 The ring
#
# Write a function that returns, for each edge, whether it belongs to the ring. As in 05.1, the
# triangles may be a part of a mesh. The edges are the sides of these triangles, each once, in any
# order and direction. The vertex is a corner of at least one triangle, and there is at least one
# ring.
#
# <details><summary>Hint: from a vertex to triangles</summary>
#
# `np.isin(triangles, vertices)` is True for each corner that is one of the given vertices. Start
# with one vertex, and find the triangles with this corner. All corners of these triangles are the
# vertices for the next ring.
#
# </details>
#
# <details><summary>Hint: from triangles to edges</summary>
#
# Your `edges_of` returns the edges of the triangles of the ring. To find them in the list of all
# edges, compare pairs, where $(i, j)$ and $(j, i)$ are the same edge. It is not enough that both
# ends are vertices of the ring.
#
# </details>


# %% question="05.6" minutes=20
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
# Near the vertex $\mathbf{x}_i$ we look for an affine velocity field. With $\mathbf{y} =
# \mathbf{x} - \mathbf{x}_i$, the position relative to the vertex, it is
#
# $$ \mathbf{u}(\mathbf{x}) = \mathbf{c}_0 + y_1 \mathbf{c}_1 + y_2 \mathbf{c}_2, \qquad
#    \mathbf{c}_0, \mathbf{c}_1, \mathbf{c}_2 \in \mathbb{R}^2. \tag{5.4} $$
#
# There are six unknown numbers. Two of them are the result, since $\mathbf{y} = \mathbf{0}$ at the
# vertex: $\mathbf{u}(\mathbf{x}_i) = \mathbf{c}_0$. Every edge of the ring gives one equation,
#
# $$ \mathbf{n}_a \cdot \mathbf{u}(\mathbf{p}_a) = v_a . \tag{5.5} $$
#
# Inserting (5.4), with $\mathbf{y}_a = \mathbf{p}_a - \mathbf{x}_i$ for the midpoint, gives the
# system of notebook 04 with the origin at the vertex:
#
# $$ \mathbf{B}'\mathbf{c} = \mathbf{V}', \qquad
#    \mathbf{B}' = \begin{bmatrix} \mathbf{n}_1^T & y_{1,1}\mathbf{n}_1^T & y_{1,2}\mathbf{n}_1^T \\
#    \vdots & \vdots & \vdots \\
#    \mathbf{n}_n^T & y_{n,1}\mathbf{n}_n^T & y_{n,2}\mathbf{n}_n^T \end{bmatrix}, \qquad
#    \mathbf{c} = \begin{bmatrix} \mathbf{c}_0 \\ \mathbf{c}_1 \\ \mathbf{c}_2 \end{bmatrix}, \qquad
#    \mathbf{V}' = \begin{bmatrix} v_1 \\ \vdots \\ v_n \end{bmatrix}. \tag{5.6} $$
#
# $\mathbf{B}'$ has six columns and a row for each of the $n$ edges. By hand: for the vertex $(4,
# 0)$ and the midpoint $(2, \tfrac32)$ of the example, $\mathbf{y}_a = (-2, \tfrac32)$. With the
# normal $(\tfrac35, \tfrac45)$ the row is $(0.6, 0.8, -1.2, -1.6, 0.9, 1.2)$.
#
# ### 05.7 The matrix
#
# Write $\mathbf{B}'$ of (5.6). The matrix is that of 04.1. New is the origin, which is the vertex
# and no longer fixed: so the first two unknowns are the velocity at the vertex, wherever the mesh
# lies. If you have written 04.1, copy it into the cell and call it. Think of the points that you
# give to it.


# %% question="05.7" minutes=10
def system(midpoints, normals, x):
    """Return B′ of (5.6), of shape (n, 6).

    Midpoints and normals have the shape (n, 2), the vertex x has (2,).
    """
    # BEGIN SOLUTION
    y = midpoints - x
    return np.hstack([normals, y[:, [0]] * normals, y[:, [1]] * normals])
    # END SOLUTION


# %%
check("05.7")

# %% [markdown]
# There are usually more equations than unknowns. As in moving least squares (notebook 02), each
# equation has a weight that decreases with the distance of the edge:
#
# $$ \mathbf{W}\mathbf{B}'\mathbf{c} = \mathbf{W}\mathbf{V}', \qquad
#    \mathbf{W} = \operatorname{diag}(w_1, \dots, w_n), \qquad
#    w_a = \frac{1}{\lVert \mathbf{p}_a - \mathbf{x}_i \rVert^2 + \varepsilon^2}. \tag{5.7} $$
#
# We take the coefficients with the smallest residual $\lVert \mathbf{W}\mathbf{B}'\mathbf{c} -
# \mathbf{W}\mathbf{V}' \rVert$; if several have it, those of least norm. With equal weights this is
# plain least squares.
#
# ### 05.8 The velocity at a vertex
#
# Write a function that returns $\mathbf{u}(\mathbf{x}_i)$ for given weights. The mesh is near the
# origin, and may have any size from $10^{-8}$ to $10^8$.
#
# <details><summary>Hint</summary>
#
# At some vertices the six unknowns are not determined, and the matrix of the normal equations is
# singular. `numpy.linalg.lstsq` still returns a solution, the *minimum-norm solution*: among all
# that fit equally well, the $\mathbf{c}$ of least norm. Its arguments are the matrix and the
# right-hand side of (5.7), not of the normal equations. Its default tolerance, with `rcond=None`,
# is suitable: singular values that are rounding errors count as zero. That of `numpy.linalg.pinv`
# is smaller, and may be too small.
#
# </details>


# %% question="05.8" minutes=10
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
# ## The reconstruction
#
# The next cell calls your functions one after the other: the edges, their normal velocities, and at
# each vertex the ring, the weights and the velocity. Read it.


# %%
def reconstruct(points, triangles, u, rings, epsilon):
    """Return velocities (K, 2) reconstructed from the normal velocities of u (K, 2)."""
    edges = edges_of(triangles)
    p, n = midpoints_and_normals(points, edges)
    v = normal_velocities(edges, n, u)
    found = np.full(points.shape, np.nan)
    for i, vertex in enumerate(points):
        near = np.asarray(ring(triangles, edges, i, rings), dtype=bool)
        distance = np.hypot(*(p[near] - vertex).T)
        w = 1 / (distance**2 + epsilon**2)
        try:
            found[i] = velocity(p[near], n[near], v[near], vertex, w)
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
        axes.plot(*points[wrong].T, "s", ms=11, mfc="none", color=PURPLE, label="error above 1e-9")
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
# - At most vertices the two arrows agree to rounding. They do not change with $\varepsilon$. Why
#   not?
# - At some vertices the result is wrong, also inside the mesh, and no warning was issued. With
#   `lstsq` the wrong arrows have a credible length. A solver of the normal equations stops there,
#   or returns arrows of any length. What do these vertices have in common? Try other meshes, and
#   count triangles.
# - Take two rings.

# %% [markdown]
# ## The rank at each vertex
#
# The field is determined only if no other field gives the same data. If $\mathbf{B}'$ has rank
# six, all of $\mathbf{c}$ is determined. If the rank is lower, there is a $\mathbf{c} \neq
# \mathbf{0}$ with
#
# $$ \mathbf{B}'\mathbf{c} = \mathbf{0} \qquad \Longleftrightarrow \qquad
#    \mathbf{n}_a \cdot \mathbf{u}(\mathbf{p}_a) = 0 \quad \text{for all edges } a \text{ of the
#    ring}: \tag{5.8} $$
#
# an affine flow that is tangent to all edges of the ring at their midpoints. It can be added to
# every solution without changing the data.
#
# ### 05.9 The ranks
#
# Write a function that returns the rank of $\mathbf{B}'$ at every vertex of a mesh. In 04.2 the
# samples of one vertex were given. New here are the samples, which your functions select for each
# vertex, and the scaling: the points are not scaled, but each column of $\mathbf{B}'$ is divided by
# its norm. Count singular values below $10^{-6}$ as zero, however large the others are (none lies
# between $10^{-7}$ and $10^{-5}$): far from the origin the rounding errors are close to $10^{-9}$,
# the tolerance of 04.2. The rank must depend neither on the position of the mesh nor on the unit of
# length: a mesh in millimetres has the same ranks as one in metres. Every point is a corner of at
# least one triangle.
#
# <details><summary>Hint</summary>
#
# `numpy.linalg.matrix_rank` has a tolerance `tol`: smaller singular values count as zero. A change
# of the unit scales the last four columns of $\mathbf{B}'$, but not the first two. Dividing each
# column by its norm does not change the rank, and makes it independent of the unit. Then a
# tolerance of $10^{-6}$ is far above the rounding errors.
#
# </details>


# %% question="05.9" minutes=25
def ranks(points, triangles, rings):
    """Return the rank of B′ at each vertex, of shape (K,).

    The points have the shape (K, 2), the triangles (T, 3).
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
# The left picture shows your ranks. The number beside each vertex is the number of its triangles.
# The right picture shows the error of the reconstruction against the rank, with one mark for each
# vertex.

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
# **What to look at.** At vertices of rank six the error is of the size of rounding errors. With one
# ring an inner vertex with three triangles has rank four, and one with four triangles has rank
# five. They have six and eight edges. At the boundary the numbers differ. Find the rule: count, for
# each vertex, the *vertices* of its ring.
#
# ## Tangent flows and conics
#
# The next picture shows a star: one vertex and the triangles around it. If your $\mathbf{B}'$ has a
# rank less than six, the picture shows the stream lines of a tangent flow (5.8). They are level
# lines of a polynomial of degree two, so they are *conics*: ellipses, parabolas, hyperbolas, or
# pairs of lines. One of them is thick. Question 04.7 has the same conic.


# %%
def star(triangles, turn):
    """Return points and triangles of a star around a vertex at the origin."""
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


def tangent_flow(points, triangles):
    """Return coefficients (3, 2) of a tangent flow of the edges of a star, and the rank of B′."""
    p, n = midpoints_and_normals(points, edges_of(triangles))
    _, sizes, rows = np.linalg.svd(np.asarray(system(p, n, np.zeros(2))))
    return rows[5].reshape(3, 2), int((sizes > 1e-9).sum())


@draw(triangles=Slider(3, 7, 4, "triangles", whole=True), turn=Slider(0, 1, 0, "turn"))
def tangent_flows(triangles, turn):
    points, cells = star(triangles, turn)
    (drift, first, second), rank = tangent_flow(points, cells)
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
        title = "a tangent flow, and its velocity at the vertex" if rank < 6 else "no tangent flow"
        axes.set(aspect="equal", xticks=[], yticks=[], xlim=(-1.4, 1.4), ylim=(-1.4, 1.4))
        axes.set_title(
            f"{len(points)} vertices, {len(edges_of(cells))} edges, rank {rank}:\n{title}"
        )
    return page


# %% [markdown]
# **What to look at.** The thick conic passes through *all* vertices. Follow one edge: the conic
# leaves it at one end and returns at the other. So the flow across the edge is zero in total. Now
# take five triangles. In general no conic passes through six points.
#
# ### In words
#
# **05.10** Let $\psi \neq 0$ be a polynomial of degree at most two that vanishes at all vertices of
# a ring; its zeros are a conic. Show that $\mathbf{u} = (\partial\psi/\partial y_2,
# -\partial\psi/\partial y_1)$ is a flow of (5.8) and not zero, so that the reconstruction fails.
#
# <details><summary>Hint</summary>
#
# How much does $\psi$ change along an edge? Express the change by $\mathbf{n}_a \cdot \mathbf{u}$,
# which is affine along the edge, and integrate it by its value at the midpoint.
#
# </details>

# %% [markdown] answer="05.10" points=5 minutes=20 words=110
# Since $\psi$ is quadratic, $\mathbf{u}$ is affine. It is not zero, since $\psi \neq 0$ vanishes at
# the vertices and so is not constant. Along the edge from $\mathbf{x}_i$ to $\mathbf{x}_j$, of
# length $l_a$, the derivative of $\psi$ is $\mathbf{n}_a\cdot\mathbf{u}$, up to the sign of the
# normal. This is an affine function along the edge, so its integral is the length times its value
# in the middle:
#
# $$ \psi(\mathbf{x}_j) - \psi(\mathbf{x}_i)
#    = \pm l_a\, \mathbf{n}_a \cdot \mathbf{u}(\mathbf{p}_a). $$
#
# The left-hand side is zero for all edges of the ring, so $\mathbf{u}$ is a flow of (5.8). It can
# be added to every solution, so the data do not determine the velocity field.
#
# *Beyond the question.* A ring with at most five vertices always has such a $\psi$: six
# coefficients satisfy at most five homogeneous linear equations. An inner vertex with $k$ triangles
# has $k + 1$ vertices in its ring, a boundary vertex has $k + 2$. So the rank is less than six at
# inner vertices with three or four triangles, and at boundary vertices with one to three. The
# converse holds too. By the theorem of Gauss nothing flows out of a triangle in a flow of (5.8), so
# this flow has no divergence and such a $\psi$. It is equal at all vertices, because the edges
# connect them; choose the constant so that it is zero there. So the null space of $\mathbf{B}'$ is
# as large as the space of quadratic polynomials that vanish at all vertices. The rank is the number
# of vertices of the ring, at most six, unless they are in special position. For six or more
# vertices the special position is that all are on one conic. The velocity $\mathbf{c}_0$ at the
# vertex is still determined if every tangent flow is zero there. This is so where four neighbours
# lie on two lines through the vertex. The remedy is a second ring where one is not enough, with a
# test of the rank, or better of the smallest singular value.

# %% [markdown] rubric="05.10"
# One point for an affine flow. One for the reason that it is not zero. One for the change of $\psi$
# along an edge as the integral of the normal velocity. One for the value at the midpoint, by which
# the integral is given. One for the conclusion: the value is zero, and the flow can be added to
# every solution.

# %% [markdown]
# ## Your own mesh
#
# The next mesh is your own, with vertices in random order. Both fields are shown for one ring and
# for two. Besides the rotation there is a second flow, a vortex that is not affine.


# %%
def vortex(points, bend):
    """Return a rotation that is slower far from the mean: affine for bend = 0 only."""
    u = rotation(points)
    return u / (1 + bend * np.hypot(*u.T)[:, np.newaxis] ** 2)


@draw(bend=Slider(0, 8, 0, "bend"), epsilon=Slider(0.01, 10, 0.2, "ε", logarithmic=True))
def comparison(bend, epsilon):
    points, triangles, _ = data("05.9")
    u = vortex(points, bend)
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
        panels[2].set(xlabel="vertices, by error", ylabel="error of the velocity")
        panels[2].legend(
            loc="upper center",
            bbox_to_anchor=(0.5, 1.2),
            ncols=2,
            columnspacing=0.8,
            handlelength=1,
        )
    return page


# %% [markdown]
# **What to look at.** For the rotation with one ring the errors form two groups, more than ten
# orders of magnitude apart. With two rings the upper group has disappeared. Now set the bend to a
# small value: every vertex has an error. Which part of it depends on the weights? Try small and
# large $\varepsilon$, with one ring and with two.
#
# ### In words
#
# **05.11** A program reconstructs the rotation (5.2) exactly to rounding at all vertices of rank
# six, for every $\varepsilon$. Explain this result.
#
# <details><summary>Hint</summary>
#
# The true coefficients satisfy *every* equation of (5.6). What is then the smallest residual of
# (5.7), for any weights? How many $\mathbf{c}$ have this residual?
#
# </details>

# %% [markdown] answer="05.11" points=3 minutes=15 words=60 optional
# The rotation is affine, so it is among the fields (5.4). By question 05.5 the data are its exact
# normal velocities at the midpoints. So the true coefficients satisfy all equations, and the
# smallest residual of (5.7) is zero, whatever the positive weights. With rank six no other
# $\mathbf{c}$ has this residual.
#
# *Beyond the question.* Weights are a compromise between equations that contradict each other; here
# none do. At vertices of lower rank the error has the size of the velocity itself, and the solver
# determines which of the many solutions is returned. The test shows that the program has no mistake
# in geometry, signs and indices, and which vertices are not determined. It contains only an affine
# field. So it does not show the error for a flow that is not affine, for which (5.3) and (5.4) are
# approximations. Nor does it show the effect of noise, or that the method is stable: vertices
# nearly on a conic have rank six and pass the test, but they magnify every error of the data.

# %% [markdown] rubric="05.11"
# One point for the reason that the true coefficients satisfy all equations: the field is affine,
# and the data are exact. One for the residual, which is zero for all weights. One for uniqueness by
# rank six.

# %% [markdown]
# ## Dig deeper
#
# - *A cross.* Put a vertex at the origin and its four neighbours on the two axes. The rank is five.
#   Is the velocity at the vertex wrong? Consider the tangent flow there.
# - *A trap.* Cut the squares of a regular grid along alternating diagonals. Consider the vertices
#   in the middle of a side with four triangles: six vertices, and still rank five. On which conic
#   do they lie?
# - *Nearly a conic.* Move the sixth vertex of a star slowly onto the conic through the other five.
#   How does the smallest singular value of $\mathbf{B}'$ tend to zero? Add noise of size $10^{-3}$
#   to the normal velocities. By which factor is it magnified?
# - *Order.* Take the bent vortex on finer and finer meshes. With which power of the edge length
#   does the error decrease, with one ring and with two? Consider the root-mean-square error and the
#   largest error.
# - *Minimum norm.* Where the solution is not unique, `lstsq` returns the $\mathbf{c}$ of least
#   norm. Multiply all coordinates and the field by ten. Is the new result ten times the old one?

# %%
progress()
