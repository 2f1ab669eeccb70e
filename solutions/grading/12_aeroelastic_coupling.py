"""Hidden cases of notebook 12."""

import numpy as np

from fieldcheck.calls import Call
from fieldcheck.questions.q12_load_transfer import transfer
from fieldcheck.questions.q12_steady_state import section, wing
from fieldcheck.questions.q12_weights_and_slopes import grid
from fieldgrade.authoring.hidden_cases import hidden


@hidden(
    "12.1",
    "It must hold far outside the structure, beside nodes, for nodes in space, and for one point.",
)
def outside(seed):
    random = np.random.default_rng(seed + 1)
    nodes = grid(random, 2, 3)
    return (
        Call("weights", (grid(random, 3, 3), random.uniform(2, 4, (3, 2))), "points far outside"),
        Call(
            "weights",
            (grid(random, 2, 2, 3), random.uniform(-1, 2, (5, 3))),
            "points around nodes in space",
        ),
        Call("weights", (nodes, random.uniform(0, 1, (1, 2))), "one point in the plane"),
        Call(
            "weights",
            (random.permutation(12)[:, None], random.uniform(0, 11, (5, 1))),
            "nodes on a line that are integers",
        ),
        Call("weights", (nodes, nodes[[1, 4]] + [[1e-4], [-1e-6]]), "points beside nodes"),
        Call("weights", (nodes, random.uniform(-0.2, 1.2, (67, 2))), "67 points"),
        Call("weights", (nodes[1:], random.uniform(-0.2, 1.2, (101, 2))), "101 points"),
        Call("weights", (grid(random, 7, 7), random.uniform(0, 3, (5, 2))), "49 nodes"),
        Call("weights", (grid(random, 12), random.uniform(0, 6, (5, 1))), "12 nodes on a line"),
        Call("weights", (nodes / 16, random.uniform(0, 0.06, (4, 2))), "close nodes"),
    )


@hidden(
    "12.2", "It must hold for a single force, for whole numbers, for any weights, and in any unit."
)
def one_force(seed):
    random = np.random.default_rng(seed + 2)
    return (
        Call("loads", (transfer(random, 1, 6), random.normal(size=(1, 3))), "one force"),
        Call(
            "loads",
            (random.normal(size=(8, 3)), random.integers(-9, 10, (8, 1))),
            "forces of one component, in whole numbers",
        ),
        Call(
            "loads",
            (transfer(random, 3, 2)[[0, 1, 0, 2]], 2.0**-60 * random.normal(size=(4, 3))),
            "tiny forces, two of them with the same weights",
        ),
        Call(
            "loads",
            (np.array([[1, 0], [0, 1], [1, 0]]), random.normal(size=(3, 3))),
            "weights in whole numbers",
        ),
        *(
            Call("loads", (transfer(random, m, n), random.normal(size=(m, 3))), f"{m} forces")
            for m, n in ((67, 43), (101, 3))
        ),
    )


@hidden(
    "12.4",
    "Forces may cancel, be small, or act at the same point, and the moment may be about any point.",
)
def forces_that_cancel(seed):
    random = np.random.default_rng(seed + 3)
    f = random.integers(-9, 10, (3, 3)) / 8
    points, pushes = random.normal(size=(2, 4, 3))
    return (
        Call(
            "resultants",
            (random.normal(size=(6, 3)), np.vstack([f, -f]), random.normal(size=3)),
            "forces that cancel",
        ),
        *(
            Call("resultants", (points, size * pushes, points[0]), case)
            for size, case in ((2.0**-40, "small forces"), (2.0**-60, "smaller forces"))
        ),
        Call(
            "resultants",
            (points[[0, 0, 0]], pushes[[0, 1, 0]], points[1]),
            "three forces at one point, two of them equal",
        ),
        Call(
            "resultants",
            (random.normal(size=(69, 3)), random.normal(size=(69, 3)), points[1]),
            "69 forces",
        ),
        Call(
            "resultants",
            (points, pushes * [[1], [0], [1], [1]], points[2]),
            "a force that is zero, and one at the point of the moment",
        ),
        Call(
            "resultants",
            (random.normal(size=(101, 3)), random.normal(size=(101, 3)), points[3]),
            "101 forces",
        ),
    )


@hidden("12.6", "Areas may differ by a thousand, in any unit.")
def uneven_areas(seed):
    random = np.random.default_rng(seed + 4)
    h, pressures, areas = (
        transfer(random, 20, 6),
        random.normal(size=20),
        10 ** random.uniform(-2, 1, 20),
    )
    return (
        Call("densities", (h, pressures, areas), "uneven areas"),
        Call("densities", (h, pressures, 2.0**-40 * areas), "small areas"),
        Call("densities", (h, pressures, 2.0**-60 * areas), "smaller areas"),
        *(
            Call(
                "densities",
                (transfer(random, m, n), random.normal(size=m), random.uniform(0.5, 2, m)),
                f"{m} points",
            )
            for m, n in ((67, 43), (101, 3))
        ),
    )


@hidden("12.7", "It must hold at a node, beside nodes, far outside, and for a single point.")
def at_nodes(seed):
    random = np.random.default_rng(seed + 5)
    nodes = grid(random, 3, 2, 2)
    beside = nodes[[1, 7]] + [[3e-4], [-1e-5]]
    return (
        Call(
            "slopes",
            (nodes, np.vstack([nodes[[2, 5]], beside, [[3.0, -2.0, 1.0]]])),
            "nodes in space, points beside nodes, and a point outside",
        ),
        Call("slopes", (nodes, random.uniform(0, 1, (1, 3))), "one point"),
        Call(
            "slopes",
            (random.permutation(9)[:, None], random.uniform(0, 8, (3, 1))),
            "nodes on a line that are integers",
        ),
        Call("slopes", (grid(random, 7, 7), random.uniform(0, 3, (5, 2))), "49 nodes"),
        Call("slopes", (grid(random, 3, 2), random.uniform(0, 1, (67, 2))), "67 points"),
        Call("slopes", (grid(random, 5), random.uniform(0, 2, (101, 1))), "101 points on a line"),
    )


@hidden(
    "12.8",
    "It must hold on both sides of the plate at once, for forces at one point, and for one force.",
)
def on_both_sides(seed):
    random = np.random.default_rng(seed + 6)
    nodes = grid(random, 4, 2)
    points = np.column_stack(
        [random.uniform(0, 1, (6, 2)), random.uniform(0.1, 1, 6) * [1, -1, 1, -1, 1, -1]]
    )
    return (
        Call("flat_loads", (nodes, points, random.normal(size=(6, 3))), "forces on both sides"),
        Call(
            "flat_loads",
            (nodes, points[:1], np.array([[0, 0, 1]])),
            "one force across the plate",
        ),
        Call(
            "flat_loads",
            (nodes, points[[0, 0, 1]] * [1, 1, 0.5], random.integers(-9, 10, (3, 3))),
            "two forces at one point and one below the plate, in whole numbers",
        ),
        *(
            Call(
                "flat_loads",
                (nodes, random.uniform(0, 1, (m, 3)), random.normal(size=(m, 3))),
                f"{m} forces",
            )
            for m in (61, 67)
        ),
        Call(
            "flat_loads",
            (grid(random, 7, 7), 2 * points, random.normal(size=(6, 3))),
            "49 nodes",
        ),
    )


@hidden("12.10", "It must hold for many nodes, many steps, and for whole numbers.")
def longer_and_shorter(seed):
    random = np.random.default_rng(seed + 7)
    whole = np.array([[7]]), np.array([[1], [-2]]), random.integers(1, 9, 2), np.eye(2, dtype=int)
    return (
        Call("iterates", (*wing(random, 6, 4), 1.1, 25), "six nodes"),
        Call("iterates", (*whole, 0.5, 4), "a section in whole numbers"),
        Call("iterates", (*wing(random, 3, 4), 0.1, 300), "small steps"),
        Call("iterates", (*wing(random, 61, 9), 1, 3), "61 nodes"),
    )


@hidden("12.10", "With no step the answer is one row of zeros.")
def no_step(seed):
    random = np.random.default_rng(seed + 17)
    return (
        Call("iterates", (*section(random, 0.3), 1.2, 0), "no step"),
        Call("iterates", (*wing(random, 3, 4), 0.7, 0), "no step of three nodes"),
        Call("iterates", (*wing(random, 3, 4), 0.7, 3), "three steps of three nodes"),
    )


@hidden("12.11", "It must hold for any section and any stiffness.")
def other_sections(seed):
    random = np.random.default_rng(seed + 8)
    calls = []
    for share in (0.1, 0.4):
        k, h, _, slope = section(random, share)
        calls.append(Call("divergence", (100 * k, h, slope), "a stiff section"))
    turn = np.linalg.qr(random.normal(size=(3, 3)))[0]
    growth = turn @ np.array([[0.2, 0, 0.3], [0, 0.7, 0.05], [0, -0.04, 0.7]]) @ turn.T
    springs = np.diag([1.5, 2.0, 2.5])
    for stiff, load, case in (
        (2.0**40, 1.0, "three stiff nodes"),
        (2.0**-40, 1.0, "three soft nodes"),
        (1.0, 2.0**-40, "three nodes under small loads"),
    ):
        loads = load * springs @ growth
        calls.append(Call("divergence", (stiff * springs, np.eye(3), loads), case))
    chain = wing(random, 47, 3)[:2]
    return (*calls, Call("divergence", (*chain, np.diag([1.0, 0.5, 0.7])), "47 nodes"))
