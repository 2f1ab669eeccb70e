"""A small drawing of where an answer differs from the right one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from fieldcheck.answers import Answers
from fieldcheck.calls import Call, Outcome
from fieldcheck.figures import figure, svg
from fieldcheck.question import Question
from fieldcheck.shapes import fitted
from fieldcheck.verdict import Verdict

FEWEST = 4
"""Fewer numbers than these need no picture."""


def picture_of_difference(
    verdict: Verdict,
    question: Question,
    calls: Sequence[Call],
    outcomes: Sequence[Outcome],
    answers: Answers | None,
) -> Verdict:
    """Return the verdict with a picture, where there are right numbers to show beside it."""
    if answers is None or verdict.call is None or verdict.rung not in ("wrong", "misconception"):
        return verdict
    call, right = calls[verdict.call], answers.right[verdict.call]
    returned = outcomes[verdict.call].values
    values = () if returned is None else fitted(returned, question.shapes(call))
    if [v.shape for v in values] != [v.shape for v in right]:
        return verdict
    worst = max(range(len(right)), key=lambda i: float(np.abs(values[i] - right[i]).max(initial=0)))
    if right[worst].size < FEWEST or not np.isfinite(values[worst]).all():
        return verdict
    return replace(verdict, picture=_drawn(values[worst], right[worst]))


def _drawn(values: np.ndarray, right: np.ndarray) -> str:
    if values.ndim == 2 and min(values.shape) > 1:
        return _matrices(values, right)
    with figure(4.2, 1.7) as page:
        axes = page.subplots()
        axes.plot(right.ravel(), "o", mfc="none", color="black", label="right")
        axes.plot(values.ravel(), "x", color="#a33b00", label="yours")
        axes.set_xlabel("entry")
        axes.legend(frameon=False, loc="center left", bbox_to_anchor=(1, 0.5))
    return svg(page)


def _matrices(values: np.ndarray, right: np.ndarray) -> str:
    limit = float(max(np.abs(right).max(), np.abs(values).max())) or 1.0
    with figure(5.2, 1.9) as page:
        panels = page.subplots(1, 3)
        for axes, matrix, title in zip(
            panels, (values, right, values - right), ("yours", "right", "difference"), strict=True
        ):
            image = axes.imshow(matrix, cmap="PuOr_r", vmin=-limit, vmax=limit, aspect="auto")
            axes.set(title=title, xticks=[], yticks=[])
        page.colorbar(image, ax=list(panels))
    return svg(page)
