"""The chapters as fragments: split, linked, with figures for the screen."""

import base64
import io
import re
from itertools import combinations

import numpy as np
import pytest
from matplotlib import colormaps
from matplotlib.colors import LinearSegmentedColormap, to_hex
from PIL import Image

from fieldrecon.plotting.style import BLACK_ON_MAP, DIVERGING, SEQUENTIAL, WHITE_ON_MAP, shades
from fieldreport.build.chapter_pages import (
    chapters_of,
    page_names,
    with_folded_solutions,
)
from fieldreport.build.errors import BuildError
from fieldreport.build.screen_figures import (
    ON_MAP,
    dark_color,
    dark_values,
    element,
    light,
    short_path,
    themed,
    webp,
)
from fieldreport.build.screen_files import FAINTEST, bright_part

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


STATED = """<main>
<section id="sec:one" class="level2"><h2>One</h2>
<p>By <a href="#thm:b">Theorem 1</a> and <a href="#ref-c" role="doc-biblioref">C 3</a>,
<span id="eq:a" class="equation"><math><mi>a</mi></math></span>, <a href="#eq:a">(1)</a>.</p>
</section>
<section id="sec:two" class="level2"><h2>Two</h2>
<div class="statement theorem" id="thm:b"><p><strong>Theorem 1</strong> (Trees).</p>
<div id="inside"><p>See <a href="#eq:a">(1)</a>.</p></div></div>
<p>After. <a href="#eq:a">(1)</a></p></section>
<section id="sec:works" class="level2">
<div id="ref-c" class="csl-entry" role="listitem">C: <em>On "x"</em>.</div></section>
</main>"""


def test_a_chapter_contains_what_it_refers_to_in_other_chapters():
    """The copies are whole, have no identifiers and links, and no title says the same again."""
    one, two, works = (chapter.content for chapter in chapters_of(STATED, ["one", "two", "works"]))
    assert one.partition('<template class="previews">')[2] == (
        '<div class="statement theorem" data-label="thm:b"><p><strong>Theorem 1</strong> (Trees).'
        "</p>\n<div><p>See (1).</p></div></div>"
        '<div data-label="ref-c" class="csl-entry" role="listitem">C: <em>On "x"</em>.</div>'
        "</template>"
    )
    assert "title=" not in one
    assert '<span data-label="eq:a" class="equation">' in two
    assert two.count("data-label") == 1  # for both links
    assert "template" not in works


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
    assert '<path d="M1.2 2.5l1.8 2.5"/>' in short
    assert "data:image/webp" in short
    assert len(short) < len(svg)


def test_a_raster_of_few_colours_stays_exact():
    """It is shorter than with the loss that suits a photograph."""
    buffer = io.BytesIO()
    colors = np.random.default_rng(0).integers(0, 2, (64, 64, 1)) * np.array([200, 100, 50])
    Image.fromarray(colors.astype(np.uint8)).save(buffer, "PNG")
    with Image.open(io.BytesIO(webp(buffer.getvalue()))) as kept:
        assert np.array_equal(kept.convert("RGB"), colors)


def test_a_short_path_ends_where_the_long_one_does():
    """Rounded differences must not add up; a closed part ends where it began."""
    steps = "".join(f"L {0.04 * k:.6f} {-0.13 * k:.6f} \n" for k in range(1, 1001))
    numbers = re.findall(r"-?\d*\.?\d+", short_path(f"M 0 0 \n{steps}").replace("m", "l"))
    assert sum(map(float, numbers[0::2])) == pytest.approx(40)
    assert sum(map(float, numbers[1::2])) == pytest.approx(-130)
    closed = "M 1 1 L 2 1 L 2 2 z M 3 1 C 3 2 4 3 5 5 C 6 6 7 7 8 9 M 0 0 M 1 1"
    assert short_path(closed) == "M1 1l1 0 0 1zm2 0c0 1 1 2 2 4 1 1 2 2 3 4m-8-9m1 1"


def test_lines_of_one_look_are_one_path_unless_they_are_translucent():
    def lines(style):
        line = f'<path d="M 1 1 L 2 2 \n" clip-path="url(#p)" style="fill: none; {style}"/>'
        return light(f"<svg>{line}\n    {line}<g>{line}</g></svg>").count("<path")

    assert lines("stroke: #000000") == 2
    assert lines("stroke: #000000; stroke-opacity: 0.5") == 3


def test_markers_within_one_frame_are_one_group():
    def marks(*frames):
        return "".join(
            f'<g clip-path="url(#{frame})">\n '
            '<use xlink:href="#m" x="1.25" y="2.5" style="a: 1.25"/>\n</g>\n'
            for frame in frames
        )

    mark = '<use xlink:href="#m" x="1.2" y="2.5" style="a: 1.25"/>'
    found = re.sub(r"\s*\n\s*", "", light(marks("p", "p", "q")))
    assert found == (f'<g clip-path="url(#p)">{mark}{mark}</g><g clip-path="url(#q)">{mark}</g>')


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
    """They must agree with the colour bar, whose lighter end would not stay the lighter one."""
    few, many = (
        "".join(f'<path style="fill: #{k:02x}0000; stroke: #000000"/>' for k in range(1, 1 + count))
        for count in (4, 24)
    )
    for amounts in (many, few + '<g id="QuadMesh_1"/>'):
        figure = on_a_page(amounts)
        assert 'style="fill: #010000; stroke: var(--ink, #000)"' in figure
        assert dark_values(figure) == ""
    assert dark_values(on_a_page(few)) != ""


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


@pytest.mark.parametrize("method", ["LS", "MLS", "PU", "RBF"])
def test_shades_of_a_method_stay_distinct_on_a_dark_page(method):
    """The darker one was once as light as the others, so that they could not be told apart."""
    drawn = [dark_color(look["color"]) for look in shades(method, 6)]
    channels = [np.array([int(color[k : k + 2], 16) for k in (1, 3, 5)]) for color in drawn]
    differences = [abs(a - b).max() for a, b in combinations(channels, 2)]
    assert min(differences) >= 8
    assert min((luminance(color) + 0.05) / (luminance("#131313") + 0.05) for color in drawn) > 3


def test_markers_of_a_cloud_are_visible_on_a_dark_page():
    """The dark end of the map is left out, and no marker is faint."""
    for name in (SEQUENTIAL, DIVERGING):
        shown = bright_part(colormaps[name])(np.linspace(0, 1, 20))
        assert min(luminance(to_hex(color)) + 0.05 for color in shown) > 2.9 * (
            luminance("#131313") + 0.05
        )
    faint = LinearSegmentedColormap.from_list("faint", [(0.2, 0.5, 0.9, 1), (0.2, 0.5, 0.9, 0.1)])
    assert bright_part(faint)(1.0)[3] == FAINTEST


def test_black_and_white_on_a_map_stay_on_a_dark_page():
    """The map stays light, so lines on it must stay dark."""
    assert ON_MAP == (BLACK_ON_MAP, WHITE_ON_MAP)
    drawn = 'style="stroke: #010101"', 'style="fill: #fefefe"'
    assert [themed(svg) for svg in drawn] == [*drawn]
