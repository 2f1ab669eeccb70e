# ---
# jupyter:
#   course:
#     builds_on:
#       "03": radial basis functions with a linear polynomial, and the saddle-point system
#     pages: book, pages 11–16; appendix, section 2
#     chapters: [20-kernels, 36-other-data]
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
# # Kernels and their orders
#
# A field through scattered values can be a sum of *radial basis functions*, one centred at each
# point, and a polynomial. Which functions are allowed? Which polynomials do they need, at which
# points, and in how many variables? Each of these questions has an answer, and this notebook shows
# what happens when the condition of the answer is violated.
#
# **Sources**: the appendix (of a thesis on mesh errors and conditionally positive definite
# functions); H. Wendland, *Scattered Data Approximation* (2005), chapters 8 (conditionally
# positive definite functions) and 9 (compactly supported functions), and chapter 1, pages 1–16;
# C. Micchelli, *Interpolation of scattered data* (1986); J. Mairhuber (1956) and P. Curtis
# (1959). **To search for**: conditionally positive definite, polyharmonic spline, thin-plate
# spline, unisolvent, saddle-point system, Wendland function, Mairhuber–Curtis theorem,
# Hermite–Birkhoff interpolation, cross-validation.
#
# Each question asks for a short function with a check below it, or for an answer in words. After a
# check that is not right, `case()` in a new cell shows the inputs for which your function failed,
# and your values. If everybody has the same inputs, it also shows the right values. Arrays may hold
# integers, so small that no product of them overflows. Compute with float64, NumPy's default type.
# Returned lists count as arrays, an array with one entry as a number, and a complex number without
# imaginary part as a real one. A function must not change its arguments.

# %% tags=["setup"]
import numpy as np
from matplotlib.cbook import get_sample_data

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
# ## The kernels
#
# Let $\mathbf{p}_1, \dots, \mathbf{p}_N$ be distinct points with the values $v_1, \dots, v_N$. A
# *kernel* $\varphi$ is a function of the distance. Most of this notebook is about the *polyharmonic
# splines*, a family with one member for each power $k = 1, 2, 3, \dots$:
#
# $$ \varphi_k(r) = \begin{cases} (-1)^{(k+1)/2}\; r^k & \text{for odd } k, \\
#    (-1)^{k/2+1}\; r^k \log r & \text{for even } k, \end{cases} \qquad \varphi_k(0) = 0. \tag{9.1}
#    $$
#
# So $\varphi_1 = -r$, $\varphi_2 = r^2\log r$ (the thin-plate spline; half of the kernel of
# notebook 03), $\varphi_3 = r^3$, $\varphi_4 = -r^4\log r$, $\varphi_5 = -r^5$. The signs make
# the quadratic form (9.5) positive.
#
# The next cell has a finished function, the kernels. It also shows the style of this notebook: a
# docstring with the shapes, whole arrays, and no loop over points. Two functions that notebook 03
# explains are ready-made, and the first cell imports them. `distances(x, points)` returns
# $\lVert\mathbf{x}_i - \mathbf{p}_j\rVert$, of shape $(M, N)$, for `x` $(M, D)$ and `points` $(N,
# D)$. The other one, `saddle_point_matrix`, is needed below. Use all three in your answers.


# %% tags=["setup"]
def kernel(r, k):
    """Return φ_k(r) of (9.1) for distances r of any shape."""
    if k % 2:
        return (-1) ** ((k + 1) // 2) * r**k
    return (-1) ** (k // 2 + 1) * r**k * np.log(np.where(r > 0, r, 1))


# %% [markdown]
# ## The problem in a picture
#
# Three points are the corners of an equilateral triangle, with the values 1, 0, 0. Can a sum of
# three kernels, without a polynomial, interpolate these values? The picture shows the field along
# the height of the triangle. Move the side of the triangle towards 1.


# %%
@draw(side=Slider(0.8, 1.2, 1.02, "side", steps=39))
def kernels_alone(side):
    sites = side * np.array([[0, 0], [np.sqrt(3) / 2, 0.5], [np.sqrt(3) / 2, -0.5]])
    values = np.array([1.0, 0.0, 0.0])
    coefficients = np.linalg.solve(kernel(distances(sites, sites), 2), values)
    along = np.linspace(-0.5, 1.8, 300)
    line = np.stack([along, 0 * along], axis=1)
    with figure(6.4, 2.8) as page:
        axes = page.subplots()
        axes.axhline(0, color=GREY, lw=0.8)
        axes.plot(
            along,
            kernel(distances(line, sites), 2) @ coefficients,
            color=ORANGE,
            label="kernels alone",
        )
        axes.plot(along, 1 - along / sites[1, 0], color=BLUE, label="a plane")
        axes.plot([0, sites[1, 0]], [1, 0], "o", color="black", label="values 1 and 0")
        axes.set(
            xlabel="along the height", ylabel="field", ylim=(-12, 12), title=rf"side {side:.3f}"
        )
        axes.legend(loc="center left", bbox_to_anchor=(1, 0.5))
    return page


# %% [markdown]
# **What to look at.** The points are in the best possible position, and a plane interpolates the
# values. The kernels alone need enormous coefficients, and for the side 1 there is no solution.
# There $r^2 \log r = 0$ for all distances, so the matrix is zero. We need a condition under which
# the matrix is regular for all distinct points.

# %% [markdown]
# ## Kernels plus a polynomial
#
# Let $\pi_1, \dots, \pi_Q$ be a basis of the polynomials of degree at most $n$. The field is
#
# $$ f(\mathbf{x}) = \sum_{j=1}^N \lambda_j\, \varphi(\lVert\mathbf{x} - \mathbf{p}_j\rVert) +
#    \sum_{l=1}^Q c_l\, \pi_l(\mathbf{x}), \qquad
#    \sum_{j=1}^N \lambda_j\, \pi_l(\mathbf{p}_j) = 0 \quad \text{for } l = 1, \dots, Q. \tag{9.2}
#    $$
#
# The equations on the right are the *side conditions*. Let
# $A_{ij} = \varphi(\lVert\mathbf{p}_i - \mathbf{p}_j\rVert)$ and $P_{il} = \pi_l(\mathbf{p}_i)$.
# The matrix $\mathbf{P}$ has a row for each point and a column for each polynomial. The unknowns
# solve the *saddle-point system*
#
# $$ \begin{bmatrix} \mathbf{A} & \mathbf{P} \\ \mathbf{P}^T & \mathbf{0} \end{bmatrix}
#    \begin{bmatrix} \boldsymbol{\lambda} \\ \mathbf{c} \end{bmatrix} =
#    \begin{bmatrix} \mathbf{v} \\ \mathbf{0} \end{bmatrix} . \tag{9.3} $$
#
# It is the system of notebook 03 for other kernels and polynomials. `saddle_point_matrix(A, P)`
# returns its matrix, also for a $\mathbf{P}$ without columns.
#
# ## A worked example
#
# Two points $(0, 0)$ and $(2, 0)$ have the values 1 and 3. Take $\varphi_1 = -r$ and the constant,
# $n = 0$. The side condition is $\lambda_1 + \lambda_2 = 0$, and the system is
#
# $$ \begin{bmatrix} 0 & -2 & 1 \\ -2 & 0 & 1 \\ 1 & 1 & 0 \end{bmatrix}
#    \begin{bmatrix} \lambda_1 \\ \lambda_2 \\ c \end{bmatrix} =
#    \begin{bmatrix} 1 \\ 3 \\ 0 \end{bmatrix}, \qquad
#    \lambda_1 = -\tfrac12, \quad \lambda_2 = \tfrac12, \quad c = 2 . $$
#
# The sum of the first two equations is $-2(\lambda_1 + \lambda_2) + 2c = 4$, so $c = 2$; then
# $-2 \lambda_2 = -1$. The field is
# $f(\mathbf{x}) = \tfrac12 \lVert\mathbf{x} - \mathbf{p}_1\rVert - \tfrac12 \lVert\mathbf{x} -
# \mathbf{p}_2\rVert + 2$.
# It has the values 1 and 3 at the points and 2 halfway between them. The next cell checks this.

# %%
two = np.array([[0.0, 0.0], [2.0, 0.0]])
halfway = np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]])
print(kernel(distances(halfway, two), 1) @ [-0.5, 0.5] + 2)

# %% [markdown]
# ## Polynomials in two variables
#
# In the plane we take the monomials as basis,
#
# $$ x_1^a\, x_2^b, \qquad a, b \geq 0, \quad a + b \leq n, \qquad Q = \tfrac12 (n+1)(n+2).
#    \tag{9.4} $$
#
# For the degree 2 and the point $(2, 3)$ they are $1, 2, 3, 4, 6, 9$.
#
# ### 09.1 The monomials
#
# Write a function that returns $\mathbf{P}$. You may choose the order of the columns. The degree
# $-1$ means no polynomial: then the matrix has $N$ rows and no column.
#
# <details><summary>Hint</summary>
#
# First make a list of the pairs $(a, b)$. For a given $a$, which is the largest $b$? An array may
# have the shape $(N, 0)$: `np.zeros((5, 0))` is one.
#
# </details>


# %% question="09.1" minutes=20
def monomials(points, degree):
    """Return P of shape (N, Q), with the columns (9.4), for points (N, 2), degree -1, 0, 1, …"""
    # BEGIN SOLUTION
    x, y = points.T
    powers = [(n - j, j) for n in range(degree + 1) for j in range(n + 1)]
    columns = np.array([x**i * y**j for i, j in powers])
    return columns.reshape(len(powers), len(points)).T
    # END SOLUTION


# %%
check("09.1")

# %% [markdown]
# ## Order of a kernel
#
# A kernel is *conditionally positive definite of order $m$* if
#
# $$ \boldsymbol{\lambda}^T \mathbf{A} \boldsymbol{\lambda} =
#    \sum_{i,j} \lambda_i \lambda_j\, \varphi(\lVert\mathbf{p}_i - \mathbf{p}_j\rVert) > 0
#    \tag{9.5} $$
#
# for all distinct points and all $\boldsymbol{\lambda} \neq \mathbf{0}$ that satisfy the side
# conditions for the polynomials of degree **less than** $m$. Order zero has no side conditions:
# $\mathbf{A}$ itself is positive definite, as for the Gaussian $\varphi(r) = e^{-r^2}$. For order
# one the $\lambda_j$ sum to zero. For order two the sums $\sum_j \lambda_j \mathbf{p}_j$ vanish as
# well.
#
# *Example.* The points $(0, 0)$, $(3, 0)$ and $(0, 4)$ have the distances 3, 4 and 5. With
# $\varphi_1 = -r$ the form is $-6\lambda_1\lambda_2 - 8\lambda_1\lambda_3 - 10\lambda_2\lambda_3$.
# For $\boldsymbol{\lambda} = (1, 1, 1)$ it is $-24$. For $(1, -1, 0)$, $(1, 0, -1)$ and
# $(0, 1, -1)$, whose entries sum to zero, it is 6, 8 and 10.
#
# To test (9.5) for given points we need the vectors with
# $\mathbf{P}^T\boldsymbol{\lambda} = \mathbf{0}$. They form a subspace, the null space of
# $\mathbf{P}^T$. Let the columns of $\mathbf{Z}$ be an orthonormal basis of this space. Then
# $\boldsymbol{\lambda} = \mathbf{Z}\mathbf{t}$, and
#
# $$ \min_{\substack{\mathbf{P}^T\boldsymbol{\lambda} = \mathbf{0} \\
#    \lVert\boldsymbol{\lambda}\rVert = 1}}
#    \boldsymbol{\lambda}^T \mathbf{A} \boldsymbol{\lambda} =
#    \text{smallest eigenvalue of } \mathbf{Z}^T \mathbf{A} \mathbf{Z} . \tag{9.6} $$
#
# ### 09.2 The smallest eigenvalue
#
# Write a function that returns (9.6) for any symmetric $\mathbf{A}$ and any $\mathbf{P}$. There are
# two special cases: $\mathbf{P}$ may have no columns, and its columns may be linearly dependent.
# Singular values of $\mathbf{P}$ of at most $10^{-10}$ times the largest one count as zero. All
# columns may be zero.
#
# <details><summary>Hint</summary>
#
# The full singular value decomposition $\mathbf{P} = \mathbf{U}\mathbf{S}\mathbf{V}^T$ has a square
# $\mathbf{U}$. Which of its columns are orthogonal to all columns of $\mathbf{P}$? Their number
# depends on the rank of $\mathbf{P}$, which may be less than $Q$. The function
# `np.linalg.matrix_rank` has a relative tolerance `rtol`; its default, and that of
# `np.linalg.pinv`, is about $10^{-15}$, not that of the text. For $Q = 0$ the rank is zero, but
# some versions of NumPy cannot compute it.
#
# </details>


# %% question="09.2" minutes=20
def least_eigenvalue(a, p):
    """Return the number (9.6) for A of shape (N, N) and P of shape (N, Q) and rank < N."""
    # BEGIN SOLUTION
    u = np.linalg.svd(p)[0]
    rank = np.linalg.matrix_rank(p, rtol=1e-10) if p.any() else 0
    z = u[:, rank:]
    return np.linalg.eigvalsh(z.T @ a @ z)[0]
    # END SOLUTION


# %%
check("09.2")


# %%
@draw(k=Slider(1, 5, 3, "power k", whole=True))
def both_sides(k):
    sites = 3 * np.random.default_rng(9).random((14, 2))
    a = kernel(distances(sites, sites), k)
    degrees = np.arange(-1, 4)
    least = np.array([least_eigenvalue(a, monomials(sites, int(n))) for n in degrees])
    with figure(6.4, 2.8) as page:
        axes = page.subplots()
        axes.axhline(0, color=GREY, lw=0.8)
        for chosen, color, mark in ((least > 0, BLUE, "^"), (least <= 0, ORANGE, "v")):
            axes.plot(degrees[chosen], least[chosen], mark, ms=9, color=color)
        for n, value in zip(degrees, least, strict=True):
            axes.annotate(
                f"{value:.0f}" if value < -1 else f"{value:.2g}",
                (n, value),
                xytext=(9, 0),
                va="center",
                textcoords="offset points",
            )
        axes.set_yscale("symlog", linthresh=1e-3)
        axes.set(
            xlabel="degree of the polynomials in the side conditions",
            ylabel="smallest eigenvalue",
            xlim=(-1.3, 3.7),
            ylim=(-3e4, 3e3),
            xticks=degrees,
            yticks=[-1e3, -1, 0, 1, 1e3],
            title=f"$k = {k}$, fourteen points",
        )
        axes.set_xticklabels(["none", "0", "1", "2", "3"])
    return page


# %% [markdown]
# **What to look at.** For each $k$ there is a degree from which on the smallest eigenvalue is
# positive. With one degree less it is far below zero. What is this degree for $k = 1, \dots, 5$?
# The order is this degree plus one. More side conditions keep a positive form positive, so a higher
# degree than necessary is allowed.
#
# The rule is
#
# $$ \text{order of } \varphi_k = \lfloor k/2 \rfloor + 1 , \tag{9.7} $$
#
# in any number of variables; $\lfloor\;\rfloor$ means rounded down. Micchelli (1986) proved it for
# all sets of distinct points; the picture shows one set of fourteen points.

# %% [markdown]
# ## Unisolvent points
#
# Let the degree match the order. Then (9.3) has exactly one solution if the points are *unisolvent*
# for the degree $n$. This means: the only polynomial of degree at most $n$ that vanishes at all
# points is zero. For $n = 1$ the points must not all lie on one line. What is the condition for
# $n = 2$?
#
# ### 09.3 Polynomials that vanish at the points
#
# A polynomial with the coefficients $\mathbf{c}$ has the values $\mathbf{P}\mathbf{c}$ at the
# points. Write a function that returns the number of linearly independent polynomials of degree at
# most $n$ that vanish at all points. For unisolvent points this number is zero.
#
# The number does not depend on the origin of the coordinates or on the unit of length, but the
# rounding errors do. In a small box $x_1^2$ is tiny compared to the monomial 1. Far from the origin
# the columns of $\mathbf{P}$ are nearly multiples of each other. So first shift the points to the
# mean zero, and divide all coordinates by one number, their size, such as the largest absolute
# value of a coordinate then. Now treat singular values of $\mathbf{P}$ of at most $10^{-10}$ times
# the largest one as zero. With fewer points than columns there are fewer singular values than
# columns.
#
# <details><summary>Hint</summary>
#
# The solutions of $\mathbf{P}\mathbf{c} = \mathbf{0}$ form a subspace. How is its dimension related
# to the rank of $\mathbf{P}$ and to the number of its columns? (Search for: rank–nullity theorem.)
#
# </details>


# %% question="09.3" minutes=15
def vanishing(points, degree):
    """Return how many independent polynomials up to a degree 0, 1, … vanish at points (N, 2).

    At least two of the points are different.
    """
    # BEGIN SOLUTION
    z = points - points.mean(axis=0)
    p = monomials(z / np.ptp(z), degree)
    return p.shape[1] - np.linalg.matrix_rank(p, rtol=1e-10)
    # END SOLUTION


# %%
check("09.3")


# %%
@draw(out=Slider(-0.4, 0.4, 0, "sixth point moved outwards"))
def six_points(out):
    angle = np.array([0.3, 1.2, 2.5, 3.3, 4.4, 5.5])
    sites = np.stack([1.3 * np.cos(angle), 0.8 * np.sin(angle)], axis=1)
    sites[5] *= 1 + out
    p = monomials(sites, 2)
    smallest = np.linalg.svd(p)[2][-1]
    side = np.linspace(-2, 2, 161)
    grid = np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2)
    with figure(6.4, 3.2) as page:
        axes = page.subplots()
        field = (monomials(grid, 2) @ smallest).reshape(161, 161)
        axes.contourf(
            side,
            side,
            np.abs(field),
            levels=np.linspace(0, 1.5, 7),
            cmap="Greys",
            extend="max",
            alpha=0.5,
        )
        axes.contour(side, side, field, levels=[0], colors=ORANGE)
        axes.plot(*sites[:5].T, "o", color=BLUE)
        axes.plot(*sites[5], "o", color=ORANGE, ms=9)
        singular = np.linalg.svd(p)[1][-1]
        axes.set(xlabel="$x_1$", ylabel="$x_2$", aspect="equal", xlim=(-2, 2), ylim=(-1.3, 1.3))
        axes.set_title(
            f"vanishing polynomials: {int(vanishing(sites, 2))}; smallest singular value "
            f"{singular:.1e}"
        )
    return page


# %% [markdown]
# **What to look at.** There are six points and six monomials of degree at most two. Among all
# quadratic polynomials with $\lVert\mathbf{c}\rVert = 1$ one has the smallest values at the six
# points. The orange curve is its zero set, and the grey shades are its absolute value. If the six
# points lie on an ellipse, this polynomial vanishes at all of them, and the points are not
# unisolvent. Move the orange point away from the ellipse: now they are. In notebook 03 the
# exceptional points lay on a line. Here, one degree higher, they lie on a *conic*: an ellipse, a
# hyperbola, a parabola, or two lines.

# %% [markdown]
# ### 09.4 The interpolating field
#
# Write a function that solves (9.3) and evaluates (9.2) at the points $\mathbf{x}$. The power $k$
# and the degree $n$ are arguments. For $n = -1$ there is no polynomial. The degree may also be
# lower than the order requires. The given points are distinct and such that (9.3) has exactly one
# solution; there may be as few points as monomials. Their coordinates may be some hundreds. Do not
# change the unit of length: for even powers and too low a degree, it changes the field.
# `saddle_point_matrix` combines the two blocks of the matrix; you state the blocks and the right
# side.
#
# <details><summary>Hint</summary>
#
# How many zeros are on the right side of (9.3)? It is the number of columns of $\mathbf{P}$. The
# functions that build the matrix also evaluate the field, with $\mathbf{x}$ in place of the points.
#
# </details>


# %% question="09.4" minutes=25
def interpolate(points, values, k, degree, x):
    """Return f of (9.2) with φ_k at x (M, 2), for points (N, 2) and values (N,)."""
    # BEGIN SOLUTION
    n = len(points)
    p = monomials(points, degree)
    system = saddle_point_matrix(kernel(distances(points, points), k), p)
    unknown = np.linalg.solve(system, np.concatenate([values, np.zeros(p.shape[1])]))
    return kernel(distances(x, points), k) @ unknown[:n] + monomials(x, degree) @ unknown[n:]
    # END SOLUTION


# %%
check("09.4")


# %%
@draw(k=Slider(1, 5, 3, "power k", whole=True), degree=Slider(-1, 3, 1, "degree n", whole=True))
def your_field(k, degree):
    sites, values, *_ = data("09.4")
    side = np.linspace(-0.5, 1.5, 81)
    grid = np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2)
    field = interpolate(sites, values, k, degree, grid).reshape(81, 81)
    enough = degree >= k // 2
    with figure(5.6, 3.9) as page:
        axes = page.subplots()
        image = axes.contourf(
            side, side, field, levels=np.linspace(-4, 4, 17), extend="both", cmap="PuOr_r"
        )
        axes.scatter(*sites.T, c=values, norm=image.norm, cmap="PuOr_r", ec="black", s=60)
        axes.set(xlabel="$x_1$", ylabel="$x_2$", aspect="equal", xticks=[0, 1], yticks=[0, 1])
        axes.set_title(
            f"$k = {k}$, $n = {degree}$: "
            + ("a field for all points" if enough else "the degree is too low")
        )
        page.colorbar(image, ax=axes, label="$f$")
    return page


# %% [markdown]
# **What to look at.** The dots have the same colours as the field around them: it interpolates
# your values, even if the degree is too low. With a degree that is too low this is luck. The form
# is indefinite under too few side conditions, and an eigenvalue may pass through zero as the
# points move, as for the triangle at the beginning. (For two or more points only $k = 1$ is safe
# without a polynomial; *Dig deeper* asks why.) Compare the corners of the picture for the degrees
# 0 and 3: how does the field extrapolate?
#
# ## A real field: the heights of a terrain
#
# The next picture interpolates heights from the Shuttle Radar Topography Mission (NASA, in the
# public domain), around Jacksboro in Tennessee. Matplotlib ships them as sample data, so the bundle
# needs no file. The sites are random nodes of the elevation model, and the errors are measured at
# 400 other nodes, which the interpolation has not used. This is *validation by held-out data*;
# repeated for all sites in turn it is called *cross-validation*.


# %%
def terrain_sample(first, number):
    """Return points (number, 2) in kilometres and their heights in metres.

    They are nodes of the model in random order, the same on every call, from the `first` on.
    """
    with get_sample_data("jacksboro_fault_dem.npz") as file:
        height = file["elevation"][::-1].astype(float)
    nodes = np.random.default_rng(1).permutation(240 * 240)
    row, column = np.divmod(nodes[first : first + number], 240)
    return np.stack([0.075 * column, 0.092 * row], axis=1), height[row, column]


@draw(
    number=Slider(40, 300, 120, "sites", whole=True),
    k=Slider(1, 5, 2, "power k in the map", whole=True),
)
def terrain(number, k):
    held_out, exact = terrain_sample(0, 400)
    sites, heights = terrain_sample(400, number)
    powers = np.arange(1, 6)
    errors = [
        np.sqrt(np.mean((interpolate(sites, heights, p, p // 2, held_out) - exact) ** 2))
        for p in map(int, powers)
    ]
    east, north = np.linspace(0, 17.9, 60), np.linspace(0, 22, 60)
    grid = np.stack(np.meshgrid(east, north), axis=-1).reshape(-1, 2)
    field = interpolate(sites, heights, k, k // 2, grid).reshape(60, 60)
    with figure(6.8, 3.3) as page:
        left, right = page.subplots(1, 2, width_ratios=(1, 1.1))
        levels = np.linspace(200, 1100, 19)
        image = left.contourf(east, north, field, levels=levels, extend="both", cmap="YlOrBr")
        left.plot(*sites.T, ".", color="black", ms=3)
        left.set(aspect="equal", xlabel="km to the east", ylabel="km to the north")
        page.colorbar(image, ax=left, label="height [m]", shrink=0.8)
        right.semilogy(powers, errors, "o-", color=BLUE)
        right.plot(k, errors[k - 1], "o", color=ORANGE, ms=9)
        right.axhline(np.std(exact), color=GREY, ls="--", label="error of the mean height")
        right.set(xlabel="power $k$", xticks=powers, ylabel="RMS error at 400 other nodes [m]")
        right.set(yticks=[40, 60, 100, 200], yticklabels=["40", "60", "100", "200"], ylim=(30, 300))
        right.minorticks_off()
        right.legend(loc="upper left")
    return page


# %% [markdown]
# **What to look at.** Which power has the smallest error? A terrain is rough, and a kernel for
# smooth fields ($k = 5$) overshoots between the sites. No rule selects the kernel; the data do, by
# held-out errors. Double the number of sites: how much does the error decrease?
#
# ## Points on a line
#
# Now the order is right, but the points are not unisolvent: five points lie on a line, with the
# kernel $r^2\log r$ and $n = 1$. The linear polynomial $x_1 - x_2$ vanishes at all of them, and
# the slider adds a multiple of it.


# %%
@draw(more=Slider(-2, 2, 1, "times x₁ − x₂"))
def on_a_line(more):
    along = np.array([0.05, 0.3, 0.45, 0.7, 0.95])
    sites = np.stack([along, along], axis=1)
    values = np.array([0.0, 1.0, 0.2, -0.6, 0.5])
    p, a = monomials(sites, 1), kernel(distances(sites, sites), 2)
    whole = np.hstack([np.vstack([a, p.T]), np.vstack([p, np.zeros((3, 3))])])
    found = np.linalg.lstsq(whole, np.append(values, np.zeros(3)), rcond=1e-10)[0]
    side = np.linspace(0, 1, 61)
    grid = np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2)
    field = kernel(distances(grid, sites), 2) @ found[:5] + monomials(grid, 1) @ found[5:]
    with figure(6.4, 2.9) as page:
        for axes, plane, title in zip(
            page.subplots(1, 2), (0, more), ("a solution", "another one"), strict=True
        ):
            shown = (field + plane * (grid[:, 0] - grid[:, 1])).reshape(61, 61)
            image = axes.contourf(
                side, side, shown, levels=np.linspace(-2, 2, 17), extend="both", cmap="PuOr_r"
            )
            axes.scatter(*sites.T, c=values, norm=image.norm, cmap="PuOr_r", ec="black", s=60)
            axes.set(
                title=title,
                aspect="equal",
                xticks=[0, 1],
                yticks=[0, 1],
                xlabel="$x_1$",
                ylabel="$x_2$",
            )
        page.colorbar(image, ax=page.axes, label="$f$")
    return page


# %% [markdown]
# **What to look at.** Both fields solve the system. They agree on the line and differ everywhere
# else.

# %% [markdown]
# ## Compactly supported kernels
#
# The kernels $\varphi_k$ do not vanish at large distances, so every point affects every other one
# and the matrix is full. Wendland's functions are zero beyond the distance 1, so that most entries
# of $\mathbf{A}$ are zero, and they need no polynomial. With $y_+ = \max(y, 0)$,
#
# $$ \ell = \lfloor D/2 \rfloor + s + 1, \qquad \psi_{D,0}(r) = (1-r)_+^{\ell}, \qquad
#    \psi_{D,1}(r) = (1-r)_+^{\ell+1} \bigl( (\ell+1)\, r + 1 \bigr) . \tag{9.8} $$
#
# Here $D$ is the number of variables. The number $s$ is the smoothness: the field is continuous for
# $s = 0$ and has two continuous derivatives for $s = 1$. The functions for $s = 1$ are integrals of
# those for $s = 0$,
#
# $$ \psi_{D,1}(r) = C \int_r^\infty t\, \psi_{D+2,0}(t)\, dt , \tag{9.9} $$
#
# where $C$ normalizes $\psi_{D,1}(0) = 1$. Both are positive definite in up to $D$ variables, and
# in general not in more.
#
# *Example.* For $D = 3$ and $s = 1$ we have $\ell = 3$ and $\psi_{3,1}(r) = (1-r)_+^4 (4r + 1)$, so
# $\psi_{3,1}(\tfrac12) = \tfrac{3}{16}$.
#
# ### 09.5 Wendland's functions
#
# Write (9.8) for $s = 0$ and $s = 1$. The brackets $\lfloor\;\rfloor$ mean: round down.


# %% question="09.5" minutes=20 optional
def wendland(r, d, s):
    """Return ψ_{d,s}(r) of (9.8) for distances r of any shape, and s = 0 or 1."""
    # BEGIN SOLUTION
    ell = d // 2 + s + 1
    inside = np.maximum(1 - r, 0)
    if s == 0:
        return inside**ell
    return inside ** (ell + 1) * ((ell + 1) * r + 1)
    # END SOLUTION


# %%
check("09.5")


# %%
@draw(
    d=Slider(1, 3, 1, "D of the function", whole=True),
    s=Slider(0, 1, 0, "smoothness s", whole=True),
)
def too_many_variables(d, s):
    r = np.linspace(0, 1.3, 200)
    steps = np.linspace(0.3, 1, 15)
    with figure(6.4, 2.8) as page:
        left, right = page.subplots(1, 2, width_ratios=[1, 1.6])
        left.plot(r, wendland(r, d, s), color=PURPLE)
        left.set(xlabel="$r$", title=rf"$\psi_{{{d},{s}}}(r)$")
        right.axhline(0, color=GREY, lw=0.8)
        for variables, across, color, mark in (
            (1, 30, BLUE, "o"),
            (2, 9, GREEN, "s"),
            (3, 5, ORANGE, "v"),
        ):
            axis = np.arange(across)
            lattice = np.stack(np.meshgrid(*[axis] * variables), axis=-1).reshape(-1, variables)
            r = distances(lattice, lattice)
            least = [
                least_eigenvalue(wendland(step * r, d, s), np.zeros((len(r), 0))) for step in steps
            ]
            right.plot(
                steps,
                least,
                color=color,
                marker=mark,
                ms=4,
                label=f"{variables} variable" + "s" * (variables > 1),
            )
        right.set(xlabel="step of the lattice", title="smallest eigenvalue", ylim=(-0.75, 1.05))
        right.legend(loc="center left", bbox_to_anchor=(1, 0.5))
    return page


# %% [markdown]
# **What to look at.** The right panel shows the smallest eigenvalue of the matrix of your function
# for lattices in one, two and three variables. The function $\psi_{1,0} = (1-r)_+$ is positive
# definite on the line. In the plane its matrix has a negative eigenvalue, and in space one that is
# farther below zero, although all points are distinct. The other functions stay positive on these
# lattices. Such a test can refute positive definiteness, but it cannot prove it. For instance,
# $\psi_{1,1}$ is not positive definite in two variables, but only lattices with about two thousand
# points show it.

# %% [markdown]
# ## The Mairhuber–Curtis theorem
#
# On the line, $N$ fixed functions can interpolate at any $N$ distinct points: the polynomials of
# degree $N - 1$. In the plane it is impossible with any continuous functions if $N \geq 2$. This
# is the theorem of *Mairhuber and Curtis*. Its proof moves two points until they have exchanged
# their positions.
#
# Let $\mathbf{m} = \tfrac12(\mathbf{p}_1 + \mathbf{p}_2)$. The first two points move
# counter-clockwise around $\mathbf{m}$, along the two halves of a circle, while $\mathbf{p}_3$
# stays:
#
# $$ \mathbf{p}_{1,2}(t) = \mathbf{m} + \begin{bmatrix} \cos \pi t & -\sin \pi t \\ \sin \pi t &
#    \cos \pi t \end{bmatrix}
#    (\mathbf{p}_{1,2} - \mathbf{m}), \qquad 0 \leq t \leq 1. \tag{9.10} $$
#
# *Example.* For $\mathbf{p}_1 = (1, 0)$, $\mathbf{p}_2 = (-1, 0)$ and $\mathbf{p}_3 = (0, 2)$ the
# points lie on the vertical axis at $t = \tfrac12$.
#
# ### 09.6 The time of failure
#
# The functions $1, x_1, x_2$ cannot interpolate arbitrary values at three points on one line. Write
# a function that returns the time $t$ between 0 and 1 at which the three points lie on one line. At
# the start, $t = 0$, they do not lie on one line, so $\mathbf{p}_3 \neq \mathbf{m}$. The unit of
# length may be any.
#
# <details><summary>Hint</summary>
#
# The line through the two moving points contains $\mathbf{m}$ and rotates by the angle $\pi t$. In
# which direction is $\mathbf{p}_3$, seen from $\mathbf{m}$? A line that has rotated by $\pi$ is the
# same line. Another way is bisection: a determinant has different signs at the two ends.
#
# </details>


# %% question="09.6" minutes=15 optional
def exchange_time(points):
    """Return the time t of (9.10) at which three points (3, 2) lie on one line."""
    # BEGIN SOLUTION
    middle = (points[0] + points[1]) / 2
    (a, b), (c, d) = points[0] - middle, points[2] - middle
    turn = np.arctan2(a * d - b * c, a * c + b * d)
    return turn / np.pi % 1
    # END SOLUTION


# %%
check("09.6")


# %%
@draw(t=Slider(0, 1, 0.25, "time t"))
def exchange(t):
    (three,) = data("09.6")
    three = (three - three.mean(axis=0)) / np.ptp(three, axis=0).max()

    def positions(time):
        z = three[:, 0] + 1j * three[:, 1]
        middle = (z[0] + z[1]) / 2
        z[:2] = middle + np.exp(1j * np.pi * time) * (z[:2] - middle)
        return np.stack([z.real, z.imag], axis=1)

    times = np.linspace(0, 1, 101)
    plain = np.array([np.linalg.det(monomials(positions(u), 1)) for u in times])
    gaussians = np.array(
        [np.linalg.det(np.exp(-4 * distances(positions(u), positions(u)) ** 2)) for u in times]
    )
    with figure(6.4, 3.3) as page:
        left, right = page.subplots(1, 2, width_ratios=[1, 1.4])
        now = positions(t)
        for j in (0, 1):
            left.plot(*np.array([positions(u)[j] for u in times]).T, color=GREY, lw=0.8, ls=":")
        positive = np.linalg.det(monomials(now, 1)) > 0
        left.fill(*now.T, color=BLUE if positive else ORANGE, alpha=0.3)
        for number, spot in zip("123", now, strict=True):
            left.plot(*spot, "o", color="black", ms=12)
            left.annotate(number, spot, color="white", ha="center", va="center", fontsize=8)
        left.set(aspect="equal", xticks=[], yticks=[], title=f"$t = {t:.2f}$")
        left.margins(0.12)
        left.spines[:].set_visible(False)
        right.axhline(0, color=GREY, lw=0.8)
        right.plot(times, plain / np.abs(plain).max(), color=BLUE, label="$1, x_1, x_2$")
        right.plot(
            times,
            gaussians / np.abs(gaussians).max(),
            color=GREEN,
            ls="--",
            label="three Gaussians",
        )
        right.axvline(t, color=PURPLE, lw=1)
        right.plot(exchange_time(three), 0, "o", mfc="none", ms=9, color=ORANGE, label="your time")
        right.set(xlabel="time $t$", title="determinant / its maximum", ylim=(-1.15, 1.15))
        right.legend(
            loc="upper center", bbox_to_anchor=(0.4, -0.2), ncols=3, fontsize=9, columnspacing=1
        )
    return page


# %% [markdown]
# **What to look at.** The picture shows three points of your own. Move the time from 0 to 1. The
# orientation of the triangle is reversed, so the triangle must be flat at some time. At this time
# the determinant of $1, x_1, x_2$ at the three points vanishes. At the end two rows of the matrix
# have been exchanged. The Gaussians are centred at the points and move with them, so that rows
# *and* columns are exchanged.

# %% [markdown]
# ## Slopes as data
#
# The method needs linear measurements, and values are only one kind of them. Interpolation of
# values and derivatives is called *Hermite–Birkhoff interpolation*. Take one variable, points
# $x_1, \dots, x_N$, and at each point a value $v_i$ and a slope $g_i$. The basis function of a
# value is $\varphi(x - y)$ with $y$ at the point. The basis function of a slope is its derivative
# **with respect to $y$**. Take $\varphi(z) = \lvert z \rvert^3$, which has order two and the
# derivatives $\varphi'(z) = 3z\lvert z \rvert$ and $\varphi''(z) = 6\lvert z \rvert$. Then
#
# $$ f(x) = \sum_j \lambda_j\, \lvert x - x_j \rvert^3 - \sum_j \mu_j\, 3 (x - x_j) \lvert x - x_j
#    \rvert + c_0 + c_1 x . \tag{9.11} $$
#
# The side conditions apply the same measurements to $1$ and $x$: $\sum_j \lambda_j = 0$ and
# $\sum_j (\lambda_j x_j + \mu_j) = 0$, since the slope of $1$ is $0$ and that of $x$ is $1$. With
# $z_{ij} = x_i - x_j$ the conditions $f(x_i) = v_i$ and $f'(x_i) = g_i$ give
#
# $$ \begin{bmatrix} \varphi(z_{ij}) & -\varphi'(z_{ij}) & 1 & x_i \\
#    \varphi'(z_{ij}) & -\varphi''(z_{ij}) & 0 & 1 \\
#    1 & 0 & 0 & 0 \\
#    x_j & 1 & 0 & 0 \end{bmatrix}
#    \begin{bmatrix} \boldsymbol{\lambda} \\ \boldsymbol{\mu} \\ c_0 \\ c_1 \end{bmatrix} =
#    \begin{bmatrix} \mathbf{v} \\ \mathbf{g} \\ 0 \\ 0 \end{bmatrix} . \tag{9.12} $$
#
# Each entry stands for a block. The blocks in the first two rows and columns have $N \times N$
# numbers, and the blocks beside and below them have $N$ numbers.
#
# ### 09.7 The matrix for values and slopes
#
# Write a function that returns the matrix of (9.12). It must be symmetric; the signs show why.
#
# <details><summary>Hint</summary>
#
# `np.block` takes the blocks row by row, as in (9.12). The block of the $x_i$ needs the shape
# $(N, 1)$. What is $\varphi'(-z)$?
#
# </details>


# %% question="09.7" minutes=20 optional
def slope_matrix(x):
    """Return the matrix of (9.12), of shape (2N + 2, 2N + 2), for x of shape (N,)."""
    # BEGIN SOLUTION
    z = x[:, np.newaxis] - x
    size = np.abs(z)
    a = np.block([[size**3, -3 * z * size], [3 * z * size, -6 * size]])
    one = np.ones((len(x), 1))
    p = np.block([[one, x[:, np.newaxis]], [np.zeros_like(one), one]])
    return np.block([[a, p], [p.T, np.zeros((2, 2))]])
    # END SOLUTION


# %%
check("09.7")


# %%
@draw(slope=Slider(-12, 12, 6, "slope at the third point"))
def with_slopes(slope):
    x = np.array([0.0, 0.7, 1.3, 2.2, 3.0])
    v = np.array([0.2, 1.0, 0.4, 0.9, 0.0])
    g = np.array([2.0, 0.0, slope, 0.0, -1.0])
    found = np.linalg.solve(slope_matrix(x), np.concatenate([v, g, [0, 0]]))
    points = np.linspace(-0.5, 3.5, 400)
    z = np.subtract.outer(points, x)
    field = (
        np.abs(z) ** 3 @ found[:5]
        - 3 * (z * np.abs(z)) @ found[5:10]
        + found[10]
        + found[11] * points
    )
    with figure(6.4, 2.8) as page:
        axes = page.subplots()
        for j in (0, 2):
            axes.axvspan(x[j], x[j + 1], color=GREY, alpha=0.12, lw=0)
        axes.plot(points, field, color=BLUE)
        for a, value, rise in zip(x, v, g, strict=True):
            reach = 0.22 / np.hypot(1, rise) * np.array([-1, 1])
            axes.plot(a + reach, value + rise * reach, color=ORANGE, lw=2.5)
        axes.plot(x, v, "o", color="black")
        axes.set(xlabel="$x$", ylabel="$f$", xlim=(-0.5, 3.5), ylim=(-1.6, 2.6))
    return page


# %% [markdown]
# **What to look at.** The curve has the given values and slopes. Which parts of it move when you
# change the slope at the third point, and which do not? Every basis function of (9.11) is nonzero
# almost everywhere, and yet the solution is local. Between two neighbours the curve is the cubic
# *Hermite interpolant* of their two values and two slopes. Outside the points it is straight.
#
# ## In words
#
# **09.8** A program uses $\varphi_3 = r^3$ with the constant only, $n = 0$, instead of $n = 1$. It
# has worked for every set of points so far. Explain with the quadratic form what can go wrong for
# other points.
#
# <details><summary>Hint</summary>
#
# Imagine two sets of points, one with a positive determinant and one with a negative determinant,
# and a path between them.
#
# </details>

# %% [markdown] answer="09.8" points=4 minutes=15 words=80
# $r^3$ has the order two: $\boldsymbol\lambda^T\mathbf{A}\boldsymbol\lambda$ is positive only if
# the $\lambda_j$ annihilate constants and linear functions. Under $\sum\lambda_j = 0$ alone the
# form takes both signs for some points. So an eigenvalue may pass through zero as points move, and
# for some distinct points the matrix is singular. Such points are exceptional, so the program may
# have missed them. Near them the coefficients are huge and the field oscillates.
#
# *Beyond the question.* An example is a triangle with the sides $1$, $1$ and $2^{2/3}$. For
# $r^2\log r$ without a polynomial, $n = -1$, it is an equilateral triangle with the side 1: all
# distances are 0 or 1, and $\varphi_2$ vanishes at both, so $\mathbf{A} = \mathbf{0}$. The degree
# $n = 2$ is allowed for $r^3$: a form that is positive on a space is positive on every subspace.
# But the points must then be unisolvent for quadratic polynomials.

# %% [markdown] rubric="09.8"
# One point for the order two: the form is positive only if linear functions are annihilated, too.
# One: under fewer side conditions the form takes both signs for some points. One: hence the matrix
# is singular for some distinct points. One: near them the coefficients are large, although the
# program has worked so far.

# %% [markdown]
# **09.9** Five points lie on a line of the plane, the kernel has the order two, and $n = 1$. Show
# that (9.3) has a solution for all values, and say which part of it is unique.
#
# <details><summary>Hint</summary>
#
# Multiply the first block row of (9.3) by $\mathbf{Z}^T$. Which matrix remains, and is it regular?
# In which space does $\mathbf{v} - \mathbf{A}\boldsymbol{\lambda}$ lie?
#
# </details>

# %% [markdown] answer="09.9" points=3 minutes=10 words=70
# Let $\boldsymbol\lambda = \mathbf{Z}\mathbf{t}$. Multiplied by $\mathbf{Z}^T$, the first block row
# is $\mathbf{Z}^T\mathbf{A}\mathbf{Z}\,\mathbf{t} = \mathbf{Z}^T\mathbf{v}$. Its matrix is positive
# definite, since the points are distinct and the order is two. So $\boldsymbol\lambda$ exists and
# is unique. The remainder $\mathbf{v} - \mathbf{A}\boldsymbol\lambda$ is orthogonal to the columns
# of $\mathbf{Z}$, hence equal to $\mathbf{P}\mathbf{c}$ for some $\mathbf{c}$. The polynomial is
# not unique: one may add a linear function that vanishes on the line.
#
# *Beyond the question.* The field is determined on the line and not outside it. A program should
# refuse such points, or choose a solution by a stated rule, such as the smallest
# $\lVert\mathbf{c}\rVert$.

# %% [markdown] rubric="09.9"
# One point: $\boldsymbol\lambda$ exists and is unique, since $\mathbf{Z}^T\mathbf{A}\mathbf{Z}$ is
# positive definite. One: a polynomial exists, since the remainder is in the range of $\mathbf{P}$.
# One: the polynomial is not unique; a polynomial that vanishes at the points may be added.

# %% [markdown]
# **09.10** Complete the proof of Mairhuber and Curtis: for any three continuous functions on the
# plane there are three distinct points and three values that they cannot interpolate.
#
# <details><summary>Hint</summary>
#
# Follow the determinant of the matrix with the entries $g_l(\mathbf{p}_i(t))$ from $t = 0$ to
# $t = 1$. What does the exchange of two rows do to a determinant?
#
# </details>

# %% [markdown] answer="09.10" points=3 minutes=10 words=70 optional
# Let $g_1, g_2, g_3$ be continuous, and let $d(t)$ be the determinant with the entries
# $g_l(\mathbf{p}_i(t))$. It is a continuous function. At $t = 1$ the first two points have
# exchanged their positions, so two rows are exchanged and $d(1) = -d(0)$. Hence $d$ vanishes at
# some time. The points are distinct at all times if $\mathbf{p}_3$ is not on the circle. At the
# zero the matrix is singular, so some values have no interpolant.

# %% [markdown] rubric="09.10"
# One point: the determinant is continuous. One: the exchange of two rows changes its sign, hence a
# zero. One: the points are distinct at all times, and a singular matrix means values without an
# interpolant.

# %% [markdown]
# ## Dig deeper
#
# - The kernel $-r$ has the order one. Compute the eigenvalues of its matrix $\mathbf{A}$ without a
#   polynomial. How many are negative? Why is the matrix regular for two or more distinct points?
#   (Its trace is zero.)
# - The kernel $\varphi(r) = -r^2$ has a form that is never negative if $\sum\lambda_j = 0$. Test it
#   with `least_eigenvalue`. Expand $\lVert\mathbf{p}_i - \mathbf{p}_j\rVert^2$: for which
#   $\boldsymbol{\lambda}$ is the form zero? Why do even powers need a logarithm?
# - Multiply all points by 1000. By which factor do the smallest eigenvalues of $\varphi_3$ change?
#   Does the field of 09.4 change?
# - Where does the proof of 09.10 fail on the line, and why does it not apply to kernels centred at
#   the points?
# - Move two of six points and use the polynomials of degree two: when is the determinant zero? Draw
#   the conic.
# - Take a Wendland function on ten thousand points, with a radius of three spacings. Which part of
#   the matrix is not zero? `scipy.sparse` stores only this part.
#
# **Next**: notebook 10 treats $r^3$ in one variable, the natural spline; notebook 12 couples two
# meshes by such fields.

# %%
progress()
