"""Errors of triangle meshes: detection, classification and repair."""
