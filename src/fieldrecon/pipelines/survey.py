"""What came of a reconstruction, and what its reader should know, in sentences."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from fieldrecon._core.memory import memory_used
from fieldrecon.io.netcdf import Result
from fieldrecon.pipelines.samples import Samples
from fieldrecon.reconstruction import Field
from fieldrecon.selection.cross_validation import ModelScore
from fieldrecon.selection.extrapolation import GAP, OUTSIDE
from fieldrecon.selection.prediction_intervals import COVERAGE, ErrorEstimate


@dataclass(frozen=True, eq=False)
class Outcome:
    """A field from samples, its values at places, and how it came about.

    Parameters
    ----------
    source : str
        The file that the samples, or the field, came from.
    samples : Samples
    trials : sequence of ModelScore
        Methods that were judged; none of a field that was loaded.
    judged : int
        Samples that were left out for each of them.
    chosen : ModelScore, optional
        The method that was taken.
    field : Field
    band : ErrorEstimate or str
        How far the field may be off, or why that is not known.
    result : Result
    seconds : float
        From the first row to the last value.
    memory : int, optional
        Most bytes that the program has used so far, where the system reports them.
    """

    source: str
    samples: Samples
    trials: Sequence[ModelScore]
    judged: int
    chosen: ModelScore | None
    field: Field
    band: ErrorEstimate | str
    result: Result
    seconds: float
    memory: int | None

    @property
    def method(self) -> str:
        """What was evaluated."""
        if self.chosen is None:
            return f"the field of {self.source}"
        return f"{self.chosen.model.name}, {self.chosen.model.meaning}"

    @property
    def ranked(self) -> list[ModelScore]:
        """The trials, the one that misses least first."""
        return sorted(self.trials, key=lambda trial: trial.rms)

    @property
    def remarks(self) -> list[str]:
        """What a reader should beware of."""
        return [*self.samples.remarks, *self._of_places(), self._of_error()]

    def _of_places(self) -> Iterator[str]:
        result, kind = self.result, self.result.places.kind
        if bad := result.places.bad:
            rows = "row is" if len(bad) == 1 else "rows are"
            yield f"{len(bad)} {rows} no place; the first, line {bad[0].line}: {bad[0].reason}."
        outside = np.count_nonzero(result.extrapolated == OUTSIDE)
        hull = "the hull" if result.lonlat else "the convex hull"
        yield f"{outside} of {len(result.values)} {kind} lie outside {hull} of the samples."
        gaps = np.count_nonzero(result.extrapolated == GAP)
        yield f"{gaps} {kind} lie in gaps between them. All these are extrapolated, and marked."

    def _of_error(self) -> str:
        if isinstance(self.band, str):
            return f"How far the field may be off is not known: {self.band}."
        typical = float(np.median(self.result.error))
        return (
            f"The error given is that which {100 * COVERAGE:.0f} of 100 samples keep below when "
            f"they are left out: {self.band.factor:.3g} times the root mean square by which the "
            f"{self.band.neighbors} samples nearest to a place are missed; half of the "
            f"{self.result.places.kind} have less than {typical:.3g}. "
            "Where extrapolated, it promises nothing."
        )

    @property
    def cost(self) -> str:
        """Time and memory."""
        return f"{self.seconds:.1f} s{memory_used(self.memory, ' of memory')}"
