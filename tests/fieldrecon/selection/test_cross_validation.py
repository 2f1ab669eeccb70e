"""Cross-validation at the distances of the queries selects a suitable method."""

from dataclasses import replace
from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest

from fieldrecon import LeastSquares, leave_one_out
from fieldrecon.datasets.synthetic import clustered, franke, halton, uniform
from fieldrecon.selection import cross_validation as module
from fieldrecon.selection.cross_validation import CrossValidator, _least, best
from fieldrecon.selection.distance_matching import Fold, nearest_neighbor_distances
from fieldrecon.selection.model_scores import ModelScore, by_caution
from fieldrecon.selection.models import (
    MODELS,
    Model,
    mean_of,
    with_variances,
    with_wide_patches,
)
from fieldrecon.selection.noise_gain import noise_gain

EXACT = 1e-8
ALONE = {name: model for name, model in MODELS.items() if not model.parts}


def scores(points, values):
    validator, known = CrossValidator.of(points, values), []
    for candidate in MODELS.values():
        known.append(validator.evaluate(candidate, known=known))
    return known


def field_of(points, values):
    """The attempt for `best`: fit the field of a model score."""
    return lambda score: score.maker(points).field(values)


def winner(points, values):
    return best(scores(points, values), field_of(points, values))[0].model


@pytest.mark.parametrize("name", ALONE)
def test_variants_have_more_and_more_smoothing_in_units_of_their_kernel(name):
    """The first one interpolates. In another unit of length, kernels r^k have another size."""
    points, unit = uniform(300, 2, seed=0), 8.0
    both = (MODELS[name].makers(x) for x in (points, unit * (points - 2)))
    for paths in zip(*both, strict=True):
        here, there = (np.array([m.keywords.get("smoothing", 0.0) for m in path]) for path in paths)
        assert here[0] == 0
        assert (np.diff(here) > 0).all()
        if len(here) > 1:
            power = paths[0][0].keywords["kernel"].homogeneity
            np.testing.assert_allclose(there, here * unit**power, rtol=1e-12)


@pytest.mark.parametrize("name", ALONE)
def test_a_model_is_what_its_meaning_says(name):
    """Its degree or kernel; the kernel r is smoothed about constants, too, the others about planes.

    Global polynomials and global kernels are tried unasked on as many samples as the guide says.
    """
    model, points = MODELS[name], uniform(80, 2, seed=0)
    methods = [path[-1](points) for path in model.makers(points)]
    degrees = [method.degree for method in methods]
    if "squares" in model.meaning:
        assert degrees == [1 if "plane" in model.meaning else int(model.meaning[-1])]
    else:
        (power,) = {method.kernel.homogeneity for method in methods}
        kernel = {1: " r,", 2: "plate", 3: " r³", 5: " r⁵"}[power]
        assert kernel in model.meaning
        if "smoothed" in model.meaning:
            assert degrees == ([0, 1] if power == 1 else [1])
    assert model.max_samples == {"LS": 20_000, "RBF": 1000}.get(model.family, np.inf)


@pytest.mark.parametrize(("where", "size"), [([[2.0]], 60), ([[2.0]] * 3, 120)])
def test_a_single_site_has_the_spacing_one(where, size):
    """Whether it has one sample or several: these count as one, so a patch has more of them."""
    alone, pair = (MODELS["pu1"].makers(np.array(x))[0] for x in (where, [[0.0], [1.0]]))
    assert {maker.keywords["patch_size"] for maker in alone} == {size}
    assert [m.keywords["smoothing"] for m in alone] == [m.keywords["smoothing"] for m in pair]


@pytest.mark.slow
def test_the_selected_method_fits_the_kind_of_data():
    """A noisy plane, a smooth field and a noisy field each select a method made for them."""
    points = uniform(150, 2, seed=0)
    noise = np.random.default_rng(1).standard_normal(150)
    slope = points @ [2.0, 3.0]
    assert winner(points, slope + noise).name == "ls1"
    assert winner(points, franke(points)).name in {
        *("tps", "cubic", "smooth", "mls2", "pu", "pu3", "pu2", "pusmooth"),
    }
    assert winner(points, franke(points) + 0.1 * noise).name in {
        *("smooth", "linear", "mls1", "ls4", "pusmooth", "pu1", "pu2"),
    }


@pytest.mark.slow
def test_the_selected_method_fits_the_kind_of_data_for_many_samples(monkeypatch):
    """The statement for few samples holds with samples in windows, too."""
    monkeypatch.setattr(module, "MANY", 5_000)
    monkeypatch.setattr(module, "WINDOW", 400)
    points = clustered(10_000, 2, 30, 0.1, seed=0)
    noise = np.random.default_rng(1).standard_normal(len(points))
    assert winner(points, points @ [2.0, 3.0] + noise).family == "LS"
    assert winner(points, franke(points)).name == "pu"
    assert winner(points, franke(points) + 0.1 * noise).name in {"pusmooth", "pu1", "pu2"}


@pytest.mark.parametrize(
    ("n", "folds", "in_windows"),
    [(400, 60, False), (401, 5, False), (20_000, 5, False), (20_001, 10, True)],
)
def test_few_samples_have_more_folds_and_many_are_used_in_windows(n, folds, in_windows):
    """The numbers of the guide for engineers."""
    points = uniform(n, 2, seed=0)
    validator = CrossValidator.of(points, points[:, 0])
    assert len(validator.folds) == folds
    assert (len(validator.sites) < n) == in_windows


def test_residuals_are_those_of_fits_without_the_excluded_samples():
    """The fitted samples of each fold predict its held-out ones."""
    points = uniform(700, 2, seed=0)
    validator = CrossValidator.of(points, 1000 * franke(points), uniform(500, 2, seed=1))
    score = validator.evaluate(MODELS["ls2"])
    literal = np.concatenate(
        [
            1000 * franke(points[fold.held_out])
            - LeastSquares(points[fold.fitted], 2).field(1000 * franke(points[fold.fitted]))(
                points[fold.held_out]
            )
            for fold in validator.folds
        ]
    )
    np.testing.assert_allclose(score.residuals, literal)
    assert score.rms == pytest.approx(np.sqrt(np.mean(literal**2)))
    assert score.largest == pytest.approx(np.abs(literal).max())
    assert score.n_held_out == validator.n_held_out == len(literal)


def test_with_other_values_the_residuals_are_those_of_these_values():
    """None that are known of the values before."""
    points = uniform(60, 2, seed=0)
    validator, maker = CrossValidator.of(points, franke(points)), partial(LeastSquares, degree=2)
    before = validator.residuals(maker)
    assert np.abs(before).max() > 0.01
    np.testing.assert_array_equal(validator.residuals(maker), before)
    polynomial = replace(validator, values=points[:, 0] * points[:, 1])
    assert np.abs(polynomial.residuals(maker)).max() < EXACT


@pytest.mark.parametrize("name", ["ls4", "mls1", "pu3"])
def test_the_error_without_queries_is_that_of_leave_one_out(name):
    """The root mean square error differs by at most 25 %."""
    points = uniform(2000, 2, seed=0)
    values = franke(points) + 0.01 * np.random.default_rng(1).standard_normal(2000)
    score = CrossValidator.of(points, values).evaluate(MODELS[name])
    every = leave_one_out(score.maker(points), values)
    assert score.rms == pytest.approx(np.sqrt(np.mean(every**2)), rel=0.25)


@pytest.mark.slow
def test_of_many_samples_those_in_windows_are_used(monkeypatch):
    """The error is the one of all samples to 25 %, and is reproducible."""
    points, x = uniform(9000, 2, seed=0), uniform(2000, 2, seed=3)
    values = franke(points) + 0.01 * np.random.default_rng(1).standard_normal(9000)
    whole = CrossValidator.of(points, values, x)
    monkeypatch.setattr(module, "MANY", 8000)
    monkeypatch.setattr(module, "WINDOW", 500)
    first, second = (CrossValidator.of(points, values, x) for _ in range(2))
    for one, other in zip(first.folds, second.folds, strict=True):
        assert np.array_equal(one.held_out, other.held_out)
        assert len(one.fitted) < 5000
        assert not np.isin(one.held_out, one.fitted).any()
    errors = [v.evaluate(MODELS["mls1"]).rms for v in (first, whole)]
    assert errors[0] == pytest.approx(errors[1], rel=0.25)


@pytest.mark.slow
def test_the_choice_holds_for_the_gaps_and_not_for_the_distances_along_the_tracks():
    """On lines without samples the chosen method has at most 1.2 times the least error.

    Leave-one-out, along the lines, chooses a method with more than that.
    """
    rng = np.random.default_rng(0)
    x, y = np.meshgrid(np.arange(0, 1, 0.005), (np.arange(12) + 0.5) / 12)
    every = np.column_stack([x.ravel(), y.ravel() + 1e-3 * rng.standard_normal(x.size)])
    waves = [(k, rng.uniform(0, 2 * np.pi), rng.uniform(0, 2 * np.pi)) for k in range(2, 14)]
    values = sum(
        np.sin(2 * np.pi * k * (every @ [np.cos(t), np.sin(t)]) + s) / k for k, t, s in waves
    )
    out = np.isin(np.floor(12 * every[:, 1]), [2, 5, 9])
    points, queries = every[~out], every[out]
    models = [MODELS[name] for name in ("mls1", "pu3", "pu1")]

    def errors_of(queries_or_none):
        compared = CrossValidator.of(points, values[~out], queries_or_none).compare(models)
        accepted = [score for score in compared if score.maker]
        true = [
            np.sqrt(np.mean((s.maker(points).field(values[~out])(queries) - values[out]) ** 2))
            for s in accepted
        ]
        chosen = min(range(len(accepted)), key=lambda i: accepted[i].rank)
        return true[chosen] / min(true)

    assert errors_of(queries) < 1.2 < errors_of(None)


def tracks(step=0.005):
    """Samples along 12 lines that are 16 times as far apart as the samples on them."""
    x, y = np.meshgrid(np.arange(0, 1, step), (np.arange(12) + 0.5) / 12)
    noise = np.random.default_rng(0).standard_normal(x.size)
    return np.column_stack([x.ravel(), y.ravel() + 1e-3 * noise])


@pytest.mark.slow
def test_there_are_gaps_only_where_queries_are_farther_than_samples_are_apart():
    """Between tracks, but not on them, and not among samples everywhere."""
    between, everywhere = np.add(tracks(), [0, 1 / 24]), uniform(2000, 2, seed=1)
    points = tracks()
    for sites, x, gaps in (
        (points, between, True),
        (points, points + 1e-3, False),
        (points, None, False),
        (uniform(2000, 2, seed=0), everywhere, False),
    ):
        assert CrossValidator.of(sites, sites[:, 0], x).has_gaps is gaps


@pytest.mark.parametrize(("distance", "gaps"), [(1.4, False), (1.6, True)])
def test_samples_held_out_at_one_and_a_half_times_their_distance_are_beside_gaps(distance, gaps):
    lattice = np.stack(np.meshgrid(*[np.arange(8.0)] * 2), axis=-1).reshape(-1, 2)
    validator = CrossValidator.of(lattice, lattice[:, 0])
    validator.__dict__["distances"] = distance + np.tile([-1.0, 1.0], 32)
    assert validator.has_gaps is gaps


@pytest.mark.slow
@pytest.mark.parametrize(("gap", "error", "size"), [(1, 1.0, 240), (1, 0.0, 60), (0, 1.0, 60)])
def test_in_gaps_patches_are_wide_unless_the_held_out_samples_speak_against_it(gap, error, size):
    """They stay as they are if their error is clearly smaller, and where there are no gaps."""
    points = tracks()
    x = np.add(points, [0, gap / 24])
    validator = CrossValidator.of(points, np.sin(9 * points.sum(axis=1)), x)
    narrow = MODELS["pu1"].makers(points)[0][0]
    score = ModelScore(MODELS["pu1"], narrow, np.full(validator.n_held_out, error))
    (found,) = validator._with_suitable_patches([score])
    assert found.maker.keywords["patch_size"] == size
    assert (found is score) == (size == 60)


def test_only_smoothed_patches_become_wide():
    """Also those of a region of the globe; other methods have none."""
    points = uniform(80, 3, seed=2)
    for name, model in ALONE.items():
        flat, on_globe = model.makers(points)[0][0], model.on_tangent_plane(points[0] / 2)
        smoothed = name in ("pu1", "pu2", "pusmooth")
        assert (with_wide_patches(flat) is not None) == smoothed
        assert (with_wide_patches(on_globe.makers(points)[0][0]) is not None) == smoothed
    wide = with_wide_patches(MODELS["pu1"].on_tangent_plane(points[0]).makers(points)[0][0])
    assert wide.keywords["method"].keywords["patch_size"] == 240
    assert with_wide_patches(wide) is None


@pytest.mark.slow
def test_the_mean_is_that_of_the_best_variants_of_its_parts():
    """Its residuals are those of its field, also on a tangent plane and with a noise of each."""
    points, mean = np.add(uniform(420, 3, seed=2), [0, 0, 1]), MODELS["mean"]
    points /= np.linalg.norm(points, axis=1)[:, None]
    values = franke(points[:, :2]) + 0.1 * np.random.default_rng(0).standard_normal(420)
    flat = mean.on_tangent_plane(points.mean(axis=0) / np.linalg.norm(points.mean(axis=0)))
    for model, variances in ((mean, None), (flat, 0.01 + points[:, 0] ** 2)):
        validator = CrossValidator.of(points, values, variances=variances)
        parts = [validator.evaluate(part) for part in model.parts]
        expected = np.mean([part.residuals for part in parts], axis=0)
        for score in (validator.evaluate(model), validator.evaluate(model, known=parts)):
            np.testing.assert_allclose(score.residuals, expected, atol=1e-9)
            assert score.reason == ""
        fold = validator.folds[0]
        noise = None if variances is None else variances[fold.fitted]
        fitted = with_variances(score.maker, noise)(points[fold.fitted])
        own = values[fold.held_out] - fitted.field(values[fold.fitted])(points[fold.held_out])
        np.testing.assert_allclose(score.residuals[: len(own)], own, atol=1e-9)


def test_a_variant_is_fitted_once_on_each_fold():
    """Though it is compared on the first folds, then on all, and again within a mean."""
    sizes = []

    def fitted(points):
        sizes.append(len(points))
        return LeastSquares(points)

    plane = Model("plane", "LS", "", lambda _: [[fitted]])
    both = Model("both", "LS", "", lambda _: [], parts=(plane, MODELS["ls2"]))
    points = uniform(100, 2, seed=0)
    validator = CrossValidator.of(points, franke(points))
    done = []
    scores = validator.compare([plane, both], progress=lambda *one: done.append(one))
    assert done == [(1, 3), (2, 3)], "all folds are the last step"
    assert [score.n_held_out for score in scores] == 2 * [validator.n_held_out]
    assert sizes == [len(fold.fitted) for fold in validator.folds]


def test_the_mean_needs_all_of_its_parts():
    """A part without a field is named with its reason."""
    few = Model("few", "LS", "", MODELS["ls2"].makers)
    points = uniform(4, 2, seed=0)
    both = Model("both", "LS", "", lambda _: [], parts=(MODELS["ls1"], few))
    score = CrossValidator.of(points, points[:, 0]).evaluate(both)
    assert score.maker is None
    assert score.reason.startswith("few: the points do not determine a polynomial of degree 2")


def test_the_patches_of_a_mean_become_wide():
    """Those of all parts that smooth, and no others."""
    makers = [MODELS[name].makers(uniform(80, 2, seed=2))[0][0] for name in ("pu1", "pu2", "pu")]
    wide = with_wide_patches(mean_of(makers)).keywords["methods"]
    assert [maker.keywords.get("patch_size") for maker in wide] == [240, 240, None]
    assert with_wide_patches(mean_of(makers[2:])) is None


QUICK = ("linear", "smooth", "pu", "cubic", "tps", "ls1", "ls2", "mls1")


@pytest.mark.parametrize("d", [2, pytest.param(3, marks=pytest.mark.slow)])
@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=() if n in QUICK else pytest.mark.slow) for n in MODELS]
)
def test_every_model_reproduces_affine_fields(name, d):
    """The field is reproduced inside and outside the convex hull."""
    points = uniform(80, d, seed=2)
    values = 1 + points @ [2.0, 3.0, 5.0][:d]
    nodes = 1.2 * uniform(30, d, seed=3) - 0.1
    score = CrossValidator.of(points, values).evaluate(MODELS[name])
    assert score.reason == ""
    _, field = best([score], field_of(points, values))
    np.testing.assert_allclose(field(nodes), 1 + nodes @ [2.0, 3.0, 5.0][:d], atol=EXACT)


@pytest.mark.slow
def test_the_smoothing_parameter_scales_with_the_unit_of_length():
    """The error of the best variant is the same in metres and in kilometres."""
    points = uniform(300, 2, seed=0)
    values = franke(points) + 0.05 * np.random.default_rng(1).standard_normal(300)
    for name in ("smooth", "pusmooth"):
        here = CrossValidator.of(points, values).evaluate(MODELS[name])
        there = CrossValidator.of(1000 * points, values).evaluate(MODELS[name])
        assert there.rms == pytest.approx(here.rms, rel=1e-6)


def test_expensive_methods_need_an_explicit_request():
    """Global kernels are not tried on more than 1000 samples unless requested by name."""
    points = halton(1001, 2)
    candidate = MODELS["smooth"]
    score = CrossValidator.of(points, franke(points)).evaluate(candidate)
    assert score.residuals is None
    assert score.reason == "not tried on more than 1000 samples unasked"
    assert (score.n_held_out, score.rms, score.largest) == (0, np.inf, np.inf)
    for most, asked_for, tried in ((10, True, True), (1001, False, True), (1000, False, False)):
        model = Model("few", "LS", "", MODELS["ls1"].makers, max_samples=most)
        score = CrossValidator.of(points, franke(points)).evaluate(model, asked_for=asked_for)
        assert (score.rms < 0.5) == tried


def test_methods_with_too_few_samples_give_a_reason():
    """Four samples determine a plane but not a polynomial of degree 2."""
    points = np.array([[0.0, 0.0], [1.0, 0.1], [0.2, 1.0], [0.7, 0.6]])
    tried = {score.model.name: score for score in scores(points, points[:, 0])}
    assert "do not determine a polynomial of degree 2" in tried["ls2"].reason
    assert tried["ls1"].reason == ""


def test_samples_without_any_method_are_refused():
    """The message has the reason of the simplest method."""
    points = np.outer(np.arange(2.0), [1.0, 2.0])
    tried = [score for score in scores(points, points[:, 0]) if score.model.family == "LS"]
    with pytest.raises(np.linalg.LinAlgError, match="no field from these samples by ls1: the poin"):
        best(tried, field_of(points, points[:, 0]))


def score_of(name, residuals):
    return ModelScore(MODELS[name], None, np.asarray(residuals))


def test_errors_are_level_up_to_one_standard_error_of_their_difference():
    """The mean of the differences of squares is 0.9 or 1.1 times its standard error, or less."""
    differences = np.tile([0.0, 2.0], 50)  # mean and standard deviation 1, standard error 0.1
    best = score_of("mls1", np.sqrt(np.full(100, 10.0)))
    for part, level in ((-0.9, True), (0.9, True), (1.1, False)):
        other = score_of("linear", np.sqrt(10 + differences - 1 + 0.1 * part))
        assert other.is_level_with(best) is level
    assert best.is_level_with(best)


def test_a_sample_that_is_held_out_in_several_folds_does_not_reduce_the_standard_error():
    """Three times the same residuals are judged as once, if the samples are known."""
    once = np.sqrt(10 + np.tile([0.0, 2.0], 50) - 1 + 0.09)
    best, other = np.full(300, np.sqrt(10.0)), np.tile(once, 3)
    for samples, level in ((np.tile(np.arange(100), 3), True), (np.arange(300), False)):
        scores = [ModelScore(MODELS["tps"], None, r, held_out=samples) for r in (best, other)]
        assert scores[1].is_level_with(scores[0]) is level


@pytest.mark.parametrize("scale", [0.125, 1.0, 8.0])
@pytest.mark.parametrize(("part", "level"), [(-0.9, True), (0.9, True), (1.1, False)])
def test_only_the_ratios_of_the_weights_decide_which_errors_are_level(scale, part, level):
    """Samples of the weight zero might as well not be there."""
    weights = scale * np.repeat([1.0, 0.0], [300, 100])
    differences = np.tile([-(0.5**0.5), -(0.5**0.5), 2**0.5], 100)  # standard deviation 1
    mean = part / np.sqrt(300)
    other = np.concatenate([10 + differences + mean, np.full(100, 99.0)])
    for held_out in (None, np.arange(400)):
        score, best = (
            ModelScore(MODELS["tps"], None, np.sqrt(s), weights=weights, held_out=held_out)
            for s in (other, np.full(400, 10.0))
        )
        assert score.rms == pytest.approx(np.sqrt(10 + mean))
        assert score.is_level_with(best) is level


def test_of_models_with_level_errors_the_most_cautious_is_chosen():
    """Kernel r is preferred to a plate only if the errors cannot be told apart."""
    plate = score_of("smooth", np.sqrt(np.full(100, 10.0)))
    wave = np.tile([0.0, 2.0], 50) - 1
    for shift, chosen in ((0.05, "linear"), (0.2, "smooth")):
        compared = by_caution([plate, score_of("linear", np.sqrt(10 + wave + shift))])
        assert min(compared, key=lambda score: score.rank).model.name == chosen


@pytest.mark.parametrize("pair", [("mean", "pu1"), ("pu1", "mean"), ("linear", "mean")])
def test_of_equally_cautious_models_the_one_of_less_error_is_chosen(pair):
    """The mean of the kernel r and of plates is as safe as the kernel r, however small the gain."""
    wave = np.tile([0.0, 2.0], 50) - 1
    errors = (np.sqrt(10 + wave), np.sqrt(np.full(100, 10.001)))
    compared = by_caution([score_of(name, e) for name, e in zip(pair, errors, strict=True)])
    assert [score.caution for score in compared] == [0, 0]
    assert min(compared, key=lambda score: score.rank).model.name == pair[0]


def test_models_without_any_residuals_are_left_as_they_are():
    """None of them has an error that could be level with another one."""
    found = [ModelScore(MODELS[name], None, None, "no field") for name in ("linear", "pu")]
    assert by_caution(found) == found


@pytest.mark.parametrize(
    ("gain", "noise", "chosen"),
    [(0.15, 1.0, "linear"), (0.25, 1.0, "pu"), (8.0, 47.0, "linear"), (8.8, 47.0, "pu")],
)
def test_an_interpolant_of_high_order_needs_a_certain_or_a_large_gain(gain, noise, chosen):
    """The gain in the mean square is 1.5 and 2.5 of its standard errors, a tenth of the noise; then
    1.7 and 1.9, which is 9.5 and 10.5 % of the root mean square.
    """
    wave = noise * (np.tile([0.0, 2.0], 50) - 1)
    high_order = score_of("pu", np.sqrt(np.full(100, 40.0)))
    compared = by_caution([high_order, score_of("linear", np.sqrt(40 + gain + wave))])
    assert min(compared, key=lambda score: score.rank).model.name == chosen


@pytest.mark.slow
def test_the_most_cautious_model_is_compared_on_all_folds():
    """A model that is worse by chance on the first folds is not lost."""
    points = uniform(200, 2, seed=0)
    validator = CrossValidator.of(points, franke(points), uniform(100, 2, seed=1))
    names = ("ls1", "tps", "cubic", "linear")
    ls1, *splines, linear = validator.compare([MODELS[name] for name in names])
    best = min([ls1, *splines, linear], key=lambda score: score.rank)
    assert linear.rms > 1.2 * best.rms
    assert linear.n_held_out == best.n_held_out == validator.n_held_out > ls1.n_held_out


def test_the_parts_of_a_mean_are_compared_on_all_folds():
    """Their residuals are known; one of them may be better than the mean."""
    points = uniform(1000, 2, seed=0)
    validator = CrossValidator.of(points, franke(points))
    names = ("pu", "pu3", "pu1", "pu2", "mean")
    held_out = {
        score.model.name: score.n_held_out
        for score in validator.compare([MODELS[name] for name in names])
    }
    assert held_out["pu1"] == held_out["pu2"] == held_out["mean"] == 1000 > held_out["pu3"]


@pytest.mark.parametrize("noise", [0.0, 0.3])
def test_of_two_smoothings_that_are_level_all_folds_decide(noise):
    """Without noise the weaker one is better, with much noise the stronger one."""
    points = uniform(500, 2, seed=0)
    values = franke(points) + noise * np.random.default_rng(1).standard_normal(500)
    model = MODELS["pu2"]
    weaker, *_, stronger = model.makers(points)[0][:5]
    first = replace(CrossValidator.of(points, values).evaluate(model), maker=stronger)
    for x, decided in ((None, weaker if noise == 0 else stronger), (points + 0.2, stronger)):
        validator = CrossValidator.of(points, values, x)
        assert validator.has_gaps == (x is not None)
        final = validator._on_all_folds(replace(first, weaker=weaker), {})
        assert final.maker is decided
        assert final.n_held_out == validator.n_held_out


def models_with_errors(errors):
    """Models by their names, whose fields of the value zero have these constant errors."""

    def making(error):
        field = SimpleNamespace(
            _has_sparse_weights=False, field=lambda _: lambda x: np.full(len(x), error)
        )
        return lambda _: [[lambda _: field]]

    return [Model(name, "LS", "", making(error)) for name, error in errors.items()]


@pytest.mark.parametrize(
    ("errors", "final"),
    [
        ({"d": 1.195, "c": 1.19, "b": 1.1, "a": 1.0, "smooth": 4.0, "linear": 5.0}, "a b c linear"),
        ({"c": 3.0, "b": 1.21, "a": 1.0}, "a"),
        ({"b": 1.19, "a": 1.0, "pu1": 1.0}, "a b pu1"),
    ],
)
def test_three_models_near_the_best_and_the_most_cautious_are_compared_on_all_folds(errors, final):
    """Near is up to 1.2 times the least error; the others keep that on the first folds."""
    validator = CrossValidator.of(uniform(500, 2, seed=0), np.zeros(500))
    scores = validator.compare(models_with_errors(errors))
    assert {score.model.name: score.rms for score in scores} == pytest.approx(errors)
    held_out = {score.model.name: score.n_held_out for score in scores}
    assert {name for name, n in held_out.items() if n == 500} == {*final.split()}
    assert all(60 <= n <= 200 for n in held_out.values() if n < 500)


@pytest.mark.parametrize(
    ("amplifying", "tried", "refused"),
    [("", "abc", ""), ("a", "abcd", "a"), ("ce", "abcd", "c"), ("abcde", "abcde", "")],
)
def test_amplifiers_are_refused_until_three_models_are_left(
    monkeypatch, amplifying, tried, refused
):
    """If none would be left, none is refused."""
    models = models_with_errors({name: 1.0 + k for k, name in enumerate("abcde")})[::-1]
    validator = CrossValidator.of(uniform(500, 2, seed=0), np.zeros(500))
    scores = [validator.evaluate(model) for model in models]
    names, seen = {score.maker: score.model.name for score in scores}, []

    def amplification(_, maker):
        seen.append(names[maker])
        return 3.1 if names[maker] in amplifying else 2.9

    monkeypatch.setattr(CrossValidator, "amplification", amplification)
    found = validator._without_amplifiers(scores)
    assert "".join(seen) == tried
    assert [one.model.name for one in found] == [*"edcba"]
    assert "".join(one.model.name for one in found if one.maker is None) == refused


@pytest.mark.parametrize(("more", "level"), [(0.05, True), (0.2, False)])
def test_a_weaker_smoothing_is_kept_in_mind_if_it_is_level(more, level):
    """The middle one of three has the least error; the one before it has a little more."""
    wave = np.tile([0.0, 2.0], 50) - 1
    squares = {"none": 10 + wave + more, "some": np.full(100, 10.0), "much": np.full(100, 20.0)}
    found = _least(
        [*squares], lambda name: replace(score_of("pu2", squares[name] ** 0.5), maker=name)
    )
    assert found.maker == "some"
    assert found.weaker == ("none" if level else None)


@pytest.mark.parametrize("valley", range(9))
def test_the_least_error_on_a_path_is_found_from_its_begin_or_its_middle(valley):
    """Errors that fall towards one variant and rise behind it: few others are tried."""
    tried = []

    def scored(i):
        tried.append(i)
        return replace(score_of("pu2", np.full(9, 1.0 + (i - valley) ** 2)), maker=i)

    assert _least(range(9), scored).maker == valley
    start = 0 if valley < 2 else 4  # at equal distances from both, either
    assert len(tried) == len({*tried}) <= abs(valley - start) + 4


def test_a_path_without_a_valley_is_searched_from_the_better_of_begin_and_middle():
    """A lower one behind higher ones is not looked for: nobody would trust it."""
    for errors, found, tried in (
        ([1.0, 2, 3, 4, 5, 0.1], 0, {0, 1, 3}),
        ([5.0, 0.1, 4, 2, 3, 0.1], 3, {0, 2, 3, 4}),
        ([1.0, 1, 1, 1, 1, 1], 0, {0, 1, 3}),
        ([3.0], 0, {0}),
    ):
        seen = set()

        def scored(i, errors=errors, seen=seen):
            seen.add(i)
            return replace(score_of("pu2", np.full(9, errors[i])), maker=i)

        assert _least(range(len(errors)), scored).maker == found
        assert seen == tried


def test_of_paths_with_nearly_the_same_error_the_first_is_taken():
    """Constants before planes, unless their error is more than two per cent larger."""
    points = uniform(300, 2, seed=0)
    noise = np.random.default_rng(0).standard_normal(300)
    constants, planes = (partial(LeastSquares, degree=degree) for degree in (0, 1))
    model = Model("either", "LS", "constant or plane", lambda _: [[constants], [planes]])
    taken = []
    for slope in np.linspace(0, 1.2, 7):
        validator = CrossValidator.of(points, noise + slope * points[:, 0])
        ratio = validator.score(model, constants).rms / validator.score(model, planes).rms
        first = validator.evaluate(model).maker is constants
        assert first == (ratio <= 1.02)
        taken.append((first, ratio > 1.0))
    assert {*taken} >= {(True, True), (False, True)}


@pytest.mark.parametrize(
    ("sizes", "n", "first"),
    [([20] * 60, 300, 3), ([25] * 60, 300, 3), ([59, 1, 5], 300, 2), ([1] * 60, 450, 5)],
)
def test_models_are_compared_on_the_first_folds_with_sixty_held_out_samples(sizes, n, first):
    """They are as few as that takes, and of more than 400 samples five at most."""
    folds = tuple(Fold(np.arange(size), np.arange(size, n)) for size in sizes)
    validator = CrossValidator(uniform(n, 2, seed=0), np.zeros(n), folds)
    assert validator._first_folds() == folds[:first]


def test_the_amplification_is_the_ratio_of_the_gains_at_queries_and_held_out_samples():
    """Queries farther than any held-out sample do not count; without others the ratio is one."""
    points, far = uniform(450, 2, seed=0), np.full((9, 2), 50.0)
    x = np.concatenate([uniform(40, 2, seed=1) * 1.2 - 0.1, far])
    maker = partial(LeastSquares, degree=4)
    validator = CrossValidator.of(points, points[:, 0], x)
    near = x[nearest_neighbor_distances(points, x) <= validator.distances.max()]
    assert 20 < len(near) <= 40
    held_out = np.concatenate(
        [
            noise_gain(maker(points[fold.fitted]), points[fold.held_out])
            for fold in validator._first_folds()
        ]
    )
    at_queries = noise_gain(maker(points), near)
    literal = np.sqrt(np.mean(at_queries**2) / np.mean(held_out**2))
    assert validator.amplification(maker) == pytest.approx(literal)
    for other in (None, far):
        assert replace(validator, queries=other).amplification(maker) == 1.0


@pytest.mark.parametrize("seed", range(3))
def test_a_window_is_the_neighbourhood_of_a_query(monkeypatch, seed):
    """The queries in it are those whose nearest sample is among its inner half."""
    monkeypatch.setattr(module, "MANY", 300)
    monkeypatch.setattr(module, "WINDOW", 80)
    monkeypatch.setattr(module, "WINDOWS", 1)
    points, x = uniform(400, 2, seed=0), uniform(150, 2, seed=1)
    order = np.linalg.norm(x[:, None] - points, axis=2).argsort(axis=1)
    validator = CrossValidator.of(points, points[:, 0], x, seed)
    (middle,) = [k for k, near in enumerate(order) if {*near[:80]} == {*validator.sites}]
    assert np.array_equal(validator.queries, x[np.isin(order[:, 0], order[middle, :40])])
    own = np.linalg.norm(points[:, None] - points, axis=2).argsort(axis=1)
    validator = CrossValidator.of(points, points[:, 0], seed=seed)
    assert validator.queries is None
    assert [k for k, near in enumerate(own) if {*near[:80]} == {*validator.sites}]


def test_ten_windows_are_about_different_queries(monkeypatch):
    """The samples lie in groups as large as a window, and there is one query in each."""
    monkeypatch.setattr(module, "MANY", 300)
    monkeypatch.setattr(module, "WINDOW", 8)
    middles = np.arange(50.0)[:, None] * [1.0, 2.0]
    points = np.concatenate([middles + 0.1 * one for one in uniform(8, 2, seed=0)])
    sites = CrossValidator.of(points, points[:, 0], middles).sites
    assert np.unique(sites % 50, return_counts=True)[1].tolist() == [8] * 10


@pytest.mark.parametrize(
    ("variances", "floor"),
    [
        (np.linspace(1.0, 9.0, 500), 3.0),
        (np.repeat([0.0, 4.0], [300, 200]), 1.6e-6),
        (np.zeros(500), 1.0),
    ],
)
def test_a_held_out_sample_counts_by_its_variance_and_the_lower_quartile(variances, floor):
    """The weights are in proportion to 1 / (v + q), and equal if all variances are."""
    points = uniform(500, 2, seed=0)
    validator = CrossValidator.of(points, franke(points), variances=variances)
    score = validator.evaluate(MODELS["ls2"])
    v = variances[validator.held_out]
    literal = np.average(score.residuals**2, weights=1 / (v + floor))
    assert score.rms == pytest.approx(np.sqrt(literal))


def test_patches_hold_more_samples_where_many_are_near_duplicates():
    """Sixty separate sites, which count once however often they were measured; 120 samples."""
    points = uniform(300, 2, seed=0)
    for repeated, size in (
        (points[:0], 60),
        (points[:150], 90),  # 300 sites of 450 samples
        (points, 120),
        (np.concatenate([points, points]), 120),
    ):
        (path, *_) = MODELS["pu1"].makers(np.concatenate([points, repeated + 1e-9]))
        assert {maker.keywords["patch_size"] for maker in path} == {size}


@pytest.mark.parametrize(("times", "spacing"), [(1, 1.0), (31, 1.0), (32, 1 / 64)])
def test_a_station_measured_32_times_is_its_own_neighbourhood(times, spacing):
    """Of two such stations the distance is not seen: the mean one of the samples is taken."""
    (path,) = MODELS["pu2"].makers(np.repeat([[0.0], [1.0]], times, axis=0))
    first, second = (maker.keywords["smoothing"] for maker in path[1:3])
    plain = [
        maker.keywords["smoothing"]
        for maker in MODELS["pu2"].makers(np.array([[0.0], [1.0]]))[0][1:3]
    ]
    np.testing.assert_allclose([first, second], spacing**2 * np.array(plain))


@pytest.mark.parametrize(("apart", "size"), [(0.9e-3, 120), (1.1e-3, 60)])
def test_samples_nearer_than_a_thousandth_of_the_mean_distance_are_near_duplicates(apart, size):
    """The mean distance of n samples of a line is their extent by n."""
    sites = np.arange(100.0)[:, None]
    close = sites + apart * 99 / 200
    (path,) = MODELS["pu2"].makers(np.concatenate([sites, close]))
    assert {maker.keywords["patch_size"] for maker in path} == {size}


def test_the_next_best_method_replaces_one_that_fails():
    """`best` takes the next score if the attempt with the best score raises LinAlgError."""
    points = uniform(30, 2, seed=4)
    validator = CrossValidator.of(points, franke(points))
    good, bad = validator.evaluate(MODELS["ls1"]), validator.evaluate(MODELS["tps"])
    assert bad.rms < good.rms

    def attempt(score):
        if score is bad:
            raise np.linalg.LinAlgError("the sites about query 3 do not determine the polynomial")
        return 7

    assert best([good, bad], attempt) == (good, 7)
    with pytest.raises(np.linalg.LinAlgError, match="by tps: the sites about query 3"):
        best([bad], attempt)


TRIED = ("ls1", "mls1", "mls2", "pu1", "pusmooth")


@pytest.mark.slow
def test_models_that_amplify_noise_at_the_queries_are_refused():
    """Moving least squares extrapolates between tracks; at samples of a track it interpolates.

    The criterion depends on the points only. Among samples everywhere no model is refused, nor is
    the only model that is asked for.
    """
    points, models = tracks(1 / 300), [MODELS[name] for name in TRIED]
    between = np.add(points, [0, 1 / 24])
    everywhere = uniform(1500, 2, seed=0)
    for sites, x, refused in (
        (points, between, {"mls1", "mls2"}),
        (everywhere, uniform(900, 2, seed=1), set()),
        (everywhere, None, set()),
    ):
        for values in (franke(sites), 1.0 * (sites[:, 1] > 0.5)):
            validator = CrossValidator.of(sites, values, x)
            for model in models:
                maker = model.makers(sites)[0][-1]
                amplified = validator.amplification(maker)
                assert (amplified > 3) == (model.name in refused)
                assert model.name in refused or 0.5 < amplified < 1.5
            compared = validator.compare(models)
            found = {s.model.name for s in compared if "amplify noise" in s.reason}
            assert found <= refused
            assert min(compared, key=lambda score: score.rank).model.name not in refused
    only = CrossValidator.of(points, franke(points), between).compare([MODELS["mls1"]], True)
    assert only[0].reason == ""


def test_targets_as_far_as_the_farthest_held_out_sample_count():
    """Those farther away do not: no error is promised there. A plane amplifies outside."""
    lattice = np.stack(np.meshgrid(*[np.arange(8.0)] * 2), axis=-1).reshape(-1, 2)
    values = lattice[:, 0] ** 2
    for beyond, counts in ((1.0, True), (1.5, False)):
        outside = np.column_stack([np.full(8, -beyond), np.arange(8.0)])
        validator = CrossValidator.of(lattice, values, outside)
        validator.__dict__["distances"] = np.ones(len(lattice))
        ratio = validator.amplification(MODELS["ls1"].makers(lattice)[0][-1])
        assert (ratio > 1.2) == counts
        assert (ratio == 1.0) != counts


@pytest.mark.parametrize(
    ("ratio", "reason"),
    [(9.0, "amplify noise 9 times as much"), (np.inf, "it has no field at some of the targets")],
)
def test_the_best_score_of_an_amplifying_model_is_not_chosen(monkeypatch, ratio, reason):
    """Its reason gives the ratio and its error; without the criterion it would be chosen."""
    points = uniform(150, 2, seed=0)
    plane = points @ [2.0, 3.0] + 0.1 * np.random.default_rng(0).standard_normal(150)
    models = [MODELS[name] for name in ("ls1", "tps")]
    validator = CrossValidator.of(points, plane, points + 0.01)
    first, _ = scores = validator.compare(models)
    assert min(scores, key=lambda score: score.rank) is first
    monkeypatch.setattr(
        CrossValidator,
        "amplification",
        lambda _, maker: ratio if maker.func is LeastSquares else 1.0,
    )
    refused, chosen = validator.compare(models)
    assert (refused.maker, refused.residuals) == (None, None)
    assert reason in refused.reason
    assert chosen.rank < refused.rank
    assert best([refused, chosen], field_of(points, plane))[0] is chosen


@pytest.mark.slow
def test_folds_are_added_until_enough_samples_are_held_out(monkeypatch):
    """Five folds have room for few gaps between tracks; samples everywhere need no more folds."""
    every = tracks()
    out = np.isin(np.floor(12 * every[:, 1]), [2, 5, 9])
    points, x = every[~out], every[out]
    assert CrossValidator.of(points, points[:, 0], x).n_held_out >= module.SUFFICIENT
    everywhere = CrossValidator.of(
        uniform(1000, 2, seed=0), np.zeros(1000), uniform(500, 2, seed=1)
    )
    assert len(everywhere.folds) == module.FOLDS
    monkeypatch.setattr(module, "MOST_FOLDS", module.FOLDS)
    assert CrossValidator.of(points, points[:, 0], x).n_held_out < module.SUFFICIENT


def test_near_duplicates_do_not_change_the_unit_of_smoothing():
    """Stations that are measured again and again, a billionth of the extent apart."""
    points = uniform(300, 2, seed=0)
    shifts = 1e-9 * np.random.default_rng(0).standard_normal((8, 1, 2))
    for name, model in ALONE.items():
        if name in ("pu1", "pu2", "pusmooth"):
            once, often = (
                model.makers(p)[0][-1] for p in (points, np.concatenate(points + shifts))
            )
            ratio = often.keywords["smoothing"] / once.keywords["smoothing"]
            assert 0.9 < ratio < 1.1
            moved = model.makers(1024 * points)[0][-1].keywords["smoothing"]
            power = {"pu1": 1, "pu2": 2, "pusmooth": 3}[name]
            assert moved == pytest.approx(1024**power * once.keywords["smoothing"])
