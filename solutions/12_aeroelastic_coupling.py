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
# # Two meshes of one wing
#
# The air bends a wing, and flows otherwise round the bent wing. One program knows the air and sees
# a *skin* of many points; another knows the structure and sees a *skeleton* of few nodes. They have
# hardly a point in common. Displacements must go from the skeleton to the skin, and loads from the
# skin to the skeleton, again and again, until nothing changes any more.
#
# By the end of this notebook you have written both ways, you can say exactly what is lost on the
# way and what is not, and you have a wing that finds its shape in the wind, or does not, and tells
# you at which speed it breaks.
#
# There are eight short functions and four questions in words. You need nothing from other
# notebooks. Numbers in brackets, such as (12.1), are those of formulas; numbers without are those
# of questions.

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

# %% [markdown]
# ## The problem in a picture
#
# Half a wing, seen from the front and above. The orange nodes are the skeleton: two spars, above
# and below, tied together at a few stations. They have been moved by a program for structures. The
# skin (blue) still stands where it was. Where should each of its points go?


# %%
def half_wing(stations):
    """Return the nodes of a skeleton (N, 3), and the skin (M, 3) with its areas (M,)."""

    def placed(s, t, side):
        chord = 0.6 - 0.3 * t
        return np.column_stack([0.3 * t + chord * s, t, side * 0.3 * chord * s * (1 - s)])

    def every(*parts):
        return [part.ravel() for part in np.meshgrid(*parts, indexing="ij")]

    nodes = placed(*every([0.2, 0.65], np.linspace(0, 0.9, stations), [1, -1]))
    s, t, side = every((np.arange(8) + 0.5) / 8, (np.arange(12) + 0.5) / 12, [1, -1])
    return nodes, placed(s, t, side), (0.6 - 0.3 * t) / 96


def on_paper(points):
    """Return where points (N, 3) appear on paper."""
    return points[:, 1] + 0.35 * points[:, 0], points[:, 2] - 0.45 * points[:, 0]


@draw(bend=Slider(0, 0.5, 0.3, "bend"), twist=Slider(-0.6, 0.6, 0.2, "twist"))
def the_problem(bend, twist):
    nodes, skin, _ = half_wing(6)
    moved = nodes.copy()
    moved[:, 2] += nodes[:, 1] ** 2 * (bend + twist * (0.4 - nodes[:, 0]))
    with figure(6.4, 3.0) as page:
        axes = page.subplots()
        rim = np.array([[0, 0, 0], [0.3, 1, 0], [0.6, 1, 0], [0.6, 0, 0], [0, 0, 0]])
        axes.plot(*on_paper(rim), color=BLUE, lw=1)
        axes.plot(*on_paper(skin), ".", color=BLUE, ms=3, label="the skin, not yet moved")
        for spar in np.moveaxis(moved.reshape(2, 6, 2, 3), 1, 2).reshape(4, 6, 3):
            axes.plot(*on_paper(spar), "o-", color=ORANGE, ms=4, lw=1)
        axes.plot([], [], "o-", color=ORANGE, ms=4, lw=1, label="the skeleton, moved")
        axes.set_aspect("equal")
        axes.axis("off")
        page.legend(loc="outside lower center", ncols=2)
    return page


# %% [markdown]
# ## Displacements
#
# Let $\mathbf{x}_1, \dots, \mathbf{x}_N \in \mathbb{R}^D$ be the nodes of the skeleton, and $u_1,
# \dots, u_N$ one component of their displacements. We lay a field through them,
#
# $$ s_u(\mathbf{y}) = \sum_{j=1}^N \lambda_j \lVert \mathbf{y} - \mathbf{x}_j \rVert^3 + c_0 +
#    \mathbf{c}^T \mathbf{y}, \qquad
#    \begin{bmatrix} \boldsymbol{\Phi} & \mathbf{P} \\ \mathbf{P}^T & \mathbf{0} \end{bmatrix}
#    \begin{bmatrix} \boldsymbol{\lambda} \\ c_0 \\ \mathbf{c} \end{bmatrix} =
#    \begin{bmatrix} \mathbf{u} \\ \mathbf{0} \end{bmatrix}, \tag{12.1} $$
#
# with $\Phi_{ij} = \lVert \mathbf{x}_i - \mathbf{x}_j \rVert^3$ and the rows $(1, \mathbf{x}_i^T)$
# of $\mathbf{P}$. On a line this is the curve of a thin ruler that is held at the nodes: a good
# picture of a structure that bends. The matrix depends on the nodes alone, and is given here:


# %% tags=["setup"]
def distances(a, b):
    """Return the distances from each point of a (M, D) to each of b (N, D), of shape (M, N)."""
    return np.linalg.norm(a[:, None] - b, axis=2)


def system(nodes):
    """Return the matrix of (12.1), of shape (N + D + 1, N + D + 1), for nodes (N, D)."""
    n, d = nodes.shape
    matrix = np.zeros((n + d + 1,) * 2)
    matrix[:n, :n] = distances(nodes, nodes) ** 3
    matrix[:n, n] = matrix[n, :n] = 1
    matrix[:n, n + 1 :], matrix[n + 1 :, :n] = nodes, nodes.T
    return matrix


# %% [markdown]
# The coefficients depend linearly on $\mathbf{u}$, and so does the field. At the points
# $\mathbf{y}_1, \dots, \mathbf{y}_M$ of the skin it has the values $\mathbf{H}\mathbf{u}$, and the
# row of $\mathbf{H}$ that belongs to $\mathbf{y}$ holds the first $N$ entries of $\mathbf{w}$ in
#
# $$ \begin{bmatrix} \boldsymbol{\Phi} & \mathbf{P} \\ \mathbf{P}^T & \mathbf{0} \end{bmatrix}
#    \mathbf{w} = \mathbf{b}(\mathbf{y}), \qquad
#    \mathbf{b}(\mathbf{y}) = \bigl(\lVert \mathbf{y} - \mathbf{x}_1 \rVert^3, \dots, \lVert
#    \mathbf{y} - \mathbf{x}_N \rVert^3, 1, \mathbf{y}^T\bigr)^T . \tag{12.2} $$
#
# ### 12.1 The weights
#
# Write a function that returns $\mathbf{H}$. It must work in the plane, in space and on a line.
#
# <details><summary>Hint</summary>
#
# `np.linalg.solve` takes many right sides at once, as columns. The matrix is symmetric.
#
# </details>


# %% question="12.1"
def weights(nodes, places):
    """Return H of (12.2), of shape (M, N), for nodes (N, D) and places (M, D)."""
    # BEGIN SOLUTION
    ones = np.ones((len(places), 1))
    b = np.hstack([distances(places, nodes) ** 3, ones, places])
    return np.linalg.solve(system(nodes), b.T).T[:, : len(nodes)]
    # END SOLUTION


# %%
check("12.1")

# %% [markdown]
# ## Loads
#
# Let $\mathbf{f}_i \in \mathbb{R}^3$ be the force at the point $\mathbf{y}_i$ of the skin: a force,
# not a force per area. If the nodes move by $\mathbf{u}_j$, the points of the skin move by
# $(\mathbf{H}\mathbf{u})_i$, and the forces do the work $\sum_i (\mathbf{H}\mathbf{u})_i^T
# \mathbf{f}_i$. The structure is to be given loads $\mathbf{g}_j$ that do the same work,
#
# $$ \sum_{i=1}^M (\mathbf{H}\mathbf{u})_i^T \mathbf{f}_i = \sum_{j=1}^N \mathbf{u}_j^T \mathbf{g}_j
#    \quad \text{for all displacements } \mathbf{u} . \tag{12.3} $$
#
# That leaves no choice:
#
# $$ \mathbf{g} = \mathbf{H}^T \mathbf{f} . \tag{12.4} $$
#
# ### 12.2 The loads on the structure


# %% question="12.2"
def loads(H, f):
    """Return g of (12.4), of shape (N, D), for weights H (M, N) and forces f (M, D)."""
    # BEGIN SOLUTION
    return H.T @ f
    # END SOLUTION


# %%
check("12.2")

# %% [markdown]
# Your own nodes, twelve of them, seen from above. A force of one acts at the cross. Each node gets
# the part of it that is drawn by the area of its dot, and the ring is where the parts balance. Move
# the force, out of the structure too.


# %%
@draw(
    x=Slider(-0.5, 2.0, 0.6, "x of the force", steps=25),
    y=Slider(-0.5, 1.5, 0.4, "y of the force", steps=20),
)
def footprint(x, y):
    nodes = data("12.1")[0]
    place = np.array([[x, y]])
    parts = loads(weights(nodes, place), np.ones((1, 1)))[:, 0]
    with figure(6.4, 3.6) as page:
        axes = page.subplots()
        for color, sign, name in ((BLUE, 1, "upwards"), (ORANGE, -1, "downwards")):
            size = 700 * np.maximum(sign * parts, 0)
            axes.scatter(*nodes.T, s=size, color=color, alpha=0.75, lw=0)
            axes.plot([], [], "o", color=color, label=name)
        axes.plot(*nodes.T, ".", color=GREY, ms=3)
        for node, part in zip(nodes, parts):
            axes.annotate(
                f"{round(part, 2) + 0:.2f}",
                node,
                (0, -14),
                textcoords="offset points",
                ha="center",
                fontsize=8,
            )
        axes.plot(*(parts @ nodes), "o", mfc="none", color=PURPLE, ms=15, label="their balance")
        axes.plot(x, y, "x", color="black", ms=8, mew=2, label="the force")
        axes.set(
            xlim=(-0.6, 2.1),
            ylim=(-0.7, 1.6),
            aspect="equal",
            title=f"sum of the parts {parts.sum():.3f}",
        )
        axes.axis("off")
        axes.legend(loc="center left", bbox_to_anchor=(1, 0.5), labelspacing=1)
    return page


# %% [markdown]
# **What to look at.** Far outside a force of one arrives as large forces up and down. Their sum is
# still one, and the ring still sits on the cross. It is a lever: what acts out there *is* large at
# the structure.
#
# ## What is kept
#
# The total force, and the total moment about a point $\mathbf{a}$, of forces $\mathbf{f}_i$ at
# points $\mathbf{p}_i$ are
#
# $$ \mathbf{F} = \sum_i \mathbf{f}_i, \qquad \mathbf{M}_{\mathbf{a}} = \sum_i (\mathbf{p}_i -
#    \mathbf{a}) \times \mathbf{f}_i . \tag{12.5} $$
#
# **12.3** Let $\mathbf{H}$ be any matrix, from any method. (a) Prove that (12.4) follows from
# (12.3), and (12.3) from (12.4). (b) Prove: the total force is the same on both sides *for all*
# forces $\mathbf{f}$ if and only if the rows of $\mathbf{H}$ sum to one. (c) Let them sum to one.
# When is the total moment the same for all $\mathbf{f}$? (d) Wendland (2005, p. 6) writes that
# "interpolation is crucial in this process since otherwise each coupling step would result in a
# loss of energy". Is that so?
#
# <details><summary>Hint</summary>
#
# Which displacement makes the work $\sum_i (\mathbf{H}\mathbf{u})_i^T\mathbf{f}_i$ a component of
# the total force? Which makes it one of the moment? Put it into (12.3).
#
# </details>

# %% [markdown] answer="12.3" points=4
# (a) The left side of (12.3) is $\sum_{ij} H_{ij}\, \mathbf{u}_j^T \mathbf{f}_i = \sum_j
# \mathbf{u}_j^T (\mathbf{H}^T\mathbf{f})_j$. This equals $\sum_j \mathbf{u}_j^T\mathbf{g}_j$ for
# every $\mathbf{u}$ exactly if $\mathbf{g} = \mathbf{H}^T\mathbf{f}$: take for $\mathbf{u}$ one
# unit displacement after the other. (b) The total of the loads is $\sum_j \mathbf{g}_j = \sum_i
# (\sum_j H_{ij})\, \mathbf{f}_i$. If all rows sum to one it is $\sum_i\mathbf{f}_i$. Conversely,
# take a single force at $\mathbf{y}_i$: it is kept only if its row sums to one. (c) $\sum_j
# \mathbf{x}_j \times \mathbf{g}_j = \sum_i (\sum_j H_{ij}\mathbf{x}_j) \times \mathbf{f}_i$, which
# agrees with $\sum_i \mathbf{y}_i \times \mathbf{f}_i$ for all forces exactly if $\sum_j
# H_{ij}\mathbf{x}_j = \mathbf{y}_i$ for all $i$, so if linear fields come back. The point
# $\mathbf{a}$ does not matter, since the total force is kept. Both are the work in a rigid motion:
# a translation, or a rotation $\boldsymbol\omega \times \mathbf{x}$. (d) No. Nothing above uses $H$
# at a node; a least-squares fit of planes keeps work, force and moment as well. What counts is that
# the loads go by the transpose. If both ways interpolate, work *is* lost.

# %% [markdown] rubric="12.3"
# One point for each of (a) to (d). In (b) and (c) "only if" must be argued, by single forces for
# instance. In (d) it suffices to see that the proof does not use interpolation.

# %% [markdown]
# ### 12.4 Force and moment
#
# Write (12.5) in space, so that you can measure what arrives.


# %% question="12.4"
def resultants(points, forces, about):
    """Return the three components of F and the three of M about a point (3,), of shape (6,).

    points and forces have the shape (M, 3).
    """
    # BEGIN SOLUTION
    moment = np.cross(points - about, forces).sum(axis=0)
    return np.concatenate([forces.sum(axis=0), moment])
    # END SOLUTION


# %%
check("12.4")

# %% [markdown]
# ## What goes wrong
#
# Before virtual work was thought of, loads were interpolated like displacements: a field through
# the values on the skin, read off at the nodes. Below, four ways on the wing above,
#
# - forces, interpolated as numbers;
# - pressures (force per area), interpolated, then multiplied by the area that belongs to each node;
# - each force to the node that is nearest;
# - your transpose.
#
# They are judged by the lift, by the moment that bends the wing, and by the one that twists it.
# Rounding is drawn at $10^{-16}$.


# %%
def arrivals(stations):
    """Return the forces and moments on the skin, and those that arrive in each of four ways."""
    nodes, skin, areas = half_wing(stations)
    s, t = (skin[:, 0] - 0.3 * skin[:, 1]) / (0.6 - 0.3 * skin[:, 1]), skin[:, 1]
    pressure = np.sqrt(1 - t**2) * (1 - s)
    f = (pressure * areas)[:, None] * [0.05, 0, 1]
    H, back = weights(nodes, skin), weights(skin, nodes)
    nearest = (distances(skin, nodes) == distances(skin, nodes).min(axis=1)[:, None]) * 1.0
    ways = {
        "forces interpolated": back @ f,
        "pressures interpolated": (back @ (f / areas[:, None])) * loads(H, areas[:, None]),
        "to the nearest node": loads(nearest, f),
        "your transpose": loads(H, f),
    }
    wanted = resultants(skin, f, np.zeros(3))
    return wanted, {name: resultants(nodes, g, np.zeros(3)) for name, g in ways.items()}


@draw(stations=Slider(3, 14, 6, "stations along the span", whole=True))
def what_goes_wrong(stations):
    wanted, found = arrivals(stations)
    with figure(6.4, 3.0) as page:
        axes = page.subplots()
        looks = zip(
            found.items(), (ORANGE, PURPLE, GREEN, BLUE), "^sDo", (-0.15, -0.05, 0.05, 0.15)
        )
        for (name, got), color, marker, aside in looks:
            off = np.abs(got - wanted)[2:5] / np.abs(wanted)[2:5]
            axes.plot(
                np.arange(3) + aside, np.maximum(off, 1e-16), marker, color=color, ms=7, label=name
            )
        axes.set_yscale("log")
        axes.set_xticks(range(3), ["lift", "bending", "twisting"])
        axes.set(ylim=(1e-17, 20), xlim=(-0.5, 2.5), ylabel="relative error")
        axes.set_yticks([1e-16, 1e-12, 1e-8, 1e-4, 1])
        axes.grid(axis="y", alpha=0.3)
        axes.legend(loc="center left", bbox_to_anchor=(1, 0.5))
    return page


# %% [markdown]
# **What to look at.** Of forces that are interpolated most get lost: a force belongs to a piece of
# skin, and few nodes read off few pieces. Pressures times areas look sensible, and the lift is
# nearly right, but a tenth of the twisting moment is missing, and more stations do not cure it. The
# nearest node keeps the lift, because rows with a single one sum to one; but the wing is bent and
# twisted wrongly. The transpose is right to rounding, with three stations or with fourteen.
#
# **12.5** A textbook asks of the loads $\mathbf{g} = \mathbf{G}\mathbf{f}$ two things at once:
# constant loads, $f_i = 1$ for all $i$, are to come back as $g_j = 1$; and the total force is to be
# the same for all $\mathbf{f}$. Show that no matrix $\mathbf{G}$ does both unless $M = N$. Which of
# the two must be given up, and what could be meant by the other?

# %% [markdown] answer="12.5" points=2
# The first says $\mathbf{G}\mathbf{1}_M = \mathbf{1}_N$, the second $\mathbf{1}_N^T\mathbf{G} =
# \mathbf{1}_M^T$. Then $N = \mathbf{1}_N^T\mathbf{1}_N = \mathbf{1}_N^T\mathbf{G}\mathbf{1}_M =
# \mathbf{1}_M^T\mathbf{1}_M = M$. So forty forces of one, with the sum forty, would become twelve
# of one, with the sum twelve. The total force is physics and must stay. A single force has no
# meaning without the piece of skin on which it acts: finer meshes have smaller forces. What can be
# constant is a *density*, force per area, and densities can come back as the same constant while
# their integrals agree.

# %% [markdown] rubric="12.5"
# One point for the contradiction, also by an example. One for keeping the total and for densities,
# force per area, as what may be constant.

# %% [markdown]
# ## Densities
#
# Let $m_i$ be the area of the point $\mathbf{y}_i$ and $p_i$ the pressure there, so that $m_i p_i$
# is a force. The node $\mathbf{x}_j$ is handed the area $m'_j$ in the same way as it is handed
# forces, and its pressure is force by area:
#
# $$ m'_j = \sum_{i=1}^M H_{ij}\, m_i, \qquad p'_j = \frac{1}{m'_j} \sum_{i=1}^M H_{ij}\, m_i\, p_i
#    . \tag{12.6} $$
#
# ### 12.6 Pressures on the structure


# %% question="12.6"
def densities(H, p, m):
    """Return p' of (12.6), of shape (N,), for weights H (M, N), pressures p (M,), areas m (M,)."""
    # BEGIN SOLUTION
    return (H.T @ (m * p)) / (H.T @ m)
    # END SOLUTION


# %%
check("12.6")

# %% [markdown]
# ## A structure without thickness
#
# A simple model of a wing is a plate: nodes in one plane of space. Try `weights` on such nodes, and
# `np.linalg.solve` says that the matrix is singular, or returns numbers without meaning.
#
# The remedy takes what we know of plates: *the normal of the plate stays a normal*. Let the plate
# be $x_3 = 0$, and let $\mathbf{y} = (\mathbf{p}, \zeta)$ stand at the height $\zeta$ above the
# point $\mathbf{p}$ of the plane. With $\mathbf{H}$ and its slopes $\mathbf{G}^k$ in the *plane*,
#
# $$ (H\mathbf{u})_i = s_{\mathbf{u}}(\mathbf{p}_i), \qquad G^k_{ij} = \frac{\partial
#    H_{ij}}{\partial p_k}, \qquad
#    \mathbf{v}_i = \sum_j H_{ij}\, \mathbf{u}_j - \zeta_i \sum_j u_{j3} \begin{pmatrix} G^1_{ij} \\
#    G^2_{ij} \\ 0 \end{pmatrix} . \tag{12.7} $$
#
# Here $\mathbf{v}_i$ is the displacement of the skin: that of the plate below it, and what the arm
# of the length $\zeta_i$ adds as the plate tilts.
#
# ### 12.7 The slopes
#
# Only $\mathbf{b}$ of (12.2) depends on the place. Its derivative with respect to the coordinate
# $k$ has the entries $3 \lVert \mathbf{y} - \mathbf{x}_j \rVert\, (y_k - x_{jk})$, then a zero for
# the one, then the unit vector of that coordinate. Write the slopes in any dimension.


# %% question="12.7"
def slopes(nodes, places):
    """Return G of shape (D, M, N), the derivatives of H along the D axes.

    nodes have the shape (N, D), places (M, D).
    """
    # BEGIN SOLUTION
    n, r = len(nodes), distances(places, nodes)
    g = []
    for k in range(nodes.shape[1]):
        b = np.zeros((len(places), len(system(nodes))))
        b[:, :n] = 3 * r * (places[:, [k]] - nodes[:, k])
        b[:, n + 1 + k] = 1
        g.append(np.linalg.solve(system(nodes), b.T).T[:, :n])
    return np.array(g)
    # END SOLUTION


# %%
check("12.7")

# %% [markdown]
# ### 12.8 Loads on a plate
#
# The loads are again the transpose: $\mathbf{g}$ must do the work $\sum_i
# \mathbf{v}_i^T\mathbf{f}_i$ in every displacement. Collect in (12.7) all that is multiplied by
# $\mathbf{u}_j$. Which components of $\mathbf{g}_j$ differ from those of $\mathbf{H}^T\mathbf{f}$?
#
# <details><summary>Hint</summary>
#
# Only $u_{j3}$ is multiplied by slopes, so only $g_{j3}$ has more than $\mathbf{H}^T\mathbf{f}$.
# What of $\mathbf{f}_i$ stands beside them?
#
# </details>


# %% question="12.8"
def flat_loads(nodes, places, f):
    """Return g, of shape (N, 3), for nodes (N, 2) of the plane, places (M, 3) and forces (M, 3)."""
    # BEGIN SOLUTION
    p, height = places[:, :2], places[:, 2]
    g1, g2 = slopes(nodes, p)
    g = weights(nodes, p).T @ f
    g[:, 2] -= g1.T @ (height * f[:, 0]) + g2.T @ (height * f[:, 1])
    return g
    # END SOLUTION


# %%
check("12.8")

# %% [markdown]
# Your own plate of nine nodes. A force of one pulls along it, at a height: an engine above the
# wing. The arrows are what the nodes get across the plate.


# %%
@draw(height=Slider(-0.6, 0.6, 0.4, "height of the force", steps=24))
def pulled_along(height):
    nodes = data("12.8")[0]
    place, force = np.array([[0.5, 0.5, height]]), np.array([[1.0, 0, 0]])
    g = flat_loads(nodes, place, force)
    flat = np.pad(nodes, ((0, 0), (0, 1)))
    before, after = (resultants(p, f, np.zeros(3)) for p, f in ((place, force), (flat, g)))

    def seen(points):
        return points[:, 0] + 0.45 * points[:, 1], 0.4 * points[:, 1] + points[:, 2]

    with figure(6.4, 3.3) as page:
        axes = page.subplots()
        corners = np.array([[-0.15, -0.15, 0], [1.15, -0.15, 0], [1.15, 1.15, 0], [-0.15, 1.15, 0]])
        axes.fill(*seen(corners), color=GREY, alpha=0.2, lw=0)
        axes.plot(*seen(flat), "o", color=GREY, ms=4)
        for node, up in zip(flat, g[:, 2]):
            ends = np.column_stack(seen(np.array([node, node + [0, 0, 0.8 * up]])))
            axes.annotate(
                "",
                ends[1],
                ends[0],
                arrowprops={"arrowstyle": "->", "color": BLUE, "lw": 2, "shrinkA": 0, "shrinkB": 0},
            )
        foot = np.vstack([place * [1, 1, 0], place, place + [0.45, 0, 0]])
        axes.plot(*seen(foot[:2]), ":", color=ORANGE)
        start, tip = np.column_stack(seen(foot[1:]))
        axes.annotate(
            "",
            tip,
            start,
            arrowprops={
                "arrowstyle": "-|>",
                "color": ORANGE,
                "lw": 2.5,
                "shrinkA": 0,
                "shrinkB": 0,
            },
        )
        axes.plot([], [], color=ORANGE, lw=2.5, label="the force")
        axes.plot([], [], color=BLUE, lw=2, label="across the plate")
        axes.set(xlim=(-0.3, 1.9), ylim=(-0.75, 1.25), aspect="equal")
        axes.set_title(
            f"moment about the y axis: {before[4]:.2f} of the force, {after[4]:.2f} of the loads"
        )
        axes.axis("off")
        axes.legend(loc="upper left")
    return page


# %% [markdown]
# **12.9** (a) Which polynomial $c_0 + \mathbf{c}^T\mathbf{y}$ makes the matrix of (12.1) singular
# if all nodes lie in the plane $x_3 = 0$? (b) What is it that displacements of nodes in one plane
# do not tell, and what does (12.7) assume instead? (c) Show that with (12.7) the rotation
# $\mathbf{u}_j = \boldsymbol\omega \times \mathbf{x}_j$ moves every point of the skin by
# $\boldsymbol\omega \times \mathbf{y}_i$. Why does that settle the total moment?
#
# <details><summary>Hint</summary>
#
# For (c): a rotation is a linear field in the plane, which $\mathbf{H}$ and $\mathbf{G}^k$ treat
# exactly. What is its third component, and what are the slopes of that?
#
# </details>

# %% [markdown] answer="12.9" points=3
# (a) $y_3$: it vanishes at all nodes, so $\boldsymbol\lambda = \mathbf{0}$, $c_0 = 0$,
# $\mathbf{c} = (0, 0, 1)^T$ solves the homogeneous system. (b) They do not tell how a field
# changes *across* the plane: any multiple of $y_3$ may be added. (12.7) assumes that the normal
# stays straight and normal to the plate, as in the theory of thin plates. (c) With $\mathbf{x} =
# (x_1, x_2, 0)$ the rotation is $\boldsymbol\omega\times\mathbf{x} = (-\omega_3 x_2,\ \omega_3
# x_1,\ \omega_1 x_2 - \omega_2 x_1)$, linear in the plane, so the first sum of (12.7) is its value
# at $\mathbf{p}_i$. The third component has the slopes $-\omega_2$ and $\omega_1$, so the second
# term is $\zeta_i(\omega_2, -\omega_1, 0) = \boldsymbol\omega \times (0, 0, \zeta_i)$. The sum is
# $\boldsymbol\omega\times\mathbf{y}_i$. The total moment is the work in rotations; they come back,
# and the loads are the transpose, so it is kept.

# %% [markdown] rubric="12.9"
# One point for the polynomial that vanishes on the nodes. One for what is unknown across the plane,
# and the normal as the remedy. One for the rotation, with work as the reason for the moment.

# %% [markdown]
# ## The loop
#
# Now both programs together. Let only displacements upwards count, so that $\mathbf{u} \in
# \mathbb{R}^N$. The structure has the stiffness $\mathbf{K}$, and the loads on the skin are
# $\mathbf{f}_0$ at rest and change as the skin moves, $\mathbf{f} = \mathbf{f}_0 +
# \mathbf{A}\mathbf{w}$ with $\mathbf{w} = \mathbf{H}\mathbf{u}$. The steady state is where neither
# has anything to tell the other:
#
# $$ \mathbf{K}\mathbf{u} = \mathbf{H}^T \mathbf{f}, \qquad \mathbf{f} = \mathbf{f}_0 +
#    \mathbf{A}\mathbf{H}\mathbf{u} . \tag{12.8} $$
#
# The programs take turns. Each time the structure answers with
# $\mathbf{K}^{-1}\mathbf{H}^T\mathbf{f}$, and of the way from the last displacement to that answer
# one goes the part $\omega$, the *relaxation*:
#
# $$ \mathbf{u}^0 = \mathbf{0}, \qquad
#    \mathbf{u}^{n+1} = (1 - \omega)\,\mathbf{u}^n + \omega\, \mathbf{K}^{-1} \mathbf{H}^T
#    (\mathbf{f}_0 + \mathbf{A}\mathbf{H}\mathbf{u}^n) . \tag{12.9} $$
#
# ### 12.10 The iterates


# %% question="12.10"
def iterates(K, H, f0, A, omega, steps):
    """Return u^0, …, u^steps of (12.9), of shape (steps + 1, N).

    K has the shape (N, N), H (M, N), f0 (M,) and A (M, M).
    """
    # BEGIN SOLUTION
    u = np.zeros((steps + 1, len(K)))
    for n in range(steps):
        f = f0 + A @ (H @ u[n])
        u[n + 1] = (1 - omega) * u[n] + omega * np.linalg.solve(K, H.T @ f)
    return u
    # END SOLUTION


# %%
check("12.10")

# %% [markdown]
# ## The typical section
#
# The smallest wing of all: a slice on a torsion spring $k$, free to turn by the angle $\theta$. The
# lift $q S a (\alpha_0 + \theta)$ grows with the angle to the wind and with the dynamic pressure
# $q$, and acts at a distance $e$ before the spring. So (12.8) is one equation,
#
# $$ k\,\theta = e\, q S a\, (\alpha_0 + \theta), \qquad \theta = \frac{\lambda}{1 - \lambda}\,
#    \alpha_0, \qquad
#    \lambda = \frac{q}{q_D}, \quad q_D = \frac{k}{e S a} . \tag{12.10} $$
#
# At $q = q_D$ the spring can no longer hold: the *divergence* of the wing. The picture is made by
# your `iterates`. A negative $\lambda$ belongs to a lift that acts behind the spring ($e < 0$).
# Where do the iterates settle, and where should they?


# %%
def airfoil(theta):
    """Return the outline of a slice of a wing of chord one, its nose up by the angle theta."""
    s = (1 - np.cos(np.linspace(0, np.pi, 40))) / 2
    half = 0.6 * (0.2969 * np.sqrt(s) - 0.126 * s - 0.3516 * s**2 + 0.2843 * s**3 - 0.1015 * s**4)
    line = np.append(s, s[::-1]) - 0.5 + 1j * np.append(half, -half[::-1])
    turned = line * np.exp(-1j * theta)
    return turned.real, turned.imag


@draw(
    lam=Slider(-3, 1.5, 0.6, "λ = q / q_D", steps=45),
    omega=Slider(0.1, 1.6, 1.0, "relaxation ω", steps=30),
)
def typical_section(lam, omega):
    share, alpha = 0.5 - lam / 8, 0.08
    where = 8 * np.array([1 - share, share])
    H, A = np.array([[0.5], [-0.5]]), np.outer(where, [1, -1])
    theta = iterates(np.eye(1), H, alpha * where, A, omega, 14)[:, 0] / alpha
    with figure(6.4, 3.0) as page:
        left, right = page.subplots(1, 2, width_ratios=[1.1, 1])
        left.plot(*airfoil(0), color=GREY, lw=1)
        left.plot(*airfoil(float(np.clip(alpha * theta[-1], -0.7, 0.7))), color=BLUE)
        left.plot(0, 0, "o", color="black", ms=5)
        arrow = {"arrowstyle": "-|>", "color": ORANGE, "lw": 2, "shrinkA": 0, "shrinkB": 0}
        left.annotate("", (share - 0.5, 0.4), (share - 0.5, 0.08), arrowprops=arrow)
        left.text(share - 0.5, 0.43, "lift", color=ORANGE, ha="center")
        left.set(xlim=(-0.6, 0.6), ylim=(-0.45, 0.5), aspect="equal")
        left.axis("off")
        right.plot(np.clip(theta, -1e3, 1e3), "o-", color=BLUE, ms=3, lw=1, label="your iterates")
        if abs(1 - lam) > 1e-9:
            right.axhline(lam / (1 - lam), color=ORANGE, ls="--", label="(12.10)")
        right.set(xlabel="step", ylabel=r"$\theta / \alpha_0$", ylim=(-7, 9))
        right.legend(loc="upper right")
        page.suptitle(
            rf"each step takes $1 - \omega(1 - \lambda) = {1 - omega * (1 - lam):.2f}$ "
            "of the one before"
        )
    return page


# %% [markdown]
# ### 12.11 The divergence of any wing
#
# With $q$ taken out, the loads are $q(\mathbf{f}_0 + \mathbf{A}\mathbf{w})$, and the wing diverges
# at the smallest $q > 0$ at which
#
# $$ \det(\mathbf{K} - q\, \mathbf{H}^T\mathbf{A}\mathbf{H}) = 0 . \tag{12.11} $$
#
# You may take for granted that there is one.
#
# <details><summary>Hint</summary>
#
# If $\mathbf{K}\mathbf{u} = q\,\mathbf{H}^T\mathbf{A}\mathbf{H}\,\mathbf{u}$, of which matrix is
# $1/q$ an eigenvalue? Not all of them need be real (`np.isreal`), or positive.
#
# </details>


# %% question="12.11"
def divergence(K, H, A):
    """Return the smallest q > 0 of (12.11), a number, for K (N, N), H (M, N), A (M, M)."""
    # BEGIN SOLUTION
    growth = np.linalg.eigvals(np.linalg.solve(K, H.T @ A @ H))
    return 1 / growth[np.isreal(growth)].real.max()
    # END SOLUTION


# %%
check("12.11")

# %% [markdown]
# **12.12** (a) For which $\omega > 0$ do the iterates of the typical section converge? Distinguish
# $\lambda < 1$ and $\lambda > 1$. (b) Two things are called divergence here, that of the wing and
# that of the iteration. Find in the picture a $\lambda$ at which the wing is stable and the
# iteration with $\omega = 1$ is not. Which $\omega$ reaches the steady state in one step? (c) For
# $\lambda > 1$, (12.10) still gives a $\theta$. What is it worth?

# %% [markdown] answer="12.12" points=3
# (a) By (12.9) and (12.10), $\theta^{n+1} = (1-\omega)\theta^n + \omega\lambda(\alpha_0 +
# \theta^n)$, so the error is multiplied by $1 - \omega(1-\lambda)$ in each step. For $\lambda < 1$
# its modulus is less than one exactly if $0 < \omega < 2/(1-\lambda)$. For $\lambda > 1$ the factor
# exceeds one for all $\omega > 0$: no relaxation helps. (b) Any $\lambda < -1$, as $\lambda = -2$:
# lift behind the spring turns the nose back, the wing is stable, but with $\omega = 1$ the factor
# is $\lambda$, and the iterates swing wider and wider. $\omega = 1/(1-\lambda)$ makes it zero, so
# that one step suffices; here a third. (c) It is an equilibrium, with the nose down, in which any
# small turn grows: the moment of the lift increases faster than that of the spring. No wing stays
# there.

# %% [markdown] rubric="12.12"
# One point for the factor and both cases. One for an example with $\lambda < -1$ (or $\omega$ too
# large) and the best $\omega$. One for an equilibrium that is unstable.

# %% [markdown]
# ## A wing in the wind
#
# Last, a wing of half span one and constant chord, drawn with its deflection enlarged: a beam that
# bends and twists, two spars of nodes, and strips of air whose lift depends on their angle *in the
# direction of the wind*. The pressure is told as a part of the closed form for a straight wing that
# twists only,
#
# $$ q_D = \Bigl(\frac{\pi}{2 l}\Bigr)^2 \frac{GJ}{c\, e\, a}, \tag{12.12} $$
#
# with the torsional stiffness $GJ$, half span $l$, chord $c$, the arm $e$ and the lift slope $a$.
# Raise the pressure first. Then sweep the wing back, and forward.


# %%
def swept_wing(sweep, n=10, strips=20, chord=0.2, slope=2 * np.pi):
    """Return K, H, f0 for an angle of one, A, for q as a part of (12.12); strips; and the skin."""
    h, apart = 1 / n / np.cos(sweep), 0.16
    along, across = (
        np.array([np.sin(sweep), np.cos(sweep)]),
        np.array([np.cos(sweep), -np.sin(sweep)]),
    )
    axis = h * np.arange(n + 1)[:, None] * along
    nodes = np.vstack([axis - apart / 2 * across, axis + apart / 2 * across])
    y = (np.arange(strips) + 0.5) / strips
    edges = [np.column_stack([y * np.tan(sweep) + s * chord, y]) for s in (-0.4, 0.6)]
    H = np.delete(weights(nodes, np.vstack(edges)), [0, n + 1], axis=1)
    twist = np.diag(np.r_[np.full(n - 1, 2.0), 1]) - np.eye(n, k=1) - np.eye(n, k=-1)
    curve = np.diff(np.vstack([np.eye(n)[0], np.zeros(n), np.eye(n)]), 2, axis=0) / h**2
    bend = h * curve.T @ (np.r_[0.5, np.ones(n - 1)][:, None] * curve)
    mean, angle = np.hstack([np.eye(n)] * 2) / 2, np.hstack([np.eye(n), -np.eye(n)]) / apart
    K = angle.T @ (twist / h) @ angle + 4 * mean.T @ bend @ mean
    pressure = (np.pi / 2) ** 2 / (chord * 0.15 * chord * slope)
    lift = pressure * slope * chord / strips * np.outer([0.75, 0.25], np.ones(strips)).ravel()
    incidence = np.tile(np.hstack([np.eye(strips), -np.eye(strips)]) / chord, (2, 1))
    return K, H, lift, lift[:, None] * incidence, y, np.array(edges)


@draw(
    q=Slider(0, 1.5, 0.6, "pressure", steps=30),
    sweep=Slider(-20, 30, 0, "sweep in degrees", steps=25),
)
def in_the_wind(q, sweep):
    K, H, f0, A, y, edges = swept_wing(np.radians(sweep))
    limit = divergence(K, H, A)
    stands = not 0 < limit <= q
    w = 0.05 * H @ iterates(K, H, q * f0, q * A, 0.25, 1000)[-1] if stands else None
    x, along = np.vstack(edges).T
    with figure(6.4, 3.2) as page:
        left, right = page.subplots(1, 2, width_ratios=[1.25, 1])
        rigid = f0.reshape(2, -1).sum(0)
        for up, color, name in ((0 * x, GREY, "stiff"), (w, BLUE, "elastic")):
            if up is None:
                right.text(0.5, 3, "no steady state", ha="center", color=ORANGE)
                continue
            places = np.column_stack([along + 0.3 * x, up - 0.7 * x])
            front, back = places.reshape(2, -1, 2)
            left.plot(*np.vstack([front, back[::-1], front[:1]]).T, color=color)
            lift = (f0 + A @ up / 0.05).reshape(2, -1).sum(0)
            right.plot(y, lift / rigid[0], color=color, label=name)
        left.set(xlim=(-0.1, 1.3), ylim=(-0.6, 0.85), aspect="equal")
        left.axis("off")
        right.set(xlabel="along the span", ylabel="lift per span", ylim=(0, 6))
        told = f"it diverges at {limit:.2f}" if 0 < limit < 50 else "it never diverges"
        left.set_title(
            f"sweep {sweep:.0f}°, pressure {q:.2f}: {told}".replace("-", "\N{MINUS SIGN}")
        )
        page.legend(loc="outside lower center", ncols=2)
    return page


# %% [markdown]
# **What to look at.** Straight, the wing diverges near the pressure one of the closed form,
# although the loop knows nothing of it: not of the formula, and of the structure only what
# $\mathbf{H}$ and $\mathbf{H}^T$ carry. Near that pressure the tip takes a lift far above that of a
# stiff wing. Swept back, bending turns the tip out of the wind; lift is *lost* to elasticity, as it
# is in an airliner, and the wing hardly ever diverges. Swept forward, bending turns the tip into
# the wind.
#
# ## Dig deeper
#
# - Leave the polynomial out of (12.1), or take a constant only. Which of the three errors in *What
#   goes wrong* stay at rounding?
# - A method that does not interpolate: fit one plane to all nodes by least squares, and let
#   $\mathbf{H}$ be the weights of that. Does it keep work, force and moment? What would a bent wing
#   say to it?
# - Aitken's relaxation chooses $\omega$ anew in each step from the last two answers,
#   $\omega_{n} = -\omega_{n-1}\, \mathbf{r}_{n-1}^T(\mathbf{r}_n - \mathbf{r}_{n-1}) /
#   \lVert\mathbf{r}_n - \mathbf{r}_{n-1}\rVert^2$ with $\mathbf{r}_n$ the answer of the structure
#   less $\mathbf{u}^n$. Why does it need two steps for the typical section, whatever $\lambda \ne
#   1$?
# - What happens at $\lambda > 1$ then, and is that good news?

# %%
progress()
