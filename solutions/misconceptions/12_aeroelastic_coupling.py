"""What students write instead of notebook 12, and what each of them should hear."""

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


def right_side(nodes, places, phi=cubed):
    return np.column_stack([phi(apart(places, nodes)), np.ones(len(places)), places])


def right_weights(nodes, places):
    return solved(cubed, nodes, right_side(nodes, places))


def right_slopes(nodes, places, factor=3.0, sign=1.0, unit=1.0):
    found = []
    for k in range(nodes.shape[1]):
        b = np.zeros((len(places), len(nodes) + nodes.shape[1] + 1))
        b[:, : len(nodes)] = factor * sign * apart(places, nodes) * (places[:, [k]] - nodes[:, k])
        b[:, len(nodes) + 1 + k] = unit
        found.append(solved(cubed, nodes, b))
    return np.stack(found)


# 12.1


@answers("12.1")
def without_the_polynomial(nodes, places):
    """The polynomial is missing: neither its rows and columns nor its conditions enter. Rows of H
    do not sum to one then, so that a wing that moves as a whole would change its shape. Which
    part of b(y) is missing?
    """
    return solved(cubed, nodes, right_side(nodes, places), polynomial=False)


@answers("12.1")
def constants_only(nodes, places):
    """Of the polynomial only the constant is there. Translations come back, and rotations do not:
    the rows of (12.2) go on after the one.
    """
    n = len(nodes)
    one = np.ones((n, 1))
    matrix = np.block([[apart(nodes, nodes) ** 3, one], [one.T, np.zeros((1, 1))]])
    b = np.column_stack([apart(places, nodes) ** 3, np.ones(len(places))])
    return np.linalg.solve(matrix, b.T).T[:, :n]


@answers("12.1")
def another_kernel(nodes, places):
    """This is the interpolation with the distance itself as kernel, on both sides. Its field has
    a kink at each node, like a string; (12.1) bends like a ruler. Look at the power.
    """
    return solved(lambda r: r, nodes, right_side(nodes, places, lambda r: r))


@answers("12.1")
def two_kernels(nodes, places):
    """The matrix has cubes of distances, and b(y) has another power of them. Then nothing is
    interpolated: both sides of (12.2) must speak of one kernel.
    """
    return solved(cubed, nodes, right_side(nodes, places, lambda r: r**2))


@answers("12.1")
def coefficients_of_the_polynomial(nodes, places):
    """The last N of the solved entries are returned. The entries that multiply displacements come
    first; those of the polynomial, at the end, multiply zeros on the right of (12.1).
    """
    n, d = nodes.shape
    p = np.column_stack([np.ones(n), nodes])
    matrix = np.block([[apart(nodes, nodes) ** 3, p], [p.T, np.zeros((d + 1, d + 1))]])
    return np.linalg.solve(matrix, right_side(nodes, places).T).T[:, -n:]


@answers("12.1")
def not_solved(nodes, places):
    """These are the cubes of the distances, the right side of (12.2), not its solution. As
    weights they would grow with the distance. The system has to be solved for each place.
    """
    return apart(places, nodes) ** 3


@answers("12.1")
def nodes_and_places_exchanged(nodes, places):
    """The weights are those of the transposed task: a field through the places, read off at the
    nodes. Which of the two sets carries displacements?
    """
    return solved(cubed, places, right_side(places, nodes)).T


@answers("12.1")
def each_alone_by_distance(nodes, places):
    """Each node counts by the inverse of its distance, and nothing is solved. Such a mean is
    never larger than the largest displacement, so a tilted wing is levelled out at its rim:
    linear fields do not come back.
    """
    w = np.maximum(apart(places, nodes), 1e-30) ** -3
    return w / w.sum(axis=1)[:, None]


# 12.2


@answers("12.2")
def not_transposed(H, f):
    """H itself is applied to the forces. It takes numbers at nodes to numbers at places; forces
    go the other way. With as many nodes as places nothing warns you. See which index of H is
    summed in (12.3).
    """
    return H @ f


@answers("12.2")
def pseudo_inverse(H, f):
    """A pseudo inverse undoes H as well as it can, and fits the forces as if they were
    displacements. The work is not the same. (12.4) asks for less: nothing has to be inverted.
    """
    return np.linalg.pinv(H) @ f


@answers("12.2")
def mean_of_the_forces(H, f):
    """Each node gets a weighted mean of the forces, since you divide by the sum of the weights. A
    node in which many forces meet must carry them all: their sum.
    """
    return (H.T @ f) / H.sum(axis=0)[:, None]


@answers("12.2")
def reaction(H, f):
    """The sign is turned: these are the forces with which the structure holds the skin. (12.3)
    asks for those that act on the structure.
    """
    return -H.T @ f


@answers("12.2")
def shared_equally(H, f):
    """Every node gets the same part of the total force. The sum is right, but the weights do not
    matter at all, and the moment is lost.
    """
    return np.tile(f.sum(axis=0) / H.shape[1], (H.shape[1], 1))


# 12.4


@answers("12.4")
def factors_exchanged(points, forces, about):
    """The moment has the wrong sign: a cross product changes its sign with the order of its
    factors. In (12.5) the arm comes first.
    """
    return np.r_[forces.sum(axis=0), np.cross(forces, points - about).sum(axis=0)]


@answers("12.4")
def always_about_the_origin(points, forces, about):
    """The moment is taken about the origin, whatever the third argument. Unless the total force
    vanishes, it depends on that point.
    """
    return np.r_[forces.sum(axis=0), np.cross(points, forces).sum(axis=0)]


@answers("12.4")
def arm_with_a_plus(points, forces, about):
    """The point about which moments are taken is added to the arm. An arm is the way *from* that
    point to where the force acts.
    """
    return np.r_[forces.sum(axis=0), np.cross(points + about, forces).sum(axis=0)]


@answers("12.4")
def total_force_at_the_mean(points, forces, about):
    """The total force is put at the mean of the points. That is right only if all forces are
    equal; a couple, for instance, has no total force and yet a moment.
    """
    total = forces.sum(axis=0)
    return np.r_[total, np.cross(points.mean(axis=0) - about, total)]


@answers("12.4")
def entries_multiplied(points, forces, about):
    """Coordinates are multiplied with the force along the same axis. A force that points along
    its arm turns nothing; the product of (12.5) is a cross product.
    """
    return np.r_[forces.sum(axis=0), ((points - about) * forces).sum(axis=0)]


@answers("12.4")
def moment_first(points, forces, about):
    """Both parts are right, but the moment comes first. The docstring asks for the force first,
    and later functions count on it.
    """
    return np.r_[np.cross(points - about, forces).sum(axis=0), forces.sum(axis=0)]


# 12.6


@answers("12.6")
def pressures_as_forces(H, p, m):
    """The areas do not enter: pressures are handed on as if they were forces. Where the skin is
    finer there are more of them, and the sum depends on the mesh.
    """
    return H.T @ p


@answers("12.6")
def forces_at_the_nodes(H, p, m):
    """These are the forces at the nodes. They are right, and one step is missing: a pressure is
    force by the area of the node, see what stands before the sum in (12.6).
    """
    return H.T @ (p * m)


@answers("12.6")
def divided_by_the_weights(H, p, m):
    """The force at a node is divided by the sum of its weights instead of its area. A constant
    pressure then does not come back, unless all areas are one.
    """
    return H.T @ (p * m) / H.sum(axis=0)


@answers("12.6")
def equal_areas_of_nodes(H, p, m):
    """Every node is given the same area, the whole divided by their number. Nodes at a rim
    collect less skin than those in the middle; their areas come from H as the forces do.
    """
    return H.T @ (p * m) / (m.sum() / H.shape[1])


@answers("12.6")
def areas_forgotten_twice(H, p, m):
    """Pressures are averaged with the weights, and areas enter neither above nor below. Constants
    come back, but the total force does not: a large piece of skin counts no more than a small
    one.
    """
    return H.T @ p / H.sum(axis=0)


@answers("12.6")
def areas_squared(H, p, m):
    """Areas enter twice above the line. The force on a piece of skin is its pressure times its
    area, once.
    """
    return H.T @ (p * m**2) / (H.T @ m)


# 12.7


@answers("12.7")
def unit_vector_forgotten(nodes, places):
    """The derivative of the polynomial is missing. A tilted plane would have no slope: the
    coordinate itself, at the end of b(y), has the derivative one along its axis.
    """
    return right_slopes(nodes, places, unit=0.0)


@answers("12.7")
def three_forgotten(nodes, places):
    """The factor from the power is missing: the derivative of a cube is three times a square."""
    return right_slopes(nodes, places, factor=1.0)


@answers("12.7")
def towards_the_node(nodes, places):
    """The arms point from the place to the nodes, so the kernel's part has the wrong sign. The
    derivative is with respect to the place.
    """
    return right_slopes(nodes, places, sign=-1.0)


@answers("12.7")
def squares_without_direction(nodes, places):
    """The kernel is differentiated with respect to the distance, and the direction is left out: 3
    r² along every axis. The chain rule has a second factor, the change of the distance along the
    axis.
    """
    found = []
    for k in range(nodes.shape[1]):
        b = np.zeros((len(places), len(nodes) + nodes.shape[1] + 1))
        b[:, : len(nodes)] = 3 * apart(places, nodes) ** 2
        b[:, len(nodes) + 1 + k] = 1
        found.append(solved(cubed, nodes, b))
    return np.stack(found)


@answers("12.7")
def unit_vector_at_the_constant(nodes, places):
    """The one of the unit vector stands one entry too early: the first coordinate is treated like
    the constant. Count the entries of b(y): N distances, the one, then the coordinates.
    """
    found = []
    for k in range(nodes.shape[1]):
        b = np.zeros((len(places), len(nodes) + nodes.shape[1] + 1))
        b[:, : len(nodes)] = 3 * apart(places, nodes) * (places[:, [k]] - nodes[:, k])
        b[:, len(nodes) + k] = 1
        found.append(solved(cubed, nodes, b))
    return np.stack(found)


@answers("12.7")
def by_coarse_differences(nodes, places):
    """These are differences of weights over a short way, not derivatives: right to a few digits
    only. (12.2) can be differentiated exactly, entry by entry.
    """
    step = 1e-3
    ways = step * np.eye(nodes.shape[1])
    return np.stack(
        [(right_weights(nodes, places + e) - right_weights(nodes, places)) / step for e in ways]
    )


# 12.8


def plate(nodes, places, f, first=0, second=1, sign=-1.0, heights=None):
    p, height = places[:, :2], places[:, 2] if heights is None else heights
    g = right_weights(nodes, p).T @ f
    gx, gy = right_slopes(nodes, p)
    g[:, 2] += sign * (gx.T @ (height * f[:, first]) + gy.T @ (height * f[:, second]))
    return g


@answers("12.8")
def heights_ignored(nodes, places, f):
    """The forces are brought down to the plate as they are. Sums are right, but a force along the
    plate, at a height, also has a moment about axes in the plate; the second term of (12.7)
    carries it.
    """
    return right_weights(nodes, places[:, :2]).T @ f


@answers("12.8")
def couple_turned_round(nodes, places, f):
    """The couples have the wrong sign. Think of an arm that stands up from the plate, and of what
    happens to its tip if the plate rises to the right: there is a minus in (12.7).
    """
    return plate(nodes, places, f, sign=1.0)


@answers("12.8")
def axes_exchanged(nodes, places, f):
    """The slope along one axis is multiplied with the force along the other. In (12.7) slope and
    component stand in the same row.
    """
    return plate(nodes, places, f, first=1, second=0)


@answers("12.8")
def normal_force_for_the_couple(nodes, places, f):
    """The couples are made of the forces *across* the plate. Those act along the arm, and turn
    nothing; it is the forces along the plate that pull at its tip.
    """
    return plate(nodes, places, f, first=2, second=2)


@answers("12.8")
def heights_without_sign(nodes, places, f):
    """Heights enter by their absolute value. Below the plate a force turns it the other way: an
    engine under a wing lifts its nose.
    """
    return plate(nodes, places, f, heights=np.abs(places[:, 2]))


@answers("12.8")
def couple_into_the_plane(nodes, places, f):
    """Forces times heights and slopes are added to the components *in* the plate. But they belong
    to the displacement by which they are multiplied in (12.7), and that is the third one.
    """
    p, height = places[:, :2], places[:, 2]
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
    """The whole way is gone in each step: ω does not enter. That converges for some wings, and
    for others swings wider and wider.
    """
    return march(
        K, H, f0, A, omega, steps, np.zeros(len(K)), lambda u: response(K, H, f0 + A @ H @ u)
    )


@answers("12.10")
def parts_exchanged(K, H, f0, A, omega, steps):
    """ω and 1 − ω have changed places: with ω = 1 nothing would ever move. Which of the two
    belongs to the answer of the structure?
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
    """Part of the answer is added to the whole of the old displacement. At the steady state u
    would still grow: the old one is to be kept only in part, see (12.9).
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
    """The loads stay those at rest: the air does not notice that the wing has moved. That is the
    coupling in one direction; f must be computed anew in each step.
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
    """The loads at rest are used in the first step and then forgotten, so that the displacement
    dies away. In (12.9) they act in every step.
    """
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
    """The first row is the stiff wing's answer to the loads at rest. The iteration of (12.9)
    begins with no displacement, so each row comes one step too early.
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
    """The loads are multiplied by the stiffness. A stiffer structure would give way more: what is
    known is K u, and u is sought.
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
def the_steady_state_only(K, H, f0, A, omega, steps):
    """Every row is the steady state, as if the two programs were one. That is where the iterates
    should end, if they converge; asked for is the way there, which begins at rest.
    """
    final = np.linalg.solve(K - H.T @ A @ H, H.T @ f0)
    return np.vstack([np.zeros(len(K)), np.tile(final, (steps, 1))])


# 12.11


def growths(K, H, A):
    return np.linalg.eigvals(np.linalg.solve(K, H.T @ A @ H))


@answers("12.11")
def sign_ignored(K, H, A):
    """The eigenvalue of largest modulus is taken. If it is negative, or complex, the iteration
    may swing, but no positive pressure makes the matrix of (12.11) singular.
    """
    return 1 / np.abs(growths(K, H, A)).max()


@answers("12.11")
def complex_ones_too(K, H, A):
    """The largest real part is taken, of complex eigenvalues too. At that pressure the matrix of
    (12.11) is not singular: a complex eigenvalue belongs to no real q.
    """
    return 1 / growths(K, H, A).real.max()


@answers("12.11")
def not_inverted(K, H, A):
    """This is the eigenvalue itself. It is the larger, the softer the wing; the pressure at which
    a softer wing diverges is smaller.
    """
    found = growths(K, H, A)
    return found[np.isreal(found)].real.max()


@answers("12.11")
def stiffness_alone(K, H, A):
    """The smallest eigenvalue of the stiffness is no pressure: the air does not enter. (12.11)
    has K on one side and H, A and q on the other.
    """
    return np.linalg.eigvals(K).real.min()


@answers("12.11")
def made_symmetric(K, H, A):
    """Eigenvalues of the symmetric part are taken. Loads that follow a displacement are not
    symmetric: the tail may act on the nose and not the nose on the tail.
    """
    found = np.linalg.solve(K, H.T @ A @ H)
    return 1 / np.linalg.eigvalsh((found + found.T) / 2).max()


@answers("12.11")
def largest_pressure(K, H, A):
    """This is a pressure at which the matrix is singular, but not the first that the wing meets
    as the wind rises: look at the smallest one that is positive.
    """
    found = growths(K, H, A)
    real = found[np.isreal(found)].real
    return 1 / real[real > 1e-9 * np.abs(found).max()].min()
