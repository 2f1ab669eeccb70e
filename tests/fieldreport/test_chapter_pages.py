"""The chapters as fragments: split, linked, with figures for the screen."""

import base64
import io
import re

import pytest
from PIL import Image

from fieldreport.build.chapter_pages import (
    chapters_of,
    page_names,
    with_folded_solutions,
    with_works,
)
from fieldreport.build.errors import BuildError
from fieldreport.build.screen_figures import dark_color, dark_values, element, light

PAGE = """<body><main id="text"><div class="abstract"><p>In short.</p></div>
<section id="sec:one" class="level2"><h2>One</h2>
<p id="eq:a"><a href="#eq:b">b</a> <a href="#eq:a">a</a></p>
<section id="sec:part" class="level3"><h3>Part</h3></section>
</section>
<section id="sec:two" class="level2"><h2>Two</h2>
<p id="eq:b"><a href="#sec:part">part</a></p></section>
</main></body>"""


def test_a_page_is_split_at_its_chapters_and_links_name_the_page_of_their_target():
    one, two = chapters_of(PAGE, ["one", "two"])
    assert "Part" in one.content
    assert "Two" not in one.content
    assert re.findall('href="([^"]*)"', one.content) == ["two.html#eq:b", "#eq:a"]
    assert '<a href="one.html#sec:part" title="Part">' in two.content
    assert "title=" not in one.content  # an equation has none


def test_a_page_has_the_name_of_the_file_that_its_chapter_begins(tmp_path):
    """A second chapter of a file has its label as name."""
    files = {
        "01-first.md": "# One {#sec:one}\n\n# More {#sec:more}\n",
        "02-next.md": "# Two {#sec:two .x}",
    }
    for name, text in files.items():
        (tmp_path / name).write_text(text)
    paths = sorted(tmp_path.iterdir())
    assert page_names(["sec:one", "sec:more", "sec:two"], paths) == ["first", "more", "next"]


def test_a_citation_shows_its_work():
    page = (
        '<a href="#ref-a" role="doc-biblioref">A 1</a><a href="#ref-b" role="doc-biblioref">B</a>'
        '<div id="ref-a" class="csl-entry" role="listitem">\nA: <em>On "x"</em>.\n</div>'
    )
    titled = with_works(page)
    assert '<a href="#ref-a" role="doc-biblioref" title="A: On &quot;x&quot;.">A 1</a>' in titled
    assert '<a href="#ref-b" role="doc-biblioref">B</a>' in titled


def test_a_solution_is_folded_and_what_follows_is_not():
    text = (
        '<div class="statement solution"><p><strong>Solution.</strong> <i>x</i></p>'
        "<div>inside</div></div><div>after</div>"
    )
    folded = with_folded_solutions(text)
    assert folded.index("inside") < folded.index("</details>") < folded.index("after")
    assert "<strong>" not in folded
    with pytest.raises(BuildError, match="no end"):
        with_folded_solutions(text.replace("</div>", ""))


def png(size: int) -> str:
    buffer = io.BytesIO()
    Image.effect_noise((size, size), 50).save(buffer, "PNG")
    return base64.b64encode(buffer.getvalue()).decode()


def test_a_figure_for_the_screen_is_shorter_and_has_the_same_elements():
    raster = png(100)
    path = '<path d="M 1.234567 2.5 \nL 3 4.987654 \n"/>'
    svg = f'<svg width="9pt">{path}<image href="data:image/png;base64,{raster}"/></svg>'
    short = light(svg)
    assert '<path d="M 1.2 2.5L3 4.9"/>' in short.replace(" \n", "").replace("\n", "")
    assert "data:image/webp" in short
    assert len(short) < len(svg)


def on_a_page(inside):
    return element(f'<svg width="9pt" viewBox="0 0 9 9">{inside}</svg>', "bumps", "A bump.", "")


def test_colours_of_a_figure_follow_the_page_and_a_bright_colour_stays():
    """Black and white are those of the page; a dark colour has a name and a value for the dark."""
    figure = on_a_page(
        '<path style="fill: #ffffff; stroke: #000000"/>'
        '<path style="fill: #5f1049; stroke: #c48600"/>'
    )
    assert 'style="fill: var(--paper, #fff); stroke: var(--ink, #000)"' in figure
    assert 'style="fill: var(--c5f1049, #5f1049); stroke: #c48600"' in figure
    assert dark_values(figure) == f"--c5f1049: {dark_color('#5f1049')}; "


def test_colours_of_amounts_stay_on_a_dark_page():
    """They must agree with the colour bar, which is a raster."""
    amounts = "".join(f'<path style="fill: #{k:02x}0000; stroke: #000000"/>' for k in range(1, 20))
    figure = on_a_page(amounts)
    assert 'style="fill: #010000; stroke: var(--ink, #000)"' in figure
    assert dark_values(figure) == ""


def test_identifiers_of_a_figure_are_its_own_and_its_letters_those_of_the_page():
    """Two figures of one page may have the same identifiers in their files."""
    figure = on_a_page(
        '<defs><style type="text/css">*{stroke-linejoin: round}</style></defs>'
        '<g id="axes_1" clip-path="url(#p7)"><!-- 0 -->\n <use xlink:href="#m2"/></g>'
        '<clipPath id="p7"/><path id="m2"/>'
        "<text style=\"font-size: 8px; font-family: 'Libertinus Serif'; text-anchor: end\">0</text>"
    )
    assert figure == (
        '<svg class="picture" role="img" aria-label="A bump."  viewBox="0 0 9 9"><defs></defs>'
        '<g clip-path="url(#bumps-0)"><use href="#bumps-1"/></g>'
        '<clipPath id="bumps-0"/><path id="bumps-1"/>'
        '<text style="font-size: 8px; text-anchor: end">0</text></svg>'
    )


def luminance(color: str) -> float:
    """Relative luminance of sRGB, as contrast is defined by WCAG 2."""
    channels = [int(color[k : k + 2], 16) / 255 for k in (1, 3, 5)]
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in channels]
    return sum(w * c for w, c in zip((0.2126, 0.7152, 0.0722), linear, strict=True))


@pytest.mark.parametrize("color", ["#000000", "#5f1049", "#2a6428", "#2a78bb", "#c48600"])
def test_lines_have_contrast_on_a_dark_page(color):
    """WCAG 2 asks for a contrast of 3 : 1 of graphical objects."""
    assert (luminance(dark_color(color)) + 0.05) / (luminance("#131313") + 0.05) > 3
