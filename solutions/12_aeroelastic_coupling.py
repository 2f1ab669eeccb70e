# ---
# jupyter:
#   course:
#     builds_on:
#       "03": the saddle-point system, solved for weights instead of coefficients
#     pages: book, section 1.2
#     chapters: [33-coupling]
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
# # Aeroelastic coupling of two meshes
#
# The air bends a wing, and the bent wing changes the flow of the air. A coupled computation
# usually has two programs: one for the flow, on a *skin* of many points, and one for the
# structure, on a *skeleton* of few nodes. The two meshes have hardly a point in common.
# Displacements must be transferred from the skeleton to the skin, and loads from the skin to the
# skeleton, until a steady state is reached.
#
# In this notebook you write both transfers, prove what they conserve, and compute the steady state
# of a wing. You also compute the dynamic pressure at which no steady state is stable: the
# *divergence* of the wing.
#
# The core takes one sitting. The questions 12.7 to 12.9, on plates, are optional, for a second
# sitting; nothing else uses them.
#
# **Sources.** Wendland, *Scattered Data Approximation* (2005), pages 5–6; Farhat and others (1998)
# and Dowell below. Search for: fluid–structure interaction, conservative load transfer, virtual
# work, Kirchhoff plate, partitioned coupling, torsional divergence. Numbers in brackets, such as
# (12.1), belong to formulas; numbers without brackets belong to questions.
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
from fieldcheck.given import distances, saddle_point_matrix

# %% [markdown]
# ## Two meshes of one wing
#
# The picture shows half a wing, seen from the front and above. The orange nodes are the skeleton:
# an upper and a lower spar, front and rear. The nodes have been displaced by a program for
# structures. The points of the skin (blue) have not been displaced yet. Where should each of them
# go?


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
# ## Transfer of displacements
#
# Let $\mathbf{x}_1, \dots, \mathbf{x}_N \in \mathbb{R}^D$ be the nodes of the skeleton, and $u_1,
# \dots, u_N$ one component of their displacements. We interpolate them by radial basis functions,
#
# $$ s_u(\mathbf{y}) = \sum_{j=1}^N \lambda_j \lVert \mathbf{y} - \mathbf{x}_j \rVert^3 + c_0 +
#    \mathbf{c}^T \mathbf{y}, \qquad
#    \begin{bmatrix} \boldsymbol{\Phi} & \mathbf{P} \\ \mathbf{P}^T & \mathbf{0} \end{bmatrix}
#    \begin{bmatrix} \boldsymbol{\lambda} \\ c_0 \\ \mathbf{c} \end{bmatrix} =
#    \begin{bmatrix} \mathbf{u} \\ \mathbf{0} \end{bmatrix}, \tag{12.1} $$
#
# with $\Phi_{ij} = \lVert \mathbf{x}_i - \mathbf{x}_j \rVert^3$ and the rows $(1, \mathbf{x}_i^T)$
# of $\mathbf{P}$. On a line, $s_u$ is the natural cubic spline: the shape of a thin beam that is
# held at the nodes. The matrix depends on the nodes alone. It is the saddle-point system of
# notebook 03, so it is written for you. Two ready-made functions help: `distances(x, points)`
# returns all distances, of shape $(M, N)$, and `saddle_point_matrix` combines the blocks.


# %% tags=["setup"]
def system(nodes):
    """Return the matrix of (12.1), of shape (N + D + 1, N + D + 1), for nodes (N, D)."""
    linear = np.insert(nodes, 0, 1, axis=1)
    return saddle_point_matrix(distances(nodes, nodes) ** 3, linear)


# %% [markdown]
# The coefficients depend linearly on $\mathbf{u}$, and so do the displacements of the skin. At the
# points $\mathbf{y}_1, \dots, \mathbf{y}_M$ of the skin they are $\mathbf{H}\mathbf{u}$ with a
# matrix of *weights* $\mathbf{H}$. The matrix in (12.1) is symmetric. Therefore the row of
# $\mathbf{H}$ that belongs to $\mathbf{y}$ consists of the first $N$ entries of $\mathbf{w}$ in
#
# $$ \begin{bmatrix} \boldsymbol{\Phi} & \mathbf{P} \\ \mathbf{P}^T & \mathbf{0} \end{bmatrix}
#    \mathbf{w} = \mathbf{b}(\mathbf{y}), \qquad
#    \mathbf{b}(\mathbf{y}) = \bigl(\lVert \mathbf{y} - \mathbf{x}_1 \rVert^3, \dots, \lVert
#    \mathbf{y} - \mathbf{x}_N \rVert^3, 1, \mathbf{y}^T\bigr)^T . \tag{12.2} $$
#
# **Example.** Three nodes on a line, $x = 0, 1, 2$, and one point $y = 1/2$. The system (12.2) is
#
# $$ \begin{bmatrix} 0 & 1 & 8 & 1 & 0 \\ 1 & 0 & 1 & 1 & 1 \\ 8 & 1 & 0 & 1 & 2 \\
#    1 & 1 & 1 & 0 & 0 \\ 0 & 1 & 2 & 0 & 0 \end{bmatrix} \mathbf{w} =
#    \begin{bmatrix} 1/8 \\ 1/8 \\ 27/8 \\ 1 \\ 1/2 \end{bmatrix}, \qquad
#    \mathbf{w} = \frac1{32} \begin{bmatrix} 13 \\ 22 \\ -3 \\ 6 \\ -12 \end{bmatrix} , $$
#
# so $\mathbf{H} = \frac1{32} (13, 22, -3)$. The weights sum to 1. Their mean of the nodes is
# $(22 - 3 \cdot 2) / 32 = 1/2$, the point $y$ itself. Check one row of the system by hand; the next
# cell solves the system. The force in its last line is explained below.

# %%
line = np.array([[0.0], [1.0], [2.0]])
row = np.linalg.solve(system(line), [1 / 8, 1 / 8, 27 / 8, 1, 1 / 2])[:3]
print("32 times the weights:", 32 * row)
print("their sum:", row.sum(), " the mean of the nodes:", row @ line)
print("loads of a force of 32 N at 1/2:", 32 * row, " moment about 0:", 32 * row @ line[:, 0])

# %% [markdown]
# The next function is finished, and shows the form of a function that returns such a matrix. It
# gives each point the displacement of its nearest node. Later it serves as a comparison.


# %% tags=["setup"]
def nearest_node(nodes, points):
    """Return the weights of the nearest node, of shape (M, N), for nodes (N, D), points (M, D)."""
    one_at_nearest = np.zeros((len(points), len(nodes)))
    for i, r in enumerate(distances(points, nodes)):
        one_at_nearest[i, r.argmin()] = 1
    return one_at_nearest


# %%
print(nearest_node(line, np.array([[0.4], [1.7]])))

# %% [markdown]
# ### 12.1 The weights
#
# Return $\mathbf{H}$. The function must work on a line, in the plane and in space, and in any unit
# of length. In the plane the nodes do not all lie on one line, and in space they do not all lie in
# one plane. They are near the origin, at most some ten times as far as from each other. The
# argument `points` contains the $\mathbf{y}_i$.
#
# <details><summary>Hint</summary>
#
# `np.linalg.solve` accepts many right-hand sides at once, as columns. Test your function with the
# three nodes of the example first.
#
# </details>


# %% question="12.1" minutes=15
def weights(nodes, points):
    """Return H of (12.2), of shape (M, N), for nodes (N, D) and points (M, D)."""
    # BEGIN SOLUTION
    ones = np.ones((len(points), 1))
    b = np.hstack([distances(points, nodes) ** 3, ones, points])
    return np.linalg.solve(system(nodes), b.T).T[:, : len(nodes)]
    # END SOLUTION


# %%
check("12.1")

# %% [markdown]
# ## Conservative load transfer
#
# Let $\mathbf{f}_i \in \mathbb{R}^D$ be the force at the point $\mathbf{y}_i$ of the skin, in
# newton (not a force per area). If the nodes move by $\mathbf{u}_j$, the points of the skin move
# by $(\mathbf{H}\mathbf{u})_i$, and the forces do the work $\sum_i (\mathbf{H}\mathbf{u})_i^T
# \mathbf{f}_i$. We require loads $\mathbf{g}_j$ on the structure that do the same *virtual work*:
#
# $$ \sum_{i=1}^M (\mathbf{H}\mathbf{u})_i^T \mathbf{f}_i = \sum_{j=1}^N \mathbf{u}_j^T \mathbf{g}_j
#    \quad \text{for all displacements } \mathbf{u} . \tag{12.3} $$
#
# Taking unit displacements for $\mathbf{u}$ shows that only one choice is possible:
#
# $$ \mathbf{g} = \mathbf{H}^T \mathbf{f} . \tag{12.4} $$
#
# This is *conservative load transfer* (Farhat, Lesoinne and Le Tallec, *Computer Methods in
# Applied Mechanics and Engineering* 157, 1998, pages 95–114; with radial basis functions: Beckert
# and Wendland, *Aerospace Science and Technology* 5, 2001, pages 125–134).
#
# **Example.** In the example above, a force of 32 N at $y = 1/2$ gives the loads 13 N, 22 N and −3
# N. Their sum is 32 N. Their moment about $x = 0$ is $22 \cdot 1 - 3 \cdot 2 = 16$ N m, as that of
# the force, $32 \cdot 1/2$.
#
# ### 12.2 The loads on the structure
#
# Return $\mathbf{g}$ of (12.4).


# %% question="12.2" minutes=10
def loads(H, f):
    """Return g of (12.4), of shape (N, D), for weights H (M, N) and forces f (M, D)."""
    # BEGIN SOLUTION
    return H.T @ f
    # END SOLUTION


# %%
check("12.2")

# %% [markdown]
# The picture shows your own twelve nodes, seen from above. A force of 1 acts at the cross. The
# area of a disc is the load on its node; the number is its value. The ring is the centre of these
# loads. Move the force, also to points outside the structure.


# %%
@draw(
    x=Slider(-0.5, 2.0, 0.6, "x of the force", steps=25),
    y=Slider(-0.5, 1.5, 0.4, "y of the force", steps=20),
)
def footprint(x, y):
    nodes = data("12.1")[0]
    point = np.array([[x, y]])
    parts = np.asarray(loads(weights(nodes, point), np.ones((1, 1))))[:, 0]
    with figure(6.6, 4.6) as page:
        axes = page.subplots()
        for color, sign, name in ((BLUE, 1, "upward"), (ORANGE, -1, "downward")):
            size = 900 * np.maximum(sign * parts, 0)
            axes.scatter(*nodes.T, s=size, color=color, alpha=0.6, lw=0)
            axes.plot([], [], "o", color=color, label=name)
        axes.plot(*nodes.T, ".", color=GREY, ms=3)
        for node, part in zip(nodes, parts):
            label = f"{round(part, 2) + 0:.2f}".replace("-", "\N{MINUS SIGN}")
            axes.text(node[0] + 0.05, node[1] + 0.05, label, fontsize=8)
        axes.plot(*(parts @ nodes), "o", mfc="none", color=PURPLE, ms=15, label="centre of loads")
        axes.plot(x, y, "x", color="black", ms=8, mew=2, label="force")
        axes.set(
            xlim=(-0.6, 2.1),
            ylim=(-0.7, 1.6),
            aspect="equal",
            title=f"sum of the loads {parts.sum():.3f}",
        )
        axes.axis("off")
        axes.legend(loc="center left", bbox_to_anchor=(1, 0.5), labelspacing=1)
    return page


# %% [markdown]
# **What to look at.** A force of 1 far outside causes large loads upward and downward. Their sum
# is still 1, and their centre is still at the force. This is the law of the lever: a force with a
# long arm causes large forces at the supports.
#
# ## Conservation of force and moment
#
# The total force of forces $\mathbf{f}_i$ at points $\mathbf{p}_i$, and their total moment about a
# point $\mathbf{a}$, are
#
# $$ \mathbf{F} = \sum_i \mathbf{f}_i, \qquad \mathbf{M}_{\mathbf{a}} = \sum_i (\mathbf{p}_i -
#    \mathbf{a}) \times \mathbf{f}_i . \tag{12.5} $$
#
# **12.3** Let $\mathbf{H}$ be any matrix, from any method, and let the loads be $\mathbf{g} =
# \mathbf{H}^T\mathbf{f}$. Prove that the total force and the total moment are conserved for all
# $\mathbf{f}$ if and only if each row of $\mathbf{H}$ sums to 1 and $\mathbf{H}$ reproduces linear
# fields.
#
# <details><summary>Hint</summary>
#
# For which displacement is the work $\sum_i (\mathbf{H}\mathbf{u})_i^T\mathbf{f}_i$ a component of
# the total force, and for which a component of the moment? For "only if", take a single force.
#
# </details>

# %% [markdown] answer="12.3" points=4 minutes=20 words=70
# The loads sum to $\sum_i (\sum_j H_{ij})\, \mathbf{f}_i$. If all rows sum to 1, this is
# $\sum_i\mathbf{f}_i$. Conversely, a single force at $\mathbf{y}_i$ is conserved only if its row
# sums to 1.
#
# The moment of the loads is $\sum_i (\sum_j H_{ij}\mathbf{x}_j) \times \mathbf{f}_i$. It is $\sum_i
# \mathbf{y}_i \times \mathbf{f}_i$ for all forces exactly if $\sum_j H_{ij}\mathbf{x}_j =
# \mathbf{y}_i$ (again by single forces): linear fields are reproduced.
#
# *Beyond the question.* The moment about another point $\mathbf{a}$ is conserved as well, since the
# total force is. Force and moment are the work in a rigid motion: a translation, or a rotation
# $\boldsymbol\omega \times \mathbf{x}$. Wendland (*Scattered Data Approximation*, 2005, page 6)
# writes that interpolation is "crucial" for conserving work. It is not: by (12.3) work is conserved
# for every $\mathbf{H}$, whatever its values at nodes. A least-squares fit of planes does not
# interpolate, and conserves work, force and moment as well. The loads must be transferred by the
# transpose. If displacements and loads are both interpolated, work *is* lost.

# %% [markdown] rubric="12.3"
# One point for the force, "if". One for the force, "only if", by single forces for instance. One
# for the moment, "if". One for the moment, "only if".

# %% [markdown]
# ### 12.4 Force and moment
#
# Write (12.5) in space, to measure what is conserved.


# %% question="12.4" minutes=5
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
# ## Comparison of four load transfers
#
# A simpler idea is to interpolate loads as displacements are interpolated: a field through the
# values on the skin, evaluated at the nodes. The picture compares four transfers for the wing
# above:
#
# - forces, interpolated;
# - pressures (force per area), interpolated, then multiplied by the area that belongs to each
#   node;
# - each force applied to the nearest node, by `nearest_node`;
# - your transpose (12.4).
#
# The three columns show the relative errors of the lift, of the moment that bends the wing, and of
# the moment that twists it. Errors below $10^{-16}$ are drawn at $10^{-16}$.


# %%
def arrivals(stations):
    """Return force and moment on the skin, and those of the loads of each transfer."""
    nodes, skin, areas = half_wing(stations)
    s, t = (skin[:, 0] - 0.3 * skin[:, 1]) / (0.6 - 0.3 * skin[:, 1]), skin[:, 1]
    pressure = np.sqrt(1 - t**2) * (1 - s)
    f = (pressure * areas)[:, None] * [0.05, 0, 1]
    H, back = weights(nodes, skin), weights(skin, nodes)
    transfers = {
        "forces interpolated": back @ f,
        "pressures interpolated": (back @ (f / areas[:, None])) * loads(H, areas[:, None]),
        "to the nearest node": loads(nearest_node(nodes, skin), f),
        "your transpose": loads(H, f),
    }
    wanted = resultants(skin, f, np.zeros(3))
    return wanted, {name: resultants(nodes, g, np.zeros(3)) for name, g in transfers.items()}


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
# **What to look at.** If forces are interpolated, most of the lift is lost: a force belongs to a
# piece of the skin, and there are fewer nodes than pieces. Interpolated pressures have nearly the
# right lift, but the twisting moment has an error of about 12 %, and more stations do not reduce
# it. The nearest node conserves the lift, since each row has a single 1; the moments are wrong.
# The transpose is exact up to rounding, with three stations or with fourteen.
#
# **12.5** Wendland (2005, page 5) requires two properties of loads $\mathbf{g} =
# \mathbf{G}\mathbf{f}$. Constant loads, $f_i = 1$ for all $i$, are reproduced as $g_j = 1$; and the
# total force is conserved for all $\mathbf{f}$. Show that no matrix $\mathbf{G}$ has both
# properties unless $M = N$.

# %% [markdown] answer="12.5" points=2 minutes=10 words=30
# With vectors of ones, the first property is $\mathbf{G}\mathbf{1}_M = \mathbf{1}_N$. The second is
# $\mathbf{1}_N^T\mathbf{G} = \mathbf{1}_M^T$: each column sums to one. Both together give $N =
# \mathbf{1}_N^T\mathbf{1}_N = \mathbf{1}_N^T\mathbf{G}\mathbf{1}_M = \mathbf{1}_M^T\mathbf{1}_M =
# M$.
#
# *Beyond the question.* Forty forces of one, with the sum forty, would become twelve of one, with
# the sum twelve. The total force is physics and must be conserved. The first property makes sense
# for a *density*, force per area. It can be constant on both meshes, while single forces depend on
# the mesh: a finer mesh has smaller forces. Constant densities can be reproduced while their
# integrals agree, as the next question shows.

# %% [markdown] rubric="12.5"
# One point for both properties as equations, or for an example of constant loads. One for the
# contradiction: the sums $M$ and $N$ must be equal.

# %% [markdown]
# ## Transfer of pressures
#
# Let $m_i$ be the area of the point $\mathbf{y}_i$ and $p_i$ the pressure there, so that $m_i p_i$
# is a force. Areas are transferred to the nodes as forces are. The pressure at a node is force
# divided by area:
#
# $$ m'_j = \sum_{i=1}^M H_{ij}\, m_i, \qquad p'_j = \frac{1}{m'_j} \sum_{i=1}^M H_{ij}\, m_i\, p_i
#    . \tag{12.6} $$
#
# Weights may be negative, but in the inputs no $m'_j$ is zero.
#
# ### 12.6 Pressures on the structure
#
# Return $p'_j$ of (12.6) for all nodes.


# %% question="12.6" minutes=5
def densities(H, p, m):
    """Return p' of (12.6), of shape (N,), for weights H (M, N), pressures p (M,), areas m (M,)."""
    # BEGIN SOLUTION
    return (H.T @ (m * p)) / (H.T @ m)
    # END SOLUTION


# %%
check("12.6")

# %% [markdown]
# ## Optional: structures without thickness (Kirchhoff plate)
#
# *The questions 12.7 to 12.9 are optional. Continue with "Partitioned coupling" for the core.*
#
# A simple model of a wing is a plate, with all nodes in one plane of space. Then the matrix of
# (12.1) in space is singular, since the nodes do not determine linear polynomials of three
# variables: `np.linalg.solve` reports this, or returns meaningless numbers.
#
# The remedy is the assumption of the *Kirchhoff plate*: normals of the plate remain straight and
# normal to it. Let the plate be $x_3 = 0$, and let $\mathbf{y} = (\mathbf{p}, \zeta)$ lie at the
# height $\zeta$ above the point $\mathbf{p}$ of the plate. With $\mathbf{H}$ and its derivatives
# $\mathbf{G}^k$ *in the plane*,
#
# $$ (H\mathbf{u})_i = s_{\mathbf{u}}(\mathbf{p}_i), \qquad G^k_{ij} = \frac{\partial
#    H_{ij}}{\partial p_k}, \qquad
#    \mathbf{v}_i = \sum_j H_{ij}\, \mathbf{u}_j - \zeta_i \sum_j u_{j3} \begin{pmatrix} G^1_{ij} \\
#    G^2_{ij} \\ 0 \end{pmatrix} . \tag{12.7} $$
#
# Here $\mathbf{v}_i$ is the displacement of the point of the skin. Its first term is the
# displacement of the plate below the point. Its second term is due to the tilt of the plate, with
# the arm $\zeta_i$.
#
# ### 12.7 The slopes
#
# Return the derivatives $\mathbf{G}^k$, in any dimension and any unit of length, for nodes as in
# 12.1. In (12.2) only $\mathbf{b}$ depends on $\mathbf{y}$. Its derivative with respect to the
# coordinate $y_k$ has the entries
#
# - $3 \lVert \mathbf{y} - \mathbf{x}_j \rVert\, (y_k - x_{jk})$ for $j = 1, \dots, N$,
# - then 0, the derivative of the entry 1,
# - then $D$ entries for the coordinates: 1 for the coordinate $k$, 0 for the others.


# %% question="12.7" minutes=20 optional
def slopes(nodes, points):
    """Return G of shape (D, M, N), the derivatives of H along the D axes.

    nodes have the shape (N, D), points (M, D).
    """
    # BEGIN SOLUTION
    n, r = len(nodes), distances(points, nodes)
    g = []
    for k in range(nodes.shape[1]):
        b = np.zeros((len(points), len(system(nodes))))
        b[:, :n] = 3 * r * (points[:, [k]] - nodes[:, k])
        b[:, n + 1 + k] = 1
        g.append(np.linalg.solve(system(nodes), b.T).T[:, :n])
    return np.array(g)
    # END SOLUTION


# %%
check("12.7")

# %% [markdown]
# ### 12.8 Loads on a plate
#
# The loads follow from virtual work again: $\mathbf{g}$ must do the work $\sum_i
# \mathbf{v}_i^T\mathbf{f}_i$ in every displacement $\mathbf{u}$. Collect the factors of
# $\mathbf{u}_j$ in (12.7). Which components of $\mathbf{g}_j$ differ from those of
# $\mathbf{H}^T\mathbf{f}$?
#
# <details><summary>Hint</summary>
#
# Only $u_{j3}$ is multiplied by slopes, so only $g_{j3}$ has an additional term. Which components
# of $\mathbf{f}_i$ multiply the slopes?
#
# </details>


# %% question="12.8" minutes=15 optional
def flat_loads(nodes, points, f):
    """Return g (N, 3) for nodes (N, 2) of the plane, points (M, 3) and forces (M, 3)."""
    # BEGIN SOLUTION
    p, height = points[:, :2], points[:, 2]
    g1, g2 = slopes(nodes, p)
    g = weights(nodes, p).T @ f
    g[:, 2] -= g1.T @ (height * f[:, 0]) + g2.T @ (height * f[:, 1])
    return g
    # END SOLUTION


# %%
check("12.8")

# %% [markdown]
# Your own plate of nine nodes. A force of 1 acts parallel to the plate at a height, like the
# thrust of an engine above the wing. The blue arrows are the loads normal to the plate.


# %%
@draw(height=Slider(-0.6, 0.6, 0.4, "height of the force", steps=24))
def pulled_along(height):
    nodes = data("12.8")[0]
    point, force = np.array([[0.5, 0.5, height]]), np.array([[1.0, 0, 0]])
    g = flat_loads(nodes, point, force)
    flat = np.pad(nodes, ((0, 0), (0, 1)))
    before, after = (resultants(p, f, np.zeros(3)) for p, f in ((point, force), (flat, g)))

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
        foot = np.vstack([point * [1, 1, 0], point, point + [0.45, 0, 0]])
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
        axes.plot([], [], color=BLUE, lw=2, label="loads normal to the plate")
        axes.set(xlim=(-0.3, 1.9), ylim=(-0.75, 1.25), aspect="equal")
        axes.set_title(
            f"moment about the y axis: {before[4]:.2f} of the force, {after[4]:.2f} of the loads"
        )
        axes.axis("off")
        axes.legend(loc="upper left")
    return page


# %% [markdown]
# **12.9** Show that (12.7) reproduces the rotation $\mathbf{u}_j = \boldsymbol\omega \times
# \mathbf{x}_j$ at every point of the skin, and conclude that the total moment is conserved.
#
# <details><summary>Hint</summary>
#
# A rotation is a linear field in the plane, which $\mathbf{H}$ and $\mathbf{G}^k$ treat exactly:
# what are its third component and the slopes of it? A moment is the work in rotations.
#
# </details>

# %% [markdown] answer="12.9" points=3 minutes=10 words=50 optional
# In the plane the rotation is linear, so the first sum is its value at $\mathbf{p}_i$. Its third
# component has the slopes $-\omega_2$ and $\omega_1$. The second term is $\zeta_i(\omega_2,
# -\omega_1, 0) = \boldsymbol\omega \times (0, 0, \zeta_i)$, and $\mathbf{v}_i =
# \boldsymbol\omega\times\mathbf{y}_i$. The moment is the work in rotations, which the loads
# conserve.
#
# *Beyond the question.* The matrix of (12.1) is singular if all nodes lie in the plane $x_3 = 0$:
# the polynomial $y_3$ vanishes at all of them and solves the homogeneous system, with
# $\boldsymbol\lambda = \mathbf{0}$. Displacements in one plane do not determine how a field changes
# *across* the plane. (12.7) assumes instead that the normal stays straight and normal to the plate.
# In the plane, $\boldsymbol\omega\times\mathbf{x} = (-\omega_3 x_2,\ \omega_3 x_1,\ \omega_1 x_2 -
# \omega_2 x_1)$.

# %% [markdown] rubric="12.9"
# One point for the first sum: the rotation is linear in the plane. One for the second term, from
# the slopes of the third component. One for the work in rotations as the reason for the moment.

# %% [markdown]
# ## Partitioned coupling
#
# Now both programs together. Let all displacements be vertical, so $\mathbf{u} \in \mathbb{R}^N$.
# Three terms from engineering: the *stiffness matrix* $\mathbf{K}$ gives the forces
# $\mathbf{K}\mathbf{u}$ that are needed to hold the displacements $\mathbf{u}$. The *dynamic
# pressure* $q = \frac12 \rho V^2$ grows with the square of the air speed $V$; all air loads are
# proportional to it. The loads on the skin are $\mathbf{f}_0$ for the undeformed wing. They change
# linearly with its displacements $\mathbf{w} = \mathbf{H}\mathbf{u}$, by $\mathbf{A}\mathbf{w}$.
# In the steady state
#
# $$ \mathbf{K}\mathbf{u} = \mathbf{H}^T \mathbf{f}, \qquad \mathbf{f} = \mathbf{f}_0 +
#    \mathbf{A}\mathbf{H}\mathbf{u} . \tag{12.8} $$
#
# A *partitioned* scheme alternates between the two programs: with the loads for $\mathbf{u}^n$,
# the structure computes the displacement $\mathbf{K}^{-1}\mathbf{H}^T\mathbf{f}$. Each step is
# *relaxed* by a factor $\omega$, so this is a fixed-point iteration with relaxation:
#
# $$ \mathbf{u}^0 = \mathbf{0}, \qquad
#    \mathbf{u}^{n+1} = (1 - \omega)\,\mathbf{u}^n + \omega\, \mathbf{K}^{-1} \mathbf{H}^T
#    (\mathbf{f}_0 + \mathbf{A}\mathbf{H}\mathbf{u}^n) . \tag{12.9} $$
#
# **Example.** One unknown, $K = 2$, $H = 1$, $f_0 = 1$, $A = 1$ and $\omega = 1$. Then $u^{n+1} =
# (1 + u^n)/2$, and the iterates are $0, \frac12, \frac34, \frac78, \dots$ They converge to $u =
# 1$, where $2u = 1 + u$. If (12.8) has no solution, the iterates exist all the same.
#
# ### 12.10 The iterates
#
# Return all iterates of (12.9), a row for each. $\mathbf{K}$ is symmetric and positive definite,
# here and in 12.11. The iterates may diverge, and `steps` may be 0.


# %% question="12.10" minutes=15
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
# The smallest elastic wing is a rigid slice on a torsion spring, the *typical section* (Dowell, *A
# Modern Course in Aeroelasticity*, section 2.1). The picture explains the letters. The section
# rotates about the *elastic axis* by the angle $\theta$. A torsion spring with the constant $k$
# holds it. The wind has the angle of attack $\alpha_0$ to the unloaded section. The *lift* acts at
# the centre of pressure, at a distance $e$ ahead of the elastic axis.


# %%
def airfoil(theta):
    """Return the outline of an aerofoil of chord 1, rotated nose-up by the angle theta."""
    s = (1 - np.cos(np.linspace(0, np.pi, 40))) / 2
    half = 0.6 * (0.2969 * np.sqrt(s) - 0.126 * s - 0.3516 * s**2 + 0.2843 * s**3 - 0.1015 * s**4)
    outline = np.append(s, s[::-1]) - 0.5 + 1j * np.append(half, -half[::-1])
    outline = outline * np.exp(-1j * theta)
    return outline.real, outline.imag


@draw()
def sketch_of_the_section():
    angle = 0.3
    nose, centre = -0.5 * np.exp(-1j * angle), -0.28 * np.exp(-1j * angle)
    with figure(6.4, 2.6) as page:
        axes = page.subplots()
        axes.fill(*airfoil(angle), facecolor="#e6eef6", edgecolor=BLUE)
        axes.plot([-0.75, 0.75], [0, 0], ":", color=GREY, lw=1)
        axes.plot(
            [1.3 * nose.real, -1.1 * nose.real],
            [1.3 * nose.imag, -1.1 * nose.imag],
            "--",
            color=GREY,
            lw=1,
        )
        t = np.linspace(0, 5 * np.pi, 200)
        axes.plot(0.012 * t * np.cos(t) / 2, 0.012 * t * np.sin(t) / 2, color="black", lw=1.2)
        arrow = {"arrowstyle": "-|>", "lw": 2, "shrinkA": 0, "shrinkB": 0}
        axes.annotate(
            "",
            (centre.real, 0.52),
            (centre.real, centre.imag),
            arrowprops=arrow | {"color": ORANGE},
        )
        axes.text(
            centre.real + 0.03, 0.45, "lift  $q\\,S\\,a\\,(\\alpha_0 + \\theta)$", color=ORANGE
        )
        for height in (-0.12, 0.06, 0.24):
            axes.annotate(
                "", (-0.82, height), (-1.1, height), arrowprops=arrow | {"color": GREY, "lw": 1}
            )
        axes.text(-1.1, -0.26, "wind, dynamic pressure $q$", color=GREY)
        axes.annotate(
            "",
            (centre.real, -0.2),
            (0, -0.2),
            arrowprops=arrow | {"color": PURPLE, "arrowstyle": "<->", "lw": 1.2},
        )
        axes.plot([0, 0], [-0.22, 0], color=PURPLE, lw=0.6)
        axes.plot([centre.real] * 2, [-0.22, centre.imag], color=PURPLE, lw=0.6)
        axes.text(centre.real / 2, -0.31, "$e$", color=PURPLE, ha="center")
        axes.text(0.06, 0.12, "elastic axis with\ntorsion spring $k$")
        axes.text(-0.79, 0.03, r"$\alpha_0 + \theta$", va="bottom")
        axes.set(xlim=(-1.15, 0.8), ylim=(-0.38, 0.56), aspect="equal")
        axes.axis("off")
    return page


# %% [markdown]
# With the wing area $S$ and the *lift slope* $a$ (lift coefficient per angle), the moments of lift
# and spring are in equilibrium if
#
# $$ k\,\theta = e\, q S a\, (\alpha_0 + \theta), \qquad \theta = \frac{\lambda}{1 - \lambda}\,
#    \alpha_0, \qquad
#    \lambda = \frac{q}{q_D}, \quad q_D = \frac{k}{e S a} . \tag{12.10} $$
#
# At $q = q_D$ the spring cannot balance the lift any more: the *divergence* of the wing.
# For $\lambda < 1$ the wing is *stable*. A negative $\lambda$ means that the centre of pressure is
# behind the elastic axis ($e < 0$). The next picture uses your `iterates`. To which angle do they
# converge, and do they converge at all?


# %%
@draw(
    lam=Slider(-3, 1.5, 0.6, "λ = q / q_D", steps=45),
    omega=Slider(0.1, 1.6, 1.0, "relaxation ω", steps=30),
)
def typical_section(lam, omega):
    share, alpha = 0.5 - lam / 8, 0.08
    where = 8 * np.array([1 - share, share])
    H, A = np.array([[0.5], [-0.5]]), np.outer(where, [1, -1])
    theta = np.asarray(iterates(np.eye(1), H, alpha * where, A, omega, 14))[:, 0] / alpha
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
        right.set(xlabel="iteration", ylabel=r"$\theta / \alpha_0$", ylim=(-7, 9))
        right.legend(loc="upper right")
        factor = f"{1 - omega * (1 - lam):.2f}".replace("-", "\N{MINUS SIGN}")
        page.suptitle(rf"error multiplied by $1 - \omega(1 - \lambda) =$ {factor} per iteration")
    return page


# %% [markdown]
# ### 12.11 The divergence pressure of a wing
#
# Let the loads be $q(\mathbf{f}_0 + \mathbf{A}\mathbf{w})$. The wing diverges at the smallest $q >
# 0$ with
#
# $$ \det(\mathbf{K} - q\, \mathbf{H}^T\mathbf{A}\mathbf{H}) = 0 . \tag{12.11} $$
#
# Return this $q$, a real number. Assume that there is one, and that it belongs to a simple
# eigenvalue.
#
# <details><summary>Hint</summary>
#
# If $\mathbf{K}\mathbf{u} = q\,\mathbf{H}^T\mathbf{A}\mathbf{H}\,\mathbf{u}$, of which matrix is
# $1/q$ an eigenvalue? The eigenvalues may be complex (`np.isreal`) or negative.
#
# </details>


# %% question="12.11" minutes=10
def divergence(K, H, A):
    """Return the smallest q > 0 of (12.11), a number, for K (N, N), H (M, N), A (M, M)."""
    # BEGIN SOLUTION
    growth = np.linalg.eigvals(np.linalg.solve(K, H.T @ A @ H))
    return 1 / growth[np.isreal(growth)].real.max()
    # END SOLUTION


# %%
check("12.11")

# %% [markdown]
# **12.12** Divergence of the wing and divergence of the iteration are different things. For which
# $\omega > 0$ do the iterates of the typical section converge, if $\lambda < 1$ and if $\lambda >
# 1$?
#
# <details><summary>Hint</summary>
#
# Subtract the equation for the steady state from (12.9). By which factor is the error multiplied?
#
# </details>

# %% [markdown] answer="12.12" points=3 minutes=10 words=50
# Since $\theta^{n+1} = (1-\omega)\theta^n + \omega\lambda(\alpha_0 + \theta^n)$, each step
# multiplies the error by $1 - \omega(1-\lambda)$. For $\lambda < 1$ the factor is less than 1, and
# the iterates converge exactly if it is greater than $-1$: if $\omega < 2/(1-\lambda)$. For
# $\lambda > 1$ the factor exceeds 1 for all $\omega > 0$, so they diverge.
#
# *Beyond the question.* The first formula follows from (12.9) and (12.10). With $\omega =
# 1/(1-\lambda)$ the factor is zero. With $\lambda = -2$, or any $\lambda < -1$, lift behind the
# axis rotates the nose back, so the wing is stable; but with $\omega = 1$ the factor is $\lambda$,
# and the iterates oscillate with growing amplitude. For $\lambda > 1$ the $\theta$ of (12.10) is an
# equilibrium with the nose down. Any small rotation grows there, since the moment of the lift
# increases faster than that of the spring. An unstable equilibrium does not occur in practice.

# %% [markdown] rubric="12.12"
# One point for the factor of the error. One for the bound of $\omega$ if $\lambda < 1$. One for the
# conclusion that no $\omega > 0$ suffices if $\lambda > 1$.

# %% [markdown]
# ## An elastic wing with sweep
#
# Finally a wing of half span 1 and constant chord, drawn with its deflection enlarged. Its
# structure is a beam that bends and twists, with two rows of nodes. The air is divided into strips
# whose lift depends on their angle *in the direction of the wind*. The *sweep* is the angle by
# which the wing points backward. The pressure is given as a multiple of the closed form for a
# straight wing that only twists,
#
# $$ q_D = \Bigl(\frac{\pi}{2 l}\Bigr)^2 \frac{GJ}{c\, e\, a}, \tag{12.12} $$
#
# with the torsional stiffness $GJ$, half span $l$, chord $c$, the distance $e$ and the lift slope
# $a$. The function `swept_wing` below assembles $\mathbf{K}$, $\mathbf{H}$, $\mathbf{f}_0$ and
# $\mathbf{A}$: $\mathbf{K}$ has a term for each twist between neighbouring stations, and one for
# each curvature of the axis. Increase the pressure first. Then sweep the wing backward, and
# forward.


# %%
def swept_wing(sweep, n=10, strips=20, chord=0.2, slope=2 * np.pi):
    """Return K, H, f0 and A for a pressure in units of (12.12), strips, and edges of the skin."""
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
    limit = float(divergence(K, H, A))
    stands = not 0 < limit <= q
    w = 0.05 * H @ iterates(K, H, q * f0, q * A, 0.25, 1000)[-1] if stands else None
    x, along = np.vstack(edges).T
    with figure(6.6, 4.9) as page:
        above, below = page.subplots(2, 1, height_ratios=[1.8, 1])
        rigid = f0.reshape(2, -1).sum(0)
        for up, color, name in ((0 * x, GREY, "rigid"), (w, BLUE, "elastic")):
            if up is None:
                below.text(0.5, 3, "no stable steady state", ha="center", color=ORANGE)
                continue
            drawn = np.column_stack([along + 0.25 * x, up - 0.45 * x])
            front, back = drawn.reshape(2, -1, 2)
            above.plot(*np.vstack([front, back[::-1], front[:1]]).T, color=color)
            above.plot(
                *np.stack([front, back], axis=1)[::3].transpose(2, 1, 0), color=color, lw=0.6
            )
            lift = (f0 + A @ up / 0.05).reshape(2, -1).sum(0)
            below.plot(y, lift / rigid[0], color=color, label=name)
        above.set(xlim=(-0.02, 1.18), ylim=(-0.36, 0.3), aspect="equal")
        above.axis("off")
        below.set(xlabel="position along the span", ylabel="lift per span", ylim=(0, 6))
        below.legend(loc="upper left")
        result = f"divergence at {limit:.2f}" if 0 < limit < 50 else "no divergence"
        above.set_title(
            f"sweep {sweep:.0f}°, pressure {q:.2f}: {result}".replace("-", "\N{MINUS SIGN}")
        )
    return page


# %% [markdown]
# **What to look at.** The straight wing diverges at about 1.02 times the pressure of the closed
# form. The computation does not use the formula; it knows the structure by $\mathbf{K}$,
# $\mathbf{H}$ and $\mathbf{H}^T$ only. Near this pressure the lift at the tip is far above that of
# a rigid wing. With backward sweep, bending rotates the tip out of the wind: elasticity *reduces*
# the lift, as in an airliner, and divergence needs a much higher pressure or does not occur. With
# forward sweep, bending rotates the tip into the wind, and the wing diverges earlier.
#
# ## Dig deeper
#
# - Omit the polynomial in (12.1), or use a constant only. Which of the three errors in the
#   comparison of load transfers remain at rounding level?
# - Fit one plane to all nodes by least squares, and let $\mathbf{H}$ be the weights of this fit.
#   Which of work, force and moment are conserved? Which displacements of a bent wing are lost?
# - *Aitken's relaxation* chooses $\omega$ anew in each step from the last two residuals,
#   $\omega_{n} = -\omega_{n-1}\, \mathbf{r}_{n-1}^T(\mathbf{r}_n - \mathbf{r}_{n-1}) /
#   \lVert\mathbf{r}_n - \mathbf{r}_{n-1}\rVert^2$, where $\mathbf{r}_n =
#   \mathbf{K}^{-1}\mathbf{H}^T\mathbf{f} - \mathbf{u}^n$ (Küttler and Wall, *Computational
#   Mechanics* 43, 2008, pages 61–72). Show that it needs two steps for the typical section, for
#   every $\lambda \ne 1$. What does it find for $\lambda > 1$?

# %%
progress()
