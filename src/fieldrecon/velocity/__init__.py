"""Velocities and gradients on meshes, from data at faces and cells.

Vertex velocities and cell velocities from the normal velocities of the faces, vertex velocities
from those of the cells, and gradients of a pressure. Erleben, Field Reconstruction, p. 3-26 and
36-44.
"""

from fieldrecon.velocity.cells import CellVelocities, cell_velocities, raviart_thomas
from fieldrecon.velocity.cells_to_vertices import circumcenter_weights, vertex_velocities_from_cells
from fieldrecon.velocity.gradients import (
    local_least_squares,
    local_moving_least_squares,
    local_rbf,
    vertex_gradients,
)
from fieldrecon.velocity.vertices import (
    VertexVelocities,
    divergence,
    normal_velocities,
    point_velocities,
    point_velocity_weights,
    velocity_weights,
    vertex_velocities,
)

__all__ = [
    "CellVelocities",
    "VertexVelocities",
    "cell_velocities",
    "circumcenter_weights",
    "divergence",
    "local_least_squares",
    "local_moving_least_squares",
    "local_rbf",
    "normal_velocities",
    "point_velocities",
    "point_velocity_weights",
    "raviart_thomas",
    "velocity_weights",
    "vertex_gradients",
    "vertex_velocities",
    "vertex_velocities_from_cells",
]
