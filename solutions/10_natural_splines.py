# ---
# jupyter:
#   course:
#     builds_on:
#       "03": the saddle-point system of a kernel and a linear polynomial
#     pages: book, section 1.4
#     chapters: [19-natural-splines]
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
# # Natural splines
#
# A *spline* was a thin elastic rod with which draughtsmen drew the lines of ships. Held by pins,
# the rod takes the shape with the least bending energy. This shape is, for small slopes, the
# *natural cubic spline* through the pins.
#
# This notebook computes the natural spline in two ways that look unrelated: as a sum of one
# function $\lvert x - x_j \rvert^3$ for each pin, and by cubic polynomials between the pins. You
# convert one form into the other, compute the bending energy, and see how a sum of functions that
# are nonzero almost everywhere can be local. The first form generalizes to the plane and to
# space, where it is interpolation by radial basis functions (notebooks 03 and 09).
#
# **Sources**: H. Wendland, *Scattered Data Approximation* (2005), section 1.4, pages 12–16; C. de
# Boor, *A Practical Guide to Splines* (1978). **To search for**: natural cubic spline, truncated
# power, moments of a spline, tridiagonal system, bending energy, minimal norm property, B-spline,
# Cox–de Boor recursion, Marsden's identity.
#
# Each question asks for a short function with a check below it, or for an answer in words. After a
# check that is not right, `case()` in a new cell shows the inputs for which your function failed,
# and your values. If everybody has the same inputs, it also shows the right values. Arrays may hold
# integers, so small that no product of them overflows. Compute with float64, NumPy's default type.
# Returned lists count as arrays, an array with one entry as a number, and a complex number without
# imaginary part as a real one. A function must not change its arguments.

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
)
from fieldcheck.given import saddle_point_matrix

# %% [markdown]
# ## The problem in a picture
#
# There are eight pins. The polynomial through all of them oscillates between them (*Runge
# phenomenon*), and the broken line has a kink at each. At the end of question 10.4 your spline will
# join this picture. Move one pin: how far does the polynomial react?


# %%
@draw(height=Slider(-1, 2, -0.5, "height of the fourth pin"))
def the_problem(height):
    pins = np.array([0.0, 0.9, 1.7, 3.0, 3.8, 5.1, 6.0, 7.0])
    heights = np.array([0.2, 0.9, 0.5, height, 1.0, 0.1, 0.3, 0.9])
    side = np.linspace(0, 7, 400)
    with figure(6.4, 2.8) as page:
        axes = page.subplots()
        polynomial = np.polynomial.Polynomial.fit(pins, heights, 7)
        axes.plot(side, polynomial(side), color=ORANGE, label="polynomial")
        axes.plot(pins, heights, color=GREY, label="broken line")
        axes.plot(pins, heights, "o", color="black", label="pins")
        axes.set(xlabel="$x$", ylabel="height", ylim=(-2, 3))
        axes.legend(loc="lower center", ncols=3)
    return page


# %% [markdown]
# ## Natural cubic splines
#
# Let $x_1 < x_2 < \dots < x_N$ be the *sites* and $f_1, \dots, f_N$ the values. A *cubic spline*
# has two continuous derivatives and is a cubic polynomial between neighbouring sites, before the
# first site and after the last one. It is *natural* if it is a straight line before the first site
# and after the last one.
#
# Let $y_+ = \max(y, 0)$. The *truncated power* $(x - x_j)_+^3$ is zero up to $x_j$ and a cubic
# polynomial from there on, and it has two continuous derivatives. We begin on the left with a
# straight line and add a multiple of a truncated power at each site:
#
# $$ s(x) = \sum_{j=1}^N \alpha_j\, (x - x_j)_+^3 + \beta_0 + \beta_1 x . \tag{10.1} $$
#
# After the last site the truncated powers are cubic polynomials. There the sum must be a straight
# line again, so the coefficients of $x^3$ and of $x^2$ must vanish:
#
# $$ \sum_{j=1}^N \alpha_j = 0, \qquad \sum_{j=1}^N \alpha_j\, x_j = 0 . \tag{10.2} $$
#
# Truncated powers distinguish left and right. Functions of the *distance* $\lvert x - x_j \rvert$
# do not, and they make sense in the plane, too. The two are related by
#
# $$ y_+^3 = \tfrac12 \bigl( \lvert y \rvert^3 + y^3 \bigr) . \tag{10.3} $$
#
# With (10.3) the curve (10.1) becomes
#
# $$ s(x) = \sum_{j=1}^N a_j\, \lvert x - x_j \rvert^3 + b_0 + b_1 x, \qquad
#    \sum_{j=1}^N a_j = \sum_{j=1}^N a_j\, x_j = 0 , \tag{10.4} $$
#
# where the new coefficients $a_j$ satisfy the same conditions.
#
# ## A worked example
#
# The sites are $0, 1, 2$, with the values $0, 1, 0$. By (10.2), $\alpha = t\,(1, -2, 1)$ for some
# $t$. Before the first site the curve is the line $\beta_0 + \beta_1 x$, so $s(0) = 0$ gives
# $\beta_0 = 0$. The other two values give $t + \beta_1 = 1$ and $8t - 2t + 2\beta_1 = 0$. Hence
# $t = -\tfrac12$ and $\beta_1 = \tfrac32$:
#
# $$ s(x) = -\tfrac12 x_+^3 + (x-1)_+^3 - \tfrac12 (x-2)_+^3 + \tfrac32 x . $$
#
# In (10.4) the same curve has $a = (-\tfrac14, \tfrac12, -\tfrac14)$, $b_0 = \tfrac32$ and
# $b_1 = 0$. The next cell evaluates both forms. At $x = \tfrac12$ the value is $\tfrac{11}{16}$.


# %%
def truncated_sum(sites, alpha, beta, x):
    """Return s of (10.1) at points x (K,), of shape (K,), for α (N,) and β (2,)."""
    powers = np.maximum(np.subtract.outer(x, sites), 0) ** 3
    return powers @ alpha + beta[0] + beta[1] * x


x = np.array([-1, 0.5, 1, 2, 3])
knots = np.array([0, 1, 2])
print(truncated_sum(knots, np.array([-0.5, 1, -0.5]), np.array([0, 1.5]), x))
cubes = sum(a * abs(x - knot) ** 3 for a, knot in zip((-0.25, 0.5, -0.25), knots, strict=True))
print(cubes + 1.5)

# %% [markdown]
# The function `truncated_sum` is a finished one, to imitate: a docstring with the formula and the
# shapes, and one matrix of shape $(K, N)$ instead of a loop over the points.
#
# ### 10.1 From truncated powers to distances
#
# Derive $a_j$, $b_0$ and $b_1$ from $\alpha_j$, $\beta_0$ and $\beta_1$ on paper. Then write the
# function. No two sites are equal.
#
# <details><summary>Hint</summary>
#
# By (10.3) a remainder is left, half of $\sum_j \alpha_j (x - x_j)^3$. Expand the cube. Which of
# the four powers of $x$ vanish by (10.2), and to which coefficients do the others contribute?
#
# </details>


# %% question="10.1" minutes=25
def from_truncated(sites, alpha, beta):
    """Return a and b of (10.4), of shapes (N,) and (2,), for sites (N,) in any order, N >= 2.

    alpha (N,) and beta (2,) are the coefficients in (10.1), and satisfy (10.2).
    """
    # BEGIN SOLUTION
    a = alpha / 2
    constant = beta[0] - a @ sites**3
    slope = beta[1] + 3 * a @ sites**2
    return a, np.array([constant, slope])
    # END SOLUTION


# %%
check("10.1")


# %%
@draw(middle=Slider(0.6, 2.4, 1.2, "second site"))
def two_sums(middle):
    knots = np.array([0.0, middle, 3.0])
    alpha = 0.35 * np.array([3 - middle, -3, middle])
    a, b = from_truncated(knots, alpha, np.array([0.4, -0.6]))
    side = np.linspace(-1, 4, 300)
    z = np.subtract.outer(side, knots)
    with figure(6.4, 2.9) as page:
        left, right = page.subplots(1, 2, sharey=True)
        for axes, terms, line, title in (
            (left, alpha * z.clip(0) ** 3, 0.4 - 0.6 * side, "truncated powers"),
            (right, a * np.abs(z) ** 3, b[0] + b[1] * side, "distances"),
        ):
            axes.plot(side, terms, color=GREY, lw=1)
            axes.plot(side, line, color=GREEN, lw=1.2, ls="--", label="straight line")
            axes.plot(side, terms.sum(axis=1) + line, color=BLUE, lw=2.2, label="sum")
            for knot in knots:
                axes.axvline(knot, color=GREY, lw=0.6, ls=":")
            axes.set(title=title, xlabel="$x$", ylim=(-12, 12))
        left.legend(loc="lower left")
    return page


# %% [markdown]
# **What to look at.** The grey terms and the dashed lines of the two panels differ, the sums do
# not. On the left all terms vanish before the first site. On the right each term vanishes at its
# own site only, and is symmetric about it. By (10.2) the sum is straight on both sides.

# %% [markdown]
# ## The saddle-point system
#
# The form (10.4) has $N + 2$ unknowns, and there are $N + 2$ equations: $s(x_i) = f_i$ and the two
# side conditions. With $A_{ij} = \lvert x_i - x_j \rvert^3$ and $\mathbf{P}$ with the rows
# $(1, x_i)$,
#
# $$ \begin{bmatrix} \mathbf{A} & \mathbf{P} \\ \mathbf{P}^T & \mathbf{0} \end{bmatrix}
#    \begin{bmatrix} \mathbf{a} \\ \mathbf{b} \end{bmatrix} =
#    \begin{bmatrix} \mathbf{f} \\ \mathbf{0} \end{bmatrix} . \tag{10.5} $$
#
# So the natural spline is an interpolant by radial basis functions: the kernel $r^3$ with a
# polynomial of degree one. On a line it is $r^3$ that minimizes the bending energy. In the plane it
# is the thin-plate spline $r^2 \log r$.
#
# ### 10.2 The spline by distances
#
# The matrix of (10.5) has the form that notebook 03 explains. `saddle_point_matrix(A, P)` is
# ready-made and combines the blocks. Write a function that states $\mathbf{A}$ and $\mathbf{P}$,
# solves (10.5), and separates $\mathbf{a}$ from $\mathbf{b}$. The sites may come in any order,
# since no equation of the system depends on it.


# %% question="10.2" minutes=20
def radial_spline(sites, values):
    """Return a (N,) and b (2,) of (10.4), for values (N,) at sites (N,), N >= 2."""
    # BEGIN SOLUTION
    n = len(sites)
    p = np.stack([np.ones(n), sites], axis=1)
    kernel = np.abs(sites[:, np.newaxis] - sites) ** 3
    unknown = np.linalg.solve(saddle_point_matrix(kernel, p), np.append(values, [0, 0]))
    return unknown[:n], unknown[n:]
    # END SOLUTION


# %%
check("10.2")


# %%
@draw(height=Slider(-2, 2, 0.8, "height of the fourth pin"))
def your_spline(height):
    pins, heights = data("10.2")
    order = np.argsort(pins)
    pins, heights = pins[order], heights[order].copy()
    heights[3] = height
    a, b = radial_spline(pins, heights)
    side = np.linspace(pins[0] - 1, pins[-1] + 1, 400)
    with figure(6.4, 2.9) as page:
        axes = page.subplots()
        axes.axvspan(pins[0], pins[-1], color=GREY, alpha=0.12, lw=0)
        curve = np.abs(np.subtract.outer(side, pins)) ** 3 @ a + b[0] + b[1] * side
        axes.plot(side, curve, color=BLUE)
        axes.plot(pins, heights, "o", color="black")
        axes.plot(pins[3], heights[3], "o", color=ORANGE, ms=9)
        axes.set(xlabel="$x$", ylabel="$s$", ylim=(-4, 4))
    return page


# %% [markdown]
# **What to look at.** The curve passes through pins of your own and is straight outside the grey
# part. Move a pin: the curve follows near it and hardly changes a few pins further.

# %% [markdown]
# ## Cubic pieces
#
# The second approach starts from the pieces. On each interval the spline is a cubic polynomial, so
# its second derivative is linear, and $s''$ is a broken line. Its values at the sites are called
# the *moments* $M_i = s''(x_i)$, as in the theory of beams. With $h_i = x_{i+1} - x_i$ and
# $u = (x - x_i) / h_i$, the cubic polynomial on $[x_i, x_{i+1}]$ with the values $f_i$, $f_{i+1}$
# and the second derivatives $M_i$, $M_{i+1}$ at the ends is
#
# $$ s(x) = (1-u)\, f_i + u\, f_{i+1} +
#    \frac{h_i^2}{6} \Bigl( \bigl[(1-u)^3 - (1-u)\bigr] M_i + \bigl[u^3 - u\bigr] M_{i+1} \Bigr) .
#    \tag{10.6} $$
#
# The slopes of neighbouring pieces agree at $x_i$ if
#
# $$ \frac{h_{i-1}}{6} M_{i-1} + \frac{h_{i-1} + h_i}{3} M_i + \frac{h_i}{6} M_{i+1} =
#    \frac{f_{i+1} - f_i}{h_i} - \frac{f_i - f_{i-1}}{h_{i-1}}, \qquad i = 2, \dots, N - 1,
#    \tag{10.7} $$
#
# and the natural spline has $M_1 = M_N = 0$. In the worked example there is one equation,
# $\tfrac23 M_2 = -1 - 1$, so $M_2 = -3$. Indeed $s''(1) = 6 \cdot (-\tfrac12) = -3$.
#
# ### 10.3 The moments
#
# Write a function that solves this *tridiagonal system*. From here on the sites are in ascending
# order. They may be far from the origin, some $10^4$ times as far as from each other. With two
# sites only, all moments are zero.
#
# <details><summary>Hint</summary>
#
# Begin with an identity matrix and zeros on the right side: then the first and the last row are
# complete. Each of the other rows has three entries. Differentiate (10.6) at $u = 0$ and $u = 1$ to
# derive (10.7).
#
# </details>


# %% question="10.3" minutes=20
def moments(sites, values):
    """Return M of (10.7), of shape (N,), for ascending sites (N,) and values (N,), N >= 2."""
    # BEGIN SOLUTION
    n, h = len(sites), np.diff(sites)
    rise = np.diff(values) / h
    a, right = np.eye(n), np.zeros(n)
    for i in range(1, n - 1):
        a[i, i - 1 : i + 2] = h[i - 1] / 6, (h[i - 1] + h[i]) / 3, h[i] / 6
        right[i] = rise[i] - rise[i - 1]
    return np.linalg.solve(a, right)
    # END SOLUTION


# %%
check("10.3")

# %% [markdown]
# ### 10.4 The pieces
#
# Write a function that evaluates the spline at any points, in any order, also where the sites are
# far from the origin, some $10^4$ times as far as from each other. Use (10.6) on the interval of
# each point. Outside, use the tangents at the first and the last site. The argument `M` contains
# the moments of the spline through the values.
#
# <details><summary>Hint</summary>
#
# `np.searchsorted` finds the interval. For points outside take the first or the last interval: $u$
# is then below 0 or above 1. Now replace the powers $u^3$ and $(1-u)^3$ of (10.6) by the truncated
# powers $u_+^3$ and $(1-u)_+^3$. What remains outside? Remember that $M_1 = M_N = 0$.
#
# </details>


# %% question="10.4" minutes=20
def piecewise(sites, values, M, x):
    """Return s at points x (K,) in any order: inside by (10.6), straight outside.

    M (N,) are the moments of the spline through the values, zero at both ends.
    """
    # BEGIN SOLUTION
    i = np.clip(np.searchsorted(sites, x) - 1, 0, len(sites) - 2)
    h = sites[i + 1] - sites[i]
    u = (x - sites[i]) / h
    left, right = np.maximum(1 - u, 0) ** 3 - (1 - u), np.maximum(u, 0) ** 3 - u
    bent = h**2 / 6 * (left * M[i] + right * M[i + 1])
    return (1 - u) * values[i] + u * values[i + 1] + bent
    # END SOLUTION


# %%
check("10.4")


# %%
@draw(reach=Slider(0.2, 3, 1.2, "how far outside"))
def beyond_the_pins(reach):
    pins, heights = data("10.3")
    M = moments(pins, heights)
    a, b = radial_spline(pins, heights)
    side = np.linspace(pins[0] - reach, pins[-1] + reach, 400)
    curve = piecewise(pins, heights, M, side)
    other = np.abs(np.subtract.outer(side, pins)) ** 3 @ a + b[0] + b[1] * side
    with figure(6.4, 3.2) as page:
        left, right = page.subplots(1, 2)
        left.plot(side, curve, color=BLUE, label="natural spline")
        for first, outside in ((0, side < pins[0]), (-2, side > pins[-1])):
            start, end = pins[first], pins[first + 1]
            four = np.linspace(start, end, 4)
            cubic = np.polynomial.Polynomial.fit(four, piecewise(pins, heights, M, four), 3)
            left.plot(
                side[outside],
                cubic(side[outside]),
                color=ORANGE,
                ls="--",
                label="cubic continued" if first else None,
            )
        left.plot(pins, heights, "o", color="black", ms=4)
        left.set(
            xlabel="$x$",
            title=f"the two forms differ by {np.abs(curve - other).max():.0e}",
            ylim=(-6, 6),
        )
        left.legend(loc="upper center", bbox_to_anchor=(0.5, -0.22), ncols=2, fontsize=9)
        right.axhline(0, color=GREY, lw=0.8)
        right.plot([side[0], *pins, side[-1]], [0, *M, 0], "-", color=BLUE)
        right.plot(pins, M, "o", color="black", ms=4)
        right.set(xlabel="$x$", title="second derivative")
    return page


# %% [markdown]
# **What to look at.** The curve by distances and the curve by pieces are the same curve, up to
# rounding. A program that sets $M_1 = M_N = 0$ and continues the outer cubics (dashed) is right
# between the sites. Outside it is wrong: a natural spline is straight there. The right panel shows
# the second derivative, a broken line that is zero at both ends. Its slope is the third derivative,
# which jumps at every site, including the first and the last.
#
# The next picture returns to the eight pins of the beginning, with your spline.


# %%
@draw(height=Slider(-1, 2, -0.5, "height of the fourth pin"))
def eight_pins(height):
    pins = np.array([0.0, 0.9, 1.7, 3.0, 3.8, 5.1, 6.0, 7.0])
    heights = np.array([0.2, 0.9, 0.5, height, 1.0, 0.1, 0.3, 0.9])
    side = np.linspace(-0.6, 7.6, 400)
    inside = np.linspace(0, 7, 400)
    with figure(6.4, 2.8) as page:
        axes = page.subplots()
        polynomial = np.polynomial.Polynomial.fit(pins, heights, 7)
        axes.plot(inside, polynomial(inside), color=ORANGE, lw=1, label="polynomial")
        spline = piecewise(pins, heights, moments(pins, heights), side)
        axes.plot(side, spline, color=BLUE, lw=2.2, label="your spline")
        axes.plot(pins, heights, "o", color="black", label="pins")
        axes.set(xlabel="$x$", ylabel="height", ylim=(-2, 3))
        axes.legend(loc="lower center", ncols=3)
    return page


# %% [markdown]
# ## Real data: carbon dioxide on Mauna Loa
#
# The next cell contains the weekly means of the carbon dioxide in the air of Mauna Loa, Hawaii,
# from 1963 to 1965. Source: C. D. Keeling and T. P. Whorf, Carbon Dioxide Information Analysis
# Center, US Department of Energy, 2004, as packed in statsmodels; in the public domain. Days count
# from 1 January 1963. Some weeks are missing, among them 18 weeks in a row in spring 1964. The
# picture uses every $n$-th week as a site and the other weeks to measure the error.


# %%
DAY = np.array(
    """
    4 11 18 25 32 39 53 60 67 74 81 88 95 102 109 116 130 137 144 151 158 165 172 179 186
    193 200 207 214 221 228 235 242 249 256 263 270 277 284 291 298 305 312 319 333 340 347
    354 361 368 375 382 515 522 543 550 557 564 571 578 592 599 606 613 620 627 634 641 648
    655 662 669 676 683 690 697 704 711 718 725 732 739 746 753 760 767 774 781 788 795 802
    809 816 823 830 837 844 851 858 865 872 879 886 893 900 907 914 921 928 935 942 949 956
    963 970 977 984 991 998 1005 1012 1019 1026 1033 1040 1047 1054 1061 1068 1075 1082 1089
    """.split(),
    dtype=float,
)
CO2 = np.array(
    """
    318.5 318.7 318.9 318.8 318.7 318.9 319.3 319.3 319.7 319.8 320.3 320.2 320.3 320.9
    322.0 321.9 321.9 322.2 322.2 322.3 322.0 321.8 320.8 320.4 320.1 319.8 319.5 319.0
    318.6 318.2 317.7 317.1 316.4 316.8 315.9 316.0 315.9 316.2 315.6 316.1 316.3 316.6
    316.8 317.1 317.5 318.0 318.2 318.5 318.7 319.0 319.4 319.8 322.0 322.0 321.5 321.1
    319.9 320.2 320.0 319.1 318.6 318.2 318.1 317.4 316.5 315.5 317.0 316.9 316.5 316.8
    317.0 317.6 317.7 317.6 317.5 318.1 318.4 318.5 318.9 318.9 319.0 319.1 319.1 319.7
    320.1 320.2 320.1 320.7 320.8 321.0 320.9 320.4 321.4 321.9 322.2 322.1 321.8 322.4
    322.2 321.9 321.6 322.2 321.8 321.7 321.7 321.9 321.9 321.8 321.7 320.4 319.4 319.4
    318.0 318.8 318.7 318.3 318.0 318.2 316.8 316.6 317.2 317.8 317.5 317.6 318.3 319.2
    318.9 319.1 319.0 319.3 319.3 319.7
    """.split(),
    dtype=float,
)


@draw(
    step=Slider(2, 12, 8, "every n-th week", whole=True),
    day=Slider(0, 900, 250, "from day", whole=True),
)
def mauna_loa(step, day):
    used, held_out = DAY[::step], np.delete(np.arange(len(DAY)), np.s_[::step])
    held_out = held_out[DAY[held_out] < used[-1]]
    M = moments(used, CO2[::step])

    def spline(days):
        return piecewise(used, CO2[::step], M, days)

    side = np.linspace(day, day + 190, 400)
    exact = CO2[held_out]
    curves = (
        ("broken line", np.interp(DAY[held_out], used, CO2[::step]), GREEN),
        ("natural spline", spline(DAY[held_out]), BLUE),
    )
    errors = {name: np.sqrt(np.mean((values - exact) ** 2)) for name, values, _ in curves}
    whole = np.linspace(DAY[0], used[-1], 900)
    with figure(6.8, 3.2) as page:
        axes, detail = page.subplots(1, 2, width_ratios=(1.5, 1), sharey=True)
        for panel, days in ((axes, whole), (detail, side)):
            panel.plot(days, np.interp(days, used, CO2[::step]), color=GREEN, lw=1, ls="--")
            panel.plot(days, spline(days), color=BLUE)
            panel.plot(DAY[held_out], exact, ".", color=GREY, ms=4, label="held out")
            panel.plot(used, CO2[::step], "o", color="black", ms=4, label="sites")
            panel.set(xlabel="day")
        axes.axvspan(382, 515, color=GREY, alpha=0.15, lw=0)
        axes.set(ylabel="carbon dioxide [ppm]", ylim=(314, 325))
        axes.set_title(", ".join(f"{name} {e:.2f} ppm" for name, e in errors.items()), loc="left")
        detail.set(xlim=(day, day + 190), title="detail")
        axes.legend(loc="upper left", ncols=2)
    return page


# %% [markdown]
# **What to look at.** With every eighth week the spline is more accurate than the broken line,
# because the seasons are a smooth curve. With every second week it is less accurate. The
# measurements have errors of about 0.3 ppm, and an interpolating spline reproduces them and
# oscillates. Such data need smoothing. In the gap of 1964 the curve is only a guess: nothing in the
# data determines its height there.
#
# ## Jumps of the third derivative
#
# The jumps of the third derivative lead back to (10.1). A term $\alpha_j (x - x_j)_+^3$ has the
# third derivative 0 to the left of $x_j$ and $6 \alpha_j$ to the right, and no other term of (10.1)
# jumps there. So
#
# $$ \alpha_j = \tfrac16 \bigl( s'''(x_j^+) - s'''(x_j^-) \bigr), \tag{10.8} $$
#
# and the line $\beta_0 + \beta_1 x$ is the curve before the first site. In the worked example
# $s''' = 0, -3, 3, 0$ on the four intervals, with the jumps $-3, 6, -3$.
#
# ### 10.5 Back to truncated powers
#
# Write a function that returns $\alpha$ and $\beta$ of (10.1) from the values and the moments.
#
# <details><summary>Hint</summary>
#
# On one interval $s''$ is linear, from $M_i$ to $M_{i+1}$: what is its slope? Outside it is zero.
# For the line, differentiate (10.6) at the left end of the first interval.
#
# </details>


# %% question="10.5" minutes=15
def truncated(sites, values, M):
    """Return α and β of (10.1), of shapes (N,) and (2,), for ascending sites (N,), N >= 2.

    M (N,) are the moments, zero at both ends.
    """
    # BEGIN SOLUTION
    h = np.diff(sites)
    thirds = np.diff(M) / h
    alpha = np.diff(thirds, prepend=0, append=0) / 6
    slope = (values[1] - values[0]) / h[0] - h[0] / 6 * M[1]
    return alpha, np.array([values[0] - slope * sites[0], slope])
    # END SOLUTION


# %%
check("10.5")


# %%
@draw()
def round_trip():
    pins, heights = data("10.3")
    converted = from_truncated(pins, *truncated(pins, heights, moments(pins, heights)))
    direct = radial_spline(pins, heights)
    with figure(6.4, 2.5) as page:
        axes = page.subplots()
        names = [f"$a_{{{j + 1}}}$" for j in range(len(pins))] + ["$b_0$", "$b_1$"]
        axes.axhline(0, color=GREY, lw=0.8)
        axes.plot(
            names, np.concatenate(direct), "o", mfc="none", ms=10, color=BLUE, label="by distances"
        )
        axes.plot(
            names,
            np.concatenate(converted),
            "x",
            color=ORANGE,
            label="moments, truncated powers, distances",
        )
        axes.set(ylabel="coefficient")
        axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1), ncols=2)
    return page


# %% [markdown]
# **What to look at.** Each cross lies in its circle: the moments, the truncated powers and the
# distances lead to the solution of (10.5). The system (10.5) has a full matrix with $N + 2$ rows,
# the system (10.7) has three numbers in each row. For a hundred thousand pins only (10.7) is
# practical.

# %% [markdown]
# ## The bending energy
#
# The *bending energy* of a curve is, for small slopes and up to a factor,
#
# $$ E(f) = \int f''(x)^2\, dx . \tag{10.9} $$
#
# Among all curves through the pins the natural spline has the smallest bending energy. More
# precisely, if $f$ has the same values at the sites as the spline $s$, then
#
# $$ \int (f'' - s'')\, s''\, dx = 0, \qquad \text{hence} \qquad E(f) = E(s) + E(f - s) .
#    \tag{10.10} $$
#
# This is the theorem of Pythagoras in a space of functions, also called the *minimal norm
# property*.
#
# ### 10.6 The energy of the spline
#
# Write a function that computes $E(s)$ exactly from the moments, also where the sites are far from
# the origin, some $10^4$ times as far as from each other: $s''$ is a broken line, and its square is
# a parabola on each interval. In the worked example the moments are $0, -3, 0$, and $E(s) = 3 + 3 =
# 6$. Integrate from $x_1$ to $x_N$. In the check the moments at both ends need not be zero.
#
# <details><summary>Hint</summary>
#
# On an interval of length $h$ let $s''$ be linear from $p$ to $q$. What is
# $h \int_0^1 \bigl((1-u)\, p + u\, q\bigr)^2 du$?
#
# </details>


# %% question="10.6" minutes=10
def energy(sites, M):
    """Return E of (10.9), a number, for ascending sites (N,) and the moments at them (N,)."""
    # BEGIN SOLUTION
    p, q = M[:-1], M[1:]
    return np.diff(sites) @ (p**2 + p * q + q**2) / 3
    # END SOLUTION


# %%
check("10.6")


# %%
@draw(size=Slider(-1, 1, 0.5, "how much is added"))
def pythagoras(size):
    pins, heights = data("10.3")
    M = moments(pins, heights)
    side = np.linspace(pins[0], pins[-1], 4001)
    i = np.searchsorted(pins[1:-1], side)
    width = pins[i + 1] - pins[i]
    u = (side - pins[i]) / width
    turn = (-1.0) ** i
    added = turn * 8 * u**2 * (1 - u) ** 2
    bend_added = turn * 8 * (2 - 12 * u + 12 * u**2) / width**2
    bend = np.interp(side, pins, M)
    sizes = np.linspace(-1, 1, 41)
    total = [np.trapezoid((bend + c * bend_added) ** 2, side) for c in sizes]
    with figure(6.4, 3.4) as page:
        left, right = page.subplots(1, 2)
        curve = piecewise(pins, heights, M, side)
        left.plot(side, curve + size * added, color=ORANGE, label="another curve")
        left.plot(side, curve, color=BLUE, label="natural spline")
        left.plot(pins, heights, "o", color="black", ms=4)
        left.set(xlabel="$x$")
        left.legend(loc="upper center", bbox_to_anchor=(0.5, -0.2), fontsize=9)
        right.plot(sizes, total, color=ORANGE, label="energy of the other")
        right.axhline(energy(pins, M), color=BLUE, label="of the spline: yours")
        right.plot(size, np.interp(size, sizes, total), "o", color=ORANGE)
        right.set(xlabel="how much is added", ylim=(0, None))
        right.legend(loc="upper center", bbox_to_anchor=(0.5, -0.2), fontsize=9)
    return page


# %% [markdown]
# **What to look at.** The orange curve passes through all pins: it is the spline plus a wave that
# is zero at each pin. Its energy is a quadratic function of the size of the wave. The minimum is at
# the size 0, and its value must be your number. By (10.10) the quadratic function has no linear
# term, for any wave.

# %% [markdown]
# ## B-splines
#
# The function $\lvert x - x_j \rvert^3$ is nonzero almost everywhere, and it grows. But some linear
# combinations of a few of them vanish outside a few intervals. These are the *B-splines*. Let
# $t_1 \leq t_2 \leq \dots \leq t_n$ be *knots*. For the degree 0
#
# $$ B_{i,0}(x) = \begin{cases} 1 & \text{for } t_i \leq x < t_{i+1}, \\ 0 & \text{otherwise,}
#    \end{cases} \tag{10.11} $$
#
# and from one degree to the next (the *Cox–de Boor recursion*)
#
# $$ B_{i,k}(x) = \frac{x - t_i}{t_{i+k} - t_i}\, B_{i,k-1}(x) +
#    \frac{t_{i+k+1} - x}{t_{i+k+1} - t_{i+1}}\, B_{i+1,k-1}(x) . \tag{10.12} $$
#
# Knots may coincide; a quotient with the denominator zero counts as zero, as in the function of the
# next cell. Knots may also be far from the origin. There are $n - k - 1$ B-splines of the degree
# $k$, here one at least. By (10.11) all of them are zero at the last knot, $x = t_n$.
#
# *Example.* For the knots $0, 1, 2$ the only B-spline of degree 1 is the hat function: $x$ on
# $[0, 1)$ and $2 - x$ on $[1, 2)$.


# %% tags=["setup"]
def quotient(top, bottom):
    """Return top / bottom for an array and a number; zeros if the number is zero."""
    return top / bottom if bottom > 0 else 0 * top


# %% [markdown]
# ### 10.7 B-splines
#
# Write a function that returns all B-splines of a degree: a row for each point, a column for each
# $i$. The knots may have any unit of length, and may be far from the origin, up to $10^9$ times as
# far as from each other.
#
# <details><summary>Hint</summary>
#
# Keep a list of arrays, one for each $i$. The list of degree 0 has $n - 1$ members, and each step
# makes a list that is shorter by one. Indices begin at zero in NumPy. `np.stack` makes a matrix
# from a list.
#
# </details>


# %% question="10.7" minutes=30 optional
def b_splines(knots, degree, x):
    """Return B of (10.12), of shape (K, n - degree - 1), for knots (n,) and x (K,)."""
    # BEGIN SOLUTION
    t = knots
    b = [((t[i] <= x) & (x < t[i + 1])).astype(float) for i in range(len(t) - 1)]
    for k in range(1, degree + 1):
        b = [
            quotient(x - t[i], t[i + k] - t[i]) * b[i]
            + quotient(t[i + k + 1] - x, t[i + k + 1] - t[i + 1]) * b[i + 1]
            for i in range(len(b) - 1)
        ]
    return np.stack(b, axis=1)
    # END SOLUTION


# %%
check("10.7")


# %%
@draw(degree=Slider(0, 3, 3, "degree", whole=True), knot=Slider(4, 6, 5, "sixth knot"))
def bells(degree, knot):
    t = np.array([0.0, 1, 2, 3, 4, knot, 6, 7, 8, 9])
    side = np.linspace(0, 9, 901)
    values = b_splines(t, degree, side)
    with figure(6.4, 2.9) as page:
        axes = page.subplots()
        colors = (BLUE, ORANGE, GREEN, PURPLE)
        for i, bell in enumerate(values.T):
            axes.plot(side, bell, color=colors[i % 4])
        axes.plot(side, values.sum(axis=1), color=GREY, ls="--", label="their sum")
        axes.plot(t, 0 * t, "|", color="black", ms=12, label="knots")
        axes.set(xlabel="$x$", xticks=np.arange(10), ylim=(-0.05, 1.3), title=f"degree {degree}")
        axes.legend(loc="upper right", ncols=2)
    return page


# %% [markdown]
# **What to look at.** A B-spline of degree $k$ vanishes outside $k + 1$ intervals and is never
# negative. Wherever $k + 1$ of them overlap, their sum is one. Move the sixth knot onto its
# neighbour: at a double knot a cubic spline has only one continuous derivative. Try the degree 1
# there.
#
# The natural spline is nearly local as well. In the next picture one of 21 values changes by 1, and
# the curve is the change of the natural spline.


# %%
@draw(which=Slider(1, 21, 11, "which value", whole=True))
def influence(which):
    pins = np.arange(1.0, 22)
    one = (pins == which).astype(float)
    side = np.linspace(0, 22, 1761)
    change = np.abs(piecewise(pins, one, moments(pins, one), side))
    with figure(6.4, 2.8) as page:
        axes = page.subplots()
        axes.semilogy(
            side, np.maximum(change, 1e-12), color=BLUE, lw=1.2, label="change of the curve"
        )
        axes.semilogy(
            side,
            0.5 * (2 - np.sqrt(3)) ** np.abs(side - which),
            color=ORANGE,
            ls="--",
            label=r"$(2 - \sqrt{3})^{\,j}$, times ½",
        )
        axes.set(xlabel="$x$", ylim=(1e-9, 1e3), xticks=[1, 6, 11, 16, 21])
        axes.legend(loc="upper right", ncols=2)
    return page


# %% [markdown]
# **What to look at.** From one pin to the next the influence decreases by the factor
# $2 - \sqrt{3} \approx 0.268$. To derive this number, up to its sign, substitute $M_i = z^i$ into
# (10.7), with equal steps and zeros on the right side.
#
# ## In words
#
# **10.8** Prove (10.10): $\int (f'' - s'')\, s''\, dx = 0$ if $f$ is smooth and has the same values
# at the sites as the natural spline $s$. Say where you use that $s$ is *natural*, and where you use
# that the values agree.
#
# <details><summary>Hint</summary>
#
# Integrate by parts on each interval: $\int g'' s'' = [g' s''] - \int g' s'''$ with $g = f - s$.
# What is $s'''$ on an interval? What is the sum of the brackets?
#
# </details>

# %% [markdown] answer="10.8" points=4 minutes=10 words=50
# Let $g = f - s$. On each interval $\int g'' s''\,dx = [g' s''] - \int g' s'''\,dx$. The brackets
# cancel at inner sites, where $g'$ and $s''$ are continuous. At the ends they vanish because $s$ is
# natural: $s'' = 0$ there. On an interval $s'''$ is constant, and $\int g'\,dx = 0$ because the
# values agree. Outside the sites $s'' = 0$.
#
# *Beyond the question.* $\int g'\,dx$ over an interval is the difference of $g$ at its ends, where
# $g$ vanishes. The second part of (10.10) follows from $f'' = s'' + g''$: $E(f) = E(s) + 2 \int g''
# s''\,dx + E(g) = E(s) + E(g) \geq E(s)$. Equality means $g'' = 0$: $g$ is a straight line that
# vanishes at $N \geq 2$ sites, so $f = s$.

# %% [markdown] rubric="10.8"
# One point: integration by parts on each interval. One: the boundary terms cancel at inner sites.
# One: they vanish at the ends since $s''$ is zero there, which is where *natural* is used. One: the
# third derivative is constant on an interval and the difference of $g$ is zero, which is where the
# values are used.

# %% [markdown]
# **10.9** A text says: a cubic spline is natural if and only if $s''(x_1) = s'''(x_1) = 0$ and
# $s''(x_N) = s'''(x_N) = 0$. A student computes the third derivative just to the right of $x_1$,
# finds 13759, and concludes that the program is wrong. Is the student right? Explain what the text
# must mean.
#
# <details><summary>Hint</summary>
#
# In the picture with the second derivative, look at the slope of the broken line on both sides of
# the first pin.
#
# </details>

# %% [markdown] answer="10.9" points=3 minutes=10 words=70
# No. The third derivative of a cubic spline jumps at the sites, so $s'''(x_1)$ is not defined by
# itself. Before the first site the natural spline is straight, so the limits from *outside* are
# zero, for the second and for the third derivative. This is what the text must mean. From inside
# $s'''(x_1^+) = M_2 / h_1$, which may be any number.
#
# *Beyond the question.* If the limit from inside were zero too, the curve would be straight on the
# first interval as well. The conditions $s'' = 0$ at both ends determine the curve between the
# sites only. Outside, a program must continue by the tangents; a continued cubic is not a natural
# spline.

# %% [markdown] rubric="10.9"
# One point: the third derivative jumps at a site, so the side matters. One: the statement of the
# text holds for the limit from outside. One: from inside it is $M_2/h_1$ and need not vanish, so
# the number is no error.

# %% [markdown]
# **10.10** Derive the dimension of the space of natural cubic splines with $N \geq 2$ sites by
# counting coefficients and conditions.
#
# <details><summary>Hint</summary>
#
# A cubic polynomial on the left has four coefficients. At each site one more number is free, the
# jump of the third derivative. How many conditions make the outer two pieces straight?
#
# </details>

# %% [markdown] answer="10.10" points=3 minutes=10 words=70
# All cubic splines form a space of dimension $N + 4$: a cubic polynomial before the first site has
# four coefficients, and each site adds a truncated power with one coefficient. A straight line on
# the left takes two conditions (no $x^2$, no $x^3$). A straight line on the right takes two more,
# which are (10.2). For $N \geq 2$ the four are independent, so the dimension is $N$.
#
# *Beyond the question.* It is the number of values. For $N = 1$ the conditions (10.2) are $\alpha_1
# = 0$ twice, and the natural splines are the straight lines: the dimension is two. Many straight
# lines pass through a single pin, so interpolation needs $N \geq 2$.

# %% [markdown] rubric="10.10"
# One point for $N + 4$ coefficients of a cubic spline. One for two conditions on each side. One for
# $N$, since the four conditions are independent.

# %% [markdown]
# ## Dig deeper
#
# - Show that $E(s) = 12\, \mathbf{a}^T\mathbf{f}$, first by numbers, then by (10.8) and integration
#   by parts.
# - Which theorem on the kernel $r^3$ says that (10.5) has exactly one solution? Use the order of
#   $r^3$ and (10.2).
# - Interpolate $\sin x$ on $[0, 3]$ with 10, 20, 40, 80 sites. How does the largest error decrease,
#   in the middle and near the ends? Where is the natural spline less accurate, and why?
# - *Marsden's identity* says that for every number $y$, $(y - x)^k$ is the sum of $B_{i,k}(x)$
#   times $(y - t_{i+1}) \cdots (y - t_{i+k})$. Test it. What does it say for the highest power of
#   $y$?
# - The convolution of a box function with a box of the same width is a B-spline of degree 1 on
#   whole numbers, and so on. Compute it with `np.convolve`, and compare with your `b_splines`.
# - Write `moments` without a full matrix, with a number of operations proportional to $N$ (Thomas
#   algorithm). How many pins are possible now?
#
# **Next**: notebook 12 couples a structure and a flow by such interpolants.

# %%
progress()
