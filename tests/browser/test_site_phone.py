"""Figures and tables of the site on a phone: letters are large, and text needs no scrolling."""

from pathlib import Path

import pytest

from settled_page import settled_page

STATIC = Path(__file__).parents[2] / "docs" / "site" / "static"
FIGURE = """<section class="chapter"><figure>
<svg class="picture" style="width:100%" viewBox="0 0 440 200">
<text x="9" y="20" style="font-size: 7px">7</text>
<text x="400" y="190" style="font-size: 9px">9</text>
</svg></figure></section>"""
INDICES = """<section class="chapter"><figure>
<svg class="picture" style="width:100%" viewBox="0 0 440 200"><text>
<tspan x="9" y="20" style="font-size: 8px">10</tspan>
<tspan x="20" y="15" style="font-size: 5px">2</tspan>
</text></svg></figure></section>"""
WORDS = "the least leave-one-out error of several"
CELLS = f"<td>{WORDS}</td><td>{WORDS}</td><td><code>{'word' * 9}</code> {WORDS}</td>"
TABLE = f"""<div class="table-wrapper"><table>
<thead><tr><th>you have</th><th>use</th><th>code</th></tr></thead><tbody><tr>{CELLS}</tr></tbody>
</table></div>"""
LISTED = f"""<div class="table-wrapper"><table>
<thead><tr><th>risk</th><th>a</th><th>b</th><th>c</th></tr></thead><tbody><tr><td>{WORDS}</td><td>yes</td><td>{WORDS}</td><td>{WORDS}</td></tr></tbody>
</table></div>"""
CODE = f"<section class='chapter'><p>{WORDS}</p><pre>{'long ' * 20}</pre></section>"


@pytest.fixture
def open_page(browser, tmp_path):
    """Open a page of the site with the given content."""
    contexts = []

    def open_in(content, width):
        style, script = ((STATIC / name).as_uri() for name in ("site.css", "reader.js"))
        (tmp_path / "one.html").write_text(
            '<!doctype html><meta name="viewport" content="width=device-width">'
            f'<link rel="stylesheet" href="{style}"><article>{content}</article>'
            f'<script src="{script}"></script>'
        )
        viewport = {"width": width, "height": 800}
        contexts.append(browser.new_context(viewport=viewport, offline=True))
        return settled_page(contexts[-1], tmp_path / "one.html")

    yield open_in
    for context in contexts:
        context.close()


@pytest.mark.parametrize("width", [390, 1280])
def test_the_smallest_letters_of_a_figure_have_eleven_pixels(open_page, width):
    """The page itself is not wider than the screen: the figure scrolls in a box of its own."""
    page = open_page(FIGURE, width)
    assert page.evaluate("7 * document.querySelector('text').getScreenCTM().a") > 10.99
    assert page.evaluate("document.documentElement.scrollWidth") <= width


def test_a_wide_table_of_text_is_stacked_on_a_phone_only(open_page):
    """Nothing of it has to be scrolled there; elsewhere its columns are side by side."""
    tops = (
        """() => [...document.querySelectorAll("td")].map(td => td.getBoundingClientRect().top)"""
    )
    wide = open_page(TABLE, 1280)
    assert len(set(wide.evaluate(tops))) == 1
    phone = open_page(TABLE, 390)
    first, second, third = phone.evaluate(tops)
    assert first == second < third
    box = "document.querySelector('.table-wrapper')"
    assert phone.evaluate(f"{box}.scrollWidth - {box}.clientWidth") <= 1


def test_letters_that_only_parts_of_a_text_have_count_and_indices_do_not(open_page):
    """Formulas in figures have the sizes of their letters at parts of the text."""
    page = open_page(INDICES, 390)
    scale = page.evaluate("document.querySelector('tspan').getScreenCTM().a")
    assert scale == pytest.approx(11 / 8)


def test_a_table_of_four_long_columns_names_each_cell_on_a_phone_only(open_page):
    """Cells lie below each other there, and each has the width of the table."""
    cells = """() => [...document.querySelectorAll("td")].map(td => [
        td.querySelector(".head")?.checkVisibility() ? td.querySelector(".head").innerText : "",
        td.getBoundingClientRect().top, td.getBoundingClientRect().width,
    ])"""
    heads, tops, widths = zip(*open_page(LISTED, 390).evaluate(cells), strict=True)
    assert heads == ("", "a", "b", "c")
    assert list(tops) == sorted(set(tops))
    assert min(widths) > 300
    heads, tops, _ = zip(*open_page(LISTED, 1280).evaluate(cells), strict=True)
    assert heads == ("", "", "", "")
    assert len(set(tops)) == 1


@pytest.mark.parametrize(("width", "is_cut"), [(390, True), (1280, False)])
def test_code_reaches_into_free_space_on_the_right(open_page, width, is_cut):
    """It is scrolled only where there is none, and the page never is."""
    page = open_page(CODE, width)
    assert page.evaluate("document.querySelector('pre.cut') !== null") == is_cut
    assert page.evaluate("document.documentElement.scrollWidth") <= width
