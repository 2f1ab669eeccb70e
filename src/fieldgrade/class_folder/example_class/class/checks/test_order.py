"""A check of the instructor's own, for question 01.2."""

import numpy as np
import pytest


@pytest.mark.question("01.2", "The order of the points must not matter.", costs=1)
def test_order(answer):
    """Reordered data must give the same coefficients."""
    points, values = np.random.default_rng(0).random((20, 2)), np.arange(20.0)
    reordered = answer("01.2", points[::-1], values[::-1])
    np.testing.assert_allclose(reordered, answer("01.2", points, values), rtol=1e-6)
