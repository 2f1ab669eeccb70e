"""Figures as parts of a page: text that can be selected, and colours that follow the page.

The printed figures have more decimals than a screen shows, an element for each line, and exact
rasters. On a page black and white are the colours of its text and of its ground, and on a dark page
dark colours of lines become light. Rasters keep their colours.
"""

from __future__ import annotations

import base64
import colorsys
import html
import io
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

PAPER: Final = 0x13
"""The brightness of the dark page, which takes the place of white."""
INK: Final = 0xE4
NEUTRAL: Final = 15
"""Channels that differ by no more make a grey."""
DARKEST: Final = 0.62
"""The least lightness of a line on a dark page."""
LIGHTEST: Final = 0.95
"""The largest: the darkest lines on a light page are the lightest on a dark one."""
SATURATION: Final = (0.6, 0.75)
"""Bounds, which keep the shades of one colour apart from those that stay."""
QUALITY: Final = 55
"""Quality of WebP: differences are not visible at twice the size."""

RASTER: Final = re.compile(r'data:image/png;base64,([^"]+)(?=")')
EMBEDDED: Final = re.compile(r'(?<=data:image/webp;base64,)[^"]+')
COLOR: Final = re.compile(r"(?<=stroke: )#[0-9a-f]{6}|(?<=fill: )#[0-9a-f]{6}")
OF_PAGE: Final = {"#000000": "var(--ink, #000)", "#ffffff": "var(--paper, #fff)"}
"""Colours that are those of the page."""
ON_MAP: Final = ("#010101", "#fefefe")
"""`BLACK_ON_MAP` and `WHITE_ON_MAP` of the style, which imports NumPy; they stay."""
SOLID: Final = "#e9e9e9"
"""The ground of a solid body, which is no amount on a map and becomes dark on a dark page."""
MOST_COLORS: Final = 20
"""More colours in one figure stand for amounts, and stay."""
COLOR_BAR: Final = 'id="QuadMesh_'
"""The beginning of a colour bar in a file; the colours of its figure stay as well."""
NAMED: Final = re.compile(r"var\(--c([0-9a-f]{6}),")
PICTURE: Final = re.compile(
    r'<img class="picture" src="([^":]+)\.svg" alt="([^"]*)" (style="[^"]*")>'
)
"""A figure in the text: its path, its alternative text, and its width."""
IDENTIFIER: Final = re.compile(r' id="([^"]+)"')
REFERENCE: Final = re.compile(r'(?<=url\(#)[^)]+|(?<=href="#)[^"]+')
NOT_SHOWN: Final = re.compile(
    r"<!--.*?-->|<style\b.*?</style>|font-family: [^;\"]*(?:; )?", flags=re.S
)
"""Comments, and rules that the style sheet of the page has for its figures."""
PATH: Final = re.compile(r'(?<= d=")[^"]+(?=")')
POSITIONS: Final = re.compile(r'(?<= points=")[^"]+|(?<=<use )[^>]*?(?= style=|/>)')
DECIMALS: Final = re.compile(r"(\.\d)\d+")
COMMAND: Final = re.compile(r"([A-Za-z])([^A-Za-z]*)")
SAME_LINE: Final = re.compile(
    r'<path d="[^"]*"(?P<look> clip-path="[^"]*" style="fill: none; (?:(?!opacity)[^"])*"/>)'
    r'(?:\s*<path d="[^"]*"(?P=look))+'
)
"""Lines of one look, which can be one path."""
SAME_CLIP: Final = re.compile(
    r'(?P<clip><g clip-path="[^"]*">)\s*<use [^>]*/>(?:\s*</g>\s*(?P=clip)\s*<use [^>]*/>)+'
)
"""Markers within one frame, which can be one group."""


def light(svg: str) -> str:
    """Return a figure without the digits and bytes that no screen shows."""
    svg = re.sub(r"<metadata>.*?</metadata>", "", svg, flags=re.S)
    svg = PATH.sub(lambda path: short_path(path[0]), svg)
    svg = POSITIONS.sub(lambda numbers: DECIMALS.sub(r"\1", numbers[0]), svg)
    svg = SAME_LINE.sub(lambda lines: _joined(lines[0], f'"{lines["look"]}', '<path d="'), svg)
    svg = SAME_CLIP.sub(lambda marks: _joined(marks[0], "</g>", marks["clip"]), svg)
    return RASTER.sub(lambda png: _embedded(base64.b64decode(png[1])), svg)


def short_path(path: str) -> str:
    """Return a path by differences, rounded to a tenth without a sum of the errors.

    Examples
    --------
    >>> short_path("M 1.234567 2.5 L 3 4.987654 L 3 4 z")
    'M1.2 2.5l1.8 2.5 0-1z'
    """
    short, last, place, start = [], "", (0, 0), (0, 0)
    for command, numbers in COMMAND.findall(path):
        values = [round(10 * float(number)) for number in numbers.split()]
        if not values:  # the path is closed
            place = start
        kind = command.lower() if last else command  # the first position is absolute
        steps = [value - place[k % 2] for k, value in enumerate(values)] if last else values
        text = "".join(_tenths(step) for step in steps)
        short.append(text if kind == last != "m" and values else kind + text.removeprefix(" "))
        place = (values[-2], values[-1]) if values else place
        start = place if kind in "Mm" else start
        last = kind
    return "".join(short)


def _tenths(tenths: int) -> str:
    """Return a number after what separates it from the one before."""
    number = re.sub(r"^(-?)0\.", r"\1.", f"{tenths / 10:g}")
    return number if number.startswith("-") else f" {number}"


def _joined(elements: str, end: str, beginning: str) -> str:
    """Return elements as one, without the ends and beginnings between them."""
    return re.sub(rf"{re.escape(end)}\s*{re.escape(beginning)}", "", elements)


def with_pictures(page: str, picture: Callable[[str, str, str], str]) -> str:
    """Return a page with its figures.

    Parameters
    ----------
    page : str
        HTML as the filters write it.
    picture : callable
        The element for a figure, named ``EXPERIMENT/FIGURE``, its alternative text, and its width.
    """
    return PICTURE.sub(lambda tag: picture(html.unescape(tag[1]), tag[2], tag[3]), page)


def element(svg: str, name: str, alt: str, width: str) -> str:
    """Return a figure as an element of a page.

    Parameters
    ----------
    svg : str
        The file.
    name : str
        Begins the identifiers in the figure, which must differ from those of other figures.
    alt, width : str
        The alternative text, and the attribute with the width, as HTML.
    """
    (box,) = re.findall(r'<svg\b[^>]* viewBox="([^"]*)"', svg)
    inside = svg[svg.index(">", svg.index("<svg")) + 1 :]
    inside = own_identifiers(themed(NOT_SHOWN.sub("", inside)), name)
    inside = re.sub(r">\s+<", "><", inside).strip()
    return f'<svg class="picture" role="img" aria-label="{alt}" {width} viewBox="{box}">{inside}'


def own_identifiers(svg: str, name: str) -> str:
    """Return a figure whose identifiers begin with its name, without those that nothing uses."""
    used = dict.fromkeys(REFERENCE.findall(svg))
    own = {identifier: f"{name}-{k}" for k, identifier in enumerate(used)}
    svg = REFERENCE.sub(lambda reference: own[reference[0]], svg).replace("xlink:href", "href")
    return IDENTIFIER.sub(lambda i: f' id="{own[i[1]]}"' if i[1] in own else "", svg)


def themed(svg: str) -> str:
    """Return a figure whose colours are those of the page, or have a name for a dark page.

    Examples
    --------
    >>> themed('style="fill: #ffffff; stroke: #5f1049"')
    'style="fill: var(--paper, #fff); stroke: var(--c5f1049, #5f1049)"'
    >>> themed('<g id="QuadMesh_1"><path style="fill: #5f1049"/>')  # a colour bar
    '<g id="QuadMesh_1"><path style="fill: #5f1049"/>'
    >>> themed('style="stroke: #010101"')  # black on a map
    'style="stroke: #010101"'
    >>> themed('<g id="QuadMesh_1"/><g style="fill: #e9e9e9"/>')  # a body in a map
    '<g id="QuadMesh_1"/><g style="fill: var(--ce9e9e9, #e9e9e9)"/>'
    """
    amounts = COLOR_BAR in svg or len(set(COLOR.findall(svg))) > MOST_COLORS
    return COLOR.sub(lambda color: themed_color(color[0], amounts=amounts), svg)


def themed_color(color: str, *, amounts: bool) -> str:
    """Return the value of a colour on a page; light ones and amounts have no name."""
    if color in OF_PAGE:
        return OF_PAGE[color]
    stays = (amounts and color != SOLID) or color in ON_MAP or dark_color(color) == color
    return color if stays else f"var(--c{color[1:]}, {color})"


def dark_values(page: str) -> str:
    """Return the declarations of the named colours of a page for a dark page."""
    names = sorted(set(NAMED.findall(page)))
    return "".join(f"--c{name}: {dark_color(f'#{name}')}; " for name in names)


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
    mirrored = min(max(1.05 - lightness, DARKEST), LIGHTEST)
    least, most = SATURATION
    channels = colorsys.hls_to_rgb(hue, mirrored, min(max(saturation, least), most))
    return "#" + "".join(f"{round(255 * channel):02x}" for channel in channels)


def webp(png: bytes) -> bytes:
    """Return a raster in the smaller format, exactly if that is shorter, as for few colours."""
    from PIL import Image

    def saved(**options: Any) -> bytes:
        buffer = io.BytesIO()
        Image.open(io.BytesIO(png)).save(buffer, "WEBP", method=4, **options)
        return buffer.getvalue()

    return min(saved(quality=QUALITY), saved(lossless=True), key=len)


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


def raster(source: str, alt: str, width: str) -> str:
    """Return a raster as an element of a page, drawn when a reader comes near."""
    look = f'class="picture raster" loading="lazy" decoding="async" src="{source}"'
    return f'<img {look} alt="{alt}" {width}>'


def address(path: Path) -> str:
    """Return a raster as an address that contains it."""
    return f"data:image/webp;base64,{base64.b64encode(path.read_bytes()).decode()}"


def _embedded(png: bytes) -> str:
    smaller = webp(png)
    kind, content = ("webp", smaller) if len(smaller) < len(png) else ("png", png)
    return f"data:image/{kind};base64,{base64.b64encode(content).decode()}"
