"""Cross-validation: the errors of models at samples that are held out.

The held-out samples are as far from the fitted ones as the queries are from all samples, see
`fieldrecon.selection.distance_matching`. All models are compared on the first folds, with their
smoothing chosen there; those near the best are then compared on all folds. Of the models whose
errors there cannot be told from the least, the most cautious is chosen. A model that amplifies
noise at the queries more than at the held-out samples is refused before: its errors there do not
show those at the queries. Where queries are in gaps, the patches of the chosen model are made wider
unless the errors speak against it. Of many samples, only those in some windows are used, each the
neighbourhood of a query. This suffices for any method whose value depends only on the samples near
by.
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
from fieldrecon.methods.partition_of_unity.blending import shared_patches
from fieldrecon.reconstruction import Reconstruction
from fieldrecon.selection.distance_matching import (
    Fold,
    distance_matched_folds,
    held_out_distances,
    nearest_neighbor_distances,
)
from fieldrecon.selection.model_scores import ModelScore, by_caution
from fieldrecon.selection.models import (
    MANY,
    Maker,
    Model,
    mean_of,
    parts_of_mean,
    with_variances,
    with_wide_patches,
)
from fieldrecon.selection.noise_gain import noise_gain

NO_FIELD = (ValueError, np.linalg.LinAlgError, MemoryError, OverflowError)
FEW = 400
"""Up to this number of samples there are more folds, since few samples have room in each."""
FOLDS_OF_FEW, FOLDS, FOLDS_OF_MANY = 60, 5, 10
"""Numbers of folds of few samples, of more, and of those in windows."""
SUFFICIENT, MOST_FOLDS = 100, 40
"""Number of held-out samples up to which the number of folds is doubled, and its maximum."""
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
"""Largest number of models that are compared on all folds, besides the most cautious ones."""
AMPLIFIED, GAIN_QUERIES = 3.0, 200
"""Ratio of the noise gains at queries and held-out samples beyond which a model is refused, and the
number of queries at which it is computed."""
GAP = 1.5
"""There are gaps if held-out samples are this many times as far from the fitted ones as samples are
from each other, on the mean."""

Result = TypeVar("Result")


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
    queries : ndarray of shape (m, d), optional
        Queries that the held-out samples stand for.
    sites : ndarray of integers, optional
        Indices of the samples near the queries; by default all samples.
    """

    points: np.ndarray
    values: np.ndarray
    folds: tuple[Fold, ...]
    variances: np.ndarray | None = None
    queries: np.ndarray | None = None
    sites: np.ndarray | None = None
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
        sites = np.arange(len(points))
        if len(points) > MANY:
            x, sites = _windows(points, x, seed)
        folds = tuple(
            Fold(sites[fold.held_out], sites[fold.fitted])
            for fold in _sufficient_folds(points[sites], x, _number_of_folds(len(points)), seed)
        )
        if variances is not None:
            variances = valid.as_values(variances, len(points), "variances")
        return cls(points, values, folds, variances, x, sites)

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

        The most cautious models are compared on all folds, too: on the first ones, a model that
        overshoots in gaps may be the best by chance. So are the parts of a mean, whose residuals
        are known. By the one-standard-error rule, the scores that are level with the best one have
        the `caution` of their models.
        """
        with shared_patches():
            return self._compare(models, asked_for, progress)

    def _compare(
        self, models: Sequence[Model], asked_for: bool, progress: Progress | None
    ) -> list[ModelScore]:
        first = self._first_folds()
        scores: list[ModelScore] = []
        for done, model in enumerate(models, 1):
            scores.append(self.evaluate(model, asked_for, first, scores))
            if progress is not None:
                progress(done, len(models) + 1)
        scores = self._without_amplifiers(scores)
        ranked = sorted((s for s in scores if s.maker), key=lambda score: score.rms)
        near = [s for s in ranked[:FINALISTS] if s.rms <= DOMINATED * ranked[0].rms]
        cautious = [score for score in ranked if score.model.caution < np.inf]
        least = min((score.model.caution for score in cautious), default=0)
        near += [score for score in cautious if score.model.caution == least]
        parts = {part for score in near if score.maker for part in parts_of_mean(score.maker)}
        near += [score for score in ranked if score.maker in parts]
        final: dict[str, ModelScore] = {}
        for score in sorted(near, key=lambda score: len(score.model.parts)):  # a mean has parts
            final[score.model.name] = self._on_all_folds(score, final)
        every = [final.get(score.model.name, score) for score in scores]
        return self._with_suitable_patches(by_caution(every))

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
        """The folds on which all models are compared: the fewest with enough held-out samples.

        They are not more than the folds of samples without gaps, so that the time is bounded.
        """
        total = np.cumsum([len(fold.held_out) for fold in self.folds])
        enough = int(np.searchsorted(total, ENOUGH)) + 1
        return self.folds[: min(enough, _number_of_folds(len(self.points)))]

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

    def amplification(self, maker: Maker) -> float:
        """Noise gain of a variant at the queries, divided by that at the held-out samples.

        Root mean squares, of the first folds and of queries no farther than the held-out samples.
        Moving least squares between tracks, for example, extrapolates from the nearest track; at a
        held-out sample of a track it interpolates along this track, with far smaller weights.
        """
        x = self._reached_queries()
        if x is None or not len(x):
            return 1.0
        try:
            sites = np.arange(len(self.points)) if self.sites is None else self.sites
            at_queries = noise_gain(self._fitted(maker, sites), x)
            held_out = [
                noise_gain(self._fitted(maker, fold.fitted), self.points[fold.held_out])
                for fold in self._first_folds()
            ]
        except NO_FIELD:
            return np.inf
        return _rms(at_queries) / _rms(np.concatenate(held_out))

    def _reached_queries(self) -> np.ndarray | None:
        """Some queries that are no farther from the samples than the farthest held-out one."""
        if self.queries is None:
            return None
        order = np.random.default_rng(0).permutation(len(self.queries))[:GAIN_QUERIES]
        some = self.queries[order]
        near = nearest_neighbor_distances(self.points, some) <= self.distances.max()
        return some[near]

    def _without_amplifiers(self, scores: list[ModelScore]) -> list[ModelScore]:
        """The scores, with the reason for refusing models that amplify noise at the queries.

        Only models with less error than the finalists are tried. If none of all would be left,
        none is refused.
        """
        refused: dict[str, str] = {}
        accepted = 0
        for score in sorted((s for s in scores if s.maker), key=lambda score: score.rms):
            assert score.maker is not None
            if accepted == FINALISTS:
                break
            ratio = self.amplification(score.maker)
            if ratio > AMPLIFIED:
                refused[score.model.name] = (
                    f"its weights amplify noise {ratio:.2g} times as much at the targets as at the "
                    f"held-out samples, so the {score.errors} is not that at the targets"
                    if np.isfinite(ratio)
                    else "it has no field at some of the targets"
                )
            else:
                accepted += 1
        if not accepted:
            return scores
        return [
            ModelScore(score.model, None, None, refused[score.model.name])
            if score.model.name in refused
            else score
            for score in scores
        ]

    def _on_all_folds(self, score: ModelScore, known: Mapping[str, ModelScore]) -> ModelScore:
        """The score on all folds, of the variant with less smoothing if it has less error there.

        In gaps a fold has few held-out samples, and all folds take too long for two variants.
        """
        assert score.maker is not None, "only models with a field are compared on all folds"
        if score.model.parts:
            final = self._of_mean(score.model, self.folds, known)
        else:
            final = self.score(score.model, score.maker)
        if score.weaker and not self.has_gaps:
            final = min(final, self.score(score.model, score.weaker), key=lambda s: s.rms)
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
        method, x = self._fitted(maker, fold.fitted), self.points[fold.held_out]
        known = self.values[fold.fitted]
        # weights take only the patches that contain held-out samples, and fields all
        found = method.weights(x) @ known if method._has_sparse_weights else method.field(known)(x)
        return self.values[fold.held_out] - found

    def _fitted(self, maker: Maker, sites: np.ndarray) -> Reconstruction:
        """The variant on some of the samples, with the variances of these."""
        if self.variances is not None:
            maker = with_variances(maker, self.variances[sites])
        return maker(self.points[sites])


def _rms(numbers: np.ndarray) -> float:
    return float(np.sqrt(np.mean(numbers**2)))


def _sufficient_folds(
    points: np.ndarray, x: np.ndarray | None, n_folds: int, seed: int
) -> tuple[Fold, ...]:
    """Folds that hold out a sufficient number of samples, as many as that takes up to a maximum.

    Where gaps are large, a fold has room for a few only. The quantiles of few residuals, and the
    differences between models, are known too badly.
    """
    folds = distance_matched_folds(points, x, n_folds, MAX_HELD_OUT, seed=seed)
    few = sum(len(fold.held_out) for fold in folds) < min(SUFFICIENT, len(points))
    if few and 2 * n_folds <= MOST_FOLDS:
        return _sufficient_folds(points, x, 2 * n_folds, seed)
    return folds


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
    i = min(found, key=rms)
    least, weaker = found[i], found.get(i - 1)
    if weaker and weaker.maker and weaker.is_level_with(least):
        return replace(least, weaker=weaker.maker)
    return least


def best(
    scores: Sequence[ModelScore], attempt: Callable[[ModelScore], Result]
) -> tuple[ModelScore, Result]:
    """Return the first score by rank for which the attempt succeeds, and the attempt's result.

    Parameters
    ----------
    scores : sequence of ModelScore
        The compared models.
    attempt : callable
        Called with one score after the other: it fits the model to all samples, or raises.

    Returns
    -------
    ModelScore
    object
        What the attempt returned.

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
