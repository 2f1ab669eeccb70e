"""Audit of triangle meshes: every planted error is found at its location, and nothing else."""

import itertools
import json
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import exact_triangles as literal
from fieldrecon.io.meshes import read_triangles, write_triangles
from fieldrecon.triangles import bounding_volumes, duplicates
from fieldrecon.triangles import intersections as _contacts
from fieldrecon.triangles import intersections as _triangle_pairs
from fieldrecon.triangles import predicates as _predicates
from fieldrecon.triangles.audit import CONCERNS, audit_mesh, unit_of
from fieldrecon.triangles.intersections import close_pairs, contacts
from fieldreport.experiments.triangles.planted_errors import planted_errors
from fieldreport.experiments.triangles.triangle_shapes import (
    band,
    bumpy,
    cube,
    klein_bottle,
    sphere,
    together,
    torus,
    turned_over,
)

PLANTED = planted_errors(1)


def scaled(surface, factor):
    return surface[0] * factor, surface[1]


def translated(surface, *by):
    return surface[0] + by, surface[1]


CLEAN = {
    "sphere": sphere(2),
    "bumpy sphere": bumpy(2),
    "cube": cube(3),
    "torus": torus(17, 9),
    "two bodies": together(sphere(1), translated(sphere(1), 3, 0, 0)),
    "two bodies within each other's boxes": together(torus(19, 7), scaled(sphere(1), 0.4)),
    "hollow": together(sphere(1), turned_over(scaled(sphere(1), 0.5))),
    "body in a hollow": together(
        sphere(1), turned_over(scaled(sphere(1), 0.7)), scaled(cube(1), 0.3)
    ),
}
ROTATION = np.linalg.qr(np.random.default_rng(7).normal(size=(3, 3)))[0]
ROTATION *= np.sign(np.linalg.det(ROTATION))


def soup(surface):
    points, triangles = surface
    return points[triangles].reshape(-1, 3), np.arange(triangles.size).reshape(-1, 3)


# --- meshes without errors ------------------------------------------------------------------------


@pytest.mark.parametrize("surface", CLEAN.values(), ids=CLEAN)
def test_correct_closed_meshes_have_no_findings(surface):
    """They are one or several solids, also with cavities, as a mesh and as a polygon soup."""
    audit = audit_mesh(*surface)
    assert (audit.found, audit.clean, audit.soup) == ({}, True, False)
    as_soup = audit_mesh(*soup(surface))
    assert (as_soup.found, as_soup.soup) == ({}, True)
    assert as_soup.parts == audit.parts


@pytest.mark.parametrize(
    ("surface", "found"),
    [
        (band(20, half_turns=0), {"boundary_loops": 2}),
        (band(20, half_turns=2), {"boundary_loops": 2}),
        (band(20, half_turns=1), {"boundary_loops": 1, "one_sided_triangles": 40}),
        (([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]), {"boundary_loops": 1}),
    ],
    ids=["ring", "two half turns", "Möbius", "triangle"],
)
def test_open_meshes_have_boundary_loops_only(surface, found):
    """A Möbius band is also one-sided."""
    assert audit_mesh(*surface).found == found


def test_a_klein_bottle_is_one_sided_and_intersects_itself():
    """It has no boundary, so only the orientation distinguishes it from a solid."""
    audit = audit_mesh(*klein_bottle(30, 14))
    assert len(audit.one_sided_triangles) == audit.triangles
    assert {*audit.found} == {"one_sided_triangles", "crossings"}


# --- planted errors, read from a file -------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("suffix", [".ply", ".obj", ".off"])
@pytest.mark.parametrize("error", PLANTED)
def test_each_planted_error_is_found_in_a_file(error, suffix, tmp_path):
    """Nothing else is found."""
    write_triangles(tmp_path / f"mesh{suffix}", *PLANTED[error].surface)
    points, triangles = read_triangles(tmp_path / f"mesh{suffix}")
    audit = audit_mesh(points, triangles)
    assert audit.found == PLANTED[error].found
    assert not audit.soup


@pytest.mark.parametrize("error", PLANTED)
def test_each_planted_error_is_found_in_a_polygon_soup(error, tmp_path):
    """Errors of the surface are found in an STL file; errors of shared vertices are not.

    STL has single precision, and so has the tolerance.
    """
    write_triangles(tmp_path / "mesh.stl", *PLANTED[error].surface)
    audit = audit_mesh(*read_triangles(tmp_path / "mesh.stl"))
    assert audit.soup
    if error == "touching vertex":
        assert audit.found == {"bow_tie_vertices": 1}
    else:
        assert audit.found == ({} if PLANTED[error].indexed else PLANTED[error].found)


def test_every_kind_of_error_is_planted():
    """Each kind belongs to one concern."""
    kinds = [kind for kinds in CONCERNS.values() for kind in kinds]
    assert len(kinds) == len(set(kinds))
    assert {kind for p in PLANTED.values() for kind in p.found} == {*kinds}


@pytest.mark.slow
def test_findings_have_the_indices_of_the_planted_errors():
    n, m = len(sphere(1)[0]), len(sphere(1)[1])

    def audit(error):
        return audit_mesh(*PLANTED[error].surface)

    (copy, original) = audit("duplicate vertex").duplicate_vertices[0]
    points = PLANTED["duplicate vertex"].surface[0]
    assert copy == n
    assert (points[copy] == points[original]).all()
    assert audit("unreferenced vertex").unreferenced_vertices.tolist() == [n]
    ((copy, original),) = audit("duplicate triangle").duplicate_triangles
    triangles = PLANTED["duplicate triangle"].surface[1]
    assert copy == m
    assert (triangles[copy] == triangles[original]).all()
    assert audit("degenerate triangle").degenerate_triangles.tolist() == [m + 1]
    ((vertex, a, b),) = audit("T-junction").t_junctions
    assert (vertex, {a, b}) == (n, {*PLANTED["T-junction"].surface[1][-2:, [0, 1]].ravel()} - {n})
    crossings = audit("crossing").crossings
    assert len(set(crossings[:, 0])) == 1  # one triangle of the sphere
    assert crossings[:, 1].tolist() == [m, m + 1, m + 2]
    (loop,) = audit("hole").boundary_loops
    assert len(loop) == 3


def test_a_seam_is_a_pair_of_free_edges():
    """Such pairs are often called duplicate edges: two boundary edges at the same location."""
    points, triangles = PLANTED["duplicate vertex"].surface
    audit = audit_mesh(points, triangles)
    assert len(audit.free_edge_pairs) == 2
    for a, b, c, d in points[audit.free_edge_pairs]:
        assert (a == c).all()
        assert (b == d).all()


def test_the_seam_of_two_halves_has_duplicates_of_all_its_vertices():
    """No edge of a closed seam has an end that only one of the halves has.

    The upper and the lower half of a sphere have their own vertices.
    """
    points, triangles = (np.asarray(part) for part in sphere(2))
    upper = points[triangles].mean(axis=1)[:, 2] > 0
    seam = np.intersect1d(triangles[upper], triangles[~upper])
    halves = np.concatenate([triangles[upper], triangles[~upper] + len(points)])
    audit = audit_mesh(np.concatenate([points, points]), halves)
    expected = np.column_stack([seam + len(points), seam])
    np.testing.assert_array_equal(audit.duplicate_vertices, expected)
    assert len(audit.free_edge_pairs) == len(seam)
    assert len(audit.touching_vertices) == 0


def test_vertices_within_the_tolerance_are_duplicates():
    """A seam of width 6e-7 is found with a tolerance of 1e-6. With 5e-7 it is a hole."""
    points, triangles = PLANTED["duplicate vertex"].surface
    points = points.copy()
    points[-1] += [6e-7, 0, 0]
    assert audit_mesh(points, triangles, 5e-7).found == {"boundary_loops": 1}
    assert audit_mesh(points, triangles, 1e-6).found == PLANTED["duplicate vertex"].found


@pytest.mark.parametrize("flipped", [0, 3, 2])
def test_boundary_loops_are_ordered(flipped):
    """Consecutive vertices are connected by a boundary edge, for every orientation of triangles."""
    points, triangles = sphere(2)
    triangles = triangles[points[triangles].mean(axis=1)[:, 2] < 0.6]
    if flipped:
        triangles[::flipped] = triangles[::flipped, ::-1]
    audit = audit_mesh(points, triangles)
    (loop,) = audit.boundary_loops
    sides = {(int(a), int(b)) for t in triangles for a, b in itertools.permutations(t, 2)}
    assert len(loop) > 8
    assert all(side in sides for side in zip(loop, np.roll(loop, -1), strict=True))
    assert len(set(loop)) == len(loop)


def test_several_errors_are_counted_separately():
    """The mesh consists of one body per kind of error."""
    bodies = [translated(p.surface, 4 * k, 0, 0) for k, p in enumerate(PLANTED.values())]
    audit = audit_mesh(*together(*bodies))
    total = {}
    for planted in PLANTED.values():
        for kind, count in planted.found.items():
            total[kind] = total.get(kind, 0) + count
    assert audit.found == total


# --- invariance -----------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("error", PLANTED)
@pytest.mark.parametrize(
    "change",
    [
        lambda p: np.add(p, [1e7, -1e7, 1e7]),
        lambda p: np.add(p @ ROTATION.T * 1e150, [3e150, 0, 0]),
        lambda p: p @ ROTATION.T,
        lambda p: p * 0.8e308,
        lambda p: p * 2.0**-400,
        lambda p: (p @ ROTATION.T).astype(np.float32),
    ],
    ids=["shifted", "turned and huge", "turned", "largest", "tiny", "single precision"],
)
def test_findings_do_not_depend_on_origin_axes_unit_and_precision(error, change):
    points, triangles = PLANTED[error].surface
    assert audit_mesh(change(points), triangles).found == PLANTED[error].found


@pytest.mark.slow
@pytest.mark.parametrize("error", PLANTED)
def test_findings_do_not_depend_on_the_order(error):
    """Vertices and triangles are permuted, and the corners of each triangle rotated."""
    points, triangles = PLANTED[error].surface
    rng = np.random.default_rng(3)
    permutation, order = rng.permutation(len(points)), rng.permutation(len(triangles))
    shuffled = np.argsort(permutation)[triangles[order]]
    shuffled = np.stack([np.roll(t, rng.integers(3)) for t in shuffled])
    assert audit_mesh(points[permutation], shuffled).found == PLANTED[error].found


@pytest.mark.slow
@pytest.mark.parametrize("error", PLANTED)
def test_findings_do_not_depend_on_reflection(error):
    """The mesh is reflected and each triangle reversed, so outward orientations are kept."""
    points, triangles = PLANTED[error].surface
    assert audit_mesh(points * [1, 1, -1], triangles[:, ::-1]).found == PLANTED[error].found


# --- comparison with exact definitions ------------------------------------------------------------

SOUPS = st.tuples(
    st.lists(st.tuples(*[st.integers(0, 3)] * 3), min_size=3, max_size=8),
    st.lists(st.tuples(*[st.integers(0, 63)] * 3), min_size=1, max_size=8),
).map(lambda drawn: (np.array(drawn[0], dtype=float), np.array(drawn[1]) % len(drawn[0])))


def findings_equal_rational_arithmetic(surface, tolerance):
    """Random triangles on a coarse grid, where many points, edges and planes coincide."""
    points, triangles = surface
    audit = audit_mesh(points, triangles, tolerance)
    crossings, overlaps, junctions, flat = literal.findings(points, triangles)
    if audit.soup:
        points = points[[points.tolist().index(p) for p in points.tolist()]]
    assert {*map(tuple, audit.crossings.tolist())} == crossings
    assert {*map(tuple, audit.overlaps.tolist())} == overlaps
    assert {*map(tuple, audit.t_junctions.tolist())} == junctions
    assert {*audit.degenerate_triangles.tolist()} == flat


of_soups = given(SOUPS, st.sampled_from([0.0, None]))
test_intersections_equal_rational_arithmetic = settings(max_examples=30)(
    of_soups(findings_equal_rational_arithmetic)
)
test_more_intersections_equal_rational_arithmetic = pytest.mark.slow(
    settings(max_examples=400)(of_soups(findings_equal_rational_arithmetic))
)


@pytest.mark.slow
@settings(max_examples=100)
@given(SOUPS)
def test_intersections_of_nearly_coincident_triangles_equal_rational_arithmetic(surface):
    """The grid is sheared by irrational numbers, so that its points coincide only approximately."""
    points, triangles = surface
    points = points @ [[1, 0.1, 1 / 3], [0.7, 1, np.pi], [1e-9, 0.3, 1]] + 0.1
    audit = audit_mesh(points, triangles, 0.0)
    crossings, overlaps, junctions, flat = literal.findings(points, triangles)
    assert {*map(tuple, audit.crossings.tolist())} == crossings
    assert {*map(tuple, audit.overlaps.tolist())} == overlaps
    assert {*map(tuple, audit.t_junctions.tolist())} == junctions
    assert {*audit.degenerate_triangles.tolist()} == flat


@pytest.mark.slow
@settings(max_examples=100)
@given(st.lists(st.tuples(*[st.integers(0, 6)] * 3), min_size=1, max_size=12))
def test_connectivity_equals_counting(triangles):
    """This covers boundary and non-manifold edges, bow-ties and a consistent orientation."""
    triangles = np.array(triangles)
    points = np.random.default_rng(0).normal(size=(7, 3))
    audit = audit_mesh(points, triangles)
    counts = literal.edge_counts(triangles)
    crowded = {edge for edge, k in counts.items() if k > 2}
    assert {*map(tuple, audit.nonmanifold_edges.tolist())} == crowded
    assert sum(map(len, audit.boundary_loops)) == sum(k == 1 for k in counts.values())
    split = [v for v in range(7) if literal.fans(triangles, v) > 1]
    assert audit.bow_tie_vertices.tolist() == split
    if audit.soup or len(audit.duplicate_triangles):
        return
    oriented = triangles.copy()
    oriented[audit.flipped_triangles] = oriented[audit.flipped_triangles, ::-1]
    sides = [side for k, t in enumerate(oriented) if len({*t}) == 3 for side in sides_of(k, t)]
    for (i, a, b), (j, c, d) in itertools.combinations(sides, 2):
        if {a, b} == {c, d} and counts[min(a, b), max(a, b)] == 2:
            one_sided = i in audit.one_sided_triangles
            assert one_sided == (j in audit.one_sided_triangles)
            assert one_sided or (a, b) == (d, c)


def sides_of(k, t):
    return [(k, int(a), int(b)) for a, b in zip(t, np.roll(t, -1), strict=True)]


def test_a_one_sided_patch_cannot_be_oriented():
    """None of the 2ⁿ orientations of the triangles of a Möbius band is consistent."""
    points, triangles = band(5, half_turns=1)
    assert len(audit_mesh(points, triangles).one_sided_triangles) == len(triangles)
    for ways in itertools.product([False, True], repeat=len(triangles)):
        oriented = np.where(np.array(ways)[:, None], triangles[:, ::-1], triangles)
        sides = [side[1:] for k, t in enumerate(oriented) for side in sides_of(k, t)]
        assert len(set(sides)) < len(sides)


@pytest.mark.parametrize("error", ["crossing", "overlap"])
def test_counts_of_planted_errors_equal_rational_arithmetic(error):
    points, triangles = PLANTED[error].surface
    audit = audit_mesh(points, triangles, 0.0)
    if error in (
        "T-junction",
        "degenerate triangle",
    ):  # exactly, the middle of an edge is not on it
        return
    near = np.unique(np.concatenate([audit.crossings.ravel(), audit.overlaps.ravel()]))
    crossings, overlaps, _, _ = literal.findings(points, triangles[near])
    assert {tuple(near[[i, j]]) for i, j in crossings} == {*map(tuple, audit.crossings.tolist())}
    assert {tuple(near[[i, j]]) for i, j in overlaps} == {*map(tuple, audit.overlaps.tolist())}


# --- filters, predicates and their mutants --------------------------------------------------------


def slow_contacts(points, triangles):
    pairs = np.array([*itertools.combinations(range(len(triangles)), 2)]).reshape(-1, 2)
    return contacts(points, triangles, pairs)


@pytest.mark.slow
def test_separating_planes_keep_every_intersecting_pair():
    """All pairs and the pairs without a separating plane have the same findings."""
    rng = np.random.default_rng(5)
    for _ in range(20):
        points = rng.integers(0, 4, (9, 3)).astype(float)
        points = np.unique(points, axis=0)
        triangles = rng.permuted(np.tile(np.arange(len(points)), (12, 1)), axis=1)[:, :3]
        triangles = np.unique(np.sort(triangles, axis=1), axis=0)
        flat = [literal.is_flat(t) for t in points[triangles].tolist()]
        triangles = triangles[~np.array(flat)]
        every, some = slow_contacts(points, triangles), close_pairs(points, triangles)
        fast = contacts(points, triangles, some)
        assert fast.crossing.sum() == every.crossing.sum()
        assert fast.overlapping.sum() == every.overlapping.sum()
        np.testing.assert_array_equal(fast.corners_on_edges, every.corners_on_edges)


def a_plane_of_the_first_separates(points, one, other):
    """Through its corners, through an edge along an axis, or across it at a shared corner."""
    a, b, c = points[list(one)]
    normal = np.cross(b - a, c - a)
    free = [k for k in other if k not in one]
    heights = (points[free] - a) @ normal
    if (heights > 0).all() or (heights < 0).all():
        return True
    axis = int(np.abs(normal).argmax())
    flat = np.delete(points, axis, axis=1) * ([1, -1] if axis == 1 else [1, 1])
    for e, f in itertools.pairwise([*one, one[0]]):
        along = flat[f] - flat[e]
        away = [flat[k] - flat[e] for k in other if k not in (e, f)]
        if all(np.sign(normal[axis]) * (along[0] * y - along[1] * x) < 0 for x, y in away):
            return True
    if len(free) != 2:
        return False
    (tip,) = {*one} & {*other}
    ours, theirs = (
        np.array([points[k] - points[tip] for k in t if k != tip]) for t in (one, other)
    )
    across = (ours / np.linalg.norm(ours, axis=1)[:, None]).sum(axis=0)
    return bool((ours @ across > 1e-9).all() and (theirs @ across < -1e-9).all())


@pytest.mark.parametrize("seed", range(4))
def test_pairs_are_close_if_no_plane_separates_them(seed):
    """Triangles of lattice points, with and without common corners; literally."""
    rng = np.random.default_rng(seed)
    points = np.unique(rng.integers(-3, 4, (14, 3)), axis=0).astype(float)
    triangles = rng.permuted(np.tile(np.arange(len(points)), (30, 1)), axis=1)[:, :3]
    triangles = triangles[np.unique(np.sort(triangles, axis=1), axis=0, return_index=True)[1]]
    triangles = triangles[[not literal.is_flat(t) for t in points[triangles].tolist()]]
    low, high = points[triangles].min(axis=1), points[triangles].max(axis=1)
    expected = [
        [i, j]
        for i, j in itertools.combinations(range(len(triangles)), 2)
        if (low[i] <= high[j]).all()
        and (low[j] <= high[i]).all()
        and not a_plane_of_the_first_separates(points, triangles[i].tolist(), triangles[j].tolist())
        and not a_plane_of_the_first_separates(points, triangles[j].tolist(), triangles[i].tolist())
    ]
    assert close_pairs(points, triangles).tolist() == expected


def test_separating_planes_remove_most_pairs_of_flat_faces():
    """Edges of flat faces continue through vertices; planes must still separate the triangles.

    The remaining pairs lie along the edges of the cube, so their number does not grow with the
    area.
    """
    few, many = (len(close_pairs(*cube(cells))) for cells in (6, 12))
    assert 0 < many < 2.5 * few


def test_a_plane_separates_opposite_triangles_whose_edges_continue_through_their_corner():
    """It bisects the angle, however wide this is and however different the edges are."""
    a, b = np.array([1.0, 0, 0]), np.array([-12.0, 5, 0])
    points = np.array([0 * a, a, b, -2 * a, -3 * b])
    for one, other in itertools.product(
        *(itertools.permutations(t) for t in ([0, 1, 2], [0, 3, 4]))
    ):
        assert close_pairs(points, np.array([one, other])).tolist() == []


@pytest.mark.parametrize("share", [0.05, 0.5, 0.95])
def test_triangles_are_close_if_a_displacement_by_the_tolerance_makes_them_touch(share):
    """In a plane, one below an edge and one above it, each moved away; those far off are not."""
    below = np.array([[0.0, 0, 0], [1, 0, 0], [0.5, -1, 0]])
    above = np.array([[share, 0, 0], [share + 0.3, 1, 0], [share - 0.3, 1, 0]])
    for times, expected in ((1, [[0, 1]]), (20, [])):
        away = [0, 0.01 * times, 0]
        points = np.concatenate([below - away, above + away])
        for axes in itertools.permutations(range(3)):
            for one in itertools.permutations(range(3)):
                triangles = np.array([one, [3, 4, 5]])
                assert close_pairs(points[:, axes], triangles, 0.01).tolist() == expected


@pytest.mark.parametrize("up", [1.0, -1.0])
def test_triangles_that_touch_at_two_vertices_in_one_place_are_close(up):
    """No plane separates them strictly: only a shared vertex may lie on it."""
    flat = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
    points = np.concatenate([flat, [[0, 0, 0], [0.2, 0.3, up], [0.3, 0.2, up]]])
    for one, other in itertools.product(
        *(itertools.permutations(t) for t in ([0, 1, 2], [3, 4, 5]))
    ):
        assert close_pairs(points, np.array([one, other])).tolist() == [[0, 1]]
        shared = np.where(np.array(other) == 3, 0, other)
        assert close_pairs(points, np.array([one, shared])).tolist() == []


@pytest.mark.parametrize("unit", [1e-3, 1.0, 1e3])
def test_simplices_are_flat_within_a_tolerance_of_the_radius_of_their_inscribed_ball(unit):
    """Three volumes over the area of a tetrahedron, two areas over the perimeter of a triangle."""
    rng = np.random.default_rng(2)
    for d in (2, 3):
        corners = unit * rng.normal(size=(d + 1, 1, d))
        volume = np.linalg.det(corners[1:, 0] - corners[0, 0])
        faces = [np.delete(corners[:, 0], k, axis=0) for k in range(d + 1)]
        grams = [(f[1:] - f[0]) @ (f[1:] - f[0]).T for f in faces]
        radius = abs(volume) / sum(np.sqrt(np.linalg.det(g)) for g in grams)
        orient = _predicates.orient2d if d == 2 else _predicates.orient3d
        assert orient(*corners, tolerance=radius * (1 - 1e-9)) == np.sign(volume)
        assert orient(*corners, tolerance=radius * (1 + 1e-9)) == 0
        if d == 2:
            in_space = np.concatenate([corners, np.ones((3, 1, 1))], axis=2) @ ROTATION.T
            assert not _predicates.collinear(*in_space, tolerance=radius * (1 - 1e-9)).any()
            assert _predicates.collinear(*in_space, tolerance=radius * (1 + 1e-9)).all()


def test_orientation_signs_are_exact():
    """On the example of Kettner and others, with steps of 2⁻⁵³, signs equal rational arithmetic."""
    k = np.arange(64) * 2.0**-53
    x, y = np.meshgrid(0.5 + k, 0.5 + k)
    c = np.column_stack([x.ravel(), y.ravel()])
    a, b = (np.broadcast_to(p, c.shape) for p in ([12.0, 12.0], [24.0, 24.0]))
    u, v = b - a, c - a
    naive = np.sign(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0])
    expected = np.sign(c[:, 1] - c[:, 0])  # exact: these numbers are multiples of 2⁻⁵³ near ½
    assert (naive != expected).any()
    np.testing.assert_array_equal(_predicates.orient2d(a, b, c), expected)


def test_signs_are_exact_where_all_roundings_go_one_way():
    """The error is larger than a rounding of the sum of the terms; its bound is two of them."""
    rng, half = np.random.default_rng(0), 2.0**-53
    x, y, z = 1 + rng.integers(2**49, 2**50, (3, 4000)) * 2.0**-52
    w = (x * y - 6 * half) / z
    a = np.full((4000, 2), half * (1 - 1e-6))
    b, c = np.column_stack([x, -z]), np.column_stack([-w, y])
    naive = np.sign((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])
    expected = _predicates._exact_signs((a, b, c))
    assert (naive != expected).any()
    np.testing.assert_array_equal(_predicates.orient2d(a, b, c), expected)


def test_signs_in_space_equal_rational_arithmetic():
    """Of sheared lattice points, many of them nearly in a plane; and of the smallest volume."""
    shear = np.array([[1, 0.1, 1 / 3], [0.7, 1, np.pi], [1e-9, 0.3, 1]])
    corners = np.random.default_rng(0).integers(0, 3, (4, 300, 3)) @ shear + 0.1
    corners[:, 0] = 1 + 2.0**-52 * np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    expected = []
    for a, *others in corners.swapaxes(0, 1).tolist():
        u, v, w = ([Fraction(x) - Fraction(y) for x, y in zip(p, a, strict=True)] for p in others)
        terms = (w[i] * (u[i - 2] * v[i - 1] - u[i - 1] * v[i - 2]) for i in range(3))
        expected.append(int(np.sign(sum(terms))))
    assert expected[0] == 1
    assert {*expected} == {-1, 0, 1}
    for d, sign in ((corners[3], 1), (corners[0], 0)):
        found = _predicates.orient3d(*corners[:3], d)
        assert found.tolist() == [sign * s for s in expected]
    assert _predicates.orient3d(*corners[[1, 0, 2, 3]]).tolist() == [-s for s in expected]
    assert _predicates._exact_signs((*corners,)).tolist() == expected


@pytest.mark.parametrize("flat", [0, 1, 2])
def test_points_are_collinear_if_all_three_projections_are(flat):
    """In a plane of coordinates only one projection is not a line, and that by the last bit.

    A tolerance of this bit makes it one.
    """
    ends = np.array([[0.0, 0.0], [24.0, 24.0], [0.5, 0.5 + 2.0**-53]])
    on_line = np.minimum(ends, ends[:, :1])
    for order in map(list, itertools.permutations(range(3))):
        bent, straight = (np.insert(p[order], flat, 0.0, axis=1)[:, None] for p in (ends, on_line))
        assert not _predicates.collinear(*bent).any()
        assert _predicates.collinear(*bent, tolerance=2.0**-53).all()
        assert _predicates.collinear(*straight).all()


@pytest.mark.slow
def test_rounded_signs_give_wrong_findings(monkeypatch):
    """A mutant without exact signs disagrees with rational arithmetic."""
    rng = np.random.default_rng(1)
    shear = np.array([[1, 0.1, 1 / 3], [0.7, 1, np.pi], [1e-9, 0.3, 1]])
    surfaces = []
    for _ in range(40):
        points = rng.integers(0, 3, (7, 3)) @ shear + 0.1
        surfaces.append((points, rng.integers(0, 7, (6, 3))))

    exact = [literal.findings(p, t) for p, t in surfaces]

    def wrong():
        audits = (audit_mesh(p, t, 0.0) for p, t in surfaces)
        return sum(
            {*audit.degenerate_triangles.tolist()} != flat
            or {*map(tuple, audit.crossings.tolist())} != crossings
            for audit, (crossings, _, _, flat) in zip(audits, exact, strict=True)
        )

    assert wrong() == 0
    monkeypatch.setattr(
        _predicates, "_exact_signs", lambda points: np.zeros(len(points[0]), dtype=np.int8)
    )
    assert wrong() > 0


def ones(a, *_, tolerance):  # noqa: ARG001
    return np.ones(len(a), dtype=np.int8)


def never(a, *_, tolerance):  # noqa: ARG001
    return np.zeros(len(a), dtype=bool)


def touching(points, triangles):
    """Number of pairs without a separating plane, of crossings, and of corners on edges."""
    pairs = np.array([*itertools.combinations(range(len(triangles)), 2)])
    found = contacts(points, triangles, pairs, 1e-14)
    left = close_pairs(points, triangles, 1e-14)
    return len(left), int(found.crossing.sum()), len(found.corners_on_edges)


@pytest.mark.parametrize(
    ("module", "name", "mutant", "error"),
    [
        (_contacts, "orient3d", ones, "crossing"),
        (_contacts, "collinear", never, "T-junction"),
        (_triangle_pairs, "BOUND_3D", 1e20, "hole"),
        (_triangle_pairs, "BOUND_3D", -1e20, "crossing"),
    ],
)
def test_wrong_predicates_and_bounds_are_detected(module, name, mutant, error, monkeypatch):
    """Findings change with wrong signs, and the remaining pairs with wrong bounds."""
    points, triangles = PLANTED[error].surface
    right = touching(points @ ROTATION.T, triangles)
    monkeypatch.setattr(module, name, mutant)
    assert touching(points @ ROTATION.T, triangles) != right


# --- tolerances and duplicates --------------------------------------------------------------------


@pytest.mark.parametrize("dtype", [np.float64, np.float32, np.int64])
@pytest.mark.parametrize("largest", [5.0, -7.0])
def test_the_default_tolerance_is_four_roundings_of_the_largest_coordinate(dtype, largest):
    """In the precision of the points; integers are exact in double precision."""
    points = np.array([[0, 0, 1], [1, 0, 2], [0, largest, 0]]).astype(dtype)
    eps = np.finfo(np.float32 if dtype == np.float32 else float).eps
    assert audit_mesh(points, [[0, 1, 2]]).tolerance == 4 * eps * abs(largest)
    if np.dtype(dtype).kind == "f":
        assert audit_mesh(points / 16, [[0, 1, 2]]).tolerance == eps * abs(largest) / 4


@pytest.mark.parametrize("largest", [1.0, 1.5, 2.0, 0.7, 1e300, 1e-300])
def test_the_unit_is_the_power_of_two_below_the_largest_coordinate(largest):
    """So that its multiple is from 1 to 2; of points at the origin it is positive."""
    unit = unit_of(np.array([[-largest, 0.1 * largest, 0.0]]))
    assert 1 <= largest / unit < 2
    assert np.frexp(unit)[0] == 0.5
    assert unit_of(np.zeros((3, 3))) > 0
    assert unit_of(np.zeros((0, 3))) > 0


def test_coordinates_count_as_zero_if_the_largest_is_1e61_times_larger():
    """Beside it their digits would need numbers of hundreds of bits."""
    points, triangles = cube(1)
    seam = triangles.copy()
    seam[0, 0] = len(points)  # a vertex of its own, at the corner of this triangle
    limit = 2.0**-200
    for tiny, found in ((1.1 * limit, 0), (limit, 1), (0.9 * limit, 1), (1e-300, 1)):
        moved = np.vstack([points, points[triangles[0, 0]] + 0.0])
        moved[-1][moved[-1] == 0] = tiny
        assert (moved[-1] == tiny).any()
        assert len(audit_mesh(moved, seam, 0.0).duplicate_vertices) == found


@pytest.mark.parametrize("tolerance", [0.0, 0.02, 0.03, 0.05])
def test_points_within_the_tolerance_are_merged_in_chains(tolerance):
    """With the first of their chain. By heights pairs are the same as by a tree."""
    points = np.random.default_rng(4).integers(0, 60, (120, 3)) * [0.01, 0.01, 0.002]
    tolerance = tolerance * (1 + 1e-12)  # of lattice points several are that far apart
    linked = np.linalg.norm(points[:, None] - points, axis=2) <= tolerance
    expected = np.arange(120)
    for _ in range(120):
        expected = np.where(linked, expected, 120).min(axis=1)
    found = duplicates.merged_vertices(points, tolerance)
    np.testing.assert_array_equal(found, expected)
    assert (tolerance > 0) == (len({*found.tolist()}) < 120)
    pairs = {(i, j) for i, j in np.argwhere(linked).tolist() if i < j}
    for way in (duplicates._near_pairs, duplicates._near_pairs_by_tree):
        assert {*map(tuple, np.sort(way(points, tolerance), axis=1).tolist())} == pairs


@pytest.mark.parametrize("tolerance", [1e-3, 0.5, 1.0, 2.0, 1e3])
def test_any_tolerance_is_a_length_and_zero_distinguishes_all_points(tolerance):
    """Also points whose squared distance is zero in floating-point numbers."""
    points = tolerance * np.array([[0, 0, 0], [0.9, 0, 0], [3, 0, 0], [3, 1.1, 0]])
    assert duplicates.merged_vertices(points, tolerance).tolist() == [0, 0, 2, 3]
    near = points.copy()
    near[1] = [0, 0, 1e-170]
    assert duplicates.merged_vertices(near, 0.0).tolist() == [0, 1, 2, 3]
    assert duplicates.merged_vertices(near[[0, 1, 0, 1]], 0.0).tolist() == [0, 1, 0, 1]


def test_points_as_far_apart_as_the_tolerance_are_merged():
    """Exactly so far; and also by far less than the roundings of the other coordinates."""
    points = np.array([[0.0, 0, 0], [3, 4, 0], [8, 4, 0], [14, 4, 0]])
    for way in (duplicates._near_pairs, duplicates._near_pairs_by_tree):
        assert sorted(np.sort(way(points, 5.0), axis=1).tolist()) == [[0, 1], [1, 2]]
    for unit in (2.0**-10, 1.0, 2.0**10):
        some = np.random.default_rng(1).random((200, 3)) * [1e-16, 1, 1]
        close = unit * np.vstack([some, np.add(some, [2.0**-56, 0, 0])])
        found = duplicates.merged_vertices(close, unit * 2.0**-56 * (1 + 1e-9))
        np.testing.assert_array_equal(found, np.tile(np.arange(200), 2))


def test_equal_triangles_are_those_of_the_same_three_vertices():
    """All triples, each in every order, on few vertices and on millions."""
    triples = np.array([*itertools.permutations(range(7), 3)])
    triples = np.random.default_rng(0).permutation(triples)
    sets = [{*t} for t in triples.tolist()]
    expected = [sets.index(t) for t in sets]
    for n in (7, 2**22):
        np.testing.assert_array_equal(duplicates.first_duplicates(triples, n), expected)


def test_coincident_edges_are_paired_in_order():
    """With their coincident ends in the same order; ends of edges without length keep theirs."""
    rng = np.random.default_rng(0)
    for merged in (np.array([0, 1, 1, 3, 0, 3, 1, 0, 8]), np.zeros(9, dtype=int)):
        edges = rng.permutation([*itertools.permutations(range(9), 2)])[:40]
        ordered = [e if merged[e[0]] <= merged[e[1]] else e[::-1] for e in edges.tolist()]
        rows = sorted((*merged[e], *e) for e in ordered)
        expected = [[*e[2:], *f[2:]] for e, f in itertools.pairwise(rows) if e[:2] == f[:2]]
        assert duplicates._edge_pairs(edges, merged).tolist() == expected


# --- output and refusals --------------------------------------------------------------------------


def test_an_audit_can_be_written_as_json():
    """Findings are lists of indices, and counts are grouped by concern."""
    written = json.loads(json.dumps(audit_mesh(*PLANTED["T-junction"].surface).as_dict()))
    assert written["counts"]["embedding"]["t_junctions"] == 1
    assert len(written["indices"]["t_junctions"][0]) == 3
    assert not written["clean"]
    assert {*written["indices"]} == {"boundary_loops", "t_junctions"}


@pytest.mark.slow
def test_findings_do_not_depend_on_the_chunk_size(monkeypatch):
    surface = together(sphere(2), translated(sphere(2), 0.3, 0.2, 0.1))
    whole = audit_mesh(*surface)
    monkeypatch.setattr(_contacts, "_CHUNK", 7)
    monkeypatch.setattr("fieldrecon.triangles.bounding_volumes._MAX_PAIRS", 50)
    assert audit_mesh(*surface).as_dict() == whole.as_dict()
    assert len(whole.crossings) > 50


def test_the_hierarchy_finds_the_boxes_that_overlap_and_no_others():
    """Boxes of a lattice, that overlap, share a side, or are a step apart along one axis."""
    rng = np.random.default_rng(3)
    low = rng.integers(0, 9, (60, 3)).astype(float)
    high = low + rng.integers(0, 3, (60, 3))
    tree = bounding_volumes.BVH(low, high, np.zeros(3))
    found = tree.order[bounding_volumes.intersecting_pairs(tree, lambda *ij: np.column_stack(ij))]
    meet = ((low[:, None] <= high) & (low <= high[:, None])).all(axis=2)
    expected = {(i, j) for i, j in np.argwhere(meet).tolist() if i < j}
    assert sorted(map(tuple, np.sort(found, axis=1).tolist())) == sorted(expected)


@pytest.mark.parametrize(("one", "other"), [(60, 25), (25, 60), (1, 33), (33, 1)])
def test_two_hierarchies_of_any_depth_give_the_boxes_that_overlap(one, other):
    """Those of the second tree are a lattice, too, near the first or far from it."""
    rng = np.random.default_rng(4)
    for far in (0.0, 4.0, 50.0):
        low = [rng.integers(0, 9, (k, 3)) + shift for k, shift in ((one, 0.0), (other, far))]
        high = [corner + rng.integers(0, 4, corner.shape) for corner in low]
        trees = [bounding_volumes.BVH(*box, np.zeros(3)) for box in zip(low, high, strict=True)]
        i, j = bounding_volumes.intersecting_pairs(
            trees[0], lambda *ij: np.column_stack(ij), trees[1]
        ).T
        found = zip(trees[0].order[i].tolist(), trees[1].order[j].tolist(), strict=True)
        meet = (low[0][:, None] <= high[1]) & (low[1] <= high[0][:, None])
        assert sorted(found) == sorted(map(tuple, np.argwhere(meet.all(axis=2)).tolist()))


def test_progress_is_reported():
    """The number of processed pairs of boxes increases to the total, in several steps."""
    seen = []
    audit_mesh(*bumpy(3), progress=lambda done, total: seen.append((done, total)))
    assert [done for done, _ in seen] == sorted(done for done, _ in seen)
    assert seen[-1][0] == seen[-1][1]
    assert len(seen) > 3


@pytest.mark.parametrize(
    ("points", "triangles", "words"),
    [
        ([[0, 0], [1, 0], [0, 1]], [[0, 1, 2]], r"points must have the shape \(n, 3\)"),
        ([[0, 0, np.nan]] * 3, [[0, 1, 2]], "points must be finite"),
        ([[0, 0, 0]] * 3, [[0, 1, 3]], r"index 3 points; triangles\[0, 2\] is 3"),
        ([[0, 0, 0]] * 3, [[0, 1, 2], [0, -2, 1], [7, 1, 2]], r"triangles\[1, 1\] is -2"),
        ([[0, 0, 0]] * 3, [[0, 1]], r"triangles must have the shape \(m, 3\)"),
        ([[0, 0, 0]] * 3, [[0, 1, 2], [0, 1]], "the rows differ"),
        ([[0, 0, 0]] * 3, [[0.0, 1, 2]], "triangles must be integers"),
    ],
)
def test_invalid_meshes_are_refused(points, triangles, words):
    """The message names the argument, what came and what was wanted."""
    with pytest.raises(ValueError, match=words):
        audit_mesh(points, triangles)


def test_a_tolerance_that_merges_all_vertices_is_refused():
    """The error is raised before memory is exhausted."""
    with pytest.raises(ValueError, match="too large for these points"):
        audit_mesh(*sphere(4), tol=0.5)
    with pytest.raises(ValueError, match="tol must be zero or a positive number"):
        audit_mesh(*sphere(1), tol=-1)


def test_coincident_points_give_degenerate_triangles():
    """Triangles without area are reported as degenerate only."""
    audit = audit_mesh(np.zeros((6, 3)), [[0, 1, 2], [3, 4, 5]])
    assert audit.degenerate_triangles.tolist() == [0, 1]
    assert audit.crossings.shape == audit.overlaps.shape == (0, 2)
    assert audit.t_junctions.shape == (0, 3)


def test_parts_are_counted_of_a_mesh_of_nothing_too():
    """There need be no triangles, and no points."""
    nothing = np.empty((0, 3), dtype=int)
    for surface, parts in (
        (CLEAN["sphere"], 1),
        (CLEAN["two bodies"], 2),
        ((nothing * 0.5, nothing), 0),
    ):
        audit = audit_mesh(*surface)
        assert audit.clean
        assert audit.parts == parts


def test_triangles_of_a_soup_have_vertices_of_their_own_of_which_some_coincide():
    """One triangle alone is no soup, nor are two with a common edge and a third beside them."""
    points = np.array(
        [[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0], [0, 1, 0], [0, 2, 0], [-1, 1, 1]]
    )
    for triangles, is_soup in (
        ([[0, 1, 2]], False),
        ([[0, 1, 2], [1, 3, 2], [4, 5, 6]], False),
        ([[0, 1, 2], [4, 5, 6]], True),
    ):
        assert audit_mesh(points, triangles).soup == is_soup


def test_morton_codes_interleave_the_bits():
    """Bit by bit, for the largest integers, too."""
    steps = np.append(np.random.default_rng(1).integers(0, 2**21, 50), [0, 1, 2**21 - 1])
    literal_codes = [sum(int(b) << 3 * k for k, b in enumerate(f"{n:b}"[::-1])) for n in steps]
    assert bounding_volumes._interleaved(steps).tolist() == literal_codes
