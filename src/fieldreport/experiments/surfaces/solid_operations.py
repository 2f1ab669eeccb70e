"""Boolean operations and deformation of two reconstructed solids: a ball and a ring.

Their union, intersection, difference and blend are ray-traced, so that their edges are as sharp as
the pixels. The frames of the deformation are triangle meshes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure
from scipy.spatial.transform import Rotation

from fieldrecon.plotting.style import figure
from fieldrecon.solids.constructive import Solid, blend, morph, transform
from fieldrecon.solids.marching_cubes import extract_surface
from fieldrecon.solids.ray_casting import OUTSIDE, View, ray_traced
from fieldrecon.solids.shapes import Ball, Torus, sample_surface
from fieldrecon.surfaces.implicit_surfaces import implicit_surface
from fieldreport.framework.experiment import Result

BODIES = ("union", "intersection", "difference", "blend")
TIMES = (0.25, 0.5, 0.75)
"""Parameters of the frames of a deformation."""
TOWARD = np.array([0.55, -0.7, 0.55])
"""View direction of the solids."""
TILT, HANDLE = np.deg2rad(70), [0.65, 0.36, 0.35]
"""The ring is turned by this angle and shifted, so that it is a handle of the ball."""
SCENE = np.array([[-0.95, -0.95, -0.95], [1.6, 1.2, 1.4]])
"""Box around the ball and the ring."""
OF_RING = (0.86, 0.66, 0.32)
"""Colour of the ring: red, green and blue."""


def ball_and_ring(n: int, seed: int) -> tuple[Solid, Solid]:
    """Return a ball and a ring, each reconstructed from n points."""
    shapes = Ball(0.9), Torus(0.8, 0.3)
    ball, ring = (implicit_surface(sample_surface(s, n, seed)[0]) for s in shapes)
    return ball, ring


@dataclass(frozen=True, eq=False)
class Combination:
    """A body that is combined of a ball and a ring."""

    body: Solid
    ball: Solid
    ring: Solid

    def color(self, x: np.ndarray) -> np.ndarray:
        """Return the colour (k, 3) of the body to whose surface each point is nearer."""
        of_ball = np.abs(self.ball(x)) < np.abs(self.ring(x))
        return np.where(of_ball[:, None], OUTSIDE, OF_RING)

    def picture(self, pixels: int) -> np.ndarray:
        """Return a picture (rows, columns, 4) in bytes, whose edges are as sharp as its pixels."""
        view = View.of_box(SCENE, TOWARD, pixels)
        traced = ray_traced(self.body, view, 0.1, slope=1.5, color=self.color)
        return np.round(255 * traced).astype(np.uint8)


def combined(ball: Solid, ring: Solid) -> list[Combination]:
    """Return the union, intersection, difference and blend of a ball and a ring through it."""
    handle = transform(ring, upright(TILT), HANDLE)
    bodies = (ball | handle, ball & handle, ball - handle, blend(ball, handle, 0.3))
    return [Combination(body, ball, handle) for body in bodies]


def upright(angle: float) -> np.ndarray:
    """Return the rotation by an angle about the direction that points right in the pictures."""
    right = np.array([-TOWARD[1], TOWARD[0], 0.0]) / np.hypot(*TOWARD[:2])
    return np.asarray(Rotation.from_rotvec(angle * right).as_matrix())


def pictured(pixels: int, combination: Combination) -> np.ndarray:
    """Return the picture of a combination."""
    return combination.picture(pixels)


def deformed(first: Solid, last: Solid) -> dict[str, Solid]:
    """Return the frames of the deformation of one solid into another."""
    between = {f"t = {t:g}": morph(first, last, t) for t in TIMES}
    return {"t = 0": first, **between, "t = 1": last}


def framed(spacing: float, solid: Solid) -> tuple[np.ndarray, np.ndarray]:
    """Return the triangles of a solid."""
    surface = extract_surface(solid, spacing)
    return surface.points, surface.triangles


def plot_bodies(result: Result) -> Figure:
    """Two reconstructed solids, combined in four ways."""
    pictures = _trimmed(result.arrays["bodies"])
    with figure(height=1.45, columns=len(BODIES)) as (page, axes):
        for panel, name, picture in zip(axes, BODIES, pictures, strict=True):
            panel.set_title(name, loc="center", fontsize=8)
            panel.imshow(picture, interpolation="antialiased")
            panel.set_axis_off()
    return page


def _trimmed(pictures: np.ndarray) -> np.ndarray:
    """Return pictures without the margin that is transparent in all of them."""
    seen = np.any(pictures[..., 3] > 0, axis=0)
    rows, columns = (np.flatnonzero(np.any(seen, axis=axis)) for axis in (1, 0))
    return pictures[:, rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]
