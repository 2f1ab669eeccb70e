"""Anisotropy: a change of coordinates, which is found where there is one."""

import numpy as np
import pytest

import fieldrecon as fr
from fieldrecon.cli.main import main
from fieldrecon.datasets import uniform
from fieldrecon.pipelines import reconstruct
from fieldrecon.selection import MODELS, Anisotropy, CrossValidator, find_anisotropy
from fieldrecon.selection.distance_matching import distance_matched_folds
from fieldrecon.selection.models import mean_of, with_distances

ALONG = Anisotropy(4.0, 30.0)


def axes(one: Anisotropy) -> tuple[np.ndarray, np.ndarray]:
    """The unit vectors along and across."""
    turn = np.radians(one.angle)
    return np.array([np.cos(turn), np.sin(turn)]), np.array([-np.sin(turn), np.cos(turn)])


def slowly_along(x: np.ndarray, one: Anisotropy) -> np.ndarray:
    along, across = axes(one)
    return np.sin(12 * x @ across + 1) + np.cos(12 / one.ratio * x @ along)


@pytest.mark.parametrize("one", [ALONG, Anisotropy(1.5, -70.0), Anisotropy(10.0, 400.0)], ids=str)
def test_circles_are_ellipses_of_the_same_area(one):
    """A step of `ratio` along the direction is as long as one of length one across it."""
    along, across = axes(one)
    m = one.metric
    assert np.linalg.det(m) == pytest.approx(1)
    assert one.ratio**2 * along @ m @ along == pytest.approx(across @ m @ across)
    assert along @ m @ across == pytest.approx(0, abs=1e-12)


def test_a_direction_is_named_by_its_angle_below_180_degrees():
    """The opposite direction is the same one."""
    for angle, name in ((0.0, "0"), (180.5, "0.5"), (400.0, "40"), (-70.0, "110")):
        assert str(Anisotropy(3.0, angle)) == f"ranges 3 times as long along {name}°"


@pytest.mark.parametrize(("ratio", "angle"), [(1.0, 0.0), (np.inf, 0.0), (2.0, np.inf)])
def test_the_ratio_is_above_one_and_both_numbers_are_finite(ratio, angle):
    with pytest.raises(ValueError, match=f"a ratio above 1 .* got {ratio:g} and {angle:g}$"):
        Anisotropy(ratio, angle)
    assert Anisotropy(1.0 + 1e-9, 0.0).ratio > 1


@pytest.mark.parametrize("name", [name for name in MODELS if not MODELS[name].parts])
def test_a_model_is_the_isotropic_one_in_other_coordinates(name):
    """Also its smoothing, which is in units of the distances."""
    points, x = uniform(150, 2, seed=1), uniform(20, 2, seed=2)
    values = slowly_along(points, ALONG)
    model, mapped = ALONG.of_model(MODELS[name]), np.linalg.cholesky(ALONG.metric)
    paths, plain = model.makers(points), MODELS[name].makers(points @ mapped)
    for path, plain_path in zip(paths, plain, strict=True):
        s = path[-1](points).field(values)
        t = plain_path[-1](points @ mapped).field(values)
        np.testing.assert_allclose(s(x), t(x @ mapped), atol=1e-9)
    assert (str(ALONG) in model.meaning) == (model.family != "LS")


def test_the_parts_of_a_mean_are_anisotropic():
    """In the model, and in a variant that is given other distances."""
    points, x = uniform(150, 2, seed=1), uniform(20, 2, seed=2)
    values, mapped = slowly_along(points, ALONG), np.linalg.cholesky(ALONG.metric)
    model = ALONG.of_model(MODELS["mean"])
    first = [part.makers(points)[0][0] for part in model.parts]
    plain = [part.makers(points @ mapped)[0][0] for part in MODELS["mean"].parts]
    t = mean_of(plain)(points @ mapped).field(values)
    for maker in (mean_of(first), with_distances(mean_of(plain), ALONG.metric)):
        np.testing.assert_allclose(maker(points).field(values)(x), t(x @ mapped), atol=1e-9)
    assert all(str(ALONG) in one.meaning for one in (model, *model.parts))


@pytest.mark.slow
@pytest.mark.parametrize("name", ["mls1", "pu1", "cubic"])
def test_the_direction_is_found_where_there_is_one(name):
    """It is found to 45 degrees, and the error at other points is smaller."""
    points, x = uniform(200, 2, seed=3), 0.1 + 0.8 * uniform(500, 2, seed=4)
    values, truth = slowly_along(points, ALONG), slowly_along(x, ALONG)
    validator = CrossValidator.of(points, values)
    before = validator.evaluate(MODELS[name])
    after, found = find_anisotropy(validator, before)
    assert found is not None
    assert abs((found.angle - ALONG.angle + 90) % 180 - 90) < 45
    assert after.rms < before.rms
    errors = [s.maker(points).field(values)(x) - truth for s in (after, before)]
    assert np.linalg.norm(errors[0]) < 0.9 * np.linalg.norm(errors[1])


@pytest.mark.slow
def test_the_direction_turns_with_the_samples():
    """By a quarter turn, which takes the four directions that are tried into each other."""
    points = uniform(200, 2, seed=3)
    turned = np.column_stack([-points[:, 1], points[:, 0]])
    angles = []
    for x in (points, turned):
        validator = CrossValidator.of(x, slowly_along(points, ALONG))
        _, found = find_anisotropy(validator, validator.evaluate(MODELS["cubic"]))
        angles.append(found.angle)
    assert (angles[1] - angles[0]) % 180 == pytest.approx(90)


def test_the_neighbours_of_the_best_direction_are_tried_and_then_those_of_its_ratio():
    """Halfway to the next directions, and with ratios larger or smaller by the root of two."""
    tried = []

    class Recording(CrossValidator):
        def score(self, model, maker, folds=None):
            found = super().score(model, maker, folds)
            tried.append((maker.keywords["metric"], found.rms))
            return found

    points = uniform(20, 2, seed=3)
    given = points, slowly_along(points, ALONG), distance_matched_folds(points, None, 4)
    find_anisotropy(Recording(*given), CrossValidator(*given).evaluate(MODELS["cubic"]))
    trials, errors = iter(tried), {}

    def best(some):
        for one in some:
            if one not in errors:
                metric, errors[one] = next(trials)
                np.testing.assert_allclose(metric, one.metric, atol=1e-15)
        return min(some, key=errors.get)

    first = best([Anisotropy(r, a) for r in (2.0, 4.0) for a in (0.0, 45.0, 90.0, 135.0)])
    turned = best([first, *(Anisotropy(first.ratio, first.angle + a) for a in (-22.5, 22.5))])
    best([turned, *(Anisotropy(turned.ratio * f, turned.angle) for f in (0.5**0.5, 2**0.5))])
    assert next(trials, None) is None


def test_the_search_reports_each_variant_that_it_tries():
    """Two ratios along four directions, then at most four neighbours of the best one."""
    points = uniform(20, 2, seed=3)
    validator = CrossValidator.of(points, slowly_along(points, ALONG))
    calls = []
    score = validator.evaluate(MODELS["cubic"])
    find_anisotropy(validator, score, lambda *call: calls.append(call))
    done, total = zip(*calls, strict=True)
    assert done == tuple(range(1, len(done) + 1))
    assert {*total} == {12}
    assert 8 < len(done) <= 12


@pytest.mark.slow
def test_none_is_found_where_there_is_none():
    """Waves of all directions, by the one-standard-error rule; least squares has no distances."""
    points = uniform(200, 2, seed=5)
    values = np.cos(np.linalg.norm(9 * (points - 0.5), axis=1))
    validator = CrossValidator.of(points, values)
    for name in ("cubic", "ls2"):
        score = validator.evaluate(MODELS[name])
        assert find_anisotropy(validator, score) == (score, None)


def test_a_given_one_is_used_and_named():
    points = uniform(60, 2, seed=6)
    survey = reconstruct(
        points, value=slowly_along(points, ALONG), method="cubic", anisotropy="4:30", grid=(3, 3)
    )
    np.testing.assert_array_equal(survey.field.method.metric, ALONG.metric)
    assert "Distances have ranges 4 times as long along 30°, as given." in survey.warnings
    assert survey.method == "cubic, cubic spline r³, ranges 4 times as long along 30°"


@pytest.mark.slow
def test_the_better_method_of_both_is_evaluated():
    """Both stand in the table of methods."""
    points = uniform(200, 2, seed=3)
    survey = reconstruct(
        points, value=slowly_along(points, ALONG), method="cubic", anisotropy="auto", grid=(3, 3)
    )
    plain, better = (s.rms for s in survey.scores)
    assert better < plain
    assert survey.field.method.metric is not None
    assert f"the rms error is {better:.4g} instead of {plain:.4g}" in survey.anisotropy


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"anisotropy": "3"}, "must be auto or RATIO:ANGLE such as 3:45; got '3'"),
        ({"anisotropy": "0.5:45"}, "a ratio above 1 and an angle in degrees; got 0.5 and 45"),
        ({"anisotropy": "3:45", "lonlat": True}, "project degrees to lengths"),
        ({"anisotropy": "auto", "z": np.arange(9.0) ** 2}, "divide the coordinates of points in"),
    ],
)
def test_what_is_no_direction_of_the_plane_is_refused(options, words):
    x, y = uniform(9, 2, seed=7).T
    with pytest.raises(ValueError, match=words):
        reconstruct(x=x, y=y, value=x, **options)


@pytest.mark.slow
def test_the_command_takes_it_and_a_saved_field_keeps_it(capsys, tmp_path):
    points = uniform(30, 2, seed=8)
    table, saved = tmp_path / "a.csv", tmp_path / "field.npz"
    rows = np.column_stack([points, points[:, 0] ** 2])
    np.savetxt(table, rows, delimiter=",", header="x,y,v", comments="")
    run = ["reconstruct", str(table), "--out", str(tmp_path / "out"), "--grid", "3x3"]
    assert main([*run, "--method", "cubic", "--anisotropy", "4:30", "--save", str(saved)]) == 0
    assert "ranges 4 times as long along 30°, as given" in " ".join(capsys.readouterr().out.split())
    np.testing.assert_array_equal(fr.load(saved).method.metric, ALONG.metric)
    with pytest.raises(ValueError, match="give either anisotropy or load"):
        reconstruct(load=saved, anisotropy="auto")
