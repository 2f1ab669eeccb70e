"""Surveys with held-out lines, blocks and samples: the chosen method and its error against SciPy's.

A fifth of the samples is held out: at random, in square blocks, or as whole lines. *Ours* is what
`fieldrecon reconstruct --at` computes. SciPy's is `RBFInterpolator` with 50 neighbours and the
smoothing chosen by cross-validation, with that of three kernels which is best on the mean over the
splits, or the best on each split. No user knows either beforehand.
Linear interpolation on triangles (griddata), kriging and verde stand beside it; griddata is
compared at the held-out samples that it answers.
The tables of the folder that FIELDRECON_SURVEYS names are measured as well: text with a header
and the columns x, y and value, the coordinates in one unit of length. `benchmarks.survey_tables`
makes those of the committed results, and says where their files are.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from time import process_time

import numpy as np
from scipy.interpolate import RBFInterpolator

from benchmarks.compared_methods import Fit, kriging, scipy_linear, verde_cross_validated
from benchmarks.finished_runs import FinishedRuns
from benchmarks.scattered_data import survey_files, survey_samples
from benchmarks.timing import BenchmarkResult, Table, Track
from fieldrecon.datasets.elevation import terrain
from fieldrecon.reconstruction import Reconstruction
from fieldrecon.selection.cross_validation import NO_FIELD, CrossValidator, best
from fieldrecon.selection.error_bands import ErrorBand
from fieldrecon.selection.leaving_one_out import leave_one_out
from fieldrecon.selection.model_scores import ModelScore
from fieldrecon.selection.models import MODELS

KERNELS = ("linear", "thin_plate_spline", "cubic")
SMOOTHINGS = (0.0, 0.1, 1.0, 10.0, 100.0, 1000.0)
NEIGHBORS = 50
HELD_OUT = 0.2
TRACKS_APART = 10
FEW = 1000
PEERS: dict[str, Fit] = {
    "griddata": scipy_linear,
    "kriging": kriging,
    "verde": verde_cross_validated,
}
DENSE, MOST = ("kriging", "verde"), 5000
"""Peers with a dense matrix, and the largest number of samples that they take."""
COLUMNS = (
    *("survey", "held out", "samples", "splits", "ours / SciPy", "ours / best of each split"),
    *(f"ours / {name}" for name in PEERS),
    *("predicted / true", "covered", "width / constant", "s"),
)


@dataclass(frozen=True)
class Size:
    splits: int = 15
    splits_of_few: int = 40
    """Of surveys of fewer than 1000 samples, whose splits differ more."""
    samples: int = 2500
    """Of a larger survey, so many samples in its middle are measured, and the whole survey."""
    splits_of_whole: int = 5
    kept: Path | None = None
    """A file of the finished splits: a comparison that was interrupted goes on after them."""

    def of(self, count: int) -> int:
        """Number of splits of a survey with this number of samples."""
        if count > self.samples:
            return self.splits_of_whole
        return self.splits_of_few if count < FEW else self.splits


FULL = Size(kept=Path(__file__).parents[1] / "build" / "finished-surveys.jsonl")
QUICK = Size(2, 2, 1500, 0)
TOY = Size(1, 1, 200, 0)


def run(size: Size, track: Track) -> BenchmarkResult:
    samples, finished = surveys(size), FinishedRuns(size.kept)
    rows = []
    for name, how in track([(name, how) for name in samples for how in SPLITS], "surveys"):
        points, values = samples[name]
        splits = size.of(len(points))
        found = np.array([kept(finished, name, how, k, points, values) for k in range(splits)])
        to_kernels, others = np.split(found, [len(KERNELS)], axis=1)
        to_best = to_kernels.mean(axis=0).max(), to_kernels.max(axis=1).mean()
        rows.append((name, how, len(points), splits, *map(float, to_best), *map(_mean, others.T)))
    finished.forget()
    return BenchmarkResult(
        parameters={"neighbours of SciPy": NEIGHBORS, "samples at most": size.samples},
        tables=[Table("Means over the splits", COLUMNS, rows)],
        notes=[
            "Ratios are those of root mean square errors at the held-out samples. The error of the "
            "chosen method is predicted by cross-validation on the other samples. The width of the "
            "band is compared with the narrowest constant band of the same coverage. Of a large "
            "survey, the samples nearest to the middle are measured, and then all of it."
        ],
    )


def kept(
    finished: FinishedRuns, name: str, how: str, seed: int, points: np.ndarray, values: np.ndarray
) -> list[float]:
    """The numbers of a split, measured unless they are among the finished ones."""
    run = f"{name}, {how}, {seed}"
    if finished.get(run) is None:
        finished.add(run, measured(points, values, how, seed))
    return list(finished.get(run))


def _mean(numbers: np.ndarray) -> float | str:
    """The mean over the splits in which there is a number."""
    there = numbers[~np.isnan(numbers)]
    return float(there.mean()) if len(there) else "–"


def surveys(size: Size) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Samples and values by name: terrain along tracks, and files."""
    grid = terrain()
    rows = np.arange(grid.height.size).reshape(grid.height.shape)[::TRACKS_APART].ravel()
    height = grid.height.ravel().astype(float)
    found = {"terrain along tracks": (grid.points[rows], height[rows])}
    found |= {name: survey_samples(path) for name, path in survey_files().items()}
    parts = {name: nearby(*samples, size.samples) for name, samples in found.items()}
    if not size.splits_of_whole:
        return parts
    return parts | {f"{n}, whole": s for n, s in found.items() if len(s[0]) > size.samples}


def nearby(points: np.ndarray, values: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """The samples nearest to the middle of the samples, if there are more."""
    distance = np.linalg.norm(points - np.median(points, axis=0), axis=1)
    near = np.sort(np.argsort(distance, kind="stable")[:count])
    return points[near], values[near]


def at_random(points: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    return rng.random(len(points)) < HELD_OUT


def by_blocks(points: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Whole squares, about ten along each side."""
    side = np.ptp(points, axis=0).max() / 10
    return _some(np.unique(points // side, axis=0, return_inverse=True)[1].ravel(), rng)


def by_lines(points: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Whole strips across the second coordinate: lines, where samples lie along such."""
    low, size = points[:, 1].min(), np.ptp(points[:, 1])
    return _some(np.round((points[:, 1] - low) / size * 40).astype(int), rng)


def _some(label: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    own = np.unique(label)
    drawn = rng.choice(own, max(1, int(HELD_OUT * len(own))), replace=False)
    return np.isin(label, drawn)


SPLITS: dict[str, Callable[[np.ndarray, np.random.Generator], np.ndarray]] = {
    "random": at_random,
    "blocks": by_blocks,
    "lines": by_lines,
}


def measured(points: np.ndarray, values: np.ndarray, how: str, seed: int) -> tuple[float, ...]:
    """The numbers of one split: ratios to SciPy's kernels, and those of the other columns."""
    out = SPLITS[how](points, np.random.default_rng(seed))
    own, data, x, truth = points[~out], values[~out], points[out], values[out]
    began = process_time()
    validator = CrossValidator.of(own, data, x)
    score, (method, found) = best(
        validator.compare([*MODELS.values()]), lambda score: _fitted(score, own, data, x)
    )
    residuals = validator.residuals(score.maker)
    band = ErrorBand(own, validator.folds, residuals, _own_residuals(method, data))
    error, width = abs(found - truth), band(x)
    seconds = process_time() - began
    covered = float(np.mean(error <= width))
    true = rms(error)
    return (
        *(true / _error_of_scipy(kernel, own, data, x, truth) for kernel in KERNELS),
        *(
            np.nan if name in DENSE and len(own) > MOST else _ratio(error, fit, own, data, x, truth)
            for name, fit in PEERS.items()
        ),
        rms(residuals) / true,
        covered,
        float(width.mean() / np.quantile(error, covered)),
        seconds,
    )


def _fitted(
    score: ModelScore, points: np.ndarray, values: np.ndarray, x: np.ndarray
) -> tuple[Reconstruction, np.ndarray]:
    """The method on all samples, and the values of its field at the queries."""
    assert score.maker is not None, "a score without a method has a reason"
    method = score.maker(points)
    return method, method.field(values)(x)


def _own_residuals(method: Reconstruction, values: np.ndarray) -> np.ndarray | None:
    try:
        return leave_one_out(method, values)
    except NO_FIELD:
        return None


def _ratio(
    error: np.ndarray,
    fit: Fit,
    points: np.ndarray,
    values: np.ndarray,
    x: np.ndarray,
    truth: np.ndarray,
) -> float:
    """Our error over that of another method where it answers; NaN if it is not installed."""
    try:
        other = fit(points, values)(x) - truth
    except ImportError:
        return np.nan
    answered = np.isfinite(other)
    return rms(error[answered]) / rms(other[answered]) if answered.any() else np.nan


def _error_of_scipy(
    kernel: str, points: np.ndarray, values: np.ndarray, x: np.ndarray, truth: np.ndarray
) -> float:
    """The error, or infinity where the 50 samples nearest to a query are on one line."""
    try:
        return rms(scipy(kernel, points, values)(x) - truth)
    except np.linalg.LinAlgError:
        return np.inf


def scipy(kernel: str, points: np.ndarray, values: np.ndarray) -> RBFInterpolator:
    """SciPy's interpolant with the smoothing of least error in three-fold cross-validation."""
    fold = np.random.default_rng(0).permutation(len(points)) % 3
    make = {s: _scipy(kernel, s) for s in SMOOTHINGS}

    def error(smoothing: float) -> float:
        return rms(np.concatenate([*_misses(make[smoothing], points, values, fold)]))

    return make[min(SMOOTHINGS, key=error)](points, values)


def _scipy(kernel: str, smoothing: float) -> Callable[..., RBFInterpolator]:
    def make(points: np.ndarray, values: np.ndarray) -> RBFInterpolator:
        neighbors = min(NEIGHBORS, len(points))
        return RBFInterpolator(points, values, neighbors, smoothing, kernel)

    return make


def _misses(
    make: Callable[..., RBFInterpolator], points: np.ndarray, values: np.ndarray, fold: np.ndarray
) -> Iterator[np.ndarray]:
    for k in range(3):
        out = fold == k
        try:
            yield make(points[~out], values[~out])(points[out]) - values[out]
        except np.linalg.LinAlgError:  # too little smoothing for samples on one line
            yield np.array([np.inf])


def rms(residuals: np.ndarray) -> float:
    return float(np.sqrt(np.mean(residuals**2)))
