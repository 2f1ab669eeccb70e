"""The style of all figures: fonts of the text, printed width, colours and lines of the methods.

``figure`` opens a figure whose style travels with it: drawing and saving need nothing else.

>>> with figure(columns=2) as (page, axes):
...     _ = axes[0].plot([0, 1], [0, 1], **line("MLS"))
>>> round(float(page.get_figwidth()), 2)
5.91
"""

from __future__ import annotations

import io
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import cache
from itertools import cycle
from types import MappingProxyType
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib import font_manager
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_hex, to_rgb
from matplotlib.figure import Figure

from fieldrecon.plotting.fonts import SERIF, SERIF_FACES, font_file
from fieldrecon.plotting.maps import SHADE, hillshade, map_axes, scale_bar

__all__ = [
    "BLACK_ON_MAP",
    "DIVERGING",
    "FULL_WIDTH",
    "HALF_WIDTH",
    "METHOD_COLORS",
    "METHOD_LINESTYLES",
    "METHOD_MARKERS",
    "PLAIN_NUMBERS",
    "SEQUENTIAL",
    "SHADE",
    "WHITE_ON_MAP",
    "StyledFigure",
    "figure",
    "hillshade",
    "hues",
    "line",
    "map_axes",
    "scale_bar",
    "shades",
    "style",
]

MILLIMETRE = 1 / 25.4
FULL_WIDTH = 150 * MILLIMETRE
HALF_WIDTH = 73 * MILLIMETRE
"""Widths in inches: the text block of the PDF, and two figures beside each other with a gap."""

METHOD_COLORS = {
    "LS": "#c48600",
    "MLS": "#2a78bb",
    "PU": "#2a6428",
    "RBF": "#5f1049",
    "truth": "#000000",
    "data": "#000000",
}
"""A colour for each method. The lightness differs by ten or more, for printing in grey."""

METHOD_LINESTYLES: Mapping[str, Any] = {
    "LS": (0, (5, 1.5)),
    "MLS": "-",
    "PU": (0, (1, 1.2)),
    "RBF": (0, (6, 1.5, 1, 1.5)),
    "truth": "-",
    "data": "none",
}
HUES = [
    "#000000",
    "#c48600",
    "#2a78bb",
    "#c0392b",
    "#2a6428",
    "#8e5bb5",
    "#3aa6a0",
    "#7a7a7a",
    "#5f1049",
    "#7d4a1e",
]
"""Colours of variants. Neighbours differ in lightness; dashes and markers differ as well."""

DASHES: Sequence[Any] = ("-", (0, (5, 1.5)), (0, (1, 1.2)), (0, (6, 1.5, 1, 1.5)))
MARKERS = "os^Dv*"
"""Dashes and markers of variants, in turn."""

METHOD_MARKERS = {"LS": "s", "MLS": "o", "PU": "D", "RBF": "^", "truth": "", "data": "."}

SEQUENTIAL = "viridis"
"""Colour map for amounts: perceptually even, rises in grey."""
DIVERGING = "PuOr_r"
"""Colour map for signed errors, centred at zero; negative contours are dashed, for grey."""
BLACK_ON_MAP, WHITE_ON_MAP = "#010101", "#fefefe"
"""Lines and veils on a map of colours: they stay on a dark page, as the map does."""
RC: Any = {
    "font.family": SERIF,
    "font.size": 9,
    "axes.titlesize": 9,
    "axes.labelsize": 9,
    "figure.titlesize": 9,
    "legend.fontsize": 8,
    "xtick.labelsize": 8,
    "ytick.labelsize": 8,
    "mathtext.fontset": "custom",
    "mathtext.rm": SERIF,
    "mathtext.sf": SERIF,
    "mathtext.tt": "DejaVu Sans Mono",
    "mathtext.cal": f"{SERIF}:italic",
    "mathtext.it": f"{SERIF}:italic",
    "mathtext.bf": f"{SERIF}:bold",
    "mathtext.bfit": f"{SERIF}:bold",
    "mathtext.fallback": "stix",
    "axes.formatter.use_mathtext": True,
    "axes.titlelocation": "left",
    "axes.linewidth": 0.6,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#dcdcdc",
    "grid.linewidth": 0.5,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "xtick.minor.width": 0.4,
    "ytick.minor.width": 0.4,
    "lines.linewidth": 1.3,
    "lines.markersize": 3.8,
    "patch.linewidth": 0.6,
    "contour.negative_linestyle": "dashed",
    "contour.linewidth": 0.8,
    "legend.edgecolor": "none",
    "legend.framealpha": 0.85,
    "legend.borderpad": 0.2,
    "legend.handlelength": 2.6,
    "image.cmap": SEQUENTIAL,
    "image.interpolation": "nearest",
    "image.origin": "lower",
    "figure.facecolor": "white",
    "figure.dpi": 150,
    "savefig.dpi": 200,
    "svg.fonttype": "path",
    "svg.hashsalt": "fieldrecon",
    "svg.id": None,
    "pdf.fonttype": 3,
    "text.usetex": False,
}

PLAIN_NUMBERS: Mapping[str, Any] = {"axes.formatter.use_mathtext": False}
"""Numbers at the axes as text: formulas take nearly a tenth of the time of a reconstruction."""

NO_CLOCK: Mapping[str, Mapping[str, None]] = {
    "svg": {"Date": None, "Creator": None},
    "pdf": {"CreationDate": None, "Creator": None, "Producer": None},
    "png": {"Software": None},
}
"""Metadata of each format that are omitted, since they would make two builds differ."""


class StyledFigure(Figure):
    """A figure that is drawn and saved in the style of the report, whatever the caller's settings.

    Saved as SVG, PDF or PNG it gives the same bytes every time.
    """

    svg_fonttype = "path"
    """Letters in an SVG: paths, which look the same everywhere, or ``"none"``: text, for a page
    that has the fonts."""

    def draw(self, renderer: Any) -> None:
        """Draw in the style of the report."""
        with style({"svg.fonttype": self.svg_fonttype}):
            super().draw(renderer)

    def _repr_png_(self) -> bytes:
        """Show the figure in a notebook, also before Matplotlib is set up there."""
        buffer = io.BytesIO()
        self.savefig(buffer, format="png")
        return buffer.getvalue()

    def savefig(self, fname: Any, **options: Any) -> None:
        """Save in the style of the report, without a date; `options` as in Matplotlib."""
        kind = options.get("format") or str(fname).rpartition(".")[2]
        options.setdefault("metadata", NO_CLOCK.get(kind))
        with style({"svg.fonttype": self.svg_fonttype}):
            super().savefig(fname, **options)


@contextmanager
def style(changes: Any = MappingProxyType({})) -> Iterator[None]:
    """Give Matplotlib the style of the report inside the ``with``, whatever the user's settings.

    Parameters
    ----------
    changes : mapping
        Settings of Matplotlib that differ from those of the report.
    """
    _register_fonts()
    with mpl.rc_context():
        mpl.rcdefaults()
        mpl.rcParams.update({**RC, **changes})
        yield


@contextmanager
def figure(
    width: float = FULL_WIDTH,
    height: float | None = None,
    *,
    rows: int = 1,
    columns: int = 1,
    settings: Any = MappingProxyType({}),
    **subplots: Any,
) -> Iterator[tuple[Figure, Any]]:
    """Figure and axes in the style of the report.

    Parameters
    ----------
    width, height : float
        Inches, as printed. The height defaults to rows of golden rectangles.
    rows, columns : int
        Number of axes; one gives the `Axes` itself, more give an array as ``Figure.subplots``.
    settings : mapping
        Settings of Matplotlib that differ from those of the report while it is drawn.
    **subplots
        Passed to ``Figure.subplots``: `sharex`, `sharey`, `width_ratios`, `subplot_kw` and so on.

    Yields
    ------
    tuple
        The figure and its axes. Draw inside the ``with``; save whenever you like.
    """
    height = height or 0.62 * width * rows / columns + 0.25
    with style(settings):
        page = StyledFigure(figsize=(width, height), layout="constrained")
        FigureCanvasAgg(page)
        yield page, page.subplots(rows, columns, **subplots)
        # solved once: every later solution would start from this one and differ in the last bits;
        # "none" instead of None would keep a placeholder, which asks for another drawing
        if layout := page.get_layout_engine():  # a picture may have set another one
            layout.execute(page)
        page.set_layout_engine(None)


def line(method: str, **changes: Any) -> dict[str, Any]:
    """Colour, line style and marker of a method, as keywords for ``Axes.plot``.

    Parameters
    ----------
    method : str
        A key of `METHOD_COLORS`.
    **changes
        Keywords added or replaced, such as ``marker=""`` for a curve of many points.

    Returns
    -------
    dict

    Examples
    --------
    >>> line("MLS")["color"]
    '#2a78bb'
    """
    look = {
        "color": METHOD_COLORS[method],
        "linestyle": METHOD_LINESTYLES[method],
        "marker": METHOD_MARKERS[method],
        "label": method,
    }
    return look | ({"linewidth": 0.9} if method == "truth" else {}) | changes


def shades(method: str, count: int, **changes: Any) -> list[dict[str, Any]]:
    """Distinguish `count` variants of one method by shades of its colour and by markers.

    Parameters
    ----------
    method : str
        A key of `METHOD_COLORS`; ``"truth"`` gives greys for families of other curves.
    count : int
        Number of variants.
    **changes
        Keywords added to each.

    Returns
    -------
    list of dict
        Keywords for ``Axes.plot``.

    Examples
    --------
    >>> [look["marker"] for look in shades("RBF", 3)]
    ['o', 's', '^']
    """
    tints = np.linspace(-0.45, 0.45, count) if count > 1 else [0.0]
    return [
        {"color": _tint(METHOD_COLORS[method], tint), "linestyle": dash, "marker": marker} | changes
        for tint, dash, marker in zip(tints, cycle(DASHES), cycle(MARKERS), strict=False)
    ]


def hues(count: int, **changes: Any) -> list[dict[str, Any]]:
    """Distinguish `count` variants by colours of their own, where only variants are compared.

    Parameters
    ----------
    count : int
        Number of variants; the eleventh has the colour of the first with another dash.
    **changes
        Keywords added to each.

    Returns
    -------
    list of dict
        Keywords for ``Axes.plot``.

    Examples
    --------
    >>> [look["color"] for look in hues(3)]
    ['#000000', '#c48600', '#2a78bb']
    """
    return [
        {"color": hue, "linestyle": dash, "marker": marker} | changes
        for hue, dash, marker, _ in zip(
            cycle(HUES), cycle(DASHES), cycle(MARKERS), range(count), strict=False
        )
    ]


def _tint(color: str, amount: float) -> str:
    """Mix a colour with white (amount > 0) or black (amount < 0)."""
    target = np.ones(3) if amount > 0 else np.zeros(3)
    red, green, blue = np.array(to_rgb(color)) * (1 - abs(amount)) + target * abs(amount)
    return to_hex((red, green, blue))


@cache
def _register_fonts() -> None:
    for face in SERIF_FACES.values():
        font_manager.fontManager.addfont(font_file(face))
