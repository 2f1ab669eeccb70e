"""The page's rank of B' and its conic against the report's singular values."""

import numpy as np
import pytest

from fieldrecon.meshes.simplex_mesh import SimplexMesh
from fieldreport.experiments.velocity.normal_matrix_rank import (
    conics_through,
    normal_matrix,
    one_ring,
)

NAME = "rank_of_star"


def mesh_of(points):
    n = len(points)
    around = np.arange(n)
    return SimplexMesh(
        np.vstack([[0, 0], points]),
        np.stack([0 * around, around + 1, (around + 1) % n + 1], axis=1),
    )


def library(state, data, numbers):  # noqa: ARG001
    mesh = mesh_of(state["points"])
    fit = one_ring(mesh, np.zeros(len(mesh.faces)))
    y = mesh.face_centers / np.abs(mesh.face_centers).max()
    s = np.linalg.svd(normal_matrix(y, mesh.face_normals), compute_uv=False)
    found = {"rank": int(fit.rank[0]), "determined": int(fit.determined[0])}
    return found | ({"ratio": s[-1] / s[0]} if found["rank"] == 6 else {})


def test_the_page_computes_the_numbers_of_the_library(living):
    living.moves_everything(library)


def test_four_triangles_leave_the_velocity_along_the_conic_undetermined(living):
    """The conic of the page is that through the vertices, and the unseen flow runs along it."""
    living.reset()
    (conic,) = conics_through(np.vstack([[0, 0], living.state["points"]])).T
    found = np.array(living.numbers["conic"])
    assert abs(abs(conic @ found) - 1) < 1e-12
    gradient, unseen = found[1:3], np.array(living.numbers["unseen"])
    assert abs(gradient @ unseen) < 1e-12 * np.linalg.norm(gradient)
    assert living.numbers["determined"] == 0


def test_a_small_step_off_the_conic_restores_the_rank(living):
    """The rank is six with a singular value of a few thousandths; on the conic nothing leaks."""
    living.press(living.controls("input[data-value='5']")[0], "Space")
    living.press(living.page.get_by_role("button", name="onto the conic"), "Enter")
    assert (living.numbers["rank"], living.numbers["leak"] < 1e-12) == (5, True)
    living.press(living.controls(".handle")[0], "Shift+ArrowUp")
    assert (living.numbers["rank"], living.numbers["leak"] < 1e-12) == (6, False)
    assert living.numbers["ratio"] < 0.01
    living.agrees_with(library)
    living.reset()


def test_the_cross_determines_the_velocity_although_the_rank_is_five(living):
    living.press(living.page.get_by_role("button", name="Cross"), "Enter")
    assert (living.numbers["rank"], living.numbers["determined"]) == (5, 1)
    living.agrees_with(library)


@pytest.mark.parametrize("triangles", [5, 6])
def test_vertices_on_one_conic_lose_the_rank(living, triangles):
    living.press(living.controls(f"input[data-value='{triangles}']")[0], "Space")
    assert living.numbers["rank"] == 6
    living.press(living.page.get_by_role("button", name="onto the conic"), "Enter")
    assert (living.numbers["rank"], living.numbers["determined"]) == (5, 0)
    living.agrees_with(library)
