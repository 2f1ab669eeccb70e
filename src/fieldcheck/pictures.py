"""A picture of the difference between an answer and the right one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from fieldcheck.answers import Answers
from fieldcheck.calls import Call, Outcome
from fieldcheck.figures import figure, svg
from fieldcheck.question import Picture, Question, unchanged
from fieldcheck.shapes import fitted
from fieldcheck.verdict import Verdict

FEWEST = 4
"""Smallest number of values for a picture."""
FEWEST_POINTS = 8
"""Smallest number of points for a picture of a field."""


def picture_of_difference(
    verdict: Verdict,
    question: Question,
    calls: Sequence[Call],
    outcomes: Sequence[Outcome],
    answers: Answers | None,
) -> Verdict:
    """Return the verdict with a picture, if the right values are known."""
    if answers is None or verdict.call is None or verdict.finding not in ("wrong", "misconception"):
        return verdict
    call, right = calls[verdict.call], answers.right[verdict.call]
    returned = outcomes[verdict.call].values
    values = () if returned is None else fitted(returned, question.shapes(call))
    if [v.shape for v in values] != [v.shape for v in right]:
        return verdict
    worst = max(range(len(right)), key=lambda i: float(np.abs(values[i] - right[i]).max(initial=0)))
    if right[worst].size < FEWEST or not np.isfinite(values[worst]).all():
        return verdict
    name = "right" if question.normal_form is unchanged else "one right answer"
    picture = _drawn(question.picture, call, values[worst], right[worst], name)
    return replace(verdict, picture=picture)


def _drawn(how: Picture, call: Call, values: np.ndarray, right: np.ndarray, name: str) -> str:
    if how == "polygon":
        return _polygons(values, right, name)
    if how == "sides":
        corners = np.asarray(call.arguments[0], float)
        middles = (corners.sum(axis=0) - corners) / 2
        return _arrows(middles, values, right, name, corners)
    points = _points(call, right)
    if points is not None:
        return (_dots if right.ndim == 1 else _arrows)(points, values, right, name)
    if values.ndim == 2 and min(values.shape) > 1:
        return _matrices(values, right, name)
    with figure(4.2, 1.7) as page:
        axes = page.subplots()
        axes.plot(right.ravel(), "o", mfc="none", color="black", label=name)
        axes.plot(values.ravel(), "x", color="#a33b00", label="yours")
        axes.set_xlabel("entry")
        axes.legend(frameon=False, loc="center left", bbox_to_anchor=(1, 0.5))
    return svg(page)


def _matrices(values: np.ndarray, right: np.ndarray, name: str) -> str:
    limit = float(max(np.abs(right).max(), np.abs(values).max())) or 1.0
    with figure(5.2, 1.9) as page:
        panels = page.subplots(1, 3)
        for axes, matrix, title in zip(
            panels, (values, right, values - right), ("yours", name, "difference"), strict=True
        ):
            image = axes.imshow(matrix, cmap="PuOr_r", vmin=-limit, vmax=limit, aspect="auto")
            axes.set(title=title, xticks=[], yticks=[])
        page.colorbar(image, ax=list(panels))
    return svg(page)


def _points(call: Call, right: np.ndarray) -> np.ndarray | None:
    """Return the points in the plane at which a field is evaluated; None if it is not a field."""
    is_field = right.ndim == 1 and len(right) >= FEWEST_POINTS
    if not is_field and right.shape[1:] != (2,):
        return None
    arrays = (a for a in call.arguments if isinstance(a, np.ndarray) and a.dtype.kind == "f")
    return next((a for a in arrays if a.shape == (len(right), 2)), None)


def _dots(points: np.ndarray, values: np.ndarray, right: np.ndarray, name: str) -> str:
    """Draw a scalar field: a dot at each point, coloured by the value."""
    limit = float(max(np.abs(right).max(), np.abs(values).max())) or 1.0
    with figure(5.6, 1.9) as page:
        panels = page.subplots(1, 3, sharex=True, sharey=True)
        for axes, field, title in zip(
            panels, (values, right, values - right), ("yours", name, "difference"), strict=True
        ):
            dots = axes.scatter(
                *points.T,
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


def _polygons(values: np.ndarray, right: np.ndarray, name: str) -> str:
    """Draw the right polygon and the student's, with the numbers of the rows at the corners."""
    with figure(4.4, 2.6) as page:
        axes = page.subplots()
        # The student's numbers are further out: the corners may be right, but in another order.
        for corners, marker, color, label, distance in (
            (right, "o", "black", name, 10),
            (values, "s", "#d9622b", "yours", 20),
        ):
            closed = np.append(corners, corners[:1], axis=0)
            axes.plot(*closed.T, marker=marker, mfc="none", color=color, lw=1, label=label)
            away = corners - corners.mean(axis=0)
            away /= np.maximum(np.hypot(*away.T), np.finfo(float).tiny)[:, np.newaxis]
            for row, (corner, direction) in enumerate(zip(corners, away, strict=True)):
                axes.annotate(
                    str(row),
                    corner,
                    distance * direction,
                    textcoords="offset points",
                    ha="center",
                    va="center",
                    color=color,
                    fontsize=8,
                )
        axes.set_axis_off()
        axes.set_aspect("equal")
        axes.margins(0.2)
        axes.legend(frameon=False, loc="center left", bbox_to_anchor=(1, 0.5))
    return svg(page)


def _arrows(
    points: np.ndarray,
    values: np.ndarray,
    right: np.ndarray,
    name: str,
    outline: np.ndarray | None = None,
) -> str:
    """Draw a vector field: at each point the right arrow and the student's, and an outline."""
    seen = points if outline is None else np.concatenate([points, outline])
    extent = float(np.ptp(seen, axis=0).max()) or 1.0
    longest = float(np.hypot(*np.concatenate([right, values]).T).max()) or 1.0
    scale = 4 * longest / extent
    how: Any = {"angles": "xy", "scale_units": "xy", "scale": scale}
    with figure(4.4, 2.6) as page:
        axes = page.subplots()
        axes.plot(*points.T, ".", color="#8a8a8a", markersize=3)
        if outline is not None:
            axes.fill(*outline.T, fill=False, edgecolor="#8a8a8a")
        axes.quiver(*points.T, *right.T, color="black", label=name, width=0.014, **how)
        axes.quiver(*points.T, *values.T, color="#d9622b", label="yours", width=0.007, **how)
        axes.update_datalim(np.concatenate([points + right / scale, points + values / scale]))
        axes.set(xticks=[], yticks=[], aspect="equal")
        axes.margins(0.1)
        axes.legend(frameon=False, loc="center left", bbox_to_anchor=(1, 0.5))
    return svg(page)
