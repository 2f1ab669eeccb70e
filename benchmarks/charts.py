"""Charts of results, drawn from the result files."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from itertools import cycle, product
from pathlib import Path
from typing import Any

from matplotlib.axes import Axes

from fieldrecon.plotting.style import FULL_WIDTH, NO_CLOCK, figure

# Colours for all kinds of colour vision (Okabe and Ito 2008), and markers for print in grey.
_COLORS = ("#000000", "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00")
_MARKERS = "so^Dv*"
_LOOKS = [
    {"linestyle": style, "color": color, "marker": marker}
    for style, (color, marker) in product("-:", zip(_COLORS, _MARKERS, strict=True))
]
_LEGEND_ROW = 0.22  # inches


def draw(result: Mapping, path: Path) -> None:
    """Draw the charts of a result side by side, with one legend, or two if the lines differ."""
    charts = result["charts"]
    shared = all([*chart["lines"]] == [*charts[0]["lines"]] for chart in charts)
    rows = 0 if shared else max(len(chart["lines"]) for chart in charts)
    height = 0.62 * FULL_WIDTH + _LEGEND_ROW * rows
    with figure(FULL_WIDTH, height, columns=len(charts), squeeze=False) as (page, axes):
        for chart, on in zip(charts, axes[0], strict=True):
            _lines(chart, on)
            if not shared:
                on.legend(loc="upper left", bbox_to_anchor=(0, -0.2), borderaxespad=0)
        if shared:
            page.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside lower left", ncols=2)
    page.savefig(path, format="svg", metadata={**NO_CLOCK["svg"], "Description": mark(result)})


def mark(result: Mapping) -> str:
    """A digest of the numbers shown, stored in the file of the chart."""
    numbers = json.dumps(result["charts"], sort_keys=True)
    return f"charts of sha256:{hashlib.sha256(numbers.encode()).hexdigest()}"


def _lines(chart: Mapping[str, Any], on: Axes) -> None:
    every: list[float] = []
    for (name, y), look in zip(chart["lines"].items(), cycle(_LOOKS), strict=False):
        x = chart["x"]
        x = x[name] if isinstance(x, Mapping) else x
        on.loglog(x, y, **look, label=name)
        every += x
    if max(every) < 10 * min(every):
        on.xaxis.set_major_formatter("{x:g}")
        on.xaxis.set_minor_formatter("{x:g}")
    on.set(title=chart["title"], xlabel=chart["x_label"], ylabel=chart["y_label"])
