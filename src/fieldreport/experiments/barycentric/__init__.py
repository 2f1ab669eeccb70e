"""barycentric."""
