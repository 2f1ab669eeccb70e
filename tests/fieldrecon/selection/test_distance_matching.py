"""Held-out samples are as far from the fitted ones as the queries are from all samples."""

import numpy as np
import pytest
from scipy import stats
from scipy.spatial import cKDTree
from scipy.spatial.distance import cdist

from fieldrecon.datasets.synthetic import clustered, uniform
from fieldrecon.selection import distance_matching as module
from fieldrecon.selection.distance_matching import (
    distance_matched_folds,
    gap_widths,
    held_out_distances,
    nearest_neighbor_distances,
    wasserstein_distance,
)


def tracks(ratio, lines=20):
    """Parallel tracks across the unit square, their distance `ratio` times that along them."""
    spacing = 1 / lines
    x, y = np.meshgrid(np.arange(0, 1, spacing / ratio), (np.arange(lines) + 0.5) * spacing)
    points = np.column_stack([x.ravel(), y.ravel()])
    return points + 0.02 * spacing * np.random.default_rng(0).standard_normal(points.shape)


def whole_lines(points, lines=20):
    """Samples without three lines, and those of these lines."""
    out = np.isin(np.floor(points[:, 1] * lines), [3, 8, 14])
    return points[~out], points[out]


def differences(points, x):
    """Mean differences of the quantiles from those of the queries: leave-one-out and the folds."""
    wanted = nearest_neighbor_distances(points, x)
    folds = distance_matched_folds(points, x)
    return (
        wasserstein_distance(wanted, nearest_neighbor_distances(points)) / wanted.mean(),
        wasserstein_distance(wanted, held_out_distances(points, folds)) / wanted.mean(),
    )


def test_distances_are_those_of_all_pairs():
    """The nearest sample is the nearest of all; of a sample, the nearest other one."""
    points, x = uniform(60, 2, seed=0), uniform(40, 2, seed=1)
    own = cdist(points, points) + np.where(np.eye(60) > 0, np.inf, 0.0)
    np.testing.assert_allclose(nearest_neighbor_distances(points, x), cdist(x, points).min(axis=1))
    np.testing.assert_allclose(nearest_neighbor_distances(points), own.min(axis=1))
    folds = distance_matched_folds(points, x)
    literal = [cdist(points[f.held_out], points[f.fitted]).min(axis=1) for f in folds]
    np.testing.assert_allclose(held_out_distances(points, folds), np.concatenate(literal))


def test_the_distance_of_distributions_is_the_wasserstein_distance():
    """SciPy's value for the same numbers, to the error of 201 quantiles."""
    a, b = np.random.default_rng(0).gamma(2.0, size=(2, 500)) * [[1.0], [1.7]]
    exact = stats.wasserstein_distance(a, b)
    assert wasserstein_distance(a, b) == pytest.approx(exact, rel=0.02)
    for name, numbers in (("a", ([1j], [0.0])), ("b", ([0.0], [1j]))):
        with pytest.raises(ValueError, match=f"{name} must be an array of real numbers"):
            wasserstein_distance(*numbers)


@pytest.mark.parametrize("ratio", [5, 50])
def test_whole_lines_are_matched_and_leave_one_out_is_not(ratio):
    """Queries on lines without samples are 50 or 5 times as far as the next sample of a line."""
    own, folds = differences(*whole_lines(tracks(ratio)))
    assert folds < 0.15 < 0.75 < own


def test_a_grid_between_tracks_is_matched_and_by_leave_one_out_it_is_not():
    """Nodes of a grid lie between the lines."""
    nodes = np.stack(np.meshgrid(*2 * (np.linspace(0.03, 0.97, 60),)), axis=-1).reshape(-1, 2)
    own, folds = differences(tracks(50), nodes)
    assert folds < 0.15 < 0.75 < own


def test_the_width_of_a_gap_is_found_on_both_sides():
    """The nearest of all samples, and the nearest within 60 degrees of the opposite direction."""
    points, x = tracks(5), uniform(200, 2, seed=3) * 1.4 - 0.2
    for query, width in zip(x, gap_widths(points, x), strict=True):
        offset = points - query
        distance = np.linalg.norm(offset, axis=1)
        nearest = offset[np.argmin(distance)]
        beyond = offset @ nearest < -0.5 * distance * distance.min()
        opposite = distance[beyond].min() if beyond.any() else distance.min()
        assert width == pytest.approx(distance.min() + opposite)


@pytest.mark.parametrize(("near", "width"), [(2047, 11.0), (2048, 2.0)])
def test_the_other_side_of_a_gap_is_sought_among_the_2048_nearest_samples(near, width):
    """If it is farther than these, twice the distance from the nearest one is taken."""
    points = np.append(-1 - np.arange(near) / 1000, 10.0)[:, None]
    assert gap_widths(points, np.zeros((1, 1))).tolist() == [width]


def test_held_out_samples_have_the_gaps_of_the_queries(monkeypatch):
    """Between tracks all gaps are as wide as the tracks are apart; along them they would not be."""
    points = tracks(50)
    x = uniform(500, 2, seed=3) * 0.9 + 0.05

    def half_of_the_gaps():
        folds = distance_matched_folds(points, x)
        found = [gap_widths(points[fold.fitted], points[fold.held_out]) for fold in folds]
        return np.median(np.concatenate(found))

    wanted = np.median(gap_widths(points, x))
    assert half_of_the_gaps() == pytest.approx(wanted, rel=0.1)
    monkeypatch.setattr(module, "_WIDER", np.inf)
    assert half_of_the_gaps() < 0.8 * wanted


@pytest.mark.slow
@pytest.mark.parametrize(
    "cloud", [lambda n, seed: uniform(n, 2, seed), lambda n, seed: clustered(n, 2, 9, 0.1, seed)]
)
def test_samples_drawn_like_the_queries_are_held_out_nearly_alone(cloud):
    """A random part of a cloud has the distances of leave-one-out: few others are excluded."""
    every = cloud(4000, 0)
    own, folds = differences(every[:3000], every[3000:])
    assert max(own, folds) < 0.15
    found = distance_matched_folds(every[:3000], every[3000:])
    excluded = sum(3000 - len(fold.fitted) for fold in found)
    assert excluded < 2.5 * sum(len(fold.held_out) for fold in found)


def test_no_held_out_sample_is_nearer_to_another_than_to_the_fitted_ones():
    """Neighbourhoods of one fold are disjoint, and the fitted samples are the others."""
    points, x = whole_lines(tracks(50))
    for fold in distance_matched_folds(points, x):
        assert not np.isin(fold.held_out, fold.fitted).any()
        assert len(points) - len(fold.fitted) <= len(points) / 5
        apart = nearest_neighbor_distances(points[fold.held_out])
        assert (apart > 1.9 * held_out_distances(points, [fold])).all()


def test_without_queries_each_sample_is_held_out_once():
    """Ten folds of nothing but held-out samples."""
    points = uniform(200, 2, seed=0)
    folds = distance_matched_folds(points, None, 10)
    assert sorted(np.concatenate([fold.held_out for fold in folds])) == list(range(200))
    assert {len(fold.fitted) + len(fold.held_out) for fold in folds} == {200}


@pytest.mark.parametrize(("gap", "wider"), [(3.0, False), (3.3, True)])
def test_gaps_are_matched_if_they_are_half_wider_than_those_about_samples(gap, wider):
    """Two lines of samples one apart, with the queries between them; about samples it is 2.1."""
    points = np.concatenate([np.arange(21.0), np.arange(21.0) + 20 + gap])[:, None]
    x = 20 + gap * np.array([[0.1], [0.5], [0.7]])
    distance = gap * np.array([0.1, 0.5, 0.3])
    assert gap_widths(points, points, 1).mean() == pytest.approx((40 * 2 + 2 * (1 + gap)) / 42)
    found = module._gaps(cKDTree(points), x, distance)
    np.testing.assert_allclose(found, gap if wider else 2 * distance)


def test_a_sample_is_drawn_four_times_on_the_mean():
    """If queries are so near to the samples that all draws have room, in enough folds."""
    points = uniform(20, 2, seed=0)
    folds = distance_matched_folds(points, np.tile(points, (9, 1)) + 1e-9, n_folds=60)
    assert sum(len(fold.held_out) for fold in folds) == 4 * 20


def test_a_single_sample_can_be_held_out():
    """Nothing is left to fit; the gap about it has no width."""
    for x in (None, [[1.0]]):
        folds = distance_matched_folds([[0.0]], x)
        assert {(*fold.held_out, len(fold.fitted)) for fold in folds} == {(0, 0)}


def test_queries_too_far_for_any_fold_leave_the_range_of_validation():
    """A query a thousand extents away changes nothing but is beyond all held-out samples."""
    points = uniform(300, 2, seed=0)
    folds = distance_matched_folds(points, np.array([[1000.0, 0.0]]))
    assert 0 < held_out_distances(points, folds).max() < 1


@pytest.mark.slow
def test_folds_are_reproducible_and_do_not_depend_on_unit_and_origin():
    """The draws have a fixed seed; another seed draws others."""
    points, x = whole_lines(tracks(5))
    first, second = distance_matched_folds(points, x), distance_matched_folds(points, x)
    moved = distance_matched_folds(1024 * points + 64, 1024 * x + 64)
    other = distance_matched_folds(points, x, seed=1)
    for a, b, c in zip(first, second, moved, strict=True):
        assert np.array_equal(a.held_out, b.held_out)
        assert np.isin(a.held_out, c.held_out).mean() > 0.9
    assert not np.array_equal(first[0].held_out, other[0].held_out)


def test_larger_neighbourhoods_are_not_crowded_out(monkeypatch):
    """If folds took whatever has room, small neighbourhoods would prevail."""
    x, y = np.meshgrid(np.arange(100.0), np.arange(0.0, 200.0, 20.0))
    points = np.column_stack([x.ravel(), y.ravel()])
    queries = uniform(500, 2, seed=0) * [99, 180]
    assert differences(points, queries)[1] < 0.2
    monkeypatch.setattr(module, "_BIASED", 1.0)
    assert differences(points, queries)[1] > 0.2


@pytest.mark.slow
def test_a_few_large_neighbourhoods_do_not_displace_the_others(monkeypatch):
    """Only one of them has room in a fold: fewer are held out, instead of few samples in all."""
    points = np.column_stack([np.linspace(0, 1, 2000), np.zeros(2000)])
    u = uniform(1000, 2, seed=0)
    x = np.column_stack([u[:, 0], np.where(u[:, 1] < 0.2, 0.085, 0.001)])

    def held_out():
        return held_out_distances(points, distance_matched_folds(points, x))

    assert len(held_out()) >= 35
    assert held_out().max() > 0.08
    monkeypatch.setattr(module, "_FEW_DRAWS", 0)
    assert len(held_out()) < 30


def test_more_folds_hold_out_more_of_few_samples():
    """Each fold has room for few large neighbourhoods: four times the folds hold out twice more."""
    points = uniform(150, 2, seed=0)
    hole = np.linalg.norm(points - 0.5, axis=1) > 0.2
    x = 0.5 + 0.2 * (uniform(50, 2, seed=1) - 0.5)
    counts = [
        sum(len(fold.held_out) for fold in distance_matched_folds(points[hole], x, n_folds))
        for n_folds in (5, 20)
    ]
    assert counts[1] > 2 * counts[0] > 0


def some_draws():
    """Samples of a square, each with a radius and the width of a gap: the sets to leave out."""
    points, rng = uniform(300, 2, seed=0), np.random.default_rng(1)
    radii, gaps = 0.12 * rng.random(80) ** 2, rng.uniform(0, 0.4, 80)
    given = list(zip(range(80), radii, gaps, strict=True))
    tree = cKDTree(points)
    return points, given, [module._Draw.of(tree, *one) for one in given]


def test_a_held_out_sample_leaves_out_its_neighbourhood_and_the_other_side_of_a_gap():
    """Written out, among all samples; half a radius farther out, nothing else may be left out."""
    points, given, draws = some_draws()
    for (center, radius, gap), draw in zip(given, draws, strict=True):
        offset = points - points[center]
        distance = np.linalg.norm(offset, axis=1)
        own = distance <= 1.5 * radius
        closest = min(distance[distance > 0], key=lambda r: abs(r - radius))
        inner = distance < (closest if abs(closest - radius) <= radius / 2 else radius)
        nearest = int(np.argmin(np.where(inner, np.inf, distance)))
        cosine = offset @ offset[nearest] / np.maximum(distance * distance[nearest], 1e-300)
        behind = (cosine < -0.5) & (distance < gap - radius)
        assert {*draw.excluded} == {center, *np.flatnonzero(inner | behind)}
        assert {*draw.touched} == {center, *np.flatnonzero(own | behind)}
    assert module._Draw.of(cKDTree(points), 5, 0.0, 0.0).excluded.tolist() == [5]
    for apart, excluded in ((0.6, [0]), (0.4, [0, 1])):
        line = cKDTree([[0.0], [apart], [3.0]])
        assert module._Draw.of(line, 0, 1.0, 2.0).excluded.tolist() == excluded
    line = cKDTree([[-1.0], [0.0], [0.5]])
    for gap, excluded in ((1.25, [1]), (1.26, [0, 1])):  # the first sample may be at its end
        draw = module._Draw.of(line, 1, 0.25, gap)
        assert draw.excluded.tolist() == draw.touched.tolist() == excluded


@pytest.mark.parametrize(("folds", "most"), [(1, 20), (3, 60), (4, 60), (5, 90), (12, 60)])
@pytest.mark.parametrize("n", [63, 80])
def test_draws_are_given_up_until_the_distances_of_those_with_room_are_theirs(n, folds, most):
    """To a tenth of their mean: first the last fifth; of 50, the farthest 2 %, to 25 at least."""
    kept = some_draws()[2][:n]
    while True:
        placed = [draw for own in module._placed(kept, 300, folds, most) for draw in own]
        wanted, found = ([draw.radius for draw in some] for some in (kept, placed))
        if wasserstein_distance(found, wanted) <= 0.1 * np.mean(wanted) or len(kept) <= 25:
            break
        farthest = np.quantile(wanted, int(0.98 * len(kept)) / len(kept), method="inverted_cdf")
        fewer = [draw for draw in kept if draw.radius <= farthest]
        kept = kept[: int(0.8 * len(kept))] if len(kept) > 50 else fewer
    packed = module._packed(some_draws()[2][:n], 300, folds, most)
    held_out = [center for fold in packed for center in fold.held_out]
    assert held_out == [draw.center for draw in placed]


@pytest.mark.parametrize("most", [30, 60])
def test_each_neighbourhood_is_placed_where_it_has_room_the_largest_first(most):
    """Written out: in the fold that excludes the fewest, apart from all that it has."""
    draws, folds = some_draws()[2], [[], [], []]
    for draw in sorted(draws, key=lambda draw: draw.radius, reverse=True):
        counts = [sum(len(other.excluded) for other in own) for own in folds]
        room = [
            count
            for own, count in zip(folds, counts, strict=True)
            if count + len(draw.excluded) <= most
            and not any({*draw.touched} & {*other.touched} for other in own)
        ]
        if room:
            folds[[*counts].index(min(room))].append(draw)
    assert module._placed(draws, 300, 3, most) == folds
    assert 9 < sum(map(len, folds)) < len(draws)


@pytest.mark.parametrize(("n", "vicinity"), [(500, 25), (100, 16), (9, 9)])
def test_samples_to_hold_out_are_drawn_from_the_twentieth_that_is_nearest(n, vicinity):
    """Or from 16 samples, if these are more; each of them is drawn.

    Queries drawn like the samples have gaps no wider than these: twice the distances count.
    """
    points, query = uniform(n, 2, seed=0), np.array([0.4, 0.7])
    x, rng = np.tile(query, (500, 1)), np.random.default_rng(0)
    center, radius, _ = module._neighborhoods(cKDTree(points), x, rng)
    distance = np.linalg.norm(points - query, axis=1)
    assert {*center} == {*np.argsort(distance)[:vicinity]}
    np.testing.assert_allclose(radius, distance.min())
    among = uniform(300, 2, seed=1)
    _, radius, gap = module._neighborhoods(cKDTree(points), among, rng)
    np.testing.assert_allclose(gap, 2 * radius)


def test_samples_far_from_the_others_are_given_the_larger_distances_with_their_gaps():
    """The distances and gaps are those of the queries, in another order."""
    points, x = tracks(50, lines=8), uniform(300, 2, seed=3) * 0.8 + 0.1
    center, radius, gap = module._neighborhoods(cKDTree(points), x, np.random.default_rng(0))
    own = nearest_neighbor_distances(points)[center]
    assert (np.diff(radius[np.argsort(own, kind="stable")])[np.diff(np.sort(own)) > 0] >= 0).all()
    distance, widths = nearest_neighbor_distances(points, x), gap_widths(points, x)
    assert sorted(zip(radius, gap, strict=True)) == sorted(zip(distance, widths, strict=True))
    assert (np.diff(radius) < 0).sum() > 100


@pytest.mark.parametrize("name", ["n_folds", "max_held_out"])
@pytest.mark.parametrize("count", [0, -3, 2.5])
def test_a_number_that_is_no_positive_integer_is_refused(name, count):
    """Of folds, and of held-out samples."""
    points = uniform(20, 2, seed=0)
    with pytest.raises(ValueError, match=f"{name} must be a positive integer; got {count}"):
        distance_matched_folds(points, points, **{name: count})
