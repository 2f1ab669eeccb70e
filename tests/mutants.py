"""Mutants: for every law, wrong methods that it must reject.

Each mutant is a case like those of the correct methods, and has only one error.
"""

import threading
from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import islice
from unittest import mock

import numpy as np
from scipy.spatial.distance import cdist

import laws
from cases import GLOBE_CASES, Case, case
from fieldrecon._core import validation as valid
from fieldrecon._numerics import neighbor_search
from fieldrecon._numerics.jets import rows_of_jet
from fieldrecon._numerics.neighbor_search import Nearest
from fieldrecon.barycentric.coordinates import BarycentricCoordinates
from fieldrecon.fields import Field
from fieldrecon.kernels.conditionally_positive_definite import polyharmonic, thin_plate_spline
from fieldrecon.kernels.positive_definite import gaussian, wendland
from fieldrecon.kernels.weights import inverse_square
from fieldrecon.methods import local_fits
from fieldrecon.methods.least_squares import LeastSquares
from fieldrecon.methods.local_fits import LocalFit
from fieldrecon.methods.metric import MetricFrame
from fieldrecon.methods.moving_least_squares import MovingLeastSquares
from fieldrecon.methods.partition_of_unity import blending as _blending
from fieldrecon.methods.partition_of_unity import method as partition_of_unity
from fieldrecon.methods.partition_of_unity import patches as _patches
from fieldrecon.methods.partition_of_unity.method import PartitionOfUnityRBF
from fieldrecon.methods.rbf import RBF
from fieldrecon.polynomials import Frame, monomials
from fieldrecon.reconstruction import Reconstruction

LINE = case("LS degree 1 in 2-D")
PARABOLA = case("LS degree 2 in 2-D")
CONSTANT = case("LS degree 0 in 2-D")
MOVING = case("MLS ε = 0.1, degree 1 in 2-D")
SHEPARD = case("MLS ε = 0, degree 0 in 2-D")
NEAREST = case("MLS wendland on 8 nearest, degree 1 in 2-D")
PLATE = case("RBF thin plate in 2-D")
FARTHER = replace(PLATE, units=(3.0,))
SMOOTHED = case("RBF thin plate, one degree more, smoothed, in 2-D")


OBLIQUE = case("RBF gaussian with a metric in 2-D")
PATCHES = case("PU r³ on 16 sites, degree 1 in 2-D")
POLYGON = case("coordinates of the regular 20-gon")
REGION = next(c for c in GLOBE_CASES if c.name == "globe PU")
SPHERE = case("PU, sphere in 3-D")


class Wrapped(Reconstruction):
    """A method that wraps another one; a mutant overrides one of its operations."""

    def __init__(self, right: Reconstruction) -> None:
        self.right = right
        self.points, self.degree, self.interpolates = right.points, right.degree, right.interpolates

    def _prepare(self, values):
        return self.right._prepare(values)

    def _value_rows(self, x, prepared):
        return self.right._value_rows(x, prepared)

    def _gradient_rows(self, x, prepared):
        return self.right._gradient_rows(x, prepared)

    def _hessian_rows(self, x, prepared):
        return self.right._hessian_rows(x, prepared)

    def _weight_rows(self, x):
        return self.right._weight_rows(x)

    def _gradient_weight_rows(self, x):
        return self.right._gradient_weight_rows(x)

    def _adjoint(self, x, f, *how):
        return self.right._adjoint(x, f, *how)

    def _chunk_rows(self, columns):
        return self.right._chunk_rows(columns)

    @property
    def _has_sparse_weights(self):
        return self.right._has_sparse_weights

    def _weight_chunk_rows(self):
        return self.right._weight_chunk_rows()


def wrapped(right: Case, mutant: type[Wrapped]) -> Case:
    """The case with its method wrapped by a mutant."""
    return replace(right, name=mutant.__name__, make=lambda p, unit: mutant(right.make(p, unit)))


def made(right: Case, name: str, make: Callable[..., Reconstruction]) -> Case:
    """The case with another method."""
    return replace(right, name=name, make=make)


# --- declarations ---------------------------------------------------------------------------------


class DegreeTooHigh(Wrapped):
    """Declares a degree that is too high by one."""

    def __init__(self, right):
        super().__init__(right)
        self.degree += 1


class DegreeTooLow(Wrapped):
    """Declares a degree that is too low by one."""

    def __init__(self, right):
        super().__init__(right)
        self.degree -= 1


class InterpolationMisdeclared(Wrapped):
    """Declares that it interpolates if it does not, and vice versa."""

    def __init__(self, right):
        super().__init__(right)
        self.interpolates = not right.interpolates


# --- polynomials, constraints, gradients ----------------------------------------------------------


class ConstraintForgotten(Reconstruction):
    """Interpolates with kernels only, without polynomial and side conditions."""

    def __init__(self, points):
        self.points, self.degree, self.interpolates = valid.as_points(points), 1, True
        self.kernel = polyharmonic(3)
        self.inverse = np.linalg.inv(self.kernel(cdist(self.points, self.points)))

    def _weight_rows(self, x):
        return self.kernel(cdist(x, self.points)) @ self.inverse

    def _gradient_weight_rows(self, x):
        slope = self.kernel.slope(cdist(x, self.points))
        offset = x[:, None, :] - self.points
        return tuple((slope * offset[..., k]) @ self.inverse for k in range(x.shape[1]))


class GradientInLocalCoordinates(Wrapped):
    """Omits the factor 1/h of the derivative with respect to (x - a)/h, as if h = 2."""

    def _gradient_rows(self, x, prepared):
        return 2 * super()._gradient_rows(x, prepared)

    def _gradient_weight_rows(self, x):
        return tuple(2 * g for g in super()._gradient_weight_rows(x))


@dataclass(frozen=True)
class frozen_weight(inverse_square):
    """Treats the weight as constant, which gives the diffuse gradient, with c(x) fixed."""

    def slope_of_squared(self, s):
        return np.zeros_like(s)

    def in_units(self, h):
        return frozen_weight(self.epsilon / h)


@dataclass(frozen=True)
class weight_not_squared(inverse_square):
    """Uses the slope of w instead of that of w²."""

    def slope_of_squared(self, s):
        return super().slope_of_squared(s) / 2

    def in_units(self, h):
        return weight_not_squared(self.epsilon / h)


class ReachHeldFixed(MovingLeastSquares):
    """The gradient of w(r/ρ) without the derivative of ρ, the distance of the (k + 1)-th site."""

    def _gradient_rows(self, x, prepared):
        return np.stack([self._at(y, prepared) for y in x])

    def _at(self, y, values):
        near = Nearest(self.points, self.neighbors)(y[None])
        index, reach = near.index[0], float(near.reach[0])
        fixed = wendland(self.weight.d, self.weight.k, reach)
        s = MovingLeastSquares(self.points[index], fixed, self.degree).field(values[index])
        return s.gradient(y)


@dataclass(frozen=True)
class no_limit_at_the_centre(thin_plate_spline):
    """Uses φ'(r)/r at r = 1 instead of the limit at r = 0, also close to zero."""

    def slope_of_squared(self, s):
        return np.where(s > 1e-2, super().slope_of_squared(s), 2.0)


# --- data, weights, adjoint -----------------------------------------------------------------------


class ClippedToTheData(Wrapped):
    """Clips values to the range of the data, and is therefore not linear."""

    def _prepare(self, values):
        return super()._prepare(values), np.abs(values).max(axis=0) / 2

    def _value_rows(self, x, prepared):
        rows = super()._value_rows(x, prepared[0])
        return np.where(np.abs(rows) > prepared[1], prepared[1], rows)

    def _gradient_rows(self, x, prepared):
        return super()._gradient_rows(x, prepared[0])


class RealPartOnly(Wrapped):
    """Drops the imaginary part of complex data."""

    def _prepare(self, values):
        return super()._prepare(values.real.copy())


class FirstComponentForAll(Wrapped):
    """Uses the coefficients of the first component for all components."""

    def _value_rows(self, x, prepared):
        rows = super()._value_rows(x, prepared)
        return np.broadcast_to(rows[:, :1], rows.shape)


class AtLeastOneComponent(Wrapped):
    """Requires at least one component."""

    def field(self, values):
        values = np.asarray(values)
        return super().field(values if values.size else np.zeros((len(values), 1)))


class WeightsWithoutConstant(Wrapped):
    """Weights without the contribution of the constant polynomial."""

    def _weight_rows(self, x):
        return super()._weight_rows(x) - 1.0 / len(self.points)


class GradientWeightsSwapped(Wrapped):
    """Exchanges the matrices of x and y."""

    def _gradient_weight_rows(self, x):
        return super()._gradient_weight_rows(x)[::-1]


class AdjointByThePseudoInverse(Wrapped):
    """Computes H⁺f instead of Hᵀf."""

    def _adjoint(self, x, f, *how):  # noqa: ARG002
        return np.linalg.pinv(laws.dense(self._weight_rows(x))) @ f


class AdjointDividedByTheComponents(Wrapped):
    """Correct for one component, and divided by two for two."""

    def _adjoint(self, x, f, *how):
        return super()._adjoint(x, f, *how) / f.shape[1]


# --- queries --------------------------------------------------------------------------------------


class WrappedField(Wrapped):
    """A method whose fields are of another class."""

    Made: type[Field] = Field

    def field(self, values):
        return self.Made(self, valid.as_values(values, len(self.points)))


class AxesInFortranOrder(WrappedField):
    """Reads queries in Fortran order."""

    class Made(Field):
        def _evaluate(self, rows_of_result, x, *others):
            x = np.asarray(x)
            reordered = np.reshape(x, x.shape, order="C").reshape(-1, x.shape[-1], order="F")
            return super()._evaluate(rows_of_result, reordered.reshape(x.shape), *others)


class AtLeastOneResult(WrappedField):
    """Returns one result for an empty set of queries."""

    class Made(Field):
        def __call__(self, x, **options):
            result = super().__call__(x, **options)
            return result if result.size else np.zeros((1, *result.shape[1:]))


class DependsOnTheBatch(Wrapped):
    """The result depends on the other queries of the batch."""

    def _value_rows(self, x, prepared):
        return super()._value_rows(x, prepared) + x.mean()


class DependsOnTheThread(Wrapped):
    """The result depends on the thread that computes it."""

    def _value_rows(self, x, prepared):
        rows = super()._value_rows(x, prepared)
        main = threading.current_thread() is threading.main_thread()
        return rows if main else np.nextafter(rows, 9.0)


class RoundedByTheExecutor(Wrapped):
    """An executor returns half precision."""

    def weights(self, x, *, executor=None, **how):
        return rounded_if(executor, super().weights(x, **how))

    def gradient_weights(self, x, *, executor=None, **how):
        return tuple(rounded_if(executor, g) for g in super().gradient_weights(x, **how))

    def adjoint(self, x, f, *, executor=None, **how):
        return rounded_if(executor, super().adjoint(x, f, **how))


def rounded_if(executor, a):
    return a if executor is None else a.astype(np.float16).astype(float)


class ExactWeights(RoundedByTheExecutor):
    """Only gradient weights and the adjoint are rounded."""

    weights = Reconstruction.weights


class OnlyTheAdjointIsRounded(ExactWeights):
    """Neither weights are rounded."""

    gradient_weights = Reconstruction.gradient_weights


class TotalTwice(Wrapped):
    """The total is reported again after the last chunk."""

    def weights(self, x, *, progress=None, **how):
        return total_again(progress, super().weights(x, progress=progress, **how), x)

    def gradient_weights(self, x, *, progress=None, **how):
        return total_again(progress, super().gradient_weights(x, progress=progress, **how), x)

    def adjoint(self, x, f, *, progress=None, **how):
        return total_again(progress, super().adjoint(x, f, progress=progress, **how), x)


def total_again(progress, result, x):
    if progress is not None:
        progress(len(x), len(x))
    return result


class TotalOfTheWeightsOnce(TotalTwice):
    """Only for gradient weights and the adjoint."""

    weights = Reconstruction.weights


class TotalOfTheAdjointTwice(TotalOfTheWeightsOnce):
    """Only for the adjoint."""

    gradient_weights = Reconstruction.gradient_weights


class MadeInHalfPrecision(RBF):
    """An executor rounds the points."""

    def __init__(self, points, kernel, *, executor=None, **how):
        super().__init__(rounded_if(executor, points), kernel, **how)


class MadeWithoutAnEnd(PartitionOfUnityRBF):
    """Progress of the last step is not reported."""

    def __init__(self, points, *args, progress=None, **how):
        def all_but_last(done, total):
            if done < total:
                progress(done, total)

        super().__init__(points, *args, progress=progress and all_but_last, **how)


class MadeTwice(LeastSquares):
    """Progress begins again after it has ended."""

    def __init__(self, points, degree=1, *, executor=None, progress=None):
        super().__init__(points, degree, progress=progress)
        super().__init__(points, degree, executor=executor, progress=progress)


class ProgressWithoutTheLastChunk(WrappedField):
    """The last chunk is not reported."""

    class Made(Field):
        def __call__(self, x, *, executor=None, progress=None):
            def all_but_last(done, total):
                if done < total:
                    progress(done, total)

            return super().__call__(x, executor=executor, progress=progress and all_but_last)


# --- invariance -----------------------------------------------------------------------------------


class AbsoluteCoordinates(Reconstruction):
    """The textbook form: normal equations in monomials of the original coordinates."""

    def __init__(self, points):
        self.points, self.degree, self.interpolates = valid.as_points(points), 1, False

    def _basis(self, x):
        return np.column_stack([np.ones(len(x)), x])

    def _weight_rows(self, x):
        b = self._basis(self.points)
        return self._basis(x) @ np.linalg.solve(b.T @ b, b.T)

    def _gradient_weight_rows(self, x):
        b = self._basis(self.points)
        slopes = np.linalg.solve(b.T @ b, b.T)[1:]
        return tuple(np.tile(row, (len(x), 1)) for row in slopes)


class Stretched(Wrapped):
    """Distances in which one axis counts twice."""

    def __init__(self, right):
        points = right.points
        super().__init__(MovingLeastSquares(points * [1.0, 2.0], right.weight, right.degree))
        self.points = points

    def _value_rows(self, x, prepared):
        return super()._value_rows(x * [1.0, 2.0], prepared)


class LosesConstantsFarAway(Wrapped):
    """Gives values of which rounding has left no digit."""

    def _far_among(self, x):
        return x[:0]


class LosesWeightsFarAway(Wrapped):
    """Gives such weights, and refuses only such values."""

    def _refuse_lost_weights(self, x, executor):
        pass


class FirstSiteTakesTheRest(Wrapped):
    """Adds 0.1 to the weight of the first site."""

    def _weight_rows(self, x):
        h = np.array(super()._weight_rows(x))
        h[:, 0] += 0.1
        return h


# --- input arrays ---------------------------------------------------------------------------------


class WritesToItsInput(Wrapped):
    """Subtracts the mean in place."""

    def field(self, values):
        values = np.asarray(values, dtype=float)
        values -= values.mean(axis=0)
        return super().field(values)


class KeepsTheCallersArray(Wrapped):
    """Keeps a reference to the data."""

    def field(self, values):
        s = super().field(values)
        s._prepared = values.reshape(len(values), -1)
        return s


class SinglePrecisionData(Wrapped):
    """Computes in the precision of its input."""

    def field(self, values):
        values = np.asarray(values)
        s = super().field(values)
        if values.dtype == np.float32:
            s._dtype = np.dtype(np.float32)
        return s


class IntegerAnswers(Wrapped):
    """Returns integers for integer data."""

    def field(self, values):
        values = np.asarray(values)
        s = super().field(values)
        if values.dtype.kind == "i":
            s._dtype = values.dtype
        return s


class LosesStateWhenPickled(Wrapped):
    """A pickled copy has default arguments."""

    def __reduce__(self):
        return LeastSquares, (self.points, 1)


class NanReplacedByZero(Wrapped):
    """Replaces NaN by zero."""

    def field(self, values):
        return super().field(np.nan_to_num(np.asarray(values)))


class AnyLength(Wrapped):
    """Truncates or repeats data to the required length."""

    def field(self, values):
        return super().field(np.resize(values, (len(self.points),)))


class DataInNoUnit(Wrapped):
    """Computes with data as they are, so that products lose their digits, and sums overflow."""

    def field(self, values):
        s = super().field(values)
        s._prepared, s._units = self._prepare(s.values[:, None]), np.ones(1)
        return s


class AbsoluteTolerance(Wrapped):
    """Rounds to zero with an absolute tolerance."""

    def _value_rows(self, x, prepared):
        rows = super()._value_rows(x, prepared)
        return np.where(np.abs(rows) < 1e-100, 0.0, rows)


# --- patches --------------------------------------------------------------------------------------


class BallsTooLarge(PartitionOfUnityRBF):
    """Balls contain sites that are not in their patches."""

    def __init__(self, *arguments):
        super().__init__(*arguments)
        first, *others = self._levels
        larger = replace(first.patches, radii=1.1 * first.patches.radii)
        self._levels = (replace(first, patches=larger), *others)


class OtherShares(PartitionOfUnityRBF):
    """Other blending weights, which a mutant defines."""

    def _value_rows(self, x, prepared):
        with mock.patch.object(partition_of_unity, "shares", self.shares):
            return super()._value_rows(x, prepared)

    def _gradient_rows(self, x, prepared):
        with mock.patch.object(partition_of_unity, "shares", self.shares):
            return super()._gradient_rows(x, prepared)

    def _hessian_rows(self, x, prepared):
        with mock.patch.object(partition_of_unity, "shares", self.shares):
            return super()._hessian_rows(x, prepared)


SHARES = partition_of_unity.shares


class NotNormalized(OtherShares):
    """The blending weights do not sum to one."""

    @staticmethod
    def shares(levels, x, order):
        for share in SHARES(levels, x, order):
            offset = x[share.query] - share.level.patches.centers[share.patch]
            r = np.linalg.norm(offset, axis=1) / share.level.patches.radii[share.patch]
            yield share._replace(weights=((1 - r) ** 4 * (4 * r + 1))[None])


class WeightsHeldFixed(OtherShares):
    """Blends the gradients of the patches without the gradients of the weights."""

    @staticmethod
    def shares(levels, x, order):
        for share in SHARES(levels, x, order):
            rest = 0 * share.weights[1:]
            yield share._replace(weights=np.vstack([share.weights[:1], rest]))


class SecondDerivativesHeldFixed(OtherShares):
    """Leaves out the second derivatives of the weights."""

    @staticmethod
    def shares(levels, x, order):
        first = rows_of_jet(x.shape[1], 1)
        for share in SHARES(levels, x, order):
            rest = 0 * share.weights[first:]
            yield share._replace(weights=np.vstack([share.weights[:first], rest]))


class ZeroOutsideTheBalls(OtherShares):
    """Returns zero outside all balls."""

    @staticmethod
    def shares(levels, x, order):
        yield from islice(SHARES(levels, x, order), 1)


class InSamplePatches(PartitionOfUnityRBF):
    """Residuals of the fit that includes the datum."""

    def _leave_one_out(self, values, progress):  # noqa: ARG002
        return values - self.field(values)(self.points)


def patches(mutant: type[PartitionOfUnityRBF], right: Case = PATCHES) -> Case:
    """The case of small patches with a mutant."""
    return made(right, mutant.__name__, lambda p, _: mutant(p, polyharmonic(3), 1, 14))


# --- arrangements ---------------------------------------------------------------------------------


class LeastNormPolynomials(PartitionOfUnityRBF):
    """Takes the polynomial of least norm over all degrees at once: a mix of 1 and x² + y² for 1."""

    def __init__(self, *arguments):
        super().__init__(*arguments)
        for systems in (s for level in self._levels for s in level.systems):
            for patch in systems.bases:
                y = systems.frames(np.array([patch]))[0]
                systems.bases[patch] = least_norm_basis(y, systems.degree)


def least_norm_basis(y: np.ndarray, degree: int) -> np.ndarray:
    """Coefficients (q, q) of polynomials of least norm with the same values at the sites (k, d)."""
    _, sigma, vt = np.linalg.svd(monomials(y, degree), full_matrices=False)
    rank = (sigma > 1e-10 * sigma[0]).sum()
    basis = np.zeros((vt.shape[1], vt.shape[1]))
    basis[:, :rank] = vt[:rank].T / sigma[:rank]
    return basis


class LeastNormParabola(LeastSquares):
    """Takes the polynomial of least norm where the sites determine none."""

    def __init__(self, points):
        self.points, self.degree, self.interpolates = valid.as_points(points), 2, False

    def _weight_rows(self, x):
        return monomials(x, 2) @ np.linalg.pinv(monomials(self.points, 2))

    def _gradient_weight_rows(self, x):
        return tuple(np.zeros((x.shape[1], len(x), len(self.points))))

    def _far_among(self, x):
        return x[:0]

    _prepare, _value_rows = Reconstruction._prepare, Reconstruction._value_rows


class PolynomialsAnywhere(LeastSquares):
    """Takes polynomials also where their rounding decides the values."""

    def _basis_at(self, x):
        return self._basis.values(self._frame.local(x))

    def _far_among(self, x):
        return x[:0]


class CornersInSinglePrecision(BarycentricCoordinates):
    """Rounds its corners, which have digits beyond those of their distance from the origin."""

    def __init__(self, vertices):
        super().__init__(vertices.astype(np.float32))


class MeetsOnlySmoothData(PartitionOfUnityRBF):
    """Declares that it interpolates where only the fields of smooth data are not refused."""

    interpolates = True


class WeightsOfAnySize(MovingLeastSquares):
    """Gives values whose weights are so large that rounding leaves no digit of them."""

    def _weight_rows(self, x):
        with mock.patch.object(local_fits, "LARGEST_SUM", np.inf):
            return super()._weight_rows(x)

    def _value_rows(self, x, prepared):
        with mock.patch.object(local_fits, "LARGEST_SUM", np.inf):
            return super()._value_rows(x, prepared)


def made_while(right: Case, name: str, arrangement: str, where, what: str, instead) -> Case:
    """The case on an arrangement, made while a name of a module is something else."""

    def make(points, unit):
        with mock.patch.object(where, what, instead):
            return right.make(points, unit)

    return replace(right, name=name, make=make, arrangements=(arrangement,))


def no_outliers(*_) -> np.ndarray:
    return np.array([], dtype=int)


def as_they_come(points: np.ndarray) -> np.ndarray:
    return np.arange(len(points))


CUBICS = case("PU r³ on 16 sites, degree 3 in 2-D")
GAUSSIAN = case("MLS gaussian on 8 nearest, degree 1 in 2-D")
WIDER = case("MLS gaussian, degree 3 in 2-D")
ONE_PATCH = case("PU with one patch in 2-D")
CIRCLE = replace(CUBICS, arrangements=("circle",))


# --- leave one out --------------------------------------------------------------------------------


class InSamplePolynomial(LeastSquares):
    """Treats leverages as zero: residuals of the fit that includes the datum."""

    def leverages(self):
        return np.zeros(len(self.points))


class InSampleMoving(MovingLeastSquares):
    """Treats own weights as zero: residuals of the fit that includes the datum."""

    def own_weights(self):
        return np.zeros(len(self.points))


class WithoutTheNextNeighbour(MovingLeastSquares):
    """Removes a site from its neighbourhood without adding the next one."""

    def predictions_from_others(self, values, sites, progress=None):
        fewer = MovingLeastSquares(self.points, self.weight, self.degree, self.neighbors - 1)
        return fewer.predictions_from_others(values, sites, progress)


class WrongDiagonal(RBF):
    """Divides by ones instead of the diagonal of the inverse."""

    def inverse_diagonal(self):
        return np.ones(len(self.points))


class HessianInTheFrame(Wrapped):
    """Divides the second derivatives by h, here 2, once only."""

    def _hessian_rows(self, x, prepared):
        return 2 * super()._hessian_rows(x, prepared)


class LaplacianOfTheFirstVariable(Wrapped):
    """Leaves out the other variables."""

    def _laplacian_rows(self, x, prepared):
        return self._hessian_rows(x, prepared)[..., 0, 0]


class HessianOfThePolynomial(MovingLeastSquares):
    """Second derivatives of the polynomial of each fit, whose coefficients change as well."""

    def _hessian_rows(self, x, prepared):
        constant = {
            "_log_gradient": lambda fit: 0 * fit.offset,
            "_log_hessian": lambda fit, *_: 0 * fit.r,
        }
        with mock.patch.multiple(LocalFit, **constant):
            return super()._hessian_rows(x, prepared)


class BendOfTheWeightsForgotten(MovingLeastSquares):
    """Takes the logarithm of the weight as linear in the squared distance."""

    def _hessian_rows(self, x, prepared):
        with mock.patch.object(local_fits, "log_square_bend", lambda *args: 0 * args[1]):
            return super()._hessian_rows(x, prepared)


class GradientNotMappedBack(RBF):
    """Derivatives by the coordinates in which the metric is Euclidean."""

    def _gradient_rows(self, x, prepared):
        with mock.patch.object(MetricFrame, "gradient", Frame.gradient):
            return super()._gradient_rows(x, prepared)

    def _hessian_rows(self, x, prepared):
        with mock.patch.object(MetricFrame, "hessian", Frame.hessian):
            return super()._hessian_rows(x, prepared)


def not_mapped_back(points, unit):
    return GradientNotMappedBack(points, gaussian(0.3 * unit), 1, metric=[[2.0, 1.0], [1.0, 2.0]])


class HessianDiagonal(Wrapped):
    """Leaves out the mixed derivatives, which only other axes show."""

    def _hessian_rows(self, x, prepared):
        hessian = super()._hessian_rows(x, prepared)
        return hessian * np.eye(x.shape[1])


MUTANTS: dict[Callable[[Case], None], list[Case]] = {
    laws.polynomials_of_the_degree_are_reproduced: [
        wrapped(LINE, DegreeTooHigh),
        wrapped(PLATE, DegreeTooHigh),
        made(PLATE, "ConstraintForgotten", lambda p, _: ConstraintForgotten(p)),
        patches(NotNormalized),
        patches(ZeroOutsideTheBalls, SPHERE),
    ],
    laws.polynomials_of_the_next_degree_are_not_reproduced: [
        wrapped(LINE, DegreeTooLow),
        wrapped(PLATE, DegreeTooLow),
        wrapped(MOVING, DegreeTooLow),
    ],
    laws.gradients_of_polynomials_are_reproduced: [
        wrapped(PARABOLA, GradientInLocalCoordinates),
        made(PLATE, "ConstraintForgotten", lambda p, _: ConstraintForgotten(p)),
    ],
    laws.polynomials_are_reproduced_far_away_or_refused: [
        wrapped(CUBICS, LosesConstantsFarAway),
        wrapped(CUBICS, LosesWeightsFarAway),
    ],
    laws.data_are_interpolated_if_and_only_if_declared: [
        wrapped(PLATE, InterpolationMisdeclared),
        wrapped(LINE, InterpolationMisdeclared),
        wrapped(SMOOTHED, InterpolationMisdeclared),
        wrapped(MOVING, InterpolationMisdeclared),
        patches(BallsTooLarge),
    ],
    laws.the_field_is_linear_in_the_data: [
        wrapped(PLATE, ClippedToTheData),
        wrapped(PLATE, RealPartOnly),
    ],
    laws.components_do_not_mix: [wrapped(MOVING, FirstComponentForAll)],
    laws.data_without_components_give_empty_results: [wrapped(LINE, AtLeastOneComponent)],
    laws.the_field_is_weights_times_data: [
        wrapped(LINE, WeightsWithoutConstant),
        patches(ZeroOutsideTheBalls, SPHERE),
    ],
    laws.the_gradient_is_gradient_weights_times_data: [wrapped(PLATE, GradientWeightsSwapped)],
    laws.the_gradient_is_the_derivative: [
        wrapped(PARABOLA, GradientInLocalCoordinates),
        made(MOVING, "DiffuseGradient", lambda p, u: MovingLeastSquares(p, frozen_weight(u / 10))),
        made(MOVING, "NotSquared", lambda p, u: MovingLeastSquares(p, weight_not_squared(u / 10))),
        made(NEAREST, "ReachHeldFixed", lambda p, _: ReachHeldFixed(p, wendland(3, 2), 1, 8)),
        made(PLATE, "NoLimit", lambda p, _: RBF(p, no_limit_at_the_centre())),
        made(OBLIQUE, "GradientNotMappedBack", not_mapped_back),
        patches(WeightsHeldFixed),
    ],
    laws.hessians_are_derivatives_of_gradients: [
        wrapped(PLATE, HessianInTheFrame),
        wrapped(PLATE, LaplacianOfTheFirstVariable),
        made(OBLIQUE, "HessianNotMappedBack", not_mapped_back),
        made(
            MOVING,
            "HessianOfThePolynomial",
            lambda p, u: HessianOfThePolynomial(p, inverse_square(u / 10)),
        ),
        made(
            MOVING,
            "BendOfTheWeightsForgotten",
            lambda p, u: BendOfTheWeightsForgotten(p, inverse_square(u / 10)),
        ),
        patches(SecondDerivativesHeldFixed),
    ],
    laws.hessians_change_with_axes_and_unit: [wrapped(MOVING, HessianDiagonal)],
    laws.the_adjoint_is_the_transpose: [
        wrapped(LINE, AdjointByThePseudoInverse),
        wrapped(PLATE, AdjointDividedByTheComponents),
    ],
    laws.the_field_and_the_adjoint_are_consistent: [wrapped(PLATE, AdjointByThePseudoInverse)],
    laws.leading_axes_of_queries_are_kept: [wrapped(MOVING, AxesInFortranOrder)],
    laws.empty_queries_give_empty_results: [wrapped(LINE, AtLeastOneResult)],
    laws.results_do_not_depend_on_the_chunks: [wrapped(PLATE, DependsOnTheBatch)],
    laws.results_do_not_depend_on_the_executor: [
        wrapped(LINE, DependsOnTheThread),
        wrapped(LINE, RoundedByTheExecutor),
        wrapped(LINE, ExactWeights),
        wrapped(LINE, OnlyTheAdjointIsRounded),
    ],
    laws.progress_increases_to_the_total: [
        wrapped(PLATE, ProgressWithoutTheLastChunk),
        wrapped(PLATE, TotalTwice),
        wrapped(PLATE, TotalOfTheWeightsOnce),
        wrapped(PLATE, TotalOfTheAdjointTwice),
    ],
    laws.making_does_not_depend_on_the_executor: [
        made(
            PLATE,
            "MadeInHalfPrecision",
            lambda p, _: MadeInHalfPrecision(p, thin_plate_spline()),
        ),
        patches(MadeWithoutAnEnd),
        made(LINE, "MadeTwice", lambda p, _: MadeTwice(p)),
    ],
    laws.results_do_not_depend_on_the_origin: [
        made(LINE, "AbsoluteCoordinates", lambda p, _: AbsoluteCoordinates(p))
    ],
    laws.results_do_not_depend_on_the_axes: [wrapped(MOVING, Stretched)],
    laws.results_do_not_depend_on_the_unit: [
        made(MOVING, "EpsilonIsNoLength", lambda p, _: MovingLeastSquares(p, inverse_square(0.1))),
        made(FARTHER, "ScaleIsNoLength", lambda p, _: RBF(p, gaussian(0.2))),
    ],
    laws.results_scale_with_the_unit_of_the_data: [wrapped(LINE, AbsoluteTolerance)],
    laws.constants_are_reproduced_at_the_ends_of_the_range_of_numbers: [
        wrapped(LINE, DataInNoUnit)
    ],
    laws.results_do_not_depend_on_the_order_of_the_sites: [wrapped(PLATE, FirstSiteTakesTheRest)],
    laws.inputs_are_not_modified: [wrapped(LINE, WritesToItsInput)],
    laws.a_method_copies_its_input: [wrapped(MOVING, KeepsTheCallersArray)],
    laws.results_do_not_depend_on_the_form_of_the_arrays: [wrapped(PLATE, SinglePrecisionData)],
    laws.integers_are_accepted: [wrapped(LINE, IntegerAnswers)],
    laws.a_pickled_copy_gives_the_same_bits: [wrapped(PARABOLA, LosesStateWhenPickled)],
    laws.nan_and_infinity_are_refused: [wrapped(LINE, NanReplacedByZero)],
    laws.wrong_shapes_are_refused: [wrapped(LINE, AnyLength)],
    laws.leave_one_out_equals_refits: [
        made(LINE, "InSamplePolynomial", lambda p, _: InSamplePolynomial(p)),
        made(MOVING, "InSampleMoving", lambda p, u: InSampleMoving(p, inverse_square(u / 10))),
        made(
            NEAREST,
            "WithoutTheNextNeighbour",
            lambda p, _: WithoutTheNextNeighbour(p, wendland(3, 2), 1, 8),
        ),
        made(PLATE, "WrongDiagonal", lambda p, _: WrongDiagonal(p, thin_plate_spline())),
        patches(InSamplePatches),
    ],
    laws.arrangements_are_solved_or_refused: [
        made(
            replace(POLYGON, arrangements=("far away",)),
            "CornersInSinglePrecision",
            lambda p, _: CornersInSinglePrecision(p),
        ),
        made(
            CIRCLE,
            "LeastNormPolynomials",
            lambda p, _: LeastNormPolynomials(p, polyharmonic(3), 3, 16),
        ),
        made(
            replace(PARABOLA, arrangements=("circle",)),
            "LeastNormParabola",
            lambda p, _: LeastNormParabola(p),
        ),
        made(
            replace(PARABOLA, arrangements=("clusters",)),
            "PolynomialsAnywhere",
            lambda p, _: PolynomialsAnywhere(p, 3),
        ),
        made(
            replace(PATCHES, arrangements=("one line",)),
            "MeetsOnlySmoothData",
            lambda p, u: MeetsOnlySmoothData(p, gaussian(0.2 * u), 1, 16),
        ),
        made_while(CUBICS, "OutliersForgotten", "outlier", _patches, "_outliers", no_outliers),
        made_while(REGION, "PatchesWithOutliers", "outlier", _patches, "APART", np.inf),
        made_while(CUBICS, "BallsAcrossGaps", "clusters", _patches, "WIDEST", np.inf),
        made_while(CUBICS, "TiesByTheOrder", "lattice", _blending, "by_position", as_they_come),
        made_while(
            GAUSSIAN, "NeighborsByTheOrder", "lattice", neighbor_search, "by_position", as_they_come
        ),
        made_while(ONE_PATCH, "PatchesThatRefuse", "outlier", _blending, "EVEN", 0.0),
        made(
            replace(WIDER, arrangements=("touching circles",)),
            "WeightsOfAnySize",
            lambda p, u: WeightsOfAnySize(p, gaussian(0.4 * u), 3),
        ),
    ],
}
