"""Conservative transfer of displacements and loads, and an elastic wing in steady flow.

The wing is built of a plate element, a vortex lattice and the standard atmosphere, which only these
experiments need.
"""
