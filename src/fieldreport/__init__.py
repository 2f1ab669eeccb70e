"""fieldreport."""
