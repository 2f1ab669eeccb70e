"""Least squares, moving least squares and radial basis functions compared, also with others."""
