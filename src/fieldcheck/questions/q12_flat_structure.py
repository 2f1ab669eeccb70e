"""The question of notebook 12 on the loads of a flat structure."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fieldcheck.calls import Call, Values, calls_of, integers
from fieldcheck.inputs.zeros import also_at_zero
from fieldcheck.question import Question, law, relative
from fieldcheck.questions.q12_weights_and_slopes import grid

# 12.8 A flat structure


def flat_inputs(seed: int) -> tuple[Call, ...]:
    """Return forces of all directions above a plate, forces in it, and one along it at a height.

    Some points lie in the plate, some forces act at the same point, and some inputs are integers.
    """
    random = np.random.default_rng(seed)
    nodes = grid(random, 3, 3)
    points = np.column_stack([random.uniform(-0.1, 1.1, (5, 2)), random.uniform(0.2, 0.8, 5)])
    forces = random.normal(size=(5, 3))
    name = "flat_loads"
    return calls_of(
        name,
        ((nodes, points, forces), "five forces above a plate"),
        (
            (nodes, points * [1, 1, 0], random.integers(-9, 10, (5, 3))),
            "forces in the plane of the plate, in whole numbers",
        ),
        (
            (nodes, points[:1] * [1, 1, -2], np.array([[1.0, 0.5, 0.0]])),
            "one force along the plate, below it",
        ),
        *(
            (
                (
                    grid(random, *counts),
                    points[some] * np.array(raised)[:, None] ** [0, 0, 1],
                    forces[some],
                ),
                case,
            )
            for counts, some, raised, case in (
                ((3, 2), [0, 1, 2, 3], [1, 0, -1, 0], "forces above, below and in the plate"),
                ((2, 3), [4, 1, 3], [0, 1, 1], "one force in the plate, two above it"),
            )
        ),
        ((nodes, points[[0, 1, 1, 2]], forces[:4]), "two forces at the same point"),
        ((nodes, points, 1e-12 * forces[::-1]), "five forces of about 10⁻¹²"),
        ((nodes, points[1:], 1e-12 * forces[:4]), "four forces of about 10⁻¹²"),
        (
            (nodes, points[[3, 3, 4]] * [[1, 1, 1], [1, 1, -2], [1, 1, 1]], forces[1:4]),
            "two forces at the same point of the plate, at different heights",
        ),
        (
            (nodes, points[:3], forces[:3] * [1, 1, 0]),
            "three forces along the plate, above it",
        ),
        *(
            ((integers(grid(random, *counts), 3), 3 * points[:n], forces[:n]), case)
            for counts, n, case in (
                ((3, 3), 4, "nodes that are integers"),
                ((2, 3), 2, "six nodes that are integers"),
            )
        ),
        *(
            ((3 * grid(random, *counts), random.integers(-2, 5, (n, 3)), forces[:n]), case)
            for counts, n, case in (
                ((3, 3), 4, "points that are integers"),
                ((3, 2), 3, "three points that are integers"),
            )
        ),
        ((nodes, points[:4], integers(forces[:4], 9)), "four forces that are integers"),
        *(
            ((nodes, points[:n] * [1, 1, 1e-5], forces[:n]), case)
            for n, case in ((4, "four forces close to the plate"), (2, "two forces close to it"))
        ),
        *(
            ((size * nodes, size * points, forces), case)
            for size, case in ((2.0**-5, "nodes 0.01 apart"), (2.0**3, "nodes 4 apart"))
        ),
        ((nodes, points, forces * [[1], [0], [1], [1], [1]]), "five forces, one of them zero"),
        ((nodes, points[:3], np.zeros((3, 3))), "three forces that are zero"),
    )


@law("In every rigid motion, including rotations, the loads must do the work of the forces.")
def does_the_work_of_rigid_motions(calls: Sequence[Call], values: Sequence[Values]) -> float:
    """Return the difference between the works of loads and forces in the six rigid motions."""
    worst = 0.0
    for call, (g,) in zip(calls, values, strict=True):
        nodes, points, f = call.arguments
        x = np.pad(nodes, ((0, 0), (0, 1)))
        turned = np.cross(points, f).sum(axis=0) - np.cross(x, g).sum(axis=0)
        worst = max(worst, relative([turned, f.sum(axis=0) - g.sum(axis=0)], f))
    return worst


QUESTIONS = (
    Question(
        "12.8",
        "flat_loads",
        3,
        also_at_zero(flat_inputs, values=(2,)),
        lambda call: ((len(call.arguments[0]), 3),),
        (does_the_work_of_rigid_motions,),
        may_call=("12.2",),
    ),
)
