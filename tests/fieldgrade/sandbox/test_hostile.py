"""Hostile input: an answer that obeys the law, or a refusal in words; no NaN, no warning."""

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
# What Python, NumPy and LAPACK say by themselves; it tells the user nothing.
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


def answered_or_refused(ask: Callable[[], object]) -> np.ndarray | None:
    """The finite answer, or None where it was refused in words."""
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


# --- what may come --------------------------------------------------------------------------------

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
    """Points in ugly places: duplicates, lattices, lines, clusters, any offset and unit."""
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
    """A method on such points, not yet made; lengths in the unit of the points, or not."""
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
    """At sites, between them, beside them and far away."""
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


# --- what must be so ------------------------------------------------------------------------------


@hostile
@given(st.data())
def test_every_question_is_answered_or_refused(data):
    """Values, gradients, weights, adjoints, coefficients, matrices, objectives, leave-one-out."""
    m = answered_or_refused(data.draw(reconstructions()))
    if m is None:
        return
    with np.errstate(all="ignore"):
        x = data.draw(queries(m.points))
    assume(np.isfinite(x).all())
    f = data.draw(data_of)(m.points)
    answered_or_refused(lambda: m.field(f)(x))
    answered_or_refused(lambda: m.field(f).gradient(x))
    answered_or_refused(lambda: m.weights(x))
    answered_or_refused(lambda: m.gradient_weights(x))
    answered_or_refused(lambda: m.adjoint(x, np.ones(len(x))))
    answered_or_refused(lambda: leave_one_out(m, f))
    if isinstance(m, LeastSquares | RBF):
        answered_or_refused(lambda: m.coefficients(f))
        answered_or_refused(m.matrix)
    if isinstance(m, LeastSquares):
        answered_or_refused(lambda: m.objective(f))
        answered_or_refused(lambda: normal_equations(m.points, f, m.degree))
    if isinstance(m, MovingLeastSquares):
        answered_or_refused(lambda: m.matrix(x))
        answered_or_refused(lambda: m.objective(f, x))
        answered_or_refused(lambda: m.objective(f, x, normalized=True))


@hostile
@given(st.data())
def test_constants_come_back_wherever_there_is_an_answer(data):
    """In any unit, at any offset, on any cloud that determines them."""
    m = answered_or_refused(data.draw(reconstructions()))
    if m is None or m.degree < 0:
        return
    with np.errstate(all="ignore"):
        x = data.draw(queries(m.points))[:1]
    inside = (x >= m.points.min(axis=0)) & (x <= m.points.max(axis=0))
    assume(inside.all())
    value = answered_or_refused(lambda: m.field(np.full(len(m.points), 3.0))(x))
    if value is not None:
        assert_close(value, np.full(len(x), 3.0), 1e-6)


@hostile
@given(st.data())
def test_an_interpolant_comes_near_its_data(data):
    """Or says that rounding prevents it. Sites 1e-60 of the cloud's size apart count as one."""
    m = answered_or_refused(data.draw(reconstructions()))
    if m is None or not m.interpolates:
        return
    if isinstance(m, MovingLeastSquares):
        assume(pdist(m.sites).min(initial=1.0) > 1e-60)
    f = np.cos(7.0 * np.arange(len(m.points)))
    values = answered_or_refused(lambda: m.field(f)(m.points))
    if values is not None:
        assert_close(values, f, 0.1)


@hostile
@given(clouds(), st.integers(0, 3))
def test_too_few_points_are_always_refused(x, degree):
    """Fewer distinct points than coefficients cannot determine them."""
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


@hostile
@given(ANYTHING)
def test_anything_may_be_given_for_points_data_queries_and_loads(thing):
    """It is used if it has the form, and refused in words if not."""
    m = LeastSquares(SITES)
    answered_or_refused(lambda: LeastSquares(thing))
    answered_or_refused(lambda: m.field(np.ones(9))(thing))
    answered_or_refused(lambda: m.weights(thing))
    answered_or_refused(lambda: m.adjoint(SITES[:2], thing))
    answered_or_refused(lambda: m.coefficients(thing))
    answered_or_refused(lambda: leave_one_out(m, thing))


@hostile
@given(ANYTHING)
def test_anything_may_be_given_for_a_parameter(thing):
    """Degrees, neighbours, weights, kernels, smoothings, lengths."""
    answered_or_refused(lambda: LeastSquares(SITES, thing))
    answered_or_refused(lambda: MovingLeastSquares(SITES, thing))
    answered_or_refused(lambda: MovingLeastSquares(SITES, gaussian(0.5), thing))
    answered_or_refused(lambda: MovingLeastSquares(SITES, gaussian(0.5), 1, thing))
    answered_or_refused(lambda: RBF(SITES, thing))
    answered_or_refused(lambda: RBF(SITES, thin_plate_spline(), thing))
    answered_or_refused(lambda: RBF(SITES, thin_plate_spline(), smoothing=thing))
    answered_or_refused(lambda: PartitionOfUnityRBF(SITES, thing))
    answered_or_refused(lambda: PartitionOfUnityRBF(SITES, degree=thing))
    answered_or_refused(lambda: PartitionOfUnityRBF(SITES, patch_size=thing))
    answered_or_refused(lambda: PartitionOfUnityRBF(SITES, smoothing=thing))
    answered_or_refused(lambda: RBF(SITES, gaussian(thing)))
    answered_or_refused(lambda: RBF(SITES, polyharmonic(thing)))
    answered_or_refused(lambda: RBF(SITES, wendland(thing, thing, thing)))
    answered_or_refused(lambda: RBF(SITES, matern(thing, thing)))
