"""The method that fits is found, of few samples by leaving out each, of many in blocks."""

import numpy as np
import pytest

from fieldrecon import LeastSquares, leave_one_out
from fieldrecon.datasets.synthetic import clustered, franke, halton, uniform
from fieldrecon.selection import cross_validation as module
from fieldrecon.selection.cross_validation import CrossValidator, best
from fieldrecon.selection.models import MODELS, Model

EXACT = 1e-8


def trials(points, values):
    judge = CrossValidator.of(points, values)
    return [judge.evaluate(candidate) for candidate in MODELS.values()]


def field_of(points, values):
    """What an attempt is: the field of a trial."""
    return lambda trial: trial.maker(points).field(values)


def winner(points, values):
    return best(trials(points, values), field_of(points, values))[0].model


def test_each_kind_of_data_has_its_method():
    """A plane, a smooth field and a noisy one are each fitted best by the method made for it."""
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
def test_of_many_samples_too(monkeypatch):
    """In blocks of them a smooth field, noise and a plane are told apart as well."""
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
def test_blocks_judge_as_leaving_out_every_sample(monkeypatch, name):
    """For each method the error in blocks is that over all samples, to a fifth or so."""
    points = uniform(6000, 2, seed=0)
    values = franke(points) + 0.01 * np.random.default_rng(1).standard_normal(6000)
    whole = CrossValidator.of(points, values)
    monkeypatch.setattr(module, "FEW", 1000)
    blocks = CrossValidator.of(points, values)
    assert whole.n_held_out == 6000
    assert blocks.n_held_out == module.BLOCKS * module.MIDST
    candidate = MODELS[name]
    assert blocks.evaluate(candidate).rms == pytest.approx(whole.evaluate(candidate).rms, rel=0.2)


def test_blocks_are_the_same_each_time():
    """The draw is by a seed, and no sample is drawn twice for the domain."""
    points = uniform(9000, 2, seed=0)
    first, second = (CrossValidator.of(points, points[:, 0]) for _ in range(2))
    assert np.array_equal(first.blocks, second.blocks)
    assert not np.isin(first.blocks[:, : module.MIDST], first.everywhere).any()
    assert len(first.everywhere) > 1000


def test_residuals_are_those_of_leaving_one_out():
    """The error told for a method is the library's leave-one-out error, in the data's unit."""
    points = uniform(40, 2, seed=0)
    trial = CrossValidator.of(points, 1000 * franke(points)).evaluate(MODELS["ls2"])
    literal = leave_one_out(LeastSquares(points, 2), 1000 * franke(points))
    assert trial.rms == pytest.approx(np.sqrt(np.mean(literal**2)))
    assert trial.largest == pytest.approx(np.abs(literal).max())


@pytest.mark.parametrize("d", [2, 3])
@pytest.mark.parametrize("name", MODELS)
def test_every_candidate_reproduces_a_plane(name, d):
    """Data of a plane give the plane, outside of the hull as well."""
    points = uniform(80, d, seed=2)
    values = 1 + points @ [2.0, 3.0, 5.0][:d]
    nodes = 1.2 * uniform(30, d, seed=3) - 0.1
    trial = CrossValidator.of(points, values).evaluate(MODELS[name])
    assert trial.reason == ""
    _, field = best([trial], field_of(points, values))
    np.testing.assert_allclose(field(nodes), 1 + nodes @ [2.0, 3.0, 5.0][:d], atol=EXACT)


def test_smoothing_has_the_unit_of_the_points():
    """The best of the variants is the same in metres and in kilometres."""
    points = uniform(300, 2, seed=0)
    values = franke(points) + 0.05 * np.random.default_rng(1).standard_normal(300)
    for name in ("smooth", "pusmooth"):
        here = CrossValidator.of(points, values).evaluate(MODELS[name])
        there = CrossValidator.of(1000 * points, values).evaluate(MODELS[name])
        assert there.rms == pytest.approx(here.rms, rel=1e-6)


def test_costly_methods_wait_to_be_asked():
    """Global kernels are not tried on thousands of samples unless asked for."""
    points = halton(2001, 2)
    candidate = MODELS["smooth"]
    trial = CrossValidator.of(points, franke(points)).evaluate(candidate)
    assert trial.residuals is None
    assert trial.reason == "not tried on more than 2000 samples unasked"
    assert trial.rms == np.inf
    few = Model("few", "LS", "", MODELS["ls1"].makers, max_samples=10)
    assert CrossValidator.of(points, franke(points)).evaluate(few, asked_for=True).rms < 0.5


def test_methods_that_need_more_samples_say_so():
    """Four samples carry a plane; for higher degrees the reason is told, and the plane is drawn."""
    points = np.array([[0.0, 0.0], [1.0, 0.1], [0.2, 1.0], [0.7, 0.6]])
    tried = {trial.model.name: trial for trial in trials(points, points[:, 0])}
    assert "do not determine a polynomial of degree 2" in tried["ls2"].reason
    assert tried["ls1"].reason == ""


def test_no_method_at_all_is_told():
    """With the reason of the simplest."""
    points = np.outer(np.arange(2.0), [1.0, 2.0])
    tried = [trial for trial in trials(points, points[:, 0]) if trial.model.family == "LS"]
    with pytest.raises(np.linalg.LinAlgError, match="no field from these samples by ls1: the poin"):
        best(tried, field_of(points, points[:, 0]))


def test_a_method_that_fails_where_it_is_wanted_gives_way():
    """The next best is taken where the attempt with the best one fails."""
    points = uniform(30, 2, seed=4)
    judge = CrossValidator.of(points, franke(points))
    good, bad = judge.evaluate(MODELS["ls1"]), judge.evaluate(MODELS["tps"])
    assert bad.rms < good.rms

    def attempt(trial):
        if trial is bad:
            raise np.linalg.LinAlgError("the sites about query 3 do not determine the polynomial")
        return 7

    assert best([good, bad], attempt) == (good, 7)
    with pytest.raises(np.linalg.LinAlgError, match="by tps: the sites about query 3"):
        best([bad], attempt)
