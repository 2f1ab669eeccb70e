# ---
# jupyter:
#   course:
#     builds_on:
#       "01": the linear basis, and the rank of its matrix
#     pages: slides, pages 11–13 and 41
#     chapters: [13-radial-basis-functions]
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
# A fit by least squares has residuals. If the data are exact, the field should *interpolate* them:
# it should have the given value at every point. In this notebook you write the best-known
# interpolation of scattered data, the *thin-plate spline*. It is a sum of radial functions, one for
# each point, and an affine field. You also find out for which points its linear system has a unique
# solution.
#
# **Source**: Erleben, *Field Reconstruction: A Quick Survey of Methods* (the slides). **Search
# for**: thin-plate spline, radial basis function, conditionally positive definite, unisolvent,
# saddle-point system, inertia of a matrix, Runge phenomenon. **Read**: Wendland, *Scattered Data
# Approximation*, chapters 8 and 10; Fasshauer, *Meshfree Approximation Methods with MATLAB*,
# chapters 2 and 6 to 9; Duchon, *Splines minimizing rotation-invariant semi-norms in Sobolev
# spaces* (1977).
#
# Each question asks for a function or for an answer in words. Write the function, run its cell, and
# run the check below it. After a check that is not right, `case()` in a new cell shows the inputs
# for which your function failed, and your values. If everybody has the same inputs, it also shows
# the right values. Arrays may hold integers, so small that no product of them overflows. Compute
# with float64, NumPy's default type. Returned lists count as arrays, an array with one entry as a
# number, and a complex number without imaginary part as a real one. A function must not change its
# arguments.

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
    terrain,
)

# %% [markdown]
# ## Interpolation by polynomials
#
# Twelve values were measured without error. A straight line has large residuals. A polynomial with
# as many coefficients as values interpolates all of them, but it oscillates between the points,
# most of all near the ends. This is the *Runge phenomenon*. Move the slider to lower degrees.


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
        axes.set(xlabel="$x$", ylabel=r"value $\phi$", xlim=(0, 1), ylim=(-2, 3))
        axes.legend(loc="lower left", ncols=3)
    return page


# %% [markdown]
# ## A finished function
#
# Radial functions depend on distances, so we need all distances between two sets of points. The
# function below is finished; imitate its style. `x[:, None]` has the shape $(M, 1, D)$, and
# `points` has the shape $(N, D)$. NumPy repeats both along the missing axis (*broadcasting*): the
# difference has the shape $(M, N, D)$, with $\mathbf{x}_m - \mathbf{p}_n$ in entry $[m, n]$. The
# sum over the last axis leaves the shape $(M, N)$.


# %%
def distances(x, points):
    """Return all distances between x (M, D) and points (N, D), of shape (M, N)."""
    difference = x[:, None] - points  # of shape (M, N, D)
    return np.linalg.norm(difference, axis=-1)


print(distances(np.array([[0.0, 0.0], [3.0, 4.0]]), np.array([[0.0, 0.0], [3.0, 0.0], [0.0, 4.0]])))


# %% [markdown]
# The first row has the distances from the origin, $0, 3, 4$. The second row has the distances from
# $(3, 4)$, $5, 4, 3$.

# %% [markdown]
# ## The kernel
#
# A thin elastic plate that is pressed onto supports of given heights passes through all of them.
# Since it resists bending, it does not oscillate between the supports. Far from the supports
# its bending fades. For a plate over the plane, the shape around a single support is
# the *thin-plate spline*
#
# $$ w(\mathbf{y}) = \lVert\mathbf{y}\rVert^2 \log \lVert\mathbf{y}\rVert^2 ,
#    \qquad w(\mathbf{0}) = 0 . \tag{3.1} $$
#
# Such a function of the distance is called a *kernel* or *radial basis function*. The logarithm is
# the natural one. It is not defined at zero, but the product tends to zero, so we set
# $w(\mathbf{0}) = 0$.
#
# By hand: $w(1, 0) = 0$, since $\log 1 = 0$. $w(1, 1) = 2 \log 2 \approx 1.386$, since the squared
# length is 2. $w(2, 0) = 4 \log 4 = 8 \log 2 \approx 5.545$.
#
# ### 03.1 The kernel
#
# Write $w$ for any number of vectors at once. The last axis holds the coordinates. An array of
# shape $(5, 2)$ has five vectors of the plane, and one of shape $(2,)$ is a single vector. An
# array of shape $(4, 6, 3)$ has a $4 \times 6$ table of vectors in space.
#
# <details><summary>Hint</summary>
#
# Start with an array of zeros, and compute only the entries whose vector is not zero. A condition
# such as `squared > 0` is a boolean array, and an array can be indexed by it.
#
# </details>


# %% question="03.1" minutes=20
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
def kernel_shape():
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
# **What to look at.** This kernel does not decrease with the distance. It is zero at the centre and
# on the unit circle (white), negative between them, and it grows without bound outside. A sum of
# such functions grows too, unless the coefficients satisfy conditions that prevent it.

# %% [markdown]
# ## The system
#
# Let $\mathbf{p}_1, \dots, \mathbf{p}_N \in \mathbb{R}^D$ be the points, called *centres*, and
# $\phi_1, \dots, \phi_N$ the values. The field is a sum of kernels, one at each centre, and an
# affine field:
#
# $$ f(\mathbf{x}) = \mathbf{b}(\mathbf{x})^T\mathbf{c} +
#    \sum_{j=1}^N \lambda_j\, w(\mathbf{x} - \mathbf{p}_j), \qquad
#    \mathbf{b}(\mathbf{x}) = (1, x_1, \dots, x_D)^T . \tag{3.2} $$
#
# There are $N$ unknown $\lambda_j$ and $D + 1$ unknown $c_k$. The field must interpolate the
# values,
#
# $$ f(\mathbf{p}_i) = \phi_i, \qquad i = 1, \dots, N, \tag{3.3} $$
#
# which are $N$ conditions. The remaining $D + 1$ are the *orthogonality constraints*
#
# $$ \sum_{j=1}^N \lambda_j\, \mathbf{b}(\mathbf{p}_j) = \mathbf{0} . \tag{3.4} $$
#
# Let $A_{ij} = w(\mathbf{p}_i - \mathbf{p}_j)$, and let $\mathbf{B}$ be the matrix with the rows
# $\mathbf{b}(\mathbf{p}_i)^T$. All conditions together are the *saddle-point system*
#
# $$ \underbrace{\begin{bmatrix} \mathbf{A} & \mathbf{B} \\ \mathbf{B}^T & \mathbf{0} \end{bmatrix}
#    }_{\mathbf{H}_{\mathrm{RBF}}}
#    \begin{bmatrix} \boldsymbol{\lambda} \\ \mathbf{c} \end{bmatrix} =
#    \begin{bmatrix} \boldsymbol{\phi} \\ \mathbf{0} \end{bmatrix} . \tag{3.5} $$
#
# ### Example: three points, by hand
#
# Take the points $0, 1, 2$ on a line and the values $1, 2, 6$, as in notebook 01. With
# $a = w(2) = 8 \log 2$, the blocks are
#
# $$ \mathbf{A} = \begin{bmatrix} 0 & 0 & a \\ 0 & 0 & 0 \\ a & 0 & 0 \end{bmatrix}, \qquad
#    \mathbf{B} = \begin{bmatrix} 1 & 0 \\ 1 & 1 \\ 1 & 2 \end{bmatrix}. $$
#
# The constraints are $\lambda_1 + \lambda_2 + \lambda_3 = 0$ and $\lambda_2 + 2\lambda_3 = 0$. So
# $\boldsymbol{\lambda} = t\,(1, -2, 1)$ with one unknown number $t$. The first three rows of (3.5)
# are
#
# $$ a t + c_0 = 1, \qquad c_0 + c_1 = 2, \qquad a t + c_0 + 2 c_1 = 6. $$
#
# The third minus the first is $2 c_1 = 5$. So $c_1 = \tfrac52$, $c_0 = -\tfrac12$ and $a t =
# \tfrac32$. The next cell checks these numbers.

# %%
kernel_2 = 8 * np.log(2)
three_a = np.array([[0, 0, kernel_2], [0, 0, 0], [kernel_2, 0, 0]])
three_b = np.array([[1.0, 0.0], [1.0, 1.0], [1.0, 2.0]])
three_lambda = 1.5 / kernel_2 * np.array([1.0, -2.0, 1.0])
print("A λ + B c:", three_a @ three_lambda + three_b @ np.array([-0.5, 2.5]))
print("Bᵀλ:", three_b.T @ three_lambda)


# %% [markdown]
# ### 03.2 The matrix
#
# Write $\mathbf{H}_{\mathrm{RBF}}$. How many rows does it have? Some points may be equal, there may
# be fewer than $D + 1$ points, and they may be far from the origin, up to $10^5$ times as far as
# from each other.
#
# <details><summary>Hint</summary>
#
# Which array holds all differences $\mathbf{p}_i - \mathbf{p}_j$? Look at `distances`. $\mathbf{B}$
# is the matrix of 01.1; if you have written 01.1, use your function. `np.block` puts blocks
# together.
#
# </details>


# %% question="03.2" minutes=20
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
        for line in (axes.axhline, axes.axvline):
            line(number - 0.5, color="black", lw=0.8)
        axes.set(title=f"{len(h)} rows for {number} points", xticks=[], yticks=[])
        page.colorbar(image, ax=axes)
    return page


# %% [markdown]
# **What to look at.** There are four blocks. The diagonal of $\mathbf{A}$ is zero, since
# $w(\mathbf{0}) = 0$, and the last block is zero. So the whole diagonal of
# $\mathbf{H}_{\mathrm{RBF}}$ is zero. Question 03.9 uses this.

# %% [markdown]
# ### 03.3 The coefficients
#
# Solve (3.5) for points for which the solution is unique. Return the two parts of the solution as
# two arrays: `return lam, c`.


# %% question="03.3" minutes=10
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
# Evaluate (3.2) at many evaluation points at once. Some of them may be centres. The coefficients
# need not satisfy (3.4), and all points may be far from the origin, as in 03.2.


# %% question="03.4" minutes=5
def evaluate(points, lam, c, x):
    """Return f of (3.2) at evaluation points x of shape (M, D), as an array of shape (M,)."""
    # BEGIN SOLUTION
    return c[0] + x @ c[1:] + kernel(x[:, np.newaxis] - points) @ lam
    # END SOLUTION


# %%
check("03.4")

# %% [markdown]
# ## Interpolation of the first data
#
# The next picture uses the data of the first picture and your functions. Move the height of the
# orange point, and change the number of points.


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
        axes.set(xlabel="$x$", ylabel=r"value $\phi$", xlim=(-0.2, 1.2), ylim=(-2.6, 3))
        axes.legend(loc="lower left", ncols=3)
    return page


# %% [markdown]
# **What to look at.** The curve passes through every point, for any height of the orange point. The
# change affects the whole curve, but it is small far away. Outside the data the curve becomes
# straight. Between the points it does not oscillate.
#
# On a line the interpolant with the least bending energy is the natural cubic spline, whose kernel
# is $\lVert\mathbf{y}\rVert^3$. The kernel (3.1) has this property in the plane. In the next
# picture the points of the plane are your own.


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
# Inside its white boundary each dot must have the same colour as the field around it.
#
# ## Real data: heights of a landscape
#
# The file `fieldcheck/datasets/terrain.json` holds 3000 heights around Cross Mountain in
# Tennessee. They were measured by the Shuttle Radar Topography Mission (public domain). `terrain()`
# returns the points in kilometres and the heights in metres. Your field interpolates the heights at
# the dots only. The error is measured at 500 other points, whose heights your functions never see.
# The error shown is the root mean square.


# %%
@draw(number=Slider(50, 400, 180, "heights", whole=True))
def landscape(number):
    points, heights = terrain()
    order = np.random.default_rng(1).permutation(len(points))
    known, others = order[:number], order[-500:]
    lam, c = coefficients(points[known], heights[known])
    at_dots = evaluate(points[known], lam, c, points[known]) - heights[known]
    elsewhere = evaluate(points[known], lam, c, points[others]) - heights[others]
    dots, held_out = (np.sqrt(np.mean(error**2)) for error in (at_dots, elsewhere))
    field = evaluate(points[known], lam, c, points)
    x, y = np.unique(points[:, 0]), np.unique(points[:, 1])
    with figure(6.8, 3.1) as page:
        panels = page.subplots(1, 2, sharey=True)
        page.suptitle(f"error: {dots:.1f} m at the dots, {held_out:.0f} m at 500 other points")
        for axes, name, shown in zip(panels, ("measured", "your field"), (heights, field)):
            grid = shown.reshape(len(y), len(x))
            levels = np.linspace(200, 1100, 19)
            image = axes.contourf(x, y, grid, levels, extend="both", cmap="terrain")
            image.set_rasterized(True)
            axes.set(title=name, aspect="equal", xlabel="km to the east")
        panels[0].set(ylabel="km to the north")
        panels[1].plot(*points[known].T, ".", ms=2, color="black")
        page.colorbar(image, ax=list(panels), label="height in metres")
    return page


# %% [markdown]
# **What to look at.** At the dots the error is only rounding, but this says nothing about the error
# elsewhere. For comparison, a plane of least squares has an error of about 141 m at the same 500
# points. Double the number of heights to 360: how much does the error decrease? Which landforms of
# the left map are missing on the right one, and how far apart are the dots there? These heights
# have little noise. If the noise were large, would you still interpolate them?
#
# ## The orthogonality constraints
#
# Is there a simpler method? $\mathbf{A}\boldsymbol{\lambda} = \boldsymbol{\phi}$ alone is a system
# of $N$ equations for $N$ unknowns, with kernels but without the affine part and the constraints.
# The picture shows both fields along the line $x_2 = 0.5$, with your own points. Increase the
# half-width.


# %%
@draw(reach=Slider(1, 1000, 4, "half-width", logarithmic=True))
def far_away(reach):
    points, values = data("03.3")
    n = len(points)
    lam, c = coefficients(points, values)
    alone = np.linalg.solve(system_matrix(points)[:n, :n], values)
    side = np.linspace(-reach, reach, 401)
    line = np.stack([side, 0 * side + 0.5], axis=1)
    with figure(6.4, 3.0) as page:
        axes = page.subplots()
        axes.axvspan(0, 1, color=GREY, alpha=0.25, lw=0, label="region of the data")
        axes.plot(side, evaluate(points, alone, 0 * c, line), color=ORANGE, label="kernels alone")
        axes.plot(side, evaluate(points, lam, c, line), color=BLUE, label="with affine part")
        axes.set(xlabel="$x_1$", ylabel="$f$", xlim=(-reach, reach))
        axes.legend()
    return page


# %% [markdown]
# **What to look at.** Both fields interpolate the data. Between the points they may look alike.
# Outside they differ: the field without constraints grows like $R^2 \log R$ with the distance $R$,
# the other one at most like an affine function.

# %% [markdown]
# ## When is the solution unique?
#
# The slides say that $\mathbf{H}_{\mathrm{RBF}}$ is symmetric and positive definite, so that
# (3.5) always has a unique solution (page 13). It is symmetric. The rest follows from its
# eigenvalues: a symmetric matrix is positive definite if all of them are positive, and invertible
# if none is zero.
#
# ### 03.5 The signs of the eigenvalues
#
# Write a function that returns how many eigenvalues of $\mathbf{H}_{\mathrm{RBF}}$ are positive,
# how many negative, and how many zero. These three numbers are called the *inertia* of the matrix.
#
# A computed eigenvalue is rarely exactly zero. Count it as zero if its absolute value is less than
# $10^{-12}$ times the largest absolute value: rounding errors are relative to the largest
# eigenvalue. (You may move the points to the origin first: this changes neither the signs nor, in
# the check, which eigenvalues count as zero. But do not scale them: in another unit of length the
# same points may have other eigenvalues that count as zero.)
#
# <details><summary>Hint</summary>
#
# `numpy.linalg` has a function for the eigenvalues of symmetric matrices. Divide them by the
# largest absolute value, then count.
#
# </details>


# %% question="03.5" minutes=20
def inertia(points):
    """Return the numbers of positive, negative and zero eigenvalues of H_RBF, for points (N, D)."""
    # BEGIN SOLUTION
    eigenvalues = np.linalg.eigvalsh(system_matrix(points))
    relative = eigenvalues / np.linalg.norm(eigenvalues, np.inf)
    positive, negative = np.sum(relative > 1e-12), np.sum(relative < -1e-12)
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
    counts = "{} positive, {} negative, {} zero".format(*(int(k) for k in inertia(points)))
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
        axes.set(xlabel="number of the eigenvalue", ylabel="size", ylim=(1e-18, 1e2), title=counts)
        axes.legend(loc="lower right")
    return page


# %% [markdown]
# **What to look at.** The picture has twelve points in a box. How many eigenvalues are negative?
# Make the box flatter, until all points lie on one line. Which eigenvalue becomes zero, and what
# does that mean for (3.5)?

# %% [markdown]
# ## The gradient
#
# Forces follow from the gradient of a pressure, so we often need the gradient of the field. From
# (3.2)
#
# $$ \nabla f(\mathbf{x}) = (c_1, \dots, c_D)^T +
#    \sum_{j=1}^N \lambda_j\, \nabla w(\mathbf{x} - \mathbf{p}_j) . \tag{3.6} $$
#
# ### 03.6 The gradient
#
# Compute $\nabla w$ on paper, with the product rule and the chain rule. What is its limit for
# $\mathbf{y} \to \mathbf{0}$? Then write (3.6). It must be right at the centres too. Test it by
# central differences of your field, as in notebook 02, before you run the check. Here, too, the
# coefficients need not satisfy (3.4), and all points may be far from the origin.
# A difference quotient itself is no answer: no step suits every unit of length.
#
# <details><summary>Hint</summary>
#
# Let $s = \lVert\mathbf{y}\rVert^2 = y_1^2 + \dots + y_D^2$. What is $\partial s / \partial y_k$,
# and what is the derivative of $s \log s$ with respect to $s$?
#
# </details>


# %% question="03.6" minutes=20
def gradient(points, lam, c, x):
    """Return the gradient (3.6) at evaluation points x (M, D), as an array of shape (M, D)."""
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
    x = np.stack(np.meshgrid(coarse, coarse), axis=-1).reshape(-1, 2)
    with figure(4.4, 4.2) as page:
        axes = page.subplots()
        field = evaluate(points, lam, c, grid).reshape(81, 81)
        axes.contour(side, side, field, levels=16, cmap="viridis", linewidths=1.2)
        axes.quiver(*x.T, *gradient(points, lam, c, x).T, color=GREY, width=0.005, scale=120)
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
# **What to look at.** The arrows are perpendicular to the level lines, and they are long where the
# level lines are close together.
#
# ## The bending energy
#
# Among all functions of the plane that interpolate the values, (3.2) has the least *bending energy*
#
# $$ E = \int_{\mathbb{R}^2} \Bigl( \frac{\partial^2 f}{\partial x_1^2} \Bigr)^2 +
#    2 \Bigl( \frac{\partial^2 f}{\partial x_1 \partial x_2} \Bigr)^2 +
#    \Bigl( \frac{\partial^2 f}{\partial x_2^2} \Bigr)^2 \, d\mathbf{x} =
#    16\pi\, \boldsymbol{\lambda}^T \mathbf{A} \boldsymbol{\lambda} . \tag{3.7} $$
#
# The integral over the whole plane is finite only because of (3.4). It cannot be negative. So
# $\boldsymbol{\lambda}^T \mathbf{A} \boldsymbol{\lambda} \geq 0$ for all $\boldsymbol{\lambda}$
# that satisfy (3.4), although $\mathbf{A}$ itself has eigenvalues of both signs. If the points
# differ, only $\boldsymbol{\lambda} = \mathbf{0}$ gives zero. Such a kernel is called
# *conditionally positive definite*.
#
# ### 03.7 The energy
#
# Write $E$ for points of the plane and their values. The solution of (3.5) is unique.


# %% question="03.7" minutes=15
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
    predicted = evaluate(others, lam, c, points[[i]])[0]
    heights = np.linspace(-4, 4, 81)
    energies = [energy(points, np.r_[values[:i], height, values[which:]]) for height in heights]
    with figure(6.4, 2.9) as page:
        axes = page.subplots()
        axes.plot(heights, energies, color=BLUE, label="energy")
        axes.axvline(values[i], color=PURPLE, ls=":", label="measured value")
        axes.axvline(predicted, color=GREEN, ls="--", label="field of the others")
        axes.set(xlabel=f"value at point {which}", ylabel="$E$", ylim=(0, None))
        axes.legend(loc="center left", bbox_to_anchor=(1, 0.5))
    return page


# %% [markdown]
# **What to look at.** The value of one of your points is changed, and the others are kept. The
# energy is a parabola and never negative. It is least at the value that the field of the other
# points has there. What is $\lambda_j$ of this point at the minimum?
#
# ## In words
#
# **03.8** Let the points be distinct, and let no hyperplane contain them. By (3.7)
# $\boldsymbol{\lambda}^T\mathbf{A}\boldsymbol{\lambda} > 0$ for every $\boldsymbol{\lambda} \neq
# \mathbf{0}$ that satisfies (3.4). Prove that (3.5) then has only one solution.
#
# <details><summary>Hint</summary>
#
# The difference of two solutions solves (3.5) with zero values: $\mathbf{A}\boldsymbol{\lambda} +
# \mathbf{B}\mathbf{c} = \mathbf{0}$ and $\mathbf{B}^T\boldsymbol{\lambda} = \mathbf{0}$. Multiply
# the first equation by $\boldsymbol{\lambda}^T$ from the left.
#
# </details>

# %% [markdown] answer="03.8" points=4 minutes=15 words=80
# The difference $(\boldsymbol{\lambda}, \mathbf{c})$ of two solutions satisfies
# $\mathbf{A}\boldsymbol{\lambda} + \mathbf{B}\mathbf{c} = \mathbf{0}$ and
# $\mathbf{B}^T\boldsymbol{\lambda} = \mathbf{0}$. From the left with $\boldsymbol{\lambda}^T$:
# $\boldsymbol{\lambda}^T\mathbf{A}\boldsymbol{\lambda} =
# -(\mathbf{B}^T\boldsymbol{\lambda})^T\mathbf{c} = 0$. The second equation is (3.4), so
# $\boldsymbol{\lambda} = \mathbf{0}$. Then $\mathbf{B}\mathbf{c} = \mathbf{0}$: an affine field
# vanishes at all points. Since no hyperplane contains them, $\mathbf{c} = \mathbf{0}$. So the two
# solutions are equal.
#
# *Beyond the question.* The constraints (3.4) do more. They supply the missing $D + 1$ equations
# for $N + D + 1$ unknowns. Affine data are reproduced, with $\boldsymbol{\lambda} = \mathbf{0}$;
# kernels alone cannot do this. Kernels grow like $R^2 \log R$ far away, but by (3.4) the factors
# $\sum_j \lambda_j$ and $\sum_j \lambda_j \mathbf{p}_j$ of the fastest terms vanish, so $f$ grows
# at most linearly. Its second derivatives decay like $R^{-2}$, so the bending energy is finite.
# Without the constraints $\mathbf{A}$ alone may be singular: for an equilateral triangle of side 1
# it is zero. The constraints are also the conditions for the least energy, with $\mathbf{c}$ as
# Lagrange multipliers. And they make the field independent of the unit of length.

# %% [markdown] rubric="03.8"
# One point for a difference of two solutions, or zero values. One for
# $\boldsymbol{\lambda}^T\mathbf{A}\boldsymbol{\lambda} = 0$ by the constraints (3.4). One for
# $\boldsymbol{\lambda} = \mathbf{0}$. One for $\mathbf{c} = \mathbf{0}$, since no hyperplane
# contains the points.

# %% [markdown]
# **03.9** The slides say about (3.5): "This is a symmetric positive definite system and will always
# have a unique solution" (page 13). Correct this sentence, with a reason for each correction.
#
# <details><summary>Hint</summary>
#
# For a positive definite matrix $\mathbf{v}^T\mathbf{H}\mathbf{v} > 0$ for each vector $\mathbf{v}
# \neq \mathbf{0}$. Try a unit vector. For uniqueness look at your flattened box, and at two equal
# points.
#
# </details>

# %% [markdown] answer="03.9" points=4 minutes=15 words=80
# The matrix is not positive definite. With the first unit vector
# $\mathbf{e}_1^T\mathbf{H}\mathbf{e}_1 = w(\mathbf{0}) = 0$, which is not positive. The trace of
# $\mathbf{H}$ is zero, so there are eigenvalues of both signs.
#
# The solution is unique for all values if and only if the points are distinct and no hyperplane
# contains them. Two equal points make two rows equal. If a hyperplane contains all points, an
# affine field that vanishes there can be added to $f$, and the sum still interpolates.
#
# *Beyond the question.* If the solution is unique, $N$ eigenvalues are positive and $D + 1$
# negative. A Cholesky factorization needs a positive pivot at each step and fails at the first,
# which is zero. Suitable are elimination with row exchanges, and a factorization
# $\mathbf{L}\mathbf{D}\mathbf{L}^T$ with pivoting and blocks of size two. On the vectors that
# satisfy (3.4) $\mathbf{A}$ is positive definite, so Cholesky is possible there.

# %% [markdown] rubric="03.9"
# One point for "not positive definite". One for a reason, such as a zero on the diagonal, the zero
# trace, or counted eigenvalues. One for distinct points, with what goes wrong otherwise. One for
# points that no hyperplane contains, with what goes wrong otherwise.

# %% [markdown]
# ## Dig deeper
#
# - *Another unit.* Multiply all points and evaluation points by 1000. Does the field change? Do
#   $\boldsymbol{\lambda}$ and $\mathbf{c}$? Show with (3.4) that $\sum_j \lambda_j
#   \lVert\mathbf{x} - \mathbf{p}_j\rVert^2$ does not depend on $\mathbf{x}$, and use it to explain
#   your observation.
# - *Lagrange multipliers.* The slides call the $\lambda_j$ Lagrange multipliers (page 11). Write
#   the conditions for a minimum of $\tfrac12\boldsymbol{\lambda}^T\mathbf{A}\boldsymbol{\lambda} -
#   \boldsymbol{\phi}^T\boldsymbol{\lambda}$ under (3.4). Which unknowns are the multipliers?
# - *Space.* In three dimensions the kernel with the least bending energy is
#   $-\lVert\mathbf{y}\rVert$. Use it instead of $w$. What happens to the gradient at the centres?
# - *Cost.* How does the time of `coefficients` grow with $N$?

# %%
progress()
