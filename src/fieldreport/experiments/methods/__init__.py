"""Least squares, moving least squares and radial basis functions; other libraries."""
