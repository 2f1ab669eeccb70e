"""The point dragged about a cell: what is embedded is what the function says."""

import base64
import json
import re
import sys
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from fieldcheck import drag, figures
from fieldcheck.drag import NODES, UNIT, Dragged, dragged, lattice, walls

TURNS = np.exp(1j * np.pi * (2 * np.arange(6) + 1) / 6)
HEXAGON = np.stack([TURNS.real, TURNS.imag], axis=1)
UNEVEN = np.array([[2.0, 0.1], [1.2, 1.5], [-0.5, 1.3], [-0.9, -0.6], [0.8, -1.1]])
TRIANGLE = np.array([[0.0, 0.0], [3.0, 0.2], [1.0, 2.0]])
CELLS = {"hexagon": HEXAGON, "uneven": UNEVEN, "clockwise": UNEVEN[::-1], "triangle": TRIANGLE}
SVG = "{http://www.w3.org/2000/svg}"


def in_products(corners):
    """Weights of a convex polygon as products of distances to its walls, written without a mesh."""
    a, b, c = walls(corners).T

    def weights(x):
        depth = c - x @ np.stack([a, b])
        n = len(corners)
        sines = [abs(a[k - 1] * b[k] - b[k - 1] * a[k]) for k in range(n)]
        w = [sines[k] * np.delete(depth, [k - 1, k], axis=1).prod(axis=1) for k in range(n)]
        return np.stack(w, axis=1) / np.sum(w, axis=0)[:, None]

    return weights


def embedded(picture):
    """The data that the script holds."""
    return json.loads(re.search(r"const d = (\{.*\});", picture.html)[1])


def looked_up(data, place):
    """What the script does between four nodes."""
    (i, j), (u, v) = np.divmod((place - np.array(data["origin"])) / data["step"], 1)
    rows = [data["table"][int(j + b) * data["across"] + int(i + a)] for a, b in np.ndindex(2, 2)]
    shares = [abs(1 - a - u) * abs(1 - b - v) for a, b in np.ndindex(2, 2)]
    return UNIT * np.array(shares) @ np.array(rows)


@pytest.fixture(params=CELLS.values(), ids=CELLS.keys())
def cell(request):
    return request.param


def test_the_table_is_what_the_function_says(cell):
    """Node by node, to half of the unit that numbers are kept in."""
    weights = in_products(cell)
    data = lattice(weights, cell)
    used = [k for k, row in enumerate(data["table"]) if row]
    up, along = np.divmod(used, data["across"])
    nodes = np.array(data["origin"]) + data["step"] * np.stack([along, up], axis=1)
    table = np.array([data["table"][k] for k in used])
    assert len(used) > NODES**2 / 5
    assert abs(UNIT * table - weights(nodes)).max() <= UNIT / 2 + 1e-12


def test_between_the_nodes_the_look_up_is_close(cell):
    """All over the cell all four nodes are there, and three digits of the weights are right."""
    weights = in_products(cell)
    data = embedded(dragged(weights, cell, np.zeros(len(cell)), cell.mean(axis=0)))
    x = np.random.default_rng(1).dirichlet(np.full(len(cell), 0.5), 400) @ cell
    found = np.array([looked_up(data, place) for place in x])
    assert abs(found - weights(x)).max() < 4e-3
    assert abs(found.sum(axis=1) - 1).max() < 1e-3


def test_no_node_is_on_an_edge(cell):
    """There a quotient has no value, or a wrong one that nobody notices."""
    data = lattice(in_products(cell), cell)
    count = len(data["table"])
    up, along = np.divmod(np.arange(count), data["across"])
    nodes = np.array(data["origin"]) + data["step"] * np.stack([along, up], axis=1)
    a, b, c = walls(cell).T
    assert abs(nodes @ np.stack([a, b]) - c).min() > 1e-7


def test_the_static_picture_shows_the_start():
    """Bars, dots, the sum and the value at the start, without any script."""
    weights, start = in_products(HEXAGON), (0.3, -0.2)
    values = np.arange(6.0)
    picture = dragged(weights, HEXAGON, values, start)
    (w,) = weights(np.array([start]))
    image = re.search(r'src="data:image/svg\+xml;base64,([^"]*)"', picture.html)[1]
    assert base64.b64decode(image).decode() == picture.svg
    parts = {e.get("data-part"): e for e in ElementTree.fromstring(picture.svg).iter()}
    widths = [float(parts[f"bar{k}"].get("width")) for k in range(6)]
    assert np.allclose(widths, 92 * w, atol=0.01)
    areas = [float(parts[f"dot{k}"].get("r")) ** 2 for k in range(6)]
    assert np.allclose(areas, 26**2 * w, atol=1)
    assert [parts[f"number{k}"].text for k in range(6)] == [f"{weight:.3f}" for weight in w]
    assert parts["sum"].text.endswith("1.000")
    assert parts["value"].text.endswith(f"{w @ values:.3f}")
    for side in ("cx", "cy"):
        assert parts["mean"].get(side) == parts["point"].get(side)


def test_what_the_script_moves_is_in_the_picture():
    """Every name that the script asks for has an element, and nothing comes from a network."""
    picture = dragged(in_products(UNEVEN), UNEVEN, np.ones(5), (0.5, 0.2))
    names = {e.get("data-part") for e in ElementTree.fromstring(picture.svg).iter()}
    script = picture.html[picture.html.index("<script>") :]
    fixed = set(re.findall(r'(?:set|part)\("(\w+)"[,)]', script))
    numbered = set(re.findall(r'(?:set|part)\("(\w+)" \+ k', script))
    assert {"point", "mean", "sum", "value", "hint"} <= fixed
    assert numbered == {"dot", "bar", "ray", "number"}
    assert fixed | {f"{name}{k}" for name in numbered for k in range(5)} <= names
    assert not re.search(r"https?://(?!www\.w3\.org)|import\(|fetch\(", picture.html)


def test_it_has_the_same_bytes_each_time():
    """And is a mime bundle, so that every front end takes what it can show."""
    once, again = (dragged(in_products(UNEVEN), UNEVEN, np.ones(5), (0.5, 0.2)) for _ in range(2))
    assert once == again
    assert once.svg.isascii()
    assert set(once._repr_mimebundle_()) == {"text/html", "image/svg+xml", "text/plain"}


def test_values_that_are_not_finite_leave_holes():
    """A function that has no value at some nodes is shown where it has one."""

    def weights(x):
        return np.where(x[:, :1] < 0, np.nan, in_products(HEXAGON)(x))

    table = lattice(weights, HEXAGON)["table"]
    full = lattice(in_products(HEXAGON), HEXAGON)["table"]
    assert 0 < sum(map(bool, table)) < sum(map(bool, full))


def test_what_is_not_written_yet_is_waited_for(monkeypatch):
    """A sentence stands for the picture, and nothing crashes."""
    shown = []
    monkeypatch.setattr(sys.modules[drag.__module__], "display", shown.append)

    def coordinates(x):
        raise NotImplementedError("07.5 is not written yet")

    def weights(x):
        return coordinates(x)

    assert drag(HEXAGON, np.ones(6), (0, 0))(weights) is weights
    drag(HEXAGON, np.ones(6), (0, 0))(in_products(HEXAGON))
    assert isinstance(shown[0], figures.Sentence)
    assert repr(shown[0]) == "The picture waits for coordinates, not written yet."
    assert isinstance(shown[1], Dragged)


def test_walls_hold_the_cell(cell):
    """Corners lie on two walls each, the middle inside all; normals have length one."""
    a, b, c = walls(cell).T
    depth = c - cell @ np.stack([a, b])
    assert ((abs(depth) < 1e-12).sum(axis=1) == 2).all()
    assert depth.min() > -1e-12
    assert (c - cell.mean(axis=0) @ np.stack([a, b]) > 0).all()
    assert np.allclose(a**2 + b**2, 1)


def test_the_script_is_told_all_that_it_asks_for():
    """Each key of its data is written, and each that is written is read."""
    script = (Path(drag.__code__.co_filename).with_name("drag.js")).read_text(encoding="utf-8")
    data = embedded(dragged(in_products(TRIANGLE), TRIANGLE, np.ones(3), (1.2, 0.7)))
    assert set(re.findall(r"\bd\.(\w+)", script)) == set(data)
