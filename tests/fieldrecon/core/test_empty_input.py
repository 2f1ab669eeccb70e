"""Empty input: no queries, no rays, no nodes of a surface and no components are no error."""

import numpy as np

import fieldrecon as fr
from fieldrecon.solids.shapes import Ball, sample_surface
from fieldrecon.triangles import distances_to_triangles
from laws import assert_close

PLANE = fr.datasets.halton(30, 2)
SPACE = fr.datasets.halton(30, 3)
NONE, NO_TRIANGLES = np.zeros((0, 3)), np.zeros((0, 3), dtype=int)
OF_NOTHING = {
    "halton": lambda: fr.datasets.halton(0, 3),
    "scrambled halton": lambda: fr.datasets.halton(0, 3, seed=1),
    "uniform": lambda: fr.datasets.uniform(0, 3, seed=1),
    "clustered": lambda: fr.datasets.clustered(0, 3, 2, 0.1, seed=1),
    "sample_surface": lambda: sample_surface(Ball(1.0), 0, seed=1)[0],
    "off_surface_points": lambda: fr.off_surface_points(NONE, NONE).points,
    "off_surface_points at a distance": lambda: fr.off_surface_points(NONE, NONE, 0.5).points,
    "classified_points": lambda: fr.surfaces.classified_points(SPACE, SPACE + 1, NONE).points,
    "departure_points": lambda: fr.departure_points(NONE, lambda x, _: x, 0.0, 0.1),
    "audit_mesh": lambda: fr.audit_mesh(NONE, NO_TRIANGLES).crossings,
    "repair_mesh": lambda: fr.repair_mesh(NONE, NO_TRIANGLES).points,
    "repair_mesh of points": lambda: fr.repair_mesh(SPACE, NO_TRIANGLES).triangles,
    "distances_to_triangles": lambda: distances_to_triangles(NONE, np.eye(3), [[0, 1, 2]]),
    "distances to none": lambda: distances_to_triangles(NONE, NONE, NO_TRIANGLES),
}


def test_no_points_give_empty_results():
    """Functions of points take none of them."""
    for name, of_nothing in OF_NOTHING.items():
        assert len(of_nothing()) == 0, name


def test_a_mesh_without_triangles_has_loose_vertices_only():
    """They are removed by its repair, and no triangle is nearer than infinity."""
    audit = fr.audit_mesh(SPACE, NO_TRIANGLES)
    assert audit.found == {"unreferenced_vertices": 30}
    repaired = fr.repair_mesh(SPACE, NO_TRIANGLES)
    assert repaired.points.shape == repaired.triangles.shape == (0, 3)
    assert repaired.done == {"removed_vertices": 30}
    assert repaired.after.clean
    assert fr.audit_mesh(NONE, NO_TRIANGLES).clean
    far = distances_to_triangles(SPACE, SPACE, NO_TRIANGLES)
    assert_close(1 / far, np.zeros(30), 0.0)


def test_no_points_have_no_departure_points():
    """By a function and by a field."""
    none = np.zeros((0, 2))
    steady = fr.LeastSquares(PLANE).field(PLANE)
    for velocity in (lambda x, _: x, steady):
        assert fr.departure_points(none, velocity, 0.0, 0.1).shape == (0, 2)


def test_no_components_are_advected():
    """With and without bounds, masses and stored weights; scalars and vectors."""
    method = fr.LeastSquares(PLANE)
    for options in ({}, {"steady": True}, {"bounded": True}, {"masses": np.ones(30)}):
        for tail in ((0,), (2, 0)):
            values = np.zeros((30, *tail))
            *_, last = fr.semi_lagrangian(
                method, values, lambda x, _: x, [0.0, 0.1, 0.2], **options
            )
            assert last.values.shape == values.shape


def test_no_components_are_reconstructed():
    """Near the sites, and far from them, where the error of constants is estimated."""
    for tail in ((0,), (2, 0)):
        s = fr.LeastSquares(PLANE).field(np.zeros((30, *tail)))
        for x in ([0.5, 0.5], [1e3, 1e3]):
            assert s(x).shape == tail
            assert s.gradient(x).shape == (*tail, 2)


def test_no_surface_is_coupled():
    """A flat structure and one in space: no displacements, and loads of zero."""
    none = np.zeros((0, 3))
    for structure in (SPACE, np.pad(PLANE, ((0, 0), (0, 1)))):
        coupling = fr.coupling.couple(structure, none)
        assert coupling.displacements(structure).shape == (0, 3)
        for tail in ((), (2,)):
            loads = coupling.loads(np.zeros((0, 3, *tail)))
            assert_close(loads, np.zeros((30, 3, *tail)), 0.0)
        assert_close(coupling.defects(none), np.zeros(6), 0.0)
        assert coupling.shares(none, [], np.zeros(30, int)).shape == (0, 1, 6)
    assert_close(fr.coupling.net_force_and_moment(none, none), np.zeros(6), 0.0)


def test_few_points_have_points_off_the_surface():
    """One is enough if the distance is given."""
    off = fr.off_surface_points([[0.0, 0, 1]], [[0.0, 0, 2]], 0.5)
    assert_close(off.points, [[0, 0, 1.5], [0, 0, 0.5]], 1e-15)
    assert_close(off.values, [-0.5, 0.5], 0.0)
    off = fr.off_surface_points(NONE, NONE)
    assert off.points.shape == (0, 3)
    assert off.values.shape == off.sites.shape == (0,)
    none = fr.surfaces.classified_points(SPACE, SPACE + 1, np.zeros((0, 3)))
    assert none.points.shape == (0, 3)
