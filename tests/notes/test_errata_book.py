"""Errors and omissions of the appendix and the book on surfaces, splines and kernels.

Each counterexample follows the printed sentence, mostly in rational numbers; the correct statement
is then tested on the library as well. The chapter on the errata of the book and the appendix names
every test of the files test_errata_*.py, and no other.
"""

import itertools
import re
from fractions import Fraction as F
from pathlib import Path

import numpy as np
import pytest

from fieldrecon.kernels.conditionally_positive_definite import polyharmonic
from fieldrecon.methods.functionals import derivatives_at, values_at
from fieldrecon.methods.hermite import HermiteRBF
from fieldrecon.methods.natural_splines import NaturalCubicSpline
from fieldrecon.methods.rbf import RBF
from fieldrecon.surfaces.normal_orientation import orient_normals
from fieldrecon.surfaces.normals import estimate_normals
from rational import determinant, dot, rank, solved
from report_fixtures import REPORT

CHAPTER = REPORT / "chapters" / "23-errata-of-the-book.md"


def test_the_chapter_names_every_test_and_no_other():
    """A claim is in the chapter if and only if a test of these files demonstrates it."""
    files = Path(__file__).parent.glob("test_errata_*.py")
    here = [name for f in files for name in re.findall(r"^def (test_\w+)", f.read_text(), re.M)]
    here.remove("test_the_chapter_names_every_test_and_no_other")
    named = re.findall(r"`(test_\w+)`", CHAPTER.read_text("utf-8"))
    assert sorted(named) == sorted(here)


# --- the appendix: conditionally positive definite functions --------------------------------------


def test_there_is_a_coefficient_for_each_point():
    """α is in R^N and P is N × Q. With α in R^d and P in R^(Q × N) the shapes do not match."""
    x = np.random.default_rng(1).random((7, 2))
    a = polyharmonic(3)(np.linalg.norm(x[:, None] - x, axis=-1))
    p = np.column_stack([np.ones(7), x])
    zero = np.zeros((3, 3))
    with pytest.raises(ValueError, match="must match exactly"):
        np.block([[a, p.T], [p, zero]])
    with pytest.raises(ValueError, match="mismatch"):
        np.ones(2) @ a
    assert np.block([[a, p], [p.T, zero]]).shape == (10, 10)


def cubes(x, y):
    """|x - y|³ for integers, or for points on a line with a direction of integer length."""
    return F(abs(x - y)) ** 3


def test_the_order_is_one_more_than_the_degree():
    """The form of r³ is positive under side conditions of degree ≤ 1, so its order is 2, not 1.

    φ(s) = s^(3/2): -φ' is negative, so (-1)^m φ^(m) is not completely monotone for m = 1. Under Σα
    = 0 alone the form of r³ is indefinite.
    """
    x = [F(0), F(1), F(2), F(5)]
    second = [F(1), F(-2), F(1), F(0)]  # annihilates 1 and x
    first = [F(1), F(-1), F(0), F(0)]  # annihilates 1
    form = {
        name: sum(
            a * b * cubes(p, q)
            for a, p in zip(alpha, x, strict=True)
            for b, q in zip(alpha, x, strict=True)
        )
        for name, alpha in (("second", second), ("first", first))
    }
    assert form["second"] > 0 > form["first"]
    assert polyharmonic(3).order == 2


def test_complete_monotonicity_gives_semidefiniteness_only():
    """φ(s) = -s: -φ' = 1 is completely monotone, but Σααφ = 2|Σαx|² vanishes for α = 1, -2, 1."""
    alpha = [F(1), F(-2), F(1)]
    x = [F(0), F(1), F(2)]
    form = sum(
        -a * b * (p - q) ** 2
        for a, p in zip(alpha, x, strict=True)
        for b, q in zip(alpha, x, strict=True)
    )
    assert sum(alpha) == 0
    assert form == 0


def test_solvability_does_not_imply_uniqueness():
    """r³ and linear polynomials on five collinear points: rank 7 of 8, yet always solvable."""
    t = [F(0), F(1), F(2), F(3), F(5)]  # the points t (3, 4), at distances 5 |t - u|
    a = [[125 * cubes(p, q) for q in t] for p in t]
    p = [[F(1), 3 * u, 4 * u] for u in t]
    h = [row + b for row, b in zip(a, p, strict=True)]
    h += [list(column) + [F(0)] * 3 for column in zip(*p, strict=True)]
    assert rank(h) == 7
    for i in range(5):
        data = [F(int(j == i)) for j in range(8)]
        assert rank([[*row, f] for row, f in zip(h, data, strict=True)]) == 7
    # the null space is the polynomial 4x - 3y, which vanishes at the points
    free = [F(0)] * 5 + [F(0), F(4), F(-3)]
    assert all(dot(row, free) == 0 for row in h)
    with pytest.raises(np.linalg.LinAlgError, match="rank 2 of 3"):
        RBF(np.array([[3.0 * u, 4.0 * u] for u in t]), polyharmonic(3))


# --- the book, section 1.1: normals and signs -----------------------------------------------------


def test_close_eigenvalues_are_not_needed_for_a_normal():
    """p. 3: a strip with λ₁ ≫ λ₂ ≫ λ₃, 100 times as long as wide, has an accurate normal."""
    rng = np.random.default_rng(2)
    strip = rng.random((200, 3)) * [100.0, 1.0, 0.0] + rng.standard_normal((200, 3)) * 1e-6
    estimate = estimate_normals(strip, neighbors=200)
    assert np.abs(estimate.vectors[:, 2]).min() > 1 - 1e-9
    assert estimate.planar.all()


def test_the_printed_sum_of_signs_has_an_inconsistent_minimum():
    """p. 3: Σ b_j b_k (1 - |η_jᵀη_k|) is minimal for inconsistent signs.

    Σ b_j b_k η_jᵀη_k is maximal for consistent signs. All signs of twelve normals on a circle are
    tried.
    """
    angle = 2 * np.pi * np.arange(12) / 12
    normals = np.column_stack([np.cos(angle), np.sin(angle)])
    edges = [(j, (j + step) % 12) for j in range(12) for step in (1, 2)]
    flips = np.random.default_rng(3).choice([-1, 1], 12)
    given = flips[:, None] * normals
    dots = np.array([given[j] @ given[k] for j, k in edges])
    signs = np.array(list(itertools.product([1], *[[-1, 1]] * 11)))
    pairs = np.array([signs[:, j] * signs[:, k] for j, k in edges]).T

    def consistent(b):
        return abs((b * flips).sum()) == 12

    book = pairs @ (1 - np.abs(dots))
    least = signs[book < book.min() + 1e-12]
    assert not any(consistent(b) for b in least)
    ours = pairs @ dots
    greatest = signs[ours > ours.max() - 1e-12]
    assert len(greatest) == 1
    assert consistent(greatest[0])


def test_one_normal_orients_one_connected_component():
    """p.

    3: two separate bodies have two spanning trees. Each needs its own root and outward direction.
    """
    x = np.random.default_rng(4).standard_normal((300, 3))
    x /= np.linalg.norm(x, axis=1, keepdims=True)
    bodies, true = np.vstack([x, x + 5.0]), np.vstack([x, x])
    flips = np.random.default_rng(5).choice([-1, 1], 600)[:, None]
    oriented = orient_normals(bodies, flips * true)
    assert (np.einsum("nd,nd->n", oriented, true) > 0).all()
    # no edge of the neighbourhood graph connects them, so the sum of signs does not depend on it
    distances = np.linalg.norm(bodies[:300, None] - bodies[None, 300:], axis=-1)
    assert distances.min() > 5


def test_the_gradient_of_a_function_positive_inside_points_inwards():
    """p. 2-4: if F > 0 inside and η points outwards, then ∇F / |∇F| = -η."""
    t = 2 * np.pi * np.arange(20) / 20
    eta = np.column_stack([np.cos(t), np.sin(t)])
    data = np.repeat([0.0, -1.0], 20)
    field = HermiteRBF([values_at(eta), derivatives_at(eta, eta)], polyharmonic(3)).field(data)
    assert float(field([0.0, 0.0])) > 0
    along = np.einsum("nd,nd->n", field.gradient(eta), eta)
    assert np.abs(along + 1).max() < 1e-8


def test_the_nearest_point_can_give_the_wrong_side():
    """p. 4: a point outside a wedge can lie behind the tangent plane of its nearest sample.

    This happens near a sparsely sampled edge, and at an edge below 90° for dense samples, too. The
    ray x - x_j must be used, because a line has no sign.
    """
    # the wedge x < 0 and y < x, whose faces are sampled one unit away from the edge
    points = {(F(0), F(-1)): (F(1), F(0)), (F(-1), F(-1)): (F(-1), F(1))}
    x = (F(1, 20), F(3, 20))  # outside: x > 0
    nearest = min(points, key=lambda p: (p[0] - x[0]) ** 2 + (p[1] - x[1]) ** 2)
    ray = [x[0] - nearest[0], x[1] - nearest[1]]
    assert nearest == (F(0), F(-1))
    assert dot(ray, points[nearest]) > 0
    y = (F(-1, 20), F(3, 20))  # outside too: y > x
    ray = [y[0] - nearest[0], y[1] - nearest[1]]
    assert min(points, key=lambda p: (p[0] - y[0]) ** 2 + (p[1] - y[1]) ** 2) == nearest
    assert dot(ray, points[nearest]) < 0  # "inside"
    far = (F(-1), F(3))
    for step in (F(1, 10), F(1, 100), F(1, 10000)):
        places = [k * step for k in range(5)]
        upright = [(F(0), -step / 10 - k) for k in places]
        oblique = [(-step * 9 / 10 - k, -step * 9 / 10 - k) for k in places]
        samples = [*upright, *oblique]
        nearest = min(samples, key=lambda p: (p[0] - far[0]) ** 2 + (p[1] - far[1]) ** 2)
        assert nearest == upright[0]
        assert far[0] - nearest[0] < 0  # "inside", by the normal (1, 0)


def test_off_surface_points_may_lie_beyond_the_opposite_sheet():
    """p. 3-4: for a slab of thickness 1/10 the point x_j - dη may be nearer to the other sheet.

    It is inside for d = 1/25 and outside for 3/20. For d = 3/50 it is nearer to the other sheet.
    The condition must be that x_j is its nearest point.
    """
    upper, lower = F(0), F(-1, 10)
    for d, inside, own in (
        (F(1, 25), True, True),
        (F(3, 50), True, False),
        (F(3, 20), False, False),
    ):
        x = upper - d
        assert (lower < x < upper) == inside
        assert (min((upper, lower), key=lambda sheet, x=x: abs(sheet - x)) == upper) == own


# --- the book, section 1.4: splines ---------------------------------------------------------------


def test_the_third_derivative_is_zero_from_outside_only():
    """p. 8: s'''(x₁) = 0 is the limit from outside.

    The limit from inside is the jump 6 α₁, here -3. The natural spline of the data 0, 1, 0 at 0, 1,
    2 is 3x/2 - x³/2 on [0, 1] and a line to the left.
    """
    method = NaturalCubicSpline([0.0, 1.0, 2.0])
    s = method.field([0.0, 1.0, 0.0])
    for start, third in ((-0.5, 0.0), (0.0, -3.0)):
        slopes = s.gradient(np.array([start, start + 0.25, start + 0.5]))
        assert (slopes[2] - 2 * slopes[1] + slopes[0]) / 0.25**2 == pytest.approx(third, abs=1e-12)
    assert 6 * method.truncated_powers([0.0, 1.0, 0.0])[0][0] == pytest.approx(-3)
    # if it were zero on both sides, s would be the line s(x) = x on [0, 1], with s(1/2) = 1/2
    assert float(s(0.5)) == pytest.approx(11 / 16)


def test_natural_splines_of_one_site_have_dimension_two():
    """p.

    8, proposition 1.1: dim NS₃ = N needs N ≥ 2. For one site (1.6) gives α = 0 and leaves π₁.
    """
    for sites in ([F(3)], [F(0), F(3)], [F(0), F(3), F(4)]):
        n = len(sites)
        conditions = [[F(1)] * n, list(sites)]
        assert n + 2 - rank(conditions) == max(n, 2)
    with pytest.raises(np.linalg.LinAlgError, match="rank 1 of 2"):
        NaturalCubicSpline([3.0])


def test_one_constant_interpolates_at_any_single_point():
    """p. 8: the theorem on N functions in R^d, d ≥ 2, needs N ≥ 2.

    For N = 1 a constant interpolates. The theorem also needs interior points: on a line in the
    plane, 1 and x interpolate at any two points.
    """
    for x in ((F(0), F(0)), (F(5), F(-2))):
        assert determinant([[F(1) for _ in [x]]]) != 0
        assert solved([[F(1)]], [F(7)]) == [F(7)]
    line = [(F(k), 2 * F(k)) for k in range(6)]
    for p, q in itertools.combinations(line, 2):
        assert determinant([[F(1), p[0]], [F(1), q[0]]]) != 0
    # two distinct points of the plane may have equal x, and then 1 and x are equal at both
    assert determinant([[F(1), F(1)], [F(1), F(1)]]) == 0
