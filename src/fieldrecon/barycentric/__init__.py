"""Barycentric coordinates of convex polygons and polyhedra, and of Voronoi cells.

Wachspress and Warren's coordinates, and the coordinates of a point of a mesh in the Voronoi cell
that surrounds it. Erleben, Field Reconstruction, p. 27-37.
"""

from fieldrecon.barycentric.coordinates import BarycentricCoordinates
from fieldrecon.barycentric.voronoi import VoronoiCell, voronoi_weights

__all__ = ["BarycentricCoordinates", "VoronoiCell", "voronoi_weights"]
