"""What all living figures have in common: phone, touch, print, no network, no script."""

import pytest

from fieldreport import widgets
from living_page import LivingPage, write_page

PHONE = {"width": 390, "height": 844}


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
    """The page does not scroll meanwhile."""
    living = open_page(viewport=PHONE, has_touch=True, is_mobile=True)
    finger = living.page.context.new_cdp_session(living.page)

    def touch(kind, *points):
        finger.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": list(points)})

    for handle in [h for h in living.controls(".handle") if h.is_visible()]:
        handle.scroll_into_view_if_needed()
        before, box = living.state, handle.bounding_box()
        top = living.page.evaluate("scrollY")
        x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
        touch("touchStart", {"x": x, "y": y})
        for step in (15, 30, 45):  # beyond the slop of a tap
            touch("touchMove", {"x": x + step, "y": y + step})
        touch("touchEnd")
        assert living.state != before
        assert living.page.evaluate("scrollY") == top


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
