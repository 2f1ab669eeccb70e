# ---
# jupyter:
#   course:
#     builds_on:
#       "01": least squares with more equations than unknowns
#     pages: slides, pages 23–26 and 44
#     chapters: [15-cell-velocities]
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
# # Velocities of the cells of a mesh
#
# Many flow solvers on triangle meshes store one number for each edge: the velocity of the fluid
# across this edge. This notebook reconstructs one velocity vector for each triangle from the
# numbers at its three edges, by least squares. You will see what least squares does with data that
# contradict each other. You will also see two tests of
# the same method. One test makes it look exact and the other makes it look poor, and you will be
# able to explain both.
#
# Notebook 05 reconstructs velocities at vertices from the same data. **Sources**: the lecture
# slides "Field Reconstruction" by K. Erleben, pages 23–26 and 44; for the last part P.-A. Raviart
# and J.-M. Thomas, *A mixed finite element method for 2nd order elliptic problems* (1977). **To
# search for**: least squares, outward normal, circumcentre, symmedian point (Lemoine point),
# discrete divergence, Raviart–Thomas element.
#
# Each question asks for a short function, or for an answer in words. Write the function, run its
# cell, and run the check below it. The check reports whether the function is right and, if not,
# which kind of mistake it may contain. Then `case()`, in a new cell, shows the inputs for which
# your function failed, and your values. If everybody has the same inputs, it also shows the right
# values. Arrays may hold integers, so small that no product of them overflows. Compute with
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
# ## The problem in a picture
#
# The orange arrows are the velocities at which the fluid leaves the triangle through its sides. The
# arrow on the second side points inwards: there the fluid enters. Choose one velocity for the whole
# triangle with the sliders; it is the black arrow. Each blue bar is the component of your velocity
# across one side, from the side to the dot. Try to bring all three dots to the tips of the orange
# arrows.

# %%
TURNS = np.array([0.4, 2.3, 4.4])
OUTFLOW = np.array([0.75, -0.55, 0.3])


@draw(direction=Slider(-180, 180, -40, "direction", whole=True), speed=Slider(0, 1.5, 0.8, "speed"))
def the_problem(direction, speed):
    out = np.exp(1j * TURNS)
    corners = [
        (a + b) / (1 + (a * b.conjugate()).real) for a, b in zip(out, np.roll(out, -1), strict=True)
    ]
    middles = (np.array(corners) + np.roll(corners, 1)) / 2
    u = speed * np.exp(1j * np.radians(direction))
    parts = (u * out.conj()).real
    off = np.sqrt(np.sum((parts - OUTFLOW) ** 2))
    with figure(6.4, 3.8) as page:
        axes = page.subplots()
        axes.fill(np.real(corners), np.imag(corners), fc="none", ec=GREY, lw=1.4)
        arrows = dict(angles="xy", scale_units="xy", scale=1, zorder=3)
        for middle, normal, wanted, part in zip(middles, out, OUTFLOW, parts, strict=True):
            axes.quiver(
                middle.real,
                middle.imag,
                wanted * normal.real,
                wanted * normal.imag,
                color=ORANGE,
                width=0.007,
                **arrows,
            )
            tip = middle + part * normal
            axes.plot([middle.real, tip.real], [middle.imag, tip.imag], color=BLUE, lw=5, alpha=0.4)
            axes.plot(tip.real, tip.imag, "o", color=BLUE, ms=7)
        axes.quiver(0, 0, u.real, u.imag, color="black", width=0.008, **arrows)
        axes.set(aspect="equal", xticks=[], yticks=[], xlim=(-2.9, 2.4), ylim=(-2.1, 2.0))
        axes.set_title(f"length of the residual: {off:.2f}")
        for side in axes.spines.values():
            side.set_visible(False)
    return page


# %% [markdown]
# **What to look at.** You can bring any two of the dots to their arrows, but then the third is
# determined. The data are three numbers, and a velocity in the plane has two components: there is
# one equation too many.

# %% [markdown]
# ## Three equations for two components
#
# Let $\mathbf{q}_1, \mathbf{q}_2, \mathbf{q}_3$ be the corners of a triangle. *Side* $a$ is the
# side opposite to corner $\mathbf{q}_a$, and $l_a$ is its length. The *outward unit normal*
# $\mathbf{n}_a$ has length one, is perpendicular to side $a$, and points away from $\mathbf{q}_a$.
# Let $v_a$ be the velocity at which the fluid leaves through side $a$. A constant velocity
# $\mathbf{u}$ should satisfy
#
# $$ \mathbf{N}\mathbf{u} = \mathbf{v}, \qquad
#    \mathbf{N} = \begin{bmatrix} \mathbf{n}_1^T \\ \mathbf{n}_2^T \\ \mathbf{n}_3^T \end{bmatrix},
#    \qquad
#    \mathbf{v} = \begin{bmatrix} v_1 \\ v_2 \\ v_3 \end{bmatrix}. \tag{6.1} $$
#
# The three equations contradict each other in general. So we take the velocity with the smallest
# sum of squared residuals:
#
# $$ \mathbf{u} \quad \text{minimizes} \quad \lVert \mathbf{N}\mathbf{u} - \mathbf{v} \rVert.
#    \tag{6.2} $$
#
# ## A worked example
#
# The triangle with the corners $(0, 0)$, $(4, 0)$ and $(0, 3)$ has the sides 5, 3 and 4. Side 1,
# opposite to the corner $(0, 0)$, runs from $(4, 0)$ to $(0, 3)$. So it has the direction
# $(-4, 3)$, and $(3, 4)$ is perpendicular to it and points away from $(0, 0)$. The two other sides
# lie on the axes. With the normal velocities $\mathbf{v} = (3.2, -0.4, -1.2)^T$,
#
# $$ \mathbf{N} = \begin{bmatrix} 0.6 & 0.8 \\ -1 & 0 \\ 0 & -1 \end{bmatrix}, \qquad
#    \mathbf{N}^T\mathbf{N} = \begin{bmatrix} 1.36 & 0.48 \\ 0.48 & 1.64 \end{bmatrix}, \qquad
#    \mathbf{N}^T\mathbf{v} = \begin{bmatrix} 2.32 \\ 3.76 \end{bmatrix}. $$
#
# The determinant of $\mathbf{N}^T\mathbf{N}$ is 2, and the solution of the normal equations is
# $\mathbf{u} = (1, 2)^T$. The residual $\mathbf{N}\mathbf{u} - \mathbf{v} = (-1, -0.6, -0.8)^T$ is
# not zero, but $\mathbf{N}^T$ maps it to zero. The next cell checks these numbers.


# %%
normals = np.array([[0.6, 0.8], [-1, 0], [0, -1]])
outflow = np.array([3.2, -0.4, -1.2])
print("normal matrix\n", normals.T @ normals)
print("its right-hand side", normals.T @ outflow)
residual = normals @ [1, 2] - outflow
print("residual", residual.round(12), "and its image", (normals.T @ residual).round(12))

# %% [markdown]
# Here is a finished function of the kind that you will write: its docstring gives the shapes, its
# body is the definition, and no corner is treated differently from the others. You may use it.


# %%
def side_lengths(q):
    """Return the lengths l_1, l_2, l_3 of the sides, of shape (3,), for the corners q (3, 2).

    Side a is opposite to q[a].
    """
    ends = [(q[1], q[2]), (q[2], q[0]), (q[0], q[1])]
    return np.array([np.linalg.norm(second - first) for first, second in ends])


print(side_lengths(np.array([[0.0, 0.0], [4.0, 0.0], [0.0, 3.0]])))

# %% [markdown]
# ### 06.1 The outward normals
#
# Write a function that returns $\mathbf{N}$ of (6.1). The corners may be listed clockwise or
# counter-clockwise. The triangle may have any size. It may be nearly flat, but its least height is
# at least $10^{-5}$ of its longest side. It may be small and far from the origin: then a formula
# with products of the coordinates themselves loses all digits.
#
# <details><summary>Hint</summary>
#
# Rotate the side by a right angle. There are two rotations by a right angle, and the order of the
# corners determines which of them gives the outward normal. On which side of the line is the
# opposite corner? The sign of a scalar product answers this.
#
# </details>


# %% question="06.1" minutes=25
def outward_normals(q):
    """Return N of (6.1), of shape (3, 2), for the corners q (3, 2).

    Row a belongs to the side opposite q[a].
    """
    # BEGIN SOLUTION
    result = np.empty((3, 2))
    for a in range(3):
        b, c = q[a - 1], q[a - 2]
        x, y = c - b
        n = np.array([y, -x]) / np.hypot(x, y)
        result[a] = n if n @ (b - q[a]) > 0 else -n
    return result
    # END SOLUTION


# %%
check("06.1")

# %% [markdown]
# ### 06.2 The velocity of a cell
#
# Write a function that returns the least-squares solution (6.2). The triangle may have any size,
# and may be far from the origin. It may be nearly flat, but its least height is at least $10^{-5}$
# of its longest side.
#
# <details><summary>Hint</summary>
#
# NumPy has a function for least squares. The normal equations of notebook 01 are another way. For
# a flat triangle and data almost without net outflow they lose more digits than that function.
#
# </details>


# %% question="06.2" minutes=5
def cell_velocity(q, v):
    """Return u of (6.2), of shape (2,).

    Given are the corners q (3, 2) and the outward normal velocities v (3,).
    """
    # BEGIN SOLUTION
    return np.linalg.lstsq(outward_normals(q), v, rcond=None)[0]
    # END SOLUTION


# %%
check("06.2")

# %% [markdown]
# ## The residual and the divergence
#
# Each equation $\mathbf{n}_a \cdot \mathbf{u} = v_a$ is a line in the plane of all velocities. The
# right panel shows the three lines for the triangle of the left panel, and the dot is your
# velocity. The slider *source* adds a multiple of $l_a$ to each $v_a$. If it is positive, more
# fluid leaves the triangle than enters it.


# %%
@draw(source=Slider(-1.5, 1.5, 0.8, "source"), shape=Slider(-0.8, 1.6, 0.1, "apex"))
def three_lines(source, shape):
    q = np.array([[shape, 0.9], [-0.8, -0.5], [0.8, -0.5]])
    n = outward_normals(q)
    length = np.hypot(*(np.roll(q, 1, axis=0) - np.roll(q, -1, axis=0)).T)
    v = n @ [0.9, 0.5] + source * length / np.linalg.norm(length)
    u = cell_velocity(q, v)
    colors = (BLUE, GREEN, PURPLE)
    with figure(6.6, 3.3) as page:
        left, right = page.subplots(1, 2)
        for a, color in enumerate(colors):
            side = np.delete(q, a, axis=0)
            left.plot(*side.T, color=color)
            left.quiver(
                *side.mean(axis=0),
                *(v[a] * n[a]),
                color=color,
                angles="xy",
                scale_units="xy",
                scale=1.8,
                width=0.011,
            )
            foot, along = v[a] * n[a], np.array([-n[a, 1], n[a, 0]])
            right.plot(*np.stack([foot - 9 * along, foot + 9 * along]).T, color=color)
        left.quiver(
            *q.mean(axis=0), *u, color=ORANGE, angles="xy", scale_units="xy", scale=1.8, width=0.013
        )
        right.plot(*u, "o", ms=8, color=ORANGE, label="your $\\mathbf{u}$")
        left.set(
            aspect="equal",
            xticks=[],
            yticks=[],
            xlim=(-1.6, 2.0),
            ylim=(-1.3, 1.6),
            title=r"$v_a\,\mathbf{n}_a$, and your $\mathbf{u}$",
        )
        left.axis("off")
        right.set(
            aspect="equal",
            xlabel="$u_1$",
            ylabel="$u_2$",
            xlim=(-1, 2.6),
            ylim=(-1, 2),
            title=r"the lines $\mathbf{n}_a \cdot \mathbf{u} = v_a$",
        )
        right.legend(loc="upper right")
    return page


# %% [markdown]
# **What to look at.** Without a source the three lines meet in one point. With a source they
# enclose a small triangle that is similar to the given one. However strong the source is, *your
# velocity does not move*. The reason is a property of the vector of lengths
# $\mathbf{l} = (l_1, l_2, l_3)^T$. The sides of a triangle, placed end to end, form a closed path,
# so their vectors sum to zero. Rotated by a right angle, this sum is
#
# $$ \mathbf{N}^T \mathbf{l} = \sum_a l_a \mathbf{n}_a = \mathbf{0}. \tag{6.3} $$
#
# Hence $\mathbf{l}$ is orthogonal to the range of $\mathbf{N}$, and least squares ignores the
# component of $\mathbf{v}$ along $\mathbf{l}$. This component is the residual. Its length is the
# *defect* of the cell,
#
# $$ d = \frac{\lvert \mathbf{l} \cdot \mathbf{v} \rvert}{\lVert \mathbf{l} \rVert}
#      = \lVert \mathbf{N}\mathbf{u} - \mathbf{v} \rVert . \tag{6.4} $$
#
# The number $\mathbf{l} \cdot \mathbf{v} = \sum_a l_a v_a$ is the net outflow of the triangle: its
# area times the *discrete divergence*. In the worked example
# $\mathbf{l} \cdot \mathbf{v} = 16 - 1.2 - 4.8 = 10$ and $d = 10/\sqrt{50} = \sqrt{2}$.
#
# ### 06.3 The defect
#
# Write a function that returns $d$, for the triangles of 06.2. You may use either side of (6.4).


# %% question="06.3" minutes=10
def defect(q, v):
    """Return d of (6.4), a number.

    Given are the corners q (3, 2) and the outward normal velocities v (3,).
    """
    # BEGIN SOLUTION
    return np.linalg.norm(outward_normals(q) @ cell_velocity(q, v) - v)
    # END SOLUTION


# %%
check("06.3")

# %% [markdown]
# ## The circumcentre
#
# A constant velocity belongs to the whole cell, but the exact field differs from point to point. To
# compare the two we have to choose a point. Finite-volume methods often choose the *circumcentre*
# $\mathbf{O}$, which has the same distance from all three corners. From
# $\lVert \mathbf{O} - \mathbf{q}_k \rVert = \lVert \mathbf{O} - \mathbf{q}_1 \rVert$ follow two
# linear equations,
#
# $$ 2\, (\mathbf{q}_k - \mathbf{q}_1) \cdot (\mathbf{O} - \mathbf{q}_1)
#    = \lVert \mathbf{q}_k - \mathbf{q}_1 \rVert^2, \qquad k = 2, 3. \tag{6.5} $$
#
# For the triangle of the worked example the equations are $8\,O_1 = 16$ and $6\,O_2 = 9$, so
# $\mathbf{O} = (2, 1.5)^T$, the midpoint of the longest side.
#
# ### 06.4 The circumcentre
#
# Write a function that returns $\mathbf{O}$. It must keep its accuracy for a triangle far from the
# origin, and for a triangle of any size from $10^{-12}$ to $10^{12}$, also a small one far from the
# origin. The three corners never lie on one line.
#
# <details><summary>Hint</summary>
#
# The unknown of (6.5) is $\mathbf{O} - \mathbf{q}_1$, not $\mathbf{O}$. Formulas with the squares
# of the coordinates themselves are right in exact arithmetic. In floating-point arithmetic they
# lose digits by *cancellation*: a double has 16 digits, and two squares of size $10^{12}$ are known
# to about $10^{-4}$ only.
#
# </details>


# %% question="06.4" minutes=10
def circumcenter(q):
    """Return O of (6.5), of shape (2,), for the corners q (3, 2)."""
    # BEGIN SOLUTION
    sides = q[1:] - q[0]
    return q[0] + np.linalg.solve(2 * sides, np.sum(sides**2, axis=1))
    # END SOLUTION


# %%
check("06.4")

# %% [markdown]
# ## An exact field for tests
#
# The test field is a rotation about a point $\mathbf{m}$ plus an expansion from $\mathbf{m}$ at the
# rate $s$:
#
# $$ \mathbf{u}(\mathbf{x}) = \mathbf{J}\,(\mathbf{x} - \mathbf{m}) + s\,(\mathbf{x} - \mathbf{m}),
#    \qquad
#    \mathbf{J} = \begin{bmatrix} 0 & -1 \\ 1 & 0 \end{bmatrix}. \tag{6.6} $$
#
# Its divergence is $2s$. For $s = 0$ the field is *free of divergence*: the net outflow of every
# cell is zero. For $s > 0$ every cell is a source, and for $s < 0$ every cell is a sink.
#
# ### 06.5 The exact velocity
#
# Write the field (6.6) for many points at once. The number $s$ may be any number, also a negative
# one.


# %% question="06.5" minutes=10
def truth(x, m, s):
    """Return u of (6.6) at points x (M, 2), of shape (M, 2).

    The centre m has the shape (2,), and s is a number.
    """
    # BEGIN SOLUTION
    z = x - m
    return np.column_stack([s * z[:, 0] - z[:, 1], z[:, 0] + s * z[:, 1]])
    # END SOLUTION


# %%
check("06.5")

# %% [markdown]
# The next picture shows a mesh with the normal velocities
# $v_a = \mathbf{n}_a \cdot \mathbf{u}(\mathbf{p}_a)$ at the midpoints $\mathbf{p}_a$ of the sides.
# The thin orange arrows at the circumcentres are your velocities. The broad blue arrows are the
# exact velocities at the same points.


# %%
def scattered(number, seed):
    """Return vertices (K, 2) of an irregular mesh of the unit square, and its triangles (T, 3)."""
    random = np.random.default_rng(seed)
    points = np.stack([np.arange(16) / 4 % 1, np.zeros(16)], axis=1)
    turn = np.exp(0.5j * np.pi * (np.arange(16) // 4)) * (points[:, 0] - 0.5 - 0.5j)
    points = 0.5 + np.stack([turn.real, turn.imag], axis=1)
    while len(points) < number:
        more = random.uniform(0.08, 0.92, (9, 2))
        free = [np.hypot(*(points - point).T).min() for point in more]
        points = np.vstack([points, more[np.argmax(free)]])
    return points, Triangulation(*points.T).triangles


def normal_velocities(corners, field):
    """Return the outward normal velocities (3,) of a field at the midpoints of the sides."""
    midpoints = np.array([np.delete(corners, k, axis=0).mean(axis=0) for k in (0, 1, 2)])
    return np.einsum("ak,ak->a", outward_normals(corners), field(midpoints))


def all_cells(points, triangles, field):
    """Return the circumcentres, velocities and defects of all cells for a field."""
    corners = points[triangles]
    data_of_cells = [normal_velocities(q, field) for q in corners]
    pairs = list(zip(corners, data_of_cells, strict=True))
    return (
        np.array([circumcenter(q) for q in corners]),
        np.array([cell_velocity(q, v) for q, v in pairs]),
        np.array([defect(q, v) for q, v in pairs]),
    )


@draw(s=Slider(-1, 1, 0, "expansion s"), seed=Slider(1, 12, 1, "mesh", whole=True))
def cells(s, seed):
    points, triangles = scattered(34, seed)
    middle = points.mean(axis=0)
    centres, found, defects = all_cells(points, triangles, lambda x: truth(x, middle, s))
    right = truth(centres, middle, s)
    look = dict(angles="xy", scale_units="xy", scale=3.4)
    with figure(6.4, 4.3) as page:
        axes = page.subplots()
        axes.triplot(*points.T, triangles, color=GREY, lw=0.7, zorder=0)
        axes.quiver(
            *centres.T, *right.T, color=BLUE, alpha=0.45, width=0.012, label="exact", **look
        )
        axes.quiver(*centres.T, *found.T, color=ORANGE, width=0.005, label="yours", **look)
        axes.plot(*middle, "+", ms=11, color="black", label=r"$\mathbf{m}$")
        axes.set(aspect="equal", xticks=[], yticks=[], xlim=(-0.2, 1.2), ylim=(-0.2, 1.2))
        axes.axis("off")
        worst = np.hypot(*(found - right).T).max()
        axes.set_title(
            f"$s$ = {s:.2g}: largest error {worst:.1g}, largest defect {defects.max():.1g}"
        )
        axes.legend(loc="center left", bbox_to_anchor=(1, 0.5))
    return page


# %% [markdown]
# **What to look at.** For $s = 0$ the arrows agree up to rounding errors, in every cell of every
# mesh. For $s \neq 0$ they do not. The error is largest in obtuse cells.
#
# ## The point of comparison
#
# The circumcentre is not the only possible point. One could compare with the exact field at the
# centroids of the cells, or at the vertices of the mesh.
#
# ### 06.6 Errors at three kinds of points
#
# Write a function that returns the root-mean-square (RMS) errors for all three choices. Let
# $\mathbf{m}$ be the mean of the points, let the data be
# $v_a = \mathbf{n}_a \cdot \mathbf{u}(\mathbf{p}_a)$ at the midpoints of the sides, and let
# $\mathbf{u}_T$ be your velocity of cell $T$. The mesh may be small, and at most ten thousand times
# its size away from the origin. Then
#
# $$ E_{\mathbf{O}} = \sqrt{\operatorname{mean}_T \lVert \mathbf{u}_T - \mathbf{u}(\mathbf{O}_T)
#    \rVert^2}, \qquad
#    E_{\mathbf{M}} = \sqrt{\operatorname{mean}_T \lVert \mathbf{u}_T - \mathbf{u}(\mathbf{M}_T)
#    \rVert^2}, $$
#
# $$ E_{\mathbf{q}} = \sqrt{\operatorname{mean}_{T, a} \lVert \mathbf{u}_T -
#    \mathbf{u}(\mathbf{q}_{T,a}) \rVert^2} \tag{6.7} $$
#
# are the errors at the circumcentres $\mathbf{O}_T$, at the centroids $\mathbf{M}_T$, and at the
# corners $\mathbf{q}_{T,a}$ of each cell. Another $\mathbf{m}$, such as zero, gives the same errors
# up to rounding, and is as good: it adds the same constant velocity to the field and to all
# $\mathbf{u}_T$.


# %% question="06.6" minutes=25
def errors(points, triangles, s):
    """Return the three errors of (6.7), of shape (3,).

    Given are the points (K, 2), the triangles (T, 3), and the number s.
    """
    # BEGIN SOLUTION
    m = points.mean(axis=0)
    squares = []
    for q in points[triangles]:
        middles = (q.sum(axis=0) - q) / 2
        v = np.sum(outward_normals(q) * truth(middles, m, s), axis=1)
        compared_at = np.vstack([circumcenter(q), q.mean(axis=0), q])
        squares.append(np.sum((cell_velocity(q, v) - truth(compared_at, m, s)) ** 2, axis=1))
    squares = np.array(squares)
    return np.sqrt([squares[:, 0].mean(), squares[:, 1].mean(), squares[:, 2:].mean()])
    # END SOLUTION


# %%
check("06.6")

# %% [markdown]
# The left panel shows the errors on a mesh of your own, against $s$. The right panel shows the
# errors for the $s$ of the slider on a sequence of finer meshes, with a line of slope 1.


# %%
@draw(s=Slider(0, 1, 0, "expansion s"))
def compared_where(s):
    points, triangles, _ = data("06.6")
    rates = np.linspace(0, 1, 11)
    table = np.array([errors(points, triangles, float(rate)) for rate in rates])
    numbers = (24, 40, 80, 160)
    meshes = [scattered(number, 2) for number in numbers]
    cell_sizes = np.array([1 / np.sqrt(len(triangles)) for _, triangles in meshes])
    finer = np.array([errors(*mesh, s) for mesh in meshes])
    styles = (
        ("at circumcentres", ORANGE, "o-"),
        ("at centroids", GREEN, "s--"),
        ("at vertices", PURPLE, "^:"),
    )
    with figure(6.8, 3.2) as page:
        left, right = page.subplots(1, 2)
        for k, (label, color, style) in enumerate(styles):
            left.plot(rates, table[:, k], style, ms=4, color=color, label=label)
            if finer[:, k].min() > 1e-12:
                right.loglog(cell_sizes, finer[:, k], style, ms=5, color=color)
        right.loglog(cell_sizes, 0.6 * cell_sizes, color=GREY, lw=1, label="slope 1")
        if finer[:, 0].max() < 1e-12:
            right.text(
                0.5,
                0.05,
                f"circumcentres: below {10.0 ** np.ceil(np.log10(finer[:, 0].max())):.0e}",
                transform=right.transAxes,
                ha="center",
                color=ORANGE,
            )
        left.axvline(s, color="black", ls=":", lw=1)
        left.set(xlabel="expansion $s$", ylabel="RMS error", ylim=(0, None), title="your mesh")
        right.set(
            xlabel="size of a cell",
            ylim=(0.01, 0.5),
            title=f"finer meshes, $s$ = {s:.2g}",
            xticks=[0.06, 0.1, 0.2],
            xticklabels=["0.06", "0.1", "0.2"],
            yticks=[0.01, 0.02, 0.05, 0.1, 0.2, 0.5],
            yticklabels=["0.01", "0.02", "0.05", "0.1", "0.2", "0.5"],
        )
        right.minorticks_off()
        right.legend(loc="upper left")
        page.legend(*left.get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return page


# %% [markdown]
# **What to look at.** For $s = 0$ the error at the circumcentres is zero up to rounding. The two
# other errors are proportional to the size of the cells, so the method seems to be of first order.
# It is the same method with the same data. For larger $s$ the circumcentre is no longer the best of
# the three.
#
# ### The point where the exact field has the velocity of the cell
#
# For one triangle, the exact field (6.6) has the velocity of the cell at exactly one point: the
# orange dot. As $s$ grows, the dot moves from the circumcentre $\mathbf{O}$ ($s = 0$) towards
# $\mathbf{K} = \sum_a l_a^2 \mathbf{q}_a / \sum_a l_a^2$ ($s \to \pm\infty$). The point
# $\mathbf{K}$ is called the *symmedian point* or Lemoine point. Change the shape of the triangle,
# too.


# %%
@draw(
    s=Slider(-3, 3, 0.7, "expansion s"),
    apex=Slider(-0.6, 1.6, 0.5, "apex"),
    height=Slider(0.2, 1.4, 0.8, "height"),
)
def matching_point(s, apex, height):
    q = np.array([[-0.7, -0.3], [0.8, -0.3], [apex, height - 0.3]])
    middle, path = np.array([-0.2, 0.1]), []
    for rate in (*np.linspace(-8, 8, 161), s):
        _, (u,), _ = all_cells(
            q, np.array([[0, 1, 2]]), lambda x, rate=rate: truth(x, middle, rate)
        )
        path.append(middle + np.linalg.inv([[rate, -1], [1, rate]]) @ u)
    squares = [np.sum(np.diff(np.delete(q, k, axis=0), axis=0) ** 2) for k in (0, 1, 2)]
    with figure(6.4, 3.7) as page:
        axes = page.subplots()
        axes.fill(*q.T, fc="none", ec="black", lw=1.2)
        axes.plot(
            *np.array(path[:-1]).T,
            color=ORANGE,
            lw=1.2,
            label=r"exact field = $\mathbf{u}$, all $s$",
        )
        axes.plot(
            *path[-1],
            "o",
            ms=9,
            color=ORANGE,
            label=f"exact field = $\\mathbf{{u}}$, $s$ = {s:.2g}",
        )
        axes.plot(*circumcenter(q), "^", ms=8, color=BLUE, label=r"circumcentre $\mathbf{O}$")
        axes.plot(
            *np.average(q, axis=0, weights=squares),
            "s",
            ms=7,
            color=PURPLE,
            label=r"symmedian point $\mathbf{K}$",
        )
        axes.plot(*q.mean(axis=0), "x", ms=8, mew=2, color=GREEN, label=r"centroid $\mathbf{M}$")
        axes.set(aspect="equal", xticks=[], yticks=[], xlim=(-1.1, 1.8), ylim=(-1.2, 1.3))
        axes.axis("off")
        axes.legend(loc="center left", bbox_to_anchor=(1, 0.5))
    return page


# %% [markdown]
# ### In words
#
# **06.7** The exact field is the rotation, $s = 0$. Prove that
# the velocity of a cell is *exactly* the field at the circumcentre of the cell, whatever the shape
# of the triangle.
#
# <details><summary>Hint</summary>
#
# Write the field about the circumcentre,
# $\mathbf{u}(\mathbf{x}) = \mathbf{u}(\mathbf{O}) + \mathbf{J}(\mathbf{x} - \mathbf{O})$. What is
# the direction of $\mathbf{p}_a - \mathbf{O}$ for the midpoint $\mathbf{p}_a$ of a side? What,
# then, is the direction of $\mathbf{J}(\mathbf{p}_a - \mathbf{O})$, and what is its component
# across the side?
#
# </details>

# %% [markdown] answer="06.7" points=5 minutes=20 words=100
# The circumcentre lies on the perpendicular bisector of every side, so $\mathbf{p}_a - \mathbf{O}$
# is a multiple of $\mathbf{n}_a$, or zero. The matrix $\mathbf{J}$ rotates by a right angle, so
# $\mathbf{n}_a \cdot \mathbf{J}(\mathbf{p}_a - \mathbf{O}) = 0$. Hence
# $v_a = \mathbf{n}_a \cdot \mathbf{u}(\mathbf{p}_a) = \mathbf{n}_a \cdot \mathbf{u}(\mathbf{O})$
# for all three sides: the constant $\mathbf{u}(\mathbf{O})$ satisfies all equations of (6.1).
#
# The residual of this constant is zero, so it is a minimizer of (6.2). Two of the normals are not
# parallel, so $\mathbf{N}$ has rank two and the minimizer is unique. The proof uses neither the
# shape of the triangle nor that $\mathbf{O}$ lies inside.
#
# *Beyond the question.* The difference from the velocity at a corner is
# $\lVert\mathbf{J}(\mathbf{q}_a - \mathbf{O})\rVert$, the circumradius. It measures the mesh and
# not the method. Constants and rotations are the only affine fields for which the theorem holds in
# every triangle: an expansion belongs to the symmedian point, and the strain $(x, -y)$, which is
# free of divergence, has an error of the size of the cell. A test with a rotation only is a test
# with the one field that cannot fail.

# %% [markdown] rubric="06.7"
# One point for the direction of $\mathbf{p}_a - \mathbf{O}$. One for the right angle: the rotation
# about $\mathbf{O}$ has no component across the side. One for concluding that the constant
# satisfies all three equations. One for: it is therefore the least-squares solution. One for
# uniqueness, or rank two.

# %% [markdown]
# ## A field for data with divergence
#
# For $s \neq 0$ the data of a cell contradict each other, because
# $\mathbf{l} \cdot \mathbf{v} = 2 s A$, with the area $A$ of the triangle. Least squares discards
# this part of the data. The lowest-order *Raviart–Thomas field* does not. It is not constant:
#
# $$ \mathbf{w}(\mathbf{x}) = \sum_{a=1}^{3} \frac{v_a}{h_a} (\mathbf{x} - \mathbf{q}_a), \qquad
#    h_a = \frac{2A}{l_a}, \tag{6.8} $$
#
# where $h_a$ is the height of the triangle over side $a$. At every point of side $a$ the component
# of $\mathbf{w}$ along $\mathbf{n}_a$ is $v_a$. For $b \neq a$ the corner $\mathbf{q}_b$ lies on
# side $a$, so the term of $b$ is parallel to side $a$ there. The term of $a$ has the component
# $v_a$, since $\mathbf{n}_a \cdot (\mathbf{x} - \mathbf{q}_a) = h_a$ on side $a$.
#
# In the worked example $A = 6$, and the heights are $2.4$, $4$ and $3$. At the circumcentre
# $(2, 1.5)$ the three terms are $\tfrac43 (2, 1.5)$, $-\tfrac1{10} (-2, 1.5)$ and
# $-\tfrac{4}{10} (2, -1.5)$, which sum to
# $\mathbf{w} = \bigl(\tfrac{31}{15}, \tfrac{49}{20}\bigr)$.
#
# ### 06.8 The Raviart–Thomas field
#
# Write a function that returns $\mathbf{w}$ at one point, inside the triangle or outside. The
# triangle may have any size, but no height is zero. It may be small and far from the origin: then
# the differences in (6.8) keep their digits, and products with the coordinates themselves lose
# them.
#
# <details><summary>Hint</summary>
#
# The area of the triangle is half the absolute value of a determinant. The height over side $a$ is
# also the distance of any point of side $a$ from $\mathbf{q}_a$ in the direction of $\mathbf{n}_a$.
#
# </details>


# %% question="06.8" minutes=15
def raviart_thomas(q, v, x):
    """Return w of (6.8) at the point x (2,), of shape (2,).

    Given are the corners q (3, 2) and the outward normal velocities v (3,).
    """
    # BEGIN SOLUTION
    n, r = outward_normals(q), x - q
    heights = np.ptp(n @ r.T, axis=1)
    return (v / heights) @ r
    # END SOLUTION


# %%
check("06.8")

# %% [markdown]
# The next picture adds three fields on one mesh: the rotation, the expansion with the rate $s$, and
# the strain $(x_1 - m_1,\, m_2 - x_2)$ with the strength of the second slider. The third slider
# adds random noise to the normal velocities. Each dot is a cell: its error at the circumcentre
# against its defect.


# %%
@draw(
    s=Slider(0, 1, 0.6, "expansion s"),
    strain=Slider(0, 1, 0, "strain"),
    noise=Slider(0, 0.2, 0, "noise"),
)
def defect_and_error(s, strain, noise):
    points, triangles = scattered(60, 2)
    middle, random = points.mean(axis=0), np.random.default_rng(5)

    def field(x):
        return truth(x, middle, s) + strain * (x - middle) * [1, -1]

    rows = []
    for corners in points[triangles]:
        v = normal_velocities(corners, field) + noise * random.normal(size=3)
        center = circumcenter(corners)
        exact = field(center[np.newaxis])[0]
        both = (cell_velocity(corners, v), raviart_thomas(corners, v, center))
        rows.append([defect(corners, v), *(np.hypot(*(u - exact)) for u in both)])
    table = np.array(rows)
    titles = ("least squares", r"Raviart–Thomas, $\mathbf{w}(\mathbf{O})$")
    with figure(6.6, 3.0) as page:
        panels = page.subplots(1, 2, sharex=True, sharey=True)
        for axes, errors_of_cells, color, title in zip(
            panels, table.T[1:], (ORANGE, BLUE), titles, strict=True
        ):
            axes.plot(table[:, 0], errors_of_cells, "o", ms=4, color=color, alpha=0.7)
            axes.set(
                xlabel="defect of the cell", title=f"{title}: mean {errors_of_cells.mean():.1g}"
            )
        limit = max(0.1, 1.1 * table.max())
        panels[0].set(
            ylabel="error at the circumcentre", xlim=(-limit / 20, limit), ylim=(-limit / 20, limit)
        )
    return page


# %% [markdown]
# **What to look at.** Without strain and noise, $\mathbf{w}(\mathbf{O})$ is exact and least squares
# is not. Set $s = 0$ and turn on the *strain*: all defects are zero up to rounding, but the errors
# of both methods are not. Then set $s$ and the strain to zero, and try *noise* alone.
#
# ### In words
#
# **06.9** All defects of a solver's output are zero. Does this show that the velocities of the
# cells are accurate? Explain what the defect measures, and give an example.
#
# <details><summary>Hint</summary>
#
# Split $\mathbf{v}$ into a component along $\mathbf{l}$ and one orthogonal to it. What does (6.2)
# do with each? Then look at the picture with strain only.
#
# </details>

# %% [markdown] answer="06.9" points=4 minutes=15 words=120
# No. By (6.3) the range of $\mathbf{N}$ consists of the vectors orthogonal to $\mathbf{l}$. Least
# squares replaces $\mathbf{v}$ by the closest of them and returns the velocity of these data. It
# discards the component along $\mathbf{l}$, which is the net outflow. The defect is the length of
# this component.
#
# Zero defects show that in each cell *some* constant velocity fits its three numbers. They do not
# show that the field is constant in the cell, and hence not that the velocity is accurate. The
# strain $(x, -y)$ has no defect, and its error is of the size of the cell.
#
# *Beyond the question.* The closest vector is $\mathbf{v} -
# \mathbf{l}\,(\mathbf{l}\cdot\mathbf{v})/\lVert\mathbf{l}\rVert^2$. Noise has three components in
# each cell: one is discarded and contributes to the defect, and two change the velocity and leave
# the defect as it is. Consistent data need not be accurate.

# %% [markdown] rubric="06.9"
# One point for "no": zero defects show only that a constant velocity fits the three numbers. One
# for the discarded component along $\mathbf{l}$, which is the net outflow or divergence. One for:
# the defect measures this component, and nothing else. One for an example, such as the strain, or
# noise orthogonal to $\mathbf{l}$.

# %% [markdown]
# ## Dig deeper
#
# - *Least squares as a point value of (6.8).* Evaluate (6.8) at the symmedian point $\mathbf{K}$
#   for random data, and compare with `cell_velocity`. To prove what you see, show the following: a
#   step from side $a$ inwards by the distance $t$ changes $\mathbf{n}_a \cdot \mathbf{w}$ by the
#   same amount for all sides. Which distances from the three sides has $\mathbf{K}$?
# - *Comparison with the vertices.* For the rotation, show that the difference between the velocity
#   of a cell and the field has the same length at all corners, which grows like the circumradius.
#   What does the error at the vertices measure, then?
# - *Expansion and noise.* For an expansion the error at the circumcentre is
#   $s\,\lVert\mathbf{K} - \mathbf{O}\rVert$. For which triangles is it zero? Noise of size $\delta$
#   in the three data has three components. How large is the error of the velocity?
# - *The triangle of the three lines.* Where in the small triangle of the three lines is the dot?
#   Which theorem on sums of squared distances is this?
# - *Weights.* Multiply equation $a$ by the length $l_a$. Which vectors are ignored now, and to
#   which point does an expansion belong?
# - *A wrong point that does no harm.* For each side take the velocity (6.6) at the corner where the
#   side begins, instead of at its midpoint. All three normal velocities are then wrong. What is the
#   error of $\mathbf{v}$, and what is the error of $\mathbf{u}$?
# - *Strain.* At which point does the field $(x, -y)$ have the velocity of the cell? Rotate the
#   strain and follow the point. It moves on a well-known circle of the triangle.
# - *Tetrahedra.* A tetrahedron has four faces. Does (6.3) hold? Which point of a face replaces the
#   midpoint of the side in the proof of 06.7?
#
# **Next**: notebook 07 interpolates between circumcentres, and notebook 13 moves a field along such
# velocities.

# %%
progress()
