"""Mistakes in notebook 12, each with the sentence that the student reads."""

import numpy as np

from fieldgrade.authoring.catalogue import answers


def apart(a, b):
    return np.linalg.norm(a[:, None] - b, axis=2)


def solved(phi, nodes, right, polynomial=True):
    """The first N entries of the solutions of the system with another kernel, or without
    polynomial.
    """
    n, d = nodes.shape
    if not polynomial:
        return np.linalg.solve(phi(apart(nodes, nodes)), right[:, :n].T).T
    p = np.column_stack([np.ones(n), nodes])
    matrix = np.vstack(
        [np.hstack([phi(apart(nodes, nodes)), p]), np.hstack([p.T, np.zeros((d + 1, d + 1))])]
    )
    return np.linalg.solve(matrix, right.T).T[:, :n]


def cubed(r):
    return r**3


def right_side(nodes, points, phi=cubed):
    return np.column_stack([phi(apart(points, nodes)), np.ones(len(points)), points])


def right_weights(nodes, points):
    return solved(cubed, nodes, right_side(nodes, points))


def by_pseudo_inverse(nodes, right):
    """The first N entries, with the default tolerance of the pseudo-inverse."""
    n, d = nodes.shape
    p = np.column_stack([np.ones(n), nodes])
    matrix = np.block([[apart(nodes, nodes) ** 3, p], [p.T, np.zeros((d + 1, d + 1))]])
    return (np.linalg.pinv(matrix) @ right.T).T[:, :n]


def right_slopes(nodes, points, factor=3.0, sign=1.0, unit=1.0):
    found = []
    for k in range(nodes.shape[1]):
        b = np.zeros((len(points), len(nodes) + nodes.shape[1] + 1))
        b[:, : len(nodes)] = factor * sign * apart(points, nodes) * (points[:, [k]] - nodes[:, k])
        b[:, len(nodes) + 1 + k] = unit
        found.append(solved(cubed, nodes, b))
    return np.stack(found)


# 12.1


@answers("12.1")
def small_singular_values_cut(nodes, points):
    """The system was solved by a pseudo-inverse or by least squares, with the default tolerance. If
    the coordinates are very large or small, it cuts small singular values. The matrix is regular,
    so `np.linalg.solve` solves the system.
    """
    return by_pseudo_inverse(nodes, right_side(nodes, points))


@answers("12.1")
def without_the_polynomial(nodes, points):
    """The polynomial is missing, with its rows, columns and side conditions. Then the rows of H do
    not sum to 1, and a wing that moves as a whole would change its shape.
    """
    return solved(cubed, nodes, right_side(nodes, points), polynomial=False)


@answers("12.1")
def constants_only(nodes, points):
    """Only the constant of the polynomial is present. Translations are reproduced, but rotations
    are not: in (12.2), the coordinates follow the 1.
    """
    n = len(nodes)
    one = np.ones((n, 1))
    matrix = np.block([[apart(nodes, nodes) ** 3, one], [one.T, np.zeros((1, 1))]])
    b = np.column_stack([apart(points, nodes) ** 3, np.ones(len(points))])
    return np.linalg.solve(matrix, b.T).T[:, :n]


@answers("12.1")
def another_kernel(nodes, points):
    """The kernel is the distance itself, on both sides. Its field has a kink at each node. (12.1)
    uses the cube of the distance.
    """
    return solved(lambda r: r, nodes, right_side(nodes, points, lambda r: r))


@answers("12.1")
def two_kernels(nodes, points):
    """The matrix has cubes of distances, but b(y) has another power. Both sides of (12.2) must have
    the same kernel.
    """
    return solved(cubed, nodes, right_side(nodes, points, lambda r: r**2))


@answers("12.1")
def coefficients_of_the_polynomial(nodes, points):
    """The last N entries of the solution were returned. The weights of the displacements are the
    first N entries.
    """
    n, d = nodes.shape
    p = np.column_stack([np.ones(n), nodes])
    matrix = np.block([[apart(nodes, nodes) ** 3, p], [p.T, np.zeros((d + 1, d + 1))]])
    return np.linalg.solve(matrix, right_side(nodes, points).T).T[:, -n:]


@answers("12.1")
def not_solved(nodes, points):
    """These are the cubed distances, entries of the right-hand side of (12.2). The system must be
    solved for each point.
    """
    return apart(points, nodes) ** 3


@answers("12.1")
def nodes_and_points_exchanged(nodes, points):
    """These weights belong to the reverse transfer: an interpolation of values at the points,
    evaluated at the nodes. In (12.1) the displacements are given at the *nodes*.
    """
    return solved(cubed, points, right_side(points, nodes)).T


@answers("12.1")
def each_alone_by_distance(nodes, points):
    """Each node has the inverse cube of its distance as its weight, and no system is solved. Then
    linear fields are not reproduced, so a tilted wing does not remain straight.
    """
    w = np.maximum(apart(points, nodes), 1e-30) ** -3
    return w / w.sum(axis=1)[:, None]


# 12.2


@answers("12.2")
def not_transposed(H, f):
    """H itself was multiplied by the forces. H maps values at nodes to values at points, but forces
    go the other way. In (12.3) the force on a node is a sum over the points, with a column of H.
    """
    return H @ f


@answers("12.2")
def decimals_lost(H, f):
    """The loads are an array like the forces: if these are integers, it holds integers only, and
    the decimals are lost. Begin with `np.zeros` without a `dtype`.
    """
    g = np.zeros((H.shape[1], f.shape[1]), dtype=f.dtype)
    for j in range(len(g)):
        g[j] = H[:, j] @ f
    return g


@answers("12.2")
def pseudo_inverse(H, f):
    """A pseudoinverse of H was used. It fits the forces as if they were displacements, and does not
    conserve work. (12.4) needs no inverse.
    """
    return np.linalg.pinv(H) @ f


@answers("12.2")
def mean_of_the_forces(H, f):
    """Each node has a weighted mean of the forces, since the sums were divided by the weights. A
    node must carry the *sum* of its forces.
    """
    return (H.T @ f) / H.sum(axis=0)[:, None]


@answers("12.2")
def reaction(H, f):
    """The loads have the opposite sign: these are the reactions of the structure. (12.3) requires
    the loads that act on the structure.
    """
    return -H.T @ f


@answers("12.2")
def shared_equally(H, f):
    """Every node has the same share of the total force. The sum is right, but the weights were not
    used, and the moment is lost.
    """
    return np.tile(f.sum(axis=0) / H.shape[1], (H.shape[1], 1))


# 12.4


@answers("12.4")
def factors_exchanged(points, forces, about):
    """The moment has the wrong sign. In (12.5) the arm points from a to the point of the force, and
    it is the first factor of the cross product. Check both.
    """
    return np.r_[forces.sum(axis=0), np.cross(forces, points - about).sum(axis=0)]


@answers("12.4")
def always_about_the_origin(points, forces, about):
    """The moment is that about the origin, whatever the third argument. Unless the total force is
    zero, the moment depends on this point.
    """
    return np.r_[forces.sum(axis=0), np.cross(points, forces).sum(axis=0)]


@answers("12.4")
def arm_with_a_plus(points, forces, about):
    """The moments are those for arms p + a. In (12.5) the point a is subtracted."""
    return np.r_[forces.sum(axis=0), np.cross(points + about, forces).sum(axis=0)]


@answers("12.4")
def total_force_at_the_mean(points, forces, about):
    """The total force was applied at the mean of the points. A couple, for instance, has zero total
    force and a moment.
    """
    total = forces.sum(axis=0)
    return np.r_[total, np.cross(points.mean(axis=0) - about, total)]


@answers("12.4")
def entries_multiplied(points, forces, about):
    """Coordinates were multiplied by the force along the same axis. The product in (12.5) is a
    cross product.
    """
    return np.r_[forces.sum(axis=0), ((points - about) * forces).sum(axis=0)]


@answers("12.4")
def moment_first(points, forces, about):
    """Both parts are right, but the moment is first. The docstring requires the force first."""
    return np.r_[np.cross(points - about, forces).sum(axis=0), forces.sum(axis=0)]


# 12.6


@answers("12.6")
def pressures_as_forces(H, p, m):
    """The areas are missing: pressures were transferred as if they were forces. Then the result
    depends on the number of points of the skin.
    """
    return H.T @ p


@answers("12.6")
def forces_at_the_nodes(H, p, m):
    """These are the forces at the nodes. A pressure is force divided by area: see the factor before
    the sum in (12.6).
    """
    return H.T @ (p * m)


@answers("12.6")
def divided_by_the_weights(H, p, m):
    """The force at a node was divided by the sum of its weights instead of its area. Then a
    constant pressure is not reproduced unless all areas are 1.
    """
    return H.T @ (p * m) / H.sum(axis=0)


@answers("12.6")
def equal_areas_of_nodes(H, p, m):
    """Every node has the same area. By (12.6) the areas are transferred with H, like forces."""
    return H.T @ (p * m) / (m.sum() / H.shape[1])


@answers("12.6")
def areas_forgotten_twice(H, p, m):
    """The areas are missing in both sums of (12.6). Constants are reproduced, but the total force
    is not conserved: large and small areas count alike.
    """
    return H.T @ p / H.sum(axis=0)


@answers("12.6")
def areas_squared(H, p, m):
    """The areas enter twice in the numerator. The force at a point of the skin is its pressure
    times its area, once.
    """
    return H.T @ (p * m**2) / (H.T @ m)


@answers("12.6")
def small_number_added_to_the_areas(H, p, m):
    """A fixed number was added to the areas of the nodes, so that none is zero. If all areas are
    tiny, it is not small beside them. In the inputs no area of a node is zero.
    """
    return (H.T @ (m * p)) / (H.T @ m + 1e-12)


@answers("12.6", named=False)
def positive_areas_of_nodes(H, p, m):
    """The area of a node with negative weights was replaced by a positive one."""
    return (H.T @ (m * p)) / np.abs(H.T @ m)


@answers("12.6", named=False)
def absolute_weights(H, p, m):
    """Negative weights were replaced by positive ones."""
    return (np.abs(H).T @ (m * p)) / (np.abs(H).T @ m)


@answers("12.6", named=False)
def positive_weights_only(H, p, m):
    """Negative weights were replaced by zero, so forces are lost."""
    positive = np.maximum(H, 0)
    return (positive.T @ (m * p)) / (positive.T @ m)


@answers("12.6", named=False)
def within_the_given_pressures(H, p, m):
    """The result may exceed the given pressures where weights are negative."""
    return np.clip((H.T @ (m * p)) / (H.T @ m), p.min(), p.max())


@answers("12.6", named=False)
def rows_made_to_sum_to_one(H, p, m):
    """The weights were changed before they were used."""
    scaled = H / H.sum(axis=1)[:, None]
    return (scaled.T @ (m * p)) / (scaled.T @ m)


# 12.7


@answers("12.7")
def unit_vector_forgotten(nodes, points):
    """The derivative of the polynomial is missing. The last D entries of b(y) are the coordinates;
    the derivative of coordinate k along axis k is 1.
    """
    return right_slopes(nodes, points, unit=0.0)


@answers("12.7")
def three_forgotten(nodes, points):
    """The factor 3 is missing: what is the derivative of a cube?"""
    return right_slopes(nodes, points, factor=1.0)


@answers("12.7")
def towards_the_node(nodes, points):
    """The part of the kernel has the wrong sign: the differences point from the point to the nodes.
    (12.7) differentiates with respect to the point.
    """
    return right_slopes(nodes, points, sign=-1.0)


@answers("12.7")
def squares_without_direction(nodes, points):
    """The kernel was differentiated with respect to the distance only: 3 r² along every axis. The
    chain rule requires the derivative of the distance along the axis as a factor.
    """
    found = []
    for k in range(nodes.shape[1]):
        b = np.zeros((len(points), len(nodes) + nodes.shape[1] + 1))
        b[:, : len(nodes)] = 3 * apart(points, nodes) ** 2
        b[:, len(nodes) + 1 + k] = 1
        found.append(solved(cubed, nodes, b))
    return np.stack(found)


@answers("12.7")
def unit_vector_at_the_constant(nodes, points):
    """The 1 of the unit vector is one entry too early, for the first axis at the position of the
    constant. The order in b(y) is: N distances, the 1, the coordinates.
    """
    found = []
    for k in range(nodes.shape[1]):
        b = np.zeros((len(points), len(nodes) + nodes.shape[1] + 1))
        b[:, : len(nodes)] = 3 * apart(points, nodes) * (points[:, [k]] - nodes[:, k])
        b[:, len(nodes) + k] = 1
        found.append(solved(cubed, nodes, b))
    return np.stack(found)


@answers("12.7")
def by_coarse_differences(nodes, points):
    """These are difference quotients with a rather large step, right to a few digits only. (12.2)
    can be differentiated exactly, entry by entry.
    """
    step = 1e-3 * np.ptp(nodes, axis=0).max()
    ways = step * np.eye(nodes.shape[1])
    return np.stack(
        [(right_weights(nodes, points + e) - right_weights(nodes, points)) / step for e in ways]
    )


# 12.8


def plate(nodes, points, f, first=0, second=1, sign=-1.0, heights=None):
    p, height = points[:, :2], points[:, 2] if heights is None else heights
    g = right_weights(nodes, p).T @ f
    gx, gy = right_slopes(nodes, p)
    g[:, 2] += sign * (gx.T @ (height * f[:, first]) + gy.T @ (height * f[:, second]))
    return g


@answers("12.8")
def heights_ignored(nodes, points, f):
    """The forces were moved down to the plate without their moments. A force along the plate, at a
    height, has a moment; the second term of (12.7) accounts for it.
    """
    return right_weights(nodes, points[:, :2]).T @ f


@answers("12.8")
def couple_turned_round(nodes, points, f):
    """The moments of the forces along the plate have the wrong sign. Check the minus in (12.7), and
    the sign of your `slopes`.
    """
    return plate(nodes, points, f, sign=1.0)


@answers("12.8")
def axes_exchanged(nodes, points, f):
    """The slope along one axis was multiplied by the force along the other. Check the components in
    (12.7), and the order of the axes in your `slopes`.
    """
    return plate(nodes, points, f, first=1, second=0)


@answers("12.8")
def normal_force_for_the_couple(nodes, points, f):
    """The slopes were multiplied by the forces *normal* to the plate. These act along the arm and
    have no moment about its foot. The forces along the plate do.
    """
    return plate(nodes, points, f, first=2, second=2)


@answers("12.8")
def heights_without_sign(nodes, points, f):
    """The heights enter by their absolute value. Below the plate a force has the
    opposite moment.
    """
    return plate(nodes, points, f, heights=np.abs(points[:, 2]))


@answers("12.8")
def couple_into_the_plane(nodes, points, f):
    """The terms with slopes were added to the components *in* the plate. In (12.7) the slopes are
    multiplied by the third component of u, so they belong to the third component of g.
    """
    p, height = points[:, :2], points[:, 2]
    g = right_weights(nodes, p).T @ f
    gx, gy = right_slopes(nodes, p)
    g[:, 0] -= gx.T @ (height * f[:, 0])
    g[:, 1] -= gy.T @ (height * f[:, 1])
    return g


# 12.10


def march(K, H, f0, A, omega, steps, start, answer):
    u = [start]
    for _ in range(steps):
        u.append(answer(u[-1]))
    return np.array(u)


def response(K, H, f):
    return np.linalg.solve(K, H.T @ f)


@answers("12.10")
def without_relaxation(K, H, f0, A, omega, steps):
    """The relaxation is missing: each step has ω = 1."""
    return march(
        K, H, f0, A, omega, steps, np.zeros(len(K)), lambda u: response(K, H, f0 + A @ H @ u)
    )


@answers("12.10")
def parts_exchanged(K, H, f0, A, omega, steps):
    """ω and 1 − ω are exchanged. With ω = 1 the displacement must be that computed by the
    structure.
    """
    return march(
        K,
        H,
        f0,
        A,
        omega,
        steps,
        np.zeros(len(K)),
        lambda u: omega * u + (1 - omega) * response(K, H, f0 + A @ H @ u),
    )


@answers("12.10")
def old_part_kept_whole(K, H, f0, A, omega, steps):
    """The old displacement is kept completely, and ω times the new one is added. In (12.9) the old
    displacement has the factor 1 − ω.
    """
    return march(
        K,
        H,
        f0,
        A,
        omega,
        steps,
        np.zeros(len(K)),
        lambda u: u + omega * response(K, H, f0 + A @ H @ u),
    )


@answers("12.10")
def loads_do_not_follow(K, H, f0, A, omega, steps):
    """The loads remain those of the undeformed wing. They must be computed again in each step, with
    A and the displacements of the step before.
    """
    return march(
        K,
        H,
        f0,
        A,
        omega,
        steps,
        np.zeros(len(K)),
        lambda u: (1 - omega) * u + omega * response(K, H, f0),
    )


@answers("12.10")
def only_the_change(K, H, f0, A, omega, steps):
    """The loads f₀ act in the first step only. In (12.9) they act in every step."""
    first = omega * response(K, H, f0)
    later = march(
        K,
        H,
        f0,
        A,
        omega,
        steps - 1,
        first,
        lambda u: (1 - omega) * u + omega * response(K, H, A @ H @ u),
    )
    return np.vstack([np.zeros(len(K)), later])


@answers("12.10")
def begins_with_the_first_answer(K, H, f0, A, omega, steps):
    """The first row is already the result of a step. The iteration of (12.9) begins with zero
    displacements.
    """
    return march(
        K,
        H,
        f0,
        A,
        omega,
        steps,
        omega * response(K, H, f0),
        lambda u: (1 - omega) * u + omega * response(K, H, f0 + A @ H @ u),
    )


@answers("12.10")
def multiplied_by_the_stiffness(K, H, f0, A, omega, steps):
    """The loads were multiplied by K. The displacement is the solution of a system with the matrix
    K.
    """
    return march(
        K,
        H,
        f0,
        A,
        omega,
        steps,
        np.zeros(len(K)),
        lambda u: (1 - omega) * u + omega * K @ (H.T @ (f0 + A @ H @ u)),
    )


@answers("12.10")
def stopped_when_close(K, H, f0, A, omega, steps):
    """The iteration stopped where two iterates hardly differ, by a fixed bound. All steps are
    required. With small steps or small loads, iterates are close long before they converge.
    """

    def step(u):
        new = (1 - omega) * u + omega * response(K, H, f0 + A @ (H @ u))
        return u if np.allclose(new, u) else new

    return march(K, H, f0, A, omega, steps, np.zeros(len(K)), step)


@answers("12.10")
def the_steady_state_only(K, H, f0, A, omega, steps):
    """Every row after the first is the steady state. The function must return the iterates of
    (12.9) on the way to it.
    """
    final = np.linalg.solve(K - H.T @ A @ H, H.T @ f0)
    return np.vstack([np.zeros(len(K)), np.tile(final, (steps, 1))])


@answers("12.10")
def from_the_steady_state(K, H, f0, A, omega, steps):
    """The iterates were computed from the steady state (12.8). At the divergence of the wing there
    is none: K − HᵀAH is singular. The iterates of (12.9) exist all the same.
    """
    final = np.linalg.solve(K - H.T @ A @ H, H.T @ f0)
    factor = (1 - omega) * np.eye(len(K)) + omega * np.linalg.solve(K, H.T @ A @ H)
    return np.array([final - np.linalg.matrix_power(factor, n) @ final for n in range(steps + 1)])


@answers("12.10")
def one_array_in_all_rows(K, H, f0, A, omega, steps):
    """All rows are equal to the last iterate. If one array is changed in place and appended again
    and again, the list holds the same array many times: append a copy.
    """
    u = march(
        K,
        H,
        f0,
        A,
        omega,
        steps,
        np.zeros(len(K)),
        lambda u: (1 - omega) * u + omega * response(K, H, f0 + A @ H @ u),
    )
    return np.tile(u[-1], (steps + 1, 1))


@answers("12.10")
def loads_at_rest_forgotten(K, H, f0, A, omega, steps):
    """All displacements are zero, since the loads f₀ of the undeformed wing are missing. In (12.9)
    they act in every step.
    """
    return np.zeros((steps + 1, len(K)))


# 12.11


def growths(K, H, A):
    return np.linalg.eigvals(np.linalg.solve(K, H.T @ A @ H))


@answers("12.11")
def sign_ignored(K, H, A):
    """The eigenvalue of largest modulus was taken. If it is negative or complex, no positive q
    belongs to it.
    """
    return 1 / np.abs(growths(K, H, A)).max()


@answers("12.11")
def complex_ones_too(K, H, A):
    """The largest real part was taken, of complex eigenvalues too. No real q belongs to a complex
    eigenvalue.
    """
    return 1 / growths(K, H, A).real.max()


@answers("12.11")
def small_imaginary_parts(K, H, A):
    """Eigenvalues were taken as real if their imaginary part is below a fixed number. For a stiff
    wing all eigenvalues are small. Compare with their size, or use `np.isreal`.
    """
    found = growths(K, H, A)
    return 1 / found[np.abs(found.imag) < 1e-9].real.max()


@answers("12.11")
def nearly_real_ones_too(K, H, A):
    """Eigenvalues were taken as real if their imaginary part is below a millionth of their size.
    But such an eigenvalue is not real, and no real q belongs to it. The computed eigenvalues of a
    real matrix are exactly real, or they are conjugate pairs: use `np.isreal`.
    """
    found = growths(K, H, A)
    return 1 / found[np.abs(found.imag) < 1e-6 * np.abs(found)].real.max()


@answers("12.11")
def real_up_to_a_tenth(K, H, A):
    """Eigenvalues were taken as real if their imaginary part is below a tenth of their size. No
    real q belongs to a complex eigenvalue. The computed eigenvalues of a real matrix are exactly
    real, or they are conjugate pairs: use `np.isreal`.
    """
    found = growths(K, H, A)
    return 1 / found[np.abs(found.imag) < 0.1 * np.abs(found)].real.max()


@answers("12.11", named=False)
def small_eigenvalues_left_out(K, H, A):
    """Eigenvalues below a fixed number were left out. A stiff wing has small eigenvalues only."""
    found = growths(K, H, A)
    real = found[np.isreal(found)].real
    return 1 / max(real[real > 1e-9], default=np.inf)


@answers("12.11")
def not_inverted(K, H, A):
    """This is an eigenvalue, 1/q. For a stiffer wing it is smaller, but the divergence pressure is
    larger.
    """
    found = growths(K, H, A)
    return found[np.isreal(found)].real.max()


@answers("12.11")
def stiffness_alone(K, H, A):
    """This is the smallest eigenvalue of the stiffness matrix. The air loads are missing: (12.11)
    contains K, H and A.
    """
    return np.linalg.eigvals(K).real.min()


@answers("12.11")
def made_symmetric(K, H, A):
    """The eigenvalues of the symmetric part were taken. In general K⁻¹HᵀAH is not symmetric, even
    if HᵀAH is.
    """
    found = np.linalg.solve(K, H.T @ A @ H)
    return 1 / np.linalg.eigvalsh((found + found.T) / 2).max()


@answers("12.11")
def largest_pressure(K, H, A):
    """At this q the matrix is singular, but there is a smaller positive q. Take the
    smallest one.
    """
    found = growths(K, H, A)
    real = found[np.isreal(found)].real
    return 1 / real[real > 1e-9 * np.abs(found).max()].min()


@answers("12.11", named=False)
def first_eigenvalue(K, H, A):
    """The eigenvalues are in no particular order."""
    return 1 / growths(K, H, A)[0].real


@answers("12.1", named=False)
def near_nodes_count_as_nodes(nodes, points):
    """An absolute limit has no meaning, since the nodes may have any unit of length."""
    middle = nodes.mean(axis=0)
    size = np.abs(nodes - middle).max()
    y, x = (nodes - middle) / size, (points - middle) / size
    n = len(y)
    p, q = (np.column_stack([np.ones(len(z)), z]) for z in (y, x))

    def cubes(a):
        return np.linalg.norm(a[:, None] - y, axis=2) ** 3

    m = p.shape[1]
    system = np.block([[cubes(y), p], [p.T, np.zeros((m, m))]])
    h = np.linalg.solve(system, np.vstack([cubes(x).T, q.T]))[:n].T
    apart = np.linalg.norm(points[:, None] - nodes, axis=2)
    near = apart.min(axis=1) < 1e-6
    h[near] = np.eye(n)[apart[near].argmin(axis=1)]
    return h
