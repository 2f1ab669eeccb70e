"""Counts of the vertices of a mesh that one ring determines, by their number of cells."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from fieldrecon.meshes.simplex_mesh import SimplexMesh
from fieldrecon.velocity.vertices import normal_velocities, vertex_velocities
from fieldreport.experiments.meshes.reference_flows import rotation
from fieldreport.experiments.velocity.normal_matrix_rank import (
    VANISHES,
    conics_through,
    error_by_conics,
    one_ring,
    vertices_around,
)
from fieldreport.framework.error_measures import order_of_magnitude
from fieldreport.framework.experiment import Cell

MOST = {False: 8, True: 5}
"""Numbers of triangles at interior and boundary vertices from which on rows are merged."""

VALENCES = (
    "where",
    "triangles",
    "vertices",
    "lowest rank",
    "highest rank",
    "determined by one ring",
    "took a second ring",
    "largest error, one ring",
    "largest error, rings as needed",
)


def counts_of_mesh(mesh: SimplexMesh) -> np.ndarray:
    """For each vertex of a mesh and a rotation, the columns that `valences` summarizes."""
    u = rotation(mesh.points, mesh.points.mean(axis=0))
    v = normal_velocities(mesh, u)
    first, all_rings = one_ring(mesh, v), vertex_velocities(mesh, v)
    found = first.values - u
    turn = rotation(np.eye(2), np.zeros(2)).T
    by_conics = [error_by_conics(mesh, i, u[i], turn) for i in range(len(u))]
    around = [vertices_around(mesh, i) for i in range(len(u))]
    return np.column_stack(
        [
            mesh.boundary_vertices,
            np.diff(mesh.vertex_cell_incidence.indptr),
            first.rank,
            first.determined,
            all_rings.rings,
            np.linalg.norm(found, axis=1),
            np.linalg.norm(all_rings.values - u, axis=1),
            [6 - conics_through(y / np.abs(y).max()).shape[1] for y in around],
            np.abs(found - by_conics).max(axis=1),
        ]
    )


def valences(counted: np.ndarray) -> Iterator[tuple[Cell, ...]]:
    """Return table rows for interior and boundary vertices, by their number of triangles."""
    for boundary, most in MOST.items():
        for n in range(1, most + 1):
            there = np.minimum(counted[:, 1], most) == n
            rows = counted[(counted[:, 0] == boundary) & there]
            if len(rows):
                _, _, rank, determined, rings, error, error_rings, *_ = rows.T
                yield (
                    "boundary" if boundary else "inside",
                    n if n < most else f"{n} and more",
                    len(rows),
                    int(rank.min()),
                    int(rank.max()),
                    int(determined.sum()),
                    int((rings > 1).sum()),
                    float(error.max()) if error.max() > VANISHES else 0.0,
                    order_of_magnitude(error_rings.max()),
                )


def facts_of_counts(counted: np.ndarray) -> dict[str, Cell]:
    """Compare ranks and errors with those predicted by the conics through the vertices."""
    determined = counted[:, 3] > 0
    return {
        "counted": len(counted),
        "rank_mismatches": (counted[:, 2] != counted[:, 7]).sum(),
        "undetermined_percent": 100 * (~determined).mean(),
        "determined_but_widened_percent": 100 * (determined & (counted[:, 4] > 1)).mean(),
        "difference_from_conics": order_of_magnitude(counted[:, 8].max()),
    }


SPACE = (
    "vertices",
    "undetermined by one ring",
    "undetermined inside",
    "one ring",
    "two rings",
    "more rings",
    "rank at its bound, %",
    "largest error, one ring",
    "largest error",
)


def rotation_in_space(mesh: SimplexMesh) -> tuple[Cell, ...]:
    """Count the rings that vertices of a mesh in space need; measure the errors of a rotation."""
    u = rotation(mesh.points, mesh.points.mean(axis=0))
    v = normal_velocities(mesh, u)
    first, all_rings = one_ring(mesh, v), vertex_velocities(mesh, v)
    faces, cells = (np.diff(x.indptr) for x in (mesh.faces_around(), mesh.vertex_cell_incidence))
    bound = np.minimum(12, faces - cells + 1)
    return (
        len(u),
        int((~first.determined).sum()),
        int((~first.determined & ~mesh.boundary_vertices).sum()),
        *(int((all_rings.rings == r).sum()) for r in (1, 2)),
        int((all_rings.rings > 2).sum()),
        float(100 * (first.rank == bound).mean()),
        float(np.linalg.norm(first.values - u, axis=1).max()),
        order_of_magnitude(np.abs(all_rings.values - u).max()),
    )
