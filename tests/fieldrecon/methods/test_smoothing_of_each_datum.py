"""A smoothing for each datum: its variance, in units of the kernel."""

from collections.abc import Callable
from unittest import mock

import numpy as np
import pytest
from scipy.spatial.distance import cdist

import laws
from cases import PatchesCase
from fieldrecon._numerics import saddle_point
from fieldrecon.kernels.base import Radial
from fieldrecon.kernels.conditionally_positive_definite import polyharmonic, thin_plate_spline
from fieldrecon.kernels.positive_definite import gaussian, wendland
from fieldrecon.methods import kernel_matrices
from fieldrecon.methods.partition_of_unity import batched_systems
from fieldrecon.methods.partition_of_unity.blending import levels_of
from fieldrecon.methods.partition_of_unity.method import PartitionOfUnityRBF
from fieldrecon.methods.partition_of_unity.patch_systems import PatchSystems
from fieldrecon.methods.rbf import RBF
from fieldrecon.polynomials import monomials
from fieldrecon.reconstruction import Reconstruction
from fieldrecon.selection.leaving_one_out import leave_one_out
from laws import assert_close, refused

N = 130
RNG = np.random.default_rng(11)
X = RNG.random((N, 2))
F = np.cos(X @ [3.0, 2.0]) + 0.1 * RNG.normal(size=N)
EACH = np.where(np.arange(N) % 3 == 0, 0.0, 10.0 ** RNG.uniform(-5, 1, N))
QUERIES = 1.2 * RNG.random((15, 2)) - 0.1

Make = Callable[..., Reconstruction]


def global_fit(kernel: Radial, degree: int) -> Make:
    return lambda x, smoothing: RBF(x, kernel, degree, smoothing)


def patches(x: np.ndarray, smoothing: object) -> PartitionOfUnityRBF:
    return PartitionOfUnityRBF(x, polyharmonic(3), 1, 16, smoothing)


def one_patch(x: np.ndarray, smoothing: object) -> PartitionOfUnityRBF:
    return PartitionOfUnityRBF(x, polyharmonic(3), 1, 2 * N, smoothing)


MAKES = {
    "thin plate": global_fit(thin_plate_spline(), 1),
    "gaussian": global_fit(gaussian(0.1), -1),
    "near pairs": global_fit(wendland(3, 1, 0.08), 0),
    "patches": patches,
}


def equal_entries_are_the_number(make: Make) -> None:
    """An array of equal entries gives the bits of the number."""
    for number in (0.0, 1e-3, 1e4):
        alike = make(X, np.full(N, number)).field(F)
        s = make(X, number).field(F)
        assert_close(alike(QUERIES), s(QUERIES), 0.0)
        assert_close(alike.gradient(QUERIES), s.gradient(QUERIES), 0.0)
        assert alike.method.interpolates == s.method.interpolates == (number == 0)


def entries_belong_to_their_sites(make: Make) -> None:
    """The field does not change if sites, data and smoothing are permuted."""
    order = np.random.default_rng(3).permutation(N)
    there = make(X[order], EACH[order]).field(F[order])
    assert_close(there(QUERIES), make(X, EACH).field(F)(QUERIES), 1e-10)


def data_with_zero_are_interpolated(make: Make) -> None:
    """The others are not, nor does the method declare it."""
    m = make(X, EACH)
    miss = np.abs(m.field(F)(X) - F)
    assert miss[EACH == 0].max() < 1e-10
    assert miss[EACH > 1e-2].min() > 1e-8
    assert not m.interpolates


def data_with_a_huge_entry_have_no_influence(make: Make) -> None:
    """However large the entry is, nothing else loses digits."""
    outliers = np.arange(N) % 8 == 1  # the last site among them
    for huge in (1e12, 1e30, 1e120):
        m = make(X, np.where(outliers, huge, EACH))
        h = laws.dense(m.weights(QUERIES))
        assert np.abs(h[:, outliers]).max() < 1e-9
        s = m.field(np.where(outliers, F + 1.0, F))
        assert_close(s(QUERIES), h @ F, 1e-9)
        zero = EACH == 0
        assert_close(s(X)[zero & ~outliers], F[zero & ~outliers], 1e-9)
        if isinstance(m, RBF):
            without = make(X[~outliers], EACH[~outliers]).field(F[~outliers])
            assert_close(s(QUERIES), without(QUERIES), 1e-8)


def coincident_data_are_averaged_by_precision(make: Make) -> None:
    """Two data of a site are one with their mean, weighted by 1 / smoothing, and the parallel sum.

    1 / smoothing = 1 / smoothing_1 + 1 / smoothing_2, as for variances.
    """
    if make is patches:  # one of them, as one site more would change the others
        make = one_patch
    first, second, g = 1e-2, 4e-2, F[1] + 0.5
    each = np.where(np.arange(N) == 1, first, 1e-3)
    twice = make(np.vstack([X, X[1]]), np.append(each, second)).field(np.append(F, g))
    each[1] = 1 / (1 / first + 1 / second)
    mean = np.where(np.arange(N) == 1, each[1] * (F[1] / first + g / second), F)
    assert_close(twice(QUERIES), make(X, each).field(mean)(QUERIES), 1e-9)


def the_unit_is_that_of_the_kernel(make: Make) -> None:
    """Of homogeneous kernels: smoothing is a length to the power of the homogeneity."""
    m = make(X, EACH)
    power = m.kernel.homogeneity
    if power == 0:
        return
    there = make(X * 1e5, EACH * 1e5**power).field(F)
    assert_close(there(QUERIES * 1e5), m.field(F)(QUERIES), 1e-9)


def leave_one_out_drops_the_entry(make: Make) -> None:
    """The closed form equals the refits without a site and its smoothing."""
    if make is patches:
        laws.leave_one_out_equals_refits(PATCHES)
        return
    few = np.arange(40)
    m = make(X[few], EACH[few])
    refits = Reconstruction._leave_one_out(m, F[few, None], None)[:, 0]
    assert_close(leave_one_out(m, F[few]), refits, 1e-8)


SMOOTHING_LAWS = [
    equal_entries_are_the_number,
    entries_belong_to_their_sites,
    data_with_zero_are_interpolated,
    data_with_a_huge_entry_have_no_influence,
    coincident_data_are_averaged_by_precision,
    the_unit_is_that_of_the_kernel,
    leave_one_out_drops_the_entry,
]
PATCHES = PatchesCase("PU with a smoothing for each datum", lambda p, _: patches(p, EACH), 2, N)


@pytest.mark.parametrize("name", MAKES)
def test_every_method_obeys_the_laws(name):
    """Dense, sparse, and on patches."""
    laws.assert_obeyed(SMOOTHING_LAWS, MAKES[name], name)


class NumberOnly(RBF):
    """The mean of the entries for all."""

    def __init__(self, points, kernel, degree=None, smoothing=0.0):
        super().__init__(points, kernel, degree, np.mean(smoothing))


class HalfOfEach(RBF):
    """Takes half of each entry of an array."""

    def __init__(self, points, kernel, degree=None, smoothing=0.0):
        super().__init__(points, kernel, degree, smoothing / 2 if np.ndim(smoothing) else smoothing)


class EntryStays(RBF):
    """The last site's entry is dropped, whichever site is left out."""

    _each_site = ()

    def _arguments(self):
        return super()._arguments() | {"smoothing": self.smoothing[: len(self.points) - 1]}


class UnitForgotten(RBF):
    """Takes r^2 for the kernel of the plane's plate."""

    def __init__(self, points, kernel, degree=None, smoothing=0.0):
        super().__init__(points, kernel, degree, smoothing / np.ptp(points) ** 2)


def made(mutant: type[RBF]) -> Make:
    return lambda x, smoothing: mutant(x, thin_plate_spline(), 1, smoothing)


def by_the_order_of_the_level(points, k, problem, *how):
    """The levels, with the entries of the first sites."""
    for level in levels_of(points, k, problem, *how):
        for systems in level.systems:
            object.__setattr__(systems, "problem", problem)
        yield level


def out_of_balance(make: Make) -> Make:
    """The method without the factors for large entries of the diagonal."""

    def unbalanced(diagonal, _):
        return np.ones_like(diagonal)

    def wrong(x, smoothing):
        with mock.patch.object(kernel_matrices, "balancing", unbalanced):
            return make(x, smoothing)

    return wrong


@pytest.mark.parametrize(
    ("law", "mutant"),
    [
        (equal_entries_are_the_number, made(HalfOfEach)),
        (data_with_zero_are_interpolated, made(NumberOnly)),
        (coincident_data_are_averaged_by_precision, made(NumberOnly)),
        (leave_one_out_drops_the_entry, made(EntryStays)),
        (the_unit_is_that_of_the_kernel, made(UnitForgotten)),
        (data_with_a_huge_entry_have_no_influence, out_of_balance(MAKES["thin plate"])),
    ],
)
def test_the_law_rejects_the_mutant(law, mutant):
    """A wrong method violates the law that it was written for, or loses all digits."""
    with pytest.raises((AssertionError, np.linalg.LinAlgError)):
        law(mutant)


def test_the_laws_reject_wrong_patches():
    """Entries in another order, a scale of each patch, and no balance."""
    with mock.patch(
        "fieldrecon.methods.partition_of_unity.method.levels_of", by_the_order_of_the_level
    ):
        for law in (entries_belong_to_their_sites, data_with_zero_are_interpolated):
            with pytest.raises(AssertionError):
                law(patches)
    unbalanced = mock.patch.object(
        batched_systems, "balancing", lambda diagonal, _: np.ones_like(diagonal)
    )
    with unbalanced, pytest.raises((AssertionError, np.linalg.LinAlgError)):
        data_with_a_huge_entry_have_no_influence(patches)
    mean = mock.patch.object(
        PatchSystems,
        "_smoothing",
        lambda self, patch: np.full(self.sites[patch].shape, self.problem.smoothing.mean()),
    )
    with mean, pytest.raises(AssertionError):
        data_with_zero_are_interpolated(patches)


# --- other routes ---------------------------------------------------------------------------------


def test_the_field_is_the_mean_of_a_gaussian_process():
    """K(x, X) (K + diag(variances) / sigma^2)^-1 f, and with a polynomial universal kriging."""
    sigma, kernel = 2.5, gaussian(0.2)
    variances = sigma**2 * (EACH + 1e-3)
    k, there = kernel(cdist(X, X)), kernel(cdist(QUERIES, X))
    covariance = sigma**2 * k + np.diag(variances)
    mean = sigma**2 * there @ np.linalg.solve(covariance, F)
    s = RBF(X, kernel, smoothing=variances / sigma**2).field(F)
    assert_close(s(QUERIES), mean, 1e-9)
    p, q = monomials(X, 1), monomials(QUERIES, 1)
    trend = np.linalg.solve(
        p.T @ np.linalg.solve(covariance, p), p.T @ np.linalg.solve(covariance, F)
    )
    mean = q @ trend + sigma**2 * there @ np.linalg.solve(covariance, F - p @ trend)
    s = RBF(X, kernel, 1, variances / sigma**2).field(F)
    assert_close(s(QUERIES), mean, 1e-9)


def test_the_matrix_and_the_coefficients_have_the_entries():
    """H_RBF (λ, c) = (f, 0), with the smoothing on the diagonal."""
    m = RBF(X, thin_plate_spline(), smoothing=EACH)
    lam, c = m.coefficients(np.stack([F, F**2], axis=1))
    h = m.matrix()
    assert_close(np.diagonal(h)[:N], EACH, 0.0)
    right = np.concatenate([np.stack([F, F**2], axis=1), np.zeros((3, 2))])
    assert_close(h @ np.concatenate([lam, c]), right, 1e-9)


def test_balanced_systems_have_no_entry_much_larger_than_the_others():
    """The factors are powers of two, and one where the diagonal is not larger."""
    s = saddle_point.balancing(np.array([0.0, 1.0, 5.0, 1e30]), np.array([2.0, -1.0, 0.5]))
    assert s[:2].tolist() == [1.0, 1.0]
    assert ((s**2 * [0.0, 1.0, 5.0, 1e30]) <= 2.0).all()
    assert (np.frexp(s)[0] == 0.5).all()
    assert saddle_point.balancing(np.array([0.0, 3.0]), np.array([0.0])).tolist() == [1.0, 1.0]


@pytest.mark.parametrize("make", [RBF, PartitionOfUnityRBF])
def test_wrong_entries_are_refused(make):
    """By name, with what came. Of coincident sites at most one may have zero."""
    kernel = polyharmonic(3)
    wrong = {
        r"smoothing must have one entry for each point, shape \(130, ...\); got \(3,\)": [1, 2, 3],
        r"smoothing must not be negative; smoothing\[2\] is -1": np.where(np.arange(N) == 2, -1, 0),
        r"smoothing must be finite; smoothing\[0\] is nan": np.where(np.arange(N), 1.0, np.nan),
        r"real numbers of the shape \(130,\), .*; got the shape \(130, 1\)": EACH[:, None],
        "the type complex128": EACH + 0j,
        "smoothing must be an array of numbers": [[1.0], [1.0, 2.0]],
        "smoothing must be zero or a positive number; got -1": -1,
    }
    for words, smoothing in wrong.items():
        with refused(words):
            make(X, kernel, smoothing=smoothing)
    twice, each = np.vstack([X, X[4], X[0]]), np.append(EACH, [0.1, 0.0])
    with refused("these coincide: 0 and 131; merge them"):
        make(twice, kernel, smoothing=each)
    each[-1] = 1e-3
    assert not make(twice, kernel, smoothing=each).interpolates
    own = EACH.copy()
    m = make(X, kernel, smoothing=own)
    own[:] = 7.0
    assert np.array_equal(m.smoothing, EACH)
    assert not m.smoothing.flags.writeable
