"""A page with one living figure: its controls by keyboard, and its numbers against the library."""

import json
import math
from functools import cache

from checkout import ROOT
from fieldreport import experiments, widgets
from fieldreport.build.widget_scripts import SCRIPTS, data_file, embedded
from fieldreport.build.widgets import as_json

SOURCE = ROOT / "report"
TOLERANCE = 1e-9
ROUNDING = 1e-15
PAGE = """<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<style>{style}</style>
</head>
<body><main>
<div class="widget" data-widget="{name}">
<figure>
<img class="picture" alt="The printed figure" src="data:image/svg+xml,<svg xmlns='http://www.w3.org/2000/svg'/>">
<figcaption>Caption.</figcaption>
</figure>
<div class="lead" hidden><p>Instruction.</p></div>
</div>
</main>
{scripts}
</body>
</html>
"""
EVALUATE = """() => {{
  const living = document.querySelector(".widget").widget;
  if (living.frame) living.refresh();
  return JSON.stringify(({function})(living));
}}"""


def write_page(name, folder):
    """Write a page as the build does, with the style and the scripts of the report."""
    path = data_file(folder, name)
    path.parent.mkdir()
    path.write_bytes(data_of(name))
    style = (SOURCE / "style.css").read_text(encoding="utf-8")
    page = PAGE.format(style=style, name=name, scripts=SCRIPTS)
    written = folder / "page.html"
    written.write_text(embedded(page, SOURCE, folder), encoding="utf-8")
    return written


@cache
def data_of(name):
    used = [experiments.get(other) for other in widgets.uses(name)]
    return as_json(widgets.data(name, [one.run(one.quick) for one in used]))


class Rounded(float):
    """A number of the library with the condition number that limits its digits."""

    def __new__(cls, value, condition):
        made = super().__new__(cls, value)
        made.condition = condition
        return made


class LivingPage:
    """The page in the browser."""

    def __init__(self, page, path, name):
        self.page, self.path, self.name = page, path, name
        self.problems = []
        self.requests = []
        page.on("pageerror", lambda error: self.problems.append(str(error)))
        page.on("console", lambda message: self.problems.append(message.text))
        page.on("request", lambda request: self.requests.append(request.url))
        self.open()

    def open(self):
        self.page.goto(self.path.as_uri())
        self.page.wait_for_function(
            "Object.keys(document.querySelector('.widget').widget.numbers).length"
        )
        self.data = self.evaluate("w => w.data")

    def evaluate(self, function):
        """Evaluate a function of the living figure; what waits for the next frame is computed."""
        return json.loads(self.page.evaluate(EVALUATE.format(function=function)))

    @property
    def state(self):
        return self.evaluate("w => w.state")

    @property
    def numbers(self):
        return self.evaluate("w => w.numbers")

    def controls(self, selector):
        return self.page.locator(f".widget {selector}").all()

    def press(self, control, *keys):
        """Press keys on a control, which must change the state."""
        before = self.state
        control.focus()
        for key in keys:
            control.press(key)
        assert self.state != before, f"{keys} changed nothing"

    def agrees_with(self, library):
        """Compare numbers of the page with those of the library, for the state of the page."""
        state, found = self.state, self.numbers
        expected = library(state, self.data, found)
        assert set(expected) <= set(found)
        for key, value in expected.items():
            compare(found[key], value, f"{key} for {state}")
        assert self.problems == []

    def moves_everything(self, library):
        """Move every slider and handle, and choose every choice, by keyboard; compare each time."""
        self.agrees_with(library)
        for slider in self.controls("input[type=range]"):
            for keys in (["ArrowRight"] * 3, ["Home"], ["End"], ["ArrowLeft"] * 5):
                self.press(slider, *keys)
                self.agrees_with(library)
        for choice in self.controls("input[type=radio]"):
            if not choice.is_checked():
                self.press(choice, "Space")
                self.agrees_with(library)
        for handle in [h for h in self.controls(".handle") if h.is_visible()]:
            for keys in (
                ["ArrowRight", "ArrowUp"],
                ["Shift+ArrowLeft"],
                ["ArrowDown", "ArrowDown"],
            ):
                self.press(handle, *keys)
                self.agrees_with(library)
        for button in [b for b in self.controls(".bar button.own") if b.is_enabled()]:
            self.press(button, "Enter")
            self.agrees_with(library)
        self.reset()
        self.agrees_with(library)

    def reset(self):
        self.page.get_by_role("button", name="Reset").press("Enter")
        assert self.state == self.evaluate("w => w.initial")


def compare(found, expected, what, size=0):
    """Compare numbers to the tolerance of the page; those of a list relative to its largest."""
    if isinstance(expected, list):
        assert len(found) == len(expected), what
        size = max((abs(x) for x in expected if isinstance(x, float)), default=0)
        for one, other in zip(found, expected, strict=True):
            compare(one, other, what, size)
        return
    tolerance = max(TOLERANCE, ROUNDING * getattr(expected, "condition", 0))
    if tolerance >= 1:  # no digit is certain
        return
    close = math.isclose(found, expected, rel_tol=tolerance, abs_tol=tolerance * size)
    assert close, f"{what}: {found} is not {expected}"
