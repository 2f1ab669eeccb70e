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
# # The weights in three dimensions
#
# In a mesh of tetrahedra the pressures are kept at circumcentres too, and those round a vertex are
# the corners of a polyhedron. The weights that mix their values look like those of the plane, with
# a six for the two and a volume for the area. Why? This notebook is a proof in four steps, and the
# same formulas as code: what you have proved you then measure, and what you measure helps where the
# proof is stuck.
#
# Three of the questions ask for functions of a line or two, three for a little more, and four for
# words. Formulas that you need from the plane are repeated.

# %% tags=["setup"]
import numpy as np

from fieldcheck import (
    BLUE,
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
# Twenty tetrahedra meet in a vertex; their outer faces form an icosahedron (grey). Their
# circumcentres (dots) are the corners of the Voronoi cell of the vertex, a dodecahedron: one face
# for each neighbour, one corner for each tetrahedron, and three faces at each corner. Turn it.


# %%
def icosahedron():
    """Return the 12 corners of an icosahedron of radius 1, and its 20 triangles."""
    golden = (1 + np.sqrt(5)) / 2
    signs = [(s, t) for s in (-1, 1) for t in (-1, 1)]
    ring = np.array([np.roll([0, s, t * golden], k) for k in range(3) for s, t in signs])
    touch = np.linalg.norm(ring[:, None] - ring, axis=2) < 2.1
    triples = [(i, j, k) for i in range(12) for j in range(i) for k in range(j)]
    faces = [t for t in triples if touch[np.ix_(t, t)].all()]
    return ring / np.hypot(1, golden), np.array(faces)


def seen_from(places, angle):
    """Return where places (M, 3), turned by degrees, appear on paper, and how near."""
    t, tilt = np.radians(angle), np.radians(20)
    turned = places @ [
        [np.cos(t), np.sin(t), 0],
        [-np.sin(t), np.cos(t), 0],
        [0, 0, 1],
    ]
    depth = np.sin(tilt) * turned[:, 2] - np.cos(tilt) * turned[:, 1]
    return (
        turned[:, 0],
        np.cos(tilt) * turned[:, 2] + np.sin(tilt) * turned[:, 1],
        depth,
    )


def draw_edges(axes, places, pairs, angle, color):
    """Draw lines between pairs of places, fainter where they are far."""
    across, up, depth = seen_from(places, angle)
    near = (depth - depth.min()) / np.ptp(depth)
    for i, j in pairs:
        strength = 0.15 + 0.85 * min(1, (near[i] + near[j]) / 2 + 0.1)
        axes.plot(across[[i, j]], up[[i, j]], color=color, alpha=strength, lw=1 + strength)


def sharing(cells):
    """Return pairs of cells with a common face: between their corners runs an edge."""
    common = (cells[:, None, :, None] == cells[:, None]).sum(axis=(2, 3))
    return np.argwhere(np.triu(common == 2))


@draw(angle=Slider(0, 180, 25, "turned by", steps=36))
def the_problem(angle):
    tips, cells = icosahedron()
    outward = tips[cells].mean(axis=1)
    dots = outward / (2 * (outward * tips[cells[:, 0]]).sum(axis=1)[:, None])
    with figure(6.4, 3.8) as page:
        axes = page.subplots()
        sides = np.unique(np.vstack([cells[:, :2], cells[:, 1:], cells[:, ::2]]), axis=0)
        draw_edges(axes, tips, sides, angle, GREY)
        draw_edges(axes, dots, sharing(cells), angle, BLUE)
        across, up, _ = seen_from(dots, angle)
        axes.plot(
            across,
            up,
            "o",
            color=BLUE,
            ms=4,
            label="circumcentres, on the Voronoi cell",
        )
        axes.plot(*seen_from(tips, angle)[:2], "o", color=GREY, ms=4, label="neighbours")
        axes.plot(0, 0, "o", color=ORANGE, label=r"the vertex $\mathbf{x}_i$")
        axes.set_aspect("equal")
        axes.axis("off")
        axes.legend(loc="center left", bbox_to_anchor=(1.02, 0.5))
    return page


# %% [markdown]
# ## What is to be proved
#
# At a corner $\mathbf{p}_a$ of a polyhedron let three faces meet, with the outward unit normals
# $\mathbf{n}_b$, $b \in \mathcal{N}_a = \{j, k, m\}$. Its weight at a place $\mathbf{x}$ is
#
# $$ w_a(\mathbf{x}) = \frac{\operatorname{vol}(\mathcal{N}_a)}{\prod_{b \in \mathcal{N}_a}
#    \mathbf{n}_b^T (\mathbf{p}_a - \mathbf{x})},
#    \qquad \operatorname{vol}(\mathcal{N}_a) = \lvert \det(\mathbf{n}_j, \mathbf{n}_k,
#    \mathbf{n}_m) \rvert . \tag{8.1} $$
#
# Let the polyhedron be the Voronoi cell of a vertex $\mathbf{x}_i$ of a Delaunay mesh. The
# tetrahedron number $a$ has the vertices $\mathbf{x}_i, \mathbf{x}_j, \mathbf{x}_k, \mathbf{x}_m$,
# the volume $V_a$ and the circumcentre $\mathbf{p}_a$. The claim is
#
# $$ w_a(\mathbf{x}) = \frac{6 V_a}{\prod_{b \in \{j,k,m\}} (\mathbf{x}_b - \mathbf{x}_i)^T
#    (\mathbf{p}_a - \mathbf{x})} . \tag{8.2} $$
#
# ## Tetrahedra
#
# With $\mathbf{e}_1, \mathbf{e}_2, \mathbf{e}_3$ the edges from one corner of a tetrahedron to the
# three others, the volume and the circumcentre are
#
# $$ V = \tfrac16 \lvert \det(\mathbf{e}_1, \mathbf{e}_2, \mathbf{e}_3) \rvert, \tag{8.3} $$
#
# $$ \mathbf{e}_r^T (\mathbf{p} - \mathbf{a}) = \tfrac12 \lVert \mathbf{e}_r \rVert^2, \qquad r = 1,
#    2, 3, \tag{8.4} $$
#
# where $\mathbf{a}$ is that corner. The second says that $\mathbf{p}$ is as far from $\mathbf{a}$
# as from the other end of each edge.
#
# ### 08.1 The volume


# %% question="08.1"
def volume(a, b, c, d):
    """Return V of (8.3), a number, for corners a, b, c, d, each of shape (3,)."""
    # BEGIN SOLUTION
    return abs(np.linalg.det([b - a, c - a, d - a])) / 6
    # END SOLUTION


# %%
check("08.1")

# %% [markdown]
# ### 08.2 The circumcentre


# %% question="08.2"
def circumcenter(a, b, c, d):
    """Return p of (8.4), of shape (3,), for corners a, b, c, d, each of shape (3,)."""
    # BEGIN SOLUTION
    edges = np.array([b - a, c - a, d - a])
    return a + np.linalg.solve(edges, [e @ e / 2 for e in edges])
    # END SOLUTION


# %%
check("08.2")

# %% [markdown]
# ## Step 1: the normals
#
# **08.3** What stands for (A) to (G)? The face $b$ of the Voronoi cell separates the places nearer
# to $\mathbf{x}_i$ from those nearer to **(A)**. So all its points $\mathbf{y}$ have
# $\lVert\mathbf{y} - \mathbf{x}_i\rVert =$ **(B)**. Squared and expanded, this says
# $(\mathbf{x}_b - \mathbf{x}_i)^T(\mathbf{y} - \mathbf{x}_i) =$ **(C)**, a plane perpendicular
# to **(D)** through the point **(E)**. With $l_b = \lVert \mathbf{x}_b - \mathbf{x}_i \rVert$
# the *outward unit* normal is therefore $\mathbf{n}_b =$ **(F)**. It points outwards
# because **(G)**.
#
# <details><summary>Hint</summary>
#
# Write $\mathbf{y} - \mathbf{x}_b = (\mathbf{y} - \mathbf{x}_i) - (\mathbf{x}_b - \mathbf{x}_i)$
# before you square.
#
# </details>

# %% [markdown] answer="08.3" points=2
# (A) $\mathbf{x}_b$, (B) $\lVert\mathbf{y} - \mathbf{x}_b\rVert$. With $\mathbf{y} - \mathbf{x}_b =
# (\mathbf{y} - \mathbf{x}_i) - (\mathbf{x}_b - \mathbf{x}_i)$ the squares of $\mathbf{y} -
# \mathbf{x}_i$ cancel, and $(\mathbf{x}_b - \mathbf{x}_i)^T(\mathbf{y} - \mathbf{x}_i) = \tfrac12
# l_b^2$ is left, so (C) $\tfrac12 l_b^2$: a plane perpendicular to (D) the edge from $\mathbf{x}_i$
# to $\mathbf{x}_b$ through (E) its midpoint. (F) $\mathbf{n}_b = (\mathbf{x}_b -
# \mathbf{x}_i)/l_b$, and it points outwards because (G) inside the cell, at $\mathbf{x}_i$ for
# instance, the left side is less than $\tfrac12 l_b^2$.

# %% [markdown] rubric="08.3"
# One point for the plane, from equal distances to $\mathbf{x}_i$ and $\mathbf{x}_b$. One for the
# normal along the edge, of length one, with a reason why it points outwards.

# %% [markdown]
# ## Step 2: the volume of the normals
#
# ### 08.4 Their determinant
#
# Compute $\operatorname{vol}(\mathcal{N}_a)$ as (8.1) defines it, from the normals of step 1, for
# one tetrahedron.


# %% question="08.4"
def volume_of_normals(center, tips):
    """Return vol(N_a) of (8.1), a number.

    center (3,) is x_i, and the rows of tips (3, 3) are x_j, x_k, x_m.
    """
    # BEGIN SOLUTION
    normals = [spoke / np.linalg.norm(spoke) for spoke in tips - center]
    return abs(np.linalg.det(normals))
    # END SOLUTION


# %%
check("08.4")

# %% [markdown]
# Now the conjecture, measured on your own tetrahedra and on others: does
# $\operatorname{vol}(\mathcal{N}_a)$ equal $6V_a/(l_j\, l_k\, l_m)$, and what if other powers of
# the lengths stand below?


# %%
@draw(power=Slider(0, 2, 1, "power of the lengths", steps=20))
def conjecture(power):
    center, neighbors, cells, _, _ = data("08.7")
    at_random = center + np.random.default_rng(2).normal(size=(30, 3, 3))
    with figure(5.4, 3.2) as page:
        axes = page.subplots()
        axes.plot([0, 1], [0, 1], color=GREY, lw=1, label="equal")
        sets = (
            ("at random", at_random, ORANGE, "."),
            ("your own", neighbors[cells], BLUE, "o"),
        )
        for name, tetrahedra, color, marker in sets:
            measured, guessed = [], []
            for tips in tetrahedra:
                lengths = np.hypot.reduce(tips - center, axis=1)
                sixfold = 6 * volume(center, tips[0], tips[1], tips[2])
                measured.append(volume_of_normals(center, tips))
                guessed.append(sixfold / np.prod(lengths) ** power)
            axes.plot(measured, guessed, marker, color=color, label=name)
        below = r"(l_j\,l_k\,l_m)" + (f"^{{{power:g}}}" if power != 1 else "")
        axes.set(
            xlabel=r"$\mathrm{vol}(\mathcal{N}_a)$",
            ylabel=rf"$6V_a\,/\,{below}$",
            xlim=(0, 1),
        )
        axes.legend(loc="center left", bbox_to_anchor=(1, 0.5))
    return page


# %% [markdown]
# **08.5** Prove it: $\operatorname{vol}(\mathcal{N}_a) = 6 V_a / (l_j\, l_k\, l_m)$. Say which rule
# for determinants you use, and what the six counts.
#
# <details><summary>Hint</summary>
#
# What happens to a determinant if one row is divided by a number? And how many tetrahedra make the
# parallelepiped over three edges?
#
# </details>

# %% [markdown] answer="08.5" points=3
# By step 1 the rows of the determinant are $\mathbf{n}_b = (\mathbf{x}_b - \mathbf{x}_i)/l_b$. A
# determinant is linear in each row, so each length can be taken out:
#
# $$ \det(\mathbf{n}_j, \mathbf{n}_k, \mathbf{n}_m) = \frac{\det(\mathbf{x}_j - \mathbf{x}_i,
#    \mathbf{x}_k - \mathbf{x}_i, \mathbf{x}_m - \mathbf{x}_i)}{l_j l_k l_m} . $$
#
# Lengths are positive, so this holds for the absolute values. The determinant on the right is, up
# to its sign, the volume of the parallelepiped over the three edges at $\mathbf{x}_i$. That
# consists of $3! = 6$ tetrahedra of equal volume, one for each order of the three edges; or: a
# tetrahedron is a third of base times height, and its base is half of a parallelogram. So the
# absolute value is $6V_a$.

# %% [markdown] rubric="08.5"
# One point for taking one length out of each row. One for the determinant of the edges as the
# volume of a parallelepiped, with the absolute value. One for the six, with a reason.

# %% [markdown]
# ## Step 3: the lengths cancel
#
# **08.6** Put steps 1 and 2 into (8.1) and arrive at (8.2). How many factors $l_b$ stand below the
# line, how many above, and why the same ones? Which of your steps would change in two dimensions,
# and which in $D$?

# %% [markdown] answer="08.6" points=3
# By step 1 each factor below is $\mathbf{n}_b^T(\mathbf{p}_a - \mathbf{x}) = (\mathbf{x}_b -
# \mathbf{x}_i)^T(\mathbf{p}_a - \mathbf{x})/l_b$. There is one for each of the three faces that
# meet in $\mathbf{p}_a$, and these belong to the three neighbours $j, k, m$ that form the
# tetrahedron $a$ with $\mathbf{x}_i$; so the denominator of (8.1) is $\prod_b (\mathbf{x}_b -
# \mathbf{x}_i)^T(\mathbf{p}_a - \mathbf{x})$ divided by $l_j l_k l_m$. By step 2 the numerator is
# $6V_a$ divided by the same product. It cancels, and (8.2) is left. In $D$ dimensions $D$ faces
# meet in a corner, $D$ lengths leave the determinant, and $D!$ simplices make the parallelepiped:
# $w_a = D!\,V_a/\prod_b (\mathbf{x}_b - \mathbf{x}_i)^T(\mathbf{p}_a - \mathbf{x})$, with $2A_a$ in
# the plane. Nothing else changes.

# %% [markdown] rubric="08.6"
# One point for each factor with its $1/l_b$. One for the cancellation, with the reason that the
# three faces at the corner belong to the three other vertices of the tetrahedron. One for $D!$, or
# $2A$ and $6V$ with the reason.

# %% [markdown]
# ### 08.7 The weights
#
# Write (8.2). The mesh is given as it usually is: an array of neighbours, and for each tetrahedron
# the three numbers of those that it has besides $\mathbf{x}_i$, in any order.


# %% question="08.7"
def weights(center, neighbors, cells, corners, x):
    """Return w_a of (8.2) for all T tetrahedra, of shape (T,), at one place x (3,).

    center (3,) is x_i, neighbors (N, 3) are all x_b, a row of cells (T, 3) holds the
    numbers j, k, m of a tetrahedron, and corners (T, 3) are the circumcentres p_a.
    """
    # BEGIN SOLUTION
    w = np.empty(len(cells))
    for a, cell in enumerate(cells):
        spokes = neighbors[cell] - center
        below = np.prod(spokes @ (corners[a] - x))
        w[a] = 6 * volume(center, *neighbors[cell]) / below
    return w
    # END SOLUTION


# %%
check("08.7")


# %% [markdown]
# ## Look at it
#
# Linear precision is what makes weights coordinates: $\sum_a \omega_a \mathbf{p}_a = \mathbf{x}$
# with $\omega_a = w_a / \sum_e w_e$. The chart shows how far the sum is from the place, at its
# worst over forty places in three cells: for your weights, for the same without the volumes, and
# for the same with the sign of the determinant left in.


# %%
def circumcenters(center, neighbors, cells):
    """Return all p_a, of shape (T, 3), with your function."""
    return np.array([circumcenter(center, *(neighbors[int(b)] for b in cell)) for cell in cells])


@draw()
def linear_precision():
    eight = np.array([(x, y, z) for x in (0, 3) for y in (1, 4) for z in (2, 5)])
    axes_ends = np.array([(1, 0, 0), (0, 1, 0), (0, 0, 1), (-1, 0, 0), (0, -1, 0), (0, 0, -1.0)])
    uneven, cells = icosahedron()
    uneven = uneven * (1 + 0.2 * np.sin(np.arange(12) ** 2))[:, None]
    stars = {
        "octahedron": (np.zeros(3), axes_ends, eight),
        "uneven icosahedron": (np.zeros(3), uneven, cells),
        "your own": data("08.7")[:3],
    }
    random = np.random.default_rng(3)
    worst = []
    for center, neighbors, cells in stars.values():
        corners = circumcenters(center, neighbors, cells)
        signs = np.sign([np.linalg.det(neighbors[cell] - center) for cell in cells])
        sizes = np.array([volume(center, *(neighbors[int(b)] for b in cell)) for cell in cells])
        misses = []
        for mix in random.dirichlet(np.ones(len(cells)), 40):
            place = mix @ corners
            w = weights(center, neighbors, cells, corners, place)
            ways = (w, w / sizes, w * signs)
            misses.append([np.linalg.norm(v @ corners / v.sum() - place) for v in ways])
        worst.append(np.maximum(np.max(misses, axis=0), 1e-17))
    with figure(6.4, 2.9) as page:
        axes = page.subplots()
        names = ("yours", "volumes left out", "signs left in")
        looks = zip(names, (BLUE, ORANGE, PURPLE), np.transpose(worst), (-0.12, 0, 0.12))
        for name, color, misses, aside in looks:
            axes.plot(np.arange(3) + aside, misses, "o", color=color, ms=8, label=name)
        axes.set_yscale("log")
        axes.set_xticks(range(3), list(stars))
        axes.set(ylim=(1e-17, 1e3), xlim=(-0.5, 2.5), ylabel="largest miss")
        axes.grid(axis="y", alpha=0.3)
        axes.legend(loc="center left", bbox_to_anchor=(1, 0.5))
    return page


# %% [markdown]
# **What to look at.** Yours is right to rounding in all three. In the octahedron all volumes are
# equal, so that leaving them out does no harm there: a regular example proves little. The
# tetrahedra are listed in no particular orientation, so the signs do harm everywhere.
#
# ## Step 4: no circumcentre
#
# The factors below (8.2) do not need the circumcentre:
#
# $$ (\mathbf{x}_b - \mathbf{x}_i)^T(\mathbf{p}_a - \mathbf{x}) = h_b(\mathbf{x}), \qquad
#    h_b(\mathbf{x}) = \tfrac12 l_b^2 - (\mathbf{x}_b - \mathbf{x}_i)^T(\mathbf{x} - \mathbf{x}_i) .
#    \tag{8.5} $$
#
# ### 08.8 The heights


# %% question="08.8"
def heights(center, neighbors, x):
    """Return h_b of (8.5) at places x (M, 3), of shape (N, M): a row for each neighbour."""
    # BEGIN SOLUTION
    return np.array([s @ s / 2 - (x - center) @ s for s in neighbors - center])
    # END SOLUTION


# %%
check("08.8")

# %% [markdown]
# A place moves along a line from inside your cell to the corner 0 and beyond. The line in the
# picture is your $h_b$; the marks are the left side of (8.5), computed from each corner of the face
# $b$ in turn. Which of the neighbours have $h_b = 0$ at the corner 0?


# %%
@draw(b=Slider(0, 5, 0, "neighbour b", whole=True))
def from_every_corner(b):
    center, neighbors, cells, corners, _ = data("08.7")
    t = np.linspace(-0.5, 1.25, 29)
    line = center + t[:, None] * (corners[0] - center)
    spoke = neighbors[b] - center
    with figure(5.6, 2.9) as page:
        axes = page.subplots()
        axes.axhline(0, color=GREY, lw=0.8)
        axes.plot(t, heights(center, neighbors, line)[b], color=BLUE, label="$h_b$")
        at_face = [int(a) for a in np.argwhere(cells == b)[:, 0]]
        for a, marker in zip(at_face, "ox+sd^v<>*"):
            p = circumcenter(center, *(neighbors[int(k)] for k in cells[a]))
            every = slice(at_face.index(a), None, len(at_face))
            left = (p - line[every]) @ spoke
            axes.plot(t[every], left, marker, color=ORANGE, label=f"from corner {a}")
        axes.axvline(1, color=GREY, lw=0.8, ls=":")
        axes.set_xticks([-0.5, 0, 0.5, 1])
        axes.set(
            xlabel="place: vertex at 0, corner 0 at 1",
            ylabel=f"$h_{b}$ on the line",
        )
        axes.legend(loc="center left", bbox_to_anchor=(1, 0.5))
    return page


# %% [markdown]
# **08.9** Prove (8.5) for every place $\mathbf{x}$ and every corner $a$ of the face $b$. What
# follows for meshes with slivers, tetrahedra so flat that their circumcentres are known to no
# digit? And what do the weights say on a face, where (8.2) divides by zero?
#
# <details><summary>Hint</summary>
#
# Begin with $\mathbf{x} = \mathbf{x}_i$: then (8.5) is one of the equations (8.4). How do both
# sides change as $\mathbf{x}$ moves?
#
# </details>

# %% [markdown] answer="08.9" points=3
# The circumcentre is as far from $\mathbf{x}_b$ as from $\mathbf{x}_i$: $\lVert\mathbf{p}_a -
# \mathbf{x}_i\rVert^2 = \lVert(\mathbf{p}_a - \mathbf{x}_i) - (\mathbf{x}_b -
# \mathbf{x}_i)\rVert^2$. Expanded, this is $(\mathbf{x}_b - \mathbf{x}_i)^T(\mathbf{p}_a -
# \mathbf{x}_i) = \tfrac12 l_b^2$. Subtract $(\mathbf{x}_b - \mathbf{x}_i)^T(\mathbf{x} -
# \mathbf{x}_i)$ from both sides. The right side knows nothing of $a$: $h_b$ is the same seen from
# every corner of the face. So circumcentres need not be computed at all, and a sliver, whose
# circumcentre is badly determined, does no harm: its volume, which is small, is all that enters.
# Since each $h_b$ is one number, all weights can be multiplied by the product of all heights, which
# leaves $V_a$ times the heights of the *other* faces. On a face $b$ all corners off it then have
# the weight zero, and the others positive ones, without any division by zero.

# %% [markdown] rubric="08.9"
# One point for the equation of equal distances at $\mathbf{x}_i$. One for the general place. One
# for a consequence: no circumcentre for slivers, or no division on faces.

# %% [markdown]
# ### 08.10 Coordinates without division
#
# Multiply all weights (8.2) by the product of all heights. What is left is
#
# $$ \omega_a = \frac{c_a}{\sum_e c_e}, \qquad c_a(\mathbf{x}) = V_a \prod_{b \,\notin\, \{j, k,
#    m\}} h_b(\mathbf{x}) . \tag{8.6} $$


# %% question="08.10"
def coordinates(center, neighbors, cells, x):
    """Return ω_a of (8.6) at places x (M, 3), of shape (M, T): a row for each place."""
    # BEGIN SOLUTION
    h = heights(center, neighbors, x)
    c = np.empty((len(cells), len(x)))
    for a, cell in enumerate(cells):
        others = np.delete(h, cell, axis=0)
        c[a] = volume(center, *neighbors[cell]) * others.prod(axis=0)
    return (c / c.sum(axis=0)).T
    # END SOLUTION


# %%
check("08.10")

# %% [markdown]
# ## A point in your cell
#
# Your own Voronoi cell. The point walks along a line from one corner through the middle to the face
# across; the dots show the coordinates by their area.


# %%
@draw(
    along=Slider(0, 1, 0.3, "on its way", steps=20),
    angle=Slider(0, 180, 30, "turned by", steps=36),
)
def walk(along, angle):
    center, neighbors, cells, corners, _ = data("08.7")
    reach = heights(center, neighbors, np.array([center, 2 * center - corners[0]]))
    slope = (reach[:, 0] - reach[:, 1]) / reach[:, 0]
    far = center - (corners[0] - center) / slope.max()
    place = (1 - along) * corners[0] + along * far
    (omega,) = coordinates(center, neighbors, cells, place[None])
    with figure(5.6, 3.8) as page:
        axes = page.subplots()
        draw_edges(axes, corners - center, sharing(cells), angle, GREY)
        across, up, _ = seen_from(corners - center, angle)
        axes.scatter(across, up, s=900 * np.clip(omega, 0, 1), color=BLUE, alpha=0.75, lw=0)
        (right,), (height,), _ = seen_from((place - center)[None], angle)
        axes.plot(right, height, "o", color=ORANGE, ms=8)
        (right,), (height,), _ = seen_from((omega @ corners - center)[None], angle)
        axes.plot(right, height, "o", mfc="none", color=PURPLE, ms=14, mew=1.5)
        extremes = f"largest {omega.max():.2f}, smallest {omega.min():.2f}"
        axes.set_title(extremes.replace("-0.00", "0.00"))
        axes.set_aspect("equal")
        axes.axis("off")
    return page


# %% [markdown]
# **What to look at.** At the start one corner has all the weight; at the end, on a face, only the
# corners of that face have any. The ring is $\sum_a \omega_a \mathbf{p}_a$: by linear precision it
# stays round the point.
#
# ## Dig deeper
#
# - Prove linear precision, $\sum_a w_a(\mathbf{x})(\mathbf{p}_a - \mathbf{x}) = \mathbf{0}$. Hint:
#   the points $\mathbf{n}_b / (\mathbf{n}_b^T(\mathbf{p}_a - \mathbf{x}))$ are the corners of a
#   closed polyhedron with one triangle for each $a$, perpendicular to $\mathbf{p}_a - \mathbf{x}$;
#   and over a closed surface the areas times normals sum to zero.
# - A vertex on the boundary of the mesh has no closed cell. Leave one tetrahedron out. Do the
#   weights still sum to one? Does a linear field still come back?
# - Cut a cube into six tetrahedra round a diagonal. Circumcentres coincide. Which sums of
#   coordinates have a meaning, and which known formula are they?

# %%
progress()
