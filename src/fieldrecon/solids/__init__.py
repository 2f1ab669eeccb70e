"""Solids as functions that are positive inside: set operations, shapes, extraction, ray tracing.

Union, intersection, difference and blending (Wendland (2005), section 1.1), the surface of a
solid as triangles by marching cubes, and pictures by ray tracing or of the triangles.
"""

from fieldrecon.solids.constructive import (
    Solid,
    as_solid,
    blend,
    difference,
    intersection,
    morph,
    transform,
    union,
)
from fieldrecon.solids.marching_cubes import ExtractedSurface, extract_surface
from fieldrecon.solids.ray_casting import View, ray_intersections, ray_traced
from fieldrecon.solids.shapes import Ball, Box, Cylinder, Torus, roughened, sample_surface, scanned

__all__ = [
    "Ball",
    "Box",
    "Cylinder",
    "ExtractedSurface",
    "Solid",
    "Torus",
    "View",
    "as_solid",
    "blend",
    "difference",
    "extract_surface",
    "intersection",
    "morph",
    "ray_intersections",
    "ray_traced",
    "roughened",
    "sample_surface",
    "scanned",
    "transform",
    "union",
]
