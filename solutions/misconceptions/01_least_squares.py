"""What students write instead of notebook 01, and what each of them should hear."""

import numpy as np

from fieldgrade.authoring.catalogue import answers


def basis(points):
    return np.insert(points, 0, 1.0, axis=1)


@answers("01.1")
def no_constant(points):
    """The constant is missing. Without a column for c₀ every field would have to vanish at the
    origin. Look at b(x) in (1.1): how many entries does it have?
    """
    return points.copy()


@answers("01.1")
def constant_last(points):
    """The columns are there, but the constant stands last. Then the first number of c is a slope,
    and everything that takes c₀ for the constant goes wrong. Compare the order of b(x) in (1.1).
    """
    return np.append(points, np.ones((len(points), 1)), axis=1)


@answers("01.1")
def points_in_columns(points):
    """Rows and columns are exchanged: this is the transpose of B. In (1.2) each point has a row."""
    return np.insert(points, 0, 1.0, axis=1).T


@answers("01.1")
def zeros_for_ones(points):
    """The first column is zero, so c₀ is multiplied by nothing and no value could tell it. Which
    function must the first coefficient be multiplied by in (1.1)?
    """
    return np.insert(points, 0, 0.0, axis=1)


@answers("01.2")
def right_side_not_projected(points, values):
    """The left side is that of the normal equations and the right side is not: only the first
    D + 1 values are used. Both sides of (1.4) are multiplied by the same matrix.
    """
    b = basis(points)
    return np.linalg.solve(b.T @ b, values[: b.shape[1]])


@answers("01.2")
def through_the_first_points(points, values):
    """This plane goes through the first D + 1 points and ignores all others. Least squares uses
    every value. Which system has as many equations as unknowns, however many points there are?
    """
    b = basis(points)[: points.shape[1] + 1]
    return np.linalg.solve(b, values[: len(b)])


@answers("01.2")
def slopes_first(points, values):
    """The numbers are the right ones in another order: the constant is last. In (1.1) the
    coefficients are c₀ for the constant, then one for each coordinate.
    """
    return np.roll(np.linalg.lstsq(basis(points), values)[0], -1)


@answers("01.2")
def no_constant_fitted(points, values):
    """The plane is forced through the origin: the fit was made without a constant. A field need not
    vanish at the origin. Is the first column of your matrix in use?
    """
    return np.insert(np.linalg.lstsq(points, values)[0], 0, 0.0)


@answers("01.2")
def mean_and_slopes(points, values):
    """The slopes are right, the constant is not: it is the mean of the values, which the plane has
    at the mean of the points, and c₀ is its value at the origin.
    """
    c = np.linalg.lstsq(basis(points), values)[0]
    return np.insert(c[1:], 0, values.mean())


@answers("01.3")
def slopes_only(coefficients, x):
    """The constant c₀ is left out, so the whole field is shifted. It belongs to b(x) as well."""
    return x @ coefficients[1:]


@answers("01.3")
def constant_subtracted(coefficients, x):
    """The constant c₀ enters with the wrong sign: the field is shifted by twice its value. What
    does (1.1) give at the origin?
    """
    return x @ coefficients[1:] - coefficients[0]


@answers("01.3")
def constant_taken_last(coefficients, x):
    """The last coefficient is taken for the constant and the first for a slope. By (1.1) the
    constant is the first.
    """
    return x @ coefficients[:-1] + coefficients[-1]


@answers("01.4")
def counted(points):
    """This counts points and coefficients. It is right only for points in general position: many
    points on one line determine no plane. Which of your cases has points like that?
    """
    return min(len(points), points.shape[1] + 1)


@answers("01.4")
def rank_of_the_points(points):
    """This is the rank of the array of points, which knows nothing of the constant and changes when
    all points move together. Asked for is the rank of B.
    """
    return np.linalg.matrix_rank(points)


@answers("01.4")
def dimension(points):
    """This is the dimension of the flat through the points, one less than the rank of B: a single
    point has dimension 0, and still determines one coefficient.
    """
    return np.linalg.matrix_rank(points - points[0], tol=1e-9)


@answers("01.4")
def full_or_nothing(points):
    """This says whether the rank is full, as one or zero; asked for is the rank itself. How many
    coefficients do points on one line determine?
    """
    return int(
        np.linalg.matrix_rank(basis(points - points.mean(axis=0)), tol=1e-9) == points.shape[1] + 1
    )


@answers("01.5")
def all_coefficients(coefficients, x):
    """The constant is among the derivatives. Differentiating (1.1) by x₁ … x_D makes it vanish: one
    entry for each coordinate is left.
    """
    return np.tile(coefficients, (len(x), 1))


@answers("01.5")
def times_the_place(coefficients, x):
    """These are the terms c_k x_k of the field, not their derivatives. How does c_k x_k change when
    x_k grows by one?
    """
    return coefficients[1:] * x


@answers("01.5")
def last_slopes_dropped(coefficients, x):
    """The coefficients have slipped by one: the constant stands where the slope along the first
    coordinate belongs.
    """
    return np.tile(coefficients[:-1], (len(x), 1))


@answers("01.6")
def without_the_half(points, values, coefficients):
    """The factor ½ is missing. It does not move the minimum, but it makes the gradient of ψ simple,
    and the number that (1.3) defines has it.
    """
    return np.sum((basis(points) @ coefficients - values) ** 2)


@answers("01.6")
def mean_instead_of_sum(points, values, coefficients):
    """This is a mean of squares: it has been divided by the number of points. ψ of (1.3) is half of
    their sum, and grows when points are added.
    """
    return 0.5 * np.mean((basis(points) @ coefficients - values) ** 2)


@answers("01.6")
def not_squared(points, values, coefficients):
    """This is half of the length of the residual. In (1.3) the length is squared, which is what
    makes the equations for c linear.
    """
    return 0.5 * np.linalg.norm(basis(points) @ coefficients - values)


@answers("01.6")
def of_the_values(points, values, coefficients):
    """This measures the fitted values and not how far they are from the data. Which difference
    stands between the bars in (1.3)?
    """
    return 0.5 * np.sum((basis(points) @ coefficients) ** 2)
