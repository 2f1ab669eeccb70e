"""Wrong answers to notebook 02, each with the sentence for the student."""

import numpy as np

from fieldgrade.authoring.catalogue import answers


def basis(points):
    return np.insert(points, 0, 1.0, axis=1)


def distances(points, x):
    return np.linalg.norm(points - x, axis=1)


def weight(points, x, epsilon):
    return (distances(points, x) ** 2 + epsilon**2) ** -1


def solved(points, values, factors):
    """Solve the normal equations in which each point counts by its factor."""
    b = basis(points)
    return np.linalg.solve((b.T * factors) @ b, (b.T * factors) @ values)


def local(points, values, x, epsilon):
    return solved(points, values, weight(points, x, epsilon) ** 2)


def value_at(c, x):
    return c[0] + x @ c[1:]


# 02.1 weights


@answers("02.1", named=False)
def zero_far_away(points, x, epsilon):
    """The weight (2.3) is small far away, but it is never zero."""
    w = weight(points, x, epsilon)
    return np.where(w * epsilon**2 < 1e-2, 0.0, w)


@answers("02.1", named=False)
def epsilon_counted_twice(points, x, epsilon):
    """At the point itself the weight is half of 1/ε²."""
    return 1 / (distances(points, x) ** 2 + 2 * epsilon**2)


@answers("02.1")
def distance_not_squared(points, x, epsilon):
    """The distance in the denominator is not squared, so a length and a squared length are added.
    The weight then has a kink at the point itself. Look at the power of r in (2.3).
    """
    return 1 / (distances(points, x) + epsilon**2)


@answers("02.1")
def epsilon_not_squared(points, x, epsilon):
    """ε is not squared, so a squared length and a length are added. The ratios of the weights would
    then depend on the unit of length. Look at the power of ε in (2.3).
    """
    return 1 / (distances(points, x) ** 2 + epsilon)


@answers("02.1")
def differences_added_before_squaring(points, x, epsilon):
    """The differences of the coordinates are added first and then squared, so differences of
    opposite signs cancel. What is the squared length of a vector?
    """
    return 1 / ((points - x).sum(axis=1) ** 2 + epsilon**2)


@answers("02.1")
def sum_of_the_lengths_squared(points, x, epsilon):
    """The distance and ε are added first, and their sum is squared. In (2.3) each of them is
    squared, and the squares are added.
    """
    return (distances(points, x) + epsilon) ** -2


@answers("02.1")
def one_sum_over_everything(points, x, epsilon):
    """The squares of all points are added to one number. Each point has its own distance. Along
    which axis of the array must the sum be taken?
    """
    return 1 / (np.linalg.norm(points - x) ** 2 + epsilon**2)


@answers("02.1")
def squared_already(points, x, epsilon):
    """This is the square of the weight. The square is taken in (2.5), so the fit would use the
    fourth power. The question asks for w of (2.3).
    """
    return weight(points, x, epsilon) ** 2


@answers("02.1")
def root_of_the_distance(points, x, epsilon):
    """A square root was taken: this is the reciprocal of a length, but (2.3) is the reciprocal of a
    squared length.
    """
    return np.sqrt(weight(points, x, epsilon))


@answers("02.1")
def distance_from_the_origin(points, x, epsilon):
    """These are the weights for the distances from the origin: x has no influence. Between which
    two points is r of (2.3) measured?
    """
    return weight(points, 0, epsilon)


@answers("02.1")
def reciprocal_forgotten(points, x, epsilon):
    """These numbers grow with the distance, so the farthest point has the largest weight. (2.3) is
    the reciprocal of this sum.
    """
    return distances(points, x) ** 2 + epsilon**2


@answers("02.1")
def made_to_sum_to_one(points, x, epsilon):
    """The weights were divided by their sum. The solution of (2.5) does not change, since a common
    factor cancels. But ψ of (2.7) changes, and (2.3) has no such sum.
    """
    w = weight(points, x, epsilon)
    return w / w.sum()


@answers("02.1")
def weights_as_a_matrix(points, x, epsilon):
    """The numbers are right, but they stand on the diagonal of a matrix. The question asks for a
    vector of shape (N,). The N × N matrix, which is almost all zeros, is not needed.
    """
    return np.diag(weight(points, x, epsilon))


@answers("02.1", named=False)
def absolute_positions(points, x, epsilon):
    """The coordinates of the points and of x have lost their signs."""
    return weight(np.abs(points), np.abs(x), epsilon)


# 02.2 weighted_fit


@answers("02.2")
def weights_not_squared(points, values, w):
    """The weights enter once, but (2.5) has their squares. Each equation of (2.4) is multiplied by
    w, and the normal equations multiply by w again. How often does W stand in (2.5)?
    """
    return solved(points, values, w)


@answers("02.2")
def fourth_power_of_the_weights(points, values, w):
    """The weights enter with their fourth power. Multiplying each row of B and V by w already leads
    to W² in the normal equations.
    """
    return np.linalg.lstsq(basis(points) * w[:, None] ** 2, values * w**2, rcond=None)[0]


@answers("02.2")
def weights_only_on_the_left(points, values, w):
    """The matrix is weighted, but the right-hand side is not. Then affine fields are not
    reproduced. Both sides of (2.4) are multiplied by W.
    """
    b = basis(points)
    return np.linalg.solve((b.T * w**2) @ b, b.T @ values)


@answers("02.2")
def right_side_weighted_once(points, values, w):
    """The right-hand side lacks one factor w: in (2.5) both sides have w². There both the rows of
    B and the values are multiplied by w. Otherwise affine fields are not reproduced.
    """
    b = basis(points)
    return np.linalg.solve((b.T * w**2) @ b, (b.T * w) @ values)


@answers("02.2")
def small_singular_values_dropped(points, values, w):
    """A pseudo-inverse takes small singular values for zero. In a small unit of length the slopes
    are among them, and are lost. `numpy.linalg.solve` drops nothing.
    """
    b = basis(points)
    return np.linalg.pinv((b.T * w**2) @ b) @ ((b.T * w**2) @ values)


@answers("02.2")
def weights_not_used(points, values, w):
    """These are the coefficients of plain least squares: the weights have no effect. Where does W
    enter (2.5)?
    """
    return solved(points, values, np.ones(len(points)))


@answers("02.2")
def no_constant_fitted(points, values, w):
    """The plane was fitted without a constant, so it passes through zero at the origin. What is the
    first entry of b(x) in (2.1)?
    """
    c = np.linalg.lstsq(points * w[:, None], values * w, rcond=None)[0]
    return np.insert(c, 0, 0.0)


@answers("02.2")
def slopes_first(points, values, w):
    """The numbers are right, but the constant stands last. In (2.1) it is the first coefficient,
    and the functions below use this order.
    """
    return np.roll(solved(points, values, w**2), -1)


@answers("02.2")
def constant_not_weighted(points, values, w):
    """The columns of the coordinates are weighted, but the column of ones is not. Add the ones
    first, then multiply the rows of B by w.
    """
    b = basis(points * w[:, None])
    return np.linalg.lstsq(b, values * w, rcond=None)[0]


@answers("02.2")
def values_weighted_alone(points, values, w):
    """The values are multiplied by the weights, but the rows of B are not. In (2.4) both sides of
    each equation have the weight. Here even an affine field does not satisfy the equations.
    """
    return np.linalg.lstsq(basis(points), w * values)[0]


@answers("02.2", named=False)
def one_measurement_for_each_point(points, values, w):
    """A point that is measured twice has two equations in (2.4), and both of them count."""
    first = np.unique(points, axis=0, return_index=True)[1]
    return solved(points[first], values[first], w[first] ** 2)


@answers("02.2", named=False)
def small_weights_set_to_zero(points, values, w):
    """Small weights were set to zero. If one weight is large, all others may be small, and they
    still determine the fit.
    """
    kept = np.where(w < 1e-2 * w.max(), 0, w)
    return np.linalg.lstsq(basis(points) * kept[:, None], values * kept, rcond=None)[0]


@answers("02.2")
def small_weights_left_out(points, values, w):
    """Measurements of small weight were left out. All weights are positive, so all measurements
    count: where the others are near one line, those of small weight determine a slope.
    """
    kept = w > 1e-3 * w.max()
    b = w[kept, None] * basis(points[kept])
    return np.linalg.lstsq(b, w[kept] * values[kept], rcond=None)[0]


# 02.4 field


@answers("02.4")
def coefficients_frozen(points, values, x, epsilon):
    """All values lie in one plane: the coefficients of the first evaluation point are used at all
    others. In (2.6) c depends on x, so each evaluation point has its own system.
    """
    return value_at(local(points, values, x[0], epsilon), x)


@answers("02.4")
def small_singular_values_dropped_at_each_point(points, values, x, epsilon):
    """A pseudo-inverse takes small singular values for zero. In a small unit of length the slopes
    are among them, and are lost. `numpy.linalg.solve` drops nothing.
    """
    b, squares = basis(points), [weight(points, place, epsilon) ** 2 for place in x]
    return np.array(
        [
            value_at(np.linalg.pinv((b.T * w) @ b) @ ((b.T * w) @ values), place)
            for w, place in zip(squares, x)
        ]
    )


@answers("02.4")
def weights_all_equal(points, values, x, epsilon):
    """This is plain least squares, one plane for all evaluation points: the weights have no effect.
    Do you use the weights of 02.1 for each evaluation point?
    """
    return value_at(solved(points, values, np.ones(len(points))), x)


@answers("02.4")
def constant_coefficient_returned(points, values, x, epsilon):
    """The result is c₀, the value of each local plane at the origin. (2.6) evaluates the plane of x
    at x.
    """
    return np.array([local(points, values, place, epsilon)[0] for place in x])


@answers("02.4")
def evaluated_at_the_points(points, values, x, epsilon):
    """The coefficients belong to the evaluation point, but the plane is evaluated at one of the
    measured points. In (2.6) b and c have the same argument x.
    """
    return np.array(
        [value_at(local(points, values, place, epsilon), p) for place, p in zip(x, points)]
    )


@answers("02.4")
def constant_forgotten(points, values, x, epsilon):
    """The slopes of each local plane are used, but not its constant. Then values that are all 1
    give zero. The first entry of b in (2.1) belongs to the constant.
    """
    return np.array([place @ local(points, values, place, epsilon)[1:] for place in x])


@answers("02.4")
def weighted_mean(points, values, x, epsilon):
    """This is a weighted mean of the values: a fit with the constant alone. It does not reproduce
    affine fields. The basis of (2.1) has D + 1 functions.
    """
    factors = np.array([weight(points, place, epsilon) ** 2 for place in x])
    return factors @ values / factors.sum(axis=1)


@answers("02.4")
def divided_by_the_weights(points, values, x, epsilon):
    """The value was divided by the sum of the weights. A weighted mean needs this division, but a
    fit does not, since a common factor of both sides of (2.5) cancels. Try values that are all 1.
    """
    sums = np.array([weight(points, place, epsilon).sum() for place in x])
    return np.array([value_at(local(points, values, place, epsilon), place) for place in x]) / sums


@answers("02.4")
def mirrored_distance(points, values, x, epsilon):
    """The distances are measured from −x, so x and the points were added, not subtracted. The
    points near the mirror image of x then have the largest weights. Look at r in (2.3).
    """
    return np.array([value_at(local(points, values, -place, epsilon), place) for place in x])


@answers("02.4")
def unsquared_in_the_field(points, values, x, epsilon):
    """The weights enter once, not squared, so points far away have too much influence. Compare your
    system with (2.5).
    """
    return np.array([value_at(solved(points, values, weight(points, p, epsilon)), p) for p in x])


def with_heavy_points(points, values, place, epsilon):
    """Fit without the points whose weights are below a millionth of the largest."""
    w = weight(points, place, epsilon)
    kept = w > 1e-6 * w.max()
    return basis(points[kept]) * w[kept, None], values[kept] * w[kept]


@answers("02.4", named=False)
def light_points_dropped(points, values, x, epsilon):
    """Points of small weight were dropped. If one weight is large, all others may be small, and
    they still determine the slopes.
    """
    found = []
    for place in x:
        b, v = with_heavy_points(points, values, place, epsilon)
        found.append(value_at(np.linalg.solve(b.T @ b, b.T @ v), place))
    return np.array(found)


@answers("02.4", named=False)
def light_points_dropped_and_shortest_solution(points, values, x, epsilon):
    """Without the points of small weight the slopes are not determined."""
    fits = (with_heavy_points(points, values, place, epsilon) for place in x)
    return [
        value_at(np.linalg.lstsq(*fit, rcond=None)[0], place)
        for fit, place in zip(fits, x, strict=True)
    ]


@answers("02.4", named=False)
def absolute_evaluation_points(points, values, x, epsilon):
    """The coordinates of the evaluation points have lost their signs."""
    return [value_at(local(points, values, y, epsilon), y) for y in np.abs(x)]


# 02.5 objective


@answers("02.5")
def weights_not_squared_in_the_objective(points, values, x, epsilon, coefficients):
    """The weights enter once. In (2.7) they stand inside the norm, which is squared. Minimizing
    your function would lead to other normal equations than (2.5).
    """
    residual = value_at(coefficients, points) - values
    return 0.5 * weight(points, x, epsilon) @ residual**2


@answers("02.5")
def without_the_half(points, values, x, epsilon, coefficients):
    """The factor ½ of (2.7) is missing. The minimum is at the same point without it, but the value
    is twice ψ.
    """
    residual = value_at(coefficients, points) - values
    return np.linalg.norm(weight(points, x, epsilon) * residual) ** 2


@answers("02.5")
def without_weights(points, values, x, epsilon, coefficients):
    """This is the objective of plain least squares: it has no weights. By which matrix are B c − V
    multiplied in (2.7)?
    """
    return 0.5 * np.linalg.norm(value_at(coefficients, points) - values) ** 2


@answers("02.5")
def values_not_weighted(points, values, x, epsilon, coefficients):
    """The weights multiply B c, but not V. In (2.7) W multiplies the whole difference."""
    error = weight(points, x, epsilon) * value_at(coefficients, points) - values
    return 0.5 * error @ error


@answers("02.5")
def length_not_squared(points, values, x, epsilon, coefficients):
    """This is half of the norm of the residual. In (2.7) the norm is squared, so that the gradient
    is linear in c.
    """
    residual = value_at(coefficients, points) - values
    return 0.5 * np.linalg.norm(weight(points, x, epsilon) * residual)


@answers("02.5")
def summed_before_squaring(points, values, x, epsilon, coefficients):
    """The residuals are added, and the sum is squared, so residuals of opposite signs cancel. In
    (2.7) each of them is squared first.
    """
    residual = value_at(coefficients, points) - values
    return 0.5 * (weight(points, x, epsilon) @ residual) ** 2


@answers("02.5")
def normalized_objective(points, values, x, epsilon, coefficients):
    """The sum is divided by the sum of the squared weights. This normalized objective appears in
    Part 2, but (2.7) is the plain sum.
    """
    factors = weight(points, x, epsilon) ** 2
    return 0.5 * factors @ (value_at(coefficients, points) - values) ** 2 / factors.sum()


@answers("02.5", named=False)
def multiplied_out(points, values, x, epsilon, coefficients):
    """Almost equal products of large values are subtracted: rounding noise has no fingerprint."""
    r = np.append(coefficients, -1.0)
    m = weight(points, x, epsilon)[:, None] * np.column_stack(
        [np.ones(len(points)), points, values]
    )
    return r @ (m.T @ m) @ r / 2


@answers("02.5", named=False)
def point_itself_left_out(points, values, x, epsilon, coefficients):
    """A point of the data at the evaluation point has the largest weight of all."""
    other = (points != x).any(axis=1)
    residual = basis(points[other]) @ coefficients - values[other]
    return np.sum((weight(points[other], x, epsilon) * residual) ** 2) / 2


# 02.7 gradient


def with_second_term(points, values, x, epsilon, data, first=1.0):
    """The first term of (2.8), and the second with the data that a student puts into the fit."""
    rows = []
    for place in x:
        w = weight(points, place, epsilon)
        c = solved(points, values, w**2)
        second = [value_at(solved(points, g, w**2), place) for g in data(w, place - points, c).T]
        rows.append(first * c[1:] + second)
    return np.array(rows)


@answers("02.7")
def diffuse_derivative(points, values, x, epsilon):
    """This is the first term of (2.8) alone, the slope of the fitted plane. It is called the
    diffuse derivative, and it is not the gradient of f. The coefficients change with x, and the
    second term is missing.
    """
    return np.array([local(points, values, place, epsilon)[1:] for place in x])


@answers("02.7")
def second_term_with_the_wrong_sign(points, values, x, epsilon):
    """The second term of (2.8) has the right size and the wrong sign. Check three signs: the
    derivative of the squared weight, the difference x − p, and the residual V − B c.
    """

    def data(w, away, c):
        return 4 * (w * (values - value_at(c, points)))[:, None] * away

    return with_second_term(points, values, x, epsilon, data)


@answers("02.7")
def derivative_of_the_weight_itself(points, values, x, epsilon):
    """The second term of (2.8) is half of what it must be. A factor 2 is missing: that of the
    square, ∂(w²) = 2 w ∂w, or that of the derivative of r², 2 (x − p).
    """

    def data(w, away, c):
        return -2 * (w * (values - value_at(c, points)))[:, None] * away

    return with_second_term(points, values, x, epsilon, data)


@answers("02.7")
def weight_lost_in_the_chain_rule(points, values, x, epsilon):
    """In the second term of (2.8) one power of the weight is missing. The derivative of s⁻² has the
    exponent −3. Count the powers of w again.
    """

    def data(w, away, c):
        return -4 * (values - value_at(c, points))[:, None] * away

    return with_second_term(points, values, x, epsilon, data)


@answers("02.7")
def squared_weight_twice_in_the_chain_rule(points, values, x, epsilon):
    """The squared weight enters the second term of (2.8) twice. The derivative of w² contains it,
    and the weighted fit multiplies its data by w² again. Which data make the product equal to the
    derivative?
    """

    def data(w, away, c):
        return -4 * (w**3 * (values - value_at(c, points)))[:, None] * away

    return with_second_term(points, values, x, epsilon, data)


@answers("02.7")
def right_side_alone_differentiated(points, values, x, epsilon):
    """Only the right-hand side of (2.5) was differentiated. The matrix H depends on x too, and the
    product rule has a term for it. Without this term even an affine field has a wrong gradient.
    """

    def data(w, away, c):
        return -4 * (w * values)[:, None] * away

    return with_second_term(points, values, x, epsilon, data)


@answers("02.7")
def second_term_alone(points, values, x, epsilon):
    """This is the second term of (2.8) alone, the effect of the change of the coefficients. The
    slope of the fitted plane is missing.
    """

    def data(w, away, c):
        return -4 * (w * (values - value_at(c, points)))[:, None] * away

    return with_second_term(points, values, x, epsilon, data, first=0.0)


@answers("02.7")
def constant_of_the_change_alone(points, values, x, epsilon):
    """Only the change of c₀ was added. All D + 1 coefficients change, and (2.8) multiplies their
    changes by b(x).
    """
    rows = []
    for place in x:
        w = weight(points, place, epsilon)
        c = solved(points, values, w**2)
        g = -4 * (w * (values - value_at(c, points)))[:, None] * (place - points)
        rows.append(c[1:] + [solved(points, column, w**2)[0] for column in g.T])
    return np.array(rows)


def differenced(points, values, x, epsilon, h):
    def f(y):
        return np.array([value_at(local(points, values, place, epsilon), place) for place in y])

    return np.stack([(f(x + h * e) - f(x - h * e)) / (2 * h) for e in np.eye(x.shape[1])], axis=1)


@answers("02.7", named=False)
def difference_quotient(points, values, x, epsilon):
    """A difference quotient with a fixed step is inaccurate in other units of length."""
    return differenced(points, values, x, epsilon, 1e-5)


@answers("02.7", named=False)
def slope_at_the_points_of_the_data(points, values, x, epsilon):
    """At a point of the data only the derivative of its own weight vanishes, not the whole second
    term of (2.8): the other weights change there as well.
    """
    rows = []
    for place in x:
        w = weight(points, place, epsilon)
        c = local(points, values, place, epsilon)
        residual = values - basis(points) @ c
        changes = [
            value_at(solved(points, -4 * w * (place - points)[:, k] * residual, w**2), place)
            for k in range(len(place))
        ]
        rows.append(c[1:] + changes * (distances(points, place).min() > 0))
    return np.array(rows)


# 02.8 errors


def misses(points, queries, n, epsilon):
    values = points.sum(axis=1) ** n
    plain = value_at(solved(points, values, np.ones(len(points))), queries)
    moving = np.array([value_at(local(points, values, p, epsilon), p) for p in queries])
    return np.array([plain, moving]) - queries.sum(axis=1) ** n


def root_mean_square(missed):
    return np.sqrt(np.mean(missed**2, axis=-1))


@answers("02.8")
def root_forgotten(points, queries, n, epsilon):
    """These are mean squares: the square root of (2.9) is missing. Without it the error does not
    have the unit of the values.
    """
    return np.mean(misses(points, queries, n, epsilon) ** 2, axis=1)


@answers("02.8")
def not_divided_by_the_number(points, queries, n, epsilon):
    """The squares are added, but not averaged, so the error grows with the number of evaluation
    points. Which factor precedes the sum in (2.9)?
    """
    return np.linalg.norm(misses(points, queries, n, epsilon), axis=1)


@answers("02.8")
def mean_of_absolute_values(points, queries, n, epsilon):
    """This is the mean absolute error. (2.9) is the root-mean-square error: it squares first, and
    takes the square root of the mean.
    """
    return np.abs(misses(points, queries, n, epsilon)).mean(axis=1)


@answers("02.8")
def mean_without_squares(points, queries, n, epsilon):
    """Errors of opposite signs cancel here. In (2.9) each error is squared before the mean is
    taken.
    """
    return np.abs(misses(points, queries, n, epsilon).mean(axis=1))


@answers("02.8")
def spread_about_the_mean(points, queries, n, epsilon):
    """This is the standard deviation of the errors, their deviation from their own mean. A field
    that is too large everywhere by the same amount would have no error. (2.9) measures the
    deviation from zero.
    """
    return misses(points, queries, n, epsilon).std(axis=1)


@answers("02.8")
def moving_least_squares_first(points, queries, n, epsilon):
    """The two numbers are right, but exchanged: plain least squares comes first."""
    return root_mean_square(misses(points, queries, n, epsilon))[::-1]


@answers("02.8")
def at_the_measured_points(points, queries, n, epsilon):
    """The errors are taken at the measured points, whose values the fit has used. (2.9) takes them
    at the other points.
    """
    return root_mean_square(misses(points, points, n, epsilon))


@answers("02.8")
def powers_added(points, queries, n, epsilon):
    """The coordinates are raised to the power n and then added. The field is the power of the
    sum.
    """
    values = (points**n).sum(axis=1)
    plain = value_at(solved(points, values, np.ones(len(points))), queries)
    moving = np.array([value_at(local(points, values, p, epsilon), p) for p in queries])
    return root_mean_square(np.array([plain, moving]) - (queries**n).sum(axis=1))


@answers("02.8")
def same_weights_twice(points, queries, n, epsilon):
    """Both numbers are the error of plain least squares: the second fit has equal weights too. Does
    your code use ε?
    """
    return np.full(2, root_mean_square(misses(points, queries, n, epsilon))[0])


# 02.9 leave_one_out


def seen(points, values, epsilon):
    return np.array([value_at(local(points, values, p, epsilon), p) for p in points])


def unseen(points, values, epsilon):
    rows = []
    for i in range(len(points)):
        p, v = np.delete(points, i, axis=0), np.delete(values, i)
        rows.append(value_at(local(p, v, points[i], epsilon), points[i]))
    return np.array(rows)


@answers("02.9")
def nothing_left_out(points, values, epsilon):
    """These are the residuals at the measured points: no measurement was left out. The field has
    used each value that it is compared with. For small ε it agrees with all of them, with their
    noise.
    """
    return values - seen(points, values, epsilon)


@answers("02.9")
def other_sign(points, values, epsilon):
    """The numbers are right except for the sign. In (2.10) the prediction is subtracted from the
    measurement.
    """
    return unseen(points, values, epsilon) - values


@answers("02.9")
def predictions(points, values, epsilon):
    """These are the predictions at the points that were left out. In (2.10) they are subtracted
    from the measurements.
    """
    return unseen(points, values, epsilon)


@answers("02.9")
def value_set_to_zero(points, values, epsilon):
    """The value was set to zero, but the point still takes part in the fit and pulls the field
    towards zero. Leave out both the point and its value.
    """
    rows = []
    for i in range(len(points)):
        v = values.copy()
        v[i] = 0
        rows.append(values[i] - value_at(local(points, v, points[i], epsilon), points[i]))
    return np.array(rows)


@answers("02.9")
def one_number_for_all(points, values, epsilon):
    """This is one number, the root-mean-square error. The question asks for the N errors."""
    return root_mean_square(values - unseen(points, values, epsilon))


@answers("02.9")
def plain_least_squares_left_out(points, values, epsilon):
    """A measurement is left out, but the others are fitted with equal weights. So ε has no effect.
    Which weights belong to the evaluation point p_i?
    """
    rows = []
    for i in range(len(points)):
        p, v = np.delete(points, i, axis=0), np.delete(values, i)
        rows.append(values[i] - value_at(solved(p, v, np.ones(len(p))), points[i]))
    return np.array(rows)


def left_out_where(equal, points, values, epsilon):
    rows = []
    for i, p in enumerate(points):
        others = ~equal(i)
        w = local(points[others], values[others], p, epsilon)
        rows.append(values[i] - value_at(w, p))
    return np.array(rows)


@answers("02.9", named=False)
def all_at_the_point_left_out(points, values, epsilon):
    """Another measurement at the same point was left out too, although it was not the one."""
    return left_out_where(lambda i: (points == points[i]).all(axis=1), points, values, epsilon)


@answers("02.9", named=False)
def all_of_the_first_coordinate_left_out(points, values, epsilon):
    """The measurement was recognized by its first coordinate, which others may have too."""
    return left_out_where(lambda i: points[:, 0] == points[i, 0], points, values, epsilon)


@answers("02.9", named=False)
def all_of_the_value_left_out(points, values, epsilon):
    """The measurement was recognized by its value, which others may have too."""
    return left_out_where(lambda i: values == values[i], points, values, epsilon)


@answers("02.9", named=False)
def by_the_shortcut(points, values, epsilon):
    """If ε is far smaller than the spacing of the points, both sides of the quotient lose their
    digits.
    """
    rows = []
    for p, v in zip(points, values):
        b, w = basis(points - p), weight(points, p, epsilon) ** 2
        a = np.linalg.solve((b.T * w) @ b, b.T * w)[0]
        itself = np.argmin(np.abs(values - v) + distances(points, p))
        rows.append((v - a @ values) / (1 - a[itself]))
    return np.array(rows)


@answers("02.9")
def squared_errors(points, values, epsilon):
    """These are the squares of the errors. (2.10) defines the errors with their signs."""
    return (values - unseen(points, values, epsilon)) ** 2


@answers("02.9")
def another_row_left_out(points, values, epsilon):
    """The wrong row was left out: the one after the evaluation point. Is the index of the omitted
    row the same as the index of the value?
    """
    rows = []
    for i in range(len(points)):
        gone = (i + 1) % len(points)
        p, v = np.delete(points, gone, axis=0), np.delete(values, gone)
        rows.append(values[i] - value_at(local(p, v, points[i], epsilon), points[i]))
    return np.array(rows)


@answers("02.2", named=False)
def without_small_weights(points, values, w):
    """Points of small weight are left out, and with them what they alone determine."""
    kept = w > 1e-4 * w.max()
    b = np.column_stack([np.ones(kept.sum()), points[kept]])
    return np.linalg.lstsq(w[kept, None] * b, w[kept] * values[kept], rcond=None)[0]
