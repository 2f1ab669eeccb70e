"""Right answers to notebook 13, written in other ways."""

import numpy as np

from fieldgrade.authoring.catalogue import answers


def wind(y, t, flow):
    """The velocity of the notebook at one place or many."""
    p, q = y[..., 0], y[..., 1]
    if flow == 2:
        a = np.array(
            [
                np.cos(np.pi * p / 2) ** 2 * np.sin(np.pi * q),
                -(np.cos(np.pi * q / 2) ** 2) * np.sin(np.pi * p),
            ]
        )
        return np.moveaxis(3 * np.cos(np.pi * t) * a, 0, -1)
    rate = (1 + t) / (1 + 4 * (p**2 + q**2)) if flow == 1 else 1 + 0 * p
    return np.moveaxis(2 * np.pi * rate * np.array([-q, p]), 0, -1)


def feet_by_table(x, t, dt, flow, table, weights):
    """An explicit scheme given by its table."""
    slopes = []
    for row in table:
        place = x - dt * sum((part * s for part, s in zip(row, slopes)), np.zeros_like(x))
        slopes.append(wind(place, t - dt * sum(row), flow))
    return x - dt * np.tensordot(weights, np.array(slopes), axes=1)


def solved_row(sites, near, y):
    """The weights of some sites, by the matrix of (13.7) entry by entry."""
    z = sites[near] - y
    k, d = z.shape
    a, b = np.zeros((k + d + 1, k + d + 1)), np.zeros(k + d + 1)
    for i in range(k):
        for j in range(k):
            a[i, j] = np.sqrt(((z[i] - z[j]) ** 2).sum()) ** 3
        a[i, k:] = a[k:, i] = np.r_[1, z[i]]
        b[i] = np.sqrt((z[i] ** 2).sum()) ** 3
    b[k] = 1  # and zeros for the foot, which is the origin
    return np.linalg.solve(a, b)[:k]


# 13.1


@answers("13.1")
def particle_by_particle(x, t, dt, flow):
    feet = np.empty(x.shape)
    for i in range(len(x)):
        feet[i] = x[i] - dt * wind(x[i], t, flow)
    return feet


@answers("13.1")
def by_its_table(x, t, dt, flow):
    return feet_by_table(x, t, dt, flow, [()], [1.0])


@answers("13.1")
def forward_with_a_negative_step(x, t, dt, flow):
    step = -dt
    return step * wind(x, t, flow) + x


# 13.2


@answers("13.2")
def midpoint_by_its_table(x, t, dt, flow):
    return feet_by_table(x, t, dt, flow, [(), (0.5,)], [0.0, 1.0])


@answers("13.2")
def midpoint_in_a_loop(x, t, dt, flow):
    feet = []
    for p in x:
        q = p - 0.5 * dt * wind(p, t, flow)
        feet.append(p - dt * wind(q, t - 0.5 * dt, flow))
    return np.array(feet)


@answers("13.2")
def mirrored_at_the_middle(x, t, dt, flow):
    half = 0.5 * dt
    middle = x - half * wind(x, t, flow)
    return x - 2 * half * wind(middle, t - half, flow)


# 13.3


@answers("13.3")
def classical_by_its_table(x, t, dt, flow):
    return feet_by_table(
        x, t, dt, flow, [(), (0.5,), (0, 0.5), (0, 0, 1)], np.array([1, 2, 2, 1]) / 6
    )


@answers("13.3")
def ways_instead_of_velocities(x, t, dt, flow):
    k1 = -dt * wind(x, t, flow)
    k2 = -dt * wind(x + 0.5 * k1, t - 0.5 * dt, flow)
    k3 = -dt * wind(x + 0.5 * k2, t - 0.5 * dt, flow)
    k4 = -dt * wind(x + k3, t - dt, flow)
    return x + k1 / 6 + k2 / 3 + k3 / 3 + k4 / 6


@answers("13.3")
def from_its_intermediate_places(x, t, dt, flow):
    p = x - dt / 2 * wind(x, t, flow)
    q = x - dt / 2 * wind(p, t - dt / 2, flow)
    r = x - dt * wind(q, t - dt / 2, flow)
    return (-x + p + 2 * q + r - dt / 2 * wind(r, t - dt, flow)) / 3


# 13.5


@answers("13.5")
def entry_by_entry(sites, feet, k):
    h = np.zeros((len(feet), len(sites)))
    for i, y in enumerate(feet):
        near = sorted(range(len(sites)), key=lambda j: float(((sites[j] - y) ** 2).sum()))[:k]
        for j, w in zip(near, solved_row(sites, near, y)):
            h[i, j] = w
    return h


@answers("13.5")
def all_systems_at_once(sites, feet, k):
    r = np.linalg.norm(feet[:, None] - sites, axis=2)
    near = np.argpartition(r, k - 1, axis=1)[:, :k]
    z = sites[near] - feet[:, None]
    m, _, d = z.shape
    a, b = np.zeros((m, k + d + 1, k + d + 1)), np.zeros((m, k + d + 1, 1))
    a[:, :k, :k] = np.linalg.norm(z[:, :, None] - z[:, None], axis=3) ** 3
    a[:, :k, k] = a[:, k, :k] = 1
    a[:, :k, k + 1 :] = z
    a[:, k + 1 :, :k] = z.transpose(0, 2, 1)
    b[:, :k, 0] = np.take_along_axis(r, near, axis=1) ** 3
    b[:, k, 0] = 1
    h = np.zeros(r.shape)
    np.put_along_axis(h, near, np.linalg.solve(a, b)[:, :k, 0], axis=1)
    return h


@answers("13.5")
def by_fields_of_unit_values(sites, feet, k):
    h = np.zeros((len(feet), len(sites)))
    for i, y in enumerate(feet):
        near = np.argsort(np.linalg.norm(sites - y, axis=1))[:k]
        z = sites[near] - y
        p = np.column_stack([np.ones(k), z])
        phi = np.linalg.norm(z[:, None] - z, axis=2) ** 3
        whole = np.block([[phi, p], [p.T, np.zeros((p.shape[1], p.shape[1]))]])
        c = np.linalg.solve(whole, np.eye(k + p.shape[1])[:, :k])
        h[i, near] = np.linalg.norm(z, axis=1) ** 3 @ c[:k] + c[k]
    return h


# 13.6


def classical(x, t, dt, flow):
    return classical_by_its_table(x, t, dt, flow)


@answers("13.6")
def row_by_row(sites, u, dt, steps, flow, k):
    result = np.zeros((steps + 1, len(sites)))
    result[0] = u
    for n in range(1, steps + 1):
        result[n] = (
            all_systems_at_once(sites, classical(sites, n * dt, dt, flow), k) @ result[n - 1]
        )
    return result


@answers("13.6")
def time_counted_along(sites, u, dt, steps, flow, k):
    t, now, found = 0.0, u.copy(), [u]
    while len(found) <= steps:
        t += dt
        now = entry_by_entry(sites, classical(sites, t, dt, flow), k).dot(now)
        found.append(now)
    return np.stack(found)


@answers("13.6")
def by_products_of_matrices(sites, u, dt, steps, flow, k):
    whole = np.eye(len(sites))
    found = [u]
    for n in range(steps):
        feet = ways_instead_of_velocities(sites, dt * (n + 1), dt, flow)
        whole = by_fields_of_unit_values(sites, feet, k) @ whole
        found.append(whole @ u)
    return np.array(found)


# 13.8


@answers("13.8")
def foot_by_foot(sites, u, feet):
    low, high = [], []
    for y in feet:
        near = np.argsort(((sites - y) ** 2).sum(axis=1))[:4]
        low.append(u[near].min())
        high.append(u[near].max())
    return np.array(low), np.array(high)


@answers("13.8")
def by_partition(sites, u, feet):
    squares = ((feet[:, None] - sites) ** 2).sum(axis=2)
    near = np.argpartition(squares, 3, axis=1)[:, :4]
    return u[near].min(axis=1), u[near].max(axis=1)


@answers("13.8")
def as_one_array(sites, u, feet):
    r = np.hypot(*(feet[:, :, None] - sites.T[None]).transpose(1, 0, 2))
    reach = np.sort(r, axis=1)[:, [3]]
    inside = r <= reach
    return np.array(
        [np.where(inside, u, np.inf).min(axis=1), np.where(inside, u, -np.inf).max(axis=1)]
    )


# 13.9


@answers("13.9")
def by_halving(u, low, high, m, total):
    down, up = (low - u).min(), (high - u).max()
    for _ in range(60):
        shift = (down + up) / 2
        v = np.clip(u + shift, low, high)
        if m @ v < total:
            down = shift
        else:
            up = shift
    return v


@answers("13.9")
def by_newton(u, low, high, m, total):
    v = np.clip(u, low, high)
    free = np.ones(len(u), bool)
    shift = 0.0
    down, up = (low - u).min(), (high - u).max()
    for _ in range(200):
        v = np.clip(u + shift, low, high)
        off = total - m @ v
        if off > 0:
            down = shift
        else:
            up = shift
        free = (u + shift > low) & (u + shift < high)
        step = off / m[free].sum() if free.any() else np.inf
        shift = shift + step if down < shift + step < up else (down + up) / 2
    return v


@answers("13.9")
def by_the_secant(u, low, high, m, total):
    def missing(shift):
        return m @ np.minimum(np.maximum(u + shift, low), high) - total

    a, b = np.min(low - u), np.max(high - u)
    for _ in range(200):
        c = (a + b) / 2
        a, b = (c, b) if missing(c) < 0 else (a, c)
        inside = b - a > 1e-15 and missing(b) > missing(a)
        c = a - missing(a) * (b - a) / (missing(b) - missing(a)) if inside else c
        if inside and a < c < b:
            a, b = (c, b) if missing(c) < 0 else (a, c)
    return np.minimum(np.maximum(u + b, low), high)


# 13.11


@answers("13.11")
def site_by_site(sites, u, dt, rounds, k):
    feet = []
    for x in sites:
        y = x
        for _ in range(rounds):
            near = np.argsort(np.abs(sites[:, 0] - y[0]))[:k]
            y = x - dt * (solved_row(sites, near, y) @ u[near])
        feet.append(y)
    return np.array(feet)


@answers("13.11")
def by_recursion(sites, u, dt, rounds, k):
    if rounds == 0:
        return sites
    before = by_recursion(sites, u, dt, rounds - 1, k)
    return sites - dt * all_systems_at_once(sites, before, k) @ u[:, None]


@answers("13.11")
def by_corrections(sites, u, dt, rounds, k):
    y = sites.copy()
    for _ in range(rounds):
        speed = by_fields_of_unit_values(sites, y, k) @ u
        y = y + (sites - dt * speed.reshape(-1, 1) - y)
    return y
