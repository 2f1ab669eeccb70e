"""What only a grader tries in notebook 02."""

import numpy as np

from fieldcheck.calls import Call
from fieldcheck.questions.q02_prediction_errors import measured_twice
from fieldgrade.authoring.hidden_cases import hidden


@hidden("02.1", "It must hold in every dimension, on the line too.")
def on_the_line_and_in_four_dimensions(seed):
    random = np.random.default_rng(seed + 1)
    return tuple(
        Call("weights", (random.normal(size=(6, d)), random.normal(size=d), 0.7), f"dimension {d}")
        for d in (1, 4)
    )


@hidden("02.1", "It must hold for any number of points.")
def many_points(seed):
    random = np.random.default_rng(seed + 10)
    given = random.normal(size=(71, 3)), random.normal(size=3), 0.7
    return (Call("weights", given, "many points in space"),)


@hidden(
    "02.2", "It must hold in every dimension, and a common factor of the weights must not matter."
)
def line_and_tiny_weights(seed):
    random = np.random.default_rng(seed + 2)
    line, space = random.random((9, 1)), random.random((30, 4))
    return (
        Call("weighted_fit", (line, random.normal(size=9), random.uniform(1, 2, 9)), "a line"),
        Call(
            "weighted_fit",
            (space, random.normal(size=30), 1e-3 * random.uniform(1, 2, 30)),
            "tiny weights",
        ),
    )


@hidden(
    "02.4",
    "The field must be right for one evaluation point, for points on a line, at a measured point, "
    "and far outside of the points.",
)
def unusual_places(seed):
    random = np.random.default_rng(seed + 3)
    line, plane = random.random((10, 1)), random.random((20, 2))
    close = 1e-3 * random.random((4, 2))
    return (
        Call(
            "field",
            (line, random.normal(size=10), random.random((1, 1)), 0.2),
            "one evaluation point on a line",
        ),
        Call("field", (plane, random.normal(size=20), plane[3:5].copy(), 0.1), "measured points"),
        Call("field", (plane, random.normal(size=20), 3 + random.random((4, 2)), 0.3), "outside"),
        Call("field", (plane, random.normal(size=20), 0.4 + close, 0.2), "points close together"),
    )


@hidden("02.4", "It must hold for any number of evaluation points and of measurements.")
def many_evaluation_points(seed):
    random = np.random.default_rng(seed + 8)
    given = random.random((43, 3)), random.normal(size=43), random.random((71, 3)), 0.4
    return (Call("field", given, "many evaluation points in space"),)


@hidden("02.7", "It must hold for any number of evaluation points and of measurements.")
def many_gradients(seed):
    random = np.random.default_rng(seed + 9)
    given = random.random((43, 2)), random.normal(size=43), random.random((71, 2)), 0.4
    return (Call("gradient", given, "many evaluation points in the plane"),)


@hidden("02.5", "It must hold on the line, and for other ε than the shown.")
def objective_on_the_line(seed):
    random = np.random.default_rng(seed + 4)
    given = (
        random.random((8, 1)),
        random.normal(size=8),
        random.random(1),
        0.15,
        random.normal(size=2),
    )
    return (Call("objective", given, "a line"),)


@hidden("02.7", "It must hold in every dimension.")
def gradient_in_four_dimensions(seed):
    random = np.random.default_rng(seed + 10)
    return tuple(
        Call(
            "gradient",
            (random.random((40, d)), random.normal(size=40), random.random((3, d)), 0.6),
            f"forty points in {words} dimensions",
        )
        for d, words in ((4, "four"), (5, "five"))
    )


@hidden("02.7", "It must hold on the line, at a single point, and for other ε than the shown.")
def gradient_on_the_line(seed):
    random = np.random.default_rng(seed + 5)
    given = (random.random((10, 1)), random.normal(size=10), random.random((1, 1)), 0.2)
    return (Call("gradient", given, "one evaluation point on a line"),)


@hidden(
    "02.8", "For n = 1 the field is affine, and both methods are exact; for large n they are not."
)
def first_and_eighth_power(seed):
    random = np.random.default_rng(seed + 6)
    points, queries = random.random((60, 2)), random.random((12, 2))
    return tuple(Call("errors", (points, queries, n, 0.15), f"n = {n}") for n in (1, 8))


@hidden(
    "02.9",
    "It must hold on a line, for many points, and where two measurements have the same point.",
)
def many_on_the_line(seed):
    random = np.random.default_rng(seed + 7)
    line = (np.arange(30) + random.random(30)) / 30
    return (
        Call("leave_one_out", (line[:, None], random.normal(size=30), 0.1), "a line"),
        Call(
            "leave_one_out",
            (*measured_twice(random, (3, 2, 3)), 0.4),
            "a grid in space, two points measured twice",
            exact=(0, 1),
        ),
    )
