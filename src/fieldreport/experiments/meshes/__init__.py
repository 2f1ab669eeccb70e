"""Meshes and their duals, and reference flows in closed form."""
