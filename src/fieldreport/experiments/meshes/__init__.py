"""Meshes and their duals, and flows on them that are known everywhere."""
