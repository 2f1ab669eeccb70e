"""What only a grader tries in notebook 06."""

import numpy as np

from fieldcheck.calls import Call
from fieldcheck.questions.q05_edges import mesh
from fieldcheck.questions.q06_cell_velocities import (
    normal_velocities,
    obtuse,
    projections,
    small_at_a_place,
    triangle,
)
from fieldgrade.authoring.hidden_cases import hidden


def right_angle(random, size):
    """Return the corners of a triangle with a right angle, turned, in one order or the other."""
    z = (
        size
        * np.exp(6j * random.random())
        * np.array([0, random.uniform(1, 2), 1j * random.uniform(1, 2)])
    )
    q = np.stack([z.real, z.imag], axis=1) + random.normal(size=2)
    return q[random.permutation(3)]


@hidden("06.1", "It must hold for triangles of every size and shape, listed either way.")
def of_every_size(seed):
    random = np.random.default_rng(seed + 1)
    return tuple(
        Call("outward_normals", (right_angle(random, size),), "a triangle")
        for size in (1e-4, 1.0, 1e3)
    )


@hidden(
    "06.2",
    "It must hold for triangles of every size and shape, and for data free of divergence too.",
)
def of_a_right_angle(seed):
    random = np.random.default_rng(seed + 2)
    return tuple(
        Call("cell_velocity", (right_angle(random, size), random.normal(size=3)), "a triangle")
        for size in (1e-3, 1.0, 1e2)
    ) + (
        Call(
            "cell_velocity",
            (obtuse(random) * [1, 2e-3], random.normal(size=3)),
            "a very flat triangle",
        ),
    )


@hidden("06.3", "The defect does not depend on the unit of length.")
def defect_in_other_units(seed):
    random = np.random.default_rng(seed + 3)
    corners = [right_angle(random, size) for size in (1e-3, 1e2)]
    return tuple(Call("defect", (q, normal_velocities(random, q)), "a triangle") for q in corners)


@hidden("06.3", "It must hold for data without net outflow too.")
def defect_of_a_constant_flow(seed):
    random = np.random.default_rng(seed + 8)
    corners = [right_angle(random, 1.0), 100 * obtuse(random)]
    return tuple(Call("defect", (q, projections(q)), "a constant flow") for q in corners)


@hidden(
    "06.4",
    "It must hold for right angles, where it is the middle of a side, near them, and if small.",
)
def circumcentre_of_a_right_angle(seed):
    random = np.random.default_rng(seed + 4)
    nearly = right_angle(random, 1.0) + 3e-4 * random.uniform(-1, 1, (3, 2))
    return (
        *(Call("circumcenter", (right_angle(random, size),), "a triangle") for size in (1e-2, 1.0)),
        Call("circumcenter", (nearly,), "nearly a right angle"),
        Call(
            "circumcenter",
            (small_at_a_place(random, triangle(random, True), 2.0**-25),),
            "a tiny triangle",
            exact=(0,),
        ),
    )


@hidden("06.5", "The number s may be negative, and there may be one point only.")
def inflow(seed):
    random = np.random.default_rng(seed + 7)
    return (
        Call("truth", (random.normal(size=(1, 2)), random.normal(size=2), -1.3), "one point"),
        *(
            Call("truth", (random.normal(size=(n, 2)), random.normal(size=2), 0.73), f"{n} points")
            for n in (67, 101)
        ),
    )


@hidden("06.6", "It must hold for every mesh, and for any rate of expansion.")
def of_two_cells(seed):
    random = np.random.default_rng(seed + 5)
    points = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]) + random.uniform(
        -0.2, 0.2, (4, 2)
    )
    return (
        Call("errors", (points, np.array([[0, 1, 2], [3, 0, 2]]), -1.7), "two cells"),
        Call("errors", (*mesh(random, 6, 6), 0.66), "a mesh of 74 triangles"),
    )


@hidden("06.6", "It must hold for a small mesh, which is far from the origin in units of its size.")
def of_a_small_mesh(seed):
    random = np.random.default_rng(seed + 9)
    points, triangles = mesh(random, 2, 2)
    small = small_at_a_place(random, points, 2.0**-14)
    return (Call("errors", (small, triangles, -0.9), "a small mesh", exact=(0,)),)


@hidden("06.8", "It must hold outside of the triangle too, and at a corner.")
def at_a_corner(seed):
    random = np.random.default_rng(seed + 6)
    q = right_angle(random, 1.0)
    return (
        Call("raviart_thomas", (q, random.normal(size=3), q[2].copy()), "a corner"),
        Call(
            "raviart_thomas",
            (q, random.normal(size=3), 5 * random.normal(size=2)),
            "a point far outside",
        ),
        Call(
            "raviart_thomas",
            (q[::-1].copy(), random.normal(size=3), random.normal(size=2)),
            "the same triangle, listed the other way round",
        ),
    )
