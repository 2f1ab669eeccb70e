"""What only a grader tries in notebook 01."""

import numpy as np

from fieldcheck.calls import Call
from fieldgrade.authoring.hidden_cases import hidden


@hidden("01.1", "It must hold in every dimension, and for any number of points.")
def matrix_in_four_dimensions(seed):
    random = np.random.default_rng(seed)
    return (
        Call("basis_matrix", (random.normal(size=(3, 4)),), "three points in four dimensions"),
        Call("basis_matrix", (random.normal(size=(1, 5)),), "one point in five dimensions"),
        Call("basis_matrix", (random.normal(size=(5, 4)),), "five points in four dimensions"),
    )


@hidden(
    "01.1", "It must be right for all coordinates, in every unit, near and far from the origin."
)
def matrix_in_other_units(seed):
    random = np.random.default_rng(seed + 3)
    return (
        Call("basis_matrix", (1e-11 * random.normal(size=(5, 2)),), "a square of 1e-11"),
        Call("basis_matrix", (1e-9 * random.normal(size=(4, 3)),), "a cube of 1e-9"),
        Call("basis_matrix", (1e5 * random.normal(size=(5, 2)),), "points far away"),
        Call("basis_matrix", (1e8 * random.normal(size=(6, 3)),), "points very far away"),
        Call("basis_matrix", (np.insert(random.normal(size=(4, 2)), 0, 1, axis=1),), "x₁ = 1"),
    )


@hidden("01.2", "It must hold in every dimension, and for other numbers of points than the shown.")
def in_four_dimensions(seed):
    random = np.random.default_rng(seed + 1)
    points = random.random((40, 4))
    return (Call("fit", (points, random.normal(size=40)), "forty points in four dimensions"),)


@hidden("01.2", "It must be right for values of every size, and for every unit of length.")
def fit_in_other_units(seed):
    random = np.random.default_rng(seed + 4)
    plane, space = random.random((11, 2)), random.random((13, 3)) - 0.4
    return (
        Call("fit", (plane, 1e-10 * random.normal(size=11)), "values of size 1e-10"),
        Call("fit", (space, 1e-10 * random.normal(size=13)), "small values in space"),
        Call("fit", (plane, 1e9 * random.normal(size=11)), "values of size 1e9"),
        Call("fit", (300 * plane, random.normal(size=11)), "points in a square of 300"),
    )


def fields_in_other_units(name, seed):
    random = np.random.default_rng(seed)
    c, d = random.normal(size=3), random.normal(size=5)
    plane, points = random.normal(size=(5, 2)), random.normal(size=(6, 4))
    return (
        Call(name, (1e-10 * c, plane), "small coefficients"),
        Call(name, (1e-9 * d, points), "small coefficients in four dimensions"),
        Call(name, (1e5 * c, plane), "large coefficients"),
        Call(name, (1e6 * d, points), "large coefficients in four dimensions"),
        Call(name, (c, 1e5 * plane), "far from the origin"),
        Call(name, (d, 1e6 * points), "far from the origin in four dimensions"),
        Call(name, (c, 1e-9 * plane), "near the origin"),
        Call(name, (d[:2], plane[:, :1]), "on the line"),
    )


@hidden(
    "01.3", "It must be right in every dimension, for coefficients and coordinates of any size."
)
def values_in_other_units(seed):
    return fields_in_other_units("evaluate", seed + 5)


@hidden(
    "01.5", "It must be right in every dimension, for coefficients and coordinates of any size."
)
def gradients_in_other_units(seed):
    return fields_in_other_units("gradient", seed + 6)


@hidden("01.6", "It must be right for values of every size, and in every dimension.")
def objective_of_small_and_large_values(seed):
    random = np.random.default_rng(seed + 7)
    plane, points = random.random((6, 2)), random.normal(size=(9, 4))
    c, d = random.normal(size=3), random.normal(size=5)
    values, more = random.normal(size=6), random.normal(size=9)
    return (
        Call("objective", (plane, 1e-7 * values, 1e-7 * c), "small values"),
        Call("objective", (points, 1e-8 * more, 1e-8 * d), "small values in four dimensions"),
        Call("objective", (plane, 1e6 * values, 1e6 * c), "large values"),
        Call("objective", (points[:, :1], more, d[:2]), "points on the line"),
        Call("objective", (random.random((25, 2)), random.normal(size=25), c), "many points"),
        Call("objective", (plane[[0, 1, 2, 1]], values[[0, 1, 2, 1]], c), "a repetition", (0, 1)),
    )


@hidden("01.4", "It must hold in every dimension.")
def in_four_and_five_dimensions(seed):
    random = np.random.default_rng(seed + 8)
    flat = random.normal(size=(9, 3)) @ random.normal(size=(3, 4))
    return (
        Call("rank", (random.random((8, 4)),), "eight points in four dimensions"),
        Call("rank", (flat,), "nine points of a hyperplane in four dimensions", exact=(0,)),
        Call("rank", (random.random((9, 5)),), "nine points in five dimensions"),
    )


@hidden("01.4", "The rank must not depend on the unit of length.")
def tiny_and_huge(seed):
    random = np.random.default_rng(seed + 2)
    line = random.normal(size=2) + random.normal(size=(7, 1)) * random.normal(size=2)
    return (
        Call("rank", (1e-3 * random.random((6, 2)),), "points in millimetres"),
        Call("rank", (1e5 * line,), "points on a line of many kilometres", exact=(0,)),
    )
