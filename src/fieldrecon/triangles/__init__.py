"""Surfaces of triangles in space: their errors, found and repaired.

Duplicates, holes, inconsistent orientation, self-intersections and T-junctions, found by exact
predicates. The appendix lists the errors.
"""

from fieldrecon.triangles.audit import MeshAudit, audit_mesh
from fieldrecon.triangles.distances import distances_to_triangles
from fieldrecon.triangles.repair import MeshRepair, repair_mesh

__all__ = ["MeshAudit", "MeshRepair", "audit_mesh", "distances_to_triangles", "repair_mesh"]
