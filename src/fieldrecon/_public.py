"""The names at the top of the package: the methods, and what nearly every use of them needs."""

from fieldrecon.advection import departure_points, semi_lagrangian
from fieldrecon.barycentric import BarycentricCoordinates, VoronoiCell, voronoi_weights
from fieldrecon.coupling import Coupling
from fieldrecon.fields import Field
from fieldrecon.io import load, save
from fieldrecon.kernels import (
    gaussian,
    inverse_multiquadric,
    inverse_square,
    matern,
    multiquadric,
    polyharmonic,
    thin_plate_spline,
    wendland,
)
from fieldrecon.meshes import SimplexMesh
from fieldrecon.methods import (
    RBF,
    HermiteRBF,
    LeastSquares,
    MovingLeastSquares,
    NaturalCubicSpline,
    OnGlobe,
    PartitionOfUnityRBF,
)
from fieldrecon.reconstruction import Reconstruction
from fieldrecon.selection import leave_one_out
from fieldrecon.solids import blend, difference, extract_surface, intersection, union
from fieldrecon.surfaces import (
    estimate_normals,
    implicit_surface,
    off_surface_points,
    orient_normals,
)
from fieldrecon.triangles import MeshAudit, audit_mesh, repair_mesh
from fieldrecon.velocity import (
    cell_velocities,
    divergence,
    normal_velocities,
    velocity_weights,
    vertex_gradients,
    vertex_velocities,
    vertex_velocities_from_cells,
)

__all__ = [
    "RBF",
    "BarycentricCoordinates",
    "Coupling",
    "Field",
    "HermiteRBF",
    "LeastSquares",
    "MeshAudit",
    "MovingLeastSquares",
    "NaturalCubicSpline",
    "OnGlobe",
    "PartitionOfUnityRBF",
    "Reconstruction",
    "SimplexMesh",
    "VoronoiCell",
    "audit_mesh",
    "blend",
    "cell_velocities",
    "departure_points",
    "difference",
    "divergence",
    "estimate_normals",
    "extract_surface",
    "gaussian",
    "implicit_surface",
    "intersection",
    "inverse_multiquadric",
    "inverse_square",
    "leave_one_out",
    "load",
    "matern",
    "multiquadric",
    "normal_velocities",
    "off_surface_points",
    "orient_normals",
    "polyharmonic",
    "repair_mesh",
    "save",
    "semi_lagrangian",
    "thin_plate_spline",
    "union",
    "velocity_weights",
    "vertex_gradients",
    "vertex_velocities",
    "vertex_velocities_from_cells",
    "voronoi_weights",
    "wendland",
]
