"""The interpolation problems of many patches at once, each in its own frame.

    [ A + smoothing I   P ] [lambda]   [f]
    [ P^T               0 ] [  c   ] = [0]

Sites of one patch lie within distance one of its centre. Where they do not determine a polynomial,
the least one in Bombieri's norm is taken of those that agree on them; of sites in a plane that is
the polynomial of the plane, constant across it.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy.spatial import cKDTree

from fieldrecon._chunks import chunked, rows_of
from fieldrecon._patches import Patches
from fieldrecon._weighted_fits import by_elimination
from fieldrecon.polynomials import EPS, dimension, exponents, monomial_gradients, monomials
from fieldrecon.radial import Radial

MOST_GROWTH = 4
"""So many times more sites are given to a patch that does not determine its polynomials."""
COLUMNS = 16
"""Right-hand sides that are solved for with one factored matrix, where there are many."""
_TOLERATED_MISS = 1e-2  # of the size of the data, before a field is refused


@dataclass(frozen=True)
class Problem:
    """What is interpolated with: kernel, degree of the polynomials, and smoothing of size one."""

    kernel: Radial
    degree: int
    smoothing: float


@dataclass(frozen=True)
class PatchSystems:
    """Patches with equally many sites, k of them.

    Attributes
    ----------
    points : (n, d) ndarray
        All sites.
    sites : (p, k) ndarray
        The sites of each patch.
    problem : Problem
        What is interpolated with.
    origin : (p, d) ndarray
        Mean of its sites, where its monomials have their centre.
    radius : (p,) ndarray
        Unit of length of each patch.
    reduced : dict
        For patches that do not determine their polynomials: the matrix (q, q) that makes those
        that they do determine, followed by columns of zeros.
    """

    points: np.ndarray
    sites: np.ndarray
    problem: Problem
    origin: np.ndarray
    radius: np.ndarray
    reduced: dict[int, np.ndarray]

    @classmethod
    def of(
        cls, points: np.ndarray, tree: cKDTree, patches: Patches, problem: Problem
    ) -> tuple[tuple[PatchSystems, ...], np.ndarray, np.ndarray]:
        """Systems of the patches, in which of them each patch is, and where in it.

        A patch that does not determine its polynomials, or only just, is given more sites.
        """
        groups: list[PatchSystems] = []
        group = np.zeros(len(patches), dtype=int)
        member, sites = np.zeros(len(patches), dtype=int), patches.sites
        rest = np.arange(len(patches))
        while len(rest):
            systems = cls._about(points, sites, problem)
            enough = sites.shape[1] >= min(len(points), MOST_GROWTH * patches.sites.shape[1])
            every = np.arange(len(rest))
            doubtful = systems.each(PatchSystems.doubtful, every)
            grows = np.zeros_like(doubtful) if enough else doubtful
            member[rest[~grows]], group[rest[~grows]] = np.arange((~grows).sum()), len(groups)
            kept = systems if not grows.any() else cls._about(points, sites[~grows], problem)
            if enough:
                for patch in np.flatnonzero(doubtful).tolist():
                    kept.reduce(patch)
            groups.append(kept)
            rest = rest[grows]
            more = min(2 * sites.shape[1], len(points))
            sites = tree.query(patches.centers[rest], more)[1].reshape(len(rest), more)
        return tuple(groups), group, member

    @classmethod
    def _about(cls, points: np.ndarray, sites: np.ndarray, problem: Problem) -> PatchSystems:
        places = points[sites]
        origin = places.mean(axis=1)
        radius = np.linalg.norm(places - origin[:, None, :], axis=2).max(axis=1)
        radius = np.exp2(np.ceil(np.log2(np.where(radius > 0, radius, 1.0))))
        return cls(points, sites, problem, origin, radius, {})

    def __len__(self) -> int:
        return len(self.sites)

    @property
    def degree(self) -> int:
        """Degree of the polynomials."""
        return self.problem.degree

    def each(self, work: Callable[..., np.ndarray], patches: np.ndarray) -> np.ndarray:
        """What `work` returns for each of many patches, in chunks."""
        parts = chunked(partial(work, self), patches, self.rows())
        return np.concatenate([part for _, part in parts] or [np.zeros(0, dtype=bool)])

    def rows(self, columns: int = 0) -> int:
        """Patches of one chunk."""
        return rows_of(8 * self.size * (3 * self.size + 2 * columns))

    @property
    def size(self) -> int:
        """Number of coefficients, k + q."""
        return self.sites.shape[1] + dimension(self.points.shape[1], self.degree)

    def offsets(self, patch: np.ndarray, x: np.ndarray) -> np.ndarray:
        """Places x (p, s, d) in the frames of patches (p,)."""
        return (x - self.origin[patch, None, :]) / self.radius[patch, None, None]

    def matrices(self, patch: np.ndarray) -> np.ndarray:
        """Matrices (p, k + q, k + q) of the patches."""
        y = self.offsets(patch, self.points[self.sites[patch]])
        k, q = y.shape[1], self.size - y.shape[1]
        matrix = np.zeros((len(patch), k + q, k + q))
        self._kernel(patch, y, y, out=matrix[:, :k, :k])
        matrix[:, range(k), range(k)] += self._smoothing(patch)[:, None]
        basis = monomials(y, self.degree)
        for i in np.flatnonzero([int(j) in self.reduced for j in patch]):
            transform = self.reduced[int(patch[i])]
            basis[i] = basis[i] @ transform
            matrix[i, range(k, k + q), range(k, k + q)] = ~transform.any(axis=0)
        matrix[:, :k, k:] = basis
        matrix[:, k:, :k] = basis.mT
        return matrix

    def coefficients(self, patch: np.ndarray, values: np.ndarray) -> np.ndarray:
        """Coefficients (p, k + q, v) of the patches for the data (n, v) of all sites."""
        matrix = self.matrices(patch)
        data = values[self.sites[patch]]
        k = data.shape[1]
        right = np.zeros((len(patch), self.size, data.shape[2]), dtype=data.dtype)
        right[:, :k] = data
        found = solved(matrix, right)
        self._refuse_a_miss(patch, matrix, found, right)
        return self._in_monomials(patch, found)

    def cardinal_coefficients(self, patch: np.ndarray) -> np.ndarray:
        """C (p, k + q, k): C f are the coefficients for the data f of the patch."""
        k = self.sites.shape[1]
        unit = np.zeros((len(patch), self.size, k))
        unit[:, range(k), range(k)] = 1.0
        return self._in_monomials(patch, solved(self.matrices(patch), unit))

    def values(self, patch: np.ndarray, x: np.ndarray, coefficients: np.ndarray) -> np.ndarray:
        """Values (p, v) at places x (p, d), with the coefficients of all patches."""
        return np.einsum("ps,psv->pv", self.basis(patch, x), coefficients[patch])

    def gradients(self, patch: np.ndarray, x: np.ndarray, coefficients: np.ndarray) -> np.ndarray:
        """Gradients (p, v, d) at places x (p, d)."""
        return np.einsum("psd,psv->pvd", self.basis_gradient(patch, x), coefficients[patch])

    def of_data(self, patch: np.ndarray, terms: np.ndarray) -> np.ndarray:
        """Sums t^T c of coefficients, t (p, k + q), as weights (p, k) of their data.

        The systems are symmetric: S w = t gives them more accurately than t^T S^-1, whose rows
        are large where sites are close.
        """
        order = np.argsort(patch, kind="stable")
        # tickets of at most so many right-hand sides of the same matrix
        first = np.searchsorted(patch[order], patch[order])
        column = (np.arange(len(order)) - first) % COLUMNS
        ticket = np.cumsum(column == 0) - 1
        begin = np.append(np.flatnonzero(column == 0), len(order))
        weights = np.empty((len(patch), self.sites.shape[1]))

        def solved_tickets(tickets: np.ndarray) -> np.ndarray:
            pairs = slice(begin[tickets[0]], begin[tickets[-1] + 1])
            right = np.zeros((len(tickets), self.size, COLUMNS))
            own = order[pairs]
            right[ticket[pairs] - tickets[0], :, column[pairs]] = terms[own]
            found = self._solved_for_data(patch[order[begin[tickets]]], right)
            weights[own] = found[ticket[pairs] - tickets[0], :, column[pairs]]
            return tickets

        for _ in chunked(solved_tickets, np.arange(len(begin) - 1), self.rows(COLUMNS)):
            pass
        return weights

    def adjoint(self, moments: np.ndarray) -> np.ndarray:
        """C^T m (p, k, v) of moments (p, k + q, v), without forming C."""
        result = np.empty((len(self), self.sites.shape[1], moments.shape[2]), dtype=moments.dtype)
        work = partial(self._adjoint, moments)
        for part, rows in chunked(work, np.arange(len(self)), self.rows(moments.shape[2])):
            result[part] = rows
        return result

    def _adjoint(self, moments: np.ndarray, patch: np.ndarray) -> np.ndarray:
        return self._solved_for_data(patch, moments[patch])

    def _solved_for_data(self, patch: np.ndarray, right: np.ndarray) -> np.ndarray:
        """The first k rows (p, k, v) of the solutions of the transposed systems."""
        k = self.sites.shape[1]
        for i in np.flatnonzero([int(j) in self.reduced for j in patch]):
            right[i, k:] = self.reduced[int(patch[i])].T @ right[i, k:]
        return solved(self.matrices(patch), right)[:, :k]

    def basis(self, patch: np.ndarray, x: np.ndarray) -> np.ndarray:
        """Kernels and monomials (p, k + q) of the patches (p,) at places x (p, d)."""
        at = self.offsets(patch, x[:, None, :])
        y = self.offsets(patch, self.points[self.sites[patch]])
        k = y.shape[1]
        b = np.empty((len(patch), self.size))
        self._kernel(patch, at, y, out=b[:, None, :k])
        b[:, k:] = monomials(at[:, 0], self.degree)
        return b

    def basis_gradient(self, patch: np.ndarray, x: np.ndarray) -> np.ndarray:
        """Their gradients (p, k + q, d) by x."""
        at = self.offsets(patch, x[:, None, :])
        y = at - self.offsets(patch, self.points[self.sites[patch]])
        k = y.shape[1]
        g = np.empty((len(patch), self.size, x.shape[1]))
        unit = self._unit(patch)[:, None]
        squared = np.einsum("pkd,pkd->pk", y, y) * unit**2
        g[:, :k] = (self.problem.kernel.slope_of_squared(squared) * unit**2)[..., None] * y
        g[:, k:] = monomial_gradients(at[:, 0], self.degree)
        return g / self.radius[patch, None, None]

    def least_degree(self) -> int:
        """Highest degree of which every patch reproduces all polynomials."""
        degree, some = self.degree, np.array(list(self.reduced), dtype=int)
        while degree >= 0 and len(some) and (self._ranks(some, degree) < self._full(degree)).any():
            degree -= 1
        return degree

    def _full(self, degree: int) -> int:
        return dimension(self.points.shape[1], degree)

    def _ranks(self, patch: np.ndarray, degree: int) -> np.ndarray:
        """Dimension (p,) of the polynomials that the sites of the patches tell apart."""
        sigma = np.linalg.svd(self._equilibrated(patch, degree), compute_uv=False)
        return (sigma > self._tolerance() * sigma[:, :1]).sum(axis=1)

    def doubtful(self, patch: np.ndarray) -> np.ndarray:
        """Where (p,) the sites may not determine the polynomials, or only just."""
        basis = monomials(self.offsets(patch, self.points[self.sites[patch]]), self.degree)
        if not basis.shape[2]:
            return np.zeros(len(patch), dtype=bool)
        if basis.shape[1] < basis.shape[2]:
            return np.ones(len(patch), dtype=bool)
        return ~by_elimination(basis.mT @ basis, 1)[1]

    def reduce(self, patch: int) -> None:
        """Have a patch use those polynomials only that its sites tell apart."""
        basis = self._equilibrated(np.array([patch]), self.degree)[0]
        _, sigma, vt = np.linalg.svd(basis, full_matrices=False)
        rank = int((sigma > self._tolerance() * sigma[0]).sum())
        if rank < basis.shape[1]:
            transform = np.zeros((basis.shape[1], basis.shape[1]))
            transform[:, :rank] = vt[:rank].T / sigma[:rank]
            weight = _bombieri(self.points.shape[1], self.degree)
            self.reduced[patch] = weight[:, None] * transform

    def _equilibrated(self, patch: np.ndarray, degree: int) -> np.ndarray:
        basis = monomials(self.offsets(patch, self.points[self.sites[patch]]), degree)
        return basis * _bombieri(self.points.shape[1], degree)

    def _tolerance(self) -> float:
        return 1e3 * EPS * self.size

    def _kernel(self, patch: np.ndarray, x: np.ndarray, y: np.ndarray, out: np.ndarray) -> None:
        squared = out
        squared[...] = 0.0
        for axis in range(x.shape[2]):
            difference = x[:, :, None, axis] - y[:, None, :, axis]
            squared += difference * difference
        out[...] = self.problem.kernel.of_squared(squared * self._unit(patch)[:, None, None] ** 2)

    def _smoothing(self, patch: np.ndarray) -> np.ndarray:
        return (
            self.problem.smoothing
            * (self._unit(patch) / self.radius[patch]) ** self.problem.kernel.homogeneity
        )

    def _unit(self, patch: np.ndarray) -> np.ndarray:
        """Length of the kernel's unit in each patch's."""
        homogeneous = self.problem.kernel.in_units(2.0) is self.problem.kernel
        return np.ones(len(patch)) if homogeneous else self.radius[patch]

    def _in_monomials(self, patch: np.ndarray, found: np.ndarray) -> np.ndarray:
        k = self.sites.shape[1]
        for i in np.flatnonzero([int(j) in self.reduced for j in patch]):
            found[i, k:] = self.reduced[int(patch[i])] @ found[i, k:]
        return found

    def _refuse_a_miss(
        self, patch: np.ndarray, matrix: np.ndarray, found: np.ndarray, right: np.ndarray
    ) -> None:
        missed = np.abs(matrix @ found - right).max(axis=1)
        size = np.abs(right).max(axis=1)
        relative = missed / np.where(size > 0, size, 1.0)
        if not (relative <= _TOLERATED_MISS).all():
            worst = int(np.argmax(np.where(np.isnan(relative), np.inf, relative).max(axis=1)))
            raise _too_flat(self.origin[patch[worst]])


def solved(matrix: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Solutions of the systems, refused in words where one is singular."""
    try:
        return np.linalg.solve(matrix, right)
    except np.linalg.LinAlgError:
        raise np.linalg.LinAlgError(
            "the system of a patch is singular in floating-point numbers: the kernel is too flat "
            "for sites this close; choose a smaller scale or a rougher kernel"
        ) from None


def _too_flat(where: np.ndarray) -> np.linalg.LinAlgError:
    place = ", ".join(f"{c:.6g}" for c in where)
    return np.linalg.LinAlgError(
        f"the field of the patch about ({place}) would miss its data, by rounding: the kernel is "
        "too flat for sites this close and data this rough; choose a smaller scale, a rougher "
        "kernel or some smoothing"
    )


def _bombieri(d: int, degree: int) -> np.ndarray:
    """Square roots of the multinomial coefficients: with them rotations keep the norm."""
    factorial = np.vectorize(math.factorial, otypes=[float])
    alpha = exponents(d, degree)
    if not len(alpha):
        return np.ones(0)
    return np.sqrt(factorial(alpha.sum(axis=1)) / factorial(alpha).prod(axis=1))
