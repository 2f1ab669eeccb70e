"""What students write instead of notebook 02, and what each of them should hear."""

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


@answers("02.1")
def distance_not_squared(points, x, epsilon):
    """The distance stands in the denominator as it is, not squared. A length and the square of
    a length are added, and the weight has a kink at the point itself. Look at the power of r in
    (2.3).
    """
    return 1 / (distances(points, x) + epsilon**2)


@answers("02.1")
def epsilon_not_squared(points, x, epsilon):
    """ε enters as it is, not squared. A squared length and a length are added: in metres and
    in centimetres the weights would then be different ones. Look at the power of ε in (2.3).
    """
    return 1 / (distances(points, x) ** 2 + epsilon)


@answers("02.1")
def differences_added_before_squaring(points, x, epsilon):
    """The differences of the coordinates are added first and squared afterwards, so that a step to
    the right and one down cancel. The squared length of a vector is the sum of what?
    """
    return 1 / ((points - x).sum(axis=1) ** 2 + epsilon**2)


@answers("02.1")
def sum_of_the_lengths_squared(points, x, epsilon):
    """The distance and ε are added first, and their sum is squared. That has a mixed term, and the
    weight has a kink at the point itself. In (2.3) each of the two is squared by itself.
    """
    return (distances(points, x) + epsilon) ** -2


@answers("02.1")
def one_sum_over_everything(points, x, epsilon):
    """All squares are added up, those of all points together, so that one number comes out. Each
    point has a distance of its own: along which axis of the array must the sum go?
    """
    return 1 / (np.linalg.norm(points - x) ** 2 + epsilon**2)


@answers("02.1")
def squared_already(points, x, epsilon):
    """This is the square of the weight. It does enter squared, but in (2.5), where you would then
    have its fourth power. Here w itself of (2.3) is asked for.
    """
    return weight(points, x, epsilon) ** 2


@answers("02.1")
def root_of_the_distance(points, x, epsilon):
    """A root has been taken: this is one over a length, where (2.3) is one over a squared length.
    Which of the two is r², and which is r?
    """
    return np.sqrt(weight(points, x, epsilon))


@answers("02.1")
def distance_from_the_origin(points, x, epsilon):
    """The distances are those of the points from the origin: the place x has no part in them, so
    the weights would be the same everywhere and nothing would move. Between which two does r in
    (2.3) measure?
    """
    return weight(points, 0, epsilon)


@answers("02.1")
def reciprocal_forgotten(points, x, epsilon):
    """These numbers grow with the distance: the farthest point would count most. Look again
    at which side of the fraction in (2.3) the distance is on.
    """
    return distances(points, x) ** 2 + epsilon**2


@answers("02.1")
def made_to_sum_to_one(points, x, epsilon):
    """The weights have been divided by their sum. The fit does not notice, since a common factor
    drops out of (2.5), but ψ of (2.7) would, and (2.3) has no sum.
    """
    w = weight(points, x, epsilon)
    return w / w.sum()


@answers("02.1")
def weights_as_a_matrix(points, x, epsilon):
    """The numbers are right, but they stand on the diagonal of a matrix. Asked for is the vector
    of them: a full N × N matrix is almost all zeros, and you will see that it is not needed.
    """
    return np.diag(weight(points, x, epsilon))


# 02.2 weighted_fit


@answers("02.2")
def weights_not_squared(points, values, w):
    """The weights enter once, not squared. Each equation of (2.4) is multiplied by w, and the
    normal equations multiply by w again, so the points nearby count for less here than they should.
    Look at where W stands in (2.5), and how often.
    """
    return solved(points, values, w)


@answers("02.2")
def fourth_power_of_the_weights(points, values, w):
    """The weights enter with the fourth power: squared once too often. Multiplying each row of
    B and V by w makes W² in the normal equations all by itself.
    """
    return solved(points, values, w**4)


@answers("02.2")
def weights_only_on_the_left(points, values, w):
    """The matrix is weighted and the right side is not. A plane that goes through all values would
    then no longer be found. Both sides of (2.4) are multiplied by W.
    """
    b = basis(points)
    return np.linalg.solve((b.T * w**2) @ b, b.T @ values)


@answers("02.2")
def right_side_weighted_once(points, values, w):
    """On the left the weights are squared, on the right they are not. Even values of an affine
    field are then not reproduced. Compare the two sides of (2.5).
    """
    b = basis(points)
    return np.linalg.solve((b.T * w**2) @ b, (b.T * w) @ values)


@answers("02.2")
def weights_not_used(points, values, w):
    """These are the coefficients of plain least squares: the weights have no effect. All points
    count alike then, however far away. Where does W enter (2.5)?
    """
    return solved(points, values, np.ones(len(points)))


@answers("02.2")
def no_constant_fitted(points, values, w):
    """The plane is forced through zero at the origin: it was fitted without the constant. A field
    need not vanish at the origin. How many entries has b(x) in (2.1), and which is the first?
    """
    c = np.linalg.lstsq(points * w[:, None], values * w, rcond=None)[0]
    return np.insert(c, 0, 0.0)


@answers("02.2")
def slopes_first(points, values, w):
    """The numbers are the right ones in another order: the constant is last. In (2.1) it is the
    first of the coefficients, and the functions below will take it from there.
    """
    return np.roll(solved(points, values, w**2), -1)


@answers("02.2")
def constant_not_weighted(points, values, w):
    """The columns of the coordinates are weighted and the column of ones is not, so the equations
    are no longer multiplied by w as a whole. Add the ones first, and weight the rows of B then.
    """
    b = basis(points * w[:, None])
    return np.linalg.lstsq(b, values * w, rcond=None)[0]


@answers("02.2")
def values_weighted_alone(points, values, w):
    """The values are multiplied by the weights, and the rows of B are not: each equation of (2.4)
    has its weight on both sides. As it is, no equation holds even where the field is affine.
    """
    return np.linalg.lstsq(basis(points), w * values)[0]


# 02.4 field


@answers("02.4")
def coefficients_frozen(points, values, x, epsilon):
    """All values lie in one plane: the coefficients of the first place are used at every other.
    They are good near that place only. In (2.6) c depends on x, so each place has a system of
    its own.
    """
    return value_at(local(points, values, x[0], epsilon), x)


@answers("02.4")
def weights_all_equal(points, values, x, epsilon):
    """This is plain least squares, one plane for all places: the weights have no effect. Are those
    of 02.1 passed on, for the place at hand?
    """
    return value_at(solved(points, values, np.ones(len(points))), x)


@answers("02.4")
def constant_coefficient_returned(points, values, x, epsilon):
    """What is returned is c₀, the value of each local plane at the origin, far from where
    the plane is good. (2.6) evaluates the plane of x at x.
    """
    return np.array([local(points, values, place, epsilon)[0] for place in x])


@answers("02.4")
def evaluated_at_the_points(points, values, x, epsilon):
    """The coefficients are those of the place, but the plane is evaluated at one of the measured
    points. In (2.6) the same x stands in b and in c; the points are in B only.
    """
    return np.array(
        [value_at(local(points, values, place, epsilon), p) for place, p in zip(x, points)]
    )


@answers("02.4")
def constant_forgotten(points, values, x, epsilon):
    """The slopes of each local plane are used, and its constant is not: even values that are all
    one give zero. The first entry of b in (2.1) belongs to it.
    """
    return np.array([place @ local(points, values, place, epsilon)[1:] for place in x])


@answers("02.4")
def weighted_mean(points, values, x, epsilon):
    """This is a weighted mean of the values, which knows no slopes: a fit with the constant alone.
    It does not even reproduce an affine field. The basis of (2.1) has D + 1 functions.
    """
    factors = np.array([weight(points, place, epsilon) ** 2 for place in x])
    return factors @ values / factors.sum(axis=1)


@answers("02.4")
def divided_by_the_weights(points, values, x, epsilon):
    """The value has been divided by the sum of the weights. A mean needs that, a fit does not: a
    factor that is common to both sides of (2.5) drops out by itself. Try values that are all one.
    """
    sums = np.array([weight(points, place, epsilon).sum() for place in x])
    return np.array([value_at(local(points, values, place, epsilon), place) for place in x]) / sums


@answers("02.4")
def mirrored_distance(points, values, x, epsilon):
    """The distances are taken to the wrong place: x and the points have been added, not
    subtracted, or one of them has changed its sign. The points that count most are then those
    around the mirror image of x. Look at r in (2.3).
    """
    return np.array([value_at(local(points, values, -place, epsilon), place) for place in x])


@answers("02.4")
def unsquared_in_the_field(points, values, x, epsilon):
    """The weights enter once, not squared, so that far points count for too much. The field
    is smoother and farther from the truth. If this is not written with your 02.2, compare it
    with (2.5).
    """
    return np.array([value_at(solved(points, values, weight(points, p, epsilon)), p) for p in x])


# 02.5 objective


@answers("02.5")
def weights_not_squared_in_the_objective(points, values, x, epsilon, coefficients):
    """The weights enter once. In (2.7) they stand between the bars and are squared with the
    rest. Minimising this function would lead to other normal equations than (2.5).
    """
    residual = value_at(coefficients, points) - values
    return 0.5 * weight(points, x, epsilon) @ residual**2


@answers("02.5")
def without_the_half(points, values, x, epsilon, coefficients):
    """The factor ½ is missing. The lowest point is the same without it, but the number is not
    that of (2.7).
    """
    residual = value_at(coefficients, points) - values
    return np.linalg.norm(weight(points, x, epsilon) * residual) ** 2


@answers("02.5")
def without_weights(points, values, x, epsilon, coefficients):
    """This is the objective of plain least squares: there are no weights in it, and so no place.
    What is multiplied by W(x) in (2.7)?
    """
    return 0.5 * np.linalg.norm(value_at(coefficients, points) - values) ** 2


@answers("02.5")
def values_not_weighted(points, values, x, epsilon, coefficients):
    """The weights multiply Bc and not V, so a plane through all values would still have an
    error. In (2.7) the weights stand outside of the brackets.
    """
    error = weight(points, x, epsilon) * value_at(coefficients, points) - values
    return 0.5 * error @ error


@answers("02.5")
def length_not_squared(points, values, x, epsilon, coefficients):
    """This is half of the length of the error; (2.7) has the squared length. Only the square makes
    the equations for the lowest point linear.
    """
    residual = value_at(coefficients, points) - values
    return 0.5 * np.linalg.norm(weight(points, x, epsilon) * residual)


@answers("02.5")
def summed_before_squaring(points, values, x, epsilon, coefficients):
    """The errors are added up and the sum is squared, so that errors of opposite signs cancel. In
    (2.7) each of them is squared first.
    """
    residual = value_at(coefficients, points) - values
    return 0.5 * (weight(points, x, epsilon) @ residual) ** 2


@answers("02.5")
def normalised_objective(points, values, x, epsilon, coefficients):
    """The sum is divided by the sum of the squared weights. That is a sensible quantity, and you
    will meet it below as the normalised one, but (2.7) is the plain sum.
    """
    factors = weight(points, x, epsilon) ** 2
    return 0.5 * factors @ (value_at(coefficients, points) - values) ** 2 / factors.sum()


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
    """This is the first term of (2.8) alone, the slope of the fitted plane, known as the diffuse
    derivative. It is not the gradient of f, since the plane turns as x moves. What is missing
    is how the coefficients change.
    """
    return np.array([local(points, values, place, epsilon)[1:] for place in x])


@answers("02.7")
def second_term_with_the_wrong_sign(points, values, x, epsilon):
    """The second term of (2.8) has the right size and the wrong sign. There are three places to
    look at: the derivative of the squared weight is negative as one goes away from a point; the
    difference is x minus the point; and the residual is V minus Bc.
    """

    def data(w, away, c):
        return 4 * (w * (values - value_at(c, points)))[:, None] * away

    return with_second_term(points, values, x, epsilon, data)


@answers("02.7")
def derivative_of_the_weight_itself(points, values, x, epsilon):
    """The second term of (2.8) is half of what it should be. You have differentiated w, but what
    stands in (2.5) is w². The chain rule has one factor more.
    """

    def data(w, away, c):
        return -2 * (w * (values - value_at(c, points)))[:, None] * away

    return with_second_term(points, values, x, epsilon, data)


@answers("02.7")
def weight_lost_in_the_chain_rule(points, values, x, epsilon):
    """In the second term of (2.8) one power of the weight is missing: differentiating s⁻² lowers
    the exponent by one, so the derivative of w² falls faster with the distance than w² itself.
    Count the powers of w again.
    """

    def data(w, away, c):
        return -4 * (values - value_at(c, points))[:, None] * away

    return with_second_term(points, values, x, epsilon, data)


@answers("02.7")
def squared_weight_twice_in_the_chain_rule(points, values, x, epsilon):
    """The squared weight is in the second term of (2.8) twice. The derivative of w² contains it,
    and the weighted fit multiplies what it is given by w² once more. What must it be given, so that
    the product is the derivative?
    """

    def data(w, away, c):
        return -4 * (w**3 * (values - value_at(c, points)))[:, None] * away

    return with_second_term(points, values, x, epsilon, data)


@answers("02.7")
def right_side_alone_differentiated(points, values, x, epsilon):
    """Only the right side of (2.5) has been differentiated. The matrix H on the left depends on x
    as well, and the product rule has a term for it. A sign that it is missing: even an affine
    field would have the wrong slope.
    """

    def data(w, away, c):
        return -4 * (w * values)[:, None] * away

    return with_second_term(points, values, x, epsilon, data)


@answers("02.7")
def second_term_alone(points, values, x, epsilon):
    """This is the second term of (2.8) alone: how the change of the coefficients changes the
    value. The slope of the fitted plane itself is missing.
    """

    def data(w, away, c):
        return -4 * (w * (values - value_at(c, points)))[:, None] * away

    return with_second_term(points, values, x, epsilon, data, first=0.0)


@answers("02.7")
def constant_of_the_change_alone(points, values, x, epsilon):
    """Of the changes of the coefficients only that of c₀ has been added. All D + 1 of them change,
    and (2.8) multiplies their changes by b(x).
    """
    rows = []
    for place in x:
        w = weight(points, place, epsilon)
        c = solved(points, values, w**2)
        g = -4 * (w * (values - value_at(c, points)))[:, None] * (place - points)
        rows.append(c[1:] + [solved(points, column, w**2)[0] for column in g.T])
    return np.array(rows)


# 02.8 errors


def misses(points, places, n, epsilon):
    values = points.sum(axis=1) ** n
    plain = value_at(solved(points, values, np.ones(len(points))), places)
    moving = np.array([value_at(local(points, values, p, epsilon), p) for p in places])
    return np.array([plain, moving]) - places.sum(axis=1) ** n


def root_mean_square(missed):
    return np.sqrt(np.mean(missed**2, axis=-1))


@answers("02.8")
def root_forgotten(points, places, n, epsilon):
    """These are mean squares: the root of (2.9) is missing. Without it the error has not the unit
    of the values, and a factor of ten looks like a hundred.
    """
    return np.mean(misses(points, places, n, epsilon) ** 2, axis=1)


@answers("02.8")
def not_divided_by_the_number(points, places, n, epsilon):
    """The squares are added up, not averaged, so that more places seem to make both methods worse.
    Look at what stands in front of the sum in (2.9).
    """
    return np.linalg.norm(misses(points, places, n, epsilon), axis=1)


@answers("02.8")
def mean_of_absolute_values(points, places, n, epsilon):
    """This is the mean of the absolute errors. It is a measure of error too, but (2.9) squares
    first and takes the root at the end, which counts large errors for more.
    """
    return np.abs(misses(points, places, n, epsilon)).mean(axis=1)


@answers("02.8")
def mean_without_squares(points, places, n, epsilon):
    """Errors of opposite signs cancel here: a field that is too high as often as too low would
    have none. In (2.9) each error is squared before the mean is taken.
    """
    return np.abs(misses(points, places, n, epsilon).mean(axis=1))


@answers("02.8")
def spread_about_the_mean(points, places, n, epsilon):
    """This is the standard deviation of the errors, how far they are from their own mean. A field
    that is too high everywhere by the same amount would seem perfect. (2.9) measures how far
    they are from zero.
    """
    return misses(points, places, n, epsilon).std(axis=1)


@answers("02.8")
def moving_least_squares_first(points, places, n, epsilon):
    """The numbers are right and exchanged: plain least squares is asked for first, then moving
    least squares.
    """
    return root_mean_square(misses(points, places, n, epsilon))[::-1]


@answers("02.8")
def at_the_measured_points(points, places, n, epsilon):
    """The errors are taken at the measured points, where the fit has seen the values. That makes
    moving least squares look almost perfect. Asked for are the errors at the other places.
    """
    return root_mean_square(misses(points, points, n, epsilon))


@answers("02.8")
def powers_added(points, places, n, epsilon):
    """The coordinates are raised to the power n one by one and added then. The field is the power
    of the sum.
    """
    values = (points**n).sum(axis=1)
    plain = value_at(solved(points, values, np.ones(len(points))), places)
    moving = np.array([value_at(local(points, values, p, epsilon), p) for p in places])
    return root_mean_square(np.array([plain, moving]) - (places**n).sum(axis=1))


@answers("02.8")
def same_weights_twice(points, places, n, epsilon):
    """Both numbers are the error of plain least squares: the second was found with equal weights as
    well. Is ε used anywhere?
    """
    return np.full(2, root_mean_square(misses(points, places, n, epsilon))[0])


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
    """These are the residuals at the measured points: no measurement has been left out. The field
    has seen each value that it is compared with, and a small ε makes it agree with all of them,
    right or wrong.
    """
    return values - seen(points, values, epsilon)


@answers("02.9")
def other_sign(points, values, epsilon):
    """The numbers are right but for the sign. In (2.10) the prediction is subtracted from the
    measurement.
    """
    return unseen(points, values, epsilon) - values


@answers("02.9")
def predictions(points, values, epsilon):
    """These are the predictions for the points that were left out. In (2.10) they are compared with
    something.
    """
    return unseen(points, values, epsilon)


@answers("02.9")
def value_set_to_zero(points, values, epsilon):
    """The value was set to zero, but the point is still there: it pulls the field to zero right
    where it is asked. Leaving a measurement out takes away the point as well as the value.
    """
    rows = []
    for i in range(len(points)):
        v = values.copy()
        v[i] = 0
        rows.append(values[i] - value_at(local(points, v, points[i], epsilon), points[i]))
    return np.array(rows)


@answers("02.9")
def one_number_for_all(points, values, epsilon):
    """This is one number, the root of the mean square of the errors. It is what the choice of ε is
    made by later; asked for are the N errors themselves.
    """
    return root_mean_square(values - unseen(points, values, epsilon))


@answers("02.9")
def plain_least_squares_left_out(points, values, epsilon):
    """A measurement is left out, but the rest is fitted with equal weights, by one plane. So ε
    has no effect, and there is nothing to choose by. Which weights belong to the place that is
    asked for?
    """
    rows = []
    for i in range(len(points)):
        p, v = np.delete(points, i, axis=0), np.delete(values, i)
        rows.append(values[i] - value_at(solved(p, v, np.ones(len(p))), points[i]))
    return np.array(rows)


@answers("02.9")
def squared_errors(points, values, epsilon):
    """These are the squares of the errors. (2.10) has the errors with their signs; square them when
    you take the mean.
    """
    return (values - unseen(points, values, epsilon)) ** 2


@answers("02.9")
def another_row_left_out(points, values, epsilon):
    """The wrong row is taken away: the point next in line is left out, and the one that is asked
    for has been seen. Are the index of the row that goes and the index of the value the same?
    """
    rows = []
    for i in range(len(points)):
        gone = (i + 1) % len(points)
        p, v = np.delete(points, gone, axis=0), np.delete(values, gone)
        rows.append(values[i] - value_at(local(p, v, points[i], epsilon), points[i]))
    return np.array(rows)
