"""Names of version 0.1 at the top of the package, which warn throughout 0.2."""

from __future__ import annotations

import warnings
from importlib import import_module
from typing import Any

_WING = "fieldreport.experiments.coupling"

MOVED = {
    "Air": f"{_WING}.standard_atmosphere.Air",
    "ElasticWing": f"{_WING}.static_aeroelasticity.ElasticWing",
    "ExtractedSurface": "fieldrecon.solids.ExtractedSurface",
    "FixedPoint": "fieldrecon.coupling.FixedPoint",
    "FlatCoupling": "fieldrecon.coupling.FlatCoupling",
    "ImplicitSurface": "fieldrecon.surfaces.ImplicitSurface",
    "Inflow": "fieldrecon.advection.Inflow",
    "MeshRepair": "fieldrecon.triangles.MeshRepair",
    "OffSurface": "fieldrecon.surfaces.OffSurface",
    "Plate": f"{_WING}.plate.Plate",
    "PointNormals": "fieldrecon.surfaces.PointNormals",
    "PolygonSoup": "fieldrecon.surfaces.PolygonSoup",
    "ShapeTransformation": "fieldrecon.surfaces.ShapeTransformation",
    "Snapshots": "fieldrecon.advection.Snapshots",
    "Solid": "fieldrecon.solids.Solid",
    "State": "fieldrecon.advection.State",
    "View": "fieldrecon.solids.View",
    "VortexLattice": f"{_WING}.vortex_lattice.VortexLattice",
    "adapted_points": "fieldrecon.advection.adapted_points",
    "as_solid": "fieldrecon.solids.as_solid",
    "b_splines": "fieldrecon.methods.b_splines",
    "barycentric_dual": "fieldrecon.meshes.barycentric_dual",
    "block_means": "fieldrecon.pipelines.block_means",
    "cardinal_b_spline": "fieldrecon.methods.cardinal_b_spline",
    "carried_normal_velocities": "fieldrecon.advection.carried_normal_velocities",
    "circumcenter_weights": "fieldrecon.velocity.circumcenter_weights",
    "circumcentric_dual": "fieldrecon.meshes.circumcentric_dual",
    "classified_points": "fieldrecon.surfaces.classified_points",
    "couple": "fieldrecon.coupling.couple",
    "deformation": "fieldrecon.solids.morph",
    "derivatives_at": "fieldrecon.methods.derivatives_at",
    "divergence_free": "fieldrecon.advection.divergence_free",
    "first_zeros": "fieldrecon.solids.ray_intersections",
    "fixed_point": "fieldrecon.coupling.fixed_point",
    "flow_energy": "fieldrecon.advection.flow_energy",
    "isotropic": f"{_WING}.plate.isotropic_rigidity",
    "laplacians_at": "fieldrecon.methods.laplacians_at",
    "local_least_squares": "fieldrecon.velocity.local_least_squares",
    "local_moving_least_squares": "fieldrecon.velocity.local_moving_least_squares",
    "local_rbf": "fieldrecon.velocity.local_rbf",
    "moved": "fieldrecon.solids.transform",
    "normal_equations": "fieldrecon.methods.normal_equations",
    "raviart_thomas": "fieldrecon.velocity.raviart_thomas",
    "ray_traced": "fieldrecon.solids.ray_traced",
    "read_cloud": "fieldrecon.io.read_cloud",
    "read_mesh": "fieldrecon.io.read_mesh",
    "read_mesh_and_data": "fieldrecon.io.read_mesh_and_data",
    "read_surface": "fieldrecon.io.read_surface",
    "read_triangles": "fieldrecon.io.read_triangles",
    "resultants": "fieldrecon.coupling.net_force_and_moment",
    "rigid_motions": "fieldrecon.coupling.rigid_body_motions",
    "shapes": "fieldrecon.solids.shapes",
    "sphere": "fieldrecon.methods.globe",
    "standard_atmosphere": f"{_WING}.standard_atmosphere.standard_atmosphere",
    "values_at": "fieldrecon.methods.values_at",
    "variational_implicit": "fieldrecon.surfaces.variational_implicit",
    "write_mesh": "fieldrecon.io.write_mesh",
    "write_triangles": "fieldrecon.io.write_triangles",
}
"""Where each is now."""


def moved(name: str) -> Any:
    """Return what an old name stands for, with a warning that names the new one.

    Raises
    ------
    KeyError
        If it is no name of version 0.1.
    """
    new = MOVED[name]
    warnings.warn(
        f"fieldrecon.{name} is now {new}; the old name is removed in version 0.3",
        DeprecationWarning,
        stacklevel=3,
    )
    room, _, attribute = new.rpartition(".")
    return getattr(import_module(room), attribute)
