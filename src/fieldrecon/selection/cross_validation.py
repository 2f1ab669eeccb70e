"""Cross-validation: the errors of models at samples that were held out.

Up to some thousands of samples, each is left out in turn. With more, a model is evaluated at
samples in the midst of blocks of neighbours, drawn at random. A block has the density and the noise
of the whole cloud, and suffices for any method whose value depends only on the samples near by. A
polynomial for the whole domain is fitted to the blocks and to others drawn at random from all.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from scipy.spatial import cKDTree

from fieldrecon._core import validation as valid
from fieldrecon.selection.leaving_one_out import leave_one_out
from fieldrecon.selection.models import Maker, Model

NO_FIELD = (ValueError, np.linalg.LinAlgError, MemoryError, OverflowError)
FEW = 8000
"""Up to this number of samples, each one is left out."""
EVERYWHERE = 40_000
"""Of more samples, the number drawn from all, to which a polynomial is fitted."""
BLOCKS, BLOCK, MIDST = 24, 1000, 250
"""Number of blocks, samples of each, and how many of these, the most central, are held out."""

Result = TypeVar("Result")


@dataclass(frozen=True, eq=False)
class ModelScore:
    """Result of a model on the samples: residuals at held-out samples, or why there are none.

    Parameters
    ----------
    model : Model
    maker : callable, optional
        The variant of least error; takes points to the method on these.
    residuals : ndarray of shape (m,), optional
        At each held-out sample, its value less the field of the others there.
    reason : str
        Why the model was not tried or has no field, otherwise empty.
    """

    model: Model
    maker: Maker | None
    residuals: np.ndarray | None
    reason: str = ""

    @property
    def rms(self) -> float:
        """Root mean square of the residuals, in the unit of the values; infinite without any."""
        return np.inf if self.residuals is None else float(np.sqrt(np.mean(self.residuals**2)))

    @property
    def largest(self) -> float:
        """Largest absolute residual; infinite without any."""
        return np.inf if self.residuals is None else float(np.abs(self.residuals).max())


@dataclass(frozen=True, eq=False)
class CrossValidator:
    """Samples, and the blocks of them in whose midst samples are held out; none of few samples.

    Parameters
    ----------
    points : ndarray of shape (n, d)
    values : ndarray of shape (n,)
    blocks : ndarray of shape (b, k), optional
        Samples of each block, the most central first.
    everywhere : ndarray of shape (k,), optional
        Samples drawn from all, without those in the midst of blocks.
    """

    points: np.ndarray
    values: np.ndarray
    blocks: np.ndarray | None = None
    everywhere: np.ndarray | None = None

    @classmethod
    def of(cls, points: np.ndarray, values: np.ndarray, seed: int = 0) -> CrossValidator:
        """Draw the blocks, if there are more than a few samples."""
        points = valid.as_points(points)
        values = valid.as_values(values, len(points))
        n = len(points)
        if n <= FEW:
            return cls(points, values)
        rng = np.random.default_rng(seed)
        middles = points[rng.choice(n, BLOCKS, replace=False)]
        blocks = cKDTree(points).query(middles, BLOCK)[1]
        drawn = rng.choice(n, min(n, EVERYWHERE), replace=False)
        return cls(points, values, blocks, np.setdiff1d(drawn, blocks[:, :MIDST]))

    @property
    def n_held_out(self) -> int:
        """Number of samples held out for each model; one in two blocks counts twice."""
        return len(self.points) if self.blocks is None else self.blocks[:, :MIDST].size

    def evaluate(self, model: Model, asked_for: bool = False) -> ModelScore:
        """Residuals of the model's best variant at held-out samples.

        A model that has no field on these points, or would take too long, has a reason instead.
        """
        if len(self.points) > model.max_samples and not asked_for:
            reason = f"not tried on more than {model.max_samples:g} samples unasked"
            return ModelScore(model, None, None, reason)
        scores, reason = [], ""
        for maker in model.makers(self.points):
            try:
                scores.append(ModelScore(model, maker, self._residuals(maker, model)))
            except NO_FIELD as error:
                reason = reason or str(error)
        if scores:
            return min(scores, key=lambda score: score.rms)
        return ModelScore(model, None, None, reason)

    def _residuals(self, maker: Maker, model: Model) -> np.ndarray:
        if self.blocks is None or self.everywhere is None:
            return leave_one_out(maker(self.points), self.values)
        if model.family == "LS":
            midst = self.blocks[:, :MIDST].ravel()
            own = np.append(np.unique(midst), self.everywhere)
            residuals = leave_one_out(maker(self.points[own]), self.values[own])
            return residuals[: len(own) - len(self.everywhere)]
        return np.concatenate([*self._in_blocks(maker, self.blocks)])

    def _in_blocks(self, maker: Maker, blocks: np.ndarray) -> Iterator[np.ndarray]:
        for block in blocks:
            yield leave_one_out(maker(self.points[block]), self.values[block])[:MIDST]


def best(
    scores: Sequence[ModelScore], attempt: Callable[[ModelScore], Result]
) -> tuple[ModelScore, Result]:
    """Return the score of least rms for which the attempt succeeds, and the attempt's result.

    Raises
    ------
    numpy.linalg.LinAlgError
        If no model can be fitted. The message is the one of the first and simplest model.
    """
    reasons = [f"{score.model.name}: {score.reason}" for score in scores if score.reason]
    for score in sorted(scores, key=lambda score: score.rms)[: len(scores) - len(reasons)]:
        try:
            return score, attempt(score)
        except NO_FIELD as error:
            reasons.append(f"{score.model.name}: {error}")
    raise np.linalg.LinAlgError(f"no field from these samples by {reasons[0]}")
