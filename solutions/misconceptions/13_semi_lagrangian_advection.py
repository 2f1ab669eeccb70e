"""What students write instead of notebook 13, and what each of them should hear."""

import numpy as np

from fieldgrade.authoring.catalogue import answers


def wind(y, t, flow):
    """The velocity of the notebook."""
    p, q = y[:, 0], y[:, 1]
    if flow == 2:
        a = (
            np.cos(np.pi * p / 2) ** 2 * np.sin(np.pi * q),
            -(np.cos(np.pi * q / 2) ** 2) * np.sin(np.pi * p),
        )
        return 3 * np.cos(np.pi * t) * np.stack(a, axis=1)
    rate = (1 + t) / (1 + 4 * (p**2 + q**2)) if flow == 1 else np.ones(len(y))
    return 2 * np.pi * np.stack([-rate * q, rate * p], axis=1)


def right_feet(x, t, dt, flow):
    a = wind(x, t, flow)
    b = wind(x - dt * a / 2, t - dt / 2, flow)
    c = wind(x - dt * b / 2, t - dt / 2, flow)
    return x - dt * (a + 2 * b + 2 * c + wind(x - dt * c, t - dt, flow)) / 6


def local_weights(sites, y, k, phi=lambda r: r**3, polynomial=True):
    """The numbers of the k nearest sites, and their weights."""
    near = np.argsort(((sites - y) ** 2).sum(axis=1))[:k]
    z = sites[near]
    a = phi(np.linalg.norm(z[:, None] - z, axis=2))
    b = phi(np.linalg.norm(z - y, axis=1))
    if polynomial:
        p = np.column_stack([np.ones(k), z])
        a = np.vstack([np.hstack([a, p]), np.hstack([p.T, np.zeros((p.shape[1],) * 2)])])
        b = np.hstack([b, 1, y])
    return near, np.linalg.solve(a, b)[:k]


def matrix(sites, feet, k, **how):
    h = np.zeros((len(feet), len(sites)))
    for i, y in enumerate(feet):
        near, w = local_weights(sites, y, k, **how)
        h[i, near] = w
    return h


# 13.1


@answers("13.1")
def forward(x, t, dt, flow):
    """You went forward, to where the particles will be. The value here comes from where they
    were: the sign of the step in (13.3).
    """
    return x + dt * wind(x, t, flow)


@answers("13.1")
def the_way_only(x, t, dt, flow):
    """This is the way that a particle went, not the place from which it came. What is it
    subtracted from?
    """
    return -dt * wind(x, t, flow)


@answers("13.1")
def velocity_of_the_time_before(x, t, dt, flow):
    """The velocity is that of the earlier time. In flows that do not change this is the same; the
    vortex gets faster. (13.3) takes here *and now*.
    """
    return x - dt * wind(x, t - dt, flow)


@answers("13.1")
def direction_only(x, t, dt, flow):
    """All particles are moved equally far, since the velocity is divided by its length. How fast
    the flow is must matter.
    """
    a = wind(x, t, flow)
    return x - dt * a / np.linalg.norm(a, axis=1)[:, None]


@answers("13.1")
def step_forgotten(x, t, dt, flow):
    """The velocity is subtracted as it is, as if the step were one.
    A path is velocity times time.
    """
    return x - wind(x, t, flow)


@answers("13.1")
def always_at_time_zero(x, t, dt, flow):
    """The velocity is taken at the time zero, whatever t. It depends on time in two of the three
    flows.
    """
    return x - dt * wind(x, 0.0, flow)


# 13.2


@answers("13.2")
def time_not_halved(x, t, dt, flow):
    """The place is half-way, the time is not: the velocity is that of the end. For a flow that
    changes, the order drops to that of Euler. Both arguments of (13.4) move.
    """
    return x - dt * wind(x - dt / 2 * wind(x, t, flow), t, flow)


@answers("13.2")
def place_not_halved(x, t, dt, flow):
    """The second velocity is taken at Euler's foot, and not half-way to it."""
    return x - dt * wind(x - dt * wind(x, t, flow), t - dt / 2, flow)


@answers("13.2")
def time_went_forward(x, t, dt, flow):
    """The place goes back, and the time forward. Half-way back it was earlier."""
    return x - dt * wind(x - dt / 2 * wind(x, t, flow), t + dt / 2, flow)


@answers("13.2")
def half_a_step_with_the_second(x, t, dt, flow):
    """With the velocity of the middle only half of the step is made. The middle is a place to
    look, and the whole way begins at x.
    """
    return x - dt / 2 * wind(x - dt / 2 * wind(x, t, flow), t - dt / 2, flow)


@answers("13.2")
def went_on_from_the_middle(x, t, dt, flow):
    """The whole step is made from the middle, so that one goes back one and a half steps. It
    begins at x.
    """
    middle = x - dt / 2 * wind(x, t, flow)
    return middle - dt * wind(middle, t - dt / 2, flow)


@answers("13.2")
def two_halves_of_euler(x, t, dt, flow):
    """Two steps of Euler, each half as long. Twice the work halves the error, and the order
    stays; (13.4) uses the second velocity for the whole.
    """
    middle = x - dt / 2 * wind(x, t, flow)
    return middle - dt / 2 * wind(middle, t - dt / 2, flow)


@answers("13.2")
def mean_of_both_ends(x, t, dt, flow):
    """This is the mean of the velocities at both ends, the scheme of Heun. It has the same order;
    asked for is the velocity of the middle.
    """
    a = wind(x, t, flow)
    return x - dt / 2 * (a + wind(x - dt * a, t - dt, flow))


# 13.3


def four(
    x,
    t,
    dt,
    flow,
    weights=(1 / 6, 1 / 3, 1 / 3, 1 / 6),
    times=(0, 0.5, 0.5, 1),
    parts=(0, 0.5, 0.5, 1),
):
    slopes = []
    for part, time in zip(parts, times):
        slopes.append(wind(x - dt * part * slopes[-1] if slopes else x, t - dt * time, flow))
    return x - dt * sum(w * s for w, s in zip(weights, slopes))


@answers("13.3")
def plain_mean(x, t, dt, flow):
    """The four velocities have the same weight. As in Simpson's rule those of the middle count
    more: see the numbers in the bracket.
    """
    return four(x, t, dt, flow, weights=(0.25,) * 4)


@answers("13.3")
def divided_by_four(x, t, dt, flow):
    """You divide by the number of velocities. The numbers in the bracket of (13.5) sum to another
    one, so that the step comes out too long.
    """
    return four(x, t, dt, flow, weights=(0.25, 0.5, 0.5, 0.25))


@answers("13.3")
def times_forgotten(x, t, dt, flow):
    """All velocities are those of the time t. The order is lost where the flow changes in time:
    each stage has a time of its own.
    """
    return four(x, t, dt, flow, times=(0, 0, 0, 0))


@answers("13.3")
def last_stage_half_way(x, t, dt, flow):
    """The fourth velocity is taken half-way again. It belongs to the end of the step."""
    return four(x, t, dt, flow, parts=(0, 0.5, 0.5, 0.5))


@answers("13.3")
def first_velocity_everywhere(x, t, dt, flow):
    """All places are found with the first velocity. Each stage looks where the one before points:
    see the indices in (13.5).
    """
    a = wind(x, t, flow)
    b = wind(x - dt * a / 2, t - dt / 2, flow)
    d = wind(x - dt * a, t - dt, flow)
    return x - dt * (a + 4 * b + d) / 6


@answers("13.3")
def bracket_forgotten(x, t, dt, flow):
    """Only the first velocity is multiplied by the step; the others are added as they are. (13.5)
    has a bracket, and so must the code.
    """
    a = wind(x, t, flow)
    b = wind(x - dt * a / 2, t - dt / 2, flow)
    c = wind(x - dt * b / 2, t - dt / 2, flow)
    return x - dt / 6 * a + 2 * b + 2 * c + wind(x - dt * c, t - dt, flow)


@answers("13.3")
def went_forward(x, t, dt, flow):
    """The scheme is right, and runs the wrong way: these are the places where the particles will
    be. All signs are turned.
    """
    return four(x, t, -dt, flow)


# 13.5


@answers("13.5")
def without_the_polynomial(sites, feet, k):
    """The rows lack the polynomial of (13.7). Not even a constant comes back then: a field that
    is one everywhere would change in each step.
    """
    return matrix(sites, feet, k, polynomial=False)


@answers("13.5")
def another_power(sites, feet, k):
    """Distances are not raised to the power of (13.7), on both sides. The field has a kink at
    each site, and the hills get blunt.
    """
    return matrix(sites, feet, k, phi=lambda r: r)


@answers("13.5")
def the_farthest(sites, feet, k):
    """The sites that are farthest from the foot have the weights. In which order does `argsort`
    sort?
    """
    h = np.zeros((len(feet), len(sites)))
    for i, y in enumerate(feet):
        far = np.argsort(-np.linalg.norm(sites - y, axis=1))[:k]
        _, w = local_weights(sites[far], y, k)
        order = np.argsort(((sites[far] - y) ** 2).sum(axis=1))
        h[i, far[order]] = w
    return h


@answers("13.5")
def all_sites(sites, feet, k):
    """All sites have weights: k is not used. The answer is a good one, but costs the cube of the
    number of sites, and the matrix has no zeros.
    """
    return matrix(sites, feet, len(sites))


@answers("13.5")
def weights_in_the_first_columns(sites, feet, k):
    """The weights stand in the first k columns, whichever sites are near. Each belongs into the
    column of its own site.
    """
    h = np.zeros((len(feet), len(sites)))
    for i, y in enumerate(feet):
        h[i, :k] = local_weights(sites, y, k)[1]
    return h


@answers("13.5")
def nearest_site_only(sites, feet, k):
    """Each foot takes the value of its nearest site. That is a step function: after short steps
    each site would find itself again, and nothing would ever move.
    """
    h = np.zeros((len(feet), len(sites)))
    for i, y in enumerate(feet):
        h[i, np.argmin(np.linalg.norm(sites - y, axis=1))] = 1
    return h


@answers("13.5")
def mean_by_distance(sites, feet, k):
    """The k nearest sites count by the inverse of their distance. Nothing is solved, the weights
    are positive, and every peak is worn away: linear fields do not come back.
    """
    h = np.zeros((len(feet), len(sites)))
    for i, y in enumerate(feet):
        r = np.maximum(np.linalg.norm(sites - y, axis=1), 1e-30)
        near = np.argsort(r)[:k]
        h[i, near] = (1 / r[near]) / (1 / r[near]).sum()
    return h


# 13.6


def marched(sites, u, dt, steps, flow, k, feet, apply=lambda h, u: h @ u):
    fields = [u]
    for n in range(steps):
        fields.append(apply(matrix(sites, feet(n), k), fields[-1]))
    return np.array(fields)


@answers("13.6")
def time_of_departure(sites, u, dt, steps, flow, k):
    """The feet are traced back from the time at which the step begins. They go back from the time
    of arrival, one step later.
    """
    return marched(sites, u, dt, steps, flow, k, lambda n: right_feet(sites, n * dt, dt, flow))


@answers("13.6")
def time_stands_still(sites, u, dt, steps, flow, k):
    """The same matrix is used in every step, that of the first. Where the velocity changes with
    time so do the feet.
    """
    return marched(sites, u, dt, steps, flow, k, lambda n: right_feet(sites, dt, dt, flow))


@answers("13.6")
def wind_from_the_other_side(sites, u, dt, steps, flow, k):
    """The field moves against the flow: its new values are looked up where the particles will be,
    not where they were.
    """
    return marched(sites, u, dt, steps, flow, k, lambda n: right_feet(sites, n * dt, -dt, flow))


@answers("13.6")
def transposed(sites, u, dt, steps, flow, k):
    """The transpose of H is applied. It keeps sums, and moves things forward, but it deals each
    value out to the sites about the foot: constants do not stay. (13.6) collects.
    """
    return marched(
        sites,
        u,
        dt,
        steps,
        flow,
        k,
        lambda n: right_feet(sites, (n + 1) * dt, dt, flow),
        lambda h, u: h.T @ u,
    )


@answers("13.6")
def always_from_the_beginning(sites, u, dt, steps, flow, k):
    """Each row is one step from the field at the beginning. A step begins where the last one
    ended.
    """
    return marched(
        sites,
        u,
        dt,
        steps,
        flow,
        k,
        lambda n: right_feet(sites, (n + 1) * dt, dt, flow),
        lambda h, _: h @ u,
    )


@answers("13.6")
def straight_feet(sites, u, dt, steps, flow, k):
    """The feet are those of Euler's scheme. In a vortex they lie outside of the circle, and the
    field shrinks towards the middle. Use your `rk4`.
    """
    return marched(
        sites, u, dt, steps, flow, k, lambda n: sites - dt * wind(sites, (n + 1) * dt, flow)
    )


@answers("13.6")
def feet_of_feet(sites, u, dt, steps, flow, k):
    """The feet of the last step are traced back further, while the values have already been
    moved. The values now are values at the sites: each step begins at these.
    """
    y, fields = sites, [u]
    for n in range(steps):
        y = right_feet(y, (n + 1) * dt, dt, flow)
        fields.append(matrix(sites, y, k) @ fields[-1])
    return np.array(fields)


# 13.8


def around(sites, feet, count):
    return np.argsort(np.linalg.norm(feet[:, None] - sites, axis=2), axis=1)[:, :count]


@answers("13.8")
def of_all_sites(sites, u, feet):
    """These are the extrema of the whole field. Ripples in the middle of a hill would pass;
    (13.8) asks for those near the foot.
    """
    return np.full(len(feet), u.min()), np.full(len(feet), u.max())


@answers("13.8")
def of_the_nearest_alone(sites, u, feet):
    """Only one site is asked, so that both bounds are equal and nothing is left to reconstruct."""
    near = around(sites, feet, 1)[:, 0]
    return u[near], u[near]


@answers("13.8")
def three_sites(sites, u, feet):
    """Three sites are asked; (13.8) names how many there are. Look at what a slice with an end
    leaves out.
    """
    near = u[around(sites, feet, 3)]
    return near.min(axis=1), near.max(axis=1)


@answers("13.8")
def exchanged(sites, u, feet):
    """The upper bound is returned first. The docstring asks for l, then h; `np.clip` with
    exchanged bounds returns nonsense without a word.
    """
    near = u[around(sites, feet, 4)]
    return near.max(axis=1), near.min(axis=1)


@answers("13.8")
def of_the_extreme_values(sites, u, feet):
    """The field is sorted, not the distances: these are the extrema of the four smallest values,
    the same for every foot.
    """
    near = np.sort(u)[:4]
    return np.full(len(feet), near.min()), np.full(len(feet), near.max())


@answers("13.8")
def four_farthest(sites, u, feet):
    """The four sites farthest from the foot are asked. Nearest come first when distances are
    sorted.
    """
    near = u[around(sites, feet, len(sites))[:, -4:]]
    return near.min(axis=1), near.max(axis=1)


# 13.9


@answers("13.9")
def bounds_alone(u, low, high, m, total):
    """Values are put between their bounds, and the mass is left as it comes. The λ of (13.9) is
    missing.
    """
    return np.clip(u, low, high)


@answers("13.9")
def shifted_beyond_bounds(u, low, high, m, total):
    """The mass is right, and the bounds are forgotten: all values are shifted alike. Bounds and
    mass must hold together.
    """
    return u + (total - m @ u) / m.sum()


@answers("13.9")
def clipped_after_the_shift(u, low, high, m, total):
    """You shift for the mass first and clip then, which changes the mass again. λ has to be such
    that it is right *after* the clipping.
    """
    return np.clip(u + (total - m @ u) / m.sum(), low, high)


@answers("13.9")
def multiplied(u, low, high, m, total):
    """The field is multiplied by a factor. The mass is right, but large values change more than
    small ones, and those that are zero never; least change means that all are shifted alike.
    """
    return u * (total / (m @ u))


@answers("13.9")
def areas_ignored(u, low, high, m, total):
    """The values have the right sum, without their areas. Mass is value times area."""
    down, up = (low - u).min(), (high - u).max()
    wanted = total * len(m) / m.sum()
    for _ in range(80):
        middle = (down + up) / 2
        down, up = (middle, up) if np.clip(u + middle, low, high).sum() < wanted else (down, middle)
    return np.clip(u + middle, low, high)


@answers("13.9")
def changed_by_area(u, low, high, m, total):
    """The change is proportional to the area, λ m. That is the least change if all sites count
    alike; in the mean square with the weights m the areas cancel, see (13.9).
    """
    down, up = ((low - u) / m).min(), ((high - u) / m).max()
    for _ in range(80):
        middle = (down + up) / 2
        down, up = (
            (middle, up) if m @ np.clip(u + middle * m, low, high) < total else (down, middle)
        )
    return np.clip(u + middle * m, low, high)


@answers("13.9")
def moved_between_the_bounds(u, low, high, m, total):
    """All values are put at the same part of the way from their lower to their upper bound. Mass
    and bounds are right, but the field itself is forgotten: u should be changed as little as
    possible.
    """
    part = (total - m @ low) / (m @ (high - low))
    return low + part * (high - low)


# 13.11


def rounds_of(sites, u, dt, rounds, k, sign=-1.0, start=None):
    y = sites if start is None else start
    for _ in range(rounds):
        y = sites + sign * dt * (matrix(sites, y, k) @ u)[:, None]
    return y


@answers("13.11")
def velocity_of_arrival(sites, u, dt, rounds, k):
    """The velocity of the site is used, not that of the foot: one round only. What arrives here
    has the velocity of where it came from, and that is what the further rounds find out.
    """
    return sites - dt * u[:, None]


@answers("13.11")
def downstream(sites, u, dt, rounds, k):
    """These are the places at which the particles will be, with the sign of the step turned
    round.
    """
    return rounds_of(sites, u, dt, rounds, k, sign=1.0)


@answers("13.11")
def from_the_last_foot(sites, u, dt, rounds, k):
    """Each round goes back a whole step from the last foot. All the rounds look for the same
    foot: they begin at x each time.
    """
    y = sites
    for _ in range(rounds):
        y = y - dt * (matrix(sites, y, k) @ u)[:, None]
    return y


@answers("13.11")
def step_divided_by_the_rounds(sites, u, dt, rounds, k):
    """The step is cut into as many parts as there are rounds. Rounds are no steps: each of them
    uses the whole Δt, and they correct each other.
    """
    y = sites
    for _ in range(rounds):
        y = y - dt / rounds * (matrix(sites, y, k) @ u)[:, None]
    return y


@answers("13.11")
def one_round_too_many(sites, u, dt, rounds, k):
    """There is one round more than asked for: the beginning of (13.10) is x itself, and counts as
    none.
    """
    return rounds_of(sites, u, dt, rounds + 1, k)


@answers("13.11")
def values_at_the_feet(sites, u, dt, rounds, k):
    """These are the values that arrive, s at the feet. Asked for are the feet."""
    return (matrix(sites, rounds_of(sites, u, dt, rounds, k), k) @ u)[:, None]
