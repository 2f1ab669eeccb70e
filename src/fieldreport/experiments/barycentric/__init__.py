"""Barycentric coordinates of polygons and polyhedra, and of Voronoi cells."""
