"""Points that coincide, and points in order, against their literal definitions."""

import numpy as np
import pytest

from fieldrecon._core.duplicates import (
    by_position,
    coincidence_labels,
    first_of_equal,
    refuse_coincident,
)


@pytest.mark.parametrize("unit", [1.0, 1.7e308])
@pytest.mark.parametrize(("n", "d", "side"), [(1, 2, 3), (60, 1, 9), (200, 2, 3), (200, 3, 2)])
def test_equal_points_are_found_wherever_they_stand(n, d, side, unit):
    """Of a lattice with many ties in each coordinate, also where sums of them overflow."""
    points = unit * (np.random.default_rng(0).integers(-side, side + 1, (n, d)) / side)
    rows = [tuple(point) for point in points.tolist()]
    first = [rows.index(row) for row in rows]
    assert first_of_equal(points).tolist() == first
    distinct = list(dict.fromkeys(rows))
    assert coincidence_labels(points).tolist() == [distinct.index(row) for row in rows]
    assert by_position(points).tolist() == sorted(range(n), key=lambda k: (rows[k], k))


def test_coincident_points_are_named_by_their_indices():
    """Five pairs are named, each with the first point that is equal; more are counted."""
    points = np.array([[0.0, 1.0]] * 6 + [[2.0, 3.0]])
    five = "0 and 1, 0 and 2, 0 and 3, 0 and 4, 0 and 5"
    with pytest.raises(ValueError, match=f"^at {five}!$"):
        refuse_coincident(points, "at {pairs}!")
    for more in (1, 2):
        with pytest.raises(ValueError, match=f"^at {five} and {more} more!$"):
            refuse_coincident(np.vstack([points, points[:more]]), "at {pairs}!")
    with pytest.raises(ValueError, match=r"^at 3 and 5!$"):
        refuse_coincident(points, "at {pairs}!", np.array([3, 5, 6]))
    refuse_coincident(points, "at {pairs}!", np.array([3, 6]))
