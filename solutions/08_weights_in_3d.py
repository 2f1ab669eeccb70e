# ---
# jupyter:
#   course:
#     builds_on:
#       "07": the weights and the coordinates in the plane
#     pages: slides, pages 37 and 46
#     chapters: [18-voronoi-coordinates]
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
# # Voronoi weights in three dimensions
#
# In a mesh of tetrahedra a solver stores its pressures at circumcentres too. The circumcentres
# around a vertex are the corners of a polyhedron, the Voronoi cell of the vertex. The weights that
# interpolate in this cell look like those of the plane, with $6V$ in place of $2A$. This notebook
# proves this in three steps and tests it by computations. A fourth step avoids the circumcentres.
#
# **Sources**: the lecture slides "Field Reconstruction" by K. Erleben, pages 27–37 and 46; J.
# Warren, S. Schaefer, A. Hirani and M. Desbrun, *Barycentric coordinates for convex sets* (2007);
# T. Ju and others, *A geometric construction of coordinates for convex polyhedra using polar duals*
# (2005). **To search for**: Wachspress coordinates of polyhedra, simple polytope, Voronoi cell,
# polar dual, sliver.
#
# Each question asks for a short function with a check below it, or for a proof in words. After a
# check that is not right, `case()` in a new cell shows the inputs for which your function failed,
# and your values. If everybody has the same inputs, it also shows the right values. Arrays may hold
# integers, so small that no product of them overflows. Compute with float64, NumPy's default type.
# Returned lists count as arrays, an array with one entry as a number, and a complex number without
# imaginary part as a real one. A function must not change its arguments.

# %% tags=["setup"]
import numpy as np

from fieldcheck import (
    BLUE,
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

# %% [markdown]
# ## The problem in a picture
#
# Twenty tetrahedra meet in a vertex, and their outer faces form an icosahedron (grey). Their
# circumcentres (dots) are the corners of the Voronoi cell of the vertex, a dodecahedron. It has one
# face for each neighbour and one corner for each tetrahedron, and three faces meet in each corner.
# Rotate it with the slider.


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


def projection(points, angle):
    """Return the picture of points (M, 3) rotated by an angle in degrees: across, up, depth."""
    t, tilt = np.radians(angle), np.radians(20)
    turned = points @ [
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


def draw_edges(axes, points, pairs, angle, color):
    """Draw lines between pairs of points, fainter at the back."""
    across, up, depth = projection(points, angle)
    near = (depth - depth.min()) / np.ptp(depth)
    for i, j in pairs:
        strength = 0.15 + 0.85 * min(1, (near[i] + near[j]) / 2 + 0.1)
        axes.plot(across[[i, j]], up[[i, j]], color=color, alpha=strength, lw=1 + strength)


def sharing(cells):
    """Return pairs of cells with a common face; their circumcentres are joined by an edge."""
    common = (cells[:, None, :, None] == cells[:, None]).sum(axis=(2, 3))
    return np.argwhere(np.triu(common == 2))


@draw(angle=Slider(0, 180, 25, "rotation", steps=36))
def the_problem(angle):
    tips, cells = icosahedron()
    outward = tips[cells].mean(axis=1)
    dots = outward / (2 * (outward * tips[cells[:, 0]]).sum(axis=1)[:, None])
    with figure(6.4, 3.8) as page:
        axes = page.subplots()
        sides = np.unique(np.vstack([cells[:, :2], cells[:, 1:], cells[:, ::2]]), axis=0)
        draw_edges(axes, tips, sides, angle, GREY)
        draw_edges(axes, dots, sharing(cells), angle, BLUE)
        across, up, _ = projection(dots, angle)
        axes.plot(
            across,
            up,
            "o",
            color=BLUE,
            ms=4,
            label="circumcentres, on the Voronoi cell",
        )
        axes.plot(*projection(tips, angle)[:2], "o", color=GREY, ms=4, label="neighbours")
        axes.plot(0, 0, "o", color=ORANGE, label=r"the vertex $\mathbf{x}_i$")
        axes.set_aspect("equal")
        axes.axis("off")
        axes.legend(loc="center left", bbox_to_anchor=(1.02, 0.5))
    return page


# %% [markdown]
# ## The claim
#
# Let three faces of a polyhedron meet in the corner $\mathbf{p}_a$, with the outward unit normals
# $\mathbf{n}_b$, $b \in \mathcal{N}_a = \{j, k, m\}$. The weight of this corner at a point
# $\mathbf{x}$ is
#
# $$ w_a(\mathbf{x}) = \frac{\operatorname{vol}(\mathcal{N}_a)}{\prod_{b \in \mathcal{N}_a}
#    \mathbf{n}_b^T (\mathbf{p}_a - \mathbf{x})},
#    \qquad \operatorname{vol}(\mathcal{N}_a) = \lvert \det(\mathbf{n}_j, \mathbf{n}_k,
#    \mathbf{n}_m) \rvert . \tag{8.1} $$
#
# Now let the polyhedron be the Voronoi cell of a vertex $\mathbf{x}_i$ of a Delaunay mesh.
# Tetrahedron $a$ has the vertices $\mathbf{x}_i, \mathbf{x}_j, \mathbf{x}_k, \mathbf{x}_m$, the
# volume $V_a$ and the circumcentre $\mathbf{p}_a$. The claim is
#
# $$ w_a(\mathbf{x}) = \frac{6 V_a}{\prod_{b \in \{j,k,m\}} (\mathbf{x}_b - \mathbf{x}_i)^T
#    (\mathbf{p}_a - \mathbf{x})} . \tag{8.2} $$
#
# ## Volume and circumcentre of a tetrahedron
#
# Let $\mathbf{e}_1, \mathbf{e}_2, \mathbf{e}_3$ be the edges from the corner $\mathbf{a}$ of a
# tetrahedron to the other three corners. Its volume and its circumcentre $\mathbf{p}$ satisfy
#
# $$ V = \tfrac16 \lvert \det(\mathbf{e}_1, \mathbf{e}_2, \mathbf{e}_3) \rvert, \tag{8.3} $$
#
# $$ \mathbf{e}_r^T (\mathbf{p} - \mathbf{a}) = \tfrac12 \lVert \mathbf{e}_r \rVert^2, \qquad r = 1,
#    2, 3. \tag{8.4} $$
#
# Equation $r$ of (8.4) says that $\mathbf{p}$ has the same distance from $\mathbf{a}$ and from the
# other end of $\mathbf{e}_r$.
#
# ## A worked example
#
# Take $\mathbf{x}_i = (0, 0, 0)$ with the neighbours $(2, 0, 0)$, $(0, 2, 0)$, $(0, 0, 2)$ and
# their opposites. The eight tetrahedra have the volume $V = \tfrac86 = \tfrac43$. For the first
# one, (8.4) is $2 p_1 = 2 p_2 = 2 p_3 = 2$, so its circumcentre is $(1, 1, 1)$, and the cell is the
# cube $[-1, 1]^3$.
#
# At $\mathbf{x} = (\tfrac12, 0, 0)$ the factors of (8.2) for the corner $(1, 1, 1)$ are
# $2 \cdot \tfrac12 = 1$, $2$ and $2$, so its weight is $8/4 = 2$. For the corner $(-1, 1, 1)$ they
# are $(-2) \cdot (-\tfrac32) = 3$, $2$ and $2$, so its weight is $8/12 = \tfrac23$. Four corners
# have the weight 2 and four have $\tfrac23$, with the sum $\tfrac{32}{3}$. The coordinates, weight
# by sum, are $\tfrac{3}{16}$ and $\tfrac{1}{16}$. The next cell checks that the mean of the corners
# with these coordinates is $\mathbf{x}$.

# %%
cube = np.array([(x, y, z) for x in (1, -1) for y in (1, -1) for z in (1, -1)])
omega_by_hand = np.where(cube[:, 0] > 0, 3, 1) / 16
print("sum", omega_by_hand.sum(), "and mean of the corners", omega_by_hand @ cube)

# %% [markdown]
# Here is a finished function of the kind that you will write. It works with differences of points,
# so it keeps its accuracy far from the origin.


# %%
def edge_lengths(center, neighbors):
    """Return l_b = |x_b - x_i| for all neighbours, of shape (N,).

    center (3,) is x_i, and neighbors (N, 3) are all x_b.
    """
    return np.linalg.norm(neighbors - center, axis=1)


print(edge_lengths(np.array([1, 1, 1]), np.array([[3, 1, 1], [1, 4, 5]])))

# %% [markdown]
# ### 08.1 The volume
#
# Write a function that returns $V$ of (8.3). A volume must be positive for every order of the
# corners. The tetrahedron may be nearly flat, and three of its corners may lie nearly on a line.
# Here and in the other questions of this notebook the points may have any unit of length and may be
# far from the origin, up to $10^9$ times as far as from each other, so use differences of points.


# %% question="08.1" minutes=15
def volume(a, b, c, d):
    """Return V of (8.3), a number, for corners a, b, c, d, each of shape (3,)."""
    # BEGIN SOLUTION
    return abs(np.linalg.det([b - a, c - a, d - a])) / 6
    # END SOLUTION


# %%
check("08.1")

# %% [markdown]
# ### 08.2 The circumcentre
#
# Write a function that returns $\mathbf{p}$ of (8.4). It must keep its accuracy for tetrahedra far
# from the origin. The point is the circumcentre of 06.4 and 07.2, now in space. If you have written
# one of them, you may copy your function and add one edge.
#
# <details><summary>Hint</summary>
#
# The unknown of (8.4) is $\mathbf{p} - \mathbf{a}$. Differences of squares of the coordinates
# themselves lose digits by cancellation.
#
# </details>


# %% question="08.2" minutes=5
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
# **08.3** Derive the *outward unit* normal $\mathbf{n}_b$ of face $b$ of the Voronoi cell, with the
# length $l_b = \lVert \mathbf{x}_b - \mathbf{x}_i \rVert$ of the edge. Begin with the points
# $\mathbf{y}$ of the face: they have the same distance from $\mathbf{x}_i$ and from $\mathbf{x}_b$.
#
# <details><summary>Hint</summary>
#
# Write $\mathbf{y} - \mathbf{x}_b = (\mathbf{y} - \mathbf{x}_i) - (\mathbf{x}_b - \mathbf{x}_i)$
# before you square.
#
# </details>

# %% [markdown] answer="08.3" points=2 minutes=5 words=30
# Squared and expanded, $\lVert\mathbf{y} - \mathbf{x}_i\rVert = \lVert\mathbf{y} -
# \mathbf{x}_b\rVert$ is $(\mathbf{x}_b - \mathbf{x}_i)^T(\mathbf{y} - \mathbf{x}_i) = \tfrac12
# l_b^2$. This is a plane perpendicular to the edge, so $\mathbf{n}_b = (\mathbf{x}_b -
# \mathbf{x}_i)/l_b$. It points outwards: at $\mathbf{x}_i$, inside the cell, the left side is
# smaller, zero.
#
# *Beyond the question.* The plane passes through the midpoint of the edge, where $\mathbf{y} -
# \mathbf{x}_i$ is half of $\mathbf{x}_b - \mathbf{x}_i$.

# %% [markdown] rubric="08.3"
# One point for the plane, from equal distances to $\mathbf{x}_i$ and $\mathbf{x}_b$. One for the
# normal along the edge, of length one, with a reason why it points outwards.

# %% [markdown]
# ## Step 2: the volume of the normals
#
# ### 08.4 The determinant of the normals
#
# Write a function that computes $\operatorname{vol}(\mathcal{N}_a)$ from its definition (8.1), with
# the normals of step 1, for one tetrahedron. The edges may be close to one plane, but the volume of
# their normals is at least 0.01.


# %% question="08.4" minutes=10
def volume_of_normals(center, tips):
    """Return vol(N_a) of (8.1), a number.

    center (3,) is x_i, and the rows of tips (3, 3) are x_j, x_k, x_m.
    """
    # BEGIN SOLUTION
    normals = [edge / np.linalg.norm(edge) for edge in tips - center]
    return abs(np.linalg.det(normals))
    # END SOLUTION


# %%
check("08.4")

# %% [markdown]
# The next picture tests the conjecture that $\operatorname{vol}(\mathcal{N}_a)$ equals
# $6V_a/(l_j\, l_k\, l_m)$, for your own tetrahedra and for random ones. The slider changes the
# power of the lengths.


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
# **08.5** Prove that $\operatorname{vol}(\mathcal{N}_a) = 6 V_a / (l_j\, l_k\, l_m)$. State which
# rule for determinants you use, and where the factor 6 comes from.
#
# <details><summary>Hint</summary>
#
# What happens to a determinant if one row is divided by a number? How many tetrahedra of equal
# volume fill the parallelepiped of three edges?
#
# </details>

# %% [markdown] answer="08.5" points=3 minutes=10 words=60
# By step 1 the rows are $\mathbf{n}_b = (\mathbf{x}_b - \mathbf{x}_i)/l_b$. A determinant is linear
# in each row, so each length can be taken out:
#
# $$ \det(\mathbf{n}_j, \mathbf{n}_k, \mathbf{n}_m) = \frac{\det(\mathbf{x}_j - \mathbf{x}_i,
#    \mathbf{x}_k - \mathbf{x}_i, \mathbf{x}_m - \mathbf{x}_i)}{l_j l_k l_m} . $$
#
# Lengths are positive, so this holds for the absolute values. The absolute value on the right is
# the volume of the parallelepiped of the three edges. It consists of $3! = 6$ tetrahedra of equal
# volume, so it is $6V_a$.
#
# *Beyond the question.* There is one tetrahedron for each order of the three edges. Another reason
# for the 6: the volume of a tetrahedron is a third of base times height, and its base is half a
# parallelogram.

# %% [markdown] rubric="08.5"
# One point for taking one length out of each row. One for the determinant of the edges as the
# volume of a parallelepiped, with the absolute value. One for the six, with a reason.

# %% [markdown]
# ## Step 3: the lengths cancel
#
# **08.6** Substitute steps 1 and 2 into (8.1) and derive (8.2). Explain why the same lengths appear
# in the numerator and in the denominator.

# %% [markdown] answer="08.6" points=3 minutes=10 words=50
# By step 1 each factor of the denominator is $\mathbf{n}_b^T(\mathbf{p}_a - \mathbf{x}) =
# (\mathbf{x}_b - \mathbf{x}_i)^T(\mathbf{p}_a - \mathbf{x})/l_b$. The faces at $\mathbf{p}_a$
# belong to the neighbours $j, k, m$ of tetrahedron $a$, whose four vertices have equal distances
# from $\mathbf{p}_a$. So the denominator has the factor $1/(l_j l_k l_m)$. By step 2 the numerator
# has it too, and it cancels.

# %% [markdown] rubric="08.6"
# One point for each factor with its $1/l_b$. One for the reason: the three faces at the corner
# belong to the three other vertices of the tetrahedron. One for the cancellation of $l_j l_k l_m$.

# %% [markdown]
# ### 08.7 The weights
#
# Write a function that returns the weights (8.2) of all corners for one point. The mesh is given in
# the usual form: an array of neighbours and, for each tetrahedron, the three indices of its
# vertices other than $\mathbf{x}_i$, in any order. The point may lie outside the cell; some weights
# are negative there. It does not lie in the plane of a face, where (8.2) divides by zero.


# %% question="08.7" minutes=15
def weights(center, neighbors, cells, corners, x):
    """Return w_a of (8.2) for all T tetrahedra, of shape (T,), at one point x (3,).

    center (3,) is x_i, neighbors (N, 3) are all x_b, a row of cells (T, 3) holds the
    numbers j, k, m of a tetrahedron, and corners (T, 3) are the circumcentres p_a.
    """
    # BEGIN SOLUTION
    w = np.empty(len(cells))
    for a, cell in enumerate(cells):
        edges = neighbors[cell] - center
        denominator = np.prod(edges @ (corners[a] - x))
        w[a] = 6 * volume(center, *neighbors[cell]) / denominator
    return w
    # END SOLUTION


# %%
check("08.7")


# %% [markdown]
# ## A test of linear precision
#
# Weights give coordinates only if $\sum_a \omega_a \mathbf{p}_a = \mathbf{x}$ with
# $\omega_a = w_a / \sum_e w_e$. This requirement is called *linear precision*. The next picture
# shows its largest violation at forty points in three cells: for your weights, for weights without
# the volumes, and for weights with the sign of the determinant.


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
        errors = []
        for mix in random.dirichlet(np.ones(len(cells)), 40):
            point = mix @ corners
            w = weights(center, neighbors, cells, corners, point)
            variants = (w, w / sizes, w * signs)
            errors.append([np.linalg.norm(v @ corners / v.sum() - point) for v in variants])
        worst.append(np.maximum(np.max(errors, axis=0), 1e-17))
    with figure(6.4, 2.9) as page:
        axes = page.subplots()
        names = ("yours", "without volumes", "with signs")
        styles = zip(names, (BLUE, ORANGE, PURPLE), np.transpose(worst), (-0.12, 0, 0.12))
        for name, color, errors, aside in styles:
            axes.plot(np.arange(3) + aside, errors, "o", color=color, ms=8, label=name)
        axes.set_yscale("log")
        axes.set_xticks(range(3), list(stars))
        axes.set(ylim=(1e-17, 1e3), xlim=(-0.5, 2.5), ylabel="largest error")
        axes.grid(axis="y", alpha=0.3)
        axes.legend(loc="center left", bbox_to_anchor=(1, 0.5))
    return page


# %% [markdown]
# **What to look at.** Your weights are accurate to rounding in all three cells. In the octahedron
# all volumes are equal, so weights without volumes are right there as well: a regular example
# proves little. The tetrahedra have no common orientation, so weights with a sign are wrong in all
# three cells.
#
# ## Step 4: no circumcentres
#
# The factors of (8.2) can be computed without the circumcentre:
#
# $$ (\mathbf{x}_b - \mathbf{x}_i)^T(\mathbf{p}_a - \mathbf{x}) = h_b(\mathbf{x}), \qquad
#    h_b(\mathbf{x}) = \tfrac12 l_b^2 - (\mathbf{x}_b - \mathbf{x}_i)^T(\mathbf{x} - \mathbf{x}_i) .
#    \tag{8.5} $$
#
# In the worked example $h_b = 2 - (\mathbf{x}_b)^T\mathbf{x}$ is 1 for the neighbour $(2, 0, 0)$, 3
# for $(-2, 0, 0)$, and 2 for the others.
#
# ### 08.8 The heights
#
# Write a function that returns $h_b$ for all neighbours and many points. Divided by $l_b$, it is
# the distance of the point from the plane of face $b$, positive inside the cell.


# %% question="08.8" minutes=10
def heights(center, neighbors, x):
    """Return h_b of (8.5) at points x (M, 3), of shape (N, M): a row for each neighbour."""
    # BEGIN SOLUTION
    return np.array([s @ s / 2 - (x - center) @ s for s in neighbors - center])
    # END SOLUTION


# %%
check("08.8")

# %% [markdown]
# The next picture follows a point along a line from inside your cell through corner 0 to the
# outside. The line is your $h_b$. The markers are the left side of (8.5), computed from each corner
# of face $b$ in turn. Which neighbours have $h_b = 0$ at corner 0?


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
            xlabel="position: vertex at 0, corner 0 at 1",
            ylabel=f"$h_{b}$ on the line",
        )
        axes.legend(loc="center left", bbox_to_anchor=(1, 0.5))
    return page


# %% [markdown]
# **08.9** Prove (8.5) for every point $\mathbf{x}$ and every corner $a$ of face $b$.
#
# <details><summary>Hint</summary>
#
# Begin with $\mathbf{x} = \mathbf{x}_i$: then (8.5) is one of the equations (8.4). How do both
# sides change as $\mathbf{x}$ moves?
#
# </details>

# %% [markdown] answer="08.9" points=3 minutes=10 words=40
# Begin with $\mathbf{x} = \mathbf{x}_i$. The circumcentre has the same distance from $\mathbf{x}_b$
# and $\mathbf{x}_i$: $\lVert\mathbf{p}_a - \mathbf{x}_i\rVert^2 = \lVert(\mathbf{p}_a -
# \mathbf{x}_i) - (\mathbf{x}_b - \mathbf{x}_i)\rVert^2$. Expanded, this is $(\mathbf{x}_b -
# \mathbf{x}_i)^T(\mathbf{p}_a - \mathbf{x}_i) = \tfrac12 l_b^2$. For any other point subtract
# $(\mathbf{x}_b - \mathbf{x}_i)^T(\mathbf{x} - \mathbf{x}_i)$ from both sides: this gives (8.5).
#
# *Beyond the question.* The right side of (8.5) does not depend on $a$: $h_b$ is the same number
# from every corner of the face. By (8.5) the weights need heights and volumes, and no
# circumcentres. So a large error in the circumcentre of a *sliver*, a tetrahedron so flat that
# rounding errors spoil it, does no harm. A second consequence is that no division by zero remains
# on faces if the weights are multiplied by $\prod_b h_b$.

# %% [markdown] rubric="08.9"
# One point for the equation of equal distances. One for expanding it, which is the case $\mathbf{x}
# = \mathbf{x}_i$. One for the general point.

# %% [markdown]
# ### 08.10 Coordinates without division
#
# Multiply all weights (8.2) by the product of all heights, and divide them by 6. The ratios do not
# change, and all denominators cancel:
#
# $$ \omega_a = \frac{c_a}{\sum_e c_e}, \qquad c_a(\mathbf{x}) = V_a \prod_{b \,\notin\, \{j, k,
#    m\}} h_b(\mathbf{x}) . \tag{8.6} $$
#
# Write a function that returns these coordinates for many points, at which the sum is not zero. In
# the worked example $c = \tfrac43 \cdot 3 \cdot 2 \cdot 2 = 16$ for four corners and $\tfrac43
# \cdot 1 \cdot 2 \cdot 2 = \tfrac{16}{3}$ for the other four.


# %% question="08.10" minutes=15
def coordinates(center, neighbors, cells, x):
    """Return ω_a of (8.6) at points x (M, 3), of shape (M, T): a row for each point.

    The points may lie inside, on faces, in corners and outside, and the cell may have any
    size, such as 1e-9. (Such a small cell has at most ten faces: a product of many more
    tiny heights is rounded to zero.)
    """
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
# ## The coordinates of a moving point
#
# The picture shows your own Voronoi cell. The orange point moves along a line from one corner
# through the centre to the opposite face. The areas of the blue dots are the coordinates, and the
# purple ring is at $\sum_a \omega_a \mathbf{p}_a$.


# %%
@draw(
    along=Slider(0, 1, 0.3, "position", steps=20),
    angle=Slider(0, 180, 30, "rotation", steps=36),
)
def walk(along, angle):
    center, neighbors, cells, corners, _ = data("08.7")
    reach = heights(center, neighbors, np.array([center, 2 * center - corners[0]]))
    slope = (reach[:, 0] - reach[:, 1]) / reach[:, 0]
    far = center - (corners[0] - center) / slope.max()
    point = (1 - along) * corners[0] + along * far
    (omega,) = coordinates(center, neighbors, cells, point[None])
    with figure(6.4, 3.8) as page:
        axes = page.subplots()
        draw_edges(axes, corners - center, sharing(cells), angle, GREY)
        across, up, _ = projection(corners - center, angle)
        axes.scatter(across, up, s=900 * np.clip(omega, 0, 1), color=BLUE, alpha=0.75, lw=0)
        axes.plot([], [], "o", color=BLUE, alpha=0.75, label="coordinate (area)")
        (right,), (height,), _ = projection((point - center)[None], angle)
        axes.plot(right, height, "o", color=ORANGE, ms=8, label=r"$\mathbf{x}$")
        (right,), (height,), _ = projection((omega @ corners - center)[None], angle)
        ring = dict(mfc="none", color=PURPLE, ms=14, mew=1.5, ls="none")
        axes.plot(right, height, "o", label=r"$\sum_a \omega_a \mathbf{p}_a$", **ring)
        extremes = f"largest {omega.max():.2f}, smallest {omega.min():.2f}"
        axes.set_title(extremes.replace("-0.00", "0.00"))
        axes.set_aspect("equal")
        axes.axis("off")
        axes.legend(loc="center left", bbox_to_anchor=(1, 0.5), labelspacing=1.2)
    return page


# %% [markdown]
# **What to look at.** At the start one corner has the coordinate 1. At the end, on a face, only the
# corners of this face have coordinates other than zero. By linear precision the ring must stay
# around the point.
#
# ## Dig deeper
#
# - Prove linear precision, $\sum_a w_a(\mathbf{x})(\mathbf{p}_a - \mathbf{x}) = \mathbf{0}$. Hint:
#   the points $\mathbf{n}_b / (\mathbf{n}_b^T(\mathbf{p}_a - \mathbf{x}))$ are the corners of a
#   closed polyhedron, the *polar dual*. It has one triangle for each $a$, perpendicular to
#   $\mathbf{p}_a - \mathbf{x}$. Over a closed surface the normals times the areas sum to zero.
# - Which steps of the proof change in two dimensions, and which in $D$ dimensions? What replaces 6?
# - A vertex on the boundary of the mesh has no closed cell. Leave out one tetrahedron. Must the
#   coordinates still sum to one? Is a linear field still reproduced?
# - Divide a cube into six tetrahedra around a diagonal. All circumcentres coincide. Which sums of
#   coordinates are well defined, and which known formula do they give?
#
# **Next**: notebook 13 interpolates a field at departure points; notebook 14 treats meshes with
# errors.

# %%
progress()
