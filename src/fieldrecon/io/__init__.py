"""Files: tables of samples, point clouds, meshes, fitted fields and their values.

The suffix names the format: `fieldrecon.io.meshes.READERS` is the table of the readers of meshes
and clouds, `fieldrecon.io.values.FORMATS` that of the writers of values.
"""

from fieldrecon.io.clouds import Cloud, read_cloud
from fieldrecon.io.meshes import (
    read_mesh,
    read_mesh_and_data,
    read_surface,
    read_triangles,
    write_mesh,
    write_triangles,
)
from fieldrecon.io.saved_fields import load, save

__all__ = [
    "Cloud",
    "load",
    "read_cloud",
    "read_mesh",
    "read_mesh_and_data",
    "read_surface",
    "read_triangles",
    "save",
    "write_mesh",
    "write_triangles",
]
