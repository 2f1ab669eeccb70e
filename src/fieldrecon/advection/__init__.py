"""advection."""
