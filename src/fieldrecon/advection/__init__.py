"""Semi-Lagrangian advection on scattered points.

The characteristics are traced back for one time step, and the new values are the
values of the reconstructed field at the departure points. Wendland (2005), section 1.3.
"""

from fieldrecon.advection.adaptation import adapted_points
from fieldrecon.advection.characteristics import Inflow, Snapshots, departure_points
from fieldrecon.advection.incompressible import (
    carried_normal_velocities,
    divergence_free,
    flow_energy,
)
from fieldrecon.advection.semi_lagrangian_steps import State, semi_lagrangian

__all__ = [
    "Inflow",
    "Snapshots",
    "State",
    "adapted_points",
    "carried_normal_velocities",
    "departure_points",
    "divergence_free",
    "flow_energy",
    "semi_lagrangian",
]
