"""What is given with loads: masses, parts, and the areas that structural nodes are handed."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from scipy import sparse

from fieldrecon import _validation as valid


def as_surface(x: ArrayLike, structure: np.ndarray) -> np.ndarray:
    """Nodes of a surface, in the space of the structural nodes."""
    surface = valid.as_points(x, "x")
    if surface.shape[1] != structure.shape[1]:
        raise ValueError(
            f"x must have as many coordinates as the structural nodes, {structure.shape[1]}; "
            f"got the shape {surface.shape}"
        )
    return surface


def as_mass(mass: ArrayLike, n: int, name: str) -> sparse.csr_array:
    """A mass matrix (n, n), or the one of lumped masses (n,) on its diagonal."""
    if not sparse.issparse(mass):
        mass = np.asarray(mass, dtype=float)
        mass = sparse.diags_array(mass) if mass.ndim == 1 else mass
    matrix = sparse.csr_array(mass)
    if matrix.shape != (n, n):
        raise ValueError(f"{name} must be masses ({n},) or a matrix ({n}, {n}); got {matrix.shape}")
    if not np.isfinite(matrix.data).all():
        raise ValueError(f"{name} must be finite")
    return matrix


def as_parts(parts: ArrayLike, n: int, name: str) -> np.ndarray:
    """The number of the part in which each of n nodes lies."""
    p = np.asarray(parts)
    if p.shape != (n,) or p.dtype.kind not in "iu" or p.min() < 0:
        raise ValueError(f"{name} must be {n} numbers of parts, integers from 0; got {p!r:.60}")
    return p


def diagonal_of_areas(areas: np.ndarray) -> sparse.dia_array:
    """Areas of structural nodes, refused where a density would have none to refer to."""
    least = int(np.argmin(areas))
    if not areas[least] > 0:
        raise np.linalg.LinAlgError(
            f"structural node {least} gets the area {areas[least]:.2g} of the surface, to which no "
            "density can refer: give structure_mass, or nodes that the surface covers"
        )
    return sparse.diags_array(areas)
