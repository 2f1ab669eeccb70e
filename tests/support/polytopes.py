"""Convex polygons and polyhedra, and meshes with given Voronoi cells."""

from itertools import permutations, product

import numpy as np

from fieldrecon._core import validation as valid
from fieldrecon.barycentric.polytope import Polytope
from fieldrecon.barycentric.voronoi import VoronoiCell
from fieldrecon.meshes.simplex_mesh import SimplexMesh

SIGNS = np.array([*product((-1.0, 1.0), repeat=3)])
CUBE = np.array([*product((0.0, 1.0), repeat=3)])
OCTAHEDRON = np.vstack([np.eye(3), -np.eye(3)])
PYRAMID = np.array([[1, 1, 0], [1, -1, 0], [-1, -1, 0], [-1, 1, 0], [0, 0, 2]]) / 1.0
TETRAHEDRON = np.array([[0.0, 0, 0], [2, 0, 1], [0, 1, 0], [1, 1, 3]])
PRISM = np.array([[0, 0, 0], [2, 0, 0], [0, 1, 0], [0, 0, 1], [2, 0, 1], [0, 1, 1]]) / 1.0
# the Voronoi cell of the face-centred cubic lattice: six of its 14 corners have four faces
RHOMBIC_DODECAHEDRON = np.vstack([SIGNS, 2 * OCTAHEDRON])


def cyclic(a: float, b: float) -> np.ndarray:
    """(0, ±a, ±b) and its cyclic permutations."""
    rows = np.array([[0, s * a, t * b] for s in (-1, 1) for t in (-1, 1)])
    return np.vstack([np.roll(rows, k, axis=1) for k in range(3)])


GOLDEN = (1 + 5**0.5) / 2
DODECAHEDRON = np.vstack([SIGNS, cyclic(1 / GOLDEN, GOLDEN)])
ICOSAHEDRON = cyclic(1.0, GOLDEN)
# its pentagons are not regular, but its corners are binary fractions
PYRITOHEDRON = np.vstack([SIGNS, cyclic(0.75, 1.25)])

POLYHEDRA = {
    "tetrahedron": TETRAHEDRON,
    "cube": CUBE,
    "prism": PRISM,
    "square pyramid": PYRAMID,
    "octahedron": OCTAHEDRON,
    "icosahedron": ICOSAHEDRON,
    "dodecahedron": DODECAHEDRON,
    "pyritohedron": PYRITOHEDRON,
    "rhombic dodecahedron": RHOMBIC_DODECAHEDRON,
}


def regular(n: int) -> np.ndarray:
    """Regular polygon with n corners (n, 2) on the unit circle."""
    angle = 2 * np.pi * np.arange(n) / n
    return np.stack([np.cos(angle), np.sin(angle)], axis=1)


QUADRILATERAL = np.array([[-0.5, -0.25], [1.5, 0], [1.25, 1.25], [0, 1]])
HEXAGON = np.array([[0.5, -0.25], [1.125, 0], [1.25, 0.75], [0.625, 1.25], [-0.125, 1], [-0.25, 0]])


def sheared(corners: np.ndarray) -> np.ndarray:
    """The corners mapped to the unit cube by an affine map; all numbers are binary fractions."""
    shear = np.array([[0.5, 0.125, 0], [0, 0.625, 0.25], [0.125, 0, 0.75]])
    return corners @ shear + [0.5, 0.375, 0.5]


POLYTOPES = {
    "quadrilateral": QUADRILATERAL,
    "hexagon": HEXAGON[[3, 0, 4, 1, 5, 2]],
    "regular 20-gon": 0.5 + 0.75 * regular(20),
    "tetrahedron": sheared(TETRAHEDRON - [0.5, 0.5, 1]),
    "parallelepiped": sheared(2 * CUBE - 1),
    "octahedron": sheared(1.5 * OCTAHEDRON),
    "square pyramid": sheared(1.5 * PYRAMID - [0, 0, 1]),
    "pyritohedron": sheared(PYRITOHEDRON),
    "rhombic dodecahedron": sheared(RHOMBIC_DODECAHEDRON),
}


def star(corners) -> SimplexMesh:
    """The mesh around vertex 0, the mean of the corners, whose Voronoi cell has these corners.

    The other vertices are the reflections of the mean in the faces. Cell a has its circumcentre at
    corner a; a corner of more than three faces has several consecutive cells.
    """
    corners = valid.as_points(corners)
    cell = Polytope.of(corners)
    center = corners.mean(axis=0)
    base = corners[[face[0] for face in cell.faces]]
    unit = cell.normals / np.linalg.norm(cell.normals, axis=1)[:, None]
    reflected = center + 2 * ((base - center) * unit).sum(axis=1)[:, None] * unit
    cells = []
    for faces in cell.corner_faces:
        d = corners.shape[1]
        fans = [faces] if d == 2 else [faces[[0, k, k + 1]] for k in range(1, len(faces) - 1)]
        cells += [[0, *(fan + 1)] for fan in fans]
    return SimplexMesh(np.vstack([center, reflected]), cells)


def voronoi_cell(corners) -> VoronoiCell:
    """The Voronoi cell with these corners."""
    return VoronoiCell(star(corners), 0)


def kuhn(n: int, d: int) -> SimplexMesh:
    """The lattice {0 ... n - 1}^d with each cube cut into d! simplices along its diagonal."""
    points = np.array([*product(range(n), repeat=d)], dtype=float)
    powers = n ** np.arange(d)[::-1]
    cells = [
        np.cumsum([np.dot(corner, powers), *powers[list(order)]])
        for corner in product(range(n - 1), repeat=d)
        for order in permutations(range(d))
    ]
    return SimplexMesh(points, np.array(cells, dtype=int))
