"""Errors and omissions of the appendix on mesh errors.

Here triangles are counted by the definitions; the audit is tested as well.
"""

import itertools
from collections import Counter

import numpy as np
import pytest

from exact_triangles import edge_counts, fans
from fieldrecon.triangles.audit import audit_mesh
from fieldreport.experiments.triangles.planted_errors import planted_errors
from fieldreport.experiments.triangles.triangle_shapes import band, cube, sphere, turned_over

PLANTED = planted_errors(1)


def is_manifold(triangles):
    """Every edge has at most two triangles; the triangles at a vertex are connected by edges."""
    vertices = {int(v) for t in triangles for v in t}
    crowded = any(count > 2 for count in edge_counts(triangles).values())
    return not crowded and all(fans(triangles, v) == 1 for v in vertices)


@pytest.mark.parametrize(
    ("error", "concern"),
    [
        ("hole", "boundary"),
        ("flipped triangle", "orientation"),
        ("crossing", "embedding"),
        ("overlap", "embedding"),
    ],
)
def test_most_listed_errors_occur_in_manifolds(error, concern):
    """A hole, a flipped triangle, a crossing and an overlap each occur in a manifold mesh."""
    points, triangles = PLANTED[error].surface
    assert is_manifold(triangles)
    counts = audit_mesh(points, triangles).counts
    assert any(counts[concern].values())
    assert not any(counts["manifoldness"].values())


@pytest.mark.parametrize("error", ["edge of four triangles", "bow-tie"])
def test_the_two_kinds_of_non_manifold_are_not_listed(error):
    """The mesh has no duplicates, no boundary, no flipped triangles and no intersections.

    Yet it is not a manifold.
    """
    points, triangles = PLANTED[error].surface
    counts = edge_counts(triangles)
    assert not is_manifold(triangles)
    assert len({frozenset(t) for t in triangles.tolist()}) == len(triangles)
    assert len({tuple(p) for p in points.tolist()}) == len(points)
    assert set(counts.values()) <= {2, 4}
    sides = Counter((int(t[k]), int(t[k - 2])) for t in triangles for k in range(3))
    assert all(sides[a, b] == sides[b, a] for a, b in counts)  # no triangle is flipped
    audit = audit_mesh(points, triangles)
    assert {*audit.found} == {*PLANTED[error].found}
    assert any(audit.counts["manifoldness"].values())


@pytest.mark.parametrize("error", ["degenerate triangle", "unreferenced vertex", "T-junction"])
def test_further_errors_are_not_listed(error):
    """They are triangles without area, unreferenced vertices, and vertices inside an edge."""
    assert audit_mesh(*PLANTED[error].surface).found == PLANTED[error].found


def test_duplicate_edges_are_other_errors():
    """Triangles refer to vertices, so an edge cannot be stored twice.

    Two coincident edges are either one edge with three triangles or two boundary edges with
    duplicate vertices.
    """
    points, triangles = sphere(1)
    sides = {frozenset((int(t[k]), int(t[k - 1]))) for t in triangles for k in range(3)}
    assert len(sides) == len(edge_counts(triangles)) == 3 * len(triangles) // 2
    points, triangles = PLANTED["duplicate vertex"].surface
    free = [edge for edge, count in edge_counts(triangles).items() if count == 1]
    locations = Counter(frozenset(tuple(points[v].tolist()) for v in edge) for edge in free)
    assert sorted(locations.values()) == [2, 2]
    audit = audit_mesh(points, triangles)
    assert {tuple(sorted(e)) for e in audit.free_edge_pairs.reshape(-1, 2).tolist()} == {*free}


def test_duplicates_hide_the_topology_of_the_surface():
    """A duplicate triangle in a closed cube gives three edges of three triangles.

    In a polygon soup every edge is free.
    """
    points, triangles = cube(1)
    again = np.concatenate([triangles, triangles[:1]])
    sides = Counter(frozenset((int(t[k]), int(t[k - 1]))) for t in again for k in range(3))
    assert sorted(sides.values()) == [2] * 15 + [3] * 3
    assert audit_mesh(points, again).found == {"duplicate_triangles": 1}
    soup = np.arange(36).reshape(-1, 3)
    assert [*edge_counts(soup).values()] == [1] * 36
    assert 36 - len({tuple(p) for p in points[triangles].reshape(-1, 3).tolist()}) == 28
    audit = audit_mesh(points[triangles].reshape(-1, 3), soup)
    assert audit.soup
    assert audit.clean


def test_consistent_normals_need_not_exist_and_do_not_suffice():
    """A Möbius band has no consistent orientation. An inverted sphere has one, but it is wrong."""
    _, triangles = band(4, half_turns=1)
    for ways in itertools.product([False, True], repeat=len(triangles)):
        oriented = np.where(np.array(ways)[:, None], triangles[:, ::-1], triangles)
        sides = [(int(t[k]), int(t[k - 2])) for t in oriented for k in range(3)]
        assert len({*sides}) < len(sides)
    assert "flipped_triangles" not in audit_mesh(*band(4, half_turns=1)).found
    points, triangles = turned_over(sphere(1))
    sides = [(int(t[k]), int(t[k - 2])) for t in triangles for k in range(3)]
    assert len({*sides}) == len(sides)
    assert np.linalg.det(points[triangles]).sum() < 0
    assert audit_mesh(points, triangles).found == {"inside_out_triangles": 80}
