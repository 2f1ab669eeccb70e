"""Questions of notebook 09 on polynomials and the points that determine them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from fieldcheck.calls import Call, Values
from fieldcheck.inputs.zeros import also_at_zero
from fieldcheck.question import Question, law, law_of_each, relative
from fieldcheck.questions.q03_radial_basis_functions import cloud
from fieldcheck.questions.q09_kernels import ridges

# 09.1 The monomials


def monomials_inputs(seed: int) -> tuple[Call, ...]:
    """Return points, one of them (1, 1), the same scaled, degrees down to −1, and points where
    monomials are equal or zero.
    """
    random = np.random.default_rng(seed)
    points = random.normal(size=(7, 2))
    points[4] = 1
    cases = (
        (points, 2, "seven points and the degree 2"),
        (points * [2, 3], 2, "the same points, stretched"),
        (random.normal(size=(4, 2)), 3, "four points and the degree 3"),
        (random.normal(size=(3, 2)), 0, "three points and the degree 0"),
        (random.normal(size=(5, 2)), -1, "five points and no polynomial"),
        (points, 3, "the same points and the degree 3"),
        (points, 1, "the same points and the degree 1"),
        (random.normal(size=(7, 2)), 2, "seven other points and the degree 2"),
        (random.normal(size=(1, 2)), 2, "one point and the degree 2"),
        (random.normal(size=(2, 2)), 3, "two points and the degree 3"),
        (on_the_axes(random, 6), 3, "points on the axes and the degree 3"),
        (on_the_axes(random, 9), 2, "points on the axes and the degree 2"),
        (random.integers(2, 9, (5, 2)) * [1, -1], 3, "five points of integers and the degree 3"),
        (random.integers(2, 9, (6, 2)) * [-1, 1], 2, "six points of integers and the degree 2"),
        (1e-6 * random.normal(size=(5, 2)), 1, "five points in a box of the size 10⁻⁶, degree 1"),
        (1e-6 * random.normal(size=(4, 2)), 2, "four points in a box of the size 10⁻⁶, degree 2"),
        (1e4 * random.normal(size=(5, 2)), 2, "five points in a box of the size 10⁴, degree 2"),
        (1e6 * random.normal(size=(4, 2)), 1, "four points in a box of the size 10⁶, degree 1"),
        (random.normal(size=(69, 2)), 1, "69 points and the degree 1"),
    )
    return (
        *(Call("monomials", (p, degree), case) for p, degree, case in cases),
        *(
            Call("monomials", (p, degree), case, exact=(0,))
            for p, degree, case in equal_monomials(random)
        ),
    )


def equal_monomials(random: np.random.Generator) -> Iterator[tuple[np.ndarray, int, str]]:
    """Yield points at which some monomials have the same values, or vanish."""
    corners, lattice = (random.permutation(np.argwhere(np.ones((n, n)))) for n in (2, 3))
    yield 1.0 * corners, 2, "four points with the coordinates 0 and 1, degree 2"
    yield lattice[:6] - 1.0, 3, "six points with the coordinates −1, 0 and 1, degree 3"
    yield random.normal(size=(5, 2)) * [1, 0], 2, "five points on the first axis, degree 2"
    yield random.normal(size=(4, 2)) * [0, 1], 1, "four points on the second axis, degree 1"


def on_the_axes(random: np.random.Generator, n: int) -> np.ndarray:
    """Return n points, most of them on one of the axes, and the last one in the origin."""
    points = random.normal(size=(n, 2))
    points[1::3, 0] = points[2::3, 1] = points[-1] = 0
    return points


def monomials_shape(call: Call) -> tuple[tuple[int, ...], ...]:
    points, degree = call.arguments
    return ((len(points), (degree + 1) * (degree + 2) // 2),)


def columns_in_order(_: Call, values: Values) -> Values:
    """Return the columns sorted by their first entries, since their order is arbitrary."""
    (p,) = values
    return (p[:, np.lexsort(np.round(p, 9)[::-1])] if p.size else p,)


@law(
    "If one coordinate is doubled and the other tripled, the columns for the degree 2 must be "
    "multiplied by 1, 2, 3, 4, 6 and 9."
)
def stretch_by_powers(_: Sequence[Call], values: Sequence[Values]) -> float:
    """Return the deviation of the columns of scaled points from 1, 2, 3, 4, 6 and 9 times the
    others.
    """
    with np.errstate(all="ignore"):
        ratio = np.sort(values[1][0] / values[0][0], axis=1)
    return relative(ratio - [1, 2, 3, 4, 6, 9], 1.0)


@law("Where both coordinates are one, every monomial must be one.")
def are_one_at_one(_: Sequence[Call], values: Sequence[Values]) -> float:
    return relative(values[0][0][4] - 1, 1.0)


# 09.3 Polynomials that vanish


def vanishing_inputs(seed: int) -> tuple[Call, ...]:
    """Return points in general position, on lines, near and on an ellipse, few, repeated, in small
    boxes, far from the origin, in integers, and about one of them.
    """
    random = np.random.default_rng(seed)
    turn = random.uniform(0.2, 1.3)
    line = np.outer(2 * cloud(random, 6, 1), [np.cos(turn), np.sin(turn)]) + random.normal(size=2)
    angle = 2 * np.pi * cloud(random, 9, 1)[:, 0]
    middle, away = random.normal(size=2), np.stack([np.cos(angle), 0.6 * np.sin(angle)], axis=1)
    ellipse = middle + away
    twice = cloud(random, 5, 2)
    far = cloud(random, 9, 2) + np.array([1e6, -3e5])
    off = ellipse + 1e-6 * (np.arange(9) == 4)[:, None] * away
    along = np.sort(cloud(random, 7, 1)[:, 0])
    near = np.outer(along, [np.cos(turn), np.sin(turn)])
    nearer = near.copy()
    near[3] += 1e-7 * np.array([-np.sin(turn), np.cos(turn)])
    nearer[3] += 5e-9 * np.array([-np.sin(turn), np.cos(turn)])
    circle = np.argwhere(np.add.outer(np.arange(-5, 6) ** 2, np.arange(-5, 6) ** 2) == 25)
    whole = random.permutation(circle)[:8] + random.integers(-9, 10, 2)
    beside = 1e-13 * random.permutation([0, 1, 0, -1, 0, 1, 0, 0, -1])
    beside_zero = np.column_stack([cloud(random, 9, 1)[:, 0], beside])
    arms = random.permutation([[1, 2], [3, -1], [4, 5]]) * random.choice([-1, 1], 2)
    star = random.integers(-9, 10, 2) + np.concatenate([0 * arms[:1], arms, -arms])
    cases = (
        (cloud(random, 8, 2), 2, "eight points and the degree 2"),
        (line, 1, "six points on a line and the degree 1"),
        (line, 2, "six points on a line and the degree 2"),
        (ellipse, 2, "nine points on an ellipse and the degree 2"),
        (ellipse, 3, "nine points on an ellipse and the degree 3"),
        (cloud(random, 4, 2), 2, "four points and the degree 2"),
        (
            np.concatenate([twice, twice[:2]]),
            2,
            "seven points, of which two pairs are the same, and the degree 2",
        ),
        (1e-8 * cloud(random, 7, 2), 2, "seven points in a box of the size 10⁻⁸ and the degree 2"),
        (far, 2, "nine points, 10⁶ from the origin, and the degree 2"),
        (1e-7 * line, 1, "six points on a line, in a box of the size 10⁻⁷, degree 1"),
        (off, 2, "nine points near an ellipse, one off by 10⁻⁶, degree 2"),
        (1e6 * ellipse, 2, "nine points on an ellipse of the size 10⁶ and the degree 2"),
        (near, 1, "seven points near a line, one off by 10⁻⁷, degree 1"),
        (nearer, 1, "seven points near a line, one off by 5 · 10⁻⁹, degree 1"),
        (nearer[:, ::-1], 1, "the seven points near a line, with their coordinates exchanged"),
        (cloud(random, 12, 2), 3, "twelve points and the degree 3"),
        (whole, 3, "eight points on a circle, in an array of integers, and the degree 3"),
        (cloud(random, 6, 2), 0, "six points and the degree 0"),
        *many_points(random, turn),
        *nearly_on_a_line(random),
    )
    exact = (
        (cloud(random, 6, 2) * [0, 1] + [0.7, 0], 1, "six points on a vertical line, degree 1"),
        (cloud(random, 7, 2) * [1, 0] - [0, 0.3], 2, "seven points on a horizontal line, degree 2"),
        (cloud(random, 3, 2) * [1, 0] + [0, 0.6], 2, "three points on a horizontal line, degree 2"),
        (line + 1e4, 1, "six points on a line, 10⁴ from the origin, and the degree 1"),
        (line - 1e4, 2, "six points on a line, 10⁴ from the origin, and the degree 2"),
        (star[[0, 1, 2, 4, 5]], 2, "five points, the first in the middle, and the degree 2"),
        (0.5 * star, 1, "seven points, the first in the middle, and the degree 1"),
        *(
            (
                size * along + start,
                2,
                f"seven points on a {words} line of length {length}, degree 2",
            )
            for along, start, words in (
                (np.outer(random.permutation([-3, -1, 0, 1, 2, 4, 5]), [0, 1]), [2, 0], "vertical"),
                (
                    np.outer(random.permutation([-3, -1, 0, 1, 2, 4, 5]), [1, 0]),
                    [0, 2],
                    "horizontal",
                ),
            )
            for size, length in ((2.0**-27, "6·10⁻⁸"), (2.0**27, "10⁹"))
        ),
        *(
            (
                size * cloud(random, 9, 2)[[*first, *range(2, 7), *last]],
                2,
                f"nine points in a box of {box}, {which} two the same, degree 2",
            )
            for first, last, which in (((0, 0), (7, 8), "the first"), ((0, 1), (8, 8), "the last"))
            for size, box in ((1e-8, "10⁻⁸"), (1e-15, "10⁻¹⁵"), (1e8, "10⁸"))
        ),
        (beside_zero, 1, "nine points within 10⁻¹³ of a horizontal line, degree 1"),
        (beside_zero[:, ::-1], 2, "nine points within 10⁻¹³ of a vertical line, degree 2"),
    )
    return (
        *(Call("vanishing", (p, degree), case) for p, degree, case in cases),
        *(Call("vanishing", (p, degree), case, exact=(0,)) for p, degree, case in exact),
    )


def many_points(random: np.random.Generator, turn: float) -> Iterator[tuple[np.ndarray, int, str]]:
    """Yield more than forty points on a line or an ellipse, but for the first or the last one."""
    line = np.outer(cloud(random, 43, 1), [np.cos(turn), np.sin(turn)])
    angle = 2 * np.pi * cloud(random, 45, 1)[:, 0]
    ellipse = np.stack([np.cos(angle), 0.6 * np.sin(angle)], axis=1)
    for k, words in ((0, "first"), (-1, "last")):
        beside, outside = line.copy(), ellipse.copy()
        beside[k] += 0.3 * np.array([-np.sin(turn), np.cos(turn)])
        outside[k] *= 1.4
        yield beside, 1, f"43 points on a line, the {words} one beside it, degree 1"
        yield outside, 2, f"45 points on an ellipse, the {words} one outside, degree 2"
    steps = random.permutation(20)[:7] - 9
    along = np.outer(steps, random.integers(1, 6, 2)) + random.integers(-9, 10, 2)
    yield along, 1, "seven points on a line, in an array of integers, and the degree 1"


def nearly_on_a_line(random: np.random.Generator) -> Iterator[tuple[np.ndarray, int, str]]:
    """Yield points one of which is so little off a line that the line counts as vanishing there.

    The least singular value is between 10⁻¹² and 10⁻¹¹ of the largest one, wherever the origin of
    a box of the size of the points is.
    """
    for n, words in ((8, "eight"), (9, "nine")):
        turn = random.uniform(0.2, 1.3)
        along = np.sort(cloud(random, n, 1)[:, 0])
        points = np.outer(along, [np.cos(turn), np.sin(turn)])
        points[4] += 8e-12 * np.array([-np.sin(turn), np.cos(turn)])
        yield points, 1, f"{words} points near a line, one off by 8 · 10⁻¹², degree 1"


@law_of_each(
    "The number must be Q minus the rank of P, for P of any basis of the polynomials, with the "
    "points shifted and scaled. Singular values of at most 10⁻¹⁰ times the largest one count as "
    "zero."
)
def agrees_with_the_rank_for_another_basis(call: Call, values: Values) -> float:
    """Return the difference from Q minus the rank of the values of ridges, instead of monomials."""
    (number,) = values
    points, degree = call.arguments
    away = np.subtract(points, points[0])
    spectrum = np.linalg.svd(ridges(away / np.abs(away).max(), degree), compute_uv=False)
    rank = np.count_nonzero(spectrum > 1e-10 * spectrum[0])
    return abs(float(number) - (degree + 1) * (degree + 2) / 2 + rank)


# 09.6 Two points exchange their positions


def exchange_inputs(seed: int) -> tuple[Call, ...]:
    """Return three points, the third on the left, on the right, and far away; all on one side of
    the origin, each time on another. Three points are integers, and m is not. At last the time is
    close to 0 or 1.
    """
    random = np.random.default_rng(seed)
    cases = (
        ("a third point on the left", 0, 1.6, (1, 1)),
        ("a third point on the right", 1, 1.4, (-1, 1)),
        ("a third point far away", 0, 20.0, (-1, -1)),
        ("a third point between the two", 1, 0.5, (1, -1)),
    )
    calls = []
    for case, half, far, signs in cases:
        start = random.uniform(0, 2 * np.pi)
        angle = start + np.pi * (half + random.uniform(0.1, 0.4) + 0.5 * (random.random() < 0.5))
        arm, third = (np.array([np.cos(u), np.sin(u)]) for u in (start, angle))
        center = random.uniform(1, 3, 2) * signs
        calls.append(
            Call(
                "exchange_time",
                (np.stack([center + arm, center - arm, center + far * third]),),
                case,
            )
        )
    first, step = random.integers(-9, 10, 2), 2 * random.integers(10, 30, 2) + 1
    whole = np.array([first, first + step, first + step * [1, -1] + random.integers(1, 20, 2)])
    calls.append(Call("exchange_time", (whole,), "three points in an array of integers"))
    for sign, side in ((1, "left"), (-1, "right")):
        arm, off = random.normal(size=(2, 2))
        near = random.uniform(1.2, 1.8) * arm.dot(_turn(sign * random.uniform(0.1, 0.3)))
        three = np.stack([off + arm, off - arm, off + near])
        calls.append(
            Call("exchange_time", (three,), f"a third point nearly in line, on the {side}")
        )
    for call in (calls[0], calls[3]):
        for size, words in ((1e-9, "10⁻⁹"), (1e6, "10⁶")):
            three = size * call.arguments[0]
            calls.append(Call("exchange_time", (three,), f"{call.case}, of the size {words}"))
    return (*calls, *upright_and_level(random))


def upright_and_level(random: np.random.Generator) -> Iterator[Call]:
    """Yield third points exactly above m, beside it, and at a right angle to the first side."""
    for arm, third, words in (
        ([1.0, 0.5], [0, 1.5], "exactly above the middle of the first two"),
        ([-0.5, 1.0], [0, -1.25], "exactly below the middle of the first two"),
        ([1.0, 0.5], [1.5, 0], "exactly to the right of the middle of the first two"),
        ([0.75, -1.0], [-1.25, 0], "exactly to the left of the middle of the first two"),
        ([0, 1.0], [1.5, 0.75], "and the first two on a vertical line"),
        ([1.0, 0], [0.75, -1.5], "and the first two on a horizontal line"),
        ([0, -1.0], [1.5, 0], "to the right of a vertical line"),
        ([1.0, 0.5], [-1.0, 2.0], "at a right angle to the first two"),
    ):
        center = random.integers(-9, 10, 2)
        long, far = 2.0 ** random.integers(-2, 3, 2)
        step = long * np.array(arm)
        three = np.stack([center + step, center - step, center + far * np.array(third)])
        yield Call("exchange_time", (three,), f"a third point {words}", exact=(0,))


def _turn(angle: float) -> np.ndarray:
    """Return the transpose of a rotation matrix, which turns rows to the left."""
    return np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])


@law_of_each("At the returned time, between 0 and 1, the three points must lie on one line.")
def makes_a_flat_triangle(call: Call, values: Values) -> float:
    """Return the area of the triangle at that time, and the distance of the time from [0, 1]."""
    (t,) = values
    z = call.arguments[0].dot([1, 1j])
    arm, third = (z[0] - z[1]) / 2, z[2] - (z[0] + z[1]) / 2
    flat = (third * np.conj(arm * np.exp(1j * np.pi * t))).imag
    return float(max(abs(flat) / abs(third * arm), float(abs(t - 0.5) > 0.5)))


QUESTIONS = (
    Question(
        "09.1",
        "monomials",
        2,
        also_at_zero(monomials_inputs, points=(0,)),
        monomials_shape,
        (are_one_at_one, stretch_by_powers),
        normal_form=columns_in_order,
    ),
    Question(
        "09.3",
        "vanishing",
        2,
        vanishing_inputs,
        lambda _: ((),),
        (agrees_with_the_rank_for_another_basis,),
    ),
    Question(
        "09.6",
        "exchange_time",
        3,
        also_at_zero(exchange_inputs, points=(0,)),
        lambda _: ((),),
        (makes_a_flat_triangle,),
        tolerance=lambda _: 1e-8,
    ),
)
