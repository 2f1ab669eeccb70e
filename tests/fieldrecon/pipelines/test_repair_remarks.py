"""What remains after a repair is explained, and the option that is named helps."""

import re
from types import SimpleNamespace

import numpy as np
import pytest

from fieldrecon.pipelines import audit
from fieldrecon.pipelines.repair_remarks import _tolerance_remark
from fieldreport.experiments.triangles.triangle_shapes import sphere


def open_sphere(largest):
    """A sphere without the triangles around its highest vertices, up to a distance."""
    points, triangles = map(np.asarray, sphere(3))
    top = points[points[:, 2].argmax()]
    return points, triangles[np.linalg.norm(points[triangles].mean(axis=1) - top, axis=1) > largest]


def told(mesh, **options):
    return audit(mesh, repair=True, **options).remarks


def test_a_sound_mesh_has_no_remarks():
    assert told(sphere(1)) == ()


@pytest.mark.slow
def test_the_suggested_share_fills_a_wide_hole():
    mesh = open_sphere(0.5)
    (sentence,) = told(mesh, largest_hole=0.01)
    assert sentence.startswith("1 hole was not filled, since the triangles would have 0.0")
    share = float(re.search(r"largest-hole, with ([\d.]+),", sentence)[1])
    assert audit(mesh, repair=True, largest_hole=share).sound()


def open_cubes(count, sides=(4,)):
    """Cubes beside each other, the last of side 1, each without these of its six sides."""
    corners = np.array([(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
    quads = np.delete(np.array(QUADS) - 1, sides, axis=0)
    triangles = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    points = np.concatenate([(count - k) * corners + [9 * k, 0, 0] for k in range(count)])
    return points, np.concatenate([triangles + 8 * k for k in range(count)])


@pytest.mark.parametrize(
    ("count", "words"),
    [
        (1, "1 hole was not filled, since the triangles would have 0.2 of the area"),
        (5, "5 holes were not filled, since the triangles would have 0.2, 0.2, 0.2, 0.2, 0.2 of"),
        (
            6,
            "6 holes were not filled, since the triangles would have 0.2, 0.2, 0.2, 0.2, 0.2, … of",
        ),
    ],
)
def test_holes_are_compared_with_the_body_around_them(count, words):
    """The side of a cube has a fifth of the area of the others, however many cubes there are."""
    mesh = open_cubes(count)
    (sentence,) = told(mesh, largest_hole=0.19)
    assert sentence.startswith(words)
    share = float(re.search(r"largest-hole, with ([\d.]+),", sentence)[1])
    assert 0.2 < share <= 0.23
    assert audit(mesh, repair=True, largest_hole=share).sound()
    assert "0.25, 0.25 of" in told(open_cubes(1, sides=(4, 5)))[0]


@pytest.mark.parametrize("largest_hole", [1.0, 0.2])
def test_a_hole_that_something_stands_in_is_not_filled(largest_hole):
    """A tetrahedron reaches out of the open side of a cube: the triangles would cross it."""
    points, triangles = open_cubes(1)
    spike = np.array([[0.4, 0.4, -0.5], [0.5, 0.6, -0.5], [0.6, 0.4, -0.5], [0.5, 0.5, 0.5]])
    faces = np.array([(0, 1, 2), (1, 0, 3), (2, 1, 3), (0, 2, 3)])
    mesh = np.concatenate([points, spike]), np.concatenate([triangles, faces + len(points)])
    (sentence,) = told(mesh, largest_hole=largest_hole)
    assert sentence.startswith("1 hole was not filled, since the triangles of least area would cr")


def test_a_long_hole_is_named_with_its_edges():
    (sentence,) = told(open_sphere(1.2))
    edges = int(re.match(r"1 hole of (\d+) edges was not filled: a hole of more than", sentence)[1])
    assert edges > 32


def test_the_suggested_tolerance_merges_a_noisy_soup():
    points, triangles = map(np.asarray, sphere(2))
    corners = points[triangles].reshape(-1, 3)
    noisy = corners + 1e-5 * np.random.default_rng(0).standard_normal(corners.shape)
    mesh = noisy, np.arange(len(corners)).reshape(-1, 3)
    (sentence,) = told(mesh)
    tolerance = float(re.search(r"tolerance, with ([\d.e-]+),", sentence)[1])
    assert audit(mesh, repair=True, tolerance=tolerance).sound()


@pytest.mark.parametrize(
    ("pairs", "apart", "told"),
    [(2, 0.018, True), (1, 0.018, False), (2, 0.021, False), (2, 1e-7, False)],
)
def test_a_tolerance_is_suggested_for_a_hundredth_of_the_vertices(pairs, apart, told):
    """They are nearer to another one than a fiftieth of an edge, and farther than the tolerance."""
    corners = np.array([[0, 0, 0], [1, 0, 0], [0.5, 0.75**0.5, 0]])
    points = np.concatenate([np.add(corners, [3.0 * k, 0, 0]) for k in range(100)])
    points[3 : 3 + 3 * pairs : 3] = np.add(points[150 : 150 + 3 * pairs : 3], [0, 0, apart])
    errors = SimpleNamespace(clean=False, tolerance=1e-6)
    found = _tolerance_remark(points, np.arange(300).reshape(-1, 3), errors)
    assert found == told * (
        "4 vertices have another one within 0.018, far less than the median edge of 1: the option "
        "tolerance, with 0.027, merges them."
    )


@pytest.mark.slow
def test_crossing_copies_are_named_on_the_page(tmp_path):
    points, triangles = map(np.asarray, sphere(1))
    both = np.vstack([points, points + 0.3]), np.vstack([triangles, triangles + len(points)])
    found = audit(both, repair=True)
    (sentence,) = found.remarks
    assert sentence.startswith(f"{len(found.final.crossings)} crossings of triangles remain")
    assert sentence in found.report(tmp_path / "a.html").read_text(encoding="utf-8")


def test_one_edge_that_remains_is_counted_as_one():
    """The common edge of two tetrahedra, which is not a fin."""
    points = [(0, 0, 0), (0, 0, 1), (1, 0, 0), (0, 1, 0), (-1, 0, 0), (0, -1, 0)]
    first = [(2, 1, 0), (3, 2, 0), (1, 3, 0), (3, 1, 2)]
    second = [(4, 1, 0), (5, 4, 0), (1, 5, 0), (5, 1, 4)]
    (sentence,) = told((np.array(points, dtype=float), np.array([*first, *second])))
    assert sentence.startswith("1 nonmanifold edge remains: ")


QUADS = [(1, 2, 4, 3), (5, 7, 8, 6), (1, 5, 6, 2), (3, 4, 8, 7), (1, 3, 7, 5), (2, 6, 8, 4)]


@pytest.fixture
def textured(tmp_path):
    """A cube of six quads with more texture coordinates than vertices, as OBJ."""
    corners = [f"v {x} {y} {z}" for x in (0, 1) for y in (0, 1) for z in (0, 1)]
    texture = [f"vt {k / 14} 0.5" for k in range(14)] + ["vn 0 0 1"] * 6
    faces = [
        "f " + " ".join(f"{v}/{(k + i) % 14 + 1}/{i + 1}" for k, v in enumerate(quad))
        for i, quad in enumerate(QUADS)
    ]
    path = tmp_path / "cube.obj"
    path.write_text("\n".join([*corners, *texture, *faces]))
    return path


def test_quads_are_divided_on_request(textured):
    """Also of a textured OBJ; without the request the message names it."""
    with pytest.raises(
        ValueError, match=r"holds quad cells.*; the option triangulate divides them"
    ):
        audit(textured)
    found = audit(textured, triangulate=True)
    assert found.sound()
    assert (len(found.points), len(found.triangles)) == (8, 12)


def cone(edges):
    """A cone without its base, whose hole has so many edges."""
    angle = 2 * np.pi * np.arange(edges) / edges
    rim = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(edges)])
    ring = np.arange(edges)
    triangles = np.column_stack([ring, np.roll(ring, -1), np.full(edges, edges)])
    return np.vstack([rim, [[0, 0, 1.0]]]), triangles


def test_a_hole_of_32_edges_is_filled_and_longer_ones_are_counted():
    """However many there are; smaller ones are filled."""
    assert audit(cone(32), repair=True, largest_hole=1.0).sound()
    parts = [cone(edges) for edges in (33, 6, 40, 33)]
    starts = np.cumsum([0, *(len(points) for points, _ in parts)])
    mesh = (
        np.vstack([np.add(points, [4.0 * k, 0, 0]) for k, (points, _) in enumerate(parts)]),
        np.vstack([t + first for (_, t), first in zip(parts, starts, strict=False)]),
    )
    (sentence,) = told(mesh, largest_hole=1.0)
    assert re.match(r"3 holes of 33, (33, 40|40, 33) edges were not filled", sentence)
