"""Formulas on the site: one that is too long for the screen is broken where a sentence would be."""

import re
from pathlib import Path

import pytest

from settled_page import settled_page

STATIC = Path(__file__).parents[2] / "docs" / "site" / "static"
SUM = "<mi>x</mi>" + "<mo>+</mo><mi>x</mi>" * 7
SHORT = "<mi>x</mi>" + "<mo>+</mo><mi>x</mi>" * 3
BRACKETS = f"<mo>(</mo>{SHORT}<mo>)</mo>"
AT_SPACES = f"{SUM}<mo>,</mo><mspace width='2.0em'></mspace>{SUM}"
AT_RELATIONS = "<mo>=</mo>".join([BRACKETS] * 4)
RIGHT = f"<mo>=</mo>{SHORT}" * 3
ALIGNED = f"<mtr><mtd>{SHORT}</mtd><mtd>{RIGHT}</mtd></mtr>"
MEASURE = """math => ({
    rows: math.querySelectorAll("mtr").length,
    cut: math.scrollWidth > math.clientWidth + 1,
    text: math.textContent,
})"""


def formula(content):
    return f'<math display="block"><semantics>{content}</semantics></math>'


@pytest.mark.parametrize(
    ("content", "width", "rows"),
    [
        (f"<mrow>{AT_SPACES}</mrow>", 1200, 0),
        (f"<mrow>{AT_SPACES}</mrow>", 400, 2),
        (f"<mrow>{AT_RELATIONS}</mrow>", 1200, 0),
        (f"<mrow>{AT_RELATIONS}</mrow>", 300, 3),  # the first relation stays with the left side
        (f"<mtable>{ALIGNED}</mtable>", 1200, 1),
        (f"<mtable>{ALIGNED}</mtable>", 300, 3),
    ],
)
def test_a_formula_is_broken_only_where_the_screen_is_too_narrow(
    browser, tmp_path, content, width, rows
):
    """Nothing of it is lost, and nothing has to be scrolled."""
    style, script = ((STATIC / name).as_uri() for name in ("site.css", "reader.js"))
    (tmp_path / "one.html").write_text(
        f'<!doctype html><link rel="stylesheet" href="{style}">'
        f'<main class="chapter">{formula(content)}</main>'
        f'<script src="{script}"></script>'
    )
    context = browser.new_context(viewport={"width": width, "height": 800}, offline=True)
    page = settled_page(context, tmp_path / "one.html")
    shown = page.locator("math").evaluate(MEASURE)
    context.close()
    assert (shown["rows"], shown["cut"]) == (rows, False)
    assert shown["text"] == re.sub("<[^>]*>", "", content)
