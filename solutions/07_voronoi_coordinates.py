# ---
# jupyter:
#   course:
#     builds_on:
#       "06": the circumcentre of a triangle
#     pages: slides, pages 27–36 and 45
#     chapters: [17-barycentric-coordinates, 18-voronoi-coordinates]
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
# # Voronoi coordinates
#
# A fluid solver stores one pressure for each triangle of its mesh, at the circumcentre of the
# triangle. The pressure at a point between the circumcentres is wanted. The circumcentres around
# a vertex are the corners of a polygon, the *Voronoi cell* of the vertex. This notebook
# interpolates in this cell by *generalized barycentric coordinates*: weights that depend on the
# point, as in a triangle. You will compute these weights from the triangles alone, evaluate them
# along a spiral, and remove the division by zero on the edges of the cell.
#
# **Sources**: the lecture slides "Field Reconstruction" by K. Erleben, pages 27–36 and the exercise
# on page 45; J. Warren, S. Schaefer, A. Hirani and M. Desbrun, *Barycentric coordinates for convex
# sets* (2007). **To search for**: generalized barycentric coordinates, Wachspress coordinates (the
# coordinates of this notebook, for any convex polygon), Delaunay triangulation and the
# Bowyer–Watson algorithm, circumcentric dual. Two other kinds of coordinates are easily confused
# with these: *mean value coordinates* (Floater 2003), which also exist in polygons that are not
# convex, and *natural neighbour coordinates* (Sibson), which interpolate values at the vertices of
# the mesh.
#
# Each question with code asks for one short function. Write it, run its cell, and run the check
# below it. The check reports whether the function is right and, if not, which kind of mistake it
# may contain. Then `case()`, in a new cell, shows the inputs for which your function failed, and
# your values. If everybody has the same inputs, it also shows the right values. Arrays may hold
# integers, so small that no product of them overflows. Compute with float64, NumPy's default type.
# Returned lists count as arrays, an array with one entry as a number, and a complex number without
# imaginary part as a real one. A function must not change its arguments.

# %% tags=["setup"]
import numpy as np

from fieldcheck import (
    BLUE,
    GREY,
    ORANGE,
    PURPLE,
    Slider,
    case,
    check,
    data,
    drag,
    draw,
    figure,
    progress,
    start_over,
    terrain,
)

# %% [markdown]
# ## The problem in a picture
#
# Six triangles around a vertex $\mathbf{x}_i$ form a hexagon. The dots are their circumcentres,
# where values are given; each value stands beside its dot. The polygon of the dots is the Voronoi
# cell of $\mathbf{x}_i$: it consists of the points that are closer to $\mathbf{x}_i$ than to any
# other vertex. What is the value at the question mark?


# %%
@draw()
def the_problem():
    rim = np.exp(1j * np.linspace(0, 2 * np.pi, 7))
    dots = (rim[1:] + rim[:-1]) / 3
    with figure(6.4, 3.4) as page:
        axes = page.subplots()
        for tip in rim[1:]:
            axes.plot([0, tip.real], [0, tip.imag], color=GREY, lw=1)
        axes.plot(rim.real, rim.imag, color=GREY, lw=1, label="mesh")
        axes.fill(dots.real, dots.imag, fc="#e8eef5", ec=BLUE, lw=2, label="Voronoi cell")
        axes.plot(
            dots.real,
            dots.imag,
            "o",
            color=BLUE,
            label="circumcentres: a value each",
        )
        for dot in dots:
            label = f"{dot.real + dot.imag:.2f}"
            axes.annotate(label, (1.22 * dot.real, 1.22 * dot.imag), ha="center", va="center")
        axes.annotate(r"$\mathbf{x}_i$", (0.04, -0.13))
        axes.plot(
            [0.16],
            [0.24],
            marker="$?$",
            ms=13,
            color=ORANGE,
            ls="none",
            label="wanted",
        )
        axes.set_aspect("equal")
        axes.axis("off")
        axes.legend(loc="center left", bbox_to_anchor=(1.02, 0.5))
    return page


# %% [markdown]
# ## The mesh
#
# Let $\mathbf{x}_i$ be the central vertex and $\mathbf{x}_0, \dots, \mathbf{x}_{N-1}$ its
# neighbours, in order around it. Indices begin at zero, as in NumPy, and are cyclic: $\mathbf{x}_N$
# is $\mathbf{x}_0$ again. A regular hexagon of radius $R$, rotated by the angle $\alpha$, has the
# neighbours
#
# $$ \mathbf{x}_b = \mathbf{x}_i + R \begin{bmatrix} \cos(\alpha + b\,\pi/3) \\ \sin(\alpha +
#    b\,\pi/3) \end{bmatrix},
#    \qquad b = 0, \dots, 5. \tag{7.1} $$
#
# ## A worked example
#
# Let $\mathbf{x}_i = (0, 0)$ have the four neighbours $(2, 0)$, $(0, 2)$, $(-2, 0)$ and $(0, -2)$.
# Each of the four triangles has the area 2. The circumcentre of the first triangle is $(1, 1)$,
# since $(0, 0)$, $(2, 0)$ and $(0, 2)$ all have the distance $\sqrt2$ from it. The other
# circumcentres are $(-1, 1)$, $(-1, -1)$ and $(1, -1)$, so the cell is a square.
#
# The coordinates of this notebook are one weight for each corner. At the point $\mathbf{x} =
# (\tfrac12, 0)$ they are $\tfrac38, \tfrac18, \tfrac18, \tfrac38$; formulas (7.5) and (7.6) will
# give these numbers. They must sum to 1, and the mean of the corners with these weights must be
# $\mathbf{x}$. The next cell checks both. With the values $8, 0, 0, 0$ at the corners, the value at
# $\mathbf{x}$ is $\tfrac38 \cdot 8 = 3$.

# %%
square = np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]])
omega_by_hand = np.array([3, 1, 1, 3]) / 8
print("sum", omega_by_hand.sum(), "and mean of the corners", omega_by_hand @ square)

# %% [markdown]
# ### 07.1 The hexagon
#
# Write a function that returns the six neighbours. The centre is not the origin in general.


# %% question="07.1" minutes=15
def hexagon(center, radius, turn):
    """Return x_0 … x_5 of (7.1), of shape (6, 2).

    center (2,) is x_i, radius is R > 0, and turn is the angle α in radians.
    """
    # BEGIN SOLUTION
    angles = [turn + b * np.pi / 3 for b in range(6)]
    circle = np.array([[np.cos(angle), np.sin(angle)] for angle in angles])
    return center + radius * circle
    # END SOLUTION


# %%
check("07.1")

# %% [markdown]
# ## Circumcentres
#
# Triangle $a$ has the vertices $\mathbf{x}_i$, $\mathbf{x}_a$ and $\mathbf{x}_{a+1}$. Its
# circumcentre $\mathbf{p}_a$ has the same distance from all three:
#
# $$ \lVert \mathbf{p}_a - \mathbf{x}_i \rVert = \lVert \mathbf{p}_a - \mathbf{x}_a \rVert
#    = \lVert \mathbf{p}_a - \mathbf{x}_{a+1} \rVert. \tag{7.2} $$
#
# ### 07.2 The circumcentre of a triangle
#
# Write a function that returns the circumcentre of a triangle. It must keep its accuracy for
# triangles far from the origin and of any size. The equations (7.2) look quadratic, but squared and
# expanded around one corner they are two linear equations, because the square of the unknown
# cancels. If you have written 06.4, you may adapt your function: it is the same point, from three
# corners.
#
# <details><summary>Hint</summary>
#
# With $\mathbf{q} = \mathbf{p} - \mathbf{a}$ and an edge $\mathbf{e} = \mathbf{b} - \mathbf{a}$,
# the condition $\lVert\mathbf{q}\rVert^2 = \lVert\mathbf{q} - \mathbf{e}\rVert^2$ becomes
# $\mathbf{e}^T\mathbf{q} = \tfrac12 \lVert\mathbf{e}\rVert^2$. Write one such equation for each of
# two edges, and solve for $\mathbf{q}$. Differences of squares of the coordinates themselves lose
# digits by cancellation.
#
# </details>


# %% question="07.2" minutes=10
def circumcenter(a, b, c):
    """Return p of (7.2), of shape (2,), for a triangle with corners a, b, c, each (2,)."""
    # BEGIN SOLUTION
    edges = np.array([b - a, c - a])
    return a + np.linalg.solve(edges, [e @ e / 2 for e in edges])
    # END SOLUTION


# %%
check("07.2")

# %% [markdown]
# The next function applies yours to all triangles around a vertex.


# %%
def circumcenters(center, rim):
    """Return all p_a, of shape (N, 2), with your function."""
    following = [*rim[1:], rim[0]]
    return np.array([circumcenter(center, one, other) for one, other in zip(rim, following)])


# %% [markdown]
# The polygon of the circumcentres is a cell of the *circumcentric dual* of the mesh. The polygon of
# the centroids is a cell of the *barycentric dual*. Move one vertex of the hexagon with the slider
# and compare the two.


# %%
@draw(distance=Slider(0.4, 2.6, 1.8, "distance", steps=44))
def two_duals(distance):
    rim = hexagon(np.zeros(2), 1.0, 0.0)
    rim[0] *= distance
    ahead = np.array([*rim[1:], rim[0]])
    with figure(6.6, 2.2) as page:
        panels = page.subplots(1, 2)
        duals = {
            "circumcentres": circumcenters(np.zeros(2), rim),
            "centroids": (rim + ahead) / 3,
        }
        for axes, (name, dual) in zip(panels, duals.items()):
            for tip, next_tip in zip(rim, ahead):
                axes.plot(
                    [0, tip[0], next_tip[0]],
                    [0, tip[1], next_tip[1]],
                    color=GREY,
                    lw=1,
                )
            closed = np.array([*dual, dual[0]])
            axes.fill(*closed.T, fc="#e8eef5", ec=BLUE, lw=2)
            axes.plot(*dual.T, "o", color=BLUE, ms=4)
            edge = dual - np.array([dual[-1], *dual[:-1]])
            lengths = np.hypot(*edge.T) * np.hypot(*rim.T)
            off = np.degrees(np.arcsin(np.max(abs(np.einsum("bk,bk->b", edge, rim)) / lengths)))
            axes.set_title(f"{name}: {90 - off:.0f}° to the mesh")
            axes.set_aspect("equal")
            axes.set(xlim=(-1.05, 2.65), ylim=(-0.95, 0.95))
            axes.axis("off")
    return page


# %% [markdown]
# **What to look at.** Each edge of the left dual lies on the perpendicular bisector of an edge of
# the mesh, wherever the vertex is. Those of the right dual in general do not. Beyond the distance 2
# the sum of the two angles opposite to an edge exceeds 180°: the mesh is no longer a Delaunay mesh.
# Then two circumcentres exchange their order, and the left dual intersects itself. Question 07.10
# asks for the reason.
#
# ## Weights
#
# Let the edges of a convex polygon with the outward unit normals $\mathbf{n}_j$ and $\mathbf{n}_k$
# meet in the corner $\mathbf{p}_a$. Wachspress coordinates have the weights
#
# $$ w_a(\mathbf{x}) = \frac{\lvert \det(\mathbf{n}_j, \mathbf{n}_k) \rvert}
#    {\mathbf{n}_j^T(\mathbf{p}_a - \mathbf{x}) \;\; \mathbf{n}_k^T(\mathbf{p}_a - \mathbf{x})} .
#    \tag{7.3} $$
#
# Each factor of the denominator is the distance from $\mathbf{x}$ to the line through an edge,
# negative outside. So inside the polygon the weight of a corner is large near its two edges.
#
# In a Voronoi cell the mesh replaces the polygon. The edges of the cell are perpendicular to the
# edges of the mesh, so the normals are $\mathbf{n}_b = (\mathbf{x}_b - \mathbf{x}_i)/l_b$ with
# $l_b = \lVert\mathbf{x}_b - \mathbf{x}_i\rVert$. The determinant is the sine of the angle of the
# triangle at $\mathbf{x}_i$. With the area $A_a$ of the triangle,
#
# $$ \lvert \det(\mathbf{n}_j, \mathbf{n}_k) \rvert = \frac{2 A_a}{l_j\, l_k}, \qquad
#    A_a = \tfrac12 \lvert \det(\mathbf{x}_j - \mathbf{x}_i,\; \mathbf{x}_k - \mathbf{x}_i) \rvert ,
#    \tag{7.4} $$
#
# and the lengths cancel. The remaining formula contains no square root:
#
# $$ w_a(\mathbf{x}) = \frac{2 A_a}
#    {(\mathbf{x}_j - \mathbf{x}_i)^T(\mathbf{p}_a - \mathbf{x}) \;\; (\mathbf{x}_k -
#    \mathbf{x}_i)^T(\mathbf{p}_a - \mathbf{x})},
#    \qquad j = a, \quad k = a + 1. \tag{7.5} $$
#
# Weights become coordinates when they are divided by their sum:
#
# $$ \omega_a(\mathbf{x}) = \frac{w_a(\mathbf{x})}{\sum_{e} w_e(\mathbf{x})} . \tag{7.6} $$
#
# ### Example: the weights, by hand
#
# For the square cell of the worked example and the point $\mathbf{x} = (\tfrac12, 0)$ the weights
# (7.5) are
#
# $$ w_0 = \frac{4}{1 \cdot 2} = 2, \qquad w_1 = \frac{4}{2 \cdot 3} = \tfrac23, \qquad
#    w_2 = \frac{4}{3 \cdot 2} = \tfrac23, \qquad w_3 = \frac{4}{2 \cdot 1} = 2. $$
#
# For the first one, $(2, 0) \cdot (\tfrac12, 1) = 1$ and $(0, 2) \cdot (\tfrac12, 1) = 2$. The sum
# is $\tfrac{16}{3}$, and (7.6) gives the coordinates $\tfrac38, \tfrac18, \tfrac18, \tfrac38$.

# %% [markdown]
# Here is a finished function of the kind that you will write, for the cell with three corners. In a
# triangle the two requirements, sum 1 and mean $\mathbf{x}$, are three linear equations, so they
# determine the three coordinates. The function evaluates them for many points at once: it returns a
# row for each point.


# %%
def triangle_coordinates(corners, x):
    """Return the barycentric coordinates of points x (M, 2), of shape (M, 3).

    corners (3, 2) are the corners of a triangle.
    """
    matrix = np.vstack([corners.T, np.ones(3)])
    right_sides = np.vstack([x.T, np.ones(len(x))])
    return np.linalg.solve(matrix, right_sides).T


print(triangle_coordinates(np.array([[0, 0], [4, 0], [0, 4]]), np.array([[1, 1], [2, 2]])))

# %% [markdown]
# ### 07.3 The area of a triangle
#
# Write a function that returns $A$ of (7.4). An area must be positive for both orders of the
# corners. The triangle may have any size and may be as thin as a needle. The result must keep its
# accuracy far from the origin as well, so use differences of the corners.


# %% question="07.3" minutes=10
def area(a, b, c):
    """Return A of (7.4), a number, for a triangle with corners a, b, c, each (2,)."""
    # BEGIN SOLUTION
    return 0.5 * abs(np.linalg.det([b - a, c - a]))
    # END SOLUTION


# %%
check("07.3")

# %% [markdown]
# ### 07.4 The weights
#
# Write a function that returns the weights (7.5) of all corners for one point $\mathbf{x}$. The
# corners are an argument. The number $N$ of neighbours may be any number from 3 on, and the
# neighbours may be listed clockwise or counter-clockwise. The point may lie outside the cell; some
# weights are negative there. It does not lie on a line through an edge of the cell, where (7.5)
# divides by zero. The cell may have any size, from $10^{-9}$ to $10^9$.
#
# <details><summary>Hint</summary>
#
# A loop over $a$ with (7.5) in its body is a good answer. The neighbour after the last one is the
# first one. The operator `%` gives its index, and so does the index $-1$ if you look backwards.
#
# </details>


# %% question="07.4" minutes=20
def weights(center, rim, corners, x):
    """Return w_0 … w_{N−1} of (7.5), of shape (N,), at one point x (2,).

    center (2,) is x_i, rim (N, 2) are its neighbours x_0, x_1 … in order, and
    corners (N, 2) are the circumcentres p_0, p_1 … .
    """
    # BEGIN SOLUTION
    w = np.empty(len(rim))
    for a in range(len(rim)):
        j, k = rim[a], rim[(a + 1) % len(rim)]
        to_corner = corners[a] - x
        below = ((j - center) @ to_corner) * ((k - center) @ to_corner)
        w[a] = 2 * area(center, j, k) / below
    return w
    # END SOLUTION


# %%
check("07.4")

# %% [markdown]
# ### 07.5 The coordinates
#
# Write a function that returns the coordinates (7.6) of many points. At every point its $N$
# coordinates must sum to 1, and $\sum_a \omega_a(\mathbf{x})\, \mathbf{p}_a = \mathbf{x}$ must
# hold. The first requirement is called *partition of unity* and the second one *linear precision*.
# Other coordinates satisfy both, too, but here those of (7.6) are required, for cells as in 07.4,
# and for points inside and outside. No point is on a line through an edge, and at none is the sum
# in (7.6) zero.


# %% question="07.5" minutes=10
def coordinates(center, rim, corners, x):
    """Return ω_a of (7.6) at points x (M, 2), of shape (M, N): a row for each point."""
    # BEGIN SOLUTION
    w = [weights(center, rim, corners, point) for point in x]
    return np.array([row / row.sum() for row in w])
    # END SOLUTION


# %%
check("07.5")

# %% [markdown]
# ## One coordinate in two cells
#
# The left cell is your own hexagon, with the centre, radius and angle of your student number.
# The right cell belongs to a vertex with random neighbours.


# %%
def over_the_cell(corners):
    """Return points of a convex cell, in rings that end just before its boundary."""
    sides = zip(corners, [*corners[1:], corners[0]])
    edge = np.concatenate([np.linspace(p, q, 20) for p, q in sides])
    middle = corners.mean(axis=0)
    return middle + np.linspace(0, 0.999, 24)[:, None, None] * (edge - middle)


@draw(a=Slider(0, 5, 0, "corner a", whole=True))
def one_coordinate(a):
    center, radius, turn = data("07.1")
    random = np.random.default_rng(5)
    angle = np.linspace(0, 2 * np.pi, 7)[:-1] + random.uniform(0, 0.7, 6)
    uneven = random.uniform(0.8, 1.3, (6, 1)) * np.column_stack([np.cos(angle), np.sin(angle)])
    stars = ((center, hexagon(center, radius, turn)), (np.zeros(2), uneven))
    with figure(6.4, 3.2) as page:
        panels = page.subplots(1, 2)
        for axes, (middle, rim) in zip(panels, stars):
            corners = circumcenters(middle, rim)
            grid = over_the_cell(corners)
            omega = coordinates(middle, rim, corners, grid.reshape(-1, 2))
            heights = omega[:, a].reshape(grid.shape[:2])
            levels = axes.contourf(*grid.T, heights.T, levels=np.linspace(0, 1, 11))
            axes.plot(*np.array([*corners, corners[0]]).T, color=GREY)
            axes.plot(*corners[a], "o", color=ORANGE, ms=8)
            axes.plot(*middle, "+", color="black")
            axes.set_aspect("equal")
            axes.axis("off")
        page.colorbar(levels, ax=panels, label=rf"$\omega_{a}$", shrink=0.8)
    return page


# %% [markdown]
# **What to look at.** The coordinate is 1 at its corner, is linear along the two edges of this
# corner, and is 0 on all other edges. So the interpolated field is linear on each edge of the cell.
# Two cells that share an edge have the same values there, and the field is continuous on the whole
# mesh.
#
# ## A spiral
#
# A *hyperbolic spiral* runs from near an edge of the cell towards its centre. Let $\mathbf{p}_a$
# and $\mathbf{p}_b$ be two *neighbouring* corners, and
#
# $$ \mathbf{s}_n = \mathbf{x}_i + \frac{r}{n} \begin{bmatrix} \cos(n\,\Delta\theta) \\
#    \sin(n\,\Delta\theta) \end{bmatrix},
#    \quad n = 1, \dots, S, \qquad
#    r = \lVert \frac{\mathbf{p}_a + \mathbf{p}_b}{2} - \mathbf{x}_i \rVert, \quad
#    \Delta\theta = \frac{2\pi}{S} . \tag{7.7} $$
#
# In a regular hexagon $r$ is the distance from $\mathbf{x}_i$ to the edges of the cell.
#
# ### 07.6 The points of the spiral
#
# Write a function that returns the $S$ points of (7.7), for any $S \ge 1$.


# %% question="07.6" minutes=20
def spiral(center, corners, steps):
    """Return s_1 … s_S of (7.7), of shape (S, 2), with S = steps.

    center (2,) is x_i; p_a and p_b are the first two of corners (N, 2).
    """
    # BEGIN SOLUTION
    r = np.linalg.norm((corners[0] + corners[1]) / 2 - center)
    s = []
    for n in range(1, steps + 1):
        angle = n * 2 * np.pi / steps
        s.append(center + r / n * np.array([np.cos(angle), np.sin(angle)]))
    return np.array(s)
    # END SOLUTION


# %%
check("07.6")

# %% [markdown]
# ### 07.7 The interpolated field
#
# With a value $\phi_a$ at each corner, the interpolated field is
#
# $$ f(\mathbf{x}) = \sum_a \omega_a(\mathbf{x})\, \phi_a . \tag{7.8} $$
#
# Write a function that evaluates it at many points, for any number $N$ of corners. The points lie
# inside the cell and outside, but not on a line through an edge, nor where the weights sum to zero.


# %% question="07.7" minutes=10
def interpolate(center, rim, corners, values, x):
    """Return f of (7.8) at points x (M, 2), of shape (M,), for values φ (N,)."""
    # BEGIN SOLUTION
    return coordinates(center, rim, corners, x) @ values
    # END SOLUTION


# %%
check("07.7")


# %%
def fields(n):
    """Return three fields to be interpolated."""
    return {
        "constant": lambda p: np.ones(len(p)),
        "linear": lambda p: p.sum(axis=1),
        f"power {n}": lambda p: p.sum(axis=1) ** n,
    }


@draw(n=Slider(2, 6, 2, "power n", whole=True))
def on_the_spiral(n):
    center, radius, turn = data("07.1")
    rim = hexagon(center, radius, turn)
    corners = circumcenters(center, rim)
    points = spiral(center, corners, 50)
    number = np.arange(1, 51)
    with figure(7.6, 2.7) as page:
        cell, inner, left, right = page.subplots(1, 4, width_ratios=(1, 0.9, 1.1, 1.1))
        for axes in (cell, inner):
            axes.fill(*((corners - center) / radius).T, fc="#e8eef5", ec=BLUE)
            axes.plot(*((points - center) / radius).T, ".-", color=ORANGE, ms=4, lw=0.8)
            axes.plot(0, 0, "+", color="black")
            axes.set(aspect="equal", xticks=[], yticks=[])
        inner.set(xlim=(-0.065, 0.065), ylim=(-0.065, 0.065), title="centre, 9 ×")
        cell.set(title="your cell")
        cell.axis("off")
        styles = ((PURPLE, "-"), (BLUE, "--"), (ORANGE, ":"))
        for (name, field), (color, dashes) in zip(fields(n).items(), styles):
            value = interpolate(center, rim, corners, field(corners), points)
            left.plot(number, field(points), color="#cccccc", lw=4)
            left.plot(number, value, color=color, ls=dashes, label=name)
            error = np.maximum(abs(value - field(points)), 1e-17)
            right.loglog(number, error, color=color, ls=dashes, label=name)
        left.set(xlabel="$n$", xscale="log", title="exact (grey), yours")
        right.set(xlabel="$n$", ylim=(1e-18, 1e2), title="error")
        page.legend(*left.get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return page


# %% [markdown]
# **What to look at.** The left panels show the spiral and, enlarged, its inner part. The panel in
# the middle shows the values along the spiral, and the right panel shows the errors. Which of the
# three errors consist of rounding only? Where along the spiral is the third error largest? Question
# 07.9 asks for an explanation.
#
# ## Drag a point
#
# The areas of the dots and the lengths of the bars are the six coordinates. The ring is at
# $\sum_a \omega_a \mathbf{p}_a$. Drag the point, or click on the picture and use the arrow keys
# (*Shift* for small steps, *Home* for the initial position).

# %%
h = np.sqrt(3) / 2


@drag(
    corners=[(h, 0.5), (0, 1), (-h, 0.5), (-h, -0.5), (0, -1), (h, -0.5)],
    values=[1.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    start=(0.35, 0.25),
)
def under_the_pointer(x):
    rim = hexagon(np.zeros(2), np.sqrt(3), 0.0)
    return coordinates(np.zeros(2), rim, circumcenters(np.zeros(2), rim), x)


# %% [markdown]
# **What to look at.** Drag the point to the midpoint of an edge, into a corner, along an edge, and
# to the centre. How many coordinates are not zero in each position? The ring must stay at the
# point; which requirement says so? Corner 0 has the value 1 and the others have the value 0, so the
# value at the point is the coordinate of corner 0. At which points is it one half?
#
# ## Evaluation on an edge
#
# On an edge, (7.5) divides by zero for both ends of the edge. *Near* an edge the result is
# inaccurate without a warning. The small number
# $(\mathbf{x}_b - \mathbf{x}_i)^T(\mathbf{p}_a - \mathbf{x})$ is a difference of nearly equal
# numbers. It is computed twice, once from each end of the edge, with two different rounding errors.
#
# The remedy uses the circumcentre. It has the same distance from $\mathbf{x}_b$ and $\mathbf{x}_i$,
# so $(\mathbf{x}_b - \mathbf{x}_i)^T(\mathbf{p}_a - \mathbf{x}_i) = \tfrac12 l_b^2$, and therefore
#
# $$ (\mathbf{x}_b - \mathbf{x}_i)^T(\mathbf{p}_a - \mathbf{x}) = h_b(\mathbf{x}), \qquad
#    h_b(\mathbf{x}) = \tfrac12 l_b^2 - (\mathbf{x}_b - \mathbf{x}_i)^T(\mathbf{x} - \mathbf{x}_i) .
#    \tag{7.9} $$
#
# The function $h_b$ depends on the neighbour $b$ only, and not on a corner. So the number is the
# same for both ends of the edge. Now multiply all weights by the product of all $h_b$. This changes
# no ratio of weights, and all denominators cancel:
#
# $$ \omega_a = \frac{c_a}{\sum_e c_e}, \qquad c_a(\mathbf{x}) = A_a \prod_{b \,\ne\, a,\; a+1}
#    h_b(\mathbf{x}) . \tag{7.10} $$
#
# In the worked example $h = (1, 2, 3, 2)$, and the products are $c = (12, 4, 4, 12)$.
#
# ### 07.8 Coordinates without division
#
# Write a function that returns the coordinates (7.10) of many points. They must be accurate inside
# the cell, on its edges, in its corners and outside, also on the extension of an edge. At no given
# point is the sum in (7.10) zero. The cell may be far from the origin, up to $10^6$ times its size,
# and may have any size, such as $10^{-9}$. (Such a small cell has at most ten neighbours: a product
# of many more tiny $h_b$ is rounded to zero.) The circumcentres are not arguments, since (7.10)
# does not need them.
#
# <details><summary>Hint</summary>
#
# First compute all $h_b$ at all points, as an array of shape $(N, M)$. Then, for each $a$, remove
# two of its rows (`numpy.delete`) and multiply the remaining rows.
#
# </details>


# %% question="07.8" minutes=25
def safe_coordinates(center, rim, x):
    """Return ω_a of (7.10) at points x (M, 2), of shape (M, N): inside, on edges, in corners and
    outside, and for cells of any size.
    """
    # BEGIN SOLUTION
    h = np.array([s @ s / 2 - (x - center) @ s for s in rim - center])
    c = np.empty(h.shape)
    for a in range(len(rim)):
        b = (a + 1) % len(rim)
        others = np.delete(h, [a, b], axis=0)
        c[a] = area(center, rim[a], rim[b]) * others.prod(axis=0)
    return (c / c.sum(axis=0)).T
    # END SOLUTION


# %%
check("07.8")


# %%
@draw(along=Slider(0.05, 0.95, 0.3, "along the edge", steps=18))
def towards_the_edge(along):
    center, radius, turn = data("07.1")
    rim = hexagon(center, radius, turn)
    corners = circumcenters(center, rim)
    on_edge = (1 - along) * corners[0] + along * corners[1]
    steps = np.logspace(-17, -0.5, 100)
    points = on_edge + steps[:, None] * (center - on_edge)
    with figure(6.4, 3.1) as page, np.errstate(all="ignore"):
        axes = page.subplots()
        methods = (
            (
                coordinates(center, rim, corners, points),
                "quotients (7.5)",
                ORANGE,
                "o",
            ),
            (safe_coordinates(center, rim, points), "products (7.10)", BLUE, "."),
        )
        for omega, name, color, marker in methods:
            error = np.linalg.norm(omega @ corners - points, axis=1) / radius
            lost = int((~np.isfinite(error)).sum())
            name += f", {lost} not finite" if lost else ""
            axes.loglog(
                steps,
                np.maximum(error, 1e-17),
                marker,
                ms=4,
                color=color,
                label=name,
            )
        axes.set(
            xlabel="distance from the edge, relative to that of the centre",
            ylabel=r"$\Vert\sum_a \omega_a \mathbf{p}_a - \mathbf{x}\Vert \;/\; R$",
            ylim=(3e-18, 30),
        )
        axes.legend()
    return page


# %% [markdown]
# **What to look at.** The points approach the edge from right to left. Each time the distance is
# ten times smaller, the quotients lose another digit without a warning. The products are accurate
# at every distance, and on the edge as well. They contain the same differences of nearly equal
# numbers. Why does this do no harm in (7.10)?
#
# ## Real data: heights of a landscape
#
# The file `fieldcheck/datasets/terrain.json` holds 3000 heights around Cross Mountain in
# Tennessee. They were measured by the Shuttle Radar Topography Mission (public domain). `terrain()`
# returns the points, the nodes of a grid, in kilometres and the heights in metres.
#
# The next picture covers most of the map with hexagons whose corners are nodes. Suppose that only
# the heights at the corners are known. Your functions interpolate them in each cell, and the error
# is measured at all other nodes. Many of these are on an edge, so the picture uses
# `safe_coordinates`. The hexagons on the map are slightly narrower than regular ones. Stretching a
# cell changes none of the coordinates, so your functions compute them in a regular hexagon.


# %%
@draw(size=Slider(1, 3, 2, "size of the cells", whole=True))
def landscape(size):
    points, heights = terrain()
    x, y = np.unique(points[:, 0]), np.unique(points[:, 1])
    measured = heights.reshape(len(y), len(x))
    # A regular cell, and its corners and nodes, in steps of the grid from its centre.
    rim = hexagon(np.zeros(2), np.sqrt(3), 0.0)
    regular = circumcenters(np.zeros(2), rim)
    steps = size * np.array([4 / np.sqrt(3), 2])
    corner = np.rint(regular * steps).astype(int)
    side = np.arange(-2 * size, 2 * size + 1)
    node = np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2)
    node = node[np.all(node / steps @ rim.T < 1.5 + 1e-9, axis=1)]
    omega = safe_coordinates(np.zeros(2), rim, node / steps)
    # All cells on the map.
    yours, known, cells = np.full(measured.shape, np.nan), np.zeros(measured.shape, bool), []
    for k, row in enumerate(range(2 * size, len(y) - 2 * size, 3 * size)):
        for column in range(2 * size * (1 + k % 2), len(x) - 2 * size, 4 * size):
            across, up = (corner + [column, row]).T
            inside = tuple((node + [column, row]).T[::-1])
            yours[inside] = omega @ measured[up, across]
            known[up, across] = True
            cells.append([x[across], y[up]])
    others = np.isfinite(yours) & ~known
    error = np.sqrt(np.mean((yours - measured)[others] ** 2))
    with figure(6.8, 3.1) as page:
        panels = page.subplots(1, 2, sharey=True)
        page.suptitle(f"{known.sum()} corners, error {error:.0f} m at {others.sum()} other nodes")
        for axes, name, shown in zip(panels, ("measured", "your field"), (measured, yours)):
            levels = np.linspace(200, 1100, 19)
            image = axes.contourf(x, y, shown, levels, extend="both", cmap="terrain")
            image.set_rasterized(True)
            axes.set(title=name, aspect="equal", xlabel="km to the east")
        for east, north in cells:
            panels[1].fill(east, north, fc="none", ec="black", lw=0.5)
        panels[0].set(ylabel="km to the north")
        page.colorbar(image, ax=list(panels), label="height in metres")
    return page


# %% [markdown]
# **What to look at.** The error is the root mean square. Halve the size of the cells: how much does
# the error decrease? Each corner belongs to up to three cells, and the field is continuous across
# their edges. Why? The coordinates are not negative in a cell, so no value is greater than at the
# highest corner. What happens to a summit inside a cell?
#
# ## In words
#
# **07.9** Explain the errors of the three fields along the spiral by the properties of the
# coordinates. For $\phi_a = (p_{a,1} + p_{a,2})^2$ derive the limit of the error at the centre of a
# hexagon of radius $R$ around the origin.
#
# <details><summary>Hint</summary>
#
# What are all coordinates at $\mathbf{x}_i$, by symmetry? The corners have the distance $R/\sqrt3$
# from $\mathbf{x}_i$.
#
# </details>

# %% [markdown] answer="07.9" points=4 minutes=15 words=90
# The constant is reproduced up to rounding at all points, since the coordinates sum to one
# (partition of unity). The linear field is reproduced up to rounding because $\sum_a \omega_a
# \mathbf{p}_a = \mathbf{x}$ (linear precision).
#
# The quadratic field is not reproduced. By symmetry all six coordinates are $1/6$ at the centre, so
# the value there is the mean of the $\phi_a$. The corners at the distance $R/\sqrt3$ have the mean
# $R^2/3$, while the field is zero at the centre. So the error tends to $R^2/3$.
#
# *Beyond the question.* For every field $\phi(\mathbf{x}) = c_0 + \mathbf{c}^T\mathbf{x}$ the sum
# is $c_0 \sum_a \omega_a + \mathbf{c}^T \sum_a \omega_a \mathbf{p}_a$, so affine fields are
# reproduced, and other fields are not in general. The limit grows with the square of the size of
# the cell. By linear precision it is the same for a hexagon with another centre. Close to an edge
# the error is smaller, since two neighbouring corners have nearly all the weight.

# %% [markdown] rubric="07.9"
# One point for the constant with partition of unity as the reason. One for the linear field with
# linear precision as the reason. One for the coordinates $1/6$, so that the value at the centre is
# the mean of the corners. One for the limit $R^2/3$.

# %% [markdown]
# **07.10** Why are the circumcentric dual cells of the inner vertices of a Delaunay mesh convex and
# without overlap?
#
# <details><summary>Hint</summary>
#
# Which vertices are nearest to a circumcentre? Move the slider of the picture with two duals beyond
# 2, and count the vertices inside a circumscribed circle.
#
# </details>

# %% [markdown] answer="07.10" points=3 minutes=10 words=100
# In a Delaunay mesh no vertex is inside the circumscribed circle of a triangle. So no vertex is
# closer to the circumcentre $\mathbf{p}_a$ than the corners of its triangle, and the circumcentres
# around an inner vertex are the corners of its Voronoi cell: of all points that are at least as
# close to this vertex as to any other. This cell is an intersection of half-planes, one for each
# other vertex, so it is convex. Cells of two vertices have only boundary points in common, since an
# inner point is closer to its own vertex than to all others.
#
# *Beyond the question.* Dual edges are perpendicular to the edges of the mesh in every mesh, since
# both ends lie on the perpendicular bisector of the edge. Convexity is lost in a mesh that is not a
# Delaunay mesh: two circumcentres exchange their order along a bisector, and the dual intersects
# itself. In the picture this happens beyond the distance 2, where the two angles opposite to an
# edge sum to more than 180°. A circumcentre outside its triangle alone does no harm.

# %% [markdown] rubric="07.10"
# One point for empty circumscribed circles. One for the circumcentres as corners of the Voronoi
# cell. One for convex cells without overlap: intersections of half-planes, or sets of points
# closest to one vertex.

# %% [markdown]
# **07.11** Derive (7.5) from (7.3). Name the property of the dual that you use, and show how the
# lengths $l_j$ and $l_k$ cancel.

# %% [markdown] answer="07.11" points=3 minutes=10 words=80 optional
# Edges of the dual and of the mesh are perpendicular. So the outward normals of the cell at
# $\mathbf{p}_a$ are $\mathbf{n}_j = (\mathbf{x}_j - \mathbf{x}_i)/l_j$ and $\mathbf{n}_k =
# (\mathbf{x}_k - \mathbf{x}_i)/l_k$. Their determinant is that of $\mathbf{x}_j - \mathbf{x}_i$ and
# $\mathbf{x}_k - \mathbf{x}_i$, divided by $l_j l_k$. The determinant of these two vectors is twice
# the area, up to its sign, which the absolute value removes. Each factor of the denominator of
# (7.3) is $(\mathbf{x}_b - \mathbf{x}_i)^T(\mathbf{p}_a - \mathbf{x})$ divided by $l_b$. So
# numerator and denominator are both divided by $l_j l_k$, which cancels.

# %% [markdown] rubric="07.11"
# One point for the normals along the edges of the mesh, by orthogonality. One for the determinant
# as twice the area. One for the factor $1/(l_j l_k)$ in the numerator and in the denominator.

# %% [markdown]
# ## Dig deeper
#
# - Rotate a hexagon so that an edge of the mesh has the angle $\Delta\theta = 7.2°$. The first
#   point of the spiral is then on an edge of the cell. What do `coordinates` and `safe_coordinates`
#   return there?
# - Why is a hexagon of six equilateral triangles a Delaunay mesh? Which properties does the
#   barycentric dual have?
# - Leave out the absolute value of (7.4). What happens if some triangles are listed clockwise and
#   others are not?
# - Evaluate the coordinates outside the cell. Some are negative, but linear fields must still be
#   reproduced. At some points outside, the sum of all $c_a$ vanishes. Where are they for a square
#   cell, and where for another quadrilateral?
# - What is the gradient of $f$? Differentiate (7.10) with
#   $\nabla h_b = -(\mathbf{x}_b - \mathbf{x}_i)$, and check the result by difference quotients.
# - Six points on a circle around $\mathbf{p}_a$ form several triangles with the same circumcentre.
#   What does (7.10) give there? Which sum of coordinates is well defined?
#
# **Next**: notebook 08 does the same in space, and notebook 13 needs interpolation at departure
# points.

# %%
progress()
