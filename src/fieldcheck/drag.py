"""An interactive picture: a point that the reader drags in a cell, and the weights of the corners.

The weights are computed in advance, on a lattice that covers the cell, and interpolated. The
picture is an SVG; a short script makes it interactive where scripts run: in JupyterLab, in Visual
Studio Code and on the published page. It needs neither a network nor a kernel.
"""

from __future__ import annotations

import base64
import json
from collections.abc import Callable
from dataclasses import dataclass
from importlib.resources import files
from typing import Any

import numpy as np

from fieldcheck.figures import BLUE, GREY, ORANGE, PURPLE, attempt, display

NODES = 36
"""Nodes of the lattice along the longer side of the cell."""
UNIT = 1e-4
"""Weights are stored as multiples of this value."""
SIDE, WIDTH, MARGIN = 300.0, 640, 48.0
"""The cell is drawn in a square of this side, in a picture of this width; in pixels."""

Weights = Callable[[np.ndarray], np.ndarray]


def drag(corners: Any, values: Any, start: Any) -> Callable[[Weights], Weights]:
    """Show the weights of the corners of a cell at a point that the reader can drag.

    Parameters
    ----------
    corners : (N, 2) array_like
        Corners of the cell, a convex polygon, in order.
    values : (N,) array_like
        Values at the corners.
    start : (2,) array_like
        The initial point, which the static picture shows.

    Examples
    --------
    The function takes points, of shape (M, 2), and returns weights, of shape (M, N)::

        @drag(corners, values, start=(0.2, 0.1))
        def weights(x):
            return ...
    """

    def show(weights: Weights) -> Weights:
        display(attempt(lambda: dragged(weights, corners, values, start)))
        return weights

    return show


@dataclass(frozen=True)
class Dragged:
    """The picture as HTML, with its script, and as SVG alone."""

    html: str
    svg: str

    def _repr_mimebundle_(self, **_: object) -> dict[str, str]:
        return {"text/html": self.html, "image/svg+xml": self.svg, "text/plain": "a picture"}


def dragged(weights: Weights, corners: Any, values: Any, start: Any) -> Dragged:
    """Return the picture of the weights, and the script that makes it interactive."""
    p, f = np.asarray(corners, dtype=float), np.asarray(values, dtype=float)
    x = np.asarray(start, dtype=float)
    here = np.asarray(weights(x[None]), dtype=float)[0]
    parameters = lattice(weights, p) | {
        "corners": np.round(p, 6).tolist(),
        "values": np.round(f, 6).tolist(),
        "walls": np.round(walls(p), 6).tolist(),
        "at": np.round(x, 6).tolist(),
        "frame": np.round(_frame(p), 6).tolist(),
    }
    text = _svg(p, f, x, here)
    image = base64.b64encode(text.encode("ascii")).decode()
    data = json.dumps(parameters, separators=(",", ":"))
    script = (files("fieldcheck") / "drag.js").read_text(encoding="utf-8")
    html = (
        '<div class="fieldcheck-drag" style="max-width:640px">'
        f'<img alt="A cell, a point in it, and the weights of the {len(p)} corners" '
        f'style="max-width:100%" src="data:image/svg+xml;base64,{image}">'
        f"<script>{script.replace('DATA', data)}</script></div>"
    )
    return Dragged(html, text)


def lattice(weights: Weights, corners: np.ndarray) -> dict[str, Any]:
    """Return the weights on a lattice over the cell: origin, step, nodes in a row, the table.

    Rows of the table are integer multiples of `UNIT`; a zero marks a node that is too far from the
    cell, or whose weights are not finite.
    """
    low, high = corners.min(axis=0), corners.max(axis=0)
    step = float((high - low).max()) / (NODES - 3)
    # No node lies on the middle lines or on axis-parallel edges, where quotients are undefined.
    origin = low - 1.37 * step
    along = np.ceil((high - origin) / step).astype(int) + 2
    i, j = np.meshgrid(np.arange(along[0]), np.arange(along[1]))
    nodes = origin + step * np.stack([i.ravel(), j.ravel()], axis=1)
    a, b, reach = walls(corners).T
    of_use = (nodes @ np.stack([a, b]) <= reach + 1.5 * step).all(axis=1)
    table: list[Any] = [0] * len(nodes)
    for k, row in zip(np.flatnonzero(of_use), np.asarray(weights(nodes[of_use])), strict=True):
        if np.isfinite(row).all():
            table[k] = np.rint(row / UNIT).astype(int).tolist()
    return {"origin": origin.tolist(), "step": step, "across": int(along[0]), "table": table}


def walls(corners: np.ndarray) -> np.ndarray:
    """Return rows (a, b, c) of the half-planes a x + b y ≤ c, with (a, b) of length one."""
    ahead = np.array([*corners[1:], corners[0]]) - corners
    normal = ahead @ [[0, -1], [1, 0]] / np.hypot(*ahead.T)[:, None]
    outward = np.sign(np.einsum("ak,ak->a", normal, corners - corners.mean(axis=0)))
    normal *= outward[:, None]
    return np.column_stack([normal, np.einsum("ak,ak->a", normal, corners)])


def _frame(corners: np.ndarray) -> np.ndarray:
    """Return (s, u, v): a point (x, y) is drawn at (s x + u, v − s y)."""
    low, high = corners.min(axis=0), corners.max(axis=0)
    scale = SIDE / float((high - low).max())
    middle = scale * (low + high) / 2
    center = MARGIN + SIDE / 2
    return np.array([scale, center - middle[0], center + middle[1]])


def _svg(p: np.ndarray, f: np.ndarray, x: np.ndarray, w: np.ndarray) -> str:
    """Return the picture; elements that the script moves have a ``data-part``."""
    scale, u, v = _frame(p)
    at = np.stack([scale * p[:, 0] + u, v - scale * p[:, 1]], axis=1)
    px, py = scale * x[0] + u, v - scale * x[1]
    mx, my = w @ at
    away = at - at.mean(axis=0)
    outward = at + 35 * away / np.hypot(*away.T)[:, None]
    height = SIDE + 2 * MARGIN
    outline = " ".join(f"{a:.1f},{b:.1f}" for a, b in at)
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height:g}" '
        f'width="{WIDTH}" height="{height:g}" font-family="sans-serif" font-size="14">',
        f'<rect width="{WIDTH}" height="{height:g}" rx="6" fill="white"/>',
        f'<polygon points="{outline}" fill="#f3f3ee" stroke="{GREY}" stroke-width="1.5"/>',
    ]
    row = min(34.0, 230 / len(p))
    top = 76.0
    lines.append(
        f'<g fill="#333"><text x="404" y="{top - 26}">corner</text>'
        f'<text x="470" y="{top - 26}">weight &#969;</text>'
        f'<text x="630" y="{top - 26}" text-anchor="end">value &#966;</text></g>'
    )
    for k, (corner, label) in enumerate(zip(at, outward, strict=True)):
        y = top + k * row
        lines += [
            f'<line data-part="ray{k}" x1="{px:.1f}" y1="{py:.1f}" x2="{corner[0]:.1f}" '
            f'y2="{corner[1]:.1f}" stroke="{BLUE}" stroke-opacity="0.35"/>',
            f'<circle cx="{corner[0]:.1f}" cy="{corner[1]:.1f}" r="3" fill="#333"/>',
            f'<circle data-part="dot{k}" cx="{corner[0]:.1f}" cy="{corner[1]:.1f}" '
            f'r="{_radius(w[k]):.2f}" fill="{BLUE}" fill-opacity="0.75"/>',
            f'<text x="{label[0]:.1f}" y="{label[1] + 5:.1f}" text-anchor="middle" '
            f'fill="#333">{k}</text>',
            f'<text x="426" y="{y + 5:.1f}" text-anchor="middle" fill="#333">{k}</text>',
            f'<rect x="448" y="{y - 8:.1f}" width="92" height="16" fill="#ececec"/>',
            f'<rect data-part="bar{k}" x="448" y="{y - 8:.1f}" width="{_bar(w[k]):.2f}" '
            f'height="16" fill="{BLUE}"/>',
            f'<text data-part="number{k}" x="584" y="{y + 5:.1f}" text-anchor="end" '
            f'fill="#333">{w[k]:.3f}</text>',
            f'<text x="630" y="{y + 5:.1f}" text-anchor="end" fill="#333">{f[k]:.2g}</text>',
        ]
    y = top + len(p) * row + 14
    lines += [
        f'<text data-part="sum" x="404" y="{y:.1f}" fill="#333">sum of the weights '
        f"{w.sum():.3f}</text>",
        f'<text data-part="value" x="404" y="{y + 28:.1f}" fill="{PURPLE}" font-size="17" '
        f'font-weight="bold">value at the point {w @ f:.3f}</text>',
        f'<text data-part="hint" x="404" y="{height - 16:g}" fill="#333" font-size="12" '
        'visibility="hidden">drag the point, or use the arrow keys</text>',
        f'<circle data-part="point" cx="{px:.1f}" cy="{py:.1f}" r="8" fill="{ORANGE}"/>',
        f'<circle data-part="mean" cx="{mx:.1f}" cy="{my:.1f}" r="12" fill="none" '
        f'stroke="{PURPLE}" stroke-width="2"/>',
        "</svg>",
    ]
    return "\n".join(lines)


def _radius(weight: float) -> float:
    return float(26 * np.sqrt(np.clip(weight, 0, 1)))


def _bar(weight: float) -> float:
    return float(92 * np.clip(weight, 0, 1))
