"""Least squares, moving least squares and radial basis functions against each other and against
other libraries.
"""
