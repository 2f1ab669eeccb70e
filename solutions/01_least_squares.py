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
# # Least squares
#
# A quantity was measured at a few scattered places. What is it in between? The simplest answer
# that uses all the measurements is one plane, laid through them so that it misses as little as
# possible. By the end of this notebook you have written that method yourself, you know when it has
# a unique answer, and you have seen where it must fail.
#
# Each question asks for a function. Write it, run its cell, and run the check below it. The check
# tells you whether it is right and, if it is not, what kind of mistake it may be.

# %% tags=["setup"]
import numpy as np

from fieldcheck import (
    BLUE,
    GREY,
    ORANGE,
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
# Below is a slice through such a field. The dots are what was measured.


# %%
@draw(places=Slider(3, 40, 12, "places", whole=True))
def the_problem(places):
    random = np.random.default_rng(1)
    x = random.random(places)
    with figure(6.4, 2.6) as page:
        axes = page.subplots()
        axes.plot(x, np.sin(4 * x) + x, "o", color=BLUE, label="measured")
        axes.plot([0.5], [0.7], marker="$?$", ms=14, color=ORANGE, label="asked for", ls="none")
        axes.set(xlabel="place $x$", ylabel=r"value $\phi$", xlim=(0, 1), ylim=(0, 2))
        axes.legend(loc="upper left")
    return page


# %% [markdown]
# ## The idea
#
# Let $\mathbf{p}_1, \dots, \mathbf{p}_N \in \mathbb{R}^D$ be the places and
# $\phi_1, \dots, \phi_N$ the values. We look for an *affine* field
#
# $$ f(\mathbf{x}) = \mathbf{b}(\mathbf{x})^T \mathbf{c}, \qquad
#    \mathbf{b}(\mathbf{x}) = (1, x_1, \dots, x_D)^T \tag{1.1} $$
#
# with $D+1$ coefficients $\mathbf{c} = (c_0, c_1, \dots, c_D)^T$. The conditions
# $f(\mathbf{p}_i) = \phi_i$ are a linear system $\mathbf{B}\mathbf{c} = \mathbf{V}$, where
#
# $$ \mathbf{B} = \begin{bmatrix} \mathbf{b}(\mathbf{p}_1)^T \\ \vdots \\ \mathbf{b}(\mathbf{p}_N)^T
#    \end{bmatrix}, \qquad
#    \mathbf{V} = \begin{bmatrix} \phi_1 \\ \vdots \\ \phi_N \end{bmatrix}. \tag{1.2} $$

# %% [markdown]
# ### 01.1 The matrix
#
# Write $\mathbf{B}$ of (1.2) for points given as an array of shape $(N, D)$.


# %% question="01.1"
def basis_matrix(points):
    """Return B of (1.2), of shape (N, D + 1), for points of shape (N, D)."""
    # BEGIN SOLUTION
    ones = np.ones((len(points), 1))
    return np.hstack([ones, points])
    # END SOLUTION


# %%
check("01.1")

# %% [markdown]
# ## The best fit
#
# With more points than coefficients the system has, as a rule, no solution. The best that can be
# done is to make the error $\boldsymbol{\varepsilon} = \mathbf{B}\mathbf{c} - \mathbf{V}$ small:
# to minimise
#
# $$ \psi(\mathbf{c}) = \tfrac{1}{2} \lVert \mathbf{B}\mathbf{c} - \mathbf{V} \rVert^2. \tag{1.3} $$
#
# Where $\psi$ is smallest its gradient vanishes, $\mathbf{B}^T(\mathbf{B}\mathbf{c} - \mathbf{V})
# = \mathbf{0}$. These are the *normal equations*
#
# $$ \mathbf{B}^T\mathbf{B}\,\mathbf{c} = \mathbf{B}^T\mathbf{V}. \tag{1.4} $$
#
# ### 01.2 The coefficients
#
# Write a function that returns the coefficients $\mathbf{c}$ of the best fit.
#
# <details><summary>Hint</summary>
#
# You have `basis_matrix`. A linear system is solved by a function of `numpy.linalg`; no inverse
# has to be formed.
#
# </details>


# %% question="01.2"
def fit(points, values):
    """Return c of (1.4), of shape (D + 1,), for points (N, D) and values (N,)."""
    # BEGIN SOLUTION
    b = basis_matrix(points)
    return np.linalg.solve(b.T @ b, b.T @ values)
    # END SOLUTION


# %%
check("01.2")

# %% [markdown]
# ### 01.3 The field
#
# Evaluate the field (1.1) at many places at once.


# %% question="01.3"
def evaluate(coefficients, x):
    """Return f of (1.1) at places x of shape (M, D), as an array of shape (M,)."""
    # BEGIN SOLUTION
    return basis_matrix(x) @ coefficients
    # END SOLUTION


# %%
check("01.3")

# %% [markdown]
# ## Look at it
#
# Now it is your functions that draw. The points are your own: they depend on the number in
# `student.txt`. Lengthen the list of powers $n$ of the field $\phi(\mathbf{x}) = (x_1 + x_2)^n$ and
# watch the plane.


# %%
@draw(n=Slider(1, 6, 2, "power n", whole=True))
def plane_and_points(n):
    points = np.random.default_rng(int(1e6 * data("01.1")[0].sum())).random((100, 2))
    values = points.sum(axis=1) ** n
    coefficients = fit(points, values)
    side = np.linspace(0, 1, 60)
    diagonal = np.stack([side, side], axis=1)
    with figure(6.4, 3.0) as page:
        axes = page.subplots()
        axes.plot(points.mean(axis=1), values, ".", color=BLUE, label="measured")
        axes.plot(side, (2 * side) ** n, color=GREY, label=r"$\phi$ along the diagonal")
        axes.plot(side, evaluate(coefficients, diagonal), color=ORANGE, label="your plane")
        axes.set(xlabel="$(x_1 + x_2)/2$", ylabel="value", title=f"$(x_1+x_2)^{n}$")
        axes.legend()
    return page


# %% [markdown]
# **What to look at.** For $n = 1$ the field is affine, and the plane goes through every point. For
# larger $n$ it cannot bend, so it errs one way in the middle and the other way at the corners. More
# points do not help: they only make the best plane better known.
#
# ### 01.4 When is the answer unique?
#
# $\mathbf{B}^T\mathbf{B}$ can be inverted exactly if the columns of $\mathbf{B}$ are linearly
# independent, that is, if its rank is $D+1$. Counting points is not enough.
#
# Write a function that returns the rank of $\mathbf{B}$. Points far from the origin must be judged
# no differently from points close to it.
#
# <details><summary>Hint</summary>
#
# Moving all points together changes neither the plane through them nor the rank. What could you
# subtract from them first?
#
# </details>


# %% question="01.4"
def rank(points):
    """Return the rank of B for points of shape (N, D), a whole number from 1 to D + 1."""
    # BEGIN SOLUTION
    centered = points - points.mean(axis=0)
    return 1 + np.linalg.matrix_rank(centered, tol=1e-9 * np.ptp(points))
    # END SOLUTION


# %%
check("01.4")

# %% [markdown]
# ### 01.5 The gradient
#
# What is the gradient of $f$ at many places? Differentiate (1.1) with pen and paper first.


# %% question="01.5"
def gradient(coefficients, x):
    """Return the gradient of f at places x of shape (M, D), as an array of shape (M, D)."""
    # BEGIN SOLUTION
    return np.tile(coefficients[1:], (len(x), 1))
    # END SOLUTION


# %%
check("01.5")

# %% [markdown]
# ### 01.6 What is minimised
#
# Write $\psi$ of (1.3). With it you can see for yourself that no other plane does better.


# %% question="01.6"
def objective(points, values, coefficients):
    """Return ψ of (1.3), a number."""
    # BEGIN SOLUTION
    residual = basis_matrix(points) @ coefficients - values
    return 0.5 * residual @ residual
    # END SOLUTION


# %%
check("01.6")


# %%
@draw()
def valley():
    random = np.random.default_rng(2)
    points, values = random.random((30, 2)), random.normal(size=30)
    best = fit(points, values)
    steps = np.linspace(-1, 1, 61)
    with figure(6.4, 2.8) as page:
        axes = page.subplots()
        for k, color in enumerate((BLUE, ORANGE, GREY)):
            rows = [objective(points, values, best + t * np.eye(3)[k]) for t in steps]
            axes.plot(steps, rows, color=color, label=f"$c_{k}$ changed")
        axes.set(xlabel="change of one coefficient", ylabel=r"$\psi$")
        axes.legend()
    return page


# %% [markdown]
# ## In words
#
# **01.7** What are the dimensions of $\mathbf{B}$, $\mathbf{c}$, $\mathbf{V}$ and
# $\mathbf{B}^T\mathbf{B}$? Under which conditions is $\mathbf{B}\mathbf{c} = \mathbf{V}$
# over-determined, and under which under-determined? Is it enough to count?
#
# <details><summary>Hint</summary>
#
# Think of a hundred points on one line of the plane.
#
# </details>

# %% [markdown] answer="01.7" points=3
# $\mathbf{B}$ is $N \times (D+1)$, $\mathbf{c}$ has $D+1$ entries, $\mathbf{V}$ has $N$, and
# $\mathbf{B}^T\mathbf{B}$ is $(D+1) \times (D+1)$. By counting, the system is over-determined for
# $N > D+1$ and under-determined for $N < D+1$. Counting is not enough: the rank of $\mathbf{B}$ is
# one more than the dimension of the smallest flat that holds all points. A hundred points on a line
# of the plane give rank 2. The system is then over-determined along the line, where the data need
# not agree, and under-determined across it, where any slope fits.

# %% [markdown] rubric="01.7"
# One point for the four dimensions. One for the two cases by counting. One for seeing that the
# affine span decides: an example such as collinear points suffices.

# %% [markdown]
# **01.8** The slides call (1.4) the method of the *pseudo inverse*. For which $\mathbf{B}$ is
# $(\mathbf{B}^T\mathbf{B})^{-1}\mathbf{B}^T$ the pseudo inverse, and what may go wrong otherwise?

# %% [markdown] answer="01.8" points=2
# If $\mathbf{B}$ has full column rank $D+1$, which is so exactly if the points are in no common
# hyperplane: $\mathbf{c}^T\mathbf{B}^T\mathbf{B}\mathbf{c} = \lVert\mathbf{B}\mathbf{c}\rVert^2$
# vanishes only for $\mathbf{c} = \mathbf{0}$ then. Otherwise the inverse does not exist, and
# rounding may hide that: a solver returns large numbers without a warning. The pseudo inverse
# itself still exists. It picks the coefficients of least norm, which depend on where the origin
# lies, so they mean little.

# %% [markdown] rubric="01.8"
# One point for full column rank, with its meaning for the points. One for what goes wrong: no
# inverse, or a least-norm answer that depends on the origin.

# %% [markdown]
# ## Dig deeper
#
# - The condition number of $\mathbf{B}^T\mathbf{B}$ is that of $\mathbf{B}$ squared. Move your
#   points by $10^3, 10^4, \dots$ along both axes. At which offset is the last digit of `fit` gone?
#   What does subtracting the mean of the points first change?
# - Compare `fit` with `numpy.linalg.lstsq`. Which of the two notices collinear points?

# %%
progress()
