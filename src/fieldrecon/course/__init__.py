"""The instructor's side of the course: notebooks from their sources, the bundle, the graders' proof."""
