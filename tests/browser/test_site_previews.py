"""Previews on the site: a link shows its target, also if this is in another chapter."""

import html
from pathlib import Path

import pytest

from fieldreport.build.chapter_pages import chapters_of

STATIC = Path(__file__).parents[2] / "docs" / "site" / "static"
REPORT = """<main>
<section id="sec:one" class="level2 chapter"><h2>One</h2>
<p>By <a href="#thm:b">Theorem 1</a>, see <a href="#sec:two">section 2</a>,
<span id="eq:a" class="equation">a = 1</span>, thus <a href="#eq:a">(1)</a>.</p></section>
<section id="sec:two" class="level2 chapter"><h2>Two</h2>
<div class="statement" id="thm:b"><p>All trees are <b>green</b>.</p></div></section>
</main>"""


@pytest.fixture
def page(browser, tmp_path):
    """The first chapter, opened as a file, without a network."""
    chapter = chapters_of(REPORT, ["one", "two"])[0].content
    style, script = (f"{STATIC.as_uri()}/{name}" for name in ("site.css", "reader.js"))
    (tmp_path / "one.html").write_text(
        f'<!doctype html><link rel="stylesheet" href="{html.escape(style)}">{chapter}'
        f'<script src="{html.escape(script)}"></script>',
        encoding="utf-8",
    )
    context = browser.new_context(offline=True)
    page = context.new_page()
    page.goto((tmp_path / "one.html").as_uri())
    yield page
    context.close()


@pytest.mark.parametrize(
    ("link", "shown"), [("Theorem 1", "All trees are green."), ("(1)", "a = 1")]
)
def test_a_link_shows_its_target_while_it_has_the_pointer_or_the_focus(page, link, shown):
    preview = page.locator(".preview")
    page.get_by_role("link", name=link).hover()
    assert preview.inner_text().strip() == shown
    page.locator("h2").hover()
    assert not preview.is_visible()
    page.get_by_role("link", name=link).focus()
    assert preview.is_visible()
    page.keyboard.press("Escape")
    assert not preview.is_visible()


def test_a_link_to_a_section_has_its_title_and_no_preview(page):
    link = page.get_by_role("link", name="section 2")
    link.hover()
    assert link.get_attribute("title") == "Two"
    assert not page.locator(".preview").is_visible()
