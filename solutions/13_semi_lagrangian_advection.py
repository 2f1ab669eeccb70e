# ---
# jupyter:
#   course:
#     builds_on:
#       "12": a reconstruction as a matrix of weights
#     pages: book, section 1.3
#     chapters: [34-advection]
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
# # Semi-Lagrangian advection
#
# Smoke moves with the wind, and salt with the sea. The concentration that a particle carries does
# not change on its way. So the value here and now is the value one time step ago at the point from
# which the particle came, its *departure point*. The field is hardly ever known at this point, and
# must be reconstructed there from values at scattered sites. Weather models use this
# *semi-Lagrangian* method (Staniforth and Côté, *Monthly Weather Review* 119, 1991, pages
# 2206–2223).
#
# In this notebook you write the method without any mesh: departure points by three schemes, the
# step as a matrix, bounds, conservation of mass, and a flow whose velocity is the transported
# quantity. You will see why a step may be much longer than the distance between sites, and why the
# shortest steps are not the best.
#
# **Sources.** Wendland, *Scattered Data Approximation* (2005), pages 6–8; Staniforth and Côté
# (1991) and Behrens and Iske (2002) below. Search for: advection equation, characteristics,
# semi-Lagrangian method, CFL number, Runge–Kutta method, quasi-monotone scheme, Burgers'
# equation. The linear system of notebooks 03, 11 and 12 is used again, so here it is given.
# Numbers in brackets, such as (13.1), belong to formulas; numbers without brackets belong to
# questions.
#
# Each question asks for a function with a check below it, or for an answer in words. After a check
# that is not right, `case()` in a new cell shows the inputs for which your function failed, and
# your values. If everybody has the same inputs, it also shows the right values. Arrays may hold
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
from fieldcheck.given import distances, saddle_point_matrix

# %% [markdown]
# ## Transport along particle paths
#
# A vortex transports a field with one peak. The field is known at the dots. The orange dot on the
# right is a site where the new value is required. One step $\Delta t$ ago the particle was at the
# orange cross on the left, where no value is known.


# %%
def scattered_in_disc(n, seed=1):
    """Return n scattered points in the unit disc."""
    random = np.random.default_rng(seed)
    angle = np.pi * (1 + np.sqrt(5)) * np.arange(n)
    radius = np.sqrt((np.arange(n) + 0.5) / n)
    points = radius[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])
    points += random.uniform(-0.3, 0.3, (n, 2)) / np.sqrt(n)
    return points / np.maximum(1, np.hypot(*points.T))[:, None]


def exact_feet(x, t, dt):
    """Return the exact departure points, at time t - dt, of points x (M, 2) at time t in flow 1."""
    angle = np.pi * ((1 + t) ** 2 - (1 + t - dt) ** 2) / (1 + 4 * (x**2).sum(axis=1))
    z = (x[:, 0] + 1j * x[:, 1]) * np.exp(-1j * angle)
    return np.column_stack([z.real, z.imag])


def hill(x, sharpness=14):
    """Return a Gaussian hill with its top at (0.45, 0)."""
    return np.exp(-sharpness * ((x[:, 0] - 0.45) ** 2 + x[:, 1] ** 2))


@draw(dt=Slider(0.02, 0.5, 0.25, "step Δt", steps=24))
def the_problem(dt):
    sites, t = scattered_in_disc(120), 0.6
    side = np.linspace(-1, 1, 81)
    grid = np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2)
    site = sites[np.argmin(((sites - [-0.25, 0.5]) ** 2).sum(axis=1))][None]
    path = np.vstack([exact_feet(site, t, s) for s in np.linspace(0, dt, 30)])
    with figure(6.4, 3.2) as page:
        panels = page.subplots(1, 2)
        for axes, time, point, mark in zip(panels, (t - dt, t), path[[-1, 0]], "Xo"):
            values = hill(exact_feet(grid, time, time)).reshape(81, 81)
            axes.contourf(side, side, values, np.linspace(0.1, 1, 10), cmap="Blues")
            axes.plot(*sites.T, ".", color=GREY, ms=3)
            axes.plot(*path.T, ":", color=ORANGE)
            axes.plot(*point, mark, color=ORANGE, ms=9)
            axes.set(aspect="equal", xlim=(-1.05, 1.05), ylim=(-1.05, 1.05))
            axes.axis("off")
        panels[0].set_title("one step ago")
        panels[1].set_title("now")
    return page


# %% [markdown]
# ## Characteristics and departure points
#
# Let $\mathbf{a}(\mathbf{y}, t)$ be the velocity of the flow. A transported field $u$ satisfies
# the *advection equation*
#
# $$ \frac{\partial u}{\partial t} + \mathbf{a} \cdot \nabla u = 0 . \tag{13.1} $$
#
# The path of a particle, $\dot{\mathbf{y}} = \mathbf{a}(\mathbf{y}, \tau)$, is called a
# *characteristic*; $u$ is constant along it. Follow the characteristic through $\mathbf{x}$ at the
# time $t$ back to the time $t - \Delta t$. The point reached is the departure point, also called
# the *foot* of the characteristic, and
#
# $$ u(\mathbf{x}, t) = u\bigl(\mathbf{y}(t - \Delta t),\, t - \Delta t\bigr), \qquad
#    \dot{\mathbf{y}}(\tau) = \mathbf{a}(\mathbf{y}(\tau), \tau), \quad \mathbf{y}(t) = \mathbf{x} .
#    \tag{13.2} $$
#
# Three flows are numbered. Flow 0 is a solid rotation with period 1. Flow 1 is a vortex:
# the rotation is slower at larger radii and becomes faster with time. Flow 2, on the square from
# $-1$ to $1$, deforms the field and then reverses: at the time 1 each particle is back where it
# started.


# %% tags=["setup"]
def velocity(y, t, flow):
    """Return a(y, t), of shape (M, 2), at points y (M, 2), in flow 0, 1 or 2."""
    y1, y2 = y.T
    if flow == 2:
        right = np.cos(np.pi * y1 / 2) ** 2 * np.sin(np.pi * y2)
        down = np.cos(np.pi * y2 / 2) ** 2 * np.sin(np.pi * y1)
        return 3 * np.cos(np.pi * t) * np.column_stack([right, -down])
    turns = (1 + t) / (1 + 4 * (y1**2 + y2**2)) if flow == 1 else 1
    return 2 * np.pi * np.column_stack([-turns * y2, turns * y1])


# %% [markdown]
# ## Departure points by Runge–Kutta schemes
#
# A departure point is computed by one step of a scheme for ordinary differential equations,
# *backward* in time. The simplest is Euler's scheme, a straight step with the velocity at
# $\mathbf{x}$ and $t$:
#
# $$ \mathbf{y} = \mathbf{x} - \Delta t\, \mathbf{a}(\mathbf{x}, t) . \tag{13.3} $$
#
# **Example.** In flow 0, let $\mathbf{x} = (1, 0)$ and $\Delta t = 1/8$. The velocity at
# $\mathbf{x}$ is $2\pi\,(0, 1)$, so Euler's foot is $(1, -\pi/4) \approx (1, -0.785)$. The exact
# foot is the point on the circle 45 degrees back, $(0.707, -0.707)$. Euler's foot lies outside the
# circle, at the radius 1.272.
#
# A better scheme goes half a step first and uses the velocity *there*, at the time $t - \Delta
# t/2$, for the whole step. This is the *midpoint rule* (13.4) below. In the example, the midpoint
# is $(1, -\pi/8)$. Its velocity is $2\pi\,(\pi/8, 1)$, so the foot is $(1 - \pi^2/32,\ -\pi/4)
# \approx (0.692, -0.785)$, at the radius 1.046. The next cell computes these numbers.

# %%
start, dt = np.array([[1.0, 0.0]]), 1 / 8
to_the_midpoint = dt / 2 * velocity(start, 0, 0)
for name, a in (
    ("Euler", velocity(start, 0, 0)),
    ("midpoint", velocity(start - to_the_midpoint, -dt / 2, 0)),
):
    foot = start - dt * a
    print(f"{name:10}", foot.round(3), "radius", np.hypot(*foot[0]).round(3))

# %% [markdown]
# ### 13.1 Euler's scheme
#
# Return the feet (13.3) of many points at once; use `velocity`.


# %% question="13.1" minutes=15
def euler(x, t, dt, flow):
    """Return the feet y (M, 2) of (13.3), at time t - dt, of points x (M, 2) at time t."""
    # BEGIN SOLUTION
    return x - dt * velocity(x, t, flow)
    # END SOLUTION


# %%
check("13.1")

# %% [markdown]
# The midpoint rule is
#
# $$ \mathbf{y} = \mathbf{x} - \Delta t\, \mathbf{a}\bigl(\mathbf{x} - \tfrac12 \Delta t\,
#    \mathbf{a}(\mathbf{x}, t),\; t - \tfrac12 \Delta t\bigr) . \tag{13.4} $$
#
# ### 13.2 The midpoint rule
#
# Return the feet (13.4) of many points at once.
#
# Before you run the check, predict: by which factor does the error of *one* step fall if $\Delta
# t$ is halved, for Euler's scheme and for the midpoint rule? (The order of a scheme is one less
# than the power of $\Delta t$ in the error of one step.)


# %% question="13.2" minutes=10
def midpoint(x, t, dt, flow):
    """Return the feet y (M, 2) of (13.4), at time t - dt, of points x (M, 2) at time t."""
    # BEGIN SOLUTION
    middle = x - dt / 2 * velocity(x, t, flow)
    return x - dt * velocity(middle, t - dt / 2, flow)
    # END SOLUTION


# %%
check("13.2")

# %% [markdown]
# For half the step the error of one step is about a quarter with Euler's scheme, and about an
# eighth with the midpoint rule: their orders are 1 and 2.
#
# The classical Runge–Kutta scheme of fourth order (RK4) uses four velocities,
#
# $$ \begin{aligned}
#    \mathbf{a}_1 &= \mathbf{a}(\mathbf{x},\ t), \\
#    \mathbf{a}_2 &= \mathbf{a}(\mathbf{x} - \tfrac12\Delta t\, \mathbf{a}_1,\ t - \tfrac12\Delta
#    t), \\
#    \mathbf{a}_3 &= \mathbf{a}(\mathbf{x} - \tfrac12\Delta t\, \mathbf{a}_2,\ t - \tfrac12\Delta
#    t), \\
#    \mathbf{a}_4 &= \mathbf{a}(\mathbf{x} - \Delta t\, \mathbf{a}_3,\ t - \Delta t), \\
#    \mathbf{y} &= \mathbf{x} - \tfrac16 \Delta t\, (\mathbf{a}_1 + 2\mathbf{a}_2 + 2\mathbf{a}_3 +
#    \mathbf{a}_4) .
#    \end{aligned} \tag{13.5} $$
#
# ### 13.3 The Runge–Kutta scheme RK4
#
# Return the feet (13.5) of many points at once.


# %% question="13.3" minutes=10
def rk4(x, t, dt, flow):
    """Return the feet y (M, 2) of (13.5), at time t - dt, of points x (M, 2) at time t."""
    # BEGIN SOLUTION
    a1 = velocity(x, t, flow)
    a2 = velocity(x - dt / 2 * a1, t - dt / 2, flow)
    a3 = velocity(x - dt / 2 * a2, t - dt / 2, flow)
    a4 = velocity(x - dt * a3, t - dt, flow)
    return x - dt / 6 * (a1 + 2 * a2 + 2 * a3 + a4)
    # END SOLUTION


# %%
check("13.3")

# %% [markdown]
# The picture shows your own eight points in the vortex, their exact paths back in time, and your
# departure points after *one* step of each scheme. The black rings are the exact departure points.
# Increase the step: which departure points leave their path first, and to which side?


# %%
@draw(dt=Slider(0.02, 0.5, 0.2, "step Δt", steps=24))
def three_feet(dt):
    x, t = data("13.1")[0], 0.5
    with figure(6.4, 3.6) as page:
        axes = page.subplots()
        paths = np.array([exact_feet(x, t, s) for s in np.linspace(0, dt, 40)])
        axes.plot(*paths.transpose(2, 0, 1), color=GREY, lw=1)
        axes.plot(*x.T, ".", color="black", ms=4, label="points now")
        axes.plot(*paths[-1].T, "o", mfc="none", color="black", ms=11, label="exact feet")
        looks = zip((euler, midpoint, rk4), (ORANGE, PURPLE, BLUE), "^so")
        for scheme, color, marker in looks:
            axes.plot(*scheme(x, t, dt, 1).T, marker, color=color, ms=5, label=scheme.__name__)
        axes.set(aspect="equal", xlim=(-1.7, 1.7), ylim=(-1.7, 1.7))
        axes.axis("off")
        axes.legend(loc="center left", bbox_to_anchor=(1, 0.5))
    return page


# %% [markdown]
# The next picture shows the error over a fixed time, when particles are traced from the time 1 to
# the time 0 in more and more steps. The numbers are the slopes between the two marks of the
# shortest steps: the *orders* of the schemes. They should be near 1, 2 and 4.


# %%
@draw()
def orders():
    x = scattered_in_disc(40)
    true = exact_feet(x, 1.0, 1.0)
    counts = 2 ** np.arange(3, 10)
    with figure(6.4, 2.9) as page:
        axes = page.subplots()
        looks = zip((euler, midpoint, rk4), (ORANGE, PURPLE, BLUE), "^so")
        for scheme, color, marker in looks:
            errors = []
            for count in counts:
                y = x
                for n in range(count):
                    y = scheme(y, 1 - n / count, 1 / count, 1)
                errors.append(np.sqrt(np.mean((y - true) ** 2)))
            slope = np.log2(errors[-2] / errors[-1])
            axes.loglog(
                1 / counts,
                errors,
                marker + "-",
                color=color,
                label=f"{scheme.__name__}, {slope:.2f}",
            )
        axes.set(xlabel=r"step $\Delta t$", ylabel="error of the departure points")
        axes.grid(alpha=0.3)
        axes.legend(loc="center left", bbox_to_anchor=(1, 0.5))
    return page


# %% [markdown]
# **13.4** Some schemes on a grid compute a new value from the values at direct neighbours. They
# must satisfy the *CFL condition* $\lvert\mathbf{a}\rvert\, \Delta t / h \le 1$, with the spacing
# $h$; the left side is the *CFL number*. Explain by the characteristics why such a scheme needs
# this condition and why (13.2) does not. You may quote that $u$ is constant along them.
#
# <details><summary>Hint</summary>
#
# Which point determines the new value, and which values does each scheme use?
#
# </details>

# %% [markdown] answer="13.4" points=3 minutes=10 words=60
# Along a characteristic $u$ is constant, so the new value is the old one at the departure point. If
# this point lies beyond the direct neighbours, their values do not determine the field there.
# (13.2) evaluates the field *at* the departure point, however far away it is.
#
# *Beyond the question.* By the chain rule $\frac{d}{d\tau} u(\mathbf{y}(\tau), \tau) = u_t +
# \dot{\mathbf{y}} \cdot \nabla u = u_t + \mathbf{a}\cdot\nabla u = 0$, so $u$ is constant along a
# characteristic. In (13.2) only the departure point itself must be accurate. So the step is
# limited by the change of the velocity along the path, $\Delta t\, \lVert\nabla\mathbf{a}\rVert$,
# and not by the spacing of the sites.

# %% [markdown] rubric="13.4"
# One point: the new value is the old one at the departure point, since $u$ is constant along the
# characteristic. The chain rule is not required. One: the direct
# neighbours do not determine the value at a departure point that is farther away. One: (13.2) uses
# the departure point at any distance.

# %% [markdown]
# ## One step as a matrix
#
# Let $\mathbf{x}_1, \dots, \mathbf{x}_N$ be scattered sites, $\mathbf{u}^n$ the values at the time
# $t_n$, and $\mathbf{y}_i$ the departure point of $\mathbf{x}_i$ for the step to $t_{n+1}$. Let
# $s_{\mathbf{u}}$ be a field that is reconstructed from the values. Then $u_i^{n+1} =
# s_{\mathbf{u}^n}(\mathbf{y}_i)$. If the reconstruction is linear in the values,
#
# $$ \mathbf{u}^{n+1} = \mathbf{H}\, \mathbf{u}^n , \tag{13.6} $$
#
# and row $i$ of $\mathbf{H}$ contains the weights of the sites for the point $\mathbf{y}_i$. We
# use radial basis functions with the kernel $r^3$ on the $k$ sites nearest to $\mathbf{y}_i$, in
# any dimension $D$. (See Behrens and Iske, *Computers & Mathematics with Applications* 43, 2002,
# pages 319–327.) Call these sites $\mathbf{z}_1, \dots, \mathbf{z}_k$. Their weights are the first
# $k$ entries of $\mathbf{w}$ in
#
# $$ \begin{bmatrix} \boldsymbol{\Phi} & \mathbf{P} \\ \mathbf{P}^T & \mathbf{0} \end{bmatrix}
#    \mathbf{w} =
#    \bigl(\lVert \mathbf{y} - \mathbf{z}_1 \rVert^3, \dots, \lVert \mathbf{y} - \mathbf{z}_k
#    \rVert^3, 1, \mathbf{y}^T\bigr)^T, \tag{13.7} $$
#
# with $\Phi_{ab} = \lVert \mathbf{z}_a - \mathbf{z}_b \rVert^3$ and the rows $(1, \mathbf{z}_a^T)$
# of $\mathbf{P}$. All other weights are zero. You know the matrix of (13.7) from notebook 12, so it
# is written for you. `distances(x, points)` is ready-made, too: for `x` of shape (M, D) and
# `points` of shape (N, D) it returns all distances, of shape (M, N).


# %% tags=["setup"]
def system(z):
    """Return the matrix of (13.7), of shape (k + D + 1, k + D + 1), for sites z (k, D)."""
    linear = np.insert(z, 0, 1, axis=1)
    return saddle_point_matrix(distances(z, z) ** 3, linear)


# %% [markdown]
# **Example.** Sites on a line at 0, 1 and 2, a departure point at $y = 1/2$, and $k = 3$. The
# weights are $\frac1{32}(13, 22, -3)$; the system is written out in notebook 12. They sum to 1,
# and their mean of the sites is $(22 - 6)/32 = 1/2$. The values $\mathbf{u} = (0, 1, 0)$ give the
# new value $22/32$. The values $(1, 0, 1)$ give $10/32$. With the values $(0, 0, 1)$ the new value
# is $-3/32$, which is less than all old values.
#
# The next function is finished. It is the crudest semi-Lagrangian step: the new value is the value
# of the site nearest to the departure point.


# %%
def nearest_values(sites, u, feet):
    """Return the values u (N,) of the sites (N, D) nearest to the feet (M, D), of shape (M,)."""
    new = np.zeros(len(feet))
    for m, foot in enumerate(feet):
        squares = ((sites - foot) ** 2).sum(axis=1)
        new[m] = u[squares.argmin()]
    return new


three = np.array([[0.0], [1.0], [2.0]])
print(nearest_values(three, np.array([0.0, 1.0, 0.0]), np.array([[0.4], [0.6]])))
print(32 * np.linalg.solve(system(three), [1 / 8, 1 / 8, 27 / 8, 1, 1 / 2])[:3])

# %% [markdown]
# ### 13.5 The matrix of a step
#
# Return $\mathbf{H}$: row $i$ has the weights (13.7) of the $k$ sites nearest to foot $i$, and
# zeros elsewhere. Here $D + 1 \le k \le N$, and the $k$ sites determine a linear polynomial: in the
# plane they are not on one line. No two distances are equal where it matters which site is nearer.
# Distances may be of any size, and the sites may be far from the origin; the weights do not change
# if the foot is made the origin.
#
# <details><summary>Hint</summary>
#
# Begin with a matrix of zeros and fill one row after the other. `np.argsort` of the distances
# gives the nearest sites first. An array of column numbers may be used as an index on the left of
# `=`.
#
# </details>


# %% question="13.5" minutes=20
def step_matrix(sites, feet, k):
    """Return H of (13.6), of shape (M, N), for sites (N, D), feet (M, D) and k nearest sites."""
    # BEGIN SOLUTION
    H = np.zeros((len(feet), len(sites)))
    for i, y in enumerate(feet):
        r = np.linalg.norm(sites - y, axis=1)
        near = np.argsort(r)[:k]
        b = np.concatenate([r[near] ** 3, [1], np.zeros_like(y)])  # the foot is the origin
        H[i, near] = np.linalg.solve(system(sites[near] - y), b)[:k]
    return H
    # END SOLUTION


# %%
check("13.5")

# %% [markdown]
# ### 13.6 Many steps
#
# Begin at the time 0 and make steps of length $\Delta t$. The departure points, by your `rk4`,
# belong to the sites at the time of *arrival*, $t_{n+1} = (n + 1)\Delta t$. If the velocity
# depends on time, departure points and $\mathbf{H}$ must be computed again in each step. Without
# steps (`steps` = 0) the only row is $\mathbf{u}$.


# %% question="13.6" minutes=15
def advect(sites, u, dt, steps, flow, k):
    """Return u^0, …, u^steps of (13.6), of shape (steps + 1, N).

    u (N,) holds the values at the time 0 at the sites (N, 2).
    """
    # BEGIN SOLUTION
    fields = [u]
    for n in range(steps):
        feet = rk4(sites, (n + 1) * dt, dt, flow)
        fields.append(step_matrix(sites, feet, k) @ fields[-1])
    return np.array(fields)
    # END SOLUTION


# %%
check("13.6")

# %% [markdown]
# ## Solid rotation with large CFL numbers
#
# A slotted disc and a hill, on 400 sites, make one solid rotation. The exact result is the initial
# field. Begin with few steps, then take many. Orange is negative, white is zero.


# %%
def slotted(x):
    """Return 1 in a disc with a slot and 0 elsewhere, plus a hill beside the disc."""
    inside = np.hypot(x[:, 0], x[:, 1] - 0.45) < 0.38
    slot = (np.abs(x[:, 0]) < 0.09) & (x[:, 1] < 0.55)
    beside = x + [0.75, 0.5]
    return np.where(inside & ~slot, 1.0, hill(beside, 25))


LEVELS = np.linspace(-1.3, 1.3, 14)


def show_field(axes, sites, u, title):
    """Draw filled contours at odd tenths, and return them: negative is orange, zero is white."""
    axes.set(aspect="equal", title=title)
    axes.axis("off")
    return axes.tricontourf(*sites.T, u, LEVELS, cmap="PuOr", extend="both")


@draw(
    steps=Slider(3, 60, 12, "steps in one rotation", whole=True),
    k=Slider(6, 40, 21, "nearest sites k", whole=True),
)
def once_round(steps, k):
    sites = scattered_in_disc(400)
    u = slotted(sites)
    H = np.asarray(step_matrix(sites, rk4(sites, 0, 1 / steps, 0), k))
    end = np.linalg.matrix_power(H, steps) @ u
    spacing = np.sqrt(np.pi / len(sites))
    with figure(6.4, 3.2) as page:
        left, right = page.subplots(1, 2)
        show_field(left, sites, u, "initial field")
        shown = show_field(right, sites, end, "after one rotation")
        page.colorbar(shown, ax=right, shrink=0.8)
        off = np.sqrt(np.mean((end - u) ** 2))
        cfl = 2 * np.pi / steps / spacing
        page.suptitle(f"CFL number {cfl:.1f} at the radius 1; root-mean-square error {off:.3f}")
    return page


# %% [markdown]
# **What to look at.** With ten steps the CFL number at the radius 1 is about 7: the particles pass
# seven sites per step, and the method remains stable. The edge of the slotted disc, which the
# sites do not resolve, is blurred. Near it values leave the range from 0 to 1. With three to five
# steps the method is stable too, but the departure points of `rk4` have large errors: the disc is
# in a wrong place, or enlarged.
#
# ## The best number of steps
#
# A smooth hill alone makes one rotation. The picture shows the error after one rotation against
# the number of steps, for your three schemes. (It takes some seconds.)


# %%
@draw(sites=Slider(150, 600, 350, "sites", steps=9))
def how_many_steps(sites):
    sites = scattered_in_disc(round(sites))
    u, counts = hill(sites), np.array([4, 6, 9, 13, 20, 30, 45])
    with figure(6.4, 3.0) as page:
        axes = page.subplots()
        looks = zip((euler, midpoint, rk4), (ORANGE, PURPLE, BLUE), "^so")
        for scheme, color, marker in looks:
            errors = []
            for count in counts:
                H = step_matrix(sites, scheme(sites, 0, 1 / count, 0), 21)
                end = np.linalg.matrix_power(H, int(count)) @ u
                errors.append(np.sqrt(np.mean((end - u) ** 2)))
            axes.loglog(
                counts, np.clip(errors, 0, 9), marker + "-", color=color, label=scheme.__name__
            )
        axes.set(xlabel="steps in one rotation", ylabel="error", ylim=(5e-4, 10))
        axes.set_xticks(counts, counts)
        axes.minorticks_off()
        axes.grid(alpha=0.3)
        axes.legend(loc="center left", bbox_to_anchor=(1, 0.5))
    return page


# %% [markdown]
# **13.7** The error of `rk4` first falls with the number of steps and then rises. There are two
# error terms: $C_1 \Delta t^{p}$ for the departure points after the whole time $T$, and $C_2 h^q$
# for *one* reconstruction, with the spacing $h$ of the sites. Derive how the best $\Delta t$
# depends on $h$.
#
# <details><summary>Hint</summary>
#
# How many reconstructions are there in the time $T$?
#
# </details>

# %% [markdown] answer="13.7" points=3 minutes=15 words=50
# There are $T/\Delta t$ steps, each with one reconstruction, so the whole error is about $C_1\Delta
# t^p + (T/\Delta t)\, C_2 h^q$. With more steps the first term falls and the second grows. The
# derivative vanishes at $p\, C_1 \Delta t^{p+1} = T C_2 h^q$, so the best step is proportional to
# $h^{q/(p+1)}$.
#
# *Beyond the question.* Every reconstruction smooths the field a little. With finer sites the best
# number of steps is larger. The error of Euler's scheme falls throughout, since its first term
# dominates.

# %% [markdown] rubric="13.7"
# One point: the number of steps is a factor of the second term. One: the first term falls and the
# second grows. One for the best step as a power of $h$; "smaller for a smaller $h$", with the
# reason, earns half.

# %% [markdown]
# ## Bounds: a quasi-monotone scheme
#
# Advection does not create new extreme values. The new value should lie between the old values
# near the departure point:
#
# $$ u_i^{\min} = \min_{j \in \mathcal{N}_i} u_j^n, \qquad u_i^{\max} = \max_{j \in \mathcal{N}_i}
#    u_j^n , \tag{13.8} $$
#
# with $\mathcal{N}_i$ the four sites nearest to the departure point $\mathbf{y}_i$. Then
# `np.clip(new, low, high)` restricts the new values to their bounds. Such a scheme is called
# *quasi-monotone* (Bermejo and Staniforth, *Monthly Weather Review* 120, 1992, pages 2622–2632).
#
# **Example.** For the sites $(0, 0)$, $(1, 0)$, $(2, 0)$, $(3, 0)$ with the values 0, 0, 1, 0 and
# any departure point, all four sites are nearest: $u^{\min} = 0$ and $u^{\max} = 1$.
#
# ### 13.8 The bounds
#
# Return both bounds of (13.8): `return low, high`. There are at least four sites, and no two
# distances are equal where it matters which site is nearer. The sites may be far from the origin,
# and their distances of any size.


# %% question="13.8" minutes=10
def bounds(sites, u, feet):
    """Return both bounds (13.8), (M,) each, for sites (N, 2), old values u (N,), feet (M, 2)."""
    # BEGIN SOLUTION
    r = np.linalg.norm(feet[:, None] - sites, axis=2)
    around = u[np.argsort(r)[:, :4]]
    return around.min(axis=1), around.max(axis=1)
    # END SOLUTION


# %%
check("13.8")

# %% [markdown]
# ## Conservation of mass
#
# If the flow is divergence-free and nothing enters, the integral of $u$ is constant. Let $m_j > 0$
# be the area of site $j$, and $\mu$ the required mass, that of the initial field. Let $\tilde u_j$
# be the new values, and $u_j^{\min} \le u_j^{\max}$ their bounds. Among all values within these
# bounds that have this mass, we take those nearest to the new values in the mean square with the
# weights $m_j$. They are
#
# $$ v_j = \min\bigl(\max(\tilde u_j + \lambda,\ u_j^{\min}),\ u_j^{\max}\bigr), \qquad
#    \sum_j m_j v_j = \mu , \tag{13.9} $$
#
# with one number $\lambda$ for all sites (compare Bermejo and Conde, *Monthly Weather Review* 130,
# 2002, pages 423–430). The mass is a nondecreasing, piecewise linear function of $\lambda$.
#
# **Example.** Two sites with $m_1 = m_2 = 1$, the new values $(0, 1)$, the lower bounds $(0, 0)$,
# the upper bounds $(1, 1.2)$, and $\mu = 1.6$. The mass must grow by 0.6. With $\lambda = 0.2$ the
# second value reaches its bound 1.2, and the mass is 1.4. Then only the first value grows, so
# $\lambda = 0.4$ and $\mathbf{v} = (0.4, 1.2)$.
#
# ### 13.9 Correction of the mass
#
# Return $\mathbf{v}$ of (13.9); the argument `new` is $\tilde{\mathbf{u}}$, and `total` is $\mu$.
# Some new values may lie outside their bounds. Values and areas may be of any size.
#
# <details><summary>Hint</summary>
#
# There are two ways. Bisection: $\lambda$ lies between $\min_j (u_j^{\min} - \tilde u_j)$ and
# $\max_j (u_j^{\max} - \tilde u_j)$; halve this interval until its midpoint is one of its ends. Or
# exactly: at which $\lambda$ does the slope of the mass change? Compute the masses there, and use
# `np.interp`.
#
# </details>


# %% question="13.9" minutes=15
def with_mass(new, low, high, m, total):
    """Return v of (13.9), of shape (N,), for new values, bounds low and high, areas m, all (N,).

    total is the required mass, between the masses of the bounds.
    """
    # BEGIN SOLUTION
    corners = np.sort(np.concatenate([low - new, high - new]))
    masses = [m @ np.clip(new + c, low, high) for c in corners]
    shift = np.interp(total, masses, corners)
    return np.clip(new + shift, low, high)
    # END SOLUTION


# %%
check("13.9")


# %% [markdown]
# The slotted disc again, on 500 sites and in 24 steps: without correction, with bounds, and with
# bounds and mass.


# %%
def rotate_with(sites, u, H, feet, bounded, massive):
    """Return the fields of one rotation in 24 steps, with bounds and mass corrected if wanted."""
    m = np.full(len(sites), np.pi / len(sites))
    fields = [u]
    for _ in range(24):
        low, high = bounds(sites, fields[-1], feet)
        new = H @ fields[-1]
        if bounded:
            new = np.clip(new, low, high)
        if massive:
            new = with_mass(new, low, high, m, m @ u)
        fields.append(new)
    return np.array(fields)


@draw()
def bounds_and_mass():
    sites = scattered_in_disc(500)
    u = slotted(sites)
    feet = np.asarray(rk4(sites, 0, 1 / 24, 0))
    H = np.asarray(step_matrix(sites, feet, 21))
    ways = {
        "no correction": (False, False),
        "bounds": (True, False),
        "bounds and mass": (True, True),
    }
    with figure(6.4, 5.0) as page:
        above, below = page.subfigures(2, 1)
        pictures, (left, right) = above.subplots(1, 3), below.subplots(1, 2)
        looks = zip(pictures, ways.items(), (ORANGE, PURPLE, BLUE), (1.5, 4, 1.5))
        for axes, (name, kept), color, width in looks:
            fields = rotate_with(sites, u, H, feet, *kept)
            shown = show_field(axes, sites, fields[-1], name)
            left.plot(fields.max(axis=1), color=color, lw=width, label=name)
            left.plot(fields.min(axis=1), color=color, lw=width)
            right.plot(fields.sum(axis=1) / u.sum(), color=color, lw=width)
        above.colorbar(shown, ax=pictures, shrink=0.8)
        left.set(xlabel="step", ylabel="minimum and maximum")
        right.set(xlabel="step", ylabel="mass / initial mass")
        below.legend(*left.get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return page


# %% [markdown]
# **What to look at.** Without correction, values leave the range from 0 to 1 at once, and the mass
# varies by one or two per cent. Bounds correct the range (the thin blue lines on the left lie on
# the thick purple ones). The correction of the mass changes the field hardly visibly. The bounds
# have a price: compare the height of the hill in the three pictures.
#
# **13.10** Let $\mu$ lie between $\sum_j m_j u_j^{\min}$ and $\sum_j m_j u_j^{\max}$. Show that
# (13.9) determines exactly one field $\mathbf{v}$, even where several $\lambda$ are possible.
#
# <details><summary>Hint</summary>
#
# Regard $v_j$ as a function of $\lambda$. Can one $v_j$ fall while another one rises?
#
# </details>

# %% [markdown] answer="13.10" points=3 minutes=10 words=60
# Each $v_j$ is a continuous, nondecreasing function of $\lambda$, and so is the mass. For small
# $\lambda$ all $v_j$ are their lower bounds, for large $\lambda$ the upper ones. So every mass
# between is reached. Two $\lambda$ with one mass give one field: no $v_j$ is smaller for the larger
# $\lambda$, and the $m_j$ are positive.
#
# *Beyond the question.* A step without a correction conserves the mass of *every* field exactly if
# $\mathbf{m}^T\mathbf{H} = \mathbf{m}^T$, a condition on columns. The reason is that the mass after
# a step is $\mathbf{m}^T\mathbf{H}\mathbf{u}$. (13.7) guarantees only $\mathbf{H}\mathbf{1} =
# \mathbf{1}$, a condition on rows: the polynomial reproduces constants.

# %% [markdown] rubric="13.10"
# One point: the mass is a continuous, nondecreasing function of $\lambda$. One: it takes both
# extreme values, hence all between. One: the field is unique, since no $v_j$ can change while the
# mass stays the same.

# %% [markdown]
# ## A deformation flow that reverses
#
# Flow 2 stretches a hill to a crescent until the time 1/2, and then reverses (a test of LeVeque,
# *SIAM Journal on Numerical Analysis* 33, 1996, pages 627–665). Your `advect` computes it on 400
# sites of the square, in two equal halves. The departure points and the matrix are computed again
# in each step.


# %%
@draw(half=Slider(2, 12, 5, "steps in each half", whole=True))
def out_and_back(half):
    random = np.random.default_rng(3)
    cells = np.indices((20, 20)).reshape(2, -1).T
    sites = (cells + random.uniform(0.2, 0.8, cells.shape)) / 10 - 1
    u = hill(sites[:, ::-1], 12)
    fields = np.asarray(advect(sites, u, 0.5 / half, 2 * half, 2, 21))
    with figure(6.4, 2.6) as page:
        panels = page.subplots(1, 3)
        for axes, n, title in zip(
            panels, (0, half, 2 * half), ("initial field", "time 1/2", "time 1")
        ):
            shown = show_field(axes, sites, fields[n], title)
        page.colorbar(shown, ax=panels, shrink=0.8)
        off = np.sqrt(np.mean((fields[-1] - u) ** 2))
        page.suptitle(f"{2 * half} steps, root-mean-square error {off:.3f}")
    return page


# %% [markdown]
# ## Burgers' equation
#
# In Burgers' equation $u_t + u\, u_x = 0$ the velocity itself is the transported quantity. A
# particle on the line keeps its velocity $u$, so its path is straight. The departure point of $x$
# is the solution $y$ of a fixed-point equation, found by iteration:
#
# $$ y = x - \Delta t\; s_{\mathbf{u}}(y), \qquad y^0 = x, \quad y^{\nu+1} = x - \Delta t\;
#    s_{\mathbf{u}}(y^\nu), \tag{13.10} $$
#
# where $s_{\mathbf{u}}$ is the field through the values at the sites, by your `step_matrix`.
#
# **Example.** Let $s(y) = y$, $x = 1$ and $\Delta t = 1/2$. The iteration gives $y^1 = 1/2$, $y^2
# = 3/4$, $y^3 = 5/8$, and converges to the solution $y = 2/3$ of $y = 1 - y/2$.
#
# ### 13.11 Departure points for Burgers' equation
#
# Return the feet after the given number of rounds of (13.10). Without rounds (`rounds` = 0) they
# are the sites. The sites may be in any order.


# %% question="13.11" minutes=15 optional
def burgers_feet(sites, u, dt, rounds, k):
    """Return y^rounds of (13.10), of shape (N, 1), for sites (N, 1) and values u (N,)."""
    # BEGIN SOLUTION
    y = sites
    for _ in range(rounds):
        y = sites - dt * (step_matrix(sites, y, k) @ u)[:, None]
    return y
    # END SOLUTION


# %%
check("13.11")

# %% [markdown]
# The picture shows a single step, of any length, from a smooth wave. The grey curve is exact: each
# point of the initial wave is moved by $\Delta t$ times its own height. At $\Delta t = 1$, in the
# units of the slider, the wave breaks.


# %%
@draw(dt=Slider(0, 1.6, 0.8, "step / breaking time", steps=32))
def one_step_of_a_wave(dt):
    x = np.linspace(-1, 1, 61)[:, None]
    u = 0.2 + np.exp(-6 * x[:, 0] ** 2)
    breaking = 1 / (np.sqrt(12) * np.exp(-0.5))
    feet = np.asarray(burgers_feet(x, u, dt * breaking, 60, 8))
    new = step_matrix(x, feet, 8) @ u
    fine = np.linspace(-1.2, 1, 400)
    wave = 0.2 + np.exp(-6 * fine**2)
    with figure(6.4, 2.9) as page:
        axes = page.subplots()
        axes.plot(x, u, ":", color=GREY, label="initial wave")
        axes.plot(fine + dt * breaking * wave, wave, color=GREY, lw=4, alpha=0.5, label="exact")
        axes.plot(x, np.clip(new, -1, 3), ".-", color=BLUE, ms=4, lw=1, label="your single step")
        axes.set(xlabel="$x$", ylabel="$u$", xlim=(-1, 1), ylim=(0, 1.5))
        axes.legend(loc="center left", bbox_to_anchor=(1, 0.5))
    return page


# %% [markdown]
# **What to look at.** Up to about 0.9 breaking times the blue points are on the grey curve. From
# the breaking time on they are also off it where it is smooth, on the rising flank between $x = 0$
# and 0.2, and at 1.4 to 1.6 they form a zigzag: there the iteration (13.10) does not converge.
# 13.12 asks when it does.
#
# **13.12** Let all sites be neighbours, $k = N$, so that $s_{\mathbf{u}}$ is smooth. Derive a bound
# on $\Delta t$ below which the iteration (13.10) surely converges.
#
# <details><summary>Hint</summary>
#
# Subtract two successive iterates. How large is the difference of $s$ at two points at most?
#
# </details>

# %% [markdown] answer="13.12" points=2 minutes=10 words=40 optional
# The difference of two successive iterates is $-\Delta t\,(s(y^\nu) - s(y^{\nu-1}))$, at most
# $\Delta t \max\lvert s'\rvert$ times the one before. If this factor is less than 1, the
# differences fall as its powers, and the iteration converges: for $\Delta t < 1/\max\lvert
# s'\rvert$.
#
# *Beyond the question.* The iteration is a contraction. The bound is at most the time $t^* =
# 1/\max(-u_x)$ at which the wave breaks, and equal to it if the velocity falls more steeply than it
# rises. The particle from $x_0$ is at $x_0 + t\,u(x_0)$. The derivative $1 + t\,u_x$ of this map
# first vanishes at $t^*$; afterwards some points have several departure points, and the equation
# for $y$ has several solutions. Before, paths are straight, so there is no error in time at all.
# The iteration can also fail where the velocity rises as steeply, although there is only one
# solution.

# %% [markdown] rubric="13.12"
# One point for the factor $\Delta t\,\max\lvert u_x\rvert$ between successive differences. One for
# the conclusion: the iteration converges if the factor is less than 1.

# %% [markdown]
# ## Dig deeper
#
# - Stability over many rotations depends on the powers of $\mathbf{H}$. Compute its eigenvalues
#   for flow 0 on sites in the disc, with $k = 21$ and with all sites. Which modulus is above 1?
#   After how many rotations is the growth visible?
# - Use sites in a square and flow 0: at the corners the departure points lie outside. What does
#   (13.7) compute there, and which boundary values does the equation need at such an inflow?
# - Which condition on $\mathbf{H}$ would conserve the mass of *every* field without (13.9)? Why
#   does (13.7) not satisfy it in general? Write the mass as $\mathbf{m}^T\mathbf{H}\mathbf{u}$.
# - Why is an affine field transported by flow 0 without any error of reconstruction?
# - Move the sites with the flow (a *Lagrangian* method): each site of the next step is the
#   position to which the flow moves a site. What remains of the error after one rotation? When are
#   new sites needed?
# - Wendland (*Scattered Data Approximation*, 2005, page 7) calls each curve along which $u$ is
#   constant a characteristic. Find a counterexample with $\mathbf{a} = (1, 0)$.
# - If the velocity is known at sites only, it must be reconstructed in each stage of (13.5). Which
#   order do the departure points have then?

# %%
progress()
