"""Linear functionals as data: values, derivatives and Laplacians at points."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from fieldrecon._core import validation as valid
from fieldrecon._numerics.jets import upper_pairs
from fieldrecon.kernels.base import Radial
from fieldrecon.kernels.derivatives import radial_derivative
from fieldrecon.polynomials import (
    Frame,
    monomial_gradients,
    monomial_laplacians,
    monomials,
    power_of_two_above,
)


@dataclass(frozen=True, eq=False)
class Functionals:
    """Functionals L_i f = a_i f(p_i) + b_i . grad f(p_i) + c_i Laplacian f(p_i).

    Made by `values_at`, `derivatives_at` and `laplacians_at`.

    Parameters
    ----------
    points : (n, d) ndarray
        The points p_i.
    value : (n,) ndarray
        Factors a of the value.
    gradient : (n, d) ndarray
        Factors b of the derivatives.
    laplacian : (n,) ndarray
        Factors c of the Laplacian.
    """

    points: np.ndarray
    value: np.ndarray
    gradient: np.ndarray
    laplacian: np.ndarray

    def __len__(self) -> int:
        return len(self.points)

    def __getitem__(self, part: slice | np.ndarray) -> Functionals:
        """A part of the functionals."""
        return Functionals(
            self.points[part], self.value[part], self.gradient[part], self.laplacian[part]
        )

    @property
    def order(self) -> int:
        """Order of the highest derivative among them."""
        return 2 if self.laplacian.any() else int(self.gradient.any())

    def in_frame(self, frame: Frame) -> tuple[Functionals, np.ndarray]:
        """Functionals of g(y) = f(x) of size one, and the sizes (n,): L f = size * (L' g).

        Sizes are powers of two: scaling by them rounds nothing.
        """
        gradient, laplacian = self.gradient / frame.scale, self.laplacian / frame.scale**2
        largest = np.maximum(abs(self.value), np.maximum(abs(gradient).max(axis=1), abs(laplacian)))
        size = power_of_two_above(largest)
        local = Functionals(
            frame.local(self.points),
            self.value / size,
            gradient / size[:, None],
            laplacian / size,
        )
        return local, size

    def of_monomials(self, degree: int) -> np.ndarray:
        """Functionals of the monomials, (n, q)."""
        return (
            self.value[:, None] * monomials(self.points, degree)
            + np.einsum("nqd,nd->nq", monomial_gradients(self.points, degree), self.gradient)
            + self.laplacian[:, None] * monomial_laplacians(self.points, degree)
        )

    def of_kernel(self, others: Functionals, kernel: Radial) -> np.ndarray:
        """Matrix (n, m) of L_i M_j phi(|x - y|), these functionals L of x and the others M of y.

        With z = x - y and the radial derivatives phi_j of the kernel, the gradient of phi(|z|) is
        phi_1 z, the Hessian phi_1 I + phi_2 z z^T, the Laplacian d phi_1 + |z|^2 phi_2.
        """
        d = self.points.shape[1]
        offsets = [self.points[:, k, None] - others.points[:, k] for k in range(d)]
        s = sum(z * z for z in offsets)
        total = np.outer(self.value, others.value) * kernel.of_squared(s)
        top = self.order + others.order
        if top == 0:
            return total
        along = sum(self.gradient[:, k, None] * z for k, z in enumerate(offsets))
        against = sum(others.gradient[:, k] * z for k, z in enumerate(offsets))
        phi = [np.zeros_like(s) if j > top else radial_derivative(kernel, s, j) for j in range(5)]
        a, c = self.value[:, None], self.laplacian[:, None]
        total += (along * others.value - a * against) * phi[1]
        total -= self.gradient @ others.gradient.T * phi[1] + along * against * phi[2]
        if max(self.order, others.order) < 2:
            return total
        laplacian = d * phi[1] + s * phi[2]
        slope = (d + 2) * phi[2] + s * phi[3]
        total += (c * others.value + a * others.laplacian) * laplacian
        total += (along * others.laplacian - c * against) * slope
        bilaplacian = d * (d + 2) * phi[2] + 2 * (d + 2) * s * phi[3] + s * s * phi[4]
        return total + c * others.laplacian * bilaplacian

    def kernel_hessians(self, x: np.ndarray, kernel: Radial) -> tuple[np.ndarray, ...]:
        """Second derivatives by x of M_j phi(|x - y|), for these functionals M of y.

        Parameters
        ----------
        x : (m, d) ndarray
            Points.
        kernel : Radial
            The function phi, with two derivatives more than the functionals need.

        Returns
        -------
        tuple of d (d + 1)/2 matrices (m, n)
            In the order of `upper_pairs`. With z = x - y, psi = d phi_1 + |z|^2 phi_2 the
            Laplacian, and a, b, c the factors of the functional, they are the entries of

            (a phi_1 - phi_2 b.z + c psi_1) I + (a phi_2 - phi_3 b.z + c psi_2) z z^T
            - phi_2 (b z^T + z b^T).
        """
        d = x.shape[1]
        z = [x[:, k, None] - self.points[:, k] for k in range(d)]
        s = sum(offset * offset for offset in z)
        top = 2 + self.order
        phi = [np.zeros_like(s) if j > top else radial_derivative(kernel, s, j) for j in range(5)]
        along = sum(self.gradient[:, k] * offset for k, offset in enumerate(z))
        psi = (d + 2) * phi[2] + s * phi[3], (d + 4) * phi[3] + s * phi[4]
        of_unit = self.value * phi[1] - along * phi[2] + self.laplacian * psi[0]
        of_square = self.value * phi[2] - along * phi[3] + self.laplacian * psi[1]
        return tuple(
            (of_unit if k == m else 0.0)
            + of_square * z[k] * z[m]
            - phi[2] * (self.gradient[:, k] * z[m] + self.gradient[:, m] * z[k])
            for k, m in upper_pairs(d)
        )


def values_at(points: ArrayLike) -> Functionals:
    """Values f(p_i).

    Parameters
    ----------
    points : (n, d) array_like
        The points p_i.

    Returns
    -------
    Functionals
        One for each point.
    """
    p = valid.as_points(points)
    return Functionals(p, np.ones(len(p)), np.zeros(p.shape), np.zeros(len(p)))


def derivatives_at(points: ArrayLike, directions: ArrayLike) -> Functionals:
    """Derivatives along directions, b_i . grad f(p_i); normal components if b is a normal.

    Parameters
    ----------
    points : (n, d) array_like
        The points p_i.
    directions : (n, d) or (d,) array_like
        Vectors b, not zero; their lengths count.

    Returns
    -------
    Functionals
        One for each point.

    Raises
    ------
    ValueError
        If a direction is zero, or there is not one for each point.
    """
    p = valid.as_points(points)
    b = valid.as_queries(directions, p.shape[1], "directions")
    if b.shape not in (p.shape, p.shape[1:]):
        wanted = f"{p.shape} or {p.shape[1:]}"
        raise ValueError(f"directions must have the shape {wanted}; got {b.shape}")
    b = np.broadcast_to(b, p.shape).copy()
    if (b == 0).all(axis=1).any():
        raise ValueError(f"directions[{int(np.argmax((b == 0).all(axis=1)))}] is zero")
    return Functionals(p, np.zeros(len(p)), b, np.zeros(len(p)))


def laplacians_at(points: ArrayLike) -> Functionals:
    """Laplacians, the sum of the second derivatives of f at p_i.

    Parameters
    ----------
    points : (n, d) array_like
        The points p_i.

    Returns
    -------
    Functionals
        One for each point.
    """
    p = valid.as_points(points)
    return Functionals(p, np.zeros(len(p)), np.zeros(p.shape), np.ones(len(p)))


def together(functionals: Functionals | Sequence[Functionals]) -> Functionals:
    """All functionals of a sequence, in its order."""
    parts = [functionals] if isinstance(functionals, Functionals) else list(functionals)
    if not parts or not all(isinstance(part, Functionals) for part in parts):
        raise ValueError(
            "functionals must be those of values_at, derivatives_at and laplacians_at, or a list "
            f"of them; got {functionals!r}"
        )
    if len({part.points.shape[1] for part in parts}) > 1:
        raise ValueError("functionals must all be of functions of as many variables")
    columns = ("points", "value", "gradient", "laplacian")
    return Functionals(*(np.concatenate([getattr(p, name) for p in parts]) for name in columns))
