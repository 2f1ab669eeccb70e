"""Questions of notebook 12 on the steady state of a structure in a flow, and its divergence."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fieldcheck.calls import Call, Values, calls_of, integers
from fieldcheck.inputs.zeros import also_at_zero
from fieldcheck.question import Question, law_of_each, relative
from fieldcheck.questions.q12_load_transfer import alternating, transfer

# 12.10 The iterates


def section(random: np.random.Generator, share: float) -> tuple[np.ndarray, ...]:
    """Return a rigid section on a torsion spring at the middle of its chord.

    The centre of pressure is at this share of the chord from the nose; the displacement is the
    angle.
    """
    chord, spring = random.uniform(1, 2), random.uniform(3, 4)
    h = np.array([[0.5 * chord], [-0.5 * chord]])
    where = np.array([1 - share, share]) * random.uniform(2, 3)
    slope = where[:, None] * np.array([1.0, -1.0]) / chord
    return np.array([[spring]]), h, 0.1 * where, slope


def wing(random: np.random.Generator, n: int, m: int) -> tuple[np.ndarray, ...]:
    """Return a chain of springs clamped at one end, with loads of both signs that depend on
    displacements.
    """
    k = np.diag(np.full(n, 2.0)) - np.eye(n, k=1) - np.eye(n, k=-1)
    k[-1, -1] = 1.0
    slope = random.uniform(0.1, 1, (m, 1)) * random.normal(size=m) / m
    rest = random.uniform(1, 2, m) * alternating(m)
    return k * random.uniform(4, 6), transfer(random, m, n), rest, slope


def iterates_inputs(seed: int) -> tuple[Call, ...]:
    """Return a section with and without relaxation, with a rear centre of pressure, and a wing.

    Tiny loads, and many small steps, show an answer that stops when the iterates hardly change. At
    divergence there is no steady state.
    """
    random = np.random.default_rng(seed)
    one, behind, chain = section(random, 0.25), section(random, 0.9), wing(random, 3, 5)
    k, h, rest, slope = chain
    whole = np.array([[random.integers(6, 10)]]), np.array([[1], [-2]])
    units = np.array([2.0**-20, 1, 1])
    name = "iterates"
    return calls_of(
        name,
        ((*one, 1.0, 6), "a section on one spring"),
        ((*one, 0.5, 6), "a section with relaxation"),
        ((*behind, 0.7, 5), "a section with the centre of pressure behind the elastic axis"),
        ((*chain, 0.8, 4), "a chain of three nodes"),
        ((*wing(random, 4, 6), 1.1, 3), "a chain of four nodes"),
        ((k, h, 1e-12 * rest, slope, 0.8, 4), "a chain of three nodes under tiny loads"),
        *(
            ((unit * k, h, unit * rest, unit * slope, 0.8, 4), f"all forces times {words}")
            for unit, words in ((2.0**-40, "10⁻¹²"), (2.0**40, "10¹²"))
        ),
        *(
            ((k * np.outer(u, u), h * u, rest, slope, 0.8, 4), f"the {which} node in another unit")
            for u, which in ((units, "first"), (units[::-1], "last"))
        ),
        ((*one, 0.15, 240), "a section with 240 small steps"),
        ((k, h, integers(rest), slope, 0.8, 4), "a chain of three nodes, its loads integers"),
        ((*one[:2], integers(one[2]), one[3], 0.5, 4), "a section, its loads integers"),
        (
            (*whole, random.integers(1, 999, 2), np.eye(2, dtype=int), 0.5, 3),
            "all in whole numbers",
        ),
        ((one[0] / 6, *one[1:], 0.8, 4), "a section beyond divergence"),
        ((behind[0] / 20, *behind[1:], 1.0, 5), "a section whose iterates alternate and grow"),
        ((k / 30, h, rest, slope, 1.2, 4), "a chain of three soft springs"),
        ((behind[0] / 20, *behind[1:], 1.0, 40), "a section whose iterates become very large"),
        ((k / 60, h, rest, slope, 1.1, 60), "a chain of three springs far beyond divergence"),
        ((k, h, 0 * rest, slope, 0.8, 3), "a chain of three nodes without loads at rest"),
        ((k, h, rest, 0 * slope, 1, 3), "a chain of three nodes, with A zero and ω = 1"),
        ((k, h, rest, slope[::-1], 0.8, 4), "the same chain with another A"),
        ((*wing(random, 43, 5), 0.9, 2), "a chain of 43 nodes"),
    ) + tuple(
        Call(name, (*critical(random, springs), omega, steps), case, exact=(0, 1, 3))
        for springs, omega, steps, case in (
            ([1], 0.7, 5, "a section at divergence"),
            ([1, 3], 1.0, 4, "two sections, one of them at divergence"),
        )
    )


def critical(random: np.random.Generator, springs: Sequence[float]) -> tuple[np.ndarray, ...]:
    """Return sections on springs, given as multiples of the stiffness at divergence."""
    n = len(springs)
    h = np.kron(np.eye(n), [[2.0], [-1.0]])
    growth = random.integers(1, 5, n).astype(float)
    slope = np.kron(np.diag(growth), [[1.0, -1.0], [0.0, 0.0]])
    return np.diag(6 * growth * springs), h, random.uniform(1, 2, 2 * n), slope


@law_of_each(
    "The first row must be zero, and each further row must follow from the row before by (12.9)."
)
def follows_from_the_row_before(call: Call, values: Values) -> float:
    """Return the deviation of the first row from zero, and the residual of K times a step."""
    (u,) = values
    k, h, rest, slope, omega, _ = call.arguments
    steps, w = np.diff(u, axis=0), np.einsum("ij,nj->ni", h, u[:-1])
    push = np.einsum("ij,ni->nj", h, rest + np.einsum("ij,nj->ni", slope, w))
    residual = np.einsum("ij,nj->ni", k, steps + omega * u[:-1]) - omega * push
    return max(relative(u[0], u), relative(residual, push))


# 12.11 Divergence


def divergence_inputs(seed: int) -> tuple[Call, ...]:
    """Return a section, two sections of which one untwists, and loads of two signs.

    The stiffness matrix of a chain is not diagonal, and A may have rank one.
    """
    random = np.random.default_rng(seed)
    k, h, _, slope = section(random, 0.25)
    other = section(random, 0.95)
    none = 0 * slope
    both = (
        np.diag([k[0, 0], 3 * other[0][0, 0]]),
        np.vstack([np.pad(h, ((0, 0), (0, 1))), np.pad(other[1], ((0, 0), (1, 0)))]),
        np.block([[slope, none], [none, 3 * other[3]]]),
    )
    turning = np.diag([0.5, 0.25, 0.4, 1.6])
    turning[2:, 2:] += 2 * np.array([[0, 1], [-1, 0]])
    springs = random.uniform(2, 3, 4)
    growths = random.uniform(0.3, 0.35, 4) * [0.6, 2.5, -4, 1.4]
    frame, other_frame = (np.linalg.qr(random.normal(size=(4, 4)))[0] for _ in range(2))
    faster = np.diag([0.3, 0.5, 1.2, 0.2])
    faster[1:3, 1:3] = [[0.9, 2.5], [-2.5, 0.9]]
    spinning = np.diag(random.uniform(2, 3, 4)), other_frame, other_frame @ faster @ other_frame.T
    coupling = random.uniform(1, 2) * np.array([[1, -1], [-1, 1]])
    units = np.array([2.0**-20, 1, 1, 1])
    return calls_of(
        "divergence",
        ((k, h, slope), "a section on one spring"),
        (both, "two sections, the second with negative λ"),
        (
            (np.diag(random.uniform(2, 3, 4)), frame, frame @ turning @ frame.T),
            "four nodes with two complex eigenvalues",
        ),
        (
            spinning,
            "four nodes with complex eigenvalues of large real part",
        ),
        *(
            ((spinning[0] * np.outer(u, u), spinning[1] * u, spinning[2]), f"{case} in other units")
            for u, case in ((units, "the first node"), (units[::-1], "the last node"))
        ),
        (
            (2.0**40 * spinning[0], *spinning[1:]),
            "four stiff nodes with complex eigenvalues of large real part",
        ),
        (tuple(part[::-1, ::-1] for part in both), "two sections, the first with negative λ"),
        (
            (np.diag(springs), np.eye(4), np.diag(springs * growths)),
            "four sections that are not coupled",
        ),
        (
            (np.diag(springs[1:]), np.eye(3), np.diag((springs * growths)[1:])),
            "three sections that are not coupled",
        ),
        *(
            ((*wing(random, n, m)[:2], np.outer(*random.uniform(0.4, 1, (2, m)))), case)
            for n, m, case in (
                (4, 6, "a chain of four nodes, with A of rank one"),
                (3, 5, "a chain of three nodes, with A of rank one"),
            )
        ),
        (
            (both[0] + coupling, both[1], np.pad(slope, ((0, 2), (0, 2)))),
            "two coupled sections, the second without loads",
        ),
        (
            (*wing(random, 3, 5)[:2], np.diag(random.uniform(1, 2, 5))),
            "a chain of three nodes, with A diagonal",
        ),
        *(
            ((both[0], both[1], growth * both[2]), case)
            for growth, case in (
                (1.5, "the same two sections, A larger"),
                (2.0**-40, "the same two sections, A tiny"),
            )
        ),
        *(
            ((chain, random.integers(0, 4, (m, n)) + np.eye(m, n, dtype=int), air), case)
            for n, m, case in (
                (3, 5, "three nodes in whole numbers"),
                (4, 6, "four nodes in whole numbers"),
            )
            for link in [np.eye(n, k=1, dtype=int)]
            for chain in [9 * np.eye(n, dtype=int) - link - link.T]
            for air in [np.diag(random.integers(1, 9, m))]
        ),
        ((*wing(random, 43, 3)[:2], np.outer(*random.uniform(0.4, 1, (2, 3)))), "43 nodes"),
        *(
            (nearly_real(random, n, stiffness, part), case)
            for n, stiffness, part, case in (
                (3, 2.0, 0.05, "three nodes with complex eigenvalues of small imaginary part"),
                (4, 0.5, 0.05, "four nodes with complex eigenvalues of small imaginary part"),
                (3, 3.0, 3e-8, "three nodes with complex eigenvalues of tiny imaginary part"),
                (4, 2.0**40, 3e-8, "four nodes with complex eigenvalues of tiny imaginary part"),
            )
        ),
    )


def nearly_real(
    random: np.random.Generator, n: int, stiffness: float, part: float
) -> tuple[np.ndarray, ...]:
    """Return equally stiff nodes; two eigenvalues of large real part are not real, but nearly.

    K⁻¹HᵀAH is normal, so that rounding errors change its eigenvalues as little as its entries.
    """
    growth = np.diag(0.4 / np.arange(1, n + 1)) * random.uniform(0.9, 1.1)
    growth[:2, :2] = random.uniform(0.6, 0.8) * np.array([[1, part], [-part, 1]])
    frame = np.linalg.qr(random.normal(size=(n, n)))[0]
    return stiffness * np.eye(n), np.eye(n), stiffness * frame @ growth @ frame.T


@law_of_each(
    "q must be positive. The matrix of (12.11) must be singular at q, and at no smaller positive "
    "number."
)
def is_just_singular(call: Call, values: Values) -> float:
    """Return the deviation of the structure in the flow from singular, or whether it was singular
    before.
    """
    (q,) = values
    k, h, slope = call.arguments
    softening = np.einsum("ij,ik,kl->jl", h, slope, h)
    at = np.linalg.svd(k - q * softening, compute_uv=False)
    parts = np.linspace(0, 0.999, 200)
    signs = np.linalg.slogdet(k - q * parts[:, None, None] * softening)[0]
    return max(
        float(at[-1] / at[0]) if len(at) > 1 else relative(at, k),
        float((signs <= 0).any() or q <= 0),
    )


QUESTIONS = (
    Question(
        "12.10",
        "iterates",
        3,
        also_at_zero(iterates_inputs, values=(2,)),
        lambda call: ((call.arguments[5] + 1, len(call.arguments[0])),),
        (follows_from_the_row_before,),
        may_call=("12.2",),
    ),
    Question("12.11", "divergence", 2, divergence_inputs, lambda _: ((),), (is_just_singular,)),
)
