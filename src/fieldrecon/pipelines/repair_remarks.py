"""Why errors of a mesh remain after a repair, and which option helps, in sentences."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np
from scipy.spatial import cKDTree

from fieldrecon._core.geometry import triangle_normals
from fieldrecon.triangles.audit import MeshAudit, in_words
from fieldrecon.triangles.half_edges import HalfEdges
from fieldrecon.triangles.holes import MAX_LOOP, minimum_area_patches, simple_loops

_CLOSE = 0.02  # distance of vertices that are probably one, as part of the median edge
_MARGIN = 1.5  # of the suggested tolerance over such distances
_LEAST_SHARE = 0.01  # of the vertices that have such a neighbour
_SHOWN = 5


def remarks(
    points: np.ndarray, triangles: np.ndarray, audit: MeshAudit, largest_hole: float
) -> Iterator[str]:
    """Yield for each kind of error that remains in a repaired mesh why it does.

    If a larger tolerance would merge many vertices, nothing else is said: it changes all the rest.
    """
    if tolerance := _tolerance_remark(points, triangles, audit):
        yield tolerance
        return
    if crossings := len(audit.crossings) + len(audit.overlaps):
        yield (
            f"{in_words('crossings', crossings)} of triangles {_remain(crossings)}: the mesh does "
            "not determine which of the surfaces that cross bounds the body. The command surface "
            "with the option polygons makes a closed surface around all triangles."
        )
    if count := len(audit.nonmanifold_edges):
        yield (
            f"{in_words('nonmanifold_edges', count)} {_remain(count)}: more than two surfaces meet "
            "there, and none of them is a small fin with a free edge."
        )
    yield from _hole_remarks(points, triangles, largest_hole)


def _tolerance_remark(p: np.ndarray, t: np.ndarray, audit: MeshAudit) -> str:
    """The tolerance that would merge vertices much nearer to each other than the edges, if any."""
    if audit.clean:
        return ""
    edge = float(np.median(np.linalg.norm(p[t] - p[np.roll(t, -1, axis=1)], axis=-1)))
    distance = cKDTree(p).query(p, [2])[0][:, 0]
    close = distance[(distance > audit.tolerance) & (distance < _CLOSE * edge)]
    if len(close) <= _LEAST_SHARE * len(p):
        return ""
    return (
        f"{len(close):,} vertices have another one within {close.max():.2g}, far less than the "
        f"median edge of {edge:.2g}: the option tolerance, with {_MARGIN * close.max():.2g}, "
        "merges them."
    )


def _hole_remarks(p: np.ndarray, t: np.ndarray, largest: float) -> Iterator[str]:
    """Yield why holes were not filled, by reason."""
    half_edges = HalfEdges(t, len(p))
    area = np.bincount(half_edges.parts, np.linalg.norm(triangle_normals(*p[t.T]), axis=1) / 2)
    long, wide, blocked = [], [], 0
    for sides in simple_loops(p, half_edges):
        if len(sides) > MAX_LOOP:
            long.append(len(sides))
            continue
        patch = minimum_area_patches(p[half_edges.start[sides]][None])[1][0]
        share = float(patch / area[half_edges.parts[sides // 3]].max())
        if share > largest:
            wide.append(share)
        else:
            blocked += 1
    if long:
        yield (
            f"{in_words('holes', len(long))} of {_listed(sorted(long))} edges "
            f"{_was(len(long))} not filled: a hole of more than {MAX_LOOP} edges may be meant, or "
            "have a shape that its boundary does not determine. The command surface closes them "
            "from the vertices."
        )
    if wide:
        yield (
            f"{in_words('holes', len(wide))} {_was(len(wide))} not filled, since the triangles "
            f"would have {_listed(f'{share:.2g}' for share in sorted(wide))} of the area around: "
            f"the option largest-hole, with {np.ceil(110 * max(wide)) / 100:.2f}, allows it."
        )
    if blocked:
        yield (
            f"{in_words('holes', blocked)} {_was(blocked)} not filled, since the triangles of "
            "least area would cross or touch others there."
        )


def _remain(count: int) -> str:
    return "remains" if count == 1 else "remain"


def _was(count: int) -> str:
    return "was" if count == 1 else "were"


def _listed(items: Iterable[object]) -> str:
    texts = [str(item) for item in items]
    return ", ".join([*texts[:_SHOWN], "…"] if len(texts) > _SHOWN else texts)
