"""Structures without thickness: nodes in one plane of space, or on one line of the plane."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
from numpy.typing import ArrayLike

from fieldrecon._core import validation as valid
from fieldrecon.coupling.transfer import Coupling, Transfer, applied, as_surface
from fieldrecon.kernels.conditionally_positive_definite import thin_plate_spline
from fieldrecon.methods.partition_of_unity.method import PartitionOfUnityRBF
from fieldrecon.reconstruction import Reconstruction

Maker = Callable[[np.ndarray], Reconstruction]
"""Makes a method from points (n, d)."""

blended_plates = partial(PartitionOfUnityRBF, kernel=thin_plate_spline(), degree=1)
"""Thin plates on patches: interpolates, reproduces linear fields, and its weights are sparse."""

FLATNESS = 1e-8
"""Thickness of nodes that count as flat, as a part of their extent."""


class FlatCoupling(Transfer):
    """A method in the plane of the structural nodes; normals of the plane stay normals.

    Displacements in a plane say nothing of what is linear across it, so no method in space on such
    nodes brings rotations back, and radial basis functions with linear polynomials refuse them.
    But a rotated plane takes its normals along. With y = p + ζ n, where p is in the plane,

        (C u)(y) = s_u(p) - ζ ∇(n · s_u)(p),

    as in the plates of Kirchhoff and the beams of Euler and Bernoulli. All rigid motions come back
    if the method reproduces linear fields of the plane, and with them total force and total moment
    of all loads. A force in the plane at a height arrives as normal forces whose couple is ζ f.

    Parameters
    ----------
    structure : (n, d) array_like
        The structural nodes, in a plane (d = 3) or on a line (d = 2).
    x : (m, d) array_like
        The nodes of the surface, in the plane or off it.
    make : callable, optional
        Makes the method from the nodes' coordinates (n, d - 1) in the plane; its gradients must
        exist at the feet p. Thin plates on patches by default.

    Attributes
    ----------
    axes : (d - 1, d) ndarray
        Orthonormal axes of the plane.
    normal : (d,) ndarray
        Its normal n.
    heights : (m,) ndarray
        The heights ζ of the surface's nodes.

    Raises
    ------
    numpy.linalg.LinAlgError
        If the nodes lie on a line in space: their displacements do not tell how it twists.

    References
    ----------
    Wendland (2005), section 1.2, for structures that are two-dimensional objects.
    """

    def __init__(self, structure: ArrayLike, x: ArrayLike, make: Maker = blended_plates) -> None:
        self.structure = valid.as_points(structure, "structure")
        self.surface = as_surface(x, self.structure)
        center = self.structure.mean(axis=0)
        axes, extents = principal_axes(self.structure)
        refuse_a_line(extents)
        self.axes, self.normal = axes[:-1], axes[-1]
        self.method = make((self.structure - center) @ self.axes.T)
        self.places = (self.surface - center) @ self.axes.T
        self.heights = (self.surface - center) @ self.normal
        self._weights = self.method.weights(self.places)
        self._slopes = self.method.gradient_weights(self.places)

    def _displace(self, u: np.ndarray) -> np.ndarray:
        across = np.einsum("d,ndv->nv", self.normal, u)
        slopes = np.einsum("kmv,kd->mdv", [g @ across for g in self._slopes], self.axes)
        return applied(self._weights, u) - self.heights[:, None, None] * slopes

    def _load(self, f: np.ndarray) -> np.ndarray:
        couples = np.einsum("m,kd,mdv->kmv", self.heights, self.axes, f)
        across = sum(g.T @ c for g, c in zip(self._slopes, couples, strict=True))
        return applied(self._weights.T, f) - self.normal[:, None] * across[:, None, :]


def couple(structure: ArrayLike, x: ArrayLike, make: Maker = blended_plates) -> Transfer:
    """Coupling of structural nodes with a surface, flat where the nodes are.

    Parameters
    ----------
    structure : (n, d) array_like
        The structural nodes.
    x : (m, d) array_like
        The nodes of the surface.
    make : callable, optional
        Makes the method from points; thin plates on patches by default, whose weights are sparse.

    Returns
    -------
    Coupling or FlatCoupling
        The latter for nodes in a plane of space, or on a line of the plane.

    Raises
    ------
    numpy.linalg.LinAlgError
        If the nodes lie on a line in space: their displacements do not tell how it twists. If the
        method does not reproduce linear fields on these nodes, so that moments would be lost.

    Notes
    -----
    A structure that is not flat may have flat pieces, such as the skins of a box, that are larger
    than the neighbourhoods of a local method. That method knows no more across them than across a
    plane; it is refused, and one with larger neighbourhoods, or a global one, is needed.

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
    _, extents = principal_axes(structure)
    if structure.shape[1] > 1 and extents[-1] <= FLATNESS * extents[0]:
        coupling: Transfer = FlatCoupling(structure, x, make)
    else:
        coupling = Coupling(make(structure), x)
    refuse_lost_moments(coupling.method)
    return coupling


def principal_axes(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Orthonormal axes (d, d) along which points extend most to least, and how far, rms."""
    away = points - points.mean(axis=0)
    size = np.abs(away).max(initial=0.0) or 1.0
    sigma, axes = np.linalg.svd(np.linalg.qr(away / size, mode="r"))[1:]
    extents = np.zeros(points.shape[1])
    extents[: len(sigma)] = sigma * (size / np.sqrt(len(points)))
    return axes, extents


def refuse_lost_moments(method: Reconstruction) -> None:
    """A method that reproduces constants at most, by its nature or on these nodes."""
    if method.degree < 1:
        raise np.linalg.LinAlgError(
            f"the method reproduces polynomials of degree {method.degree} on these nodes, and the "
            "total moment would be lost: where flat pieces of the structure are larger than its "
            "neighbourhoods, give it larger ones, as by patch_size, or a global method; or make a "
            "Coupling if that is meant"
        )


def refuse_a_line(extents: np.ndarray) -> None:
    """Nodes on a line of space, or at one point of the plane."""
    if len(extents) < 2 or extents[-2] <= FLATNESS * extents[0]:
        where = "at one point" if len(extents) < 3 or extents[0] == 0 else "on a line"
        raise np.linalg.LinAlgError(
            f"the structural nodes lie {where}, and their displacements do not tell how what is "
            "off it turns: add nodes off it, at the ends of rigid arms, that move as it turns"
        )
