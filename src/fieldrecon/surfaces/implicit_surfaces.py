"""Implicit surface of a cloud of points: a field that is zero at the points and positive inside."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial import cKDTree

from fieldrecon._core import validation as valid
from fieldrecon._core.chunks import Progress
from fieldrecon.fields import Field
from fieldrecon.kernels.conditionally_positive_definite import polyharmonic
from fieldrecon.methods.functionals import derivatives_at, values_at
from fieldrecon.methods.hermite import HermiteRBF
from fieldrecon.methods.partition_of_unity.method import PartitionOfUnityRBF
from fieldrecon.methods.rbf import RBF
from fieldrecon.solids.constructive import Solid
from fieldrecon.surfaces.cloud_cleaning import (
    CleanedCloud,
    as_clean_cloud,
    noise_without_curvature,
)
from fieldrecon.surfaces.off_surface import classified_points, off_surface_points

_METHODS = ("rbf", "partition", "hermite")
_MAX_GLOBAL = 700  # points of a single system
_PATCH = 40  # sites of a patch: about 13 points, each with one outside and one inside
_LARGEST_PATCH = 400
_MARGIN, _WIDER = 4.0, 0.1  # of the box around the points: in spacings, and relative to its size
_LATTICE, _NEAREST = 2.0, 1.5  # step of a lattice and its distance from the points, in spacings
_RINGS = 2  # layers of nodes of a lattice around the points
_SHIFT = 0.382  # of a cell, so that lattices of different steps share no nodes
_WALL = 9  # points along each edge of the box
_LONGEST = 0.5  # of the width of a cloud: waves that are smoothed away; longer ones are its shape
_EXACT = 0.02  # of the spacing: noise below which the points count as exact


class ImplicitSurface(Solid):
    """The body whose surface goes through points, as `implicit_surface` returns it.

    Attributes
    ----------
    points, outward : (n, 3) ndarray
        The points that were used, and outward normals.
    left_out : (k,) ndarray of int
        The given points that were not used: duplicates and outliers.
    noise, smoothing : float
        Estimated distance of the points from the surface, with the curvature between few points,
        and the length below which waves of the surface were smoothed away; zero for none.
    field : Field
        F, a field with a gradient.
    warnings : tuple of str
        Warnings about the points, in sentences.
    """

    spacing: float

    def __init__(self, cloud: CleanedCloud, field: Field, smoothing: float) -> None:
        self.points, self.outward, self.left_out = cloud.points, cloud.outward, cloud.left_out
        self.noise, self.smoothing, self.spacing = cloud.noise, smoothing, cloud.spacing
        self.field, self.warnings = field, cloud.warnings + _warnings(cloud, smoothing)
        self.near, self.box = self.points, _box_about(cloud)

    def _values(self, x: np.ndarray) -> np.ndarray:
        return self.field(x)

    def _gradients(self, x: np.ndarray) -> np.ndarray:
        return self.field.gradient(x)

    def distances(self, x: ArrayLike | None = None) -> np.ndarray:
        """Distances of points from the surface, to first order: |F| / |grad F|.

        Parameters
        ----------
        x : (..., 3) array_like, optional
            Points; by default those that were used.

        Returns
        -------
        (...) ndarray
        """
        q = self.points if x is None else valid.as_queries(x, 3)
        slope = np.linalg.norm(self.gradient(q), axis=-1)
        return np.abs(self(q)) / np.where(slope > 0, slope, 1.0)


def implicit_surface(
    points: ArrayLike,
    normals: ArrayLike | None = None,
    *,
    method: str | None = None,
    distance: float | None = None,
    smoothing: float | None = None,
    progress: Progress | None = None,
) -> ImplicitSurface:
    """Reconstruct a body from points on its surface.

    F = 0 at the points does not determine F. So points off the surface, along the normals, get the
    signed distances as values, positive inside; or the derivative along the normals is set to -1.
    F is the interpolant with the kernel r^3, which minimizes the energy. The normals of the surface
    are -grad F / |grad F|. Duplicates and outliers are ignored. A point has no normal if no plane
    fits its neighbours, as at edges.

    Parameters
    ----------
    points : (n, 3) array_like
        Points on the surface of a body, at least four different ones.
    normals : (n, 3) array_like, optional
        Outward normals; by default they are estimated and oriented.
    method : {"rbf", "partition", "hermite"}, optional
        One system for all sites, a partition of unity with many small systems, or values and normal
        derivatives without points off the surface. By default "rbf" for up to 700 points and
        "partition" for more, up to millions.
    distance : float, optional
        Largest distance of the points off the surface, as in `off_surface_points`; by default the
        spacing of the points.
    smoothing : float, optional
        Length of the waves of the surface that are halved; shorter waves vanish, and longer ones
        remain. 0 interpolates, as "hermite" always does. By default 10 sqrt(noise spacing) with the
        estimated noise, at most half the width of the cloud (its second largest principal extent),
        and 0 if the noise, without the curvature between the points, is below a fiftieth of the
        spacing.
    progress : callable, optional
        Called as progress(done, total) with numbers of patches.

    Returns
    -------
    ImplicitSurface
        F is its value at points.

    Raises
    ------
    ValueError
        If an argument has the wrong form.
    numpy.linalg.LinAlgError
        If the points do not lie on a surface: no plane fits the neighbours of any point.
    MemoryError
        If there are too many points for one system.

    References
    ----------
    Carr et al., Reconstruction and representation of 3D objects with radial basis functions (2001);
    Wendland (2005), section 1.1; Macêdo, Gois and Velho, Hermite interpolation of implicit surfaces
    with radial basis functions (2011).

    Examples
    --------
    >>> from fieldrecon.solids.shapes import Ball, sample_surface
    >>> ball = implicit_surface(sample_surface(Ball(1.0), 500, seed=1)[0])
    >>> ball([[0, 0, 0.9], [0, 0, 1.1]]).round(2), ball.normals([0, 0, 1.0]).round(2) + 0.0
    (array([ 0.1, -0.1]), array([0., 0., 1.]))
    """
    cloud = as_clean_cloud(points, normals)
    if method is None:
        method = "rbf" if len(cloud.points) <= _MAX_GLOBAL else "partition"
    if method not in _METHODS:
        raise ValueError(f"method must be one of {', '.join(_METHODS)}; got {method!r}")
    if method == "hermite":
        if smoothing:
            raise ValueError("method hermite interpolates: it takes smoothing=0")
        return ImplicitSurface(cloud, _hermite(cloud), 0.0)
    length = (
        _smoothing_of(cloud)
        if smoothing is None
        else (valid.as_length(smoothing, "smoothing", zero_allowed=True))
    )
    distance = cloud.spacing if distance is None else distance
    off = off_surface_points(cloud.points, cloud.outward, distance)
    # at an edge there is room on one side only, that of the obtuse angle
    usable = cloud.trusted[off.sites] | (cloud.beside[off.sites] & (np.abs(off.values) == distance))
    sites = np.concatenate([cloud.points, off.points[usable]])
    values = np.concatenate([np.zeros(len(cloud.points)), off.values[usable]])
    if method == "partition":
        # patches extrapolate badly; these sites determine the field farther out
        more, more_values = _far_points(cloud, _box_about(cloud))
        sites = np.concatenate([sites, more])
        values = np.concatenate([values, more_values])
    weight = _energy_weight(length, cloud.spacing)
    if method == "rbf":
        return ImplicitSurface(
            cloud, RBF(sites, polyharmonic(3), smoothing=weight).field(values), length
        )
    patch = int(np.clip(3 * np.pi * (0.6 * length / cloud.spacing) ** 2, _PATCH, _LARGEST_PATCH))
    patches = PartitionOfUnityRBF(
        sites, polyharmonic(3), degree=1, patch_size=min(patch, len(sites)), smoothing=weight
    )
    return ImplicitSurface(cloud, patches.field(values, progress=progress), length)


def _far_points(cloud: CleanedCloud, box: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Points farther from the surface, with values: coarser lattices, and the walls of the box.

    The nearest point classifies a node, if it has a normal. Nodes far inside are dropped, since the
    depth of a body is unknown if points cover only one side of it.
    """
    step, known = _LATTICE * cloud.spacing, cloud.trusted | cloud.beside
    parts, low = [_walls(cloud, box)], box[0]
    size = float((box[1] - low).max())
    for level in range(int(np.log2(max(size / (4 * step), 1))) + 1):
        unit = 2.0**level
        index = np.unique(np.round((cloud.points - low) / (unit * step)).astype(np.int64), axis=0)
        for axis in np.eye(3, dtype=np.int64):  # the rings around, without each node 125 times
            rings = np.arange(-_RINGS, _RINGS + 1)[:, None] * axis
            index = np.unique((index[:, None] + rings).reshape(-1, 3), axis=0)
        nodes = low + unit * step * (index + _SHIFT)
        nodes = nodes[((nodes > box[0]) & (nodes < box[1])).all(axis=1)]
        classified = classified_points(cloud.points, cloud.outward, nodes)
        far = np.linalg.norm(classified.points - cloud.points[classified.sites], axis=1)
        kept = (far > unit * _NEAREST * cloud.spacing) & (far < unit * _RINGS * step)
        kept &= known[classified.sites] & ((level == 0) | (classified.values < 0))
        parts.append((classified.points[kept], classified.values[kept]))
    points, values = zip(*parts, strict=True)
    return np.concatenate(points), np.concatenate(values)


def _walls(cloud: CleanedCloud, box: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Points on the walls of the box, which are outside since the body is bounded."""
    t = np.stack(np.meshgrid(*[np.linspace(0, 1, _WALL)] * 3, indexing="ij"), -1).reshape(-1, 3)
    walls = box[0] + (box[1] - box[0]) * t[((t == 0) | (t == 1)).any(axis=1)]
    return walls, -cKDTree(cloud.points - box[0]).query(walls - box[0])[0]


def _warnings(cloud: CleanedCloud, smoothing: float) -> tuple[str, ...]:
    """Warnings about noise and about missing normals."""
    warnings = []
    if smoothing and smoothing == _longest_smoothed(cloud.points):
        warnings.append(
            f"The points are too few to tell noise from curvature; waves shorter than "
            f"{smoothing:.2g}, half the width of the cloud, are smoothed away."
        )
    elif smoothing:
        warnings.append(
            f"The points are about {cloud.noise:.2g} off a smooth surface; waves of it shorter "
            f"than {smoothing:.2g} are smoothed away."
        )
    if cloud.trusted.mean() < 0.5:
        warnings.append(
            "Most points have no normal: the body is thinner than their spacing, or they do not "
            "lie on a surface; normals or more points would determine it."
        )
    return tuple(warnings)


def _box_about(cloud: CleanedCloud) -> np.ndarray:
    low, high = cloud.points.min(axis=0), cloud.points.max(axis=0)
    margin = max(_MARGIN * cloud.spacing, _WIDER * float((high - low).max()))
    return np.array([low - margin, high + margin])


def _hermite(cloud: CleanedCloud) -> Field:
    trusted = cloud.trusted
    method = HermiteRBF(
        [values_at(cloud.points), derivatives_at(cloud.points[trusted], cloud.outward[trusted])],
        polyharmonic(3),
    )
    return method.field(np.concatenate([np.zeros(len(cloud.points)), -np.ones(int(trusted.sum()))]))


def _smoothing_of(cloud: CleanedCloud) -> float:
    """Length at which the normals of the smoothed surface have a tenth of a radian of noise."""
    if cloud.noise < _EXACT * cloud.spacing:
        return 0.0
    length = 10 * float(np.sqrt(cloud.noise * cloud.spacing))
    longest = _longest_smoothed(cloud.points)
    if length >= longest:  # the points are too few to tell noise from curvature
        return longest
    exact = noise_without_curvature(cloud.points) < _EXACT * cloud.spacing
    return 0.0 if exact else length


def _longest_smoothed(points: np.ndarray) -> float:
    """Half the second largest extent of a cloud along its principal axes.

    The curvature of a body is a wave longer than this. Few points do not tell it from noise.
    """
    local = points - points.mean(axis=0)
    size = np.abs(local).max()
    axes = np.linalg.svd(np.linalg.qr(local / size, mode="r"))[2]
    return _LONGEST * float(np.sort(np.ptp(local @ axes.T, axis=0))[-2])


def _energy_weight(length: float, spacing: float) -> float:
    """Weight of the energy at which waves of a length on a plane of points are halved.

    The kernel r^3 has the Fourier transform 96 pi / k^6 in space and 18 pi / k^5 on a plane; with
    three sites on each square of the spacing, a wave keeps 1 / (1 + weight k^5 spacing^2 / 54 pi).
    """
    return 54 * np.pi * (length / (2 * np.pi)) ** 5 / spacing**2
