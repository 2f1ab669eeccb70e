"""What only a grader tries in notebook 09."""

import numpy as np

from fieldcheck.calls import Call
from fieldcheck.questions.q03_radial_basis_functions import cloud
from fieldcheck.questions.q09_kernels import ring
from fieldgrade.authoring.hidden_cases import hidden


@hidden("09.1", "The degree may be any, and there may be one point only, or many.")
def other_degrees(seed):
    random = np.random.default_rng(seed + 1)
    return (
        Call("monomials", (random.normal(size=(5, 2)), 5), "five points and the degree 5"),
        Call("monomials", (random.normal(size=(3, 2)), 8), "three points and the degree 8"),
        Call("monomials", (random.normal(size=(1, 2)), 2), "one point"),
        Call("monomials", (random.normal(size=(4, 2)), 1), "four points and the degree 1"),
        Call("monomials", (random.normal(size=(6, 2)), 0), "six points and the degree 0"),
        Call("monomials", (random.normal(size=(1, 2)), -1), "one point and no polynomial"),
        Call("monomials", (random.normal(size=(101, 2)), 2), "101 points and the degree 2"),
    )


@hidden(
    "09.2",
    "A may be any symmetric matrix, and the columns of P of any sizes, also nearly equal ones.",
)
def any_matrix(seed):
    random = np.random.default_rng(seed + 2)
    a, p = random.normal(size=(12, 12)), random.normal(size=(12, 3))
    apart = np.zeros((12, 3))
    for k, size in enumerate((1.0, 2.0**-28, 2.0**-38)):
        apart[4 * k : 4 * k + 4, k] = size * random.uniform(1, 2, 4)
    alike = np.eye(12, 4)
    alike[0, 1], alike[1, 1] = 1.0, 2.0**-40
    alone = np.eye(12)[:, random.permutation(12)[:3]]
    return (
        Call("least_eigenvalue", (a + a.T, alike), "two of four conditions nearly equal"),
        Call("least_eigenvalue", (a + a.T, p), "a random symmetric matrix"),
        Call("least_eigenvalue", (a + a.T, p[:, :0]), "a random matrix and no conditions"),
        Call(
            "least_eigenvalue",
            (1e4 * (a + a.T), np.hstack([p, p, p, p])),
            "conditions that are given four times",
        ),
        Call("least_eigenvalue", (a + a.T, p * [1, 3e-3, 1]), "conditions of different sizes"),
        Call("least_eigenvalue", (a + a.T, 1e-8 * p), "conditions with small numbers"),
        Call("least_eigenvalue", (a + a.T, apart), "conditions on different points"),
        Call(
            "least_eigenvalue",
            (a + a.T, np.repeat(alone, 4, axis=1)),
            "conditions on single points that are repeated side by side",
            exact=(1,),
        ),
        Call("least_eigenvalue", (a + a.T + 1e7 * np.eye(12), p), "large eigenvalues"),
    )


@hidden("09.3", "Two lines are a conic too, and it must hold far from the origin and in any unit.")
def on_two_lines(seed):
    random = np.random.default_rng(seed + 3)
    along = cloud(random, 8, 1)[:, 0]
    cross = np.stack(
        [np.where(np.arange(8) < 4, along, 0.3), np.where(np.arange(8) < 4, 0.3, along)]
    )
    turn = np.linalg.qr(random.normal(size=(2, 2)))[0]
    off = cross.copy()
    off[1, np.argmax(np.abs(along[:4] - 0.3))] += 1e-6
    return (
        Call("vanishing", (cross.T @ turn + 1, 2), "eight points on two lines"),
        Call("vanishing", (cloud(random, 9, 2) + 3, 2), "nine points away from the origin"),
        Call("vanishing", (cloud(random, 2, 2), 1), "two points"),
        Call(
            "vanishing",
            (np.array([[0.5, 2.0], [0.5, 3.0]]), 3),
            "two points, one above the other",
            exact=(0,),
        ),
        Call("vanishing", (1e-7 * (cross.T @ turn), 2), "eight points on two tiny lines"),
        Call("vanishing", (off.T @ turn, 2), "eight points near two lines"),
        Call(
            "vanishing", ([1e6, 3e6] + cloud(random, 7, 2), 2), "seven points far from the origin"
        ),
    )


@hidden(
    "09.4",
    "It must hold for other powers, degrees and numbers of points, at one point, and near points.",
)
def other_fields(seed):
    random = np.random.default_rng(seed + 4)
    points, values = cloud(random, 20, 2), random.normal(size=20)
    close = points.copy()
    close[7] = close[12] + [0.008, -0.004]
    six = ring(random, 6, 1.5)
    return (
        Call("interpolate", (points, values, 4, 2, random.random((1, 2))), "k = 4 and one point"),
        Call(
            "interpolate",
            (points, values, 3, 3, points),
            "k = 3 and the degree 3 at the points themselves",
        ),
        Call(
            "interpolate",
            (points[:3], values[:3], 2, 1, random.random((4, 2))),
            "as many points as monomials",
        ),
        Call(
            "interpolate", (points, values, 1, -1, random.random((4, 2))), "k = 1 and no polynomial"
        ),
        Call("interpolate", (points, values, 2, 1, points[:9] + 1e-3), "k = 2, beside nine points"),
        Call("interpolate", (points, values, 3, 1, points - 1e-5), "k = 3, beside all points"),
        Call("interpolate", (close, values, 3, 1, random.random((9, 2))), "two close points"),
        Call(
            "interpolate",
            (six, random.normal(size=6), 4, 0, random.random((9, 2))),
            "k = 4 and the degree 0",
        ),
        Call("interpolate", (points, values, 3, 1, points[3:4] + 0.1), "k = 3 and one point"),
        Call("interpolate", (points, values, 3, 1, random.random((101, 2))), "101 points"),
        Call(
            "interpolate",
            (cloud(random, 45, 2), random.normal(size=45), 1, 0, random.random((5, 2))),
            "45 points",
        ),
    )


@hidden("09.5", "D may be large, and a single distance is an array too.")
def many_variables(seed):
    r = np.random.default_rng(seed + 5).uniform(0, 1.5, 7)
    return (
        Call("wendland", (r, 9, 1), "nine variables"),
        Call("wendland", (r, 9, 0), "nine variables, not smooth"),
        Call("wendland", (r, 6, 0), "six variables"),
        Call("wendland", (r[:1], 1, 1), "one distance"),
        Call("wendland", (r[1:2] / 2, 2, 0), "one distance, not smooth"),
        Call("wendland", (r[1:].reshape(3, 2), 3, 1), "a matrix of distances"),
    )


@hidden("09.6", "The points may lie anywhere, and be far apart or near.")
def anywhere(seed):
    random = np.random.default_rng(seed + 6)
    calls = []
    for scale in (1e-6, 1, 1e6):
        points = random.normal(size=(3, 2))
        opposite = np.append(points[:2], [points[0] + points[1] - points[2]], axis=0)
        for three, side in ((points, "one"), (opposite, "the other")):
            case = f"points of the size {scale:g}, the third on {side} side"
            calls.append(Call("exchange_time", (scale * three,), case))
    return tuple(calls)


@hidden("09.7", "The points come in any order, and one point has a value and a slope too.")
def one_and_many(seed):
    random = np.random.default_rng(seed + 7)
    x = random.normal(size=9)
    return (
        Call("slope_matrix", (x,), "nine points"),
        Call("slope_matrix", (cloud(random, 43, 1)[:, 0],), "43 points"),
        Call("slope_matrix", (x[:1],), "one point"),
        Call("slope_matrix", (2.0**-13 * x[:4],), "four points 10⁻⁴ apart"),
    )
