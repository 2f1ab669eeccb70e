"""Write the sample files, and the submissions of the example class: python examples/make.py."""

import json
from pathlib import Path

import numpy as np

import fieldrecon as fr
from fieldgrade.authoring.sources import REGION, Source

HERE = Path(__file__).parent
SOURCE = Source(HERE.parent / "solutions" / "01_least_squares.py")
CLASS = HERE.parent / "src/fieldgrade/class_folder/example_class"
SHIFTED = """
def fit(points, values):
    matrix = basis_matrix(points)
    return np.linalg.lstsq(matrix, values + 1, rcond=None)[0]
"""
STUB = "def rank(points):\n    raise NotImplementedError\n"
SLOW = "while True:\n    pass\n"
WORDS = {
    "ada": "B has N rows and D + 1 columns, c has D + 1 entries, V has N, and BᵀB is square with "
    "D + 1 rows. The system is over-determined for N > D + 1 and under-determined for N < D + 1. "
    "Counting is not enough: a hundred points on one line of the plane give only rank 2.",
    "bob": "It is over-determined if there are more points than unknowns.",
}
"""Answers to question 01.7."""


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
    """Write the example class: right, one mistake, unfinished, endless, cut off."""
    needed = (c for c in SOURCE.cells if c.question or (c.is_setup and c.kind == "code"))
    right = [REGION.sub(r"\g<body>", cell.text + "\n").rstrip() for cell in needed]
    cells = {
        "ada": right,
        "bob": [*right, SHIFTED],
        "cai": [STUB if "def rank(" in text else text for text in right],
        "dan": [*right, SLOW],
        "eve": right,
    }
    for student, texts in cells.items():
        content = _notebook(texts, WORDS.get(student, ""))
        file = CLASS / "submissions" / student / f"{SOURCE.path.stem}.ipynb"
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(content[:-200] if student == "eve" else content, encoding="utf-8")


def _notebook(texts: list[str], words: str) -> str:
    code = {"cell_type": "code", "execution_count": None, "metadata": {}, "outputs": []}
    cells = [code | {"source": text} for text in texts]
    cells += [{"cell_type": "markdown", "metadata": {"answer": "01.7"}, "source": words}]
    content = {"cells": cells, "metadata": {}, "nbformat": 4, "nbformat_minor": 4}
    return json.dumps(content, indent=1, ensure_ascii=False) + "\n"


if __name__ == "__main__":
    heights()
    scan()
    damaged()
    submissions()
