"""Methods that reconstruct a field from values at scattered points.

Least squares and moving least squares (Erleben, Field Reconstruction, p. 3-10), augmented radial
basis functions (p. 11-13), the same on overlapping patches for millions of points, data of any kind
(Hermite), natural cubic splines (Wendland (2005), section 1.4), the mean of several methods, and
fields on the globe. Each is a `fieldrecon.Reconstruction`, which is determined by its weights.
"""

from fieldrecon.methods.functionals import Functionals, derivatives_at, laplacians_at, values_at
from fieldrecon.methods.globe import OnGlobe, principal, to_unit
from fieldrecon.methods.hermite import HermiteField, HermiteRBF
from fieldrecon.methods.least_squares import LeastSquares, normal_equations
from fieldrecon.methods.mean import Mean
from fieldrecon.methods.moving_least_squares import MovingLeastSquares
from fieldrecon.methods.natural_splines import NaturalCubicSpline
from fieldrecon.methods.partition_of_unity.method import PartitionOfUnityRBF
from fieldrecon.methods.rbf import RBF
from fieldrecon.methods.spline_bases import b_splines, cardinal_b_spline
from fieldrecon.methods.tangent_plane import OnTangentPlane

__all__ = [
    "RBF",
    "Functionals",
    "HermiteField",
    "HermiteRBF",
    "LeastSquares",
    "Mean",
    "MovingLeastSquares",
    "NaturalCubicSpline",
    "OnGlobe",
    "OnTangentPlane",
    "PartitionOfUnityRBF",
    "b_splines",
    "cardinal_b_spline",
    "derivatives_at",
    "laplacians_at",
    "normal_equations",
    "principal",
    "to_unit",
    "values_at",
]
