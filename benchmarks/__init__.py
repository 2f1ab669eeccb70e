"""Benchmarks: time and memory of fieldrecon relative to other libraries, on one machine."""
