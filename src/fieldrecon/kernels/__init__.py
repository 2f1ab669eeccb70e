"""Radial functions: kernels of radial basis functions, and weights of moving least squares.

Each kernel knows its order of conditional positive definiteness, its slope, and the sign that
makes its form positive. Erleben, Field Reconstruction, p. 9-13; Wendland (2005), section 1.1; the
appendix.
"""

from fieldrecon.kernels.base import Radial
from fieldrecon.kernels.conditionally_positive_definite import (
    multiquadric,
    polyharmonic,
    thin_plate_spline,
)
from fieldrecon.kernels.mairhuber_curtis import SingularExchange, singular_exchange
from fieldrecon.kernels.positive_definite import gaussian, inverse_multiquadric, matern, wendland
from fieldrecon.kernels.weights import inverse_square

__all__ = [
    "Radial",
    "SingularExchange",
    "gaussian",
    "inverse_multiquadric",
    "inverse_square",
    "matern",
    "multiquadric",
    "polyharmonic",
    "singular_exchange",
    "thin_plate_spline",
    "wendland",
]
