"""Velocities and gradients on meshes, and vertices that one ring does not determine."""
