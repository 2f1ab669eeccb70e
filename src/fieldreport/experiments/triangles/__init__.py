"""Errors of triangle meshes: planted, found, told apart, and repaired."""
