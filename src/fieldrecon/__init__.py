"""Reconstruct a field from scattered samples.

Sites first, data second, then call: ``RBF(points, thin_plate_spline()).field(values)(x)``.
"""

from fieldrecon import datasets
from fieldrecon.dual_meshes import barycentric_dual, circumcentric_dual
from fieldrecon.least_squares import LeastSquares, normal_equations
from fieldrecon.mesh import SimplexMesh
from fieldrecon.model_selection import leave_one_out
from fieldrecon.moving_least_squares import MovingLeastSquares
from fieldrecon.positive_definite import gaussian, inverse_multiquadric, matern, wendland
from fieldrecon.radial import inverse_square, multiquadric, polyharmonic, thin_plate_spline
from fieldrecon.rbf import RBF
from fieldrecon.reconstruction import Field, Reconstruction

__all__ = [
    "RBF",
    "Field",
    "LeastSquares",
    "MovingLeastSquares",
    "Reconstruction",
    "SimplexMesh",
    "barycentric_dual",
    "circumcentric_dual",
    "datasets",
    "gaussian",
    "inverse_multiquadric",
    "inverse_square",
    "leave_one_out",
    "matern",
    "multiquadric",
    "normal_equations",
    "polyharmonic",
    "thin_plate_spline",
    "wendland",
]
