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
# # Velocities of the cells of a mesh
#
# How fast does the fluid cross each edge? That is what many programs that compute a flow on
# triangles know, and nothing else. The cheapest way to whole velocities gives each triangle one
# vector, found from its own three sides. By the end of this notebook you have written it, you know
# what it does with data that contradict each other, and you have met a test that makes it look
# perfect, and one that makes it look bad. Both are misleading, and you can say why.
#
# Each question asks for a function. Write it, run its cell, and run the check below it. The check
# tells you whether it is right and, if it is not, what kind of mistake it may be. You need nothing
# from other notebooks. There are seven short functions and two questions in words.

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
# A triangle, and the speeds at which the fluid leaves it: the orange arrows. The second one points
# inwards, so there the fluid comes in. You may choose one velocity for the whole triangle, the
# black arrow. The blue bars show its part across each side, from the side to the dot. Try to bring
# all three dots to the tips of the orange arrows.


# %%
TURNS = np.array([0.4, 2.3, 4.4])
WANTED = np.array([0.75, -0.55, 0.3])


@draw(direction=Slider(-180, 180, -40, "direction", whole=True), speed=Slider(0, 1.5, 0.8, "speed"))
def the_problem(direction, speed):
    out = np.exp(1j * TURNS)
    corners = [
        (a + b) / (1 + (a * b.conjugate()).real) for a, b in zip(out, np.roll(out, -1), strict=True)
    ]
    middles = (np.array(corners) + np.roll(corners, 1)) / 2
    u = speed * np.exp(1j * np.radians(direction))
    parts = (u * out.conj()).real
    off = np.sqrt(np.sum((parts - WANTED) ** 2))
    with figure(6.4, 3.8) as page:
        axes = page.subplots()
        axes.fill(np.real(corners), np.imag(corners), fc="none", ec=GREY, lw=1.4)
        arrows = dict(angles="xy", scale_units="xy", scale=1, zorder=3)
        for place, way, wanted, part in zip(middles, out, WANTED, parts, strict=True):
            axes.quiver(
                place.real,
                place.imag,
                wanted * way.real,
                wanted * way.imag,
                color=ORANGE,
                width=0.007,
                **arrows,
            )
            tip = place + part * way
            axes.plot([place.real, tip.real], [place.imag, tip.imag], color=BLUE, lw=5, alpha=0.4)
            axes.plot(tip.real, tip.imag, "o", color=BLUE, ms=7)
        axes.quiver(0, 0, u.real, u.imag, color="black", width=0.008, **arrows)
        axes.set(aspect="equal", xticks=[], yticks=[], xlim=(-2.9, 2.4), ylim=(-2.1, 2.0))
        axes.set_title(f"the three differences together: {off:.2f}")
        for side in axes.spines.values():
            side.set_visible(False)
    return page


# %% [markdown]
# **What to look at.** Two dots can be brought to their places, any two. The third has then no
# choice. There are three numbers, and a velocity has two: one equation too many.

# %% [markdown]
# ## One equation too many
#
# Let $\mathbf{q}_1, \mathbf{q}_2, \mathbf{q}_3$ be the corners of a triangle. *Side* $a$ is the one
# opposite to corner $\mathbf{q}_a$; let $l_a$ be its length and $\mathbf{n}_a$ its *outward unit
# normal*: of length one, perpendicular to the side, away from $\mathbf{q}_a$. If $v_a$ is the
# velocity at which the fluid leaves through side $a$, a constant velocity $\mathbf{u}$ should
# satisfy
#
# $$ \mathbf{N}\mathbf{u} = \mathbf{v}, \qquad
#    \mathbf{N} = \begin{bmatrix} \mathbf{n}_1^T \\ \mathbf{n}_2^T \\ \mathbf{n}_3^T \end{bmatrix},
#    \qquad
#    \mathbf{v} = \begin{bmatrix} v_1 \\ v_2 \\ v_3 \end{bmatrix}. \tag{6.1} $$
#
# ### 06.1 The outward normals
#
# Write a function that returns $\mathbf{N}$. The corners may be listed clockwise or anticlockwise.
#
# <details><summary>Hint</summary>
#
# Turn the side by a right angle. There are two ways to do so, and which of them is outward depends
# on the order of the corners. Look at the corner opposite: on which side of the line is it? A
# scalar product tells.
#
# </details>


# %% question="06.1"
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
# Since there are three equations and two unknowns, we take the velocity that leaves the smallest
# error:
#
# $$ \mathbf{u} \quad \text{minimises} \quad \lVert \mathbf{N}\mathbf{u} - \mathbf{v} \rVert.
#    \tag{6.2} $$
#
# ### 06.2 The velocity of a cell


# %% question="06.2"
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
# ## What is left over
#
# Each equation $\mathbf{n}_a \cdot \mathbf{u} = v_a$ is a line in the plane of all velocities.
# Below, on the right, these are the three lines of the triangle on the left, and the dot is your
# velocity. The slider lets the triangle be a source: it adds the same outflow *per length* to all
# sides, so that more fluid leaves than enters.


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
# **What to look at.** Without a source the three lines meet in one point. With it they enclose a
# triangle, whose shape you have seen before. And however strong the source is: *your velocity does
# not move*. To see why, multiply $\mathbf{N}^T$ by the vector of lengths $\mathbf{l} = (l_1, l_2,
# l_3)^T$. The sides of a triangle, one after the other, lead back to where one started; turn them
# all by a right angle, and you have
#
# $$ \mathbf{N}^T \mathbf{l} = \sum_a l_a \mathbf{n}_a = \mathbf{0}. \tag{6.3} $$
#
# So $\mathbf{l}$ is perpendicular to everything that $\mathbf{N}\mathbf{u}$ can be, and least
# squares ignores it. What no constant velocity explains is the part of $\mathbf{v}$ along
# $\mathbf{l}$. Its length is the *defect* of the cell,
#
# $$ d = \frac{\lvert \mathbf{l} \cdot \mathbf{v} \rvert}{\lVert \mathbf{l} \rVert}
#      = \lVert \mathbf{N}\mathbf{u} - \mathbf{v} \rVert . \tag{6.4} $$
#
# And $\mathbf{l} \cdot \mathbf{v} = \sum_a l_a v_a$ is what flows out of the triangle on the whole,
# its area times the *divergence*.
#
# ### 06.3 The defect
#
# Either side of (6.4) will do.


# %% question="06.3"
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
# ## Where does the velocity belong?
#
# To compare with a truth we need places. A constant velocity belongs to the whole cell, but the
# truth is different at each place in it. In finite volumes one often takes the *circumcentre*
# $\mathbf{O}$, the place that is equally far from all three corners. From $\lVert \mathbf{O} -
# \mathbf{q}_k \rVert = \lVert \mathbf{O} - \mathbf{q}_1 \rVert$ follow two linear equations,
#
# $$ 2\, (\mathbf{q}_k - \mathbf{q}_1) \cdot (\mathbf{O} - \mathbf{q}_1)
#    = \lVert \mathbf{q}_k - \mathbf{q}_1 \rVert^2, \qquad k = 2, 3. \tag{6.5} $$
#
# ### 06.4 The circumcentre
#
# Write a function that returns it. It must be as good for a triangle far from the origin.
#
# <details><summary>Hint</summary>
#
# The unknown in (6.5) is not $\mathbf{O}$ but $\mathbf{O} - \mathbf{q}_1$. Formulas with squares of
# the coordinates themselves are right on paper; how many digits are left of a difference of two
# squares of size $10^{10}$?
#
# </details>


# %% question="06.4"
def circumcentre(q):
    """Return O of (6.5), of shape (2,), for the corners q (3, 2)."""
    # BEGIN SOLUTION
    sides = q[1:] - q[0]
    return q[0] + np.linalg.solve(2 * sides, np.sum(sides**2, axis=1))
    # END SOLUTION


# %%
check("06.4")

# %% [markdown]
# ## A flow that is known
#
# The truth shall be a rotation about a place $\mathbf{m}$, and an expansion from there at the rate
# $s$:
#
# $$ \mathbf{u}(\mathbf{x}) = \mathbf{J}\,(\mathbf{x} - \mathbf{m}) + s\,(\mathbf{x} - \mathbf{m}),
#    \qquad
#    \mathbf{J} = \begin{bmatrix} 0 & -1 \\ 1 & 0 \end{bmatrix}. \tag{6.6} $$
#
# For $s = 0$ nothing flows out of any cell: the field is *free of divergence*. For $s > 0$ every
# cell is a source.
#
# ### 06.5 The truth in closed form
#
# Write the field, at many places at once.


# %% question="06.5"
def truth(x, m, s):
    """Return u of (6.6) at places x (M, 2), of shape (M, 2).

    The centre m has the shape (2,), and s is a number.
    """
    # BEGIN SOLUTION
    z = x - m
    return np.column_stack([s * z[:, 0] - z[:, 1], z[:, 0] + s * z[:, 1]])
    # END SOLUTION


# %%
check("06.5")

# %% [markdown]
# Everything together: a mesh, the normal velocities $v_a = \mathbf{n}_a \cdot
# \mathbf{u}(\mathbf{p}_a)$ at the middles $\mathbf{p}_a$ of the sides, and your velocities as thin
# orange arrows at the circumcentres. The broad blue ones are the truth there.


# %%
def scattered(number, seed):
    """Vertices (K, 2) of a mesh of the unit square, spread evenly, but not in rows; and its
    triangles (T, 3).
    """
    random = np.random.default_rng(seed)
    points = np.stack([np.arange(16) / 4 % 1, np.zeros(16)], axis=1)
    turn = np.exp(0.5j * np.pi * (np.arange(16) // 4)) * (points[:, 0] - 0.5 - 0.5j)
    points = 0.5 + np.stack([turn.real, turn.imag], axis=1)
    while len(points) < number:
        more = random.uniform(0.08, 0.92, (9, 2))
        free = [np.hypot(*(points - place).T).min() for place in more]
        points = np.vstack([points, more[np.argmax(free)]])
    return points, Triangulation(*points.T).triangles


def leaving(corners, field):
    """The normal velocities of a field at the middles of the sides of one cell, outward, (3,)."""
    middle_of_side = [np.delete(corners, k, axis=0).mean(axis=0) for k in (0, 1, 2)]
    return np.einsum("ak,ak->a", outward_normals(corners), field(np.array(middle_of_side)))


def of_the_cells(points, triangles, field):
    """Circumcentres, velocities and defects of all cells, for a field given as a function of
    places.
    """
    places, found, left = [], [], []
    for corners in points[triangles]:
        v = leaving(corners, field)
        places.append(circumcentre(corners))
        found.append(cell_velocity(corners, v))
        left.append(defect(corners, v))
    return np.array(places), np.array(found), np.array(left)


@draw(s=Slider(-1, 1, 0, "expansion s"), seed=Slider(1, 12, 1, "mesh", whole=True))
def cells(s, seed):
    points, triangles = scattered(34, seed)
    middle = points.mean(axis=0)
    places, found, left = of_the_cells(points, triangles, lambda x: truth(x, middle, s))
    right = truth(places, middle, s)
    look = dict(angles="xy", scale_units="xy", scale=3.4)
    with figure(6.4, 4.3) as page:
        axes = page.subplots()
        axes.triplot(*points.T, triangles, color=GREY, lw=0.7, zorder=0)
        axes.quiver(*places.T, *right.T, color=BLUE, alpha=0.45, width=0.012, label="truth", **look)
        axes.quiver(*places.T, *found.T, color=ORANGE, width=0.005, label="yours", **look)
        axes.plot(*middle, "+", ms=11, color="black", label=r"$\mathbf{m}$")
        axes.set(aspect="equal", xticks=[], yticks=[], xlim=(-0.2, 1.2), ylim=(-0.2, 1.2))
        axes.axis("off")
        worst = np.hypot(*(found - right).T).max()
        axes.set_title(f"$s$ = {s:.2g}: largest error {worst:.1g}, largest defect {left.max():.1g}")
        axes.legend(loc="center left", bbox_to_anchor=(1, 0.5))
    return page


# %% [markdown]
# **What to look at.** For $s = 0$ all arrows agree, to the last digit, in every cell of every mesh.
# Let the flow expand. Now they do not, and the cells with a long side and a flat angle are the
# worst.
#
# ### 06.6 Compared where?
#
# One could have compared elsewhere: at the centroids of the cells, or with the velocities at the
# vertices. Write a function that does all three. With $\mathbf{m}$ the mean of the points, $v_a =
# \mathbf{n}_a \cdot \mathbf{u}(\mathbf{p}_a)$ at the middles of the sides, and $\mathbf{u}_T$ the
# velocity of cell $T$, it returns the root mean squares
#
# $$ E_{\mathbf{O}} = \sqrt{\operatorname{mean}_T \lVert \mathbf{u}_T - \mathbf{u}(\mathbf{O}_T)
#    \rVert^2}, \qquad
#    E_{\mathbf{M}} = \sqrt{\operatorname{mean}_T \lVert \mathbf{u}_T - \mathbf{u}(\mathbf{M}_T)
#    \rVert^2}, $$
#
# $$ E_{\mathbf{q}} = \sqrt{\operatorname{mean}_{T, a} \lVert \mathbf{u}_T -
#    \mathbf{u}(\mathbf{q}_{T,a}) \rVert^2} \tag{6.7} $$
#
# at the circumcentres $\mathbf{O}_T$, at the centroids $\mathbf{M}_T$, and at the three corners of
# each cell.


# %% question="06.6"
def errors(points, triangles, s):
    """Return the three errors of (6.7), of shape (3,).

    Given are the points (K, 2), the triangles (T, 3), and the number s.
    """
    # BEGIN SOLUTION
    m = points.mean(axis=0)
    missed = []
    for q in points[triangles]:
        middles = (q.sum(axis=0) - q) / 2
        v = np.sum(outward_normals(q) * truth(middles, m, s), axis=1)
        places = np.vstack([circumcentre(q), q.mean(axis=0), q])
        missed.append(np.sum((cell_velocity(q, v) - truth(places, m, s)) ** 2, axis=1))
    missed = np.array(missed)
    return np.sqrt([missed[:, 0].mean(), missed[:, 1].mean(), missed[:, 2:].mean()])
    # END SOLUTION


# %%
check("06.6")

# %% [markdown]
# On the left the errors on a mesh of your own, against $s$. On the right those for the $s$ of the
# slider, on finer and finer meshes.


# %%
@draw(s=Slider(0, 1, 0, "expansion s"))
def compared_where(s):
    points, triangles, _ = data("06.6")
    rates = np.linspace(0, 1, 11)
    table = np.array([errors(points, triangles, float(rate)) for rate in rates])
    sizes = (24, 40, 80, 160)
    finer = np.array([errors(*scattered(number, 2), s) for number in sizes])
    looks = (
        ("at circumcentres", ORANGE, "o-"),
        ("at centroids", GREEN, "s--"),
        ("at vertices", PURPLE, "^:"),
    )
    with figure(6.8, 3.1) as page:
        left, right = page.subplots(1, 2)
        for k, (label, color, look) in enumerate(looks):
            left.plot(rates, table[:, k], look, ms=4, color=color, label=label)
            right.loglog(np.sqrt(sizes), np.maximum(finer[:, k], 1e-16), look, ms=5, color=color)
        left.axvline(s, color="black", ls=":", lw=1)
        left.set(xlabel="expansion $s$", ylabel="error", ylim=(0, None), title="your mesh")
        right.set(
            xlabel="root of the number of vertices",
            title=f"finer meshes, $s$ = {s:.2g}",
            xticks=[5, 10],
            xticklabels=["5", "10"],
        )
        right.minorticks_off()
        page.legend(*left.get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return page


# %% [markdown]
# **What to look at.** For $s = 0$ one curve is at zero and the two others are not. On the right it
# is at the level of rounding, while the others fall slowly, as if the method were of first order.
# It is the same method, with the same numbers. For larger $s$ the order of the curves may change.
#
# ### Which place has the velocity that was found?
#
# For one triangle: the truth (6.6) takes the velocity that you have found at one place, the dot. It
# wanders as $s$ changes, from the circumcentre $\mathbf{O}$ towards $\mathbf{K}$, the *symmedian
# point* $\mathbf{K} = \sum_a l_a^2 \mathbf{q}_a / \sum_a l_a^2$. Change the shape of the triangle,
# too.


# %%
@draw(
    s=Slider(-3, 3, 0.7, "expansion s"),
    apex=Slider(-0.6, 1.6, 0.5, "apex"),
    height=Slider(0.2, 1.4, 0.8, "height"),
)
def wandering_place(s, apex, height):
    q = np.array([[-0.7, -0.3], [0.8, -0.3], [apex, height - 0.3]])
    middle, way = np.array([-0.2, 0.1]), []
    for rate in (*np.linspace(-8, 8, 161), s):
        _, (u,), _ = of_the_cells(
            q, np.array([[0, 1, 2]]), lambda x, rate=rate: truth(x, middle, rate)
        )
        way.append(middle + np.linalg.inv([[rate, -1], [1, rate]]) @ u)
    squares = [np.sum(np.diff(np.delete(q, k, axis=0), axis=0) ** 2) for k in (0, 1, 2)]
    with figure(6.4, 3.7) as page:
        axes = page.subplots()
        axes.fill(*q.T, fc="none", ec="black", lw=1.2)
        axes.plot(*np.array(way[:-1]).T, color=ORANGE, lw=1.2, label="its way, for all $s$")
        axes.plot(*way[-1], "o", ms=9, color=ORANGE, label=f"the place for $s$ = {s:.2g}")
        axes.plot(*circumcentre(q), "^", ms=8, color=BLUE, label=r"circumcentre $\mathbf{O}$")
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
# **06.7** The field is the rotation, $s = 0$. Compare the velocities of the cells with the
# velocities at the vertices of the mesh. Are they meaningful? With what should they be compared,
# and what does the difference from the vertices measure? Prove that for a rotation the velocity of
# a cell is *exactly* the truth at the circumcentre. Does it follow that the method is exact there
# for other fields?
#
# <details><summary>Hint</summary>
#
# Write the field about the circumcentre, $\mathbf{u}(\mathbf{x}) = \mathbf{u}(\mathbf{O}) +
# \mathbf{J}(\mathbf{x} - \mathbf{O})$. In which direction is $\mathbf{p}_a - \mathbf{O}$ for the
# middle $\mathbf{p}_a$ of a side? In which direction, then, is $\mathbf{J}(\mathbf{p}_a -
# \mathbf{O})$, and what of it crosses the side?
#
# </details>

# %% [markdown] answer="06.7" points=5
# They are meaningful, but a vector of a cell must be compared with the truth at the right place.
# For an affine field the truth in the cell varies by its slope times the size of the cell, so a
# difference from the velocity at a vertex is no error of the method: at every corner it is
# $\lVert\mathbf{J}(\mathbf{q}_a - \mathbf{O})\rVert = R$, the circumradius. It measures the mesh,
# and falls like the size of the cells, which looks like a method of first order. At the centroid,
# where the mean of the three vertex velocities belongs, it is the distance of centroid and
# circumcentre. The closed form $\mathbf{u}(\mathbf{O}) = \mathbf{J}(\mathbf{O} - \mathbf{m})$ is
# what to compare with: the difference is rounding.
#
# *Proof.* The circumcentre lies on the perpendicular bisector of every side, so $\mathbf{p}_a -
# \mathbf{O}$ is a multiple of $\mathbf{n}_a$, or zero. $\mathbf{J}$ turns by a right angle:
# $\mathbf{n}_a \cdot \mathbf{J}(\mathbf{p}_a - \mathbf{O}) = 0$. Hence $v_a = \mathbf{n}_a \cdot
# \mathbf{u}(\mathbf{p}_a) = \mathbf{n}_a \cdot \mathbf{u}(\mathbf{O})$ for all three sides: the
# constant $\mathbf{u}(\mathbf{O})$ satisfies all equations of (6.1). Two of the normals are not
# parallel, so the solution is unique, and it is what least squares returns. The shape of the
# triangle has no part in it, nor whether $\mathbf{O}$ is inside.
#
# It does not follow for other fields. Constants and rotations are the only affine fields for which
# this holds in every triangle. For an expansion the velocity belongs to the symmedian point; a
# strain such as $(x, -y)$, though free of divergence, has an error of the size of the cell. For a
# general smooth field the error is of first order. Who tests with a rotation only tests with the
# one field that cannot fail.

# %% [markdown] rubric="06.7"
# One point for meaningful, at the circumcentre, compared with the closed form. One for what the
# difference from the vertices measures (circumradius, or the slope times the size of the cell). Two
# for the proof: one for the right angle, one for concluding that the constant solves all three
# equations, uniquely. One for seeing that other fields are not exact, with an example.

# %% [markdown]
# ## When more flows out than in
#
# For $s \neq 0$ the data of a cell contradict each other: $\mathbf{l} \cdot \mathbf{v} = 2 s A$,
# with the area $A$. Least squares discards that. There is an old and simple field that does not. It
# is not constant; it is called after Raviart and Thomas:
#
# $$ \mathbf{w}(\mathbf{x}) = \sum_{a=1}^{3} \frac{v_a}{h_a} (\mathbf{x} - \mathbf{q}_a), \qquad
#    h_a = \frac{2A}{l_a}, \tag{6.8} $$
#
# where $h_a$ is the height of the triangle over side $a$. All along side $a$ it has the normal
# velocity $v_a$: for $b \neq a$ the corner $\mathbf{q}_b$ lies on the side, so that term does not
# cross it, and the term with $\mathbf{q}_a$ crosses it at $v_a$.
#
# ### 06.8 Another velocity
#
# Write $\mathbf{w}$ at one place.
#
# <details><summary>Hint</summary>
#
# The area of the triangle is half the absolute value of a determinant. The height over side $a$ is
# also how far any corner on the side is from $\mathbf{q}_a$ in the direction of $\mathbf{n}_a$.
#
# </details>


# %% question="06.8"
def raviart_thomas(q, v, x):
    """Return w of (6.8) at the place x (2,), of shape (2,).

    Given are the corners q (3, 2) and the outward normal velocities v (3,).
    """
    # BEGIN SOLUTION
    n = outward_normals(q)
    heights = np.ptp(n @ q.T, axis=1)
    return (v / heights) @ (x - q)
    # END SOLUTION


# %%
check("06.8")

# %% [markdown]
# Three fields on a mesh: a rotation with the expansion of the slider, and one that is neither, the
# strain $(x_1 - m_1,\, m_2 - x_2)$ with the strength of the second slider. To the normal velocities
# noise may be added. The pictures show each cell as a dot: the error at its circumcentre against
# its defect.


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
        v = leaving(corners, field) + noise * random.normal(size=3)
        center = circumcentre(corners)
        right = field(center[np.newaxis])[0]
        two = (cell_velocity(corners, v), raviart_thomas(corners, v, center))
        rows.append([defect(corners, v), *(np.hypot(*(u - right)) for u in two)])
    table = np.maximum(rows, 1e-17)
    with figure(6.6, 3.0) as page:
        for axes, column, color, title in zip(
            page.subplots(1, 2, sharey=True),
            (1, 2),
            (ORANGE, BLUE),
            ("least squares", r"$\mathbf{w}(\mathbf{O})$"),
            strict=True,
        ):
            axes.loglog(table[:, 0], table[:, column], "o", ms=4, color=color, alpha=0.7)
            axes.set(
                xlabel="defect of the cell",
                title=f"{title}: mean {table[:, column].mean():.1g}",
                xlim=(1e-18, 3),
                ylim=(1e-18, 3),
            )
            axes.set(xticks=[1e-16, 1e-8, 1], yticks=[1e-16, 1e-8, 1])
        page.axes[0].set_ylabel("error at the circumcentre")
    return page


# %% [markdown]
# **What to look at.** With expansion only, $\mathbf{w}(\mathbf{O})$ is exact, and least squares is
# not. Set $s = 0$ and turn on the *strain*: now the defects are rounding, but the errors are not,
# for neither of the two. Then set both to zero, and try *noise* alone.
#
# ### In words
#
# **06.9** How good are the velocities of the cells if the normal velocities are not free of
# divergence with respect to the cells? Say what least squares does with the part of the data that
# no constant velocity explains, and what that means for an expanding flow, and for noise. Suppose
# all defects of a program's output are zero. Does this show that the velocities of the cells are
# accurate?
#
# <details><summary>Hint</summary>
#
# Split $\mathbf{v}$ into a part along $\mathbf{l}$ and one perpendicular to it. What does (6.2)
# make of each? For the last part, look at your picture with strain.
#
# </details>

# %% [markdown] answer="06.9" points=4
# By (6.3) the vectors that $\mathbf{N}\mathbf{u}$ can be are exactly those perpendicular to
# $\mathbf{l}$. Least squares replaces $\mathbf{v}$ by the closest of these, $\mathbf{v} -
# \mathbf{l}\,(\mathbf{l}\cdot\mathbf{v})/\lVert\mathbf{l}\rVert^2$, and returns the velocity that
# belongs to it. The part along $\mathbf{l}$, what flows out on the whole, is discarded: adding any
# multiple of $\mathbf{l}$ to the data changes nothing. It is what the defect measures.
#
# *Expansion.* The velocity found is the truth at the symmedian point and not at the circumcentre:
# the error there is $s\,\lVert\mathbf{K} - \mathbf{O}\rVert$. It is of the order of the size of the
# cell, zero in equilateral triangles, and large in obtuse ones, whose circumcentre is far outside.
# The velocities are still of first order. The error can be avoided, since $\mathbf{w}(\mathbf{O})$
# of (6.8) is exact for rotations and expansions.
#
# *Noise.* Of three independent errors of size $\delta$ one combination, that along $\mathbf{l}$, is
# removed and shows as a defect of the size $\delta$. The two others go into the velocity, which
# moves by $\mathbf{N}^+$ times the errors: by about $\delta$, more in flat triangles. A single bad
# face spoils its two cells.
#
# *Zero defects* show that in each cell *some* constant velocity fits its three numbers, so that the
# data are free of divergence. They do not show that the field is constant in the cell: the strain
# has no defect and an error of the size of the cell. Consistent is not accurate.

# %% [markdown] rubric="06.9"
# One point for what is discarded, the part along $\mathbf{l}$, which is the divergence. One for the
# expansion: an error of the order of the cell, or its formula, or that it may be avoided. One for
# noise. One for the last part, with a reason or an example: no defect does not mean no error.

# %% [markdown]
# ## Dig deeper
#
# - *Two are one.* Evaluate (6.8) at the symmedian point $\mathbf{K}$, for random data. Compare with
#   `cell_velocity`. To prove what you see, show that a step from side $a$ inwards by the distance
#   $t$ changes $\mathbf{n}_a \cdot \mathbf{w}$ by the same amount for all sides. Which distances
#   from the three sides has $\mathbf{K}$?
# - *A triangle of lines.* In the picture with the three lines, where in the small triangle is the
#   dot? Which theorem on sums of squared distances have you found?
# - *Weights.* Multiply equation $a$ by the length $l_a$. Which vectors are now ignored, and where
#   does an expansion belong?
# - *A mistake that does no harm.* Go round the triangle, and take for each side the velocity of
#   (6.6) at the corner where the side begins instead of that at its middle. The normal velocities
#   are then wrong, all three. By which vector? What does that do to $\mathbf{u}$?
# - *Strain.* For which place does the truth $(x, -y)$ have the velocity that was found? Turn the
#   strain, and follow the place. It runs on a circle that you know from school.
# - *Space.* A tetrahedron has four faces. Does (6.3) hold? In the proof of 06.7, which point of a
#   face takes the part of the middle of the side?

# %%
progress()
