"""The pictures of the notebooks can be drawn wherever their sliders are."""

import random

import numpy as np
import pytest
from matplotlib.figure import Figure

import fieldcheck
from graded_class import SOURCES


def pictures(source, monkeypatch):
    """All cells of a solved notebook run: its variables, and each picture with its sliders."""
    found = []

    def draw(**sliders):
        def keep(picture):
            found.append((picture, sliders))
            return picture

        return keep

    monkeypatch.setattr(fieldcheck, "draw", draw)
    monkeypatch.setattr(fieldcheck, "drag", lambda *_, **__: lambda weights: weights)
    monkeypatch.setattr(fieldcheck, "check", lambda _: None)
    monkeypatch.setattr(fieldcheck, "progress", lambda: None)
    namespace = {"__name__": source.name}
    for number, cell in enumerate(source.cells):
        if cell.kind == "code":
            exec(compile(cell.text, f"{source.name}, cell {number}", "exec"), namespace)
    return namespace, found


def somewhere(slider, choice):
    part = choice.random()
    if slider.whole:
        return int(slider.low + round(part * (slider.high - slider.low)))
    if slider.logarithmic:
        return slider.low * (slider.high / slider.low) ** part
    return slider.low + part * (slider.high - slider.low)


@pytest.mark.slow
@pytest.mark.parametrize("source", SOURCES.values(), ids=SOURCES)
def test_every_picture_is_drawn_at_any_position_of_its_sliders(source, monkeypatch):
    """At one end or the other and at a random place; the static picture shows the start only."""
    _, found = pictures(source, monkeypatch)
    choice = random.Random(source.number)
    assert any(sliders for _, sliders in found)
    for picture, sliders in found:
        ends = {name: choice.choice((s.low, s.high)) for name, s in sliders.items()}
        place = {name: somewhere(slider, choice) for name, slider in sliders.items()}
        for position in (ends, place) if sliders else ({},):
            assert isinstance(picture(**position), Figure), (picture.__name__, position)


def test_the_terrain_of_09_has_no_node_twice(monkeypatch):
    """A repeated site makes the system singular, and a held-out node is no site."""
    namespace, _ = pictures(SOURCES["09"], monkeypatch)
    sample = namespace["terrain_sample"]
    held_out, sites = sample(0, 400)[0], sample(400, 300)[0]
    assert len(np.unique(np.concatenate([held_out, sites]), axis=0)) == 700
