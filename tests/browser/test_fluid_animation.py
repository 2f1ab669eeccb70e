"""The page's frames of the fluid animation against the library's meshes."""

from base64 import b64decode

import numpy as np

from fieldrecon.meshes.simplex_mesh import SimplexMesh

NAME = "fluid_animation"


def unpacked(text, kind, scale):
    return np.frombuffer(b64decode(text), kind) / scale


def library(state, data, numbers):  # noqa: ARG001
    """The mesh is the Delaunay mesh of its points, so that the stored cells are not needed."""
    frame = data["frames"][state["step"]]
    mesh = SimplexMesh.delaunay(unpacked(frame["points"], "<u2", 65535).reshape(-1, 2))
    ink = unpacked(frame["ink"], "u1", 255)
    x, y = unpacked(data["rims"][state["step"]], "<u2", 65535).reshape(-1, 2).T
    return {
        "triangles": len(mesh.cells),
        "area": mesh.cell_measures @ ink[mesh.cells].mean(axis=1),
        "exactArea": abs(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2,
        "energies": [row[state["step"]] for row in data["energies"]],
    }


def test_the_page_computes_the_numbers_of_the_library(living):
    living.moves_everything(library)


def test_play_moves_to_the_end_and_stops(living):
    living.reset()
    play = living.page.get_by_role("button", name="Play")
    play.press("Enter")
    living.page.wait_for_function(
        "() => { const w = document.querySelector('.widget').widget;"
        " return w.state.step === w.data.times.length - 1; }"
    )
    living.page.get_by_role("button", name="Play").wait_for()
    living.agrees_with(library)


def test_play_can_be_paused(living):
    living.reset()
    living.page.get_by_role("button", name="Play").press("Enter")
    living.page.get_by_role("button", name="Pause").press("Enter")
    living.page.wait_for_timeout(800)
    assert living.state["step"] < len(living.data["times"]) - 1
