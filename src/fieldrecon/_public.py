"""The public names of the package, each from the module that defines it."""

from fieldrecon import datasets, shapes, sphere
from fieldrecon.adaptation import adapted_points
from fieldrecon.advection import State, semi_lagrangian
from fieldrecon.aeroelasticity import ElasticWing
from fieldrecon.atmosphere import Air, standard_atmosphere
from fieldrecon.barycentric import BarycentricCoordinates
from fieldrecon.block_averages import block_means
from fieldrecon.cell_velocity import cell_velocities, raviart_thomas
from fieldrecon.cells_to_vertices import circumcenter_weights, vertex_velocities_from_cells
from fieldrecon.characteristics import Inflow, Snapshots, departure_points
from fieldrecon.cloud_files import read_cloud
from fieldrecon.coupling import Coupling
from fieldrecon.deformations import blend, deformation, moved
from fieldrecon.dual_meshes import barycentric_dual, circumcentric_dual
from fieldrecon.field_files import load, save
from fieldrecon.fixed_points import FixedPoint, fixed_point
from fieldrecon.flat_coupling import FlatCoupling, couple
from fieldrecon.functionals import derivatives_at, laplacians_at, values_at
from fieldrecon.hermite import HermiteRBF
from fieldrecon.implicit_surfaces import ImplicitSurface, implicit_surface
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
from fieldrecon.off_surface import OffSurface, classified_points, off_surface_points
from fieldrecon.partition_of_unity import PartitionOfUnityRBF
from fieldrecon.plates import Plate, isotropic
from fieldrecon.polygon_soup import PolygonSoup
from fieldrecon.positive_definite import gaussian, inverse_multiquadric, matern, wendland
from fieldrecon.radial import inverse_square, multiquadric, polyharmonic, thin_plate_spline
from fieldrecon.ray_tracing import View, ray_traced
from fieldrecon.rays import first_zeros
from fieldrecon.rbf import RBF
from fieldrecon.reconstruction import Field, Reconstruction
from fieldrecon.rigid_bodies import resultants, rigid_motions
from fieldrecon.solids import Solid, as_solid, difference, intersection, union
from fieldrecon.sphere import OnGlobe
from fieldrecon.spline_bases import b_splines, cardinal_b_spline
from fieldrecon.splines import NaturalCubicSpline
from fieldrecon.surface_extraction import ExtractedSurface, extract_surface
from fieldrecon.triangle_files import read_triangles, write_triangles
from fieldrecon.variational import ShapeTransformation, variational_implicit
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
    "ExtractedSurface",
    "Field",
    "FixedPoint",
    "FlatCoupling",
    "HermiteRBF",
    "ImplicitSurface",
    "Inflow",
    "LeastSquares",
    "MeshAudit",
    "MeshRepair",
    "MovingLeastSquares",
    "NaturalCubicSpline",
    "OffSurface",
    "OnGlobe",
    "PartitionOfUnityRBF",
    "Plate",
    "PointNormals",
    "PolygonSoup",
    "Reconstruction",
    "ShapeTransformation",
    "SimplexMesh",
    "Snapshots",
    "Solid",
    "State",
    "View",
    "VoronoiCell",
    "VortexLattice",
    "adapted_points",
    "as_solid",
    "audit_mesh",
    "b_splines",
    "barycentric_dual",
    "blend",
    "block_means",
    "cardinal_b_spline",
    "carried_normal_velocities",
    "cell_velocities",
    "circumcenter_weights",
    "circumcentric_dual",
    "classified_points",
    "couple",
    "datasets",
    "deformation",
    "departure_points",
    "derivatives_at",
    "difference",
    "divergence",
    "divergence_free",
    "estimate_normals",
    "extract_surface",
    "first_zeros",
    "fixed_point",
    "flow_energy",
    "gaussian",
    "implicit_surface",
    "intersection",
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
    "moved",
    "multiquadric",
    "normal_equations",
    "normal_velocities",
    "off_surface_points",
    "orient_normals",
    "polyharmonic",
    "raviart_thomas",
    "ray_traced",
    "read_cloud",
    "read_mesh",
    "read_mesh_and_data",
    "read_surface",
    "read_triangles",
    "repair_mesh",
    "resultants",
    "rigid_motions",
    "save",
    "semi_lagrangian",
    "shapes",
    "sphere",
    "standard_atmosphere",
    "thin_plate_spline",
    "union",
    "values_at",
    "variational_implicit",
    "velocity_weights",
    "vertex_gradients",
    "vertex_velocities",
    "vertex_velocities_from_cells",
    "voronoi_weights",
    "wendland",
    "write_mesh",
    "write_triangles",
]
