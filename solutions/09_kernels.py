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
# # Kernels and their orders
#
# A field that goes through scattered values can be made of bumps, one on each point, and a
# polynomial. Which bumps may be used? With which polynomials, at which points, in how many
# variables? There is an answer to each of the four, and in this notebook you see every one of them
# fail where its premise does.
#
# You find out which polynomials a kernel needs, when points determine a polynomial, and how far a
# bump of finite width may be trusted. You let two points change places, which shows why nobody can
# choose the functions before the points are known. At the end slopes are data too.
#
# Each question asks for a function. Write it, run its cell, and run the check below it.

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
# ## The kernels
#
# Let $\mathbf{p}_1, \dots, \mathbf{p}_N$ be distinct points with the values $v_1, \dots, v_N$.
# A *kernel* $\varphi$ is a function of the distance alone. Most of this notebook is about one
# family, in which $k = 1, 2, 3, \dots$ is a power:
#
# $$ \varphi_k(r) = \begin{cases} (-1)^{(k+1)/2}\; r^k & \text{for odd } k, \\
#    (-1)^{k/2+1}\; r^k \log r & \text{for even } k, \end{cases} \qquad \varphi_k(0) = 0. \tag{9.1}
#    $$
#
# So $\varphi_1 = -r$, $\varphi_2 = r^2\log r$ (the thin-plate spline), $\varphi_3 = r^3$,
# $\varphi_4 = -r^4\log r$, $\varphi_5 = -r^5$. You will see what the signs are for. The next cell
# has them, and the distances of two sets of points; use both in your answers.


# %% tags=["setup"]
def kernel(r, k):
    """Return φ_k(r) of (9.1) for distances r of any shape."""
    if k % 2:
        return (-1) ** ((k + 1) // 2) * r**k
    return (-1) ** (k // 2 + 1) * r**k * np.log(np.where(r > 0, r, 1))


def distances(x, points):
    """Return |x_i - p_j|, of shape (M, N), for x (M, D) and points (N, D)."""
    return np.linalg.norm(x[:, None] - points, axis=-1)


# %% [markdown]
# ## The problem in a picture
#
# Three points are the corners of an equilateral triangle, with the values 1, 0, 0. Can three bumps
# alone, without a polynomial, go through them? The picture cuts the field along the height of the
# triangle. Move the side towards 1.


# %%
@draw(side=Slider(0.8, 1.2, 1.02, "side", steps=39))
def three_bumps(side):
    sites = side * np.array([[0, 0], [np.sqrt(3) / 2, 0.5], [np.sqrt(3) / 2, -0.5]])
    values = np.array([1.0, 0.0, 0.0])
    factors = np.linalg.solve(kernel(distances(sites, sites), 2), values)
    along = np.linspace(-0.5, 1.8, 300)
    line = np.stack([along, 0 * along], axis=1)
    with figure(6.4, 2.8) as page:
        axes = page.subplots()
        axes.axhline(0, color=GREY, lw=0.8)
        axes.plot(
            along, kernel(distances(line, sites), 2) @ factors, color=ORANGE, label="bumps alone"
        )
        axes.plot(along, 1 - along / sites[1, 0], color=BLUE, label="a plane")
        axes.plot([0, sites[1, 0]], [1, 0], "o", color="black", label="values 1 and 0")
        axes.set(
            xlabel="along the height", ylabel="field", ylim=(-12, 12), title=rf"side {side:.3f}"
        )
        axes.legend(loc="center left", bbox_to_anchor=(1, 0.5))
    return page


# %% [markdown]
# **What to look at.** The points are as harmless as points can be, and three values demand no more
# than a plane. The bumps go through them with enormous factors, and for the side 1 not at all:
# there $r^2 \log r = 0$ for all three distances, and the matrix is zero. A kernel that is fine at
# almost all points is of little use. We want one that cannot fail.

# %% [markdown]
# ## Bumps and a polynomial
#
# Let $\pi_1, \dots, \pi_Q$ be a basis of the polynomials of degree at most $n$. The field is
#
# $$ f(\mathbf{x}) = \sum_{j=1}^N \lambda_j\, \varphi(\lVert\mathbf{x} - \mathbf{p}_j\rVert) +
#    \sum_{l=1}^Q c_l\, \pi_l(\mathbf{x}), \qquad
#    \sum_{j=1}^N \lambda_j\, \pi_l(\mathbf{p}_j) = 0 \quad \text{for } l = 1, \dots, Q. \tag{9.2}
#    $$
#
# The sums on the right are the *side conditions*. With $A_{ij} = \varphi(\lVert\mathbf{p}_i -
# \mathbf{p}_j\rVert)$ and $P_{il} = \pi_l(\mathbf{p}_i)$, a matrix with a row for each point and a
# column for each polynomial, the unknowns solve
#
# $$ \begin{bmatrix} \mathbf{A} & \mathbf{P} \\ \mathbf{P}^T & \mathbf{0} \end{bmatrix}
#    \begin{bmatrix} \boldsymbol{\lambda} \\ \mathbf{c} \end{bmatrix} =
#    \begin{bmatrix} \mathbf{v} \\ \mathbf{0} \end{bmatrix} . \tag{9.3} $$
#
# A system of this form is called a *saddle-point system*. In the plane take the monomials for a
# basis,
#
# $$ x_1^a\, x_2^b, \qquad a, b \geq 0, \quad a + b \leq n, \qquad Q = \tfrac12 (n+1)(n+2).
#    \tag{9.4} $$
#
# ### 09.1 The monomials
#
# Write $\mathbf{P}$. The order of the columns is yours. The degree $-1$ stands for no polynomial at
# all: then the matrix has $N$ rows and no column.
#
# <details><summary>Hint</summary>
#
# First make a list of the pairs $(a, b)$. If $a$ is given, how far does $b$ go? What has the shape
# $(N, 0)$ is an array as well: `np.zeros((5, 0))` is one.
#
# </details>


# %% question="09.1"
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
# ## Order
#
# A kernel is *conditionally positive definite of order $m$* if for all distinct points, and all
# $\boldsymbol{\lambda} \neq \mathbf{0}$ that satisfy the side conditions for the polynomials of
# degree **less than** $m$,
#
# $$ \boldsymbol{\lambda}^T \mathbf{A} \boldsymbol{\lambda} =
#    \sum_{i,j} \lambda_i \lambda_j\, \varphi(\lVert\mathbf{p}_i - \mathbf{p}_j\rVert) > 0 .
#    \tag{9.5} $$
#
# Order zero has no side conditions: $\mathbf{A}$ itself is positive definite. An example is the
# Gaussian, $\varphi(r) = e^{-r^2}$. For order one the $\lambda_j$ sum to zero, for order two they
# do so when weighted by the coordinates as well.
#
# How does one test (9.5) for given points? The vectors with $\mathbf{P}^T\boldsymbol{\lambda} =
# \mathbf{0}$ are a subspace. Let the columns of $\mathbf{Z}$ be an orthonormal basis of it. Then
# $\boldsymbol{\lambda} = \mathbf{Z}\mathbf{t}$, and
#
# $$ \min_{\substack{\mathbf{P}^T\boldsymbol{\lambda} = \mathbf{0} \\
#    \lVert\boldsymbol{\lambda}\rVert = 1}}
#    \boldsymbol{\lambda}^T \mathbf{A} \boldsymbol{\lambda} =
#    \text{least eigenvalue of } \mathbf{Z}^T \mathbf{A} \mathbf{Z} . \tag{9.6} $$
#
# ### 09.2 The least eigenvalue
#
# Write (9.6) for any symmetric $\mathbf{A}$ and any $\mathbf{P}$. Two things may happen:
# $\mathbf{P}$ may have no columns, and its columns may depend on each other.
#
# <details><summary>Hint</summary>
#
# The full singular value decomposition $\mathbf{P} = \mathbf{U}\mathbf{S}\mathbf{V}^T$ has a square
# $\mathbf{U}$. Which of its columns are orthogonal to all columns of $\mathbf{P}$? How many of them
# there are depends on the rank of $\mathbf{P}$, which may be less than $Q$; `np.linalg.matrix_rank`
# takes a relative tolerance `rtol`. For $Q = 0$ the rank is zero; some versions of NumPy refuse to
# compute it.
#
# </details>


# %% question="09.2"
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
            ylabel="least eigenvalue",
            xlim=(-1.3, 3.7),
            ylim=(-3e4, 3e3),
            xticks=degrees,
            yticks=[-1e3, -1, 0, 1, 1e3],
            title=f"$k = {k}$, fourteen points",
        )
        axes.set_xticklabels(["none", "0", "1", "2", "3"])
    return page


# %% [markdown]
# **What to look at.** For each $k$ there is a degree from which on the least eigenvalue is
# positive, and it is not a close thing: one degree less, and it is far below zero. What is that
# degree for $k = 1, \dots, 5$? The order is one more. Once the form is positive, more side
# conditions keep it so: a higher degree than needed does no harm.
#
# The rule is
#
# $$ \text{order of } \varphi_k = \lfloor k/2 \rfloor + 1 , \tag{9.7} $$
#
# in any number of variables. That it is true for all points is a theorem of Micchelli; you have
# tried fourteen.

# %% [markdown]
# ## Which points?
#
# Let the order be right. The system (9.3) has exactly one solution if, besides, no polynomial of
# degree at most $n$ vanishes at all points, except zero. Such points are called *unisolvent* for
# the degree $n$: they tell polynomials apart. For $n = 1$ that means: not all on one line. What
# does it mean for $n = 2$?
#
# ### 09.3 Polynomials that vanish
#
# A polynomial with the coefficients $\mathbf{c}$ has the values $\mathbf{P}\mathbf{c}$ at the
# points. Count how many linearly independent polynomials of degree at most $n$ vanish at all of
# them. Zero means: unisolvent.
#
# <details><summary>Hint</summary>
#
# The vectors with $\mathbf{P}\mathbf{c} = \mathbf{0}$ are a subspace. Its dimension, the rank of
# $\mathbf{P}$, and the number of columns of $\mathbf{P}$ have something to do with each other. In a
# small box monomials are small numbers, so a tolerance has to be relative.
#
# </details>


# %% question="09.3"
def vanishing(points, degree):
    """Return how many independent polynomials up to a degree vanish at points (N, 2)."""
    # BEGIN SOLUTION
    p = monomials(points, degree)
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
            f"vanishing polynomials: {int(vanishing(sites, 2))}; least singular value "
            f"{singular:.1e}"
        )
    return page


# %% [markdown]
# **What to look at.** Six points, and six monomials of degree at most two. The line is where the
# quadratic polynomial is zero that is smallest at the points, among those with
# $\lVert\mathbf{c}\rVert = 1$. If the six lie on one ellipse, it vanishes at all of them, and
# quadratics cannot be told apart. Move the orange point off: now they can. So the points on the
# line of notebook 03 return one degree higher as points on a *conic*: an ellipse, a hyperbola, a
# parabola, or two lines.

# %% [markdown]
# ### 09.4 The field
#
# Now put it together: solve (9.3) and evaluate (9.2) at places $\mathbf{x}$. The power $k$ and the
# degree $n$ are free; with $n = -1$ there are bumps only.
#
# <details><summary>Hint</summary>
#
# How many zeros stand on the right side of (9.3)? The number of columns of $\mathbf{P}$ knows. The
# same two functions that make the matrix evaluate the field: at places $\mathbf{x}$ instead of the
# points.
#
# </details>


# %% question="09.4"
def interpolate(points, values, k, degree, x):
    """Return f of (9.2) with φ_k at x (M, 2), for points (N, 2) and values (N,)."""
    # BEGIN SOLUTION
    n = len(points)
    p = monomials(points, degree)
    q = p.shape[1]
    a = kernel(distances(points, points), k)
    system = np.block([[a, p], [p.T, np.zeros((q, q))]])
    unknown = np.linalg.solve(system, np.concatenate([values, np.zeros(q)]))
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
# **What to look at.** Each dot vanishes in its surroundings: the field goes through your values
# even where the degree is too low. There it is luck: the matrix is indefinite on the side
# conditions, and as points move an eigenvalue may pass through zero, as for the triangle at the
# beginning. (Only $k = 1$ is safe without a polynomial; *dig deeper* says why.) Compare the corners
# of the picture for the degrees 0 and 3: what does the field do far from the data?
#
# And if the degree is right but the points are not? Here five points lie on a line, with the kernel
# $r^2\log r$ and $n = 1$. The plane $x_1 - x_2$ vanishes at all of them. Add as much of it as you
# like.


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
# **What to look at.** Both fields solve the system. On the line they agree, elsewhere nothing
# decides between them.

# %% [markdown]
# ## How many variables?
#
# The kernels $\varphi_k$ never end: each point feels every other one, and the matrix is full.
# Wendland found kernels that are zero beyond the distance 1, so that most entries of $\mathbf{A}$
# are zero, and that need no polynomial. With $y_+ = \max(y, 0)$,
#
# $$ \ell = \lfloor D/2 \rfloor + s + 1, \qquad \psi_{D,0}(r) = (1-r)_+^{\ell}, \qquad
#    \psi_{D,1}(r) = (1-r)_+^{\ell+1} \bigl( (\ell+1)\, r + 1 \bigr) . \tag{9.8} $$
#
# Here $D$ is the number of variables, and $s$ tells how smooth the field is: continuous for $s =
# 0$, with two continuous derivatives for $s = 1$. The second family comes from the first by an
# integral,
#
# $$ \psi_{D,1}(r) = C \int_r^\infty t\, \psi_{D+2,0}(t)\, dt , \tag{9.9} $$
#
# where $C$ makes $\psi_{D,1}(0) = 1$. They are positive definite in up to $D$ variables, and that
# is all that is promised.
#
# ### 09.5 Wendland's functions
#
# Write (9.8) for $s = 0$ and $s = 1$. The brackets $\lfloor\;\rfloor$ mean: round down.


# %% question="09.5"
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
@draw(d=Slider(1, 3, 1, "made for D", whole=True), s=Slider(0, 1, 0, "smoothness s", whole=True))
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
        right.set(xlabel="step of the lattice", title="least eigenvalue", ylim=(-0.75, 1.05))
        right.legend(loc="center left", bbox_to_anchor=(1, 0.5))
    return page


# %% [markdown]
# **What to look at.** Lattices of points in one, two and three variables, and the matrix of your
# function at them. $\psi_{1,0} = (1-r)_+$ is made for the line. In the plane its matrix has a
# negative eigenvalue, in space a large one, although all points are distinct. The others stay above
# zero on these lattices. A trial that finds nothing proves nothing, though: $\psi_{1,1}$ is not
# positive definite in two variables either, but only a lattice of some two thousand points shows
# it.

# %% [markdown]
# ## Two points change places
#
# Why does one need kernels at all? Why not fix $N$ functions once and for all, as the polynomials
# of degree $N - 1$ on the line, and combine them to go through any $N$ values? On the line that
# works at all distinct points. In the plane it cannot, whichever functions one takes. This is the
# theorem of *Mairhuber and Curtis*, and its proof is a film.
#
# Let $\mathbf{m} = \tfrac12(\mathbf{p}_1 + \mathbf{p}_2)$. The first two points travel around
# $\mathbf{m}$ counterclockwise, along the two halves of a circle, until they have changed places;
# $\mathbf{p}_3$ stays:
#
# $$ \mathbf{p}_{1,2}(t) = \mathbf{m} + \begin{bmatrix} \cos \pi t & -\sin \pi t \\ \sin \pi t &
#    \cos \pi t \end{bmatrix}
#    (\mathbf{p}_{1,2} - \mathbf{m}), \qquad 0 \leq t \leq 1. \tag{9.10} $$
#
# ### 09.6 When does it fail?
#
# The functions $1, x_1, x_2$ cannot go through any three values when the three points lie on one
# line. Return the time $t$ between 0 and 1 at which they do.
#
# <details><summary>Hint</summary>
#
# The line through the two moving points always contains $\mathbf{m}$, and it turns by the angle
# $\pi t$. In which direction is $\mathbf{p}_3$, seen from $\mathbf{m}$? `np.arctan2(y, x)` is the
# angle of a vector; a line that has turned by $\pi$ is the same line. Or search: the sign of a
# determinant differs at the two ends.
#
# </details>


# %% question="09.6"
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
def film(t):
    (three,) = data("09.6")
    three = (three - three.mean(axis=0)) / np.ptp(three, axis=0).max()

    def moved(time):
        z = three[:, 0] + 1j * three[:, 1]
        middle = (z[0] + z[1]) / 2
        z[:2] = middle + np.exp(1j * np.pi * time) * (z[:2] - middle)
        return np.stack([z.real, z.imag], axis=1)

    times = np.linspace(0, 1, 101)
    plain = np.array([np.linalg.det(monomials(moved(u), 1)) for u in times])
    bumps = np.array(
        [np.linalg.det(np.exp(-4 * distances(moved(u), moved(u)) ** 2)) for u in times]
    )
    with figure(6.4, 3.3) as page:
        left, right = page.subplots(1, 2, width_ratios=[1, 1.4])
        now = moved(t)
        for j in (0, 1):
            left.plot(*np.array([moved(u)[j] for u in times]).T, color=GREY, lw=0.8, ls=":")
        turned = np.linalg.det(monomials(now, 1)) > 0
        left.fill(*now.T, color=BLUE if turned else ORANGE, alpha=0.3)
        for number, spot in zip("123", now, strict=True):
            left.plot(*spot, "o", color="black", ms=12)
            left.annotate(number, spot, color="white", ha="center", va="center", fontsize=8)
        left.set(aspect="equal", xticks=[], yticks=[], title=f"$t = {t:.2f}$")
        left.margins(0.12)
        left.spines[:].set_visible(False)
        right.axhline(0, color=GREY, lw=0.8)
        right.plot(times, plain / np.abs(plain).max(), color=BLUE, label="$1, x_1, x_2$")
        right.plot(
            times, bumps / np.abs(bumps).max(), color=GREEN, ls="--", label="three Gaussians"
        )
        right.axvline(t, color=PURPLE, lw=1)
        right.plot(exchange_time(three), 0, "o", mfc="none", ms=9, color=ORANGE, label="your time")
        right.set(xlabel="time $t$", title="determinant, over its largest size", ylim=(-1.15, 1.15))
        right.legend(
            loc="upper center", bbox_to_anchor=(0.4, -0.2), ncols=3, fontsize=9, columnspacing=1
        )
    return page


# %% [markdown]
# **What to look at.** Three points of your own. Move the time from 0 to 1. The triangle is turned
# over, so it must have been flat on the way: there the determinant of $1, x_1, x_2$ at the three
# points vanishes. At the end two rows of the matrix have been exchanged. The Gaussians sit on the
# points and travel with them, so that rows *and* columns are exchanged.

# %% [markdown]
# ## Slopes are data too
#
# Nothing so far needs values. Any linear measurements will do, if they are independent. Take one
# variable, points $x_1, \dots, x_N$, and at each of them a value $v_i$ and a slope $g_i$. The bump
# of a value is $\varphi(x - y)$ with $y$ at the point. The bump of a slope is its derivative **by
# $y$**. With $\varphi(z) = \lvert z \rvert^3$, whose derivatives are $\varphi'(z) = 3z\lvert z
# \rvert$ and $\varphi''(z) = 6\lvert z \rvert$, and of order two,
#
# $$ f(x) = \sum_j \lambda_j\, \lvert x - x_j \rvert^3 - \sum_j \mu_j\, 3 (x - x_j) \lvert x - x_j
#    \rvert + c_0 + c_1 x . \tag{9.11} $$
#
# The side conditions pair the same measurements with $1$ and $x$: $\sum_j \lambda_j = 0$ and
# $\sum_j (\lambda_j x_j + \mu_j) = 0$, since the slope of $1$ is $0$ and that of $x$ is $1$. With
# $z_{ij} = x_i - x_j$ the conditions $f(x_i) = v_i$ and $f'(x_i) = g_i$ give
#
# $$ \begin{bmatrix} \varphi(z_{ij}) & -\varphi'(z_{ij}) & 1 & x_i \\
#    \varphi'(z_{ij}) & -\varphi''(z_{ij}) & 0 & 1 \\
#    1 & 0 & 0 & 0 \\
#    x_j & 1 & 0 & 0 \end{bmatrix}
#    \begin{bmatrix} \boldsymbol{\lambda} \\ \boldsymbol{\mu} \\ c_0 \\ c_1 \end{bmatrix} =
#    \begin{bmatrix} \mathbf{v} \\ \mathbf{g} \\ 0 \\ 0 \end{bmatrix} , \tag{9.12} $$
#
# where each entry stands for a block: of $N \times N$ numbers in the first two rows and columns, of
# $N$ numbers beside and below them.
#
# ### 09.7 The matrix for values and slopes
#
# Write the matrix of (9.12). It is symmetric; look at the signs, and you see why.
#
# <details><summary>Hint</summary>
#
# `np.block` takes the blocks row by row, as they stand. A block for $x_i$ needs the shape $(N, 1)$.
# What is $\varphi'(-z)$?
#
# </details>


# %% question="09.7"
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
    places = np.linspace(-0.5, 3.5, 400)
    z = np.subtract.outer(places, x)
    field = (
        np.abs(z) ** 3 @ found[:5]
        - 3 * (z * np.abs(z)) @ found[5:10]
        + found[10]
        + found[11] * places
    )
    with figure(6.4, 2.8) as page:
        axes = page.subplots()
        for j in (0, 2):
            axes.axvspan(x[j], x[j + 1], color=GREY, alpha=0.12, lw=0)
        axes.plot(places, field, color=BLUE)
        for a, value, rise in zip(x, v, g, strict=True):
            reach = 0.22 / np.hypot(1, rise) * np.array([-1, 1])
            axes.plot(a + reach, value + rise * reach, color=ORANGE, lw=2.5)
        axes.plot(x, v, "o", color="black")
        axes.set(xlabel="$x$", ylabel="$f$", xlim=(-0.5, 3.5), ylim=(-1.6, 2.6))
    return page


# %% [markdown]
# **What to look at.** The curve has the values and the slopes. Which parts of it move when you
# change the slope of the third point, and which do not? Every bump in (9.11) reaches everywhere,
# and yet the answer is local. Between two neighbours the curve is the cubic that their two values
# and two slopes determine, as in every textbook on interpolation; outside it is straight.
#
# ## In words
#
# **09.8** A program uses $\varphi_3 = r^3$ with the constant alone, $n = 0$, instead of $n = 1$. It
# has worked on every set of points so far. What has been lost? Say what can go wrong, and give an
# example of a kernel and of distinct points for which a degree that is too low fails altogether. Is
# it a mistake to take $n = 2$ for $r^3$?
#
# <details><summary>Hint</summary>
#
# Think of two sets of points, one of which has a positive determinant and the other a negative one,
# and of a path between them. For the example look at the first picture.
#
# </details>

# %% [markdown] answer="09.8" points=4
# The promise has been lost. $r^3$ has the order two: only if the $\lambda_j$ annihilate constants
# and linear functions is $\boldsymbol\lambda^T\mathbf{A}\boldsymbol\lambda$ positive. Under
# $\sum\lambda_j = 0$ alone the form has both signs, as the picture of both sides shows, so its
# eigenvalues may pass through zero as points move: for some distinct points the matrix is singular,
# and near them the factors are huge and the field swings. Nor is the field any longer that of least
# energy, and far away it grows faster than a plane.
#
# For $r^3$ itself, with $n = 0$, such points are the corners of a triangle with the sides $1$, $1$
# and $2^{2/3}$.
#
# *Another example.* $r^2\log r$ without a polynomial (order two, $n = -1$): for the corners of an
# equilateral triangle with the side 1 all distances are 0 or 1, $\varphi_2$ vanishes at both,
# $\mathbf{A} = \mathbf{0}$, and no values but zero can be met.
#
# $n = 2$ is no mistake. More side conditions leave fewer $\boldsymbol\lambda$, and a form that is
# positive on a space is positive on a smaller one. But the points must be unisolvent for
# quadratics: at least six in the plane, not on a conic; and the field may grow quadratically
# outside.

# %% [markdown] rubric="09.8"
# One point: the form is no longer positive under fewer conditions (indefinite). One: hence singular
# at some distinct points, although it may work at most. One for an example that is right, with a
# reason. One: a higher degree is allowed, the points must then be unisolvent for it.

# %% [markdown]
# **09.9** One often reads that (9.3) can be solved if and only if the points are unisolvent. Five
# points lie on a line of the plane, the kernel is of order two, $n = 1$. Does (9.3) have a
# solution? For all values? Which part of it is unique, and what should a program do?
#
# <details><summary>Hint</summary>
#
# Multiply the first row of (9.3) by $\mathbf{Z}^T$. Which matrix is left, and can it be inverted?
# Then ask in which space $\mathbf{v} - \mathbf{A}\boldsymbol{\lambda}$ lies.
#
# </details>

# %% [markdown] answer="09.9" points=3
# It has a solution for all values. With $\boldsymbol\lambda = \mathbf{Z}\mathbf{t}$ the first row
# becomes $\mathbf{Z}^T\mathbf{A}\mathbf{Z}\,\mathbf{t} = \mathbf{Z}^T\mathbf{v}$, whose matrix is
# positive definite, since the points are distinct and the order is right. So $\mathbf{t}$, and with
# it $\boldsymbol\lambda$, exists and is unique. What is left, $\mathbf{v} -
# \mathbf{A}\boldsymbol\lambda$, is orthogonal to $\mathbf{Z}$, and hence in the range of
# $\mathbf{P}$: there is a $\mathbf{c}$ with $\mathbf{P}\mathbf{c}$ equal to it.
#
# $\mathbf{c}$ is not unique: one may add the coefficients of a linear function that vanishes on the
# line. On the line the field is determined, off the line it is not.
#
# A program should refuse, or say which solution it takes and why (such as the shortest
# $\mathbf{c}$, or no slope across the line). It should not solve a singular system by elimination
# and return what rounding has made of it.

# %% [markdown] rubric="09.9"
# One point: a solution exists for all values, with a reason. One: the factors of the bumps are
# unique, the polynomial is not (a polynomial that is zero at the points may be added). One for a
# sensible reaction of a program: refuse, tell, or choose by a stated rule.

# %% [markdown]
# **09.10** Finish the proof of Mairhuber and Curtis: why can no three continuous functions on the
# plane, not even others than $1, x_1, x_2$, go through any values at any three distinct points?
# Where does the proof fail on the line, and why does it say nothing against bumps on the points?
#
# <details><summary>Hint</summary>
#
# Follow the determinant of the matrix with the entries $g_l(\mathbf{p}_i(t))$ from $t = 0$ to $t =
# 1$. What does the exchange of two rows do to a determinant? And of two rows and two columns?
#
# </details>

# %% [markdown] answer="09.10" points=3
# Let $g_1, g_2, g_3$ be continuous, and $d(t)$ the determinant of the matrix with the entries
# $g_l(\mathbf{p}_i(t))$. It is continuous. At $t = 1$ the first two points have changed places, two
# rows of the matrix are exchanged, and $d(1) = -d(0)$. So $d$ vanishes somewhere in between, while
# the three points are distinct all the time, if $\mathbf{p}_3$ is not on the circle. There the
# matrix is singular, and for some values there is no interpolant. With more points choose the
# circle so small that it meets none of the others.
#
# On the line the two points cannot change places without meeting each other, and there the matrix
# has two equal rows anyway. One variable has no room to step aside.
#
# With bumps the functions depend on the points: $g_l(\mathbf{x}) = \varphi(\lVert\mathbf{x} -
# \mathbf{p}_l(t)\rVert)$. The exchange swaps two rows and two columns, the determinant keeps its
# sign, and nothing forces it through zero.

# %% [markdown] rubric="09.10"
# One point: continuous, changes its sign by the exchange of two rows, hence a zero at distinct
# points. One: on a line the points would have to meet. One: bumps move with the points, rows and
# columns are exchanged, the sign stays.

# %% [markdown]
# ## Dig deeper
#
# - $-r$ has the order one. Compute the eigenvalues of its matrix $\mathbf{A}$ alone, without any
#   polynomial. How many are negative? Why is it never singular at distinct points? (Its trace is
#   zero.)
# - $\varphi(r) = -r^2$ has a form that is never negative if $\sum\lambda_j = 0$. Try it in
#   `least_eigenvalue`. Expand $\lVert\mathbf{p}_i - \mathbf{p}_j\rVert^2$: for which
#   $\boldsymbol{\lambda}$ is the form zero? Why does no even power of $r$ serve without a
#   logarithm?
# - Multiply all points by 1000. By what factor do the least eigenvalues of $\varphi_3$ change? And
#   does the field of 09.4?
# - The film with six points and the polynomials of degree two: when is the determinant zero? Draw
#   the conic.
# - A Wendland function on a cloud of ten thousand points, with a radius of three spacings: what
#   part of the matrix is not zero? `scipy.sparse` stores only that.

# %%
progress()
