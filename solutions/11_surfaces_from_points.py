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
# # Surfaces from point clouds
#
# A scanner measures points on a body, and nothing else: no triangles, no inside and outside, no
# order. By the end of this notebook you have found a function $F$ whose zero level runs through the
# points, positive inside and negative outside, and you have drawn it. Everything works in the
# plane, where pictures are clear, and in space without a change.
#
# The road has four stations: normals, their signs, points beside the surface, and interpolation.
# Eight functions.

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
    draw,
    figure,
    progress,
    start_over,
)

SQUARE = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])


def augmented(points, normals, lengths):
    """Return sites (3N, D) and values (3N,): the points, those outside, those inside.

    Lengths (N, 2) tell how far beside each point they are.
    """
    outer, inner = lengths[:, :1], lengths[:, 1:]
    sites = np.concatenate([points, points + outer * normals, points - inner * normals])
    return sites, np.concatenate([0 * outer, -outer, inner]).ravel()


# %% [markdown]
# The next cell makes clouds and draws them. Run it; you need not read it.

# %%
from fieldcheck.questions.q11_point_clouds import OBLIQUE, horseshoe, outward, torus


def cloud(n, noise=0.0, seed=5):
    """Return n points of a horseshoe, off by some noise."""
    random = np.random.default_rng(seed)
    return horseshoe(random, n, 0.2) + noise * random.normal(size=(n, 2))


def draw_cloud(axes, points, color="black", size=3.5):
    """Draw points."""
    axes.plot(*points.T, "o", ms=size, color=color, zorder=3)
    axes.set_aspect("equal")
    axes.set_axis_off()


def draw_normals(axes, points, normals, length=0.22, color=BLUE, both=False):
    """Draw normals as lines from their points, or to both sides."""
    n = length * np.asarray(normals)
    draw_pieces(axes, np.stack([points - both * n, points + n], axis=1), color=color, lw=1.4)


def draw_pieces(axes, ends, **style):
    """Draw lines from point to point, given their ends (K, 2, 2)."""
    if len(ends):
        gaps = np.insert(np.asarray(ends, dtype=float), 2, np.nan, axis=1)
        axes.plot(*gaps.reshape(-1, 2).T, zorder=2, **style)


def lattice(n, size=1.9):
    """Return the nodes of a grid of n × n squares about the origin, row by row, (n + 1, n + 1,
    2).
    """
    side = np.linspace(-size, size, n + 1)
    return np.stack(np.meshgrid(side, side), axis=-1)


# %% [markdown]
# ## The problem in a picture
#
# Points of a closed curve. Where does it run, and where is inside? With how few points do you still
# see it?


# %%
@draw(points=Slider(12, 120, 44, "points", steps=54, whole=True))
def problem(points):
    with figure(6.4, 2.9) as page:
        left, right = page.subplots(1, 2)
        draw_cloud(left, cloud(points))
        draw_cloud(right, cloud(points, 0.03))
        left.set(title="exact")
        right.set(title="as a scanner has them")
    return page


# %% [markdown]
# Whoever sees the curve joins points to their neighbours. Near a point a smooth curve looks like a
# straight line, and a smooth surface like a plane. That is the first station.
#
# ## Normals
#
# Let $N(i)$ be the $K$ points nearest to $\mathbf{p}_i$, itself among them. Their centre and the
# matrix of their variances are
#
# $$ \mathbf{m}_i = \frac1K \sum_{j \in N(i)} \mathbf{p}_j , \qquad
#    \mathbf{C}_i = \sum_{j \in N(i)} (\mathbf{p}_j - \mathbf{m}_i)(\mathbf{p}_j - \mathbf{m}_i)^T .
#    \tag{11.1} $$
#
# $\mathbf{C}_i$ has $D$ eigenvalues $\lambda_1 \ge \dots \ge \lambda_D \ge 0$: the variances along
# its eigenvectors. Across a line or plane through the neighbours there is the least variance. So
# the normal $\mathbf{n}_i$ is the unit eigenvector that belongs to $\lambda_D$. Its sign is open.
# The *planarity*
#
# $$ q_i = 1 - \lambda_D / \lambda_{D-1} \tag{11.2} $$
#
# is one if the neighbours lie in a plane, and zero if no plane is better than another.
#
# ### 11.1 Normals and planarity
#
# <details><summary>Hint</summary>
#
# Point by point. `np.argsort` of the distances gives the nearest first. `np.linalg.eigh` returns
# eigenvalues, the least first, and eigenvectors as *columns*.
#
# </details>


# %% question="11.1"
def normals(points, k):
    """Return unit normals (N, D), of any sign, and q of (11.2), (N,), for points (N, D)."""
    # BEGIN SOLUTION
    n, planarity = np.zeros(points.shape), np.zeros(len(points))
    for i in range(len(points)):
        near = points[np.argsort(np.linalg.norm(points - points[i], axis=1))[:k]]
        offsets = near - np.mean(near, axis=0)
        variances, axes = np.linalg.eigh(offsets.T @ offsets)
        n[i], planarity[i] = axes[:, 0], 1 - variances[0] / variances[1]
    return n, planarity
    # END SOLUTION


# %%
check("11.1")


# %%
@draw(
    k=Slider(3, 30, 12, "neighbours K", whole=True),
    noise=Slider(0, 0.1, 0.04, "noise", steps=25),
)
def estimated(k, noise):
    points = cloud(90, noise)
    n, planarity = (np.asarray(a) for a in normals(points, k))
    angle = np.degrees(np.arccos(np.clip(np.abs((n * outward(points)).sum(axis=1)), 0, 1)))
    with figure(6.4, 3.1) as page:
        left, right = page.subplots(1, 2, width_ratios=(5, 4))
        draw_cloud(left, points, size=2.5)
        good = planarity > 0.75
        draw_normals(left, points[good], n[good], 0.12, BLUE, both=True)
        draw_normals(left, points[~good], n[~good], 0.12, ORANGE, both=True)
        left.set(title="blue: planarity above ¾")
        right.plot(planarity, angle, "o", ms=3.5, color=PURPLE)
        right.set(xlabel="planarity", ylabel="error of the normal in degrees", xlim=(-0.03, 1.03))
        right.set(ylim=(-3, 93), title=f"in the mean {angle.mean():.1f}°")
    return page


# %% [markdown]
# **What to look at.** Few neighbours see the noise, many see round the corner. There is a best
# number between, and it grows with the noise. A small planarity warns. A large one promises little:
# where the curve begins to bend, the neighbours may lie close to a line that is not the tangent
# (dots high up, on the right).
#
# ## Neighbours
#
# The normals have lines and no arrows yet. Neighbours should agree: the idea is to begin at one
# point, and to hand the sign on from neighbour to neighbour. "$j$ is among the $K$ nearest of $i$"
# does not go both ways: a lonely point has neighbours to whom it is none. So points are *linked* if
# one of the two holds,
#
# $$ g_{ij} = 1 \iff i \neq j \text{ and } \big( j \in N(i) \text{ or } i \in N(j) \big). \tag{11.3}
#    $$
#
# ### 11.2 The graph


# %% question="11.2"
def linked(points, k):
    """Return g of (11.3), zeros and ones of shape (N, N), for points (N, D)."""
    # BEGIN SOLUTION
    graph = np.zeros((len(points), len(points)))
    for i in range(len(points)):
        nearest = np.argsort(np.linalg.norm(points - points[i], axis=1))[1:k]
        graph[i, nearest] = 1
    return np.maximum(graph, graph.T)
    # END SOLUTION


# %%
check("11.2")

# %% [markdown]
# ## Orientation
#
# Over which link can a sign be handed on? Two normals that are nearly parallel leave no doubt. If
# they stand at right angles the sign is a guess. So let a link cost
#
# $$ w_{ij} = 1 - | \mathbf{n}_i^T \mathbf{n}_j | , \tag{11.4} $$
#
# which does not depend on the signs, and take the cheapest links that connect all points:
# the *minimum spanning tree*. Along it the signs go: if $\mathbf{n}_i^T \mathbf{n}_j < 0$ the new
# one is turned round.
#
# The tree grows from one point. At each step, of all links from the tree to a point outside of it,
# take the cheapest. And the first sign? At the *highest* point, that with the greatest last
# coordinate, the outward normal points upward: its last component is positive. If links do not
# reach all points there are several parts, and each begins anew at its highest point.
#
# ### 11.3 Orient
#
# You are given the normals, and the links as an array of ones and zeros.
#
# <details><summary>Hint</summary>
#
# Keep for each point outside of the tree the least cost of a link to the tree, infinite at first,
# and where that link begins. When a point joins the tree, update both for the points that it is
# linked to. If the least of all costs is infinite, a new part begins. `np.where(outside, cost,
# np.inf)` hides the points that have joined.
#
# </details>


# %% question="11.3"
def orient(points, normals, linked):
    """Return the normals (N, D), each as it is or turned round, for points (N, D), links (N, N)."""
    # BEGIN SOLUTION
    n = normals.copy()
    outside = np.ones(len(points), dtype=bool)
    least, origin = np.full(len(points), np.inf), np.zeros(len(points), dtype=int)
    while outside.any():
        i = np.argmin(np.where(outside, least, np.inf))
        if outside[i] and least[i] < np.inf:
            reference = n[origin[i]]
        else:
            i = np.argmax(np.where(outside, points[:, -1], -np.inf))
            reference = np.eye(points.shape[1])[-1]
        if n[i] @ reference < 0:
            n[i] = -n[i]
        outside[i] = False
        cost = -np.abs(n @ n[i])  # (11.4) less one, which changes no comparison
        nearer = (linked[i] > 0) & (cost < least)
        least[nearer], origin[nearer] = cost[nearer], i
    return n
    # END SOLUTION


# %%
check("11.3")


# %%
@draw(k=Slider(3, 20, 5, "neighbours K", whole=True))
def oriented(k):
    points = cloud(60)
    found, graph = np.asarray(normals(points, 5)[0]), np.asarray(linked(points, k))
    arrows = np.asarray(orient(points, found, graph))
    right_way = (arrows * outward(points)).sum(axis=1) > 0
    with figure(6.4, 3.0) as page:
        left, right = page.subplots(1, 2)
        draw_pieces(left, points[np.argwhere(np.triu(graph))], color=GREY, lw=0.7)
        draw_cloud(left, points)
        draw_normals(left, points, found)
        draw_cloud(right, points)
        draw_normals(right, points[right_way], arrows[right_way])
        draw_normals(right, points[~right_way], arrows[~right_way], color=ORANGE)
        left.set(title="the graph, and normals of any sign")
        wrong = int((~right_way).sum())
        right.set(title="all outward" if wrong == 0 else f"{wrong} inward")
    return page


# %% [markdown]
# **What to look at.** With more neighbours links jump across the body, and across the gap. There
# the normals are nearly parallel, so that these links are cheap, and they point in opposite
# directions: the sign is handed on, and wrong. With too few, parts get lost.
#
# ## Points beside the surface
#
# Now to the function. $F(\mathbf{p}_i) = 0$ at all points does not determine it: zero everywhere is
# a solution. So points beside the surface are added, along the normals, with the distance as their
# value, negative outside and positive inside:
#
# $$ F(\mathbf{p}_i + \delta\, \mathbf{n}_i) = -\delta , \qquad F(\mathbf{p}_i - \delta'\,
#    \mathbf{n}_i) = \delta' . \tag{11.5} $$
#
# How far? A point that is too far outside may be inside again, of another part of the body. There
# is a simple test, of Carr and others: the point of the cloud *nearest* to the added point must be
# its own, $\mathbf{p}_i$. If it is not, go half as far, and test again:
#
# $$ \delta = \Delta / 2^m \quad \text{with the least } m \ge 0 \text{ for which the test is
#    passed.} \tag{11.6} $$
#
# ### 11.4 How far
#
# Return the lengths $\delta$ and $\delta'$ for each point, each with a test of its own.


# %% question="11.4"
def off_surface(points, normals, distance):
    """Return δ outside and δ' inside by (11.6), of shape (N, 2), for points and normals (N, D)."""
    # BEGIN SOLUTION
    lengths = np.full((len(points), 2), float(distance))
    for i in range(len(points)):
        for s, n in enumerate([normals[i], -normals[i]]):
            offsets = points[i] - points
            while np.argmin(np.linalg.norm(offsets + lengths[i, s] * n, axis=1)) != i:
                lengths[i, s] /= 2
    return lengths
    # END SOLUTION


# %%
check("11.4")

# %% [markdown]
# `augmented(points, normals, lengths)` is written for you. It returns all sites and their values:
# the points with zero, then those outside, then those inside.
#
# ## Interpolation
#
# The function is a sum of cubes of distances, with a linear one,
#
# $$ F(\mathbf{x}) = \sum_{j=1}^{n} \lambda_j \lVert \mathbf{x} - \mathbf{s}_j \rVert^3 + c_0 +
#    \mathbf{c}^T \mathbf{x} . \tag{11.7} $$
#
# $\mathbf{s}_1, \dots, \mathbf{s}_n$ are the sites, $f_j$ their values. With $\mathbf{A}_{ij} =
# \lVert \mathbf{s}_i - \mathbf{s}_j \rVert^3$, and $\mathbf{P}$ with the rows $(1,
# \mathbf{s}_j^T)$, the coefficients solve
#
# $$ \begin{bmatrix} \mathbf{A} & \mathbf{P} \\ \mathbf{P}^T & \mathbf{0} \end{bmatrix}
#    \begin{bmatrix} \boldsymbol\lambda \\ \mathbf{c} \end{bmatrix} =
#    \begin{bmatrix} \mathbf{f} \\ \mathbf{0} \end{bmatrix} , \tag{11.8} $$
#
# where $\mathbf{c}$ has $c_0$ as its first entry. The second row makes the system solvable, and
# lets $F$ grow slowly far away.
#
# ### 11.5 The coefficients


# %% question="11.5"
def implicit(sites, values):
    """Return λ, (n,), and c = (c₀, …), (D + 1,), of (11.8) for sites (n, D), values (n,)."""
    # BEGIN SOLUTION
    n, d = sites.shape
    p = np.column_stack([np.ones(n), sites])
    a = np.linalg.norm(sites[:, np.newaxis] - sites, axis=2) ** 3
    matrix = np.block([[a, p], [p.T, np.zeros((d + 1, d + 1))]])
    solution = np.linalg.solve(matrix, np.append(values, np.zeros(d + 1)))
    return solution[:n], solution[n:]
    # END SOLUTION


# %%
check("11.5")

# %% [markdown]
# ### 11.6 The function and its gradient
#
# Return $F$ and its gradient at places $\mathbf{x}$. What is the derivative of $r^3$ with $r =
# \lVert \mathbf{x} - \mathbf{s} \rVert$? Write it without a division: a place may be a site.
#
# <details><summary>Hint</summary>
#
# By the chain rule $\nabla r^3 = 3 r^2\, \nabla r$, and $\nabla r = (\mathbf{x} - \mathbf{s}) / r$.
#
# </details>


# %% question="11.6"
def field(x, sites, lam, c):
    """Return F of (11.7), (M,), and its gradients, (M, D), at places x (M, D)."""
    # BEGIN SOLUTION
    offset = x[:, np.newaxis] - sites
    r = np.linalg.norm(offset, axis=2)
    values = r**3 @ lam + c[0] + x @ c[1:]
    gradients = 3 * np.einsum("mn,mnd->md", r * lam, offset) + c[1:]
    return values, gradients
    # END SOLUTION


# %%
check("11.6")


# %%
@draw(distance=Slider(0.02, 1.5, 0.9, "distance Δ", logarithmic=True))
def beside(distance):
    points = cloud(44)
    n = outward(points)
    with figure(6.6, 3.2) as page:
        panels = page.subplots(1, 2)
        tested = np.asarray(off_surface(points, n, distance))
        for axes, lengths in zip(panels, (np.full((44, 2), distance), tested)):
            sites, values = augmented(points, n, lengths)
            nodes = lattice(60)
            f = np.asarray(field(nodes.reshape(61 * 61, 2), sites, *implicit(sites, values))[0])
            f = f.reshape(61, 61)
            axes.contourf(*nodes.transpose(2, 0, 1), f, [-9, 0, 9], colors=["white", "#cfe0ee"])
            axes.plot(*sites[44:88].T, ".", ms=3, color=ORANGE)
            axes.plot(*sites[88:].T, ".", ms=3, color=BLUE)
            draw_cloud(axes, points, size=2.5)
            axes.set(xlim=(-1.9, 1.9), ylim=(-1.9, 1.9))
        panels[0].set(title=f"all at Δ = {distance:.2g}")
        panels[1].set(title="tested, and halved where needed")
    return page


# %% [markdown]
# **What to look at.** Blue shade: $F > 0$. Orange points are to be outside, blue ones inside. On
# the left they cross over, contradict each other, and tear the body. The test makes a large
# distance harmless. At the other end of the slider both are alike.
#
# ## Onto the surface
#
# The normal of a level of $F$ is its gradient. As $F$ falls towards the outside, the *outward*
# normal is $-\nabla F / \lVert \nabla F \rVert$: normals come for free now, and everywhere. And
# from a place near the surface one gets onto it by Newton's method along the gradient: replace $F$
# by its tangent, and go to where that is zero,
#
# $$ \mathbf{x} \;\leftarrow\; \mathbf{x} - \frac{F(\mathbf{x})}{\lVert \nabla F(\mathbf{x})
#    \rVert^2} \nabla F(\mathbf{x}) . \tag{11.9} $$
#
# ### 11.7 Newton's steps


# %% question="11.7"
def to_surface(x, sites, lam, c, steps):
    """Return the places after so many steps (11.9), of shape (M, D), from places x (M, D)."""
    # BEGIN SOLUTION
    for _ in range(steps):
        f, gradient = field(x, sites, lam, c)
        size = f / np.sum(gradient**2, axis=1)
        x = x - size[:, np.newaxis] * gradient
    return x
    # END SOLUTION


# %%
check("11.7")

# %% [markdown]
# ## Marching squares
#
# To draw the zero level, cut the plane into squares, and look at $F$ in their corners only. If it
# has one sign in all four corners the level passes by. Otherwise it crosses the sides whose ends
# have different signs; where, is told by linear interpolation. Between the ends $\mathbf{a}$ and
# $\mathbf{b}$ of a side, with the values $f_a$ and $f_b$,
#
# $$ \mathbf{x} = \mathbf{a} + \frac{f_a}{f_a - f_b} (\mathbf{b} - \mathbf{a}) . \tag{11.10} $$
#
# Let the corners be $(0,0)$, $(1,0)$, $(1,1)$, $(0,1)$, in this order, round the square: the rows
# of `SQUARE`, which is written for you. A piece of the level goes from one crossing to the other;
# let it run so that what is positive lies to its *left*. Then pieces of neighbouring squares follow
# each other, and the curve as a whole runs round the body.
#
# ### 11.8 A piece of the level
#
# Each row of `values` belongs to one square, in which exactly two sides are crossed. Return the
# start and the end of each piece.
#
# <details><summary>Hint</summary>
#
# Go round the square once. Where the sign changes from plus to minus, is it the start of the piece
# or its end? Draw a square in which only the first corner is positive.
#
# </details>


# %% question="11.8"
def pieces(values):
    """Return start and end of the piece in each square, (K, 2, 2), for values (K, 4)."""
    # BEGIN SOLUTION
    ends = np.zeros((len(values), 2, 2))
    for square, f in zip(ends, values):
        for i in range(4):
            j = (i + 1) % 4
            if (f[i] > 0) != (f[j] > 0):
                share = f[i] / (f[i] - f[j])
                square[int(f[j] > 0)] = SQUARE[i] + share * (SQUARE[j] - SQUARE[i])
    return ends
    # END SOLUTION


# %%
check("11.8")


# %% [markdown]
# The next cell cuts a grid of values into squares, and calls your function for those with two
# crossings. (There are squares with four. They have two pieces, and more than one way to draw
# them.)


# %%
def zero_level(nodes, f):
    """Return the pieces (K, 2, 2) of the zero level of values f (n + 1, n + 1) at nodes of a
    grid.
    """
    around = np.stack([f[:-1, :-1], f[:-1, 1:], f[1:, 1:], f[1:, :-1]], axis=-1)
    crossed = ((around > 0) != (np.roll(around, -1, axis=-1) > 0)).sum(axis=-1) == 2
    start = nodes[:-1, :-1][crossed][:, None]
    step = nodes[1, 1] - nodes[0, 0]
    return start + step * np.asarray(pieces(around[crossed])).reshape(-1, 2, 2)


@draw(squares=Slider(6, 60, 14, "squares", steps=27, whole=True))
def marching(squares):
    points, n, _ = data("11.4")
    sites, values = augmented(points, n, np.asarray(off_surface(points, n, 0.2)))
    lam, c = implicit(sites, values)
    nodes = lattice(squares, 1.8)
    f = np.asarray(field(nodes.reshape(-1, 2), sites, lam, c)[0]).reshape(nodes.shape[:2])
    level = zero_level(nodes, f)
    ends = level.reshape(-1, 2)
    moved = np.asarray(to_surface(ends, sites, lam, c, 3))
    value, slope = field(ends, sites, lam, c)
    off = np.abs(value) / np.linalg.norm(slope, axis=1)
    after = np.abs(field(moved, sites, lam, c)[0])
    with figure(6.6, 3.3) as page:
        panels = page.subplots(1, 2)
        for axes, p in zip(panels, (level, moved.reshape(-1, 2, 2))):
            side = nodes[0, :, 0]
            axes.hlines(side, -1.8, 1.8, color="0.9", lw=0.6)
            axes.vlines(side, -1.8, 1.8, color="0.9", lw=0.6)
            draw_pieces(axes, p, color=BLUE, lw=2)
            draw_cloud(axes, points, size=2.5)
        inside, outside = nodes[f > 0], nodes[f <= 0]
        panels[0].plot(*inside.T, "o", ms=2.2, color=ORANGE)
        panels[0].plot(*outside.T, "o", ms=0.8, color=GREY)
        panels[0].set(title=f"interpolated: off by up to {off.max():.1g}")
        panels[1].set(title=f"three steps of Newton: {after.max():.1g}")
    return page


# %% [markdown]
# **What to look at.** The points are your own. Few squares cut corners: the ends of the pieces are
# where a *linear* function would be zero. Newton's steps put them onto the level; between them the
# pieces are straight all the same.
#
# ## The whole road
#
# From a cloud with noise to the body, nothing else given: your normals, your graph, your signs,
# your points beside, your function, your level. The thin arrows are $-\nabla F$.


# %%
@draw(
    noise=Slider(0, 0.08, 0.015, "noise", steps=16),
    k=Slider(3, 16, 7, "neighbours K", whole=True),
    distance=Slider(0.02, 0.8, 0.15, "distance Δ", logarithmic=True),
)
def whole_road(noise, k, distance):
    points = cloud(70, noise)
    n = np.asarray(orient(points, np.asarray(normals(points, k)[0]), np.asarray(linked(points, k))))
    sites, values = augmented(points, n, np.asarray(off_surface(points, n, distance)))
    lam, c = implicit(sites, values)
    nodes = lattice(70)
    f = np.asarray(field(nodes.reshape(-1, 2), sites, lam, c)[0]).reshape(nodes.shape[:2])
    with figure(6.6, 3.0) as page:
        left, right = page.subplots(1, 2)
        draw_cloud(left, points, size=2.5)
        draw_normals(left, points, n, 0.15)
        left.set(title="normals with their signs")
        image = right.contourf(
            *nodes.transpose(2, 0, 1), f, np.linspace(-1, 1, 21), cmap="PuOr", extend="both"
        )
        image.set_rasterized(True)
        page.colorbar(image, ax=right, ticks=[-1, 0, 1], label="F", shrink=0.8)
        level = zero_level(nodes, f)
        draw_pieces(right, level, color="black", lw=1.6)
        some = level[::6, 0]
        slope = np.asarray(field(some, sites, lam, c)[1])
        draw_normals(right, some, -slope / np.linalg.norm(slope, axis=1)[:, None], 0.15, "black")
        right.set(title="F and its zero level", xlim=(-1.9, 1.9), ylim=(-1.9, 1.9), aspect="equal")
        right.set_axis_off()
        left.set(xlim=(-1.9, 1.9), ylim=(-1.9, 1.9))
    return page


# %% [markdown]
# **What to look at.** Make noise: the level still goes through every point, and becomes rough. Make
# $\Delta$ small as well: two values that differ by $2\Delta$, at places whose distance the noise
# has made up. What would you rather ask of $F$ than to interpolate?
#
# ## In space
#
# None of your functions asks for the dimension. A torus, by the same road; then cut into slices,
# each drawn by marching squares.


# %%
@draw(height=Slider(-0.4, 0.4, 0.2, "height", steps=32))
def slices(height):
    points = torus(np.random.default_rng(7), 8, 17) @ OBLIQUE.T
    n = np.asarray(orient(points, np.asarray(normals(points, 8)[0]), np.asarray(linked(points, 8))))
    sites, values = augmented(points, n, np.asarray(off_surface(points, n, 0.2)))
    lam, c = implicit(sites, values)
    nodes = lattice(28, 1.6)

    def paper(x):
        return np.stack([x[..., 0], 1.2 * x[..., 2] + 0.42 * x[..., 1]], axis=-1)

    def values_at(z):
        x = np.insert(nodes.reshape(-1, 2), 2, z, axis=1)
        return np.asarray(field(x, sites, lam, c)[0]).reshape(nodes.shape[:2])

    with figure(6.8, 2.5) as page:
        first, left, right = page.subplots(1, 3)
        draw_cloud(first, paper(points), size=1.5)
        draw_pieces(
            first, np.stack([paper(points), paper(points + 0.15 * n)], axis=1), color=BLUE, lw=0.8
        )
        first.set(title=f"{len(points)} points, and normals")
        for z in [*np.linspace(-0.36, 0.36, 7), height]:
            level = np.insert(zero_level(nodes, values_at(z)), 2, z, axis=2)
            chosen = z == height
            draw_pieces(
                left, paper(level), color=ORANGE if chosen else BLUE, lw=2.2 if chosen else 1
            )
        left.set(aspect="equal", title="slices of the level")
        left.set_axis_off()
        f = values_at(height)
        bands = right.contourf(
            *nodes.transpose(2, 0, 1), f, np.linspace(-0.8, 0.8, 17), cmap="PuOr", extend="both"
        )
        bands.set_rasterized(True)
        draw_pieces(right, zero_level(nodes, f), color=ORANGE, lw=2.2)
        right.set(aspect="equal", title=f"F at the height {height:.2g}")
        right.set_axis_off()
    return page


# %% [markdown]
# **What to look at.** Move the height: the two circles of a slice come together and vanish at the
# top. Look back at your eight functions: where would the third dimension have made a difference?

# %% [markdown]
# ## In words
#
# **11.9** Leave out the points beside the surface. What is the solution of (11.8) then, and why?
# Why two of them for each point, and not one inside only? And what goes wrong if $\Delta$ is too
# large without the test, and what if it is very small?
#
# <details><summary>Hint</summary>
#
# The right side of (11.8) is zero then. For the last part think of the rows of the matrix, and of
# the noise.
#
# </details>

# %% [markdown] answer="11.9" points=3
# All values are zero, and the system is regular if the points lie on no line (plane): its only
# solution is zero, $F = 0$ everywhere, with no level and no sides. Values off the surface are what
# makes $F$ change its sign. One side alone would do formally; two force $F$ to go through zero with
# a slope of about $-1$ along the normal, so that it is near the signed distance, neither flat nor
# steep, and the level is well determined from both sides.
#
# Too far: the point lies on the wrong side of another part of the body, with the wrong sign, and
# the level is torn; or its value is no distance any more, since another part is nearer. Very near:
# two sites nearly coincide, two rows of the matrix are nearly equal and its condition is bad; and
# where the points are off by noise, differences of noise are divided by a small $\Delta$, so that
# the level gets rough.

# %% [markdown] rubric="11.9"
# One point for F = 0 with the reason. One for two sides: change of sign and slope. One for both
# ends of the range of distances; one of these alone earns half.

# %% [markdown]
# **11.10** In a textbook one reads that normals $b_i \mathbf{n}_i$ with signs $b_i = \pm 1$ are
# oriented if $\sum b_i b_j (1 - |\mathbf{n}_i^T\mathbf{n}_j|)$, over all links, is as small as
# possible. Show with a sphere whose normals are right to begin with that this cannot be. Why
# can *no* choice of weights that do not depend on the signs do? What should be made large instead,
# and what is (11.4) good for?
#
# <details><summary>Hint</summary>
#
# With right normals all $b_i = 1$ should be best. And what changes in the sum if you turn one of
# the given normals round before you begin?
#
# </details>

# %% [markdown] answer="11.10" points=3
# The weights are not negative. With right normals $b = (1, \dots, 1)$ should be the answer; but it
# makes every term as large as it can be, and the sum is the *greatest* possible, not the least. The
# least puts opposite signs where the normals differ most.
#
# Nor can a change of signs help: turn one given normal, and the weights stay as they are, so the
# best $b$ stays the same too, while the right answer has another sign at that point. A sum that
# cannot see the given signs cannot correct them.
#
# Large should be $\sum b_i b_j\, \mathbf{n}_i^T \mathbf{n}_j$, where neighbours agree if the term
# is positive. To maximise it exactly is hard. The tree is a good guess: along its links every term
# is made positive, and (11.4) says which links to use, those where the normals are nearly parallel
# and the decision is safe.

# %% [markdown] rubric="11.10"
# One point for the right normals giving the maximum. One for the invariance: weights without signs
# cannot see which normals are turned. One for the right sum, with signs of the scalar products, and
# (11.4) as the weight of the tree.

# %% [markdown]
# **11.11** A sheet of metal has been scanned from both sides. Its thickness is less than the
# distance of the points. Go through the stations: what goes wrong at each of them? What could be
# measured in addition that would help?
#
# <details><summary>Hint</summary>
#
# Who are the nearest neighbours of a point?
#
# </details>

# %% [markdown] answer="11.11" points=3
# Normals: the neighbours come from both sides, and the plane through them is a compromise; its
# normal may still be good where the sheet is flat, at its rim it is not, and the planarity is low.
# Graph: links go through the sheet. Orientation: the normals of both sides are parallel, so these
# links are the cheapest of all, and the same sign is given to both sides, one of which then points
# inward. Points beside: those inside have their nearest neighbour on the other side until they are
# within half of the thickness, so they are very near to the surface and the system is badly
# conditioned; with wrong signs they contradict each other.
#
# The direction from which each point was seen, which scanners know, decides about the sign at once:
# the normal points to the scanner. Or more points: spacing below the thickness. Normals measured
# otherwise serve as well.

# %% [markdown] rubric="11.11"
# One point for neighbours from both sides in normals or graph. One for the orientation: cheap links
# with the wrong sign. One for a remedy: direction to the scanner, or denser points.

# %% [markdown]
# ## Dig deeper
#
# - There is a way without points beside the surface. Ask for $F(\mathbf{p}_i) = 0$ and
#   $\mathbf{n}_i^T \nabla F(\mathbf{p}_i) = -1$. What replaces the cubes? How many unknowns are
#   there?
# - Add a number $\mu > 0$ to the diagonal of $\mathbf{A}$ in (11.8), with the sign that makes the
#   level smoother. Try it on noise.
# - Two bodies $F$ and $G$: what are the zero levels of $\max(F, G)$, $\min(F, G)$, $\min(F, -G)$
#   and $(1 - t) F + t G$?
# - Squares with four crossings: draw both ways. What does the sign of $F$ in the middle of the
#   square tell? In space there are cubes instead, and 256 kinds of corners. How many of them differ
#   by more than a turn?
# - How does the time for (11.8) grow with the number of points? At which number is your computer
#   full? What could be done if each point sees its surroundings only?

# %%
progress()
