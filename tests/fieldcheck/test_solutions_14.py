"""The solutions of notebook 14 agree with the library."""

import numpy as np
import pytest

from checkout import ROOT
from fieldcheck.datasets import kleopatra
from fieldcheck.inputs.surfaces import (
    ball,
    band,
    book,
    flipped,
    fused,
    joined,
    ring,
    sheet,
    shuffled,
    without,
)
from fieldgrade.authoring.sources import Source
from fieldrecon.triangles.audit import audit_mesh
from fieldrecon.triangles.duplicates import merged_vertices
from fieldrecon.triangles.half_edges import HalfEdges
from fieldrecon.triangles.repair import repair_mesh

NOTEBOOK = Source(ROOT / "solutions/14_mesh_errors.py").functions()
SURFACES = {
    "sphere": ball(),
    "torus": ring(4, 7),
    "holes": without(ball(3, 6), 0, 1, 30),
    "parts": joined(sheet(2, 3), ball(2, 5), band(0, 6)),
    "one side": joined(band(1, 6), sheet(1, 2)),
    "three turns": band(3, 9),
    "bow-tie": fused(joined(ball(2, 5), ball(2, 4)), (3, 14)),
    "pages": joined(book(3), ball(2, 3), book(5)),
}
every_surface = pytest.mark.parametrize("surface", SURFACES.values(), ids=SURFACES)


@pytest.fixture
def random():
    return np.random.default_rng(1414)


def test_merged_vertices_agree_with_the_library(random):
    """The clusters are narrower than the tolerance and far apart."""
    for _ in range(20):
        place = random.integers(0, 40, (12, 3)).astype(float)
        points = np.repeat(place, 3, axis=0) + random.uniform(-0.05, 0.05, (36, 3))
        points = points[random.permutation(36)]
        np.testing.assert_array_equal(NOTEBOOK["weld"](points, 0.2), merged_vertices(points, 0.2))


@every_surface
def test_edge_counts_agree_with_the_library(random, surface):
    """Boundary edges, edges of more than two triangles and the Euler characteristic agree."""
    points, triangles = shuffled(random, flipped(random, surface), 4)
    half_edges = HalfEdges(triangles, len(points))
    count = NOTEBOOK["triangles_at_sides"](triangles)
    np.testing.assert_array_equal(np.flatnonzero(count == 1), half_edges.free_sides)
    ends = np.sort(NOTEBOOK["sides"](triangles)[count > 2], axis=1)
    np.testing.assert_array_equal(np.unique(ends, axis=0), half_edges.nonmanifold_edges)
    assert (1 / count).sum() == pytest.approx(len(half_edges.edges))
    chi = len(np.unique(triangles)) - len(half_edges.edges) + len(triangles)
    assert NOTEBOOK["euler_characteristic"](triangles) == chi


@every_surface
def test_boundary_loops_and_fans_agree_with_the_audit(random, surface):
    """Loops are compared if the boundary consists of loops."""
    points, triangles = shuffled(random, flipped(random, surface), 4)
    audit = audit_mesh(points, triangles)
    fans = NOTEBOOK["fans"](len(points), triangles)
    np.testing.assert_array_equal(np.flatnonzero(fans > 1), audit.bow_tie_vertices)
    np.testing.assert_array_equal(np.flatnonzero(fans == 0), audit.unreferenced_vertices)
    if len(audit.nonmanifold_edges) == 0:
        loop = NOTEBOOK["boundary_loops"](len(points), triangles)
        mine = {frozenset(np.flatnonzero(loop == k).tolist()) for k in np.unique(loop[loop >= 0])}
        assert mine == {frozenset(vertices.tolist()) for vertices in audit.boundary_loops}


@every_surface
def test_oriented_triangles_pass_the_audit(random, surface):
    """Triangles of a one-sided part have the sign zero."""
    points, triangles = shuffled(random, flipped(random, surface))
    audit = audit_mesh(points, triangles)
    if len(audit.nonmanifold_edges):
        return
    turn = NOTEBOOK["turns"](points, triangles)
    np.testing.assert_array_equal(np.flatnonzero(turn == 0), audit.one_sided_triangles)
    mended = np.where(turn[:, None] < 0, triangles[:, ::-1], triangles)
    assert len(audit_mesh(points, mended).flipped_triangles) == 0
    if (turn < 0).any():
        assert len(audit.flipped_triangles) > 0


def test_the_euler_characteristic_of_a_repaired_torus_is_zero(random):
    """The library repairs a polygon soup of a torus with errors."""
    points, triangles = shuffled(random, flipped(random, ring(5, 8)))
    soup = points[triangles].reshape(-1, 3), np.arange(triangles.size).reshape(-1, 3)
    assert NOTEBOOK["euler_characteristic"](soup[1]) == len(triangles)
    welds = NOTEBOOK["weld"](soup[0], 1e-9)[soup[1]]
    assert NOTEBOOK["euler_characteristic"](welds) == 0
    assert NOTEBOOK["euler_characteristic"](repair_mesh(*soup).triangles) == 0


def test_degenerate_triangles_agree_with_the_audit(random):
    """Needles, caps and repeated vertices are far below the tolerance, others far above it."""
    points = random.normal(size=(60, 3))
    triangles = np.arange(60).reshape(-1, 3)
    for t in (0, 5, 9):
        points[triangles[t, 1]] = points[triangles[t, 0]] + 1e-12 * random.normal(size=3)
    for t in (2, 11):
        a, b = points[triangles[t, :2]]
        points[triangles[t, 2]] = 0.3 * a + 0.7 * b + 1e-12 * random.normal(size=3)
    triangles[15, 2] = triangles[15, 0]
    flat = NOTEBOOK["flat"](points, triangles, 1e-9)
    np.testing.assert_array_equal(np.flatnonzero(flat), [0, 2, 5, 9, 11, 15])
    audit = audit_mesh(points, triangles, tol=1e-9)
    np.testing.assert_array_equal(np.flatnonzero(flat), audit.degenerate_triangles)


@pytest.mark.slow
def test_intersecting_triangles_agree_with_the_audit(random):
    """Random pairs are compared with the exact predicates of the audit."""
    crossings = 0
    for _ in range(60):
        points = random.normal(size=(6, 3))
        corners = points[[[3, 4, 5]] * 3 + [[0, 1, 2]] * 3]
        start, end = points, points[[1, 2, 0, 4, 5, 3]]
        mine = NOTEBOOK["pierced"](start, end, corners).any()
        assert mine == len(audit_mesh(points, [[0, 1, 2], [3, 4, 5]]).crossings)
        crossings += mine
    assert 10 < crossings < 50


def test_connected_parts_agree_with_powers_of_the_graph(random):
    """`connected` is a helper given to students."""
    for _ in range(20):
        links = random.integers(0, 30, (18, 2))
        least = NOTEBOOK["connected"](30, links)
        graph = np.eye(30, dtype=bool)
        graph[links[:, 0], links[:, 1]] = graph[links[:, 1], links[:, 0]] = True
        for _ in range(5):
            graph = graph @ graph
        np.testing.assert_array_equal(least, graph.argmax(axis=1))


def test_the_example_of_two_triangles():
    """A square of two triangles: its sides, counts, characteristic, loop and fans."""
    square = np.array([[0, 1, 2], [0, 2, 3]])
    counts = NOTEBOOK["triangles_at_sides"](square)
    np.testing.assert_array_equal(counts, [1, 1, 2, 2, 1, 1])
    assert NOTEBOOK["euler_characteristic"](square) == 1
    np.testing.assert_array_equal(NOTEBOOK["boundary_loops"](5, square), [0, 0, 0, 0, -1])
    np.testing.assert_array_equal(NOTEBOOK["fans"](5, square), [1, 1, 1, 1, 0])


def test_the_examples_of_geometry():
    """A chain of points, a flat triangle, and a segment through a triangle."""
    chain = np.array([[0.0], [0.9], [1.8], [2.7]])
    np.testing.assert_array_equal(NOTEBOOK["weld"](chain, 1.0), [0, 0, 1, 2])
    points, first = np.array([[0.0, 0, 0], [4, 0, 0], [1, 0.3, 0]]), np.array([[0, 1, 2]])
    for tolerance, flat in ((0.31, True), (0.29, False)):
        assert NOTEBOOK["flat"](points, first, tolerance)[0] == flat
    start, end = np.array([[1.0, 1, 2], [1, 1, 2]]), np.array([[1.0, 1, -2], [1, 1, 1]])
    corners = np.tile([[0.0, 0, 0], [4, 0, 0], [0, 4, 0]], (2, 1, 1))
    np.testing.assert_array_equal(NOTEBOOK["pierced"](start, end, corners), [True, False])


def test_the_asteroid_is_a_sphere_until_vertices_collapse():
    """Vertices merged within 5 km leave a sphere, within 6 km edges of more than two triangles."""
    points, triangles = kleopatra()
    assert round(np.linalg.det(points[triangles]).sum() / 6, -3) == 697000
    for tolerance, sphere in ((0, True), (5, True), (6, False)):
        name = NOTEBOOK["weld"](points, tolerance)
        for _ in range(20):
            name = name[name]
        t = name[triangles]
        t = t[(t != np.roll(t, 1, axis=1)).all(axis=1)]
        assert (NOTEBOOK["euler_characteristic"](t) == 2) == sphere
        assert (NOTEBOOK["triangles_at_sides"](t) == 2).all() == sphere
