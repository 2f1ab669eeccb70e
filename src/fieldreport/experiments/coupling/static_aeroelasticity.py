"""Static aeroelasticity of a wing: the steady state, and divergence."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from fieldrecon.coupling.fixed_point_iteration import FixedPoint, fixed_point
from fieldrecon.coupling.transfer import Transfer
from fieldreport.experiments.coupling.plate import Plate
from fieldreport.experiments.coupling.vortex_lattice import VortexLattice

REAL = 1e-6
"""An eigenvalue whose imaginary part is smaller than this fraction of it counts as real."""


@dataclass(frozen=True, eq=False)
class ElasticWing:
    """A plate and a vortex lattice in one plane, and the coupling between their nodes.

    With deflections w of the plate, circulations γ of the lattice, and the dynamic pressure q,

        γ = γ(θ + S C w),   K w = q C^T f(γ),

    where θ are the incidences of the wing as it was built, S takes heights to incidences, and C
    takes deflections of the plate's nodes to the corners of the lattice. Both are linear, and so

        γ = γ(θ) + q T γ.

    In each iteration, the component of γ along an eigenvector of T is multiplied by q λ. Where
    q λ = 1 for some λ there is no steady state: the wing diverges.

    Parameters
    ----------
    plate : Plate
        The structure.
    lattice : VortexLattice
        The air, at a Mach number.
    coupling : Transfer
        From the plate's nodes to the lattice's corners, both in the plane z = 0 of space, such as
        a `FlatCoupling`.

    References
    ----------
    Wendland (2005), section 1.2; Bisplinghoff, Ashley and Halfman, Aeroelasticity (1955).
    """

    plate: Plate
    lattice: VortexLattice
    coupling: Transfer

    def __post_init__(self) -> None:
        for name, nodes, points in (
            ("structure", self.coupling.structure, self.plate.mesh.points),
            ("surface", self.coupling.surface, self.lattice.points),
        ):
            if nodes.shape != (len(points), 3) or not np.array_equal(nodes[:, :2], points):
                raise ValueError(f"coupling.{name} must be the {len(points)} nodes, with z = 0")

    def heights(self, deflections: ArrayLike) -> np.ndarray:
        """Heights (m, ...) of the lattice's corners, from deflections (n, ...) of the plate."""
        return self.coupling.displacements(_upward(deflections))[:, 2]

    def deflections(self, forces: ArrayLike) -> np.ndarray:
        """Deflections (n, ...) of the plate under forces (m, ...) at the lattice's corners."""
        return self.plate.deflections(self.coupling.loads(_upward(forces))[:, 2])

    def circulations(self, deflections: ArrayLike, incidences: ArrayLike) -> np.ndarray:
        """Circulations (a, b) of the deflected wing, for the given incidences as built."""
        bent = self.lattice.incidences(self.heights(deflections))
        return self.lattice.circulations(np.asarray(incidences) + bent)

    def steady_state(
        self,
        pressure: float,
        incidences: ArrayLike,
        relaxation: float | None = None,
        **options: Any,
    ) -> FixedPoint:
        """Deflections (n,) in equilibrium with the flow, by fixed-point iteration.

        Parameters
        ----------
        pressure : float
            Dynamic pressure q.
        incidences : (a, b) array_like
            Incidences of the panels of the wing as it was built, in radians.
        relaxation : float, optional
            1 for no relaxation; by default Aitken's relaxation.
        **options
            Further options of `fixed_point`.
        """

        def turn(w: np.ndarray) -> np.ndarray:
            forces = self.lattice.forces(self.circulations(w, incidences))
            return self.deflections(pressure * forces)

        return fixed_point(turn, np.zeros(len(self.plate.mesh.points)), relaxation, **options)

    @cached_property
    def feedback(self) -> np.ndarray:
        """The matrix T (p, p): from circulations, by forces and bending, to circulations."""
        a, b = self.lattice.shape
        one_by_one = np.eye(a * b).reshape(a, b, a * b)
        bent = self.heights(self.deflections(self.lattice.forces(one_by_one)))
        returned = self.lattice.circulations(self.lattice.incidences(bent))
        return returned.reshape(a * b, a * b)

    @cached_property
    def eigenvalues(self) -> np.ndarray:
        """Eigenvalues λ (p,) of T, the largest first; those of most structures are real."""
        found = np.linalg.eigvals(self.feedback)
        return found[np.argsort(-np.abs(found), kind="stable")]

    @property
    def divergence_pressure(self) -> float:
        """The smallest dynamic pressure without a steady state, 1 / λ; infinite if there is none.

        Eigenvalues far below the largest belong to the meshes rather than to the wing.
        """
        size = np.abs(self.eigenvalues)
        real = (np.abs(self.eigenvalues.imag) <= REAL * size) & (self.eigenvalues.real > 0)
        return float(1 / size[real].max()) if real.any() else np.inf

    def contraction(self, pressure: float) -> float:
        """Convergence factor q max |λ| of the iteration without relaxation."""
        return float(pressure * np.abs(self.eigenvalues[0]))


def settled(found: FixedPoint) -> np.ndarray:
    """Return the deflections of a steady state.

    Raises
    ------
    ValueError
        If the iteration did not converge.
    """
    if not found.converged:
        raise ValueError(
            "the iteration between flow and structure must converge to a steady state; "
            f"after {len(found.residuals) - 1} steps the residual is "
            f"{found.residuals[-1] / found.residuals[0]:.1g} of the first"
        )
    return found.value


def _upward(sizes: ArrayLike) -> np.ndarray:
    """Vectors (n, 3, ...) along z."""
    z = np.asarray(sizes, dtype=float)
    vectors = np.zeros((len(z), 3, *z.shape[1:]))
    vectors[:, 2] = z
    return vectors
