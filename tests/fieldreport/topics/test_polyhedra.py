"""Claims of the chapter on barycentric coordinates, on a small run."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from fieldrecon.barycentric.coordinates import BarycentricCoordinates
from fieldreport.experiments.barycentric import coordinate_formulas as formulas
from fieldreport.experiments.barycentric import polyhedra
from fieldreport.experiments.barycentric.coordinate_formulas import Outside
from fieldreport.experiments.barycentric.polytopes import (
    OUTSIDE,
    POLYHEDRA,
    Planes,
    irregular,
    mesh_of,
    regular,
)

ROUNDING = 1e-14
CROWDED = ("octahedron", "square pyramid", "rhombic dodecahedron")


@pytest.fixture(scope="module")
def result():
    return polyhedra.run(replace(polyhedra.QUICK, splits=6))


# --- textbook formulas ---------------------------------------------------------------------------


@pytest.mark.parametrize("name", POLYHEDRA)
def test_corners_edges_and_faces_satisfy_eulers_formula(name):
    """n - e + f = 2, each face is an oriented loop, and the expected polyhedra are simple."""
    planes = Planes.of(POLYHEDRA[name])
    assert len(planes.corners) - len(planes.edges) + len(planes.offsets) == 2
    assert planes.simple == (name not in CROWDED)
    for face in range(len(planes.offsets)):
        loop = POLYHEDRA[name][planes.around(face)]
        sides = np.roll(loop, -1, axis=0) - loop
        turns = np.cross(sides, np.roll(sides, -1, axis=0)) @ planes.normals[face]
        assert (turns > 0).all()


@pytest.mark.parametrize("name", ["tetrahedron", "cube", "dodecahedron"])
def test_the_quotient_is_the_polar_dual_at_simple_corners(name):
    """Two formulas that share only the planes of the faces agree."""
    planes = Planes.of(POLYHEDRA[name])
    x = np.random.default_rng(0).dirichlet(np.ones(len(planes.corners)), 5) @ planes.corners
    assert abs(formulas.quotient(planes, x) - formulas.polar(planes, x)).max() < 1e-13


def test_rational_weights_agree_with_the_quotient_away_from_edges():
    """The rational weights are exact, and the quotient is accurate to rounding there."""
    corners = irregular(7, seed=1)
    x = np.array([0.1, 0.05])
    exact = formulas.rational(corners, x)
    assert abs(formulas.quotient(Planes.of(corners), x[None])[0] - exact).max() < ROUNDING


@pytest.mark.parametrize("corners", [regular(5), irregular(6, seed=2), POLYHEDRA["cube"][:4] * 2])
def test_meshes_have_the_area_of_their_polygon(corners):
    """In the plane and in space."""
    if corners.shape[1] == 3:
        corners = corners[[0, 1, 3, 2]]
    points, triangles = mesh_of(corners, 5)
    sides = points[triangles[:, 1:]] - points[triangles[:, :1]]
    gram = np.einsum("tad,tbd->tab", sides, sides)
    flat = corners if corners.shape[1] == 2 else corners[:, 1:]
    area = np.sqrt(np.linalg.det(gram)).sum() / 2
    assert area == pytest.approx(ConvexHull(flat).volume, rel=1e-12)


# --- results of the experiment -------------------------------------------------------------------


def test_positions_are_reproduced_and_independent_formulas_agree(result):
    """This holds up to rounding in every polytope; closed forms are compared where they exist."""
    table = result.tables["polytopes"]
    assert max(table.column("positions")) < ROUNDING
    assert max(table.column("polar dual")) < ROUNDING
    differences = [x for x in table.column("difference") if x != "–"]
    assert len(differences) == 4
    assert max(differences) < ROUNDING
    assert result.facts["gradient_error"] < ROUNDING


def test_three_faces_suffice_at_simple_corners_only(result):
    """The quotient with three faces reproduces positions if and only if no corner has more."""
    for row in result.tables["polytopes"].rows:
        simple, error = row[5], row[8]
        assert (error < polyhedra.EXACT) == (simple == "yes"), row[0]
        assert error < polyhedra.EXACT or error > 0.01


def test_the_error_with_three_faces_does_not_depend_on_the_draw():
    """It does with a hundred points, at which the formula has few large errors."""
    corners = POLYHEDRA["square pyramid"]

    def spread(n: int) -> float:
        draws = (polyhedra.Params(sampled=n, seed=seed) for seed in range(10))
        found = [polyhedra.error_of_few_faces(params, corners) for params in draws]
        return max(found) / min(found)

    assert spread(polyhedra.Params().sampled) < 1.1 < 1.3 < spread(100)


def test_every_split_converges_to_the_polar_dual(result):
    """The convergence is of first order in δ, whichever pair of faces meets."""
    assert 0.98 < result.facts["slope_least"] <= result.facts["slope_most"] < 1.02
    assert result.facts["ways_pyramid"] == 2
    assert result.facts["difference_at_smallest_shift"] < 1e-9


@pytest.mark.parametrize("name", CROWDED)
def test_splits_do_not_converge_to_the_formula_with_three_faces(name):
    """The limit distinguishes right weights from wrong ones."""
    planes = Planes.of(POLYHEDRA[name])
    x = 0.5 * planes.corners[:1] + 0.1
    shifts = 1e-8 * np.random.default_rng(3).uniform(-1, 1, len(planes.offsets))
    apart, origin = formulas.split(planes, shifts)
    limit = formulas.added_up(formulas.quotient(apart, x), origin, len(planes.corners))
    assert abs(BarycentricCoordinates(planes.corners).weights(x) - limit).max() < 1e-6
    assert abs(formulas.quotient(planes, x, 3) - limit).max() > 0.01


def test_moving_two_opposite_faces_makes_the_others_meet():
    """At the apex of a pyramid they meet in an edge, whichever opposite pair is moved."""
    planes = Planes.of(POLYHEDRA["square pyramid"])
    for pair, others in (planes.opposite, planes.opposite[::-1]):
        shifts = np.zeros(len(planes.offsets))
        shifts[pair] = 0.1
        apart, origin = formulas.split(planes, shifts)
        assert apart.simple
        assert (np.bincount(origin) == [1, 1, 1, 1, 2]).all()
        assert apart.on[:, others].all(axis=1).sum() == 2
        assert apart.on[:, pair].all(axis=1).sum() == 0


def test_products_are_accurate_near_edges_and_quotients_are_not(result):
    """Far from edges both are accurate; closest to an edge the quotient has no correct digit."""
    (quotient, products), (at_corner, _) = result.arrays["beside"]
    assert result.arrays["beside"][:, 1].max() < ROUNDING
    assert max(quotient[0], at_corner[0]) < 1e-13
    assert min(quotient.max(), at_corner.max()) > 1e-3
    assert products.max() < ROUNDING


def test_the_poles_lie_on_the_adjoint_curve(result):
    """The adjoint is the only polynomial of degree n - 3 through the crossings of the edges."""
    assert result.facts["adjoint_difference"] < 1e-11
    assert result.facts["crossings"] == sum(n * (n - 3) // 2 for n in OUTSIDE)
    assert result.facts["poles"] > 0
    assert result.facts["poles_refused"] == result.facts["poles"]


def test_a_curve_through_a_moved_crossing_differs(monkeypatch):
    """A shift of one crossing by a thousandth is detected."""
    true = formulas.crossings

    def moved(planes):
        points = true(planes)
        return points + 1e-3 * np.eye(len(points), 2)

    monkeypatch.setattr(formulas, "crossings", moved)
    assert Outside.of(OUTSIDE[5], 8, 20).difference > 1e-6
