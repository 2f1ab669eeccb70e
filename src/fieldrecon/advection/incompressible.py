"""Incompressible flow: advection of normal velocities, and projection to zero divergence."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from scipy import sparse
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import splu

from fieldrecon._core import validation as valid
from fieldrecon.advection.characteristics import Velocity, departure_points, velocities
from fieldrecon.fields import Field
from fieldrecon.meshes.simplex_mesh import SimplexMesh

BALANCE = 1e-9
"""Largest net flow into the domain, relative to the sum of all flows, that counts as zero."""


def carried_normal_velocities(
    mesh: SimplexMesh,
    velocity: Velocity | Field,
    t: float,
    dt: float,
    carried: Velocity | Field | None = None,
    scheme: str = "rk4",
) -> np.ndarray:
    """Advect a flow by one time step, and return its normal velocities on the faces of a mesh.

    They are v_a = n_a · u(y_a) with the departure point y_a of the centroid of face a. The flow may
    be given on another mesh.

    Parameters
    ----------
    mesh : SimplexMesh
        The mesh of this step.
    velocity : callable or Field
        The advecting flow, as for `departure_points`.
    t, dt : float
        The time of this step, and the time since the last one.
    carried : callable or Field, optional
        The advected velocities u at the last step; the advecting flow by default.
    scheme : str
        As for `departure_points`.

    Returns
    -------
    (f,) ndarray
        In the direction of `mesh.face_normals`. Their divergence is not zero; see
        `divergence_free`.

    References
    ----------
    Klingner, Feldman, Chentanez and O'Brien, Fluid animation with dynamic meshes (2006).

    Examples
    --------
    >>> import numpy as np, fieldrecon as fr
    >>> mesh = fr.SimplexMesh.delaunay(fr.datasets.halton(50, 2))
    >>> v = carried_normal_velocities(mesh, lambda x, t: 0 * x + [3.0, 4.0], 0.0, 0.1)
    >>> np.allclose(v, mesh.face_normals @ [3, 4])
    True
    """
    feet = departure_points(mesh.face_centers, velocity, t, dt, scheme)
    carried = velocity if carried is None else carried
    return np.einsum("fd,fd->f", mesh.face_normals, velocities(carried, feet, t - dt))


def flow_energy(mesh: SimplexMesh) -> sparse.csr_array:
    """The matrix M of v^T M v = ∫ |u|², with the Raviart-Thomas field u of normal velocities v.

    In a cell, u = sum_a l_a v_a (x - x_a) / (d V), with the corner x_a opposite to face a.

    Parameters
    ----------
    mesh : SimplexMesh

    Returns
    -------
    (f, f) csr_array
        Symmetric and positive definite; v^T M v / 2 is the kinetic energy at density one.

    Examples
    --------
    >>> import fieldrecon as fr
    >>> mesh = fr.SimplexMesh([[0, 0], [2, 0], [0, 2]], [[0, 1, 2]])
    >>> v = fr.normal_velocities(mesh, [[3.0, 4.0]] * 3)
    >>> round(float(v @ (flow_energy(mesh) @ v)), 12)  # 25 times the area
    50.0
    """
    unit = _extent(mesh)
    return _energy(mesh, unit) * unit ** mesh.points.shape[1]


def _energy(mesh: SimplexMesh, unit: float) -> sparse.csr_array:
    """`flow_energy` for a unit of length, so that its entries are neither huge nor tiny."""
    d = mesh.points.shape[1]
    corners = mesh.points[mesh.cells]
    arms = (mesh.cell_centers[:, None] - corners) / unit
    spread = (arms**2).sum(axis=(1, 2)) / ((d + 1) * (d + 2))
    size = mesh.cell_face_signs * (mesh.face_measures / unit ** (d - 1))[mesh.cell_faces]
    inner = np.einsum("cad,cbd->cab", arms, arms) + spread[:, None, None]
    volume = mesh.cell_measures / unit**d
    inner *= size[:, :, None] * size[:, None, :] / (d**2 * volume)[:, None, None]
    one, two = np.broadcast_arrays(mesh.cell_faces[:, :, None], mesh.cell_faces[:, None, :])
    f = len(mesh.faces)
    return sparse.csr_array((inner.ravel(), (one.ravel(), two.ravel())), shape=(f, f))


def divergence_free(mesh: SimplexMesh, v: ArrayLike) -> np.ndarray:
    """Project normal velocities to zero divergence; those of the boundary are not changed.

    The result w minimizes (w - v)^T M (w - v) subject to D w = 0, with the matrix M of
    `flow_energy` and the outflow D w of the cells. The Lagrange multipliers are the pressures of
    the cells. A flow without divergence is not changed. Without flow through the boundary the
    energy does not increase.

    Parameters
    ----------
    mesh : SimplexMesh
        The mesh.
    v : (f,) array_like
        Normal velocities, in the direction of `mesh.face_normals`.

    Returns
    -------
    (f,) ndarray

    Raises
    ------
    ValueError
        If the net flow through the boundary is not zero.

    References
    ----------
    Raviart and Thomas (1977); Brezzi and Fortin, Mixed and Hybrid Finite Element Methods (1991).

    Examples
    --------
    >>> import numpy as np, fieldrecon as fr
    >>> mesh = fr.SimplexMesh.delaunay(fr.datasets.halton(50, 2))
    >>> v = np.where(mesh.face_cells[:, 1] < 0, 0.0, 1.0)
    >>> bool(abs(fr.divergence(mesh, divergence_free(mesh, v))).max() < 1e-12)
    True
    """
    v = valid.as_values(v, len(mesh.faces), "v", "face")
    if v.ndim != 1:
        raise ValueError(f"v must be one number for each face; got the shape {v.shape}")
    unit = _extent(mesh)
    outflow = _outflow(mesh, unit)
    inside = np.flatnonzero(mesh.face_cells[:, 1] >= 0)
    kept = _independent_cells(mesh, outflow @ v, np.abs(outflow) @ np.abs(v), unit)
    result = v.copy()
    if len(inside):
        energy, balance = _energy(mesh, unit)[inside][:, inside], outflow[kept][:, inside]
        result[inside] += _least_change(energy, balance, -(outflow @ v)[kept])
    return result


def _least_change(
    energy: sparse.csr_array, balance: sparse.csr_array, wanted: np.ndarray
) -> np.ndarray:
    """The u of least energy with B u = b, by its saddle-point system, scaled symmetrically.

    Scaled, the diagonal of the energy and the largest entry of each row of B are 1, so that pivots
    depend neither on units nor on the sizes of the cells.
    """
    f = energy.shape[0]
    across = sparse.diags_array(1 / np.sqrt(energy.diagonal()))
    balance = balance @ across
    size = abs(balance).max(axis=1).toarray().ravel()
    balance = sparse.diags_array(1 / size) @ balance
    system = sparse.block_array([[across @ energy @ across, balance.T], [balance, None]]).tocsc()
    right = np.concatenate([np.zeros(f), wanted / size])
    factor = splu(system)
    solution = factor.solve(right)
    solution += factor.solve(right - system @ solution)
    return across @ solution[:f]


def _extent(mesh: SimplexMesh) -> float:
    """A power of two near the largest extent of the mesh."""
    return float(np.exp2(np.round(np.log2(np.ptp(mesh.points[mesh.cells], axis=(0, 1)).max()))))


def _outflow(mesh: SimplexMesh, unit: float) -> sparse.csr_array:
    """The outflow matrix of cells (c, f): signs times measures of faces, for a unit of length."""
    measures = mesh.face_measures / unit ** (mesh.points.shape[1] - 1)
    entries = mesh.cell_face_signs * measures[mesh.cell_faces]
    rows = np.repeat(np.arange(len(mesh.cells)), entries.shape[1])
    where = (rows, mesh.cell_faces.ravel())
    return sparse.csr_array((entries.ravel(), where), shape=(len(mesh.cells), len(mesh.faces)))


def _independent_cells(
    mesh: SimplexMesh, net: np.ndarray, all_flow: np.ndarray, unit: float
) -> np.ndarray:
    """All cells but one of each part of the mesh, whose balance follows from the others."""
    one, two = mesh.face_cells[mesh.face_cells[:, 1] >= 0].T
    c = len(mesh.cells)
    parts, part = connected_components(sparse.coo_array((np.ones(len(one)), (one, two)), (c, c)))
    total, size = np.bincount(part, net, parts), np.bincount(part, all_flow, parts)
    wrong = np.flatnonzero(np.abs(total) > BALANCE * size)
    if len(wrong):
        more = total[wrong[0]] * unit ** (mesh.points.shape[1] - 1)
        raise ValueError(
            f"v must let in through the boundary as much as out; {more:.3g} more flows "
            "out, and no flow inside balances that"
        )
    return np.setdiff1d(np.arange(c), np.unique(part, return_index=True)[1])
