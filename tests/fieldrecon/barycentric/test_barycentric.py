"""Barycentric coordinates: rational arithmetic, closed forms, and the formula of the slides."""

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
from fieldrecon._core import chunks as _chunks
from fieldrecon.barycentric.coordinates import BarycentricCoordinates
from fieldrecon.barycentric.polytope import ROUNDINGS, Polytope, around, hanging_vertices
from fieldrecon.barycentric.wachspress import ProductForm, _Products
from fieldrecon.polynomials import EPS
from laws import assert_close
from polytopes import CUBE, GOLDEN, HEXAGON, OCTAHEDRON, POLYHEDRA, PYRAMID, TETRAHEDRON, regular

EXACT = 1e-13


def inside(corners, m=50, seed=0):
    """Random points (m, d) of the polytope, some close to its faces."""
    share = np.random.default_rng(seed).dirichlet(np.full(len(corners), 0.4), m)
    return share @ corners


def faces_at(corners, i):
    """Outward unit normals of the faces at corner i, from Qhull only."""
    hull = ConvexHull(corners)
    planes = np.unique(hull.equations.round(12), axis=0)
    on = np.abs(corners @ planes[:, :-1].T + planes[:, -1]) < 1e-9
    return planes[on[i], :-1]


def slides_weights(corners, x, volume=lambda n: abs(np.linalg.det(n))):
    """The slides' quotient vol(N_i) / prod n^T (p_i - x) of the first d faces at each corner."""
    d = corners.shape[1]
    w = np.empty(len(corners))
    for i, p in enumerate(corners):
        normals = faces_at(corners, i)[:d]
        w[i] = volume(normals) / np.prod(normals @ (p - x))
    return w / w.sum()


# --- rational arithmetic ------------------------------------------------------------------------


def rational_weights(corners, x):
    """Exact weights, in product form, of a polygon with anticlockwise corners."""
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
# offsets from an edge or a corner, to both sides
BESIDE = (0.0, 1e-300, 1e-20, 1e-16, -1e-16, 1e-12, 1e-8, -1e-8)


@pytest.mark.slow
@pytest.mark.parametrize("corners", POLYGONS.values(), ids=POLYGONS)
@pytest.mark.parametrize("offset", BESIDE)
def test_weights_near_an_edge_equal_rational_arithmetic(corners, offset):
    """This holds at any distance from the edge, where quotients of the slides become infinite."""
    coordinates = BarycentricCoordinates(corners)
    for a in range(len(corners)):
        p, q = corners[a], corners[(a + 1) % len(corners)]
        for t in (1e-9, 0.3, 0.5):
            x = p + t * (q - p) + offset * np.array([p[1] - q[1], q[0] - p[0]])
            assert abs(coordinates.weights(x) - rational_weights(corners, x)).max() < 1e-14


@pytest.mark.parametrize("offset", BESIDE)
def test_weights_near_a_corner_equal_rational_arithmetic(offset):
    """This holds in every direction from the corner."""
    coordinates = BarycentricCoordinates(HEXAGON)
    for p in HEXAGON:
        for direction in regular(7):
            x = p + offset * direction
            assert abs(coordinates.weights(x) - rational_weights(HEXAGON, x)).max() < 1e-14


def test_the_quotient_of_the_slides_is_silently_wrong_on_an_edge():
    """The two heights in the denominators are rounding errors, so their ratio is arbitrary."""
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
def test_coordinates_of_a_simplex_are_affine(corners):
    """They are the only solution of Σ w = 1 and Σ w p = x, inside and outside."""
    corners = np.array(corners, dtype=float)
    x = 5 * np.random.default_rng(1).normal(size=(20, corners.shape[1]))
    system = np.vstack([corners.T, np.ones(len(corners))])
    affine = np.linalg.solve(system, np.vstack([x.T, np.ones(20)])).T
    assert abs(BarycentricCoordinates(corners).weights(x) - affine).max() < 1e-12


@pytest.mark.parametrize("d", [2, 3])
def test_coordinates_of_a_cube_are_multilinear(d):
    """This is bilinear and trilinear interpolation.

    It holds in all of space, because the denominator is constant.
    """
    corners = CUBE[: 2**d, -d:]
    x = 3 * np.random.default_rng(2).normal(size=(20, d))
    exact = np.where(corners == 1, x[:, None], 1 - x[:, None]).prod(axis=2)
    size = abs(exact).max(axis=1, keepdims=True)
    assert (abs(BarycentricCoordinates(corners).weights(x) - exact) / size).max() < 1e-12


@pytest.mark.parametrize("n", [4, 5, 6, 12])
def test_coordinates_of_a_regular_polygon_are_symmetric(n):
    """The weights of the centre are 1/n.

    A rotation by one corner permutes the weights cyclically.
    """
    corners = regular(n)
    coordinates = BarycentricCoordinates(corners)
    assert abs(coordinates.weights([0.0, 0.0]) - 1 / n).max() < EXACT
    x = inside(corners)
    c, s = corners[1]
    rotated = coordinates.weights(x @ np.array([[c, s], [-s, c]]))
    assert abs(rotated - np.roll(coordinates.weights(x), 1, axis=1)).max() < EXACT


def test_coordinates_of_an_octahedron_do_not_depend_on_the_triangulation_of_its_dual():
    """The weights are volumes of cones over the facets of the polar dual, in rational arithmetic.

    Each facet is a square, and both diagonals give the same volume.
    """
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
            square.sort(key=lambda s, o=other: (s[o[0]], s[o[0]] * s[o[1]]))  # in cyclic order
            a, b, c, e = square
            assert term(a, b, c) + term(a, c, e) == term(b, c, e) + term(b, e, a)
            w.append(term(a, b, c) + term(a, c, e))
    exact = np.array([float(v / sum(w)) for v in w])
    found = BarycentricCoordinates(OCTAHEDRON).weights([float(v) for v in x])
    assert abs(found - exact).max() < EXACT


# --- polyhedra ----------------------------------------------------------------------------------


@pytest.mark.parametrize("corners", POLYHEDRA.values(), ids=POLYHEDRA)
def test_coordinates_are_positive_with_linear_precision(corners):
    """This holds in every polyhedron, also if more than three faces meet at a corner."""
    x = inside(corners)
    w = BarycentricCoordinates(corners).weights(x)
    assert (w >= 0).all()
    assert abs(w.sum(axis=1) - 1).max() < EXACT
    assert abs(w @ corners - x).max() < EXACT


@pytest.mark.parametrize("corners", [*POLYHEDRA.values(), HEXAGON, regular(40)])
def test_weights_at_corners_are_exactly_zero_or_one(corners):
    """More than three faces may meet, and coordinates need not be binary fractions."""
    q = ortho_group.rvs(corners.shape[1], random_state=3)
    for p in (corners, corners @ q + 0.1, 1e-150 * corners):
        assert (BarycentricCoordinates(p).weights(p) == np.eye(len(p))).all()


@pytest.mark.parametrize("corners", POLYHEDRA.values(), ids=POLYHEDRA)
def test_weights_on_a_face_vanish_except_at_its_corners(corners):
    """On an edge the weights are linear."""
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
def test_linear_fields_are_reproduced_near_a_corner_of_many_faces(distance):
    """Values and gradients are accurate, although all products vanish at the corner."""
    for corners, i in ((PYRAMID, 4), (OCTAHEDRON - OCTAHEDRON[0], 0)):
        corners = corners - corners[i]
        x = distance * (inside(corners, 20, seed=4) - corners[i])
        coordinates = BarycentricCoordinates(corners)
        assert abs(coordinates.weights(x) @ corners - x).max() < EXACT * distance
        gradient = coordinates.field(corners @ [1.0, 2.0, 3.0]).gradient(x)
        assert abs(gradient - [1, 2, 3]).max() < 1e-12
        # the field is linear along rays from the corner, so its gradient is constant on them
        s = coordinates.field(np.cos(np.arange(len(corners))))
        if distance < 1e-7:
            assert abs(s.gradient(x) - s.gradient(x / 2)).max() < 10 * distance + 1e-12


def split(corners, i, delta):
    """The polyhedron with corner i cut off at depth `delta`; the index of the first new corner."""
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
    """The slides perturb a corner of four faces to four corners of three faces.

    The difference of the weights is proportional to the perturbation.
    """
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


def test_three_of_four_faces_at_a_corner_lose_linear_precision():
    """The definition on the slides, read with any three of the faces, loses linear fields."""
    for corners in (PYRAMID, OCTAHEDRON):
        x = inside(corners, 1, seed=6)[0]
        assert abs(slides_weights(corners, x) @ corners - x).max() > 0.01
    for corners in (CUBE, TETRAHEDRON):
        x = inside(corners, 1, seed=6)[0]
        assert abs(slides_weights(corners, x) @ corners - x).max() < 1e-12


def test_the_volume_of_the_normals_is_an_absolute_value():
    """The sign of the determinant depends on the order of the faces, which the slides omit."""
    corners = regular(5)
    x = np.array([0.1, 0.2])

    def signed(n):
        return np.linalg.det(n)

    assert abs(slides_weights(corners, x) @ corners - x).max() < 1e-12
    assert abs(slides_weights(corners, x, signed) @ corners - x).max() > 0.05


# --- mutants ------------------------------------------------------------------------------------


class Mutant(BarycentricCoordinates):
    """Barycentric coordinates with a changed product form."""

    def __init__(self, vertices):
        super().__init__(vertices)
        faces = Polytope.of(self.points).corner_faces
        self._form = self.spoil(ProductForm(self._form.normals, faces), faces)


class FirstThreeFaces(Mutant):
    def spoil(self, form, faces):
        return ProductForm(form.normals, [f[:3] for f in faces])


class SignedVolumes(Mutant):
    def spoil(self, form, faces):
        form.volume = np.linalg.det(form.normals[np.array(faces)])
        return form


class UnitVolumes(Mutant):
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
def test_wrong_volumes_violate_linear_reproduction(mutant, name):
    wrong = replace(case(f"coordinates of the {name}"), make=lambda p, _: mutant(p))
    with pytest.raises((AssertionError, np.linalg.LinAlgError)):
        laws.polynomials_of_the_degree_are_reproduced(wrong)


# --- invariance ---------------------------------------------------------------------------------


@pytest.mark.parametrize("corners", [HEXAGON, PYRAMID, POLYHEDRA["dodecahedron"]])
def test_weights_are_invariant_under_affine_maps(corners):
    """Shears, offsets and units do not change the weights."""
    d = corners.shape[1]
    x = inside(corners)
    w = BarycentricCoordinates(corners).weights(x)
    rng = np.random.default_rng(7)
    for scale, offset in ((1.0, 0.0), (1e150, 0.0), (1e-150, 0.0), (1.0, 1e6)):
        a = scale * (np.eye(d) + 0.3 * rng.normal(size=(d, d)))
        mapped = BarycentricCoordinates(corners @ a + offset)
        assert abs(mapped.weights(x @ a + offset) - w).max() < 1e-12 + 1e-15 * offset


@pytest.mark.parametrize("corners", [HEXAGON, regular(16)], ids=["hexagon", "16-gon"])
def test_weights_of_thin_polygons_are_accurate(corners):
    """The width of the polygon is 1e-12 of its length; products of many heights are numbers."""
    x = inside(corners)
    w = BarycentricCoordinates(corners * [1.0, 1e-12]).weights(x * [1.0, 1e-12])
    assert abs(w - BarycentricCoordinates(corners).weights(x)).max() < 1e-12


@pytest.mark.slow
@pytest.mark.parametrize("n", [16, 17, 400, 3000])
def test_products_of_many_heights_do_not_underflow(n):
    """A product of 3000 heights may be 1e-900; at a corner two of the heights are zero."""
    corners = regular(n)
    coordinates = BarycentricCoordinates(corners)
    x = np.vstack([[0, 0], 0.999 * corners[1:2], corners[:2], corners[:2].mean(axis=0)[None]])
    w = coordinates.weights(x)
    assert abs(w @ corners - x).max() < 1e-12
    assert abs(w[0] - 1 / n).max() < 1e-12
    s = coordinates.field(corners @ [1.0, 2.0])
    assert abs(s.gradient(x) - [1, 2]).max() < 1e-7


@pytest.mark.slow
@settings(max_examples=60)
@given(st.integers(0, 2**32), st.integers(4, 14), st.sampled_from([2, 3]))
def test_coordinates_of_random_polytopes_have_linear_precision(seed, n, d):
    """Corners are random points on an ellipsoid.

    The weights are nonnegative, and gradients of linear fields are exact.
    """
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
def test_products_without_given_factors_equal_direct_multiplication(n, omitted, seed):
    """Some of the factors are zero."""
    rng = np.random.default_rng(seed)
    sets = list(combinations(range(n), min(omitted, n - 1)))
    sets = np.array([sets[k] for k in rng.integers(len(sets), size=5)])
    h = rng.choice([0.0, 0.5, -1.0, 1.5], size=(n, 6))
    found, exponent = _Products(n, sets)(h[:, None])
    found = found[:, 0] if exponent is None else np.ldexp(found[:, 0], np.maximum(exponent, -1100))
    for row, without in zip(found, sets, strict=True):
        assert row == pytest.approx(np.delete(h, without, axis=0).prod(axis=0), rel=1e-14)


def test_the_edges_of_a_polygon_are_in_anticlockwise_order():
    """The order of the given corners does not matter.

    Each edge begins at the end of the previous one.
    """
    rng = np.random.default_rng(8)
    for n in (3, 4, 5, 6, 17):
        corners = regular(n)[rng.permutation(n)] * [3.0, 1.0]
        polygon = Polytope.of(corners)
        begin, end = np.array(polygon.faces).T
        assert (begin == np.roll(end, 1)).all()
        orientation = np.linalg.det(np.stack([corners[begin], corners[end]], axis=1))
        assert (orientation > 0).all()
        assert (np.einsum("ad,ad->a", polygon.normals, corners[begin]) > 0).all()


# --- refusals -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("vertices", "words"),
    [
        ([[0, 0], [2, 0], [1, 1], [2, 2], [0, 2]], r"vertex 2, \(1, 1\), lies inside the hull"),
        ([[0, 0], [1, 0], [0, 0], [0, 1]], r"vertex 0, \(0, 0\), and vertex 2 coincide"),
        ([[0, 0], [1, 0], [2, 0], [1, 0], [0, 1]], r"vertex 1, \(1, 0\), and vertex 3 coincide"),
        ([*CUBE, CUBE[0]], r"vertex 0, \(0, 0, 0\), and vertex 8 coincide"),
        ([*CUBE, [0.5, 0.5, 0.5]], r"corners of a convex polyhedron; vertex 8, .* lies inside"),
        ([*CUBE, [0.5, 0.5, 1.0]], r"vertex 8, \(0.5, 0.5, 1\), lies on the boundary"),
        ([*CUBE, [0.5, 1.0, 1.0]], r"vertex 8, \(0.5, 1, 1\), lies on the boundary"),
        ([[0.0], [1.0]], r"vertices must have 2 or 3 coordinates; got the shape \(2, 1\)"),
        (np.zeros((6, 4)), "vertices must have 2 or 3 coordinates"),
        ([[0, 0], [1, np.nan], [0, 1]], r"vertices must be finite; vertices\[1, 1\] is nan"),
        ([1.0, 2.0], r"vertices must have the shape \(n, d\)"),
    ],
)
def test_vertices_of_non_convex_polytopes_are_refused(vertices, words):
    """The message names a vertex that is not a corner of the convex hull, and where it lies."""
    with pytest.raises(ValueError, match=words):
        BarycentricCoordinates(vertices)


@pytest.mark.parametrize(
    ("vertices", "words"),
    [
        ([[0, 0], [1, 1]], "the vertices lie on a line: they are not the corners of a polygon"),
        ([[0, 0], [1, 1], [3, 3], [0.5, 0.5]], "the vertices lie on a line"),
        ([[2, 3]] * 3, "the vertices lie on a line"),
        (
            [[0, 0, 0], [1, 0, 0], [0, 1, 0]],
            "lie in a plane: they are not the corners of a polyhedron",
        ),
        ([[0, 0, 1], [1, 0, 1], [0, 1, 1], [1, 1, 1]], "the vertices lie in a plane"),
        ([[1e6, 0], [1e6 + 1e-9, 0], [1e6, 1e-20]], "the vertices lie on a line"),
        ([[np.cos(k), ROUNDINGS / 2 * EPS * np.sin(k)] for k in range(40)], "lie on a line"),
    ],
)
def test_flat_polytopes_are_refused(vertices, words):
    """There are too few vertices, or all lie on a line or in a plane, up to rounding."""
    with pytest.raises(np.linalg.LinAlgError, match=words):
        BarycentricCoordinates(vertices)


# --- hanging vertices -----------------------------------------------------------------------------


def with_hanging_vertices(seed):
    """A turned polygon far away, its corners, and two vertices inside one edge, one in another."""
    turn = ortho_group.rvs(2, random_state=seed)
    corners = np.array([[0, 0], [3, 0], [4, 2], [1, 3], [-0.5, 1.5]]) @ turn + 10.0 * seed
    inside = [0.3 * corners[1] + 0.7 * corners[0], 0.6 * corners[1] + 0.4 * corners[0]]
    inside += [0.5 * corners[3] + 0.5 * corners[4]]
    order = np.random.default_rng(seed).permutation(8)
    return np.concatenate([corners, inside])[order], np.argsort(order)


def hanging_vertices_have_their_limits(coordinates):
    """Linear from vertex to vertex on their edge; inside the limit as they move onto it."""
    for seed in range(4):
        vertices, number = with_hanging_vertices(seed)
        a, b, one, two = vertices[number[[0, 1, 5, 6]]]
        weights = coordinates(vertices).weights
        queries = np.concatenate(
            [np.random.default_rng(1).dirichlet(np.ones(8), 20) @ vertices, vertices]
        )
        w = weights(queries)
        assert_close(w.sum(axis=1), np.ones(28), 1e-12)
        assert_close(w @ vertices, queries, 1e-11)
        assert_close(w[20:], np.eye(8), 1e-11)
        for t, ends in ((0.25, (a, one)), (0.7, (one, two)), (0.5, (two, b))):
            on = weights([t * ends[1] + (1 - t) * ends[0]])[0]
            which = [int(np.abs(vertices - end).sum(axis=1).argmin()) for end in ends]
            assert_close(on[which], np.array([1 - t, t]), 1e-11)
            assert_close(np.delete(on, which), np.zeros(6), 1e-11)
        outward = vertices[number[:5]].mean(axis=0)
        errors = []
        for pulled in (1e-3, 1e-5):
            moved = vertices.copy()
            for k, way in ((5, 1.0), (6, 1.0), (7, 1.0)):
                moved[number[k]] += way * pulled * (moved[number[k]] - outward)
            errors.append(
                np.abs(BarycentricCoordinates(moved).weights(queries[:20]) - w[:20]).max()
            )
        assert errors[1] < 2e-2 * errors[0] < 2e-2


def test_hanging_vertices_have_the_limits_of_their_coordinates():
    """In any order of the vertices, wherever the polygon lies and however it is turned."""
    hanging_vertices_have_their_limits(BarycentricCoordinates)


@pytest.mark.parametrize("unit", [2.0**-40, 2.0**40])
def test_a_query_is_on_an_edge_with_hanging_vertices_in_any_unit(unit):
    """Up to rounding, and not a little inside; powers of two change no bit of the weights."""
    vertices, number = with_hanging_vertices(1)
    a, b, _, c, _ = vertices[number[:5]]
    on = a + np.linspace(0, 1, 9)[:, None] * (b - a)
    x = np.concatenate([on, on + 1e-9 * (c - on)])
    w = BarycentricCoordinates(vertices).weights(x)
    assert (w[:9, number[5:7]] > 0.1).any(axis=1).sum() == 7
    assert not w[9:, number[5:]].any()
    laws.assert_same_bits(BarycentricCoordinates(unit * vertices).weights(unit * x), w)


@pytest.mark.parametrize(("roundings", "hanging"), [(-8, 1), (0, 1), (8, 1), (-200, 0), (200, 0)])
def test_vertices_off_an_edge_by_rounding_hang_in_it(roundings, hanging):
    """On either side of it, though Qhull sees corners outside; farther off all are corners."""
    corners = np.array([[0, 0], [3, 0], [4, 2], [1, 3], [-0.5, 1.5]])
    off = np.array([0.0, -4 * roundings * EPS])  # the polygon has a size of about four
    vertices = np.array([*corners, *([[0.6, 0], [2.1, 0], [1.5, 0]] + off * [[1], [1.2], [1.4]])])
    for order in (np.arange(8), np.random.default_rng(0).permutation(8)):
        number = np.argsort(order)
        ring, edges = hanging_vertices(vertices[order])
        assert ring.tolist() == (sorted(number[:5]) if hanging else [*range(8)])
        assert [edge.tolist() for edge in edges] == [number[[0, 5, 7, 6, 1]].tolist()] * hanging


def test_a_triangle_may_have_vertices_inside_each_edge():
    """Then it keeps three corners; a vertex inside the triangle leaves all as they are."""
    vertices = np.array([[0, 0], [1, 0], [4, 0], [2, 2], [0, 4], [0, 1], [0, 3]], dtype=float)
    ring, edges = hanging_vertices(vertices)
    assert ring.tolist() == [0, 2, 4]
    assert sorted(edge.tolist() for edge in edges) == [[0, 1, 2], [2, 3, 4], [4, 6, 5, 0]]
    ring, edges = hanging_vertices(np.array([*vertices, [1.0, 1.0]]))
    assert (ring.tolist(), edges) == ([*range(8)], [])


@pytest.mark.parametrize(("bend", "apart"), [(1e-9, 1e-7), (1e-7, 1e-8), (1e-4, 1e-11)])
@pytest.mark.parametrize("side", [-1, 1])
def test_a_vertex_beside_a_nearly_straight_corner_hangs_in_one_edge(bend, apart, side):
    """It is within rounding of the line of the other edge, too, but beyond its end."""
    beside = [1 + side * apart, -bend * (1 - apart)]
    corners, (edge,) = hanging_vertices(np.array([[0, 0], [1, -bend], [2, 0], [1, 1.5], beside]))
    assert corners.tolist() == [0, 1, 2, 3]
    assert edge.tolist() == ([1, 4, 2] if side > 0 else [0, 4, 1])


def test_beyond_an_edge_with_hanging_vertices_linear_fields_are_reproduced():
    """A query on its line is not on the edge."""
    coordinates = BarycentricCoordinates([[0, 0], [1, 0], [2, 0], [3, 2], [0, 1]])
    x = np.array([[-0.5, 0.0], [-1.9, 0.0], [2.5, 0.0], [3.9, 0.0]])
    w = coordinates.weights(x)
    assert_close(w @ coordinates.points, x, 1e-12)
    assert not w[:, 1].any()


class WithoutWeightOnTheirEdge(BarycentricCoordinates):
    """Coordinates of the corners alone, on all edges."""

    def _on_edge(self, x, edge):
        on, t = super()._on_edge(x, edge)
        return np.zeros_like(on), t


def test_the_law_of_hanging_vertices_can_fail():
    """For coordinates whose hanging vertices have no weight anywhere."""
    with pytest.raises(AssertionError):
        hanging_vertices_have_their_limits(WithoutWeightOnTheirEdge)


def test_an_edge_with_inner_vertices_has_no_gradients():
    """Inside, that of the hanging vertex is zero; the values jump at the edge."""
    polygon = BarycentricCoordinates([[0, 0], [1, 0], [2, 0], [2, 2], [0, 2]])
    field = polygon.field([0, 1, 0, 0, 0])
    assert field([[0.5, 0.0], [1.0, 0.0], [0.5, 1e-9]]).tolist() == [0.5, 1.0, 0.0]
    assert_close(field.gradient([[0.5, 0.5]]), np.zeros((1, 2)), 1e-15)
    plain = BarycentricCoordinates([[0, 0], [2, 0], [2, 2], [0, 2]]).field([0, 0, 3, 0])
    hessian = polygon.field([0, 1, 0, 3, 0]).hessian([[0.5, 0.5]])
    assert_close(hessian, plain.hessian([[0.5, 0.5]]), 1e-14)
    for derivative in (field.gradient, field.hessian):
        with pytest.raises(ValueError, match=r"no gradient at \(0.5, 0\), on an edge .* vertex 1"):
            derivative([[0.5, 0.0]])


def test_a_point_on_an_edge_is_refused_despite_rounding():
    """Rounding may move the point outwards or inwards."""
    for seed in range(20):
        q = ortho_group.rvs(3, random_state=seed)
        cube = CUBE @ q
        rng = np.random.default_rng(seed)
        p = rng.choice([0.5, 0.001]) * (cube[1] - cube[0]) + cube[0]
        with pytest.raises(ValueError, match=r"vertex 8, .* lies on the boundary"):
            BarycentricCoordinates(np.vstack([cube, p]))


def test_weights_have_a_pole_outside_where_the_products_cancel():
    """For this quadrilateral the sum of the products vanishes on the line 4x + 3y + 12 = 0."""
    coordinates = BarycentricCoordinates([[0, 0], [2, 0], [3, 2], [0, 1]])
    corners = coordinates.points
    for x in ([-3.0, 0.0], [0.0, -4.0], [-1.5, -2.0]):
        for evaluate in (coordinates.weights, coordinates.field(np.ones(4)).gradient):
            with pytest.raises(np.linalg.LinAlgError, match=r"no value at .*: the weights of the"):
                evaluate(x)
        beyond = np.array(x) - [1.0, 1.0]
        assert abs(coordinates.weights(beyond) @ corners - beyond).max() < 1e-12
        assert coordinates.weights(beyond).min() < 0


def test_queries_with_complete_cancellation_are_refused():
    """At a distance of 1e30 only rounding errors would be left."""
    with pytest.raises(np.linalg.LinAlgError, match="the weights of the corners cancel"):
        BarycentricCoordinates(HEXAGON).weights([1e30, 0.0])


def test_there_is_no_gradient_at_a_corner_of_more_than_three_faces():
    """At a corner of three faces the gradient exists."""
    s = BarycentricCoordinates(PYRAMID).field(np.arange(5.0))
    for derivative in (s.gradient, s.hessian):
        with pytest.raises(ValueError, match=r"no gradient at the corner \(0, 0, 2\), where more "):
            derivative(PYRAMID)
    assert np.isfinite(s.gradient(PYRAMID[:4])).all()
    assert s(PYRAMID).tolist() == [0, 1, 2, 3, 4]


def test_of_many_queries_the_one_without_derivatives_is_named(monkeypatch):
    """Whichever part of the queries it is in."""
    monkeypatch.setattr(_chunks, "CHUNK_BYTES", 2**12)
    s = BarycentricCoordinates(PYRAMID).field(np.arange(5.0))
    inside = np.mean(PYRAMID, axis=0)
    x = np.vstack([np.tile(inside, (300, 1)), PYRAMID[4:], np.tile(inside, (7, 1))])
    for derivative in (s.gradient, s.hessian):
        with pytest.raises(ValueError, match=r"no gradient at the corner \(0, 0, 2\)"):
            derivative(x)


def test_triangles_of_qhull_are_merged_to_faces():
    """A dodecahedron has twelve pentagons, whatever the rounding of its coordinates."""
    hull = Polytope.of(POLYHEDRA["dodecahedron"] * GOLDEN)
    assert [len(f) for f in hull.faces] == [5] * 12
    hull = Polytope.of(POLYHEDRA["rhombic dodecahedron"] @ ortho_group.rvs(3, random_state=1))
    assert sorted(len(f) for f in hull.corner_faces) == [3] * 8 + [4] * 6


@pytest.mark.parametrize("length", [1e-150, 1.0, 1e150])
def test_vectors_are_ordered_by_their_angle_in_any_unit(length):
    """Counter-clockwise about the axis, whichever comes first."""
    angle = np.random.default_rng(0).permutation(9) * 0.6
    vectors = np.column_stack([np.cos(angle), np.sin(angle), np.sin(3 * angle)])
    order = around(length * vectors, np.array([0.0, 0.0, 2.0]))
    turns = np.diff(angle[order], append=angle[order[0]]) % (2 * np.pi)
    assert turns.sum() == pytest.approx(2 * np.pi)
