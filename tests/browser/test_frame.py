"""What all living figures have in common: phone, touch, print, no network, no script."""

import pytest

from fieldreport import widgets
from living_page import LivingPage, write_page

PHONE = {"width": 390, "height": 844}
LETTERS = """() => [...document.querySelectorAll(".living svg text")]
    .filter(text => text.textContent.trim())
    .map(text => {
        const box = text.getBoundingClientRect()
        const size = parseFloat(getComputedStyle(text).fontSize) * text.getScreenCTM().a
        return [text.textContent, size, box.left, box.right, box.top, box.bottom]
    })"""
"""The texts of the panels, the size of their letters in pixels, and the boxes around them."""
READABLE = 4.5
"""The least contrast of text with its ground, by the Web Content Accessibility Guidelines."""
CONTRASTS = """() => {
    const linear = c => c <= 0.03928 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4
    const channels = colour => colour.match(/[\\d.]+/g).map(Number)
    const luminance = colour => {
        const [r, g, b] = channels(colour).map(c => linear(c / 255))
        return 0.2126 * r + 0.7152 * g + 0.0722 * b
    }
    const ground = element => {
        const own = element && getComputedStyle(element).backgroundColor
        if (!element) return "rgb(255, 255, 255)"
        return channels(own)[3] === 0 ? ground(element.parentElement) : own
    }
    const contrast = element => {
        const style = getComputedStyle(element)
        const ink = element instanceof SVGElement ? style.fill : style.color
        const [dark, light] = [luminance(ink), luminance(ground(element))].sort((a, b) => a - b)
        return (light + 0.05) / (dark + 0.05)
    }
    return [...document.querySelectorAll(".living *")]
        .filter(e => [...e.childNodes].some(n => n.nodeType === 3 && n.textContent.trim()))
        .filter(e => e.getClientRects().length && !e.matches("style, script, option, title"))
        .map(e => [contrast(e), e.textContent.trim()])
}"""


@pytest.fixture(scope="module", params=widgets.names())
def path(request, tmp_path_factory):
    return request.param, write_page(request.param, tmp_path_factory.mktemp("page"))


@pytest.fixture
def open_page(browser, path):
    """Open the page of a living figure in a context with given options."""
    contexts = []

    def open_in(**options):
        contexts.append(browser.new_context(offline=True, **options))
        return LivingPage(contexts[-1].new_page(), path[1], path[0])

    yield open_in
    for context in contexts:
        context.close()


def test_on_a_phone_nothing_is_wider_than_the_screen(open_page):
    """Handles are moved by a finger, which has a target of 24 pixels or more."""
    living = open_page(viewport=PHONE, has_touch=True, is_mobile=True)
    assert living.page.evaluate("document.documentElement.scrollWidth") <= PHONE["width"]
    for control in [*living.controls("input[type=range]"), *living.controls(".bar button")]:
        assert control.bounding_box()["height"] >= 24
    for target in living.controls(".handle .touch"):
        box = target.bounding_box()
        assert box is None or box["width"] >= 24


def test_the_page_makes_no_request_and_reports_no_error(open_page):
    living = open_page()
    assert [url for url in living.requests if not url.startswith(("file:", "data:"))] == []
    assert living.problems == []


def test_every_control_has_a_name_for_a_screen_reader(open_page):
    living = open_page()
    unnamed = """() => [...document.querySelectorAll(".living input, .living button, .handle")]
        .filter(c => c.getClientRects().length)
        .filter(c => !(c.closest("label") || c).textContent.trim() && !c.ariaLabel).length"""
    assert living.page.evaluate(unnamed) == 0


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_all_text_can_be_read(open_page, scheme):
    """On the background of each colour scheme."""
    found = open_page(color_scheme=scheme).page.evaluate(CONTRASTS)
    assert len(found) > 5
    assert [(c, text) for c, text in found if c < READABLE] == []


@pytest.mark.parametrize("viewport", [PHONE, {"width": 1280, "height": 900}])
def test_letters_of_panels_are_large_and_do_not_touch(open_page, viewport):
    """Of 11 pixels or more; ticks, titles and labels are apart by what their boxes leave free."""
    texts = open_page(viewport=viewport).page.evaluate(LETTERS)
    assert [(text, size) for text, size, *_ in texts if size < 10.9] == []
    free = 2  # a box contains the space for accents and descenders
    for k, (one, _, left, right, top, bottom) in enumerate(texts):
        for other, _, left2, right2, top2, bottom2 in texts[:k]:
            across = min(right, right2) - max(left, left2)
            down = min(bottom, bottom2) - max(top, top2)
            assert across < free or down < free + 1, (one, other)


def test_a_handle_follows_the_pointer(open_page):
    living = open_page(viewport={"width": 900, "height": 1400})
    for handle in [h for h in living.controls(".handle") if h.is_visible()]:
        before, box = living.state, handle.bounding_box()
        x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
        living.page.mouse.move(x, y)
        living.page.mouse.down()
        living.page.mouse.move(x + 9, y + 7, steps=4)
        living.page.mouse.up()
        assert living.state != before


def test_a_handle_follows_a_finger(open_page):
    """To the end of its way, and the page does not scroll meanwhile."""
    living = open_page(viewport=PHONE, has_touch=True, is_mobile=True)
    living.page.add_style_tag(content="body { padding-bottom: 3000px }")
    living.page.evaluate("addEventListener('pointercancel', () => { window.stopped = true; })")
    finger = living.page.context.new_cdp_session(living.page)

    def touch(kind, *points):
        finger.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": list(points)})

    for handle in [h for h in living.controls(".handle") if h.is_visible()]:
        handle.scroll_into_view_if_needed()
        before, box = living.state, handle.bounding_box()
        top = living.page.evaluate("scrollY")
        x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
        touch("touchStart", {"x": x, "y": y})
        for step in range(6, 50, 6):  # beyond the slop of a tap
            touch("touchMove", {"x": x + step / 3, "y": y - step})
        touch("touchEnd")
        assert living.state != before
        assert living.page.evaluate("scrollY") == top
    assert not living.page.evaluate("window.stopped || false")


def test_the_printed_figure_is_one_button_away_and_in_print(open_page):
    living = open_page()
    picture, panels = living.page.locator(".widget .picture"), living.page.locator(".panels")
    assert (picture.is_visible(), panels.is_visible()) == (False, True)
    living.page.get_by_role("button", name="Printed figure").press("Enter")
    assert (picture.is_visible(), panels.is_visible()) == (True, False)
    living.page.get_by_role("button", name="Printed figure").press("Enter")
    living.page.emulate_media(media="print")
    assert (picture.is_visible(), panels.is_visible()) == (True, False)


def test_without_a_script_the_picture_stays(browser, path):
    context = browser.new_context(java_script_enabled=False)
    page = context.new_page()
    page.goto(path[1].as_uri())
    assert page.locator(".widget .picture").is_visible()
    assert not page.locator(".lead").is_visible()
    context.close()
