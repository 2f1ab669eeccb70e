"""_numerics."""
