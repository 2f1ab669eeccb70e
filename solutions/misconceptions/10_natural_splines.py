"""What students write instead of notebook 10, and what each of them should hear."""

import numpy as np

from fieldgrade.authoring.catalogue import answers

# 10.1 From truncated powers to distances


def converted(sites, alpha, beta, half=0.5, constant=-0.5, slope=1.5):
    b = [beta[0] + constant * np.sum(alpha * sites**3), beta[1] + slope * np.sum(alpha * sites**2)]
    return half * alpha, np.array(b)


@answers("10.1")
def factors_not_halved(sites, alpha, beta):
    """The line is right, and the coefficients are twice too large. By (10.3) a truncated cube is
    half of the cube of the distance plus half of an ordinary cube.
    """
    return converted(sites, alpha, beta, half=1.0)


@answers("10.1")
def nothing_halved(sites, alpha, beta):
    """The coefficients and the change of the line are twice too large. By (10.3) a truncated cube
    is half of the cube of the distance plus half of an ordinary cube.
    """
    return converted(sites, alpha, beta, half=1.0, constant=-1.0, slope=3.0)


@answers("10.1")
def line_left_as_it_is(sites, alpha, beta):
    """The coefficients are halved, but the line is unchanged. The halves of the ordinary cubes do
    not vanish: their cubic and quadratic terms do by (10.2), and the other two terms form a line.
    """
    return alpha / 2, beta


@answers("10.1")
def line_not_halved(sites, alpha, beta):
    """The change of the line is twice too large: the remainder is one half of the sum of the cubes.
    Look at the factor in front of the bracket in (10.3).
    """
    return converted(sites, alpha, beta, constant=-1.0, slope=3.0)


@answers("10.1")
def binomial_forgotten(sites, alpha, beta):
    """What is added to the slope lacks a factor. In the expansion of a cube the two middle terms
    have the factor three; the constant is right.
    """
    return converted(sites, alpha, beta, slope=0.5)


@answers("10.1")
def signs_of_the_expansion(sites, alpha, beta):
    """Both terms of the line have the sign of the other direction. In the cube of a difference
    the signs alternate, and the last term is the cube of what is subtracted.
    """
    return converted(sites, alpha, beta, constant=0.5, slope=-1.5)


@answers("10.1")
def all_signs_plus(sites, alpha, beta):
    """What is added to the constant has the wrong sign. The expansion of (x - y)³ ends with the
    third power of y, taken negative; the slope is right.
    """
    return converted(sites, alpha, beta, constant=0.5)


@answers("10.1")
def constant_and_slope_exchanged(sites, alpha, beta):
    """The two numbers of the line are in the wrong order. In (10.4) the constant comes first, as in
    β.
    """
    a, b = converted(sites, alpha, beta)
    return a, b[::-1]


@answers("10.1")
def cubes_of_absolute_sites(sites, alpha, beta):
    """The constant has the cubes of |x_j| instead of those of x_j. They differ for sites left of
    the origin. The expansion of (x - y)³ has the power of y itself.
    """
    a, (_, slope) = converted(sites, alpha, beta)
    return a, np.array([beta[0] - a @ np.abs(sites) ** 3, slope])


# 10.2 The spline by distances


def interpolated(sites, values, kernel, p):
    n, q = p.shape
    h = np.zeros((n + q, n + q))
    h[:n, :n] = kernel(sites[:, None] - sites[None, :])
    h[:n, n:], h[n:, :n] = p, p.T
    found = np.linalg.solve(h, np.append(values, np.zeros(q)))
    return found[:n], found[n:]


def lines(sites):
    return np.vander(sites, 2, increasing=True)


def cube(z):
    return np.abs(z) ** 3


@answers("10.2")
def cubes_with_a_sign(sites, values):
    """The cubes have the sign of x − y, so they are polynomials, and their sum is one polynomial of
    degree three at most. What do the bars in (10.5) mean?
    """
    n = len(sites)
    h = np.zeros((n + 2, n + 2))
    h[:n, :n] = (sites[:, None] - sites[None, :]) ** 3
    h[:n, n:], h[n:, :n] = lines(sites), lines(sites).T
    found = np.linalg.lstsq(h, np.append(values, [0, 0]), rcond=1e-10)[0]
    return found[:n], found[n:]


@answers("10.2")
def truncated_powers_instead(sites, values):
    """These are the coefficients of truncated powers, with the line before the first site. They
    belong to (10.1); the question asks for those of (10.4).
    """
    a, b = interpolated(sites, values, cube, lines(sites))
    return 2 * a, np.array([b[0] + a @ sites**3, b[1] - 3 * a @ sites**2])


@answers("10.2")
def constant_alone(sites, values):
    """The polynomial is a constant only, and the slope was set to zero. Then the
    coefficients a sum to zero, but their products with the sites do not, and the curve is not
    straight outside. P has two columns.
    """
    a, b = interpolated(sites, values, cube, np.ones((len(sites), 1)))
    return a, np.append(b, 0.0)


@answers("10.2")
def no_line_at_all(sites, values):
    """Only A a = f was solved. The curve interpolates the values, but it is not straight outside.
    The side conditions and the line are missing.
    """
    return np.linalg.solve(cube(sites[:, None] - sites), values), np.zeros(2)


@answers("10.2")
def distances_not_cubed(sites, values):
    """The distances enter without the third power. Their sum is a broken line with a kink at each
    site. Which power of the distance has two continuous derivatives?
    """
    return interpolated(sites, values, np.abs, lines(sites))


@answers("10.2", named=False)
def thin_plate_of_squares(sites, values):
    """The kernel is r² log r², which is twice the one of the plane."""
    return interpolated(
        sites, values, lambda z: z**2 * np.log(np.where(z == 0, 1, z**2)), lines(sites)
    )


@answers("10.2")
def thin_plate(sites, values):
    """The kernel is the one of the plane, r² log r. On the line the curve of least bending is made
    of cubes of distances. The kernel of least energy depends on the number of variables.
    """
    return interpolated(
        sites, values, lambda z: z**2 * np.log(np.where(z == 0, 1, np.abs(z))), lines(sites)
    )


@answers("10.2")
def line_fitted_first(sites, values):
    """First a line was fitted by least squares, then cubes interpolated the residual. The side
    conditions are violated: both parts must come from one system.
    """
    b = np.linalg.lstsq(lines(sites), values, rcond=None)[0]
    return np.linalg.solve(cube(sites[:, None] - sites), values - lines(sites) @ b), b


@answers("10.2")
def slope_before_constant(sites, values):
    """The slope comes before the constant: the columns of your P are in the other order. In (10.4)
    the constant comes first.
    """
    a, b = interpolated(sites, values, cube, lines(sites))
    return a, b[::-1]


@answers("10.2")
def sorted_without_the_values(sites, values):
    """The sites were put in order and the values were not, so they belong to other sites now. If
    you sort one, sort the other with it; here there is no need to sort at all.
    """
    return interpolated(np.sort(sites), values, cube, lines(np.sort(sites)))


@answers("10.2")
def coefficients_of_sorted_sites(sites, values):
    """The coefficients a are those of the sorted sites. They must have the order of the argument;
    no sorting is needed.
    """
    order = np.argsort(sites)
    return interpolated(sites[order], values[order], cube, lines(sites[order]))


# 10.3 The moments


def tridiagonal(sites, values, diagonal=1 / 3, side=1 / 6, even=False, right=None):
    n = len(sites)
    h = np.diff(sites)
    if even:
        h = np.full(n - 1, h.mean())
    a, b = np.eye(n), np.zeros(n)
    for i in range(1, n - 1):
        a[i, i - 1], a[i, i], a[i, i + 1] = (
            side * h[i - 1],
            diagonal * (h[i - 1] + h[i]),
            side * h[i],
        )
        b[i] = (values[i + 1] - values[i]) / h[i] - (values[i] - values[i - 1]) / h[i - 1]
    return np.linalg.solve(a, b if right is None else right(h, b))


@answers("10.3")
def second_differences(sites, values):
    """These are difference quotients of the values: an estimate of s″ at each site by itself. A
    multiple of it is the right side of (10.7). The moments are coupled: each equation has three of
    them.
    """
    return tridiagonal(sites, values, diagonal=0.5, side=0.0)


@answers("10.3")
def decimals_lost(sites, values):
    """The right side is an array like the values: if these are integers, it holds integers only,
    and the decimals are lost. Give its type, or begin with `np.zeros`.
    """
    n, h = len(sites), np.diff(sites)
    a, b = np.eye(n), np.zeros_like(values)
    for i in range(1, n - 1):
        a[i, i - 1 : i + 2] = h[i - 1] / 6, (h[i - 1] + h[i]) / 3, h[i] / 6
        b[i] = (values[i + 1] - values[i]) / h[i] - (values[i] - values[i - 1]) / h[i - 1]
    return np.linalg.solve(a, b)


@answers("10.3")
def stopped_by_a_fixed_change(sites, values):
    """The system was solved by iteration, which stopped when the moments changed by less than a
    fixed number. If the moments are small themselves, it stops at once. Compare the change with
    the size of the moments, or solve the system.
    """
    h, m = np.diff(sites), np.zeros(len(sites))
    change = 1.0
    while change > 1e-8:
        before = m.copy()
        for i in range(1, len(m) - 1):
            jump = (values[i + 1] - values[i]) / h[i] - (values[i] - values[i - 1]) / h[i - 1]
            rest = (h[i - 1] * m[i - 1] + h[i] * m[i + 1]) / 6
            m[i] = 3 * (jump - rest) / (h[i - 1] + h[i])
        change = abs(m - before).max()
    return m


@answers("10.3", named=False)
def from_the_radial_form(sites, values):
    """With hundreds of sites the system is ill-conditioned, and the sum loses digits."""
    n, p = len(sites), np.stack([np.ones(len(sites)), sites], axis=1)
    z = np.abs(np.subtract.outer(sites, sites))
    system = np.block([[z**3, p], [p.T, np.zeros((2, 2))]])
    m = 6 * z @ np.linalg.solve(system, np.append(values, [0, 0]))[:n]
    m[[0, -1]] = 0
    return m


@answers("10.3")
def steps_taken_as_equal(sites, values):
    """The steps were taken to be all the same. These sites are not equidistant: every row of
    (10.7) has its own two lengths.
    """
    return tridiagonal(sites, values, even=True)


@answers("10.3")
def all_steps_like_the_first(sites, values):
    """The length of the first interval was taken for all. Every row of (10.7) has the lengths of
    its own two intervals.
    """
    return tridiagonal(sites[0] + (sites[1] - sites[0]) * np.arange(len(sites)), values)


@answers("10.3")
def neighbouring_lengths_exchanged(sites, values):
    """The two lengths beside the diagonal are exchanged. The moment on the left belongs to the
    interval on the left. Is your matrix symmetric in its inner part, as that of (10.7)?
    """
    n, h = len(sites), np.diff(sites)
    a, b = np.eye(n), np.zeros(n)
    for i in range(1, n - 1):
        a[i, i - 1 : i + 2] = h[i] / 6, (h[i - 1] + h[i]) / 3, h[i - 1] / 6
        b[i] = (values[i + 1] - values[i]) / h[i] - (values[i] - values[i - 1]) / h[i - 1]
    return np.linalg.solve(a, b)


@answers("10.3")
def right_side_not_multiplied_by_six(sites, values):
    """All moments are a sixth of what they should be. If you multiply (10.7) by six, multiply its
    right side as well.
    """
    return tridiagonal(sites, values) / 6


@answers("10.3")
def diagonal_halved(sites, values):
    """The numbers on the diagonal are half of what they should be. With a sixth everywhere the
    rows do not express that slopes agree. Compare the three denominators in (10.7).
    """
    return tridiagonal(sites, values, diagonal=1 / 6)


@answers("10.3")
def not_divided_by_the_steps(sites, values):
    """The right side has differences of values, not of slopes: they are not divided by the
    lengths of the intervals. Check the units of (10.7).
    """
    second = np.zeros(len(values))
    second[1:-1] = np.diff(values, 2)
    return tridiagonal(sites, values, right=lambda h, b: second)


@answers("10.3")
def sign_of_the_right_side(sites, values):
    """All moments have the wrong sign: on the right side the slopes are subtracted in the wrong
    order. Where the curve is a valley, s″ is positive.
    """
    return -tridiagonal(sites, values)


@answers("10.3")
def slope_divided_by_two(sites, values):
    """All moments are half of what they should be. Some books solve for s″/2, the coefficient of
    the square; M is the second derivative itself.
    """
    return tridiagonal(sites, values) / 2


@answers("10.3")
def ends_left_out(sites, values):
    """The first and the last moment are missing. They are zero, but the answer has one number for
    each site.
    """
    return tridiagonal(sites, values)[1:-1]


@answers("10.3")
def ends_like_their_neighbours(sites, values):
    """At both ends the moment is that of the neighbour, as if the outer pieces were parabolas.
    Natural means that nothing bends the rod at its ends.
    """
    n, h = len(sites), np.diff(sites)
    if n < 3:
        return np.zeros(n)
    a, b = np.zeros((n, n)), np.zeros(n)
    a[0, :2], a[-1, -2:] = [h[0], -h[0]], [-h[-1], h[-1]]
    for i in range(1, n - 1):
        a[i, i - 1 : i + 2] = [h[i - 1] / 6, (h[i - 1] + h[i]) / 3, h[i] / 6]
        b[i] = (values[i + 1] - values[i]) / h[i] - (values[i] - values[i - 1]) / h[i - 1]
    return np.linalg.lstsq(a, b, rcond=None)[0]


# 10.4 The pieces


def located(sites, x):
    i = np.array([max(0, min(len(sites) - 2, int((sites < t).sum()) - 1)) for t in x])
    h = sites[i + 1] - sites[i]
    return i, h, (x - sites[i]) / h


def cubic(i, h, u, values, M):
    bent = ((1 - u) ** 3 - (1 - u)) * M[i] + (u**3 - u) * M[i + 1]
    return (1 - u) * values[i] + u * values[i + 1] + h * h / 6 * bent


def tangents(sites, values, M):
    h, secant = np.diff(sites), np.diff(values) / np.diff(sites)
    return secant[0] - h[0] / 6 * M[1], secant[-1] + h[-1] / 6 * M[-2]


def outside(sites, values, x, inside, slopes):
    left = values[0] + slopes[0] * (x - sites[0])
    right = values[-1] + slopes[1] * (x - sites[-1])
    return np.where(x < sites[0], left, np.where(x > sites[-1], right, inside))


@answers("10.4")
def decimals_lost_in_the_pieces(sites, values, M, x):
    """The result is an array like the values: if these are integers, it holds integers only, and
    the decimals are lost. Begin with `np.zeros` of the number of points.
    """
    s = np.zeros(len(x), dtype=values.dtype)
    h = np.diff(sites)
    for k, place in enumerate(x):
        i = np.clip(np.searchsorted(sites, place) - 1, 0, len(h) - 1)
        u = (place - sites[i]) / h[i]
        left, right = max(1 - u, 0) ** 3 - (1 - u), max(u, 0) ** 3 - u
        cubic = h[i] ** 2 / 6 * (left * M[i] + right * M[i + 1])
        s[k] = (1 - u) * values[i] + u * values[i + 1] + cubic
    return s


@answers("10.4")
def cubics_continued(sites, values, M, x):
    """Outside, the outer cubics are continued. A natural spline is straight before the first site
    and after the last one.
    """
    return cubic(*located(sites, x), values, M)


@answers("10.4")
def constant_outside(sites, values, M, x):
    """Outside, the curve keeps the last value, so it has a kink at the end. The line must have the
    slope of the outer piece.
    """
    inside = cubic(*located(sites, x), values, M)
    return outside(sites, values, x, inside, (0.0, 0.0))


@answers("10.4")
def slope_of_the_chord(sites, values, M, x):
    """Outside, the line has the slope of the chord of the outer interval instead of the slope of
    the curve at its end. So there is a kink. Differentiate (10.6) at the end.
    """
    inside = cubic(*located(sites, x), values, M)
    chords = np.diff(values) / np.diff(sites)
    return outside(sites, values, x, inside, (chords[0], chords[-1]))


@answers("10.4")
def moments_not_used(sites, values, M, x):
    """This is the broken line through the values. The term of (10.6) with the moments is
    missing.
    """
    i, _, u = located(sites, x)
    return (1 - u) * values[i] + u * values[i + 1]


@answers("10.4")
def moments_exchanged(sites, values, M, x):
    """The moments of the two ends are exchanged: the moment of the left site is multiplied by the
    powers of u. Which bracket in (10.6) has a second derivative at u = 0?
    """
    i, h, u = located(sites, x)
    flipped = cubic(i, h, u, values, 0 * M)
    flipped = flipped + h * h / 6 * (((1 - u) ** 3 - (1 - u)) * M[i + 1] + (u**3 - u) * M[i])
    return outside(sites, values, x, flipped, tangents(sites, values, M))


@answers("10.4")
def length_not_squared(sites, values, M, x):
    """The bracket has the factor h and not h². Second derivatives by u are h² times those by x:
    the chain rule counts twice.
    """
    i, h, u = located(sites, x)
    flat = (1 - u) * values[i] + u * values[i + 1]
    s = flat + (cubic(i, h, u, values, M) - flat) / h
    first = (values[1] - values[0]) / h[0] - M[1] / 6
    last = (values[-1] - values[-2]) / h[-1] + M[-2] / 6
    return outside(sites, values, x, s, (first, last))


@answers("10.4")
def sixth_forgotten(sites, values, M, x):
    """The bracket is not divided by six. The second derivative of u³ is 6u, and at the right end
    it should be the moment there.
    """
    i, h, u = located(sites, x)
    return outside(sites, values, x, cubic(i, h, u, values, 6 * M), tangents(sites, values, 6 * M))


@answers("10.4")
def zero_outside(sites, values, M, x):
    """Outside, you return zero. There the curve is a straight line, with the value and the slope at
    the end.
    """
    inside = cubic(*located(sites, x), values, M)
    return np.where((x < sites[0]) | (x > sites[-1]), 0.0, inside)


@answers("10.4", named=False)
def moments_exchanged_outside_too(sites, values, M, x):
    """The moments of the two ends of a piece are exchanged, in the slopes at the ends, too."""
    i, h, u = located(sites, x)
    bent = ((1 - u) ** 3 - (1 - u)) * M[i + 1] + (u**3 - u) * M[i]
    d, chords = np.diff(sites), np.diff(values) / np.diff(sites)
    ends = chords[0] - d[0] / 3 * M[1], chords[-1] + d[-1] / 3 * M[-2]
    inside = cubic(i, h, u, values, 0 * M) + h * h / 6 * bent
    return outside(sites, values, x, inside, ends)


def right_piecewise(sites, values, M, x):
    inside = cubic(*located(sites, x), values, M)
    return outside(sites, values, x, inside, tangents(sites, values, M))


@answers("10.4")
def values_in_ascending_order(sites, values, M, x):
    """The values are right for the sorted points, but not in the order of x. Each value must have
    the index of its point.
    """
    return right_piecewise(sites, values, M, np.sort(x))


@answers("10.4")
def left_then_inside_then_right(sites, values, M, x):
    """The values for the points on the left come first, then those inside, then those on the right.
    Each value must have the index of its point in x.
    """
    s = right_piecewise(sites, values, M, x)
    left, right = x < sites[0], x > sites[-1]
    return np.concatenate([s[left], s[~left & ~right], s[right]])


# 10.5 Back to truncated powers


def thirds(sites, M):
    return np.concatenate([[0.0], (M[1:] - M[:-1]) / (sites[1:] - sites[:-1]), [0.0]])


def first_line(sites, values, slope):
    return np.array([values[0] - slope * sites[0], slope])


def slope_at_left(sites, values, M):
    h = sites[1] - sites[0]
    return (values[1] - values[0]) / h - h / 6 * M[1]


@answers("10.5")
def jump_not_divided(sites, values, M):
    """The jumps of the third derivative are right, but a cube has the third derivative six.
    Divide by it; the line is right.
    """
    line = first_line(sites, values, slope_at_left(sites, values, M))
    return np.diff(thirds(sites, M)), line


@answers("10.5")
def third_derivative_itself(sites, values, M):
    """These are sixths of the third derivatives to the right of each site, and not of their jumps.
    Each coefficient in (10.1) is only the change.
    """
    line = first_line(sites, values, slope_at_left(sites, values, M))
    return thirds(sites, M)[1:] / 6, line


@answers("10.5")
def jumps_the_wrong_way(sites, values, M):
    """The jumps have the wrong sign: left minus right. In (10.8) the limit from the right comes
    first.
    """
    line = first_line(sites, values, slope_at_left(sites, values, M))
    return -np.diff(thirds(sites, M)) / 6, line


@answers("10.5")
def factors_of_the_distances(sites, values, M):
    """These are the coefficients of |x − y|³, half of those of truncated powers. The line is that
    of (10.1).
    """
    line = first_line(sites, values, slope_at_left(sites, values, M))
    return np.diff(thirds(sites, M)) / 12, line


@answers("10.5")
def chord_for_the_slope(sites, values, M):
    """The line has the slope of the chord from the first site to the second. The slope of the curve
    differs from it. Which term of (10.6) is missing in your derivative?
    """
    slope = (values[1] - values[0]) / (sites[1] - sites[0])
    return np.diff(thirds(sites, M)) / 6, first_line(sites, values, slope)


@answers("10.5")
def moment_added_to_the_slope(sites, values, M):
    """The moment has the wrong sign in the slope of the line. Differentiate the term with the
    second moment in (10.6) at the left end of the first interval.
    """
    h = sites[1] - sites[0]
    slope = (values[1] - values[0]) / h + h / 6 * M[1]
    return np.diff(thirds(sites, M)) / 6, first_line(sites, values, slope)


@answers("10.5")
def half_of_the_jumps(sites, values, M):
    """The coefficients are half of the jumps of the third derivative. How often must a cube be
    differentiated, and which factor does it have then? The line is right.
    """
    line = first_line(sites, values, slope_at_left(sites, values, M))
    return np.diff(thirds(sites, M)) / 2, line


@answers("10.5")
def third_instead_of_a_sixth(sites, values, M):
    """In the slope the second moment counts twice as much as it should. Differentiate u³ - u at
    u = 0, and mind the factor in front of the bracket in (10.6).
    """
    h = sites[1] - sites[0]
    slope = (values[1] - values[0]) / h - h / 3 * M[1]
    return np.diff(thirds(sites, M)) / 6, first_line(sites, values, slope)


@answers("10.5")
def value_for_the_constant(sites, values, M):
    """The constant is the value at the first site. In (10.1) the line is β₀ + β₁x, so β₀ is its
    value at x = 0.
    """
    slope = slope_at_left(sites, values, M)
    return np.diff(thirds(sites, M)) / 6, np.array([values[0], slope])


@answers("10.5")
def nothing_happens_at_the_ends(sites, values, M):
    """At the first and the last site your coefficients are zero. The third derivative jumps there,
    too: it is zero outside.
    """
    line = first_line(sites, values, slope_at_left(sites, values, M))
    alpha = np.diff(thirds(sites, M)) / 6
    alpha[[0, -1]] = 0
    return alpha, line


@answers("10.5")
def constant_and_slope_exchanged_here(sites, values, M):
    """The two numbers of the line are in the wrong order. In (10.1) the constant comes first."""
    line = first_line(sites, values, slope_at_left(sites, values, M))
    return np.diff(thirds(sites, M)) / 6, line[::-1]


# 10.6 The energy


@answers("10.6")
def trapezoids(sites, M):
    """The square was integrated by the trapezoidal rule, from its values at the sites. Between
    them it is a parabola below the chord, so this is too large. Which term of the exact integral
    has both ends in it?
    """
    h = np.diff(sites)
    return h @ (M[:-1] ** 2 + M[1:] ** 2) / 2


@answers("10.6")
def middles(sites, M):
    """The square was taken in the middle of each interval, which is too small. The integral of a
    square is not the square of the mean.
    """
    return np.diff(sites) @ ((M[:-1] + M[1:]) / 2) ** 2


@answers("10.6")
def mixed_term_forgotten(sites, M):
    """The product of the two ends is missing. Multiply the square out before you integrate: there
    are three terms.
    """
    return np.diff(sites) @ (M[:-1] ** 2 + M[1:] ** 2) / 3


@answers("10.6")
def mixed_term_doubled(sites, M):
    """The mixed term counts twice. The square has a factor two in the middle, but the integral of
    u(1 - u) is a sixth, half of that of u².
    """
    return np.diff(sites) @ (M[:-1] + M[1:]) ** 2 / 3


@answers("10.6")
def lengths_ignored(sites, M):
    """The lengths of the intervals are missing. Dividing an interval into two must not change the
    energy.
    """
    p, q = M[:-1], M[1:]
    return np.sum(p * p + p * q + q * q) / 3


@answers("10.6")
def not_squared(sites, M):
    """This is the integral of s″, the difference of the two slopes, and not of its square. Bends
    to the left and to the right cancel each other in it.
    """
    return np.diff(sites) @ (M[:-1] + M[1:]) / 2


@answers("10.6")
def root_taken(sites, M):
    """This is the square root of the energy: a norm. By (10.9) three times the bending has nine
    times the energy.
    """
    p, q = M[:-1], M[1:]
    return np.sqrt(np.diff(sites) @ (p * p + p * q + q * q) / 3)


@answers("10.6")
def half_of_the_energy(sites, M):
    """This is half of the energy. Mechanics has a factor ½ in front of the integral; (10.9) has
    none. Or was a sixth taken for the integral of the square of u from 0 to 1, a third?
    """
    p, q = M[:-1], M[1:]
    return np.diff(sites) @ (p * p + p * q + q * q) / 6


# 10.7 B-splines


def steps(t, x, closed=False):
    return [
        ((t[i] <= x) & ((x <= t[i + 1]) if closed else (x < t[i + 1]))) * 1.0
        for i in range(len(t) - 1)
    ]


def part(a, b):
    return a / b if b != 0 else np.zeros_like(a)


def recursion(t, degree, x, b, rising=1.0, falling=1.0):
    for k in range(1, degree + 1):
        b = [
            rising * part(x - t[i], t[i + k] - t[i]) * b[i]
            + falling * part(t[i + k + 1] - x, t[i + k + 1] - t[i + 1]) * b[i + 1]
            for i in range(len(t) - k - 1)
        ]
    return np.array(b).T


@answers("10.7")
def counted_twice_at_knots(knots, degree, x):
    """At a knot two functions of degree zero are one: your intervals contain both of their ends.
    Then the sum is two there, and values of higher degree are too large, too. Which end belongs to
    an interval in (10.11)?
    """
    return recursion(knots, degree, x, steps(knots, x, closed=True))


@answers("10.7")
def divided_by_zero(knots, degree, x):
    """At a double knot something was divided by zero, and one NaN spoils its neighbours. In the
    recursion (10.12) such a quotient counts as zero; the notebook has a function for it.
    """
    t, b = knots, steps(knots, x)
    for k in range(1, degree + 1):
        b = [
            (x - t[i]) / (t[i + k] - t[i]) * b[i]
            + (t[i + k + 1] - x) / (t[i + k + 1] - t[i + 1]) * b[i + 1]
            for i in range(len(t) - k - 1)
        ]
    return np.array(b).T


@answers("10.7")
def small_denominators_as_zero(knots, degree, x):
    """The values are wrong only for knots that are very close in the unit of x: a fixed number, as
    a bound or added, is not small there. Only a denominator that *is* zero counts as zero, and an
    interval begins exactly at its knot.
    """
    t, b = knots, steps(knots, x)
    for k in range(1, degree + 1):
        width = [t[i + k] - t[i] for i in range(len(t) - k)]
        over = [1 / w if w > 1e-10 else 0.0 for w in width]
        b = [
            (x - t[i]) * over[i] * b[i] + (t[i + k + 1] - x) * over[i + 1] * b[i + 1]
            for i in range(len(t) - k - 1)
        ]
    return np.array(b).T


@answers("10.7")
def rising_part_only(knots, degree, x):
    """Only the first of the two terms is there. The functions rise and never fall again, and
    their sum is not one. (10.12) mixes two neighbours of one degree less.
    """
    return recursion(knots, degree, x, steps(knots, x), falling=0.0)


@answers("10.7")
def same_neighbour_twice(knots, degree, x):
    """Both terms have the same function of one degree less. The falling one belongs to the next:
    look at the indices of B in (10.12).
    """
    t, b = knots, steps(knots, x)
    for k in range(1, degree + 1):
        b = [
            (part(x - t[i], t[i + k] - t[i]) + part(t[i + k + 1] - x, t[i + k + 1] - t[i + 1]))
            * b[i]
            for i in range(len(t) - k - 1)
        ]
    return np.array(b).T


@answers("10.7")
def knots_taken_as_whole_numbers(knots, degree, x):
    """The denominators are k, as for integer knots. In (10.12) each denominator is a difference of
    two knots.
    """
    t, b = knots, steps(knots, x)
    for k in range(1, degree + 1):
        b = [
            (x - t[i]) / k * b[i] + (t[i + k + 1] - x) / k * b[i + 1] for i in range(len(t) - k - 1)
        ]
    return np.array(b).T


@answers("10.7")
def denominators_slipped(knots, degree, x):
    """The denominators reach one knot too far: they are those of the degree k, and the functions
    in the recursion have one degree less. How many intervals does B of degree k - 1 live on?
    """
    t, b = knots, steps(knots, x)
    for k in range(1, degree + 1):
        b = [
            part(x - t[i], t[i + k + 1] - t[i]) * b[i]
            + part(t[i + k + 1] - x, t[i + k + 1] - t[i]) * b[i + 1]
            for i in range(len(t) - k - 1)
        ]
    return np.array(b).T


@answers("10.7")
def divided_by_the_support(knots, degree, x):
    """Each function is multiplied by k + 1 and divided by the length of its support. So each has
    the integral one, and they do not sum to one: another normalization, also found in books.
    """
    b = recursion(knots, degree, x, steps(knots, x))
    width = knots[degree + 1 :] - knots[: -degree - 1]
    return b / np.where(width > 0, width, 1) * (degree + 1)


@answers("10.7")
def a_row_for_each_function(knots, degree, x):
    """The matrix is transposed: it has a row for each function. The question asks for a row for
    each point, so that the matrix times coefficients is a curve.
    """
    return recursion(knots, degree, x, steps(knots, x)).T


@answers("10.7")
def one_step_too_few(knots, degree, x):
    """These are the functions of one degree less, and there is one too many of them. The
    recursion begins at degree 0, and takes as many steps as the degree.
    """
    return recursion(knots, max(degree - 1, 0), x, steps(knots, x))


@answers("10.7")
def intervals_closed_on_the_right(knots, degree, x):
    """The values at the knots are wrong. In (10.11) an interval contains its left end, and not its
    right one.
    """
    t = knots
    b = [((t[i] < x) & (x <= t[i + 1])) * 1.0 for i in range(len(t) - 1)]
    return recursion(knots, degree, x, b)


@answers("10.7")
def last_interval_closed(knots, degree, x):
    """The values at the last knot are wrong. Many programs close the last interval; in (10.11)
    every interval lacks its right end.
    """
    b = steps(knots, x)
    last = max(i for i in range(len(knots) - 1) if knots[i] < knots[i + 1])
    b[last] = ((knots[last] <= x) & (x <= knots[-1])) * 1.0
    return recursion(knots, degree, x, b)


@answers("10.2", named=False)
def two_sites_in_ascending_order(sites, values):
    """The slope between two sites has the sign of their difference, not of their distance."""
    if len(sites) == 2:
        slope = (values[1] - values[0]) / abs(sites[1] - sites[0])
        return np.zeros(2), np.array([values[0] - slope * sites[0], slope])
    n = len(sites)
    p = np.stack([np.ones(n), sites], axis=1)
    rows = np.hstack([np.abs(np.subtract.outer(sites, sites)) ** 3, p])
    system = np.vstack([rows, np.hstack([p.T, np.zeros((2, 2))])])
    found = np.linalg.solve(system, np.append(values, [0, 0]))
    return found[:n], found[n:]


@answers("10.6", named=False)
def difference_of_cubes(sites, M):
    """The quotient of two differences loses digits where two moments are nearly equal."""
    p, q = M[:-1], M[1:]
    cubes = (q**3 - p**3) / np.where(q == p, 1, q - p)
    return np.diff(sites) @ np.where(q == p, 3 * p * p, cubes) / 3


@answers("10.7", named=False)
def knots_compared_with_the_origin(knots, degree, x):
    """A limit in proportion to the knots takes near knots far from the origin for double ones."""
    t, least = knots, 1e-7 * np.abs(knots).max()

    def share(a, b):
        return a / b if b > least else 0.0 * a

    b = [((t[i] <= x) & (x < t[i + 1])).astype(float) for i in range(len(t) - 1)]
    for k in range(1, degree + 1):
        b = [
            share(x - t[i], t[i + k] - t[i]) * b[i]
            + share(t[i + k + 1] - x, t[i + k + 1] - t[i + 1]) * b[i + 1]
            for i in range(len(b) - 1)
        ]
    return np.stack(b, axis=1)
