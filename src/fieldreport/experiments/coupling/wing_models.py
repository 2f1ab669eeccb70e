"""Swept wings of one plan: skin, plate and vortex lattice."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fieldrecon.coupling.flat_structures import FlatCoupling
from fieldrecon.meshes.simplex_mesh import SimplexMesh
from fieldreport.experiments.coupling.plate import Plate, isotropic_rigidity
from fieldreport.experiments.coupling.static_aeroelasticity import ElasticWing
from fieldreport.experiments.coupling.vortex_lattice import VortexLattice

BENT_MOST = 0.4  # fraction of the chord at which the mean line is highest


@dataclass(frozen=True)
class Plan:
    """A tapered half wing and its structure; lengths in m, angles in degrees."""

    half_span: float
    root_chord: float
    taper: float
    sweep: float
    thickness: float
    camber: float
    incidence: tuple[float, float]
    skin: tuple[float, float]
    plate: tuple[float, float]
    young: float
    poisson: float

    def chord(self, y: np.ndarray) -> np.ndarray:
        """Chord of the section at y."""
        return self.root_chord * (1 - (1 - self.taper) * y / self.half_span)

    def at(self, part: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Points (..., 2) at fractions of the chord; the quarter-chord line is swept."""
        part, y = np.broadcast_arrays(part, y)
        quarter = np.tan(np.radians(self.sweep)) * y + self.root_chord / 4
        return np.stack([quarter + (part - 0.25) * self.chord(y), y], axis=-1)

    def along(self, y: np.ndarray, ends: tuple[float, float]) -> np.ndarray:
        """A value that varies linearly from the root to the tip."""
        return np.interp(y, [0, self.half_span], ends)


def profile(part: np.ndarray) -> np.ndarray:
    """Half thickness over full thickness of NACA four-digit profiles with closed trailing edge."""
    c = part
    return 5 * (0.2969 * np.sqrt(c) - 0.126 * c - 0.3516 * c**2 + 0.2843 * c**3 - 0.1036 * c**4)


def mean_line(part: np.ndarray) -> np.ndarray:
    """Mean line of NACA four-digit profiles, in chords, for camber one."""
    p = BENT_MOST
    front = (2 * p * part - part**2) / p**2
    rear = (1 - 2 * p + 2 * p * part - part**2) / (1 - p) ** 2
    return np.where(part < p, front, rear)


def mean_slope(part: np.ndarray) -> np.ndarray:
    """Slope of the mean line."""
    p = BENT_MOST
    return 2 * (p - part) / np.where(part < p, p, 1 - p) ** 2


def plate_mesh(plan: Plan, across: int, along: int) -> SimplexMesh:
    """Triangles in the middle plane, almost from leading to trailing edge."""
    part, y = np.linspace(*plan.plate, across + 1), np.linspace(0, plan.half_span, along + 1)
    points = plan.at(part[:, None], y)
    n = np.arange((across + 1) * (along + 1)).reshape(across + 1, along + 1)
    a, b, c, d = (k.ravel() for k in (n[:-1, :-1], n[1:, :-1], n[1:, 1:], n[:-1, 1:]))
    cells = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    return SimplexMesh(points.reshape(-1, 2), cells)


def skin_plate(plan: Plan, across: int, along: int) -> Plate:
    """The upper and lower skins at the distance of the local thickness, clamped at the root."""
    mesh = plate_mesh(plan, across, along)
    x, y = mesh.cell_centers.T
    chord = plan.chord(y)
    part = (x - plan.at(np.zeros(1), y)[..., 0]) / chord
    apart = 2 * plan.thickness * profile(part) * chord
    thick = plan.along(y, plan.skin)
    rigidity = plan.young * thick * apart**2 / (2 * (1 - plan.poisson**2))
    return Plate(mesh, isotropic_rigidity(rigidity, plan.poisson), mesh.points[:, 1] == 0)


def lattice(plan: Plan, panels: tuple[int, ...], mach: float) -> VortexLattice:
    """Uniform panels along the chord, refined along the span towards the tip."""
    across, along = panels
    part = np.linspace(0, 1, across + 1)[:, None]
    y = plan.half_span * np.sin(np.linspace(0, np.pi / 2, along + 1))
    return VortexLattice(plan.at(part, y), mach)


def elastic(
    plan: Plan, pieces: tuple[int, ...], panels: tuple[int, ...], mach: float
) -> ElasticWing:
    """The elastic wing: plate and lattice coupled by thin-plate splines on patches."""
    plate, air = skin_plate(plan, *pieces), lattice(plan, panels, mach)
    return ElasticWing(plate, air, FlatCoupling(flat(plate.mesh.points), flat(air.points)))


def built_incidences(plan: Plan, panels: tuple[int, ...], angle: float) -> np.ndarray:
    """Incidences (a, b) of the panels, from angle of attack, built-in twist and camber."""
    across, along = panels
    part = (np.arange(across) + 0.75) / across
    y = plan.half_span * np.sin(np.linspace(0, np.pi / 2, along + 1))
    twist = plan.along((y[1:] + y[:-1]) / 2, plan.incidence)
    return np.radians(angle + twist) - plan.camber * mean_slope(part)[:, None]


def skin(plan: Plan, across: int, along: int) -> np.ndarray:
    """Points (2 across + 1, along + 1, 3), from the trailing edge over the top and back to it."""
    turn = np.linspace(0, 2 * np.pi, 2 * across + 1)[:, None]
    part = (1 + np.cos(turn)) / 2
    y = np.linspace(0, plan.half_span, along + 1)
    height = plan.camber * mean_line(part) + np.sign(np.pi - turn) * plan.thickness * profile(part)
    twist = np.radians(plan.along(y, plan.incidence))
    points = plan.at(part, y)
    rise = (height - np.sin(twist) * (part - 0.25)) * plan.chord(y)
    return np.concatenate([points, rise[..., None]], axis=-1)


def flat(points: np.ndarray) -> np.ndarray:
    """Points of the plane, in space."""
    return np.pad(points, ((0, 0), (0, 1)))
