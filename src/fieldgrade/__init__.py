"""The instructor's side of the course: notebooks, the bundle, the proof of the graders."""
