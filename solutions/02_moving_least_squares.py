# ---
# jupyter:
#   course:
#     builds_on:
#       "01": the matrix of the basis, its rank, and the normal equations
#     pages: slides, pages 8–10 and 40
#     chapters: [12-moving-least-squares]
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
# # Moving least squares
#
# One plane cannot follow a curved field. *Moving least squares* fits another plane at every
# evaluation point, with large weights for the measurements nearby. In this notebook you write the
# method and its gradient, and you learn how to choose its parameter, the length $\varepsilon$.
#
# Part 1 is the core: the method and its gradient. Part 2 is a second sitting, on accuracy and on
# the choice of $\varepsilon$.
#
# **Source**: Erleben, *Field Reconstruction: A Quick Survey of Methods* (the slides). **Search
# for**: moving least squares, LOESS (the same method in statistics), diffuse derivative,
# leave-one-out cross-validation. **Read**: Wendland, *Scattered Data Approximation*, chapter 4;
# Hastie, Tibshirani and Friedman, *The Elements of Statistical Learning*, chapters 6 and 7.
#
# Each question asks for a function or for an answer in words. Write the function, run its cell, and
# run the check below it. The check reports whether the function is right and, if it is not, which
# mistake is likely. After a check that is not right, `case()` in a new cell shows the inputs for
# which your function failed, and your values. If everybody has the same inputs, it also shows the
# right values. Arrays may hold integers, so small that no product of them overflows. Compute with
# float64, NumPy's default type. Returned lists count as arrays, an array with one entry as a
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
# # Part 1: the method and its gradient
#
# ## Local fits
#
# The dots are measurements of a wave. The grey straight line fits all of them. The orange line fits
# only the eight points that are nearest to the dotted line $x$. Move $x$.

# %%
BESIDE = {"loc": "center left", "bbox_to_anchor": (1, 0.5)}
VALUES = {"ylabel": r"value $\phi$", "ylim": (-0.8, 1.7)}
UNIT = {"xlabel": "$x$", "xlim": (-0.02, 1.02)}
TRUTH = {"color": GREY, "lw": 4, "alpha": 0.4}
SQUARE = {"xlabel": "$x_1$", "ylabel": "$x_2$", "aspect": "equal"}


def wave(t):
    return np.sin(6 * t) + t


def measured(number, noise=0.0):
    """Return random points (number, 1) of the unit interval, and the values there."""
    random = np.random.default_rng(7)
    t = random.random(number)
    return t[:, np.newaxis], wave(t) + noise * random.normal(size=number)


@draw(x=Slider(0, 1, 0.45, "x"))
def the_problem(x):
    points, values = measured(40, 0.05)
    t = points[:, 0]
    near = np.argsort(np.abs(t - x))[:8]
    side, short = np.array([0, 1]), x + np.array([-0.15, 0.15])
    everywhere = np.polyfit(t, values, 1)
    nearby = np.polyfit(t[near], values[near], 1)
    with figure(6.4, 2.8) as page:
        axes = page.subplots()
        axes.axvline(x, color="black", ls=":", lw=1)
        axes.plot(t, values, "o", ms=4, color=BLUE, label="measured")
        axes.plot(t[near], values[near], "o", color=ORANGE, label="eight nearest")
        axes.plot(side, np.polyval(everywhere, side), color=GREY, label="fit of all")
        axes.plot(short, np.polyval(nearby, short), color=ORANGE, label="fit of eight")
        axes.set(**UNIT, **VALUES)
        axes.legend(**BESIDE)
    return page


# %% [markdown]
# **What to look at.** The orange line is accurate near $x$, and nowhere else. But it jumps whenever
# another measurement becomes one of the eight nearest, so the resulting field is discontinuous.
# Weights that decrease smoothly with the distance avoid these jumps.

# %% [markdown]
# ## Weights
#
# Let $\mathbf{p}_1, \dots, \mathbf{p}_N \in \mathbb{R}^D$ be the points of the measurements, and
# $\phi_1, \dots, \phi_N$ the values. An *affine* field is
#
# $$ f(\mathbf{x}) = \mathbf{b}(\mathbf{x})^T \mathbf{c}, \qquad
#    \mathbf{b}(\mathbf{x}) = (1, x_1, \dots, x_D)^T, \qquad
#    \mathbf{c} = (c_0, c_1, \dots, c_D)^T. \tag{2.1} $$
#
# The conditions $f(\mathbf{p}_i) = \phi_i$ are $N$ equations $\mathbf{B}\mathbf{c} = \mathbf{V}$,
# with a row for each point:
#
# $$ \mathbf{B} = \begin{bmatrix} \mathbf{b}(\mathbf{p}_1)^T \\ \vdots \\ \mathbf{b}(\mathbf{p}_N)^T
#    \end{bmatrix}, \qquad
#    \mathbf{V} = \begin{bmatrix} \phi_1 \\ \vdots \\ \phi_N \end{bmatrix}. \tag{2.2} $$
#
# Least squares gives all equations the same weight. Moving least squares fixes an evaluation point
# $\mathbf{x}$ and multiplies equation $i$ by a weight that decreases with the distance of
# $\mathbf{p}_i$ from $\mathbf{x}$:
#
# $$ w_i(\mathbf{x}) = \frac{1}{r_i^2 + \varepsilon^2}, \qquad
#    r_i = \lVert \mathbf{x} - \mathbf{p}_i \rVert, \tag{2.3} $$
#
# where $\varepsilon > 0$ is a length that we choose. At $r = \varepsilon$ the weight is half of its
# value at $r = 0$.
#
# ### Example: three weights, by hand
#
# Take the points $0, 1, 2$ on a line, the values $1, 2, 6$, the evaluation point $x = 1$ and
# $\varepsilon = 1$. The distances are $1, 0, 1$, and (2.3) gives the weights
# $\tfrac12, 1, \tfrac12$.

# %% [markdown]
# ### 02.1 The weights
#
# Write a function that returns the weights of all points for one evaluation point. They must be
# accurate also far from the origin, at up to $10^5$ times their extent, and for arrays of integers.


# %% question="02.1" minutes=15
def weights(points, x, epsilon):
    """Return w_1 … w_N of (2.3), of shape (N,).

    The points have the shape (N, D), the evaluation point x has (D,), and ε is a number.
    """
    # BEGIN SOLUTION
    return 1 / (np.sum((points - x) ** 2, axis=1) + epsilon**2)
    # END SOLUTION


# %%
check("02.1")

# %% [markdown]
# The following pictures are drawn with your functions. On the right are a hundred points of your
# own: they depend on the number in `student.txt`. The area of a dot is proportional to its weight
# at the cross.


# %%
@draw(
    epsilon=Slider(0.02, 1, 0.1, "ε", logarithmic=True),
    x1=Slider(0, 1, 0.4, "x₁"),
    x2=Slider(0, 1, 0.6, "x₂"),
)
def who_counts(epsilon, x1, x2):
    r = np.linspace(0, 1, 201)
    along = weights(r[:, np.newaxis], np.zeros(1), epsilon) * epsilon**2
    points = data("02.8")[0]
    here = weights(points, np.array([x1, x2]), epsilon)
    area = 150 * here / here.max()
    with figure(6.4, 2.9) as page:
        left, right = page.subplots(1, 2)
        left.plot(r, along, color=BLUE, label="$w(r)/w(0)$")
        left.plot(r, along**2, "--", color=ORANGE, label="its square")
        left.axvline(epsilon, color="black", ls=":", lw=1)
        left.set(
            xlabel="distance $r$",
            title=rf"$\varepsilon = {epsilon:.2g}$",
            ylim=(0, 1.05),
        )
        left.legend()
        right.scatter(*points.T, s=2, color=GREY)
        right.scatter(*points.T, s=area, color=BLUE, alpha=0.6, lw=0)
        right.plot(x1, x2, "+", ms=12, color="black")
        right.set(**SQUARE)
    return page


# %% [markdown]
# ## The weighted fit at one evaluation point
#
# With the diagonal matrix $\mathbf{W}(\mathbf{x}) = \operatorname{diag}(w_1, \dots, w_N)$ the
# weighted equations are
#
# $$ \mathbf{W}(\mathbf{x})\,\mathbf{B}\,\mathbf{c} = \mathbf{W}(\mathbf{x})\,\mathbf{V}. \tag{2.4}
#    $$
#
# There are usually more equations than unknowns. Multiplying both sides by
# $(\mathbf{W}\mathbf{B})^T$ gives the *normal equations*:
#
# $$ \underbrace{\mathbf{B}^T\,\mathbf{W}(\mathbf{x})^2\,\mathbf{B}}_{\mathbf{H}(\mathbf{x})}\;
#    \mathbf{c}(\mathbf{x}) = \mathbf{B}^T\,\mathbf{W}(\mathbf{x})^2\,\mathbf{V}. \tag{2.5} $$
#
# The weights enter squared: the influence of a point is $w_i^2$, the dashed curve above. Many books
# write $\mathbf{W}$ where (2.5) has $\mathbf{W}^2$. Both methods are called moving least squares,
# and their results differ.
#
# ### Example: the weighted fit, by hand
#
# For the three points of the example the squared weights are $\tfrac14, 1, \tfrac14$. Equation
# (2.5) is
#
# $$ \begin{bmatrix} \tfrac32 & \tfrac32 \\ \tfrac32 & 2 \end{bmatrix}
#    \begin{bmatrix} c_0 \\ c_1 \end{bmatrix} = \begin{bmatrix} \tfrac{15}{4} \\ 5 \end{bmatrix}. $$
#
# The difference of the two equations is $\tfrac12 c_1 = \tfrac54$. So $c_1 = \tfrac52$, $c_0 = 0$,
# and the value at $x = 1$ is $c_0 + c_1 = \tfrac52$. Plain least squares has the value 3 there
# (notebook 01). The measured value at this point is 2, so the weighted fit is closer to it. The
# next cell checks these numbers.

# %%
three_b = np.array([[1.0, 0.0], [1.0, 1.0], [1.0, 2.0]])
three_values = np.array([1.0, 2.0, 6.0])
three_squares = np.array([0.25, 1.0, 0.25])
three_h = (three_b.T * three_squares) @ three_b
print("H:", three_h.tolist())
print("right-hand side:", (three_b.T * three_squares) @ three_values)
print("H c for c = (0, 5/2):", three_h @ np.array([0.0, 2.5]))


# %% [markdown]
# ### 02.2 The coefficients
#
# Write a function that solves (2.5) for given weights, all of them positive. In all questions of
# this notebook the points determine the coefficients, and here they are near the origin, in any
# unit of length. Small weights, down to $10^{-5}$ of the largest, count, too: where all points of
# large weight are near one line, the others determine the slope across this line.
#
# <details><summary>Hint</summary>
#
# Build $\mathbf{B}$ of 01.1 first: a column of ones, then the columns of the points. Avoid the $N
# \times N$ matrix $\mathbf{W}$. Multiplication by a diagonal matrix from the left multiplies each
# row by a number. NumPy does the same by broadcasting: an array of shape $(N, 1)$ multiplies the
# rows of an array of shape $(N, D + 1)$.
#
# </details>


# %% question="02.2" minutes=15
def weighted_fit(points, values, w):
    """Return c of (2.5), of shape (D + 1,).

    The points have the shape (N, D), the values (N,) and the weights w (N,).
    """
    # BEGIN SOLUTION
    b = np.column_stack([np.ones(len(points)), points])
    h = b.T @ (w[:, np.newaxis] ** 2 * b)
    return np.linalg.solve(h, b.T @ (w**2 * values))
    # END SOLUTION


# %%
check("02.2")

# %% [markdown]
# With equal weights the fit is plain least squares, the grey line. With your weights of 02.1 it is
# the orange line, which belongs to one evaluation point $x$. Move $x$, then change $\varepsilon$.


# %%
@draw(
    x=Slider(0, 1, 0.45, "x"),
    epsilon=Slider(0.01, 2, 0.05, "ε", logarithmic=True),
)
def line_at_a_point(x, epsilon):
    points, v = measured(40, 0.05)
    here = weights(points, np.array([x]), epsilon)
    plain, local = (weighted_fit(points, v, w) for w in (np.ones(40), here))
    side, value = np.array([0, 1]), local[0] + local[1] * x
    with figure(6.4, 2.8) as page:
        axes = page.subplots()
        axes.axvline(x, color="black", ls=":", lw=1)
        axes.scatter(points[:, 0], v, s=8, color=BLUE)
        area = 120 * (here / here.max()) ** 2
        axes.scatter(points[:, 0], v, s=area, color=BLUE, alpha=0.5, lw=0)
        axes.plot(side, plain[0] + plain[1] * side, color=GREY, label="equal weights")
        axes.plot(side, local[0] + local[1] * side, color=ORANGE, label="your fit at $x$")
        axes.plot(x, value, "o", ms=8, color=ORANGE, label=r"$f(x)$")
        axes.set(**UNIT, **VALUES)
        axes.legend(**BESIDE)
    return page


# %% [markdown]
# **What to look at.** As $x$ moves, the orange line rotates smoothly and does not jump. Points
# within a few $\varepsilon$ of $x$ dominate the fit. If $\varepsilon$ is smaller than the spacing
# of the points, the few nearest points dominate. For large $\varepsilon$ all weights are nearly
# equal, and the orange line approaches the grey one.

# %% [markdown]
# ### In words
#
# **02.3** For which points $\mathbf{p}_1, \dots, \mathbf{p}_N$ is the matrix
# $\mathbf{H}(\mathbf{x})$ of (2.5) non-singular at every evaluation point $\mathbf{x}$, with the
# weights (2.3)? Prove your answer.
#
# <details><summary>Hint</summary>
#
# When is $\mathbf{H}\mathbf{c} = \mathbf{0}$? Write $\mathbf{c}^T\mathbf{H}\mathbf{c}$ as the
# square of a norm.
#
# </details>

# %% [markdown] answer="02.3" points=4 minutes=15 words=80
# It is non-singular if and only if no hyperplane contains all points. All weights are positive, so
# $\mathbf{W}$ is invertible at every $\mathbf{x}$. If $\mathbf{H}\mathbf{c} = \mathbf{0}$, then
# $\lVert \mathbf{W}\mathbf{B}\mathbf{c} \rVert^2 = \mathbf{c}^T\mathbf{H}\mathbf{c} = 0$, and
# $\mathbf{B}\mathbf{c} = \mathbf{0}$: the affine field with coefficients $\mathbf{c}$ vanishes at
# every point. For $\mathbf{c} \neq \mathbf{0}$ its zeros form a hyperplane, or there are none.
# Conversely, if a hyperplane contains all points, some affine field $\mathbf{c} \neq \mathbf{0}$
# vanishes at all of them, and $\mathbf{H}\mathbf{c} = \mathbf{0}$.
#
# *Beyond the question.* The hyperplane is a line for $D = 2$ and a plane for $D = 3$. At least $D +
# 1$ points are needed. With weights that vanish beyond some distance only the points with positive
# weight would count, and the answer would depend on $\mathbf{x}$.

# %% [markdown] rubric="02.3"
# One point for the condition that no hyperplane contains all points. One for using that all weights
# are positive, so that the evaluation point has no influence. One for the square of the norm, which
# gives $\mathbf{B}\mathbf{c} = \mathbf{0}$. One for the affine field that vanishes at all points.
# The converse is not required.

# %% [markdown]
# ## The field
#
# The coefficients $\mathbf{c}(\mathbf{x})$ belong to the evaluation point $\mathbf{x}$, where the
# field has the value
#
# $$ f(\mathbf{x}) = \mathbf{b}(\mathbf{x})^T \mathbf{c}(\mathbf{x}). \tag{2.6} $$
#
# Each further evaluation point requires the solution of another system. This is the meaning of
# *moving* in the name of the method.
#
# ### 02.4 The field at many evaluation points
#
# Write a function that evaluates (2.6) at $M$ evaluation points. The points of the data are near
# the origin, in any unit of length. A loop over the evaluation points is fine.


# %% question="02.4" minutes=20
def field(points, values, x, epsilon):
    """Return f of (2.6) at M evaluation points x, of shape (M,).

    The evaluation points have the shape (M, D), the points (N, D) and the values (N,).
    """
    # BEGIN SOLUTION
    result = []
    for query in x:
        c = weighted_fit(points, values, weights(points, query, epsilon))
        result.append(c[0] + c[1:] @ query)
    return np.array(result)
    # END SOLUTION


# %%
check("02.4")


# %%
@draw(
    epsilon=Slider(0.01, 3, 0.05, "ε", logarithmic=True),
    number=Slider(4, 80, 20, "points", whole=True),
    noise=Slider(0, 0.5, 0, "noise"),
)
def curve(epsilon, number, noise):
    points, v = measured(number, noise)
    side = np.linspace(0, 1, 301)
    yours = field(points, v, side[:, np.newaxis], epsilon)
    with figure(6.4, 3.0) as page:
        axes = page.subplots()
        axes.plot(side, wave(side), **TRUTH, label=r"$\phi$, the truth")
        axes.plot(points[:, 0], v, "o", ms=5, color=BLUE, label="measured")
        axes.plot(side, yours, color=ORANGE, label="your field")
        axes.set(**UNIT, **VALUES | {"ylim": (-1.2, 2.2)})
        axes.set_title(rf"{number} points, $\varepsilon$ = {epsilon:.2g}")
        axes.legend(**BESIDE)
    return page


# %% [markdown]
# **What to look at.**
#
# - Without noise, make $\varepsilon$ small. Does the curve pass *through* the points, or only close
#   to them? Make $\varepsilon$ large. Which curve does the field approach?
# - Take four points, then eighty. How does the error change where the points are dense?
# - Now add noise, and note an $\varepsilon$ for which the curve is close to the truth. Part 2 comes
#   back to this choice.
#
# The next picture shows the same in the plane, with your own points (the dots) and the field
# $\phi(\mathbf{x}) = (x_1 + x_2)^n$: the truth, least squares, and your field.


# %%
@draw(
    n=Slider(1, 6, 3, "power n", whole=True),
    epsilon=Slider(0.01, 3, 0.1, "ε", logarithmic=True),
)
def maps(n, epsilon):
    points = data("02.8")[0]
    v = points.sum(axis=1) ** n
    side = np.linspace(0, 1, 33)
    grid = np.stack(np.meshgrid(side, side), axis=-1)
    plane = weighted_fit(points, v, np.ones(100))
    moving = field(points, v, grid.reshape(-1, 2), epsilon).reshape(33, 33)
    shown = {
        r"$\phi = (x_1 + x_2)^" + f"{n}$": grid.sum(axis=-1) ** n,
        "least squares": plane[0] + grid @ plane[1:],
        rf"yours, $\varepsilon = {epsilon:.2g}$": moving,
    }
    with figure(6.8, 2.6) as page:
        panels = page.subplots(1, 3, sharey=True)
        for axes, (title, heights) in zip(panels, shown.items(), strict=True):
            levels = np.linspace(0, 2**n, 17)
            image = axes.contourf(side, side, heights, levels, extend="both")
            axes.plot(*points.T, ".", ms=3, color="white", mec="black", mew=0.3)
            axes.set(title=title, **SQUARE, xticks=[0, 1], yticks=[0, 1])
            axes.label_outer()
        page.colorbar(image, ax=list(panels))
    return page


# %% [markdown]
# ## The objective
#
# The residual of (2.4) is $\mathbf{e} = \mathbf{W}(\mathbf{x})\mathbf{B}\mathbf{c} -
# \mathbf{W}(\mathbf{x})\mathbf{V}$. Half of its squared norm is
#
# $$ \psi(\mathbf{c}; \mathbf{x})
#    = \tfrac{1}{2} \lVert \mathbf{W}(\mathbf{x})(\mathbf{B}\mathbf{c} - \mathbf{V}) \rVert^2
#    = \tfrac{1}{2} \sum_{i=1}^N w_i(\mathbf{x})^2
#      \left( \mathbf{b}(\mathbf{p}_i)^T \mathbf{c} - \phi_i \right)^2. \tag{2.7} $$
#
# There is one such function for each evaluation point $\mathbf{x}$. For the example by hand the
# residual $\mathbf{B}\mathbf{c} - \mathbf{V}$ is $(-1, \tfrac12, -1)$, and $\psi = \tfrac12
# (\tfrac14 + \tfrac14 + \tfrac14) = \tfrac38$.
#
# ### 02.5 The objective
#
# Write $\psi$ for any coefficients, not only for the best ones. The residuals may be a million
# times smaller than the values.


# %% question="02.5" minutes=10
def objective(points, values, x, epsilon, coefficients):
    """Return ψ(c; x) of (2.7), a number.

    The evaluation point x has the shape (D,), the coefficients c have (D + 1,).
    """
    # BEGIN SOLUTION
    residual = coefficients[0] + points @ coefficients[1:] - values
    return 0.5 * np.sum((weights(points, x, epsilon) * residual) ** 2)
    # END SOLUTION


# %%
check("02.5")

# %% [markdown]
# On a line there are two coefficients, so $\psi$ is a function of two variables. The left picture
# shows its level lines. Its axes are the value $c_0 + c_1 x$ and the slope $c_1$ of a straight
# line. The dot is the result of your `weighted_fit`. The thin curve is the path of the dot as $x$
# goes from 0 to 1. Move $x$.


# %%
@draw(
    x=Slider(0, 1, 0.45, "x"),
    epsilon=Slider(0.01, 2, 0.05, "ε", logarithmic=True),
)
def valley(x, epsilon):
    points, v = measured(40, 0.05)

    def best(at):
        return weighted_fit(points, v, weights(points, np.array([at]), epsilon))

    lowest = best(x)
    path = np.linspace(0, 1, 101)
    lines = np.array([best(at) for at in path])

    def height(value, slope):
        line = np.array([value - slope * x, slope])
        return objective(points, v, np.array([x]), epsilon, line)

    value, slope = np.linspace(-1, 2, 121), np.linspace(-12, 12, 61)
    heights = [[height(a, b) for a in value] for b in slope]
    side = np.linspace(0, 1, 2)
    with figure(6.4, 3.0) as page:
        left, right = page.subplots(1, 2)
        levels = np.min(heights) * 2.0 ** np.arange(1, 16)
        left.contour(value, slope, heights, levels, norm="log", linewidths=0.9)
        left.plot(lines[:, 0] + path * lines[:, 1], lines[:, 1], color=GREY, lw=1)
        left.plot(lowest[0] + x * lowest[1], lowest[1], "o", ms=8, color=ORANGE)
        left.set(xlabel="value at $x$", ylabel="slope $c_1$")
        left.set_title(r"$\psi(\mathbf{c}; x)$, level lines")
        right.axvline(x, color="black", ls=":", lw=1)
        right.plot(points[:, 0], v, ".", color=BLUE)
        right.plot(side, lowest[0] + lowest[1] * side, color=ORANGE)
        right.set(**UNIT, **VALUES, title="the line of the minimum")
    return page


# %% [markdown]
# **What to look at.** For every $x$ the function has one minimum, at the bottom of a long valley.
# The valley is long because lines with the same value at $x$ and another slope are nearly as good:
# only points close to $x$ have large weights. How does the valley change for a large $\varepsilon$?
#
# ### In words
#
# **02.6** Show that the solution of (2.5) is
# the only minimum of $\psi(\mathbf{c}; \mathbf{x})$ with respect to $\mathbf{c}$, if
# $\mathbf{H}(\mathbf{x})$ is non-singular.
#
# <details><summary>Hint</summary>
#
# Compute the gradient of $\psi$ with respect to $\mathbf{c}$ for a fixed $\mathbf{x}$, then the
# matrix of its second derivatives. You know this matrix.
#
# </details>

# %% [markdown] answer="02.6" points=3 minutes=10 words=50
# For fixed $\mathbf{x}$, $\nabla_{\mathbf{c}}\psi =
# (\mathbf{W}\mathbf{B})^T(\mathbf{W}\mathbf{B}\mathbf{c} - \mathbf{W}\mathbf{V}) =
# \mathbf{B}^T\mathbf{W}^2(\mathbf{B}\mathbf{c} - \mathbf{V})$, because $\mathbf{W}$ is diagonal. It
# is zero if and only if (2.5) holds. The matrix of second derivatives is $\mathbf{H}$, which is
# positive semi-definite, hence positive definite if non-singular. So $\psi$ is strictly convex, and
# the zero of its gradient is its only minimum.
#
# *Beyond the question.* The same follows without convexity from the completed square:
# $\psi(\mathbf{c}^* + \mathbf{d}) = \psi(\mathbf{c}^*) + \tfrac12
# \mathbf{d}^T\mathbf{H}\mathbf{d} > \psi(\mathbf{c}^*)$ for every $\mathbf{d} \neq \mathbf{0}$.

# %% [markdown] rubric="02.6"
# One point for the gradient, with the square of $\mathbf{W}$ explained. One for convexity, or the
# completed square. One for uniqueness: $\mathbf{H}$ is positive definite if it is non-singular.

# %% [markdown]
# ## The gradient
#
# Forces follow from the gradient of a pressure, so we often need the gradient of $f$ and not $f$
# itself. By the product rule, (2.6) has
#
# $$ \frac{\partial f}{\partial x_k} = c_k(\mathbf{x}) +
#    \mathbf{b}(\mathbf{x})^T \frac{\partial \mathbf{c}}{\partial x_k}(\mathbf{x}). \tag{2.8} $$
#
# The first term is the slope of the fitted plane, the *diffuse derivative*. It is not the
# derivative of $f$: the coefficients of the plane change with $\mathbf{x}$ too, and the second term
# is the effect of this change.
#
# Differentiate both sides of (2.5) by $x_k$ on paper. Neither $\mathbf{B}$ nor $\mathbf{V}$ depends
# on $\mathbf{x}$. In $\mathbf{W}^2$ each entry $w_i^2$ does, by (2.3). Bring everything except
# $\mathbf{H}\,\partial\mathbf{c}/\partial x_k$ to the right-hand side.
#
# ### A finished function: central differences
#
# Every gradient should be tested by differences before it is used. The *central difference* of $f$
# in the direction of coordinate $k$ is
#
# $$ \frac{f(\mathbf{x} + h\mathbf{e}_k) - f(\mathbf{x} - h\mathbf{e}_k)}{2h}
#    = \frac{\partial f}{\partial x_k}(\mathbf{x}) + O(h^2). $$
#
# For $g(\mathbf{x}) = x_1^2 x_2$ at $\mathbf{x} = (1, 2)$ the gradient is
# $(2 x_1 x_2, x_1^2) = (4, 1)$. With $h = 0.1$ the first central difference is
# $(1.1^2 \cdot 2 - 0.9^2 \cdot 2)/0.2 = 4$. The function below is finished; imitate its style.


# %%
def differences(f, x, h):
    """Return central differences of f with step h at M points x, of shape (M, D).

    The points have the shape (M, D). The function f maps points (M, D) to values (M,).
    """
    columns = []
    for k in range(x.shape[1]):
        step = np.zeros(x.shape[1])
        step[k] = h
        columns.append((f(x + step) - f(x - step)) / (2 * h))
    return np.stack(columns, axis=1)


def example_field(x):
    return x[:, 0] ** 2 * x[:, 1]


print(differences(example_field, np.array([[1.0, 2.0]]), 0.1))


# %% [markdown]
# ### 02.7 The gradient at many evaluation points
#
# Write the gradient of $f$, with both terms of (2.8). It must be the derivative of the function of
# 02.4, and as there the points are near the origin, in any unit of length. Compute it from the
# formulas. A difference quotient is a test, but no substitute: no step $h$ suits every unit of
# length.
#
# <details><summary>Hint: the derivative of the system</summary>
#
# On the left-hand side the product rule gives two terms. Move the one with the derivative of
# $\mathbf{H}$ to the right-hand side, and combine it with the derivative of the right-hand side.
# Between $\mathbf{B}^T$ and the end then stands the derivative of $\mathbf{W}^2$, times the
# residual $\mathbf{r} = \mathbf{V} - \mathbf{B}\mathbf{c}(\mathbf{x})$.
#
# </details>
#
# <details><summary>Hint: the derivative of a squared weight</summary>
#
# Write $w_i^2 = s^{-2}$ with $s = r_i^2 + \varepsilon^2$, and use the chain rule. What is the
# derivative of $r_i^2$ by $x_k$? Write the result as $w_i^2$ times a factor.
#
# </details>
#
# <details><summary>Hint: a function for the new system</summary>
#
# Write the right-hand side as $\mathbf{B}^T\mathbf{W}^2\mathbf{g}$. Then the derivative of
# $\mathbf{c}$ solves (2.5) with the data $\mathbf{g}$ instead of $\mathbf{V}$. You have a function
# for that.
#
# </details>


# %% question="02.7" minutes=40
def gradient(points, values, x, epsilon):
    """Return the gradient of f at evaluation points x, all of (2.8), of shape (M, D).

    The evaluation points have the shape (M, D), the points (N, D) and the values (N,).
    """
    # BEGIN SOLUTION
    result = np.empty(x.shape)
    for j, query in enumerate(x):
        w = weights(points, query, epsilon)
        c = weighted_fit(points, values, w)
        residual = values - c[0] - points @ c[1:]
        for k in range(len(query)):
            g = -4 * w * (query[k] - points[:, k]) * residual
            dc = weighted_fit(points, g, w)
            result[j, k] = c[1 + k] + dc[0] + dc[1:] @ query
    return result
    # END SOLUTION


# %% [markdown]
# **Exercise: test your gradient by differences** (not graded). Before you run the
# check, run the next cell. It compares your gradient with central differences of your field, for
# steps from $10^{-1}$ to $10^{-12}$.


# %%
@draw(epsilon=Slider(0.05, 1, 0.3, "ε", logarithmic=True))
def gradient_test(epsilon):
    points, v, x, _ = data("02.7")
    yours = gradient(points, v, x, epsilon)

    def f(y):
        return field(points, v, y, epsilon)

    steps = 10.0 ** -np.arange(1, 13)
    off = [np.abs(differences(f, x, h) - yours).max() for h in steps]
    with figure(5.4, 2.8) as page:
        axes = page.subplots()
        axes.loglog(steps, off / np.abs(yours).max(), "o-", color=ORANGE)
        axes.set(xlabel="step $h$", ylabel="largest relative difference", ylim=(1e-13, 10))
    return page


# %% [markdown]
# **What to look at.** If the gradient is right, the curve falls in proportion to $h^2$ as $h$
# decreases, to about $10^{-9}$. Then it rises in proportion to $1/h$, because the rounding errors
# of $f$ are divided by $h$. If the gradient is wrong, the curve does not fall. Why is the best step
# smaller for small $\varepsilon$?

# %%
check("02.7")

# %% [markdown]
# The dots below are differences of neighbouring values of your field. The dashed line is the
# diffuse derivative, the first term of (2.8) alone.


# %%
@draw(epsilon=Slider(0.02, 1, 0.08, "ε", logarithmic=True))
def slopes(epsilon):
    points, v = measured(20)
    side = np.linspace(0, 1, 201)
    heights = field(points, v, side[:, np.newaxis], epsilon)
    around = [weights(points, np.array([at]), epsilon) for at in side]
    tilts = [weighted_fit(points, v, w)[1] for w in around]
    middles = (side[1:] + side[:-1]) / 2
    differences = np.diff(heights) / np.diff(side)
    with figure(6.4, 4.2) as page:
        top, bottom = page.subplots(2, 1, sharex=True)
        top.plot(side, wave(side), **TRUTH, label=r"$\phi$")
        top.plot(points[:, 0], v, "o", ms=4, color=BLUE, label="measured")
        top.plot(side, heights, color=ORANGE, label="your field")
        bottom.plot(side, 6 * np.cos(6 * side) + 1, **TRUTH, label=r"$\phi'$")
        bottom.plot(side, tilts, "--", color=PURPLE, label="slope of the fit")
        yours = gradient(points, v, side[:, np.newaxis], epsilon)
        bottom.plot(side, yours, color=ORANGE, label="your gradient")
        bottom.plot(middles[::5], differences[::5], "k.", label="differences")
        top.set(ylabel="value")
        bottom.set(**UNIT, ylabel="slope")
        for axes in (top, bottom):
            axes.legend(**BESIDE)
    return page


# %% [markdown]
# **What to look at.** The differences lie on your gradient, not on the dashed line. Which of the
# two is closer to the slope of the truth? For a very small $\varepsilon$ it is the dashed line,
# which does not follow the small oscillations of $f$. If $\varepsilon$ is the spacing of the points
# or more, it is your gradient. So the diffuse derivative can be a good estimate of $\phi'$, but it
# is *not* the derivative of $f$. If forces must be consistent with a potential, so that energy is
# conserved, the full gradient is needed.

# %% [markdown]
# # Part 2 (optional): accuracy and the choice of ε
#
# ## The root-mean-square error
#
# The test field is $\phi(\mathbf{x}) = (x_1 + x_2)^n$, measured at random points of the unit
# square. Both methods use the same values. Both are evaluated at the same points $\mathbf{x}_1,
# \dots, \mathbf{x}_M$, none of which is a measured point. The *root-mean-square error* is
#
# $$ E = \sqrt{ \frac{1}{M} \sum_{j=1}^M
#    \bigl( f(\mathbf{x}_j) - \phi(\mathbf{x}_j) \bigr)^2 }. \tag{2.9} $$
#
# For two evaluation points with the errors $3$ and $-4$ it is $\sqrt{(9 + 16)/2} \approx 3.54$.
#
# ### 02.8 Least squares against moving least squares
#
# Write a function that returns $E$ for plain least squares and for moving least squares, in
# this order. The power $n$ is a positive integer. The points may also lie outside of the unit
# square.
#
# <details><summary>Hint</summary>
#
# Your `weighted_fit` can also do plain least squares. Which weights treat all points alike?
#
# </details>


# %% question="02.8" minutes=15 optional
def errors(points, queries, n, epsilon):
    """Return E of (2.9) for least and for moving least squares, of shape (2,).

    The field (x_1 + x_2)ⁿ is measured at points (N, 2). Both methods are evaluated at
    queries (M, 2).
    """
    # BEGIN SOLUTION
    values, truth = np.sum(points, axis=1) ** n, np.sum(queries, axis=1) ** n
    c = weighted_fit(points, values, np.ones(len(points)))
    plain = c[0] + queries @ c[1:] - truth
    moving = field(points, values, queries, epsilon) - truth
    return np.sqrt([np.mean(plain**2), np.mean(moving**2)])
    # END SOLUTION


# %%
check("02.8")

# %% [markdown]
# The picture shows your own hundred points and ten evaluation points.


# %%
@draw(epsilon=Slider(0.01, 3, 0.05, "ε", logarithmic=True))
def comparison(epsilon):
    points, queries = data("02.8")[:2]
    powers = range(2, 9)
    both = np.array([errors(points, queries, n, epsilon) for n in powers])
    first = max(errors(points, queries, 1, epsilon))
    with figure(6.4, 3.0) as page:
        left, right = page.subplots(1, 2, width_ratios=(1, 1.5))
        left.plot(*points.T, ".", ms=4, color=BLUE, label="measured")
        left.plot(*queries.T, "x", color=ORANGE, label="evaluated")
        left.set(**SQUARE)
        left.legend(loc="lower center", bbox_to_anchor=(0.5, 1), ncols=2)
        names = ("least squares", "moving least squares")
        for name, line, color, rms in zip(names, ("s--", "o-"), (GREY, ORANGE), both.T):
            right.semilogy(powers, rms, line, color=color, label=name)
        exact = "both exact, to rounding" if first < 1e-10 else f"error {first:.1g}"
        right.set(xlabel="power $n$", ylabel="error $E$", title=f"$n = 1$: {exact}")
        right.set_ylim(top=12 * both.max())
        right.legend(loc="upper left")
    return page


# %% [markdown]
# **What to look at.** Why are both methods exact for $n = 1$? For $n = 2, 3, \dots$ both errors
# grow, since the field is steeper towards the corner $(1, 1)$. By which factor is moving least
# squares more accurate? Ten evaluation points are few: run `errors` with a thousand before you
# trust the factor. How does the comparison change for the largest $\varepsilon$?

# %% [markdown]
# ## The choice of ε
#
# Here $\phi$ is known, so we can compute the error for every $\varepsilon$. The field is $(x_1 +
# x_2)^n$ at your hundred points, with optional noise. The error (2.9) is taken at three hundred
# random evaluation points.

# %%
WIDTHS = np.geomspace(0.01, 3, 16)


def noisy(n, noise):
    """Return your points, noisy values of (x_1 + x_2)ⁿ there, and 300 evaluation points."""
    points, random = data("02.8")[0], np.random.default_rng(3)
    v = points.sum(axis=1) ** n + noise * random.normal(size=len(points))
    return points, v, random.random((300, 2))


def true_errors(n, noise):
    points, v, many = noisy(n, noise)
    truth = many.sum(axis=1) ** n
    off = [field(points, v, many, width) - truth for width in WIDTHS]
    return np.sqrt(np.mean(np.square(off), axis=1))


@draw(n=Slider(1, 6, 3, "power n", whole=True), noise=Slider(0, 1, 0.3, "noise"))
def error_against_width(n, noise):
    with figure(6.4, 2.8) as page:
        axes = page.subplots()
        for sigma, color in ((0.0, BLUE), (noise, ORANGE)):
            rms = true_errors(n, sigma)
            axes.semilogx(WIDTHS, rms, color=color, label=f"noise {sigma:.2g}")
            axes.plot(WIDTHS[rms.argmin()], rms.min(), "o", color=color)
        axes.axvline(0.1, color="black", ls=":", lw=1)
        top = max(axes.get_ylim()[1], 1e-3)
        axes.text(0.105, top, "spacing of\nthe points", va="top")
        axes.set(xlabel=r"$\varepsilon$", ylabel="error $E$", ylim=(0, top))
        axes.legend(**BESIDE)
    return page


# %% [markdown]
# **What to look at.** Without noise the curve is flat on the left: all small $\varepsilon$ have the
# same error, and a large $\varepsilon$ has a larger one. With noise there is a best $\varepsilon$,
# which grows with the noise. This is the *bias–variance trade-off*. Set $n = 1$: now the largest
# $\varepsilon$ is the best. Why?
#
# ### Minimizing ψ over ε
#
# In practice $\phi$ is unknown, and so is this curve. We need a criterion that uses the
# measurements alone. The slides suggest $\psi$ of (2.7), whose minimum defines the coefficients
# (page 40). The next picture shows the minimum of $\psi$ as a function of $\varepsilon$, at three
# of your evaluation points.


# %%
@draw(noise=Slider(0, 1, 0.3, "noise"))
def least_objective(noise):
    points, v, _ = noisy(3, noise)
    with figure(6.4, 2.8) as page:
        axes = page.subplots()
        queries = data("02.8")[1][:3]
        for query, color in zip(queries, (BLUE, ORANGE, GREEN), strict=True):
            lowest, label = [], f"({query[0]:.2f}, {query[1]:.2f})"
            for width in WIDTHS:
                c = weighted_fit(points, v, weights(points, query, width))
                lowest.append(objective(points, v, query, width, c))
            axes.loglog(WIDTHS, lowest, color=color, label=label)
        axes.set(xlabel=r"$\varepsilon$", ylabel=r"minimum of $\psi$ over $\mathbf{c}$")
        axes.legend(title=r"at $\mathbf{x} =$")
    return page


# %% [markdown]
# **What to look at.** For which $\varepsilon$ is $\psi$ smallest? Does this $\varepsilon$ depend on
# the noise, or on the values? Question 02.10 asks for the reason.
#
# ## Leave-one-out cross-validation
#
# A valid test predicts a measurement that the method has not used. Leave out the measurement
# $(\mathbf{p}_i, \phi_i)$, compute the field $f_{-i}$ of the other $N - 1$ measurements, and take
# its error:
#
# $$ e_i = \phi_i - f_{-i}(\mathbf{p}_i), \qquad i = 1, \dots, N. \tag{2.10} $$
#
# Only the measurements are needed for this. The mean of $e_i^2$ estimates the error of prediction,
# and the $\varepsilon$ with the smallest mean is chosen.
#
# ### 02.9 The leave-one-out errors
#
# Write a function that returns all $e_i$. They must be accurate also if $\varepsilon$ is much
# smaller than the spacing of the points. A point may be measured twice: then each measurement is
# left out by itself, and the other one counts.
#
# <details><summary>Hint</summary>
#
# Use your `field`. A boolean array selects all rows except one. NumPy also has a function that
# deletes a row. The evaluation point is $\mathbf{p}_i$, as an array of shape $(1, D)$.
#
# </details>


# %% question="02.9" minutes=25 optional
def leave_one_out(points, values, epsilon):
    """Return e_1 … e_N of (2.10), of shape (N,).

    The points have the shape (N, D) and the values (N,).
    """
    # BEGIN SOLUTION
    result = np.empty(len(points))
    for i in range(len(points)):
        others = np.arange(len(values)) != i
        f = field(points[others], values[others], points[[i]], epsilon)
        result[i] = values[i] - f.item()
    return result
    # END SOLUTION


# %%
check("02.9")

# %% [markdown]
# The next picture compares four criteria on your points, as functions of $\varepsilon$: the true
# error, the leave-one-out error, $\psi$, and the normalized $\bar\psi = \psi / \sum_i w_i^2$. The
# last one is half a weighted mean of squared residuals. Each curve is divided by its minimum,
# which a dot marks. The number in brackets is the ratio of two true errors: at the $\varepsilon$
# of this criterion, and at the best $\varepsilon$.


# %%
@draw(n=Slider(1, 6, 3, "power n", whole=True), noise=Slider(0, 1, 0.3, "noise"))
def criteria(n, noise):
    points, v, _ = noisy(n, noise)
    truth = true_errors(n, noise)
    unseen, sums, means = [], [], []
    for width in WIDTHS:
        unseen.append(np.sqrt(np.mean(leave_one_out(points, v, width) ** 2)))
        lowest, total = [], []
        for query in data("02.8")[1]:
            there = weights(points, query, width)
            best = weighted_fit(points, v, there)
            lowest.append(objective(points, v, query, width, best))
            total.append(np.sum(there**2))
        sums.append(np.sum(lowest))
        means.append(np.sum(np.divide(lowest, total)))
    curves = (
        ("true error", truth, GREY, "-"),
        ("leave-one-out", unseen, GREEN, "--"),
        (r"$\psi$", sums, ORANGE, "-."),
        (r"$\bar\psi$", means, PURPLE, ":"),
    )
    with figure(6.8, 3.2) as page:
        axes = page.subplots()
        for name, curve, color, line in curves:
            ratio = np.maximum(curve, 1e-9) / max(np.min(curve), 1e-9)
            choice = ratio.argmin()
            regret = max(truth[choice], 1e-9) / max(truth.min(), 1e-9)
            label, size = f"{name} (×{regret:.2f})", 9 if color == GREY else 7
            axes.loglog(WIDTHS, ratio, line, color=color, label=label)
            axes.plot(WIDTHS[choice], 1, "o", color=color, ms=size)
        axes.set(xlabel=r"$\varepsilon$", ylabel="ratio to the minimum", ylim=(0.8, 40))
        axes.legend(**BESIDE, title="criterion (×error)")
    return page


# %% [markdown]
# **What to look at.** Set the noise to zero, then to 0.3, then to 1. Which criteria change their
# choice, and which do not? Then set $n = 1$ with noise: now $\psi$ chooses well. Is $\psi$
# therefore a good criterion?
#
# ## Real data: heights of a landscape
#
# The file `fieldcheck/datasets/terrain.json` holds 3000 heights around Cross Mountain in
# Tennessee. They were measured by the Shuttle Radar Topography Mission (public domain). `terrain()`
# returns the points in kilometres and the heights in metres. Suppose that only some of these
# heights are known. The left map shows all heights, the right map your field from the dots.


# %%
def survey(number):
    """Return points and heights of a survey, and of 500 other points of the landscape."""
    points, heights = terrain()
    order = np.random.default_rng(1).permutation(len(points))
    known, others = order[:number], order[-500:]
    return points[known], heights[known], points[others], heights[others]


@draw(
    epsilon=Slider(0.05, 10, 0.5, "ε in km", logarithmic=True),
    number=Slider(50, 400, 250, "points", whole=True),
)
def landscape(epsilon, number):
    points, heights = terrain()
    x, y = np.unique(points[:, 0]), np.unique(points[:, 1])
    known, known_heights, _, _ = survey(number)
    yours = field(known, known_heights, points, epsilon)
    rms = np.sqrt(np.mean((yours - heights) ** 2))
    with figure(6.8, 3.0) as page:
        panels = page.subplots(1, 2, sharey=True)
        titles = ("measured heights", f"your field: error {rms:.0f} m")
        for axes, title, shown in zip(panels, titles, (heights, yours), strict=True):
            levels = np.linspace(200, 1100, 19)
            grid = shown.reshape(len(y), len(x))
            image = axes.contourf(x, y, grid, levels, extend="both", cmap="terrain")
            axes.set(title=title, aspect="equal", xlabel="km to the east")
        panels[0].set(ylabel="km to the north")
        panels[1].plot(*known.T, ".", ms=2, color="black")
        page.colorbar(image, ax=list(panels), label="height in metres")
    return page


@draw(
    number=Slider(50, 400, 250, "points", whole=True),
    noise=Slider(0, 200, 0, "noise in m"),
)
def landscape_errors(number, noise):
    known, heights, others, truth = survey(number)
    heights = heights + noise * np.random.default_rng(2).normal(size=number)
    widths = np.geomspace(0.05, 10, 12)
    off = [field(known, heights, others, width) - truth for width in widths]
    unseen = [leave_one_out(known, heights, width) for width in widths]
    with figure(6.4, 2.8) as page:
        axes = page.subplots()
        rms, predicted = (np.sqrt(np.mean(np.square(e), axis=1)) for e in (off, unseen))
        axes.semilogx(widths, rms, color=GREY, label="true error at 500 points")
        axes.semilogx(widths, predicted, "--", color=GREEN, label="leave-one-out error")
        for curve, color in ((rms, GREY), (predicted, GREEN)):
            axes.plot(widths[curve.argmin()], curve.min(), "o", color=color)
        axes.set(xlabel=r"$\varepsilon$ in km", ylabel="error in metres", ylim=(0, None))
        axes.legend(**BESIDE)
    return page


# %% [markdown]
# **What to look at.** Without noise the error is nearly constant for $\varepsilon$ below 0.4 km. It
# grows where $\varepsilon$ exceeds the spacing of the points, which is 0.85 km for 250 points.
# These heights have little noise, so averaging does not help. Set the noise to 100 m. Now the true
# error is smallest for an $\varepsilon$ of about 0.6 km, and leave-one-out selects 0.9 km. The true
# errors of the two choices differ by 2 %. Why is the leave-one-out error with this noise larger
# than the true error?
#
# ### In words
#
# **02.10** The $\varepsilon$ with the smallest minimum of $\psi$ over $\mathbf{c}$ is not a good
# one, whereas leave-one-out cross-validation selects a good one, also for noisy data. Explain this;
# begin with a proof that the minimum of $\psi$ never increases with $\varepsilon$, whatever the
# data.
#
# <details><summary>Hint</summary>
#
# Keep $\mathbf{c}$ fixed and increase $\varepsilon$. How does each term of the sum in (2.7) change?
# Can the minimum over $\mathbf{c}$ then grow?
#
# </details>

# %% [markdown] answer="02.10" points=5 minutes=20 words=130 optional
# Let $\psi_1$ and $\psi_2$ belong to $\varepsilon_1 < \varepsilon_2$, with the minimizers
# $\mathbf{c}_1$ and $\mathbf{c}_2$. For fixed $\mathbf{c}$ every weight $w_i = 1/(r_i^2 +
# \varepsilon^2)$ decreases as $\varepsilon$ grows, so each term of (2.7) decreases or is zero.
# Hence $\psi_2(\mathbf{c}_2) \le \psi_2(\mathbf{c}_1) \le \psi_1(\mathbf{c}_1)$, and the largest
# $\varepsilon$ is selected. The residuals in $\psi$ are at points that the fit has used. They are
# not errors at $\mathbf{x}$, where nothing was measured.
#
# Leave-one-out evaluates the field at points whose measurement it has not used. A field that
# follows the noise predicts the omitted value badly, and so does a field that is too stiff. The
# mean of $e_i^2$ estimates the squared error plus the variance of the noise. The variance does not
# depend on $\varepsilon$, so the minimum is close to the best $\varepsilon$.
#
# *Beyond the question.* The minimum of $\psi$ even decreases strictly, unless it is zero from the
# start, as for affine data. In the limit it decreases like $\varepsilon^{-4}$, and the selected
# method is least squares. Values of $\psi$ for different $\varepsilon$ have different weights and
# cannot be compared. Without noise the best $\varepsilon$ is small: below about a tenth of the
# spacing of the points the error is constant, and above the spacing it grows up to that of least
# squares. With noise the best $\varepsilon$ is larger, since the field must average several points.
# If the true field is affine, $\varepsilon \to \infty$ is best.

# %% [markdown] rubric="02.10"
# One point for the terms with fixed $\mathbf{c}$. One for the minimum over $\mathbf{c}$. One for
# saying that $\psi$ measures residuals of data that the fit has used, not the error at
# $\mathbf{x}$. One for leave-one-out: it evaluates at data that the fit has not used. One for a
# variance of the noise that does not depend on $\varepsilon$. An answer that recommends $\psi$ gets
# none of the first three points.

# %% [markdown]
# ## Dig deeper
#
# - *Shortcut.* The field is linear in the values: $f(\mathbf{p}_i) = \sum_j a_{ij}\phi_j$. Show
#   that $e_i = (\phi_i - f(\mathbf{p}_i))/(1 - a_{ii})$, so that no system without the point is
#   needed. How do you get $a_{ii}$ from `field`? For which $\varepsilon$ does the quotient lose its
#   digits?
# - *The normalized objective.* Why is $\bar\psi$ smallest for small $\varepsilon$, if there is
#   noise? Think of $D + 1$ measurements that are much closer than all others.
# - *Terraces.* The slides say that "bumps and dimples occur unless $\varepsilon$ is substantially
#   larger than the spacing between points" (page 9). Look for them where the field is curved. Count
#   the changes of sign of the second differences of the curve, for a small $\varepsilon$ and for
#   $\varepsilon$ equal to the spacing. Then use the basis $b(\mathbf{x}) = 1$ alone, so that $f$ is
#   a weighted mean of the values (Shepard's method). What is its slope at the points?
# - *Rounding.* At a measured point, how large is the ratio of the largest squared weight to the
#   others for $\varepsilon = 10^{-4}$? Evaluate the field there for $\varepsilon = 10^{-2}, \dots,
#   10^{-9}$. The exact field tends to the measured value. What does your field do? Replace
#   $\mathbf{b}(\mathbf{p}_i)$ by $\mathbf{b}(\mathbf{p}_i - \mathbf{x})$, and (2.5) by
#   `numpy.linalg.lstsq` on (2.4), and try again.
# - *Far away.* What is the limit of the field as $\mathbf{x}$ goes to infinity?

# %%
progress()
