"""What only a grader tries in notebook 03."""

import numpy as np

from fieldcheck.calls import Call
from fieldcheck.questions.q03_radial_basis_functions import at_distance_one, cloud, with_zeros
from fieldgrade.authoring.hidden_cases import hidden


@hidden("03.1", "A single vector is an array of vectors too, and the dimension may be any.")
def one_vector(seed):
    random = np.random.default_rng(seed + 1)
    return (
        Call("kernel", (random.normal(size=5),), "one vector in five dimensions"),
        Call("kernel", (random.normal(size=(4, 1)),), "four vectors on the line"),
        Call("kernel", (1e-9 * random.normal(size=(3, 2)),), "very short vectors"),
    )


@hidden("03.2", "It must hold in every dimension.")
def in_four_dimensions(seed):
    points = cloud(np.random.default_rng(seed + 2), 9, 4)
    return (Call("system_matrix", (points,), "nine points in four dimensions"),)


@hidden("03.1", "It must hold for any number of vectors.")
def a_large_table(seed):
    table = np.random.default_rng(seed + 7).normal(size=(17, 19, 3))
    return (Call("kernel", (table,), "a table of seventeen times nineteen vectors"),)


@hidden("03.2", "It must hold for any number of points.")
def many_points(seed):
    random = np.random.default_rng(seed + 8)
    return (
        Call("system_matrix", (cloud(random, 43, 2),), "forty-three points"),
        Call("system_matrix", (cloud(random, 45, 3),), "forty-five points in space"),
    )


@hidden("03.4", "It must hold for any number of centres and of evaluation points.")
def many_evaluation_points(seed):
    random = np.random.default_rng(seed + 9)
    points, lam, c = cloud(random, 45, 3), random.normal(size=45), random.normal(size=4)
    return (Call("evaluate", (points, lam, c, random.random((71, 3))), "many points in space"),)


@hidden("03.6", "It must hold for any number of centres and of evaluation points.")
def many_gradients(seed):
    random = np.random.default_rng(seed + 10)
    points, lam, c = cloud(random, 43, 2), random.normal(size=43), random.normal(size=3)
    return (Call("gradient", (points, lam, c, random.random((71, 2))), "many points"),)


@hidden("03.6", "It must hold in every dimension.")
def gradients_in_four_dimensions(seed):
    random = np.random.default_rng(seed + 11)
    return tuple(
        Call(
            "gradient",
            (
                cloud(random, 12, d),
                random.normal(size=12),
                random.normal(size=d + 1),
                random.random((5, d)),
            ),
            f"twelve centres in {words} dimensions",
        )
        for d, words in ((4, "four"), (5, "five"))
    )


@hidden("03.3", "It must hold for other numbers of points and other dimensions than the shown.")
def on_the_line(seed):
    random = np.random.default_rng(seed + 3)
    return (
        Call(
            "coefficients", (cloud(random, 9, 1), random.normal(size=9)), "nine points on the line"
        ),
        Call("coefficients", (cloud(random, 40, 2), random.normal(size=40)), "forty points"),
        Call("coefficients", (cloud(random, 9, 1), np.full(9, 0.7)), "equal values on the line"),
        Call(
            "coefficients",
            (cloud(random, 8, 2), with_zeros(random.normal(size=8), 2, 6)),
            "eight values, two of them zero",
        ),
        Call(
            "coefficients",
            (at_distance_one(random, 3), random.normal(size=7)),
            "a point of space and its neighbours at distance one",
            exact=(0,),
        ),
    )


@hidden(
    "03.4", "Evaluation points may coincide with all centres, and there may be one of them only."
)
def at_the_points_themselves(seed):
    random = np.random.default_rng(seed + 4)
    points, c = cloud(random, 20, 2), random.normal(size=3)
    lam = random.normal(size=20)
    return (
        Call("evaluate", (points, lam, c, points), "the points themselves", exact=(0, 3)),
        Call("evaluate", (points, lam, c, random.random((1, 2))), "one evaluation point"),
    )


@hidden(
    "03.6", "Evaluation points may coincide with all centres, and there may be one of them only."
)
def gradient_at_the_points_themselves(seed):
    random = np.random.default_rng(seed + 5)
    points, c = cloud(random, 20, 2), random.normal(size=3)
    lam = random.normal(size=20)
    return (
        Call("gradient", (points, lam, c, points), "the points themselves", exact=(0, 3)),
        Call("gradient", (points, lam, c, random.random((1, 2))), "one evaluation point"),
    )


@hidden("03.5", "Points of space may lie in one plane.")
def in_one_plane_of_space(seed):
    random = np.random.default_rng(seed + 6)
    flat = cloud(random, 8, 2) @ np.linalg.qr(random.normal(size=(3, 3)))[0][:2]
    return (Call("inertia", (flat,), "eight points in one plane of space", exact=(0,)),)
