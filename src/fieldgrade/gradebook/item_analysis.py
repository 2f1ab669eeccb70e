"""How the questions did: how many fail, whether they tell the good from the weak, and why."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from fieldgrade.class_folder.csv_tables import to_csv
from fieldgrade.gradebook.sheets import Line, Sheet

FEWEST = 3
"""A correlation over fewer submissions tells nothing."""
MOST_MISTAKES = 3


@dataclass(frozen=True)
class Item:
    """How a question did.

    Parameters
    ----------
    question : str
        Its name.
    answers : int
        Submissions to its notebook in which it was graded.
    failed : float
        The part of them that did not earn all points.
    mean : float
        The mean part of the points that was earned.
    discrimination : float, optional
        See `discrimination`.
    mistakes : tuple of (str, int)
        The commonest misconceptions, or the rungs reached where none was recognised, with counts.
    """

    question: str
    answers: int
    failed: float
    mean: float
    discrimination: float | None
    mistakes: tuple[tuple[str, int], ...] = ()


def items(sheets: Iterable[Sheet]) -> list[Item]:
    """Return how each question did, over all submissions; what nobody has read yet is left out."""
    handed_in = [sheet for sheet in sheets if sheet.record]
    notebooks = sorted({sheet.notebook for sheet in handed_in})
    return [
        item
        for notebook in notebooks
        for item in _items([sheet for sheet in handed_in if sheet.notebook == notebook])
    ]


def discrimination(scores: np.ndarray, rest: np.ndarray) -> float | None:
    """Return the correlation of a question's scores with those of all the others.

    With x the scores of the question and y those of the rest, over the same students,

        r = Σ (x - x̄)(y - ȳ) / sqrt(Σ (x - x̄)² Σ (y - ȳ)²);

    where a question is either right or wrong this is the point-biserial correlation. The question
    itself is not in the rest, which would raise r. Below 0.2 a question tells little, below zero it
    is answered better by those who do worse on the rest, and should be looked at.

    Returns
    -------
    float or None
        None where all have the same score, or fewer than three were graded.

    References
    ----------
    R. L. Ebel and D. A. Frisbie, Essentials of Educational Measurement (1991), chapter 13.

    Examples
    --------
    >>> discrimination(np.array([0.0, 0.0, 1.0, 1.0]), np.array([1.0, 2.0, 3.0, 4.0]))
    0.894427190999...
    """
    if len(scores) < FEWEST or np.ptp(scores) == 0 or np.ptp(rest) == 0:
        return None
    x, y = scores - scores.mean(), rest - rest.mean()
    return float(x @ y / np.sqrt((x @ x) * (y @ y)))


def to_table(found: Sequence[Item]) -> str:
    """Return the analysis as CSV."""
    columns = ("question", "answers", "failed", "mean", "discrimination", "commonest mistakes")
    return to_csv(
        columns,
        ((i.question, i.answers, i.failed, i.mean, i.discrimination, _in_words(i)) for i in found),
    )


def _in_words(item: Item) -> str:
    return "; ".join(f"{name} ({count})" for name, count in item.mistakes)


def _items(sheets: Sequence[Sheet]) -> Iterable[Item]:
    """Yield how the questions of one notebook did."""
    for index, first in enumerate(sheets[0].lines):
        graded = [sheet for sheet in sheets if sheet.lines[index].how != "open"]
        if not graded or first.possible == 0:
            continue
        lines = [sheet.lines[index] for sheet in graded]
        scores = np.array([line.points / line.possible for line in lines])
        rest = np.array([s.earned - s.lines[index].points for s in graded])
        mistakes = Counter(filter(None, map(_mistake, lines)))
        yield Item(
            first.question,
            len(graded),
            float(np.mean(scores < 1)),
            float(scores.mean()),
            discrimination(scores, rest),
            tuple(_commonest(mistakes)),
        )


def _commonest(mistakes: Counter[str]) -> list[tuple[str, int]]:
    return sorted(mistakes.items(), key=lambda pair: (-pair[1], pair[0]))[:MOST_MISTAKES]


def _mistake(line: Line) -> str:
    """Return the misconception of an answer, or how far it came."""
    if line.grade is None or line.grade.verdict.right:
        return ""
    return line.grade.verdict.mistake or line.grade.verdict.rung
