"""Velocities and gradients on meshes, and vertices whose velocity one ring does not determine."""
