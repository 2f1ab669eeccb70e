"""The solutions of notebook 02 agree with the library."""

from types import SimpleNamespace

import numpy as np
import pytest

from checkout import ROOT
from fieldgrade.authoring.sources import Source
from fieldrecon.kernels.weights import inverse_square
from fieldrecon.methods.least_squares import LeastSquares
from fieldrecon.methods.moving_least_squares import MovingLeastSquares
from fieldrecon.selection.leaving_one_out import leave_one_out

SOURCE = Source(ROOT / "solutions" / "02_moving_least_squares.py")
STUDENT = SimpleNamespace(**SOURCE.functions())
CASES = [(d, epsilon) for d in (1, 2, 3) for epsilon in (0.05, 0.3, 2.0)]


@pytest.fixture(params=CASES, ids=lambda case: f"d{case[0]}-epsilon{case[1]}")
def case(request):
    d, epsilon = request.param
    random = np.random.default_rng(20 * d)
    points, values, x = random.random((25, d)), random.normal(size=25), random.random((6, d))
    return SimpleNamespace(
        points=points,
        values=values,
        x=x,
        epsilon=epsilon,
        library=MovingLeastSquares(points, inverse_square(epsilon)),
    )


def close(a, b, tolerance=1e-8):
    np.testing.assert_allclose(a, b, rtol=tolerance, atol=tolerance * np.abs(b).max())


def test_the_weights_agree_with_the_library(case):
    """w(r) of the notebook is the kernel `inverse_square`."""
    for x in case.x:
        r = np.linalg.norm(case.points - x, axis=1)
        close(STUDENT.weights(case.points, x, case.epsilon), inverse_square(case.epsilon)(r))


def test_equal_weights_give_least_squares(case):
    c = STUDENT.weighted_fit(case.points, case.values, np.ones(25))
    close(c, LeastSquares(case.points).coefficients(case.values))


def test_the_field_and_its_gradient_agree_with_the_library(case):
    """The notebook uses the origin, the library the evaluation point as its local origin."""
    given = case.points, case.values, case.x, case.epsilon
    field = case.library.field(case.values)
    close(STUDENT.field(*given), field(case.x))
    close(STUDENT.gradient(*given), field.gradient(case.x), 1e-7)


def test_the_minimum_of_the_objective_agrees_with_the_library(case):
    for x in case.x:
        c = STUDENT.weighted_fit(
            case.points, case.values, STUDENT.weights(case.points, x, case.epsilon)
        )
        found = STUDENT.objective(case.points, case.values, x, case.epsilon, c)
        close(found, case.library.objective(case.values, x))


def test_leave_one_out_residuals_agree_with_the_library(case):
    """The notebook drops each point, the library uses a closed form."""
    found = STUDENT.leave_one_out(case.points, case.values, case.epsilon)
    close(found, leave_one_out(case.library, case.values), 1e-7)


@pytest.mark.parametrize("n", [2, 3, 6])
def test_the_errors_of_both_methods_agree_with_the_library(n):
    random = np.random.default_rng(n)
    points, queries = random.random((100, 2)), random.random((10, 2))
    values, truth = points.sum(axis=1) ** n, queries.sum(axis=1) ** n
    methods = LeastSquares(points), MovingLeastSquares(points, inverse_square(0.05))
    rms = [np.sqrt(np.mean((m.field(values)(queries) - truth) ** 2)) for m in methods]
    close(STUDENT.errors(points, queries, n, 0.05), np.array(rms))


def test_the_choice_of_epsilon_is_as_the_notebook_states():
    """The minimum of ψ always decreases with ε; leave-one-out selects a nearly optimal ε."""
    random = np.random.default_rng(5)
    points, queries = random.random((100, 2)), random.random((200, 2))
    values = points.sum(axis=1) ** 3 + 0.3 * random.normal(size=100)
    widths, errors, unseen, lowest = np.geomspace(0.01, 3, 9), [], [], []
    for epsilon in widths:
        method = MovingLeastSquares(points, inverse_square(epsilon))
        missed = method.field(values)(queries) - queries.sum(axis=1) ** 3
        errors.append(np.sqrt(np.mean(missed**2)))
        unseen.append(np.sum(STUDENT.leave_one_out(points, values, epsilon) ** 2))
        lowest.append(method.objective(values, queries[:5]))
    assert (np.diff(lowest, axis=0) < 0).all()
    assert errors[int(np.argmin(unseen))] < 1.2 * min(errors)
    assert errors[-1] > 2 * min(errors)
