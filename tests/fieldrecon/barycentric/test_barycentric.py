"""Barycentric coordinates against rational numbers, closed forms, and the slides' own formula."""

from dataclasses import replace
from fractions import Fraction
from itertools import combinations

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.spatial import ConvexHull
from scipy.spatial.distance import pdist
from scipy.stats import ortho_group

import laws
from cases import case
from fieldrecon.barycentric.coordinates import BarycentricCoordinates
from fieldrecon.barycentric.polytope import Polytope
from fieldrecon.barycentric.wachspress import ProductForm, _Products
from polytopes import CUBE, GOLDEN, HEXAGON, OCTAHEDRON, POLYHEDRA, PYRAMID, TETRAHEDRON, regular

EXACT = 1e-13


def inside(corners, m=50, seed=0):
    """Random points (m, d) of the polytope, some near its faces."""
    share = np.random.default_rng(seed).dirichlet(np.full(len(corners), 0.4), m)
    return share @ corners


def faces_at(corners, i):
    """Outward unit normals of the faces at corner i and the corners on each: from Qhull alone."""
    hull = ConvexHull(corners)
    planes = np.unique(hull.equations.round(12), axis=0)
    on = np.abs(corners @ planes[:, :-1].T + planes[:, -1]) < 1e-9
    return planes[on[i], :-1]


def slides_weights(corners, x, volume=lambda n: abs(np.linalg.det(n))):
    """The slides' quotient vol(N_i) / prod n^T (p_i - x), the first d faces at each corner."""
    d = corners.shape[1]
    w = np.empty(len(corners))
    for i, p in enumerate(corners):
        normals = faces_at(corners, i)[:d]
        w[i] = volume(normals) / np.prod(normals @ (p - x))
    return w / w.sum()


# --- rational numbers ---------------------------------------------------------------------------


def rational_weights(corners, x):
    """Exact weights of a polygon whose corners come anticlockwise, in product form."""
    p = [[Fraction(float(c)) for c in row] for row in corners]
    x = [Fraction(float(c)) for c in x]
    n = len(p)

    def cross(a, b):
        return a[0] * b[1] - a[1] * b[0]

    def minus(a, b):
        return [a[0] - b[0], a[1] - b[1]]

    edges = [minus(p[(a + 1) % n], p[a]) for a in range(n)]
    h = [cross(edges[a], minus(x, p[a])) for a in range(n)]
    w = []
    for i in range(n):
        term = cross(edges[i - 1], edges[i])
        for a in range(n):
            if a not in (i, (i - 1) % n):
                term *= h[a]
        w.append(term)
    return np.array([float(term / sum(w)) for term in w])


POLYGONS = {"hexagon": HEXAGON, "regular": regular(6), "17-gon": regular(17)}
# what follows must hold beside an edge too, from both sides
BESIDE = (0.0, 1e-300, 1e-20, 1e-16, -1e-16, 1e-12, 1e-8, -1e-8)


@pytest.mark.slow
@pytest.mark.parametrize("corners", POLYGONS.values(), ids=POLYGONS)
@pytest.mark.parametrize("offset", BESIDE)
def test_weights_beside_an_edge_are_those_of_rational_numbers(corners, offset):
    """At any distance from it, where two of the slides' quotients become infinite."""
    coordinates = BarycentricCoordinates(corners)
    for a in range(len(corners)):
        p, q = corners[a], corners[(a + 1) % len(corners)]
        for t in (1e-9, 0.3, 0.5):
            x = p + t * (q - p) + offset * np.array([p[1] - q[1], q[0] - p[0]])
            assert abs(coordinates.weights(x) - rational_weights(corners, x)).max() < 1e-14


@pytest.mark.parametrize("offset", BESIDE)
def test_weights_beside_a_corner_are_those_of_rational_numbers(offset):
    """From any direction."""
    coordinates = BarycentricCoordinates(HEXAGON)
    for p in HEXAGON:
        for direction in regular(7):
            x = p + offset * direction
            assert abs(coordinates.weights(x) - rational_weights(HEXAGON, x)).max() < 1e-14


def test_the_quotient_of_the_slides_is_wrong_on_an_edge_and_says_nothing():
    """Its two heights below the edge are rounded differently, and their ratio is arbitrary."""
    angle = np.deg2rad(7.2)
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    corners = regular(6) @ turn / np.sqrt(3)
    worst = 0.0
    for a in range(6):
        x = corners[[a, (a + 1) % 6]].mean(axis=0)
        half = np.isin(np.arange(6), [a, (a + 1) % 6]) / 2
        assert abs(BarycentricCoordinates(corners).weights(x) - half).max() < 1e-14
        with np.errstate(all="ignore"):
            naive = slides_weights(corners, x)
        if np.isfinite(naive).all():
            worst = max(worst, abs(naive - half).max())
    assert worst > 0.05


# --- closed forms -------------------------------------------------------------------------------


@pytest.mark.parametrize("corners", [[[0, 0], [2, 1], [1, 3]], TETRAHEDRON], ids=["2-D", "3-D"])
def test_in_a_simplex_they_are_affine(corners):
    """The one solution of sum w = 1, sum w p = x, inside and outside."""
    corners = np.array(corners, dtype=float)
    x = 5 * np.random.default_rng(1).normal(size=(20, corners.shape[1]))
    system = np.vstack([corners.T, np.ones(len(corners))])
    affine = np.linalg.solve(system, np.vstack([x.T, np.ones(20)])).T
    assert abs(BarycentricCoordinates(corners).weights(x) - affine).max() < 1e-12


@pytest.mark.parametrize("d", [2, 3])
def test_in_a_cube_they_are_products_of_linear_functions(d):
    """Bilinear and trilinear interpolation, everywhere in space: the sum is a constant."""
    corners = CUBE[: 2**d, -d:]
    x = 3 * np.random.default_rng(2).normal(size=(20, d))
    exact = np.where(corners == 1, x[:, None], 1 - x[:, None]).prod(axis=2)
    size = abs(exact).max(axis=1, keepdims=True)
    assert (abs(BarycentricCoordinates(corners).weights(x) - exact) / size).max() < 1e-12


@pytest.mark.parametrize("n", [4, 5, 6, 12])
def test_in_a_regular_polygon_they_have_its_symmetry(n):
    """1/n in the middle; and a turn by one corner moves each weight by one."""
    corners = regular(n)
    coordinates = BarycentricCoordinates(corners)
    assert abs(coordinates.weights([0.0, 0.0]) - 1 / n).max() < EXACT
    x = inside(corners)
    c, s = corners[1]
    turned = coordinates.weights(x @ np.array([[c, s], [-s, c]]))
    assert abs(turned - np.roll(coordinates.weights(x), 1, axis=1)).max() < EXACT


def test_in_an_octahedron_either_diagonal_of_the_polar_cube_s_squares_will_do():
    """Volumes of the cones over the polar dual's facets, in rational numbers."""
    x = [Fraction(1, 8), Fraction(-1, 4), Fraction(3, 16)]
    signs = [(a, b, c) for a in (1, -1) for b in (1, -1) for c in (1, -1)]
    h = {s: 1 - sum(u * v for u, v in zip(s, x, strict=True)) for s in signs}

    def term(*t):
        rows = [list(s) for s in t]
        det = sum(
            rows[0][a]
            * (
                rows[1][(a + 1) % 3] * rows[2][(a + 2) % 3]
                - rows[1][(a + 2) % 3] * rows[2][(a + 1) % 3]
            )
            for a in range(3)
        )
        return abs(det) / (h[t[0]] * h[t[1]] * h[t[2]])

    w = []
    for sign in (1, -1):
        for k in range(3):
            square = [s for s in signs if s[k] == sign]
            other = [j for j in range(3) if j != k]
            square.sort(key=lambda s, o=other: (s[o[0]], s[o[0]] * s[o[1]]))  # once round
            a, b, c, e = square
            assert term(a, b, c) + term(a, c, e) == term(b, c, e) + term(b, e, a)
            w.append(term(a, b, c) + term(a, c, e))
    exact = np.array([float(v / sum(w)) for v in w])
    found = BarycentricCoordinates(OCTAHEDRON).weights([float(v) for v in x])
    assert abs(found - exact).max() < EXACT


# --- polyhedra ----------------------------------------------------------------------------------


@pytest.mark.parametrize("corners", POLYHEDRA.values(), ids=POLYHEDRA)
def test_positions_come_back_from_positive_weights(corners):
    """Linear precision in every polyhedron, simple or not."""
    x = inside(corners)
    w = BarycentricCoordinates(corners).weights(x)
    assert (w >= 0).all()
    assert abs(w.sum(axis=1) - 1).max() < EXACT
    assert abs(w @ corners - x).max() < EXACT


@pytest.mark.parametrize("corners", [*POLYHEDRA.values(), HEXAGON, regular(40)])
def test_at_corners_all_other_weights_are_exactly_zero(corners):
    """Also where more than three faces meet, and where nothing is a binary fraction."""
    q = ortho_group.rvs(corners.shape[1], random_state=3)
    for p in (corners, corners @ q + 0.1, 1e-150 * corners):
        assert (BarycentricCoordinates(p).weights(p) == np.eye(len(p))).all()


@pytest.mark.parametrize("corners", POLYHEDRA.values(), ids=POLYHEDRA)
def test_on_a_face_only_its_corners_have_weights(corners):
    """And on an edge its two ends share by distance."""
    coordinates = BarycentricCoordinates(corners)
    for face in Polytope.of(corners).faces:
        x = inside(corners[face], 5)
        w = coordinates.weights(x)
        others = np.setdiff1d(np.arange(len(corners)), face)
        assert abs(w[:, others]).max() < 1e-15
        p, q = corners[face[0]], corners[face[1]]
        w = coordinates.weights(p + 0.25 * (q - p))[0]
        assert abs(w[face[:2]] - [0.75, 0.25]).max() < EXACT


@pytest.mark.parametrize("distance", [1e-2, 1e-8, 1e-15, 1e-100])
def test_beside_a_corner_of_many_faces_linear_fields_still_come_back(distance):
    """Values and gradients, although all products vanish there."""
    for corners, i in ((PYRAMID, 4), (OCTAHEDRON - OCTAHEDRON[0], 0)):
        corners = corners - corners[i]
        x = distance * (inside(corners, 20, seed=4) - corners[i])
        coordinates = BarycentricCoordinates(corners)
        assert abs(coordinates.weights(x) @ corners - x).max() < EXACT * distance
        gradient = coordinates.field(corners @ [1.0, 2.0, 3.0]).gradient(x)
        assert abs(gradient - [1, 2, 3]).max() < 1e-12
        # of degree one along rays out of the corner, so its gradient is constant there
        s = coordinates.field(np.cos(np.arange(len(corners))))
        if distance < 1e-7:
            assert abs(s.gradient(x) - s.gradient(x / 2)).max() < 10 * distance + 1e-12


def split(corners, i, delta):
    """The polyhedron with its corner i cut off at depth `delta`, and which corners come from i."""
    others = np.delete(corners, i, axis=0)
    normals = faces_at(corners, i)
    axis = normals.sum(axis=0) / np.linalg.norm(normals.sum(axis=0))
    new = []
    hull = Polytope.of(corners)
    for j in range(len(corners)):
        shared = [f for f in hull.faces if i in f and j in f]
        if j != i and len(shared) == 2:
            t = delta / (axis @ (corners[i] - corners[j]))
            new.append(corners[i] + t * (corners[j] - corners[i]))
    return np.vstack([others, new]), len(others)


@pytest.mark.parametrize(("corners", "i"), [(PYRAMID, 4), (OCTAHEDRON, 2)])
def test_the_polar_dual_is_the_limit_of_split_corners(corners, i):
    """The slides' perturbation: a corner of four faces as four of three, to order one."""
    x = 0.6 * inside(corners, 10, seed=5) + 0.4 * corners.mean(axis=0)
    exact = BarycentricCoordinates(corners).weights(x)
    deltas, errors = [1e-2, 1e-4, 1e-6], []
    for delta in deltas:
        near, kept = split(corners, i, delta)
        w = BarycentricCoordinates(near).weights(x)
        together = np.insert(w[:, :kept], i, w[:, kept:].sum(axis=1), axis=1)
        errors.append(abs(together - exact).max())
    ratio = np.array(errors) / deltas
    assert 1e-2 < ratio.min() <= ratio.max() < 10
    assert ratio.max() / ratio.min() < 1.1


def test_three_faces_do_not_make_a_corner_of_four():
    """The slides' definition, read with any three of the faces, loses linear fields."""
    for corners in (PYRAMID, OCTAHEDRON):
        x = inside(corners, 1, seed=6)[0]
        assert abs(slides_weights(corners, x) @ corners - x).max() > 0.01
    for corners in (CUBE, TETRAHEDRON):
        x = inside(corners, 1, seed=6)[0]
        assert abs(slides_weights(corners, x) @ corners - x).max() < 1e-12


def test_the_volume_is_that_of_the_normals_without_its_sign():
    """The determinant changes sign with the order of two faces, which the slides leave open."""
    corners = regular(5)
    x = np.array([0.1, 0.2])

    def signed(n):
        return np.linalg.det(n)

    assert abs(slides_weights(corners, x) @ corners - x).max() < 1e-12
    assert abs(slides_weights(corners, x, signed) @ corners - x).max() > 0.05


# --- mistakes that the laws see -----------------------------------------------------------------


class Spoiled(BarycentricCoordinates):
    """With another set of terms."""

    def __init__(self, vertices):
        super().__init__(vertices)
        faces = Polytope.of(self.points).corner_faces
        self._form = self.spoil(ProductForm(self._form.normals, faces), faces)


class FirstThreeFaces(Spoiled):
    def spoil(self, form, faces):
        return ProductForm(form.normals, [f[:3] for f in faces])


class SignedVolumes(Spoiled):
    def spoil(self, form, faces):
        form.volume = np.linalg.det(form.normals[np.array(faces)])
        return form


class UnitVolumes(Spoiled):
    def spoil(self, form, _):
        form.volume = np.ones_like(form.volume)
        return form


@pytest.mark.parametrize(
    ("mutant", "name"),
    [
        (FirstThreeFaces, "octahedron"),
        (FirstThreeFaces, "square pyramid"),
        (SignedVolumes, "hexagon"),
        (UnitVolumes, "quadrilateral"),
    ],
)
def test_the_law_of_reproduction_sees_wrong_volumes(mutant, name):
    """Linear fields do not come back from any of these."""
    wrong = replace(case(f"coordinates of the {name}"), make=lambda p, _: mutant(p))
    with pytest.raises((AssertionError, np.linalg.LinAlgError)):
        laws.polynomials_of_its_degree_are_reproduced(wrong)


# --- invariance ---------------------------------------------------------------------------------


@pytest.mark.parametrize("corners", [HEXAGON, PYRAMID, POLYHEDRA["dodecahedron"]])
def test_any_affine_map_keeps_the_weights(corners):
    """They belong to the affine shape: shears, offsets and units do not matter."""
    d = corners.shape[1]
    x = inside(corners)
    w = BarycentricCoordinates(corners).weights(x)
    rng = np.random.default_rng(7)
    for scale, offset in ((1.0, 0.0), (1e150, 0.0), (1e-150, 0.0), (1.0, 1e6)):
        a = scale * (np.eye(d) + 0.3 * rng.normal(size=(d, d)))
        moved = BarycentricCoordinates(corners @ a + offset)
        assert abs(moved.weights(x @ a + offset) - w).max() < 1e-12 + 1e-15 * offset


def test_thin_polygons_keep_their_digits():
    """A width of 1e-12 of the length is a shape like any other."""
    thin = HEXAGON * [1.0, 1e-12]
    x = inside(HEXAGON)
    w = BarycentricCoordinates(thin).weights(x * [1.0, 1e-12])
    assert abs(w - BarycentricCoordinates(HEXAGON).weights(x)).max() < 1e-12


@pytest.mark.slow
@pytest.mark.parametrize("n", [16, 17, 400, 3000])
def test_products_of_many_heights_stay_in_range(n):
    """Three thousand of them go from 1e-900 to one, and a corner has two."""
    corners = regular(n)
    coordinates = BarycentricCoordinates(corners)
    x = np.vstack([[0, 0], 0.999 * corners[1:2], corners[:2], corners[:2].mean(axis=0)[None]])
    w = coordinates.weights(x)
    assert abs(w @ corners - x).max() < 1e-12
    assert abs(w[0] - 1 / n).max() < 1e-12
    s = coordinates.field(corners @ [1.0, 2.0])
    assert abs(s.gradient(x) - [1, 2]).max() < 1e-7


@settings(max_examples=60)
@given(st.integers(0, 2**32), st.integers(4, 14), st.sampled_from([2, 3]))
def test_random_polytopes(seed, n, d):
    """Hulls of random points on spheres: partition of unity, positions, positivity, gradients."""
    rng = np.random.default_rng(seed)
    corners = rng.normal(size=(n, d))
    corners /= np.linalg.norm(corners, axis=1)[:, None]
    corners = corners @ (np.eye(d) + 0.3 * rng.normal(size=(d, d)))
    assume(np.linalg.svd(corners - corners[0], compute_uv=False)[-1] > 1e-2)
    assume(pdist(corners).min() > 1e-2)
    coordinates = BarycentricCoordinates(corners)
    x = inside(corners, 5, seed=1)
    w = coordinates.weights(x)
    assert w.min() >= -1e-12
    assert abs(w.sum(axis=1) - 1).max() < 1e-12
    assert abs(w @ corners - x).max() < 1e-10
    g = np.stack(coordinates.gradient_weights(x), axis=-1)
    size = abs(g).max()
    assert abs(g.sum(axis=1)).max() < 1e-12 * size
    jacobian = np.einsum("mnk,nj->mjk", g, corners)
    assert abs(jacobian - np.eye(d)).max() < 1e-12 * size + 1e-10


@settings(max_examples=40)
@given(st.integers(2, 40), st.integers(1, 4), st.integers(0, 2**32))
def test_products_without_some_factors(n, omitted, seed):
    """The tree gives what multiplying the others gives, zeros included."""
    rng = np.random.default_rng(seed)
    sets = list(combinations(range(n), min(omitted, n - 1)))
    sets = np.array([sets[k] for k in rng.integers(len(sets), size=5)])
    h = rng.choice([0.0, 0.5, -1.0, 1.5], size=(n, 6))
    found, exponent = _Products(n, sets)(h[:, None])
    found = found[:, 0] if exponent is None else np.ldexp(found[:, 0], np.maximum(exponent, -1100))
    for row, without in zip(found, sets, strict=True):
        assert row == pytest.approx(np.delete(h, without, axis=0).prod(axis=0), rel=1e-14)


def test_the_edges_of_a_polygon_come_once_round_it():
    """Whatever the order of the corners: each edge begins where the last ended, anticlockwise."""
    rng = np.random.default_rng(8)
    for n in (3, 4, 5, 6, 17):
        corners = regular(n)[rng.permutation(n)] * [3.0, 1.0]
        polygon = Polytope.of(corners)
        begin, end = np.array(polygon.faces).T
        assert (begin == np.roll(end, 1)).all()
        turn = np.linalg.det(np.stack([corners[begin], corners[end]], axis=1))
        assert (turn > 0).all()
        assert (np.einsum("ad,ad->a", polygon.normals, corners[begin]) > 0).all()


# --- refusals -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("vertices", "words"),
    [
        ([[0, 0], [2, 0], [1, 1], [2, 2], [0, 2]], r"vertex 2, \(1, 1\), lies inside the hull"),
        ([[0, 0], [1, 0], [2, 0], [2, 2]], r"vertex 1, \(1, 0\), lies on the boundary of the hull"),
        ([[0, 0], [0.1, 0.3], [0.3, 0.9], [2, 0]], r"vertex 1, .* lies on the boundary"),
        ([[0, 0], [1, 0], [0, 0], [0, 1]], r"vertex 0, \(0, 0\), and vertex 2 coincide"),
        ([*CUBE, [0.5, 0.5, 0.5]], r"corners of a convex polyhedron; vertex 8, .* lies inside"),
        ([*CUBE, [0.5, 0.5, 1.0]], r"vertex 8, \(0.5, 0.5, 1\), lies on the boundary"),
        ([*CUBE, [0.5, 1.0, 1.0]], r"vertex 8, \(0.5, 1, 1\), lies on the boundary"),
        ([[0.0], [1.0]], r"vertices must have 2 or 3 coordinates; got the shape \(2, 1\)"),
        (np.zeros((6, 4)), "vertices must have 2 or 3 coordinates"),
        ([[0, 0], [1, np.nan], [0, 1]], r"vertices must be finite; vertices\[1, 1\] is nan"),
        ([1.0, 2.0], r"vertices must have the shape \(n, d\)"),
    ],
)
def test_what_is_no_convex_polytope_is_refused(vertices, words):
    """By the vertex that is none of its corners, and where that lies."""
    with pytest.raises(ValueError, match=words):
        BarycentricCoordinates(vertices)


@pytest.mark.parametrize(
    ("vertices", "words"),
    [
        ([[0, 0], [1, 1]], "the vertices lie on a line: they are not the corners of a polygon"),
        ([[0, 0], [1, 1], [3, 3], [0.5, 0.5]], "the vertices lie on a line"),
        (
            [[0, 0, 0], [1, 0, 0], [0, 1, 0]],
            "lie in a plane: they are not the corners of a polyhedron",
        ),
        ([[0, 0, 1], [1, 0, 1], [0, 1, 1], [1, 1, 1]], "the vertices lie in a plane"),
        ([[1e6, 0], [1e6 + 1e-9, 0], [1e6, 1e-20]], "the vertices lie on a line"),
    ],
)
def test_flat_polytopes_are_refused(vertices, words):
    """Too few vertices, or all on a line or in a plane."""
    with pytest.raises(np.linalg.LinAlgError, match=words):
        BarycentricCoordinates(vertices)


def test_a_midpoint_of_an_edge_is_refused_though_rounding_moves_it():
    """Outwards or inwards, in any direction, near an end or not."""
    for seed in range(20):
        q = ortho_group.rvs(3, random_state=seed)
        cube = CUBE @ q
        rng = np.random.default_rng(seed)
        p = rng.choice([0.5, 0.001]) * (cube[1] - cube[0]) + cube[0]
        with pytest.raises(ValueError, match=r"vertex 8, .* lies on the boundary"):
            BarycentricCoordinates(np.vstack([cube, p]))
        square = CUBE[:4, 1:] @ q[:2, :2]
        p = 0.3 * square[1] + 0.7 * square[0]
        with pytest.raises(ValueError, match=r"vertex 4, .* lies on the boundary"):
            BarycentricCoordinates(np.vstack([square, p]))


def test_outside_there_is_a_curve_without_values():
    """Where the sum of the products vanishes: here the line 4x + 3y + 12 = 0, through two poles."""
    coordinates = BarycentricCoordinates([[0, 0], [2, 0], [3, 2], [0, 1]])
    corners = coordinates.points
    for x in ([-3.0, 0.0], [0.0, -4.0], [-1.5, -2.0]):
        for ask in (coordinates.weights, coordinates.field(np.ones(4)).gradient):
            with pytest.raises(np.linalg.LinAlgError, match=r"no value at .*: the weights of the"):
                ask(x)
        beyond = np.array(x) - [1.0, 1.0]
        assert abs(coordinates.weights(beyond) @ corners - beyond).max() < 1e-12
        assert coordinates.weights(beyond).min() < 0


def test_so_far_away_that_nothing_is_left_is_refused():
    """Rather than answered by rounding."""
    with pytest.raises(np.linalg.LinAlgError, match="the weights of the corners cancel"):
        BarycentricCoordinates(HEXAGON).weights([1e30, 0.0])


def test_there_is_no_gradient_at_a_corner_of_more_than_three_faces():
    """There is at the others."""
    s = BarycentricCoordinates(PYRAMID).field(np.arange(5.0))
    with pytest.raises(ValueError, match=r"no gradient at the corner \(0, 0, 2\), where more than"):
        s.gradient(PYRAMID)
    assert np.isfinite(s.gradient(PYRAMID[:4])).all()
    assert s(PYRAMID).tolist() == [0, 1, 2, 3, 4]


def test_the_golden_ratio_makes_regular_faces():
    """Qhull's triangles are one pentagon, whatever the rounding."""
    hull = Polytope.of(POLYHEDRA["dodecahedron"] * GOLDEN)
    assert [len(f) for f in hull.faces] == [5] * 12
    hull = Polytope.of(POLYHEDRA["rhombic dodecahedron"] @ ortho_group.rvs(3, random_state=1))
    assert sorted(len(f) for f in hull.corner_faces) == [3] * 8 + [4] * 6
