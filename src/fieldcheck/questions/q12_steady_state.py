"""Questions of notebook 12, the loop of structure and flow."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fieldcheck.calls import Call, Values
from fieldcheck.question import Question, law, relative
from fieldcheck.questions.q12_aeroelastic_coupling import transfer


def section(random: np.random.Generator, share: float) -> tuple[np.ndarray, ...]:
    """Return a section on a torsion spring at the middle of its chord.

    The centre of pressure is at that share of the chord from the nose; the displacement is the
    angle.
    """
    chord, spring = random.uniform(1, 2), random.uniform(3, 4)
    h = np.array([[0.5 * chord], [-0.5 * chord]])
    where = np.array([1 - share, share]) * random.uniform(2, 3)
    slope = where[:, None] * np.array([1.0, -1.0]) / chord
    return np.array([[spring]]), h, 0.1 * where, slope


def wing(random: np.random.Generator, n: int, m: int) -> tuple[np.ndarray, ...]:
    """Return a chain of springs that is held at one end, in loads that depend on displacements."""
    k = np.diag(np.full(n, 2.0)) - np.eye(n, k=1) - np.eye(n, k=-1)
    k[-1, -1] = 1.0
    slope = random.uniform(0.1, 1, (m, 1)) * random.normal(size=m) / m
    return k * random.uniform(4, 6), transfer(random, m, n), random.uniform(1, 2, m), slope


def iterates_inputs(seed: int) -> tuple[Call, ...]:
    """Return a section with and without relaxation, one with the centre far behind, and a wing."""
    random = np.random.default_rng(seed)
    one, behind, chain = section(random, 0.25), section(random, 0.9), wing(random, 3, 5)
    name = "iterates"
    return (
        Call(name, (*one, 1.0, 6), "a section on one spring"),
        Call(name, (*one, 0.5, 6), "the same section with relaxation"),
        Call(name, (*behind, 0.7, 5), "a section with the centre of pressure behind the axis"),
        Call(name, (*chain, 0.8, 4), "a chain of three nodes"),
    )


@law(
    "A section on one spring begins at rest, and each of its steps is 1 − ω(1 − λ) "
    "times the one before, where λ is how much the moment of the lift grows with the "
    "angle, divided by how much that of the spring does."
)
def settles_as_a_section(calls: Sequence[Call], values: Sequence[Values]) -> float:
    """Return how far angles of a section are from the sums of a geometric series that begins at
    rest.
    """
    worst = 0.0
    for call, (u,) in zip(calls[:3], values[:3], strict=True):
        k, h, rest, slope, omega, _ = call.arguments
        spring, arm = float(k[0, 0]), h[:, 0]
        lam = np.vdot(arm, np.einsum("ij,j->i", slope, arm)) / spring
        parts = (1 - omega * (1 - lam)) ** np.arange(len(u) - 1)
        angles = omega * np.vdot(arm, rest) / spring * np.r_[0.0, np.cumsum(parts)]
        worst = max(worst, relative(u[:, 0] - angles, angles))
    return worst


# 12.11 Divergence


def divergence_inputs(seed: int) -> tuple[Call, ...]:
    """Return a section, two sections of which one turns back, and loads of two signs."""
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
    frame = np.linalg.qr(random.normal(size=(4, 4)))[0]
    return (
        Call("divergence", (k, h, slope), "a section on one spring"),
        Call("divergence", both, "two sections, the second of which turns back"),
        Call(
            "divergence",
            (np.diag(random.uniform(2, 3, 4)), frame, frame @ turning @ frame.T),
            "four nodes with loads that turn",
        ),
    )


@law("There the matrix of structure and flow is singular, and at no smaller pressure.")
def is_just_singular(calls: Sequence[Call], values: Sequence[Values]) -> float:
    """Return how far the structure in the flow is from singular there, or whether it was so
    before.
    """
    worst = 0.0
    for call, (q,) in zip(calls, values, strict=True):
        k, h, slope = call.arguments
        softening = np.einsum("ij,ik,kl->jl", h, slope, h)
        at = np.linalg.svd(k - q * softening, compute_uv=False)
        parts = np.linspace(0, 0.999, 200)
        signs = np.linalg.slogdet(k - q * parts[:, None, None] * softening)[0]
        worst = max(
            worst,
            float(at[-1] / at[0]) if len(at) > 1 else relative(at, k),
            float((signs <= 0).any() or q <= 0),
        )
    return worst


QUESTIONS = (
    Question(
        "12.10",
        "iterates",
        3,
        iterates_inputs,
        lambda call: ((call.arguments[5] + 1, len(call.arguments[0])),),
        (settles_as_a_section,),
    ),
    Question("12.11", "divergence", 2, divergence_inputs, lambda _: ((),), (is_just_singular,)),
)
