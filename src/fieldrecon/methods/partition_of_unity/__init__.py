"""Radial basis functions on overlapping patches, blended by a partition of unity.

Each patch is a small interpolation problem; the patches are solved in batches, so that the work
grows in proportion to the number of points. Wendland (2005), section 15.4.
"""
