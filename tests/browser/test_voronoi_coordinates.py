"""The page's Voronoi coordinates against the library's."""

import math

import numpy as np

from fieldrecon.barycentric.voronoi import voronoi_weights
from fieldrecon.meshes.simplex_mesh import SimplexMesh
from fieldreport.experiments.barycentric.hexagon_spiral import Star, quotients
from living_page import Rounded

NAME = "voronoi_coordinates"
NAMES = ("product", "quotient")


def star_of(state):
    around = np.arange(6)
    cells = np.stack([0 * around, around + 1, (around + 1) % 6 + 1], axis=1)
    return Star(SimplexMesh(np.vstack([[0, 0], state["corners"]]), cells), 0)


def library(state, data, numbers):  # noqa: ARG001
    star, x = star_of(state), np.array([state["query"]])
    product = voronoi_weights(star.mesh, 0, x).toarray()[0]
    with np.errstate(all="ignore"):
        quotient = quotients(star, x)[0]
    squares = (star.spokes**2).sum(axis=1)
    height = (0.5 - star.spokes @ x[0] / squares).min()
    digits = 1 / abs(height) if height else math.inf
    return {
        "centers": star.corners.tolist(),
        "product": [Rounded(w, digits) for w in product],
        "quotient": [Rounded(w, digits) for w in quotient],
        "smallest": Rounded(product.min(), digits / abs(product.min())),
    }


def test_the_page_computes_the_numbers_of_the_library(living):
    living.moves_everything(library)


def test_only_the_quotient_loses_its_digits_near_an_edge(living):
    living.press(living.controls("input[type=range]")[0], *["ArrowRight"] * 11)
    assert living.numbers["productError"] < 1e-14
    assert not living.numbers["quotientError"] < 1e-6


def test_the_query_stays_in_the_cell(living):
    """Far too many steps in one direction end at the boundary of the cell."""
    living.reset()
    living.press(living.controls(".handle.query")[0], *["ArrowRight"] * 60)
    assert min(living.numbers["product"]) > 0


def test_no_bar_covers_the_names_of_the_bars(living):
    """The first bar is above the others, and longest at the first circumcentre."""
    living.reset()
    query = living.controls(".handle.query")[0]
    living.press(query, *["ArrowRight"] * 60, *["ArrowUp"] * 10)
    names = [text for text in living.controls(".panels text") if text.text_content() in NAMES]
    bottom = max(box["y"] + box["height"] for box in (name.bounding_box() for name in names))
    bars = living.controls(".panels svg:last-of-type polygon.fill")
    assert len(names) == len(NAMES)
    assert bottom <= min(bar.bounding_box()["y"] for bar in bars if bar.bounding_box())
