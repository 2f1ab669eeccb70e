"""What students write instead of notebook 03, and what each of them should hear."""

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


@answers("03.1")
def length_not_squared(y):
    """This is r log r, with the length r where its square belongs. The kernel is another one then,
    with a corner at the pin. Look at what stands twice in (3.1).
    """
    r = np.linalg.norm(y, axis=-1)
    return np.nan_to_num(r * np.log(r))


@answers("03.1")
def logarithm_of_the_length(y):
    """This is half of the kernel: r² log r. Books write it so, and the field would come out the
    same, with λ twice as large; but in (3.1) the logarithm is taken of something else than the
    length.
    """
    return w(y) / 2


@answers("03.1")
def undefined_at_zero(y):
    """For the vector zero this is zero times minus infinity, which is no number. One NaN in the
    matrix, and there is one for each point, makes all coefficients NaN. What does (3.1) say of
    zero?
    """
    return squares(y) * np.log(squares(y))


@answers("03.1")
def a_little_added(y):
    """A small number was added to keep the logarithm finite. It changes the kernel everywhere, and
    moves the field off the data. The value at zero is known: it needs a case of its own.
    """
    return (squares(y) + 1e-6) * np.log(squares(y) + 1e-6)


@answers("03.1")
def one_added(y):
    """One was added in the logarithm, which makes it vanish at zero, and makes another kernel: this
    one is never negative. Where does the thin-plate spline change its sign?
    """
    return squares(y) * np.log1p(squares(y))


@answers("03.1")
def common_logarithm(y):
    """The logarithm is to base ten. In mathematics, and in (3.1), log is the natural one; the
    derivative that you will need in 03.6 is simple for that one only.
    """
    return w(y) / np.log(10)


@answers("03.1")
def length_of_everything(y):
    """All entries of the array are summed to one single number. Each vector has a value of its own:
    the last axis holds its coordinates, the others count the vectors.
    """
    s = np.sum(y**2)
    return s * np.log(s)


@answers("03.1")
def logarithm_alone(y):
    """The factor in front of the logarithm is missing. What is left grows beyond bounds at the pin,
    where the sheet of metal has a finite height.
    """
    return np.log(np.where(squares(y) > 0, squares(y), 1))


# 03.2 The matrix


@answers("03.2")
def constraints_forgotten(points):
    """The last rows are zero: the orthogonality constraints are missing. Such a matrix can never be
    inverted. Which block of (3.5) holds (3.4)?
    """
    a, b = w(offsets(points, points)), basis(points)
    return np.hstack([np.vstack([a, 0 * b.T]), np.vstack([b, np.zeros((b.shape[1],) * 2)])])


@answers("03.2")
def bumps_alone(points):
    """This is the block A alone. Without the polynomial an affine field is not reproduced, and far
    away the field grows without end. Look at the other blocks of (3.5).
    """
    return w(offsets(points, points))


@answers("03.2")
def constant_forgotten(points):
    """The block B has the coordinates and no column of ones. Then the polynomial vanishes at the
    origin, and the field depends on where that is. How many entries has b(x) in (3.2)?
    """
    return bordered(w(offsets(points, points)), points)


@answers("03.2")
def polynomial_first(points):
    """The blocks stand in another order: here the first unknowns are c and the last λ. That is a
    system as good, but (3.5), and those who split its solution, have it the other way round.
    """
    b = basis(points)
    zero = np.zeros((b.shape[1],) * 2)
    return np.vstack([np.hstack([zero, b.T]), np.hstack([b, w(offsets(points, points))])])


@answers("03.2")
def constant_last(points):
    """The column of ones stands after the coordinates. Then c₀ would be a slope, and the last
    coefficient the constant. Compare the order in b(x) of (3.2).
    """
    return bordered(
        w(offsets(points, points)), np.append(points, np.ones((len(points), 1)), axis=1)
    )


@answers("03.2")
def ones_on_the_diagonal(points):
    """The diagonal of A is one. Many kernels have the value one at zero, which would make A
    positive definite; what is w(0) for this one?
    """
    a = w(offsets(points, points)) + np.eye(len(points))
    return bordered(a, basis(points))


@answers("03.2")
def identity_in_the_corner(points):
    """The last block is an identity. It mixes c into the constraints, which then do not make the
    sums of λ vanish. What multiplies c in (3.4)?
    """
    h = bordered(w(offsets(points, points)), basis(points))
    n = len(points)
    h[n:, n:] = np.eye(len(h) - n)
    return h


@answers("03.2")
def undefined_on_the_diagonal(points):
    """The diagonal of A is no number: it was computed as zero times minus infinity, and it makes
    all coefficients NaN. What is the difference of a point and itself, and what is w of it?
    """
    s = squares(offsets(points, points))
    return bordered(s * np.log(s), basis(points))


@answers("03.2")
def distances_for_the_kernel(points):
    """The block A holds the distances of the points and not the kernel of them. Each entry is w
    of a difference of two points.
    """
    return bordered(np.sqrt(squares(offsets(points, points))), basis(points))


# 03.3 The coefficients


@answers("03.3")
def constraints_left_out(points, values):
    """Only A λ = φ was solved, and c set to zero. The field goes through the values, but the λ do
    not satisfy (3.4), so an affine field is not reproduced and the field grows far away.
    """
    return np.linalg.solve(w(offsets(points, points)), values), np.zeros(points.shape[1] + 1)


@answers("03.3")
def plane_fitted_first(points, values):
    """First a plane by least squares, then bumps for what it misses: this goes through the values,
    but nothing makes the λ orthogonal to the polynomials, as (3.4) demands. λ and c are found
    together, from one system.
    """
    b = basis(points)
    c = np.linalg.lstsq(b, values)[0]
    return np.linalg.solve(w(offsets(points, points)), values - b @ c), c


@answers("03.3")
def parts_exchanged(points, values):
    """The two parts are right and in the wrong order: the first D + 1 numbers returned are c. Asked
    for is λ first, one for each point.
    """
    lam, c = solved(w(offsets(points, points)), basis(points), values)
    return c, lam


@answers("03.3")
def in_one_piece(points, values):
    """These are the right numbers in one array. Return two: the λ, one for each point, and c. An
    array is cut by slices such as a[:k] and a[k:].
    """
    return np.concatenate(solved(w(offsets(points, points)), basis(points), values))


@answers("03.3")
def zeros_first(points, values):
    """The right side begins with the zeros. In (3.5) the first N rows are the values, and the zeros
    belong to the constraints below them.
    """
    h = bordered(w(offsets(points, points)), basis(points))
    q = points.shape[1] + 1
    unknown = np.linalg.solve(h, np.append(np.zeros(q), values))
    return unknown[: len(points)], unknown[len(points) :]


@answers("03.3")
def only_the_sum_constrained(points, values):
    """The λ sum to zero, but weighted by coordinates they do not: the polynomial here is a constant
    only. (3.4) is D + 1 equations, one for each entry of b.
    """
    lam, c = solved(w(offsets(points, points)), np.ones((len(points), 1)), values)
    return lam, np.append(c, np.zeros(points.shape[1]))


@answers("03.3")
def for_half_of_the_kernel(points, values):
    """The λ are twice as large as they should be: these belong to r² log r, which is half of w.
    With that kernel they give the same field, but 03.4 multiplies them by the w of (3.1).
    """
    lam, c = solved(w(offsets(points, points)), basis(points), values)
    return 2 * lam, c


@answers("03.3")
def plane_alone(points, values):
    """This is the plane of least squares, and no bumps at all. It misses the values; what has to be
    found from (3.5) is a λ for each point as well.
    """
    return np.zeros(len(points)), np.linalg.lstsq(basis(points), values)[0]


# 03.4 The field


@answers("03.4")
def polynomial_forgotten(points, lam, c, x):
    """The bumps are there and the affine part is not. Both belong to (3.2): without the plane the
    field misses the values by what the plane contributes.
    """
    return w(offsets(x, points)) @ lam


@answers("03.4")
def constant_left_out(points, lam, c, x):
    """The constant c₀ is missing: the whole field is shifted. b(x) in (3.2) has a one as its first
    entry.
    """
    return x @ c[1:] + w(offsets(x, points)) @ lam


@answers("03.4")
def bumps_forgotten(points, lam, c, x):
    """This is the affine part alone. Of the λ and the points nothing is used; where in (3.2) do
    they stand?
    """
    return basis(x) @ c


@answers("03.4")
def factors_forgotten(points, lam, c, x):
    """All bumps are added with the factor one. Each has a λ of its own, which is what makes the
    field go through the values.
    """
    return basis(x) @ c + w(offsets(x, points)).sum(axis=1)


@answers("03.4")
def constant_taken_last(points, lam, c, x):
    """The last coefficient is taken for the constant and the first for a slope. In (3.2) the
    constant stands first.
    """
    return x @ c[:-1] + c[-1] + w(offsets(x, points)) @ lam


@answers("03.4")
def undefined_at_the_points(points, lam, c, x):
    """At a point of the data the field is no number: the kernel was computed there as zero times
    minus infinity. Does your line use the kernel that you wrote in 03.1?
    """
    s = squares(offsets(x, points))
    return basis(x) @ c + (s * np.log(s)) @ lam


@answers("03.4")
def half_of_the_kernel(points, lam, c, x):
    """The bumps are half as high as they should be: the logarithm was taken of the length instead
    of its square. The λ of 03.3 belong to the w of (3.1).
    """
    return basis(x) @ c + w(offsets(x, points)) @ lam / 2


# 03.5 The signs


@answers("03.5")
def as_one_reads(points):
    """All positive: that is the claim, not a count. The diagonal of the matrix is zero, so the
    sum of its eigenvalues is zero too. Compute them, and look at their signs.
    """
    return sum(points.shape) + 1, 0, 0


@answers("03.5")
def of_the_block(points):
    """These are the signs of the eigenvalues of the block A alone. Asked for are those of the whole
    matrix of (3.5): their numbers must add up to N + D + 1.
    """
    eigenvalues = np.linalg.eigvalsh(w(offsets(points, points)))
    return (
        np.sum(eigenvalues > 1e-9),
        np.sum(eigenvalues < -1e-9),
        np.sum(np.abs(eigenvalues) < 1e-9),
    )


@answers("03.5")
def signs_exchanged(points):
    """Positive and negative are exchanged. Is the order of the three numbers that which is asked
    for?
    """
    eigenvalues = np.linalg.eigvalsh(bordered(w(offsets(points, points)), basis(points)))
    return (
        np.sum(eigenvalues < -1e-9),
        np.sum(eigenvalues > 1e-9),
        np.sum(np.abs(eigenvalues) < 1e-9),
    )


@answers("03.5")
def none_found_zero(points):
    """No eigenvalue is counted as zero. Points on one line, or two at the same place, make one
    zero, and then (3.5) has many solutions, or none. Computed, it is a tiny number of either
    sign: was it compared with zero exactly?
    """
    n, d = points.shape
    return n, d + 1, 0


@answers("03.5")
def all_zeros_taken_for_negative(points):
    """An eigenvalue that should be zero was counted as negative. Whoever divides values into
    positive ones and the rest does not see that the matrix is singular. Which size does rounding
    explain?
    """
    eigenvalues = np.linalg.eigvalsh(bordered(w(offsets(points, points)), basis(points)))
    positive = np.sum(eigenvalues > 1e-9)
    return positive, len(eigenvalues) - positive, 0


@answers("03.5")
def two_numbers(points):
    """These are two numbers. Asked for are three: positive, negative, zero. The third tells whether
    the system can be solved.
    """
    eigenvalues = np.linalg.eigvalsh(bordered(w(offsets(points, points)), basis(points)))
    return np.sum(eigenvalues > 1e-9), np.sum(eigenvalues < -1e-9)


# 03.6 The gradient


def summed(factor, lam, c, y):
    return c[1:] + np.sum(factor[..., None] * lam[:, None] * y, axis=1)


def logarithm(y):
    return np.log(np.where(squares(y) > 0, squares(y), 1))


@answers("03.6")
def logarithm_not_differentiated(points, lam, c, x):
    """The square was differentiated and the logarithm was not. By the product rule each of the two
    factors of w is differentiated once: there are two terms.
    """
    y = offsets(x, points)
    return summed(2 * logarithm(y), lam, c, y)


@answers("03.6")
def square_not_differentiated(points, lam, c, x):
    """The logarithm was differentiated and the square in front of it was not: one of the two
    terms of the product rule is missing, the one that has a logarithm.
    """
    y = offsets(x, points)
    return summed(2 * np.ones(y.shape[:2]), lam, c, y)


@answers("03.6")
def inner_two_forgotten(points, lam, c, x):
    """The bumps contribute half of what they should: a factor 2 is missing, from the derivative of
    the squared length by a coordinate.
    """
    y = offsets(x, points)
    return summed(1 + logarithm(y), lam, c, y)


@answers("03.6")
def chain_rule_forgotten(points, lam, c, x):
    """This is the derivative of w by the squared length, the same for all coordinates. The gradient
    has a direction: multiply by the derivative of the squared length by each coordinate.
    """
    return c[1:] + ((1 + logarithm(offsets(x, points))) @ lam)[:, None]


@answers("03.6")
def logarithm_of_the_length_itself(points, lam, c, x):
    """The logarithm in your gradient is that of the length, and in (3.1) it is that of the squared
    length. One is half of the other.
    """
    y = offsets(x, points)
    return summed(2 * (1 + logarithm(y) / 2), lam, c, y)


@answers("03.6")
def slopes_forgotten(points, lam, c, x):
    """The bumps are differentiated and the affine part is left out. What is its gradient?"""
    y = offsets(x, points)
    return summed(2 * (1 + logarithm(y)), lam, 0 * c, y)


@answers("03.6")
def pointing_to_the_pins(points, lam, c, x):
    """The bumps push the wrong way: y points from the place to the data point. In (3.6) w is
    taken of x - p, and its gradient by x keeps that sign.
    """
    y = offsets(x, points)
    return summed(-2 * (1 + logarithm(y)), lam, c, y)


@answers("03.6")
def undefined_at_the_pins(points, lam, c, x):
    """At a point of the data this is zero times minus infinity, no number. The limit of the product
    exists: y tends to zero faster than the logarithm grows. That bump contributes nothing there.
    """
    y = offsets(x, points)
    return summed(2 * (1 + np.log(squares(y))), lam, c, y)


@answers("03.6")
def coefficients_slipped(points, lam, c, x):
    """The first D coefficients are taken for the slopes. The first of them is the constant, whose
    derivative is zero.
    """
    y = offsets(x, points)
    return summed(2 * (1 + logarithm(y)), lam, np.roll(c, 1), y)


# 03.7 The energy


@answers("03.7")
def factor_forgotten(points, values):
    """This is the quadratic form without the factor in front, which the integral in (3.7) has."""
    lam, _ = solved(w(offsets(points, points)), basis(points), values)
    return lam @ w(offsets(points, points)) @ lam


@answers("03.7")
def factor_of_the_half_kernel(points, values):
    """This is half of the energy. The factor 8π belongs to the kernel r² log r; with the w of (3.1)
    there is another one.
    """
    lam, _ = solved(w(offsets(points, points)), basis(points), values)
    return 8 * np.pi * lam @ w(offsets(points, points)) @ lam


@answers("03.7")
def form_of_the_values(points, values):
    """The values were put into the quadratic form. It is that of the coefficients: by (3.7) the
    energy is that of λ, and an affine field, whose values are not zero, has none.
    """
    return 16 * np.pi * values @ w(offsets(points, points)) @ values


@answers("03.7")
def squares_of_the_coefficients(points, values):
    """This is the sum of the squares of λ. Bumps that are close together bend the sheet jointly:
    the matrix A between the two vectors tells how.
    """
    lam, _ = solved(w(offsets(points, points)), basis(points), values)
    return 16 * np.pi * lam @ lam


@answers("03.7")
def without_constraints(points, values):
    """Here λ was found from A λ = φ alone. Without the constraints the integral is infinite, and
    this number, which may even be negative, is no energy.
    """
    a = w(offsets(points, points))
    return 16 * np.pi * values @ np.linalg.solve(a, values)


@answers("03.7")
def root_of_it(points, values):
    """This is the square root of the energy. Three times the values have nine times the energy, and
    yours only three times.
    """
    lam, _ = solved(w(offsets(points, points)), basis(points), values)
    return np.sqrt(np.abs(16 * np.pi * lam @ w(offsets(points, points)) @ lam))
