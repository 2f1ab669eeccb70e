"""Scores of models: their residuals at held-out samples, and which errors can be told apart."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from fieldrecon.selection.models import Maker, Model

SMALL_GAIN, CERTAIN = 1.1, 2.0
"""Ratio of errors, and standard errors of their difference, up to which a model that is not
cautious is not preferred to one that is."""


@dataclass(frozen=True, eq=False)
class ModelScore:
    """Result of a model on the samples: residuals at held-out samples, or why there are none.

    Parameters
    ----------
    model : Model
    maker : callable, optional
        The variant of least error; takes points to the method on these.
    residuals : ndarray of shape (m,) or (m, k), optional
        At each held-out sample, its value, or k values, less the field of the fitted ones there.
    reason : str
        Why the model was not tried or has no field, otherwise empty.
    weights : ndarray of shape (m,), optional
        How much each held-out sample counts in the root mean square; by default all equally.
    held_out : ndarray of shape (m,), optional
        The held-out samples, by their indices; by default m different ones.
    caution : float
        That of the model if its error cannot be told from the least, otherwise infinite.
    weaker : callable, optional
        The next variant with less smoothing, if its error cannot be told from that of this one.
    """

    model: Model
    maker: Maker | None
    residuals: np.ndarray | None
    reason: str = ""
    weights: np.ndarray | None = None
    held_out: np.ndarray | None = None
    caution: float = np.inf
    weaker: Maker | None = None

    def __repr__(self) -> str:
        return f"<ModelScore {self.model.name}: {self.reason or self.errors}>"

    @property
    def errors(self) -> str:
        """Its errors in words."""
        return f"rms error {self.rms:.4g} at {self.n_held_out} held-out samples"

    @property
    def n_held_out(self) -> int:
        """Number of residuals."""
        return 0 if self.residuals is None else len(self.residuals)

    @property
    def rms(self) -> float:
        """Root mean square of the residuals, in the unit of the values; infinite without any."""
        if self.residuals is None:
            return np.inf
        return float(np.sqrt(np.average(self.squares, weights=self.weights)))

    @property
    def squares(self) -> np.ndarray:
        """Squared residual at each held-out sample, (m,), the mean of those of several values."""
        assert self.residuals is not None, "a score without residuals has a reason"
        return np.mean(self.residuals.reshape(self.n_held_out, -1) ** 2, axis=1)

    @property
    def largest(self) -> float:
        """Largest absolute residual; infinite without any."""
        return np.inf if self.residuals is None else float(np.abs(self.residuals).max())

    @property
    def rank(self) -> tuple[int, float, float]:
        """Key of the order: more held-out samples, then caution, then the smaller rms first."""
        return -self.n_held_out, self.caution, self.rms

    def is_level_with(self, best: ModelScore, standard_errors: float = 1.0) -> bool:
        """Whether its mean square error exceeds that of the best by so few standard errors.

        With the differences e of their squares, and s the sums of e - mean(e) at each of the
        samples, of which some are held out in several folds: mean(e) <= k sqrt(sum(s²)) / m.
        """
        excess = self.squares - best.squares
        weights = np.ones(len(excess)) if self.weights is None else self.weights
        mean = np.average(excess, weights=weights)
        off = weights * (excess - mean)
        sums = off if self.held_out is None else np.bincount(self.held_out, weights=off)
        return bool(mean <= standard_errors * np.sqrt((sums**2).sum()) / weights.sum())


def by_caution(scores: list[ModelScore]) -> list[ModelScore]:
    """The scores, with the caution of their models if they are level with the best on all folds."""
    most = max(score.n_held_out for score in scores)
    final = [score for score in scores if score.n_held_out == most > 0]
    least = _best_of(final)
    return [
        replace(score, caution=score.model.caution)
        if least and score in final and score.is_level_with(least)
        else score
        for score in scores
    ]


def _best_of(scores: list[ModelScore]) -> ModelScore | None:
    """The score of least error; that of a cautious model if the gain is small and uncertain.

    An interpolant of high order overshoots at a few places. Its error is large if one of them is
    among the held-out samples, and small by chance if none is.
    """
    cautious = [score for score in scores if score.model.caution < np.inf]
    least, safe = (min(some, key=lambda s: s.rms, default=None) for some in (scores, cautious))
    if not (least and safe) or safe.rms > SMALL_GAIN * least.rms:
        return least
    return safe if safe.is_level_with(least, CERTAIN) else least
