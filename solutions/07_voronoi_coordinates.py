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
# # Voronoi coordinates in a hexagon
#
# A fluid solver keeps one pressure in each triangle of its mesh, at the circumcentre. A marker
# drifts by, between the circumcentres. What is the pressure there?
#
# The circumcentres round a vertex are the corners of a polygon, the *Voronoi cell* of the vertex.
# In this notebook you mix the values at its corners with weights that depend on the place, as the
# three corners of a triangle are mixed by barycentric coordinates. You write these weights for any
# cell from the triangles alone, follow them along a spiral, drag a point about to feel them, and
# make them safe on the edge, where the formula divides by zero.
#
# Each question asks for a short function. Write it, run its cell, and run the check below it: it
# tells whether the function is right and, if not, what kind of mistake it may be.

# %% tags=["setup"]
import numpy as np

from fieldcheck import (
    BLUE,
    GREY,
    ORANGE,
    PURPLE,
    Slider,
    check,
    data,
    drag,
    draw,
    figure,
    progress,
    start_over,
)

# %% [markdown]
# ## The problem in a picture
#
# Six triangles round a vertex $\mathbf{x}_i$ make a hexagon. The dots are their circumcentres,
# where a value is known; its number stands beside each. The hexagon of dots is the Voronoi cell of
# $\mathbf{x}_i$: all places that are nearer to $\mathbf{x}_i$ than to any other vertex. What is the
# value at the question mark?


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
            label="asked for",
        )
        axes.set_aspect("equal")
        axes.axis("off")
        axes.legend(loc="center left", bbox_to_anchor=(1.02, 0.5))
    return page


# %% [markdown]
# ## The mesh
#
# Let $\mathbf{x}_i$ be the vertex in the middle, and $\mathbf{x}_0, \dots, \mathbf{x}_{N-1}$ its
# neighbours in order round it. Indices begin at zero, as in NumPy, and go round: $\mathbf{x}_N$ is
# $\mathbf{x}_0$ again. For a regular hexagon with the radius $R$, turned by the angle $\alpha$,
#
# $$ \mathbf{x}_b = \mathbf{x}_i + R \begin{bmatrix} \cos(\alpha + b\,\pi/3) \\ \sin(\alpha +
#    b\,\pi/3) \end{bmatrix},
#    \qquad b = 0, \dots, 5. \tag{7.1} $$
#
# ### 07.1 A hexagon
#
# Your hexagon will not be centred at the origin. Much that goes wrong in geometry goes wrong only
# then.


# %% question="07.1"
def hexagon(center, radius, turn):
    """Return x_0 … x_5 of (7.1), of shape (6, 2).

    center (2,) is x_i, radius is R, and turn is the angle α.
    """
    # BEGIN SOLUTION
    directions = [turn + b * np.pi / 3 for b in range(6)]
    circle = np.array([[np.cos(way), np.sin(way)] for way in directions])
    return center + radius * circle
    # END SOLUTION


# %%
check("07.1")

# %% [markdown]
# ## Circumcentres
#
# The triangle number $a$ has the vertices $\mathbf{x}_i$, $\mathbf{x}_a$ and $\mathbf{x}_{a+1}$.
# Its circumcentre $\mathbf{p}_a$ is as far from one of them as from the others:
#
# $$ \lVert \mathbf{p}_a - \mathbf{x}_i \rVert = \lVert \mathbf{p}_a - \mathbf{x}_a \rVert
#    = \lVert \mathbf{p}_a - \mathbf{x}_{a+1} \rVert. \tag{7.2} $$
#
# ### 07.2 The circumcentre of a triangle
#
# The equations (7.2) look quadratic, and are not: square them, expand around one corner, and
# the square of the unknown cancels. Two linear equations are left.
#
# <details><summary>Hint</summary>
#
# With $\mathbf{q} = \mathbf{p} - \mathbf{a}$ and an edge $\mathbf{e} = \mathbf{b} - \mathbf{a}$,
# the condition $\lVert\mathbf{q}\rVert^2 = \lVert\mathbf{q} - \mathbf{e}\rVert^2$ becomes
# $\mathbf{e}^T\mathbf{q} = \tfrac12 \lVert\mathbf{e}\rVert^2$. Write one such equation for each of
# two edges, and solve. What has to be done with $\mathbf{q}$ at the end?
#
# </details>


# %% question="07.2"
def circumcenter(a, b, c):
    """Return p of (7.2), of shape (2,), for a triangle with corners a, b, c, each (2,)."""
    # BEGIN SOLUTION
    edges = np.array([b - a, c - a])
    return a + np.linalg.solve(edges, [e @ e / 2 for e in edges])
    # END SOLUTION


# %%
check("07.2")

# %% [markdown]
# All circumcentres round a vertex, with your function:


# %%
def circumcenters(center, rim):
    """Return all p_a, of shape (N, 2), with your function."""
    following = [*rim[1:], rim[0]]
    return np.array([circumcenter(center, one, other) for one, other in zip(rim, following)])


# %% [markdown]
# Joining the circumcentres gives the *circumcentric dual* of the mesh. Joining the centroids gives
# another dual, which is used as well. Pull one vertex of the hexagon and watch both.


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
            way = dual - np.array([dual[-1], *dual[:-1]])
            lengths = np.hypot(*way.T) * np.hypot(*rim.T)
            off = np.degrees(np.arcsin(np.max(abs(np.einsum("bk,bk->b", way, rim)) / lengths)))
            axes.set_title(f"{name}: off a right angle by {off:.0f}°")
            axes.set_aspect("equal")
            axes.set(xlim=(-1.05, 2.65), ylim=(-0.95, 0.95))
            axes.axis("off")
    return page


# %% [markdown]
# **What to look at.** Each edge of the left dual stands at right angles on an edge of the mesh,
# wherever the vertex is, and cuts it in half. On the right it does neither. Beyond the distance 2
# two triangles are obtuse, with their circumcentres outside, and then the left dual crosses itself.
# Question 07.10 asks why. To which distance is the mesh Delaunay?
#
# ## Weights
#
# For a corner $\mathbf{p}_a$ of a convex polygon, where two edges with the outward unit normals
# $\mathbf{n}_j$ and $\mathbf{n}_k$ meet, Warren and others take
#
# $$ w_a(\mathbf{x}) = \frac{\lvert \det(\mathbf{n}_j, \mathbf{n}_k) \rvert}
#    {\mathbf{n}_j^T(\mathbf{p}_a - \mathbf{x}) \;\; \mathbf{n}_k^T(\mathbf{p}_a - \mathbf{x})} .
#    \tag{7.3} $$
#
# Each factor of the denominator is the distance from $\mathbf{x}$ to an edge. Near the edges of a
# corner its weight is large, elsewhere it is small: the corner draws the value at $\mathbf{x}$ to
# its own.
#
# In a Voronoi cell nothing of this need be computed from the polygon. Its edges are perpendicular
# to those of the mesh, so the normals are $\mathbf{n}_b = (\mathbf{x}_b - \mathbf{x}_i)/l_b$ with
# $l_b = \lVert\mathbf{x}_b - \mathbf{x}_i\rVert$. The determinant is the sine of the angle of the
# triangle at $\mathbf{x}_i$. With the area $A_a$ of the triangle,
#
# $$ \lvert \det(\mathbf{n}_j, \mathbf{n}_k) \rvert = \frac{2 A_a}{l_j\, l_k}, \qquad
#    A_a = \tfrac12 \lvert \det(\mathbf{x}_j - \mathbf{x}_i,\; \mathbf{x}_k - \mathbf{x}_i) \rvert ,
#    \tag{7.4} $$
#
# and the lengths cancel. What is left needs no square root:
#
# $$ w_a(\mathbf{x}) = \frac{2 A_a}
#    {(\mathbf{x}_j - \mathbf{x}_i)^T(\mathbf{p}_a - \mathbf{x}) \;\; (\mathbf{x}_k -
#    \mathbf{x}_i)^T(\mathbf{p}_a - \mathbf{x})},
#    \qquad j = a, \quad k = a + 1. \tag{7.5} $$
#
# ### 07.3 The area of a triangle
#
# An area is positive, whichever way round the corners are listed.


# %% question="07.3"
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
# Now (7.5), for one place $\mathbf{x}$ and all corners $a$. The corners are handed over, so that
# you see at a glance what else is needed. They need not be those of a hexagon: $N$ may be anything
# from 3 on, and the neighbours may be listed either way round.
#
# <details><summary>Hint</summary>
#
# A loop over $a$ with (7.5) in its body is a good answer. The neighbour after the last is the
# first: the operator `%` helps, and so does an index of $-1$ if you look backwards instead.
#
# </details>


# %% question="07.4"
def weights(center, rim, corners, x):
    """Return w_0 … w_{N−1} of (7.5), of shape (N,), at one place x (2,).

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
# Weights become coordinates when they are divided by their sum:
#
# $$ \omega_a(\mathbf{x}) = \frac{w_a(\mathbf{x})}{\sum_{e} w_e(\mathbf{x})} . \tag{7.6} $$
#
# Then $\sum_a \omega_a(\mathbf{x}) = 1$ at every $\mathbf{x}$. Less obvious is that also $\sum_a
# \omega_a(\mathbf{x})\, \mathbf{p}_a = \mathbf{x}$, which is why they may be called coordinates.
# The check tries both.


# %% question="07.5"
def coordinates(center, rim, corners, x):
    """Return ω_a of (7.6) at places x (M, 2), of shape (M, N): a row for each place."""
    # BEGIN SOLUTION
    w = [weights(center, rim, corners, place) for place in x]
    return np.array([row / row.sum() for row in w])
    # END SOLUTION


# %%
check("07.5")

# %% [markdown]
# ## Look at a coordinate
#
# One coordinate over two cells: that of your own hexagon (centre, radius and angle come from
# `student.txt`), and that of a vertex with neighbours at random.


# %%
def over_the_cell(corners):
    """Return places all over a convex cell, in rings that end just before its edge."""
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
            places = over_the_cell(corners)
            omega = coordinates(middle, rim, corners, places.reshape(-1, 2))
            heights = omega[:, a].reshape(places.shape[:2])
            levels = axes.contourf(*places.T, heights.T, levels=np.linspace(0, 1, 11))
            axes.plot(*np.array([*corners, corners[0]]).T, color=GREY)
            axes.plot(*corners[a], "o", color=ORANGE, ms=8)
            axes.plot(*middle, "+", color="black")
            axes.set_aspect("equal")
            axes.axis("off")
        page.colorbar(levels, ax=panels, label=rf"$\omega_{a}$", shrink=0.8)
    return page


# %% [markdown]
# **What to look at.** The coordinate is 1 at its corner, falls in a straight line along the two
# edges there, and is 0 on all other edges. So along an edge the value is interpolated linearly
# between the two ends. Two cells that share the edge agree on it: the field is continuous over the
# whole mesh.
#
# ## The spiral
#
# A spiral visits the cell from close to an edge to the centre. Let $\mathbf{p}_a$ and
# $\mathbf{p}_b$ be two *neighbouring* corners, and
#
# $$ \mathbf{s}_n = \mathbf{x}_i + \frac{r}{n} \begin{bmatrix} \cos(n\,\Delta\theta) \\
#    \sin(n\,\Delta\theta) \end{bmatrix},
#    \quad n = 1, \dots, S, \qquad
#    r = \lVert \frac{\mathbf{p}_a + \mathbf{p}_b}{2} - \mathbf{x}_i \rVert, \quad
#    \Delta\theta = \frac{2\pi}{S} . \tag{7.7} $$
#
# In a regular hexagon $r$ is the distance from $\mathbf{x}_i$ to an edge of the cell, the same for
# all edges.
#
# ### 07.6 The points of the spiral


# %% question="07.6"
def spiral(center, corners, steps):
    """Return s_1 … s_S of (7.7), of shape (S, 2), with S = steps.

    center (2,) is x_i; p_a and p_b are the first two of corners (N, 2).
    """
    # BEGIN SOLUTION
    r = np.linalg.norm((corners[0] + corners[1]) / 2 - center)
    s = []
    for n in range(1, steps + 1):
        way = n * 2 * np.pi / steps
        s.append(center + r / n * np.array([np.cos(way), np.sin(way)]))
    return np.array(s)
    # END SOLUTION


# %%
check("07.6")

# %% [markdown]
# ### 07.7 The field
#
# At last the field: with a value $\phi_a$ at each corner,
#
# $$ f(\mathbf{x}) = \sum_a \omega_a(\mathbf{x})\, \phi_a . \tag{7.8} $$


# %% question="07.7"
def interpolate(center, rim, corners, values, x):
    """Return f of (7.8) at places x (M, 2), of shape (M,), for values φ (N,)."""
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
    places = spiral(center, corners, 50)
    number = np.arange(1, 51)
    with figure(7.2, 3.0) as page:
        cell, left, right = page.subplots(1, 3, width_ratios=(1.1, 1, 1))
        cell.fill(*corners.T, fc="#e8eef5", ec=BLUE)
        cell.plot(*places.T, ".-", color=ORANGE, ms=4, lw=0.8)
        cell.set(aspect="equal", title="the spiral in your cell")
        cell.axis("off")
        looks = ((PURPLE, "-"), (BLUE, "--"), (ORANGE, ":"))
        for (name, field), (color, dashes) in zip(fields(n).items(), looks):
            value = interpolate(center, rim, corners, field(corners), places)
            left.plot(number, field(places), color="#cccccc", lw=4)
            left.plot(number, value, color=color, ls=dashes, label=name)
            miss = np.maximum(abs(value - field(places)), 1e-17)
            right.loglog(number, miss, color=color, ls=dashes, label=name)
        left.set(xlabel="$n$", xscale="log", title="true (grey), and yours")
        right.set(xlabel="$n$", ylim=(1e-18, 1e2), title="error")
        page.legend(*left.get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return page


# %% [markdown]
# **What to look at.** On the left the spiral: the first point is close to an edge, the second half
# as far out, the last ones crowd round the centre. In the middle the values along it. On the right
# the errors: which of the three are nothing but rounding? Where along the spiral is the third one
# largest, and does it vanish towards the centre? You discuss this in question 07.9.
#
# ## Drag a point
#
# The dots show the six coordinates by their area, the bars by their length. The ring stands at
# $\sum_a \omega_a \mathbf{p}_a$. Drag the point, or click on the picture and use the arrow keys
# (*Shift* for small steps, *Home* to go back).


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
# **What to look at.** Drag the point to the middle of an edge, into a corner, along an edge, to the
# centre. How many weights are left in each? The ring never leaves the point. Why must it not?
# Corner 0 alone has a value other than zero. So the value at the point is its weight: where in the
# cell is it a half?
#
# ## On the edge
#
# On an edge (7.5) divides by zero, for both ends of the edge. Worse, *near* an edge it does not
# complain, and is wrong: the tiny $(\mathbf{x}_b - \mathbf{x}_i)^T(\mathbf{p}_a - \mathbf{x})$ is
# what is left when nearly equal numbers are subtracted, and it is computed twice, from either end,
# with a rounding error of its own each time.
#
# There is a way out. A circumcentre is as far from $\mathbf{x}_b$ as from $\mathbf{x}_i$, so
# $(\mathbf{x}_b - \mathbf{x}_i)^T(\mathbf{p}_a - \mathbf{x}_i) = \tfrac12 l_b^2$, and therefore
#
# $$ (\mathbf{x}_b - \mathbf{x}_i)^T(\mathbf{p}_a - \mathbf{x}) = h_b(\mathbf{x}), \qquad
#    h_b(\mathbf{x}) = \tfrac12 l_b^2 - (\mathbf{x}_b - \mathbf{x}_i)^T(\mathbf{x} - \mathbf{x}_i) .
#    \tag{7.9} $$
#
# The corner has dropped out: $h_b$ belongs to the neighbour $b$ alone, whichever end of the edge it
# is seen from. Now multiply all weights by the product of all $h_b$, which changes no ratio. Every
# denominator cancels:
#
# $$ \omega_a = \frac{c_a}{\sum_e c_e}, \qquad c_a(\mathbf{x}) = A_a \prod_{b \,\ne\, a,\; a+1}
#    h_b(\mathbf{x}) . \tag{7.10} $$
#
# ### 07.8 Coordinates without division
#
# Write (7.10). No circumcentre is handed over: none is needed.
#
# <details><summary>Hint</summary>
#
# First all $h_b$ at all places, as an array of shape $(N, M)$. Then, for one $a$ after the other,
# leave out two of its rows (`numpy.delete`) and multiply the rest.
#
# </details>


# %% question="07.8"
def safe_coordinates(center, rim, x):
    """Return ω_a of (7.10) at places x (M, 2), of shape (M, N), on edges as well."""
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
    places = on_edge + steps[:, None] * (center - on_edge)
    with figure(6.4, 3.1) as page, np.errstate(all="ignore"):
        axes = page.subplots()
        ways = (
            (
                coordinates(center, rim, corners, places),
                "quotients (7.5)",
                ORANGE,
                "o",
            ),
            (safe_coordinates(center, rim, places), "products (7.10)", BLUE, "."),
        )
        for omega, name, color, marker in ways:
            miss = np.linalg.norm(omega @ corners - places, axis=1) / radius
            lost = int((~np.isfinite(miss)).sum())
            name += f", {lost} without a value" if lost else ""
            axes.loglog(
                steps,
                np.maximum(miss, 1e-17),
                marker,
                ms=4,
                color=color,
                label=name,
            )
        axes.set(
            xlabel="distance from the edge, in parts of the way to the centre",
            ylabel=r"$\Vert\sum_a \omega_a \mathbf{p}_a - \mathbf{x}\Vert \;/\; R$",
            ylim=(3e-18, 30),
        )
        axes.legend()
    return page


# %% [markdown]
# **What to look at.** Each time the place comes ten times as near to the edge, the quotients lose
# another digit, and say nothing. The products are right at every distance, and on the edge too.
# They subtract the same nearly equal numbers: why does that do no harm there?
#
# ## In words
#
# **07.9** Discuss your results on the spiral for $\phi_a = 1$, for $\phi_a = p_{a,1} + p_{a,2}$,
# and for a field that is not linear. Which come back exactly, and why? What value does the field
# approach in the centre, and how large is the error there for $\phi(\mathbf{x}) = (x_1 + x_2)^2$
# and a hexagon of radius $R$ round the origin?
#
# <details><summary>Hint</summary>
#
# What are all coordinates at $\mathbf{x}_i$, by symmetry? The corners are at the distance
# $R/\sqrt3$.
#
# </details>

# %% [markdown] answer="07.9" points=4
# The constant comes back up to rounding at all fifty points, since the coordinates have the sum
# one: that is what (7.6) divides for. The linear field comes back up to rounding as well, because
# $\sum_a \omega_a \mathbf{p}_a = \mathbf{x}$: for $\phi(\mathbf{x}) = c_0 + \mathbf{c}^T\mathbf{x}$
# the sum is $c_0 \sum_a \omega_a + \mathbf{c}^T \sum_a \omega_a \mathbf{p}_a$. The exact values
# along the spiral approach $\phi(\mathbf{x}_i)$ like $1/n$, as its points approach the centre. No
# other field need come back. In the centre of a regular hexagon all six coordinates are $1/6$, so
# the value is the mean of the $\phi_a$. For $(x_1+x_2)^2$ the corners at $R/\sqrt3$ have the mean
# $R^2/3$, while the field is zero there: the error tends to $R^2/3$, grows with the square of the
# size of the cell, and does not vanish towards the centre. It is largest there and smaller close to
# an edge, where two neighbouring corners have nearly all the weight. All weights are positive
# inside, so values stay between the smallest and the largest $\phi_a$: no overshoot.

# %% [markdown] rubric="07.9"
# One point for the constant with partition of unity as the reason. One for the linear field with
# linear precision as the reason. One for saying that other fields do not come back, with evidence
# from the plot. One for the limit in the centre: the mean of the corners, error $R^2/3$.

# %% [markdown]
# **07.10** Which properties has the circumcentric dual of a Delaunay mesh: what of convexity, of
# crossings, of angles? Which of them remain if the mesh is not Delaunay, and which has the dual of
# the centroids? Why is your hexagon a Delaunay mesh?
#
# <details><summary>Hint</summary>
#
# The dual edge that crosses the edge from $\mathbf{x}_i$ to $\mathbf{x}_b$ joins two points that
# are each as far from $\mathbf{x}_i$ as from $\mathbf{x}_b$. Move the slider of the first
# interactive picture beyond 2 and count the vertices inside a circumscribed circle.
#
# </details>

# %% [markdown] answer="07.10" points=3
# Dual edges are perpendicular to the edges of the mesh, in every mesh: both ends lie on the
# bisector of the edge. In a Delaunay mesh no vertex is inside the circumscribed circle of a
# triangle, so no vertex is nearer to $\mathbf{p}_a$ than $\mathbf{x}_i$ is. Then the circumcentres
# round an inner vertex are the corners of its Voronoi cell, an intersection of half-planes: the
# dual cells are convex, and they do not cross. Without Delaunay right angles remain, but two
# circumcentres exchange their order along a bisector, and the dual crosses itself; in the picture
# from the distance 2 on, where the opposite angles of an edge sum to more than 180°. A circumcentre
# outside its triangle alone does no harm. The dual of centroids does not cross itself, but loses
# the right angles, and its edges no longer bisect those of the mesh. The hexagon is Delaunay: its
# triangles are equilateral, their circles have the radius $R/\sqrt3$ and contain no other vertex;
# the opposite angles of each inner edge sum to 120°.

# %% [markdown] rubric="07.10"
# One point for the right angles, with the bisector as the reason, in any mesh. One for convex cells
# that do not cross in a Delaunay mesh only; naming the Voronoi cell suffices. One for the centroids
# and for a reason why the hexagon is Delaunay.

# %% [markdown]
# **07.11** Derive (7.5) from (7.3) in your own words: which property of the dual enters where, and
# what becomes of the lengths $l_j$ and $l_k$? What would go wrong without the absolute value in
# (7.4)?

# %% [markdown] answer="07.11" points=3
# Dual and primal edges are perpendicular, so the outward normals of the cell at $\mathbf{p}_a$ are
# the unit vectors along the two spokes, $\mathbf{n}_j = (\mathbf{x}_j - \mathbf{x}_i)/l_j$ and
# $\mathbf{n}_k = (\mathbf{x}_k - \mathbf{x}_i)/l_k$. Their determinant is that of the spokes
# divided by $l_j l_k$, and the determinant of the spokes is twice the area of the triangle, up to
# sign. Each factor of the denominator of (7.3) has one length below it, so the denominator is the
# product of $(\mathbf{x}_b - \mathbf{x}_i)^T(\mathbf{p}_a - \mathbf{x})$ divided by the same $l_j
# l_k$. It cancels. Without the absolute value a triangle listed clockwise has a negative weight. If
# all are listed the same way round, the sum changes sign as well and the coordinates survive; if
# some are not, as in most meshes, they are wrong without warning.

# %% [markdown] rubric="07.11"
# One point for the normals along the spokes by orthogonality. One for the determinant as twice the
# area and the lengths that cancel. One for mixed orientations that give negative weights.

# %% [markdown]
# ## Dig deeper
#
# - Turn a hexagon so that a spoke has the angle $\Delta\theta = 7.2°$. The first point of the
#   spiral is then on an edge. What do `coordinates` and `safe_coordinates` say there?
# - Leave the cell. Some coordinates become negative, yet linear fields still come back. Somewhere
#   outside the sum of all $c_a$ vanishes: where, for a square cell, and where for another
#   quadrilateral?
# - What is the gradient of $f$? Differentiate (7.10) with $\nabla h_b = -(\mathbf{x}_b -
#   \mathbf{x}_i)$, and check it with differences.
# - Six points on a circle round $\mathbf{p}_a$ make several triangles with one circumcentre. What
#   does (7.10) give there? Which sum of coordinates has a meaning?

# %%
progress()
