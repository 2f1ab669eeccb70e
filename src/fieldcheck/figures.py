"""Pictures in a notebook: drawn with the student's functions, and redrawn when sliders move."""

from __future__ import annotations

import base64
import io
import os
import re
import sys
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import matplotlib as mpl
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import Collection
from matplotlib.figure import Figure

STATIC = "FIELDCHECK_STATIC"
"""Environment variable: any value disables the sliders."""

MOST_VERTICES = 4000
"""An artist with more vertices is an image in the SVG, which would otherwise take up megabytes."""
DOTS_PER_INCH = 160
"""The resolution of these images."""

PATH = re.compile(r' d="[^"]*"')
LONG_DECIMAL = re.compile(r"(\.\d{3})\d+")

BLUE, ORANGE, PURPLE, GREEN, GREY = "#2a78bb", "#c48600", "#5f1049", "#2a6428", "#8a8a8a"
"""Colours that the colour-blind can distinguish, with different lightness in grey."""

STYLE: Any = {
    "font.size": 10,
    "axes.titlesize": 10,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "figure.constrained_layout.use": True,
    "svg.hashsalt": "fieldcheck",
    "svg.fonttype": "path",
    "legend.frameon": False,
    "lines.linewidth": 1.6,
    "image.cmap": "viridis",
}


@contextmanager
def figure(width: float = 6.4, height: float = 3.6) -> Iterator[Figure]:
    """Open a figure in the style of the course; draw inside the block.

    Examples
    --------
    >>> with figure(4, 3) as page:
    ...     _ = page.subplots().plot([0, 1], [0, 1], color=BLUE)
    >>> svg(page).startswith("<svg")
    True
    """
    with mpl.rc_context(STYLE):
        page = Figure(figsize=(width, height))
        FigureCanvasAgg(page)
        yield page
        page.canvas.draw()


def svg(page: Figure) -> str:
    """Return a figure as SVG, with the same bytes each time."""
    file = io.StringIO()
    for artist in page.findobj(Collection):
        artist.set_rasterized(_vertices(artist) > MOST_VERTICES)
    with mpl.rc_context(STYLE):
        page.savefig(
            file, format="svg", dpi=DOTS_PER_INCH, metadata={"Date": None, "Creator": None}
        )
    text = file.getvalue()
    return PATH.sub(_short_path, text[text.index("<svg") :].strip())


def _short_path(path: re.Match[str]) -> str:
    """Return a path in one line, its coordinates cut to a thousandth of a point."""
    return LONG_DECIMAL.sub(r"\1", path[0]).replace("\n", "")


def _vertices(artist: Any) -> int:
    """Return the number of vertices of a collection, counted for each position of its paths."""
    paths = artist.get_paths()
    drawn = max(len(paths), len(artist.get_offsets()), 1)
    return drawn * sum(len(path.vertices) for path in paths) // max(len(paths), 1)


@dataclass(frozen=True)
class Slider:
    """A number that the reader moves.

    Parameters
    ----------
    low, high : float
        The range.
    start : float
        The initial value, which the static picture shows.
    label : str
        The label.
    steps : int
        The number of steps.
    logarithmic : bool
        Steps of equal ratio.
    whole : bool
        Whole numbers only.
    """

    low: float
    high: float
    start: float
    label: str
    steps: int = 40
    logarithmic: bool = False
    whole: bool = False


def draw(**sliders: Slider) -> Callable[[Callable[..., Figure]], Callable[..., Figure]]:
    """Draw the picture that a function returns, at once and whenever a slider moves.

    While a function that the picture needs is not written, a sentence replaces the picture.

    Examples
    --------
    ::

        @draw(epsilon=Slider(0.01, 1, 0.1, "ε", logarithmic=True))
        def picture(epsilon):
            with figure() as page:
                ...
            return page
    """

    def show(picture: Callable[..., Figure]) -> Callable[..., Figure]:
        if sliders and _can_move():
            _show_moving(picture, sliders)
        else:
            display(_drawn(picture, {name: s.start for name, s in sliders.items()}))
        return picture

    return show


def _drawn(picture: Callable[..., Figure], values: dict[str, float]) -> Any:
    """Return the picture, or the sentence that replaces it."""
    return attempt(lambda: Picture(svg(picture(**values))))


def attempt(make: Callable[[], Any]) -> Any:
    """Return the result of `make`, or a sentence if a function is not written or fails."""
    try:
        return make()
    except NotImplementedError:
        return Sentence(f"The picture waits for {_asked()}, not written yet.")
    except Exception as error:
        text = " ".join(str(error).split())
        return Sentence(f"The picture cannot be drawn: {type(error).__name__}: {text}.")


def _asked() -> str:
    """Return the name of the function that is not written."""
    error = sys.exc_info()[1]
    frames = traceback.extract_tb(error.__traceback__) if error else []
    return frames[-1].name if frames else "a function"


@dataclass(frozen=True)
class Picture:
    """An SVG that notebooks show as an image."""

    text: str

    def _repr_mimebundle_(self, **_: object) -> dict[str, str]:
        return {"image/svg+xml": self.text, "text/plain": "a picture"}


@dataclass(frozen=True)
class Sentence:
    """A sentence that replaces a picture."""

    text: str

    def __repr__(self) -> str:
        return self.text


def display(thing: Any) -> None:
    """Show an object below the cell of a notebook; elsewhere do nothing."""
    module = sys.modules.get("IPython")
    if module is None or module.get_ipython() is None:
        return
    from IPython import display as screen

    screen.display(thing)


def _can_move() -> bool:
    module = sys.modules.get("IPython")
    if os.environ.get(STATIC) or module is None or module.get_ipython() is None:
        return False
    try:
        import ipywidgets  # noqa: F401
    except ImportError:
        return False
    return True


def _show_moving(picture: Callable[..., Figure], sliders: dict[str, Slider]) -> None:
    import ipywidgets
    from IPython.display import display

    controls = {name: _control(ipywidgets, slider) for name, slider in sliders.items()}
    screen = ipywidgets.HTML()

    def redraw(_: object = None) -> None:
        drawn = _drawn(picture, {name: control.value for name, control in controls.items()})
        screen.value = _embedded(drawn.text) if isinstance(drawn, Picture) else drawn.text

    for control in controls.values():
        control.observe(redraw, names="value")
    redraw()
    display(ipywidgets.VBox([*controls.values(), screen]))


def _embedded(text: str) -> str:
    """Return an SVG as an image, so that its identifiers do not clash with other figures."""
    return f'<img src="data:image/svg+xml;base64,{base64.b64encode(text.encode()).decode()}">'


def _control(widgets: Any, slider: Slider) -> Any:
    """Return the slider of ipywidgets; it reports its value when it is released."""
    from math import log10

    look = {
        "description": slider.label,
        "continuous_update": False,
        "style": {"description_width": "initial"},
    }
    if slider.whole:
        return widgets.IntSlider(int(slider.start), int(slider.low), int(slider.high), **look)
    if slider.logarithmic:
        low, high = log10(slider.low), log10(slider.high)
        step = (high - low) / slider.steps
        return widgets.FloatLogSlider(slider.start, min=low, max=high, step=step, **look)
    step = (slider.high - slider.low) / slider.steps
    return widgets.FloatSlider(slider.start, min=slider.low, max=slider.high, step=step, **look)
