"""Coupling with flat structures: nodes in one plane of space, or on one line of the plane."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
from numpy.typing import ArrayLike

from fieldrecon._core import validation as valid
from fieldrecon.coupling.transfer import (
    Coupling,
    Transfer,
    applied,
    as_surface,
    principal_axes,
    row_sums,
    warn_of_large_weights,
)
from fieldrecon.kernels.conditionally_positive_definite import thin_plate_spline
from fieldrecon.methods.partition_of_unity.method import PartitionOfUnityRBF
from fieldrecon.reconstruction import Reconstruction

Maker = Callable[[np.ndarray], Reconstruction]
"""Makes a method from points (n, d)."""

blended_plates = partial(PartitionOfUnityRBF, kernel=thin_plate_spline(), degree=1)
"""Thin-plate splines on patches: they interpolate, reproduce linear fields, and are sparse."""

FLATNESS = 1e-6
"""Thickness up to which nodes count as flat, relative to their extent: the digits of a file."""


class FlatCoupling(Transfer):
    """A coupling by a method in the plane of the structural nodes, whose normals stay normal.

    Displacements in a plane do not determine a linear field across it, so no method in space
    reproduces rotations on such nodes, and radial basis functions with linear polynomials refuse
    them. But the normals of a plane rotate with it. With y = p + ζ n, where p is in the plane,

        (C u)(y) = s_u(p) - ζ ∇(n · s_u)(p),

    as for Kirchhoff plates and Euler-Bernoulli beams. If the method reproduces linear fields of the
    plane, all rigid motions are reproduced, and the total force and moment of all loads are
    conserved. A tangential force f at the height ζ is transferred with normal forces of couple ζ f.

    Parameters
    ----------
    structure : (n, d) array_like
        The structural nodes, in a plane (d = 3) or on a line (d = 2).
    x : (m, d) array_like
        The nodes of the surface, in the plane or outside it.
    make : callable, optional
        Makes the method from the coordinates (n, d - 1) of the nodes in the plane; its gradients
        must exist at the projections p. Thin-plate splines on patches by default.
    flatness : float, optional
        As for `couple`; nodes whose distances from a line are smaller lie on a line.

    Attributes
    ----------
    axes : (d - 1, d) ndarray
        Orthonormal axes of the plane.
    normal : (d,) ndarray
        Its normal n.
    heights : (m,) ndarray
        The heights ζ of the nodes of the surface.

    Raises
    ------
    numpy.linalg.LinAlgError
        If the nodes lie on a line in space: their displacements do not determine its twist.

    Warns
    -----
    RuntimeWarning
        As `Coupling`.

    References
    ----------
    Wendland (2005), section 1.2, for structures that are two-dimensional objects.
    """

    def __init__(
        self,
        structure: ArrayLike,
        x: ArrayLike,
        make: Maker = blended_plates,
        flatness: float = FLATNESS,
    ) -> None:
        self.structure = valid.as_points(structure, "structure")
        self.surface = as_surface(x, self.structure)
        center = self.structure.mean(axis=0)
        axes, thinness = principal_axes(self.structure)
        refuse_a_line(thinness, valid.as_length(flatness, "flatness", zero_allowed=True))
        self.axes, self.normal = axes[:-1], axes[-1]
        self.method = make((self.structure - center) @ self.axes.T)
        self.projections = (self.surface - center) @ self.axes.T
        self.heights = (self.surface - center) @ self.normal
        self._weights = self.method.weights(self.projections)
        self._slopes = self.method.gradient_weights(self.projections)
        warn_of_large_weights(self.row_norms())

    def row_norms(self) -> np.ndarray:
        """Sums of the absolute weights of each node of the surface, at its projection.

        Returns
        -------
        (m,) ndarray
            The factors by which displacements can grow, without the rotation of the normals.
        """
        return row_sums(self._weights)

    def _displace(self, u: np.ndarray) -> np.ndarray:
        across = np.einsum("d,ndv->nv", self.normal, u)
        slopes = np.einsum("kmv,kd->mdv", [g @ across for g in self._slopes], self.axes)
        return applied(self._weights, u) - self.heights[:, None, None] * slopes

    def _load(self, f: np.ndarray) -> np.ndarray:
        couples = np.einsum("m,kd,mdv->kmv", self.heights, self.axes, f)
        across = sum(g.T @ c for g, c in zip(self._slopes, couples, strict=True))
        return applied(self._weights.T, f) - self.normal[:, None] * across[:, None, :]


def couple(
    structure: ArrayLike,
    x: ArrayLike,
    make: Maker = blended_plates,
    *,
    flatness: float = FLATNESS,
) -> Transfer:
    """Couple structural nodes with a surface, by a `FlatCoupling` if the nodes are flat.

    Parameters
    ----------
    structure : (n, d) array_like
        The structural nodes.
    x : (m, d) array_like
        The nodes of the surface.
    make : callable, optional
        Makes the method from points; by default thin-plate splines on patches, which are sparse.
    flatness : float, optional
        Nodes count as flat if the rms of their distances from a plane is at most this share of
        their extent. The default admits coordinates that a file holds to six digits; for
        coordinates of four digits give 1e-4.

    Returns
    -------
    Coupling or FlatCoupling
        The latter for nodes in a plane of space, or on a line of the plane.

    Raises
    ------
    numpy.linalg.LinAlgError
        If the nodes lie on a line in space: their displacements do not determine its twist. If the
        method does not reproduce linear fields on these nodes, so that moments would be lost.

    Warns
    -----
    RuntimeWarning
        As `Coupling`.

    Notes
    -----
    A structure that is not flat may have flat pieces, such as the skins of a box, that are larger
    than the neighbourhoods of a local method. Such a method does not reproduce linear fields across
    the pieces, and is refused; use larger neighbourhoods, or a global method.

    Examples
    --------
    >>> import numpy as np
    >>> from fieldrecon.coupling.rigid_body_motions import net_force_and_moment
    >>> plate = np.pad(np.indices((4, 6)).reshape(2, -1).T * 1.0, ((0, 0), (0, 1)))
    >>> skin = plate + [0.2, 0.3, 0.5]
    >>> coupling = couple(plate, skin)
    >>> f = np.cos(skin)
    >>> np.allclose(net_force_and_moment(plate, coupling.loads(f)), net_force_and_moment(skin, f))
    True
    """
    structure = valid.as_points(structure, "structure")
    flatness = valid.as_length(flatness, "flatness", zero_allowed=True)
    if structure.shape[1] > 1 and principal_axes(structure)[1][-1] <= flatness:
        coupling: Coupling | FlatCoupling = FlatCoupling(structure, x, make, flatness)
    else:
        coupling = Coupling(make(structure), x)
    refuse_lost_moments(coupling.method)
    return coupling


def refuse_lost_moments(method: Reconstruction) -> None:
    """Refuse a method that does not reproduce linear fields on these nodes."""
    if method.degree < 1:
        raise np.linalg.LinAlgError(
            f"the method reproduces polynomials of degree {method.degree} on these nodes, and the "
            "total moment would be lost: where flat pieces of the structure are larger than its "
            "neighbourhoods, give it larger ones, as by patch_size, or a global method; or make a "
            "Coupling if that is meant"
        )


def refuse_a_line(thinness: np.ndarray, flatness: float) -> None:
    """Refuse nodes of one coordinate, on a line of space, or at one point of the plane."""
    if len(thinness) == 1:
        raise np.linalg.LinAlgError(
            "nodes with one coordinate do not rotate: use a Coupling, which needs no flat structure"
        )
    if thinness[-2] <= flatness:
        where = "at one point" if len(thinness) < 3 or thinness[0] == 0 else "on a line"
        raise np.linalg.LinAlgError(
            f"the structural nodes lie {where}, and their displacements do not determine its "
            "rotation about itself: add nodes off it, at the ends of rigid arms"
        )
