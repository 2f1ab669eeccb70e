"""Fonts embedded in the HTML page: the fonts of the PDF, subset to the characters that occur.

A browser stretches brackets only with a font that has an OpenType MATH table; plain Linux has none.
"""

from __future__ import annotations

import base64
import html
import io
import re
from collections.abc import Iterable

from fontTools import subset
from fontTools.ttLib import TTFont

from fieldrecon.plotting.fonts import MATH, SERIF_FACES, font_bytes
from fieldreport.build.errors import BuildError

CSS = {
    "regular": "font-weight: 400; font-style: normal",
    "italic": "font-weight: 400; font-style: italic",
    "bold": "font-weight: 700; font-style: normal",
}
FEATURES = ["kern", "liga", "lnum", "tnum", "mark", "mkmk", "ccmp", "locl"]
INVISIBLE = {*range(0x20), 0xAD, 0x200B, 0xFE0E, *range(0x2060, 0x2065)}
ASCII = set(range(0x20, 0x7F))


def font_faces(page: str) -> str:
    """Return the style rules with the embedded fonts of a page.

    Raises
    ------
    BuildError
        If no font has a character of the text or of the mathematics.
    """
    return faces_of(*code_points(page))


def faces_of(mathematics: set[int], text: set[int]) -> str:
    """Return the style rules with the embedded fonts for code points of mathematics and of text.

    Characters that the serif font lacks are taken from the font for mathematics.

    Raises
    ------
    BuildError
        If no font has a character of the text or of the mathematics.
    """
    fonts = {face: _open(name) for face, name in SERIF_FACES.items()}
    lacking = text - set(fonts["regular"].getBestCmap())
    math = _open(MATH)
    _require(math, mathematics | lacking)
    rules = [_rule("Report Serif", CSS[face], font, text) for face, font in fonts.items()]
    return "".join([*rules, _rule("Report Math", "", math, mathematics | lacking, ["ssty"])])


def code_points(page: str) -> tuple[set[int], set[int]]:
    """Return the code points of the mathematics and of the text of a page."""
    body = re.sub(r"<(style|code|annotation)\b.*?</\1>", "", page, flags=re.S)
    scripts = re.findall(r"<script>(.*?)</script>", body, flags=re.S)  # they write labels
    body = re.sub(r"<script\b.*?</script>", "", body, flags=re.S)
    formulas = re.findall(r"<math\b.*?</math>", body, flags=re.S)
    text = re.sub(r"<math\b.*?</math>", "", body, flags=re.S)
    mathematics = set().union(*map(_characters, formulas)) | ASCII
    if any(tag in formula for formula in formulas for tag in ("<msqrt", "<mroot")):
        mathematics.add(ord("√"))  # drawn by the browser, not in the markup
    labels = set(map(ord, "".join(scripts))) - INVISIBLE
    return mathematics | set(map(italic, mathematics)), _characters(text) | labels | ASCII


def italic(point: int) -> int:
    """Return the code point with which MathML draws a single letter in ``<mi>``.

    Examples
    --------
    >>> chr(italic(ord("x"))), chr(italic(ord("h"))), chr(italic(ord("ψ")))
    ('𝑥', 'ℎ', '𝜓')
    """
    odd = {
        0x68: 0x210E,
        0x3D5: 0x1D719,
        0x3F5: 0x1D716,
        0x3D1: 0x1D717,
        0x3F1: 0x1D71A,
        0x3D6: 0x1D71B,
        0x2202: 0x1D715,
    }
    ranges = ((0x41, 26, 0x1D434), (0x61, 26, 0x1D44E), (0x391, 25, 0x1D6E2), (0x3B1, 25, 0x1D6FC))
    if point in odd:
        return odd[point]
    for start, count, to in ranges:
        if start <= point < start + count:
            return to + point - start
    return point


def _characters(markup: str) -> set[int]:
    return set(map(ord, html.unescape(re.sub(r"<[^>]*>", "", markup)))) - INVISIBLE


def _open(name: str) -> TTFont:
    return TTFont(io.BytesIO(font_bytes(name)), recalcTimestamp=False)


def _require(font: TTFont, points: set[int]) -> None:
    missing = sorted(points - set(font.getBestCmap()))
    if missing:
        listed = ", ".join(f"{chr(point)} (U+{point:04X})" for point in missing)
        raise BuildError(f"the fonts of the report have no {listed}: write it another way")


def _rule(
    family: str, look: str, font: TTFont, points: set[int], features: Iterable[str] = FEATURES
) -> str:
    data = base64.b64encode(_subset(font, points, features)).decode()
    return (
        f'@font-face {{ font-family: "{family}"; {look}; font-display: block; '
        f'src: url(data:font/woff;base64,{data}) format("woff"); }}\n'
    )


def _subset(font: TTFont, points: set[int], features: Iterable[str]) -> bytes:
    options = subset.Options(layout_features=list(features), hinting=False, desubroutinize=True)
    options.drop_tables += ["FFTM", "PfEd"]
    cutter = subset.Subsetter(options)
    cutter.populate(unicodes=points)
    cutter.subset(font)
    font.flavor = "woff"
    buffer = io.BytesIO()
    font.save(buffer)
    return buffer.getvalue()
