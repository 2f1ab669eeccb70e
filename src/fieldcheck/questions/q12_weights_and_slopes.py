"""Questions of notebook 12 on the weights and slopes of linear interpolation."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fieldcheck.calls import Call, Values, calls_of, integers
from fieldcheck.inputs.zeros import also_at_zero
from fieldcheck.question import Question, law, law_of_each, relative, scale


def grid(random: np.random.Generator, *counts: int) -> np.ndarray:
    """Return the nodes of a grid of spacing one half, each slightly displaced."""
    nodes = np.indices(counts).reshape(len(counts), -1).T / 2
    return nodes + random.uniform(-0.13, 0.13, nodes.shape)


# 12.1 and 12.7 Weights and slopes


def meshes(name: str, seed: int) -> tuple[Call, ...]:
    """Return nodes and points in the plane, in space and on a line; a triangle; the nodes
    themselves; single points; nodes or points that are integers.
    """
    random = np.random.default_rng(seed)
    plane, space, line = grid(random, 4, 3), grid(random, 3, 2, 2), grid(random, 5)
    triangle = np.array([[0, 0], [9, 2], [2, 8]]) + random.integers(-1, 2, (3, 2))
    turned = np.column_stack([-plane[:, 1], plane[:, 0]])
    x = random.uniform(-0.2, 1.4, (5, 2))
    beside = random.uniform(0.5, 1, (3, 2)) * np.array([[1e-3], [1e-4], [1e-6]])
    return calls_of(
        name,
        ((plane, x), "twelve nodes in the plane"),
        (
            (turned, np.column_stack([-x[:, 1], x[:, 0]])),
            "the twelve nodes after a quarter of a turn",
        ),
        ((space, random.uniform(0, 1, (4, 3))), "twelve nodes in space"),
        (
            (line, random.integers(-1, 4, (6, 1))),
            "five nodes on the line, and points in whole numbers",
        ),
        ((triangle, random.integers(1, 7, (3, 2))), "three nodes in the plane, in whole numbers"),
        ((plane, plane[[4, 0, 7]]), "points that are nodes"),
        ((plane, plane[[4, 0, 7]] + beside), "points 10⁻³, 10⁻⁴ and 10⁻⁶ beside nodes"),
        ((space, random.uniform(0, 1, (1, 3))), "one point, and twelve nodes in space"),
        ((line, random.uniform(-0.2, 2, (1, 1))), "one point, and five nodes on the line"),
        ((integers(plane, 3), 3 * x), "nodes in the plane that are integers"),
        ((integers(line, 3), random.uniform(-1, 7, (4, 1))), "nodes on the line that are integers"),
        ((3 * plane, random.integers(-1, 6, (4, 2))), "points in the plane that are integers"),
        ((2.0**-4 * plane, 2.0**-4 * x), "twelve nodes about 0.03 apart"),
        ((2.0**-4 * space, random.uniform(0, 0.06, (3, 3))), "twelve nodes in space, 0.03 apart"),
        ((2.0**3 * plane, 2.0**3 * x), "twelve nodes about 4 apart"),
        ((2.0**4 * line, random.uniform(-3, 32, (4, 1))), "five nodes on the line, 8 apart"),
        ((line[1:3], random.uniform(-1, 2, (3, 1))), "two nodes on the line"),
        (
            (grid(random, 2, 2, 2)[[0, 3, 5, 6]], random.uniform(0, 1, (6, 3))),
            "four nodes in space",
        ),
        ((grid(random, 2, 2), random.uniform(0, 0.5, (4, 2))), "four nodes in the plane"),
        ((grid(random, 3), random.uniform(0, 1, (4, 1))), "three nodes on the line"),
    )


def weights_inputs(seed: int) -> tuple[Call, ...]:
    """Return the same, and nodes in millimetres.

    There a default tolerance would cut singular values.
    """
    calls = meshes("weights", seed)
    (plane, x), (line, _) = calls[0].arguments, calls[3].arguments
    y = np.random.default_rng(seed + 1).uniform(-0.2, 2, (4, 1))
    return (
        *calls,
        Call("weights", (1e3 * line, 1e3 * y), "five nodes on the line, in millimetres"),
        Call("weights", (1e3 * plane, 1e3 * x), "twelve nodes in the plane, in millimetres"),
        Call("weights", (2.0**-19 * line, 2.0**-19 * y), "five nodes on the line, 10⁻⁶ apart"),
        Call("weights", (2.0**-19 * plane, 2.0**-19 * x), "twelve nodes in the plane, 10⁻⁶ apart"),
        *(
            Call("weights", (2.0**-19 * plane, 2.0**-19 * (plane[nodes] + away)), case)
            for nodes, case in (
                ([1, 6, 8], "twelve nodes 10⁻⁶ apart, points beside three of them"),
                ([2, 5], "twelve nodes 10⁻⁶ apart, points beside two of them"),
            )
            for away in [1e-3 * np.random.default_rng(seed + 2).uniform(0.5, 1, (len(nodes), 2))]
        ),
    )


def slopes_inputs(seed: int) -> tuple[Call, ...]:
    """Return the same, other units of length, and two Gauss points between nodes of the line."""
    calls = meshes("slopes", seed)
    (plane, x), (line, _) = calls[0].arguments, calls[3].arguments
    y = np.random.default_rng(seed + 1).uniform(-0.2, 2, (4, 1))
    middle, half = (line[1] + line[2]) / 2, (line[2] - line[1]) / 2
    points = middle + half * np.array([[-1.0], [1.0]]) / np.sqrt(3)
    return (
        *calls,
        Call("slopes", (1e3 * plane, 1e3 * x), "twelve nodes in the plane, in millimetres"),
        Call("slopes", (2.0**-19 * plane, 2.0**-19 * x), "twelve nodes in the plane, 10⁻⁶ apart"),
        Call("slopes", (2.0**-19 * line, 2.0**-19 * y), "five nodes on the line, 10⁻⁶ apart"),
        Call("slopes", (2.0**40 * plane, 2.0**40 * x), "twelve nodes in the plane, 10¹² apart"),
        Call("slopes", (2.0**40 * line, 2.0**40 * y), "five nodes on the line, 10¹² apart"),
        Call("slopes", (line, points), "two points between two nodes of the line"),
    )


@law(
    "From one node to the next, the slopes must integrate to the change of the weights. The weight "
    "of the first node changes from 1 to 0, that of the second from 0 to 1."
)
def integrates_to_the_change_of_weights(calls: Sequence[Call], values: Sequence[Values]) -> float:
    """Return the difference between the integral of slopes between nodes and the change of weights.

    Between the nodes the slopes are polynomials of degree two, for which Gauss quadrature is exact.
    """
    line, ((g,),) = calls[-1].arguments[0][:, 0], values[-1]
    change = (line[2] - line[1]) / 2 * g.sum(axis=0)
    return float(np.abs(change - [0.0, -1.0, 1.0, 0.0, 0.0]).max())


@law_of_each(
    "If all nodes move alike, all points must move with them: each row of H must sum to 1."
)
def rows_sum_to_one(_: Call, values: Values) -> float:
    """Return the deviation of row sums from one: translations must be reproduced."""
    return float(np.abs(values[0].sum(axis=1) - 1).max())


@law_of_each(
    "H times the coordinates of the nodes must be the coordinates of the points: linear "
    "displacements must be reproduced."
)
def reproduces_positions(call: Call, values: Values) -> float:
    """Return the deviation of the weighted means of the nodes from the points."""
    (nodes, points, *_), (h,) = call.arguments, values
    return relative(np.einsum("ij,jk->ik", h, nodes) - points, points)


@law("At a node, the weight of this node must be 1, and all others must be 0.")
def is_one_at_its_node(_: Sequence[Call], values: Sequence[Values]) -> float:
    """Return the deviation of the weights at nodes from one for the node and zero otherwise."""
    return float(np.abs(values[5][0] - np.eye(12)[[4, 0, 7]]).max())


@law("A common rotation of nodes and points must not change the weights.")
def is_rotation_invariant(_: Sequence[Call], values: Sequence[Values]) -> float:
    """Return the change of the weights under a rotation."""
    return relative(values[1][0] - values[0][0], values[0][0])


@law(
    "If nodes and points are rotated, the slopes must rotate with them. Difference quotients do so "
    "only nearly."
)
def slopes_rotate_with_the_mesh(_: Sequence[Call], values: Sequence[Values]) -> float:
    """Return the deviation of slopes after a quarter turn from the rotated slopes."""
    (before,), (after,) = values[:2]
    return relative([after[1] - before[0], after[0] + before[1]], before)


@law(
    "The slopes of a constant must be 0; those of a coordinate must be 1 along its own axis and 0 "
    "along the others.",
    1e-6,  # difference quotients obey this law up to rounding, and break others
)
def slope_of_linear_fields(calls: Sequence[Call], values: Sequence[Values]) -> float:
    """Return the deviation of slopes from zero for constants, from unit vectors for coordinates."""
    worst = 0.0
    for call, (g,) in zip(calls, values, strict=True):
        nodes = call.arguments[0]
        of_coordinates = np.einsum("kij,jl->ikl", g, nodes)
        size = max(1.0, scale(g) * scale(nodes))  # rounding errors are relative to these products
        worst = max(worst, float(np.abs(g.sum(axis=2)).max()) * scale(nodes) / size)
        worst = max(worst, float(np.abs(of_coordinates - np.eye(len(g))).max()) / size)
    return worst


def weights_shape(call: Call) -> tuple[tuple[int, ...], ...]:
    return ((len(call.arguments[1]), len(call.arguments[0])),)


QUESTIONS = (
    Question(
        "12.1",
        "weights",
        3,
        also_at_zero(weights_inputs, points=(0, 1)),
        weights_shape,
        (rows_sum_to_one, reproduces_positions, is_one_at_its_node, is_rotation_invariant),
    ),
    Question(
        "12.7",
        "slopes",
        2,
        slopes_inputs,
        lambda call: ((call.arguments[0].shape[1], *weights_shape(call)[0]),),
        (slope_of_linear_fields, slopes_rotate_with_the_mesh, integrates_to_the_change_of_weights),
    ),
)
