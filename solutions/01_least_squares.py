# ---
# jupyter:
#   course:
#     pages: slides, pages 3–7 and 39
#     chapters: [11-least-squares]
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
# A quantity was measured at a few scattered points, and its value between them is wanted. The
# simplest method that uses all measurements is *linear regression*: an affine function whose
# squared errors have the smallest sum. In this notebook you write the method, find out when its
# solution is unique, and see which fields it cannot represent.
#
# You need linear systems, the transpose of a matrix, and the gradient.
#
# **Sources.** Erleben, *Field Reconstruction: A Quick Survey of Methods*, pages 3–7. Search for:
# linear least squares, normal equations, pseudo-inverse. Read: Strang, *Introduction to Linear
# Algebra*, the chapter on orthogonality; Trefethen and Bau, *Numerical Linear Algebra*, lectures 11
# and 18.
#
# Each question asks for a function or for an answer in words. Write the function, run its cell, and
# run the check below it. The check reports whether the function is right and, if it is not, which
# mistake is likely. Then `case()`, in a new cell, shows the inputs for which your function failed,
# and your values. If everybody has the same inputs, it also shows the right values. A function must
# not change its arguments. In all notebooks arrays may hold integers, as `np.array([1, 2])` does,
# so small that no product of them overflows; `x.astype(float)` is an array of real numbers.
# Returned lists count as arrays, an array with one entry as a number, and a complex number without
# imaginary part as a real one. Compute with NumPy's default type, float64; float32 has too few
# digits.

# %% tags=["setup"]
import numpy as np

from fieldcheck import (
    BLUE,
    GREY,
    ORANGE,
    Slider,
    case,
    check,
    data,
    draw,
    figure,
    progress,
    start_over,
)

# %% [markdown]
# ## Scattered data
#
# The dots are measurements of a field along a line. We want its value at the dotted line, where
# nothing was measured.


# %%
@draw(number=Slider(3, 40, 12, "points", whole=True))
def the_problem(number):
    x = np.random.default_rng(1).random(number)
    with figure(6.4, 2.6) as page:
        axes = page.subplots()
        axes.plot(x, np.sin(4 * x) + x, "o", color=BLUE, label="measured")
        axes.axvline(0.5, color=ORANGE, ls=":", label="value wanted here")
        axes.set(xlabel="$x$", ylabel=r"value $\phi$", xlim=(0, 1), ylim=(0, 2))
        axes.legend(loc="lower right")
    return page


# %% [markdown]
# ## A finished function
#
# The simplest answer is the value of the nearest point. It is called *nearest-neighbour
# interpolation*. The function below is finished; imitate its style. It has three parts: a docstring
# with all shapes, array operations instead of loops, and one returned array.
#
# `x[:, None]` has the shape $(M, 1, D)$. Subtracting `points`, of shape $(N, D)$, gives all
# differences, of shape $(M, N, D)$. This rule of NumPy is called *broadcasting*. `axis=-1` then
# removes the last axis, and `axis=1` the axis of the points.


# %%
def nearest_values(points, values, x):
    """Return the value of the nearest point, of shape (M,), at each of M evaluation points.

    The points have the shape (N, D), the values (N,), and the evaluation points x (M, D).
    """
    distances = np.linalg.norm(x[:, None] - points, axis=-1)  # of shape (M, N)
    return values[np.argmin(distances, axis=1)]


three_points = np.array([[0.0], [1.0], [2.0]])  # three points on a line, D = 1
three_values = np.array([1.0, 2.0, 6.0])
print(nearest_values(three_points, three_values, np.array([[0.2], [0.7], [9.0]])))


# %% [markdown]
# The three results are the values at the points 0, 1 and 2. This field is piecewise constant, and
# it jumps halfway between two points. A field without jumps needs another idea.

# %% [markdown]
# ## The affine field
#
# Let $\mathbf{p}_1, \dots, \mathbf{p}_N \in \mathbb{R}^D$ be the points and
# $\phi_1, \dots, \phi_N$ the values. We look for an *affine* field
#
# $$ f(\mathbf{x}) = \mathbf{b}(\mathbf{x})^T \mathbf{c}, \qquad
#    \mathbf{b}(\mathbf{x}) = (1, x_1, \dots, x_D)^T \tag{1.1} $$
#
# with $D+1$ coefficients $\mathbf{c} = (c_0, c_1, \dots, c_D)^T$. Its graph is a straight line for
# $D = 1$ and a plane for $D = 2$. The conditions $f(\mathbf{p}_i) = \phi_i$ are a linear system
# $\mathbf{B}\mathbf{c} = \mathbf{V}$, where
#
# $$ \mathbf{B} = \begin{bmatrix} \mathbf{b}(\mathbf{p}_1)^T \\ \vdots \\ \mathbf{b}(\mathbf{p}_N)^T
#    \end{bmatrix}, \qquad
#    \mathbf{V} = \begin{bmatrix} \phi_1 \\ \vdots \\ \phi_N \end{bmatrix}. \tag{1.2} $$
#
# Statisticians call $\mathbf{B}$ the *design matrix*.
#
# ### Example: three points, by hand
#
# Take the points $0, 1, 2$ on a line and the values $1, 2, 6$. Then $D = 1$, and (1.2) is
#
# $$ \mathbf{B} = \begin{bmatrix} 1 & 0 \\ 1 & 1 \\ 1 & 2 \end{bmatrix}, \qquad
#    \mathbf{V} = \begin{bmatrix} 1 \\ 2 \\ 6 \end{bmatrix}. $$
#
# No straight line passes through the three values. The first two require $c_0 = 1$ and $c_1 = 1$,
# and then $f(2) = 3$, not 6.

# %% [markdown]
# ### 01.1 The design matrix
#
# Write $\mathbf{B}$ of (1.2) for points given as an array of shape $(N, D)$.


# %% question="01.1" minutes=15
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
# With more points than coefficients the system usually has no solution. Then we make the residual
# $\boldsymbol{\varepsilon} = \mathbf{B}\mathbf{c} - \mathbf{V}$ as small as possible: we minimize
#
# $$ \psi(\mathbf{c}) = \tfrac{1}{2} \lVert \mathbf{B}\mathbf{c} - \mathbf{V} \rVert^2. \tag{1.3} $$
#
# At the minimum the gradient of $\psi$ is zero, $\mathbf{B}^T(\mathbf{B}\mathbf{c} - \mathbf{V})
# = \mathbf{0}$. In words: the residual must be orthogonal to the columns of $\mathbf{B}$. These are
# the *normal equations*
#
# $$ \mathbf{B}^T\mathbf{B}\,\mathbf{c} = \mathbf{B}^T\mathbf{V}. \tag{1.4} $$
#
# ### Example: the normal equations, by hand
#
# For the three points of the example,
#
# $$ \mathbf{B}^T\mathbf{B} = \begin{bmatrix} 3 & 3 \\ 3 & 5 \end{bmatrix}, \qquad
#    \mathbf{B}^T\mathbf{V} = \begin{bmatrix} 9 \\ 14 \end{bmatrix}. $$
#
# Subtracting the first equation from the second gives $2c_1 = 5$. So $c_1 = \tfrac52$ and $c_0 =
# \tfrac12$. The residual is $(-\tfrac12, 1, -\tfrac12)$. Its sum is zero, and its scalar product
# with $(0, 1, 2)$ is zero, as (1.4) requires. The next cell checks these numbers.

# %%
three_b = np.array([[1.0, 0.0], [1.0, 1.0], [1.0, 2.0]])
three_c = np.array([0.5, 2.5])
print("BᵀB:", (three_b.T @ three_b).tolist())
print("BᵀV:", three_b.T @ three_values)
print("BᵀB c:", three_b.T @ three_b @ three_c)
print("residual:", three_b @ three_c - three_values)


# %% [markdown]
# ### 01.2 The coefficients
#
# Write a function that returns the coefficients $\mathbf{c}$ of the best fit. For all inputs of the
# check the solution of (1.4) is unique. The points are near the origin, not much farther from it
# than from each other, and may all lie within $10^{-6}$ of it.
#
# <details><summary>Hint</summary>
#
# You have `basis_matrix`. `numpy.linalg` has a function that solves a linear system; no inverse is
# needed.
#
# </details>


# %% question="01.2" minutes=10
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
# Evaluate the field (1.1) at many evaluation points at once.


# %% question="01.3" minutes=5
def evaluate(coefficients, x):
    """Return f of (1.1) at evaluation points x of shape (M, D), as an array of shape (M,)."""
    # BEGIN SOLUTION
    return basis_matrix(x) @ coefficients
    # END SOLUTION


# %%
check("01.3")

# %% [markdown]
# ## The fit of a curved field
#
# The next picture is drawn with your functions. The points are your own: they depend on the number
# in `student.txt`. The field is $\phi(\mathbf{x}) = (x_1 + x_2)^n$. Move the slider of the power
# $n$, and compare the plane with the field.


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
# **What to look at.** For $n = 1$ the field is affine, and the plane passes through every point.
# For larger $n$ the plane is too low at both ends of the diagonal and too high in its middle, since
# it cannot bend. More points do not reduce this error, which is called the *bias* of the model.
#
# ## When is the solution unique?
#
# The matrix $\mathbf{B}^T\mathbf{B}$ is invertible if and only if the columns of $\mathbf{B}$ are
# linearly independent, that is, if $\mathbf{B}$ has rank $D+1$. Such a set of points is called
# *unisolvent* for affine fields. Counting points is not enough: the three points $(0, 0)$, $(1,
# 1)$, $(2, 2)$ of the plane lie on one line, and
#
# $$ \mathbf{B} = \begin{bmatrix} 1 & 0 & 0 \\ 1 & 1 & 1 \\ 1 & 2 & 2 \end{bmatrix} $$
#
# has rank 2, since its last two columns are equal.
#
# ### 01.4 The rank
#
# Write a function that returns the rank of $\mathbf{B}$. At least two of the points are different.
# The rank must depend neither on the distance of the points from the origin nor on the unit of
# length.
#
# Rounding errors turn zero singular values into small ones. Take the singular values of the matrix
# of the coordinates, without the column of ones, after one of the points, or their mean, has been
# subtracted from all points (hint 1 asks why). Count a singular value as zero if it is at most
# $10^{-9}$ times the extent of the points. The extent is the largest difference between two values
# of one coordinate.
#
# <details><summary>Hint 1</summary>
#
# A common translation of all points changes neither the fitted field nor the rank. After the
# subtraction one row of the coordinates, or their sum, is zero. What is then the rank of the column
# of ones and the remaining columns together?
#
# </details>
#
# <details><summary>Hint 2</summary>
#
# `np.linalg.matrix_rank(A, tol=t)` counts the singular values of `A` that are larger than `t`.
# Without `tol` the limit is the rounding error of the entries of `A`. For points far from the
# origin, the rounding errors of the coordinates are larger than this limit.
#
# </details>


# %% question="01.4" minutes=15
def rank(points):
    """Return the rank of B for points of shape (N, D), a whole number from 2 to D + 1."""
    # BEGIN SOLUTION
    centered = points - points.mean(axis=0)
    return 1 + np.linalg.matrix_rank(centered, tol=1e-9 * np.ptp(points, axis=0).max())
    # END SOLUTION


# %%
check("01.4")

# %% [markdown]
# Below, twelve points lie in a strip. Their values are $x_1$ plus small errors of size 0.02. The
# lines are level lines of your fit, 0.1 apart. Make the strip narrow.


# %%
@draw(width=Slider(1e-12, 1, 1, "width", logarithmic=True))
def strip(width):
    random = np.random.default_rng(4)
    points = random.random((12, 2)) * np.array([1, width])
    values = points[:, 0] + 0.02 * random.normal(size=12)
    side = np.linspace(0, 1, 41)
    grid = np.stack(np.meshgrid(side, side), axis=-1)
    points[:, 1] += (1 - width) / 2
    full = rank(points) == 3
    with figure(4.2, 3.6) as page:
        axes = page.subplots()
        title = "rank 2: no unique plane"
        if full:
            c = fit(points, values)
            heights = evaluate(c, grid.reshape(-1, 2)).reshape(41, 41)
            levels = np.arange(-20, 21) / 10
            axes.contour(side, side, heights, levels, colors=ORANGE, linewidths=1)
            title = f"rank 3, slopes {c[1]:.2g} and {c[2]:.2g}"
        axes.plot(*points.T, "o", color=BLUE)
        axes.set(xlabel="$x_1$", ylabel="$x_2$", aspect="equal", title=title)
        axes.set(xlim=(0, 1), ylim=(0, 1))
    return page


# %% [markdown]
# **What to look at.** The right slopes are 1 and 0. In a narrow strip small errors of the values
# produce a large slope across the strip. On a line this slope is not determined at all.
#
# The *condition number* of $\mathbf{B}$ is the ratio of its largest and its smallest singular
# value. It bounds how much errors are magnified, and it is infinite if the rank is less than $D +
# 1$. The condition number of $\mathbf{B}^T\mathbf{B}$ is the square of the condition number of
# $\mathbf{B}$. So the normal equations lose twice as many digits to rounding as a solver that uses
# $\mathbf{B}$ itself, such as `numpy.linalg.lstsq`.

# %% [markdown]
# ## Gradient and objective
#
# ### 01.5 The gradient
#
# Differentiate (1.1) on paper. Then return the gradient of $f$ at many evaluation points. A
# difference quotient is no answer: far from the origin it loses digits.


# %% question="01.5" minutes=5
def gradient(coefficients, x):
    """Return the gradient of f at evaluation points x of shape (M, D), of shape (M, D)."""
    # BEGIN SOLUTION
    return np.tile(coefficients[1:], (len(x), 1))
    # END SOLUTION


# %%
check("01.5")

# %% [markdown]
# ### 01.6 The objective
#
# Write the *objective* $\psi$ of (1.3), for any coefficients, also where the residuals are a
# million times smaller than the values. In the example by hand it is $\psi(\tfrac12, \tfrac52) =
# \tfrac12 (\tfrac14 + 1 + \tfrac14) = \tfrac34$.


# %% question="01.6" minutes=10
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
def minimum():
    random = np.random.default_rng(2)
    points, values = random.random((30, 2)), random.normal(size=30)
    best = fit(points, values)
    steps = np.linspace(-1, 1, 61)
    with figure(6.4, 2.8) as page:
        axes = page.subplots()
        for direction in random.normal(size=(12, 3)):
            change = direction / np.linalg.norm(direction)
            rows = [objective(points, values, best + t * change) for t in steps]
            axes.plot(steps, rows, color=BLUE, lw=1)
        axes.plot(0, objective(points, values, best), "o", color=ORANGE, label="your fit")
        axes.set(xlabel=r"distance from $\mathbf{c}$ in coefficient space", ylabel=r"$\psi$")
        axes.legend()
    return page


# %% [markdown]
# **What to look at.** Each curve shows $\psi$ along a line through your coefficients, in one of
# twelve random directions. All of them have their minimum at your fit. Each curve is a parabola,
# since $\psi$ is a quadratic function of $\mathbf{c}$.

# %% [markdown]
# ## In words
#
# **01.7** Explain with an example why the numbers of equations and unknowns, $N$ and $D+1$, do not
# decide whether $\mathbf{B}\mathbf{c} = \mathbf{V}$ is over-determined or under-determined.
#
# <details><summary>Hint</summary>
#
# Think of a hundred points on one line of the plane.
#
# </details>

# %% [markdown] answer="01.7" points=3 minutes=10 words=80
# By counting, the system is over-determined for $N > D+1$ and under-determined for $N < D+1$. But
# equations may depend on each other, so the rank of $\mathbf{B}$ decides.
#
# For a hundred points on a line of the plane, $\mathbf{B}$ has three columns and the rank 2. The
# system is over-determined along the line, where the data need not agree. It is under-determined
# across the line, where any slope fits.
#
# *Beyond the question.* The rank of $\mathbf{B}$ is one more than the dimension of the affine hull
# of the points.

# %% [markdown] rubric="01.7"
# One point for the two cases by counting. One for the reason that counting is not enough: equations
# may depend on each other, so the rank decides. One for an example such as collinear points, where
# the rank is less than the number of columns.

# %% [markdown]
# **01.8** The slides call (1.4) the method of the *pseudo-inverse* (page 5). For which points is
# $(\mathbf{B}^T\mathbf{B})^{-1}\mathbf{B}^T$ the pseudo-inverse of $\mathbf{B}$?

# %% [markdown] answer="01.8" points=2 minutes=10 words=40
# The inverse exists if and only if $\mathbf{B}$ has full column rank $D+1$. Then no combination of
# the columns is zero. This means that no affine function except zero vanishes at all points: no
# hyperplane contains all of them.
#
# *Beyond the question.* With full column rank $\mathbf{c}^T\mathbf{B}^T\mathbf{B}\mathbf{c} =
# \lVert\mathbf{B}\mathbf{c}\rVert^2$ is zero for $\mathbf{c} = \mathbf{0}$ only, so
# $\mathbf{B}^T\mathbf{B}$ is invertible. For other points the inverse does not exist, and rounding
# errors may hide this: a solver returns large numbers without a warning. The pseudo-inverse itself
# selects the coefficients of least norm, which depend on the origin.

# %% [markdown] rubric="01.8"
# One point for full column rank. One for its meaning for the points: no hyperplane contains all of
# them.

# %% [markdown]
# ## Dig deeper
#
# - *Lost digits.* Move your points by $10^3, 10^4, \dots$ along both axes. At which offset has
#   `fit` lost all its digits? Subtract the mean of the points first. What changes?
# - *A second solver.* Compare `fit` with `numpy.linalg.lstsq`. Which of the two reports collinear
#   points?
# - *A curved model.* Add the columns $x_1^2$, $x_1 x_2$ and $x_2^2$ to $\mathbf{B}$. For which
#   points of the plane does the new matrix have rank less than 6? (Search for: conic through five
#   points.)

# %%
progress()
