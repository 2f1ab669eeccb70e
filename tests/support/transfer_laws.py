"""Laws that a transfer between two meshes must obey, each a function of the transfer."""

import numpy as np

from fieldrecon.coupling.rigid_body_motions import net_force_and_moment, rigid_motions
from fieldrecon.coupling.transfer import Transfer
from laws import VISIBLE, assert_close

CLOSE = 1e-9


def loads_on(t: Transfer) -> np.ndarray:
    """Random loads (m, d) on the surface, of total size one."""
    m, d = t.surface.shape
    return np.random.default_rng(m).normal(size=(m, d)) / np.sqrt(m)


def virtual_work_is_conserved(t: Transfer) -> None:
    """(C u, f) = (u, Cᵀ f) must hold for every displacement u and every load f."""
    f = loads_on(t)
    u = np.cos(7 * t.structure) + t.structure**2
    assert_close((t.displacements(u) * f).sum(), (u * t.loads(f)).sum(), CLOSE)


def forces_are_conserved_if_and_only_if_translations_are_reproduced(t: Transfer) -> None:
    """The condition is checked on displacements and its consequence on loads."""
    d = t.structure.shape[1]
    conservation_is_equivalent_to_reproduction(t, slice(0, d))


def moments_are_conserved_if_and_only_if_rotations_are_reproduced(t: Transfer) -> None:
    """Moments are taken about the origin."""
    d = t.structure.shape[1]
    conservation_is_equivalent_to_reproduction(t, slice(d, None))


def conservation_is_equivalent_to_reproduction(t: Transfer, which: slice) -> None:
    f = loads_on(t)
    transferred = t.displacements(rigid_motions(t.structure)[..., which])
    motion_error = np.abs(transferred - rigid_motions(t.surface)[..., which]).max()
    force_error = (
        net_force_and_moment(t.surface, f) - net_force_and_moment(t.structure, t.loads(f))
    )[which]
    if motion_error < CLOSE:
        assert_close(force_error, np.zeros_like(force_error), CLOSE)
    else:
        assert motion_error > VISIBLE
        assert np.abs(force_error).max() > VISIBLE


def defects_equal_the_lost_force_and_moment(t: Transfer) -> None:
    """`defects` must give them about any point, without computing the loads on the structure."""
    f, about = loads_on(t), np.full(t.structure.shape[1], 0.3)
    lost = net_force_and_moment(t.surface, f, about) - net_force_and_moment(
        t.structure, t.loads(f), about
    )
    assert_close(t.defects(f, about), lost, CLOSE)


def shares_of_parts_add_up_to_the_conserved_force_and_moment(t: Transfer) -> None:
    """The shares of a part must add up to its force and moment minus the defects.

    Each share must be the force and moment of the loads on that part of the structure.
    """
    f = loads_on(t)
    here = (t.surface[:, 0] > 0.6).astype(int) + (t.surface[:, 0] > 1.0)
    there = (t.structure[:, 1] > 0.5).astype(int)
    shares = t.shares(f, here, there)
    for k in range(here.max() + 1):
        alone = np.where(here[:, None] == k, f, 0.0)
        conserved = net_force_and_moment(t.surface, alone) - t.defects(alone)
        assert_close(shares[k].sum(axis=0), conserved, CLOSE)
        for part in range(there.max() + 1):
            own = there == part
            received = net_force_and_moment(t.structure[own], t.loads(alone)[own])
            assert_close(shares[k, part], received, CLOSE)


def densities_conserve_the_total_force_as_loads_do(t: Transfer) -> None:
    """1ᵀ M_X g = 1ᵀ Cᵀ M_Y f must hold for lumped and for consistent mass matrices."""
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
    virtual_work_is_conserved,
    forces_are_conserved_if_and_only_if_translations_are_reproduced,
    moments_are_conserved_if_and_only_if_rotations_are_reproduced,
    defects_equal_the_lost_force_and_moment,
    shares_of_parts_add_up_to_the_conserved_force_and_moment,
    densities_conserve_the_total_force_as_loads_do,
]
