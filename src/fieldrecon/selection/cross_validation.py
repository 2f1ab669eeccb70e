"""Which method misses left-out samples least.

Up to some thousands of samples each is left out in turn, of all the others. Of more, a method is
judged at samples in the midst of blocks of neighbours, drawn at random: of their density and their
noise, as the whole cloud is, and enough for any method whose value depends on the samples near by.
A polynomial for the whole domain is fitted to these and to others drawn at random from all of it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from scipy.spatial import cKDTree

from fieldrecon.selection.leaving_one_out import leave_one_out
from fieldrecon.selection.models import Candidate, Maker

NO_FIELD = (ValueError, np.linalg.LinAlgError, MemoryError, OverflowError)
FEW = 8000
"""Samples of which each one is left out."""
EVERYWHERE = 40_000
"""Samples of more that a polynomial is fitted to."""
BLOCKS, BLOCK, MIDST = 24, 1000, 250
"""Blocks of samples, how many each has, and how many of these, the most central, are judged."""

Found = TypeVar("Found")


@dataclass(frozen=True, eq=False)
class Trial:
    """What came of a method on the samples: residuals where left out, or why there are none.

    Parameters
    ----------
    candidate : Candidate
    maker : callable, optional
        The variant that misses least; takes points to the method on these.
    residuals : ndarray of shape (m,), optional
        At the samples judged, each value less the field of all the others there.
    reason : str
        Why the method was not tried or does not exist, otherwise empty.
    """

    candidate: Candidate
    maker: Maker | None
    residuals: np.ndarray | None
    reason: str = ""

    @property
    def rms(self) -> float:
        """Root mean square of the residuals, in the unit of the values; infinite without any."""
        return np.inf if self.residuals is None else float(np.sqrt(np.mean(self.residuals**2)))

    @property
    def largest(self) -> float:
        """Largest residual in size."""
        return np.inf if self.residuals is None else float(np.abs(self.residuals).max())


@dataclass(frozen=True, eq=False)
class Judge:
    """Samples, and the blocks of them in whose midst methods are judged; none of few samples.

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
    def of(cls, points: np.ndarray, values: np.ndarray, seed: int = 0) -> Judge:
        """Draw the blocks, if there are more than a few samples."""
        n = len(points)
        if n <= FEW:
            return cls(points, values)
        rng = np.random.default_rng(seed)
        middles = points[rng.choice(n, BLOCKS, replace=False)]
        blocks = cKDTree(points).query(middles, BLOCK)[1]
        drawn = rng.choice(n, min(n, EVERYWHERE), replace=False)
        return cls(points, values, blocks, np.setdiff1d(drawn, blocks[:, :MIDST]))

    @property
    def judged(self) -> int:
        """How many samples are left out for each method, some perhaps in two blocks."""
        return len(self.points) if self.blocks is None else self.blocks[:, :MIDST].size

    def trial(self, candidate: Candidate, asked_for: bool = False) -> Trial:
        """Leave samples out and see how far the others miss them.

        A method that cannot be had on these points, or would take too long, says why.
        """
        if len(self.points) > candidate.most and not asked_for:
            most = f"{candidate.most:g}"
            return Trial(candidate, None, None, f"not tried on more than {most} samples unasked")
        trials, reason = [], ""
        for maker in candidate.makers(self.points):
            try:
                trials.append(Trial(candidate, maker, self._residuals(maker, candidate)))
            except NO_FIELD as error:
                reason = reason or str(error)
        if trials:
            return min(trials, key=lambda trial: trial.rms)
        return Trial(candidate, None, None, reason)

    def _residuals(self, maker: Maker, candidate: Candidate) -> np.ndarray:
        if self.blocks is None or self.everywhere is None:
            return leave_one_out(maker(self.points), self.values)
        if candidate.family == "LS":
            midst = self.blocks[:, :MIDST].ravel()
            own = np.append(np.unique(midst), self.everywhere)
            residuals = leave_one_out(maker(self.points[own]), self.values[own])
            return residuals[: len(own) - len(self.everywhere)]
        return np.concatenate([*self._in_blocks(maker, self.blocks)])

    def _in_blocks(self, maker: Maker, blocks: np.ndarray) -> Iterator[np.ndarray]:
        for block in blocks:
            yield leave_one_out(maker(self.points[block]), self.values[block])[:MIDST]


def best(trials: Sequence[Trial], attempt: Callable[[Trial], Found]) -> tuple[Trial, Found]:
    """Return the trial of least rms for which the attempt succeeds, and what came of it.

    Raises
    ------
    numpy.linalg.LinAlgError
        If there is none; the reason is that of the first, the simplest method.
    """
    reasons = [f"{trial.candidate.name}: {trial.reason}" for trial in trials if trial.reason]
    for trial in sorted(trials, key=lambda trial: trial.rms)[: len(trials) - len(reasons)]:
        try:
            return trial, attempt(trial)
        except NO_FIELD as error:
            reasons.append(f"{trial.candidate.name}: {error}")
    raise np.linalg.LinAlgError(f"no field from these samples by {reasons[0]}")
