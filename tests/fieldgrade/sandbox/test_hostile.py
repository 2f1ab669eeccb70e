"""Arbitrary input to the library: a finite answer that obeys the law, or an error in words."""

import warnings
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import assume, given, note, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial.distance import pdist

from fieldrecon.kernels.base import Radial
from fieldrecon.kernels.conditionally_positive_definite import (
    multiquadric,
    polyharmonic,
    thin_plate_spline,
)
from fieldrecon.kernels.positive_definite import gaussian, inverse_multiquadric, matern, wendland
from fieldrecon.kernels.weights import inverse_square
from fieldrecon.methods.least_squares import LeastSquares, normal_equations
from fieldrecon.methods.moving_least_squares import MovingLeastSquares
from fieldrecon.methods.partition_of_unity.method import PartitionOfUnityRBF
from fieldrecon.methods.rbf import RBF
from fieldrecon.polynomials import dimension
from fieldrecon.reconstruction import Reconstruction
from fieldrecon.selection.leaving_one_out import leave_one_out
from laws import assert_close, dense

REFUSALS = (ValueError, np.linalg.LinAlgError, OverflowError, MemoryError)
# Messages of Python, NumPy and LAPACK themselves, which do not help the user.
BARE = (
    "math range error",
    "numerical result out of range",
    "singular matrix",
    "too large to convert",
    "cannot convert",
    "zero-size array",
    "broadcast",
    "reshape",
    "not aligned",
    "must not contain infs",
    "did not converge",
    "illegal value",
    "array must not",
)
hostile = settings(max_examples=150)


def answer_or_none(ask: Callable[[], object]) -> np.ndarray | None:
    """Return the finite answer, or None if the call raised an error with a proper message."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            answer = ask()
        except REFUSALS as refusal:
            words = str(refusal)
            assert len(words) > 20, words
            assert not any(bare in words.lower() for bare in BARE), words
            return None
    if isinstance(answer, Reconstruction):
        note(str(vars(answer)))
    else:
        for part in answer if isinstance(answer, tuple) else (answer,):
            assert np.isfinite(dense(part)).all()
    return answer


# --- inputs ---------------------------------------------------------------------------------------

lengths = st.one_of(
    st.sampled_from([1e-300, 1e-150, 1e-12, 1e-3, 0.1, 1.0, 10.0, 1e6, 1e150, 1e300]),
    st.floats(min_value=1e-3, max_value=10.0),
)
weights = st.one_of(
    st.builds(inverse_square, lengths | st.just(0.0)),
    st.builds(gaussian, lengths),
    st.builds(wendland, st.integers(1, 3), st.integers(0, 3), lengths),
    st.builds(inverse_multiquadric, lengths),
    st.builds(matern, st.sampled_from([0.5, 1.5, 2.0]), lengths),
)
kernels = st.one_of(
    weights,
    st.just(thin_plate_spline()),
    st.builds(polyharmonic, st.integers(1, 6)),
    st.builds(multiquadric, lengths),
)


@st.composite
def clouds(draw) -> np.ndarray:
    """Difficult points: duplicates, lattices, lines, clusters, with any offset and unit."""
    d, n = draw(st.integers(1, 3)), draw(st.integers(1, 14))
    entries = st.one_of(st.integers(-2, 2).map(float), st.floats(-1.0, 1.0, allow_subnormal=False))
    x = draw(arrays(np.float64, (n, d), elements=entries))
    shape = draw(st.sampled_from(["as it is", "line", "nearly a line", "twice", "two clusters"]))
    if shape == "line":
        x = x[:, :1] * np.arange(1, d + 1)
    elif shape == "nearly a line":
        x = x * np.where(np.arange(d) == 0, 1.0, draw(st.sampled_from([1e-3, 1e-9, 1e-14])))
    elif shape == "twice":
        x = np.repeat(x, 2, axis=0)
    elif shape == "two clusters":
        x = x * draw(st.sampled_from([1e-3, 1e-9])) + np.arange(n)[:, None] % 2
    offset = draw(st.sampled_from([0.0, 1.0, -1e6, 1e12]))
    unit = draw(st.sampled_from([1.0, 1.0, 1e-150, 1e150, 1e-300, 1e300]))
    assume(np.abs(x).max() + abs(offset) < 1e308 / max(unit, 1.0))
    return (x + offset) * unit


@st.composite
def reconstructions(draw) -> Callable[[], Reconstruction]:
    """A function that makes a method on such points; lengths may be in the unit of the points."""
    x = draw(clouds())
    size = float(np.ptp(x / 4, axis=0).max()) * 4
    unit = size if 0 < size < np.inf and draw(st.booleans()) else 1.0

    def in_unit(radial: Radial) -> Radial:
        with np.errstate(all="ignore"):
            return radial if unit == 1.0 else radial.in_units(1 / unit)

    degree = draw(st.integers(0, 3))
    kind = draw(st.sampled_from(["LS", "MLS", "MLS", "nearest", "RBF", "RBF", "PU", "PU"]))
    if kind == "LS":
        return lambda: LeastSquares(x, degree)
    if kind in ("RBF", "PU"):
        kernel, smoothing = draw(kernels), draw(st.sampled_from([0.0, 0.0, 1e-6, 1.0, 1e6]))
        degree = None if degree == 3 else degree
        if kind == "RBF":
            return lambda: RBF(x, in_unit(kernel), degree, smoothing)
        size = draw(st.sampled_from([None, 2, 3, 4, 6, 11]))
        return lambda: PartitionOfUnityRBF(x, in_unit(kernel), degree, size, smoothing)
    weight = draw(weights)
    if kind == "nearest":
        k = draw(st.integers(1, max(1, len(x))))
        return lambda: MovingLeastSquares(x, weight, degree, k)
    return lambda: MovingLeastSquares(x, in_unit(weight), degree)


@st.composite
def queries(draw, sites: np.ndarray) -> np.ndarray:
    """Queries at sites, between sites, near sites and far away."""
    n, d = sites.shape
    i, j = draw(st.integers(0, n - 1)), draw(st.integers(0, n - 1))
    t = draw(st.sampled_from([0.0, 1e-15, 1e-9, 0.3, 0.5, 1.0, -2.0]))
    between = sites[i] * (1 - t) + sites[j] * t
    far = np.full(d, draw(st.sampled_from([0.0, 1.0, 1e10, -1e200, 1e308])))
    return np.stack([between, far])[: draw(st.integers(0, 2))]


data_of = st.sampled_from(
    [
        lambda x: np.ones(len(x)),
        lambda x: np.zeros(len(x)),
        lambda x: np.arange(len(x)),
        lambda x: np.cos(7.0 * np.arange(len(x))) * 1e150,
        lambda x: (1 + 2j) * np.arange(len(x)) * 1e-160,
        lambda x: np.where(np.arange(len(x)) % 2, 1e300, -1e300),
        lambda x: np.ones((len(x), 2, 0)),
    ]
)


# --- laws -----------------------------------------------------------------------------------------


@pytest.mark.slow
@hostile
@given(st.data())
def test_every_method_answers_or_refuses_any_query(data):
    """Values, gradients, weights, adjoints, coefficients, matrices, objectives, leave-one-out."""
    m = answer_or_none(data.draw(reconstructions()))
    if m is None:
        return
    with np.errstate(all="ignore"):
        x = data.draw(queries(m.points))
    assume(np.isfinite(x).all())
    f = data.draw(data_of)(m.points)
    answer_or_none(lambda: m.field(f)(x))
    answer_or_none(lambda: m.field(f).gradient(x))
    answer_or_none(lambda: m.weights(x))
    answer_or_none(lambda: m.gradient_weights(x))
    answer_or_none(lambda: m.adjoint(x, np.ones(len(x))))
    answer_or_none(lambda: leave_one_out(m, f))
    if isinstance(m, LeastSquares | RBF):
        answer_or_none(lambda: m.coefficients(f))
        answer_or_none(m.matrix)
    if isinstance(m, LeastSquares):
        answer_or_none(lambda: m.objective(f))
        answer_or_none(lambda: normal_equations(m.points, f, m.degree))
    if isinstance(m, MovingLeastSquares):
        answer_or_none(lambda: m.matrix(x))
        answer_or_none(lambda: m.objective(f, x))
        answer_or_none(lambda: m.objective(f, x, normalized=True))


@pytest.mark.slow
@hostile
@given(st.data())
def test_constants_are_reproduced_wherever_there_is_an_answer(data):
    """This holds in any unit, at any offset, and on any point cloud that determines constants."""
    m = answer_or_none(data.draw(reconstructions()))
    if m is None or m.degree < 0:
        return
    with np.errstate(all="ignore"):
        x = data.draw(queries(m.points))[:1]
    inside = (x >= m.points.min(axis=0)) & (x <= m.points.max(axis=0))
    assume(inside.all())
    value = answer_or_none(lambda: m.field(np.full(len(m.points), 3.0))(x))
    if value is not None:
        assert_close(value, np.full(len(x), 3.0), 1e-6)


@pytest.mark.slow
@hostile
@given(st.data())
def test_an_interpolant_reproduces_its_data_or_is_refused(data):
    """Sites closer than 1e-60 of the size of the point cloud count as one."""
    m = answer_or_none(data.draw(reconstructions()))
    if m is None or not m.interpolates:
        return
    if isinstance(m, MovingLeastSquares):
        assume(pdist(m.sites).min(initial=1.0) > 1e-60)
    f = np.cos(7.0 * np.arange(len(m.points)))
    values = answer_or_none(lambda: m.field(f)(m.points))
    if values is not None:
        assert_close(values, f, 0.1)


@pytest.mark.slow
@hostile
@given(clouds(), st.integers(0, 3))
def test_fewer_distinct_points_than_coefficients_are_refused(x, degree):
    if len(np.unique(x, axis=0)) < dimension(x.shape[1], degree):
        for make in (
            lambda: LeastSquares(x, degree),
            lambda: MovingLeastSquares(x, inverse_square(0.1), degree),
            lambda: RBF(x, gaussian(1.0), degree, 1.0),
        ):
            with pytest.raises(np.linalg.LinAlgError, match="do not determine a polynomial"):
                make()


ANYTHING = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(-3, 3),
    st.floats(),
    st.text(max_size=3),
    st.lists(st.floats() | st.integers() | st.none(), max_size=3),
    st.lists(st.lists(st.floats(), max_size=3), max_size=4),
    arrays(np.float64, st.tuples(st.integers(0, 3), st.integers(0, 3)), elements=st.floats()),
    st.just({1: 2}),
    st.just(object()),
    st.just(np.array(["a", "b"])),
    st.just(np.array([np.datetime64("2020-01-01")])),
)
SITES = np.random.default_rng(1).random((9, 2))


@pytest.mark.slow
@hostile
@given(ANYTHING)
def test_invalid_points_data_queries_and_loads_are_refused_with_a_message(thing):
    """Any object is either accepted or refused with a proper message."""
    m = LeastSquares(SITES)
    answer_or_none(lambda: LeastSquares(thing))
    answer_or_none(lambda: m.field(np.ones(9))(thing))
    answer_or_none(lambda: m.weights(thing))
    answer_or_none(lambda: m.adjoint(SITES[:2], thing))
    answer_or_none(lambda: m.coefficients(thing))
    answer_or_none(lambda: leave_one_out(m, thing))


@pytest.mark.slow
@hostile
@given(ANYTHING)
def test_invalid_parameters_are_refused_with_a_message(thing):
    """Degrees, neighbours, weights, kernels, smoothings, lengths."""
    answer_or_none(lambda: LeastSquares(SITES, thing))
    answer_or_none(lambda: MovingLeastSquares(SITES, thing))
    answer_or_none(lambda: MovingLeastSquares(SITES, gaussian(0.5), thing))
    answer_or_none(lambda: MovingLeastSquares(SITES, gaussian(0.5), 1, thing))
    answer_or_none(lambda: RBF(SITES, thing))
    answer_or_none(lambda: RBF(SITES, thin_plate_spline(), thing))
    answer_or_none(lambda: RBF(SITES, thin_plate_spline(), smoothing=thing))
    answer_or_none(lambda: PartitionOfUnityRBF(SITES, thing))
    answer_or_none(lambda: PartitionOfUnityRBF(SITES, degree=thing))
    answer_or_none(lambda: PartitionOfUnityRBF(SITES, patch_size=thing))
    answer_or_none(lambda: PartitionOfUnityRBF(SITES, smoothing=thing))
    answer_or_none(lambda: RBF(SITES, gaussian(thing)))
    answer_or_none(lambda: RBF(SITES, polyharmonic(thing)))
    answer_or_none(lambda: RBF(SITES, wendland(thing, thing, thing)))
    answer_or_none(lambda: RBF(SITES, matern(thing, thing)))
