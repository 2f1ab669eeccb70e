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
# # Moving least squares
#
# One plane through all measurements cannot bend. Moving least squares fits a plane of its own at
# every place, and lets the measurements nearby count most. By the end of this notebook you have
# written the method, you know its gradient, which is not the one that first comes to mind, and you
# have found out how to choose its one parameter, and how not to.
#
# Each question asks for a function. Write it, run its cell, and run the check below it. The check
# tells you whether it is right and, if it is not, what kind of mistake it may be. You need nothing
# from other notebooks. There are seven functions of one to eight lines, and three questions in
# words.

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
# The dots are measurements of a wave. The grey line is the straight line that fits all of them
# best. Somebody asks for the value at the dotted line. Move the place, and watch the orange line,
# which was fitted to the eight nearest measurements only.


# %%
BESIDE = {"loc": "center left", "bbox_to_anchor": (1, 0.5)}
VALUES = {"ylabel": r"value $\phi$", "ylim": (-0.8, 1.7)}
UNIT = {"xlabel": "place $x$", "xlim": (-0.02, 1.02)}
TRUTH = {"color": GREY, "lw": 4, "alpha": 0.4}
SQUARE = {"xlabel": "$x_1$", "ylabel": "$x_2$", "aspect": "equal"}


def wave(t):
    return np.sin(6 * t) + t


def measured(number, noise=0.0):
    """Places of shape (number, 1) on the unit interval, and values there."""
    random = np.random.default_rng(7)
    t = random.random(number)
    return t[:, np.newaxis], wave(t) + noise * random.normal(size=number)


@draw(place=Slider(0, 1, 0.45, "place"))
def the_problem(place):
    points, values = measured(40, 0.05)
    t = points[:, 0]
    near = np.argsort(np.abs(t - place))[:8]
    side, short = np.array([0, 1]), place + np.array([-0.15, 0.15])
    everywhere = np.polyfit(t, values, 1)
    nearby = np.polyfit(t[near], values[near], 1)
    with figure(6.4, 2.8) as page:
        axes = page.subplots()
        axes.axvline(place, color="black", ls=":", lw=1)
        axes.plot(t, values, "o", ms=4, color=BLUE, label="measured")
        axes.plot(t[near], values[near], "o", color=ORANGE, label="eight nearest")
        axes.plot(side, np.polyval(everywhere, side), color=GREY, label="line for all")
        axes.plot(short, np.polyval(nearby, short), color=ORANGE)
        axes.set(**UNIT, **VALUES)
        axes.legend(**BESIDE)
    return page


# %% [markdown]
# **What to look at.** The orange line is good where it is asked for, and nowhere else. But it
# jumps: whenever another measurement becomes one of the eight nearest, the fit changes at once. A
# field made like this is torn in many places. It would be better if measurements came in and went
# out gradually.

# %% [markdown]
# ## The idea
#
# Let $\mathbf{p}_1, \dots, \mathbf{p}_N \in \mathbb{R}^D$ be the points where something was
# measured and $\phi_1, \dots, \phi_N$ the values. An *affine* field is
#
# $$ f(\mathbf{x}) = \mathbf{b}(\mathbf{x})^T \mathbf{c}, \qquad
#    \mathbf{b}(\mathbf{x}) = (1, x_1, \dots, x_D)^T, \qquad
#    \mathbf{c} = (c_0, c_1, \dots, c_D)^T. \tag{2.1} $$
#
# That it takes the values at the points are $N$ equations $\mathbf{B}\mathbf{c} = \mathbf{V}$, a
# row for each point:
#
# $$ \mathbf{B} = \begin{bmatrix} \mathbf{b}(\mathbf{p}_1)^T \\ \vdots \\ \mathbf{b}(\mathbf{p}_N)^T
#    \end{bmatrix}, \qquad
#    \mathbf{V} = \begin{bmatrix} \phi_1 \\ \vdots \\ \phi_N \end{bmatrix}. \tag{2.2} $$
#
# *Least squares* treats these equations alike. *Moving least squares* fixes a place $\mathbf{x}$
# and multiplies the $i$-th equation by a weight, which is the larger the closer $\mathbf{p}_i$ is
# to $\mathbf{x}$. We take
#
# $$ w_i(\mathbf{x}) = \frac{1}{r_i^2 + \varepsilon^2}, \qquad
#    r_i = \lVert \mathbf{x} - \mathbf{p}_i \rVert, \tag{2.3} $$
#
# where $\varepsilon > 0$ is a length that we choose. At $r = \varepsilon$ the weight is half of
# what it is at $r = 0$.

# %% [markdown]
# ### 02.1 The weights
#
# Write the weights of all points at one place.


# %% question="02.1"
def weights(points, x, epsilon):
    """Return w_1 … w_N of (2.3), of shape (N,).

    The points have the shape (N, D), the place x has (D,), and ε is a number.
    """
    # BEGIN SOLUTION
    return 1 / (np.sum((points - x) ** 2, axis=1) + epsilon**2)
    # END SOLUTION


# %%
check("02.1")

# %% [markdown]
# From here on the pictures are drawn with your functions. On the right are a hundred points of your
# own: they depend on what is written in `student.txt`. The area of a dot is its weight.


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
# ## The fit at one place
#
# With the diagonal matrix $\mathbf{W}(\mathbf{x}) = \operatorname{diag}(w_1, \dots, w_N)$ the
# weighted equations are
#
# $$ \mathbf{W}(\mathbf{x})\,\mathbf{B}\,\mathbf{c} = \mathbf{W}(\mathbf{x})\,\mathbf{V}. \tag{2.4}
#    $$
#
# There are more of them than unknowns. Multiplying both sides by $(\mathbf{W}\mathbf{B})^T$ gives
# the *normal equations*, which have as many equations as unknowns:
#
# $$ \underbrace{\mathbf{B}^T\,\mathbf{W}(\mathbf{x})^2\,\mathbf{B}}_{\mathbf{H}(\mathbf{x})}\;
#    \mathbf{c}(\mathbf{x}) = \mathbf{B}^T\,\mathbf{W}(\mathbf{x})^2\,\mathbf{V}. \tag{2.5} $$
#
# Mind the square: a point counts by $w_i^2$, the dashed curve above. Many books write $\mathbf{W}$
# where (2.5) has $\mathbf{W}^2$. Both are called moving least squares, and their numbers differ.

# %% [markdown]
# ### 02.2 The coefficients
#
# Write a function that solves (2.5) for weights that are given. It does not need to know where they
# come from.
#
# <details><summary>Hint</summary>
#
# Build $\mathbf{B}$ first: a column of ones, then the columns of the points. The $N \times N$
# matrix $\mathbf{W}$ need not be built. What does multiplying by a diagonal matrix do to each row?
# NumPy does the same by broadcasting.
#
# </details>


# %% question="02.2"
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
# With all weights equal this is plain least squares, the grey line. With yours of 02.1 it is the
# orange line, which belongs to one place. Move the place, then change $\varepsilon$.


# %%
@draw(
    place=Slider(0, 1, 0.45, "place"),
    epsilon=Slider(0.01, 2, 0.05, "ε", logarithmic=True),
)
def line_at_a_place(place, epsilon):
    points, v = measured(40, 0.05)
    here = weights(points, np.array([place]), epsilon)
    plain, local = (weighted_fit(points, v, w) for w in (np.ones(40), here))
    side, value = np.array([0, 1]), local[0] + local[1] * place
    with figure(6.4, 2.8) as page:
        axes = page.subplots()
        axes.axvline(place, color="black", ls=":", lw=1)
        axes.scatter(points[:, 0], v, s=8, color=BLUE)
        area = 120 * (here / here.max()) ** 2
        axes.scatter(points[:, 0], v, s=area, color=BLUE, alpha=0.5, lw=0)
        axes.plot(side, plain[0] + plain[1] * side, color=GREY, label="equal weights")
        axes.plot(side, local[0] + local[1] * side, color=ORANGE, label="yours, at $x$")
        axes.plot(place, value, "o", ms=8, color=ORANGE, label=r"$f(x)$")
        axes.set(**UNIT, **VALUES)
        axes.legend(**BESIDE)
    return page


# %% [markdown]
# **What to look at.** As the place moves the orange line turns smoothly; it no longer jumps. Nearly
# all of the fit comes from points within a few $\varepsilon$, or from the nearest few where
# $\varepsilon$ is small. For large $\varepsilon$ all weights are nearly equal and orange becomes
# grey.

# %% [markdown]
# ### In words
#
# **02.3** What are the dimensions of the matrix $\mathbf{H}(\mathbf{x})$ in (2.5), and what do they
# not depend on? Under which conditions on the points and the weights is it non-singular? Prove it.
# Then think of the computer: what happens to $\mathbf{H}(\mathbf{p}_1)$, at one of the points
# itself, if $\varepsilon$ is made very small?
#
# <details><summary>Hint</summary>
#
# When is $\mathbf{H}\mathbf{c} = \mathbf{0}$? Look at $\mathbf{c}^T\mathbf{H}\mathbf{c}$, and write
# it as the square of a length.
#
# </details>
#
# <details><summary>Hint for the second part</summary>
#
# How large is the largest weight at $\mathbf{p}_1$, and how large are the others? They enter
# squared, and a floating-point number has sixteen digits.
#
# </details>

# %% [markdown] answer="02.3" points=4
# $\mathbf{H}$ is $(D+1) \times (D+1)$: as large as the basis, however many points there are. It is
# symmetric, and $\mathbf{c}^T\mathbf{H}\mathbf{c} = \lVert \mathbf{W}\mathbf{B}\mathbf{c} \rVert^2
# \ge 0$. If $\mathbf{H}\mathbf{c} = \mathbf{0}$ this is zero, so $\mathbf{W}\mathbf{B}\mathbf{c} =
# \mathbf{0}$. All weights of (2.3) are positive, $\mathbf{W}$ can be inverted, and
# $\mathbf{B}\mathbf{c} = \mathbf{0}$ follows: the affine field with coefficients $\mathbf{c}$
# vanishes at every point. For $\mathbf{c} \neq \mathbf{0}$ the zeros of an affine field lie in one
# hyperplane, or there are none. So $\mathbf{H}$ is non-singular exactly if the points do not all
# lie in a hyperplane: on a line for $D = 2$, in a plane for $D = 3$. At least $D + 1$ points are
# needed. The place $\mathbf{x}$ has no part in it. With weights that vanish beyond some distance
# only the points that still count at $\mathbf{x}$ matter, and $\mathbf{H}$ may be regular at one
# place and singular at another.
#
# At $\mathbf{p}_1$ the largest squared weight is $\varepsilon^{-4}$, those of points at distance
# $R$ are about $R^{-4}$. Their ratio is $(R/\varepsilon)^4$, which for $\varepsilon = 10^{-4} R$ is
# $10^{16}$. Adding up $\mathbf{H}$ in floating-point numbers then loses all points but one, and one
# point does not determine a plane: what is singular is not $\mathbf{H}$ but what is left of it. The
# solver may return large wrong numbers without a word.

# %% [markdown] rubric="02.3"
# One point for the dimensions, independent of $N$. Two for the condition, that the points do not
# lie in a hyperplane: one for the statement, one for the proof, which must use that the weights are
# positive. One for the ratio of the weights and its effect on rounding; the power four, or a
# number, should be there.

# %% [markdown]
# ## The field
#
# The coefficients $\mathbf{c}(\mathbf{x})$ belong to the place $\mathbf{x}$, and there the field is
#
# $$ f(\mathbf{x}) = \mathbf{b}(\mathbf{x})^T \mathbf{c}(\mathbf{x}). \tag{2.6} $$
#
# To know it at another place, a new system must be solved. This is what moves in moving least
# squares.
#
# ### 02.4 At many places
#
# Write a function that evaluates (2.6) at $M$ places. A loop over the places is fine.


# %% question="02.4"
def field(points, values, x, epsilon):
    """Return f of (2.6) at M places x, of shape (M,).

    The places have the shape (M, D), the points (N, D) and the values (N,).
    """
    # BEGIN SOLUTION
    result = []
    for place in x:
        c = weighted_fit(points, values, weights(points, place, epsilon))
        result.append(c[0] + c[1:] @ place)
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
# - Without noise, make $\varepsilon$ small. Does the curve go *through* the points, or only close
#   to them? Make it large: to which curve does it tend?
# - Give it four points, then eighty. How does the error change where the points are dense?
# - Now add noise, and look for an $\varepsilon$ that you like. Remember it: we come back to this.
#
# The same in the plane, with your own points (the dots) and the field
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
# ## What is minimised
#
# Equations that cannot all hold have an error. For (2.4) it is $\mathbf{e} =
# \mathbf{W}(\mathbf{x})\mathbf{B}\mathbf{c} - \mathbf{W}(\mathbf{x})\mathbf{V}$, and half its
# squared length is
#
# $$ \psi(\mathbf{c}; \mathbf{x})
#    = \tfrac{1}{2} \lVert \mathbf{W}(\mathbf{x})(\mathbf{B}\mathbf{c} - \mathbf{V}) \rVert^2
#    = \tfrac{1}{2} \sum_{i=1}^N w_i(\mathbf{x})^2
#      \left( \mathbf{b}(\mathbf{p}_i)^T \mathbf{c} - \phi_i \right)^2. \tag{2.7} $$
#
# ### 02.5 The objective
#
# Write $\psi$ for any coefficients, not only the best ones.


# %% question="02.5"
def objective(points, values, x, epsilon, coefficients):
    """Return ψ(c; x) of (2.7), a number.

    The place x has the shape (D,), the coefficients c have (D + 1,).
    """
    # BEGIN SOLUTION
    residual = coefficients[0] + points @ coefficients[1:] - values
    return 0.5 * np.sum((weights(points, x, epsilon) * residual) ** 2)
    # END SOLUTION


# %%
check("02.5")

# %% [markdown]
# On a line there are two coefficients, so $\psi$ is a landscape over a plane. Below, the left
# picture shows its level lines. A straight line is told there by its value at $x$, which is $c_0 +
# c_1 x$, and its slope $c_1$. The dot is what your `weighted_fit` returns, and the thin curve is
# the way that the dot takes as the place goes from 0 to 1. Move the place.


# %%
@draw(
    place=Slider(0, 1, 0.45, "place"),
    epsilon=Slider(0.01, 2, 0.05, "ε", logarithmic=True),
)
def valley(place, epsilon):
    points, v = measured(40, 0.05)
    x = np.array([place])

    def best(at):
        return weighted_fit(points, v, weights(points, np.array([at]), epsilon))

    lowest = best(place)
    places = np.linspace(0, 1, 101)
    lines = np.array([best(at) for at in places])

    def height(value, slope):
        line = np.array([value - slope * place, slope])
        return objective(points, v, x, epsilon, line)

    value, slope = np.linspace(-1, 2, 121), np.linspace(-12, 12, 61)
    heights = [[height(a, b) for a in value] for b in slope]
    side = np.linspace(0, 1, 2)
    with figure(6.4, 3.0) as page:
        left, right = page.subplots(1, 2)
        levels = np.min(heights) * 2.0 ** np.arange(1, 16)
        left.contour(value, slope, heights, levels, norm="log", linewidths=0.9)
        left.plot(lines[:, 0] + places * lines[:, 1], lines[:, 1], color=GREY, lw=1)
        left.plot(lowest[0] + place * lowest[1], lowest[1], "o", ms=8, color=ORANGE)
        left.set(xlabel="value at $x$", ylabel="slope $c_1$")
        left.set_title(r"$\psi(\mathbf{c}; x)$, level lines")
        right.axvline(place, color="black", ls=":", lw=1)
        right.plot(points[:, 0], v, ".", color=BLUE)
        right.plot(side, lowest[0] + lowest[1] * side, color=ORANGE)
        right.set(**UNIT, **VALUES, title="its lowest point")
    return page


# %% [markdown]
# **What to look at.** There is one valley and one lowest point, wherever the place is. The valley
# is long in one direction: lines with the same value at $x$ and another slope are nearly as good,
# since only what happens close to $x$ counts. What does the valley look like for a large
# $\varepsilon$?
#
# ### In words
#
# **02.6** What has (2.5) to do with optimisation? Derive it from (2.7). Show that its solution is
# where $\psi$ is smallest, and not just stationary. Is there *one* such problem, as in least
# squares?
#
# <details><summary>Hint</summary>
#
# Compute the gradient of $\psi$ with respect to $\mathbf{c}$, with $\mathbf{x}$ held fixed, and
# then the matrix of second derivatives. You have met that matrix.
#
# </details>

# %% [markdown] answer="02.6" points=3
# With $\mathbf{x}$ fixed, $\psi$ is a quadratic function of $\mathbf{c}$. Its gradient is
# $\nabla_{\mathbf{c}}\psi = (\mathbf{W}\mathbf{B})^T(\mathbf{W}\mathbf{B}\mathbf{c} -
# \mathbf{W}\mathbf{V}) = \mathbf{B}^T\mathbf{W}^2(\mathbf{B}\mathbf{c} - \mathbf{V})$, because
# $\mathbf{W}$ is diagonal. Where it vanishes, (2.5) holds. The second derivatives are the matrix
# $\mathbf{H} = \mathbf{B}^T\mathbf{W}^2\mathbf{B}$, which is positive semi-definite, so $\psi$ is
# convex, and a point where the gradient vanishes is a global minimum. It is the only one if
# $\mathbf{H}$ is non-singular, for then $\psi(\mathbf{c}^* + \mathbf{d}) = \psi(\mathbf{c}^*) +
# \tfrac12 \mathbf{d}^T\mathbf{H}\mathbf{d} > \psi(\mathbf{c}^*)$ for every $\mathbf{d} \neq
# \mathbf{0}$.
#
# There is not one problem but one for each place $\mathbf{x}$, without constraints and with $D+1$
# unknowns. The field is made of the minimisers of all of them, $f(\mathbf{x}) =
# \mathbf{b}(\mathbf{x})^T \operatorname{arg\,min}_{\mathbf{c}} \psi(\mathbf{c}; \mathbf{x})$; no
# single $\mathbf{c}$ belongs to it.

# %% [markdown] rubric="02.6"
# One point for the gradient, with the square of $\mathbf{W}$ explained. One for convexity, or the
# completed square. One for seeing that each place has a problem of its own.

# %% [markdown]
# ## The gradient
#
# Often it is not $f$ that is wanted but its slope: a force is the gradient of a pressure. By the
# product rule, (2.6) has
#
# $$ \frac{\partial f}{\partial x_k} = c_k(\mathbf{x}) +
#    \mathbf{b}(\mathbf{x})^T \frac{\partial \mathbf{c}}{\partial x_k}(\mathbf{x}). \tag{2.8} $$
#
# The first term is the slope of the plane that was fitted. It is tempting to stop there. But the
# plane turns while $\mathbf{x}$ moves, and the second term says how that changes the value.
#
# Take pen and paper. Differentiate both sides of (2.5) by $x_k$. Neither $\mathbf{B}$ nor
# $\mathbf{V}$ depends on $\mathbf{x}$; of $\mathbf{W}^2$ each entry $w_i^2$ does, by (2.3). Bring
# everything but $\mathbf{H}\,\partial\mathbf{c}/\partial x_k$ to the right.
#
# ### 02.7 The gradient at many places
#
# Write the gradient of $f$. It is the true derivative of the function that you wrote in 02.4, not a
# difference quotient and not the first term alone.
#
# <details><summary>Hint: the derivative of the system</summary>
#
# On the left the product rule gives two terms. One of them goes to the right side and meets the
# derivative of the right side there. What stands between $\mathbf{B}^T$ and the end is then the
# derivative of $\mathbf{W}^2$, times the residual
# $\mathbf{r} = \mathbf{V} - \mathbf{B}\mathbf{c}(\mathbf{x})$.
#
# </details>
#
# <details><summary>Hint: the derivative of a squared weight</summary>
#
# Write $w_i^2 = s^{-2}$ with $s = r_i^2 + \varepsilon^2$ and use the chain rule. By how much does
# $r_i^2$ change with $x_k$? Write the result as $w_i^2$ times something.
#
# </details>
#
# <details><summary>Hint: no new system is needed</summary>
#
# If you have written the right side as $\mathbf{B}^T\mathbf{W}^2\mathbf{g}$, the derivative of
# $\mathbf{c}$ solves (2.5) with other data, $\mathbf{g}$ in the place of $\mathbf{V}$. You have a
# function for that.
#
# </details>


# %% question="02.7"
def gradient(points, values, x, epsilon):
    """Return the gradient of f at places x, all of (2.8), of shape (M, D).

    The places have the shape (M, D), the points (N, D) and the values (N,).
    """
    # BEGIN SOLUTION
    result = np.empty(x.shape)
    for j, place in enumerate(x):
        w = weights(points, place, epsilon)
        c = weighted_fit(points, values, w)
        residual = values - c[0] - points @ c[1:]
        for k in range(len(place)):
            g = -4 * w * (place[k] - points[:, k]) * residual
            dc = weighted_fit(points, g, w)
            result[j, k] = c[1 + k] + dc[0] + dc[1:] @ place
    return result
    # END SOLUTION


# %%
check("02.7")

# %% [markdown]
# The dots below are differences of neighbouring values of your field. The dashed line is the first
# term of (2.8) alone, which is known as the *diffuse derivative*.


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
# two is closer to the slope of the truth? For a very small $\varepsilon$ it is the dashed one,
# which does not follow the small waves of $f$; from about the spacing of the points on it is your
# gradient. So the dashed line may be a fair estimate of $\phi'$, but it is *not* the derivative of
# $f$. Who needs the two to agree, because a force must do the work that the potential says, needs
# the full gradient.

# %% [markdown]
# ## How good is it?
#
# Now a fair comparison. The field is $\phi(\mathbf{x}) = (x_1 + x_2)^n$, measured at random points
# of the unit square. Both methods see the same values, and both are asked at the same places
# $\mathbf{x}_1, \dots, \mathbf{x}_M$, which are no measured points. The error is the root of the
# mean square of what they miss by:
#
# $$ E = \sqrt{ \frac{1}{M} \sum_{j=1}^M
#    \bigl( f(\mathbf{x}_j) - \phi(\mathbf{x}_j) \bigr)^2 }. \tag{2.9} $$
#
# ### 02.8 Least squares against moving least squares
#
# Write a function that returns $E$ for plain least squares and for moving least squares, in this
# order.
#
# <details><summary>Hint</summary>
#
# You have written least squares as well: which weights make `weighted_fit` treat all points alike?
#
# </details>


# %% question="02.8"
def errors(points, places, n, epsilon):
    """Return E of (2.9) for least and for moving least squares, of shape (2,).

    The field (x_1 + x_2)ⁿ is measured at points (N, 2). Both methods are asked at
    places (M, 2).
    """
    # BEGIN SOLUTION
    values, truth = np.sum(points, axis=1) ** n, np.sum(places, axis=1) ** n
    c = weighted_fit(points, values, np.ones(len(points)))
    plain = c[0] + places @ c[1:] - truth
    moving = field(points, values, places, epsilon) - truth
    return np.sqrt([np.mean(plain**2), np.mean(moving**2)])
    # END SOLUTION


# %%
check("02.8")

# %% [markdown]
# Here are your own hundred points and ten places. Nobody else has them.


# %%
@draw(epsilon=Slider(0.01, 3, 0.05, "ε", logarithmic=True))
def comparison(epsilon):
    points, places = data("02.8")[:2]
    powers = range(2, 9)
    both = np.array([errors(points, places, n, epsilon) for n in powers])
    first = max(errors(points, places, 1, epsilon))
    with figure(6.4, 3.0) as page:
        left, right = page.subplots(1, 2, width_ratios=(1, 1.5))
        left.plot(*points.T, ".", ms=4, color=BLUE, label="measured")
        left.plot(*places.T, "x", color=ORANGE, label="asked for")
        left.set(**SQUARE)
        left.legend(loc="lower center", bbox_to_anchor=(0.5, 1), ncols=2)
        names = ("least squares", "moving least squares")
        for name, line, color, told in zip(names, ("s--", "o-"), (GREY, ORANGE), both.T):
            right.semilogy(powers, told, line, color=color, label=name)
        exact = "both exact, to rounding" if first < 1e-10 else f"error {first:.1g}"
        right.set(xlabel="power $n$", ylabel="error $E$", title=f"$n = 1$: {exact}")
        right.set_ylim(top=12 * both.max())
        right.legend(loc="upper left")
    return page


# %% [markdown]
# **What to look at.** Why is $n = 1$ exact for both? For $n = 2, 3, \dots$ both errors grow, since
# the field rises ever more steeply towards the corner $(1, 1)$. How many times better is moving
# least squares? Ten places are few: run `errors` with a thousand before you trust a factor. And
# what happens to the comparison when you push $\varepsilon$ to its largest value?

# %% [markdown]
# ## Which ε is best?
#
# Since we know $\phi$, we can look. The field is $(x_1 + x_2)^n$ at your hundred points, with noise
# added if you like, and the error (2.9) is taken at three hundred places.


# %%
WIDTHS = np.geomspace(0.01, 3, 16)


def noisy(n, noise):
    """Your points, (x_1 + x_2)ⁿ there with noise, and three hundred places."""
    points, random = data("02.8")[0], np.random.default_rng(3)
    v = points.sum(axis=1) ** n + noise * random.normal(size=len(points))
    return points, v, random.random((300, 2))


def true_errors(n, noise):
    points, v, many = noisy(n, noise)
    truth = many.sum(axis=1) ** n
    missed = [field(points, v, many, width) - truth for width in WIDTHS]
    return np.sqrt(np.mean(np.square(missed), axis=1))


@draw(n=Slider(1, 6, 3, "power n", whole=True), noise=Slider(0, 1, 0.3, "noise"))
def error_against_width(n, noise):
    with figure(6.4, 2.8) as page:
        axes = page.subplots()
        for sigma, color in ((0.0, BLUE), (noise, ORANGE)):
            missed = true_errors(n, sigma)
            axes.semilogx(WIDTHS, missed, color=color, label=f"noise {sigma:.2g}")
            axes.plot(WIDTHS[missed.argmin()], missed.min(), "o", color=color)
        axes.axvline(0.1, color="black", ls=":", lw=1)
        top = max(axes.get_ylim()[1], 1e-3)
        axes.text(0.105, top, "spacing of\nthe points", va="top")
        axes.set(xlabel=r"$\varepsilon$", ylabel="error $E$", ylim=(0, top))
        axes.legend(**BESIDE)
    return page


# %% [markdown]
# **What to look at.** Without noise the curve is flat on the left: every small $\varepsilon$ is as
# good as the next, and there is nothing to gain from a large one. With noise there is a best
# $\varepsilon$, and it grows with the noise. Set $n = 1$: now it pays to make $\varepsilon$ as
# large as possible. Why?
#
# ### A tempting idea
#
# In practice $\phi$ is not known, and this curve cannot be drawn. What can be computed from the
# measurements alone? There is $\psi$ of (2.7). It measures an error, and the coefficients were
# found by minimising it. So why not choose the $\varepsilon$ that makes $\psi$ smallest as well?
# Try it, with your own points, at three of your places.


# %%
@draw(noise=Slider(0, 1, 0.3, "noise"))
def tempting(noise):
    points, v, _ = noisy(3, noise)
    with figure(6.4, 2.8) as page:
        axes = page.subplots()
        places = data("02.8")[1][:3]
        for place, color in zip(places, (BLUE, ORANGE, GREEN), strict=True):
            lowest, label = [], f"({place[0]:.2f}, {place[1]:.2f})"
            for width in WIDTHS:
                c = weighted_fit(points, v, weights(points, place, width))
                lowest.append(objective(points, v, place, width, c))
            axes.loglog(WIDTHS, lowest, color=color, label=label)
        axes.set(xlabel=r"$\varepsilon$", ylabel=r"least value of $\psi$")
        axes.legend(title=r"at $\mathbf{x} =$")
    return page


# %% [markdown]
# **What to look at.** Where is the minimum? Does its place depend on the noise, on the values, on
# anything that was measured? Keep your answer for question 02.10.
#
# ## Leaving one out
#
# An honest test asks the method for something that it has not seen. Leave out the measurement
# $(\mathbf{p}_i, \phi_i)$, make the field $f_{-i}$ of the other $N - 1$, and see by how much it
# misses:
#
# $$ e_i = \phi_i - f_{-i}(\mathbf{p}_i), \qquad i = 1, \dots, N. \tag{2.10} $$
#
# Nothing but the measurements is needed for this.
#
# ### 02.9 The leave-one-out errors
#
# Write a function that returns all $e_i$.
#
# <details><summary>Hint</summary>
#
# Use your `field`. An array of booleans picks all rows but one; there is also a function of NumPy
# that deletes a row. The place is $\mathbf{p}_i$, as an array of shape $(1, D)$.
#
# </details>


# %% question="02.9"
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
# Now all judges side by side, on your points. Each curve is what one of them thinks of each
# $\varepsilon$; a dot marks its choice. Besides the leave-one-out error and $\psi$ there is a third
# judge, the *normalised* $\bar\psi = \psi / \sum_i w_i^2$, a weighted mean of squared residuals.
# The number in brackets says how many times larger the true error is at that choice than at the
# best $\varepsilon$.


# %%
@draw(n=Slider(1, 6, 3, "power n", whole=True), noise=Slider(0, 1, 0.3, "noise"))
def judges(n, noise):
    points, v, _ = noisy(n, noise)
    truth = true_errors(n, noise)
    unseen, sums, means = [], [], []
    for width in WIDTHS:
        unseen.append(np.sqrt(np.mean(leave_one_out(points, v, width) ** 2)))
        lowest, total = [], []
        for place in data("02.8")[1]:
            there = weights(points, place, width)
            best = weighted_fit(points, v, there)
            lowest.append(objective(points, v, place, width, best))
            total.append(np.sum(there**2))
        sums.append(np.sum(lowest))
        means.append(np.sum(np.divide(lowest, total)))
    verdicts = (
        ("true error", truth, GREY, "-"),
        ("leave one out", unseen, GREEN, "--"),
        (r"$\psi$", sums, ORANGE, "-."),
        (r"$\bar\psi$", means, PURPLE, ":"),
    )
    with figure(6.8, 3.2) as page:
        axes = page.subplots()
        for name, told, color, line in verdicts:
            told = np.maximum(told, 1e-9) / max(np.min(told), 1e-9)
            choice = told.argmin()
            regret = max(truth[choice], 1e-9) / max(truth.min(), 1e-9)
            label, size = f"{name} (×{regret:.2f})", 9 if color == GREY else 7
            axes.loglog(WIDTHS, told, line, color=color, label=label)
            axes.plot(WIDTHS[choice], 1, "o", color=color, ms=size)
        axes.set(xlabel=r"$\varepsilon$", ylabel="over its least", ylim=(0.8, 40))
        axes.legend(**BESIDE, title="judge (regret)")
    return page


# %% [markdown]
# **What to look at.** Set the noise to zero, then to 0.3, then to 1. Which judges change their
# mind, and which never do? Then set $n = 1$ with noise: now $\psi$ is right. Does that make it a
# good judge?
#
# ### In words
#
# **02.10** For which $\varepsilon$ does moving least squares work best, without noise and with it?
# A hint that is sometimes given reads: *use $\psi$ to measure the overall error*. Explain what
# $\psi$ measures, and why it cannot choose $\varepsilon$, whatever was measured. Why does
# normalising it not help when there is noise? What does leaving one out do differently?
#
# <details><summary>Hint</summary>
#
# Keep $\mathbf{c}$ fixed and increase $\varepsilon$. What happens to each term of the sum in (2.7)?
# What can minimising over $\mathbf{c}$ afterwards do to it?
#
# </details>
#
# <details><summary>Hint for the normalised one</summary>
#
# Think of $D + 1$ measurements that are much closer than all others. How well can a plane fit
# these? Does that tell you anything about the value at $\mathbf{x}$?
#
# </details>

# %% [markdown] answer="02.10" points=5
# *The best $\varepsilon$.* Without noise, a small one: from about a tenth of the spacing of the
# points downwards nothing changes any more, and from the spacing on the error grows, up to that of
# least squares. The exception is an affine field, which is exact for every $\varepsilon$. With
# noise the best $\varepsilon$ is larger, and grows with the noise: the field has to average over
# several points. If the true field is affine, the best is $\varepsilon \to \infty$, least squares,
# which averages over all of them. The gradient asks for a larger $\varepsilon$ than the value.
#
# *What $\psi$ measures.* It says how far the local plane is from the measurements around
# $\mathbf{x}$, by weights whose size depends on $\varepsilon$. It is no error at $\mathbf{x}$,
# where nothing was measured. For fixed $\mathbf{c}$ every weight $w_i = 1/(r_i^2 + \varepsilon^2)$
# falls as $\varepsilon$ grows, so each term of (2.7) falls; minimising over $\mathbf{c}$ makes the
# sum only smaller. In formulas: with $\varepsilon_1 < \varepsilon_2$ and minimisers $\mathbf{c}_1,
# \mathbf{c}_2$, $\psi_2(\mathbf{c}_2) \le \psi_2(\mathbf{c}_1) \le \psi_1(\mathbf{c}_1)$. So the
# least value of $\psi$ falls for *all* data (unless it is zero from the start, for an affine
# field), in the end as $\varepsilon^{-4}$: it always chooses $\varepsilon = \infty$, which is least
# squares, on noise-free data the worst choice of all. That $\mathbf{c}$ minimises $\psi$ is no
# reason: $\psi$ with another $\varepsilon$ is another function, measured in other units.
#
# *Normalised*, the effect of the units is gone. But the smaller $\varepsilon$ is, the fewer points
# count, and a plane with $D+1$ coefficients can follow few points closely, noise and all. So
# $\bar\psi$ is least at the smallest $\varepsilon$: harmless without noise, wrong with it. It
# judges a fit by the data that it was fitted to.
#
# *Leaving one out* judges the field at places where there is a measurement that it has not seen. A
# field that follows the noise misses the one left out, and so does a field that is too stiff. The
# mean of $e_i^2$ estimates the squared error plus the variance of the noise, which does not depend
# on $\varepsilon$, so that its minimum is close to the best $\varepsilon$.

# %% [markdown] rubric="02.10"
# One point for the best $\varepsilon$ without noise and with it, in relation to the spacing. Two
# for $\psi$: that it falls for all data (an argument, not only the picture), and that it is a
# residual and no error at $\mathbf{x}$. One for the normalised one: few points are followed
# closely. One for leaving one out: data that the fit has not seen. A student who follows the hint
# of the question and chooses by $\psi$ gets none of the two points for $\psi$.

# %% [markdown]
# ## Dig deeper
#
# - *Shortcut.* The field is linear in the values: $f(\mathbf{p}_i) = \sum_j a_{ij}\phi_j$. Show
#   that $e_i = (\phi_i - f(\mathbf{p}_i))/(1 - a_{ii})$, so that nothing has to be left out. How do
#   you get $a_{ii}$ from `field`? For which $\varepsilon$ does the quotient lose its digits, and
#   why?
# - *Terraces.* The slides say that "bumps and dimples occur unless $\varepsilon$ is substantially
#   larger than the spacing between points". Look for them where the field is curved: with a small
#   $\varepsilon$ count the changes of sign of the second differences of the curve, and with
#   $\varepsilon$ of one spacing. Replace the basis by $b(\mathbf{x}) = 1$ alone, so that $f$ is a
#   weighted mean of the values, and draw the curve again. What is its slope at the points?
# - *Rounding.* Evaluate the field at a measured point for $\varepsilon = 10^{-2}, 10^{-3}, \dots,
#   10^{-9}$. The exact field tends to the value there. What does yours do? Replace
#   $\mathbf{b}(\mathbf{p}_i)$ by $\mathbf{b}(\mathbf{p}_i - \mathbf{x})$, and (2.5) by
#   `numpy.linalg.lstsq` on (2.4), and try again.
# - *Far away.* To what does the field tend as $\mathbf{x}$ goes to infinity?

# %%
progress()
