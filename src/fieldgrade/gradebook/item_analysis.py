"""Item analysis: difficulty and discrimination of each question, and common mistakes."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from html import escape
from itertools import groupby

import numpy as np

from fieldgrade.class_folder.csv_tables import to_csv
from fieldgrade.gradebook.explanations import OUTCOMES
from fieldgrade.gradebook.grade_sheets import GradeLine, GradeSheet
from fieldgrade.html_pages import page, table

FEWEST = 3
"""Smallest number of submissions for a correlation."""
MOST_MISTAKES = 3
LITTLE = 0.2
"""A discrimination below this value is marked."""
BAR = 7.0
"""Length of the bar of a question that everybody fails, in em."""

COLUMNS = ("Question", "Answers", "Failed", "Mean", "Discrimination", "Most common mistakes")
EXPLAINED = (
    "Failed: the share of answers without full points. Mean: the mean share of the points. "
    "Discrimination: the correlation of a question's points with those of the other questions of "
    "its notebook. A value below 0.2 says little; a negative value means that students who do "
    "worse on the other questions do better on this one, so the question should be reviewed."
)


@dataclass(frozen=True)
class ItemStatistics:
    """Statistics of a question.

    Parameters
    ----------
    question : str
        Its name.
    answers : int
        The number of graded answers.
    failed : float
        The share of answers without full points.
    mean : float
        The mean share of the points.
    discrimination : float, optional
        See `discrimination`.
    mistakes : tuple of (str, int)
        The most common mistakes with counts: recognized ones by name, others by their outcome.
    title : str
        The title of the question.
    """

    question: str
    answers: int
    failed: float
    mean: float
    discrimination: float | None
    mistakes: tuple[tuple[str, int], ...] = ()
    title: str = ""


def items(sheets: Iterable[GradeSheet]) -> list[ItemStatistics]:
    """Return the statistics of each question; answers that are not graded yet are left out."""
    handed_in = [sheet for sheet in sheets if sheet.record]
    notebooks = sorted({sheet.notebook for sheet in handed_in})
    return [
        item
        for notebook in notebooks
        for item in _items([sheet for sheet in handed_in if sheet.notebook == notebook])
    ]


def discrimination(scores: np.ndarray, rest: np.ndarray) -> float | None:
    """Return the correlation of a question's scores with those of all other questions.

    Let x be the scores of the question and y those of the other questions:

        r = Σ (x - x̄)(y - ȳ) / sqrt(Σ (x - x̄)² Σ (y - ȳ)²);

    For a question that is either right or wrong, r is the point-biserial correlation. The question
    itself is excluded from y, since it would raise r. A value below 0.2 says little; a question
    with a negative value should be reviewed.

    Returns
    -------
    float or None
        None if all scores are equal, or fewer than three answers were graded.

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


def to_table(found: Sequence[ItemStatistics]) -> str:
    """Return the analysis as CSV."""
    columns = ("question", "answers", "failed", "mean", "discrimination", "commonest mistakes")
    return to_csv(
        columns,
        ((i.question, i.answers, i.failed, i.mean, i.discrimination, _in_words(i)) for i in found),
    )


def _in_words(item: ItemStatistics) -> str:
    return "; ".join(f"{name} ({count})" for name, count in item.mistakes)


def _items(sheets: Sequence[GradeSheet]) -> Iterable[ItemStatistics]:
    """Yield the statistics of the questions of one notebook."""
    for index, first in enumerate(sheets[0].lines):
        graded = [sheet for sheet in sheets if sheet.lines[index].how != "open"]
        if not graded or first.possible == 0:
            continue
        lines = [sheet.lines[index] for sheet in graded]
        scores = np.array([line.points / line.possible for line in lines])
        rest = np.array([s.earned - s.lines[index].points * first.counts for s in graded])
        mistakes = Counter(filter(None, map(_mistake, lines)))
        yield ItemStatistics(
            first.question,
            len(graded),
            float(np.mean(scores < 1)),
            float(scores.mean()),
            discrimination(scores, rest),
            tuple(_commonest(mistakes)),
            first.title,
        )


def _commonest(mistakes: Counter[str]) -> list[tuple[str, int]]:
    return sorted(mistakes.items(), key=lambda pair: (-pair[1], pair[0]))[:MOST_MISTAKES]


def _mistake(line: GradeLine) -> str:
    """Return the recognized mistake of an answer, or its outcome."""
    if line.grade is None or line.grade.verdict.right:
        return ""
    return line.grade.verdict.mistake or OUTCOMES[line.grade.verdict.finding]


def analysis_page(
    found: Sequence[ItemStatistics],
    titles: Mapping[str, str],
    subtitle: str = "",
    attention: str = "",
) -> str:
    """Return the page with a table for each notebook.

    Parameters
    ----------
    found : sequence of ItemStatistics
        The statistics of the questions, in order.
    titles : mapping
        The titles of the notebooks.
    subtitle : str
        The numbers of notebooks and students.
    attention : str
        The address of the page of submissions that need the instructor's eyes.
    """
    link = f'<p><a href="{escape(attention)}">Submissions that need your eyes</a></p>'
    body = [link if attention else "", f"<p>{escape(EXPLAINED)}</p>"]
    for notebook, its in groupby(found, key=lambda item: item.question.partition(".")[0]):
        title = f"{notebook} {titles.get(notebook, '')}".strip()
        body.append(f"<h2>{escape(title)}</h2>{table(COLUMNS, map(_row, its), numbers=(1, 3, 4))}")
    return page("Statistics of the questions", subtitle, "\n".join(body))


def _row(item: ItemStatistics) -> tuple[str, ...]:
    bar = f'<span class="bar" style="width:{BAR * item.failed:.2f}em"></span>'
    return (
        escape(f"{item.question} {item.title}".strip()),
        str(item.answers),
        f'<span class="bars">{bar} {item.failed:.0%}</span>',
        f"{item.mean:.0%}",
        _discrimination(item),
        "<br>".join(f"{escape(name)} ({count})" for name, count in item.mistakes),
    )


def _discrimination(item: ItemStatistics) -> str:
    if item.discrimination is None:
        return "–"
    text = f"{item.discrimination:.2f}".replace("-", "−")
    return f"<mark>{text}</mark>" if item.discrimination < LITTLE else text
