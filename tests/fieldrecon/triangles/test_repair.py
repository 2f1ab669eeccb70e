"""Repair of triangle meshes: planted errors are corrected, correct meshes are unchanged."""

import itertools
from collections import Counter
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrecon._core.geometry import triangle_normals
from fieldrecon.io.meshes import read_triangles, write_triangles
from fieldrecon.triangles import half_edges as _half_edges
from fieldrecon.triangles import orientation as _orientation
from fieldrecon.triangles import repair as _mending
from fieldrecon.triangles.audit import audit_mesh
from fieldrecon.triangles.distances import distances_to_triangles
from fieldrecon.triangles.duplicates import first_duplicates
from fieldrecon.triangles.half_edges import HalfEdges
from fieldrecon.triangles.holes import (
    MAX_LOOP,
    _cycles,
    _has_known_diagonals,
    _keys,
    hole_patches,
    minimum_area_patches,
)
from fieldrecon.triangles.orientation import inconsistently_oriented, inverted
from fieldrecon.triangles.repair import erroneous, repair_mesh, without_flat
from fieldreport.experiments.triangles.planted_errors import damaged, planted_errors
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

PLANTED = planted_errors(2)
LEFT = {
    "edge of four triangles": {"nonmanifold_edges": 1},
    "bow-tie": {"touching_vertices": 1},
    "one side": PLANTED["one side"].found,
    "crossing": PLANTED["crossing"].found,
    "overlap": PLANTED["overlap"].found,
    "touching vertex": PLANTED["touching vertex"].found,
}
DONE = {
    "duplicate vertex": {"merged_vertices": 1},
    "unreferenced vertex": {"removed_vertices": 1},
    "duplicate triangle": {"removed_triangles": 1},
    "degenerate triangle": {"removed_triangles": 1, "split_edges": 1},
    "bow-tie": {"split_vertices": 1},
    "hole": {"filled_holes": 1, "filling_triangles": 1},
    "flipped triangle": {"reoriented_triangles": 1},
    "inside out": {"reoriented_triangles": 320},
    "T-junction": {"split_edges": 1},
}


def volume(points, triangles):
    return np.linalg.det(points[triangles]).sum() / 6


@pytest.mark.slow
@pytest.mark.parametrize("error", PLANTED)
def test_each_planted_error_is_repaired_or_reported(error):
    """Errors without a unique correction are left unchanged and are found again by the audit."""
    repaired = repair_mesh(*PLANTED[error].surface)
    assert repaired.before.found == PLANTED[error].found
    assert repaired.done == DONE.get(error, {})
    assert repaired.after.found == LEFT.get(error, {})
    assert audit_mesh(repaired.points, repaired.triangles).found == repaired.after.found


def test_fins_are_removed_and_walls_are_not():
    """A fin is small and has a free edge; a wall inside a body has none, or is large."""
    points, triangles = sphere(2)
    apex = len(points)
    fin = [[triangles[0][0], triangles[0][1], apex]]
    repaired = repair_mesh([*points, 1.5 * np.asarray(points)[triangles[0][0]]], [*triangles, *fin])
    assert repaired.done == {"removed_triangles": 1, "removed_fins": 1, "removed_vertices": 1}
    assert repaired.after.clean
    assert np.array_equal(repaired.triangles, triangles)
    large = repair_mesh([*points, [0, 0, 9.0]], [*triangles, *fin], largest_hole=0.001)
    assert large.after.found == {"nonmanifold_edges": 1, "boundary_loops": 1}
    bipyramid = [[1, 0, 0], [0, 1, 0], [-1, -1, 0], [0, 0, 1], [0, 0, -1]]
    outside = [[0, 1, 3], [1, 2, 3], [2, 0, 3], [1, 0, 4], [2, 1, 4], [0, 2, 4]]
    walled = repair_mesh(bipyramid, [*outside, [0, 1, 2]], largest_hole=1.0)
    assert walled.done == {}
    assert walled.after.found["nonmanifold_edges"] == 3
    book = repair_mesh([*bipyramid[:3], [0, 0, 1], [1, 1, 2]], [[0, 1, k] for k in (2, 3, 4)], 0, 1)
    assert "removed_fins" not in book.done


@pytest.mark.slow
@pytest.mark.parametrize("unit", [2.0**-500, 2.0**1023])
@pytest.mark.parametrize("error", DONE)
def test_repair_does_not_depend_on_the_unit(error, unit):
    """Results agree bit for bit for units that are powers of two."""
    points, triangles = PLANTED[error].surface
    here, there = repair_mesh(points, triangles), repair_mesh(points * unit, triangles)
    assert there.done == here.done
    np.testing.assert_array_equal(there.points, here.points * unit)
    np.testing.assert_array_equal(there.triangles, here.triangles)


@pytest.mark.slow
@pytest.mark.parametrize("error", DONE)
def test_repair_is_idempotent(error):
    once = repair_mesh(*PLANTED[error].surface)
    twice = repair_mesh(once.points, once.triangles)
    assert twice.done == {}
    np.testing.assert_array_equal(twice.points, once.points)
    np.testing.assert_array_equal(twice.triangles, once.triangles)


@pytest.mark.parametrize(
    "surface",
    [
        sphere(2),
        torus(17, 9),
        cube(3),
        together(sphere(1), turned_over((sphere(1)[0] / 2, sphere(1)[1]))),
        band(20, half_turns=0),
        band(20, half_turns=1),
        klein_bottle(20, 10),
        PLANTED["touching vertex"].surface,
        PLANTED["overlap"].surface,
    ],
    ids=["sphere", "torus", "cube", "hollow", "ring", "Möbius", "Klein", "touching", "fold"],
)
def test_correct_meshes_are_not_changed(surface):
    """Solids, cavities, wide holes, one-sided bands and intersections are kept bit for bit."""
    points, triangles = surface
    repaired = repair_mesh(points, triangles)
    assert repaired.done == {}
    np.testing.assert_array_equal(repaired.points, points)
    np.testing.assert_array_equal(repaired.triangles, triangles)


@pytest.mark.slow
@pytest.mark.parametrize("error", DONE)
def test_triangles_away_from_the_error_are_kept_in_order(error):
    """Triangles without a common vertex with the error are not changed."""
    points, triangles = PLANTED[error].surface
    repaired = repair_mesh(points, triangles)
    if error == "inside out":
        np.testing.assert_array_equal(repaired.triangles, triangles[:, [0, 2, 1]])
        return
    before = points[triangles].reshape(-1, 9)
    before = before[np.sort(np.unique(before, axis=0, return_index=True)[1])]  # without duplicates
    after = repaired.points[repaired.triangles].reshape(-1, 9)
    kept = np.array([(after == t).all(axis=1).any() for t in before])
    assert (~kept).sum() <= 2
    order = [int(np.argmax((after == t).all(axis=1))) for t in before[kept]]
    assert (np.diff(order) >= 0).all()


def test_a_solid_with_many_errors_is_repaired_through_files(tmp_path):
    """The result is closed and oriented, and has the original volume to 0.1 %."""
    write_triangles(tmp_path / "before.stl", *damaged(3, 3, seed=1))
    repaired = repair_mesh(*read_triangles(tmp_path / "before.stl"))
    assert repaired.before.soup
    assert {"duplicate_triangles", "t_junctions", "flipped_triangles"} < {*repaired.before.found}
    write_triangles(tmp_path / "after.stl", repaired.points, repaired.triangles)
    assert audit_mesh(*read_triangles(tmp_path / "after.stl")).clean
    assert volume(repaired.points, repaired.triangles) == pytest.approx(volume(*bumpy(3)), rel=1e-3)


@pytest.mark.slow
def test_solids_are_oriented_outward_and_cavities_inward():
    """The four nested shells have every combination of orientations."""
    shells = [(sphere(1)[0] * r, sphere(1)[1]) for r in (1, 0.75, 0.5, 0.25)]
    for ways in itertools.product([False, True], repeat=4):
        given = together(*(turned_over(s) if w else s for s, w in zip(shells, ways, strict=True)))
        repaired = repair_mesh(*given)
        signs = [
            np.sign(volume(repaired.points, t)) for t in np.split(repaired.triangles, len(shells))
        ]
        assert signs == [1, -1, 1, -1]


@pytest.mark.slow
def test_large_holes_are_filled_on_request_only():
    """A cube without its top stays open by default.

    A hole in a flat face is filled by a flat patch.
    """
    points, triangles = cube(2)
    cup = triangles[~(points[triangles][:, :, 2] == 1).all(axis=1)]
    left = repair_mesh(points, cup)
    assert left.after.found == {"boundary_loops": 1}
    filled = repair_mesh(points, cup, largest_hole=0.25)
    assert filled.after.clean
    assert volume(filled.points, filled.triangles) == pytest.approx(1)
    assert repair_mesh(*PLANTED["hole"].surface, largest_hole=0).after.found == {
        "boundary_loops": 1
    }


def touching_holes():
    """Spheres less triangles: two with a common corner, on the octahedron and elsewhere; five at
    random, two of them at one vertex; and all around a rhombus, which hangs at two vertices."""
    tops = np.array([[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2]])
    octahedron = (
        np.concatenate([np.eye(3), -np.eye(3)]),
        np.concatenate([tops, np.where(tops == 2, 5, tops)[:, ::-1]]),
    )
    yield octahedron, [0, 2]
    points, triangles = sphere(1)
    for seed in range(3):
        rng = np.random.default_rng(seed)
        around = np.flatnonzero((triangles == rng.integers(len(points))).any(axis=1))
        taken = [*rng.choice(around, 2, replace=False), *rng.choice(len(triangles), 3)]
        yield (points, triangles), taken
    near = np.isin(triangles, triangles[5, :2])
    yield (points, triangles), np.flatnonzero(near.any(axis=1) & (near.sum(axis=1) < 2))


@pytest.mark.slow
def test_holes_that_touch_are_filled_one_at_a_time():
    """The bodies are whole again, with about their volume."""
    for (points, triangles), taken in touching_holes():
        given = np.delete(triangles, taken, axis=0)
        repaired = repair_mesh(points, given, largest_hole=1.0)
        assert repaired.after.clean
        assert "split_vertices" not in repaired.done
        assert volume(*mesh_of(repaired)) == pytest.approx(volume(points, triangles), rel=0.06)


def mesh_of(repaired):
    return repaired.points, repaired.triangles


def test_fans_of_two_bodies_with_a_common_corner_are_filled_each_alone():
    """Two tetrahedra without a face at their common tip: two bodies that touch."""
    faces = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
    one = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])
    both = (
        np.concatenate([one, -one[1:]]),
        np.concatenate([faces[1:], np.where(faces, faces + 3, 0)[1:, ::-1]]),
    )
    repaired = repair_mesh(*both, largest_hole=1.0)
    assert repaired.done == {"split_vertices": 1, "filled_holes": 2, "filling_triangles": 2}
    assert repaired.after.found == {"touching_vertices": 1}


# --- the law: no repair adds an error -------------------------------------------------------------


def take_at_a_vertex(rng, points, triangles):
    around = np.flatnonzero((triangles == rng.integers(len(points))).any(axis=1))
    taken = rng.choice(around, min(len(around), rng.integers(1, 4)), replace=False)
    return points, np.delete(triangles, taken, axis=0)


def take(rng, points, triangles):
    return points, np.delete(triangles, rng.choice(len(triangles), 2), axis=0)


def flip(rng, points, triangles):
    turned = triangles.copy()
    turned[rng.integers(len(triangles))] = triangles[rng.integers(len(triangles)), ::-1]
    return points, turned


def double(rng, points, triangles):
    return points, np.concatenate([triangles, triangles[rng.choice(len(triangles), 1)]])


def cut_on_one_side(rng, points, triangles, capped=False):
    """Split a triangle at the midpoint of a side; if `capped`, close the seam without area."""
    k, new = rng.integers(len(triangles)), len(points)
    a, b, c = np.roll(triangles[k], rng.integers(3))
    halves = [[a, new, c], [new, b, c], [a, b, new]][: 3 if capped else 2]
    whole = np.concatenate([np.delete(triangles, k, axis=0), halves])
    return np.concatenate([points, points[[a, b]].mean(axis=0)[None]]), whole


def cut_and_cap(rng, points, triangles):
    return cut_on_one_side(rng, points, triangles, capped=True)


def copy_a_vertex(rng, points, triangles):
    vertex, cut = rng.integers(len(points)), triangles.copy()
    for t in np.flatnonzero((triangles == vertex).any(axis=1)):
        if rng.random() < 0.5:
            cut[t] = np.where(cut[t] == vertex, len(points), cut[t])
    return np.concatenate([points, points[[vertex]]]), cut


def join_two_vertices(rng, points, triangles):
    one, other = rng.choice(len(points), 2, replace=False)
    return points, np.where(triangles == one, other, triangles)


DAMAGES = [
    take_at_a_vertex,
    take,
    flip,
    double,
    cut_on_one_side,
    cut_and_cap,
    copy_a_vertex,
    join_two_vertices,
]
BODIES = [sphere(0), sphere(1), torus(7, 5), cube(2), cube(1)]


def damaged_mesh(seed, body, damages):
    """A body with several damages, one after another."""
    surface, rng = BODIES[body], np.random.default_rng(seed)
    for k in damages:
        surface = DAMAGES[k](rng, *surface)
    return surface


def no_repair_adds_a_kind_of_error(surface, largest_hole=1.0):
    """But where a bow-tie was split, its fans still touch."""
    repaired = repair_mesh(*surface, largest_hole=largest_hole)
    found = {*audit_mesh(*mesh_of(repaired)).found}
    if repaired.before.found.get("bow_tie_vertices"):
        found -= {"touching_vertices"}
    assert found <= {*repaired.before.found}


def draw_of(seed):
    rng = np.random.default_rng(seed)
    return seed, rng.integers(5), rng.choice(len(DAMAGES), rng.integers(1, 5))


def test_no_repair_adds_an_error():
    """A few draws of the law below."""
    for seed in range(4):
        no_repair_adds_a_kind_of_error(damaged_mesh(*draw_of(seed)))


@pytest.mark.slow
@settings(max_examples=75, deadline=None)
@given(
    st.integers(0, 2**32 - 1),
    st.integers(0, len(BODIES) - 1),
    st.lists(st.integers(0, len(DAMAGES) - 1), min_size=1, max_size=5),
    st.sampled_from([0.1, 0.3, 1.0]),
)
def test_no_repair_of_any_damage_adds_an_error(seed, body, damages, largest_hole):
    """Over bodies with one to five damages."""
    no_repair_adds_a_kind_of_error(damaged_mesh(seed, body, damages), largest_hole)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("mutants", "first"),
    [
        ({"added_kinds": lambda before, after: set()}, 220),  # noqa: ARG005
        (
            {
                "added_kinds": lambda before, after: set(),  # noqa: ARG005
                "erroneous": lambda after, t, first: np.empty(0, dtype=int),  # noqa: ARG005
            },
            0,
        ),
    ],
    ids=["stages are kept", "patches are kept"],
)
def test_a_repair_that_does_not_look_is_caught(mutants, first, monkeypatch):
    """By one of these draws; the first mutant is caught by one draw in some hundreds."""
    for name, mutant in mutants.items():
        monkeypatch.setattr(_mending, name, mutant)

    def some_draws():
        for seed in range(first, first + 100):
            no_repair_adds_a_kind_of_error(damaged_mesh(*draw_of(seed)))

    with pytest.raises(AssertionError):
        some_draws()


def test_a_patch_that_would_intersect_the_mesh_is_not_inserted():
    """A tetrahedron in the hole prevents the patch."""
    points, triangles = PLANTED["hole"].surface
    (loop,) = audit_mesh(points, triangles).boundary_loops
    middle = points[loop].mean(axis=0)
    spike = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]]) * 0.02 - 0.005
    faces = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
    both = together((points, triangles), (spike + middle, faces))
    repaired = repair_mesh(*both)
    assert repaired.done == {}
    assert repaired.after.found == {"boundary_loops": 1}


def test_all_vertices_inside_an_edge_are_merged():
    """One of two triangulated halves is subdivided at seven points of the common edge."""
    x = np.linspace(0, 1, 9)
    points = np.concatenate([np.column_stack([x, 0 * x, 0 * x]), [[0.5, 1, 0.0], [0.5, -1, 0.0]]])
    fan = [[k, k + 1, 9] for k in range(8)]
    repaired = repair_mesh(points, [*fan, [0, 10, 8]], largest_hole=0)
    assert repaired.done == {"split_edges": 7}
    assert repaired.after.found == {"boundary_loops": 1}


@pytest.mark.slow
def test_patches_have_minimal_area():
    """No triangulation of these loops of six points has a smaller area."""
    rng = np.random.default_rng(4)
    corners = rng.normal(size=(20, 6, 3))
    triangles, areas = minimum_area_patches(corners)

    def area(p, t):
        a, b, c = p[list(t)]
        return np.linalg.norm(np.cross(b - a, c - a)) / 2

    def least(p, i, j):
        between = range(i + 1, j)
        return min(
            (least(p, i, k) + least(p, k, j) + area(p, (i, k, j)) for k in between), default=0
        )

    for p, chosen, minimal_area in zip(corners, triangles, areas, strict=True):
        assert minimal_area == pytest.approx(least(p, 0, 5))
        assert sum(area(p, t) for t in chosen) == pytest.approx(minimal_area)
        assert len(audit_mesh(p, chosen).boundary_loops) == 1
        assert sorted(audit_mesh(p, chosen).boundary_loops[0]) == [*range(6)]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "mutant", "error"),
    [
        ("without_duplicates", lambda t, n: t, "duplicate triangle"),  # noqa: ARG005
        ("without_flat", lambda p, t, *_: t, "degenerate triangle"),  # noqa: ARG005
        ("split_free_edges", lambda p, t, tolerance: t, "T-junction"),  # noqa: ARG005
        ("split_bow_ties", lambda p, t: (p, t), "bow-tie"),
        ("oriented", lambda p, t: t, "flipped triangle"),  # noqa: ARG005
        ("hole_patches", lambda p, t, largest: (t[:0], t[:0, 0]), "hole"),  # noqa: ARG005
    ],
)
def test_omitting_a_step_of_the_repair_is_detected(name, mutant, error, monkeypatch):
    right = repair_mesh(*PLANTED[error].surface)
    monkeypatch.setattr(_mending, name, mutant)
    wrong = repair_mesh(*PLANTED[error].surface)
    assert (wrong.done, wrong.after.found) != (right.done, right.after.found)


def test_invalid_input_is_refused():
    """At least one triangle must have a positive area, and `largest_hole` must not be negative."""
    with pytest.raises(ValueError, match="none is left to repair"):
        repair_mesh(np.zeros((3, 3)), [[0, 1, 2]])
    with pytest.raises(ValueError, match="largest_hole must be zero or a positive number"):
        repair_mesh(*sphere(1), largest_hole=-1)


# --- parts of the repair --------------------------------------------------------------------------


def test_loose_triangles_of_a_closed_surface_are_merged():
    """The audit finds no error in them, but each triangle has its own three vertices."""
    points, triangles = cube(2)
    repaired = repair_mesh(
        points[triangles].reshape(-1, 3), np.arange(triangles.size).reshape(-1, 3)
    )
    assert repaired.before.clean
    assert repaired.before.soup
    assert len(repaired.points) == len(points)
    assert not repaired.after.soup


def test_errors_of_new_triangles_have_their_numbers_in_the_mesh():
    """The first triangles are old: their errors are not counted."""
    points, triangles = cube(2)
    twice = np.vstack([triangles[:1], triangles, triangles[5:6]])
    wrong = erroneous(audit_mesh(points, twice), twice, 3)
    assert len(twice) - 1 in wrong
    assert (wrong >= 3).all()


def test_each_stage_of_a_repair_adds_its_own_kinds():
    """Removal, splitting of edges, orientation, filling of holes, splitting of bow-ties."""
    kinds = ["duplicate vertex", "duplicate triangle", "T-junction", "flipped triangle"]
    surfaces = [planted_errors(1)[kind].surface for kind in (*kinds, "hole", "bow-tie")]
    bodies = [(np.add(p, [4 * k, 0, 0]), t) for k, (p, t) in enumerate(surfaces)]
    points, triangles = together(*bodies)
    before = audit_mesh(points, triangles)
    damaged_one = _mending._Damaged(points, triangles, before, before.tolerance, 0.1, None)
    expected = {"merged_vertices", "removed_triangles"}
    for stage, new in enumerate(
        [
            set(),
            {"split_edges"},
            {"reoriented_triangles"},
            {"filled_holes", "filling_triangles"},
            {"split_vertices"},
        ]
    ):
        expected |= new
        assert {*damaged_one.repaired(stage + 1, spare=False).done} == expected


def test_a_small_loose_triangle_is_no_fin():
    """A fin hangs at an edge of two other triangles; what is apart from it stays."""
    points, triangles = sphere(1)
    n, (a, b, _) = len(points), triangles[0]
    apart = np.array([[5.0, 0, 0], [5.1, 0, 0], [5.0, 0.1, 0]])
    whole = np.vstack([points, 1.3 * np.asarray(points)[a], apart])
    every = np.vstack([triangles, [[a, b, n], [n + 1, n + 2, n + 3]]])
    left, fins = _mending.without_fins(whole, every, 0.1)
    assert fins == 1
    np.testing.assert_array_equal(left, np.delete(every, -2, axis=0))


def test_distances_to_single_and_collapsed_triangles():
    """Of a triangle that collapsed, the distance from the segment or point that is left."""
    x = np.random.default_rng(1).normal(size=(60, 3))
    a, b, c = np.array([[0.1, 0, 0.2], [1.0, 0.3, -0.2], [0.2, 0.9, 0.4]])
    along = np.clip((x - a) @ (b - a) / ((b - a) @ (b - a)), 0, 1)
    segment = np.linalg.norm(x - a - along[:, None] * (b - a), axis=1)
    point = np.linalg.norm(x - a, axis=1)
    for corners, expected in (([a, a, b], segment), ([b, a, b], segment), ([a, a, a], point)):
        np.testing.assert_allclose(distances_to_triangles(x, corners, [[0, 1, 2]]), expected)
    shares = np.random.default_rng(2).dirichlet([1.0] * 3, 60)
    normal = np.cross(b - a, c - a)
    above = shares @ [a, b, c] + 0.7 * normal / np.linalg.norm(normal)
    np.testing.assert_allclose(distances_to_triangles(above, [a, b, c], [[0, 1, 2]]), 0.7)


def test_distances_to_triangles_are_lengths():
    """Multiplied by a factor if everything is, however small or large."""
    rng = np.random.default_rng(3)
    x, corners = rng.normal(size=(60, 3)), rng.normal(size=(3, 3))
    shares = np.array([s for s in itertools.product(range(41), repeat=3) if sum(s) == 40]) / 40
    on_it = shares @ corners
    near = np.linalg.norm(x[:, None] - on_it, axis=2).min(axis=1)
    for unit in (1e-3, 1.0, 1e3):
        found = distances_to_triangles(unit * x, unit * corners, [[0, 1, 2]]) / unit
        assert (found <= near + 1e-9).all()
        assert (found > near - 0.1).all()
        np.testing.assert_allclose(found, distances_to_triangles(x, corners, [[0, 1, 2]]))


def test_the_triangle_of_the_nearest_vertex_is_found():
    """Its other vertices are farther away than those of other triangles."""
    spike = [[0.0, 0, 0], [99, 1, 0], [99, -1, 0]]
    others = [[0, 5 + k, j] for k in range(3) for j in (0, 1, 2)]
    triangles = np.arange(12).reshape(4, 3)
    found = distances_to_triangles([[-1.0, 0, 0]], spike + others, triangles)
    assert found == pytest.approx(1)


def edges_of(triangle):
    return [tuple(sorted(map(int, pair))) for pair in itertools.combinations(triangle, 2)]


@pytest.mark.parametrize("seed", range(3))
def test_spared_are_the_flat_triangles_at_edges_of_three_or_more(seed):
    """Of points on two lines; counted edge by edge."""
    points = np.array([*itertools.product([0.0, 1], range(6), [0.0])])
    t = np.random.default_rng(seed).integers(0, 12, (24, 3))
    real = [k for k in t if len({*k}) == 3]
    count = Counter(edge for k in real for edge in edges_of(k))
    flat = np.array([len({*points[k, 0]}) == 1 for k in real])
    spared = np.array([any(count[edge] > 2 for edge in edges_of(k)) for k in real])
    assert 0 < (flat & spared).sum() < flat.sum()
    for spare in (False, True):
        kept = ~flat | (spare & spared)
        np.testing.assert_array_equal(without_flat(points, t, 0.0, spare), np.array(real)[kept])


@pytest.mark.parametrize("error", ["edge of four triangles", "T-junction", "duplicate vertex"])
def test_triangles_at_wrong_edges_and_vertices_are_erroneous(error):
    """Those with an edge of three or more, or with a vertex inside it, or with a copied vertex."""
    points, triangles = PLANTED[error].surface
    audit = audit_mesh(points, triangles)
    edges = [*audit.nonmanifold_edges, *audit.t_junctions[:, 1:]]
    bad = {tuple(sorted(map(int, e))) for e in edges}
    copies = {*audit.duplicate_vertices.ravel().tolist()}
    literal = [
        k for k, t in enumerate(triangles) if bad & {*edges_of(t)} or copies & {*map(int, t)}
    ]
    assert literal
    for first in (0, literal[0] + 1):
        found = erroneous(audit, np.asarray(triangles), first).tolist()
        assert found == [k for k in literal if k >= first]


def test_edges_on_millions_of_vertices_have_different_keys():
    """Of neighbouring numbers at both ends."""
    n = 2**31
    ends = np.array([*itertools.product([0, 1, n - 2, n - 1], repeat=2)])
    assert len({*_keys(ends, n).tolist()}) == len(ends)


def test_equal_triangles_are_found_on_millions_of_vertices():
    """A number for each triangle would not fit into 64 bits: these two would have the same."""
    far = [2**20, 2**20 + 5, 2**20 + 7]
    some = np.array([far, [0, *far[1:]], far[::-1]])
    assert first_duplicates(some, 2**22).tolist() == [0, 1, 0]


def test_a_long_path_around_a_hole_does_not_hide_a_short_one():
    """From joint 0 one path leads to 1; one of 40 sides leads on from there, and one leads back."""
    paths = [np.array([0]), np.arange(2, 2 + MAX_LOOP + 8), np.array([1])]
    ends = np.zeros(MAX_LOOP + 10, dtype=int)
    ends[0], ends[paths[1][-1]] = 1, 2
    starts = np.zeros_like(ends)
    starts[1] = starts[2] = 1
    assert list(_cycles(SimpleNamespace(start=starts, end=ends), paths)) == [(0, 2)]


def test_all_short_simple_cycles_of_paths_are_found_once():
    """Of paths of one to three sides between few joints; each cycle from its first path."""
    for seed in range(20):
        starts, ends = np.random.default_rng(seed).integers(0, 3, (2, 5))
        joined = [
            cycle
            for k in range(1, 4)
            for cycle in itertools.permutations(range(5), k)
            if cycle[0] == min(cycle)
            and len({*starts[[*cycle]]}) == k
            and (ends[[*cycle]] == np.roll(starts[[*cycle]], -1)).all()
        ]
        paths = [np.arange(3 * k, 3 * k + 1 + k % 3) for k in range(5)]
        sides = SimpleNamespace(start=np.full(15, 99), end=np.full(15, 99))
        sides.start[[path[0] for path in paths]] = starts
        sides.end[[path[-1] for path in paths]] = ends
        found = [*_cycles(sides, paths)]
        assert sorted(found) == sorted(joined)


@pytest.mark.parametrize("corners", [4, 5, 7])
def test_a_patch_has_a_known_diagonal_if_an_edge_of_two_of_its_triangles_exists(corners):
    """Each of the other edges may be known: of the boundary, or of none of its triangles."""
    points = np.random.default_rng(corners).normal(size=(2, corners, 3))
    order = minimum_area_patches(points)[0]
    numbers = np.random.default_rng(0).permutation(corners + 3)[:corners]
    for known in map(list, itertools.combinations(range(corners + 3), 2)):
        found = _has_known_diagonals(
            order, numbers[order], _keys(np.array([known]), corners + 3), corners + 3
        )
        count = [Counter(e for t in numbers[patch] for e in edges_of(t)) for patch in order]
        assert found.tolist() == [c[(*known,)] == 2 for c in count]


def cone(corners, height, left):
    """Triangles from a regular polygon of radius 1 to a tip, and their area over the polygon's."""
    angle = 2 * np.pi * np.arange(corners) / corners
    rim = np.column_stack([np.cos(angle) + left, np.sin(angle), 0 * angle])
    around = np.arange(corners)
    tip = np.full(corners, corners)
    apothem = np.cos(np.pi / corners)
    return (
        np.vstack([rim, [left, 0, height]]),
        np.column_stack([around, np.roll(around, -1), tip]),
        np.hypot(height, apothem) / apothem,
    )


def test_a_hole_is_filled_up_to_its_share_of_the_area_of_its_part():
    """The holes below cones of different heights; short ones first, then by their first sides."""
    cones = [cone(k, h, 4 * i) for i, (k, h) in enumerate([(3, 1), (5, 9), (4, 3), (5, 2), (6, 5)])]
    points, triangles = together(*(surface[:2] for surface in cones))
    triangles = triangles[np.random.default_rng(0).permutation(len(triangles))]
    rims = [
        {*range(n - len(p), n - 1)}
        for (p, _, _), n in zip(
            cones, np.cumsum([len(p) for p, _, _ in cones]).tolist(), strict=True
        )
    ]
    sides = [side for t in triangles.tolist() for side in zip(t, t[1:] + t[:1], strict=True)]
    for _, _, ratio in cones:
        for largest in ((1 + 1e-9) / ratio, (1 - 1e-9) / ratio):
            filling, hole = hole_patches(points, triangles, largest)
            expected = [rim for rim, c in zip(rims, cones, strict=True) if largest * c[2] >= 1]
            expected.sort(
                key=lambda rim: (len(rim), [{*side} <= rim for side in sides].index(True))
            )
            filled = [{*filling[hole == k].ravel().tolist()} for k in range(len(expected))]
            assert filled == expected
            whole = np.concatenate([triangles, filling])
            half_edges = HalfEdges(whole, len(points))
            assert len(half_edges.boundary_loops) == len(cones) - len(expected)
            assert not inconsistently_oriented(half_edges)[0].any()
            assert hole.max(initial=-1) == len(expected) - 1


def test_a_hole_of_exactly_the_share_of_the_area_is_filled():
    """In a plane: three triangles around a point inside a triangle."""
    points = np.array([[0.0, 0, 0], [4, 0, 0], [0, 4, 0], [1, 1, 0]])
    around = np.array([[0, 1, 3], [1, 2, 3], [2, 0, 3]])
    assert len(hole_patches(points, around, 1.0)[0]) == 1


def test_a_boundary_of_32_edges_is_filled_and_one_of_33_is_not():
    """As the documentation of the repair says."""
    for corners, new in ((32, 30), (33, 0)):
        points, triangles, _ = cone(corners, 5.0, 0.0)
        assert len(hole_patches(points, triangles, 1.0)[0]) == new


def test_parts_are_closed_if_two_triangles_meet_at_each_edge():
    """Random triangles, counted edge by edge in each part."""
    kinds = set()
    tetrahedron = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]
    for seed in range(30):
        rng = np.random.default_rng(seed)
        rows = np.array([*itertools.combinations(range(5), 3)])
        some = rows[rng.permutation(len(rows))[: rng.integers(1, 5)]] + 4
        walled = np.array(
            [[0, 1, 3], [1, 2, 3], [0, 2, 3], [0, 1, 4], [1, 2, 4], [0, 2, 4], [0, 1, 2]]
        )
        triangles = rng.permutation(np.concatenate([tetrahedron, some, 9 + walled]))
        half_edges = HalfEdges(triangles, 14)
        for part, closed in enumerate(half_edges.closed_parts):
            edges = [e for t in triangles[half_edges.parts == part] for e in edges_of(t)]
            counts = {*Counter(edges).values()}
            assert closed == (counts == {2})
            kinds.add((*sorted(counts),))
    assert {(1,), (2,), (2, 3), (1, 2), (1, 2, 3)} <= kinds


def test_a_closed_part_without_volume_is_not_inverted():
    """A fan of triangles, and the same fan below it: the sum of volumes is a rounding error."""
    rng, next_one = np.random.default_rng(1), np.roll(np.arange(12), -1)
    for _ in range(8):
        points = rng.random((13, 3))
        points = np.vstack([points, points[12]])
        above = np.column_stack([np.arange(12), next_one, np.full(12, 12)])
        below = np.column_stack([next_one, np.arange(12), np.full(12, 13)])
        for triangles in (
            np.vstack([above, below]),
            np.vstack([below, above[rng.permutation(12)]]),
        ):
            half_edges = HalfEdges(triangles, len(points))
            assert half_edges.closed_parts.all()
            assert not inverted(points, half_edges, np.zeros(24, dtype=bool)).any()
            box = cube(1)
            both = together((points, triangles), (4 * box[0] - 1, box[1]))
            half_edges = HalfEdges(both[1], len(both[0]))
            assert not inverted(both[0], half_edges, np.zeros(len(both[1]), dtype=bool)).any()


def test_a_free_edge_is_split_at_the_vertex_nearest_to_its_middle_first():
    """One side of a triangle, of whichever number; edges beside which there are no vertices stay.

    The triangles at the vertices on the sides have edges of larger numbers, which are not free.
    """
    corners = np.array([[0.0, 0, 0], [8, 0, 0], [0, 8, 0]])
    on_sides = np.array([[3.0, 0, 0], [4, 0, 0], [0, 5.0, 0]])
    beside = np.array([[3.0, -9, 0], [5, -9, 0], [-9, 5, 1], [-9, 4, 1]])
    points = np.vstack([corners, on_sides, beside])
    fans = [[3, 6, 4], [4, 6, 7], [5, 8, 9]]
    for order in ([0, 1, 2], [2, 0, 1], [0, 2, 1]):
        triangles = np.array([order, *fans])
        side, vertex = _mending._inside_free_edges(points, triangles, 0.0)
        assert side // 3 == [0]
        assert vertex == [4]
        whole = _mending.split_free_edges(points, triangles, 0.0)
        split = [t for t in whole.tolist() if {*t} <= {*range(6)}]
        assert sorted(np.unique(split)) == [0, 1, 2, 3, 4, 5]
        areas = np.linalg.norm(triangle_normals(*points[np.array(split).T]), axis=1) / 2
        assert areas.sum() == pytest.approx(32.0)


def test_an_edge_of_two_triangles_is_not_split_at_a_vertex_of_a_boundary():
    """A sheet that stands on it only touches it there, whatever the numbers of its vertices."""
    foot = np.array([[0.0, 0, 0], [1, 0, 2], [-1, 0, 2]])
    diamond = np.array([[0.0, -3, 0], [0, 3, 0], [-3, 0, 0], [3, 0, 0]])
    for points, first, second in (
        (np.vstack([foot, diamond]), [0, 1, 2], [[3, 6, 5], [4, 5, 6]]),
        (np.vstack([diamond, foot]), [4, 5, 6], [[0, 3, 2], [1, 2, 3]]),
    ):
        triangles = np.array([first, *second])
        assert np.array_equal(_mending.split_free_edges(points, triangles, 0.0), triangles)


def test_a_free_edge_is_not_split_at_a_vertex_without_a_boundary():
    """The hub of a wheel touches the middle of an edge of another triangle."""
    angle = np.arange(6) * np.pi / 3
    rim = np.column_stack([0 * angle, np.cos(angle), np.sin(angle)])
    triangle = np.array([[-1.0, 0, 0], [1, 0, 0], [-1, -2, 2]])
    points = np.vstack([rim, [[0, 0, 0]], triangle])
    wheel = np.column_stack([np.arange(6), (np.arange(6) + 1) % 6, np.full(6, 6)])
    triangles = np.vstack([wheel, [[7, 8, 9]]])
    assert (audit_mesh(points, triangles).t_junctions == [6, 7, 8]).any()
    np.testing.assert_array_equal(_mending.split_free_edges(points, triangles, 0.0), triangles)
    cut = np.vstack([wheel[1:], [[7, 8, 9]]])
    assert len(_mending.split_free_edges(points, cut, 0.0)) == len(cut) + 1


def star(rng, rays):
    """Triangles with a common corner, numbered at random; and for each ray from it a vertex on it.

    Each of these vertices has a triangle of its own, beside the star.
    """
    ends = np.arange(2 * rays)[:, None] * np.array([0.0, 8, 0]) + [64, 0, 0]
    on_rays = ends * rng.integers(1, 8, (2 * rays, 1)) / 8
    above, beside = np.add(on_rays, [0, 0, 1]), np.add(on_rays, [0, 1, 2])
    points = np.vstack([np.zeros((1, 3)), ends, on_rays, above, beside])
    n = 2 * rays
    faces = np.column_stack([np.zeros(rays, int), 1 + np.arange(0, n, 2), 2 + np.arange(0, n, 2)])
    fins = 1 + n + np.arange(n)[:, None] + [0, n, 2 * n]
    number = rng.permutation(len(points))
    renumbered = np.empty_like(points)
    renumbered[number] = points
    return renumbered, rng.permuted(number[np.vstack([faces, fins])], axis=1), number


@pytest.mark.parametrize("seed", range(2))
def test_of_each_triangle_the_free_edge_with_a_vertex_nearest_to_its_middle_is_split(seed):
    """One edge of each triangle at a time, and in the end all of them; literally."""
    rays = 5
    points, triangles, number = star(np.random.default_rng(seed), rays)
    middle, ends = number[0], number[1 : 1 + 2 * rays]
    on_ray = number[1 + 2 * rays : 1 + 4 * rays]
    off = np.abs(2 * points[on_ray] - points[ends] - points[middle]).max(axis=1)
    side, vertex = _mending._inside_free_edges(points, triangles, 0.0)
    assert (side // 3).tolist() == [*range(rays)]
    for t, k, v in zip(side // 3, side % 3, vertex, strict=True):
        nearest = 2 * t + off[2 * t : 2 * t + 2].argmin()
        assert v == on_ray[nearest] or off[2 * t] == off[2 * t + 1]
        assert {triangles[t, k], triangles[t, (k + 1) % 3]} == {
            middle,
            ends[on_ray.tolist().index(v)],
        }
    whole = _mending.split_free_edges(points, triangles, 0.0)
    assert len(whole) == len(triangles) + 2 * rays
    assert len(_mending._inside_free_edges(points, whole, 0.0)[0]) == 0


@pytest.mark.parametrize("seed", range(3))
def test_each_fan_but_the_first_gets_a_vertex_of_its_own(seed):
    """In the order of the vertices and of the first corners of their fans."""
    rng = np.random.default_rng(seed)
    points, triangles = rng.normal(size=(9, 3)), rng.integers(0, 9, (12, 3))
    triangles = triangles[[len({*t}) == 3 for t in triangles.tolist()]]
    triangles = triangles[np.unique(np.sort(triangles, axis=1), axis=0, return_index=True)[1]]
    fans = HalfEdges(triangles, 9).fans
    first = {fan: int(np.argmax(fans == fan)) for fan in fans.tolist()}
    by_vertex = sorted((int(triangles.ravel()[corner]), corner) for corner in first.values())
    new, n = {}, 9
    for k, (vertex, corner) in enumerate(by_vertex):
        again = k > 0 and by_vertex[k - 1][0] == vertex
        new[corner], n = (n, n + 1) if again else (vertex, n)
    expected = [new[first[fan]] for fan in fans.tolist()]
    assert n > 11
    more, split = _mending.split_bow_ties(points, triangles)
    assert split.ravel().tolist() == expected
    np.testing.assert_array_equal(more[split], points[triangles])
    assert len(HalfEdges(split, n).bow_ties) == 0


def test_vertices_are_not_merged_if_an_edge_of_three_triangles_would_form():
    """Where one was before, others are; and so are those at edges of two triangles."""
    three = [[0, 1, 2], [1, 0, 3], [4, 5, 6]]  # with 4 at 0 and 5 at 1
    seam = [[7, 9, 10], [8, 11, 9]]  # with 8 at 7
    before = [[13, 15, 14], [14, 13, 16], [13, 14, 17], [12, 17, 18]]  # with 14 at 12
    pairs = np.array([[4, 0], [5, 1], [8, 7], [14, 12]])
    audit = SimpleNamespace(
        soup=False, duplicate_vertices=pairs, nonmanifold_edges=np.array([[13, 14]])
    )
    merged = _mending.merge_targets(
        np.array([*three, *seam, *before]), audit, np.zeros((19, 3)), 0.0
    )
    expected = np.arange(19)
    expected[[8, 14]] = 7, 12
    np.testing.assert_array_equal(merged, expected)


def test_a_body_is_turned_outward_when_its_hole_is_filled():
    """Before, its triangles are the boundary of no body."""
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    inward = np.array([[0, 1, 2], [0, 3, 1], [1, 3, 2]])
    before = audit_mesh(corners, inward)
    for stages in (4, 5):
        given = _mending._Damaged(corners, inward, before, 0.0, 1.0, None)
        repaired = given.repaired(stages, spare=True)
        assert repaired.after.clean
        assert repaired.done == {
            "reoriented_triangles": 3,
            "filled_holes": 1,
            "filling_triangles": 1,
        }


def test_a_repair_tries_fewer_and_fewer_stages(monkeypatch):
    """First without and then with the flat triangles at edges of three; at last it does nothing."""
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [2, 2, 2]])
    faces = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2], [0, 1, 4], [0, 1, 1]])
    tried, repaired = [], _mending._Damaged.repaired

    def noted(self, stages, spare):
        result = repaired(self, stages, spare)
        tried.append((stages, spare, result.done.get("removed_fins", 0)))
        return result

    monkeypatch.setattr(_mending._Damaged, "repaired", noted)
    monkeypatch.setattr(_mending, "added_kinds", lambda *_: {"crossings"})
    left = repair_mesh(corners, faces, largest_hole=1.0)
    assert tried == [(5, False, 1), *((k, True, 0) for k in (5, 4, 3, 2, 1))]
    assert left.done == {}
    assert left.after is left.before
    np.testing.assert_array_equal(left.points, corners)
    np.testing.assert_array_equal(left.triangles, faces)


def test_one_triangle_is_left_or_none_was_there():
    """Neither is refused: only degenerate triangles are."""
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [5, 5, 5]])
    one = repair_mesh(corners, [[0, 1, 2], [1, 2, 2]])
    assert one.done == {"removed_triangles": 1, "removed_vertices": 1}
    assert one.triangles.tolist() == [[0, 1, 2]]
    none = repair_mesh(corners, np.empty((0, 3), dtype=int))
    assert none.done == {"removed_vertices": 4}
    assert none.after.clean


def test_a_fin_has_at_most_the_share_of_the_area():
    """Exactly that share is allowed: a triangle at an edge of two others, all of the same area."""
    corners = np.array([[0.0, 0, 0], [0, 0, 1], [1, 0, 0], [0, 1, 0], [-1, 0, 0]])
    pages = np.array([[0, 1, 2], [1, 0, 3], [0, 1, 4]])
    spine = np.array([[2, 3, 0], [3, 2, 1]])
    for largest, fins in ((0.2, 1), (0.19, 0)):
        whole = np.vstack([pages, spine])
        areas = np.linalg.norm(triangle_normals(*corners[whole.T]), axis=1)
        share = largest * 5 * areas[2] / areas.sum()
        left, found = _mending.without_fins(corners, whole, share)
        assert found == fins
        assert len(left) == 5 - fins


# --- half-edges and orientation ------------------------------------------------------------------


def test_elements_of_each_group_are_paired_in_order():
    """The last of an odd number is its own partner."""
    for seed in range(5):
        groups = np.random.default_rng(seed).integers(0, 6, 25)
        expected = np.arange(25)
        for group in range(6):
            some = np.flatnonzero(groups == group)
            one, other = some[: len(some) // 2 * 2].reshape(-1, 2).T
            expected[one], expected[other] = other, one
        np.testing.assert_array_equal(_half_edges._partners(groups), expected)


def test_elements_of_a_cycle_are_ranked_from_its_smallest():
    """Step by step along permutations with cycles of many lengths."""
    for seed in range(5):
        onward = np.random.default_rng(seed).permutation(30)
        label, rank = _half_edges._cycles(onward)
        for k in range(30):
            steps = [k]
            while onward[steps[-1]] != k:
                steps.append(int(onward[steps[-1]]))
            least = steps.index(min(steps))
            assert (label[k], rank[k]) == (min(steps), -least % len(steps))


def test_edges_are_the_different_pairs_of_ends_in_order():
    """Among them those of one triangle, and those of more than two."""
    for seed in range(5):
        rows = np.array([*itertools.combinations(range(7), 3)])
        rng = np.random.default_rng(seed)
        triangles = rng.permuted(rng.permutation(rows)[:14], axis=1)
        half_edges = HalfEdges(triangles, 7)
        count = Counter(e for t in triangles for e in edges_of(t))
        assert [*map(tuple, half_edges.edges.tolist())] == sorted(count)
        crowded = [e for e in sorted(count) if count[e] > 2]
        assert [*map(tuple, half_edges.nonmanifold_edges.tolist())] == crowded
        ends = zip(half_edges.start.tolist(), half_edges.end.tolist(), strict=True)
        single = [k for k, e in enumerate(ends) if count[min(e), max(e)] == 1]
        assert half_edges.free_sides.tolist() == single


def test_a_boundary_may_consist_of_one_side():
    """Of a triangle that stands in a double pyramid, between two edges of three triangles."""
    outside = [[0, 1, 3], [1, 2, 3], [2, 0, 3], [1, 0, 4], [2, 1, 4], [0, 2, 4]]
    half_edges = HalfEdges(np.array([*outside, [3, 4, 0]]), 5)
    assert [loop.tolist() for loop in half_edges.loop_sides] == [[18]]
    assert [loop.tolist() for loop in half_edges.boundary_loops] == [[3]]


def test_the_minority_of_each_patch_is_reversed_and_in_a_tie_those_unlike_the_first():
    """Two octahedra with a triangle apart, in any order, with any triangles turned over."""
    tops = np.array([[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2]])
    octahedron = np.concatenate([tops, np.where(tops == 2, 5, tops)[:, ::-1]])
    triangles = np.concatenate([octahedron, octahedron + 6, [[12, 13, 14]]])
    part = np.repeat([0, 1, 2], [8, 8, 1])
    for seed in range(40):
        rng = np.random.default_rng(seed)
        order = rng.permutation(17)
        turned = rng.random(17) < rng.random()
        given = np.where(turned[:, None], triangles[order][:, ::-1], triangles[order])
        expected = turned.copy()
        for k in range(3):
            some = part[order] == k
            half = 2 * turned[some].sum() - some.sum()
            if half > 0 or (half == 0 and turned[some][0]):
                expected[some] = ~turned[some]
        found, one_sided = inconsistently_oriented(HalfEdges(given, 15))
        np.testing.assert_array_equal(found, expected)
        assert not one_sided.any()


def found_inverted(*bodies):
    """Whether each body is found to be inside out, also if some triangles are to be reversed."""
    points, triangles = together(*bodies)
    half_edges = HalfEdges(triangles, len(points))
    found = inverted(points, half_edges, np.zeros(len(triangles), dtype=bool))
    turned = np.random.default_rng(0).random(len(triangles)) < 0.5
    some = HalfEdges(np.where(turned[:, None], triangles[:, ::-1], triangles), len(points))
    np.testing.assert_array_equal(inverted(points, some, turned), found)
    first = np.cumsum([0, *(len(t) for _, t in bodies)])
    assert all(len({*found[i:j]}) == 1 for i, j in itertools.pairwise(first))
    return found[first[:-1]].tolist()


def box(low, high):
    points, triangles = cube(1)
    return np.asarray(low) + points * np.subtract(high, low), triangles


def test_tiny_bodies_far_from_the_first_vertex_are_oriented():
    """Each by its own volume, which is a rounding error of volumes from the first vertex."""
    rng = np.random.default_rng(0)
    ways = rng.random(12) < 0.5
    bodies = [box(np.add(low, 2), np.add(low, 2 + 1e-7)) for low in 5 * rng.random((12, 3))]
    bodies = [turned_over(b) if way else b for b, way in zip(bodies, ways, strict=True)]
    assert found_inverted(box([0, 0, 0], [1, 1, 1]), *bodies) == [False, *ways]


@pytest.mark.parametrize("axes", [[0, 1, 2], [1, 2, 0], [2, 0, 1]])
def test_a_cavity_is_a_part_inside_an_odd_number_of_others(axes):
    """Long boxes one in another; not one that sticks out of another, or that touches its wall."""
    size = np.array([1.0, 3, 30])[axes]
    outer = box(-size, size)
    shells = [box(-size * k, size * k) for k in (1, 0.75, 0.5, 0.25)]
    beside = box(3 * size, 4 * size)
    ways = [False, True, False, True]
    right = [turned_over(s) if w else s for s, w in zip(shells, ways, strict=True)]
    assert found_inverted(*right, beside) == [False] * 5
    assert found_inverted(*shells, turned_over(beside)) == [*ways, True]
    for step in (*np.eye(3), *-np.eye(3)):
        through = box(-0.1 * size + size * step, 0.1 * size + size * step)
        assert found_inverted(outer, through) == [False, False]
        wall = box(-0.1 * size + 0.9 * size * step, 0.1 * size + 0.9 * size * step)
        assert found_inverted(outer, wall) == [False, False]


def test_a_cavity_below_another_part_of_its_body_is_inside_once():
    """In the tube of an upright ring: a line upward leaves the ring, and crosses it once more."""
    points, triangles = torus(19, 7)
    upright = points[:, [1, 2, 0]]
    cavity = turned_over(box([-0.05, -0.05, -1.05], [0.05, 0.05, -0.95]))
    hole = box([-0.05, -0.05, -0.05], [0.05, 0.05, 0.05])
    assert found_inverted((upright, triangles), cavity, hole) == [False, False, False]


def test_a_point_is_in_a_body_if_an_odd_number_of_triangles_is_above_it():
    """Also below edges and vertices, and on a face, which is not above it."""
    points, triangles = cube(2)
    grid = np.array([*itertools.product(np.arange(-1, 6) / 4, repeat=3)])
    level = (grid[:, 2] == 0) | (grid[:, 2] == 1)
    inside = ((grid > 0) & (grid < 1))[:, :2].all(axis=1) & (grid[:, 2] >= 0) & (grid[:, 2] < 1)
    walls = np.isin(grid[:, :2], (0, 1)).any(axis=1)
    for shear in ([[1, 0, 0], [0, 1, 0], [0, 0, 1]], [[3, 1, 0], [-1, 2, 0], [0, 0, 5]]):
        corners = (points @ shear)[triangles]
        p = (grid @ shear)[~walls]
        above = [_orientation._below(p, np.broadcast_to(c, (len(p), 3, 3))) for c in corners]
        np.testing.assert_array_equal(np.sum(above, axis=0) % 2 == 1, inside[~walls])
    assert (inside & level).any()
