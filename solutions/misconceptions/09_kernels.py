"""What students write instead of notebook 09, and what each of them should hear."""

import numpy as np

from fieldgrade.authoring.catalogue import answers


def phi(r, k):
    sign = 1.0 if k % 4 in (2, 3) else -1.0
    return sign * r**k * (1.0 if k % 2 else np.log(np.where(r > 0, r, 1.0)))


def gaps(x, points):
    return np.sqrt(((x[:, None, :] - points[None, :, :]) ** 2).sum(axis=2))


def basis(points, pairs):
    x, y = points[:, 0], points[:, 1]
    return np.array([x**a * y**b for a, b in pairs]).reshape(len(pairs), len(points)).T


def pairs_up_to(degree):
    return [(t - b, b) for t in range(degree + 1) for b in range(t + 1)]


def full(points, degree):
    return basis(points, pairs_up_to(degree))


def bordered(a, p):
    q = p.shape[1]
    return np.vstack([np.hstack([a, p]), np.hstack([p.T, np.zeros((q, q))])])


# 09.1 The monomials


@answers("09.1")
def degree_of_each_variable(points, degree):
    """Each exponent alone runs up to the degree, so that products such as x²y² are among the
    columns. The degree of a monomial is the sum of its exponents. Compare the number Q in (9.4).
    """
    return basis(points, [(a, b) for a in range(degree + 1) for b in range(degree + 1)])


@answers("09.1")
def constant_forgotten(points, degree):
    """The column of ones is missing. The constant is the polynomial of degree zero. Which exponents
    does it have in (9.4)?
    """
    return basis(points, [pair for pair in pairs_up_to(degree) if sum(pair) > 0])


@answers("09.1")
def highest_degree_only(points, degree):
    """Only the monomials whose exponents sum to exactly the degree are present. (9.4) has those of
    lower degree as well.
    """
    return basis(points, [pair for pair in pairs_up_to(degree) if sum(pair) == degree])


@answers("09.1")
def degree_below(points, degree):
    """These are the monomials of degree less than n. The argument is the degree itself, and is
    reached; "less than" belongs to the order m in (9.5), which is another number.
    """
    return full(points, degree - 1)


@answers("09.1")
def no_mixed_products(points, degree):
    """The matrix has the powers of each coordinate, but not their products, such as x₁x₂. Without
    them most rotated quadratic polynomials are not in the space.
    """
    return basis(points, [pair for pair in pairs_up_to(degree) if min(pair) == 0])


@answers("09.1")
def no_mixed_products_but_a_constant(points, degree):
    """The matrix has the powers of each coordinate, but not their products, such as x₁x₂. And for
    the degree −1 it has a column of ones, where it must have no column at all.
    """
    powers = range(1, degree + 1)
    return basis(points, [(0, 0), *((k, 0) for k in powers), *((0, k) for k in powers)])


@answers("09.1")
def a_row_for_each_polynomial(points, degree):
    """This is the transpose of the required matrix: it has a row for each monomial. In (9.3) P has
    a row for each point.
    """
    return full(points, degree).T


@answers("09.1")
def divided_by_factorials(points, degree):
    """The monomials are divided by factorials, as in a Taylor series. That is a basis as good,
    but not the one of (9.4): at the point (1, 1) all of its members are one.
    """
    scale = [
        np.prod([max(1, i) for i in range(a + 1)]) * np.prod([max(1, i) for i in range(b + 1)])
        for a, b in pairs_up_to(degree)
    ]
    return full(points, degree) / np.array(scale, dtype=float)


# 09.2 The least eigenvalue


def complement(p):
    u, s, _ = np.linalg.svd(p)
    rank = int((s > 1e-9 * s.max(initial=0.0)).sum())
    return u[:, :rank], u[:, rank:]


@answers("09.2")
def conditions_ignored(a, p):
    """This is the least eigenvalue of A itself. Vectors that do not satisfy the side conditions
    do not count in (9.6), and for them the form may well be negative. Where does your answer use
    P?
    """
    return np.linalg.eigvalsh(a)[0]


@answers("09.2")
def eigenvalue_of_the_whole_system(a, p):
    """This is the smallest eigenvalue of the matrix of (9.3). It has a negative eigenvalue for each
    independent condition, for any kernel. (9.6) is about A on a subspace.
    """
    return np.linalg.eigvalsh(bordered(a, p))[0]


@answers("09.2")
def columns_counted(a, p):
    """Where the columns of P depend on each other, too many directions were taken away. The
    subspace has the dimension N less the rank of P, which may be smaller than the number of its
    columns.
    """
    z = np.linalg.qr(p, mode="complete")[0][:, p.shape[1] :]
    return np.linalg.eigvalsh(z.T @ a @ z)[0]


@answers("09.2")
def on_the_wrong_subspace(a, p):
    """The form was taken on the columns of P instead of on the vectors orthogonal to them. Which λ
    satisfy Pᵀλ = 0?
    """
    z = complement(p)[0]
    return np.linalg.eigvalsh(z.T @ a @ z)[0]


@answers("09.2")
def basis_not_orthonormal(a, p):
    """The columns of your Z span the right subspace, but they are not orthonormal. Then a vector
    t of length one does not make a λ of length one, and the sign of the result is right while its
    size is not.
    """
    rank = complement(p)[0].shape[1]
    z = (np.eye(len(a)) - p @ np.linalg.pinv(p, rcond=1e-9))[:, rank:]
    return np.linalg.eigvalsh(z.T @ a @ z)[0]


@answers("09.2")
def largest_of_them(a, p):
    """This is the largest eigenvalue. A form is positive if the smallest one is. In which order
    does `eigvalsh` return them?
    """
    z = complement(p)[1]
    return np.linalg.eigvalsh(z.T @ a @ z)[-1]


@answers("09.2")
def smallest_in_size(a, p):
    """This is the eigenvalue with the smallest absolute value. The form is indefinite if one
    eigenvalue is negative, so the sign matters.
    """
    z = complement(p)[1]
    spectrum = np.linalg.eigvalsh(z.T @ a @ z)
    return spectrum[np.argmin(np.abs(spectrum))]


@answers("09.2")
def zeros_of_the_projection(a, p):
    """The form was projected onto the subspace and kept its size N × N. Such a matrix has a zero
    eigenvalue for each condition, and the least of all is zero where the form is positive. Those
    zeros do not belong to vectors of the subspace.
    """
    z = complement(p)[1]
    k = z @ z.T
    return np.linalg.eigvalsh(k @ a @ k)[0]


@answers("09.2")
def square_for_the_projection(a, p):
    """I − P Pᵀ is a projection only if the columns of P are orthonormal, and these are not. The
    form belongs on the null space of Pᵀ: take an orthonormal basis Z of it, and no N × N matrix.
    """
    k = np.eye(len(a)) - p @ p.T
    return np.linalg.eigvalsh(k @ a @ k)[0]


def projection(p):
    return np.eye(len(p)) - p @ np.linalg.pinv(p, rcond=1e-10) if p.size else np.eye(len(p))


@answers("09.2")
def projection_by_columns_of_q(a, p):
    """I − Q Qᵀ takes a direction away for each column of P, also where columns depend on each
    other. And this form kept its size N × N, so it has zeros that belong to no vector of the
    subspace.
    """
    q = np.linalg.qr(p)[0]
    k = np.eye(len(a)) - q @ q.T
    return np.linalg.eigvalsh(k @ a @ k)[0]


@answers("09.2")
def first_columns_of_q(a, p):
    """The first columns of Q span the columns of P only if the first columns of P are independent.
    Here one of them is zero, or nearly equal to the one before. `qr` of NumPy does not exchange
    columns; which factorization does not depend on their order?
    """
    return on_the_complement_by_qr(a, p, lambda pivots: np.sort(pivots)[::-1])


@answers("09.2")
def columns_of_q_with_a_small_pivot(a, p):
    """A column of Q with a small entry of R beside it need not be orthogonal to P: later columns of
    P may have a component along it. `qr` of NumPy does not exchange columns; which factorization
    does not depend on their order?
    """
    return on_the_complement_by_qr(a, p, lambda pivots: pivots)


def on_the_complement_by_qr(a, p, order):
    q, r = np.linalg.qr(p, mode="complete")
    pivots = np.zeros(len(a))
    pivots[: min(r.shape)] = np.abs(np.diag(r))
    z = q[:, order(pivots) <= 1e-10 * pivots.max()]
    return np.linalg.eigvalsh(z.T @ a @ z)[0]


@answers("09.2")
def lowest_eigenvalues_left_out(a, p):
    """As many of the lowest eigenvalues were left out as there are conditions. The zeros of the
    projected form come first only if the form is positive. Where it is not, the number you are
    looking for was among those left out.
    """
    k = projection(p)
    return np.linalg.eigvalsh(k @ a @ k)[round(len(a) - np.trace(k))]


@answers("09.2")
def zeros_left_out(a, p):
    """Eigenvalues of the projected form that are zero were left out. But zero may also be the least
    value of the form on the subspace. Compute with a form that has no additional eigenvalues.
    """
    k = projection(p)
    spectrum = np.linalg.eigvalsh(k @ a @ k)
    return spectrum[np.abs(spectrum) > 1e-9 * np.abs(spectrum).max()].min()


@answers("09.2")
def projected_from_one_side(a, p):
    """The projection stands on one side of A only. The product is not symmetric, and `eigvalsh`
    reads one of its triangles, so these are eigenvalues of another matrix. Where are the two
    factors Z in (9.6)?
    """
    return np.linalg.eigvalsh(projection(p) @ a)[0]


@answers("09.2", named=False)
def pseudo_inverse_with_its_default_tolerance(a, p):
    """Conditions that count as dependent by the text are conditions for `pinv` still."""
    k = np.eye(len(a)) - p @ np.linalg.pinv(p)
    return np.linalg.eigvalsh(k @ a @ k)[0]


def on_the_complement(a, p, rank):
    z = np.linalg.svd(p)[0][:, rank:]
    return np.linalg.eigvalsh(z.T @ a @ z)[0]


@answers("09.2", named=False)
def coarse_relative_tolerance(a, p):
    """Conditions whose singular value is small, but not zero, are ignored."""
    s = np.linalg.svd(p, compute_uv=False)
    return on_the_complement(a, p, int((s > 1e-2 * s.max(initial=0.0)).sum()))


@answers("09.2", named=False)
def absolute_tolerance(a, p):
    """Conditions with small numbers are ignored because the tolerance is absolute."""
    return on_the_complement(a, p, int((np.linalg.svd(p, compute_uv=False) > 1e-6).sum()))


@answers("09.2", named=False)
def small_absolute_tolerance(a, p):
    """The tolerance of the text is taken as absolute: it must be relative."""
    return on_the_complement(a, p, int((np.linalg.svd(p, compute_uv=False) > 1e-10).sum()))


@answers("09.2")
def by_eigenvectors_of_the_square(a, p):
    """A condition whose singular value is 3·10⁻¹⁰ of the largest one was ignored, but only those
    below 10⁻¹⁰ count as zero. Either the tolerance is too large, or it applies to eigenvalues of
    P Pᵀ: these are the squares of the singular values, and become rounding errors much earlier.
    """
    values, vectors = np.linalg.eigh(p @ p.T)
    z = vectors[:, values <= 1e-11 * values.max(initial=0.0)]
    return np.linalg.eigvalsh(z.T @ a @ z)[0]


# 09.3 Polynomials that vanish


def rank_of(p, tolerance=1e-9):
    s = np.linalg.svd(p, compute_uv=False)
    return int((s > tolerance * s.max(initial=0.0)).sum())


def own_box(points):
    away = points - points.mean(axis=0)
    return away / max(np.abs(away).max(), 1e-300)


def space(degree):
    return (degree + 1) * (degree + 2) // 2


@answers("09.3")
def rank_itself(points, degree):
    """This is the rank of P, the number of independent conditions. The question asks for the
    dimension of the space of polynomials that satisfy all of them. The two numbers have a simple
    sum.
    """
    return rank_of(full(own_box(points), degree), 1e-10)


@answers("09.3", named=False)
def size_along_the_first_axis(points, degree):
    """The size is zero for points on a vertical line, however small or large they are."""
    away = points - points.mean(axis=0)
    size = np.ptp(away[:, 0])
    p = full(away / (size if size > 0 else 1), degree)
    return p.shape[1] - rank_of(p, 1e-10)


@answers("09.3", named=False)
def distance_of_the_first_two(points, degree):
    """The first two points may be the same: their distance is no measure of the size."""
    away = points - points[0]
    p = full(away / (np.hypot(*away[1]) or 1), degree)
    return p.shape[1] - rank_of(p, 1e-10)


@answers("09.3")
def conditions_lacking(points, degree):
    """Every point was counted as a condition of its own. Points on a line or a conic, and
    repeated ones, make conditions that depend on each other; count the independent ones. In
    rounded numbers a singular value that should be zero is merely tiny.
    """
    return max(0, space(degree) - len(points))


@answers("09.3")
def relations_between_the_points(points, degree):
    """The rank was subtracted from the number of points. This counts how many λ satisfy the side
    conditions; polynomials have as many coefficients as P has columns.
    """
    return len(points) - rank_of(full(own_box(points), degree), 1e-10)


@answers("09.3")
def neither_shifted_nor_scaled(points, degree):
    """In a small box, and far from the origin, too many polynomials seem to vanish. There the
    monomials are tiny, or nearly multiples of each other. Shift and scale the points first.
    """
    return space(degree) - rank_of(full(points, degree), 1e-10)


@answers("09.3")
def nearly_vanishing_counted(points, degree):
    """Polynomials that nearly vanish at the points are counted, too. Only singular values below
    10⁻¹⁰ times the largest one count as zero. The eigenvalues of PᵀP are their squares.
    """
    return space(degree) - rank_of(full(own_box(points), degree), 1e-5)


@answers("09.3")
def tolerance_too_small(points, degree):
    """A singular value of less than 10⁻¹¹ times the largest one did not count as zero. All those of
    at most 10⁻¹⁰ times the largest one count as zero.
    """
    return space(degree) - rank_of(full(own_box(points), degree), 1e-12)


@answers("09.3")
def small_singular_values_counted(points, degree):
    """With fewer points than monomials your number is too small. P has only N singular values then,
    and each column beyond N adds one polynomial that vanishes.
    """
    p = full(own_box(points), degree)
    return min(p.shape) - rank_of(p, 1e-10)


def rank_above(points, degree, tolerance):
    return int((np.linalg.svd(full(points, degree), compute_uv=False) > tolerance).sum())


@answers("09.3", named=False)
def fixed_tolerance(points, degree):
    """An absolute tolerance: what is small depends on the unit of length."""
    return space(degree) - rank_above(points, degree, 1e-3)


@answers("09.3", named=False)
def smaller_fixed_tolerance(points, degree):
    """An absolute tolerance: what is small depends on the unit of length."""
    return space(degree) - rank_above(points, degree, 1e-6)


@answers("09.3", named=False)
def tiny_fixed_tolerance(points, degree):
    """An absolute tolerance: what is small depends on the unit of length."""
    return space(degree) - rank_above(points, degree, 1e-9)


@answers("09.3", named=False)
def small_eigenvalues_of_the_normal_matrix(points, degree):
    """An absolute tolerance for squares of singular values, without shifting and scaling."""
    p = full(points, degree)
    return int((np.linalg.eigvalsh(p.T @ p) < 1e-12).sum())


@answers("09.3", named=False)
def relative_but_coarse_and_not_scaled(points, degree):
    """The tolerance is relative, but coarse, and the points are neither shifted nor scaled."""
    return space(degree) - rank_of(full(points, degree), 1e-5)


@answers("09.3")
def lines_only(points, degree):
    """This tests whether the points lie on a line, for any degree. A quadratic polynomial can also
    vanish on an ellipse. Use the monomials of the given degree.
    """
    return 3 - rank_of(full(own_box(points), 1), 1e-10)


@answers("09.3")
def yes_or_no(points, degree):
    """This says whether there is one, as zero or one. There may be several independent ones; as
    many as the rank falls short of the number of monomials.
    """
    return int(rank_of(full(own_box(points), degree), 1e-10) < space(degree))


@answers("09.3", named=False)
def each_axis_by_its_own_size(points, degree):
    """Points on a line parallel to an axis have the size zero along the other axis."""
    z = points - points[0]
    p = full(z / np.abs(z).max(axis=0), degree)
    return p.shape[1] - np.linalg.matrix_rank(p, rtol=1e-10)


# 09.4 The field


def solved(points, values, k, degree, x, ridge=0.0, corner=0.0):
    n = len(points)
    h = bordered(phi(gaps(points, points), k), full(points, degree))
    h[:n, :n] += ridge * np.eye(n)
    h[n:, n:] += corner * np.eye(len(h) - n)
    unknown = np.linalg.solve(h, np.append(values, np.zeros(len(h) - n)))
    return phi(gaps(x, points), k) @ unknown[:n], full(x, degree) @ unknown[n:]


@answers("09.4")
def kernels_alone(points, values, k, degree, x):
    """Only A λ = v was solved, without a polynomial and without side conditions. For these kernels
    the matrix may be singular at distinct points, as in the first picture. Which blocks of (9.3)
    are missing?
    """
    return phi(gaps(x, points), k) @ np.linalg.solve(phi(gaps(points, points), k), values)


@answers("09.4")
def small_singular_values_cut(points, values, k, degree, x):
    """The system was solved by a pseudo-inverse or by least squares, with the default tolerance.
    For coordinates of some hundreds it cuts small singular values. Then the side conditions do not
    hold. The matrix is regular: `np.linalg.solve` solves the system.
    """
    p, n = full(points, degree), len(points)
    matrix = bordered(phi(gaps(points, points), k), p)
    w = np.linalg.pinv(matrix) @ np.r_[values, 0 * p[0]]
    return phi(gaps(x, points), k) @ w[:n] + full(x, degree) @ w[n:]


@answers("09.4", named=False)
def tiny_coefficients_dropped(points, values, k, degree, x):
    """The coefficients of small values are small, and no rounding errors."""
    p, n = full(points, degree), len(points)
    w = np.linalg.solve(bordered(phi(gaps(points, points), k), p), np.r_[values, 0 * p[0]])
    w = np.where(np.abs(w) < 1e-10, 0, w)
    return phi(gaps(x, points), k) @ w[:n] + full(x, degree) @ w[n:]


@answers("09.4")
def polynomial_not_evaluated(points, values, k, degree, x):
    """The coefficients are those of (9.3), but only the kernels are summed at x. The polynomial,
    the second sum in (9.2), is missing.
    """
    return solved(points, values, k, degree, x)[0]


@answers("09.4")
def one_degree_less(points, values, k, degree, x):
    """The polynomial has one degree less than the argument. The argument is the degree n, not the
    order m; the smallest n that a kernel needs is m − 1.
    """
    return sum(solved(points, values, k, degree - 1, x))


@answers("09.4")
def always_linear(points, values, k, degree, x):
    """The polynomial is linear for every degree. In notebook 03 this was right; here P has the
    monomials up to the degree n.
    """
    return sum(solved(points, values, k, 1, x))


@answers("09.4")
def conditions_dropped(points, values, k, degree, x):
    """The field interpolates the values, but the side conditions are not used. There are more
    unknowns than equations, and the shortest of many solutions was taken, which depends on the unit
    of length.
    """
    a = np.hstack([phi(gaps(points, points), k), full(points, degree)])
    unknown = np.linalg.lstsq(a, values, rcond=None)[0]
    return np.hstack([phi(gaps(x, points), k), full(x, degree)]) @ unknown


@answers("09.4")
def polynomial_fitted_first(points, values, k, degree, x):
    """First a polynomial was fitted by least squares, then kernels interpolated the residual. Their
    coefficients do not satisfy the side conditions. Both parts must come from one system.
    """
    p = full(points, degree)
    c = np.linalg.lstsq(p, values, rcond=None)[0]
    lam = np.linalg.solve(phi(gaps(points, points), k), values - p @ c)
    return phi(gaps(x, points), k) @ lam + full(x, degree) @ c


@answers("09.4")
def made_definite_by_a_ridge(points, values, k, degree, x):
    """A multiple of the identity was added to A. This smooths the data instead of interpolating
    them. With the right order it is not needed.
    """
    return sum(solved(points, values, k, degree, x, ridge=1e-2))


@answers("09.4")
def identity_in_the_corner(points, values, k, degree, x):
    """The last block of the matrix is not zero. Then the sums of the side conditions need not
    vanish, and polynomials are not reproduced. What multiplies c in the second row of (9.3)?
    """
    return sum(solved(points, values, k, degree, x, corner=1.0))


# 09.5 Wendland's functions


def compact(r, power, factor, s):
    inside = np.clip(1 - r, 0, None)
    return inside**power * (factor * r + 1 if s else 1)


@answers("09.5")
def not_rounded_down(r, d, s):
    """Half of D was not rounded down. For an even D the exponent is right by chance, for an odd one
    there is a half too much. What do the brackets in (9.8) mean?
    """
    ell = d / 2 + s + 1
    return compact(r, ell + s, ell + 1, s)


@answers("09.5")
def never_cut_off(r, d, s):
    """Beyond the distance 1 your function is not zero. A compact support makes the matrix sparse.
    What does the plus sign in (9.8) mean?
    """
    ell = d // 2 + s + 1
    return (1 - r) ** (ell + s) * ((ell + 1) * r + 1 if s else 1)


@answers("09.5")
def cut_off_by_size(r, d, s):
    """The absolute value of 1 - r was taken, not its positive part: the function is not zero
    beyond 1. Look at what happens there for the distance 2.
    """
    ell = d // 2 + s + 1
    return np.abs(1 - r) ** (ell + s) * ((ell + 1) * r + 1 if s else 1)


@answers("09.5")
def smoothness_not_in_ell(r, d, s):
    """For s = 1, the exponent and the factor of r are one too small. Either ℓ was made without s,
    or ℓ stands where (9.8) has ℓ + 1.
    """
    ell = d // 2 + 1
    return compact(r, ell + s, ell + 1, s)


@answers("09.5")
def dimension_not_halved(r, d, s):
    """The exponent contains the number of variables instead of half of it. The function is positive
    definite, but narrower than (9.8).
    """
    ell = d + s + 1
    return compact(r, ell + s, ell + 1, s)


@answers("09.5")
def exponent_one_too_small(r, d, s):
    """The exponent is one too small. A function so wide is not positive definite in this number
    of variables any more: its limit is sharp. Count the terms of ℓ in (9.8).
    """
    ell = d // 2 + s
    return compact(r, ell + s, ell + 1, s)


@answers("09.5")
def half_rounded_up(r, d, s):
    """Half of D was rounded up. For an even D the exponent is right, for an odd one it is too large
    by one. What do the brackets in (9.8) mean?
    """
    ell = (d + 1) // 2 + s + 1
    return compact(r, ell + s, ell + 1, s)


@answers("09.5")
def smoothness_missing_in_the_power(r, d, s):
    """For s = 1 the exponent of 1 − r is ℓ. In (9.8) it is larger by one."""
    ell = d // 2 + s + 1
    return compact(r, ell, ell + 1, s)


@answers("09.5")
def factor_forgotten(r, d, s):
    """For s = 1 the factor in the large brackets is missing. A power of 1 − r alone has a kink at
    zero. What is the slope at zero, with and without the factor?
    """
    ell = d // 2 + s + 1
    return compact(r, ell + s, 0.0, s)


@answers("09.5")
def ell_in_the_factor(r, d, s):
    """In the factor r is multiplied by ℓ and should be by one more. With ℓ the slope at zero is not
    zero, and the function has a corner there.
    """
    ell = d // 2 + s + 1
    return compact(r, ell + s, ell, s)


# 09.6 Two points change places


def direction(v):
    return np.arctan2(v[1], v[0])


def turned_by(points):
    middle = (points[0] + points[1]) / 2
    return direction(points[2] - middle) - direction(points[0] - middle)


@answers("09.6")
def in_radians(points):
    """This is the angle by which the line has turned, in radians. In (9.10) the time 1 belongs to
    half a turn: how much is that in radians?
    """
    return turned_by(points) % np.pi


@answers("09.6")
def part_of_a_whole_turn(points):
    """The angle was divided by a full revolution. In (9.10) the points rotate by π between the
    times 0 and 1.
    """
    return turned_by(points) % np.pi / (2 * np.pi)


@answers("09.6")
def clockwise(points):
    """This is the time for a clockwise turn, and (9.10) turns counter-clockwise. Which angle is
    subtracted from which? If you use `arctan2`, its first argument is the second coordinate.
    """
    return -turned_by(points) / np.pi % 1


@answers("09.6")
def not_the_same_line(points):
    """Some of your times are not between 0 and 1. A line that is rotated by π is the same line, so
    the time is determined up to whole numbers.
    """
    return np.angle(np.exp(1j * turned_by(points))) / np.pi


@answers("09.6")
def angle_without_a_sign(points):
    """The angle has lost its sign, by `arccos` or by an absolute value. A scalar product gives the
    angle between two directions, not which way to turn from the one to the other. If the third
    point is on the right of the first arm, your time is that of a clockwise turn.
    """
    return np.abs(np.angle(np.exp(1j * turned_by(points)))) / np.pi


@answers("09.6")
def seen_from_the_origin(points):
    """The directions were taken from the origin of the coordinates. The two points turn around
    their midpoint m, which may be anywhere.
    """
    return (direction(points[2]) - direction(points[0])) / np.pi % 1


@answers("09.6")
def seen_from_the_first_point(points):
    """The direction of the third point was taken from the first point. The line through both
    moving points turns around m; the first point itself moves.
    """
    way = direction(points[2] - points[0]) - direction(points[1] - points[0])
    return way / np.pi % 1


@answers("09.6")
def as_near_as_each_other(points):
    """At this time the third point is equally far from both: the triangle is isosceles, and as
    far from flat as it can be. It is flat when the line through the moving points contains the
    third.
    """
    return (turned_by(points) / np.pi + 0.5) % 1


@answers("09.6")
def half_time(points):
    """You return one half for all inputs. The time depends on the direction of the third point."""
    return 0.5


# 09.7 Values and slopes


def blocks(x, of_slopes=-1.0, slope_of_values=1.0, second=-6.0, first=3.0):
    z = x[:, None] - x[None, :]
    return np.block(
        [
            [abs(z) ** 3, of_slopes * first * z * abs(z)],
            [slope_of_values * first * z * abs(z), second * abs(z)],
        ]
    )


def sides(x):
    n = len(x)
    return np.stack([np.append(np.ones(n), np.zeros(n)), np.append(x, np.ones(n))], axis=1)


@answers("09.7")
def derivative_by_the_wrong_argument(x):
    """The basis functions of the slopes are derivatives with respect to x instead of y: the second
    block column has the wrong sign, and the matrix is not symmetric.
    """
    return bordered(blocks(x, of_slopes=1.0, second=6.0), sides(x))


@answers("09.7")
def sign_of_the_second_derivative(x):
    """The block of slopes by slopes has the wrong sign. It is differentiated twice, once by x and
    once by y, and the second one changes the sign. With the plus the form is not positive.
    """
    return bordered(blocks(x, second=6.0), sides(x))


@answers("09.7")
def both_signs_the_same(x):
    """The two blocks beside the diagonal are equal. φ′ is an odd function, so a symmetric matrix
    needs opposite signs there. Compare the second column and the second row of (9.12).
    """
    return bordered(blocks(x, slope_of_values=-1.0), sides(x))


@answers("09.7")
def squares_without_sign(x):
    """φ′ was taken as 3z². The derivative of |z|³ has the sign of z, which is the reason for the
    factor |z| in 3z|z|.
    """
    z = x[:, None] - x[None, :]
    a = np.block([[abs(z) ** 3, -3 * z**2], [3 * z**2, -6 * abs(z)]])
    return bordered(a, sides(x))


@answers("09.7")
def cubes_without_size(x):
    """The first block is z³ and not its absolute value. A kernel is a function of the distance, the
    same to the left and to the right; z³ is a polynomial, and its matrix has the rank four at most.
    """
    a = blocks(x)
    n = len(x)
    a[:n, :n] = (x[:, None] - x[None, :]) ** 3
    return bordered(a, sides(x))


@answers("09.7")
def slopes_have_no_polynomial(x):
    """The rows of the slopes have zeros under the polynomial. But x has a slope, which is one;
    without it a line through the data would be bent to have the slopes. Look at the second row of
    (9.12).
    """
    n = len(x)
    p = sides(x)
    p[n:] = 0
    return bordered(blocks(x), p)


@answers("09.7")
def slopes_treated_as_values(x):
    """The polynomial has the same rows for slopes as for values. The slope of 1 is zero and that
    of x is one; the entries are what the measurement says of the polynomial.
    """
    p = sides(x)
    n = len(x)
    p[n:] = p[:n]
    return bordered(blocks(x), p)


@answers("09.7")
def a_polynomial_for_each(x):
    """There are four side conditions, two for the values and two for the slopes. There is only one
    polynomial c₀ + c₁x, so there are two conditions, each with values and slopes.
    """
    n = len(x)
    one = np.stack([np.ones(n), x], axis=1)
    zero = np.zeros((n, 2))
    return bordered(blocks(x), np.block([[one, zero], [zero, one]]))


@answers("09.7")
def point_by_point(x):
    """Value and slope of each point are adjacent. This is the same system in another order; (9.12)
    has all values first, then all slopes.
    """
    n = len(x)
    order = [*np.arange(2 * n).reshape(2, n).T.ravel(), 2 * n, 2 * n + 1]
    return bordered(blocks(x), sides(x))[np.ix_(order, order)]
