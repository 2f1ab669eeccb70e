"""Gradients at the vertices of a mesh from values at its cells, such as those of a pressure."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from fieldrecon import _validation as valid
from fieldrecon._estimable import estimable_weights
from fieldrecon._rings import ValuesOfWeights, as_vertices, fit_on_rings
from fieldrecon._stars import LocalWeights, Stars, number_that_count, relative_weights
from fieldrecon.local_gradients import CellStars, LocalGradient, local_least_squares
from fieldrecon.mesh import SimplexMesh
from fieldrecon.polynomials import Frame, monomials

# A site this many times farther than the middle one is no neighbour: the circumcentres of flat
# cells on the boundary lie anywhere.
_FAR = 10.0


def vertex_gradients(
    mesh: SimplexMesh,
    values: ArrayLike,
    method: LocalGradient | None = None,
    sites: ArrayLike | None = None,
    vertices: ArrayLike | None = None,
) -> np.ndarray:
    """Gradients at vertices from values at the cells.

    About each vertex a field is fitted to the values of the cells of one, two, ... rings, as many
    as determine an affine function, and differentiated at the vertex. Affine fields come back
    exactly. In general the error falls like the size of the cells, and like its square where they
    lie symmetrically about the vertex.

    Parameters
    ----------
    mesh : SimplexMesh
        The mesh.
    values : (c, ...) array_like
        One value, or several, for each cell.
    method : optional
        `local_least_squares()`, the default, `local_moving_least_squares(weight)` or
        `local_rbf()`.
    sites : (c, d) array_like, optional
        Where the values belong; at the circumcentres by default. For cell averages give
        `mesh.cell_centers`.
    vertices : (m,) array_like of int, optional
        Where; at all points by default.

    Returns
    -------
    (m, ..., d) ndarray
        Gradient at each vertex, the derivative by each variable last.

    Raises
    ------
    ValueError
        If there is not a finite value for each cell.
    numpy.linalg.LinAlgError
        If all the cells there are do not determine an affine function; if a point belongs to no
        cell.

    References
    ----------
    Erleben, Field Reconstruction, p. 14-16.

    Examples
    --------
    >>> import fieldrecon as fr
    >>> mesh = fr.SimplexMesh.delaunay(fr.datasets.halton(50, 2))
    >>> pressure = mesh.circumcenters @ [3, 4]
    >>> vertex_gradients(mesh, pressure, fr.local_rbf(), vertices=[7]).round(9)
    array([[3., 4.]])
    """
    values = valid.as_values(values, len(mesh.cells), "values", "cell")
    vertices = as_vertices(mesh, vertices)
    d = mesh.points.shape[1]
    method = local_least_squares() if method is None else method
    if not isinstance(method, LocalGradient):
        raise ValueError(
            "method must be local_least_squares(), local_moving_least_squares(weight) or "
            f"local_rbf(); got {method!r}"
        )
    fit = _LocalGradients(mesh, method, _as_sites(mesh, sites))
    found = ValuesOfWeights(d, len(vertices), values.reshape(len(values), -1))
    fit_on_rings(mesh, None, vertices, fit, found, ("cells", "a gradient at it"))
    return found.values.reshape(len(vertices), *values.shape[1:], d)


def _as_sites(mesh: SimplexMesh, sites: ArrayLike | None) -> np.ndarray:
    if sites is None:
        return mesh.circumcenters
    p = valid.as_points(sites)
    wanted = (len(mesh.cells), mesh.points.shape[1])
    if p.shape != wanted:
        raise ValueError(f"sites must be one point for each cell, shape {wanted}; got {p.shape}")
    return p


class _LocalGradients:
    """The fits of a method to the values of the cells about vertices."""

    def __init__(self, mesh: SimplexMesh, method: LocalGradient, sites: np.ndarray) -> None:
        self.mesh, self.method, self.sites = mesh, method, sites
        self.unit = Frame.around(mesh.points).scale

    def __call__(self, stars: Stars) -> LocalWeights:
        """Weights of the cells in the gradient at each vertex."""
        offset = self.sites[stars.index] - self.mesh.points[stars.vertices][:, None]
        w = relative_weights(self.method.weight, self.unit, offset, stars.there)
        distance, typical = _distances(offset, w > 0)
        counted = number_that_count(w)
        w = np.where(distance <= _FAR * typical[:, None], w, 0.0)
        length = np.exp2(np.ceil(np.log2(np.where(np.isfinite(typical), typical, 1.0))))
        y = offset / length[:, None, None] * (w > 0)[..., None]
        affine = estimable_weights(monomials(y, 1), (w > 0).astype(float), y.shape[2] + 1)
        size = np.sqrt(np.einsum("mdk,mdk->md", affine, affine)[:, 1:].max(axis=1))
        weights = np.full(affine[:, 1:].shape, np.nan)
        ok = np.flatnonzero(np.isfinite(size))
        batch = CellStars(y[ok], w[ok], affine[ok], length[ok] / self.unit, self.unit)
        weights[ok] = self.method(batch) / length[ok, None, None]
        return LocalWeights(weights, size, counted)


def _distances(offset: np.ndarray, there: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Distances (m, k) of the sites, infinite where there is none, and their medians (m,)."""
    distance = np.where(there, np.linalg.norm(offset, axis=2), np.inf)
    middle = np.maximum(np.count_nonzero(there, axis=1) - 1, 0) // 2
    typical = np.take_along_axis(np.sort(distance, axis=1), middle[:, None], axis=1)[:, 0]
    return distance, typical
