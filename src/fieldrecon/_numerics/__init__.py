"""Numerical building blocks: weighted least squares, saddle-point systems, and neighbour search.

Many small problems are solved in one batch, by factorization, each in a local frame.
"""
