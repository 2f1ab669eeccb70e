"""What only a grader tries in notebook 04."""

import numpy as np

from fieldcheck.calls import Call
from fieldcheck.questions.q03_radial_basis_functions import cloud
from fieldcheck.questions.q04_rank_of_normals import (
    across,
    directions,
    flow,
    perpendicular_vectors,
)
from fieldgrade.authoring.hidden_cases import hidden


@hidden("04.1", "It must hold in every dimension, and for any number of samples.")
def in_four_dimensions(seed):
    random = np.random.default_rng(seed + 1)
    return (
        Call(
            "velocity_matrix",
            (random.normal(size=(3, 4)), random.normal(size=(3, 4))),
            "four dimensions",
        ),
        Call(
            "velocity_matrix",
            (random.normal(size=(1, 2)), random.normal(size=(1, 2))),
            "one sample",
        ),
        Call(
            "velocity_matrix",
            (random.normal(size=(2, 5)), random.normal(size=(2, 5))),
            "five dimensions",
        ),
        Call("velocity_matrix", (cloud(random, 101, 2), directions(random, 101)), "101 samples"),
    )


@hidden("04.2", "Any affine flow may be the one that is not seen, near the origin and far from it.")
def hidden_flows(seed):
    random = np.random.default_rng(seed + 2)
    points = cloud(random, 20, 2)
    blind, name = perpendicular_vectors(points, flow(random)), "velocity_rank"
    return (
        Call(name, (points, blind), "twenty samples that hide a flow", exact=(0, 1)),
        Call(
            name,
            (50 + 1e3 * points, blind),
            "twenty samples that hide a flow, in millimetres",
            exact=(0, 1),
        ),
    )


@hidden("04.2", "It must hold in every dimension.")
def ranks_in_four_dimensions(seed):
    random = np.random.default_rng(seed + 7)
    points, normals = random.random((25, 4)), random.normal(size=(25, 4))
    normals /= np.sqrt((normals * normals).sum(axis=1))[:, None]
    level = normals * [1, 1, 1, 0]
    level /= np.sqrt((level * level).sum(axis=1))[:, None]
    return (
        Call("velocity_rank", (points, normals), "25 samples in four dimensions"),
        Call("velocity_rank", (points, level), "25 level normals in four dimensions", exact=(0, 1)),
    )


@hidden("04.3", "Any affine flow may be the one that is not seen.")
def many_samples(seed):
    random = np.random.default_rng(seed + 3)
    points = cloud(random, 40, 2)
    return (
        Call(
            "tangent_field", (points, perpendicular_vectors(points, flow(random))), "forty samples"
        ),
    )


@hidden("04.4", "It must hold for any number of points.")
def many_points(seed):
    random = np.random.default_rng(seed + 6)
    return tuple(
        Call("crossing_normals", (cloud(random, n, 2) - [1.1, 0.0], flow(random)), f"{n} points")
        for n in (67, 101)
    )


@hidden("04.5", "The directions may be any, and the normals of either sign.")
def turned_as_a_whole(seed):
    random = np.random.default_rng(seed + 4)
    points = cloud(random, 8, 2)
    one, two, *_ = directions(random, 8)
    signs, tilts = random.choice([-1, 1], (8, 1)), 1e-11 * random.uniform(0.5, 1, (8, 1))

    def normals(first):
        """An exact comparison would be right or wrong by rounding if they were just parallel."""
        each = np.array([one] * first + [two] * (8 - first))
        return signs * (each + tilts * across(each))

    return (
        Call("obvious", (points, normals(4)), "two directions, four samples each"),
        Call("obvious", (points, normals(6)), "two directions, six and two"),
    )


@hidden("04.7", "The conic may be any, and the points may be few.")
def parabola(seed):
    random = np.random.default_rng(seed + 5)
    t = np.arange(8) - 3.5 + random.uniform(-0.3, 0.3, 8)
    turn = np.array([[0.8, 0.6], [-0.6, 0.8]])
    return (
        Call(
            "conic_rank",
            (np.column_stack([t, 0.4 * t**2]) @ turn + 5,),
            "eight points on a parabola",
            exact=(0,),
        ),
        Call("conic_rank", (random.random((2, 2)),), "two points"),
    )
