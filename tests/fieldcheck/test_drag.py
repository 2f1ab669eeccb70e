"""The draggable point in a cell: the embedded table agrees with the student's function."""

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


def product_weights(corners):
    """Weights of a convex polygon as products of the distances to its edges, without a mesh."""
    a, b, c = walls(corners).T

    def weights(x):
        depth = c - x @ np.stack([a, b])
        n = len(corners)
        sines = [abs(a[k - 1] * b[k] - b[k - 1] * a[k]) for k in range(n)]
        w = [sines[k] * np.delete(depth, [k - 1, k], axis=1).prod(axis=1) for k in range(n)]
        return np.stack(w, axis=1) / np.sum(w, axis=0)[:, None]

    return weights


def embedded(picture):
    """The data embedded in the script."""
    return json.loads(re.search(r"const d = (\{.*\});", picture.html)[1])


def interpolated(data, place):
    """Bilinear interpolation in the embedded table, as the script does it."""
    (i, j), (u, v) = np.divmod((place - np.array(data["origin"])) / data["step"], 1)
    rows = [data["table"][int(j + b) * data["across"] + int(i + a)] for a, b in np.ndindex(2, 2)]
    shares = [abs(1 - a - u) * abs(1 - b - v) for a, b in np.ndindex(2, 2)]
    return UNIT * np.array(shares) @ np.array(rows)


@pytest.fixture(params=CELLS.values(), ids=CELLS.keys())
def cell(request):
    return request.param


def test_the_embedded_table_agrees_with_the_function(cell):
    """At every node, up to half the unit in which numbers are stored."""
    weights = product_weights(cell)
    data = lattice(weights, cell)
    used = [k for k, row in enumerate(data["table"]) if row]
    up, along = np.divmod(used, data["across"])
    nodes = np.array(data["origin"]) + data["step"] * np.stack([along, up], axis=1)
    table = np.array([data["table"][k] for k in used])
    assert len(used) > NODES**2 / 5
    assert abs(UNIT * table - weights(nodes)).max() <= UNIT / 2 + 1e-12


def test_interpolation_between_nodes_has_a_small_error(cell):
    """All four nodes exist everywhere in the cell, and the weights have three correct digits."""
    weights = product_weights(cell)
    data = embedded(dragged(weights, cell, np.zeros(len(cell)), cell.mean(axis=0)))
    x = np.random.default_rng(1).dirichlet(np.full(len(cell), 0.5), 400) @ cell
    found = np.array([interpolated(data, place) for place in x])
    assert abs(found - weights(x)).max() < 4e-3
    assert abs(found.sum(axis=1) - 1).max() < 1e-3


def test_no_node_is_on_an_edge(cell):
    """On an edge a quotient has no value, or a wrong value that nobody notices."""
    data = lattice(product_weights(cell), cell)
    count = len(data["table"])
    up, along = np.divmod(np.arange(count), data["across"])
    nodes = np.array(data["origin"]) + data["step"] * np.stack([along, up], axis=1)
    a, b, c = walls(cell).T
    assert abs(nodes @ np.stack([a, b]) - c).min() > 1e-7


def test_the_static_picture_shows_the_start():
    """Bars, dots, the sum and the value are drawn without a script."""
    weights, start = product_weights(HEXAGON), (0.3, -0.2)
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


def test_every_element_used_by_the_script_is_in_the_picture():
    """Nothing is loaded from the network."""
    picture = dragged(product_weights(UNEVEN), UNEVEN, np.ones(5), (0.5, 0.2))
    names = {e.get("data-part") for e in ElementTree.fromstring(picture.svg).iter()}
    script = picture.html[picture.html.index("<script>") :]
    fixed = set(re.findall(r'(?:set|part)\("(\w+)"[,)]', script))
    numbered = set(re.findall(r'(?:set|part)\("(\w+)" \+ k', script))
    assert {"point", "mean", "sum", "value", "hint"} <= fixed
    assert numbered == {"dot", "bar", "ray", "number"}
    assert fixed | {f"{name}{k}" for name in numbered for k in range(5)} <= names
    assert not re.search(r"https?://(?!www\.w3\.org)|import\(|fetch\(", picture.html)


def test_the_picture_is_reproducible():
    """The picture is a MIME bundle, so that each front end shows the format it supports."""
    once, again = (
        dragged(product_weights(UNEVEN), UNEVEN, np.ones(5), (0.5, 0.2)) for _ in range(2)
    )
    assert once == again
    assert once.svg.isascii()
    assert set(once._repr_mimebundle_()) == {"text/html", "image/svg+xml", "text/plain"}


def test_values_that_are_not_finite_are_left_out_of_the_table():
    """The function is shown where it has a value."""

    def weights(x):
        return np.where(x[:, :1] < 0, np.nan, product_weights(HEXAGON)(x))

    table = lattice(weights, HEXAGON)["table"]
    full = lattice(product_weights(HEXAGON), HEXAGON)["table"]
    assert 0 < sum(map(bool, table)) < sum(map(bool, full))


def test_an_unwritten_function_gives_a_sentence_instead_of_a_picture(monkeypatch):
    shown = []
    monkeypatch.setattr(sys.modules[drag.__module__], "display", shown.append)

    def coordinates(x):
        raise NotImplementedError("07.5 is not written yet")

    def weights(x):
        return coordinates(x)

    assert drag(HEXAGON, np.ones(6), (0, 0))(weights) is weights
    drag(HEXAGON, np.ones(6), (0, 0))(product_weights(HEXAGON))
    assert isinstance(shown[0], figures.Sentence)
    assert repr(shown[0]) == "The picture waits for coordinates, not written yet."
    assert isinstance(shown[1], Dragged)


def test_walls_bound_the_cell(cell):
    """Each corner is on two walls, the mean is inside all of them, and normals are unit vectors."""
    a, b, c = walls(cell).T
    depth = c - cell @ np.stack([a, b])
    assert ((abs(depth) < 1e-12).sum(axis=1) == 2).all()
    assert depth.min() > -1e-12
    assert (c - cell.mean(axis=0) @ np.stack([a, b]) > 0).all()
    assert np.allclose(a**2 + b**2, 1)


def test_the_script_uses_exactly_the_embedded_keys():
    script = (Path(drag.__code__.co_filename).with_name("drag.js")).read_text(encoding="utf-8")
    data = embedded(dragged(product_weights(TRIANGLE), TRIANGLE, np.ones(3), (1.2, 0.7)))
    assert set(re.findall(r"\bd\.(\w+)", script)) == set(data)
