"""Selection of a method by the data, and the error of a reconstructed field.

Cross-validation at the distances of the queries, leave-one-out errors, prediction intervals, and
points that are extrapolated.
"""

from fieldrecon.selection.anisotropy import Anisotropy, find_anisotropy
from fieldrecon.selection.cross_validation import CrossValidator, best
from fieldrecon.selection.distance_matching import (
    Fold,
    distance_matched_folds,
    held_out_distances,
    nearest_neighbor_distances,
    wasserstein_distance,
)
from fieldrecon.selection.error_bands import ErrorBand
from fieldrecon.selection.extrapolation import extrapolated
from fieldrecon.selection.leaving_one_out import leave_one_out
from fieldrecon.selection.model_scores import ModelScore
from fieldrecon.selection.models import MODELS, Model

__all__ = [
    "MODELS",
    "Anisotropy",
    "CrossValidator",
    "ErrorBand",
    "Fold",
    "Model",
    "ModelScore",
    "best",
    "distance_matched_folds",
    "extrapolated",
    "find_anisotropy",
    "held_out_distances",
    "leave_one_out",
    "nearest_neighbor_distances",
    "wasserstein_distance",
]
