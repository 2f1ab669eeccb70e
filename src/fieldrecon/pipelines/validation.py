"""The validation of a reconstruction: which samples were held out, how far, and the residuals."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fieldrecon.selection.cross_validation import CrossValidator
from fieldrecon.selection.distance_matching import (
    nearest_neighbor_distances,
    wasserstein_distance,
)
from fieldrecon.selection.error_bands import ErrorBand

_ALIKE = 0.2
"""Mean difference of the quantiles of two distributions that are alike, as part of their mean."""
_OWN_DISTANCES = 20_000  # samples whose distances from each other are shown


@dataclass(frozen=True, eq=False)
class Validation:
    """Held-out samples: their distances, values and residuals, and the band that these give.

    Distances are those from the nearest sample, on the globe in degrees.

    Parameters
    ----------
    band : ErrorBand
    targets, leave_one_out, held_out : ndarray
        Distances of the targets from the samples, of each sample from the others, and of the
        held-out samples from the fitted ones.
    values, residuals : ndarray of shape (m,)
        Values of the held-out samples, and the differences from the predicted ones.
    unit : str
        Unit of the distances, or empty.
    """

    band: ErrorBand
    targets: np.ndarray
    leave_one_out: np.ndarray
    held_out: np.ndarray
    values: np.ndarray
    residuals: np.ndarray
    unit: str = ""

    @classmethod
    def of(
        cls,
        validator: CrossValidator,
        residuals: np.ndarray,
        band: ErrorBand,
        x: np.ndarray,
        lonlat: bool,
    ) -> Validation:
        """Compute the distances of targets x (m, d), and of the samples."""
        points = validator.points
        every = max(1, len(points) // _OWN_DISTANCES)
        shown = _degrees if lonlat else np.asarray
        return cls(
            band,
            shown(nearest_neighbor_distances(points, x)),
            shown(np.sort(nearest_neighbor_distances(points))[::every]),
            shown(band.distances),
            validator.values[validator.held_out],
            residuals,
            " degrees" if lonlat else "",
        )

    @property
    def is_matched_by_leave_one_out(self) -> bool:
        """Whether the samples are as far from each other as the targets are from the samples."""
        difference = wasserstein_distance(self.targets, self.leave_one_out)
        return difference <= _ALIKE * float(self.targets.mean())

    @property
    def farthest(self) -> str:
        """The largest distance of a held-out sample, with its unit."""
        return self._length(self.held_out.max())

    @property
    def sentence(self) -> str:
        """What was done, and why."""
        count = len(self.residuals)
        targets, own = (self._length(np.median(d)) for d in (self.targets, self.leave_one_out))
        far, apart = (self._length(np.quantile(d, 0.9)) for d in (self.targets, self.leave_one_out))
        medians = (
            f"The targets have a median distance of {targets} from the nearest sample, the samples "
            f"of {own} from each other; a tenth have more than {far} and {apart}"
        )
        if self.is_matched_by_leave_one_out:
            return (
                f"{medians}. Both distributions are alike, so the errors were estimated at {count} "
                "samples that were held out with few others."
            )
        return (
            f"{medians}. Leave-one-out cross-validation would not show the error at the targets. "
            f"So the errors were estimated at {count} samples that were held out together with "
            f"their neighbours, at a median distance of {self._length(np.median(self.held_out))} "
            "(nearest-neighbour distance matching)."
        )

    def coverage(self) -> list[tuple[str, float, int]]:
        """For bins of held-out samples: the largest distance, the fraction covered, the number."""
        found = self.band.coverage_by_distance()
        return [
            (self._length(_degrees(np.array(far)) if self.unit else far), share, count)
            for far, share, count in found
        ]

    def _length(self, distance: float | np.ndarray) -> str:
        return f"{float(distance):.3g}{self.unit}"


def _degrees(chord: np.ndarray) -> np.ndarray:
    """Angles of chords of the unit sphere, in degrees."""
    return np.degrees(2 * np.arcsin(np.minimum(chord / 2, 1.0)))
