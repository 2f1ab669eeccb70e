"""Charts of results, drawn from what is written down of them."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from itertools import cycle
from pathlib import Path
from typing import Any

from matplotlib.axes import Axes

from fieldrecon.reporting.style import FULL_WIDTH, NO_CLOCK, figure

# Colours that differ for every kind of sight (Okabe and Ito 2008), and markers for grey print.
_COLORS = ("#000000", "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00")
_MARKERS = "so^Dv*"


def draw(result: Mapping, path: Path) -> None:
    """Draw the charts of a result side by side, with one legend below."""
    charts = result["charts"]
    with figure(FULL_WIDTH, 0.62 * FULL_WIDTH, columns=len(charts), squeeze=False) as (page, axes):
        for chart, on in zip(charts, axes[0], strict=True):
            _lines(chart, on)
        page.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside lower left", ncols=2)
    page.savefig(path, format="svg", metadata={**NO_CLOCK["svg"], "Description": mark(result)})


def mark(result: Mapping) -> str:
    """What a drawing bears to tell which numbers it shows."""
    numbers = json.dumps(result["charts"], sort_keys=True)
    return f"charts of sha256:{hashlib.sha256(numbers.encode()).hexdigest()}"


def _lines(chart: Mapping[str, Any], on: Axes) -> None:
    looks = zip(cycle(_COLORS), cycle(_MARKERS), strict=False)
    for (name, y), (color, marker) in zip(chart["lines"].items(), looks, strict=False):
        on.loglog(chart["x"], y, color=color, marker=marker, label=name)
    on.set(title=chart["title"], xlabel=chart["x_label"], ylabel=chart["y_label"])
