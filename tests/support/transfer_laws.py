"""Laws that a coupling of two meshes must satisfy, each a plain function of a coupling."""

import numpy as np

from fieldrecon.coupling.rigid_body_motions import net_force_and_moment, rigid_motions
from fieldrecon.coupling.transfer import Transfer
from laws import VISIBLE, assert_close

CLOSE = 1e-9


def loads_on(t: Transfer) -> np.ndarray:
    """Loads of size one on the surface, (m, d)."""
    m, d = t.surface.shape
    return np.random.default_rng(m).normal(size=(m, d)) / np.sqrt(m)


def work_is_kept(t: Transfer) -> None:
    """(C u, f) = (u, C^T f) for any displacement, a rigid motion or not."""
    f = loads_on(t)
    u = np.cos(7 * t.structure) + t.structure**2
    assert_close((t.displacements(u) * f).sum(), (u * t.loads(f)).sum(), CLOSE)


def forces_are_kept_if_and_only_if_translations_come_back(t: Transfer) -> None:
    """Whether they do is asked of the displacements, and what follows of the loads."""
    d = t.structure.shape[1]
    motions_and_resultants_agree(t, slice(0, d))


def moments_are_kept_if_and_only_if_rotations_come_back(t: Transfer) -> None:
    """About the origin."""
    d = t.structure.shape[1]
    motions_and_resultants_agree(t, slice(d, None))


def motions_and_resultants_agree(t: Transfer, which: slice) -> None:
    f = loads_on(t)
    here = t.displacements(rigid_motions(t.structure)[..., which])
    motion_missed = np.abs(here - rigid_motions(t.surface)[..., which]).max()
    missed = (net_force_and_moment(t.surface, f) - net_force_and_moment(t.structure, t.loads(f)))[
        which
    ]
    if motion_missed < CLOSE:
        assert_close(missed, np.zeros_like(missed), CLOSE)
    else:
        assert motion_missed > VISIBLE
        assert np.abs(missed).max() > VISIBLE


def what_is_lost_is_known_beforehand(t: Transfer) -> None:
    """`defects`, about any point, without the loads on the structure."""
    f, about = loads_on(t), np.full(t.structure.shape[1], 0.3)
    lost = net_force_and_moment(t.surface, f, about) - net_force_and_moment(
        t.structure, t.loads(f), about
    )
    assert_close(t.defects(f, about), lost, CLOSE)


def parts_get_what_parts_give(t: Transfer) -> None:
    """The shares of a part of the surface are its net force and moment, less what is lost."""
    f = loads_on(t)
    here = (t.surface[:, 0] > 0.6).astype(int) + (t.surface[:, 0] > 1.0)
    there = (t.structure[:, 1] > 0.5).astype(int)
    shares = t.shares(f, here, there)
    for k in range(here.max() + 1):
        alone = np.where(here[:, None] == k, f, 0.0)
        kept = net_force_and_moment(t.surface, alone) - t.defects(alone)
        assert_close(shares[k].sum(axis=0), kept, CLOSE)
        for part in range(there.max() + 1):
            own = there == part
            arrived = net_force_and_moment(t.structure[own], t.loads(alone)[own])
            assert_close(shares[k, part], arrived, CLOSE)


def densities_keep_the_total_force_as_loads_do(t: Transfer) -> None:
    """1^T M_X g = 1^T C^T M_Y f, with lumped and with full masses."""
    f = loads_on(t)
    n, m = len(t.structure), len(t.surface)
    rng = np.random.default_rng(3)
    lumped = 0.5 + rng.random(m)
    full = np.diag(lumped) + 0.1 * np.eye(m, k=1) + 0.1 * np.eye(m, k=-1)
    own = np.diag(0.5 + rng.random(n)) + 0.1 * np.eye(n, k=1) + 0.1 * np.eye(n, k=-1)
    for mass in (np.diag(lumped), full):
        given = t.densities(f, lumped if mass is not full else full, own)
        assert_close((own @ given).sum(axis=0), t.loads(mass @ f).sum(axis=0), CLOSE)


LAWS = [
    work_is_kept,
    forces_are_kept_if_and_only_if_translations_come_back,
    moments_are_kept_if_and_only_if_rotations_come_back,
    what_is_lost_is_known_beforehand,
    parts_get_what_parts_give,
    densities_keep_the_total_force_as_loads_do,
]
