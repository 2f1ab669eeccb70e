"""A small drawing of where an answer differs from the right one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from fieldcheck.answers import Answers
from fieldcheck.calls import Call, Outcome
from fieldcheck.figures import figure, svg
from fieldcheck.question import Question
from fieldcheck.shapes import fitted
from fieldcheck.verdict import Verdict

FEWEST = 4
"""Fewer numbers than these need no picture."""
FEWEST_PLACES = 8
"""A field at fewer places is drawn entry by entry."""


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
    return replace(verdict, picture=_drawn(call, values[worst], right[worst]))


def _drawn(call: Call, values: np.ndarray, right: np.ndarray) -> str:
    places = _places(call, right)
    if places is not None:
        return (_dots if right.ndim == 1 else _arrows)(places, values, right)
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


def _places(call: Call, right: np.ndarray) -> np.ndarray | None:
    """Return the places in the plane at which a field is asked for, if that is what is returned."""
    is_field = right.ndim == 1 and len(right) >= FEWEST_PLACES
    if not is_field and right.shape[1:] != (2,):
        return None
    arrays = (a for a in call.arguments if isinstance(a, np.ndarray) and a.dtype.kind == "f")
    return next((a for a in arrays if a.shape == (len(right), 2)), None)


def _dots(places: np.ndarray, values: np.ndarray, right: np.ndarray) -> str:
    """Draw a field of numbers: at each place a dot whose colour is the value."""
    limit = float(max(np.abs(right).max(), np.abs(values).max())) or 1.0
    with figure(5.6, 1.9) as page:
        panels = page.subplots(1, 3, sharex=True, sharey=True)
        for axes, field, title in zip(
            panels, (values, right, values - right), ("yours", "right", "difference"), strict=True
        ):
            dots = axes.scatter(
                *places.T,
                c=field,
                cmap="PuOr_r",
                vmin=-limit,
                vmax=limit,
                s=36,
                edgecolors="#555555",
                linewidths=0.6,
            )
            axes.set(title=title, xticks=[], yticks=[], aspect="equal")
            axes.margins(0.12)
        page.colorbar(dots, ax=list(panels))
    return svg(page)


def _arrows(places: np.ndarray, values: np.ndarray, right: np.ndarray) -> str:
    """Draw a field of vectors: at each place an arrow, the student's over the right one."""
    extent = float(np.ptp(places, axis=0).max()) or 1.0
    longest = float(np.hypot(*np.concatenate([right, values]).T).max()) or 1.0
    scale = 4 * longest / extent
    how: Any = {"angles": "xy", "scale_units": "xy", "scale": scale}
    with figure(4.4, 2.6) as page:
        axes = page.subplots()
        axes.plot(*places.T, ".", color="#8a8a8a", markersize=3)
        axes.quiver(*places.T, *right.T, color="black", label="right", width=0.014, **how)
        axes.quiver(*places.T, *values.T, color="#d9622b", label="yours", width=0.007, **how)
        axes.update_datalim(np.concatenate([places + right / scale, places + values / scale]))
        axes.set(xticks=[], yticks=[], aspect="equal")
        axes.margins(0.1)
        axes.legend(frameon=False, loc="center left", bbox_to_anchor=(1, 0.5))
    return svg(page)
