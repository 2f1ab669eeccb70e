"""Error messages: the point at fault."""

import numpy as np
import pytest
from scipy import sparse

from fieldrecon._core.validation import (
    MAX_SHOWN,
    as_count,
    as_degree,
    as_length,
    as_line,
    as_numbers,
    as_points,
    as_queries,
    as_values,
    check_finite,
    format_point,
    quiet_evaluate,
)


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


def test_coordinates_are_real_numbers_and_values_may_be_complex():
    """Also where no imaginary part differs from zero."""
    for check in (lambda a: as_points(a[:, None], "p"), lambda a: as_line(a, "p")):
        with pytest.raises(ValueError, match="p must be an array of real numbers; got the type co"):
            check(np.ones(3, dtype=complex))
        assert check(np.ones(3)).tolist() == [[1.0]] * 3
    with pytest.raises(ValueError, match="x must be an array of real numbers; got the type comp"):
        as_queries(np.ones((3, 1), dtype=complex), 1)
    assert as_values([1j, 2], 2).tolist() == as_numbers([1j, 2], "v").tolist() == [1j, 2]


def test_points_are_copied_and_cannot_be_changed():
    given = np.zeros((3, 2))
    points = as_points(given)
    given += 1
    assert not points.any()
    with pytest.raises(ValueError, match="read-only"):
        points[0, 0] = 1.0
    with pytest.raises(ValueError, match=r"at least one point; got the shape \(0, 2\)"):
        as_points(given[:0])
    assert as_points(given[:0], none_allowed=True).shape == (0, 2)


def test_degrees_are_from_zero_counts_from_one_and_lengths_above_zero():
    """Unless another bound is given; the number that is returned is one of Python."""
    for check, lowest, name in ((as_degree, 0, "degree"), (as_count, 1, "n")):
        given = () if check is as_degree else (name,)
        assert type(check(np.int8(lowest), *given)) is int
        for wrong in (lowest - 1, float(lowest), True, "1"):
            with pytest.raises(ValueError, match=f"^{name} must be an integer, {lowest} or more; "):
                check(wrong, *given)
    assert as_degree(-1, -1) == -1
    assert as_count(7, "n", 3, 7) == 7
    with pytest.raises(ValueError, match="n must be from 3 to 7; got 8"):
        as_count(8, "n", 3, 7, "from 3 to 7")
    assert as_length(1, "h") == 1.0
    assert as_length(0, "h", zero_allowed=True) == 0.0
    for wrong in (0, -1.0, np.inf, np.nan, True, "1", 1j, 10**400):
        with pytest.raises(ValueError, match=r"^h must be a positive number; got "):
            as_length(wrong, "h")
    with pytest.raises(ValueError, match=r"^h must be zero or a positive number; got -1"):
        as_length(-1, "h", zero_allowed=True)
