"""The page's velocity of a triangle against the library's."""

import numpy as np

from fieldrecon.meshes.simplex_mesh import SimplexMesh
from fieldrecon.velocity.cells import cell_velocities
from fieldrecon.velocity.vertices import normal_velocities

NAME = "cell_velocity"


def gradient(state):
    angle = 2 * np.deg2rad(state["axis"])
    strain = [[np.cos(angle), np.sin(angle)], [np.sin(angle), -np.cos(angle)]]
    return np.array(
        {"rotation": [[0, -1], [1, 0]], "expansion": np.eye(2), "strain": strain}[state["motion"]]
    )


def library(state, data, numbers):  # noqa: ARG001
    mesh = SimplexMesh(np.array(state["corners"]), [[0, 1, 2]])
    center, g = mesh.circumcenters[0], gradient(state)
    velocity = cell_velocities(mesh, normal_velocities(mesh, (mesh.points - center) @ g.T)).values[
        0
    ]
    at_centroid = g @ (mesh.cell_centers[0] - center) - velocity
    error = float(np.linalg.norm(velocity))
    return {
        "center": center.tolist(),
        "radius": np.linalg.norm(mesh.points[0] - center),
        "place": (center + np.linalg.solve(g, velocity)).tolist(),
        "errorAtCentroid": np.linalg.norm(at_centroid),
    } | ({"velocity": velocity.tolist(), "errorAtCenter": error} if error > 1e-12 else {})


def test_the_page_computes_the_numbers_of_the_library(living):
    living.moves_everything(library)


def test_every_strain_lies_on_the_nine_point_circle(living):
    """A rotation has its velocity at the circumcentre, which does not lie there."""
    slider = living.controls("input[type=range]")[0]
    for _ in range(4):
        living.press(slider, *["ArrowRight"] * 15)
        assert living.numbers["offCircle"] < 1e-14
    living.press(living.controls("input[data-value=rotation]")[0], "Space")
    assert living.numbers["offCircle"] > 0.01
    assert living.numbers["errorAtCenter"] < 1e-14
