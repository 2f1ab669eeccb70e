"""Cross-validation: the errors of models at samples that are held out.

The held-out samples are as far from the fitted ones as the queries are from all samples, see
`fieldrecon.selection.distance_matching`. All models are compared on the first folds, with their
smoothing chosen there; those near the best are then compared on all folds. Of the models whose
errors there cannot be told from the least, the most cautious is chosen. Where queries are in gaps,
its patches are made wider unless the errors speak against it. Of many samples, only those
in some windows are used, each the neighbourhood of a query. This suffices for any method whose
value depends only on the samples near by.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial import cKDTree

from fieldrecon._core import validation as valid
from fieldrecon._core.chunks import Progress
from fieldrecon.selection.distance_matching import (
    Fold,
    distance_matched_folds,
    held_out_distances,
    nearest_neighbor_distances,
)
from fieldrecon.selection.models import (
    MANY,
    Maker,
    Model,
    mean_of,
    parts_of_mean,
    with_variances,
    with_wide_patches,
)

NO_FIELD = (ValueError, np.linalg.LinAlgError, MemoryError, OverflowError)
FEW = 400
"""Up to this number of samples there are more folds, since few samples have room in each."""
FOLDS_OF_FEW, FOLDS, FOLDS_OF_MANY = 60, 5, 10
"""Numbers of folds of few samples, of more, and of those in windows."""
WINDOWS, WINDOW = 10, 1500
"""Number of windows, and samples of each."""
MAX_HELD_OUT = 1000
"""Largest number of held-out samples in all folds together."""
ENOUGH = 60
"""Number of held-out samples at which all models are compared, if there are as many."""
DOMINATED = 1.2
"""A model with more than this times the least error there is not compared on the other folds."""
NEARLY = 1.02
"""Of several paths of variants, the first is taken whose error is at most this times the least."""
FINALISTS = 3
"""Largest number of models that are compared on all folds, besides the most cautious one."""
GAP = 1.5
"""There are gaps if held-out samples are this many times as far from the fitted ones as samples are
from each other, on the mean."""

Result = TypeVar("Result")


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
    """

    model: Model
    maker: Maker | None
    residuals: np.ndarray | None
    reason: str = ""
    weights: np.ndarray | None = None
    held_out: np.ndarray | None = None
    caution: float = np.inf

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

    def is_level_with(self, best: ModelScore) -> bool:
        """Whether its mean square error exceeds that of the best by at most one standard error.

        With the differences e of their squares, and s the sums of e - mean(e) at each of the
        samples, of which some are held out in several folds: mean(e) <= sqrt(sum(s²)) / m.
        """
        excess = self.squares - best.squares
        weights = np.ones(len(excess)) if self.weights is None else self.weights
        mean = np.average(excess, weights=weights)
        off = weights * (excess - mean)
        sums = off if self.held_out is None else np.bincount(self.held_out, weights=off)
        return bool(mean <= np.sqrt((sums**2).sum()) / weights.sum())


@dataclass(frozen=True, eq=False)
class CrossValidator:
    """Samples and the folds in which some of them are held out.

    Parameters
    ----------
    points : ndarray of shape (n, d)
    values : ndarray of shape (n,) or (n, k)
        Several values are to be given in units of equal weight.
    folds : tuple of Fold
    variances : ndarray of shape (n,), optional
        Variances of the noise of the values, to which smoothing is proportional.
    """

    points: np.ndarray
    values: np.ndarray
    folds: tuple[Fold, ...]
    variances: np.ndarray | None = None
    _known: dict[tuple[Maker, Fold], np.ndarray] = field(
        default_factory=dict, init=False, repr=False
    )
    """Residuals that are known: a variant is compared on the first folds, and again on all."""

    @classmethod
    def of(
        cls,
        points: ArrayLike,
        values: ArrayLike,
        x: ArrayLike | None = None,
        seed: int = 0,
        variances: ArrayLike | None = None,
    ) -> CrossValidator:
        """Choose the folds for queries x (m, d); without any, for queries like the samples."""
        points = valid.as_points(points)
        values = valid.as_values(values, len(points))
        x = x if x is None else valid.as_queries(x, points.shape[1])
        n_folds = _number_of_folds(len(points))
        if len(points) <= MANY:
            folds = distance_matched_folds(points, x, n_folds, MAX_HELD_OUT, seed=seed)
        else:
            x, own = _windows(points, x, seed)
            found = distance_matched_folds(points[own], x, n_folds, MAX_HELD_OUT, seed=seed)
            folds = tuple(Fold(own[fold.held_out], own[fold.fitted]) for fold in found)
        if variances is not None:
            variances = valid.as_values(variances, len(points), "variances")
        return cls(points, values, folds, variances)

    @cached_property
    def held_out(self) -> np.ndarray:
        """Held-out samples, fold by fold, by their indices."""
        return np.concatenate([fold.held_out for fold in self.folds])

    @cached_property
    def distances(self) -> np.ndarray:
        """Distance of each held-out sample from the nearest one that is fitted."""
        return held_out_distances(self.points, self.folds)

    @property
    def n_held_out(self) -> int:
        """Number of samples held out; one in two folds counts twice."""
        return len(self.held_out)

    @property
    def has_gaps(self) -> bool:
        """Whether the held-out samples are farther from the fitted ones than samples are apart."""
        apart = nearest_neighbor_distances(self.points).mean()
        return bool(self.distances.mean() > GAP * apart)

    def compare(
        self,
        models: Sequence[Model],
        asked_for: bool = False,
        progress: Progress | None = None,
    ) -> list[ModelScore]:
        """Scores of the models: all on the first folds, and those near the best on all folds.

        The most cautious model is compared on all folds, too: on the first ones, a model that
        overshoots in gaps may be the best by chance. By the one-standard-error rule, the scores
        that are level with the best one have the `caution` of their models.
        """
        first = self._first_folds()
        scores: list[ModelScore] = []
        for done, model in enumerate(models, 1):
            scores.append(self.evaluate(model, asked_for, first, scores))
            if progress is not None:
                progress(done, len(models) + 1)
        ranked = sorted((s for s in scores if s.maker), key=lambda score: score.rms)
        near = [s for s in ranked[:FINALISTS] if s.rms <= DOMINATED * ranked[0].rms]
        near += sorted(ranked, key=lambda score: score.model.caution)[:1]
        final = [self._on_all_folds(score) if score in near else score for score in scores]
        return self._with_suitable_patches(_by_caution(final))

    def evaluate(
        self,
        model: Model,
        asked_for: bool = False,
        folds: Sequence[Fold] | None = None,
        known: Sequence[ModelScore] = (),
    ) -> ModelScore:
        """Residuals of the model's best variant at held-out samples.

        A model that has no field on these points, or would take too long, has a reason instead.
        Scores on the same folds that are `known` are not computed again for a mean.
        """
        if len(self.points) > model.max_samples and not asked_for:
            reason = f"not tried on more than {model.max_samples:g} samples unasked"
            return ModelScore(model, None, None, reason)
        if model.parts:
            return self._of_mean(model, folds, {score.model.name: score for score in known})
        score = partial(self.score, model, folds=folds or self.folds)
        found = [_least(path, score) for path in model.makers(self.points)]
        least = min(score.rms for score in found)
        return next(score for score in found if score.rms <= NEARLY * least)

    def _of_mean(
        self, model: Model, folds: Sequence[Fold] | None, known: Mapping[str, ModelScore]
    ) -> ModelScore:
        """Residuals of the mean of the best variants of the model's parts."""
        makers = []
        for part in model.parts:
            score = known.get(part.name) or self.evaluate(part, folds=folds)
            if score.maker is None:
                return ModelScore(model, None, None, f"{part.name}: {score.reason}")
            makers.append(score.maker)
        return self.score(model, mean_of(makers), folds)

    def _first_folds(self) -> tuple[Fold, ...]:
        """The folds on which all models are compared: the fewest with enough held-out samples."""
        total = np.cumsum([len(fold.held_out) for fold in self.folds])
        return self.folds[: int(np.searchsorted(total, ENOUGH)) + 1]

    def score(self, model: Model, maker: Maker, folds: Sequence[Fold] | None = None) -> ModelScore:
        """Residuals of one variant of the model at the held-out samples of the folds, or of all."""
        folds = folds or self.folds
        try:
            residuals = np.concatenate([self._residuals(maker, fold) for fold in folds])
        except NO_FIELD as error:
            return ModelScore(model, None, None, str(error))
        held_out = np.concatenate([fold.held_out for fold in folds])
        weights = None if self.variances is None else _certainty(self.variances)[held_out]
        return ModelScore(model, maker, residuals, weights=weights, held_out=held_out)

    def _on_all_folds(self, score: ModelScore) -> ModelScore:
        assert score.maker is not None, "only models with a field are compared on all folds"
        final = self.score(score.model, score.maker)
        return final if final.maker else score

    def _with_suitable_patches(self, scores: list[ModelScore]) -> list[ModelScore]:
        """The scores, with wide patches in the best one if there are gaps.

        By the one-standard-error rule it keeps its patches if their error is clearly smaller.
        """
        chosen = min(scores, key=lambda score: score.rank)
        maker = with_wide_patches(chosen.maker) if self.has_gaps else None
        if maker is None or chosen.n_held_out < self.n_held_out:
            return scores
        wide = self.score(chosen.model, maker)
        if wide.maker is None or not wide.is_level_with(chosen):
            return scores
        wide = replace(wide, caution=chosen.caution)
        return [wide if score is chosen else score for score in scores]

    def residuals(self, maker: Maker) -> np.ndarray:
        """Residuals at the held-out samples of all folds, of the method that is made of points."""
        return np.concatenate([self._residuals(maker, fold) for fold in self.folds])

    def _residuals(self, maker: Maker, fold: Fold) -> np.ndarray:
        if (maker, fold) not in self._known:
            self._known[maker, fold] = self._new_residuals(maker, fold)
        return self._known[maker, fold]

    def _new_residuals(self, maker: Maker, fold: Fold) -> np.ndarray:
        if parts := parts_of_mean(maker):
            return np.mean([self._residuals(part, fold) for part in parts], axis=0)
        if self.variances is not None:
            maker = with_variances(maker, self.variances[fold.fitted])
        fitted = maker(self.points[fold.fitted]).field(self.values[fold.fitted])
        return self.values[fold.held_out] - fitted(self.points[fold.held_out])


def _by_caution(scores: list[ModelScore]) -> list[ModelScore]:
    """The scores, with the caution of their models if they are level with the best on all folds."""
    most = max(score.n_held_out for score in scores)
    final = [score for score in scores if score.n_held_out == most > 0]
    least = min(final, key=lambda score: score.rms, default=None)
    return [
        replace(score, caution=score.model.caution)
        if least and score in final and score.is_level_with(least)
        else score
        for score in scores
    ]


def _number_of_folds(n: int) -> int:
    return FOLDS_OF_FEW if n <= FEW else FOLDS if n <= MANY else FOLDS_OF_MANY


def _certainty(variances: np.ndarray) -> np.ndarray:
    """Weights 1 / (v + q) of samples with noise of variance v, and q the lower quartile of these.

    The residual at a sample of much noise shows the noise. The most certain quarter of the samples
    counts at most twice as much as the worst of its samples.
    """
    floor = max(float(np.quantile(variances, 0.25)), 1e-6 * float(variances.mean())) or 1.0
    return floor / (variances + floor)


def _windows(
    points: np.ndarray, x: np.ndarray | None, seed: int
) -> tuple[np.ndarray | None, np.ndarray]:
    """Windows about queries drawn at random: the queries in them, and the indices of the samples.

    A query is in a window if its nearest sample is among the inner half of the samples.
    """
    tree = cKDTree(points)
    at = points if x is None else x
    drawn = np.random.default_rng(seed).permutation(len(at))[:WINDOWS]
    window = tree.query(at[drawn], WINDOW)[1]
    if x is not None:
        x = x[np.isin(tree.query(x)[1], window[:, : WINDOW // 2])]
    return x, np.unique(window)


def _least(path: Sequence[Maker], score: Callable[[Maker], ModelScore]) -> ModelScore:
    """The best score on a path of variants with more and more smoothing.

    The search begins at the better of the first and the middle variant, and goes on in both
    directions while the error decreases.
    """
    found: dict[int, ModelScore] = {}

    def rms(i: int) -> float:
        if i not in found:
            found[i] = score(path[i])
        return found[i].rms

    start = min({0, len(path) // 2}, key=rms)
    for step in (1, -1):
        i = start
        while 0 <= i + step < len(path) and rms(i + step) < rms(i):
            i += step
    return min(found.values(), key=lambda score: score.rms)


def best(
    scores: Sequence[ModelScore], attempt: Callable[[ModelScore], Result]
) -> tuple[ModelScore, Result]:
    """Return the first score by rank for which the attempt succeeds, and the attempt's result.

    Raises
    ------
    numpy.linalg.LinAlgError
        If no model can be fitted. The message is the one of the first and simplest model.
    """
    reasons = [f"{score.model.name}: {score.reason}" for score in scores if score.reason]
    ranked = sorted(scores, key=lambda score: score.rank)
    for score in ranked[: len(scores) - len(reasons)]:
        try:
            return score, attempt(score)
        except NO_FIELD as error:
            reasons.append(f"{score.model.name}: {error}")
    raise np.linalg.LinAlgError(f"no field from these samples by {reasons[0]}")
