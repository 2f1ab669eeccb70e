"""Symbolic proofs of the formula for the weights of Voronoi coordinates.

The vertex x_i is the origin, because all formulas contain differences only. Lengths and volumes are
positive, so an equation holds if it holds for the squares, and squares need neither roots nor
absolute values.
"""

import math
from functools import cache

import pytest
import sympy as sp

DIMENSIONS = [2, 3]
HALF = sp.Rational(1, 2)


@cache
def simplex(d):
    """Edges x_b - x_i of a generic simplex as rows, a generic query x, and a generic point p."""
    edges = sp.Matrix(d, d, lambda b, k: sp.Symbol(f"e{b}{k}", real=True))
    x, p = (sp.Matrix([sp.Symbol(f"{name}{k}", real=True) for k in range(d)]) for name in "xp")
    return edges, x, p


def squared_lengths(edges):
    return [(edges[b, :] * edges[b, :].T)[0] for b in range(edges.rows)]


@cache
def squared_volume(d):
    """The squared volume of the simplex from its edge lengths: the Cayley-Menger determinant."""
    edges = simplex(d)[0]
    corners = sp.Matrix.vstack(sp.zeros(1, d), edges)
    n = d + 1
    squares = sp.Matrix(n, n, lambda i, j: sum(c**2 for c in corners[i, :] - corners[j, :]))
    ones = sp.ones(1, n)
    bordered = sp.Matrix.vstack(
        sp.Matrix.hstack(sp.zeros(1, 1), ones), sp.Matrix.hstack(ones.T, squares)
    )
    determinant = bordered.applyfunc(sp.expand).det(method="berkowitz")
    return sp.expand((-1) ** n * determinant / (2**d * math.factorial(d) ** 2))


def volume_of_normals(edges):
    """The slides' vol(N_a): the determinant of the unit normals n_b = (x_b - x_i) / l_b."""
    lengths = [sp.sqrt(square) for square in squared_lengths(edges)]
    return sp.Matrix([edges[b, :] / lengths[b] for b in range(edges.rows)]).det(method="berkowitz")


def circumcenter(edges):
    """The intersection of the perpendicular bisectors of the edges at x_i, by Cramer's rule."""
    right = sp.Matrix([square / 2 for square in squared_lengths(edges)])
    return edges.adjugate() * right / edges.det(method="berkowitz")


def vanishes(expression):
    return sp.expand(sp.fraction(sp.together(expression))[0]) == 0


# --- claims: expressions that must vanish -------------------------------------------------------


def volume_claim(d, factor=None, power=1):
    """(vol(N_a) prod l_b)^2 = (D! V_a)^2."""
    edges, _, _ = simplex(d)
    factor = math.factorial(d) if factor is None else factor
    lengths_squared = math.prod(squared_lengths(edges))
    squared = sp.cancel(volume_of_normals(edges) ** 2 * lengths_squared**power)
    return squared - factor**2 * squared_volume(d)


def weight_claim(d, keep_lengths=False):
    """vol(N_a) / prod n_b^T (p - x) = D! V_a / prod (x_b - x_i)^T (p - x), for any p."""
    edges, x, p = simplex(d)
    slopes = [(edges[b, :] * (p - x))[0] for b in range(d)]
    lengths = [sp.sqrt(square) for square in squared_lengths(edges)]
    heights = [slope / length for slope, length in zip(slopes, lengths, strict=True)]
    quotient = (volume_of_normals(edges) / math.prod(heights)) ** 2
    below = math.prod(heights if keep_lengths else slopes)
    return quotient - math.factorial(d) ** 2 * squared_volume(d) / below**2


def height_claim(d, half=HALF):
    """(x_b - x_i)^T (p_a - x) = l_b^2 / 2 - (x_b - x_i)^T (x - x_i), summed with any factors."""
    edges, x, _ = simplex(d)
    slopes = edges * (circumcenter(edges) - x)
    wanted = half * sp.Matrix(squared_lengths(edges)) - edges * x
    return sum(sp.Symbol(f"t{b}") * (slopes - wanted)[b] for b in range(d))


def circumcenter_claim(d):
    """|p_a - x_b|^2 = |p_a - x_i|^2."""
    edges = simplex(d)[0]
    p = circumcenter(edges)
    return sum(
        sp.Symbol(f"t{b}") * (sum(c**2 for c in edges[b, :].T - p) - sum(c**2 for c in p))
        for b in range(d)
    )


def precision_claim(d, shift=0):
    """sum_a V_a prod_{b not in a} h_b (p_a - x) = 0 for a vertex with d + 1 neighbours."""
    x = simplex(d)[1]
    spokes = sp.Matrix(d + 1, d, lambda b, k: sp.Symbol(f"e{b}{k}", real=True))
    total = sp.zeros(d, 1)
    for left_out in range(d + 1):
        edges = spokes.copy()
        edges.row_del(left_out)
        half = sp.Matrix(squared_lengths(edges)) / 2
        opposite = spokes[left_out, :]
        height = ((opposite * opposite.T) / 2 - opposite * x)[0] + shift
        # det (p_a - x), with det p_a = adj(edges) half: no division
        toward = edges.adjugate() * half - edges.det(method="berkowitz") * x
        total += (-1) ** left_out * height * toward
    return sum(sp.Symbol(f"t{k}") * total[k] for k in range(d))


# --- proofs, and refutations of similar claims --------------------------------------------------


CLAIMS = [volume_claim, weight_claim, circumcenter_claim, height_claim, precision_claim]
PROOFS = [(claim, d) for claim in CLAIMS for d in DIMENSIONS]


@pytest.mark.slow
@pytest.mark.parametrize(("claim", "d"), PROOFS)
def test_the_claims_are_proved(claim, d):
    """They hold for every simplex, every point inside or outside, and every orientation."""
    assert vanishes(claim(d))


@pytest.mark.slow
@pytest.mark.parametrize("d", DIMENSIONS)
@pytest.mark.parametrize(
    "mutant",
    [
        lambda d: volume_claim(d, factor=1),
        lambda d: volume_claim(d, power=2),
        lambda d: weight_claim(d, keep_lengths=True),
        lambda d: height_claim(d, half=1),
        lambda d: precision_claim(d, shift=1),
    ],
    ids=["without D!", "squares of lengths", "unit normals kept", "whole squares", "heights moved"],
)
def test_similar_formulas_are_refuted(mutant, d):
    assert not vanishes(mutant(d))
