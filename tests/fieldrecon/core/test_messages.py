"""Error messages: the point at fault."""

import numpy as np
import pytest
from scipy import sparse

from fieldrecon._core.validation import MAX_SHOWN, check_finite, format_point, quiet_evaluate


def test_a_point_of_few_variables_is_shown_whole():
    """Of a longer one the number of coordinates is given."""
    point = [0.25 * k for k in range(MAX_SHOWN + 1)]
    assert [float(c) for c in format_point(point[:-1]).split(", ")] == point[:-1]
    shown, _, rest = format_point(point).partition(", … ")
    assert [float(c) for c in shown.split(", ")] == point[: MAX_SHOWN // 2]
    assert rest == f"of {MAX_SHOWN + 1} coordinates"


@pytest.mark.parametrize("form", [np.asarray, sparse.csr_array])
@pytest.mark.parametrize("wrong", [np.inf, np.nan])
def test_a_result_out_of_range_is_reported_at_the_first_point_that_has_one(form, wrong):
    """In dense and in sparse results; finite ones are returned as they are."""
    x = np.array([[0.5, 1.0], [0.25, 2.0], [0.125, 3.0]])
    result = np.array([[0.0, 1.0], [wrong, 2.0], [0.0, wrong]])
    with pytest.raises(OverflowError, match=r"the result at \(0\.25, 2\) exceeds the range"):
        check_finite(form(result), x)
    finite = form(np.eye(3))
    assert check_finite(finite, x) is finite


@pytest.mark.filterwarnings("error")
def test_overflow_is_found_in_the_result_and_causes_no_warning():
    assert quiet_evaluate(np.exp, np.array([1e4])) == np.inf
