"""Meshes of triangles in the plane and of tetrahedra in space, and their duals.

Cells, faces, circumcentres, the cells around a vertex, and Delaunay meshes of scattered points.
Erleben, Field Reconstruction, p. 14-16.
"""

from fieldrecon.meshes.duals import barycentric_dual, circumcentric_dual
from fieldrecon.meshes.simplex_mesh import SimplexMesh

__all__ = ["SimplexMesh", "barycentric_dual", "circumcentric_dual"]
