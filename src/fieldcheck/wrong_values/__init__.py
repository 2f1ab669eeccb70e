"""What wrong values have in common, and how far they are off, in words."""
