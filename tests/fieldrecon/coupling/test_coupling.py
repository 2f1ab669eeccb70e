"""Coupling of meshes: conservation laws, their conditions, and the loss otherwise."""

import warnings
from collections.abc import Callable
from functools import partial
from unittest import mock

import numpy as np
import pytest
from scipy.spatial.distance import cdist

import transfer_laws
from fieldrecon import reconstruction
from fieldrecon.coupling.flat_structures import FlatCoupling, couple
from fieldrecon.coupling.rigid_body_motions import net_force_and_moment, rigid_motions
from fieldrecon.coupling.transfer import (
    Coupling,
    Transfer,
    applied,
    diagonal_of_areas,
    warn_of_large_weights,
)
from fieldrecon.datasets.synthetic import halton
from fieldrecon.kernels.conditionally_positive_definite import polyharmonic, thin_plate_spline
from fieldrecon.kernels.positive_definite import gaussian, wendland
from fieldrecon.kernels.weights import inverse_square
from fieldrecon.methods.least_squares import LeastSquares
from fieldrecon.methods.moving_least_squares import MovingLeastSquares
from fieldrecon.methods.partition_of_unity.method import PartitionOfUnityRBF
from fieldrecon.methods.rbf import RBF
from fieldreport.experiments.coupling.coupling import integrated, separate
from laws import VISIBLE, assert_close

plates = partial(RBF, kernel=thin_plate_spline())
cubics = partial(RBF, kernel=polyharmonic(3), degree=1)


def nodes(d: int, n: int = 40) -> np.ndarray:
    return halton(n, d)


def skin_points(d: int, m: int = 90) -> np.ndarray:
    """Points in the unit cube shifted by 1/4 along x, so that they overlap the nodes in part."""
    return halton(m, d, seed=5) + np.eye(d)[0] / 4


def flat(d: int) -> np.ndarray:
    """Nodes in a plane of space or on a line of the plane, rotated and shifted."""
    x = np.column_stack([halton(40, d - 1), np.zeros(40)])
    return x @ random_rotation(d) + 0.3


def random_rotation(d: int) -> np.ndarray:
    return np.linalg.qr(np.random.default_rng(d).normal(size=(d, d)))[0]


METHODS: dict[str, Callable[[np.ndarray], object]] = {
    "thin plates": plates,
    "blended patches": partial(PartitionOfUnityRBF, kernel=thin_plate_spline(), degree=1),
    "linear fit": partial(LeastSquares, degree=1),
    "moving linear fit": partial(MovingLeastSquares, weight=inverse_square(0.1), degree=1),
    "moving constant": partial(MovingLeastSquares, weight=inverse_square(0.1), degree=0),
    "kernel with a constant": partial(RBF, kernel=polyharmonic(1), degree=0),
    "kernel alone": partial(RBF, kernel=gaussian(0.3)),
}

COUPLINGS: dict[str, Callable[[], Transfer]] = {
    f"{name} in {d}-D": lambda make=make, d=d: Coupling(make(nodes(d)), skin_points(d))
    for name, make in METHODS.items()
    for d in (2, 3)
} | {
    f"{name}, flat in {d}-D": lambda make=make, d=d: quietly(
        FlatCoupling, flat(d), skin_points(d), make
    )
    for name, make in {
        "cubics": cubics,
        "a fit of degree 0": partial(LeastSquares, degree=0),
    }.items()
    for d in (2, 3)
}


@pytest.mark.parametrize("law", transfer_laws.LAWS, ids=lambda law: law.__name__)
@pytest.mark.parametrize("name", COUPLINGS)
def test_every_transfer_obeys_the_laws(name, law):
    law(COUPLINGS[name]())


def test_conservation_depends_on_the_degree_of_the_method():
    """Degree 1 conserves force and moment, degree 0 the force only, and no polynomial neither."""
    for d in (2, 3):
        for make, force, moment in [
            (METHODS["linear fit"], True, True),
            (METHODS["moving constant"], True, False),
            (METHODS["kernel with a constant"], True, False),
            (METHODS["kernel alone"], False, False),
        ]:
            t = Coupling(make(nodes(d)), skin_points(d))
            lost = np.abs(t.defects(transfer_laws.loads_on(t)))
            assert (lost[:d].max() < 1e-9) == force
            assert (lost[d:].max() < 1e-9) == moment


# --- mutants --------------------------------------------------------------------------------------


class InterpolatedLoads(Coupling):
    """Mutant: loads by interpolation of the surface loads at the nodes."""

    def _load(self, f):
        return plates(self.surface).field(f)(self.structure)


class NearestNode(Coupling):
    """Mutant: loads to the nearest node, displacements by H.

    The force is conserved, work is not.
    """

    def _load(self, f):
        total = np.zeros((len(self.structure), *f.shape[1:]))
        np.add.at(total, cdist(self.surface, self.structure).argmin(axis=1), f)
        return total


class Rescaled(InterpolatedLoads):
    """Mutant: interpolated loads, scaled so that the sums of each component agree."""

    def _load(self, f):
        loads = super()._load(f)
        return loads * (f.sum(axis=0) / loads.sum(axis=0))


class RotationForgotten(FlatCoupling):
    """Mutant: points off the plane move as their projections do."""

    def _displace(self, u):
        return applied(self._weights, u)


class CouplesBackward(FlatCoupling):
    """Mutant: the couples of loads off the plane have the wrong sign."""

    def _load(self, f):
        here, self.heights = self.heights, -self.heights
        loads = super()._load(f)
        self.heights = here
        return loads


class DefectsAboutOrigin(Coupling):
    """Mutant: moments are always taken about the origin."""

    def defects(self, f, about=None):  # noqa: ARG002
        return super().defects(f)


class SharesOfAll(Coupling):
    """Mutant: each part of the surface gets the loads of all parts."""

    def shares(self, f, surface, structure):
        right = super().shares(f, surface, structure)
        return np.broadcast_to(right.sum(axis=0), right.shape)


class MassForgotten(Coupling):
    """Mutant: loads per area are treated as loads."""

    def densities(self, f, surface_mass, structure_mass=None):  # noqa: ARG002
        return super().densities(f, np.ones(len(f)), structure_mass)


MUTANTS = [
    (transfer_laws.virtual_work_is_conserved, InterpolatedLoads),
    (transfer_laws.virtual_work_is_conserved, NearestNode),
    (transfer_laws.virtual_work_is_conserved, Rescaled),
    (transfer_laws.virtual_work_is_conserved, CouplesBackward),
    (transfer_laws.virtual_work_is_conserved, RotationForgotten),
    (
        transfer_laws.forces_are_conserved_if_and_only_if_translations_are_reproduced,
        InterpolatedLoads,
    ),
    (
        transfer_laws.moments_are_conserved_if_and_only_if_rotations_are_reproduced,
        InterpolatedLoads,
    ),
    (transfer_laws.moments_are_conserved_if_and_only_if_rotations_are_reproduced, NearestNode),
    (transfer_laws.moments_are_conserved_if_and_only_if_rotations_are_reproduced, CouplesBackward),
    (transfer_laws.defects_equal_the_lost_force_and_moment, InterpolatedLoads),
    (transfer_laws.defects_equal_the_lost_force_and_moment, DefectsAboutOrigin),
    (transfer_laws.shares_of_parts_add_up_to_the_conserved_force_and_moment, SharesOfAll),
    (transfer_laws.densities_conserve_the_total_force_as_loads_do, MassForgotten),
]


@pytest.mark.parametrize(
    ("law", "mutant"), MUTANTS, ids=lambda part: getattr(part, "__name__", None)
)
def test_each_law_rejects_its_mutants(law, mutant):
    if issubclass(mutant, FlatCoupling):
        wrong = mutant(flat(3), skin_points(3), cubics)
    else:
        make = METHODS["kernel alone" if mutant is DefectsAboutOrigin else "thin plates"]
        wrong = mutant(make(nodes(3)), skin_points(3))
    with pytest.raises(AssertionError):
        law(wrong)


# --- pointwise loads ------------------------------------------------------------------------------


def test_constant_nodal_loads_cannot_be_reproduced_with_their_sum():
    """The sums over 12 and 40 nodes differ. Densities can be both reproduced and conserved."""
    t = Coupling(plates(nodes(2, 12)), halton(40, 2, seed=5))
    ones = np.ones((40, 2))
    pointwise = plates(t.surface).field(ones)(t.structure)
    assert_close(pointwise.sum(axis=0), np.array([12.0, 12.0]), 1e-9)
    assert_close(t.loads(ones).sum(axis=0), np.array([40.0, 40.0]), 1e-9)
    areas = 0.5 + np.random.default_rng(0).random(40)
    density = t.densities(ones, areas)
    assert_close(density, np.ones((12, 2)), 1e-9)
    got = t.method.adjoint(t.surface, areas)
    assert_close((got[:, None] * density).sum(axis=0), np.full(2, areas.sum()), 1e-9)


def test_a_constant_density_is_reproduced_if_and_only_if_the_masses_match():
    """The condition on the given masses is Cᵀ M_Y 1 = M_X 1."""
    t = Coupling(plates(nodes(2, 12)), halton(40, 2, seed=5))
    areas = 0.5 + np.random.default_rng(0).random(40)
    matching = t.method.adjoint(t.surface, areas)
    assert_close(t.densities(np.ones((40, 2)), areas, matching), np.ones((12, 2)), 1e-9)
    other = matching * np.linspace(0.9, 1.1, 12)
    found = t.densities(np.ones((40, 2)), areas, other)
    assert_close(found, np.repeat(matching[:, None] / other[:, None], 2, axis=1), 1e-9)
    assert np.abs(found - 1).max() > 0.05


# --- flat structures ------------------------------------------------------------------------------


def test_flat_structures_are_detected():
    """This holds for any plane, far from the origin and in any unit.

    Almost flat nodes are not flat.
    """
    for d in (2, 3):
        for unit, offset in ((1.0, 0.0), (1e-9, 0.0), (1e6, 3.0)):
            x = (flat(d) + offset) * unit
            t = quietly(
                couple, x, (skin_points(d) + offset) * unit, cubics
            )  # beyond a line by its length
            assert isinstance(t, FlatCoupling)
            f = transfer_laws.loads_on(t)
            lost = net_force_and_moment(t.structure, t.loads(f)) - net_force_and_moment(
                t.surface, f
            )
            assert np.abs(lost[:d]).max() < 1e-8
            assert np.abs(lost[d:]).max() < 1e-8 * unit * (1 + offset)
        away = np.linalg.svd(flat(d) - flat(d).mean(axis=0))[2][-1]
        thick = flat(d) + 1e-3 * np.cos(np.arange(40))[:, None] * away
        assert type(quietly(couple, thick, skin_points(d), cubics)) is Coupling


@pytest.mark.parametrize("d", [2, 3])
def test_flatness_is_judged_for_the_digits_of_a_file(d):
    """Rounded to `digits` in any unit: flat if and only if flatness admits it, and then right.

    A bent plate, whose sagitta is ten times the flatness, is not flat.
    """
    exact = flat(d)
    normal = np.linalg.svd(exact - exact.mean(axis=0))[2][-1]
    y = exact[::3] + 0.05 * normal
    u = np.sum((exact - exact.mean(axis=0)) ** 2, axis=1)[:, None] * normal
    expected = FlatCoupling(exact, y, cubics).displacements(u)
    for digits, unit in ((4, 1.0), (5, 1e6), (6, 1.0), (7, 1e-6), (8, 1e6)):
        x, flatness = np.round(exact, digits) * unit, 10.0**-digits
        for t in [couple(x, y * unit, cubics, flatness=flatness)] + (
            [couple(x, y * unit, cubics)] if digits >= 6 else []
        ):
            assert type(t) is FlatCoupling
            assert np.abs(t.displacements(u) - expected).max() < 30 * flatness
        if digits < 6:
            assert type(quietly(couple, x, y * unit, cubics)) is Coupling
        bent = (exact + 10 * flatness * u / u.max()) * unit
        assert type(quietly(couple, bent, y * unit, cubics, flatness=flatness)) is Coupling


def quietly(make, *arguments, **options):
    """Whatever it warns of."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return make(*arguments, **options)


def test_weights_that_amplify_are_announced():
    """Exactly those above the bound: almost flat nodes in space, and points far away."""
    almost = np.round(flat(3), 4)
    normal = np.linalg.svd(almost - almost.mean(axis=0))[2][-1]
    with pytest.warns(RuntimeWarning, match=r"node \d+ of the surface sum to .*flatness=\de-05"):
        couple(almost, flat(3) + 0.05 * normal, cubics)
    for far in (flat(2), nodes(2)):
        with pytest.warns(RuntimeWarning, match=r"structural nodes nearer to it$"):
            couple(far, far[:3] * 1e3, cubics)
    couple(nodes(3), skin_points(3), cubics)
    for t in (couple(nodes(3), skin_points(3), cubics), couple(flat(3), skin_points(3), cubics)):
        sums = np.abs(t.method.weights(t.projections)).sum(axis=1)
        assert_close(t.row_norms(), sums, 1e-12)
    with mock.patch.object(reconstruction, "DENSE_LIMIT_BYTES", 1000):
        t = Coupling(cubics(nodes(3)), skin_points(3))
    sums = np.abs(cubics(nodes(3)).weights(skin_points(3))).sum(axis=1)
    assert (t.row_norms() <= sums * (1 + 1e-9)).all()
    assert (t.row_norms() >= sums / 10).all()


def test_weights_of_a_sum_above_a_hundred_are_announced():
    """By the node of the largest sum; no node at all has none."""
    warn_of_large_weights(np.array([1.0, 100.0, 99.0]))
    warn_of_large_weights(np.array([]))
    with pytest.warns(RuntimeWarning, match=r"node 1 of the surface sum to 1e\+02, more than 100:"):
        warn_of_large_weights(np.array([1.0, 100.5, 99.0]))


@pytest.mark.parametrize("d", [2, 3])
def test_only_a_thin_structure_may_be_meant_to_be_flat(d):
    """One that is less than a hundredth as thick as it is long; nodes on the axis never are."""
    normal = np.eye(d)[-1]
    wave = np.sqrt(2) * np.cos(np.arange(40) * np.pi / 4)[:, None] * normal  # of the rms one
    line = np.linspace(0, 1, 40)
    plate = np.column_stack([line, *[np.cos(9 * line) / 5] * (d - 2), 0 * line])
    for thickness, remedy in ((0.008, "meant to be flat$"), (0.02, "nearer to it$")):
        with pytest.warns(RuntimeWarning, match=remedy):
            warn_of_large_weights(np.array([101.0]), plate + thickness * wave)
    heap = np.append(np.zeros(20000), 1.0)[:, None]
    with pytest.warns(RuntimeWarning, match="nearer to it$"):
        warn_of_large_weights(np.array([101.0]), heap)


def test_every_coupling_announces_them_once_at_the_line_of_the_caller():
    """Also one made without `couple`, of nodes in space or in a plane."""
    almost, far = np.round(flat(3), 4), flat(3) * 1e3
    for make, warned in (
        (lambda: Coupling(cubics(almost), far), True),
        (lambda: FlatCoupling(flat(3), far, cubics), True),
        (lambda: couple(almost, far, cubics), True),
        (lambda: couple(flat(3), far, cubics), True),
        (lambda: Coupling(cubics(nodes(3)), skin_points(3)), False),
    ):
        with warnings.catch_warnings(record=True) as seen:
            warnings.simplefilter("always")
            make()
        own_line = (__file__, make.__code__.co_firstlineno)
        assert [(w.filename, w.lineno) for w in seen] == [own_line] * warned


def test_a_method_that_refuses_random_signs_is_coupled_all_the_same():
    """Its weights are not kept, and smooth displacements may be all that it is given."""
    refusal = np.linalg.LinAlgError("too flat for data this rough")
    method = cubics(nodes(3))
    with (
        mock.patch.object(reconstruction, "DENSE_LIMIT_BYTES", 1000),
        mock.patch.object(type(method), "field", side_effect=refusal),
    ):
        assert Coupling(method, skin_points(3))._weights is None


def test_a_method_in_space_refuses_flat_nodes_or_loses_moments():
    """RBF refuses flat nodes. Blended patches reduce their degree to 0 and lose the moments."""
    with pytest.raises(np.linalg.LinAlgError, match="do not determine a polynomial of degree 1"):
        plates(flat(3))
    t = Coupling(PartitionOfUnityRBF(flat(3), degree=1), skin_points(3))
    lost = t.defects(transfer_laws.loads_on(t))
    assert t.method.degree == 0
    assert np.abs(lost[:3]).max() < 1e-9
    assert np.abs(lost[3:]).max() > VISIBLE


def test_points_off_a_bent_plate_move_with_its_normals():
    """u = x² rotates the normal by -2x, so a point at height ζ moves by -2xζ along x."""
    x = np.column_stack([np.linspace(-1, 1, 81), np.zeros(81)])
    u = np.column_stack([np.zeros(81), x[:, 0] ** 2])
    y = np.array([[0.31, 0.2], [-0.57, 0.2], [0.31, -0.4], [0.31, 0.0]])
    displacements = FlatCoupling(
        x, y, partial(RBF, kernel=polyharmonic(3), degree=2)
    ).displacements(u)
    expected = np.column_stack([-2 * y[:, 0] * y[:, 1], y[:, 0] ** 2])
    assert_close(displacements, expected, 1e-6)


def test_a_force_off_the_plane_gives_a_couple():
    """A force along the plate at height ζ gives normal forces with sum zero and moment ζ."""
    x = np.column_stack([np.linspace(-1, 1, 9), np.zeros(9)])
    loads = FlatCoupling(x, [[0.1, 0.5]], cubics).loads([[1.0, 0.0]])
    assert_close(loads.sum(axis=0), np.array([1.0, 0.0]), 1e-12)
    assert_close(net_force_and_moment(x, loads), np.array([1.0, 0.0, -0.5]), 1e-12)


def test_nodes_on_a_line_in_space_are_refused():
    """Displacements of the line do not determine its torsion."""
    line = np.linspace(0, 1, 9)[:, None] * [1.0, 2.0, 3.0]
    with pytest.raises(np.linalg.LinAlgError, match=r"lie on a line.*rigid arms"):
        couple(line, skin_points(3))
    for point, y in ((np.ones((3, 2)), skin_points(2)), (np.ones((4, 3)), skin_points(3))):
        with pytest.raises(np.linalg.LinAlgError, match="lie at one point"):
            couple(point, y)
    with pytest.raises(np.linalg.LinAlgError, match="lie at one point"):
        couple(nodes(2), skin_points(2), flatness=1.0)  # as thick as they are long
    with pytest.raises(np.linalg.LinAlgError, match="nodes with one coordinate do not rotate"):
        FlatCoupling(nodes(1), skin_points(1))


def test_patches_within_one_flat_side_are_refused():
    """Small patches on one side of a box lie in a plane. Larger patches contain both sides."""
    g = np.stack(np.meshgrid(np.linspace(0, 1, 20), np.linspace(0, 1, 20)), -1).reshape(-1, 2)
    box = np.vstack([np.column_stack([g, np.full(400, z)]) for z in (0.0, 0.5)])
    y = skin_points(3)
    with pytest.raises(
        np.linalg.LinAlgError, match="degree 0 on these nodes, and the total moment"
    ):
        couple(box, y)
    t = couple(box, y, partial(PartitionOfUnityRBF, degree=1, patch_size=300))
    assert np.abs(t.defects(transfer_laws.loads_on(t))).max() < 1e-9


def test_patches_conserve_force_and_moment_on_special_structures_or_are_refused():
    """Two plates, the frames of a tube, and a cloud with an outlier."""
    rng, t = np.random.default_rng(0), np.linspace(0, 2 * np.pi, 40, endpoint=False)
    frame = np.column_stack([np.cos(t), np.sin(t)])
    structures = {
        "two plates": np.column_stack([rng.random((400, 2)), np.repeat([0.0, 1.0], 200)]),
        "tube": np.vstack([np.column_stack([frame, np.full(40, z)]) for z in range(5)]),
        "outlier": np.vstack([rng.random((200, 3)), [[300.0, -200.0, 500.0]]]),
    }
    conserved = []
    for name, nodes in structures.items():
        try:
            transfer = couple(nodes, skin_points(3), PartitionOfUnityRBF)
        except np.linalg.LinAlgError:
            continue
        assert np.abs(transfer.defects(transfer_laws.loads_on(transfer))).max() < 1e-8, name
        conserved.append(name)
    assert {"two plates", "tube"} <= set(conserved)


# --- the mappings of preCICE ----------------------------------------------------------------------


KERNEL = wendland(3, 2, 0.8)


def test_precice_mappings_with_an_integrated_polynomial_agree():
    """The consistent mapping is H, the conservative one Hᵀ, by preCICE's block system."""
    x, y = nodes(3), skin_points(3)
    consistent, conservative = integrated(x, y, KERNEL)
    u, f = np.cos(5 * x), np.sin(7 * y)
    t = Coupling(RBF(x, KERNEL, degree=1), y)
    assert_close(t.displacements(u), consistent @ u, 1e-9)
    assert_close(t.loads(f), conservative @ f, 1e-9)


def test_precice_mappings_with_a_separate_polynomial_differ_and_conserve():
    """preCICE first subtracts a polynomial fit and interpolates the rest without polynomials."""
    x, y = nodes(3), skin_points(3)
    consistent, conservative = separate(x, y, KERNEL)
    q = np.column_stack([np.ones(len(x)), x])
    u, f = np.cos(5 * x), np.sin(7 * y)
    rest = u - q @ np.linalg.lstsq(q, u, rcond=None)[0]
    alone = RBF(x, KERNEL, degree=-1).field(rest)(y)
    fitted = np.column_stack([np.ones(len(y)), y]) @ np.linalg.lstsq(q, u, rcond=None)[0]
    assert_close(consistent @ u, alone + fitted, 1e-9)
    assert_close(((consistent @ u) * f).sum(), (u * (conservative @ f)).sum(), 1e-9)
    assert_close(net_force_and_moment(x, conservative @ f), net_force_and_moment(y, f), 1e-9)
    t = Coupling(RBF(x, KERNEL, degree=1), y)
    assert np.abs(t.loads(f) - conservative @ f).max() > VISIBLE


# --- evaluation without matrices, load cases, parts -----------------------------------------------


def test_weights_too_large_to_store_are_not_formed():
    """Then field and adjoint give the same result."""
    x, y = nodes(3), skin_points(3)
    u, f = np.cos(5 * x), np.sin(7 * y)
    kept = Coupling(plates(x), y)
    with mock.patch.object(reconstruction, "DENSE_LIMIT_BYTES", 1000):
        t = Coupling(plates(x), y)
        assert t._weights is None
        assert_close(t.displacements(u), kept.displacements(u), 1e-10)
        assert_close(t.loads(f), kept.loads(f), 1e-10)


def test_load_cases_are_independent():
    """Loads (m, d, ...) and displacements (n, d, ...) may have additional axes."""
    for t in (
        Coupling(plates(nodes(3)), skin_points(3)),
        FlatCoupling(flat(3), skin_points(3), cubics),
    ):
        f = np.random.default_rng(1).normal(size=(90, 3, 2, 4))
        u = np.random.default_rng(2).normal(size=(40, 3, 2, 4))
        areas = np.ones(90)
        own = np.ones(40)
        for k in np.ndindex(2, 4):
            each = (slice(None), slice(None), *k)
            assert_close(t.loads(f)[each], t.loads(f[each]), 1e-11)
            assert_close(t.displacements(u)[each], t.displacements(u[each]), 1e-11)
            assert_close(t.densities(f, areas, own)[each], t.densities(f[each], areas, own), 1e-11)
            assert_close(t.defects(f)[(slice(None), *k)], t.defects(f[each]), 1e-11)


def test_local_methods_do_not_load_distant_parts():
    """For two distant surfaces, patches transfer the load of each to its own nodes only."""
    x = halton(400, 3)
    x[:, 0] = np.where(np.arange(400) % 2, 3 + x[:, 0], x[:, 0])
    y = x[::3] + 0.01
    f = np.random.default_rng(0).normal(size=y.shape)
    parts = (y[:, 0] > 2).astype(int), (x[:, 0] > 2).astype(int)
    local = Coupling(PartitionOfUnityRBF(x, thin_plate_spline(), 1), y).shares(f, *parts)
    everywhere = Coupling(plates(x), y).shares(f, *parts)
    assert_close(local.sum(axis=1), everywhere.sum(axis=1), 1e-8)
    leaked = [np.abs(shares[[0, 1], [1, 0]]).max() for shares in (local, everywhere)]
    assert leaked[0] < 1e-12
    assert leaked[1] > VISIBLE


def test_shares_of_parts_sum_to_the_forces_and_moments_of_the_surface():
    """For three parts of the surface and three of the structure, of which one has no nodes."""
    t = Coupling(plates(nodes(3)), skin_points(3))
    f, here, there = np.cos(9 * t.surface), np.arange(90) % 3, np.arange(40) % 2 * 2
    shares = t.shares(f, here, there)
    assert shares.shape == (3, 3, 6)
    assert not shares[:, 1].any()
    for k in range(3):
        alone = net_force_and_moment(t.surface[here == k], f[here == k])
        assert_close(shares[k].sum(axis=0), alone, 1e-10)
    assert_close(t.shares(f, here, 0 * there), shares.sum(axis=1, keepdims=True), 1e-10)
    loads = t.loads(f)[there == 2]
    assert_close(
        shares[:, 2].sum(axis=0), net_force_and_moment(t.structure[there == 2], loads), 1e-10
    )


def test_the_flatness_that_a_warning_suggests_is_twice_the_thickness():
    """A little less makes the nodes flat as well, less than half of it does not."""
    almost = np.round(flat(3), 4)
    normal = np.linalg.svd(almost - almost.mean(axis=0))[2][-1]
    y = flat(3) + 0.05 * normal
    with pytest.warns(RuntimeWarning, match="flatness=") as seen:
        couple(almost, y, cubics)
    flatness = float(str(seen[0].message).partition("flatness=")[2].split()[0])
    assert isinstance(couple(almost, y, cubics, flatness=0.7 * flatness), FlatCoupling)
    assert type(quietly(couple, almost, y, cubics, flatness=0.4 * flatness)) is Coupling


def test_with_the_flatness_zero_no_thick_plate_is_flat():
    """Also the class itself takes it. On the axis nothing is flat with any."""
    assert type(couple(nodes(3), skin_points(3), cubics, flatness=0.0)) is Coupling
    assert type(couple(nodes(1), skin_points(1), cubics, flatness=1.0)) is Coupling
    plane = np.pad(nodes(2), ((0, 0), (0, 1)))
    assert isinstance(FlatCoupling(plane, plane, cubics, flatness=0.0), FlatCoupling)
    line = np.pad(nodes(1), ((0, 0), (0, 2)))
    with pytest.raises(np.linalg.LinAlgError, match="lie on a line"):
        couple(line, plane, cubics, flatness=0.0)


def test_moments_equal_cross_products():
    """In the plane the moment is the third component."""
    p, f = skin_points(3), np.cos(9 * skin_points(3))
    about = np.array([0.2, -0.1, 0.4])
    moment = np.cross(p - about, f).sum(axis=0)
    assert_close(net_force_and_moment(p, f, about), np.concatenate([f.sum(axis=0), moment]), 1e-12)
    third = (p[:, 0] * f[:, 1] - p[:, 1] * f[:, 0]).sum()
    assert_close(net_force_and_moment(p[:, :2], f[:, :2])[2], third, 1e-12)
    assert rigid_motions(np.zeros((1, 4))).shape == (1, 4, 10)
    stretched = rigid_motions(p)[:, :, 3:]
    assert_close(np.einsum("md,mdr->mr", p, stretched), np.zeros((90, 3)), 1e-12)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (
            lambda t: t.loads(np.ones(90)),
            r"f must be vectors of 3 components, shape \(90, 3, \.\.\.\)",
        ),
        (lambda t: t.displacements(np.ones((90, 3))), r"u must have one entry for each point"),
        (
            lambda t: t.densities(np.ones((90, 3)), np.ones(5)),
            r"surface_mass must be masses \(90,\)",
        ),
        (
            lambda t: t.densities(np.ones((90, 3)), np.full(90, np.nan)),
            "surface_mass must be finite",
        ),
        (
            lambda t: t.shares(np.ones((90, 3)), np.full(90, -1), np.zeros(40, int)),
            "surface must be 90 numbers of parts",
        ),
        (lambda t: t.defects(np.ones((90, 3)), [1.0]), "about must have 3 coordinates"),
        (lambda t: Coupling(t.method, np.ones((5, 2))), "x must have as many coordinates"),
    ],
)
def test_invalid_arguments_are_refused(call, words):
    """The message names the argument."""
    with pytest.raises(ValueError, match=words):
        call(Coupling(plates(nodes(3)), skin_points(3)))


def test_densities_of_nodes_without_area_are_refused():
    """A node far from the surface has area zero."""
    x = np.vstack([nodes(2), [[9.0, 9.0]]])
    t = Coupling(PartitionOfUnityRBF(x, degree=1, kernel=thin_plate_spline()), nodes(2) * 0.9)
    with pytest.raises(np.linalg.LinAlgError, match=r"structural node \d+ gets the area"):
        t.densities(np.ones((40, 2)), np.ones(40))
    with pytest.raises(np.linalg.LinAlgError, match="structural node 1 gets the area 0 of"):
        diagonal_of_areas(np.array([2.0, 0.0, 1.0]))
