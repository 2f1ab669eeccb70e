"""Figures for the screen: smaller files, and colours for a dark page.

The printed figures have more decimals than a screen shows, and exact rasters. On a dark page the
ink is light: black and white change places, and dark colours of lines become lighter. Rasters keep
their colours.
"""

from __future__ import annotations

import base64
import colorsys
import io
import re
from pathlib import Path
from typing import Final
from urllib.parse import quote

PAPER: Final = 0x13
"""The brightness of the dark page, which takes the place of white."""
INK: Final = 0xE4
NEUTRAL: Final = 10
"""Channels that differ by no more make a grey."""
DARKEST: Final = 0.62
"""The least lightness of a line on a dark page."""
QUALITY: Final = 55
"""Quality of WebP: differences are not visible at twice the size."""

RASTER: Final = re.compile(r'data:image/png;base64,([^"]+)(?=")')
COLOR: Final = re.compile(r"(?<=stroke: )#[0-9a-f]{6}|(?<=fill: )#[0-9a-f]{6}")
PATH: Final = re.compile(r'(?<= d=")[^"]+(?=")|(?<= points=")[^"]+(?=")')
DECIMALS: Final = re.compile(r"(\.\d)\d+")
STEP: Final = re.compile(r" ?\n([A-Za-z]) ?")
READABLE: Final = " !$'()*+,-./:;=?@[]^_`{|}~\n"
"""Characters that stand as they are in the address of an SVG."""


def light(svg: str) -> str:
    """Return a figure without the digits and bytes that no screen shows."""
    svg = re.sub(r"<metadata>.*?</metadata>", "", svg, flags=re.S)
    svg = PATH.sub(lambda path: STEP.sub(r"\1", DECIMALS.sub(r"\1", path[0])), svg)
    return RASTER.sub(lambda png: _embedded(base64.b64decode(png[1])), svg)


def dark(svg: str) -> str:
    """Return a figure in the colours of a dark page."""
    svg = COLOR.sub(lambda color: dark_color(color[0]), svg)
    return svg.replace("<svg ", f'<svg fill="#{INK:02x}{INK:02x}{INK:02x}" ', 1)  # of glyphs


def dark_color(color: str) -> str:
    """Return the colour of a line or an area on a dark page.

    Examples
    --------
    >>> dark_color("#000000"), dark_color("#ffffff")
    ('#e4e4e4', '#131313')
    >>> dark_color("#c48600")  # light enough as it is
    '#c48600'
    """
    red, green, blue = (int(color[k : k + 2], 16) for k in (1, 3, 5))
    if max(red, green, blue) - min(red, green, blue) <= NEUTRAL:
        grey = round(INK + (PAPER - INK) * (red + green + blue) / 765)
        return f"#{grey:02x}{grey:02x}{grey:02x}"
    if 0.2126 * red + 0.7152 * green + 0.0722 * blue > 100:
        return color
    hue, lightness, saturation = colorsys.rgb_to_hls(red / 255, green / 255, blue / 255)
    lighter = colorsys.hls_to_rgb(hue, max(lightness, DARKEST), min(saturation, 0.75))
    return "#" + "".join(f"{round(255 * channel):02x}" for channel in lighter)


def webp(png: bytes) -> bytes:
    """Return a raster in the smaller format."""
    from PIL import Image

    buffer = io.BytesIO()
    Image.open(io.BytesIO(png)).save(buffer, "WEBP", quality=QUALITY, method=4)
    return buffer.getvalue()


def screen_file(out: Path, figure: str) -> Path:
    """Return the file of a figure, named ``EXPERIMENT/FIGURE``, for the screen.

    Parameters
    ----------
    out : Path
        The build folder.
    figure : str
        Experiment and figure, without suffix.
    """
    raster = out / "screen" / f"{figure}.webp"
    return raster if raster.exists() else raster.with_suffix(".svg")


def address(path: Path) -> str:
    """Return a figure as an address that contains it."""
    if path.suffix == ".webp":
        return f"data:image/webp;base64,{base64.b64encode(path.read_bytes()).decode()}"
    text = path.read_text(encoding="utf-8").replace('"', "'")
    return f"data:image/svg+xml,{quote(text, safe=READABLE)}"


def _embedded(png: bytes) -> str:
    smaller = webp(png)
    kind, content = ("webp", smaller) if len(smaller) < len(png) else ("png", png)
    return f"data:image/{kind};base64,{base64.b64encode(content).decode()}"
