"""Sites at which fixed functions cannot interpolate: by the sign of the exact determinant."""

from fractions import Fraction
from functools import partial
from math import prod

import numpy as np
import pytest
from scipy.spatial.distance import cdist, pdist

from fieldrecon.datasets.synthetic import halton
from fieldrecon.kernels import gaussian, singular_exchange
from fieldrecon.kernels.mairhuber_curtis import _HEIGHTS
from fieldrecon.polynomials import dimension, exponents, monomials
from laws import assert_close, refused


def exact_sign(points: np.ndarray, degree: int) -> int:
    """Sign of the determinant of the monomials, in rational numbers."""
    alpha = exponents(points.shape[1], degree).tolist()
    rows = [
        [prod(x**k for x, k in zip(map(Fraction, p), a, strict=True)) for a in alpha]
        for p in points.tolist()
    ]
    sign = 1
    for k in range(len(rows)):
        pivot = next((i for i in range(k, len(rows)) if rows[i][k]), None)
        if pivot is None:
            return 0
        if pivot != k:
            rows[k], rows[pivot] = rows[pivot], rows[k]
            sign = -sign
        sign *= 1 if rows[k][k] > 0 else -1
        for i in range(k + 1, len(rows)):
            factor = rows[i][k] / rows[k][k]
            rows[i] = [a - factor * b for a, b in zip(rows[i], rows[k], strict=True)]
    return sign


@pytest.mark.slow
@pytest.mark.parametrize(("d", "degree"), [(2, 1), (2, 2), (2, 3), (3, 1), (3, 2)])
def test_the_exact_determinant_changes_its_sign_at_the_time(d, degree):
    """Also in other units and far from the origin; the sites stay distinct."""
    points = halton(dimension(d, degree), d)
    for pair, unit, offset in (((0, 1), 1.0, 0.0), ((2, 0), 2.0**200, 0.0), ((1, 2), 1.0, 4.0)):
        p = points * unit + offset
        found = singular_exchange(partial(monomials, degree=degree), p, pair)
        before, after = (found.at(found.time + step) for step in (-1e-6, 1e-6))
        assert exact_sign(before, degree) == -exact_sign(after, degree) != 0
        assert exact_sign(found.at(0.0), degree) == -exact_sign(found.at(1.0), degree)
        assert pdist(found.sites).min() > 1e-3 * unit
        assert np.array_equal(found.at(0.0), p)
        others = np.delete(np.arange(len(p)), pair)
        assert np.array_equal(found.sites[others], p[others])
        assert np.array_equal(found.at(1.0)[list(pair)], p[list(pair)[::-1]])


@pytest.mark.parametrize("d", [2, 3])
def test_two_sites_alone_change_places_on_a_half_circle(d):
    """Their midpoint and their distance stay, and they move by pi / 2 distances at even speed."""
    start = np.array([[3.0, 1.0, 5.0], [4.0, 1.5, 7.0]])[:, :d]
    found = singular_exchange(lambda x: np.column_stack([np.ones(2), x[:, 0]]), start)
    path = np.array([found.at(t) for t in np.linspace(0, 1, 101)])
    distance = pdist(start)[0]
    assert_close(path.mean(axis=1), np.tile(start.mean(axis=0), (101, 1)), 1e-14)
    assert_close(np.linalg.norm(path[:, 0] - path[:, 1], axis=1), np.full(101, distance), 1e-14)
    step = distance * np.sin(np.pi / 200)
    assert_close(np.linalg.norm(np.diff(path[:, 0], axis=0), axis=1), np.full(100, step), 1e-12)


@pytest.mark.parametrize("d", [2, 3])
def test_the_path_is_the_ellipse_on_which_no_other_site_lies(d):
    """Seven of eight ellipses are blocked, each by a site on the way of one of the two."""
    pair = np.array([[3.0, 1.0, 5.0], [4.0, 1.5, 7.0]])[:, :d]
    half = (pair[0] - pair[1]) / 2
    circle = singular_exchange(lambda x: np.column_stack([np.ones(2), x[:, 0]]), pair).across
    for free in range(8):
        sites = [
            pair.mean(axis=0)
            + (-1) ** k * (half * np.cos(np.pi * t) + h * circle * np.sin(np.pi * t))
            for k, (h, t) in enumerate(zip(_HEIGHTS, np.linspace(0.3, 0.7, 8), strict=True))
            if k != free
        ]
        points = np.concatenate([pair, sites])
        found = singular_exchange(lambda x, y=points: gaussian(0.3)(cdist(x, y)), points)
        assert_close(found.across, _HEIGHTS[free] * circle, 1e-12)


def test_functions_that_move_with_the_sites_are_refused():
    """The determinant of a kernel is the same after the exchange."""
    points = halton(6, 2)
    with refused("functions must not depend on the sites: .* by the factor 1$"):
        singular_exchange(lambda x: gaussian(0.5)(cdist(x, x)), points)
    for change in (1e-3, -1e-3):
        with refused("functions must not depend on the sites: .* by the factor -(1|0.997)$"):
            singular_exchange(
                lambda x, c=change: (1 + c * (x[0, 0] == 2)) * monomials(x, 1),
                [[0, 0], [2, 0], [1, 2]],
            )


@pytest.mark.parametrize(
    ("arguments", "words", "error"),
    [
        ((partial(monomials, degree=2), [[0.0], [1], [2]]), "points must have 2 coord", ValueError),
        ((partial(monomials, degree=1), np.eye(3)[:, :2], (0, 0)), "two distinct", ValueError),
        ((partial(monomials, degree=1), np.eye(3)[:, :2], (0, 3)), "two indices of 3", ValueError),
        ((partial(monomials, degree=1), np.eye(3)[:, :2], (0, -1)), "two indices of 3", ValueError),
        ((partial(monomials, degree=2), np.eye(3)[:, :2]), "must have 3 real values", ValueError),
        (
            (partial(monomials, degree=1), [[0, 0], [1, 1], [2, 2]]),
            "dependent at the points already",
            np.linalg.LinAlgError,
        ),
    ],
)
def test_other_arguments_are_refused(arguments, words, error):
    """The message names the argument and what is wanted."""
    with refused(words, error):
        singular_exchange(*arguments)
