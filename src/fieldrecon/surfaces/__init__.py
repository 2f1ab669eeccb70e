"""From a cloud of points on a surface to an implicit function of the solid that it bounds.

Normals and their orientation, points off the surface, implicit surfaces from points, variational
implicit functions, and polygon soups. Wendland (2005), section 1.1.
"""

from fieldrecon.surfaces.implicit_surfaces import ImplicitSurface, implicit_surface
from fieldrecon.surfaces.normal_orientation import orient_normals
from fieldrecon.surfaces.normals import PointNormals, estimate_normals
from fieldrecon.surfaces.off_surface import OffSurface, classified_points, off_surface_points
from fieldrecon.surfaces.polygon_soup import PolygonSoup
from fieldrecon.surfaces.variational_implicits import ShapeTransformation, variational_implicit

__all__ = [
    "ImplicitSurface",
    "OffSurface",
    "PointNormals",
    "PolygonSoup",
    "ShapeTransformation",
    "classified_points",
    "estimate_normals",
    "implicit_surface",
    "off_surface_points",
    "orient_normals",
    "variational_implicit",
]
