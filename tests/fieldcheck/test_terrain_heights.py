"""The heights for students are those of the real terrain."""

import numpy as np

from fieldcheck import datasets
from fieldrecon.datasets import terrain


def test_the_landscape_is_every_third_node_of_the_terrain():
    """Rows from south to north; distances in kilometres, relative to the first node."""
    points, heights = datasets.terrain()
    whole = terrain()
    rows, columns = slice(4, 154, 3), slice(160, 340, 3)
    x, y = whole.x[columns], whole.y[rows]
    np.testing.assert_array_equal(heights, whole.height[rows, columns].ravel())
    expected = np.stack(np.meshgrid(x - x[0], y - y[0]), axis=-1).reshape(-1, 2) / 1000
    np.testing.assert_allclose(points, expected, rtol=0, atol=1e-4)
