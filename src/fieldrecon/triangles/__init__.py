"""triangles."""
