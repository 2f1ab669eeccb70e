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
# # The rank of a velocity system
#
# Simulations of fluids often know only what flows *across* the edges of a mesh: one number for each
# edge. The whole velocity has to be found from many such numbers. When can it be found, and when is
# there a flow that no edge sees? By the end of this notebook you can answer for any points and any
# normals, and you know why "six equations for six unknowns" proves nothing.
#
# Each question asks for a function. Write it, run its cell, and run the check below it.

# %% tags=["setup"]
import numpy as np

from fieldcheck import (
    BLUE,
    GREY,
    ORANGE,
    Slider,
    check,
    data,
    draw,
    figure,
    progress,
    start_over,
)


def velocity(c, x):
    """Return u of (4.1) at places x of shape (M, 2), for coefficients c of shape (6,)."""
    c_0, c_1, c_2 = np.reshape(c, (3, 2))
    return c_0 + np.outer(x[:, 0], c_1) + np.outer(x[:, 1], c_2)


# %% [markdown]
# The next cell draws edges and flows. Run it; you need not read it.


# %%
def draw_edges(axes, points, normals, length=0.14):
    """Draw samples as short edges, each with a thin line along its normal."""
    along = 0.5 * length * normals[:, ::-1] * np.array([-1, 1])
    for p, t, n in zip(points, along, 0.5 * length * normals, strict=True):
        axes.plot(*np.transpose([p - t, p + t]), color=BLUE, lw=2.4, solid_capstyle="round")
        axes.plot(*np.transpose([p, p + n]), color=BLUE, lw=0.8)
    axes.set(aspect="equal", xlim=(-0.1, 1.1), ylim=(-0.1, 1.1))
    axes.set_axis_off()


def draw_flow(axes, c, color=GREY):
    """Draw the stream lines of an affine velocity field."""
    side = np.linspace(-0.1, 1.1, 40)
    x, y = np.meshgrid(side, side)
    u = velocity(c, np.stack([x.ravel(), y.ravel()], axis=1))
    axes.streamplot(
        x, y, *u.T.reshape(2, 40, 40), color=color, linewidth=0.8, density=0.7, arrowsize=0.7
    )


def turned(normals, degrees):
    """Return normals turned to the left, by one angle or by one for each."""
    a, b = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    x, y = normals.T
    return np.stack([a * x - b * y, b * x + a * y], axis=1)


# %% [markdown]
# ## The problem in a picture
#
# Six edges. On each of them the velocity across it is measured, and nothing else. Grey is one flow,
# orange another: at zero they are the same. Move the slider. What changes on the left? And on the
# right, where the measurements are?


# %%
@draw(amount=Slider(-1, 1, 0.6, "amount"))
def two_flows(amount):
    points = np.array([[0.0, 0.35], [0.2, 0.9], [0.35, 0.15], [0.5, 0.75], [0.8, 0.4], [0.75, 0.9]])
    middle = np.array([0.35, 0.5])
    normals = (points - middle) / np.linalg.norm(points - middle, axis=1)[:, None]
    one = np.array([0.3, 0.1, 0.2, 0.1, 0.0, -0.3])
    other = one + amount * np.array([middle[1], -middle[0], 0, 1, -1, 0])
    with figure(6.4, 2.9) as page:
        left, right = page.subplots(1, 2)
        draw_edges(left, points, normals)
        for k, (p, n) in enumerate(zip(points, normals, strict=True), start=1):
            left.annotate(str(k), p - 0.14 * n, ha="center", va="center", color=BLUE)
        for k, (c, color) in enumerate(((one, GREY), (other, ORANGE))):
            flow = velocity(c, points)
            left.quiver(*points.T, *flow.T, color=color, scale=3, width=0.012)
            across = np.einsum("nd,nd->n", normals, flow)
            right.bar(np.arange(1, 7) + 0.4 * k - 0.2, across, 0.36, color=color)
        left.set(xlim=(-0.15, 1.15), ylim=(-0.05, 1.1))
        right.axhline(0, color="black", lw=0.8)
        right.set(xlabel="edge", ylabel="velocity across it", ylim=(-0.6, 0.6))
    return page


# %% [markdown]
# Two different flows, the same six numbers. Whoever has only the numbers cannot know which it was.
# Why does it happen for these six edges?
#
# ## The system
#
# Let the velocity be affine near the samples. In the plane
#
# $$ \mathbf{u}(\mathbf{x}) = \mathbf{c}_0 + x\,\mathbf{c}_1 + y\,\mathbf{c}_2, \qquad
#    \mathbf{c}_0, \mathbf{c}_1, \mathbf{c}_2 \in \mathbb{R}^2 , \tag{4.1} $$
#
# where $\mathbf{x} = (x, y)^T$. At the place $\mathbf{p}_i = (x_i, y_i)^T$ the component along the
# unit normal $\mathbf{n}_i$ is known,
#
# $$ \mathbf{n}_i^T \mathbf{u}(\mathbf{p}_i) = v_i , \qquad i = 1, \dots, N . \tag{4.2} $$
#
# These are $N$ linear equations $\mathbf{B}'\mathbf{c} = \mathbf{V}'$ for the six numbers
# $\mathbf{c} = (\mathbf{c}_0, \mathbf{c}_1, \mathbf{c}_2)$:
#
# $$ \mathbf{B}' = \begin{bmatrix} \mathbf{n}_1^T & x_1\mathbf{n}_1^T & y_1\mathbf{n}_1^T \\
#    \vdots & \vdots & \vdots \\ \mathbf{n}_N^T & x_N\mathbf{n}_N^T & y_N\mathbf{n}_N^T
#    \end{bmatrix},
#    \qquad \mathbf{V}' = \begin{bmatrix} v_1 \\ \vdots \\ v_N \end{bmatrix}. \tag{4.3} $$
#
# In space there is a fourth block $z_i\mathbf{n}_i^T$; in $D$ dimensions there are $D + D^2$
# columns.
#
# ### 04.1 The matrix
#
# Write $\mathbf{B}'$ with its columns in the order of (4.3): first those of $\mathbf{c}_0$, all its
# components, then those of $\mathbf{c}_1$, and so on.
#
# <details><summary>Hint</summary>
#
# One block is the array of normals itself. What must each row of it be multiplied by to make the
# next? Numbers of shape $(N,)$ multiply rows if they are given the shape $(N, 1)$, as `a[:, None]`
# has.
#
# </details>


# %% question="04.1"
def velocity_matrix(points, normals):
    """Return B' of (4.3), of shape (N, D + D²), for points and normals of shape (N, D)."""
    # BEGIN SOLUTION
    blocks = [normals]
    for coordinate in points.T:
        blocks.append(coordinate[:, np.newaxis] * normals)
    return np.hstack(blocks)
    # END SOLUTION


# %%
check("04.1")

# %% [markdown]
# ## The rank
#
# The flow is determined by its samples exactly if $\mathbf{B}'$ has *full column rank*: six in the
# plane. In 01 you have seen that counting points is not enough. Here it is not enough either.
#
# ### 04.2 The rank
#
# Write a function that returns the rank of $\mathbf{B}'$. It must not depend on where the origin
# is, nor on the unit of length; normals are unit vectors. And what is zero but for rounding is
# zero.
#
# <details><summary>Hint</summary>
#
# Moving all points together changes $\mathbf{c}_0$ and not what can be known. So does another unit.
# Bring the points to the origin and to the size one first. Then one tolerance fits all.
#
# </details>


# %% question="04.2"
def velocity_rank(points, normals):
    """Return the rank of B' for points and unit normals of shape (N, D), a whole number."""
    # BEGIN SOLUTION
    moved = points - points.mean(axis=0)
    b = velocity_matrix(moved / np.ptp(moved), normals)
    return np.linalg.matrix_rank(b, tol=1e-9)
    # END SOLUTION


# %%
check("04.2")


# %%
@draw()
def four_ranks():
    random = np.random.default_rng(11)
    points = data("04.2")[0]
    middle = np.array([0.47, 0.52])
    radial = (points - middle) / np.linalg.norm(points - middle, axis=1)[:, None]
    up = np.tile([0.0, 1.0], (8, 1))
    cases = {
        "at random": turned(up, random.uniform(0, 360, 8)),
        "parallel": up,
        "two not parallel": turned(up, [0, 50, 0, 0, 0, 0, -20, 0]),
        "through one place": radial,
    }
    with figure(6.4, 2.1) as page:
        for axes, (name, normals) in zip(page.subplots(1, 4), cases.items(), strict=True):
            draw_edges(axes, points, normals)
            axes.set(title=f"{name}:\nrank {velocity_rank(points, normals)}")
    return page


# %% [markdown]
# **What to look at.** The eight points, your own, are the same each time, and $\mathbf{B}'$ has
# eight rows each time. Only the normals differ. The second and the third loss can be guessed. The
# last cannot: no two of its normals are parallel.
#
# ## What is lost
#
# If the rank is less than six there is a vector $\mathbf{c} \neq \mathbf{0}$ with
#
# $$ \mathbf{B}'\mathbf{c} = \mathbf{0} \quad\Longleftrightarrow\quad
#    \mathbf{n}_i^T \mathbf{u}(\mathbf{p}_i) = 0 \ \text{ for all } i . \tag{4.4} $$
#
# Read the right side: $\mathbf{u}$ is an affine flow that runs *along* every edge. No edge sees it,
# so it can be added to any solution. That is the whole truth about the rank: it is full if and only
# if no affine flow other than zero is tangent to all samples.
#
# ### 04.3 The flow that no edge sees
#
# For samples with $\operatorname{rank}\mathbf{B}' = 5$ return the coefficients $\mathbf{c}$ of such
# a flow. Its size and sign are up to you, but it must not be zero.
#
# <details><summary>Hint</summary>
#
# `np.linalg.svd` returns three arrays. The rows of the last one are at right angles to each other.
# What does $\mathbf{B}'$ do to each of them?
#
# </details>


# %% question="04.3"
def tangent_field(points, normals):
    """Return c ≠ 0 of (4.4), of shape (6,), for points and normals of shape (N, 2) and rank 5."""
    # BEGIN SOLUTION
    rows = np.linalg.svd(velocity_matrix(points, normals))[2]
    return rows[-1]
    # END SOLUTION


# %%
check("04.3")

# %% [markdown]
# ### 04.4 The other way round
#
# Take any affine flow and any points. Which normals hide this flow? Return one unit normal for each
# point, of either sign. `velocity(c, points)` is written for you.


# %% question="04.4"
def crossing_normals(points, c):
    """Return unit normals (N, 2) with n_i · u(p_i) = 0, for points (N, 2) and c of shape (6,)."""
    # BEGIN SOLUTION
    u, v = velocity(c, points).T
    return np.column_stack([-v, u]) / np.hypot(u, v)[:, np.newaxis]
    # END SOLUTION


# %%
check("04.4")

# %% [markdown]
# ## Look at it
#
# Five flows, the same ten points. The normals are yours, from 04.4; the stream lines are yours too,
# from 04.3, which knows nothing of the flow but the normals.


# %%
@draw()
def five_flows():
    points = np.stack([np.arange(10) / 9, 0.618 * np.arange(3, 13) % 1], axis=1)
    flows = {
        "rotation": [0.5, -0.5, 0, 1, -1, 0],
        "expansion": [-0.5, -0.5, 1, 0, 0, 1],
        "spiral": [0.2, -0.8, 0.6, 1, -1, 0.6],
        "saddle": [-0.5, 0.5, 1, 0, 0, -1],
        "parabolas": [1, -2, 0, 4, 0, 0],
    }
    with figure(6.6, 2.0) as page:
        for axes, (name, c) in zip(page.subplots(1, 5), flows.items(), strict=True):
            normals = crossing_normals(points, np.array(c))
            draw_flow(axes, tangent_field(points, normals))
            draw_edges(axes, points, normals)
            axes.set(title=f"{name}:\nrank {velocity_rank(points, normals)}")
    return page


# %% [markdown]
# **What to look at.** Every affine flow hides from *some* edges at *any* points. Ten equations, six
# unknowns, no two normals parallel, and the rank is five.
#
# ### Turn the normals until the rank drops
#
# Six samples that hide a rotation. Turn one normal, or all of them together, and watch the smallest
# singular value of $\mathbf{B}'$: the rank is lost where it is zero.


# %%
@draw(
    one=Slider(-90, 90, 0, "turn one", steps=60),
    together=Slider(-90, 90, 0, "turn all", steps=60),
)
def turning(one, together):
    points = np.random.default_rng(8).random((6, 2))
    hidden = crossing_normals(points, np.array([0.5, -0.5, 0, 1, -1, 0]))

    def smallest(angle, of_all):
        n = turned(hidden, of_all + angle * (np.arange(6) == 2))
        return np.linalg.svd(velocity_matrix(points, n), compute_uv=False)[-1]

    angles = np.linspace(-90, 90, 121)
    normals = turned(hidden, together + one * (np.arange(6) == 2))
    rank = int(velocity_rank(points, normals))
    with figure(6.4, 2.9) as page:
        left, right = page.subplots(1, 2, width_ratios=(2, 3))
        if rank < 6:
            draw_flow(left, tangent_field(points, normals))
        draw_edges(left, points, normals)
        left.plot(*points[2], "o", color=ORANGE)
        left.set(title=f"rank {rank}" + ("" if rank == 6 else ", and what is not seen"))
        right.plot(angles, [smallest(a, together) for a in angles], color=GREY, label="turn one")
        right.plot(angles, [smallest(one, a) for a in angles], "--", color=BLUE, label="turn all")
        right.plot(one, smallest(one, together), "o", ms=8, color=ORANGE)
        right.set(xlabel="angle in degrees", ylabel="smallest singular value", ylim=(-0.01, None))
        right.legend()
    return page


# %% [markdown]
# **What to look at.** Turn the one normal (orange dot). The rank is six at once, but the smallest
# singular value grows only in proportion to the angle: near zero there is a flow that is seen, and
# hardly, and an error of measurement becomes a large error of that flow. Now put it back, and turn
# all six together. The value stays at zero! Which flow do they hide at 45 degrees, and which at 90?
# You find both among the five flows above.

# %% [markdown]
# ## The obvious conditions
#
# Some losses can be seen with the naked eye. Suppose that all points $\mathbf{p}_i$ are such that
# $\mathbf{B}$, with the rows $(1, x_i, y_i)$, has full column rank three: they are not on one line.
# What must hold of the normals?
#
# Consider flows of one fixed direction $\mathbf{m}$, as wind from the west that is stronger in the
# north: $\mathbf{u}(\mathbf{x}) = \alpha(\mathbf{x})\,\mathbf{m}$ with an affine function $\alpha$.
# A sample says something about it only if $\mathbf{n}_i^T\mathbf{m} \neq 0$. These samples must
# determine $\alpha$, so their points must not be on one line either:
#
# $$ \text{for every direction } \mathbf{m} \neq \mathbf{0} \text{ the points } \mathbf{p}_i \text{
#    with }
#    \mathbf{n}_i^T\mathbf{m} \neq 0 \text{ are not on one line.} \tag{4.5} $$
#
# ### 04.5 Are they fulfilled?
#
# Write a function that returns whether (4.5) holds. There are infinitely many directions; for which
# of them can the condition say more than that all points are not on one line?
#
# <details><summary>Hint</summary>
#
# A sample is left out for exactly one direction and its opposite. So there are at most $N$
# directions to try. Points are not on one line if $\mathbf{B}$, made of them, has rank three. The
# same test does for few points, and for none.
#
# </details>


# %% question="04.5"
def obvious(points, normals):
    """Return whether (4.5) holds, True or False, for points and unit normals of shape (N, 2)."""
    # BEGIN SOLUTION
    b = np.column_stack([np.ones(len(points)), points])
    for n in normals:
        m = np.array([-n[1], n[0]])
        seen = np.abs(normals @ m) > 1e-9
        if np.linalg.matrix_rank(b[seen], tol=1e-9) < 3:
            return False
    return True
    # END SOLUTION


# %%
check("04.5")


# %%
@draw()
def obvious_or_not():
    random = np.random.default_rng(21)
    points = np.array([[0.1, 0.2], [0.9, 0.1], [0.5, 0.55], [0.15, 0.9], [0.85, 0.8], [0.45, 0.05]])
    line = np.array([[0.0, 0.1], [0.2, 0.26], [0.4, 0.42], [0.6, 0.58], [0.8, 0.74], [0.2, 0.9]])
    up = np.tile([0.0, 1.0], (6, 1))
    cases = [
        ("parallel", points, up),
        ("two others", points, turned(up, [0, 60, 0, 0, -40, 0])),
        ("three others", points, turned(up, [0, 60, 90, 0, -40, 0])),
        ("five in line", line, turned(up, random.uniform(0, 180, 6))),
        ("a rotation", points, crossing_normals(points, np.array([0.35, -0.6, 0, 1, -1, 0]))),
    ]
    with figure(6.6, 2.2) as page:
        for axes, (name, p, n) in zip(page.subplots(1, 5), cases, strict=True):
            draw_edges(axes, p, n)
            told = "holds" if obvious(p, n) else "fails"
            axes.set(title=f"{name}:\n(4.5) {told},\nrank {velocity_rank(p, n)}")
    return page


# %% [markdown]
# **What to look at.** Where (4.5) fails the rank is less than six, always. But it may hold, and the
# rank is less all the same. And look at the fourth picture: five points on a line and one beside
# it. Its normals are random, and whatever they are, the rank will not be six. Can you find the
# flow?

# %% [markdown]
# ## Stars of triangles
#
# In a mesh the normals are not free: they belong to edges. Take a vertex with the triangles round
# it, and sample at the midpoints of *all* edges of these triangles: $k$ spokes and $k$ edges of the
# rim.
#
# ### 04.6 The samples of a star
#
# Write a function that returns the midpoints and the unit normals: first of the spokes, in the
# order of the neighbours, then of the rim, from each neighbour to the next, and from the last to
# the first.


# %% question="04.6"
def star_samples(center, ring):
    """Return points and unit normals, both (2k, 2), for a center (2,) and neighbours (k, 2)."""
    # BEGIN SOLUTION
    following = np.concatenate([ring[1:], ring[:1]])
    start = np.concatenate([np.tile(center, (len(ring), 1)), ring])
    end = np.concatenate([ring, following])
    x, y = (end - start).T
    return (start + end) / 2, np.column_stack([-y, x]) / np.hypot(x, y)[:, np.newaxis]
    # END SOLUTION


# %%
check("04.6")

# %% [markdown]
# ### 04.7 A rank without any normals
#
# For such samples there is a surprise. The rank of $\mathbf{B}'$ can be read off the *vertices*
# alone:
#
# $$ \operatorname{rank}\mathbf{B}' = \operatorname{rank} \begin{bmatrix}
#    1 & x_1 & y_1 & x_1^2 & x_1 y_1 & y_1^2 \\ \vdots & & & & & \vdots \\
#    1 & x_V & y_V & x_V^2 & x_V y_V & y_V^2 \end{bmatrix}, \tag{4.6} $$
#
# where now $(x_j, y_j)$ are the $V = k + 1$ vertices of the star. It is six if and only if the
# vertices lie on no common *conic*: no ellipse, parabola, hyperbola, pair of lines. Write the rank
# on the right. As before it must not depend on the origin and the unit.


# %% question="04.7"
def conic_rank(vertices):
    """Return the rank on the right of (4.6) for vertices of shape (V, 2), a whole number."""
    # BEGIN SOLUTION
    moved = vertices - vertices.mean(axis=0)
    x, y = (moved / np.ptp(moved)).T
    b = np.column_stack([np.ones(len(x)), x, y, x * x, x * y, y * y])
    return np.linalg.matrix_rank(b, tol=1e-9)
    # END SOLUTION


# %%
check("04.7")


# %%
@draw(
    neighbours=Slider(3, 8, 4, "neighbours", whole=True),
    shift=Slider(-0.2, 0.2, 0, "move one", steps=40),
)
def star(neighbours, shift):
    random = np.random.default_rng(2)
    angles = (
        2 * np.pi * (np.arange(neighbours) + random.uniform(-0.25, 0.25, neighbours)) / neighbours
    )
    sizes = random.uniform(0.33, 0.5, neighbours)
    center = np.array([0.5, 0.5])
    ring = center + sizes[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    ring[0, 0] += shift
    points, normals = star_samples(center, ring)
    vertices = np.insert(ring, 0, center, axis=0)
    rank, by_vertices = int(velocity_rank(points, normals)), int(conic_rank(vertices))
    with figure(4.4, 3.9) as page:
        axes = page.subplots()
        for a, b in zip(ring, ring[np.arange(1, neighbours + 1) % neighbours], strict=True):
            axes.plot(*np.transpose([center, a, b]), color=GREY, lw=0.8)
        draw_edges(axes, points, normals, 0.08)
        axes.plot(*vertices.T, "o", color="black", ms=4)
        if rank < 6:
            (a, b), (d, e), (f, _) = tangent_field(points, normals).reshape(3, 2)
            x, y = np.meshgrid(*2 * [np.linspace(-0.1, 1.1, 200)])

            def stream(x, y):
                return a * y - b * x + d * x * y + (f * y**2 - e * x**2) / 2

            axes.contour(x, y, stream(x, y), 18, colors=GREY, linewidths=0.6, linestyles="-")
            axes.contour(
                x, y, stream(x, y), [stream(*center)], colors=ORANGE, linewidths=2, linestyles="-"
            )
        told = f"{2 * neighbours} equations, rank {rank};"
        axes.set(title=f"{told} {neighbours + 1} vertices, rank {by_vertices}")
    return page


# %% [markdown]
# **What to look at.** With four neighbours there are eight equations for six unknowns, and the rank
# is five. The thin lines are the stream lines of the flow that no edge sees. One of them (orange)
# goes through all the vertices: it is the conic. Through five points there is always one. Add a
# neighbour. How many does a vertex need?
#
# ## In words
#
# **04.8** Let $N \ge 6$ and let $\mathbf{B}$ have full column rank. Which "obvious" conditions must
# one require of the normals $\mathbf{n}_i$, such that $\mathbf{B}'$ does not lose full column rank?
# Why are they necessary, and are they sufficient?
#
# <details><summary>Hint</summary>
#
# Begin with the simplest flows: constant ones, then those of one direction. For the last part think
# of a wheel.
#
# </details>

# %% [markdown] answer="04.8" points=4
# Necessary are: not all normals are parallel, since nothing is known of the component along the
# edges then, and the rank is three. More generally, for each direction $\mathbf{m}$ the points of
# the samples with $\mathbf{n}_i^T\mathbf{m} \neq 0$ must not lie on one line. Otherwise there is an
# affine function $\alpha \neq 0$ that vanishes at all of them, and $\mathbf{u} =
# \alpha\,\mathbf{m}$ is tangent to every sample: where $\alpha \neq 0$ the normal is at right
# angles to $\mathbf{m}$. For the directions of the axes this says that $\mathbf{N}_x\mathbf{B}$ and
# $\mathbf{N}_y\mathbf{B}$ have rank three each, with the components of the normals on the diagonals
# of $\mathbf{N}_x$ and $\mathbf{N}_y$.
#
# They are not sufficient. If all normals pass through one place, the rotation about it is tangent
# to all edges: no two normals need be parallel, and the rank is at most five. The same holds for
# every affine flow $\mathbf{u}$ and any points, if each normal is chosen at right angles to
# $\mathbf{u}(\mathbf{p}_i)$: expansion, spiral, saddle. The complete condition is that no affine
# flow other than zero is tangent to all samples. For random normals it holds, as a rule.
# Sufficient, and easy to see, is: two directions that are not parallel, each the normal of three
# samples that are not on one line.

# %% [markdown] rubric="04.8"
# One point for "not all parallel" with its reason. One for the condition for each direction (or for
# the rank of $\mathbf{N}_x\mathbf{B}$ and $\mathbf{N}_y\mathbf{B}$, or that three samples off a
# line must carry each component). One for saying that this is not sufficient, with an example such
# as a rotation. One for the complete condition, a tangent affine flow.

# %% [markdown]
# **04.9** "There are more equations than unknowns, so the least squares problem has a unique
# solution." What is wrong with it? Use your star with four neighbours. How many neighbours does an
# inner vertex need, and what should a program do that meets a vertex with fewer?
#
# <details><summary>Hint</summary>
#
# Add up what flows out of a triangle: for a flow that no edge sees, what does it say of
# $\operatorname{div}\mathbf{u}$? How many of the equations of a star are then independent, at most?
#
# </details>

# %% [markdown] answer="04.9" points=3
# Unique is the solution if the *rank* is six; as many rows as columns are necessary for that and
# not sufficient, for rows may depend on each other. The star of four triangles has eight equations
# of rank five: by (4.6) the rank is at most the number of vertices, $k + 1$, since they are the
# rows on the right. (For an affine flow the eight fluxes obey relations: what flows out of each
# triangle, divided by its area, is the same for all triangles.) So $k \ge 5$ is needed, and it
# suffices unless the six or more vertices lie on a conic.
#
# A solver of the normal equations returns numbers without a warning, right in their normal
# components and arbitrary in the unseen flow. A program should look at singular values, or at what
# it can bound by them, and take more samples where they are too few: the edges of the next ring of
# triangles.

# %% [markdown] rubric="04.9"
# One point for rank against number of equations. One for $k + 1$ vertices or five neighbours, with
# a reason. One for a remedy: test the rank and enlarge the neighbourhood; "take the pseudo inverse"
# earns nothing, since its answer is arbitrary.

# %% [markdown]
# ## Dig deeper
#
# - Leave out the rim: only the $k$ edges that end in the vertex. Show that $\mathbf{x} -
#   \mathbf{x}_i$, where $\mathbf{x}_i$ is the vertex, is tangent to all of them, however many they
#   are. Is $\mathbf{u}(\mathbf{x}_i)$ itself still determined?
# - Prove (4.6). A flow without divergence is $\mathbf{u} = (\partial_y\psi, -\partial_x\psi)$, with
#   $\psi$ quadratic if $\mathbf{u}$ is affine. Why does the flux through an edge equal the
#   difference of $\psi$ at its ends?
# - Put four neighbours on two lines through the vertex. What is the unseen flow at the vertex? The
#   rank is five, and yet the velocity that is wanted there is determined.
# - Count for tetrahedra: how many columns has $\mathbf{B}'$, and how many faces has a star with
#   six, seven, eight vertices?

# %%
progress()
