"""Incompressible flow by frames: normal velocities carried to another mesh, and made to balance."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from scipy import sparse
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import splu

from fieldrecon._core import validation as valid
from fieldrecon.advection.characteristics import Velocity, departure_points, velocities
from fieldrecon.meshes.simplex_mesh import SimplexMesh
from fieldrecon.reconstruction import Field

BALANCE = 1e-9
"""A net flow into the domain that is less than this part of all flow counts as none."""


def carried_normal_velocities(
    velocity: Velocity | Field,
    mesh: SimplexMesh,
    t: float,
    dt: float,
    carried: Velocity | Field | None = None,
    scheme: str = "rk4",
) -> np.ndarray:
    """Normal velocities of the faces of a mesh, from a flow that carries itself for a step.

    v_a = n_a · u(y_a), y_a the place a step ago of what is at the centroid of face a now. The mesh
    need not be the one on which the flow is known.

    Parameters
    ----------
    velocity : callable or Field
        The flow that carries, as for `departure_points`.
    mesh : SimplexMesh
        The mesh of this step.
    t, dt : float
        The time of this step, and how long ago the last one was.
    carried : callable or Field, optional
        The velocities u at the last step that are carried; those of the flow by default.
    scheme : str
        As for `departure_points`.

    Returns
    -------
    (f,) ndarray
        In the direction of `mesh.face_normals`. They balance in no cell, until `divergence_free`.

    References
    ----------
    Klingner, Feldman, Chentanez and O'Brien, Fluid animation with dynamic meshes (2006).

    Examples
    --------
    >>> import numpy as np, fieldrecon as fr
    >>> mesh = fr.SimplexMesh.delaunay(fr.datasets.halton(50, 2))
    >>> v = carried_normal_velocities(lambda x, t: 0 * x + [3.0, 4.0], mesh, 0.0, 0.1)
    >>> np.allclose(v, mesh.face_normals @ [3, 4])
    True
    """
    feet = departure_points(mesh.face_centers, velocity, t, dt, scheme)
    carried = velocity if carried is None else carried
    return np.einsum("fd,fd->f", mesh.face_normals, velocities(carried, feet, t - dt))


def flow_energy(mesh: SimplexMesh) -> sparse.csr_array:
    """The matrix M of v^T M v = ∫ |u|², u the field of Raviart and Thomas of normal velocities v.

    In a cell, u = sum_a l_a v_a (x - x_a) / (d V), x_a the corner opposite to face a.

    Parameters
    ----------
    mesh : SimplexMesh

    Returns
    -------
    (f, f) csr_array
        Symmetric and positive definite; half of v^T M v is the kinetic energy at density one.

    Examples
    --------
    >>> import fieldrecon as fr
    >>> mesh = fr.SimplexMesh([[0, 0], [2, 0], [0, 2]], [[0, 1, 2]])
    >>> v = fr.normal_velocities(mesh, [[3.0, 4.0]] * 3)
    >>> round(float(v @ (flow_energy(mesh) @ v)), 12)  # 25 times the area
    50.0
    """
    d = mesh.points.shape[1]
    corners = mesh.points[mesh.cells]
    arms = mesh.cell_centers[:, None] - corners
    spread = (arms**2).sum(axis=(1, 2)) / ((d + 1) * (d + 2))
    size = mesh.cell_face_signs * mesh.face_measures[mesh.cell_faces]
    inner = np.einsum("cad,cbd->cab", arms, arms) + spread[:, None, None]
    inner *= size[:, :, None] * size[:, None, :] / (d**2 * mesh.cell_measures)[:, None, None]
    one, two = np.broadcast_arrays(mesh.cell_faces[:, :, None], mesh.cell_faces[:, None, :])
    f = len(mesh.faces)
    return sparse.csr_array((inner.ravel(), (one.ravel(), two.ravel())), shape=(f, f))


def divergence_free(mesh: SimplexMesh, v: ArrayLike) -> np.ndarray:
    """The nearest normal velocities in energy that balance in each cell; the boundary's are kept.

    min (w - v)^T M (w - v) under D w = 0, with M of `flow_energy` and D the outflow of cells. The
    multipliers of the balance are the pressures of the cells. Of a flow that balances, it changes
    nothing; where the boundary lets nothing through, it never adds energy.

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
        If more flows in through the boundary than out.

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
    outflow = _outflow(mesh)
    inside = np.flatnonzero(mesh.face_cells[:, 1] >= 0)
    kept = _one_left_out(mesh, outflow @ v, np.abs(outflow) @ np.abs(v))
    balance = outflow[kept][:, inside]
    energy = flow_energy(mesh)[inside][:, inside]
    system = sparse.block_array([[energy, balance.T], [balance, None]]).tocsc()
    right = np.concatenate([np.zeros(len(inside)), -(outflow @ v)[kept]])
    result = v.copy()
    result[inside] += splu(system).solve(right)[: len(inside)] if len(inside) else 0.0
    return result


def _outflow(mesh: SimplexMesh) -> sparse.csr_array:
    """What leaves cells (c, f): signs times sizes of faces."""
    entries = mesh.cell_face_signs * mesh.face_measures[mesh.cell_faces]
    rows = np.repeat(np.arange(len(mesh.cells)), entries.shape[1])
    where = (rows, mesh.cell_faces.ravel())
    return sparse.csr_array((entries.ravel(), where), shape=(len(mesh.cells), len(mesh.faces)))


def _one_left_out(mesh: SimplexMesh, net: np.ndarray, all_flow: np.ndarray) -> np.ndarray:
    """All cells but one of each part of the mesh, whose balance follows from that of the others."""
    one, two = mesh.face_cells[mesh.face_cells[:, 1] >= 0].T
    c = len(mesh.cells)
    parts, part = connected_components(sparse.coo_array((np.ones(len(one)), (one, two)), (c, c)))
    total, size = np.bincount(part, net, parts), np.bincount(part, all_flow, parts)
    wrong = np.flatnonzero(np.abs(total) > BALANCE * size)
    if len(wrong):
        raise ValueError(
            f"v must let in through the boundary as much as out; {total[wrong[0]]:.3g} more flows "
            "out, and no flow inside balances that"
        )
    return np.setdiff1d(np.arange(c), np.unique(part, return_index=True)[1])
