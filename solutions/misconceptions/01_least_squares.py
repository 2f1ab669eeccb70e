"""Wrong answers to notebook 01, each with the sentence for the student."""

import numpy as np

from fieldgrade.authoring.catalogue import answers


def basis(points):
    return np.insert(points, 0, 1.0, axis=1)


@answers("01.1")
def no_constant(points):
    """The column of ones is missing. Without it every field would be zero at the origin. How many
    entries has b(x) in (1.1)?
    """
    return points.copy()


@answers("01.1")
def constant_last(points):
    """The columns are right, but the column of ones stands last. Then the first coefficient is a
    slope, and functions that use c₀ as the constant are wrong. Compare the order of b(x) in (1.1).
    """
    return np.append(points, np.ones((len(points), 1)), axis=1)


@answers("01.1")
def points_in_columns(points):
    """Rows and columns are exchanged: this is the transpose of B. In (1.2) each point has a row."""
    return np.insert(points, 0, 1.0, axis=1).T


@answers("01.1")
def zeros_for_ones(points):
    """The first column is zero, so c₀ has no effect on the field. By which function is c₀
    multiplied in (1.1)?
    """
    return np.insert(points, 0, 0.0, axis=1)


@answers("01.2")
def right_side_not_projected(points, values):
    """The left-hand side belongs to the normal equations, but the right-hand side contains only the
    first D + 1 values. In (1.4) both sides are multiplied by the same matrix.
    """
    b = basis(points)
    return np.linalg.solve(b.T @ b, values[: b.shape[1]])


@answers("01.2")
def through_the_first_points(points, values):
    """This plane passes through the first D + 1 points and ignores all other values. Least squares
    uses every value. Which system has as many equations as unknowns for any number of points?
    """
    b = basis(points)[: points.shape[1] + 1]
    return np.linalg.solve(b, values[: len(b)])


@answers("01.2", named=False)
def one_measurement_for_each_point(points, values):
    """Where a point was measured twice, both values count."""
    alone, first = np.unique(points, axis=0, return_index=True)
    return np.linalg.lstsq(basis(alone), values[first], rcond=None)[0]


@answers("01.2", named=False)
def small_singular_values_dropped(points, values):
    """A strip determines the slope across it, unless its small singular value is dropped."""
    return np.linalg.lstsq(basis(points), values, rcond=1e-2)[0]


@answers("01.2", named=False)
def slopes_dropped_in_a_small_unit(points, values):
    """In another unit of length the slopes belong to small singular values."""
    return np.linalg.lstsq(basis(points), values, rcond=1e-4)[0]


@answers("01.2", named=False)
def outliers_left_out(points, values):
    """Least squares uses every value, also one that is far from the others."""
    b = basis(points)
    e = np.abs(b @ np.linalg.lstsq(b, values)[0] - values)
    kept = e <= 2.5 * np.sqrt(np.mean(e**2))
    return np.linalg.lstsq(b[kept], values[kept])[0]


@answers("01.2")
def values_stored_like_the_points(points, values):
    """The values were copied into an array of the type of the points. For points with integer
    coordinates this array holds integers only, and the decimals of the values are lost.
    """
    stored = np.empty(len(points), dtype=points.dtype)
    stored[:] = values
    return np.linalg.lstsq(basis(points), stored)[0]


@answers("01.2")
def slopes_first(points, values):
    """The numbers are right, but the constant stands last. In (1.1) the first coefficient is the
    constant c₀, and one slope for each coordinate follows.
    """
    return np.roll(np.linalg.lstsq(basis(points), values)[0], -1)


@answers("01.2")
def no_constant_fitted(points, values):
    """The plane was fitted without a constant, so it passes through zero at the origin. Does your
    matrix have the column of ones?
    """
    return np.insert(np.linalg.lstsq(points, values)[0], 0, 0.0)


@answers("01.2")
def mean_and_slopes(points, values):
    """The slopes are right. The constant is the mean of the values, which the plane has at the mean
    of the points. But c₀ is the value at the origin.
    """
    c = np.linalg.lstsq(basis(points), values)[0]
    return np.insert(c[1:], 0, values.mean())


@answers("01.3")
def slopes_only(coefficients, x):
    """The constant c₀ is missing, so the whole field is shifted. By (1.1) the first entry of b(x)
    is 1.
    """
    return x @ coefficients[1:]


@answers("01.3")
def constant_subtracted(coefficients, x):
    """The constant c₀ has the wrong sign, so the field is shifted by twice its value. Which value
    does (1.1) give at the origin?
    """
    return x @ coefficients[1:] - coefficients[0]


@answers("01.3")
def constant_taken_last(coefficients, x):
    """The last coefficient is used as the constant, and the first one as a slope. By (1.1) the
    constant comes first.
    """
    return x @ coefficients[:-1] + coefficients[-1]


@answers("01.3")
def stored_like_x(coefficients, x):
    """The values were stored in an array of the type of x, as `np.zeros_like` makes it. For
    evaluation points with integer coordinates it holds integers only, and the decimals are lost.
    Which type has `np.zeros(len(x))`?
    """
    return (basis(x) @ coefficients).astype(x.dtype)


@answers("01.3", named=False)
def coefficients_like_x(coefficients, x):
    """For integer coordinates the coefficients lose their decimals."""
    return basis(x) @ coefficients.astype(x.dtype)


@answers("01.4", named=False)
def of_the_first_points(points):
    """The first D + 1 points may be on one line although the others are not."""
    first = points[1 : points.shape[1] + 1] - points[0]
    return 1 + np.linalg.matrix_rank(first, tol=1e-9 * np.ptp(points, axis=0).max())


@answers("01.4", named=False)
def extent_of_the_first_step(points):
    """The first two points may be equal, and are not the extent of all points."""
    moved = points - points[0]
    return 1 + np.linalg.matrix_rank(moved, tol=1e-9 * np.abs(moved[:2]).max())


@answers("01.4", named=False)
def largest_singular_value_as_unit(points):
    """It grows with the number of points; the extent does not."""
    s = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    return 1 + int((s > 1e-9 * s[0]).sum())


@answers("01.4")
def counted(points):
    """This is the smaller of the numbers of points and coefficients. It is the rank only for points
    in general position. What is the rank for many points on one line?
    """
    return min(len(points), points.shape[1] + 1)


@answers("01.4")
def rank_of_the_points(points):
    """This is the rank of the array of points. It ignores the column of ones, and it changes when
    all points are translated. The question asks for the rank of B.
    """
    return np.linalg.matrix_rank(points)


@answers("01.4")
def dimension(points):
    """This is the dimension of the affine hull of the points, which is the rank of B minus one. A
    single point has dimension 0 and still determines one coefficient.
    """
    return np.linalg.matrix_rank(points - points[0], tol=1e-9 * np.ptp(points, axis=0).max())


@answers("01.4")
def full_or_nothing(points):
    """The function returns 1 if the rank is full, else 0. The question asks for the rank itself.
    How many coefficients do points on one line determine?
    """
    extent = np.ptp(points, axis=0).max()
    centered = points - points.mean(axis=0)
    return int(np.linalg.matrix_rank(centered, tol=1e-9 * extent) == points.shape[1])


@answers("01.4")
def not_centred(points):
    """The result depends on the distance of the points from the origin. At a distance of ten
    million, the columns of B are nearly multiples of the first one. Which translation of the points
    avoids this?
    """
    return np.linalg.matrix_rank(basis(points))


@answers("01.4")
def rounding_counted(points):
    """Deviations of 10⁻¹² of the extent, as rounding errors may be, are counted as a direction. Is
    one of the points, or their mean, subtracted, and is `tol` relative to the extent?
    """
    return np.linalg.matrix_rank(basis(points - points.mean(axis=0)))


@answers("01.4", named=False)
def not_centred_with_a_tolerance(points):
    """The points are not centred, and the tolerance hangs on the unit."""
    return np.linalg.matrix_rank(basis(points), tol=1e-6)


@answers("01.4", named=False)
def scaled_without_a_tolerance(points):
    """Deviations of 10⁻¹² from a line count as a direction."""
    return np.linalg.matrix_rank(basis(points / np.abs(points).max()))


@answers("01.4", named=False)
def normal_equations(points):
    """The product squares the singular values."""
    return np.linalg.matrix_rank(basis(points).T @ basis(points))


@answers("01.4", named=False)
def rank_of_the_covariance(points):
    """The covariance squares the singular values, so widths below 10⁻⁸ count as zero."""
    return 1 + np.linalg.matrix_rank(np.cov(points.T))


@answers("01.4", named=False)
def relative_to_the_largest_singular_value(points):
    """A tolerance of a millionth is much coarser than the one of the text."""
    s = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    return 1 + np.sum(s > 1e-6 * s[0])


@answers("01.4", named=False)
def centred_by_one_mean(points):
    """One mean of all coordinates leaves the points far from the origin."""
    b = basis(points - points.mean())
    return np.linalg.matrix_rank(b, tol=1e-9 * np.ptp(points, axis=0).max())


@answers("01.4", named=False)
def gram_matrix_with_a_tolerance(points):
    """The product squares the singular values, but not the tolerance."""
    moved = points - points.mean(axis=0)
    return 1 + np.linalg.matrix_rank(moved.T @ moved, tol=1e-9 * np.ptp(points, axis=0).max())


@answers("01.4", named=False)
def coarse_tolerance(points):
    """With this tolerance thin clouds lose a direction."""
    return np.linalg.matrix_rank(basis(points - points.mean(axis=0)), tol=1e-3)


@answers("01.4", named=False)
def very_coarse_tolerance(points):
    """With this tolerance thin clouds lose a direction."""
    return np.linalg.matrix_rank(basis(points - points.mean(axis=0)), tol=0.1)


@answers("01.4", named=False)
def fixed_tolerance(points):
    """The tolerance is a length, and does not change with the unit."""
    return 1 + np.linalg.matrix_rank(points - points.mean(axis=0), tol=1e-9)


@answers("01.4", named=False)
def always_one_more(points):
    """The rank is too large by one, for all inputs."""
    return 2 + np.linalg.matrix_rank(
        points - points.mean(axis=0), tol=1e-9 * np.ptp(points, axis=0).max()
    )


@answers("01.4", named=False)
def of_the_first_ten_points(points):
    """The others may lie beside the line of the first ones."""
    first = points[:10] - points[:10].mean(axis=0)
    return 1 + np.linalg.matrix_rank(first, tol=1e-9 * np.ptp(points, axis=0).max())


@answers("01.4", named=False)
def by_a_determinant(points):
    """The determinant tells whether the rank is full, and not what it is otherwise."""
    b = basis(points)
    full = abs(np.linalg.det(b.T @ b)) > 1e-9
    return b.shape[1] if full else b.shape[1] - 1


@answers("01.4", named=False)
def ones_not_scaled(points):
    """In a small unit of length the column of ones counts as zero."""
    b = basis(points - points.mean(axis=0))
    return np.linalg.matrix_rank(b, tol=1e-9 * np.ptp(points, axis=0).max())


@answers("01.4", named=False)
def tolerance_of_1e_11(points):
    """The text asks for a limit that is larger by a factor of a hundred."""
    moved = points - points.mean(axis=0)
    return 1 + np.linalg.matrix_rank(moved, tol=1e-11 * np.ptp(points, axis=0).max())


@answers("01.4", named=False)
def centred_in_integers(points):
    """The rounded mean of points on a line is not on the line."""
    center = points.mean(axis=0).astype(points.dtype)
    return 1 + np.linalg.matrix_rank(points - center, tol=1e-9 * np.ptp(points, axis=0).max())


@answers("01.5")
def slopes_stored_like_x(coefficients, x):
    """The slopes were stored in an array of the type of x, as `np.zeros_like` or `np.full_like`
    makes it. For evaluation points with integer coordinates it holds integers only, and the
    decimals are lost.
    """
    return np.full_like(x, coefficients[1:])


@answers("01.5", named=False)
def zero_where_a_coordinate_is_zero(coefficients, x):
    """The gradient does not depend on the evaluation point."""
    return coefficients[1:] * (x != 0)


@answers("01.5", named=False)
def difference_quotient(coefficients, x):
    """Differences of values lose digits far from the origin."""
    h = 1e-6
    return np.transpose(
        [(basis(x + h * e) - basis(x - h * e)) @ coefficients / (2 * h) for e in np.eye(x.shape[1])]
    )


@answers("01.5")
def all_coefficients(coefficients, x):
    """The constant c₀ is among the derivatives. The gradient of (1.1) has one entry for each
    coordinate, and the derivative of a constant is zero.
    """
    return np.tile(coefficients, (len(x), 1))


@answers("01.5")
def times_the_place(coefficients, x):
    """These are the terms c_k x_k of the field, not their derivatives. How much does c_k x_k change
    when x_k grows by 1?
    """
    return coefficients[1:] * x


@answers("01.5")
def last_slopes_dropped(coefficients, x):
    """The coefficients are shifted by one position: the constant stands where the first slope
    belongs.
    """
    return np.tile(coefficients[:-1], (len(x), 1))


@answers("01.6")
def without_the_half(points, values, coefficients):
    """The factor ½ of (1.3) is missing. The minimum is at the same point without it, but the value
    is twice ψ.
    """
    return np.sum((basis(points) @ coefficients - values) ** 2)


@answers("01.6")
def mean_instead_of_sum(points, values, coefficients):
    """The sum was divided by the number of points: this is half of the mean of the squares. ψ of
    (1.3) is half of their sum.
    """
    return 0.5 * np.mean((basis(points) @ coefficients - values) ** 2)


@answers("01.6")
def not_squared(points, values, coefficients):
    """This is half of the norm of the residual. In (1.3) the norm is squared, so that the gradient
    is linear in c.
    """
    return 0.5 * np.linalg.norm(basis(points) @ coefficients - values)


@answers("01.6")
def summed_before_squaring(points, values, coefficients):
    """The residuals are added, and the sum is squared, so residuals of opposite signs cancel. In
    (1.3) each of them is squared first.
    """
    return 0.5 * np.sum(basis(points) @ coefficients - values) ** 2


@answers("01.6")
def of_the_values(points, values, coefficients):
    """This is half the sum of the squared fitted values. In (1.3) the values V are subtracted
    before the norm is taken.
    """
    return 0.5 * np.sum((basis(points) @ coefficients) ** 2)


@answers("01.6", named=False)
def multiplied_out(points, values, coefficients):
    """Almost equal products of large values are subtracted: rounding noise has no fingerprint."""
    r = np.append(coefficients, -1.0)
    m = np.column_stack([np.ones(len(points)), points, values])
    return r @ (m.T @ m) @ r / 2


@answers("01.6", named=False)
def outliers_count_less(points, values, coefficients):
    """Large residuals are not squared, as in robust statistics."""
    e = np.abs(basis(points) @ coefficients - values)
    return np.sum(np.where(e < 10, e**2 / 2, 10 * e - 50))


@answers("01.6", named=False)
def spread_of_the_residual(points, values, coefficients):
    """The residual of coefficients that are not optimal has a mean."""
    return 0.5 * len(points) * np.var(basis(points) @ coefficients - values)


@answers("01.6", named=False)
def one_measurement_for_each_point_counted(points, values, coefficients):
    """Where a point was measured twice, both values count."""
    alone, first = np.unique(points, axis=0, return_index=True)
    return 0.5 * np.sum((basis(alone) @ coefficients - values[first]) ** 2)


@answers("01.6", named=False)
def zero_for_few_points(points, values, coefficients):
    """A plane passes through few points, but the coefficients may be those of another plane."""
    e = basis(points) @ coefficients - values
    return 0.0 if len(points) <= points.shape[1] + 1 else e @ e / 2
