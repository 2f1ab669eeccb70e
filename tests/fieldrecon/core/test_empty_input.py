"""Empty input: no queries, no rays, no nodes of a surface and no components are no error."""

import numpy as np

import fieldrecon as fr
from laws import assert_close

PLANE = fr.datasets.halton(30, 2)
SPACE = fr.datasets.halton(30, 3)


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
    none = fr.surfaces.classified_points(SPACE, SPACE + 1, np.zeros((0, 3)))
    assert none.points.shape == (0, 3)
