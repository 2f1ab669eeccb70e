"""Selection of a method by the data, and the error of a reconstructed field.

Leave-one-out and cross-validation errors, prediction intervals, and points that are extrapolated.
"""

from fieldrecon.selection.cross_validation import CrossValidator, ModelScore, best
from fieldrecon.selection.extrapolation import extrapolated
from fieldrecon.selection.leaving_one_out import leave_one_out
from fieldrecon.selection.models import MODELS, Model
from fieldrecon.selection.prediction_intervals import ErrorEstimate

__all__ = [
    "MODELS",
    "CrossValidator",
    "ErrorEstimate",
    "Model",
    "ModelScore",
    "best",
    "extrapolated",
    "leave_one_out",
]
