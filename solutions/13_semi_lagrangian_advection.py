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
# # Fields that move with the flow
#
# Smoke in the wind, salt in the sea: what is carried along changes its place and not its value. So
# the value here and now is the value a moment ago at the place from which the particle came. That
# place is hardly ever one at which the value is known, and finding the value there is what field
# reconstruction is for.
#
# By the end of this notebook you have written the whole method for points without any mesh: feet of
# characteristics by three schemes, a step as a matrix, bounds and mass that are kept, and a flow
# that carries itself. You know why a step may be much longer than the way to the next point, and
# why the shortest steps are not the best.
#
# There are eight short functions and four questions in words. You need nothing from other
# notebooks. Numbers in brackets, such as (13.1), are those of formulas; numbers without are those
# of questions.

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
# A vortex carries a hill. Values are known at the dots. The orange dot on the right asks for the
# value now; a step $\Delta t$ ago its particle was at the orange cross on the left, and there is no
# dot.


# %%
def scattered_in_disc(n, seed=1):
    """Return n scattered places in the unit disc."""
    random = np.random.default_rng(seed)
    angle = np.pi * (1 + np.sqrt(5)) * np.arange(n)
    radius = np.sqrt((np.arange(n) + 0.5) / n)
    places = radius[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])
    places += random.uniform(-0.3, 0.3, (n, 2)) / np.sqrt(n)
    return places / np.maximum(1, np.hypot(*places.T))[:, None]


def exact_feet(x, t, dt):
    """Return where the vortex below had the places x (M, 2) of time t at the time t - dt."""
    angle = np.pi * ((1 + t) ** 2 - (1 + t - dt) ** 2) / (1 + 4 * (x**2).sum(axis=1))
    z = (x[:, 0] + 1j * x[:, 1]) * np.exp(-1j * angle)
    return np.column_stack([z.real, z.imag])


def hill(x, sharpness=14):
    """Return a hill with its top at (0.45, 0)."""
    return np.exp(-sharpness * ((x[:, 0] - 0.45) ** 2 + x[:, 1] ** 2))


@draw(dt=Slider(0.02, 0.5, 0.25, "step Δt", steps=24))
def the_problem(dt):
    sites, t = scattered_in_disc(120), 0.6
    side = np.linspace(-1, 1, 81)
    grid = np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2)
    asked = sites[np.argmin(((sites - [-0.25, 0.5]) ** 2).sum(axis=1))][None]
    path = np.vstack([exact_feet(asked, t, s) for s in np.linspace(0, dt, 30)])
    with figure(6.4, 3.2) as page:
        panels = page.subplots(1, 2)
        for axes, time, place, mark in zip(panels, (t - dt, t), path[[-1, 0]], "Xo"):
            values = hill(exact_feet(grid, time, time)).reshape(81, 81)
            axes.contourf(side, side, values, np.linspace(0.1, 1, 10), cmap="Blues")
            axes.plot(*sites.T, ".", color=GREY, ms=3)
            axes.plot(*path.T, ":", color=ORANGE)
            axes.plot(*place, mark, color=ORANGE, ms=9)
            axes.set(aspect="equal", xlim=(-1.05, 1.05), ylim=(-1.05, 1.05))
            axes.axis("off")
        panels[0].set_title("a step ago")
        panels[1].set_title("now")
    return page


# %% [markdown]
# ## The idea
#
# Let $\mathbf{a}(\mathbf{y}, t)$ be the velocity of the flow. A field $u$ that is carried along
# obeys
#
# $$ \frac{\partial u}{\partial t} + \mathbf{a} \cdot \nabla u = 0 . \tag{13.1} $$
#
# The path of a particle, $\dot{\mathbf{y}} = \mathbf{a}(\mathbf{y}, \tau)$, is called
# a *characteristic*, and along it nothing changes. Follow the one through $\mathbf{x}$ at the time
# $t$ back for a while $\Delta t$, to its *foot*:
#
# $$ u(\mathbf{x}, t) = u\bigl(\mathbf{y}(t - \Delta t),\, t - \Delta t\bigr), \qquad
#    \dot{\mathbf{y}}(\tau) = \mathbf{a}(\mathbf{y}(\tau), \tau), \quad \mathbf{y}(t) = \mathbf{x} .
#    \tag{13.2} $$
#
# Three flows are given, by number. Number 0 turns as a whole, once in the time one. Number 1 is a
# vortex, slower outside, that gets faster with time. Number 2, on the square from $-1$ to $1$,
# stretches what it carries, and reverses: at the time one all is back.


# %% tags=["setup"]
def velocity(y, t, flow):
    """Return a(y, t), of shape (M, 2), at places y (M, 2), in the flow number 0, 1 or 2."""
    y1, y2 = y.T
    if flow == 2:
        right = np.cos(np.pi * y1 / 2) ** 2 * np.sin(np.pi * y2)
        down = np.cos(np.pi * y2 / 2) ** 2 * np.sin(np.pi * y1)
        return 3 * np.cos(np.pi * t) * np.column_stack([right, -down])
    turns = (1 + t) / (1 + 4 * (y1**2 + y2**2)) if flow == 1 else 1
    return 2 * np.pi * np.column_stack([-turns * y2, turns * y1])


# %% [markdown]
# ## Feet
#
# The foot is found by one step of a scheme for ordinary differential equations, *backward* in time.
# The simplest is Euler's: go straight back with the velocity of here and now,
#
# $$ \mathbf{y} = \mathbf{x} - \Delta t\, \mathbf{a}(\mathbf{x}, t) . \tag{13.3} $$
#
# ### 13.1 Euler


# %% question="13.1"
def euler(x, t, dt, flow):
    """Return the feet y of (13.3), of shape (M, 2), at time t - dt of places x (M, 2) at time t."""
    # BEGIN SOLUTION
    return x - dt * velocity(x, t, flow)
    # END SOLUTION


# %%
check("13.1")

# %% [markdown]
# Better: go half-way, and take the velocity of that place *at that time* for the whole step,
#
# $$ \mathbf{y} = \mathbf{x} - \Delta t\, \mathbf{a}\bigl(\mathbf{x} - \tfrac12 \Delta t\,
#    \mathbf{a}(\mathbf{x}, t),\; t - \tfrac12 \Delta t\bigr) . \tag{13.4} $$
#
# ### 13.2 The midpoint rule


# %% question="13.2"
def midpoint(x, t, dt, flow):
    """Return the feet y of (13.4), of shape (M, 2), at time t - dt of places x (M, 2) at time t."""
    # BEGIN SOLUTION
    middle = x - dt / 2 * velocity(x, t, flow)
    return x - dt * velocity(middle, t - dt / 2, flow)
    # END SOLUTION


# %%
check("13.2")

# %% [markdown]
# The classical scheme of Runge and Kutta looks at four velocities,
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
# ### 13.3 Runge and Kutta


# %% question="13.3"
def rk4(x, t, dt, flow):
    """Return the feet y of (13.5), of shape (M, 2), at time t - dt of places x (M, 2) at time t."""
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
# Your own eight places in the vortex, their true paths back in time, and your three kinds of feet
# after *one* step. The black rings are where the particles were. Lengthen the step: which feet
# leave their path first, and to which side?


# %%
@draw(dt=Slider(0.02, 0.5, 0.2, "step Δt", steps=24))
def three_feet(dt):
    x, t = data("13.1")[0], 0.5
    with figure(6.4, 3.6) as page:
        axes = page.subplots()
        paths = np.array([exact_feet(x, t, s) for s in np.linspace(0, dt, 40)])
        axes.plot(*paths.transpose(2, 0, 1), color=GREY, lw=1)
        axes.plot(*x.T, ".", color="black", ms=4, label="places now")
        axes.plot(*paths[-1].T, "o", mfc="none", color="black", ms=11, label="true feet")
        looks = zip((euler, midpoint, rk4), (ORANGE, PURPLE, BLUE), "^so")
        for scheme, color, marker in looks:
            axes.plot(*scheme(x, t, dt, 1).T, marker, color=color, ms=5, label=scheme.__name__)
        axes.set(aspect="equal", xlim=(-1.5, 1.5), ylim=(-1.25, 1.25))
        axes.axis("off")
        axes.legend(loc="center left", bbox_to_anchor=(1, 0.5))
    return page


# %% [markdown]
# How fast the errors fall is the *order*. Below, particles are traced from the time one to the time
# zero in more and more steps. The numbers are the slopes between the last two marks.


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
        axes.set(xlabel=r"step $\Delta t$", ylabel="error of the feet")
        axes.grid(alpha=0.3)
        axes.legend(loc="center left", bbox_to_anchor=(1, 0.5))
    return page


# %% [markdown]
# **13.4** (a) Prove: if $u$ obeys (13.1), then $u$ is constant along characteristics. (b) Is
# every curve along which $u$ is constant a characteristic? Find a counterexample. (c) A scheme that
# computes the new value at a point of a grid from those of its direct neighbours needs
# $\lvert\mathbf{a}\rvert\, \Delta t \le h$, with $h$ the spacing. Why? Why does nothing of the kind
# limit (13.2), and what limits $\Delta t$ then?
#
# <details><summary>Hint</summary>
#
# For (b) take $\mathbf{a} = (1, 0)$ and a field that does not depend on $y_2$. For (c) ask from
# where the information comes that decides the new value.
#
# </details>

# %% [markdown] answer="13.4" points=3
# (a) By the chain rule $\frac{d}{d\tau} u(\mathbf{y}(\tau), \tau) = u_t + \dot{\mathbf{y}} \cdot
# \nabla u = u_t + \mathbf{a}\cdot\nabla u = 0$. (b) With $\mathbf{a} = (1, 0)$ and $u = g(y_1 - t)$
# the curve $\mathbf{y}(t) = (t, \sin t)$ has $u = g(0)$ throughout, but its velocity is $(1, \cos
# t)$, not $\mathbf{a}$. (In the extreme, a constant field is constant along every curve.) (c) The
# true value is decided at the foot. If the particle comes from farther than the direct neighbours,
# their values do not contain it, and no formula that uses only them can be right. (13.2) looks up
# the value *at* the foot, however far that is. Only the foot itself must be right: the step is
# limited by how much the velocity changes along it, $\Delta t\, \lVert\nabla\mathbf{a}\rVert$, and
# not by the spacing of the points.

# %% [markdown] rubric="13.4"
# One point for the chain rule. One for a counterexample with a curve and its velocity. One for the
# foot as what decides the value, and the change of the velocity as what limits the step.

# %% [markdown]
# ## One step is a matrix
#
# Let $\mathbf{x}_1, \dots, \mathbf{x}_N$ be the sites, scattered as they are, $\mathbf{u}^n$ the
# values at the time $t_n$, and $\mathbf{y}_i$ the foot of $\mathbf{x}_i$ after the step to
# $t_{n+1}$. Some method makes a field $s$ of the values; then the new value is $u_i^{n+1} =
# s_{\mathbf{u}^n}(\mathbf{y}_i)$. If the method is linear,
#
# $$ \mathbf{u}^{n+1} = \mathbf{H}\, \mathbf{u}^n , \tag{13.6} $$
#
# and row $i$ of $\mathbf{H}$ holds the weights of the sites for the place $\mathbf{y}_i$. We take
# the field that bends least through the $k$ sites nearest to $\mathbf{y}$, in any dimension $D$.
# Call these sites $\mathbf{z}_1, \dots, \mathbf{z}_k$. Their weights are the first $k$ entries of
# $\mathbf{w}$ in
#
# $$ \begin{bmatrix} \boldsymbol{\Phi} & \mathbf{P} \\ \mathbf{P}^T & \mathbf{0} \end{bmatrix}
#    \mathbf{w} =
#    \bigl(\lVert \mathbf{y} - \mathbf{z}_1 \rVert^3, \dots, \lVert \mathbf{y} - \mathbf{z}_k
#    \rVert^3, 1, \mathbf{y}^T\bigr)^T, \tag{13.7} $$
#
# with $\Phi_{ab} = \lVert \mathbf{z}_a - \mathbf{z}_b \rVert^3$ and the rows $(1, \mathbf{z}_a^T)$
# of $\mathbf{P}$. All other weights are zero. The matrix of (13.7) is given:


# %% tags=["setup"]
def system(z):
    """Return the matrix of (13.7), of shape (k + D + 1, k + D + 1), for sites z (k, D)."""
    k, d = z.shape
    matrix = np.zeros((k + d + 1,) * 2)
    matrix[:k, :k] = np.linalg.norm(z[None] - z[:, None], axis=-1) ** 3
    matrix[:k, k] = matrix[k, :k] = 1
    matrix[:k, k + 1 :], matrix[k + 1 :, :k] = z, z.T
    return matrix


# %% [markdown]
# ### 13.5 The matrix of a step
#
# <details><summary>Hint</summary>
#
# Begin with zeros and fill one row after the other. `np.argsort` of distances tells which sites are
# near; an array of numbers of columns may stand on the left of `=`.
#
# </details>


# %% question="13.5"
def step_matrix(sites, feet, k):
    """Return H of (13.6), of shape (M, N), for sites (N, D), feet (M, D) and k nearest sites."""
    # BEGIN SOLUTION
    H = np.zeros((len(feet), len(sites)))
    for i, y in enumerate(feet):
        r = np.linalg.norm(sites - y, axis=1)
        near = np.argsort(r)[:k]
        b = np.concatenate([r[near] ** 3, [1], y])
        H[i, near] = np.linalg.solve(system(sites[near]), b)[:k]
    return H
    # END SOLUTION


# %%
check("13.5")

# %% [markdown]
# ### 13.6 Many steps
#
# Begin at the time zero and make steps of the length $\Delta t$. The feet, by your `rk4`, are those
# of the sites at the time of *arrival*, $t_{n+1} = (n + 1)\Delta t$; if the velocity depends on
# time, they and $\mathbf{H}$ are other ones in each step.


# %% question="13.6"
def advect(sites, u, dt, steps, flow, k):
    """Return u^0, …, u^steps of (13.6), of shape (steps + 1, N).

    u (N,) are the values at the time zero at the sites (N, 2).
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
# ## Once round
#
# A hill and a slotted disc on 400 sites that turn once as a whole. The end should be the beginning.
# Begin with few steps: between two of them the particles fly over many sites. Then take many.


# %%
def slotted(x):
    """Return one in a disc with a slot, zero elsewhere, and a hill beside it."""
    inside = np.hypot(x[:, 0], x[:, 1] - 0.45) < 0.38
    slot = (np.abs(x[:, 0]) < 0.09) & (x[:, 1] < 0.55)
    beside = x + [0.75, 0.5]
    return np.where(inside & ~slot, 1.0, hill(beside, 25))


LEVELS = np.linspace(-1.3, 1.3, 14)


def show_field(axes, sites, u, title):
    """Draw filled contours at odd tenths: negative values are orange, zero is white."""
    axes.tricontourf(*sites.T, u, LEVELS, cmap="PuOr", extend="both")
    axes.set(aspect="equal", title=title)
    axes.axis("off")


@draw(
    steps=Slider(3, 60, 12, "steps in one turn", whole=True),
    k=Slider(6, 40, 21, "sites that count", whole=True),
)
def once_round(steps, k):
    sites = scattered_in_disc(400)
    u = slotted(sites)
    H = step_matrix(sites, rk4(sites, 0, 1 / steps, 0), k)
    end = np.linalg.matrix_power(H, steps) @ u
    spacing = np.sqrt(np.pi / len(sites))
    with figure(6.4, 3.2) as page:
        left, right = page.subplots(1, 2)
        show_field(left, sites, u, "at the beginning")
        show_field(right, sites, end, "after one turn")
        off = np.sqrt(np.mean((end - u) ** 2))
        page.suptitle(
            f"the rim moves {2 * np.pi / steps / spacing:.1f} spacings in a step; error {off:.3f}"
        )
    return page


# %% [markdown]
# **What to look at.** With ten steps the rim flies over about seven sites in each, and nothing goes
# wrong. The edge of the disc, which no sites resolve, is blurred, and near it values leave the
# range from zero to one.
#
# ## How many steps?
#
# Now a smooth hill alone, so that errors can be told apart. On your three schemes, the error after
# one turn against the number of steps:


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
        axes.set(xlabel="steps in one turn", ylabel="error", ylim=(5e-4, 10))
        axes.set_xticks(counts, counts)
        axes.minorticks_off()
        axes.grid(alpha=0.3)
        axes.legend(loc="center left", bbox_to_anchor=(1, 0.5))
    return page


# %% [markdown]
# **13.7** (a) The curve of `rk4` falls and then rises. Explain both, with errors $C_1 \Delta t^{p}$
# of the feet after the whole time $T$ and $C_2 h^q$ of a single reconstruction, $h$ being the
# spacing. Which $\Delta t$ is best, and how does it change with $h$? (b) Why is there no error of
# reconstruction at all for an affine field in the flow number 0? (c) What would $\mathbf{H}$ be if
# each foot were a site? Why not let the sites go along with the flow, always?

# %% [markdown] answer="13.7" points=3
# (a) There are $T/\Delta t$ steps, and each reconstructs once, so the whole error is about
# $C_1\Delta t^p + (T/\Delta t)\, C_2 h^q$. The first part falls as steps get shorter, the second
# grows: every reconstruction blurs a little. The derivative vanishes at $p\, C_1 \Delta t^{p+1} = T
# C_2 h^q$, so the best step is proportional to $h^{q/(p+1)}$: with finer sites more steps pay.
# Euler is on its falling part throughout. (b) The flow is linear in space, so `rk4` maps places
# linearly, and an affine field of the feet is an affine field of the sites. (13.7) brings affine
# fields back exactly. What is left is the error of the feet. (c) The identity up to the order of
# the sites: nothing is reconstructed and nothing blurred. But the flow crowds sites in some places
# and leaves others without any, so that after a while the field is no longer known everywhere, and
# new sites need a reconstruction after all.

# %% [markdown] rubric="13.7"
# One point for the two parts and the number of steps; the best step may be given by a formula or in
# words. One for affine fields. One for the identity, with what is against sites that go along.

# %% [markdown]
# ## Bounds
#
# A value that is only carried along is never larger than it was. The new one should lie between the
# values round the foot:
#
# $$ l_i = \min_{j \in \mathcal{N}_i} u_j^n, \qquad h_i = \max_{j \in \mathcal{N}_i} u_j^n ,
#    \tag{13.8} $$
#
# with $\mathcal{N}_i$ the four sites that are nearest to the foot $\mathbf{y}_i$. `np.clip(moved,
# low, high)` then puts values between their bounds.
#
# ### 13.8 The bounds


# %% question="13.8"
def bounds(sites, u, feet):
    """Return l and h of (13.8), of shape (M,), for sites (N, 2), values u (N,), feet (M, 2)."""
    # BEGIN SOLUTION
    r = np.linalg.norm(feet[:, None] - sites, axis=2)
    around = u[np.argsort(r)[:, :4]]
    return around.min(axis=1), around.max(axis=1)
    # END SOLUTION


# %%
check("13.8")

# %% [markdown]
# ## Mass
#
# If the flow has no divergence and nothing enters, the integral of $u$ stays. Let $m_j$ be the area
# of site $j$, and $M$ the mass $\sum_j m_j u_j$ that there should be. Of all values within their
# bounds that have this mass we take those that change least, in the mean square with the weights
# $m_j$. They are
#
# $$ v_j = \min\bigl(\max(u_j + \lambda,\ l_j),\ h_j\bigr), \qquad \sum_j m_j v_j = M , \tag{13.9}
#    $$
#
# with one number $\lambda$ for all sites. The mass as a function of $\lambda$ never falls, and is
# made of straight pieces.
#
# ### 13.9 The mass
#
# <details><summary>Hint</summary>
#
# There are two ways. Between $\min_j (l_j - u_j)$ and $\max_j (h_j - u_j)$ one finds $\lambda$ by
# halving an interval sixty times. Or: where are the corners between the straight pieces? With the
# masses there, `np.interp` finishes.
#
# </details>


# %% question="13.9"
def with_mass(u, low, high, m, total):
    """Return v of (13.9), of shape (N,), for values u, bounds low and high, areas m, all (N,).

    total is the mass M, between those of the bounds.
    """
    # BEGIN SOLUTION
    corners = np.sort(np.concatenate([low - u, high - u]))
    masses = [m @ np.clip(u + c, low, high) for c in corners]
    shift = np.interp(total, masses, corners)
    return np.clip(u + shift, low, high)
    # END SOLUTION


# %%
check("13.9")

# %% [markdown]
# The slotted disc again, on 500 sites and in 24 steps: as it comes, within bounds, and with bounds
# and mass.


# %%
def keeping(sites, u, H, feet, bounded, massive):
    """Return the fields of as many steps as there are in a turn, and what is kept beside."""
    m = np.full(len(sites), np.pi / len(sites))
    fields = [u]
    for _ in range(24):
        low, high = bounds(sites, fields[-1], feet)
        moved = H @ fields[-1]
        if bounded:
            moved = np.clip(moved, low, high)
        if massive:
            moved = with_mass(moved, low, high, m, m @ u)
        fields.append(moved)
    return np.array(fields)


@draw()
def what_is_kept():
    sites = scattered_in_disc(500)
    u = slotted(sites)
    feet = rk4(sites, 0, 1 / 24, 0)
    H = step_matrix(sites, feet, 21)
    ways = {
        "as it comes": (False, False),
        "within bounds": (True, False),
        "bounds and mass": (True, True),
    }
    with figure(6.4, 5.0) as page:
        above, below = page.subfigures(2, 1)
        pictures, (left, right) = above.subplots(1, 3), below.subplots(1, 2)
        for axes, (name, kept), color in zip(pictures, ways.items(), (ORANGE, PURPLE, BLUE)):
            fields = keeping(sites, u, H, feet, *kept)
            show_field(axes, sites, fields[-1], name)
            left.plot(fields.max(axis=1), color=color, label=name)
            left.plot(fields.min(axis=1), color=color)
            right.plot(fields.sum(axis=1) / u.sum(), color=color)
        left.set(xlabel="step", ylabel="extrema")
        right.set(xlabel="step", ylabel="mass")
        below.legend(*left.get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return page


# %% [markdown]
# **What to look at.** Unbounded, values leave the range from zero to one at once, and the mass
# wanders by a per cent or two. Bounds alone mend the first, and keeping the mass besides changes
# hardly anything more. What do they cost? Look at the hill.
#
# **13.10** (a) Why is there exactly one field $\mathbf{v}$ of the form (13.9) if $M$ lies between
# $\sum_j m_j l_j$ and $\sum_j m_j h_j$, and none otherwise? (b) Which condition on $\mathbf{H}$
# keeps the mass of *every* field without any correction, which one keeps constants? Which of the
# two does (13.7) obey? (c) A smooth hill has its top between the sites. What do bounds do to it, in
# one step and in many?

# %% [markdown] answer="13.10" points=3
# (a) Each $v_j$ is a continuous function of $\lambda$ that never falls, and so is the mass. For
# $\lambda$ small enough all are at $l_j$, for $\lambda$ large enough at $h_j$, so every mass
# between is reached. Where the mass stays the same over a whole interval of $\lambda$, no $v_j$
# changes there, since none falls and the $m_j$ are positive: the field is unique even if $\lambda$
# is not. Outside, bounds are in contradiction with the mass. (b) The mass after a step is
# $\mathbf{m}^T\mathbf{H}\mathbf{u}$; it is that before for every $\mathbf{u}$ exactly if
# $\mathbf{m}^T\mathbf{H} = \mathbf{m}^T$, a condition on columns. Constants stay if
# $\mathbf{H}\mathbf{1} = \mathbf{1}$, a condition on rows. (13.7) obeys the second, since the
# polynomial is in it, not the first. (c) At the top the interpolant is higher than all sites
# around; the bound cuts that off, though it was right. In every step a little is cut, and the hill
# gets lower and lower.

# %% [markdown] rubric="13.10"
# One point for monotone and continuous with the two extremes. One for $\mathbf{m}^T\mathbf{H} =
# \mathbf{m}^T$ against $\mathbf{H}\mathbf{1} = \mathbf{1}$, and which holds. One for the top that
# is cut, in each step again.

# %% [markdown]
# ## Out and back
#
# The flow number 2 draws a hill out to a thread until the time one half, and then winds it back.
# Your `advect` does it on 400 sites of the square; feet and matrix are made anew in each step.


# %%
@draw(steps=Slider(4, 24, 10, "steps", whole=True))
def out_and_back(steps):
    random = np.random.default_rng(3)
    cells = np.indices((20, 20)).reshape(2, -1).T
    sites = (cells + random.uniform(0.2, 0.8, cells.shape)) / 10 - 1
    steps += steps % 2
    u = hill(sites[:, ::-1], 12)
    fields = advect(sites, u, 1 / steps, steps, 2, 21)
    with figure(6.4, 2.6) as page:
        panels = page.subplots(1, 3)
        for axes, n, title in zip(
            panels, (0, steps // 2, steps), ("at the beginning", "half-way", "back")
        ):
            show_field(axes, sites, fields[n], title)
        off = np.sqrt(np.mean((fields[-1] - u) ** 2))
        page.suptitle(f"{steps} steps, error {off:.3f}")
    return page


# %% [markdown]
# ## A flow that carries itself
#
# In $u_t + u\, u_x = 0$, the equation of Burgers, the velocity is what is carried. On the line a
# particle keeps its velocity $u$, so its path is straight, and the foot of $x$ after a step is a
# solution of
#
# $$ y = x - \Delta t\; s_{\mathbf{u}}(y), \qquad\text{found by}\qquad y^0 = x, \quad y^{m+1} = x -
#    \Delta t\; s_{\mathbf{u}}(y^m), \tag{13.10} $$
#
# where $s_{\mathbf{u}}$ is the field through the values at the sites, by your `step_matrix`.
#
# ### 13.11 Feet of a flow that carries itself


# %% question="13.11"
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
# One single step, of any length, from a smooth wave. The grey curve is exact: every point of the
# wave at the beginning, moved by $\Delta t$ times its own height. At $\Delta t = 1$ in units of the
# slider the wave breaks.


# %%
@draw(dt=Slider(0, 1.6, 0.8, "step, in units of the time of breaking", steps=32))
def one_step_of_a_wave(dt):
    x = np.linspace(-1, 1, 61)[:, None]
    u = 0.2 + np.exp(-6 * x[:, 0] ** 2)
    breaking = 1 / (np.sqrt(12) * np.exp(-0.5))
    feet = burgers_feet(x, u, dt * breaking, 60, 8)
    moved = step_matrix(x, feet, 8) @ u
    fine = np.linspace(-1.2, 1, 400)
    wave = 0.2 + np.exp(-6 * fine**2)
    with figure(6.4, 2.9) as page:
        axes = page.subplots()
        axes.plot(x, u, ":", color=GREY, label="at the beginning")
        axes.plot(fine + dt * breaking * wave, wave, color=GREY, lw=4, alpha=0.5, label="exact")
        axes.plot(x, np.clip(moved, -1, 3), ".-", color=BLUE, ms=4, lw=1, label="one step of yours")
        axes.set(xlabel="$x$", ylabel="$u$", xlim=(-1, 1), ylim=(0, 1.5))
        axes.legend(loc="center left", bbox_to_anchor=(1, 0.5))
    return page


# %% [markdown]
# **13.12** (a) When does (13.10) converge, and how fast? (b) The wave breaks at the time $t^* =
# 1/\max(-u_x)$. What happens then to the characteristics, and what has this to do with (a)? (c) So
# up to which length is one step exact but for reconstruction?
#
# <details><summary>Hint</summary>
#
# Subtract two rounds from each other. How large is the difference of $s(y)$ at two places at most?
#
# </details>

# %% [markdown] answer="13.12" points=2
# (a) The difference of two rounds is $-\Delta t\,(s(y^m) - s(y^{m-1}))$, at most $\Delta t
# \max\lvert s'\rvert$ times the one before; if that factor is less than one, the rounds converge at
# least as fast as its powers. (b) The particle from $x_0$ is at $x_0 + t\,u(x_0)$; this map has the
# derivative $1 + t\,u_x$, which first vanishes at $t^*$, where particles overtake each other. From
# then on some places have several feet, and (13.10) has several solutions. Where the velocity falls
# most, $\Delta t\,\lvert s' \rvert$ reaches one at the same moment. (After that the rounds fail
# also where the velocity rises as steeply, although there is one foot only: this is a fault of the
# rounds, not of the wave.) (c) Up to $\Delta t < t^*$, as far as the rounds converge: paths are
# straight, so no error of time is made at all, however many sites are passed.

# %% [markdown] rubric="13.12"
# One point for the factor $\Delta t\,\lvert u_x\rvert < 1$. One for feet that are no longer unique
# after $t^*$, or for straight paths, so that the step is exact before.

# %% [markdown]
# ## Dig deeper
#
# - What decides whether many turns go well are the powers of $\mathbf{H}$. Compute its eigenvalues
#   for the flow 0 on sites in the disc, with 21 sites that count and with all of them. Which has a
#   modulus above one? How many turns does it take until one sees it?
# - Sites in a square and the flow 0: the corners come from outside. What does (13.7) do there, and
#   what do the eigenvalues say? What would the equation need to be told at such a boundary?
# - Let the sites go along: put each site of the next step where the flow takes a site of this one.
#   What is left of the error after one turn? When do you need new sites?
# - A velocity that is itself known only at sites has to be reconstructed inside every stage of
#   (13.5). Which order do the feet keep then?

# %%
progress()
