"""Drawings of the guides as parts of their pages, with colours that follow the page.

An SVG in an `<img>` has colours of its own: on a dark page it would be a white plate, or black
lines on black.
"""

from __future__ import annotations

import colorsys
import html
import re
from pathlib import Path
from typing import TYPE_CHECKING

from fieldreport.build.chapter_pages import DARK
from fieldreport.build.screen_figures import (
    INK,
    NOT_SHOWN,
    PAPER,
    dark_color,
    light,
    own_identifiers,
)

if TYPE_CHECKING:
    from docutils.nodes import document
    from sphinx.application import Sphinx

COLOR = re.compile(r'(?P<of>(?:fill|stroke)(?:: |="))#(?P<hex>[0-9a-f]{6})')
SIZE = re.compile(r' (?:width|height|version|xmlns(?::xlink)?)="[^"]*"')
AREA = 0.8
"""Lighter colours are those of areas, which become as dark as the page with the text on them."""


def drawing(svg: str, name: str, alt: str) -> str:
    """Return an SVG as an element of a page, whose identifiers begin with its name."""
    beginning = svg.index("<svg")
    start = svg.index(">", beginning)
    attributes = SIZE.sub("", svg[beginning + len("<svg") : start])
    inside = own_identifiers(NOT_SHOWN.sub("", light(svg[start + 1 :])), name)
    inside = re.sub(r">\s+<", "><", inside).strip()
    look = f'class="picture" role="img" aria-label="{html.escape(alt)}"'
    return f"<svg {look}{attributes}>{dark_style(inside)}{COLOR.sub(named, inside)}"


def named(color: re.Match[str]) -> str:
    """Return a colour with a name for the dark page."""
    return f"{color['of']}var(--d{color['hex']}, #{color['hex']})"


def dark_style(svg: str) -> str:
    """Return the style that gives the names their colours on a dark page."""
    names = sorted({color["hex"] for color in COLOR.finditer(svg)})
    return f"<style>{DARK.format(''.join(f'--d{c}: {dark_shade(c)}; ' for c in names))}</style>"


def dark_shade(color: str) -> str:
    """Return a colour on a dark page: that of the report's figures, or of a light area dark."""
    channels = (int(color[k : k + 2], 16) / 255 for k in (0, 2, 4))
    hue, lightness, saturation = colorsys.rgb_to_hls(*channels)
    if lightness < AREA:
        return dark_color(f"#{color}")
    dark = (INK + (PAPER - INK) * lightness) / 255
    return "#" + "".join(
        f"{round(255 * channel):02x}" for channel in colorsys.hls_to_rgb(hue, dark, saturation)
    )


def put_in(app: Sphinx, doctree: document, page: str) -> None:
    """Replace the images of a page that are drawings."""
    from docutils import nodes  # only the site needs it, the tests of drawings do not

    for k, image in enumerate(list(doctree.findall(nodes.image))):
        if image["uri"].endswith(".svg"):
            svg = Path(app.srcdir, image["uri"]).read_text(encoding="utf-8")
            element = drawing(svg, f"{Path(page).name}-{k}", image.get("alt", ""))
            image.replace_self(nodes.raw("", element, format="html"))


def setup(app: Sphinx) -> dict:
    """Register with Sphinx."""
    app.connect("doctree-resolved", put_in)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
