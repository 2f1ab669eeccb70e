"""Kernels of radial basis functions: conditional positive definiteness, errors, conditioning."""
