"""Radial basis functions on overlapping patches, blended: for millions of sites."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Executor
from functools import cached_property, partial
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from fieldrecon._core import validation as valid
from fieldrecon._core.chunks import Progress, chunked, progress_after, rows_of, split_progress
from fieldrecon._numerics.jets import product, rows_of_jet, symmetric, upper_pairs
from fieldrecon.fields import Field
from fieldrecon.kernels.base import Radial
from fieldrecon.kernels.conditionally_positive_definite import polyharmonic
from fieldrecon.methods.metric import as_metric, frame_of
from fieldrecon.methods.partition_of_unity.batched_systems import COLUMNS
from fieldrecon.methods.partition_of_unity.blending import (
    Moments,
    gradient_weight_rows,
    levels_of,
    moments,
    number_of_patches,
    shares,
    summed,
    weight_rows,
)
from fieldrecon.methods.partition_of_unity.leave_one_out import blended_residuals
from fieldrecon.methods.partition_of_unity.patch_systems import Problem
from fieldrecon.methods.solvability import (
    INTERPOLATED,
    as_augmentation,
    as_finite,
    as_kernel,
    as_smoothing,
    random_signs,
    refuse_duplicates,
    unit_smoothing,
)
from fieldrecon.polynomials import EPS, dimension
from fieldrecon.reconstruction import Reconstruction, Weights

Coefficients: TypeAlias = Sequence[Sequence[np.ndarray]]
"""For each level and each of its groups of systems: (p, k + q, v)."""
MAX_CROWDING = 2
"""Factor by which the patches that reach a query may exceed their mean, for the size of chunks."""


DRAWS = 8
"""Number of random data whose fields show whether a method interpolates; patches are small."""


class PartitionOfUnityRBF(Reconstruction):
    """Radial basis functions on overlapping patches, s(x) = sum_j w_j(x) s_j(x), sum_j w_j = 1.

    Each patch has the `patch_size` sites nearest to its centre, in a ball that has no other site in
    its interior, and s_j is the augmented `RBF` of these; so s interpolates, and reproduces what
    every s_j does. The weights w_j are twice continuously differentiable and vanish outside their
    balls. Where no ball reaches, in gaps and outside, patches on coarser and coarser subsets of the
    sites take over, the last of which reaches everywhere. The cost is O(n log n), and a value
    depends only on sites near the query. The order of the sites does not matter, not even to
    rounding: of equally distant sites their positions decide, unless sites coincide.

    Parameters
    ----------
    points : (n, d) array_like
        Sites, distinct unless there is smoothing.
    kernel : Radial
        Kernel of the patches; r^3 by default.
    degree : int, optional
        Degree of the polynomials, `kernel.order - 1` or more; -1 for none. By default 3 in up to
        three variables, 2 in up to five, and 1 beyond, unless the kernel needs more.
    patch_size : int, optional
        Sites of each patch; by default four times the number of polynomials, at least 12 d.
    smoothing : float or (n,) array_like
        Added to the diagonal, all of it or datum by datum, as in `RBF`: the variance of each datum
        in units of the kernel.
    metric : (d,) or (d, d) array_like, optional
        Distances other than the Euclidean one: scales of the coordinates, for which it is
        sqrt(sum_k ((x_k - y_k) / scale_k)^2), or a symmetric positive definite matrix M, for which
        it is sqrt((x - y)^T M (x - y)). Balls and lengths of the kernel are such distances. A patch
        that is a millionth as wide as it is long in these distances counts as a line; see
        `reduced`.
    executor : concurrent.futures.Executor, optional
        Runs the chunks of the set-up; this machine's threads by default.
    progress : callable, optional
        Called as progress(done, total) with numbers of sites, while the patches are set up.

    Attributes
    ----------
    patch_sizes : (p,) ndarray
        Sites of each patch; more than `patch_size` if it needs them to determine its polynomials,
        fewer if there are no more, or if a few sites are clusters far from others.
    reduced : int
        Number of patches whose sites do not determine a polynomial of the degree, not even with
        four times as many, of which none makes the patch a thousand times as wide: sites on a
        line, in a plane or on a circle, say. They use all
        polynomials of the degrees that their sites determine, and of higher degrees those that are
        determined modulo the lower ones: on a line or in a plane these are constant across it, on a
        circle harmonic.
    interpolates : bool
        False with smoothing, and where the kernel is so flat for the sites of a patch that rounding
        makes the fields of some data miss them by more than 1e-6 of their size. Then a patch fits
        what its system determines, and weights at the sites may be far from one and zero. It takes
        the time of a field when it is first asked for.
    degree : int
        The degree that is reproduced everywhere: the lowest that all patches determine. No distinct
        sites are refused for want of a polynomial; one site reproduces constants.

    Notes
    -----
    The defaults are measured (experiment `partition_of_unity`). On smooth data the error falls
    with the degree, at nearly the same cost; on rough data, where it cannot, r^3 with polynomials
    of degree 3 is as accurate as with linear ones and the plate of least energy, while r^5 and r^7
    amplify noise, and degree 4 overshoots in gaps. Larger patches cost little more, since there
    are fewer of them. In more than about six variables a site lies in dozens of patches, and the
    field of all sites at once, `RBF`, is better if it fits into memory (experiment
    `high_dimensions`).

    A polynomial counts as determined if its values at the sites, modulo lower degrees, are at least
    1e-6 of the patch's size (root mean square); beyond linear polynomials, and those that the
    kernel needs, at least 1e-4. Errors of the data are magnified by about the inverse.

    Outside the convex hull and in gaps, values are a fair extrapolation, and gradients are not.
    There the levels change within half a spacing, and the gradient has their difference divided
    by this distance. For f = sin 3(x + y) + x^2 at 600 sites in the unit square, the gradient
    (of size 6) has errors of up to 31 within 0.1 of the square, 3.2 at the 95 % quantile; that of
    `RBF` with r^3 has 1.0 and 0.7. `fieldrecon.selection.extrapolated` marks such points. Far
    outside, values grow like the degree's power of the distance, and rounding with them: cubics
    lose a constant, and are refused, from about 1e4 times the extent of the sites on.

    Leave-one-out residuals are an estimate of the error: the patches stay where they are, while
    a fit without the site would have others. They have the size of the true residuals, and on a
    site inside the cloud a correlation of about 0.7 with them.

    Raises
    ------
    ValueError
        If points coincide, or an argument has the wrong form.
    numpy.linalg.LinAlgError
        If the metric is not positive definite. Of the data: if the kernel is too flat for sites so
        close and data so rough.
    OverflowError
        Of the data: if coefficients exceed the range of floating-point numbers.

    References
    ----------
    Wendland, Fast evaluation of radial basis functions: methods based on partition of unity (2002);
    Wendland (2005), section 15.4; Cavoretto and De Rossi (2015).

    Examples
    --------
    >>> import numpy as np, fieldrecon as fr
    >>> points = fr.datasets.halton(5000, 2)
    >>> s = PartitionOfUnityRBF(points).field(fr.datasets.franke(points))
    >>> bool(abs(s([0.5, 0.5]) - fr.datasets.franke([0.5, 0.5])) < 1e-5)
    True
    """

    _each_site = ("smoothing",)

    def __init__(
        self,
        points: ArrayLike,
        kernel: Radial | None = None,
        degree: int | None = None,
        patch_size: int | None = None,
        smoothing: ArrayLike = 0.0,
        *,
        metric: ArrayLike | None = None,
        executor: Executor | None = None,
        progress: Progress | None = None,
    ) -> None:
        self.points = valid.as_points(points)
        d = self.points.shape[1]
        self.kernel = as_kernel(polyharmonic(3) if kernel is None else kernel, d)
        if degree is None:
            degree = max(usual_degree(d), self.kernel.order - 1)
        degree = as_augmentation(degree, self.kernel)
        self.patch_size = _as_patch_size(patch_size, d, degree)
        self.smoothing = as_smoothing(smoothing, len(self.points))
        self.metric = as_metric(metric, d)
        self._frame = frame_of(self.points, self.metric)
        scaled = self._frame.scaled(self.points)
        refuse_duplicates(scaled, smoothing=self.smoothing)
        unit_kernel = as_finite(self.kernel.in_units(self._frame.scale))
        problem = Problem(
            unit_kernel,
            degree,
            unit_smoothing(self.smoothing, len(self.points), self.kernel, self._frame.scale),
            EPS * float(np.abs(scaled).max()),
            self._frame,
        )
        local = self._frame.local(self.points)
        size = min(self.patch_size, len(local))
        self._levels = tuple(levels_of(local, size, problem, executor, progress))
        self.patch_sizes = np.repeat(
            [s.sites.shape[1] for s in self._levels[0].systems],
            [len(s) for s in self._levels[0].systems],
        )
        systems = [s for level in self._levels for s in level.systems]
        self.reduced = sum(s.reduced for s in systems)
        self.degree = min(s.least_degree() for s in systems)

    @cached_property
    def interpolates(self) -> bool:  # type: ignore[override]
        """Whether the field takes any data at the sites, computed when it is first asked for."""
        if np.any(self.smoothing):
            return False
        level = self._levels[0]
        signs = random_signs(len(self.points), DRAWS)[level.sites]
        return max(systems.rough_miss(signs) for systems in level.systems) <= INTERPOLATED

    def field(
        self,
        values: ArrayLike,
        *,
        executor: Executor | None = None,
        progress: Progress | None = None,
    ) -> Field:
        """Field of these data.

        Parameters
        ----------
        values : (n, ...) array_like
            One real or complex scalar, vector or array for each site.
        executor : concurrent.futures.Executor, optional
            Runs the chunks of patches; this machine's threads by default.
        progress : callable, optional
            Called as progress(done, total) with numbers of patches.

        Returns
        -------
        Field
            Callable at any points, with a gradient.
        """
        prepare = partial(self._prepare, executor=executor, progress=progress)
        return Field(self, valid.as_values(values, len(self.points)), prepare)

    def _arguments(self) -> dict[str, Any]:
        # the degree as it was asked for, not the lowest that a patch determines
        return super()._arguments() | {"degree": self._levels[0].systems[0].degree}

    def _leave_one_out(self, values: np.ndarray, progress: Progress | None) -> np.ndarray:
        return blended_residuals(self.points, self._levels[0], values, progress)

    def _prepare(
        self,
        values: np.ndarray,
        executor: Executor | None = None,
        progress: Progress | None = None,
    ) -> Coefficients:
        total = number_of_patches(self._levels)
        found, done = [], 0
        for level in self._levels:
            own, finest = [], level is self._levels[0]
            for systems in level.systems:
                own_progress = progress_after(progress, done, total)
                own.append(systems.fitted(values[level.sites], finest, executor, own_progress))
                done += len(systems)
            found.append(own)
        return found

    def _value_rows(self, x: np.ndarray, prepared: Coefficients) -> np.ndarray:
        x = self._frame.local(x)
        columns = prepared[0][0].shape[2]
        total = np.zeros((len(x), columns), dtype=prepared[0][0].dtype)
        for share, coefficients in zip(shares(self._levels, x, order=0), prepared, strict=False):
            values = np.empty((len(share.query), columns), dtype=total.dtype)
            for systems, own, pairs, member in share.systems():
                values[pairs] = systems.values(member, x[share.query[pairs]], coefficients[own])
            total += summed(share.query, share.weights[0, :, None] * values, len(x))
        return total

    def _gradient_rows(self, x: np.ndarray, prepared: Coefficients) -> np.ndarray:
        return self._frame.gradient(self._local_gradient_rows(x, prepared))

    def _local_gradient_rows(self, x: np.ndarray, prepared: Coefficients) -> np.ndarray:
        """Gradients (m, v, d) by the coordinates in the frame."""
        middle = self._value_rows(x, prepared)
        x = self._frame.local(x)
        total = np.zeros((*middle.shape, x.shape[1]), dtype=middle.dtype)
        for share, coefficients in zip(shares(self._levels, x, order=1), prepared, strict=False):
            terms = np.empty((len(share.query), *total.shape[1:]), dtype=total.dtype)
            for systems, own, pairs, member in share.systems():
                query, weight = share.query[pairs], share.weights[0, pairs, None, None]
                values = systems.values(member, x[query], coefficients[own]) - middle[query]
                slopes = systems.gradients(member, x[query], coefficients[own])
                # the weights' gradients sum to zero: only differences of the values count
                terms[pairs] = (
                    weight * slopes + values[..., None] * share.weights[1:, pairs].T[:, None, :]
                )
            total += summed(share.query, terms, len(x))
        return total

    def _hessian_rows(self, x: np.ndarray, prepared: Coefficients) -> np.ndarray:
        """The derivatives of the weights sum to zero: only differences of the patches count."""
        middle, slope = self._value_rows(x, prepared), self._local_gradient_rows(x, prepared)
        x = self._frame.local(x)
        d = x.shape[1]
        total = np.zeros((len(upper_pairs(d)), *middle.shape), dtype=middle.dtype)
        for share, coefficients in zip(shares(self._levels, x, order=2), prepared, strict=False):
            jet = np.empty((rows_of_jet(d, 2), len(share.query), middle.shape[1]), middle.dtype)
            for systems, own, pairs, member in share.systems():
                query = share.query[pairs]
                patch = member, x[query], coefficients[own]
                jet[0, pairs] = systems.values(*patch) - middle[query]
                difference = systems.gradients(*patch) - slope[query]
                jet[1 : 1 + d, pairs] = np.moveaxis(difference, 2, 0)
                jet[1 + d :, pairs] = systems.second_derivatives(*patch)
            terms = product(jet, share.weights[..., None], d)[1 + d :]
            for entry, term in zip(total, terms, strict=True):
                entry += summed(share.query, term, len(x))
        return self._frame.hessian(symmetric(total, d))

    @property
    def _has_sparse_weights(self) -> bool:
        return True

    def _weight_rows(self, x: np.ndarray) -> Weights:
        return weight_rows(self._levels, len(self.points), self._frame.local(x))

    def _gradient_weight_rows(self, x: np.ndarray) -> tuple[Weights, ...]:
        local = self._frame.local(x)
        return self._frame.partials(gradient_weight_rows(self._levels, len(self.points), local))

    def _weight_chunk_rows(self) -> int:
        return self._chunk_rows(COLUMNS)

    def _adjoint(
        self,
        x: np.ndarray,
        f: np.ndarray,
        executor: Executor | None,
        progress: Progress | None,
    ) -> np.ndarray:
        summing, solving = split_progress(progress, len(x), 2)
        total = Moments(self._levels, f.shape[1], f.dtype)
        work = partial(valid.quiet_evaluate, moments, self._levels, self._frame.local(x), f)
        rows = self._chunk_rows(f.shape[1])
        for _, part in chunked(work, self._order(x), rows, executor, summing):
            total.add(part)
        return total.of_sites(len(self.points), executor, solving)

    def _order(self, x: np.ndarray) -> np.ndarray:
        boxes = self._levels[0].patches.boxes
        box = boxes.containing(valid.quiet_evaluate(self._frame.local, x))
        return np.argsort(box, kind="stable")

    def _chunk_rows(self, columns: int) -> int:
        systems, d = self._levels[0].systems[0], self.points.shape[1]
        overlap = MAX_CROWDING * self.patch_sizes.sum() / len(self.points)
        return rows_of(8 * overlap * (systems.size * (d + 3) + columns * (d + 2)))


def usual_degree(d: int) -> int:
    """Default degree of polynomials in d variables, by measurement."""
    if d <= 3:
        return 3
    return 2 if d <= 5 else 1


def _as_patch_size(size: int | None, d: int, degree: int) -> int:
    """Number of sites of a patch, larger than the dimension of the polynomials."""
    q = dimension(d, degree)
    if size is None:
        return max(4 * q, 12 * d)
    wanted = f"an integer above {q}, the number of polynomials of degree {degree} in {d} variables"
    return valid.as_count(size, "patch_size", q + 1, wanted=wanted)
