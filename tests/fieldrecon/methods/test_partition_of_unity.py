"""Partition-of-unity RBF: smoothness, accuracy, unusual point sets, memory and refusals."""

import itertools
import multiprocessing
import re
import tracemalloc
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor

import numpy as np
import pytest
import sympy
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrecon._core import chunks as _chunks
from fieldrecon._numerics.jets import composition, product, quotient, rows_of_jet, upper_pairs
from fieldrecon._numerics.kd_partition import KDPartition, halved
from fieldrecon.datasets.synthetic import clustered, franke, halton, uniform
from fieldrecon.kernels.conditionally_positive_definite import (
    multiquadric,
    polyharmonic,
    thin_plate_spline,
)
from fieldrecon.kernels.positive_definite import (
    gaussian,
    inverse_multiquadric,
    matern,
    wendland,
)
from fieldrecon.kernels.weights import inverse_square
from fieldrecon.methods.partition_of_unity import blending as _blending
from fieldrecon.methods.partition_of_unity import patches as _patches
from fieldrecon.methods.partition_of_unity.ball_weights import COVERED, REACH, weights_of_balls
from fieldrecon.methods.partition_of_unity.batched_systems import (
    COLUMNS,
    _orthogonal,
    batched_solve_grouped,
    solved,
)
from fieldrecon.methods.partition_of_unity.method import PartitionOfUnityRBF
from fieldrecon.methods.partition_of_unity.patch_systems import relative_miss
from fieldrecon.methods.partition_of_unity.polynomial_rank import (
    orthonormal_basis,
    whole_degrees,
)
from fieldrecon.methods.rbf import RBF
from fieldrecon.polynomials import dimension, monomials
from fieldrecon.selection.leaving_one_out import leave_one_out
from laws import assert_close, assert_same_bits, refused

X = halton(1500, 2)
ROUND_ONE = (1 - 1e-12, 1 + 1e-12)


def wave(x: np.ndarray) -> np.ndarray:
    return np.sin(x @ np.linspace(2.0, 4.0, x.shape[-1]))


def tracks() -> np.ndarray:
    """Eight parallel scan lines with two hundred sites on each."""
    along, across = np.meshgrid(np.linspace(0, 1, 200), np.linspace(0, 1, 8))
    x = np.stack([along, across], axis=-1).reshape(-1, 2)
    return x + 1e-5 * np.random.default_rng(1).random(x.shape)


# --- patches --------------------------------------------------------------------------------------


@pytest.mark.parametrize("d", [1, 2, 3, 5])
@pytest.mark.parametrize("n", [1, 2, 7, 8, 15, 100, 333])
def test_boxes_contain_each_site_once_in_nearly_equal_numbers(n, d):
    """The numbers of sites differ by at most one, and each site lies in its box.

    They are the fewest boxes, of at most seven slabs across the longest side, of at most 6.5 sites.
    """
    x = np.random.default_rng(n).random((n, d))
    boxes = KDPartition.around(x, 6.5)
    counts = (boxes.sites >= 0).sum(axis=1)
    assert counts.max() - counts.min() <= 1
    numbers = [s * 2**levels for s in range(1, 8) for levels in range(12)]
    assert len(counts) == min(number for number in numbers if number >= n / 6.5)
    assert len(boxes.slabs) < 7
    assert boxes.across == np.ptp(x, axis=0).argmax()
    there = boxes.sites >= 0
    assert sorted(boxes.sites[there]) == list(range(n))
    renumbered, order = boxes.in_order()
    assert np.array_equal(renumbered.sites[there], np.arange(n))
    assert np.array_equal(order, boxes.sites[there])
    assert {*boxes.sites[~there], *renumbered.sites[~there]} <= {-1}
    box = np.nonzero(there)[0]
    np.testing.assert_array_equal(boxes.containing(x[boxes.sites[there]]), box)


@pytest.mark.parametrize("order", [0, 1, 2])
@pytest.mark.parametrize("d", [1, 2, 3])
def test_jets_obey_the_rules_of_calculus(d, order):
    """Those of a product of linear functions are known; others follow by powers and inverses."""
    rng, rows = np.random.default_rng(d), rows_of_jet(d, order)
    p, q = np.zeros((2, 10, 5))
    p[: 1 + d], q[: 1 + d] = rng.uniform(1, 2, (2, 1 + d, 5))
    second = [p[1 + k] * q[1 + j] + p[1 + j] * q[1 + k] for k, j in upper_pairs(d)]
    exact = np.stack([p[0] * q[0], *(p[0] * q[1 : 1 + d] + q[0] * p[1 : 1 + d]), *second])[:rows]
    p, q = p[:rows], q[:rows]
    u = product(p, q, d)
    assert_close(u, exact, 1e-14)
    assert_close(quotient(u, q, d), p, 1e-14)
    for v in (p, u):
        assert_close(
            composition((v[0] ** 2, 2 * v[0], 2 + 0 * v[0]), v, d), product(v, v, d), 1e-13
        )
        one = np.zeros_like(v)
        one[0] = 1.0
        inverse = composition((1 / v[0], -(v[0] ** -2), 2 * v[0] ** -3), v, d)
        assert_close(quotient(one, v, d), inverse, 1e-14)
        assert_close(product(inverse, v, d), one, 1e-13)


@pytest.mark.parametrize("missing", [0, 1])
def test_a_row_of_sites_is_cut_across_its_longest_side(missing):
    """Whichever site is the last, also if one is missing; its coordinates do not count."""
    for last, seed in np.ndindex(9, 10):
        x = 5 + np.random.default_rng(seed).random((9, 3))
        axis = np.ptp(x, axis=0).argmax()
        row = np.append(np.roll(np.arange(9), -1 - last), np.full(missing, -1))
        found, cut, halves, _ = halved(row[None], np.where(row >= 0, x.T[:, row], 0.0)[:, None])
        assert found == [axis]
        left, right = (x[half[half >= 0], axis] for half in halves)
        assert left.max() < cut[0] < right.min()
        assert len(left) + len(right) == 9
        assert abs(len(left) - len(right)) == 1


@pytest.mark.parametrize("n", [1, 9, 90])
@pytest.mark.parametrize("d", [1, 2, 3])
def test_a_ball_reaches_into_the_boxes_that_are_no_farther_than_its_radius(d, n):
    """In ascending order, also where balls touch boxes, as many do about nodes of a lattice.

    A box ends at the cuts that made it, or nowhere.
    """
    rng = np.random.default_rng(n)
    boxes = KDPartition.around(rng.integers(0, 9, (200, d)) * 1.0, 6.5)
    ends = [-np.inf, *boxes.slabs, np.inf]
    low, high = (np.tile(side * np.inf, (len(ends) - 1, d)) for side in (-1, 1))
    low[:, boxes.across], high[:, boxes.across] = ends[:-1], ends[1:]
    for axis, cut in boxes.halvings:
        low, high = np.repeat(low, 2, axis=0), np.repeat(high, 2, axis=0)
        box = np.arange(len(cut))
        low[2 * box + 1, axis] = high[2 * box, axis] = cut
    centers, radii = rng.integers(0, 18, (n, d)) / 2, rng.integers(1, 6, n) / 2
    away = np.maximum(np.maximum(low[:, None] - centers, centers - high[:, None]), 0)
    balls = [np.flatnonzero(row).tolist() for row in (away**2).sum(axis=2) <= radii**2]
    ball, start = boxes.reached(centers, radii)
    assert [part.tolist() for part in np.split(ball, start[1:-1])] == balls


@pytest.mark.slow
@settings(max_examples=40)
@given(st.integers(1, 4), st.integers(0, 10**6), st.booleans())
def test_the_patches_of_a_query_are_those_whose_balls_contain_it(d, seed, lattice):
    """The reference tests all balls, also for points with equal coordinates."""
    rng = np.random.default_rng(seed)
    x = np.unique(rng.integers(0, 9, (300, d)), axis=0) / 9 if lattice else rng.random((300, d))
    method = PartitionOfUnityRBF(x, polyharmonic(1), 0, 6)
    for level in method._levels:
        own = level.patches
        q = np.concatenate([2 * rng.random((30, d)) - 1, own.centers[:5]])
        away = np.linalg.norm((q[:, None] - own.centers) / own.radii[:, None], axis=2)
        pairs = own.containing(q)
        found = set(zip(pairs.query.tolist(), pairs.patch.tolist(), strict=True))
        surely, perhaps = (set(map(tuple, np.argwhere(away < r).tolist())) for r in ROUND_ONE)
        assert surely <= found <= perhaps


def test_the_weight_of_a_ball_vanishes_from_its_radius_on():
    """And is (1 - r)^4 (4 r + 1) at the distance r, in units of the radius, of each ball."""
    r = np.array([0.0, 0.25, 0.99, 1.0, 1.2, 3.0])
    centers, radii = np.array([[1.0, 2.0], [-3.0, 0.5]]), np.array([0.5, 4.0])
    x = centers[:, None] + np.multiply.outer(radii, r)[..., None] * [0.6, -0.8]
    expected = np.maximum(1 - r, 0) ** 4 * (4 * r + 1)
    assert_close(weights_of_balls(centers, radii, x), np.tile(expected, (2, 1)), 1e-14)


@pytest.mark.parametrize("side", [[-30.0, -30.0], [-30.0, 30.0], [30.0, -30.0], [30.0, 30.0]])
def test_balls_end_at_the_next_site_or_in_a_gap_and_reach_beyond_all_sites(side):
    """In the gap about a cluster at twice the distance of its farthest site.

    An outlier is the middle of a ball.
    """
    outlier, cluster = np.array([side]), halton(12, 2) - side
    m = PartitionOfUnityRBF(np.vstack([X[:150], outlier, cluster]), polyharmonic(1), 0, 12)
    points, patches = m._frame.local(m.points), m._levels[0].patches
    away = np.linalg.norm(points - patches.centers[:, None], axis=2)
    own, following = np.sort(away, axis=1)[:, 11:13].T
    assert_close(patches.radii, np.minimum(following, _patches.WIDEST * own), 1e-12)
    in_gap = patches.radii < following - 1e-12
    assert 0 < in_gap.sum() < len(patches) / 2
    assert ((away / patches.radii[:, None]).min(axis=0) <= REACH).all()


@pytest.mark.parametrize("d", [1, 2, 3])
def test_each_site_in_a_box_of_its_own_is_the_centre_of_a_patch(d):
    """Patches of two sites have such boxes, some of which are empty."""
    m = PartitionOfUnityRBF(uniform(50, d, seed=1), polyharmonic(1), 0, 2)
    centers = m._levels[0].patches.centers
    assert sorted(centers.tolist()) == sorted(m._frame.local(m.points).tolist())


@pytest.mark.parametrize("k", [2, 3, 5, 11, 50])
def test_levels_have_decreasing_numbers_of_sites(k):
    """Each has a third to a tenth of the sites of the previous one: a third for small patches.

    The last one is a single patch.
    """
    levels = PartitionOfUnityRBF(halton(700, 2), polyharmonic(1), 0, k)._levels
    sizes = np.array([len(level.sites) for level in levels])
    third = np.ceil(sizes[:-1] / 3)
    assert (sizes[1:] <= third).all()
    assert (sizes[1:] >= sizes[:-1] // 10).all()
    assert (sizes[1:] == third).all() == (k < 4)
    assert len(levels[-1].patches) == 1
    assert levels[-1].patches.containing(X[:3]).patch.tolist() == [0, 0, 0]


@pytest.mark.parametrize(("each", "halves"), [(9, 1), (10, 1), (11, 2)])
def test_one_of_at_most_ten_sites_of_a_box_is_on_the_next_level(each, halves):
    """Boxes of eleven are halved. Here 64 boxes have the same number of sites each."""
    levels = PartitionOfUnityRBF(halton(64 * each, 2), polyharmonic(1), 0, 3 * each)._levels
    assert len(levels[1].sites) == 64 * halves


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("side", [-1, 1])
def test_a_site_far_outside_the_box_of_the_chosen_ones_is_chosen_too(axis, side):
    """On any side, if it is beyond by more than half of the width of the box."""
    middle, half = np.array([0.5, 12.0]), np.array([2.0, 3.0])
    for beyond, chosen in ((0.9, []), (1.1, [2])):
        site = middle + side * (1 + beyond) * half * np.eye(2)[axis]
        points = np.stack([middle - half, middle + half, site])
        assert _patches._outliers(points, np.array([0, 1])).tolist() == chosen


def test_the_chosen_sites_are_the_nearest_to_the_middles_of_their_boxes():
    """Whichever place they have in their boxes, and in the order of the sites."""
    for middle in range(3):
        order = np.roll([0.0, -1.0, 1.0], middle)
        points = np.add.outer([0.0, 10.0, 20.0], order).reshape(9, 1)
        chosen = _patches._thinned(points, np.arange(9).reshape(3, 3))
        assert_close(points[chosen, 0], [0.0, 10.0, 20.0], 0.0)
    alone = np.arange(9)[:, None]  # every third of them, from the first one on
    assert _patches._thinned(1.0 * alone, alone).tolist() == [0, 3, 6]


def test_a_place_without_a_site_in_a_box_is_not_chosen():
    """Although the last of all sites is nearer to the middle of the box than its own three."""
    box = [[-5.0, 0.0], [5.0, 0.0], [5.0, 0.1]]
    other = [[-1.0, 2.0], [1.0, 2.0], [0.0, 3.0], [0.0, 1.0]]
    rows = np.array([[0, 1, 2, -1], [3, 4, 5, 6]])
    assert _patches._thinned(np.array(box + other), rows).min() >= 0


def test_few_sites_share_a_patch_unless_they_are_narrow_clusters():
    """At most four times the sites of a patch; three in any case, and twelve for each axis of a
    coarser level. The unit does not matter."""
    even, cluster = halton(90, 2), 1e-6 * halton(90, 2)
    pairs = np.concatenate([np.add.outer([0.0, 1.0], c) for c in cluster])
    for points, k, finest, size in (
        (even[:80], 20, True, 80),
        (even[:81], 20, True, 20),
        (cluster[[0, 0, 0, 0, 0]], 3, True, 5),
        (pairs[:3], 3, True, 3),
        (pairs[:4], 3, True, 2),
        (pairs[:24], 20, False, 24),
        (pairs[:25], 20, False, 12),
    ):
        for unit in (1e-5, 1.0, 1e5):
            assert _blending._patch_size(unit * points, k, finest) == size


def test_levels_of_sites_on_an_axis_are_those_of_one_variable():
    """A coordinate that all sites have in common has no extreme sites."""
    line = np.random.default_rng(4).random((200, 1))
    in_plane = np.column_stack([np.full(200, 0.3), line])
    found = [PartitionOfUnityRBF(x, polyharmonic(1), 0, 30)._levels for x in (line, in_plane)]
    for one, other in zip(*found, strict=True):
        np.testing.assert_array_equal(one.sites, other.sites)


def test_methods_on_the_same_sites_share_their_patches():
    """Kernel, degree and smoothing may differ; the fields are those of methods of their own."""
    x, others = X[:400], uniform(400, 2, seed=8)
    settings = [
        (x, polyharmonic(3), 3, 40),
        (x, polyharmonic(1), 0, 40, 1e-3),
        (x, polyharmonic(3), 3, 60),
        (others, polyharmonic(3), 3, 40),
        (x, thin_plate_spline(), 2, 40),
    ]
    with _blending.shared_patches():
        shared = [PartitionOfUnityRBF(*one) for one in settings]
    for one, method in zip(settings, shared, strict=True):
        fields = [m.field(wave(m.points)) for m in (method, PartitionOfUnityRBF(*one))]
        assert_same_bits(*(field(x[:50] + 0.001) for field in fields))
    patches = [method._levels[0].patches for method in shared]
    assert [one is patches[0] for one in patches] == [True, True, False, False, True]
    assert PartitionOfUnityRBF(*settings[0])._levels[0].patches is not patches[0]


@pytest.mark.parametrize("kernel", [polyharmonic(3), matern(2.5, 3.0)], ids=repr)
@pytest.mark.parametrize("d", [1, 2, 3])
def test_one_patch_equals_rbf(d, kernel):
    """Values, gradients and second derivatives agree with `RBF`."""
    x = 10 * np.random.default_rng(d).random((40, d))
    q = 10 * np.random.default_rng(9).random((50, d))
    one, other = (method(x, kernel, 1).field(wave(x)) for method in (PartitionOfUnityRBF, RBF))
    assert_close(one(q), other(q), 1e-8)
    assert_close(one.gradient(q), other.gradient(q), 1e-7)
    assert_close(one.hessian(q), other.hessian(q), 1e-6)


@pytest.mark.parametrize(
    "kernel", [polyharmonic(3), thin_plate_spline(), matern(2.5, 0.3)], ids=repr
)
@pytest.mark.parametrize("smoothing", [0.01, np.linspace(0.001, 0.1, 200)], ids=["same", "own"])
def test_each_patch_has_the_rbf_of_its_sites_with_their_smoothing(kernel, smoothing):
    """However small it is."""
    x, q = 10 * X[:200], 10 * uniform(20, 2, seed=3)
    m = PartitionOfUnityRBF(x, kernel, 1, 12, smoothing)
    systems = m._levels[0].systems[0]
    coefficients = m._prepare(wave(x)[:, None])[0][0]
    for patch in (0, len(systems) - 1):
        own = m._levels[0].sites[systems.sites[patch]]
        alone = RBF(x[own], kernel, 1, np.broadcast_to(smoothing, 200)[own]).field(wave(x[own]))
        values = systems.values(np.full(20, patch), m._frame.local(q), coefficients)
        assert_close(values[:, 0], alone(q), 1e-8 * np.abs(values).max())


# --- smoothness -----------------------------------------------------------------------------------


def test_the_next_level_has_a_weight_where_those_of_a_level_sum_to_less_than_c():
    """It is c (1 - W/c)^3 of their sum W, and zero from W = c on."""
    w = np.array([0.0, 0.5, 0.9, 1.0, 1.5, 100.0])
    taken = _blending._taken_over(COVERED * w[None], 2)
    assert_close(taken[0], COVERED * np.array([1.0, 0.125, 0.001, 0.0, 0.0, 0.0]), 1e-16)


def test_derivatives_of_small_patches_are_the_limits_of_difference_quotients():
    """Also of kernels with a length, inside and outside of the balls."""
    sites, q = X[:60], 1.4 * halton(80, 2, seed=1) - 0.2
    field = PartitionOfUnityRBF(sites, matern(3.5, 0.4), 2, 12).field(wave(sites))
    for function, derivative in ((field, field.gradient), (field.gradient, field.hessian)):
        steps = [1e-6 * unit for unit in np.eye(2)]
        quotient = np.stack([function(q + h) - function(q - h) for h in steps], axis=-1) / 2e-6
        exact = derivative(q)
        error = np.linalg.norm((exact - quotient).reshape(80, -1), axis=1)
        assert (error < 1e-5 * (1 + np.linalg.norm(exact.reshape(80, -1), axis=1))).all()


def largest_jump_of_the_second_derivative(step: float) -> float:
    """Largest jump along a line that crosses many balls and leaves the point set."""
    s = PartitionOfUnityRBF(X, polyharmonic(5), 2, 16).field(wave(X))
    t = np.arange(0.6, 1.5, step)
    slope = s.gradient(np.column_stack([t, 0.3 + 0.5 * t])) @ [1.0, 0.5]
    second = np.diff(slope) / step
    return float(np.abs(np.diff(second)).max())


@pytest.mark.slow
def test_fields_are_twice_continuously_differentiable():
    """The line crosses the boundaries of balls and enters the region of coarser patches."""
    coarse, fine = map(largest_jump_of_the_second_derivative, (1e-4, 2.5e-5))
    assert fine < 0.35 * coarse


@pytest.mark.parametrize("d", [1, 2])
def test_where_patches_agree_their_weights_have_no_part_in_derivatives(d):
    """Of a constant only rounding is left; sums of derivatives of weights lose more digits."""
    sites = np.random.default_rng(d).random((60, d))
    field = PartitionOfUnityRBF(sites, gaussian(0.1), 0, 2).field(np.ones(60))
    x = np.random.default_rng(0).random((300, d))
    assert np.median(np.abs(field.gradient(x)).max(axis=1)) < 5e-16
    assert np.median(np.abs(field.hessian(x)).max(axis=(1, 2))) < 5e-14


@pytest.mark.slow
def test_a_weight_with_a_kink_is_not_twice_differentiable(monkeypatch):
    """The test above detects (1 - r)², whose second derivative jumps at the boundary."""

    def kinked(offset, order):
        r = np.linalg.norm(offset, axis=1)
        inward = np.where(r > 0, -2 * (1 - r) / np.where(r > 0, r, 1), 0.0)
        return np.vstack([(1 - r) ** 2, inward * offset.T])[: 1 + 2 * order]

    monkeypatch.setattr(_blending, "bump", kinked)
    coarse, fine = map(largest_jump_of_the_second_derivative, (1e-4, 2.5e-5))
    assert fine > 0.7 * coarse


# --- accuracy -------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize(("power", "degree", "order"), [(3, 1, 1.8), (3, 3, 3.5), (5, 2, 2.8)])
def test_the_error_converges_with_the_degree(power, degree, order):
    """The order of convergence is nearly degree + 1 or higher."""
    q = 0.05 + 0.9 * halton(3000, 2, seed=1)
    sizes, errors = np.array([2000, 8000, 32000]), []
    for n in sizes:
        x = halton(n, 2)
        s = PartitionOfUnityRBF(x, polyharmonic(power), degree).field(franke(x))
        errors.append(np.sqrt(np.mean((s(q) - franke(q)) ** 2)))
    assert -2 * np.polyfit(np.log(sizes), np.log(errors), 1)[0] > order


def error_near_the_boundary() -> float:
    x, q = np.random.default_rng(1).random((2, 8000, 3))
    error = np.abs(PartitionOfUnityRBF(x).field(wave(x))(q) - wave(q))
    return error.max() / np.sqrt(np.mean(error**2))


@pytest.mark.slow
def test_the_error_near_the_boundary_is_bounded(monkeypatch):
    """Outside the balls, patches with a few times fewer sites are used, not 100 times fewer."""
    known = error_near_the_boundary()
    monkeypatch.setattr(_patches, "THINNED", 10**9)
    assert known < 60
    assert error_near_the_boundary() > 1.5 * known


@pytest.mark.slow
def test_clusters_of_very_different_sizes_are_interpolated():
    """Patches between clusters are singular up to rounding, and still interpolate smooth data."""
    rng = np.random.default_rng(0)
    x = np.concatenate(
        [rng.random((800, 2)), 0.5 + 1e-4 * rng.random((800, 2)), 0.2 + 1e-7 * rng.random((200, 2))]
    )
    for power in (3, 5, 7):
        s = PartitionOfUnityRBF(x, polyharmonic(power), 3).field(franke(x))
        assert_close(s(x), franke(x), 1e-7)


def test_a_patch_of_all_sites_keeps_a_constant_far_away():
    """Although the kernel multiplies the rounding of its coefficients by 1e7 there."""
    field = PartitionOfUnityRBF(X[:12], polyharmonic(3), 1).field(np.ones(12))
    assert_close(field([[100.0, 200.0], [-150.0, 90.0]]), np.ones(2), 1e-11)


def test_an_outlier_spoils_nothing_elsewhere():
    """In the cloud the field is as accurate as without it, however far away it is.

    At the outlier the field extrapolates the cloud, which magnifies rounding errors.
    """
    x, q = X[:100], 0.1 + 0.8 * halton(300, 2, seed=1)
    without = np.abs(PartitionOfUnityRBF(x).field(franke(x))(q) - franke(q)).max()
    for far in (1e2, 1e4, 1e6):
        p, f = np.vstack([x, [0.3 * far, 0.9 * far]]), np.append(franke(x), 0.5)
        s = PartitionOfUnityRBF(p).field(f)
        assert np.abs(s(q) - franke(q)).max() < 1.5 * without
        assert_close(s(x), franke(x), 1e-12)
        assert_close(s(p[-1]), f[-1], 1e-3)


def test_a_kernel_of_values_too_large_is_refused():
    """Products of entries of the systems must be numbers: 1e100 and not 1e160."""
    method = PartitionOfUnityRBF(X[:200], multiquadric(1e-100))
    assert_close(method.field(np.ones(200))(X[200:220]), np.ones(20), 1e-12)
    with refused("values of the kernel in a patch exceed 1e150", OverflowError):
        PartitionOfUnityRBF(X[:200], multiquadric(1e-160)).field(np.ones(200))


def test_coefficients_too_large_are_refused():
    """In words about their size, not about the kernel; no size of the data alone makes them so."""
    one, right = np.ones((1, 1, 1)), np.full((1, 1, 1), 1.7e308)
    with pytest.raises(OverflowError, match=r"coefficients of a patch exceed the range.*2e\+308"):
        relative_miss(one, np.full((1, 1, 1), np.inf), right)
    s = PartitionOfUnityRBF(X).field(np.full(len(X), 1.7e308))
    assert_close(s(X[:20]) / 1.7e308, np.ones(20), 1e-12)


def test_patches_interpolate_if_and_only_if_rounding_lets_them():
    """On a line of sites, weights at the sites are one and zero until the kernel is too flat.

    Between the scales of the two sides, rounding decides: of an error of the size of 1e-6.
    """
    x = (np.arange(60.0) / 60)[:, None] * np.array([1.0, 0.3])
    for kernel in (gaussian, inverse_multiquadric, multiquadric):
        for scale, meets in ((0.01, True), (0.02, True), (0.2, False), (1.0, False)):
            m = PartitionOfUnityRBF(x, kernel(scale), 1)
            assert m.interpolates is meets, f"{kernel.__name__} of scale {scale}"
            deviation = np.abs(m.weights(x).toarray() - np.eye(60)).max()
            assert (deviation < 1e-5) == meets, f"deviates by {deviation:.1e}"


def test_weights_of_flat_kernels_on_a_line_are_bounded():
    """Sites in their order along a line: a smooth right-hand side would not show the rounding."""
    x = (np.arange(60.0) / 60)[:, None] * np.array([1.0, 0.3])
    for kernel in (gaussian, inverse_multiquadric, multiquadric):
        for scale in (0.05, 0.1, 0.15, 0.2, 0.3, 1.0):
            h = PartitionOfUnityRBF(x, kernel(scale), 1).weights(x)
            assert np.abs(h.toarray()).sum(axis=1).max() < 5, f"{kernel.__name__} of scale {scale}"


def test_a_kernel_too_flat_for_rough_data_is_refused():
    """The message has the location of the patch, in the coordinates of the sites."""
    low, high = np.array([500.0, 20.0]), np.array([501.0, 22.0])
    sites = low + (high - low) * X
    for metric in (None, [1.0, 3.0], [[2.0, 1.0], [1.0, 1.0]]):
        m = PartitionOfUnityRBF(sites, gaussian(50.0), -1, 30, metric=metric)
        with pytest.raises(np.linalg.LinAlgError, match="would miss its data") as refusal:
            m.field(1e-9 * np.cos(1e4 * np.arange(len(X))))
        place = re.search(r"patch about \((.*), (.*)\) would", str(refusal.value))
        where = np.array([float(c) for c in place.groups()])
        assert ((low < where) & (where < high)).all()


def test_a_miss_of_a_patch_is_refused_as_far_as_the_blended_field_has_it():
    """If it exceeds a hundredth of the data, times the largest share of the patch at the site."""
    systems = PartitionOfUnityRBF(X[:300])._levels[0].systems[0]
    patches = np.arange(3)
    shares = systems._largest_shares(patches)
    miss = np.zeros((*shares.shape, 2))
    systems._refuse_a_miss(patches, miss)
    patch, place = np.argwhere((shares > 0.05) & (shares < 0.5))[-1]
    miss[patch, place, 1] = 0.009 / shares[patch, place]
    systems._refuse_a_miss(patches, miss)
    miss[patch, place, 1] = 0.011 / shares[patch, place]
    for missed in (miss, np.full_like(miss, 0.011)):
        with pytest.raises(np.linalg.LinAlgError, match="would miss its data by about 1e-02"):
            systems._refuse_a_miss(patches, missed)


def test_smoothing_reduces_noise():
    """The error of the field is less than half of that without smoothing."""
    x = halton(4000, 2)
    noisy = franke(x) + 0.1 * np.random.default_rng(1).normal(size=len(x))
    error = {
        smoothing: np.std(
            PartitionOfUnityRBF(x, polyharmonic(3), 1, 60, smoothing).field(noisy)(x) - franke(x)
        )
        for smoothing in (0.0, 1e-3)
    }
    assert error[1e-3] < 0.5 * error[0.0]


def test_leave_one_out_residuals_estimate_the_error():
    """Their root mean square is between 0.5 and 5 times the true error."""
    q = halton(1000, 2, seed=1)
    m = PartitionOfUnityRBF(X)
    error = np.sqrt(np.mean((m.field(franke(X))(q) - franke(q)) ** 2))
    own = np.sqrt(np.mean(leave_one_out(m, franke(X)) ** 2))
    assert 0.5 * error < own < 5 * error


def test_an_indispensable_site_is_named(monkeypatch):
    """Three sites with linear polynomials need each other, and many on a line the one beside it.

    No quotient by zero warns, also where threads share the patches.
    """
    m = PartitionOfUnityRBF(X[:3], thin_plate_spline(), 1)
    with pytest.raises(np.linalg.LinAlgError, match=r"without point 0, \(0, 0\), the others"):
        leave_one_out(m, wave(X[:3]))
    monkeypatch.setattr(_chunks, "CHUNK_BYTES", 2**12)
    sites = np.vstack([np.column_stack([np.linspace(0, 1, 90), np.zeros(90)]), [0.5, 0.25]])
    m = PartitionOfUnityRBF(sites, thin_plate_spline(), 1, 12)
    with pytest.raises(np.linalg.LinAlgError, match=r"without point 90, \(0.5, 0.25\), the others"):
        leave_one_out(m, wave(sites))


# --- point sets that are not unisolvent -----------------------------------------------------------


@pytest.mark.parametrize(
    ("width", "k", "degree", "determined"),
    [
        (3e-5, 1, 1, 1),
        (1e-7, 1, 1, 0),
        (0.1, 3, 2, 2),
        (1.2e-2, 3, 2, 1),
        (1.2e-2, 5, 2, 2),
        (1e-3, 5, 2, 1),
    ],
)
def test_a_strip_determines_what_is_large_enough_across_it(width, k, degree, determined):
    """From 1e-6 on for y, and for y^2 if the kernel needs it, as r^5 does; else from 1e-4 on.

    On a strip of this width y has the size width / 3, and y^2 modulo linear ones width^2 / 13.
    """
    m = PartitionOfUnityRBF(halton(40, 2) * [1.0, width], polyharmonic(k), degree, 40)
    assert (m.degree, m.reduced) == (determined, int(determined < degree))


def test_sites_on_a_tilted_plane_use_the_polynomials_of_the_plane():
    """The field is constant across the plane, and a cubic on the plane is reproduced."""
    rng = np.random.default_rng(2)
    axes = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    flat = rng.random((900, 2))
    x = flat @ axes[:2]
    m = PartitionOfUnityRBF(x)
    assert m.degree == 0
    assert m.reduced > 0
    s = m.field(flat[:, 0] ** 3 - flat[:, 1])
    on_it = rng.random((50, 2))
    for away in (0.0, 0.01):
        value = s(on_it @ axes[:2] + away * axes[2])
        assert_close(value, on_it[:, 0] ** 3 - on_it[:, 1], 1e-8)


def test_lower_degrees_stay_whole():
    """On a circle x² + y² is a constant, and the linear polynomials are no less linear for it."""
    t = 2 * np.pi * np.arange(50) / 50
    m = PartitionOfUnityRBF(np.column_stack([np.cos(t), np.sin(t)]))
    assert (m.degree, m.reduced) == (1, 1)
    q = np.array([[0.0, 0.0], [0.5, 0.0], [3.0, -4.0]])
    for values, exact in ((np.ones(50), np.ones(3)), (m.points[:, 1], q[:, 1])):
        assert_close(m.field(values)(q), exact, 1e-11)


def test_patches_count_a_degree_only_where_it_stands_out_from_the_lower_ones():
    """Bases by degrees against the ranks of the monomials, in exact arithmetic."""
    rng = np.random.default_rng(4)
    for d, degree, n in ((1, 4, 3), (2, 3, 8), (2, 3, 30), (3, 2, 7), (3, 2, 40)):
        y = rng.integers(-4, 5, (n, d))
        y[:, -1] = y[:, 0] % 2  # two planes
        powers = [sympy.Matrix(monomials(y, m).astype(int)).rank() for m in range(degree + 1)]
        unit = y[None] / (8 * np.sqrt(d))
        basis = orthonormal_basis(unit, degree, np.full((1, degree + 1), 1e-9))
        at_sites = monomials(unit[0], degree) @ basis[0]
        there = basis[0].any(axis=0)
        counts = [there[: dimension(d, m)].sum() for m in range(degree + 1)]
        assert counts == powers
        assert_close(at_sites.T @ at_sites, np.diag(there.astype(float)), 1e-9)


def test_bases_of_sites_near_a_circle_are_orthonormal_to_rounding():
    """There x^2 + y^2 is nearly a polynomial of lower degree; subtracting it once loses digits."""
    rng = np.random.default_rng(0)
    t, r = 2 * np.pi * rng.random(60), 1 + 1e-3 * rng.random(60)
    y = np.column_stack([1 + r * np.cos(t), 1 + r * np.sin(t)]) / 4
    at_sites = monomials(y, 3) @ orthonormal_basis(y[None], 3, np.full((1, 4), 1e-9))[0]
    assert_close(at_sites.T @ at_sites, np.eye(10), 2e-10)


def test_sites_on_a_line_use_the_polynomials_of_one_variable():
    t = np.sort(np.random.default_rng(3).random(300))
    m = PartitionOfUnityRBF(np.outer(t, [1.0, 2.0, 3.0]))
    assert m.degree == 0
    s = m.field(t**3)
    assert_close(
        s(np.outer(t[:-1] + np.diff(t) / 2, [1.0, 2.0, 3.0])), (t[:-1] + np.diff(t) / 2) ** 3, 1e-9
    )


def test_rounding_of_coordinates_far_from_the_origin_is_no_second_variable():
    """On a line 10¹⁰ away, the patches of a plane have the polynomials of the line only."""
    along, across = np.array([1.0, 2.0]), np.array([2.0, -1.0])
    t = (np.arange(1000) + 0.3 * np.random.default_rng(3).random(1000)) / 1000
    for offset in (0.0, 1e10):
        m = PartitionOfUnityRBF(np.outer(t, along) + offset, polyharmonic(3), 1, 12)
        assert m.reduced == sum(len(level.patches) for level in m._levels)
        gradient = m.field(t).gradient(np.outer(t[:-1] + np.diff(t) / 2, along) + offset)
        assert_close(gradient @ across, np.zeros(999), 1e-2)


def test_patches_grow_to_four_times_their_sites_and_not_into_the_far():
    """Sites on lines do not determine the polynomials of the plane, however many there are.

    A middle of three equidistant sites is a site. Far ones are a thousand times as far away.
    """
    t = np.arange(192.0)[:, None]
    assert {*PartitionOfUnityRBF(t * [1.0, 2.0], polyharmonic(3), 1, 9).patch_sizes} == {36}
    lines = np.concatenate([t[:17] * [1.0, 2.0] + [far, 0.0] for far in 1e6 * np.arange(4)])
    assert {*PartitionOfUnityRBF(lines, polyharmonic(3), 1, 9).patch_sizes} == {9}


def test_patches_on_scan_lines_grow_until_they_are_unisolvent():
    """No degree is reduced, and the data are interpolated."""
    x = tracks()
    m = PartitionOfUnityRBF(x, polyharmonic(3), 1, 12)
    sizes = [systems.sites.shape[1] for systems in m._levels[0].systems]
    assert sizes[0] == 12
    assert len(sizes) > 1
    assert (m.degree, m.reduced) == (1, 0)
    assert_close(m.field(wave(x))(x), wave(x), 1e-9)


def test_radii_of_patches_follow_the_density():
    """They are small in clusters and large between them."""
    x = np.unique(np.clip(clustered(4000, 2, 8, 0.02, seed=1), 0, 1), axis=0)
    m = PartitionOfUnityRBF(x)
    radii = m._levels[0].patches.radii
    assert radii.max() > 10 * radii.min()
    assert_close(m.field(franke(x))(x), franke(x), 1e-8)


shapes = st.sampled_from(["uniform", "lattice", "thin", "clusters", "curve", "tracks", "far"])


@pytest.mark.slow
@settings(max_examples=25)
@given(shapes, st.integers(1, 4), st.integers(30, 200), st.integers(0, 10**6))
def test_arbitrary_point_sets_are_interpolated_and_reproduce_constants(shape, d, n, seed):
    """The patches are small and numerous."""
    rng = np.random.default_rng(seed)
    x = rng.random((n, d))
    if shape == "lattice":
        x = np.round(x * 12) / 12
    elif shape == "thin":
        x[:, -1] *= 1e-7
    elif shape == "clusters":
        x[::2] *= 1e-5
    elif shape == "curve":
        x = np.cos(3 * x[:, :1] + np.arange(d))
    elif shape == "tracks":
        x[:, 0] = np.round(x[:, 0] * 5) / 5
    elif shape == "far":
        x += 1e6
    x = np.unique(x, axis=0)
    m = PartitionOfUnityRBF(x, polyharmonic(3), 1, 2 * d + 4)
    f = np.cos(3 * x[:, 0] - x[:, -1])
    s = m.field(np.stack([f, np.ones(len(x))], axis=1))
    assert_close(s(x)[:, 0], f, 1e-5)
    q = x[:1] + 2 * np.ptp(x, axis=0) * (rng.random((40, d)) - 0.5)
    assert_close(s(q)[:, 1], np.ones(40), 1e-6)
    assert np.isfinite(s.gradient(q)).all()


# --- refusals -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"patch_size": 10}, "patch_size must be an integer above 10, .*degree 3 in 2 var.*got 10"),
        ({"patch_size": 2.5}, "patch_size must be an integer .*got 2.5"),
        ({"kernel": "cubic"}, "kernel must be a radial function .*got 'cubic'"),
        ({"degree": 0}, r"polyharmonic\(k=3\) needs polynomials of degree 1 or more .*got 0"),
        ({"smoothing": -1.0}, "smoothing must be zero or a positive number; got -1.0"),
    ],
)
def test_invalid_arguments_are_refused(options, words):
    """The message names the argument, what was wanted, and what came."""
    with pytest.raises(ValueError, match=words):
        PartitionOfUnityRBF(X, **options)


def test_the_whole_degrees_are_those_of_which_no_polynomial_is_missing():
    """In any patch: a constant that is missing leaves no degree, whatever else is there."""
    there = np.tile(np.eye(6), (2, 1, 1))
    for missing, degree in ((None, 2), (5, 1), (3, 1), (2, 0), (1, 0), (0, -1)):
        basis = there.copy()
        if missing is not None:
            basis[1, :, missing] = 0
        assert whole_degrees(basis, 2, 2) == degree


@pytest.mark.parametrize("copies", [2, 39, 40])
@pytest.mark.parametrize("d", [2, 3])
def test_polynomials_are_reproduced_at_as_many_coincident_sites_as_a_patch_has(d, copies):
    """They alone determine the constant only; the patch gets the next sites, too."""
    points = halton(300, d)
    points = np.concatenate([points, np.repeat(points[7:8], copies - 1, axis=0)])
    method = PartitionOfUnityRBF(points, polyharmonic(3), 1, 40, smoothing=1e-6)
    plane = 2 + points @ np.arange(1.0, d + 1)
    assert method.degree == 1
    assert_close(method.field(plane)(points), plane, 1e-12)


def test_coincident_sites_are_named():
    """With smoothing they are accepted, but not more of them than the sites of a patch."""
    x = np.concatenate([X, X[[3, 17]]])
    with pytest.raises(ValueError, match="these coincide: 3 and 1500, 17 and 1501; merge"):
        PartitionOfUnityRBF(x)
    assert not PartitionOfUnityRBF(x, smoothing=1e-6).interpolates
    crowd = np.concatenate([X, np.repeat(X[:1], 99, axis=0)])
    with pytest.raises(ValueError, match="at most 40 points, the sites of a patch, may coincide"):
        PartitionOfUnityRBF(crowd, smoothing=1e-6)


@pytest.mark.parametrize(
    ("kernel", "orders"),
    [
        (polyharmonic(1), 0),
        (thin_plate_spline(), 1),
        (matern(1.0, 0.5), 1),
        (polyharmonic(3), 2),
        (matern(1.5, 0.5), 2),
        (wendland(3, 1, 0.5), 2),
    ],
    ids=repr,
)
def test_at_a_site_a_field_has_the_derivatives_that_its_kernel_has(kernel, orders):
    """They are the limits of those beside the site; further ones are refused."""
    s, site = PartitionOfUnityRBF(X[:300], kernel).field(wave(X[:300])), X[20:23]
    derivatives = ((s.gradient, "gradient"), (s.hessian, "second derivatives"))
    for order, (derivative, name) in enumerate(derivatives, 1):
        beside = derivative(site + 1e-9)
        if order <= orders:
            assert_close(derivative(site), beside, 1e-5 * np.abs(beside).max())
        else:
            with pytest.raises(ValueError, match=f"has no {name if orders else 'gradient'} at a"):
                derivative(site)


# --- executors, progress, sparsity ----------------------------------------------------------------


@pytest.mark.slow
def test_results_are_equal_on_threads_and_processes():
    """Set-up, fit, values, gradients, weights and adjoints agree bit for bit."""
    m, q = PartitionOfUnityRBF(X), halton(3000, 2, seed=1)
    here = m.field(wave(X))
    spawn = multiprocessing.get_context("spawn")
    with ThreadPoolExecutor(3) as threads, ProcessPoolExecutor(1, mp_context=spawn) as processes:
        for executor in (threads, processes):
            again = PartitionOfUnityRBF(X, executor=executor)
            assert_same_bits(again.weights(q, executor=executor), m.weights(q))
            load = m.adjoint(q, q)
            assert_close(again.adjoint(q, q, executor=executor), load, 0.0)
            there = again.field(wave(X), executor=executor)
            assert_close(there(q, executor=executor), here(q), 0.0)
            assert_close(there.gradient(q, executor=executor), here.gradient(q), 0.0)


def test_set_up_and_fit_report_progress(monkeypatch):
    """They count sites and patches of all levels; the last call has the total."""
    monkeypatch.setattr(_chunks, "CHUNK_BYTES", 2**16)
    made, fitted = [], []
    m = PartitionOfUnityRBF(X, progress=lambda *call: made.append(call))
    m.field(wave(X), progress=lambda *call: fitted.append(call))
    patches = sum(len(level.patches) for level in m._levels)
    for calls, total in ((made, len(X)), (fitted, patches)):
        done = [d for d, _ in calls]
        assert done == sorted(done)
        assert len(set(done)) > 5
        assert {of for _, of in calls} == {total}
        assert calls[-1] == (total, total)
    fifths = {len(X) * part // 5 for part in range(1, 6)}  # cuts, balls, boxes, systems; the rest
    assert fifths <= {done for done, _ in made}
    assert made[-2][0] == max(fifths - {len(X)})


def test_residuals_and_adjoints_report_progress_with_patches_of_several_sizes():
    """It ascends, and the last call has the total: of the patches, and of the queries."""
    m = PartitionOfUnityRBF(tracks()[::4], polyharmonic(3), 1, 12)
    assert len({*m.patch_sizes.tolist()}) > 1
    residuals, sums = [], []
    leave_one_out(m, wave(m.points), progress=lambda *call: residuals.append(call))
    m.adjoint(X, wave(X), progress=lambda *call: sums.append(call))
    for calls, total in ((residuals, len(m.patch_sizes)), (sums, len(X))):
        assert calls == sorted(calls)
        assert len({done for done, _ in calls}) > 1
        assert min(calls) > (0, total)
        assert calls[-1] == (total, total)


@pytest.mark.parametrize("n", [1, 30, 200])
def test_progress_of_few_sites_is_reported(n):
    """The last call has the total, and the method does not depend on `progress`."""
    calls = []
    m = PartitionOfUnityRBF(X[:n], progress=lambda *call: calls.append(call))
    assert calls[-1] == (n, n)
    assert_close(m.field(wave(X[:n]))(X), PartitionOfUnityRBF(X[:n]).field(wave(X[:n]))(X), 0.0)


def test_weights_are_sparse_and_independent_of_other_queries():
    """A query has few patches, and the order of the queries changes weights by rounding only."""
    m, q = PartitionOfUnityRBF(X), halton(2000, 2, seed=1)
    h = m.weights(q)
    assert np.diff(h.indptr).max() < 0.2 * len(X)
    back = m.weights(q[::-1])[::-1]
    assert abs(h - back).max() < 1e-9


# --- small systems --------------------------------------------------------------------------------


def test_memory_does_not_grow_with_the_number_of_variables():
    """Differences are computed axis by axis, so a few matrices are allocated instead of sixty."""
    m = PartitionOfUnityRBF(uniform(300, 60, seed=1))
    tracemalloc.start()
    m.field(m.points[:, 0])
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 12 * 8 * 361**2


def test_singular_consistent_systems_are_solved():
    """The solution has moderate entries."""
    rng = np.random.default_rng(1)
    a = rng.normal(size=(5, 8, 8))
    a += a.mT
    a[2, 0], a[2, :, 0] = a[2, 1], a[2, :, 1]
    a[2, 0, 0] = a[2, 0, 1] = a[2, 1, 0] = a[2, 1, 1]
    x = rng.normal(size=(5, 8, 3))
    b = a @ x
    for unit in (1.0, 1j):
        found = solved(a, unit * b, 8)
        assert_close(a @ found, unit * b, 1e-9)
        assert np.abs(found).max() < 10 * np.abs(x).max()
        assert_close(found[0], unit * x[0], 1e-9)


def test_singular_systems_have_the_solution_of_least_norm_and_least_squares():
    """With and without polynomials, whose equations are met; in any unit of the kernel."""
    rng = np.random.default_rng(1)
    a = rng.normal(size=(8, 5))
    a /= np.linalg.norm(a, axis=1, keepdims=True)
    a = a @ a.T
    np.fill_diagonal(a, 1.0)
    for q, unit in itertools.product((0, 2), (2.0**-30, 1.0, 2.0**30)):
        p, f, g = rng.normal(size=(8, q)), rng.normal(size=(8, 3)), rng.normal(size=(q, 3))
        matrix = np.block([[unit * a, p], [p.T, np.zeros((q, q))]])
        found = solved(matrix[None], np.vstack([unit * f, g])[None], 8)[0]
        across = np.eye(8) - p @ np.linalg.pinv(p)
        least = np.linalg.pinv(p.T) @ g
        least += np.linalg.pinv(across @ a @ across, 1e-9, hermitian=True) @ (f - a @ least)
        assert_close(found[:8], least, 1e-9)
        assert_close(found[8:] / unit, np.linalg.pinv(p) @ (f - a @ least), 1e-9)


@pytest.mark.parametrize("q", [0, 2])
@pytest.mark.parametrize("huge", [[0], [1], [8], [0, 1, 8]])
def test_systems_with_a_huge_smoothing_of_some_data_are_solved(q, huge):
    """Whichever they are: the rounding of these entries does not drown the others."""
    t = np.linspace(0, 1, 9)
    matrix = np.zeros((9 + q, 9 + q))
    matrix[:9, :9] = np.exp(-((8 * (t[:, None] - t)) ** 2))
    matrix[:9, 9:] = np.vander(t, q)
    matrix[9:, :9] = matrix[:9, 9:].T
    matrix[huge, huge] += 1e20
    right = np.random.default_rng(0).normal(size=(9 + q, 2))
    assert_close(matrix @ solved(matrix[None], right[None], 9)[0], right, 1e-9)


def test_what_is_left_beside_polynomials_is_orthogonal_to_them_to_its_own_rounding():
    """However small it is beside them."""
    rng = np.random.default_rng(3)
    q = np.linalg.qr(rng.normal(size=(9, 3)))[0]
    x = 1e8 * q @ rng.normal(size=(3, 4)) + rng.normal(size=(9, 4))
    assert_close(q.T @ _orthogonal(q, x), np.zeros((3, 4)), 1e-14)


def test_the_weights_of_a_far_query_sum_to_one():
    """To rounding, although the kernel drowns the constant there, and in any unit."""
    t = np.linspace(0, 1, 12)
    p = np.vander(t, 2)
    matrix = np.block([[np.abs(t[:, None] - t) ** 3, p], [p.T, np.zeros((2, 2))]])
    for far in (1e4, 1e6):
        right = np.concatenate([np.abs(far - t) ** 3, [far, 1.0]])
        for unit in (1.0, 2.0**-60):
            found = solved(matrix[None], unit * right[None, :, None], len(t))[0, :, 0]
            assert_close(found[: len(t)].sum() / unit, 1.0, 1e-7)


def test_a_kernel_of_large_values_keeps_polynomial_reproduction():
    """A constant is reproduced with two coincident sites and a kernel of size 1e24."""
    x = np.array([[0.0], [0.0], [1.0]])
    m = PartitionOfUnityRBF(x, inverse_square(1e-12), 0, smoothing=1e-6)
    assert_close(m.field(np.full(3, 3.0))([[1e-15], [0.5]]), [3.0, 3.0], 1e-9)


def test_many_right_hand_sides_are_grouped_by_system():
    """Each is solved with its own system, in any order and number."""
    rng = np.random.default_rng(2)
    a = rng.normal(size=(4, 5, 5)) + 9 * np.eye(5)
    for m in (0, 1, 3, COLUMNS, 100):
        system, right = rng.integers(0, 4, m), rng.normal(size=(m, 5))
        found = batched_solve_grouped(lambda i, b: np.linalg.solve(a[i], b), system, right, 5, 2)
        alone = [np.linalg.solve(a[i], b) for i, b in zip(system, right, strict=True)]
        assert_close(found, np.reshape(alone, (m, 5)), 1e-12)


@pytest.mark.parametrize("d", [1, 2, 3])
def test_the_share_of_a_patch_at_its_sites_has_a_bound_that_is_at_most_one(d):
    """Also where several patches share a site."""
    m = PartitionOfUnityRBF(uniform(1500, d, seed=1))
    (share, *_) = _blending.shares(m._levels, m._levels[0].systems[0].points, 0)
    for systems, _, pairs, member in share.systems():
        bounds = systems._largest_shares(np.arange(len(systems)))
        assert bounds.min() >= 0
        assert bounds.max() == 1
        sites = systems.sites[member]
        row, place = np.nonzero(sites == share.query[pairs][:, None])
        assert (share.weights[0, pairs[row]] <= bounds[member[row], place] + 1e-12).all()
        assert len(systems) > 1


@pytest.mark.parametrize("n", [4, 6, 10])
@pytest.mark.parametrize(("width", "sizes"), [(1e-6, 1), (0.3, 2)])
def test_narrow_clusters_of_few_sites_have_patches_of_their_own(n, width, sizes):
    """In one patch their kernels would be rounding; wide clusters share one."""
    cluster = width * uniform(n, 2, seed=0)
    m = PartitionOfUnityRBF(np.vstack([cluster, 1 + cluster]))
    assert {*m.patch_sizes.tolist()} == {sizes * n}
    assert_close(m.field(m.points[:, 0])(m.points), m.points[:, 0], 1e-9)
