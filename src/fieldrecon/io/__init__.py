"""Files: tables of samples, clouds of points, meshes, and reconstructed values."""

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
