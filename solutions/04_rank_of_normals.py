# ---
# jupyter:
#   course:
#     builds_on:
#       "01": least squares, the rank of a matrix and its tolerance
#     pages: slides, pages 18–22 and 42
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
# # The rank of a velocity system
#
# Many flow solvers know only the velocity *across* each edge of a mesh: one number for each edge,
# the normal component. The whole velocity has to be reconstructed from several of these numbers. In
# this notebook you find out when they determine an affine flow. Six equations for six unknowns are
# not always enough: the rank of the system depends on the positions and on the normals.
#
# **Source**: Erleben, *Field Reconstruction: A Quick Survey of Methods* (the slides). **Search
# for**: full column rank, null space, singular value decomposition, normal velocity, staggered
# (MAC) grid, stream function, conic through five points. **Read**: Strang, *Introduction to
# Linear Algebra*, the chapters on the four subspaces and on the singular value decomposition.
#
# Each question asks for a function or for an answer in words. Write the function, run its cell, and
# run the check below it. After a check that is not right, `case()` in a new cell shows the inputs
# for which your function failed, and your values. If everybody has the same inputs, it also shows
# the right values. Arrays may hold integers, so small that no product of them overflows. Compute
# with float64, NumPy's default type. Returned lists count as arrays, an array with one entry as a
# number, and a complex number without imaginary part as a real one. A function must not change its
# arguments.

# %% [markdown]
# ## A finished function
#
# The next cell ends with a finished function, `velocity`. Read it and imitate its style. It
# evaluates an affine flow $\mathbf{u}(x, y) = \mathbf{c}_0 + x\,\mathbf{c}_1 + y\,\mathbf{c}_2$ at
# $M$ points. Its six coefficients are one array, $(\mathbf{c}_0, \mathbf{c}_1, \mathbf{c}_2)$.
# `np.outer` multiplies each coordinate by each component.

# %% tags=["setup"]
import numpy as np

from fieldcheck import (
    BLUE,
    GREY,
    ORANGE,
    Slider,
    case,
    check,
    data,
    draw,
    figure,
    progress,
    start_over,
)


def velocity(c, x):
    """Return u of (4.1) at points x of shape (M, 2), for coefficients c of shape (6,)."""
    c_0, c_1, c_2 = np.reshape(c, (3, 2))
    return c_0 + np.outer(x[:, 0], c_1) + np.outer(x[:, 1], c_2)


# %% [markdown]
# For example, $\mathbf{c}_0 = (0, 0)$, $\mathbf{c}_1 = (0, 1)$, $\mathbf{c}_2 = (-1, 0)$ is the
# rotation $\mathbf{u} = (-y, x)$ about the origin.

# %%
example_flow = np.array([0, 0, 0, 1, -1, 0])
print(velocity(example_flow, np.array([[1.0, 0.0], [0.0, 2.0], [1.0, 1.0]])))


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


def rotated(normals, degrees):
    """Return normals rotated counter-clockwise, by one angle or by one for each."""
    a, b = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    x, y = normals.T
    return np.stack([a * x - b * y, b * x + a * y], axis=1)


# %% [markdown]
# ## Normal velocities
#
# The picture has six edges. On each of them only the normal component of the velocity is measured.
# The grey and the orange arrows are two flows. The orange one is the grey one plus a rotation, and
# the slider sets the amount of rotation. Compare the arrows on the left with the measurements on
# the right.


# %%
@draw(amount=Slider(-1, 1, 0.6, "rotation added"))
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
            left.annotate(str(k), p + 0.13 * n, ha="center", va="center", color=BLUE)
        for k, (c, color) in enumerate(((one, GREY), (other, ORANGE))):
            flow = velocity(c, points)
            left.quiver(*points.T, *flow.T, color=color, scale=3, width=0.012)
            across = np.einsum("nd,nd->n", normals, flow)
            right.bar(np.arange(1, 7) + 0.4 * k - 0.2, across, 0.36, color=color)
        left.set(xlim=(-0.2, 1.15), ylim=(-0.05, 1.15))
        right.axhline(0, color="black", lw=0.8)
        right.set(xlabel="edge", ylabel="normal velocity", ylim=(-0.6, 0.6))
    return page


# %% [markdown]
# The two flows are different, and their six measurements are equal. So these measurements do not
# determine the flow. This notebook finds the reason.
#
# ## The system
#
# Let the velocity be affine near the samples. In the plane
#
# $$ \mathbf{u}(\mathbf{x}) = \mathbf{c}_0 + x\,\mathbf{c}_1 + y\,\mathbf{c}_2, \qquad
#    \mathbf{c}_0, \mathbf{c}_1, \mathbf{c}_2 \in \mathbb{R}^2 , \tag{4.1} $$
#
# where $\mathbf{x} = (x, y)^T$. At the point $\mathbf{p}_i = (x_i, y_i)^T$ the component along the
# unit normal $\mathbf{n}_i$ is known:
#
# $$ \mathbf{n}_i^T \mathbf{u}(\mathbf{p}_i) = v_i , \qquad i = 1, \dots, N . \tag{4.2} $$
#
# A *sample* is a point with its normal. The samples give $N$ linear equations
# $\mathbf{B}'\mathbf{c} = \mathbf{V}'$ for the six numbers
# $\mathbf{c} = (\mathbf{c}_0, \mathbf{c}_1, \mathbf{c}_2)$:
#
# $$ \mathbf{B}' = \begin{bmatrix} \mathbf{n}_1^T & x_1\mathbf{n}_1^T & y_1\mathbf{n}_1^T \\
#    \vdots & \vdots & \vdots \\ \mathbf{n}_N^T & x_N\mathbf{n}_N^T & y_N\mathbf{n}_N^T
#    \end{bmatrix},
#    \qquad \mathbf{V}' = \begin{bmatrix} v_1 \\ \vdots \\ v_N \end{bmatrix}. \tag{4.3} $$
#
# In space there is a fourth block $z_i\mathbf{n}_i^T$. In $D$ dimensions there are $D + D^2$
# columns.
#
# ### Example: three samples, by hand
#
# Take the points $(1, 0)$, $(0, 2)$, $(1, 1)$ with the unit normals $(1, 0)$, $(0, 1)$, $(\tfrac35,
# \tfrac45)$. Each row of (4.3) has the normal, then $x$ times the normal, then $y$ times the
# normal:
#
# $$ \mathbf{B}' = \begin{bmatrix} 1 & 0 & 1 & 0 & 0 & 0 \\ 0 & 1 & 0 & 0 & 0 & 2 \\
#    \tfrac35 & \tfrac45 & \tfrac35 & \tfrac45 & \tfrac35 & \tfrac45 \end{bmatrix}. $$
#
# For the rotation $\mathbf{c} = (0, 0, 0, 1, -1, 0)$ the product is $\mathbf{B}'\mathbf{c} = (0, 0,
# \tfrac45 - \tfrac35) = (0, 0, \tfrac15)$. Directly: the velocity at $(1, 1)$ is $(-1, 1)$, and its
# component along $(\tfrac35, \tfrac45)$ is $\tfrac15$. The next cell checks these numbers.

# %%
three_normals = np.array([[1.0, 0.0], [0.0, 1.0], [0.6, 0.8]])
three_rows = np.array([[1, 0, 1, 0, 0, 0], [0, 1, 0, 0, 0, 2], [0.6, 0.8, 0.6, 0.8, 0.6, 0.8]])
three_velocities = velocity(example_flow, np.array([[1.0, 0.0], [0.0, 2.0], [1.0, 1.0]]))
print("B' c:", three_rows @ example_flow)
print("n · u:", np.einsum("id,id->i", three_normals, three_velocities))


# %% [markdown]
# ### 04.1 The matrix
#
# Write $\mathbf{B}'$ with its columns in the order of (4.3): first the two columns of
# $\mathbf{c}_0$, then those of $\mathbf{c}_1$, and so on. It must work in every dimension $D$.
#
# <details><summary>Hint</summary>
#
# The first block is the array of normals. By which number must each of its rows be multiplied for
# the next block? An array of shape $(N, 1)$, such as `a[:, None]`, multiplies rows.
#
# </details>


# %% question="04.1" minutes=20
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
# The samples determine the flow if and only if $\mathbf{B}'$ has *full column rank*: six in the
# plane. In notebook 01 the number of points did not decide the rank, and here the number of samples
# does not.
#
# ### 04.2 The rank
#
# Write a function that returns the rank of $\mathbf{B}'$. It must depend neither on the position of
# the origin nor on the unit of length. All normals are unit vectors.
#
# Rounding turns zero singular values into small ones. Scale the points, with the same factor
# for all coordinates, such that their extent is about one, and count singular values of
# $\mathbf{B}'$ below $10^{-9}$ as zero. The extent is the largest difference between two values of
# one coordinate.
# The number of samples is arbitrary. The points may be on a line, and several samples may share a
# point, but not all points are equal.
#
# <details><summary>Hint</summary>
#
# A common translation of all points changes $\mathbf{c}_0$, but not the rank. A change of the unit
# scales $\mathbf{c}_1$ and $\mathbf{c}_2$, but does not change the rank either. Subtract the mean
# of the points and divide by their extent first. Then one tolerance suits all cases.
#
# </details>


# %% question="04.2" minutes=10
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
        "at random": rotated(up, random.uniform(0, 360, 8)),
        "parallel": up,
        "two not parallel": rotated(up, [0, 50, 0, 0, 0, 0, -20, 0]),
        "through one point": radial,
    }
    with figure(6.4, 2.1) as page:
        for axes, (name, normals) in zip(page.subplots(1, 4), cases.items(), strict=True):
            draw_edges(axes, points, normals)
            axes.set(title=f"{name}:\nrank {velocity_rank(points, normals)}")
    return page


# %% [markdown]
# **What to look at.** The eight points are the same in all pictures, and $\mathbf{B}'$ has eight
# rows each time. Only the normals differ. The losses of rank in the second and the third
# picture are easy to explain. That in the fourth is not: no two of these normals are parallel.
#
# ## The null space
#
# If the rank is less than six, there is a vector $\mathbf{c} \neq \mathbf{0}$ with
#
# $$ \mathbf{B}'\mathbf{c} = \mathbf{0} \quad\Longleftrightarrow\quad
#    \mathbf{n}_i^T \mathbf{u}(\mathbf{p}_i) = 0 \ \text{ for all } i . \tag{4.4} $$
#
# So $\mathbf{u}$ is an affine flow that is *tangent* to every edge. All its normal velocities are
# zero, so it can be added to every solution. In short: $\mathbf{B}'$ has full column rank if and
# only if no affine flow except zero is tangent to all samples.
#
# ### 04.3 A tangent flow
#
# For samples with $\operatorname{rank}\mathbf{B}' = 5$ return the coefficients $\mathbf{c}$ of such
# a flow. Its size and its sign are arbitrary, but it must not be zero. Each entry of
# $\mathbf{B}'\mathbf{c}$ must be zero up to rounding: at most $10^{-9}$ times the largest
# coefficient. The extent of the points is about one, and they are at most a thousand times as far
# from the origin.
#
# <details><summary>Hint</summary>
#
# `np.linalg.svd` returns three arrays. The rows of the last one are orthogonal. What is the product
# of $\mathbf{B}'$ and each of them?
#
# </details>


# %% question="04.3" minutes=10
def tangent_field(points, normals):
    """Return c ≠ 0 of (4.4), of shape (6,), for points and normals of shape (N, 2) and rank 5."""
    # BEGIN SOLUTION
    rows = np.linalg.svd(velocity_matrix(points, normals))[2]
    return rows[-1]
    # END SOLUTION


# %%
check("04.3")

# %% [markdown]
# ### 04.4 Normals for a given flow
#
# Conversely, every affine flow is tangent to suitable samples at any points. For a given flow,
# return one unit normal of either sign at each point, such that the normal velocity is zero. The
# flow may be slow, but it is not zero at any of the points. Use `velocity(c, points)`.


# %% question="04.4" minutes=5
def crossing_normals(points, c):
    """Return unit normals (N, 2) with n_i · u(p_i) = 0, for points (N, 2) and c of shape (6,)."""
    # BEGIN SOLUTION
    u, v = velocity(c, points).T
    return np.column_stack([-v, u]) / np.hypot(u, v)[:, np.newaxis]
    # END SOLUTION


# %%
check("04.4")

# %% [markdown]
# ## Five tangent flows
#
# The picture shows five flows and the same ten points. The normals come from your function of 04.4.
# The stream lines come from your function of 04.3, which uses the normals only.


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
# **What to look at.** There are ten equations for six unknowns, no two normals are parallel, and
# the rank is five.
#
# ### A sample that rotates
#
# The next picture begins with six samples to which a rotation is tangent. Rotate the normal of one
# sample, or all normals together, and observe the smallest singular value of $\mathbf{B}'$. The
# rank drops where it is zero.


# %%
@draw(
    one=Slider(-90, 90, 0, "rotate one", steps=60),
    together=Slider(-90, 90, 0, "rotate all", steps=60),
)
def rotating(one, together):
    points = np.random.default_rng(8).random((6, 2))
    hidden = crossing_normals(points, np.array([0.5, -0.5, 0, 1, -1, 0]))

    def smallest(angle, of_all):
        n = rotated(hidden, of_all + angle * (np.arange(6) == 2))
        return np.linalg.svd(velocity_matrix(points, n), compute_uv=False)[-1]

    angles = np.linspace(-90, 90, 121)
    normals = rotated(hidden, together + one * (np.arange(6) == 2))
    rank = int(velocity_rank(points, normals))
    with figure(6.4, 2.9) as page:
        left, right = page.subplots(1, 2, width_ratios=(2, 3))
        if rank < 6:
            draw_flow(left, tangent_field(points, normals))
        draw_edges(left, points, normals)
        left.plot(*points[2], "o", color=ORANGE)
        left.set(title=f"rank {rank}" + ("" if rank == 6 else ", a tangent flow"))
        right.plot(angles, [smallest(a, together) for a in angles], color=GREY, label="rotate one")
        right.plot(angles, [smallest(one, a) for a in angles], "--", color=BLUE, label="rotate all")
        right.plot(one, smallest(one, together), "o", ms=8, color=ORANGE)
        right.set(xlabel="angle in degrees", ylabel="smallest singular value", ylim=(-0.01, None))
        right.legend()
    return page


# %% [markdown]
# **What to look at.** Rotate one normal, that of the orange dot on the left; the orange dot on the
# right is the present singular value. The rank is six at once, but the smallest singular value
# grows only in proportion to the angle. For a small angle the system is
# *ill-conditioned*: small errors of the measurements cause large errors of the flow. Then set this
# normal back and rotate all six together: the singular value remains zero. To which flow are the
# edges tangent at 45 degrees, and to which at 90 degrees? Both are among the five flows above.

# %% [markdown]
# ## Necessary conditions
#
# Suppose that the points $\mathbf{p}_i$ are not on one line. Then the matrix $\mathbf{B}$ with the
# rows $(1, x_i, y_i)$ has full column rank three. Which conditions must the normals satisfy?
#
# Consider flows of one fixed direction $\mathbf{m}$, such as a west wind that is stronger in the
# north: $\mathbf{u}(\mathbf{x}) = \alpha(\mathbf{x})\,\mathbf{m}$ with an affine function $\alpha$.
# A sample measures $\alpha$ only if $\mathbf{n}_i^T\mathbf{m} \neq 0$. These samples must determine
# $\alpha$, so their points must not be on one line:
#
# $$ \text{for every direction } \mathbf{m} \neq \mathbf{0} \text{ the points } \mathbf{p}_i \text{
#    with }
#    \mathbf{n}_i^T\mathbf{m} \neq 0 \text{ are not on one line.} \tag{4.5} $$
#
# ### 04.5 A test of the conditions
#
# Write a function that returns whether (4.5) holds. Its name is `obvious`, since the slides call
# such conditions "obvious". There are infinitely many directions. For which of them is (4.5)
# stronger than the condition that not all points are on one line? Count a product
# $\mathbf{n}_i^T\mathbf{m}$ of unit vectors as zero if its absolute value is below $10^{-9}$.
# Points count as on one line if their distances from a line are below $10^{-9}$; all coordinates
# are between $-10$ and $10$. Several samples may share a point.
#
# <details><summary>Hint</summary>
#
# Each sample is omitted for exactly one direction and its opposite. So at most $N$ directions
# must be tested. Points are not on one line if their matrix $\mathbf{B}$ has rank three. For
# coordinates of this size its smallest singular value is about as large as the distances from a
# line, so `np.linalg.matrix_rank` with `tol=1e-9` is suitable. This test is also right for fewer
# than three points.
#
# </details>


# %% question="04.5" minutes=25
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
        ("two exceptions", points, rotated(up, [0, 60, 0, 0, -40, 0])),
        ("three exceptions", points, rotated(up, [0, 60, 90, 0, -40, 0])),
        ("five on a line", line, rotated(up, random.uniform(0, 180, 6))),
        ("a rotation", points, crossing_normals(points, np.array([0.35, -0.6, 0, 1, -1, 0]))),
    ]
    with figure(6.6, 2.2) as page:
        for axes, (name, p, n) in zip(page.subplots(1, 5), cases, strict=True):
            draw_edges(axes, p, n)
            status = "holds" if obvious(p, n) else "fails"
            axes.set(title=f"{name}:\n(4.5) {status},\nrank {velocity_rank(p, n)}")
    return page


# %% [markdown]
# **What to look at.** Where (4.5) fails, the rank is always less than six. The fourth picture has
# five points on a line and one point off the line. For any normals its rank is less than six. Which
# flow is tangent to all its edges? In the fifth picture (4.5) holds, although the rank is less than
# six.

# %% [markdown]
# ## Stars of triangles
#
# In a mesh the normals are not arbitrary: they belong to edges. The *star* of a vertex consists of
# the triangles around it. We sample at the midpoints of *all* edges of these triangles: $k$ spokes,
# which end in the vertex, and $k$ outer edges.
#
# By hand: for the spoke from $(0, 0)$ to $(4, 0)$ the midpoint is $(2, 0)$, and a unit normal is
# $(0, 1)$. For the outer edge from $(4, 0)$ to $(0, 3)$ the midpoint is $(2, \tfrac32)$. The edge
# vector is $(-4, 3)$, so a unit normal is $(\tfrac35, \tfrac45)$.
#
# ### 04.6 The samples of a star
#
# Write a function that returns the midpoints and the unit normals. First come the spokes, in the
# order of the neighbours. Then come the outer edges, from each neighbour to the next, and from the
# last to the first. Each normal may have either sign. The star may have any size and may be far
# from the origin. Edges may be parallel to an axis.


# %% question="04.6" minutes=15
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
# ### 04.7 The rank from the vertices
#
# The vertices of a star are not all on one line. For its samples the rank of $\mathbf{B}'$
# depends on the *vertices* alone:
#
# $$ \operatorname{rank}\mathbf{B}' = \operatorname{rank} \begin{bmatrix}
#    1 & x_1 & y_1 & x_1^2 & x_1 y_1 & y_1^2 \\ \vdots & & & & & \vdots \\
#    1 & x_V & y_V & x_V^2 & x_V y_V & y_V^2 \end{bmatrix}. \tag{4.6} $$
#
# Here $(x_j, y_j)$ are the $V = k + 1$ vertices of the star. The rank is six if and only if no
# *conic* contains all vertices: no ellipse, parabola, hyperbola, pair of lines or single line.
# Write the rank on the right-hand side of (4.6).
#
# As in 04.2 the rank must depend neither on the origin nor on the unit of length. Before you form
# the squares, move the mean of the vertices to the origin and scale them to an extent of about one.
# Count singular values below $10^{-9}$ as zero. There are two vertices or more. They may even be on
# a line, although no star is. Their extents in $x$ and in $y$ are of similar size. So you may
# divide both coordinates by the same number, or each coordinate by its own.


# %% question="04.7" minutes=15
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
    shift=Slider(-0.2, 0.08, 0, "move one", steps=28),
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
        counts = f"{2 * neighbours} equations, rank {rank};"
        axes.set(title=f"{counts} {neighbours + 1} vertices, rank {by_vertices}")
    return page


# %% [markdown]
# **What to look at.** With four neighbours there are eight equations for six unknowns, and the rank
# is five. The thin lines are the stream lines of the tangent flow. One of them (orange) passes
# through all vertices: it is the conic. Through five points there is always a conic. With three
# neighbours the rank is four: several conics pass through the four vertices, and one of them is
# drawn. Add neighbours. How many does a vertex need?
#
# Notebook 05 uses this result: it reconstructs the velocities at all vertices of a mesh.
#
# ## In words
#
# **04.8** The slides ask for "obvious" conditions on the normals $\mathbf{n}_i$ that are necessary
# for full column rank of $\mathbf{B}'$; condition (4.5) is one of them, and the last picture of
# 04.5 shows that it is not sufficient. Prove that (4.5) is necessary.
#
# <details><summary>Hint</summary>
#
# Let (4.5) be violated, and look for a tangent flow of one direction, $\mathbf{u} =
# \alpha\,\mathbf{m}$.
#
# </details>

# %% [markdown] answer="04.8" points=4 minutes=15 words=60
# Let (4.5) fail for $\mathbf{m}$. The points with $\mathbf{n}_i^T\mathbf{m} \neq 0$ are on one
# line, so an affine function $\alpha \neq 0$ vanishes at them. The affine flow $\mathbf{u} =
# \alpha\,\mathbf{m} \neq \mathbf{0}$ is tangent to every sample, since $\alpha(\mathbf{p}_i) = 0$
# or $\mathbf{n}_i^T\mathbf{m} = 0$. Its coefficients are a vector $\mathbf{c} \neq \mathbf{0}$ with
# $\mathbf{B}'\mathbf{c} = \mathbf{0}$. So the rank is less than six.
#
# *Beyond the question.* (4.5) is not sufficient. Take six points on a circle, no two of them
# opposite, with radial normals. The rotation about the centre is tangent to all samples, so the
# rank is at most five. But (4.5) holds: no two normals are parallel, so a direction omits at most
# one point, and the five others are not on one line. Not only the rotation gives examples: take an
# expansion, a spiral or a saddle $\mathbf{u}$, and normals perpendicular to
# $\mathbf{u}(\mathbf{p}_i)$. If all normals are parallel, nothing is known of the component along
# the edges, and the rank is three. For the directions of the axes (4.5) says that
# $\mathbf{N}_x\mathbf{B}$ and $\mathbf{N}_y\mathbf{B}$ have rank three each, with the components of
# the normals on the diagonals of $\mathbf{N}_x$ and $\mathbf{N}_y$. The complete condition is that
# only the zero flow satisfies (4.4). Sufficient is: two directions that are not parallel, each the
# normal of three samples that are not on one line. So if the points contain two disjoint triples
# that are not on one line each, random normals give full column rank with probability one.

# %% [markdown] rubric="04.8"
# One point for the negation of (4.5): a direction $\mathbf{m}$ whose points are on one line. One
# for an affine $\alpha \neq 0$ that vanishes on the line. One for showing that $\alpha\,\mathbf{m}$
# is tangent to all samples. One for the conclusion that the rank is less than six.

# %% [markdown]
# **04.9** "There are more equations than unknowns, so the least-squares problem has a unique
# solution." Explain with the star of four neighbours why this is wrong. You may quote (4.6).
#
# <details><summary>Hint</summary>
#
# How many equations and how many vertices has this star? What does (4.6) say about the number of
# independent equations?
#
# </details>

# %% [markdown] answer="04.9" points=3 minutes=10 words=60
# The solution is unique if and only if the *rank* is six. Rows may depend on each other, so the
# number of rows does not decide. The star has eight equations, but only five vertices. By (4.6) its
# rank is that of a matrix with one row for each vertex, so it is at most five.
#
# *Beyond the question.* The bound follows without (4.6), too. The flux of an affine flow through an
# edge is the length of the edge times the normal velocity at its midpoint. The flux out of each
# triangle, divided by its area, is $\operatorname{div}\mathbf{u}$, which is the same for all
# $k$ triangles. These are $k - 1$ independent relations between the $2k$ equations, so the rank is
# at most $k + 1$. So $k \ge 5$ is necessary, and it is sufficient unless the six or more vertices
# lie on a conic. A solver of the normal equations returns numbers without a warning, right in their
# normal components and arbitrary in the tangent flow. A program should test the smallest singular
# value. Where it is too small, more samples are needed, such as the edges of the next ring of
# triangles. "Take the pseudo-inverse" is no remedy, since its answer is arbitrary.

# %% [markdown] rubric="04.9"
# One point for uniqueness by the rank. One for saying that equations may depend on each other. One
# for the reason that the rank is at most five: the five vertices by (4.6), which may be quoted, or
# the fluxes out of the triangles.

# %% [markdown]
# ## Dig deeper
#
# - *Spokes alone.* Omit the outer edges: take only the $k$ edges that end in the vertex. Show that
#   $\mathbf{x} - \mathbf{x}_i$, where $\mathbf{x}_i$ is the vertex, is tangent to all of them, for
#   any $k$. Is $\mathbf{u}(\mathbf{x}_i)$ still determined?
# - *Proof of (4.6).* A flow without divergence is $\mathbf{u} = (\partial_y\psi, -\partial_x\psi)$,
#   where the *stream function* $\psi$ is quadratic if $\mathbf{u}$ is affine. Why does the flux
#   through an edge equal the difference of $\psi$ between its ends?
# - *A cross.* Put four neighbours on two lines through the vertex. What is the tangent flow at the
#   vertex? The rank is five, and yet the velocity at the vertex is determined.
# - *Tetrahedra.* How many columns has $\mathbf{B}'$ in space, and how many faces has a star with
#   six, seven, eight vertices?

# %%
progress()
