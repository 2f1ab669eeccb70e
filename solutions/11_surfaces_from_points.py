# ---
# jupyter:
#   course:
#     builds_on:
#       "03": the saddle-point system, and the gradient of a radial basis function
#     pages: book, section 1.1
#     chapters: [38-surfaces]
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
# A scanner measures points on the surface of a body. It measures neither triangles nor normals, and
# it does not say which side is inside. In this notebook you construct a function $F$ whose zero
# level passes through the points. $F$ is positive inside the body and negative outside. This is
# *surface reconstruction by an implicit function*.
#
# The method has four steps: estimate normals, orient them, add points beside the surface, and
# interpolate with radial basis functions. Your functions work in the plane, where
# pictures are clear, and in space without a change. At the end you reconstruct an asteroid from
# points measured by radar.
#
# **Sources.** Wendland, *Scattered Data Approximation* (2005), pages 2–4; Hoppe and others (1992)
# and Carr and others (2001) below. Search for: principal component analysis, covariance matrix,
# minimum spanning tree, Prim's algorithm, signed distance, implicit surface, marching squares.
# Notebook 14 finds the errors in triangulated surfaces of such bodies. Numbers in brackets, such
# as (11.1), belong to formulas; numbers without brackets belong to questions.
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
from fieldcheck.datasets import kleopatra
from fieldcheck.given import distances, saddle_point_matrix

SQUARE = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])


def augmented(points, normals, lengths):
    """Return sites (3N, D) and values (3N,): the points, those outside, those inside.

    Column 0 of the lengths (N, 2) holds the distance outside of each point, column 1 the one
    inside.
    """
    outer, inner = lengths[:, :1], lengths[:, 1:]
    sites = np.concatenate([points, points + outer * normals, points - inner * normals])
    return sites, np.concatenate([0 * outer, -outer, inner]).ravel()


# %% [markdown]
# The next cell makes point clouds and draws them. Run it; you need not read it.

# %%
from fieldcheck.questions.q11_point_clouds import horseshoe, outward


def cloud(n, noise=0.0, seed=5):
    """Return n points of a horseshoe with normally distributed errors."""
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
    """Draw line segments with the ends (K, 2, 2)."""
    if len(ends):
        gaps = np.insert(np.asarray(ends, dtype=float), 2, np.nan, axis=1)
        axes.plot(*gaps.reshape(-1, 2).T, zorder=2, **style)


def lattice(n, size=1.9):
    """Return the nodes of a grid of n × n squares about the origin, of shape (n + 1, n + 1, 2)."""
    side = np.linspace(-size, size, n + 1)
    return np.stack(np.meshgrid(side, side), axis=-1)


# %% [markdown]
# ## Point clouds with and without noise
#
# The points lie on a closed curve. Reduce their number: with how few points do you still recognize
# the curve?


# %%
@draw(points=Slider(12, 120, 44, "points", steps=54, whole=True))
def problem(points):
    with figure(6.4, 2.9) as page:
        left, right = page.subplots(1, 2)
        draw_cloud(left, cloud(points))
        draw_cloud(right, cloud(points, 0.03))
        left.set(title="exact points")
        right.set(title="measured points, with noise")
    return page


# %% [markdown]
# ## Normals by principal component analysis
#
# Near a point, a smooth curve looks like a straight line and a smooth surface like a plane. So we
# fit a line or plane to the neighbours of each point. No two points of a cloud are equal, and no
# two neighbours are equally far from a point. Let $N(i)$ be the $K$ points nearest to
# $\mathbf{p}_i$, including $\mathbf{p}_i$ itself. Their mean and their *covariance matrix* are
#
# $$ \mathbf{m}_i = \frac1K \sum_{j \in N(i)} \mathbf{p}_j , \qquad
#    \mathbf{C}_i = \frac1K \sum_{j \in N(i)} (\mathbf{p}_j - \mathbf{m}_i)(\mathbf{p}_j -
#    \mathbf{m}_i)^T . \tag{11.1} $$
#
# The eigenvalues $\lambda_1 \ge \dots \ge \lambda_D \ge 0$ of $\mathbf{C}_i$ are the variances of
# the neighbours along its eigenvectors. The variance is smallest across the fitted line or plane.
# Therefore the normal $\mathbf{n}_i$ is the unit eigenvector for $\lambda_D$, with either sign.
# This is *principal component analysis* (PCA). The *planarity*
#
# $$ q_i = 1 - \lambda_D / \lambda_{D-1} \tag{11.2} $$
#
# is 1 if the neighbours lie exactly on the fitted line or plane. It is 0 if the two smallest
# variances are equal: then the normal is not determined.
#
# **Example.** Three neighbours in the plane are $(-2, 1)$, $(1, -2)$ and $(4, 1)$. Their mean is
# $(1, 0)$, and the offsets from the mean are $(-3, 1)$, $(0, -2)$ and $(3, 1)$. Hence
#
# $$ \mathbf{C} = \frac13 \begin{bmatrix} 9 + 0 + 9 & -3 + 0 + 3 \\ -3 + 0 + 3 & 1 + 4 + 1
#    \end{bmatrix} = \begin{bmatrix} 6 & 0 \\ 0 & 2 \end{bmatrix} . $$
#
# The smaller eigenvalue is 2, with the eigenvector $\mathbf{n} = (0, 1)$. The planarity is
# $1 - 2/6 = 2/3$. The next cell computes the same numbers.

# %%
example = np.array([[-2.0, 1.0], [1.0, -2.0], [4.0, 1.0]])
covariance = np.cov(example.T, bias=True)  # bias: divided by K, not by K − 1
print(covariance)
print(*np.linalg.eigh(covariance), sep="\n")

# %% [markdown]
# The next function is finished. It shows the form that the functions of this notebook can have: a
# docstring with the shapes, an empty array, and a loop over the points.


# %%
def spacing(points):
    """Return the distance of each point to its nearest neighbour, (N,), for points (N, D)."""
    gaps = np.zeros(len(points))
    for i, p in enumerate(points):
        others = np.delete(points, i, axis=0)
        gaps[i] = np.linalg.norm(others - p, axis=1).min()
    return gaps


print(spacing(example))

# %% [markdown]
# ### 11.1 Normals and planarity
#
# Return the normals and the planarity of all points. The points are such that all eigenvalues but
# the smallest are positive. The unit of length may be any, and the cloud may be far from the
# origin, up to $10^8$ times its size.
#
# <details><summary>Hint</summary>
#
# Go point by point, as `spacing` does. `np.argsort` of the distances gives the nearest points
# first. `np.linalg.eigh` returns the eigenvalues in increasing order, and the eigenvectors as
# *columns*.
#
# </details>


# %% question="11.1" minutes=25
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
        left.set(title="blue: planarity above 0.75")
        right.plot(planarity, angle, "o", ms=3.5, color=PURPLE)
        right.set(xlabel="planarity", ylabel="error of the normal in degrees", xlim=(-0.03, 1.03))
        right.set(ylim=(-3, 93), title=f"mean error {angle.mean():.1f}°")
    return page


# %% [markdown]
# **What to look at.** With few neighbours the normals follow the noise. With many neighbours the
# fitted line cuts across bends. The best $K$ lies between, and it grows with the noise. A small
# planarity is a warning. A large planarity is no guarantee: where the curve begins to bend, the
# neighbours can lie close to a line that is not the tangent (dots high up on the right).
#
# ## The neighbourhood graph
#
# PCA leaves the sign of each normal open. Neighbouring normals should agree in sign, so a sign can
# be passed from neighbour to neighbour. The relation "$j$ is among the $K$ nearest points of $i$"
# is not symmetric: an isolated point is not among the neighbours of its own neighbours. Therefore
# two points are *linked* if at least one of them is among the nearest points of the other:
#
# $$ g_{ij} = 1 \iff i \neq j \text{ and } \big( j \in N(i) \text{ or } i \in N(j) \big). \tag{11.3}
#    $$
#
# ### 11.2 Neighbourhood graph
#
# Return $g$. There are at least $K$ points, and no two neighbours are equally far from a point. The
# unit of length may be any, and the cloud may be far from the origin, as in 11.1.


# %% question="11.2" minutes=15
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
# ## Orientation along a minimum spanning tree
#
# A link is safe for passing a sign if its two normals are nearly parallel. If they are
# perpendicular, the sign is a guess. So each link costs
#
# $$ w_{ij} = 1 - | \mathbf{n}_i^T \mathbf{n}_j | , \tag{11.4} $$
#
# which does not depend on the signs. We choose the links that connect all points at the smallest
# total cost: the *minimum spanning tree*. A sign is passed along a link of the tree as follows: if
# $\mathbf{n}_i^T \mathbf{n}_j < 0$, where $\mathbf{n}_i$ is already oriented, then $\mathbf{n}_j$
# is inverted, otherwise it is kept. Hoppe and others published the method (*Surface reconstruction
# from unorganized points*, SIGGRAPH 1992).
#
# **Prim's algorithm** grows the tree from one point. In each step it takes the cheapest of all
# links from a point in the tree to a point outside the tree. The first point is the *highest* one,
# with the largest last coordinate: there the outward normal points upward, so its last component
# is positive. If no link leads out of the tree, the graph has several components. Then the highest
# of the remaining points begins the next tree in the same way.
#
# **Example.** Five points of a circle of radius 2, with outward normals $\mathbf{p}/2$, except that
# the normals of the points 1 and 3 are inverted:
#
# | point | $\mathbf{p}$ | given normal | outward? |
# |---|---|---|---|
# | 0 | $(0, 2)$ | $(0, 1)$ | yes |
# | 1 | $(1.2, 1.6)$ | $(-0.6, -0.8)$ | no |
# | 2 | $(2, 0)$ | $(1, 0)$ | yes |
# | 3 | $(1.6, -1.2)$ | $(-0.8, 0.6)$ | no |
# | 4 | $(0, -2)$ | $(0, -1)$ | yes |
#
# The links and their costs (11.4) are 0–1: 0.2, 1–2: 0.4, 2–3: 0.2, 3–4: 0.4, and three longer
# links 0–2, 1–3 and 2–4: each 1. Prim's algorithm begins at point 0, the highest point.
#
# | step | links out of the tree | cheapest | product with the oriented normal | result |
# |---|---|---|---|---|
# | 1 | 0–1: 0.2, 0–2: 1 | 0–1 | $-0.8$ | invert 1 |
# | 2 | 1–2: 0.4, 0–2: 1, 1–3: 1 | 1–2 | $0.6$ | keep 2 |
# | 3 | 2–3: 0.2, 1–3: 1, 2–4: 1 | 2–3 | $-0.8$ | invert 3 |
# | 4 | 3–4: 0.4, 2–4: 1 | 3–4 | $0.6$ | keep 4 |
#
# In step 2 the product uses $\mathbf{n}_1 = (0.6, 0.8)$, which has just been inverted. At the end
# all normals are outward. The next cell computes the costs and draws the tree.

# %% tags=["setup"]
FIVE = np.array([[0, 2], [1.2, 1.6], [2, 0], [1.6, -1.2], [0, -2]])
FIVE_GIVEN = FIVE / 2 * np.array([[1], [-1], [1], [-1], [1]])
FIVE_LINKS = np.array(
    [[0, 1, 1, 0, 0], [1, 0, 1, 1, 0], [1, 1, 0, 1, 1], [0, 1, 1, 0, 1], [0, 0, 1, 1, 0]]
)

# %%
print(np.round(np.where(FIVE_LINKS > 0, 1 - np.abs(FIVE_GIVEN @ FIVE_GIVEN.T), np.nan), 2))


@draw()
def spanning_tree():
    with figure(6.4, 2.9) as page:
        panels = page.subplots(1, 2)
        links = np.argwhere(np.triu(FIVE_LINKS))
        tree = np.array([[0, 1], [1, 2], [2, 3], [3, 4]])
        for axes, n, title in zip(panels, (FIVE_GIVEN, FIVE / 2), ("given", "oriented")):
            draw_pieces(axes, FIVE[links], color=GREY, lw=0.8, ls=":")
            draw_pieces(axes, FIVE[tree], color=ORANGE, lw=1.8)
            draw_cloud(axes, FIVE, size=5)
            for i, (p, m) in enumerate(zip(FIVE, n)):
                axes.annotate("", p + 0.7 * m, p, arrowprops={"arrowstyle": "-|>", "color": BLUE})
                beside_arrow = p + 0.15 * p + 0.18 * np.array([-p[1], p[0]])
                axes.text(*beside_arrow, str(i), ha="center", va="center")
            axes.set(xlim=(-0.6, 3.2), ylim=(-2.9, 2.9), title=f"{title} normals, and the tree")
    return page


# %% [markdown]
# ### 11.3 Orientation
#
# Unit normals are given, and the links as an array of ones and zeros. Return the oriented normals.
# Each component of the graph has a single highest point, where the last coordinate of the normal is
# not zero. Where several links are equally cheap, all lead to the same normals.
#
# <details><summary>Hint 1</summary>
#
# Keep for each point outside the tree the smallest cost of a link to the tree, and the point of the
# tree where that link begins. All costs are infinite at first. When a point joins the tree, update
# both for the points linked to it, but only where the new link is *cheaper*.
#
# </details>
# <details><summary>Hint 2</summary>
#
# `np.where(outside, cost, np.inf)` hides the points that have joined. If the smallest remaining
# cost is infinite, a new component begins. Test your function first: `orient(FIVE, FIVE_GIVEN,
# FIVE_LINKS)` must return `FIVE / 2`.
#
# </details>


# %% question="11.3" minutes=40
def orient(points, normals, linked):
    """Return the normals (N, D), each kept or inverted, for points (N, D) and links (N, N)."""
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
        left.set(title="graph, and normals of either sign")
        wrong = int((~right_way).sum())
        right.set(title="all outward" if wrong == 0 else f"{wrong} inward")
    return page


# %% [markdown]
# **What to look at.** With more neighbours, links jump across the body and across the gap. There
# the normals are nearly parallel, so these links are cheap. But the outward directions are
# opposite, so the sign that is passed on is wrong.
#
# ## Off-surface points
#
# The conditions $F(\mathbf{p}_i) = 0$ do not determine $F$, since $F = 0$ everywhere satisfies
# them. Therefore we add *off-surface points* along the normals. Their values are signed distances,
# negative outside and positive inside:
#
# $$ F(\mathbf{p}_i + \delta\, \mathbf{n}_i) = -\delta , \qquad F(\mathbf{p}_i - \delta'\,
#    \mathbf{n}_i) = \delta' . \tag{11.5} $$
#
# How large may $\delta$ be? An off-surface point that is too far outside may lie inside another
# part of the body. Carr and others (*Reconstruction and representation of 3D objects with radial
# basis functions*, SIGGRAPH 2001, pages 67–76) use a simple test: among all points of the cloud,
# $\mathbf{p}_i$ must be the *nearest* to its own off-surface point. If it is not, halve the
# distance and test again. With the first distance $\Delta$ (`distance`) this gives
#
# $$ \delta = \Delta / 2^m \quad \text{with the smallest } m \ge 0 \text{ for which the test is
#    passed.} \tag{11.6} $$
#
# ### 11.4 Distances of the off-surface points
#
# Return $\delta$ and $\delta'$ for each point. Each side has its own test. The normals have the
# length 1, and the unit of length may be any. The distance is positive. The cloud has two points or
# more, of which no two are equal, and no tested point has two nearest points. It may be far from
# the origin, up to $10^8$ times as far as its points are from each other.


# %% question="11.4" minutes=20
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
# The function `augmented(points, normals, lengths)` at the top of the notebook is written for you.
# It returns all sites and their values: first the points with the value zero, then the points
# outside, then the points inside.
#
# ## Interpolation by radial basis functions
#
# $F$ is a sum of cubed distances and a linear polynomial,
#
# $$ F(\mathbf{x}) = \sum_{j=1}^{n} \lambda_j \lVert \mathbf{x} - \mathbf{s}_j \rVert^3 + c_0 +
#    \mathbf{c}^T \mathbf{x} , \tag{11.7} $$
#
# with sites $\mathbf{s}_1, \dots, \mathbf{s}_n$ and values $f_1, \dots, f_n$. Let $\mathbf{A}_{ij}
# = \lVert \mathbf{s}_i - \mathbf{s}_j \rVert^3$, and let $\mathbf{P}$ have the rows $(1,
# \mathbf{s}_j^T)$. The coefficients solve the *saddle-point system*
#
# $$ \begin{bmatrix} \mathbf{A} & \mathbf{P} \\ \mathbf{P}^T & \mathbf{0} \end{bmatrix}
#    \begin{bmatrix} \boldsymbol\lambda \\ \mathbf{c} \end{bmatrix} =
#    \begin{bmatrix} \mathbf{f} \\ \mathbf{0} \end{bmatrix} , \tag{11.8} $$
#
# where $\mathbf{c}$ is $c_0$ followed by the $\mathbf{c}$ of (11.7). The kernel $r^3$ is
# *conditionally positive definite*: with the side conditions $\mathbf{P}^T\boldsymbol\lambda =
# \mathbf{0}$ the system has a unique solution, provided the sites do not all lie in one plane (in
# the plane: on one line). It is the same kind of system as in notebook 03.
#
# ### 11.5 The coefficients
#
# Two functions that notebook 03 explains are ready-made: `distances(x, points)` returns all
# distances, of shape $(M, N)$, and `saddle_point_matrix(A, P)` the matrix of (11.8). State
# $\mathbf{A}$ and $\mathbf{P}$ for sites in the plane or in space, solve (11.8), and separate
# $\boldsymbol\lambda$ from $\mathbf{c}$. The distances between sites are at least 0.01.


# %% question="11.5" minutes=15
def implicit(sites, values):
    """Return λ, (n,), and c = (c₀, …), (D + 1,), of (11.8) for sites (n, D), values (n,)."""
    # BEGIN SOLUTION
    n, d = sites.shape
    p = np.column_stack([np.ones(n), sites])
    matrix = saddle_point_matrix(distances(sites, sites) ** 3, p)
    solution = np.linalg.solve(matrix, np.append(values, np.zeros(d + 1)))
    return solution[:n], solution[n:]
    # END SOLUTION


# %%
check("11.5")

# %% [markdown]
# ### 11.6 The function and its gradient
#
# Return $F$ and its gradient at the points $\mathbf{x}$. Points and sites may be far from the
# origin, up to $10^9$ times as far as from each other. What is the gradient of $r^3$ with
# $r = \lVert \mathbf{x} - \mathbf{s} \rVert$? Avoid division by $r$, since $\mathbf{x}$ may be a
# site.
#
# Test your gradient by differences before you run the check: $\partial F / \partial x_1$ at
# $\mathbf{x}$ should agree with $\big(F(\mathbf{x} + h \mathbf{e}_1) - F(\mathbf{x} - h
# \mathbf{e}_1)\big) / (2h)$ for $h = 10^{-5}$, to about nine digits near the origin.
#
# <details><summary>Hint</summary>
#
# By the chain rule $\nabla r^3 = 3 r^2\, \nabla r$, and $\nabla r = (\mathbf{x} - \mathbf{s}) / r$.
#
# </details>


# %% question="11.6" minutes=15
def field(x, sites, lam, c):
    """Return F of (11.7), (M,), and its gradients, (M, D), at points x (M, D)."""
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
        panels[0].set(title=f"all at Δ = {distance:.2g}, not tested")
        panels[1].set(title="tested, and halved if needed")
    return page


# %% [markdown]
# **What to look at.** The shaded region is $F > 0$. Orange points should lie outside, blue points
# inside. In the left picture they lie on the wrong sides of other parts of the body, their values
# contradict each other, and the body breaks into pieces. The test of (11.6) makes a large $\Delta$
# harmless. At the left end of the slider both pictures agree.
#
# ## Projection onto the surface
#
# The gradient is normal to the level sets of $F$. Since $F$ decreases outward, the *outward*
# normal is $-\nabla F / \lVert \nabla F \rVert$, at every point where $\nabla F \neq \mathbf{0}$.
# A point near the surface is projected onto it by Newton's method along the gradient. Each step
# replaces $F$ by its tangent and moves to the zero of the tangent:
#
# $$ \mathbf{x} \;\leftarrow\; \mathbf{x} - \frac{F(\mathbf{x})}{\lVert \nabla F(\mathbf{x})
#    \rVert^2} \nabla F(\mathbf{x}) . \tag{11.9} $$
#
# ### 11.7 Newton's method
#
# Return the points after the given number of steps (11.9); for 0 steps, the given points. The
# values of $F$ and its gradients may be as small as $10^{-30}$.


# %% question="11.7" minutes=15 optional
def to_surface(x, sites, lam, c, steps):
    """Return the points (M, D) after the given number of steps (11.9), from points x (M, D)."""
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
# To draw the zero level, divide the plane into squares and evaluate $F$ at their corners. If all
# four values have the same sign, no piece is drawn in the square. Otherwise the level crosses the
# sides whose ends have different signs. The crossing point is found by linear interpolation: on
# the side from $\mathbf{a}$ to $\mathbf{b}$, with the values $f_a$ and $f_b$,
#
# $$ \mathbf{x} = \mathbf{a} + \frac{f_a}{f_a - f_b} (\mathbf{b} - \mathbf{a}) . \tag{11.10} $$
#
# The corners are $(0,0)$, $(1,0)$, $(1,1)$, $(0,1)$, in this order round the square. They are the
# rows of `SQUARE`, which is defined above. A piece of the level runs from one crossing to the
# other, with the positive values on its *left*. Then the pieces of neighbouring squares follow
# each other, and the whole curve runs counter-clockwise round the body. In space the method is
# called *marching cubes* (Lorensen and Cline, SIGGRAPH 1987).
#
# **Example.** The values are $3, -1, -2, -2$. The side from $(0,0)$ to $(1,0)$ is crossed at
# $(3/4, 0)$, since $3 / (3 - (-1)) = 3/4$. The side from $(0,1)$ to $(0,0)$, with the values $-2$
# and 3, is crossed at the share $-2 / (-2 - 3) = 2/5$ from $(0,1)$, hence at $(0, 3/5)$. The
# positive corner $(0,0)$ must be on the left, so the piece runs from $(3/4, 0)$ to $(0, 3/5)$.
#
# ### 11.8 Pieces of the zero level
#
# Each row of `values` belongs to one square. Exactly two sides of it are crossed. No value is zero,
# but values may be tiny, such as the $-10^{-300}$ in the cell after the check. Return the start and
# the end of each piece.
#
# <details><summary>Hint</summary>
#
# Go round the square once. In the example, where does the sign change from plus to minus: at the
# start of the piece, or at its end?
#
# </details>


# %% question="11.8" minutes=25 optional
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
# The next cell divides a grid of values into squares, and calls your function for the squares with
# two crossings. (A square with four crossings has two pieces, and there is more than one way to
# draw them.) A value of exactly zero counts as negative.


# %%
def zero_level(nodes, f):
    """Return the pieces (K, 2, 2) of the zero level of values f (n + 1, n + 1) at grid nodes."""
    f = np.where(f == 0, -1e-300, f)
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
    projected = np.asarray(to_surface(ends, sites, lam, c, 3))
    value, slope = field(ends, sites, lam, c)
    off = np.abs(value) / np.linalg.norm(slope, axis=1)
    after = np.abs(field(projected, sites, lam, c)[0])
    with figure(6.6, 3.3) as page:
        panels = page.subplots(1, 2)
        for axes, p in zip(panels, (level, projected.reshape(-1, 2, 2))):
            side = nodes[0, :, 0]
            axes.hlines(side, -1.8, 1.8, color="0.9", lw=0.6)
            axes.vlines(side, -1.8, 1.8, color="0.9", lw=0.6)
            draw_pieces(axes, p, color=BLUE, lw=2)
            draw_cloud(axes, points, size=2.5)
        inside, outside = nodes[f > 0], nodes[f <= 0]
        panels[0].plot(*inside.T, "o", ms=2.2, color=ORANGE)
        panels[0].plot(*outside.T, "o", ms=0.8, color=GREY)
        panels[0].set(title=f"linear interpolation: error up to {off.max():.1g}")
        panels[1].set(title=f"three Newton steps: $|F|$ up to {after.max():.1g}")
    return page


# %% [markdown]
# **What to look at.** The points are your own; they depend on the number in `student.txt`. Orange
# nodes have $F > 0$. With few squares the ends of the pieces are off the level, since $F$ is not
# linear along a side. Newton's method moves the ends onto the level. Between its ends a piece
# remains straight.
#
# ## The complete method in the plane
#
# From a noisy cloud to the body, by your functions. The thin arrows are $-\nabla F$.


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
        left.set(title="oriented normals")
        image = right.contourf(
            *nodes.transpose(2, 0, 1), f, np.linspace(-1, 1, 21), cmap="PuOr", extend="both"
        )
        image.set_rasterized(True)
        page.colorbar(image, ax=right, ticks=[-1, 0, 1], label="F", shrink=0.8)
        level = right.contour(*nodes.transpose(2, 0, 1), f, [0.0], colors="black", linewidths=1.6)
        starts = np.vstack(level.allsegs[0])[::6]
        slope = np.asarray(field(starts, sites, lam, c)[1])
        draw_normals(right, starts, -slope / np.linalg.norm(slope, axis=1)[:, None], 0.15, "black")
        right.set(title="F and its zero level", xlim=(-1.9, 1.9), ylim=(-1.9, 1.9), aspect="equal")
        right.set_axis_off()
        left.set(xlim=(-1.9, 1.9), ylim=(-1.9, 1.9))
    return page


# %% [markdown]
# **What to look at.** Increase the noise: the level still passes through every point and becomes
# rough. Now decrease $\Delta$ as well. The values at neighbouring sites differ by $\Delta$, while
# the noise has changed the distances between them. Which condition would suit noisy points better
# than interpolation?
#
# ## A measured surface: the asteroid Kleopatra
#
# Asteroid 216 Kleopatra is about 217 km long and has the shape of a dog bone. Its shape was
# measured with the radar of the Arecibo Observatory: S. J. Ostro and others, *Science* 288 (2000),
# pages 836–839. The data are from NASA's Planetary Data System, and are in the public domain;
# `fieldcheck/datasets/kleopatra.json` names the source. `kleopatra()` returns 600 points in
# kilometres, and triangles, which we do not need here. Your functions do the rest, in three
# dimensions. The picture takes a few seconds.


# %%
@draw(height=Slider(-30, 30, 0, "height z in km", steps=30))
def asteroid(height):
    points = kleopatra()[0][::2]
    n = np.asarray(orient(points, np.asarray(normals(points, 8)[0]), np.asarray(linked(points, 8))))
    sites, values = augmented(points, n, np.asarray(off_surface(points, n, 5.0)))
    lam, c = implicit(sites, values)
    nodes = lattice(40, 120.0)[6:-6]

    def values_at(z):
        x = np.insert(nodes.reshape(-1, 2), 2, z, axis=1)
        return np.asarray(field(x, sites, lam, c)[0]).reshape(nodes.shape[:2])

    with figure(6.8, 4.6) as page:
        (first, second), (left, right) = page.subplots(2, 2)
        tips = points + 7 * n
        for axes, pair, name in ((first, (0, 1), "from above"), (second, (0, 2), "from the side")):
            draw_pieces(axes, np.stack([points, tips], axis=1)[:, :, pair], color=BLUE, lw=0.8)
            draw_cloud(axes, points[:, pair], size=1.8)
            axes.set(title=f"{len(points)} points and normals, {name}")
        second.axhline(height, color=ORANGE, lw=1)
        for z in [*np.linspace(-36, 32, 7), height]:
            chosen = z == height
            style = (
                {"colors": ORANGE, "linewidths": 2.2}
                if chosen
                else {"colors": BLUE, "linewidths": 1}
            )
            left.contour(*nodes.transpose(2, 0, 1), values_at(z), [0.0], **style)
        left.set(title="contour lines of the zero level", aspect="equal")
        left.set_axis_off()
        f = values_at(height)
        bands = right.contourf(
            *nodes.transpose(2, 0, 1), f, np.linspace(-40, 40, 17), cmap="PuOr", extend="both"
        )
        bands.set_rasterized(True)
        right.contour(*nodes.transpose(2, 0, 1), f, [0.0], colors=ORANGE, linewidths=2.2)
        right.set(aspect="equal", title=f"$F$ at the height {height:.0f} km")
        right.set_axis_off()
        page.colorbar(bands, ax=right, ticks=[-40, 0, 40], label="$F$ in km", shrink=0.8)
    return page


# %% [markdown]
# **What to look at.** Move the height. The two lobes separate where the neck ends. $F$ is close to
# the signed distance near the surface, since the off-surface values are distances. Which lines of
# your functions would be different in the plane?

# %% [markdown]
# ## Questions in words
#
# **11.9** Why does the method need off-surface points on both sides of the surface, at a distance
# $\Delta$ that is neither very large nor very small?
#
# <details><summary>Hint</summary>
#
# Without off-surface points the right-hand side of (11.8) is zero. For a very small $\Delta$
# compare two rows of the matrix, and think of noise.
#
# </details>

# %% [markdown] answer="11.9" points=3 minutes=15 words=80
# Without them all values are zero and the system is regular, so $F = 0$ everywhere. Values on both
# sides make $F$ change its sign at the surface, with a slope of about $-1$ along the normal.
#
# A large $\Delta$ puts off-surface points into other parts of the body, where their values have the
# wrong sign. A small $\Delta$ makes two rows of the matrix nearly equal, and divides errors of the
# points by $\Delta$.
#
# *Beyond the question.* The system is regular if the points do not all lie on one line (in space:
# in one plane). With the slope $-1$, $F$ is close to the signed distance, and the level is well
# determined. A large $\Delta$ does harm outside the body, too: the value is no longer a distance if
# another part is nearer. The level then breaks into pieces. For a very small $\Delta$ the level
# becomes rough, and the condition number of the matrix is large.

# %% [markdown] rubric="11.9"
# One point for $F = 0$ without them, with the reason. One for the change of sign, or for the slope.
# One for both ends of the range of $\Delta$; one end alone earns half.

# %% [markdown]
# **11.10** Wendland (*Scattered Data Approximation*, 2005, page 3) calls normals $b_i \mathbf{n}_i$
# with signs $b_i = \pm 1$ consistently oriented if a sum over all links is minimal: $\sum b_i b_j
# (1 - |\mathbf{n}_i^T\mathbf{n}_j|)$. Show that no weight that ignores the signs of the given
# normals can be right, and correct the sum.
#
# <details><summary>Hint</summary>
#
# Begin with the outward normals of a sphere: then all $b_i = 1$ should be optimal. How does the sum
# change if one of the given normals is inverted?
#
# </details>

# %% [markdown] answer="11.10" points=3 minutes=10 words=60 optional
# Invert one given normal. The weights stay as they are, so the best $b$ stays the same, while the
# right answer has another sign at that point. So such a sum cannot be right for both.
#
# The sum $\sum b_i b_j\, \mathbf{n}_i^T \mathbf{n}_j$ should be maximal: a term is positive where
# neighbours agree.
#
# *Beyond the question.* With Wendland's weights, which are not negative, $b = (1, \dots, 1)$ makes
# every term as large as possible for outward normals, so the sum is *maximal* at the right answer.
# Its minimum puts opposite signs where the normals differ most. The exact maximum of the corrected
# sum is expensive. The tree is a good approximation: along its links every term is made positive,
# or is zero. By (11.4) it prefers links with nearly parallel normals, where the decision is safe.

# %% [markdown] rubric="11.10"
# One point for inverting one normal, or for outward normals, whose signs give the maximum. One for
# the contradiction: the weights and the best signs stay the same, the right ones do not. One for
# the sum with signs of the scalar products; (11.4) as the weight of the tree may be named.

# %% [markdown]
# **11.11** A sheet of metal has been scanned from both sides. Its thickness is smaller than the
# distance between neighbouring points. Why does the orientation of the normals along the
# neighbourhood graph fail?
#
# <details><summary>Hint</summary>
#
# On which side of the sheet are the nearest neighbours of a point?
#
# </details>

# %% [markdown] answer="11.11" points=3 minutes=10 words=60 optional
# The nearest neighbours lie on both sides, so links pass through the sheet. The normals of both
# sides are parallel, so the links through the sheet are the cheapest of all, and the tree contains
# some of them. Along such a link the same sign is given to both sides, and one of them then points
# inward.
#
# *Beyond the question.* A remedy is the direction from which each point was seen, which scanners
# know: the normal points to the scanner. Other remedies are more points, with a spacing below the
# thickness, and normals from another measurement. The plane fitted to the neighbours is a
# compromise. Its normal may still be good where the sheet is flat, but not at its edge. Off-surface
# points on the inside pass the test only within half of the thickness, and with wrong signs they
# contradict each other.

# %% [markdown] rubric="11.11"
# One point for neighbours, or links, from both sides. One for cheap links, since the normals are
# parallel. One for the wrong sign: both sides get the same direction, so one points inward.

# %% [markdown]
# ## Dig deeper
#
# - Off-surface points can be avoided. Require $F(\mathbf{p}_i) = 0$ and $\mathbf{n}_i^T \nabla
#   F(\mathbf{p}_i) = -1$ (search for *Hermite radial basis functions*). Which functions replace the
#   cubed distances, and how many unknowns are there?
# - For noisy points, approximate instead of interpolating: add a number $\mu$ to the diagonal of
#   $\mathbf{A}$ in (11.8). Which sign of $\mu$ makes the level smoother? (Search for *smoothing
#   spline*.)
# - Let two bodies be given by $F$ and $G$. Which bodies belong to $\max(F, G)$, $\min(F, G)$,
#   $\min(F, -G)$ and $(1 - t) F + t G$? (Search for *constructive solid geometry*.)
# - Draw both ways to connect the crossings in a square with four of them. Which way does the sign
#   of $F$ at the centre suggest? A cube has 256 sign patterns. How many differ by more than a
#   rotation?
# - How does the time for (11.8) grow with the number of points, and for how many points is the
#   memory of your computer full? Read in Wendland (2005), chapter 15, how partitions of unity
#   avoid the large system.

# %%
progress()
