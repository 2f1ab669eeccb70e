"""The public names of the package, each from the module that defines it."""

from fieldrecon.advection.adaptation import adapted_points
from fieldrecon.advection.departure_points import Inflow, Snapshots, departure_points
from fieldrecon.advection.incompressible import (
    carried_normal_velocities,
    divergence_free,
    flow_energy,
)
from fieldrecon.advection.semi_lagrangian import State, semi_lagrangian
from fieldrecon.barycentric.coordinates import BarycentricCoordinates
from fieldrecon.barycentric.voronoi import VoronoiCell, voronoi_weights
from fieldrecon.coupling.fixed_point import FixedPoint, fixed_point
from fieldrecon.coupling.flat_structures import FlatCoupling, couple
from fieldrecon.coupling.rigid_motions import resultants, rigid_motions
from fieldrecon.coupling.transfer import Coupling
from fieldrecon.datasets import synthetic as datasets
from fieldrecon.io.clouds import read_cloud
from fieldrecon.io.meshes import read_mesh, read_mesh_and_data, read_surface, write_mesh
from fieldrecon.io.saved_fields import load, save
from fieldrecon.io.triangles import read_triangles, write_triangles
from fieldrecon.kernels.positive_definite import gaussian, inverse_multiquadric, matern, wendland
from fieldrecon.kernels.radial import inverse_square, multiquadric, polyharmonic, thin_plate_spline
from fieldrecon.meshes.duals import barycentric_dual, circumcentric_dual
from fieldrecon.meshes.simplex_mesh import SimplexMesh
from fieldrecon.methods import globe as sphere
from fieldrecon.methods.functionals import derivatives_at, laplacians_at, values_at
from fieldrecon.methods.globe import OnGlobe
from fieldrecon.methods.hermite import HermiteRBF
from fieldrecon.methods.least_squares import LeastSquares, normal_equations
from fieldrecon.methods.moving_least_squares import MovingLeastSquares
from fieldrecon.methods.natural_splines import NaturalCubicSpline
from fieldrecon.methods.partition_of_unity.method import PartitionOfUnityRBF
from fieldrecon.methods.rbf import RBF
from fieldrecon.methods.spline_bases import b_splines, cardinal_b_spline
from fieldrecon.pipelines.block_means import block_means
from fieldrecon.reconstruction import Field, Reconstruction
from fieldrecon.selection.leave_one_out import leave_one_out
from fieldrecon.solids import shapes
from fieldrecon.solids.constructive import (
    Solid,
    as_solid,
    blend,
    deformation,
    difference,
    intersection,
    moved,
    union,
)
from fieldrecon.solids.marching_cubes import ExtractedSurface, extract_surface
from fieldrecon.solids.ray_casting import first_zeros
from fieldrecon.solids.ray_tracing import View, ray_traced
from fieldrecon.surfaces.implicit_surfaces import ImplicitSurface, implicit_surface
from fieldrecon.surfaces.normal_orientation import orient_normals
from fieldrecon.surfaces.normals import PointNormals, estimate_normals
from fieldrecon.surfaces.off_surface import OffSurface, classified_points, off_surface_points
from fieldrecon.surfaces.polygon_soup import PolygonSoup
from fieldrecon.surfaces.variational_implicits import ShapeTransformation, variational_implicit
from fieldrecon.triangles.audit import MeshAudit, audit_mesh
from fieldrecon.triangles.repair import MeshRepair, repair_mesh
from fieldrecon.velocity.cell_velocities import cell_velocities, raviart_thomas
from fieldrecon.velocity.cells_to_vertices import circumcenter_weights, vertex_velocities_from_cells
from fieldrecon.velocity.gradients import (
    local_least_squares,
    local_moving_least_squares,
    local_rbf,
    vertex_gradients,
)
from fieldrecon.velocity.vertex_velocities import (
    divergence,
    normal_velocities,
    velocity_weights,
    vertex_velocities,
)
from fieldreport.experiments.coupling.plate import Plate, isotropic
from fieldreport.experiments.coupling.standard_atmosphere import Air, standard_atmosphere
from fieldreport.experiments.coupling.vortex_lattice import VortexLattice
from fieldreport.experiments.coupling.wing import ElasticWing

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
