"""Write the sample files of this folder anew: python examples/make.py."""

import json
from pathlib import Path

import numpy as np

import fieldrecon as fr
from fieldgrade.authoring.sources import Source

HERE = Path(__file__).parent
SOURCE = Source(HERE.parent / "solutions" / "01_least_squares.py")
SHIFTED = """
def fit(points, values):
    matrix = basis_matrix(points)
    return np.linalg.lstsq(matrix, values + 1, rcond=None)[0]
"""
STUB = "def rank(points):\n    raise NotImplementedError\n"
SLOW = "while True:\n    pass\n"


def heights(count: int = 600) -> None:
    """Write heights of the terrain at scattered points, in metres east and north."""
    land = fr.datasets.terrain()
    x, y = land.x, land.y
    at = fr.datasets.uniform(count, 2, seed=1)
    columns, rows = (at * [len(x) - 1, len(y) - 1]).round().astype(int).T
    table = np.column_stack([x[columns], y[rows], land.height[rows, columns]])
    header = "east [m],north [m],height [m]"
    np.savetxt(HERE / "heights.csv", table, fmt="%.1f", delimiter=",", header=header, comments="")


def scan(count: int = 3000) -> None:
    """Write points on a torus as a scanner takes them, with noise, and without normals."""
    points, normals = fr.solids.sample_surface(fr.solids.Torus(1.0, 0.4), count, seed=2)
    noisy = fr.solids.roughened(points, normals, 0.003, seed=3)
    np.savetxt(HERE / "scan.xyz", noisy, fmt="%.5f", header="x y z", comments="")


def damaged() -> None:
    """Write a box with a hole, a face turned over and a face given twice."""
    corners = np.array([[i, j, k] for i in (0, 1) for j in (0, 1) for k in (0, 1)], float)
    quads = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
    faces = [[[a, b, c], [a, c, d]] for a, b, c, d in quads]
    triangles = np.concatenate(faces)
    triangles[0] = triangles[0, ::-1]
    fr.io.write_triangles(
        HERE / "damaged.stl", corners, np.concatenate([triangles[:-1], triangles[3:4]])
    )


def submissions() -> None:
    """Write what five students submit: right, one mistake, unfinished, endless, cut off."""
    right = [c.text for c in SOURCE.cells if c.question or (c.is_setup and c.kind == "code")]
    cells = {
        "ada": right,
        "bob": [*right, SHIFTED],
        "cai": [*right, STUB],
        "dan": [*right, SLOW],
        "eve": right,
    }
    for student, texts in cells.items():
        content = _notebook(texts)
        file = HERE / "submissions" / student / f"{SOURCE.path.stem}.ipynb"
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(content[:-200] if student == "eve" else content, encoding="utf-8")
    (HERE / "class").mkdir(exist_ok=True)
    lines = "".join(f"{student},{student}@uni.example\n" for student in cells)
    (HERE / "class" / "roster.csv").write_text("student,email\n" + lines, encoding="utf-8")


def _notebook(texts: list[str]) -> str:
    cells = [
        {"cell_type": "code", "execution_count": None, "metadata": {}, "outputs": [], "source": t}
        for t in texts
    ]
    content = {"cells": cells, "metadata": {}, "nbformat": 4, "nbformat_minor": 4}
    return json.dumps(content, indent=1, ensure_ascii=False) + "\n"


if __name__ == "__main__":
    heights()
    scan()
    damaged()
    submissions()
