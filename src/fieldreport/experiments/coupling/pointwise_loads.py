"""Pointwise load transfer for the elastic wing, as alternatives to the transpose."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TypeAlias

import numpy as np
from scipy import sparse
from scipy.spatial import cKDTree

from fieldrecon.coupling.rigid_body_motions import net_force_and_moment
from fieldrecon.coupling.transfer import Transfer, applied
from fieldrecon.kernels.conditionally_positive_definite import thin_plate_spline
from fieldrecon.methods.rbf import RBF
from fieldreport.experiments.coupling.static_aeroelasticity import ElasticWing, settled

Matrix: TypeAlias = np.ndarray | sparse.sparray


class OtherLoads(Transfer):
    """The displacements of a coupling, and loads by a matrix (n, m) that is not its transpose."""

    def __init__(self, base: Transfer, matrix: Matrix) -> None:
        self.base, self.matrix = base, matrix
        self.structure, self.surface = base.structure, base.surface
        self.method, self.projections = base.method, base.projections

    def _displace(self, u: np.ndarray) -> np.ndarray:
        return self.base._displace(u)

    def _load(self, f: np.ndarray) -> np.ndarray:
        return applied(self.matrix, f)


def corner_areas(wing: ElasticWing) -> np.ndarray:
    """A quarter of the area of each of the panels at a corner of the lattice, (m,)."""
    a, b = wing.lattice.shape
    quarters = wing.lattice.spans * wing.lattice.chords / 4
    areas = np.zeros((a + 1, b + 1))
    for i, j in np.ndindex(2, 2):
        areas[i : i + a, j : j + b] += quarters
    return areas.ravel()


def nearest_node(wing: ElasticWing) -> Matrix:
    """Each corner's force to the nearest node of the plate."""
    near = cKDTree(wing.plate.mesh.points).query(wing.lattice.points)[1]
    n, m = len(wing.plate.mesh.points), len(near)
    return sparse.csr_array((np.ones(m), (near, np.arange(m))), shape=(n, m))


def interpolated_forces(wing: ElasticWing) -> Matrix:
    """Forces interpolated as they are."""
    between = RBF(wing.lattice.points, thin_plate_spline())
    return np.asarray(between.weights(wing.plate.mesh.points))


def interpolated_pressures(wing: ElasticWing) -> Matrix:
    """Forces per area interpolated, times the area of the corners nearest to each node."""
    areas = corner_areas(wing)
    return (nearest_node(wing) @ areas)[:, None] * interpolated_forces(wing) / areas


WAYS: dict[str, Callable[[ElasticWing], Matrix] | None] = {
    "transpose": None,
    "nearest node": nearest_node,
    "pressures interpolated": interpolated_pressures,
    "forces interpolated": interpolated_forces,
}


def loaded(wing: ElasticWing, way: str) -> ElasticWing:
    """The same wing with another load transfer."""
    make = WAYS[way]
    return wing if make is None else replace(wing, coupling=OtherLoads(wing.coupling, make(wing)))


def compared(
    wing: ElasticWing, pressure: float, incidences: np.ndarray
) -> list[tuple[str, float, float, float, float, float]]:
    """For each transfer: relative errors of lift, bending and work; then tip rise, lift loss.

    The errors of lift and bending compare the transferred loads with the loads on the stiff wing.
    The loads of the steady state do the work in its deflections. The rise of the tip is in m.
    """
    air = wing.lattice
    stiff = air.circulations(incidences)
    rows = []
    for way in WAYS:
        other = loaded(wing, way)
        f = _upward(air.forces(stiff))
        arrives = net_force_and_moment(wing.coupling.structure, other.coupling.loads(f))
        given = net_force_and_moment(wing.coupling.surface, f)
        w = settled(other.steady_state(pressure, incidences, maxiter=300))
        bent = other.circulations(w, incidences)
        z, g = other.heights(w), air.forces(bent)
        work = w @ other.coupling.loads(_upward(g))[:, 2] / (z @ g)
        tip = z.reshape(air.shape[0] + 1, -1)[:, -1].mean()
        kept = air.lift_coefficient(bent) / air.lift_coefficient(stiff)
        lift, bending = np.abs(arrives[[2, 3]] / given[[2, 3]] - 1)
        rows.append((way, lift, bending, abs(work - 1), float(tip), 1 - kept))
    return rows


def _upward(z: np.ndarray) -> np.ndarray:
    return z[:, None] * [0.0, 0.0, 1.0]
