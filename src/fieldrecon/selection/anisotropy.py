"""Geometric anisotropy: fields that vary more slowly along one direction of the plane.

In the words of kriging, the range is longer along that direction than across it. A method takes it
as a metric, in which the samples along the direction are nearer.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, replace

import numpy as np

from fieldrecon._core.chunks import Progress
from fieldrecon.selection.cross_validation import CrossValidator
from fieldrecon.selection.model_scores import ModelScore
from fieldrecon.selection.models import Model, with_distances, with_metric

RATIOS, DIRECTIONS = (2.0, 4.0), 4
"""Ratios, and the number of directions, that are tried first."""


@dataclass(frozen=True)
class Anisotropy:
    """A direction along which a field of the plane varies more slowly.

    The distance is that of M = R diag(1 / ratio, ratio) R^T with the rotation R by the angle. Its
    circles are ellipses of the same area, `ratio` times as long along the direction as across it.

    Parameters
    ----------
    ratio : float
        Range along the direction, divided by the one across it: more than one. It is the
        reciprocal of the ratio of gstat.
    angle : float
        Direction in degrees, from the axis x towards the axis y: 90 less the azimuth.

    Raises
    ------
    ValueError
        If the ratio is not more than one, or one of both is not finite.

    References
    ----------
    Chilès and Delfiner, Geostatistics, 2nd ed. (2012), section 2.5.2.

    Examples
    --------
    >>> stretched = Anisotropy(4.0, 90.0)
    >>> print(stretched)
    ranges 4 times as long along 90°
    >>> np.diagonal(stretched.metric).round(12)
    array([4.  , 0.25])
    """

    ratio: float
    angle: float

    def __post_init__(self) -> None:
        if not (1 < self.ratio < np.inf and np.isfinite(self.angle)):
            raise ValueError(
                "anisotropy must be a ratio above 1 and an angle in degrees; got "
                f"{self.ratio:g} and {self.angle:g}"
            )

    @classmethod
    def of(cls, text: str) -> Anisotropy:
        """Read a ratio and an angle, such as 3:45."""
        number = r"([-+]?\d*\.?\d+)"
        found = re.fullmatch(f"{number}:{number}", text.strip())
        if not found:
            raise ValueError(f"anisotropy must be auto or RATIO:ANGLE such as 3:45; got {text!r}")
        return cls(float(found[1]), float(found[2]))

    def __str__(self) -> str:
        return f"ranges {self.ratio:.3g} times as long along {self.angle % 180:.3g}°"

    @property
    def metric(self) -> np.ndarray:
        """The matrix M, (2, 2), of determinant one."""
        turn = np.radians(self.angle)
        along, across = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
        return np.outer(along, along) / self.ratio + self.ratio * np.outer(across, across)

    def of_model(self, model: Model) -> Model:
        """The model with the distances of this anisotropy."""
        return with_metric(model, self.metric, str(self))


def find_anisotropy(
    validator: CrossValidator, score: ModelScore, progress: Progress | None = None
) -> tuple[ModelScore, Anisotropy | None]:
    """Try anisotropies in the variant of a score, at the held-out samples.

    First two ratios along four directions are tried, then the neighbours of the best one. By the
    one-standard-error rule it is taken only if the isotropic error is clearly larger.

    Parameters
    ----------
    validator : CrossValidator
        The samples, with the folds that hold some of them out.
    score : ModelScore
        The method, by its error at these samples.
    progress : callable, optional
        Called as progress(done, total) with numbers of variants.

    Returns
    -------
    ModelScore
        That of the anisotropic variant, or the given one.
    Anisotropy or None
        What was found, if it was taken.
    """
    maker = score.maker
    if maker is None or score.n_held_out < validator.n_held_out or score.model.family == "LS":
        return score, None
    coarse = [Anisotropy(r, 180 * k / DIRECTIONS) for r in RATIOS for k in range(DIRECTIONS)]
    total = len(coarse) + 4
    found: dict[Anisotropy, ModelScore] = {}

    def error(one: Anisotropy) -> float:
        if one not in found:
            variant = with_distances(maker, one.metric)
            found[one] = validator.score(one.of_model(score.model), variant)
            if progress is not None:
                progress(len(found), total)
        return found[one].rms

    best = min(coarse, key=error)
    turned = [replace(best, angle=best.angle + step) for step in (-22.5, 22.5)]
    best = min((best, *turned), key=error)
    stretched = [replace(best, ratio=best.ratio * factor) for factor in (2**-0.5, 2**0.5)]
    best = min((best, *stretched), key=error)
    if found[best].maker is None or score.is_level_with(found[best]):
        return score, None
    return replace(found[best], caution=score.caution), best
