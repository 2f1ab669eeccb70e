"""Transfer of displacements and loads between two meshes of one surface, by H and its transpose."""

from __future__ import annotations

import math
import sys
import warnings
from abc import ABC, abstractmethod
from contextlib import suppress

import numpy as np
from numpy.typing import ArrayLike
from scipy import sparse
from scipy.sparse.linalg import splu

from fieldrecon._core import validation as valid
from fieldrecon.coupling.rigid_body_motions import as_vectors, net_force_and_moment, rigid_motions
from fieldrecon.reconstruction import Reconstruction, Weights, weights_if_they_fit

MAX_ROW_NORM = 100.0
"""Sum of the absolute weights of a node of the surface above which a coupling warns."""

THIN = 0.01
"""Thickness up to which nodes may be meant to be flat, relative to their extent."""

SIGNS = 8
"""Vectors of random signs that bound the norms of rows that are not kept."""


class Transfer(ABC):
    """A linear map of displacements of structural nodes to those of a surface, and its adjoint.

    For any map C the loads by its adjoint do the same work, (C u, f) = (u, C^T f). So the total
    force of all loads is conserved if and only if translations are reproduced, C e_k = e_k, and the
    total moment if and only if rotations are. Otherwise `defects` is the difference.

    Attributes
    ----------
    structure : (n, d) ndarray
        The structural nodes.
    surface : (m, d) ndarray
        The nodes of the surface.
    method : Reconstruction
        The method on the structural nodes.
    projections : (m, d) or (m, d - 1) ndarray
        The points at which the method is evaluated.
    """

    method: Reconstruction
    structure: np.ndarray
    surface: np.ndarray
    projections: np.ndarray

    def displacements(self, u: ArrayLike) -> np.ndarray:
        """Displacements C u of the surface.

        Parameters
        ----------
        u : (n, d, ...) array_like
            Displacements of the structural nodes, one or several.

        Returns
        -------
        (m, d, ...) ndarray
            Displacements of the nodes of the surface.
        """
        u = as_vectors(u, self.structure, "u")
        flat = self._displace(u.reshape(*u.shape[:2], math.prod(u.shape[2:])))
        return flat.reshape(len(self.surface), *u.shape[1:])

    def loads(self, f: ArrayLike) -> np.ndarray:
        """Loads C^T f on the structural nodes.

        Parameters
        ----------
        f : (m, d, ...) array_like
            Forces at the nodes of the surface (not per area), one load case or several.

        Returns
        -------
        (n, d, ...) ndarray
            Forces at the structural nodes.
        """
        f = as_vectors(f, self.surface, "f")
        flat = self._load(f.reshape(*f.shape[:2], math.prod(f.shape[2:])))
        return flat.reshape(len(self.structure), *f.shape[1:])

    def densities(
        self, f: ArrayLike, surface_mass: ArrayLike, structure_mass: ArrayLike | None = None
    ) -> np.ndarray:
        """Loads per area g = M_X^-1 C^T M_Y f of loads per area f.

        Their integrals 1^T M_X g and 1^T M_Y f agree if the total forces do. A constant density is
        reproduced if and only if C^T M_Y 1 = M_X 1; this holds for the default M_X if M_Y is
        lumped and the method acts on each component separately.

        Parameters
        ----------
        f : (m, d, ...) array_like
            Forces per area at the nodes of the surface.
        surface_mass : (m,) array_like or (m, m) array or sparse matrix
            M_Y: the area of each node, or the mass matrix of finite elements.
        structure_mass : (n,) array_like or (n, n) array or sparse matrix, optional
            M_X; by default the area of each node by the method, sum_i a_i w_j(y_i).

        Returns
        -------
        (n, d, ...) ndarray
            Forces per area at the structural nodes.

        Raises
        ------
        numpy.linalg.LinAlgError
            If some structural node has no area.
        """
        f = as_vectors(f, self.surface, "f")
        mass = as_mass(surface_mass, len(self.surface), "surface_mass")
        if structure_mass is None:
            areas = self.method.adjoint(self.projections, mass @ np.ones(len(f)))
            own = diagonal_of_areas(areas)
        else:
            own = as_mass(structure_mass, len(self.structure), "structure_mass")
        loads = self.loads(applied(mass, f))
        return splu(own.tocsc()).solve(loads.reshape(len(loads), -1)).reshape(loads.shape)

    def defects(self, f: ArrayLike, about: ArrayLike | None = None) -> np.ndarray:
        """Differences of total force and moment between the surface and the structure.

        They are sum_i (B(y_i) - (C B)_i)^T f_i with the rigid motions B; the loads on the structure
        are not computed.

        Parameters
        ----------
        f : (m, d, ...) array_like
            Forces at the nodes of the surface.
        about : (d,) array_like, optional
            The point about which moments are taken; the origin by default.

        Returns
        -------
        (r, ...) ndarray
            As `net_force_and_moment`: values on the surface minus values on the structure.
        """
        f = as_vectors(f, self.surface, "f")
        transferred = self.displacements(rigid_motions(self.structure, about))
        difference = rigid_motions(self.surface, about) - transferred
        return np.einsum("mdr,md...->r...", difference, f)

    def shares(self, f: ArrayLike, surface: ArrayLike, structure: ArrayLike) -> np.ndarray:
        """Force and moment transferred from each part of the surface to each part of the structure.

        This is local conservation: under the conditions for the whole, the sums over the parts of
        the structure are the `net_force_and_moment` of each part of the surface. The share that a
        part transfers to its own part of the structure measures how local the method is.

        Parameters
        ----------
        f : (m, d) array_like
            Forces at the nodes of the surface.
        surface : (m,) array_like of int
            The part, 0 to K - 1, in which each node of the surface lies.
        structure : (n,) array_like of int
            The part, 0 to L - 1, in which each structural node lies.

        Returns
        -------
        (K, L, r) ndarray
            Forces and moments about the origin.
        """
        f = as_vectors(f, self.surface, "f")
        here = as_parts(surface, len(self.surface), "surface")
        there = as_parts(structure, len(self.structure), "structure")
        alone = np.where(here[:, None] == np.arange(here.max(initial=-1) + 1), 1.0, 0.0)
        loads = self.loads(f[:, :, None] * alone[:, None, :])
        return np.stack(
            [
                net_force_and_moment(self.structure[there == k], loads[there == k]).T
                if (there == k).any()
                else np.zeros((alone.shape[1], rigid_motions(self.structure[:1]).shape[2]))
                for k in range(there.max() + 1)
            ],
            axis=1,
        )

    @abstractmethod
    def _displace(self, u: np.ndarray) -> np.ndarray:
        """C u of displacements (n, d, v)."""

    @abstractmethod
    def _load(self, f: np.ndarray) -> np.ndarray:
        """C^T f of loads (m, d, v)."""


class Coupling(Transfer):
    """A method on the structural nodes, evaluated on the surface for each component separately.

    The total force is conserved if and only if the rows of H sum to one, and the total moment if
    and only if also H X = Y, that is, if the method reproduces linear fields. It need not
    interpolate. The weights are stored if they are sparse or small.

    Parameters
    ----------
    method : Reconstruction
        The method on the structural nodes X.
    x : (m, d) array_like
        The nodes Y of the surface. The meshes need not match, nor cover the same region.

    Warns
    -----
    RuntimeWarning
        If the absolute weights of a node of the surface sum to more than 100: displacements and
        loads may grow by this factor, and so do their errors.

    References
    ----------
    Wendland (2005), section 1.2, where loads are interpolated, which conserves neither work nor
    force;
    Farhat, Lesoinne and Le Tallec (1998); Beckert and Wendland (2001).

    Examples
    --------
    >>> import numpy as np, fieldrecon as fr
    >>> nodes, skin = fr.datasets.halton(50, 2), fr.datasets.halton(400, 2, seed=1)
    >>> coupling = Coupling(fr.RBF(nodes, fr.thin_plate_spline()), skin)
    >>> f = np.cos(skin)
    >>> np.allclose(net_force_and_moment(nodes, coupling.loads(f)), net_force_and_moment(skin, f))
    True
    """

    def __init__(self, method: Reconstruction, x: ArrayLike) -> None:
        self.method = method
        self.structure = method.points
        self.surface = self.projections = as_surface(x, self.structure)
        self._weights = weights_if_they_fit(method, self.surface)
        # a method may refuse the random signs, and yet take smooth displacements
        with suppress(np.linalg.LinAlgError):
            warn_of_large_weights(self.row_norms(), self.structure)

    def row_norms(self) -> np.ndarray:
        """Sums of the absolute weights of each node of the surface; lower bounds if H is not kept.

        Any signs u = ±1 bound the sum of a row h from below, |h · u|; a few random ones do.

        Returns
        -------
        (m,) ndarray
            The factors by which displacements can grow in each component.
        """
        if self._weights is None:
            signs = np.random.default_rng(0).choice([-1.0, 1.0], (len(self.structure), SIGNS))
            return np.abs(self.method.field(signs)(self.surface)).max(axis=1)
        return row_sums(self._weights)

    def _displace(self, u: np.ndarray) -> np.ndarray:
        if self._weights is None:
            return self.method.field(u)(self.surface)
        return applied(self._weights, u)

    def _load(self, f: np.ndarray) -> np.ndarray:
        if self._weights is None:
            return self.method.adjoint(self.surface, f)
        return applied(self._weights.T, f)


def warn_of_large_weights(sums: np.ndarray, structure: np.ndarray | None = None) -> None:
    """Warn of a node of the surface whose absolute weights have a large sum.

    Nodes of the structure are given if they are not treated as flat.
    """
    if sums.max(initial=0.0) <= MAX_ROW_NORM:
        return
    worst = int(sums.argmax())
    warnings.warn(
        f"the absolute weights of node {worst} of the surface sum to {sums[worst]:.2g}, more than "
        f"{MAX_ROW_NORM:.0f}: displacements and loads, and their errors, may grow by this factor; "
        f"give structural nodes nearer to it{'' if structure is None else _or_flat(structure)}",
        RuntimeWarning,
        stacklevel=_frames_of_this_package(),
    )


def _or_flat(structure: np.ndarray) -> str:
    """The other remedy, for nodes that are nearly in a plane of space or on a line of the plane."""
    thickness = principal_axes(structure)[1][-1]
    if structure.shape[1] == 1 or thickness > THIN:
        return ""
    return f", or couple with flatness={2 * thickness:.1g} if the structure is meant to be flat"


def _frames_of_this_package() -> int:
    """The stack level of the user's own line, whichever function made the coupling."""
    frame, level = sys._getframe(1), 1
    while frame.f_back and frame.f_globals["__name__"].startswith("fieldrecon."):
        frame, level = frame.f_back, level + 1
    return level


def principal_axes(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Principal axes (d, d) of points as rows, and the rms of the points along each axis.

    The rms (d,) are relative to the extent of the points along the first axis, and decrease; all
    are zero for points that coincide.
    """
    away = points - points.mean(axis=0)
    sigma, axes = np.linalg.svd(np.linalg.qr(away, mode="r"))[1:]
    rms = np.zeros(points.shape[1])
    rms[: len(sigma)] = sigma / np.sqrt(len(points))
    return axes, rms / (np.ptp(away @ axes[0]) or 1.0)


def row_sums(weights: Weights) -> np.ndarray:
    """Sums (m,) of the absolute weights in each row."""
    return np.asarray(abs(weights).sum(axis=1)).ravel()


def applied(matrix: Weights, columns: np.ndarray) -> np.ndarray:
    """The product of a matrix with arrays (n, d, v)."""
    flat = columns.reshape(len(columns), math.prod(columns.shape[1:]))  # also of no rows
    return (matrix @ flat).reshape(matrix.shape[0], *columns.shape[1:])


def as_surface(x: ArrayLike, structure: np.ndarray) -> np.ndarray:
    """Validate the nodes of a surface in the space of the structural nodes."""
    surface = valid.as_points(x, "x", none_allowed=True)
    if surface.shape[1] != structure.shape[1]:
        raise ValueError(
            f"x must have as many coordinates as the structural nodes, {structure.shape[1]}; "
            f"got the shape {surface.shape}"
        )
    return surface


def as_mass(mass: ArrayLike, n: int, name: str) -> sparse.csr_array:
    """Return a mass matrix (n, n), diagonal for lumped masses (n,)."""
    if not sparse.issparse(mass):
        mass = valid.as_numbers(mass, name, complex_allowed=False)
        mass = sparse.diags_array(mass) if mass.ndim == 1 else mass
    matrix = sparse.csr_array(mass)
    if matrix.shape != (n, n):
        raise ValueError(f"{name} must be masses ({n},) or a matrix ({n}, {n}); got {matrix.shape}")
    if not np.isfinite(matrix.data).all():
        raise ValueError(f"{name} must be finite")
    return matrix


def as_parts(parts: ArrayLike, n: int, name: str) -> np.ndarray:
    """Validate the part of each of n nodes."""
    p = np.asarray(valid.unmasked(parts, name))
    if p.shape != (n,) or (n and (p.dtype.kind not in "iu" or p.min() < 0)):
        raise ValueError(f"{name} must be {n} numbers of parts, integers from 0; got {p!r:.60}")
    return p


def diagonal_of_areas(areas: np.ndarray) -> sparse.dia_array:
    """Return the areas of structural nodes as a matrix; areas that are not positive are refused."""
    least = int(np.argmin(areas))
    if not areas[least] > 0:
        raise np.linalg.LinAlgError(
            f"structural node {least} gets the area {areas[least] + 0.0:.2g} of the surface, for "
            "which no density exists: give structure_mass, or nodes that the surface covers"
        )
    return sparse.diags_array(areas)
