"""The mean of methods; its laws are those of all methods, in test_laws."""

import numpy as np
import pytest

import fieldrecon as fr
from fieldrecon.datasets import franke, uniform
from fieldrecon.methods import Mean

POINTS, X = uniform(150, 2, seed=0), uniform(40, 2, seed=1)
VALUES = franke(POINTS)
MAKERS = (
    lambda p, **how: fr.PartitionOfUnityRBF(p, fr.polyharmonic(3), 1, 20, 1e-4, **how),
    lambda p, **how: fr.PartitionOfUnityRBF(p, fr.polyharmonic(1), 0, 30, **how),
)


def test_everything_is_the_mean():
    """Values, derivatives, weights, and residuals of leaving out each sample."""
    mean = Mean(POINTS, MAKERS)
    fields = [method.field(VALUES) for method in mean.methods]
    s = mean.field(VALUES)
    for name in ("__call__", "gradient"):
        each = [getattr(field, name)(X) for field in fields]
        np.testing.assert_allclose(getattr(s, name)(X), np.mean(each, axis=0), atol=1e-12)
    weights = [method.weights(X).toarray() for method in mean.methods]
    np.testing.assert_allclose(mean.weights(X).toarray(), np.mean(weights, axis=0), atol=1e-12)
    without = [fr.leave_one_out(method, VALUES) for method in mean.methods]
    np.testing.assert_allclose(fr.leave_one_out(mean, VALUES), np.mean(without, axis=0), atol=1e-12)
    assert (mean.degree, mean.interpolates) == (0, False)


def test_methods_are_made_again_on_the_points():
    """Also those that are given as methods, on other points."""
    mean = Mean(POINTS, [make(POINTS[:100]) for make in MAKERS])
    assert [len(method.points) for method in mean.methods] == [150, 150]
    assert np.array_equal(mean.field(VALUES)(X), Mean(POINTS, MAKERS).field(VALUES)(X))


@pytest.mark.parametrize(
    "work",
    [
        lambda progress: Mean(POINTS, MAKERS, progress=progress),
        lambda progress: Mean(POINTS, MAKERS).field(VALUES, progress=progress),
    ],
)
def test_the_progress_is_that_of_all_methods(work):
    """It increases from the first method to the end of the last."""
    seen = []
    work(lambda done, total: seen.append(done / total))
    assert seen == sorted(seen)
    assert 0 < seen[0] < 1 == seen[-1]


@pytest.mark.parametrize(
    ("methods", "sentence"),
    [
        ([], "methods must be one or more"),
        (fr.LeastSquares, r"methods must be a sequence: one method is given as \[method\]"),
        (fr.LeastSquares(POINTS), "methods must be a sequence"),
        ([lambda p: fr.LeastSquares(p[:10])], "LeastSquares has 10 of 150 points"),
        ([lambda p: fr.LeastSquares(p[::-1])], "all given points, in their order"),
    ],
)
def test_methods_must_be_several_on_the_same_points(methods, sentence):
    with pytest.raises(ValueError, match=sentence):
        Mean(POINTS, methods)
