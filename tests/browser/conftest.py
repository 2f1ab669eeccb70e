"""The living figures in a real browser: Chromium of the distribution, driven by Playwright."""

import os
import shutil

import pytest

from living_page import LivingPage, write_page

PROGRAMS = ("chromium", "chromium-browser", "google-chrome")
MISSING = (
    "test-browser needs Chromium, which is not on the PATH. Install it (Debian, Ubuntu: "
    "sudo apt-get install chromium), or set CHROMIUM=/path/to/chromium."
)


@pytest.fixture(scope="session")
def browser():
    program = os.environ.get("CHROMIUM") or next(filter(None, map(shutil.which, PROGRAMS)), None)
    if program is None:
        pytest.exit(MISSING, returncode=1)
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        started = playwright.chromium.launch(executable_path=program, args=["--no-sandbox"])
        yield started
        started.close()


@pytest.fixture(scope="module")
def living(request, browser, tmp_path_factory):
    """The living figure that the test module names, on a page of its own."""
    path = write_page(request.module.NAME, tmp_path_factory.mktemp("page"))
    context = browser.new_context(viewport={"width": 900, "height": 900}, offline=True)
    yield LivingPage(context.new_page(), path, request.module.NAME)
    context.close()
