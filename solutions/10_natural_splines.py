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
# # Natural splines
#
# A thin elastic rod is held by pins. Which shape does it take? Draughtsmen built ships with such
# rods and called them *splines*. The shape is the curve through the pins that bends least, and it
# is known in every detail.
#
# In this notebook you compute it in two ways that have nothing in common: by one bump $\lvert x -
# x_j \rvert^3$ for each pin, and by cubic pieces from pin to pin. You convert one into the other,
# see that the curve is straight beyond the last pin, measure how much it bends, and find out how a
# curve whose bumps reach everywhere can be local. In the first way nothing needs the line: it is
# how fields in the plane and in space are made.
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
# Eight pins. A polynomial through all of them swings between them, and a broken line has a kink at
# each. A rod would do neither. Move one pin, and see how far the polynomial feels it.


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
# Let $x_1 < x_2 < \dots < x_N$ be the *sites* and $f_1, \dots, f_N$ the values. A *cubic spline* is
# a curve with two continuous derivatives that is a cubic polynomial between neighbouring sites,
# before the first and after the last. It is *natural* if it is a straight line before the first
# site and after the last: no pin bends it there.
#
# With $y_+ = \max(y, 0)$, the function $(x - x_j)_+^3$ is zero up to $x_j$, a cubic from there on,
# and has two continuous derivatives. Start on the left with a straight line; at each site add a
# multiple of this *truncated power*:
#
# $$ s(x) = \sum_{j=1}^N \alpha_j\, (x - x_j)_+^3 + \beta_0 + \beta_1 x . \tag{10.1} $$
#
# After the last site all truncated powers are powers. There the sum has to be straight again, so
# the factors of $x^3$ and of $x^2$ vanish:
#
# $$ \sum_{j=1}^N \alpha_j = 0, \qquad \sum_{j=1}^N \alpha_j\, x_j = 0 . \tag{10.2} $$
#
# A truncated power knows left from right. A function of the *distance* $\lvert x - x_j \rvert$ does
# not, and has a meaning in the plane too. The bridge is
#
# $$ y_+^3 = \tfrac12 \bigl( \lvert y \rvert^3 + y^3 \bigr) . \tag{10.3} $$
#
# Put it into (10.1), and the same curve becomes, with the same conditions for the new factors
# $a_j$,
#
# $$ s(x) = \sum_{j=1}^N a_j\, \lvert x - x_j \rvert^3 + b_0 + b_1 x, \qquad
#    \sum_{j=1}^N a_j = \sum_{j=1}^N a_j\, x_j = 0 . \tag{10.4} $$
#
# ### 10.1 From truncated powers to distances
#
# Find $a_j$, $b_0$ and $b_1$ with pen and paper, from $\alpha_j$, $\beta_0$ and $\beta_1$. Then
# write it.
#
# <details><summary>Hint</summary>
#
# By (10.3) there is a rest, half of $\sum_j \alpha_j (x - x_j)^3$. Expand the cube. Which of the
# four powers of $x$ drop out by (10.2), and to which coefficients do the others belong?
#
# </details>


# %% question="10.1"
def from_truncated(sites, alpha, beta):
    """Return a and b of (10.4), of shapes (N,) and (2,).

    alpha (N,) and beta (2,) are those of (10.1), and satisfy (10.2).
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
        for axes, terms, rest, title in (
            (left, alpha * z.clip(0) ** 3, 0.4 - 0.6 * side, "truncated powers"),
            (right, a * np.abs(z) ** 3, b[0] + b[1] * side, "distances"),
        ):
            axes.plot(side, terms, color=GREY, lw=1)
            axes.plot(side, rest, color=GREEN, lw=1.2, ls="--", label="straight line")
            axes.plot(side, terms.sum(axis=1) + rest, color=BLUE, lw=2.2, label="sum")
            for knot in knots:
                axes.axvline(knot, color=GREY, lw=0.6, ls=":")
            axes.set(title=title, xlabel="$x$", ylim=(-12, 12))
        left.legend(loc="lower left")
    return page


# %% [markdown]
# **What to look at.** The grey terms and the dashed lines differ, the sums do not. On the left
# nothing happens before the first site. On the right all terms are there from the start, left and
# right look alike, and together they are straight on both sides: that is the work of (10.2).

# %% [markdown]
# ## Through the pins
#
# In (10.4) there are $N + 2$ unknowns, and $N + 2$ equations: $s(x_i) = f_i$, and the two side
# conditions. With $A_{ij} = \lvert x_i - x_j \rvert^3$ and $\mathbf{P}$ with the rows $(1, x_i)$,
#
# $$ \begin{bmatrix} \mathbf{A} & \mathbf{P} \\ \mathbf{P}^T & \mathbf{0} \end{bmatrix}
#    \begin{bmatrix} \mathbf{a} \\ \mathbf{b} \end{bmatrix} =
#    \begin{bmatrix} \mathbf{f} \\ \mathbf{0} \end{bmatrix} . \tag{10.5} $$
#
# So the natural spline is a radial basis function: the kernel $r^3$ and a polynomial of degree one.
#
# ### 10.2 The spline by distances
#
# Solve (10.5). The sites may come in any order: nothing in the system asks for it.


# %% question="10.2"
def radial_spline(sites, values):
    """Return a (N,) and b (2,) of (10.4), for values (N,) at sites (N,)."""
    # BEGIN SOLUTION
    n = len(sites)
    p = np.stack([np.ones(n), sites], axis=1)
    kernel = np.abs(sites[:, np.newaxis] - sites) ** 3
    system = np.block([[kernel, p], [p.T, np.zeros((2, 2))]])
    found = np.linalg.solve(system, np.append(values, [0, 0]))
    return found[:n], found[n:]
    # END SOLUTION


# %%
check("10.2")


# %%
@draw(height=Slider(-2, 2, 0.8, "height of the fourth pin"))
def the_rod(height):
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
# **What to look at.** Your own pins. The rod is straight outside the grey part. Move a pin: near it
# the rod follows, a few pins further it hardly notices.

# %% [markdown]
# ## From pin to pin
#
# Now forget all that. On each interval the spline is a cubic, so its second derivative is a
# straight line, and $s''$ is a broken line. Call its values at the sites the *moments* $M_i =
# s''(x_i)$. With $h_i = x_{i+1} - x_i$ and $u = (x - x_i) / h_i$, the cubic on $[x_i, x_{i+1}]$
# that has the values $f_i$, $f_{i+1}$ and the second derivatives $M_i$, $M_{i+1}$ at its ends is
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
# and natural means $M_1 = M_N = 0$.
#
# ### 10.3 The moments
#
# Write the system and solve it. From here on the sites ascend. With two sites only, there is
# nothing to bend.
#
# <details><summary>Hint</summary>
#
# Begin with an identity matrix and zeros on the right side: then the first and the last row are
# done. Each of the others has three entries. Differentiate (10.6) at $u = 0$ and $u = 1$ to see
# where (10.7) comes from.
#
# </details>


# %% question="10.3"
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
# Evaluate the spline at any places: (10.6) on the interval in which each place lies, and outside
# the straight lines that continue the first and the last piece with their value and slope.
#
# <details><summary>Hint</summary>
#
# `np.searchsorted` finds the interval. For places outside take the first interval or the last: $u$
# is then below 0 or above 1. What becomes of (10.6) there, if the powers $u^3$ and $(1-u)^3$ are
# replaced by truncated ones, $u_+^3$ and $(1-u)_+^3$? Remember $M_1 = M_N = 0$.
#
# </details>


# %% question="10.4"
def piecewise(sites, values, bends, x):
    """Return s at places x (K,), inside by (10.6), straight outside.

    bends (N,) are the moments, zero at both ends.
    """
    # BEGIN SOLUTION
    i = np.clip(np.searchsorted(sites, x) - 1, 0, len(sites) - 2)
    h = sites[i + 1] - sites[i]
    u = (x - sites[i]) / h
    left, right = np.maximum(1 - u, 0) ** 3 - (1 - u), np.maximum(u, 0) ** 3 - u
    bent = h**2 / 6 * (left * bends[i] + right * bends[i + 1])
    return (1 - u) * values[i] + u * values[i + 1] + bent
    # END SOLUTION


# %%
check("10.4")


# %%
@draw(reach=Slider(0.2, 3, 1.2, "how far outside"))
def beyond_the_pins(reach):
    pins, heights = data("10.3")
    bends = moments(pins, heights)
    a, b = radial_spline(pins, heights)
    side = np.linspace(pins[0] - reach, pins[-1] + reach, 400)
    curve = piecewise(pins, heights, bends, side)
    other = np.abs(np.subtract.outer(side, pins)) ** 3 @ a + b[0] + b[1] * side
    with figure(6.4, 3.2) as page:
        left, right = page.subplots(1, 2)
        left.plot(side, curve, color=BLUE, label="natural spline")
        for first, way in ((0, side < pins[0]), (-2, side > pins[-1])):
            start, end = pins[first], pins[first + 1]
            four = np.linspace(start, end, 4)
            cubic = np.polynomial.Polynomial.fit(four, piecewise(pins, heights, bends, four), 3)
            left.plot(
                side[way],
                cubic(side[way]),
                color=ORANGE,
                ls="--",
                label="cubic continued" if first else None,
            )
        left.plot(pins, heights, "o", color="black", ms=4)
        left.set(
            xlabel="$x$",
            title=f"two routes differ by {np.abs(curve - other).max():.0e}",
            ylim=(-6, 6),
        )
        left.legend(loc="upper center", bbox_to_anchor=(0.5, -0.22), ncols=2, fontsize=9)
        right.axhline(0, color=GREY, lw=0.8)
        right.plot([side[0], *pins, side[-1]], [0, *bends, 0], "-", color=BLUE)
        right.plot(pins, bends, "o", color="black", ms=4)
        right.set(xlabel="$x$", title="second derivative")
    return page


# %% [markdown]
# **What to look at.** The curve by distances and the curve by pieces are one curve, up to rounding.
# Programs that only set $M_1 = M_N = 0$ and let the outer cubics run on (dashed) agree inside, and
# leave outside: that is no natural spline any more. On the right is the second derivative: a broken
# line, zero at both ends. Its *slope*, the third derivative, jumps at every site, at the first and
# the last as well.
#
# The jump tells the way back. A term $\alpha_j (x - x_j)_+^3$ has the third derivative 0 to the
# left of $x_j$ and $6 \alpha_j$ to the right, and no other term of (10.1) jumps there. So
#
# $$ \alpha_j = \tfrac16 \bigl( s'''(x_j^+) - s'''(x_j^-) \bigr), \tag{10.8} $$
#
# and the line $\beta_0 + \beta_1 x$ is the curve before the first site.
#
# ### 10.5 Back to truncated powers
#
# Write $\alpha$ and $\beta$ of (10.1), from the values and the moments.
#
# <details><summary>Hint</summary>
#
# On one interval $s''$ goes from $M_i$ to $M_{i+1}$ in a straight line: what is its slope? Outside
# it is zero. For the line, differentiate (10.6) at the left end of the first interval.
#
# </details>


# %% question="10.5"
def truncated(sites, values, bends):
    """Return α and β of (10.1), of shapes (N,) and (2,).

    bends (N,) are the moments, zero at both ends.
    """
    # BEGIN SOLUTION
    h = np.diff(sites)
    thirds = np.diff(bends) / h
    alpha = np.diff(thirds, prepend=0, append=0) / 6
    slope = (values[1] - values[0]) / h[0] - h[0] / 6 * bends[1]
    return alpha, np.array([values[0] - slope * sites[0], slope])
    # END SOLUTION


# %%
check("10.5")


# %%
@draw()
def round_trip():
    pins, heights = data("10.3")
    way = from_truncated(pins, *truncated(pins, heights, moments(pins, heights)))
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
            np.concatenate(way),
            "x",
            color=ORANGE,
            label="moments, truncated powers, distances",
        )
        axes.set(ylabel="coefficient")
        axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1), ncols=2)
    return page


# %% [markdown]
# **What to look at.** Every cross in its circle: from the moments by way of truncated powers you
# arrive at the solution of (10.5). One route costs a full system of $N + 2$ equations, the other
# three numbers in each row. For a hundred thousand pins only the second one is possible.

# %% [markdown]
# ## The least bending
#
# The *energy* of a curve is
#
# $$ E(f) = \int f''(x)^2\, dx . \tag{10.9} $$
#
# Of all curves through the pins the natural spline has the least. More precisely, if $f$ goes
# through the same values as the spline $s$, then
#
# $$ \int (f'' - s'')\, s''\, dx = 0, \qquad \text{hence} \qquad E(f) = E(s) + E(f - s) ,
#    \tag{10.10} $$
#
# a theorem of Pythagoras for curves.
#
# ### 10.6 The energy of the spline
#
# Write $E(s)$ from the moments, exactly: $s''$ is a broken line, and its square a parabola on each
# interval.
#
# <details><summary>Hint</summary>
#
# On an interval of the length $h$ on which $s''$ goes from $p$ to $q$: what is $h \int_0^1
# \bigl((1-u)\, p + u\, q\bigr)^2 du$?
#
# </details>


# %% question="10.6"
def energy(sites, bends):
    """Return E of (10.9), a number, for ascending sites (N,) and the moments at them (N,)."""
    # BEGIN SOLUTION
    p, q = bends[:-1], bends[1:]
    return np.diff(sites) @ (p**2 + p * q + q**2) / 3
    # END SOLUTION


# %%
check("10.6")


# %%
@draw(size=Slider(-1, 1, 0.5, "how much is added"))
def pythagoras(size):
    pins, heights = data("10.3")
    bends = moments(pins, heights)
    side = np.linspace(pins[0], pins[-1], 4001)
    i = np.searchsorted(pins[1:-1], side)
    width = pins[i + 1] - pins[i]
    u = (side - pins[i]) / width
    turn = (-1.0) ** i
    added = turn * 8 * u**2 * (1 - u) ** 2
    bend_added = turn * 8 * (2 - 12 * u + 12 * u**2) / width**2
    bend = np.interp(side, pins, bends)
    sizes = np.linspace(-1, 1, 41)
    total = [np.trapezoid((bend + c * bend_added) ** 2, side) for c in sizes]
    with figure(6.4, 3.4) as page:
        left, right = page.subplots(1, 2)
        curve = piecewise(pins, heights, bends, side)
        left.plot(side, curve + size * added, color=ORANGE, label="another curve")
        left.plot(side, curve, color=BLUE, label="natural spline")
        left.plot(pins, heights, "o", color="black", ms=4)
        left.set(xlabel="$x$")
        left.legend(loc="upper center", bbox_to_anchor=(0.5, -0.2), fontsize=9)
        right.plot(sizes, total, color=ORANGE, label="energy of the other")
        right.axhline(energy(pins, bends), color=BLUE, label="of the spline: yours")
        right.plot(size, np.interp(size, sizes, total), "o", color=ORANGE)
        right.set(xlabel="how much is added", ylim=(0, None))
        right.legend(loc="upper center", bbox_to_anchor=(0.5, -0.2), fontsize=9)
    return page


# %% [markdown]
# **What to look at.** The orange curve goes through all pins, with a wave added that is zero at
# each. Its energy is a parabola in the size of the wave, and its lowest point touches your number,
# exactly where nothing is added. By (10.10) it has no linear part, whatever wave one takes.

# %% [markdown]
# ## Local after all
#
# The bump $\lvert x - x_j \rvert^3$ reaches everywhere and grows. But sums of a few of them vanish
# outside a few intervals. These are the *B-splines*. Let $t_1 \leq t_2 \leq \dots \leq t_n$
# be *knots*. For the degree 0
#
# $$ B_{i,0}(x) = \begin{cases} 1 & \text{for } t_i \leq x < t_{i+1}, \\ 0 & \text{otherwise,}
#    \end{cases} \tag{10.11} $$
#
# and from one degree to the next
#
# $$ B_{i,k}(x) = \frac{x - t_i}{t_{i+k} - t_i}\, B_{i,k-1}(x) +
#    \frac{t_{i+k+1} - x}{t_{i+k+1} - t_{i+1}}\, B_{i+1,k-1}(x) . \tag{10.12} $$
#
# Knots may coincide; a quotient whose denominator is zero counts as zero. The next cell has such a
# quotient. There are $n - k - 1$ B-splines of the degree $k$.


# %% tags=["setup"]
def quotient(top, bottom):
    """Return top / bottom for an array and a number; zeros if the number is zero."""
    return top / bottom if bottom > 0 else 0 * top


# %% [markdown]
# ### 10.7 B-splines
#
# Write all B-splines of a degree at once: a row for each place, a column for each $i$.
#
# <details><summary>Hint</summary>
#
# Keep a list of arrays, one for each $i$. The list of degree 0 has $n - 1$ members; each step makes
# a shorter one. Mind that indices begin at zero in NumPy. `np.stack` makes a matrix of a list.
#
# </details>


# %% question="10.7"
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
# **What to look at.** A B-spline of degree $k$ lives on $k + 1$ intervals, is never negative, and
# wherever $k + 1$ of them meet their sum is one. Move the sixth knot onto its neighbour: at a
# double knot a cubic spline has one derivative less. Try the degree 1 there.
#
# Locality shows in the rod as well. Here one value of many is changed by 1, and you see how much
# the natural spline changes from interval to interval.


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
# **What to look at.** From one pin to the next the influence falls to about a quarter: to $2 -
# \sqrt{3} \approx 0.268$, to be precise. Where does that number come from? Put $M_i = z^i$ into
# (10.7) with equal steps and zeros on the right side.
#
# ## In words
#
# **10.8** Prove (10.10): that $\int (f'' - s'')\, s''\, dx = 0$ if $f$ and the natural spline $s$
# have the same values at the sites, and $f$ is smooth. Where do you use that $s$ is *natural*, and
# where that the values are the same? Conclude that no other curve through the pins bends as little.
#
# <details><summary>Hint</summary>
#
# Integrate by parts, interval by interval: $\int g'' s'' = [g' s''] - \int g' s'''$ with $g = f -
# s$. What is $s'''$ on an interval? What becomes of the sum of the brackets?
#
# </details>

# %% [markdown] answer="10.8" points=4
# Let $g = f - s$; it vanishes at all sites. On an interval $\int g'' s'' dx = [g' s''] - \int g'
# s''' dx$.
#
# *The brackets.* $g'$ and $s''$ are continuous, so the brackets of neighbouring intervals cancel at
# each inner site, and $g'(x_N) s''(x_N) - g'(x_1) s''(x_1)$ is left. Here it is used that $s$ is
# natural: $s''$ is zero at both ends.
#
# *The rest.* On an interval $s'''$ is constant, and $\int g' dx$ is the difference of $g$ at the
# two ends, $0 - 0$: here it is used that the values are the same. Outside $s'' = 0$. So the
# integral vanishes.
#
# *Conclusion.* $f'' = s'' + g''$, and $E(f) = E(s) + 2 \int g'' s'' + E(g) = E(s) + E(g) \geq
# E(s)$. Equality means $g'' = 0$: $g$ is a straight line that vanishes at $N \geq 2$ sites, so $g =
# 0$ and $f = s$.

# %% [markdown] rubric="10.8"
# One point: integration by parts on each interval. One: the boundary terms cancel inside, and
# vanish at the ends since s'' is zero there. One: the third derivative is constant on an interval,
# the difference of g is zero. One: Pythagoras and uniqueness, with the argument that g is a line
# with two zeros.

# %% [markdown]
# **10.9** A text says: a cubic spline is natural if and only if $s''(x_1) = s'''(x_1) = 0$ and
# $s''(x_N) = s'''(x_N) = 0$. A student computes the third derivative just to the right of $x_1$,
# finds 13759, and thinks that the program is wrong. Who is right? And what does a program lack that
# only makes $s''(x_1) = s''(x_N) = 0$?
#
# <details><summary>Hint</summary>
#
# Look at the slope of the broken line on the right of the picture with the second derivative, on
# both sides of the first pin.
#
# </details>

# %% [markdown] answer="10.9" points=3
# Both, once it is said from which side. The third derivative of a cubic spline jumps at the sites,
# so $s'''(x_1)$ has no meaning by itself. Before the first site the natural spline is straight, so
# the limit from *outside* is zero, for the second and the third derivative; that is what the text
# must mean. From inside $s'''(x_1^+) = M_2 / h_1$, which may be any number. If it were zero too,
# the curve would be straight on the first interval as well.
#
# $s'' = 0$ at both ends determines the curve between the sites: there such a program is right.
# Outside it says nothing. If the outer cubic is simply continued, its second derivative grows from
# zero on, with the slope $s'''$ of the inside, and the curve is no longer straight nor of finite
# energy. One has to continue by the tangent.

# %% [markdown] rubric="10.9"
# One point: the third derivative jumps at a site, the statement holds for the limit from outside.
# One: inside it need not vanish, so the number is no error. One: s'' = 0 settles the inside only;
# outside one must continue with straight lines, and a continued cubic is not natural.

# %% [markdown]
# **10.10** Count: how many cubic splines are there for $N$ sites, in the sense of a dimension, and
# how many of them are natural? Does the count hold for $N = 1$? And which sentence about the kernel
# $r^3$ says that (10.5) has exactly one solution?
#
# <details><summary>Hint</summary>
#
# A cubic on the left has four coefficients; at each site one more number is chosen, the jump of the
# third derivative. How many conditions make the outer two pieces straight?
#
# </details>

# %% [markdown] answer="10.10" points=3
# A cubic on the far left, four numbers, and at each site a truncated power with one factor: $N +
# 4$. Straight on the left takes two conditions (no $x^2$, no $x^3$), straight on the right two
# more, which are (10.2). So $N$ are left, as many as values, if the four conditions are
# independent.
#
# For $N = 1$ they are not. (10.2) reads $\alpha_1 = 0$ and $\alpha_1 x_1 = 0$, the same condition
# twice; the natural splines are the straight lines, of dimension two and not one, and there are
# many through one pin. One needs $N \geq 2$.
#
# $r^3$ is conditionally positive definite of order two: the form $\mathbf{a}^T \mathbf{A}
# \mathbf{a}$ is positive for all $\mathbf{a} \neq \mathbf{0}$ that satisfy the two side conditions,
# and two distinct sites are enough to determine a polynomial of degree one. Then the system has one
# solution for all values. Here the form has a meaning too: $E(s) = 12\,
# \mathbf{a}^T\mathbf{A}\,\mathbf{a}$.

# %% [markdown] rubric="10.10"
# One point: N + 4 and N, with a reason. One: N = 1 fails, as the conditions depend on each other
# (or: all lines are natural splines). One: order two (positive form on the side conditions) and
# sites that determine a line.

# %% [markdown]
# ## Dig deeper
#
# - Show that $E(s) = 12\, \mathbf{a}^T\mathbf{f}$, first by numbers, then by (10.8) and integration
#   by parts.
# - Interpolate $\sin x$ on $[0, 3]$ with 10, 20, 40, 80 sites. How does the largest error fall, in
#   the middle and near the ends? Where does the natural spline lose, and why?
# - For every number $y$, Marsden's identity says that $(y - x)^k$ is the sum of $B_{i,k}(x)$ times
#   $(y - t_{i+1}) \cdots (y - t_{i+k})$. Try it. What does it say for the highest power of $y$?
# - A box, smeared out by a box of the same width, is a B-spline of degree 1 on whole numbers; and
#   so on. Do it with `np.convolve`, and compare with your `b_splines`.
# - Write `moments` without a full matrix, in a number of steps proportional to $N$. How many pins
#   can you take now?

# %%
progress()
