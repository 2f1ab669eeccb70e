"""Laws that every reconstruction must obey, each a function of a case.

A law fails with an AssertionError. Methods and mutants are tested by the same functions.
"""

import pickle
import re
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Executor, ThreadPoolExecutor
from contextlib import contextmanager
from functools import partial
from itertools import product
from typing import TypeVar
from unittest import mock

import numpy as np
from scipy import sparse
from scipy.spatial.distance import pdist

from cases import FLAT, Case
from fieldrecon._core import chunks as _chunks
from fieldrecon._core.chunks import Inline
from fieldrecon._numerics.far_queries import LOST
from fieldrecon.methods.least_squares import LeastSquares
from fieldrecon.methods.rbf import RBF
from fieldrecon.methods.solvability import TOLERATED_MISS
from fieldrecon.polynomials import EPS
from fieldrecon.reconstruction import Reconstruction
from fieldrecon.selection.leaving_one_out import leave_one_out

VISIBLE = 1e-5
"""Differences above this size are not rounding errors."""

FAR_AWAY = 1e-3
"""Relative error of polynomials far from the sites: constants are refused from 1e-4 on."""

# Error of the sixth-order difference quotient below, including the rounding of the field.
DIFFERENCE = 1e-5
SECOND_DIFFERENCE = 1e-3
"""Of the same quotient of gradients, relative to the second derivatives: kernels that are so smooth
that their matrix loses nine digits have gradients with seven."""


def assert_close(a: object, b: object, tolerance: float) -> None:
    """Assert equal shapes and that no entries differ by more than the tolerance."""
    a, b = np.asarray(a), np.asarray(b)
    assert a.shape == b.shape, f"shape {a.shape}, not {b.shape}"
    deviation = float(np.abs(a - b).max(initial=0.0))
    assert deviation <= tolerance, f"deviates by {deviation:.1e}, more than {tolerance:.1e}"


def dense(matrix: object) -> np.ndarray:
    return matrix.toarray() if sparse.issparse(matrix) else np.asarray(matrix)


def all_monomials(x: np.ndarray, degree: int) -> np.ndarray:
    """Monomials of 2x - 1, (m, q), sorted by total degree."""
    y = 2 * x - 1
    powers = [a for a in product(range(degree + 1), repeat=x.shape[1]) if sum(a) <= degree]
    powers.sort(key=sum)
    return np.reshape([np.prod(y**a, axis=1) for a in powers], (-1, len(x))).T


def difference_quotient(f, x: np.ndarray, step: float) -> np.ndarray:
    """Gradient by central differences of order six; the derivative is the last axis."""
    columns = []
    for axis in np.eye(x.shape[-1]):
        by = {k: f(x + k * step * axis) - f(x - k * step * axis) for k in (1, 2, 3)}
        columns.append((45 * by[1] - 9 * by[2] + by[3]) / (60 * step))
    return np.stack(columns, axis=-1)


T = TypeVar("T")
Law = Callable[[Case], None]


def about(some: Callable[[Case], bool]) -> Callable[[Law], Law]:
    """Decorate a law that applies to some cases only."""

    def restricted(law: Law) -> Law:
        law.about = some
        return law

    return restricted


def broken(laws: Iterable[Callable[[T], None]], subject: T) -> Iterator[Exception]:
    """Apply the laws and yield the errors, each with the name of its law."""
    for law in laws:
        try:
            law(subject)
        except Exception as error:
            error.add_note(f"The law is {law.__name__}.")
            yield error


def assert_obeyed(laws: Iterable[Callable[[T], None]], subject: T, name: str) -> None:
    """Assert all laws in one test item and show all errors."""
    errors = list(broken(laws, subject))
    if errors:
        raise ExceptionGroup(f"{name} breaks {len(errors)} of the laws", errors)


# --- polynomials --------------------------------------------------------------------------------


@about(lambda case: case.method.degree >= 0)
def polynomials_of_the_degree_are_reproduced(case: Case) -> None:
    """Data of a polynomial of the declared degree must give it inside and outside the point set."""
    m = case.method
    s = m.field(all_monomials(case.sites, m.degree))
    assert_close(s(case.queries), all_monomials(case.queries, m.degree), case.exact)


def polynomials_of_the_next_degree_are_not_reproduced(case: Case) -> None:
    """The declared degree must be the highest: some polynomial of the next is not reproduced."""
    m = case.method
    s = m.field(all_monomials(case.sites, m.degree + 1))
    error = np.abs(s(case.queries) - all_monomials(case.queries, m.degree + 1))
    assert error.max() > VISIBLE, f"degree {m.degree + 1} is reproduced to {error.max():.1e}"


@about(lambda case: case.method.degree >= 0)
def gradients_of_polynomials_are_reproduced(case: Case) -> None:
    """Gradients of powers of a linear function must agree with the chain rule."""
    m, power = case.method, case.method.degree
    a = np.linspace(0.5, 1.0, case.d)
    s = m.field((case.sites @ a - 0.5) ** power)
    exact = power * (case.queries @ a - 0.5)[:, None] ** max(power - 1, 0) * a
    assert_close(s.gradient(case.queries), exact, 100 * case.exact)


@about(lambda case: case.method.degree >= 0)
def polynomials_are_reproduced_far_away_or_refused(case: Case) -> None:
    """At up to 1e8 times their size from the sites, no digit is lost silently.

    Polynomials and constants beside other data must be reproduced, or the query is refused.
    """
    m = case.method
    p, constant = all_monomials(case.sites, m.degree), np.stack([case.data, case.data + 1], axis=1)
    polynomial, both = m.field(p), m.field(constant)
    for distance in (1e5, 1e8):
        x = distance * np.linspace(0.6, 1.0, case.d)[None]
        exact = all_monomials(x, m.degree)
        size = np.maximum(1.0, np.abs(exact))
        with refused_or_computed():
            assert_close(polynomial(x) / size, exact / size, FAR_AWAY)
        with refused_or_computed():
            assert_close(np.diff(both(x)), np.ones((1, 1)), FAR_AWAY)
        with refused_or_computed():
            assert_close(m.weights(x) @ p / size, exact / size, FAR_AWAY)
        with refused_or_computed():
            assert_close(m.adjoint(x, [1.0]) @ p / size[0], exact[0] / size[0], FAR_AWAY)


@contextmanager
def refused_or_computed() -> Iterator[None]:
    """A context whose body may raise the error for a query outside, and no other."""
    message = None
    try:
        yield
    except np.linalg.LinAlgError as refusal:
        message = str(refusal)
    words = "rounding decides the value|do not determine|have no value at"
    assert message is None or re.search(words, message), f"refused in other words: {message}"


# --- data ---------------------------------------------------------------------------------------


@about(lambda case: case.method.interpolates or case.distinguishable)
def data_are_interpolated_if_and_only_if_declared(case: Case) -> None:
    """H(X) = I must hold if and only if the method declares that it interpolates."""
    deviation = np.abs(dense(case.method.weights(case.sites)) - np.eye(case.n)).max()
    if case.method.interpolates:
        assert deviation <= case.exact, f"H(X) deviates from I by {deviation:.1e}"
    else:
        assert deviation > VISIBLE, f"H(X) is I to {deviation:.1e}"


def the_field_is_linear_in_the_data(case: Case) -> None:
    """The field of 2f - 3ig must be 2 s_f - 3i s_g, and so must its gradient."""
    f, g = case.data, np.sin(5 * case.data)
    s = case.method.field
    assert_close(
        s(2 * f - 3j * g)(case.queries),
        2 * s(f)(case.queries) - 3j * s(g)(case.queries),
        10 * case.exact,
    )
    assert_close(
        s(2 * f - 3j * g).gradient(case.queries),
        2 * s(f).gradient(case.queries) - 3j * s(g).gradient(case.queries),
        1000 * case.exact,
    )


def components_do_not_mix(case: Case) -> None:
    """Each component of vector or matrix data must be reconstructed independently."""
    f = np.stack([case.data, case.data**2, -case.data, case.data**3], axis=1).reshape(-1, 2, 2)
    s = case.method.field(f)
    for i, j in product(range(2), range(2)):
        alone = case.method.field(f[:, i, j])
        assert_close(s(case.queries)[:, i, j], alone(case.queries), case.exact)
        gradient = s.gradient(case.queries)[:, i, j]
        assert_close(gradient, alone.gradient(case.queries), 100 * case.exact)


def data_without_components_give_empty_results(case: Case) -> None:
    """Data of the shape (n, 0) must give values (m, 0) and gradients (m, 0, d)."""
    s = case.method.field(np.zeros((case.n, 0)))
    assert s(case.queries).shape == (len(case.queries), 0)
    assert s.gradient(case.queries).shape == (len(case.queries), 0, case.d)


# --- weights, gradients, adjoint ----------------------------------------------------------------


def the_field_is_weights_times_data(case: Case) -> None:
    """s(x) = H f must hold, although the field does not form H."""
    assert_close(
        case.method.field(case.data)(case.queries),
        case.method.weights(case.queries) @ case.data,
        case.exact,
    )


def the_gradient_is_gradient_weights_times_data(case: Case) -> None:
    """∇s(x) = (G_1 f, ..., G_d f) must hold."""
    g = case.method.gradient_weights(case.queries)
    assert len(g) == case.d
    assert_close(
        case.method.field(case.data).gradient(case.queries),
        np.stack([matrix @ case.data for matrix in g], axis=-1),
        100 * case.exact,
    )


def the_gradient_is_the_derivative(case: Case) -> None:
    """The gradient must agree with difference quotients of the field."""
    s = case.method.field(case.data)
    quotient = difference_quotient(s, case.queries, step=2e-5)
    assert_close(s.gradient(case.queries), quotient, DIFFERENCE)


def has_second_derivatives(case: Case) -> bool:
    """Whether the method computes them."""
    return type(case.method)._hessian_rows is not Reconstruction._hessian_rows


@about(has_second_derivatives)
def hessians_are_derivatives_of_gradients(case: Case) -> None:
    """Hessians agree with difference quotients of gradients; their trace is the Laplacian."""
    s, x = case.method.field(case.data), case.queries
    hessian, quotient = s.hessian(x), difference_quotient(s.gradient, x, step=2e-5)
    size = max(np.abs(quotient).max(), VISIBLE)
    assert_close(hessian, quotient, SECOND_DIFFERENCE * size)
    assert_close(hessian, hessian.swapaxes(-1, -2), 0.0)
    trace = np.trace(hessian, axis1=-2, axis2=-1)
    assert_close(s.laplacian(x), trace, 1000 * case.exact * max(size, 1.0))


@about(has_second_derivatives)
def hessians_change_with_axes_and_unit(case: Case) -> None:
    """Hessians turn with the points, Q^T H Q, and scale as 1 / unit^2."""
    q, x, unit = case.turn, case.queries, case.units[-1]
    hessian = case.method.field(case.data).hessian(x)
    there = case.make(case.sites @ q * unit, unit).field(case.data)
    tolerance = 1e4 * case.exact * max(1.0, np.abs(hessian).max())
    assert_close(there.hessian(x @ q * unit) * unit * unit, q.T @ hessian @ q, tolerance)


def the_adjoint_is_the_transpose(case: Case) -> None:
    """The adjoint must be Hᵀf, also for several components and complex values."""
    h = dense(case.method.weights(case.queries))
    f = np.cos(np.arange(len(h)))
    assert_close(case.method.adjoint(case.queries, f), h.T @ f, case.exact)
    f = np.stack([f, 1j * f**2], axis=1)
    assert_close(case.method.adjoint(case.queries, f), h.T @ f, case.exact)


def the_field_and_the_adjoint_are_consistent(case: Case) -> None:
    """(s(x), g) = (f, Hᵀg) must hold for the field and the adjoint."""
    g = np.sin(np.arange(len(case.queries)) + 1.0)
    here = case.method.field(case.data)(case.queries) @ g
    there = case.data @ case.method.adjoint(case.queries, g)
    assert_close(here, there, 100 * case.exact)


# --- queries ------------------------------------------------------------------------------------


def leading_axes_of_queries_are_kept(case: Case) -> None:
    """Queries (..., d) must give values (..., *v), gradients (..., *v, d) and m rows of weights."""
    f = np.stack([case.data, -case.data], axis=1)
    s = case.method.field(f)
    x = case.queries.reshape(2, 1, 4, case.d)
    assert_close(s(x), s(case.queries).reshape(2, 1, 4, 2), case.exact)
    gradients = s.gradient(case.queries).reshape(2, 1, 4, 2, case.d)
    assert_close(s.gradient(x), gradients, 100 * case.exact)
    assert_close(s(x[0, 0, 3]), s(case.queries)[3], case.exact)
    assert_close(
        dense(case.method.weights(x)), dense(case.method.weights(case.queries)), case.exact
    )


def empty_queries_give_empty_results(case: Case) -> None:
    """Empty results must have the right shapes, and the adjoint of zero queries must be zero."""
    m, f = case.method, np.stack([case.data, -case.data], axis=1)
    none = np.zeros((0, 3, case.d))
    assert m.field(f)(none).shape == (0, 3, 2)
    assert m.field(f).gradient(none).shape == (0, 3, 2, case.d)
    assert m.weights(none).shape == (0, case.n)
    assert [g.shape for g in m.gradient_weights(none)] == [(0, case.n)] * case.d
    assert_close(m.adjoint(none, np.zeros((0, 2))), np.zeros((case.n, 2)), 0.0)


def results_do_not_depend_on_the_chunks(case: Case) -> None:
    """Single queries and all queries at once must give the same results."""
    m = case.method
    s, x = m.field(case.data), case.queries
    f = np.cos(np.arange(len(x)))

    def everything() -> list[np.ndarray]:
        matrices = [m.weights(x), *m.gradient_weights(x)]
        return [s(x), m.adjoint(x, f), s.gradient(x), *map(dense, matrices)]

    together = everything()
    one_core = mock.patch.object(_chunks, "available_cores", return_value=1)
    with mock.patch.object(_chunks, "CHUNK_BYTES", 1), one_core:
        separately = everything()
    for a, b in zip(together, separately, strict=True):
        assert_close(a, b, 100 * case.exact)


def evaluations(case: Case) -> list[Callable[..., object]]:
    """All functions of queries that take an executor and progress, at three queries."""
    m, s = case.method, case.method.field(case.data)
    f, x = np.array([1.0, -2.0, 3.0]), case.queries[-3:]
    functions = s, s.gradient, m.weights, m.gradient_weights, partial(m.adjoint, f=f)
    return [partial(evaluate, x) for evaluate in functions]


def results_do_not_depend_on_the_executor(case: Case, executor: Executor | None = None) -> None:
    """The default threads, one thread and any other executor must give the same bits."""
    with mock.patch.object(_chunks, "CHUNK_BYTES", 2**10), ThreadPoolExecutor(1) as single:
        for evaluate in evaluations(case):
            assert_same_bits(evaluate(executor=executor or single), evaluate())


def assert_same_bits(a: object, b: object) -> None:
    """Assert that two arrays or matrices, or two tuples of them, are equal."""
    pairs = zip(a, b, strict=True) if isinstance(a, tuple) else [(a, b)]
    for one, other in pairs:
        assert_close(dense(one), dense(other), 0.0)


def progress_increases_to_the_total(case: Case) -> None:
    """progress(done, total) must not decrease, and must reach the total once, at the end."""
    with mock.patch.object(_chunks, "CHUNK_BYTES", 2**10):
        for evaluate in evaluations(case):
            calls: list[tuple[int, int]] = []
            evaluate(executor=Inline(), progress=lambda *call, calls=calls: calls.append(call))
            assert_counted(calls, 3)


def assert_counted(calls: list[tuple[int, int]], total: int) -> None:
    """Assert that the calls of progress count up to the total, and reach it once."""
    done = [d for d, _ in calls]
    assert {of for _, of in calls} == {total}
    assert done == sorted(done)
    assert done.count(total) == 1, f"progress is {done}"


def making_does_not_depend_on_the_executor(case: Case, executor: Executor | None = None) -> None:
    """A method made by an executor must give the same bits, with progress up to its sites."""
    m, calls = case.method, list[tuple[int, int]]()
    with mock.patch.object(_chunks, "CHUNK_BYTES", 2**12), ThreadPoolExecutor(1) as single:
        how = {"executor": executor or single, "progress": lambda *call: calls.append(call)}
        here, there = (m._made(m.points, **m._arguments(), **h) for h in ({}, how))
    assert_same_bits(there.weights(case.queries), here.weights(case.queries))
    assert (there.degree, there.interpolates) == (here.degree, here.interpolates)
    assert_counted(calls, case.n)


# --- invariance: origin, axes, units, order -------------------------------------------------


def results_do_not_depend_on_the_origin(case: Case) -> None:
    """Values, gradients and weights must not change under a translation by 2^20."""
    offset = 2.0**20
    translated = case.make(case.sites + offset, 1.0)
    here, there = case.method.field(case.data), translated.field(case.data)
    x = case.queries
    assert_close(there(x + offset), here(x), 10 * case.exact)
    assert_close(there.gradient(x + offset), here.gradient(x), 1000 * case.exact)
    assert_close(
        dense(translated.weights(x + offset)), dense(case.method.weights(x)), 10 * case.exact
    )


def results_do_not_depend_on_the_axes(case: Case) -> None:
    """Under rotations and reflections values must not change, and gradients must rotate."""
    q = case.turn
    here, x = case.method.field(case.data), case.queries
    there = case.make(case.sites @ q, 1.0).field(case.data)
    assert_close(there(x @ q), here(x), 10 * case.exact)
    assert_close(there.gradient(x @ q), here.gradient(x) @ q, 1000 * case.exact)


def results_do_not_depend_on_the_unit(case: Case) -> None:
    """Values must not change with the unit, and gradients must scale with 1/unit, up to 1e±150."""
    here, x = case.method.field(case.data), case.queries
    for unit in case.units:
        there = case.make(case.sites * unit, unit).field(case.data)
        assert_close(there(x * unit), here(x), 10 * case.exact)
        assert_close(there.gradient(x * unit) * unit, here.gradient(x), 1000 * case.exact)


def results_scale_with_the_unit_of_the_data(case: Case) -> None:
    """Data of size 1e-200, 1e-120 or 1e200 must give values and gradients of that size."""
    here, x = case.method.field(case.data), case.queries
    for unit in (2.0**-660, 2.0**-400, 2.0**660):
        there = case.method.field(case.data * unit)
        assert_close(there(x) / unit, here(x), case.exact)
        assert_close(there.gradient(x) / unit, here.gradient(x), 100 * case.exact)


@about(lambda case: case.method.degree >= 0)
def constants_are_reproduced_at_the_ends_of_the_range_of_numbers(case: Case) -> None:
    """Sums and products of such data overflow or lose their digits; the field must not."""
    for constant in (5e-324, 1e-310, -3e307, 1.5e308):
        s = case.method.field(np.full(case.n, constant))
        assert_close(s(case.queries) / constant, np.ones(len(case.queries)), case.exact)


def results_do_not_depend_on_the_order_of_the_sites(case: Case) -> None:
    """The weights must be permuted with the sites."""
    order = np.random.default_rng(6).permutation(case.n)
    shuffled = case.make(case.sites[order], 1.0)
    assert_close(
        dense(shuffled.weights(case.queries)),
        dense(case.method.weights(case.queries))[:, order],
        10 * case.exact,
    )


# --- input arrays ------------------------------------------------------------------------


def inputs_are_not_modified(case: Case) -> None:
    """Points, data and queries may be read-only, and must not be modified if they are not."""
    for writeable in (True, False):
        p, f, x = case.sites.copy(), case.data.copy(), case.queries.copy()
        load = np.cos(np.arange(len(x)))
        arrays = (p, f, x, load)
        before = [a.copy() for a in arrays]
        for a in arrays:
            a.flags.writeable = writeable
        m = case.make(p, 1.0)
        m.field(f)(x), m.field(f).gradient(x)
        m.weights(x), m.gradient_weights(x), m.adjoint(x, load)
        for a, b in zip(arrays, before, strict=True):
            assert_close(a, b, 0.0)


def a_method_copies_its_input(case: Case) -> None:
    """Later changes of the caller's arrays must not change the method or its field."""
    p, f = case.sites.copy(), case.data.copy()
    m = case.make(p, 1.0)
    s = m.field(f)
    p[:], f[:] = 7.0, 7.0
    assert_close(m.weights(case.queries) @ case.data, s(case.queries), case.exact)
    assert_close(s(case.queries), case.method.field(case.data)(case.queries), case.exact)
    assert not m.points.flags.writeable


def results_do_not_depend_on_the_form_of_the_arrays(case: Case) -> None:
    """Lists, Fortran order, strides and float32 of the same numbers must give the same results."""
    p, f, x = (a.astype(np.float32).astype(float) for a in (case.sites, case.data, case.queries))
    expected = case.make(p, 1.0).field(f)(x)
    forms = [
        lambda a: a.tolist(),
        lambda a: np.asfortranarray(a),
        lambda a: np.repeat(a, 2, axis=0)[::2],
        lambda a: a.astype(np.float32),
    ]
    for form in forms:
        again = case.make(form(p), 1.0).field(form(f))(form(x))
        assert again.dtype == np.float64
        assert_close(again, expected, 10 * case.exact)


def integers_are_accepted(case: Case) -> None:
    """Integer points, data and queries must give the same results as floats."""
    p, x = (np.round(a * 2**12).astype(int) for a in (case.sites, case.queries))
    f = np.round(case.data * 100).astype(int)
    m = case.make(p, 2.0**12)
    expected = case.make(p.astype(float), 2.0**12).field(f.astype(float))
    assert_close(m.field(f)(x), expected(x.astype(float)), 100 * case.exact)
    assert m.field(f)(x).dtype == np.float64


def a_pickled_copy_gives_the_same_bits(case: Case) -> None:
    """Pickling must not change any bit, so that processes can share the work."""
    copy = pickle.loads(pickle.dumps(case.method))
    x = case.queries
    assert (copy.degree, copy.interpolates) == (case.method.degree, case.method.interpolates)
    assert_close(dense(copy.weights(x)), dense(case.method.weights(x)), 0.0)
    s = pickle.loads(pickle.dumps(case.method.field(case.data)))
    assert_close(s.gradient(x), case.method.field(case.data).gradient(x), 0.0)


def nan_and_infinity_are_refused(case: Case) -> None:
    """NaN and infinity must be refused in every argument, with its name and the position."""
    m, x = case.method, case.queries
    for bad in (np.nan, np.inf, -np.inf):
        f, p, q = case.data.copy(), case.sites.copy(), x.copy()
        f[2], p[1, 0], q[3, 0] = bad, bad, bad
        with refused(r"values must be finite; values\[2\] is "):
            m.field(f)
        with refused(rf"{case.argument} must be finite; {case.argument}\[1, 0\] is "):
            case.make(p, 1.0)
        for evaluate in (m.field(case.data), m.field(case.data).gradient, m.weights):
            with refused(r"x must be finite; x\[3, 0\] is "):
                evaluate(q)
        with refused(r"f must be finite; f\[1\] is "):
            m.adjoint(x[:2], [1.0, bad])


def wrong_shapes_are_refused(case: Case) -> None:
    """Wrong shapes must be refused; the message has the required and the actual shape."""
    m, d, n = case.method, case.d, case.n
    with refused(rf"values must have one entry for each point, shape \({n}, ...\); got \(3,\)"):
        m.field([1.0, 2.0, 3.0])
    for evaluate in (
        m.field(case.data),
        m.field(case.data).gradient,
        m.weights,
        m.gradient_weights,
    ):
        with refused(rf"x must have {d} coordinates? per point, shape \(..., {d}\); got "):
            evaluate(np.zeros((4, d + 1)))
    with refused(r"f must have one entry for each query, shape \(8, ...\); got \(2,\)"):
        m.adjoint(case.queries, [1.0, 2.0])
    with refused(rf"{case.argument} must have the shape \(n, d\); got \(2, 2, 2\)"):
        case.make(np.zeros((2, 2, 2)), 1.0)


@contextmanager
def refused(words: str, error: type[Exception] = ValueError) -> Iterator[None]:
    """A context whose body must raise an error with this message."""
    message = None
    try:
        yield
    except error as refusal:
        message = str(refusal)
    assert message is not None, f"not refused: {words}"
    assert re.search(words, message), f"refused in other words: {message}"


# --- leave one out ------------------------------------------------------------------------------


def leave_one_out_equals_refits(case: Case) -> None:
    """The residual must be f_i - s_(-i)(p_i), with s_(-i) fitted to the other sites.

    The patches of a partition of unity stay the same in the refit.
    """
    if not case.removable:
        with refused("outside the polytope of the other corners", TypeError):
            leave_one_out(case.method, case.data)
        return
    if case.n == len(all_monomials(case.sites[:1], max(case.method.degree, 0))[0]):
        with refused("without point 0, .* do not determine", np.linalg.LinAlgError):
            leave_one_out(case.method, case.data)
        return
    residuals = leave_one_out(case.method, case.data)
    for i in (0, 7 % case.n, case.n - 1):
        assert_close(residuals[i], case.data[i] - case.without(i), 1000 * case.exact)


# --- arrangements -------------------------------------------------------------------------------


def arrangements_are_solved_or_refused(case: Case) -> None:
    """On sites of any arrangement the laws below must hold, or the method refuses the sites.

    The message of a refusal must be in the words of the subject. Patches and coordinates must not
    refuse.
    """
    meets = case.method.interpolates
    for name, sites in case.arranged():
        try:
            assert_promises_kept(case.make, sites, case.around(sites), case.refuses, meets)
        except AssertionError as error:
            error.add_note(f"The sites are: {name}.")
            raise


def assert_promises_kept(
    make: Callable[[np.ndarray, float], Reconstruction],
    sites: np.ndarray,
    x: np.ndarray,
    refuses: bool,
    meets: bool,
) -> None:
    """Laws with tolerances relative to the weights, by which rounding is multiplied.

    Polynomials must be reproduced, data interpolated, both routes and the adjoint agree, inside and
    outside the hull, and the order of the sites must not matter. Weights so large that rounding
    leaves no digit must be refused, and those of a method that `meets` its data on other sites be
    the identity at these. (Polynomials and patches say for each set of sites whether they meet
    them: the number of sites decides, or the flatness of the kernel.)
    """
    rng, (n, d) = np.random.default_rng(9), sites.shape
    low, extent = sites.min(axis=0), max(np.ptp(sites, axis=0).max(), 1e-9)
    spread = np.median(np.abs(sites - np.median(sites, axis=0)).max(axis=1)) + 1e-9 * extent
    f = np.cos((sites - low) @ np.linspace(0.3, 1.0, d) / spread)
    order = rng.permutation(n)

    try:
        m = make(sites, 1.0)
        h, other = dense(m.weights(x)), dense(make(sites[order], 1.0).weights(x))
        own = isinstance(m, LeastSquares) or not refuses
        if m.interpolates if own else meets:
            assert_close(dense(m.weights(sites)), np.eye(n), TOLERATED_MISS)
        p, exact = (all_monomials((y - low) / extent, m.degree) for y in (sites, x))
        s = m.field(np.column_stack([p, f]))
        values, again = s(x), s(sites) if m.interpolates else None
        slopes = [dense(rows) for rows in gradient_weights(m, x)] if m.degree >= 0 else []
    except (np.linalg.LinAlgError, ValueError) as error:
        if refuses and WORDS[type(error)].search(str(error)):
            return
        raise AssertionError(f"refused: {error!r}") from None

    size = 1 + np.abs(h).sum(axis=1)[:, None]
    if not refuses:  # then the weights stay bounded
        assert size.max() * EPS < FLAT, f"weights of size {size.max():.0e}"
    lost = LOST if isinstance(innermost(m), LeastSquares | RBF) else VISIBLE
    assert size.max() * EPS < lost, f"no digits are left by weights of size {size.max():.0e}"
    grows = size * max(1.0, np.abs(exact).max(initial=0.0))
    reproduced = VISIBLE if refuses else FLAT
    assert_close(h @ p / grows, exact / grows, reproduced)
    assert_close(values[:, :-1] / grows, exact / grows, reproduced)
    assert_close(values[:, -1:] / size, h @ f[:, None] / size, TOLERATED_MISS)
    for rows in slopes:  # a constant has the gradient zero
        relative = rows.sum(axis=1) / (1 + np.abs(rows).sum(axis=1))
        assert_close(relative, np.zeros(len(x)), SLOPE)
    load = np.cos(np.arange(len(x)))
    assert_close(m.adjoint(x, load) / size.max(), h.T @ load / size.max(), 10 * TOLERATED_MISS)
    if again is not None:
        assert_close(again[:, -1], f, TOLERATED_MISS)
    if n > 1 and pdist(sites).min() > 0.05 * extent:  # where distances may tie
        f, tolerance = rng.normal(size=n), VISIBLE
    else:
        tolerance = 10 * TOLERATED_MISS
    assert_close(other @ f[order] / size[:, 0], h @ f / size[:, 0], tolerance)


def innermost(m: Reconstruction) -> Reconstruction:
    """The method in a plane or in space of one at longitudes and latitudes."""
    return innermost(m.method) if hasattr(m, "method") else m


def gradient_weights(m: Reconstruction, x: np.ndarray) -> tuple:
    """Gradient weights, or none of a kernel or a weight without derivatives at its sites."""
    try:
        return m.gradient_weights(x)
    except ValueError:
        return ()


SLOPE = 1e-11
WORDS = {
    np.linalg.LinAlgError: re.compile("do not determine|would miss its data|rounding decides"),
    ValueError: re.compile("neighbors must be an integer from 1 to"),
}


LAWS: list[Law] = [
    polynomials_of_the_degree_are_reproduced,
    polynomials_of_the_next_degree_are_not_reproduced,
    gradients_of_polynomials_are_reproduced,
    polynomials_are_reproduced_far_away_or_refused,
    data_are_interpolated_if_and_only_if_declared,
    the_field_is_linear_in_the_data,
    components_do_not_mix,
    data_without_components_give_empty_results,
    the_field_is_weights_times_data,
    the_gradient_is_gradient_weights_times_data,
    the_gradient_is_the_derivative,
    hessians_are_derivatives_of_gradients,
    hessians_change_with_axes_and_unit,
    the_adjoint_is_the_transpose,
    the_field_and_the_adjoint_are_consistent,
    leading_axes_of_queries_are_kept,
    empty_queries_give_empty_results,
    results_do_not_depend_on_the_chunks,
    results_do_not_depend_on_the_executor,
    progress_increases_to_the_total,
    making_does_not_depend_on_the_executor,
    results_do_not_depend_on_the_origin,
    results_do_not_depend_on_the_axes,
    results_do_not_depend_on_the_unit,
    results_scale_with_the_unit_of_the_data,
    constants_are_reproduced_at_the_ends_of_the_range_of_numbers,
    results_do_not_depend_on_the_order_of_the_sites,
    inputs_are_not_modified,
    a_method_copies_its_input,
    results_do_not_depend_on_the_form_of_the_arrays,
    integers_are_accepted,
    a_pickled_copy_gives_the_same_bits,
    nan_and_infinity_are_refused,
    wrong_shapes_are_refused,
    leave_one_out_equals_refits,
    arrangements_are_solved_or_refused,
]


def laws_about(case: Case) -> list[Law]:
    """The laws that a case can break."""
    return [law for law in LAWS if getattr(law, "about", lambda _: True)(case)]
