"""A real terrain, reconstructed from points on its isolines."""
