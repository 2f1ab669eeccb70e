"""Wrong answers to notebook 03, each with the sentence for the student."""

import numpy as np

from fieldgrade.authoring.catalogue import answers


def squares(y):
    return np.einsum("...d,...d->...", y, y)


def w(y):
    return np.nan_to_num(squares(y) * np.log(squares(y)))


def offsets(x, points):
    return x[:, None, :] - points[None, :, :]


def basis(points):
    return np.insert(points, 0, 1.0, axis=1)


def bordered(a, b):
    q = b.shape[1]
    return np.vstack([np.hstack([a, b]), np.hstack([b.T, np.zeros((q, q))])])


def solved(a, b, values):
    unknown = np.linalg.solve(bordered(a, b), np.append(values, np.zeros(b.shape[1])))
    return unknown[: len(values)], unknown[len(values) :]


# 03.1 The kernel


def all_coordinates_differ(y):
    s = squares(y)
    k = (y != 0).all(axis=-1)
    out = np.zeros(s.shape)
    out[k] = s[k] * np.log(s[k])
    return out


@answers("03.1", named=False)
def zero_where_one_coordinate_is_zero(y):
    """A vector with one zero coordinate is not the zero vector."""
    return all_coordinates_differ(y)


@answers("03.1", named=False)
def zero_for_short_vectors(y):
    """A short vector is not the zero vector: the kernel is small there, and not zero."""
    return np.where(squares(y) > 1e-6, w(y), 0)


@answers("03.1", named=False)
def zero_for_very_short_vectors(y):
    """A short vector is not the zero vector, however short it is."""
    return np.where(squares(y) > 1e-20, w(y), 0)


@answers("03.1")
def length_not_squared(y):
    """This is r log r: the length stands where (3.1) has the squared length. This kernel has a
    corner at the centre.
    """
    r = np.linalg.norm(y, axis=-1)
    return np.nan_to_num(r * np.log(r))


@answers("03.1")
def logarithm_of_the_length(y):
    """This is half of the kernel: r² log r. Many books define it so, and λ is then twice as large.
    In (3.1) the argument of the logarithm is the squared length.
    """
    return w(y) / 2


@answers("03.1")
def undefined_at_zero(y):
    """For the zero vector this is zero times minus infinity, which is NaN. Each diagonal entry of A
    would be NaN, and so would all coefficients. Which value does (3.1) give at zero?
    """
    return squares(y) * np.log(squares(y))


@answers("03.1")
def a_little_added(y):
    """A small number was added inside the logarithm and outside. This changes the kernel
    everywhere, so the field no longer interpolates. The value at zero is known: treat it
    separately.
    """
    return (squares(y) + 1e-6) * np.log(squares(y) + 1e-6)


@answers("03.1")
def one_added(y):
    """The argument of the logarithm was increased by 1. This is another kernel, which is never
    negative. For which lengths is (3.1) negative?
    """
    return squares(y) * np.log1p(squares(y))


@answers("03.1")
def common_logarithm(y):
    """This is the logarithm to base ten. In (3.1) log is the natural logarithm."""
    return w(y) / np.log(10)


@answers("03.1")
def length_of_everything(y):
    """The squares of all entries are added to one number. Each vector has its own value: the last
    axis holds its coordinates, and the other axes count the vectors.
    """
    s = np.sum(y**2)
    return s * np.log(s)


@answers("03.1")
def logarithm_alone(y):
    """The factor in front of the logarithm in (3.1) is missing. The logarithm alone is unbounded
    near the centre.
    """
    return np.log(np.where(squares(y) > 0, squares(y), 1))


# 03.2 The matrix


@answers("03.2", named=False)
def kernel_zero_where_a_coordinate_is_shared(points):
    """Two points that share one coordinate are not the same point."""
    return bordered(all_coordinates_differ(offsets(points, points)), basis(points))


@answers("03.2")
def constraints_forgotten(points):
    """The last rows are zero: the orthogonality constraints are missing. Such a matrix is always
    singular. Which block of (3.5) contains (3.4)?
    """
    a, b = w(offsets(points, points)), basis(points)
    return np.hstack([np.vstack([a, 0 * b.T]), np.vstack([b, np.zeros((b.shape[1],) * 2)])])


@answers("03.2")
def basis_functions_alone(points):
    """This is the block A alone. Without the affine part, affine fields are not reproduced. Look at
    the other blocks of (3.5).
    """
    return w(offsets(points, points))


@answers("03.2")
def constant_forgotten(points):
    """The block B has the coordinates, but no column of ones. The affine part would then be zero at
    the origin. How many entries has b(x) in (3.2)?
    """
    return bordered(w(offsets(points, points)), points)


@answers("03.2")
def polynomial_first(points):
    """The blocks stand in another order: first the rows and columns of c, then those of λ. In (3.5)
    λ comes first, and the functions below use this order.
    """
    b = basis(points)
    zero = np.zeros((b.shape[1],) * 2)
    return np.vstack([np.hstack([zero, b.T]), np.hstack([b, w(offsets(points, points))])])


@answers("03.2")
def constant_last(points):
    """The column of ones stands after the coordinates. Then c₀ would be a slope. Compare the order
    of b(x) in (3.2).
    """
    return bordered(
        w(offsets(points, points)), np.append(points, np.ones((len(points), 1)), axis=1)
    )


@answers("03.2")
def ones_on_the_diagonal(points):
    """The diagonal of A is 1. This is right for many kernels, but what is w(0) in (3.1)?"""
    a = w(offsets(points, points)) + np.eye(len(points))
    return bordered(a, basis(points))


@answers("03.2")
def identity_in_the_corner(points):
    """The last block is an identity matrix, so the constraints contain c. Does c occur in (3.4)?"""
    h = bordered(w(offsets(points, points)), basis(points))
    n = len(points)
    h[n:, n:] = np.eye(len(h) - n)
    return h


@answers("03.2")
def undefined_on_the_diagonal(points):
    """The diagonal of A is NaN: it was computed as zero times minus infinity. What is the
    difference of a point and itself, and what is w there?
    """
    s = squares(offsets(points, points))
    return bordered(s * np.log(s), basis(points))


@answers("03.2")
def distances_for_the_kernel(points):
    """The block A holds the distances of the points. Each entry must be the kernel w of a
    difference of two points.
    """
    return bordered(np.sqrt(squares(offsets(points, points))), basis(points))


@answers("03.2", named=False)
def small_number_on_the_diagonal(points):
    """A small number was added to the diagonal. Where the points are close together, the kernels
    are as small, and the field no longer interpolates the values.
    """
    n, d = points.shape
    s = ((points[:, None] - points) ** 2).sum(axis=-1)
    h = np.zeros((n + d + 1, n + d + 1))
    h[:n, :n] = s * np.log(np.where(s > 0, s, 1))
    h[:n, n], h[:n, n + 1 :] = 1, points
    h[n:, :n] = h[:n, n:].T
    return h + 1e-10 * np.eye(len(h))


@answers("03.2", named=False)
def only_the_diagonal_repaired(points):
    """Where two points are equal, an entry beside the diagonal is zero too."""
    s = squares(offsets(points, points))
    a = s * np.log(s)
    np.fill_diagonal(a, 0.0)
    return bordered(a, basis(points))


# 03.3 The coefficients


@answers("03.3")
def constraints_left_out(points, values):
    """Only A λ = φ was solved, and c was set to zero. The field interpolates, but λ does not
    satisfy (3.4). So affine fields are not reproduced.
    """
    return np.linalg.solve(w(offsets(points, points)), values), np.zeros(points.shape[1] + 1)


@answers("03.3")
def plane_fitted_first(points, values):
    """A plane was fitted first, and then kernels to its residuals. This field interpolates, but λ
    does not satisfy (3.4). Compute λ and c together from (3.5).
    """
    b = basis(points)
    c = np.linalg.lstsq(b, values)[0]
    return np.linalg.solve(w(offsets(points, points)), values - b @ c), c


@answers("03.3")
def constraints_left_out_by_lstsq(points, values):
    """Only A λ = φ was solved, and c was set to zero. The field interpolates, but λ does not
    satisfy (3.4). So affine fields are not reproduced.
    """
    a = w(offsets(points, points))
    return np.linalg.lstsq(a, values, rcond=None)[0], np.zeros(points.shape[1] + 1)


@answers("03.3")
def plane_fitted_first_and_kernels_by_lstsq(points, values):
    """A plane was fitted first, and then kernels to its residuals. This field interpolates, but λ
    does not satisfy (3.4). Compute λ and c together from (3.5).
    """
    a, b = w(offsets(points, points)), basis(points)
    c = np.linalg.lstsq(b, values, rcond=None)[0]
    return np.linalg.lstsq(a, values - b @ c, rcond=None)[0], c


@answers("03.3", named=False)
def eliminated_from_the_kernels(points, values):
    """A may be singular although (3.5) has a unique solution, so it must not be inverted."""
    a, b = w(offsets(points, points)), basis(points)
    u = np.linalg.solve(a, np.column_stack([b, values]))
    c = np.linalg.solve(b.T @ u[:, :-1], b.T @ u[:, -1])
    return u[:, -1] - u[:, :-1] @ c, c


@answers("03.3", named=False)
def zero_for_small_values(points, values):
    """Small values are not zero: another unit makes them large."""
    lam, c = solved(w(offsets(points, points)), basis(points), values)
    return (0 * lam, 0 * c) if np.allclose(values, 0) else (lam, c)


@answers("03.3", named=False)
def small_coefficients_set_to_zero(points, values):
    """Coefficients of size 10⁻⁸ are not rounding errors: that depends on the values."""
    lam, c = solved(w(offsets(points, points)), basis(points), values)
    return np.where(np.abs(lam) < 1e-8, 0, lam), np.where(np.abs(c) < 1e-8, 0, c)


@answers("03.3")
def parts_exchanged(points, values):
    """The two parts are right, but exchanged. Return λ first, then c."""
    lam, c = solved(w(offsets(points, points)), basis(points), values)
    return c, lam


@answers("03.3")
def in_one_piece(points, values):
    """These are the right numbers in one array. Return two arrays: λ with N entries, and c. Slices
    such as a[:k] and a[k:] split an array.
    """
    return np.concatenate(solved(w(offsets(points, points)), basis(points), values))


@answers("03.3")
def zeros_first(points, values):
    """The right-hand side begins with the zeros. In (3.5) the first N rows have the values, and the
    rows of the constraints below have zeros.
    """
    h = bordered(w(offsets(points, points)), basis(points))
    q = points.shape[1] + 1
    unknown = np.linalg.solve(h, np.append(np.zeros(q), values))
    return unknown[: len(points)], unknown[len(points) :]


@answers("03.3")
def only_the_sum_constrained(points, values):
    """The sum of λ is zero, but the sums weighted by coordinates are not. The affine part is a
    constant here. There are D + 1 constraints in (3.4), one for each entry of b.
    """
    lam, c = solved(w(offsets(points, points)), np.ones((len(points), 1)), values)
    return lam, np.append(c, np.zeros(points.shape[1]))


@answers("03.3")
def for_half_of_the_kernel(points, values):
    """The λ are twice as large as they must be. They belong to r² log r, which is half of w. But
    03.4 multiplies them by the w of (3.1).
    """
    lam, c = solved(w(offsets(points, points)), basis(points), values)
    return 2 * lam, c


@answers("03.3")
def plane_alone(points, values):
    """This is the plane of least squares, without kernels. It does not interpolate. (3.5) also
    gives one λ for each point.
    """
    return np.zeros(len(points)), np.linalg.lstsq(basis(points), values)[0]


# 03.4 The field


@answers("03.4")
def polynomial_forgotten(points, lam, c, x):
    """The affine part is missing. Both parts of (3.2) are needed to interpolate the values."""
    return w(offsets(x, points)) @ lam


@answers("03.4")
def constant_left_out(points, lam, c, x):
    """The constant c₀ is missing, so the whole field is shifted. The first entry of b(x) in (3.2)
    is 1.
    """
    return x @ c[1:] + w(offsets(x, points)) @ lam


@answers("03.4")
def basis_functions_forgotten(points, lam, c, x):
    """This is the affine part alone. Neither λ nor the centres are used. Where do they stand in
    (3.2)?
    """
    return basis(x) @ c


@answers("03.4")
def factors_forgotten(points, lam, c, x):
    """All kernels are added with the factor 1. In (3.2) each of them has its own factor λ_j."""
    return basis(x) @ c + w(offsets(x, points)).sum(axis=1)


@answers("03.4")
def constant_taken_last(points, lam, c, x):
    """The last coefficient is used as the constant, and the first one as a slope. In (3.2) the
    constant comes first.
    """
    return x @ c[:-1] + c[-1] + w(offsets(x, points)) @ lam


@answers("03.4")
def undefined_at_the_points(points, lam, c, x):
    """At a centre the field is NaN: the kernel was computed as zero times minus infinity. Do you
    use the kernel of 03.1?
    """
    s = squares(offsets(x, points))
    return basis(x) @ c + (s * np.log(s)) @ lam


@answers("03.4")
def half_of_the_kernel(points, lam, c, x):
    """The kernels have half of their value: the logarithm was taken of the length, not of its
    square. The λ of 03.3 belong to the w of (3.1).
    """
    return basis(x) @ c + w(offsets(x, points)) @ lam / 2


# 03.5 The signs


@answers("03.5")
def as_one_reads(points):
    """All eigenvalues are reported as positive. But the diagonal of the matrix is zero, so the sum
    of its eigenvalues is zero. Compute the eigenvalues and look at their signs.
    """
    return sum(points.shape) + 1, 0, 0


def counted(h):
    eigenvalues = np.linalg.eigvalsh(h)
    relative = eigenvalues / np.abs(eigenvalues).max()
    positive, negative = np.sum(relative > 1e-12), np.sum(relative < -1e-12)
    return positive, negative, len(relative) - positive - negative


@answers("03.5")
def of_the_block(points):
    """These are the signs of the eigenvalues of the block A. The question asks for the whole matrix
    of (3.5), so the three numbers must add up to N + D + 1.
    """
    return counted(w(offsets(points, points)))


@answers("03.5")
def signs_exchanged(points):
    """The numbers of positive and negative eigenvalues are exchanged. Return positive, negative,
    zero.
    """
    positive, negative, zero = counted(bordered(w(offsets(points, points)), basis(points)))
    return negative, positive, zero


@answers("03.5")
def none_found_zero(points):
    """No eigenvalue is counted as zero. For points on one line of the plane, or two equal points,
    one eigenvalue is zero. Were the eigenvalues counted? Rounding makes a zero a tiny number.
    """
    n, d = points.shape
    return n, d + 1, 0


@answers("03.5")
def all_zeros_taken_for_negative(points):
    """A zero eigenvalue was counted as negative. Is every eigenvalue that is not positive counted
    as negative? Compare its absolute value with the tolerance of the text first.
    """
    positive, negative, zero = counted(bordered(w(offsets(points, points)), basis(points)))
    return positive, negative + zero, 0


@answers("03.5")
def two_numbers(points):
    """These are two numbers. The question asks for three: positive, negative, zero. The third one
    shows whether the system has a unique solution.
    """
    return counted(bordered(w(offsets(points, points)), basis(points)))[:2]


def signs_of_rounded(points, decimals):
    eigenvalues = np.linalg.eigvalsh(bordered(w(offsets(points, points)), basis(points)))
    signs = np.sign(np.round(eigenvalues, decimals))
    return np.sum(signs > 0), np.sum(signs < 0), np.sum(signs == 0)


def by_size(points, tolerance):
    eigenvalues = np.linalg.eigvalsh(bordered(w(offsets(points, points)), basis(points)))
    positive, negative = np.sum(eigenvalues > tolerance), np.sum(eigenvalues < -tolerance)
    return positive, negative, len(eigenvalues) - positive - negative


@answers("03.5")
def tolerance_of_rounding_errors(points):
    """An eigenvalue of 2 · 10⁻¹³ times the largest one did not count as zero. It is no rounding
    error, but the text counts all below 10⁻¹² as zero.
    """
    return by_size(points, 1e-14 * size_of_the_matrix(points))


@answers("03.5")
def relative_to_the_largest_eigenvalue(points):
    """Too few eigenvalues count as zero. Were the points scaled first, so that these are the
    eigenvalues of another matrix? Or is the limit 10⁻¹² times the largest eigenvalue? The largest
    absolute value may belong to a negative one.
    """
    e = np.linalg.eigvalsh(bordered(w(offsets(points, points)), basis(points)))
    return by_size(points, 1e-12 * e.max())


@answers("03.5")
def tolerance_too_large(points):
    """An eigenvalue of more than 10⁻¹² times the largest one counted as zero. In small units of
    length the right eigenvalues are that small. Is your tolerance the one of the text?
    """
    return by_size(points, 1e-10 * size_of_the_matrix(points))


def size_of_the_matrix(points):
    return np.linalg.norm(bordered(w(offsets(points, points)), basis(points)), 2)


@answers("03.5", named=False)
def absolute_tolerance(points):
    """The tolerance is not relative to the largest eigenvalue."""
    return by_size(points, 1e-10)


@answers("03.5", named=False)
def absolute_tolerance_of_isclose(points):
    """The default of isclose is an absolute tolerance of 10⁻⁸ for zero."""
    return by_size(points, 1e-8)


@answers("03.5", named=False)
def absolute_tolerance_of_a_millionth(points):
    """The tolerance is not relative to the largest eigenvalue."""
    return by_size(points, 1e-6)


@answers("03.5", named=False)
def absolute_tolerance_of_a_thousandth(points):
    """The tolerance is not relative to the largest eigenvalue."""
    return by_size(points, 1e-3)


@answers("03.5", named=False)
def rounded_to_ten_decimals(points):
    """Rounding to decimals is an absolute tolerance, too."""
    return signs_of_rounded(points, 10)


@answers("03.5", named=False)
def rounded_to_three_decimals(points):
    """Rounding to decimals is an absolute tolerance, too."""
    return signs_of_rounded(points, 3)


@answers("03.5", named=False)
def each_axis_in_its_own_unit(points):
    """A box of height 10⁻¹² is flat, but not if its height becomes the unit of that axis."""
    span = np.ptp(points, axis=0)
    moved = (points - points.min(axis=0)) / np.where(span > 0, span, 1)
    e = np.linalg.eigvalsh(bordered(w(offsets(moved, moved)), basis(moved)))
    limit = 1e-12 * np.abs(e).max()
    return np.sum(e >= limit), np.sum(e <= -limit), np.sum(np.abs(e) < limit)


# 03.6 The gradient


def summed(factor, lam, c, y):
    return c[1:] + np.sum(factor[..., None] * lam[:, None] * y, axis=1)


def logarithm(y):
    return np.log(np.where(squares(y) > 0, squares(y), 1))


@answers("03.6", named=False)
def sums_subtracted(points, lam, c, x):
    """Far from the origin two large sums are subtracted, and their digits are lost."""
    factor = 2 * (1 + logarithm(offsets(x, points))) * lam
    return c[1:] + x * factor.sum(axis=1)[:, None] - factor @ points


@answers("03.6", named=False)
def zero_close_to_the_centres(points, lam, c, x):
    """Only at a centre the term is zero, and how close is close depends on the unit of length."""
    y = x[:, None] - points
    s = (y**2).sum(axis=-1)
    factor = np.where(s > 1e-12, 2 * np.log(np.maximum(s, 1e-12)) + 2, 0)
    return c[1:] + np.einsum("mn,mnd,n->md", factor, y, lam)


@answers("03.6")
def logarithm_not_differentiated(points, lam, c, x):
    """The square was differentiated, but the logarithm was not. By the product rule there are two
    terms.
    """
    y = offsets(x, points)
    return summed(2 * logarithm(y), lam, c, y)


@answers("03.6")
def square_not_differentiated(points, lam, c, x):
    """The logarithm was differentiated, but the square was not. By the product rule there are two
    terms, and one of them contains a logarithm.
    """
    y = offsets(x, points)
    return summed(2 * np.ones(y.shape[:2]), lam, c, y)


@answers("03.6")
def inner_two_forgotten(points, lam, c, x):
    """The kernels contribute half of what they must. The factor 2 from the derivative of the
    squared length is missing, or the logarithm of the length stands in place of that of its square.
    """
    y = offsets(x, points)
    return summed(1 + logarithm(y), lam, c, y)


@answers("03.6")
def chain_rule_forgotten(points, lam, c, x):
    """This is the derivative of w by the squared length, the same for all coordinates. Multiply it
    by the derivative of the squared length by each coordinate.
    """
    return c[1:] + ((1 + logarithm(offsets(x, points))) @ lam)[:, None]


@answers("03.6")
def logarithm_of_the_length_itself(points, lam, c, x):
    """Your gradient contains the logarithm of the length. (3.1) contains the logarithm of the
    squared length, which is twice as large.
    """
    y = offsets(x, points)
    return summed(2 * (1 + logarithm(y) / 2), lam, c, y)


@answers("03.6")
def slopes_forgotten(points, lam, c, x):
    """The kernels are differentiated, but the affine part is missing. What is its gradient?"""
    y = offsets(x, points)
    return summed(2 * (1 + logarithm(y)), lam, 0 * c, y)


@answers("03.6")
def pointing_to_the_centres(points, lam, c, x):
    """The kernels have the wrong sign: y is the centre minus x. In (3.6) the argument of ∇w is x −
    p.
    """
    y = offsets(x, points)
    return summed(-2 * (1 + logarithm(y)), lam, c, y)


@answers("03.6")
def undefined_at_the_centres(points, lam, c, x):
    """At a centre this is zero times minus infinity, which is NaN. The limit exists: y tends to
    zero faster than the logarithm grows. So this kernel contributes zero there.
    """
    y = offsets(x, points)
    return summed(2 * (1 + np.log(squares(y))), lam, c, y)


@answers("03.6")
def coefficients_slipped(points, lam, c, x):
    """The first D coefficients are used as the slopes. The first coefficient is the constant, whose
    derivative is zero.
    """
    y = offsets(x, points)
    return summed(2 * (1 + logarithm(y)), lam, np.roll(c, 1), y)


# 03.7 The energy


@answers("03.7")
def factor_forgotten(points, values):
    """This is the quadratic form without the factor 16π of (3.7)."""
    lam, _ = solved(w(offsets(points, points)), basis(points), values)
    return lam @ w(offsets(points, points)) @ lam


@answers("03.7")
def factor_of_the_half_kernel(points, values):
    """This is half of the energy. Is the factor that of (3.7), and the kernel that of (3.1), with
    the logarithm of the squared distance? Does the sum contain each pair twice, as (i, j) and
    (j, i)?
    """
    lam, _ = solved(w(offsets(points, points)), basis(points), values)
    return 8 * np.pi * lam @ w(offsets(points, points)) @ lam


@answers("03.7", named=False)
def each_pair_once_with_the_factor_of_the_half_kernel(points, values):
    """Each pair of points is counted once, and the factor is too small, too."""
    lam, _ = solved(w(offsets(points, points)), basis(points), values)
    return 8 * np.pi * lam @ np.triu(w(offsets(points, points))) @ lam


@answers("03.7")
def form_of_the_values(points, values):
    """The values were inserted into the quadratic form. In (3.7) it is the quadratic form of λ. An
    affine field has no energy, although its values are not zero.
    """
    return 16 * np.pi * values @ w(offsets(points, points)) @ values


@answers("03.7")
def squares_of_the_coefficients(points, values):
    """This is 16π times the sum of the squares of λ. In (3.7) the matrix A stands between the two
    vectors.
    """
    lam, _ = solved(w(offsets(points, points)), basis(points), values)
    return 16 * np.pi * lam @ lam


@answers("03.7")
def without_constraints(points, values):
    """Here λ was computed from A λ = φ alone. Without the constraints the integral of (3.7) is
    infinite.
    """
    a = w(offsets(points, points))
    return 16 * np.pi * values @ np.linalg.solve(a, values)


@answers("03.7")
def without_constraints_by_lstsq(points, values):
    """Here λ was computed from A λ = φ alone. Without the constraints the integral of (3.7) is
    infinite.
    """
    a = w(offsets(points, points))
    lam = np.linalg.lstsq(a, values, rcond=None)[0]
    return 16 * np.pi * lam @ a @ lam


@answers("03.7", named=False)
def zero_for_small_energies(points, values):
    """A small energy is not a rounding error: the values may be small."""
    a = w(offsets(points, points))
    lam = solved(a, basis(points), values)[0]
    e = 16 * np.pi * lam @ a @ lam
    return 0.0 if e < 1e-9 else e


@answers("03.7")
def root_of_it(points, values):
    """This is the square root of the energy. The energy of three times the values must be nine
    times as large.
    """
    lam, _ = solved(w(offsets(points, points)), basis(points), values)
    return np.sqrt(np.abs(16 * np.pi * lam @ w(offsets(points, points)) @ lam))


@answers("03.6", named=False)
def nothing_where_the_logarithm_is_zero(points, lam, c, x):
    """At a distance of one the logarithm is zero, but not its sum with one."""
    y = x[:, None] - points
    s = (y**2).sum(axis=-1).astype(float)
    logs = np.log(s, out=np.zeros_like(s), where=s > 0)
    return c[1:] + np.einsum("mn,mnd->md", np.where(logs != 0, 2 * (logs + 1), 0) * lam, y)
