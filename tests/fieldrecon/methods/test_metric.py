"""Anisotropic distances: the isotropic method on mapped sites, with the chain rule."""

from unittest import mock

import numpy as np
import pytest
from scipy.linalg import sqrtm

import fieldrecon as fr
from fieldrecon.methods.metric import MetricFrame, as_metric
from fieldrecon.methods.moving_least_squares import MovingLeastSquares
from fieldrecon.methods.partition_of_unity.method import PartitionOfUnityRBF
from fieldrecon.methods.rbf import RBF
from fieldrecon.reconstruction import Reconstruction
from fieldrecon.selection.leaving_one_out import leave_one_out
from laws import assert_close, dense, refused

RNG = np.random.default_rng(5)
X = RNG.random((90, 2))
F = np.cos(X @ [3.0, 2.0])
QUERIES = RNG.random((7, 2))
MATRIX = np.array([[4.0, 1.0], [1.0, 0.5]])
SCALES = np.array([0.5, 3.0])

MAKES = {
    "RBF": lambda x, **how: RBF(x, fr.thin_plate_spline(), **how),
    "smoothed RBF": lambda x, **how: RBF(x, fr.gaussian(0.3), 1, 1e-3, **how),
    "sparse RBF": lambda x, **how: RBF(x, fr.wendland(3, 2, 0.2), **how),
    "nearest sites": lambda x, **how: MovingLeastSquares(x, fr.wendland(3, 2), 1, 9, **how),
    "sites within a radius": lambda x, **how: MovingLeastSquares(
        x, fr.wendland(3, 2, 0.7), 1, **how
    ),
    "patches": lambda x, **how: PartitionOfUnityRBF(x, fr.polyharmonic(3), 2, 14, **how),
}


def assert_same_in_other_coordinates(m: Reconstruction, there: Reconstruction, root) -> None:
    """The method at x, and the isotropic one `there` at y = L x."""
    x, y, load = QUERIES, QUERIES @ root.T, np.cos(np.arange(7))
    s, t = m.field(F), there.field(F)
    assert_close(s(x), t(y), 1e-9)
    assert_close(s.gradient(x), t.gradient(y) @ root, 1e-7)
    assert_close(s.hessian(x), root.T @ t.hessian(y) @ root, 1e-5)
    assert_close(s.laplacian(x), np.trace(root.T @ t.hessian(y) @ root, axis1=1, axis2=2), 1e-5)
    assert_close(dense(m.weights(x)), dense(there.weights(y)), 1e-9)
    g = np.stack([dense(g) @ F for g in m.gradient_weights(x)], axis=1)
    assert_close(g, s.gradient(x), 1e-8)
    assert_close(m.adjoint(x, load), there.adjoint(y, load), 1e-9)
    assert_close(leave_one_out(m, F), leave_one_out(there, F), 1e-8)
    assert (m.degree, m.interpolates) == (there.degree, there.interpolates)


@pytest.mark.slow
@pytest.mark.parametrize("name", MAKES)
def test_a_metric_is_a_change_of_coordinates(name):
    """With the symmetric root of the matrix, where the method does not depend on the axes."""
    make = MAKES[name]
    roots = {
        "matrix": np.linalg.cholesky(MATRIX).T if name == "patches" else sqrtm(MATRIX),
        "scales": np.diag(1 / SCALES),
    }
    for (_, root), metric in zip(roots.items(), (MATRIX, SCALES), strict=True):
        assert_same_in_other_coordinates(make(X, metric=metric), make(X @ root.T), root)
    diagonal = make(X, metric=np.diag(1 / SCALES**2)).field(F)
    assert_close(diagonal(QUERIES), make(X, metric=SCALES).field(F)(QUERIES), 1e-9)
    isotropic = make(X).field(F)
    for identity in (np.ones(2), np.eye(2)):
        s = make(X, metric=identity).field(F)
        assert_close(s(QUERIES), isotropic(QUERIES), 1e-11)
        assert_close(s.gradient(QUERIES), isotropic.gradient(QUERIES), 1e-9)


def test_wrong_metrics_break_the_change_of_coordinates():
    """Scales that multiply, a transposed factor, and derivatives that are not mapped back."""
    root, make = sqrtm(MATRIX), MAKES["RBF"]
    there = make(X @ root.T)

    def unchanged(_, by_y):
        return by_y

    def transposed(self, x):
        return (x - self.center) @ self.factor / self.scale

    wrong = {"gradient": unchanged, "hessian": unchanged, "partials": unchanged}
    for name, mapped in (wrong | {"local": transposed}).items():
        with mock.patch.object(MetricFrame, name, mapped), pytest.raises(AssertionError):
            assert_same_in_other_coordinates(make(X, metric=MATRIX), there, root)
    there = make(X @ np.diag(1 / SCALES))
    with pytest.raises(AssertionError):
        assert_same_in_other_coordinates(make(X, metric=1 / SCALES), there, np.diag(1 / SCALES))


@pytest.mark.parametrize("name", MAKES)
def test_a_method_with_a_metric_is_saved_and_made_again(name, tmp_path):
    """With its matrix or scales, from a list; a file without a metric is isotropic."""
    for metric in (MATRIX.tolist(), SCALES.tolist(), None):
        s = MAKES[name](X, metric=metric).field(F)
        fr.save(tmp_path / "field.npz", s)
        again = fr.load(tmp_path / "field.npz")
        assert np.array_equal(again.gradient(QUERIES), s.gradient(QUERIES))
        others = s.method._without(4).field(np.delete(F, 4))
        again = MAKES[name](np.delete(X, 4, axis=0), metric=metric).field(np.delete(F, 4))
        assert np.array_equal(others(QUERIES), again(QUERIES))
    arguments = s.method._arguments()
    assert arguments.pop("metric") is None


def test_a_metric_acts_on_chords_of_the_globe():
    """The inner method has it, on unit vectors; gradients by degrees agree with differences."""
    lonlat = X * [300, 140] - [150, 70]
    m = fr.OnGlobe(lonlat, lambda u: RBF(u, fr.polyharmonic(3), metric=[1.0, 1.0, 0.2]))
    s, step = m.field(F), 1e-4
    x = lonlat[:5] + 3.0
    for k in range(2):
        h = step * np.eye(2)[k]
        assert_close(s.gradient(x)[:, k], (s(x + h) - s(x - h)) / (2 * step), 1e-6)


@pytest.mark.parametrize("make", MAKES.values(), ids=list(MAKES))
def test_wrong_metrics_are_refused(make):
    """By name, with what came."""
    wrong = {
        r"metric must have one entry for each coordinate, shape \(2, ...\); got \(3,\)": [1, 2, 3],
        r"metric must have one entry for each coordinate, .*; got \(\)": 2.0,
        r"or a matrix of the shape \(2, 2\); got the shape \(2, 3\)": np.ones((2, 3)),
        "got the shape .* and the type complex128": np.eye(2) * 1j,
        r"metric must have positive scales; metric\[1\] is -1": [1, -1],
        r"metric must have positive scales; metric\[0\] is 0": [0, 1],
        r"metric must have positive scales; metric\[1\] is 0": [1, 0],
        r"metric must be finite; metric\[1, 1\] is nan": np.diag([1, np.nan]),
        r"must be symmetric; metric\[0, 1\] is 2 and metric\[1, 0\] is 1": [[4, 2], [1, 4]],
    }
    for words, metric in wrong.items():
        with refused(words):
            make(X, metric=metric)
    for matrix, least in (
        ([[1, 2], [2, 1]], "-1, and its largest entry 2"),
        ([[1, 1], [1, 1]], "(0|-?[0-9.]+e-1[5-9]), and its largest entry 1"),
        (np.zeros((2, 2)), "0, and its largest entry 0"),
        (np.diag([-1, -3]), "-3, and its largest entry 3"),
    ):
        words = f"metric must be positive definite; its least eigenvalue is {least}$"
        with refused(words, np.linalg.LinAlgError):
            make(X, metric=matrix)


def test_a_matrix_that_is_singular_up_to_rounding_is_refused():
    """Without distances along a diagonal of space; with an eigenvalue above rounding it is none."""
    rng = np.random.default_rng(3)
    for d in (2, 3, 5, 8, 12, 40):
        for _ in range(5):
            along = rng.choice([-1.0, 1.0], d) / np.sqrt(d)
            flat = np.eye(d) - np.outer(along, along)
            with refused("metric must be positive definite", np.linalg.LinAlgError):
                as_metric(flat, d)
            assert not as_metric(flat + 1e-12 * np.eye(d), d).flags.writeable


@pytest.mark.parametrize("d", [2, 3, 4, 6])
def test_the_order_and_units_of_coordinates_do_not_make_a_singular_matrix_a_metric(d):
    """A random direction without distance, which may be short along any of the axes."""
    rng = np.random.default_rng(d)
    for _ in range(50):
        a = rng.standard_normal((d, d - 1)) * 10.0 ** rng.uniform(-3, 3, (d, 1))
        with refused("metric must be positive definite", np.linalg.LinAlgError):
            as_metric(a @ a.T, d)


def test_a_metric_that_flattens_the_sites_is_named():
    """In its distances they lie on a line; patches of them keep what a line determines."""
    for make in (MAKES["RBF"], MAKES["nearest sites"]):
        with refused("as far apart as the metric says, do not determine", np.linalg.LinAlgError):
            make(X, metric=[1e300, 1.0])
    assert MAKES["RBF"](X, metric=[1e-6, 1.0]).degree == 1
    flat = MAKES["patches"](X, metric=[1e-9, 1.0])
    assert flat.reduced > 0
    assert flat.degree == 0


def test_the_callers_metric_is_copied_and_its_unit_does_not_matter():
    """From 1e-140 to 1e140; beyond the range, distances are refused."""
    own = MATRIX.copy()
    m = RBF(X, fr.thin_plate_spline(), metric=own)
    expected = m.field(F)
    own[:] = 0.0
    assert np.array_equal(m.metric, MATRIX)
    for unit in (1e-140, 1e140):
        s = RBF(X, fr.thin_plate_spline(), metric=MATRIX / unit / unit).field(F)
        assert_close(s(QUERIES), expected(QUERIES), 1e-9)
        assert_close(s.gradient(QUERIES), expected.gradient(QUERIES), 1e-8)
    with refused("distances of the metric exceed the range", OverflowError):
        RBF(X * 1e200, fr.thin_plate_spline(), metric=[1e-200, 1.0])
    assert as_metric(None, 2) is None
