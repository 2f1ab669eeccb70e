"""Conservative transfer of displacements and loads, and an elastic wing in steady flow.

The wing consists of a plate element, a vortex lattice and the standard atmosphere; only these
experiments use them.
"""
