"""Mistakes in notebook 13, each with the sentence that the student reads."""

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


def local_weights(sites, feet, k, phi=lambda r: r**3, polynomial=True):
    """The numbers of the k sites nearest to each foot, and their weights."""
    near = np.argsort(((sites - feet[:, None]) ** 2).sum(axis=2), axis=1)[:, :k]
    z = sites[near] - feet[:, None]
    m, d = feet.shape
    size = k + polynomial * (1 + d)
    a, b = np.zeros((m, size, size)), np.zeros((m, size))
    a[:, :k, :k] = phi(np.linalg.norm(z[:, :, None] - z[:, None], axis=3))
    b[:, :k] = phi(np.linalg.norm(z, axis=2))
    if polynomial:
        a[:, :k, k] = a[:, k, :k] = b[:, k] = 1
        a[:, :k, k + 1 :] = z
        a[:, k + 1 :, :k] = z.transpose(0, 2, 1)
    return near, np.linalg.solve(a, b[..., None])[:, :k, 0]


def matrix(sites, feet, k, **how):
    h = np.zeros((len(feet), len(sites)))
    near, w = local_weights(sites, feet, k, **how)
    np.put_along_axis(h, near, w, axis=1)
    return h


# 13.1


@answers("13.1")
def forward(x, t, dt, flow):
    """The points are moved forward, to where the particles will be. Departure points lie back in
    time: check the sign in (13.3).
    """
    return x + dt * wind(x, t, flow)


@answers("13.1")
def the_way_only(x, t, dt, flow):
    """This is the displacement of the particle, not its departure point. In (13.3) it is subtracted
    from x.
    """
    return -dt * wind(x, t, flow)


@answers("13.1")
def velocity_of_the_time_before(x, t, dt, flow):
    """The velocity is taken at the time t − Δt. (13.3) uses the velocity at the time t. In the
    flows 1 and 2 they differ.
    """
    return x - dt * wind(x, t - dt, flow)


@answers("13.1")
def direction_only(x, t, dt, flow):
    """The velocity was divided by its length, so all points move equally far. (13.3) uses the
    velocity itself.
    """
    a = wind(x, t, flow)
    return x - dt * a / np.linalg.norm(a, axis=1)[:, None]


@answers("13.1")
def step_forgotten(x, t, dt, flow):
    """The velocity was subtracted without the factor Δt. A displacement is velocity times time."""
    return x - wind(x, t, flow)


@answers("13.1")
def always_at_time_zero(x, t, dt, flow):
    """The velocity is taken at the time 0, whatever t is. In two of the flows it
    depends on time.
    """
    return x - dt * wind(x, 0.0, flow)


@answers("13.1")
def always_in_flow_zero(x, t, dt, flow):
    """The velocity is that of flow 0, whatever the argument `flow` is. Pass it to `velocity`."""
    return x - dt * wind(x, t, 0)


@answers("13.1")
def truncated_feet(x, t, dt, flow):
    """The points are integers, and the array of the feet has the same type: `np.zeros_like`,
    `np.empty_like` and `x.copy()` keep it. NumPy then removes all digits after the decimal point.
    Make an array of floats, with `np.zeros(x.shape)`.
    """
    return (x - dt * wind(x, t, flow)).astype(x.dtype)


# 13.2


@answers("13.2")
def time_not_halved(x, t, dt, flow):
    """The second velocity is taken at the midpoint, but at the time t. In (13.4) its time is t −
    Δt/2.
    """
    return x - dt * wind(x - dt / 2 * wind(x, t, flow), t, flow)


@answers("13.2")
def place_not_halved(x, t, dt, flow):
    """The second velocity is taken at Euler's foot and not at the midpoint."""
    return x - dt * wind(x - dt * wind(x, t, flow), t - dt / 2, flow)


@answers("13.2")
def time_went_forward(x, t, dt, flow):
    """The midpoint is back in space, but its time is t + Δt/2. In (13.4) its time is t − Δt/2."""
    return x - dt * wind(x - dt / 2 * wind(x, t, flow), t + dt / 2, flow)


@answers("13.2")
def midpoint_ahead(x, t, dt, flow):
    """The midpoint lies ahead: half a step was added to x and not subtracted. Check the signs in
    (13.4).
    """
    return x - dt * wind(x + dt / 2 * wind(x, t, flow), t - dt / 2, flow)


@answers("13.2")
def half_a_step_with_the_second(x, t, dt, flow):
    """The last step has half the length. The velocity at the midpoint is used for the whole step
    from x.
    """
    return x - dt / 2 * wind(x - dt / 2 * wind(x, t, flow), t - dt / 2, flow)


@answers("13.2")
def went_on_from_the_middle(x, t, dt, flow):
    """The last step begins at the midpoint, so the way is one and a half steps long. It must begin
    at x.
    """
    middle = x - dt / 2 * wind(x, t, flow)
    return middle - dt * wind(middle, t - dt / 2, flow)


@answers("13.2")
def two_halves_of_euler(x, t, dt, flow):
    """These are the values of two steps of Euler's scheme, each of half the length. (13.4) makes
    one whole step from x with the second velocity alone.
    """
    middle = x - dt / 2 * wind(x, t, flow)
    return middle - dt / 2 * wind(middle, t - dt / 2, flow)


@answers("13.2")
def mean_of_both_ends(x, t, dt, flow):
    """This is Heun's scheme: the mean of the velocities at both ends. (13.4) uses the velocity at
    the midpoint.
    """
    a = wind(x, t, flow)
    return x - dt / 2 * (a + wind(x - dt * a, t - dt, flow))


@answers("13.2")
def midpoint_forward(x, t, dt, flow):
    """The scheme is right but goes forward in time. Check the signs in (13.4)."""
    return x + dt * wind(x + dt / 2 * wind(x, t, flow), t + dt / 2, flow)


@answers("13.2")
def truncated_feet_of_the_midpoint(x, t, dt, flow):
    """The points are integers, and the array of the feet has the same type: `np.zeros_like`,
    `np.empty_like` and `x.copy()` keep it. NumPy then removes all digits after the decimal point.
    Make an array of floats, with `np.zeros(x.shape)`.
    """
    return (x - dt * wind(x - dt / 2 * wind(x, t, flow), t - dt / 2, flow)).astype(x.dtype)


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
    """The four velocities have equal weights. In (13.5) the second and the third have
    the factor 2.
    """
    return four(x, t, dt, flow, weights=(0.25,) * 4)


@answers("13.3")
def divided_by_four(x, t, dt, flow):
    """The sum was divided by 4. The factors in the bracket of (13.5) sum to 6."""
    return four(x, t, dt, flow, weights=(0.25, 0.5, 0.5, 0.25))


@answers("13.3")
def times_forgotten(x, t, dt, flow):
    """All velocities are taken at the time t. Each stage of (13.5) has its own time."""
    return four(x, t, dt, flow, times=(0, 0, 0, 0))


@answers("13.3")
def times_ahead(x, t, dt, flow):
    """The points go back, but the times of the stages go forward: t + Δt/2 and t + Δt. The
    particle was at these points before the time t.
    """
    return four(x, t, dt, flow, times=(0, -0.5, -0.5, -1))


@answers("13.3")
def third_stage_like_the_second(x, t, dt, flow):
    """The third velocity might as well be the second again. In (13.5) each stage uses the velocity
    of the stage before.
    """
    a = wind(x, t, flow)
    b = wind(x - dt * a / 2, t - dt / 2, flow)
    return x - dt * (a + 4 * b + wind(x - dt * b, t - dt, flow)) / 6


@answers("13.3")
def last_stage_half_way(x, t, dt, flow):
    """The fourth velocity is taken half a step back. In (13.5) its point is a whole step back."""
    return four(x, t, dt, flow, parts=(0, 0.5, 0.5, 0.5))


@answers("13.3")
def last_time_half_way(x, t, dt, flow):
    """The fourth velocity is taken at the time t − Δt/2. In (13.5) its time is t − Δt."""
    return four(x, t, dt, flow, times=(0, 0.5, 0.5, 0.5))


@answers("13.3")
def first_velocity_everywhere(x, t, dt, flow):
    """All points are computed with the first velocity. In (13.5) each stage uses the velocity of
    the stage before.
    """
    a = wind(x, t, flow)
    b = wind(x - dt * a / 2, t - dt / 2, flow)
    d = wind(x - dt * a, t - dt, flow)
    return x - dt * (a + 4 * b + d) / 6


@answers("13.3")
def bracket_forgotten(x, t, dt, flow):
    """Only the first velocity was multiplied by Δt/6. In (13.5) the factor applies to the whole
    bracket.
    """
    a = wind(x, t, flow)
    b = wind(x - dt * a / 2, t - dt / 2, flow)
    c = wind(x - dt * b / 2, t - dt / 2, flow)
    return x - dt / 6 * a + 2 * b + 2 * c + wind(x - dt * c, t - dt, flow)


@answers("13.3")
def went_forward(x, t, dt, flow):
    """The scheme is right but goes forward in time. Check the signs in (13.5)."""
    return four(x, t, -dt, flow)


@answers("13.3")
def truncated_feet_of_four_stages(x, t, dt, flow):
    """The points are integers, and the array of the feet has the same type: `np.zeros_like`,
    `np.empty_like` and `x.copy()` keep it. NumPy then removes all digits after the decimal point.
    Make an array of floats, with `np.zeros(x.shape)`.
    """
    return (right_feet(x, t, dt, flow)).astype(x.dtype)


# 13.5


@answers("13.5")
def without_the_polynomial(sites, feet, k):
    """The polynomial of (13.7) is missing. Then constants are not reproduced, and a constant field
    would change in each step.
    """
    return matrix(sites, feet, k, polynomial=False)


@answers("13.5")
def another_power(sites, feet, k):
    """The kernel is the distance itself. (13.7) uses the cube of the distance, on both sides."""
    return matrix(sites, feet, k, phi=lambda r: r)


def with_powers(sites, feet, k, left, right):
    """The weights with one power of the distances on each side of (13.7)."""
    h = np.zeros((len(feet), len(sites)))
    for i, y in enumerate(feet):
        near = np.argsort(np.linalg.norm(sites - y, axis=1))[:k]
        z = sites[near] - y
        p = np.insert(z, 0, 1.0, axis=1)
        a = np.linalg.norm(z[:, None] - z, axis=2) ** left
        system = np.block([[a, p], [p.T, np.zeros((p.shape[1], p.shape[1]))]])
        b = np.concatenate([np.linalg.norm(z, axis=1) ** right, [1], 0 * y])
        h[i, near] = np.linalg.solve(system, b)[:k]
    return h


@answers("13.5")
def distances_on_the_right(sites, feet, k):
    """The right-hand side has the distances, and the matrix their cubes. (13.7) has the cubes on
    both sides.
    """
    return with_powers(sites, feet, k, 3, 1)


@answers("13.5")
def squares_on_the_right(sites, feet, k):
    """The right-hand side has the squared distances, and the matrix their cubes. (13.7) has the
    cubes on both sides.
    """
    return with_powers(sites, feet, k, 3, 2)


@answers("13.5", named=False)
def foot_not_made_the_origin(sites, feet, k):
    """Far from the origin the coordinates of the foot and of the sites lose their digits."""
    h = np.zeros((len(feet), len(sites)))
    for i, y in enumerate(feet):
        r = np.linalg.norm(sites - y, axis=1)
        near = np.argsort(r)[:k]
        z = sites[near]
        p = np.insert(z.astype(float), 0, 1.0, axis=1)
        a = np.linalg.norm(z[:, None] - z, axis=2) ** 3
        system = np.block([[a, p], [p.T, np.zeros((p.shape[1], p.shape[1]))]])
        h[i, near] = np.linalg.solve(system, np.concatenate([r[near] ** 3, [1], y]))[:k]
    return h


@answers("13.5", named=False)
def neighbours_by_expanded_squares(sites, feet, k):
    """Far from the origin the squares lose the digits that decide which site is nearer."""
    h = np.zeros((len(feet), len(sites)))
    for i, y in enumerate(feet):
        near = np.argsort((sites**2).sum(axis=1) - 2 * sites @ y)[:k]
        order, w = local_weights(sites[near], y[None], k)
        h[i, near[order]] = w
    return h


@answers("13.5")
def the_farthest(sites, feet, k):
    """The sites farthest from the foot have the weights. `argsort` sorts in increasing order."""
    h = np.zeros((len(feet), len(sites)))
    for i, y in enumerate(feet):
        far = np.argsort(-np.linalg.norm(sites - y, axis=1))[:k]
        near, w = local_weights(sites[far], y[None], k)
        h[i, far[near]] = w
    return h


@answers("13.5")
def all_sites(sites, feet, k):
    """All sites have weights: k was not used. By (13.7) only the k nearest sites have weights."""
    return matrix(sites, feet, len(sites))


@answers("13.5")
def weights_in_the_first_columns(sites, feet, k):
    """The weights are in the first k columns. Each weight belongs in the column of its site."""
    h = np.zeros((len(feet), len(sites)))
    h[:, :k] = local_weights(sites, feet, k)[1]
    return h


@answers("13.5")
def nearest_site_only(sites, feet, k):
    """Each foot has the value of its nearest site. (13.7) requires the solution of a system for the
    k nearest sites.
    """
    h = np.zeros((len(feet), len(sites)))
    for i, y in enumerate(feet):
        h[i, np.argmin(np.linalg.norm(sites - y, axis=1))] = 1
    return h


@answers("13.5")
def mean_by_distance(sites, feet, k):
    """The weights are inverse distances, and no system was solved. Then linear fields are not
    reproduced.
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
    """The departure points were computed from the time at the beginning of the step. They belong to
    the time of arrival, (n + 1)Δt.
    """
    return marched(sites, u, dt, steps, flow, k, lambda n: right_feet(sites, n * dt, dt, flow))


@answers("13.6")
def time_stands_still(sites, u, dt, steps, flow, k):
    """Every step used the departure points of the same time. If the velocity depends on time, they
    differ from step to step.
    """
    return marched(sites, u, dt, steps, flow, k, lambda n: right_feet(sites, dt, dt, flow))


@answers("13.6")
def wind_from_the_other_side(sites, u, dt, steps, flow, k):
    """The field moves against the flow: the points were traced forward in time."""
    return marched(sites, u, dt, steps, flow, k, lambda n: right_feet(sites, n * dt, -dt, flow))


@answers("13.6")
def transposed(sites, u, dt, steps, flow, k):
    """The transpose of H was applied. In (13.6) row i of H gives the new value of site i."""
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
def one_array_in_all_rows(sites, u, dt, steps, flow, k):
    """All rows after the first are equal to the last field. If one array is changed in place and
    appended again and again, the list holds the same array many times: append a copy.
    """
    fields = marched(
        sites, u, dt, steps, flow, k, lambda n: right_feet(sites, (n + 1) * dt, dt, flow)
    )
    return np.vstack([u, *steps * [fields[-1]]])


@answers("13.6")
def always_from_the_beginning(sites, u, dt, steps, flow, k):
    """Each row is one step from the initial field. A step must begin with the result of the step
    before.
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
    """The departure points are those of Euler's scheme. Use your `rk4`."""
    return marched(
        sites, u, dt, steps, flow, k, lambda n: sites - dt * wind(sites, (n + 1) * dt, flow)
    )


@answers("13.6")
def feet_of_feet(sites, u, dt, steps, flow, k):
    """The departure points of the last step were traced back further. In each step they begin at
    the sites.
    """
    y, fields = sites, [u]
    for n in range(steps):
        y = right_feet(y, (n + 1) * dt, dt, flow)
        fields.append(matrix(sites, y, k) @ fields[-1])
    return np.array(fields)


@answers("13.6")
def forward_from_the_arrival(sites, u, dt, steps, flow, k):
    """The field moves against the flow: the points were traced forward in time, beginning at the
    time of arrival.
    """
    return marched(
        sites, u, dt, steps, flow, k, lambda n: right_feet(sites, (n + 1) * dt, -dt, flow)
    )


# 13.8


def around(sites, feet, count):
    return np.argsort(np.linalg.norm(feet[:, None] - sites, axis=2), axis=1)[:, :count]


@answers("13.8")
def of_all_sites(sites, u, feet):
    """These are the extreme values of the whole field. (13.8) uses four sites only."""
    return np.full(len(feet), u.min()), np.full(len(feet), u.max())


@answers("13.8", named=False)
def distances_rounded(sites, u, feet):
    """Distances rounded to twelve decimals are equal in small units of length."""
    r = np.round(np.linalg.norm(feet[:, None] - sites, axis=2), 12)
    near = u[np.argsort(r, axis=1)[:, :4]]
    return near.min(axis=1), near.max(axis=1)


@answers("13.8")
def of_the_nearest_alone(sites, u, feet):
    """Only one site was used, so both bounds are equal. (13.8) uses four sites."""
    near = around(sites, feet, 1)[:, 0]
    return u[near], u[near]


@answers("13.8")
def three_sites(sites, u, feet):
    """Three sites were used. (13.8) uses four sites; a slice does not include its end."""
    near = u[around(sites, feet, 3)]
    return near.min(axis=1), near.max(axis=1)


@answers("13.8")
def exchanged(sites, u, feet):
    """The upper bound was returned first. The question asks for the lower bound first."""
    near = u[around(sites, feet, 4)]
    return near.max(axis=1), near.min(axis=1)


@answers("13.8")
def of_the_extreme_values(sites, u, feet):
    """The values were sorted, so these are extreme values of the four smallest values, not of
    those at the nearest sites.
    """
    near = np.sort(u)[:4]
    return np.full(len(feet), near.min()), np.full(len(feet), near.max())


@answers("13.8")
def zero_counted_among_the_values(sites, u, feet):
    """Zero is counted as if it were a fifth value, so the lower bound is never positive and the
    upper one never negative. Where does the search for the smallest and the largest value begin?
    """
    near = u[around(sites, feet, 4)]
    return np.minimum(near.min(axis=1), 0), np.maximum(near.max(axis=1), 0)


@answers("13.8")
def four_farthest(sites, u, feet):
    """The four sites farthest from the foot were used. Sorting gives the smallest
    distances first.
    """
    near = u[around(sites, feet, len(sites))[:, -4:]]
    return near.min(axis=1), near.max(axis=1)


@answers("13.8")
def five_sites(sites, u, feet):
    """Five sites were used. (13.8) uses four sites."""
    near = u[around(sites, feet, 5)]
    return near.min(axis=1), near.max(axis=1)


@answers("13.8")
def around_the_nearest_site(sites, u, feet):
    """These are the extreme values around the *site* nearest to the foot. (13.8) uses the four
    sites nearest to the foot itself.
    """
    near = u[around(sites, sites[around(sites, feet, 1)[:, 0]], 4)]
    return near.min(axis=1), near.max(axis=1)


# 13.9


def halved(u, low, high, m, total, a, b, along=1.0):
    """Bisection for the multiple of a change, between a and b, that gives the right mass."""
    for _ in range(100):
        middle = (a + b) / 2
        if m @ np.clip(u + middle * along, low, high) < total:
            a = middle
        else:
            b = middle
    return np.clip(u + (a + b) / 2 * along, low, high)


@answers("13.9")
def bounds_alone(u, low, high, m, total):
    """The values were restricted to their bounds, but the mass was not corrected: λ of (13.9) is
    missing.
    """
    return np.clip(u, low, high)


@answers("13.9")
def shifted_beyond_bounds(u, low, high, m, total):
    """The mass is right, but the bounds do not hold: all values were changed by the
    same number.
    """
    return u + (total - m @ u) / m.sum()


@answers("13.9")
def clipped_after_the_shift(u, low, high, m, total):
    """The values were shifted to the right mass and then restricted to the bounds, which changes
    the mass again. The mass must be right *after* the restriction.
    """
    return np.clip(u + (total - m @ u) / m.sum(), low, high)


@answers("13.9")
def multiplied(u, low, high, m, total):
    """The field was multiplied by a factor. (13.9) adds the same λ to all values and applies the
    bounds.
    """
    return u * (total / (m @ u))


@answers("13.9")
def areas_ignored(u, low, high, m, total):
    """The plain mean of the values is M / Σm, but the areas m are missing: mass is value times
    area.
    """
    return halved(
        u, low, high, np.ones(len(m)), total * len(m) / m.sum(), (low - u).min(), (high - u).max()
    )


@answers("13.9")
def sum_of_the_values(u, low, high, m, total):
    """The plain sum of the values is the required mass, or as near to it as the bounds allow. In
    (13.9) each value is multiplied by its area m.
    """
    return halved(u, low, high, np.ones(len(m)), total, (low - u).min(), (high - u).max())


@answers("13.9")
def changed_by_area(u, low, high, m, total):
    """The change is proportional to the area. In (13.9) the same λ is added to all values."""
    return halved(u, low, high, m, total, ((low - u) / m).min(), ((high - u) / m).max(), along=m)


@answers("13.9")
def moved_between_the_bounds(u, low, high, m, total):
    """Mass and bounds are right, but u was not used: all values are at the same fraction between
    their bounds.
    """
    part = (total - m @ low) / (m @ (high - low))
    return low + part * (high - low)


@answers("13.9", named=False)
def shift_between_minus_one_and_one(u, low, high, m, total):
    """The shift λ of (13.9) may be larger than 1 in absolute value."""
    return halved(u, low, high, m, total, -1.0, 1.0)


@answers("13.9", named=False)
def shift_of_at_most_a_half(u, low, high, m, total):
    """The shift λ of (13.9) may be larger than 1/2 in absolute value."""
    return halved(u, low, high, m, total, -0.5, 0.5)


@answers("13.9", named=False)
def shift_below_a_billion(u, low, high, m, total):
    """The shift λ of (13.9) may be larger than any fixed number: values may be of any size."""
    return halved(u, low, high, m, total, -1e9, 1e9)


@answers("13.9", named=False)
def shift_within_the_range_of_the_values(u, low, high, m, total):
    """The shift may be larger than the range of the values."""
    return halved(u, low, high, m, total, -np.ptp(u), np.ptp(u))


@answers("13.9", named=False)
def shift_within_the_width_of_the_bounds(u, low, high, m, total):
    """Values may be farther from their bounds than the bounds from each other."""
    return halved(u, low, high, m, total, (low - high).min(), (high - low).max())


# 13.11


def rounds_of(sites, u, dt, rounds, k, sign=-1.0, start=None):
    y = sites if start is None else start
    for _ in range(rounds):
        y = sites + sign * dt * (matrix(sites, y, k) @ u)[:, None]
    return y


@answers("13.11")
def velocity_of_arrival(sites, u, dt, rounds, k):
    """The result is the same as after one round, whatever the number of rounds. Either there is one
    round only, or the velocity is taken at the site in every round. In (13.10) it is taken at the
    last approximation of the departure point.
    """
    return sites - dt * u[:, None]


@answers("13.11")
def downstream(sites, u, dt, rounds, k):
    """The points are moved forward, with the flow. Check the sign in (13.10)."""
    return rounds_of(sites, u, dt, rounds, k, sign=1.0)


@answers("13.11")
def from_the_last_foot(sites, u, dt, rounds, k):
    """Each round goes back a whole step from the last approximation. In (13.10) each round begins
    at x.
    """
    y = sites
    for _ in range(rounds):
        y = y - dt * (matrix(sites, y, k) @ u)[:, None]
    return y


@answers("13.11")
def step_divided_by_the_rounds(sites, u, dt, rounds, k):
    """The step was divided into as many parts as there are rounds. In (13.10) each round uses the
    whole Δt and begins at x.
    """
    return from_the_last_foot(sites, u, dt / max(rounds, 1), rounds, k)


@answers("13.11")
def one_round_too_many(sites, u, dt, rounds, k):
    """There is one round too many. The first approximation y⁰ = x counts as no round."""
    return rounds_of(sites, u, dt, rounds + 1, k)


@answers("13.11")
def values_at_the_feet(sites, u, dt, rounds, k):
    """These are the values at the departure points. Return the departure points themselves."""
    return (matrix(sites, rounds_of(sites, u, dt, rounds, k), k) @ u)[:, None]
