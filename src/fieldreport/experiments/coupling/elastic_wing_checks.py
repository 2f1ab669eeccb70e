"""Components of the elastic wing, each compared with a closed form."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from fieldrecon.coupling.flat_structures import FlatCoupling
from fieldrecon.meshes.simplex_mesh import SimplexMesh
from fieldreport.experiments.coupling.plate import Plate, isotropic_rigidity
from fieldreport.experiments.coupling.static_aeroelasticity import ElasticWing
from fieldreport.experiments.coupling.vortex_lattice import VortexLattice
from fieldreport.experiments.coupling.wing_models import flat


class ClosedFormCheck(NamedTuple):
    """A quantity, its computed value, and the value of a closed form."""

    quantity: str
    computed: float
    closed_form: float


class Strips(VortexLattice):
    """Strip theory: the lift of each strip of the wing is lift slope times incidence.

    There is one panel along the chord, whose vortex lies at a quarter of the chord.
    """

    lift_slope = 2 * np.pi

    def circulations(self, incidences: ArrayLike) -> np.ndarray:
        """Circulations γ = a c θ / 2."""
        theta = np.asarray(incidences)
        chords = self.chords.reshape(self.chords.shape + (1,) * (theta.ndim - 2))
        return self.lift_slope / 2 * chords * theta


def strip(length: float, across: int, along: int) -> SimplexMesh:
    """Triangles of a rectangle of width one."""
    x, y = np.meshgrid(np.linspace(0, 1, across + 1), np.linspace(0, length, along + 1))
    n = np.arange(x.size).reshape(x.shape)
    a, b, c, d = (k.ravel() for k in (n[:-1, :-1], n[:-1, 1:], n[1:, 1:], n[1:, :-1]))
    cells = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    return SimplexMesh(np.column_stack([x.ravel(), y.ravel()]), cells)


def cantilever(across: int = 8) -> ClosedFormCheck:
    """Deflection of the end of a strip, evenly loaded: q L⁴ / (8 D), for a Poisson's ratio of 0."""
    length = 4.0
    mesh = strip(length, across, 4 * across)
    plate = Plate(mesh, isotropic_rigidity(1.0, 0.0), mesh.points[:, 1] == 0)
    areas = np.bincount(mesh.cells.ravel(), np.repeat(mesh.cell_measures / 3, 3))
    end = plate.deflections(areas)[mesh.points[:, 1] == length]
    return ClosedFormCheck(
        "deflection of an evenly loaded cantilever", float(end.mean()), length**4 / 8
    )


def straight_wing(along: int = 60) -> ClosedFormCheck:
    """Divergence of a straight even wing that only twists: (π/2)² GJ / (e a L²), e = c² / 4.

    The section's twisting stiffness is GJ = 4 D_66 c. Chords do not bend, since D_11 is large; and
    as D_22 is small, holding the root does not stiffen the wing against twisting.
    """
    length = 20.0
    mesh = strip(length, 4, along)
    plate = Plate(mesh, np.diag([1e3, 1e-2, 0.5]), mesh.points[:, 1] == 0)
    x, y = np.meshgrid([0.0, 1.0], np.linspace(0, length, along // 2 + 1), indexing="ij")
    air = Strips(np.stack([x, y], axis=-1))
    wing = ElasticWing(plate, air, FlatCoupling(flat(mesh.points), flat(air.points)))
    closed = (np.pi / 2) ** 2 * 2.0 / (2 * np.pi / 4 * length**2)
    return ClosedFormCheck("divergence of a straight even wing", wing.divergence_pressure, closed)


def elliptic_wing(aspect: float = 100.0, along: int = 40) -> ClosedFormCheck:
    """Lift slope of an elliptic wing of high aspect ratio: 2 π / (1 + 2 / A), after Prandtl."""
    angle = np.linspace(0, np.pi / 2, along + 1)
    chord = 8 / (np.pi * aspect) * np.maximum(np.cos(angle), 1e-3)
    part = np.linspace(0, 1, 9)[:, None]
    air = VortexLattice(np.stack(np.broadcast_arrays((part - 0.25) * chord, np.sin(angle)), -1))
    slope = air.lift_coefficient(air.circulations(np.ones(air.shape)))
    return ClosedFormCheck("lift slope of an elliptic wing", slope, 2 * np.pi / (1 + 2 / aspect))


def long_wing(mach: float, length: float = 1000.0) -> ClosedFormCheck:
    """Lift slope of a long wing at a Mach number: 2 π / √(1 - M²), after Prandtl and Glauert."""
    x, y = np.meshgrid(np.linspace(0, 1, 5), np.linspace(0, length, 11), indexing="ij")
    air = VortexLattice(np.stack([x, y], axis=-1), mach)
    gamma = air.circulations(np.ones(air.shape))
    slope = float(2 * gamma[:, 0].sum())  # at the root, far from the tip
    closed = 2 * np.pi / np.sqrt(1 - mach**2)
    return ClosedFormCheck("lift slope of a long wing in such a stream", slope, closed)


def checks(mach: float) -> list[ClosedFormCheck]:
    """All checks, the last at this Mach number."""
    return [cantilever(), straight_wing(), elliptic_wing(), long_wing(mach)]
