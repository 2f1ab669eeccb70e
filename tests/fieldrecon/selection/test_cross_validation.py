"""Cross-validation selects a suitable method, by leave-one-out or, for many samples, in blocks."""

import numpy as np
import pytest

from fieldrecon import LeastSquares, leave_one_out
from fieldrecon.datasets.synthetic import clustered, franke, halton, uniform
from fieldrecon.selection import cross_validation as module
from fieldrecon.selection.cross_validation import CrossValidator, best
from fieldrecon.selection.models import MODELS, Model

EXACT = 1e-8


def scores(points, values):
    validator = CrossValidator.of(points, values)
    return [validator.evaluate(candidate) for candidate in MODELS.values()]


def field_of(points, values):
    """The attempt for `best`: fit the field of a model score."""
    return lambda score: score.maker(points).field(values)


def winner(points, values):
    return best(scores(points, values), field_of(points, values))[0].model


def test_the_selected_method_fits_the_kind_of_data():
    """A noisy plane, a smooth field and a noisy field each select a method made for them."""
    points = uniform(150, 2, seed=0)
    noise = np.random.default_rng(1).standard_normal(150)
    slope = points @ [2.0, 3.0]
    assert winner(points, slope + noise).name == "ls1"
    assert winner(points, franke(points)).name in {"tps", "cubic", "smooth", "mls2", "pu", "pu3"}
    assert winner(points, franke(points) + 0.1 * noise).name in {
        "smooth",
        "mls1",
        "ls4",
        "pusmooth",
    }


@pytest.mark.slow
def test_the_selected_method_fits_the_kind_of_data_for_many_samples(monkeypatch):
    """The statement for few samples holds with cross-validation in blocks, too."""
    monkeypatch.setattr(module, "BLOCKS", 8)
    points = clustered(20_000, 2, 30, 0.1, seed=0)
    noise = np.random.default_rng(1).standard_normal(len(points))
    assert winner(points, points @ [2.0, 3.0] + noise).family == "LS"
    assert winner(points, franke(points)).name == "pu"
    assert winner(points, franke(points) + 0.1 * noise).name == "pusmooth"


@pytest.mark.parametrize(
    "name",
    [
        "ls4",
        "mls1",
        *(pytest.param(m, marks=pytest.mark.slow) for m in ("mls2", "pu", "pu3", "pusmooth")),
    ],
)
def test_the_error_in_blocks_agrees_with_leave_one_out(monkeypatch, name):
    """The root mean square error differs by at most 20 %."""
    points = uniform(6000, 2, seed=0)
    values = franke(points) + 0.01 * np.random.default_rng(1).standard_normal(6000)
    whole = CrossValidator.of(points, values)
    monkeypatch.setattr(module, "FEW", 1000)
    blocks = CrossValidator.of(points, values)
    assert whole.n_held_out == 6000
    assert blocks.n_held_out == module.BLOCKS * module.MIDST
    candidate = MODELS[name]
    assert blocks.evaluate(candidate).rms == pytest.approx(whole.evaluate(candidate).rms, rel=0.2)


def test_blocks_are_reproducible():
    """The draw has a fixed seed; held-out samples and samples of the whole domain are disjoint."""
    points = uniform(9000, 2, seed=0)
    first, second = (CrossValidator.of(points, points[:, 0]) for _ in range(2))
    assert np.array_equal(first.blocks, second.blocks)
    assert not np.isin(first.blocks[:, : module.MIDST], first.everywhere).any()
    assert len(first.everywhere) > 1000


def test_scores_are_computed_from_leave_one_out_residuals():
    """Root mean square and maximum are in the unit of the data."""
    points = uniform(40, 2, seed=0)
    score = CrossValidator.of(points, 1000 * franke(points)).evaluate(MODELS["ls2"])
    literal = leave_one_out(LeastSquares(points, 2), 1000 * franke(points))
    assert score.rms == pytest.approx(np.sqrt(np.mean(literal**2)))
    assert score.largest == pytest.approx(np.abs(literal).max())


@pytest.mark.parametrize("d", [2, 3])
@pytest.mark.parametrize("name", MODELS)
def test_every_model_reproduces_affine_fields(name, d):
    """The field is reproduced inside and outside the convex hull."""
    points = uniform(80, d, seed=2)
    values = 1 + points @ [2.0, 3.0, 5.0][:d]
    nodes = 1.2 * uniform(30, d, seed=3) - 0.1
    score = CrossValidator.of(points, values).evaluate(MODELS[name])
    assert score.reason == ""
    _, field = best([score], field_of(points, values))
    np.testing.assert_allclose(field(nodes), 1 + nodes @ [2.0, 3.0, 5.0][:d], atol=EXACT)


def test_the_smoothing_parameter_scales_with_the_unit_of_length():
    """The error of the best variant is the same in metres and in kilometres."""
    points = uniform(300, 2, seed=0)
    values = franke(points) + 0.05 * np.random.default_rng(1).standard_normal(300)
    for name in ("smooth", "pusmooth"):
        here = CrossValidator.of(points, values).evaluate(MODELS[name])
        there = CrossValidator.of(1000 * points, values).evaluate(MODELS[name])
        assert there.rms == pytest.approx(here.rms, rel=1e-6)


def test_expensive_methods_need_an_explicit_request():
    """Global kernels are not tried on more than 2000 samples unless requested by name."""
    points = halton(2001, 2)
    candidate = MODELS["smooth"]
    score = CrossValidator.of(points, franke(points)).evaluate(candidate)
    assert score.residuals is None
    assert score.reason == "not tried on more than 2000 samples unasked"
    assert score.rms == np.inf
    few = Model("few", "LS", "", MODELS["ls1"].makers, max_samples=10)
    assert CrossValidator.of(points, franke(points)).evaluate(few, asked_for=True).rms < 0.5


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
