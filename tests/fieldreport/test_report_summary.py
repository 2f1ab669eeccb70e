"""The summary of the report: its lines of code run, its map names every exercise of the slides."""

import re

import numpy as np
import pytest

import fieldrecon as fr
from report_fixtures import REPORT

SUMMARY = (REPORT / "chapters" / "00-summary.md").read_text("utf-8")
LINES = re.findall(r"`(fr\..*?)`", SUMMARY)


@pytest.fixture(scope="module")
def names():
    """What the text lets the letters of the code stand for, and data for the other names."""
    p = fr.datasets.halton(60, 2)
    mesh = fr.SimplexMesh.delaunay(p)
    angle = np.linspace(0, 2 * np.pi, 60, endpoint=False)
    heights = fr.datasets.halton(400, 2)[:, 0] * 2 - 1
    turns = np.arange(400) * np.pi * (3 - np.sqrt(5))
    radius = np.sqrt(1 - heights**2)
    sphere = np.stack([radius * np.cos(turns), radius * np.sin(turns), heights], axis=1)
    corners = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    return {
        "fr": fr,
        "p": p,
        "f": p.sum(axis=1),
        "x": fr.datasets.uniform(5, 2, seed=1),
        "h": 0.1,
        "s": 1e-3,
        "n": np.stack([np.cos(p[:, 0]), np.sin(p[:, 0])], axis=1),
        "g": np.cos(p[:, 0]) + np.sin(p[:, 0]),
        "method": fr.RBF(p, fr.polyharmonic(3)),
        "mesh": mesh,
        "v": fr.normal_velocities(mesh, mesh.points),
        "pressure": mesh.circumcenters.sum(axis=1),
        "inner": np.flatnonzero(~mesh.boundary_vertices),
        "corners": np.stack([np.cos(angle), np.sin(angle)], axis=1) * 2,
        "structure": sphere[::20],
        "skin": sphere * 1.1,
        "forces": np.ones((400, 3)),
        "velocity": lambda x, _: np.stack([-x[:, 1], x[:, 0]], axis=1),
        "times": [0.0, 0.1],
        "cloud": sphere,
        "normals": sphere,
        "points": np.array(corners, dtype=float),
        "cells": np.array([[0, 1, 2, 3]]),
        "triangles": np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]),
    }


@pytest.mark.parametrize(
    "line",
    [pytest.param(x, marks=pytest.mark.slow) if "surface" in x else x for x in LINES],
)
def test_the_code_of_the_summary_runs(line, names):
    """Each line is an expression of the names that the text explains, or of data for them."""
    assert eval(line, dict(names)) is not None


@pytest.mark.slow
def test_a_part_of_the_points_suffices_to_choose_the_smoothing():
    """The error with the smoothing chosen on a third of the points is near the least."""
    x, kernel = fr.datasets.halton(400, 2), fr.polyharmonic(3)
    values = 10.0 ** np.arange(-6, 2)

    def field(p):
        return np.sin(6 * p[:, 0]) * p[:, 1] + np.cos(9 * p[:, 1]) * p[:, 0]

    for seed in range(3):
        p = fr.datasets.uniform(900, 2, seed=seed)
        f = field(p) + 0.1 * np.random.default_rng(seed).standard_normal(900)
        loss = [
            np.mean(fr.leave_one_out(fr.RBF(p[:300], kernel, smoothing=s), f[:300]) ** 2)
            for s in values
        ]
        error = [
            np.sqrt(np.mean((fr.RBF(p, kernel, smoothing=s).field(f)(x) - field(x)) ** 2))
            for s in values
        ]
        assert error[np.argmin(loss)] < 1.6 * min(error)
        assert max(error) > 3 * min(error)


def test_the_summary_has_code_for_every_part_of_the_library():
    """A row each for derivatives, many variables, loads, advection, surfaces and meshes."""
    assert len(LINES) >= 18
    for name in ("HermiteRBF", "degree=1", "couple", "semi_lagrangian", "implicit_surface"):
        assert any(name in line for line in LINES)


def test_the_map_names_the_exercises_on_the_slides_and_no_others():
    """Every exercise that a chapter on the slides contains, except the report's own."""
    own = {"exr:gbc-simple", "exr:gbc-triangle", "exr:gradient-vertex"}
    chapters = [REPORT / "chapters" / name for name in CHAPTERS_ON_THE_SLIDES]
    posed = {e for c in chapters for e in re.findall(r"#(exr:[\w-]+)", c.read_text("utf-8"))}
    assert set(re.findall(r"\[@(exr:[\w-]+)\]\{\.with-page\}", SUMMARY)) == posed - own


CHAPTERS_ON_THE_SLIDES = (
    "11-least-squares.md",
    "12-moving-least-squares.md",
    "13-radial-basis-functions.md",
    "14-vertex-velocities.md",
    "15-cell-velocities.md",
    "16-pressure-gradients.md",
    "17-barycentric-coordinates.md",
    "18-voronoi-coordinates.md",
)
