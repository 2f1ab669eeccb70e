"""From results to the report: one figure style, one build, HTML and PDF."""
