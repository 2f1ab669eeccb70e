"""Points on a surface made the boundary of a body: F = 0 there, and positive inside."""

from __future__ import annotations

from itertools import product

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial import cKDTree

from fieldrecon._core import validation as valid
from fieldrecon._core.chunks import Progress
from fieldrecon.kernels.conditionally_positive_definite import polyharmonic
from fieldrecon.methods.functionals import derivatives_at, values_at
from fieldrecon.methods.hermite import HermiteRBF
from fieldrecon.methods.partition_of_unity.method import PartitionOfUnityRBF
from fieldrecon.methods.rbf import RBF
from fieldrecon.reconstruction import Field
from fieldrecon.solids.constructive import Solid
from fieldrecon.surfaces.cloud_cleaning import Cloud, as_clean_cloud
from fieldrecon.surfaces.off_surface import classified_points, off_surface_points

__all__ = ["ImplicitSurface", "implicit_surface"]

_METHODS = ("rbf", "partition", "hermite")
_FEW = 700  # points up to which one system serves all
_PATCH = 40  # sites of a patch: about 13 points, each with one outside and one inside
_LARGEST_PATCH = 400
_MARGIN, _WIDER = 4.0, 0.1  # that the box keeps from the points: spacings, parts of its size
_LATTICE, _NEAREST = 2.0, 1.5  # spacings: of a lattice, and its least distance from the points
_RINGS = 2  # nodes of a lattice from the points outward
_SHIFT = 0.382  # of a cell: so that lattices of different steps have no node in common
_WALL = 9  # points along each edge of the box
_EXACT = 0.02  # of the spacing: noise below which the points are taken for exact


class ImplicitSurface(Solid):
    """The body whose surface goes through points; made by `implicit_surface`.

    Attributes
    ----------
    points, outward : (n, 3) ndarray
        The points that counted, and outward normals.
    left_out : (k,) ndarray of int
        Which of the given points did not: copies and outliers.
    noise, smoothing : float
        How far the points are off the surface, as estimated, and the length below which waves of
        it were smoothed away, zero for none.
    field : Field
        F, a field with a gradient.
    remarks : tuple of str
        What is to be known about the points, in sentences.
    """

    spacing: float

    def __init__(self, cloud: Cloud, field: Field, smoothing: float) -> None:
        self.points, self.outward, self.left_out = cloud.points, cloud.outward, cloud.left_out
        self.noise, self.smoothing, self.spacing = cloud.noise, smoothing, cloud.spacing
        self.field, self.remarks = field, cloud.remarks + _said(cloud, smoothing)
        self.near, self.box = self.points, _box_about(cloud)

    def _values(self, x: np.ndarray) -> np.ndarray:
        return self.field(x)

    def _gradients(self, x: np.ndarray) -> np.ndarray:
        return self.field.gradient(x)

    def distances(self, x: ArrayLike | None = None) -> np.ndarray:
        """Distances of points to the surface, to first order: |F| / |grad F|.

        Parameters
        ----------
        x : (..., 3) array_like, optional
            Points; those that counted by default.

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
    """The body whose surface goes through points of it.

    F = 0 at the points does not determine F. Points off the surface, along the normals, get the
    values of signed distances, positive inside; or the derivative along the normals is -1. Then
    F is interpolated with the kernel r^3, which has the least energy, and normals of the surface
    are -grad F / |grad F|. Copies count once, outliers not at all, and where no plane fits the
    neighbours of a point, as at edges, it has no normal.

    Parameters
    ----------
    points : (n, 3) array_like
        Points on the surface of a body, four different ones or more.
    normals : (n, 3) array_like, optional
        Outward normals; estimated and oriented if missing.
    method : {"rbf", "partition", "hermite"}, optional
        One system of all sites, a partition of unity with many small ones, or values and normal
        derivatives without points off the surface. By default "rbf" for up to 700 points and
        "partition" beyond, which takes millions.
    distance : float, optional
        Of the points off the surface, at most, as in `off_surface_points`; by default the spacing
        of the points.
    smoothing : float, optional
        Length of the waves of the surface that are halved; shorter ones vanish, longer ones stay.
        0 interpolates, as "hermite" always does. By default 10 sqrt(noise spacing), with the noise
        that the points show, and 0 if that is below a fiftieth of their spacing.
    progress : callable, optional
        Called as progress(done, total) with numbers of patches.

    Returns
    -------
    ImplicitSurface
        Called at points it gives F.

    Raises
    ------
    ValueError
        If an argument has the wrong form.
    numpy.linalg.LinAlgError
        If the points lie on no surface: nowhere does a plane fit their neighbours.
    MemoryError
        If there are too many for one system.

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
        method = "rbf" if len(cloud.points) <= _FEW else "partition"
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
    told = cloud.trusted[off.sites] | (cloud.beside[off.sites] & (np.abs(off.values) == distance))
    sites = np.concatenate([cloud.points, off.points[told]])
    values = np.concatenate([np.zeros(len(cloud.points)), off.values[told]])
    if method == "partition":
        # beyond their sites the patches say little: these hold the field farther out
        more, told_there = _far_points(cloud, _box_about(cloud))
        sites = np.concatenate([sites, more])
        values = np.concatenate([values, told_there])
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


def _far_points(cloud: Cloud, box: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Points farther from the surface, and values: lattices ever coarser, and the walls of the box.

    Nodes are told by the nearest point, if it has a normal. Far inside nothing is said: where the
    points see one side of the body only, nobody knows how deep it is.
    """
    step, known = _LATTICE * cloud.spacing, cloud.trusted | cloud.beside
    parts, low = [_walls(cloud, box)], box[0]
    size = float((box[1] - low).max())
    for level in range(int(np.log2(max(size / (4 * step), 1))) + 1):
        unit = 2.0**level
        cells = np.unique(np.round((cloud.points - low) / (unit * step)).astype(np.int64), axis=0)
        about = np.array(list(product(range(-_RINGS, _RINGS + 1), repeat=3)))
        index = np.unique((cells[:, None] + about).reshape(-1, 3), axis=0)
        nodes = low + unit * step * (index + _SHIFT)
        nodes = nodes[((nodes > box[0]) & (nodes < box[1])).all(axis=1)]
        told = classified_points(cloud.points, cloud.outward, nodes)
        far = np.linalg.norm(told.points - cloud.points[told.sites], axis=1)
        kept = (far > unit * _NEAREST * cloud.spacing) & (far < unit * _RINGS * step)
        kept &= known[told.sites] & ((level == 0) | (told.values < 0))
        parts.append((told.points[kept], told.values[kept]))
    points, values = zip(*parts, strict=True)
    return np.concatenate(points), np.concatenate(values)


def _walls(cloud: Cloud, box: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Points on the walls of the box, which are outside: the body is bounded."""
    t = np.stack(np.meshgrid(*[np.linspace(0, 1, _WALL)] * 3, indexing="ij"), -1).reshape(-1, 3)
    walls = box[0] + (box[1] - box[0]) * t[((t == 0) | (t == 1)).any(axis=1)]
    return walls, -cKDTree(cloud.points - box[0]).query(walls - box[0])[0]


def _said(cloud: Cloud, smoothing: float) -> tuple[str, ...]:
    """Sentences about noise, and about normals that mostly are none."""
    said = []
    if smoothing:
        said.append(
            f"The points are about {cloud.noise:.2g} off a smooth surface; waves of it shorter "
            f"than {smoothing:.2g} are smoothed away."
        )
    if cloud.trusted.mean() < 0.5:
        said.append(
            "Most points have no normal: the body is thinner than their distance, or these are no "
            "points of a surface; with normals, or with more points, it can be told."
        )
    return tuple(said)


def _box_about(cloud: Cloud) -> np.ndarray:
    low, high = cloud.points.min(axis=0), cloud.points.max(axis=0)
    margin = max(_MARGIN * cloud.spacing, _WIDER * float((high - low).max()))
    return np.array([low - margin, high + margin])


def _hermite(cloud: Cloud) -> Field:
    some = cloud.trusted
    method = HermiteRBF(
        [values_at(cloud.points), derivatives_at(cloud.points[some], cloud.outward[some])],
        polyharmonic(3),
    )
    return method.field(np.concatenate([np.zeros(len(cloud.points)), -np.ones(int(some.sum()))]))


def _smoothing_of(cloud: Cloud) -> float:
    """A length that leaves the normals of the smoothed surface a tenth of a radian of noise."""
    exact = cloud.noise < _EXACT * cloud.spacing
    return 0.0 if exact else 10 * float(np.sqrt(cloud.noise * cloud.spacing))


def _energy_weight(length: float, spacing: float) -> float:
    """Weight of the energy that halves waves of a length on a plane of points.

    The kernel r^3 has the Fourier transform 96 pi / k^6 in space and 18 pi / k^5 on a plane; with
    three sites on each square of the spacing, a wave keeps 1 / (1 + weight k^5 spacing^2 / 54 pi).
    """
    return 54 * np.pi * (length / (2 * np.pi)) ** 5 / spacing**2
