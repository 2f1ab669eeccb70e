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
# # Radial basis functions
#
# A fit by least squares misses the data. Sometimes the data are exact, and the field should go
# *through* every value. In this notebook you write the best known method that does it: a bump on
# each point, and a plane below them all. You also find out that two things which are often said
# about its system of equations are not true.
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
# ## The problem in a picture
#
# Twelve values were measured without error. A straight line misses most of them. A polynomial of
# higher degree comes closer, and with as many coefficients as values it goes through all. See what
# it does between them, and move the slider down.


# %%
@draw(degree=Slider(2, 11, 11, "degree", whole=True))
def the_problem(degree):
    random = np.random.default_rng(3)
    x = (np.arange(12) + 0.7 * random.random(12)) / 12
    values = np.sin(4 * x) + (x > 0.5) * 0.6
    side = np.linspace(0, 1, 400)
    with figure(6.4, 2.8) as page:
        axes = page.subplots()
        for k, color in ((1, GREY), (degree, ORANGE)):
            polynomial = np.polynomial.Polynomial.fit(x, values, k)
            axes.plot(side, polynomial(side), color=color, label=f"degree {k}")
        axes.plot(x, values, "o", color=BLUE, label="measured")
        axes.set(xlabel="place $x$", ylabel=r"value $\phi$", xlim=(0, 1), ylim=(-2, 3))
        axes.legend(loc="lower left", ncols=3)
    return page


# %% [markdown]
# ## The idea
#
# Think of a thin sheet of metal that is pressed onto pins of given heights. It goes through all of
# them, and since it resists bending it does not swing in between. Far from the pins it is flat.
#
# The shape of such a sheet round a single pin is the *thin-plate spline*
#
# $$ w(\mathbf{y}) = \lVert\mathbf{y}\rVert^2 \log \lVert\mathbf{y}\rVert^2 ,
#    \qquad w(\mathbf{0}) = 0 . \tag{3.1} $$
#
# The logarithm is the natural one. It does not exist at zero, but the product has the limit zero,
# and that is what $w(\mathbf{0})$ stands for.
#
# ### 03.1 The kernel
#
# Write $w$ for any number of vectors at once. The last axis holds the coordinates: an array of
# shape $(5, 2)$ is five vectors of the plane, one of shape $(4, 6, 3)$ four times six in space.
#
# <details><summary>Hint</summary>
#
# What is zero can be left as it is: begin with zeros, and compute only where there is something to
# compute. A condition such as `squared > 0` is an array, and an array can be indexed by it.
#
# </details>


# %% question="03.1"
def kernel(y):
    """Return w of (3.1), of shape (...), for vectors y of shape (..., D)."""
    # BEGIN SOLUTION
    squared = np.sum(y**2, axis=-1)
    w = np.zeros(squared.shape)
    away = squared > 0
    w[away] = squared[away] * np.log(squared[away])
    return w
    # END SOLUTION


# %%
check("03.1")


# %%
@draw()
def one_bump():
    side = np.linspace(-1.4, 1.4, 71)
    with figure(6.4, 2.7) as page:
        section, plan = page.subplots(1, 2)
        section.axhline(0, color=GREY, lw=0.8)
        section.plot(side, kernel(np.stack([side, 0 * side], axis=1)), color=BLUE)
        section.set(xlabel="$y_1$, with $y_2 = 0$", ylabel=r"$w(\mathbf{y})$")
        grid = np.stack(np.meshgrid(side, side), axis=-1)
        image = plan.contourf(side, side, kernel(grid), np.linspace(-0.4, 1.4, 19), extend="max")
        image.set_rasterized(True)
        plan.contour(side, side, kernel(grid), levels=[0], colors="white", linewidths=1)
        plan.set(xlabel="$y_1$", ylabel="$y_2$", aspect="equal")
        page.colorbar(image, ax=plan, label="$w$", ticks=[-0.4, 0, 0.5, 1])
    return page


# %% [markdown]
# **What to look at.** This bump is no hill that fades away. It is zero at the pin and on the unit
# circle (white), negative between them, and beyond it grows without end. A sum of such functions
# would grow as well, unless something keeps it in check.

# %% [markdown]
# ## The system
#
# Let $\mathbf{p}_1, \dots, \mathbf{p}_N \in \mathbb{R}^D$ be the places and $\phi_1, \dots, \phi_N$
# the values. The field is a bump on each place, with a factor of its own, and an affine field:
#
# $$ f(\mathbf{x}) = \mathbf{b}(\mathbf{x})^T\mathbf{c} +
#    \sum_{j=1}^N \lambda_j\, w(\mathbf{x} - \mathbf{p}_j), \qquad
#    \mathbf{b}(\mathbf{x}) = (1, x_1, \dots, x_D)^T . \tag{3.2} $$
#
# There are $N$ unknown $\lambda_j$ and $D + 1$ unknown $c_k$. It shall go through the values,
#
# $$ f(\mathbf{p}_i) = \phi_i, \qquad i = 1, \dots, N, \tag{3.3} $$
#
# which are $N$ conditions. The others are the *orthogonality constraints*
#
# $$ \sum_{j=1}^N \lambda_j\, \mathbf{b}(\mathbf{p}_j) = \mathbf{0} . \tag{3.4} $$
#
# With $A_{ij} = w(\mathbf{p}_i - \mathbf{p}_j)$ and the matrix $\mathbf{B}$ whose rows are
# $\mathbf{b}(\mathbf{p}_i)^T$, all of them together are
#
# $$ \underbrace{\begin{bmatrix} \mathbf{A} & \mathbf{B} \\ \mathbf{B}^T & \mathbf{0} \end{bmatrix}
#    }_{\mathbf{H}_{\mathrm{RBF}}}
#    \begin{bmatrix} \boldsymbol{\lambda} \\ \mathbf{c} \end{bmatrix} =
#    \begin{bmatrix} \boldsymbol{\phi} \\ \mathbf{0} \end{bmatrix} . \tag{3.5} $$
#
# ### 03.2 The matrix
#
# Write $\mathbf{H}_{\mathrm{RBF}}$. First say how many rows it has.
#
# <details><summary>Hint</summary>
#
# `points[:, None]` has the shape $(N, 1, D)$. What is the shape of the difference of it and
# `points`, and what is in it? Blocks are put together by `np.block`.
#
# </details>


# %% question="03.2"
def system_matrix(points):
    """Return H_RBF of (3.5) for points of shape (N, D)."""
    # BEGIN SOLUTION
    n, d = points.shape
    a = kernel(points[:, np.newaxis] - points)
    b = np.hstack([np.ones((n, 1)), points])
    return np.block([[a, b], [b.T, np.zeros((d + 1, d + 1))]])
    # END SOLUTION


# %%
check("03.2")


# %%
@draw(number=Slider(3, 40, 16, "points", whole=True))
def the_matrix(number):
    points = np.random.default_rng(5).random((number, 2))
    h = system_matrix(points)
    with figure(4.6, 3.6) as page:
        axes = page.subplots()
        image = axes.imshow(h, cmap="PuOr_r", vmin=-1, vmax=1)
        for place in (axes.axhline, axes.axvline):
            place(number - 0.5, color="black", lw=0.8)
        axes.set(title=f"{len(h)} rows for {number} points", xticks=[], yticks=[])
        page.colorbar(image, ax=axes)
    return page


# %% [markdown]
# **What to look at.** Four blocks. The diagonal of the first one is zero, since $w(\mathbf{0}) =
# 0$, and so is the whole last block: there is not one number other than zero on the diagonal of
# $\mathbf{H}_{\mathrm{RBF}}$. Keep that in mind for question 03.5.

# %% [markdown]
# ### 03.3 The coefficients
#
# Solve (3.5). Return the two parts of the unknown one by one.


# %% question="03.3"
def coefficients(points, values):
    """Return (λ, c) of (3.5), of shapes (N,) and (D + 1,), for points (N, D) and values (N,)."""
    # BEGIN SOLUTION
    n, d = points.shape
    right = np.concatenate([values, np.zeros(d + 1)])
    unknown = np.linalg.solve(system_matrix(points), right)
    return unknown[:n], unknown[n:]
    # END SOLUTION


# %%
check("03.3")

# %% [markdown]
# ### 03.4 The field
#
# Evaluate (3.2) at many places at once. Some of them may be points of the data.


# %% question="03.4"
def evaluate(points, lam, c, x):
    """Return f of (3.2) at places x of shape (M, D), as an array of shape (M,)."""
    # BEGIN SOLUTION
    return c[0] + x @ c[1:] + kernel(x[:, np.newaxis] - points) @ lam
    # END SOLUTION


# %%
check("03.4")

# %% [markdown]
# ## Look at it
#
# The data of the first picture again, and your own functions. Move the height of the orange point,
# and change the number of points.


# %%
@draw(
    height=Slider(-1.5, 2.5, 0.3, "height"),
    number=Slider(4, 12, 12, "points", whole=True),
)
def through_all_points(height, number):
    random = np.random.default_rng(3)
    x = (np.arange(12) + 0.7 * random.random(12)) / 12
    values = np.sin(4 * x) + (x > 0.5) * 0.6
    shown = np.linspace(0, 11, number).round().astype(int)
    moved = number // 2
    x, values = np.stack([x, values])[:, shown]
    side = np.linspace(-0.2, 1.2, 500)
    with figure(6.4, 2.9) as page:
        axes = page.subplots()
        for color, style in ((GREY, "--"), (BLUE, "-")):
            lam, c = coefficients(x[:, None], values)
            label = "your field" if style == "-" else "as measured"
            axes.plot(
                side, evaluate(x[:, None], lam, c, side[:, None]), style, color=color, label=label
            )
            values[moved] = height
        axes.plot(x, values, "o", color=BLUE)
        axes.plot(x[moved], height, "o", ms=9, color=ORANGE, label="moved")
        axes.set(xlabel="place $x$", ylabel=r"value $\phi$", xlim=(-0.2, 1.2), ylim=(-2.6, 3))
        axes.legend(loc="lower left", ncols=3)
    return page


# %% [markdown]
# **What to look at.** The curve goes through every point, wherever you put the orange one. The
# change is felt by all of the curve, but little far away. Outside the data the curve becomes
# straight. And between them it swings no more than the data demand.
#
# In the plane the points below are your own.


# %%
@draw()
def surface():
    points, values = data("03.3")
    lam, c = coefficients(points, values)
    side = np.linspace(-0.1, 1.1, 61)
    grid = np.stack(np.meshgrid(side, side), axis=-1)
    field = evaluate(points, lam, c, grid.reshape(-1, 2)).reshape(61, 61)
    with figure(5.4, 4.0) as page:
        axes = page.subplots()
        image = axes.contourf(side, side, field, levels=20)
        image.set_rasterized(True)
        axes.scatter(*points.T, c=values, norm=image.norm, ec="white", s=70)
        axes.set(
            xlabel="$x_1$",
            ylabel="$x_2$",
            aspect="equal",
            title="dots: the data, in the same colours",
        )
        page.colorbar(image, ax=axes, label="$f$")
    return page


# %% [markdown]
# Each dot should vanish in its surroundings but for its white rim.
#
# ## What the constraints are for
#
# Could one do with less? $\mathbf{A}\boldsymbol{\lambda} = \boldsymbol{\phi}$ alone is a system of
# $N$ equations for $N$ unknowns: only bumps, no plane, no constraints. Here both fields are seen
# along the line $x_2 = 0.5$, with your own points. Slide the edge outwards.


# %%
@draw(reach=Slider(1, 1000, 4, "edge", logarithmic=True))
def far_away(reach):
    points, values = data("03.3")
    n = len(points)
    lam, c = coefficients(points, values)
    bumps = np.linalg.solve(system_matrix(points)[:n, :n], values)
    side = np.linspace(-reach, reach, 401)
    line = np.stack([side, 0 * side + 0.5], axis=1)
    with figure(6.4, 3.0) as page:
        axes = page.subplots()
        axes.axvspan(0, 1, color=GREY, alpha=0.25, lw=0, label="here are the data")
        axes.plot(side, evaluate(points, bumps, 0 * c, line), color=ORANGE, label="bumps alone")
        axes.plot(side, evaluate(points, lam, c, line), color=BLUE, label="bumps and a plane")
        axes.set(xlabel="$x_1$", ylabel="$f$", xlim=(-reach, reach))
        axes.legend()
    return page


# %% [markdown]
# **What to look at.** Both go through the data. Between the points they may look alike; beyond them
# they have nothing in common: one grows like $R^2 \log R$ with the distance $R$, the other no
# faster than a plane.

# %% [markdown]
# ## When does it work?
#
# One often reads that $\mathbf{H}_{\mathrm{RBF}}$ is symmetric and positive definite, so that (3.5)
# always has exactly one solution. Symmetric it is. For the rest, count: a symmetric matrix is
# positive definite if all its eigenvalues are positive, and it can be inverted if none is zero.
#
# ### 03.5 The signs of the eigenvalues
#
# Write a function that returns how many eigenvalues of $\mathbf{H}_{\mathrm{RBF}}$ are positive,
# how many negative, and how many zero. A computed eigenvalue is never quite zero; take for zero
# what is much smaller than the largest.
#
# <details><summary>Hint</summary>
#
# `numpy.linalg` has a function for eigenvalues of symmetric matrices, which are real. What
# difference to the largest would you ascribe to rounding, if numbers have sixteen digits?
#
# </details>


# %% question="03.5"
def inertia(points):
    """Return the numbers of positive, negative and zero eigenvalues of H_RBF, for points (N, D)."""
    # BEGIN SOLUTION
    eigenvalues = np.linalg.eigvalsh(system_matrix(points))
    relative = eigenvalues / np.ptp(eigenvalues)
    positive, negative = np.sum(relative > 1e-10), np.sum(relative < -1e-10)
    return positive, negative, len(relative) - positive - negative
    # END SOLUTION


# %%
check("03.5")


# %%
@draw(height=Slider(1e-10, 1, 1, "height", logarithmic=True))
def flattened(height):
    points = np.random.default_rng(7).random((12, 2)) * np.array([1, height])
    h = system_matrix(points)
    spectrum = np.linalg.eigvalsh(h)
    number = np.arange(1, len(spectrum) + 1)
    told = "{} positive, {} negative, {} zero".format(*(int(k) for k in inertia(points)))
    with figure(6.4, 3.0) as page:
        axes = page.subplots()
        for sign, color, marker, label in (
            (1, BLUE, "o", "positive"),
            (-1, ORANGE, "v", "negative"),
        ):
            chosen = sign * spectrum > 0
            axes.semilogy(
                number[chosen], np.abs(spectrum[chosen]), marker, color=color, label=label
            )
        axes.set(xlabel="number of the eigenvalue", ylabel="size", ylim=(1e-18, 1e2), title=told)
        axes.legend(loc="lower right")
    return page


# %% [markdown]
# **What to look at.** Twelve points of a box whose height you choose. How many eigenvalues are
# negative? Make the box flatter, until all points lie on one line: what happens to one of them, and
# what does that mean for (3.5)?

# %% [markdown]
# ## The gradient
#
# Fields are reconstructed to be differentiated: a force is the gradient of a pressure. From (3.2)
#
# $$ \nabla f(\mathbf{x}) = (c_1, \dots, c_D)^T +
#    \sum_{j=1}^N \lambda_j\, \nabla w(\mathbf{x} - \mathbf{p}_j) . \tag{3.6} $$
#
# ### 03.6 The gradient
#
# Find $\nabla w$ with pen and paper, with the product rule and the chain rule. What is its limit
# for $\mathbf{y} \to \mathbf{0}$? Then write (3.6). It must hold at the points of the data too.
#
# <details><summary>Hint</summary>
#
# Call $s = \lVert\mathbf{y}\rVert^2 = y_1^2 + \dots + y_D^2$. What is $\partial s / \partial y_k$,
# and what is the derivative of $s \log s$ by $s$?
#
# </details>


# %% question="03.6"
def gradient(points, lam, c, x):
    """Return the gradient (3.6) at places x of shape (M, D), as an array of shape (M, D)."""
    # BEGIN SOLUTION
    y = x[:, np.newaxis] - points
    squared = np.sum(y**2, axis=-1)
    factor = np.zeros(squared.shape)
    away = squared > 0
    factor[away] = 2 * (1 + np.log(squared[away]))
    return c[1:] + np.einsum("mn,mnd->md", factor * lam, y)
    # END SOLUTION


# %%
check("03.6")


# %%
@draw()
def arrows():
    points, values = data("03.3")
    lam, c = coefficients(points, values)
    side, coarse = np.linspace(0, 1, 81), np.linspace(0.03, 0.97, 15)
    grid = np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2)
    places = np.stack(np.meshgrid(coarse, coarse), axis=-1).reshape(-1, 2)
    with figure(4.4, 4.2) as page:
        axes = page.subplots()
        field = evaluate(points, lam, c, grid).reshape(81, 81)
        axes.contour(side, side, field, levels=16, cmap="viridis", linewidths=1.2)
        axes.quiver(
            *places.T, *gradient(points, lam, c, places).T, color=GREY, width=0.005, scale=120
        )
        axes.plot(*points.T, "o", color=ORANGE)
        axes.set(
            xlabel="$x_1$",
            ylabel="$x_2$",
            aspect="equal",
            xlim=(0, 1),
            ylim=(0, 1),
            title="dots: the data",
        )
    return page


# %% [markdown]
# **What to look at.** The arrows stand at right angles to the level lines, and they are long where
# the lines are close.
#
# ## The energy of bending
#
# Why this kernel, of all? In the plane, among all functions that go through the values, (3.2) is
# the one that bends least: its *bending energy*
#
# $$ E = \int_{\mathbb{R}^2} \Bigl( \frac{\partial^2 f}{\partial x_1^2} \Bigr)^2 +
#    2 \Bigl( \frac{\partial^2 f}{\partial x_1 \partial x_2} \Bigr)^2 +
#    \Bigl( \frac{\partial^2 f}{\partial x_2^2} \Bigr)^2 \, d\mathbf{x} =
#    16\pi\, \boldsymbol{\lambda}^T \mathbf{A} \boldsymbol{\lambda} \tag{3.7} $$
#
# is the smallest possible. The integral over the whole plane is finite only because of (3.4).
#
# ### 03.7 The energy
#
# Write $E$ for points of the plane and their values.


# %% question="03.7"
def energy(points, values):
    """Return E of (3.7), a number, for points (N, 2) and values (N,)."""
    # BEGIN SOLUTION
    lam = coefficients(points, values)[0]
    a = kernel(points[:, np.newaxis] - points)
    return 16 * np.pi * lam @ a @ lam
    # END SOLUTION


# %%
check("03.7")


# %%
@draw(which=Slider(1, 12, 5, "point", whole=True))
def one_value_changed(which):
    points, values = data("03.3")
    i = which - 1
    others = np.delete(points, i, axis=0)
    lam, c = coefficients(others, np.delete(values, i))
    foretold = evaluate(others, lam, c, points[[i]])[0]
    heights = np.linspace(-4, 4, 81)
    energies = [energy(points, np.r_[values[:i], height, values[which:]]) for height in heights]
    with figure(6.4, 2.9) as page:
        axes = page.subplots()
        axes.plot(heights, energies, color=BLUE, label="energy")
        axes.axvline(values[i], color=PURPLE, ls=":", label="its measured value")
        axes.axvline(foretold, color=GREEN, ls="--", label="the field of the others there")
        axes.set(xlabel=f"value at point {which}", ylabel="$E$", ylim=(0, None))
        axes.legend(loc="center left", bbox_to_anchor=(1, 0.5))
    return page


# %% [markdown]
# **What to look at.** The value of one of your points is changed and the others are kept. The
# energy is a parabola, never negative, and it is smallest exactly where the field that knows
# nothing of this point would have put it. How large is the $\lambda_j$ of that point then?
#
# ## In words
#
# **03.8** Discuss the role of the orthogonality constraints (3.4). What would be lost without them?
#
# <details><summary>Hint</summary>
#
# Four things can be said: about the number of equations, about data that are affine, about places
# far away, about whether there is one solution only. For the last, let
# $\mathbf{A}\boldsymbol{\lambda} + \mathbf{B}\mathbf{c} = \mathbf{0}$, multiply by
# $\boldsymbol{\lambda}^T$ from the left, and use that
# $\boldsymbol{\lambda}^T\mathbf{A}\boldsymbol{\lambda}$ is an energy.
#
# </details>

# %% [markdown] answer="03.8" points=4
# *Counting.* The field has $N + D + 1$ unknowns and goes through $N$ values; the constraints are
# the $D + 1$ equations that lack.
#
# *Affine data.* If $\phi_i = \mathbf{b}(\mathbf{p}_i)^T\mathbf{a}$, then $\boldsymbol{\lambda} =
# \mathbf{0}$, $\mathbf{c} = \mathbf{a}$ satisfies all equations. So affine fields are reproduced
# exactly; bumps alone do not do that.
#
# *Far away.* Each bump grows like $R^2 \log R$. Expanded for large $R$, the fastest terms carry the
# factors $\sum_j \lambda_j$ and $\sum_j \lambda_j \mathbf{p}_j$, which (3.4) makes zero. What is
# left grows no faster than the plane, and the energy of bending is finite.
#
# *Uniqueness.* For vectors that satisfy (3.4),
# $\boldsymbol{\lambda}^T\mathbf{A}\boldsymbol{\lambda}$ is positive unless $\boldsymbol{\lambda} =
# \mathbf{0}$, if the points are distinct. With zero values (3.5) gives
# $\boldsymbol{\lambda}^T\mathbf{A}\boldsymbol{\lambda}
# = -(\mathbf{B}^T\boldsymbol{\lambda})^T\mathbf{c}
# = 0$, hence $\boldsymbol{\lambda} = \mathbf{0}$ and then $\mathbf{B}\mathbf{c} = \mathbf{0}$.
# Without the constraints $\mathbf{A}$ may be singular: for an equilateral triangle of side one it
# is zero.
#
# They are also the conditions for the least energy, with $\mathbf{c}$ as Lagrange multipliers; and
# they make the field independent of the unit of length.

# %% [markdown] rubric="03.8"
# One point for each of four roles with a reason: as many equations as unknowns; exact for affine
# data; growth far away (or finite energy); definiteness and uniqueness. Least energy or
# independence of the unit may stand for one of them.

# %% [markdown]
# **03.9** What are the dimensions of $\mathbf{H}_{\mathrm{RBF}}$? Is it positive definite, and may
# a Cholesky factorization be used for it? When does (3.5) have exactly one solution?
#
# <details><summary>Hint</summary>
#
# For a positive definite matrix $\mathbf{v}^T\mathbf{H}\mathbf{v} > 0$ for each vector $\mathbf{v}
# \neq \mathbf{0}$. Try one with a single entry other than zero. For the last question look at your
# flattened box.
#
# </details>

# %% [markdown] answer="03.9" points=4
# $\mathbf{H}_{\mathrm{RBF}}$ is $(N + D + 1) \times (N + D + 1)$.
#
# It is symmetric but not positive definite: with the first unit vector
# $\mathbf{e}_1^T\mathbf{H}\mathbf{e}_1 = w(\mathbf{0}) = 0$. The trace is zero, so there are
# eigenvalues of both signs: $N$ positive and $D + 1$ negative ones, if the solution is unique.
# Cholesky needs the root of a positive pivot at each step and fails at the first, which is zero;
# the same holds for conjugate gradients. One takes elimination with row exchanges, or a
# factorization $\mathbf{L}\mathbf{D}\mathbf{L}^T$, or Cholesky for the part of $\mathbf{A}$ on the
# vectors that satisfy (3.4), which is positive definite.
#
# There is one solution for all values if and only if the points are distinct and no hyperplane
# holds them all: not on a line in the plane, not in a plane of space. Two equal points make two
# rows equal. On a common line an affine field that vanishes there can be added to $f$, which still
# goes through the values.

# %% [markdown] rubric="03.9"
# One point for the dimensions. One for indefinite, with a reason: zero diagonal, zero trace, or
# counted eigenvalues. One for why Cholesky fails, or what to use instead. One for distinct points
# that are in no common hyperplane.

# %% [markdown]
# ## Dig deeper
#
# - Measure your points in another unit: multiply them all by 1000, and the places $\mathbf{x}$ too.
#   Does the field change? Do $\boldsymbol{\lambda}$ and $\mathbf{c}$? Show with (3.4) why $\sum_j
#   \lambda_j \lVert\mathbf{x} - \mathbf{p}_j\rVert^2$ does not depend on $\mathbf{x}$, and what
#   that has to do with it.
# - The $\lambda_j$ are sometimes called Lagrange multipliers. Write the conditions for a minimum of
#   $\tfrac12\boldsymbol{\lambda}^T\mathbf{A}\boldsymbol{\lambda} -
#   \boldsymbol{\phi}^T\boldsymbol{\lambda}$ under (3.4). Which of the unknowns are the multipliers?
# - In space the sheet that bends least has another shape round a pin, $-\lVert\mathbf{y}\rVert$.
#   Put it in the place of $w$. What becomes of the gradient at the points of the data?
# - How does the time of `coefficients` grow with $N$? Where is the limit on your computer?

# %%
progress()
