"""Questions of notebook 12 on displacements and loads between two meshes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fieldcheck.calls import Call, Values, calls_of, integers
from fieldcheck.inputs.zeros import also_at_zero
from fieldcheck.question import Question, law, law_of_each, relative


def transfer(random: np.random.Generator, m: int, n: int) -> np.ndarray:
    """Return positive weights whose rows sum to one, without any relation to a mesh."""
    return random.dirichlet(np.ones(n), m)


# 12.2 Loads


def loads_inputs(seed: int) -> tuple[Call, ...]:
    """Return weights whose rows sum to one, others, and as many points as nodes."""
    random = np.random.default_rng(seed)
    return calls_of(
        "loads",
        ((transfer(random, 7, 4), random.normal(size=(7, 3))), "seven points and four nodes"),
        (
            (transfer(random, 5, 4), random.integers(-9, 10, (5, 3))),
            "forces in an array of integers",
        ),
        (
            (random.normal(size=(3, 5)), random.normal(size=(3, 2))),
            "forces of two components, weights of both signs that do not sum to one",
        ),
        ((random.normal(size=(5, 3)), random.normal(size=(5, 1))), "forces of one component"),
        ((random.uniform(0.5, 2, (4, 1)), random.normal(size=(4, 3))), "a single node"),
        (
            (transfer(random, 4, 3)[[0, 1, 1, 2, 3]], random.normal(size=(5, 3))),
            "two points with the same weights",
        ),
        (
            (random.permutation(np.eye(6, 3, dtype=int)), random.normal(size=(6, 3))),
            "weights in an array of integers",
        ),
        (
            (transfer(random, 4, 3), 2.0**-50 * random.normal(size=(4, 3))),
            "tiny forces",
        ),
        *(
            ((again, random.normal(size=(7, 3))), case)
            for again in [transfer(random, 7, 4)]
            for case in ("seven other points", "the same seven points with other forces")
        ),
        ((transfer(random, 5, 3), np.zeros((5, 3))), "forces that are zero"),
        ((random.integers(-3, 4, (5, 3)), random.integers(-9, 10, (5, 3))), "all whole numbers"),
        ((transfer(random, 61, 5), random.normal(size=(61, 2))), "61 points and five nodes"),
        ((transfer(random, 5, 5), random.normal(size=(5, 3))), "as many points as nodes"),
        ((transfer(random, 3, 3), random.normal(size=(3, 2))), "three points and three nodes"),
    )


@law(
    "For every displacement of the nodes, the loads must do the same work as the forces on the "
    "skin."
)
def does_the_same_work(calls: Sequence[Call], values: Sequence[Values]) -> float:
    """Return the difference between the work of the loads and that of the forces."""
    random, worst = np.random.default_rng(0), 0.0
    for call, (g,) in zip(calls, values, strict=True):
        h, f = call.arguments
        for _ in range(4):
            u = random.normal(size=g.shape)
            along = np.einsum("ij,jk->ik", h, u)
            worst = max(worst, relative(np.vdot(along, f) - np.vdot(u, g), np.abs(along * f).sum()))
    return worst


# 12.4 Resultants


def resultants_inputs(seed: int) -> tuple[Call, ...]:
    """Return forces about two points, a couple about two points, and one force with a lever arm.

    Several forces may act at one point. Points or forces may be integers.
    """
    random = np.random.default_rng(seed)
    p, f = random.normal(size=(6, 3)), random.normal(size=(6, 3))
    a, b = random.normal(size=(2, 3))
    ends, pull = random.normal(size=(2, 3)), random.normal(size=3)
    arm = np.array([[random.uniform(1, 3), 0.0, 0.0]])
    name = "resultants"
    return calls_of(
        name,
        ((p, f, a), "six forces"),
        ((p, f, b), "the same forces about another point"),
        ((ends, np.array([pull, -pull]), a), "a couple"),
        ((ends, np.array([pull, -pull]), b), "a couple about another point"),
        (
            (arm, np.array([[0.0, 0.0, 2.0]]), np.zeros(3)),
            "one upward force on an arm, about the origin",
        ),
        ((integers(p), f, a), "six forces at points that are integers"),
        ((p[:3], f[:3], integers(b)), "three forces about a point that is integers"),
        ((p, random.integers(-9, 10, (6, 3)), a), "six forces that are integers"),
        ((p[1:5], integers(f[2:]), b), "four forces that are integers"),
        ((integers(p[:4]), f[:4], b), "four forces at points that are integers"),
        ((p[2:], f[2:], integers(a)), "four forces about a point that is integers"),
        ((p[[0, 1, 1, 2]], f[:4], a), "two forces at the same point"),
        ((p[[0, 1, 1, 0, 2]], f[[0, 1, 2, 0, 0]], b), "equal forces at equal points"),
        ((p, f * [[1], [1], [0], [1], [1], [1]], a), "six forces, the third one zero"),
        ((p[:5], f[:5] * [[0], [1], [1], [0], [1]], b), "five forces, two of them zero"),
        ((p, 2.0**-30 * f, a), "six forces of about 10⁻⁹"),
        ((p[:3], np.zeros((3, 3), dtype=int), b), "three forces that are zero"),
        ((random.normal(size=(61, 3)), random.normal(size=(61, 3)), b), "61 forces"),
    )


@law(
    "About another point only the moment may change, by the moment of the total force between the "
    "two points: not at all for a couple."
)
def changes_by_the_moment_of_the_total_force(
    calls: Sequence[Call], values: Sequence[Values]
) -> float:
    """Return the deviation of the difference of moments about two points from that of the total
    force.
    """
    (one,), (two,), (couple,), (again,), *_ = values
    apart = calls[0].arguments[2] - calls[1].arguments[2]
    total = one[:3]
    carried = [apart[k - 2] * total[k - 1] - apart[k - 1] * total[k - 2] for k in range(3)]
    return max(
        relative(two - one - np.r_[0.0, 0.0, 0.0, carried], two),
        relative(again - couple, couple),
    )


@law("The total force must be the sum of the forces.")
def sums_the_forces(calls: Sequence[Call], values: Sequence[Values]) -> float:
    """Return the deviation of the first three components from the sum of the forces."""
    return max(
        relative(found[:3] - call.arguments[1].sum(axis=0), call.arguments[1])
        for call, (found,) in zip(calls, values, strict=True)
    )


@law("A couple ±f must have the moment d × f, where d points from the second force to the first.")
def a_couple_has_its_arm(calls: Sequence[Call], values: Sequence[Values]) -> float:
    """Return the deviation of the moment of a couple from the cross product of its arm."""
    wanted = [
        np.cross(c.arguments[0][0] - c.arguments[0][1], c.arguments[1][0]) for c in calls[2:4]
    ]
    return max(
        relative(found[3:] - moment, moment)
        for moment, (found,) in zip(wanted, values[2:4], strict=True)
    )


@law("An upward force at the distance r on the x axis must have the moment (0, −r f, 0).")
def an_upward_force_on_an_arm(calls: Sequence[Call], values: Sequence[Values]) -> float:
    """Return the deviation from force and moment of one upward force."""
    ((reach, _, _),), ((_, _, pull),), _ = calls[4].arguments
    ((*_, x, y, z),) = values[4]
    return relative([x, y + reach * pull, z], pull)


# 12.6 Densities


def densities_inputs(seed: int) -> tuple[Call, ...]:
    """Return pressures, a constant pressure, and equal areas."""
    random = np.random.default_rng(seed)
    h, areas = transfer(random, 12, 4), random.uniform(0.5, 2, 12)
    return calls_of(
        "densities",
        ((h, random.normal(size=12), areas), "twelve points and four nodes"),
        ((h, np.full(12, 3), areas), "a constant pressure"),
        (
            (transfer(random, 5, 5), random.integers(-99, 100, 5), np.full(5, 2)),
            "five points with pressures that are whole numbers",
        ),
        *(
            ((signed, alternating(n) * random.uniform(1, 2, n), random.uniform(0.5, 2, n)), case)
            for n, k, case in (
                (10, 4, "weights of both signs at ten points"),
                (7, 3, "weights of both signs at seven points"),
            )
            for signed in [of_both_signs(transfer(random, n, k))]
        ),
        *(
            ((rows[:, None] * transfer(random, n, 4), random.normal(size=n), np.ones(n)), case)
            for n, case in (
                (9, "nine points whose weights do not sum to one"),
                (6, "six points whose weights do not sum to one"),
            )
            for rows in [random.uniform(0.4, 1.6, n)]
        ),
        *(
            (
                (transfer(random, n, 4) * alternating(4), random.normal(size=n), np.ones(n)),
                case,
            )
            for n, case in (
                (8, "eight points and two nodes with negative weights alone"),
                (5, "five points and two nodes with negative weights alone"),
            )
        ),
        *(
            ((transfer(random, n, 3), random.normal(size=n), random.integers(1, 9, n)), case)
            for n, case in (
                (7, "seven areas that are integers"),
                (4, "four areas that are integers"),
            )
        ),
        *(
            (
                (random.uniform(0.5, 2, (n, 1)), random.normal(size=n), random.uniform(0.5, 2, n)),
                case,
            )
            for n, case in (
                (5, "five points and a single node"),
                (3, "three points and a single node"),
            )
        ),
        *(
            (
                (
                    random.permutation(np.eye(n, 3, dtype=int) + np.eye(n, 3, -3, dtype=int)),
                    random.normal(size=n),
                    random.uniform(0.5, 2, n),
                ),
                case,
            )
            for n, case in (
                (6, "six points, each with a single node"),
                (5, "five points, each with a single node"),
            )
        ),
        ((h, random.normal(size=12), areas), "the same weights and areas, other pressures"),
        ((h, random.normal(size=12), areas[::-1]), "the same weights, other areas"),
        ((h, np.zeros(12), areas), "pressures that are zero"),
        ((h, 2.0**-40 * random.normal(size=12), areas), "pressures of about 10⁻¹²"),
        ((transfer(random, 61, 5), random.normal(size=61), random.uniform(1, 2, 61)), "61 points"),
        *(
            (
                (transfer(random, n, 3), random.normal(size=n), size * random.uniform(0.5, 2, n)),
                case,
            )
            for n, size, case in (
                (9, 2.0**-50, "nine areas of about 10⁻¹⁵"),
                (6, 2.0**-60, "six areas of about 10⁻¹⁸"),
            )
        ),
        *(
            ((transfer(random, n, n), random.normal(size=n), random.uniform(0.5, 2, n)), case)
            for n, case in ((4, "four points and four nodes"), (6, "six points and six nodes"))
        ),
    )


def alternating(n: int) -> np.ndarray:
    """Return n signs that alternate."""
    return np.where(np.arange(n) % 2, 1.0, -1.0)


def of_both_signs(h: np.ndarray) -> np.ndarray:
    """Return weights with the same sums of rows, some negative, but positive sums of columns."""
    change = 0.6 * alternating(len(h))
    return h + np.column_stack([change, -change, np.zeros((len(h), h.shape[1] - 2))])


@law("A constant pressure must be reproduced as the same constant.")
def reproduces_constants(_: Sequence[Call], values: Sequence[Values]) -> float:
    """Return the deviation of a constant pressure from itself."""
    return float(np.abs(values[1][0] / 3 - 1).max())


@law_of_each(
    "The total force must be conserved: Σ m′ⱼ p′ⱼ must be the sum of mᵢ pᵢ times the sum of row i "
    "of H."
)
def conserves_the_total_force(call: Call, values: Values) -> float:
    """Return the difference between the total forces of nodal and given pressures."""
    (g,) = values
    h, pressures, areas = call.arguments
    kept = np.einsum("ij,j->i", h, g) - h.sum(axis=1) * pressures
    return relative(areas @ kept, areas)


QUESTIONS = (
    Question(
        "12.2",
        "loads",
        1,
        also_at_zero(loads_inputs, values=(1,)),
        lambda call: ((call.arguments[0].shape[1], call.arguments[1].shape[1]),),
        (does_the_same_work,),
    ),
    Question(
        "12.4",
        "resultants",
        2,
        also_at_zero(resultants_inputs, points=(0, 2), values=(1,)),
        lambda _: ((6,),),
        (
            sums_the_forces,
            an_upward_force_on_an_arm,
            a_couple_has_its_arm,
            changes_by_the_moment_of_the_total_force,
        ),
    ),
    Question(
        "12.6",
        "densities",
        2,
        also_at_zero(densities_inputs, values=(1,)),
        lambda call: ((call.arguments[0].shape[1],),),
        (reproduces_constants, conserves_the_total_force),
    ),
)
