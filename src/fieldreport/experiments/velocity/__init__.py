"""Velocities and gradients on meshes, and the vertices at which one ring does not determine them."""
