"""Reconstruct a field from scattered samples.

Sites first, data second, then call: ``RBF(points, thin_plate_spline()).field(values)(x)``.
"""

from fieldrecon import datasets, sphere
from fieldrecon.adaptation import adapted_points
from fieldrecon.advection import State, semi_lagrangian
from fieldrecon.aeroelasticity import ElasticWing
from fieldrecon.atmosphere import Air, standard_atmosphere
from fieldrecon.barycentric import BarycentricCoordinates
from fieldrecon.cell_velocity import cell_velocities, raviart_thomas
from fieldrecon.cells_to_vertices import circumcenter_weights, vertex_velocities_from_cells
from fieldrecon.characteristics import Inflow, Snapshots, departure_points
from fieldrecon.coupling import Coupling
from fieldrecon.dual_meshes import barycentric_dual, circumcentric_dual
from fieldrecon.field_files import load, save
from fieldrecon.fixed_points import FixedPoint, fixed_point
from fieldrecon.flat_coupling import FlatCoupling, couple
from fieldrecon.functionals import derivatives_at, laplacians_at, values_at
from fieldrecon.hermite import HermiteRBF
from fieldrecon.incompressible import (
    carried_normal_velocities,
    divergence_free,
    flow_energy,
)
from fieldrecon.least_squares import LeastSquares, normal_equations
from fieldrecon.local_gradients import (
    local_least_squares,
    local_moving_least_squares,
    local_rbf,
)
from fieldrecon.mesh import SimplexMesh
from fieldrecon.mesh_audit import MeshAudit, audit_mesh
from fieldrecon.mesh_files import read_mesh, read_mesh_and_data, read_surface, write_mesh
from fieldrecon.mesh_gradients import vertex_gradients
from fieldrecon.mesh_repair import MeshRepair, repair_mesh
from fieldrecon.model_selection import leave_one_out
from fieldrecon.moving_least_squares import MovingLeastSquares
from fieldrecon.normal_orientation import orient_normals
from fieldrecon.normals import PointNormals, estimate_normals
from fieldrecon.partition_of_unity import PartitionOfUnityRBF
from fieldrecon.plates import Plate, isotropic
from fieldrecon.positive_definite import gaussian, inverse_multiquadric, matern, wendland
from fieldrecon.radial import inverse_square, multiquadric, polyharmonic, thin_plate_spline
from fieldrecon.rbf import RBF
from fieldrecon.reconstruction import Field, Reconstruction
from fieldrecon.rigid_motions import resultants, rigid_motions
from fieldrecon.sphere import OnGlobe
from fieldrecon.spline_bases import b_splines, cardinal_b_spline
from fieldrecon.splines import NaturalCubicSpline
from fieldrecon.triangle_files import read_triangles, write_triangles
from fieldrecon.velocity import (
    divergence,
    normal_velocities,
    velocity_weights,
    vertex_velocities,
)
from fieldrecon.voronoi import VoronoiCell, voronoi_weights
from fieldrecon.vortex_lattice import VortexLattice

__all__ = [
    "RBF",
    "Air",
    "BarycentricCoordinates",
    "Coupling",
    "ElasticWing",
    "Field",
    "FixedPoint",
    "FlatCoupling",
    "HermiteRBF",
    "Inflow",
    "LeastSquares",
    "MeshAudit",
    "MeshRepair",
    "MovingLeastSquares",
    "NaturalCubicSpline",
    "OnGlobe",
    "PartitionOfUnityRBF",
    "Plate",
    "PointNormals",
    "Reconstruction",
    "SimplexMesh",
    "Snapshots",
    "State",
    "VoronoiCell",
    "VortexLattice",
    "adapted_points",
    "audit_mesh",
    "b_splines",
    "barycentric_dual",
    "cardinal_b_spline",
    "carried_normal_velocities",
    "cell_velocities",
    "circumcenter_weights",
    "circumcentric_dual",
    "couple",
    "datasets",
    "departure_points",
    "derivatives_at",
    "divergence",
    "divergence_free",
    "estimate_normals",
    "fixed_point",
    "flow_energy",
    "gaussian",
    "inverse_multiquadric",
    "inverse_square",
    "isotropic",
    "laplacians_at",
    "leave_one_out",
    "load",
    "local_least_squares",
    "local_moving_least_squares",
    "local_rbf",
    "matern",
    "multiquadric",
    "normal_equations",
    "normal_velocities",
    "orient_normals",
    "polyharmonic",
    "raviart_thomas",
    "read_mesh",
    "read_mesh_and_data",
    "read_surface",
    "read_triangles",
    "repair_mesh",
    "resultants",
    "rigid_motions",
    "save",
    "semi_lagrangian",
    "sphere",
    "standard_atmosphere",
    "thin_plate_spline",
    "values_at",
    "velocity_weights",
    "vertex_gradients",
    "vertex_velocities",
    "vertex_velocities_from_cells",
    "voronoi_weights",
    "wendland",
    "write_mesh",
    "write_triangles",
]
